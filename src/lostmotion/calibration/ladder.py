"""Which families of errors to estimate: from the frames alone to periodic errors of the joints.

Frames and geometry are always estimated, since their prior keeps what the data do not resolve. A
further rung stays where the mean error at held-out poses falls by more than one standard error of
the paired difference, and the log evidence rises.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from lostmotion.calibration.fit import Asked, fit
from lostmotion.calibration.terms import is_frame, is_harmonic
from lostmotion.calibration.validation import blocked_folds, cross_validate, random_folds

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.calibration.fit import Estimates
    from lostmotion.calibration.instruments import Instrument
    from lostmotion.calibration.model import RobotModel
    from lostmotion.calibration.validation import HeldOut
    from lostmotion.spatial import Floats

Terms = Literal["geometry", "waves"]
FRAMES, GEOMETRY, HARMONICS = "base and tool", "geometry", "periodic errors"


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

    model    errors that the last rung kept estimates
    rungs    in the order tried
    before   held-out measurements of the first rung, with random folds
    random   the same of the last rung kept
    """

    model: RobotModel
    rungs: tuple[Rung, ...]
    before: HeldOut
    random: HeldOut

    @property
    def kept(self) -> Rung:
        """Return the last rung that was kept."""
        return [rung for rung in self.rungs if rung.kept][-1]


def climb(
    model: RobotModel,
    instrument: Instrument,
    *,
    terms: Terms = "waves",
    scale: float = 1.0,
    noise: float | None = None,
    seed: int = 1,
    progress: Callable[[str, int, int], None] | None = None,
) -> Climb:
    """Return the fit of the errors that the measurement supports, and what each family bought.

    terms  "geometry": constant errors of the chain alone; "waves": also periodic errors of the
           joints
    scale  size of the errors that the arm's file states over usual ones
    noise  standard deviation of a coordinate, m; None: estimated
    seed   of the random folds
    """
    labels = blocked_folds(model.matrix.state.frames[-1, :, :3, 3])
    own = len(instrument.unknowns)
    frame = np.array([is_frame(owner) for owner in model.owners])
    harmonic = np.array([is_harmonic(owner) for owner in model.owners])
    families = [(FRAMES, frame), (GEOMETRY, ~harmonic)]
    if terms == "waves" and harmonic.any():
        families.append((HARMONICS, np.ones(len(harmonic), dtype=bool)))
    rungs: list[Rung] = []
    tried: list[tuple[RobotModel, Asked]] = []
    for number, (name, members) in enumerate(families):
        if progress is not None:
            progress(f"estimating {name}", number, len(families) + 1)
        part = model.keeping(np.flatnonzero(members))
        asked = Asked(
            np.ones(len(part.streams) + own),
            noise,
            harmonics=name == HARMONICS,
            scale=scale,
            robust=name != FRAMES,  # what the frames alone leave is no measuring error
        )
        found = fit(part, instrument, asked)
        held = cross_validate(part, instrument, asked, labels)
        count = int((found.variances > 0).sum())
        reason = _refusal(rungs[-1], found, held) if name == HARMONICS else ""
        rungs.append(Rung(name, count, found, held, not reason, reason))
        if not reason:
            tried.append((part, asked))
    if progress is not None:
        progress("validating at random poses", len(families), len(families) + 1)
    folds = random_folds(model.matrix.state.q, seed)
    before, after = (
        cross_validate(part, instrument, asked, folds) for part, asked in (tried[0], tried[-1])
    )
    return Climb(tried[-1][0], tuple(rungs), before, after)


def _refusal(before: Rung, found: Estimates, held: HeldOut) -> str:
    """Return why a family is not kept, in a clause; empty where it is."""
    if not found.orders:
        return "the evidence is for none"
    better, error = paired(before.blocked.error, held.error)
    if found.evidence <= before.fit.evidence:
        return "the log evidence does not rise"
    if better <= error:
        return (
            "held-out regions are not predicted better by more than one standard error of the "
            "difference"
        )
    return ""


def paired(before: Floats, after: Floats) -> tuple[float, float]:
    """Return the mean of before - after, and its standard error."""
    difference = before - after
    return float(difference.mean()), float(difference.std(ddof=1) / math.sqrt(len(difference)))
