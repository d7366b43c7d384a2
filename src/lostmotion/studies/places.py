"""Which of a study's poses are meant by a number or by a zone in space?"""

from __future__ import annotations

import math
from numbers import Integral
from typing import TYPE_CHECKING, Any

import numpy as np

from lostmotion.errors import refuse_argument

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.spatial import Floats

_AXES = "xyz"
_EXAMPLE = 'zone = {"x": (0.2, 0.5)}'


def one_pose(q: Floats, pose: Any) -> tuple[Floats, str]:  # noqa: ANN401 - a number, or joint values
    """Which joint values (1, joint) are meant by a pose's number among q (pose, joint), or by an array of one pose itself? And its name.

    Raises InputError for a number that there is not, or values of another shape or not finite.
    """
    if isinstance(pose, Integral):
        if not 0 <= int(pose) < len(q):
            raise refuse_argument("pose", pose, f"a number from 0 to {len(q) - 1}", "pose = 0")
        return q[[int(pose)]], f"pose {pose}"
    values = np.atleast_2d(np.asarray(pose, dtype=float))
    if values.shape != (1, q.shape[1]) or not np.isfinite(values).all():
        raise refuse_argument("pose", f"values of shape {np.shape(pose)}", f"{q.shape[1]} finite joint values in rad and m, or a number", "pose = 0")
    return values, "the pose asked for"


def in_zone(tool: Floats, zone: Any) -> tuple[np.ndarray, str]:  # noqa: ANN401 - a mask, or ends by axis
    """Which poses (pose,) have their tool point, (pose, 3) m, in this zone? And its name.

    `zone` is that mask itself, or the ends along some of the base's axes, {"x": (0.2, 0.5)} in m. Raises InputError where no pose lies in it.
    """
    if hasattr(zone, "items"):
        mask, name = _in_box(tool, zone)
    else:
        mask = np.asarray(zone)
        if mask.shape != (len(tool),) or mask.dtype != bool:
            raise refuse_argument(
                "zone", f"an array of {mask.dtype} of shape {mask.shape}", f"a truth value for each of the {len(tool)} poses", _EXAMPLE
            )
        name = "the zone asked for"
    if not mask.any():
        low, high = tool.min(axis=0), tool.max(axis=0)
        reached = ", ".join(f"{axis} {a:.3f}..{b:.3f} m" for axis, a, b in zip(_AXES, low, high, strict=True))
        raise refuse_argument("zone", f"{name}: none of the {len(tool)} poses is in it", f"a zone that some reach; the tool goes {reached}", _EXAMPLE)
    return mask, name


def _in_box(tool: Floats, ends: Mapping[str, tuple[float, float]]) -> tuple[np.ndarray, str]:
    mask = np.ones(len(tool), dtype=bool)
    told = []
    for axis, (low, high) in ends.items():
        if axis not in set(_AXES) or not (math.isfinite(low) and math.isfinite(high)) or low > high:
            raise refuse_argument("zone", f"{axis} from {low} to {high}", "ends along x, y or z in m, the lower one first", _EXAMPLE)
        along = tool[:, _AXES.index(axis)]
        mask &= (along >= low) & (along <= high)
        told.append(f"{axis} {low * 1e3:g} … {high * 1e3:g} mm")
    return mask, ", ".join(told)
