"""Elastic bodies of a cycloidal stage: the disc on its hub and the ring in its housing, as springs at the output.

`cycloid.contact` computes the equilibrium of a rigid disc on its contacts. The approach by Johnson's law includes each body down to the depth d = 2
Req exp((1 + nu')/2 - 1) under the contact (1.5 Req for steel in plane strain; nu' = nu/(1 - nu), in plane stress nu). The rest of each body is
modelled here as a plane annulus (`annulus`), fixed at the hub or in the housing and loaded along the lines of action of the contacts. Assumptions:

- Each force is moved along its line of action to the point where that line crosses the rim of the annulus, so its moment is exact.
- A wavy rim (of the disc; of the ring with envelope lobes or planet pins) is replaced by a circle of its mean radius, because its lobes are low
  compared with their length. A force is distributed there as a half-ellipse over +-w, a quarter of a lobe pitch: the width of one tooth.
- At a wavy rim every part of the body is included once. In a half-plane under a point load, the path from the depth d to a far depth D contributes
  p/(pi E') 2 ln(D/d). A half-ellipse of load inclined by the slant s from the normal has the mean displacement p/(pi E') [2 ln(2 D/w) + 1/2 - (1 +
  nu') cos^2 s] relative to the same point. The real flank is normal to its force, the rim of the annulus is not, and Flamant's stresses depend on the
  direction of the force alone. So both agree at w* = 4 Req exp(-3/4 + (1 + nu') sin^2(s)/2). For another w the correction is p/(pi E') 2 ln(w/w*), of
  either sign. The sum is valid even for a concave flank where d exceeds the body.
- A lobe or pin on the rim is part of a round bar: a force through its centre compresses it, down to the centre, by p/(pi E') [2 ln(4 Rr/a) - 1]
  (Johnson, section 5.6). The law of the contact uses Req instead of Rr, so 2 ln(Rr/Req) p/(pi E') is added. The root of the lobe then loads the rim
  over its whole width, +-Rr, with the stress of a square inner corner at its ends (`CORNERED`). The force passes through the centre of the root, so
  no moment bends the lobe, and its shear is included above. `contact.lobe_compliance` includes the same lobe: `Flanks.bending` must be zero together
  with `ring_body`.
- Pins are treated as integral with the body around their half-round seats. A loose seat is a further contact and is not included.

Holes for output pins make the disc softer by a third to twofold: `disc_with_holes`, a plane disc with its holes, takes the place of its annulus.
Compared with finite elements of a solid steel stage in the tests and in docs/theory/cycloid.md.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from lostmotion.laws.annulus import CORNERED, ELLIPTIC, Annulus, Plane, flexibility
from lostmotion.laws.cycloid.geometry import arms, contact_radius, normals, pin_angles
from lostmotion.laws.perforated_disc import RimLoads, wind_up_per_torque

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.geometry import Stage
    from lostmotion.laws.perforated_disc import Holes
    from lostmotion.spatial import Floats


def disc_body(  # noqa: PLR0913, PLR0917 - geometry, material, load
    stage: Stage, hub_radius: float, width: float, young: float, nu: float, forces: Floats | None = None, crank: float = 0.0, plane: Plane = "strain"
) -> float:
    """Return the rotation of the output per torque on a disc (rad/(N m)) from the disc's body (with planet pins: the planet's).

    hub_radius  within it the disc is rigid, m: bearing seat, or the circle of the inner edges of its output holes
    width       of the disc, m
    young, nu   Young's modulus, Pa, and Poisson's ratio
    forces      (N,) on the lobes at this crank angle, N, such as `LoadSharing.forces[i, j, k]`; by default F_i = T l_i/sum(l^2), which averaged over
                a turn is F_max l_i/(e z)
    crank       crank angle, rad
    plane       as of `Annulus`; use the same plane for the modulus of the contacts

    The result times the disc's torque is to be added to `LoadSharing.rotation`. By virtual work it is F' A F/T^2. Raises ValueError for a hub that
    cuts the teeth or the seats of pins, for forces of another shape, negative or not finite, and for forces without moment.
    """
    return _turn_per_torque(stage, disc_flexibility(stage, hub_radius, width, young, nu, crank, plane), forces, crank)


@functools.lru_cache(maxsize=64)
def disc_with_holes(stage: Stage, bore_radius: float, holes: Holes, width: float, young: float, nu: float, plane: Plane = "strain") -> float:
    """Return the rotation of the output per torque on a disc (rad/(N m)) from a disc with holes, in which output pins take its torque.

    bore_radius  of the seat of the eccentric's bearing, m: it takes the force, as a rigid hub without friction
    holes        for the output pins

    Forces are those of equal springs, as in `disc_body`; mean of two positions of the holes, on the line of centres and half a pitch away. Other
    arguments as `disc_body`. Raises ValueError for holes that overlap or cut an edge, DidNotConvergeError for very thin webs.
    """
    body = Annulus(_rim(stage, "planet"), _fixed_radius(stage, "planet", bore_radius), width, young, nu, plane)
    lines = _lines_of_action(stage, "planet", body, 0.0)
    arm = arms(stage, pin_angles(stage, np.zeros(1))[0])
    force = np.maximum(arm, 0.0)
    rim = RimLoads(force, lines.angle, lines.slant, lines.half, lines.exponent)
    of_body = wind_up_per_torque(body, holes, rim, np.array([0.0, math.pi / holes.count]), "sliding")
    return float(of_body.mean()) + float(force**2 @ lines.rest) / float(force @ arm) ** 2


def ring_body(  # noqa: PLR0913, PLR0917 - geometry, material, load
    stage: Stage,
    outer_radius: float,
    width: float,
    young: float,
    nu: float,
    forces: Floats | None = None,
    crank: float = 0.0,
    plane: Plane = "strain",
) -> float:
    """Return the rotation of the output per torque on a disc (rad/(N m)) from the ring's body and its lobes.

    `outer_radius` (m): there the ring is fixed to the rigid housing all round. Other arguments and errors as `disc_body`. With more than one disc
    `width` is the share of the ring's width per disc.
    """
    return _turn_per_torque(stage, ring_flexibility(stage, outer_radius, width, young, nu, crank, plane), forces, crank)


def disc_flexibility(stage: Stage, hub_radius: float, width: float, young: float, nu: float, crank: float = 0.0, plane: Plane = "strain") -> Floats:
    """Return the displacements (m/N) of the disc's body along contact i under a unit force at contact j: (N, N), symmetric, with a fixed hub.

    This is the part that the approach by Johnson's law does not include. For a concave flank that law includes too much, so the diagonal can be
    negative. Arguments as `disc_body`.
    """
    return _flexibility(stage, "planet", Annulus(_rim(stage, "planet"), _fixed_radius(stage, "planet", hub_radius), width, young, nu, plane), crank)


def ring_flexibility(stage: Stage, outer_radius: float, width: float, young: float, nu: float, crank: float = 0.0, plane: Plane = "strain") -> Floats:
    """Return the displacements (m/N) of the ring's body and lobes along contact i under a unit force at contact j: (N, N), as `disc_flexibility`."""
    return _flexibility(stage, "ring", Annulus(_rim(stage, "ring"), _fixed_radius(stage, "ring", outer_radius), width, young, nu, plane), crank)


def _pinned(stage: Stage, part: Literal["planet", "ring"]) -> bool:
    """Return whether this part has the pins or round lobes. The rim of the other part is wavy, and so is that of an envelope ring."""
    return stage.kind != "lobe envelope" and (part == "planet") == stage.has_planet_pins


def _rim(stage: Stage, part: Literal["planet", "ring"]) -> float:
    """Return the radius (m) of the loaded edge of the annulus: the pin circle, or the mean of tips and valleys of a wavy rim."""
    if _pinned(stage, part):
        return stage.ring_radius
    if part == "ring" and not stage.has_planet_pins:
        return stage.ring_radius - stage.pin_radius + stage.eccentricity  # crests at R - Rr, roots 2 e farther out
    return stage.ring_radius + (stage.pin_radius if stage.has_planet_pins else -stage.pin_radius)


def _flexibility(stage: Stage, part: Literal["planet", "ring"], body: Annulus, crank: float) -> Floats:
    lines = _lines_of_action(stage, part, body, crank)
    return flexibility(body, lines.angle, lines.slant, lines.half, lines.exponent) + np.diag(lines.rest)


@dataclass(frozen=True, slots=True)
class _LinesOfAction:
    """Where the contacts' lines of action cross the rim of a body.

    angle, slant    (N,) place and inclination from the outward radius, rad
    half, exponent  half arc (rad) and shape of the distribution of each force
    rest            (N,) approach per force (m/N) between the depth that the law of the contact includes and the distributed load
    """

    angle: Floats
    slant: Floats
    half: float
    exponent: float
    rest: Floats


def _lines_of_action(stage: Stage, part: Literal["planet", "ring"], body: Annulus, crank: float) -> _LinesOfAction:
    pinned = _pinned(stage, part)
    theta = pin_angles(stage, np.array([crank]))[0]
    along = normals(stage, theta) @ np.array([1, 1j])
    # the planet's centre is at e along the line of centres from the ring's; pin angles are about the pin circle's centre
    centre = (-stage.eccentricity if part == "ring" else 0.0) if stage.has_planet_pins else (stage.eccentricity if part == "planet" else 0.0)
    pin = stage.ring_radius * np.exp(1j * theta) - centre
    foot = (pin * along.conj()).imag  # signed distance of the line of action from the part's centre
    if (np.abs(foot) >= body.loaded).any():
        raise ValueError("a contact's line of action does not cross the rim: this stage is too far from round to be modelled by annuli")
    place = along * (np.sqrt(body.loaded**2 - foot**2) + 1j * foot)
    slant = np.angle(along / place)
    reach = contact_radius(stage, theta)
    if pinned:
        half, shape = math.asin(stage.pin_radius / body.loaded), CORNERED
        share = stage.pin_radius / reach
    else:
        lobes = stage.pins if stage.kind == "lobe envelope" and part == "ring" else stage.lobes
        half, shape = math.pi / (2 * lobes), ELLIPTIC
        share = half * body.loaded / (4 * reach * np.exp(-0.75 + (1 + body.plane_nu) / 2 * np.sin(slant) ** 2))
    rest = 2 * np.log(share) / (math.pi * body.plane_modulus * body.width)
    return _LinesOfAction(np.angle(place), slant, half, shape, rest)


def ring_reach(stage: Stage) -> float:
    """Return the outermost radius (m) of the ring's teeth or of the seats of its pins; the outer radius of the ring must be larger.

    It is R + Rr for pins and R + Rr + e for planet pins. Integral lobes have no seats: their roots are at R - Rr + 2 e, where the disc's tips reach,
    and those of plain arcs extend at least to the circle of their centres, R.
    """
    rim = _rim(stage, "ring")
    if stage.kind == "ring pins":
        return rim + stage.pin_radius
    root = stage.tip_radius + stage.eccentricity
    return max(rim, root)


def _fixed_radius(stage: Stage, part: Literal["planet", "ring"], radius: float) -> float:
    """Return the radius (m) of the fixed edge. Raises ValueError for one that cuts the profile or the seats of pins."""
    if part == "planet":
        end = _rim(stage, part) - (stage.pin_radius if stage.has_planet_pins else stage.eccentricity)
        if radius >= end:
            raise ValueError(f"the hub's radius is {radius * 1e3:g} mm, but teeth or seats reach in to {end * 1e3:g} mm: choose a smaller hub")
    else:
        end = ring_reach(stage)
        if radius <= end:
            raise ValueError(f"the ring's outer radius is {radius * 1e3:g} mm, but teeth or seats reach out to {end * 1e3:g} mm: choose a larger one")
    return radius


def _turn_per_torque(stage: Stage, flexible: Floats, forces: Floats | None, crank: float) -> float:
    arm = arms(stage, pin_angles(stage, np.array([crank]))[0])
    force = np.maximum(arm, 0.0) if forces is None else np.asarray(forces, dtype=float)
    if force.shape != arm.shape:
        raise ValueError(f"forces are needed for each of the {stage.pins} pins or lobes at one crank angle, not of shape {force.shape}")
    if not (np.isfinite(force).all() and (force >= 0).all()):
        raise ValueError("forces must be finite, and zero or more: a contact can only push")
    torque = float(force @ arm)
    if abs(torque) <= 1e-9 * float(force.sum()) * stage.planet_pitch_radius:  # rounding
        raise ValueError("these forces have no moment about the planet's centre")
    return float(force @ flexible @ force) / torque**2
