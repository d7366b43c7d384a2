"""Where a shaft on rolling bearings settles under any load: shift across, shift along and tilt, five degrees of freedom.

Every contact only pushes, Q = K delta^n. How far a contact closes is a convex function of where the shaft stands (the length of a straight line for
balls, a plane for rollers), so the stored energy is convex too: there is one balance, and Newton's method with a search along its line finds it.
Rings and shaft are rigid, speeds low, friction none; cages and ribs carry nothing.

Frame: z along the shaft, right-handed. A stand is (x, y, z, about x, about y) of the shaft against the housing, m and rad; a load
(Fx, Fy, Fz, Mx, My) what the shaft puts on the bearings, N and N m, both about the frame's origin.

Source: ISO/TS 16281:2008, 4.2 and 4.3 (balls and sliced rollers); T. Harris, Rolling Bearing Analysis, 4th ed., chapter 7. In the energy's own
form the moment of a ball acts at the centres of the inner groove, where ISO/TS 16281 takes half the pitch diameter.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.rolling import BALL_EXPONENT, BEARING_STEEL, ROLLER_EXPONENT, ball_stiffness, element_angles, roller_stiffness

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from lostmotion.spatial import Floats

    Indices = NDArray[np.intp]
    Flags = NDArray[np.bool_]

_ITERATIONS: Final = 200
_LINE_STEPS: Final = 40
_CONVERGED: Final = 1e-11
_ROUNDING: Final = 5e-16
# Directions softer than this share of the stiffest count as free: no load, no motion.
_SOFTEST: Final = 1e-12


@dataclass(frozen=True, slots=True)
class Closing:
    """How far contacts close: `approach` (case, contact) m, below zero where open; `slope` (case, contact, 5) is its derivative by the stand.

    Its second derivative is bow bow' with `bow` (case, contact, 5). `size` (case, contact) m is what the approach is a difference of: it tells what
    rounding leaves.
    """

    approach: Floats
    slope: Floats
    bow: Floats
    size: Floats

    def of(self, cases: Indices | Flags) -> Closing:
        """Pick some cases."""
        return Closing(self.approach[cases], self.slope[cases], self.bow[cases], self.size[cases])


class Row(ABC):
    """One row of rolling elements about the z axis of its own frame."""

    @property
    @abstractmethod
    def element(self) -> Indices:
        """Give the number of the element to which each contact belongs (contact,); every element has as many, one after another."""

    @property
    @abstractmethod
    def spring(self) -> tuple[float, float]:
        """Give K and n of one contact."""

    @property
    @abstractmethod
    def pitch_diameter(self) -> float:
        """Give the pitch diameter, m."""

    @abstractmethod
    def closing(self, stand: Floats, clearance: Floats) -> Closing:
        """How far does each contact close at these stands (case, 5) with these radial clearances (case,)?"""


@dataclass(frozen=True, slots=True, kw_only=True)
class BallRow(Row):
    """A row of balls: deep-groove (contact_angle 0, both shoulders) or angular-contact (above 0, a shoulder against +z only).

    ball, pitch   diameters, m
    grooves       radius of the inner and outer groove over the ball's diameter
    contact_angle rad; an angular-contact row stands, unloaded, where its balls just touch at this angle
    first         angle of the first ball from x, rad
    """

    count: int
    ball: float
    pitch: float
    grooves: tuple[float, float] = (0.52, 0.52)
    contact_angle: float = 0.0
    material: tuple[float, float] = BEARING_STEEL
    first: float = 0.0

    @property
    def element(self) -> Indices:
        """One contact per ball."""
        return np.arange(self.count)

    @property
    def spring(self) -> tuple[float, float]:
        """Hertz's point contacts at both races in series."""
        return ball_stiffness(self.ball, self.pitch, *self.grooves, self.contact_angle, self.material), BALL_EXPONENT

    @property
    def pitch_diameter(self) -> float:
        """Give the circle of the balls' centres."""
        return self.pitch

    def closing(self, stand: Floats, clearance: Floats) -> Closing:
        """Follow the line between the centres of the two grooves: how much longer it is than without load is how far the contacts close."""
        apart = (sum(self.grooves) - 1) * self.ball
        radius = self.pitch / 2 + (self.grooves[0] - 0.5) * self.ball * math.cos(self.contact_angle)
        across, along = _directions(element_angles(self.count, self.first), radius)
        radial = apart * math.cos(self.contact_angle) - clearance[:, None] / 2 + stand @ across.T
        axial = apart * math.sin(self.contact_angle) + stand @ along.T
        held = np.ones_like(axial)
        if self.contact_angle:  # on the side without a shoulder the ball stays at the bottom of the groove
            held = np.where(axial > 0, 1.0, 0.0)
            axial = axial * held
        length = np.hypot(radial, axial)
        cosine, sine = (radial / length)[..., None], (axial / length)[..., None]
        bow = (cosine * along - sine * across) * (held / np.sqrt(length))[..., None]
        return Closing(length - apart, cosine * across + sine * along, bow, length)


@dataclass(frozen=True, slots=True, kw_only=True)
class RollerRow(Row):
    """A row of cylindrical rollers, cut into slices so that a tilt loads their ends; they carry nothing along the axis.

    length, roller, pitch  effective length, diameter, pitch diameter, m
    crowned       rollers with the profile of ISO/TS 16281, 0.35 µm per mm of diameter x ln(1/(1 - (2x/l)^2)), at each race
    """

    count: int
    length: float
    roller: float
    pitch: float
    slices: int = 30
    crowned: bool = True
    first: float = 0.0

    @property
    def element(self) -> Indices:
        """One contact per slice."""
        return np.repeat(np.arange(self.count), self.slices)

    @property
    def spring(self) -> tuple[float, float]:
        """Palmgren's line contact, its stiffness shared by the slices."""
        return roller_stiffness(self.length) / self.slices, ROLLER_EXPONENT

    @property
    def pitch_diameter(self) -> float:
        """Give the circle of the rollers' centres."""
        return self.pitch

    def closing(self, stand: Floats, clearance: Floats) -> Closing:
        """Close each slice by the ring's shift there, less half the clearance and the profile at both races."""
        angles = element_angles(self.count, self.first)
        place = ((np.arange(self.slices) + 0.5) / self.slices - 0.5) * self.length
        profile = -0.00035 * self.roller * np.log1p(-((2 * place / self.length) ** 2)) if self.crowned else np.zeros(self.slices)
        cosine, sine = np.cos(angles)[:, None], np.sin(angles)[:, None]
        zero = np.zeros((self.count, self.slices))
        slope = np.stack([cosine + zero, sine + zero, zero, -place * sine, place * cosine], axis=-1).reshape(-1, 5)
        return _straight(stand, slope, np.tile(2 * profile, self.count) + clearance[:, None] / 2)


@dataclass(frozen=True, slots=True, kw_only=True)
class CrossedRow(Row):
    """One row of rollers that stand crosswise: every other one leans the other way, so that one pair of rings carries every load.

    lean          angle of the contacts from the plane of the bearing, rad
    A clearance below zero is preload, the usual state of these bearings.
    """

    count: int
    length: float
    pitch: float
    lean: float = math.pi / 4
    first: float = 0.0

    def __post_init__(self) -> None:
        """Refuse an odd number: two neighbours would lean the same way."""
        if self.count % 2:
            raise ValueError("crossed rollers come in pairs: an even count is needed")

    @property
    def element(self) -> Indices:
        """One contact per roller."""
        return np.arange(self.count)

    @property
    def spring(self) -> tuple[float, float]:
        """Palmgren's line contact."""
        return roller_stiffness(self.length), ROLLER_EXPONENT

    @property
    def pitch_diameter(self) -> float:
        """Give the circle of the rollers' centres."""
        return self.pitch

    def closing(self, stand: Floats, clearance: Floats) -> Closing:
        """Close each roller along the line on which it leans."""
        across, along = _directions(element_angles(self.count, self.first), self.pitch / 2)
        leaning = np.where(np.arange(self.count) % 2, -1.0, 1.0)[:, None] * math.sin(self.lean)
        slope = math.cos(self.lean) * across + leaning * along
        return _straight(stand, slope, clearance[:, None] / 2 * math.cos(self.lean))


def _directions(angles: Floats, radius: float) -> tuple[Floats, Floats]:
    """Give the radial and the axial motion of the inner race at each element, per unit stand (element, 5)."""
    cosine, sine, zero = np.cos(angles), np.sin(angles), np.zeros_like(angles)
    across = np.stack([cosine, sine, zero, zero, zero], axis=-1)
    along = np.stack([zero, zero, zero + 1, radius * sine, -radius * cosine], axis=-1)
    return across, along


def _straight(stand: Floats, slope: Floats, gap: Floats) -> Closing:
    approach = stand @ slope.T - gap
    whole = np.broadcast_to(slope, (*approach.shape, 5))
    return Closing(approach, whole, np.zeros((*approach.shape, 5)), np.abs(approach) + 2 * np.abs(gap))


@dataclass(frozen=True, slots=True)
class Seat:
    """A row on the shaft: at the height `at` (m) along z; `mirrored`: its shoulder faces -z; `pressed` (m): set off along its own +z before any load.

    Two mirrored angular-contact rows, each pressed by the same amount, are a preloaded pair.
    """

    row: Row
    at: float = 0.0
    mirrored: bool = False
    pressed: float = 0.0

    @property
    def view(self) -> Floats:
        """Give the matrix (5, 5) from the shaft's stand to the row's own."""
        view = np.eye(5)
        view[0, 4], view[1, 3] = self.at, -self.at
        if self.mirrored:
            view[2:] *= -1
        return view


@dataclass(frozen=True, slots=True)
class Settled:
    """Where the shaft settles.

    stand      (case, 5) m, rad; NaN where no balance was found
    loads      one (case, element) per row, N
    residual   (case,) what is left unbalanced, as share of the load (moments over half the largest pitch diameter): 1e-11, or what rounding leaves
               where preload or stiffness is many times the load
    converged  (case,) false where nothing holds the load
    stiffness  (case, 5, 5) the slope of the load at the stand, N/m, N/rad, N m/rad
    """

    stand: Floats
    loads: tuple[Floats, ...]
    residual: Floats
    converged: Flags
    stiffness: Floats


class _Balance:
    """The contacts of all rows as one set, in a stand measured in metres throughout."""

    def __init__(self, seats: Sequence[Seat], clearance: Floats) -> None:
        self.seats, self.clearance = seats, clearance
        self.reach = max(seat.row.pitch_diameter for seat in seats) / 2
        self.scale = np.array([1, 1, 1, 1 / self.reach, 1 / self.reach])
        springs = [(*seat.row.spring, len(seat.row.element)) for seat in seats]
        self.stiffness = np.concatenate([np.full(count, k) for k, _, count in springs])
        self.exponent = np.concatenate([np.full(count, n) for _, n, count in springs])

    def closing(self, stand: Floats, cases: Indices) -> Closing:
        """All contacts (case, contact) at these stands of these cases."""
        parts = []
        for seat in self.seats:
            view = seat.view
            own = (stand * self.scale) @ view.T
            own[:, 2] += seat.pressed
            part = seat.row.closing(own, self.clearance[cases])
            turned = view * self.scale
            parts.append(Closing(part.approach, part.slope @ turned, part.bow @ turned, part.size))
        return Closing(*(np.concatenate([getattr(part, name) for part in parts], axis=1) for name in ("approach", "slope", "bow", "size")))

    def held(self, stand: Floats, cases: Indices) -> tuple[Floats, Floats, Closing]:
        """Give the load held (case, 5), each contact's share (case, contact), and the contacts."""
        contact = self.closing(stand, cases)
        each = self.stiffness * np.maximum(contact.approach, 0.0) ** self.exponent
        return (each[:, None] @ contact.slope)[:, 0], each, contact

    def tangent(self, each: Floats, contact: Closing) -> Floats:
        """Give the stiffness of each contact (case, contact), N/m; none where it is open."""
        return np.divide(self.exponent * each, contact.approach, out=np.zeros_like(each), where=contact.approach > 0)

    def slope(self, each: Floats, contact: Closing) -> Floats:
        """Give how the load held grows with the stand (case, 5, 5)."""
        stiff = np.swapaxes(contact.slope, 1, 2) @ (self.tangent(each, contact)[..., None] * contact.slope)
        return np.asarray(stiff + np.swapaxes(contact.bow, 1, 2) @ (each[..., None] * contact.bow))

    def allowance(self, wanted: Floats, each: Floats, contact: Closing) -> Floats:
        """Give how much may be left unbalanced (case,), N: a share of the load, and what rounding leaves of preload and of small differences."""
        rounding = each.sum(axis=1) + np.einsum("ce,ce->c", self.tangent(each, contact), contact.size)
        return np.asarray(_CONVERGED * np.linalg.norm(wanted, axis=1) + _ROUNDING * rounding)


def settle(seats: Sequence[Seat], load: ArrayLike, clearance: Floats | float = 0.0) -> Settled:
    """Where does a shaft on these rows settle under loads (case, 5), and what does each element carry?

    `clearance` (case,) or one for all: radial internal clearance of every row, m, diametral; below zero preload. Where loads leave a direction
    free (no load and no stiffness along it) the shaft stays there in the middle. A case without any balance is marked and NaN.
    Raises ValueError for loads of another shape or not finite.
    """
    loads = np.asarray(load, dtype=float)
    if loads.ndim != 2 or loads.shape[1] != 5 or not np.isfinite(loads).all():  # noqa: PLR2004 - case by five
        raise ValueError(f"loads of the shape (case, 5), all finite, are needed, not {loads.shape}")
    play = np.array(np.broadcast_to(np.asarray(clearance, dtype=float), len(loads)))
    balance = _Balance(seats, play)
    wanted = loads * balance.scale
    stand = _start(balance, wanted)
    stand, ratio = _newton(balance, wanted, stand)
    every = np.arange(len(loads))
    _, each, contact = balance.held(stand, every)
    converged = ratio <= 1
    blank = np.where(converged, 1.0, np.nan)
    size = np.linalg.norm(wanted, axis=1)
    residual = np.linalg.norm(balance.held(stand, every)[0] - wanted, axis=1) / np.where(size > 0, size, 1.0)
    stiffness = balance.slope(each, contact) / (balance.scale[:, None] * balance.scale)
    return Settled(
        stand * balance.scale * blank[:, None], _by_element(seats, each * blank[:, None]), residual, converged, stiffness * blank[:, None, None]
    )


def _by_element(seats: Sequence[Seat], each: Floats) -> tuple[Floats, ...]:
    out, first = [], 0
    for seat in seats:
        element = seat.row.element
        part = each[:, first : first + len(element)].reshape(len(each), int(element[-1]) + 1, -1).sum(axis=2)
        out.append(part)
        first += len(element)
    return tuple(out)


def _start(balance: _Balance, wanted: Floats) -> Floats:
    """Give a stand (case, 5) straight along the load where the contacts hold as much along it as is wanted."""
    size = np.linalg.norm(wanted, axis=1)
    along = wanted / np.where(size > 0, size, 1.0)[:, None]
    cases = np.arange(len(wanted))

    def short(way: Floats) -> Flags:
        held = balance.held(way[:, None] * along, cases)[0]
        return np.asarray(np.einsum("ck,ck->c", held, along) < size)

    low, high = np.zeros_like(size), np.full_like(size, 1e-6)
    while (more := short(high) & (size > 0) & (high < balance.reach)).any():
        low, high = np.where(more, high, low), np.where(more, 2 * high, high)
    for _ in range(10):
        middle = (low + high) / 2
        under = short(middle)
        low, high = np.where(under, middle, low), np.where(under, high, middle)
    return np.asarray(np.where(size > 0, high, 0.0)[:, None] * along)


def _newton(balance: _Balance, wanted: Floats, stand: Floats) -> tuple[Floats, Floats]:
    """Give the balanced stands (case, 5) and how far the residual stands above its allowance (case,); above 1 there is no balance."""
    ratio = np.full(len(wanted), np.inf)
    open_cases = np.arange(len(wanted))
    for _ in range(_ITERATIONS):
        held, each, contact = balance.held(stand[open_cases], open_cases)
        lack = wanted[open_cases] - held
        allowed = balance.allowance(wanted[open_cases], each, contact)
        ratio[open_cases] = np.linalg.norm(lack, axis=1) / np.where(allowed > 0, allowed, 1.0)
        # Whatever has left the bearing altogether is held by nothing.
        on = (ratio[open_cases] > 1) & (np.linalg.norm(stand[open_cases], axis=1) < balance.reach)
        if not on.any():
            break
        open_cases = open_cases[on]
        step = _step(balance.slope(each[on], contact.of(on)), lack[on])
        # No step longer than the way so far and the play: contacts found on the way must not be jumped over.
        longest = np.linalg.norm(stand[open_cases], axis=1) + np.abs(balance.clearance[open_cases]) + 1e-6
        step *= np.minimum(1.0, longest / np.linalg.norm(step, axis=1))[:, None]
        stand[open_cases] += _share_of_step(balance, wanted, stand, step, open_cases)[:, None] * step
    return stand, ratio


def _step(slope: Floats, lack: Floats) -> Floats:
    """Give Newton's step, and none along directions that nothing holds and nothing loads."""
    values, vectors = np.linalg.eigh(slope)
    least = np.maximum(values[:, -1:], 1.0) * _SOFTEST
    parts = np.einsum("ckl,ck->cl", vectors, lack)
    return np.asarray(np.einsum("ckl,cl->ck", vectors, parts / np.maximum(values, least)))


def _share_of_step(balance: _Balance, wanted: Floats, stand: Floats, step: Floats, cases: Indices) -> Floats:
    """Give which share of the step to take: all of it, or as far as the energy falls, to half of the slope at its start."""

    def down(share: Floats) -> Floats:
        held = balance.held(stand[cases] + share[:, None] * step, cases)[0]
        return np.asarray(np.einsum("ck,ck->c", wanted[cases] - held, step))

    start = down(np.zeros(len(cases)))
    low, high = np.zeros(len(cases)), np.ones(len(cases))
    share = high.copy()
    for _ in range(_LINE_STEPS):
        now = down(share)
        beyond = now < -0.5 * start
        low = np.where(~beyond, share, low)
        high = np.where(beyond, share, high)
        done = ~beyond & ((now <= 0.5 * start) | (share >= 1))
        if done.all():
            break
        share = np.where(done, share, (low + high) / 2)
    return share
