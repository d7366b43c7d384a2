"""Behaviour of cycloidal gearboxes of one drawing: play, wind-up by member, and harmonics of the
transmission error.

Computed once per drawing on 256 simulated gearboxes, with draws of their own that no study's seed
changes. Each pose then costs a look-up in these tables.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid import drive
from lostmotion.laws.cycloid.friction import DriveFriction, FrictionCoefficients, friction_torques
from lostmotion.parts.gearbox.cycloidal.frame import GearboxFrame
from lostmotion.parts.gearbox.cycloidal.members import stage_wind_up
from lostmotion.parts.gearbox.cycloidal.names import (
    BOUNDED,
    CONTACTS,
    FIRST,
    FIRST_STAGE,
    FRAME,
    FRAME_SCREWS,
    INPUT,
    PIN_MEMBERS,
    is_without_scatter,
)
from lostmotion.parts.gearbox.cycloidal.samples import (
    GEARBOXES,
    SEED,
    disc_share,
    gearboxes,
    simulated,
)
from lostmotion.parts.gearbox.cycloidal.sources import ErrorHarmonic, HysteresisLoop
from lostmotion.parts.gearbox.cycloidal.states import bounds

if TYPE_CHECKING:
    from lostmotion.parts.gearbox.cycloidal.drawing import CycloidalDrawing
    from lostmotion.parts.gearbox.cycloidal.stage import CycloidalStage
    from lostmotion.spatial import Floats

# Relative change of a compliance that is rounding.
_ROUNDING: Final = 1e-12
# Torque levels of the tables, as shares of the rated torque.
LEVELS: Final = (0.01, 0.03, 0.1, 0.3, 0.6, 1.0, 1.5, 2.5)
_HARMONIC_LEVELS: Final = (0.1, 1.0)
# Fewer gearboxes for the spectrum, which needs many crank angles.
_HARMONIC_GEARBOXES: Final = 48
_MOST_HARMONICS: Final = 4
LOST_MOTION: Final = 0.03  # one of the torque levels
ANGLES: Final = 4


@dataclass(frozen=True, slots=True)
class Behaviour:
    """Computed behaviour of the manufactured samples of a drawing. Angles in rad at the output,
    torques in N m at the output.

    torque (level,) from zero on; wind_up (level,) of each member that is not rigid, beyond the
    play, averaged over gearboxes;
    scatter (level,) standard deviation over gearboxes of the total wind-up; play and lost_motion
    (gearbox,), the latter between + and - 3 % of the rated torque; harmonic_torque (level of the
    harmonics,) with `harmonics`; neglected_share: share of the transmission error's mean square in
    smaller harmonics, by which the retained ones are scaled up; friction with the levels of
    `torque`; load_side (level,) rad, the wind-up of the springs between the load and the friction;
    jammed: share of the gearboxes in which flanks interfere.
    """

    torque: Floats
    wind_up: dict[str, Floats]
    scatter: Floats
    play: Floats
    lost_motion: Floats
    harmonic_torque: Floats
    harmonics: tuple[ErrorHarmonic, ...]
    neglected_share: float
    friction: DriveFriction
    load_side: Floats
    jammed: float

    @property
    def total(self) -> Floats:
        """Return the total wind-up (level,), rad, averaged over gearboxes."""
        return np.asarray(sum(self.wind_up.values()))

    @property
    def loop(self) -> HysteresisLoop:
        """Return the hysteresis of the whole gearbox."""
        return HysteresisLoop(
            self.torque, self.total - self.load_side, self.friction.in_loop, self.friction.pins
        )


def behaviour(gearbox: CycloidalDrawing) -> Behaviour:
    """Return the behaviour of gearboxes of this drawing. Raises DidNotConvergeError where the
    contact law finds no equilibrium.

    What the drawing does not state scales the wind-up of its members; the scatter over gearboxes is
    that with the middle of it.
    """
    middle = _behaviour(gearbox.middle)
    wind_up = _scaled(gearbox, middle.wind_up)
    more = sum(wind_up.values()) - middle.total
    lost_motion = middle.lost_motion + 2 * more[1 + LEVELS.index(LOST_MOTION)]
    return replace(
        middle, wind_up=wind_up, lost_motion=lost_motion, load_side=load_side(gearbox, wind_up)
    )


@functools.lru_cache(maxsize=64)
def _behaviour(gearbox: CycloidalDrawing) -> Behaviour:
    rated = gearbox.rated_torque
    torque = rated * np.array(LEVELS)
    made = gearboxes(gearbox, np.array([-LOST_MOTION * rated, *torque]), ANGLES, GEARBOXES)
    small = LEVELS.index(LOST_MOTION)
    both_ways = made.wind_up[1 + small] - made.wind_up[0]
    drawn = wind_up(gearbox, torque)
    without_scatter = wind_up_without_scatter(drawn)
    members = distribute_wind_up(drawn, made.wind_up[1:].mean(axis=1))
    harmonics, neglected = _harmonics(gearbox)
    start = np.zeros(1)
    return Behaviour(
        torque=np.concatenate([start, torque]),
        wind_up={
            name: np.concatenate([start, angle]) for name, angle in members.items() if angle.any()
        },
        scatter=np.concatenate([start, made.wind_up[1:].std(axis=1)]),
        play=made.play,
        lost_motion=made.play + both_ways + 2 * without_scatter[small],
        harmonic_torque=rated * np.array(_HARMONIC_LEVELS),
        harmonics=harmonics,
        neglected_share=neglected,
        friction=friction(gearbox, torque),
        load_side=np.concatenate([start, load_side(gearbox, members)]),
        jammed=made.jammed,
    )


def wind_up(gearbox: CycloidalDrawing, torque: Floats) -> dict[str, Floats]:
    """Return the nominal wind-up (rad) of each member under torques (torque,) above zero at the
    output, beyond the play.

    Bounded members have names of their own (`BOUNDED`).
    """
    return _scaled(gearbox, _with_middles(gearbox.middle, tuple(torque.tolist())))


def _scaled(gearbox: CycloidalDrawing, wind_up: dict[str, Floats]) -> dict[str, Floats]:
    """Return the wind-up of each member with the values of what the drawing does not state, from
    that with the middle of each.
    """
    out = dict(wind_up)
    for each in gearbox.unknowns:
        more = gearbox.unstated.get(each.name, 1.0) - 1
        if abs(more) > _ROUNDING:
            out |= {
                name: out[name] * (1 + share * more)
                for name, share in each.shares.items()
                if name in out
            }
    return out


@functools.lru_cache(maxsize=64)
def _with_middles(gearbox: CycloidalDrawing, torques: tuple[float, ...]) -> dict[str, Floats]:
    """Return the wind-up with the middle of all that the drawing does not state: of a bounded
    member the geometric mean of its bounds.
    """
    torque = np.array(torques)
    share, steps = disc_share(gearbox), abs(gearbox.steps)
    out = {name: share * angle for name, angle in stage_wind_up(gearbox, share * torque).items()}
    first = gearbox.cycloidal_first_stage
    if first is not None:
        out |= {
            f"{FIRST_STAGE}{name}": angle / steps
            for name, angle in stage_wind_up(first, torque / steps).items()
        }
    out |= _outside(gearbox, torque)
    computed = np.sum(list(out.values()), axis=0)
    of_first = np.sum(
        [angle for name, angle in out.items() if name.startswith(FIRST_STAGE)], axis=0
    )
    for name, (low, high) in bounds(gearbox).items():
        out[f"{name}{BOUNDED}"] = math.sqrt(low * high) * (
            of_first if name.startswith(FIRST_STAGE) else computed
        )
    return out


def distribute_wind_up(as_drawn: dict[str, Floats], simulated: Floats) -> dict[str, Floats]:
    """Return the members' wind-up (torque,), rad, such that the members with scatter add up to
    their mean over simulated gearboxes `simulated` (torque,), rad.

    Unequal flanks make contact one after the other: the wind-up beyond that of nominal flanks is
    attributed to the lobe contacts. Flanks that interfere wind up less: then all members with
    scatter are reduced in proportion.
    """
    own = sum(as_drawn.values()) - wind_up_without_scatter(as_drawn)
    share = np.where(simulated < own, simulated / np.where(own > 0, own, 1.0), 1.0)
    out = {
        name: angle if is_without_scatter(name) else share * angle
        for name, angle in as_drawn.items()
    }
    return out | {CONTACTS: out[CONTACTS] + np.maximum(simulated - own, 0.0)}


def wind_up_without_scatter(members: dict[str, Floats]) -> Floats:
    """Return the part of the members' wind-up (torque,) without scatter, which `gearboxes` does not
    include.
    """
    none = np.zeros_like(members[CONTACTS])
    return np.asarray(
        np.sum(
            [none, *(angle for name, angle in members.items() if is_without_scatter(name))], axis=0
        )
    )


def _outside(gearbox: CycloidalDrawing, torque: Floats) -> dict[str, Floats]:
    """Return the wind-up of the members outside the cycloidal stages."""
    first, frame = gearbox.first_stage, gearbox.frame
    out = {}
    if first is not None and first.kind == "planetary":
        out[FIRST] = torque * first.compliance / gearbox.ratio**2
    if isinstance(frame, GearboxFrame):
        if frame.tube is not None:
            out[FRAME] = torque / frame.tube.stiffness
        if frame.screws is not None:
            out[FRAME_SCREWS] = frame.screws.wind_up(torque)
    elif frame is not None:
        out[FRAME] = torque / frame
    soft = (
        1 / gearbox.input_shaft if gearbox.input_shaft is not None else gearbox.input_twist or 0.0
    )
    out[INPUT] = torque * soft / gearbox.ratio**2
    return {name: angle for name, angle in out.items() if name not in gearbox.rigid}


def _harmonics(gearbox: CycloidalDrawing) -> tuple[tuple[ErrorHarmonic, ...], float]:
    """Return the largest harmonics of the transmission error, scaled to the mean square of all, and
    the share of the smaller ones.
    """
    steps, share = abs(gearbox.steps), disc_share(gearbox)
    loads = gearbox.rated_torque * np.array(_HARMONIC_LEVELS)
    found = {k * steps: share**2 * power for k, power in _spectrum(gearbox, share * loads, SEED)}
    first = gearbox.cycloidal_first_stage
    if first is not None:
        before = abs(gearbox.ratio)
        for k, power in _spectrum(first, loads / steps, SEED + 1):
            # some coincide with harmonics of the last stage
            found[k * before] = found.get(k * before, 0.0) + power / steps**2
    whole = np.sum(list(found.values()), axis=0)
    if not np.any(whole > 0):
        return (), 0.0
    weight = {
        cycles: float((power / np.where(whole > 0, whole, 1.0)).sum())
        for cycles, power in found.items()
    }
    kept = sorted(weight, key=lambda cycles: -weight[cycles])[:_MOST_HARMONICS]
    held = np.sum([found[cycles] for cycles in kept], axis=0)
    scale = np.sqrt(whole / np.where(held > 0, held, 1.0))
    harmonics = tuple(
        ErrorHarmonic(float(cycles), np.sqrt(found[cycles]) * scale) for cycles in sorted(kept)
    )
    return harmonics, float(1 - (held / whole)[-1])


def _spectrum(stage: CycloidalStage, loads: Floats, seed: int) -> list[tuple[int, Floats]]:
    """Return the mean square (level,), rad^2, of each harmonic of the crank's turn, averaged over
    gearboxes.
    """
    angles = 3 * stage.pins
    rotation = simulated(stage, loads, angles, _HARMONIC_GEARBOXES, seed).rotation
    power = 2 * (np.abs(np.fft.rfft(rotation, axis=1) / angles) ** 2).mean(axis=2)
    return [(k, power[:, k]) for k in range(1, power.shape[1])]


def load_side(gearbox: CycloidalDrawing, members: dict[str, Floats]) -> Floats:
    """Return the part of the members' wind-up (torque,), rad, in springs between the load and the
    friction, which carry all of the load.

    These are housing and output shaft, and where the flanks rub the output pins that carry the
    output. Friction without load counts there as well; it acts before the pins, whose part of its
    loop is neglected.
    """
    names = [
        FRAME,
        FRAME_SCREWS,
        *(PIN_MEMBERS if gearbox.friction is not None and gearbox.fixed == "ring" else ()),
    ]
    none = np.zeros_like(members[CONTACTS])
    return np.asarray(
        np.sum(
            [
                none,
                *(angle for name, angle in members.items() if name.removesuffix(BOUNDED) in names),
            ],
            axis=0,
        )
    )


def friction(gearbox: CycloidalDrawing, torque: Floats) -> DriveFriction:
    """Return the friction at the output, with levels at zero and at torques (torque,), rising from
    above zero.

    Of flanks, eccentric and output pins only those of the output stage, which dominate: friction
    before it reaches the output divided by the ratio.
    """
    stated, discs = gearbox.friction, gearbox.discs
    # on the discs, on the crank, of the output pins while it turns, and while it is held
    lost = np.zeros((4, len(torque) + 1))
    if stated is not None:
        circle = gearbox.output_pins.circle_radius if gearbox.output_pins else math.inf
        coefficients = FrictionCoefficients(
            stated.flank, stated.bearing, stated.bearing_radius, stated.output, circle
        )
        crank = drive.crank_angles_of_pitch(gearbox.drive)
        gap = drive.nominal_gaps(gearbox.drive, crank)
        for k, load in enumerate(disc_share(gearbox) * torque / discs, 1):
            answer = drive.loaded_disc(gearbox.drive, float(load), crank, gap)
            found = friction_torques(gearbox.stage, crank, answer, coefficients, abs(gearbox.steps))
            lost[:, k] = [
                discs * float(each.mean())
                for each in (found.disc, found.crank, found.pins, found.pins_held)
            ]
    levels, (on_discs, on_crank, pins, held) = np.concatenate([np.zeros(1), torque]), lost
    # a disc that turns by nothing against its pins slides on them only as the crank turns
    if gearbox.fixed == "carrier":
        held = np.zeros_like(held)
    return DriveFriction(
        levels,
        on_discs,
        on_crank + pins - held,
        float(held[-1] / torque[-1]),
        gearbox.friction_in_loop,
    )
