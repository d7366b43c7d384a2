"""Poses of a closed chain with the tool in a stated box: drives by inverse kinematics from home."""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.closed_arrays import MET, NOT_ASSEMBLED, SINGULAR
from lostmotion.mechanism.closed_chain import Mistake, home_frames
from lostmotion.mechanism.closed_home import home_of
from lostmotion.mechanism.closed_inverse import OUT_OF_RANGE, reached_from_home
from lostmotion.mechanism.closed_jacobian import motion_units
from lostmotion.mechanism.closed_position import LIMITED, MOST_GAIN, NEAR_SINGULAR, assemble
from lostmotion.mechanism.holding import spread_evenly

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.mechanism.places import Tree
    from lostmotion.mechanism.workspace_box import WorkspaceBox
    from lostmotion.spatial import Floats

# Components that the drives move less than this share of the largest are not controlled.
_CONTROLLED: Final = 1e-4
_EXAMPLE: Final = 'x = ["-50 mm", "50 mm"]'
_REASONS: Final = {
    OUT_OF_RANGE: "a drive outside its limits",
    NOT_ASSEMBLED: "not reached",
    SINGULAR: "beyond a parallel singularity",
    LIMITED: "a passive joint outside its limits",
    NEAR_SINGULAR: (f"near a parallel singularity (gain above {MOST_GAIN:g} times that at home)"),
}


def controlled(tree: Tree, first: tuple[int, ...]) -> list[int]:
    """Return the components of the tool's twist that the drives control at home: these `first`,
    then positions and rotations as far as they are independent of them.
    """
    columns = assemble(tree, np.array(tree.home)[None]).columns[0] * motion_units(tree, tree.moved)
    rows: list[int] = []
    for k in dict.fromkeys((*first, 3, 4, 5, 0, 1, 2)):
        values = np.linalg.svd(columns[[*rows, k]], compute_uv=False)
        whole = len(rows) < len(tree.moved) and len(values) == len(rows) + 1
        if whole and values[-1] > _CONTROLLED * np.abs(columns).max():
            rows.append(k)
    return rows


def box_error(tree: Tree, box: WorkspaceBox) -> Mistake | None:
    """Return the mistake in the box of a chain's tool; None without one."""
    path, stated = ("workspace",), list(box.stated)
    if not tree.welds:
        return Mistake(
            path,
            "a box of the tool of an arm without closures",
            "limits of its joints, and --zone for a part of its workspace",
            'limits = ["-90 deg", "90 deg"]',
        )
    if not stated:
        return Mistake(path, "a box without limits", "limits of x, y or z", _EXAMPLE)
    rows = controlled(tree, tuple(stated))
    strange = [k for k in stated if k not in rows]
    if strange:
        return Mistake(
            path,
            f"limits of {box.names(strange)}, which the {len(tree.moved)} drives do not control "
            "independently",
            f"limits of {box.names(rows)}",
            _EXAMPLE,
        )
    if len(rows) < len(tree.moved):
        return Mistake(
            path,
            f"a box for {len(tree.moved)} drives that control {len(rows)} components of the tool",
            "limits of the drives alone: a pose of the tool does not decide where they stand",
            'limits = ["-90 deg", "90 deg"]',
        )
    turns = [max(map(abs, limits)) for k, limits in box.stated.items() if k < 3]  # noqa: PLR2004
    if math.hypot(*turns) >= math.pi:
        return Mistake(
            path,
            "rotations from home of half a turn",
            "less than half a turn",
            'rz = ["-20 deg", "20 deg"]',
        )
    return None


def drives_in_box(
    tree: Tree, limits: Floats, box: WorkspaceBox, values: Floats
) -> tuple[Floats, NDArray[np.int64]]:
    """Return the drives (pose, drive), rad or m, for poses of the tool at values (pose, component)
    of a box, and why each is excluded (pose,), as `reached_from_home`.

    limits  (drive, 2) of the drives, rad or m
    """
    wanted = box.poses_at(values, home_frames(tree)[-1, 0])
    return reached_from_home(tree, limits, wanted, _rows(tree, tuple(box.stated)), MET)


@functools.lru_cache(maxsize=32)
def _rows(tree: Tree, stated: tuple[int, ...]) -> NDArray[np.int64]:
    return np.array(sorted(controlled(tree, stated)))


def excluded(tree: Tree, limits: Floats, box: WorkspaceBox | None) -> str:
    """Return which share of the poses of a closed chain is excluded, and why, of 256 spread evenly
    between the limits of the drives (drive, 2), rad or m, or in the box of the tool.
    """
    if box is None:
        q = spread_evenly(limits)
        where, found = "of the drives", assemble(tree, q).problem
        within, reasons = "between their limits", {**_REASONS, NOT_ASSEMBLED: "not assembled"}
    else:
        q = spread_evenly(box.ranges)
        where, found = "of the tool", drives_in_box(tree, limits, box, q)[1]
        within, reasons = "in its box", _REASONS
    shares = {text: float((found == problem).mean()) for problem, text in reasons.items()}
    listed = [f"{100 * share:.3g} % {text}" for text, share in shares.items() if share]
    return f"poses {where} excluded, of {len(q)} spread evenly {within}: " + (
        ", ".join(listed) or "none"
    )


def closed_remarks(tree: Tree, limits: Floats, box: WorkspaceBox | None) -> tuple[str, ...]:
    """Return remarks on a closed chain: its freedoms and constraints, and how many of the poses
    between the limits of its drives (drive, 2), rad or m, or in the box of its tool are excluded,
    and why; none for an arm without closures.
    """
    if not tree.welds:
        return ()
    home = home_of(tree)
    freedoms, drives = home.jacobian.shape[2] + len(tree.moved), len(tree.moved)
    redundant = home.jacobian.shape[1] - home.rank
    idle = f" and {home.idle} idle, which leave the tool still" if home.idle else ""
    counted = (
        f"closed chain: {freedoms} freedoms - rank {home.rank} of {len(tree.welds)} closures = "
        f"{freedoms - home.rank}, of {drives} drives{idle}; "
        + (f"over-constrained {redundant} times" if redundant else "exactly constrained")
    )
    return (
        counted,
        excluded(tree, limits, box)
        + ". Not counted: friction of passive joints, and legs that touch each other",
        "loads of a closed chain act in its undeflected shape: deflections are of first order",
    )
