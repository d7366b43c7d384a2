"""Figures as a person reads them: label, value, unit, interval, sample. Screen, report and
result.json all print these, whatever they are about.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from numbers import Integral
from typing import TYPE_CHECKING, Any, Literal

from lostmotion.printed import (
    BOUND_SIGNS,
    between,
    digits,
    factor_of,
    last_place,
    places,
    rounded_length,
    share_text,
    si_of,
    stated_text,
    suited,
    unit_of_length,
    unit_of_lengths,
    written,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from typing import SupportsFloat

    from lostmotion.error_model.intervals import Estimate


@dataclass(frozen=True, slots=True)
class Cell:
    """One number of a table: value and ends of its 95 % interval in SI (NaN where there is none),
    the unit in which it is shown ("1" for a pure number), and what it was counted from.

    stated: it was given, not computed: printed as it stands, to four digits, without zeros behind
    it.
    bound: the true value is no larger ("upper"), or no smaller ("lower").
    words: what stands in the cell in place of a number.
    assumed: a size that rests on assumed drives alone: printed with one digit, without its
    interval.
    """

    value: float
    shown: str
    low: float = math.nan
    high: float = math.nan
    samples: str = ""
    ends: str = "95 % interval"
    stated: bool = False
    bound: Literal["", "upper", "lower"] = ""
    words: str = ""
    assumed: bool = False

    @property
    def unit(self) -> str:
        """Return the SI unit of the value and of the ends of its interval."""
        return si_of(self.shown)

    @property
    def as_shown(self) -> float:
        """Return the value in the unit in which it is shown."""
        return self._as_shown(self.value)

    def _as_shown(self, value: float) -> float:
        return value if isinstance(value, Integral) else value * factor_of(self.shown)

    def __str__(self) -> str:
        """Return value and unit as text, to the digits that its interval supports (see
        `last_place`); a bound with its sign.
        """
        return BOUND_SIGNS[self.bound] + self._plain_text()

    def _plain_text(self) -> str:
        if self.words or self.assumed:
            return self.words or self._one_digit()
        unit = "" if self.shown == "1" else self.shown
        if isinstance(self.value, Integral):  # counted, not measured
            return f"{self.value} {unit}".strip()
        value = self.as_shown
        if not math.isfinite(value):
            return digits(value)
        if self.stated:
            return f"{stated_text(value)} {unit}".strip()
        if self.shown == "%" and not self.between:
            return f"{share_text(value)} %"
        return f"{written(value, self._last)} {unit}".strip()

    def _one_digit(self) -> str:
        if self.unit == "m":
            return f"{'-' if self.value < 0 else ''}{rounded_length(abs(self.value))}"
        value = self.as_shown
        place = places(abs(value), 1) if math.isfinite(value) else 0
        return f"{written(value, place)} {'' if self.shown == '1' else self.shown}".strip()

    @property
    def number(self) -> str:
        """Return the value as text without its unit."""
        return str(self).removesuffix(self.shown).rstrip()

    @property
    def display(self) -> str:
        """Return the value with its unit and its interval, as printed."""
        return f"{self} ({self.interval})" if self.interval else str(self)

    @property
    def alone(self) -> Cell:
        """Return the value without its interval."""
        return Cell(self.value, self.shown, samples=self.samples, assumed=self.assumed)

    @property
    def interval(self) -> str:
        """Return the interval as text, with its kind unless it is one of 95 %; empty where there is
        none.
        """
        return self.between + (
            "" if not self.between or self.ends == "95 % interval" else f" ({self.ends})"
        )

    @property
    def between(self) -> str:
        """Return the ends of the interval as text, empty where there is none."""
        if self.assumed:
            return ""
        return between(self._as_shown(self.low), self._as_shown(self.high), self._last)

    @property
    def _last(self) -> int:
        return last_place(*(self._as_shown(each) for each in (self.value, self.low, self.high)))


@dataclass(frozen=True, slots=True)
class Row:
    """A line of a section: what it is, its cells, a remark, and its key in result.json where that
    does not follow from the label.
    """

    label: str
    cells: tuple[Cell, ...]
    note: str = ""
    key: str = ""


@dataclass(frozen=True, slots=True)
class Section:
    """A titled block of figures; `columns` names the figures of its rows.

    folded: what its rows amount to, in a sentence. A page shows that sentence, on paper alone, and
    the table where the reader opens it.
    bars: blocks of bars of the same figures, beside the table.
    """

    key: str
    title: str
    columns: tuple[str, ...]
    rows: tuple[Row, ...]
    note: str = ""
    folded: str = ""
    bars: tuple[Bars, ...] = ()

    @property
    def with_interval(self) -> list[bool]:
        """Return which columns have an interval beside them."""
        return [any(row.cells[k].interval for row in self.rows) for k in range(len(self.columns))]


@dataclass(frozen=True, slots=True)
class Card:
    """A figure that is asked for first: what it is, the number as text, a quiet line below it, and
    the key of the declared figure that it shows, if it is one.

    limited_as  whether a kind of error that is missing makes it a bound, as an error or as
                repeatability
    """

    title: str
    number: str
    quiet: str = ""
    key: str = ""
    limited_as: Literal["", "error", "repeatability"] = ""


@dataclass(frozen=True, slots=True)
class Bar:
    """One bar: its label, the figure that it draws, and a second figure beside it, None where there
    is none.

    size   length of the bar in the unit that all bars of the block share; negative where the figure
           reduces the total
    parts  the same length split in the order of the block's `stack`; empty where it is not split
    """

    label: str
    figure: Cell
    size: float
    effect: Cell | None = None
    parts: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Bars:
    """A titled block of bars for the first screen or beside a table: what they show, from what, and
    the same figures in full in the section `key`.

    column  what the bars show ("share of the mean square")
    effect  what the second figures show; empty where there are none
    stack   names of the parts of each bar; empty where bars are not split
    note    a quiet line below
    most    size that the scale reaches at least: blocks that stand side by side are then drawn to
            one scale
    """

    key: str
    title: str
    column: str
    bars: tuple[Bar, ...]
    effect: str = ""
    stack: tuple[str, ...] = ()
    note: str = ""
    most: float = 0.0

    @property
    def ends(self) -> tuple[float, float]:
        """Return the ends of the scale: the smallest and the largest size, with zero between them;
        (0, 1) where every bar is zero.
        """
        reach = [0.0, self.most]
        for bar in self.bars:
            reach += [
                bar.size,
                sum(part for part in bar.parts if part > 0),
                sum(part for part in bar.parts if part < 0),
            ]
        return (min(reach), max(reach)) if any(reach) else (0.0, 1.0)


@dataclass(frozen=True, slots=True)
class Lines:
    """Lines to copy: what they are for, and the text."""

    title: str
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Sheet:
    """All results for one arm or part: the screen prints them, the report lays them out,
    result.json contains them.

    name, subject  its name, and the subject of the results ("predicted accuracy")
    counts         what the figures were counted from, in a few words; empty where nothing was drawn
    verdict        the answer in a sentence or three
    cards          the figures that are asked for first
    warnings       what makes the figures doubtful as a whole, shown with the verdict
    notes          what the reader should know besides
    words          what the terms mean
    source         where it comes from, after the version: seed, counts, files
    arrays         what the NetCDF beside the page holds; empty where there is none
    drawing        what the DXF beside the page holds; empty where there is none
    seed           of all that was drawn, None where nothing was
    facts          further entries of result.json, at its top
    lines          lines for the user's file, where it lacks some
    about          what was examined in a few words: "5 joints, 18.8 kg, payload 5 kg"; empty where
                   the name says it
    bars           blocks of bars for the first screen
    brief          further statements of the first screen, each a word and a sentence or two
                   ("Where", "Drives", "Trust")
    """

    subject: str
    name: str = ""
    verdict: str = ""
    cards: tuple[Card, ...] = ()
    sections: tuple[Section, ...] = ()
    source: str = ""
    counts: str = ""
    warnings: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    words: tuple[tuple[str, str], ...] = ()
    arrays: str = ""
    drawing: str = ""
    seed: int | None = None
    facts: dict[str, Any] = field(default_factory=dict)
    lines: Lines | None = None
    about: str = ""
    bars: tuple[Bars, ...] = ()
    brief: tuple[tuple[str, str], ...] = ()


def table(
    key: str,
    title: str,
    columns: Mapping[str, str] | Sequence[str],
    rows: Iterable[Row | Sequence[Any]],
    note: str = "",
    *,
    unit: str = "1",
    samples: str = "",
) -> Section:
    """Return a section: of every row its label, a value for each column, and a note where the row
    has one.

    columns  each by its name, with the unit in which its numbers are shown. With an SI unit the one
             that people read is chosen by the size of each number (`suited`)
    rows     a value is a number or an estimate in SI, a text, None where nothing is known, or a
             cell as it is printed
    unit     of all columns, where `columns` is names alone
    samples  what the numbers were counted from, where their cell does not state it

    Raises ValueError for a row of another length.
    """
    units = [*columns.values()] if isinstance(columns, Mapping) else [unit] * len(columns)
    return Section(
        key,
        title,
        tuple(columns),
        tuple(row if isinstance(row, Row) else _row(row, units, samples) for row in rows),
        note,
    )


def _row(row: Sequence[Any], units: Sequence[str], samples: str) -> Row:
    label, *values = row
    note = values.pop() if len(values) == len(units) + 1 else ""
    cells = (_cell(*pair, samples) for pair in zip(values, units, strict=True))
    return Row(label, tuple(cells), note)


def _cell(value: Cell | Estimate | SupportsFloat | str | None, unit: str, samples: str) -> Cell:
    # not above: the command line reads this file before anything of NumPy
    from lostmotion.error_model.intervals import Estimate

    if isinstance(value, str):
        return in_words(value)
    if isinstance(value, Cell):
        return value if value.samples or value.words else replace(value, samples=samples)
    if isinstance(value, Estimate):
        return cell(value, unit, samples)
    if isinstance(value, Integral):
        return Cell(int(value), unit, samples=samples)
    number = math.nan if value is None else float(value)
    return Cell(number, suited(number, unit), samples=samples)


def in_words(text: str) -> Cell:
    """Return a cell that has words in place of a number."""
    return Cell(math.nan, "1", words=text)


def several(count: int, noun: str) -> str:
    """Return a count with its noun: "1 pose", "2 poses"."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def length(
    value: float,
    low: float = math.nan,
    high: float = math.nan,
    samples: str = "",
    *,
    stated: bool = False,
) -> Cell:
    """Return a length (m), shown in the unit that suits its size: µm, mm or m."""
    return Cell(value, unit_of_length(value), low, high, samples, stated=stated)


def cell(estimate: Estimate, unit: str, samples: str = "") -> Cell:
    """Return an estimate in this SI unit, shown in the unit in which people read it."""
    return Cell(estimate.value, suited(estimate.value, unit), estimate.low, estimate.high, samples)


def in_one_unit(lengths: Sequence[Cell]) -> list[Cell]:
    """Return lengths, shown in one unit for a column (`unit_of_lengths`)."""
    unit = unit_of_lengths(each.value for each in lengths)
    return [replace(each, shown=unit) for each in lengths]
