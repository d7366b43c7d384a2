"""Log deviations of the planes of a path: how much they differ by chance, how far they are shrunk,
and those of simulated tests of as many cycles.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.visit_intervals import MIN_VISITS, generator, unbiased_square

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.spatial import Floats

SAMPLES: Final = 2000
_BATCH: Final = 100


def true_share(values: Floats, chance: Floats) -> Floats:
    """Return the share (set,) of the variance of values (set, plane) that exceeds their sampling
    variance (set,).
    """
    if values.shape[1] < MIN_VISITS:
        return np.ones(len(values))
    seen = values.var(axis=1, ddof=1)
    return np.asarray(np.clip(1 - chance / np.where(seen > 0, seen, np.inf), 0.0, 1.0))


def log_deviations(sets: Floats) -> tuple[Floats, Floats, Floats]:
    """Return log deviations (set, plane) of centred sets (set, cycle, plane, k), their sampling
    variance (set,), and the planes' correlation (set,).

    A log deviation has the variance tr C^2 / (tr C)^2 / (2 (n - 1)), a pair of planes the
    covariance |C_12|^2 / (tr C_1 tr C_2) / (2 (n - 1)). What all planes share does not make them
    differ. The squared sample correlation of independent planes averages 1 / (n - 1), that of
    identical planes one.
    """
    count = sets.shape[1]
    trace = (sets**2).sum(axis=(1, 3)) / (count - 1)
    standardised = sets / np.sqrt(trace)[:, None, :, None]
    covariance = np.einsum("dnpi,dnpj->dpij", standardised, standardised) / (count - 1)
    chance, common = _chance(
        (covariance**2).sum(axis=(2, 3)),
        standardised.reshape(*standardised.shape[:2], -1),
        sets.shape[3],
    )
    return np.log(trace) / 2, chance, common


def _chance(own: Floats, flat: Floats, size: int) -> tuple[Floats, Floats]:
    """Return the sampling variance (set,) of the log deviations and the planes' correlation (set,).

    own (set, plane) is tr C^2 / (tr C)^2 of each plane, flat (set, cycle, plane x size) are the
    standardised vectors in any order within a cycle.
    """
    count, planes = flat.shape[1], own.shape[1]
    least = 1 / (count - 1)
    single = np.clip(unbiased_square(own, count), 1 / size, 1.0).mean(axis=1)
    across = (
        flat @ np.swapaxes(flat, 1, 2)
        if flat.shape[1] < flat.shape[2]
        else np.swapaxes(flat, 1, 2) @ flat
    )
    seen = (across**2).sum(axis=(1, 2)) / (planes * (count - 1)) ** 2
    common = np.clip(
        (seen - least) / np.maximum(own.mean(axis=1) - least, np.finfo(float).tiny), 0.0, 1.0
    )
    return single * (1 - common) / (2 * (count - 1)), common


def shrunk_deviations(spread: Floats, chance: Floats) -> Floats:
    """Return log deviations (set, plane) shrunk towards their mean by their sampling variance
    (set,).
    """
    mean = spread.mean(axis=1, keepdims=True)
    return np.asarray(
        mean + kept_share(spread, chance, true_share(spread, chance)) * (spread - mean)
    )


def kept_share(spread: Floats, chance: Floats, share: Floats) -> Floats:
    """Return the share (set, plane) of its distance from the mean that each log deviation keeps,
    given the overall share (set,).

    None is shrunk by more than one standard deviation of the sampling variance, which would treat a
    single bad plane as chance (B. Efron and C. Morris, Limiting the risk of Bayes and empirical
    Bayes estimators, part II, JASA 67, 1972, p. 130).
    """
    furthest = np.sqrt(chance)[:, None]
    off = np.abs(spread - spread.mean(axis=1, keepdims=True))
    return np.asarray(
        np.maximum(
            share[:, None],
            1 - furthest / np.maximum(off, np.maximum(furthest, np.finfo(float).tiny)),
        )
    )


def simulated_tests(root: Floats, count: int) -> tuple[Floats, Floats]:
    """Return log deviations (draw, plane) and their sampling variance (draw,) of simulated tests
    with this number of cycles.

    `root` (root, plane, k) is a root of the covariance.
    """
    roots, planes, size = root.shape
    # Components before planes: sums over cycles and components then run along whole rows.
    flat = np.swapaxes(root, 1, 2).reshape(roots, -1)
    pairs = [(i, j) for i in range(size) for j in range(i + 1)]
    rng, spreads, chances = generator("largest scatter"), [], []
    draws, moved = (np.empty((_BATCH * count, each)) for each in flat.shape)
    sets = moved.reshape(_BATCH, count, size, planes)
    for _ in range(0, SAMPLES, _BATCH):
        np.matmul(rng.standard_normal(out=draws), flat, out=moved)
        sets -= sets.mean(axis=1, keepdims=True)
        own, sums = np.zeros((_BATCH, planes)), np.zeros((_BATCH, planes))
        for i, j in pairs:
            products = np.einsum("dnp,dnp->dp", sets[:, :, i], sets[:, :, j])
            own += (1 if i == j else 2) * products**2
            sums += products if i == j else 0.0
        variance = sums / (count - 1)
        sets /= np.sqrt(variance)[:, None, None]
        spreads.append(np.log(variance) / 2)
        chances.append(_chance(own / sums**2, moved.reshape(_BATCH, count, -1), size)[0])
    return np.concatenate(spreads), np.concatenate(chances)


def exceedance(spread: Floats, chance: Floats, many: Floats) -> Callable[[Floats, float], float]:
    """Return a function of offsets (plane,) and a limit: how often the largest of the log
    deviations (draw, plane) of simulated tests, moved by the offsets, shrunk, and with `many`
    (plane,) added, is at least the limit.
    """
    middle, planes = spread.mean(axis=1), spread.shape[1]
    # Planes before draws: an inversion evaluates this some fifty times, each along whole rows and
    # in the same memory.
    away = np.ascontiguousarray((spread - middle[:, None]).T)
    off, near = np.empty_like(away), np.empty_like(away)
    furthest = np.sqrt(chance)

    def share(offsets: Floats, limit: float) -> float:
        np.add(away, (offsets - offsets.mean())[:, None], out=off)
        kept = np.ones(len(middle))
        if planes >= MIN_VISITS:
            seen = np.square(off, out=near).sum(axis=0) / (planes - 1)
            kept = np.clip(1 - chance / np.where(seen > 0, seen, np.inf), 0.0, 1.0)
        np.multiply(off, kept, out=near)
        # as in kept_share: at most one standard deviation nearer to the mean
        np.maximum(near, np.subtract(off, furthest, out=off), out=near)
        np.minimum(near, np.add(off, 2 * furthest, out=off), out=near)
        np.add(near, many[:, None], out=near)
        return float((near.max(axis=0) >= limit - offsets.mean() - middle).mean())

    return share
