"""Share of the workspace within a target, its size, and bounds of the cells' figures, against brute
force on an arm of three joints.
"""

import dataclasses

import numpy as np
import pytest
from scipy.stats import binomtest

from lostmotion.error_model.poses import Poses
from lostmotion.maps.accuracy_map import map_workspace
from lostmotion.maps.cell_statistics import (
    CONFIGURATIONS,
    MEAN,
    QUANTILE,
    PoseErrors,
    bounds_by_cell,
    cell_figures,
    errors,
)
from lostmotion.maps.request import MapRequest
from lostmotion.propagation.analytic import analytic
from tests.maps.test_map_reach import FORE, HEIGHT, UPPER, configurations, turret

pytestmark = pytest.mark.usual_counts
PARTS = {
    "S": {"encoder": {"zero": "0.4 mrad"}},
    "A": {"encoder": {"zero": "0.5 mrad"}, "gearbox": {"ratio": 100, "stiffness": "25000 N m/rad"}},
    "B": {"encoder": {"zero": "1 mrad"}, "gearbox": {"ratio": 100, "stiffness": "14000 N m/rad"}},
}
EDGE = 0.2
MEANT = CONFIGURATIONS.index("mean")


@pytest.fixture(scope="module")
def truth():
    """Return figures by the mean over all configurations at many points sampled over the workspace,
    and its size, m^3.
    """
    arm, reach = turret(**PARTS), UPPER + FORE
    drawn = np.random.default_rng(4).uniform(-reach, reach, (12_000, 3)) + np.array([0, 0, HEIGHT])
    found = [configurations(point) for point in drawn]
    at = np.repeat(np.arange(len(drawn)), [len(each) for each in found])
    told = analytic(
        arm, Poses(np.vstack([q for each in found for q in each]), "given"), levels=(0.95,)
    )
    assert told.valid.all()
    counts = np.bincount(at, minlength=len(drawn))
    sums = np.bincount(at, told.quantiles[:, 0], len(drawn))
    return (sums[counts > 0] / counts[counts > 0]), float(np.mean(counts > 0)) * (2 * reach) ** 3


@pytest.fixture(scope="module")
def coarse():
    """Map the arm with cells as large as its links."""
    return map_workspace(turret(**PARTS), MapRequest(cell=EDGE, poses=8000))


def test_a_target_that_no_cell_keeps_has_a_share_all_the_same(truth, coarse):
    """Where no centre of a coarse cell meets the target, the share and its interval are those of
    the points between the centres.
    """
    values, _ = truth
    plain = coarse
    target = 0.999 * float(np.nanmin(plain.selected[plain.centre]))
    true = float(np.mean(values <= target))
    assert true > 0.005
    found = map_workspace(
        turret(**PARTS), MapRequest(cell=EDGE, poses=8000, target=target)
    ).within_target
    assert not (found.cells & plain.centre).any()
    assert found.share.low < true < found.share.high
    assert found.share.high > found.share.value > 0
    nowhere, nothing = plain.validation.share(QUANTILE, "mean", 1e-9)
    count = len(plain.validation.points)
    assert (nowhere.value, nowhere.low) == (0, 0)
    assert nowhere.high == pytest.approx(binomtest(0, count).proportion_ci().high)
    assert nothing.high > 0
    everywhere, _ = plain.validation.share(QUANTILE, "mean", 1.0)
    assert (everywhere.value, everywhere.high) == (1, 1)
    assert everywhere.low == pytest.approx(binomtest(count, count).proportion_ci().low)


@pytest.mark.parametrize("edge", [pytest.param(0.05, marks=pytest.mark.slow), EDGE])
def test_share_and_size_hold_brute_force(truth, coarse, edge):
    """For fine and coarse cells, intervals of shares at several targets, median and volume cover,
    and are no wider than the counts imply.
    """
    values, volume = truth
    found = (
        coarse
        if edge == EDGE
        else map_workspace(turret(**PARTS), MapRequest(cell=edge, poses=8000))
    )
    assert found.size.low < volume < found.size.high
    assert found.size.high - found.size.low < 0.25 * volume
    for part in (0.1, 0.3, 0.5, 0.9):
        share, size = found.validation.share(QUANTILE, "mean", float(np.quantile(values, part)))
        assert share.low < part < share.high
        assert share.high - share.low < 0.15
        assert size.low < part * volume < size.high
    median = found.validation.quantile(QUANTILE, "mean", 0.5)
    assert median.low < np.median(values) < median.high
    assert median.high - median.low < 0.2 * median.value


def test_uncertain_figures_widen_the_interval(monkeypatch, coarse):
    """With uncertain figures the interval contains the share with each at its lower and at its
    upper bound.
    """
    by_itself = coarse
    target = float(np.median(by_itself.validation.figures[QUANTILE, MEANT]))

    def unsure(arm, poses, **options):
        found = analytic(arm, poses, **options)
        return dataclasses.replace(
            found, quantiles=1.2 * found.quantiles, quantiles_uncertainty=0.2 * found.quantiles
        )

    monkeypatch.setattr("lostmotion.maps.cell_statistics.analytic", unsure)
    raised = map_workspace(turret(**PARTS), MapRequest(cell=EDGE, poses=8000, target=target))
    assert not raised.evaluated.errors.valid.any()
    share, plain = (
        raised.within_target.share,
        by_itself.validation.share(QUANTILE, "mean", target)[0],
    )
    assert share.value < plain.low  # raised figures alone would leave the truth out
    assert share.low < plain.value < share.high


def test_cells_hold_the_mean_over_all_configurations():
    """At every centre the figures by hand, over all configurations with equal weight, are within
    the cell's bounds.
    """
    arm = turret(**PARTS)
    found = map_workspace(arm, MapRequest(cell=0.1, poses=8000))
    cells = np.flatnonzero(found.centre)
    real = [configurations(middle) for middle in found.reached.grid.centres(cells)]
    # Some middles lie a hair beyond a joint's limit, nearer than the middle of a cell has to be
    # met.
    cells, real = cells[[bool(each) for each in real]], [each for each in real if each]
    assert len(cells) > 300
    at = np.repeat(np.arange(len(cells)), [len(each) for each in real])
    expected = cell_figures(
        errors(arm, np.vstack([q for each in real for q in each]), 0.95), at, len(cells)
    )
    figures, bounds = (
        each.reshape(*each.shape[:-3], -1)[..., cells] for each in (found.errors, found.bounds)
    )
    assert figures == pytest.approx(expected, rel=2e-3)
    assert ((bounds[0] <= figures) & (figures <= bounds[1])).all()
    assert (bounds[1] - bounds[0] < 0.1 * figures).all()


def test_ends_of_cells_by_hand():
    """Bounds of all poses carry over to best, mean and worst; for sampled poses the mean's is
    Student's, and one bound of each extreme is unknown.
    """
    values, off = np.array([1.0, 2.0, 4.0, 3.0]), np.array([0.1, 0.3, 0.2, 0.5])
    found = PoseErrors(
        values,
        2 * values,
        np.stack([values - off, 2 * values - off]),
        np.stack([values + off, 2 * values + off]),
        np.ones(4, bool),
    )
    cell = np.array([0, 0, 0, 1])
    low, high = bounds_by_cell(found, cell, 3, np.zeros(3, bool))
    assert low[QUANTILE, :, 0] == pytest.approx([1.9, (1.9 + 3.7 + 7.8) / 3, 7.8])
    assert high[MEAN, :, 0] == pytest.approx([1.1, (1.1 + 2.3 + 4.2) / 3, 4.2])
    assert np.isnan(low[:, :, 2]).all()
    low, high = bounds_by_cell(found, cell, 3, np.ones(3, bool))
    # Student's t of two degrees of freedom, any table
    half = 4.302653 * np.std([1, 2, 4], ddof=1) / np.sqrt(3)
    assert high[MEAN, 1, 0] == pytest.approx((1.1 + 2.3 + 4.2) / 3 + half)
    assert low[MEAN, 1, 0] == 0  # no error is negative
    assert np.isnan(low[:, 0]).all()
    assert np.isnan(high[:, 2]).all()
    # of one pose nothing is known of the family
    assert np.isnan([low[:, 1, 1], high[:, 1, 1]]).all()
