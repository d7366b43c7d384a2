"""A strain wave gear: an elliptic wave generator presses a thin toothed cup, the flexspline, into a
circular spline of a few more teeth.
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Final, Literal, Self

from pydantic import model_validator

from lostmotion.laws.gears import strain_wave_ratio
from lostmotion.parts.error_source import AngleAmount
from lostmotion.parts.gearbox.counts import teeth
from lostmotion.parts.gearbox.gearbox import TurningFigures, refuse

# An ellipse meshes at both ends of its long axis.
_LOBES: Final = 2


class StrainWaveGearbox(TurningFigures):
    """A strain wave gear; data-sheet figures as in `Gearbox`, and numbers of teeth.

    flexspline_teeth, circular_spline_teeth   the circular spline has two more, or another even
                                              number
    held          "circular spline": the flexspline is the output and turns opposite to the input;
                  "flexspline": the reverse wave_generator_error  amplitude at the output of the
                  harmonic of the generator, twice per turn of the input

    Its teeth are preloaded: it has no play unless backlash or lost motion is stated. Stiffness
    zones describe its lower stiffness at small torque.
    """

    absent: ClassVar[tuple[str, ...]] = ("backlash",)
    kind: Literal["strain wave"] = "strain wave"
    flexspline_teeth: Annotated[int, teeth("200")]
    circular_spline_teeth: Annotated[int, teeth("202")]
    held: Literal["circular spline", "flexspline"] = "circular spline"
    wave_generator_error: AngleAmount = 0.0

    @property
    def ratio(self) -> float:
        """Return the turns of the wave generator per turn of the output, negative with the circular
        spline held.
        """
        return strain_wave_ratio(
            self.flexspline_teeth,
            self.circular_spline_teeth,
            flexspline_fixed=self.held == "flexspline",
        )

    @model_validator(mode="after")
    def _goes_together(self) -> Self:
        flexspline, circular = self.flexspline_teeth, self.circular_spline_teeth
        more = circular - flexspline
        if more <= 0 or more % _LOBES:
            near = max(more - more % _LOBES, _LOBES)
            raise refuse(
                f"a circular spline of {circular} teeth around a flexspline of {flexspline}",
                (
                    "a circular spline with two teeth more, or another even number: they mesh at "
                    "both ends of an ellipse"
                ),
                f"flexspline_teeth = {flexspline}, circular_spline_teeth = {flexspline + near}",
            )
        return self

    def _own_harmonics(self) -> list[tuple[str, float, float]]:
        return [("wave generator", self.wave_generator_error, _LOBES * abs(self.ratio))]
