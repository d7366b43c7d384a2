"""Four of the six forms in which an error follows from angle, load and gravity: everything that a part can do is one of them.

Constant, Harmonic (of the joint's angle), Spring (a curve along one motion) and Linear (a compliance matrix); the other two are HeldPlay (a play that
a load closes, `parts.play`) and LoadTable (shifts tabulated over several loads, `parts.load_table`). Arrays have the pose last.
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
    """A piecewise linear function of a load of zero or more: `value` at each `load` (n,), rising; beyond the last it goes on with slope `beyond`."""

    load: Floats
    value: Floats
    beyond: float = 0.0

    @classmethod
    def of_zones(cls, stiffness: Sequence[float], limits: Sequence[float]) -> Curve:
        """Return the wind-up over the load of a spring in zones: stiffness N m/rad or N/m, limits one fewer, rising, N m or N."""
        load = np.array([0.0, *limits])
        steps = np.diff(load) / np.array(stiffness[:-1])
        return cls(load, np.array([0.0, *np.cumsum(steps)]), 1 / stiffness[-1])

    @classmethod
    def through(cls, load: Floats, value: Floats) -> Curve:
        """Return the curve through these points that goes on straight beyond the last one."""
        return cls(load, value, float((value[-1] - value[-2]) / (load[-1] - load[-2])))

    def __call__(self, load: Floats) -> Floats:
        """Return the value at loads (any shape) of zero or more."""
        out = np.interp(load, self.load, self.value)
        return np.asarray(out + np.maximum(load - self.load[-1], 0.0) * self.beyond if self.beyond else out)

    def slope(self, load: Floats) -> Floats:
        """Return the slope at loads (any shape) of zero or more; at a knot that of the side of larger loads."""
        steps = np.append(np.diff(self.value) / np.diff(self.load), self.beyond)
        return np.asarray(np.where(load < self.load[0], 0.0, steps[np.searchsorted(self.load, load, "right") - 1]))


class _Along(Form):
    """A form along one fixed unit twist `direction` (6,), of a size that depends on the condition."""

    direction: Floats

    @abstractmethod
    def size(self, at: Condition) -> Floats | float:
        """Return the size (pose,), or one for all poses."""

    def screw(self, at: Condition) -> Floats:
        """Return the screw (6, pose)."""
        return np.asarray(self.direction[:, None] * np.broadcast_to(at.once(self, lambda: self.size(at)), len(at.angle)))

    def write(self, at: Condition, scale: float, out: Floats) -> None:
        """Write the screw times `scale` into `out` (6, pose)."""
        size = at.once(self, lambda: self.size(at)) * scale
        for row, weight in zip(out, self.direction, strict=True):
            row[:] = weight * size if weight else 0.0


@dataclass(frozen=True, eq=False)
class Constant(_Along):
    """The same screw at every pose."""

    direction: Floats

    @property
    def reads(self) -> tuple[str, ...]:
        """Return that it depends on nothing."""
        return ()

    def size(self, at: Condition) -> float:  # noqa: ARG002 - it depends on nothing
        """Return one."""
        return 1.0


@dataclass(frozen=True, eq=False)
class Harmonic(_Along):
    """The sine or the cosine of `order` times the angle that has been turned.

    turns     turning in rad per unit of the joint's value, for the screw of a sliding joint; None where the joint itself turns
    envelope  amplitude over the size of the load along `direction`; None: one
    """

    direction: Floats
    order: float
    phase: Literal["sine", "cosine"]
    turns: float | None = None
    envelope: Curve | None = None

    @property
    def reads(self) -> tuple[str, ...]:
        """Return that it depends on the angle, and with an envelope on the load."""
        return ("angle",) if self.envelope is None else ("angle", "wrench")

    def size(self, at: Condition) -> Floats:
        """Return the harmonic (pose,)."""
        # Order and turns are not folded into one factor: that alone would move a harmonic of 1 000 rad by 1e-12.
        turned = at.angle if self.turns is None else at.angle * self.turns
        out = (np.sin if self.phase == "sine" else np.cos)(self.order * turned)
        envelope = self.envelope
        return np.asarray(out if envelope is None else out * at.once(envelope, lambda: envelope(np.abs(at.along(self.direction)))))


@dataclass(frozen=True, eq=False)
class Spring(_Along):
    """A curve over the load along the same motion, odd in the load; with `odd` False even: half the width of a friction loop, which is no spring."""

    direction: Floats
    curve: Curve
    odd: bool = True

    @property
    def elastic(self) -> bool:
        """Return whether it is a spring."""
        return self.odd

    def size(self, at: Condition) -> Floats:
        """Return the deflection (pose,), rad or m."""
        load = at.along(self.direction)
        value = self.curve(np.abs(load))
        return np.asarray(np.sign(load) * value if self.odd else value)

    def compliance(self, at: Condition) -> Floats:
        """Return the tangent (pose, 6, 6), at a knot of the curve that on the side of larger loads."""
        slope = self.curve.slope(np.abs(at.along(self.direction)))
        return np.asarray(np.multiply.outer(slope * self.odd, np.outer(self.direction, self.direction)))


@dataclass(frozen=True, eq=False)
class Linear(Form):
    """A compliance `matrix` (6, 6) times the wrench, and `own_weight` (6, 3) times gravity."""

    matrix: Floats
    own_weight: Floats | None = None

    @property
    def reads(self) -> tuple[str, ...]:
        """Return whether it depends on load and gravity."""
        return (*(("wrench",) if self.elastic else ()), *(("gravity",) if self.own_weight is not None else ()))

    @property
    def elastic(self) -> bool:
        """Return whether a load moves it."""
        return bool(self.matrix.any())

    def screw(self, at: Condition) -> Floats:
        """Return the deflection (6, pose)."""
        out = rows_times(self.matrix, at.wrench)
        return out if self.own_weight is None else out + rows_times(self.own_weight, at.gravity)

    def compliance(self, at: Condition) -> Floats:
        """Return the matrix for every pose (pose, 6, 6)."""
        return np.broadcast_to(self.matrix, (len(at.angle), 6, 6))
