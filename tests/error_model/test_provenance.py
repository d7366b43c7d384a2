"""The provenance of each joint's errors: stated, assumed or ideal."""

from __future__ import annotations

import pytest

from lostmotion.error_model.provenance import KINDS, refuse_undescribed, states
from lostmotion.errors import InputError
from lostmotion.io import read
from lostmotion.mechanism.arm import Arm
from lostmotion.parts.base import Base
from lostmotion.parts.joint import FixedJoint, PrismaticJoint, RevoluteJoint
from lostmotion.parts.link import Link
from lostmotion.parts.lumped import Lumped
from lostmotion.units import Toleranced
from tests.io.conftest import EXAMPLES

ARMS = ("z-arm.toml", "arm-from-drawings.toml", "ur5e.urdf", "paper/z-arm-lumped.toml")


def joint(name="A", **parts):
    """Return a revolute joint."""
    return RevoluteJoint(name=name, limits=(-1.0, 1.0), **parts)


@pytest.mark.parametrize("file", ARMS)
def test_the_table_lists_every_moving_joint_once(file):
    """The table lists every moving joint once and in order, with defined kinds and states."""
    arm = read(EXAMPLES / file)
    found = states(arm)
    assert [each.joint for each in found.joints] == [each.name for each in arm.moving]
    for each in found.joints:
        assert [kind for kind in KINDS if kind in each.states] == list(each.states)
        assert set(each.states.values()) <= {"stated", "assumed", "ideal"}
    assert tuple(found.base) == ("tilt", "mount")
    assert found.described
    assert len(set(found.assumed)) == len(found.assumed)


def test_an_arm_without_stated_errors_has_no_error_source():
    """Masses, payload, ratios and a nominal tilt are not error sources."""
    bare = Arm(
        name="bare",
        joints=(
            joint(
                mass=3.0,
                link=Link(length=0.4, mass=2.0),
                gearbox={"ratio": 100, "rated_torque": 50.0},
                encoder={"side": "output"},
            ),
            PrismaticJoint(
                name="B",
                limits=(0.0, 1.0),
                bearing={"kind": "rolling", "span": 0.1},
                lumped={},
                mounting={},
            ),
            FixedJoint(name="C", link=Link(length=0.1)),
        ),
        base=Base(roll=0.1),
        payload={"mass": 5.0},
    )
    found = states(bare)
    assert not found.described
    assert found.ideal_joints == ("A", "B")
    assert {state for each in found.joints for state in each.states.values()} == {"ideal"}


@pytest.mark.parametrize(
    ("parts", "kind"),
    [
        ({"gearbox": {"backlash": 0.0}}, "backlash"),
        ({"gearbox": {"hysteresis": 0.0}}, "hysteresis"),
        ({"gearbox": {"transmission_error": 0.0}}, "transmission error"),
        ({"gearbox": {"stiffness": 1e4}}, "stiffness"),
        (
            {"gearbox": {"kind": "planetary", "sun_teeth": 20, "ring_teeth": 70, "sun_error": 0.0}},
            "transmission error",
        ),
        ({"bearing": {"kind": "rolling", "span": 0.1, "clearance": 0.0}}, "bearing"),
        ({"bearing": {"kind": "crossed roller", "radial_runout": 0.0}}, "bearing"),
        ({"encoder": {"zero": 0.0}}, "encoder"),
        ({"mounting": {"offset": 0.0}}, "axis mounting"),
        ({"link": {"length": 0.1, "length_tolerance": 0.0}}, "link length"),
        ({"link": {"length": 0.1, "rigid": True}}, "link bending"),
        ({"lumped": {"angle": 0.0}}, "lumped"),
    ],
)
def test_a_stated_zero_counts_as_stated(parts, kind):
    """An error stated as zero counts as stated, and every other kind of error of that joint stays
    ideal.
    """
    found = states(Arm(name="x", joints=(joint(**parts), joint("B"))))
    assert {name for name, state in found.joints[0].states.items() if state != "ideal"} == {kind}
    assert found.joints[0].states[kind] == "stated"
    assert found.described
    assert found.ideal_joints == ("B",)


def test_a_default_is_listed_as_assumed():
    """The default friction and the default torque of lost motion are listed as assumed, and stated
    values are not.
    """
    gearbox = {"lost_motion": 3e-4, "stiffness": 4e5, "rated_torque": 400.0}
    found = states(Arm(name="x", joints=(joint(gearbox=gearbox),)))
    assert {each.key: each.reason for each in found.assumed} == {
        "lost_motion_torque": "default, 3 % of the rated torque",
        "friction_torque": "default, 1 % of the rated torque, ±50 %",
    }
    stated = {**gearbox, "lost_motion_torque": 0.03, "friction_torque": Toleranced(4.0, 1.0)}
    assert not states(Arm(name="x", joints=(joint(gearbox=stated),))).assumed


def test_a_lumped_error_without_a_size_is_no_error_source():
    """A lumped error with a distribution but without an angle or an offset is not an error
    source.
    """
    assert not states(
        Arm(name="x", joints=(joint(lumped=Lumped(law="uniform", varies="robot")),))
    ).described


def test_a_kind_of_error_is_missing_where_any_joint_lacks_it():
    """A kind of error is missing if any joint lacks it; a lumped error is never missing, because it
    replaces other kinds.
    """
    encoder = {"zero": 1e-4}
    one, both = (
        states(Arm(name="x", joints=(joint(encoder=encoder), joint("B", **more)))).ideal_kinds
        for more in ({}, {"encoder": encoder})
    )
    assert set(one) - set(both) == {"encoder"}
    # links without length have no error, joints that turn have no guideway, and a servo is listed
    # only where it is described
    assert set(both) == set(KINDS) - {
        "encoder",
        "lumped",
        "link bending",
        "link length",
        "guideway",
        "servo",
    }


def test_a_base_alone_is_an_error_source():
    """A base with a tilt tolerance or an elastic mount is an error source by itself."""
    for base, kind in (
        (Base(roll="0 deg ± 1 deg"), "tilt"),
        (Base(linear_stiffness=(1e6, 1e6, 1e6)), "mount"),
    ):
        found = states(Arm(name="x", joints=(joint(),), base=base))
        assert found.described
        assert found.base[kind] == "stated"
        assert found.ideal_joints == ("A",)


def test_a_fixed_joint_is_listed_only_where_its_link_is_described():
    """A fixed joint has no drive and is listed only if its link has a tolerance, which is an error
    source of the arm.
    """
    fixed = FixedJoint(name="F", link=Link(length=0.2, length_tolerance=1e-4))
    found = states(Arm(name="x", joints=(joint(), fixed)))
    assert [each.joint for each in found.joints] == ["A"]
    assert [each.joint for each in found.fixed] == ["F"]
    assert found.described
    assert states(Arm(name="x", joints=(joint(), FixedJoint(name="F")))).fixed == ()


def test_a_joint_may_mark_a_whole_part_as_assumed():
    """All stated kinds of error of a part marked as assumed are assumed, and the table names the
    joint's source.
    """
    arm = Arm(
        name="x",
        joints=(
            joint(
                lumped=Lumped(angle=1e-4),
                gearbox={"backlash": 1e-4},
                assumed=("gearbox", "lumped"),
                source="guess",
            ),
        ),
    )
    found = states(arm)
    assert found.joints[0].states["backlash"] == found.joints[0].states["lumped"] == "assumed"
    assert found.joints[0].states["stiffness"] == "ideal"
    assert [(each.key, each.source) for each in found.assumed] == [
        ("gearbox", "guess"),
        ("lumped", "guess"),
        ("friction_torque", ""),
    ]


def test_a_typical_material_makes_only_the_stiffness_of_a_drawn_gearbox_assumed():
    """A typical material makes the stiffness of a drawn gearbox assumed, while the clearances and
    runouts of the drawing stay stated.
    """
    arm = read(EXAMPLES / "arm-from-drawings.toml")
    drawn = arm.model_copy(
        update={"joints": tuple(each.model_copy(update={"assumed": ()}) for each in arm.joints)}
    )
    shoulder = states(drawn).joints[1].states
    kinds = ("backlash", "stiffness", "hysteresis", "transmission error", "bearing")
    assert [shoulder[kind] for kind in kinds] == ["stated", "assumed", "stated", "stated", "stated"]


def test_an_arm_without_error_sources_is_rejected_with_an_example_for_its_first_joint():
    """The error for an arm without error sources shows an example backlash for its first joint, in
    arcmin if revolute and in µm if prismatic.
    """
    slide = PrismaticJoint(name="B", limits=(0.0, 1.0))
    for joints, entry in (
        ((joint(), slide), ("joints.A", "1 arcmin")),
        ((slide, joint()), ("joints.B", "20 µm")),
    ):
        with pytest.raises(InputError) as refused:
            refuse_undescribed(Arm(name="bare", joints=joints))
        assert all(word in str(refused.value) for word in entry)
