"""Kinematics and statics against Pinocchio, to rounding error."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin
import pytest

from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.state import state_of
from lostmotion.mechanism.tool import Payload
from lostmotion.parts.base import Base
from lostmotion.parts.joint import FixedJoint, PrismaticJoint, RevoluteJoint
from lostmotion.parts.link import Frame, Link

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "kinematics, static torques",
        (
            "Pinocchio, 200 random arms of revolute, prismatic and fixed joints, some on "
            "branches, and the UR5e"
        ),
        "1e-10",
        "mechanism/state.py",
    ),
)

CHAINS = 200
POSES = 5


def vector(rng: np.random.Generator, size: float = 0.5) -> tuple[float, float, float]:
    """Draw three numbers within ± size."""
    x, y, z = rng.uniform(-size, size, 3)
    return float(x), float(y), float(z)


def place(rng: np.random.Generator) -> Frame:
    """Draw a frame: half a metre away at most, turned anyhow."""
    return Frame(xyz=vector(rng), rpy=vector(rng, math.pi))


def random_arm(rng: np.random.Generator) -> Arm:
    """Draw 1 to 10 joints of every kind, some on branches, with weights, a tool, a payload off
    centre and a tilted base.
    """
    joints: list[RevoluteJoint | PrismaticJoint | FixedJoint] = []
    count = int(rng.integers(1, 11))
    # Every fifth joint stands on some place before it, so that what was the chain so far may become
    # a branch; the first one moves the tool.
    places = ["J0", "J0.tip"]
    for k in range(count):
        kind = (
            rng.choice(["revolute", "prismatic", "fixed"], p=[0.6, 0.25, 0.15]) if k else "revolute"
        )
        link = Link(tip=place(rng), mass=rng.uniform(0, 5), centre_of_mass=vector(rng))
        after = str(rng.choice(places)) if k and rng.random() < 0.2 else None
        places += [f"J{k}.seat", f"J{k}", f"J{k}.tip"] if k else []
        same = {
            "name": f"J{k}",
            "after": after,
            "origin": place(rng),
            "mass": rng.uniform(0, 3),
            "centre_of_mass": vector(rng, 0.1),
            "link": link,
        }
        if kind == "fixed":
            joints.append(FixedJoint(**same))
        elif kind == "revolute":
            joints.append(RevoluteJoint(**same, axis=vector(rng), limits=(-4, 4)))
        else:
            joints.append(PrismaticJoint(**same, axis=vector(rng), limits=(-1, 1)))
    return Arm(
        name="random",
        joints=joints,
        base=Base(roll=rng.uniform(-1, 1), pitch=rng.uniform(-1, 1)),
        tool={"frame": place(rng), "mass": rng.uniform(0, 2), "centre_of_mass": vector(rng)},
        payload={"mass": rng.uniform(0, 10), "centre_of_mass": vector(rng)},
        gravity=rng.uniform(1, 25),
    )


def se3(place_or_pose: Frame | np.ndarray) -> pin.SE3:
    """Hand a frame over, from its own numbers: roll, pitch and yaw are turned into a matrix by
    Pinocchio.
    """
    if isinstance(place_or_pose, Frame):
        return pin.SE3(pin.rpy.rpyToMatrix(*place_or_pose.rpy), np.array(place_or_pose.xyz))
    return pin.SE3(place_or_pose)


def point_mass(mass: float, centre: np.ndarray | tuple[float, ...]) -> pin.Inertia:
    """Return an inertia without extent: statics do not see the rest."""
    return pin.Inertia(mass, np.array(centre, dtype=float), np.zeros((3, 3)))


def weight_at(joint: RevoluteJoint | PrismaticJoint | FixedJoint) -> float:
    """Return what stands at a joint's seat (kg): the joint as stated, or else its gearbox alone."""
    if joint.mass is not None:
        return joint.mass
    gearbox = None if isinstance(joint, FixedJoint) else joint.gearbox
    return gearbox.mass or 0.0 if gearbox is not None else 0.0


def as_pinocchio(arm: Arm) -> pin.Model:
    """Build the same arm as a Pinocchio model whose frames bear the arm's place names."""
    model = pin.Model()
    parent, here = 0, pin.SE3.Identity()
    roll, pitch = arm.base.roll.nominal, arm.base.pitch.nominal
    level = pin.rpy.rpyToMatrix(roll, pitch, 0.0)
    model.gravity.linear = level.T @ np.array([0, 0, -arm.gravity])

    def mark(name: str, at: pin.SE3) -> None:
        model.addFrame(pin.Frame(name, parent, at, pin.FrameType.OP_FRAME))

    mark("base", here)
    for joint in arm.joints:
        if joint.after is not None:
            on = model.frames[model.getFrameId(joint.after)]
            parent, here = on.parentJoint, on.placement
        here = here * se3(joint.origin)
        mark(f"{joint.name}.seat", here)
        model.appendBodyToJoint(parent, point_mass(weight_at(joint), joint.centre_of_mass), here)
        if not isinstance(joint, FixedJoint):
            axis = (
                np.array([0, 0, 1.0])
                if joint.axis == "z"
                else np.array(joint.axis) / np.linalg.norm(joint.axis)
            )
            kind = (
                pin.JointModelRevoluteUnaligned
                if isinstance(joint, RevoluteJoint)
                else pin.JointModelPrismaticUnaligned
            )
            parent = model.addJoint(parent, kind(axis), here, joint.name)
            here = pin.SE3.Identity()
        mark(joint.name, here)
        model.appendBodyToJoint(
            parent, point_mass(joint.link.total_mass, joint.link.mass_centre), here
        )
        here = here * se3(joint.link.tip)
        mark(f"{joint.name}.tip", here)
    centre = arm.tool.frame.xyz if arm.tool.centre_of_mass is None else arm.tool.centre_of_mass
    model.appendBodyToJoint(parent, point_mass(arm.tool.mass, centre), here)
    here = here * se3(arm.tool.frame)
    mark("tool", here)
    model.appendBodyToJoint(parent, point_mass(arm.payload.mass, arm.payload.centre_of_mass), here)
    return model


def frames_by_pinocchio(model: pin.Model, names: tuple[str, ...], q: np.ndarray) -> np.ndarray:
    """Return Pinocchio's poses (place, 4, 4)."""
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    return np.array([data.oMf[model.getFrameId(name)].homogeneous for name in names])


@pytest.mark.parametrize("seed", range(20))
def test_gearboxes_weigh_at_their_joints_as_pinocchios_bodies_do(seed: int):
    """A gearbox is a body on the link before its joint where no mass of the joint is stated; where
    one is stated, it is part of that.
    """
    rng = np.random.default_rng(seed)
    drawn = random_arm(rng)
    own = tuple(
        joint
        if isinstance(joint, FixedJoint)
        else joint.model_copy(update={"mass": None, "gearbox": geared(joint, rng.uniform(1, 70))})
        for joint in drawn.joints
    )
    within = tuple(
        joint
        if isinstance(joint, FixedJoint)
        else joint.model_copy(update={"gearbox": geared(joint, 70.0)})
        for joint in drawn.joints
    )
    q = rng.uniform(-3, 3, (POSES, len(drawn.moving)))
    arm = drawn.model_copy(update={"joints": own})
    model = as_pinocchio(arm)
    theirs = [pin.computeGeneralizedGravity(model, model.createData(), each) for each in q]
    np.testing.assert_allclose(
        state_of(arm, q).torques, theirs, rtol=0, atol=1e-10 * 1000 * arm.gravity
    )
    assert arm.mass == pytest.approx(
        sum(map(weight_at, own)) + sum(joint.link.total_mass for joint in own) + arm.tool.mass,
        rel=1e-14,
    )
    np.testing.assert_array_equal(
        state_of(drawn.model_copy(update={"joints": within}), q).torques, state_of(drawn, q).torques
    )


def geared(joint: RevoluteJoint | PrismaticJoint, mass: float) -> object:
    """Return a gearbox of this mass as a joint of this kind has it."""
    return (
        type(joint)
        .model_validate({"name": "x", "limits": (-1, 1), "gearbox": {"mass": mass}})
        .gearbox
    )


@pytest.mark.parametrize("seed", range(CHAINS))
def test_any_chain_stands_and_holds_as_pinocchios_does(seed: int):
    """Chains of any joints, weights and base tilts: frames agree to 1e-10 m, holding torques to
    1e-10 of the weight carried.
    """
    rng = np.random.default_rng(seed)
    arm = random_arm(rng)
    model = as_pinocchio(arm)
    q = rng.uniform(-3, 3, (POSES, len(arm.moving)))
    ours, torques = state_of(arm, q).frames, state_of(arm, q).torques
    carried = (
        sum(weight_at(joint) + joint.link.total_mass for joint in arm.joints)
        + arm.tool.mass
        + arm.payload.mass
    )
    for row in range(POSES):
        np.testing.assert_allclose(
            ours[:, row], frames_by_pinocchio(model, arm.places, q[row]), rtol=0, atol=1e-10
        )
        theirs = pin.computeGeneralizedGravity(model, model.createData(), q[row])
        np.testing.assert_allclose(
            torques[row], theirs, rtol=0, atol=1e-10 * max(1.0, carried * arm.gravity)
        )


@pytest.mark.parametrize("seed", range(CHAINS))
def test_the_carry_matrices_of_joints_are_pinocchios_jacobian(seed: int):
    """The carry matrix of a joint's place times its unit motion is its column of the tool's
    Jacobian in the base's axes, to 1e-10.
    """
    rng = np.random.default_rng(2000 + seed)
    arm = random_arm(rng)
    model = as_pinocchio(arm)
    state = state_of(arm, rng.uniform(-3, 3, (1, len(arm.driven))))
    ours = np.column_stack(
        [state.carry(place)[0] @ arm.tree.places[place].twist for place in arm.tree.moved]
    )
    theirs = pin.computeFrameJacobian(
        model,
        model.createData(),
        np.array(state.q[0]),
        model.getFrameId("tool"),
        pin.ReferenceFrame.LOCAL_WORLD_ALIGNED,
    )
    linear, turning = np.split(theirs.reshape(6, -1), 2)
    np.testing.assert_allclose(ours, np.vstack([turning, linear]), rtol=0, atol=1e-10)


@pytest.mark.parametrize("seed", range(0, CHAINS, 10))
def test_a_force_on_the_tool_is_held_as_pinocchios_jacobian_says(seed: int):
    """A process force and moment in the tool's axes add to each drive what Pinocchio's tool
    Jacobian says, to 1e-10 of the force.
    """
    rng = np.random.default_rng(1000 + seed)
    arm = random_arm(rng)
    model = as_pinocchio(arm)
    force, moment = vector(rng, 100), vector(rng, 100)
    q = rng.uniform(-3, 3, (1, len(arm.moving)))
    pressed = arm.with_payload(Payload(force=force, moment=moment))
    ours = state_of(pressed, q, gravity=np.zeros(3)).torques[0]
    data = model.createData()
    # linear rows first
    jacobian = pin.computeFrameJacobian(
        model, data, q[0], model.getFrameId("tool"), pin.ReferenceFrame.LOCAL
    )
    np.testing.assert_allclose(ours, -jacobian.T @ np.array([*force, *moment]), rtol=0, atol=1e-8)


def test_the_joints_of_the_base_carry_what_pinocchio_says():
    """The whole wrench on the first joint, not only the part that its drive holds, equals
    Pinocchio's constraint force.
    """
    rng = np.random.default_rng(7)
    for _ in range(20):
        arm = random_arm(rng)
        model = as_pinocchio(arm)
        q = rng.uniform(-3, 3, (1, len(arm.moving)))
        data = model.createData()
        pin.rnea(model, data, q[0], np.zeros(model.nv), np.zeros(model.nv))
        # on the body, in the joint's frame
        held = np.concatenate([data.f[1].angular, data.f[1].linear])
        ours = state_of(arm, q).wrenches[arm.places.index(arm.moving[0].name), 0]
        np.testing.assert_allclose(ours, -held, rtol=0, atol=1e-10 * max(1.0, np.abs(held).max()))


# UR5e, the maker's standard DH numbers (m, degrees) and link masses (kg)
UR5E_A = (0, -0.425, -0.3922, 0, 0, 0)
UR5E_D = (0.1625, 0, 0, 0.1333, 0.0997, 0.0996)
UR5E_ALPHA = (90, 0, 0, 90, -90, 0)
UR5E_MASS = (3.761, 8.058, 2.846, 1.37, 1.3, 0.365)


def ur5e() -> Arm:
    """Build a UR5e: after each joint's turn about z, d along z, a along x and alpha about x; masses
    half way along.
    """
    links = [
        Link(tip=Frame(xyz=(a, 0, d), rpy=(math.radians(alpha), 0, 0)), mass=m)
        for a, d, alpha, m in zip(UR5E_A, UR5E_D, UR5E_ALPHA, UR5E_MASS, strict=True)
    ]
    return Arm(
        name="UR5e",
        joints=[
            RevoluteJoint(name=f"J{k}", limits=(-7, 7), link=link)
            for k, link in enumerate(links, 1)
        ],
        payload=Payload(mass=5.0),
    )


def by_dh(q: np.ndarray) -> np.ndarray:
    """Multiply out the standard DH matrices: the flange (4, 4)."""
    out = np.eye(4)
    for theta, a, d, alpha in zip(q, UR5E_A, UR5E_D, np.radians(UR5E_ALPHA), strict=True):
        ct, st, ca, sa = math.cos(theta), math.sin(theta), math.cos(alpha), math.sin(alpha)
        out = out @ np.array(
            [
                [ct, -st * ca, st * sa, a * ct],
                [st, ct * ca, -ct * sa, a * st],
                [0, sa, ca, d],
                [0, 0, 0, 1],
            ]
        )
    return out


def test_a_ur5e_stands_and_holds_as_pinocchios_does():
    """A UR5e from its DH numbers: flange as the DH matrices multiply out, frames and holding
    torques as Pinocchio's.
    """
    arm, rng = ur5e(), np.random.default_rng(3)
    model = as_pinocchio(arm)
    q = rng.uniform(-math.pi, math.pi, (50, 6))
    ours, torques = state_of(arm, q).frames, state_of(arm, q).torques
    for row in range(50):
        np.testing.assert_allclose(ours[-1, row], by_dh(q[row]), atol=1e-12)
        np.testing.assert_allclose(
            ours[:, row], frames_by_pinocchio(model, arm.places, q[row]), atol=1e-12
        )
        np.testing.assert_allclose(
            torques[row],
            pin.computeGeneralizedGravity(model, model.createData(), q[row]),
            atol=1e-10,
        )


def test_a_ur5e_stretched_out_reaches_as_its_drawing_shows():
    """At joint zeros a UR5e lies stretched along -x: flange at (-0.8172, -0.2329, 0.0628), as the
    drawing's sums say.
    """
    flange = state_of(ur5e(), np.zeros((1, 6))).frames[-1, 0]
    np.testing.assert_allclose(
        flange[:3, 3], [-0.425 - 0.3922, -0.1333 - 0.0996, 0.1625 - 0.0997], atol=1e-12
    )
