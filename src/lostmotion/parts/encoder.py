"""The encoder that the controller believes: resolution, noise, eccentricity, zero."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Generic, Literal, Self, TypeVar

from pydantic import model_validator
from pydantic_core import PydanticCustomError

from lostmotion.laws.distributions import Normal, Uniform, of_tolerance
from lostmotion.parts.error_source import ErrorSource, Lead
from lostmotion.parts.forms import Constant
from lostmotion.parts.provenance import Sourced
from lostmotion.parts.standard_terms import harmonic_terms, limit_terms, parameter
from lostmotion.units import Distribution, Quantity, ToleranceLaw

if TYPE_CHECKING:
    from lostmotion.parts.term import Motion, Parameter, Term

AmountT = TypeVar("AmountT", bound=float)
NoiseLaw = Annotated[ToleranceLaw, Distribution(("normal", "normal without limits", "uniform"))]


class Encoder(Sourced, ErrorSource, Generic[AmountT]):
    """An encoder on the motor or on the output. On a sliding joint all its errors are lengths at the slide, whatever the ratio.

    side          "motor": on a turning joint its errors reach the output divided by the gear ratio. "output": they reach it whole,
                  and the gearbox's own errors are seen and taken away by the controller, but for the backlash that a load below the joint's
                  friction leaves open
    dead_band     on the output only: ± error that the controller leaves uncorrected. Within it, and within the backlash, a joint whose load is
                  below its friction rests anywhere; left out: anywhere within the backlash
    resolution    one count; the position is anywhere within it
    noise         ± limit of what differs from reading to reading
    noise_law     distribution of the noise: "normal", three sigma at the limit, cut there; "normal without limits", the same not cut, so that there
                  is no worst case; "uniform"; or a table of rows [value in units of the noise, probability of a smaller one]
    eccentricity  ± amplitude of the error over one turn of the encoder, its phase drawn per robot; not of a scale along a slide
    zero          ± limit of the mastering of the joint's zero, at the output
    ratio         turns of the encoder per turn of the output, or of the screw; left out, the joint's gear ratio
    lead          of the screw, on a sliding joint; left out, that of the joint's gearbox
    """

    side: Literal["motor", "output"] = "motor"
    resolution: AmountT | None = None
    noise: AmountT | None = None
    noise_law: NoiseLaw = "normal"
    eccentricity: AmountT | None = None
    zero: AmountT | None = None
    ratio: Annotated[float, Quantity("", "121", above=0)] | None = None
    lead: Lead | None = None
    dead_band: AmountT | None = None

    @model_validator(mode="after")
    def _band_is_of_the_output(self) -> Self:
        if self.dead_band is not None and self.side == "motor":
            context = {
                "why": "dead_band of an encoder on the motor",
                "expected": "an encoder on the output: one on the motor does not see the backlash",
                "example": 'encoder = { side = "output", dead_band = "10 arcsec" }',
            }
            raise PydanticCustomError("limits", "{why}", context)
        return self

    def terms(self, motion: Motion) -> list[Term]:
        """Return the errors of the value that the controller believes."""
        turns = (self.ratio or 1.0) if self.side == "motor" else 1.0
        ratio, along = turns if motion.turning else 1.0, Constant(motion.twist)
        out: list[Term] = []
        if self.resolution:
            out += limit_terms("resolution", along, self.resolution / ratio / 2, Uniform(), self._sized("resolution", motion), visit=True)
        if self.noise:
            law = of_tolerance(self.noise_law)
            out += limit_terms("noise", along, self.noise / ratio, law, self._sized("noise", motion), visit=True)
        if self.eccentricity:
            size, sized = self.eccentricity / ratio, self._sized("eccentricity", motion)
            out += harmonic_terms("eccentricity 1", "eccentricity", motion.twist, turns, size, sized, motion.turns(self.lead))
        if self.zero:
            out += limit_terms("zero", along, self.zero, Normal(), self._sized("zero", motion))
        return out

    def _sized(self, key: str, motion: Motion) -> Parameter:
        return parameter(key, getattr(self, key), motion.unit)
