"""Selection of poses: one by its number, or those with the tool in a zone."""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Integral
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.error_model.poses import Poses, sample_poses
from lostmotion.errors import InputError, Problem, refuse_argument, shown
from lostmotion.mechanism.state import tool_points

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.error_model.poses import PoseLaw
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_AXES = "xyz"
_EXAMPLE = "x 0.2..0.5 m"
# Largest number of poses among which those in a zone are searched.
MOST_TRIED: Final = 1 << 19


@dataclass(frozen=True, slots=True)
class InZone:
    """Poses with the tool in a zone.

    name   name of the zone, for tables
    poses  the poses in it
    tried  number of poses among which they were found
    """

    name: str
    poses: Poses
    tried: int


def one_pose(q: Floats, pose: Any) -> tuple[Floats, str]:  # noqa: ANN401 - a number, or joint values
    """Return the joint values (1, joint; rad or m) of one pose, and its name.

    q     (pose, joint) rad or m
    pose  number of a row of q from 0, or joint values (joint,) or (1, joint)

    Raises InputError for a number that does not exist, or for values of another shape or not
    finite.
    """
    if isinstance(pose, Integral):
        if not 0 <= int(pose) < len(q):
            raise refuse_argument("at", pose, f"a number from 0 to {len(q) - 1}", at=0)
        return q[[int(pose)]], f"pose {pose}"
    values = np.atleast_2d(np.asarray(pose, dtype=float))
    if values.shape != (1, q.shape[1]) or not np.isfinite(values).all():
        raise refuse_argument(
            "at",
            f"values of shape {np.shape(pose)}",
            f"{q.shape[1]} finite joint values in rad and m, or a number",
            at=0,
        )
    return values, "the pose asked for"


def in_zone(tool: Floats, zone: Any) -> tuple[np.ndarray, str]:  # noqa: ANN401 - a mask, or ends by axis
    """Return a mask (pose,) of the poses with the tool point in a zone, and the name of the zone.

    tool  (pose, 3) tool points in the base's frame, m
    zone  such a mask itself, or limits along one or more of the base's axes, {"x": (0.2, 0.5)} in m

    Raises InputError for an invalid zone, or one without a pose.
    """
    if hasattr(zone, "items"):
        mask, name = _in_box(tool, zone)
    else:
        mask = np.asarray(zone)
        if mask.shape != (len(tool),) or mask.dtype != bool:
            raise refuse_argument(
                "zone",
                f"an array of {mask.dtype} of shape {mask.shape}",
                f"a truth value for each of the {len(tool)} poses",
                zone=_EXAMPLE,
            )
        name = "the zone asked for"
    if not mask.any():
        raise _nowhere(name, zone, tool)
    return mask, name


def among(poses: Poses, tool: Floats, zone: Any) -> InZone:  # noqa: ANN401 - a mask, or ends by axis
    """Return those of these poses with the tool in a zone, in independent sets of equal size (see
    `_in_equal_sets`).

    Arguments and errors as `in_zone`. Also raises InputError where only one of several sampled
    poses is in the zone, which is too few for a study.
    """
    mask, name = in_zone(tool, zone)
    return InZone(name, _in_equal_sets(poses, mask, name, tool), len(poses))


def poses_in_zone(
    arm: Arm,
    count: int,
    zone: Mapping[str, tuple[float, float]],
    seed: int = 1,
    law: PoseLaw = "sobol",
) -> InZone:
    """Return `count` poses of a pose law with the tool in a zone, given by limits (m) along axes of
    the base.

    The independent sets of the law are extended until each contains enough poses in the zone; the
    first of these are returned. They have the distribution of the law on condition that the tool is
    in the zone. For a zone that contains the whole workspace they are the poses of `sample_poses`.
    For a small zone, fewer poses are returned: those of 524 288 (2^19) that are in it. Raises
    InputError where none is, or only one.
    """
    tries = [
        count,
        *(tried for tried in (8 * count, 64 * count) if tried < MOST_TRIED),
        *([MOST_TRIED] if count < MOST_TRIED else []),
    ]
    for tried in tries:
        sampled = sample_poses(arm, tried, law, seed)
        tool = tool_points(arm, sampled.q)
        mask, name = _in_box(tool, zone)
        of_sets = mask.reshape(sampled.replicates, -1)
        each = -(-count // len(of_sets))
        if of_sets.sum(axis=1).min() >= each:
            first = np.concatenate(
                [
                    np.flatnonzero(inside)[:each] + k * of_sets.shape[1]
                    for k, inside in enumerate(of_sets)
                ]
            )
            return InZone(name, Poses(sampled.q[first], law, len(of_sets)), len(sampled))
    if not mask.any():
        raise _nowhere(name, zone, tool)
    return InZone(name, _in_equal_sets(sampled, mask, name, tool, count), len(sampled))


def _in_equal_sets(
    poses: Poses, mask: np.ndarray, name: str, tool: Floats, most: int = 1 << 62
) -> Poses:
    """Return the poses in a mask, divided in order into sets of equal size; the few left over at
    the end are dropped.

    There are as many sets as before, or as many as poses if these are fewer; each set is shortened
    so that all have about `most` poses together. The original sets have different numbers of poses
    in the mask, so a new set may take poses from the next original one. With so few poses of a
    sequence these are nearly independent samples.
    """
    inside = np.flatnonzero(mask)
    if poses.replicates == 1:
        return Poses(poses.q[inside], poses.law)
    if len(inside) == 1:
        raise _refused(
            f"{name}: only 1 of the {len(mask)} poses is in it",
            "a zone that more poses reach",
            tool,
        )
    sets = min(poses.replicates, len(inside))
    each = min(len(inside) // sets, -(-most // sets))
    return Poses(
        poses.q[inside[: len(inside) // sets * sets].reshape(sets, -1)[:, :each].ravel()],
        poses.law,
        sets,
    )


def _nowhere(name: str, zone: Any, tool: Floats) -> InputError:  # noqa: ANN401 - a mask, or ends by axis
    """Refuse a zone without a pose; one within the region that the tool reaches may just be too
    small to contain a sample.
    """
    ends = checked_ends(zone).items() if hasattr(zone, "items") else ()
    along = [(tool[:, _AXES.index(axis)], low, high) for axis, (low, high) in ends]
    within = bool(along) and all(
        low <= reached.max() and high >= reached.min() for reached, low, high in along
    )
    expected = (
        "a larger zone, because this one may be reached but is too small to contain a sampled pose"
        if within
        else "a zone that some poses reach"
    )
    return _refused(f"{name}: none of the {len(tool)} poses is in it", expected, tool)


def _refused(found: str, expected: str, tool: Floats) -> InputError:
    """Refuse a zone and report the region that the tool reaches. The name of the zone is text of
    this module and is not shortened.
    """
    low, high = tool.min(axis=0), tool.max(axis=0)
    reached = ", ".join(
        f"{axis} {a:.3f}..{b:.3f} m" for axis, a, b in zip(_AXES, low, high, strict=True)
    )
    return InputError(
        [
            Problem(
                "",
                "zone",
                found,
                f"{expected}; the tool reaches {reached}",
                passing=(("zone", _EXAMPLE),),
            )
        ]
    )


def _in_box(tool: Floats, ends: Mapping[str, tuple[float, float]]) -> tuple[np.ndarray, str]:
    mask = np.ones(len(tool), dtype=bool)
    limits = []
    for axis, (low, high) in checked_ends(ends).items():
        along = tool[:, _AXES.index(axis)]
        mask &= (along >= low) & (along <= high)
        limits.append(f"{axis} {low * 1e3:g} … {high * 1e3:g} mm")
    return mask, ", ".join(limits)


def checked_ends(ends: Mapping[Any, Any]) -> dict[str, tuple[float, float]]:
    """Return the limits (m) of a zone along each axis of the base that it names. Raises InputError
    with every mistake in them.
    """
    expected = "limits along x, y or z in m, the lower one first"
    mistakes: list[Problem] = []
    out: dict[str, tuple[float, float]] = {}
    for axis, pair in ends.items():
        try:
            low, high = (math.nan if isinstance(end, str) else float(end) for end in pair)
        except (TypeError, ValueError):
            low = high = math.nan
        if (
            not (isinstance(axis, str) and axis in set(_AXES))
            or not (math.isfinite(low) and math.isfinite(high))
            or low > high
        ):
            mistakes.append(
                Problem(
                    "",
                    "zone",
                    shown(f"{axis}: {pair}")[1:-1],
                    expected,
                    passing=(("zone", _EXAMPLE),),
                )
            )
        out[axis] = (low, high)
    if mistakes or not out:
        raise InputError(
            mistakes or [Problem("", "zone", "no limits", expected, passing=(("zone", _EXAMPLE),))]
        )
    return out
