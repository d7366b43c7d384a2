"""Columns whose draws a calibration leaves correlated (`mechanism.calibration.Correlations`).

Let x be the columns of one error, with draws L z: L is the Cholesky factor of their correlation
matrix, and z are independent standard normal draws. Then x L z is the error, and its covariance is
(x L) (x L)'. So sums of squares need no other terms: as many columns, x L, have independent draws.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lostmotion.error_model.draws import Stream, robot_draws
from lostmotion.mechanism.calibration import REMAINING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.error_model.columns import Draws, Groups, Key
    from lostmotion.mechanism.calibration import Correlations
    from lostmotion.spatial import Floats


class Mixture(NamedTuple):
    """Independent standard normal draws, as many as an error has correlated ones.

    streams     names of these draws
    weights     (column, draw) the columns @ weights have these draws
    directions  (draw, stream) each of them as a sum of the draws of `streams_of`
    """

    streams: tuple[Stream, ...]
    weights: Floats
    directions: Floats

    @property
    def correlation(self) -> Floats:
        """Return the correlations (column, column) of the draws of the columns."""
        return self.weights @ self.weights.T


def mixtures(
    infos: Sequence[Draws], groups: Groups, correlations: Correlations | None
) -> dict[Key, Mixture]:
    """Return the independent draws of each group of columns with correlated draws."""
    if correlations is None:
        return {}
    return {
        key: _mixture(correlations, [infos[k].robot_name for k in members], number)
        for number, (key, members) in enumerate(groups.items())
        if infos[members[0]].robot_name in correlations.row
    }


def _mixture(correlations: Correlations, names: Sequence[str], group: int) -> Mixture:
    """Return the independent draws of columns with these streams; several columns may have one."""
    streams = list(dict.fromkeys(names))
    rows = correlations.factor[[correlations.row[name] for name in streams]]
    # An error may have some of all streams: by QR it has as many independent draws as these.
    directions, weights = np.linalg.qr(rows.T)
    signs = np.where(np.diag(weights) < 0, -1.0, 1.0)
    of_stream = (weights * signs[:, None]).T
    return Mixture(
        tuple(Stream(f"calibration.{group}.{k}", REMAINING) for k in range(len(streams))),
        of_stream[[streams.index(name) for name in names]],
        (directions * signs).T,
    )


def streams_of(correlations: Correlations | None) -> tuple[Stream, ...]:
    """Return the independent streams of which correlated draws are sums; none without any."""
    names = () if correlations is None else correlations.streams
    return tuple(Stream(f"calibration.{name}", REMAINING) for name in names)


def correlated_draws(seed: int, correlations: Correlations, robots: int) -> dict[str, Floats]:
    """Return the correlated draws of each robot (tile, LANES) by name, as `draws.robot_draws`.

    A robot's draws are the same bits for any number of robots.
    """
    out = robot_draws(seed, streams_of(correlations), robots).transpose(1, 0, 2).copy()
    # In place from the last row: a row of the lower triangle needs those above it alone.
    for row in range(len(out) - 1, -1, -1):
        out[row] *= correlations.factor[row, row]
        for above in np.flatnonzero(correlations.factor[row, :row]):
            out[row] += correlations.factor[row, above] * out[above]
    return dict(zip(correlations.streams, out, strict=True))
