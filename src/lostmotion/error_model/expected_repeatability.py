"""Expected value and standard deviation of RP_l for normally distributed visits, without sampling.

RP_l = mean(l) + 3 s of the lengths l of the deviations from the barycentre. These deviations are
normal vectors with 1 - 1/n of the covariance, each pair correlated by -1/(n - 1). The mean squares
of mean(l) and of s follow from pairs of lengths; E s and E mean(l) s follow from the Taylor series
of the root of s^2 with the joint cumulants of mean(l) and s^2: those of independent lengths (R.
Fisher's k-statistics; M. Kendall, A. Stuart, The Advanced Theory of Statistics, vol. 1, ch. 12),
and those due to the common barycentre (F. Mehler's expansion in the correlation). All terms up to
third order in 1/n are included.
"""

from __future__ import annotations

from math import comb, factorial
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.spatial import Floats

_PAIR: Final = 2
_AXES: Final = 3
_HIGHEST: Final = 8
_STEP: Final = 0.5
# Laplace variable. The integrands are analytic within pi of the real axis of its logarithm: the
# quadrature error falls as exp(-2 pi^2 / step).
_NODES: Final = np.exp(np.arange(-60.0, 60.0 + _STEP, _STEP))


def visit_covariance(matrix: PoseMatrix) -> Floats:
    """Return the covariance of a robot's visits (pose, 3, 3), m^2, averaged over robots: exact sum
    over terms.
    """
    errors = matrix.merged
    shift = errors.tool[:, 3:][:, :, errors.columns("visit", "robot x visit")]
    return np.asarray(shift @ np.swapaxes(shift, 1, 2))


def expected_repeatability(covariance: Floats, visits: int | None = None) -> tuple[Floats, Floats]:
    """Return the expected RP_l and its standard deviation, both (n,), for normal scatter with this
    covariance (n, 3, 3).

    `visits` is the number of visits per set; None: the limit for many visits, standard deviation 0.
    Exact for two visits, else a series to the third order in 1 / visits, for any rank and shape of
    the covariance. Largest error against brute-force sampling, in %:

        visits               30     10     7      5     4     3
        expected value       0.01   0.05   0.05   0.2   0.8   1.1
        standard deviation   0.05   0.3    0.5    2     3     11

    Not valid for scatter dominated by a few two-valued or uniform errors. NaN for covariances that
    are not finite. Raises ValueError for fewer than two visits.
    """
    if visits is not None and visits < _PAIR:
        raise ValueError(f"{visits} visit; repeatability needs at least 2")
    covariance = np.asarray(covariance, dtype=float)
    known = np.asarray(np.isfinite(covariance).all(axis=(1, 2)))
    variances = np.maximum(np.linalg.eigvalsh(np.where(known[:, None, None], covariance, 0.0)), 0.0)
    total: Floats = variances.sum(axis=1)
    shares = np.where(
        total[:, None] > 0, variances / np.where(total > 0, total, 1.0)[:, None], 1 / _AXES
    )
    mean, deviation = _standardised(shares, visits)
    size = np.where(known, np.sqrt(total), np.nan)
    return np.asarray(size * mean), np.asarray(size * deviation)


def _standardised(shares: Floats, visits: int | None) -> tuple[Floats, Floats]:
    """Return expected value and standard deviation for variances along the principal axes (n, 3)
    that sum to one.
    """
    lengths = length_moments(shares)
    mean = lengths[1]
    spread = np.sqrt(1 - mean**2)
    if visits is None:
        return mean + 3 * spread, np.zeros_like(mean)
    shorter = np.sqrt(1 - 1 / visits)
    if visits == _PAIR:  # both are equally far from their midpoint: s = 0
        return shorter * mean, shorter * spread
    # Tilting a normal density by y_i^2 / variance_i changes the length as two more axes with this
    # variance would.
    wider = length_moments(
        np.concatenate(
            [np.tile(shares[:, None], (1, _AXES, 1)), np.repeat(shares[:, :, None], 2, axis=2)],
            axis=2,
        )
    )
    tilted = [one - other[:, None] for one, other in zip(wider, lengths, strict=True)]
    above_mean, square = _series_coefficients(
        _central_moments(lengths, mean, spread),
        _central_moments(tilted, mean[:, None], spread[:, None]),
    )
    powers = (1 / visits) ** np.arange(4)[:, None]
    return shorter * (
        mean + spread * (above_mean * powers).sum(axis=0)
    ), shorter * spread * np.sqrt((square * powers).sum(axis=0))


def length_moments(variances: Floats) -> list[Floats]:
    """Return the moments E l^p (...) for p from 0 to 8 of the length l of a normal vector with
    these variances (..., axis) along its axes.

    Even moments in closed form; odd ones from the transform E exp(-u l^2) and its derivatives by a
    trapezoidal rule in log u. Relative error 1e-11 for variances of about unit sum, including
    zeros.
    """
    shrunk = 1 / (1 + 2 * _NODES[:, None] * variances[..., None, :])
    weight = _STEP / np.sqrt(np.pi) * np.sqrt(_NODES * shrunk.prod(axis=-1))
    odd, even = _square_moments(variances[..., None, :] * shrunk), _square_moments(variances)
    out = [np.ones(variances.shape[:-1])]
    for tilted, plain in zip(odd, even, strict=True):
        out += [np.asarray((weight * tilted).sum(axis=-1)), plain]
    return out


def _square_moments(variances: Floats) -> list[Floats]:
    """Return the first four moments of the squared length, whose cumulants are 2^(r-1) (r-1)! times
    the sums of the variances' powers.
    """
    moments: list[Floats] = [np.ones(variances.shape[:-1])]
    cumulants = [
        np.asarray(2 ** (r - 1) * factorial(r - 1) * (variances**r).sum(axis=-1))
        for r in range(1, _HIGHEST // 2 + 1)
    ]
    for r in range(1, len(cumulants) + 1):
        moments.append(
            sum(
                (comb(r - 1, j - 1) * cumulants[j - 1] * moments[r - j] for j in range(1, r + 1)),
                start=np.zeros_like(moments[0]),
            )
        )
    return moments[1:]


def _central_moments(raw: list[Floats], mean: Floats, spread: Floats) -> list[Floats]:
    """Return the standardised central moments of ((l - mean) / spread)^p from the raw moments of
    l^p, p = 0, 1, ...
    """
    return [
        sum(
            (comb(p, k) * raw[k] * (-mean) ** (p - k) for k in range(p + 1)),
            start=np.zeros_like(raw[0]),
        )
        / spread**p
        for p in range(len(raw))
    ]


def _series_coefficients(central: list[Floats], tilted: list[Floats]) -> tuple[Floats, Floats]:
    """Return the coefficients, by powers of 1/n (4, ...), of mean and variance of RP_l for
    standardised lengths z.

    `central` holds the central moments (...), `tilted` the moments of z^p under a density tilted
    towards each axis (..., axis). In units of the standard deviation of the lengths times sqrt(1 -
    1/n); the mean excludes that of the lengths.
    """
    g3, g4, g5, g6, g7, g8 = _cumulants(central)
    # z, w = z^2 - 1, and their products: correlations of two or three visits through the common
    # barycentre.
    z, w, zw, ww = tilted[1], tilted[2], tilted[3] - tilted[1], tilted[4] - 2 * tilted[2]

    def both(*factors: Floats) -> Floats:
        return np.asarray(np.prod(np.broadcast_arrays(*factors), axis=0).sum(axis=-1))

    zz = both(z, z)
    # Joint cumulants of mean(z) and t = s^2 / E s^2, by orders of 1/n: of t, t; mean, t; t, t, t;
    # mean, t, t; four t; mean, t, t, t.
    v1, v2 = g4 + 2, 2 + both(w, w) / 2
    v3 = v2 + 2 * both(z, z, w) - 2 * both(zw, z) + 2 * zz + zz * v1
    k1, k2 = g3, both(z, w) / 2
    k3 = both(z, z, z) - k2 + zz * g3 / 2
    t2 = g6 + 12 * g4 + 4 * g3**2 + 8
    t3 = 12 * g4 + 16 + 1.5 * both(ww, w) - both(w, w, w) - 6 * g3 * both(z, w)
    m2 = g5 + 4 * g3
    m3 = 4 * g3 + both(ww, z) / 2 + both(zw, w) - both(z, w, w) - 2 * both(z, w) - 2 * g3 * zz
    t4 = g8 + 24 * g6 + 32 * g5 * g3 + 32 * g4**2 + 144 * g4 + 96 * g3**2 + 48
    m4 = g7 + 12 * (g5 + g4 * g3) + 8 * g3 * g4 + 24 * g3
    # E sqrt(t) - 1, by sqrt(1 + x) = 1 + x/2 - x^2/8 + x^3/16 - 5 x^4/128 + 7 x^5/256 - 21
    # x^6/1024.
    e1 = -v1 / 8
    e2 = -v2 / 8 + t2 / 16 - 15 * v1**2 / 128
    e3 = -v3 / 8 + t3 / 16 - 5 * (t4 + 6 * v1 * v2) / 128 + 70 * t2 * v1 / 256 - 315 * v1**3 / 1024
    # E mean(z) sqrt(t).
    c1 = k1 / 2
    c2 = k2 / 2 - m2 / 8 + 3 * k1 * v1 / 16
    c3 = (
        k3 / 2
        - m3 / 8
        + (m4 + 3 * (k1 * v2 + k2 * v1)) / 16
        - 5 * (6 * m2 * v1 + 4 * k1 * t2) / 128
        + 105 * k1 * v1**2 / 256
    )
    # sqrt(E s^2) = 1 - zz / 4n^2 - zz / 2n^3.
    mean = [3 * np.ones_like(zz), 3 * e1, 3 * (e2 - zz / 4), 3 * (e3 - zz / 2 - zz * e1 / 4)]
    square = [
        np.zeros_like(zz),
        1 + 6 * c1 - 18 * e1,
        zz / 2 + 6 * c2 - 18 * e2 - 9 * e1**2,
        zz / 2 + 6 * (c3 - zz * c1 / 4) - 18 * (e3 + e1 * e2) + 9 * zz * e1,
    ]
    return np.stack(mean), np.stack(square)


def _cumulants(central: list[Floats]) -> list[Floats]:
    """Return the cumulants from the third on, of central moments."""
    found: list[Floats] = [np.zeros_like(central[0])]
    for r in range(1, len(central)):
        known = (comb(r - 1, j - 1) * found[j] * central[r - j] for j in range(1, r))
        found.append(central[r] - sum(known, start=np.zeros_like(central[0])))
    return found[3:]
