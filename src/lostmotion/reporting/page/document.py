"""Any sheet as one self-contained page with its plots, and the same figures as plain data."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Final

from lostmotion.reporting.layout import plain
from lostmotion.reporting.page.first_screen import first_screen
from lostmotion.reporting.page.security import policy
from lostmotion.reporting.page.style import style
from lostmotion.reporting.page.tables import table
from lostmotion.reporting.page.text import escaped, spaced
from lostmotion.reporting.plot import FIRST_SCREEN
from lostmotion.reporting.svg import inline_svg

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Section, Sheet

# With more columns of figures and intervals than this, a section takes the width of the page; with one more, its table stands below its plots.
_NARROW: Final = 4
_BESIDE_A_PLOT: Final = 6
# A table of more rows is closed at first where a plot shows the same figures.
_FEW_ROWS: Final = 9
# Plots that a narrow section has at most.
_ONE: Final = 1


def contents(sheet: Sheet, drawn: Sequence[Plot]) -> dict[str, bytes]:
    """Return the contents of report.html and result.json. Made in memory, so that what fails to be made never reaches the disk."""
    from lostmotion.version import __version__

    result = json.dumps(plain(sheet, __version__), indent=2, sort_keys=True, ensure_ascii=False, allow_nan=False)
    return {"report.html": page(sheet, drawn, __version__).encode(), "result.json": f"{result}\n".encode()}


def page(sheet: Sheet, drawn: Sequence[Plot], version: str) -> str:
    """Return report.html: the answer, key figures, sections with their plots, meaning of the words, origin of the figures. No request leaves it."""
    links = " ".join(f'<a href="#{section.key}">{escaped(section.title)}</a>' for section in sheet.sections)
    words = "".join(f"<dt>{escaped(word)}</dt><dd>{escaped(meaning)}</dd>" for word, meaning in sheet.words)
    explained = f'<section id="words" class="wide"><h2>How to read this</h2><dl class="words">{words}</dl></section>\n' if words else ""
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy(())}">
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
</body>
</html>
"""


def _beside(sheet: Sheet) -> str:
    """Return the sentence that names the files beside the page."""
    same = 'Beside this page lie the same figures as plain data, <a href="result.json">result.json</a>'
    others = [(sheet.arrays, "arrays.nc", " (NetCDF)"), (sheet.drawing, "profile.dxf", "")]
    return "".join([same, *(f',\nand {escaped(what)}, <a href="{name}">{name}</a>{kind}' for what, name, kind in others if what), "."])


def _section(section: Section, drawn: list[Plot]) -> str:
    """Return a section: its plots, and its table beside or below them. Narrow sections stand in pairs."""
    columns = len(section.columns) + sum(section.with_interval)
    figures = "".join(f'<figure id="plot-{plot.key}">{inline_svg(plot)}</figure>' for plot in drawn)
    shown = f'<div class="table">{table(section)}</div>'
    if drawn and len(section.rows) > _FEW_ROWS:
        shown = f"<details><summary>Table of {len(section.rows)} rows</summary>{shown}</details>"
    wide = columns > _NARROW or len(drawn) > _ONE
    place = "beside" if wide and drawn and (columns <= _BESIDE_A_PLOT or len(drawn) > _ONE) else "below"
    inside = f'<div class="{place}">{figures}{shown}</div>'
    return f'<section id="{section.key}" class="{"wide" if wide else "narrow"}"><h2>{escaped(section.title)}</h2>{inside}</section>\n'
