"""The plots of a study, one function each: where the arm reaches and errs, how errors spread, which part is to blame, what the drives hold.

Points are thinned by their order, so the same study draws the same plot.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.accuracy.plots.bending import bending
from lostmotion.analyses.accuracy.plots.budget import CAUSES_TEXT, LEVELS_TEXT, at_places, budget, by_level, levels
from lostmotion.analyses.accuracy.plots.waterfall import waterfall
from lostmotion.analyses.accuracy.plots.zone import errors_in_zone
from lostmotion.analyses.accuracy.tables.zone import seen_in
from lostmotion.error_model.intervals import pooled_quantile, pooled_robots_quantile
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.histogram import binned, linear_bins
from lostmotion.reporting.plot import BLUE, GREEN, LEGEND, ORANGE, PER_UNIT, Plot, framed, histogram, label, mark, named, projected, styled
from lostmotion.reporting.sheet import length

if TYPE_CHECKING:
    from collections.abc import Callable

    import plotly.graph_objects as go

    from lostmotion.analyses.accuracy.answer import Answer
    from lostmotion.spatial import Floats

_CLOUD: Final = "#d4d4d4"
_ERROR_SCALE: Final = ((0.0, "#c8df3a"), (0.2, "#5ec962"), (0.4, "#21918c"), (0.6, "#31688e"), (0.8, "#443983"), (1.0, "#2b0040"))
_MOST_CLOUD: Final = 6000
_MOST_POSES: Final = 2000
# Of the longest side of a plot in space, the least that another has.
_LEAST_DEPTH: Final = 0.2
_ROOM: Final = 1.15
_MOST_IN_SPACE: Final = 1500


def plots(answer: Answer) -> list[Plot]:
    """Return the plots of this study. In reading order; AP and RP only where poses were visited twice, a budget only where parts err."""
    drawn: list[tuple[str, str, Callable[[Answer], go.Figure], str]] = [
        ("error-map", "workspace", error_map, "Tool points in space, coloured by mean position error."),
        ("workspace-xoz", "workspace", workspace_xoz, "Workspace projected on the XOZ plane, visited poses coloured by mean position error."),
        ("workspace-xoy", "workspace", workspace_xoy, "Workspace projected on the XOY plane, visited poses coloured by mean position error."),
        ("error-histogram", "error", error_histogram, "Histogram of the position error over the workspace with its 50th, 95th and 99th percentile."),
        ("ap-rp", "iso9283", accuracy_over_robots, "Histograms of AP and RP over the robots with the 95th percentile."),
        ("levels", "levels", lambda answer: levels(answer.budget), LEVELS_TEXT),
        (
            "waterfall",
            "waterfall",
            lambda answer: waterfall(answer.waterfall),
            "Waterfall of the 95th percentile: as manufactured, less the effects of calibration, load compensation and mapping.",
        ),
        ("budget", "budget", budget, "Bars of each part's share of the mean-square error, the largest on top."),
        (
            "causes",
            "causes",
            lambda answer: by_level(answer.budget.causes, "Share of mean square by kind of error"),
            CAUSES_TEXT,
        ),
        ("bending", "bending", bending, "Stacked bars of each link's largest deflection by cause."),
        ("torques", "torques", torques, "Bars of the largest holding torque of each joint, as the base stands and over all tilts of the base."),
    ]
    missing = {"ap-rp"} if answer.sampled.visits < 2 else set()  # noqa: PLR2004 - a scatter needs two
    missing |= set() if answer.sampled.tally.owners else {"levels", "waterfall", "budget", "causes"}
    missing |= set() if answer.bending else {"bending"}
    places = at_places(answer.places)
    for k, zone in enumerate(answer.zones, start=1):
        words = f"Histogram of the position error in the zone {zone.name} over that of the whole workspace."
        places.append(Plot(f"zone-{k}", f"zone_{k}", errors_in_zone(answer, zone), words))
        if answer.sampled.visits > 1:
            inside = accuracy_over_robots(seen_in(answer, zone))
            places.append(Plot(f"zone-{k}-ap-rp", f"zone_{k}_iso9283", inside, f"Histograms of AP and RP over the robots in the zone {zone.name}."))
    return [Plot(key, section, draw(answer), words) for key, section, draw, words in drawn if key not in missing] + places


def workspace_xoz(answer: Answer) -> go.Figure:
    """Draw the workspace from the side, coloured by error. Projection on XOZ, mm."""
    return _projection(answer, 0, 2)


def workspace_xoy(answer: Answer) -> go.Figure:
    """Draw the workspace from above, coloured by error. Projection on XOY, mm."""
    return _projection(answer, 0, 1)


def error_map(answer: Answer) -> go.Figure:
    """Draw the visited tool points (mm) in space, coloured by their mean position error."""
    import plotly.graph_objects as go

    chosen = _thinned(len(answer.poses), _MOST_IN_SPACE)
    at = _mm(answer.tool[chosen])
    error, marker = _coloured(answer, chosen)
    marker["size"] = 3
    points = go.Scatter3d(
        x=at[:, 0],
        y=at[:, 1],
        z=at[:, 2],
        mode="markers",
        marker=marker,
        customdata=error,
        hovertemplate=f"x %{{x:.0f}}, y %{{y:.0f}}, z %{{z:.0f}} mm<br>mean error %{{customdata:.4~g}} {_error_unit(answer)}<extra></extra>",
        showlegend=False,
    )
    figure = framed("Mean error in space", points, height=440)
    axis = {"backgroundcolor": "white", "gridcolor": "#dddddd", "linecolor": "#888888", "showline": True, "zeroline": False, "nticks": 6}
    # A flat arm's plot is given some depth, and no more room than the others', or the camera stands inside it.
    low, high = answer.tool.min(axis=0) * 1e3, answer.tool.max(axis=0) * 1e3
    sides = np.maximum(high - low, max(_LEAST_DEPTH * (high - low).max(), 1e-3))
    ends = np.column_stack([low + high - sides, low + high + sides]) / 2
    room = dict(zip("xyz", (_ROOM * sides / sides.max()).tolist(), strict=True))
    words = {name: {"tickfont": {"size": 11}, "title": {"text": f"{name} [mm]", "font": {"size": 13}}} for name in "xyz"}
    scene = {f"{name}axis": {**axis, **words[name], "range": ends[k].tolist()} for k, name in enumerate("xyz")}
    figure.update_layout(
        scene={
            **scene,
            "aspectmode": "manual",
            "aspectratio": room,
            "camera": {"eye": {"x": 1.5, "y": -1.75, "z": 0.9}, "center": {"x": 0, "y": 0, "z": -0.12}},
        },
        margin={"l": 0, "r": 0, "t": 40, "b": 0},
    )
    return figure


def error_histogram(answer: Answer) -> go.Figure:
    """Draw the histogram of the position error with its 50th, 95th and 99th percentiles and their 95 % intervals."""
    sampled = answer.sampled
    edges, counts = linear_bins(sampled.replicate_hist.sum(axis=0))
    unit = length(float(edges[-1])).unit
    factor = PER_UNIT[unit]
    hover = f"%{{x:.4~g}} {unit} ± half a bin<br>%{{y}} samples, %{{customdata:.2f}} %<extra></extra>"
    bars = histogram(edges * factor, counts, BLUE, hover)
    figure = framed("Position error over the workspace", bars, height=400)
    for k, level in enumerate(kernel.QUANTILES):
        mark(figure, pooled_quantile(sampled.group_hist, sampled.replicate_hist, level), f"{100 * level:.0f}th percentile", unit, row=k)
    figure.update_xaxes(title_text=f"position error [{unit}]", showgrid=False)
    figure.update_yaxes(title_text=f"samples per {float(edges[1] - edges[0]) * factor:.3g} {unit} [1]")
    figure.update_layout(margin_t=96, bargap=0)
    return figure


def accuracy_over_robots(answer: Answer) -> go.Figure:
    """Draw histograms of AP and RP over the robots: each robot's mean over the poses, with the 95th percentile.

    Raises ValueError for a study of a single visit, which has no RP.
    """
    from plotly.subplots import make_subplots

    sampled = answer.sampled
    if sampled.visits < 2:  # noqa: PLR2004 - a scatter needs two
        raise ValueError(f"{sampled.visits} visit to each pose; AP and RP over robots need at least 2")
    figure = styled(make_subplots(rows=1, cols=2, horizontal_spacing=0.14), "AP and RP of simulated robots", height=360)
    for column, name in ((1, "AP"), (2, "RP")):
        values = sampled.robot_means[:, :, column].mean(axis=0)
        unit = length(float(values.max())).unit
        factor = PER_UNIT[unit]
        edges, counts = binned(values, about=max(min(30, round(2 * len(values) ** (1 / 3))), 5))
        hover = f"{name} %{{x:.4~g}} {unit} ± half a bin<br>%{{y}} robots, %{{customdata:.2f}} %<extra></extra>"
        bars = histogram(edges * factor, counts, BLUE if name == "AP" else GREEN, hover)
        figure.add_trace(bars, row=1, col=column)
        figure.update_xaxes(title_text=f"{name} [{unit}]", showgrid=False, nticks=6, row=1, col=column)
        figure.update_yaxes(title_text="robots [1]" if column == 1 else None, row=1, col=column)
        mark(figure, pooled_robots_quantile(sampled.robot_means[:, :, column]), "95th percentile", unit, axes=str(column) if column > 1 else "")
    figure.update_layout(margin_t=76, bargap=0)
    return figure


def torques(answer: Answer) -> go.Figure:
    """Draw the largest holding torque (N m, or force in N) of each joint as the base stands, and over every tilt of the base."""
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    units = [unit for unit in ("N m", "N") if any(held.unit == unit for held in answer.worst_torques)]
    counts = [sum(held.unit == unit for held in answer.worst_torques) for unit in units]
    gap = 74 * (len(units) - 1)  # pixels between two axes, if there are two
    inside = 46 * sum(counts) + gap
    figure = make_subplots(rows=len(units), cols=1, row_heights=counts, vertical_spacing=gap / inside)
    figure = styled(figure, "Largest holding torque" if units == ["N m"] else "Largest holding torque or force", height=inside + 136)
    for row, unit in enumerate(units, start=1):
        held = [one for one in answer.worst_torques if one.unit == unit]
        for name, colour, values, signed in (
            ("as the base stands", BLUE, [abs(one.worst) for one in held], [one.worst for one in held]),
            ("worst over base tilts", ORANGE, [one.over_tilts for one in held], [one.over_tilts for one in held]),
        ):
            bars = go.Bar(
                x=values,
                y=list(range(len(held))),
                orientation="h",
                name=name,
                legendgroup=name,
                showlegend=row == 1,
                marker={"color": colour},
                customdata=signed,
                hovertemplate=f"{name}: %{{customdata:.4~g}} {unit}<extra></extra>",
            )
            figure.add_trace(bars, row=row, col=1)
        figure.update_yaxes(**named([label(one.joint) for one in held]), row=row, col=1)
        figure.update_xaxes(title_text=f"holding {'torque' if unit == 'N m' else 'force'}, magnitude [{unit}]", rangemode="tozero", row=row, col=1)
    figure.update_layout(barmode="group", bargap=0.3, bargroupgap=0.08, legend=LEGEND, margin_t=80)
    return figure


def _projection(answer: Answer, across: int, up: int) -> go.Figure:
    import plotly.graph_objects as go

    cloud = _mm(answer.workspace.points[_thinned(len(answer.workspace.points), _MOST_CLOUD)])
    chosen = _thinned(len(answer.poses), _MOST_POSES)
    visited = _mm(answer.tool[chosen])
    error, marker = _coloured(answer, chosen)
    worst = int(answer.sampled.per_pose[:, kernel.MEAN].argmax())
    names = "XYZ"[across], "XYZ"[up]
    marker["size"] = 4.5
    text = (
        f"{names[0].lower()} %{{x:.0f}} mm, {names[1].lower()} %{{y:.0f}} mm<br>mean error %{{customdata:.4~g}} {_error_unit(answer)}<extra></extra>"
    )
    return projected(
        "Workspace",
        across,
        up,
        _mm(answer.tool[worst]),
        "worst pose",
        worst,
        go.Scatter(x=cloud[:, across], y=cloud[:, up], mode="markers", marker={"size": 3, "color": _CLOUD}, name="reachable", hoverinfo="skip"),
        go.Scatter(x=visited[:, across], y=visited[:, up], mode="markers", marker=marker, name="visited", customdata=error, hovertemplate=text),
    )


def _coloured(answer: Answer, chosen: np.ndarray) -> tuple[Floats, dict[str, Any]]:
    """Return the chosen poses' mean errors in the unit of all, and a marker that colours by them; all maps share one scale."""
    means = answer.sampled.per_pose[:, kernel.MEAN]
    unit = _error_unit(answer)
    error = np.round(means[chosen] * PER_UNIT[unit], 4).astype(np.float32)
    low, high = (float(end) * PER_UNIT[unit] for end in (means.min(), means.max()))
    title = {"text": f"mean error [{unit}]", "side": "right", "font": {"size": 13}}
    bar = {"title": title, "thickness": 12, "outlinewidth": 0, "ticks": "outside", "len": 0.85, "nticks": 7}
    return error, {"color": error, "colorscale": [list(stop) for stop in _ERROR_SCALE], "cmin": low, "cmax": high, "colorbar": bar}


def _error_unit(answer: Answer) -> str:
    return length(float(answer.sampled.per_pose[:, kernel.MEAN].max())).unit


def _thinned(count: int, most: int) -> np.ndarray:
    """Choose at most so many of `count` in equal steps, always the same ones."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).astype(int))


def _mm(metres: Floats) -> Floats:
    return np.asarray(np.round(metres * 1e3, 1), dtype=np.float32)
