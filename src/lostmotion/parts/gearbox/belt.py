"""Timing belts: of a carriage, whose strands change their length with its position, and between two
pulleys of a turning joint.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, Self

from pydantic import model_validator

from lostmotion.laws.linear_drives import belt_compliance, belt_stage_stiffness
from lostmotion.parts.error_source import AngleAmount, LengthPlus
from lostmotion.parts.gearbox.gearbox import TurningFigures, refuse
from lostmotion.parts.gearbox.slide import SlideFigures
from lostmotion.parts.provenance import OfClass
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

Tension = Annotated[float, Quantity("N", "450 kN", above=0)]


class BeltDrive(SlideFigures):
    """A carriage on an open belt over a drive pulley and an idler; figures as in `SlideFigures`.

    belt_stiffness  EA, force per strain: specific stiffness x width
    belt_length     free length of the belt from the drive pulley to the carriage and from there
                    round the idler back to the drive pulley
    start           free length from the drive pulley to the carriage where the joint's value is
                    zero; it grows with that value

    Valid while the pretension keeps both strands taut. A belt on the carriage's own motor (omega
    drive) has the same lengths.
    """

    kind: Literal["belt"] = "belt"
    described_by: ClassVar[dict[str, tuple[str, ...]]] = {"stiffness": ("belt_stiffness",)}
    belt_stiffness: Tension
    belt_length: LengthPlus
    start: LengthPlus

    @model_validator(mode="after")
    def _starts_on_the_belt(self) -> Self:
        if self.start >= self.belt_length:
            raise refuse(
                "a start beyond the length of the belt",
                "a start shorter than belt_length",
                'belt_length = "3 m", start = "0.2 m"',
            )
        return self

    def compliance_at(self, position: Floats) -> Floats:
        """Return the compliance (m/N) of both strands at joint values (any shape), m."""
        return belt_compliance(self.start + position, self.belt_length, self.belt_stiffness)

    def range_error(self, limits: tuple[float, float]) -> tuple[str, str, str] | None:
        """Return what was found, what is expected and an example where a strand would vanish within
        a joint's range.
        """
        if self.start + limits[0] > 0 and self.start + limits[1] < self.belt_length:
            return None
        expected = (
            f"a strand of some length at both limits: start above {-limits[0]:g} m, belt_length "
            f"above start + {limits[1]:g} m"
        )
        return (
            "a range in which the carriage reaches the drive pulley",
            expected,
            'belt_length = "3 m", start = "0.2 m"',
        )


class BeltStage(TurningFigures, OfClass):
    """A closed timing belt from the motor's pulley to that of a turning joint; figures as in
    `Gearbox`.

    ratio           turns of the motor per turn of the joint
    belt_stiffness  EA, force per strain: specific stiffness x width
    strand          free length of each of the two strands
    pulley_radius   pitch radius of the joint's pulley
    pulley_error, motor_pulley_error  amplitude at the output of the harmonic that each pulley's
                                      eccentricity makes: once per turn of it stiffness       of all
                                      but the belt, in series with it

    Valid while the pretension keeps both strands taut.
    """

    kind: Literal["belt"] = "belt"
    described_by: ClassVar[dict[str, tuple[str, ...]]] = {"stiffness": ("belt_stiffness",)}
    ratio: Annotated[float, Quantity("", "4", above=0)]
    belt_stiffness: Tension
    strand: LengthPlus
    pulley_radius: LengthPlus
    pulley_error: AngleAmount = 0.0
    motor_pulley_error: AngleAmount = 0.0

    @property
    def zones(self) -> list[float]:
        """Return the stiffness (N m/rad) of the belt, in series with that stated for the rest."""
        belt = belt_stage_stiffness(self.strand, self.pulley_radius, self.belt_stiffness)
        return [1 / (1 / belt + 1 / rest) for rest in super().zones] or [belt]

    def _own_harmonics(self) -> list[tuple[str, float, float]]:
        return [
            ("pulley", self.pulley_error, 1.0),
            ("motor pulley", self.motor_pulley_error, self.ratio),
        ]
