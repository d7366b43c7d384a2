"""The plots of a cycloidal gearbox by its drawing: profile, lobe loads, scatter of the play, compliance, transmission error and its spectrum."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.gearbox.cycloidal import SHOWN
from lostmotion.analyses.gearbox.plots.profile import profile
from lostmotion.error_model.intervals import robots_quantile
from lostmotion.propagation.montecarlo.histogram import binned
from lostmotion.reporting.plot import BLUE, GREEN, LEGEND, ORANGE, RED, Plot, framed, histogram, named, styled
from lostmotion.reporting.sheet import ARCMIN, ARCSEC

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from lostmotion.analyses.gearbox.cycloidal import Lobes, Transmission
    from lostmotion.analyses.gearbox.gear import GearStudy
    from lostmotion.spatial import Floats

_COLOURS: Final = (BLUE, ORANGE, GREEN, RED)
_MOST_HARMONICS: Final = 24


def drawing_plots(study: GearStudy) -> list[Plot]:
    """Return the plots of the drawing. Raises ValueError for a gearbox without one."""
    drawn = study.drawn
    if drawn is None:
        raise ValueError("a gearbox by stated figures has no drawing")
    counted = f"{study.count} simulated gearboxes"
    out = [
        Plot("profile", "geometry", profile(study), "Discs and ring at true scale, with the pitch point and the force on each lobe as an arrow."),
        Plot("lobe-loads", "lobes", lobe_loads(drawn.lobes), "Load and peak pressure of each lobe over its angle from the line of centres."),
        Plot("play", "built", spread(drawn.play, "Play", counted, BLUE), f"Histogram of the play of {counted}."),
        Plot("lost-motion", "built", spread(drawn.lost_motion, "Lost motion", counted, GREEN), f"Histogram of the lost motion of {counted}."),
    ]
    if drawn.members:
        out.append(Plot("members", "members", members(drawn.members), "Bars of the wind-up through each member, the largest first."))
    if drawn.transmission.amplitude.any():
        out.append(Plot("error", "transmission", error(drawn.transmission), "Transmission error of a few gearboxes over a turn of the crank."))
        out.append(
            Plot("spectrum", "transmission", spectrum(drawn.transmission), "Amplitude of each harmonic over its cycles per turn of the output.")
        )
    return out


def lobe_loads(cases: tuple[Lobes, ...]) -> go.Figure:
    """Draw force and pressure of each lobe over its angle from the line of centres, at crank angle zero."""
    import plotly.graph_objects as go
    from plotly.subplots import make_subplots

    figure = styled(make_subplots(rows=2, cols=1, shared_xaxes=True, vertical_spacing=0.08), "Load of the lobes of one disc", height=480)
    for case, colour in zip(cases, _COLOURS, strict=False):
        order = np.argsort(case.theta)
        at = np.degrees(case.theta[order])
        name = f"share {case.share:.3g} of the torque"
        for row, values, unit in ((1, case.force, "N"), (2, case.peak / 1e9, "GPa")):
            bars = go.Bar(
                x=np.round(at, 4),
                y=values[order],
                name=name,
                legendgroup=name,
                showlegend=row == 1 and len(cases) > 1,
                marker={"color": colour},
                hovertemplate=f"{name}<br>θ = %{{x:.1f}}°: %{{y:.4~g}} {unit}<extra></extra>",
            )
            figure.add_trace(bars, row=row, col=1)
    loaded = np.abs(np.degrees(cases[0].theta[np.max([case.force for case in cases], axis=0) > 0]))
    middle = 1.0 if cases[0].theta[cases[0].force.argmax()] > 0 else -1.0
    step = 360 / len(cases[0].theta)
    ends = sorted((middle * max(float(loaded.min()) - 1.5 * step, -step), middle * (float(loaded.max()) + 1.5 * step)))
    figure.update_xaxes(range=ends, showgrid=False)
    figure.update_xaxes(title_text="θ, angle from the line of centres [deg]", row=2, col=1)
    figure.update_yaxes(title_text="load [N]", row=1, col=1)
    figure.update_yaxes(title_text="peak pressure [GPa]", row=2, col=1)
    figure.update_layout(barmode="group", legend=LEGEND, margin_t=84)
    return figure


def spread(values: Floats, name: str, counted: str, colour: str) -> go.Figure:
    """Draw the scatter of manufactured samples: a histogram with mean and 5, 50 and 95 % quantiles."""
    shown = values / ARCMIN
    even = float(np.ptp(shown)) <= 1e-9 * max(float(np.abs(shown).max()), 1.0)
    wide = max(0.01 * abs(float(shown[0])), 1e-3)
    edges, counts = (shown[0] + wide * np.array([-0.5, 0.5]), np.array([len(shown)])) if even else binned(shown, about=40)
    bars = histogram(edges, counts, colour, "%{x:.3~g} arcmin ± half a bin<br>%{y} gearboxes, %{customdata:.2f} %<extra></extra>")
    figure = framed(f"{name} of {counted}", bars, height=320)
    marks = [(float(shown.mean()), "mean", 1)]
    marks += [(float(robots_quantile(shown, level)[0]), f"{100 * level:.0f} %", 0) for level in (0.05, 0.5, 0.95)]
    for value, word, row in marks:
        figure.add_vline(x=value, line={"color": RED, "width": 1.3, "dash": "dot" if word != "mean" else "solid"})
        figure.add_annotation(
            x=value, y=1 + 0.075 * row, yref="paper", yanchor="bottom", text=f"{word} {value:.3g}", showarrow=False, font={"color": RED, "size": 12}
        )
    figure.update_xaxes(title_text=f"{name.lower()} [arcmin]", showgrid=False)
    figure.update_yaxes(title_text=f"gearboxes per {float(edges[1] - edges[0]):.3g} arcmin [1]")
    figure.update_layout(margin_t=92, bargap=0)
    return figure


def members(found: dict[str, float]) -> go.Figure:
    """Draw the compliance by member."""
    import plotly.graph_objects as go

    values = [angle / ARCMIN for angle in found.values()]
    whole = sum(values)
    bars = go.Bar(
        x=values,
        y=list(range(len(values))),
        orientation="h",
        marker={"color": BLUE},
        text=[f"{value:.3g}′, {100 * value / whole:.2g} %" for value in values],
        textposition="outside",
        cliponaxis=False,
        customdata=list(found),
        hovertemplate="%{customdata}: %{x:.4~g} arcmin<extra></extra>",
    )
    figure = framed("Wind-up by member", bars, height=110 + 26 * len(values))
    figure.update_yaxes(**named(list(found)))
    figure.update_xaxes(title_text="wind-up [arcmin]", range=[0, 1.22 * max(values)])
    return figure


def error(found: Transmission) -> go.Figure:
    """Draw the transmission error of a few gearboxes over a turn of the crank, under the torque."""
    import plotly.graph_objects as go

    crank = np.round(np.degrees(found.crank), 4)
    traces = [
        go.Scatter(
            x=crank,
            y=np.round(found.errors[-1, :, k] / ARCSEC, 7),
            mode="lines",
            name=f"gearbox {k + 1}",
            line={"color": _COLOURS[k], "width": 1.4},
            hovertemplate=f"gearbox {k + 1}<br>crank %{{x:.4~g}}°: %{{y:.3~g}} arcsec<extra></extra>",
        )
        for k in range(min(SHOWN, found.errors.shape[-1]))
    ]
    figure = framed(f"Transmission error, {found.loads[-1]:.4g} N m", *traces, height=340)
    figure.update_xaxes(title_text="crank angle [deg]", dtick=60, range=[0, 360])
    figure.update_yaxes(title_text="transmission error of the output [arcsec]")
    figure.update_layout(legend=LEGEND, margin_t=84)
    return figure


def spectrum(found: Transmission) -> go.Figure:
    """Draw the lowest harmonics of the transmission error, under a light load and under the torque."""
    import plotly.graph_objects as go

    seen = found.cycles[: max(_MOST_HARMONICS, int(np.flatnonzero(found.amplitude.max(axis=0) > 0.2 * found.amplitude.max())[-1]) + 1)]
    traces: list[Any] = [
        go.Bar(
            x=seen,
            y=found.amplitude[k, : len(seen)] / ARCSEC,
            name=f"{load:.4g} N m",
            width=[0.4 * float(found.cycles[0])] * len(seen),
            offset=(k - 1) * 0.4 * float(found.cycles[0]),
            marker={"color": _COLOURS[1 - k]},
            hovertemplate=f"{load:.4g} N m<br>%{{x:.6~g}} per turn: %{{y:.3~g}} arcsec<extra></extra>",
        )
        for k, load in enumerate(found.loads)
    ]
    figure = framed("Spectrum of the transmission error", *traces, height=340)
    step = float(found.cycles[0]) * max(1, math.ceil(len(seen) / 10))
    figure.update_xaxes(
        title_text="cycles per turn of the output [1]", tick0=0, dtick=step, showgrid=False, range=[0, float(seen[-1] + found.cycles[0])]
    )
    figure.update_yaxes(title_text="amplitude, rms over gearboxes [arcsec]", rangemode="tozero")
    figure.update_layout(legend=LEGEND, margin_t=84)
    return figure
