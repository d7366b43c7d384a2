"""Bands of a gearbox: how far its figures depend on the values that are only known to lie in a
range.

The ranges are drawn together (`parts.bands`), and each draw is computed as the nominal gearbox. Its
difference from the nominal gearbox with the middle of each range is added to the mean of the
manufactured samples. So a band has no part of the scatter between gearboxes.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid.friction import DriveFriction
from lostmotion.laws.torque_angle import Definitions, SampledCurve, StatedCurve, readings
from lostmotion.parts.bands import DRAWS, draws, latin_hypercube, unknown_values, varies
from lostmotion.parts.gearbox.cycloidal.model import (
    distribute_wind_up,
    wind_up,
    wind_up_without_scatter,
)
from lostmotion.parts.gearbox.cycloidal.samples import gearboxes

if TYPE_CHECKING:
    from lostmotion.laws.torque_angle import CurveReadings
    from lostmotion.parts.bands import UnknownValue
    from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
    from lostmotion.parts.gearbox.kinds import StatedGearbox
    from lostmotion.spatial import Floats

# Share of the compliance in members that depend on a range, above which a stiffness is printed as
# its band.
LARGE: Final = 0.2
# Simulated gearboxes, at a few crank angles, for the change of the play: the same in every draw.
_GEARBOXES: Final = 64
_ANGLES: Final = 4


@dataclass(frozen=True, slots=True)
class GearBands:
    """Figures of a gearbox over draws of its ranges.

    unknown  the ranges; shares (draw, value): where in its range each value is taken
    read     the readings, one per draw
    members  wind-up (draw,), rad, of each member at the torque; of a gearbox by stated figures
             empty
    middle   wind-up (rad) of each member with the middle of every range
    """

    unknown: tuple[UnknownValue, ...]
    shares: Floats
    read: CurveReadings
    members: dict[str, Floats]
    middle: dict[str, float]

    @property
    def unknown_share(self) -> float:
        """Return the share of the wind-up in members that depend on a range; of a gearbox by stated
        figures all or nothing.
        """
        if not self.members:
            return float(varies(self.read.wind_up))
        return sum(
            self.middle.get(name, 0.0) for name, each in self.members.items() if varies(each)
        ) / sum(self.middle.values())

    @property
    def member_shares(self) -> dict[str, Floats]:
        """Return the share of each member in the wind-up of its draw (draw,)."""
        whole = np.sum(list(self.members.values()), axis=0)
        return {name: each / whole for name, each in self.members.items()}


@dataclass(frozen=True, slots=True)
class Middle:
    """A drawn gearbox with the middle of every range: its curve (level, sample) and play (sample,)
    over manufactured samples, averaged for the bands.

    torque (level,) N m of `as_drawn`, the nominal wind-up by member, and `found`, the mean wind-up
    of the members with scatter, rad
    """

    asked: Definitions
    torque: Floats
    as_drawn: dict[str, Floats]
    found: Floats
    curve: SampledCurve
    play: float


def bands_of_drawing(gearbox: CycloidalGearbox, middle: Middle, seed: int) -> GearBands | None:
    """Return the bands of a drawn gearbox; None for a drawing without ranges.

    Raises InputError where the ranges allow an impossible drawing, DidNotConvergeError where
    contacts cannot carry a load.
    """
    unknown = unknown_values(gearbox)
    if not unknown:
        return None
    asked = middle.asked
    at = np.flatnonzero(np.isin(middle.torque, asked.levels))
    levels = middle.torque[at]
    as_drawn = {name: each[at] for name, each in middle.as_drawn.items()}
    own = _own(as_drawn)
    shares = latin_hypercube(unknown, DRAWS, seed)
    members: dict[str, list[float]] = {}
    shift, play = np.zeros((len(levels), len(shares))), np.zeros(len(shares))
    before = _play(gearbox)
    last = int(np.searchsorted(levels, asked.torque))
    # all are built before one is computed, so that an impossible drawing is refused at once
    for k, known in enumerate([*draws(gearbox, unknown, shares)]):
        drawn = wind_up(known, levels)
        more = _own(drawn) - own
        # flanks that interfere wind up less than as drawn, in proportion; others as drawn and a
        # little more
        found = np.where(
            middle.found[at] < own,
            middle.found[at] * (1 + more / np.where(own > 0, own, 1.0)),
            middle.found[at] + more,
        )
        shift[:, k] = (
            found
            - middle.found[at]
            + wind_up_without_scatter(drawn)
            - wind_up_without_scatter(as_drawn)
        )
        play[k] = middle.play + _play(known) - before
        for name, each in distribute_wind_up(drawn, found).items():
            members.setdefault(name, []).append(float(each[last]))
    mean = middle.curve.angle.mean(axis=1)
    steps = np.concatenate([np.zeros((1, len(shares))), shift])
    every = np.stack(
        [np.interp(middle.curve.torque, np.concatenate([[0.0], levels]), each) for each in steps.T],
        axis=1,
    )
    curve = replace(middle.curve, angle=mean[:, None] + every)
    return GearBands(
        unknown=unknown,
        shares=shares,
        read=readings(curve, np.maximum(play, 0.0), asked),
        members={name: np.array(each) for name, each in members.items() if any(each)},
        middle={
            name: float(each[last])
            for name, each in distribute_wind_up(as_drawn, middle.found[at]).items()
        },
    )


def bands_of_figures(gearbox: StatedGearbox, asked: Definitions, seed: int) -> GearBands | None:
    """Return the bands of a gearbox by stated figures; None for one without ranges."""
    unknown = unknown_values(gearbox)
    if not unknown:
        return None
    shares = latin_hypercube(unknown, DRAWS, seed)
    angles: list[Floats] = []
    play: list[float] = []
    # two torques close together would lose digits: the curve is sampled where its readings need it
    torque = np.unique([0.0, *gearbox.zone_torques, asked.torque / 2, *asked.levels])
    torque = np.append(torque, 2 * torque[-1])
    for known in draws(gearbox, unknown, shares):
        angles.append(StatedCurve(known.zones, known.zone_torques, 0.0).elastic_angle(torque)[:, 0])
        play.append(known.play.nominal)
    none = np.zeros_like(torque)
    curve = SampledCurve(torque, np.stack(angles, axis=1), DriveFriction(torque, none, none))
    return GearBands(unknown, shares, readings(curve, np.array(play), asked), {}, {})


def _own(members: dict[str, Floats]) -> Floats:
    """Return the wind-up (level,), rad, of the members with scatter."""
    return np.asarray(sum(members.values()) - wind_up_without_scatter(members))


def _play(gearbox: CycloidalGearbox) -> float:
    return _play_of(gearbox.middle)


@functools.lru_cache(maxsize=8)
def _play_of(gearbox: CycloidalGearbox) -> float:
    return float(gearboxes(gearbox, np.zeros(0), _ANGLES, _GEARBOXES).play.mean())
