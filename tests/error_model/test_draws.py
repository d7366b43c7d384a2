"""Random draws per robot and per visit."""

import numpy as np
import pytest
from scipy import stats

from lostmotion.error_model.draw_kernel import LANES, TABLE
from lostmotion.error_model.draws import Stream, robot_draws, uniforms, visit_draws
from lostmotion.error_model.pose_matrix import screws
from lostmotion.laws.distributions import Cosine, Normal, Sine, TwoSided, Uniform
from lostmotion.mechanism.state import state_of
from tests.arms import arm_of


def test_a_stream_is_uniform_and_a_longer_one_begins_with_a_shorter_one():
    """A stream passes a Kolmogorov-Smirnov test, lies between 0 and 1, and begins with the same
    values at any length.
    """
    u = uniforms(1, "joints.A.gearbox.side", 20_000)
    assert stats.kstest(u, "uniform").pvalue > 1e-3
    assert u.min() > 0
    assert u.max() < 1
    np.testing.assert_array_equal(u[:50], uniforms(1, "joints.A.gearbox.side", 50))


def test_streams_of_different_names_or_seeds_are_uncorrelated():
    """Streams with different names or seeds have the correlation of independent numbers."""
    first = uniforms(1, "a", 20_000)
    for other in (uniforms(1, "b", 20_000), uniforms(2, "a", 20_000)):
        assert abs(np.corrcoef(first, other)[0, 1]) < 4 / np.sqrt(20_000)


@pytest.mark.parametrize("law", [Normal(), Uniform(), TwoSided(), Cosine()])
def test_visit_draws_are_standardised_and_uncorrelated(law):
    """Draws per visit have mean 0 and variance 1, and are uncorrelated between visits, poses and
    robots.
    """
    robot, visit = (x.ravel() for x in np.meshgrid(np.arange(300), np.arange(40), indexing="ij"))
    values = np.stack(
        [visit_draws(3, [Stream("s", law)], pose, robot, visit)[0] for pose in range(20)]
    ).reshape(20, 300, 40)
    assert abs(values.mean()) < 5 / np.sqrt(values.size)
    assert values.var() == pytest.approx(1, abs=8 / np.sqrt(values.size))
    for a, b in ((values[:, :, :-1], values[:, :, 1:]), (values[:-1], values[1:])):
        assert abs(np.corrcoef(a.ravel(), b.ravel())[0, 1]) < 5 / np.sqrt(a.size)
    # adjacent robots read adjacent entries of one table
    assert abs(np.corrcoef(values[:, :-1].ravel(), values[:, 1:].ravel())[0, 1]) < 4 / np.sqrt(
        TABLE
    )


def test_sine_and_cosine_of_a_harmonic_share_their_phase():
    """The cosine and sine draws of one stream lie on a circle of radius sqrt 2, per robot and per
    visit.
    """
    pair = [Stream("phase", Cosine()), Stream("phase", Sine())]
    of_robots = robot_draws(1, pair, LANES)
    np.testing.assert_allclose((of_robots**2).sum(axis=1), 2.0, rtol=1e-12)
    of_visits = visit_draws(1, pair, 4, np.arange(50), np.arange(50))
    np.testing.assert_allclose((of_visits**2).sum(axis=0), 2.0, rtol=1e-12)


def test_a_new_error_source_changes_no_other_draws():
    """An arm with an added encoder has the same streams for all other terms."""
    bare, more = arm_of(encoder=None), arm_of()
    q = np.zeros((1, 3))
    known = {(info.name, info.robot, info.visit) for info in screws(state_of(more, q)).infos}
    assert {(info.name, info.robot, info.visit) for info in screws(state_of(bare, q)).infos} < known
