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
    play_per_crank_clearance,
)
from lostmotion.laws.cycloid.geometry import (
    arms,
    gaps,
    gaps_from_pins,
    normals,
    pin_angles,
)
from lostmotion.laws.distributions import Normal, of_tolerance
from lostmotion.units import Toleranced

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.drive import Drive
    from lostmotion.laws.distributions import Law
    from lostmotion.spatial import Floats

_NONE: Final = Toleranced(0.0)


@dataclass(frozen=True, slots=True)
class DimensionScatter:
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


def sample_gaps(
    drive: Drive, scatter: DimensionScatter, crank: Floats, gearboxes: int, seed: int
) -> Floats:
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
        moved, turned, _ = bores(drive, scatter, disc, gearboxes, seed)
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


def clearance_angle(drive: Drive, scatter: DimensionScatter, gearboxes: int, seed: int) -> Floats:
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


def bores(
    drive: Drive, scatter: DimensionScatter, disc: int, gearboxes: int, seed: int
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
