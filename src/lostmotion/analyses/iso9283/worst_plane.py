"""The figure of a path's worst plane that many cycles would show: estimates and intervals for AT and RT, whose planes were run through together.

The largest of several figures is no figure of its own plane: it reads high, the more the more planes are nearly as bad. So each limit is asked of
tests made up: if this were true, how often would a test show as much? No such interval holds its level for every kind of path; how often these do is
measured by benchmarks/path_intervals.py and said in docs/theory/iso9283.md.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.iso9283.confidence import LEVEL, MIN_VISITS, UNKNOWN, generator, shrunk_covariance, unbiased_square
from lostmotion.analyses.iso9283.expected_repeatability import expected_repeatability
from lostmotion.error_model.intervals import Estimate

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.spatial import Floats

_DRAWN: Final = 2000
_BATCH: Final = 100
# A variance along an axis is none if it is a smaller share of the largest.
_FLAT: Final = 1e-12
_HALVED: Final = 24  # bisections of a limit, far finer than the draws tell


def largest_mean(vectors: Floats, level: float = LEVEL) -> Estimate:
    """Return the largest of the true averages' lengths and its interval, of vectors (plane, cycle, k) whose planes were run through together.

    The estimate is the largest of lengths drawn together until they scatter as true ones do, kept within the interval.

    The limits are the largest lengths beyond which a plane that stands as many deviations off as was found is just rare enough or common enough.
    For the lower one, planes stand as much shorter than the longest as they surely are, less a deviation of what chance leaves open; all are drawn
    back, each as far as it scatters, none beyond the limit. For the upper one they stand as far apart as they do on the whole, less what chance adds;
    that which needs the least is drawn out, others as far as their scatter goes with its. The averages scatter normally with the covariance found,
    less what few cycles seem to have in common; planes as differently as is more than chance, and by Student's law as far as no other plane tells
    how much. NaN for fewer than two cycles and for what is not finite.
    """
    count = vectors.shape[1]
    if count < MIN_VISITS or not np.isfinite(vectors).all():
        return UNKNOWN
    mean = vectors.mean(axis=1)
    centred = np.swapaxes(vectors - mean[:, None], 0, 1)
    moving = (centred**2).sum(axis=(0, 2)) > 0
    still = float(np.linalg.norm(mean[~moving], axis=1).max(initial=0.0))
    if not moving.any():
        return Estimate(still, still, still)
    found = _largest_length_interval(mean[moving], *_sampling_distribution(centred[:, moving]), (1 - level) / 2)
    return Estimate(*(max(each, still) for each in (found.value, found.low, found.high)))


def _sampling_distribution(centred: Floats) -> tuple[Floats, Floats, Floats]:
    """Tell how averages scatter of tests like this (cycle, plane, k).

    Gives deviations (plane,), a root (root, plane, k) of their covariance, and what tests make of it (draw, plane, k).
    """
    count, planes, size = centred.shape
    own = np.zeros(planes)
    scatter = np.sqrt((centred**2).sum(axis=(0, 2)) / (count - 1))
    alike = centred / scatter[:, None]
    shared = np.ones(1)  # two cycles show all planes alike, and tell no more
    root = alike / math.sqrt(count - 1)
    if count > MIN_VISITS:
        spread, chance, common = _log_deviations(_within(centred)[None])
        # How much planes scatter, all of them tell at least; what they have in common tells as little as one, and each alone where it differs.
        kept = _kept_share(spread, chance, _true_share(spread, chance))[0]
        shared, own = np.maximum(common, 1 / planes), kept * chance[0] * 2 * (count - 1)
        # A log deviation reads low by its variance: Student's law makes up for planes alone, not for those drawn together.
        scatter, root = np.exp(_shrunk(spread, chance)[0] + chance[0] * (1 - kept)), _root(alike)
    deviation = scatter / math.sqrt(count)
    root = root.reshape(-1, planes, size) * deviation[:, None]
    rng = generator("largest mean")
    moved = (rng.standard_normal((_DRAWN, len(root))) @ root.reshape(len(root), -1)).reshape(_DRAWN, planes, size)
    for share in (shared, own):
        freedom = (count - 1) / np.maximum(share, _FLAT)
        moved *= np.sqrt(freedom / rng.chisquare(freedom, (_DRAWN, len(share))))[:, :, None]
    return deviation, root, moved


def _largest_length_interval(mean: Floats, deviation: Floats, root: Floats, moved: Floats, tail: float) -> Estimate:
    """Return the largest of the true lengths, of averages (plane, k) that scatter so, and its interval with a share `tail` beyond either limit."""
    length = np.linalg.norm(mean, axis=1)
    found, worst = float(length.max()), int(length.argmax())
    along = np.where(length[:, None] > 0, mean, np.eye(mean.shape[1])[0]) / np.where(length > 0, length, 1.0)[:, None]
    radial = (root * along).sum(axis=2)
    covariance = radial.T @ radial
    variance = np.maximum(np.diag(covariance), _FLAT * (found**2 + float((root**2).sum())))
    between = covariance - covariance.mean(axis=0) - covariance.mean(axis=1)[:, None] + covariance.mean()
    chance = np.trace(between) / max(len(mean) - 1, 1)
    # What chance adds to the variance scatters by this share; half of it holds the level in all cases (benchmarks/path_intervals.py).
    scatters = math.sqrt(2 * float((between**2).sum())) / max(float(np.trace(between)), np.finfo(float).tiny)
    surely = float(_true_share(length[None], np.array([chance * (1 + scatters / 2)]))[0])
    true = max(float(length.var()) * len(mean) / max(len(mean) - 1, 1) - chance, 0.0)
    middle = np.average(length, weights=1 / (true + variance))
    on_the_whole = middle + np.sqrt(true / (true + variance)) * (length - middle)
    # Beside a longest that chance alone made so, planes may well stand as far off as it, or half a path that is off alike would be held to be one.
    near = found - surely * (found - length) + np.sqrt(surely * variance)
    across, squares = (moved * along).sum(axis=2), (moved**2).sum(axis=2)

    def as_far(there: Floats, limit: float) -> float:
        """How often would a test show a plane as many deviations beyond the limit, were the lengths these?"""
        there = np.clip(there, 0.0, limit)
        reached = np.maximum(limit + float(((length - limit) / deviation).max()) * deviation, 0.0)
        return float((there * (there + 2 * across) + squares >= reached**2).any(axis=1).mean())

    def drawn_back(limit: float) -> float:
        return as_far(near - (found - limit) * deviation / deviation[worst], limit)

    def drawn_out(limit: float) -> float:
        plane = int(np.argmin((limit - length) / np.sqrt(variance)))
        there = on_the_whole + covariance[plane] / variance[plane] * (limit - length[plane])
        there[plane] = limit
        return as_far(there, limit)

    low = 0.0 if drawn_back(0.0) > tail else _bisect(drawn_back, tail, 0.0, found)
    high = found + math.sqrt(variance.max())
    while drawn_out(high) < 1 - tail:
        high = 2 * high
    high = _bisect(drawn_out, 1 - tail, low, high)
    return Estimate(min(max(float(on_the_whole.max()), low), high), low, high)


def _true_share(values: Floats, chance: Floats) -> Floats:
    """Which share (set,) of what values (set, plane) differ by is more than chance, which makes them differ by this variance (set,)?"""
    if values.shape[1] < MIN_VISITS:
        return np.ones(len(values))
    seen = values.var(axis=1, ddof=1)
    return np.asarray(np.clip(1 - chance / np.where(seen > 0, seen, np.inf), 0.0, 1.0))


def _bisect(share: Callable[[float], float], at: float, low: float, high: float) -> float:
    """Find where a rising share passes this one."""
    for _ in range(_HALVED):
        middle = (low + high) / 2
        low, high = (low, middle) if share(middle) > at else (middle, high)
    return (low + high) / 2


def largest_scatter(vectors: Floats, level: float = LEVEL) -> Estimate:
    """Return the largest scatter of many cycles and its interval, of vectors (plane, cycle, k) whose planes were run through together.

    The scatter is mean + 3 s of the distances from the average, or 3 s where vectors have one part. The largest is estimated with the planes drawn
    together by what chance alone makes them differ, none further than a deviation. The limits are those under which so large an estimate is just rare
    enough or common enough in tests of as many cycles, normal and with the covariance found less what few cycles seem to have in common. For a limit
    below the estimate no plane stands beyond it; half a deviation is left to chance. For one above, the worst is drawn out to it; others follow by
    what they have in common with it, and all alike as far as planes may not be apart at all. The largest that the test itself showed reads high and
    may lie above the interval. NaN for fewer than three cycles, no scatter, and what is not finite.
    """
    count = vectors.shape[1]
    if count <= MIN_VISITS or not np.isfinite(vectors).all():
        return UNKNOWN
    centred = np.swapaxes(vectors - vectors.mean(axis=1, keepdims=True), 0, 1)
    centred = centred[:, (centred**2).sum(axis=(0, 2)) > 0]
    if not centred.size:
        return UNKNOWN
    centred = _within(centred)
    alike = centred / np.sqrt((centred**2).sum(axis=(0, 2)) / (count - 1))[:, None]
    many = np.full(centred.shape[1], math.log(3.0)) if vectors.shape[2] == 1 else np.log(_limit_repeatability(alike))
    spread, chance, _ = _log_deviations(centred[None])
    thought = _shrunk(spread, chance)[0] + many
    estimate, worst = float(thought.max()), int(thought.argmax())
    root = covariance_root(alike)
    of_chance, chances = simulated_tests(root, count)
    # That planes are apart must not be missed: what chance makes them differ by is taken half a deviation short.
    between = of_chance.var(axis=1)
    surplus = between.std() / max(between.mean(), np.finfo(float).tiny) / 2
    apart = _true_share(spread, chance * (1 - surplus))
    mean = spread.mean()
    drawn_apart = mean + _kept_share(spread, chance, np.sqrt(apart))[0] * (spread[0] - mean) + many
    squares = (np.einsum("rpi,rj->pij", root, root[:, worst]) ** 2).sum(axis=(1, 2))
    in_common = squares / np.sqrt(squares[worst] * (np.einsum("rpi,rpj->pij", root, root) ** 2).sum(axis=(1, 2)))
    follows = 1 - apart[0] * (1 - in_common)
    near = thought + math.sqrt(float(_true_share(spread, chance)[0] * chance[0])) / 2

    def as_large(there: Floats) -> float:
        """How often would a test show as large a one, were the scatters these? Logarithms."""
        return float(((_shrunk(of_chance + there - many, chances) + many).max(axis=1) >= estimate).mean())

    def drawn_back(limit: float) -> float:
        return as_large(np.minimum(near, limit))

    def drawn_out(limit: float) -> float:
        return as_large(np.minimum(drawn_apart + (limit - drawn_apart[worst]) * follows, limit))

    tail, low, high = (1 - level) / 2, estimate - 1, estimate + 1
    while drawn_back(low) > tail:
        low -= 1
    while drawn_out(high) < 1 - tail:
        high += 1
    low = _bisect(drawn_back, tail, low, high)
    high = _bisect(drawn_out, 1 - tail, low, high)
    return Estimate(*(math.exp(each) for each in (min(max(estimate, low), high), low, high)))


def _within(centred: Floats) -> Floats:
    """Give vectors (cycle, plane, k) within the plane, or on the line, that all of them lie in."""
    if centred.shape[2] == 1:
        return centred
    values, axes = np.linalg.eigh(np.einsum("npi,npj->ij", centred, centred))
    return np.asarray(centred @ axes[:, values > _FLAT * values[-1]])


def covariance_root(alike: Floats) -> Floats:
    """Give a root (root, plane, k) of the covariance that made-up tests scatter with, of planes (cycle, plane, k)."""
    _, _, common = _log_deviations(alike[None])
    return _root(alike, telling=1 / max(float(common[0]), 1 / alike.shape[1])).reshape(-1, *alike.shape[1:])


def simulated_tests(root: Floats, count: int) -> tuple[Floats, Floats]:
    """Make up tests of so many cycles that scatter by a root (root, plane, k) of the covariance.

    Gives log deviations (draw, plane), and the variance (draw,) that chance makes of them.
    """
    flat = root.reshape(len(root), -1)
    rng, found = generator("largest scatter"), []
    for _ in range(0, _DRAWN, _BATCH):
        sets = (rng.standard_normal((_BATCH, count, len(root))) @ flat).reshape(_BATCH, count, *root.shape[1:])
        found.append(_log_deviations(sets - sets.mean(axis=1, keepdims=True)))
    spreads, chances, _ = zip(*found, strict=True)
    return np.concatenate(spreads), np.concatenate(chances)


def _root(alike: Floats, telling: float = 1.0) -> Floats:
    """Give a root of the covariance of planes (cycle, plane, k), of which any two have less in common than so few cycles make it seem.

    Each plane's own scatter is rounder than it seems, as far as so many telling planes make sure.
    """
    count, planes, size = alike.shape
    flat = alike.reshape(count, -1)
    covariance = (flat.T @ flat / (count - 1)).reshape(planes, size, planes, size)
    square = (covariance**2).sum(axis=(1, 3))
    own = np.sqrt(np.outer(np.diag(square), np.diag(square)))
    least = 1 / (count - 1)  # on the average, of two planes with nothing in common
    true = (square - least) / np.maximum(own - least, np.finfo(float).tiny) * own
    share = np.sqrt(np.clip(true / np.maximum(square, least), 0.0, 1.0))
    # What chance takes from a pair below zero is lost by the clip. The others give it up: all together have as much in common as on the average.
    np.fill_diagonal(true, 0.0)
    np.fill_diagonal(share, 0.0)
    kept = float((share**2 * square).sum())
    share *= math.sqrt(min(max(float(true.sum()) / kept, 0.0), 1.0)) if kept > 0 else 0.0
    np.fill_diagonal(share, 1.0)
    covariance *= share[:, None, :, None]
    each = np.arange(planes)
    covariance[each, :, each] = shrunk_covariance(covariance[each, :, each], count, telling)
    values, vectors = np.linalg.eigh(covariance.reshape(planes * size, -1))
    root = (vectors * np.sqrt(np.maximum(values, 0.0))).T
    trace = (root.reshape(-1, planes, size) ** 2).sum(axis=(0, 2))
    return np.asarray(root / np.repeat(np.sqrt(trace), size))


def _limit_repeatability(alike: Floats) -> Floats:
    """Give mean + 3 s of many distances for planes (cycle, plane, k) of trace one, made rounder by what samples are too unequal."""
    count, _, size = alike.shape
    covariance = shrunk_covariance(np.einsum("npi,npj->pij", alike, alike) / (count - 1), count)
    return expected_repeatability(np.pad(covariance, ((0, 0), (0, 3 - size), (0, 3 - size))))[0]


def _log_deviations(sets: Floats) -> tuple[Floats, Floats, Floats]:
    """Give log deviations (set, plane) of centred sets (set, cycle, plane, k), the variance (set,) that chance makes of them, and what is in common.

    A log deviation has the variance tr C^2 / (tr C)^2 / (2 (n - 1)), two planes' the covariance |C_12|^2 / (tr C_1 tr C_2) / (2 (n - 1)): what all
    have in common makes none differ. Of planes with nothing in common a sample shows 1 / (n - 1) on the average, and of those alike all.
    """
    count, _, size = sets.shape[1:]
    least = 1 / (count - 1)
    trace = (sets**2).sum(axis=(1, 3)) / (count - 1)
    alike = sets / np.sqrt(trace)[:, None, :, None]
    covariance = np.einsum("dnpi,dnpj->dpij", alike, alike) / (count - 1)
    own = (covariance**2).sum(axis=(2, 3))
    single = np.clip(unbiased_square(own, count), 1 / size, 1.0).mean(axis=1)
    flat = alike.reshape(*alike.shape[:2], -1)
    across = flat @ np.swapaxes(flat, 1, 2) if flat.shape[1] < flat.shape[2] else np.swapaxes(flat, 1, 2) @ flat
    seen = (across**2).sum(axis=(1, 2)) / (alike.shape[2] * (count - 1)) ** 2
    common = np.clip((seen - least) / np.maximum(own.mean(axis=1) - least, np.finfo(float).tiny), 0.0, 1.0)
    return np.log(trace) / 2, single * (1 - common) / (2 * (count - 1)), common


def _shrunk(spread: Floats, chance: Floats) -> Floats:
    """Draw log deviations (set, plane) towards their average, as far as what they differ by is chance (set,)."""
    mean = spread.mean(axis=1, keepdims=True)
    return np.asarray(mean + _kept_share(spread, chance, _true_share(spread, chance)) * (spread - mean))


def _kept_share(spread: Floats, chance: Floats, share: Floats) -> Floats:
    """Which part of its distance from the average does each log deviation (set, plane) keep, where planes on the whole keep this share (set,)?

    None is drawn further than by the deviation that chance makes, or a single bad place would be taken for chance (B. Efron and C. Morris, Limiting
    the risk of Bayes and empirical Bayes estimators, part II, JASA 67, 1972, p. 130).
    """
    furthest = np.sqrt(chance)[:, None]
    off = np.abs(spread - spread.mean(axis=1, keepdims=True))
    return np.asarray(np.maximum(share[:, None], 1 - furthest / np.maximum(off, np.maximum(furthest, np.finfo(float).tiny))))
