"""Figures of a result as files for a thesis: SVG with texts as texts, PDF with embedded fonts, or
PNG at 300 dpi; in light colours on white.
"""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any, Final, Literal

from lostmotion.reporting.chart_settings import settings
from lostmotion.reporting.svg import raw_svg, with_plain_fonts

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from lostmotion.reporting.plot import Plot

FigureKind = Literal["svg", "pdf", "png"]
FOLDER: Final = "figures"
_DPI: Final = 300
# Nothing in a file depends on the day or on the version of a library.
_UNDATED: Final[dict[str, dict[str, Any]]] = {
    "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    "png": {"Software": None},
}


def figure_files(drawn: Sequence[Plot], kind: FigureKind) -> dict[str, bytes]:
    """Return every plot as the content of a file, by its name in a report's folder:
    `figures/KEY.svg`.
    """
    return {f"{FOLDER}/{plot.key}.{kind}": figure_bytes(plot.figure, kind) for plot in drawn}


def figure_bytes(figure: Figure, kind: FigureKind, *, dpi: float = _DPI) -> bytes:
    """Return a figure as the content of a file of this kind; a PNG with this many pixels per
    inch.
    """
    if kind == "svg":
        return with_plain_fonts(raw_svg(figure)).encode()
    with settings(), io.BytesIO() as content:
        figure.savefig(
            content, format=kind, dpi=dpi if kind == "png" else figure.dpi, metadata=_UNDATED[kind]
        )
        return content.getvalue()
