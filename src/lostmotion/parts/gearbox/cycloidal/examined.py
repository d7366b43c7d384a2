"""Figures of a cycloidal gearbox from its drawing: lobe loads, the spread of manufactured samples,
compliance by member, transmission error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid.drive import (
    crank_angles_of_pitch,
    crank_force,
    loaded_disc,
    nominal_gaps,
)
from lostmotion.laws.cycloid.envelope import mean_contacts, second_contacts
from lostmotion.laws.cycloid.envelope_contact import envelope_contact
from lostmotion.laws.cycloid.geometry import arms, gaps, pin_angles, pressure_angles
from lostmotion.laws.cycloid.geometry import ratio as ratio_of
from lostmotion.laws.cycloid.tolerances import sample as sample_within
from lostmotion.laws.distributions import Normal
from lostmotion.laws.torque_angle import CurveReadings, Definitions, SampledCurve, readings
from lostmotion.parts.gearbox.bands import GearBands, Middle, bands_of_drawing
from lostmotion.parts.gearbox.cycloidal.envelope import branches
from lostmotion.parts.gearbox.cycloidal.materials import material_shares
from lostmotion.parts.gearbox.cycloidal.model import (
    LEVELS,
    distribute_wind_up,
    friction,
    load_side,
    wind_up,
    wind_up_without_scatter,
)
from lostmotion.parts.gearbox.cycloidal.samples import disc_share, gearboxes, simulated

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.envelope_contact import EnvelopeContact
    from lostmotion.laws.cycloid.friction import DriveFriction
    from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
    from lostmotion.parts.gearbox.cycloidal.envelope import Branches
    from lostmotion.parts.gearbox.cycloidal.stage import CycloidalStage
    from lostmotion.spatial import Floats

# Customary share of the torque on one of two discs, where load sharing is not computed.
CUSTOMARY_SHARE: Final = 0.55
# Crank angles over which a simulated gearbox is averaged, as for its behaviour in an arm.
_ANGLES: Final = 4
# Largest number of samples with a transmission error, and crank angles per pin (even): two periods
# per pin are resolved.
MOST_SPECTRA: Final = 64
_PER_PIN: Final = 4
SHOWN: Final = 4
# Light load, as a share of the torque.
LIGHT: Final = 0.1
FRICTION_LOADS: Final = (0.1, 0.3, 0.6, 1.0)


@dataclass(frozen=True)
class Lobes:
    """Nominal loads of one disc's lobes, when it carries this share of the torque.

    theta, pressure_angle (N,) rad; force (N,) N and peak (N,) Pa at crank angle zero, where a pin
    is on the line of centres. Over a pitch of the crank: carrying, fewest and most lobes in
    contact; largest_force and largest_peak; bearing, mean force (N) on each eccentric bearing.
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
    """Transmission error: lead of the output over the nominal ratio, rad, under loads (load,), N m:
    a tenth of the torque and the full torque.

    crank (angle,) rad, one turn; errors (load, angle, gearbox); cycles (order,) per turn of the
    output, power (load, order, gearbox) the squared amplitude of each harmonic, rad^2.
    """

    loads: Floats
    crank: Floats
    errors: Floats
    cycles: Floats
    power: Floats

    @property
    def peak_to_peak(self) -> Floats:
        """Return the span of the error over a turn of the crank (load, gearbox)."""
        return np.asarray(np.ptp(self.errors, axis=1))

    @property
    def mean_square(self) -> Floats:
        """Return the mean square of the error over a turn of the crank (load, gearbox), rad^2."""
        return np.asarray((self.errors[:, :-1] ** 2).mean(axis=1))

    @property
    def amplitude(self) -> Floats:
        """Return the amplitudes (load, order), rad, the root mean square over gearboxes."""
        return np.asarray(np.sqrt(self.power.mean(axis=2)))


@dataclass(frozen=True)
class ExaminedDrawing:
    """Results from the drawing.

    lobes for each share of the torque on a disc; play (gearbox,) rad; curve and read, with the
    scatter of the materials; jammed: number of jammed gearboxes; members: the mean wind-up (rad) by
    name, largest first; bands: the figures over draws of what the drawing leaves open, None where
    it has no ranges; branches, before: contacts of both branches of the stage at the output and of
    a first stage, None without envelope lobes.
    """

    lobes: tuple[Lobes, ...]
    play: Floats
    curve: SampledCurve
    read: CurveReadings
    jammed: int
    members: dict[str, float]
    transmission: Transmission
    bands: GearBands | None = None
    branches: BothBranches | None = None
    before: BothBranches | None = None

    @property
    def friction(self) -> DriveFriction:
        """Return the friction at the output."""
        return self.curve.friction

    @property
    def without_play(self) -> bool:
        """Return whether the drawing describes nothing that opens play, and no gearbox is
        preloaded: real ones then have more play, lost motion and transmission error.
        """
        return not (self.play.any() or self.jammed or np.ptp(self.lost_motion))

    @property
    def lost_motion(self) -> Floats:
        """Return the lost motion (gearbox,), rad; of a drawing its torque is always known."""
        if self.read.lost_motion is None:
            raise ValueError("no torque for the lost motion")
        return self.read.lost_motion


def drawn(gearbox: CycloidalGearbox, asked: Definitions, count: int, seed: int) -> ExaminedDrawing:
    """Return the results of manufactured samples of a drawing at these torques. Raises
    DidNotConvergeError where the contacts cannot carry one.
    """
    torque, rated = asked.torque, gearbox.rated_torque
    needed = [LIGHT * torque, *asked.levels]
    levels = np.unique(
        [*needed, *(level * rated for level in LEVELS if level * rated < max(needed))]
    )
    made = gearboxes(gearbox, np.concatenate([-levels[::-1], levels]), _ANGLES, count, seed)
    # the curve of a sample is the mean of both directions, as in a measured loop
    flanks = (made.wind_up[len(levels) :] - made.wind_up[: len(levels)][::-1]) / 2
    as_drawn = wind_up(gearbox, levels)
    softer = _of_materials(gearbox, as_drawn, count, seed)
    angle = flanks + wind_up_without_scatter(as_drawn)[:, None] + softer
    start = np.zeros(1)
    curve = SampledCurve(
        np.concatenate([start, levels]),
        np.concatenate([np.zeros((1, count)), angle]),
        friction(gearbox, levels),
        np.concatenate([start, load_side(gearbox, as_drawn)]),
    )
    at = int(np.searchsorted(levels, torque))
    own = (flanks + softer).mean(axis=1)
    found = distribute_wind_up(as_drawn, own)
    members = {name: float(each[at]) for name, each in found.items() if each.any()}
    shares = (0.5, CUSTOMARY_SHARE) if gearbox.discs == 2 else (1 / gearbox.discs,)  # noqa: PLR2004 - of a pair
    first = gearbox.cycloidal_first_stage
    before = (
        None if first is None else both_branches(first, torque / abs(gearbox.steps) / first.discs)
    )
    return ExaminedDrawing(
        lobes=tuple(_lobes(gearbox, torque, share) for share in shares),
        play=made.play,
        curve=curve,
        read=readings(curve, made.play, asked),
        jammed=round(made.jammed * count),
        members=dict(sorted(members.items(), key=lambda member: -member[1])),
        transmission=_transmission(
            gearbox, torque * np.array([LIGHT, 1.0]), min(MOST_SPECTRA, max(count, SHOWN)), seed
        ),
        bands=bands_of_drawing(
            gearbox, Middle(asked, levels, as_drawn, own, curve, float(made.play.mean())), seed
        ),
        branches=both_branches(gearbox, shares[0] * (torque * disc_share(gearbox))),
        before=before,
    )


def _of_materials(
    gearbox: CycloidalGearbox, as_drawn: dict[str, Floats], count: int, seed: int
) -> Floats:
    """Return the scatter of the wind-up (level, gearbox), rad, due to the moduli: normal
    distributions with three sigma at the stated scatter.
    """
    out = np.zeros((len(next(iter(as_drawn.values()))), count))
    for each in material_shares(gearbox):
        off = (
            1 / (1 + sample_within(each.material.scatter, Normal(), each.name, seed, (count,))) - 1
        )
        for name, share in each.shares.items():
            if name in as_drawn:
                out += share * as_drawn[name][:, None] * off
    return out


def _lobes(gearbox: CycloidalGearbox, torque: float, share: float) -> Lobes:
    drive, stage = gearbox.drive, gearbox.stage
    crank = crank_angles_of_pitch(drive)
    load = share * (torque * disc_share(gearbox))
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


def _transmission(gearbox: CycloidalGearbox, loads: Floats, count: int, seed: int) -> Transmission:
    """Return the transmission error of the output stage, and of a cycloidal first stage, over a
    turn of the output stage's crank.
    """
    steps, share = abs(gearbox.steps), disc_share(gearbox)
    main = share * _errors(gearbox, share * loads, count, seed)
    found = _powers(main, steps)
    first, angles = gearbox.cycloidal_first_stage, main.shape[1]
    if first is not None:
        before = _errors(first, loads / steps, count, seed + 1) / steps
        times = abs(ratio_of(first.stage))
        angles = math.lcm(angles, times * before.shape[1])
        main = _finer(main, angles) + np.tile(_finer(before, angles // times), (1, times, 1))
        both = _powers(main, steps)
        found = {
            cycles: both[cycles] for cycles in sorted({*found, *_powers(before, steps * times)})
        }
    crank = 2 * math.pi * np.arange(angles + 1) / angles
    errors = np.concatenate([main, main[:, :1]], axis=1)
    return Transmission(
        loads, crank, errors, np.array(list(found)), np.stack(list(found.values()), axis=1)
    )


def _errors(stage: CycloidalStage, loads: Floats, count: int, seed: int) -> Floats:
    """Return the transmission error of the stage (load, angle, gearbox), rad, over a turn of its
    crank, without its mean and the highest harmonic.
    """
    angles = _PER_PIN * stage.pins
    rotation = simulated(stage, loads, angles, count, seed).rotation
    harmonics = np.fft.rfft(-rotation, axis=1)
    harmonics[:, [0, -1]] = 0.0
    return np.asarray(np.fft.irfft(harmonics, angles, axis=1))


def _powers(errors: Floats, steps: float) -> dict[float, Floats]:
    """Return the squared amplitude (load, gearbox) of each harmonic, by its cycles per turn of the
    output.
    """
    power = (2 * np.abs(np.fft.rfft(errors, axis=1)[:, 1:-1]) / errors.shape[1]) ** 2
    return {float((k + 1) * steps): power[:, k] for k in range(power.shape[1])}


def _finer(errors: Floats, count: int) -> Floats:
    """Return errors (load, angle, gearbox) of one turn interpolated to `count` angles, no fewer
    than before, with the same harmonics.
    """
    return np.asarray(
        np.fft.irfft(np.fft.rfft(errors, axis=1), count, axis=1) * (count / errors.shape[1])
    )


_TURN: Final = 360


@dataclass(frozen=True)
class BothBranches:
    """Contacts of both branches of a stage.

    mean, fewest, most  number of contacts of both branches over a turn of the crank
    effect              stiffening of the contacts with a rigid disc and ring, and its method
    elastic             whether disc or ring is elastic, so that the contacts of both branches are
                        solved together on them
    theta, arm, gap     (contact,) rad, m and m of the second contacts at crank zero that turn the
                        disc as its first ones do
    solved              equilibrium along the whole flank, each (crank,) over a pitch; None with the
                        rule
    """

    mean: float
    fewest: int
    most: int
    effect: Branches
    elastic: bool
    theta: Floats
    arm: Floats
    gap: Floats
    solved: EnvelopeContact | None


def both_branches(part: CycloidalStage, torque: float) -> BothBranches | None:
    """Return the contacts of both branches of a stage under a torque (N m) on one disc; None
    without a second branch.

    Raises DidNotConvergeError where the contacts cannot carry the torque.
    """
    stage, drive = part.stage, part.drive
    effect = branches(stage, part.envelope)
    if effect is None:
        return None
    first = int(mean_contacts(stage)[0])
    found = np.isfinite(
        second_contacts(stage, 2 * math.pi / stage.pins * np.arange(_TURN) / _TURN)
    ).sum(axis=1)
    theta = -stage.lobes * second_contacts(stage, [0.0])[0]
    theta -= 2 * math.pi * np.round(theta / (2 * math.pi))
    driving = np.sort(theta[np.isfinite(theta) & (arms(stage, theta) > 0)])
    solved = None
    if effect.method == "exact":
        solved = envelope_contact(
            stage, drive.flanks, torque, crank_angles_of_pitch(drive), drive.relief
        )
    return BothBranches(
        mean=sum(mean_contacts(stage)),
        fewest=first + int(found.min()),
        most=first + int(found.max()),
        effect=effect,
        elastic=not (drive.disc_body is None and drive.ring_body is None),
        theta=driving,
        arm=arms(stage, driving),
        gap=gaps(stage, driving, drive.relief),
        solved=solved,
    )
