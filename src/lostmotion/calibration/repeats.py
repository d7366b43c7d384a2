"""Repeated visits to one pose: their mean, which the fit uses, and their scatter.

What the model of the arm lacks is the same at every visit to a pose. Repeats average the scatter of
the robot between visits and the noise of the instrument alone, so that they are no independent
measurements of the arm.

Source: ISO 5725-2, pooled variance of cells; its interval by the chi-square distribution.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from lostmotion.calibration.instruments import OnInstrument, Rows

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lostmotion.calibration.instruments import Instrument, MeasuredVisits
    from lostmotion.calibration.model import RobotModel
    from lostmotion.spatial import Floats

# Joint values that differ by less are those of one pose, rad and m.
_SAME_JOINTS: Final = 1e-9
# Logged joint values of one commanded pose differ by no more, rad and m: jitter of the drives, and
# the last digit.
_LOGGED: Final = 1e-4
# Distance from the median of a pose over the usual one from which a visit is wrong: one in 10 000
# normal visits is beyond it. Of two visits neither is.
_FAR: Final = 8.0
_FEWEST: Final = 3


class RepeatScatter(NamedTuple):
    """Pooled standard deviation of repeated measurements.

    deviation  of a coordinate, in the unit of the measurement
    low, high  its 95 % confidence interval
    poses      number of poses that were measured repeatedly
    rows       number of measurements at them
    """

    deviation: float
    low: float
    high: float
    poses: int
    rows: int


def scatter_of_repeats(poses: Sequence[object], residual: Floats) -> RepeatScatter | None:
    """Return the scatter within groups of measurements of one pose; None without repeats.

    poses     key of the pose of each measurement
    residual  (measurement, coordinate) measured less predicted, of one prediction at each pose

    Valid for coordinates of equal variance whose repeats are independent.
    """
    members: dict[object, list[int]] = {}
    for k, key in enumerate(poses):
        members.setdefault(key, []).append(k)
    groups = [residual[rows] for rows in members.values() if len(rows) > 1]
    if not groups:
        return None
    from scipy.stats import chi2

    freedom = sum(len(each) - 1 for each in groups) * residual.shape[1]
    square = sum(float(((each - each.mean(axis=0)) ** 2).sum()) for each in groups)
    low, high = (float(square / chi2.ppf(share, freedom)) ** 0.5 for share in (0.975, 0.025))
    return RepeatScatter(
        (square / freedom) ** 0.5, low, high, len(groups), sum(len(each) for each in groups)
    )


def common_poses(q: Floats) -> Floats:
    """Return the joint values (visit, joint), rad and m, in which those of one commanded pose are
    their mean: visits that are within 0.1 mrad and 0.1 mm of one another in each joint. A path in
    smaller steps is left as it is.
    """
    pose, count = np.zeros(len(q), dtype=np.int64), 0
    while count < (count := int(pose.max(initial=0)) + 1):  # until no joint splits a group
        for joint in q.T:
            order = np.lexsort((joint, pose))
            apart = (np.diff(pose[order]) != 0) | (np.diff(joint[order]) > _LOGGED)
            pose[order[1:]] = np.cumsum(apart)
            pose[order[:1]] = 0
    low, high, total = np.full((3, count, q.shape[1]), [[[np.inf]], [[-np.inf]], [[0.0]]])
    np.minimum.at(low, pose, q)
    np.maximum.at(high, pose, q)
    np.add.at(total, pose, q)
    extent = (high - low).max(axis=1)
    logged = (extent > _SAME_JOINTS) & (extent <= _LOGGED)
    mean = total / np.bincount(pose, minlength=count)[:, None]
    return np.where(logged[pose][:, None], mean[pose], q)


@dataclass(frozen=True, eq=False)
class Repeats:
    """Which visits are of one pose: of the same joint values, sides of approach, payload, target
    and set.

    pose      (visit,) number of the pose of each visit, in the order in which they come
    residual  (visit, row) what is measured less what would be at the nominal pose
    """

    pose: NDArray[np.int64]
    residual: Floats

    @functools.cached_property
    def first(self) -> NDArray[np.int64]:
        """Return the first visit to each pose (pose,)."""
        return np.unique(self.pose, return_index=True)[1]

    @functools.cached_property
    def used(self) -> NDArray[np.bool_]:
        """Return which visits (visit,) are in the mean of their pose: those that are not far from
        the median of three or more.
        """
        many = np.bincount(self.pose)[self.pose] >= _FEWEST
        away = np.zeros(len(self.pose))
        for pose in np.unique(self.pose[many]):
            here = self.pose == pose
            beside = self.residual[here] - np.median(self.residual[here], axis=0)
            away[here] = np.linalg.norm(beside, axis=1)
        usual = float(np.median(away[many])) if many.any() else 0.0
        return np.asarray(away <= _FAR * usual) if usual else np.ones(len(away), dtype=bool)

    @property
    def counts(self) -> NDArray[np.int64]:
        """Return the number of visits in the mean of each pose (pose,)."""
        return np.bincount(self.pose[self.used])

    def scatter(self, poses: NDArray[np.int64], rows: NDArray[np.bool_]) -> RepeatScatter | None:
        """Return the scatter of these rows (row,) at these poses."""
        here = self.used & np.isin(self.pose, poses)
        return scatter_of_repeats(self.pose[here].tolist(), self.residual[np.ix_(here, rows)])

    def mean(self, instrument: Instrument) -> Instrument:
        """Return the measurement of the poses by the means of their visits."""
        if len(self.first) == len(self.pose):
            return instrument
        rows = np.flatnonzero(self.used)
        return Averaged(instrument.part(rows), self.pose[rows])


def repeats_of(visits: MeasuredVisits, instrument: Instrument, frames: Floats) -> Repeats:
    """Return which of these visits are of one pose, with what the instrument measured; `frames` are
    the nominal ones of the tool (visit, 4, 4).
    """
    joints = np.round(visits.q / _SAME_JOINTS)
    parts = (joints, visits.approach, visits.payload)
    columns = np.column_stack([each for each in parts if isinstance(each, np.ndarray)])
    columns = columns + 0.0  # no negative zero
    names = ("",) * len(visits) if visits.readings is None else visits.readings.target
    sets = names if visits.sets is None else visits.sets
    of: dict[tuple[str, str, bytes], int] = {}
    keys = [
        (name, set_, row.tobytes()) for name, set_, row in zip(names, sets, columns, strict=True)
    ]
    pose = [of.setdefault(key, len(of)) for key in keys]
    residual = instrument.rows(frames, np.zeros(len(instrument.unknowns))).residual
    return Repeats(np.array(pose), residual)


@dataclass(frozen=True, eq=False)
class Averaged(OnInstrument):
    """An instrument that measured poses repeatedly: its rows are means over the visits to a pose.

    pose  (visit,) number of the pose of each visit of the instrument
    """

    pose: NDArray[np.int64]

    def rows(self, frames: Floats, unknowns: Floats) -> Rows:
        """Return the means of the rows."""
        counts = np.bincount(self.pose, minlength=len(frames))

        def mean(values: Floats) -> Floats:
            total = np.zeros((len(frames), *values.shape[1:]))
            np.add.at(total, self.pose, values)
            return total / counts[:, None, None]

        residual, *by = self.inner.rows(frames[self.pose], unknowns)
        return Rows(mean(residual[:, :, None])[:, :, 0], *map(mean, by))

    def part(self, rows: NDArray[np.int64]) -> Averaged:
        """Return the measurement at the poses in these rows."""
        number = np.full(int(self.pose.max()) + 1, -1)
        number[rows] = np.arange(len(rows))
        visits = np.flatnonzero(number[self.pose] >= 0)
        return Averaged(self.inner.part(visits), number[self.pose[visits]])


@dataclass(frozen=True, eq=False)
class AtPoses:
    """A model at poses that were visited repeatedly, and what repeats show.

    model      with the scatter of the mean of the visits to each pose
    scatter    of the measured lengths; None: nothing was measured repeatedly
    predicted  standard deviation that the arm's file predicts for it, without the instrument
    reading    variance of a visit by what repeats show beside that, m^2
    """

    model: RobotModel
    scatter: RepeatScatter | None
    predicted: float
    reading: float


def at_poses(
    model: RobotModel,
    repeats: Repeats,
    instrument: Instrument,
    poses: NDArray[np.int64],
    noise: float | None = None,
) -> AtPoses:
    """Return the model at poses with the scatter of the mean of their visits.

    model       at the poses, with the scatter of one visit
    instrument  what measured the visits, or their means
    poses       whose visits are compared
    noise       standard deviation of a coordinate at one visit, m; None: not stated

    The side of approach, where it is not recorded, is the same at all visits to a pose: it is not
    averaged.
    """
    scatter = repeats.scatter(poses, instrument.lengths)
    if scatter is None:
        return AtPoses(model, None, 0.0, 0.0)
    by = instrument.rows(model.matrix.state.frames[-1], np.zeros(len(instrument.unknowns))).by_twist
    spread = by @ (model.scatter - model.sides) @ by.transpose(0, 2, 1)
    lengths = instrument.lengths
    predicted = float(np.diagonal(spread, axis1=1, axis2=2)[:, lengths].mean())
    unit = float(instrument.noise[lengths][0]) ** 2
    reading = max(scatter.deviation**2 - predicted, 0.0) / unit
    if noise is not None:
        reading = min(reading, noise**2)
    counts = repeats.counts[:, None, None]
    averaged = (model.scatter - model.sides) / counts + model.sides
    mean = replace(model, scatter=averaged, reading=reading / repeats.counts)
    return AtPoses(mean, scatter, predicted**0.5, reading)
