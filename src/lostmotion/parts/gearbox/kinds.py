"""Gearboxes that a joint may have: every kind of which the package `parts.gearbox` has a line, and
those of other packages.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Annotated, Any, Final, TypeAlias, TypeGuard, Union

from pydantic import BeforeValidator, Field, TypeAdapter

from lostmotion.parts import gearbox as package
from lostmotion.parts.error_source import (
    AngleAmount,
    AngularStiffness,
    ClearanceDim,
    ForceAmount,
    FrictionForce,
    FrictionTorque,
    LengthAmount,
    LinearStiffness,
    PlayDim,
    TorqueAmount,
)
from lostmotion.parts.gearbox.catalogue import CatalogueGearbox
from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
from lostmotion.parts.gearbox.gearbox import Gearbox, TurningFigures
from lostmotion.parts.gearbox.slide import SlideFigures
from lostmotion.parts.kinds import kinds_of_extensions

if TYPE_CHECKING:
    from collections.abc import Mapping

    from typing_extensions import TypeIs

# The kind of a gearbox that states none.
DEFAULT_KIND: Final = "catalogue"


def _of_default_kind(stated: Any) -> Any:  # noqa: ANN401 - whatever a file holds
    return {"kind": DEFAULT_KIND, **stated} if isinstance(stated, dict) else stated


_Slide: TypeAlias = CatalogueGearbox[
    LengthAmount, ClearanceDim, LinearStiffness, ForceAmount, FrictionForce
]
# Kinds described by data-sheet figures, on a turning joint and on a sliding one.
if TYPE_CHECKING:
    _StatedTurning: TypeAlias = TurningFigures
    _StatedSliding: TypeAlias = _Slide | SlideFigures
else:
    _OWN = [each for each in vars(package).values() if isinstance(each, type)]
    _ALL = [*_OWN, *kinds_of_extensions(_OWN, TurningFigures, SlideFigures)]
    _TURNING = [each for each in _ALL if issubclass(each, TurningFigures)]
    _StatedTurning = Union[
        (
            CatalogueGearbox[AngleAmount, PlayDim, AngularStiffness, TorqueAmount, FrictionTorque],
            *_TURNING,
        )
    ]
    _StatedSliding = Union[(_Slide, *(each for each in _ALL if issubclass(each, SlideFigures)))]
TurningGearbox = Annotated[
    _StatedTurning | CycloidalGearbox,
    Field(discriminator="kind"),
    BeforeValidator(_of_default_kind),
]
SlidingDrive = Annotated[
    _StatedSliding, Field(discriminator="kind"), BeforeValidator(_of_default_kind)
]
# Described by data-sheet figures, on a turning or a sliding joint; and of any kind.
StatedGearbox: TypeAlias = _StatedTurning | _StatedSliding
AnyGearbox: TypeAlias = StatedGearbox | CycloidalGearbox


@functools.cache
def _turning() -> TypeAdapter[Any]:
    return TypeAdapter(TurningGearbox)  # its schema, of many kinds, takes 30 ms to build


def turning_gearbox(stated: Mapping[str, Any]) -> TurningGearbox:
    """Return the gearbox of a turning joint with these keys and values as in a file; raises
    pydantic's ValidationError where they describe none.
    """
    found: TurningGearbox = _turning().validate_python(stated, context={"text": True})
    return found


# Type checkers cannot express isinstance with a parametrised Pydantic class.
_SLIDES: Final[tuple[type[Any], ...]] = (_Slide, SlideFigures)


def is_gearbox(part: object) -> TypeGuard[AnyGearbox]:
    """Return whether a part is a gearbox."""
    return isinstance(part, Gearbox | CycloidalGearbox)


def is_drawn(gearbox: object) -> TypeIs[CycloidalGearbox]:
    """Return whether a gearbox is given by its drawing and not by stated figures."""
    return isinstance(gearbox, CycloidalGearbox)


def is_sliding(gearbox: object) -> bool:
    """Return whether a gearbox is the drive of a sliding joint, whose quantities are lengths and
    forces.
    """
    return isinstance(gearbox, _SLIDES)
