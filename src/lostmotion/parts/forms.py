"""Four of the six forms by which the screw of an error depends on angle, load and gravity.

Constant, Harmonic (of the joint's angle), Spring (a curve along one motion) and Linear (a
compliance matrix). The other two are HeldPlay (a play that a load closes, `parts.play`) and
LoadTable (shifts tabulated over several loads, `parts.load_table`). The pose is the last axis of
every array.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from lostmotion.parts.term import Form, rows_times

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.parts.term import Condition
    from lostmotion.spatial import Floats


@dataclass(frozen=True, eq=False)
class Curve:
    """A piecewise linear function of a load of zero or more, or of a joint's value.

    load    (n,) rising, N m or N; or rad or m
    value   (n,) value at each load, in any unit
    beyond  slope for loads above the last one
    """

    load: Floats
    value: Floats
    beyond: float = 0.0

    @classmethod
    def of_zones(cls, stiffness: Sequence[float], limits: Sequence[float]) -> Curve:
        """Return the wind-up (rad or m) over the load of a spring with a constant stiffness in each
        zone of load.

        stiffness  of each zone, N m/rad or N/m
        limits     load at the end of each zone but the last, rising, N m or N
        """
        load = np.array([0.0, *limits])
        steps = np.diff(load) / np.array(stiffness[:-1])
        return cls(load, np.array([0.0, *np.cumsum(steps)]), 1 / stiffness[-1])

    @classmethod
    def through(cls, load: Floats, value: Floats) -> Curve:
        """Return the curve through these points, load (n,) rising and value (n,), which continues
        in a straight line above the last one.
        """
        return cls(load, value, float((value[-1] - value[-2]) / (load[-1] - load[-2])))

    def __call__(self, load: Floats) -> Floats:
        """Return the value at loads (any shape) of zero or more."""
        out = np.interp(load, self.load, self.value)
        return np.asarray(
            out + np.maximum(load - self.load[-1], 0.0) * self.beyond if self.beyond else out
        )

    def slope(self, load: Floats) -> Floats:
        """Return the slope at loads (any shape) of zero or more; at a knot, the slope towards
        larger loads.
        """
        steps = np.append(np.diff(self.value) / np.diff(self.load), self.beyond)
        return np.asarray(
            np.where(load < self.load[0], 0.0, steps[np.searchsorted(self.load, load, "right") - 1])
        )


class _Along(Form):
    """A form whose screw is a fixed unit twist, `direction` (6,), times a size that depends on the
    condition.
    """

    direction: Floats

    @abstractmethod
    def size(self, at: Condition) -> Floats | float:
        """Return the size (pose,), or one number for all poses."""

    def screw(self, at: Condition) -> Floats:
        """Return the screw (6, pose)."""
        return np.asarray(
            self.direction[:, None]
            * np.broadcast_to(at.once(self, lambda: self.size(at)), len(at.angle))
        )

    def write(self, at: Condition, scales: Floats, out: Floats) -> None:
        """Write the screw times each of `scales` (term,) into `out` (6, term, pose)."""
        write_along(self.direction, at.once(self, lambda: self.size(at)) * scales[:, None], out)


def write_along(direction: Floats, sizes: Floats, out: Floats) -> None:
    """Write a direction (6,) times sizes (term, pose) into `out` (6, term, pose)."""
    out[:] = 0.0
    for row, weight in zip(out, direction.tolist(), strict=True):
        if weight:
            np.multiply(weight, sizes, out=row)


@dataclass(frozen=True, eq=False)
class Constant(_Along):
    """The same screw at every pose, or one that follows the joint's own value.

    travel  factor over the joint's value, rad or m; None: one
    """

    direction: Floats
    travel: Curve | None = None

    @property
    def reads(self) -> tuple[str, ...]:
        """Return no fields for a constant screw, "angle" for one that follows the joint's value."""
        return () if self.travel is None else ("angle",)

    def size(self, at: Condition) -> Floats | float:
        """Return one, or the factor (pose,)."""
        return 1.0 if self.travel is None else self.travel(at.angle)


@dataclass(frozen=True, eq=False)
class Harmonic(_Along):
    """The sine or the cosine of `order` times the angle of rotation.

    order     cycles per turn
    turns     rotation in rad per metre of travel of a sliding joint's screw; None for a turning
              joint
    envelope  amplitude over the absolute load along `direction`; None: one
    """

    direction: Floats
    order: float
    phase: Literal["sine", "cosine"]
    turns: float | None = None
    envelope: Curve | None = None

    @property
    def reads(self) -> tuple[str, ...]:
        """Return "angle", and with an envelope also "wrench"."""
        return ("angle",) if self.envelope is None else ("angle", "wrench")

    def size(self, at: Condition) -> Floats:
        """Return the harmonic (pose,)."""
        # Order and turns are not combined in one factor: rounding would then change a harmonic at 1
        # 000 rad by 1e-12.
        turned = at.angle if self.turns is None else at.angle * self.turns
        out = (np.sin if self.phase == "sine" else np.cos)(self.order * turned)
        envelope = self.envelope
        return np.asarray(
            out
            if envelope is None
            else out * at.once(envelope, lambda: envelope(np.abs(at.along(self.direction))))
        )


@dataclass(frozen=True, eq=False)
class Spring(_Along):
    """A curve of the load along `direction`. Odd in the load for a spring; with `odd` False even,
    as half the width of a friction loop is.

    travel  factor over the joint's value, rad or m, of a spring whose length changes with it; None:
            one
    fed_forward  the load is that of the weights alone, which a controller knows: what it adds to a
            deflection or takes off it, and no spring to other loads
    """

    direction: Floats
    curve: Curve
    odd: bool = True
    travel: Curve | None = None
    fed_forward: bool = False

    @property
    def reads(self) -> tuple[str, ...]:
        """Return "wrench" or "weight", and "angle" for a spring that follows the joint's value."""
        load = "weight" if self.fed_forward else "wrench"
        return (load,) if self.travel is None else ("angle", load)

    @property
    def elastic(self) -> bool:
        """Return whether it is a spring, which is an odd curve of the whole load."""
        return self.odd and not self.fed_forward

    def size(self, at: Condition) -> Floats:
        """Return the deflection (pose,), rad or m."""
        load = at.along(self.direction)
        if self.fed_forward:
            load = rows_times(self.direction[None], at.weight)[0]
        value = self.curve(np.abs(load)) * self._factor(at)
        return np.asarray(np.sign(load) * value if self.odd else value)

    def compliance(self, at: Condition) -> Floats:
        """Return the tangent compliance (pose, 6, 6), rad and m per N m and N; at a knot of the
        curve, the one towards larger loads.
        """
        slope = self.curve.slope(np.abs(at.along(self.direction))) * self._factor(at)
        return np.asarray(
            np.multiply.outer(slope * self.odd, np.outer(self.direction, self.direction))
        )

    def _factor(self, at: Condition) -> Floats | float:
        return 1.0 if self.travel is None else self.travel(at.angle)


@dataclass(frozen=True, eq=False)
class Linear(Form):
    """The sum of three products: matrix x wrench, own_weight x gravity, and per_kelvin x
    temperature rise.

    matrix      (6, 6) compliance, rad and m per N m and N
    own_weight  (6, 3) rad and m per m/s^2; None: no effect
    per_kelvin  (6,) rad and m per K; None: no effect
    """

    matrix: Floats
    own_weight: Floats | None = None
    per_kelvin: Floats | None = None

    @property
    def reads(self) -> tuple[str, ...]:
        """Return "wrench" where a load moves it, "gravity" where its own weight does, and
        "temperature_rise" where temperature does.
        """
        factors = {
            "wrench": self.elastic,
            "gravity": self.own_weight is not None,
            "temperature_rise": self.per_kelvin is not None,
        }
        return tuple(name for name, counts in factors.items() if counts)

    @property
    def elastic(self) -> bool:
        """Return whether a load moves it."""
        return bool(self.matrix.any())

    def screw(self, at: Condition) -> Floats:
        """Return the deflection (6, pose), rad and m."""
        out = rows_times(self.matrix, at.wrench)
        if self.own_weight is not None:
            out = out + rows_times(self.own_weight, at.gravity)
        return (
            out if self.per_kelvin is None else out + self.per_kelvin[:, None] * at.temperature_rise
        )

    def compliance(self, at: Condition) -> Floats:
        """Return the compliance matrix for every pose (pose, 6, 6)."""
        return np.broadcast_to(self.matrix, (len(at.angle), 6, 6))
