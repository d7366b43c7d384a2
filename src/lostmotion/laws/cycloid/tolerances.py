"""Simulated cycloidal stages with manufacturing tolerances: play, lost motion, wind-up and
transmission error of each gearbox.

Every dimension is drawn within its tolerance and converted into gaps at the contacts. The discs, at
equally spaced phases of the same crank, share the torque so that all rotate the output by the same
angle at each crank angle. Without load the first contact in either direction decides, so an error
of one flank has its full effect; under load the errors of the flanks average.

Where flanks of one disc, or of different discs, interfere, the discs push against each other
without any torque. `cycloid.preload` computes their rest angle, from which wind-up is measured.

Errors of pins are common to all discs; errors of flanks belong to one disc. Random numbers are
drawn by the name of the dimension and the number of the gearbox. So the other draws do not change
with another tolerance or with more gearboxes.
"""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid.drive import (
    LEAST_ARM,
    loaded_disc,
    play_per_crank_clearance,
    rest_angle,
)
from lostmotion.laws.cycloid.geometry import (
    arms,
    first_contact_angle,
    gaps,
    gaps_from_pins,
    normals,
    pin_angles,
)
from lostmotion.laws.cycloid.preload import (
    ClearanceEffects,
    carried_torque,
    crossing,
    preloaded_discs,
)
from lostmotion.laws.distributions import Normal, of_tolerance
from lostmotion.units import Toleranced

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.drive import Drive
    from lostmotion.laws.distributions import Law
    from lostmotion.spatial import Floats

_NONE: Final = Toleranced(0.0)


@dataclass(frozen=True, slots=True)
class Scatter:
    """Tolerances (m) of the dimensions of a stage; only clearances have a nominal value.

    Common to one gearbox:
    ring_radius, pin_radius, eccentricity  ± of the dimensions of the stage
    roller, circle                         ± of the profile modification
    crank_clearance, output_clearance      diametral clearances of the crank bearings, and of the
                                           output pins in their holes
    shaft_clearances                       those of the bearings of the shaft, each after the shift
                                           of the discs along their forces per clearance

    Independent, as ± of a normal distribution:
    output_position  of each output pin relative to its hole, in both directions
    crank_position   of each bore of a disc for a crankshaft relative to its flanks, in both
                     directions
    pin_position     of each pin or lobe, radial and tangential
    pin_size         radius of each pin or lobe
    flank_form       of the flank of a disc along its normal, at each pin or lobe
    """

    ring_radius: Toleranced = _NONE
    pin_radius: Toleranced = _NONE
    eccentricity: Toleranced = _NONE
    roller: Toleranced = _NONE
    circle: Toleranced = _NONE
    crank_clearance: Toleranced = _NONE
    output_clearance: Toleranced = _NONE
    shaft_clearances: tuple[tuple[float, Toleranced], ...] = ()
    output_position: float = 0.0
    crank_position: float = 0.0
    pin_position: float = 0.0
    pin_size: float = 0.0
    flank_form: float = 0.0


@dataclass(frozen=True, slots=True)
class SimulatedGearboxes:
    """Results of simulated gearboxes; the last axis is the gearbox.

    ahead, behind  (crank, gearbox) free rotation of the output in either direction from its
                   position without gaps, rad, with all clearances. Their sum is the play. It is
                   zero where discs push against each other; one of the two is then negative.
    torque         (torque,) N m, of either sign
    rotation       (torque, crank, gearbox) of the output under the torque, rad, with its sign and
                   all clearances; at least the free rotation jammed         (gearbox,) whether
                   flanks interfere at every crank angle by more than all clearances
    """

    ahead: Floats
    behind: Floats
    torque: Floats
    rotation: Floats
    jammed: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]

    @property
    def ends(self) -> tuple[Floats, Floats]:
        """Return the ends of the free rotation ahead and behind (crank, gearbox), rad; where discs
        push against each other, the rest angle twice.
        """
        return self.ahead, -self.behind

    @property
    def play(self) -> Floats:
        """Return the play (gearbox,), rad, averaged over a turn of the crank; zero where discs push
        against each other.
        """
        return np.asarray(np.maximum(self.ahead + self.behind, 0.0).mean(axis=0))


def sample(size: float, law: Law, name: str, seed: int, shape: tuple[int, ...]) -> Floats:
    """Return random values of this shape (gearbox, ...) within ± size, from the stream of this
    name. More gearboxes do not change the first ones.
    """
    if not size:
        return np.zeros(shape)
    stream = np.random.Generator(np.random.PCG64([seed, zlib.crc32(name.encode())]))
    # An open interval, as quantile functions require.
    uniforms = (stream.integers(0, 2**53, size=shape) + 0.5) / 2**53
    return law.quantile(uniforms) * (size / law.bound)


def sample_dimension(dimension: Toleranced, name: str, seed: int, count: int) -> Floats:
    """Return random values (gearbox,) of a toleranced dimension, in its unit, from the stream of
    this name.
    """
    return dimension.nominal + sample(
        dimension.tolerance, of_tolerance(dimension.law), name, seed, (count,)
    )


def sample_gaps(drive: Drive, scatter: Scatter, crank: Floats, gearboxes: int, seed: int) -> Floats:
    """Return the gaps (disc, crank, gearbox, N), m, of simulated gearboxes at crank angles
    (crank,), rad; negative for interference.
    """
    stage, pins, normal = drive.stage, drive.stage.pins, Normal()

    def shared(name: str) -> Floats:
        dimension = getattr(scatter, name)
        return sample(dimension.tolerance, of_tolerance(dimension.law), name, seed, (gearboxes,))[
            :, None
        ]

    def each(name: str, stream: str) -> Floats:
        return sample(getattr(scatter, name), normal, stream, seed, (gearboxes, pins))

    radius = shared("pin_radius") + each("pin_size", "pin_size")
    radial = shared("ring_radius") + each("pin_position", "pin_position radial")
    tangential = each("pin_position", "pin_position tangential")
    off, roller, circle = shared("eccentricity"), shared("roller"), shared("circle")
    out = np.empty((drive.discs, len(crank), gearboxes, pins))
    for disc in range(drive.discs):
        theta = pin_angles(stage, crank + 2 * math.pi * disc / drive.discs)[:, None]
        # dR removes (1 - K1 cos theta)/D of itself, as a pin farther out does; planet pins move in
        # the opposite direction.
        taken = (
            roller
            + np.abs(gaps_from_pins(stage, theta, np.zeros(1), np.ones(1), np.zeros(1))) * circle
        )
        moved, turned, _ = _bores(drive, scatter, disc, gearboxes, seed)
        across, along = _in_line_of_centres(moved, crank + 2 * math.pi * disc / drive.discs)
        normal_to = normals(stage, theta)
        shift = (
            normal_to[..., 0] * (off + along[..., None])
            + normal_to[..., 1] * across[..., None]
            + arms(stage, theta) * turned[:, None]
        )
        flank = each("flank_form", f"flank_form disc {disc}")
        out[disc] = (
            gaps(stage, theta, drive.relief)
            + taken
            + flank
            - shift
            + gaps_from_pins(stage, theta, radius, radial, tangential)
        )
    return out


def simulate(
    drive: Drive,
    scatter: Scatter,
    torque: Floats,
    crank: Floats,
    gearboxes: int,
    seed: int,
    *,
    threads: int = 1,
) -> SimulatedGearboxes:
    """Return play and rotation of simulated gearboxes at crank angles (crank,) under torques
    (torque,) of either sign, not zero, N m on the drive.

    Rotations include the deflection of disc, flanks and eccentric (see `cycloid.drive`), not that
    of the output pins. The sharing between discs is interpolated linearly between the computed
    loads, with an error of about 2 % of the angle where their gaps differ much. Without any torque,
    discs that push against each other are placed in the middle of their overlap. The result does
    not depend on `threads`; with more gearboxes the first ones stay the same. Raises
    DidNotConvergeError where a load is beyond the contact law, ValueError for a torque of zero.
    """
    torque, crank = np.asarray(torque, dtype=float), np.asarray(crank, dtype=float)
    if not torque.all():
        raise ValueError(
            "a torque is zero, at which the output is free in its play: see `ahead` and `behind`"
        )
    gap = sample_gaps(drive, scatter, crank, gearboxes, seed)
    angles = [
        pin_angles(drive.stage, crank + 2 * math.pi * disc / drive.discs)[:, None]
        for disc in range(drive.discs)
    ]
    ahead = np.stack(
        [
            first_contact_angle(drive.stage, theta, each, LEAST_ARM)
            for theta, each in zip(angles, gap, strict=True)
        ]
    )
    behind = np.stack(
        [
            first_contact_angle(drive.stage, -theta, each, LEAST_ARM)
            for theta, each in zip(angles, gap, strict=True)
        ]
    )
    alone = ahead.copy(), behind.copy()
    interfering = ahead + behind < 0
    for disc in np.flatnonzero(interfering.any(axis=(1, 2))):
        # Its own flanks fix the disc in one position, from which only the clearances allow the
        # output to move.
        rest = (ahead[disc] - behind[disc]) / 2
        if len(torque):
            turned = crank + 2 * math.pi * disc / drive.discs
            rest = rest_angle(
                drive, turned, gap[disc], float(np.abs(torque).min()), threads=threads
            )
        ahead[disc], behind[disc] = np.where(
            interfering[disc], (rest, -rest), (ahead[disc], behind[disc])
        )
    free = clearance_angle(drive, scatter, gearboxes, seed) / 2
    early, uneven = _output_pins(drive, scatter, crank, gearboxes, seed)
    early = early - _lost_rotation(drive, scatter, gearboxes, seed)[:, None]
    # Clearances may absorb the interference of a disc, so a gearbox is jammed only where the
    # interference exceeds them.
    jammed = (
        ((alone[0] + early[0]).min(axis=0) + (alone[1] + early[1]).min(axis=0) + 2 * free) < 0
    ).all(axis=0)
    first, last = ahead + early[0] + free, behind + early[1] + free
    ends = np.stack([first.min(axis=0), last.min(axis=0)])
    rotation = np.empty((len(torque), len(crank), gearboxes))
    for way, (sign, start) in enumerate(((1.0, ahead), (-1.0, behind))):
        chosen = np.flatnonzero(np.sign(torque) == sign)
        if len(chosen):
            found = (
                _common_rotation(drive, torque[chosen], crank, gap, start, threads)
                + free
                + uneven[way]
            )
            # Errors of the output pins average under load, while the first one to touch ends the
            # free rotation.
            rotation[chosen] = sign * np.maximum(found, ends[way])
    preloaded = ends.sum(axis=0) < 0
    middle = (ends[0] - ends[1]) / 2
    ahead, behind = np.where(preloaded, middle, ends[0]), np.where(preloaded, -middle, ends[1])
    chosen = np.flatnonzero(preloaded.any(axis=0))
    if len(chosen) and len(torque):
        shifts = ClearanceEffects(
            -last[..., chosen], first[..., chosen], (free + uneven)[..., chosen]
        )
        rest, turned = preloaded_discs(
            drive, torque, crank, gap[:, :, chosen], shifts, threads=threads
        )
        own = preloaded[:, chosen]
        rotation[..., chosen] = np.where(own, turned, rotation[..., chosen])
        ahead[:, chosen], behind[:, chosen] = (
            np.where(own, rest[1], ahead[:, chosen]),
            np.where(own, -rest[0], behind[:, chosen]),
        )
    return SimulatedGearboxes(ahead, behind, torque, rotation, jammed)


def clearance_angle(drive: Drive, scatter: Scatter, gearboxes: int, seed: int) -> Floats:
    """Return the play (gearbox,), rad, due to the clearances of crank bearings, G times
    `play_per_crank_clearance`, and of output pins, Gw/Rw.

    The bearings of the shaft count as those of the cranks, by the shift of the discs that each of
    them allows.
    """
    room = sample_dimension(scatter.crank_clearance, "crank_clearance", seed, gearboxes)
    for k, (shift, clearance) in enumerate(scatter.shaft_clearances):
        room = room + shift * sample_dimension(clearance, f"shaft_clearance {k}", seed, gearboxes)
    out = play_per_crank_clearance(drive) * room
    if drive.output is not None:
        out = (
            out
            + sample_dimension(scatter.output_clearance, "output_clearance", seed, gearboxes)
            / drive.output.circle
        )
    return np.asarray(out)


def _bores(
    drive: Drive, scatter: Scatter, disc: int, gearboxes: int, seed: int
) -> tuple[Floats, Floats, Floats]:
    """Return the effect of misplaced bores on a disc: displacement (gearbox, 2), m, rotation
    (gearbox,), rad, and misfits (gearbox, crank, 2), m.

    By least squares, as for equal bearings that all carry load; in the axes of the output.
    """
    count, circle = drive.eccentric.cranks, drive.eccentric.circle
    off = np.stack(
        [
            sample(
                scatter.crank_position,
                Normal(),
                f"crank_position {way} disc {disc}",
                seed,
                (gearboxes, count),
            )
            for way in "xy"
        ],
        axis=-1,
    )
    moved = off.mean(axis=1)
    if count == 1:
        return moved, np.zeros(gearboxes), np.zeros_like(off)
    angle = 2 * math.pi * np.arange(count) / count
    tangent = np.stack([-np.sin(angle), np.cos(angle)], axis=-1)
    around = (off * tangent).sum(axis=-1).mean(axis=1)
    return moved, around / circle, off - moved[:, None] - around[:, None, None] * tangent


def _in_line_of_centres(shift: Floats, crank: Floats) -> tuple[Floats, Floats]:
    """Return the components across and along the line of centres, both (crank, gearbox), of
    displacements (gearbox, 2) in the output's axes.
    """
    cosine, sine = np.cos(crank)[:, None], np.sin(crank)[:, None]
    return shift[:, 1] * cosine - shift[:, 0] * sine, shift[:, 0] * cosine + shift[:, 1] * sine


def _lost_rotation(drive: Drive, scatter: Scatter, gearboxes: int, seed: int) -> Floats:
    """Return the reduction (disc, gearbox), rad, of the free rotation in each direction by bores
    that are misplaced relative to the crankshafts.

    A bearing with the misfit r in its half clearance g has the free motion of one with the half
    clearance sqrt(g^2 - r^2), and none from r = g on. The bearing with the largest misfit decides.
    """
    half = (
        np.maximum(
            sample_dimension(scatter.crank_clearance, "crank_clearance", seed, gearboxes), 0.0
        )
        / 2
    )
    off = np.stack(
        [
            np.linalg.norm(_bores(drive, scatter, disc, gearboxes, seed)[2], axis=-1).max(axis=1)
            for disc in range(drive.discs)
        ]
    )
    return np.asarray(
        play_per_crank_clearance(drive) * (half - np.sqrt(np.maximum(half**2 - off**2, 0.0)))
    )


def _output_pins(
    drive: Drive, scatter: Scatter, crank: Floats, gearboxes: int, seed: int
) -> tuple[Floats, Floats]:
    """Return the effect of misplaced output pins, rad: on the free rotation, and under load.

    The first is (direction, disc, crank, gearbox), the second (direction, crank, gearbox). A pin at
    the angle phi from the line of centres, misplaced along that line by d, touches its hole at the
    rotation (Gw/2 + d)/(Rw sin phi). The first pin that touches ends the free rotation. Under load
    the rotation is sum(sin phi d)/(Rw sum(sin phi^2)), averaged over the discs.
    """
    shape = (2, drive.discs, len(crank), gearboxes)
    pins = drive.output
    if pins is None or not scatter.output_position:
        return np.zeros(shape), np.zeros((2, len(crank), gearboxes))
    half = (
        sample_dimension(scatter.output_clearance, "output_clearance", seed, gearboxes)[:, None] / 2
    )
    early, uneven = np.empty(shape), np.empty(shape)
    for disc in range(drive.discs):
        first, second = (
            sample(
                scatter.output_position,
                Normal(),
                f"output_position {way} disc {disc}",
                seed,
                (gearboxes, pins.count),
            )
            for way in "xy"
        )
        turned = (crank + 2 * math.pi * disc / drive.discs)[:, None, None]
        off = first * np.cos(turned) + second * np.sin(turned)
        sine = np.sin(2 * math.pi * np.arange(pins.count) / pins.count - turned)
        for way, sign in enumerate((1.0, -1.0)):
            leaning = np.maximum(sign * sine, 0.0)
            touches = leaning > LEAST_ARM
            lever = pins.circle * np.where(touches, leaning, 1.0)
            with_error = np.where(touches, (half + off) / lever, np.inf).min(axis=-1)
            early[way, disc] = with_error - np.where(touches, half / lever, np.inf).min(axis=-1)
            uneven[way, disc] = (leaning * off).sum(axis=-1) / (
                pins.circle * (leaning**2).sum(axis=-1)
            )
    return early, uneven.mean(axis=1)


def _common_rotation(
    drive: Drive, torque: Floats, crank: Floats, gap: Floats, start: Floats, threads: int
) -> Floats:
    """Return the common angle (torque, crank, gearbox), rad, positive, at which the discs share
    torques of one sign; `start`: first contacts.
    """
    sign = float(np.sign(torque[0]))
    # Each disc alone, from its first contact to the total torque, of which it may carry nearly all.
    wanted = np.abs(torque)
    loads = np.unique(np.concatenate([[0.0], wanted / drive.discs, [wanted.max()]]))
    alone = np.empty((drive.discs, len(loads), *gap.shape[1:3]))
    for disc in range(drive.discs):
        turned = crank + 2 * math.pi * disc / drive.discs
        for k, each in enumerate(loads[1:], 1):
            alone[disc, k] = (
                sign
                * loaded_disc(
                    drive, sign * float(each), turned, gap[disc], threads=threads
                ).rotation[0]
            )
        # Interfering flanks push each other apart without torque.
        alone[disc, 0] = np.minimum(start[disc], alone[disc, 1])
    points = alone.reshape(-1, *alone.shape[2:])
    sums = np.stack([sum(carried_torque(each, loads, point) for each in alone) for point in points])
    return np.stack([crossing(points, sums, sums < whole, whole) for whole in wanted])
