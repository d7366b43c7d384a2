"""Elastic bodies of a cycloidal stage, the disc on its hub and the ring in its housing: how far a
force at one contact moves the others.

`cycloid.contact` solves contacts and bodies together. The approach by Johnson's law includes each
body down to the depth d = 2 Req exp((1 + nu')/2 -
1) under the contact (1.5 Req for steel in plane strain; nu' = nu/(1 - nu), in plane stress nu). The
   rest of each body is modelled here, plane, fixed at the hub or in the housing and loaded along
   the lines of action of the contacts. Assumptions:

- A disc with lobes and a ring with envelope lobes have their exact profile (`lobed_wheel`). Other
  bodies are annuli: a force is moved along its line of action to the point where that line crosses
  the rim, so its moment is exact.
- The wavy rim of a ring around planet pins is replaced by a circle of its mean radius, because its
  lobes are low compared with
  their length. A force is distributed there as a half-ellipse over +-w, a quarter of a lobe pitch:
  the width of one tooth.
- At a wavy rim every part of the body is included once. In a half-plane under a point load, the
  path from the depth d to a far depth D contributes p/(pi E') 2 ln(D/d). A half-ellipse of load
  inclined by the slant s from the normal has the mean displacement p/(pi E') [2 ln(2 D/w) + 1/2 -
  (1 + nu') cos^2 s] relative to the same point. The real flank is normal to its force, the rim of
  the annulus is not, and Flamant's stresses depend on the direction of the force alone. So both
  agree at w* = 4 Req exp(-3/4 + (1 + nu') sin^2(s)/2). For another w the correction is p/(pi E') 2
  ln(w/w*), of either sign. The sum is valid even for a concave flank where d exceeds the body.
- A lobe or pin on the rim is part of a round bar: a force through its centre compresses it, down to
  the centre, by p/(pi E') [2 ln(4 Rr/a) - 1] (Johnson, section 5.6). The law of the contact uses
  Req instead of Rr, so 2 ln(Rr/Req) p/(pi E') is added. The root of the lobe then loads the rim
  over its whole width, +-Rr, with the stress of a square inner corner at its ends (`CORNERED`). The
  force passes through the centre of the root, so no moment bends the lobe, and its shear is
  included above. Plain arcs whose roots lie outside the circle of their centres have a stem, a
  cantilever. `contact.lobe_compliance` includes the same lobe: `Flanks.bending` must be zero
  together with the body of the ring.
- Pins are treated as integral with the body around their half-round seats. A loose seat is a
  further contact and is not included.

Holes for output pins or the bearings of crankshafts, which then support the disc, are computed on a
round disc (`perforated_disc`).
Compared with finite elements of a solid steel stage in the tests and in docs/theory/cycloid.md.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.annulus import CORNERED, ELLIPTIC, Annulus, Plane
from lostmotion.laws.annulus import flexibility as edge_flexibility
from lostmotion.laws.cycloid.envelope import second_radius
from lostmotion.laws.cycloid.geometry import contact_radius, flank, normals, pin_angles
from lostmotion.laws.cycloid.lobed_wheel import contact_flexibility
from lostmotion.laws.perforated_disc import RimLoads, check_holes, response

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.stage import Part, Stage
    from lostmotion.laws.perforated_disc import DiscResponse
    from lostmotion.laws.perforated_disc_series import Holes
    from lostmotion.spatial import Floats

# Smallest hub, over the radius of the rim, of a disc with its exact flank.
_SMALLEST_HUB: Final = 0.15
# Positions of the holes within a pitch of these, over which the response is averaged: with pins,
# and with bearings, whose forces turn with the crank.
_POSITIONS: Final = {False: 2, True: 4}


@dataclass(frozen=True, slots=True)
class ElasticBody:
    """The elastic body of the planet (disc) or of the ring.

    part       "planet" or "ring"
    edge       radius of its fixed edge, m: within it a planet is rigid (hub, or seat of the
               eccentric's bearing); there a ring is fixed to its rigid housing all round
    young, nu  Young's modulus, Pa, and Poisson's ratio
    holes      in a disc. With output pins, which take its torque, its edge is the bore, a rigid hub
               without friction, which takes the force; with bearings of crankshafts, which take
               both, its edge is free, and displacements are relative to the mean motion of the
               bearings
    plane      as of `Annulus`; use the same plane for the modulus of the contacts
    """

    part: Part
    edge: float
    young: float
    nu: float
    holes: Holes | None = None
    plane: Plane = "strain"


def check_body(stage: Stage, body: ElasticBody) -> None:
    """Raise ValueError for a fixed edge that cuts the teeth or the seats of pins, and for holes
    that overlap or cut an edge, without a solution.
    """
    whole = Annulus(
        _rim(stage, body.part),
        _fixed_radius(stage, body.part, body.edge),
        1.0,
        1.0,
        body.nu,
        body.plane,
    )
    if body.holes is not None:
        check_holes(
            whole
            if stage.has_planet_pins
            else replace(whole, loaded=_rim_over_holes(stage, whole, body.holes)),
            body.holes,
        )


def flexibility(stage: Stage, body: ElasticBody, width: float, crank: Floats) -> Floats:
    """Return the displacements (m/N) of a body along contact i under a unit force at contact j:
    (side, crank, N, N), each matrix symmetric.

    width  of the body, m; with more than one disc the share of the ring's width per disc
    crank  (crank,) crank angles, rad

    Under forward (0) and backward torques (1), which load different holes. This is the part that
    the approach by Johnson's law does not include; for a concave flank that law includes too much,
    so the diagonal can be negative. With holes it is the mean over positions of these, two with
    pins (on the line of centres and half a pitch away), four with bearings. Computed once per
    drawing and position of the lobes, for any modulus and width. Raises ValueError for a fixed edge
    that cuts the teeth or the seats of pins and for holes that overlap or cut an edge,
    DidNotConvergeError for very thin webs.
    """
    pitch = 2 * math.pi / (stage.lobes if stage.has_planet_pins else stage.pins)
    out = np.empty((2, len(crank), stage.pins, stage.pins))
    for k, angle in enumerate(np.asarray(crank, dtype=float).tolist()):
        turns = math.floor(angle / pitch + 1e-9)
        # rounded, so that equal positions of the lobes are found again
        each = _unit_flexibility(
            stage, replace(body, young=1.0), round(angle - turns * pitch, 12) + 0.0, ()
        )
        out[:, k] = np.roll(each, (turns, turns), axis=(1, 2))
    return out / (body.young * width)


def flexibility_with_second(
    stage: Stage, body: ElasticBody, width: float, crank: float, second: Floats
) -> Floats:
    """Return `flexibility` (side, contact, contact) of an envelope stage at one crank angle (rad)
    at contacts of both branches.

    second  parameters (contact,) of the disc's flank at contacts of the second branch, rad, which
            follow the N of the first branch
    """
    return _unit_flexibility(stage, replace(body, young=1.0), crank, tuple(second.tolist())) / (
        body.young * width
    )


@functools.lru_cache(maxsize=512)
def _unit_flexibility(
    stage: Stage, unit: ElasticBody, crank: float, second: tuple[float, ...]
) -> Floats:
    """Return `flexibility` for one crank angle, width and modulus one, at the contacts of the first
    branch and of the second one (rad).
    """
    part, holes = unit.part, unit.holes
    body = Annulus(
        _rim(stage, part), _fixed_radius(stage, part, unit.edge), 1.0, 1.0, unit.nu, unit.plane
    )
    others = np.array(second)
    size = (2, stage.pins + len(second), stage.pins + len(second))
    if part == "ring" and stage.kind == "lobe envelope":
        return np.asarray(
            np.broadcast_to(contact_flexibility(stage, body, crank, part, others), size)
        )
    lines = _lines_of_action(stage, part, body, crank, others)
    if part == "ring" or stage.has_planet_pins:
        whole = (
            _edge_flexibility(body, lines)
            if holes is None
            else _response(stage, body, holes).flexibility(lines.rim)
        ) + np.diag(lines.rest)
        return np.asarray(np.broadcast_to(whole, size))
    # Except near the flank and over the holes, these and a smaller hub change a disc with lobes as
    # they change a round one.
    hub = replace(body, fixed=max(unit.edge, _SMALLEST_HUB * body.loaded))
    whole = contact_flexibility(stage, hub, crank, part, others)
    if holes is not None:
        body = replace(body, loaded=_rim_over_holes(stage, body, holes))
        lines = _lines_of_action(stage, part, body, crank, others)
        whole = (
            whole
            + _response(stage, body, holes).flexibility(lines.rim)
            - _edge_flexibility(replace(body, fixed=hub.fixed), lines)
        )
    elif hub != body:
        whole = whole + _edge_flexibility(body, lines) - _edge_flexibility(hub, lines)
    return np.asarray(np.broadcast_to(whole, size))


def _rim_over_holes(stage: Stage, body: Annulus, holes: Holes) -> float:
    """Return the radius (m) of the round rim whose webs over the holes bend as those below the wavy
    flank: with the same mean of 1/thickness^3.

    The thickness below the flank is taken as t + e cos(angle). Raises ValueError for holes that
    reach the valleys.
    """
    web = body.loaded - holes.circle - holes.radius
    depth = stage.eccentricity / web
    if not 0 < depth < 1:
        raise ValueError("this disc cannot exist: the holes cut the rim")
    return float(
        body.loaded - web + web * (1 - depth**2) ** (5 / 6) / (1 + depth**2 / 2) ** (1 / 3)
    )


def _edge_flexibility(body: Annulus, lines: _LinesOfAction) -> Floats:
    return edge_flexibility(
        body, lines.rim.angle, lines.rim.slant, lines.rim.half, lines.rim.exponent
    )


@functools.lru_cache(maxsize=16)
def _response(stage: Stage, body: Annulus, holes: Holes) -> DiscResponse:
    """Return the response of a disc with holes, in evenly spaced positions of these: the first one
    on the line of centres.
    """
    number = _POSITIONS[holes.bearings]
    lines = 2 * math.pi / holes.count * np.arange(number) / number
    return response(
        body,
        holes,
        _lines_of_action(stage, "planet", body, 0.0, np.zeros(0)).rim,
        lines,
        "free" if holes.bearings else "sliding",
    )


def _pinned(stage: Stage, part: Part) -> bool:
    """Return whether this part has the pins or round lobes. The rim of the other part is wavy."""
    return stage.kind != "lobe envelope" and (part == "planet") == stage.has_planet_pins


def _rim(stage: Stage, part: Part) -> float:
    """Return the radius (m) of the loaded edge of the annulus: pin circle, roots of lobes outside
    it, or the mean of tips and valleys.
    """
    if _pinned(stage, part):
        return (
            max(stage.ring_radius, stage.tip_radius + stage.eccentricity)
            if stage.kind == "lobe arcs"
            else stage.ring_radius
        )
    if part == "ring" and not stage.has_planet_pins:
        # crests at R - Rr, roots 2 e farther out
        return stage.ring_radius - stage.pin_radius + stage.eccentricity
    return stage.ring_radius + (stage.pin_radius if stage.has_planet_pins else -stage.pin_radius)


@dataclass(frozen=True, slots=True)
class _LinesOfAction:
    """Where the contacts' lines of action cross the rim of a body.

    rim   place, inclination and distribution of each force
    rest  (contact,) approach per force (m/N) between the depth that the law of the contact includes
          and the distributed load
    """

    rim: RimLoads
    rest: Floats


def _lines_of_action(
    stage: Stage, part: Part, body: Annulus, crank: float, second: Floats
) -> _LinesOfAction:
    """Return the lines of action of all contacts of the first branch, then of the second one of an
    envelope stage, whose rim here is the disc's.
    """
    pinned = _pinned(stage, part)
    theta = pin_angles(stage, np.array([crank]))[0]
    along = normals(stage, theta) @ np.array([1, 1j])
    # the planet's centre is at e along the line of centres from the ring's; pin angles are about
    # the pin circle's centre
    centre = (
        (-stage.eccentricity if part == "ring" else 0.0)
        if stage.has_planet_pins
        else (stage.eccentricity if part == "planet" else 0.0)
    )
    pin = stage.ring_radius * np.exp(1j * theta) - centre
    of_second, away = (
        each @ np.array([1, 1j]) * np.exp(-1j * crank * (1 + 1 / stage.lobes))
        for each in flank(stage, second)
    )
    pin, along = np.append(pin, of_second), np.append(along, away)
    foot = (pin * along.conj()).imag  # signed distance of the line of action from the part's centre
    if (np.abs(foot) >= body.loaded).any():
        raise ValueError(
            "a contact's line of action does not cross the rim: this stage is too far from "
            "round to be modelled by annuli"
        )
    place = along * (np.sqrt(body.loaded**2 - foot**2) + 1j * foot)
    slant = np.angle(along / place)
    reach = np.append(contact_radius(stage, theta), second_radius(stage, second))
    if pinned:
        half, shape = math.asin(stage.pin_radius / body.loaded), CORNERED
        share = stage.pin_radius / reach
    else:
        half, shape = math.pi / (2 * stage.lobes), ELLIPTIC
        share = (
            half
            * body.loaded
            / (4 * reach * np.exp(-0.75 + (1 + body.plane_nu) / 2 * np.sin(slant) ** 2))
        )
    rest = 2 * np.log(share) / (math.pi * body.plane_modulus * body.width)
    if pinned:
        rest = rest + _stem(stage, body, np.angle(along / pin))
    return _LinesOfAction(RimLoads(np.angle(place), slant, half, shape), rest)


def _stem(stage: Stage, body: Annulus, lean: Floats) -> Floats:
    """Return the deflection per force (m/N) of a lobe's stem between its centre and its root, as a
    cantilever; zero where it has none.

    lean  (N,) of the force from the lobe's axis, rad
    """
    height, root = max(body.loaded - stage.ring_radius, 0.0), 2 * stage.pin_radius
    shear = body.young / (2 + 2 * body.nu)
    across = 4 * height**3 / (body.plane_modulus * root**3) + 6 * height / (5 * shear * root)
    return np.asarray(
        (np.cos(lean) ** 2 * height / (body.plane_modulus * root) + np.sin(lean) ** 2 * across)
        / body.width
    )


def ring_reach(stage: Stage) -> float:
    """Return the outermost radius (m) of the ring's teeth or of the seats of its pins; the outer
    radius of the ring must be larger.

    It is R + Rr for pins and R + Rr + e for planet pins. Integral lobes have no seats: their roots
    are at R - Rr + 2 e, where the disc's tips reach, and those of plain arcs extend at least to the
    circle of their centres, R.
    """
    rim = _rim(stage, "ring")
    if stage.kind == "ring pins":
        return rim + stage.pin_radius
    root = stage.tip_radius + stage.eccentricity
    return max(rim, root)


def _fixed_radius(stage: Stage, part: Part, radius: float) -> float:
    """Return the radius (m) of the fixed edge. Raises ValueError for one that cuts the profile or
    the seats of pins.
    """
    if part == "planet":
        end = _rim(stage, part) - (
            stage.pin_radius if stage.has_planet_pins else stage.eccentricity
        )
        if radius >= end:
            raise ValueError(
                f"the hub's radius is {radius * 1e3:g} mm, but teeth or seats reach in to "
                f"{end * 1e3:g} mm: choose a smaller hub"
            )
    else:
        end = ring_reach(stage)
        if radius <= end:
            raise ValueError(
                f"the ring's outer radius is {radius * 1e3:g} mm, but teeth or seats reach out "
                f"to {end * 1e3:g} mm: choose a larger one"
            )
    return radius
