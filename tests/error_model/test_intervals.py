"""Coverage of confidence intervals, and their closed forms."""

import math
from statistics import NormalDist

import numpy as np
import pytest
from scipy.special import betainc
from scipy.stats import t

from lostmotion import sample_poses
from lostmotion.error_model import error_bins, intervals, robot_intervals
from lostmotion.error_model.error_bins import bin_edges
from lostmotion.error_model.intervals import (
    of_length,
    pooled_quantile,
    pseudo_values,
    quantile,
    standard_deviation,
)
from lostmotion.error_model.robot_intervals import (
    pooled_mean,
    pooled_robots_quantile,
    robots_quantile,
    root_mean_square,
    root_mean_square_of_samples,
)
from lostmotion.error_model.share_intervals import share_below, share_interval
from lostmotion.propagation.montecarlo.montecarlo import run
from tests.arms import arm_of

SETS = 8


@pytest.mark.parametrize("axis", [0, 1])
def test_where_only_robots_or_only_poses_differ_the_interval_is_students(axis):
    """Where robots alone or sets of poses alone differ, four values have Student's interval."""
    values = np.array([1.0, 1.3, 0.9, 1.6])
    found = robot_intervals.two_way(np.expand_dims(values, axis) + np.zeros((4, 4)))
    assert found.half == pytest.approx(3.182446 * values.std(ddof=1) / 2, rel=1e-6)
    assert (found.of_poses if axis else found.of_robots) == pytest.approx(
        values.var(ddof=1) / 4, rel=1e-12
    )
    assert (found.of_robots if axis else found.of_poses) == 0


@pytest.mark.parametrize(
    ("of_sets", "of_robots", "of_cells"),
    [(0.0, 1.0, 0.0), (1.0, 1.0, 1.0), (0.3, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.1, 0.3)],
)
def test_the_interval_of_a_pooled_mean_covers_for_any_source_of_scatter(
    of_sets, of_robots, of_cells
):
    """Of 1 000 synthetic studies 93 to 97 % have a 95 % interval that covers the true value,
    whether robots, sets or cells scatter.

    Where sets or cells alone scatter, coverage reaches 99 %, because a variance component estimated
    below zero counts as zero.
    """
    rng = np.random.default_rng(7)
    covered = 0
    for _ in range(1000):
        means = (
            rng.normal(0, of_robots, 60)
            + rng.normal(0, of_sets / 2, (SETS, 1))
            + rng.normal(0, of_cells, (SETS, 60))
        )
        found = pooled_mean(5 + means)
        covered += found.low <= 5 <= found.high
    assert 0.93 <= covered / 1000 <= (0.97 if of_robots > of_cells else 0.99)


@pytest.mark.parametrize("share", [0.02, 0.1, 0.5])
def test_truncating_an_interval_at_zero_does_not_lower_its_coverage(share):
    """The interval of a length ends at zero or above and covers the true mean as often as the
    interval without truncation.
    """
    rng = np.random.default_rng(11)
    below, covered, whole = 0, 0, 0
    for _ in range(500):
        means = np.where(rng.random((SETS, 40)) < share, rng.lognormal(0, 1, (SETS, 40)), 0.0) * (
            rng.random(40) < share
        )
        found, half = pooled_mean(means), robot_intervals.two_way(means).half
        truth = share**2 * math.exp(0.5)
        covered += found.low <= truth <= found.high
        whole += abs(means.mean() - truth) <= half
        below += means.mean() < half
        assert found.low >= 0
        assert found.high == pytest.approx(found.value + half)
        assert pooled_robots_quantile(means).low >= 0 or math.isnan(
            pooled_robots_quantile(means).low
        )
    assert covered == whole
    assert below > 0 or share == 0.5


def test_the_half_width_of_a_truncated_interval_is_its_upper_half():
    """Truncation of an interval at zero does not reduce its half-width."""
    assert of_length(1.0, -3.0, 5.0).low == 0.0
    assert of_length(1.0, -3.0, 5.0).half == 4.0
    assert of_length(6.0, 2.0, 10.0).half == 4.0
    assert math.isnan(of_length(1.0, math.nan, 2.0).low)


def test_the_ends_of_a_pooled_quantile_are_python_floats():
    """The value and both ends of a pooled quantile are Python floats, so that comparisons return a
    Python bool.
    """
    hist = np.zeros((4, error_bins.BINS), np.int64)
    hist[:, 4000] = 10
    found = pooled_quantile(hist, hist, 0.95)
    assert found.low < found.value < found.high
    assert {type(found.value), type(found.low), type(found.high)} == {float}
    assert type(found.high <= 1.0) is bool


def test_a_quantile_beyond_the_histogram_has_no_interval():
    """A quantile in the last bin, from 16 m on, is infinite and has no interval, also where the
    largest sample is known.
    """
    hist = np.zeros((4, error_bins.BINS), np.int64)
    hist[:, -1] = 10
    for largest in (math.inf, 633.0):
        found = pooled_quantile(hist, hist, 0.95, largest)
        assert found.value == math.inf
        assert math.isnan(found.low)
        assert math.isnan(found.high)


@pytest.mark.slow
def test_the_interval_of_a_pooled_quantile_or_share_covers():
    """Of 1 000 synthetic studies with lognormal errors 93 to 97 % have a 95 % interval that covers
    the true 50th or 95th percentile.

    So have those of the share of errors up to these lengths.
    """
    rng = np.random.default_rng(8)
    robots, groups, samples = 128, 32, 16
    spread = (0.1, 0.3, 0.4)  # of sets, of robots, of samples
    edges = bin_edges()
    scale = {0.5: 0.0, 0.95: 1.6448536269514722}
    covered, shares = dict.fromkeys(scale, 0), dict.fromkeys(scale, 0)
    for _ in range(1000):
        logs = (
            rng.normal(0, spread[0], (SETS, 1, 1))
            + rng.normal(0, spread[1], (robots, 1))
            + rng.normal(0, spread[2], (SETS, robots, samples))
        )
        bins = np.searchsorted(edges, 1e-3 * np.exp(logs), side="right") - 1
        whose = np.repeat(np.arange(robots) * groups // robots, samples)
        by_group = np.bincount(
            (whose * error_bins.BINS + bins.reshape(SETS, -1)).ravel(),
            minlength=groups * error_bins.BINS,
        ).reshape(groups, -1)
        by_set = np.array([np.bincount(each.ravel(), minlength=error_bins.BINS) for each in bins])
        for level, normal in scale.items():
            truth = 1e-3 * np.exp(normal * np.linalg.norm(spread))
            found = pooled_quantile(by_group, by_set, level)
            covered[level] += found.low <= truth <= found.high
            share = share_below(by_group, by_set, truth, robots)
            shares[level] += share.low <= level <= share.high
    assert all(0.93 <= count / 1000 <= 0.97 for count in (*covered.values(), *shares.values())), (
        covered,
        shares,
    )


@pytest.mark.slow
def test_a_nominal_90_percent_covers_86_to_94_in_500_studies(monkeypatch):
    """The 90 % intervals of 500 studies of a small arm cover the values of one large study in 86
    to 94 %, three standard deviations of the binomial law to either side.

    The figures are mean error, AP and RP, the 50th and 95th percentiles of the error, and the 95th
    percentiles over robots of mean error, AP and RP.
    """
    play = {"backlash": "0.5 arcmin ± 0.2 arcmin"}
    small = arm_of(
        2,
        gearbox=play,
        bearing=None,
        encoder={"noise": "0.5 arcmin", "zero": "0.3 arcmin"},
        mounting=None,
        link={"length": "400 mm ± 50 µm"},
    )

    def estimates(poses, robots, seed):
        found = run(small, sample_poses(small, poses, seed=seed), robots, 4, seed, compared=0)
        means = [pooled_mean(found.robot_means[:, :, k]) for k in range(3)]
        pooled = [
            pooled_quantile(found.group_hist, found.replicate_hist, level) for level in (0.5, 0.95)
        ]
        return [
            *means,
            *pooled,
            *(pooled_robots_quantile(found.robot_means[:, :, k]) for k in range(3)),
        ]

    truth = [each.value for each in estimates(1024, 4_000, 10**6)]
    for room in (intervals, robot_intervals):
        monkeypatch.setattr(room, "CONFIDENCE", 0.90)
    covered = np.zeros(len(truth))
    for seed in range(500):
        covered += [
            each.low <= true <= each.high
            for each, true in zip(estimates(64, 128, seed), truth, strict=True)
        ]
    assert (covered >= 430).all(), covered
    assert (covered <= 470).all(), covered


def test_the_interval_of_a_99th_percentile_ends_at_most_at_the_largest_sample():
    """The upper end of a quantile of few robots is known and at most the largest sample, and one
    robot has no interval.
    """
    rng = np.random.default_rng(9)
    hist = np.zeros((4, error_bins.BINS), np.int64)
    np.add.at(hist, (np.repeat(np.arange(4), 50), rng.integers(5000, 5400, 200)), 1)
    largest = float(bin_edges()[5400])
    found = pooled_quantile(hist, hist.sum(axis=0)[None], 0.99, largest)
    assert found.low < found.value <= found.high <= largest
    alone = pooled_quantile(hist[:1], hist[:1], 0.5)
    assert np.isnan(alone.low)
    assert np.isnan(alone.high)
    assert np.isnan(pooled_mean(rng.normal(size=(8, 1))).low)


def test_where_robots_and_poses_differ_their_variances_are_those_of_an_analysis_of_variance():
    """The variance of the mean over robots and sets of poses is (MS robots + MS sets - MS residual)
    / number of cells.
    """
    rng = np.random.default_rng(12)
    sets, robots = 8, 30
    values = (
        rng.normal(0, 1, robots)
        + rng.normal(0, 0.7, (sets, 1))
        + rng.normal(0, 0.8, (sets, robots))
    )
    rest = values - values.mean(axis=0) - values.mean(axis=1, keepdims=True) + values.mean()
    squares = np.array(
        [
            sets * values.mean(axis=0).var(ddof=1),
            robots * values.mean(axis=1).var(ddof=1),
            -(rest**2).sum() / (sets - 1) / (robots - 1),
        ]
    ) / (sets * robots)
    found = robot_intervals.two_way(values)
    # Satterthwaite
    freedom = (
        squares.sum() ** 2 / (squares**2 / [robots - 1, sets - 1, (sets - 1) * (robots - 1)]).sum()
    )
    assert (found.of_robots, found.of_poses) == pytest.approx(
        (squares[0], squares[1] + squares[2]), rel=1e-12
    )
    assert found.half == pytest.approx(t(freedom).ppf(0.975) * np.sqrt(squares.sum()), rel=1e-9)


def test_the_interval_of_a_share_below_a_limit_is_students_over_robots():
    """The share of errors below a limit of four robots has Student's interval with three degrees of
    freedom.
    """
    below = np.array([8, 5, 9, 6])
    hist = np.zeros((4, error_bins.BINS), np.int64)
    hist[:, 4000], hist[:, 5000] = below, 10 - below
    found = intervals.share_spread(hist, hist.sum(axis=0)[None], float(bin_edges()[4500]))
    assert found.half == pytest.approx(t(3).ppf(0.975) * (below / 10).std(ddof=1) / 2, rel=1e-9)
    assert (found.of_robots, found.of_poses) == pytest.approx(
        ((below / 10).var(ddof=1) / 4, 0.0), rel=1e-12
    )


def test_a_share_of_all_or_none_has_the_interval_of_as_many_trials_as_robots():
    """No error of 200 robots above the limit: at least 98 % (Wilson), not exactly 100 %; one group
    of robots has no interval.
    """
    hist = np.zeros((4, error_bins.BINS), np.int64)
    hist[:, 4000] = 50
    limit = float(bin_edges()[4500])
    found = share_below(hist, hist.sum(axis=0)[None], limit, 200)
    assert (found.value, found.low, found.high) == pytest.approx((1.0, *share_interval(200, 200)))
    none = share_below(hist, hist.sum(axis=0)[None], limit / 10, 200)
    assert (none.value, none.low, none.high) == pytest.approx((0.0, *share_interval(0, 200)))
    assert math.isnan(share_below(hist[:1], hist[:1], limit, 50).low)


def test_equal_sets_of_poses_leave_the_degrees_of_freedom_of_the_robots():
    """Where sets of poses do not differ, a thousand robots have a half-width of 1.96 standard
    errors, not the 2.36 of eight sets.
    """
    rng = np.random.default_rng(10)
    robots = rng.normal(1, 0.1, 1000)
    found = pooled_mean(np.tile(robots, (SETS, 1)))
    assert (found.high - found.low) / 2 == pytest.approx(
        1.9623 * robots.std(ddof=1) / np.sqrt(1000), rel=1e-4
    )


@pytest.mark.parametrize("count", [128, 1000])
@pytest.mark.parametrize(
    "law",
    [lambda u: u**3, lambda u: -np.log1p(-u), lambda u: 1 / (1 - u)],
    ids=["short", "exponential", "long tail"],
)
def test_the_robots_quantile_covers(law, count):
    """In 10 000 synthetic studies the true 95th percentile of the robots lies beyond either end of
    its interval in 1.5 to 3 %.
    """
    _, low, high = robots_quantile(law(np.random.default_rng(11).uniform(size=(10_000, count)))).T
    missed = np.array([(low > law(0.95)).mean(), (high < law(0.95)).mean()])
    assert (missed > 0.015).all(), missed
    assert (missed < 0.030).all(), missed


def test_the_pooled_robots_quantile_covers():
    """Of 1 000 synthetic studies 93 to 97 % have an interval that covers the true 95th percentile
    over robots.
    """
    rng = np.random.default_rng(11)
    covered = 0
    for _ in range(1000):
        found = pooled_robots_quantile(rng.normal(1, 0.2, 300) + rng.normal(0, 0.02, (SETS, 1)))
        covered += found.low <= 1 + 0.2 * 1.6448536 <= found.high
    assert 0.93 <= covered / 1000 <= 0.97


def test_the_robots_quantile_excludes_the_scatter_of_few_poses():
    """The 95th percentile over robots excludes the scatter of their means over few poses, and
    equals the mean where robots do not differ.
    """
    rng = np.random.default_rng(12)
    robots, cells = rng.normal(1, 0.1, 4000), rng.normal(0, 0.3, (SETS, 4000))
    exact, seen, none = (
        pooled_robots_quantile(values).value
        for values in (np.tile(robots, (SETS, 1)), robots + cells, 1 + cells)
    )
    assert exact == pytest.approx(1 + 0.1 * 1.645, rel=0.005)
    assert seen == pytest.approx(exact, rel=0.01)
    assert np.quantile((robots + cells).mean(axis=0), 0.95) > 1.04 * exact
    assert none == pytest.approx(1.0, rel=0.05)
    assert pooled_robots_quantile((robots + cells)[:1]).value == pytest.approx(
        np.quantile(robots + cells[0], 0.95), rel=1e-3
    )


def test_the_ranks_of_a_robots_quantile_follow_the_beta_distribution():
    """The ranks of both ends leave 2.5 % of a beta distribution beyond the level, and are near
    those that Hutson published for floods.
    """
    for count, published in ((59, (0.37502, 0.62498)), (37, (0.34414, 0.65586))):
        value, *ends = robots_quantile(np.arange(1.0, count + 1), 0.5)
        assert value == (count + 1) / 2
        assert [betainc(end, count + 1 - end, 0.5) for end in ends] == pytest.approx(
            [0.975, 0.025], abs=1e-9
        )
        assert np.array(ends) / (count + 1) == pytest.approx(published, abs=5e-5)


@pytest.mark.parametrize(
    ("count", "known"),
    [(1, (False, False)), (2, (True, False)), (71, (True, False)), (72, (True, True))],
)
def test_an_end_beyond_all_robots_is_unknown(count, known):
    """The upper end of a 95th percentile is unknown for up to 71 robots, since 0.95^71 exceeds 2.5
    %, and for one robot both ends are unknown.
    """
    _, *ends = robots_quantile(np.arange(float(count)))
    assert tuple(np.isfinite(ends)) == known


def test_a_root_mean_square_lies_between_the_roots_of_its_mean_squares_ends():
    """The squared ends of a root mean square's interval are Student's interval of the mean squares
    of the sets, truncated at zero.
    """
    found = root_mean_square(np.array([1.0, 3.0]))
    # Student's t for one degree of freedom, times the standard error 1
    half = 12.706204736 * np.sqrt(2) / np.sqrt(2)
    assert found.value == pytest.approx(np.sqrt(2))
    assert (found.low, found.high) == pytest.approx((0.0, np.sqrt(2 + half)))
    close = root_mean_square(np.array([4.0, 4.1, 3.9, 4.0]))
    assert close.high**2 - 4 == pytest.approx(4 - close.low**2)
    assert np.isnan(root_mean_square(np.array([2.0])).low)


def test_the_interval_of_a_standard_deviation_covers_for_any_source_of_scatter():
    """Of 400 synthetic studies 92 to 98.5 % have a 95 % interval that covers the true standard
    deviation over robots, poses and visits.

    Each error is a pose's size x a robot's size x a Maxwell-distributed length, so that its mean
    and mean square are known.
    """
    rng = np.random.default_rng(11)
    edges = bin_edges()
    mean = 1e-3 * np.sqrt(8 / np.pi)
    mean_square = 3e-6 * (1 + 0.5**2 / 3) * (1 + 0.2**2 / 3)
    truth = np.sqrt(mean_square - mean**2)
    covered = 0
    for _ in range(400):
        size = (
            1e-3
            * rng.uniform(0.5, 1.5, (SETS, 4, 1, 1))
            * rng.uniform(0.8, 1.2, (32, 4)).reshape(1, 1, 32, 4)
        )
        lengths = size * np.sqrt(rng.chisquare(3, size.shape))
        places = np.searchsorted(edges, lengths, side="right") - 1
        by_group, by_set = (
            np.moveaxis(places, axis, 0).reshape(count, -1) for axis, count in ((2, 32), (0, SETS))
        )
        hists = [
            np.stack([np.bincount(row, minlength=error_bins.BINS) for row in rows])
            for rows in (by_group, by_set)
        ]
        found = standard_deviation(*hists, float(lengths.mean()), float((lengths**2).mean()))
        assert found.value == pytest.approx(lengths.std(), rel=1e-9)
        covered += found.low <= truth <= found.high
    assert 0.92 <= covered / 400 <= 0.985


def test_repeated_samples_do_not_narrow_the_interval_of_a_standard_deviation():
    """Three robots have the same interval at one visit and at a hundred visits with equal errors,
    because only robots and sets of poses count.
    """
    places = np.array([4000, 4100, 4300])
    hist = np.zeros((3, error_bins.BINS), np.int64)
    hist[range(3), places] = 1
    lengths = np.sqrt(bin_edges()[places] * bin_edges()[places + 1])
    of_lengths = float(lengths.mean()), float((lengths**2).mean())
    sets = hist.sum(axis=0)[None]
    once, often = (
        standard_deviation(hist, sets, *of_lengths),
        standard_deviation(100 * hist, 100 * sets, *of_lengths),
    )
    assert (once.low, once.high) == pytest.approx((often.low, often.high), rel=1e-12)
    assert once.low < 0.9 * once.value
    assert once.value < 0.9 * once.high


def test_equal_errors_have_zero_standard_deviation():
    """Equal errors have a standard deviation of exactly zero, and one that the bins cannot resolve
    has no interval.
    """
    hist = np.zeros((4, error_bins.BINS), np.int64)
    hist[:, 4000] = 10
    at = float(np.sqrt(bin_edges()[4000] * bin_edges()[4001]))
    assert standard_deviation(hist, hist, at, at**2) == intervals.Estimate(0.0, 0.0, 0.0)
    narrow = standard_deviation(hist, hist, at, at**2 * (1 + 1e-8))
    assert narrow.value == pytest.approx(1e-4 * at, rel=1e-4)
    assert np.isnan([narrow.low, narrow.high]).all()


def test_the_chi_square_interval_of_a_root_mean_square_covers():
    """Of 2 000 intervals for 200 normal errors of 3 µm, 95 % cover 3 µm, and an interval is the
    same length in other units.
    """
    squares = np.random.default_rng(7).normal(0, 3e-6, (2000, 200)) ** 2
    found = [root_mean_square_of_samples(each) for each in squares]
    assert np.mean([each.low <= 3e-6 <= each.high for each in found]) == pytest.approx(
        0.95, abs=0.015
    )
    in_um = root_mean_square_of_samples(squares[0] * 1e12)
    assert (in_um.value, in_um.low, in_um.high) == pytest.approx(
        (found[0].value * 1e6, found[0].low * 1e6, found[0].high * 1e6), rel=1e-9
    )


@pytest.mark.parametrize("count", [1, 10, 37, 4000])
def test_no_share_exceeds_the_whole(count):
    """The interval of a share ends at exactly one where all robots meet a limit, and at zero where
    none does.
    """
    low, high = share_interval(count, count)
    assert 0 < low < high <= 1
    assert high == pytest.approx(1, abs=1e-12)
    assert share_interval(0, count) == pytest.approx((0, 1 - low), abs=1e-12)


@pytest.mark.parametrize(("hits", "count"), [(0, 5), (1, 1), (8, 10), (995, 1000)])
def test_the_interval_of_a_share_is_wilsons(hits, count):
    """At the ends of the interval of E. Wilson's score test the share seen is 1.96 standard
    deviations of the binomial law away, but for a share of none or all.
    """
    share, z = hits / count, NormalDist().inv_cdf(0.975)
    for end in share_interval(hits, count):
        away = z * math.sqrt(end * (1 - end) / count)
        assert end in {0.0, 1.0} or abs(end - share) == pytest.approx(away, rel=1e-9)


@pytest.mark.parametrize("bins", [[], [0], [4000, 4001, 4007], [5, error_bins.BINS - 1]])
def test_pseudo_values_are_those_of_all_bins(bins):
    """The bins without a sample may be passed over: also where none has one, and where the errors
    reach the first or the last.
    """
    hists = np.zeros((3, error_bins.BINS), np.int64)
    hists[:, bins] = np.random.default_rng(1).integers(0, 9, (3, len(bins)))
    whole = hists.sum(axis=0)
    expected = [3 * quantile(whole, 0.6) - 2 * quantile(whole - one, 0.6) for one in hists]
    np.testing.assert_array_equal(pseudo_values(hists, 0.6), expected)
