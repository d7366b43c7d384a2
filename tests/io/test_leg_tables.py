"""A sized closed chain is written into its own file, its legs too."""

import tomllib
from pathlib import Path
from types import SimpleNamespace

import pytest

import lostmotion
from lostmotion.io.arm_writer import NewParts, reads_back, sized_toml
from lostmotion.parts.section import Tube

DELTA = Path(__file__).parents[2] / "examples" / "closed-chains" / "delta-printer.toml"
RODS = tuple(f"{tower}{side}_rod" for tower in "ABC" for side in (1, 2))


def written(names, folder):
    """Return the tables of the file of the example whose rods of these names become tubes of 8 mm,
    and how it differs when it is read again.
    """
    arm = lostmotion.read(DELTA)
    tube = Tube(kind="tube", outer="8 mm", wall="1 mm")
    joints = tuple(
        joint.model_copy(update={"link": joint.link.model_copy(update={"section": tube})})
        if joint.name in names
        else joint
        for joint in arm.joints
    )
    result = SimpleNamespace(
        arm=arm,
        sized=arm.model_copy(update={"joints": joints}),
        new_parts=[NewParts(name, section=tube) for name in names],
    )
    text = sized_toml(DELTA, result)
    (folder / "sized.toml").write_text(text, encoding="utf-8")
    assert "# " in text  # its comments are kept
    return tomllib.loads(text), reads_back(DELTA, folder / "sized.toml", result)


def test_a_part_that_all_copies_get_is_stated_once(tmp_path):
    """In the leg's own joint, and nothing in its copies."""
    tree, differs = written(RODS, tmp_path)
    leg = tree["legs"][1]
    assert differs == ""
    assert leg["joints"][0]["link"]["section"]["outer"] == "8 mm"
    assert not any("rod" in each for each in leg["copies"])


def test_a_part_that_some_copies_get_is_stated_by_each(tmp_path):
    """With all of its link: the others keep theirs."""
    tree, differs = written(("A1_rod", "C2_rod"), tmp_path)
    leg = tree["legs"][1]
    assert differs == ""
    assert "link" not in leg["joints"][0]
    outer = {each["name"]: each["rod"]["link"]["section"]["outer"] for each in leg["copies"]}
    assert outer == {name[:2]: "8 mm" if name in ("A1_rod", "C2_rod") else "6 mm" for name in RODS}


@pytest.mark.slow
@pytest.mark.usefixtures("unpainted", "few_samples")
def test_the_links_of_a_closed_chain_with_legs_are_sized(tmp_path):
    """The search for worse poses passes those at which the chain is not assembled, and the sized
    file is read as the sized arm.
    """
    found = lostmotion.size(DELTA, poses=32)
    assert found.is_met
    found.report(tmp_path / "sized")
    assert not any(";" in line for line in found.further_files(tmp_path / "sized"))
