"""What every plot shares: its colours, its dress, and the pieces that several are made of. Plotly is loaded when a plot is drawn."""

from __future__ import annotations

import html
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    import plotly.graph_objects as go
    from matplotlib.figure import Figure

    from lostmotion.spatial import Floats

# Colours that colour-blind readers distinguish, also in grey print (M. Okabe, K. Ito 2008); the scale is viridis, dark where the error is large.
BLUE: Final = "#0072B2"
ORANGE: Final = "#E69F00"
GREEN: Final = "#009E73"
RED: Final = "#B23A00"
# Colours of loads by cause.
OF_CAUSE: Final = {
    "payload": BLUE,
    "process force": RED,
    "tool": "#999999",
    "links": GREEN,
    "joints and drives": ORANGE,
    "own weight": "#CC79A7",
}
INK: Final = "#222222"
FONT: Final = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', 'Liberation Sans', Arial, sans-serif"

_LONGEST_LABEL: Final = 36
PER_UNIT: Final = {"µm": 1e6, "mm": 1e3, "m": 1.0}
LEGEND: Final = {"orientation": "h", "x": 0, "y": 1, "yanchor": "bottom", "traceorder": "normal", "itemsizing": "constant"}
_LINE: Final = {"showline": True, "linecolor": "#666666", "ticks": "outside", "tickcolor": "#666666", "ticklen": 4, "ticklabelstandoff": 3}
_GRID: Final = {"gridcolor": "#e8e8e8", "zeroline": False, "automargin": True, "title": {"standoff": 8, "font": {"size": 13}}}


@dataclass(frozen=True)
class Plot:
    """A drawn plot: the section whose figures it shows, a key for file names, and what it shows in words for those who cannot see it."""

    key: str
    section: str
    figure: Figure | go.Figure
    words: str


def framed(title: str, *traces: Any, height: int) -> go.Figure:  # noqa: ANN401 - plotly publishes no types
    """Draw traces in a figure dressed for print."""
    import plotly.graph_objects as go

    return go.Figure(list(traces), {**_dress(title, height), "xaxis": {**_LINE, **_GRID}, "yaxis": {**_LINE, **_GRID}})


def projected(title: str, across: int, up: int, marked: Floats, words: str, number: int, *traces: Any) -> go.Figure:  # noqa: ANN401
    """Draw tool points projected along one axis, both axes to one scale, with one pose ringed: `marked` (3,) mm, its name and its number."""
    import plotly.graph_objects as go

    ring = {"size": 13, "symbol": "circle-open", "color": RED, "line": {"width": 2}}
    hover = f"{words}, number {number}<extra></extra>"
    names = "XYZ"[across], "XYZ"[up]
    at = {"x": marked[[across]], "y": marked[[up]]}
    figure = framed(
        f"{title} on {names[0]}O{names[1]}", *traces, go.Scatter(**at, mode="markers", marker=ring, name=words, hovertemplate=hover), height=520
    )
    figure.update_xaxes(title_text=f"{names[0].lower()} [mm]")
    figure.update_yaxes(title_text=f"{names[1].lower()} [mm]", scaleanchor="x", scaleratio=1)
    figure.update_layout(legend=LEGEND, margin_t=80)
    return figure


def styled(figure: go.Figure, title: str, *, height: int) -> go.Figure:
    """Dress a figure for print: white, one font, a light grid, nothing else."""
    figure.update_layout(_dress(title, height))
    figure.update_xaxes(**_LINE, **_GRID)
    figure.update_yaxes(**_LINE, **_GRID)
    return figure


def _dress(title: str, height: int) -> dict[str, Any]:
    """Return the layout that every plot shares."""
    return {
        "template": "none",
        "title": {"text": title, "x": 0, "y": 1, "xref": "container", "yref": "container", "pad": {"t": 10, "l": 4}, "font": {"size": 15}},
        "font": {"family": FONT, "size": 13, "color": INK},
        "height": height,
        "margin": {"l": 60, "r": 16, "t": 52, "b": 56},
        "hoverlabel": {"font": {"family": FONT}},
    }


def histogram(edges: Floats, counts: np.ndarray, colour: str, hover: str) -> go.Bar:
    """Draw counts between edges (already in the unit shown) as bars that touch."""
    import plotly.graph_objects as go

    middles, width = (edges[:-1] + edges[1:]) / 2, float(edges[1] - edges[0])
    marker = {"color": colour, "line": {"color": "white", "width": 0.5}}
    share = 100 * counts / counts.sum()
    return go.Bar(x=middles, y=counts, width=width, marker=marker, customdata=share, hovertemplate=hover, showlegend=False)


def named(names: Sequence[str]) -> dict[str, Any]:
    """Write these names beside bars at 0, 1, 2 …, the first on top."""
    count = len(names)
    return {"tickvals": list(range(count)), "ticktext": list(names), "range": [count - 0.5, -0.5], "showgrid": False, "showline": False, "ticks": ""}


def label(name: str) -> str:
    """Make a name of the arm safe to draw: plotly reads mark-up in its texts."""
    return html.escape(name if len(name) <= _LONGEST_LABEL else name[: _LONGEST_LABEL - 1] + "…")
