"""Plots of an accuracy map: slices, isosurfaces, radial section, share of the workspace by error, error budget by zone."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.workspace_map.cell_statistics import CONFIGURATIONS, QUANTILE
from lostmotion.analyses.workspace_map.radial import radial_section
from lostmotion.analyses.workspace_map.surfaces import level_surface
from lostmotion.analyses.workspace_map.tables.map_labels import configuration_label, percentile_label, size_label
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.plot import BLUE, GREEN, INK, LEGEND, ORANGE, PER_UNIT, RED, Plot, framed, label, named
from lostmotion.reporting.sheet import length

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from lostmotion.analyses.workspace_map.map import WorkspaceMap
    from lostmotion.analyses.workspace_map.placement import Placement
    from lostmotion.spatial import Floats

_SCALE: Final = ((0.0, "#c8df3a"), (0.2, "#5ec962"), (0.4, "#21918c"), (0.6, "#31688e"), (0.8, "#443983"), (1.0, "#2b0040"))
_TONES: Final = ("#b8d433", "#5ec962", "#21918c", "#31688e", "#443983")
# Quantiles over the cells at which isosurfaces are drawn.
_LEVELS: Final = (0.1, 0.3, 0.5, 0.7, 0.9)
# Most cells for isosurfaces; finer grids are thinned to limit the size of the page.
_MOST_CELLS: Final = 60_000
_PARTS_SHOWN: Final = 12
_OF_BY: Final = {"best": GREEN, "mean": BLUE, "worst": ORANGE}
# Width of the plot area, and height of titles and axes, in pixels.
_ACROSS: Final = 470
_AROUND: Final = 140


def map_plots(found: WorkspaceMap, at: Floats | None = None) -> list[Plot]:
    """Return the plots of an accuracy map, in reading order; slices through the point `at` (3,) m, or through the best place."""
    through = found.best_place if at is None else at
    out = []
    for across, up in ((0, 1), (0, 2), (1, 2)):
        if found.reached.grid.shape[across] > 1 and found.reached.grid.shape[up] > 1:
            names = "xyz"[across] + "xyz"[up]
            words = f"Slice of the workspace in the {names[0]}-{names[1]} plane, coloured by the error of each cell."
            out.append(Plot(f"slice-{names}", "map", slice_through(found, across, up, through), words))
    surfaces = surfaces_of_equal_error(found, through)
    if surfaces is not None:
        out.append(Plot("surfaces", "map", surfaces, "Surfaces of equal error in space, the near half cut away."))
    section = radial_plot(found)
    if section is not None:
        out.append(Plot("radial", "map", section, "Error by distance from the first axis and height, over all azimuths."))
    out.append(Plot("share", "within", share_by_error(found), "Share of the workspace within each error."))
    if found.budgets and found.budgets[0].costs:
        out.append(Plot("budget", "budget", budget_by_zone(found), "Bars of each part's share of the mean-square error, by zone."))
    return out


def slice_through(found: WorkspaceMap, across: int, up: int, through: Floats) -> go.Figure:
    """Return a slice of the map through this point (3,), m, spanned by two of the base's axes."""
    grid, names = found.reached.grid, "xyz"
    other = 3 - across - up
    index = int(np.clip(np.floor((through[other] - grid.low[other]) / grid.edge), 0, grid.shape[other] - 1))
    values = np.take(found.selected, index, axis=other)  # axes stay in order: across before up
    x, y = grid.centres_along(across), grid.centres_along(up)
    height = f"{names[other]} = {grid.centres_along(other)[index] * 1e3:.4g} mm"
    traces: list[Any] = [_heat(found, x, y, values, (names[across], names[up]))]
    if found.within_target is not None and np.isfinite(values).any():
        traces.append(_contour(found, x, y, values))
    figure = framed(f"{names[across]}-{names[up]} slice at {height}", *traces, height=420)
    for box in () if found.placements is None else found.placements.best:
        _outline(figure, box, (across, up, other), float(grid.centres_along(other)[index]), grid.edge)
    return _equal(figure, (x, y), grid.edge, f"{names[across]} [mm]", f"{names[up]} [mm]")


def radial_plot(found: WorkspaceMap) -> go.Figure | None:
    """Return the error by distance from the first axis and height; None unless that axis is vertical and turns fully."""
    section = radial_section(found)
    if section is None:
        return None
    edge = found.reached.grid.edge
    figure = framed("Radial section, over all azimuths", _heat(found, section.r, section.z, section.values, ("r", "z")), height=420)
    return _equal(figure, (section.r, section.z), edge, "distance from the first axis [mm]", "z [mm]")


def surfaces_of_equal_error(found: WorkspaceMap, through: Floats) -> go.Figure | None:
    """Return isosurfaces of the error in the half of the workspace beyond the x-z plane through a point; None for a flat workspace."""
    import plotly.graph_objects as go

    grid = found.reached.grid
    if min(grid.shape) < 2:  # noqa: PLR2004 - a surface needs volume
        return None
    step = max(math.ceil((found.selected.size / _MOST_CELLS) ** (1 / 3)), 1)
    cut = int(np.clip(np.floor((through[1] - grid.low[1]) / grid.edge), 0, grid.shape[1] - 2))
    beyond = np.where(found.centre, found.selected, np.nan)[::step, cut::step, ::step]
    values = found.selected[found.centre & np.isfinite(found.selected)]
    unit, factor = _unit(found)
    middles = [grid.centres_along(0)[::step], grid.centres_along(1)[cut::step], grid.centres_along(2)[::step]]
    figure = framed(f"Surfaces of equal error beyond y = {grid.centres_along(1)[cut] * 1e3:.4g} mm", height=580)
    for part, colour in zip(_LEVELS, _TONES, strict=True):
        level = float(np.quantile(values, part))
        vertices, faces = level_surface(beyond, level)
        if len(faces):
            x, y, z = (np.interp(vertices[:, k], np.arange(len(middles[k])), middles[k] * 1e3).astype(np.float32) for k in range(3))
            text = f"{level * factor:.3g} {unit}"
            i, j, k = (faces[:, c].astype(np.int32) for c in range(3))
            mesh = go.Mesh3d(
                x=x, y=y, z=z, i=i, j=j, k=k, color=colour, opacity=0.5, name=text, showlegend=True, hovertemplate=f"{text}<extra></extra>"
            )
            figure.add_trace(mesh)
    for box in () if found.placements is None else found.placements.best[:1]:
        figure.add_trace(_edges(box))
    axis = {"backgroundcolor": "white", "gridcolor": "#dddddd", "linecolor": "#888888", "showline": True, "zeroline": False, "nticks": 6}
    scene = {f"{name}axis": {**axis, "tickfont": {"size": 11}, "title": {"text": f"{name} [mm]", "font": {"size": 13}}} for name in "xyz"}
    figure.update_layout(
        scene={**scene, "aspectmode": "data", "camera": {"eye": {"x": 0.7, "y": -1.9, "z": 0.8}, "center": {"x": 0, "y": 0, "z": -0.05}}},
        legend={**LEGEND, "y": 0, "yanchor": "top", "title": {"text": f"{percentile_label(found)}, {configuration_label(found)}", "side": "top"}},
        margin={"l": 0, "r": 0, "t": 40, "b": 90},
    )
    return figure


def share_by_error(found: WorkspaceMap) -> go.Figure:
    """Return the share of the workspace within each error, for the best, mean and worst configuration."""
    import plotly.graph_objects as go

    unit, factor = _unit(found)
    curves = []
    for k, by in enumerate(CONFIGURATIONS):
        values = found.figures[QUANTILE, k][found.centre]
        values = np.sort(values[np.isfinite(values)]) * factor
        shares = 100 * np.arange(1, len(values) + 1) / len(values)
        thin = np.unique(np.linspace(0, len(values) - 1, min(len(values), 400)).astype(int))
        line = {"color": _OF_BY[by], "width": 2.5 if by == found.by else 1.5, "dash": "solid" if by == found.by else "dash"}
        hover = f"{by}: %{{y:.3~g}} % within %{{x:.4~g}} {unit}<extra></extra>"
        name = "mean over configurations" if by == "mean" else f"{by} configuration"
        curves.append(go.Scatter(x=values[thin], y=shares[thin], mode="lines", line=line, name=name, hovertemplate=hover))
    figure = framed("Share of the workspace by error", *curves, height=400)
    if found.within_target is not None:
        target = found.within_target.target * factor
        figure.add_shape(type="line", x0=target, x1=target, y0=0, y1=1, yref="y domain", line={"color": RED, "width": 1.3, "dash": "dot"})
        text = {"text": "target", "font": {"color": RED, "size": 12}, "showarrow": False, "xanchor": "left", "yanchor": "bottom", "xshift": 4}
        figure.add_annotation(x=target, y=0, yref="y domain", **text)
    figure.update_xaxes(title_text=f"{percentile_label(found)} of the error [{unit}]", rangemode="tozero")
    figure.update_yaxes(title_text="share of the workspace [%]", range=[0, 102])
    figure.update_layout(legend=LEGEND, margin_t=80)
    return figure


def budget_by_zone(found: WorkspaceMap) -> go.Figure:
    """Return each part's share of the mean square (%) in each zone, the largest contributor of the first zone on top."""
    import plotly.graph_objects as go

    first = found.budgets[0].costs[:_PARTS_SHOWN]
    names = [label(short_name(cost.part)) for cost in first]
    bars = []
    for each, colour in zip(found.budgets, (ORANGE, GREEN, BLUE) if len(found.budgets) > 1 else (BLUE,), strict=False):
        shares = {cost.part: 100 * cost.share for cost in each.costs}
        bars.append(
            go.Bar(
                x=[shares[cost.part] for cost in first],
                y=list(range(len(names))),
                orientation="h",
                name=f"{each.zone} (r.m.s. {length(each.rms)})",
                marker={"color": colour},
                hovertemplate=f"{each.zone}: %{{x:.3~g}} %<extra></extra>",
            )
        )
    figure = framed("Share of mean square by part and zone", *bars, height=150 + (16 * len(bars) + 14) * len(names))
    figure.update_xaxes(title_text="share of mean square [%]")
    figure.update_yaxes(**named(names))
    figure.update_layout(barmode="group", bargap=0.25, bargroupgap=0.05, legend=LEGEND, margin_t=60 + 22 * len(bars))
    return figure


def _unit(found: WorkspaceMap) -> tuple[str, float]:
    """Return the unit of all slices, from the largest error."""
    unit = length(float(np.nanmax(found.selected))).unit
    return unit, PER_UNIT[unit]


def _heat(found: WorkspaceMap, x: Floats, y: Floats, values: Floats, names: tuple[str, str]) -> go.Heatmap:
    """Return a heat map of the cells' errors; all share one scale."""
    import plotly.graph_objects as go

    unit, factor = _unit(found)
    title = {"text": f"{percentile_label(found)}, {configuration_label(found)} [{unit}]", "side": "right", "font": {"size": 12}}
    hover = f"{names[0]} %{{x:.0f}}, {names[1]} %{{y:.0f}} mm<br>%{{z:.4~g}} {unit}<extra></extra>"
    return go.Heatmap(
        x=np.round(x * 1e3, 6),
        y=np.round(y * 1e3, 6),
        z=(values.T * factor).astype(np.float32),
        colorscale=[list(stop) for stop in _SCALE],
        zmin=float(np.nanmin(found.selected)) * factor,
        zmax=float(np.nanmax(found.selected)) * factor,
        colorbar={"title": title, "thickness": 12, "outlinewidth": 0, "ticks": "outside", "len": 0.95, "nticks": 7},
        hovertemplate=hover,
        hoverongaps=False,
    )


def _contour(found: WorkspaceMap, x: Floats, y: Floats, values: Floats) -> go.Contour:
    """Return the contour line of the target."""
    import plotly.graph_objects as go

    unit, factor = _unit(found)
    target = 0.0 if found.within_target is None else found.within_target.target * factor
    return go.Contour(
        x=np.round(x * 1e3, 6),
        y=np.round(y * 1e3, 6),
        z=(values.T * factor).astype(np.float32),
        contours={"start": target, "end": target, "size": 1, "coloring": "none"},
        line={"color": "white", "width": 2.5},
        showscale=False,
        showlegend=True,
        name=f"target {target:.4g} {unit}",
        hoverinfo="skip",
        connectgaps=False,
    )


def _outline(figure: go.Figure, box: Placement, axes: tuple[int, int, int], height: float, edge: float) -> None:
    """Add the outline of a box to a slice that cuts it; for a box with yaw in side view its whole extent."""
    across, up, other = axes
    cos, sin = math.cos(box.yaw), math.sin(box.yaw)
    wide = np.array([abs(cos) * box.size[0] + abs(sin) * box.size[1], abs(sin) * box.size[0] + abs(cos) * box.size[1], box.size[2]])
    if abs(height - box.centre[other]) > max(wide[other], edge) / 2:
        return
    if other == 2:  # noqa: PLR2004 - z: seen from above
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) / 2 * box.size[:2]
        corners = corners @ np.array([[cos, sin], [-sin, cos]]) + box.centre[:2]
    else:
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]) / 2 * wide[[across, up]] + box.centre[[across, up]]
    path = "M" + " L".join(f"{x * 1e3:.1f},{y * 1e3:.1f}" for x, y in corners)
    first = not figure.layout.shapes
    figure.add_shape(type="path", path=path, line={"color": RED, "width": 2}, name="best placements", showlegend=first, legendgroup="places")


def _edges(box: Placement) -> go.Scatter3d:
    """Return the twelve edges of a box as one broken line."""
    import plotly.graph_objects as go

    cos, sin = math.cos(box.yaw), math.sin(box.yaw)
    signs = np.array([[a, b, c] for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)])
    corners = (signs / 2 * box.size) @ np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]]) + box.centre
    line: list[list[float | None]] = []
    for i in range(8):
        for j in range(i + 1, 8):
            if np.abs(signs[i] - signs[j]).sum() == 2:  # noqa: PLR2004 - one sign differs
                line += [(corners[i] * 1e3).tolist(), (corners[j] * 1e3).tolist(), [None, None, None]]
    x, y, z = ([point[c] for point in line] for c in range(3))
    name = f"best placement for {size_label(box.size)}"
    return go.Scatter3d(x=x, y=y, z=z, mode="lines", line={"color": RED, "width": 5}, name=name, hoverinfo="skip")


def _equal(figure: go.Figure, middles: tuple[Floats, Floats], edge: float, x_title: str, y_title: str) -> go.Figure:
    """Return the figure with the same scale on both axes, and its height adjusted."""
    spans = [(float(each[0] - edge) * 1e3, float(each[-1] + edge) * 1e3) for each in middles]
    wide, tall = (high - low for low, high in spans)
    figure.update_xaxes(title_text=x_title, range=spans[0], constrain="domain", showgrid=False)
    figure.update_yaxes(title_text=y_title, range=spans[1], scaleanchor="x", scaleratio=1, constrain="domain", showgrid=False)
    legend = {**LEGEND, "font": {"size": 12}, "bgcolor": "#e4e4e4"} if figure.layout.shapes or len(figure.data) > 1 else LEGEND
    height = int(np.clip(_ACROSS * tall / wide + _AROUND, 300, 760))
    figure.update_layout(height=height, legend=legend, margin_t=84, plot_bgcolor="#f3f3f3", font_color=INK)
    return figure
