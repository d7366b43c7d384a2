"""What went in, as a report prints it: units, states and sources."""

from __future__ import annotations

from pathlib import Path

import pytest

import lostmotion
from lostmotion.band import Band
from lostmotion.error_model.given_values import given_in_part
from lostmotion.error_model.provenance import states
from lostmotion.parts.error_source import Friction
from lostmotion.reporting.inputs import _quantities, inputs_section, value_text
from lostmotion.reporting.laws_used import laws_section
from lostmotion.units import Quantity, Toleranced, read_quantity

EXAMPLES = Path(__file__).parents[2] / "examples"
AS_A_FILE_WRITES = str.maketrans({"²": "^2", "³": "^3", "⁴": "^4", "°": "deg"})
ARM = """name = "two"
[gearboxes.small]
backlash = "1 arcmin ± 0.5 arcmin"
stiffness = "20 N m/arcmin"
friction_torque = "1 N m ± 20 %"
assumed = ["stiffness"]
source = "data sheet"
[[joints]]
name = "A"
type = "revolute"
limits = ["-90 deg", "90 deg"]
gearbox = "small"
[[joints]]
name = "B"
type = "revolute"
limits = ["-90 deg", "90 deg"]
gearbox = "small"
assumed = ["limits"]
"""


@pytest.mark.parametrize(
    "file",
    ["z-arm.toml", "arm-from-drawings.toml", "gantry.toml", "printed-hobby-arm.toml", "ur5e.urdf"],
)
def test_a_printed_value_reads_back_as_what_the_part_holds(file):
    """Every number with a unit, and its tolerance, is that of the part to four digits when its text
    is read as a file's would be.
    """
    read = 0
    for given in states(lostmotion.read(EXAMPLES / file)).given:
        value = given.value.load if isinstance(given.value, Friction) else given.value
        quantity = next(iter(_quantities(given.part, given.key)), None)
        if (
            quantity is None
            or isinstance(value, bool | Band)
            or not isinstance(value, int | float | Toleranced)
        ):
            continue
        text = value_text(value, quantity).replace("deg C", "°C").partition(" (")[0]
        nominal, tolerance = (
            (value.nominal, value.tolerance) if isinstance(value, Toleranced) else (value, 0.0)
        )
        if not nominal or "µm/(m K)" in value_text(value, quantity):
            continue
        found = read_quantity(text.translate(AS_A_FILE_WRITES), quantity.si)
        assert (found.nominal, found.tolerance) == (
            pytest.approx(nominal, rel=6e-4),
            pytest.approx(tolerance, rel=6e-4),
        ), (given, text)
        read += 1
    assert read > 25


@pytest.mark.parametrize(
    ("value", "quantity", "text"),
    [
        (Toleranced(0.4, 50e-6), Quantity("m", "1 mm", toleranced=True), "400 mm ± 50 µm"),
        (
            Toleranced(311.15, 10.0),
            Quantity("K above absolute zero", "35 °C", toleranced=True),
            "38 °C ± 10 K",
        ),
        (
            Toleranced(0.0, 30e-6, "uniform"),
            Quantity("m", "1 mm", toleranced=True),
            "0 ± 30 µm (uniform)",
        ),
        (9.69627362e-5, Quantity("rad", "1 arcmin"), "20 arcsec"),
        ((-2.61799387799, 0.0), Quantity("rad", "1 arcmin"), "-150, 0 °"),
        (0.1, Quantity("", "10 %"), "10 %"),
        (2.3e-5, Quantity("1/K", "23e-6 1/K"), "23 µm/(m K)"),
        (Band(1.3e9, 3e9), Quantity("Pa", "70 GPa", band="uniform"), "1.3 to 3 GPa"),
        (True, None, "yes"),
        (tuple(tuple(range(6)) for _ in range(6)), None, "table of 6 rows"),
    ],
)
def test_a_value_has_the_unit_of_its_size(value, quantity, text):
    """No power of ten and no digit that nobody stated: lengths in µm, mm or m, angles in arcsec,
    arcmin or degrees.
    """
    assert value_text(value, quantity) == text


def test_stated_assumed_and_ideal_values_are_marked(tmp_path):
    """Each value has its state and its source; a gearbox that two joints share is listed once; what
    nothing describes is named as ideal.
    """
    (tmp_path / "arm.toml").write_text(ARM, encoding="utf-8")
    known = states(lostmotion.read(tmp_path / "arm.toml"))
    (section,) = inputs_section(known.given, known)
    rows = [(row.label, row.cells[0].words, row.cells[1].words, row.note) for row in section.rows]
    assert (
        "gearboxes.small",
        "backlash 1 arcmin ± 0.5 arcmin; friction_torque 1 N m ± 0.2 N m",
        "stated",
        "data sheet",
    ) in rows
    assert ("gearboxes.small", "stiffness 20 N m/arcmin", "assumed", "data sheet") in rows
    assert ("B", "limits -90, 90 °", "assumed", "") in rows
    assert "B.gearbox" not in [row[0] for row in rows]
    assert ("encoder", "nothing described: every joint", "ideal", "") in rows
    assert section.folded.startswith("3 values stated, 2 assumed, ")


def test_values_of_a_part_that_is_assumed_as_a_whole_are_assumed(tmp_path):
    """A joint that marks its gearbox as assumed is one assumed value, and none of the gearbox'
    values is shown as stated.
    """
    (tmp_path / "arm.toml").write_text(
        ARM.replace('assumed = ["limits"]', 'assumed = ["limits", "gearbox"]'), encoding="utf-8"
    )
    arm = lostmotion.read(tmp_path / "arm.toml")
    shown = given_in_part(arm.joints[1], "joints.B")
    assert {each.state for each in shown if each.owner == "gearboxes.small"} == {"assumed"}
    assert [each.key for each in shown if each.reason] == ["limits", "gearbox", "stiffness"]


@pytest.mark.parametrize(
    ("file", "some", "none"),
    [
        (
            "z-arm.toml",
            ("Timoshenko", "Nabtesco", "JCGM 101:2008"),
            ("Muskhelishvili", "Gates Mectrol"),
        ),
        ("gantry.toml", ("Gates Mectrol",), ("Litvin",)),
        (
            "arm-from-drawings.toml",
            ("Litvin", "ISO/TS 16281:2008", "K. Johnson, Contact Mechanics"),
            ("Gates Mectrol",),
        ),
    ],
)
def test_the_laws_are_those_of_the_parts(file, some, none):
    """Each law of a part that the arm has is listed once with its source, and none of parts that it
    does not have.
    """
    (section,) = laws_section(states(lostmotion.read(EXAMPLES / file)).given)
    sources = [row.cells[0].words for row in section.rows]
    assert len({row.label for row in section.rows}) == len(section.rows)
    assert all(any(each in source for source in sources) for each in some)
    assert not any(each in source for source in sources for each in none)


def test_tolerances_by_direction_are_written_out():
    """Of a mounting, one for each axis; a long list by its size."""
    stated = (Toleranced(0.0, 2e-5), Toleranced(0.0), Toleranced(0.0, 5e-5, "uniform"))
    assert value_text(stated, Quantity("m", "20 µm")) == "0 ± 20 µm, 0, 0 ± 50 µm (uniform)"
    assert value_text(stated * 3, Quantity("m", "20 µm")) == "table of 9 rows"
