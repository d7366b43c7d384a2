"""Data-sheet figures common to all kinds of gearbox, and their error terms."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, ClassVar, Final, Generic, Self, TypeVar

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from lostmotion.laws.gears import play_from_lost_motion, wind_up
from lostmotion.parts.error_source import (
    HELD_SHARE,
    OF_HELD,
    OF_RATED,
    RATED_SHARE,
    AngleAmount,
    AngularStiffness,
    ErrorSource,
    Friction,
    FrictionShare,
    FrictionTorque,
    Inertia,
    Line,
    Mass,
    PartFigure,
    PlayDim,
    Price,
    Share,
    TorqueAmount,
)
from lostmotion.parts.forms import Constant, Curve
from lostmotion.parts.provenance import UPPER_LIMIT, Keys, Sourced, with_friction
from lostmotion.parts.standard_terms import (
    TRANSMISSION_ERROR,
    backlash_terms,
    harmonic_terms,
    loop_terms,
    parameter,
    spring_terms,
)
from lostmotion.parts.term import Holding, Motion, Parameter, Term
from lostmotion.units import Quantity, Toleranced

if TYPE_CHECKING:
    from collections.abc import Callable


AmountT = TypeVar("AmountT", bound=float)
PlayT = TypeVar("PlayT", bound=Toleranced)
StiffnessT = TypeVar("StiffnessT", bound=float)
LoadT = TypeVar("LoadT", bound=float)
FrictionT = TypeVar("FrictionT", bound=Friction)


# Fields for which a maker may state an upper limit, each with the parameter of its terms.
LIMITED: Final = {
    "backlash": "play",
    "lost_motion": "play",
    "hysteresis": "hysteresis",
    "transmission_error": TRANSMISSION_ERROR,
}


class StatedHarmonic(Sourced, Generic[AmountT]):
    """One harmonic of the transmission error: `amplitude` (half of peak to peak) with `cycles` per
    turn of the output, or of the screw.
    """

    amplitude: AmountT
    cycles: Annotated[float, Quantity("", "2", above=0)]


class Gearbox(Sourced, ErrorSource, Generic[AmountT, PlayT, StiffnessT, LoadT, FrictionT]):
    """Data-sheet figures of any reducer; an omitted value is assumed ideal (no play, rigid, exact).

    backlash          total free play at the output; ± is its scatter over gearboxes
    lost_motion       instead of backlash: the maker's reading between + and - `lost_motion_torque`
                      (share of rated torque)
    stiffness         one value, or one per zone with `zone_torques` between them (K1/K2/K3)
    stiffness_scatter ± scatter of the wind-up over gearboxes, as a share
    rigid             true: declared rigid. Without it and without a stiffness, the stiffness is
                      missing, and figures are lower bounds
    hysteresis        full width of the friction loop at zero load; its side follows the last
                      motion, with or without load
    hysteresis_scatter ± share by which the friction, and with it that width, differs from visit to
    visit, three standard deviations. Where no
                      hysteresis is stated, the loop is that of the stated friction_torque behind
                      the stiffness
    transmission_error full peak-to-peak error over a turn (one harmonic per turn), or a list of
    harmonics
    friction_torque   under a load below it the play stays open; default: 1 % of the rated torque,
                      or where none is stated, in an arm, 2 % of the most that the joint holds at
                      rest, in any pose on any slope. ± is its scatter over gearboxes; default: ±50
                      %
    mass              of the gearbox; used where the joint states no mass, which would include its
                      gearbox
    price             of the gearbox; used where the joint states no price, which would include its
                      gearbox
    inertia           moment of inertia at the input; data only, no result uses it
    upper_limits      keys for which the maker states an upper limit instead of a value: figures
                      based on them are "at most"

    A kind adds its `kind` and its `ratio`, turns of the input per turn of the output.
    """

    # Keys of a kind, besides those of any gearbox, that describe its "stiffness" or its "backlash".
    described_by: ClassVar[dict[str, tuple[str, ...]]] = {}
    # Kinds of error that a gearbox of this kind does not have, by its principle.
    absent: ClassVar[tuple[str, ...]] = ()
    kind: str
    model: Annotated[Line, Field(max_length=80)] = ""
    rated_torque: LoadT | None = None
    stiffness: (
        StiffnessT | Annotated[list[StiffnessT], Field(min_length=1, max_length=8)] | None
    ) = None
    zone_torques: Annotated[list[LoadT], Field(max_length=7)] = Field(default=[])
    stiffness_scatter: Share = 0.0
    rigid: bool = False
    backlash: PlayT | None = None
    lost_motion: AmountT | None = None
    lost_motion_torque: Annotated[float, Quantity("", "3 %", above=0, high=1)] = 0.03
    hysteresis: AmountT | None = None
    hysteresis_scatter: FrictionShare = 0.0
    transmission_error: (
        AmountT | Annotated[list[StatedHarmonic[AmountT]], Field(max_length=64)] | None
    ) = None
    friction_torque: FrictionT | None = None
    mass: Mass | None = None
    price: Price | None = None
    inertia: Inertia | None = None
    upper_limits: Keys = ()

    if TYPE_CHECKING:  # a field of some kinds, computed from the teeth of others

        @property
        def ratio(self) -> float:
            """Return the turns of the input per turn of the output, negative for opposite
            directions.
            """

    @property
    def assumptions(self) -> dict[str, str]:
        """Return the values that are not stated as facts: key to reason, with the limits and
        defaults in use.
        """
        out = {**super().assumptions, **dict.fromkeys(self.upper_limits, UPPER_LIMIT)}
        if self.lost_motion is not None and "lost_motion_torque" not in self.model_fields_set:
            out["lost_motion_torque"] = "default, 3 % of the rated torque"
        return with_friction(out, "friction_torque", self.play_friction(Holding))

    @property
    def zones(self) -> list[float]:
        """Return the stiffness of each zone; empty for a rigid gearbox."""
        if self.stiffness is None:
            return []
        return list(self.stiffness) if isinstance(self.stiffness, list) else [self.stiffness]

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        elastic = [
            name
            for name in ("stiffness", *self.described_by.get("stiffness", ()))
            if getattr(self, name) is not None
        ]
        if self.rigid and elastic:
            raise refuse(f"rigid beside {elastic[0]}", "one of the two", "rigid = true")
        limits = [float(limit) for limit in self.zone_torques]
        if len(limits) != max(len(self.zones) - 1, 0) or any(
            b <= a for a, b in pairwise([0.0, *limits])
        ):
            raise PydanticCustomError(
                "zones",
                "{why}",
                {
                    "why": f"{len(self.zones)} stiffness zones with {len(limits)} zone torques",
                    "expected": "rising zone torques, one fewer than stiffness values",
                    "example": (
                        'stiffness = ["25 N m/arcmin", "34 N m/arcmin"], zone_torques = ["14 N m"]'
                    ),
                },
            )
        if self.lost_motion is not None:
            self._check_lost_motion()
        if self.hysteresis_scatter and self.loop_width is None:
            context = {
                "why": "hysteresis_scatter without a hysteresis",
                "expected": (
                    "hysteresis with it, the width of the friction loop that scatters, or "
                    "friction_torque and stiffness"
                ),
                "example": 'hysteresis = "0.5 arcmin", hysteresis_scatter = "20 %"',
            }
            raise PydanticCustomError("limits", "{why}", context)
        return self

    def _check_lost_motion(self) -> None:
        example = (
            'lost_motion = "1 arcmin", lost_motion_torque = "3 %", rated_torque = "412 N m", '
            'stiffness = "113 N m/arcmin"'
        )
        if self.backlash is not None:
            context = {
                "why": "both backlash and lost_motion",
                "expected": "one of the two",
                "example": 'backlash = "0.5 arcmin"',
            }
            raise PydanticCustomError("lost_motion", "{why}", context)
        if self.rated_torque is None or not self.zones:
            context = {
                "why": "lost_motion without rated_torque and stiffness",
                "expected": "rated_torque and stiffness with it",
                "example": example,
            }
            raise PydanticCustomError("lost_motion", "{why}", context)
        if self._stated_play.nominal < 0:
            context = {
                "why": "a lost motion smaller than the elastic wind-up at that torque",
                "expected": "a larger lost_motion, or backlash stated by itself",
                "example": 'backlash = "0.2 arcmin"',
            }
            raise PydanticCustomError("lost_motion", "{why}", context)

    @property
    def loop_width(self) -> float | None:
        """Return the full width of the friction loop without load (rad or m); None where none is
        described.

        As stated, or 2 w(F) of the stated friction F behind a spring curve w, where the scatter of
        the friction is stated without a width.
        """
        friction = self.friction_torque
        if (
            self.hysteresis is not None
            or not self.hysteresis_scatter
            or friction is None
            or not self.zones
        ):
            return self.hysteresis
        return 2 * float(wind_up(np.array(friction.load.nominal), self.zones, self.zone_torques))

    @property
    def play(self) -> Toleranced:
        """Return the free play, as stated or computed from the lost motion."""
        return self._stated_play

    @property
    def _stated_play(self) -> Toleranced:
        if self.backlash is not None:
            return self.backlash
        if self.lost_motion is None or self.rated_torque is None:
            return Toleranced(0.0)
        small = self.lost_motion_torque * self.rated_torque
        return Toleranced(
            play_from_lost_motion(self.lost_motion, small, self.zones, self.zone_torques)
        )

    @property
    def friction(self) -> Friction:
        """Return the load below which the last motion decides the side of the play, of the gearbox
        by itself; 0 where it is not known.
        """
        return self._friction_in(Holding)

    def play_friction(self, holding: Callable[[], Holding]) -> Friction | None:
        """Return the stated friction, or else the assumed one; None without play."""
        return self._friction_in(holding) if self.play.nominal else None

    def _friction_in(self, holding: Callable[[], Holding]) -> Friction:
        if self.friction_torque is not None:
            return self.friction_torque
        if self.rated_torque is not None:
            return Friction.of_load(RATED_SHARE * self.rated_torque, OF_RATED)
        return Friction.of_load(HELD_SHARE * holding().load, OF_HELD)

    def terms(self, motion: Motion) -> list[Term]:
        """Return wind-up under load, play on the side set by load or last motion, hysteresis,
        transmission error.
        """
        out: list[Term] = []
        if self.zones:
            zones = len(self.stiffness) if isinstance(self.stiffness, list) else 1
            sized = Parameter("stiffness", float(self.zones[0]), motion.stiffness_unit, zones)
            curve = Curve.of_zones(self.zones, self.zone_torques)
            out += spring_terms(
                motion.twist,
                curve,
                self.stiffness_scatter,
                sized,
                "stiffness scatter",
                "stiffness",
                self._travel(motion),
            )
        out += backlash_terms(motion, self.play, self._friction_in(motion.holding).load)
        width = self.loop_width
        if width:
            sized = parameter("hysteresis", self.hysteresis, motion.unit)
            out += loop_terms(Constant(motion.twist), width / 2, sized, self.hysteresis_scatter)
        own = [(*each, each[0]) for each in self._own_harmonics()]
        stated = [(*each, TRANSMISSION_ERROR) for each in self._stated_harmonics()]
        for name, size, cycles, cause in (*own, *stated):
            value = self.transmission_error if cause == TRANSMISSION_ERROR else None
            if size:
                out += harmonic_terms(
                    name,
                    cause,
                    motion.twist,
                    cycles,
                    size,
                    parameter(cause, value, motion.unit),
                    self._turns(motion),
                )
        return out

    @property
    def harmonics(self) -> list[tuple[str, float, float]]:
        """Return the harmonics of the transmission error: name, amplitude at the output (rad or m),
        cycles per turn of output or screw.
        """
        return [
            harmonic
            for harmonic in (*self._own_harmonics(), *self._stated_harmonics())
            if harmonic[1]
        ]

    def _stated_harmonics(self) -> list[tuple[str, float, float]]:
        stated = self.transmission_error
        if isinstance(stated, list):
            return [
                (f"{TRANSMISSION_ERROR} {index}", harmonic.amplitude, harmonic.cycles)
                for index, harmonic in enumerate(stated, 1)
            ]
        return [] if stated is None else [(f"{TRANSMISSION_ERROR} 1", stated / 2, 1.0)]

    @property
    def states_ratio(self) -> bool:
        """Return whether the ratio is known, from the teeth or as stated."""
        return True

    @property
    def not_specified(self) -> str:
        """Return the members that are not described and therefore bounded: none, because the stated
        stiffness includes all.
        """
        return ""

    def _travel(self, motion: Motion) -> Curve | None:  # noqa: ARG002 - for kinds whose spring has another length at every position
        """Return the factor of the wind-up over the joint's value; None where the stiffness does
        not depend on it.
        """
        return None

    @property
    def own_figures(self) -> list[PartFigure]:
        """Return the figures specific to this kind, for its sheet."""
        return []

    def _own_harmonics(self) -> list[tuple[str, float, float]]:
        """Return the harmonics specific to this kind: name, amplitude at the output (rad), cycles
        per turn of the output.
        """
        return []

    def _turns(self, motion: Motion) -> float | None:  # noqa: ARG002 - for kinds on sliding joints
        """Return the rotation (rad) of the drive per unit of the joint's value, on a sliding joint;
        None where the joint itself turns.
        """
        return None


# Base class of the kinds for turning joints only.
TurningFigures = Gearbox[AngleAmount, PlayDim, AngularStiffness, TorqueAmount, FrictionTorque]


def refuse(why: str, expected: str, example: str) -> PydanticCustomError:
    """Return the validation error of an impossible gearbox: what was found, what is expected, a
    valid example.
    """
    return PydanticCustomError(
        "gearbox", "{why}", {"why": why, "expected": expected, "example": example}
    )
