"""Mean, standard deviation and quantiles of the magnitude |b + e| of a robot's position error at
each pose, without sampling robots.

e is a sum of terms, S (3, term) in m per unit draw, about the bias b. There are two ways, and both
state an uncertainty for every figure.

- `by_rays`: for nearly normal sums. The normal vector with its first correction for shape is
  integrated along fixed directions.
- `by_points`: for any sum. The draws are taken at the points of a scrambled Sobol sequence, the
  same for all poses.

`figures` takes rays where their correction is small at every level, and points elsewhere.
`pooled_counts` counts the lengths of many poses together.

Sources: I. Deak, Numer. Math. 35 (1980) 475, and P. Bjerager, J. Eng. Mech. 114 (1988) 1285
(integration along rays); O. Barndorff-Nielsen and D. Cox, Asymptotic Techniques (1989), ch. 6
(Edgeworth series of a vector); A. Owen, J. Complexity 14 (1998) 466 (scrambled nets).
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from lostmotion.error_model.closing import closed_in_some, standardised
from lostmotion.error_model.error_bins import BINS
from lostmotion.propagation import error_magnitude_kernel as kernel
from lostmotion.propagation.shape_correction import (
    RAYS,
    directions,
    excess_of,
    forms_of,
    hermite_weights,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from lostmotion.error_model.cumulants import Cumulants, Draws
    from lostmotion.spatial import Floats


LEVELS: Final = (0.5, 0.95, 0.99, 0.997)
# Nodes of Gauss's rule along each ray, and where it ends, in standard deviations.
_NODES: Final = 16
_END: Final = 7.0
# Rays apply where the correction moves each quantile by at most this share of itself, and changes
# the density there by at most that share.
MOST_MOVED: Final = 0.02
MOST_DENSER: Final = 1 / 8
# Points of one pose and of each pose of a pooled histogram, in blocks whose differences give the
# standard error.
POINTS: Final = 16_384
POOLED_POINTS: Final = 4096
BLOCKS: Final = 8
# Uncertainties by points are this number of standard errors: about 95 %.
_STANDARD_ERRORS: Final = 2.0
# Poses at a time. Tiles always start at the same poses, since the rounding of matrix products may
# depend on their shape.
TILE: Final = 64
# A variance that is a smaller share of the largest one is rounding, and counts as zero.
_ROUNDING: Final = 1e-12


@dataclass(frozen=True, slots=True)
class Magnitude:
    """Figures of the error's magnitude at each pose, m.

    values         (pose, 2 + level): mean, standard deviation, quantiles
    uncertainty    (pose, 2 + level): two standard errors of the points, or, for rays, what the
                   correction for shape moves (docs/theory/accuracy.md)
    nearly_normal  (pose,) whether rays apply
    excess         (pose,) the scatter's mean fourth power against a normal vector's: 0 normal,
                   below 0 flat or two-sided
    """

    values: Floats
    uncertainty: Floats
    nearly_normal: NDArray[np.bool_]
    excess: Floats


class Plays(NamedTuple):
    """Plays that are closed in some robots only. The terms that depend on them are the last ones.

    uniforms  (play, point) a play is closed at points where this is at most its share
    closed    (pose, play) share of the robots whose play is closed
    of_term   (term,) number of the play on which each of the last terms depends
    """

    uniforms: Floats
    closed: Floats
    of_term: NDArray[np.int64]


class Rays(NamedTuple):
    """Rays b + r a of a vector with bias b, for integrals along them; r is in standard deviations.

    square   (pose,) b . b, m^2
    along    (pose, ray) b . a, m^2
    across   (pose, ray) a . a, m^2
    weights  (pose, 5, ray) of 1, r ... r^4; normal vectors share one set (1, 5, ray)
    """

    square: Floats
    along: Floats
    across: Floats
    weights: Floats


def figures(
    shift: Floats,
    bias: Floats,
    cumulants: Cumulants,
    draws: Callable[[int], Floats],
    levels: Sequence[float] = LEVELS,
    plays: Plays | None = None,
) -> Magnitude:
    """Return the figures of every pose: by rays where they apply, by points elsewhere.

    shift   (pose, 3, term) m per unit draw
    bias    (pose, 3) m
    draws   returns the draws (term, count) at `count` points, as `sobol_draws` does
    levels  shares of the quantiles, 0..1
    plays   the plays that are closed in some robots only, at POINTS points, in the order of the
            cumulants' closings
    """
    found = by_rays(shift, bias, cumulants, levels, None if plays is None else plays.closed)
    rest = np.flatnonzero(~found.nearly_normal)
    if len(rest):
        there = None if plays is None else plays._replace(closed=plays.closed[rest])
        found.values[rest], found.uncertainty[rest] = by_points(
            shift[rest], bias[rest], draws(POINTS), levels, there
        )
    return found


def by_rays(
    shift: Floats,
    bias: Floats,
    cumulants: Cumulants | None = None,
    levels: Sequence[float] = LEVELS,
    closed: Floats | None = None,
) -> Magnitude:
    """Return the figures of nearly normal sums; without cumulants those of normal vectors. Valid
    where `nearly_normal` is true.

    shift (pose, 3, term) m per unit draw, bias (pose, 3) m, closed (pose, play) as in `Plays`.
    Mean and standard deviation are by Gauss's rule, quantiles by Newton's method.
    """
    from scipy.special import ndtri

    count, wanted = len(bias), np.array(levels, float)
    values, uncertainty = np.empty((2, count, 2 + len(wanted)))
    normal, excess = np.ones(count, bool), np.zeros(count)
    for at in _tiles(count):
        deviations, axes = _principal(shift[at] @ shift[at].transpose(0, 2, 1), bias[at])
        forms = None
        if cumulants is not None:
            white = (axes / np.where(deviations > 0, deviations, np.inf)[:, None]).transpose(
                0, 2, 1
            ) @ shift[at]
            forms = forms_of(white, cumulants, None if closed is None else closed[at])
            excess[at] = excess_of(forms, deviations)
        rays = _rays(deviations, axes, bias[at], forms)
        kernel.moments_along_rays(*rays, *_radii(), values[at])
        kernel.quantiles_along_rays(
            *rays,
            wanted,
            ndtri(wanted),
            (MOST_MOVED, MOST_DENSER),
            values[at],
            uncertainty[at],
            normal[at],
        )
        constant = at.start + np.flatnonzero(~deviations.any(axis=1))
        values[constant] = np.linalg.norm(bias[constant], axis=1, keepdims=True)
        values[constant, 1] = uncertainty[constant] = 0.0
    return Magnitude(values, uncertainty, normal, excess)


def rays_of(covariance: Floats, bias: Floats) -> Rays:
    """Return the rays of normal vectors, for any number of calls of `share_below`: covariance
    (pose, 3, 3) m^2, bias (pose, 3) m.
    """
    return _rays(*_principal(covariance, bias), bias, None)


def share_below(rays: Rays, limits: Floats) -> tuple[Floats, Floats]:
    """Return the share of magnitudes below limits (pose, limit), m, and its density there, 1/m."""
    shares, densities = np.empty((2, *limits.shape))
    kernel.shares_within(*rays, limits, shares, densities)
    return shares, densities


def _principal(covariance: Floats, bias: Floats) -> tuple[Floats, Floats]:
    """Return the standard deviations (pose, 3) along the principal axes, m, and the axes (pose, 3,
    axis).

    The axes point to the side of the bias, so that the rays, and therefore all figures, do not
    depend on the orientation of the base frame.
    """
    values, axes = np.linalg.eigh(covariance)
    axes = np.where(bias[:, None] @ axes < 0, -axes, axes)
    return np.sqrt(np.where(values > _ROUNDING * values[:, -1:], values, 0.0)), axes


def _rays(deviations: Floats, axes: Floats, bias: Floats, forms: Floats | None) -> Rays:
    """Return the rays of vectors with these principal axes, weighted by the correction for the
    cumulants in `forms`.
    """
    weights = (
        np.zeros((1, 5, RAYS))
        if forms is None
        else (forms @ hermite_weights()).reshape(-1, 5, RAYS)
    )
    weights[:, 0] += 1
    # The mean weight would be one if the directions were exactly uniform.
    mass = weights.mean(axis=2) @ np.array(
        [1, 2 * math.sqrt(2 / math.pi), 3, 8 * math.sqrt(2 / math.pi), 15]
    )
    across = deviations**2 @ directions() ** 2
    along = ((bias[:, None] @ axes)[:, 0] * deviations) @ directions()
    return Rays(
        (bias**2).sum(axis=1),
        along,
        np.maximum(across, 1e-18 * across.max(axis=1, keepdims=True) + 1e-300),
        weights / (RAYS * mass[:, None, None]),
    )


# ---- Cumulants of the sum as forms: k_ijk h_i h_j h_k and k_ijkl h_i h_j h_k h_l, by the
# coefficients of their monomials in h.


@functools.cache
def _radii() -> tuple[Floats, Floats]:
    """Return nodes along a ray, in standard deviations, and the share of a standard normal vector
    at each of them; both (node,).
    """
    x, weights = np.polynomial.legendre.leggauss(_NODES)
    r = _END * (x + 1) / 2
    shares = weights * r**2 * np.exp(-(r**2) / 2)
    return r, shares / shares.sum()


# ---- Points


def sobol_draws(
    terms: Sequence[Draws], importance: Mapping[Hashable, float], count: int, seed: int = 0
) -> Floats:
    """Return draws (term, count) at the points of a scrambled Sobol sequence; the most important
    streams use its first coordinates.

    terms       for each term the streams whose draws it multiplies, with their distributions
    importance  importance of every stream; only the order matters
    """
    from scipy.stats import qmc

    order = {
        stream: n
        for n, stream in enumerate(sorted(importance, key=lambda stream: -importance[stream]))
    }
    if not order:
        return np.ones((len(terms), count))
    points = qmc.Sobol(len(order), scramble=True, rng=np.random.default_rng(seed)).random(count)
    u = np.clip(points, 1e-12, 1 - 1e-12).T
    return np.array(
        [
            np.prod(
                [np.ones(count), *(law.quantile(u[order[stream]]) for stream, law in term)], axis=0
            )
            for term in terms
        ]
    )


def by_points(
    shift: Floats,
    bias: Floats,
    draws: Floats,
    levels: Sequence[float] = LEVELS,
    plays: Plays | None = None,
) -> tuple[Floats, Floats]:
    """Return values and uncertainty (pose, 2 + level) as in `Magnitude`, from draws (term, point);
    other arguments as for `figures`.
    """
    values, uncertainty = np.empty((2, len(bias), 2 + len(levels)))
    for at, squares in _squares(shift, bias, draws, plays):
        kernel.figures_of_lengths(
            squares, np.array(levels, float), _STANDARD_ERRORS, values[at], uncertainty[at]
        )
    return values, uncertainty


def pooled_counts(
    shift: Floats, bias: Floats, draws: Floats, plays: Plays | None = None
) -> NDArray[np.int64]:
    """Return the number of magnitudes of all these poses in each bin of `error_bins`, by block of
    points (BLOCKS, bin).
    """
    counts = np.zeros((BLOCKS, BINS), np.int64)
    for _, squares in _squares(shift, bias, draws, plays):
        kernel.count_lengths(squares, counts)
    return counts


def _squares(
    shift: Floats, bias: Floats, draws: Floats, plays: Plays | None
) -> Iterator[tuple[slice, NDArray[np.float32]]]:
    """Yield tiles of poses and their squared magnitudes (pose, block, point), m^2. The mean of
    every draw over the points is subtracted.
    """
    if plays is not None:
        yield from _squares_with_plays(shift, bias, draws, plays)
        return
    pad = -len(draws) % 4
    centred = np.pad(
        (draws - draws.mean(axis=1, keepdims=True)).astype(np.float32), ((0, pad), (0, 0))
    )
    buffer = np.empty((TILE, draws.shape[1]), np.float32)
    for at in _tiles(len(bias)):
        steps = np.pad(shift[at].astype(np.float32), ((0, 0), (0, 0), (0, pad)))
        out = buffer[: len(steps)]
        kernel.squared_lengths(steps, bias[at].astype(np.float32), centred, out)
        yield at, out.reshape(len(steps), BLOCKS, -1)


def _squares_with_plays(
    shift: Floats, bias: Floats, draws: Floats, plays: Plays
) -> Iterator[tuple[slice, NDArray[np.float32]]]:
    """Yield the same for single poses with plays: of the last terms, only those count whose play is
    closed in some robots at the pose.
    """
    steady = len(draws) - len(plays.of_term)
    buffer = np.zeros((len(draws) + 3, draws.shape[1]), np.float32)
    buffer[:steady] = draws[:steady] - draws[:steady].mean(axis=1, keepdims=True)
    for p, closed in enumerate(plays.closed):
        some = np.flatnonzero(closed_in_some(closed))
        active = np.concatenate(
            [np.arange(steady), *(steady + np.flatnonzero(plays.of_term == play) for play in some)]
        )
        for row, term in enumerate(active[steady:], steady):
            play = plays.of_term[term - steady]
            drawn = draws[term] * standardised(plays.uniforms[play], closed[play, None])
            buffer[row] = drawn - drawn.mean()
        last = len(active) + -len(active) % 4
        buffer[len(active) : last] = 0.0
        step = np.zeros((1, 3, last), np.float32)
        step[0, :, : len(active)] = shift[p][:, active]
        out = np.empty((1, draws.shape[1]), np.float32)
        kernel.squared_lengths(step, bias[p : p + 1].astype(np.float32), buffer[:last], out)
        yield slice(p, p + 1), out.reshape(1, BLOCKS, -1)


def _tiles(count: int) -> list[slice]:
    return [slice(first, min(first + TILE, count)) for first in range(0, count, TILE)]
