"""The length of a normal vector: against SciPy's laws, Imhof's integral and samples."""

import hashlib
from math import factorial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from lostmotion.laws import normal_length_kernel as kernel
from lostmotion.laws import normal_length_means_kernel as means_kernel
from lostmotion.laws.distributions import Cosine, Normal, TwoSided, Uniform
from lostmotion.laws.normal_length import ACCURACY, WORST, normal_length, share_and_density, share_below
from lostmotion.laws.normal_length_forms_kernel import FOURTHS

LEVELS = (0.25, 0.5, 0.95, 0.99, 0.997)


def one(bias, variances, levels=LEVELS):
    """Give the length of one vector with axes along x, y and z."""
    return normal_length(np.array([bias], float), np.diag(variances)[None].astype(float), levels)


def imhof(limit, variances, bias):
    """P(|b + N(0, diag)| > limit) by Imhof's real integral (Biometrika 48 (1961) 419, eq. 3.2), summed at Davies' midpoints."""
    step = 2 * np.pi / (limit**2 + 60 * (variances.sum() + (bias**2).sum()))
    total = 0.0
    for first in range(0, 4_000_000, 500_000):
        u = (np.arange(first, first + 500_000) + 0.5) * step
        t = np.outer(variances, u)
        part = 1 / (1 + t * t)
        d = (bias**2 / variances)[:, None]
        angle = 0.5 * np.sum(np.arctan(t) + d * t * part, axis=0) - 0.5 * limit**2 * u
        total += np.sum(np.sin(angle) / u * np.sqrt(np.sqrt(np.prod(part, axis=0))) * np.exp(-0.5 * np.sum(d * t * t * part, axis=0)))
    return 0.5 + total * step / np.pi


@pytest.mark.parametrize("rank", [1, 2, 3])
def test_without_bias_the_length_is_chis(rank):
    """A round scatter in one, two or three dimensions: half-normal, Rayleigh and Maxwell."""
    found, law = one([0, 0, 0], np.arange(3) < rank), stats.chi(rank)
    assert found.mean[0] == pytest.approx(law.mean(), rel=ACCURACY)
    assert found.cube_mean[0] == pytest.approx(law.moment(3), rel=ACCURACY)
    assert found.quantiles[0] == pytest.approx(law.ppf(LEVELS), rel=ACCURACY)


@pytest.mark.parametrize("bias", [1e-3, 0.1, 1.0, 3.0, 10.0, 100.0, 1e4])
def test_with_bias_it_is_scipys_folded_rician_and_noncentral_law(bias):
    """Rank one: folded normal; rank two: Rice; rank three: the root of a noncentral chi-square."""
    folded, rice = stats.foldnorm(bias), stats.rice(bias)
    assert one([bias, 0, 0], [1, 0, 0]).mean[0] == pytest.approx(folded.mean(), rel=ACCURACY)
    assert one([bias, 0, 0], [1, 0, 0]).quantiles[0] == pytest.approx(folded.ppf(LEVELS), rel=ACCURACY)
    assert one([bias, 0, 0], [1, 1, 1]).quantiles[0] == pytest.approx(np.sqrt(stats.ncx2(3, bias**2).ppf(LEVELS)), rel=ACCURACY)
    found = one([0, bias, 0], [1, 1, 0])
    if bias < 30:  # beyond, SciPy's own mean overflows
        assert found.mean[0] == pytest.approx(rice.mean(), rel=ACCURACY)
    assert found.quantiles[0] == pytest.approx(rice.ppf(LEVELS), rel=ACCURACY)


@pytest.mark.parametrize("seed", range(4))
def test_imhofs_integral_gives_the_same_share(seed):
    """Whatever the shape and the bias, the share beyond each quantile is one less its level."""
    rng = np.random.default_rng(seed)
    variances, bias = 10.0 ** rng.uniform(-1, 0, 3), rng.standard_normal(3) * (0.3, 1.0, 2.0, 0.0)[seed]
    found = one(bias, variances)
    for level, quantile in zip(LEVELS, found.quantiles[0], strict=True):
        assert imhof(quantile, variances, bias) == pytest.approx(1 - level, abs=2e-6)


@pytest.mark.parametrize("variances", [(0.226, 0.360, 0.414), (0.201, 0.249, 0.550), (0.060, 0.073, 0.866)])
@pytest.mark.parametrize("bias", [(0, 0, 0), (0.1, -0.2, 0.3)])
def test_contours_around_all_three_axes_give_imhofs_share(variances, bias):
    """With little bias the contour leaves every variance's own branch point behind, and no root of M may take the wrong side of one."""
    variances, bias = np.array(variances), np.array(bias, float)
    found = one(bias, variances)
    for level, quantile in zip(LEVELS, found.quantiles[0], strict=True):
        assert imhof(quantile, variances, bias) == pytest.approx(1 - level, abs=3e-7)


@given(st.integers(0, 2**32 - 1), st.integers(0, 3), st.floats(-9, 9))
@settings(deadline=None, max_examples=200)
def test_turning_and_scaling_the_vector_changes_nothing(seed, rank, exponent):
    """Quantiles rise with the level, the mean lies below the root mean square, and length scales with the vector, of any rank."""
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((3, rank)) * 10.0 ** rng.uniform(-3, 0, rank)
    bias = rng.standard_normal(3) * 10.0 ** rng.uniform(-3, 1)
    turn, scale = np.linalg.qr(rng.standard_normal((3, 3)))[0], 10.0**exponent
    first = normal_length(bias[None], (root @ root.T)[None], LEVELS)
    turned, rooted = scale * (turn @ bias), scale * (turn @ root)
    second = normal_length(turned[None], (rooted @ rooted.T)[None], LEVELS)
    assert (np.diff(first.quantiles[0]) >= -ACCURACY * first.quantiles[0, -1]).all()
    assert first.mean[0] <= np.sqrt(first.mean_square[0]) * (1 + ACCURACY)
    assert second.mean[0] == pytest.approx(scale * first.mean[0], rel=ACCURACY)
    assert second.quantiles[0] == pytest.approx(scale * first.quantiles[0], rel=2 * ACCURACY)


def test_no_vector_changes_a_bit_of_its_neighbours():
    """Vectors of any rank, alone and among others, that are turned to their axes side by side."""
    rng = np.random.default_rng(3)
    roots = rng.standard_normal((21, 3, 3)) * 10.0 ** rng.uniform(-9, 0, (21, 1, 3))
    bias, covariance = rng.standard_normal((21, 3)), roots @ np.swapaxes(roots, 1, 2)
    together = normal_length(bias, covariance, LEVELS)
    for n in range(21):
        alone = normal_length(bias[n : n + 1], covariance[n : n + 1], LEVELS)
        assert (alone.mean[0], *alone.quantiles[0]) == (together.mean[n], *together.quantiles[n])


@given(st.integers(0, 2**32 - 1), st.integers(1, 3))
@settings(deadline=None, max_examples=100)
def test_the_share_below_a_quantile_is_its_level(seed, rank):
    """Quantiles and shares are each other's inverse, and shares are 0 and 1 far away."""
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((3, rank)) * 10.0 ** rng.uniform(-1, 0, rank)
    bias, covariance = rng.standard_normal((1, 3)), (root @ root.T)[None]
    quantiles = normal_length(bias, covariance, LEVELS).quantiles[0]
    far = quantiles[-1] + np.array([1e2, 1e6])
    shares, densities, left = share_and_density(bias, covariance, [0.0, -1.0, *quantiles, *far])
    assert shares[0, [0, 1, -2, -1]] == pytest.approx([0, 0, 1, 1], abs=2e-6)
    assert (np.abs(shares[0, 2:-2] - LEVELS) < WORST * quantiles * densities[0, 2:-2] + 2e-6).all()
    assert not left.any()


def test_nearly_all_quantiles_are_as_sure_as_said():
    """Of 5 000 vectors, most of them flat: one quantile in a thousand may be off by more than the stated share of itself, none by the worst."""
    rng = np.random.default_rng(7)
    off = []
    for k in range(5000):
        root = rng.standard_normal((3, 1 + k % 3)) * 10.0 ** rng.uniform(-1, 0, 1 + k % 3)
        bias, covariance = rng.standard_normal((1, 3)), (root @ root.T)[None]
        quantiles = normal_length(bias, covariance, (0.5, 0.95, 0.99, 0.997)).quantiles[0]
        shares, densities, _ = share_and_density(bias, covariance, quantiles)
        off.append(np.abs(shares[0] - [0.5, 0.95, 0.99, 0.997]) / (densities[0] * quantiles))
    assert (np.array(off) > ACCURACY).mean() < 1e-3
    assert np.max(off) < WORST


def test_a_certain_length_is_told_exactly():
    """Without scatter the length is the bias; without anything it is zero; with almost none it is normal."""
    assert one([3, 4, 0], [0, 0, 0]).quantiles[0] == pytest.approx(5, rel=1e-15)
    assert one([3, 4, 0], [0, 0, 0]).mean[0] == pytest.approx(5, rel=1e-15)
    assert not one([0, 0, 0], [0, 0, 0]).quantiles.any()
    found = one([1, 0, 0], [1e-12, 4e-12, 0])
    assert found.quantiles[0] - 1 == pytest.approx(1e-6 * stats.norm.ppf(LEVELS) + 2e-12, abs=1e-13)
    assert share_below(np.zeros((1, 3)), np.zeros((1, 3, 3)), [0.0])[0] == 1


def test_what_is_no_number_gives_none():
    """A bias that is not a number gives NaN, not a figure; shapes that do not fit and levels out of reach are refused."""
    assert np.isnan(one([np.nan, 0, 0], [1, 1, 1]).mean).all()
    assert np.isnan(one([0, 0, 0], [np.nan, 1, 1]).quantiles).all()
    across = np.eye(3)[None].repeat(2, axis=0)
    across[0, 0, 1] = np.inf
    found = normal_length(np.zeros((2, 3)), across, LEVELS)
    assert np.isnan(found.mean).tolist() == [True, False]
    assert np.isnan(found.quantiles).all(axis=1).tolist() == [True, False]
    with pytest.raises(ValueError, match=r"\(n, 3, 3\)"):
        normal_length(np.zeros((2, 3)), np.zeros((1, 3, 3)))
    with pytest.raises(ValueError, match="levels"):
        one([0, 0, 0], [1, 1, 1], (0.1,))


def test_dense_samples_agree():
    """Four million samples of a slanted, biased normal vector: mean and quantiles within five standard errors."""
    rng = np.random.default_rng(1)
    root, bias = np.array([[1.0, 0.5, 0], [0, 0.7, 0.2], [0.3, 0, 0.1]]), np.array([0.5, -0.2, 0.1])
    lengths = np.linalg.norm(bias + rng.standard_normal((4_000_000, 3)) @ root.T, axis=1)
    found = normal_length(bias[None], (root @ root.T)[None], LEVELS)
    assert found.mean[0] == pytest.approx(lengths.mean(), rel=2e-3)
    below = (lengths[:, None] < found.quantiles[0]).mean(axis=0)
    assert np.abs(below - LEVELS).max() < 5 * np.sqrt(0.25 / len(lengths))


def test_no_change_of_a_called_file_is_missed():
    """Compiled code is kept by the text of its own file, which names the digest of every file that it calls (put the new one there)."""
    folder = Path(kernel.__file__).parent
    for name, digest in (*kernel.BEHIND.items(), *means_kernel.BEHIND.items()):
        assert hashlib.blake2b((folder / f"{name}.py").read_bytes(), digest_size=8).hexdigest() == digest, name


def form_of(directions, excess):
    """Give the quartic form (1, 15) of independent terms along `directions` (term, 3)."""
    out = []
    for i, j, k in FOURTHS:
        many = factorial(4) / (factorial(i) * factorial(j) * factorial(k))
        out.append(many * np.sum(excess * directions[:, 0] ** i * directions[:, 1] ** j * directions[:, 2] ** k))
    return np.array([out])


@pytest.mark.parametrize("count", [6, 12, 24])
def test_a_sum_of_uniforms_on_a_line_is_told_within_its_bound(count):
    """|sum of n uniforms| against Irwin and Hall's exact law: the fourth cumulants take most of the normal law's error away."""
    directions = np.tile([1.0, 0, 0], (count, 1))
    form = form_of(directions, np.full(count, Uniform().excess))
    covariance = np.diag([float(count), 0, 0])[None]
    found = normal_length(np.zeros((1, 3)), covariance, (0.5, 0.95, 0.99), form)
    plain = normal_length(np.zeros((1, 3)), covariance, (0.5, 0.95, 0.99))
    exact = np.array([stats.irwinhall(count).ppf((1 + level) / 2) - count / 2 for level in (0.5, 0.95, 0.99)]) * 2 * np.sqrt(3)
    wrong = np.abs(found.quantiles[0] - exact)
    assert (wrong <= found.quantiles_left[0] + ACCURACY * exact).all()
    assert wrong.sum() < 0.3 * np.abs(plain.quantiles[0] - exact).sum()


@pytest.mark.parametrize("rank", [1, 2, 3])
def test_a_vector_without_mean_is_the_limit_of_one_with_hardly_any(rank):
    """Where mean and third cumulants are zero the sums are shorter: the same figures and bounds as those of a mean that changes nothing."""
    rng = np.random.default_rng(rank)
    directions = np.zeros((9, 3))
    directions[:, :rank] = rng.standard_normal((9, rank))
    form, covariance = form_of(directions, rng.choice([-1.2, -0.6, 0.4], 9)), (directions.T @ directions)[None]
    none, hardly = (normal_length(np.full((1, 3), mean), covariance, LEVELS, form) for mean in (0.0, 1e-9))
    assert none.mean == pytest.approx(hardly.mean, rel=1e-8)
    assert none.mean_left == pytest.approx(hardly.mean_left, rel=1e-6)
    assert none.quantiles == pytest.approx(hardly.quantiles, rel=1e-7)
    assert none.quantiles_left == pytest.approx(hardly.quantiles_left, rel=1e-5)


def test_one_two_sided_draw_is_no_normal_vector():
    """A single play has the length 1, always; the law that has a density says itself that it is far off."""
    form = form_of(np.array([[1.0, 0, 0]]), np.array([TwoSided().excess]))
    found = normal_length(np.zeros((1, 3)), np.diag([1.0, 0, 0])[None], (0.5, 0.95), form)
    left = found.quantiles_left[0]
    assert ((left > 0.1) | np.isnan(left)).all()


@pytest.mark.parametrize("seed", range(12))
def test_few_flat_and_wavy_draws_are_told_within_their_bound(seed):
    """Sums of 5 to 24 uniform, two-sided, wavy and cut normal draws, with and without bias: samples lie within what is said to be left out."""
    rng = np.random.default_rng(seed)
    laws = [(Uniform(), TwoSided(), Cosine(), Normal())[k] for k in rng.integers(0, 4, rng.integers(5, 25))]
    directions = rng.standard_normal((len(laws), 3))
    bias = rng.standard_normal(3) * rng.choice([0, 1, 3, 10])
    form = form_of(directions, np.array([law.excess for law in laws]))
    levels = (0.5, 0.95, 0.99)
    found = normal_length(bias[None], (directions.T @ directions)[None], levels, form)
    draws = np.array([law.quantile(rng.random(400_000)) for law in laws])
    lengths = np.linalg.norm(bias[:, None] + directions.T @ draws, axis=0)
    noise = 4 * lengths.std() / np.sqrt(len(lengths))
    assert abs(found.mean[0] - lengths.mean()) <= found.mean_left[0] + noise
    assert (np.abs(found.quantiles[0] - np.quantile(lengths, levels)) <= found.quantiles_left[0] + noise * np.array([2, 4, 8])).all()
