"""A Wolfrom (3K) gearbox: sun in, one ring held, a second ring out, stepped planets between them on
a carrier that runs free.
"""

from __future__ import annotations

from typing import Annotated, Final, Literal, Self

from pydantic import model_validator

from lostmotion.laws.gears import planetary_ratio, wolfrom_ratio
from lostmotion.parts.error_source import AngleAmount, PartFigure
from lostmotion.parts.gearbox.counts import MOST_PLANETS, Planets, teeth
from lostmotion.parts.gearbox.gearbox import TurningFigures, refuse

_RING: Final = "a ring with more teeth than the wheel in it"


class WolfromGearbox(TurningFigures):
    """A planetary gearbox of high ratio; data-sheet figures as in `Gearbox`, and numbers of teeth.

    sun_teeth, planet_teeth, fixed_ring_teeth   the planet's wheel between sun and held ring
    output_planet_teeth, output_ring_teeth      its other wheel, in the ring that is the output
    planets       their number, equally spaced
    sun_error, planet_error, first_mesh_error, second_mesh_error  amplitude at the output of the
                                                                  harmonic of each: once per turn of
                                                                  the sun
                  or of a planet relative to the carrier, once per tooth of the held or of the
                  output ring

    Such wheels are often profile-shifted, so that numbers of teeth do not determine whether they
    mesh: this is not checked.
    """

    kind: Literal["wolfrom"] = "wolfrom"
    sun_teeth: Annotated[int, teeth("18")]
    planet_teeth: Annotated[int, teeth("36")]
    fixed_ring_teeth: Annotated[int, teeth("90")]
    output_planet_teeth: Annotated[int, teeth("33")]
    output_ring_teeth: Annotated[int, teeth("87")]
    planets: Planets = 3
    sun_error: AngleAmount = 0.0
    planet_error: AngleAmount = 0.0
    first_mesh_error: AngleAmount = 0.0
    second_mesh_error: AngleAmount = 0.0

    @property
    def ratio(self) -> float:
        """Return the turns of the sun per turn of the output ring, negative for opposite
        directions.
        """
        return wolfrom_ratio(
            self.sun_teeth,
            self.planet_teeth,
            self.fixed_ring_teeth,
            self.output_planet_teeth,
            self.output_ring_teeth,
        )

    @property
    def carrier_turns(self) -> float:
        """Return the turns of the carrier per turn of the output ring."""
        return self.ratio / planetary_ratio(self.sun_teeth, self.fixed_ring_teeth)

    @model_validator(mode="after")
    def _goes_together(self) -> Self:
        sun, planet, fixed = self.sun_teeth, self.planet_teeth, self.fixed_ring_teeth
        second, out = self.output_planet_teeth, self.output_ring_teeth
        if fixed <= planet:
            # so that the planets can be assembled as well
            near = planet + 1 + -(sun + planet + 1) % self.planets
            raise refuse(
                f"a fixed ring of {fixed} teeth around a planet of {planet}",
                _RING,
                f"fixed_ring_teeth = {near}",
            )
        if out <= second:
            near = second + 1 if planet * (second + 1) != fixed * second else second + 2
            raise refuse(
                f"an output ring of {out} teeth around a planet of {second}",
                _RING,
                f"output_ring_teeth = {near}",
            )
        if planet * out == fixed * second:
            raise refuse(
                (
                    f"an output that stands still: {fixed}/{planet} = {out}/{second}, both rings "
                    "drive the planets at the same speed"
                ),
                "rings whose ratios to their planets differ",
                f"output_ring_teeth = {out + 1}",
            )
        if (sun + fixed) % self.planets:
            near = min(
                (n for n in range(1, MOST_PLANETS + 1) if not (sun + fixed) % n),
                key=lambda n: (abs(n - self.planets), n),
            )
            raise refuse(
                f"{self.planets} planets with sun + fixed ring = {sun + fixed} teeth",
                (
                    "a number of planets that divides sun + fixed ring: otherwise equally spaced "
                    "planets cannot be assembled"
                ),
                f"planets = {near}",
            )
        return self

    @property
    def own_figures(self) -> list[PartFigure]:
        """Return the turns of the carrier."""
        return [PartFigure("turns of the carrier per turn of the output", self.carrier_turns)]

    def _own_harmonics(self) -> list[tuple[str, float, float]]:
        carrier = abs(self.carrier_turns)
        return [
            ("sun", self.sun_error, carrier * self.fixed_ring_teeth / self.sun_teeth),
            ("planet", self.planet_error, carrier * self.fixed_ring_teeth / self.planet_teeth),
            ("first mesh", self.first_mesh_error, carrier * self.fixed_ring_teeth),
            (
                "second mesh",
                self.second_mesh_error,
                abs(1 - self.carrier_turns) * self.output_ring_teeth,
            ),
        ]
