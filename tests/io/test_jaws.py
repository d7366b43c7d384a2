"""Jaws of a gripper and joints of an arm: a pair that slides or follows ends an arm only where
nothing else moves behind it.
"""

from __future__ import annotations

import pytest

from lostmotion.io import read
from tests.io.conftest import mistakes
from tests.io.test_mjcf import HINGE, INERTIAL, model
from tests.io.test_urdf_tip import fixed, sliding, turning
from tests.io.test_xacro import HEAD
from tests.io.urdfs import agrees_with_pinocchio, arm, link, robot

LIFT = [
    *(
        link("base"),
        *sliding("screen_lift", "base", "screen"),
        *sliding("arm_lift", "base", "carriage"),
    ),
    *(*turning("shoulder", "carriage", "upper"), *turning("elbow", "upper", "fore")),
]
TURRET = turning("turn", "base", "turret")
ROD = turning("j3b", "link2", "rod", '<mimic joint="j2" multiplier="-1"/>')
FORE = turning("j3", "link2", "fore", '<mimic joint="j2" multiplier="-1"/>')


@pytest.fixture(params=["urdf", "urdf.xacro"])
def written(request, tmp_path):
    """Return the file of a URDF of these parts, by itself or as a file for xacro."""

    def write(*parts):
        path = tmp_path / f"r.{request.param}"
        text = robot(*parts)
        if request.param.endswith("xacro"):
            text = text.replace(
                '<robot name="r">', f'{HEAD}<xacro:property name="unused" value="1"/>'
            )
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.mark.parametrize("beside", [[], TURRET])
@pytest.mark.parametrize("tool", [[], fixed("tool0", "fore")])
def test_an_arm_behind_one_of_two_slides_is_no_jaw(written, beside, tool):
    """A screen and an arm slide on one column: the arm is read whole, whether or not it ends at a
    link of a tool's name.
    """
    path = written(*LIFT, *beside, *tool)
    found = read(path)
    assert [joint.name for joint in found.moving] == ["arm_lift", "shoulder", "elbow"]
    if path.suffix == ".urdf":
        agrees_with_pinocchio(path, found, "tool0" if tool else "fore")


@pytest.mark.parametrize(
    "behind",
    [
        [
            *sliding("j4", "fore", "carriage"),
            *turning("j5", "carriage", "spindle"),
            *fixed("tool0", "spindle"),
        ],
        [*turning("j4", "fore", "wrist", '<mimic joint="j2"/>'), *fixed("tool0", "wrist")],
        fixed("tool0", "fore"),
        [*turning("j4", "fore", "wrist"), *turning("j5", "wrist", "end")],
    ],
)
def test_a_linkage_on_the_way_to_the_tool_is_refused_by_name(written, behind):
    """Two bars of a pantograph follow the joint before them: they are no jaws, whether drives,
    followers or nothing but the tool is behind them.
    """
    found = mistakes(written(*arm(2), *FORE, *ROD, *behind))[0]
    assert "joint 'j3' follows 'j2'" in found.found
    assert "a ratio, not a mechanism" in found.expected
    assert "[[closures]]" in found.expected
    assert found.example == 'tip = "link2"'


def test_followers_beside_the_way_to_the_tool_are_carried(written):
    """The rod of a linkage hangs at zero, with a note that it moves in the file; the arm is
    read.
    """
    path = written(*arm(2), *turning("j3", "link2", "fore"), *ROD, *fixed("tool0", "fore"))
    found = read(path)
    assert [joint.name for joint in found.moving] == ["j1", "j2", "j3"]
    assert any("moving with the arm in the URDF: j3b (follows j2)" in note for note in found.notes)


@pytest.mark.parametrize(
    "jaws",
    [
        [*sliding("a", "link3", "left"), *sliding("b", "link3", "right")],
        [*sliding("a", "link3", "left"), *sliding("b", "link3", "right", '<mimic joint="a"/>')],
        [
            *turning("a", "link3", "left", '<mimic joint="drive"/>'),
            *turning("b", "link3", "right", '<mimic joint="drive"/>'),
        ],
        [
            *sliding("a", "link3", "left"),
            *sliding("b", "link3", "right"),
            *fixed("left_pad", "left"),
            *fixed("right_pad", "right"),
        ],
    ],
)
def test_jaws_are_still_set_aside(written, jaws):
    """A pair with nothing that moves behind it is a gripper, which follows itself or a drive of its
    own.
    """
    found = read(written(*arm(3), *jaws))
    assert [joint.name for joint in found.moving] == ["j1", "j2", "j3"]


SLIDE = '<joint name="{0}" type="slide" axis="0 0 1" range="0 0.5"/>'


def body(name, joint, *rest):
    """Return a body with a joint."""
    return f'<body name="{name}" pos="0.3 0 0.1">{INERTIAL.format(1)}{joint}{"".join(rest)}</body>'


def test_jaws_and_arms_of_mjcf_are_distinguished_too(tmp_path):
    """Slides of a column, and bars that an equality couples to the joint before them."""
    path = tmp_path / "r.xml"
    upper = body("upper", HINGE.format("shoulder"), body("fore", HINGE.format("elbow")))
    path.write_text(
        model(
            body("screen", SLIDE.format("screen")), body("carriage", SLIDE.format("lift"), upper)
        ),
        encoding="utf-8",
    )
    assert [joint.name for joint in read(path).moving] == ["lift", "shoulder", "elbow"]
    fore = body("fore", HINGE.format("j3"), body("wrist", HINGE.format("j4"), '<site name="tcp"/>'))
    bars = "".join(
        f'<joint joint1="{name}" joint2="j2" polycoef="0 -1 0 0 0"/>' for name in ("j3", "rod")
    )
    lower = body("lower", HINGE.format("j2"), fore, body("rod", HINGE.format("rod")))
    path.write_text(
        model(body("turn", HINGE.format("j1"), lower), rest=f"<equality>{bars}</equality>"),
        encoding="utf-8",
    )
    (found,) = mistakes(path)
    assert "joint 'j3' follows 'j2'" in found.found
    assert "a ratio, not a mechanism" in found.expected
    assert "[[closures]]" in found.expected
