"""Where can the tool get to? Reach, extent and volume of the workspace, from many poses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.arm import frames
from lostmotion.studies.poses import PoseLaw, sample_poses

if TYPE_CHECKING:
    from lostmotion.arm import Arm
    from lostmotion.spatial import Floats

SAMPLES: Final = 131_072
_CHUNK: Final = 4096
# Grids tried for the volume, cells along the longest side, finest first.
_GRIDS: Final = (64, 48, 32, 24, 16, 12, 8)
# The sample fills a grid when its first half already visited this share of the cells.
_FILLED: Final = 0.97
_DIMENSIONS: Final = 3


@dataclass(frozen=True)
class Workspace:
    """What the sampled tool positions (pose, 3) say, in m and m^3, base frame.

    reach             largest distance from the base's origin, and the same seen from above (horizontal)
    nearest           smallest distance from the base's origin
    low, high         (3,) extent along x, y, z
    volume            with volume_low (cells surrounded by visited cells) and volume_high (every visited cell); cell is the edge used.
                      Zero where the workspace is no body (fewer than three motions, or flat)
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


def tool_positions(arm: Arm, q: Floats) -> Floats:
    """Where is the tool point at these poses? (pose, 3), m, base frame; in chunks, so that memory stays bounded."""
    return np.concatenate([frames(arm, q[k : k + _CHUNK])[-1, :, :3, 3] for k in range(0, len(q), _CHUNK)])


def workspace(arm: Arm, law: PoseLaw = "sobol", samples: int = SAMPLES, seed: int = 1) -> Workspace:
    """Which space can the tool point of this arm reach within its joint limits?

    No obstacle, floor or self-collision is considered. Raises ValueError for fewer than one sample.
    """
    points = tool_positions(arm, sample_poses(arm, samples, law, seed).q)
    distance = np.linalg.norm(points, axis=1)
    low, high = points.min(axis=0), points.max(axis=0)
    inner, outer, cell = _volume(points, low, high) if len(arm.moving) >= _DIMENSIONS else (0.0, 0.0, 0.0)
    return Workspace(
        points,
        law,
        float(distance.max()),
        float(np.linalg.norm(points[:, :2], axis=1).max()),
        float(distance.min()),
        low,
        high,
        (inner + outer) / 2,
        inner,
        outer,
        cell,
    )


def _volume(points: Floats, low: Floats, high: Floats) -> tuple[float, float, float]:
    """Count cells: those whose six neighbours were visited too, and all that were visited; on the finest grid that the sample fills."""
    extent = high - low
    longest = float(extent.max())
    if longest == 0 or float(extent.min()) < 1e-6 * longest:
        return 0.0, 0.0, 0.0
    for cells in _GRIDS:
        edge = longest / cells
        shape = np.maximum(np.ceil(extent / edge).astype(int), 1) + 2
        index = np.minimum(((points - low) / edge).astype(int), shape - 3) + 1
        cell = np.ravel_multi_index(tuple(index.T), tuple(shape))
        visited, earlier = np.zeros(int(np.prod(shape)), bool), np.zeros(int(np.prod(shape)), bool)
        visited[cell], earlier[cell[: len(cell) // 2]] = True, True
        if np.count_nonzero(earlier) >= _FILLED * np.count_nonzero(visited):
            break
    visited = visited.reshape(shape)
    inside = visited.copy()
    for axis in range(_DIMENSIONS):
        inside &= np.roll(visited, 1, axis) & np.roll(visited, -1, axis)
    return float(np.count_nonzero(inside)) * edge**3, float(np.count_nonzero(visited)) * edge**3, edge
