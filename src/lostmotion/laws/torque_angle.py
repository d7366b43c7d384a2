"""Data-sheet figures read from the torque-angle curve: wind-up, stiffness, lost motion and
hysteresis, for each manufactured sample.

Stiffness and lost motion are those of the elastic curve, without friction. Makers read the middle
of the hysteresis loop, which agrees within a few per cent while friction is small and means nothing
where friction keeps the drive from unloading. A bench test under rising torque reads the loading
branch, stiffer by the share of the torque that friction carries: it is a figure of its own. Lost
motion: Nabtesco, RV series, data sheets (at ±3 % of the rated torque); Harmonic Drive at ±4 %.
Stiffness, by `StiffnessDefinition`: the slope between 50 and 100 % of the rated torque as most
makers of planetary gearboxes state it; b/a of Nabtesco's hysteresis curve, of which the torques are
drawn rather than written and are here those of the lost motion and of the load; secant from the
middle of the play; tangent. A gearbox by stated figures counts as one sample.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, Protocol

import numpy as np

from lostmotion.laws.gears import friction_loop, wind_up

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.laws.cycloid.friction import DriveFriction
    from lostmotion.spatial import Floats

StiffnessDefinition = Literal["slope", "b/a", "secant", "tangent"]
# The tangent is a slope between this share of the torque below and above it.
_TANGENT: Final = 0.02


class TorqueAngleCurve(Protocol):
    """The torque-angle curve of a gearbox, without its play."""

    def elastic_angle(self, torque: Floats) -> Floats:
        """Return the wind-up (torque, sample), rad, under torques (torque,) N m of either sign,
        without friction.
        """

    def branches(self, torque: Floats, most: float) -> tuple[Floats, Floats]:
        """Return the angles (torque, sample), rad, of the output with friction, under rising and
        falling torque, in a loop between ± most (N m).
        """


@dataclass(frozen=True, slots=True)
class StatedCurve:
    """The curve of stated figures: stiffness (N m/rad) in zones up to `limits` (N m), and a loop of
    the full width `hysteresis` (rad).
    """

    stiffness: Sequence[float]
    limits: Sequence[float]
    hysteresis: float

    def elastic_angle(self, torque: Floats) -> Floats:
        """Return the wind-up (torque, 1), rad."""
        return (
            wind_up(torque, self.stiffness, self.limits)
            if self.stiffness
            else np.zeros_like(torque)
        )[:, None]

    def branches(self, torque: Floats, most: float) -> tuple[Floats, Floats]:  # noqa: ARG002 - the width is stated
        """Return the wind-up less and plus half of the loop (torque, 1), rad."""
        angle = self.elastic_angle(torque)
        return angle - self.hysteresis / 2, angle + self.hysteresis / 2


@dataclass(frozen=True, slots=True)
class SampledCurve:
    """The curves of manufactured samples: `angle` (level, sample) rad at `torque` (level,) N m,
    from zero on, and the friction of the drive.

    load_side (level,) rad: the part of the angle in springs between the load and the friction;
    default: none. Linear between the levels, extrapolated linearly beyond the last.
    """

    torque: Floats
    angle: Floats
    friction: DriveFriction
    load_side: Floats | None = None

    def elastic_angle(self, torque: Floats) -> Floats:
        """Return the wind-up (torque, sample), rad."""
        return self._odd(self.angle, torque)

    def branches(self, torque: Floats, most: float) -> tuple[Floats, Floats]:
        """Return the angles (torque, sample), rad, with the springs behind the friction under less
        torque as it rises, and more as it falls.

        As the torque falls the springs stay at the end of the loop until it has changed by the
        friction of both directions.
        """
        tip = self._unlimited(np.array([most]))[0]
        rising, falling = self._unlimited(torque)
        behind = np.maximum(rising, -tip), np.minimum(falling, tip)
        before = 0.0 if self.load_side is None else self._odd(self.load_side[:, None], torque)
        return behind[0] + before, behind[1] + before

    def _unlimited(self, torque: Floats) -> tuple[Floats, Floats]:
        """Return the angles (torque, sample), rad, of the springs behind the friction in a loop
        between any torques.
        """
        behind = self.angle if self.load_side is None else self.angle - self.load_side[:, None]
        friction = self.friction
        return friction_loop(
            lambda carried: self._odd(behind, carried),
            torque,
            friction.levels,
            friction.in_loop,
            friction.pins,
        )

    def _odd(self, angle: Floats, torque: Floats) -> Floats:
        """Return a curve (level, sample), odd in the torque, at torques (torque,): (torque,
        sample).
        """
        size = np.abs(torque)
        at = np.clip(np.searchsorted(self.torque, size, side="right"), 1, len(self.torque) - 1)
        share = (size - self.torque[at - 1]) / (self.torque[at] - self.torque[at - 1])
        return np.asarray(
            np.sign(torque)[:, None]
            * (angle[at - 1] + share[:, None] * (angle[at] - angle[at - 1]))
        )


@dataclass(frozen=True, slots=True)
class Definitions:
    """Torques (N m) at which the data-sheet figures are read, and the definition of the stiffness.

    torque of the wind-up, small of the lost motion, slope (two) of the stiffness as a slope; None
    where they are not known
    """

    torque: float
    small: float | None = None
    slope: tuple[float, float] | None = None
    stiffness: StiffnessDefinition = "slope"

    @property
    def span(self) -> tuple[float, float] | None:
        """Return the torques between which the stiffness is read; None where they are not known."""
        if self.stiffness == "b/a":
            return (
                None
                if self.small is None or self.small >= self.torque
                else (self.small, self.torque)
            )
        if self.stiffness == "tangent":
            return (1 - _TANGENT) * self.torque, (1 + _TANGENT) * self.torque
        return self.slope if self.stiffness == "slope" else (0.0, self.torque)

    @property
    def levels(self) -> list[float]:
        """Return every torque above zero that is read."""
        return [
            each
            for each in (self.torque, self.small, *(self.slope or ()), *(self.span or ()))
            if each
        ]


@dataclass(frozen=True, slots=True)
class CurveReadings:
    """Readings, each (sample,): angles in rad, stiffness in N m/rad (sliding drives: m and N/m),
    rigid: infinite.

    wind_up (torsion) at the torque, beyond the play; displacement from the middle of the play to
    there, half the play more; secant from zero to the torque, slope between two torques, and
    stiffness by the definition asked for, all without friction; loading the same between the same
    torques as they rise, with friction; lost_motion between ± the small torque, without friction;
    friction_width and width of the loop at zero torque, without and with the play;
    friction_under_load at half of it.
    """

    asked: Definitions
    wind_up: Floats
    displacement: Floats
    secant: Floats
    slope: Floats | None
    stiffness: Floats | None
    loading: Floats | None
    lost_motion: Floats | None
    friction_width: Floats
    width: Floats
    friction_under_load: Floats


def readings(curve: TorqueAngleCurve, play: Floats, asked: Definitions) -> CurveReadings:
    """Return the readings of a curve with this play (sample,), rad."""
    most = asked.torque
    angle = curve.elastic_angle(np.array([most]))[0]
    rising, falling = curve.branches(np.array([0.0, most / 2]), most)
    loop, loaded = falling - rising
    lost = (
        None if asked.small is None else play + 2 * curve.elastic_angle(np.array([asked.small]))[0]
    )
    secant, slope, stiffness = (
        _slope(curve.elastic_angle, each) for each in ((0.0, most), asked.slope, asked.span)
    )
    loading = _slope(lambda torque: curve.branches(torque, float(torque.max()))[0], asked.span)
    return CurveReadings(
        asked,
        angle,
        play / 2 + angle,
        np.asarray(secant),
        slope,
        stiffness,
        loading,
        lost,
        loop,
        play + loop,
        loaded,
    )


def _slope(angle: Callable[[Floats], Floats], torques: tuple[float, float] | None) -> Floats | None:
    """Return the slope (sample,) of angles (torque, sample) between two torques (N m), infinite
    where it does not turn; None without torques.
    """
    if torques is None:
        return None
    turned = np.diff(angle(np.array(torques)), axis=0)[0]
    return np.asarray(
        np.where(turned > 0, (torques[1] - torques[0]) / np.where(turned > 0, turned, 1.0), np.inf)
    )
