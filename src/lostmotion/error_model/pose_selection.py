"""Selection of a study's poses by a number or by a zone in space."""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Integral
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.error_model.poses import Poses, sample_poses
from lostmotion.errors import InputError, Problem, refuse_argument, shown
from lostmotion.mechanism.serial import tool_points

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.error_model.poses import PoseLaw
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_AXES = "xyz"
_EXAMPLE = "x 0.2..0.5 m"
# So many poses are tried to find those in a zone.
MOST_TRIED: Final = 1 << 19


@dataclass(frozen=True, slots=True)
class InZone:
    """The poses that bring the tool into a zone, what the zone is called, and among how many poses of their law they were found."""

    name: str
    poses: Poses
    tried: int


def one_pose(q: Floats, pose: Any) -> tuple[Floats, str]:  # noqa: ANN401 - a number, or joint values
    """Return the joint values (1, joint) of a pose's number among q (pose, joint), or of an array of one pose, and its name.

    Raises InputError for a number that there is not, or values of another shape or not finite.
    """
    if isinstance(pose, Integral):
        if not 0 <= int(pose) < len(q):
            raise refuse_argument("at", pose, f"a number from 0 to {len(q) - 1}", at=0)
        return q[[int(pose)]], f"pose {pose}"
    values = np.atleast_2d(np.asarray(pose, dtype=float))
    if values.shape != (1, q.shape[1]) or not np.isfinite(values).all():
        raise refuse_argument("at", f"values of shape {np.shape(pose)}", f"{q.shape[1]} finite joint values in rad and m, or a number", at=0)
    return values, "the pose asked for"


def in_zone(tool: Floats, zone: Any) -> tuple[np.ndarray, str]:  # noqa: ANN401 - a mask, or ends by axis
    """Return which poses (pose,) have their tool point, (pose, 3) m, in this zone, and its name.

    `zone` is that mask itself, or the ends along some of the base's axes, {"x": (0.2, 0.5)} in m. Raises InputError where no pose lies in it.
    """
    if hasattr(zone, "items"):
        mask, name = _in_box(tool, zone)
    else:
        mask = np.asarray(zone)
        if mask.shape != (len(tool),) or mask.dtype != bool:
            raise refuse_argument(
                "zone", f"an array of {mask.dtype} of shape {mask.shape}", f"a truth value for each of the {len(tool)} poses", zone=_EXAMPLE
            )
        name = "the zone asked for"
    if not mask.any():
        raise _nowhere(name, zone, tool)
    return mask, name


def among(poses: Poses, tool: Floats, zone: Any) -> InZone:  # noqa: ANN401 - a mask, or ends by axis
    """Return those poses with the tool, (pose, 3) m, in a zone, in as many independent sets of equal size (`_dealt`).

    Raises InputError as `in_zone`, and where only one of poses that were drawn does: that says nothing of the zone.
    """
    mask, name = in_zone(tool, zone)
    return InZone(name, _dealt(poses, mask, name, tool), len(poses))


def poses_in_zone(arm: Arm, count: int, zone: Mapping[str, tuple[float, float]], seed: int = 1, law: PoseLaw = "sobol") -> InZone:
    """Return `count` poses of a pose law with the tool in a zone, limits along the base's axes in m.

    The first so many in it of each of the law's independent sets, which are made longer until there are enough: poses of the same law, given that
    the tool is in the zone. A zone that holds the workspace holds the poses of `sample_poses`. Of a small zone, all that are in it of 524 288
    (2^19). Raises InputError where none is, or only one.
    """
    tries = [count, *(tried for tried in (8 * count, 64 * count) if tried < MOST_TRIED), *([MOST_TRIED] if count < MOST_TRIED else [])]
    for tried in tries:
        sampled = sample_poses(arm, tried, law, seed)
        tool = tool_points(arm, sampled.q)
        mask, name = _in_box(tool, zone)
        of_sets = mask.reshape(sampled.replicates, -1)
        each = -(-count // len(of_sets))
        if of_sets.sum(axis=1).min() >= each:
            first = np.concatenate([np.flatnonzero(inside)[:each] + k * of_sets.shape[1] for k, inside in enumerate(of_sets)])
            return InZone(name, Poses(sampled.q[first], law, len(of_sets)), len(sampled))
    if not mask.any():
        raise _nowhere(name, zone, tool)
    return InZone(name, _dealt(sampled, mask, name, tool, count), len(sampled))


def _dealt(poses: Poses, mask: np.ndarray, name: str, tool: Floats, most: int = 1 << 62) -> Poses:
    """Return the poses in a mask in equal sets: cut, in order, into as many as there were, or as there are poses, the few left over dropped.

    Sets that keep few of their poses keep different numbers of them. Cut so, a set borrows from its neighbour; so few poses of a sequence are
    nearly independent draws, whichever set they come from.
    """
    inside = np.flatnonzero(mask)
    if poses.replicates == 1:
        return Poses(poses.q[inside], poses.law)
    if len(inside) == 1:
        raise _refused(f"{name}: only 1 of the {len(mask)} poses is in it", "a zone that more reach", tool)
    sets = min(poses.replicates, len(inside))
    each = min(len(inside) // sets, -(-most // sets))
    return Poses(poses.q[inside[: len(inside) // sets * sets].reshape(sets, -1)[:, :each].ravel()], poses.law, sets)


def _nowhere(name: str, zone: Any, tool: Floats) -> InputError:  # noqa: ANN401 - a mask, or ends by axis
    """Refuse a zone without a pose; one that lies where the tool goes may only be too small to be met by chance."""
    ends = checked_ends(zone).items() if hasattr(zone, "items") else ()
    along = [(tool[:, _AXES.index(axis)], low, high) for axis, (low, high) in ends]
    within = bool(along) and all(low <= reached.max() and high >= reached.min() for reached, low, high in along)
    expected = (
        "a larger one, for it may be reached but is too small to be met by chance, or one that some reach" if within else "a zone that some reach"
    )
    return _refused(f"{name}: none of the {len(tool)} poses is in it", expected, tool)


def _refused(found: str, expected: str, tool: Floats) -> InputError:
    """Refuse a zone and say where the tool goes; its name is our own text, and is not cut short."""
    low, high = tool.min(axis=0), tool.max(axis=0)
    reached = ", ".join(f"{axis} {a:.3f}..{b:.3f} m" for axis, a, b in zip(_AXES, low, high, strict=True))
    return InputError([Problem("", "zone", found, f"{expected}; the tool goes {reached}", passing=(("zone", _EXAMPLE),))])


def _in_box(tool: Floats, ends: Mapping[str, tuple[float, float]]) -> tuple[np.ndarray, str]:
    mask = np.ones(len(tool), dtype=bool)
    limits = []
    for axis, (low, high) in checked_ends(ends).items():
        along = tool[:, _AXES.index(axis)]
        mask &= (along >= low) & (along <= high)
        limits.append(f"{axis} {low * 1e3:g} … {high * 1e3:g} mm")
    return mask, ", ".join(limits)


def checked_ends(ends: Mapping[Any, Any]) -> dict[str, tuple[float, float]]:
    """Return the limits of a zone, m, along each of the base's axes that it names. Raises InputError with every mistake in what was given."""
    expected = "ends along x, y or z in m, the lower one first"
    mistakes: list[Problem] = []
    out: dict[str, tuple[float, float]] = {}
    for axis, pair in ends.items():
        try:
            low, high = (math.nan if isinstance(end, str) else float(end) for end in pair)
        except (TypeError, ValueError):
            low = high = math.nan
        if not (isinstance(axis, str) and axis in set(_AXES)) or not (math.isfinite(low) and math.isfinite(high)) or low > high:
            mistakes.append(Problem("", "zone", shown(f"{axis}: {pair}")[1:-1], expected, passing=(("zone", _EXAMPLE),)))
        out[axis] = (low, high)
    if mistakes or not out:
        raise InputError(mistakes or [Problem("", "zone", "no ends", expected, passing=(("zone", _EXAMPLE),))])
    return out
