"""The plot of the error in a zone over that of the whole workspace."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.accuracy.tables.zone import seen_in
from lostmotion.error_model.intervals import pooled_quantile
from lostmotion.propagation.montecarlo.histogram import counts_between, linear_bins
from lostmotion.reporting.plot import BLUE, LEGEND, PER_UNIT, framed, mark
from lostmotion.reporting.sheet import length

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from lostmotion.analyses.accuracy.answer import Answer
    from lostmotion.analyses.accuracy.route import FoundInZone

_GREY: Final = "#9a9a9a"


def errors_in_zone(answer: Answer, zone: FoundInZone) -> go.Figure:
    """Draw the distribution of the error in a zone over that of the workspace, with the zone's 95th percentile."""
    import plotly.graph_objects as go

    inside = seen_in(answer, zone).sampled
    here, whole = inside.replicate_hist.sum(axis=0), answer.sampled.replicate_hist.sum(axis=0)
    edges, _ = linear_bins(here + whole)
    unit = length(float(edges[-1])).unit
    factor = PER_UNIT[unit]

    def steps(hist: np.ndarray, name: str, colour: str, **dress: Any) -> go.Scatter:  # noqa: ANN401 - plotly publishes no types
        share = 100 * counts_between(hist, edges) / hist.sum()
        hover = f"%{{x:.4~g}} {unit}: %{{y:.2f}} % of the samples<extra>{name}</extra>"
        line = {"color": colour, "shape": "hv", "width": 1.6}
        return go.Scatter(x=edges * factor, y=np.append(share, share[-1]), name=name, line=line, hovertemplate=hover, **dress)

    traces = (
        steps(whole, "whole workspace", _GREY, fill="tozeroy", fillcolor="rgba(154,154,154,0.25)"),
        steps(here, "in the zone", BLUE),
    )
    figure = framed("Position error in the zone", *traces, height=400)
    mark(figure, pooled_quantile(inside.group_hist, inside.replicate_hist, 0.95), "95th percentile, in the zone", unit)
    figure.update_xaxes(title_text=f"position error [{unit}]", showgrid=False)
    figure.update_yaxes(title_text=f"samples per {float(edges[1] - edges[0]) * factor:.3g} {unit} [%]", rangemode="tozero")
    figure.update_layout(margin_t=96, showlegend=True, legend={**LEGEND, "y": 1.09})
    return figure
