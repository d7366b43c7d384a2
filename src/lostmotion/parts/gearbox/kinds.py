"""Which gearboxes may a joint have? A new kind is one file here and one line below."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Final, TypeAlias, TypeGuard

from pydantic import BeforeValidator, Field

from lostmotion.parts.error_source import (
    AngleAmount,
    AngularStiffness,
    ClearanceDim,
    ForceAmount,
    LengthAmount,
    LinearStiffness,
    PlayDim,
    TorqueAmount,
)
from lostmotion.parts.gearbox.catalogue import CatalogueGearbox
from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
from lostmotion.parts.gearbox.gearbox import Gearbox
from lostmotion.parts.gearbox.planetary import PlanetaryGearbox
from lostmotion.parts.gearbox.strain_wave import StrainWaveGearbox
from lostmotion.parts.gearbox.wolfrom import WolfromGearbox
from lostmotion.parts.gearbox.worm import WormGearbox

if TYPE_CHECKING:
    from typing_extensions import TypeIs

# What a gearbox is that does not say its kind.
DEFAULT_KIND: Final = "catalogue"


def _of_default_kind(stated: Any) -> Any:  # noqa: ANN401 - whatever a file holds
    return {"kind": DEFAULT_KIND, **stated} if isinstance(stated, dict) else stated


# What the rest of the package asks of a kind: to be an ErrorSource, or to have `members` (`source.Grouped`), and its `ratio`, turns of the input
# per turn of the output, negative where they go opposite ways.
_StatedTurning: TypeAlias = (
    CatalogueGearbox[AngleAmount, PlayDim, AngularStiffness, TorqueAmount] | PlanetaryGearbox | WolfromGearbox | StrainWaveGearbox | WormGearbox
)
TurningGearbox = Annotated[_StatedTurning | CycloidalGearbox, Field(discriminator="kind"), BeforeValidator(_of_default_kind)]
SlidingDrive: TypeAlias = CatalogueGearbox[LengthAmount, ClearanceDim, LinearStiffness, ForceAmount]
# By the figures that makers print, on a turning or a sliding joint; and of any kind.
StatedGearbox: TypeAlias = _StatedTurning | SlidingDrive
AnyGearbox: TypeAlias = StatedGearbox | CycloidalGearbox


# Checkers of types have no name for a class of Pydantic with its fields' types filled in.
_SLIDES: Final[type[Any]] = SlidingDrive


def is_gearbox(part: object) -> TypeGuard[AnyGearbox]:
    """Return whether a part is a gearbox."""
    return isinstance(part, Gearbox | CycloidalGearbox)


def is_drawn(gearbox: object) -> TypeIs[CycloidalGearbox]:
    """Return whether a gearbox is given by its drawing and not by stated figures."""
    return isinstance(gearbox, CycloidalGearbox)


def is_sliding(gearbox: object) -> bool:
    """Return whether a gearbox is the drive of a sliding joint, whose amounts are lengths and forces."""
    return isinstance(gearbox, _SLIDES)
