"""Text with units: what it means, what is refused, and that no text does harm."""

from __future__ import annotations

import copy
import math
import pickle
import time

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from pydantic import BaseModel, ConfigDict, ValidationError
from pydantic_core import PydanticCustomError

from lostmotion.band import Band
from lostmotion.distribution_table import table_rows
from lostmotion.laws.distributions import Table, product_mean
from lostmotion.parts.error_source import (
    AngleDim,
    AngularStiffness,
    ClearanceDim,
    Length,
    LengthDim,
    Share,
)
from lostmotion.unit_registry import (
    _COMMON,
    _UNITS_IN_WORDS,
    UnitError,
    _registry,
    factor,
    unit_in_words,
)
from lostmotion.units import Quantity, Toleranced, read_quantity

ARCMIN = math.pi / 180 / 60


@pytest.mark.parametrize(
    ("text", "si", "value"),
    [
        ("400 mm", "m", 0.4),
        ("60 µm", "m", 60e-6),
        ("60 μm", "m", 60e-6),
        ("60 um", "m", 60e-6),
        ("2 in", "m", 0.0508),
        ("2 cm", "m", 0.02),
        ("0.5 arcmin", "rad", 0.5 * ARCMIN),
        ("0.5'", "rad", 0.5 * ARCMIN),
        ("0.5′", "rad", 0.5 * ARCMIN),
        ("30 arcsec", "rad", 0.5 * ARCMIN),
        ('30"', "rad", 0.5 * ARCMIN),
        ("30″", "rad", 0.5 * ARCMIN),
        ("180 deg", "rad", math.pi),
        ("180°", "rad", math.pi),
        ("-90 °", "rad", -math.pi / 2),
        ("1 rev", "rad", 2 * math.pi),
        ("1 mrad", "rad", 1e-3),
        ("113 N m/arcmin", "N m/rad", 113 / ARCMIN),
        ("113 N·m/arcmin", "N m/rad", 113 / ARCMIN),
        ("113 N*m/arcmin", "N m/rad", 113 / ARCMIN),
        ("31e3 N m/rad", "N m/rad", 31e3),
        ("200 N/µm", "N/m", 2e8),
        ("70 GPa", "Pa", 70e9),
        ("7.85 g/cm^3", "kg/m^3", 7850),
        ("7.85 g/cm**3", "kg/m^3", 7850),
        ("2.2e5 mm^4", "m^4", 2.2e-7),
        ("3 %", "", 0.03),
        ("121", "", 121),
        ("10 lb", "kg", 4.5359237),
        ("1 lbf", "N", 4.4482216152605),
        ("9.81 m/s^2", "m/s^2", 9.81),
        ("  .5e+1   mm ", "m", 0.005),
        ("5. mm", "m", 0.005),
    ],
)
def test_a_quantity_means_what_the_si_brochure_says(text: str, si: str, value: float):
    """Every spelling of a unit that a data sheet uses gives the value in SI that tables of units
    give.
    """
    assert read_quantity(text, si) == Toleranced(pytest.approx(value, rel=1e-14), 0.0)


@pytest.mark.parametrize("sign", ["±", " ± ", "+/-", " +/- ", "+-", " +- "])
def test_a_tolerance_may_be_typed_on_any_keyboard(sign: str):
    """±, +/- and +- all state a tolerance, with or without spaces."""
    assert read_quantity(f"400 mm{sign}50 µm", "m") == Toleranced(
        pytest.approx(0.4), pytest.approx(5e-5)
    )


@pytest.mark.parametrize(
    ("text", "si", "nominal", "tolerance", "law"),
    [
        ("400 mm ± 0.05", "m", 0.4, 5e-5, "normal"),
        ("20 N m/arcmin ± 10 %", "N m/rad", 20 / ARCMIN, 2 / ARCMIN, "normal"),
        ("-5 mm ± 10 %", "m", -0.005, 0.0005, "normal"),
        ("3 % ± 1 %", "", 0.03, 0.01, "normal"),
        ("0.5' ± 12\" (uniform)", "rad", 0.5 * ARCMIN, 0.2 * ARCMIN, "uniform"),
        ("40 µm ± 20 µm (normal)", "m", 4e-5, 2e-5, "normal"),
        ("0 deg ± 1 deg", "rad", 0.0, math.pi / 180, "normal"),
    ],
)
def test_a_tolerance_follows_the_value_or_its_own_unit(
    text: str, si: str, nominal: float, tolerance: float, law: str
):
    """A tolerance without a unit takes the value's, one in per cent is a share of the value, and
    the law may be named.
    """
    found = read_quantity(text, si)
    assert (found.nominal, found.tolerance) == (pytest.approx(nominal), pytest.approx(tolerance))
    assert found.law == law


@pytest.mark.parametrize(
    ("text", "si"),
    [
        ("50 N m", "N m/rad"),
        ("50 N m/rad", "N m"),
        ("50 N/m", "N m/rad"),
        ("1 rad", ""),
        ("1", "rad"),
        ("1 deg", "m"),
        ("400", "m"),
        ("400 ± 0.05 mm", "m"),
        ("400 mm ± 1 deg", "m"),
        ("5 kg", "N"),
        ("5 MPa", "N/m"),
        ("3 %", "m"),
    ],
)
def test_another_dimension_is_refused(text: str, si: str):
    """A torque is no stiffness, an angle no plain number, a mass no force: the reader says which
    dimension was wanted.
    """
    with pytest.raises(UnitError, match="unit of"):
        read_quantity(text, si)


@pytest.mark.parametrize(
    "text",
    [
        "",
        " ",
        "mm",
        "about 5 mm",
        "5 mm 6 mm",
        "5,3 mm",
        "nan m",
        "inf m",
        "5 m ± nan m",
        "0x10 m",
        "1_000 m",
        "5 m; 6 m",
        "5 m\nm",
        "٣ m",
        "5 m (triangular)",
        "5 m ± ",
        "± 5 m",
        "51/m",
        "5 m//s",
        "5 N**m",
        "5 m^2^2",
        "5 m^22",
        "5 __import__('os')",
        "5 m.__class__",
        "5 (m)",
        "5 flurbs",
        "5 Mm m",
        "1e999 m",
        "5 m ± 1e999 m",
        "5 m ± -1 mm",
    ],
)
def test_what_is_no_length_is_refused(text: str):
    """Text that is not one finite number with one length unit raises UnitError, and nothing
    else.
    """
    with pytest.raises(UnitError):
        read_quantity(text, "m")


@pytest.mark.parametrize(
    "text",
    [
        "9" * 100_000 + " m",
        "1 " + "m" * 100_000,
        "1 " + "m " * 50_000,
        "1 m" + "^9" * 50,
        "1 m**9**9**9**9",
        "1 " + "*".join(["m^9"] * 6),
        "1 " + "/".join(["km^-9"] * 6),
        "1e308 " + "*".join(["Gm^9"] * 6),
        "1" * 119 + "m",
        "1 m" + " " * 110 + "±",
        "1" + " " * 60 + "m" + " /" * 20,
        "(" * 10_000,
    ],
)
@pytest.mark.parametrize("si", ["m", ""])
def test_hostile_text_is_refused_at_once(text: str, si: str):
    """No text, however long or nested, keeps the reader busy: it is refused within a fraction of a
    second.
    """
    read_quantity("1 mm", "m")  # the unit table is loaded once
    start = time.perf_counter()
    try:
        found = read_quantity(text, si)
    except UnitError:
        found = None
    assert found is None or text == "1" * 119 + "m"
    assert time.perf_counter() - start < 0.5


@given(
    st.text(alphabet="0123456789.eE+-±%°'\"µμ/*^·() mNradgksPGinoml_[],!@²٣", max_size=40),
    st.sampled_from(sorted(_UNITS_IN_WORDS)),
)
@example("5 m·/m", "")
@example("1 1/1/m", "")
@example("5 %%", "")
@example("5 N m /", "N m")
@settings(deadline=None, max_examples=600)
def test_any_text_is_a_quantity_or_a_unit_error(text: str, si: str):
    """Whatever is typed, the reader gives a finite value with a tolerance that is not negative, or
    raises UnitError: nothing else comes out.
    """
    try:
        found = read_quantity(text, si)
    except UnitError:
        pass
    else:
        assert math.isfinite(found.nominal)
        assert found.tolerance >= 0


UNITS = {
    "m": ("mm", "µm", "m", "in", "km"),
    "rad": ("arcmin", "deg", "mrad", "°", "rev"),
    "N m/rad": ("N m/arcmin", "kN m/rad"),
    "Pa": ("MPa", "GPa"),
}


@given(
    st.sampled_from([(si, unit) for si, units in UNITS.items() for unit in units]),
    st.floats(-1e12, 1e12),
    st.floats(0, 1e9),
    st.sampled_from(["normal", "uniform"]),
)
@settings(deadline=None, max_examples=200)
def test_what_is_written_is_read_again(
    pair: tuple[str, str], value: float, tolerance: float, law: str
):
    """A value and tolerance written in any unit come back as the same SI value: reading is value
    times factor, to the last digit but one.
    """
    si, unit = pair
    one = read_quantity(f"1 {unit}", si).nominal
    found = read_quantity(f"{value!r} {unit} ± {tolerance!r} {unit} ({law})", si)
    assert found.nominal == pytest.approx(value * one, rel=1e-15)
    assert found.tolerance == pytest.approx(tolerance * one, rel=1e-15)
    assert found.law == law
    assert read_quantity(f"{found.nominal!r} {si}", si).nominal == found.nominal


def test_every_dimension_has_a_name_in_words():
    """Every SI unit that fields use is spoken of in users' words, with an example unit."""
    for si in _UNITS_IN_WORDS:
        assert unit_in_words(si) != si
    assert unit_in_words("m^17") == "m^17"


class Sample(BaseModel):
    """Fields of the kinds that parts have."""

    model_config = ConfigDict(extra="forbid")

    length: Length = 0.0
    dimension: LengthDim = Toleranced(0.0)
    clearance: ClearanceDim = Toleranced(0.0)
    tilt: AngleDim = Toleranced(0.0)
    stiffness: AngularStiffness = 1.0
    scatter: Share = 0.0


def refusal(*, from_file: bool = False, **fields: object) -> str:
    """Return the message with which a sample refuses."""
    with pytest.raises(ValidationError) as caught:
        Sample.model_validate(fields, context={"text": from_file})
    return str(caught.value)


def test_from_python_a_number_is_si_and_from_a_file_it_needs_a_unit():
    """From Python 0.4 is 0.4 m; from a file a bare 0.4 is refused, since nobody knows of what; a
    share is a plain number in both.
    """
    assert Sample(length=0.4).length == 0.4
    assert (
        Sample.model_validate({"length": "400 mm", "scatter": 0.1}, context={"text": True}).length
        == 0.4
    )
    assert "a number without a unit" in refusal(length=0.4, from_file=True)


@pytest.mark.parametrize(
    ("fields", "why"),
    [
        ({"stiffness": "50 N m"}, "not a unit of angular stiffness"),
        ({"stiffness": 0.0}, "out of range"),
        ({"stiffness": -5.0}, "out of range"),
        ({"scatter": 0.5}, "out of range"),
        ({"clearance": "20 µm ± 30 µm"}, "the tolerance reaches out of range"),
        ({"clearance": Toleranced(2e-5, 3e-5)}, "the tolerance reaches out of range"),
        ({"clearance": "-1 µm"}, "out of range"),
        ({"dimension": Toleranced(0.4, -1e-5)}, "cannot be negative"),
        ({"dimension": Toleranced(math.nan)}, "not a finite number"),
        ({"dimension": Toleranced(0.4, math.inf)}, "not a finite number"),
        ({"length": "400 mm ± 1 mm"}, "a tolerance is not used here"),
        ({"length": math.inf}, "not a finite number"),
        ({"length": True}, "not a quantity"),
        ({"length": None}, "not a quantity"),
        ({"length": [1.0]}, "not a quantity"),
    ],
)
def test_a_value_out_of_range_is_refused_with_what_was_expected(
    fields: dict[str, object], why: str
):
    """A field refuses what cannot be (negative play, soft nothing, infinite length) and says what
    it takes instead.
    """
    message = refusal(**fields)
    assert why in message
    assert "expected" in message


def test_a_field_says_what_it_takes():
    """A field states its dimension, its range and whether it takes a tolerance."""
    assert (
        Quantity("N m/rad", "1 N m/rad", above=0).expected
        == "angular stiffness (N m/arcmin, N m/rad), above zero"
    )
    assert (
        Quantity("", "10 %", low=0, high=0.33).expected
        == "a plain number or per cent, zero or more, at most 0.33 (33 %)"
    )
    assert Quantity("", "2", low=1).expected == "a plain number, at least 1"
    assert (
        Quantity("m", "1 mm", toleranced=True).expected
        == "length (mm, µm, m, in), with or without ± tolerance"
    )


def test_the_schema_asks_for_text_with_a_unit():
    """The schema states that a length is text, and that a plain number may be either."""
    fields = Sample.model_json_schema()["properties"]
    assert fields["length"]["type"] == "string"
    assert fields["scatter"]["type"] == ["string", "number"]
    assert fields["stiffness"]["examples"] == ["12 N m/arcmin"]


@pytest.mark.parametrize(
    ("text", "law"),
    [
        ("400 mm ± 50 µm", "normal"),
        ("400 mm ± 50 µm (uniform)", "uniform"),
        ("400 mm ± 50 µm (normal without limits)", "normal without limits"),
    ],
)
def test_a_word_behind_a_tolerance_is_its_distribution(text: str, law: str):
    """A length takes each distribution by its word in brackets, or with its value in a table."""
    field = Quantity("m", "400 mm ± 50 µm", toleranced=True, any_law=True)
    assert field(text) == Toleranced(0.4, pytest.approx(5e-5), law)
    assert field({"value": "400 mm ± 50 µm", "law": law}) == Toleranced(
        0.4, pytest.approx(5e-5), law
    )


def test_a_tolerance_takes_a_table():
    """Rows of value and probability stand beside the value, as shares of its tolerance."""
    field = Quantity("m", "400 mm ± 50 µm", toleranced=True, any_law=True)
    assert field({"value": "400 mm ± 50 µm", "law": [[-1, 0], [0.2, 0.5], [1, 1]]}).law == (
        (-1.0, 0.0),
        (0.2, 0.5),
        (1.0, 1.0),
    )


@pytest.mark.parametrize(
    ("value", "why"),
    [
        ({"value": "400 mm ± 50 µm", "law": [[-1, 0], [1, 0.9]]}, "from 0 to 0.9, not from 0 to 1"),
        ({"value": "400 mm ± 50 µm", "law": [[1, 0], [-1, 1]]}, "do not rise"),
        ({"value": "400 mm ± 50 µm", "law": [[-1, 0], [0, 0], [1, 1]]}, "do not rise"),
        ({"value": "400 mm ± 50 µm", "law": [[0, 0], [5e-324, 0.5], [1, 1]]}, "do not rise"),
        ({"value": "400 mm ± 50 µm", "law": [[-1, 0], [0, 1e-300], [1, 1]]}, "do not rise"),
        ({"value": "400 mm ± 50 µm", "law": [[-1, 0], [float("inf"), 1]]}, "two finite numbers"),
        ({"value": "400 mm ± 50 µm", "law": [[-1, 0, 3], [1, 1]]}, "two finite numbers"),
        ({"value": "400 mm ± 50 µm", "law": [[1, 0], [1 + 1e-9, 1]]}, "hardly differ"),
        ({"value": "400 mm ± 50 µm", "law": [[0, 0]]}, "2 to 1000 rows"),
        ({"value": "400 mm ± 50 µm", "law": "gaussian"}, "not a known distribution"),
        ({"value": "400 mm ± 50 µm"}, "exactly the keys value"),
        ({"value": "400 mm", "law": "normal without limits"}, "without a ± tolerance"),
    ],
)
def test_a_table_that_is_no_distribution_is_refused(value: object, why: str):
    """A table that does not rise from probability 0 to 1, or a word that names none, says what is
    wrong with it.
    """
    with pytest.raises(PydanticCustomError, match=why):
        Quantity("m", "400 mm ± 50 µm", toleranced=True, any_law=True)(value)


def test_a_play_has_limits():
    """A play, a fit or a size is checked at its limits: a distribution without any is refused
    there.
    """
    with pytest.raises(PydanticCustomError, match="limits must hold"):
        Quantity("rad", "0.5 arcmin ± 0.2 arcmin", low=0, toleranced=True)(
            "0.5 arcmin ± 0.2 arcmin (normal without limits)"
        )


@given(
    st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=8),
    st.lists(st.floats(1e-6, 1.0), min_size=7, max_size=7),
)
@settings(deadline=None, max_examples=200)
def test_every_table_that_is_taken_is_a_distribution(values: list[float], steps: list[float]):
    """Whatever a table holds, it is refused, or its draws have mean zero, variance one, and stay
    within their bound.
    """
    edges = [0.0]
    for step in steps[: len(values) - 1]:
        edges.append(edges[-1] + step)
    rows = [[value, edge / edges[-1]] for value, edge in zip(sorted(values), edges, strict=True)]
    try:
        table = Table(table_rows(rows))
    except UnitError:
        return
    assert product_mean((table,)) == pytest.approx(0, abs=1e-6)
    assert product_mean((table, table)) == pytest.approx(1, rel=1e-6)
    u = np.linspace(0, 1, 1001)[1:-1]
    assert np.abs(table.quantile(u)).max() <= table.bound * (1 + 1e-12)


@pytest.mark.parametrize(
    "text", ["1.3 .. 3.0 GPa", "1.3..3 GPa", "1300 MPa .. 3 GPa", "1.3 GPa .. 3", " 1.3e0 ..3.GPa "]
)
def test_a_range_has_a_unit_at_either_end(text: str):
    """A range of a modulus has the geometric mean as its number, and one of a dimension the
    arithmetic mean.
    """
    modulus = Quantity("Pa", "70 GPa", above=0, band="log-uniform")(text)
    assert isinstance(modulus, Band)
    assert (modulus.low, modulus.high) == (pytest.approx(1.3e9), pytest.approx(3e9))
    assert modulus == pytest.approx(math.sqrt(1.3 * 3.0) * 1e9, rel=1e-14)
    assert modulus.at(0.25) == pytest.approx(1.3e9 * (3.0 / 1.3) ** 0.25)
    assert Quantity("Pa", "70 GPa", band="uniform")(text) == pytest.approx(2.15e9, rel=1e-14)


def test_a_size_may_be_both_unknown_and_scattered():
    """A dimension takes a range of its nominal value, the tolerance of each part, or both."""
    found = Quantity("m", "40 mm", above=0, toleranced=True, band="uniform")(
        "12 .. 12.2 mm ± 0.05 mm"
    )
    assert isinstance(found, Toleranced)
    assert found == Toleranced(pytest.approx(0.0121), pytest.approx(5e-5))
    assert repr(found.nominal) == "Band(0.012, 0.012199999999999999, 'uniform')"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("3 .. 1.3 mm", "ends do not rise"),
        ("3 .. 3 mm", "ends do not rise"),
        ("3 mm .. 0.003 m", "ends do not rise"),
        ("-1 .. 3 mm", "out of range"),
        ("1 .. 5 mm", "out of range"),
        ("1 .. 1e999 mm", "not a finite number"),
        ("1 .. 3 kg", "not a unit of length"),
        ("1 .. 3", "unit of length"),
        ("1 .. 2 .. 3 mm", "not a number with a unit"),
        ("1 ... 3 mm", "not a number with a unit"),
        ("1 .. mm", "not a number with a unit"),
    ],
)
def test_a_range_that_cannot_be_is_refused(text: str, why: str):
    """A range that falls, is empty or leaves the limits of its field says so."""
    with pytest.raises(PydanticCustomError, match=why) as caught:
        Quantity("m", "4 mm", above=0, high=0.004, band="uniform")(text)
    assert "at most 0.004 m, or a range a .. b" in str(caught.value)


def test_a_range_is_refused_where_one_value_is_needed():
    """A field without ranges says that it takes one value."""
    assert "a range a .. b is not used here: state one value" in refusal(length="1 .. 2 mm")
    assert "a range a .. b is not used here: state one value" in refusal(scatter=Band(0.1, 0.2))


def test_a_range_survives_a_copy():
    """Copies, also between processes, have the same limits and distribution."""
    band = Band(1.0, 4.0, "log-uniform")
    for copied in (copy.deepcopy(band), pickle.loads(pickle.dumps(band))):  # noqa: S301 - our own bytes
        assert repr(copied) == "Band(1.0, 4.0, 'log-uniform')"
        assert copied == 2.0


def test_a_power_of_zero_is_no_unit():
    """A metre to the power of zero is refused in words: the unit library itself fails on it."""
    with pytest.raises(UnitError, match=r"'m\^0' is not a known unit"):
        read_quantity("3 m^0", "m")


@pytest.mark.parametrize("unit", _COMMON)
def test_the_units_of_most_files_are_those_of_the_registry(unit):
    """To the last bit; and of another dimension they are refused as by it."""
    si, size = _COMMON[unit]
    registry = _registry()
    plain = registry.parse_units(unit.replace("%", "pct"))
    assert registry.Quantity(1.0, plain).to(registry.parse_units(si)).magnitude == size
    assert factor(unit, si) == size
    with pytest.raises(UnitError, match="unit of"):
        factor(unit, "m^4")


@pytest.mark.parametrize(("unit", "size"), [("%", 0.01), ("µm/m", 1e-6), ("", 1.0)])
def test_a_share_is_a_number_by_either_name(unit, size):
    """Of dimension "" or "1"."""
    assert factor(unit, "1") == factor(unit, "") == size
