"""Temperatures in arm files: the table [environment], the expansion of materials and links, and
what is refused.
"""

from __future__ import annotations

import pytest

import lostmotion
from lostmotion.io.part_file import read_bearing
from lostmotion.unit_registry import ABSOLUTE
from lostmotion.units import UnitError, read_quantity

ARM = """
name = "warm"
[[joints]]
name = "A"
type = "revolute"
limits = ["-90 deg", "90 deg"]
link = { length = "400 mm", section = "tube", material = "own", up = "z"__LINK__ }
[sections.tube]
kind = "tube"
outer = "60 mm"
wall = "3 mm"
[materials.own]
young = "70 GPa"
poisson = 0.33
density = "2700 kg/m^3"
expansion = "23 µm/m/K"
[environment]
temperature = "35 °C ± 5 K"
"""


def written(tmp_path, text: str):
    """Return the path of a file with this text."""
    path = tmp_path / "arm.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("text", "kelvin", "tolerance"),
    [
        ("35 °C", 308.15, 0.0),
        ("35 degC ± 5", 308.15, 5.0),
        ("308.15 K ± 5 K", 308.15, 5.0),
        ("-10 °C ± 3 K (uniform)", 263.15, 3.0),
        ("95 °F ± 9 °F", 308.15, 5.0),
    ],
)
def test_a_temperature_is_read_on_its_scale_and_its_tolerance_is_a_difference(
    text: str, kelvin: float, tolerance: float
):
    """35 °C, 308.15 K and 95 °F are one temperature; ± 5 K and ± 9 °F are one difference."""
    found = read_quantity(text, ABSOLUTE)
    assert found.nominal == pytest.approx(kelvin, rel=1e-12)
    assert found.tolerance == pytest.approx(tolerance, rel=1e-12, abs=0)


@pytest.mark.parametrize("text", ["35", "35 mm", "35 °C ± 5 %", "35 °C ± 1 mm", "35 %"])
def test_what_is_no_temperature_is_refused(text: str):
    """A number without a scale, a length, and a share of a temperature are refused."""
    with pytest.raises(UnitError, match="temperature"):
        read_quantity(text, ABSOLUTE)


def test_a_file_states_temperature_expansion_and_differences(tmp_path):
    """All four keys arrive in SI; the reference temperature is 20 °C unless stated."""
    arm = lostmotion.read(
        written(tmp_path, ARM.replace("__LINK__", ', temperature_difference = "4 K ± 2 K"'))
    )
    assert arm.environment.rise.nominal == pytest.approx(15.0)
    assert arm.environment.rise.tolerance == pytest.approx(5.0)
    link = arm.joints[0].link
    assert link.material.expansion == pytest.approx(23e-6)
    assert (link.temperature_difference.nominal, link.temperature_difference.tolerance) == (
        4.0,
        2.0,
    )
    names = {placed.term.name for placed in arm.terms}
    assert {
        "thermal expansion",
        "temperature variation",
        "thermal bending",
        "temperature difference variation",
    } <= names
    other = lostmotion.read(
        written(
            tmp_path,
            ARM.replace("__LINK__", "")
            + 'reference_temperature = "300 K"\ntemperature_varies = "visit"\n',
        )
    )
    assert other.environment.rise.nominal == pytest.approx(8.15)
    assert {
        placed.term.level for placed in other.terms if placed.term.name == "temperature variation"
    } == {"visit"}


@pytest.mark.parametrize(
    ("old", "new", "key", "said"),
    [
        (
            '"35 °C ± 5 K"',
            '"35"',
            "environment.temperature",
            "temperature (°C, K), at least -100 °C, at most 200 °C",
        ),
        ('"35 °C ± 5 K"', '"35 K"', "environment.temperature", "out of range"),
        ('"35 °C ± 5 K"', "35", "environment.temperature", "a number without a unit"),
        ('"35 °C ± 5 K"', '"35 °C ± 5 %"', "environment.temperature", "35 °C ± 5 K"),
        ("temperature =", "temperatur =", "environment.temperatur", "temperature"),
        (
            "temperature =",
            'temperature_varies = "day"\ntemperature =',
            "environment.temperature_varies",
            "visit",
        ),
        (
            "__LINK__",
            ', temperature_difference = "10 °C"',
            "joints.A.link.temperature_difference",
            "temperature difference (K)",
        ),
        (
            "__LINK__",
            ', temperature_difference = "900 K"',
            "joints.A.link.temperature_difference",
            "at most 200 K",
        ),
        ("__LINK__", ', expansion = "23e-6"', "joints.A.link.expansion", "23e-6 1/K"),
        ('"23 µm/m/K"', '"23 1/K"', "materials.own.expansion", "at most 0.001 1/K"),
        (
            'up = "z"__LINK__',
            'rigid = true, temperature_difference = "5 K"',
            "joints.A.link",
            "one of the two",
        ),
    ],
)
def test_a_mistake_is_reported_under_its_key(tmp_path, old: str, new: str, key: str, said: str):
    """Each mistake is one problem with what was found, what is expected, and an example."""
    text = ARM.replace(old, new).replace("__LINK__", "")
    with pytest.raises(lostmotion.InputError) as refused:
        lostmotion.read(written(tmp_path, text))
    assert [problem.key for problem in refused.value.problems] == [key]
    assert said in str(refused.value)
    assert refused.value.problems[0].example


def test_a_sidecar_states_the_temperature_of_a_urdf(tmp_path):
    """A URDF says nothing of temperature; its sidecar states that of the robot and the expansion of
    its links.
    """
    urdf = "examples/ur5e.urdf"
    sidecar = tmp_path / "side.toml"
    sidecar.write_text(
        (
            '[environment]\ntemperature = "30 °C"\n[joints.elbow_joint]\nlink = { expansion = '
            '"23e-6 1/K" }\n'
        ),
        encoding="utf-8",
    )
    arm = lostmotion.read(urdf, sidecar=sidecar)
    (grown,) = [placed.owner for placed in arm.terms if placed.term.name == "thermal expansion"]
    assert grown == "joints.elbow_joint.link"


def test_the_bearing_of_an_arm_is_examined_at_the_temperature_of_the_arm():
    """The working clearance on the sheet of one bearing is the one that the arm works with: 18 K
    loosen its aluminium housing by 20.8 µm.
    """
    file = "examples/arm-in-the-sun.toml"
    found = read_bearing(file, "elbow").part
    cold = lostmotion.read(file).joints[2].bearing
    assert found.temperature_rise == pytest.approx(18.0)
    assert (
        found.working.nominal > cold.working.nominal + 0.8 * 10.5e-6 * 18 * 0.11 * 110 / 113 * 0.9
    )
    assert found.spreads["mounted"] == cold.spreads["mounted"]
