"""A planetary gearbox: sun in, ring held, planet carrier out."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import model_validator

from lostmotion.laws.gears import planetary_ratio
from lostmotion.parts.error_source import AngleAmount
from lostmotion.parts.gearbox.counts import MOST_PLANETS, Planets, teeth
from lostmotion.parts.gearbox.gearbox import TurningFigures, refuse


class PlanetaryGearbox(TurningFigures):
    """One planetary stage with its ring held; data-sheet figures as in `Gearbox`, and numbers of
    teeth.

    sun_teeth, ring_teeth, planet_teeth   planet_teeth default: from the other two
    planets       their number, equally spaced
    sun_error, planet_error, ring_error, mesh_error  amplitude at the output of the harmonic of
                                                     each: once per turn of the sun or of a
                  planet relative to the carrier, once per turn of the output (ring), once per tooth
                  (mesh)

    Teeth without profile shift: ring = sun + 2 x planet.
    """

    kind: Literal["planetary"] = "planetary"
    sun_teeth: Annotated[int, teeth("20")]
    ring_teeth: Annotated[int, teeth("70")]
    planet_teeth: Annotated[int, teeth("25")] | None = None
    planets: Planets = 3
    sun_error: AngleAmount = 0.0
    planet_error: AngleAmount = 0.0
    ring_error: AngleAmount = 0.0
    mesh_error: AngleAmount = 0.0

    @property
    def ratio(self) -> float:
        """Return the turns of the sun per turn of the carrier."""
        return planetary_ratio(self.sun_teeth, self.ring_teeth)

    @model_validator(mode="after")
    def _goes_together(self) -> Self:
        sun, ring = self.sun_teeth, self.ring_teeth
        fitting = (ring - sun) // 2
        if fitting < 1 or (ring - sun) % 2 or self.planet_teeth not in (None, fitting):
            planet = self.planet_teeth or max(fitting, 1)
            planets = _nearest_planets(self.planets, sun, planet)
            raise refuse(
                f"sun {sun}, ring {ring}"
                + (
                    f", planet {self.planet_teeth} teeth"
                    if self.planet_teeth
                    else " teeth, which leaves no whole planet"
                ),
                "ring = sun + 2 x planet",
                f"sun_teeth = {sun}, planet_teeth = {planet}, ring_teeth = {sun + 2 * planet}"
                + (f", planets = {planets}" if planets != self.planets else ""),
            )
        if (sun + ring) % self.planets:
            raise refuse(
                f"{self.planets} planets with sun + ring = {sun + ring} teeth",
                (
                    "a number of planets that divides sun + ring: otherwise equally spaced "
                    "planets cannot be assembled"
                ),
                f"planets = {_nearest_planets(self.planets, sun, fitting)}",
            )
        if not _have_room(self.planets, sun, fitting):
            found = f"{self.planets} planets of {fitting} teeth around a sun of {sun}"
            raise refuse(
                found,
                "planets that do not touch each other",
                f"planets = {_nearest_planets(self.planets, sun, fitting)}",
            )
        return self

    def _own_harmonics(self) -> list[tuple[str, float, float]]:
        sun, ring = self.sun_teeth, self.ring_teeth
        return [
            ("sun", self.sun_error, ring / sun),
            ("planet", self.planet_error, ring / ((ring - sun) // 2)),
            ("ring", self.ring_error, 1.0),
            ("mesh", self.mesh_error, float(ring)),
        ]


def _have_room(planets: int, sun: int, planet: int) -> bool:
    """Return whether the pitch circles of neighbouring planets do not overlap."""
    return planets == 1 or (sun + planet) * math.sin(math.pi / planets) > planet


def _nearest_planets(wanted: int, sun: int, planet: int) -> int:
    """Return the possible number of equally spaced planets that is nearest to the wanted one."""
    fit = [
        count
        for count in range(1, MOST_PLANETS + 1)
        if not 2 * (sun + planet) % count and _have_room(count, sun, planet)
    ]
    return min(fit, key=lambda count: (abs(count - wanted), count))
