"""A chart as SVG text within a page: its colours are CSS variables, its letters are text, and the
same figure gives the same bytes.
"""

from __future__ import annotations

import html
import io
import re
import warnings
from typing import TYPE_CHECKING, Any, Final

from lostmotion.reporting.chart_settings import settings
from lostmotion.reporting.palette import LIGHT

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

    from lostmotion.reporting.plot import Plot

_UNDATED: Final[dict[str, Any]] = {"Date": None, "Creator": None, "Format": None, "Type": None}
_COLOUR: Final = re.compile(r"#[0-9a-f]{6}")
_FAMILY: Final = re.compile(r"font-family: [^;\"]*(?:; )?|; font-family: [^;\"]*(?=\")")
# Attributes that hold coordinates.
_COORDINATES: Final = re.compile(r' (d|transform|x|y|width|height|points)="([^"]*)"')
_NUMBER: Final = re.compile(r"-?\d+\.\d+(?:e-?\d+)?")
_REFERENCE: Final = re.compile(r'(?:url\(#|href="#)([^")]+)')
_PLACES: Final = 2
# Text between tags, and what stands for it while the markup is changed.
_CONTENT: Final = re.compile(r"(?<=>)[^<>]*[^<>\s][^<>]*(?=<)")
_HELD: Final = "\x00"


def inline_svg(plot: Plot) -> str:
    """Return the plot as an SVG element for a page, described by its words, with identifiers that
    start with its key.
    """
    text = raw_svg(plot.figure)
    text = text[text.index("<svg") :].strip()
    text = re.sub(
        r"<metadata>.*?</metadata>|<!--.*?-->|<style[^>]*>.*?</style>", "", text, flags=re.DOTALL
    )
    box = re.search(r'viewBox="([^"]+)"', text)
    sides = box[1].split() if box else ["0", "0", "1", "1"]
    width, height = (round(float(side) * 4 / 3) for side in sides[2:])  # pt to px
    head = (
        f'<svg class="chart" role="img" aria-label="{html.escape(plot.words)}" '
        f'viewBox="{" ".join(sides)}" width="{width}" height="{height}" '
        'style="font-family: var(--font)" stroke-linejoin="round" stroke-linecap="butt" '
        'xmlns="http://www.w3.org/2000/svg">'
    )
    return _with_texts_kept(text, lambda markup: _on_page(markup, head, plot.key))


def _on_page(markup: str, head: str, key: str) -> str:
    """Return the markup of a chart with this opening tag, in the colours of the page, rounded and
    with identifiers of its own.
    """
    markup = re.sub(r"<svg [^>]*>", lambda _: head, _FAMILY.sub("", markup), count=1)
    markup = _own_identifiers(markup, key)
    markup = _COORDINATES.sub(_rounded, markup)
    names = {colour: name for name, colour in LIGHT.items()}
    markup = re.sub(
        r'style="[^"]*"',
        lambda style: _COLOUR.sub(lambda each: f"var(--{names[each[0]]})", style[0]),
        markup,
    )
    markup = re.sub(r' transform="rotate\(-?0 [^)]*\)"|<defs>\s*</defs>', "", markup)
    return _without_groups(re.sub(r"\s*\n\s*", "\n", markup))


def _with_texts_kept(text: str, changed: Callable[[str], str]) -> str:
    """Return SVG text whose markup alone is changed: a name from a user's file may look like an
    attribute.
    """
    texts: list[str] = []

    def held(content: re.Match[str]) -> str:
        texts.append(content[0])
        return _HELD

    markup = changed(_CONTENT.sub(held, text))
    kept = iter(texts)
    return re.sub(_HELD, lambda _: next(kept), markup)


def raw_svg(figure: Figure) -> str:
    """Return a figure as matplotlib writes it, in its own colours and with its texts as texts; no
    clock is read.
    """
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    canvas: Any = FigureCanvasSVG(figure)
    with settings(), warnings.catch_warnings(), io.BytesIO() as content:
        # the reader's own fonts show the texts
        warnings.filterwarnings("ignore", "Glyph .* missing from font", UserWarning)
        canvas.print_svg(content, metadata=_UNDATED)  # `savefig` would draw everything twice
        return content.getvalue().decode()


def with_plain_fonts(text: str) -> str:
    """Return SVG text in fonts that most machines have, in place of matplotlib's own."""
    plain = "font-family: Arial, Helvetica, 'Liberation Sans', sans-serif"
    return _with_texts_kept(text, lambda markup: re.sub(r"font-family: [^;\"]*", plain, markup))


def _without_groups(text: str) -> str:
    """Remove the groups that have no attribute, with their ends."""
    kept: list[bool] = []

    def group(tag: re.Match[str]) -> str:
        if tag[0] != "</g>":
            kept.append(tag[0] != "<g>")
            return tag[0] if kept[-1] else ""
        return tag[0] if kept.pop() else ""

    return re.sub(r"\n{2,}", "\n", re.sub(r"<g(?: [^>]*)?>|</g>", group, text))


def _own_identifiers(text: str, key: str) -> str:
    """Put the plot's key before identifiers that are referred to, and remove the others: several
    plots share one page.
    """
    used = set(_REFERENCE.findall(text))
    text = re.sub(
        r' id="([^"]*)"', lambda own: f' id="{key}-{own[1]}"' if own[1] in used else "", text
    )
    text = re.sub(r"url\(#", f"url(#{key}-", text)
    return re.sub(r'(?:xlink:)?href="#', f'href="#{key}-', text)


def _rounded(attribute: re.Match[str]) -> str:
    """Return an attribute with its coordinates to 0.01 pt and without the spaces that SVG does not
    need.
    """
    shorter = _NUMBER.sub(_short, attribute[2])
    if attribute[1] == "d":
        shorter = re.sub(r"\s*([A-Za-z])\s*", r"\1", shorter).strip()
    return f' {attribute[1]}="{shorter}"'


def _short(number: re.Match[str]) -> str:
    text = f"{float(number[0]):.{_PLACES}f}".rstrip("0").rstrip(".")
    return "0" if text in {"-0", ""} else text
