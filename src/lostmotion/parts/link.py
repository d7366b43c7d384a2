"""A link: where it leads, what it weighs, how it bends, how exactly it was made."""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Annotated, Literal, Self

import numpy as np
from pydantic import AfterValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from lostmotion.laws import beam
from lostmotion.laws.chance import Normal
from lostmotion.parts.source import (
    Angle,
    Condition,
    ErrorSource,
    Length,
    LengthAmount,
    LengthDim,
    LengthPlus,
    Line,
    Mass,
    Part,
    Share,
    Term,
    limit_term,
    toleranced_terms,
)
from lostmotion.spatial import pose_of, skew
from lostmotion.units import Quantity, Toleranced

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.spatial import Floats

Vector = Annotated[tuple[Length, Length, Length], Field(description="x, y, z, each with its unit")]


def _is_direction(stated: str | tuple[float, float, float]) -> str | tuple[float, float, float]:
    if isinstance(stated, tuple) and not (np.all(np.isfinite(stated)) and 0 < float(np.linalg.norm(stated)) < math.inf):
        context = {"why": f"the direction {list(stated)}", "expected": "a finite direction that is not zero", "example": "[0, 0, 1]"}
        raise PydanticCustomError("direction", "{why}", context)
    return stated


Direction = Annotated[Literal["x", "y", "z", "-x", "-y", "-z"] | tuple[float, float, float], AfterValidator(_is_direction)]


class Place(Part):
    """A frame seen from the frame before: xyz, then roll, pitch, yaw about the fixed x, y, z axes (as in URDF)."""

    xyz: Vector = (0.0, 0.0, 0.0)
    rpy: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)

    @functools.cached_property
    def pose(self) -> Floats:
        """Give the frame as a pose (4, 4)."""
        return pose_of(self.xyz, self.rpy)


class Material(Part):
    """What a link is made of: Young's modulus, Poisson's ratio, density."""

    young: Annotated[float, Quantity("Pa", "70 GPa", above=0)]
    poisson: Annotated[float, Quantity("", "0.33", low=0, high=0.499)]
    density: Annotated[float, Quantity("kg/m^3", "2700 kg/m^3", above=0)]
    scatter: Share = 0.0
    source: Annotated[Line, Field(max_length=300)] = ""

    @property
    def shear(self) -> float:
        """Give the shear modulus, isotropic."""
        return self.young / (2 * (1 + self.poisson))


def _refuse(why: str, expected: str, example: str) -> PydanticCustomError:
    return PydanticCustomError("section", "{why}", {"why": why, "expected": expected, "example": example})


class Tube(Part):
    """A round tube."""

    kind: Literal["tube"] = "tube"
    outer: LengthPlus
    wall: LengthPlus

    @model_validator(mode="after")
    def _wall_fits(self) -> Self:
        if self.wall > self.outer / 2:
            raise _refuse(
                f"wall {self.wall * 1e3:g} mm in a tube of {self.outer * 1e3:g} mm outside diameter",
                f"a wall of at most half the outside diameter, {self.outer * 500:g} mm",
                'outer = "60 mm", wall = "3 mm"',
            )
        return self

    def values(self, nu: float) -> beam.SectionValues:
        """Give what the beam needs."""
        return beam.round_section(self.outer, self.outer - 2 * self.wall, nu)


class Rod(Part):
    """A solid round bar."""

    kind: Literal["rod"] = "rod"
    diameter: LengthPlus

    def values(self, nu: float) -> beam.SectionValues:
        """Give what the beam needs."""
        return beam.round_section(self.diameter, 0.0, nu)


class Rectangle(Part):
    """A solid bar; width lies along the joint's axis, height across it."""

    kind: Literal["rectangle"] = "rectangle"
    width: LengthPlus
    height: LengthPlus

    def values(self, nu: float) -> beam.SectionValues:
        """Give what the beam needs."""
        return beam.rectangle_section(self.width, self.height, nu)


class Box(Part):
    """A rectangular tube; width lies along the joint's axis, height across it."""

    kind: Literal["box"] = "box"
    width: LengthPlus
    height: LengthPlus
    wall: LengthPlus

    @model_validator(mode="after")
    def _wall_fits(self) -> Self:
        least = min(self.width, self.height)
        if self.wall >= least / 2:
            raise _refuse(
                f"wall {self.wall * 1e3:g} mm in a box {self.width * 1e3:g} x {self.height * 1e3:g} mm",
                f"a wall below half of the smaller side, {least * 500:g} mm",
                'width = "50 mm", height = "60 mm", wall = "3 mm"',
            )
        return self

    def values(self, nu: float) -> beam.SectionValues:
        """Give what the beam needs."""
        return beam.box_section(self.width, self.height, self.wall, nu)


class CustomSection(Part):
    """Any section by its figures; y lies along the joint's axis, z across it and the link."""

    kind: Literal["custom"] = "custom"
    area: Annotated[float, Quantity("m^2", "540 mm^2", above=0)]
    i_y: Annotated[float, Quantity("m^4", "2.2e5 mm^4", above=0)]
    i_z: Annotated[float, Quantity("m^4", "2.2e5 mm^4", above=0)]
    torsion: Annotated[float, Quantity("m^4", "4.4e5 mm^4", above=0)]
    shear_y: Annotated[float, Quantity("", "0.5", above=0, high=1)] = 0.5
    shear_z: Annotated[float, Quantity("", "0.5", above=0, high=1)] = 0.5

    def values(self, nu: float) -> beam.SectionValues:  # noqa: ARG002 - one way to ask every section
        """Give what the beam needs; the ratio nu is already in the figures."""
        return beam.SectionValues(self.area, self.i_y, self.i_z, self.torsion, self.shear_y, self.shear_z)


Section = Annotated[Tube | Rod | Rectangle | Box | CustomSection, Field(discriminator="kind")]
_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


class Link(Part):
    """The body between a joint and the next one, as a beam along the straight line between them.

    length, direction   from this joint's frame to the next seat; or `tip`, the whole frame
    length_tolerance    ± limit of the distance to the next seat, where `length` does not carry it (a tip from DH or URDF)
    section, material   left out: the link is rigid
    mass                left out: section x length x density
    centre_of_mass      in the joint's frame; left out: half way. The mass is spread evenly on both sides of it, as far as to the nearer end
    up                  direction across the link that the section's height follows; left out: across the joint's axis
    """

    length: LengthDim = Toleranced(0.0)
    direction: Direction = "x"
    length_tolerance: LengthAmount = 0.0
    tip: Place | None = None
    section: Section | None = None
    material: Material | None = None
    mass: Mass | None = None
    centre_of_mass: Vector | None = None
    up: Direction | None = None

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.tip is not None and (self.length.nominal or self.length.tolerance):
            raise _refuse("both tip and length", "one of the two; beside a tip, length_tolerance", 'length = "400 mm ± 50 µm"')
        if self.length_tolerance and self.length.tolerance:
            raise _refuse("a tolerance both in length and in length_tolerance", "one of the two", 'length = "400 mm ± 50 µm"')
        if self.length_tolerance and not self.reach:
            raise _refuse("length_tolerance on a link that leads nowhere", "a link with a length or a tip", 'length = "400 mm ± 50 µm"')
        if (self.section is None) != (self.material is None):
            raise _refuse("a section without a material, or the reverse", "both or neither", 'material = "aluminium"')
        if self.up is not None and np.linalg.norm(np.cross(unit(self.up), self.tip_pose[:3, 3])) < 1e-6 * self.reach:
            raise _refuse("up along the link itself", "a direction across the link", 'up = "z"')
        return self

    @functools.cached_property
    def tip_pose(self) -> Floats:
        """Give the next seat's frame in this joint's frame (4, 4)."""
        if self.tip is not None:
            return self.tip.pose
        return pose_of(unit(self.direction) * self.length.nominal)

    @property
    def reach(self) -> float:
        """Give the straight distance from the joint to the next seat, m."""
        return float(np.linalg.norm(self.tip_pose[:3, 3]))

    @functools.cached_property
    def total_mass(self) -> float:
        """Give the mass as stated, or as section, length and material make it."""
        if self.mass is not None:
            return self.mass
        if self.section is None or self.material is None:
            return 0.0
        return self.section.values(self.material.poisson).area * self.reach * self.material.density

    @property
    def mass_centre(self) -> Floats:
        """Give the centre of mass in the joint's frame (3,), m."""
        return np.array(self.centre_of_mass) if self.centre_of_mass is not None else self.tip_pose[:3, 3] / 2

    def beam_axes(self, joint_axis: Floats) -> Floats:
        """Give the rotation (3, 3) whose columns are the beam's x (along), y (section's width) and z (height) in the joint's frame."""
        along = self.tip_pose[:3, 3] / self.reach
        if self.up is not None:
            height = unit(self.up)
        else:
            height = np.cross(along, joint_axis)
            if np.linalg.norm(height) < 1e-6:  # noqa: PLR2004 - the joint turns the link about itself: any side will do
                height = np.eye(3)[int(np.argmin(np.abs(along)))]
        across = np.cross(height, along)
        across /= np.linalg.norm(across)
        return np.column_stack([along, across, np.cross(along, across)])

    def with_joint_axis(self, joint_axis: Floats) -> ElasticLink:
        """Give this link as it stands behind a joint: only there is it known how its section lies."""
        return ElasticLink(self, joint_axis)


class ElasticLink(ErrorSource):
    """A link behind its joint; its terms act at the link's tip, in the tip's axes."""

    def __init__(self, link: Link, joint_axis: Floats) -> None:
        """Work out once what does not depend on the pose."""
        self.link = link
        self.tip_from_joint = link.tip_pose[:3, :3].T
        self.joint_axis = joint_axis

    def terms(self, at: Condition) -> list[Term]:
        """Bending under what hangs on the tip, bending under its own weight, and the length as made."""
        link = self.link
        out: list[Term] = []
        if link.length.tolerance:
            twist = np.concatenate([np.zeros(3), self.tip_from_joint @ unit(link.direction)])
            out += toleranced_terms("length", twist, link.length)
        elif link.length_tolerance:
            along = self.tip_from_joint @ link.tip_pose[:3, 3] / link.reach
            out.append(limit_term("length", np.concatenate([np.zeros(3), along]), link.length_tolerance, Normal()))
        if link.section is None or link.material is None or not link.reach:
            return out
        bent = at.wrench @ self.tip_compliance.T
        sagged = at.gravity @ self.own_weight_compliance.T
        out += [Term("bending under load", bent), Term("sag under own weight", sagged)]
        if link.material.scatter:
            law = Normal()
            out.append(limit_term("stiffness scatter", bent + sagged, link.material.scatter, law))
        return out

    @functools.cached_property
    def _to_tip(self) -> Floats:
        return self.tip_from_joint @ self.link.beam_axes(self.joint_axis)

    @functools.cached_property
    def tip_compliance(self) -> Floats:
        """Give the twist of the tip per wrench on it (6, 6), both in the tip's axes."""
        turn6 = np.kron(np.eye(2), self._to_tip)
        return turn6 @ self._beam(self.link.reach, beam.tip_compliance) @ turn6.T

    @functools.cached_property
    def own_weight_compliance(self) -> Floats:
        """Give the twist of the tip per gravity (6, 3), both in the tip's axes.

        The weight is spread evenly along the beam on both sides of its centre, as far as the nearer end is away: all of the beam for a centre
        half way, a point for one at an end. A centre beside the beam, or beyond its ends, adds the weight's moment there.
        """
        link = self.link
        turn6 = np.kron(np.eye(2), self._to_tip)
        if link.centre_of_mass is None:
            spread = self._beam(link.reach, beam.tip_under_own_weight) * (link.total_mass / link.reach)
            return turn6 @ spread @ self._to_tip.T
        centre = link.beam_axes(self.joint_axis).T @ link.mass_centre
        middle = min(max(float(centre[0]), 0.0), link.reach)
        arm = skew(centre - np.array([middle, 0, 0]))
        # What the tip does is a cubic of where a load acts, and two Gauss points integrate a cubic exactly.
        gauss = min(middle, link.reach - middle) / math.sqrt(3)
        halves = self._under_load_at(middle - gauss) + self._under_load_at(middle + gauss)
        return turn6 @ halves @ np.vstack([arm, np.eye(3)]) @ self._to_tip.T * (link.total_mass / 2)

    def _under_load_at(self, place: float) -> Floats:
        """Give the twist of the tip per wrench (6, 6) that acts so far along the beam (m), in the beam's axes."""
        carry = np.eye(6)
        carry[3:, :3] = -skew(np.array([self.link.reach - place, 0, 0]))  # a rotation where the load acts swings the rest of the link
        return carry @ self._beam(place, beam.tip_compliance)

    def _beam(self, length: float, law: Callable[[float, float, float, beam.SectionValues], Floats]) -> Floats:
        material, section = self.link.material, self.link.section
        if material is None or section is None:
            raise ValueError("a rigid link has no compliance")
        return law(length, material.young, material.shear, section.values(material.poisson))


def unit(direction: Direction) -> Floats:
    """Which unit vector (3,) does a direction name?"""
    if isinstance(direction, str):
        sign = -1.0 if direction.startswith("-") else 1.0
        return sign * np.array(_AXES[direction[-1]])
    vector = np.array(direction, dtype=float)
    return np.asarray(vector / math.sqrt(float(vector @ vector)))
