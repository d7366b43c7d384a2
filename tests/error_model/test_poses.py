"""Pose sampling over the joint ranges."""

import numpy as np
import pytest
from scipy import stats

from lostmotion import Arm, InputError
from lostmotion.error_model.pose_selection import among
from lostmotion.error_model.poses import sample_poses


def slides(count: int) -> Arm:
    """Return an arm of slides with a range from 0 to 1 m each."""
    return Arm.model_validate(
        {
            "name": "slides",
            "joints": [
                {"type": "prismatic", "name": f"J{k}", "limits": ("0 m", "1 m")}
                for k in range(count)
            ],
        }
    )


def test_a_grid_has_equal_steps_and_both_ends():
    """A grid of ten poses of two joints has four equal steps per joint including both ends, and a
    grid of one pose is the middle.
    """
    found = sample_poses(slides(2), 10, "grid")
    steps = {0.0, 1 / 3, 2 / 3, 1.0}
    assert {tuple(np.round(row, 12)) for row in found.q} == {
        tuple(np.round((a, b), 12)) for a in steps for b in steps
    }
    assert len(found) == 16
    np.testing.assert_array_equal(sample_poses(slides(2), 1, "grid").q, [[0.5, 0.5]])


def test_a_grid_over_many_joints_is_rejected():
    """A grid over 24 joints is rejected, since two steps per joint are 17 million poses."""
    with pytest.raises(InputError, match=r"2 steps in each of 24 joints"):
        sample_poses(slides(24), 5, "grid")


@pytest.mark.parametrize("count", [-5, 0, 10_000_001])
@pytest.mark.parametrize("law", ["sobol", "uniform", "normal", "grid"])
def test_zero_poses_and_more_than_ten_million_are_rejected(law, count):
    """A set has between one and ten million poses."""
    with pytest.raises(InputError, match="10000000"):
        sample_poses(slides(1), count, law)
    assert len(sample_poses(slides(1), 1, law)) == (1 if law == "grid" else 8)


def test_a_sobol_set_covers_a_joint_evenly_and_uniform_poses_are_independent():
    """A Sobol set visits each of 128 equal intervals of a joint once, and 128 independent poses
    miss 1/e, about 37 %, of them.
    """
    visited = {
        law: [
            len(set((each * 128).astype(int)))
            for each in sample_poses(slides(1), 1024, law).q.reshape(8, 128)
        ]
        for law in ("sobol", "uniform")
    }
    assert visited["sobol"] == [128] * 8
    assert np.mean(visited["uniform"]) == pytest.approx(128 * (1 - 1 / np.e), abs=3)


def test_normal_poses_are_truncated_at_the_limits():
    """Normal joint values have mid-range as mean and a sixth of the range as standard deviation,
    truncated at the limits.
    """
    q = sample_poses(slides(1), 4000, "normal").q[:, 0]
    # 0.1 % of independent samples exceed it
    assert stats.kstest(q, stats.truncnorm(-3, 3, 0.5, 1 / 6).cdf).statistic < 0.03
    assert 0 <= q.min() < q.max() <= 1


def test_a_zone_with_few_poses_has_one_set_per_pose():
    """A zone with fewer poses than sets has one set per pose and drops no pose."""
    poses = sample_poses(slides(3), 64)
    for count in (2, 3, 8):
        mask = np.arange(64) % 7 == 0
        mask[np.flatnonzero(mask)[count:]] = False
        found = among(poses, poses.q, mask).poses
        np.testing.assert_array_equal(found.q, poses.q[mask])
        assert found.replicates == count
