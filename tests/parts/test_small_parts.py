"""Encoders, lumped errors, mounting and the base."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from pydantic import ValidationError

from lostmotion.mechanism.arm import Arm
from lostmotion.parts.base import Base
from lostmotion.parts.joint import FixedJoint, PrismaticJoint, RevoluteJoint
from lostmotion.parts.lumped import Lumped
from lostmotion.parts.mounting import Mounting
from lostmotion.spatial import pose_of
from lostmotion.units import Toleranced
from tests.parts.conditions import (
    SLIDE_Z,
    TURN_Z,
    at_tool,
    condition,
    design,
    drawn,
    encoder,
    terms_at,
    visit_size,
)


def only(found: list, name: str) -> np.ndarray:
    """Return the screw of the one term of this name."""
    (term,) = [term for term in found if term.name == name]
    return np.broadcast_to(term.screw, (1, 6))[0] * term.bound


def test_an_encoder_on_the_motor_is_divided_by_the_ratio():
    """Resolution, noise and eccentricity of a motor encoder reach the output divided by the gear
    ratio; the mastering error reaches it whole.
    """
    fields = {"resolution": 1e-3, "noise": 2e-4, "eccentricity": 3e-4, "zero": 1e-4, "ratio": 100}
    motor, output = (
        terms_at(encoder(side=side, **fields), condition(angle=0.0)) for side in ("motor", "output")
    )
    for name in ("resolution", "noise", "eccentricity 1 cosine"):
        np.testing.assert_allclose(only(motor, name), only(output, name) / 100, rtol=1e-12)
        assert only(output, name)[2] > 0
    np.testing.assert_allclose(only(motor, "zero"), only(output, "zero"))
    assert only(output, "resolution")[2] == pytest.approx(0.5e-3)
    assert only(output, "noise")[2] == pytest.approx(2e-4)
    assert only(output, "zero")[2] == pytest.approx(1e-4)


def test_a_count_is_anywhere_within_itself():
    """Within one count the position is uniform: deviation count/sqrt 12, and drawn at every visit,
    as noise is; zero is not.
    """
    found = terms_at(encoder(side="output", resolution=1e-3, zero=1e-4, noise=1e-5), condition())
    assert {term.name: term.level for term in found} == {
        "resolution": "visit",
        "noise": "visit",
        "zero": "robot",
    }
    count = drawn([term for term in found if term.name == "resolution"], 20_000)[:, 0, 2]
    assert count.std() == pytest.approx(1e-3 / math.sqrt(12), rel=0.02)
    assert np.abs(count).max() <= 0.5e-3


@pytest.mark.parametrize(("side", "waves"), [("motor", 20), ("output", 1)])
def test_eccentricity_goes_round_with_the_encoder(side: str, waves: int):
    """An eccentric disc errs once a turn of its own: once per output turn on the output, once per
    motor turn on the motor.
    """
    angles = np.linspace(0, 2 * np.pi, 128, endpoint=False)
    found = terms_at(encoder(side=side, eccentricity=1e-3, ratio=20), condition(angle=angles))
    lines = np.abs(np.fft.rfft(drawn(found, 10, poses=128)[:, :, 2], axis=1)) / 64
    np.testing.assert_allclose(lines[:, waves], 1e-3 / (20 if side == "motor" else 1), rtol=1e-9)
    assert np.delete(lines, waves, axis=1).max() < 1e-15


GEARED = {"ratio": 80, "backlash": 1e-3, "stiffness": 1e4, "transmission_error": 1e-4}


def test_an_encoder_on_the_output_sees_the_gearbox():
    """With an encoder on the output the controller takes away what a loaded gearbox does; on the
    motor it cannot see it.
    """
    geared, measured = (
        RevoluteJoint(
            name="A", limits=(-1, 1), gearbox=GEARED, encoder={"side": side, "noise": 1e-5}
        )
        for side in ("motor", "output")
    )
    assert set(geared.sources) == {"gearbox", "encoder"}
    arm = Arm(
        name="arm",
        joints=[measured.model_copy(update={"axis": "y"})],
        payload={"mass": 1.0, "centre_of_mass": (0.4, 0.0, 0.0)},
    )
    left = [
        (item.name, float(np.abs(twist).max()))
        for item, twist in at_tool(arm, [0.3])
        if "gearbox" in item.owner
    ]
    assert set(left) == {("joints.A.gearbox.backlash left open", 0.0)}
    assert set(measured.model_copy(update={"gearbox": None}).sources) == {"encoder"}
    exact = RevoluteJoint(
        name="A",
        limits=(-1, 1),
        gearbox={"stiffness": 1e4, "hysteresis": 1e-4},
        encoder={"side": "output"},
    )
    assert set(exact.sources) == {"encoder"}


def test_a_motor_encoder_takes_the_ratio_of_its_gearbox():
    """An encoder that states no ratio turns as often as the gearbox makes it; one that does, as it
    says.
    """
    joint = RevoluteJoint(name="A", limits=(-1, 1), gearbox=GEARED, encoder={"noise": 8e-4})
    assert only(terms_at(joint.sources["encoder"], condition()), "noise")[2] == pytest.approx(1e-5)
    stated = RevoluteJoint(
        name="A", limits=(-1, 1), gearbox=GEARED, encoder={"noise": 8e-4, "ratio": 8}
    )
    assert only(terms_at(stated.sources["encoder"], condition()), "noise")[2] == pytest.approx(1e-4)
    bare = RevoluteJoint(name="A", limits=(-1, 1), encoder={"noise": 8e-4})
    assert only(terms_at(bare.sources["encoder"], condition()), "noise")[2] == pytest.approx(8e-4)


def sliding(**fields: object) -> PrismaticJoint:
    """Return a sliding joint with these parts."""
    return PrismaticJoint(name="S", limits=(0, 1), **fields)


def test_an_encoder_on_the_motor_of_a_screw_states_lengths_at_the_slide():
    """On a sliding joint no ratio divides what an encoder states: counts, noise and eccentricity
    are lengths at the slide.
    """
    fields = {"resolution": 1e-5, "noise": 2e-6, "eccentricity": 3e-6, "zero": 1e-5}
    joint = sliding(gearbox={"ratio": 4, "lead": 0.01}, encoder=fields)
    found = terms_at(joint.sources["encoder"], condition(axis=SLIDE_Z))
    sizes = {term.name: only(found, term.name)[5] for term in found}
    assert sizes == pytest.approx(
        {
            "resolution": 5e-6,
            "noise": 2e-6,
            "eccentricity 1 sine": 0,
            "eccentricity 1 cosine": 3e-6,
            "zero": 1e-5,
        },
    )


@pytest.mark.parametrize(
    ("drive", "own", "period"),
    [
        ({"ratio": 4, "lead": 0.01}, {}, 0.0025),
        ({"lead": 0.01}, {"ratio": 2}, 0.005),
        ({"lead": 0.01}, {"lead": 0.02}, 0.02),
        (None, {"lead": 0.02}, 0.02),
    ],
)
def test_eccentricity_on_a_screw_comes_back_with_the_motors_turn(drive, own, period):
    """A motor that turns 4 times per turn of a screw of 10 mm lead has the same error every 2.5 mm;
    the encoder's own values precede the drive's.
    """
    found = terms_at(
        sliding(gearbox=drive, encoder={"eccentricity": 3e-6, **own}).sources["encoder"],
        condition(axis=SLIDE_Z, angle=np.linspace(0, period, 64, endpoint=False)),
    )
    lines = np.abs(np.fft.rfft(drawn(found, 10, poses=64)[:, :, 5], axis=1)) / 32
    np.testing.assert_allclose(lines[:, 1], 3e-6, rtol=1e-9)
    assert np.delete(lines, 1, axis=1).max() < 1e-15


@pytest.mark.parametrize(
    ("fields", "why"),
    [
        ({"encoder": {"eccentricity": 3e-6}}, "eccentricity without a lead on a sliding joint"),
        (
            {"encoder": {"eccentricity": 3e-6}, "gearbox": {"ratio": 4}},
            "eccentricity without a lead on a sliding joint",
        ),
        (
            {"encoder": {"eccentricity": 3e-6, "side": "output"}, "gearbox": {"lead": 0.01}},
            "eccentricity of an encoder along the slide",
        ),
    ],
)
def test_eccentricity_on_a_slide_needs_something_that_turns(fields: dict[str, object], why: str):
    """Without a lead nobody knows how often an encoder turns, and a scale along the slide never
    does; without eccentricity no lead is asked for.
    """
    with pytest.raises(ValidationError) as caught:
        sliding(**fields)
    (error,) = caught.value.errors()
    assert error["loc"] == ("encoder",)
    assert error["ctx"]["why"] == why
    assert error["ctx"]["expected"]
    assert "=" in error["ctx"]["example"]
    assert (
        sliding(**{**fields, "encoder": {"noise": 1e-6, "eccentricity": 0.0}}).encoder is not None
    )


def test_a_lead_belongs_to_sliding_joints():
    """On a turning joint the encoder's lead says nothing and is refused."""
    with pytest.raises(ValidationError, match="a lead on a turning joint"):
        encoder(eccentricity=1e-3, lead=0.01)


def test_a_joint_lists_its_parts_and_a_fixed_joint_has_none():
    """A joint names the parts that err, a sliding one too; a fixed joint has nothing that moves."""
    slide = PrismaticJoint(
        name="S",
        limits=(0, 1),
        gearbox={"backlash": 1e-5},
        bearing={"kind": "rolling", "span": 0.1},
        lumped={"angle": 1e-6},
    )
    assert set(slide.sources) == {"gearbox", "bearing", "lumped"}
    assert FixedJoint(name="F").sources == {}
    assert not FixedJoint(name="F").twist.any()


@pytest.mark.parametrize(
    "fields",
    [
        {"name": "A", "limits": (1, -1)},
        {"name": "A", "limits": (1, 1)},
        {"name": "A", "limits": (-1, 1), "axis": (0, 0, 0)},
        {"name": "A", "limits": (-1, 1), "axis": (0, 0, math.nan)},
        {"name": "", "limits": (-1, 1)},
        {"name": "A\nB", "limits": (-1, 1)},
        {"name": "A", "limits": (-1, 1), "mass": -1.0},
    ],
)
def test_a_joint_that_cannot_be_is_refused(fields: dict[str, object]):
    """Limits must rise, an axis must point somewhere, a name be a plain word and a mass not
    negative.
    """
    with pytest.raises(ValidationError):
        RevoluteJoint(**fields)


def test_any_direction_may_be_an_axis():
    """An axis is a direction: its length does not matter, and "-z" is the opposite of "z"."""
    tilted = RevoluteJoint(name="A", limits=(-1, 1), axis=(0, 3, 4))
    np.testing.assert_allclose(tilted.twist, [0, 0.6, 0.8, 0, 0, 0])
    np.testing.assert_array_equal(
        PrismaticJoint(name="A", limits=(-1, 1), axis="-z").twist, -SLIDE_Z
    )


def test_from_zero_to_maximum_is_read_as_a_cut_normal_law():
    """The paper's 'normal, from zero to maximum': mean max/2, three sigma reach both ends, none
    outside.
    """
    angles = drawn(terms_at(Lumped(angle=6e-3, law="from zero to maximum"), condition()), 20_000)[
        :, 0, 2
    ]
    assert angles.min() >= 0
    assert angles.max() <= 6e-3
    assert angles.mean() == pytest.approx(3e-3, rel=0.01)
    assert angles.std() == pytest.approx(1e-3 * 0.98658, rel=0.02)


@pytest.mark.parametrize(
    ("law", "deviation"),
    [("normal", 0.98658 / 3), ("uniform", 1 / math.sqrt(3)), ("two-sided", 1.0)],
)
def test_a_lumped_angle_stays_within_its_limit(law: str, deviation: float):
    """A lumped angle ± a never leaves ± a and scatters as its law says."""
    angles = drawn(terms_at(Lumped(angle=1e-3, law=law), condition()), 20_000)[:, 0, 2]
    assert np.abs(angles).max() <= 1e-3 * (1 + 1e-12)
    assert angles.std() == pytest.approx(1e-3 * deviation, rel=0.02)


def test_a_lumped_offset_shifts_along_the_named_axes():
    """A lumped offset is uniform and independent along each named direction of the joint's frame,
    and turns nothing.
    """
    moved = drawn(terms_at(Lumped(offset=3e-5, offset_along=["x", "z"]), condition()), 20_000)[:, 0]
    assert not moved[:, [0, 1, 2, 4]].any()
    np.testing.assert_allclose(moved[:, [3, 5]].std(axis=0), 3e-5 / math.sqrt(3), rtol=0.02)
    assert np.abs(moved).max() <= 3e-5
    assert np.corrcoef(moved[:, 3], moved[:, 5])[0, 1] == pytest.approx(0, abs=0.03)


def test_lumped_errors_are_drawn_per_visit_or_per_robot_as_stated():
    """A lumped error differs from visit to visit unless it is stated as a property of the robot."""
    assert {term.level for term in terms_at(Lumped(angle=1e-3, offset=1e-5), condition())} == {
        "visit"
    }
    assert {
        term.level
        for term in terms_at(Lumped(angle=1e-3, offset=1e-5, varies="robot"), condition())
    } == {"robot"}


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.6, 0, 0.8)])
@pytest.mark.parametrize("slides", [False, True])
def test_a_joint_is_mounted_askew_across_its_axis_only(axis: tuple[float, ...], *, slides: bool):
    """Mounting tilts and offsets an axis in the two directions across it, equally, once per robot,
    and never along it.
    """
    direction = np.array(axis)
    twist = np.concatenate([np.zeros(3), direction] if slides else [direction, np.zeros(3)])
    found = terms_at(Mounting(tilt=1e-3, offset=2e-4), condition(axis=twist))
    assert {term.level for term in found} == {"robot"}
    total = sum(np.outer(term.screw, term.screw) * term.bound**2 for term in found)
    across = np.eye(3) - np.outer(direction, direction)
    np.testing.assert_allclose(total[:3, :3], 1e-6 * across, atol=1e-18)
    np.testing.assert_allclose(total[3:, 3:], 4e-8 * across, atol=1e-18)


def test_a_badly_mounted_axis_does_not_turn_with_its_joint():
    """The tilt of a joint's axis stays in the link before: half a turn of the joint leaves the tilt
    of the tool as it was.
    """
    arm = Arm(
        name="arm",
        joints=[
            RevoluteJoint(
                name="A", limits=(-4, 4), axis="z", mounting={"tilt": 1e-3}, link={"length": 0.5}
            )
        ],
    )
    for angle in (0.0, 1.0, math.pi):
        turned = np.array(
            [
                twist[:3] * item.term.bound
                for item, twist in at_tool(arm, [angle])
                if "mounting" in item.owner
            ]
        )
        np.testing.assert_allclose(turned.T @ turned, np.diag([1e-6, 1e-6, 0]), atol=1e-18)
        if angle == 0.0:
            first = turned
        np.testing.assert_allclose(turned, first, atol=1e-15)


def test_a_fixed_joint_can_be_mounted_askew():
    """A flange has a mounting error too, about the two directions across its z."""
    arm = Arm(
        name="arm",
        joints=[
            RevoluteJoint(name="A", limits=(-4, 4)),
            FixedJoint(name="F", mounting={"tilt": 1e-3, "offset": 1e-4}),
        ],
    )
    found = [twist for item, twist in at_tool(arm, [0.0]) if "mounting" in item.owner]
    assert len(found) == 4
    assert all(abs(twist[2]) < 1e-15 and abs(twist[5]) < 1e-15 for twist in found)


@pytest.mark.parametrize(
    ("roll", "pitch"), [(0.0, 0.0), (0.3, 0.0), (0.0, -0.4), (0.3, -0.4), (-1.0, 0.9)]
)
def test_a_tilt_that_nobody_measured_moves_the_tool_as_the_exact_rotation_does(
    roll: float, pitch: float
):
    """The error of base roll and pitch at the tool is the derivative of the exactly rotated tool
    position, seen in the base's axes.
    """
    arm = Arm(
        name="arm",
        base=Base(roll=Toleranced(roll, 0.01), pitch=Toleranced(pitch, 0.01)),
        joints=[
            RevoluteJoint(
                name="A", limits=(-4, 4), origin={"xyz": (0.1, 0.2, 0.3)}, link={"length": 0.7}
            )
        ],
    )
    point = np.array([0.1 + 0.7 * math.cos(0.4), 0.2 + 0.7 * math.sin(0.4), 0.3])
    level = pose_of(rpy=(roll, pitch, 0))[:3, :3]
    step = 1e-6
    for item, twist in at_tool(arm, [0.4]):
        by = (step, 0.0) if item.term.name == "roll" else (0.0, step)
        ahead, behind = (
            pose_of(rpy=(roll + s * by[0], pitch + s * by[1], 0))[:3, :3] for s in (1, -1)
        )
        exact = level.T @ (ahead - behind) @ point / (2 * step)
        np.testing.assert_allclose(twist[3:] * item.term.bound, exact * 0.01, atol=1e-11)


def test_a_tilted_base_turns_gravity():
    """A base rolled by a quarter turn about x has gravity along its own -y; one pitched nose down
    has it towards its nose.
    """
    joints = [RevoluteJoint(name="A", limits=(-1, 1))]
    rolled = Arm(name="arm", joints=joints, base=Base(roll=math.pi / 2)).gravity_in_base
    np.testing.assert_allclose(rolled, [0, -9.80665, 0], atol=1e-12)
    nose_down = Arm(name="arm", joints=joints, base=Base(pitch=math.pi / 2)).gravity_in_base
    np.testing.assert_allclose(nose_down, [9.80665, 0, 0], atol=1e-12)


@pytest.mark.parametrize("varies", ["robot", "visit"])
def test_a_mobile_base_stands_differently_every_time(varies: str):
    """The tilt of a base that is set down once belongs to the robot, of a mobile one to the
    visit.
    """
    found = terms_at(
        Base(roll=Toleranced(0, 0.01), pitch=Toleranced(0, 0.02), tilt_varies=varies), condition()
    )
    assert {term.level for term in found} == {varies}
    angles = drawn(found, 10_000)[:, 0]
    assert 0.009 < np.abs(angles[:, 0]).max() <= 0.01
    assert 0.018 < np.abs(angles[:, 1]).max() <= 0.02


def test_a_mount_gives_in_six_directions():
    """A mount moves by load over stiffness, direction by direction; where no stiffness is stated it
    is rigid.
    """
    load = (10.0, -20.0, 30.0, 100.0, 200.0, -300.0)
    whole = Base(angular_stiffness=(1e5, 2e5, 3e5), linear_stiffness=(1e8, 2e8, 3e8))
    np.testing.assert_allclose(
        design(terms_at(whole, condition(load)))[0],
        [1e-4, -1e-4, 1e-4, 1e-6, 1e-6, -1e-6],
        rtol=1e-12,
    )
    turning = Base(angular_stiffness=(1e5, 2e5, 3e5))
    np.testing.assert_allclose(
        design(terms_at(turning, condition(load)))[0], [1e-4, -1e-4, 1e-4, 0, 0, 0], rtol=1e-12
    )
    sinking = Base(linear_stiffness=(1e8, 2e8, 3e8))
    np.testing.assert_allclose(
        design(terms_at(sinking, condition(load)))[0], [0, 0, 0, 1e-6, 1e-6, -1e-6], rtol=1e-12
    )
    assert visit_size(terms_at(whole, condition(load))) == 0


def test_a_part_shows_what_was_stated():
    """A part prints its stated fields and leaves the others out."""
    assert repr(Lumped(angle=1e-3)) == "Lumped(angle=0.001)"
    assert repr(Mounting()) == "Mounting()"
    assert TURN_Z.tolist() == RevoluteJoint(name="A", limits=(-1, 1)).twist.tolist()


def test_a_mounting_by_direction_has_the_stated_limit_about_and_along_each_axis_of_the_seat():
    """Independent of each other, also about and along the axis itself; `axes` turns the directions,
    here by a quarter about z: x becomes y.
    """
    limits = ["1 mrad", "0 rad", "3 mrad"], ["0 mm", "20 µm", "0 µm ± 30 µm (uniform)"]
    stated = dict(zip(("tilt", "offset"), limits, strict=True))
    turned = {**stated, "axes": ["0 deg", "0 deg", "90 deg"]}
    for tree, x in ((stated, np.eye(3)[0]), (turned, np.eye(3)[1])):
        found = terms_at(
            Mounting.model_validate(tree, context={"text": True}), condition(axis=TURN_Z)
        )
        names = ["axis tilt x", "axis tilt z", "axis offset y", "axis offset z"]
        assert [term.name for term in found] == names
        np.testing.assert_allclose(only(found, names[0])[:3], 1e-3 * x, atol=1e-15)
        np.testing.assert_allclose(only(found, names[1]), [0, 0, 3e-3, 0, 0, 0], atol=1e-15)
        np.testing.assert_allclose(only(found, names[3]), [0, 0, 0, 0, 0, 30e-6], atol=1e-15)


@pytest.mark.parametrize("wrong", ['"-1 mrad"', '"1 mrad ± 2 mrad"', '"1 mm"', "0.001"])
def test_a_direction_of_a_mounting_takes_a_limit(wrong):
    """Not below zero, around zero, with a unit."""
    with pytest.raises(ValidationError):
        Mounting.model_validate(
            {"tilt": [json.loads(wrong), "0 rad", "0 rad"]}, context={"text": True}
        )
