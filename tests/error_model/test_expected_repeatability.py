"""Expected RP_l of normally distributed visits: its limits, and agreement with sampling for few
visits.
"""

import numpy as np
import pytest
from scipy.special import gamma

from lostmotion.error_model.expected_repeatability import expected_repeatability, length_moments
from lostmotion.laws.iso9283 import pose_repeatability

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "RP of normal scatter without sampling",
        "its constants; 800 000 sets of 30 visits, 200 000 of 3 to 10, with control variates",
        "6e-6; at 30 visits 0.02 % mean, 0.05 % standard deviation, plus sampling error",
    ),
)

SHAPES = [(1.0, 1.0, 1.0), (1.0, 1.0, 0.0), (1.0, 0.0, 0.0), (1.0, 0.25, 0.04), (1.0, 0.5, 0.5)]


def _mean_length(variances, power):
    """Return E l^p by averaging over a fine grid of directions, an independent calculation."""
    upward, around = np.meshgrid(
        (np.arange(600) + 0.5) / 600, (np.arange(600) + 0.5) / 600 * np.pi / 2, indexing="ij"
    )
    flat = 1 - upward**2
    square = (
        variances[0] * flat * np.cos(around) ** 2
        + variances[1] * flat * np.sin(around) ** 2
        + variances[2] * upward**2
    )
    return (
        2 ** (power / 2)
        * gamma((3 + power) / 2)
        / gamma(1.5)
        * float((square ** (power / 2)).mean())
    )


def _sampled(variances, visits, sets, seed=5):
    """Return mean and standard deviation of RP_l over sampled sets, each with its standard error.

    Variance reduction: only the remainder beyond a sum over independent visits is sampled, whose
    mean and variance are known.
    """
    mean, cube = (_mean_length(variances, power) for power in (1, 3))
    total = sum(variances)
    spread = np.sqrt(total - mean**2)
    # Per visit: z + 3 (z^2 - 1) / 2 of its standard length z, the first order of RP_l.
    third = (cube - 3 * mean * total + 2 * mean**3) / spread**3
    fourth = (
        total**2
        + 2 * sum(x**2 for x in variances)
        - 4 * mean * cube
        + 6 * mean**2 * total
        - 3 * mean**4
    ) / spread**4
    known = (1 + 3 * third + 9 / 4 * (fourth - 1)) * spread**2 / visits
    rng, parts = np.random.Generator(np.random.SFC64(seed)), []
    axes = np.sqrt([x for x in variances if x])
    for _ in range(0, sets, 20_000):
        points = rng.standard_normal((20_000, visits, len(axes))) * axes
        z = (np.sqrt((points**2).sum(axis=-1)) - mean) / spread
        parts.append((spread * (z + 1.5 * (z**2 - 1)).mean(axis=1), pose_repeatability(points)))
    easy, found = np.concatenate(parts, axis=1)
    left = found - easy
    about = left - left.mean()
    grown = 2 * easy * about + about**2  # what the square of the deviation has besides the known
    chance = np.stack([easy, easy**2 - known])  # zero on the average
    squared, by_chance = _without(grown, chance)
    deviation = np.sqrt(known + squared)
    return *_without(left, chance), deviation, by_chance / (2 * deviation)


def _without(values, chance):
    """Return the mean of values, less its regression on values of known zero mean, and its standard
    error.
    """
    less = np.linalg.solve(chance @ chance.T, chance @ (values - values.mean())) @ chance
    return (values - less).mean(), (values - less).std() / np.sqrt(len(values))


@pytest.mark.parametrize(("axes", "limit"), [(3, 3.61609), (2, 3.21872), (1, 2.60632)])
def test_repeatability_of_many_visits_tends_to_its_constant(axes, limit):
    """RP_l for many visits, in standard deviations per axis, in space, in a plane and on a line."""
    covariance = 4.0 * np.diag(np.arange(3) < axes).astype(float)[None]
    assert expected_repeatability(covariance)[0][0] / 2 == pytest.approx(limit, abs=6e-6)
    assert expected_repeatability(covariance, 10**7)[0][0] / 2 == pytest.approx(limit, abs=6e-6)


@pytest.mark.parametrize(
    ("shape", "sets"),
    [
        *(pytest.param(shape, 800_000, marks=pytest.mark.slow) for shape in SHAPES[:4]),
        (SHAPES[4], 200_000),
    ],
)
def test_repeatability_of_thirty_visits_holds_to_a_thousandth(shape, sets):
    """Mean and standard deviation over sets of 30 visits, in space, in a plane, on a line and for
    unequal axes, agree with sampling to 0.05 %.
    """
    mean, deviation = (value[0] for value in expected_repeatability(np.diag(shape)[None], 30))
    sampled, by_chance, spread, spread_by_chance = _sampled(shape, 30, sets)
    assert by_chance < 1e-4 * sampled
    assert spread_by_chance < 0.4 / np.sqrt(sets) * spread
    assert abs(mean - sampled) < 2e-4 * mean + 2 * by_chance
    assert abs(deviation - spread) < 5e-4 * deviation + 2 * spread_by_chance


def test_thirty_visits_of_a_round_scatter_show_the_known_figures():
    """In space the mean is 3.536 standard deviations per axis with a standard deviation of 0.329;
    the latter is 0.337 in a plane, 0.355 on a line.
    """
    covariance = np.stack([np.diag(shape) for shape in SHAPES[:3]])
    mean, deviation = expected_repeatability(covariance, 30)
    assert mean[0] == pytest.approx(3.536, abs=5e-4)
    assert deviation == pytest.approx([0.3293, 0.3367, 0.3546], abs=3e-4)


@pytest.mark.parametrize(
    ("visits", "of_mean", "of_deviation"),
    [(10, 5e-4, 3e-3), (7, 5e-4, 5e-3), (5, 2e-3, 0.02), (3, 0.011, 0.11)],
)
@pytest.mark.parametrize("shape", [SHAPES[0], SHAPES[2], SHAPES[3]])
def test_repeatability_of_few_visits_is_as_good_as_it_says(shape, visits, of_mean, of_deviation):
    """The stated error for few visits is not exceeded."""
    mean, deviation = (value[0] for value in expected_repeatability(np.diag(shape)[None], visits))
    sampled, by_chance, spread, spread_by_chance = _sampled(shape, visits, 200_000)
    assert abs(mean - sampled) < of_mean * mean + 2 * by_chance
    assert abs(deviation - spread) < of_deviation * deviation + 2 * spread_by_chance


def test_two_visits_lie_as_far_from_their_middle():
    """RP_l of two visits is half their distance: sqrt(1 / pi) on average on a line with unit
    standard deviation.
    """
    mean, deviation = (
        value[0] for value in expected_repeatability(np.diag([1.0, 0.0, 0.0])[None], 2)
    )
    assert mean == pytest.approx(np.sqrt(1 / np.pi), rel=1e-10)
    assert deviation == pytest.approx(np.sqrt(0.5 - 1 / np.pi), rel=1e-10)


def test_what_does_not_scatter_repeats_and_what_is_no_number_stays_none():
    """Zero scatter gives zero; NaN gives NaN without affecting other covariances, of any
    magnitude.
    """
    mean, deviation = expected_repeatability(
        np.stack([np.zeros((3, 3)), np.full((3, 3), np.nan), 1e-12 * np.eye(3), 1e6 * np.eye(3)]),
        30,
    )
    assert mean[0] == deviation[0] == 0
    assert np.isnan(mean[1])
    assert np.isnan(deviation[1])
    assert mean[3] / mean[2] == pytest.approx(1e9, rel=1e-12)
    with pytest.raises(ValueError, match="at least 2"):
        expected_repeatability(np.eye(3)[None], 1)


@pytest.mark.parametrize("axes", [1, 2, 3, 5])
def test_moments_of_a_round_length_are_those_of_chi(axes):
    """E l^p by quadrature equals the gamma-function form for any number of axes, and additional
    zero variances change nothing.
    """
    moments = length_moments(np.array([1 / axes] * axes + [0.0] * (5 - axes)))
    for power, found in enumerate(moments):
        assert found == pytest.approx(
            (2 / axes) ** (power / 2) * gamma((axes + power) / 2) / gamma(axes / 2), rel=1e-11
        )
