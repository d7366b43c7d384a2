"""The errors of one robot from measurements: most probable values, and what remains uncertain.

Residuals are exact compositions; columns are those of the nominal arm. Each unknown has a normal
prior with the variance that the arm's file states. An error far out of its tolerance is released:
its prior is widened where the evidence rises by more than `LEAST_GAIN`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from lostmotion.calibration import evidence
from lostmotion.calibration.terms import is_compliance, is_frame, is_harmonic, is_seat

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.calibration.evidence import Posterior
    from lostmotion.calibration.instruments import Instrument
    from lostmotion.calibration.model import RobotModel
    from lostmotion.spatial import Floats

# Rise of the log evidence, nats, by which an error is released; about one false release in 200
# robots that follow their files.
LEAST_GAIN: Final = 5.0
_RELEASES: Final = (4.0, 16.0, 64.0)
_MOST_RELEASES: Final = 6
# Scales of stated errors that are close to one, so that nothing is chosen.
_USUAL: Final = (0.5, 2.0)
_STEPS: Final = 8
_FEWEST_STEPS: Final = 4
# Steps after which what is chosen by evidence is settled.
_CHOICES: Final = 3
# Change of the estimates, in prior deviations, at which the iteration ends.
_SETTLED: Final = 1e-6
# Range of the noise that is searched, m.
_NOISE: Final = (1e-6, 2e-3)
# Distance of a measurement from its prediction, in deviations, from which it is weighted down.
_FAR: Final = 4.5
# Orders of periodic errors that are compared, and factors on their amplitude.
_ORDERS: Final = (0, 1, 2, 4, 8, 16, 32)
_AMPLITUDES: Final = (0.5, 1.0, 2.0)


class Release(NamedTuple):
    """An error out of its tolerance: index of its draw, factor by which its prior was widened, and
    the rise of the log evidence, nats.
    """

    draw: int
    factor: float
    gain: float


@dataclass(frozen=True)
class Asked:
    """What a fit estimates.

    variances  (unknown,) prior variances of the draws and of the instrument's unknowns, in those of
               the terms; zero: not estimated
    noise      standard deviation of the instrument and of what the model lacks, m; None: by
               evidence
    harmonics      whether order and amplitude of periodic errors are chosen by evidence
    release    whether errors out of tolerance are released
    robust     whether measurements that are far off are weighted down
    scale      size of the errors that the arm's file states over usual ones: those that it does not
               state may be as much smaller or larger, by evidence
    """

    variances: Floats
    noise: float | None = None
    harmonics: bool = False
    release: bool = True
    robust: bool = True
    scale: float = 1.0


@dataclass(frozen=True, eq=False)
class Estimates:
    """The estimates of one robot.

    mean, covariance  of the draws and of the instrument's unknowns, in deviations of the terms
    variances         prior variances that were used
    noise             standard deviation of a coordinate, m
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
    (pose, row, row) at estimates of the draws and of the instrument's unknowns.
    """
    draws, unknowns = np.split(mean, [len(model.streams)])
    rows = instrument.rows(model.frames(draws), unknowns)
    by = rows.by_twist
    columns = np.concatenate([by @ model.columns, rows.by_unknown], axis=2)
    return rows.residual, columns, by @ model.scatter @ by.transpose(0, 2, 1)


def whitened(residual: Floats, covariance: Floats) -> Floats:
    """Return residuals (pose, row) in deviations of these covariances (pose, row, row)."""
    lower = np.linalg.cholesky(covariance)
    return np.asarray(np.linalg.solve(lower, residual[:, :, None])[:, :, 0])


def fit(model: RobotModel, instrument: Instrument, asked: Asked) -> Estimates:
    """Return the estimates from a measurement at the poses of the model, by Gauss-Newton."""
    return _Search(model, instrument, asked).run()


class _Search:
    """State of the iteration: estimates, and the quantities chosen by evidence."""

    def __init__(self, model: RobotModel, instrument: Instrument, asked: Asked) -> None:
        self.model, self.instrument, self.asked = model, instrument, asked
        self.draws = len(model.streams)
        self.mean = np.zeros(len(asked.variances))
        self.variances = asked.variances.copy()
        self.noise = 1e-4 if asked.noise is None else asked.noise
        self.weights = np.ones(len(model))
        self.released: list[Release] = []
        self.gains: dict[tuple[int, float], float] = {}
        self.order = np.array([_order(model, k) for k in range(self.draws)], dtype=int)
        self.orders, self.amplitude, self.scale = 0, 1.0, 1.0
        if asked.harmonics:
            self.variances[: self.draws][self.order > 0] = 0.0
        else:
            self.orders = int(self.order[asked.variances[: self.draws] > 0].max(initial=0))
        # what has no tolerance that it could exceed
        fixed = [is_frame(owner) or is_compliance(owner) for owner in model.owners]
        self.seat = np.array([is_seat(owner) for owner in model.owners], dtype=bool)
        self.robot = np.array(
            [not f and not o for f, o in zip(fixed, self.order, strict=True)], dtype=bool
        )

    def run(self) -> Estimates:
        surprise = math.nan
        linear = linearised(self.model, self.instrument, self.mean)
        for step in range(_STEPS):
            residual, columns, covariance = linear
            values = residual + columns @ self.mean
            self.rows = _Whitened(values, columns, covariance, self.instrument.noise)
            chosen = self._choose(step)
            if math.isnan(surprise) and step:
                surprise = evidence.surprise(self._normal(), self._unreleased())
            found = evidence.posterior(self._normal(), self.variances)
            change = np.abs(found.mean - self.mean).max(initial=0.0)
            self.mean = found.mean
            linear = linearised(self.model, self.instrument, self.mean)
            reweighted = self._weigh(linear[0], linear[2])
            if step + 1 >= _FEWEST_STEPS and not chosen and not reweighted and change < _SETTLED:
                break
        found = evidence.posterior(self._normal(), self.variances)
        return Estimates(
            found.mean,
            found.covariance,
            self.variances,
            self.noise,
            self.weights,
            found.evidence,
            tuple(self.released),
            self.orders,
            surprise,
            residual.size,
        )

    def _normal(self, noise: float | None = None) -> evidence.NormalEquations:
        return self.rows.normal(self.noise if noise is None else noise, self.weights)

    def _choose(self, step: int) -> bool:
        """Choose noise, releases and periodic errors by evidence; return whether any changed."""
        if not 0 < step <= _CHOICES:  # first the estimates alone, from the nominal arm
            return step == 0
        changed = self._tune_noise()
        changed |= self._tune_seats()
        if self.asked.harmonics:
            changed |= self._tune_harmonics()
        return changed

    def _unreleased(self) -> Floats:
        out = self.variances.copy()
        for each in self.released:
            out[each.draw] = self.asked.variances[each.draw]
        return out

    def _tune_noise(self) -> bool:
        if self.asked.noise is not None:
            return False
        before = self.noise
        self.noise, _ = self._best_noise(self.variances)
        return abs(math.log(self.noise / before)) > 0.01  # noqa: PLR2004 - one per cent

    def _best_noise(self, variances: Floats) -> tuple[float, float]:
        """Return the noise of the largest evidence, and that."""
        if self.asked.noise is not None:
            return self.noise, evidence.log_evidence(self._normal(), variances)
        from scipy.optimize import minimize_scalar

        def cost(logarithm: float) -> float:
            return -evidence.log_evidence(self._normal(math.exp(logarithm)), variances)

        low, high = (math.log(each) for each in _NOISE)
        found = minimize_scalar(cost, bounds=(low, high), method="bounded", options={"xatol": 3e-3})
        return math.exp(found.x), -float(found.fun)

    def _tune_seats(self) -> bool:
        """Choose the size of the errors that the file does not state by evidence, each size with
        the releases that it leads to; return whether anything changed.
        """
        before = self.scale, tuple(self.released)
        harmonics = self.variances[: self.draws][self.order > 0]
        best, chosen = -math.inf, None
        usual = _USUAL[0] <= self.asked.scale <= _USUAL[1]
        for scale in (1.0,) if usual or not self.seat.any() else (1.0, self.asked.scale):
            self.scale, self.released = scale, []
            self.variances = self.asked.variances.copy()
            self.variances[: self.draws][self.order > 0] = harmonics
            self.variances[: self.draws][self.seat] *= scale**2
            if self.asked.release:
                self._release()
            self.noise, found = self._best_noise(self.variances)
            if found > best:
                best = found
                chosen = scale, self.released, self.variances, self.noise
        if chosen is not None:
            self.scale, self.released, self.variances, self.noise = chosen
        return before != (self.scale, tuple(self.released))

    def _release(self) -> None:
        """Widen the prior of errors out of tolerance, one at a time."""
        while len(self.released) < _MOST_RELEASES:
            _, now = self._best_noise(self.variances)
            found = evidence.posterior(self._normal(), self.variances)
            taken = {each.draw for each in self.released}
            options = sorted(
                (
                    (float(gains[k]), k, factor)
                    for factor in _RELEASES
                    for gains in [
                        evidence.release_gains(found, self.variances, self._widening(factor))
                    ]
                    for k in map(
                        int, np.flatnonzero(self.robot & (self.variances[: self.draws] > 0))
                    )
                    if k not in taken
                ),
                reverse=True,
            )[:3]
            tried = []
            for _, k, factor in options:
                wider = self.variances.copy()
                wider[k] = self.asked.variances[k] * factor**2
                noise, after = self._best_noise(wider)
                tried.append((after - now, k, factor, noise, wider))
            if not tried or max(tried, key=lambda each: each[0])[0] < LEAST_GAIN:
                break
            gain, k, factor, self.noise, self.variances = max(tried, key=lambda each: each[0])
            # That of the first step counts: later ones are at the estimates with this release.
            gain = self.gains.setdefault((k, factor), gain)
            self.released.append(Release(k, factor, gain))

    def _widening(self, factor: float) -> Floats:
        """Return the factors (unknown,) from the prior deviations in use to those of a release."""
        used = np.where(self.variances > 0, self.variances, 1.0)
        return np.asarray(factor * np.sqrt(self.asked.variances / used))

    def _tune_harmonics(self) -> bool:
        """Choose the highest order, the amplitude and the noise by evidence, one after another and
        twice; return whether order or amplitude changed.
        """
        before = self.orders, self.amplitude
        shares = (1.0,) if self.asked.noise is not None else (0.5, 0.7, 1.0, 1.3)
        best = evidence.log_evidence(self._normal(), self.variances)
        for _ in range(2):
            of_orders = [(orders, self.amplitude, self.noise) for orders in _ORDERS]
            start = best
            best = self._best_harmonics(of_orders, best)
            of_sizes = [
                (self.orders, self.amplitude * size, self.noise * share)
                for share in shares
                for size in _AMPLITUDES
            ]
            best = self._best_harmonics(of_sizes if self.orders else [], best)
            if best <= start:
                break
        return before != (self.orders, self.amplitude)

    def _best_harmonics(self, options: Sequence[tuple[int, float, float]], best: float) -> float:
        """Adopt the order, amplitude and noise (m) of the largest log evidence above `best`, and
        return that.
        """
        for orders, amplitude, noise in options:
            variances = self.variances.copy()
            kept = (self.order > 0) & (self.order <= orders)
            variances[: self.draws][self.order > 0] = 0.0
            variances[: self.draws][kept] = self.asked.variances[: self.draws][kept] * amplitude**2
            found = evidence.log_evidence(self._normal(noise), variances)
            if found > best:
                best, self.variances = found, variances
                self.orders, self.amplitude, self.noise = orders, amplitude, noise
        return best

    def _weigh(self, residual: Floats, covariance: Floats) -> bool:
        """Weight down whole measurements that are far from their predictions; return whether a
        weight changed.
        """
        if not self.asked.robust:
            return False
        noise = self.noise**2 * np.diag(self.instrument.noise**2)
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


def _order(model: RobotModel, draw: int) -> int:
    """Return the order of a periodic error that the calibration added; else 0."""
    if not is_harmonic(model.owners[draw]):
        return 0
    return int(model.streams[draw].name.rsplit(" ", 1)[1])
