"""Accuracy at poses that were not measured: cross-validation with random and with blocked folds."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.calibration.fit import fit, linearised, whitened
from lostmotion.calibration.sets import FEWEST_IN_SET

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from lostmotion.calibration.choices import Asked
    from lostmotion.calibration.fit import Estimates
    from lostmotion.calibration.instruments import Instrument, MeasuredVisits
    from lostmotion.calibration.model import RobotModel
    from lostmotion.spatial import Floats

FOLDS: Final = 5
_LLOYD_STEPS: Final = 50
# Number of measurements from which their 95th percentile is used.
_MANY: Final = 40


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Measurements against predictions of fits that did not use them.

    error      (pose,) length of the residual: of the position where one is measured, m
    distances  (pose,) squared length of the residual in deviations of its prediction
    rows       number of rows of a measurement: the expectation of `distances`
    folds      (pose,) number of the fold in which a pose was held out; None: all at once
    """

    error: Floats
    distances: Floats
    rows: int
    folds: NDArray[np.int64] | None = None

    @property
    def mean(self) -> float:
        """Return the mean error, m."""
        return float(self.error.mean())

    @property
    def standard_error(self) -> float:
        """Return the standard error of the mean error, m."""
        return float(self.error.std(ddof=1) / math.sqrt(len(self.error)))

    @property
    def coverage(self) -> float:
        """Return the share of measurements within their 95 % region, as of `covered`."""
        return float(self.covered.mean())

    @functools.cached_property
    def covered(self) -> NDArray[np.bool_]:
        """Return which measurements (pose,) are within their 95 % region, whose covariance is
        inflated by what the other folds need: 95 % of those that set a factor are within it by
        construction.
        """
        folds = np.zeros(len(self.distances)) if self.folds is None else self.folds
        out = np.zeros(len(folds), dtype=bool)
        for fold in np.unique(folds):
            here = folds == fold
            out[here] = self.within(self._inflation(self.distances[~here]))[here]
        return out

    def within(self, inflation: float) -> NDArray[np.bool_]:
        """Return which measurements (pose,) are within their 95 % region, whose covariance is
        inflated by this factor.
        """
        from scipy.stats import chi2

        return np.asarray(self.distances <= chi2.ppf(0.95, self.rows) * inflation)

    @property
    def inflation(self) -> float:
        """Return the factor, at least 1, by which covariances are too small, such that 95 % of the
        measurements are within their 95 % regions.

        From few measurements the mean squared distance is used, without what one in a thousand
        exceeds: a few wrong measurements are no property of the arm.
        """
        return self._inflation(self.distances)

    def _inflation(self, distances: Floats) -> float:
        from scipy.stats import chi2

        if not len(distances):
            return 1.0
        if len(distances) >= _MANY:
            found = np.quantile(distances, 0.95) / chi2.ppf(0.95, self.rows)
        else:
            far = chi2.ppf(0.999, self.rows)
            found = np.minimum(distances, far).mean() / self.rows
        return max(1.0, float(found))


def numbered(q: Floats) -> NDArray[np.int64]:
    """Return the number of the pose of each row (row, joint), in the order in which they come."""
    of: dict[bytes, int] = {}
    return np.array([of.setdefault(row.tobytes(), len(of)) for row in np.ascontiguousarray(q)])


def random_folds(q: Floats, seed: int) -> NDArray[np.int64]:
    """Return the number of the fold of each row (row, joint), at random; all rows of one pose are
    in one fold.
    """
    pose = numbered(q)
    count = int(pose.max()) + 1
    labels = np.arange(count) % min(FOLDS, count)
    return np.asarray(np.random.default_rng(seed).permutation(labels)[pose])


def blocked_folds(points: Floats) -> NDArray[np.int64]:
    """Return the number of the fold of each point (pose, 3): regions of the workspace by k-means,
    from points that are far apart.
    """
    count = min(FOLDS, len(points))
    centres = [points[int(np.argmax(np.linalg.norm(points - points.mean(axis=0), axis=1)))]]
    while len(centres) < count:
        nearest = np.min([np.linalg.norm(points - c, axis=1) for c in centres], axis=0)
        centres.append(points[int(np.argmax(nearest))])
    labels = np.zeros(len(points), dtype=np.int64)
    for _ in range(_LLOYD_STEPS):
        away = np.linalg.norm(points[:, None] - np.array(centres), axis=2)
        found = np.argmin(away, axis=1)
        if np.array_equal(found, labels):
            break
        labels = found
        centres = [
            points[labels == k].mean(axis=0) if (labels == k).any() else centres[k]
            for k in range(count)
        ]
    return labels


def folds_in_sets(
    folds_of: Callable[[NDArray[np.int64]], NDArray[np.int64]],
    count: int,
    sets: NDArray[np.str_] | None,
) -> NDArray[np.int64]:
    """Return the number of the fold of each of so many poses by `folds_of`, a function of rows.

    The frame of a set is no property of the arm that others predict: a set of which a fold leaves
    too few poses has folds of its own.
    """
    out = folds_of(np.arange(count))
    for name in [] if sets is None else np.unique(sets):
        here = np.flatnonzero(sets == name)
        if len(here) - np.bincount(out[here]).max() < FEWEST_IN_SET:
            out[here] = folds_of(here)
    return out


def kept_aside(visits: MeasuredVisits, share: float, seed: int) -> NDArray[np.bool_]:
    """Return which visits are at a share of the poses, at random: fewer where a set would have too
    few left for its frame.
    """
    pose = numbered(visits.q)
    mixed = np.random.default_rng(seed).permutation(int(pose.max()) + 1)
    apart = np.isin(pose, mixed[: round(share * len(mixed))])
    if visits.sets is not None:
        for rows in visits.by_set.values():
            poses, left = np.unique(pose[rows]), np.unique(pose[rows[~apart[rows]]])
            back = np.setdiff1d(poses, left)[: max(FEWEST_IN_SET - len(left), 0)]
            apart &= ~np.isin(pose, back)
    return np.asarray(apart)


def cross_validate(
    model: RobotModel, instrument: Instrument, asked: Asked, folds: NDArray[np.int64]
) -> HeldOut:
    """Return the measurements of each fold against the fit of all others. Whatever is chosen by
    evidence is chosen again without the fold.
    """
    error, distances = np.zeros(len(model)), np.zeros(len(model))
    rows = 0
    for fold in np.unique(folds):
        here, rest = np.flatnonzero(folds == fold), np.flatnonzero(folds != fold)
        found = fit(model.rows(rest), instrument.part(rest), asked)
        held = held_out(model.rows(here), instrument.part(here), found)
        error[here], distances[here], rows = held.error, held.distances, held.rows
    return HeldOut(error, distances, rows, folds)


def held_out(model: RobotModel, instrument: Instrument, estimates: Estimates) -> HeldOut:
    """Return measurements at these poses against the predictions of a fit."""
    residual, columns, scatter = linearised(model, instrument, estimates.mean)
    noise = estimates.noise**2 * np.diag(instrument.noise**2)
    covariance = columns @ estimates.covariance @ columns.transpose(0, 2, 1) + scatter + noise
    return HeldOut(
        instrument.error(residual),
        (whitened(residual, covariance) ** 2).sum(axis=1),
        residual.shape[1],
    )
