"""What cycloidal gearboxes of one drawing do as they are built, and the error terms that follow from it.

Worked out once per drawing, on 256 gearboxes with draws of their own that no study's seed changes: how much play they have, by how much they wind up
and through which member, and which waves their transmission error is made of. Poses then cost a look into these tables.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid import contact, drive
from lostmotion.laws.cycloid.tolerances import sample_dimension, simulate
from lostmotion.laws.distributions import Normal
from lostmotion.laws.gears import friction_loop
from lostmotion.parts.error_source import OF_RATED, ErrorSource, Friction
from lostmotion.parts.forms import Curve, Harmonic, Spring
from lostmotion.parts.standard_terms import PHASES, TRANSMISSION_ERROR, backlash_terms, loop_term, spring_terms
from lostmotion.parts.term import Draw, Parameter, Term
from lostmotion.units import Toleranced

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.laws.cycloid.tolerances import SimulatedGearboxes
    from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
    from lostmotion.parts.gearbox.cycloidal_stage import CycloidalStage
    from lostmotion.parts.term import Holding, Motion
    from lostmotion.spatial import Floats

GEARBOXES: Final = 256
SEED: Final = 1
# Of the rated torque.
LEVELS: Final = (0.01, 0.03, 0.1, 0.3, 0.6, 1.0, 1.5, 2.5)
_WAVED: Final = (0.1, 1.0)
# Fewer gearboxes where every crank angle counts.
_WAVING: Final = 48
_MOST_WAVES: Final = 4
# Before the names of a cycloidal first stage's members.
FIRST_STAGE: Final = "first stage, "
# Members that are plain springs and the same in all gearboxes.
_ALIKE: Final = ("output pins", "first stage", "frame", "input shaft")
LOST_MOTION: Final = 0.03  # one of the levels
_ANGLES: Final = 4


@dataclass(frozen=True, slots=True)
class Wave:
    """One wave of the transmission error: `cycles` per turn of the output; `size` (level,) rad, root mean square over gearboxes and angles."""

    cycles: float
    size: Floats


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


def along(load: Floats | float, torque: Floats, values: Floats) -> Floats:
    """Which value belongs to loads (any shape, zero or more)? On straight lines between the levels, and straight on beyond the last."""
    load = np.asarray(load, dtype=float)
    slope = (values[-1] - values[-2]) / (torque[-1] - torque[-2])
    return np.asarray(np.interp(load, torque, values) + np.maximum(load - torque[-1], 0.0) * slope)


def along_curve(load: Floats, torque: Floats, values: Floats) -> Floats:
    """Which value belongs to loads (any shape) of either sign on a curve that is odd in the load? As `along`."""
    return np.sign(load) * along(np.abs(load), torque, values)


@functools.lru_cache(maxsize=64)
def behaviour(gearbox: CycloidalGearbox) -> Behaviour:
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


def gearboxes(gearbox: CycloidalGearbox, torque: Floats, angles: int, count: int, seed: int = SEED) -> Made:
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


def wind_up(gearbox: CycloidalGearbox, torque: Floats) -> dict[str, Floats]:
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


def _outside(gearbox: CycloidalGearbox, torque: Floats) -> dict[str, Floats]:
    """Give the wind-up of what stands before and behind the cycloidal stages."""
    first = gearbox.first_stage
    out = {}
    if first is not None and first.kind == "planetary":
        out["first stage"] = torque * first.softness / gearbox.ratio**2
    out["frame"] = torque / (gearbox.frame or math.inf)
    out["input shaft"] = torque / ((gearbox.input_shaft or math.inf) * gearbox.ratio**2)
    return out


def _share(gearbox: CycloidalGearbox) -> float:
    """Give the disc's torque and turn per those of the output: one, or with the ring as output its teeth count."""
    stage = gearbox.stage
    return 1.0 if gearbox.fixed == "ring" else stage.planet_pitch_radius / stage.ring_pitch_radius


def _waves(gearbox: CycloidalGearbox) -> tuple[tuple[Wave, ...], float]:
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


def friction(gearbox: CycloidalGearbox, torque: Floats) -> Floats:
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


@dataclass(frozen=True, slots=True)
class WindUp(ErrorSource):
    """One member's wind-up (level,) at torques (level,), its standard deviation over gearboxes, and the ± share by which its material scatters."""

    torque: Floats
    angle: Floats
    scatter: Floats | None = None
    material: float = 0.0

    def terms(self, motion: Motion) -> list[Term]:
        """Return the wind-up, its scatter over gearboxes, and that of the material."""
        sized = Parameter("stiffness")
        out = spring_terms(motion.twist, Curve.through(self.torque, self.angle), self.material, sized, "material scatter", "material")
        if self.scatter is not None and self.scatter.any():
            form = Spring(motion.twist, Curve.through(self.torque, self.scatter))
            out.append(Term("wind-up scatter", "wind-up scatter", form, robot=Draw("wind-up", Normal()), parameter=sized, exponent=-1))
        return out


@dataclass(frozen=True, slots=True)
class Play(ErrorSource):
    """Free play of scattered size, which a load above `friction` (N m) closes; `reason` where that is assumed."""

    play: Toleranced
    friction: float
    reason: str = ""

    def play_friction(self, holding: Callable[[], Holding]) -> Friction:  # noqa: ARG002 - a drawn gearbox is rated
        """Return what the drawing states, or else what is assumed."""
        return Friction(self.friction, self.reason)

    def terms(self, motion: Motion) -> list[Term]:
        """Return the play on the side where the load or the last motion leaves the output."""
        return backlash_terms(motion, self.play, self.friction)


@dataclass(frozen=True, slots=True)
class Waves(ErrorSource):
    """Transmission error as waves, whose size (level,) follows the load and whose size and phase differ from gearbox to gearbox."""

    torque: Floats
    waves: tuple[Wave, ...]

    def terms(self, motion: Motion) -> list[Term]:
        """Return two terms per harmonic, with draws of their own: amplitude and phase both differ."""
        sized, law, out = Parameter(TRANSMISSION_ERROR), Normal(), []
        for wave in self.waves:
            envelope = Curve(self.torque, wave.size)
            for phase in PHASES:
                name = f"{wave.cycles:g} per turn {phase}"
                form = Harmonic(motion.twist, wave.cycles, phase, envelope=envelope)
                out.append(Term(name, TRANSMISSION_ERROR, form, robot=Draw(name, law), parameter=sized))
        return out


@dataclass(frozen=True, slots=True)
class Loop(ErrorSource):
    """The loop that friction (level,), N m, leaves on a spring that winds up by `angle` (level,), rad, at torques (level,)."""

    torque: Floats
    angle: Floats
    friction: Floats

    def branches(self, load: Floats) -> tuple[Floats, Floats]:
        """Return the angles (rad) at which loads (any shape, N m) of either sign leave the output as they rise, and as they fall."""
        rubs = along(np.abs(load), self.torque, self.friction)
        return friction_loop(lambda torque: along_curve(torque, self.torque, self.angle), load, rubs)

    def terms(self, motion: Motion) -> list[Term]:
        """Return half the width of the loop to either side."""
        return [loop_term(Spring(motion.twist, self.half_width, odd=False), 1.0, Parameter("hysteresis"))]

    @property
    def half_width(self) -> Curve:
        """Return half the width (rad) of the loop over the size of the load, N m.

        Exact: spring and friction are piecewise linear, so that the width is too, with a knot wherever the load, or the load with friction added or
        taken away, stands at a level.
        """
        low, rubs = self.torque, self.friction
        steps = np.diff(low)
        slope = np.append(np.diff(rubs) / steps, (rubs[-1] - rubs[-2]) / steps[-1])
        high = np.append(low[1:], np.inf)
        knots = [low]
        for sign in (1.0, -1.0):
            # load + sign x friction = level, solved on each stretch of the friction's curve
            growth = 1 + sign * slope
            start = low + sign * rubs
            for level in (*-low, *low):
                with np.errstate(divide="ignore", invalid="ignore"):
                    load = low + (level - start) / growth
                knots.append(load[(load >= low) & (load < high)])
        load = np.unique(np.concatenate(knots))
        load = np.append(load, 2 * load[-1])
        rising, falling = self.branches(load)
        return Curve.through(load, (falling - rising) / 2)


def material_shares() -> dict[str, tuple[float, float]]:
    """Return by which share each member's wind-up follows the compliance of the disc's material, and of the ring's."""
    return {"lobe contacts": (0.5, 0.5), "disc body": (1.0, 0.0), **dict.fromkeys(("ring body", "ring lobes", "ring pins"), (0.0, 1.0))}


def sources(gearbox: CycloidalGearbox) -> dict[str, ErrorSource]:
    """Which sources of error has a gearbox of this drawing? Those that are zero are left out.

    Play and wind-up are drawn apart. In a gearbox they offset each other a little, for a flank that touches early is then the first to yield: so
    together they scatter up to a third more here than they should.
    """
    found = gearbox.behaviour
    out: dict[str, ErrorSource] = {}
    play = float(found.play.mean())
    if play > 0:
        # a normal law of the same mean and deviation, cut where the play would be none
        limit = min(float(found.play.std()) * Normal().bound, play)
        out["play"] = Play(Toleranced(play, limit), gearbox.friction_at_rest, OF_RATED if gearbox.friction_torque is None else "")
    disc, ring = gearbox.disc_material.scatter, gearbox.ring_material.scatter
    scatters = {name: of_disc * disc + of_ring * ring for name, (of_disc, of_ring) in material_shares().items()}
    for name, angle in found.wind_up.items():
        if angle.any():
            scatter = found.scatter if name == "lobe contacts" else None
            out[name] = WindUp(found.torque, angle, scatter, scatters.get(name, 0.0))
    if found.waves:
        out["transmission error"] = Waves(found.wave_torque, found.waves)
    if found.friction.any():
        out["friction"] = found.loop
    return out
