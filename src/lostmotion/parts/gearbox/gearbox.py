"""The figures that makers print of any gearbox, and the errors they stand for: what every kind takes, whatever is inside it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Final, Generic, Protocol, Self, TypeVar, runtime_checkable

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from lostmotion.laws.distributions import Uniform, of_tolerance
from lostmotion.laws.gears import play_from_lost_motion
from lostmotion.parts.error_source import (
    HELD_SHARE,
    OF_HELD,
    OF_RATED,
    RATED_SHARE,
    AngleAmount,
    AngularStiffness,
    ErrorSource,
    Friction,
    Inertia,
    Line,
    Mass,
    PartFigure,
    PlayDim,
    Share,
    TorqueAmount,
)
from lostmotion.parts.forms import Constant, Curve, Seat
from lostmotion.parts.provenance import UPPER_LIMIT, Keys, Sourced, default_friction
from lostmotion.parts.standard_terms import TRANSMISSION_ERROR, End, backlash_terms, free_terms, harmonic_terms, loop_term, parameter, spring_terms
from lostmotion.parts.term import Draw, Holding, Motion, Parameter, Term
from lostmotion.units import Quantity, Toleranced

if TYPE_CHECKING:
    from collections.abc import Callable

    from pydantic import GetJsonSchemaHandler, ValidationInfo
    from pydantic_core import CoreSchema


AmountT = TypeVar("AmountT", bound=float)
PlayT = TypeVar("PlayT", bound=Toleranced)
StiffnessT = TypeVar("StiffnessT", bound=float)
LoadT = TypeVar("LoadT", bound=float)


@dataclass(frozen=True)
class Whole(Quantity):
    """Marks a field that counts something: a whole number from `low` to `high`."""

    @property
    def expected(self) -> str:
        """Say in words what this field takes."""
        return f"a whole number from {self.low:g} to {self.high:g}"

    def __call__(self, value: Any, info: ValidationInfo | None = None) -> int:  # noqa: ANN401 - whatever a file holds
        """Turn what was given into a count; raises pydantic's error with `expected` and `example` in its context."""
        number = super().__call__(value, info)
        if not isinstance(number, float) or not number.is_integer():
            raise self.refusal("not a whole number")
        return int(number)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Describe the field for editors."""
        return {"type": ["string", "integer"], "description": self.expected, "examples": [int(self.example)]}


def teeth(example: str) -> Whole:
    """Mark a field that holds a number of teeth."""
    return Whole("", example, low=1, high=10_000)


MOST_PLANETS: Final = 64
Planets = Annotated[int, Whole("", "3", low=1, high=MOST_PLANETS)]


# Fields for which a maker may print an upper limit, each with the key of the parameter that its terms follow.
LIMITED: Final = {"backlash": "play", "lost_motion": "play", "hysteresis": "hysteresis", "transmission_error": TRANSMISSION_ERROR}


class Harmonic(Sourced, Generic[AmountT]):
    """One wave of the transmission error: `amplitude` (half of peak to peak) with `cycles` per turn of the output, or of the screw."""

    amplitude: AmountT
    cycles: Annotated[float, Quantity("", "2", above=0)]


class Gearbox(Sourced, ErrorSource, Generic[AmountT, PlayT, StiffnessT, LoadT]):
    """What makers print of any reducer; every value left out is taken as ideal (no play, rigid, exact).

    backlash          total free play at the output; ± is its scatter over gearboxes built
    lost_motion       instead of backlash: what the maker reads between + and - `lost_motion_torque` (share of rated torque)
    stiffness         one value, or one per zone with `zone_torques` between them (K1/K2/K3)
    stiffness_scatter ± share of the wind-up over gearboxes built
    hysteresis        full width of the loop that friction leaves at zero load; its side follows the way of arriving, loaded or not
    transmission_error full peak-to-peak error over a turn (one wave per turn), or a list of waves
    friction_torque   a load below it cannot hold the play closed; left out: 1 % of the rated torque, or where none is stated, in an arm, 2 % of the
                      most that the joint holds at rest, in any pose on any slope
    mass              of the gearbox; it weighs at the joint where no mass of the joint is stated, for a joint's mass includes its gearbox
    inertia           moment of inertia seen at the input; kept as data, no result uses it
    upper_limits      keys for which the maker prints an upper limit and no value: figures that rest on them are "at most"

    A kind adds its `kind` and its `ratio`, turns of the input per turn of the output.
    """

    kind: str
    model: Annotated[Line, Field(max_length=80)] = ""
    rated_torque: LoadT | None = None
    stiffness: StiffnessT | Annotated[list[StiffnessT], Field(min_length=1, max_length=8)] | None = None
    zone_torques: Annotated[list[LoadT], Field(max_length=7)] = Field(default=[])
    stiffness_scatter: Share = 0.0
    backlash: PlayT | None = None
    lost_motion: AmountT | None = None
    lost_motion_torque: Annotated[float, Quantity("", "3 %", above=0, high=1)] = 0.03
    hysteresis: AmountT | None = None
    transmission_error: AmountT | Annotated[list[Harmonic[AmountT]], Field(max_length=64)] | None = None
    friction_torque: LoadT | None = None
    mass: Mass | None = None
    inertia: Inertia | None = None
    upper_limits: Keys = ()

    if TYPE_CHECKING:  # a field of some kinds, computed from the teeth of others

        @property
        def ratio(self) -> float:
            """Return the turns of the input per turn of the output, negative where they go opposite ways."""

    @property
    def assumptions(self) -> dict[str, str]:
        """Return the values that are not stated as facts: key to reason, with the limits and defaults that count."""
        out = {**super().assumptions, **dict.fromkeys(self.upper_limits, UPPER_LIMIT)}
        if self.lost_motion is not None and "lost_motion_torque" not in self.model_fields_set:
            out["lost_motion_torque"] = "default, 3 % of the rated torque"
        return out | default_friction("friction_torque", self.play_friction(Holding))

    @property
    def zones(self) -> list[float]:
        """Give the stiffness of each zone; empty for a rigid gearbox."""
        if self.stiffness is None:
            return []
        return list(self.stiffness) if isinstance(self.stiffness, list) else [self.stiffness]

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        limits = [float(limit) for limit in self.zone_torques]
        if len(limits) != max(len(self.zones) - 1, 0) or any(b <= a for a, b in pairwise([0.0, *limits])):
            raise PydanticCustomError(
                "zones",
                "{why}",
                {
                    "why": f"{len(self.zones)} stiffness zones with {len(limits)} zone torques",
                    "expected": "rising zone torques, one fewer than stiffness values",
                    "example": 'stiffness = ["25 N m/arcmin", "34 N m/arcmin"], zone_torques = ["14 N m"]',
                },
            )
        if self.lost_motion is not None:
            self._check_lost_motion()
        return self

    def _check_lost_motion(self) -> None:
        example = 'lost_motion = "1 arcmin", lost_motion_torque = "3 %", rated_torque = "412 N m", stiffness = "113 N m/arcmin"'
        if self.backlash is not None:
            context = {"why": "both backlash and lost_motion", "expected": "one of the two", "example": 'backlash = "0.5 arcmin"'}
            raise PydanticCustomError("lost_motion", "{why}", context)
        if self.rated_torque is None or not self.zones:
            context = {"why": "lost_motion alone", "expected": "rated_torque and stiffness with it", "example": example}
            raise PydanticCustomError("lost_motion", "{why}", context)
        if self._stated_play.nominal < 0:
            context = {
                "why": "a lost motion smaller than the elastic wind-up at that torque",
                "expected": "a larger lost_motion, or backlash stated by itself",
                "example": 'backlash = "0.2 arcmin"',
            }
            raise PydanticCustomError("lost_motion", "{why}", context)

    @property
    def play(self) -> Toleranced:
        """Give the free play, as stated or as it follows from the lost motion."""
        return self._stated_play

    @property
    def _stated_play(self) -> Toleranced:
        if self.backlash is not None:
            return self.backlash
        if self.lost_motion is None or self.rated_torque is None:
            return Toleranced(0.0)
        small = self.lost_motion_torque * self.rated_torque
        return Toleranced(play_from_lost_motion(self.lost_motion, small, self.zones, self.zone_torques))

    @property
    def friction(self) -> float:
        """Return the load below which the way of arriving decides on the side of the play, of the gearbox by itself: 0 where it is not known."""
        return self._friction_in(Holding).load

    def play_friction(self, holding: Callable[[], Holding]) -> Friction | None:
        """Return what is stated, or else what is assumed."""
        return self._friction_in(holding) if self.play.nominal else None

    def _friction_in(self, holding: Callable[[], Holding]) -> Friction:
        if self.friction_torque is not None:
            return Friction(self.friction_torque)
        if self.rated_torque is not None:
            return Friction(RATED_SHARE * self.rated_torque, OF_RATED)
        return Friction(HELD_SHARE * holding().load, OF_HELD)

    def terms(self, motion: Motion) -> list[Term]:
        """Return wind-up under load, play on the side where the load leaves it, hysteresis, transmission error."""
        out: list[Term] = []
        if self.zones:
            zones = len(self.stiffness) if isinstance(self.stiffness, list) else 1
            sized = Parameter("stiffness", float(self.zones[0]), motion.stiffness_unit, zones)
            curve = Curve.of_zones(self.zones, self.zone_torques)
            out += spring_terms(motion.twist, curve, self.stiffness_scatter, sized, "stiffness scatter", "stiffness")
        out += backlash_terms(motion, self.play, self._friction_in(motion.holding).load)
        if self.hysteresis is not None:
            out.append(loop_term(Constant(motion.twist), self.hysteresis / 2, parameter("hysteresis", self.hysteresis, motion.unit)))
        own, stated = [(*wave, wave[0]) for wave in self._own_waves()], [(*wave, TRANSMISSION_ERROR) for wave in self._stated_waves()]
        for name, size, cycles, cause in (*own, *stated):
            value = self.transmission_error if cause == TRANSMISSION_ERROR else None
            if size:
                out += harmonic_terms(name, cause, motion.twist, cycles, size, parameter(cause, value, motion.unit), self._turns(motion))
        return out

    @property
    def waves(self) -> list[tuple[str, float, float]]:
        """Return the harmonics of the transmission error: name, amplitude at the output (rad or m), cycles per turn of output or screw."""
        return [wave for wave in (*self._own_waves(), *self._stated_waves()) if wave[1]]

    def _stated_waves(self) -> list[tuple[str, float, float]]:
        stated = self.transmission_error
        if isinstance(stated, list):
            return [(f"{TRANSMISSION_ERROR} {index}", wave.amplitude, wave.cycles) for index, wave in enumerate(stated, 1)]
        return [] if stated is None else [(f"{TRANSMISSION_ERROR} 1", stated / 2, 1.0)]

    @property
    def states_ratio(self) -> bool:
        """Return whether the ratio is known: from the teeth, or as stated."""
        return True

    @property
    def assumed_rigid(self) -> str:
        """Return the members that are not specified and taken as rigid: none, for the stated stiffness is that of all."""
        return ""

    @property
    def own_figures(self) -> list[PartFigure]:
        """Return the figures that this kind alone has, for its sheet."""
        return []

    def _own_waves(self) -> list[tuple[str, float, float]]:
        """Return the harmonics that this kind knows by name: name, amplitude at the output (rad), cycles per turn of the output."""
        return []

    def _turns(self, motion: Motion) -> float | None:  # noqa: ARG002 - most kinds only turn
        """Return the turning (rad) per unit of the joint's value that the transmission error goes by; None where the joint itself turns."""
        return None


@runtime_checkable
class Loose(Protocol):
    """A source with a free play."""

    @property
    def play(self) -> Toleranced:
        """Return the whole free play, rad or m."""

    def play_friction(self, holding: Callable[[], Holding]) -> Friction | None:
        """Return the load below which it stays open; None without play."""


@dataclass(frozen=True, slots=True)
class PlayInLoop(ErrorSource):
    """What an encoder on the output leaves of a gearbox: the play, where the load is below friction; `dead_band` ± rad or m, None: all of the play.

    Above friction the flanks are closed and the controller turns the motor until the output is in place. Below it the output is coupled to nothing
    but friction: it rests wherever the controller left it within its dead band, or hunts between the flanks, so that at the moment of
    reading every place within the play, or the dead band where that is the smaller, is alike: a uniform law, where an encoder on the motor leaves it
    at one flank or the other. Half its width is min(play / 2, dead_band) times the share that the load leaves free, as `laws.clearance` has it.
    """

    loose: Loose
    dead_band: float | None

    @property
    def play(self) -> Toleranced:
        """Return the whole free play."""
        return self.loose.play

    def play_friction(self, holding: Callable[[], Holding]) -> Friction | None:
        """Return that of the gearbox."""
        return self.loose.play_friction(holding)

    def terms(self, motion: Motion) -> list[Term]:
        """Return the rest anywhere within what is left open: another place at every visit, whatever the last motion."""
        friction, play = self.play_friction(motion.holding), self.play
        if friction is None or not play.nominal:
            return []
        # A dead band well inside the play does not scatter with it.
        within = self.dead_band is not None and self.dead_band < play.nominal / 2
        half, spread = (self.dead_band or 0.0, 0.0) if within else (play.nominal / 2, play.tolerance / of_tolerance(play.law).bound / 2)
        name = "dead band" if within else "backlash left open"
        sized = Parameter(name) if within else parameter("play", play.nominal, motion.unit)
        law, amount = Uniform(), Draw("amount", of_tolerance(play.law))
        ends = [End(name, motion.twist, Draw("rest", law))]
        return free_terms(name, Seat(motion.twist[None], friction.load), ends, half / law.bound, spread / law.bound, amount, sized)


# What of a kind that only turns is built on.
TurningFigures = Gearbox[AngleAmount, PlayDim, AngularStiffness, TorqueAmount]


def refuse(why: str, expected: str, example: str) -> PydanticCustomError:
    """Build the error of a gearbox that cannot be: what was found, what belongs there, an example that passes."""
    return PydanticCustomError("gearbox", "{why}", {"why": why, "expected": expected, "example": example})
