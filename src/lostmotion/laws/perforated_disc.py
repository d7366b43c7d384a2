"""Deformation of a plane disc with a central bore and a circle of round holes, loaded at its rim
and at the holes.

Kolosov's two functions are expanded in powers of z and in inverse powers about the centre of every
hole, with logarithms for the resultant forces; the coefficients follow from the boundary conditions
at points of all edges, by least squares. The series converge geometrically with the number of
terms: the figures are accurate to 0.6 % where the conditions are met to 2 %, which is checked, with
webs of a tenth of a hole's diameter between holes with bearings and a free bore to 1.2 %. Webs of a
twentieth of a hole's diameter are resolved, those of a hundredth are not.

Source: N. Muskhelishvili, Some Basic Problems of the Mathematical Theory of Elasticity, 1953,
sections 35 to 41 (multiply connected bodies).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.annulus import ELLIPTIC, Annulus, spectrum
from lostmotion.laws.perforated_disc_series import (
    Bore,
    DiscEdge,
    Holes,
    edge_conditions,
    edges_of,
    least_squares,
)

if TYPE_CHECKING:
    import numpy.typing as npt

    from lostmotion.spatial import Floats

    Complexes = npt.NDArray[np.complex128]

# Thickness of a web, over the diameter of the holes, below which the series resolve no disc.
LEAST_WEB: Final = 0.01

# Attempts: terms about each hole and at least about the bore, terms about the bore per length of
# its edge over those about a hole, and harmonics of the load on the rim times its half arc (rad).
# The later ones are for thin webs.
_ATTEMPTS: Final = ((16, 0.0, 5), (28, 0.0, 10), (28, 1.0, 10))
# Largest number of terms about the bore.
_MOST: Final = 200
# Largest root-mean-square error of the boundary conditions, over that of the loads.
_RESIDUAL: Final = 0.02


class UnresolvedWebsError(DidNotConvergeError):
    """The webs of a disc between its holes and edges are too thin for the series."""


@dataclass(frozen=True, slots=True)
class RimLoads:
    """Places of forces that push on the rim.

    angle    (force,) position from the line of centres, rad
    slant    (force,) inclination of the line of action from the radius, rad: the force points
             inwards, against the direction angle + slant
    half     half arc over which each is distributed as (1 - x^2)^exponent, rad
    """

    angle: Floats
    slant: Floats
    half: float
    exponent: float = ELLIPTIC

    @property
    def arm(self) -> Floats:
        """Return the lever arm of each force about the centre (force,), over the radius of the
        rim.
        """
        return -np.sin(self.slant)


@dataclass(frozen=True, slots=True)
class DiscResponse:
    """Response of a disc with holes to unit loads: work of load i in the displacements of load j,
    m/N, as a symmetric matrix.

    The loads are the real and imaginary parts of each harmonic of the rim's traction, -terms to
    terms; then those of the holes. With pins these are, for each line of centres, the forces that
    balance a unit force times the radius of the rim: on the holes that are loaded where the rim's
    forces have a negative moment, as under a positive torque of a stage, and on the others. With
    bearings: a force on each hole in either direction, linear in the force, and for each line and
    sign of the torque what turns it into a cosine pressure on half of the edge.

    ahead  (line, side, hole) directions of the forces on the holes, for the second kind of loads on
           bearings, as complex numbers
    """

    work: Floats
    terms: int
    lines: Floats
    reach: float
    holes: Holes | None
    ahead: Complexes

    def loads(self, rim: RimLoads, line: int, side: int) -> Floats:
        """Return the unit forces on the rim in terms of the unit loads (force, load), under a
        positive (0) or negative (1) torque of the stage.
        """
        harmonics = _harmonics(rim, float(self.lines[line]), self.terms)
        pins = np.zeros((len(rim.angle), len(self.work) - 2 * harmonics.shape[1]))
        if self.holes is not None and self.holes.bearings:
            each, count = (
                _reactions(self.holes, rim, float(self.lines[line]), self.reach),
                self.holes.count,
            )
            first = 2 * count + (2 * line + side) * count
            pins[:, :count], pins[:, count : 2 * count] = each.real, each.imag
            pins[:, first : first + count] = (each * self.ahead[line, side].conj()).real
        elif self.holes is not None:
            pins[:, 2 * line + side] = rim.arm
        return np.concatenate([harmonics.real, harmonics.imag, pins], axis=1)

    def flexibility(self, rim: RimLoads) -> Floats:
        """Return the displacements (m/N) along force i under a unit force j: (side, force, force),
        mean over the lines of centres.

        Under a positive and a negative torque of the stage. Displacements are relative to a fixed
        bore, or else to the pins, which then do no work.
        """
        out = np.zeros((2, len(rim.angle), len(rim.angle)))
        for side in range(2):
            for line in range(len(self.lines)):
                loads = self.loads(rim, line, side)
                out[side] += loads @ self.work @ loads.T / len(self.lines)
        return np.asarray((out + out.transpose(0, 2, 1)) / 2)


def response(
    disc: Annulus,
    holes: Holes | None,
    rim: RimLoads,
    lines: Floats,
    bore: Bore,
    towards: Literal[-1, 1] = -1,
) -> DiscResponse:
    """Return the response of a disc to forces on its rim, by virtual work.

    disc   loaded at its rim; its fixed radius is that of the bore
    holes  of the output pins; None for a solid disc
    rim    forces along the contacts, at angles from the line of centres
    lines  (line,) angles of the line of centres, towards the disc's centre, from the first hole,
           rad
    bore   "fixed": bonded to a rigid hub, which takes the torque; "sliding": on a frictionless
           rigid hub, while half of the holes take the torque, each by a cosine pressure on half of
           its edge, with forces in proportion to the distance of the holes from the line of
           centres; "free", while the bearings of crankshafts in all holes share force and torque
           equally, each by a cosine pressure on half of its edge towards  direction of the pins'
           push along the line of centres. A hole's centre is ahead of its pin's by the
           eccentricity, so under a positive
             torque the pin pushes against the line (-1), and the loaded holes are those on the side
             of the loaded rim; 1 is the reverse

    Raises ValueError for holes that overlap or cut an edge, and for a sliding or free bore without
    holes of its kind; UnresolvedWebsError where the series do not resolve the webs.
    """
    if holes is not None:
        check_holes(disc, holes)
    if bore == "sliding" and (holes is None or holes.bearings):
        raise ValueError("a disc on a sliding bore needs holes with pins that take its torque")
    if bore == "free" and (holes is None or not holes.bearings):
        raise ValueError("a disc with a free bore needs holes with bearings")
    lines = np.atleast_1d(np.asarray(lines, dtype=float))
    loaded = None if bore == "fixed" else holes
    ahead = (
        np.empty((0, 2, 0), complex)
        if loaded is None or not loaded.bearings
        else _ahead(loaded, rim, lines, disc.loaded)
    )
    for terms, dense, per_arc in _ATTEMPTS:
        of_bore = max(
            terms,
            0
            if holes is None
            else max(
                4 * holes.count, min(math.ceil(dense * terms * disc.fixed / holes.radius), _MOST)
            ),
        )
        edges = edges_of(disc, holes, terms, of_bore, max(24, math.ceil(per_arc / rim.half)))
        loads = _unit_loads(disc, loaded, rim, lines, edges, towards, ahead)
        moved, matrix, wanted = edge_conditions(disc, edges, loads, bore)
        answer = least_squares(matrix, wanted)
        weights = np.concatenate(
            [
                np.full(len(edge.points), 2 * math.pi * edge.radius / len(edge.points))
                for edge in edges
            ]
        )
        work = (
            ((loads.real * weights) @ moved.real + (loads.imag * weights) @ moved.imag)
            @ answer
            * disc.loaded
            * disc.width
        )
        found = DiscResponse(np.asarray(work), edges[0].terms, lines, disc.loaded, loaded, ahead)
        tried = [np.minimum(rim.arm, 0.0) @ found.loads(rim, line, 0) for line in range(len(lines))]
        error = max(
            float(
                np.linalg.norm(matrix @ (answer @ each) - wanted @ each)
                / np.linalg.norm(wanted @ each)
            )
            for each in tried
        )
        if error < _RESIDUAL:
            return found
    around = "" if holes is None else f" around holes with a radius of {holes.radius * 1e3:.4g} mm"
    raise UnresolvedWebsError(
        f"the webs of this disc{around} are too thin for its series: boundary conditions are "
        f"off by {100 * error:.1f} %"
    )


def pin_forces(holes: Holes, torque: float, line: float, towards: Literal[-1, 1] = -1) -> Complexes:
    """Return the forces (hole,), N, of the pins on a disc as complex numbers in its plane; they
    balance a torque (N m) on its rim.

    Arguments as `response`.
    """
    arm = np.sin(2 * math.pi * np.arange(holes.count) / holes.count - line)
    # a force along the line of centres has the moment -circle x arm
    share = np.maximum(math.copysign(1.0, torque) * towards * arm, 0.0)
    return np.asarray(
        towards
        * share
        * abs(torque)
        / (holes.circle * float(share @ np.abs(arm)))
        * np.exp(1j * line)
    )


def _reactions(holes: Holes, rim: RimLoads, line: float, reach: float) -> Complexes:
    """Return the forces (force, hole) of the bearings on a disc under unit forces on its rim of
    this radius (m): equal shares of force and torque.
    """
    push = -np.exp(1j * (rim.angle + rim.slant + line)) * spectrum(np.array(rim.half), rim.exponent)
    return np.asarray(
        -push[:, None] / holes.count
        - (rim.arm * reach / (holes.count * holes.circle))[:, None] * 1j * holes.places
    )


def _ahead(holes: Holes, rim: RimLoads, lines: Floats, reach: float) -> Complexes:
    """Return the directions (line, side, hole) of the bearings' forces on a disc whose contacts
    carry in proportion to their arms.
    """
    sides = np.stack([-np.minimum(rim.arm, 0.0), np.maximum(rim.arm, 0.0)])
    out = np.stack([sides @ _reactions(holes, rim, float(line), reach) for line in lines])
    return np.asarray(out / np.abs(out))


def check_holes(disc: Annulus, holes: Holes) -> None:
    """Raise ValueError for holes that overlap or cut an edge, without a solution."""
    wrong = []
    if holes.circle - holes.radius <= disc.fixed:
        wrong.append("the holes cut the bore")
    if holes.circle + holes.radius >= disc.loaded:
        wrong.append("the holes cut the rim")
    if holes.circle * math.sin(math.pi / holes.count) <= holes.radius:
        wrong.append("the holes overlap")
    if wrong:
        raise ValueError("this disc cannot exist: " + "; ".join(wrong))


def _unit_loads(
    disc: Annulus,
    holes: Holes | None,
    rim: RimLoads,
    lines: Floats,
    edges: list[DiscEdge],
    towards: Literal[-1, 1],
    ahead: Complexes,
) -> Complexes:
    """Return the tractions (load, point), Pa, of the unit loads at the points of all edges; those
    on the `holes` as they are loaded.
    """
    points = edges[0].points
    n = np.arange(-edges[0].terms, edges[0].terms + 1)
    shape = spectrum(np.abs(n) * rim.half, rim.exponent) / (2 * math.pi * disc.loaded * disc.width)
    harmonics = shape[:, None] * points * np.exp(1j * n[:, None] * np.angle(points))
    on_holes = [] if holes is None else _on_holes(disc, holes, lines, edges[1:-1], towards, ahead)
    out = np.zeros(
        (2 * len(harmonics) + len(on_holes), sum(len(edge.points) for edge in edges)), dtype=complex
    )
    (
        out[: len(harmonics), : len(points)],
        out[len(harmonics) : 2 * len(harmonics), : len(points)],
    ) = harmonics, 1j * harmonics
    for row, each in enumerate(on_holes, 2 * len(harmonics)):
        out[row, len(points) : len(points) + len(each)] = each
    return out


def _on_holes(
    disc: Annulus,
    holes: Holes,
    lines: Floats,
    edges: list[DiscEdge],
    towards: Literal[-1, 1],
    ahead: Complexes,
) -> list[Complexes]:
    """Return the tractions (point,) of the unit loads on the holes at the points of all their
    edges.
    """
    out: list[Complexes] = []
    if not holes.bearings:
        for line in lines:
            for sign in (-1.0, 1.0):
                pins = pin_forces(holes, sign * disc.loaded, float(line), towards)
                tractions = [
                    np.sum(_hole_traction(disc, holes, force, edge), axis=0)
                    for force, edge in zip(pins, edges, strict=True)
                ]
                out.append(np.asarray(sign * np.concatenate(tractions)))
        return out
    for part, forces in (
        (0, np.ones((1, holes.count), complex)),
        (0, 1j * np.ones((1, holes.count))),
        (1, ahead.reshape(-1, holes.count)),
    ):
        for row in forces:
            for k, edge in enumerate(edges):
                each = np.zeros((len(edges), len(edge.points)), complex)
                each[k] = _hole_traction(disc, holes, row[k], edge)[part]
                out.append(each.ravel())
    return out


def _harmonics(rim: RimLoads, line: float, terms: int) -> Complexes:
    """Return the harmonics -terms to terms (force, harmonic) of unit forces on the rim, without the
    shape of their distribution.
    """
    n = np.arange(-terms, terms + 1)
    return np.asarray(
        -np.exp(1j * rim.slant)[:, None] * np.exp(-1j * (rim.angle + line)[:, None] * n)
    )


def _hole_traction(
    disc: Annulus, holes: Holes, force: complex, edge: DiscEdge
) -> tuple[Complexes, Complexes]:
    """Return the traction (point,), Pa, of a cosine pressure on half of a hole's edge with this
    resultant (N), by its harmonics.

    In two parts: the first harmonic, which has the resultant and is linear in the force, and the
    even ones, without resultant.
    """
    outward = -edge.normals
    turn = np.angle(outward) - np.angle(force)
    even = np.arange(1, edge.terms // 2 + 1)
    others = 1 / math.pi + 2 / math.pi * np.cos(2 * turn[:, None] * even) @ (
        (-1.0) ** (even + 1) / (4 * even**2 - 1)
    )
    unit = 2 * abs(force) / (math.pi * holes.radius * disc.width) * outward
    return unit * np.cos(turn) / 2, unit * others
