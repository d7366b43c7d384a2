"""A link: its length and tip frame, mass, compliance, length tolerance and thermal expansion."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, ClassVar, Self

import numpy as np
from pydantic import field_validator, model_validator

from lostmotion.laws import beam
from lostmotion.laws.process_tolerance import Process, process_tolerance
from lostmotion.parts.compliance import Compliance, Measured
from lostmotion.parts.error_source import (
    Expansion,
    LengthAmount,
    LengthDim,
    Mass,
    Price,
    TemperatureDifference,
)
from lostmotion.parts.frame import Direction, Frame, Vector, unit
from lostmotion.parts.material import Material
from lostmotion.parts.mounting import TipTolerance, with_zero_tolerance
from lostmotion.parts.profile import Section, beam_of, section_error
from lostmotion.parts.provenance import DEFAULT, OfClass
from lostmotion.parts.section import Rod, refuse_section
from lostmotion.spatial import pose_of
from lostmotion.units import Toleranced

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

# Re-exported: the descriptions that a link is made of.
__all__ = ["Direction", "Frame", "Link", "Material", "Rod", "Vector", "unit"]


class Link(OfClass):
    """The body between a joint and the next one, as a beam along the straight line between them.

    length, direction   from this joint's frame to the next seat; or `tip`, the whole frame
    length_tolerance    ± limit of the distance to the next seat, where `length` does not state it
                        (a tip from DH or URDF)
    tip_tolerance       instead: ± of the next seat's frame about and along each of the tip's
                        directions, `{ tilt = [...], offset = [...] }`
    process             sets the ± limit of that distance where none is stated, by
                        `laws.process_tolerance`; it counts as assumed
    section, material   a uniform section, or one that changes along the link (stepped, tapered);
                        composite sections state their own materials
    compliance          instead of a section: matrix (6, 6) at the tip and in its axes
    measured            instead of a section: a force on the tip and the measured deflection
    rigid               true: the link is declared rigid. None of these four: the stiffness is
                        missing, and figures are lower bounds
    mass                default: that of section and material; zero with a compliance or a
                        measurement
    price               of the link, data for comparisons
    centre_of_mass      in the joint's frame; default: that of the sections, or the middle. Stated:
                        the mass is spread uniformly on both sides of it, up to the nearer end
    up                  direction across the link that the section's height follows; default: across
                        the joint's axis
    expansion           linear thermal expansion along the link, 1/K; default: that of its materials
    temperature_difference  of the side that the section's height points to, above the opposite
                            side; ± how far it differs. The link bends
    """

    shareable: ClassVar[bool] = False
    length: LengthDim = Toleranced(0.0)
    direction: Direction = "x"
    length_tolerance: LengthAmount = 0.0
    tip_tolerance: TipTolerance | None = None
    process: Process | None = None
    tip: Frame | None = None
    section: Section | None = None
    material: Material | None = None
    compliance: Compliance | None = None
    measured: Measured | None = None
    rigid: bool = False
    mass: Mass | None = None
    price: Price | None = None
    centre_of_mass: Vector | None = None
    up: Direction | None = None
    expansion: Expansion | None = None
    temperature_difference: TemperatureDifference = Toleranced(0.0)

    _zero_tolerance = model_validator(mode="before")(with_zero_tolerance)

    @field_validator("length")
    @classmethod
    def _is_a_distance(cls, length: Toleranced) -> Toleranced:
        if length.nominal < 0:
            found = f"a negative length, {1e3 * length.nominal:g} mm"
            raise refuse_section(
                found,
                "a length of at least 0; the direction says where the link points",
                'length = "400 mm", direction = "-x"',
            )
        return length

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.tip is not None and (self.length.nominal or self.length.tolerance):
            raise refuse_section(
                "both tip and length",
                "one of the two; beside a tip, length_tolerance",
                'length = "400 mm ± 50 µm"',
            )
        if self.length_tolerance and self.length.tolerance:
            raise refuse_section(
                "a tolerance both in length and in length_tolerance",
                "one of the two",
                'length = "400 mm ± 50 µm"',
            )
        if self.tip_tolerance is not None and (self.length_tolerance or self.length.tolerance):
            raise refuse_section(
                "a tolerance of the length beside tip_tolerance",
                "one of the two",
                'length_tolerance = "50 µm"',
            )
        if self.length_tolerance and not self.reach:
            raise refuse_section(
                "length_tolerance on a link of zero length",
                "a link with a length or a tip",
                'length = "400 mm ± 50 µm"',
            )
        try:
            _ = self.process_tolerance
        except ValueError as error:
            raise refuse_section(
                str(error), "a shorter link, or its length_tolerance", 'length_tolerance = "0.5 mm"'
            ) from None
        self._check_stiffness()
        if (
            self.up is not None
            and np.linalg.norm(np.cross(unit(self.up), self.tip_pose[:3, 3])) < 1e-6 * self.reach
        ):
            raise refuse_section(
                "up along the link itself", "a direction across the link", 'up = "z"'
            )
        if self.bends_with_temperature and not np.isfinite(self.thermal_expansion[:, 1]).all():
            expected = "a section of known height whose materials state their expansion"
            found = "temperature_difference of a link whose bending by it is not known"
            example = 'section = { kind = "tube", outer = "60 mm", wall = "3 mm" }, '
            example += 'material = "aluminium"' + ("" if self.reach else ', length = "400 mm"')
            raise refuse_section(found, expected, example)
        return self

    def _check_stiffness(self) -> None:
        stated = [
            name
            for name in ("section", "compliance", "measured")
            if getattr(self, name) is not None
        ]
        if len(stated) > 1:
            raise refuse_section(
                " beside ".join(stated),
                "one of section, compliance and measured",
                'section = "tube"',
            )
        if stated and self.rigid:
            raise refuse_section(f"rigid beside {stated[0]}", "one of the two", "rigid = true")
        if self.section is None and self.material is not None:
            raise refuse_section(
                "a material without a section",
                "both or neither",
                'section = { kind = "tube", outer = "60 mm", wall = "3 mm" }',
            )
        if self.section is not None:
            problem = section_error(
                self.section, self.reach, has_material=self.material is not None
            )
            if problem:
                raise refuse_section(*problem, 'material = "aluminium"')
            if self._beam_of_section is not None and any(
                each.density is None for each in self._beam_of_section[1]
            ):
                expected = (
                    "the density of every material of a link, which bends under its own weight"
                )
                raise refuse_section(
                    "a material without density", expected, 'density = "2700 kg/m^3"'
                )
        elif stated and not self.reach:
            raise refuse_section(
                f"{stated[0]} of a link of zero length",
                "a link with a length or a tip",
                'length = "400 mm"',
            )
        for bending in (self.measured, self.measured.sideways) if self.measured is not None else ():
            if bending is not None and bending.inconsistency(self.reach):
                raise refuse_section(
                    bending.inconsistency(self.reach),
                    "a deflection possible for a bar",
                    'deflection = "0.2 mm", slope = "2 arcmin"',
                )

    @property
    def process_tolerance(self) -> float:
        """Return the ± limit (m) of the length by the process that makes the link; zero where a
        limit is stated, or no process.
        """
        stated = (
            self.length.tolerance or {"length_tolerance", "tip_tolerance"} & self.model_fields_set
        )
        return (
            0.0
            if self.process is None or stated or not self.reach
            else process_tolerance(self.process, self.reach)
        )

    @property
    def assumptions(self) -> dict[str, str]:
        """Return the values that are not stated as facts: key to reason, with the tolerance by
        process.
        """
        found, limit = super().assumptions, self.process_tolerance
        return (
            {
                **found,
                "length_tolerance": (
                    f"{DEFAULT} tolerance of {self.process}, ± {1e3 * limit:.2g} mm"
                ),
            }
            if limit
            else found
        )

    @functools.cached_property
    def tip_pose(self) -> Floats:
        """Return the next seat's frame in this joint's frame (4, 4)."""
        if self.tip is not None:
            return self.tip.pose
        return pose_of(unit(self.direction) * self.length.nominal)

    @property
    def reach(self) -> float:
        """Return the straight distance from the joint to the next seat, m."""
        return float(np.linalg.norm(self.tip_pose[:3, 3]))

    @property
    def is_rigid(self) -> bool:
        """Return whether the link is assumed rigid: its stiffness is not specified, or its length
        is zero.
        """
        return not self.reach or (
            self.section is None and self.compliance is None and self.measured is None
        )

    @functools.cached_property
    def _beam_of_section(self) -> tuple[beam.Beam, tuple[Material, ...]] | None:
        """Return the beam of section and material, and the material of each of its causes."""
        return (
            beam_of(self.section, self.reach, self.material)
            if self.section is not None and self.reach
            else None
        )

    @functools.cached_property
    def total_mass(self) -> float:
        """Return the mass as stated, or that of section, length and material."""
        if self.mass is not None:
            return self.mass
        return self._beam_of_section[0].mass if self._beam_of_section is not None else 0.0

    @functools.cached_property
    def mass_centre(self) -> Floats:
        """Return the centre of mass in the joint's frame (3,), m."""
        if self.centre_of_mass is not None:
            return np.array(self.centre_of_mass)
        share = (
            self._beam_of_section[0].mass_centre / self.reach
            if self._beam_of_section is not None
            else 0.5
        )
        return np.asarray(self.tip_pose[:3, 3] * share)

    @property
    def bends_with_temperature(self) -> bool:
        """Return whether a temperature difference across the link is stated."""
        return bool(self.temperature_difference.nominal or self.temperature_difference.tolerance)

    @functools.cached_property
    def thermal_expansion(self) -> Floats:
        """Return the twist of the tip (6, 2), in beam axes, per kelvin of temperature rise and of
        difference across the link; NaN: not known.
        """
        made = self._beam_of_section
        out = np.full((6, 2), np.nan) if made is None else made[0].tip_expansion()
        if self.expansion is not None:
            out[:, 0] = [0, 0, 0, self.expansion * self.reach, 0, 0]
        return out

    @property
    def expands(self) -> bool:
        """Return whether the link has a length and a known expansion."""
        return bool(self.reach and np.isfinite(self.thermal_expansion[:, 0]).all())

    def beam_in(self, tip_from_beam: Floats) -> tuple[beam.Beam, tuple[float, ...]]:
        """Return the equivalent beam of this link, in its own axes, and the scatter of each of its
        causes.

        `tip_from_beam` (3, 3) turns those axes into the tip's. The beam of a measurement is uniform
        and has the measured tip deflection. That of a compliance is `beam_of_compliance`: exact
        under loads on the tip; under its own weight the link bends like that beam. Raises
        ValueError for a rigid link.
        """
        if self._beam_of_section is not None:
            made, materials = self._beam_of_section
            return made, tuple(material.scatter for material in materials)
        if self.is_rigid:
            raise ValueError("a rigid link has no compliance")
        if self.measured is not None:
            return beam.prism(self.reach, [self.measured.compliance_per_length(self.reach)]), (
                self.measured.scatter,
            )
        assert self.compliance is not None  # noqa: S101 - it is not rigid
        turn6 = np.kron(np.eye(2), tip_from_beam)
        return beam.beam_of_compliance(turn6.T @ self.compliance.values @ turn6, self.reach), (
            self.compliance.scatter,
        )

    def beam_axes(self, joint_axis: Floats) -> Floats:
        """Return the rotation (3, 3) whose columns are the beam's x (along), y (section's width)
        and z (height) in the joint's frame.
        """
        along = self.tip_pose[:3, 3] / self.reach
        if self.up is not None:
            height = unit(self.up)
        else:
            height = np.cross(along, joint_axis)
            if np.linalg.norm(height) < 1e-6:  # noqa: PLR2004 - the joint turns the link about its own line: any direction serves
                height = np.eye(3)[int(np.argmin(np.abs(along)))]
        across = np.cross(height, along)
        across /= np.linalg.norm(across)
        return np.column_stack([along, across, np.cross(along, across)])
