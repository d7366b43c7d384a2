"""What a fit chooses by evidence: the noise, errors out of tolerance, the size of errors that the
file does not state, and the order of periodic errors.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from lostmotion.calibration import evidence
from lostmotion.calibration.terms import is_compliance, is_frame, is_harmonic, is_seat

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.calibration.model import RobotModel
    from lostmotion.spatial import Floats

# Rise of the log evidence, nats, by which an error is released; about one false release in 200
# robots that follow their files.
LEAST_GAIN: Final = 5.0
_RELEASES: Final = (4.0, 16.0, 64.0)
_MOST_RELEASES: Final = 6
# Degrees of freedom of a Student-t prior, and its reweightings until the change of each variance.
STUDENT: Final = 2.0
_REWEIGHTINGS: Final = 200
_REWEIGHTED: Final = 1e-9
# Scales of stated errors that are close to one, so that nothing is chosen.
_USUAL: Final = (0.5, 2.0)
# Range of the noise that is searched, m.
_NOISE: Final = (1e-6, 5e-2)
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
    student    whether the robot's errors have Student-t priors in place of releases
    robust     whether measurements that are far off are weighted down
    scale      size of the errors that the arm's file states over usual ones: those that it does not
               state may be as much smaller or larger, by evidence
    """

    variances: Floats
    noise: float | None = None
    harmonics: bool = False
    release: bool = True
    student: bool = False
    robust: bool = True
    scale: float = 1.0


class EvidenceChoices:
    """Noise and prior variances of a fit."""

    def __init__(self, model: RobotModel, asked: Asked) -> None:
        """Start from the prior variances and the noise that are asked for."""
        self.asked = asked
        self.draws = len(model.streams)
        self.variances = asked.variances.copy()
        self.noise = 1e-4 if asked.noise is None else asked.noise
        self.released: list[Release] = []
        self.gains: dict[tuple[int, float], float] = {}
        # the best noise and its evidence by the prior variances, for the rows of one step
        self._noises: dict[bytes, tuple[float, float]] = {}
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

    def choose(self, normal: Callable[[float], evidence.NormalEquations]) -> bool:
        """Choose noise, releases and periodic errors by the evidence of rows, whose normal
        equations depend on the noise, m; return whether any changed.
        """
        changed = self.tune_noise(normal)
        changed |= self._tune_seats()
        if self.asked.harmonics:
            changed |= self._tune_harmonics()
        return changed

    def unreleased(self) -> Floats:
        """Return the prior variances (unknown,) before any was widened."""
        out = self.variances.copy()
        for each in self.released:
            out[each.draw] = self.asked.variances[each.draw]
        if self.asked.student:
            out[: self.draws][self.robot] = self._stated()[: self.draws][self.robot]
        return out

    def _stated(self) -> Floats:
        """Return the prior variances (unknown,) at the chosen size of what the file does not
        state.
        """
        out = self.asked.variances.copy()
        out[: self.draws][self.seat] *= self.scale**2
        return out

    def reweigh(self, data: evidence.NormalEquations) -> None:
        """Replace the variances of the robot's errors by those of normal priors with the same most
        probable values as Student-t priors, by expectation-maximisation.

        With n degrees of freedom and a scale s, an error x has the variance (n s^2 + x^2)/(n + 1).
        Source: K. Lange, R. Little, J. Taylor, J. Am. Stat. Assoc. 84 (1989) 881.
        """
        at = np.flatnonzero(self.robot & (self.variances[: self.draws] > 0))
        stated = self._stated()[at]
        for _ in range(_REWEIGHTINGS):
            mean = evidence.posterior(data, self.variances).mean[at]
            wider = (STUDENT * stated + mean**2) / (STUDENT + 1)
            change = np.abs(wider / self.variances[at] - 1).max(initial=0.0)
            self.variances = self.variances.copy()
            self.variances[at] = wider
            if change < _REWEIGHTED:
                break

    def widened(self, data: evidence.NormalEquations) -> tuple[Release, ...]:
        """Return the errors that are out of tolerance: the releases, or those whose Student-t prior
        became as wide as the smallest of these.
        """
        if not self.asked.student:
            return tuple(self.released)
        stated, found = self.unreleased(), []
        ratio = np.sqrt(self.variances / np.where(stated > 0, stated, 1.0))
        here = evidence.log_evidence(data, self.variances)
        for k in map(int, np.flatnonzero(ratio >= _RELEASES[0])):
            narrow = self.variances.copy()
            narrow[k] = stated[k]
            gain = here - evidence.log_evidence(data, narrow)
            found.append(Release(k, float(ratio[k]), gain))
        return tuple(sorted(found, key=lambda each: -each.gain))

    def tune_noise(self, normal: Callable[[float], evidence.NormalEquations]) -> bool:
        """Choose the noise alone; as `choose`."""
        self.normal, self._noises = normal, {}
        if self.asked.noise is not None:
            return False
        before = self.noise
        self.noise, _ = self._best_noise(self.variances)
        return abs(math.log(self.noise / before)) > 0.01  # noqa: PLR2004 - one per cent

    def _best_noise(self, variances: Floats) -> tuple[float, float]:
        """Return the noise of the largest evidence, and that."""
        if self.asked.noise is not None:
            return self.noise, evidence.log_evidence(self.normal(self.noise), variances)
        key = variances.tobytes()  # the same variances return when a release is tried and adopted
        if key not in self._noises:
            self._noises[key] = self._searched_noise(variances)
        return self._noises[key]

    def _searched_noise(self, variances: Floats) -> tuple[float, float]:
        from scipy.optimize import minimize_scalar

        def cost(logarithm: float) -> float:
            return -evidence.log_evidence(self.normal(math.exp(logarithm)), variances)

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
            self.variances = self._stated()
            self.variances[: self.draws][self.order > 0] = harmonics
            if self.asked.student:
                self.reweigh(self.normal(self.noise))
            elif self.asked.release:
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
            found = evidence.posterior(self.normal(self.noise), self.variances)
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
        best = evidence.log_evidence(self.normal(self.noise), self.variances)
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
            found = evidence.log_evidence(self.normal(noise), variances)
            if found > best:
                best, self.variances = found, variances
                self.orders, self.amplitude, self.noise = orders, amplitude, noise
        return best


def _order(model: RobotModel, draw: int) -> int:
    """Return the order of a periodic error that the calibration added; else 0."""
    if not is_harmonic(model.owners[draw]):
        return 0
    return int(model.streams[draw].name.rsplit(" ", 1)[1])
