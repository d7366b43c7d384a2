"""The one idea behind every part: it lists its elementary errors once, as data, before any pose is
known.
"""

from __future__ import annotations

import functools
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    Final,
    NamedTuple,
    Protocol,
    Self,
    runtime_checkable,
)

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    ValidatorFunctionWrapHandler,
    WrapValidator,
)
from pydantic_core import PydanticCustomError

from lostmotion.errors import shown
from lostmotion.units import Quantity, Toleranced, states_tolerance

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from lostmotion.parts.term import Holding, Motion, Term


def _is_printable(text: str) -> str:
    if not text.isprintable():
        context = {
            "why": f"{shown(text)}, with a character that cannot be printed",
            "expected": "one line of printable text",
            "example": '"text"',
        }
        raise PydanticCustomError("line", "{why}", context)
    return text


# One line of displayable text without terminal control characters.
Line = Annotated[str, AfterValidator(_is_printable)]

# The quantities that parts are made of. From a file each takes text with a unit, from Python a
# number in SI as well.
Angle = Annotated[float, Quantity("rad", "0.5 arcmin")]
AngleAmount = Annotated[float, Quantity("rad", "0.5 arcmin", low=0)]
AngleDim = Annotated[
    Toleranced, Quantity("rad", "0.5 arcmin ± 0.2 arcmin", toleranced=True, any_law=True)
]
PlayDim = Annotated[Toleranced, Quantity("rad", "0.5 arcmin ± 0.2 arcmin", low=0, toleranced=True)]
Length = Annotated[float, Quantity("m", "400 mm")]
LengthAmount = Annotated[float, Quantity("m", "20 µm", low=0)]
LengthPlus = Annotated[float, Quantity("m", "40 mm", above=0, band="uniform")]
Wall = Annotated[float, Quantity("m", "3 mm", above=0, band="uniform")]
Lead = Annotated[float, Quantity("m", "10 mm", above=0)]
LengthDim = Annotated[Toleranced, Quantity("m", "400 mm ± 50 µm", toleranced=True, any_law=True)]
ClearanceDim = Annotated[
    Toleranced, Quantity("m", "40 µm ± 20 µm", low=0, toleranced=True, band="uniform")
]
Mass = Annotated[float, Quantity("kg", "2.5 kg", low=0)]
# In the file's currency; no error depends on it.
Price = Annotated[float, Quantity("", "900", low=0)]
Inertia = Annotated[float, Quantity("kg m^2", "1.4e-5 kg m^2", low=0)]
Force = Annotated[float, Quantity("N", "50 N")]
ForceAmount = Annotated[float, Quantity("N", "5 N", low=0)]
Torque = Annotated[float, Quantity("N m", "12 N m")]
TorqueAmount = Annotated[float, Quantity("N m", "12 N m", low=0)]
AngularStiffness = Annotated[
    float, Quantity("N m/rad", "12 N m/arcmin", above=0, band="log-uniform")
]
LinearStiffness = Annotated[float, Quantity("N/m", "200 N/µm", above=0, band="log-uniform")]
# A length per length: of a scale, or of the lead of a screw.
Gradient = Annotated[float, Quantity("", "50 µm/m", low=0, high=0.01)]
Share = Annotated[float, Quantity("", "10 %", low=0, high=0.33)]
# Of the friction loop of a drive, from visit to visit.
FrictionShare = Annotated[float, Quantity("", "20 %", low=0, high=1)]
# Of any solid: from fibres, which shrink, to soft polymers.
Expansion = Annotated[float, Quantity("1/K", "23e-6 1/K", low=-50e-6, high=1e-3, band="uniform")]
TemperatureDifference = Annotated[
    Toleranced, Quantity("K", "5 K ± 5 K", low=-200, high=200, toleranced=True)
]


# Default friction where none is stated, as a share of the rated torque, or else of the largest load
# that the joint holds at rest.
RATED_SHARE: Final = 0.01
HELD_SHARE: Final = 0.02
OF_RATED: Final = "1 % of the rated torque"
OF_HELD: Final = "2 % of the most that it holds at rest"
# Default scatter (±) of dry friction from drive to drive, as a share of it: an engineering
# estimate, not a measurement.
FRICTION_SCATTER: Final = 0.5
FRICTION_SCATTER_TEXT: Final = f"±{100 * FRICTION_SCATTER:g} %"


@dataclass(frozen=True, slots=True)
class Friction:
    """Load (N m or N) below which a play stays open, with its scatter (±) from drive to drive.

    reason           of an assumed load; empty for a stated one
    scatter_assumed  whether the scatter is the default, because none is stated
    """

    load: Toleranced
    reason: str = ""
    scatter_assumed: bool = False

    @classmethod
    def of_load(cls, load: float, reason: str = "") -> Self:
        """Return the friction of this size (N m or N) with the default scatter. Without friction
        there is none to assume.
        """
        return cls(Toleranced(load, FRICTION_SCATTER * load), reason, scatter_assumed=load > 0)


def _friction(value: object, quantity: ValidatorFunctionWrapHandler) -> Friction:
    """Return a stated friction, with the default scatter where its own is not stated."""
    if isinstance(value, Friction):
        return replace(value, load=quantity(value.load))
    load: Toleranced = quantity(value)
    if states_tolerance(value):
        return Friction(load)
    default = Friction.of_load(load.nominal)
    return replace(default, load=replace(default.load, law=load.law))


FrictionTorque = Annotated[
    Friction, Quantity("N m", "1 N m ± 30 %", low=0, toleranced=True), WrapValidator(_friction)
]
FrictionForce = Annotated[
    Friction, Quantity("N", "5 N ± 30 %", low=0, toleranced=True), WrapValidator(_friction)
]


class Part(BaseModel):
    """Base class of descriptions: immutable, and unknown fields are refused."""

    model_config = ConfigDict(defer_build=True, frozen=True, extra="forbid")
    # Whether several joints of a file may use the same one.
    shareable: ClassVar[bool] = True
    # Whether all its errors follow from its whole drawing, and not each from a key of its own.
    by_drawing: ClassVar[bool] = False
    # Whether its values enter the stiffness alone.
    elastic_only: ClassVar[bool] = False
    # Keys that people look for and no law reads: key to what a message expects in their place, and
    # an example.
    not_modelled: ClassVar[dict[str, tuple[str, str]]] = {}

    @classmethod
    def model_rebuild(cls, **options: Any) -> bool | None:  # noqa: ANN401 - those of pydantic
        """Complete the model as pydantic does, but for a generic one: no value is read by it, and
        pydantic asks for it whenever a parametrised one is made.
        """
        parameters = cls.__pydantic_generic_metadata__["parameters"]
        return None if parameters else super().model_rebuild(**options)

    @functools.cached_property
    def shared_name(self) -> str:
        """Return the key under which the file describes this part for several joints
        ("gearboxes.RV"); empty for a part of its own.

        Set by the reader of the file. A changed copy is no longer that part.
        """
        return ""

    def __copy__(self) -> Self:
        """Return a copy of the fields alone: cached results may not be valid for a changed copy."""
        out = super().__copy__()
        for name in set(out.__dict__) - set(type(self).model_fields):
            del out.__dict__[name]
        return out

    def __repr__(self) -> str:
        """Return the fields that were stated, without those at their defaults."""
        stated = ", ".join(
            f"{name}={getattr(self, name)!r}" for name in sorted(self.model_fields_set)
        )
        return f"{type(self).__name__.partition('[')[0]}({stated})"

    __str__ = __repr__


class ErrorSource(ABC):
    """Base class of error sources."""

    @abstractmethod
    def terms(self, motion: Motion) -> Sequence[Term]:
        """Return the terms of this part on a joint with this motion, for all poses."""

    def play_friction(self, holding: Callable[[], Holding]) -> Friction | None:  # noqa: ARG002 - most parts have no play
        """Return the friction below which this part's play stays open; None for a part without
        play.
        """
        return None

    @property
    def has_fits(self) -> bool:
        """Return whether its clearance follows from fits, which change with temperature."""
        return False

    def temperature_error(self, rise: Toleranced | None) -> tuple[str, str, str] | None:  # noqa: ARG002 - most parts do not depend on it
        """Return what was found, what is expected and an example where this part is not valid at a
        temperature rise (K); None where it is.
        """
        return None


class PartFigure(NamedTuple):
    """A figure of a part for its sheet: value in SI, unit, and a note."""

    label: str
    value: float
    unit: str = ""
    note: str = ""


@runtime_checkable
class Grouped(Protocol):
    """A part with several error sources, each listed separately in the budget."""

    @property
    def members(self) -> Mapping[str, ErrorSource]:
        """Return the sources by name."""
