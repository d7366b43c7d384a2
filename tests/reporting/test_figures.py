"""Figures as text: no digit that the interval does not support."""

import math
from decimal import Decimal

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from lostmotion.printed import digits, factor_of
from lostmotion.reporting.sheet import Cell, length

SIZES = st.floats(-1e6, 1e6).filter(lambda value: value == 0 or abs(value) > 1e-5)
WIDTHS = st.floats(1e-6, 1e5)


def shown(value, unit, low=math.nan, high=math.nan, **more):
    """Return a cell with this number in the unit in which it is shown."""
    by = factor_of(unit)
    si = value if isinstance(value, int | np.integer) and by == 1 else value / by
    return Cell(si, unit, low / by, high / by, **more)


def significant(text: str) -> int:
    """Count the digits that a printed number claims; zeros before the first and behind the last
    whole one claim nothing.
    """
    claimed = text.lstrip("-<>").replace(".", "").lstrip("0")
    return len(claimed if "." in text else claimed.rstrip("0"))


def last_place(text: str) -> Decimal:
    """Return what one unit of the last digit stands for; whole digits that were rounded away claim
    nothing.
    """
    number = Decimal(text)
    return Decimal(1).scaleb(number.as_tuple().exponent if "." in text else 0)


@given(value=SIZES, unit=st.sampled_from(["µm", "mm", "%", "N m", "1"]))
def test_without_an_interval_at_most_three_digits_are_printed(value, unit):
    """A number that nobody knows the uncertainty of is printed to half a per cent of itself, and no
    finer.
    """
    text = str(shown(value, unit)).split()[0]
    assert significant(text) <= 3
    if text[0] in "<>":
        return
    assert abs(float(text) - value) <= max(
        0.005 * abs(value), 0.005 if unit == "%" else 0.0, 1e-7
    ) * (1 + 1e-9)
    assert unit == "%" or digits(shown(value, unit).as_shown) == text


@given(value=SIZES, below=WIDTHS, above=WIDTHS)
def test_no_digit_is_finer_than_its_interval(value, below, above):
    """The last printed digit is no finer than a hundredth of the interval's width; the printed
    value lies between the printed ends.
    """
    low, high = value - below, value + above
    figure = shown(value, "mm", low, high)
    text = str(figure).split()[0]
    ends = figure.between.split(" … ")
    largest = max(abs(each) for each in (value, low, high))
    for each in (text, *ends):
        assert significant(each) <= 4
        if each != "0" and "." in each:
            assert (
                float(last_place(each)) >= 0.0099 * (high - low)
                or float(last_place(each)) * 1e4 > largest * 0.99
            )
    assert float(ends[0]) <= float(text) <= float(ends[1])
    assert abs(float(text) - value) <= max(0.05 * (high - low), 0.0005 * largest) * (1 + 1e-9)


def test_digits_of_single_figures():
    """An uncertainty has two digits and the value ends where they end; large numbers are rounded
    too; counts and what was stated are not.
    """
    assert [
        str(shown(*each))
        for each in (
            (0.59312, "mm", 0.588, 0.603),
            (20.17, "µm", 17.0, 25.7),
            (1.234567, "mm", 1.23454, 1.23461),
        )
    ] == [
        "0.593 mm",
        "20.2 µm",
        "1.235 mm",
    ]
    assert shown(20.17, "µm", 13.6, 25.7).between == "14 … 26"
    assert shown(20.17, "µm", 13.6, math.nan).between == "13.6 … ?"
    assert (
        f"{shown(1.5412, 'mm', 1.4738, math.nan)} {shown(1.5412, 'mm', 1.4738, math.inf).between}"
        == "1.54 mm 1.47 … ?"
    )
    assert [
        str(shown(value, "N")) for value in (12345.0, 999.6, 0.09996, 12345, np.int64(12345))
    ] == [
        "12300 N",
        "1000 N",
        "0.100 N",
        "12345 N",
        "12345 N",
    ]
    assert str(shown(12345.0, "mm", stated=True)) == "12345 mm"
    assert str(shown(12345.0, "mm", 11000.0, 14000.0)) == "12300 mm"
    assert str(length(1.2345)) == "1.23 m"
    assert [str(shown(math.nan, "mm")), str(shown(math.inf, "%", 1.0, math.inf))] == [
        "not known",
        "unbounded",
    ]


def test_a_share_is_neither_all_nor_nothing_by_rounding():
    """99.97 % is not all, and 0.004 % not nothing; with an interval a share has the digits of any
    other figure.
    """
    assert [
        str(shown(value, "%")) for value in (99.97, 100.0, 0.0, 0.004, 27.37, 0.1234, 123.4)
    ] == [
        ">99.9 %",
        "100 %",
        "0 %",
        "<0.01 %",
        "27.4 %",
        "0.12 %",
        "123 %",
    ]
    # All shares together miss 100 by the last bits of their sum.
    assert [str(shown(value, "%")) for value in (99.99999999999999, 100.00000000000001, 1e-14)] == [
        "100 %",
        "100 %",
        "0 %",
    ]
    assert str(shown(99.97, "%", 99.91, 99.99)) == "99.97 %"
    assert str(shown(93.421, "%", 92.0, 95.0)) == "93.4 %"
