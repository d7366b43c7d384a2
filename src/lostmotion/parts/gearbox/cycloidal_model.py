"""Behaviour of cycloidal gearboxes of one drawing: play, wind-up by member, and harmonics of the transmission error.

Computed once per drawing on 256 simulated gearboxes, with draws of their own that no study's seed changes. Each pose then costs a look-up in these
tables.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid import contact, drive
from lostmotion.laws.cycloid.tolerances import sample_dimension, simulate
from lostmotion.parts.gearbox.cycloidal_drawing import FIRST_STAGE
from lostmotion.parts.gearbox.cycloidal_sources import Loop, Wave

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.tolerances import SimulatedGearboxes
    from lostmotion.parts.gearbox.cycloidal_drawing import CycloidalDrawing
    from lostmotion.parts.gearbox.cycloidal_stage import CycloidalStage
    from lostmotion.spatial import Floats

GEARBOXES: Final = 256
SEED: Final = 1
# Of the rated torque.
LEVELS: Final = (0.01, 0.03, 0.1, 0.3, 0.6, 1.0, 1.5, 2.5)
_WAVED: Final = (0.1, 1.0)
# Fewer gearboxes where every crank angle counts.
_WAVING: Final = 48
_MOST_WAVES: Final = 4
# Members that are plain springs and the same in all gearboxes.
_ALIKE: Final = ("output pins", "first stage", "frame", "input shaft")
LOST_MOTION: Final = 0.03  # one of the levels
_ANGLES: Final = 4


@dataclass(frozen=True, slots=True)
class Behaviour:
    """What was worked out. Angles in rad at the output, torques in N m at the output.

    torque (level,) from zero on; wind_up (level,) of each member that is not rigid, play not counted, the contacts' on average over gearboxes;
    scatter (level,) one standard deviation over gearboxes of the whole wind-up; play and lost_motion (gearbox,), the latter between + and - 3 % of
    the rated torque; wave_torque (wave level,) with `waves`; waves_left_out: share of the transmission error's mean square that smaller waves had,
    before it was put on these; friction (level,) N m; jammed: share of the gearboxes in which flanks interfere.
    """

    torque: Floats
    wind_up: dict[str, Floats]
    scatter: Floats
    play: Floats
    lost_motion: Floats
    wave_torque: Floats
    waves: tuple[Wave, ...]
    waves_left_out: float
    friction: Floats
    jammed: float

    @property
    def total(self) -> Floats:
        """Give the whole wind-up (level,), rad, on average over gearboxes."""
        return np.asarray(sum(self.wind_up.values()))

    @property
    def loop(self) -> Loop:
        """Return the loop that friction leaves on the spring of the whole gearbox."""
        return Loop(self.torque, self.total, self.friction)


@functools.lru_cache(maxsize=64)
def behaviour(gearbox: CycloidalDrawing) -> Behaviour:
    """What do gearboxes of this drawing do? Raises DidNotConvergeError where the contact law does not hold the loads."""
    rated = gearbox.rated_torque
    torque = rated * np.array(LEVELS)
    made = gearboxes(gearbox, np.array([-LOST_MOTION * rated, *torque]), _ANGLES, GEARBOXES)
    small = LEVELS.index(LOST_MOTION)
    both_ways = made.wind_up[1 + small] - made.wind_up[0]
    drawn = wind_up(gearbox, torque)
    alike = plain_springs(drawn)
    members = shared_out(drawn, made.wind_up[1:].mean(axis=1))
    waves, left_out = _waves(gearbox)
    start = np.zeros(1)
    return Behaviour(
        torque=np.concatenate([start, torque]),
        wind_up={name: np.concatenate([start, angle]) for name, angle in members.items() if angle.any()},
        scatter=np.concatenate([start, made.wind_up[1:].std(axis=1)]),
        play=made.play,
        lost_motion=made.play + both_ways + 2 * alike[small],
        wave_torque=rated * np.array(_WAVED),
        waves=waves,
        waves_left_out=left_out,
        friction=np.concatenate([start, friction(gearbox, torque)]) + (gearbox.friction_torque or 0.0),
        jammed=made.jammed,
    )


@dataclass(frozen=True, slots=True)
class Made:
    """What gearboxes built of one drawing do: play (gearbox,), wind_up (torque, gearbox) beyond it with its sign, rad; jammed: a share.

    The wind-up holds what differs from gearbox to gearbox: flanks, discs, eccentrics of all stages.
    """

    play: Floats
    wind_up: Floats
    jammed: float


def gearboxes(gearbox: CycloidalDrawing, torque: Floats, angles: int, count: int, seed: int = SEED) -> Made:
    """What do so many gearboxes of this drawing do under torques (torque,) of either sign at the output, on average over `angles` of the crank?"""
    share, steps = _share(gearbox), abs(gearbox.steps)
    crank = 2 * math.pi * np.arange(angles) / angles
    sign = np.sign(torque)[:, None]
    main = simulate(gearbox.drive, gearbox.scatter, share * torque, crank, count, seed)
    play, jammed = share * main.play, main.jammed
    turned = share * _beyond(main, sign)
    first = gearbox.first_stage
    if first is not None and first.kind == "cycloidal":
        before = simulate(first.drive, first.scatter, torque / steps, crank, count, seed + 1)
        play, jammed = play + before.play / steps, jammed | before.jammed
        turned = turned + _beyond(before, sign) / steps
    elif first is not None:
        play = play + sample_dimension(first.play, "first stage play", seed, count) / (first.sun_radius * abs(gearbox.ratio))
    return Made(play, turned, float(jammed.mean()))


def _beyond(made: SimulatedGearboxes, sign: Floats) -> Floats:
    """Give by how much a stage winds up beyond its play (torque, gearbox), on average over the crank; below zero the other way round."""
    ahead, behind = made.ends
    return np.asarray((made.rotation - np.where(sign[:, None] > 0, ahead, behind)).mean(axis=1))


def wind_up(gearbox: CycloidalDrawing, torque: Floats) -> dict[str, Floats]:
    """By which angle (rad) does each member wind up under torques (torque,) above zero at the output, as drawn, play not counted?"""
    share, steps = _share(gearbox), abs(gearbox.steps)
    out = {name: share * angle for name, angle in drive.wind_up_by_member(gearbox.drive, share * torque).items()}
    first = gearbox.first_stage
    if first is not None and first.kind == "cycloidal":
        out |= {f"{FIRST_STAGE}{name}": angle / steps for name, angle in drive.wind_up_by_member(first.drive, torque / steps).items()}
    return out | _outside(gearbox, torque)


def shared_out(as_drawn: dict[str, Floats], found: Floats) -> dict[str, Floats]:
    """Return the members' wind-up (torque,), rad, so that those that differ from gearbox to gearbox add up to their mean `found` (torque,), rad.

    Flanks that differ take the load one after the other: what they wind up beyond flanks as drawn belongs to the lobe contacts. Flanks that press on
    each other wind up less: then all of these members do, in proportion.
    """
    own = sum(as_drawn.values()) - plain_springs(as_drawn)
    share = np.where(found < own, found / np.where(own > 0, own, 1.0), 1.0)
    out = {name: angle if name.removeprefix(FIRST_STAGE) in _ALIKE else share * angle for name, angle in as_drawn.items()}
    return out | {"lobe contacts": out["lobe contacts"] + np.maximum(found - own, 0.0)}


def plain_springs(members: dict[str, Floats]) -> Floats:
    """Which part of the members' wind-up (torque,) is the same in all gearboxes, and so not in what `gearboxes` gives?"""
    return np.asarray(np.sum([angle for name, angle in members.items() if name.removeprefix(FIRST_STAGE) in _ALIKE], axis=0))


def _outside(gearbox: CycloidalDrawing, torque: Floats) -> dict[str, Floats]:
    """Give the wind-up of what stands before and behind the cycloidal stages."""
    first = gearbox.first_stage
    out = {}
    if first is not None and first.kind == "planetary":
        out["first stage"] = torque * first.softness / gearbox.ratio**2
    out["frame"] = torque / (gearbox.frame or math.inf)
    out["input shaft"] = torque / ((gearbox.input_shaft or math.inf) * gearbox.ratio**2)
    return out


def _share(gearbox: CycloidalDrawing) -> float:
    """Give the disc's torque and turn per those of the output: one, or with the ring as output its teeth count."""
    stage = gearbox.stage
    return 1.0 if gearbox.fixed == "ring" else stage.planet_pitch_radius / stage.ring_pitch_radius


def _waves(gearbox: CycloidalDrawing) -> tuple[tuple[Wave, ...], float]:
    """Give the largest waves of the transmission error, with the mean square of all, and the share that the smaller ones had."""
    steps, share = abs(gearbox.steps), _share(gearbox)
    loads = gearbox.rated_torque * np.array(_WAVED)
    found = {k * steps: share**2 * power for k, power in _spectrum(gearbox, share * loads, SEED)}
    first = gearbox.first_stage
    if first is not None and first.kind == "cycloidal":
        before = abs(gearbox.ratio)
        for k, power in _spectrum(first, loads / steps, SEED + 1):
            # whole multiples of the last stage's waves among them
            found[k * before] = found.get(k * before, 0.0) + power / steps**2
    whole = np.sum(list(found.values()), axis=0)
    if not np.any(whole > 0):
        return (), 0.0
    weight = {cycles: float((power / np.where(whole > 0, whole, 1.0)).sum()) for cycles, power in found.items()}
    kept = sorted(weight, key=lambda cycles: -weight[cycles])[:_MOST_WAVES]
    held = np.sum([found[cycles] for cycles in kept], axis=0)
    scale = np.sqrt(whole / np.where(held > 0, held, 1.0))
    waves = tuple(Wave(float(cycles), np.sqrt(found[cycles]) * scale) for cycles in sorted(kept))
    return waves, float(1 - (held / whole)[-1])


def _spectrum(stage: CycloidalStage, loads: Floats, seed: int) -> list[tuple[int, Floats]]:
    """Give the mean square (level,), rad^2, of each harmonic of the crank's turn, averaged over gearboxes."""
    angles = 3 * stage.pins
    crank = 2 * math.pi * np.arange(angles) / angles
    rotation = simulate(stage.drive, stage.scatter, loads, crank, _WAVING, seed).rotation
    power = 2 * (np.abs(np.fft.rfft(rotation, axis=1) / angles) ** 2).mean(axis=2)
    return [(k, power[:, k]) for k in range(1, power.shape[1])]


def friction(gearbox: CycloidalDrawing, torque: Floats) -> Floats:
    """How large (N m) is the friction of flanks, eccentric and output pins, felt at the output, under torques (torque,) above zero?

    The stage at the output alone, whose share is nearly all: what rubs before it is felt divided by the ratio.
    """
    stated = gearbox.friction
    out = np.zeros_like(torque)
    if stated is None:
        return out
    circle = gearbox.output_pins.circle_radius if gearbox.output_pins else math.inf
    rubbing = contact.Friction(stated.flank, stated.bearing, stated.bearing_radius, stated.output, circle)
    crank = drive.crank_angles_of_pitch(gearbox.drive)
    gap = drive.nominal_gaps(gearbox.drive, crank)
    for k, load in enumerate(_share(gearbox) * torque / gearbox.discs):
        answer = drive.loaded_disc(gearbox.drive, float(load), crank, gap)
        out[k] = gearbox.discs * float(contact.friction_torque(gearbox.stage, crank, answer, rubbing).mean())
    return out


def material_shares() -> dict[str, tuple[float, float]]:
    """Return by which share each member's wind-up follows the compliance of the disc's material, and of the ring's."""
    return {"lobe contacts": (0.5, 0.5), "disc body": (1.0, 0.0), **dict.fromkeys(("ring body", "ring lobes", "ring pins"), (0.0, 1.0))}
