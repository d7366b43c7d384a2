"""Simulated cycloidal stages with manufacturing tolerances: play, lost motion, wind-up and
transmission error of each gearbox.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.laws.cycloid.drive import (
    LEAST_ARM,
    play_per_crank_clearance,
    rest_angle,
    rotations,
)
from lostmotion.laws.cycloid.geometry import (
    first_contact_angle,
    pin_angles,
)
from lostmotion.laws.cycloid.preload import (
    ClearanceEffects,
    carried_torque,
    crossing,
    preloaded_discs,
)
from lostmotion.laws.cycloid.tolerances import (
    DimensionScatter,
    bores,
    clearance_angle,
    sample,
    sample_dimension,
    sample_gaps,
)
from lostmotion.laws.distributions import Normal

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.drive import Drive
    from lostmotion.spatial import Floats


@dataclass(frozen=True, slots=True)
class SimulatedGearboxes:
    """Results of simulated gearboxes; the last axis is the gearbox.

    ahead, behind  (crank, gearbox) free rotation of the output in either direction from its
                   position without gaps, rad, with all clearances. Their sum is the play. It is
                   zero where discs push against each other; one of the two is then negative.
    torque         (torque,) N m, of either sign
    rotation       (torque, crank, gearbox) of the output under the torque, rad, with its sign and
                   all clearances; at least the free rotation
    jammed         (gearbox,) whether flanks interfere at every crank angle by more than all
                   clearances
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


def simulate(
    drive: Drive,
    scatter: DimensionScatter,
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
    if preloaded.any() and len(torque):
        # a gearbox is rarely preloaded at every crank angle
        effects = ClearanceEffects(
            *(each[:, preloaded][..., None] for each in (-last, first, free + uneven))
        )
        rest, turned = preloaded_discs(
            drive,
            torque,
            crank,
            gap[:, preloaded][:, :, None],
            effects,
            places=np.nonzero(preloaded)[0],
            threads=threads,
        )
        rotation[:, preloaded] = turned[..., 0]
        ahead[preloaded], behind[preloaded] = rest[1, :, 0], -rest[0, :, 0]
    return SimulatedGearboxes(ahead, behind, torque, rotation, jammed)


def _lost_rotation(drive: Drive, scatter: DimensionScatter, gearboxes: int, seed: int) -> Floats:
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
            np.linalg.norm(bores(drive, scatter, disc, gearboxes, seed)[2], axis=-1).max(axis=1)
            for disc in range(drive.discs)
        ]
    )
    return np.asarray(
        play_per_crank_clearance(drive) * (half - np.sqrt(np.maximum(half**2 - off**2, 0.0)))
    )


def _output_pins(
    drive: Drive, scatter: DimensionScatter, crank: Floats, gearboxes: int, seed: int
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
        found, _ = rotations(drive, sign * loads[1:], turned, gap[disc], threads=threads)
        alone[disc, 1:] = sign * found
        # Interfering flanks push each other apart without torque.
        alone[disc, 0] = np.minimum(start[disc], alone[disc, 1])
    points = alone.reshape(-1, *alone.shape[2:])
    sums = np.asarray(sum(carried_torque(each, loads[:, None, None], points) for each in alone))
    return np.stack([crossing(points, sums, sums < whole, whole) for whole in wanted])
