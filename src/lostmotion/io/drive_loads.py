"""The load that each drive of an arm is to give, and the class of its drives: from effort limits,
else static loads, else the reach.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.catalogue.drive_classes import class_of, drive_classes
from lostmotion.mechanism.arm import STANDARD_GRAVITY
from lostmotion.mechanism.even_poses import even_poses
from lostmotion.mechanism.state import state_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from lostmotion.catalogue.drive_classes import DriveClass
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.state import State
    from lostmotion.spatial import Floats

# A drive gives this many times the largest static load of the arm without payload. Source: maker's
# joint torques over static loads by their URDF: UR3 3.1, UR5 2.5, UR10 2.7, Panda 1.5, LBR iiwa 7
# 3.3, xArm 6 2, Z1 1.7, ViperX-300 2.5.
MARGIN: Final = 2.5
# Static load of an arm's heaviest joint, N m, over the fourth power of its reach, m: weight grows
# with the cube of the size, and its lever with the size. Source: the same arms, 42 to 280 (hobby
# arms 26), Panda, UR5, iiwa 7 and xArm 6 106 to 118 [M 60].
BY_REACH: Final = 100.0
# Masses are placeholders where the static load is this many times more or less than by reach.
_PLAUSIBLE: Final = 50.0
# Effort limits over the static load that are credible for the most heavily loaded joint; of equal
# ones on all joints the second.
_MOST_EFFORT: Final = 20.0
_MOST_EQUAL_EFFORT: Final = 6.0
# The smallest drive of an arm gives at least this share of the largest: UR5 0.19, iiwa 7 0.23,
# Panda 0.14 [M 60].
_LEAST_SHARE: Final = 1 / 7
# A load below this share of the largest is none: the axis stands upright, or passes through the
# centre of mass. So is a lever below this share of the reach about every turning axis: files round
# right angles, and 3.1416 for pi lets an upright axis hold a millionth of the weight.
_NO_LOAD: Final = 0.02
_SEVERAL: Final = 3
_EQUAL: Final = 1e-6
# Acceleration of an axis that lifts nothing, m/s^2 [M 50].
_ACCELERATION: Final = 5.0


@dataclass(frozen=True)
class DriveLoads:
    """Largest load that each drive is to give, N m or N by joint, with the class of the arm.

    static  largest static load by joint, N m or N; by the reach where `masses` is false
    efforts those of the file that are used; empty where none is credible
    remarks how the loads were found, in a sentence each
    """

    loads: Mapping[str, float]
    static: Mapping[str, float]
    efforts: Mapping[str, float]
    masses: bool
    of: DriveClass
    remarks: tuple[str, ...]


def drive_loads(arm: Arm, efforts: Mapping[str, float] | None = None) -> DriveLoads:
    """Return the load of every drive and the class that suits the largest of them.

    `efforts` are the effort limits of a robot file by joint, N m or N; 0 where none is stated. They
    are not used where they cannot be true: smaller than what gravity asks for, far larger, or the
    same on all joints of very different load. Without credible masses the static loads follow from
    the reach: the estimate is then within a factor of about three.
    """
    q = even_poses(arm)
    state = state_of(arm, q)
    held = np.abs(state.torques).max(axis=0)
    turns = np.array([joint.type == "revolute" for joint in arm.driven])
    remarks: list[str] = []
    lever, reach = _levers(state), _reaches(state)
    upright = bool(turns.any()) and bool(lever[turns].max() <= _NO_LOAD * reach[turns].max())
    by_reach = _by_reach(np.where(upright, 0.0, lever), turns)
    why = _placeholder_masses(arm, held, by_reach, turns)
    static = held if not why else by_reach
    if upright:
        how = f"an acceleration of {_ACCELERATION:g} m/s^2 of all behind it, at the reach"
        first, how = (
            (f"{why}, and ", f"the reach, {BY_REACH:g} N m x (reach / 1 m)^4") if why else ("", how)
        )
        remarks.append(f"{first}no turning axis holds a static load: loads by {how}")
    elif why:
        remarks.append(
            f"{why}: static loads by the reach of {lever[turns].max(initial=0.0):.2g} m, "
            f"{BY_REACH:g} N m x (reach / 1 m)^4"
        )
    stated = np.array([(efforts or {}).get(joint.name, 0.0) for joint in arm.driven])
    need = np.where(
        turns & (not upright),
        _with_neighbours(static, turns),
        _in_motion(arm, static, reach, masses=not why),
    )
    used, reason = _credible(stated, need, turns)
    remarks += [reason] if reason else []
    loads = np.where(used, stated, MARGIN * need)
    loads = _at_least_a_share(loads, turns)
    names = [joint.name for joint in arm.driven]
    return DriveLoads(
        dict(zip(names, map(float, loads), strict=True)),
        dict(zip(names, map(float, static), strict=True)),
        {name: float(effort) for name, effort, use in zip(names, stated, used, strict=True) if use},
        not why,
        _class(loads, turns),
        tuple(remarks),
    )


def _levers(state: State) -> Floats:
    """Return the largest lever (m) of a weight at the tool about each joint; 1 for sliding joints
    that lift it.
    """
    payload = state.arm.payload
    heavier = payload.model_copy(update={"mass": payload.mass + 1.0})
    loaded = replace(state, arm=state.arm.model_copy(update={"payload": heavier}))
    return np.asarray(np.abs(loaded.torques - state.torques).max(axis=0) / STANDARD_GRAVITY)


def _reaches(state: State) -> Floats:
    """Return the largest distance (m) of the tool from the origin of each moving joint."""
    at = state.frames[:, :, :3, 3]
    moved = at[list(state.arm.tree.moved)]
    return np.asarray(np.linalg.norm(at[-1] - moved, axis=-1).max(axis=1))


def _by_reach(lever: Floats, turns: np.ndarray) -> Floats:
    reach = float(lever[turns].max(initial=0.0))
    return np.where(turns, BY_REACH * reach**3 * lever, 0.0)


def _placeholder_masses(arm: Arm, held: Floats, by_reach: Floats, turns: np.ndarray) -> str:
    """Return why the masses of an arm cannot be true; empty where they may be."""
    masses = [mass for joint in arm.joints if (mass := joint.total_mass + joint.link.total_mass)]
    if not masses:
        return "no masses"
    if len(masses) >= _SEVERAL and max(masses) - min(masses) <= _EQUAL * max(masses):
        return f"every link weighs {masses[0]:.3g} kg, a placeholder"
    heaviest, usual = float(held[turns].max(initial=0.0)), float(by_reach.max(initial=0.0))
    if usual and not usual / _PLAUSIBLE <= heaviest <= usual * _PLAUSIBLE:
        return (
            f"a static load of {_torque(heaviest)} where about {_torque(usual)} are usual, so that "
            "masses are placeholders"
        )
    return ""


def _with_neighbours(static: Floats, turns: np.ndarray) -> Floats:
    """Return the static loads of turning joints, those without load with that of their neighbour:
    the next one outward, else the one before.
    """
    out = static.copy()
    loaded = [k for k in np.flatnonzero(turns) if static[k] > _NO_LOAD * static[turns].max()]
    for k in np.flatnonzero(turns):
        if k not in loaded and loaded:
            outward = [j for j in loaded if j > k]
            out[k] = static[outward[0] if outward else loaded[-1]]
    return out


def _moved(arm: Arm, k: int) -> float:
    """Return the mass (kg) behind a moving joint, with the payload."""
    behind = arm.joints[arm.joints.index(arm.driven[k]) :]
    return (
        sum(each.link.total_mass for each in behind)
        + sum(each.total_mass for each in behind[1:])
        + arm.payload.mass
    )


def _in_motion(arm: Arm, static: Floats, reach: Floats, *, masses: bool) -> Floats:
    """Return the loads of drives (joint,), N m or N, that move more than they lift: what they hold,
    at least what accelerates all behind them.

    On a turning joint that is a torque at the `reach`; without credible masses it follows from the
    reach alone.
    """
    out = static.copy()
    for k, joint in enumerate(arm.driven):
        usual = drive_classes()["small strain wave"].reference(joint.type)
        moved = _ACCELERATION * _moved(arm, k)
        if joint.type == "revolute":
            moved, usual = moved * reach[k] * masses, BY_REACH * reach[k] ** 4 or usual
        out[k] = max(static[k], moved / MARGIN) or usual / MARGIN
    return out


def _credible(stated: Floats, need: Floats, turns: np.ndarray) -> tuple[np.ndarray, str]:
    """Return which effort limits may be true (joint,), and why the others are not used; empty where
    all are, or none is stated.
    """
    none = np.zeros(len(stated), dtype=bool)
    if not stated.any():
        return none, ""
    turning = stated[turns & (stated > 0)]
    if turns.any() and turning.size:
        most = int(np.argmax(np.where(turns, need, -1.0)))
        ratio = stated[most] / need[most] if need[most] else np.inf
        equal = turning.size >= _SEVERAL and np.ptp(turning) <= _EQUAL * turning.max()
        if equal and ratio > _MOST_EQUAL_EFFORT:
            return (
                none,
                (
                    f"effort limits not used: {_torque(turning[0])} on every joint, where the "
                    "loads differ, is a placeholder"
                ),
            )
        if ratio > _MOST_EFFORT:
            return (
                none,
                (
                    f"effort limits not used: {_torque(stated[most])} where gravity asks for "
                    f"{_torque(need[most])} is a placeholder"
                ),
            )
        if 0 < ratio < 1:
            return (
                none,
                (
                    f"effort limits not used: {_torque(stated[most])}, less than the static load "
                    f"of {_torque(need[most])}"
                ),
            )
    floor = np.maximum(need, _LEAST_SHARE * need[turns].max(initial=0.0) * turns)
    used = (stated >= need) & (stated <= 2 * _MOST_EFFORT * np.maximum(floor, 1e-9)) & (stated > 0)
    left = int((~used & (stated > 0)).sum())
    return (
        used,
        (
            f"{left} of {int((stated > 0).sum())} effort limits not used: below the static load, "
            "or far above it"
        )
        if left
        else "",
    )


def _at_least_a_share(loads: Floats, turns: np.ndarray) -> Floats:
    least = _LEAST_SHARE * loads[turns].max(initial=0.0)
    return np.where(turns, np.maximum(loads, least), loads)


def _class(loads: Floats, turns: np.ndarray) -> DriveClass:
    of = turns if turns.any() else ~turns
    return class_of("revolute" if turns.any() else "prismatic", float(loads[of].max(initial=0.0)))


def _torque(value: float) -> str:
    return load_text(value, "N m")


def load_text(load: float, unit: str) -> str:
    """Return a load with three significant digits and its unit, without a power of ten."""
    return f"{float(f'{load:.3g}'):.12f}".rstrip("0").rstrip(".") + f" {unit}"


def remarks_of(loads: DriveLoads) -> Sequence[str]:
    """Return how the loads were found, in a sentence each, beginning with what they rest on."""
    basis = (
        "effort limits of the file"
        if loads.efforts
        else f"{MARGIN:g} times the static loads, which leaves room for payload and acceleration"
    )
    return (f"loads of the drives: {basis}", *loads.remarks)
