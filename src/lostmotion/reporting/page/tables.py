"""Sections of a sheet as HTML tables, for the page and for notebooks."""

from __future__ import annotations

import math
import re
from importlib.resources import files
from typing import TYPE_CHECKING, Final

from lostmotion.reporting.page.text import escaped, foldable, spaced

if TYPE_CHECKING:
    from lostmotion.reporting.sheet import Cell, Section

# A label folds between words where it is longer than this.
_FOLDS_AT: Final = 14
# Letters between the columns of a table, and how much wider bold ones are.
_GAP: Final = 2
_BOLD: Final = 1.1
# States of provenance, which are shown as marks.
_MARKS: Final = ("stated", "assumed", "ideal")
# Words in a cell that are longer than this fold, and their column begins at the left.
_LONG: Final = 24
# In a table of more columns than this a remark has a line of its own: the column of labels is too
# narrow for sentences.
_REMARK_BESIDE: Final = 3


def style() -> str:
    """Return the style of tables outside of a page: those of a notebook."""
    return files(__package__).joinpath("notebook.css").read_text(encoding="utf-8")


def table(section: Section) -> str:
    """Return a section as a table: label and remark, each figure with its interval, and below what
    they were counted from.
    """
    if not section.rows:
        return f"<p>{escaped(section.title)}: {escaped(section.note)}</p>"
    samples = list(
        dict.fromkeys(
            figure.samples for row in section.rows for figure in row.cells if figure.samples
        )
    )
    intervals = section.with_interval
    texts = [
        any(len(row.cells[k].words) > _LONG for row in section.rows)
        for k in range(len(section.columns))
    ]
    head = "".join(
        f'<th scope="col" class="{"long" if of_text else "value"}">{escaped(name)}</th>'
        + ('<th scope="col" class="interval">95 % interval</th>' if interval else "")
        for name, interval, of_text in zip(section.columns, intervals, texts, strict=True)
    )
    columns = 1 + len(section.columns) + sum(intervals)
    body = []
    for row in section.rows:
        shown = zip(row.cells, intervals, texts, strict=True)
        cells = "".join(
            _cells(figure, samples, interval=interval, of_text=of_text)
            for figure, interval, of_text in shown
        )
        note = spaced(row.note)
        if note and columns > _REMARK_BESIDE:
            body.append(
                f'<tr><th scope="row">{foldable(row.label)}</th>{cells}</tr><tr '
                f'class="remark"><td colspan="{columns}"><div>{note}</div></td></tr>'
            )
        else:
            body.append(
                f'<tr><th scope="row">{foldable(row.label)}'
                f"{f'<small>{note}</small>' if note else ''}</th>{cells}</tr>"
            )
    quiet = [spaced(section.note)] if section.note else []
    quiet += [
        f"{f'<sup>{_mark(k)}</sup> ' if len(samples) > 1 else ''}from {spaced(text)}"
        for k, text in enumerate(samples)
    ]
    foot = (
        f'<tfoot><tr><td colspan="{columns}"><div>{"<br>".join(quiet)}</div></td></tr></tfoot>'
        if quiet
        else ""
    )
    return (
        f"<table><caption>{escaped(section.title)}</caption><thead><tr><td></td>{head}</tr></thead>"
        f"<tbody>{''.join(body)}</tbody>{foot}</table>"
    )


def width_of(section: Section) -> int:
    """Return how wide the table of a section is at least, in letters: labels fold between words,
    figures do not.
    """
    words = [
        word
        for row in section.rows
        for word in (row.label[:_FOLDS_AT], *re.split(r"[ ._]", row.label))
    ]
    labels = max(map(len, words), default=0)
    cells = [[row.cells[k] for row in section.rows] for k in range(len(section.columns))]
    figures = sum(
        _BOLD * max((min(len(str(each)), 2 * _LONG) for each in column), default=0) + _GAP
        for column in cells
    )
    intervals = sum(
        max(len(each.interval) for each in column) + _GAP
        for column in cells
        if any(each.interval for each in column)
    )
    return math.ceil(labels + figures + intervals)


def _cells(figure: Cell, samples: list[str], *, interval: bool, of_text: bool) -> str:
    mark = (
        f"<sup>{_mark(samples.index(figure.samples))}</sup>"
        if len(samples) > 1 and figure.samples
        else ""
    )
    beside = f'<td class="interval">{spaced(figure.interval)}</td>' if interval else ""
    if figure.words and not math.isfinite(figure.value):
        kind = " words long" if of_text else " words"
        shown = (
            f'<span class="mark {figure.words}">{figure.words}</span>'
            if figure.words in _MARKS
            else spaced(figure.words)
        )
        return f'<td class="value{kind}">{shown}{mark}</td>{beside}'
    return f'<td class="value">{spaced(str(figure))}{mark}</td>{beside}'


def _mark(index: int) -> str:
    return chr(ord("a") + index)
