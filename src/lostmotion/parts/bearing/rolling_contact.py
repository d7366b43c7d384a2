"""Bearings from their drawing: rolling elements in one-sided contact, with a dead band of the
mounted clearance and a hardening stiffness.
"""

from __future__ import annotations

import functools
from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from lostmotion.laws.distributions import TwoSided, of_tolerance
from lostmotion.laws.rolling.table import Pair, ShiftTable, shift_table
from lostmotion.parts.bearing.bearing import BearingFigures
from lostmotion.parts.bearing.fits import MountedBearing
from lostmotion.parts.bearing.rolling import SIDES, closing_friction, per_shift
from lostmotion.parts.bearing.runout import runout_terms
from lostmotion.parts.error_source import (
    Friction,
    FrictionForce,
    LengthAmount,
)
from lostmotion.parts.load_table import LoadTable, ShaftOnRows
from lostmotion.parts.play import Seat
from lostmotion.parts.provenance import with_friction
from lostmotion.parts.standard_terms import (
    ENVIRONMENT,
    VARIATION,
    circle,
    free_play_variation,
    free_terms,
    varying,
)
from lostmotion.parts.term import Draw, Holding, Motion, Parameter, Term
from lostmotion.units import Toleranced

if TYPE_CHECKING:
    from collections.abc import Callable

    from typing_extensions import TypeIs

    from lostmotion.spatial import Floats

# Step of the clearance for finite differences, m.
_STEP: Final = 1e-6


class DrawnBearing(MountedBearing, BearingFigures):
    """Base class of bearings described by a drawing.

    closing_force  under a load below it on one bearing its clearance stays open; default: 2 % of
                   the largest load on one bearing at rest, in any pose on any slope. ± is its
                   scatter over joints; default: ±50 %
    radial_runout, axial_runout  full indicator reading over a turn

    Rings, shaft and housing are assumed rigid, without friction. Loads on the elements and the
    shaft's displacement are those of `laws.rolling.equilibrium`, interpolated in
    `laws.rolling.table` for each pose.
    """

    by_drawing: ClassVar[bool] = True
    closing_force: FrictionForce | None = None
    radial_runout: LengthAmount = 0.0
    axial_runout: LengthAmount = 0.0

    @property
    def assumptions(self) -> dict[str, str]:
        """Return the values that are not stated as facts: key to reason, with the default
        friction.
        """
        return with_friction(super().assumptions, "closing_force", self.play_friction(Holding))

    @property
    @abstractmethod
    def rows(self) -> Pair:
        """Return the rows on the shaft, z along the joint's axis, and their pressure centres."""

    @property
    @abstractmethod
    def bearings(self) -> int:
        """Return the number of bearings, each with its own clearance."""

    @property
    def is_single(self) -> bool:
        """Return whether this is a single row, which carries almost no moment."""
        return False

    @abstractmethod
    def pressure(self, load: Floats) -> Floats:
        """Return the contact pressure (Pa) of elements under these loads (N) at the inner race."""

    @functools.cached_property
    def static_load(self) -> float:
        """Return the load (N) of an element at the static pressure limit: 4 200 MPa for balls, 4
        000 MPa for rollers (ISO 76).
        """
        limit, power = (4200e6, 3) if self.elements == "ball" else (4000e6, 2)
        return float((limit / self.pressure(np.ones(1))[0]) ** power)

    @property
    def top(self) -> float:
        """Return the largest load (N) of the table: a third of the elements at their static
        limit.
        """
        return sum(self.static_load * seat.row.count / 3 for seat in self.rows.seats)

    def table(self, clearance: float) -> ShiftTable:
        """Return the shifts under load at one clearance (m)."""
        return shift_table(self.rows, clearance, self.top)

    @property
    @abstractmethod
    def largest_clearance(self) -> float:
        """Return the largest clearance or preload (m) at which the laws are valid: they assume
        small displacements of the elements.
        """

    @property
    def clearance_error(self) -> tuple[str, str, str] | None:
        """Return what was found, what is expected and an example for a working clearance, or a
        preload, beyond `largest_clearance`.
        """
        spread, most = self.spreads["working"], self.largest_clearance
        if max(spread.highest, -spread.lowest) <= most:
            return None
        found = f"a working clearance of {spread.lowest * 1e6:.4g} to {spread.highest * 1e6:.4g} µm"
        return (
            found,
            f"one within ±{most * 1e6:.4g} µm for elements of this size",
            'clearance = "15 µm ± 8 µm"',
        )

    @property
    def has_fits(self) -> bool:
        """Return that its clearance follows from fits."""
        return True

    def temperature_error(self, rise: Toleranced | None) -> tuple[str, str, str] | None:
        """Return what is wrong with the working clearance at this temperature rise; None where it
        is valid.
        """
        problem = self.warmed(rise).clearance_error
        return problem and (f"{problem[0]} at the temperature of the arm", *problem[1:])

    def terms(self, motion: Motion) -> list[Term]:
        """Return the shift of the shaft in the clearance under load, its free play, elastic
        deflection, scatter over bearings, and runout.
        """
        return self.warmed(motion.rise)._terms(motion, self.clearance_per_kelvin(motion.rise))  # noqa: SLF001 - of the same class

    def _terms(self, motion: Motion, per_kelvin: float) -> list[Term]:
        axis, out = motion.axis, []
        along, names = np.concatenate([np.zeros(3), axis]), [name for name, _ in SIDES]
        streams = [f"{name} amount" if self.bearings > 1 else "amount" for name in names]
        robots = [Draw(stream, of_tolerance(self.working.law)) for stream in streams]
        spread = self.working.tolerance / robots[0].law.bound
        shaft = self._shaft(motion, along, varies=bool(per_kelvin))
        play, clearance, stiffness, expansion = (
            self.working.nominal,
            Parameter("clearance"),
            Parameter("stiffness"),
            Parameter("thermal expansion"),
        )
        for k, (name, seat, robot) in enumerate(zip(names, shaft.seats, robots, strict=False)):
            out.append(
                Term(
                    f"{name} deflection",
                    "deflection",
                    LoadTable(shaft, "deflects", k),
                    parameter=stiffness,
                    exponent=-1,
                )
            )
            if play > 0:
                held = LoadTable(shaft, "held", k)
                out.append(
                    Term(
                        f"{name} clearance side held by load",
                        "clearance",
                        held,
                        parameter=clearance,
                    )
                )
                ends = circle(f"{name} clearance", f"{name} clearance position", seat.way, axis)
                out += free_terms("clearance", seat, ends, play / 2, spread / 2, robot, clearance)
                if per_kelvin:
                    out += free_play_variation(seat, ends, per_kelvin / 2, motion, expansion)
        rows = {stream: tuple(k for k in (0, 1) if streams[k] == stream) for stream in streams}
        if shaft.axial:
            out += self._along(shaft, along)
            rows = {stream: (*each, 2) for stream, each in rows.items()}
        for robot in dict.fromkeys(robots) if spread else ():
            for k in rows[robot.stream]:
                side = (*names, "axial")[k]
                name = robot.stream if side in robot.stream else f"{side} {robot.stream}"
                # The axial load is shared by all bearings.
                size = spread / len(rows) if side == "axial" else spread
                out.append(
                    Term(
                        name,
                        "clearance",
                        LoadTable(shaft, "grows", k),
                        size,
                        robot,
                        parameter=clearance,
                        effect=robot.stream,
                    )
                )
        if per_kelvin and motion.rise is not None:
            for k, side in enumerate((*names, "axial")[: 3 if shaft.axial else 2]):
                form, name = LoadTable(shaft, "grows", k), f"{side} {VARIATION}"
                out += varying(
                    name,
                    form,
                    motion.rise,
                    motion,
                    expansion,
                    shared=ENVIRONMENT,
                    per_kelvin=per_kelvin,
                    cause=VARIATION,
                )
        return out + (
            runout_terms(axis, self.radial_runout, self.axial_runout) if motion.turning else []
        )

    def _shaft(self, motion: Motion, along: Floats, *, varies: bool) -> ShaftOnRows:
        rows, friction = self.rows, self.play_friction(motion.holding)
        closing = Toleranced(0.0) if friction is None else friction.load
        behind, ahead = (
            Seat(
                per_shift(motion.axis, side, rows.span),
                closing,
                min(rows.span, 1.0),
                f"{name} friction",
            )
            for name, side in SIDES
        )
        wider = (
            self.table(self.working.nominal + _STEP) if self.working.tolerance or varies else None
        )
        seats = behind, ahead, Seat(along[None], closing, stream="axial friction")
        return ShaftOnRows(
            seats, motion.turning and rows.axial, self.table(self.working.nominal), wider, _STEP
        )

    def _along(self, shaft: ShaftOnRows, along: Floats) -> list[Term]:
        """Return deflection and play along the axis."""
        stiffness, clearance = Parameter("axial stiffness"), Parameter("clearance")
        out = [
            Term(
                "axial deflection",
                "axial deflection",
                LoadTable(shaft, "deflects", 2),
                parameter=stiffness,
                exponent=-1,
            )
        ]
        if self.working.nominal > 0:
            half = float(shaft.table.edges(*np.array([[0.0], [0.0], [1.0]]))[0, 2])
            free, side = LoadTable(shaft, "free", 2, along), Draw("axial side", TwoSided())
            out.append(
                Term(
                    "axial play side held by load",
                    "axial play",
                    LoadTable(shaft, "held", 2),
                    parameter=clearance,
                )
            )
            out.append(
                Term("axial play", "axial play", free, half, visit=side, parameter=clearance)
            )
        return out

    def play_friction(self, holding: Callable[[], Holding]) -> Friction | None:
        """Return the closing force that is stated, or else assumed; None where every bearing is
        preloaded.
        """
        some_have_play = self.working.nominal + self.working.tolerance > 0
        return (
            closing_friction(self.closing_force, self.rows.span, holding)
            if some_have_play
            else None
        )


def is_drawn_bearing(bearing: object) -> TypeIs[DrawnBearing]:
    """Return whether a bearing is described by its drawing and not by stated figures."""
    return isinstance(bearing, DrawnBearing)
