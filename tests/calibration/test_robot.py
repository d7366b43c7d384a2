"""One robot from measured differences, of which not every file states the sign."""

from __future__ import annotations

import numpy as np
import pytest

import lostmotion
from lostmotion.calibration.instruments import MeasuredVisits
from lostmotion.calibration.model import model_of
from lostmotion.calibration.robot import measured_in_base
from lostmotion.calibration.terms import Deviations
from lostmotion.error_model.poses import sample_poses
from lostmotion.io.measured.calibration_visits import CalibrationVisits
from lostmotion.mechanism.state import state_of
from lostmotion.spatial import exp
from tests.calibration.ur5_grid import ARM

POSES = 24


def differences(turn: float):
    """Return an arm, joint values, and attained less nominal points of a drawn robot in a frame
    that is turned about z, rad.
    """
    arm = lostmotion.read(ARM)
    q = sample_poses(arm, 64, "sobol", 1).q[:POSES]
    model = model_of(arm, q)
    points = model.frames(np.random.default_rng(2).normal(size=len(model.streams)))[:, :3, 3]
    turned = points @ exp(np.array([0, 0, turn, 0, 0, 0]))[:3, :3].T
    return arm, q, turned - state_of(arm, q).frames[-1, :, :3, 3]


@pytest.mark.parametrize("sign", [1, -1])
def test_a_turned_base_decides_the_sign_of_differences(sign):
    """By 50 mrad, since a rotation by the reverse angle displaces points otherwise."""
    arm, q, beside = differences(0.05)
    seen = measured_in_base(arm, MeasuredVisits(q, difference=sign * beside), Deviations())
    assert (seen.sign, seen.favoured) == (sign, sign)


def test_small_differences_of_either_sign_fit_as_well():
    """Without a base that is far off the measurement does not decide their sign, and the warning
    states so.
    """
    arm, q, beside = differences(0.0)
    visits = CalibrationVisits(q, difference=beside, lines=tuple(range(POSES)))
    found = lostmotion.calibrate(arm, visits, terms="geometry")
    assert any("the reverse fits about as well" in text for text in found.warnings)


def test_a_stated_sign_is_used_and_compared_with_the_measurement():
    """It is not estimated, and a warning states where the reverse fits much better."""
    arm, q, beside = differences(0.05)
    for sign in (1, -1):
        visits = CalibrationVisits(
            q, difference=sign * beside, lines=tuple(range(POSES)), signed=True
        )
        assert measured_in_base(arm, visits, Deviations()).sign == 1
        found = lostmotion.calibrate(arm, visits, terms="geometry")
        against = [text for text in found.warnings if "sign" in text]
        assert against == [] if sign == 1 else "the reverse of the stated sign" in against[0]
