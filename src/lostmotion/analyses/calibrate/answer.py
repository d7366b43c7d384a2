"""What the measurement of one robot shows, poses to measure next, and a maker's calibration."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.calibration.alignment import alignments_in_words, plausible_rows
from lostmotion.calibration.chain import ChainErrors
from lostmotion.calibration.choices import Asked
from lostmotion.calibration.correction import corrected
from lostmotion.calibration.fit import fit
from lostmotion.calibration.ladder import counted
from lostmotion.calibration.model import model_of
from lostmotion.calibration.plan import plan
from lostmotion.calibration.repeats import at_poses, repeats_of
from lostmotion.calibration.robot import LEAST_NOISE, measured_in_base, robot_of
from lostmotion.calibration.spread import variance_elsewhere
from lostmotion.calibration.terms import Deviations, added_terms, is_frame
from lostmotion.controller_model.percentile import percentile95
from lostmotion.error_model.pose_selection import poses_in_zone
from lostmotion.error_model.poses import sample_poses
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.sheet import Cell, length, several

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from lostmotion.calibration.ladder import Prior, Terms
    from lostmotion.calibration.model import RobotModel
    from lostmotion.calibration.plan import PosePlan
    from lostmotion.calibration.repeats import RepeatScatter
    from lostmotion.calibration.robot import EstimatedError, Robot
    from lostmotion.io.measured.calibration_visits import CalibrationVisits
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Variance beside the measured poses, over that at them, from which they are too close to a plane.
_SLAB: Final = 4.0
_FEW: Final = 8
_COVERED: Final = (0.92, 0.98)
# Fewest measurements of which a share is compared with 95 %.
FEWEST_COUNTED: Final = 40
# Probability below which the measurements conflict with the stated tolerances.
_CONFLICT: Final = 1e-3
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
    visits     the first visit to each pose
    raw        (pose,) distance of each measured tool point from the nominal one, m
    before     (pose,) the same with base and tool frame estimated from other poses
    fitted     (pose,) residual of the fitted poses
    elsewhere  variance beside the measured poses over that at them
    taken      number of all visits to these poses
    findings   what is out of tolerance
    warnings   what makes the figures doubtful
    """

    robot: Robot
    visits: CalibrationVisits
    raw: Floats
    before: Floats
    fitted: Floats
    elsewhere: float
    taken: int
    findings: tuple[str, ...]
    warnings: tuple[str, ...]
    seed: int

    @property
    def repeats(self) -> RepeatScatter | None:
        """Return the scatter of the lengths that were measured repeatedly at one pose; None: of
        none.
        """
        return self.robot.repeated.scatter

    @property
    def counts(self) -> str:
        """Return the number of poses, and of visits where there are more, in words."""
        poses = several(len(self.visits), "pose")
        return f"{self.taken} visits of {poses}" if self.taken > len(self.visits) else poses

    @property
    def errors_held_out(self) -> tuple[Floats, Floats, Floats]:
        """Return the errors that figures of accuracy count, m: with base and tool frame alone, of
        random folds, and of excluded regions.
        """
        climb = self.robot.climb
        errors = (self.before, climb.random.error, climb.kept.blocked.error)
        return tuple(each[self.counted] for each in errors)  # type: ignore[return-value]

    @property
    def counted(self) -> NDArray[np.bool_]:
        """Return the measurements (pose,) that figures of accuracy count: those that are not
        weighted down.
        """
        return counted(self.robot.climb.kept.fit.weights)

    @functools.cached_property
    def corrections(self) -> tuple[Floats, Floats]:
        """Return the commands (pose, joint), rad and m, by which this robot reaches the nominal
        poses of the measurements, and the distances (pose,), m, that remain.
        """
        measured = self.robot.arm.calibrated(self.robot.calibrations.as_measured)
        return corrected(measured, self.visits.q)

    @property
    def remaining(self) -> tuple[str, ...]:
        """Return a note on measured poses that the corrected commands miss by more than the robot
        is accurate; none where they reach all.
        """
        left, accurate = self.corrections[1], float(self.errors_held_out[1].mean())
        missed = int((left > accurate).sum())
        if not missed:
            return ()
        most = int(left.argmax())
        text = (
            f"the corrected commands in joints.csv miss {missed} of {several(len(left), 'pose')} "
            f"by more than {length(accurate)}, that of line {self.visits.lines[most]} by "
            f"{length(float(left[most]))}: near a singular pose no joint moves the tool that way"
        )
        return (text,)


def calibrated(  # noqa: PLR0913 - as `robot_of`
    arm: Arm,
    visits: CalibrationVisits,
    *,
    terms: Terms,
    prior: Prior,
    noise: float | None,
    hold_out: float,
    seed: int,
    progress: Callable[[str, int, int], None] | None = None,
) -> CalibrationAnswer:
    """Return what the visits show of the robot; arguments as for `robot_of`, whose WrongArmError is
    raised.
    """
    bare = arm.calibrated(None)
    visits, wrong = _plausible(bare, visits)
    robot = robot_of(
        bare,
        visits,
        terms=terms,
        prior=prior,
        sizes=visits.sizes,
        noise=noise if noise is not None else visits.noise,
        hold_out=hold_out,
        seed=seed,
        progress=progress,
    )
    first = robot.repeats.first[robot.poses]
    far = [visits.lines[k] for k in np.flatnonzero(~robot.repeats.used)]
    taken = int(np.isin(robot.repeats.pose, robot.poses).sum())
    visits = visits.rows(first)
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
        taken,
        _findings(robot),
        (*wrong, *_warnings(robot, visits, far, elsewhere)),
        seed,
    )


def _plausible(arm: Arm, visits: CalibrationVisits) -> tuple[CalibrationVisits, list[str]]:
    """Return the visits without gross mistakes, and a warning with the lines of these."""
    kept = plausible_rows(arm, visits)
    lines = [line for k, line in enumerate(visits.lines) if k not in kept]
    if not lines:
        return visits, []
    far = f"{several(len(lines), 'row')} far from where this arm can be, not used and not counted "
    return visits.rows(kept), [f"{far}in the accuracy: {_listed(lines)}"]


def _listed(lines: Sequence[int]) -> str:
    more = f" and {len(lines) - _LISTED} more" if len(lines) > _LISTED else ""
    return f"line {', '.join(map(str, lines[:_LISTED]))}{more}"


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


def _warnings(
    robot: Robot, visits: CalibrationVisits, far: list[int], elsewhere: float
) -> list[str]:
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
    if far:
        rows = several(len(far), "row")
        out.append(f"{rows} far from the others of the same pose, not used: {_listed(far)}")
    down = np.flatnonzero(~counted(best.weights))
    if len(down):
        names = _listed([visits.lines[k] for k in down])
        out.append(
            f"{several(len(down), 'row')} far from the prediction, weighted down and not counted "
            f"in the accuracy: {names}"
        )
    out += _of_sign(robot, visits)
    out += alignments_in_words(robot.alignments, visits)
    out += [
        f"{rung.name} not estimated: {rung.reason}" for rung in robot.climb.rungs if not rung.kept
    ]
    if len(visits) < _FEW:
        out.append(
            f"{len(visits)} poses: an error out of tolerance is found reliably from {_FEW} on"
        )
    if len(visits) >= FEWEST_COUNTED and not _COVERED[0] <= held.coverage <= _COVERED[1]:
        out.append(
            f"{100 * held.coverage:.0f} % of the held-out measurements are within their 95 % "
            "regions"
        )
    return out


def _of_sign(robot: Robot, visits: CalibrationVisits) -> list[str]:
    """Return how differences are read where their sign is not stated, or where the measurement
    contradicts it.
    """
    if visits.difference is None:
        return []
    if visits.signed:
        contradicted = (
            "the reverse of the stated sign of the differences fits much better: check the line "
            "# sign above the rows"
        )
        return [contradicted] if robot.favoured == -robot.sign else []
    order = "attained less commanded" if robot.sign > 0 else "commanded less attained"
    why = "which fits better"
    if not robot.favoured:
        why = "but the reverse fits about as well: state it above the rows, "
        why += "# sign: attained - commanded"
    return [f"the sign of the differences is not stated: read as {order}, {why}"]


@dataclass(frozen=True, repr=False)
class ImportedErrors(ChainErrors):
    """A maker's calibration as errors of the arm: every attribute of `ChainErrors`."""

    robot: Arm
    file: Path
    digest: str


CANDIDATES: Final = 2000
_WORKING: Final = 256
# Prior variances by which poses are chosen, over those of the estimates: a wide prior is robust.
_WIDE: Final = 4.0


@dataclass(frozen=True, repr=False)
class PlannedPoses:
    """Poses to measure next.

    q         (pose, joint) joint values, rad or m
    plan      predicted radius after each number of poses, and observability
    measured  number of poses that were measured already
    """

    arm: Arm
    q: Floats
    plan: PosePlan
    measured: int
    noise: float
    seed: int


def planned_poses(
    arm: Arm,
    count: int,
    zone: Mapping[str, tuple[float, float]] | None,
    visits: CalibrationVisits | None,
    noise: float,
    seed: int,
) -> PlannedPoses:
    """Return the poses that most reduce the mean predicted variance over the working poses.

    zone    limits of the tool point, by axis; None: the whole workspace
    visits  what was measured already, with the deviations that its file states; None: nothing
    noise   standard deviation of a measured coordinate, m
    """
    bare = arm.calibrated(None)
    sizes = (None if visits is None else visits.sizes) or Deviations()
    added = added_terms(bare, sizes)
    every = sample_poses(bare, CANDIDATES, "sobol", seed).q[:CANDIDATES]
    working = every[:_WORKING]
    if zone is not None:
        working = poses_in_zone(bare, _WORKING, zone, seed).poses.q[:_WORKING]
    candidates, wanted = model_of(bare, every, added), model_of(bare, working, added)
    before = np.diag([1.0 if is_frame(owner) else _WIDE for owner in wanted.owners])
    if visits is not None:
        before = _measured(bare, visits, sizes, noise, wanted)
    found = plan(candidates, wanted, count, before, noise=noise)
    done = 0 if visits is None else len(visits)
    return PlannedPoses(arm, every[found.chosen], found, done, noise, seed)


def _measured(
    arm: Arm, visits: CalibrationVisits, sizes: Deviations, noise: float, wanted: RobotModel
) -> Floats:
    """Return the covariance of the estimates after what was measured, with a wide prior."""
    visits, _ = _plausible(arm, visits)
    seen = measured_in_base(arm, visits, sizes)
    repeats = repeats_of(visits, seen.instrument, seen.frames)
    instrument, q = repeats.mean(seen.instrument), visits.q[repeats.first]
    single = model_of(arm, q, added_terms(arm, sizes))
    repeated = at_poses(single, repeats, instrument, np.arange(len(q)), noise)
    model = repeated.model
    noise = max(noise**2 - repeated.reading, LEAST_NOISE**2) ** 0.5
    wide = np.array([1.0 if is_frame(owner) else _WIDE for owner in model.owners])
    own = len(instrument.unknowns)
    asked = Asked(np.concatenate([wide, np.ones(own)]), noise)
    covariance = fit(model, instrument, asked).covariance
    rows = model.numbers(wanted.streams)
    return np.asarray(covariance[np.ix_(rows, rows)])


def corrected_radius(robot: Robot, q: Floats) -> Floats:
    """Return the 95 % radius of the tool (pose,), m, at q (pose, joint) where the estimates are
    corrected: what remains uncertain of them, and the scatter between visits.
    """
    best, streams = robot.climb.kept.fit, robot.climb.model.streams
    model = model_of(robot.arm, q, robot.calibration.added)
    kept = np.flatnonzero(best.variances[: len(streams)])
    columns = model.columns[:, 3:, model.numbers([streams[k] for k in kept])]
    covariance = robot.inflation * best.covariance[np.ix_(kept, kept)]
    spread = columns @ covariance @ columns.transpose(0, 2, 1) + model.scatter[:, 3:, 3:]
    return percentile95(np.zeros((len(q), 3)), spread)
