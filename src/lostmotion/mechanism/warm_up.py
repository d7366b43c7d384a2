"""Drift of the tool while an arm warms up, by thermal expansion of its links: of pose accuracy (ISO
9283:1998, 7.6), and over a task by the own heat of its joints.

Links rise by dT (1 - exp(-t / T)) and expand freely: for the standard all by one rise and one
coefficient, over the eight hours for which it observes; for a task each by its own rise, time
constant and material. Neglected: the structure between base and first joint, drives, bearings, and
compensation by the controller.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism import load_feedback
from lostmotion.mechanism.state import state_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.state import State
    from lostmotion.spatial import Floats

# Thermal expansion of structural aluminium alloys (EN 1999-1-1, 3.2.5), 1/K.
ALUMINIUM: Final = 23e-6
HOUR: Final = 3600.0
OBSERVATION: Final = 8 * HOUR
_READINGS: Final = 49


@dataclass(frozen=True)
class WarmUp:
    """Temperature rise of the links (K), its time constant (s), and their coefficient of thermal
    expansion (1/K).
    """

    rise: float
    time_constant: float = HOUR
    expansion: float = ALUMINIUM


@dataclass(frozen=True)
class OwnHeat:
    """Temperature rise of links by the own heat of their joints at the duty of a task, above the
    temperature of the arm.

    joints         their names, in the order of the arm
    rise           (joint,) K, in the long run
    time_constant  (joint,) s
    duration       of one run, s
    over           time over which runs follow each other from the start on, s; at least one run
    warm           whether the arm is warm at the start: its full rises, at all times
    """

    joints: tuple[str, ...]
    rise: Floats
    time_constant: Floats
    duration: float
    over: float
    warm: bool = False

    def shares(self, time: Floats) -> Floats:
        """Return the share of the rise of each link (joint, ...) at these times (...), s."""
        share = share_of_rise(np.asarray(time)[..., None], self.time_constant)
        return np.moveaxis(np.ones_like(share) if self.warm else share, -1, 0)

    def times(self, places: int, runs: int) -> Floats:
        """Return when each run visits each place (place, run), s: places at equal intervals, and
        runs in the middle of equal parts of the time over which they follow each other.
        """
        begins = (self.over - self.duration) * (np.arange(runs) + 0.5) / runs
        return np.asarray(np.linspace(0.0, self.duration, places)[:, None] + begins)


@dataclass(frozen=True)
class Drift:
    """Drift at one pose during warm-up.

    time (reading,) s           since the start
    shift (reading, 3)          displacement of the tool, m, base frame
    accuracy (reading, robot)   AP_p, m
    largest (robot,)            dAP_p: largest change of AP_p since the start, m
    """

    warm_up: WarmUp
    time: Floats
    shift: Floats
    accuracy: Floats
    largest: Floats


def share_of_rise(time: Floats, time_constant: Floats | float) -> Floats:
    """Return the share of its rise by which a body has warmed after a time, s, at constant heat:
    1 - exp(-t / T), one heat capacity and one path of the heat.
    """
    return np.asarray(-np.expm1(-time / time_constant))


def growth(arm: Arm, q: Floats, warm_up: WarmUp) -> Floats:
    """Return the displacement of the tool (3,), m, at one pose q (joint,) by the full temperature
    rise of all links, to first order.
    """
    link = {"expansion": warm_up.expansion}
    joints = tuple(
        joint.model_copy(update={"link": joint.link.model_copy(update=link)})
        for joint in arm.joints
    )
    warm = arm.model_copy(update={"joints": joints})
    rises = {joint.name: warm_up.rise for joint in joints if joint.link.expands}
    return np.asarray(link_growth(state_of(warm, q), rises)[:, 0, 3:].sum(axis=0))


def link_growth(state: State, rises: Mapping[str, float]) -> Floats:
    """Return rotation and displacement of the tool (link, pose, 6), rad and m, by the expansion of
    the links of these joints, to first order; where a soft arm stands, with the loads that follow.

    rises  temperature rise of each link by the name of its joint, K

    Raises ValueError for a link without length or known expansion.
    """
    arm, place, local = state.arm, [], []
    for joint, (_, _, tip) in zip(arm.joints, arm.tree.joints, strict=True):
        if joint.name in rises:
            if not joint.link.expands:
                raise ValueError(f"the link of {joint.name} has no length or no known expansion")
            place.append(tip)
            local.append(joint.elastic_link.expansion[:, 0] * rises[joint.name])
    at = np.array(place, dtype=int)
    screws = np.repeat(np.reshape(local, (len(at), 6)).T[:, :, None], len(state), axis=2)
    follow = state.equilibrium is not None and arm.soft_freedoms
    moved = (
        load_feedback.tool_twists(state, at, screws) if follow else state.tool_twists(at, screws)
    )
    return np.asarray(moved.transpose(1, 2, 0))


def drift(arm: Arm, q: Floats, barycentre: Floats, warm_up: WarmUp) -> Drift:
    """Return the drift of AP_p at one pose q (joint,) over eight hours, for robots with these
    initial mean errors (robot, 3), m.
    """
    time = np.linspace(0.0, OBSERVATION, _READINGS)
    shift = share_of_rise(time, warm_up.time_constant)[:, None] * growth(arm, q, warm_up)
    accuracy = np.linalg.norm(barycentre + shift[:, None], axis=-1)
    return Drift(warm_up, time, shift, accuracy, np.abs(accuracy - accuracy[0]).max(axis=0))
