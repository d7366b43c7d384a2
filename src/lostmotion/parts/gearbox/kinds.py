"""Which gearboxes may a joint have? A new kind is one file here and one line below."""

from __future__ import annotations

from typing import Annotated, Any, Final

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
from lostmotion.parts.gearbox.planetary import PlanetaryGearbox
from lostmotion.parts.gearbox.strain_wave import StrainWaveGearbox
from lostmotion.parts.gearbox.wolfrom import WolfromGearbox
from lostmotion.parts.gearbox.worm import WormGearbox

# What a gearbox is that does not say its kind.
DEFAULT_KIND: Final = "catalogue"


def _of_default_kind(stated: Any) -> Any:  # noqa: ANN401 - whatever a file holds
    return {"kind": DEFAULT_KIND, **stated} if isinstance(stated, dict) else stated


# What the rest of the package asks of a kind: to be an ErrorSource, or to have `members` (`source.Grouped`), and its `ratio`, turns of the input
# per turn of the output, negative where they go opposite ways.
TurningGearbox = Annotated[
    CatalogueGearbox[AngleAmount, PlayDim, AngularStiffness, TorqueAmount]
    | CycloidalGearbox
    | PlanetaryGearbox
    | WolfromGearbox
    | StrainWaveGearbox
    | WormGearbox,
    Field(discriminator="kind"),
    BeforeValidator(_of_default_kind),
]
SlidingDrive = CatalogueGearbox[LengthAmount, ClearanceDim, LinearStiffness, ForceAmount]
