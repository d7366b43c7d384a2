"""Encoder errors: resolution, noise, eccentricity and zero offset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Generic, Literal, Self, TypeVar

from pydantic import model_validator
from pydantic_core import PydanticCustomError

from lostmotion.distribution_table import Distribution, ToleranceLaw
from lostmotion.laws.distributions import Normal, Uniform, of_tolerance
from lostmotion.parts.error_source import ErrorSource, Gradient, Lead
from lostmotion.parts.forms import Constant
from lostmotion.parts.provenance import OfClass
from lostmotion.parts.standard_terms import (
    harmonic_terms,
    limit_terms,
    parameter,
    proportional_terms,
)
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.parts.term import Motion, Parameter, Term

AmountT = TypeVar("AmountT", bound=float)
NoiseLaw = Annotated[ToleranceLaw, Distribution(("normal", "normal without limits", "uniform"))]


class Encoder(OfClass, ErrorSource, Generic[AmountT]):
    """An encoder on the motor or on the output. On a sliding joint all its errors are lengths at
    the slide, whatever the ratio.

    side          "motor": on a turning joint its errors reach the output divided by the gear ratio.
                  "output": they reach it undivided, and the controller corrects the gearbox's
                  errors, except for the backlash that stays open under a load below the joint's
                  friction
    dead_band     on the output only: ± error that the controller does not correct. A joint whose
                  load is below its friction rests anywhere within the dead band and within the
                  backlash; default: anywhere within the backlash
    resolution    one count; the position is uniformly distributed within it
    noise         ± limit of the variation between readings
    noise_law     distribution of the noise: "normal", truncated at the limit of three sigma;
                  "normal without limits", not truncated, so that there is no worst case; "uniform";
                  or a table of rows [value in units of the noise, probability of a smaller one]
    eccentricity  ± amplitude of the error over one turn of the encoder, with a random phase per
                  robot; not for a linear scale
    zero          ± limit of the joint's zero offset after mastering, at the output
    scale_error   of a linear scale, on a sliding joint only: ± share by which its graduation is too
                  long or too short, from the joint's zero
    ratio         turns of the encoder per turn of the output, or of the screw; default: the joint's
                  gear ratio
    lead          of the screw, on a sliding joint; default: the lead of the joint's gearbox
    """

    side: Literal["motor", "output"] = "motor"
    resolution: AmountT | None = None
    noise: AmountT | None = None
    noise_law: NoiseLaw = "normal"
    eccentricity: AmountT | None = None
    zero: AmountT | None = None
    scale_error: Gradient | None = None
    ratio: Annotated[float, Quantity("", "121", above=0)] | None = None
    lead: Lead | None = None
    dead_band: AmountT | None = None

    @model_validator(mode="after")
    def _band_is_of_the_output(self) -> Self:
        if self.dead_band is not None and self.side == "motor":
            context = {
                "why": "dead_band of an encoder on the motor",
                "expected": (
                    "an encoder on the output: an encoder on the motor does not measure the "
                    "backlash"
                ),
                "example": 'encoder = { side = "output", dead_band = "10 arcsec" }',
            }
            raise PydanticCustomError("limits", "{why}", context)
        return self

    @property
    def turns(self) -> float:
        """Return the turns of the encoder per turn of the output, or of the screw: one where the
        encoder is on the output.
        """
        return (self.ratio or 1.0) if self.side == "motor" else 1.0

    def terms(self, motion: Motion) -> list[Term]:
        """Return the errors of the position that the encoder reports."""
        turns = self.turns
        ratio, along = turns if motion.turning else 1.0, Constant(motion.twist)
        out: list[Term] = []
        if self.resolution:
            out += limit_terms(
                "resolution",
                along,
                self.resolution / ratio / 2,
                Uniform(),
                self._sized("resolution", motion),
                visit=True,
            )
        if self.noise:
            law = of_tolerance(self.noise_law)
            out += limit_terms(
                "noise", along, self.noise / ratio, law, self._sized("noise", motion), visit=True
            )
        if self.eccentricity:
            size, sized = self.eccentricity / ratio, self._sized("eccentricity", motion)
            out += harmonic_terms(
                "eccentricity 1",
                "eccentricity",
                motion.twist,
                turns,
                size,
                sized,
                motion.turns(self.lead),
            )
        if self.zero:
            out += limit_terms("zero", along, self.zero, Normal(), self._sized("zero", motion))
        if self.scale_error:
            out += proportional_terms(
                "scale error",
                motion,
                self.scale_error,
                parameter("scale_error", self.scale_error, ""),
                "scale error",
            )
        return out

    def _sized(self, key: str, motion: Motion) -> Parameter:
        return parameter(key, getattr(self, key), motion.unit)
