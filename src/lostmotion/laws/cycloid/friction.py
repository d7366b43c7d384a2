"""Coulomb friction of a cycloidal stage: hysteresis with the input held, efficiency in both
directions, and self-locking.

Three places rub, and each loses a share of the torque that passes through it, in series from the
load to the input:

* output pins in their holes, loaded by the torque at the output. Per radian of the output they
  slide by the eccentricity e against a crank at rest, and by e more per radian of the crank
  against the disc; the first part acts on the disc, the second on the crank;
* flanks. The forces on a disc with friction at each contact balance about its centre and about the
  pitch point: T_disc = T_n -+ mu sum(F h) and T_crank = T_disc +- mu sum(F d), for an input that
  drives and one that is driven back. T_n is the moment of the normal forces F about the centre, d
  the distance of a contact from the pitch point, and h that from the centre along its normal,
  usually a little smaller;
* the eccentric's bearing, loaded by the force on the crank, with mu r F on the disc and, times the
  turns of the crank, on the input.

So flanks alone, h = d, of a friction m T_n leave the efficiency 1 - m where the input drives: at m
= 1 it cannot turn the output. Where a load drives the input back they leave 1/(1 + m), never zero.
Bearing and output pins of shares m leave 1/(1 + m) and 1 - m: an eccentric is self-locking once its
friction circle mu r reaches the eccentricity. Normal forces are those without friction, which
changes their shares. Grease, seals and a first stage are not included.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid.geometry import arms, pin_angles, pitch_distance
from lostmotion.laws.gears import interpolated, torque_behind_friction, unloads

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.laws.cycloid.contact import LoadSharing
    from lostmotion.laws.cycloid.stage import Stage
    from lostmotion.spatial import Floats


# Relative difference of two torques that is rounding.
_ROUNDING: Final = 1e-9


@dataclass(frozen=True, slots=True)
class FrictionCoefficients:
    """Coulomb friction coefficients of a cycloidal stage; zero for none.

    flank           between disc and lobes: 0.05 to 0.1 sliding in grease, about 0.005 with rollers
    bearing         of the eccentric's bearing at its `bearing_radius` (m): about 0.002 with rolling
                    elements
    output          of the output pins in their holes; with sleeves, times bore radius over sleeve
                    radius
    pin_circle      radius of the output pins, m
    """

    flank: float
    bearing: float = 0.0
    bearing_radius: float = 0.0
    output: float = 0.0
    pin_circle: float = math.inf


@dataclass(frozen=True, slots=True)
class FrictionTorques:
    """Friction torques of one disc at the output (torque, crank, draw), N m: on the `disc` about
    its centre, on the `crank`, and of output `pins` while the crank turns and while it is held.
    """

    disc: Floats
    crank: Floats
    pins: Floats
    pins_held: Floats


def friction_torques(
    stage: Stage,
    crank: Floats | Sequence[float],
    answer: LoadSharing,
    friction: FrictionCoefficients,
    turns: float | None = None,
) -> FrictionTorques:
    """Return the Coulomb friction torques of one disc for the load sharing `answer` at these crank
    angles (crank,), rad.

    Per radian of the output each flank slides by its distance from the pitch point, R D - Rr
    (planet pins: + Rr), and the output pins by e N (planet pins: e z): by e with the crank held.
    The crank turns by `turns`; default: those with the ring held.
    """
    theta = pin_angles(stage, np.atleast_1d(np.asarray(crank, dtype=float)))
    away = pitch_distance(stage, theta)
    reach = stage.ring_radius * away + (1 if stage.has_planet_pins else -1) * stage.pin_radius
    beyond = np.sign(reach) * stage.planet_pitch_radius * (np.cos(theta) - stage.shortening) / away
    slide, offset = (
        friction.flank * (answer.forces * each[None, :, None, :]).sum(axis=-1)
        for each in (np.abs(reach), beyond)
    )
    bearing = friction.bearing * friction.bearing_radius * answer.bearing_force
    moment = np.abs((answer.forces * arms(stage, theta)[None, :, None, :]).sum(axis=-1))
    held = friction.output * stage.eccentricity * 4 / math.pi * moment / friction.pin_circle
    return FrictionTorques(
        disc=slide + offset + bearing,
        crank=bearing * (stage.planet_pitch_radius / stage.eccentricity if turns is None else turns)
        - offset,
        pins=held * stage.ring_pitch_radius / stage.eccentricity,
        pins_held=held,
    )


@dataclass(frozen=True, slots=True)
class DriveFriction:
    """Friction of a whole drive at its output.

    levels    (level,) N m, from zero on: the moment of the normal forces on the flanks
    discs     (level,) N m, on the discs
    crank     (level,) N m, between the discs and the input, with what output pins rub as it turns
    pins      friction of the output pins with the input held, over the torque at the output; with
              the carrier held there is none
    constant  N m, without load
    """

    levels: Floats
    discs: Floats
    crank: Floats
    pins: float = 0.0
    constant: float = 0.0

    @property
    def any(self) -> bool:
        """Return whether there is friction."""
        return bool(self.constant or self.pins or self.discs.any() or self.crank.any())

    @property
    def in_loop(self) -> Floats:
        """Return the friction (level,), N m, between the output pins and the springs, with the
        input held.
        """
        return self.constant + self.discs

    @property
    def drives(self) -> bool:
        """Return whether the input can turn the output, which is whether the springs unload:
        friction on the discs below their torque.
        """
        return unloads(self.levels, self.discs)

    @property
    def self_locking(self) -> bool:
        """Return whether no load at the output can turn the input: friction of the crank or of the
        output pins takes all of it.
        """
        return self.pins >= 1 or bool((self.crank[1:] >= self.levels[1:]).all())

    @property
    def backdriving_torque(self) -> float:
        """Return the torque at the output (N m) above which it turns an input without load;
        infinite for a self-locking drive.
        """
        return math.inf if self.self_locking else self.constant / (1 - self.pins)

    def driving(self, load: Floats) -> Floats:
        """Return the torque of the input times the ratio, N m, that moves loads (any shape, N m) at
        the output; infinite where none does.
        """
        on_discs = load * (1 + self.pins) + self.constant
        carried = torque_behind_friction(on_discs, self.levels, self.discs, -1)
        moves = carried - interpolated(carried, self.levels, self.discs) >= on_discs * (
            1 - _ROUNDING
        )
        return np.asarray(
            np.where(moves, carried + interpolated(carried, self.levels, self.crank), np.inf)
        )

    def driven_back(self, load: Floats) -> Floats:
        """Return the torque times the ratio, N m, that loads (any shape, N m) at the output exert
        on the input; zero where friction holds them.
        """
        on_discs = np.maximum(load * (1 - self.pins) - self.constant, 0.0)
        carried = torque_behind_friction(on_discs, self.levels, self.discs, 1)
        return np.asarray(np.maximum(carried - interpolated(carried, self.levels, self.crank), 0.0))

    def efficiency(self, load: Floats) -> Floats:
        """Return the efficiency under loads (any shape, N m, above zero) that the input moves."""
        return np.asarray(load / self.driving(load))

    def efficiency_driven_back(self, load: Floats) -> Floats:
        """Return the share of loads (any shape, N m, above zero) that reaches the input."""
        return np.asarray(self.driven_back(load) / load)
