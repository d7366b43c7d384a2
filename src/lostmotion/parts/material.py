"""Elastic properties, density and thermal expansion of a material."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Final, Literal, Self

from pydantic import Field, model_validator

from lostmotion.band import limits_of
from lostmotion.laws.polymers import REFERENCE, creep_factor, temperature_factor
from lostmotion.parts.environment import Temperature
from lostmotion.parts.error_source import Expansion, Line, Share
from lostmotion.parts.provenance import Sourced
from lostmotion.parts.section import refuse_section
from lostmotion.unit_registry import ABSOLUTE
from lostmotion.units import Quantity

_INCOMPRESSIBLE: Final = 0.499
# Of one modulus in another.
Ratio = Annotated[float, Quantity("", "0.7", above=0, high=1, band="log-uniform")]
# What a printing process leaves open of a part whose drawing does not state it; other processes
# make solid, isotropic parts. [M 75]: of FFF data sheets, 0.4 to 0.7 across the layers with carbon
# or glass fibres, 0.8 to 1 without.
USUAL: Final[dict[str, dict[str, str]]] = {
    "FFF": {"across_layers": "0.4 .. 1", "infill": "0.5 .. 1"},
    "SLA": {},
    "SLS": {},
    "MJF": {},
}


class Material(Sourced):
    """Material of a part: Young's modulus, Poisson's ratio, density; of a link along it, of a
    printed part along its layers.

    name           parts whose materials are equal in name and values are of one batch: a range in
                   it has one value for all of them
    shear_modulus  of an anisotropic material (laminate, 3D print); default: the isotropic value
                   young / (2 (1 + poisson))
    density        of a link's material only; default: not stated, as in the drawing of a gearbox
    scatter        ± variation of both moduli between parts, as a share
    expansion      linear thermal expansion along the link, 1/K; default: not stated, so the
                   expansion is not counted
    process        of a printed part. "FFF" leaves the next two open, unless stated: 0.4 .. 1 and
                   0.5 .. 1
    across_layers  modulus across the layers over young, which shafts and pins have, because they
                   are printed standing; default: 1
    infill         modulus of a plate of walls and infill (disc, ring, housing) over young; default:
                   1
    load_time      how long the load acts; with creep: the modulus after 1 h and after 1 000 h, over
                   that of a short test
    temperature    of the part; with heat_deflection, the temperature (ISO 75, 0.45 MPa) at which
                   half of the modulus is left
    """

    elastic_only: ClassVar[bool] = True
    name: Annotated[Line, Field(max_length=80)] = ""
    young: Annotated[float, Quantity("Pa", "70 GPa", above=0, band="log-uniform")]
    poisson: Annotated[float, Quantity("", "0.33", low=0, high=0.95, band="uniform")]
    density: Annotated[float, Quantity("kg/m^3", "2700 kg/m^3", above=0, band="uniform")] | None = (
        None
    )
    shear_modulus: (
        Annotated[float, Quantity("Pa", "26 GPa", above=0, band="log-uniform")] | None
    ) = None
    scatter: Share = 0.0
    expansion: Expansion | None = None
    process: Literal["FFF", "SLA", "SLS", "MJF"] | None = None
    across_layers: Ratio = 1.0
    infill: Ratio = 1.0
    load_time: Annotated[float, Quantity("s", "1000 h", above=0)] | None = None
    creep: tuple[Ratio, Ratio] | None = None
    temperature: Temperature | None = None
    heat_deflection: (
        Annotated[float, Quantity(ABSOLUTE, "145 °C", low=REFERENCE + 10, high=REFERENCE + 500)]
        | None
    ) = None

    @model_validator(mode="before")
    @classmethod
    def _of_process(cls, stated: Any) -> Any:  # noqa: ANN401 - whatever a file holds
        """Take what the process leaves open where it is not stated, as assumed values."""
        process = stated.get("process") if isinstance(stated, dict) else None
        usual = (
            {key: value for key, value in USUAL.get(process, {}).items() if key not in stated}
            if isinstance(process, str)
            else {}
        )
        assumed = stated.get("assumed", ()) if usual else ()
        return (
            {**stated, **usual, "assumed": [*assumed, *usual]}
            if usual and isinstance(assumed, list | tuple)
            else stated
        )

    @model_validator(mode="after")
    def _softens_as_stated(self) -> Self:
        if self.load_time is not None and self.creep is None:
            example = 'load_time = "1000 h", creep = [0.92, 0.79]'
            raise refuse_section(
                "a load_time without creep",
                "the creep factors after 1 h and 1 000 h beside it",
                example,
            )
        if self.temperature is None:
            return self
        if self.heat_deflection is None or self.temperature > self.heat_deflection:
            why = (
                "a temperature without heat_deflection"
                if self.heat_deflection is None
                else "a temperature above heat_deflection"
            )
            raise refuse_section(
                why,
                "a temperature below that of heat deflection",
                'temperature = "50 °C", heat_deflection = "145 °C"',
            )
        return self

    @model_validator(mode="after")
    def _poisson_is_isotropic(self) -> Self:
        largest = limits_of(self.poisson)[1]
        if self.shear_modulus is None and largest > _INCOMPRESSIBLE:
            why = f"poisson {largest:g}, out of range for an isotropic material"
            raise refuse_section(
                why,
                "at most 0.499, or the shear_modulus of a laminate",
                'poisson = 0.75, shear_modulus = "33 GPa"',
            )
        return self

    @property
    def shear(self) -> float:
        """Return the shear modulus, as stated or isotropic, under the stated load time and
        temperature.
        """
        stated = (
            self.young / (2 * (1 + self.poisson))
            if self.shear_modulus is None
            else self.shear_modulus
        )
        return stated * self._softer

    @property
    def modulus(self) -> float:
        """Return Young's modulus (Pa) under the stated load time and temperature."""
        return self.young * self._softer

    @property
    def plate_modulus(self) -> float:
        """Return the modulus (Pa) of a plate in its plane, with its infill."""
        return self.modulus * self.infill

    @property
    def standing_modulus(self) -> float:
        """Return the modulus (Pa) along a part that is printed standing, across its layers."""
        return self.modulus * self.across_layers

    @property
    def _softer(self) -> float:
        """Return the moduli over those of a short test at 23 °C."""
        out = 1.0
        if self.load_time is not None and self.creep is not None:
            out *= creep_factor(self.load_time, *self.creep)
        if self.temperature is not None and self.heat_deflection is not None:
            out *= temperature_factor(self.temperature, self.heat_deflection)
        return out


def with_material(part: Any, old: Material, new: Material) -> Any:  # noqa: ANN401 - a part, or a list, tuple or mapping of parts, of any class
    """Return a part with another material in every place of one that is equal to `old`."""
    if isinstance(part, Material):
        return new if part == old else part
    if isinstance(part, list | tuple):
        return type(part)(with_material(each, old, new) for each in part)
    if isinstance(part, dict):
        return {key: with_material(each, old, new) for key, each in part.items()}
    if not isinstance(part, Sourced):
        return part
    values = {name: getattr(part, name) for name in type(part).model_fields}
    changed = {
        name: after
        for name, before in values.items()
        if (after := with_material(before, old, new)) != before
    }
    return part.model_copy(update=changed) if changed else part
