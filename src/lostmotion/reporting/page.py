"""Any sheet as one self-contained page, with its plots; the same figures as plain data; and its tables for notebooks."""

from __future__ import annotations

import html
import json
import re
from typing import TYPE_CHECKING, Final

from lostmotion.reporting.layout import plain
from lostmotion.reporting.palette import css_variables
from lostmotion.reporting.svg import inline_svg

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Card, Figure, Section, Sheet

_TABLES_CSS: Final = """
div.lostmotion{background:#fff;color:#222;padding:4px 8px}
div.lostmotion table{max-width:760px;margin:0 0 16px}
.lostmotion table{border-collapse:collapse;font-size:13px;line-height:1.35;font-variant-numeric:tabular-nums;width:100%;text-align:left}
.lostmotion caption{text-align:left;font-weight:600;font-size:14px;padding:0 0 6px;color:#222}
.lostmotion th,.lostmotion td{padding:4px 10px 4px 0;vertical-align:top;text-align:left;border:0;background:none}
.lostmotion th:last-child,.lostmotion td:last-child{padding-right:0}
.lostmotion thead tr>*{font-weight:600;color:#444;border-bottom:1px solid #888;vertical-align:bottom}
.lostmotion tbody th{font-weight:400;overflow-wrap:anywhere;min-width:7.5em}
.lostmotion tbody th:has(small){min-width:10em}
.lostmotion tbody tr+tr>*{border-top:1px solid #e6e6e6}
.lostmotion td.value{text-align:right;white-space:nowrap;font-weight:600}
.lostmotion thead th.value{text-align:right}
.lostmotion .interval{white-space:nowrap}
.lostmotion td.interval{color:#555}
.lostmotion small{display:block;color:#666;font-size:11.5px;overflow-wrap:anywhere}
.lostmotion sup{color:#777;font-weight:400;font-size:9.5px;line-height:0;margin-left:1px}
.lostmotion tfoot td{color:#666;font-size:11.5px;padding-top:6px;border-top:1px solid #888}
"""
# More columns of figures and intervals than this, and a table stands above its plots.
_BESIDE_A_PLOT: Final = 6
_PAGE_CSS: Final = """
*{box-sizing:border-box}
body{margin:0 auto;max-width:1320px;padding:28px 32px 48px;background:#fff;color:#222;font:15px/1.5 FONT}
h1{font-size:26px;line-height:1.2;margin:0 0 6px;overflow-wrap:anywhere}
h2{font-size:19px;margin:0 0 14px;padding-top:14px;border-top:2px solid #222}
p{margin:0 0 10px;max-width:80ch;overflow-wrap:anywhere}
a{color:#0b5394}
.verdict{font-size:17px}
nav{font-size:13.5px;margin:0 0 20px;color:#666}
nav a{margin-right:14px;white-space:nowrap}
.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(158px,1fr));gap:12px;margin:18px 0 16px;padding:0}
.cards div{border:1px solid #ccc;border-radius:4px;padding:10px 12px;margin:0}
.cards dt{font-size:12.5px;color:#444}
.cards dd{margin:0}
.cards .number{font-size:22px;font-weight:600;line-height:1.35;font-variant-numeric:tabular-nums}
.cards .quiet{font-size:12px;color:#666;overflow-wrap:anywhere}
section{margin:34px 0 0}
section caption{position:absolute;width:1px;height:1px;overflow:hidden;clip-path:inset(50%)}
.pair{display:grid;grid-template-columns:minmax(0,1fr) minmax(0,1fr);gap:26px 36px;align-items:start}
.table{overflow-x:auto}
.table:only-child{grid-column:1/-1}
.pair.long{grid-template-columns:minmax(0,1fr)}
.table:only-child table,.long table{width:min-content;min-width:calc(50% - 18px)}
figure{margin:0;min-width:0;max-width:660px;width:100%}
pre{overflow-x:auto;border:1px solid #ccc;border-radius:4px;padding:10px 12px;font-size:13px;max-width:100ch}
.warn{border-left:3px solid #b23a00;padding-left:10px}
dl.words{display:grid;grid-template-columns:max-content 1fr;gap:5px 18px;margin:0;font-size:14px;max-width:100ch}
dl.words dt{font-weight:600}
dl.words dd{margin:0}
@media (max-width:1000px){body{padding:20px 18px 36px}.pair{grid-template-columns:minmax(0,1fr)}.table:only-child table,.long table{min-width:100%}}
@media (max-width:560px){dl.words{grid-template-columns:1fr;gap:0}dl.words dd{margin-bottom:8px}}
@page{size:A4;margin:16mm 15mm}
@media print{
body{padding:0;max-width:none;font-size:10.5pt}
nav{display:none!important}
.pair{display:block}
figure{margin:10px auto 0;break-inside:avoid}
.table{overflow:visible;break-inside:avoid}
tr,.cards div,dl.words dd,#words,#source{break-inside:avoid}
.lostmotion tfoot{display:table-row-group}
h2{break-after:avoid}
section{margin-top:22px}
}
"""
FONT: Final = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', 'Liberation Sans', Arial, sans-serif"


def contents(sheet: Sheet, drawn: Sequence[Plot]) -> dict[str, bytes]:
    """Return the contents of report.html and result.json. Made in memory, so that what fails to be made never reaches the disk."""
    from lostmotion.version import __version__

    result = json.dumps(plain(sheet, __version__), indent=2, sort_keys=True, ensure_ascii=False, allow_nan=False)
    return {"report.html": page(sheet, drawn, __version__).encode(), "result.json": f"{result}\n".encode()}


def tables(sheet: Sheet) -> str:
    """Show a sheet in a notebook: its tables as compact HTML that needs nothing else."""
    found = "".join(_table(section) for section in sheet.sections)
    warnings = "".join(f"<p><b>Warning:</b> {_text(warning)}</p>" for warning in sheet.warnings)
    return f'<div class="lostmotion"><style>{_TABLES_CSS}</style><p><b>{_text(sheet.name)}</b><br>{_text(sheet.verdict)}</p>{warnings}{found}</div>'


def page(sheet: Sheet, drawn: Sequence[Plot], version: str) -> str:
    """Lay out report.html: verdict, key figures, sections with their plots, what the words mean, where it came from. No request leaves it."""
    policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
    name = _text(sheet.name)
    links = " ".join(f'<a href="#{section.key}">{_text(section.title)}</a>' for section in sheet.sections)
    warnings = "".join(f'<p class="warn" role="alert"><strong>Warning:</strong> {_unbroken(warning)}</p>' for warning in sheet.warnings)
    notes = "".join(f'<p class="warn">{_unbroken(note)}</p>' for note in sheet.notes)
    words = "".join(f"<dt>{html.escape(word, quote=False)}</dt><dd>{html.escape(meaning, quote=False)}</dd>" for word, meaning in sheet.words)
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{name}: {_text(sheet.subject)}</title>
<style>:root{{{css_variables()}--font:{FONT}}}.chart{{max-width:100%;height:auto}}{_PAGE_CSS.replace("FONT", FONT)}{_TABLES_CSS}</style>
</head>
<body class="lostmotion">
<header>
<h1>{name}</h1>
{warnings}
<p class="verdict">{_unbroken(sheet.verdict)}</p>
{"".join(f"<p><b>{_text(word)}</b> {_unbroken(text)}</p>" for word, text in sheet.brief)}
{notes}
{_lines(sheet)}<nav aria-label="Sections">{links} <a href="#words">How to read this</a></nav>
<dl class="cards">{"".join(_card(card) for card in sheet.cards)}</dl>
</header>
<main>
{"".join(_section(section, [plot for plot in drawn if plot.section == section.key]) for section in sheet.sections)}
<section id="words"><h2>How to read this</h2><dl class="words">{words}</dl></section>
</main>
<footer>
<section id="source"><h2>Where it comes from</h2><p>{_text(f"lostmotion {version}, {sheet.source}")}</p>
<p>{_beside(sheet)}</p></section>
</footer>
</body>
</html>
"""


def _lines(sheet: Sheet) -> str:
    return f"<p>{_text(sheet.lines.title)}</p><pre>{_text(sheet.lines.text)}</pre>\n" if sheet.lines else ""


def _beside(sheet: Sheet) -> str:
    """Name the files that lie beside the page."""
    same = 'Beside this page lie the same figures as plain data, <a href="result.json">result.json</a>'
    others = [(sheet.arrays, "arrays.nc", " (NetCDF)"), (sheet.drawing, "profile.dxf", "")]
    return "".join([same, *(f',\nand {_text(what)}, <a href="{name}">{name}</a>{kind}' for what, name, kind in others if what), "."])


def _card(card: Card) -> str:
    number, quiet = _text(card.number), _text(card.quiet)
    return f'<div><dt>{_text(card.title)}</dt><dd class="number">{number}</dd><dd class="quiet">{quiet}</dd></div>'


def _section(section: Section, drawn: list[Plot]) -> str:
    figures = "".join(f'<figure id="plot-{plot.key}">{inline_svg(plot)}</figure>' for plot in drawn)
    table = _table(section)
    long = " long" if len(section.columns) + sum(_with_interval(section)) > _BESIDE_A_PLOT else ""
    pair = f'<div class="pair{long}"><div class="table">{table}</div>{figures}</div>'
    return f'<section id="{section.key}"><h2>{_text(section.title)}</h2>{pair}</section>\n'


def _table(section: Section) -> str:
    """Set a section as a table: label and remark, each figure with its interval, and below what they were counted from."""
    if not section.rows:
        return f"<p>{_text(section.title)}: {_text(section.note)}</p>"
    samples = list(dict.fromkeys(figure.samples for row in section.rows for figure in row.figures if figure.samples))
    with_interval = _with_interval(section)
    head = "".join(
        f'<th scope="col" class="value">{_text(name)}</th>' + ('<th scope="col" class="interval">95 % interval</th>' if interval else "")
        for name, interval in zip(section.columns, with_interval, strict=True)
    )
    body = []
    for row in section.rows:
        note = f"<small>{_text(row.note)}</small>" if row.note else ""
        cells = "".join(_cells(figure, samples, interval=interval) for figure, interval in zip(row.figures, with_interval, strict=True))
        body.append(f'<tr><th scope="row">{_foldable(row.label)}{note}</th>{cells}</tr>')
    quiet = [_text(section.note)] if section.note else []
    quiet += [f"{f'<sup>{_mark(k)}</sup> ' if len(samples) > 1 else ''}from {_text(text)}" for k, text in enumerate(samples)]
    foot = f'<tfoot><tr><td colspan="{1 + len(section.columns) + sum(with_interval)}">{"<br>".join(quiet)}</td></tr></tfoot>' if quiet else ""
    return f"<table><caption>{_text(section.title)}</caption><thead><tr><td></td>{head}</tr></thead><tbody>{''.join(body)}</tbody>{foot}</table>"


def _with_interval(section: Section) -> list[bool]:
    return [any(row.figures[k].interval for row in section.rows) for k in range(len(section.columns))]


def _cells(figure: Figure, samples: list[str], *, interval: bool) -> str:
    mark = f"<sup>{_mark(samples.index(figure.samples))}</sup>" if len(samples) > 1 and figure.samples else ""
    return f'<td class="value">{_text(str(figure))}{mark}</td>' + (f'<td class="interval">{_text(figure.interval)}</td>' if interval else "")


def _mark(index: int) -> str:
    return chr(ord("a") + index)


def _foldable(name: str) -> str:
    """Let a long name of a part fold at its joints, not in mid-word."""
    return re.sub(r"([._])(?=\w{3})", r"\1<wbr>", _text(name))


def _unbroken(sentence: str) -> str:
    """Keep a number and its unit in one line."""
    return re.sub(r"(?<=\d) (?=(?:%|[mµnk]?m|kg|N|°|arcmin|arcsec)(?:\W|$))", "\u00a0", _text(sentence))


def _text(text: str) -> str:
    return html.escape(text)
