"""One robot: its estimated errors as a calibration of the arm, and each of them for a table."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from lostmotion.calibration import alignment, validation
from lostmotion.calibration.choices import LEAST_GAIN, Asked
from lostmotion.calibration.drift import drifting
from lostmotion.calibration.fit import fit
from lostmotion.calibration.instruments import Points
from lostmotion.calibration.ladder import climb
from lostmotion.calibration.model import model_of, with_payload
from lostmotion.calibration.partial import instrument_of
from lostmotion.calibration.reduction import in_best_frames, reduced
from lostmotion.calibration.repeats import at_poses, repeats_of
from lostmotion.calibration.sets import in_sets
from lostmotion.calibration.tags import tags_of
from lostmotion.calibration.terms import (
    Deviations,
    added_terms,
    is_added,
    is_compliance,
    is_frame,
    is_harmonic,
    joint_torques,
    stated_scale,
)
from lostmotion.error_model.poses import sample_poses
from lostmotion.mechanism.calibration import Calibration, size_of
from lostmotion.mechanism.state import state_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from lostmotion.calibration.alignment import Alignment
    from lostmotion.calibration.fit import Estimates
    from lostmotion.calibration.instruments import Instrument, MeasuredVisits
    from lostmotion.calibration.ladder import Climb, Prior, Terms
    from lostmotion.calibration.model import RobotModel
    from lostmotion.calibration.repeats import AtPoses, Repeats
    from lostmotion.calibration.validation import HeldOut
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Highest order of periodic errors that is tried.
_ORDERS: Final = 32
# Fewest poses with which they are tried; they pay from about twenty on.
_FEWEST_PERIODIC: Final = 12
# Number of poses over the workspace at which the covariance is compared with its factor.
_POSES: Final = 256
# Least noise beside what repeats show, m: of a stated noise that is no larger than their scatter.
LEAST_NOISE: Final = 1e-9
# Rise of the log evidence per coordinate, nats, by which a sign of differences is decided.
_DECISIVE: Final = 0.01
# Deviation of the wind-up of a joint under the largest torque of the measurement, rad.
_WIND_UP: Final = 1e-3


@dataclass(frozen=True)
class EstimatedError:
    """One error of the robot.

    name       of its draw
    draw       number of that among the estimates, as in `Release`
    unit       "rad", "m", "rad/(N m)" or "m/m"; "1" where the draw has no single size
    prior      standard deviation that was assumed
    value      estimate, and its standard deviation, in the unit
    deviation
    resolved   share of the prior variance that the measurement removed
    effect     r.m.s. motion of the tool by the estimate at the measured poses, m
    tied       name of the error with which it is correlated most, and that correlation
    correlation
    in_file    whether the arm's file states it
    released   factor by which its prior was widened; 1 for most
    frame      whether it is of the base or tool frame, or of the instrument
    """

    name: str
    draw: int
    unit: str
    prior: float
    value: float
    deviation: float
    resolved: float
    effect: float
    tied: str
    correlation: float
    in_file: bool
    released: float
    frame: bool
    periodic: bool


@dataclass(frozen=True, eq=False)
class Robot:
    """What is known of one robot.

    arm          the arm as its file states it
    calibrations estimates of its draws, with inflated covariance
    climb        families of errors, with their errors at held-out poses
    instrument   what was measured, in the base frame
    frames       (pose, 4, 4) nominal frames of the tool
    sizes        prior deviations of what the file does not state
    inflation    factor on the covariance, by held-out measurements
    alignments   frame of the instrument that was removed, by its set-up; None: the base frame
    sign         -1 where measured differences are read as commanded less attained
    favoured     sign that the measurement decides for; 0: either fits about as well
    errors       of the robot, largest effect first
    poses        (pose,) numbers of the measured poses that were used
    repeats      which visits are of one pose
    repeated     what repeats show
    aside        measurements that were kept aside, against predictions; None: all were used
    """

    arm: Arm
    calibrations: Calibrations
    climb: Climb
    instrument: Instrument
    frames: Floats
    sizes: Deviations
    inflation: float
    alignments: Mapping[str, Alignment | None]
    sign: int
    favoured: int
    errors: tuple[EstimatedError, ...]
    poses: NDArray[np.int64]
    repeats: Repeats
    repeated: AtPoses
    aside: HeldOut | None = None

    @property
    def calibration(self) -> Calibration:
        """Return the estimates, compared with the base and tool frame that fit the robot best."""
        return self.calibrations.own

    @property
    def calibrated(self) -> Arm:
        """Return the arm of this robot."""
        return self.arm.calibrated(self.calibration)

    def noise(self, estimates: Estimates) -> float:
        """Return the standard deviation of a coordinate at one visit, m, by a fit."""
        return float(np.hypot(estimates.noise, self.repeated.reading**0.5))


def robot_of(  # noqa: PLR0913 - a calibration is these choices
    arm: Arm,
    measured: MeasuredVisits,
    *,
    sizes: Deviations | None = None,
    terms: Terms = "all",
    prior: Prior = "release",
    noise: float | None = None,
    hold_out: float = 0.0,
    seed: int = 1,
    progress: Callable[[str, int, int], None] | None = None,
) -> Robot:
    """Return the robot that was measured.

    sizes  prior deviations of errors that the file does not state; None: usual ones, or such as it
           states for others, whichever the measurement makes more probable
    hold_out  share of the poses, at random, that no estimate uses: predictions are compared with
           what was measured there
    other arguments as for `climb`

    Raises WrongArmError where base and tool frame leave more than 5 % of the reach, and ValueError
    where neither points nor differences are measured, or several sets of any other readings.
    """
    chosen = sizes or Deviations()
    turn = 0.0 if measured.rotation is None else chosen.base_turn
    soft = _compliance(arm, measured) if terms == "all" else 0.0
    chosen = replace(chosen, tool_turn=turn, compliance=soft)
    seen = measured_in_base(arm, measured, chosen)
    repeats = repeats_of(measured, seen.instrument, seen.frames)
    visits = measured.rows(repeats.first)
    periodic = terms != "geometry" and len(visits) >= _FEWEST_PERIODIC
    chosen = replace(chosen, orders=_ORDERS if periodic else 0)
    single = model_of(
        arm, visits.q, added_terms(arm, chosen), approach=visits.approach, payload=visits.payload
    )
    drift = drifting(seen.instrument, measured.time)
    still = repeats.mean(seen.instrument)
    moving = None if drift is None else repeats.mean(drift)
    apart = validation.kept_aside(visits, hold_out, seed)
    aside, used = np.flatnonzero(apart), np.flatnonzero(~apart)
    repeated = at_poses(single, repeats, still, used, noise)
    every = repeated.model
    if noise is not None:
        noise = max(noise**2 - repeated.reading, LEAST_NOISE**2) ** 0.5
    model, instrument = every.rows(used), still.part(used)
    found = climb(
        model,
        instrument,
        drift=None if moving is None else moving.part(used),
        terms=terms,
        prior=prior,
        scale=stated_scale(arm, chosen) if sizes is None else 1.0,
        noise=noise,
        seed=seed,
        progress=progress,
        sets=None if visits.sets is None else visits.sets[used],
    )
    if measured.readings is not None:
        turns = not (still.noise == 1.0).any()
        alignment.refuse_other_arm(found.before.error, every.matrix.state.frames[-1], turns=turns)
        own = len(found.model.streams) + np.arange(len(still.unknowns))
        alignment.refuse_lost_instrument(found.instrument, found.kept.fit.mean[own])
    inflation = found.kept.blocked.inflation
    tested, source = None, f"{len(used)} measured poses"
    if len(aside):
        there = every.rows(aside).keeping(every.numbers(found.model.streams))
        with_drift = len(found.instrument.unknowns) > len(still.unknowns)
        measure = moving if moving is not None and with_drift else still
        tested = validation.held_out(there, measure.part(aside), found.kept.fit)
    return Robot(
        arm,
        calibrations_of(arm, found.model, found.kept.fit, chosen, inflation, source),
        found,
        found.instrument,
        seen.frames[repeats.first[used]],
        chosen,
        inflation,
        seen.alignments,
        seen.sign,
        seen.favoured,
        estimated_errors(found.model, found.kept.fit, found.instrument),
        used,
        repeats,
        repeated,
        tested,
    )


def _compliance(arm: Arm, measured: MeasuredVisits) -> float:
    """Return the prior deviation of the joints' compliance, rad/(N m); 0 where only one payload
    was measured.
    """
    masses = np.zeros(0) if measured.payload is None else np.unique(measured.payload)
    if len(masses) < 2:  # noqa: PLR2004 - the difference of two
        return 0.0
    torques = joint_torques(with_payload(arm, float(masses[-1])), measured.q)
    largest = float(np.abs(torques).max(initial=0.0))
    return _WIND_UP / largest if largest else 0.0


class MeasuredInBase(NamedTuple):
    """What was measured, in the base frame; fields as of `Robot`."""

    instrument: Instrument
    frames: Floats
    alignments: Mapping[str, Alignment | None]
    sign: int = 1
    favoured: int = 1


def measured_in_base(arm: Arm, measured: MeasuredVisits, sizes: Deviations) -> MeasuredInBase:
    """Return what was measured, in the base frame. Arguments and errors as for `robot_of`."""
    frames = state_of(arm, measured.q).frames[-1]
    if measured.readings is not None:
        if len(measured.by_set) > 1:
            raise ValueError("several sets of readings of one number, or of pixels")
        of = tags_of if measured.readings.kind == "tags" else instrument_of
        return MeasuredInBase(of(measured.readings, frames), frames, {})
    sign, favoured, point = 1, 1, measured.point
    if point is None:
        if measured.difference is None:
            raise ValueError("neither points nor differences are measured")
        better, favoured = _sign(arm, measured, frames, measured.difference)
        sign = 1 if measured.signed else better
        point = frames[:, :3, 3] + sign * measured.difference
    seen, frame_of = alignment.instrument_in_base(frames, point, measured, sizes)
    return MeasuredInBase(seen, frames, frame_of, sign, favoured)


def _sign(
    arm: Arm, measured: MeasuredVisits, frames: Floats, difference: Floats
) -> tuple[int, int]:
    """Return 1 where differences fit better as attained less commanded, -1 as the reverse: by the
    evidence of base and tool frame; and the same, or 0 where that does not decide.

    Small errors of either sign fit equally well: only those of second order differ. So the evidence
    decides where the reverse also leaves about a hundredth more at each coordinate. Its noise is
    estimated: frames alone leave much more than that of the instrument.
    """
    usual = Deviations()
    model = model_of(arm, measured.q, added_terms(arm, usual))
    outer = model.keeping(np.flatnonzero([is_frame(owner) for owner in model.owners]))
    found = {}
    for sign in (1, -1):
        seen = in_sets(Points(frames[:, :3, 3] + sign * difference), measured, usual)
        count = len(outer.streams) + len(seen.unknowns)
        asked = Asked(np.ones(count), release=False, robust=False)
        found[sign] = fit(outer, seen, asked).evidence
    better = max(found, key=lambda sign: found[sign])
    gain = found[better] - found[-better]
    return better, better if gain > max(LEAST_GAIN, _DECISIVE * difference.size) else 0


class Calibrations(NamedTuple):
    """A robot as every question takes it, and where it was measured.

    own          compared with the base and tool frame that fit it best
    as_measured  without them: the most probable tool in the base frame, and no covariance
    """

    own: Calibration
    as_measured: Calibration


def calibrations_of(
    arm: Arm,
    model: RobotModel,
    best: Estimates,
    sizes: Deviations,
    inflation: float = 1.0,
    source: str = "a measurement",
) -> Calibrations:
    """Return the estimates of all draws that a measurement is about, with inflated covariance;
    `source` as in `Calibration`.
    """
    kept = np.flatnonzero(best.variances[: len(model.streams)])
    streams = tuple((model.streams[k].name, model.streams[k].law) for k in kept)
    names = {name for name, _ in streams}
    added = tuple(
        term
        for term in added_terms(arm, sizes)
        if term.term.robot is not None and term.term.robot.name(term.owner) in names
    )
    everywhere = model_of(arm, sample_poses(arm, _POSES, "sobol", 1).q, added)
    columns = everywhere.columns[:, :, everywhere.numbers([model.streams[k] for k in kept])]
    measured = columns if sizes.tool_turn else columns[:, 3:]
    frames = np.array([is_frame(model.owners[k]) for k in kept])
    own = in_best_frames(measured, frames)
    covariance = own @ (inflation * best.covariance[np.ix_(kept, kept)]) @ own.T
    mean = best.mean[kept]
    return Calibrations(
        Calibration(streams, own @ mean, reduced(columns[:, 3:], covariance), added, source),
        Calibration(streams, mean, np.zeros_like(covariance), added, source),
    )


def estimated_errors(
    model: RobotModel, best: Estimates, instrument: Instrument
) -> tuple[EstimatedError, ...]:
    """Return the errors of the robot, the largest effect on the tool first."""
    count = len(model.streams)
    deviation = np.sqrt(np.diag(best.covariance))
    free = np.flatnonzero(best.variances)
    scale = np.where(deviation > 0, deviation, 1.0)
    correlation = best.covariance / np.outer(scale, scale)
    np.fill_diagonal(correlation, 0.0)
    factors = {each.draw: each.factor for each in best.released}
    resolved = best.resolved
    names = [stream.name for stream in model.streams]
    names += [n if n.startswith("drift") else f"instrument.{n}" for n in instrument.unknowns]
    out = []
    for k in map(int, free):
        tied = int(np.argmax(np.abs(correlation[k])))
        size, unit = instrument.size(k - count) if k >= count else _size(model, k)
        effect = np.sqrt((model.columns[:, 3:, k] ** 2).sum(axis=1).mean()) if k < count else 0.0
        owner = model.owners[k] if k < count else ""
        out.append(
            EstimatedError(
                names[k],
                k,
                unit,
                size * float(np.sqrt(best.prior[k])),
                size * float(best.mean[k]),
                size * float(deviation[k]),
                float(resolved[k]),
                float(effect * abs(best.mean[k])),
                names[tied],
                float(correlation[k, tied]),
                k < count and not is_added(owner),
                factors.get(k, 1.0),
                k >= count or is_frame(owner),
                is_harmonic(owner),
            )
        )
    return tuple(sorted(out, key=lambda each: -each.effect))


def _size(model: RobotModel, draw: int) -> tuple[float, str]:
    """Return the size of an error per unit draw, with its unit; 1 without one where its screw
    depends on the pose or several terms share the draw.
    """
    columns = np.flatnonzero(model.of == draw)
    if is_compliance(model.owners[draw]):
        return float(model.matrix.infos[columns[0]].of.term.scale), "rad/(N m)"
    return size_of([model.matrix.infos[k].of for k in columns])
