"""Joint samples of all poses against the draws of single samples, term by term."""

from __future__ import annotations

import numpy as np
import pytest

from lostmotion import Arm
from lostmotion.error_model.arrival import last_motion
from lostmotion.error_model.pose_matrix import screws
from lostmotion.mechanism.calibration import Calibration, known_streams
from lostmotion.mechanism.state import state_of
from lostmotion.propagation import exact
from lostmotion.propagation.tool_errors import tool_errors
from tests.arms import JOINT, arm_of

VALIDATES = (
    (
        "errors of the same robots at all poses",
        (
            "the sum of all terms times their own draws, sample by sample; calibrated arms, and "
            "plays that a load closes in some robots"
        ),
        "1e-9",
        "propagation/tool_errors.py",
    ),
)


def rubbing():
    """Return an arm whose friction differs from robot to robot, near its own loads."""
    return arm_of(3, gearbox={**JOINT["gearbox"], "friction_torque": "30 N m ± 90 %"})


def calibrated():
    """Return an arm of which some draws are known, with correlated estimates."""
    arm = arm_of(3)
    streams = tuple(known_streams(arm.terms))[:4]
    root = np.random.default_rng(1).standard_normal((4, 4)) * 0.3
    return arm.calibrated(Calibration(streams, np.full(4, 0.4), root @ root.T))


@pytest.mark.parametrize("of", [lambda: arm_of(3), rubbing, calibrated])
@pytest.mark.parametrize("sides", ["drawn", "known", "mixed"])
def test_joint_samples_are_those_of_single_draws(of, sides):
    """Every error is the sum over columns of the screw per unit draw times the draws of the robot
    and of the visit.
    """
    arm = of()
    assert isinstance(arm, Arm)
    q = np.random.default_rng(3).uniform(-0.9, 0.9, (5, 3))
    approach = {"drawn": 0.0, "known": 1.0, "mixed": np.sign(np.round(q, 1))}[sides]
    matrix = screws(state_of(arm, q), approach=approach)
    if of is rubbing:
        assert matrix.closed_in_some.any()
    found = np.concatenate([e for _, e in tool_errors(matrix, 9, 70, 3)], axis=2)
    robot, visit = (
        each.ravel() for each in np.meshgrid(np.arange(70), np.arange(3), indexing="ij")
    )
    for pose in range(len(q)):
        draws = exact.draws_of(matrix, pose, 9, pose, robot, visit)
        expected = (matrix.tool[pose] @ draws).reshape(6, 70, 3)
        np.testing.assert_allclose(found[pose], expected, rtol=1e-9, atol=1e-15)


def test_poses_share_a_side_until_the_joint_moves():
    """Upright axes with nothing but play: where only the slide moves, the error stays the same in
    every run; drawn at every pose it does not.
    """
    turning = {"type": "revolute", "axis": "z", "limits": (-1.0, 1.0)}
    turning |= {"gearbox": {"backlash": "1 arcmin"}, "link": {"length": "300 mm", "rigid": True}}
    joints = [{**turning, "name": "A"}, {**turning, "name": "B"}]
    joints.append({"name": "Z", "type": "prismatic", "axis": "z", "limits": (0.0, 1.0)})
    arm = Arm.model_validate({"name": "play", "joints": joints})
    q = np.array([[0.1, 0.2, 0.3], [0.1, 0.2, 0.35], [0.1, 0.25, 0.35]])
    sides, since = last_motion(q)
    np.testing.assert_array_equal(sides, [[0, 0, 0], [0, 0, 1], [0, 1, 1]])
    matrix = screws(state_of(arm, q), approach=sides)
    shared, drawn = (
        np.concatenate([e for _, e in tool_errors(matrix, 4, 100, 2, each)], axis=2)
        for each in (since, None)
    )
    np.testing.assert_allclose(shared[0], shared[1], atol=1e-15)
    assert np.abs(drawn[0] - drawn[1]).max() > 1e-5
    assert len(np.unique(np.round(shared[2, 2], 9))) == 2  # the side of A alone
