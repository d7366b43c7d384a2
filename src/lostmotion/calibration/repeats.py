"""Scatter of repeated measurements: that of the robot between visits, and of the instrument.

Source: ISO 5725-2, pooled variance of cells; its interval by the chi-square distribution.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.spatial import Floats


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
