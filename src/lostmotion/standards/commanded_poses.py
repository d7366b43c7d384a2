"""Poses that a measured robot was sent to, and the arm in them: where robots are predicted for
comparison.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.poses import sample_poses
from lostmotion.errors import InputError, Problem, shown
from lostmotion.io.limits import cut
from lostmotion.mechanism.inverse import inverse_kinematics
from lostmotion.mechanism.state import state_of, tool_points
from lostmotion.propagation.iso9283.cube import (
    FULL,
    INWARD,
    MOST_POSES,
    NAMES,
    SAMPLES,
    STARTS,
    CommandedPoses,
    candidate_rotations,
    cube_from_arguments,
    cube_in_reach,
    five_points,
    orientation_clause,
    out_of_reach,
)
from lostmotion.propagation.iso9283.largest_cube import largest_cube
from lostmotion.standards.measured_paths import MIN_COMMANDS, path_ends

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.io.measured.visits import Visits
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.iso9283.cube import Cube
    from lostmotion.spatial import Floats

# Commanded positions that differ by less are equal, m.
SAME: Final = 1e-3
_MOST_NAMED: Final = 5
_LONGEST_NAME: Final = 40


def cube_of(
    arm: Arm,
    stated: tuple[Floats, float] | None,
    rotation: Floats | None,
    floor: float | None,
    visits: Visits | None,
    progress: Callable[[str, int, int], None] | None,
) -> Cube:
    """Return the test cube: the one with the stated centre and side, m, else that of the measured
    commands, else the largest found above the floor; `rotation` (3, 3) of the tool where stated.
    """
    if stated is not None:
        return cube_from_arguments(arm, *stated, rotation)
    commanded = None if visits is None else commanded_cube(visits)
    if visits is None or commanded is None:
        return largest_cube(arm, rotation, floor, progress=progress)
    centre, side, turned = commanded
    if rotation is None and len(arm.tree.tool_joints) >= FULL:
        rotation = turned
    cube = cube_in_reach(arm, centre, side, rotation)
    if cube is None:
        raise _unreachable_command(arm, visits, centre, side, rotation)
    return cube


def commanded_cube(visits: Visits) -> tuple[Floats, float, Floats | None] | None:
    """Return centre, side (m) and tool rotation (None if unknown) of the cube of the commanded P1
    to P5; None where they are not poses of a cube.
    """
    at = {name: k for k, name in reversed(list(enumerate(visits.pose)))}
    known = {**visits.known} | {
        name: visits.commanded_pose(at[name]) for name in NAMES if name in at
    }
    if not set(NAMES) <= set(known):
        return None
    points = np.stack([known[name][:3, 3] for name in NAMES])
    if not np.isfinite(points).all():
        return None
    side = float(np.linalg.norm(points[3] - points[1])) / (INWARD * math.sqrt(3))
    if np.linalg.norm(points - five_points(points[0], side), axis=1).max() > SAME:
        return None
    rotation = known[NAMES[0]][:3, :3]
    return points[0], side, rotation if np.isfinite(rotation).all() else None


def _unreachable_command(
    arm: Arm, visits: Visits, centre: Floats, side: float, rotation: Floats | None
) -> InputError:
    """Return the error for commanded P1 to P5, of a cube with this centre and side (m), that the
    arm cannot reach.
    """
    at = next((k for k, name in enumerate(visits.pose) if name in NAMES), 0)
    points = five_points(centre, side)
    beyond = np.flatnonzero(out_of_reach(arm, points, rotation))
    named = [f"{NAMES[k]} at ({', '.join(f'{x * 1e3:.0f}' for x in points[k])}) mm" for k in beyond]
    place = (
        f"a cube of {side * 1e3:.0f} mm about ({', '.join(f'{x * 1e3:.0f}' for x in centre)}) mm"
    )
    found = (
        f"{', '.join(named)}, out of reach of {arm.name}"
        if named
        else f"on {place}, part of which {arm.name} cannot reach"
    )
    expected = (
        "commands in the arm's base frame, on a cube that it reaches "
        f"entirely{orientation_clause(arm)}"
    )
    alone = (
        f"lostmotion iso9283 --measured {visits.where[at][0]}, to evaluate the measured robot alone"
    )
    return InputError(
        [Problem(visits.where[at][0], "commanded positions of P1 to P5", found, expected, alone)]
    )


def poses_of_cube(centre: Floats, side: float, rotation: Floats | None) -> dict[str, Floats]:
    """Return P1 to P5 (4, 4) by name for a cube with this centre (3,) and side in m; rotation NaN
    where none is stated.
    """
    out = {}
    for name, point in zip(NAMES, five_points(np.asarray(centre, dtype=float), side), strict=True):
        out[name] = np.eye(4)
        out[name][:3, 3], out[name][:3, :3] = point, math.nan if rotation is None else rotation
    return out


def refuse_missing_commands(visits: Visits) -> None:
    """Raise InputError where commands of P1 to P5 or of a path are missing: the cube found by a
    search need not be where the robot was sent.
    """
    commanded = np.asarray(np.isfinite(visits.command).all(axis=1))
    lines = {
        path for path in dict.fromkeys(visits.path) if path and _no_line(visits, path, commanded)
    }
    missing: dict[str, list[int]] = {}
    for k, (pose, path) in enumerate(zip(visits.pose, visits.path, strict=True)):
        if path in lines or (pose in NAMES and not commanded[k]):
            missing.setdefault(visits.where[k][0], []).append(k)
    mistakes = []
    for file, rows in missing.items():
        poses = ", ".join(sorted({visits.pose[k] for k in rows} - {""}))
        paths = ", ".join(
            shown(path) for path in dict.fromkeys(visits.path[k] for k in rows) if path
        )
        named = " and ".join(
            ([f"poses {poses}"] if poses else [])
            + ([f"readings along path {paths}"] if paths else [])
        )
        mistakes.append(
            Problem(
                file,
                f"{len(rows)} row{'s' * (len(rows) > 1)}, from line {visits.where[rows[0]][1]}",
                f"{named} without commanded positions",
                (
                    "xc, yc, zc in the rows, a file of commands, or the cube that was commanded "
                    "(the cube found by a search may be another one)"
                ),
                '--cube "400 mm" --centre "600 mm, 0 mm, 400 mm"',
            )
        )
    if mistakes:
        raise InputError(mistakes)


def _no_line(visits: Visits, path: str, commanded: np.ndarray) -> bool:
    """Return whether neither a path's name nor its rows define the commanded line."""
    rows = np.array([each == path for each in visits.path])
    return (
        path_ends(path, visits.known) is None
        and int(np.count_nonzero(rows & commanded)) < MIN_COMMANDS
    )


def commanded_poses(arm: Arm, visits: Visits) -> CommandedPoses | None:
    """Return the commanded poses of a file with joint values of the arm; None where the file
    commands none.

    With six joints or more the tool has the commanded orientation, or where none is commanded the
    first of downward, forward and that in the middle of the joint ranges that all poses allow.
    Joint values continue from pose to pose where they can. Raises InputError where a pose is out of
    reach.
    """
    first = {
        name: k
        for k, name in reversed(list(enumerate(visits.pose)))
        if name and np.isfinite(visits.command[k]).all()
    }
    names = [name for name in dict.fromkeys(visits.pose) if name in first]
    if not names:
        return None
    kept = (
        [
            names[k]
            for k in np.unique(np.linspace(0, len(names) - 1, MOST_POSES).round().astype(int))
        ]
        if len(names) > MOST_POSES
        else names
    )
    wanted = np.stack([visits.commanded_pose(first[name]) for name in kept])
    turned = bool(np.isfinite(wanted).all()) and len(arm.tree.tool_joints) >= FULL
    cloud = sample_poses(arm, SAMPLES).q
    places = tool_points(arm, cloud)
    missed: list[int] = []
    for rotation in [None] if turned else candidate_rotations(arm, None):
        if not turned:
            wanted[:, :3, :3] = np.eye(3) if rotation is None else rotation
        q, missed = _reached(
            arm, wanted, cloud, places, with_orientation=turned or rotation is not None
        )
        if not missed:
            return CommandedPoses(
                tuple(kept), q, state_of(arm, q).frames[-1], rotation, len(names) - len(kept)
            )
    k = first[kept[missed[0]]]
    named = ", ".join(
        (
            f"{cut(kept[k], _LONGEST_NAME)} at "
            f"({', '.join(f'{x * 1e3:.0f}' for x in wanted[k, :3, 3])}) mm"
        )
        for k in missed[:_MOST_NAMED]
    )
    more = f" and {len(missed) - _MOST_NAMED} more" if len(missed) > _MOST_NAMED else ""
    expected = f"commands in the arm's base frame, that it reaches{orientation_clause(arm)}"
    alone = (
        f"lostmotion iso9283 --measured {visits.where[k][0]}, to evaluate the measured robot alone"
    )
    raise InputError(
        [
            Problem(
                visits.where[k][0],
                "commanded positions",
                f"{named}{more}, out of reach of {arm.name}",
                expected,
                alone,
            )
        ]
    )


def _reached(
    arm: Arm, wanted: Floats, cloud: Floats, places: Floats, *, with_orientation: bool
) -> tuple[Floats, list[int]]:
    """Return joint values (pose, joint) that continue from pose to pose where they can, and the
    poses that were not reached.
    """
    q = np.empty((len(wanted), cloud.shape[1]))
    missed: list[int] = []
    before: Floats | None = None
    for k, pose in enumerate(wanted):
        starts = cloud[np.argsort(np.linalg.norm(places - pose[:3, 3], axis=1))[:STARTS]]
        if before is not None:
            starts = np.vstack([before, starts])
        found, reached = inverse_kinematics(
            arm, np.tile(pose, (len(starts), 1, 1)), starts, with_orientation=with_orientation
        )
        if not reached.any():
            missed.append(k)
            continue
        q[k] = before = found[int(np.argmax(reached))]
    return q, missed
