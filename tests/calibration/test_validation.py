"""Held-out measurements against their predictions."""

from __future__ import annotations

import numpy as np
import pytest

from lostmotion.calibration.validation import HeldOut

FOLDS = np.repeat(np.arange(5), 40)


def held(worse: float) -> HeldOut:
    """Return 200 measurements of points in five regions, of which one has `worse` times the
    deviation that is predicted.
    """
    distances = np.random.default_rng(1).chisquare(3, 200) * np.where(FOLDS == 2, worse**2, 1.0)
    return HeldOut(np.sqrt(distances), distances, 3, FOLDS)


def test_coverage_is_that_of_regions_which_set_no_factor():
    """Where one region is predicted worse than all others its measurements are beyond theirs,
    though one factor could inflate the covariances such that 95 % of all were within.
    """
    assert 0.92 <= held(1.0).coverage <= 0.99
    assert held(4.0).within(held(4.0).inflation).mean() == pytest.approx(0.95, abs=0.01)
    assert held(4.0).coverage < 0.9
    assert held(4.0).covered[FOLDS != 2].mean() > 0.99
