"""Sections through the workspace in classes of a value at each pose: from the side (XOZ) and from
above (XOY).

A cell has the mean value of the poses nearest to it, so good and bad poses at different depths are
not drawn over each other. Where the first joint turns about a vertical axis, neither load nor error
depends on its angle: poses are then compared by their distance from that axis and their height.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.vertical_axis import vertical_axis
from lostmotion.reporting.chart import (
    label_axes,
    one,
    ringed,
    swatch,
)
from lostmotion.reporting.map_chart import (
    cells,
    class_legend,
    class_of,
    contour,
)
from lostmotion.reporting.palette import LIGHT, class_limits
from lostmotion.reporting.workspace_cells import CELLS, NEAREST, cells_of_cut

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lostmotion.mechanism.arm import Arm
    from lostmotion.reporting.workspace_cells import Axis
    from lostmotion.spatial import Floats

_VERTICAL: Final = 1e-9
# Percentiles of the values between which the classes lie.
COVERED: Final = (3.0, 97.0)
# A workspace lower than this share of its longest side has no section from the side, and one
# narrower than that none from above.
FLAT: Final = 0.05
# What each section shows, in words.
SECTION_TEXT: Final = {
    name: (
        f"{kind} section of the workspace in seven classes; each cell has the mean of the "
        f"{NEAREST} poses nearest to it."
    )
    for name, kind in (("xoz", "Vertical"), ("xoy", "Horizontal"))
}
# Height of a chart, mm: what stands around the section, the section's width, and the ends.
_AROUND: Final = 38.0
_ACROSS: Final = 110.0
_HEIGHTS: Final = (60.0, 150.0)


@dataclass(frozen=True)
class PoseValues:
    """A value at each pose of an arm, to be drawn over the workspace.

    tool       (pose, 3) m
    values     (pose,) in the unit shown
    what       the value, and `unit`
    marked     the pose that is ringed, and through which sections go; `mark` names it
    reachable  (point, 3) m, what the tool reaches
    target     largest acceptable value, drawn as a contour, in the unit shown; None without one
    turns      whether the values are the same at any angle of a first joint that turns about a
               vertical axis
    """

    arm: Arm
    tool: Floats
    values: Floats
    what: str
    unit: str
    marked: int
    mark: str
    reachable: Floats
    target: float | None = None
    turns: bool = True


def symmetry_axis(arm: Arm) -> Axis:
    """Return the vertical axis (x, y; m) of the first joint, about which neither load nor error
    depends on the angle; None without one.
    """
    gravity = arm.gravity_in_base
    return vertical_axis(arm) if np.allclose(gravity[:2], 0.0, atol=_VERTICAL) else None


def sections(pose_values: PoseValues) -> list[tuple[str, Figure]]:
    """Return the sections XOZ and XOY with their names, "xoz" and "xoy", in this order; not those
    in which the workspace is a line.

    XOZ contains the vertical axis of the first joint, or the marked pose where there is none. XOY
    contains the marked pose.
    """
    extent = np.ptp(pose_values.reachable, axis=0)
    size = float(extent.max())
    return [
        (f"{'xyz'[across]}o{'xyz'[up]}", _section(pose_values, across, up, size / CELLS))
        for across, up in ((0, 2), (0, 1))
        if min(extent[across], extent[up]) > FLAT * size
    ]


def _section(pose_values: PoseValues, across: int, up: int, edge: float) -> Figure:
    """Draw the section spanned by two axes of the base in cells with this edge, m."""
    axis, other = symmetry_axis(pose_values.arm) if pose_values.turns else None, 3 - across - up
    marked = pose_values.tool[pose_values.marked].copy()
    if axis is not None and other == 1:  # turned about the axis into the section
        marked[:2] = axis[0] + np.hypot(marked[0] - axis[0], marked[1] - axis[1]), axis[1]
    view = np.eye(3)[[across, up, other]]
    x, y, values = cells_of_cut(
        pose_values.reachable,
        pose_values.tool,
        pose_values.values,
        view,
        float(marked[other]),
        edge,
        axis,
    )
    wide, tall = (float(np.ptp(each)) for each in (x, y))
    place = f"{marked[other] * 1e3:.4g}".replace("-", "−")
    title = f"Section {'XYZ'[across]}O{'XYZ'[up]}, {'xyz'[other]} = {place} mm"
    figure, on = one(title, float(np.clip(_AROUND + _ACROSS * tall / wide, *_HEIGHTS)))
    limits = class_limits(*np.percentile(pose_values.values, COVERED))
    if len(pose_values.values) >= NEAREST:
        cells(on, x * 1e3, y * 1e3, class_of(values, limits))
    else:
        cells(on, x * 1e3, y * 1e3, np.where(np.isfinite(values), 0, -1), (LIGHT["line"],))
    if pose_values.target is not None and len(pose_values.values) >= NEAREST:
        centres = [(each[1:] + each[:-1]) / 2 for each in (x, y)]
        contour(on, centres[0], centres[1], values, pose_values.target, "target", pose_values.unit)
    ringed(on, 1e3 * marked[across], 1e3 * marked[up], pose_values.mark)
    on.set_aspect("equal")
    label_axes(on, f"{'xyz'[across]} [mm]", f"{'xyz'[up]} [mm]")
    extra = on.get_legend_handles_labels()[0]
    if len(pose_values.values) >= NEAREST:
        class_legend(
            figure,
            limits,
            f"{pose_values.what} [{pose_values.unit}], mean of the nearest poses",
            extra,
        )
    else:
        class_legend(
            figure,
            limits,
            f"too few poses for {pose_values.what}",
            [swatch("reachable", LIGHT["line"]), *extra],
        )
    return figure
