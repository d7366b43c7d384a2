"""What the measurement of one robot shows: accuracy before and after, findings, and doubts."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.calibration.robot import robot_of
from lostmotion.calibration.spread import variance_elsewhere
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.sheet import Cell, length, several

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.calibration.ladder import Terms
    from lostmotion.calibration.robot import EstimatedError, Robot
    from lostmotion.io.measured.calibration_visits import CalibrationVisits
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Variance beside the measured poses, over that at them, from which they are too close to a plane.
_SLAB: Final = 4.0
_FEW: Final = 8
_COVERED: Final = (0.92, 0.98)
# Fewest measurements of which a share is compared with 95 %.
_COUNTED: Final = 40
# Probability below which the measurements conflict with the stated tolerances.
_CONFLICT: Final = 1e-3
_WEIGHTED_DOWN: Final = 0.5
_LISTED: Final = 6
# Units in which the sizes of errors are shown.
_UNITS: Final = {"rad": "mrad", "rad/(N m)": "arcmin/(N m)", "m/m": "µm/m", "1": "1"}
# Shares of the prior variance below which an estimate is not, or partly, resolved.
UNRESOLVED: Final = 0.1
PARTLY: Final = 0.75


@dataclass(frozen=True, repr=False)
class CalibrationAnswer:
    """What the measurement of one robot shows.

    robot      estimates, held-out measurements and families of errors
    visits     what was measured
    raw        (pose,) distance of each measured tool point from the nominal one, m
    before     (pose,) the same with base and tool frame estimated from other poses
    fitted     (pose,) residual of the fitted poses
    elsewhere  variance beside the measured poses over that at them
    findings   what is out of tolerance
    warnings   what makes the figures doubtful
    """

    robot: Robot
    visits: CalibrationVisits
    raw: Floats
    before: Floats
    fitted: Floats
    elsewhere: float
    findings: tuple[str, ...]
    warnings: tuple[str, ...]
    seed: int


def calibrated(
    arm: Arm,
    visits: CalibrationVisits,
    terms: Terms,
    noise: float | None,
    hold_out: float,
    seed: int,
    progress: Callable[[str, int, int], None] | None = None,
) -> CalibrationAnswer:
    """Return what the visits show of the robot; arguments as for `robot_of`, whose WrongArmError is
    raised.
    """
    robot = robot_of(
        arm.calibrated(None),
        visits,
        terms=terms,
        sizes=visits.sizes,
        noise=noise if noise is not None else visits.noise,
        hold_out=hold_out,
        seed=seed,
        progress=progress,
    )
    lines = tuple(visits.lines[k] for k in robot.rows)
    visits = replace(visits.rows(robot.rows), lines=lines)
    best, model = robot.climb.kept.fit, robot.climb.model
    draws, unknowns = np.split(best.mean, [len(model.streams)])
    residual = robot.instrument.rows(model.frames(draws), unknowns).residual
    raw = robot.instrument.rows(robot.frames, np.zeros_like(unknowns)).residual
    count = len(model.streams)
    elsewhere = variance_elsewhere(model, best.covariance[:count, :count])
    return CalibrationAnswer(
        robot,
        visits,
        robot.instrument.error(raw),
        robot.climb.before.error,
        robot.instrument.error(residual),
        elsewhere,
        _findings(robot),
        tuple(_warnings(robot, visits, elsewhere)),
        seed,
    )


def size(error: EstimatedError, value: float) -> Cell:
    """Return a size of an error in the unit that people read; a number of standard deviations where
    it has none.
    """
    return length(value) if error.unit == "m" else Cell(value, _UNITS[error.unit])


def _findings(robot: Robot) -> tuple[str, ...]:
    out = []
    for error in robot.errors:
        if error.released > 1:
            text = (
                f"{short_name(error.name)} is {size(error, error.value)} "
                f"± {size(error, 2 * error.deviation)}, "
                f"{abs(error.value) / error.prior:.2g} times its standard deviation"
            )
            out.append(text if error.in_file else f"{text}; it is not in the arm file")
    return tuple(out)


def _warnings(robot: Robot, visits: CalibrationVisits, elsewhere: float) -> list[str]:
    from scipy.stats import chi2

    best, held = robot.climb.kept.fit, robot.climb.kept.blocked
    out = list(visits.remarks)
    if elsewhere > _SLAB:
        out.append(
            "the measured poses lie in a slab: the predicted variance beside it is "
            f"{elsewhere:.2g} times that at them; measure poses at other heights and distances"
        )
    if chi2.sf(best.surprise, best.rows) < _CONFLICT:
        out.append(
            "the measurements conflict with the tolerances: chi-square "
            f"{best.surprise:.0f} of {best.rows} coordinates before any error was released"
        )
    if visits.duplicates:
        out.append(f"{several(visits.duplicates, 'duplicate row')} dropped")
    down = np.flatnonzero(best.weights < _WEIGHTED_DOWN)
    if len(down):
        names = ", ".join(str(visits.lines[k]) for k in down[:_LISTED])
        more = f" and {len(down) - _LISTED} more" if len(down) > _LISTED else ""
        out.append(
            f"{several(len(down), 'row')} far from the prediction, weighted down: line "
            f"{names}{more}"
        )
    if visits.difference is not None:
        order = "attained less commanded" if robot.sign > 0 else "commanded less attained"
        out.append(f"the sign of the differences is not stated: read as {order}, which fits better")
    if robot.alignment is not None:
        out.append(
            "the measurements are in the frame of the instrument, "
            f"{length(robot.alignment.shift)} and {Cell(robot.alignment.turn, '°')} from the base: "
            "brought into the base frame"
        )
    out += [
        f"{rung.name} not estimated: {rung.reason}" for rung in robot.climb.rungs if not rung.kept
    ]
    if len(visits) < _FEW:
        out.append(
            f"{len(visits)} rows: an error out of tolerance is found reliably from {_FEW} on"
        )
    covered = held.coverage(robot.inflation)
    if len(visits) >= _COUNTED and not _COVERED[0] <= covered <= _COVERED[1]:
        out.append(
            f"{100 * covered:.0f} % of the held-out measurements are within their 95 % regions"
        )
    return out
