"""Layout of result.json: figures by stable keys, tables as they are printed, and the JSON Schema of
both.

`figures.error.p95.value` is the 95th percentile of section `error`, with `unit`, `low` and `high`.
A row of a table with several columns has one level more: `figures.budget.A_bearing.share.value`.
Keys do not change with the words of a table: a row has a key of its own where its label is a
phrase, else the key follows from the label, which is a name from the user's file or a term of the
field.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from typing import TYPE_CHECKING, Any, Final

from lostmotion.error_model.intervals import Estimate

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from lostmotion.reporting.sheet import Cell, Row, Section, Sheet

# Changes where a key changes or goes; keys may be added without.
LAYOUT: Final = 4
_PERCENTILE: Final = re.compile(
    r"([0-9]+(?:\.[0-9]+)?)(?: %(?: of [a-z]+)?(?: are)? below|(?:th|st|nd|rd) percentile)"
    r"|^([0-9]+) %$"
)


def key_of(label: str) -> str:
    """Return the key of a label: its letters and digits, "p95" for the 95th percentile or a column
    "95 %", with "_" between words.
    """
    text = _PERCENTILE.sub(r"p\1\2", label).replace("r.m.s.", "rms")
    return re.sub(r"\W+", "_", text).strip("_") or "value"


def figures_by_key(sections: Iterable[Section]) -> dict[str, Any]:
    """Return every figure of a sheet by section, row and, where a table has several columns,
    column.
    """
    return {section.key: _rows(section) for section in sections}


def estimates_by_key(sections: Iterable[Section]) -> Iterator[tuple[str, str, Estimate]]:
    """Yield every figure with its keys joined by dots, what it is in words, and its value with
    ends and SI unit; not those that are words alone.
    """
    for section in sections:
        columns = _each_once([key_of(name) for name in section.columns])
        keys = _each_once([row.key or key_of(row.label) for row in section.rows])
        for key, row in zip(keys, section.rows, strict=True):
            for column, name, each in zip(columns, section.columns, row.cells, strict=True):
                if each.words and not math.isfinite(each.value):
                    continue
                alone = columns == ["value"]
                yield (
                    ".".join([section.key, key, *([] if alone else [column])]),
                    row.label if alone else f"{row.label}, {name}",
                    Estimate(each.value, each.low, each.high, unit=each.unit, bound=each.bound),
                )


def row_at(sections: Iterable[Section], section: str, row: str) -> Row | None:
    """Return the row of this section by its key, or by that of its label. None where there is
    none.
    """
    return next(
        (
            each
            for of in sections
            if of.key == section
            for each in of.rows
            if row in {each.key, key_of(each.label)}
        ),
        None,
    )


def _rows(section: Section) -> dict[str, Any]:
    columns = [key_of(name) for name in section.columns]
    keys = _each_once([row.key or key_of(row.label) for row in section.rows])
    return {key: _row(row, columns) for key, row in zip(keys, section.rows, strict=True)}


def _row(row: Row, columns: list[str]) -> dict[str, Any]:
    if columns == ["value"]:
        return figure_data(row.cells[0])
    return {
        name: figure_data(figure)
        for name, figure in zip(_each_once(columns), row.cells, strict=True)
    }


def _each_once(keys: list[str]) -> list[str]:
    """Number keys that occur several times, from the second on."""
    seen: Counter[str] = Counter()
    out = []
    for key in keys:
        seen[key] += 1
        out.append(key if seen[key] == 1 else f"{key}_{seen[key]}")
    return out


def figure_data(figure: Cell) -> dict[str, Any]:
    """Return one figure as plain data; null where there is no finite number."""
    value, low, high = (
        each if math.isfinite(each) else None for each in (figure.value, figure.low, figure.high)
    )
    return {
        "value": value,
        "unit": None if figure.words and value is None else figure.unit,
        "low": low,
        "high": high,
        "interval": None if low is None and high is None else figure.ends,
        "samples": figure.samples,
        "display": figure.display,
        **({"bound": figure.bound} if figure.bound else {}),
        **({"words": figure.words} if figure.words else {}),
    }


def plain(sheet: Sheet, version: str) -> dict[str, Any]:
    """Return every printed figure as plain data for result.json: no clock time, so that two runs
    can be compared byte by byte.
    """
    return {
        "lostmotion": version,
        "layout": LAYOUT,
        **sheet.facts,
        "answer": sheet.verdict,
        "brief": [{"title": word, "text": sentence} for word, sentence in sheet.brief],
        "warnings": list(sheet.warnings),
        "notes": list(sheet.notes),
        **(
            {"lines": {"title": sheet.lines.title, "text": sheet.lines.text}} if sheet.lines else {}
        ),
        "figures": figures_by_key(sheet.sections),
        "sections": [
            {
                "key": section.key,
                "title": section.title,
                "note": section.note,
                "rows": [
                    {
                        "label": row.label,
                        "note": row.note,
                        "figures": [
                            _column(name, figure, sheet.seed)
                            for name, figure in zip(section.columns, row.cells, strict=True)
                        ],
                    }
                    for row in section.rows
                ],
            }
            for section in sheet.sections
        ],
    }


def _column(name: str, figure: Cell, seed: int | None) -> dict[str, Any]:
    data = figure_data(figure)
    ends = [data.pop("low"), data.pop("high")]
    kind = data.pop("interval")
    return {
        "name": name,
        **data,
        "interval": None if kind is None else ends,
        "interval_kind": kind,
        "seed": seed,
    }


def result_schema() -> dict[str, Any]:
    """Return the JSON Schema of result.json."""
    number, text = {"type": ["number", "null"]}, {"type": "string"}
    figure = {
        "type": "object",
        "description": (
            "A figure: its value and the ends of its interval in `unit`, which is an SI unit and "
            "the same for this key in every file (a share is a number from 0 to 1), null where "
            "there is none; what it was counted from; and the same as people read it."
        ),
        "properties": {
            "value": number,
            "unit": {
                "type": ["string", "null"],
                "description": "SI unit; null where words stand in place of a number",
            },
            "low": number,
            "high": number,
            "interval": {
                "type": ["string", "null"],
                "description": "kind of interval, '95 % interval'",
            },
            "samples": text,
            "display": {"type": "string", "description": "as printed: '0.42 mm (0.40 … 0.45)'"},
            "bound": {
                "enum": ["upper", "lower"],
                "description": "the true value is no larger, or no smaller",
            },
            "words": {"type": "string", "description": "what is printed in place of a number"},
        },
        "required": ["value", "unit", "low", "high", "interval", "samples", "display"],
        "additionalProperties": False,
    }
    column = {
        "type": "object",
        "properties": {
            "name": text,
            "value": number,
            "unit": {"type": ["string", "null"]},
            "interval": {"type": ["array", "null"], "items": number},
            "interval_kind": {"type": ["string", "null"]},
            "samples": text,
            "seed": {"type": ["integer", "null"]},
            "display": text,
            "bound": {"enum": ["upper", "lower"]},
            "words": text,
        },
        "required": [
            "name",
            "value",
            "unit",
            "interval",
            "interval_kind",
            "samples",
            "display",
            "seed",
        ],
        "additionalProperties": False,
    }
    row = {
        "type": "object",
        "properties": {"label": text, "note": text, "figures": {"type": "array", "items": column}},
        "required": ["label", "note", "figures"],
        "additionalProperties": False,
    }
    section = {
        "type": "object",
        "description": "A table as it is printed.",
        "properties": {
            "key": text,
            "title": text,
            "note": text,
            "rows": {"type": "array", "items": row},
        },
        "required": ["key", "title", "note", "rows"],
        "additionalProperties": False,
    }
    of_row = {
        "anyOf": [
            {"$ref": "#/$defs/Figure"},
            {"type": "object", "additionalProperties": {"$ref": "#/$defs/Figure"}},
        ]
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "lostmotion result",
        "description": (
            "result.json: every figure by a stable key, and the tables as they are printed. Other "
            "members are facts of the question."
        ),
        "type": "object",
        "properties": {
            "lostmotion": {"type": "string", "description": "version of the program"},
            "layout": {"const": LAYOUT, "description": "version of this layout"},
            "answer": {"type": "string", "description": "the headline, in a sentence or three"},
            "brief": {
                "type": "array",
                "description": "statements of the first screen besides the headline",
                "items": {
                    "type": "object",
                    "properties": {"title": text, "text": text},
                    "required": ["title", "text"],
                },
            },
            "warnings": {"type": "array", "items": text},
            "notes": {"type": "array", "items": text},
            "lines": {
                "type": "object",
                "properties": {"title": text, "text": text},
                "required": ["title", "text"],
            },
            "figures": {
                "type": "object",
                "description": (
                    "section.row, or section.row.column where a table has several columns"
                ),
                "additionalProperties": {"type": "object", "additionalProperties": of_row},
            },
            "sections": {"type": "array", "items": section},
        },
        "required": ["lostmotion", "layout", "answer", "warnings", "notes", "figures", "sections"],
        "$defs": {"Figure": figure},
    }
