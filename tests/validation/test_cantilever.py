"""The beam law under chance: the cantilever that OpenTURNS publishes as a use case, F L^3 / (3 E I)
in metres.

E Beta(0.9, 3.5) on 65 … 75 GPa, F log-normal of mean 300 N and deviation 30 N, L uniform on 2.5 …
2.6 m, I Beta(2.5, 4) on 1.3e-7 … 1.7e-7 m^4, the last two joined by a normal copula of rank
correlation -0.2.
"""

import math

import numpy as np
import pytest
from scipy import stats
from scipy.stats import qmc

from lostmotion.laws.beam import prism
from lostmotion.laws.cross_sections import SectionValues, compliance_per_length

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "cantilever F L³/(3 E I), four distributions, two of them dependent",
        (
            "OpenTURNS's use case: first-order mean 0.1701111, standard deviation 0.0207523, 95th "
            "percentile 0.206806 m"
        ),
        "3e-7; 3e-4; 2e-3",
    ),
)

STIFF_IN_SHEAR = 1e18
RANK_CORRELATION = -0.2
SIGMA = math.sqrt(math.log(1 + (30 / 300) ** 2))
YOUNG = stats.beta(0.9, 3.5, 65e9, 10e9)
FORCE = stats.lognorm(SIGMA, scale=300 * math.exp(-(SIGMA**2) / 2))
LENGTH = stats.uniform(2.5, 0.1)
SECOND = stats.beta(2.5, 4, 1.3e-7, 4e-8)


def deflection(young, force, length, second):
    """Return how far the tip moves, by the beam law without its share of shear."""
    section = SectionValues(
        area=1e-3, i_y=second, i_z=second, torsion=2 * second, shear_y=1.0, shear_z=1.0
    )
    return (
        prism(length, [compliance_per_length(young, STIFF_IN_SHEAR, section)]).compliance_at(
            length
        )[0][4, 4]
        * force
    )


def test_the_cantilever_of_openturns():
    """First order: mean 0.1701111, deviation 0.0207523; 95 % of 16 384 points of a Sobol sequence
    below the published 0.206806.
    """
    laws = (YOUNG, FORCE, LENGTH, SECOND)
    middle = np.array([law.mean() for law in laws])
    assert deflection(*middle) == pytest.approx(0.1701111, abs=5e-8)
    slopes = [
        (deflection(*(middle + step)) - deflection(*(middle - step))) / (2 * step.max())
        for step in np.diag(1e-4 * middle)
    ]
    correlation = 2 * math.sin(math.pi * RANK_CORRELATION / 6)
    sobol = qmc.Sobol(4, rng=np.random.default_rng(1)).random_base2(14).clip(1e-12, 1 - 1e-12)
    normal = stats.norm.ppf(sobol)
    normal[:, 3] = correlation * normal[:, 2] + math.sqrt(1 - correlation**2) * normal[:, 3]
    drawn = np.column_stack(
        [law.ppf(u) for law, u in zip(laws, stats.norm.cdf(normal).T, strict=True)]
    )
    covariance = np.diag([law.var() for law in laws])
    covariance[2, 3] = covariance[3, 2] = np.cov(drawn[:, 2:].T)[0, 1]
    assert math.sqrt(slopes @ covariance @ slopes) == pytest.approx(0.0207523, rel=3e-4)
    sizes = [deflection(*point) for point in drawn]
    assert np.quantile(sizes, 0.95) == pytest.approx(0.206806, rel=2e-3)
