"""The arm at its worst pose in a cut through its workspace, coloured by the error: the picture of the first screen."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.serial import frames
from lostmotion.propagation.montecarlo import kernel
from lostmotion.reporting.chart import PER_UNIT, cells, class_legend, class_of, label_axes, one
from lostmotion.reporting.palette import LIGHT, class_limits, round_below
from lostmotion.reporting.plot import FIRST_SCREEN, Plot
from lostmotion.reporting.sheet import length

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lostmotion.analyses.accuracy.answer import Answer
    from lostmotion.spatial import Floats

# Cells along the longest side of the workspace; poses whose mean colours a cell.
_CELLS: Final = 44
_NEAREST: Final = 16
# Classes cover the values between these percentiles.
_COVERED: Final = (3.0, 97.0)
# A workspace lower than this share of its longest side is cut horizontally. The arrow is at most this share of that side long.
_FLAT: Final = 0.05
_ARROW: Final = 0.15
# The mean error vector is drawn where its part in the plane of the cut is more than this share of the mean error.
_SHOWN: Final = 0.2
_FILLS: Final = {"base": "quiet", "joint": "quiet", "tool": "warn", "payload": "warn"}


def arm_in_workspace(answer: Answer) -> Plot:
    """Return the arm at the pose with the largest mean error, in the cut through its workspace that holds base axis and tool.

    A cell has the mean of the 95th percentile over the poses of the study that put the tool nearest to it. The workspace is that of the joint limits.
    """
    table, points = answer.sampled.per_pose, answer.workspace.points
    worst = int(table[:, kernel.MEAN].argmax())
    q95 = table[:, kernel.FIRST_QUANTILE + 3 * kernel.QUANTILES.index(0.95)]
    unit = length(float(q95.max())).unit
    tool, bias = answer.tool[worst], answer.sampled.bias[worst, 3:]
    size = float(np.ptp(points, axis=0).max()) or 1.0
    view, names = _view(points, tool, size)
    limits = class_limits(*(float(each) * PER_UNIT[unit] for each in np.percentile(q95, _COVERED)))
    drawn, on = one("", 132, width=178)
    across, up, values = _cut(points, answer.tool, q95 * PER_UNIT[unit], view, float(view[2] @ tool), size / _CELLS)
    cells(on, across * 1e3, up * 1e3, class_of(values, limits))
    seen = np.concatenate([*_arm(on, answer, worst, view), 1e3 * np.column_stack([across[[0, -1]], up[[0, -1]]])])
    room = 1e3 * size / _CELLS
    on.set_xlim(float(seen[:, 0].min()) - room, float(seen[:, 0].max()) + room)
    on.set_ylim(float(seen[:, 1].min()) - room, float(seen[:, 1].max()) + room)
    mean, within = float(table[worst, kernel.MEAN]), float(np.linalg.norm(view[:2] @ bias))
    factor = _factor(_ARROW * size / within) if within > _SHOWN * mean else 0.0
    if factor:
        start, end = (1e3 * (view[:2] @ each) for each in (tool, tool + factor * bias))
        on.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": LIGHT["warn"], "lw": 2.2, "mutation_scale": 14}, zorder=6)
    on.set_aspect("equal")
    label_axes(on, *(f"{name} [mm]" for name in names))
    class_legend(drawn, limits, f"95 % of positions within [{unit}]")
    arrow = f" The arrow is the mean error vector in this plane, drawn {factor:g} times larger." if factor else ""
    words = (
        f"The arm at the pose with the largest mean error, {length(mean)}, in the cut through its workspace at the tool. "
        f"Cells: mean over the {min(_NEAREST, len(q95))} nearest poses.{arrow}"
    )
    return Plot("arm", FIRST_SCREEN, drawn, words)


def _view(points: Floats, tool: Floats, size: float) -> tuple[Floats, tuple[str, str]]:
    """Return the directions to the right, upwards and towards the viewer (3, 3) of the cut, and the names of the first two."""
    if float(np.ptp(points[:, 2])) < _FLAT * size:
        return np.eye(3), ("x", "y")
    azimuth = math.atan2(tool[1], tool[0])
    right = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
    return np.array([right, [0.0, 0.0, 1.0], np.cross(right, [0.0, 0.0, 1.0])]), ("distance from the base's axis", "z")


def _cut(points: Floats, tool: Floats, values: Floats, view: Floats, depth: float, edge: float) -> tuple[Floats, Floats, Floats]:
    """Return the edges of the cells of a cut across and upwards, m, and their values (across, up); NaN where no point of the workspace is."""
    from scipy.ndimage import binary_closing
    from scipy.spatial import KDTree

    near = np.concatenate([points, tool])  # never empty: the plane contains the tool of one pose
    inside = near[np.abs(near @ view[2] - depth) <= edge] @ view[:2].T
    across, up = (
        np.arange(math.floor(low / edge), math.floor(high / edge) + 2) * edge for low, high in zip(inside.min(0), inside.max(0), strict=True)
    )
    reached = np.histogram2d(inside[:, 0], inside[:, 1], bins=(across, up))[0] > 0
    reached |= binary_closing(np.pad(reached, 1), np.ones((3, 3), bool))[1:-1, 1:-1]
    column, row = np.nonzero(reached)
    centres = np.column_stack([across[column] + edge / 2, up[row] + edge / 2, np.full(len(row), depth)]) @ view
    of_poses = KDTree(tool).query(centres, k=np.arange(1, min(_NEAREST, len(tool)) + 1))[1]
    out = np.full(reached.shape, np.nan)
    out[column, row] = values[of_poses].mean(axis=1)
    return across, up, out


def _arm(on: Axes, answer: Answer, pose: int, view: Floats) -> list[Floats]:
    """Draw the bodies of the arm from far to near, and return their outlines (corner, 2), mm."""
    from matplotlib.patches import Polygon

    at = frames(answer.arm, answer.poses.q[pose : pose + 1])[:, 0]
    bodies = sorted(answer.arm.bodies, key=lambda body: float(view[2] @ (at[body.place] @ body.pose)[:3, 3]))
    outlines = [body.silhouette(at[body.place], view[:2]) * 1e3 for body in bodies]
    for body, outline in zip(bodies, outlines, strict=True):
        on.add_patch(Polygon(outline, facecolor=LIGHT[_FILLS.get(body.kind, "line")], edgecolor=LIGHT["ink"], linewidth=0.7, zorder=5))
    return outlines


def _factor(most: float) -> float:
    """Return the largest of 1, 2 and 5 times a power of ten that is at most this, and at least 1."""
    return max(1.0, round_below(most))
