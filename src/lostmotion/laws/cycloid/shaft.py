"""Compliance of the eccentric's shaft as a beam on its bearings, under discs whose forces turn with
their cranks.

The forces on the discs are equal and point in the directions of their cranks' phases, so the shaft
bends in two planes at once, and two discs in opposite phase load it by a couple. The shaft is a
`supported_beam`; its contributions by part stay separate.

Source: H. Allen, Analysis and Design of Structural Sandwich Panels, 1969 (tight screws off the
axis, thick faces).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cross_sections import round_section
from lostmotion.laws.supported_beam import BeamPiece, SupportedBeam, respond

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.spatial import Floats

# Share of the bending stiffness below which screws count as being on the neutral axis.
_ON_AXIS: Final = 1e-9


@dataclass(frozen=True, slots=True)
class ShaftLayer:
    """One concentric layer of a shaft's section: outer and inner diameter (m), Young's modulus (Pa)
    and Poisson's ratio.
    """

    outer: float
    inner: float
    young: float
    nu: float

    @property
    def bending(self) -> float:
        """Return the bending stiffness E I (N m^2)."""
        return self.young * round_section(self.outer, self.inner, self.nu).i_z

    @property
    def torsion(self) -> float:
        """Return the torsional stiffness G J (N m^2)."""
        return (
            self.young / (2 + 2 * self.nu) * round_section(self.outer, self.inner, self.nu).torsion
        )

    @property
    def shear(self) -> float:
        """Return the shear stiffness k G A (N)."""
        section = round_section(self.outer, self.inner, self.nu)
        return self.young / (2 + 2 * self.nu) * section.area * section.shear_y


@dataclass(frozen=True, slots=True)
class ShaftBolts:
    """Screws along a shaft, evenly spaced on a circle off its axis.

    count, diameter, offset  number, diameter and radius of their circle, m
    young, nu                of the screws, Pa

    Tight screws and the body between them bend as a sandwich, in which the body transmits the
    shear; loose ones only bend on their own.
    """

    count: int
    diameter: float
    offset: float
    young: float
    nu: float

    @property
    def directions(self) -> tuple[float, ...]:
        """Return the directions of bending, rad, of which the mean is that of all directions: two
        for a pair of screws, else one.
        """
        return (0.0, math.pi / 2) if self.count == 2 else (0.0,)  # noqa: PLR2004 - a pair

    def squares(self, direction: float) -> float:
        """Return the sum of the squared distances from the neutral axis (m^2) for bending in this
        direction.
        """
        return sum(
            (self.offset * math.cos(2 * math.pi * k / self.count - direction)) ** 2
            for k in range(self.count)
        )


@dataclass(frozen=True, slots=True)
class Stretch:
    """A stretch of a shaft from `start` to `end` (m) with concentric layers, which bend together,
    bonded or loose, and screws off the axis.

    Raises ValueError for screws that do not lie within one layer.
    """

    start: float
    end: float
    layers: tuple[ShaftLayer, ...]
    screws: ShaftBolts | None = None

    def __post_init__(self) -> None:
        """Refuse screws across layers."""
        _ = None if self.screws is None else self._web

    @property
    def _web(self) -> ShaftLayer:
        """Return the layer that holds the screws."""
        screws = self.screws
        for layer in self.layers:
            if (
                screws is not None
                and layer.inner <= 2 * screws.offset - screws.diameter
                and 2 * screws.offset + screws.diameter <= layer.outer
            ):
                return layer
        raise ValueError("its screws do not lie within one layer of every section")

    @property
    def piece(self) -> BeamPiece:
        """Return the stretch without screws as a piece of a beam: stiffnesses of layers with the
        same curvature add up.
        """
        return BeamPiece(
            self.start,
            self.end,
            sum(each.bending for each in self.layers),
            sum(each.shear for each in self.layers),
        )

    def piece_with_screws(self, direction: float, *, tight: bool) -> BeamPiece:
        """Return the stretch as a piece of a beam that bends in this direction (rad).

        Loose screws: the body without their holes, and the screws, each about its own axis. Tight
        ones: a sandwich of the same with a second beam, whose bending stiffness is that of the
        screws about the axis of the shaft, and whose shear is that of the layer between them.
        """
        screws, plain = self.screws, self.piece
        if screws is None:
            return plain
        web, own = self._web, ShaftLayer(screws.diameter, 0.0, screws.young, screws.nu)
        hole = ShaftLayer(screws.diameter, 0.0, web.young, web.nu)
        squares, area = screws.squares(direction), math.pi / 4 * screws.diameter**2
        bending = (
            plain.bending + screws.count * (own.bending - hole.bending) - web.young * area * squares
        )
        shear = (
            plain.shear
            + screws.count * own.shear
            - web.shear * screws.count * screws.diameter**2 / (web.outer**2 - web.inner**2)
        )
        faces = screws.young * area * squares
        if not tight or faces < _ON_AXIS * bending:
            return BeamPiece(self.start, self.end, bending, shear)
        return BeamPiece(self.start, self.end, bending, math.inf, (faces, web.shear))

    @property
    def torsion(self) -> float:
        """Return the torsional stiffness G J (N m^2)."""
        return sum(each.torsion for each in self.layers)


@dataclass(frozen=True, slots=True)
class ShaftCompliance:
    """Displacement of a disc per force on every disc, m/N, averaged over the discs, and the
    reactions.

    by_part    (part,) contributions of the stretches, then of the supports of the beam, m/N
    twist      contribution of the torsion between the discs, m/N
    reactions  (support,) force on each support per force on every disc
    """

    by_part: Floats
    twist: float
    reactions: Floats

    @property
    def total(self) -> float:
        """Return the whole compliance, m/N."""
        return float(self.by_part.sum()) + self.twist


def shaft_compliance(
    beam: SupportedBeam,
    stretches: Sequence[Stretch],
    discs: Sequence[tuple[float, float]],
    phases: Floats,
    eccentricity: float,
) -> ShaftCompliance:
    """Return the compliance of a shaft under its discs.

    beam       the stretches as pieces, on their supports
    discs      the stretch of the shaft on which each disc's bearing pushes, m; equal places are a
               point load
    phases     (disc,) of the cranks, rad
    eccentricity  m: a disc's force twists the shaft by this lever arm, relative to the first disc

    The displacement of disc d along its own force is the sum over j of A_dj cos(phi_d - phi_j),
    with the flexibility A of the beam. The shaft is driven at its start. Torsion before the first
    disc belongs to the input. Raises ValueError for a beam that can move freely.
    """
    found = respond(beam, discs)
    along = np.exp(1j * np.asarray(phases))
    by_part = np.einsum("i,pij,j->p", along.conj(), found.by_part, along).real / len(discs)
    reactions = np.abs(found.reactions @ along)
    middles = [(low + high) / 2 for low, high in discs]
    first = min(middles)
    turned = sum(twist(stretches, first, min(one, two)) for one in middles for two in middles)
    return ShaftCompliance(by_part, eccentricity**2 * turned / len(discs), np.asarray(reactions))


def twist(stretches: Sequence[Stretch], start: float, end: float) -> float:
    """Return the twist between two places per torque, rad/(N m)."""
    lengths = [
        (max(min(end, each.end) - max(start, each.start), 0.0), each.torsion) for each in stretches
    ]
    return math.fsum(length / torsion for length, torsion in lengths)
