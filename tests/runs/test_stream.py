"""Poses of a long row, a stretch at a time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model.poses import sample_poses
from lostmotion.runs.stream import poses_between, rounded

ARM = lostmotion.read(Path(__file__).parents[2] / "examples" / "z-arm.toml")


@pytest.mark.parametrize("law", ["sobol", "uniform", "normal", "grid"])
@pytest.mark.parametrize("count", [1, 8, 1000])
def test_a_stretch_is_cut_from_the_whole_row(law, count):
    """Whatever the law, a stretch of poses has the bits that the whole row has there."""
    whole = sample_poses(ARM, count, law, seed=3)
    poses, sets = rounded(ARM, count, law)
    assert (poses, sets) == (len(whole), whole.replicates)
    each = poses // sets
    for of_set in range(sets):
        for first, last in ((0, each), (each // 3, each // 2), (each - 1, each)):
            found = poses_between(ARM, law, poses, 3, of_set * each + first, of_set * each + last)
            np.testing.assert_array_equal(
                found, whole.q[of_set * each + first : of_set * each + last]
            )


def test_far_ahead_costs_no_more_than_near():
    """Pose number four hundred million is within the limits and has a name of its own, without
    those before it.
    """
    poses, _ = rounded(ARM, 2**29, "uniform")
    far = poses_between(ARM, "uniform", poses, 1, 400_000_000, 400_000_003)
    assert far.shape == (3, 5)
    assert (far >= ARM.limits[:, 0]).all()
    assert (far <= ARM.limits[:, 1]).all()
    assert len(np.unique(far)) == far.size


def test_too_many_are_refused():
    """More poses than the sequences hold are refused, with how many they do."""
    with pytest.raises(lostmotion.InputError, match="8589934592"):
        rounded(ARM, 2**34, "sobol")
