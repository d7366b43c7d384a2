"""Contacts of a disc with an envelope ring, both branches of it, and the outlines of both wheels
from which meshes are made.

The flank of the disc is divided along its length. Parts of it that come close to the ring are the
contacts; those of both branches merge where they are near each other. The ring's profile is the arc
of a pin up to the junction, and beyond it the branch that the tips of the disc cut. Normals and
gaps are those of the ring's true profile at the foot of each point of the disc. Complex numbers
stand for points, as in `contours`.
"""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from lostmotion.laws.cycloid.envelope import junction, ring_of_second_branch
from lostmotion.laws.cycloid.finite_elements.contours import Edge, Points
from lostmotion.laws.cycloid.geometry import arms, flank, gaps, planet_pose

if TYPE_CHECKING:
    from collections.abc import Callable

    from scipy.spatial import KDTree

    from lostmotion.laws.cycloid.stage import Modification, Stage
    from lostmotion.spatial import Floats

# Points of a flank between two corners, and within an interval of a contact.
_LONG: Final = 65
_SHORT: Final = 5
# Points of a lobe's flank, of half a pitch of the ring, and of a lobe in the search for contacts.
_LOBE: Final = 4001
_HALF_PITCH: Final = 8001
_SEARCH: Final = 3000
# Pitches past those with an arm at which contacts are meshed.
_BEYOND: Final = 1.5
# Fewest and most intervals of a contact.
_FEWEST: Final = 4
_MOST: Final = 30
_STEPS: Final = 6


@dataclass(frozen=True, slots=True)
class EnvelopeContacts:
    """The contacts of a disc with an envelope ring at one crank angle. Lengths in m, angles in rad.

    crank               crank angle
    relief              of the disc
    flank_at (contact,) parameter of the disc's flank at the middle of each contact
    theta    (contact,) angle of a pin with the same arm and gap
    place    (contact,) point of the disc there
    towards  (contact,) unit vector there from the ring into the disc
    planet              centre of the disc
    turn                rotation of the disc
    """

    stage: Stage
    crank: float
    relief: Modification
    flank_at: Floats
    theta: Floats
    place: Points
    towards: Points
    planet: complex
    turn: float
    moments: ClassVar[int] = 4
    hertzian: ClassVar[bool] = False

    @property
    def arm(self) -> Floats:
        """Return the arms (contact,), m."""
        return arms(self.stage, self.theta)

    @property
    def lever(self) -> Floats:
        """Return the slip of the flank per rotation of the disc (contact,), m."""
        return np.asarray((np.conj(self.towards) * (self.place - self.planet)).real)

    def normal(self, k: int, places: Floats) -> Points:
        """Return the unit vectors from the ring into the disc at places (m) along contact k."""
        return _nearest(self.stage, self._points(k, places))[0]

    def surface(self, k: int, places: Floats) -> tuple[Floats, Floats, Floats]:
        """Return gaps (m) with the relief, moments of the normals about the disc's centre (m) and
        curvatures of the ring (1/m) along contact k.
        """
        points = self._points(k, places)
        outwards, gap, bend = _nearest(self.stage, points)
        relief = gaps(self.stage, -self.stage.lobes * self._parameters(k, places), self.relief)
        return gap + relief, np.asarray((np.conj(points - self.planet) * outwards).imag), bend

    def along(self, k: int, points: Points) -> Floats:
        """Return the distance (m) along the disc's flank, from the middle of contact k, of each
        point's foot.
        """
        half = math.pi / self.stage.lobes
        known = self.flank_at[k] + np.linspace(-half, half, 801)
        t = known[np.abs(self._placed(known)[:, None] - points).argmin(axis=0)]
        for _ in range(_STEPS):
            step = 1e-7
            slope = (self._placed(t + step) - self._placed(t - step)) / (2 * step)
            t = t + ((points - self._placed(t)) * np.conj(slope)).real / np.abs(slope) ** 2
        return _length(self.stage, t) - _length(self.stage, self.flank_at[k : k + 1])

    def planet_outline(self, at: dict[int, Floats]) -> list[Edge]:
        """Return the closed outline of the disc, counter-clockwise, with corners at the places `at`
        (m) of contacts, and at tips and valleys.
        """
        corners = {k: self._parameters(k, places) for k, places in at.items()}
        return _outline(
            corners, np.arange(2 * self.stage.lobes) * math.pi / self.stage.lobes, self._placed
        )

    def ring_outline(self, at: dict[int, Floats]) -> list[Edge]:
        """Return the closed outline of the ring, counter-clockwise, with corners opposite those of
        the disc, and at crests, junctions and roots.
        """
        corners = {}
        for k, places in at.items():
            points = self._points(k, places)
            outwards, gap, _ = _nearest(self.stage, points)
            angles = np.angle(points - gap * outwards)
            corners[k] = angles[0] + np.angle(np.exp(1j * (angles - angles[0])))
        pitch, side = (
            2 * math.pi / self.stage.pins,
            float(np.angle(_second_branch(self.stage).points[0])),
        )
        others = (
            pitch * np.arange(self.stage.pins)[:, None] + [0.0, side, pitch / 2, pitch - side]
        ).ravel()
        return _outline(corners, others, functools.partial(_ring, self.stage))

    def _points(self, k: int, places: Floats) -> Points:
        return self._placed(self._parameters(k, places))

    def _parameters(self, k: int, places: Floats) -> Floats:
        return _parameter(self.stage, _length(self.stage, self.flank_at[k : k + 1]) + places)

    def _placed(self, t: Floats) -> Points:
        return np.asarray(
            self.planet + flank(self.stage, t)[0] @ np.array([1, 1j]) * np.exp(1j * self.turn)
        )


def envelope_contacts(
    stage: Stage,
    crank: float,
    relief: Modification,
    closest: Callable[[Floats], Floats],
    step: Callable[[Floats], Floats],
) -> tuple[EnvelopeContacts, dict[int, Floats]]:
    """Return the contacts at a crank angle (rad), and the ends of the intervals of each, m from its
    middle.

    closest  from theta (flank,) to the gaps, without relief, below which the flank is meshed, m
    step     from theta to the length of an interval, m
    """
    centre, rotation = planet_pose(stage, np.array(crank))
    planet, turn = complex(*centre), float(rotation)
    t = np.arange(_SEARCH * stage.lobes) * 2 * math.pi / (_SEARCH * stage.lobes)
    theta = -stage.lobes * t
    beyond = min(_BEYOND * 2 * math.pi / stage.pins, 1.0)
    points = planet + flank(stage, t)[0] @ np.array([1, 1j]) * np.exp(1j * turn)
    near = (theta + beyond) % (2 * math.pi) < math.pi + 2 * beyond
    near[near] = _nearest(stage, points[near])[1] < closest(theta[near])
    first = int(np.flatnonzero(~near)[0])
    rolled = np.roll(near, -first)
    starts, ends = (
        np.flatnonzero(np.diff(rolled.astype(int)) == 1) + 1,
        np.flatnonzero(np.diff(np.append(rolled, False).astype(int)) == -1),
    )
    low, high = (_length(stage, t[0] + (first + each) * (t[1] - t[0])) for each in (starts, ends))
    own = step(-stage.lobes * _parameter(stage, (low + high) / 2))
    apart = np.flatnonzero(low[1:] - high[:-1] > own[1:])
    low, high = low[np.append(0, apart + 1)], high[np.append(apart, len(high) - 1)]
    middle = _parameter(stage, (low + high) / 2)
    counts = np.clip(np.ceil((high - low) / step(-stage.lobes * middle)), _FEWEST, _MOST).astype(
        int
    )
    at = {
        k: np.linspace(low[k] - high[k], high[k] - low[k], count + 1) / 2
        for k, count in enumerate(counts)
    }
    place = planet + flank(stage, middle)[0] @ np.array([1, 1j]) * np.exp(1j * turn)
    wrapped = np.asarray(np.angle(np.exp(-1j * stage.lobes * middle)))
    return EnvelopeContacts(
        stage, crank, relief, middle, wrapped, place, _nearest(stage, place)[0], planet, turn
    ), at


def _outline(
    corners: dict[int, Floats], others: Floats, placed: Callable[[Floats], Points]
) -> list[Edge]:
    """Return a closed outline of splines with corners at parameters of the contacts, and at
    `others` where no contact is.
    """
    found = [
        (float(t) % (2 * math.pi), k, j)
        for k, each in corners.items()
        for j, t in enumerate(np.sort(each))
    ]
    # a corner no closer than the length of an interval, because slivers refine the mesh around them
    spans = [
        ((each.min() + each.max()) / 2, np.ptp(each) * (0.5 + 1 / (len(each) - 1)))
        for each in corners.values()
    ]
    free = [
        float(t)
        for t in others
        if all(abs(math.remainder(t - middle, 2 * math.pi)) > reach for middle, reach in spans)
    ]
    found = sorted([*found, *((t % (2 * math.pi), -1, 0) for t in free)])
    edges = []
    for (start, k, i), (end, other, j) in itertools.pairwise(
        [*found, (found[0][0] + 2 * math.pi, *found[0][1:])]
    ):
        one = k >= 0 and k == other and abs(i - j) == 1
        edges.append(
            Edge(placed(np.linspace(start, end, _SHORT if one else _LONG)), k if one else -1)
        )
    ends = [edge.points[0] for edge in edges]
    return [
        Edge(np.append(edge.points[:-1], end), edge.contact)
        for edge, end in zip(edges, [*ends[1:], ends[0]], strict=True)
    ]


@functools.lru_cache(maxsize=8)
def _lengths(stage: Stage) -> tuple[Floats, Floats]:
    """Return parameters (rad) over a lobe, from tip to tip, and the length of the flank from the
    valley (m) there.
    """
    t = np.linspace(-math.pi, math.pi, _LOBE) / stage.lobes
    s = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(flank(stage, t)[0] @ np.array([1, 1j]))))])
    return t, s - s[-1] / 2


def _length(stage: Stage, t: Floats) -> Floats:
    """Return the length (m) of the disc's flank from the parameter zero to parameters t (rad)."""
    known, s = _lengths(stage)
    lobe = np.round(t * stage.lobes / (2 * math.pi))
    return np.asarray(np.interp(t - lobe * 2 * math.pi / stage.lobes, known, s) + 2 * lobe * s[-1])


def _parameter(stage: Stage, length: Floats) -> Floats:
    """Return the parameters (rad) of the disc's flank at lengths (m) from the parameter zero."""
    known, s = _lengths(stage)
    lobe = np.round(length / (2 * s[-1]))
    return np.asarray(
        np.interp(length - 2 * lobe * s[-1], s, known) + lobe * 2 * math.pi / stage.lobes
    )


@dataclass(frozen=True, slots=True)
class _SecondBranch:
    """Half a pitch of the ring's second branch, slightly beyond its root: parameters, points,
    tangents, turning of the tangent (1/m), polar angle.
    """

    t: Floats
    points: Points
    tangent: Points
    turning: Floats
    angle: Floats
    tree: KDTree


@functools.lru_cache(maxsize=8)
def _second_branch(stage: Stage) -> _SecondBranch:
    from scipy.spatial import KDTree

    t = np.linspace(junction(stage), 1.02 * math.pi / stage.lobes, _HALF_PITCH)
    points = ring_of_second_branch(stage, t) @ np.array([1, 1j])
    slope = np.gradient(points)
    turning = np.gradient(np.unwrap(np.angle(slope))) / np.abs(slope)
    return _SecondBranch(
        t,
        points,
        slope / np.abs(slope),
        turning,
        np.angle(points),
        KDTree(np.stack([points.real, points.imag], axis=-1)),
    )


def _folded(
    stage: Stage, angle: Floats
) -> tuple[Floats, np.ndarray[tuple[int, ...], np.dtype[np.bool_]]]:
    """Return the angle of the crest nearest to each polar angle, and whether this lies before
    it.
    """
    crest = 2 * math.pi / stage.pins * np.round(angle * stage.pins / (2 * math.pi))
    return crest, angle < crest


def _nearest(stage: Stage, points: Points) -> tuple[Points, Floats, Floats]:
    """Return the normals of the ring's profile at the feet of points (m), into the disc, the
    distances from it (m), and its curvature (1/m).
    """
    crest, before = _folded(stage, np.angle(points))
    turned = points * np.exp(-1j * crest)
    turned = np.where(before, np.conj(turned), turned)
    branch = _second_branch(stage)
    from_pin = turned - stage.ring_radius
    on_arc = np.angle(-np.conj(from_pin)) < np.angle(-np.conj(branch.points[0] - stage.ring_radius))
    k = np.zeros(turned.shape, dtype=np.int64)
    cut = turned[~on_arc]
    k[~on_arc] = branch.tree.query(np.stack([cut.real, cut.imag], axis=-1))[1]
    beside = (turned - branch.points[k]) * np.conj(branch.tangent[k])
    of_cut = 1j * branch.tangent[k] * np.exp(1j * branch.turning[k] * beside.real)
    normal = np.where(on_arc, from_pin / np.abs(from_pin), of_cut)
    gap = np.where(
        on_arc,
        np.abs(from_pin) - stage.pin_radius,
        beside.imag - branch.turning[k] * beside.real**2 / 2,
    )
    bend = np.where(on_arc, 1 / stage.pin_radius, -branch.turning[k])
    return np.where(before, np.conj(normal), normal) * np.exp(1j * crest), gap, bend


def _ring(stage: Stage, angle: Floats) -> Points:
    """Return the points of the ring's profile (m) at polar angles (rad); of the second branch on
    the true profile, at these angles to 1e-9.
    """
    crest, before = _folded(stage, angle)
    off = np.abs(angle - crest)
    branch = _second_branch(stage)
    on_arc = off < branch.angle[0]
    sine = np.minimum(stage.ring_radius * np.sin(off), stage.pin_radius)
    arc = (stage.ring_radius * np.cos(off) - np.sqrt(stage.pin_radius**2 - sine**2)) * np.exp(
        1j * off
    )
    t = np.interp(off, branch.angle, branch.t)
    cut = ring_of_second_branch(stage, t) @ np.array([1, 1j])
    half = np.where(on_arc, arc, cut)
    return np.asarray(np.where(before, np.conj(half), half) * np.exp(1j * crest))
