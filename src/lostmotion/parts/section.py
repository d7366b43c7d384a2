"""Cross-sections of links by sizes, section properties or outline. Width (y) lies along the joint's
axis, height (z) across it.
"""

from __future__ import annotations

from typing import Annotated, Final, Literal, Self, TypeAlias

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from lostmotion.laws import cross_sections, outline
from lostmotion.parts.error_source import Length, LengthPlus, Wall
from lostmotion.parts.provenance import Sourced
from lostmotion.units import Quantity


def refuse_section(why: str, expected: str, example: str) -> PydanticCustomError:
    """Return the validation error of an impossible link."""
    return PydanticCustomError(
        "section", "{why}", {"why": why, "expected": expected, "example": example}
    )


# Least wall thickness as a share of the section's width; below about 1e-8 rounding would determine
# the stiffness.
_THINNEST: Final = 1e-6


def _refuse_foil(name: str, thin: float, wide: float, example: str) -> None:
    """Refuse a wall, web or flange that is too thin for its section."""
    if thin < _THINNEST * wide:
        found = f"{name} {thin * 1e3:g} mm in a section {wide * 1e3:g} mm wide"
        raise refuse_section(
            found,
            f"a {name} of at least {_THINNEST:g} of the width, {_THINNEST * wide * 1e3:g} mm",
            example,
        )


class Tube(Sourced):
    """A round tube."""

    kind: Literal["tube"] = "tube"
    outer: LengthPlus
    wall: Wall

    @property
    def height(self) -> float:
        """Return the height across the link, m."""
        return self.outer

    @model_validator(mode="after")
    def _wall_fits(self) -> Self:
        if self.wall > self.outer / 2:
            raise refuse_section(
                (
                    f"wall {self.wall * 1e3:g} mm in a tube of {self.outer * 1e3:g} mm outside "
                    "diameter"
                ),
                f"a wall of at most half the outside diameter, {self.outer * 500:g} mm",
                'outer = "60 mm", wall = "3 mm"',
            )
        _refuse_foil("wall", self.wall, self.outer, 'outer = "60 mm", wall = "3 mm"')
        return self

    def values(self, nu: float) -> cross_sections.SectionValues:
        """Return the section values of the beam."""
        return cross_sections.round_section(self.outer, self.outer - 2 * self.wall, nu)


class Rod(Sourced):
    """A solid round bar."""

    kind: Literal["rod"] = "rod"
    diameter: LengthPlus

    @property
    def height(self) -> float:
        """Return the height across the link, m."""
        return self.diameter

    def values(self, nu: float) -> cross_sections.SectionValues:
        """Return the section values of the beam."""
        return cross_sections.round_section(self.diameter, 0.0, nu)


class Rectangle(Sourced):
    """A solid bar; width lies along the joint's axis, height across it."""

    kind: Literal["rectangle"] = "rectangle"
    width: LengthPlus
    height: LengthPlus

    def values(self, nu: float) -> cross_sections.SectionValues:
        """Return the section values of the beam."""
        return cross_sections.rectangle_section(self.width, self.height, nu)


class Box(Sourced):
    """A rectangular tube; width lies along the joint's axis, height across it."""

    kind: Literal["box"] = "box"
    width: LengthPlus
    height: LengthPlus
    wall: Wall

    @model_validator(mode="after")
    def _wall_fits(self) -> Self:
        least = min(self.width, self.height)
        if self.wall >= least / 2:
            raise refuse_section(
                (
                    f"wall {self.wall * 1e3:g} mm in a box {self.width * 1e3:g} x "
                    f"{self.height * 1e3:g} mm"
                ),
                f"a wall below half of the smaller side, {least * 500:g} mm",
                'width = "50 mm", height = "60 mm", wall = "3 mm"',
            )
        _refuse_foil(
            "wall",
            self.wall,
            max(self.width, self.height),
            'width = "50 mm", height = "60 mm", wall = "3 mm"',
        )
        return self

    def values(self, nu: float) -> cross_sections.SectionValues:
        """Return the section values of the beam."""
        return cross_sections.box_section(self.width, self.height, self.wall, nu)


class ISection(Sourced):
    """An I-section: flanges as wide as `width`, along the joint's axis, the web standing across it;
    sharp corners.
    """

    kind: Literal["I"] = "I"
    width: LengthPlus
    height: LengthPlus
    web: Wall
    flange: Wall

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.web >= self.width or self.flange >= self.height / 2:
            raise refuse_section(
                (
                    f"web {self.web * 1e3:g} mm and flanges {self.flange * 1e3:g} mm in a section "
                    f"{self.width * 1e3:g} x {self.height * 1e3:g} mm"
                ),
                "a web thinner than the width, flanges thinner than half the height",
                'width = "50 mm", height = "80 mm", web = "4 mm", flange = "6 mm"',
            )
        for name, thin in (("web", self.web), ("flange", self.flange)):
            _refuse_foil(
                name,
                thin,
                max(self.width, self.height),
                'width = "50 mm", height = "80 mm", web = "4 mm", flange = "6 mm"',
            )
        return self

    def values(self, nu: float) -> cross_sections.SectionValues:
        """Return the section values of the beam."""
        return cross_sections.i_section(self.width, self.height, self.web, self.flange, nu)


class CustomSection(Sourced):
    """Any section by its section properties; y lies along the joint's axis, z across it and the
    link.

    height  along z: over it lies the temperature difference of a link that states one
    """

    kind: Literal["custom"] = "custom"
    area: Annotated[float, Quantity("m^2", "540 mm^2", above=0)]
    i_y: Annotated[float, Quantity("m^4", "2.2e5 mm^4", above=0)]
    i_z: Annotated[float, Quantity("m^4", "2.2e5 mm^4", above=0)]
    torsion: Annotated[float, Quantity("m^4", "4.4e5 mm^4", above=0)]
    shear_y: Annotated[float, Quantity("", "0.5", above=0, high=1)] = 0.5
    shear_z: Annotated[float, Quantity("", "0.5", above=0, high=1)] = 0.5
    height: LengthPlus | None = None

    def values(self, nu: float) -> cross_sections.SectionValues:  # noqa: ARG002 - the signature of all sections
        """Return the section values of the beam; the stated figures already include nu."""
        return cross_sections.SectionValues(
            self.area, self.i_y, self.i_z, self.torsion, self.shear_y, self.shear_z
        )


Corners: TypeAlias = Annotated[
    tuple[tuple[Length, Length], ...], Field(min_length=3, max_length=200)
]


class Outline(Sourced):
    """Any section by its outline: corners (y, z) in order, y along the joint's axis, and holes in
    it. The link's line runs through the centroid.

    Computed by finite elements (`laws.outline`), with the extra `sections`. A channel or an angle
    twists under a force beside its shear centre.
    """

    kind: Literal["outline"] = "outline"
    points: Corners
    holes: Annotated[tuple[Corners, ...], Field(max_length=20)] = ()

    @property
    def height(self) -> float:
        """Return the height across the link, m."""
        heights = [z for _, z in self.points]
        return max(heights) - min(heights)

    @model_validator(mode="after")
    def _is_a_section(self) -> Self:
        if not outline.available():
            raise refuse_section(
                f"an outline without {outline.MISSING}",
                f"{outline.INSTALL}; or another kind of section",
                'kind = "custom"',
            )
        doubt = outline.outline_error(self.points, self.holes)
        if doubt:
            example = 'points = [["0 mm", "0 mm"], ["40 mm", "0 mm"], ["0 mm", "60 mm"]]'
            raise refuse_section(
                f"an invalid outline: {doubt}",
                "corners in order, no side across another, holes inside",
                example,
            )
        return self

    def values(self, nu: float) -> cross_sections.SectionValues:
        """Return the section values of the beam."""
        return outline.outline_section(self.points, self.holes, nu)


# Defined by sizes alone, so that sections of one kind can be interpolated.
Sized = Annotated[Tube | Rod | Rectangle | Box | ISection, Field(discriminator="kind")]
Plain = Annotated[
    Tube | Rod | Rectangle | Box | ISection | CustomSection | Outline, Field(discriminator="kind")
]
