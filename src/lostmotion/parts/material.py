"""Elastic properties, density and thermal expansion of a material."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Final, Self

from pydantic import Field, model_validator

from lostmotion.band import limits_of
from lostmotion.parts.error_source import Expansion, Line, Share
from lostmotion.parts.provenance import Sourced
from lostmotion.parts.section import refuse_section
from lostmotion.units import Quantity

_INCOMPRESSIBLE: Final = 0.499


class Material(Sourced):
    """Material of a link: Young's modulus along it, Poisson's ratio, density.

    name           parts whose materials are equal in name and values are of one batch: a range in it has one value for all of them
    shear_modulus  of an anisotropic material (laminate, 3D print); default: the isotropic value young / (2 (1 + poisson))
    scatter        ± variation of both moduli between parts, as a share
    expansion      linear thermal expansion along the link, 1/K; default: not stated, so the expansion is not counted
    """

    elastic_only: ClassVar[bool] = True
    name: Annotated[Line, Field(max_length=80)] = ""
    young: Annotated[float, Quantity("Pa", "70 GPa", above=0, band="log-uniform")]
    poisson: Annotated[float, Quantity("", "0.33", low=0, high=0.95, band="uniform")]
    density: Annotated[float, Quantity("kg/m^3", "2700 kg/m^3", above=0, band="uniform")]
    shear_modulus: Annotated[float, Quantity("Pa", "26 GPa", above=0, band="log-uniform")] | None = None
    scatter: Share = 0.0
    expansion: Expansion | None = None

    @model_validator(mode="after")
    def _poisson_is_isotropic(self) -> Self:
        largest = limits_of(self.poisson)[1]
        if self.shear_modulus is None and largest > _INCOMPRESSIBLE:
            why = f"poisson {largest:g}, out of range for an isotropic material"
            raise refuse_section(why, "at most 0.499, or the shear_modulus of a laminate", 'poisson = 0.75, shear_modulus = "33 GPa"')
        return self

    @property
    def shear(self) -> float:
        """Return the shear modulus, as stated or isotropic."""
        return self.young / (2 * (1 + self.poisson)) if self.shear_modulus is None else self.shear_modulus


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
    changed = {name: after for name, before in values.items() if (after := with_material(before, old, new)) != before}
    return part.model_copy(update=changed) if changed else part
