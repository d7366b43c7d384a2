"""The plot of the bending of links by cause."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.mechanism.load_causes import CAUSES, OUTBOARD_CAUSES, OWN_WEIGHT
from lostmotion.reporting.plot import LEGEND, OF_CAUSE, framed, label, named

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from lostmotion.analyses.accuracy.answer import Answer


def bending(answer: Answer) -> go.Figure:
    """Draw the largest deflection of each link (µm), stacked by cause; a cause that reduces the bending extends to the left."""
    import plotly.graph_objects as go

    links = answer.bending
    bars = []
    for cause in (OWN_WEIGHT, *CAUSES):
        parts = [bent.by_cause.get(cause, (0.0, 0.0, 0.0))[0] for bent in links]
        if any(parts):
            name = OUTBOARD_CAUSES.get(cause, cause)
            bars.append(
                go.Bar(
                    x=[part * 1e6 for part in parts],
                    y=list(range(len(links))),
                    orientation="h",
                    name=name,
                    marker={"color": OF_CAUSE[cause]},
                    hovertemplate=f"{name}: %{{x:.4~g}} µm<extra></extra>",
                )
            )
    figure = framed("Largest deflection of each link", *bars, height=150 + 40 * len(links))
    figure.update_xaxes(title_text="deflection of the link's tip [µm]")
    figure.update_yaxes(**named([label(bent.joint) for bent in links]))
    figure.update_layout(barmode="relative", bargap=0.35, legend=LEGEND, margin_t=84)
    return figure
