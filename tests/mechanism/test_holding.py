"""The poses at which the largest static load of each joint is computed."""

import numpy as np
import pytest

from lostmotion.mechanism.holding import spread_evenly


def test_the_poses_cover_the_range_of_a_joint_evenly():
    """Of 256 positions of one joint no gap is larger than 1.3 times the mean gap, and none is
    smaller than half of it.
    """
    positions = np.sort(spread_evenly(np.array([[-1.0, 3.0]]))[:, 0])
    assert -1 <= positions[0] < positions[-1] <= 3
    gaps = np.diff(positions) / (4 / 256)
    assert gaps.max() < 1.3
    assert gaps.min() > 0.45


@pytest.mark.parametrize(
    ("joints", "ratio"), [(2, 1.32471795724475), (3, 1.22074408460576), (6, 1.11277568427871)]
)
def test_several_joints_advance_by_powers_of_the_generalised_golden_ratio(
    joints: int, ratio: float
):
    """From pose to pose joint k advances by 1/ratio^k of its range, modulo the range; the ratio is
    the root of x^(joints + 1) = x + 1.
    """
    steps = np.diff(spread_evenly(np.tile([0.0, 1.0], (joints, 1))), axis=0) % 1
    np.testing.assert_allclose(
        steps, np.tile(ratio ** -np.arange(1.0, joints + 1), (255, 1)), rtol=1e-9
    )
