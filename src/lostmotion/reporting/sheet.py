"""Figures as a person reads them: label, value, unit, interval, sample. Screen, report and
result.json all print these, whatever they are about.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from numbers import Integral
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

ARCMIN = math.pi / 10800
ARCSEC = ARCMIN / 60
# In the units people read (µm, mm, N m, %) anything smaller is what rounding leaves of zero.
_NOTHING = 1e-7
# Units of length, per metre.
PER_METRE = {"µm": 1e6, "mm": 1e3, "m": 1.0}
# Significant digits without an interval, at most with one, and of the interval's width.
_DIGITS = 3
_MOST_DIGITS = 4
_DIGITS_OF_WIDTH = 2
_MOST_PLACES = 9


@dataclass(frozen=True, slots=True)
class Figure:
    """One number: value and ends of its 95 % interval in `unit` ("1" for a pure number; NaN where
    there is none), and what it was counted from.

    stated: it was given, not computed: printed as it stands, to four digits, without zeros behind
    it.
    bound: the true value is no larger ("upper"), or no smaller ("lower").
    words: what stands in the cell in place of a number.
    """

    value: float
    unit: str
    low: float = math.nan
    high: float = math.nan
    samples: str = ""
    ends: str = "95 % interval"
    stated: bool = False
    bound: Literal["", "upper", "lower"] = ""
    words: str = ""

    def __str__(self) -> str:
        """Return value and unit as text, to the digits that its interval supports (see `_places`);
        a bound with its sign.
        """
        return {"": "", "upper": "≤ ", "lower": "≥ "}[self.bound] + self._plain_text()

    def _plain_text(self) -> str:
        if self.words:
            return self.words
        unit = "" if self.unit == "1" else self.unit
        if isinstance(self.value, Integral):  # counted, not measured
            return f"{self.value} {unit}".strip()
        if not math.isfinite(self.value):
            return digits(self.value)
        if self.stated:
            # As it was given, so whole digits are never rounded away.
            text = _written(self.value, max(_places(abs(self.value), _MOST_DIGITS), 0))
            return f"{text.rstrip('0').rstrip('.') if '.' in text else text} {unit}".strip()
        if self.unit == "%" and not self.between:
            return f"{_share(self.value)} %"
        return f"{_written(self.value, self._last)} {unit}".strip()

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
        if math.isnan(self.low) and math.isnan(self.high):
            return ""
        return " … ".join(
            _written(end, self._last) if math.isfinite(end) else "?"
            for end in (self.low, self.high)
        )

    @property
    def _last(self) -> int:
        """Return the decimal place of the last digit of the value and of both ends.

        Without an interval three significant digits are printed. With one, the last digit is the
        second of the interval's width (JCGM 100:2008, 7.2.6, gives an uncertainty at most two
        digits), and no number has more than four significant digits, three where an end is not
        known.
        """
        known = [abs(each) for each in (self.value, self.low, self.high) if math.isfinite(each)]
        spans = (self.high - self.low, self.high - self.value, self.value - self.low)
        width = next((abs(span) for span in spans if math.isfinite(span)), None)
        if width is None or not known:
            return _places(max(known, default=0.0), _DIGITS)
        closed = math.isfinite(self.low) and math.isfinite(self.high)
        most = _places(max(known), _MOST_DIGITS if closed else _DIGITS)
        return most if width == 0 else min(_places(width, _DIGITS_OF_WIDTH), most)


@dataclass(frozen=True, slots=True)
class Row:
    """A line of a section: what it is, its figures, a remark, and its key in result.json where that
    does not follow from the label.
    """

    label: str
    figures: tuple[Figure, ...]
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
        return [any(row.figures[k].interval for row in self.rows) for k in range(len(self.columns))]


@dataclass(frozen=True, slots=True)
class Card:
    """A figure that is asked for first: what it is, the number as text, and a quiet line below
    it.
    """

    title: str
    number: str
    quiet: str = ""


@dataclass(frozen=True, slots=True)
class Bar:
    """One bar: its label, the figure that it draws, and a second figure beside it, None where there
    is none.

    size   length of the bar in the unit that all bars of the block share; negative where the figure
           reduces the total
    parts  the same length split in the order of the block's `stack`; empty where it is not split
    """

    label: str
    figure: Figure
    size: float
    effect: Figure | None = None
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

    name: str
    subject: str
    verdict: str
    cards: tuple[Card, ...]
    sections: tuple[Section, ...]
    source: str
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


def find_row(sections: Iterable[Section], key: str, label: str) -> Row | None:
    """Return the row of the section `key` with this label. None where there is none."""
    return next(
        (
            row
            for section in sections
            if section.key == key
            for row in section.rows
            if row.label == label
        ),
        None,
    )


def in_words(text: str) -> Figure:
    """Return a cell that has words in place of a number."""
    return Figure(math.nan, "1", words=text)


def digits(value: float) -> str:
    """Return a number that has no interval as text, with three significant digits."""
    return _written(value, _places(abs(value), _DIGITS) if math.isfinite(value) else 0)


def as_stated(value: float) -> str:
    """Return a number as a user stated it, without a unit: four significant digits, or more before
    the point. Never a power of ten.
    """
    return str(Figure(value, "1", stated=True))


def _places(size: float, count: int) -> int:
    """Return the decimal place of the last of `count` significant digits; below zero where whole
    digits are rounded away.
    """
    return count - 1 - int(f"{size:.{count - 1}e}".partition("e")[2])


def _written(value: float, place: int) -> str:
    """Return a number rounded to this decimal place."""
    if not math.isfinite(value):
        return "not known" if math.isnan(value) else "unbounded"
    if abs(value) < _NOTHING:
        return "0"
    text = f"{round(value, place):.{min(max(place, 0), _MOST_PLACES)}f}"
    return "0" if float(text) == 0 else text


def _share(value: float) -> str:
    """Return a share in per cent that has no interval: as other numbers, but no finer than 0.01 %,
    and never rounded to 0 or 100.
    """
    # a sum of all shares misses 100 by its last bits
    if not math.isfinite(value) or abs(value) < _NOTHING or abs(value - 100) < _NOTHING:
        return digits(value)
    if abs(value) < 0.005:  # noqa: PLR2004 - would show as 0.00
        return "<0.01"
    text = _written(value, min(_places(abs(value), _DIGITS), 2))
    return text if float(text) != 100 else ">99.9" if value < 100 else "100"  # noqa: PLR2004 - the whole


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
) -> Figure:
    """Return a length (m) in the unit that suits its size: µm, mm or m."""
    unit = "µm" if abs(value) < 1e-4 else "mm" if abs(value) < 1 else "m"  # noqa: PLR2004 - where people change units
    by = PER_METRE[unit]
    return Figure(value * by, unit, low * by, high * by, samples, stated=stated)


def in_one_unit(figures: Sequence[Figure]) -> list[Figure]:
    """Return lengths, in whatever units, in one unit for a column: µm where the largest is below 1
    mm, else mm, and m from 1 m.
    """
    largest = max(
        (abs(each.value) / PER_METRE[each.unit] for each in figures if math.isfinite(each.value)),
        default=0.0,
    )
    unit = "µm" if largest < 1e-3 else length(largest).unit  # noqa: PLR2004 - where people change units
    out = []
    for each in figures:
        by = PER_METRE[unit] / PER_METRE[each.unit]
        out.append(
            replace(each, value=each.value * by, unit=unit, low=each.low * by, high=each.high * by)
        )
    return out
