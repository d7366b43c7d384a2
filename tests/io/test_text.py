"""A file that is not there: which one was probably meant."""

import pytest

import lostmotion
from lostmotion.io.text import read_text
from lostmotion.io.toml import read_toml


@pytest.mark.parametrize(
    ("asked", "meant"),
    [
        ("z-amr.toml", "z-arm.toml"),
        ("z-arm.tml", "z-arm.toml"),
        ("z-arm.urdf", "z-arm.toml"),
        ("nope.toml", ""),
        ("z_arm.csv", "z-arm.csv"),
    ],
)
def test_similar_names_are_offered_and_similar_endings_are_not(tmp_path, asked, meant):
    """A slip in the name or another ending is offered its neighbour; a name of its own is offered
    nothing.
    """
    for name in ("pyproject.toml", "note.md", "z-arm.csv", "z-arm.toml"):
        (tmp_path / name).write_text("")
    if asked.endswith(("tml", "urdf")):
        (tmp_path / "z-arm.csv").unlink()
    with pytest.raises(lostmotion.InputError) as caught:
        read_text(tmp_path / asked, 1)
    assert caught.value.problems[0].nearest == meant


@pytest.mark.parametrize(
    ("text", "bare"),
    [
        ("limits = [-90 deg, 90 deg]", "-90 deg"),
        ("backlash = 0.5 arcmin ± 0.2 arcmin  # as printed", "0.5 arcmin ± 0.2 arcmin"),
        ("stiffness = 49 N m/arcmin", "49 N m/arcmin"),
        ("mount = { tilt = ±3 mrad }", "±3 mrad"),
        ("x = 1\nshare = 5 %\ny = 3 mm", "5 %"),
        ("x = 3 4", ""),
        ("x = arm", ""),
        ('x = "3 mm" 4 mm', ""),
        ("x = [1, 2\ny = 3 mm", ""),
        ("x =", ""),
    ],
)
def test_a_value_with_its_unit_but_no_quotes_is_reported(tmp_path, text, bare):
    """Where reading breaks off at a number and its unit, these are shown in quotes; any other
    mistake is reported in TOML's words.
    """
    (tmp_path / "arm.toml").write_text(text, encoding="utf-8")
    with pytest.raises(lostmotion.InputError) as caught:
        read_toml(tmp_path / "arm.toml")
    told = caught.value.problems[0]
    assert told.file.rpartition(":")[2].isdecimal()
    if bare:
        assert (told.found, told.expected, told.example) == (
            f"{bare} without quotes",
            "a value with its unit in quotes",
            f'"{bare}"',
        )
    else:
        assert told.expected == "valid TOML"
