"""A result in a notebook: the answer, the arm in its workspace, five figures and five bars, with
every table folded below.

Styles stand in the elements and the picture is a PNG within the HTML: hosts of notebooks remove
style sheets, scripts and SVG.
"""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING, Final

from lostmotion.reporting.page.tables import style, table
from lostmotion.reporting.page.text import escaped, headline, spaced
from lostmotion.reporting.palette import LIGHT

if TYPE_CHECKING:
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Bar, Bars, Card, Sheet

_MOST: Final = 5
_DPI: Final = 160
_QUIET: Final = f"color:{LIGHT['quiet']};font-size:12px"
_CELL: Final = "border:0;background:none;vertical-align:top;text-align:left;padding:0"


def notebook_bundle(sheet: Sheet, picture: Plot | None) -> dict[str, str]:
    """Return a result by media type: one line of text, HTML that needs nothing else, and the
    picture by itself where there is one.
    """
    png = "" if picture is None else _png(picture)
    found = {
        "text/plain": f"{sheet.name}: {sheet.verdict}" if sheet.verdict else sheet.name,
        "text/html": _html(sheet, picture, png),
    }
    return {**found, "image/png": png} if png else found


def _png(picture: Plot) -> str:
    from lostmotion.reporting.figure_files import figure_bytes

    return base64.b64encode(figure_bytes(picture.figure, "png", dpi=_DPI)).decode("ascii")


def _html(sheet: Sheet, picture: Plot | None, png: str) -> str:
    answer, rest = headline(sheet.verdict) if sheet.verdict else ("", "")
    answer = answer.replace("<em>", '<em style="font-style:normal">')
    warnings = "".join(
        f'<p style="color:{LIGHT["warn"]}"><b>Warning:</b> {spaced(warning)}</p>'
        for warning in sheet.warnings
    )
    tables = (
        "<div "
        f'class="lostmotion"><style>{style()}</style>{"".join(map(table, sheet.sections))}</div>'
    )
    figures = f"{_numbers(sheet.cards)}{''.join(map(_bars, sheet.bars[:1]))}"
    if picture is not None:
        shown = (
            f'<img src="data:image/png;base64,{png}" alt="{escaped(picture.words)}" '
            'style="width:100%;max-width:560px">'
        )
        figures = (
            '<table class="lostmotion-figures" style="border:0;width:100%"><tr '
            f'style="background:none"><td style="{_CELL};width:57%">{shown}</td>'
            f'<td style="{_CELL};padding-left:16px">{figures}</td></tr></table>'
        )
    if sheet.bars:
        tables = f'<details><summary style="{_QUIET}">Every figure</summary>{tables}</details>'
    opening = (
        f'<p style="margin:2px 0 10px"><b style="font-size:16px">{answer}</b> {rest}</p>'
        if answer
        else ""
    )
    return (
        f'<div style="background:{LIGHT["paper"]};color:{LIGHT["ink"]};padding:10px '
        "14px;max-width:1000px;"
        f'font:14px/1.4 system-ui,sans-serif">'
        f'<p style="margin:0"><b>{escaped(sheet.name)}</b> <span '
        f'style="{_QUIET}">{spaced(sheet.about or sheet.counts)}</span></p>'
        f"{opening}{warnings}{figures}{tables}</div>"
    )


def _numbers(cards: tuple[Card, ...]) -> str:
    if not cards:
        return ""
    lines = "".join(
        '<tr style="background:none"><td '
        f'style="{_CELL};padding-right:10px;text-align:right;white-space:nowrap"><b>{spaced(card.number)}</b></td>'
        f'<td style="{_CELL}">{spaced(card.title)}</td></tr>'
        for card in cards[:_MOST]
    )
    return f'<table class="lostmotion-figures" style="border:0;margin:0 0 10px">{lines}</table>'


def _bars(block: Bars) -> str:
    lines = "".join(_line(bar, block) for bar in block.bars[:_MOST])
    head = f'<b>{spaced(block.title)}</b> <span style="{_QUIET}">{spaced(block.column)}</span>'
    return (
        f'<p style="margin:0 0 2px">{head}</p><table class="lostmotion-figures" '
        f'style="border:0;width:100%;margin:0 0 10px">{lines}</table>'
    )


def _line(bar: Bar, block: Bars) -> str:
    """Return one bar from the zero of the block's scale, to the left where it is negative."""
    low, high = block.ends
    left, width = (
        100 * (min(0.0, bar.size) - low) / (high - low),
        100 * abs(bar.size) / (high - low),
    )
    drawn = (
        "<div "
        f'style="margin-left:{left:.1f}%;width:{width:.1f}%;height:10px;background:{LIGHT["robot"]}"></div>'
    )
    return (
        '<tr style="background:none"><td '
        f'style="{_CELL};padding-right:8px;white-space:nowrap">{escaped(bar.label)}</td>'
        f'<td style="{_CELL};width:60%;padding-top:5px">{drawn}</td>'
        "<td "
        f'style="{_CELL};padding-left:8px;text-align:right;white-space:nowrap">{spaced(str(bar.figure))}</td></tr>'
    )
