"""Printed values of one model of a reducer, and the checks that they pass."""

from __future__ import annotations

import re
from typing import Annotated, Any, Final, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from lostmotion.errors import nearest, shown
from lostmotion.parts.error_source import (
    AngleAmount,
    AngularStiffness,
    FrictionTorque,
    Inertia,
    Line,
    Part,
    PlayDim,
    TorqueAmount,
)
from lostmotion.parts.gearbox.catalogue import CatalogueGearbox
from lostmotion.parts.provenance import NO_VALUES
from lostmotion.units import Quantity

Ratio = Annotated[float, Quantity("", "100", above=0)]
_RATIO: Final = re.compile(r"[0-9]{1,6}(?:\.[0-9]{1,6})?")
_BY_RATIO: Final = {
    "inertia_by_ratio": (
        "each with a moment of inertia at the input",
        'inertia_by_ratio = { "57" = "3.25e-5 kg m^2", "121" = "1.37e-5 kg m^2" }',
    ),
    "torques_by_ratio": (
        "each with rated, repeated and momentary peak torque",
        'torques_by_ratio = { "80" = ["63 N m", "137 N m", "255 N m"] }',
    ),
}
_TYPICAL: Final = 'typical = { hysteresis = "0.2 arcmin", source = "measured on 5 pieces, 2024" }'


class Typical(Part):
    """Typical values of delivered gearboxes where the maker prints only an upper limit; `source`
    states who measured or prints them.
    """

    backlash: PlayDim | None = None
    lost_motion: AngleAmount | None = None
    hysteresis: AngleAmount | None = None
    transmission_error: AngleAmount | None = None
    source: Annotated[Line, Field(min_length=1, max_length=200)]


class Printed(Part):
    """The fields of a row besides the gearbox itself."""

    models: Annotated[
        list[Annotated[Line, Field(min_length=1, max_length=40)]],
        Field(min_length=1, max_length=20),
    ]
    maker: Annotated[Line, Field(min_length=1, max_length=80)]
    ratio: Ratio | None = None
    ratio_one_of: Annotated[tuple[Ratio, ...], Field(max_length=50)] = ()
    ratio_above: Ratio | None = None
    upper_limits: Annotated[tuple[Line, ...], Field(max_length=20)] = ()
    lost_motion: AngleAmount | None = None
    moment_rigidity: AngularStiffness | None = None
    acceleration_torque: TorqueAmount | None = None
    emergency_torque: TorqueAmount | None = None
    inertia_by_ratio: Annotated[dict[Line, Inertia], Field(max_length=50)] = Field(default={})
    torques_by_ratio: Annotated[
        dict[Line, tuple[TorqueAmount, TorqueAmount, TorqueAmount]], Field(max_length=50)
    ] = Field(default={})
    printed: Annotated[Line, Field(max_length=300)] = ""
    source: Annotated[Line, Field(min_length=1, max_length=200)]
    mass_source: Annotated[Line, Field(max_length=200)] = ""
    inertia_source: Annotated[Line, Field(max_length=200)] = ""
    torque_source: Annotated[Line, Field(max_length=200)] = ""

    @model_validator(mode="after")
    def _is_of_one_class(self) -> Self:
        stated = [name for name in ("ratio", "ratio_one_of", "ratio_above") if getattr(self, name)]
        if len(stated) > 1:
            context = {
                "why": listed(stated),
                "expected": "one of them, or none for every ratio",
                "example": "ratio_above = 50",
            }
            raise PydanticCustomError("gearbox", "{why}", context)
        for key, (value, example) in _BY_RATIO.items():
            strange = [ratio for ratio in getattr(self, key) if not _RATIO.fullmatch(ratio)]
            if strange:
                context = {
                    "why": f"{shown(strange[0])} in {key}",
                    "expected": f"ratios as keys, {value}",
                    "example": example,
                }
                raise PydanticCustomError("gearbox", "{why}", context)
        return self


class CheckedRow(Printed):
    """A row with its gearbox validated key by key, as required of rows from a user's file."""

    part: CatalogueGearbox[AngleAmount, PlayDim, AngularStiffness, TorqueAmount, FrictionTorque]
    typical: Typical | None = None

    @model_validator(mode="after")
    def _typical_values_are_of_limits(self) -> Self:
        for name in (self.typical.model_fields_set if self.typical is not None else set()) - {
            "source"
        }:
            limit, typical = getattr(self.part, name), getattr(self.typical, name)
            if name not in self.upper_limits:
                context = {
                    "why": f"{name} in typical",
                    "expected": "errors named in upper_limits",
                    "example": f'upper_limits = ["{name}"]',
                }
                raise PydanticCustomError("gearbox", "{why}", context)
            if isinstance(limit, list) or _size(typical) > _size(limit):
                context = {
                    "why": f"a typical {name} above the maker's limit",
                    "expected": "at most the limit",
                    "example": _TYPICAL,
                }
                raise PydanticCustomError("gearbox", "{why}", context)
        return self

    @model_validator(mode="after")
    def _limits_are_its_own(self) -> Self:
        strange = [name for name in self.upper_limits if name not in self.part.model_fields_set]
        if strange:
            stated = sorted(self.part.model_fields_set - NO_VALUES)
            near = nearest(strange[0], stated) or next(iter(stated), "hysteresis")
            context = {
                "why": f"{shown(strange[0])} in upper_limits",
                "expected": "keys that part states",
                "example": f'upper_limits = ["{near}"]',
            }
            raise PydanticCustomError("gearbox", "{why}", context)
        return self


def _size(amount: Any) -> float:  # noqa: ANN401 - an amount with or without its tolerance
    return float(getattr(amount, "nominal", amount) or 0.0)


def listed(names: list[str]) -> str:
    """Return names as a list in words: "a, b and c"."""
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
