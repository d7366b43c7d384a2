"""Error sources of a cycloidal gearbox, each a table over the torque: wind-up of a member, play,
transmission error, and hysteresis.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.distributions import Normal
from lostmotion.laws.gears import friction_loop, interpolated, unloads
from lostmotion.parts.error_source import ErrorSource, Friction
from lostmotion.parts.forms import Curve, Harmonic, Spring
from lostmotion.parts.standard_terms import (
    PHASES,
    TRANSMISSION_ERROR,
    backlash_terms,
    backlash_variation,
    loop_terms,
    spring_terms,
)
from lostmotion.parts.term import Draw, Parameter, Term

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.parts.term import Holding, Motion
    from lostmotion.spatial import Floats
    from lostmotion.units import Toleranced


@dataclass(frozen=True, slots=True)
class ErrorHarmonic:
    """One harmonic of the transmission error: `cycles` per turn of the output; `size` (level,) rad,
    root mean square over gearboxes and angles.
    """

    cycles: float
    size: Floats


@dataclass(frozen=True, slots=True)
class GearboxWindUp(ErrorSource):
    """One member's wind-up (level,) at torques (level,), and its standard deviation over gearboxes.

    materials  name of each material that it follows, and the ± scatter of the wind-up with it, as a
               share: one draw per material
    """

    torque: Floats
    angle: Floats
    scatter: Floats | None = None
    materials: tuple[tuple[str, float], ...] = ()

    def terms(self, motion: Motion) -> list[Term]:
        """Return the wind-up, its scatter over gearboxes, and that of the materials, which members
        and gearboxes of the same batch share.
        """
        sized, curve = Parameter("stiffness"), Curve.through(self.torque, self.angle)
        out = spring_terms(motion.twist, curve, 0.0, sized, "", "")
        for k, (material, share) in enumerate(self.materials):
            name, draw = (
                f"material scatter {k + 1}" if k else "material scatter",
                Draw("scatter", Normal(), material),
            )
            out.append(
                Term(
                    name,
                    "material scatter",
                    Spring(motion.twist, curve),
                    share / Normal().bound,
                    draw,
                    parameter=sized,
                    exponent=-1,
                )
            )
        if self.scatter is not None and self.scatter.any():
            form = Spring(motion.twist, Curve.through(self.torque, self.scatter))
            out.append(
                Term(
                    "wind-up scatter",
                    "wind-up scatter",
                    form,
                    robot=Draw("wind-up", Normal()),
                    parameter=sized,
                    exponent=-1,
                )
            )
        return out


@dataclass(frozen=True, slots=True)
class Play(ErrorSource):
    """Free play with scatter, closed by a load above `friction` (N m).

    per_kelvin  returns its change (rad/K) within the ± of a temperature rise of the arm; None where
                it does not follow that
    """

    play: Toleranced
    friction: Friction
    per_kelvin: Callable[[Toleranced], float] | None = None

    def play_friction(self, holding: Callable[[], Holding]) -> Friction:  # noqa: ARG002 - a drawn gearbox is rated
        """Return the stated friction, or else the assumed one."""
        return self.friction

    def terms(self, motion: Motion) -> list[Term]:
        """Return the play on the side where the load or the last motion leaves the output."""
        out = backlash_terms(motion, self.play, self.friction.load)
        if self.per_kelvin is None or motion.rise is None or not motion.rise.tolerance:
            return out
        return out + backlash_variation(motion, self.friction.load, self.per_kelvin(motion.rise))


@dataclass(frozen=True, slots=True)
class TransmissionError(ErrorSource):
    """Transmission error as harmonics whose size (level,) depends on the load, with amplitude and
    phase that scatter over gearboxes.
    """

    torque: Floats
    harmonics: tuple[ErrorHarmonic, ...]

    def terms(self, motion: Motion) -> list[Term]:
        """Return two terms per harmonic, with draws of their own: amplitude and phase both
        differ.
        """
        sized, law, out = Parameter(TRANSMISSION_ERROR), Normal(), []
        for harmonic in self.harmonics:
            envelope = Curve(self.torque, harmonic.size)
            for phase in PHASES:
                name = f"{harmonic.cycles:g} per turn {phase}"
                form = Harmonic(motion.twist, harmonic.cycles, phase, envelope=envelope)
                out.append(
                    Term(name, TRANSMISSION_ERROR, form, robot=Draw(name, law), parameter=sized)
                )
        return out


@dataclass(frozen=True, slots=True)
class HysteresisLoop(ErrorSource):
    """Hysteresis of a spring with `angle` (level,), rad, behind friction (level,), N m, at torques
    (level,) that the spring carries.

    pins     friction before it, of the output pins, over the load
    scatter  ± share by which its width differs from visit to visit
    """

    torque: Floats
    angle: Floats
    friction: Floats
    pins: float = 0.0
    scatter: float = 0.0

    def branches(self, load: Floats) -> tuple[Floats, Floats]:
        """Return the angles (rad) of the output under rising and falling loads (any shape, N m) of
        either sign.
        """
        return friction_loop(
            lambda torque: interpolated_odd(torque, self.torque, self.angle),
            load,
            self.torque,
            self.friction,
            self.pins,
        )

    def terms(self, motion: Motion) -> list[Term]:
        """Return half the width of the hysteresis loop, to either side. Raises DidNotConvergeError
        for friction that holds the drive.
        """
        return loop_terms(
            Spring(motion.twist, self.half_width, odd=False),
            1.0,
            Parameter("hysteresis"),
            self.scatter,
        )

    @property
    def half_width(self) -> Curve:
        """Return half the width (rad) of the loop over the size of the load, N m.

        Exact: spring and friction are piecewise linear, so that the width is too, with a knot
        wherever the spring carries a level in either branch. Raises DidNotConvergeError where
        friction takes all of the torque, so that the drive cannot move its load, and no width is
        defined.
        """
        if self.pins >= 1 or not unloads(self.torque, self.friction):
            raise DidNotConvergeError(
                "friction of the drive's flanks or output pins takes all of its torque, so "
                "that its input cannot turn the output: state smaller "
                "coefficients in [gearbox.friction]"
            )
        carried, friction = (
            np.concatenate([-self.torque, self.torque]),
            np.concatenate([self.friction, self.friction]),
        )
        knots = np.concatenate(
            [[0.0], (carried + friction) / (1 - self.pins), (carried - friction) / (1 + self.pins)]
        )
        load = np.unique(knots[knots >= 0])
        load = np.append(load, 2 * load[-1])
        rising, falling = self.branches(load)
        return Curve.through(load, (falling - rising) / 2)


def interpolated_odd(load: Floats, torque: Floats, values: Floats) -> Floats:
    """Return the value at loads (any shape) of either sign, on a curve that is odd in the load; as
    `interpolated`.
    """
    return np.sign(load) * interpolated(np.abs(load), torque, values)
