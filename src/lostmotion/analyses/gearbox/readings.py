"""Data-sheet figures read from the torque-angle curve: wind-up, stiffness, lost motion and hysteresis, for each manufactured sample.

Stiffness and lost motion are read on the middle of the loop. Lost motion: Nabtesco, RV series, data sheets (at ±3 % of the rated torque); Harmonic
Drive at ±4 %. Stiffness, by `StiffnessDefinition`: the slope between 50 and 100 % of the rated torque as most makers of planetary gearboxes state it;
b/a of Nabtesco's hysteresis curve, of which the torques are drawn rather than written and are here those of the lost motion and of the load; secant
from the middle of the play; tangent. A gearbox by stated figures counts as one sample.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, Protocol

import numpy as np

from lostmotion.laws.gears import friction_loop, wind_up

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.spatial import Floats

StiffnessDefinition = Literal["slope", "b/a", "secant", "tangent"]
# The tangent is a slope between this share of the torque below and above it.
_TANGENT: Final = 0.02


class Curve(Protocol):
    """The torque-angle curve of a gearbox, without its play."""

    def elastic_angle(self, torque: Floats) -> Floats:
        """Return the wind-up (torque, sample), rad, under torques (torque,) N m of either sign, without friction."""

    def branches(self, torque: Floats) -> tuple[Floats, Floats]:
        """Return the angles (torque, sample), rad, of the output with friction, under rising and falling torque."""


@dataclass(frozen=True, slots=True)
class StatedCurve:
    """The curve of stated figures: stiffness (N m/rad) in zones up to `limits` (N m), and a loop of the full width `hysteresis` (rad)."""

    stiffness: Sequence[float]
    limits: Sequence[float]
    hysteresis: float

    def elastic_angle(self, torque: Floats) -> Floats:
        """Return the wind-up (torque, 1), rad."""
        return (wind_up(torque, self.stiffness, self.limits) if self.stiffness else np.zeros_like(torque))[:, None]

    def branches(self, torque: Floats) -> tuple[Floats, Floats]:
        """Return the wind-up less and plus half of the loop (torque, 1), rad."""
        angle = self.elastic_angle(torque)
        return angle - self.hysteresis / 2, angle + self.hysteresis / 2


@dataclass(frozen=True, slots=True)
class SampledCurve:
    """The curves of manufactured samples: `angle` (level, sample) rad and `friction` (level,) N m at `torque` (level,) N m, from zero on.

    load_side (level,) rad: the part of the angle in springs between the load and the friction; default: none. Linear between the levels, extrapolated
    linearly beyond the last.
    """

    torque: Floats
    angle: Floats
    friction: Floats
    load_side: Floats | None = None

    def elastic_angle(self, torque: Floats) -> Floats:
        """Return the wind-up (torque, sample), rad."""
        return self._odd(self.angle, torque)

    def branches(self, torque: Floats) -> tuple[Floats, Floats]:
        """Return the angles (torque, sample), rad, with the springs behind the friction under less torque as it rises, and more as it falls."""
        behind = self.angle if self.load_side is None else self.angle - self.load_side[:, None]
        branches = friction_loop(lambda carried: self._odd(behind, carried), torque, self.torque, self.friction)
        before = 0.0 if self.load_side is None else self._odd(self.load_side[:, None], torque)
        return branches[0] + before, branches[1] + before

    def _odd(self, angle: Floats, torque: Floats) -> Floats:
        """Return a curve (level, sample), odd in the torque, at torques (torque,): (torque, sample)."""
        size = np.abs(torque)
        at = np.clip(np.searchsorted(self.torque, size, side="right"), 1, len(self.torque) - 1)
        share = (size - self.torque[at - 1]) / (self.torque[at] - self.torque[at - 1])
        return np.asarray(np.sign(torque)[:, None] * (angle[at - 1] + share[:, None] * (angle[at] - angle[at - 1])))


@dataclass(frozen=True, slots=True)
class Definitions:
    """Torques (N m) at which the data-sheet figures are read, and the definition of the stiffness.

    torque of the wind-up, small of the lost motion, slope (two) of the stiffness as a slope; None where they are not known
    """

    torque: float
    small: float | None = None
    slope: tuple[float, float] | None = None
    stiffness: StiffnessDefinition = "slope"

    @property
    def span(self) -> tuple[float, float] | None:
        """Return the torques between which the stiffness is read on the middle of the loop; None where they are not known."""
        if self.stiffness == "b/a":
            return None if self.small is None or self.small >= self.torque else (self.small, self.torque)
        if self.stiffness == "tangent":
            return (1 - _TANGENT) * self.torque, (1 + _TANGENT) * self.torque
        return self.slope if self.stiffness == "slope" else (0.0, self.torque)

    @property
    def levels(self) -> list[float]:
        """Return every torque above zero that is read."""
        return [each for each in (self.torque, self.small, *(self.slope or ()), *(self.span or ())) if each]


@dataclass(frozen=True, slots=True)
class Readings:
    """Readings, each (sample,): angles in rad, stiffness in N m/rad (sliding drives: m and N/m), rigid: infinite.

    wind_up (torsion) at the torque, beyond the play; displacement from the middle of the play to there, half the play more; secant from zero to the
    torque, slope between two torques, and stiffness by the definition asked for, on the middle of the loop; lost_motion between the middles of the
    loop at ± the small torque; friction_width and width of the loop at zero torque, without and with the play; friction_under_load at half of it.
    """

    asked: Definitions
    wind_up: Floats
    displacement: Floats
    secant: Floats
    slope: Floats | None
    stiffness: Floats | None
    lost_motion: Floats | None
    friction_width: Floats
    width: Floats
    friction_under_load: Floats


def readings(curve: Curve, play: Floats, asked: Definitions) -> Readings:
    """Return the readings of a curve with this play (sample,), rad."""
    angle = curve.elastic_angle(np.array([asked.torque]))[0]
    rising, falling = curve.branches(np.array([0.0, asked.torque / 2]))
    loop, loaded = falling - rising
    lost = None if asked.small is None else play + 2 * _middle(curve, asked.small)
    slope, stiffness = (None if each is None else _between(curve, *each) for each in (asked.slope, asked.span))
    return Readings(asked, angle, play / 2 + angle, _between(curve, 0.0, asked.torque), slope, stiffness, lost, loop, play + loop, loaded)


def _between(curve: Curve, low: float, high: float) -> Floats:
    """Return the slope of the middle of the loop between two torques (N m); infinite where it does not turn."""
    angle = _middle(curve, high) - _middle(curve, low)
    return np.asarray(np.where(angle > 0, (high - low) / np.where(angle > 0, angle, 1.0), np.inf))


def _middle(curve: Curve, torque: float) -> Floats:
    rising, falling = curve.branches(np.array([torque]))
    return np.asarray((rising + falling)[0] / 2)
