"""At each visit all direction-dependent errors of a joint share the sign of its last motion."""

from __future__ import annotations

import numpy as np
import pytest

from lostmotion.error_model.pose_matrix import screws
from lostmotion.error_model.poses import Poses, sample_poses
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.exact import draws_of
from lostmotion.propagation.montecarlo.montecarlo import run
from lostmotion.sizing.error_cache import BIAS, ErrorCache
from tests.error_model.arms import ARMS

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "last motion shared by backlash and hysteresis",
        (
            "backlash and hysteresis of 2' at 1 m: mean 0.582 mm from above, below and either "
            "side; the mean square of random arrivals is that "
            "of the 50/50 mixture, and every sample one from above or from below, "
            "four examples and seven random arms"
        ),
        "1e-9; 1e-12",
    ),
)

ARCMIN = np.pi / 10_800


def mean_square(matrix):
    """Return the mean-square position error (pose,), m^2; draws are uncorrelated with mean square
    one.
    """
    columns = matrix.merged
    drawn = [k for k, info in enumerate(columns.infos) if info.draws]
    return (columns.bias[:, 3:] ** 2).sum(axis=1) + columns.squares[drawn].sum(axis=0)


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
def test_the_mean_square_of_a_random_last_motion_is_the_mean_of_both_directions(arm):
    """The mean square for a random last motion of one joint is the mean of those of its two
    directions, for any motion of the other joints.
    """
    q = sample_poses(arm, 8).q
    state = state_of(arm, q)
    sides = np.tile([1.0, -1.0, 0.0, 1.0], q.size)[: q.size].reshape(q.shape)
    for joint in range(q.shape[1]):
        up, down, either = (sides.copy() for _ in range(3))
        up[:, joint], down[:, joint], either[:, joint] = 1.0, -1.0, 0.0
        each = [mean_square(screws(state, approach=approach)) for approach in (up, down)]
        np.testing.assert_allclose(
            mean_square(screws(state, approach=either)),
            np.mean(each, axis=0),
            rtol=1e-12,
        )


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
def test_a_visit_with_random_last_motion_is_a_visit_from_either_direction(arm):
    """Each visit with a random last motion has the error of a visit from above or from below, with
    equal probability.

    So mean error, r.m.s. error and AP of each robot are those of the 50/50 mixture, within the
    sampling error of 64 robots and 32 visits.
    """
    q = sample_poses(arm, 8).q[:1]
    state = state_of(arm, q)
    robot, visit = (
        axis.ravel() for axis in np.meshgrid(np.arange(64), np.arange(32), indexing="ij")
    )
    for joint in {of.joint for of in arm.terms if of.term.sided}:
        sides = np.ones(q.shape)
        errors = {}
        for side in (0.0, 1.0, -1.0):
            sides[:, joint] = side
            matrix = screws(state, approach=sides)
            errors[side] = (matrix.tool[0, 3:] @ draws_of(matrix, 0, 5, 0, robot, visit)).T.reshape(
                64, 32, 3
            )
        either, up, down = errors.values()
        close = 1e-10 * np.abs(either).max()
        as_up, as_down = (np.abs(either - one).max(axis=2) <= close for one in (up, down))
        assert (as_up | as_down).all()
        apart = np.abs(up - down).max(axis=2) > 10 * close
        assert not apart.any() or as_up[apart].mean() == pytest.approx(
            0.5, abs=2.5 / np.sqrt(apart.sum())
        )
        sizes = [np.linalg.norm(one, axis=2) for one in (either, up, down)]
        noise = 4 * np.sqrt(((sizes[1] - sizes[2]) ** 2).mean()) / 2 / np.sqrt(len(robot)) + close
        assert sizes[0].mean() == pytest.approx((sizes[1].mean() + sizes[2].mean()) / 2, abs=noise)
        assert np.sqrt((sizes[0] ** 2).mean()) == pytest.approx(
            np.sqrt((sizes[1] ** 2 + sizes[2] ** 2).mean() / 2), abs=noise
        )
        accuracy, mixed = (
            np.linalg.norm(one.mean(axis=1), axis=1) for one in (either, (up + down) / 2)
        )
        assert accuracy == pytest.approx(
            mixed, abs=4 * np.abs(up - down).max() / np.sqrt(32) + close
        )
        assert accuracy.mean() == pytest.approx(
            mixed.mean(), abs=np.abs(up - down).max() / np.sqrt(32) + close
        )


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
def test_parts_of_a_joint_that_share_its_last_motion_add_before_they_are_squared(arm):
    """The error cache for sizing has the mean squares of the pose matrix, also where several parts
    of a joint share its last motion.
    """
    q = sample_poses(arm, 8).q
    sums = ErrorCache(arm, q).of(arm)
    np.testing.assert_allclose(
        (sums[BIAS] ** 2).sum(axis=0) + sums[3:6].sum(axis=0),
        mean_square(screws(state_of(arm, q))),
        rtol=1e-11,
        atol=1e-30,
    )


def unloaded(**gearbox):
    """Return an arm with one vertical joint, whose play no load closes, and a link of 1 m."""
    joint = {
        "name": "A",
        "type": "revolute",
        "axis": "z",
        "limits": (-1, 1),
        "gearbox": gearbox,
        "link": {"length": 1.0},
    }
    return Arm.model_validate({"name": "unloaded", "joints": [joint]})


def test_backlash_and_hysteresis_of_an_unloaded_joint_add_up_from_either_side():
    """An unloaded joint with 2 arcmin of backlash and of hysteresis ends every visit 2 arcmin off
    the middle: 0.582 mm at 1 m.
    """
    arm = unloaded(backlash=2 * ARCMIN, hysteresis=2 * ARCMIN)
    poses = Poses(np.zeros((1, 1)), "given")
    for approach in (0.0, 1.0, -1.0):
        found = run(arm, poses, robots=200, visits=20, seed=3, approach=approach)
        assert found.per_pose[0, 0] == pytest.approx(2 * ARCMIN, rel=1e-9), approach


def test_a_random_approach_has_the_mean_error_of_either_direction():
    """The Monte Carlo mean error of an unloaded joint with scattered backlash is equal for upward,
    downward and random last motions.
    """
    arm = unloaded(backlash="2 arcmin ± 1 arcmin", hysteresis=2 * ARCMIN, stiffness=1e5)
    poses = Poses(np.zeros((1, 1)), "given")
    either, up, down = (
        run(arm, poses, robots=4000, visits=16, seed=5, approach=approach)
        for approach in (0.0, 1.0, -1.0)
    )
    assert up.per_pose[0, 0] == pytest.approx(down.per_pose[0, 0], rel=1e-9)
    assert either.per_pose[0, 0] == pytest.approx(up.per_pose[0, 0], rel=1e-9)
