"""The magnitude of an error by rays and by points, compared with closed forms, exact cumulants and
each other.
"""

from collections import Counter
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.stats import qmc

from lostmotion.error_model.cumulants import Cumulants, CumulantsOfOrder, cumulants
from lostmotion.error_model.error_bins import bin_edges
from lostmotion.laws.distributions import Cosine, Normal, Sine, Table, TwoSided, Uniform
from lostmotion.propagation import error_magnitude as magnitude

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "magnitude of a normal vector",
        "chi, Rice, folded normal, noncentral chi-square; reference figures",
        "2e-4 at 95 % and above, 6e-4 mean, 4.5e-3 median",
        "propagation/error_magnitude.py propagation/shape_correction.py propagation/error_magnitude_kernel.py",
    ),
    (
        "magnitude of sums far from normal",
        "noncentral chi-square, sums of uniform draws, exact cumulants of the square, samples",
        "5e-3, or the stated uncertainty",
        "propagation/error_magnitude.py propagation/shape_correction.py tests/propagation/test_analytic.py",
    ),
)

LEVELS = np.array(magnitude.LEVELS)
NORMAL = Normal(np.inf)
PLAY, FLAT, CUT = TwoSided(), Uniform(), Normal()


def normal_vector(bias, variances, levels=LEVELS):
    """Return the figures of one normal vector whose axes are x, y and z."""
    return magnitude.by_rays(
        np.diag(np.sqrt(np.array(variances, float)))[None], np.array([bias], float), levels=levels
    )


def points_of(terms, count=magnitude.POINTS):
    """Return Sobol draws for terms [(shift, stream, distribution), ...], the largest stream first,
    and their shifts (1, 3, term).
    """
    importance = Counter()
    for shift, stream, _ in terms:
        importance[stream] += float(np.square(shift).sum())
    drawn = magnitude.sobol_draws([[(stream, law)] for _, stream, law in terms], importance, count)
    return drawn, np.array([shift for shift, *_ in terms], float).T[None]


def by_points(terms, bias=(0, 0, 0)):
    """Return the values and their uncertainty (2 + level,) of one sum by points."""
    drawn, shift = points_of(terms)
    return (found[0] for found in magnitude.by_points(shift, np.array([bias], float), drawn))


def round_noise(size=1.0):
    """Return normal terms with this standard deviation along each axis."""
    return [(size * axis, f"noise {k}", NORMAL) for k, axis in enumerate(np.eye(3))]


@pytest.mark.parametrize(
    ("bias", "variances", "expected", "tolerance"),
    [
        ((0, 0, 0), (1, 1, 1), (1.595769, 0.673440, 1.538172, 2.795483, 3.368214, 3.732482), 1e-5),
        ((2, 0, 0), (1, 1, 1), (None, None, 2.464980, 3.997649, 4.649304, 5.055140), 2e-4),
        (
            (0, 0, 0),
            (1, 0, 0),
            (np.sqrt(2 / np.pi), np.sqrt(1 - 2 / np.pi), 0.674490, 1.959964, 2.575829, 2.967738),
            3e-5,
        ),
        ((1, 0, 0), (1, 0, 0), (None, None, 1.050544, 2.646146, 3.326632, 3.747894), 2e-5),
        (
            (0, 0, 0),
            (1, 1, 0),
            (stats.rayleigh.mean(), stats.rayleigh.std(), 1.177410, 2.447747, 3.034854, 3.408561),
            4e-5,
        ),
    ],
)
def test_rays_of_normal_vectors_are_the_closed_forms(bias, variances, expected, tolerance):
    """The figures of a normal vector in space, in a plane and on a line equal their closed forms.

    A normal vector needs no correction for shape, so its uncertainty is that of the integration
    alone.
    """
    found = normal_vector(bias, variances)
    for own, exact in zip(found.values[0], expected, strict=True):
        assert exact is None or own == pytest.approx(exact, rel=tolerance)
    assert found.nearly_normal.all()
    assert found.uncertainty == pytest.approx(1e-3 * found.values[0, 1])  # integration error alone


@pytest.mark.parametrize("bias", [0.0, 0.3, 1.0, 3.0, 10.0, 100.0])
@pytest.mark.parametrize("rank", [1, 2, 3])
def test_rays_are_accurate_for_any_rank_and_any_bias(rank, bias):
    """Rays match folded normal, Rice and noncentral chi: high levels to 0.02 %, mean and deviation
    to 0.06 %, the median to 0.45 %.
    """
    variances = (np.arange(3) < rank).astype(float)
    law = {1: stats.foldnorm(bias), 2: stats.rice(bias) if bias else stats.rayleigh, 3: None}[rank]
    exact = np.sqrt(stats.ncx2(3, bias**2).ppf(LEVELS)) if law is None else law.ppf(LEVELS)
    found = normal_vector((bias, 0, 0), variances)
    size = np.maximum(exact, np.sqrt(rank))
    assert found.values[0, 3:] == pytest.approx(exact[1:], abs=2e-4 * size[1:].max())
    assert found.values[0, 2] == pytest.approx(exact[0], abs=4.5e-3 * size[0])
    if law is not None and bias < 30:  # SciPy's own mean overflows at larger biases
        assert found.values[0, :2] == pytest.approx((law.mean(), law.std()), rel=6e-4)
    # The mean square is b . b + tr C, within the integration error of 256 directions.
    assert found.values[0, 0] ** 2 + found.values[0, 1] ** 2 == pytest.approx(
        bias**2 + rank, rel=2e-4
    )


@given(st.integers(0, 2**32 - 1), st.integers(1, 3), st.floats(-6, 6))
@settings(deadline=None, max_examples=50)
def test_turning_and_scaling_a_vector_turns_and_scales_its_figures(seed, rank, exponent):
    """Rotating a vector leaves its quantiles unchanged, scaling it scales them, and they rise with
    their level.
    """
    rng = np.random.default_rng(seed)
    root, bias = (
        rng.standard_normal((3, rank)) * 10.0 ** rng.uniform(-1, 0, rank),
        rng.standard_normal(3),
    )
    turn, scale = np.linalg.qr(rng.standard_normal((3, 3)))[0], 10.0**exponent
    first, second = (
        magnitude.by_rays((m @ root)[None], (m @ bias)[None]).values[0]
        for m in (np.eye(3), scale * turn)
    )
    assert second == pytest.approx(scale * first, rel=1e-4)
    assert (np.diff(first[2:]) > 0).all()


def test_the_share_below_a_quantile_is_its_level():
    """The share of errors below a quantile is its level, and the density is the derivative of that
    share.
    """
    rng = np.random.default_rng(2)
    roots, bias = rng.standard_normal((30, 3, 3)), rng.standard_normal((30, 3))
    quantiles = magnitude.by_rays(roots, bias).values[:, 2:]
    rays = magnitude.rays_of(roots @ roots.transpose(0, 2, 1), bias)
    shares, densities = magnitude.share_below(rays, quantiles)
    assert shares == pytest.approx(np.tile(LEVELS, (30, 1)), abs=2e-5)
    step = 1e-4 * quantiles
    slopes = (
        magnitude.share_below(rays, quantiles + step)[0]
        - magnitude.share_below(rays, quantiles - step)[0]
    ) / (2 * step)
    assert densities == pytest.approx(slopes, rel=0.02, abs=1e-3 * densities.max())
    ends = magnitude.share_below(rays, np.tile([0.0, 1e6], (30, 1)))[0]
    assert ends == pytest.approx(np.tile([0.0, 1.0], (30, 1)), abs=1e-6)


def test_the_density_of_a_corrected_magnitude_is_the_slope_of_its_share():
    """The density of a magnitude corrected for skewness and kurtosis is the derivative of its
    share, for each power of the ray's radius.
    """
    rng = np.random.default_rng(4)
    roots, bias = rng.standard_normal((6, 3, 3)), rng.standard_normal((6, 3))
    normal = magnitude.rays_of(roots @ roots.transpose(0, 2, 1), bias)
    # above the bias, where every ray crosses the limit once
    limits, step = np.linalg.norm(bias, axis=1)[:, None] + [0.1, 1.0, 3.0], 1e-3
    for power in range(5):
        weights = np.zeros_like(normal.weights)
        weights[:, power] = 1 / magnitude.RAYS
        rays = normal._replace(weights=weights)
        densities = magnitude.share_below(rays, limits)[1]
        slopes = (
            magnitude.share_below(rays, limits + step)[0]
            - magnitude.share_below(rays, limits - step)[0]
        ) / (2 * step)
        assert densities == pytest.approx(slopes, rel=0.02, abs=2e-3 * densities.max()), power


def test_an_error_without_scatter_is_its_bias():
    """Every figure of an error without scatter equals |b| exactly, and is zero without a bias."""
    found = magnitude.by_rays(
        np.zeros((2, 3, 4)),
        np.array([[3.0, 0, 4], [0, 0, 0]]),
        cumulants([[(k, FLAT)] for k in range(4)]),
    )
    assert found.values.tolist() == [[5, 0, 5, 5, 5, 5], [0] * 6]
    assert not found.uncertainty.any()
    assert found.nearly_normal.all()


@pytest.mark.parametrize(
    ("terms", "exact", "tolerance"),
    [
        (
            [((1, 0, 0), k, FLAT) for k in range(3)],
            np.sqrt(3) * (3 - np.cbrt(24 * (1 - LEVELS))),
            0.005,
        ),
        ([((2, 0, 0), "side", PLAY), *round_noise()], np.sqrt(stats.ncx2.ppf(LEVELS, 3, 4)), 0.004),
        (
            [((2, 0, 0), "w", Cosine()), ((0, 2, 0), "w", Sine()), *round_noise()],
            np.sqrt(stats.ncx2.ppf(LEVELS, 3, 8)),
            0.004,
        ),
        ([((0.6, 0, 0.8), "u", FLAT)], np.sqrt(3) * LEVELS, 0.001),
    ],
    ids=[
        "three uniform draws on a line",
        "a play in isotropic noise",
        "a harmonic in isotropic noise",
        "a uniform draw",
    ],
)
def test_points_of_sums_far_from_normal_are_the_closed_forms(terms, exact, tolerance):
    """Points match the Irwin-Hall and noncentral chi distributions within their uncertainty, which
    is below 2 %.
    """
    values, uncertainty = by_points(terms)
    # the formula for three uniform draws is valid in the tail only
    first = 1 if terms[0][1] == 0 else 0
    assert values[2 + first :] == pytest.approx(exact[first:], rel=tolerance)
    assert (np.abs(values[2 + first :] - exact[first:]) <= 1.5 * uncertainty[2 + first :]).all()
    assert (uncertainty[:-1] < 0.02 * values[:-1]).all()


def test_a_level_in_a_gap_has_an_uncertainty_as_wide_as_the_gap():
    """Two two-sided errors make two magnitudes: the median between them has the gap as its
    uncertainty, and higher levels equal the larger one.
    """
    values, uncertainty = by_points([((1, 0, 0), "a", PLAY), ((0.3, 0.5, 0), "b", PLAY)])
    short, long = np.hypot(0.7, 0.5), np.hypot(1.3, 0.5)
    assert values[0] == pytest.approx((short + long) / 2, rel=1e-5)
    assert values[1] == pytest.approx((long - short) / 2, rel=1e-5)
    assert values[3:] == pytest.approx([long] * 3, rel=1e-3)
    assert uncertainty[2] > 0.9 * (long - short) / 2
    assert ((uncertainty[3:] > 0) & (uncertainty[3:] < 1e-3)).all()  # half a bin width


def shapes_of(seed, rank=3):
    """Return a random sum of uniform, two-sided, harmonic and normal draws: terms, shifts (pose, 3,
    term) and biases (pose, 3).

    The bias is up to a hundred times the scatter.
    """
    rng, terms = np.random.default_rng(seed), []
    for k in range(int(rng.integers(12, 30))):
        kind = rng.integers(4)
        terms += [[(k, Cosine())], [(k, Sine())]] if kind == 3 else [[(k, (CUT, FLAT, PLAY)[kind])]]
    shift = rng.standard_normal((8, 3, len(terms)))
    shift[:, rank:] = 0.0
    bias = (
        rng.standard_normal((8, 3)) * np.sqrt(len(terms)) * rng.choice([0, 0.3, 1, 10, 100], (8, 1))
    )
    return terms, shift, bias


@pytest.mark.parametrize("rank", [1, 2, 3])
@pytest.mark.parametrize("seed", range(6))
def test_rays_and_points_agree_where_rays_are_valid(seed, rank):
    """Along a line, in a plane and in space, rays and points agree on the mean to 0.3 % and on
    every figure within both uncertainties.
    """
    terms, shift, bias = shapes_of(seed, rank)
    rays = magnitude.by_rays(shift, bias, cumulants(terms))
    drawn = magnitude.sobol_draws(
        terms,
        dict.fromkeys((stream for term in terms for stream, _ in term), 1.0),
        magnitude.POINTS,
    )
    values, uncertainty = magnitude.by_points(shift, bias, drawn)
    near = rays.nearly_normal
    assert near.any()
    assert rays.values[near, 0] == pytest.approx(values[near, 0], rel=3e-3)
    assert rays.values[near, 1] == pytest.approx(values[near, 1], rel=0.01)
    assert (np.abs(rays.values - values) <= rays.uncertainty + 1.5 * uncertainty)[near].all()


@pytest.mark.parametrize(("rank", "seed"), [(1, 0), (1, 5), (2, 5), (3, 5)])
def test_mean_and_deviation_by_rays_lie_within_their_uncertainty(rank, seed):
    """The mean and standard deviation by rays lie within their uncertainty of those of 131 072
    points.

    The uncertainty is that of the integration and a tenth of the largest correction of a quantile.
    """
    terms, shift, bias = shapes_of(seed, rank)
    rays = magnitude.by_rays(shift, bias, cumulants(terms))
    drawn = magnitude.sobol_draws(
        terms, dict.fromkeys((stream for term in terms for stream, _ in term), 1.0), 2**17, seed=9
    )
    exact, _ = magnitude.by_points(shift, bias, drawn)
    near = rays.nearly_normal
    assert near.any()
    assert (np.abs(rays.values - exact)[near, :2] <= rays.uncertainty[near, :2]).all()
    assert (rays.uncertainty[near, :2] < 0.02 * rays.values[near, 1:2]).all()


def test_uncertainty_by_points_covers_the_scatter_between_sequences():
    """The scatter of a figure over twelve scrambled sequences is at most its uncertainty, and that
    of a quantile at least a tenth of it.
    """
    terms, shift, bias = shapes_of(0)
    streams = dict.fromkeys((stream for term in terms for stream, _ in term), 1.0)
    found = np.array(
        [
            magnitude.by_points(
                shift, bias, magnitude.sobol_draws(terms, streams, magnitude.POINTS, seed)
            )
            for seed in range(12)
        ]
    )
    scatter, uncertainty = found[:, 0].std(axis=0, ddof=1), found[:, 1].mean(axis=0)
    assert (scatter <= uncertainty).all()
    assert (uncertainty[:, 2:] <= 10 * scatter[:, 2:]).all()


def test_points_have_the_exact_mean_vector():
    """Points centre every draw and product of draws, so the mean magnitude along a large bias
    equals the bias.
    """
    terms = [[("amount", NORMAL), ("side", PLAY)], [("u", FLAT)]]
    drawn = magnitude.sobol_draws(terms, {"amount": 1.0, "side": 1.0, "u": 1.0}, magnitude.POINTS)
    assert abs(drawn[0].mean()) > 1e-5
    values, _ = magnitude.by_points(
        np.array([[[1.0, 0.5], [0, 0], [0, 0]]]), np.array([[10.0, 0, 0]]), drawn
    )
    assert values[0, 0] == pytest.approx(10.0, abs=2e-6)


def test_the_most_important_stream_takes_the_first_coordinate():
    """The stream with the largest variance takes the first and most uniform coordinate of the Sobol
    sequence, whatever the order of the terms.
    """
    first = np.random.default_rng(0)
    points = qmc.Sobol(3, scramble=True, rng=first).random(64)
    drawn = magnitude.sobol_draws(
        [[("a", FLAT)], [("b", FLAT)], [("c", FLAT)]], {"a": 1.0, "b": 3.0, "c": 2.0}, 64
    )
    assert drawn == pytest.approx(FLAT.quantile(points.T[[2, 0, 1]]), abs=1e-9)


def test_the_excess_is_that_of_the_draws():
    """The k_iijj of independent draws is the sum of their fourth cumulants times the fourth powers
    of their sizes.
    """
    shift = np.random.default_rng(3).standard_normal((1, 3, 4))
    found = magnitude.by_rays(
        shift,
        np.zeros((1, 3)),
        cumulants([[(k, law)] for k, law in enumerate((FLAT, PLAY, FLAT, NORMAL))]),
    )
    covariance = shift[0] @ shift[0].T
    fourth = np.array([-1.2, -2.0, -1.2, 0.0]) @ np.square(shift[0]).sum(axis=0) ** 2
    assert found.excess[0] == pytest.approx(
        fourth / (np.trace(covariance) ** 2 + 2 * np.trace(covariance @ covariance)), rel=1e-7
    )


def test_figures_come_from_rays_where_these_are_valid_and_from_points_elsewhere():
    """A pose with a dominant two-sided error uses points, a pose with many small errors rays, and
    both have every figure with its uncertainty.
    """
    terms = [[("side", PLAY)], *([(k, CUT)] for k in range(20))]
    shift = np.random.default_rng(1).standard_normal((2, 3, 21))
    shift[1, :, 0] = 30.0
    drawn = magnitude.sobol_draws(
        terms, {"side": 2.0} | dict.fromkeys(range(20), 1.0), magnitude.POINTS
    )
    found = magnitude.figures(shift, np.zeros((2, 3)), cumulants(terms), lambda _: drawn)
    assert found.nearly_normal.tolist() == [True, False]
    assert (
        found.values[1].tolist()
        == magnitude.by_points(shift[1:], np.zeros((1, 3)), drawn)[0][0].tolist()
    )
    assert (
        found.values[0].tolist()
        == magnitude.by_rays(shift, np.zeros((2, 3)), cumulants(terms)).values[0].tolist()
    )
    assert (found.uncertainty > 0).all()
    assert found.excess[1] < found.excess[0] < 0


def test_two_sided_draws_beside_a_large_bias_are_not_nearly_normal():
    """Two-sided errors beside a large bias are not nearly normal, although their quantiles hardly
    move relative to the magnitude.
    """
    terms = [[(k, PLAY)] for k in range(3)]
    found = magnitude.by_rays(
        np.eye(3)[None] * [1.0, 0.5, 0.2], np.array([[100.0, 0, 0]]), cumulants(terms)
    )
    assert not found.nearly_normal.any()


def exact_cumulants(shift, bias, known):
    """Return the first two cumulants of |b + S x|^2, exact for any draws (V. Leonov, A. Shiryaev
    1959).
    """
    t, k = np.zeros((3, 3, 3)), np.zeros((3, 3, 3, 3))
    for members, value in zip(known.third.terms.tolist(), known.third.values, strict=True):
        for order in set(permutations(members)):
            t += (
                value
                / len(set(permutations(members)))
                * np.einsum("i,j,k->ijk", *(shift[:, m] for m in order))
            )
    for members, value in zip(known.fourth.terms.tolist(), known.fourth.values, strict=True):
        for order in set(permutations(members)):
            k += (
                value
                / len(set(permutations(members)))
                * np.einsum("i,j,k,l->ijkl", *(shift[:, m] for m in order))
            )
    c = shift @ shift.T
    first = bias @ bias + np.trace(c)
    return first, 2 * np.trace(c @ c) + 4 * bias @ c @ bias + 4 * bias @ np.einsum(
        "ijj->i", t
    ) + np.einsum("iijj->", k)


@pytest.mark.parametrize("seed", range(3))
def test_points_have_the_exact_variance_of_the_squared_error(seed):
    """The mean and variance of the squared magnitude by points equal the formula in cumulants, with
    skew draws and a bias.
    """
    terms, shift, bias = shapes_of(seed)
    skew = Table(((0.0, 0.0), (0.2, 0.7), (1.0, 1.0)))
    terms[0] = [("skew", skew)]
    known = cumulants(terms)
    assert len(known.third.terms)
    drawn = magnitude.sobol_draws(
        terms, dict.fromkeys((stream for term in terms for stream, _ in term), 1.0), 2**16
    )
    for p in range(3):
        squares = np.square(shift[p] @ drawn + bias[p][:, None]).sum(axis=0)
        mean, variance = exact_cumulants(shift[p], bias[p], known)
        assert squares.mean() == pytest.approx(mean, rel=1e-3)
        assert squares.var() == pytest.approx(variance, rel=0.02)


def test_rays_follow_skewness():
    """The correction for skewness and kurtosis moves the quantiles of a shifted gamma distribution
    beside a bias to those of SciPy.
    """
    shape, bias = 60.0, 4.0
    law = stats.gamma(shape, loc=-np.sqrt(shape), scale=1 / np.sqrt(shape))
    none = np.zeros(1, int)
    third, fourth = (
        CumulantsOfOrder(np.zeros((1, n), int), np.array([value]), np.zeros(1), none, none)
        for n, value in ((3, 2 / np.sqrt(shape)), (4, 6 / shape))
    )
    known = Cumulants(third, fourth, ())
    shift = np.zeros((1, 3, 1))
    shift[0, 0] = 1.0
    exact = bias + law.ppf(LEVELS)
    corrected, plain = (
        magnitude.by_rays(shift, np.array([[bias, 0, 0]]), one).values[0] for one in (known, None)
    )
    assert corrected[0] == pytest.approx(bias, abs=2e-4)
    assert np.abs(corrected[2:] - exact).max() < 0.3 * np.abs(plain[2:] - exact).max()


def test_more_points_change_figures_by_less_than_their_uncertainty():
    """Four times as many points change each figure of a sum far from normal by at most 1.5 times
    its uncertainty.
    """
    terms = [
        ((1, 0.2, 0), "a", PLAY),
        ((0, 0.8, 0.3), "b", FLAT),
        ((0.5, -0.4, 0.6), "w", Cosine()),
        ((0.1, 0.4, 0.6), "w", Sine()),
        *round_noise(0.3),
    ]
    drawn, shift = points_of(terms, 2**16)
    few, some, many = (
        magnitude.by_points(shift, np.zeros((1, 3)), drawn[:, :count])
        for count in (2**12, 2**14, 2**16)
    )
    for (value, uncertainty), (better, less) in ((few, some), (some, many)):
        assert (np.abs(value - better) <= 1.5 * uncertainty).all()
        assert (less < uncertainty).mean() > 0.7


def test_a_pose_in_a_full_tile_has_the_same_bits_whatever_follows():
    """The figures of a pose in a full tile have the same bits for any number of later poses."""
    terms, shift, bias = shapes_of(1)
    shift, bias = np.tile(shift, (20, 1, 1)), np.tile(bias, (20, 1))
    drawn = magnitude.sobol_draws(
        terms, dict.fromkeys((stream for term in terms for stream, _ in term), 1.0), 4096
    )
    for count in (64, 128):
        assert np.array_equal(
            magnitude.by_rays(shift[:count], bias[:count]).values,
            magnitude.by_rays(shift, bias).values[:count],
        )
        assert np.array_equal(
            magnitude.by_points(shift[:count], bias[:count], drawn)[0],
            magnitude.by_points(shift, bias, drawn)[0][:count],
        )


def test_pooled_counts_are_the_histogram_of_all_magnitudes():
    """The pooled counts put every magnitude of every pose into its bin of the Monte Carlo
    histogram, block by block.
    """
    terms, shift, bias = shapes_of(2)
    drawn = magnitude.sobol_draws(
        terms, dict.fromkeys((stream for term in terms for stream, _ in term), 1.0), 4096
    )
    counts = magnitude.pooled_counts(shift * 1e-4, bias * 1e-4, drawn)
    centred = drawn - drawn.mean(axis=1, keepdims=True)
    lengths = 1e-4 * np.linalg.norm(shift @ centred + bias[:, :, None], axis=1)
    by_hand = np.histogram(lengths, bin_edges())[0]
    assert counts.shape == (magnitude.BLOCKS, len(by_hand))
    assert (counts.sum(axis=1) == lengths.size // magnitude.BLOCKS).all()
    # 32-bit rounding moves magnitudes across a nearby edge
    assert np.abs(counts.sum(axis=0) - by_hand).sum() < 1e-3 * lengths.size


def test_the_density_below_the_bias_is_the_slope_of_the_share():
    """Below the length of a large bias, directions that never reach a limit add neither share nor
    density.
    """
    rays = magnitude.rays_of(np.diag([1.0, 4.0, 0.25])[None], np.array([[3.0, 2.0, 1.0]]))
    limits = np.linspace(1.0, 3.7, 28)
    shares, densities = magnitude.share_below(rays, limits[None])
    step = 1e-5
    above, below = (
        magnitude.share_below(rays, (limits + side * step)[None])[0] for side in (1, -1)
    )
    assert densities[0] == pytest.approx((above - below)[0] / (2 * step), rel=2e-2, abs=1e-6)
    assert np.abs(densities).max() < 1.0
    assert (np.diff(shares[0]) > 0).all()
