"""Static loads of joints by cause and over tilts of the base, and bending of links by cause."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model.budget import costs
from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.loads.survey import Survey
from lostmotion.mechanism import closed_chain
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.holding_torques import (
    holding_torques,
    static_loads,
    worst_torques_over_tilts,
)
from lostmotion.mechanism.load_causes import CAUSES, OWN_WEIGHT, bending, single_cause_arms
from lostmotion.mechanism.state import state_of
from lostmotion.parts.base import Base
from lostmotion.parts.joint import RevoluteJoint
from lostmotion.parts.link import Material
from lostmotion.units import Toleranced
from tests.mechanism.test_elastostatics import elastic_arm, payload_wrench

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "worst torque within a tilt, moment on bearings, loads and bending by cause",
        "brute force over directions of gravity; closed forms of a cantilever; the total",
        "never exceeded; 1e-6; 1e-12",
        "mechanism/holding_torques.py mechanism/load_causes.py",
    ),
)


def directions_within(rng: np.random.Generator, tilt: float, count: int) -> np.ndarray:
    """Draw directions (count, 3) within an angle `tilt` (rad) of straight down, half of them on the
    edge of that cone.
    """
    away = np.where(rng.random(count) < 0.5, tilt, tilt * np.sqrt(rng.random(count)))
    side = rng.uniform(0, 2 * math.pi, count)
    return np.column_stack(
        [np.sin(away) * np.cos(side), np.sin(away) * np.sin(side), -np.cos(away)]
    )


@pytest.mark.parametrize("tilt", [0.0, 0.2, 1.0, 2.5, math.pi])
def test_the_worst_torque_over_tilts_is_the_largest_and_is_reached(tilt: float):
    """None of 500 directions of gravity within a tilt of the base requires more torque than the
    reported maximum; the largest is within 3 % of it.
    """
    rng = np.random.default_rng(int(10 * tilt))
    for _ in range(2):
        arm = elastic_arm(rng, 4)  # with a process force
        q = rng.uniform(-1, 1, (1, 4))
        level = state_of(arm, q)
        worst = worst_torques_over_tilts(level, within=tilt)[0]
        held = np.abs(
            [
                state_of(arm, q, frames=level.frames, gravity=arm.gravity * down).torques[0]
                for down in directions_within(rng, tilt, 500 if tilt else 1)
            ]
        )
        assert (held.max(axis=0) <= worst * (1 + 1e-12)).all()
        np.testing.assert_allclose(held.max(axis=0), worst, rtol=3e-2)


def test_every_worst_torque_occurs_under_its_reported_gravity():
    """The gravity reported for each worst torque causes it, as a sum over causes, for the whole
    arm, and on a base of that roll and pitch.
    """
    rng = np.random.default_rng(3)
    for _ in range(2):
        arm = elastic_arm(rng, 5)
        q = rng.uniform(-1, 1, (40, 5))
        within = (
            worst_torques_over_tilts(state_of(arm, q), within=0.3),
            worst_torques_over_tilts(state_of(arm, q)),
        )
        for k, node in enumerate(static_loads(arm, q, 0.3)):
            assert node.within_tilt is not None
            assert abs(node.nominal.value) == pytest.approx(
                np.abs(state_of(arm, q).torques[:, k]).max(), rel=1e-12
            )
            for asked, worst in zip((node.within_tilt, node.any_tilt), within, strict=True):
                assert abs(asked.value) == pytest.approx(worst[:, k].max(), rel=1e-9)
                assert state_of(arm, q[asked.index], gravity=asked.gravity).torques[
                    0, k
                ] == pytest.approx(asked.value, rel=1e-9)
                assert sum(asked.by_cause.values()) == pytest.approx(asked.value, rel=1e-12)
                assert np.linalg.norm(asked.gravity) == pytest.approx(arm.gravity)
                x, y, z = asked.gravity / arm.gravity
                # of the base that has this gravity in its axes
                roll, pitch = math.atan2(-y, -z), math.asin(np.clip(x, -1, 1))
                leaning = arm.model_copy(
                    update={"base": Base(roll=Toleranced(roll), pitch=Toleranced(pitch))}
                )
                assert state_of(leaning, q[asked.index]).torques[0, k] == pytest.approx(
                    asked.value, rel=1e-9, abs=1e-9
                )
            assert node.within_tilt.tilt <= 0.3 + 1e-12


def test_the_worst_bearing_moment_is_not_exceeded_at_any_tilt():
    """Reported bearing loads equal the wrench there at the nominal tilt; over 400 tilts the moment
    reaches the reported maximum and no more.
    """
    rng = np.random.default_rng(4)
    arm = elastic_arm(rng, 3)
    arm = arm.model_copy(
        update={"payload": arm.payload.model_copy(update={"force": (0.0, 0.0, 0.0)})}
    )
    q = rng.uniform(-1, 1, (5, 3))
    tilts = arm.gravity * directions_within(rng, math.pi, 400)
    for joint, node in zip(arm.moving, static_loads(arm, q), strict=True):
        place = arm.places.index(joint.name)
        across = np.eye(3) - np.outer(joint.twist[:3], joint.twist[:3])

        def sizes(carried: np.ndarray, across: np.ndarray = across) -> np.ndarray:
            return np.linalg.norm(carried[..., :3] @ across, axis=-1)

        assert node.moment == pytest.approx(
            sizes(state_of(arm, q).wrenches[place]).max(), rel=1e-12
        )
        assert node.force == pytest.approx(
            np.linalg.norm(state_of(arm, q).wrenches[place, :, 3:], axis=1).max(), rel=1e-12
        )
        at_worst = q[[node.moment_any_tilt_index]]
        frames = state_of(arm, at_worst).frames
        seen = max(
            sizes(state_of(arm, at_worst, frames=frames, gravity=down).wrenches[place])[0]
            for down in tilts
        )
        assert seen <= node.moment_any_tilt * (1 + 1e-12)
        assert seen == pytest.approx(node.moment_any_tilt, rel=3e-2)


def test_the_largest_holding_torque_is_sought_at_every_pose():
    """Every pose has its holding torques; the largest of each joint, level and over all tilts, is
    reported with its sign and its pose.
    """
    rng = np.random.default_rng(5)
    arm = elastic_arm(rng, 3)
    q = rng.uniform(-1, 1, (5000, 3))  # more than are computed in one block
    found, largest = holding_torques(arm, q)
    torques, over_tilts = state_of(arm, q).torques, worst_torques_over_tilts(state_of(arm, q))
    np.testing.assert_allclose(found, torques, rtol=1e-12, atol=1e-12 * np.abs(torques).max())
    for k, each in enumerate(largest):
        assert (each.worst, each.over_tilts) == pytest.approx(
            (torques[each.worst_index, k], over_tilts[each.over_tilts_index, k]), rel=1e-12
        )
        assert abs(each.worst) == pytest.approx(np.abs(torques[:, k]).max(), rel=1e-12)
        assert each.over_tilts == pytest.approx(over_tilts[:, k].max(), rel=1e-12)


def test_the_mass_of_a_tool_is_at_the_tool_point_unless_stated():
    """A tool of 2 kg, tool point 0.5 m and flange 0.4 m from the axis: its torque follows the
    cosine; a centre 0.4 m behind the flange has none.
    """
    joint = {
        "name": "A",
        "type": "revolute",
        "axis": "y",
        "limits": (-1, 1),
        "link": {"length": 0.4},
    }
    q = np.array([[0.0], [0.6], [-0.9]])
    for centre, lever in (
        ({}, 0.5),
        ({"centre_of_mass": (-0.4, 0.0, 0.0)}, 0.0),
        ({"centre_of_mass": (0.1, 0.0, 0.0)}, 0.5),
    ):
        tool = {"frame": {"xyz": (0.1, 0.0, 0.0)}, "mass": 2.0, **centre}
        arm = Arm.model_validate({"name": "tool", "joints": [joint], "tool": tool})
        np.testing.assert_allclose(
            np.abs(state_of(arm, q).torques[:, 0]),
            2.0 * arm.gravity * lever * np.cos(q[:, 0]),
            atol=1e-12,
        )


def test_causes_add_up_to_the_whole():
    """Wrenches of an arm under one cause of load at a time add up to those under all causes; a
    cause without load is not reported.
    """
    rng = np.random.default_rng(6)
    arm = elastic_arm(rng, 6)
    q = rng.uniform(-1, 1, (9, 6))
    apart = single_cause_arms(arm)
    assert tuple(apart) == CAUSES
    whole = state_of(arm, q).wrenches
    np.testing.assert_allclose(
        sum(state_of(one, q).wrenches for one in apart.values()),
        whole,
        rtol=0,
        atol=1e-12 * np.abs(whole).max(),
    )
    assert "payload" not in single_cause_arms(
        arm.model_copy(update={"payload": arm.payload.model_copy(update={"mass": 0.0})})
    )


def links_alone(arm: Arm) -> Arm:
    """Return the arm with the bending of its links as its only error."""
    exact = Material(young=70e9, poisson=0.33, density=2700.0)
    return arm.model_copy(
        update={
            "base": Base(),
            "joints": tuple(
                joint.model_copy(
                    update={
                        "gearbox": None,
                        "bearing": None,
                        "link": joint.link.model_copy(update={"material": exact}),
                    }
                )
                for joint in arm.joints
            ),
        }
    )


def test_the_causes_of_bending_add_up_to_the_bending_of_the_link():
    """Contributions of own weight, payload, process force, tool, next links and next joints add up
    to the link's deflection and slope, to 1e-12.
    """
    rng = np.random.default_rng(9)
    arm = elastic_arm(rng, 5)
    q = rng.uniform(-1, 1, (50, 5))
    at, matrix = state_of(arm, q).settled().frames, pose_matrix(arm, q)
    loaded = [(info.of, matrix.local[:, :, k]) for k, info in enumerate(matrix.infos)]
    for bent in bending(arm, q, np.zeros((50, 3)), 0.0):
        place = arm.places.index(f"{bent.joint}.tip")
        twist = sum(
            screw
            for of, screw in loaded
            if of.owner == f"joints.{bent.joint}.link" and of.term.level == "design"
        )
        line = np.einsum(
            "pji,pj->pi", at[place, :, :3, :3], at[place, :, :3, 3] - at[place - 1, :, :3, 3]
        )
        line /= np.linalg.norm(line, axis=1)[:, None]
        sizes = [
            np.linalg.norm(np.cross(line, part), axis=1) for part in (twist[:, 3:], twist[:, :3])
        ]
        for size, found, index, column in zip(
            sizes,
            (bent.deflection, bent.slope),
            (bent.deflection_index, bent.slope_index),
            (0, 1),
            strict=True,
        ):
            assert found == pytest.approx(size.max(), rel=1e-12)
            assert index == size.argmax()
            assert sum(part[column] for part in bent.by_cause.values()) == pytest.approx(
                found, rel=1e-12
            )


def test_a_cantilever_bends_by_each_cause_as_in_beam_theory():
    """A horizontal beam with little shear, so stiff that it stays straight: deflections F l^3/3EI
    under the payload and w l^4/8EI under its weight; slopes F l^2/2EI and w l^3/6EI.
    """
    length, second, young, mass = 2.0, 1e-6, 200e9, 1.5
    section = {
        "kind": "custom",
        "area": 1e3,
        "i_y": second,
        "i_z": second,
        "torsion": 2 * second,
        "shear_y": 1.0,
        "shear_z": 1.0,
    }
    link = {
        "length": length,
        "section": section,
        "material": {"young": young, "poisson": 0.3, "density": 1.0},
        "mass": mass,
    }
    arm = Arm(
        name="beam",
        joints=[RevoluteJoint(name="A", axis="y", limits=(-1, 1), link=link)],
        payload={"mass": 3.0},
    )
    bias = pose_matrix(arm, np.zeros((1, 1))).bias[:, 3:]
    (bent,) = bending(arm, np.zeros((1, 1)), bias, float(bias[0] @ bias[0]))
    force, weight = 3.0 * arm.gravity, mass * arm.gravity / length
    assert bent.by_cause["payload"][:2] == pytest.approx(
        (force * length**3 / (3 * young * second), force * length**2 / (2 * young * second)),
        rel=1e-6,
    )
    own = weight * length**4 / (8 * young * second), weight * length**3 / (6 * young * second)
    assert bent.by_cause[OWN_WEIGHT][:2] == pytest.approx(own, rel=1e-6)
    assert set(bent.by_cause) == {"payload", "links", OWN_WEIGHT}
    assert bent.by_cause["links"] == (0.0, 0.0, 0.0)
    assert sum(part[2] for part in bent.by_cause.values()) == pytest.approx(1.0)


def test_the_causes_of_bending_add_up_to_the_share_of_the_link_in_the_budget():
    """Over a study, the shares of the causes add up to the share of the link in the error budget,
    for links of exact stiffness, but for what is of second order beside them: the square of the
    tool's turn.
    """
    arm = links_alone(elastic_arm(np.random.default_rng(12), 4))
    study = lostmotion.study(arm, 64, robots=2, visits=2)
    shares = {cost.part: cost.share for cost in costs(study.sampled.tally)}
    turn = np.linalg.norm(study.sampled.bias[:, :3], axis=1).max()
    for bent in study.bending:
        assert sum(part[2] for part in bent.by_cause.values()) == pytest.approx(
            shares[f"joints.{bent.joint}.link"], abs=turn**2
        )


def test_a_survey_agrees_with_compliance_and_deflection():
    """Most compliant pose, shares, ellipsoid and payload deflection of a survey agree with
    `compliance` and `deflection` where the arm stands.
    """
    arm = elastic_arm(np.random.default_rng(13), 4)
    found = Survey.of(arm, lostmotion.sample_poses(arm, 64), 0.2)
    q = found.poses.q
    whole = lostmotion.state_of(arm, q).settled().compliance
    softest = np.linalg.eigvalsh(whole[:, 3:, 3:])[:, -1]
    np.testing.assert_allclose(found.max_compliance, softest, rtol=1e-9)
    assert found.softest_pose == softest.argmax()
    np.testing.assert_allclose(
        found.compliance, whole[found.softest_pose], rtol=0, atol=1e-9 * np.abs(whole).max()
    )
    np.testing.assert_allclose(
        found.rotational.values[0],
        np.linalg.eigvalsh(whole[found.softest_pose, :3, :3])[::-1],
        rtol=1e-7,
    )
    assert found.shares.sum() == pytest.approx(1.0)
    assert found.softest_shares.sum() == pytest.approx(1.0)
    assert found.payload_deflection is not None
    lifted = np.einsum("pij,pj->pi", whole, payload_wrench(arm, q, standing=True))
    np.testing.assert_allclose(
        found.payload_deflection, np.linalg.norm(lifted[:, 3:], axis=1), rtol=1e-6
    )
    assert [node.joint for node in found.joint_loads] == ["J0", "J1", "J2", "J3"]


def test_a_rigid_arm_is_surveyed_too():
    """A rigid arm has holding torques and zero compliance."""
    joint = {
        "type": "revolute",
        "name": "A",
        "axis": "y",
        "limits": (-1, 1),
        "link": {"length": 0.5, "mass": 2.0},
        "gearbox": {"backlash": Toleranced(1e-4)},
    }
    found = Survey.of(
        Arm(name="rigid", joints=[joint]),
        lostmotion.sample_poses(Arm(name="rigid", joints=[joint]), 64),
    )
    assert not found.max_compliance.any()
    assert found.parts == ()
    assert found.payload_deflection is None
    assert found.joint_loads[0].any_tilt.value != 0


def test_the_links_of_a_closed_chain_share_the_arms_under_single_causes(monkeypatch):
    """The closures of a palletiser are solved for a few poses of all its links together, not for
    each link and each cause of load again.
    """
    arm = lostmotion.read("examples/closed-chains/parallelogram-palletiser.toml")
    q = lostmotion.sample_poses(arm, 16).q
    loops, solved = [], closed_chain.settled_loops

    def counted(*given, **more):
        loops.append(given)
        return solved(*given, **more)

    monkeypatch.setattr(closed_chain, "settled_loops", counted)
    found = bending(arm, q, np.zeros((16, 3)), 0.0)
    assert len(found) > 5
    # at all poses and at those of the largest deflections: the arm, its loads by cause, and the
    # loads by which friction of each of these is assumed
    assert len(loops) <= 2 * (1 + len(CAUSES)) + (1 + len(CAUSES))


def test_tolerances_of_a_link_do_not_change_its_bending():
    """A link with tolerances of length and stiffness has the bending of the exact link, by cause
    and share.
    """

    def beam(length: str, scatter: str) -> Arm:
        material = {
            "young": "70 GPa",
            "poisson": 0.33,
            "density": "2700 kg/m^3",
            "scatter": scatter,
        }
        link = {
            "length": length,
            "section": {"kind": "tube", "outer": "80 mm", "wall": "4 mm"},
            "material": material,
        }
        joint = {"name": "A", "type": "revolute", "axis": "y", "limits": (-1, 1), "link": link}
        return Arm.model_validate({"name": "beam", "joints": [joint], "payload": {"mass": "3 kg"}})

    arms, q = (beam("400 mm", "0 %"), beam("400 mm ± 5 mm", "10 %")), np.array([[0.0], [0.4]])
    bias = pose_matrix(arms[0], q).bias[:, 3:]
    exact, inexact = (bending(arm, q, bias, float(np.vdot(bias, bias)) / len(q))[0] for arm in arms)
    assert sum(part[2] for part in exact.by_cause.values()) == pytest.approx(1)
    assert inexact == exact
