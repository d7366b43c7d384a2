"""Mean, standard deviation and quantiles of the magnitude |b + e| of a robot's position error at each pose, without sampling robots.

e is a sum of terms, S (3, term) in m per unit draw, about the bias b. There are two ways, and both state an uncertainty for every figure.

- `by_rays`: for nearly normal sums. The normal vector with its first correction for shape is integrated along fixed directions.
- `by_points`: for any sum. The draws are taken at the points of a scrambled Sobol sequence, the same for all poses.

`figures` takes rays where their correction is small at every level, and points elsewhere. `pooled_counts` counts the lengths of many poses together.

Sources: I. Deak, Numer. Math. 35 (1980) 475, and P. Bjerager, J. Eng. Mech. 114 (1988) 1285 (integration along rays); O. Barndorff-Nielsen and
D. Cox, Asymptotic Techniques (1989), ch. 6 (Edgeworth series of a vector); A. Owen, J. Complexity 14 (1998) 466 (scrambled nets).
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from lostmotion.error_model.closing import standardised
from lostmotion.error_model.error_bins import BINS
from lostmotion.propagation import error_magnitude_kernel as kernel

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from lostmotion.error_model.cumulants import Cumulants, Draws
    from lostmotion.spatial import Floats

LEVELS: Final = (0.5, 0.95, 0.99, 0.997)
RAYS: Final = 256
# Nodes of Gauss's rule along each ray, and where it ends, in standard deviations.
_NODES: Final = 16
_END: Final = 7.0
# Rays apply where the correction moves each quantile by at most this share of itself, and changes the density there by at most that share.
MOST_MOVED: Final = 0.02
MOST_DENSER: Final = 1 / 8
# Points of one pose and of each pose of a pooled histogram, in blocks whose differences give the standard error.
POINTS: Final = 16_384
POOLED_POINTS: Final = 4096
BLOCKS: Final = 8
# Uncertainties by points count so many standard errors: about 95 %.
_STANDARD_ERRORS: Final = 2.0
# Poses at a time, always cut in the same places: matrix products may round by their shape.
TILE: Final = 64
# A variance that is a smaller share of the largest is what rounding leaves of none.
_ROUNDING: Final = 1e-12
_PAIRS: Final = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))


@dataclass(frozen=True, slots=True)
class Magnitude:
    """Figures of the error's magnitude at each pose, m.

    values         (pose, 2 + level): mean, standard deviation, quantiles
    uncertainty    (pose, 2 + level): two standard errors of the points, or, for rays, what the correction for shape moves (docs/theory/accuracy.md)
    nearly_normal  (pose,) whether rays apply
    excess         (pose,) the scatter's mean fourth power against a normal vector's: 0 normal, below 0 flat or two-sided
    """

    values: Floats
    uncertainty: Floats
    nearly_normal: NDArray[np.bool_]
    excess: Floats


class Plays(NamedTuple):
    """What decides at poses where plays are closed in some robots only; the terms that change with it are the last ones.

    uniforms  (play, point): a play is closed where this is at most its share
    closed    (pose, play) share of the robots whose play is closed
    of_term   (term,) the play of each of these terms
    """

    uniforms: Floats
    closed: Floats
    of_term: NDArray[np.int64]


class Rays(NamedTuple):
    """What integrals along rays need: b . b (pose,), b . a and a . a (pose, ray), and the weights of 1, r ... r^4 along each (pose, 5, ray).

    Normal vectors share one set of weights (1, 5, ray).
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

    shift (pose, 3, term) m per unit draw, bias (pose, 3) m; draws(count) gives the draws (term, count) at so many points, as `sobol_draws` does.
    Where plays are closed in some robots only, `plays` at POINTS points, in the order of the cumulants' closings.
    """
    found = by_rays(shift, bias, cumulants, levels, None if plays is None else plays.closed)
    rest = np.flatnonzero(~found.nearly_normal)
    if len(rest):
        there = None if plays is None else plays._replace(closed=plays.closed[rest])
        found.values[rest], found.uncertainty[rest] = by_points(shift[rest], bias[rest], draws(POINTS), levels, there)
    return found


def by_rays(
    shift: Floats, bias: Floats, cumulants: Cumulants | None = None, levels: Sequence[float] = LEVELS, closed: Floats | None = None
) -> Magnitude:
    """Return the figures of nearly normal sums; without cumulants those of normal vectors. Valid where `nearly_normal` says so.

    shift (pose, 3, term) m per unit draw, bias (pose, 3) m, closed (pose, play) as in `Plays`.
    Mean and deviation by Gauss's rule, quantiles by Newton's method.
    """
    from scipy.special import ndtri

    count, wanted = len(bias), np.array(levels, float)
    values, uncertainty = np.empty((2, count, 2 + len(wanted)))
    normal, excess = np.ones(count, bool), np.zeros(count)
    for at in _tiles(count):
        deviations, axes = _principal(shift[at] @ shift[at].transpose(0, 2, 1), bias[at])
        forms = None
        if cumulants is not None:
            white = (axes / np.where(deviations > 0, deviations, np.inf)[:, None]).transpose(0, 2, 1) @ shift[at]
            forms = _forms(white, cumulants, None if closed is None else closed[at])
            excess[at] = _excess(forms, deviations)
        rays = _rays(deviations, axes, bias[at], forms)
        kernel.moments_along_rays(*rays, *_radii(), values[at])
        kernel.quantiles_along_rays(*rays, wanted, ndtri(wanted), (MOST_MOVED, MOST_DENSER), values[at], uncertainty[at], normal[at])
        still = at.start + np.flatnonzero(~deviations.any(axis=1))
        values[still] = np.linalg.norm(bias[still], axis=1, keepdims=True)
        values[still, 1] = uncertainty[still] = 0.0
    return Magnitude(values, uncertainty, normal, excess)


def rays_of(covariance: Floats, bias: Floats) -> Rays:
    """Return the rays of normal vectors: covariance (pose, 3, 3) m^2, bias (pose, 3) m. For `share_below`, which may be asked at many limits."""
    return _rays(*_principal(covariance, bias), bias, None)


def share_below(rays: Rays, limits: Floats) -> tuple[Floats, Floats]:
    """Return the share of magnitudes below limits (pose, limit), m, and its density there, 1/m."""
    shares, densities = np.empty((2, *limits.shape))
    kernel.shares_within(*rays, limits, shares, densities)
    return shares, densities


def _principal(covariance: Floats, bias: Floats) -> tuple[Floats, Floats]:
    """Return standard deviations (pose, 3) along the principal axes, and these (pose, 3, axis).

    The axes point to the side of the bias, so that the rays, and with them every figure, turn with the vector.
    """
    values, axes = np.linalg.eigh(covariance)
    axes = np.where(bias[:, None] @ axes < 0, -axes, axes)
    return np.sqrt(np.where(values > _ROUNDING * values[:, -1:], values, 0.0)), axes


def _rays(deviations: Floats, axes: Floats, bias: Floats, forms: Floats | None) -> Rays:
    """Return the rays of vectors with these principal axes, weighted by the correction for the cumulants in `forms`."""
    weights = np.zeros((1, 5, RAYS)) if forms is None else (forms @ _hermite()).reshape(-1, 5, RAYS)
    weights[:, 0] += 1
    # The mean weight is one but for what so many directions leave.
    mass = weights.mean(axis=2) @ np.array([1, 2 * math.sqrt(2 / math.pi), 3, 8 * math.sqrt(2 / math.pi), 15])
    across = deviations**2 @ _directions() ** 2
    along = ((bias[:, None] @ axes)[:, 0] * deviations) @ _directions()
    return Rays(
        (bias**2).sum(axis=1), along, np.maximum(across, 1e-18 * across.max(axis=1, keepdims=True) + 1e-300), weights / (RAYS * mass[:, None, None])
    )


# ---- Cumulants of the sum as forms: k_ijk h_i h_j h_k and k_ijkl h_i h_j h_k h_l, by the coefficients of their monomials in h.


@functools.cache
def _powers(order: int) -> tuple[tuple[int, int, int], ...]:
    """Return the exponents of x, y, z in the monomials of this order."""
    return tuple((i, j, order - i - j) for i in range(order + 1) for j in range(order + 1 - i))


def _forms(white: Floats, known: Cumulants, closed: Floats | None) -> Floats:
    """Return the coefficients (pose, 10 + 15) of the third and fourth forms of sums white (pose, 3, term) @ draws."""
    threes, fours = known.third.terms, known.fourth.terms

    def pairs(terms: NDArray[np.int64]) -> Floats:
        one, two = white[:, :, terms[:, 0]], white[:, :, terms[:, 1]]
        return np.stack([one[:, i] * two[:, j] + (one[:, j] * two[:, i] if i != j else 0.0) for i, j in _PAIRS], axis=1)

    third = pairs(threes) * known.third.at(closed) @ white[:, :, threes[:, 2]].transpose(0, 2, 1)
    fourth = pairs(fours) * known.fourth.at(closed) @ pairs(fours[:, 2:]).transpose(0, 2, 1)
    return np.concatenate([third.reshape(len(white), -1) @ _collect(3), fourth.reshape(len(white), -1) @ _collect(4)], axis=1)


@functools.cache
def _collect(order: int) -> Floats:
    """Return which monomial each product of a pair of axes with an axis (order 3) or a pair (order 4) belongs to (product, monomial)."""
    others: tuple[tuple[int, ...], ...] = ((0,), (1,), (2,)) if order == 3 else _PAIRS  # noqa: PLR2004 - the order itself
    products = [pair + other for pair in _PAIRS for other in others]
    return np.array([[tuple(map(axes.count, range(3))) == powers for powers in _powers(order)] for axes in products], float)


def _excess(forms: Floats, deviations: Floats) -> Floats:
    """Return k_iijj over the mean fourth power of a normal vector, (tr C)^2 + 2 tr C^2, by the fourth form of the whitened sum (pose,)."""
    fourth, variances = forms[:, len(_powers(3)) :], deviations**2
    traced = np.zeros(len(forms))
    for column, powers in enumerate(_powers(4)):
        if all(power % 2 == 0 for power in powers):
            # x^4 holds k_xxxx once; x^2 y^2 holds k_xxyy six times, of which the trace has two
            share = 1.0 if max(powers) == 4 else 1 / 3  # noqa: PLR2004 - x^4
            traced += share * fourth[:, column] * np.prod(deviations ** np.array(powers), axis=1)
    normal = variances.sum(axis=1) ** 2 + 2 * (variances**2).sum(axis=1)
    return np.asarray(traced / np.where(normal > 0, normal, 1.0))


@functools.cache
def _hermite() -> Floats:
    """Return what each coefficient of the forms adds to the weights along the rays (10 + 15, 5 x ray): Hermite's tensors, k3 : H3 / 6 + k4 : H4 / 24.

    Along r u these are (k_uuu r^3 - 3 k_iiu r) / 6 and (k_uuuu r^4 - 6 k_iiuu r^2 + 3 k_iijj) / 24. A trace is a Laplacian of the form.
    """
    u = {order: np.array([np.prod(_directions() ** np.array(powers)[:, None], axis=0) for powers in _powers(order)]) for order in (0, 1, 2, 3, 4)}
    out = np.zeros((25, 5, RAYS))
    third, fourth = out[: len(_powers(3))], out[len(_powers(3)) :]
    third[:, 3], third[:, 1] = u[3] / 6, -_laplacian(3) @ u[1] / 12
    fourth[:, 4], fourth[:, 2], fourth[:, 0] = u[4] / 24, -_laplacian(4) @ u[2] / 48, _laplacian(4) @ _laplacian(2) @ u[0] / 192
    return out.reshape(25, -1)


@functools.cache
def _laplacian(order: int) -> Floats:
    """Return the Laplacian of each monomial of this order by monomials two orders lower (monomial, monomial)."""
    out = np.zeros((len(_powers(order)), len(_powers(order - 2))))
    for row, powers in enumerate(_powers(order)):
        for column, lower in enumerate(_powers(order - 2)):
            taken = np.subtract(powers, lower)
            if sorted(taken) == [0, 0, 2]:
                power = powers[int(np.argmax(taken))]
                out[row, column] = power * (power - 1)
    return out


@functools.cache
def _directions() -> Floats:
    """Return evenly spread unit vectors (3, ray): the golden spiral, aligned with no axis."""
    n = np.arange(RAYS) + 0.5
    z, angle = 1 - 2 * n / RAYS, 4 * math.pi * n / (1 + math.sqrt(5))
    return np.stack([np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z])


@functools.cache
def _radii() -> tuple[Floats, Floats]:
    """Return nodes along a ray and the shares of a standard normal vector that they stand for."""
    x, weights = np.polynomial.legendre.leggauss(_NODES)
    r = _END * (x + 1) / 2
    shares = weights * r**2 * np.exp(-(r**2) / 2)
    return r, shares / shares.sum()


# ---- Points


def sobol_draws(terms: Sequence[Draws], importance: Mapping[Hashable, float], count: int, seed: int = 0) -> Floats:
    """Return draws (term, count) at the points of a scrambled Sobol sequence; the most important streams take its first coordinates.

    terms: of each the streams whose draws it multiplies, with their distributions; importance: the size of every stream.
    """
    from scipy.stats import qmc

    order = {stream: n for n, stream in enumerate(sorted(importance, key=lambda stream: -importance[stream]))}
    if not order:
        return np.ones((len(terms), count))
    points = qmc.Sobol(len(order), scramble=True, rng=np.random.default_rng(seed)).random(count)
    u = np.clip(points, 1e-12, 1 - 1e-12).T
    return np.array([np.prod([np.ones(count), *(law.quantile(u[order[stream]]) for stream, law in term)], axis=0) for term in terms])


def by_points(shift: Floats, bias: Floats, draws: Floats, levels: Sequence[float] = LEVELS, plays: Plays | None = None) -> tuple[Floats, Floats]:
    """Return values and uncertainty (pose, 2 + level) from draws (term, point), as in `Magnitude`."""
    values, uncertainty = np.empty((2, len(bias), 2 + len(levels)))
    for at, squares in _squares(shift, bias, draws, plays):
        kernel.figures_of_lengths(squares, np.array(levels, float), _STANDARD_ERRORS, values[at], uncertainty[at])
    return values, uncertainty


def pooled_counts(shift: Floats, bias: Floats, draws: Floats, plays: Plays | None = None) -> NDArray[np.int64]:
    """Return how many lengths of all these poses fall into each bin, by block of points (BLOCKS, bin); bins as `error_bins`."""
    counts = np.zeros((BLOCKS, BINS), np.int64)
    for _, squares in _squares(shift, bias, draws, plays):
        kernel.count_lengths(squares, counts)
    return counts


def _squares(shift: Floats, bias: Floats, draws: Floats, plays: Plays | None) -> Iterator[tuple[slice, NDArray[np.float32]]]:
    """Yield some poses and their squared lengths (pose, block, point), m^2. Over the points every draw has mean zero."""
    if plays is not None:
        yield from _squares_with_plays(shift, bias, draws, plays)
        return
    pad = -len(draws) % 4
    centred = np.pad((draws - draws.mean(axis=1, keepdims=True)).astype(np.float32), ((0, pad), (0, 0)))
    room = np.empty((TILE, draws.shape[1]), np.float32)
    for at in _tiles(len(bias)):
        steps = np.pad(shift[at].astype(np.float32), ((0, 0), (0, 0), (0, pad)))
        out = room[: len(steps)]
        kernel.squared_lengths(steps, bias[at].astype(np.float32), centred, out)
        yield at, out.reshape(len(steps), BLOCKS, -1)


def _squares_with_plays(shift: Floats, bias: Floats, draws: Floats, plays: Plays) -> Iterator[tuple[slice, NDArray[np.float32]]]:
    """Yield the same pose by pose, where draws differ: of the last terms only those count whose play is closed in some robots here."""
    steady = len(draws) - len(plays.of_term)
    room = np.zeros((len(draws) + 3, draws.shape[1]), np.float32)
    room[:steady] = draws[:steady] - draws[:steady].mean(axis=1, keepdims=True)
    for p, closed in enumerate(plays.closed):
        some = np.flatnonzero((closed > 0) & (closed < 1))
        there = np.concatenate([np.arange(steady), *(steady + np.flatnonzero(plays.of_term == play) for play in some)])
        for row, term in enumerate(there[steady:], steady):
            play = plays.of_term[term - steady]
            drawn = draws[term] * standardised(plays.uniforms[play], closed[play, None])
            room[row] = drawn - drawn.mean()
        last = len(there) + -len(there) % 4
        room[len(there) : last] = 0.0
        step = np.zeros((1, 3, last), np.float32)
        step[0, :, : len(there)] = shift[p][:, there]
        out = np.empty((1, draws.shape[1]), np.float32)
        kernel.squared_lengths(step, bias[p : p + 1].astype(np.float32), room[:last], out)
        yield slice(p, p + 1), out.reshape(1, BLOCKS, -1)


def _tiles(count: int) -> list[slice]:
    return [slice(first, min(first + TILE, count)) for first in range(0, count, TILE)]
