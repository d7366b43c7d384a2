"""The tables of a controller have the same kinematics, torques, mean and covariance as the
study.
"""

from __future__ import annotations

import functools

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model.pose_matrix import screws
from lostmotion.laws.distributions import Cosine, Normal, Sine
from lostmotion.mechanism.state import state_of
from lostmotion.mechanism.tool import Payload
from tests.parts.random_arms import EXAMPLES, random_arm, random_poses

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "controller: kinematics, torques, mean and covariance from tables",
        "the study's pose matrix on 31 arms with every kind of part, last motion known and unknown",
        "1e-10",
    ),
)

NAMES = (
    "z-arm.toml",
    "ur5e.urdf",
    "arm-from-drawings.toml",
    "arm-in-the-sun.toml",
    "paper/z-arm-lumped.toml",
    "gantry.toml",
    "scara.toml",
)
ARMS = {name: functools.partial(lostmotion.read, EXAMPLES / name) for name in NAMES} | {
    f"random {seed}": functools.partial(random_arm, seed) for seed in range(24)
}


def covariance_of(matrix):
    """Return the covariance of the displacement (pose, 3, 3): columns with equal draws add
    first.
    """
    drawn = matrix.merged.columns("robot", "visit", "robot x visit")
    shifts = matrix.merged.tool[:, 3:][:, :, drawn]
    return shifts @ shifts.transpose(0, 2, 1)


def assert_near(found, expected, share=1e-10):
    """Compare arrays (pose, ...) by their largest element at each pose, and by the largest of all
    poses where one is zero.
    """
    rows = np.abs(expected).reshape(len(expected), -1).max(axis=1)
    scale = np.maximum(rows, 1e-6 * max(rows.max(), 1e-30))
    assert (np.abs(found - expected).reshape(len(expected), -1).max(axis=1) <= share * scale).all()


@pytest.mark.parametrize("name", ARMS)
def test_a_controller_predicts_what_a_study_computes(name):
    """Tool pose, holding torques, expected error and covariance agree for every kind of part,
    whether the last motion is known or not.
    """
    arm = ARMS[name]()
    model, q = lostmotion.controller(arm, largest_payload=100.0), random_poses(arm, 41)[1:]
    mixed = np.random.default_rng(3).integers(-1, 2, size=q.shape).astype(float)
    for approach in (0.0, 1.0, -1.0, mixed):
        found, matrix = (
            model.predict(q, side=np.broadcast_to(approach, q.shape)),
            screws(state_of(arm, q), approach=approach),
        )
        tool = state_of(arm, q).frames[-1]
        assert not found.status.any()
        np.testing.assert_allclose(found.point, tool[:, :3, 3], atol=1e-13)
        np.testing.assert_allclose(found.turn, tool[:, :3, :3], atol=1e-13)
        assert_near(found.torques, state_of(arm, q).torques)
        assert_near(found.screw, matrix.bias)
        assert_near(found.covariance, covariance_of(matrix))
        assert_near(
            found.mean_square,
            np.einsum("pii->p", covariance_of(matrix)) + (matrix.bias[:, 3:] ** 2).sum(axis=1),
        )


def test_payload_and_gravity_are_inputs():
    """Another payload, a process force and a tilted base need no other tables; assumed friction
    belongs to the drives and stays the same.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    payload = Payload(
        mass=3.0,
        centre_of_mass=(0.02, -0.01, 0.05),
        force=(5.0, -20.0, 10.0),
        moment=(0.3, 0.1, -0.2),
    )
    tilted = arm.with_payload(payload)
    tilted = tilted.model_copy(
        update={"base": tilted.base.model_copy(update={"pitch": lostmotion.units.Toleranced(0.2)})}
    )
    tilted.__dict__["_holdings"] = arm._holdings
    q = random_poses(arm, 40)
    load = [3.0, 0.02, -0.01, 0.05, 5.0, -20.0, 10.0, 0.3, 0.1, -0.2]
    found, matrix = (
        lostmotion.controller(arm).predict(q, load, tilted.gravity_in_base),
        screws(state_of(tilted, q)),
    )
    assert_near(found.torques, state_of(tilted, q).torques)
    assert_near(found.screw, matrix.bias)
    assert_near(found.covariance, covariance_of(matrix))


def test_the_jacobian_is_the_derivative_of_the_tool():
    """Central differences of the tool point and of its rotation, on an arm with turning and sliding
    joints.
    """
    arm = next(
        arm
        for arm in map(random_arm, range(40))
        if {joint.type for joint in arm.moving} == {"revolute", "prismatic"}
    )
    q, step = random_poses(arm, 5) * 0.9, 1e-6
    found = lostmotion.controller(arm, largest_payload=100.0).predict(q).jacobian
    for k in range(q.shape[1]):
        ends = [
            state_of(arm, q + sign * step * np.eye(q.shape[1])[k]).frames[-1] for sign in (1, -1)
        ]
        spin = (
            (ends[0][:, :3, :3] - ends[1][:, :3, :3])
            / (2 * step)
            @ state_of(arm, q).frames[-1][:, :3, :3].transpose(0, 2, 1)
        )
        np.testing.assert_allclose(
            found[:, 3:, k], (ends[0] - ends[1])[:, :3, 3] / (2 * step), atol=1e-8
        )
        np.testing.assert_allclose(
            found[:, :3, k],
            np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1),
            atol=1e-8,
        )


def test_a_calibrated_robot_has_its_own_mean_and_less_scatter():
    """Estimates of draws move errors from the covariance to the mean, harmonics included; what
    remains uncertain is correlated between joints.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    first, second = (joint.name for joint in arm.moving[:2])
    streams = (
        (f"joints.{first}.encoder.zero", Normal()),
        (f"joints.{second}.gearbox.stiffness", Normal()),
        (f"joints.{second}.gearbox.amount", Normal()),
        (f"joints.{first}.gearbox.transmission error 1", Cosine()),
        (f"joints.{first}.gearbox.transmission error 1", Sine()),
    )
    factor = 0.2 * np.random.default_rng(1).normal(size=(5, 5))
    mean, remaining = np.array([0.7, -1.1, 0.4, 0.9, -0.3]), factor @ factor.T
    q = random_poses(arm, 20)
    found = lostmotion.controller(
        arm, calibration=lostmotion.Calibration(streams, mean, remaining)
    ).predict(q)

    matrix = screws(state_of(arm, q))
    names = [stream for stream, _ in streams]
    laws = dict(enumerate(law for _, law in streams))
    known, uncertain, used = {}, {}, set()
    for column, info in enumerate(matrix.merged.infos):
        rows = [
            k
            for k, name in enumerate(names)
            if info.robot is not None and info.robot.name == name and info.robot.law == laws[k]
        ]
        rest = tuple(draw for draw in info.draws if draw[0][0] != "robot") if rows else info.draws
        shift, factor_on_known = matrix.merged.tool[:, :, column], mean[rows[0]] if rows else 1.0
        known[rest] = known.get(rest, 0.0) + factor_on_known * shift
        if rows:
            used |= set(rows)
            uncertain.setdefault(rest, {})[rows[0]] = shift[:, 3:]
    assert used == set(range(5))
    expected = sum(np.einsum("pi,pj->pij", v[:, 3:], v[:, 3:]) for rest, v in known.items() if rest)
    for columns in uncertain.values():
        for a, one in columns.items():
            for b, other in columns.items():
                expected = expected + remaining[a, b] * np.einsum("pi,pj->pij", one, other)
    assert_near(found.screw, known[()])
    assert_near(found.covariance, expected)
    assert (found.mean_square != lostmotion.controller(arm).predict(q).mean_square).all()
