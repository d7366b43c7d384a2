"""How poses are drawn over the joint ranges."""

import numpy as np
import pytest
from scipy import stats

from lostmotion import Arm, InputError
from lostmotion.error_model.pose_selection import among
from lostmotion.error_model.poses import sample_poses


def slides(count: int) -> Arm:
    """Return an arm of slides, each from 0 to 1 m."""
    return Arm.model_validate({"name": "slides", "joints": [{"type": "prismatic", "name": f"J{k}", "limits": ("0 m", "1 m")} for k in range(count)]})


def test_a_grid_has_equal_steps_and_both_ends():
    """Ten poses of two joints are four steps in each, every pair of them once; a grid of a single pose is the middle."""
    found = sample_poses(slides(2), 10, "grid")
    steps = {0.0, 1 / 3, 2 / 3, 1.0}
    assert {tuple(np.round(row, 12)) for row in found.q} == {tuple(np.round((a, b), 12)) for a in steps for b in steps}
    assert len(found) == 16
    np.testing.assert_array_equal(sample_poses(slides(2), 1, "grid").q, [[0.5, 0.5]])


def test_a_grid_over_many_joints_would_be_too_large():
    """Two steps in each of 24 joints are 17 million poses: refused, though only five were asked for."""
    with pytest.raises(InputError, match=r"2 steps in each of 24 joints"):
        sample_poses(slides(24), 5, "grid")


@pytest.mark.parametrize("count", [-5, 0, 10_000_001])
@pytest.mark.parametrize("law", ["sobol", "uniform", "normal", "grid"])
def test_no_poses_and_more_than_ten_million_are_refused(law, count):
    """A study visits at least one pose; one alone is enough to ask for."""
    with pytest.raises(InputError, match="10000000"):
        sample_poses(slides(1), count, law)
    assert len(sample_poses(slides(1), 1, law)) == (1 if law == "grid" else 8)


def test_a_sobol_set_covers_a_joint_evenly_and_uniform_poses_are_independent():
    """Of 128 equal stretches of a joint a Sobol set visits each once; 128 independent poses miss about 37 % of them, which is 1/e."""
    visited = {
        law: [len(set((each * 128).astype(int))) for each in sample_poses(slides(1), 1024, law).q.reshape(8, 128)] for law in ("sobol", "uniform")
    }
    assert visited["sobol"] == [128] * 8
    assert np.mean(visited["uniform"]) == pytest.approx(128 * (1 - 1 / np.e), abs=3)


def test_normal_poses_lie_about_mid_range_and_end_at_the_limits():
    """Joint values of the paper's law: normal about mid-range with a sixth of the range as standard deviation, cut at the limits."""
    q = sample_poses(slides(1), 4000, "normal").q[:, 0]
    assert stats.kstest(q, stats.truncnorm(-3, 3, 0.5, 1 / 6).cdf).statistic < 0.03  # 0.1 % of independent samples exceed it
    assert 0 <= q.min() < q.max() <= 1


def test_a_zone_that_two_or_three_poses_reach_has_as_many_sets():
    """Where fewer poses of a sequence reach a zone than there are sets, each of them is a set of its own, and none is dropped."""
    poses = sample_poses(slides(3), 64)
    for count in (2, 3, 8):
        mask = np.arange(64) % 7 == 0
        mask[np.flatnonzero(mask)[count:]] = False
        found = among(poses, poses.q, mask).poses
        np.testing.assert_array_equal(found.q, poses.q[mask])
        assert found.replicates == count
