"""Numbers as people read them: in the unit that suits their size, to the digits that their interval
supports.

Inside the package every number is in SI. Only here, when a number is shown, is another unit chosen.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Iterable

ARCMIN: Final = math.pi / 10800
ARCSEC: Final = ARCMIN / 60
_DEGREE: Final = math.pi / 180

# Unit as printed: its SI unit, and how many of it are one of those.
UNITS: Final[dict[str, tuple[str, float]]] = {
    "1": ("1", 1.0),
    "%": ("1", 100.0),
    "m": ("m", 1.0),
    "mm": ("m", 1e3),
    "µm": ("m", 1e6),
    "m²": ("m²", 1.0),
    "m³": ("m³", 1.0),
    "rad": ("rad", 1.0),
    "°": ("rad", 1 / _DEGREE),
    "arcmin": ("rad", 1 / ARCMIN),
    "arcsec": ("rad", 1 / ARCSEC),
    "mrad": ("rad", 1e3),
    "rad/m": ("rad/m", 1.0),
    "kg": ("kg", 1.0),
    "kg/m³": ("kg/m³", 1.0),
    "s": ("s", 1.0),
    "K": ("K", 1.0),
    "N": ("N", 1.0),
    "kN": ("N", 1e-3),
    "N m": ("N m", 1.0),
    "Pa": ("Pa", 1.0),
    "MPa": ("Pa", 1e-6),
    "GPa": ("Pa", 1e-9),
    "N/m": ("N/m", 1.0),
    "N/mm": ("N/m", 1e-3),
    "N/µm": ("N/m", 1e-6),
    "m/N": ("m/N", 1.0),
    "µm/N": ("m/N", 1e6),
    "N m/rad": ("N m/rad", 1.0),
    "N m/arcmin": ("N m/rad", ARCMIN),
    "rad/(N m)": ("rad/(N m)", 1.0),
    "arcmin/(N m)": ("rad/(N m)", 1 / ARCMIN),
    "µm/m": ("1", 1e6),
    "1/K": ("1/K", 1.0),
    "µm/m/K": ("1/K", 1e6),
}
# In the units people read (µm, mm, N m, %) anything smaller is what rounding leaves of zero.
_NOTHING: Final = 1e-7
# Significant digits without an interval, at most with one, and of the interval's width.
_DIGITS: Final = 3
_MOST_DIGITS: Final = 4
_DIGITS_OF_WIDTH: Final = 2
_MOST_PLACES: Final = 9
# Of a length with one digit: what rounding outward neglects, and where µm begin, m.
_SLACK: Final = 0.03
_SMALLEST_MM: Final = 1e-5


def si_of(unit: str) -> str:
    """Return the SI unit of a printed one; a currency, which is in no list, is its own."""
    return UNITS.get(unit, (unit, 1.0))[0]


def factor_of(unit: str) -> float:
    """Return how many of a printed unit are one of its SI unit; 1 for a currency."""
    return UNITS.get(unit, (unit, 1.0))[1]


def unit_of_length(value: float) -> str:
    """Return the unit that suits the size of a length (m): µm, mm or m."""
    return "µm" if abs(value) < 1e-4 else "mm" if abs(value) < 1 else "m"  # noqa: PLR2004 - where people change units


def unit_of_lengths(values: Iterable[float]) -> str:
    """Return one unit for a column of lengths (m): µm where the largest is below 1 mm, else mm, and
    m from 1 m.
    """
    largest = max((abs(each) for each in values if math.isfinite(each)), default=0.0)
    return "µm" if largest < 1e-3 else unit_of_length(largest)  # noqa: PLR2004 - where people change units


def suited(value: float, unit: str) -> str:
    """Return the unit in which people read a number in this SI unit: lengths by their size, angles
    in minutes of arc, shares in per cent.
    """
    if unit == "m":
        return unit_of_length(value)
    return {"rad": "arcmin", "N m/rad": "N m/arcmin", "rad/(N m)": "arcmin/(N m)"}.get(unit, unit)


def last_place(value: float, low: float = math.nan, high: float = math.nan) -> int:
    """Return the decimal place of the last digit of a value and of the ends of its interval.

    Without an interval three significant digits are printed. With one, the last digit is the second
    of the interval's width (JCGM 100:2008, 7.2.6, gives an uncertainty at most two digits), and no
    number has more than four significant digits, three where an end is not known.
    """
    known = [abs(each) for each in (value, low, high) if math.isfinite(each)]
    spans = (high - low, high - value, value - low)
    width = next((abs(span) for span in spans if math.isfinite(span)), None)
    if width is None or not known:
        return places(max(known, default=0.0), _DIGITS)
    closed = math.isfinite(low) and math.isfinite(high)
    most = places(max(known), _MOST_DIGITS if closed else _DIGITS)
    return most if width == 0 else min(places(width, _DIGITS_OF_WIDTH), most)


def between(low: float, high: float, last: int) -> str:
    """Return the ends of an interval as text, a question mark for one that is not known; empty
    where there is none.
    """
    if math.isnan(low) and math.isnan(high):
        return ""
    return " … ".join(written(end, last) if math.isfinite(end) else "?" for end in (low, high))


def stated_text(value: float) -> str:
    """Return a number as it was stated: four significant digits, or more before the point, without
    zeros behind it. Never a power of ten.
    """
    text = written(value, max(places(abs(value), _MOST_DIGITS), 0))
    return text.rstrip("0").rstrip(".") if "." in text else text


def digits(value: float) -> str:
    """Return a number that has no interval as text, with three significant digits."""
    return written(value, places(abs(value), _DIGITS) if math.isfinite(value) else 0)


def places(size: float, count: int) -> int:
    """Return the decimal place of the last of `count` significant digits; below zero where whole
    digits are rounded away.
    """
    return count - 1 - int(f"{size:.{count - 1}e}".partition("e")[2])


def written(value: float, place: int) -> str:
    """Return a number rounded to this decimal place."""
    if not math.isfinite(value):
        return "not known" if math.isnan(value) else "unbounded"
    if abs(value) < _NOTHING:
        return "0"
    text = f"{round(value, place):.{min(max(place, 0), _MOST_PLACES)}f}"
    return "0" if float(text) == 0 else text


def share_text(value: float) -> str:
    """Return a share in per cent that has no interval: as other numbers, but no finer than 0.01 %,
    and never rounded to 0 or 100.
    """
    # a sum of all shares misses 100 by its last bits
    if not math.isfinite(value) or abs(value) < _NOTHING or abs(value - 100) < _NOTHING:
        return digits(value)
    if abs(value) < 0.005:  # noqa: PLR2004 - would show as 0.00
        return "<0.01"
    text = written(value, min(places(abs(value), _DIGITS), 2))
    return text if float(text) != 100 else ">99.9" if value < 100 else "100"  # noqa: PLR2004 - the whole


def rounded_length(value: float, way: float = 0.0) -> str:
    """Return a length (m) with one significant digit; `way` -1 rounds down, 1 up, both but for 3 %,
    0 to the nearest.
    """
    if not (math.isfinite(value) and value > 0):
        return "0 µm" if value == 0 else "?"
    unit, factor = ("µm", 1e6) if value < _SMALLEST_MM else ("mm", 1e3)
    place = math.floor(math.log10(value * factor))
    number = value * factor / 10.0**place
    digit = {-1.0: math.floor(number * (1 + _SLACK)), 1.0: math.ceil(number / (1 + _SLACK))}.get(
        way, round(number)
    )
    text = f"{digit * 10.0**place:.12f}"
    return f"{text.rstrip('0').rstrip('.')} {unit}"


# Before a figure that the true value is no larger than ("upper"), or no smaller than ("lower").
BOUND_SIGNS: Final = {"": "", "upper": "≤ ", "lower": "≥ "}


def estimate_text(value: float, low: float, high: float, unit: str) -> str:
    """Return a number in SI with the ends of its interval, in the unit that people read."""
    shown = suited(value, unit)
    by = factor_of(shown)
    last = last_place(value * by, low * by, high * by)
    ends = between(low * by, high * by, last)
    text = f"{written(value * by, last)}{'' if shown == '1' else f' {shown}'}"
    return f"{text} ({ends})" if ends else text


def round_number(value: float) -> float:
    """Return the nearest of 1, 2 and 5 times a power of ten, by ratio, to a number above zero."""
    power = 10.0 ** math.floor(math.log10(value))
    return min(
        (step * power for step in (1, 2, 5, 10)), key=lambda step: abs(math.log(step / value))
    )
