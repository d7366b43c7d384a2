"""What only the drawing of a cycloidal gearbox tells: which lobes carry, how it comes out when built, through what it gives, how evenly it turns."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid import pin_angles, pressure_angles
from lostmotion.laws.cycloid import ratio as ratio_of
from lostmotion.laws.cycloid_built import built
from lostmotion.laws.cycloid_contact import efficiency
from lostmotion.laws.cycloid_drive import crank_force, loaded_disc, nominal_gaps, pitch_of_crank
from lostmotion.parts.gearbox.cycloidal_behaviour import LOST_MOTION, along, gearboxes, plain_springs, wind_up

if TYPE_CHECKING:
    from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
    from lostmotion.parts.gearbox.cycloidal_stage import CycloidalStage
    from lostmotion.spatial import Floats

# What one of two discs is taken to carry where nobody works out how they share.
CUSTOMARY_SHARE: Final = 0.55
# Crank angles over which a built gearbox is averaged, as for its behaviour in an arm.
_ANGLES: Final = 4
# Gearboxes whose transmission error is followed, and crank angles per pin, an even number: nearly two waves per pin are still seen.
FOLLOWED: Final = 48
_PER_PIN: Final = 4
SHOWN: Final = 4
# Of the torque.
LIGHT: Final = 0.1
FRICTION_LOADS: Final = (0.1, 0.3, 0.6, 1.0)


@dataclass(frozen=True)
class Lobes:
    """What one disc's lobes carry as drawn, when this share of the torque is on it.

    theta, pressure_angle (N,) rad; force (N,) N and peak (N,) Pa with the crank at zero, where a pin stands on the line of centres. Over a pitch of
    the crank: carrying, fewest and most lobes in contact; largest_force and largest_peak; bearing, N on each eccentric bearing of a disc on average.
    """

    share: float
    theta: Floats
    pressure_angle: Floats
    force: Floats
    peak: Floats
    carrying: tuple[int, int]
    largest_force: float
    largest_peak: float
    bearing: float


@dataclass(frozen=True)
class Transmission:
    """How far the output runs ahead of an even ratio, rad, under loads (load,), N m: a tenth of the torque and all of it.

    crank (angle,) rad, once round; errors (load, angle, gearbox); cycles (wave,) per turn of the output, amplitude (load, wave), the root mean square
    over gearboxes.
    """

    loads: Floats
    crank: Floats
    errors: Floats
    cycles: Floats
    amplitude: Floats

    @property
    def peak_to_peak(self) -> Floats:
        """Give the span of the error over a turn of the crank (load, gearbox)."""
        return np.asarray(np.ptp(self.errors, axis=1))


@dataclass(frozen=True)
class Rubbing:
    """Friction (load,) N m felt at the output under loads (load,) N m, and the share of the power that arrives."""

    loads: Floats
    friction: Floats
    efficiency: Floats


@dataclass(frozen=True)
class Drawn:
    """What was found.

    lobes for each share that a disc may carry; play and lost_motion (gearbox,) rad, the latter between ± the torque small (N m); jammed: how many of
    the gearboxes; members: the wind-up (rad) by name, largest first.
    """

    lobes: tuple[Lobes, ...]
    play: Floats
    lost_motion: Floats
    small: float
    jammed: int
    members: dict[str, float]
    transmission: Transmission
    rubbing: Rubbing | None


def drawn(gearbox: CycloidalGearbox, torque: float, count: int, seed: int) -> Drawn:
    """What does the drawing tell under a torque (N m) above zero? Raises DidNotConvergeError where the contact law does not hold the load."""
    small = np.array([LOST_MOTION * gearbox.rated_torque])
    made = gearboxes(gearbox, np.array([-small[0], small[0]]), _ANGLES, count, seed)
    alike = float(plain_springs(wind_up(gearbox, small))[0])
    found = gearbox.behaviour
    members = {name: float(along(torque, found.torque, angle)) for name, angle in found.wind_up.items()}
    rubbing = None
    if found.friction.any():
        loads = torque * np.array(FRICTION_LOADS)
        friction = along(loads, found.torque, found.friction)
        rubbing = Rubbing(loads, friction, efficiency(loads, friction))
    shares = (0.5, CUSTOMARY_SHARE) if gearbox.discs == 2 else (1 / gearbox.discs,)  # noqa: PLR2004 - of a pair
    return Drawn(
        lobes=tuple(_lobes(gearbox, torque, share) for share in shares),
        play=made.play,
        lost_motion=made.play + made.wind_up[1] - made.wind_up[0] + 2 * alike,
        small=float(small[0]),
        jammed=round(made.jammed * count),
        members=dict(sorted(members.items(), key=lambda member: -member[1])),
        transmission=_transmission(gearbox, torque * np.array([LIGHT, 1.0]), seed),
        rubbing=rubbing,
    )


def disc_torque(gearbox: CycloidalGearbox, torque: float) -> float:
    """Which torque (N m) is on all discs together, as seen with the ring held, under a torque at the output?"""
    return torque * abs(ratio_of(gearbox.stage) / gearbox.steps)


def _lobes(gearbox: CycloidalGearbox, torque: float, share: float) -> Lobes:
    drive, stage = gearbox.drive, gearbox.stage
    crank = pitch_of_crank(drive)
    load = share * disc_torque(gearbox, torque)
    answer = loaded_disc(drive, load, crank, nominal_gaps(drive, crank))
    theta = pin_angles(stage, crank[:1])[0]
    carrying = answer.lobes[0, :, 0]
    return Lobes(
        share=share,
        theta=theta,
        pressure_angle=pressure_angles(stage, theta),
        force=answer.forces[0, 0, 0],
        peak=answer.pressures[0, 0, 0],
        carrying=(int(carrying.min()), int(carrying.max())),
        largest_force=float(answer.forces.max()),
        largest_peak=float(answer.pressures.max()),
        bearing=crank_force(drive, load),
    )


def _transmission(gearbox: CycloidalGearbox, loads: Floats, seed: int) -> Transmission:
    """Follow the transmission error of the stage at the output, and of a cycloidal stage before it, over a turn of the output stage's crank."""
    steps, share = abs(gearbox.steps), disc_torque(gearbox, 1.0)
    main = share * _errors(gearbox, share * loads, seed)
    found = dict(_powers(main, steps))
    first, angles = gearbox.first_stage, main.shape[1]
    if first is not None and first.kind == "cycloidal":
        before = _errors(first, loads / steps, seed + 1) / steps
        times = abs(ratio_of(first.stage))
        angles = math.lcm(angles, times * before.shape[1])
        for cycles, power in _powers(before, steps * times).items():
            found[cycles] = found.get(cycles, 0.0) + power
        main = _finer(main, angles) + np.tile(_finer(before, angles // times), (1, times, 1))
    crank = 2 * math.pi * np.arange(angles + 1) / angles
    errors = np.concatenate([main, main[:, :1]], axis=1)
    waves = sorted(found)
    return Transmission(loads, crank, errors, np.array(waves), np.sqrt(np.array([found[cycles] for cycles in waves])).T)


def _errors(stage: CycloidalStage, loads: Floats, seed: int) -> Floats:
    """Give how far the stage's output runs ahead (load, angle, gearbox), rad, over a turn of its crank, without its mean and the fastest wave."""
    angles = _PER_PIN * stage.pins
    crank = 2 * math.pi * np.arange(angles) / angles
    rotation = built(stage.drive, stage.scatter, loads, crank, FOLLOWED, seed).rotation
    waves = np.fft.rfft(-rotation, axis=1)
    waves[:, [0, -1]] = 0.0
    return np.asarray(np.fft.irfft(waves, angles, axis=1))


def _powers(errors: Floats, steps: float) -> dict[float, Floats]:
    """Give the mean square amplitude (load,) over gearboxes of each wave, by its cycles per turn of the output."""
    amplitude = 2 * np.abs(np.fft.rfft(errors, axis=1)[:, 1:-1]) / errors.shape[1]
    return {float((k + 1) * steps): power for k, power in enumerate((amplitude**2).mean(axis=2).T)}


def _finer(errors: Floats, count: int) -> Floats:
    """Read errors (load, angle, gearbox) of one turn at so many angles, no fewer: the same waves, and none besides."""
    return np.asarray(np.fft.irfft(np.fft.rfft(errors, axis=1), count, axis=1) * (count / errors.shape[1]))
