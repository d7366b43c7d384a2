"""Clearances and fits by the standards' names, in an arm and in a file about a bearing."""

from __future__ import annotations

import pytest

import lostmotion
from lostmotion import InputError
from lostmotion.catalogue.clearances import (
    clearance_of_group,
    delivered_clearance,
    interference_of_zone,
)
from lostmotion.io.part_file import read_bearing
from tests.io.conftest import EXAMPLES

UM = 1e-6
BALLS = """kind = "ball pair"
bore = "45 mm"
outside_diameter = "85 mm"
balls = 9
ball_diameter = "12.7 mm"
pitch_diameter = "65 mm"
span = "60 mm"
"""
ROLLERS = """kind = "roller pair"
bore = "60 mm"
outside_diameter = "110 mm"
rollers = 16
roller_diameter = "14 mm"
roller_length = "14 mm"
pitch_diameter = "86 mm"
span = "80 mm"
"""
ARM = 'name = "arm"\n[[joints]]\nname = "A"\ntype = "revolute"\nlimits = ["0 deg", "1 deg"]\n'


@pytest.fixture
def file(tmp_path):
    """Write a file and return its path."""

    def write(text):
        path = tmp_path / "bearing.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_group_and_zones_become_dimensions(file):
    """CN, k5 and H7 of a 6209: the bands of ISO 5753-1, ISO 286-2 and ISO 492, by hand."""
    part = read_bearing(
        file("[bearing]\n" + BALLS + 'clearance = "CN"\nshaft_fit = "k5"\nhousing_fit = "H7"\n')
    ).part
    assert part.clearance.nominal == pytest.approx((6 + 23) / 2 * UM)
    assert part.clearance.tolerance == pytest.approx((23 - 6) / 2 * UM)
    assert part.clearance.law == "uniform"
    # shaft +2 … +13 in a bore -12 … 0: tight by 2 … 25 µm; ring -15 … 0 in a housing 0 … +35: loose
    # by 0 … 50 µm
    assert part.shaft_interference.nominal == pytest.approx((2 + 25) / 2 * UM)
    assert part.shaft_interference.tolerance == pytest.approx((25 - 2) / 2 * UM)
    assert part.housing_interference.nominal == pytest.approx(-25 * UM)
    assert part.housing_interference.tolerance == pytest.approx(25 * UM)


def test_the_same_from_python():
    """What a file names can be had in Python by the same names."""
    low, high = delivered_clearance("deep-groove ball", 0.045, "C3")
    found = clearance_of_group("deep-groove ball", 0.045, "C3")
    assert (found.nominal - found.tolerance, found.nominal + found.tolerance) == pytest.approx(
        (low, high)
    )
    assert interference_of_zone("shaft", 0.045, "k5").nominal == pytest.approx(13.5 * UM)


def test_the_warning_appears_from_a_file(file):
    """A normal-class cylindrical roller bearing above 50 mm bore: the paper's 60 µm do not hold,
    and the sheet and the arm say so.
    """
    said = read_bearing(file("[bearing]\n" + ROLLERS + 'clearance = "CN"\n')).notes
    assert any("60 µm does not hold" in note for note in said)
    arm = lostmotion.read(file(ARM + "[joints.bearing]\n" + ROLLERS + 'clearance = "CN"\n'))
    assert any("60 µm does not hold" in note for note in arm.notes)
    shared = lostmotion.read(
        file(ARM + 'bearing = "wide"\n[bearings.wide]\n' + ROLLERS + 'clearance = "CN"\n')
    )
    assert shared.joints[0].bearing == arm.joints[0].bearing
    assert any("60 µm does not hold" in note for note in shared.notes)
    assert any(
        "60 µm does not hold" in note
        for note in read_bearing(EXAMPLES / "bearing" / "nu212-pair.toml").notes
    )


@pytest.mark.parametrize(
    "text",
    [
        BALLS + 'clearance = "CN"\n',
        ROLLERS + 'clearance = "C2"\n',
        ROLLERS + 'clearance = "50 µm ± 5 µm"\n',
    ],
)
def test_no_warning_without_need(file, text):
    """Balls, a tighter group or a stated clearance raise no doubt."""
    assert read_bearing(file("[bearing]\n" + text)).notes == ()


@pytest.mark.parametrize(
    ("text", "key", "said"),
    [
        ('clearance = "C5"', "bearing.clearance", "C2, CN, C3, C4"),
        ('clearance = "cn"', "bearing.clearance", "C2, CN, C3, C4"),
        ("clearance = 3", "bearing.clearance", "without a unit"),
        ('clearance = "large"', "bearing.clearance", "length"),
        ('shaft_fit = "q5"', "bearing.shaft_fit", "k5"),
        ("shaft_fit = 5", "bearing.shaft_fit", "zone"),
        ('housing_fit = "h7"', "bearing.housing_fit", "H7"),
        ('shaft_fit = "k5"\nshaft_interference = "10 µm"', "bearing.shaft_fit", "one of the two"),
        ('shaft_fut = "k5"', "bearing.shaft_fut", "shaft_fit"),
        ('inner_ring_warmer = "5 mm"', "bearing.inner_ring_warmer", "temperature"),
        ('finish = "rough"', "bearing.finish", "ground"),
        ('contact_angle = "80 deg"', "bearing.contact_angle", "at most"),
    ],
)
def test_mistakes_are_reported_under_their_key(file, text, key, said):
    """What no standard names is refused with what there is."""
    with pytest.raises(InputError) as refused:
        read_bearing(file("[bearing]\n" + BALLS + text + "\n"))
    assert [problem.key for problem in refused.value.problems] == [key]
    assert said in str(refused.value)
    assert refused.value.problems[0].example


def test_sizes_beyond_the_tables_name_the_nearest_row(file):
    """A bore that the tables do not hold is refused with the nearest range, for the group and for
    the fit.
    """
    with pytest.raises(InputError) as refused:
        read_bearing(
            file(
                "[bearing]\n"
                + ROLLERS.replace('"60 mm"', '"2 mm"')
                + 'clearance = "CN"\nshaft_fit = "k5"\n'
            )
        )
    assert {problem.key for problem in refused.value.problems} == {"bearing.shaft_fit"}
    assert "over 3 to 250 mm" in refused.value.problems[0].expected
    # no zone helps there
    assert refused.value.problems[0].example.startswith("shaft_interference = ")
    with pytest.raises(InputError, match="the nearest row is over 80 to 100 mm"):
        read_bearing(
            file("[bearing]\n" + BALLS.replace('"45 mm"', '"145 mm"') + 'clearance = "CN"\n')
        )


def test_crossed_rollers_have_no_group(file):
    """The standard's groups are for other bearings: a crossed roller's clearance is a length."""
    text = ROLLERS.replace("roller pair", "crossed roller bearing").replace('span = "80 mm"\n', "")
    with pytest.raises(InputError, match="no groups"):
        read_bearing(file("[bearing]\n" + text + 'clearance = "C2"\n'))
    assert read_bearing(
        file("[bearing]\n" + text + 'clearance = "-5 µm ± 3 µm"\n')
    ).part.clearance.nominal == pytest.approx(-5 * UM)
