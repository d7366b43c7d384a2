"""Tables of a result as files: CSV with every digit and unit, for programs, or LaTeX with the
digits that are printed, for a thesis.
"""

from __future__ import annotations

import csv
import io
import math
import re
from typing import TYPE_CHECKING, Final, Literal

from lostmotion.reporting.layout import key_of

if TYPE_CHECKING:
    from lostmotion.reporting.sheet import Cell, Section, Sheet

TableKind = Literal["csv", "latex"]
FOLDER: Final = "tables"
_SUFFIX: Final = {"csv": "csv", "latex": "tex"}
_SPECIAL: Final = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
} | {each: f"\\{each}" for each in "&%$#_{}"}
# Where a cell begins with the sign of a formula, in half or full width.
_FORMULA: Final = re.compile(r"(?:^|(?<=[;\t\r\n]))(?=\s*[=+@＝＋－＠-])|^(?=[\t\r\n])")
# Signs that a plain LaTeX document does not know as letters.
_SIGNS: Final = {
    "−": "$-$",
    "≤": r"$\leq$",
    "≥": r"$\geq$",
    "≈": r"$\approx$",
    "×": r"$\times$",
    "±": r"$\pm$",
    "→": r"$\rightarrow$",
    "√": r"$\surd$",
    "µ": r"\textmu{}",
    "°": r"\textdegree{}",
    "′": r"$'$",
    "″": r"$''$",
    "…": r"\ldots{}",
    "²": r"\textsuperscript{2}",
    "³": r"\textsuperscript{3}",
    "⁴": r"\textsuperscript{4}",
    "θ": r"$\theta$",
    "ω": r"$\omega$",
    "σ": r"$\sigma$",
    "<": "$<$",
    ">": "$>$",
    "\N{NARROW NO-BREAK SPACE}": r"\,",
    "\N{NO-BREAK SPACE}": "~",
}


def table_files(sheet: Sheet, kind: TableKind) -> dict[str, bytes]:
    """Return every section of a sheet as the content of a file, by its name in a report's folder:
    `tables/KEY.csv` or `tables/KEY.tex`.
    """
    write = _csv if kind == "csv" else _latex
    return {
        f"{FOLDER}/{key_of(section.key)}.{_SUFFIX[kind]}": write(section).encode()
        for section in sheet.sections
    }


def _csv(section: Section) -> str:
    """Return a section with a row for each of its rows; each column has a value, its unit, and the
    ends of its interval where it has one.
    """
    with_interval = section.with_interval
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    head = ["name"]
    for name, interval in zip(section.columns, with_interval, strict=True):
        head += [name, f"{name}: unit", *([f"{name}: low", f"{name}: high"] if interval else [])]
    rows.writerow(map(_text, [*head, "note"]))
    for row in section.rows:
        cells = [_text(row.label)]
        for figure, interval in zip(row.cells, with_interval, strict=True):
            cells += [
                _text(figure.words) or _number(figure.value),
                "" if figure.words or figure.unit == "1" else _text(figure.unit),
            ]
            cells += [_number(figure.low), _number(figure.high)] if interval else []
        rows.writerow([*cells, _text(row.note)])
    return text.getvalue()


def _text(text: str) -> str:
    """Return a text that a spreadsheet shows and does not compute: an apostrophe stands before the
    sign of a formula, as OWASP advises.

    That is so behind a semicolon and a tabulator too, at which spreadsheets of other languages
    divide a line.
    """
    return _FORMULA.sub("'", text)


def _number(value: float) -> str:
    """Return a number with every digit; empty where it is not known."""
    return repr(float(value)) if math.isfinite(value) else ""


def _latex(section: Section) -> str:
    """Return a section as a floating table for the package booktabs, with its title as caption and
    its key as label.
    """
    with_interval = section.with_interval
    with_note = any(row.note for row in section.rows)
    columns = (
        "l"
        + "".join("rl" if interval else "r" for interval in with_interval)
        + ("l" if with_note else "")
    )
    head = [""]
    for name, interval in zip(section.columns, with_interval, strict=True):
        head += [escaped(name), *([escaped("95 % interval")] if interval else [])]
    lines = [_line([*head, *([""] if with_note else [])])]
    for row in section.rows:
        cells = [escaped(row.label)]
        for figure, interval in zip(row.cells, with_interval, strict=True):
            cells += [_printed(figure), *([escaped(figure.interval)] if interval else [])]
        lines.append(_line([*cells, *([escaped(row.note)] if with_note else [])]))
    body = "\n".join([r"\toprule", lines[0], r"\midrule", *lines[1:], r"\bottomrule"])
    note = f"\n\\par\\smallskip\\footnotesize {escaped(section.note)}" if section.note else ""
    return (
        "% needs \\usepackage{booktabs}\n"
        f"\\begin{{table}}\n\\centering\n\\caption{{{escaped(section.title)}}}\n"
        f"\\label{{tab:{key_of(section.key)}}}\n"
        f"\\begin{{tabular}}{{{columns}}}\n{body}\n\\end{{tabular}}{note}\n\\end{{table}}\n"
    )


def _line(cells: list[str]) -> str:
    return " & ".join(cells) + r" \\"


def _printed(figure: Cell) -> str:
    """Return a figure as it is printed, with a thin space before its unit."""
    text = str(figure)
    return (
        escaped(text) if figure.words else re.sub(r"(?<=\d) (?=\S)", r"\\,", escaped(text), count=1)
    )


def escaped(text: str) -> str:
    """Return a text that LaTeX prints as it stands."""
    return "".join(_SPECIAL.get(each) or _SIGNS.get(each, each) for each in text)
