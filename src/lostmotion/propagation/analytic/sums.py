"""The sums over an arm's terms: bias, covariance, third and fourth cumulants of the error at every pose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.laws.normal_length_forms_kernel import FOURTHS, THIRDS, add_up

if TYPE_CHECKING:
    from collections.abc import Collection

    from lostmotion.error_model.cumulants import Cumulants
    from lostmotion.spatial import Floats


@dataclass(frozen=True, slots=True)
class Sums:
    """Of nearly normal errors: bias (n, 3) m, covariance (n, 3, 3) m^2, forms of the third (n, 10) m^3 and fourth cumulants (n, 15) m^4."""

    bias: Floats
    covariance: Floats
    third: Floats
    fourth: Floats

    @property
    def arrays(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Give all four."""
        return self.bias, self.covariance, self.third, self.fourth


def sums(shift: Floats, known: Cumulants, bias: Floats) -> Sums:
    """What do draws of these cumulants add up to? shift (3, term, pose) m per unit draw, contiguous; bias (pose, 3) is passed on."""
    count = shift.shape[2]
    pairs, third, fourth = np.zeros((6, count)), np.zeros((len(THIRDS), count)), np.zeros((len(FOURTHS), count))
    add_up(*(shift, known.pairs, known.pair_values, known.threes, known.three_values, known.fours, known.four_values, pairs, third, fourth))
    covariance = np.ascontiguousarray(pairs.T[:, [[0, 5, 4], [5, 1, 3], [4, 3, 2]]])
    return Sums(np.ascontiguousarray(bias), covariance, np.ascontiguousarray(third.T), np.ascontiguousarray(fourth.T))


def variance(shift: Floats, known: Cumulants, terms: Collection[int]) -> Floats:
    """Which mean square (pose,), m^2, do the draws of these terms alone add up to? shift (3, term, pose) m per unit draw."""
    out = np.zeros(shift.shape[2])
    inside = np.isin(known.pairs, list(terms)).all(axis=1)
    for (i, j), value in zip(known.pairs[inside], known.pair_values[inside], strict=True):
        out += value * (shift[:, i] * shift[:, j]).sum(axis=0)
    return out
