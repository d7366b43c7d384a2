"""Paired differences and the shares of parts in them, on random arms and in closed form."""

import math

import numpy as np
import pytest

from lostmotion.error_model.budget import budget_changes, label_of, tally
from lostmotion.error_model.differences import (
    ZERO,
    mean_difference,
    robots_quantile_difference,
    root_mean_square_difference,
    sets_difference,
    share_of_difference,
)
from lostmotion.mechanism.tool import Payload
from tests.error_model.arms import SEEDS
from tests.parts.random_arms import random_arm, random_poses

VALIDATES = (
    (
        "shares of parts in the change of the mean square",
        (
            "difference of two exact budgets, seven random arms with another payload; unchanged "
            "parts have none"
        ),
        "1e-12",
        "error_model/budget.py",
    ),
    (
        "intervals of paired differences",
        "closed forms of two and eight sets; 400 pairs of samples of a correlated pair",
        "1e-12; 91 to 99 % of the intervals cover",
        "error_model/differences.py",
    ),
)


@pytest.mark.parametrize("seed", SEEDS)
def test_shares_add_to_the_change_of_the_mean_square(seed):
    """An arm with 1 kg more: by part and by kind shares add to the difference of two budgets;
    exchanged arms change their sign; a copy has none.
    """
    arm = random_arm(seed)
    heavier = arm.with_payload(
        Payload(mass=arm.payload.mass + 1.0, centre_of_mass=arm.payload.centre_of_mass)
    )
    q = random_poses(arm, 5)
    labels = (label_of("part"), label_of("cause"))
    squares = [found.total / found.poses for found in (tally(each, q) for each in (arm, heavier))]
    pairs = (arm, heavier), (heavier, arm), (arm, arm)
    for forth, back, none in zip(
        *(budget_changes(one, other, q, labels)[0] for one, other in pairs), strict=True
    ):
        assert sum(forth.values()) == pytest.approx(
            squares[1] - squares[0], rel=1e-10, abs=1e-13 * squares[0]
        )
        assert {name: -value for name, value in back.items()} == pytest.approx(
            forth, rel=1e-9, abs=1e-13 * squares[0]
        )
        assert not any(none.values())


def test_the_difference_of_two_sets_is_the_closed_form():
    """Student's interval of one degree of freedom: 12.706 times half the distance of the two
    differences.
    """
    before, after = np.array([1.0, 2.0]), np.array([1.5, 3.5])
    found = sets_difference(before, after)
    assert found.value == 1.0
    assert found.high - found.value == pytest.approx(12.706204736174694 * 0.5, rel=1e-9)
    assert math.isnan(sets_difference(before[:1], after[:1]).low)


def test_a_root_mean_square_that_is_scaled_changes_by_its_scale():
    """Three times the errors, so nine times the mean squares: the change is twice the root, and so
    is its interval by the delta method.
    """
    squares = np.random.default_rng(1).uniform(1.0, 2.0, 8)
    found = root_mean_square_difference(squares, 9 * squares)
    root = math.sqrt(squares.mean())
    assert found.value == pytest.approx(2 * root, rel=1e-12)
    spread = 2.3646242510102993 * np.std(squares, ddof=1) / math.sqrt(8) / (2 * root)
    assert found.high - found.value == pytest.approx(2 * spread, rel=1e-9)
    share = share_of_difference(8 * squares, squares, 9 * squares)
    assert [share.value, share.low, share.high] == pytest.approx(
        [found.value, found.low, found.high], rel=1e-12
    )
    assert share_of_difference(np.zeros(8), np.zeros(8), np.zeros(8)) == ZERO


def test_intervals_of_a_correlated_pair_cover_its_difference():
    """Robots that share most of their error: mean and 95th percentile of the difference are covered
    in 91 to 99 % of 400 samples.

    The common part has a standard deviation of 1, the arms' own parts 0.1 and 0.2, sets of poses
    0.1: each value is a robot's mean over a set.
    """
    rng = np.random.default_rng(3)
    true_mean, true_quantile = 0.5, 0.5 + 1.6448536269514722 * (math.sqrt(1.04) - math.sqrt(1.01))
    hits = np.zeros(2)
    for _ in range(400):
        common, own, other = (rng.standard_normal(160) for _ in range(3))
        of_sets = 0.1 * rng.standard_normal((8, 1))
        before = 10 + common + 0.1 * own + of_sets
        after = 10.5 + common + 0.2 * other + of_sets + 0.05 * rng.standard_normal((8, 1))
        for k, (found, true) in enumerate(
            (
                (mean_difference(before, after), true_mean),
                (robots_quantile_difference(before, after), true_quantile),
            ),
        ):
            hits[k] += found.low <= true <= found.high
    assert (hits / 400 >= 0.91).all(), hits
    assert (hits / 400 <= 0.99).all(), hits
