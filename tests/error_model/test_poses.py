"""How poses are drawn over the joint ranges."""

import numpy as np
import pytest

from lostmotion import Arm, InputError, sample_poses


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
