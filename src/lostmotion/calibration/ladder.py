"""Which families of errors to estimate: from the frames alone to periodic errors of the joints.

Frames and geometry are always estimated, since their prior keeps what the data do not resolve. A
further rung stays where the mean error at held-out poses falls by more than one standard error of
the paired difference, the log evidence rises, and the estimate is possible. The compliance of the
joints is tried where two payloads were measured, drift where the time was recorded.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.calibration.choices import Asked
from lostmotion.calibration.fit import fit
from lostmotion.calibration.terms import is_compliance, is_frame, is_harmonic
from lostmotion.calibration.validation import (
    blocked_folds,
    cross_validate,
    folds_in_sets,
    random_folds,
)
from lostmotion.parts.forms import Spring

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from lostmotion.calibration.fit import Estimates
    from lostmotion.calibration.instruments import Instrument
    from lostmotion.calibration.model import RobotModel
    from lostmotion.calibration.validation import HeldOut
    from lostmotion.spatial import Floats

Terms = Literal["geometry", "waves", "all"]
Prior = Literal["release", "student-t"]
FRAMES, GEOMETRY, HARMONICS = "base and tool", "geometry", "periodic errors"
COMPLIANCE, DRIFT = "compliance of the joints", "drift"
# Weight below which a measurement counts as wrong.
_WEIGHTED_DOWN: Final = 0.5
# Deviations below zero from which a compliance is impossible.
_IMPOSSIBLE: Final = 2.0


@dataclass(frozen=True, eq=False)
class Rung:
    """A family of errors that was tried.

    name       of the family that was added
    count      number of errors that are estimated with it
    fit        estimates from all measurements
    blocked    held-out measurements, regions of the workspace excluded
    kept       whether the family is part of the result
    reason     why it is not; empty where it is
    """

    name: str
    count: int
    fit: Estimates
    blocked: HeldOut
    kept: bool = True
    reason: str = ""


@dataclass(frozen=True, eq=False)
class Climb:
    """What each rung bought.

    model       errors that the last rung kept estimates
    instrument  the measurement, with a drift where one was found
    rungs       in the order tried
    before      held-out measurements of the first rung, with random folds
    random      the same of the last rung kept
    """

    model: RobotModel
    instrument: Instrument
    rungs: tuple[Rung, ...]
    before: HeldOut
    random: HeldOut

    @property
    def kept(self) -> Rung:
        """Return the last rung that was kept."""
        return [rung for rung in self.rungs if rung.kept][-1]


def climb(  # noqa: PLR0913 - a measurement, and what to try
    model: RobotModel,
    instrument: Instrument,
    *,
    drift: Instrument | None = None,
    terms: Terms = "all",
    prior: Prior = "release",
    scale: float = 1.0,
    noise: float | None = None,
    seed: int = 1,
    sets: NDArray[np.str_] | None = None,
    progress: Callable[[str, int, int], None] | None = None,
) -> Climb:
    """Return the fit of the errors that the measurement supports, and what each family bought.

    drift  the instrument with a drift; None: no time was recorded
    terms  "geometry": constant errors of the chain alone; "waves": also periodic errors of the
           joints; "all": also compliance and drift
    prior  "release": normal, and errors out of tolerance are released; "student-t": of the robot's
           errors Student-t
    scale  size of the errors that the arm's file states over usual ones
    noise  standard deviation of a coordinate, m; None: estimated
    seed   of the random folds
    sets   (pose,) name of the set-up of the instrument; None: one
    """
    points, q = model.matrix.state.frames[-1, :, :3, 3], model.matrix.state.q
    labels = folds_in_sets(lambda rows: blocked_folds(points[rows]), len(model), sets)
    frame = np.array([is_frame(owner) for owner in model.owners])
    harmonic = np.array([is_harmonic(owner) for owner in model.owners])
    soft = np.array([is_compliance(owner) for owner in model.owners])
    members, seen = frame, instrument
    families: list[tuple[str, NDArray[np.bool_], Instrument | None]]
    families = [(FRAMES, frame, None), (GEOMETRY, ~harmonic & ~soft, None)]
    if terms == "all":
        families += [(COMPLIANCE, soft, None)] if soft.any() else []
        families += [] if drift is None else [(DRIFT, np.zeros_like(soft), drift)]
    if terms != "geometry" and harmonic.any():
        families.append((HARMONICS, harmonic, None))
    rungs: list[Rung] = []
    tried: list[tuple[RobotModel, Instrument, Asked]] = []
    for number, (name, more, drifting) in enumerate(families):
        if progress is not None:
            progress(f"estimating {name}", number, len(families) + 1)
        here, measured = members | more, drifting or seen
        part = model.keeping(np.flatnonzero(here))
        asked = Asked(
            np.ones(len(part.streams) + len(measured.unknowns)),
            noise,
            harmonics=name == HARMONICS,
            scale=scale,
            student=prior == "student-t",
            robust=name != FRAMES,  # what the frames alone leave is no measuring error
        )
        found = fit(part, measured, asked)
        held = cross_validate(part, measured, asked, labels)
        count = int((found.variances > 0).sum())
        kept = [rung for rung in rungs if rung.kept]
        optional = name not in {FRAMES, GEOMETRY}
        reason = _refusal(name, kept[-1], part, found, held) if optional else ""
        rungs.append(Rung(name, count, found, held, not reason, reason))
        if not reason:
            tried.append((part, measured, asked))
            members, seen = here, measured
    if progress is not None:
        progress("validating at random poses", len(families), len(families) + 1)
    folds = folds_in_sets(lambda rows: random_folds(q[rows], seed), len(model), sets)
    before, after = (cross_validate(*each, folds) for each in (tried[0], tried[-1]))
    return Climb(tried[-1][0], seen, tuple(rungs), before, after)


def _refusal(
    name: str, before: Rung, model: RobotModel, estimates: Estimates, held: HeldOut
) -> str:
    """Return why a family is not kept, in a clause; empty where it is."""
    if name == HARMONICS and not estimates.orders:
        return "the evidence is for none"
    used = counted(estimates.weights)
    better, error = paired(before.blocked.error[used], held.error[used])
    if estimates.evidence <= before.fit.evidence:
        return "the log evidence does not rise"
    if better <= error:
        return (
            "held-out regions are not predicted better by more than one standard error of the "
            "difference"
        )
    return _impossible(model, estimates) if name == COMPLIANCE else ""


def _impossible(model: RobotModel, estimates: Estimates) -> str:
    """Return which joint is estimated to yield against its load, in a clause; empty for none."""
    deviation = np.sqrt(np.diag(estimates.covariance))
    for k, owner in enumerate(model.owners):
        if is_compliance(owner):
            of = next(i.of for i, n in zip(model.matrix.infos, model.of, strict=True) if n == k)
            stated = sum(
                each.of.term.scale * float(each.of.term.form.curve.slope(np.zeros(1))[0])
                for each in model.matrix.infos
                if each.of.place == of.place
                and each.level == "design"
                and isinstance(each.of.term.form, Spring)
                and each.of.term.form.elastic
            )
            least = estimates.mean[k] + _IMPOSSIBLE * deviation[k]
            if stated + of.term.scale * least < 0:
                return f"the estimate for {owner} is below zero, which no joint can have"
    return ""


def counted(weights: Floats) -> NDArray[np.bool_]:
    """Return the measurements (pose,) that are not weighted down; all where nearly none would be
    left.
    """
    out = weights >= _WEIGHTED_DOWN
    return np.asarray(out if out.mean() > _WEIGHTED_DOWN else np.ones_like(out))


def paired(before: Floats, after: Floats) -> tuple[float, float]:
    """Return the mean of before - after, and its standard error."""
    difference = before - after
    return float(difference.mean()), float(difference.std(ddof=1) / math.sqrt(len(difference)))
