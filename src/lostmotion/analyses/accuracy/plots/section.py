"""Sections of the workspace in classes of the mean error: from the side and from above.

Poses are gathered in square cells, so good and bad poses at different depths are not drawn over each other. From the side, an arm whose first joint
turns about a vertical axis has all its poses turned about that axis into one half plane: neither load nor error depends on that joint's angle. For
other arms, and from above, a section holds the poses within a slab about the worst pose.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.serial import frames
from lostmotion.propagation.montecarlo import kernel
from lostmotion.reporting.chart import PER_UNIT, cells, class_legend, class_of, label, label_axes, one, ringed, swatch
from lostmotion.reporting.palette import LIGHT, class_limits
from lostmotion.reporting.sheet import length

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lostmotion.analyses.accuracy.answer import Answer
    from lostmotion.spatial import Floats

# Half the thickness of a slab, of the workspace's extent across it.
_SLAB: Final = 0.1
_PER_CELL: Final = 3
_MOST_CELLS: Final = 32
_FEWEST_CELLS: Final = 8
_LEAST_SHAPE: Final = 0.15
_UPRIGHT: Final = 1e-9
# Height of a chart, mm: what stands around the section, the section's width, and the ends.
_AROUND: Final = 38.0
_ACROSS: Final = 110.0
_HEIGHTS: Final = (60.0, 150.0)


def seen_from_the_side(answer: Answer) -> Figure:
    """Draw the mean error over a vertical section, mm: all poses turned about a vertical first axis, else those near the worst pose's XOZ plane."""
    arm = answer.arm
    joint = arm.tree.tool_joints[0]
    place = arm.tree.moved[joint]
    frame, twist = frames(arm, np.zeros((1, len(arm.moving))))[place, 0], arm.tree.places[place].twist
    axis, gravity = frame[:3, :3] @ twist[:3], arm.gravity_in_base
    if not np.allclose([*axis[:2], *gravity[:2]], 0.0, atol=_UPRIGHT) or not axis.any():
        return _slab(answer, 0, 2)
    seen = [
        np.column_stack([np.hypot(points[:, 0] - frame[0, 3], points[:, 1] - frame[1, 3]), points[:, 2]])
        for points in (answer.tool, answer.workspace.points)
    ]
    name = label(arm.moving[joint].name)
    words = f"Mean error, all poses turned about the axis of {name}", f"distance from the axis of {name} [mm]", "z [mm]"
    return _section(answer, words, seen[0], seen[1], np.ones(len(answer.tool), dtype=bool))


def seen_from_above(answer: Answer) -> Figure:
    """Draw the mean error over the horizontal section, mm, through the worst pose."""
    return _slab(answer, 0, 1)


def _slab(answer: Answer, across: int, up: int) -> Figure:
    """Draw the mean error of the poses within a slab about the plane of two axes of the base through the worst pose."""
    other = 3 - across - up
    low, high = answer.tool[:, other].min(), answer.tool[:, other].max()
    middle = answer.tool[_worst(answer), other]
    half = _SLAB * (high - low) + _UPRIGHT
    near = [np.abs(points[:, other] - middle) <= half for points in (answer.tool, answer.workspace.points)]
    names = "xyz"[across], "xyz"[up], "xyz"[other]
    words = f"Mean error near the worst pose's plane of {names[0]} and {names[1]}", f"{names[0]} [mm]", f"{names[1]} [mm]"
    return _section(answer, words, answer.tool[:, [across, up]], answer.workspace.points[near[1]][:, [across, up]], near[0])


def _section(answer: Answer, words: tuple[str, str, str], tool: Floats, reachable: Floats, chosen: np.ndarray) -> Figure:
    """Draw the mean error of the chosen poses in square cells over the reachable cells.

    `words` are the title and both axes, `tool` (pose, 2) and `reachable` (point, 2) positions in m.
    """
    means = answer.sampled.per_pose[:, kernel.MEAN]
    unit = length(float(means.max())).unit
    factor = PER_UNIT[unit]
    limits = class_limits(*(float(end) * factor for end in np.quantile(means, [0.03, 0.97])))
    both = np.vstack([reachable, tool[chosen]])
    low, high = both.min(axis=0), both.max(axis=0)
    low, high = (low + high) / 2 - _sides(high - low) / 2, (low + high) / 2 + _sides(high - low) / 2
    count = int(np.clip(np.sqrt(chosen.sum() / _PER_CELL), _FEWEST_CELLS, _MOST_CELLS))
    side = float((high - low).max()) / count
    edges = [start + side * np.arange(int(np.ceil((end - start) / side - 1e-9)) + 1) for start, end in zip(low, high, strict=True)]
    sums, counts = (np.histogram2d(tool[chosen, 0], tool[chosen, 1], edges, weights=each)[0] for each in (means[chosen] * factor, None))
    error = np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)
    reached = np.histogram2d(reachable[:, 0], reachable[:, 1], edges)[0] > 0
    wide, tall = (float(each[-1] - each[0]) for each in edges)
    figure, on = one(words[0], float(np.clip(_AROUND + _ACROSS * tall / wide, *_HEIGHTS)))
    x, y = (each * 1e3 for each in edges)
    cells(on, x, y, np.where(reached, 0, -1), (LIGHT["line"],))
    cells(on, x, y, class_of(error, limits))
    worst = tool[_worst(answer)] * 1e3
    ringed(on, float(worst[0]), float(worst[1]), "worst pose")
    on.set_aspect("equal")
    label_axes(on, words[1], words[2])
    class_legend(figure, limits, f"mean error [{unit}]", [swatch("reachable, not visited", LIGHT["line"]), *on.get_legend_handles_labels()[0]])
    return figure


def _sides(extent: Floats) -> Floats:
    """Return the sides to draw: a flat workspace is given some height."""
    return np.maximum(extent, max(_LEAST_SHAPE * float(extent.max()), 1e-3))


def _worst(answer: Answer) -> int:
    """Return the pose with the largest mean error."""
    return int(answer.sampled.per_pose[:, kernel.MEAN].argmax())
