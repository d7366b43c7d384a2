"""How far does the tool wander while the arm warms up? Drift of pose characteristics (ISO 9283:1998, 7.6) from links that grow.

Assumed: every link warms evenly and alike, dT(t) = dT (1 - exp(-t / T)), and grows freely by one coefficient. What lies between base and first joint,
drives, bearings and a compensation by the controller are left out. The standard watches for eight hours, or until changes have died down.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import refuse_argument
from lostmotion.mechanism.serial import frames

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Of aluminium alloys for structures (EN 1999-1-1, 3.2.5), 1/K.
ALUMINIUM: Final = 23e-6
HOUR: Final = 3600.0
WATCHED: Final = 8 * HOUR
_READINGS: Final = 49


@dataclass(frozen=True)
class WarmUp:
    """By how much the links warm, K; within which time 63 % of it, s; by which share of its length a link grows per kelvin, 1/K.

    Raises InputError for what is no number, and a time that is not above zero.
    """

    rise: float
    time_constant: float = HOUR
    expansion: float = ALUMINIUM

    def __post_init__(self) -> None:
        """Refuse links that warm at once, and what is no number."""
        for name, value in (("rise", self.rise), ("time_constant", self.time_constant), ("expansion", self.expansion)):
            if not math.isfinite(value) or (name == "time_constant" and value <= 0):
                expected = "seconds, above zero" if name == "time_constant" else "a finite number"
                raise refuse_argument(f"warm_up.{name}", value, expected, warm_up="25 K")


@dataclass(frozen=True)
class Drift:
    """What warming up does at one pose.

    time (reading,) s      shift (reading, 3) of the tool, m, base frame
    accuracy (reading, robot)  AP_p, m
    largest (robot,)       dAP_p: the largest change of AP_p since the start, m
    """

    warm_up: WarmUp
    time: Floats
    shift: Floats
    accuracy: Floats
    largest: Floats


def growth(arm: Arm, q: Floats, warm_up: WarmUp) -> Floats:
    """Where does the tool go (3,), m, when all links have grown at one pose q (joint,)? To first order: the sum of what each link grows."""
    at = frames(arm, q[None])[:, 0]
    ends = (joint.tip for joint in arm.tree.joints if joint.tip in arm.tree.way)
    links = sum((at[tip, :3, 3] - at[arm.tree.places[tip].parent, :3, 3] for tip in ends), start=np.zeros(3))
    return np.asarray(warm_up.expansion * warm_up.rise * links)


def drift(arm: Arm, q: Floats, barycentre: Floats, warm_up: WarmUp) -> Drift:
    """How does AP_p change at one pose q (joint,) in eight hours, for robots that start with these average errors (robot, 3), m?"""
    time = np.linspace(0.0, WATCHED, _READINGS)
    share = -np.expm1(-time / warm_up.time_constant)
    shift = share[:, None] * growth(arm, q, warm_up)
    accuracy = np.linalg.norm(barycentre + shift[:, None], axis=-1)
    return Drift(warm_up, time, shift, accuracy, np.abs(accuracy - accuracy[0]).max(axis=0))
