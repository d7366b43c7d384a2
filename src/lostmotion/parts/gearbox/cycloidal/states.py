"""What is known of each member of a cycloidal gearbox: stated, computed, assumed, bounded, ideal or
absent; and how far the unknown may lie off.

Nothing is rigid in silence. A member that follows from dimensions of the drawing is computed. One
that the drawing does not describe is bounded: its compliance lies between 0.05 times and once that
of all members of its stage together, the frame's that of the whole gearbox.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal

from lostmotion.band import Band
from lostmotion.laws.rolling.by_size import STIFFNESS_BAND
from lostmotion.parts.gearbox.cycloidal import names
from lostmotion.parts.gearbox.cycloidal.frame import GearboxFrame
from lostmotion.parts.gearbox.cycloidal.seats import BearingSize
from lostmotion.parts.gearbox.cycloidal.shaft import Shaft
from lostmotion.parts.gearbox.cycloidal.springs import (
    BOUNDS,
    CRANK_HOLES_OF_UNKNOWN_SIZE,
    HOLES_OF_UNKNOWN_SIZE,
)

if TYPE_CHECKING:
    from lostmotion.parts.gearbox.cycloidal.stage import CycloidalStage
    from lostmotion.parts.gearbox.cycloidal.stages import CycloidalStages

Kind = Literal["stated", "computed", "assumed", "bounded", "ideal", "absent"]
# Largest share of the wind-up due to members before the eccentric at the ratio of 15; it falls with
# the square of the ratio.
_INPUT_SHARE: Final = 0.01
_INPUT_RATIO: Final = 15
# Bounds, over the computed members, below which a member before the eccentric is not worth a range
# of its own.
_NEGLIGIBLE: Final = 0.05


@dataclass(frozen=True, slots=True)
class MemberState:
    """What is known of a member, with a reason where it is not stated or computed from stated
    dimensions.
    """

    kind: Kind
    reason: str = ""

    def __str__(self) -> str:
        """Return the state as text."""
        return f"{self.kind}: {self.reason}" if self.reason else self.kind


@dataclass(frozen=True, slots=True)
class Unknown:
    """A quantity of the design that the drawing does not state: one value for all gearboxes of the
    drawing.

    factor  on the compliance of the members: uniform in its logarithm, with the middle one
    shares  share of each member's wind-up that is proportional to it
    """

    name: str
    factor: Band
    shares: dict[str, float]


def member_states(gearbox: CycloidalStages) -> dict[str, MemberState]:
    """Return what is known of each member of a gearbox, by name."""
    out = _of_stage(gearbox)
    first, frame = gearbox.first_stage, gearbox.frame
    if first is not None and first.kind == "cycloidal":
        out |= {f"{names.FIRST_STAGE}{name}": state for name, state in _of_stage(first).items()}
    elif first is not None:
        bounded = MemberState(
            "bounded",
            (
                f"at most {100 * _input_bounds(gearbox)[1]:.3g} % of the computed members, by the "
                "ratio"
            ),
        )
        out[names.FIRST] = MemberState("stated") if first.mesh_stiffness is not None else bounded
    out[names.FRAME] = _bounded()
    if isinstance(frame, GearboxFrame):
        if frame.tube is not None:
            out[names.FRAME] = MemberState("computed")
        if frame.screws is not None:
            out[names.FRAME_SCREWS] = MemberState(
                "computed" if frame.screws.slip else "assumed",
                "" if frame.screws.slip else "without preload",
            )
    elif frame is not None:
        out[names.FRAME] = MemberState("stated")
    if gearbox.input_shaft is not None:
        out[names.INPUT] = MemberState("stated")
    elif gearbox.input_twist is not None:
        out[names.INPUT] = MemberState(
            "computed", "from the driven end of the eccentric's shaft to its first disc"
        )
    else:
        out[names.INPUT] = MemberState(
            "bounded",
            (
                f"at most {100 * _input_bounds(gearbox)[1]:.3g} % of the computed members, by the "
                "ratio"
            ),
        )
    return out | {name: MemberState("ideal", "declared rigid") for name in gearbox.rigid}


def bounds(gearbox: CycloidalStages) -> dict[str, tuple[float, float]]:
    """Return the smallest and largest compliance of each bounded member, over that of the computed
    members of its stage or of the gearbox.
    """
    of_input = (names.FIRST, names.INPUT)
    states = member_states(gearbox)
    return {
        name: _input_bounds(gearbox) if name in of_input else BOUNDS
        for name, state in states.items()
        if state.kind == "bounded"
    }


def unknowns(gearbox: CycloidalStages) -> tuple[Unknown, ...]:
    """Return what the drawing does not state, each with its effect on the members; bounded members
    last, without negligible ones.
    """
    out = [*_unknowns(gearbox, "")]
    first = gearbox.cycloidal_first_stage
    if first is not None:
        out += _unknowns(first, names.FIRST_STAGE)
    limits = {name: limit for name, limit in bounds(gearbox).items() if limit[1] > _NEGLIGIBLE}
    return (
        *out,
        *(_around(name, *limit, {f"{name}{names.BOUNDED}": 1.0}) for name, limit in limits.items()),
    )


def _input_bounds(gearbox: CycloidalStages) -> tuple[float, float]:
    most = min(_INPUT_SHARE * (_INPUT_RATIO / abs(gearbox.ratio)) ** 2, 1.0)
    return BOUNDS[0] * most, BOUNDS[1] * most


def _bounded() -> MemberState:
    return MemberState("bounded", f"{BOUNDS[0]:g} to {BOUNDS[1]:g} times the computed members")


def _around(name: str, low: float, high: float, shares: dict[str, float]) -> Unknown:
    """Return an unknown whose tables hold the geometric mean of its limits."""
    reach = math.sqrt(high / low)
    return Unknown(name, Band(1 / reach, reach, "log-uniform"), shares)


def _of_stage(stage: CycloidalStage) -> dict[str, MemberState]:
    computed, pins = MemberState("computed"), stage.output_pins
    out = {names.CONTACTS: computed}
    if stage.form == "ring pins":
        out[names.RING_PINS] = (
            computed
            if stage.pin_span is not None
            else MemberState("assumed", "in seats along their full length, without bending")
        )
    elif stage.form == "planet pins":
        out[names.PLANET_PINS] = _bounded()
    else:
        out[names.RING_LOBES] = MemberState(
            "computed",
            "in the body of the ring"
            if stage.elastic_bodies and names.RING_BODY not in stage.rigid
            else "",
        )
    out |= _of_bodies(stage) | _of_shaft(stage)
    if stage.eccentric.cranks > 1:
        out[names.PINS] = MemberState("absent", "the cranks carry the output")
    elif pins is None or (pins.stiffness is None and pins.diameter is None):
        out[names.PINS] = _bounded()
    elif pins.stiffness is not None:
        out[names.PINS] = MemberState("stated", "with seats and holes")
    else:
        out[names.PINS] = computed
        out[names.SEATS] = MemberState(
            "assumed" if pins.unknown_seats else "computed", pins.unknown_seats
        )
        if pins.sleeve is not None and pins.sleeve.rollers is not None:
            out[names.NEEDLES] = computed
        out[names.HOLES] = (
            computed
            if stage.disc.holes is not None
            else MemberState("assumed", "diameter of pin, twice the eccentricity and clearance")
        )
    return out | {
        name: MemberState("ideal", "declared rigid")
        for name in stage.rigid
        if name in names.STAGE_MEMBERS
    }


def _of_bodies(stage: CycloidalStage) -> dict[str, MemberState]:
    if not stage.elastic_bodies:
        return {names.DISC_BODY: _bounded(), names.RING_BODY: _bounded()}
    reasons = (
        []
        if stage.disc_bore_radius is not None
        else [f"a bore of {2e3 * stage.bore_radius:.3g} mm"]
    )
    if stage.output_pins is not None and stage.hole_diameter is None:
        low, high = HOLES_OF_UNKNOWN_SIZE
        reasons.append(f"holes of unknown size, {low:g} to {high:g} times a solid disc")
    elif stage.eccentric.cranks > 1 and _unknown_crank_holes(stage):
        low, high = CRANK_HOLES_OF_UNKNOWN_SIZE
        reasons.append(
            f"crank holes of {1e3 * (stage.hole_diameter or 0.0):.3g} mm, {low:g} to "
            f"{high:.2g} times their wind-up"
        )
    elif stage.eccentric.cranks > 1:
        pass
    elif stage.hole_diameter is not None and stage.disc.holes is None:
        reasons.append(f"holes of {1e3 * stage.hole_diameter:.4g} mm")
    out = {names.DISC_BODY: MemberState("assumed" if reasons else "computed", ", ".join(reasons))}
    ring = (
        ""
        if stage.ring_outer_radius is not None
        else f"held at an outer radius of {1e3 * stage.outer_radius:.3g} mm"
    )
    return {**out, names.RING_BODY: MemberState("assumed" if ring else "computed", ring)}


def _unknown_crank_holes(stage: CycloidalStage) -> bool:
    """Return whether the discs have holes for several cranks of which the drawing states neither
    the size nor that of the bearings.
    """
    return (
        stage.eccentric.cranks > 1
        and stage.disc.holes is None
        and not isinstance(stage.eccentric.bearing, BearingSize)
    )


def _of_fit(*, known: bool) -> MemberState:
    return (
        MemberState("computed") if known else MemberState("assumed", "fit between bonded and snug")
    )


def _of_shaft(stage: CycloidalStage) -> dict[str, MemberState]:
    eccentric, out = stage.eccentric, dict[str, MemberState]()
    by_size = isinstance(eccentric.bearing, BearingSize)
    if eccentric.rollers is not None or by_size:
        out[names.BEARING] = (
            MemberState("assumed", "balls by the size of the bearing")
            if by_size
            else MemberState("computed")
        )
    else:
        out[names.BEARING] = _bounded() if eccentric.bearing is None else MemberState("stated")
    if stage.tilt_share:
        out[names.TILT] = MemberState("computed")
    if eccentric.cranks > 1:
        out[names.BORE] = MemberState(
            "absent", "the bearings of the cranks push on the holes in the body of the disc"
        )
    elif stage.elastic_bodies:
        known = stage.disc.bore_fit is not None or eccentric.cup is not None
        out[names.BORE] = (
            MemberState("computed")
            if known
            else MemberState("assumed", "fit between pressed and snug")
        )
    shaft = eccentric.shaft
    if not isinstance(shaft, Shaft):
        out[names.SHAFT] = (
            _bounded() if shaft is None else MemberState("stated", "with its bearings and seats")
        )
        return out
    loose = shaft.screws is not None and shaft.screws.tight is None
    out[names.SHAFT] = (
        MemberState("assumed", "screws between loose and tight")
        if loose
        else MemberState("computed")
    )
    if any(each.bearing is None for each in shaft.supports):
        out[names.SHAFT_BEARINGS] = _bounded()
    else:
        sized = any(isinstance(each.bearing, BearingSize) for each in shaft.supports)
        out[names.SHAFT_BEARINGS] = (
            MemberState("assumed", "balls by the size of the bearings")
            if sized
            else MemberState("stated")
        )
    seats = [None if each.seat is None else stage.seats[each.seat] for each in shaft.supports]
    bounded = any(seat is None for seat in seats)
    out[names.SHAFT_SEATS] = (
        _bounded()
        if bounded
        else _of_fit(known=all(seat is None or seat.fit is not None for seat in seats))
    )
    return out


def _unknowns(stage: CycloidalStage, prefix: str) -> list[Unknown]:
    """Return what the drawing of a stage does not state, beside bounded members."""
    pins, out = stage.output_pins, _unknowns_of_shaft(stage)
    if isinstance(stage.eccentric.bearing, BearingSize):
        out.append(_around("eccentric bearing by its size", *STIFFNESS_BAND, {names.BEARING: 1.0}))
    if stage.bore_compliance and _of_shaft(stage)[names.BORE].kind == "assumed":
        out.append(_around("fit of the eccentric bearing in its bore", *BOUNDS, {names.BORE: 1.0}))
    if pins is not None and pins.unknown_seats and names.SEATS not in stage.rigid:
        stiff, soft = (
            sum(each.compliance(stage.discs, rigid=stage.rigid)) for each in stage.pin_limits
        )
        open_point = (
            "seats of the output pins"
            if pins.seat is None
            else "fit of the output pins in their seats"
        )
        out.append(_around(open_point, stiff, soft, {names.PINS: 1.0, names.SEATS: 1.0}))
    if stage.elastic_bodies and (
        _unknown_crank_holes(stage) or (pins is not None and stage.hole_diameter is None)
    ):
        limits = HOLES_OF_UNKNOWN_SIZE if pins is not None else CRANK_HOLES_OF_UNKNOWN_SIZE
        out.append(_around("holes of the discs", *limits, {names.DISC_BODY: 1.0}))
    out = [each for each in out if not set(each.shares) <= set(stage.rigid)]
    return [
        replace(
            each,
            name=f"{prefix}{each.name}",
            shares={f"{prefix}{name}": share for name, share in each.shares.items()},
        )
        for each in out
    ]


def _unknowns_of_shaft(stage: CycloidalStage) -> list[Unknown]:
    shaft, springs = stage.eccentric.shaft, stage.shaft_springs
    if springs is None or not isinstance(shaft, Shaft):
        return []
    out = []
    if shaft.screws is not None and shaft.screws.tight is None:
        out.append(
            _around(
                "screws of the eccentric shaft, loose or tight", *springs.spread, {names.SHAFT: 1.0}
            )
        )
    if any(isinstance(each.bearing, BearingSize) for each in shaft.supports):
        out.append(
            _around(
                "bearings of the eccentric shaft by their size",
                *STIFFNESS_BAND,
                {names.SHAFT_BEARINGS: 1.0},
            )
        )
    of_seats = sum(springs.seats.values())
    for name, part in springs.seats.items():
        if part and stage.seats[name].fit is None:
            out.append(
                _around(
                    f"fit of the seat {name}",
                    *stage.seats[name].compliances,
                    {names.SHAFT_SEATS: part / of_seats},
                )
            )
    return out
