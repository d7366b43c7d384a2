"""Drawing of a cycloidal gearbox: one stage or two, every dimension with its tolerance, every spring stated, computed or bounded."""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Literal, Self

from pydantic import Field, model_validator

from lostmotion.errors import shown
from lostmotion.laws.cycloid.geometry import ratio as ratio_of
from lostmotion.laws.cycloid.shaft import twist
from lostmotion.parts.error_source import (
    OF_RATED,
    RATED_SHARE,
    AngularStiffness,
    ClearanceDim,
    Friction,
    FrictionTorque,
    Inertia,
    LengthPlus,
    Line,
    LinearStiffness,
    Mass,
)
from lostmotion.parts.gearbox.cycloidal_frame import GearboxFrame  # noqa: TC001 - read by pydantic
from lostmotion.parts.gearbox.cycloidal_names import FIRST_STAGE, FRAME, OUTSIDE, STAGE_MEMBERS
from lostmotion.parts.gearbox.cycloidal_seats import Named  # noqa: TC001 - read by pydantic
from lostmotion.parts.gearbox.cycloidal_shaft import Shaft
from lostmotion.parts.gearbox.cycloidal_stage import CycloidalStage
from lostmotion.parts.gearbox.cycloidal_states import MemberState, Unknown, member_states, unknowns
from lostmotion.parts.gearbox.gearbox import Whole, refuse
from lostmotion.parts.provenance import Sourced, with_friction
from lostmotion.units import Quantity, Toleranced

if TYPE_CHECKING:
    from collections.abc import Mapping

Torque = Annotated[float, Quantity("N m", "412 N m", above=0)]
# Of a compliance, over its middle.
Factor = Annotated[float, Quantity("", "1.5", above=0, high=1000, band="log-uniform")]
Teeth = Annotated[int, Whole("", "16", low=6, high=1000)]
# What some members include beyond their names.
_INCLUDED: Final = {"eccentric shaft": "eccentric shaft with its bearings and seats", "frame": "frame (housing and output shaft)"}
# Pressure angle of the involute flanks.
_PRESSURE_ANGLE = math.radians(20)


class PlanetaryFirstStage(Sourced):
    """A planetary first stage: a sun drives planets, each on a crankshaft (as in an RV reducer).

    play            along the pitch circle, between sun and planet
    mesh_stiffness  of one sun-planet mesh along its line of action; for steel about 14 to 20 N/(µm mm) of face width (ISO 6336-1)
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
        """Return the rotation of the sun per torque on it (rad/(N m)), with the load shared equally by all planets."""
        if self.mesh_stiffness is None:
            return 0.0
        return 1 / (self.planets * self.mesh_stiffness * math.cos(_PRESSURE_ANGLE) ** 2 * self.sun_radius**2)


class CycloidalFirstStage(CycloidalStage):
    """A cycloidal first stage: its disc drives the crank of the second stage."""

    kind: Literal["cycloidal"] = "cycloidal"


class CycloidalDrawing(CycloidalStage):
    """What the drawing of a cycloidal gearbox states; `CycloidalGearbox` lists its fields."""

    by_drawing: ClassVar[bool] = True
    may_be_rigid: ClassVar[tuple[str, ...]] = (*STAGE_MEMBERS, *OUTSIDE)
    kind: Literal["cycloidal"] = "cycloidal"
    model: Annotated[Line, Field(max_length=80)] = ""
    rated_torque: Torque
    fixed: Literal["ring", "carrier"] = "ring"
    first_stage: Annotated[PlanetaryFirstStage | CycloidalFirstStage, Field(discriminator="kind")] | None = None
    frame: AngularStiffness | GearboxFrame | None = None
    input_shaft: AngularStiffness | None = None
    friction_torque: FrictionTorque | None = None
    mass: Mass | None = None
    inertia: Inertia | None = None
    unstated: Annotated[dict[Named, Factor], Field(max_length=100)] = Field(default={})

    @model_validator(mode="after")
    def _leaves_open(self) -> Self:
        names = [each.name for each in self.unknowns]
        strange = [name for name in self.unstated if name not in names]
        if strange:
            expected = f"what this drawing leaves open: {', '.join(names) or 'nothing'}"
            raise refuse(f"{shown(strange[0])} in unstated", expected, f'unstated = {{ "{names[0] if names else FRAME}" = 1.5 }}')
        object.__setattr__(self, "unstated", self.left_open)
        return self

    @property
    def left_open(self) -> dict[str, float]:
        """Return a factor for whatever the drawing leaves open: a range, unless it is stated."""
        return {each.name: self.unstated.get(each.name, each.factor) for each in self.unknowns}

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy with other values, which may leave other things open."""
        out = super().model_copy(update=update, deep=deep)
        if update and "unstated" not in update:
            object.__setattr__(out, "unstated", out.left_open)
        return out

    @model_validator(mode="after")
    def _stages_fit(self) -> Self:
        if isinstance(self.first_stage, PlanetaryFirstStage) and self.eccentric.cranks not in (1, self.first_stage.planets):
            raise refuse(
                f"{self.first_stage.planets} planets on {self.eccentric.cranks} cranks",
                "a planet on every crankshaft",
                f"first_stage = {{ planets = {self.eccentric.cranks} }}",
            )
        return self

    @property
    def steps(self) -> float:
        """Return the turns of the eccentric, relative to the held ring or carrier, per turn of the output; negative for opposite directions."""
        return ratio_of(self.stage, self.fixed)

    @property
    def ratio(self) -> float:
        """Return the turns of the input per turn of the output; negative for opposite directions."""
        first = self.first_stage
        if first is None:
            return self.steps
        if isinstance(first, CycloidalFirstStage):
            return self.steps * ratio_of(first.stage)
        # Outer gears turn in opposite directions; with the ring held the carrier adds one turn.
        held = -first.step * ratio_of(self.stage, "carrier")
        return held if self.fixed == "carrier" else 1 - held

    @property
    def assumptions(self) -> dict[str, str]:
        """Return the values that are not stated as facts: key to reason, with the default friction."""
        return with_friction(super().assumptions, "friction_torque", self.friction_at_rest)

    @property
    def design_force(self) -> float:
        """Return the force (N) on a disc's bearing under the rated torque."""
        share = 1.0 if self.fixed == "ring" else self.stage.planet_pitch_radius / self.stage.ring_pitch_radius
        return share * self.rated_torque / (self.discs * self.eccentric.cranks * self.stage.planet_pitch_radius)

    @property
    def input_twist(self) -> float | None:
        """Return the rotation of the input per torque on it (rad/(N m)) by the eccentric's shaft up to its first disc; None where it is not known."""
        shaft = self.eccentric.shaft
        if self.first_stage is not None or not isinstance(shaft, Shaft):
            return None
        return twist(shaft.stretches, 0.0, min(shaft.disc_at))

    @functools.cached_property
    def unknowns(self) -> tuple[Unknown, ...]:
        """Return what the drawing does not state, each with its effect on the members."""
        return unknowns(self)

    @functools.cached_property
    def middle(self) -> Self:
        """Return the drawing with the middle of everything that it does not state."""
        return self.model_copy(update={"unstated": {}})

    @functools.cached_property
    def states(self) -> dict[str, MemberState]:
        """Return what is known of each member, by name."""
        return member_states(self)

    @property
    def bounded(self) -> tuple[str, ...]:
        """Return the members that the drawing does not describe, of which the compliance is bounded."""
        return tuple(name for name, state in self.states.items() if state.kind == "bounded")

    @property
    def states_ratio(self) -> bool:
        """Return that the ratio is known from the teeth."""
        return True

    @property
    def not_specified(self) -> str:
        """Return the bounded members as text, each with what it includes and its stage."""
        return ", ".join(
            f"{_INCLUDED.get(name.removeprefix(FIRST_STAGE), name.removeprefix(FIRST_STAGE))}{' of the first stage' * name.startswith(FIRST_STAGE)}"
            for name in self.bounded
        )

    @property
    def friction_at_rest(self) -> Friction:
        """Return the load (N m) below which the direction of the last motion decides the side of the play, stated or else assumed."""
        return self.friction_torque if self.friction_torque is not None else Friction.of_load(RATED_SHARE * self.rated_torque, OF_RATED)

    @property
    def friction_in_loop(self) -> float:
        """Return the friction torque without load (N m) that counts in the hysteresis: the stated one."""
        return self.friction_torque.load.nominal if self.friction_torque is not None else 0.0
