"""Where arms stand under their loads. Arms that cannot hold them: the finding, with the joint."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final
from weakref import WeakValueDictionary

import numpy as np

from lostmotion.errors import InputError, Problem
from lostmotion.mechanism.state import State, as_poses, blocks_of, state_of
from lostmotion.recent import Recent

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats


def bytes_of(state: State) -> int:
    """Return about how many bytes a settled state takes with what was computed from it: 2.5 to 6
    times its frames were measured, for serial arms and closed chains.
    """
    return 8 * state.frames.nbytes


# States of a study that several of its figures need, some thousand poses.
_RECENT: Final = Recent[State](160 << 20, bytes_of)


def forget_states() -> None:
    """Keep no state, in a run that visits each pose once."""
    _RECENT.clear()


def settled_at(arm: Arm, q: Floats) -> State:
    """Return the state in which an arm stands under its loads at these poses (pose, joint), rad or
    m: `State.settled`, of which the last ones are kept. Errors as `state_of`.
    """
    values = as_poses(arm, q)
    return _RECENT.of((id(arm), values.tobytes()), lambda: _settled(arm, values))


# Of soft arms, whose settling takes most of the time of a study: the kept state with each pose.
_WITH_POSE: Final[WeakValueDictionary[tuple[int, bytes], State]] = WeakValueDictionary()


def _settled(arm: Arm, values: Floats) -> State:
    """Return `settled_at`: of poses among those of one kept state, as those left where some fall,
    its rows.
    """
    if not arm.soft_freedoms:
        return state_of(arm, values).settled()
    poses = [(id(arm), row.tobytes()) for row in values]
    kept = _WITH_POSE.get(poses[0]) if poses else None
    if kept is not None:
        number = {row.tobytes(): k for k, row in enumerate(kept.q)}
        if all(row in number for _, row in poses):
            return kept.rows(np.array([number[row] for _, row in poses]))
    state = state_of(arm, values).settled()
    _WITH_POSE.update(dict.fromkeys(poses, state))
    return state


def standing_at(arm: Arm, q: Floats) -> State:
    """Return the same; raises InputError as `standing` where the arm cannot hold its load."""
    return standing(settled_at(arm, q))


def standing_if_soft(state: State) -> State:
    """Return the state in which a soft arm stands (`standing`), and that of a stiff arm as it is:
    its loads at the command are those where it stands, to second order in the droop.
    """
    return standing(state) if state.arm.soft_freedoms else state


def standing(state: State) -> State:
    """Return the state in which the arm stands under its loads (`State.settled`). Raises InputError
    where there is none at some pose, with the joint that cannot hold: no error can be stated there.
    """
    state = state.settled()
    found = state.equilibrium
    if found is not None:
        refuse_falling(state.arm, state.q, found.falls_at)
    return state


def falls_at(arm: Arm, q: Floats) -> NDArray[np.int64]:
    """Return the index of the place whose springs cannot hold the load at each of these poses
    (pose, joint); -1 where the arm stands, as stiff arms and closed chains do everywhere.
    """
    out = np.full(len(q), -1)
    if not arm.soft_freedoms:
        return out
    for here, values in blocks_of(q):
        equilibrium = settled_at(arm, values).equilibrium
        if equilibrium is not None:
            out[here] = equilibrium.falls_at
    return out


def refuse_any_fall(arm: Arm, q: Floats) -> None:
    """Raise InputError where the arm falls at any of these poses (pose, joint)."""
    refuse_falling(arm, q, falls_at(arm, q))


def cannot_hold(arm: Arm, places: NDArray[np.int64]) -> str:
    """Return where springs cannot hold the load most often: "joint A", or "the link of A"."""
    name = arm.places[np.bincount(places[places >= 0]).argmax()]
    return f"the link of {name.removesuffix('.tip')}" if name.endswith(".tip") else f"joint {name}"


def refuse_falling(arm: Arm, q: Floats, places: NDArray[np.int64], most: float = 0.0) -> None:
    """Raise InputError where the arm falls, by the place of `falls_at` (pose,), at more than this
    share of the poses q (pose, joint), with the joint that cannot hold.
    """
    falling = np.flatnonzero(places >= 0)
    if len(falling) <= most * len(q):
        return
    place = np.bincount(places[falling]).argmax()
    first = falling[places[falling] == place][0]
    pose = " ".join(
        f"{joint.name}={np.degrees(value):.4g}deg"
        if joint.twist[:3].any()
        else f"{joint.name}={1e3 * value:.4g}mm"
        for joint, value in zip(arm.driven, q[first], strict=True)
    )
    raise InputError(
        [
            Problem(
                arm.name,
                f"joints.{arm.places[place].removesuffix('.tip')}",
                f"no stable equilibrium at {len(falling)} of {len(q)} poses: the springs at "
                f"{cannot_hold(arm, places)} cannot hold the load, first at {pose}",
                "a stiffness above the change of the load's torque per angle, a lighter load, or "
                "other limits",
                'stiffness = "2 N m/arcmin"',
            )
        ]
    )
