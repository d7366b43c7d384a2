"""Sections of several materials, or that change along the link: composite, stepped and tapered."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Final, Literal, Self, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from lostmotion.laws import beam, cross_sections
from lostmotion.parts.error_source import Length, LengthAmount, LengthPlus, Part
from lostmotion.parts.material import Material
from lostmotion.parts.provenance import Sourced, value_keys
from lostmotion.parts.section import (
    Box,
    CustomSection,
    ISection,
    Outline,
    Plain,
    Rectangle,
    Rod,
    Sized,
    Tube,
    refuse_section,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.spatial import Floats

# Allowed relative difference between the link's length and that of its steps or stations (rounded
# lengths of a table or URDF); they are stretched.
_SLACK: Final = 1e-3
# Gauss points per piece of a taper, over which no size changes by more than a factor of two: 1e-10
# of the bending.
_TAPER_POINTS: Final = 8


@dataclass(frozen=True, slots=True)
class _Share:
    """Contribution of one material to a section: compliance per length (6, 6), mass per length,
    kg/m, and the free thermal strain of the section.
    """

    material: Material
    compliance: Floats
    density: float
    strain: Floats


def _plain(section: Plain, material: Material) -> _Share:
    values = section.values(material.poisson)
    compliance = cross_sections.compliance_per_length(material.modulus, material.shear, values)
    return _Share(
        material,
        compliance,
        values.area * (float("nan") if material.density is None else material.density),
        _strain(material, section.height),
    )


def _strain(material: Material, height: float | None) -> Floats:
    unknown = float("nan")
    return cross_sections.thermal_strain(
        unknown if material.expansion is None else material.expansion, height or unknown
    )


class Layer(Part):
    """One profile of a composite section.

    offset  of its centroid from the link's line, along the section's height
    """

    section: Plain
    material: Material
    offset: Length = 0.0


class Composite(Sourced):
    """A section of several materials bonded together: an aluminium tube in a sleeve of carbon
    fibre, or layers at offsets, such as a sandwich.

    The layers bend, stretch and twist as one, so their stiffnesses add. Whether they overlap is not
    checked. The torsion of layers that are not round is approximate, and so is the shear of layers
    at offsets. Layers of different expansion at offsets bend with temperature (a bimetal).
    """

    kind: Literal["composite"] = "composite"
    layers: Annotated[tuple[Layer, ...], Field(min_length=1, max_length=10)]

    def shares(self) -> list[_Share]:
        """Return the contribution of each layer to the section."""
        alone = [_plain(layer.section, layer.material) for layer in self.layers]
        bonded = np.stack(
            [
                cross_sections.beside_axis(share.compliance, layer.offset)
                for share, layer in zip(alone, self.layers, strict=True)
            ]
        )
        compliances = cross_sections.parallel_layers(bonded)
        strain = cross_sections.layered_strain(
            bonded, np.stack([_strain(layer.material, self.height) for layer in self.layers])
        )
        return [
            _Share(share.material, compliance, share.density, strain)
            for share, compliance in zip(alone, compliances, strict=True)
        ]

    @property
    def height(self) -> float | None:
        """Return the height of the whole section, m; None where that of a layer is not known."""
        heights = [(layer.offset, layer.section.height) for layer in self.layers]
        ends = [
            (offset - height / 2, offset + height / 2)
            for offset, height in heights
            if height is not None
        ]
        return (
            max(high for _, high in ends) - min(low for low, _ in ends)
            if len(ends) == len(heights)
            else None
        )


CrossSection: TypeAlias = Annotated[
    Tube | Rod | Rectangle | Box | ISection | CustomSection | Outline | Composite,
    Field(discriminator="kind"),
]


def _shares(section: CrossSection, material: Material | None) -> list[_Share]:
    if isinstance(section, Composite):
        return section.shares()
    if material is None:
        raise ValueError("a section of no material")
    return [_plain(section, material)]


class Step(Part):
    """One step of a stepped link: its length, its section, and its material where it differs from
    the link's.
    """

    length: LengthPlus
    section: CrossSection
    material: Material | None = None

    @model_validator(mode="after")
    def _has_one_material(self) -> Self:
        if isinstance(self.section, Composite) and self.material is not None:
            raise refuse_section(
                "a material beside a composite section",
                "the materials in its layers",
                'section = { kind = "composite" }',
            )
        return self


class Stepped(Sourced):
    """A link of several uniform sections in a row, from the joint on; their lengths add up to the
    link's.
    """

    kind: Literal["stepped"] = "stepped"
    steps: Annotated[tuple[Step, ...], Field(min_length=1, max_length=50)]

    @property
    def length(self) -> float:
        """Return the sum of the steps, m."""
        return sum(step.length for step in self.steps)


class Station(Part):
    """A position along a tapered link, from the joint, and the section there."""

    at: LengthAmount
    section: Sized


class Tapered(Sourced):
    """A link whose sizes change linearly from each station to the next, from the joint (at 0) to
    the tip; a step is two stations at one place.
    """

    kind: Literal["tapered"] = "tapered"
    stations: Annotated[tuple[Station, ...], Field(min_length=2, max_length=50)]

    @model_validator(mode="after")
    def _stations_ascend(self) -> Self:
        at = [station.at for station in self.stations]
        if at[0] != 0 or any(a > b for a, b in itertools.pairwise(at)) or at[-1] <= 0:
            found = ", ".join(f"{x * 1e3:g}" for x in at)
            raise refuse_section(
                f"stations at {found} mm", "the first at 0, in ascending order", _STATIONS
            )
        for one, other in itertools.pairwise(self.stations):
            if one.at < other.at and type(one.section) is not type(other.section):
                found = f"a taper from a {one.section.kind} to a {other.section.kind}"
                raise refuse_section(
                    found,
                    (
                        "the same kind of section at both ends of a taper, or two stations at one "
                        "place"
                    ),
                    _STATIONS,
                )
        return self

    @property
    def length(self) -> float:
        """Return the position of the last station, m."""
        return self.stations[-1].at


_STATIONS: Final = (
    'stations = [{ at = "0 mm", section = "large" }, { at = "400 mm", section = "small" }]'
)
Section = Annotated[
    Tube
    | Rod
    | Rectangle
    | Box
    | ISection
    | CustomSection
    | Outline
    | Composite
    | Stepped
    | Tapered,
    Field(discriminator="kind"),
]


def section_error(section: Section, length: float, *, has_material: bool) -> tuple[str, str] | None:
    """Return why a link of this length cannot have such a section, and what is expected; None where
    it can.
    """
    takes = not isinstance(section, Composite)
    if isinstance(section, Stepped):
        takes = any(
            step.material is None and not isinstance(step.section, Composite)
            for step in section.steps
        )
    if takes and not has_material:
        return "a section without a material", "both or neither"
    if has_material and not takes:
        return (
            "a material beside a section that states its own",
            "the materials in the section alone",
        )
    if isinstance(section, Stepped | Tapered) and abs(section.length - length) > _SLACK * length:
        return (
            (
                f"a {section.kind} section {section.length * 1e3:g} mm long in a link "
                f"{length * 1e3:g} mm long"
            ),
            "steps or stations up to its tip",
        )
    return None


def beam_of(
    section: Section, length: float, material: Material | None
) -> tuple[beam.Beam, tuple[Material, ...]]:
    """Return the beam of a link of this length and section, and the material of each of its causes.

    Pieces of one material share one scatter: they come from one batch. Raises ValueError for a
    section of no material.
    """
    if isinstance(section, Tapered):
        if material is None:
            raise ValueError("a section of no material")
        return _tapered(section, length, material), (material,)
    steps = (
        section.steps
        if isinstance(section, Stepped)
        else (Step.model_construct(length=length, section=section, material=None),)
    )
    shares = [_shares(step.section, step.material or material) for step in steps]
    materials = tuple(dict.fromkeys(share.material for piece in shares for share in piece))
    ends = np.cumsum([0.0, *(step.length for step in steps)])
    ends *= length / ends[-1]
    pieces = [
        _even(start, end, piece, materials)
        for (start, end), piece in zip(itertools.pairwise(ends.tolist()), shares, strict=True)
    ]
    return beam.Beam(tuple(pieces)), materials


def _even(
    start: float, end: float, shares: Sequence[_Share], materials: tuple[Material, ...]
) -> beam.Segment:
    compliance = np.zeros((len(materials), 6, 6))
    for share in shares:
        compliance[materials.index(share.material)] += share.compliance
    return beam.uniform_segment(
        start, end, compliance, sum(share.density for share in shares), shares[0].strain
    )


def _tapered(section: Tapered, length: float, material: Material) -> beam.Beam:
    stretch = length / section.length
    tapers = [
        _Taper(one.section, other.section, one.at * stretch, other.at * stretch, material)
        for one, other in itertools.pairwise(section.stations)
        if one.at < other.at
    ]
    return beam.Beam(tuple(piece for taper in tapers for piece in taper.pieces()))


@dataclass(frozen=True, slots=True)
class _Taper:
    """A part of a link whose sizes change linearly from one section to another."""

    near: Sized
    far: Sized
    start: float
    end: float
    material: Material

    def pieces(self) -> list[beam.Segment]:
        """Return the taper in pieces, divided where a size has doubled or halved."""
        cuts = {0.0, 1.0}
        for near, far in (
            (getattr(self.near, size), getattr(self.far, size)) for size in _sizes(self.near)
        ):
            count = math.ceil(abs(math.log2(far / near)))
            cuts |= {((far / near) ** (k / count) - 1) / (far / near - 1) for k in range(1, count)}
        places = [self.start + (self.end - self.start) * cut for cut in sorted(cuts)]
        return [
            beam.Segment(low, high, self.compliance, self.density, _TAPER_POINTS, self.strain)
            for low, high in itertools.pairwise(places)
        ]

    def compliance(self, x: float) -> Floats:
        """Return the compliance per length of the section at x (1, 6, 6)."""
        return self._at(x).compliance[None]

    def density(self, x: float) -> float:
        """Return the mass per length at x, kg/m."""
        return self._at(x).density

    def strain(self, x: float) -> Floats:
        """Return the free thermal strain at x (6, 2)."""
        return self._at(x).strain

    def _at(self, x: float) -> _Share:
        share = (x - self.start) / (self.end - self.start)
        sizes = {
            size: (1 - share) * getattr(self.near, size) + share * getattr(self.far, size)
            for size in _sizes(self.near)
        }
        return _plain(type(self.near).model_construct(**sizes), self.material)


def _sizes(section: Sized) -> list[str]:
    return value_keys(type(section))
