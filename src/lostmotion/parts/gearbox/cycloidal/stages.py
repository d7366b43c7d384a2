"""One or two stages of a cycloidal gearbox, its frame and input shaft, every dimension with its
tolerance.
"""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, model_validator

from lostmotion.laws.cycloid.geometry import ratio as ratio_of
from lostmotion.laws.cycloid.shaft import twist
from lostmotion.parts.error_source import (
    AngularStiffness,
    ClearanceDim,
    FrictionShare,
    FrictionTorque,
    Inertia,
    LengthPlus,
    Line,
    LinearStiffness,
    Mass,
    Price,
)
from lostmotion.parts.gearbox.counts import Whole
from lostmotion.parts.gearbox.cycloidal.frame import GearboxFrame  # noqa: TC001 - read by pydantic
from lostmotion.parts.gearbox.cycloidal.names import OUTSIDE, STAGE_MEMBERS
from lostmotion.parts.gearbox.cycloidal.shaft import Shaft
from lostmotion.parts.gearbox.cycloidal.stage import CycloidalStage
from lostmotion.parts.gearbox.gearbox import refuse
from lostmotion.parts.provenance import Sourced
from lostmotion.units import Quantity, Toleranced

Torque = Annotated[float, Quantity("N m", "412 N m", above=0)]
Teeth = Annotated[int, Whole("", "16", low=6, high=1000)]
# Pressure angle of the involute flanks.
_PRESSURE_ANGLE = math.radians(20)


class PlanetaryFirstStage(Sourced):
    """A planetary first stage: a sun drives planets, each on a crankshaft (as in an RV reducer).

    play            along the pitch circle, between sun and planet
    mesh_stiffness  of one sun-planet mesh along its line of action; for steel about 14 to 20 N/(µm
                    mm) of face width (ISO 6336-1)
    """

    kind: Literal["planetary"] = "planetary"
    sun_teeth: Teeth
    planet_teeth: Teeth
    module: LengthPlus
    planets: Annotated[int, Whole("", "2", low=1, high=12)] = 2
    play: ClearanceDim = Toleranced(0.0)
    mesh_stiffness: LinearStiffness | None = None

    @property
    def step(self) -> float:
        """Return the reduction: turns of the sun per turn of a planet, with the carrier held."""
        return self.planet_teeth / self.sun_teeth

    @property
    def sun_radius(self) -> float:
        """Return the sun's pitch radius (m)."""
        return self.sun_teeth * self.module / 2

    @property
    def compliance(self) -> float:
        """Return the rotation of the sun per torque on it (rad/(N m)), with the load shared equally
        by all planets.
        """
        if self.mesh_stiffness is None:
            return 0.0
        return 1 / (
            self.planets * self.mesh_stiffness * math.cos(_PRESSURE_ANGLE) ** 2 * self.sun_radius**2
        )


class CycloidalFirstStage(CycloidalStage):
    """A cycloidal first stage: its disc drives the crank of the second stage."""

    kind: Literal["cycloidal"] = "cycloidal"


class CycloidalStages(CycloidalStage):
    """The stages of a cycloidal gearbox, with what is around them; `CycloidalGearbox` lists its
    fields.
    """

    by_drawing: ClassVar[bool] = True
    may_be_rigid: ClassVar[tuple[str, ...]] = (*STAGE_MEMBERS, *OUTSIDE)
    kind: Literal["cycloidal"] = "cycloidal"
    model: Annotated[Line, Field(max_length=80)] = ""
    rated_torque: Torque
    fixed: Literal["ring", "carrier"] = "ring"
    first_stage: (
        Annotated[PlanetaryFirstStage | CycloidalFirstStage, Field(discriminator="kind")] | None
    ) = None
    frame: AngularStiffness | GearboxFrame | None = None
    input_shaft: AngularStiffness | None = None
    friction_torque: FrictionTorque | None = None
    hysteresis_scatter: FrictionShare = 0.0
    mass: Mass | None = None
    price: Price | None = None
    inertia: Inertia | None = None

    @model_validator(mode="after")
    def _stages_fit(self) -> Self:
        if isinstance(self.first_stage, PlanetaryFirstStage) and self.eccentric.cranks not in (
            1,
            self.first_stage.planets,
        ):
            raise refuse(
                f"{self.first_stage.planets} planets on {self.eccentric.cranks} cranks",
                "a planet on every crankshaft",
                f"first_stage = {{ planets = {self.eccentric.cranks} }}",
            )
        return self

    @property
    def cycloidal_first_stage(self) -> CycloidalFirstStage | None:
        """Return the first stage where it is cycloidal."""
        return self.first_stage if isinstance(self.first_stage, CycloidalFirstStage) else None

    @property
    def steps(self) -> float:
        """Return the turns of the eccentric, relative to the held ring or carrier, per turn of the
        output; negative for opposite directions.
        """
        return ratio_of(self.stage, self.fixed)

    @property
    def ratio(self) -> float:
        """Return the turns of the input per turn of the output; negative for opposite
        directions.
        """
        first = self.first_stage
        if first is None:
            return self.steps
        if isinstance(first, CycloidalFirstStage):
            return self.steps * ratio_of(first.stage)
        # Outer gears turn in opposite directions; with the ring held the carrier adds one turn.
        held = -first.step * ratio_of(self.stage, "carrier")
        return held if self.fixed == "carrier" else 1 - held

    @property
    def design_force(self) -> float:
        """Return the force (N) on a disc's bearing under the rated torque."""
        share = (
            1.0
            if self.fixed == "ring"
            else self.stage.planet_pitch_radius / self.stage.ring_pitch_radius
        )
        return (
            share
            * self.rated_torque
            / (self.discs * self.eccentric.cranks * self.stage.planet_pitch_radius)
        )

    @property
    def input_twist(self) -> float | None:
        """Return the rotation of the input per torque on it (rad/(N m)) by the eccentric's shaft up
        to its first disc; None where it is not known.
        """
        shaft = self.eccentric.shaft
        if self.first_stage is not None or not isinstance(shaft, Shaft):
            return None
        return twist(shaft.stretches, 0.0, min(shaft.disc_at))

    @property
    def states_ratio(self) -> bool:
        """Return that the ratio is known from the teeth."""
        return True
