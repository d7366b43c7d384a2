"""Outlines of planet and ring with corners at chosen points of their contacts, from which meshes
are made.

Complex numbers stand for points: x + iy in the frame of the ring, m. Pins are integral with their
wheel around half-round seats, as in `cycloid.bodies`. Between them is the pin circle, or the circle
that the tips of the other wheel reach where this is deeper.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from lostmotion.laws.cycloid.geometry import (
    arms,
    contact_radius,
    flank,
    normals,
    pin_angles,
    planet_pose,
)

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.stage import Stage
    from lostmotion.spatial import Floats

Points = np.ndarray[tuple[int, ...], np.dtype[np.complex128]]

# Points of a flank between two corners, and within an interval of a contact.
_LONG: Final = 257
_SHORT: Final = 5
# Longest arc of one edge, rad.
_ARC: Final = 1.0
# Samples of the flank, half a pitch to either side of a contact.
_SAMPLES: Final = 801
# Share of a pin's free arc that a contact may use.
_WITHIN: Final = 0.98
_SAME: Final = 1e-9


@dataclass(frozen=True, slots=True)
class Edge:
    """A smooth piece of an outline.

    points   (point,) on the true profile, m: of an arc of a circle three, otherwise the nodes of a
             cubic spline
    contact  number of the contact on which it lies, or -1
    """

    points: Points
    contact: int = -1

    @property
    def arc(self) -> bool:
        """Return whether it is an arc of a circle."""
        return len(self.points) == 3  # noqa: PLR2004 - start, middle, end

    @property
    def straight(self) -> bool:
        """Return whether it is a straight line."""
        across = (self.points[1:-1] - self.points[0]) / (self.points[-1] - self.points[0])
        return bool(np.abs(across.imag).max() < _SAME)


@dataclass(frozen=True, slots=True)
class Contacts:
    """The contacts of a stage with pins, or lobes of plain arcs, at one crank angle. Lengths in m,
    angles in rad.

    crank             crank angle
    theta    (N,)     angle from the line of centres
    pin      (N,)     centre of the pin or lobe
    towards  (N,)     unit vector from the pin's centre to the point of contact
    radius   (N,)     equivalent radius
    flank_at (N,)     parameter of the flank
    planet            centre of the planet
    turn              rotation of the planet
    """

    stage: Stage
    crank: float
    theta: Floats
    pin: Points
    towards: Points
    radius: Floats
    flank_at: Floats
    planet: complex
    turn: float
    moments: ClassVar[int] = 2
    hertzian: ClassVar[bool] = True

    @property
    def arm(self) -> Floats:
        """Return the arms (N,), m."""
        return arms(self.stage, self.theta)

    @property
    def place(self) -> Points:
        """Return the points of contact (N,), m."""
        return np.asarray(self.pin + self.stage.pin_radius * self.towards)

    @property
    def lever(self) -> Floats:
        """Return the slip of the flank on each pin per rotation of the planet (N,), m."""
        foot = self.pin if self.stage.has_planet_pins else self.place
        return np.asarray((np.conj(self.towards) * (foot - self.planet)).real)

    def normal(self, k: int, places: Floats) -> Points:
        """Return the unit vectors away from the centre of pin k at places (m) along it."""
        return np.asarray(self.towards[k] * np.exp(1j * places / self.stage.pin_radius))

    def surface(self, k: int, places: Floats) -> tuple[Floats, Floats, Floats]:
        """Return gaps (m), moments of the normals about the planet's centre (m) and curvatures of
        the pin (1/m) at places (m) of contact k.
        """
        moment = (np.conj(self.pin[k] - self.planet) * self.normal(k, places)).imag
        return (
            gaps_at(self, k, places),
            np.asarray(moment),
            np.full(len(places), 1 / self.stage.pin_radius),
        )

    def planet_outline(self, at: dict[int, Floats]) -> list[Edge]:
        """Return the closed outline of the planet with corners at places (m) of contacts."""
        return pinned(self, at) if self.stage.has_planet_pins else toothed(self, at)

    def ring_outline(self, at: dict[int, Floats]) -> list[Edge]:
        """Return the closed outline of the ring with corners at places (m) of contacts."""
        return toothed(self, at) if self.stage.has_planet_pins else pinned(self, at)

    def along(self, k: int, points: Points) -> Floats:
        """Return the distance (m) along pin k, from its point of contact, of each point's foot; it
        rises with the angle about the pin's centre.
        """
        return np.asarray(
            np.angle((points - self.pin[k]) / self.towards[k]) * self.stage.pin_radius
        )

    def free_arc(self) -> tuple[Floats, Floats]:
        """Return how far (m, both positive) a pin's free arc extends from each contact, against and
        along growing angles about its centre.
        """
        centre = self.planet if self.stage.has_planet_pins else 0.0
        crest = (self.pin - centre) * (1 if self.stage.has_planet_pins else -1)
        off = np.angle(crest / self.towards)
        end = _free_angle(self.stage)
        return (end - off) * self.stage.pin_radius * _WITHIN, (
            end + off
        ) * self.stage.pin_radius * _WITHIN


def contacts(stage: Stage, crank: float) -> Contacts:
    """Return the contacts with pins or arcs at a crank angle (rad); for envelope rings see
    `envelope`.
    """
    theta = pin_angles(stage, np.array([crank]))[0]
    towards = -(normals(stage, theta) @ np.array([1, 1j])) * np.exp(1j * crank)
    centre, turn = planet_pose(stage, np.array(crank))
    planet, rotation = complex(*centre), float(turn)
    around = np.asarray(2 * math.pi / stage.pins * np.arange(stage.pins), dtype=np.float64)
    if stage.has_planet_pins:
        pin = planet + stage.ring_radius * np.exp(1j * (around + rotation))
        return Contacts(
            stage,
            crank,
            theta,
            pin,
            -towards,
            contact_radius(stage, theta),
            np.asarray(around + rotation),
            planet,
            rotation,
        )
    pin = stage.ring_radius * np.exp(1j * around)
    return Contacts(
        stage,
        crank,
        theta,
        pin,
        towards,
        contact_radius(stage, theta),
        np.asarray(around - rotation),
        planet,
        rotation,
    )


def toothed(made: Contacts, at: dict[int, Floats]) -> list[Edge]:
    """Return the closed outline of the toothed wheel, counter-clockwise, with corners at the places
    `at` (m) of contacts.

    at: for each contact distances along the pin's surface from the point of contact, rising with
    the angle about the pin's centre; every contact has a corner at its point of contact in any
    case. Raises ValueError where a contact would reach past its flank.
    """
    stage = made.stage
    found: list[tuple[float, int, int]] = []
    for k in range(stage.pins):
        places = at.get(k, np.zeros(1))
        found += [(t, k, j) for j, t in enumerate(_flank_parameters(made, k, places))]
    found.sort()
    edges = []
    for (start, k, i), (end, other, j) in zip(
        found, [*found[1:], (found[0][0] + 2 * math.pi, *found[0][1:])], strict=True
    ):
        one = k == other and abs(i - j) == 1
        t = np.linspace(start, end, _SHORT if one else _LONG)
        edges.append(Edge(_placed(made, t), k if one else -1))
    return edges


def pinned(made: Contacts, at: dict[int, Floats]) -> list[Edge]:
    """Return the closed outline of the wheel with the pins or lobes, counter-clockwise, with
    corners as `toothed`.
    """
    stage = made.stage
    centre, way = (made.planet, 1) if stage.has_planet_pins else (0.0, -1)
    free, root = _free_angle(stage), _root_radius(stage)
    order = np.argsort(np.angle((made.pin - centre) / (made.pin[0] - centre)) % (2 * math.pi))
    pins = [_pin(made, int(k), centre, way, free, at.get(int(k), np.zeros(1))) for k in order]
    edges: list[Edge] = []
    for pin, after in zip(pins, [*pins[1:], pins[0]], strict=True):
        edges += pin + _root(pin[-1].points[-1], after[0].points[0], centre, root)
    return edges


def _pin(
    made: Contacts, k: int, centre: complex, way: int, free: float, places: Floats
) -> list[Edge]:
    """Return the free arc of pin k, counter-clockwise about the wheel's centre; `way` is +1 where
    its crest is outwards.
    """
    crest = way * (made.pin[k] - centre) / abs(made.pin[k] - centre)
    here = float(np.angle(made.towards[k] / crest))
    inner = np.sort(here + np.asarray(places) / made.stage.pin_radius)
    corners = way * np.sort(way * np.concatenate([[-free, free], inner]))
    edges = []
    for n, (start, end) in enumerate(itertools.pairwise(corners)):
        own = 1 <= n < len(places)
        steps = 1 if own else max(1, math.ceil(abs(end - start) / _ARC))
        on = made.pin[k] + made.stage.pin_radius * crest * np.exp(
            1j * np.linspace(start, end, 2 * steps + 1)
        )
        edges += [Edge(on[2 * j : 2 * j + 3], k if own else -1) for j in range(steps)]
    return edges


def _root(start: complex, end: complex, centre: complex, radius: float) -> list[Edge]:
    """Return the bottom between two pins: an arc about the centre, with radial walls where the pins
    end before it.
    """
    a, b = start - centre, end - centre
    foot, top = a / abs(a) * radius, b / abs(b) * radius
    arc = Edge(np.array([foot, foot * np.sqrt(top / foot), top]) + centre)
    if abs(abs(a) - radius) < _SAME * radius:
        return [Edge(np.array([start, arc.points[1], end]))]
    return [
        Edge(np.array([start, (start + arc.points[0]) / 2, arc.points[0]])),
        arc,
        Edge(np.array([arc.points[2], (arc.points[2] + end) / 2, end])),
    ]


def _root_radius(stage: Stage) -> float:
    """Return the radius (m) of the bottom between pins or lobes."""
    r, rr, e = stage.ring_radius, stage.pin_radius, stage.eccentricity
    return min(r, r + rr - 2 * e) if stage.has_planet_pins else max(r, r - rr + 2 * e)


def _free_angle(stage: Stage) -> float:
    """Return the half angle (rad) of a pin's free arc, from its crest to the bottom, or to a radial
    wall tangent to a lobe with a stem.
    """
    r, rr, root = stage.ring_radius, stage.pin_radius, _root_radius(stage)
    if stage.kind == "lobe arcs" and root > r:
        return math.acos(rr / r)
    meets = math.acos(max((r**2 + rr**2 - root**2) / (2 * r * rr), -1.0))
    return math.pi - meets if stage.has_planet_pins else meets


def _placed(made: Contacts, t: Floats) -> Points:
    """Return the points of the toothed wheel's flank at parameters t in the ring's frame."""
    points = flank(made.stage, t)[0] @ np.array([1, 1j])
    return (
        points
        if made.stage.has_planet_pins
        else np.asarray(made.planet + points * np.exp(1j * made.turn))
    )


def _flank_parameters(made: Contacts, k: int, places: Floats) -> Floats:
    """Return the parameters of the flank's points above these places (m) of contact k."""
    half = math.pi / made.stage.lobes
    around = np.linspace(-half, half, _SAMPLES)
    s = made.along(k, _placed(made, made.flank_at[k] + around))
    sign = 1.0 if s[_SAMPLES // 2 + 1] > s[_SAMPLES // 2 - 1] else -1.0
    rising = np.diff(sign * s) > 0
    first = _SAMPLES // 2 - int(np.argmin(np.append(rising[_SAMPLES // 2 - 1 :: -1], False)))
    last = _SAMPLES // 2 + int(np.argmin(np.append(rising[_SAMPLES // 2 :], False)))
    known, at = sign * s[first : last + 1], around[first : last + 1]
    wanted = sign * np.asarray(places)
    if wanted.min() < known[0] or wanted.max() > known[-1]:
        raise ValueError(
            f"the contact at {math.degrees(made.theta[k]):.1f} deg from the line of centres "
            "would reach past its flank"
        )
    t = np.interp(wanted, known, at)
    step = 1e-7
    for _ in range(4):
        here = made.flank_at[k] + t
        slope = (
            made.along(k, _placed(made, here + step)) - made.along(k, _placed(made, here - step))
        ) / (2 * step)
        t = t - (made.along(k, _placed(made, here)) - places) / slope
    return np.asarray(made.flank_at[k] + t)


def gaps_at(made: Contacts, k: int, places: Floats) -> Floats:
    """Return the gap (m) between the unloaded flank and the pin at these places (m) of contact
    k.
    """
    return np.asarray(
        np.abs(_placed(made, _flank_parameters(made, k, places)) - made.pin[k])
        - made.stage.pin_radius
    )
