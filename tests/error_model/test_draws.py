"""Draws of robots and of visits."""

import numpy as np
import pytest
from scipy import stats

from lostmotion.error_model.draw_kernel import LANES, TABLE
from lostmotion.error_model.draws import Stream, robot_draws, uniforms, visit_draws
from lostmotion.error_model.pose_matrix import screws
from lostmotion.laws.distributions import Cosine, Normal, Sine, TwoSided, Uniform
from tests.conftest import arm_of


def test_uniforms_are_uniform_and_a_longer_run_begins_with_a_shorter_one():
    """The stream passes a Kolmogorov-Smirnov test, stays inside 0..1 and does not change its beginning."""
    u = uniforms(1, "joints.A.gearbox.side", 20_000)
    assert stats.kstest(u, "uniform").pvalue > 1e-3
    assert u.min() > 0
    assert u.max() < 1
    np.testing.assert_array_equal(u[:50], uniforms(1, "joints.A.gearbox.side", 50))


def test_streams_of_other_names_or_seeds_have_nothing_in_common():
    """Correlation between two names, and between two seeds, is that of independent numbers."""
    first = uniforms(1, "a", 20_000)
    for other in (uniforms(1, "b", 20_000), uniforms(2, "a", 20_000)):
        assert abs(np.corrcoef(first, other)[0, 1]) < 4 / np.sqrt(20_000)


@pytest.mark.parametrize("law", [Normal(), Uniform(), TwoSided(), Cosine()])
def test_visit_draws_have_the_moments_of_their_law_and_do_not_repeat(law):
    """Over poses, robots and visits the draws have mean 0 and variance 1, and one visit or pose says nothing of the next."""
    robot, visit = (x.ravel() for x in np.meshgrid(np.arange(300), np.arange(40), indexing="ij"))
    values = np.stack([visit_draws(3, [Stream("s", law)], pose, robot, visit)[0] for pose in range(20)]).reshape(20, 300, 40)
    assert abs(values.mean()) < 5 / np.sqrt(values.size)
    assert values.var() == pytest.approx(1, abs=8 / np.sqrt(values.size))
    for a, b in ((values[:, :, :-1], values[:, :, 1:]), (values[:-1], values[1:])):
        assert abs(np.corrcoef(a.ravel(), b.ravel())[0, 1]) < 5 / np.sqrt(a.size)
    # neighbouring robots read neighbouring entries of one table
    assert abs(np.corrcoef(values[:, :-1].ravel(), values[:, 1:].ravel())[0, 1]) < 4 / np.sqrt(TABLE)


def test_the_two_parts_of_a_harmonic_share_their_phase():
    """Cosine and sine of one stream lie on a circle of radius sqrt 2, for robots and for visits."""
    pair = [Stream("wave", Cosine()), Stream("wave", Sine())]
    of_robots = robot_draws(1, pair, LANES)
    np.testing.assert_allclose((of_robots**2).sum(axis=1), 2.0, rtol=1e-12)
    of_visits = visit_draws(1, pair, 4, np.arange(50), np.arange(50))
    np.testing.assert_allclose((of_visits**2).sum(axis=0), 2.0, rtol=1e-12)


def test_a_new_error_source_leaves_all_other_draws_alone():
    """The same arm with an encoder more: every term that both have has the same draws."""
    bare, more = arm_of(encoder=None), arm_of()
    q = np.zeros((1, 3))
    known = {(info.name, info.robot, info.visit) for info in screws(more, q).infos}
    assert {(info.name, info.robot, info.visit) for info in screws(bare, q).infos} < known
