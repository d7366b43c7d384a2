"""Intervals where few robots or few poses make the figure: their coverage, and their closed
forms.
"""

import math
import tomllib

import numpy as np
import pytest
from scipy.stats import beta, binom, binomtest

import lostmotion
from lostmotion.error_model.budget import budget
from lostmotion.error_model.intervals import pooled_quantile, quantile
from lostmotion.error_model.poses import sample_poses
from lostmotion.error_model.remedies import remaining_rms
from lostmotion.error_model.robot_intervals import (
    mean_spread,
    pooled_mean,
    pooled_robots_quantile,
    root_mean_square,
    shrunk_means,
    two_way,
)
from lostmotion.error_model.small_counts import (
    counting_floor,
    freedom_of_variance,
    order_statistics,
)
from lostmotion.propagation.montecarlo.montecarlo import run

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        (
            "intervals where a play opens in 0.5 % of poses, and of a 99th percentile that the "
            "worst of 200 robots make"
        ),
        "150 studies of 2 048 poses x 200 robots; four of 8 192 poses x 1 000 robots",
        (
            "at least 90 % cover mean RP, RP's 95th percentile of robots, and the 95th and 99th "
            "percentiles of the error; by the variance alone 83 %"
        ),
        "error_model/intervals.py",
    ),
    (
        "interval of the r.m.s. error between visits where a play opens in 0.5 % of poses",
        "closed form; 100 studies of 2 048 poses",
        "at least 95 cover, by the variance alone 84",
        "error_model/robot_intervals.py",
    ),
)

# The play opens where the load, 8 kg at 0.8 m and 2 kg at 0.4 m, is below the friction: |cos A| <
# 0.0071, so in 0.47 % of -80° to 91°.
RARE = """
name = "rare"
[payload]
mass = "8 kg"
[[joints]]
name = "A"
type = "revolute"
axis = "-y"
limits = ["-80 deg", "91 deg"]
gearbox = { ratio = 100, backlash = "4 arcmin", friction_torque = "0.5 N m ± 0 %" }
encoder = { resolution = "10 arcmin", zero = "0.5 arcmin" }
link = { length = "800 mm ± 100 µm", direction = "x", mass = "2 kg" }
"""
SETS = 8


def test_the_floor_by_counting_is_the_limit_of_a_proportion_without_an_event():
    """Eight sets with the same number of open plays: the mean is not known better than to 0.37 of a
    pose in each set (Clopper and Pearson).
    """
    values = np.zeros(2048)
    values[:8] = 660e-6
    upper = binomtest(0, SETS).proportion_ci().high
    assert counting_floor(np.random.default_rng(1).permutation(values), SETS) == pytest.approx(
        SETS * upper * 660e-6 / 2048, rel=1e-9
    )
    assert counting_floor(values, 1) == 0


def test_the_floor_by_counting_vanishes_where_errors_vary_smoothly():
    """A sine over 2 048 poses has a floor below a ten thousandth of its mean, and a mean over
    robots keeps the interval of its variance.
    """
    smooth = 1 + 0.5 * np.sin(np.linspace(0, 2 * np.pi, 2048))
    assert counting_floor(smooth, SETS) < 1e-4
    means = np.random.default_rng(2).normal(1, 0.1, (SETS, 50))
    assert mean_spread(means, smooth).half == pytest.approx(two_way(means).half, rel=1e-3)


def test_the_floor_replaces_the_part_of_the_poses_alone():
    """Where equal sets show no variance, the half-width is the root of the squares of that of the
    robots and of the floor.
    """
    robots, values = (
        np.tile(np.random.default_rng(3).normal(1, 0.1, 1000), (SETS, 1)),
        np.where(np.arange(2048) < 8, 30.0, 1.0),
    )
    alone, floor = pooled_mean(robots), counting_floor(values, SETS)
    assert pooled_mean(robots, values).half == pytest.approx(
        math.hypot(alone.half, floor), rel=1e-9
    )


@pytest.mark.parametrize(("level", "count"), [(0.5, 25), (0.95, 300), (0.99, 2000)])
def test_ends_of_a_quantile_are_order_statistics(level, count):
    """The share of true values beyond each end, by the beta law of an order statistic, is 2.5 % but
    for the step between two ranks.
    """
    for end, tail in zip(order_statistics(level, count, 0.95), (0.975, 0.025), strict=True):
        rank = end * (count + 1)
        steps = [
            beta.cdf(level, math.floor(rank) + k, count + 1 - math.floor(rank) - k) for k in (0, 1)
        ]
        assert min(steps) - 1e-9 <= tail <= max(steps) + 1e-9


def test_two_hundred_samples_may_all_lie_below_the_99th_percentile():
    """They do in 13 % of cases: the upper end is the largest sample; of 400 samples, 1.8 %, it is a
    rank below it.
    """
    assert binom.pmf(200, 200, 0.99) == pytest.approx(0.134, abs=1e-3)
    assert order_statistics(0.99, 200, 0.95)[1] == 1
    assert order_statistics(0.01, 200, 0.95)[0] == 0
    assert 0.99 < order_statistics(0.99, 400, 0.95)[1] < 1


def test_a_variance_that_few_members_make_has_few_degrees_of_freedom():
    """Normal members keep n - 1 but for their sampling; one member in 32 with everything leaves
    fewer than three.
    """
    alone = np.zeros(32)
    alone[0] = 1
    assert 2 < freedom_of_variance(alone) < 3
    assert freedom_of_variance(np.arange(32.0)) == pytest.approx(31)
    assert freedom_of_variance(np.ones(8)) == 7


def test_the_root_mean_square_between_visits_covers_its_closed_form():
    """The play of ±2' at 800 mm opens in the share of poses whose torque is below the friction; an
    encoder of 10' behind 1:100 adds its rounding everywhere. Remedies have the same interval.
    """
    arm = lostmotion.Arm.model_validate(tomllib.loads(RARE))
    share = 2 * math.asin(0.5 / (9.80665 * (8 * 0.8 + 2 * 0.4))) / math.radians(171)
    arcmin = math.radians(1 / 60)
    truth = 0.8 * arcmin * math.sqrt(share * 2**2 + (10 / 100) ** 2 / 12)
    covered = by_variance = 0
    for seed in range(100):
        poses = sample_poses(arm, 2048, seed=seed)
        found = budget(arm, poses.q, replicates=poses.replicates)
        interval, alone = found.rms_interval(2), root_mean_square(found.squares.visited[:, 2])
        covered += interval.low <= truth <= interval.high
        by_variance += alone.low <= truth <= alone.high
    assert covered >= 95, covered
    assert by_variance < 88, by_variance
    assert remaining_rms(arm, poses)["as manufactured"].half == found.rms_interval().half


@pytest.mark.slow
def test_intervals_cover_where_few_robots_or_poses_make_the_figure():
    """Of 150 studies so many cover that a coverage of 95 % is not refuted (binomial test, 1 %), for
    each of four figures.

    By the variance between sets and groups alone 83 % cover mean RP and the 99th percentile.
    """
    arm = lostmotion.Arm.model_validate(tomllib.loads(RARE))

    def sampled(poses, robots, seed):
        return run(arm, sample_poses(arm, poses, seed=seed), robots, 4, seed, compared=0)

    def figures(found):
        means = found.robot_means[:, :, 2]
        of_poses = found.of_poses(2)
        quantiles = [
            pooled_quantile(found.group_hist, found.replicate_hist, level) for level in (0.95, 0.99)
        ]
        return [
            pooled_mean(means, of_poses),
            pooled_robots_quantile(means, of_poses=of_poses),
            *quantiles,
        ], two_way(means).half

    large = [sampled(8192, 1000, 777 + k) for k in range(4)]
    counts = sum(each.replicate_hist.sum(axis=0) for each in large)
    robots = np.concatenate([shrunk_means(each.robot_means[:, :, 2]) for each in large])
    truth = [
        robots.mean(),
        np.quantile(robots, 0.95),
        quantile(counts, 0.95),
        quantile(counts, 0.99),
    ]
    covered, by_variance = np.zeros(4), 0
    for seed in range(5000, 5150):
        found, half = figures(sampled(2048, 200, seed))
        covered += [each.low <= true <= each.high for each, true in zip(found, truth, strict=True)]
        by_variance += abs(found[0].value - truth[0]) <= half
    least = binom.ppf(0.01, 150, 0.95)
    assert (covered >= least).all(), covered
    assert by_variance < 130
