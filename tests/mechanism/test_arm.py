"""The chain walked out and back: frames by hand, balance of forces, torques from energy, and a
numeric core that touches nothing.
"""

from __future__ import annotations

import ast
import functools
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

import lostmotion
from lostmotion.mechanism.arm import STANDARD_GRAVITY, Arm
from lostmotion.mechanism.frames import steps_between
from lostmotion.mechanism.holding_torques import worst_torques_over_tilts
from lostmotion.mechanism.state import as_poses, state_of, tool_points
from lostmotion.mechanism.tool import Payload
from lostmotion.parts.base import Base
from lostmotion.parts.joint import FixedJoint, PrismaticJoint, RevoluteJoint
from lostmotion.spatial import combined, exp, motion

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "joint torques",
        "finite differences of potential energy; brute force over tilts",
        "1e-6; exact",
        "mechanism/state.py",
    ),
)

ONE, TWO = 0.5, 0.3


def planar(**fields: object) -> Arm:
    """Return a planar arm of two turning joints, lifting in the x-z plane (axis -y: positive is
    up), with masses half way along its links.
    """
    joints = [
        RevoluteJoint(name="A", limits=(-4, 4), axis="-y", link={"length": ONE, "mass": 4.0}),
        RevoluteJoint(
            name="B", limits=(-4, 4), axis="-y", mass=1.5, link={"length": TWO, "mass": 2.0}
        ),
    ]
    return Arm(name="planar", joints=joints, **fields)


@functools.cache  # the same arm for all examples of a test
def spatial() -> Arm:
    """Return an arm of all kinds of joints, with masses, tool and payload off every axis."""
    joints = [
        RevoluteJoint(
            name="waist",
            limits=(-4, 4),
            axis="z",
            origin={"xyz": (0, 0, 0.2)},
            mass=2.0,
            centre_of_mass=(0.1, 0, 0.05),
            link={"length": 0.1},
        ),
        RevoluteJoint(
            name="lift",
            limits=(-4, 4),
            axis=(0.1, 1, 0.2),
            link={"length": 0.4, "mass": 3.0, "centre_of_mass": (0.15, 0.02, 0.03)},
        ),
        FixedJoint(
            name="bracket",
            origin={"rpy": (0.2, 0.3, -0.1)},
            mass=0.7,
            link={"length": 0.05, "direction": "z", "mass": 0.4},
        ),
        PrismaticJoint(
            name="slide",
            limits=(0, 0.5),
            axis=(1, 0, -1),
            mass=0.3,
            link={"tip": {"xyz": (0.1, 0.05, 0), "rpy": (0, 0.5, 0)}, "mass": 1.2},
        ),
        RevoluteJoint(name="wrist", limits=(-4, 4), axis="x"),
    ]
    tool = {
        "frame": {"xyz": (0, 0, 0.12), "rpy": (0.1, -0.2, 0.3)},
        "mass": 0.6,
        "centre_of_mass": (0, 0.01, -0.05),
    }
    payload = Payload(
        mass=2.5, centre_of_mass=(0.02, 0.03, 0.04), force=(5, -7, 9), moment=(0.3, 0.2, -0.1)
    )
    return Arm(
        name="spatial", joints=joints, tool=tool, payload=payload, base=Base(roll=0.2, pitch=-0.1)
    )


QS = st.tuples(*[st.floats(-3, 3)] * 4)


@given(st.floats(-3, 3), st.floats(-3, 3))
@settings(deadline=None, max_examples=50)
def test_a_planar_arm_stands_where_trigonometry_says(a: float, b: float):
    """Elbow and tool of a planar arm are at l1 (cos a, sin a) and l2 (cos(a + b), sin(a + b))
    further.
    """
    arm = planar()
    at = state_of(arm, np.array([[a, b]])).frames[:, 0]
    place = dict(zip(arm.places, at, strict=True))
    elbow = ONE * np.array([math.cos(a), 0, math.sin(a)])
    tool = elbow + TWO * np.array([math.cos(a + b), 0, math.sin(a + b)])
    np.testing.assert_allclose(place["B"][:3, 3], elbow, atol=1e-14)
    np.testing.assert_allclose(place["tool"][:3, 3], tool, atol=1e-14)
    np.testing.assert_allclose(
        place["tool"][:3, 0], [math.cos(a + b), 0, math.sin(a + b)], atol=1e-14
    )
    np.testing.assert_array_equal(place["base"], np.eye(4))


@given(st.floats(-3, 3), st.floats(-3, 3))
@settings(deadline=None, max_examples=50)
def test_a_planar_arm_holds_what_its_levers_carry(a: float, b: float):
    """Each drive of a planar arm holds weights times level arms: links half way, the elbow's motor
    on the first link, the payload at the tool.
    """
    arm = planar(payload=Payload(mass=3.0))
    x1, x2 = ONE * math.cos(a), TWO * math.cos(a + b)
    second = STANDARD_GRAVITY * (2.0 * x2 / 2 + 3.0 * x2)
    first = STANDARD_GRAVITY * (4.0 * x1 / 2 + 1.5 * x1 + 2.0 * (x1 + x2 / 2) + 3.0 * (x1 + x2))
    np.testing.assert_allclose(
        state_of(arm, np.array([[a, b]])).torques[0], [first, second], atol=1e-12
    )


def test_a_joints_own_motor_hangs_on_the_link_before():
    """The mass of a joint's housing loads the link before it and the base, and neither its own
    bearing nor its drive.
    """
    arm = planar()
    place = dict(zip(arm.places, state_of(arm, np.zeros((1, 2))).wrenches[:, 0], strict=True))
    weight = {name: -load[5] / STANDARD_GRAVITY for name, load in place.items()}
    expected = {
        "tool": 0,
        "B.tip": 0,
        "B": 2.0,
        "B.seat": 2.0,
        "A.tip": 3.5,
        "A": 7.5,
        "A.seat": 7.5,
        "base": 7.5,
    }
    assert weight == pytest.approx(expected, abs=1e-12)


@given(QS)
@settings(deadline=None, max_examples=50)
def test_the_ground_carries_everything(q: tuple[float, ...]):
    """The force on the base is all weight plus the process force; its moment is that of every
    weight at its own place.
    """
    arm = spatial()
    at = dict(zip(arm.places, state_of(arm, np.array([q])).frames[:, 0], strict=True))
    gravity = arm.gravity_in_base
    loads = [  # mass, frame, centre
        (2.0, "waist.seat", (0.1, 0, 0.05)),
        (3.0, "lift", (0.15, 0.02, 0.03)),
        (0.7, "bracket.seat", (0, 0, 0)),
        (0.4, "bracket", (0, 0, 0.025)),
        (0.3, "slide.seat", (0, 0, 0)),
        (1.2, "slide", (0.05, 0.025, 0)),
        (0.6, f"{arm.joints[-1].name}.tip", (0, 0.01, -0.05)),
        (2.5, "tool", (0.02, 0.03, 0.04)),
    ]
    tool = at["tool"]
    process = tool[:3, :3] @ [5, -7, 9]
    force = sum(mass for mass, _, _ in loads) * gravity + process
    moment = np.cross(tool[:3, 3], process) + tool[:3, :3] @ [0.3, 0.2, -0.1]
    for mass, frame, centre in loads:
        moment = moment + np.cross((at[frame] @ [*centre, 1])[:3], mass * gravity)
    found = state_of(arm, np.array([q])).wrenches[0, 0]
    np.testing.assert_allclose(found[3:], force, atol=1e-11)
    np.testing.assert_allclose(found[:3], moment, atol=1e-11)


def potential(arm: Arm, q: np.ndarray, payload: Payload) -> float:
    """Return the height energy of all masses, J, from frames alone."""
    at = dict(zip(arm.places, state_of(arm, q[None]).frames[:, 0], strict=True))
    energy = 0.0
    down = arm.gravity_in_base
    for joint in arm.joints:
        for mass, frame, centre in (
            (joint.mass or 0.0, f"{joint.name}.seat", joint.centre_of_mass),
            (joint.link.total_mass, joint.name, joint.link.mass_centre),
        ):
            energy -= mass * (at[frame] @ [*centre, 1])[:3] @ down
    flange = f"{arm.joints[-1].name}.tip"
    for place, mass, centre in (
        ("tool", payload.mass, payload.centre_of_mass),
        (flange, arm.tool.mass, arm.tool.centre_of_mass),
    ):
        energy -= mass * (at[place] @ [*centre, 1])[:3] @ down
    return energy


@given(QS)
@settings(deadline=None, max_examples=50)
def test_holding_torques_are_the_slope_of_the_energy(q: tuple[float, ...]):
    """What each drive holds is how steeply the height energy rises as its joint moves."""
    arm, at = spatial(), np.array(q)
    payload = Payload(mass=2.5, centre_of_mass=(0.02, 0.03, 0.04))
    step = 1e-5
    slopes = [
        (potential(arm, at + step * unit, payload) - potential(arm, at - step * unit, payload))
        / (2 * step)
        for unit in np.eye(4)
    ]
    np.testing.assert_allclose(
        state_of(arm.with_payload(payload), at).torques[0], slopes, atol=1e-6
    )


@given(QS)
@settings(deadline=None, max_examples=50)
def test_a_process_force_is_held_by_the_jacobian(q: tuple[float, ...]):
    """A force and moment on the tool ask of each drive minus the work they do per unit of its
    motion.
    """
    arm, at = spatial(), np.array(q)
    payload = Payload(force=(5, -7, 9), moment=(0.3, 0.2, -0.1))
    found = state_of(arm.with_payload(payload), at, gravity=np.zeros(3)).torques[0]
    tool = state_of(arm, at[None]).frames[-1, 0]
    force, moment = tool[:3, :3] @ payload.force, tool[:3, :3] @ payload.moment
    step = 1e-6
    for k, unit in enumerate(np.eye(4)):
        ahead, behind = state_of(arm, np.array([at + step * unit, at - step * unit])).frames[-1]
        shift = (ahead[:3, 3] - behind[:3, 3]) / (2 * step)
        turned = (ahead[:3, :3] - behind[:3, :3]) @ tool[:3, :3].T / (2 * step)
        turn = np.array([turned[2, 1], turned[0, 2], turned[1, 0]])
        assert found[k] == pytest.approx(-(force @ shift + moment @ turn), abs=1e-6)


@given(QS)
@settings(deadline=None, max_examples=20)
def test_the_worst_tilt_is_the_worst_of_all_tilts(q: tuple[float, ...]):
    """No direction of gravity asks more of any drive than the stated worst case, and the worst of
    20 000 directions comes within 1 % of it.
    """
    arm, at = spatial(), np.array([q])
    worst = worst_torques_over_tilts(state_of(arm, at))[0]
    directions = np.random.default_rng(0).normal(size=(20_000, 3))
    directions *= arm.gravity / np.linalg.norm(directions, axis=1)[:, None]
    # Torque is affine in gravity, which is checked on one direction; that makes the search cheap.
    none = state_of(arm, at, gravity=np.zeros(3)).torques[0]
    slope = np.array([state_of(arm, at, gravity=unit).torques[0] - none for unit in np.eye(3)])
    np.testing.assert_allclose(
        state_of(arm, at, gravity=directions[0]).torques[0],
        none + directions[0] @ slope,
        atol=1e-10,
    )
    tried = np.abs(none + directions @ slope).max(axis=0)
    assert (tried <= worst * (1 + 1e-12) + 1e-12).all()
    assert (tried >= 0.99 * worst - 1e-9).all()


def test_the_worst_tilt_of_a_lever_is_its_weight_times_its_reach():
    """For a horizontal as for a vertical lever the worst moment is weight times distance; on a
    slide it is the whole weight.
    """
    arm = Arm(
        name="lever",
        joints=[RevoluteJoint(name="A", limits=(-4, 4), axis="y", link={"length": 0.8})],
        payload=Payload(mass=2.0),
    )
    np.testing.assert_allclose(
        worst_torques_over_tilts(state_of(arm, np.array([[0.0], [math.pi / 2], [1.0]]))),
        2 * 0.8 * STANDARD_GRAVITY,
    )
    slide = Arm(
        name="slide",
        joints=[PrismaticJoint(name="A", limits=(-4, 4), axis="x", link={"length": 0.8})],
        payload=Payload(mass=2.0),
    )
    np.testing.assert_allclose(
        worst_torques_over_tilts(state_of(slide, np.array([[0.1]]))), 2 * STANDARD_GRAVITY
    )


def test_a_process_force_adds_to_the_worst_tilt():
    """A force on the tool turns with the arm, so it adds at its full moment to the worst that
    gravity can do.
    """
    arm = Arm(
        name="lever",
        joints=[RevoluteJoint(name="A", limits=(-4, 4), axis="y", link={"length": 0.8})],
    )
    load = Payload(mass=2.0, force=(0, 0, 30.0))
    np.testing.assert_allclose(
        worst_torques_over_tilts(state_of(arm.with_payload(load), np.zeros((1, 1)))),
        2 * 0.8 * STANDARD_GRAVITY + 24,
    )


def test_a_slide_carries_what_points_down_it():
    """A vertical slide holds the whole weight, a horizontal one none of it."""
    for axis, held in (("z", 5 * STANDARD_GRAVITY), ("-z", -5 * STANDARD_GRAVITY), ("x", 0.0)):
        arm = Arm(
            name="slide",
            joints=[PrismaticJoint(name="A", limits=(0, 1), axis=axis)],
            payload=Payload(mass=5.0),
        )
        assert state_of(arm, np.array([[0.3]])).torques[0, 0] == pytest.approx(held, abs=1e-12)


def test_on_a_slope_the_load_leans():
    """An arm pointing up bears nothing on level ground, and weight times sine of the slope times
    its length on a slope.
    """
    for pitch in (0.0, 0.3):
        arm = Arm(
            name="mast",
            base=Base(pitch=pitch),
            joints=[
                RevoluteJoint(
                    name="A", limits=(-4, 4), axis="y", link={"length": 1.0, "direction": "z"}
                )
            ],
            payload=Payload(mass=5.0),
        )
        # Pitched nose down about +y, gravity gains a part along the base's +x and pulls the mast
        # over forwards.
        assert state_of(arm, np.zeros((1, 1))).torques[0, 0] == pytest.approx(
            -5 * STANDARD_GRAVITY * math.sin(pitch), abs=1e-12
        )


def test_gravity_may_be_the_moons():
    """Everything weighs in proportion to the arm's gravity; without it nothing weighs anything."""
    q = np.array([[0.2, -0.4]])
    earth = state_of(planar(payload=Payload(mass=3.0)), q).torques
    np.testing.assert_allclose(
        state_of(planar(payload=Payload(mass=3.0), gravity=1.62), q).torques,
        earth * 1.62 / STANDARD_GRAVITY,
    )
    assert not state_of(planar(payload=Payload(mass=3.0), gravity=0.0), q).torques.any()


def test_a_weightless_arm_carries_what_acts_on_its_tool_alone():
    """Without masses, force and moment on the tool still load every joint; without those too,
    nothing does.
    """
    joints = [RevoluteJoint(name="A", limits=(-4, 4), axis="z", link={"tip": {"xyz": (ONE, 0, 0)}})]
    q = np.array([[0.7]])
    pushed, twisted, free = (
        Arm(name="rod", joints=joints, payload=load)
        for load in (Payload(force=(0, 8, 0)), Payload(moment=(0, 0, 3)), Payload())
    )
    assert state_of(pushed, q).torques[0, 0] == pytest.approx(-8 * ONE)
    assert state_of(twisted, q).torques[0, 0] == pytest.approx(-3)
    assert state_of(free, q).wrenches.shape == state_of(pushed, q).wrenches.shape
    assert not state_of(free, q).wrenches.any()


@given(QS)
@settings(deadline=None, max_examples=30)
def test_steps_multiply_back_to_frames(q: tuple[float, ...]):
    """The poses from place to place, multiplied out, give every place again; the quick way to the
    tool gives the same point.
    """
    arm = spatial()
    at = state_of(arm, np.array([q, q])).frames
    here = np.eye(4)
    for step, frame in zip(steps_between(at)[:, 0], at[:, 0], strict=True):
        here = here @ step
        np.testing.assert_allclose(here, frame, atol=1e-12)
    np.testing.assert_allclose(tool_points(arm, np.array([q])), at[-1, :1, :3, 3], atol=1e-14)


@given(QS)
@settings(deadline=None, max_examples=30)
def test_a_pure_motion_is_an_exponential(q: tuple[float, ...]):
    """Turning or sliding by an amount is the exponential of that amount of the joint's unit
    twist.
    """
    arm = spatial()
    for joint, amount in zip(arm.moving, q, strict=True):
        here = state_of(arm, np.array([q])).frames[-1, 0]
        there = combined(here[..., None], motion(joint.twist, np.array([amount])))[..., 0]
        np.testing.assert_allclose(there, here @ exp(amount * joint.twist), atol=1e-14)


def test_places_are_named_in_walking_order():
    """Base, then seat, joint and tip of every joint, then the tool: as many places as frames."""
    arm = planar()
    assert arm.places == ("base", "A.seat", "A", "A.tip", "B.seat", "B", "B.tip", "tool")
    assert state_of(arm, np.zeros((5, 2))).frames.shape == (8, 5, 4, 4)
    assert state_of(arm, np.zeros((5, 2))).wrenches.shape == (8, 5, 6)
    np.testing.assert_array_equal(arm.limits, [[-4, 4], [-4, 4]])


def test_an_arm_is_described_in_a_line():
    """An arm prints its name, its joints in order, its own weight and its payload's."""
    assert repr(spatial()) == "<Arm 'spatial': RRFPR, 8.2 kg, payload 2.5 kg>"
    assert str(planar()) == "<Arm 'planar': RR, 7.5 kg, payload 0 kg>"


@pytest.mark.parametrize("q", [np.zeros(3), np.zeros((4, 3)), np.zeros((2, 2, 2)), np.array(0.0)])
def test_joint_values_of_another_shape_are_refused(q: np.ndarray):
    """One value per moving joint: anything else is refused and the message says what was found and
    wanted.
    """
    with pytest.raises(ValueError, match=r"q has shape .* expected \(pose, 2\)"):
        state_of(planar(), q)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_joint_values_that_are_no_numbers_are_refused(bad: float):
    """An angle that is not finite is refused by every question."""
    q = np.array([[0.0, bad]])
    for question in (state_of, tool_points):
        with pytest.raises(ValueError, match="not finite"):
            question(planar(), q)


def test_one_pose_may_be_a_plain_row():
    """A single pose may be given as a list of joint values."""
    np.testing.assert_array_equal(as_poses(planar(), [0.1, 0.2]), [[0.1, 0.2]])


def test_an_arm_needs_joints_that_move_and_differ_in_name():
    """Two joints of one name, no joint at all or only fixed ones make no arm."""
    for joints, why in (
        ([RevoluteJoint(name="A", limits=(-1, 1))] * 2, "more than once"),
        ([FixedJoint(name="A")], "no joint that moves"),
        ([], "at least 1 item"),
    ):
        with pytest.raises(ValidationError, match=why):
            Arm(name="arm", joints=joints)


def test_terms_know_their_owner_and_place():
    """Every term carries the full name of its part and sits on that part's frame: mounting on the
    seat, gearbox on the joint, length on the tip.
    """
    joint = RevoluteJoint(
        name="A",
        limits=(-1, 1),
        mounting={"tilt": 1e-3},
        gearbox={"backlash": 1e-3},
        bearing={"kind": "crossed roller", "radial_runout": 1e-5},
        encoder={"noise": 1e-5},
        lumped={"angle": 1e-4},
        link={"length": "0.4 m ± 1 mm"},
    )
    arm = Arm(name="arm", joints=[joint], base=Base(roll="0 deg ± 1 deg"))
    where = {of.owner: arm.places[of.place] for of in arm.terms}
    assert where == {
        "base tilt": "base",
        "joints.A.mounting": "A.seat",
        "joints.A.gearbox": "A",
        "joints.A.bearing": "A",
        "joints.A.encoder": "A",
        "joints.A.lumped": "A",
        "joints.A.link": "A.tip",
    }
    names = [of.name for of in arm.terms]
    assert len(set(names)) == len(names)
    assert "joints.A.gearbox.backlash" in names


def test_the_approach_reaches_every_joint():
    """Coming from one side, no joint leaves its play to chance; coming from either, every unloaded
    one does.
    """
    joints = [RevoluteJoint(name=name, limits=(-1, 1), gearbox={"backlash": 1e-3}) for name in "AB"]
    arm = Arm(name="arm", joints=joints)
    for approach, left in ((0.0, 2), (1.0, 0), (-1.0, 0)):
        matrix = lostmotion.screws(lostmotion.state_of(arm, np.zeros((1, 2))), approach=approach)
        assert (
            sum(
                info.visit is not None and matrix.local[0, :, k].any()
                for k, info in enumerate(matrix.infos)
            )
            == left
        )


SOURCES = Path(lostmotion.__file__).parent
CORE = sorted(
    path
    for name in ("laws", "parts", "mechanism", "error_model", "propagation", "spatial.py")
    for path in ((SOURCES / name).rglob("*.py") if "." not in name else [SOURCES / name])
)
FORBIDDEN_CALLS = {"open", "print", "input", "breakpoint", "exec", "eval", "compile", "__import__"}
FORBIDDEN_METHODS = {
    "open",
    "read_text",
    "write_text",
    "read_bytes",
    "write_bytes",
    "tofile",
    "fromfile",
    "loadtxt",
    "savetxt",
    "savez",
    "memmap",
}


@pytest.mark.parametrize("path", CORE, ids=lambda path: path.relative_to(SOURCES).as_posix())
def test_the_numeric_core_touches_nothing(path: Path):
    """Laws, parts, mechanism, error model and propagation open no file, print nothing, ask nothing
    and read no clock: they only calculate.
    """
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            assert node.func.id not in FORBIDDEN_CALLS, f"line {node.lineno}"
        if isinstance(node, ast.Attribute):
            assert node.attr not in FORBIDDEN_METHODS, f"line {node.lineno}"
        names = (
            [alias.name for alias in node.names]
            if isinstance(node, ast.Import)
            else [node.module]
            if isinstance(node, ast.ImportFrom)
            else []
        )
        for name in names:
            assert (name or "").partition(".")[0] not in {
                "os",
                "io",
                "sys",
                "pathlib",
                "time",
                "datetime",
                "logging",
                "socket",
                "subprocess",
            }, name
