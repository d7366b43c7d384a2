"""The forms of error terms as directions times products of factors, collected for one place."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.controller_model.tables import (
    CLOSED,
    DIFFERS,
    ONE,
    OPEN,
    ExportedCurve,
    ExportedFriction,
    ExportedHarmonic,
    ExportedLoadTable,
    ExportedSeat,
    ExportedThreshold,
)
from lostmotion.laws.distributions import Normal, of_tolerance
from lostmotion.parts import forms, load_table, play

if TYPE_CHECKING:
    from collections.abc import Hashable

    from lostmotion.parts.forms import Curve
    from lostmotion.parts.play import AnySeat, Seat
    from lostmotion.parts.term import Form, Threshold
    from lostmotion.spatial import Floats

Kind = Literal["curve", "harmonic", "seat", "threshold", "table"]
# A factor: its kind, its index among those of that kind at the place, and which of its numbers.
Factor = tuple[Kind, int, int]
# What a size is the product of.
Size = tuple[Factor, ...]

_NUMBERS: Final[dict[Kind, int]] = {"curve": 1, "harmonic": 1, "threshold": 3, "table": 9}
_STATES: Final = ("deflects", "held", "grows")


@dataclass
class Factors:
    """The factors at one place, each stored once.

    turn    (6, 6) turns the arm's axes of the place into those of its record
    limits  (2,) of the joint of the place, rad or m; None without a joint
    """

    turn: Floats
    limits: Floats | None = None
    curves: list[ExportedCurve] = field(default_factory=list)
    harmonics: list[ExportedHarmonic] = field(default_factory=list)
    seats: list[ExportedSeat] = field(default_factory=list)
    thresholds: list[ExportedThreshold] = field(default_factory=list)
    tables: list[ExportedLoadTable] = field(default_factory=list)
    sizes: list[Size] = field(default_factory=lambda: [()])
    _known: dict[Hashable, int] = field(default_factory=dict)

    def size(self, factors: Size) -> int:
        """Return the index of a size."""
        ordered = tuple(sorted(factors))
        if ordered not in self.sizes:
            self.sizes.append(ordered)
        return self.sizes.index(ordered)

    def numbered_sizes(self) -> tuple[tuple[int, int, int], ...]:
        """Return the indices of the factors of each size, filled up with ONE."""
        first: dict[tuple[Kind, int], int] = {}
        count = 1
        for k in range(len(self.curves)):
            first["curve", k] = count + k
        count += len(self.curves)
        for k in range(len(self.harmonics)):
            first["harmonic", k] = count + k
        count += len(self.harmonics)
        for k, seat in enumerate(self.seats):
            first["seat", k] = count
            count += len(seat.way)
        for kind, found in (("threshold", self.thresholds), ("table", self.tables)):
            for k in range(len(found)):
                first[kind, k] = count  # type: ignore[index]
                count += _NUMBERS[kind]  # type: ignore[index]
        out = []
        for size in self.sizes:
            numbers = [first[kind, index] + part for kind, index, part in size]
            one, two, three = (*numbers, ONE, ONE, ONE)[:3]
            out.append((one, two, three))
        return tuple(out)

    def of_form(self, form: Form) -> list[tuple[Size, Floats]]:
        """Return the sizes of a form, without its threshold, and their directions (6,) in the axes
        of the record.

        Raises TypeError for a form that is linear in the wrench, and for one that is not known.
        """
        match form:
            case forms.Constant(direction=direction, travel=travel):
                return [(self._travel(travel), self.turn @ direction)]
            case forms.Harmonic(
                direction=direction, order=order, phase=phase, turns=turns, envelope=envelope
            ):
                harmonic = self._harmonic(
                    ExportedHarmonic(order, 1.0 if turns is None else turns, phase == "cosine")
                )
                own: Size = (
                    () if envelope is None else (self.curve(direction, envelope, odd=False),)
                )
                return [((harmonic, *own), self.turn @ direction)]
            case forms.Spring(
                direction=direction, curve=curve, odd=odd, travel=travel, fed_forward=weights
            ):
                load = self.curve(direction, curve, odd=odd, weights=weights)
                return [((load, *self._travel(travel)), self.turn @ direction)]
            case play.HeldPlay(direction=direction) | load_table.LoadTable(direction=direction) if (
                direction is not None
            ):
                return [((), self.turn @ direction)]
            case play.HeldPlay(seat=seat):
                return self._along_load(seat, ())
            case load_table.LoadTable(shaft=shaft, state=state, row=row):
                value: Factor = ("table", self._table(shaft), 3 * row + _STATES.index(state))
                seat = shaft.seats[row]
                # Axial values have a sign; radial ones are sizes along the load.
                return (
                    [((value,), self.turn @ seat.way[0])]
                    if row == len(shaft.seats) - 1
                    else self._along_load(seat, (value,))
                )
            case _:
                raise TypeError(f"a form without factors: {type(form).__name__}")

    def threshold(self, threshold: Threshold, *, above: bool) -> tuple[Factor, Factor, float]:
        """Return the factors of a form that exists where a play is closed (`above`), or open.

        One factor of its mean over robots, one of the change from robot to robot, and the sign of
        the change.
        """
        seats = _seats(threshold)
        key = ("threshold", seats)
        if key not in self._known:
            self._known[key] = len(self.thresholds)
            self.thresholds.append(ExportedThreshold(tuple(self._friction(seat) for seat in seats)))
        index = self._known[key]
        return (
            ("threshold", index, CLOSED if above else OPEN),
            ("threshold", index, DIFFERS),
            1.0 if above else -1.0,
        )

    def curve(self, direction: Floats, curve: Curve, *, odd: bool, weights: bool = False) -> Factor:
        """Return the factor of a curve of the load along a direction (6,) of the arm's place; of
        the load by the weights alone with `weights`.
        """
        key = (
            "curve",
            direction.tobytes(),
            curve.load.tobytes(),
            curve.value.tobytes(),
            curve.beyond,
            odd,
            weights,
        )
        if key not in self._known:
            self._known[key] = len(self.curves)
            slope = np.append(np.diff(curve.value) / np.diff(curve.load), curve.beyond)
            width = np.append(np.diff(curve.load), math.inf)
            self.curves.append(
                ExportedCurve(
                    self.turn @ direction,
                    odd,
                    float(curve.value[0]),
                    curve.load,
                    width,
                    slope,
                    weights,
                )
            )
        return ("curve", self._known[key], 0)

    def _travel(self, travel: Curve | None) -> Size:
        """Return the factor of a curve over the joint value, between the limits; none without
        one.
        """
        if travel is None:
            return ()
        if self.limits is None:
            raise TypeError("a form that follows the value of a joint, at a place without one")
        # A curve that began far below the limits would be a small difference of large numbers in
        # single precision.
        low, high = self.limits
        at = np.array([low, *travel.load[(travel.load > low) & (travel.load < high)], high])
        return (self.curve(np.zeros(6), type(travel)(at, travel(at)), odd=False),)

    def _harmonic(self, harmonic: ExportedHarmonic) -> Factor:
        if harmonic not in self.harmonics:
            self.harmonics.append(harmonic)
        return ("harmonic", self.harmonics.index(harmonic), 0)

    def _along_load(self, seat: Seat, others: Size) -> list[tuple[Size, Floats]]:
        index = self._seat(seat.way)
        return [((*others, ("seat", index, k)), self.turn @ way) for k, way in enumerate(seat.way)]

    def _seat(self, way: Floats) -> int:
        key = ("seat", way.tobytes())
        if key not in self._known:
            self._known[key] = len(self.seats)
            self.seats.append(ExportedSeat(way @ self.turn.T))
        return self._known[key]

    def _friction(self, seat: Seat) -> ExportedFriction:
        friction = seat.friction
        found = of_tolerance(friction.law)
        at, cut, scale = np.array([[-1.0, 0.0], [1.0, 1.0]]), 0.0, 1.0
        match found:
            case Normal(cut=cut):
                scale = cut if math.isfinite(cut) else found.stated
            case _:
                rows = getattr(found, "rows", ((-1.0, 0.0), (1.0, 1.0)))
                at = np.array(rows, dtype=float)
        start, share = at.T
        return ExportedFriction(
            self._seat(seat.way),
            seat.lever,
            friction.nominal,
            friction.tolerance,
            float(share[0]),
            start[:-1],
            np.diff(start),
            np.diff(share) / np.diff(start),
            cut,
            scale,
        )

    def _table(self, shaft: load_table.ShaftOnRows) -> int:
        key = ("table", shaft)
        if key not in self._known:
            self._known[key] = len(self.tables)
            behind, ahead, along = (self._seat(seat.way) for seat in shaft.seats)
            self.tables.append(
                ExportedLoadTable(
                    (behind, ahead, along), shaft.axial, shaft.table, shaft.wider, shaft.step
                )
            )
        return self._known[key]


def _seats(threshold: Threshold | AnySeat) -> tuple[Seat, ...]:
    match threshold:
        case play.AnySeat(seats=seats):
            return seats
        case play.Seat():
            return (threshold,)
        case _:
            raise TypeError(f"a threshold of an unknown kind: {type(threshold).__name__}")
