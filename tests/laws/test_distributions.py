"""Probability distributions against numerical quadrature and SciPy's own distributions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from lostmotion.laws.distributions import (
    Cosine,
    Law,
    Normal,
    Sine,
    TwoSided,
    Uniform,
    of_tolerance,
    product_mean,
)

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "distributions",
        "quadrature of mean and variance; SciPy",
        "1e-6",
        "laws/distributions.py",
    ),
)

LAWS: dict[str, Law] = {
    "normal cut at 3": Normal(),
    "normal cut at 0.5": Normal(0.5),
    "normal cut at 6": Normal(6.0),
    "normal": Normal(math.inf),
    "uniform": Uniform(),
    "two-sided": TwoSided(),
    "cosine": Cosine(),
    "sine": Sine(),
}


def moments(law: Law, power: int) -> float:
    """Integrate draw^power over the uniforms: Gauss-Legendre on panels that thicken towards both
    ends, where inverse normal laws rise.
    """
    edges = np.concatenate([[0.0], np.logspace(-14, -2, 49), np.linspace(0.01, 0.5, 99)[1:]])
    edges = np.concatenate([edges, 1 - edges[-2::-1]])
    x, w = np.polynomial.legendre.leggauss(20)
    half = np.diff(edges) / 2
    u = (edges[:-1] + half)[:, None] + half[:, None] * x
    inside = np.clip(u, 1e-300, 1 - 2.0**-53)
    return float(np.sum(law.quantile(inside) ** power * half[:, None] * w))


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_a_draw_has_mean_zero(law: Law):
    """Draws of every distribution have mean zero, so a mean must be stated as a design term."""
    assert moments(law, 1) == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_a_draw_has_mean_square_one(law: Law):
    """Draws of every distribution have mean square one, so a term's screw is its standard
    deviation.
    """
    assert moments(law, 2) == pytest.approx(1, abs=1e-6)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_the_bound_is_the_supremum_of_the_draws(law: Law):
    """The bound of a distribution is its largest draw: none is beyond it, and some come arbitrarily
    close.
    """
    u = np.concatenate([np.linspace(0, 1, 100_003)[1:-1], [2.0**-53, 1 - 2.0**-53]])
    largest = np.abs(law.quantile(u)).max()
    assert largest <= law.bound * (1 + 1e-12)
    if math.isfinite(law.bound):
        assert largest == pytest.approx(law.bound, rel=1e-4)


@pytest.mark.parametrize("cut", [0.1, 0.5, 1.0, 2.0, 3.0, 5.0])
def test_a_truncated_normal_law_is_scipys(cut: float):
    """A normal law truncated at c of its standard deviations has the deviation and quantiles of
    SciPy's truncated normal.
    """
    scipys = stats.truncnorm(-cut, cut)
    assert cut / Normal(cut).bound == pytest.approx(scipys.std(), rel=1e-9)
    u = np.linspace(0.001, 0.999, 41)
    np.testing.assert_allclose(
        Normal(cut).quantile(u), scipys.ppf(u) / scipys.std(), rtol=1e-9, atol=1e-12
    )


def test_a_tolerance_is_three_sigma_of_a_truncated_normal_law():
    """Of parts within ± t cut at three sigma, the deviation is t / 3.0408, a little less than t /
    3.
    """
    assert Normal().bound == pytest.approx(
        3 / math.sqrt(1 - 6 * stats.norm.pdf(3) / (2 * stats.norm.cdf(3) - 1)), rel=1e-12
    )
    assert Normal().bound == pytest.approx(3.0408, abs=5e-5)


def test_the_two_components_of_a_harmonic_share_one_phase():
    """Cosine and sine of the same uniform lie on one circle, so a harmonic of random phase never
    exceeds its amplitude.
    """
    u = np.linspace(0.0005, 0.9995, 1000)
    np.testing.assert_allclose(
        np.hypot(Cosine().quantile(u), Sine().quantile(u)), math.sqrt(2), rtol=1e-14
    )


def test_the_word_of_a_tolerance_names_its_distribution():
    """A dimension marked "uniform" is uniform; any other is normal, truncated at three sigma by its
    limits.
    """
    assert of_tolerance("uniform") == Uniform()
    assert of_tolerance("normal") == Normal(3.0)


@pytest.mark.parametrize(
    ("law", "excess"),
    [
        (Uniform(), -1.2),
        (TwoSided(), -2.0),
        (Cosine(), -1.5),
        (Sine(), -1.5),
        (Normal(math.inf), 0.0),
    ],
)
def test_the_fourth_cumulants_are_the_closed_forms(law: Law, excess: float):
    """Fourth cumulants of the unit distributions have closed forms."""
    assert product_mean((law,) * 4) - 3 == pytest.approx(excess, abs=1e-9)


@pytest.mark.parametrize("cut", [1.0, 2.0, 3.0, 5.0])
def test_the_fourth_cumulant_of_a_truncated_normal_law_is_scipys(cut: float):
    """Truncation makes a normal law platykurtic."""
    assert product_mean((Normal(cut),) * 4) - 3 == pytest.approx(
        float(stats.truncnorm(-cut, cut).stats(moments="k")), abs=1e-8
    )


def test_means_of_products_from_one_uniform():
    """The two components of a harmonic are uncorrelated but not independent."""
    assert product_mean((Cosine(), Sine())) == pytest.approx(0, abs=1e-12)
    assert product_mean((Cosine(), Cosine(), Sine(), Sine())) == pytest.approx(0.5, abs=1e-12)
    assert product_mean(()) == pytest.approx(1, abs=1e-12)
