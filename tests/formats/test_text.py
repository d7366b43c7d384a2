"""A file that is not there: which one was probably meant."""

import pytest

import lostmotion
from lostmotion.formats.text import read_text


@pytest.mark.parametrize(
    ("asked", "meant"),
    [("z-amr.toml", "z-arm.toml"), ("z-arm.tml", "z-arm.toml"), ("z-arm.urdf", "z-arm.toml"), ("nope.toml", ""), ("z_arm.csv", "z-arm.csv")],
)
def test_names_alike_are_offered_and_endings_alike_are_not(tmp_path, asked, meant):
    """A slip in the name or another ending is offered its neighbour; a name of its own is offered nothing."""
    for name in ("pyproject.toml", "note.md", "z-arm.csv", "z-arm.toml"):
        (tmp_path / name).write_text("")
    if asked.endswith(("tml", "urdf")):
        (tmp_path / "z-arm.csv").unlink()
    with pytest.raises(lostmotion.InputError) as caught:
        read_text(tmp_path / asked, 1)
    assert caught.value.problems[0].nearest == meant
