"""Play that a load closes once it overcomes friction, which differs from robot to robot."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from lostmotion.laws.clearance import closed_share
from lostmotion.laws.distributions import of_tolerance
from lostmotion.units import Toleranced

TABLE = ((-1.0, 0.0), (-0.2, 0.3), (0.5, 0.4), (1.0, 1.0))


@given(
    st.lists(st.floats(0, 1e6), min_size=2, max_size=20),
    st.floats(0, 1e6),
    st.just(0.0) | st.floats(1e-6, 1),
    st.sampled_from(["normal", "uniform", TABLE]),
)
@settings(deadline=None, max_examples=200)
def test_a_larger_load_closes_the_play_in_more_robots(loads, friction, scatter, law):
    """Whatever the friction and its scatter, the share of robots whose play is closed rises with
    the load, from none to all.
    """
    load = np.sort(loads)
    share = closed_share(
        load, Toleranced(friction, scatter * friction, law), np.full(len(load), 1.0)
    )
    assert ((share >= 0) & (share <= 1)).all()
    assert (np.diff(share) >= 0).all()
    assert (share[load > friction * (1 + scatter) + 1e-3] == 1).all()
    assert (share[load < friction * (1 - scatter) - 1e-3] == 0).all()


def test_a_scatter_of_next_to_nothing_is_a_threshold():
    """Friction of the smallest number that there is, ±50 %: loads above it close the play, and no
    figure overflows.
    """
    share = closed_share(np.array([0.0, 1.0, 1e6]), Toleranced(2.2e-309, 1.1e-309), np.zeros(3))
    np.testing.assert_array_equal(share, [0, 1, 1])


def test_without_friction_any_load_closes_the_play():
    """Without friction the smallest load closes the play in every robot; no load leaves it open."""
    np.testing.assert_array_equal(
        closed_share(np.array([1e-3, 0.0, 5.0]), Toleranced(0.0), np.full(3, 5.0)), [1, 0, 1]
    )


def test_friction_without_scatter_is_a_threshold():
    """The play is open in all robots below the friction, and closed in all from it on."""
    np.testing.assert_array_equal(
        closed_share(np.array([0.0, 1.0, 1.999, 2.0, 9.0]), Toleranced(2.0), np.full(5, 9.0)),
        [0, 0, 0, 1, 1],
    )


def test_the_share_of_robots_is_that_of_frictions_below_the_load():
    """For friction 1 ±50 %, a normal distribution cut at three sigma, and for a uniform one, by
    SciPy; 0.9 closes the play in 27.36 % of robots.
    """
    load = np.array([0.4, 0.6, 0.9, 1.0, 1.2, 1.6])
    normal, uniform = (
        closed_share(load, Toleranced(1.0, 0.5, law), np.ones(6)) for law in ("normal", "uniform")
    )
    np.testing.assert_allclose(
        normal, stats.truncnorm(-3, 3, loc=1.0, scale=0.5 / 3).cdf(load), atol=1e-15
    )
    np.testing.assert_allclose(uniform, stats.uniform(0.5, 1.0).cdf(load), atol=1e-15)
    assert normal[2] == pytest.approx(0.2736, abs=5e-5)
    endless = closed_share(load, Toleranced(1.0, 0.5, "normal without limits"), np.ones(6))
    np.testing.assert_allclose(endless, stats.norm(1.0, 0.5 / 3).cdf(load), atol=1e-15)


@pytest.mark.parametrize("law", ["normal", "uniform", "normal without limits", TABLE])
def test_the_share_below_an_amount_is_the_inverse_of_the_draws(law):
    """An amount that a share of robots stays below is the quantile of the draws at that share."""
    distribution, u = of_tolerance(law), np.linspace(0.01, 0.99, 99)
    amounts = distribution.quantile(u) / distribution.stated + distribution.mean
    np.testing.assert_allclose(distribution.share_below(amounts), u, atol=1e-12)


@pytest.mark.parametrize("friction", [0.0, 1e-9])
def test_rounding_is_not_a_load(friction: float):
    """A load of 1e-10 of the whole wrench is rounding and closes nothing; one of 1e-8 is a load."""
    assert closed_share(np.array([1e-7]), Toleranced(friction), np.full(1, 1e3)) == 0
    assert closed_share(np.array([1e-5]), Toleranced(friction), np.full(1, 1e3)) == 1
