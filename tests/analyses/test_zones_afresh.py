"""The share of the workspace within a target, its size, and the ends of cells' figures, against brute force on an arm of three joints."""

import dataclasses

import numpy as np
import pytest
from scipy.stats import binomtest

from lostmotion.analyses.workspace_map.cell_statistics import BYS, MEAN, QUANTILE, Errors, by_cell, ends_by_cell, errors
from lostmotion.analyses.workspace_map.map import Wish, zones
from lostmotion.error_model.poses import Poses
from lostmotion.propagation.analytic import analytic
from tests.analyses.test_zones_reach import FORE, HEIGHT, UPPER, configurations, turret

PARTS = {
    "S": {"encoder": {"zero": "0.4 mrad"}},
    "A": {"encoder": {"zero": "0.5 mrad"}, "gearbox": {"ratio": 100, "stiffness": "25000 N m/rad"}},
    "B": {"encoder": {"zero": "1 mrad"}, "gearbox": {"ratio": 100, "stiffness": "14000 N m/rad"}},
}
EDGE = 0.2
MEANT = BYS.index("mean")


@pytest.fixture(scope="module")
def truth():
    """Give figures by the mean over all configurations at many points drawn over the whole workspace, and its size, m^3."""
    arm, reach = turret(**PARTS), UPPER + FORE
    drawn = np.random.default_rng(4).uniform(-reach, reach, (12_000, 3)) + np.array([0, 0, HEIGHT])
    found = [configurations(point) for point in drawn]
    at = np.repeat(np.arange(len(drawn)), [len(each) for each in found])
    told = analytic(arm, Poses(np.vstack([q for each in found for q in each]), "given"), levels=(0.95,))
    assert told.valid.all()
    counts = np.bincount(at, minlength=len(drawn))
    sums = np.bincount(at, told.quantiles[:, 0], len(drawn))
    return (sums[counts > 0] / counts[counts > 0]), float(np.mean(counts > 0)) * (2 * reach) ** 3


@pytest.fixture(scope="module")
def coarse():
    """Map the arm by cells as large as its links."""
    return zones(turret(**PARTS), Wish(cell=EDGE, poses=8000))


def test_a_target_that_no_cell_keeps_has_a_share_all_the_same(truth, coarse):
    """Where no middle of a coarse cell is within the target, the share and its interval hold what points between the middles say."""
    values, _ = truth
    plain = coarse
    target = 0.999 * float(np.nanmin(plain.shown[plain.centre]))
    true = float(np.mean(values <= target))
    assert true > 0.005
    found = zones(turret(**PARTS), Wish(cell=EDGE, poses=8000, target=target)).within
    assert not (found.cells & plain.centre).any()
    assert found.share.low < true < found.share.high
    assert found.share.high > found.share.value > 0
    nowhere, nothing = plain.afresh.share(QUANTILE, "mean", 1e-9)
    count = len(plain.afresh.points)
    assert (nowhere.value, nowhere.low) == (0, 0)
    assert nowhere.high == pytest.approx(binomtest(0, count).proportion_ci().high)
    assert nothing.high > 0
    everywhere, _ = plain.afresh.share(QUANTILE, "mean", 1.0)
    assert (everywhere.value, everywhere.high) == (1, 1)
    assert everywhere.low == pytest.approx(binomtest(count, count).proportion_ci().low)


@pytest.mark.parametrize("edge", [pytest.param(0.05, marks=pytest.mark.slow), EDGE])
def test_share_and_size_hold_brute_force(truth, coarse, edge):
    """Of fine cells and of coarse ones: shares at several targets, the median and the volume; intervals no wider than points of that count leave."""
    values, volume = truth
    found = coarse if edge == EDGE else zones(turret(**PARTS), Wish(cell=edge, poses=8000))
    assert found.size.low < volume < found.size.high
    assert found.size.high - found.size.low < 0.25 * volume
    for part in (0.1, 0.3, 0.5, 0.9):
        share, size = found.afresh.share(QUANTILE, "mean", float(np.quantile(values, part)))
        assert share.low < part < share.high
        assert share.high - share.low < 0.15
        assert size.low < part * volume < size.high
    median = found.afresh.quantile(QUANTILE, "mean", 0.5)
    assert median.low < np.median(values) < median.high
    assert median.high - median.low < 0.2 * median.value


def test_uncertain_figures_widen_the_interval(monkeypatch, coarse):
    """Where figures are uncertain, the interval holds the share with each at its low end and at its high end."""
    by_itself = coarse
    target = float(np.median(by_itself.afresh.figures[QUANTILE, MEANT]))

    def unsure(arm, poses, **options):
        found = analytic(arm, poses, **options)
        return dataclasses.replace(found, quantiles=1.2 * found.quantiles, quantiles_uncertainty=0.2 * found.quantiles)

    monkeypatch.setattr("lostmotion.analyses.workspace_map.cell_statistics.analytic", unsure)
    raised = zones(turret(**PARTS), Wish(cell=EDGE, poses=8000, target=target))
    assert not raised.looked.errors.valid.any()
    share, plain = raised.within.share, by_itself.afresh.share(QUANTILE, "mean", target)[0]
    assert share.value < plain.low  # raised figures alone would leave the truth out
    assert share.low < plain.value < share.high


def test_cells_hold_the_mean_over_all_configurations():
    """At every middle: the figures by hand over all configurations there, each weighed alike, lie between the ends that the cell states."""
    arm = turret(**PARTS)
    found = zones(arm, Wish(cell=0.1, poses=8000))
    cells = np.flatnonzero(found.centre)
    real = [configurations(middle) for middle in found.reached.grid.centres(cells)]
    # Some middles lie a hair beyond a joint's limit, nearer than the middle of a cell has to be met.
    cells, real = cells[[bool(each) for each in real]], [each for each in real if each]
    assert len(cells) > 300
    at = np.repeat(np.arange(len(cells)), [len(each) for each in real])
    expected = by_cell(errors(arm, np.vstack([q for each in real for q in each]), 0.95), at, len(cells))
    figures, ends = (each.reshape(*each.shape[:-3], -1)[..., cells] for each in (found.figures, found.ends))
    assert figures == pytest.approx(expected, rel=2e-3)
    assert ((ends[0] <= figures) & (figures <= ends[1])).all()
    assert (ends[1] - ends[0] < 0.1 * figures).all()


def test_ends_of_cells_by_hand():
    """The ends of all poses pass on to best, mean and worst; of drawn poses the mean's is Student's, and one side of each extreme is open."""
    values, off = np.array([1.0, 2.0, 4.0, 3.0]), np.array([0.1, 0.3, 0.2, 0.5])
    found = Errors(values, 2 * values, np.stack([values - off, 2 * values - off]), np.stack([values + off, 2 * values + off]), np.ones(4, bool))
    cell = np.array([0, 0, 0, 1])
    low, high = ends_by_cell(found, cell, 3, np.zeros(3, bool))
    assert low[QUANTILE, :, 0] == pytest.approx([1.9, (1.9 + 3.7 + 7.8) / 3, 7.8])
    assert high[MEAN, :, 0] == pytest.approx([1.1, (1.1 + 2.3 + 4.2) / 3, 4.2])
    assert np.isnan(low[:, :, 2]).all()
    low, high = ends_by_cell(found, cell, 3, np.ones(3, bool))
    half = 4.302653 * np.std([1, 2, 4], ddof=1) / np.sqrt(3)  # Student's t of two degrees of freedom, any table
    assert high[MEAN, 1, 0] == pytest.approx((1.1 + 2.3 + 4.2) / 3 + half)
    assert low[MEAN, 1, 0] == 0  # no error is negative
    assert np.isnan(low[:, 0]).all()
    assert np.isnan(high[:, 2]).all()
    assert np.isnan([low[:, 1, 1], high[:, 1, 1]]).all()  # of one pose nothing is known of the family
