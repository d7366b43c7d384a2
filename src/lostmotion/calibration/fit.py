"""The errors of one robot from measurements: most probable values, and what remains uncertain.

Residuals are exact compositions; columns are those of the nominal arm. Each unknown has a normal
prior with the variance that the arm's file states. An error far out of its tolerance is released:
its prior is widened where the evidence rises by more than `choices.LEAST_GAIN`. In its place the
robot's errors may have Student-t priors.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.calibration import evidence
from lostmotion.calibration.choices import EvidenceChoices

if TYPE_CHECKING:
    from lostmotion.calibration.choices import Asked, Release
    from lostmotion.calibration.evidence import Posterior
    from lostmotion.calibration.instruments import Instrument
    from lostmotion.calibration.model import RobotModel
    from lostmotion.spatial import Floats

_STEPS: Final = 8
_FEWEST_STEPS: Final = 4
# Steps after which what is chosen by evidence is settled.
_CHOICES: Final = 3
# Change of the estimates, in prior deviations, at which the iteration ends.
_SETTLED: Final = 1e-8
# Distance of a measurement from its prediction, in deviations, from which it is weighted down.
_FAR: Final = 4.5


@dataclass(frozen=True, eq=False)
class Estimates:
    """The estimates of one robot.

    mean, covariance  of the draws and of the instrument's unknowns, in deviations of the terms
    variances         prior variances that were used
    prior             prior variances before any was widened
    noise             standard deviation of a coordinate, m, beside what repeats show
    weights           (pose,) 1, or less where a measurement is far off
    evidence          log evidence, nats
    released          errors out of tolerance
    orders            highest order of the periodic errors
    surprise, rows    chi-square of the measurement under the prior, before any release, and its
                      degrees of freedom
    """

    mean: Floats
    covariance: Floats
    variances: Floats
    prior: Floats
    noise: float
    weights: Floats
    evidence: float
    released: tuple[Release, ...]
    orders: int
    surprise: float
    rows: int

    @property
    def resolved(self) -> Floats:
        """Return the share of the prior variance that the measurement removed (unknown,)."""
        return evidence.resolved(self._posterior, self.variances)

    @property
    def _posterior(self) -> Posterior:
        return evidence.Posterior(self.mean, self.covariance, self.evidence)


def linearised(
    model: RobotModel, instrument: Instrument, mean: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return residuals (pose, row), columns (pose, row, unknown) and the covariance of the scatter
    (pose, row, row), with what repeats show of it, at estimates of the draws and of the
    instrument's unknowns.
    """
    draws, unknowns = np.split(mean, [len(model.streams)])
    rows = instrument.rows(model.frames(draws), unknowns)
    by = rows.by_twist
    columns = np.concatenate([by @ model.columns, rows.by_unknown], axis=2)
    covariance = by @ model.scatter @ by.transpose(0, 2, 1)
    covariance = covariance + model.reading[:, None, None] * np.diag(instrument.noise**2)
    return rows.residual, columns, covariance


def whitened(residual: Floats, covariance: Floats) -> Floats:
    """Return residuals (pose, row) in deviations of these covariances (pose, row, row)."""
    lower = np.linalg.cholesky(covariance)
    return np.asarray(np.linalg.solve(lower, residual[:, :, None])[:, :, 0])


def fit(model: RobotModel, instrument: Instrument, asked: Asked) -> Estimates:
    """Return the estimates from a measurement at the poses of the model, by Gauss-Newton."""
    return _Search(model, instrument, asked).run()


class _Search:
    """State of the iteration: estimates, weights, and what is chosen by evidence."""

    def __init__(self, model: RobotModel, instrument: Instrument, asked: Asked) -> None:
        self.model, self.instrument, self.asked = model, instrument, asked
        self.mean = np.zeros(len(asked.variances))
        self.weights = np.ones(len(model))
        self.choices = EvidenceChoices(model, asked)

    def run(self) -> Estimates:
        surprise, choices = math.nan, self.choices
        linear = linearised(self.model, self.instrument, self.mean)
        for step in range(_STEPS):
            residual, columns, covariance = linear
            values = residual + columns @ self.mean
            self.rows = _Whitened(values, columns, covariance, self.instrument.noise)
            chosen = step == 0  # first the estimates and the noise alone, from the nominal arm
            if chosen:
                choices.tune_noise(self._normal)
            elif step <= _CHOICES:
                chosen = choices.choose(self._normal)
            if math.isnan(surprise) and step:
                surprise = evidence.surprise(self._normal(choices.noise), choices.unreleased())
            if self.asked.student:
                choices.reweigh(self._normal(choices.noise))
            found = evidence.posterior(self._normal(choices.noise), choices.variances)
            change = np.abs(found.mean - self.mean).max(initial=0.0)
            self.mean = found.mean
            linear = linearised(self.model, self.instrument, self.mean)
            reweighted = self._weigh(linear[0], linear[2])
            if step + 1 >= _FEWEST_STEPS and not chosen and not reweighted and change < _SETTLED:
                break
        data = self._normal(choices.noise)
        found = evidence.posterior(data, choices.variances)
        return Estimates(
            found.mean,
            found.covariance,
            choices.variances,
            choices.unreleased(),
            choices.noise,
            self.weights,
            found.evidence,
            choices.widened(data),
            choices.orders,
            surprise,
            residual.size,
        )

    def _normal(self, noise: float) -> evidence.NormalEquations:
        return self.rows.normal(noise, self.weights)

    def _weigh(self, residual: Floats, covariance: Floats) -> bool:
        """Weight down whole measurements that are far from their predictions; return whether a
        weight changed.
        """
        if not self.asked.robust:
            return False
        noise = self.choices.noise**2 * np.diag(self.instrument.noise**2)
        distance = np.linalg.norm(whitened(residual, covariance + noise), axis=1)
        expected = math.sqrt(residual.shape[1])
        scale = max(1.0, float(np.median(distance)) / expected)
        limit = (_FAR - math.sqrt(3) + expected) * scale
        weights = np.minimum(1.0, (limit / np.maximum(distance, 1e-300)) ** 4)
        changed = bool((np.abs(weights - self.weights) > 1e-3).any())  # noqa: PLR2004
        self.weights = weights
        return changed


class _Whitened:
    """Rows with a covariance that depends on the noise."""

    def __init__(self, values: Floats, columns: Floats, covariance: Floats, noise: Floats) -> None:
        self.values, self.columns, self.covariance, self.unit = values, columns, covariance, noise
        self.scatters = bool(covariance.any())
        self.plain: evidence.NormalEquations | None = None
        self.weights: Floats | None = None

    def normal(self, noise: float, weights: Floats) -> evidence.NormalEquations:
        """Return the normal equations for a noise (m) and weights (pose,)."""
        if self.scatters:
            return self._computed(noise, weights)
        # Without scatter the noise is a factor.
        if self.plain is None or self.weights is not weights:
            self.plain, self.weights = self._computed(1.0, weights), weights
        information, projected, square, log_scale, rows = self.plain
        return evidence.NormalEquations(
            information / noise**2,
            projected / noise**2,
            square / noise**2,
            log_scale + 2 * rows * math.log(noise),
            rows,
        )

    def _computed(self, noise: float, weights: Floats) -> evidence.NormalEquations:
        lower = np.linalg.cholesky(self.covariance + noise**2 * np.diag(self.unit**2))
        root = np.sqrt(weights)[:, None, None]
        inverse = np.linalg.inv(lower) * root
        count = self.values.size
        columns = (inverse @ self.columns).reshape(count, -1)
        values = (inverse @ self.values[:, :, None]).ravel()
        logs = 2 * np.log(np.diagonal(lower, axis1=1, axis2=2)).sum()
        logs -= self.values.shape[1] * np.log(weights).sum()
        return evidence.NormalEquations.of(columns, values, float(logs))
