"""Simulated gearboxes of one drawing: their play, and the wind-up of the members with scatter."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid import contact, drive
from lostmotion.laws.cycloid.simulated import simulate
from lostmotion.laws.cycloid.tolerances import sample_dimension
from lostmotion.parts.gearbox.cycloidal.frame import GearboxFrame
from lostmotion.parts.gearbox.cycloidal.names import (
    FRAME_SCREWS,
)

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.simulated import SimulatedGearboxes
    from lostmotion.laws.cycloid.tolerances import DimensionScatter
    from lostmotion.parts.gearbox.cycloidal.drawing import CycloidalDrawing
    from lostmotion.parts.gearbox.cycloidal.stage import CycloidalStage
    from lostmotion.spatial import Floats

GEARBOXES: Final = 256
SEED: Final = 1
# For the contacts of simulated gearboxes; figures do not depend on it.
_THREADS: Final = 4


@dataclass(frozen=True, slots=True)
class Samples:
    """Simulated gearboxes of one drawing: play (gearbox,), signed wind_up (torque, gearbox) beyond
    it, rad; jammed: share with interfering flanks.

    The wind-up is that of the members with scatter: flanks, discs, eccentrics of all stages.
    """

    play: Floats
    wind_up: Floats
    jammed: float


def gearboxes(
    gearbox: CycloidalDrawing, torque: Floats, angles: int, count: int, seed: int = SEED
) -> Samples:
    """Return `count` simulated gearboxes of this drawing at torques (torque,) of either sign at the
    output, averaged over `angles` crank angles.
    """
    share, steps = disc_share(gearbox), abs(gearbox.steps)
    sign = np.sign(torque)[:, None]
    main = simulated(gearbox, share * torque, angles, count, seed)
    play, jammed = share * main.play, main.jammed
    turned = share * _beyond(main, sign)
    first = gearbox.first_stage
    if first is not None and first.kind == "cycloidal":
        before = simulated(first, torque / steps, angles, count, seed + 1)
        play, jammed = play + before.play / steps, jammed | before.jammed
        turned = turned + _beyond(before, sign) / steps
    elif first is not None:
        play = play + sample_dimension(first.play, "first stage play", seed, count) / (
            first.sun_radius * abs(gearbox.ratio)
        )
    if (
        isinstance(gearbox.frame, GearboxFrame)
        and gearbox.frame.screws is not None
        and FRAME_SCREWS not in gearbox.rigid
    ):
        play = play + gearbox.frame.screws.play
    return Samples(play, turned, float(jammed.mean()))


def simulated(
    stage: CycloidalStage, torque: Floats, angles: int, count: int, seed: int
) -> SimulatedGearboxes:
    """Return `count` simulated stages under torques (torque,), N m on its discs, at evenly spaced
    crank angles of one turn.

    They are computed once for all stages that differ only in the stiffness of output pins, frame
    and other members outside of the contacts; without torques, for all that differ only in
    stiffness.
    """
    output = stage.drive.output
    contacts = (
        stage.drive
        if output is None
        else replace(stage.drive, output=replace(output, stiffness=math.inf))
    )
    if not len(torque):
        cranks = drive.EccentricSprings(
            cranks=contacts.eccentric.cranks, circle=contacts.eccentric.circle
        )
        contacts = replace(
            contacts,
            flanks=contact.Flanks(width=1.0, modulus=1.0),
            eccentric=cranks,
            disc_body=None,
            ring_body=None,
        )
    return _simulated(
        contacts,
        stage.scatter,
        np.ascontiguousarray(torque, dtype=float).tobytes(),
        angles,
        count,
        seed,
    )


@functools.lru_cache(maxsize=32)
def _simulated(
    contacts: drive.Drive,
    scatter: DimensionScatter,
    torque: bytes,
    angles: int,
    count: int,
    seed: int,
) -> SimulatedGearboxes:
    crank = 2 * math.pi * np.arange(angles) / angles
    return simulate(contacts, scatter, np.frombuffer(torque), crank, count, seed, threads=_THREADS)


def _beyond(made: SimulatedGearboxes, sign: Floats) -> Floats:
    """Return the signed wind-up of a stage beyond its play (torque, gearbox), averaged over the
    crank.
    """
    ahead, behind = made.ends
    return np.asarray((made.rotation - np.where(sign[:, None] > 0, ahead, behind)).mean(axis=1))


def disc_share(gearbox: CycloidalDrawing) -> float:
    """Return the disc's torque and rotation per those of the output: one, or with the ring as
    output the ratio of the pitch radii.
    """
    stage = gearbox.stage
    return 1.0 if gearbox.fixed == "ring" else stage.planet_pitch_radius / stage.ring_pitch_radius
