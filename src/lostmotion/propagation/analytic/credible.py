"""Where may a series about the normal law be believed, and where do lengths stand in steps that it does not see?"""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.cumulants import draws_of
from lostmotion.laws.distributions import Table, TwoSided
from lostmotion.laws.normal_length import WORST

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lostmotion.error_model.pose_matrix import TermInfo
    from lostmotion.laws.distributions import Law
    from lostmotion.spatial import Floats

# No figure of a pose is told where the next order may move one by this share of what the scatter alone would make of it: beside a large bias any
# figure is known to a small share of itself, however little is known of the scatter.
ODD: Final = 0.4
# Draws of two sides make lengths stand in steps, unless others smooth them: those have to scatter by these shares of their mean square, or the parts
# of a mixture, the series and a lattice do not see the steps.
SMOOTH_PARTS: Final = 0.2
SMOOTH: Final = 0.05


def of_two_sides(infos: Sequence[TermInfo], columns: NDArray[np.int64]) -> frozenset[int]:
    """Which of these terms stand on one side or the other, or near a few values of a table?"""
    return frozenset(k for k in columns.tolist() if any(_is_stepped(law) for _, _, law in draws_of(infos[k])))


def _is_stepped(law: Law) -> bool:
    return isinstance(law, TwoSided) or (isinstance(law, Table) and law.is_stepped)


def on_a_line(covariance: Floats, levels: Sequence[float]) -> Floats:
    """What were mean and quantiles (pose, figure), m, if all of the scatter lay on a line, were normal, and there were no bias?"""
    rms = np.sqrt(np.einsum("pii->p", covariance))
    return np.asarray(np.multiply.outer(rms, [math.sqrt(2 / math.pi), *(NormalDist().inv_cdf((1 + level) / 2) for level in levels)]))


def believable(figures: Floats, bounds: Floats, scatter: Floats, worst: Floats) -> NDArray[np.bool_]:
    """Which figures (pose, figure) have a bound that is small beside the scatter (`on_a_line`), and lie within the worst case? None without one."""
    possible = ~(figures > (1 + WORST) * worst[:, None])
    return np.asarray((bounds - WORST * figures <= ODD * scatter + 1e-12 * figures) & possible)
