"""Where arms stand under their loads. Arms that cannot hold them: the finding, with the joint."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import InputError, Problem
from lostmotion.mechanism.state import State, as_poses, state_of
from lostmotion.recent import Recent

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats


def bytes_of(state: State) -> int:
    """Return about how many bytes a settled state takes: forty times its frames, measured."""
    return 40 * state.frames.nbytes


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
    return _RECENT.of((id(arm), values.tobytes()), lambda: state_of(arm, values).settled())


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
    if found is None or not (found.falls_at >= 0).any():
        return state
    falling = np.flatnonzero(found.falls_at >= 0)
    place = np.bincount(found.falls_at[falling]).argmax()
    first = falling[found.falls_at[falling] == place][0]
    arm, name = state.arm, state.arm.places[place]
    pose = " ".join(
        f"{joint.name}={np.degrees(value):.4g}deg"
        if joint.twist[:3].any()
        else f"{joint.name}={1e3 * value:.4g}mm"
        for joint, value in zip(arm.driven, state.q[first], strict=True)
    )
    where = "the link of" if name.endswith(".tip") else "joint"
    raise InputError(
        [
            Problem(
                arm.name,
                f"joints.{name.removesuffix('.tip')}",
                f"no stable equilibrium at {len(falling)} of {len(state)} poses: the springs at "
                f"{where} {name.removesuffix('.tip')} cannot hold the load, first at {pose}",
                "a stiffness above the change of the load's torque per angle, a lighter load, or "
                "other limits",
                'stiffness = "2 N m/arcmin"',
            )
        ]
    )
