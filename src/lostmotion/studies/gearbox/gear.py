"""One gearbox looked at by itself: how its output turns as the torque goes to and fro; and, where it is given by its drawing, what is inside."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeGuard

import numpy as np

from lostmotion.errors import DidNotConvergeError, refuse_argument
from lostmotion.laws.gears import wind_up
from lostmotion.parts.gearbox.catalogue import CatalogueGearbox
from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
from lostmotion.parts.gearbox.cycloidal_behaviour import LEVELS, LOST_MOTION, along_curve
from lostmotion.parts.gearbox.gearbox import Gearbox
from lostmotion.parts.gearbox.planetary import PlanetaryGearbox
from lostmotion.parts.gearbox.strain_wave import StrainWaveGearbox
from lostmotion.parts.gearbox.wolfrom import WolfromGearbox
from lostmotion.parts.gearbox.worm import WormGearbox
from lostmotion.studies.gearbox.gear_drawn import Drawn, drawn

if TYPE_CHECKING:
    from lostmotion.parts.source import ErrorSource
    from lostmotion.spatial import Floats

StatedGearbox = CatalogueGearbox[Any, Any, Any, Any] | PlanetaryGearbox | WolfromGearbox | StrainWaveGearbox | WormGearbox
AnyGearbox = StatedGearbox | CycloidalGearbox
MOST_GEARBOXES: Final = 100_000
# Steps of half a loop.
_STEPS: Final = 400
_ROUNDING: Final = 1e-9


@dataclass(frozen=True)
class Loop:
    """How far the output turns as the torque on it goes to and fro with the input held. Torques in N m, angles in rad (sliding drives: N and m).

    torque (step,) from the largest one way to the largest the other; rising and falling (step,) the angles as it rises and falls, the average
    gearbox of the drawing; friction_rising, friction_falling the same without play: friction's loop alone. play; rest: the torque that it takes to
    move through the play; small: the torque of the lost motion, and ends (2,) the middle of the loop there; lost_motion between them.
    """

    torque: Floats
    rising: Floats
    falling: Floats
    friction_rising: Floats
    friction_falling: Floats
    play: float
    rest: float
    small: float
    ends: Floats
    lost_motion: float

    @property
    def width(self) -> float:
        """Give the width of the loop at zero torque."""
        return float(np.interp(0.0, self.torque, self.falling) - np.interp(0.0, self.torque, self.rising))

    @property
    def friction_width(self) -> float:
        """Give the width at zero torque of friction's loop alone."""
        return float(np.interp(0.0, self.torque, self.friction_falling) - np.interp(0.0, self.torque, self.friction_rising))


@dataclass(frozen=True)
class GearStudy:
    """What was found of a gearbox under a torque (N m at the output; None where none is rated or given).

    loop   None without torque, for a gearbox that neither gives nor has play, or where the torque does not overcome friction
    drawn  what only a drawing tells; None for gearboxes by stated figures
    """

    gearbox: AnyGearbox
    torque: float | None
    count: int
    seed: int
    loop: Loop | None
    drawn: Drawn | None

    @property
    def wind_up(self) -> float | None:
        """Give the wind-up at the torque, play not counted."""
        return None if self.torque is None else float(_wind_up(self.gearbox, np.array([self.torque]))[0])


def gear(gearbox: ErrorSource, torque: float | None = None, gearboxes: int = 1000, seed: int = 1) -> GearStudy:
    """What does this gearbox do under a torque (N m; left out: its rated one)? So many of a drawing are built by chance.

    Raises InputError for a torque that is not above zero, a count out of range, a seed below zero; DidNotConvergeError where the contact law does not
    hold the load.
    """
    if not _is_known(gearbox):
        raise refuse_argument("gearbox", type(gearbox).__name__, "a gearbox that a joint can have")
    if torque is not None and not (np.isfinite(torque) and torque > 0):
        raise refuse_argument("torque", torque, "a torque above zero", "torque = 200.0")
    if not 2 <= gearboxes <= MOST_GEARBOXES:  # noqa: PLR2004 - a scatter needs two
        raise refuse_argument("gearboxes", gearboxes, f"from 2 to {MOST_GEARBOXES}: one has no scatter", "gearboxes = 1000")
    if seed < 0:
        raise refuse_argument("seed", seed, "a whole number, zero or more", "seed = 1")
    chosen = gearbox.rated_torque if torque is None else torque
    inside = None
    if isinstance(gearbox, CycloidalGearbox):
        try:
            inside = drawn(gearbox, chosen or gearbox.rated_torque, gearboxes, seed)
        except DidNotConvergeError as error:
            highest = max(chosen or 0.0, LEVELS[-1] * gearbox.rated_torque)
            raise DidNotConvergeError(
                f"up to {highest:.4g} N m at the output, {LEVELS[-1]:g} times the rated torque or what was asked for, are more than the contacts of "
                f"the lobes hold: a smaller torque, larger lobes or a stiffer material is needed ({error})"
            ) from error
    found = None if chosen is None else _loop(gearbox, float(chosen), inside)
    return GearStudy(gearbox, chosen, gearboxes, seed, found, inside)


def _is_known(gearbox: ErrorSource | CycloidalGearbox) -> TypeGuard[AnyGearbox]:
    return isinstance(gearbox, Gearbox | CycloidalGearbox)


def _wind_up(gearbox: AnyGearbox, torque: Floats) -> Floats:
    if isinstance(gearbox, CycloidalGearbox):
        found = gearbox.behaviour
        return along_curve(torque, found.torque, found.total)
    return wind_up(torque, gearbox.zones, gearbox.zone_torques) if gearbox.zones else np.zeros_like(torque)


def _branches(gearbox: AnyGearbox, torque: Floats) -> tuple[Floats, Floats]:
    """Give the angles (torque,) at which friction leaves the output as the torque rises, and as it falls."""
    if isinstance(gearbox, CycloidalGearbox):
        return gearbox.behaviour.loop.branches(torque)
    angle, half = _wind_up(gearbox, torque), (gearbox.hysteresis or 0.0) / 2
    return angle - half, angle + half


def _loop(gearbox: AnyGearbox, most: float, inside: Drawn | None) -> Loop | None:
    """Follow the torque to and fro: wind-up, friction that holds it back on the way, and the play, crossed once the torque overcomes friction."""
    if isinstance(gearbox, CycloidalGearbox):
        play = 0.0 if inside is None else float(inside.play.mean())
        rest, share, rated = gearbox.friction_at_rest, LOST_MOTION, gearbox.rated_torque
    else:
        play, rest, share, rated = gearbox.play.nominal, gearbox.friction, gearbox.lost_motion_torque, gearbox.rated_torque or most
    if most <= rest:
        return None
    past = float(np.nextafter(rest, math.inf))
    even = np.linspace(-most, most, 2 * _STEPS + 1)
    # the play is crossed between two neighbouring numbers, with nothing between them that rounding left there
    torque = np.unique([*even[np.abs(np.abs(even) - rest) > _ROUNDING * most], -past, -rest, rest, past])
    rising, falling = _branches(gearbox, torque)
    if not (play or rising.any() or falling.any()):
        return None
    if rising[-1] >= np.interp(0.0, torque, falling):
        # once the torque turns back, friction holds the output where it is until the torque has let go of it
        falling, rising = np.minimum(falling, rising[-1]), np.maximum(rising, falling[0])
    side = play / 2
    small = share * rated
    end = side + float(np.mean(_branches(gearbox, np.array([small]))))
    return Loop(
        torque=torque,
        rising=rising + np.where(torque > rest, side, -side),
        falling=falling + np.where(torque < -rest, -side, side),
        friction_rising=rising,
        friction_falling=falling,
        play=play,
        rest=rest,
        small=small,
        ends=np.array([-end, end]),
        lost_motion=2 * end,
    )
