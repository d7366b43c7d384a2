"""One gearbox: its hysteresis loop and, for a gearbox from its drawing, its members."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.gearbox.bands import GearBands, bands_of_figures
from lostmotion.analyses.gearbox.cycloidal import Drawn, drawn
from lostmotion.analyses.gearbox.readings import Definitions, Readings, StatedCurve, readings
from lostmotion.errors import DidNotConvergeError, refuse_argument
from lostmotion.laws.perforated_disc import UnresolvedWebsError
from lostmotion.parts.gearbox.cycloidal.model import LOST_MOTION
from lostmotion.parts.gearbox.kinds import is_drawn, is_gearbox

if TYPE_CHECKING:
    from lostmotion.analyses.gearbox.readings import Curve, StiffnessDefinition
    from lostmotion.parts.error_source import ErrorSource
    from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
    from lostmotion.parts.gearbox.kinds import AnyGearbox
    from lostmotion.spatial import Floats

MOST_GEARBOXES: Final = 100_000
# Steps of half a loop.
_STEPS: Final = 400
_ROUNDING: Final = 1e-9
# Shares of the rated torque between which most makers state the stiffness as the slope of the
# curve.
SLOPE: Final = (0.5, 1.0)


@dataclass(frozen=True)
class Loop:
    """Torque-angle hysteresis with the input held, the mean of the samples. Torques in N m, angles
    in rad (sliding drives: N and m).

    torque (step,) from the largest in one direction to the largest in the other; rising, falling
    (step,) the angles then;
    friction_rising, friction_falling the same without play: the hysteresis of friction alone. play;
    rest: the torque that traverses the play; small: the torque of the lost motion, and ends (2,)
    the middle of the loop there; None and empty where no such torque is known.
    """

    torque: Floats
    rising: Floats
    falling: Floats
    friction_rising: Floats
    friction_falling: Floats
    play: float
    rest: float
    small: float | None
    ends: Floats

    @property
    def lost_motion(self) -> float | None:
        """Return the lost motion, on the mean of the samples."""
        return float(self.ends[1] - self.ends[0]) if len(self.ends) else None

    @property
    def width(self) -> float:
        """Return the width of the loop at zero torque."""
        return float(
            np.interp(0.0, self.torque, self.falling) - np.interp(0.0, self.torque, self.rising)
        )

    @property
    def friction_width(self) -> float:
        """Return the width at zero torque of the friction loop alone."""
        return float(
            np.interp(0.0, self.torque, self.friction_falling)
            - np.interp(0.0, self.torque, self.friction_rising)
        )


@dataclass(frozen=True, repr=False)
class GearStudy:
    """Results of a gearbox under a torque (N m at the output; None where none is rated or stated).

    loop     None without torque, for a rigid gearbox without play, or where the torque does not
             overcome friction
    read     the data-sheet figures of every sample; None without torque
    drawn    the results from a drawing; None for gearboxes by stated figures
    bands    the figures over draws of the values that are stated as ranges; None without ranges
    """

    gearbox: AnyGearbox
    torque: float | None
    count: int
    seed: int
    loop: Loop | None
    read: Readings | None
    drawn: Drawn | None
    bands: GearBands | None = None

    @property
    def wind_up(self) -> float | None:
        """Return the mean wind-up at the torque, beyond the play."""
        return None if self.read is None else float(self.read.wind_up.mean())


def gear(
    gearbox: ErrorSource,
    torque: float | None = None,
    gearboxes: int = 500,
    seed: int = 1,
    lost_motion_torque: float | None = None,
    slope_range: tuple[float, float] | None = None,
    stiffness_definition: StiffnessDefinition = "slope",
) -> GearStudy:
    """Study a gearbox under a torque (N m; its rated one unless stated), on this many manufactured
    samples of a drawing.

    `lost_motion_torque` N m at which the lost motion is read; default: the stated share, or 3 %, of
    the rated torque.
    `slope_range` N m between which the slope of the curve is taken; default: 50 to 100 % of the
    rated torque. Raises InputError for torques not above zero, a slope range that does not rise, a
    definition of the stiffness without its torques, a count out of range, a seed below zero;
    DidNotConvergeError where the contacts cannot carry the load.
    """
    if not is_gearbox(gearbox):
        raise refuse_argument("gearbox", type(gearbox).__name__, "a gearbox that a joint can have")
    for name, value in (
        ("torque", torque),
        ("lost_motion_torque", lost_motion_torque),
        ("slope_range", slope_range and slope_range[1]),
    ):
        if value is not None and not (np.isfinite(value) and value > 0):
            raise refuse_argument(name, value, "a torque above zero", **{name: 200.0})
    if slope_range is not None and not 0 <= slope_range[0] < slope_range[1]:
        raise refuse_argument(
            "slope_range", slope_range, "two rising torques", slope_range=(100.0, 200.0)
        )
    if not 2 <= gearboxes <= MOST_GEARBOXES:  # noqa: PLR2004 - a scatter needs two
        raise refuse_argument(
            "gearboxes", gearboxes, f"from 2 to {MOST_GEARBOXES}: one has no scatter", gearboxes=500
        )
    if seed < 0:
        raise refuse_argument("seed", seed, "a whole number, zero or more", seed=1)
    chosen = gearbox.rated_torque if torque is None else torque
    if chosen is None:
        return GearStudy(gearbox, None, gearboxes, seed, None, None, None)
    asked = _definitions(
        gearbox, float(chosen), lost_motion_torque, slope_range, stiffness_definition
    )
    if not is_drawn(gearbox):
        curve = StatedCurve(gearbox.zones, gearbox.zone_torques, gearbox.loop_width or 0.0)
        read = readings(curve, np.array([gearbox.play.nominal]), asked)
        return GearStudy(
            gearbox,
            chosen,
            gearboxes,
            seed,
            _loop(curve, gearbox.play.nominal, gearbox.friction.load.nominal, read),
            read,
            None,
            bands_of_figures(gearbox, asked, seed),
        )
    inside = _drawn(gearbox, asked, gearboxes, seed)
    loop = _loop(
        inside.curve, float(inside.play.mean()), gearbox.friction_at_rest.load.nominal, inside.read
    )
    return GearStudy(gearbox, chosen, gearboxes, seed, loop, inside.read, inside, inside.bands)


def _drawn(gearbox: CycloidalGearbox, asked: Definitions, gearboxes: int, seed: int) -> Drawn:
    """Return the results from the drawing. Raises DidNotConvergeError, with the torque where the
    contacts cannot carry it.
    """
    try:
        return drawn(gearbox, asked, gearboxes, seed)
    except UnresolvedWebsError:
        raise
    except DidNotConvergeError as error:
        most = max(asked.levels)
        raise DidNotConvergeError(
            f"{most:.4g} N m at the output is more than the contacts of the lobes can carry: "
            "take a smaller torque, larger lobes or a stiffer "
            f"material ({error})"
        ) from error


def _definitions(
    gearbox: AnyGearbox,
    torque: float,
    small: float | None,
    slope: tuple[float, float] | None,
    stiffness: StiffnessDefinition,
) -> Definitions:
    """Return the torques asked for or by default. Raises InputError for a definition of the
    stiffness whose torques are not known.
    """
    rated = gearbox.rated_torque
    share = LOST_MOTION if is_drawn(gearbox) else gearbox.lost_motion_torque
    asked = Definitions(
        torque,
        small or (share * rated if rated is not None else None),
        slope or ((SLOPE[0] * rated, SLOPE[1] * rated) if rated is not None else None),
        stiffness,
    )
    if stiffness == "b/a" and asked.span is None:
        expected = (
            "'slope', 'secant' or 'tangent', or a torque of the lost motion below that of the load"
        )
        raise refuse_argument(
            "stiffness_definition", "'b/a'", expected, stiffness_definition="secant"
        )
    return asked


def _loop(curve: Curve, play: float, rest: float, read: Readings) -> Loop | None:
    """Return the hysteresis loop: wind-up, friction, and the backlash, traversed once the torque
    overcomes friction.
    """
    most, small = read.asked.torque, read.asked.small
    if most <= rest:
        return None
    past = float(np.nextafter(rest, math.inf))
    even = np.linspace(-most, most, 2 * _STEPS + 1)
    # the play is traversed between two neighbouring floating-point numbers; steps within rounding
    # of them are removed
    torque = np.unique(
        [*even[np.abs(np.abs(even) - rest) > _ROUNDING * most], -past, -rest, rest, past]
    )
    rising, falling = (each.mean(axis=1) for each in curve.branches(torque, most))
    if not (play or rising.any() or falling.any()):
        return None
    if rising[-1] >= np.interp(0.0, torque, falling):
        # when the torque reverses, friction holds the output until the torque has changed by twice
        # the friction
        falling, rising = np.minimum(falling, rising[-1]), np.maximum(rising, falling[0])
    side = play / 2
    end = None if read.lost_motion is None else float(read.lost_motion.mean()) / 2
    return Loop(
        torque=torque,
        rising=rising + np.where(torque > rest, side, -side),
        falling=falling + np.where(torque < -rest, -side, side),
        friction_rising=rising,
        friction_falling=falling,
        play=play,
        rest=rest,
        small=small,
        ends=np.array([]) if end is None else np.array([-end, end]),
    )
