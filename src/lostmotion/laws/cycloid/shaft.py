"""Compliance of the eccentric's shaft as a beam on its bearings, under discs whose forces turn with their cranks.

The forces on the discs are equal and point in the directions of their cranks' phases, so the shaft bends in two planes at once, and two discs in
opposite phase load it by a couple. The shaft is a `supported_beam`; its contributions by part stay separate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.laws.beam import round_section
from lostmotion.laws.supported_beam import Piece, SupportedBeam, respond

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.spatial import Floats


@dataclass(frozen=True, slots=True)
class Layer:
    """One concentric layer of a shaft's section: outer and inner diameter (m), Young's modulus (Pa) and Poisson's ratio."""

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
        return self.young / (2 + 2 * self.nu) * round_section(self.outer, self.inner, self.nu).torsion

    @property
    def shear(self) -> float:
        """Return the shear stiffness k G A (N)."""
        section = round_section(self.outer, self.inner, self.nu)
        return self.young / (2 + 2 * self.nu) * section.area * section.shear_y


@dataclass(frozen=True, slots=True)
class Stretch:
    """A stretch of a shaft from `start` to `end` (m) with concentric layers, which bend together, bonded or loose."""

    start: float
    end: float
    layers: tuple[Layer, ...]

    @property
    def piece(self) -> Piece:
        """Return the stretch as a piece of a beam: stiffnesses of layers with the same curvature add up."""
        return Piece(self.start, self.end, sum(each.bending for each in self.layers), sum(each.shear for each in self.layers))

    @property
    def torsion(self) -> float:
        """Return the torsional stiffness G J (N m^2)."""
        return sum(each.torsion for each in self.layers)


@dataclass(frozen=True, slots=True)
class ShaftCompliance:
    """Displacement of a disc per force on every disc, m/N, averaged over the discs, and the reactions.

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
    beam: SupportedBeam, stretches: Sequence[Stretch], discs: Sequence[tuple[float, float]], phases: Floats, eccentricity: float
) -> ShaftCompliance:
    """Return the compliance of a shaft under its discs.

    beam       the stretches as pieces, on their supports
    discs      the stretch of the shaft on which each disc's bearing pushes, m; equal places are a point load
    phases     (disc,) of the cranks, rad
    eccentricity  m: a disc's force twists the shaft by this lever arm, relative to the first disc

    The displacement of disc d along its own force is the sum over j of A_dj cos(phi_d - phi_j), with the flexibility A of the beam. The shaft is
    driven at its start. Torsion before the first disc belongs to the input. Raises ValueError for a beam that can move freely.
    """
    found = respond(beam, discs)
    along = np.exp(1j * np.asarray(phases))
    by_part = np.einsum("i,pij,j->p", along.conj(), found.by_part, along).real / len(discs)
    reactions = np.abs(found.reactions @ along)
    middles = [(low + high) / 2 for low, high in discs]
    first = min(middles)
    twist = sum(_twist(stretches, first, min(one, two)) for one in middles for two in middles)
    return ShaftCompliance(by_part, eccentricity**2 * twist / len(discs), np.asarray(reactions))


def _twist(stretches: Sequence[Stretch], start: float, end: float) -> float:
    """Return the twist between two places per torque, rad/(N m)."""
    lengths = [(max(min(end, each.end) - max(start, each.start), 0.0), each.torsion) for each in stretches]
    return math.fsum(length / torsion for length, torsion in lengths)
