"""Elastostatics of the whole arm, against an assembled stiffness matrix, reciprocity and the
systematic error of a study.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import lostmotion
from lostmotion.mechanism.arm import STANDARD_GRAVITY, Arm
from lostmotion.mechanism.elastostatics import ellipsoid
from lostmotion.mechanism.state import state_of
from lostmotion.parts.joint import PrismaticJoint, RevoluteJoint
from lostmotion.spatial import pose_of, skew
from lostmotion.units import Toleranced

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "whole-arm compliance",
        (
            "one set of equations for all nodes of beams, joint springs and mount; "
            "reciprocity and energy on 100 arms; the study's bias under"
            " a payload"
        ),
        "1e-8; 1e-10; 1e-9",
        "mechanism/elastostatics.py",
    ),
)

YOUNG, POISSON = 70e9, 0.33
SHEAR = YOUNG / (2 * (1 + POISSON))
SECTION = {
    "kind": "custom",
    "area": 8e-4,
    "i_y": 3e-7,
    "i_z": 5e-7,
    "torsion": 6e-7,
    "shear_y": 0.5,
    "shear_z": 0.6,
}
MATERIAL = {"young": YOUNG, "poisson": POISSON, "density": 2700.0}


def vector(rng: np.random.Generator, size: float) -> tuple[float, float, float]:
    """Draw three numbers within ± size."""
    x, y, z = rng.uniform(-size, size, 3)
    return float(x), float(y), float(z)


def elastic_arm(rng: np.random.Generator, joints: int, *, zones: bool = False) -> Arm:
    """Draw an arm whose joint units, links and mount are all elastic, with play, masses, a payload
    and a tilted base.
    """
    chain: list[RevoluteJoint | PrismaticJoint] = []
    for k in range(joints):
        slides = k > 0 and rng.random() < 0.3
        same = {
            "name": f"J{k}",
            "axis": str(rng.choice(["x", "y", "z", "-y"])),
            "origin": {"xyz": vector(rng, 0.1), "rpy": vector(rng, 1.0)},
            "mass": rng.uniform(0, 3),
            "link": {
                "length": rng.uniform(0.2, 0.5),
                "direction": vector(rng, 1.0),
                "section": SECTION,
                "material": MATERIAL,
            },
        }
        stiff = float(rng.uniform(5e4, 5e5)) * (100 if slides else 1)
        drive: dict[str, object] = {"stiffness": stiff, "backlash": Toleranced(1e-5)}
        if zones:
            drive |= {"stiffness": [stiff, 2 * stiff], "zone_torques": [rng.uniform(1, 30)]}
        bearing: dict[str, object] = {
            "kind": "crossed roller",
            "moment_stiffness": rng.uniform(1e5, 1e6),
            "radial_stiffness": rng.uniform(1e7, 1e9),
        }
        if not slides:
            bearing |= {"axial_stiffness": rng.uniform(1e7, 1e9), "axial_runout": 1e-5}
        elif rng.random() < 0.5:
            bearing = {
                "kind": "rolling",
                "span": 0.1,
                "clearance": Toleranced(2e-5),
                "radial_stiffness": rng.uniform(1e7, 1e9),
            }
        kind = PrismaticJoint if slides else RevoluteJoint
        chain.append(kind(**same, limits=(-1.0, 1.0), gearbox=drive, bearing=bearing))
    return Arm(
        name="elastic",
        joints=chain,
        base={
            "roll": Toleranced(rng.uniform(-0.3, 0.3)),
            "angular_stiffness": tuple(rng.uniform(1e5, 1e6, 3)),
            "linear_stiffness": tuple(rng.uniform(1e7, 1e8, 3)),
        },
        tool={"frame": {"xyz": vector(rng, 0.1)}, "mass": 1.0},
        payload={
            "mass": rng.uniform(0, 10),
            "centre_of_mass": vector(rng, 0.1),
            "force": vector(rng, 50),
        },
    )


def beam_element(length: float) -> np.ndarray:
    """Return the stiffness (12, 12) of a Timoshenko beam along x, nodes as (displacement,
    rotation).

    Source: J. Przemieniecki, Theory of Matrix Structural Analysis.
    """
    e, g, area, torsion = YOUNG, SHEAR, SECTION["area"], SECTION["torsion"]
    out = np.zeros((12, 12))
    for row, value in ((0, e * area / length), (3, g * torsion / length)):
        out[np.ix_([row, row + 6], [row, row + 6])] = value * np.array([[1, -1], [-1, 1]])
    for second, shear, shift, turn, sign in (
        (SECTION["i_z"], SECTION["shear_y"], 1, 5, 1.0),
        (SECTION["i_y"], SECTION["shear_z"], 2, 4, -1.0),
    ):
        phi = 12 * e * second / (shear * g * area * length**2)
        a, b = 12 / length**3, sign * 6 / length**2
        c, d = (4 + phi) / length, (2 - phi) / length
        rows = [shift, turn, shift + 6, turn + 6]
        out[np.ix_(rows, rows)] = (
            e
            * second
            / (1 + phi)
            * np.array([[a, b, -a, b], [b, c, -b, d], [-a, -b, a, -b], [b, d, -b, c]])
        )
    return out


def rigid(arm: np.ndarray) -> np.ndarray:
    """Return the matrix (6, 6) from the (displacement, rotation) of a node to that of a point at
    `arm` (m) from it on the same rigid body.
    """
    out = np.eye(6)
    out[:3, 3:] = -skew(arm)
    return out


def joint_flexibility(joint: RevoluteJoint | PrismaticJoint, axis: np.ndarray) -> np.ndarray:
    """Return (displacement, rotation) per (force, moment) of a joint unit with this axis: a drive
    along it, a bearing across it.
    """
    along, out = np.outer(axis, axis), np.zeros((6, 6))
    across = np.eye(3) - along
    drive, bearing = joint.gearbox, joint.bearing
    turn, shift = slice(3, 6), slice(3)
    where = turn if joint.type == "revolute" else shift
    out[where, where] += along / drive.stiffness
    if bearing.kind == "rolling":  # two springs across the axis, `span` apart
        out[shift, shift] += across / (2 * bearing.radial_stiffness)
        out[turn, turn] += across / (bearing.radial_stiffness * bearing.span**2 / 2)
        return out
    out[shift, shift] += across / bearing.radial_stiffness + (
        along / bearing.axial_stiffness if bearing.axial_stiffness else 0
    )
    out[turn, turn] += across / bearing.moment_stiffness
    return out


def assembled(arm: Arm, q: np.ndarray) -> np.ndarray:
    """Return the compliance at the tool from one system of equations for the whole structure: beams
    as elements, joints and mount as springs.

    The unknowns are displacements and rotations of the base plate, of each joint's output and of
    each link's tip, and the forces in joints and mount. With forces as unknowns, rigid springs need
    no large number. All in the base's axes.
    """
    at = state_of(arm, q[None]).frames[:, 0]
    count = len(arm.joints)
    nodes, springs = 1 + 2 * count, 1 + count
    size = 6 * (nodes + springs)
    system, load = np.zeros((size, size)), np.zeros((size, 6))

    def rows(node: int) -> slice:
        return slice(6 * node, 6 * node + 6)

    def spring(
        number: int, flexibility: np.ndarray, behind: tuple[int, np.ndarray] | None, ahead: int
    ) -> None:
        """Add a spring between two nodes: their relative displacement is flexibility x force, and
        opposite forces act on them.
        """
        own = rows(nodes + number)
        system[own, own] = -flexibility
        system[own, rows(ahead)] += np.eye(6)
        system[rows(ahead), own] += np.eye(6)
        if behind is not None:
            node, lever = behind
            system[own, rows(node)] -= rigid(lever)
            system[rows(node), own] -= rigid(lever).T

    mount = np.diag([1 / k for k in (*arm.base.linear_stiffness, *arm.base.angular_stiffness)])
    spring(0, mount, None, 0)
    tip, tip_point = 0, np.zeros(3)
    for k, joint in enumerate(arm.joints):
        here = at[3 * k + 2]
        axis = (
            here[:3, :3]
            @ {"x": np.eye(3)[0], "y": np.eye(3)[1], "z": np.eye(3)[2], "-y": -np.eye(3)[1]}[
                joint.axis
            ]
        )
        out, end = 1 + 2 * k, 2 + 2 * k
        spring(1 + k, joint_flexibility(joint, axis), (tip, here[:3, 3] - tip_point), out)
        along = at[3 * k + 3][:3, 3] - here[:3, 3]
        length = float(np.linalg.norm(along))
        x = along / length
        # the width of the section is along the axis of the joint
        y = np.cross(np.cross(x, axis), x)
        y = (
            -y / np.linalg.norm(y)
            if np.dot(np.cross(np.cross(x, axis), x), axis) < 0
            else y / np.linalg.norm(y)
        )
        turn = np.kron(np.eye(4), np.column_stack([x, y, np.cross(x, y)]))
        both = np.r_[rows(out), rows(end)]
        system[np.ix_(both, both)] += turn @ beam_element(length) @ turn.T
        tip, tip_point = end, at[3 * k + 3][:3, 3]
    tool = rigid(at[-1][:3, 3] - tip_point)
    load[rows(tip)] = tool.T
    # Equations and unknowns are scaled to one magnitude, for accuracy.
    scale = 1 / np.sqrt(np.abs(system).max(axis=1))
    found = scale[:, None] * np.linalg.solve(system * np.outer(scale, scale), scale[:, None] * load)
    moved = tool @ found[rows(tip)]
    swap = [3, 4, 5, 0, 1, 2]  # rotation first, as in the package
    return moved[np.ix_(swap, swap)]


@pytest.mark.parametrize("joints", [3, 4, 5, 6])
def test_an_arm_deflects_as_one_structure_of_beams_and_springs(joints: int):
    """The compliance at the tool of arms of three to six turning and sliding joints equals that of
    the assembled structure, to 1e-8.
    """
    rng = np.random.default_rng(joints)
    for _ in range(10):
        arm = elastic_arm(rng, joints)
        q = rng.uniform(-1, 1, joints)
        expected = assembled(arm, q)
        found = lostmotion.state_of(arm, q).compliance[0]
        unit = np.sqrt(np.diag(expected))
        np.testing.assert_allclose(
            found / np.outer(unit, unit), expected / np.outer(unit, unit), rtol=0, atol=1e-8
        )


def test_compliance_is_reciprocal_and_positive():
    """Compliance matrices of 100 arms are symmetric and positive definite; the shares of
    the parts are positive and add up to one.
    """
    rng = np.random.default_rng(5)
    for number in range(100):
        joints = int(rng.integers(1, 7))
        arm = elastic_arm(rng, joints, zones=number % 2 == 0)
        found = state_of(arm, rng.uniform(-1, 1, joints)).compliances
        whole = found.whole
        unit = np.sqrt(np.einsum("pii->pi", whole))
        alike = whole / (unit[:, :, None] * unit[:, None, :])
        np.testing.assert_allclose(alike, alike.transpose(0, 2, 1), rtol=0, atol=1e-10)
        assert np.linalg.eigvalsh(alike).min() > 0
        assert (found.shares > -1e-12).all()
        np.testing.assert_allclose(found.shares.sum(axis=0), 1.0, rtol=1e-12)


def test_a_rigid_arm_does_not_deflect():
    """Where every part is rigid no wrench moves the tool, whatever the play."""
    bearing = {"kind": "rolling", "span": 0.1, "clearance": Toleranced(3e-5, 1e-5)}
    gearbox = {"backlash": Toleranced(2e-4), "hysteresis": 1e-4, "transmission_error": 1e-4}
    joints = [
        RevoluteJoint(
            name=f"J{k}",
            axis="y",
            limits=(-1, 1),
            link={"length": 0.4},
            gearbox=gearbox,
            bearing=bearing,
        )
        for k in range(3)
    ]
    arm = Arm(name="rigid", joints=joints, payload={"mass": 5.0})
    q = np.random.default_rng(1).uniform(-1, 1, (7, 3))
    assert (
        not lostmotion.state_of(arm, q).deflection(np.array([10.0, -20, 5, 100, 200, -300])).any()
    )
    assert not lostmotion.state_of(arm, q).compliance.any()
    assert state_of(arm, q).compliances.shares.shape[1] == 7
    assert not ellipsoid(lostmotion.state_of(arm, q).compliance).values.any()


def test_play_does_not_add_compliance():
    """An arm has the same compliance with and without play in its gearboxes."""
    rng = np.random.default_rng(8)
    arm = elastic_arm(rng, 4)
    tight = arm.model_copy(
        update={
            "joints": tuple(
                joint.model_copy(update={"gearbox": _without_play(joint)}) for joint in arm.joints
            )
        }
    )
    q = rng.uniform(-1, 1, (5, 4))
    np.testing.assert_allclose(
        lostmotion.state_of(arm, q).compliance,
        lostmotion.state_of(tight, q).compliance,
        rtol=0,
        atol=1e-18,
    )


def _without_play(joint: RevoluteJoint | PrismaticJoint) -> object:
    return joint.gearbox.model_copy(update={"backlash": None})


def payload_wrench(arm: Arm, q: np.ndarray, *, standing: bool = False) -> np.ndarray:
    """Return moment and force of the payload's weight at the tool point, in the base's axes, at
    the command or where the arm stands.
    """
    state = state_of(arm, q)
    at = (state.settled() if standing else state).frames[-1]
    lever = at[:, :3, :3] @ np.array(arm.payload.centre_of_mass)
    force = np.broadcast_to(arm.payload.mass * arm.gravity_in_base, lever.shape)
    return np.hstack([np.cross(lever, force), force])


def test_the_deflection_under_the_payload_is_what_the_payload_adds_to_the_systematic_error():
    """On arms with linear springs, three results agree: deflection, compliance times payload
    weight, and the increase of the systematic error.
    """
    rng = np.random.default_rng(11)
    for _ in range(5):
        arm = elastic_arm(rng, 4)
        plain = {"gearbox": None, "bearing": None}
        joints = [
            joint.model_copy(update={**plain, "gearbox": _without_play(joint)})
            for joint in arm.joints
        ]
        arm = arm.model_copy(
            update={
                "joints": tuple(joints),
                "payload": arm.payload.model_copy(update={"force": (0.0, 0.0, 0.0)}),
            }
        )
        empty = arm.model_copy(update={"payload": arm.payload.model_copy(update={"mass": 0.0})})
        q = rng.uniform(-1, 1, (16, 4))
        wrench = payload_wrench(arm, q)
        added = (
            lostmotion.screws(lostmotion.state_of(arm, q)).bias
            - lostmotion.screws(lostmotion.state_of(empty, q)).bias
        )
        moved = lostmotion.state_of(empty, q).deflection(wrench)
        np.testing.assert_allclose(moved, added, rtol=1e-9, atol=1e-9 * np.abs(added).max())
        by_tangent = np.einsum("pij,pj->pi", lostmotion.state_of(empty, q).compliance, wrench)
        np.testing.assert_allclose(by_tangent, moved, rtol=1e-8, atol=1e-8 * np.abs(added).max())


def test_the_error_of_a_weightless_arm_is_its_compliance_times_the_payload():
    """A study of an arm without mass and without random errors has the root-mean-square error of
    compliance times the weight of the payload to first order in the droop, and of the arm where it
    stands under any weight.
    """
    link = {"length": 0.4, "section": SECTION, "material": MATERIAL, "mass": 0.0}
    joints = [
        RevoluteJoint(name=f"J{k}", axis="y", limits=(-1, 1), link=link, gearbox={"stiffness": 1e5})
        for k in range(3)
    ]
    payload = {"centre_of_mass": (0.1, 0.0, 0.05)}
    for mass in (5.0, 0.005):  # 0.005 kg turns the tool by 3e-6 rad
        arm = Arm(name="weightless", joints=joints, payload={"mass": mass, **payload})
        study = lostmotion.study(arm, 64, robots=2, visits=2)
        q = study.poses.q
        found, state = study.sampled.tally.levels[0] / len(q), state_of(arm, q)
        moved = (state.settled().frames[-1] - state.frames[-1])[:, :3, 3]
        assert found == pytest.approx((moved**2).sum(axis=1).mean(), rel=1e-9)
    linear = np.einsum("pij,pj->pi", state.compliance, payload_wrench(arm, q))[:, 3:]
    assert found == pytest.approx((linear**2).sum(axis=1).mean(), rel=1e-6)


def test_a_straight_beam_has_the_compliance_of_beam_theory():
    """A beam on a rigid joint deflects by F l^3/3EI and shear with its tip free to rotate, by F
    l^3/12EI and shear with its rotation fixed.
    """
    length = 0.5
    arm = Arm(
        name="beam",
        joints=[
            RevoluteJoint(
                name="A",
                axis="y",
                limits=(-1, 1),
                link={"length": length, "section": SECTION, "material": MATERIAL},
            )
        ],
    )
    found = lostmotion.state_of(arm, np.zeros((1, 1))).compliance
    shear = (
        length / (SECTION["shear_y"] * SHEAR * SECTION["area"]),
        length / (SECTION["shear_z"] * SHEAR * SECTION["area"]),
    )
    bending = length**3 / (YOUNG * SECTION["i_z"]), length**3 / (YOUNG * SECTION["i_y"])
    free, held = ellipsoid(found), ellipsoid(found, rotation_fixed=True)
    stretch = length / (YOUNG * SECTION["area"])
    # The width of the section, y of the beam, is along the axis of the joint.
    np.testing.assert_allclose(
        free.values[0], [bending[1] / 3 + shear[1], bending[0] / 3 + shear[0], stretch], rtol=1e-9
    )
    np.testing.assert_allclose(
        held.values[0], [bending[1] / 12 + shear[1], bending[0] / 12 + shear[0], stretch], rtol=1e-8
    )
    np.testing.assert_allclose(np.abs(free.directions[0]), np.eye(3)[:, [2, 1, 0]], atol=1e-9)
    stiff = np.linalg.inv(found[0])
    # With the rotation fixed, a force acts against the translational block of the stiffness.
    np.testing.assert_allclose(
        np.sort(1 / np.linalg.eigvalsh(stiff[3:, 3:])), np.sort(held.values[0]), rtol=1e-8
    )


def test_a_gearbox_has_the_stiffness_of_the_zone_of_its_load():
    """A reducer with two stiffness zones behind a lever arm has the first stiffness under a small
    load and the second beyond the zone limit.
    """
    gearbox = {"stiffness": [1e4, 4e4], "zone_torques": [10.0]}
    for mass, slope in ((0.5, 1e4), (5.0, 4e4)):
        arm = Arm(
            name="lever",
            joints=[
                RevoluteJoint(
                    name="A", axis="y", limits=(-1, 1), link={"length": 0.5}, gearbox=gearbox
                )
            ],
            payload={"mass": mass},
        )
        assert lostmotion.state_of(arm, np.zeros((1, 1))).compliance[0, 1, 1] == pytest.approx(
            1 / slope, rel=1e-9
        )
    # Over both zones: of 20 N m in addition to 2.45 N m, 7.55 N m are in the first zone and the
    # rest in the second.
    arm = arm.model_copy(update={"payload": arm.payload.model_copy(update={"mass": 0.5})})
    first = 10.0 - 0.5 * 0.5 * STANDARD_GRAVITY
    turned = lostmotion.state_of(arm, np.zeros((1, 1))).deflection(np.array([0, 20.0, 0, 0, 0, 0]))[
        0, 1
    ]
    assert turned == pytest.approx(first / 1e4 + (20 - first) / 4e4, rel=1e-12)


def test_many_poses_in_one_call_equal_each_pose_alone():
    """Compliances do not depend on which poses are computed in one call, or in which blocks, also
    with the nonlinear springs of rolling contacts.
    """
    ball = {
        "kind": "ball pair", "bore": 0.045, "outside_diameter": 0.085, "balls": 9, "ball_diameter": 0.0127, "pitch_diameter": 0.065,
        "span": 0.06, "clearance": Toleranced(2e-5),
    }  # fmt: skip
    zoned = {"stiffness": [1e4, 4e4], "zone_torques": [10.0]}
    joints = [
        RevoluteJoint(
            name="A",
            axis="y",
            limits=(-1, 1),
            link={"length": 0.4, "mass": 2.0},
            gearbox=zoned,
            bearing=ball,
        ),
        RevoluteJoint(
            name="B",
            axis="y",
            limits=(-1, 1),
            link={"length": 0.3, "section": SECTION, "material": MATERIAL},
            gearbox={"stiffness": 3e4},
        ),
    ]
    arm = Arm(name="hardening", joints=joints, payload={"mass": 3.0})
    q = np.random.default_rng(2).uniform(-1.5, 1.5, (1500, 2))
    together = lostmotion.state_of(arm, q).compliance
    some = [0, 3, 700, 1023, 1024, 1499]
    alone = np.concatenate([lostmotion.state_of(arm, q[k]).compliance for k in some])
    np.testing.assert_allclose(together[some], alone, rtol=1e-8, atol=1e-8 * np.abs(alone).max())
    asymmetry = state_of(arm, q[:50]).compliances.asymmetry
    shift = together[:50, 3:, 3:]
    expected = [np.abs(each - each.T).max() / np.abs(each).max() for each in shift]
    np.testing.assert_allclose(asymmetry, expected, rtol=1e-6)
    assert 0 < asymmetry.max() < 1e-2  # asymmetry due to the tables of the bearings


@pytest.mark.parametrize(
    "wrench", [np.zeros(3), np.zeros((2, 6)), np.array([0, 0, 0, 0, 0, math.nan])]
)
def test_an_invalid_wrench_is_refused(wrench: np.ndarray):
    """A wrench has six finite values, for all poses together or for each pose."""
    arm = elastic_arm(np.random.default_rng(1), 2)
    with pytest.raises(ValueError, match="wrench"):
        lostmotion.state_of(arm, np.zeros((3, 2))).deflection(wrench)


def potential(arm: Arm, q: np.ndarray) -> np.ndarray:
    """Return the potential energy (pose,) of all masses, N m: the sum of mass times gravity times
    height.
    """
    at, down = state_of(arm, q).frames, arm.gravity_in_base
    out = np.zeros(len(q))

    def raise_(place: int, mass: float, centre: object) -> None:
        point = at[place, :, :3, 3] + at[place, :, :3, :3] @ np.asarray(centre, dtype=float)
        out[:] -= mass * point @ down

    for k, joint in enumerate(arm.joints):
        raise_(3 * k + 1, joint.mass or 0.0, joint.centre_of_mass)
        raise_(3 * k + 2, joint.link.total_mass, joint.link.mass_centre)
    # from the tip of the last joint
    raise_(-2, arm.tool.mass, arm.tool.centre_of_mass or arm.tool.frame.xyz)
    raise_(-1, arm.payload.mass, arm.payload.centre_of_mass)
    return out


def test_holding_torques_are_the_gradient_of_the_potential_energy():
    """By virtual work, holding torques are the derivatives of potential energy by joint value: to
    1e-6, on 100 arms with tilted bases.
    """
    rng = np.random.default_rng(21)
    for _ in range(100):
        joints = int(rng.integers(1, 7))
        arm = elastic_arm(rng, joints)
        arm = arm.model_copy(
            update={
                "base": arm.base.model_copy(update={"pitch": Toleranced(rng.uniform(-1, 1))}),
                "payload": arm.payload.model_copy(update={"force": (0.0, 0.0, 0.0)}),
            }
        )
        q, step = rng.uniform(-1, 1, joints), 1e-3
        held = state_of(arm, q).torques[0]
        for k in range(joints):
            to = np.eye(joints)[k] * step
            far = potential(arm, np.array([q + 2 * to, q + to, q - to, q - 2 * to]))
            slope = float(np.array([-1, 8, -8, 1]) @ far) / (12 * step)
            assert held[k] == pytest.approx(slope, rel=1e-6, abs=1e-6)


def test_a_force_along_a_principal_direction_displaces_along_it():
    """A force along a principal direction displaces the tool point along that direction only."""
    arm = elastic_arm(np.random.default_rng(4), 5)
    found = lostmotion.state_of(arm, np.full((1, 5), 0.3)).compliance
    free = ellipsoid(found)
    for k in range(3):
        direction = free.directions[0, :, k]
        moved = lostmotion.state_of(arm, np.full((1, 5), 0.3)).deflection(
            np.concatenate([np.zeros(3), direction])
        )[0, 3:]
        np.testing.assert_allclose(
            moved, free.values[0, k] * direction, rtol=0, atol=1e-7 * free.values[0, 0]
        )


def test_the_offset_of_the_tool_frame_is_a_lever_arm():
    """A force on an offset tool rotates the last joint by force times lever arm over its stiffness,
    as calculated by hand.
    """
    joint = RevoluteJoint(name="A", axis="z", limits=(-4, 4), gearbox={"stiffness": 1e4})
    arm = Arm(name="arm", joints=[joint], tool={"frame": {"xyz": (0.5, 0.0, 0.0)}})
    found = lostmotion.state_of(arm, np.array([[math.pi / 2]])).compliance[0]
    lever = pose_of(rpy=(0, 0, math.pi / 2))[:3, :3] @ [0.5, 0, 0]
    twist = np.concatenate([[0, 0, 1.0], np.cross([0, 0, 1.0], lever)])
    np.testing.assert_allclose(found, np.outer(twist, twist) / 1e4, rtol=0, atol=1e-15)
