"""Reach, extent and volume of the workspace, from many poses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.poses import PoseLaw, sample_poses
from lostmotion.mechanism.assembly import affordable
from lostmotion.mechanism.state import tool_points

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

SAMPLES: Final = 524_288
# Fewer where there are many joints, so that memory stays bounded.
_JOINT_VALUES: Final = 4_194_304
# Grids tried for the volume, cells along the longest side, finest first.
_GRIDS: Final = (64, 48, 32, 24, 16, 12, 8)
# A grid is fine enough for the sample when closing single holes adds less than this share of cells.
_MOST_HOLES: Final = 0.02
_DIMENSIONS: Final = 3


@dataclass(frozen=True)
class Workspace:
    """What the sampled tool positions (pose, 3) say, in m and m^3, base frame.

    reach             largest distance from the base's origin, and the same seen from above
                      (horizontal)
    nearest           smallest distance from the base's origin
    low, high         (3,) extent along x, y, z
    volume            half way between volume_low (cells with all 26 neighbours visited) and
                      volume_high (all visited); cell is the edge used. Zero where the workspace is
                      no body: fewer than three motions, flat, or a surface
    Extremes of a sample: the true reach is not smaller, the true nearest not larger.
    """

    points: Floats
    law: PoseLaw
    reach: float
    reach_horizontal: float
    nearest: float
    low: Floats
    high: Floats
    volume: float
    volume_low: float
    volume_high: float
    cell: float


def workspace(
    arm: Arm, law: PoseLaw = "sobol", samples: int | None = None, seed: int = 1
) -> Workspace:
    """Return the workspace of the tool point within the joint limits.

    No obstacle, floor or self-collision is considered. `samples` by default half a million, fewer
    with more than eight joints.
    """
    count = samples or affordable(
        arm, min(SAMPLES, 1 << (_JOINT_VALUES // len(arm.driven)).bit_length() - 1)
    )
    points = tool_points(arm, sample_poses(arm, count, law, seed).q)
    along = np.ascontiguousarray(points.T)  # one axis after the other in memory
    distance = np.linalg.norm(along, axis=0)
    low, high = along.min(axis=1), along.max(axis=1)
    inner, outer, cell = (
        _volume(along, low, high) if len(arm.driven) >= _DIMENSIONS else (0.0, 0.0, 0.0)
    )
    return Workspace(
        points,
        law,
        float(distance.max()),
        float(np.linalg.norm(along[:2], axis=0).max()),
        float(distance.min()),
        low,
        high,
        (inner + outer) / 2,
        inner,
        outer,
        cell,
    )


def _volume(along: Floats, low: Floats, high: Floats) -> tuple[float, float, float]:
    """Count cells of the finest grid that the sample (3, pose) fills: those with all 26 neighbours
    visited, and all visited (single holes closed).

    For a smooth boundary the first falls short by about as much as the second exceeds, so the
    volume lies between and near the middle.
    """
    from scipy.ndimage import binary_closing, binary_erosion

    extent = high - low
    longest = float(extent.max())
    if longest == 0 or float(extent.min()) < 1e-6 * longest:
        return 0.0, 0.0, 0.0
    cube = np.ones((3, 3, 3), bool)
    for cells in _GRIDS:
        edge = longest / cells
        shape = np.maximum(np.ceil(extent / edge).astype(int), 1) + 4
        number = np.zeros(along.shape[1], dtype=int)
        for part, start, size in zip(along, low, shape.tolist(), strict=True):
            number *= size
            number += np.minimum(((part - start) / edge).astype(int), size - 5) + 2
        visited = np.zeros(shape, bool)
        visited.ravel()[number] = True
        closed = binary_closing(visited, cube)
        if np.count_nonzero(closed & ~visited) <= _MOST_HOLES * np.count_nonzero(closed):
            break
    inside = binary_erosion(closed, cube)
    if not inside.any():
        return 0.0, 0.0, 0.0  # nowhere thicker than the grid: a surface
    return (
        float(np.count_nonzero(inside)) * edge**3,
        float(np.count_nonzero(closed)) * edge**3,
        edge,
    )
