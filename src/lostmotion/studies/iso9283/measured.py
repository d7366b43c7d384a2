"""What do measured visits say by ISO 9283, and how sure is each figure? One robot, as it stood before the instrument.

Intervals hold for scatter that is normal, or nearly so: Student's for averages along an axis, chi-square's for 3 s; for the lengths AP_p and RP_l the
same idea by sampling, since no closed form is known. AP_p's is of where many visits would put the average, RP_l's of what many visits would give, of
which the n of the sample show a little less.
"""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import refuse_argument
from lostmotion.studies.draws import key
from lostmotion.studies.intervals import Estimate, student
from lostmotion.studies.iso9283 import characteristics as iso
from lostmotion.studies.iso9283.fitted import Fit, best_fit, left_by_frames

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.spatial import Floats

LEVEL: Final = 0.95
_DRAWN: Final = 2000
_AGAIN: Final = 400
_HALVINGS: Final = 60
_FEWEST: Final = 2
_FRAME: Final = 3
# Fewer poses than this, drawn again, say too little of others.
_POOLED: Final = 20


@dataclass(frozen=True)
class Visits:
    """Measured visits, in rows; m and rad, base frame.

    pose (visit,)        label of the pose
    cycle (visit,)       number of the cycle, counted up within a pose where the file names none
    side (visit,)        from which side it was approached; empty for the standard's cycle
    attained (visit, 3)  positions
    command (visit, 3)   commanded positions, NaN where none are known
    turn (visit, 3)      rotation vector from the commanded orientation to the attained one, base axes; None where orientations were not measured
    rotation (visit, 3, 3)  of the commanded tool; None where not known
    duplicates           rows left out because they repeat another one exactly
    instrument           standard deviation of one reading of a coordinate, m; 0 where not stated
    source               where they come from
    """

    pose: tuple[str, ...]
    cycle: np.ndarray
    side: tuple[str, ...]
    attained: Floats
    command: Floats
    turn: Floats | None
    rotation: Floats | None
    duplicates: int
    instrument: float
    source: str


@dataclass(frozen=True)
class MeasuredPose:
    """One pose: lengths in m, angles in rad; estimates are NaN where too few visits or no command tell nothing.

    accuracy, repeatability   AP_p and RP_l
    axes (6)                  AP_a, AP_b, AP_c, AP_x, AP_y, AP_z
    scatter (6)               3 s about and along the axes: RP_a, RP_b, RP_c first
    without_instrument        RP_l with the instrument's own scatter taken off, in squares
    fitted                    AP_p left with the best-fit frames over all poses
    multi_directional         vAP_p, from visits with a side; NaN without
    errors (visit, 3)         about the command, or about the barycentre where no command is known
    """

    name: str
    visits: int
    command: Floats
    accuracy: Estimate
    repeatability: Estimate
    axes: tuple[Estimate, ...]
    scatter: tuple[Estimate, ...]
    without_instrument: float
    fitted: float
    multi_directional: Estimate
    errors: Floats


@dataclass(frozen=True)
class Measured:
    """The sheet of one robot.

    poses       each pose, P2 before P10
    distance    AD_p and RD between P2 and P4; None without both
    pooled      mean, standard deviation, 95 % point and largest of AP_p over poses, as it is and with the best-fit frames; with intervals over poses
    fit         the frames; None for fewer than three poses or no commands
    floor       RP_l that the instrument alone would show, m
    """

    visits: Visits
    poses: tuple[MeasuredPose, ...]
    distance: tuple[Estimate, Estimate] | None
    pooled: tuple[tuple[Estimate, ...], tuple[Estimate, ...]] | None
    fit: Fit | None
    floor: float


NOTHING: Final = Estimate(math.nan, math.nan, math.nan)


def judge(visits: Visits, level: float = LEVEL) -> Measured:
    """What does ISO 9283 say of these visits? Intervals of this level; two visits at least for a scatter, three poses for frames.

    Raises InputError for poses that were visited from stated sides alone: their other figures are those of the standard's cycle.
    """
    names = sorted(dict.fromkeys(visits.pose), key=_counting)
    label = np.array(visits.pose)
    in_cycle = np.array([not side for side in visits.side])
    rows = {name: np.flatnonzero((label == name) & in_cycle) for name in names}
    if alone := [name for name, found in rows.items() if not len(found)]:
        expected = "visits without a side at every pose too, those of the standard's cycle"
        raise refuse_argument("side", f"a side at all visits to {', '.join(alone)}", expected, "P1,,600.01,0.02,399.98")
    command = np.array([visits.command[found[0]] for found in rows.values()]).reshape(-1, 3)
    barycentre = np.array([visits.attained[found].mean(axis=0) for found in rows.values()]).reshape(-1, 3)
    rotation = None if visits.rotation is None else np.array([visits.rotation[found[0]] for found in rows.values()])
    fit = best_fit(barycentre, command, rotation) if len(rows) >= _FRAME and np.isfinite(command).all() else None
    left = np.full(len(rows), math.nan) if fit is None else np.linalg.norm(fit.residual, axis=1)
    poses = tuple(_pose(visits, name, found, float(left[k]), level) for k, (name, found) in enumerate(rows.items()))
    pooled = None
    if fit is not None:
        raw = barycentre - command
        pooled = _pooled(lambda chosen: raw[chosen], len(raw), level), _pooled(_refit(command, rotation, fit), len(raw), level)
    floor = visits.instrument * _round_repeatability(min(len(found) for found in rows.values()))
    return Measured(visits, poses, _distance(visits, rows, level), pooled, fit, floor)


def _counting(name: str) -> tuple[str, int, str]:
    """Give what sorts names as people count."""
    word = name.rstrip("0123456789")
    return word, int(name[len(word) :][-9:] or 0), name


def student_interval(values: Floats, level: float = LEVEL) -> Estimate:
    """What is the mean of values (visit,), and between which does it lie? Student's interval."""
    mean, count = float(values.mean()), len(values)
    if count < _FEWEST:
        return Estimate(mean, math.nan, math.nan)
    half = student(count - 1, level) * float(values.std(ddof=1)) / math.sqrt(count)
    return Estimate(mean, mean - half, mean + half)


def scatter_interval(values: Floats, level: float = LEVEL) -> Estimate:
    """What are 3 s of values (visit,), and between which do they lie? Chi-square's interval for a normal scatter."""
    from scipy.special import chdtri

    count = len(values)
    if count < _FEWEST:
        return NOTHING
    spread = 3 * float(values.std(ddof=1))
    low, high = (math.sqrt((count - 1) / float(chdtri(count - 1, tail))) for tail in ((1 - level) / 2, (1 + level) / 2))
    return Estimate(spread, spread * low, spread * high)


def accuracy_interval(errors: Floats, level: float = LEVEL) -> Estimate:
    """What is AP_p of errors (visit, 3), and between which does it lie?

    The square of the average's length is too large by the trace of its covariance C, and has the variance 4 b'Cb + 2 tr C^2 (normal scatter);
    Student's share of its root to both sides, never below zero. Holds its level where AP_p is half of the scatter of a visit or more; above it below.
    """
    if len(errors) < _FEWEST:
        return Estimate(float(np.linalg.norm(errors.mean(axis=0))), math.nan, math.nan)
    return _length(errors.mean(axis=0), np.cov(errors.T) / len(errors), len(errors) - 1, level)


def _length(mean: Floats, covariance: Floats, freedom: int, level: float) -> Estimate:
    """Give the length of an average with this covariance, and its interval."""
    value = float(np.linalg.norm(mean))
    square = value**2 - float(np.trace(covariance))
    half = student(freedom, level) * math.sqrt(float(4 * mean @ covariance @ mean + 2 * (covariance**2).sum()))
    return Estimate(value, math.sqrt(max(square - half, 0.0)), math.sqrt(max(square + half, 0.0)))


def repeatability_interval(errors: Floats, level: float = LEVEL) -> Estimate:
    """What is RP_l of errors (visit, 3), and between which does the RP_l of many visits lie?

    Sets of as many visits are drawn from a normal scatter with the covariance found; how their RP_l stands to the limit is how this one is taken to.
    The covariance is first made rounder by what a sample's is too unequal.
    """
    value, count = float(iso.pose_repeatability(errors)) if len(errors) >= _FEWEST else math.nan, len(errors)
    if not value > 0 or count <= _FEWEST:
        return Estimate(value, math.nan, math.nan)
    covariance = _shrunk(np.cov(errors.T), count)
    limit = float(iso.expected_repeatability(covariance[None] / np.trace(covariance))[0][0]) * math.sqrt(float(np.trace(covariance)))
    sets = _generator("repeatability").standard_normal((_DRAWN, count, 3)) @ _root(covariance).T
    low, high = np.quantile(iso.pose_repeatability(sets) / limit, [(1 - level) / 2, (1 + level) / 2])
    return Estimate(value, value / float(high), value / float(low))


@functools.cache
def _round_repeatability(count: int) -> float:
    """Give RP_l that so many visits show on the average, in deviations of a round normal scatter; zero for a single visit."""
    return float(iso.expected_repeatability(np.eye(3)[None], count)[0][0]) if count >= _FEWEST else 0.0


def _shrunk(covariance: Floats, count: int) -> Floats:
    """Draw a sample's covariance towards a round one, until its eigenvalues are as unequal as the true ones are on the average.

    A sample's squares are too unequal by a known amount: E tr S^2 = (1 + 1/m) tr C^2 + (tr C)^2 / m with m = count - 1, of normal visits.
    """
    size, freedom = len(covariance), count - 1
    round_one = float(np.trace(covariance)) ** 2 / size
    found = float((covariance**2).sum()) - round_one
    true = freedom**2 / ((freedom - 1) * (freedom + 2)) * (found + round_one - size * round_one / freedom) - round_one
    share = math.sqrt(min(max(true / found, 0.0), 1.0)) if found > 0 else 0.0
    return np.asarray(share * covariance + (1 - share) * float(np.trace(covariance)) / size * np.eye(size))


def _root(covariance: Floats) -> Floats:
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def _generator(name: str) -> np.random.Generator:
    return np.random.Generator(np.random.Philox(key=key(1, f"iso9283.{name}")))


def _pose(visits: Visits, name: str, found: np.ndarray, fitted: float, level: float) -> MeasuredPose:
    attained, command = visits.attained[found], visits.command[found[0]]
    known = bool(np.isfinite(command).all())
    errors = attained - (command if known else attained.mean(axis=0))
    turns = np.full((len(found), 3), math.nan) if visits.turn is None else visits.turn[found]
    each = np.column_stack([turns, errors])
    measured = [visits.turn is not None] * 3 + [True] * 3
    repeat = repeatability_interval(errors, level)
    floor = visits.instrument * _round_repeatability(len(found))
    return MeasuredPose(
        name,
        len(found),
        command,
        accuracy_interval(errors, level) if known else NOTHING,
        repeat,
        tuple(student_interval(column, level) if ok and known else NOTHING for column, ok in zip(each.T, measured, strict=True)),
        tuple(scatter_interval(column, level) if ok else NOTHING for column, ok in zip(each.T, measured, strict=True)),
        math.sqrt(max(repeat.value**2 - floor**2, 0.0)) if visits.instrument and repeat.value > 0 else math.nan,
        fitted,
        _from_sides(visits, name, level),
        errors,
    )


def _from_sides(visits: Visits, name: str, level: float) -> Estimate:
    """Give vAP_p, with the interval of the pair of sides that stand farthest apart."""
    sides: dict[str, list[int]] = {}
    for k, (pose, side) in enumerate(zip(visits.pose, visits.side, strict=True)):
        if pose == name and side:
            sides.setdefault(side, []).append(k)
    sets = [visits.attained[found] for found in sides.values()]
    if len(sets) < _FEWEST:
        return NOTHING
    pairs = [(one, other) for one, other in itertools.combinations(sets, 2)]
    one, other = max(pairs, key=lambda pair: float(np.linalg.norm(pair[0].mean(axis=0) - pair[1].mean(axis=0))))
    between, fewest = one.mean(axis=0) - other.mean(axis=0), min(len(one), len(other))
    if fewest < _FEWEST:
        return Estimate(float(np.linalg.norm(between)), math.nan, math.nan)
    return _length(between, np.cov(one.T) / len(one) + np.cov(other.T) / len(other), fewest - 1, level)


def _distance(visits: Visits, rows: dict[str, np.ndarray], level: float) -> tuple[Estimate, Estimate] | None:
    """Give AD_p and RD between P2 and P4, from the cycles in which both were visited."""
    if not {"P2", "P4"} <= set(rows):
        return None
    cycles = [dict(zip(visits.cycle[rows[name]].tolist(), rows[name].tolist(), strict=True)) for name in ("P2", "P4")]
    both = sorted(set(cycles[0]) & set(cycles[1]))
    if len(both) < _FEWEST:
        return None
    ends = [visits.attained[[at[cycle] for cycle in both]] for at in cycles]
    far = np.linalg.norm(ends[1] - ends[0], axis=1)
    command = float(np.linalg.norm(visits.command[rows["P4"][0]] - visits.command[rows["P2"][0]]))
    return (student_interval(far - command, level) if math.isfinite(command) else NOTHING), scatter_interval(far, level)


def _refit(command: Floats, rotation: Floats | None, fit: Fit) -> Callable[[np.ndarray], np.ndarray]:
    """Give what turns picked poses into what their own best-fit frames leave; small steps about the fit over all poses."""
    stands = (command if rotation is None else command + rotation @ fit.tool) @ fit.base[:3, :3].T + fit.base[:3, 3]
    turned = None if rotation is None else fit.base[:3, :3] @ rotation

    def left(chosen: np.ndarray) -> np.ndarray:
        return left_by_frames(fit.residual[chosen], stands[chosen], None if turned is None else turned[chosen])

    return left


def _pooled(left: Callable[[np.ndarray], np.ndarray], count: int, level: float) -> tuple[Estimate, ...]:
    """Give mean, standard deviation, 95 % point and largest of the lengths that are `left` at poses, with intervals by drawing poses again."""

    def told(chosen: np.ndarray) -> Floats:
        lengths = np.linalg.norm(left(chosen), axis=1)
        return np.array([lengths.mean(), lengths.std(ddof=1), np.quantile(lengths, 0.95), lengths.max()])

    low, high = np.full((2, 4), math.nan)
    if count >= _POOLED:
        rng = _generator("poses")
        again = np.array([told(rng.integers(count, size=count)) for _ in range(_AGAIN)])
        low[:3], high[:3] = np.quantile(again[:, :3], [(1 - level) / 2, (1 + level) / 2], axis=0)
    return tuple(Estimate(float(value), float(a), float(b)) for value, a, b in zip(told(np.arange(count)), low, high, strict=True))
