"""Reducers by name in an arm file."""

from __future__ import annotations

import pytest

from lostmotion.io import read
from tests.io.conftest import JOINT, mistakes_in  # noqa: F401 - the fixture
from tests.parts.conditions import ARCMIN

HEAD = 'name = "x"\n'


def arm_from(tmp_path, text):
    """Read an arm from text."""
    path = tmp_path / "arm.toml"
    path.write_text(HEAD + text, encoding="utf-8")
    return read(path)


@pytest.mark.parametrize(
    "text",
    [
        JOINT + 'gearbox = "RV-40E-121"\n',
        JOINT + 'gearbox = { catalogue = "RV-40E", ratio = 121 }\n',
        JOINT + 'gearbox = { catalogue = "RV-40E", ratio = "121" }\n',
        JOINT + 'gearbox = "s"\n[gearboxes.s]\ncatalogue = "RV-40E-121"\n',
    ],
)
def test_a_reducer_is_named_in_three_ways(tmp_path, text):
    """By itself, inside a gearbox that adds to it, or as a shared part: the same gearbox, and a
    note with its source.
    """
    arm = arm_from(tmp_path, text)
    gearbox = arm.moving[0].gearbox
    assert gearbox.ratio == 121
    assert gearbox.stiffness == pytest.approx(108 / ARCMIN)
    (note,) = arm.notes
    assert "upper limit" in note
    assert "(not verified, 95 % confidence)" in note
    assert "[M" not in gearbox.source
    assert "(not verified, 95 % confidence)" in gearbox.source


def test_stated_values_have_priority(tmp_path):
    """A measured backlash and transmission error replace the catalogue's values and its missing
    ones.
    """
    arm = arm_from(
        tmp_path,
        JOINT
        + (
            'gearbox = { catalogue = "CSG-25", ratio = 100, backlash = "0.1 arcmin", '
            'transmission_error = "0.3 arcmin" }\n'
        ),
    )
    gearbox = arm.moving[0].gearbox
    assert gearbox.play.nominal == pytest.approx(0.1 * ARCMIN)
    assert gearbox.transmission_error == pytest.approx(0.3 * ARCMIN)
    assert gearbox.zones == [31e3, 50e3, 57e3]


def test_a_shared_gearbox_has_priority_over_the_catalogue(tmp_path):
    """A gearbox table of the file named RV-40E replaces the catalogue's."""
    arm = arm_from(tmp_path, JOINT + 'gearbox = "RV-40E"\n[gearboxes.RV-40E]\nratio = 7\n')
    assert arm.moving[0].gearbox.ratio == 7
    assert arm.moving[0].gearbox.stiffness is None
    assert arm.notes == ()


def test_two_joints_of_one_reducer_are_noted_once(tmp_path):
    """The note is about the reducer, however many joints have it."""
    arm = arm_from(
        tmp_path,
        JOINT
        + 'gearbox = "RV-40E-121"\n'
        + JOINT.replace('"A"', '"B"')
        + 'gearbox = "RV-40E-121"\n',
    )
    assert len(arm.notes) == 1


@pytest.mark.parametrize(
    ("text", "key", "expected"),
    [
        (JOINT + 'gearbox = "catalogue"\n', "joints.A.gearbox", "one gearbox"),
        (JOINT + 'gearbox = "RV-41E"\n', "joints.A.gearbox", "a reducer of the catalogue"),
        (JOINT + 'gearbox = "CSG-25"\n', "joints.A.gearbox", "above 50"),
        (
            JOINT + 'gearbox = { catalogue = "CSG-25-40" }\n',
            "joints.A.gearbox.catalogue",
            "above 50",
        ),
        (
            JOINT + 'gearbox = { catalogue = "RV-40E-121", ratio = 81 }\n',
            "joints.A.gearbox.catalogue",
            "one ratio",
        ),
        (JOINT + "gearbox = { catalogue = 3 }\n", "joints.A.gearbox.catalogue", "the name"),
        (
            JOINT + 'gearbox = { catalogue = "CSG-25", ratio = "12 mm" }\n',
            "joints.A.gearbox.ratio",
            "number",
        ),
        (
            JOINT + 'gearbox = { catalogue = "CSG-25", ratio = [1] }\n',
            "joints.A.gearbox.ratio",
            "number",
        ),
        (
            JOINT + 'gearbox = { catalogue = "RV-40E", ratio = -3 }\n',
            "joints.A.gearbox.ratio",
            "number",
        ),
        (JOINT + 'gearbox = { catalog = "RV-40E" }\n', "joints.A.gearbox.catalog", "catalogue"),
        (
            JOINT + 'gearbox = "g"\n[gearboxes.g]\ncatalogue = "RV-41E"\n',
            "gearboxes.g.catalogue",
            "a reducer of the catalogue",
        ),
        (
            JOINT + 'gearbox = "RV-40E"\nencoder = { eccentricity = "3 arcmin" }\n',
            "joints.A.gearbox",
            "the ratio behind the name",
        ),
        (
            JOINT + 'gearbox = "RV-40E"\nencoder = "e"\n[encoders.e]\nnoise = "1 arcmin"\n',
            "joints.A.gearbox",
            "the ratio behind the name",
        ),
        (
            HEAD[:0]
            + JOINT.replace("revolute", "prismatic").replace("deg", "mm")
            + 'gearbox = "RV-40E"\n',
            "joints.A.gearbox",
            "lengths and forces",
        ),
    ],
)
def test_a_mistake_is_reported_once_under_its_key(mistakes_in, text, key, expected):  # noqa: F811 - the fixture
    """A wrong name, a missing or impossible ratio, a prismatic joint: each is reported once, under
    the key in the file.
    """
    found = mistakes_in(HEAD + text)
    assert list(found) == [key]
    assert expected in found[key].expected


def test_an_encoder_on_the_output_needs_no_ratio(tmp_path):
    """The ratio matters only where the encoder's errors are divided by it."""
    arm = arm_from(
        tmp_path,
        JOINT + 'gearbox = "RV-40E"\nencoder = { side = "output", noise = "0.1 arcmin" }\n',
    )
    assert arm.moving[0].encoder.side == "output"


def test_the_nearest_name_is_offered(mistakes_in):  # noqa: F811 - the fixture
    """A misspelt reducer is refused with the nearest one; a misspelt shared gearbox with the
    nearest shared one, even where reducers are close.
    """
    assert mistakes_in(HEAD + JOINT + 'gearbox = "RV-42"\n')["joints.A.gearbox"].nearest == "RV-42N"
    text = HEAD + "[gearboxes.RV-42own]\nratio = 3\n" + JOINT + 'gearbox = "RV-42ow"\n'
    assert mistakes_in(text)["joints.A.gearbox"].nearest == "RV-42own"


@pytest.mark.parametrize(
    ("gearbox", "key", "near"),
    [
        ("{ ratoi = 3 }", "joints.A.gearbox.ratoi", "ratio"),
        (
            '{ kind = "planetery", sun_teeth = 20, ring_teeth = 70 }',
            "joints.A.gearbox.kind",
            "planetary",
        ),
        (
            '{ kind = "planetary", sun_teeth = 20, ring_teeth = 70, planetteeth = 25 }',
            "joints.A.gearbox.planetteeth",
            "planet_teeth",
        ),
        (
            '{ kind = "planetary", sun_teeth = 20, ring_teeth = 70, catalogue = "RV-40E" }',
            "joints.A.gearbox.catalogue",
            "",
        ),
        ('{ kind = "planetary", sun_teeth = 20, ring_teeth = 71 }', "joints.A.gearbox", ""),
        (
            '{ kind = "planetary", sun_teeth = 20, ring_teeth = "70 mm" }',
            "joints.A.gearbox.ring_teeth",
            "",
        ),
    ],
)
def test_a_mistake_in_a_kind_of_gearbox_is_reported(mistakes_in, gearbox, key, near):  # noqa: F811 - the fixture
    """A wrong key without a kind, a wrong kind, a wrong key in a kind, teeth that do not fit: one
    mistake each, where it stands, with the nearest.
    """
    found = mistakes_in(HEAD + JOINT + f"gearbox = {gearbox}\n")
    assert list(found) == [key]
    assert found[key].nearest == near


def test_a_gearbox_may_name_the_default_kind(tmp_path):
    """A reducer of the catalogue is found with its kind stated and without."""
    arm = arm_from(tmp_path, JOINT + 'gearbox = { kind = "catalogue", catalogue = "RV-40E-121" }\n')
    assert arm.moving[0].gearbox.ratio == 121
