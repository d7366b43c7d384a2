"""Drift of pose accuracy during warm-up (ISO 9283:1998, 7.6) by thermal expansion of the links.

Assumed: all links share the temperature rise dT(t) = dT (1 - exp(-t / T)) and expand freely with
one coefficient, in place of those of their materials; the error terms are those of a stated
temperature. Neglected: the structure between base and first joint, drives, bearings, and
compensation by the controller. The standard observes for eight hours, or until drift settles.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.state import state_of
from lostmotion.parts.environment import DRAWING, Environment
from lostmotion.units import Toleranced

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.joint import Joint
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


def growth(arm: Arm, q: Floats, warm_up: WarmUp) -> Floats:
    """Return the displacement of the tool (3,), m, at one pose q (joint,) by the full temperature
    rise of all links, to first order.
    """
    warm = _warmed(arm, warm_up)
    state = state_of(warm, q)
    conditions, shift = state.conditions(), np.zeros(3)
    links = (placed for part in warm.parts if part.kind == "link" for placed in part.terms())
    for placed in links:
        if "temperature_rise" in placed.term.form.reads:
            local = placed.term.scale * placed.term.form.screw(conditions(placed))
            shift += state.tool_twists(np.array([placed.place]), local[:, None])[3:, 0, 0]
    return shift


def _warmed(arm: Arm, warm_up: WarmUp) -> Arm:
    """Return the arm at its full temperature rise, all links with one expansion."""
    joints = [
        joint.model_copy(
            update={"link": joint.link.model_copy(update={"expansion": warm_up.expansion})}
            | _without_gearbox(joint)
        )
        for joint in arm.joints
    ]
    # Built without its checks: a temperature rise may be larger than any temperature at which an
    # arm works.
    environment = Environment.model_construct(temperature=Toleranced(DRAWING + warm_up.rise))
    return arm.model_copy(update={"joints": tuple(joints), "environment": environment})


def _without_gearbox(joint: Joint) -> dict[str, None]:
    """Return the change that removes the gearbox of a joint, whose clearances at the full rise are
    not needed.
    """
    return {} if joint.type == "fixed" else {"gearbox": None}


def drift(arm: Arm, q: Floats, barycentre: Floats, warm_up: WarmUp) -> Drift:
    """Return the drift of AP_p at one pose q (joint,) over eight hours, for robots with these
    initial mean errors (robot, 3), m.
    """
    time = np.linspace(0.0, OBSERVATION, _READINGS)
    share = -np.expm1(-time / warm_up.time_constant)
    shift = share[:, None] * growth(arm, q, warm_up)
    accuracy = np.linalg.norm(barycentre + shift[:, None], axis=-1)
    return Drift(warm_up, time, shift, accuracy, np.abs(accuracy - accuracy[0]).max(axis=0))
