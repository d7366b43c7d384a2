"""Which joints of an arm are copies of each other."""

import lostmotion
from lostmotion.io.arm_templates import template_text
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.leg_copies import leg_copies


def groups(arm, part="link"):
    """Return the groups of several joints."""
    return sorted({each for each in leg_copies(arm, part).values() if len(each) > 1})


def written(template, folder, change=("", "")):
    """Return the arm of a template with a change of its text."""
    text = template_text(template)
    assert change[0] in text
    (folder / "arm.toml").write_text(text.replace(*change, 1), encoding="utf-8")
    return lostmotion.read(folder / "arm.toml")


def test_three_arms_and_six_rods_of_a_delta_are_copies(tmp_path):
    """Rods are attached to arms that are copies; so are the balls at their ends."""
    rods = [f"{tower}{side}" for tower in "ABC" for side in (1, 2)]
    assert groups(written("delta", tmp_path)) == [
        tuple(f"{rod}_ball" for rod in rods),
        tuple(f"{rod}_rod" for rod in rods),
        ("A_arm", "B_arm", "C_arm"),
    ]


def test_branches_written_one_by_one_are_copies_too(tmp_path):
    """As those of a five-bar; a gearbox of its own makes a drive another one, but not its link."""
    whole = written("five-bar", tmp_path)
    assert groups(whole) == [("left", "right"), ("left-elbow", "right-elbow")]
    other = written("five-bar", tmp_path, ("CSG-17-80", "CSG-20-80"))
    assert groups(other) == groups(whole)
    assert ("left", "right") not in groups(other, "gearbox")


def test_what_a_longer_link_carries_is_no_copy(tmp_path):
    """A proximal link of 201 mm leaves a five-bar without copies: its elbow stands elsewhere."""
    assert groups(written("five-bar", tmp_path, ("200 mm", "201 mm"))) == []


def test_the_joints_of_a_serial_arm_are_no_copies():
    """Even where all have equal links."""
    joint = {"type": "revolute", "axis": "y", "limits": (-1, 1), "link": {"length": 0.3}}
    arm = Arm(name="chain", joints=[{**joint, "name": name} for name in "ABC"])
    assert groups(arm) == []


def test_equal_lugs_at_different_places_are_no_copies(tmp_path):
    """Those of a palletiser with linkages, which differ in their loads."""
    arm = written("linkage-palletiser", tmp_path)
    lug, first = (
        next(each for each in arm.joints if each.name == name) for name in ("lug", "first")
    )
    assert lug.link.model_dump() == first.link.model_dump()
    assert groups(arm) == []
