"""Limit deviations by ISO 286's formulas, against the printed values of its tables."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from lostmotion.laws.iso286 import (
    HOLE_ZONES,
    RANGES,
    SHAFT_ZONES,
    STEPS,
    expected_zone,
    grade_width,
    limit_deviations,
)

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "limit deviations of shafts and holes",
        "the tables of ISO 286-1 and ISO 286-2",
        "printed digits",
        "laws/iso286.py",
    ),
)

# ISO 286-1, table 1, µm: ranges over 3, 6, 10, 18, 30, 50, 80, 120 and 180 mm, each up to the next,
# the last one to 250 mm.
GRADES = {
    5: (5, 6, 8, 9, 11, 13, 15, 18, 20),
    6: (8, 9, 11, 13, 16, 19, 22, 25, 29),
    7: (12, 15, 18, 21, 25, 30, 35, 40, 46),
    8: (18, 22, 27, 33, 39, 46, 54, 63, 72),
    9: (30, 36, 43, 52, 62, 74, 87, 100, 115),
    10: (48, 58, 70, 84, 100, 120, 140, 160, 185),
    11: (75, 90, 110, 130, 160, 190, 220, 250, 290),
}
# ISO 286-1, table 2: the deviation nearest to zero, µm, in the same ranges.
FUNDAMENTAL = {
    "f": (-10, -13, -16, -20, -25, -30, -36, -43, -50),
    "g": (-4, -5, -6, -7, -9, -10, -12, -14, -15),
    "k": (1, 1, 1, 2, 2, 2, 3, 3, 4),
    "m": (4, 6, 7, 8, 9, 11, 13, 15, 17),
    "n": (8, 10, 12, 15, 17, 20, 23, 27, 31),
    "p": (12, 15, 18, 22, 26, 32, 37, 43, 50),
}
# With the narrower ranges of r and s.
FINE = {
    "r": (15, 19, 23, 28, 34, 41, 43, 51, 54, 63, 65, 68, 77, 80, 84),
    "s": (19, 23, 28, 35, 43, 53, 59, 71, 79, 92, 100, 108, 122, 130, 140),
}
# ISO 286-1, tables 2 and 3, of zones on both sides of zero: the lower deviation of shafts, the
# upper one of holes, µm, in the same ranges.
BOTH_SIDES = {
    "j5": (-2, -2, -3, -4, -5, -7, -9, -11, -13),
    "j6": (-2, -2, -3, -4, -5, -7, -9, -11, -13),
    "j7": (-4, -5, -6, -8, -10, -12, -15, -18, -21),
    "J6": (5, 5, 6, 8, 10, 13, 16, 18, 22),
    "J7": (6, 8, 10, 12, 14, 18, 22, 26, 30),
    "J8": (10, 12, 15, 20, 24, 28, 34, 41, 47),
}
# ISO 286-2: diameter in mm, zone, upper and lower deviation in µm.
PUBLISHED = [
    (50, "H7", 25, 0), (50, "k6", 18, 2), (50, "g6", -9, -25), (25, "p6", 35, 22), (50, "K7", 7, -18), (50, "N7", -8, -33), (50, "P7", -17, -42),
    (100, "js6", 11, -11), (10, "r6", 28, 19), (30, "F7", 41, 20), (120, "m6", 35, 13), (40, "h6", 0, -16), (40, "j6", 11, -5), (40, "k5", 13, 2),
    (40, "m5", 20, 9), (40, "m6", 25, 9), (40, "n6", 33, 17), (60, "h6", 0, -19), (60, "j6", 12, -7), (60, "k5", 15, 2), (60, "k6", 21, 2),
    (60, "n6", 39, 20), (60, "H7", 30, 0), (60, "J7", 18, -12), (60, "K7", 9, -21), (60, "M7", 0, -30), (60, "N7", -9, -39), (100, "J7", 22, -13),
    (100, "K7", 10, -25), (100, "M7", 0, -35), (100, "N7", -10, -45), (20, "h7", 0, -21), (20, "H8", 33, 0), (20, "k6", 15, 2), (20, "n6", 28, 15),
    (20, "p6", 35, 22), (20, "r6", 41, 28), (20, "f7", -20, -41), (20, "G7", 28, 7), (20, "P7", -14, -35), (20, "R7", -20, -41), (50, "M6", -4, -20),
    (50, "K6", 3, -13), (50, "N6", -12, -28), (50, "P6", -21, -37), (50, "R7", -25, -50), (8, "H7", 15, 0), (8, "m6", 15, 6), (8, "P7", -9, -24),
    (5, "h6", 0, -8), (5, "k6", 9, 1), (5, "r6", 23, 15), (100, "n6", 45, 23), (100, "p6", 59, 37), (100, "r6", 73, 51), (200, "r6", 106, 77),
    (200, "k6", 33, 4), (200, "m6", 46, 17), (200, "F7", 96, 50), (150, "N7", -12, -52), (150, "P7", -28, -68), (16, "g6", -6, -17),
]  # fmt: skip


@pytest.mark.parametrize("grade", GRADES)
def test_grades_are_those_of_the_table(grade):
    """IT5 to IT11 in all nine ranges; the formula alone is within 1 µm of IT5 to IT9, which is its
    rounding.
    """
    for (low, high), printed in zip(pairwise(RANGES), GRADES[grade], strict=True):
        assert grade_width(grade, high) == grade_width(grade, low + 0.001) == printed
        middle = math.sqrt(low * high)
        formula = {5: 7, 6: 10, 7: 16, 8: 25, 9: 40, 10: 64, 11: 100}[grade] * (
            0.45 * middle ** (1 / 3) + 0.001 * middle
        )
        assert formula == pytest.approx(printed, abs=1.0 if grade <= 9 else 5.0)


@pytest.mark.parametrize("letter", [*FUNDAMENTAL, *FINE])
def test_fundamental_deviations_are_those_of_the_table(letter):
    """Fundamental deviations of shafts of grade 6 are those of the table, for every letter in every
    range.
    """
    edges, printed = (STEPS, FINE[letter]) if letter in FINE else (RANGES, FUNDAMENTAL[letter])
    for high, value in zip(edges[1:], printed, strict=True):
        low_limit, high_limit = limit_deviations(f"{letter}6", high * 1e-3)
        found = high_limit if letter in "fg" else low_limit
        assert found * 1e6 == pytest.approx(value)


@pytest.mark.parametrize("zone", BOTH_SIDES)
def test_zones_on_both_sides_of_zero_are_those_of_the_table(zone):
    """Zones j and J have the printed deviation in every range; the other deviation is one grade
    away, on the other side of zero.
    """
    for high, value, width in zip(RANGES[1:], BOTH_SIDES[zone], GRADES[int(zone[-1])], strict=True):
        ends = (value - width, value) if zone[0] == "J" else (value, value + width)
        assert [each * 1e6 for each in limit_deviations(zone, high * 1e-3)] == pytest.approx(ends)
        assert ends[0] < 0 < ends[1]


@pytest.mark.parametrize(("diameter", "zone", "upper", "lower"), PUBLISHED)
def test_published_limits(diameter, zone, upper, lower):
    """Limit deviations of shafts and holes are those printed in ISO 286-2."""
    assert [each * 1e6 for each in limit_deviations(zone, diameter * 1e-3)] == pytest.approx(
        [lower, upper]
    )


def test_ranges_contain_their_upper_end_and_widths_grow():
    """50 mm belongs to 30 to 50, a little more to the next range; every zone is as wide as its
    grade and no narrower on a larger diameter.
    """
    assert limit_deviations("H7", 0.05)[1] == pytest.approx(25e-6)
    assert limit_deviations("H7", 0.0500001)[1] == pytest.approx(30e-6)
    for zone in (*SHAFT_ZONES, *HOLE_ZONES):
        widths = []
        for size in STEPS[1:]:
            low, high = limit_deviations(zone, size * 1e-3)
            widths.append(round((high - low) * 1e6, 3))
            assert widths[-1] == grade_width(int(zone[-1]), size)
        assert widths == sorted(widths)


@pytest.mark.parametrize(
    ("zone", "diameter"),
    [
        ("k6", 0.003),
        ("k6", 0.251),
        ("k6", 0.0),
        ("q6", 0.05),
        ("K5", 0.05),
        ("j8", 0.05),
        ("h12", 0.05),
        ("", 0.05),
    ],
)
def test_zones_and_diameters_beyond_the_formulas_are_refused(zone, diameter):
    """Zones and diameters outside the range of the formulas, and NaN, are refused."""
    with pytest.raises(ValueError, match="limit deviations"):
        limit_deviations(zone, diameter)
    with pytest.raises(ValueError, match="limit deviations"):
        limit_deviations("k6", math.nan)


def test_an_unknown_zone_is_refused_with_the_nearest():
    """A hole's zone for a shaft and an unknown letter are refused, with the nearest valid zone."""
    assert expected_zone("K6", hole=False)[1] == "k6"
    assert expected_zone("h7", hole=True)[1] == "H7"
    assert expected_zone("k6", hole=False) == ("", "")
