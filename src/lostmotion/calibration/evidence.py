"""Linear Gaussian estimation: posterior, log evidence, and its gain from a wider prior.

Unknowns x are standardised: x ~ N(0, diag(variances)), and z = B x + e with
independent e ~ N(0, 1).
Sources: A. Tarantola, Inverse Problem Theory, 2005, ch. 3; D. MacKay, Neural Computation 4 (1992)
415; M. Tipping, J. Mach. Learn. Res. 1 (2001) 211.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.linalg import solve_triangular

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.spatial import Floats


class NormalEquations(NamedTuple):
    """Normal equations of whitened rows.

    information  (unknown, unknown) B'B
    projected    (unknown,) B'z
    square       z'z
    log_scale    logarithm of the determinant of the covariance of the rows
    rows         number of rows
    """

    information: Floats
    projected: Floats
    square: float
    log_scale: float
    rows: int

    @classmethod
    def of(cls, columns: Floats, values: Floats, log_scale: float) -> NormalEquations:
        """Return the normal equations of whitened columns B (row, unknown) and values z (row,)."""
        return cls(
            columns.T @ columns,
            columns.T @ values,
            float(values @ values),
            log_scale,
            len(values),
        )


class Posterior(NamedTuple):
    """What is known of the unknowns after a measurement.

    mean        (unknown,)
    covariance  (unknown, unknown)
    evidence    logarithm of the probability density of the measurement
    """

    mean: Floats
    covariance: Floats
    evidence: float


def posterior(data: NormalEquations, variances: Floats) -> Posterior:
    """Return the posterior of unknowns with these prior variances (unknown,); zero: known to be
    zero.
    """
    free, scale, lower, half = _factor(data, variances)
    inverse = solve_triangular(lower, np.diag(scale), lower=True)
    mean, covariance = np.zeros(len(variances)), np.zeros((len(variances), len(variances)))
    mean[free] = inverse.T @ half
    covariance[np.ix_(free, free)] = inverse.T @ inverse
    return Posterior(mean, covariance, _evidence(data, lower, half))


def log_evidence(data: NormalEquations, variances: Floats) -> float:
    """Return the logarithm of the probability density of the rows under this prior."""
    _, _, lower, half = _factor(data, variances)
    return _evidence(data, lower, half)


def _factor(
    data: NormalEquations, variances: Floats
) -> tuple[NDArray[np.int64], Floats, Floats, Floats]:
    """Return the unknowns that are free, their prior deviations, the Cholesky factor of I + S B'B S
    and its inverse times S B'z.
    """
    free: NDArray[np.int64] = np.flatnonzero(variances).astype(np.int64)
    scale: Floats = np.sqrt(variances[free])
    inner = scale[:, None] * data.information[np.ix_(free, free)] * scale
    lower = np.asarray(np.linalg.cholesky(inner + np.eye(len(free))), dtype=float)
    half = np.asarray(solve_triangular(lower, scale * data.projected[free], lower=True))
    return free, scale, lower, half


def _evidence(data: NormalEquations, lower: Floats, half: Floats) -> float:
    misfit = data.square - float(half @ half)
    spread = data.log_scale + 2 * float(np.log(np.diag(lower)).sum())
    return -0.5 * (misfit + spread + data.rows * math.log(2 * math.pi))


def surprise(data: NormalEquations, variances: Floats) -> float:
    """Return z'(B diag(variances) B' + I)^-1 z: chi-square distributed with a degree of freedom per
    row if the prior holds.
    """
    *_, half = _factor(data, variances)
    return data.square - float(half @ half)


def resolved(estimated: Posterior, variances: Floats) -> Floats:
    """Return the share of the prior variance of each unknown that the measurement removed."""
    safe = np.where(variances > 0, variances, 1.0)
    return np.where(variances > 0, 1 - np.diag(estimated.covariance) / safe, 0.0)


def release_gains(estimated: Posterior, variances: Floats, factor: Floats) -> Floats:
    """Return how much the log evidence rises (unknown,) where the prior deviation of one unknown is
    `factor` (unknown,) times as large.

    From the rank-one update of the covariance of the rows: with c = factor^2 - 1, t the resolved
    share and m the estimate in prior deviations, (c m^2 / (1 + c t) - ln(1 + c t)) / 2.
    """
    c = factor**2 - 1
    safe = np.where(variances > 0, variances, 1.0)
    t, square = resolved(estimated, variances), estimated.mean**2 / safe
    return np.asarray(0.5 * (c * square / (1 + c * t) - np.log1p(c * t)))
