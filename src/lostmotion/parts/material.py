"""What a part is made of."""

from __future__ import annotations

from typing import Annotated, Final, Self

from pydantic import model_validator

from lostmotion.parts.error_source import Share
from lostmotion.parts.provenance import Sourced
from lostmotion.parts.section import refuse_section
from lostmotion.units import Quantity

_INCOMPRESSIBLE: Final = 0.499


class Material(Sourced):
    """What a link is made of: Young's modulus along it, Poisson's ratio, density.

    shear_modulus  of what is not alike to all sides, a laminate or a print; left out: young / (2 (1 + poisson))
    scatter        ± share by which both moduli differ from part to part
    """

    young: Annotated[float, Quantity("Pa", "70 GPa", above=0)]
    poisson: Annotated[float, Quantity("", "0.33", low=0, high=0.95)]
    density: Annotated[float, Quantity("kg/m^3", "2700 kg/m^3", above=0)]
    shear_modulus: Annotated[float, Quantity("Pa", "26 GPa", above=0)] | None = None
    scatter: Share = 0.0

    @model_validator(mode="after")
    def _is_alike_to_all_sides(self) -> Self:
        if self.shear_modulus is None and self.poisson > _INCOMPRESSIBLE:
            why = f"poisson {self.poisson:g}, out of range for a material alike to all sides"
            raise refuse_section(why, "at most 0.499, or the shear_modulus of a laminate", 'poisson = 0.75, shear_modulus = "33 GPa"')
        return self

    @property
    def shear(self) -> float:
        """Give the shear modulus, as stated or isotropic."""
        return self.young / (2 * (1 + self.poisson)) if self.shear_modulus is None else self.shear_modulus
