"""How long is an error that few flat, wavy or two-sided draws make nearly all of? By points of Sobol sequences over the draws.

There neither nearly normal parts nor a lattice tell every figure: lengths stand in steps, and between them hardly any. The same points serve every
pose, whatever the study's seed. Eight sequences are scrambled by themselves, and what they differ by is what they leave uncertain.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.cumulants import draws_of
from lostmotion.error_model.draws import sobol
from lostmotion.error_model.intervals import student

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lostmotion.error_model.pose_matrix import TermInfo
    from lostmotion.spatial import Floats

SETS: Final = 8
# Points of each set, one attempt after the other.
EACH: Final = (1024, 8192)
# A bound is no interval: one in a thousand may lie beyond.
SURE: Final = 0.999
# Of each law of lengths so many steps are kept, closer together towards both ends.
_KEPT: Final = 1024
# Around a length, as a share of it, where its density is asked.
_AROUND: Final = 0.02
# Points as near to zero and one as a uniform can be.
_LEAST: Final = 2.0**-54


def points_of(infos: Sequence[TermInfo], columns: np.ndarray, each: int) -> Floats:
    """Which draws stand for all that these terms can draw? (term, set x point), so many points in each set; more keep the first ones."""
    streams = list(dict.fromkeys((level, name) for k in columns for level, name, _ in draws_of(infos[k])))
    out = np.ones((len(columns), SETS * each))
    for n in range(SETS):
        u = np.clip(sobol(0, f"analytic.points.{n}", len(streams)).random(each), _LEAST, 1 - _LEAST)
        for row, k in zip(out, columns, strict=True):
            for level, name, law in draws_of(infos[k]):
                row[n * each : (n + 1) * each] *= law.quantile(u[:, streams.index((level, name))])
    return out


def by_points(drawn: Floats, bias: Floats, shift: Floats, levels: Floats) -> tuple[Floats, Floats, Points]:
    """How long is bias (n, 3) + shift (n, 3, term) @ drawn (term, point) on average, and which lengths do these shares stay below?

    Values (n, 1 + level), the mean first, how far each may be off, and the laws of the lengths.
    """
    values, bounds = np.empty((2, len(bias), 1 + len(levels)))
    kept, missed = np.empty((len(bias), _KEPT + 1)), np.empty(len(bias))
    each = drawn.shape[1] // SETS
    shares = _shares()
    ranks = np.round((drawn.shape[1] - 1) * shares).astype(int)
    apart = np.diff(shares).max() / 2  # of a share from the nearest that is kept
    half = student(SETS - 1, SURE) / np.sqrt(SETS)
    for n in range(len(bias)):
        x, y, z = shift[n] @ drawn + bias[n, :, None]
        sets = np.sort(np.sqrt(x * x + y * y + z * z).reshape(SETS, each), axis=1)
        whole = np.sort(sets, axis=None, kind="stable")  # which merges what is sorted already
        values[n] = np.r_[whole.mean(), _quantiles(whole, levels)]
        of_sets = np.column_stack([sets.mean(axis=1), _quantiles(sets, levels)])
        bounds[n] = half * of_sets.std(axis=0, ddof=1)
        off = half * np.array([np.searchsorted(own, values[n, 1:]) / each for own in sets]).std(axis=0, ddof=1) + 1 / each
        # Where lengths leave a gap at a level, all sets may agree on a place in its middle.
        for sign in (-1, 1):
            there = _quantiles(whole, np.clip(levels + sign * off, 0, 1))
            bounds[n, 1:] = np.maximum(bounds[n, 1:], np.abs(there - values[n, 1:]))
        kept[n], missed[n] = whole[ranks], off.max(initial=1 / each) + apart
    return values, bounds, Points(kept, missed)


def _quantiles(rising: Floats, levels: Floats) -> Floats:
    """Read quantiles (..., level) off sorted lengths (..., point), along straight lines between points."""
    at = levels * (rising.shape[-1] - 1)
    low = np.minimum(at.astype(int), rising.shape[-1] - 2)
    return np.asarray(rising[..., low] + (at - low) * (rising[..., low + 1] - rising[..., low]))


def _shares() -> Floats:
    return (1 - np.cos(np.linspace(0, np.pi, _KEPT + 1))) / 2


class Points:
    """Shares of the vectors' lengths, as the points say; missed (n,) how far shares may be off."""

    def __init__(self, kept: Floats, missed: Floats) -> None:
        """Keep lengths (n, step) of rising shares."""
        self._kept, self.missed = kept, missed

    def share(self, some: NDArray[np.int64], lengths: Floats) -> tuple[Floats, Floats]:
        """Which share of each of some vectors' lengths lies below these (some, length), and how dense are they there?"""
        shares = _shares()
        rows = list(zip(self._kept[some], lengths, strict=True))
        low, below, high = (np.array([np.interp(at * near, own, shares) for own, at in rows]) for near in (1 - _AROUND, 1.0, 1 + _AROUND))
        # Beside a gap, the lesser density is the one that tells how far a quantile may be off.
        return below, np.minimum(below - low, high - below) / (_AROUND * lengths)
