"""The picture of an arm: what it frames and hides, colour classes with round limits, and the factor
by which errors are enlarged.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, Self

import numpy as np

from lostmotion.mechanism.state import state_of
from lostmotion.printed import round_number
from lostmotion.reporting.palette import CLASSES, DARK, class_limits

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats


Shown = Literal["half", "all", "none"]
# Direction from the middle of the workspace to the camera, with z up; tangent of half its angle of
# view, which is 75 degrees; and the share of the picture that arm and workspace fill.
_CAMERA: Final = np.array([0.42, -0.86, 0.28]) / np.linalg.norm([0.42, -0.86, 0.28])
_VIEW: Final = math.tan(math.radians(37.5))
_FILLED: Final = 0.9
# The half of the workspace behind the arm begins this share of its size behind its middle.
_BEHIND: Final = 0.06
# A workspace that is thinner than this share of its size is not cut.
_THIN: Final = 0.25
# Largest distance of a click from the point that is meant, over the size of the workspace.
_NEAR: Final = 0.015
# The first pose has its tool at this share of the largest distance from the base's axis, or as near
# as possible to it.
_REACHED: Final = 0.6
_SEARCHED: Final = 512


@dataclass(frozen=True)
class Framing:
    """What the camera sees.

    size    extent of the workspace together with the base, m
    middle  (3,) point in the middle of the picture, m
    floor   lowest level of the workspace's picture along z, m
    away    distance of the camera from the middle, m
    """

    size: float
    middle: Floats
    floor: float
    away: float

    @classmethod
    def of(cls, arm: Arm, points: Floats, q: Floats) -> Self:
        """Return the framing for the tool points (pose, 3), m, and for the arm itself at q
        (joint,), rad and m.
        """
        at = state_of(arm, q).frames[:, 0]
        corners = {body: body.corners_at(at[body.place]) for body in arm.bodies}
        seen = np.concatenate([points, np.zeros((1, 3)), *corners.values()])
        low, high = seen.min(axis=0), seen.max(axis=0)
        floor = min(
            [
                0.0,
                *(float(each[:, 2].min()) for body, each in corners.items() if body.kind == "base"),
            ]
        )
        # Each point is within the angle of view, in a picture as high as it is wide.
        middle = (low + high) / 2
        towards = (seen - middle) @ _CAMERA
        aside = np.linalg.norm(seen - middle - np.multiply.outer(towards, _CAMERA), axis=1)
        away = float((towards + aside / (_FILLED * _VIEW)).max())
        return cls(float(np.linalg.norm(high - low)) or 1.0, middle, floor, away or 1.0)

    @property
    def camera(self) -> Floats:
        """Return the position of the camera (3,), m."""
        return np.asarray(self.middle + self.away * _CAMERA)


def first_pose(arm: Arm, poses: Poses) -> Floats:
    """Return the pose (joint,) that is shown first: one of these with the arm above its base, half
    stretched, near the middle of its ranges.
    """
    q = poses.q[:_SEARCHED]
    at = state_of(arm, q).frames[:, :, :3, 3]
    aside = np.hypot(at[-1, :, 0], at[-1, :, 1])
    below = np.maximum(-at[..., 2], 0.0).max(axis=0) / (np.abs(at).max() or 1.0)
    low, high = arm.limits.T
    off_middle = np.abs((q - (low + high) / 2) / (high - low)).mean(axis=1)
    return np.asarray(
        q[np.argmin(4 * below + 2 * np.abs(aside / (aside.max() or 1.0) - _REACHED) + off_middle)]
    )


def visible(points: Floats, shown: Shown, size: float) -> NDArray[np.int64]:
    """Return the indices of the tool points (pose, 3) that are drawn: those behind the arm, seen
    from the camera, all, or none.
    """
    if shown == "none":
        return np.empty(0, dtype=int)
    low, high = points[:, 1].min(), points[:, 1].max()
    if shown == "all" or high - low < _THIN * size:
        return np.arange(len(points))
    return np.flatnonzero(points[:, 1] > (low + high) / 2 + _BEHIND * size)


def picked(origin: Floats, direction: Floats, points: Floats, size: float) -> int | None:
    """Return the index of the point (point, 3) that a click means; None where none is near.

    The click is a ray from `origin` (3,) along `direction` (3,) in the base's frame. Of the points
    near it the first one counts.
    """
    along = direction / np.linalg.norm(direction)
    to_points = points - origin
    depth = to_points @ along
    off = np.linalg.norm(to_points - np.outer(depth, along), axis=1)
    near = np.flatnonzero((off < _NEAR * size) & (depth > 0))
    return int(near[np.argmin(depth[near])]) if len(near) else None


# Small to large error, on the dark ground of the view.
COLOURS: Final = tuple(DARK[f"c{k}"] for k in range(len(CLASSES)))
# Share of the errors below the first and above the last limit.
_ENDS: Final = (0.03, 0.97)
# Length of a typical error in the picture, as a share of the picture's size.
_SHOWN: Final = 0.06


@dataclass(frozen=True)
class Classes:
    """Limits (m) between the colour classes, ascending, at multiples of a round step."""

    limits: tuple[float, ...]

    def colours(self, errors: Floats) -> NDArray[np.uint8]:
        """Return the colour (error, 3) of each error (m); one that lies on a limit belongs to the
        class above it.
        """
        table = np.array(
            [[int(colour[k : k + 2], 16) for k in (1, 3, 5)] for colour in COLOURS], dtype=np.uint8
        )
        return np.asarray(table[np.searchsorted(self.limits, errors, side="right")])


def classes_of(errors: Floats) -> Classes:
    """Return the classes that suit these errors (m): round limits, in mm, over the range of most of
    them.
    """
    low, high = (float(each) for each in 1e3 * np.quantile(errors, _ENDS))
    return Classes(tuple(1e-3 * limit for limit in class_limits(low, high)))


def enlargement(errors: Floats, size: float) -> float:
    """Return the round factor at which a typical one of these errors (m) is well visible in a
    picture of this size (m); 1 without errors.
    """
    typical = float(np.median(errors))
    return round_number(_SHOWN * size / typical) if typical > 0 else 1.0
