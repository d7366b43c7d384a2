"""Plots of an accuracy map: slices, small slices, radial section, share of the workspace by error,
error budget by zone.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.workspace_map.page.labels import configuration_label, percentile_label
from lostmotion.analyses.workspace_map.page.slices import (
    ACROSS,
    AROUND,
    draw_cells,
    gain_plots,
    index_at,
    of_equal_scale,
    place_text,
)
from lostmotion.maps.cell_statistics import CONFIGURATIONS, QUANTILE
from lostmotion.maps.radial import radial_section
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.printed import factor_of, unit_of_length
from lostmotion.reporting.chart import (
    axes,
    figure,
    grid,
    grouped,
    label_axes,
    legend,
    named_rows,
    one,
)
from lostmotion.reporting.chart_settings import SMALL
from lostmotion.reporting.map_chart import (
    class_legend,
    class_of,
    contour,
)
from lostmotion.reporting.palette import LIGHT, class_limits
from lostmotion.reporting.plot import Plot
from lostmotion.reporting.sheet import length

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lostmotion.maps.accuracy_map import WorkspaceMap
    from lostmotion.maps.placement import Placement
    from lostmotion.spatial import Floats

_PARTS_SHOWN: Final = 12
_OF_BY: Final = {"best": LIGHT["visit"], "mean": LIGHT["robot"], "worst": LIGHT["design"]}
# Small slices of one figure, in two rows.
_MULTIPLES: Final = 6
# Shares of the cells outside the inner classes.
_TAILS: Final = (0.03, 0.97)
_POINTS: Final = 200


def map_plots(accuracy_map: WorkspaceMap, at: Floats | None = None) -> list[Plot]:
    """Return the plots of an accuracy map, in reading order; slices through the point `at` (3,) m,
    or through the best place.
    """
    through = accuracy_map.best_place if at is None else at
    shape = accuracy_map.reached.grid.shape
    out = []
    for across, up in ((0, 1), (0, 2), (1, 2)):
        if shape[across] > 1 and shape[up] > 1:
            names = "xyz"[across] + "xyz"[up]
            words = (
                f"Slice of the workspace in the {names[0]}-{names[1]} plane, in classes of the "
                "error of each cell."
            )
            out.append(
                Plot(
                    f"slice-{names}", "map", slice_through(accuracy_map, across, up, through), words
                )
            )
    for along, name in ((2, "z"), (1, "y")):
        if min(shape) > 1 and shape[along] > _MULTIPLES:
            words = (
                f"Slices of the workspace at {_MULTIPLES} places along {name}, in classes of the "
                "error of each cell."
            )
            out.append(Plot(f"slices-{name}", "map", slices_along(accuracy_map, along), words))
    section = radial_plot(accuracy_map)
    if section is not None:
        out.append(
            Plot(
                "radial",
                "map",
                section,
                "Error by distance from the first axis and height, over all azimuths.",
            )
        )
    out += gain_plots(accuracy_map, through)
    out.append(
        Plot(
            "share",
            "within",
            share_by_error(accuracy_map),
            "Share of the workspace within each error.",
        )
    )
    if accuracy_map.budgets and accuracy_map.budgets[0].costs:
        out.append(
            Plot(
                "budget",
                "budget",
                budget_by_zone(accuracy_map),
                "Bars of each part's share of the mean square, by zone.",
            )
        )
    return out


def slice_through(accuracy_map: WorkspaceMap, across: int, up: int, through: Floats) -> Figure:
    """Return a slice of the map through this point (3,), m, spanned by two of the base's axes."""
    grid, names = accuracy_map.reached.grid, "xyz"
    other = 3 - across - up
    index = index_at(grid, other, through)
    values = np.take(
        accuracy_map.selected, index, axis=other
    )  # axes stay in order: across before up
    x, y = grid.centres_along(across), grid.centres_along(up)
    height = float(grid.centres_along(other)[index])
    made, on = of_equal_scale(
        f"{names[across]}-{names[up]} slice, {place_text(other, height)}", x, y
    )
    _draw(on, accuracy_map, x, y, values)
    _target(on, accuracy_map, x, y, values)
    for box in () if accuracy_map.placements is None else accuracy_map.placements.best:
        _outline(on, box, (across, up, other), height, grid.edge)
    label_axes(on, f"{names[across]} [mm]", f"{names[up]} [mm]")
    _classes(made, accuracy_map, on)
    return made


def slices_along(accuracy_map: WorkspaceMap, along: int) -> Figure:
    """Return small slices at even steps along one of the base's axes, all to one scale."""
    grid = accuracy_map.reached.grid
    across, up = (axis for axis in range(3) if axis != along)
    x, y = grid.centres_along(across), grid.centres_along(up)
    chosen = np.round((np.arange(_MULTIPLES) + 0.5) * grid.shape[along] / _MULTIPLES - 0.5).astype(
        int
    )
    wide, tall = (float(np.ptp(each)) + grid.edge for each in (x, y))
    rows = 2
    made = figure(
        float(
            np.clip(AROUND + 16 + rows * (ACROSS / (_MULTIPLES / rows) * tall / wide + 8), 70, 170)
        )
    )
    panels = axes(
        made,
        f"Slices along {'xyz'[along]}",
        rows=rows,
        columns=_MULTIPLES // rows,
        sharex=True,
        sharey=True,
    )
    for k, (on, index) in enumerate(zip(panels.flat, chosen, strict=True)):
        values = np.take(accuracy_map.selected, int(index), axis=along)
        _draw(on, accuracy_map, x, y, values)
        _target(on, accuracy_map, x, y, values)
        on.set_aspect("equal")
        on.locator_params(nbins=4)
        last, left = k >= _MULTIPLES // rows, k % (_MULTIPLES // rows) == 0
        label_axes(on, f"{'xyz'[across]} [mm]" if last else "", f"{'xyz'[up]} [mm]" if left else "")
        on.set_title(
            place_text(along, float(grid.centres_along(along)[index])), loc="center", fontsize=SMALL
        )
    _classes(made, accuracy_map, panels[0, 0])
    return made


def radial_plot(accuracy_map: WorkspaceMap) -> Figure | None:
    """Return the error by distance from the first axis and height; None unless that axis is
    vertical and turns fully.
    """
    section = radial_section(accuracy_map)
    if section is None:
        return None
    made, on = of_equal_scale("Radial section, over all azimuths", section.r, section.z)
    _draw(on, accuracy_map, section.r, section.z, section.values)
    label_axes(on, "distance from the first axis [mm]", "z [mm]")
    _classes(made, accuracy_map, on)
    return made


def share_by_error(accuracy_map: WorkspaceMap) -> Figure:
    """Return the share of the workspace within each error, for the best, mean and worst
    configuration.
    """
    unit, factor = _unit(accuracy_map)
    made, on = one("Share of the workspace by error", 84)
    grid(on, "both")
    for k, by in enumerate(CONFIGURATIONS):
        values = accuracy_map.errors[QUANTILE, k][accuracy_map.centre]
        values = np.sort(values[np.isfinite(values)]) * factor
        shares = 100 * np.arange(1, len(values) + 1) / len(values)
        thin = np.unique(np.linspace(0, len(values) - 1, min(len(values), _POINTS)).astype(int))
        name = "mean over configurations" if by == "mean" else f"{by} configuration"
        selected = by == accuracy_map.by
        on.plot(
            values[thin],
            shares[thin],
            color=_OF_BY[by],
            linewidth=2.0 if selected else 1.2,
            linestyle="-" if selected else "--",
            label=name,
        )
    if accuracy_map.within_target is not None:
        on.axvline(
            accuracy_map.within_target.target * factor,
            color=LIGHT["warn"],
            linewidth=1.2,
            linestyle=(0, (1.5, 1.5)),
            label="target",
        )
    on.set_xlim(left=0)
    on.set_ylim(0, 102)
    label_axes(
        on, f"{percentile_label(accuracy_map)} of the error [{unit}]", "share of the workspace [%]"
    )
    legend(made)
    return made


def budget_by_zone(accuracy_map: WorkspaceMap) -> Figure:
    """Return each part's share of the mean square (%) in each zone, the largest contributor of the
    first zone on top.
    """
    first = accuracy_map.budgets[0].costs[:_PARTS_SHOWN]
    colours = ("design", "visit", "robot") if len(accuracy_map.budgets) > 1 else ("robot",)
    rows = []
    for each, colour in zip(accuracy_map.budgets, colours, strict=False):
        shares = {cost.part: 100 * cost.share for cost in each.costs}
        rows.append(
            (
                f"{each.zone} (r.m.s. {length(each.rms)})",
                LIGHT[colour],
                np.array([shares[cost.part] for cost in first]),
            )
        )
    made, on = one(
        "Share of mean square by part and zone",
        34 + 4.5 * len(rows) + (3.4 * len(rows) + 2) * len(first),
    )
    grouped(on, rows)
    named_rows(on, [short_name(cost.part) for cost in first])
    label_axes(on, "share of mean square [%]")
    legend(made)
    return made


def _unit(accuracy_map: WorkspaceMap) -> tuple[str, float]:
    """Return the unit of all slices, from the largest error."""
    unit = unit_of_length(float(np.nanmax(accuracy_map.selected)))
    return unit, factor_of(unit)


def _limits(accuracy_map: WorkspaceMap) -> list[float]:
    """Return the limits of the classes that all slices share."""
    _, factor = _unit(accuracy_map)
    low, high = np.nanquantile(accuracy_map.selected, _TAILS)
    return class_limits(float(low) * factor, float(high) * factor)


def _draw(on: Axes, accuracy_map: WorkspaceMap, x: Floats, y: Floats, values: Floats) -> None:
    """Draw the errors (x, y) of cells with these centres, m, in the classes of all slices."""
    classes = class_of(values * _unit(accuracy_map)[1], _limits(accuracy_map))
    draw_cells(on, accuracy_map.reached.grid.edge, x, y, classes)


def _target(on: Axes, accuracy_map: WorkspaceMap, x: Floats, y: Floats, values: Floats) -> None:
    """Draw the contour line of the target where it crosses a slice."""
    if accuracy_map.within_target is not None:
        unit, factor = _unit(accuracy_map)
        contour(
            on, x, y, values * factor, accuracy_map.within_target.target * factor, "target", unit
        )


def _classes(made: Figure, accuracy_map: WorkspaceMap, on: Axes) -> None:
    """Draw the legend of the classes, and what else a slice shows."""
    handles, names = on.get_legend_handles_labels()
    extra = dict(zip(names, handles, strict=True))
    class_legend(
        made,
        _limits(accuracy_map),
        f"{percentile_label(accuracy_map)}, {configuration_label(accuracy_map)} "
        f"[{_unit(accuracy_map)[0]}]",
        extra.values(),
    )


def _outline(
    on: Axes, box: Placement, axes_of: tuple[int, int, int], height: float, edge: float
) -> None:
    """Add the outline of a box to a slice that cuts it; for a box with yaw in side view its whole
    extent.
    """
    across, up, other = axes_of
    cos, sin = math.cos(box.yaw), math.sin(box.yaw)
    wide = np.array(
        [
            abs(cos) * box.size[0] + abs(sin) * box.size[1],
            abs(sin) * box.size[0] + abs(cos) * box.size[1],
            box.size[2],
        ]
    )
    if abs(height - box.centre[other]) > max(wide[other], edge) / 2:
        return
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) / 2
    if other == 2:  # noqa: PLR2004 - z: seen from above
        corners = corners * box.size[:2] @ np.array([[cos, sin], [-sin, cos]]) + box.centre[:2]
    else:
        corners = corners * wide[[across, up]] + box.centre[[across, up]]
    on.plot(
        corners[:, 0] * 1e3,
        corners[:, 1] * 1e3,
        color=LIGHT["warn"],
        linewidth=1.6,
        label="best placements",
    )
