"""The shaft of an eccentric by its dimensions: sections, bearings and their seats, as stated by a
drawing.
"""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, ClassVar, Final, Self

import numpy as np
from pydantic import Field, model_validator

from lostmotion.laws.cycloid import shaft as laws
from lostmotion.laws.rolling.by_size import stiffness_of_size
from lostmotion.laws.supported_beam import Support, SupportedBeam
from lostmotion.parts.error_source import (
    AngularStiffness,
    ClearanceDim,
    LengthAmount,
    LengthPlus,
    LinearStiffness,
)
from lostmotion.parts.gearbox.counts import Whole
from lostmotion.parts.gearbox.cycloidal.names import SHAFT_BEARINGS, SHAFT_SEATS
from lostmotion.parts.gearbox.cycloidal.pins import STEEL
from lostmotion.parts.gearbox.cycloidal.seats import BearingSeat, BearingSize, Named
from lostmotion.parts.gearbox.gearbox import refuse
from lostmotion.parts.material import Material
from lostmotion.parts.provenance import DEFAULT, Sourced
from lostmotion.units import Toleranced

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from lostmotion.laws.supported_beam import BeamPiece
    from lostmotion.spatial import Floats

# Smallest force on a support that its bearing by size is taken at, as a share of a disc's force.
_LEAST_REACTION: Final = 0.01


class ShaftSection(Sourced):
    """A section of the shaft, from the end of the one before (the first: from 0) `to` a place.

    bore      inner diameter; default: solid
    material  default: steel
    core      material that fills the bore; default: empty
    """

    to: LengthPlus
    diameter: LengthPlus
    bore: LengthAmount = 0.0
    material: Material = STEEL
    core: Material | None = None

    @model_validator(mode="after")
    def _has_a_wall(self) -> Self:
        if self.bore >= self.diameter:
            why = f"a bore of {self.bore * 1e3:g} mm in a diameter of {self.diameter * 1e3:g} mm"
            raise refuse(
                why, "a bore smaller than the diameter", f'bore = "{500 * self.diameter:.3g} mm"'
            )
        if self.core is not None and not self.bore:
            raise refuse("a core without a bore", "the bore that it fills", 'bore = "12 mm"')
        return self

    @property
    def layers(self) -> tuple[tuple[laws.ShaftLayer, Material], ...]:
        """Return the layers of the section, each with its material."""
        out = [
            (
                laws.ShaftLayer(
                    self.diameter, self.bore, self.material.standing_modulus, self.material.poisson
                ),
                self.material,
            )
        ]
        if self.core is not None:
            out.append(
                (
                    laws.ShaftLayer(self.bore, 0.0, self.core.standing_modulus, self.core.poisson),
                    self.core,
                )
            )
        return tuple(out)


class ShaftSupport(Sourced):
    """A bearing that supports the shaft.

    at         its place along the shaft
    bearing    its radial stiffness, or the bore and outside_diameter of a ball bearing;
               unspecified: bounded
    tilt       its stiffness against tilting, for wide or paired bearings; default: none, as of a
               deep groove ball bearing
    seat       the name of its seat under `seats`; unspecified: bounded
    clearance  diametral working clearance
    """

    at: LengthAmount
    bearing: LinearStiffness | BearingSize | None = None
    tilt: AngularStiffness | None = None
    seat: Named | None = None
    clearance: ClearanceDim = Toleranced(0.0)


class ShaftScrews(Sourced):
    """Screws along the whole shaft, evenly spaced on a circle off its axis.

    offset    radius of their circle
    tight     true: screws and body bend as a sandwich; false: the screws are loose in their holes;
              default: between the two
    material  default: steel
    """

    assumed_unless_stated: ClassVar[dict[str, str]] = {
        "tight": f"{DEFAULT}, between loose and tight"
    }
    count: Annotated[int, Whole("", "2", low=2, high=50)]
    diameter: LengthPlus
    offset: LengthPlus
    tight: bool | None = None
    material: Material = STEEL

    @property
    def law(self) -> laws.ShaftBolts:
        """Return the argument of the law."""
        return laws.ShaftBolts(
            self.count, self.diameter, self.offset, self.material.modulus, self.material.poisson
        )


class Shaft(Sourced):
    """The shaft of an eccentric, or of each crank, on its bearings. All places are measured from
    its driven end.

    supports  its bearings
    disc_at   the place of each disc
    sections  its sections, from the driven end on
    screws    along the whole shaft, off its axis
    """

    supports: Annotated[tuple[ShaftSupport, ...], Field(min_length=1, max_length=8)]
    disc_at: Annotated[tuple[LengthAmount, ...], Field(min_length=1, max_length=4)]
    sections: Annotated[tuple[ShaftSection, ...], Field(min_length=1, max_length=40)]
    screws: ShaftScrews | None = None

    @model_validator(mode="after")
    def _is_held(self) -> Self:
        ends = [each.to for each in self.sections]
        if any(second <= first for first, second in itertools.pairwise(ends)):
            raise refuse(
                "sections that do not follow one another",
                "each section ending beyond the one before",
                'to = "27 mm"',
            )
        beyond = [
            place
            for place in (*self.disc_at, *(each.at for each in self.supports))
            if place > ends[-1]
        ]
        if beyond:
            why = (
                f"a disc or support at {max(beyond) * 1e3:g} mm on a shaft of {ends[-1] * 1e3:g} mm"
            )
            raise refuse(why, "places on the shaft", f'to = "{1e3 * max(beyond):g} mm"')
        if len({each.at for each in self.supports}) < 2 and not any(  # noqa: PLR2004
            each.tilt for each in self.supports
        ):
            example = (
                'supports = [{ at = "0 mm", bearing = "30 N/µm" }, { at = "43 mm", bearing = "60 '
                'N/µm" }]'
            )
            raise refuse(
                "a shaft on a single support without tilt stiffness",
                "two supports or more",
                example,
            )
        return self

    @property
    def stretches(self) -> tuple[laws.Stretch, ...]:
        """Return the sections as arguments of the law. Raises ValueError for screws that do not lie
        within one layer of each.
        """
        starts = [0.0, *(each.to for each in self.sections)]
        screws = None if self.screws is None else self.screws.law
        return tuple(
            laws.Stretch(start, each.to, tuple(layer for layer, _ in each.layers), screws)
            for start, each in zip(starts, self.sections, strict=False)
        )

    @functools.lru_cache(maxsize=64)  # noqa: B019 - equal shafts of many drawings have the same response
    def response(self, case: ShaftCase) -> ShaftSprings:
        """Return the compliance by member: for screws that are not stated as tight or loose, the
        geometric mean of both.

        Raises ValueError for a shaft that its supports do not hold, and for screws that do not lie
        within one layer.
        """
        if self.screws is None:
            return self._response(case, ((0.0, False),))
        choices = (True, False) if self.screws.tight is None else (self.screws.tight,)
        variants = [
            self._response(case, [(each, tight) for each in self.screws.law.directions])
            for tight in choices
        ]
        stiff, soft = variants[0], variants[-1]
        if stiff is soft:
            return stiff
        both = (np.sqrt(one * two) for one, two in zip(stiff.arrays(), soft.arrays(), strict=True))
        mean = ShaftSprings.of(both, case.names, soft.reactions)
        return replace(mean, spread=(stiff.shaft, soft.shaft))

    def _response(self, case: ShaftCase, ways: Sequence[tuple[float, bool]]) -> ShaftSprings:
        """Return the mean response to bending in these directions (rad), each with screws tight or
        loose.
        """
        stretches = self.stretches
        end = stretches[-1].end
        loads = [
            (max(place - case.width / 2, 0.0), min(place + case.width / 2, end))
            for place in self.disc_at
        ]
        soft = [(self._bearing(each, None, case), self._seat(each, case)) for each in self.supports]
        out = []
        for direction, tight in ways:
            pieces = tuple(each.piece_with_screws(direction, tight=tight) for each in stretches)

            def respond(
                soft: Sequence[tuple[float, float]], pieces: tuple[BeamPiece, ...] = pieces
            ) -> laws.ShaftCompliance:
                springs = (
                    Support(each.at, 1 / sum(both) if sum(both) else math.inf, each.tilt or 0.0)
                    for each, both in zip(self.supports, soft, strict=True)
                )
                return laws.shaft_compliance(
                    SupportedBeam(pieces, tuple(springs)),
                    stretches,
                    loads,
                    np.array(case.phases),
                    case.eccentricity,
                )

            found = respond(soft)
            if any(isinstance(each.bearing, BearingSize) for each in self.supports):
                # a bearing by its size stiffens with its load
                forces = case.force * found.reactions
                soft = [
                    (self._bearing(each, float(force), case), seat)
                    for each, force, (_, seat) in zip(self.supports, forces, soft, strict=True)
                ]
                found = respond(soft)
            out.append(found)
        by_part = np.mean([each.by_part for each in out], axis=0)
        of_supports = by_part[len(stretches) :]
        share = np.array([seat / (bearing + seat) if seat else 0.0 for bearing, seat in soft])
        of_seats = np.array(
            [
                sum(
                    part
                    for part, at in zip(of_supports * share, self.supports, strict=True)
                    if at.seat == name
                )
                for name in case.names
            ]
        )
        parts = (
            by_part[: len(stretches)],
            np.array([out[0].twist]),
            np.array([float(of_supports @ (1 - share))]),
            of_seats,
        )
        return ShaftSprings.of(
            parts, case.names, tuple(np.mean([each.reactions for each in out], axis=0).tolist())
        )

    @staticmethod
    def _bearing(support: ShaftSupport, force: float | None, case: ShaftCase) -> float:
        """Return the compliance (m/N) of a bearing, one by its size under a force (N): without a
        force it is not known yet, and rigid.
        """
        bearing = support.bearing
        if bearing is None or SHAFT_BEARINGS in case.rigid:
            return 0.0
        if not isinstance(bearing, BearingSize):
            return 1 / bearing
        if force is None:
            return 0.0
        # a bearing that carries next to nothing hardly matters
        return 1 / stiffness_of_size(
            bearing.bore, bearing.outside_diameter, max(force, _LEAST_REACTION * case.force)
        )

    @staticmethod
    def _seat(support: ShaftSupport, case: ShaftCase) -> float:
        return (
            dict(case.seats)[support.seat].compliance
            if support.seat is not None and SHAFT_SEATS not in case.rigid
            else 0.0
        )


@dataclass(frozen=True, slots=True)
class ShaftCase:
    """What loads and holds a shaft.

    seats         by name
    width         over which the force of each disc is spread, m
    phases        of the discs, rad
    eccentricity  m
    force         of each disc, N, at which bearings by their size are taken
    rigid         members declared rigid
    """

    seats: tuple[tuple[str, BearingSeat], ...]
    width: float
    phases: tuple[float, ...]
    eccentricity: float
    force: float
    rigid: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of the seats."""
        return tuple(name for name, _ in self.seats)


@dataclass(frozen=True, slots=True)
class ShaftSprings:
    """Displacement of a disc per force on every disc (m/N) by member: sections, torsion between
    discs, bearings, seats by name.

    reactions  force on each support per force on every disc
    spread     smallest and largest part of the shaft itself, for screws of which it is not stated
               whether they are tight; else zeros
    """

    sections: tuple[float, ...]
    twist: float
    bearings: float
    seats: dict[str, float]
    reactions: tuple[float, ...]
    spread: tuple[float, float] = (0.0, 0.0)

    @classmethod
    def of(
        cls, parts: Iterable[Floats], seats: Iterable[str], reactions: tuple[float, ...]
    ) -> ShaftSprings:
        """Return the springs from arrays of sections, torsion, bearings and seats."""
        sections, twist, bearings, of_seats = parts
        return cls(
            tuple(sections.tolist()),
            float(twist[0]),
            float(bearings[0]),
            dict(zip(seats, of_seats.tolist(), strict=True)),
            reactions,
        )

    def arrays(self) -> tuple[Floats, ...]:
        """Return sections, torsion, bearings and seats as arrays."""
        return (
            np.array(self.sections),
            np.array([self.twist]),
            np.array([self.bearings]),
            np.array(list(self.seats.values())),
        )

    @property
    def shaft(self) -> float:
        """Return the part of bending, shear and torsion of the shaft itself, m/N."""
        return sum(self.sections) + self.twist

    @property
    def total(self) -> float:
        """Return the whole compliance, m/N."""
        return self.shaft + self.bearings + sum(self.seats.values())
