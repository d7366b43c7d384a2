"""A short study of a spoiled arm, and statements that hold of the figures of any arm whatever.

The whole study asks the same of thirty variants of the arm (remedies, halved tolerances, two
approaches): one in `EVERY` files is studied so.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.accuracy.study import refuse_beyond_histogram
from lostmotion.error_model.poses import sample_poses
from lostmotion.error_model.provenance import refuse_undescribed
from lostmotion.error_model.trust import with_figures
from lostmotion.propagation.error_samples import Drawn
from lostmotion.propagation.figures import figures_of
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.montecarlo import run

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.montecarlo.montecarlo import Sampled

EVERY: Final = 10
# Of rounding, in errors that are sums over hundreds of terms; and of lengths below which an error
# is one of rounding alone.
_ROUNDING: Final = 1e-9
_NOTHING: Final = 1e-15


def studied_shortly(arm: Arm) -> Sampled:
    """Sample the errors of a few robots at 16 poses, and hold their figures to what is true of any.

    Raises InputError as `study` does, AssertionError for figures that contradict each other.
    """
    refuse_undescribed(arm)
    poses = with_figures(arm, sample_poses(arm, 16))
    sampled = run(arm, poses, robots=32, visits=3, seed=1)
    refuse_beyond_histogram(arm, sampled)
    consistent(sampled)
    return sampled


def consistent(sampled: Sampled) -> None:
    """Refuse figures that cannot be of one arm: a mean above the r.m.s., percentiles out of order,
    a draw beyond the worst case, parts that do not add up, a value outside its interval.
    """
    per_pose, tally = sampled.per_pose, sampled.tally
    mean, square, largest = per_pose[:, [kernel.MEAN, kernel.MEAN_SQUARE, kernel.LARGEST]].T
    assert np.isfinite(per_pose[:, : kernel.FIRST_QUANTILE]).all()
    assert (mean >= 0).all()
    _in_order("mean and r.m.s.", mean, np.sqrt(square))
    _in_order("r.m.s. and largest", np.sqrt(square), largest)
    _in_order("largest and worst case", largest, sampled.worst)
    quantiles = per_pose[:, kernel.FIRST_QUANTILE :: 3].T
    for lower, higher in itertools.pairwise(quantiles):
        _in_order("percentiles", lower, higher)
    # Sampled and summed in closed form. The mean square of 32 robots of one normal error varies by
    # a quarter, and all poses see the same robots: a factor 4 is beyond five standard deviations.
    drawn, summed = float(square.mean()), tally.total / tally.poses
    assert summed / 4 - _NOTHING**2 <= drawn <= 4 * summed + _NOTHING**2, (drawn, summed)
    rest = float(np.abs(tally.shared.sum() - tally.total))
    assert rest <= _ROUNDING * max(tally.total, float(np.abs(tally.shared).sum())), rest
    assert (tally.own >= 0).all()
    errors = Drawn.of(sampled)
    for key, figure in figures_of(errors).items():
        if key.startswith("rms"):  # by the squares of a budget, not by the draws
            continue
        each = figure.of(errors)
        assert np.isfinite(each.value), key
        assert not each.low > each.value * (1 + _ROUNDING), (key, each.low, each.value)
        assert not each.high < each.value * (1 - _ROUNDING), (key, each.value, each.high)


def _in_order(what: str, lower: np.ndarray, higher: np.ndarray) -> None:
    wrong = lower > higher * (1 + _ROUNDING) + _NOTHING
    assert not wrong.any(), f"{what}: {lower[wrong][:3]}, {higher[wrong][:3]}"
