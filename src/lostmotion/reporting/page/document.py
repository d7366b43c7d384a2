"""Any sheet as one self-contained page with its plots, and the same figures as plain data."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Final

from lostmotion.reporting.layout import plain
from lostmotion.reporting.page.bars import bars_beside
from lostmotion.reporting.page.first_screen import first_screen
from lostmotion.reporting.page.security import policy
from lostmotion.reporting.page.style import style
from lostmotion.reporting.page.tables import table, width_of
from lostmotion.reporting.page.text import escaped, spaced
from lostmotion.reporting.page.viewer import script_elements, scripts
from lostmotion.reporting.plot import FIRST_SCREEN
from lostmotion.reporting.svg import inline_svg

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Section, Sheet

# A table of this width in letters stands in half of the page, on paper too; a wider one takes all
# of it.
_NARROW: Final = 65
# A table of up to this width stands beside a single plot, in the larger part of the page; a wider
# one below it.
_BESIDE: Final = 80
# A table of more rows is closed at first where a plot shows the same figures.
_FEW_ROWS: Final = 9
# Plots that a narrow section has at most.
_ONE: Final = 1


def contents(sheet: Sheet, drawn: Sequence[Plot]) -> dict[str, bytes]:
    """Return the contents of report.html and result.json. Made in memory, so that what fails to be
    made never reaches the disk.
    """
    from lostmotion.version import __version__

    result = json.dumps(
        plain(sheet, __version__), indent=2, sort_keys=True, ensure_ascii=False, allow_nan=False
    )
    return {
        "report.html": page(sheet, drawn, __version__).encode(),
        "result.json": f"{result}\n".encode(),
    }


def page(sheet: Sheet, drawn: Sequence[Plot], version: str) -> str:
    """Return report.html: the answer, key figures, sections with their plots, meaning of the words,
    origin of the figures. No request leaves it.
    """
    links = " ".join(
        f'<a href="#{section.key}">{escaped(section.title)}</a>' for section in sheet.sections
    )
    words = "".join(
        f"<dt>{escaped(word)}</dt><dd>{escaped(meaning)}</dd>" for word, meaning in sheet.words
    )
    explained = (
        (
            '<section id="words" class="wide"><h2>How to read this</h2><dl '
            f'class="words">{words}</dl></section>\n'
        )
        if words
        else ""
    )
    viewed = any(plot.scene is not None for plot in drawn)
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy(scripts() if viewed else ())}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escaped(sheet.name)}: {escaped(sheet.subject)}</title>
<style>{style()}</style>
</head>
<body>
<a class="skip" href="#sections">Skip to the figures</a>
{first_screen(sheet, [plot for plot in drawn if plot.section == FIRST_SCREEN], version)}
<nav aria-label="Sections">{links}{' <a href="#words">How to read this</a>' if words else ""}</nav>
<main id="sections">
{"".join(_section(section, [plot for plot in drawn if plot.section == section.key]) for section in sheet.sections)}{explained}</main>
<footer id="source"><h2>Where it comes from</h2><p>{spaced(f"lostmotion {version}, {sheet.source}")}</p>
<p>{_beside(sheet)}</p></footer>
{script_elements() if viewed else ""}</body>
</html>
"""  # noqa: E501


def _beside(sheet: Sheet) -> str:
    """Return the sentence that names the files beside the page."""
    same = (
        'Beside this page lie the same figures as plain data, <a href="result.json">result.json</a>'
    )
    others = [(sheet.arrays, "arrays.nc", " (NetCDF)"), (sheet.drawing, "profile.dxf", "")]
    return "".join(
        [
            same,
            *(
                f',\nand {escaped(what)}, <a href="{name}">{name}</a>{kind}'
                for what, name, kind in others
                if what
            ),
            ".",
        ]
    )


def _section(section: Section, drawn: list[Plot]) -> str:
    """Return a section: its plots and bars, and its table beside or below them. Narrow sections
    stand in pairs.
    """
    figures = "".join(f'<figure id="plot-{plot.key}">{inline_svg(plot)}</figure>' for plot in drawn)
    width = width_of(section)
    narrow, uneven = width <= _NARROW, _NARROW < width <= _BESIDE and len(drawn) == _ONE
    full = "" if narrow or uneven else " full"
    # A table that is wider than its place scrolls, for which the keyboard has to reach it.
    shown = (
        f'<div class="table{full}" role="group" aria-label="Table: {escaped(section.title)}" '
        f'tabindex="0">{table(section)}</div>'
    )
    if section.folded:
        shown = (
            "<details "
            f'class="folded{full}"><summary>{spaced(section.folded)}</summary>{shown}</details>'
        )
    elif drawn and len(section.rows) > _FEW_ROWS:
        shown = (
            f'<details class="{full.strip()}"><summary>Table of {len(section.rows)} '
            f"rows</summary>{shown}</details>"
        )
    wide = not narrow or len(drawn) > _ONE or bool(section.bars)
    place = (
        "beside with-bars"
        if section.bars
        else "below"
        if not (wide and drawn)
        else "beside uneven"
        if uneven
        else "beside"
    )
    inside = f'<div class="{place}">{figures}{"".join(map(bars_beside, section.bars))}{shown}</div>'
    return (
        f'<section id="{section.key}" '
        f'class="{"wide" if wide else "narrow"}">'
        f"<h2>{escaped(section.title)}</h2>{inside}</section>\n"
    )
