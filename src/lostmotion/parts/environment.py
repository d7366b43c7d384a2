"""Surroundings of the arm: the temperature at which it works."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, ClassVar, Final, Literal

from lostmotion.parts.provenance import DEFAULT, Sourced
from lostmotion.unit_registry import ABSOLUTE, ZERO_CELSIUS
from lostmotion.units import Quantity, Toleranced

# Reference temperature of lengths on drawings (ISO 1:2022), K.
DRAWING: Final = ZERO_CELSIUS + 20.0
# Range of temperature, K, in which one expansion coefficient describes a structural material.
_COLDEST, _HOTTEST = ZERO_CELSIUS - 100.0, ZERO_CELSIUS + 200.0
Temperature = Annotated[float, Quantity(ABSOLUTE, "20 °C", low=_COLDEST, high=_HOTTEST)]
TemperatureDim = Annotated[
    Toleranced, Quantity(ABSOLUTE, "35 °C ± 5 K", low=_COLDEST, high=_HOTTEST, toleranced=True)
]


class Environment(Sourced):
    """Surroundings of the arm.

    temperature            of the whole arm at work; ± how far it differs. Default: not stated, so
                           nothing expands
    reference_temperature  at which the dimensions of the file apply and the controller's model is
                           exact
    temperature_varies     "robot": the ± is a constant difference of each robot and its site;
                           "visit": the temperature differs at every visit. It also applies to the ±
                           of the temperature differences of links
    """

    shareable: ClassVar[bool] = False
    temperature: TemperatureDim | None = None
    reference_temperature: Temperature = DRAWING
    temperature_varies: Literal["robot", "visit"] = "robot"

    @property
    def assumptions(self) -> dict[str, str]:
        """Return the values that are not stated as facts: key to reason, with the reference
        temperature of a drawing that states none.
        """
        default = (
            self.temperature is not None and "reference_temperature" not in self.model_fields_set
        )
        return {
            **super().assumptions,
            **({"reference_temperature": f"{DEFAULT}, 20 °C (ISO 1)"} if default else {}),
        }

    @property
    def rise(self) -> Toleranced | None:
        """Return the rise of the temperature above the reference temperature, K; None where no
        temperature is stated.
        """
        return (
            None
            if self.temperature is None
            else replace(
                self.temperature, nominal=self.temperature.nominal - self.reference_temperature
            )
        )
