"""Limit deviations of shafts and holes by ISO 286's formulas, for diameters over 3 mm up to and
including 250 mm.

Tolerance grades: i = 0.45 D^(1/3) + 0.001 D µm, D mm the geometric mean of the range, times 7, 10,
16, 25, 40, 64, 100 for IT5 to IT11. Fundamental deviations of shafts, µm: f -5.5 D^0.41, g -2.5
D^0.34, h 0, k 0.6 D^(1/3) (grades up to 7, else 0), m IT7 - IT6, n 5 D^0.34, p IT7 and 0 to 4 more,
s IT8 and 1 to 4 more up to 50 mm and IT7 + 0.4 D above, r the geometric mean of p and s; js is
symmetric; j has no formula. Holes mirror the shafts, and K, M, N up to IT8 and P, R up to IT7 are
shifted by the difference to the next finer grade.

The standard rounds to whole micrometres, and in part to preferred numbers. Where its table differs
from the rounded formula, `_PRINTED` has the value of the table, so that the limits are those of the
table. The formula alone would differ by up to 1 µm, for IT10 and IT11 by up to 5 µm.

Source: ISO 286-1:1988, annex A (formulas), tables 1 to 3 (values).
"""

from __future__ import annotations

import math
import re
from itertools import pairwise
from typing import Final

from lostmotion.errors import nearest

Limits = tuple[float, float]

_MM: Final = 1e-3
_UM: Final = 1e-6
# Limits of the ranges of diameters, mm; r and s have narrower ones.
RANGES: Final = (3, 6, 10, 18, 30, 50, 80, 120, 180, 250)
STEPS: Final = (3, 6, 10, 18, 30, 50, 65, 80, 100, 120, 140, 160, 180, 200, 225, 250)
_UNITS: Final = {5: 7, 6: 10, 7: 16, 8: 25, 9: 40, 10: 64, 11: 100}
# Values of the table, µm, where they differ from the rounded formula, by grade or letter and upper
# end of the range, mm.
_PRINTED: Final[dict[tuple[str, int], int]] = {
    ("IT6", 6): 8,
    ("IT7", 10): 15,
    ("IT7", 18): 18,
    ("IT9", 6): 30,
    ("IT9", 180): 100,
    ("IT9", 250): 115,
    ("IT10", 6): 48,
    ("IT10", 10): 58,
    ("IT10", 18): 70,
    ("IT10", 80): 120,
    ("IT10", 120): 140,
    ("IT10", 180): 160,
    ("IT11", 6): 75,
    ("IT11", 18): 110,
    ("IT11", 30): 130,
    ("IT11", 50): 160,
    ("IT11", 80): 190,
    ("IT11", 120): 220,
    ("IT11", 180): 250,
    ("f", 250): 50,
    ("n", 120): 23,
    ("r", 18): 23,
    ("r", 50): 34,
    ("r", 160): 65,
    ("r", 200): 77,
    ("r", 225): 80,
    ("s", 225): 130,
    ("s", 250): 140,
}
# Additions to a grade, µm, by the upper end of the range, mm: from the table, because the formula
# states only their limits.
_P_MORE: Final = {6: 0, 10: 0, 18: 0, 30: 1, 50: 1, 80: 2, 120: 2, 180: 3, 250: 4}
_S_MORE: Final = {6: 1, 10: 1, 18: 1, 30: 2, 50: 4}
# Deviations without a formula, µm, by range: the lower ones of j5, j6 and j7, the upper ones of J6,
# J7 and J8.
_J: Final[dict[str, tuple[int, ...]]] = {
    "j5": (-2, -2, -3, -4, -5, -7, -9, -11, -13),
    "j6": (-2, -2, -3, -4, -5, -7, -9, -11, -13),
    "j7": (-4, -5, -6, -8, -10, -12, -15, -18, -21),
    "J6": (5, 5, 6, 8, 10, 13, 16, 18, 22),
    "J7": (6, 8, 10, 12, 14, 18, 22, 26, 30),
    "J8": (10, 12, 15, 20, 24, 28, 34, 41, 47),
}
_ZONE: Final = re.compile(r"(?P<letter>[A-Za-z]{1,2})(?P<grade>[0-9]{1,2})")
# Tolerance zones that are common on drawings, from loose to tight.
SHAFT_ZONES: Final = (
    "f7",
    "g5",
    "g6",
    "h5",
    "h6",
    "h7",
    "j5",
    "j6",
    "js5",
    "js6",
    "k5",
    "k6",
    "m5",
    "m6",
    "n5",
    "n6",
    "p5",
    "p6",
    "r6",
)
HOLE_ZONES: Final = (
    "F7",
    "F8",
    "G6",
    "G7",
    "H6",
    "H7",
    "H8",
    "J6",
    "J7",
    "JS6",
    "JS7",
    "K6",
    "K7",
    "M6",
    "M7",
    "N6",
    "N7",
    "P6",
    "P7",
    "R6",
    "R7",
)
_LETTERS: Final = ("f", "g", "h", "j", "js", "k", "m", "n", "p", "r", "s")


def expected_zone(zone: str, *, hole: bool) -> tuple[str, str]:
    """Return what is expected in place of an unknown tolerance zone, and the nearest known zone;
    two empty strings for a known zone.
    """
    kind, known = ("hole", HOLE_ZONES) if hole else ("shaft", SHAFT_ZONES)
    found = _ZONE.fullmatch(zone.strip())
    letters = [letter.upper() if hole else letter for letter in _LETTERS]
    if found and found["letter"] in letters and int(found["grade"]) in _UNITS:
        letter = found["letter"].lower()
        grade = int(found["grade"])
        finest = 6 if hole and letter in {"k", "m", "n", "p", "r", "s"} else 5
        if (letter != "j" or zone.strip() in _J) and grade >= finest:
            return "", ""
    best = (
        next((each for each in known if each.lower() == zone.strip().lower()), None)
        or nearest(zone.strip(), known)
        or ("H7" if hole else "k5")
    )
    return f"a zone of a {kind} such as {', '.join(known)}", best


def limit_deviations(zone: str, diameter: float) -> Limits:
    """Return the lower and upper limit deviation (m) of a tolerance zone, of a shaft ("k6") or a
    hole ("K7"), at this nominal diameter (m).

    Valid for letters f, g, h, js, k, m, n, p, r, s with grades 5 to 11 (capital letters for holes,
    K to S from grade 6 on) and for j5, j6, j7, J6, J7, J8; over 3 mm, up to and including 250 mm.
    Raises ValueError for any other zone or diameter.
    """
    zone = zone.strip()
    hole = zone[:1].isupper()
    expected, _ = expected_zone(zone, hole=hole)
    size = round(diameter / _MM, 6)
    if expected or not RANGES[0] < size <= RANGES[-1]:
        raise ValueError(
            f"no limit deviations of {zone} at {size:g} mm: zones f to s, grades 5 to 11, over "
            "3 mm up to 250 mm"
        )
    match = _ZONE.fullmatch(zone)
    letter, grade = (match["letter"].lower(), int(match["grade"])) if match else ("h", 6)
    width = grade_width(grade, size)
    if letter == "js":
        return -width / 2 * _UM, width / 2 * _UM
    if letter == "j":
        at = _J[zone][_ends(RANGES, size)[2]]
        return ((at - width) * _UM, at * _UM) if hole else (at * _UM, (at + width) * _UM)
    if hole:
        low, high = _hole(letter, grade, size, width)
    else:
        start = _fundamental(letter, grade, size)
        low, high = (start - width, start) if letter in {"f", "g", "h"} else (start, start + width)
    return low * _UM, high * _UM


def grade_width(grade: int, size: float) -> int:
    """Return the tolerance (µm) of a grade, IT5 to IT11, at a diameter (mm)."""
    low, high, _ = _ends(RANGES, size)
    middle: float = math.sqrt(low * high)
    formula = _UNITS[grade] * (0.45 * middle ** (1 / 3) + 0.001 * middle)
    return _PRINTED.get((f"IT{grade}", high), round(float(formula)))


def _ends(edges: tuple[int, ...], size: float) -> tuple[int, int, int]:
    """Return both ends (mm) of the range that contains a diameter (mm), and its index."""
    return next(
        (low, high, k) for k, (low, high) in enumerate(pairwise(edges)) if low < size <= high
    )


def _fundamental(letter: str, grade: int, size: float) -> int:
    """Return the fundamental deviation (µm) of a shaft, that nearest to zero: the upper one of f,
    g, h, otherwise the lower one.
    """
    low, high, _ = _ends(STEPS if letter in {"r", "s"} else RANGES, size)
    middle = math.sqrt(low * high)
    whole = _ends(RANGES, size)[1]
    if letter == "r":
        value = math.sqrt(_fundamental("p", grade, size) * _fundamental("s", grade, size))
    elif letter == "s":
        value = (
            grade_width(8, size) + _S_MORE[whole]
            if whole in _S_MORE
            else grade_width(7, size) + 0.4 * middle
        )
    else:
        value = {
            "f": -5.5 * middle**0.41,
            "g": -2.5 * middle**0.34,
            "h": 0.0,
            "k": 0.6 * middle ** (1 / 3) if grade <= 7 else 0.0,  # noqa: PLR2004 - the standard's
            "m": grade_width(7, size) - grade_width(6, size),
            "n": 5 * middle**0.34,
            "p": grade_width(7, size) + _P_MORE[whole],
        }[letter]
    printed = _PRINTED.get((letter, high))
    return round(value) if printed is None else int(math.copysign(printed, value))


def _hole(letter: str, grade: int, size: float, width: int) -> tuple[float, float]:
    """Return the limit deviations (µm) of a hole: those of the shaft, mirrored; for fine grades
    shifted so that equivalent fits are equally tight.
    """
    mirrored = -_fundamental(letter, min(grade, 7) if letter == "k" else grade, size)
    if letter in {"f", "g", "h"}:
        return mirrored, mirrored + width
    finest = 8 if letter in {"k", "m", "n"} else 7
    coarse = 0 if letter in {"k", "n"} else mirrored
    upper = mirrored + width - grade_width(grade - 1, size) if grade <= finest else coarse
    return upper - width, upper
