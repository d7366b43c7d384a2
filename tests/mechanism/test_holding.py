"""The poses at which an arm's largest holding torques are sought."""

import numpy as np
import pytest

from lostmotion.mechanism.holding import spread_evenly


def test_the_poses_tried_leave_no_stretch_of_a_joint_out():
    """256 positions of one joint, multiples of the golden ratio: no gap is more than 1.3 times the mean gap, none less than half of it."""
    positions = np.sort(spread_evenly(np.array([[-1.0, 3.0]]))[:, 0])
    assert -1 <= positions[0] < positions[-1] <= 3
    gaps = np.diff(positions) / (4 / 256)
    assert gaps.max() < 1.3
    assert gaps.min() > 0.45


@pytest.mark.parametrize(("joints", "ratio"), [(2, 1.32471795724475), (3, 1.22074408460576), (6, 1.11277568427871)])
def test_several_joints_move_on_by_powers_of_the_generalised_golden_ratio(joints: int, ratio: float):
    """From pose to pose joint k moves on by 1/ratio^k of its range, modulo the range; the ratio is the root of x^(joints + 1) = x + 1."""
    steps = np.diff(spread_evenly(np.tile([0.0, 1.0], (joints, 1))), axis=0) % 1
    np.testing.assert_allclose(steps, np.tile(ratio ** -np.arange(1.0, joints + 1), (255, 1)), rtol=1e-9)
