"""Which length does a share of errors stay below, where points over the draws leave it vague? One draw is summed over in closed form.

Given all other draws, an error moves along a straight line as one draw without steps varies, and the share of it within a sphere is that between two
places of the law. The mean of this over the points is far smoother than a count of them, and needs far fewer, the more that draw makes of the error.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.cumulants import draws_of
from lostmotion.error_model.intervals import student
from lostmotion.laws.distributions import Smooth
from lostmotion.propagation.analytic.points import SETS, SURE

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from lostmotion.error_model.pose_matrix import TermInfo
    from lostmotion.spatial import Floats

# Of a share: what rounding and the points' own fineness may leave.
_SHARE: Final = 1e-7
# How much further than to first order a bound is looked for.
_WIDER: Final = (1.2, 2.0, 5.0)
_FINE: Final = 1e-5
# Where so large a share of a figure is vague, lengths leave a gap, and there is nothing to find.
_GAP: Final = 0.1


def smooth_draws(infos: Sequence[TermInfo], columns: np.ndarray) -> dict[int, Smooth]:
    """Which of these terms draw once, without steps, and what no other one draws? The laws by the terms' rows."""
    drawn = [draws_of(infos[k]) for k in columns]
    users = Counter((level, name) for some in drawn for level, name, _ in some)
    return {row: law for row, [(level, name, law), *more] in enumerate(drawn) if not more and users[level, name] == 1 and isinstance(law, Smooth)}


def smoothen(
    quantiles: tuple[Floats, Floats], wanted: NDArray[np.bool_], drawn: Floats, bias: Floats, shift: Floats, levels: Floats, smooth: dict[int, Smooth]
) -> None:
    """Better the quantiles (n, level) and bounds that are `wanted` of lengths that `by_points` gave, in place.

    Where lengths leave a gap nothing changes, nor where that is not known better.
    """
    if not smooth:
        return
    values, bounds = quantiles
    rows = np.array(list(smooth))
    wanted = wanted & (bounds < _GAP * values)
    for n in np.flatnonzero(wanted.any(axis=1)):
        row = int(rows[np.argmax((shift[n][:, rows] ** 2).sum(axis=0))])
        if not shift[n][:, row].any():
            continue  # of draws that do not move the tool
        share = _shares(drawn, bias[n], shift[n], row, smooth[row])
        for k in np.flatnonzero(wanted[n]):
            at, bound = _quantile(share, float(levels[k]), float(values[n, k]), float(bounds[n, k]))
            if bound < bounds[n, k]:
                values[n, k], bounds[n, k] = at, bound


def _shares(drawn: Floats, bias: Floats, shift: Floats, row: int, law: Smooth) -> Callable[[float], Floats]:
    """Give the function that says which share (set,) lies within a length, the draw in this row summed over."""
    along = shift[:, row]
    square = float(along @ along)
    rest = shift @ drawn + bias[:, None] - np.outer(along, drawn[row])
    middle = -(along @ rest) / square
    across = np.maximum((rest**2).sum(axis=0) / square - middle**2, 0.0)

    def share(length: float) -> Floats:
        half = length**2 / square - across
        some = np.flatnonzero(half > 0)
        root, centre = np.sqrt(half[some]), middle[some]
        out = np.zeros(len(half))
        out[some] = law.share(centre + root) - law.share(centre - root)
        return np.asarray(out.reshape(SETS, -1).mean(axis=1))

    return share


def _quantile(share: Callable[[float], Floats], level: float, guess: float, bound: float) -> tuple[float, float]:
    """Find the length of this share by halving and secants, and how far it may be off; an infinite bound where that is not known."""
    from scipy.optimize import brentq

    low, high = max(guess - 2 * bound, 0.0), guess + 2 * bound
    if not float(share(low).mean()) < level < float(share(high).mean()):
        return guess, np.inf
    at = float(brentq(lambda length: float(share(length).mean()) - level, low, high, xtol=_FINE * guess))
    sets = share(at)
    off = student(SETS - 1, SURE) / np.sqrt(SETS) * float(sets.std(ddof=1)) + abs(float(sets.mean()) - level) + _SHARE
    for first in (bound * off / max(float(share(at + bound).mean()) - level, off), bound):
        for wider in _WIDER:
            by = wider * first
            if float(share(max(at - by, 0.0)).mean()) <= level - off and float(share(at + by).mean()) >= level + off:
                return at, by
    return at, np.inf
