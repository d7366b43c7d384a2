"""Rows of rolling elements, described by their contacts: direction, position and stiffness.

There are two kinds of contacts. The closure of a straight one (roller, slice of a roller) is radial
+ across . displacement. The closure of a ball between two grooves is the change of distance between
the groove centres: hypot(radial + across . displacement, axial + along . displacement) - apart.
Both are convex in the displacement (x, y, z, about x, about y; m and rad) of the inner ring. A
share of the row's clearance is subtracted from `radial`.

Source: ISO/TS 16281:2008, 4.2 and 4.3 (balls and sliced rollers); T. Harris, Rolling Bearing
Analysis, 4th ed., chapter 7.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.laws.rolling.radial import (
    BALL_EXPONENT,
    BEARING_STEEL,
    ROLLER_EXPONENT,
    ball_stiffness,
    element_angles,
    roller_stiffness,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.spatial import Floats

    Contacts = NDArray[np.void]

CONTACT: Final = np.dtype(
    [
        ("element", np.int64),  # index in the row
        ("stiffness", float),  # K and n of the force K closure^n, N
        ("exponent", float),
        ("share", float),  # share of the radial clearance in the contact's gap
        ("radial", float),  # m, without displacement and clearance
        ("axial", float),
        ("apart", float),  # m, between the groove centres without load; 0 for a straight contact
        # whether a ball is supported in both axial directions, or towards +axial only
        ("shoulders", bool),
        ("across", float, 5),  # change of `radial` and `axial` per displacement
        ("along", float, 5),
    ],
    align=True,
)


class RollingRow(ABC):
    """One row of rolling elements about the z axis of its own frame."""

    count: int

    @property
    @abstractmethod
    def spring(self) -> tuple[float, float]:
        """Return K and n of one contact."""

    @property
    @abstractmethod
    def pitch_diameter(self) -> float:
        """Return the pitch diameter, m."""

    @property
    @abstractmethod
    def contacts(self) -> Contacts:
        """Return the contacts (contact,) as a structured array of the type CONTACT."""

    def _contacts(self, element: Any, **fields: Any) -> Contacts:  # noqa: ANN401 - whatever broadcasts
        out = np.zeros(len(element), CONTACT)
        out["element"] = element
        out["stiffness"], out["exponent"] = self.spring
        for name, values in fields.items():
            out[name] = values
        return out


@dataclass(frozen=True, slots=True, kw_only=True)
class BallRow(RollingRow):
    """A row of balls: deep-groove (contact_angle 0, both shoulders) or angular-contact (above 0, a
    shoulder against +z only).

    ball, pitch    diameters, m
    grooves        radius of the inner and outer groove over the ball's diameter
    contact_angle  rad; without load the balls of an angular-contact row just touch at this angle
    material       Young's modulus, Pa, and Poisson's ratio of balls and rings
    first          angle of the first ball from x, rad
    """

    count: int
    ball: float
    pitch: float
    grooves: tuple[float, float] = (0.52, 0.52)
    contact_angle: float = 0.0
    material: tuple[float, float] = BEARING_STEEL
    first: float = 0.0

    @property
    def spring(self) -> tuple[float, float]:
        """Return K and n of Hertz's point contacts at both races in series."""
        return ball_stiffness(
            self.ball, self.pitch, *self.grooves, self.contact_angle, self.material
        ), BALL_EXPONENT

    @property
    def pitch_diameter(self) -> float:
        """Return the diameter of the circle of the balls' centres, m."""
        return self.pitch

    @property
    def contacts(self) -> Contacts:
        """Return one contact per ball, along the line between the centres of the two grooves."""
        apart = (sum(self.grooves) - 1) * self.ball
        radius = self.pitch / 2 + (self.grooves[0] - 0.5) * self.ball * math.cos(self.contact_angle)
        across, along = _directions(element_angles(self.count, self.first), radius)
        return self._contacts(
            np.arange(self.count),
            share=0.5,
            radial=apart * math.cos(self.contact_angle),
            axial=apart * math.sin(self.contact_angle),
            apart=apart,
            shoulders=not self.contact_angle,
            across=across,
            along=along,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class RollerRow(RollingRow):
    """A row of cylindrical rollers, divided into slices so that a tilt loads their ends; they carry
    no axial load.

    length, roller, pitch  effective length, diameter and pitch diameter, m
    slices                 number of slices of each roller
    crowned                rollers with the profile of ISO/TS 16281, 0.35 µm per mm of diameter x
                           ln(1/(1 - (2x/l)^2)), at each race
    first                  angle of the first roller from x, rad
    """

    count: int
    length: float
    roller: float
    pitch: float
    slices: int = 30
    crowned: bool = True
    first: float = 0.0

    @property
    def spring(self) -> tuple[float, float]:
        """Return K and n of Palmgren's line contact, with the stiffness divided among the
        slices.
        """
        return roller_stiffness(self.length) / self.slices, ROLLER_EXPONENT

    @property
    def pitch_diameter(self) -> float:
        """Return the diameter of the circle of the rollers' centres, m."""
        return self.pitch

    @property
    def contacts(self) -> Contacts:
        """Return one contact per slice. Its closure is the ring's displacement there, less half the
        clearance and the profile at both races.
        """
        angles = np.repeat(element_angles(self.count, self.first), self.slices)
        place = np.tile(
            ((np.arange(self.slices) + 0.5) / self.slices - 0.5) * self.length, self.count
        )
        profile = (
            -0.00035 * self.roller * np.log1p(-((2 * place / self.length) ** 2))
            if self.crowned
            else np.zeros_like(place)
        )
        cosine, sine = np.cos(angles), np.sin(angles)
        across = np.stack(
            [cosine, sine, np.zeros_like(angles), -place * sine, place * cosine], axis=-1
        )
        return self._contacts(
            np.repeat(np.arange(self.count), self.slices),
            share=0.5,
            radial=-2 * profile,
            across=across,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class CrossedRow(RollingRow):
    """One row of crossed rollers, alternately inclined, so that one pair of rings carries loads in
    all directions.

    length, pitch  effective length of a roller and pitch diameter, m
    lean           angle of the lines of contact from the plane of the bearing, rad
    first          angle of the first roller from x, rad

    A negative clearance is preload, the usual state of these bearings. Raises ValueError for an odd
    number of rollers.
    """

    count: int
    length: float
    pitch: float
    lean: float = math.pi / 4
    first: float = 0.0

    def __post_init__(self) -> None:
        """Refuse an odd number of rollers, with which two neighbours would have the same
        inclination.
        """
        if self.count % 2:
            raise ValueError("crossed rollers come in pairs: an even count is needed")

    @property
    def spring(self) -> tuple[float, float]:
        """Return K and n of Palmgren's line contact."""
        return roller_stiffness(self.length), ROLLER_EXPONENT

    @property
    def pitch_diameter(self) -> float:
        """Return the diameter of the circle of the rollers' centres, m."""
        return self.pitch

    @property
    def contacts(self) -> Contacts:
        """Return one contact per roller, along its line of action."""
        across, along = _directions(element_angles(self.count, self.first), self.pitch / 2)
        leaning = np.where(np.arange(self.count) % 2, -1.0, 1.0)[:, None] * math.sin(self.lean)
        return self._contacts(
            np.arange(self.count),
            share=math.cos(self.lean) / 2,
            across=math.cos(self.lean) * across + leaning * along,
        )


def _directions(angles: Floats, radius: float) -> tuple[Floats, Floats]:
    """Return the radial and the axial motion of the inner race at each element per unit
    displacement, both (element, 5).
    """
    cosine, sine, zero = np.cos(angles), np.sin(angles), np.zeros_like(angles)
    across = np.stack([cosine, sine, zero, zero, zero], axis=-1)
    along = np.stack([zero, zero, zero + 1, radius * sine, -radius * cosine], axis=-1)
    return across, along


@dataclass(frozen=True, slots=True)
class RowSeat:
    """A row on the shaft.

    at             position along z, m
    mirrored       whether its shoulder faces -z
    preload_shift  displacement of its inner ring along its own +z before any load, m

    Two angular-contact rows, one of them mirrored, with the same `preload_shift` are a preloaded
    pair.
    """

    row: RollingRow
    at: float = 0.0
    mirrored: bool = False
    preload_shift: float = 0.0

    @property
    def view(self) -> Floats:
        """Return the matrix (5, 5) from the shaft's displacement to that of the row."""
        view = np.eye(5)
        view[0, 4], view[1, 3] = self.at, -self.at
        if self.mirrored:
            view[2:] *= -1
        return view

    @property
    def contacts(self) -> Contacts:
        """Return the contacts of the row as functions of the shaft's displacement."""
        out = self.row.contacts
        out["radial"] += out["across"][:, 2] * self.preload_shift
        out["axial"] += out["along"][:, 2] * self.preload_shift
        out["across"] @= self.view
        out["along"] @= self.view
        return out
