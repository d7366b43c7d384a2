"""Sections of the workspace in classes of a value at each pose: from the side and from above.

Poses are gathered in square cells, so good and bad poses at different depths are not drawn over each other. From the side, an arm whose first joint
turns about a vertical axis has all its poses turned about that axis into one half plane: neither load nor error depends on that joint's angle. For
other arms, and from above, a section holds the poses within a slab about the marked pose.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.serial import frames
from lostmotion.reporting.chart import cells, class_legend, class_of, label, label_axes, one, ringed, swatch
from lostmotion.reporting.palette import LIGHT, class_limits

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Half the thickness of a slab, of the workspace's extent across it.
_SLAB: Final = 0.1
_PER_CELL: Final = 3
_MOST_CELLS: Final = 32
_FEWEST_CELLS: Final = 8
_LEAST_SHAPE: Final = 0.15
_UPRIGHT: Final = 1e-9
# Shares of the poses outside the inner classes.
_TAILS: Final = (0.03, 0.97)
# Height of a chart, mm: what stands around the section, the section's width, and the ends.
_AROUND: Final = 38.0
_ACROSS: Final = 110.0
_HEIGHTS: Final = (60.0, 150.0)


@dataclass(frozen=True)
class PoseValues:
    """A value at each pose of an arm, to be drawn over the tool points.

    tool       (pose, 3) m
    values     (pose,) in the unit shown
    what       the value, and `unit`
    marked     the pose that is ringed, and through which slabs go; `mark` names it
    reachable  (point, 3) m, further points that the tool reaches
    """

    arm: Arm
    tool: Floats
    values: Floats
    what: str
    unit: str
    marked: int
    mark: str
    reachable: Floats = field(default_factory=lambda: np.empty((0, 3)))


def from_the_side(found: PoseValues) -> Figure:
    """Draw a vertical section, mm: all poses turned about a vertical first axis, else those near the XOZ plane of the marked pose."""
    arm = found.arm
    joint = arm.tree.tool_joints[0]
    place = arm.tree.moved[joint]
    frame, twist = frames(arm, np.zeros((1, len(arm.moving))))[place, 0], arm.tree.places[place].twist
    axis, gravity = frame[:3, :3] @ twist[:3], arm.gravity_in_base
    if not np.allclose([*axis[:2], *gravity[:2]], 0.0, atol=_UPRIGHT) or not axis.any():
        return _slab(found, 0, 2)
    tool, reachable = (
        np.column_stack([np.hypot(points[:, 0] - frame[0, 3], points[:, 1] - frame[1, 3]), points[:, 2]]) for points in (found.tool, found.reachable)
    )
    name = label(arm.moving[joint].name)
    words = f"all poses turned about the axis of {name}", f"distance from the axis of {name} [mm]", "z [mm]"
    return _section(found, words, tool, reachable, np.ones(len(tool), dtype=bool))


def from_above(found: PoseValues) -> Figure:
    """Draw a horizontal section, mm, through the marked pose."""
    return _slab(found, 0, 1)


def _slab(found: PoseValues, across: int, up: int) -> Figure:
    """Draw the poses within a slab about the plane of two axes of the base through the marked pose."""
    other = 3 - across - up
    depth = found.tool[:, other]
    half = _SLAB * float(np.ptp(depth)) + _UPRIGHT
    near, reached = (np.abs(points[:, other] - depth[found.marked]) <= half for points in (found.tool, found.reachable))
    names = "xyz"[across], "xyz"[up]
    place = f"{depth[found.marked] * 1e3:.4g}".replace("-", "−")
    words = f"section at {'xyz'[other]} = {place} mm", f"{names[0]} [mm]", f"{names[1]} [mm]"
    return _section(found, words, found.tool[:, [across, up]], found.reachable[reached][:, [across, up]], near)


def _section(found: PoseValues, words: tuple[str, str, str], tool: Floats, reachable: Floats, chosen: np.ndarray) -> Figure:
    """Draw the mean value of the chosen poses in square cells over the reachable cells.

    `words` are where the section lies and both axes, `tool` (pose, 2) and `reachable` (point, 2) positions in m.
    """
    limits = class_limits(*(float(end) for end in np.quantile(found.values, _TAILS)))
    edges = _edges(np.vstack([reachable, tool[chosen]]), int(chosen.sum()))
    sums, counts = (np.histogram2d(tool[chosen, 0], tool[chosen, 1], edges, weights=each)[0] for each in (found.values[chosen], None))
    means = np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)
    wide, tall = (float(each[-1] - each[0]) for each in edges)
    figure, on = one(f"{found.what[:1].upper()}{found.what[1:]}, {words[0]}", float(np.clip(_AROUND + _ACROSS * tall / wide, *_HEIGHTS)))
    x, y = (each * 1e3 for each in edges)
    extra = []
    if len(reachable):
        reached = np.histogram2d(reachable[:, 0], reachable[:, 1], edges)[0] > 0
        cells(on, x, y, np.where(reached, 0, -1), (LIGHT["line"],))
        extra.append(swatch("reachable, not visited", LIGHT["line"]))
    cells(on, x, y, class_of(means, limits))
    at = tool[found.marked] * 1e3
    ringed(on, float(at[0]), float(at[1]), found.mark)
    on.set_aspect("equal")
    label_axes(on, words[1], words[2])
    class_legend(figure, limits, f"{found.what} [{found.unit}]", [*extra, *on.get_legend_handles_labels()[0]])
    return figure


def _edges(points: Floats, count: int) -> list[Floats]:
    """Return the edges of square cells, m, that hold all points (point, 2) and a few of `count` poses each; a flat workspace is given some height."""
    low, high = points.min(axis=0), points.max(axis=0)
    sides = np.maximum(high - low, max(_LEAST_SHAPE * float((high - low).max()), 1e-3))
    side = float(sides.max()) / int(np.clip(np.sqrt(count / _PER_CELL), _FEWEST_CELLS, _MOST_CELLS))
    starts = (low + high - sides) / 2
    return [start + side * np.arange(int(np.ceil(length / side - 1e-9)) + 1) for start, length in zip(starts, sides, strict=True)]
