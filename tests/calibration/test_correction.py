"""Corrected commands of a calibrated robot."""

from __future__ import annotations

import numpy as np

from lostmotion.calibration.correction import corrected, expected_tool
from lostmotion.calibration.terms import Deviations, added_terms
from lostmotion.io import read
from lostmotion.laws.distributions import Normal
from lostmotion.mechanism.calibration import Calibration
from lostmotion.mechanism.state import state_of
from tests.calibration.ur5_grid import ARM, grid_model


def test_a_corrected_robot_reaches_the_nominal_poses():
    """A robot with an axis tilted by 12 mrad and a base shifted by 2 mm misses by millimetres, and
    with corrected commands by less than a nanometre.
    """
    arm = read(ARM)
    added = added_terms(arm, Deviations())
    names = ("joints.J4.seat.tilt 2", "base frame.shift x")
    kept = tuple(of for of in added if of.name in names)
    streams = tuple((of.name, Normal(np.inf)) for of in kept)
    calibration = Calibration(streams, np.array([0.2, 24.0]), np.zeros((2, 2)), kept)
    robot = arm.calibrated(calibration)
    q = grid_model()[0].matrix.state.q[::100]
    nominal = state_of(arm, q).frames[-1]
    before = np.linalg.norm(expected_tool(robot, q)[:, :3, 3] - nominal[:, :3, 3], axis=1)
    assert before.min() > 1e-3
    command, left = corrected(robot, q)
    assert left.max() < 1e-9
    np.testing.assert_allclose(expected_tool(robot, command), nominal, atol=1e-9)
