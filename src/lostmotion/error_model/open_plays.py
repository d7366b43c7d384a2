"""Plays of the passive joints of a closed chain that their reactions do not close."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lostmotion.mechanism.assembly import may_not_assemble
from lostmotion.mechanism.even_poses import few_even_poses
from lostmotion.mechanism.state import state_of
from lostmotion.parts.play import decides_on

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.state import State


def open_plays(state: State) -> dict[str, NDArray[np.bool_]]:
    """Return whether (pose,) a play of each passive joint with play is open: its reaction is below
    the force that closes the play in most robots.
    """
    joints = {each.place: each.joint for each in state.arm.tree.passive}
    conditions = state.conditions()
    out: dict[str, NDArray[np.bool_]] = {}
    for placed in state.arm.terms:
        decides = decides_on(placed.term.form)
        if decides is not None and placed.place in joints:
            name = joints[placed.place]
            found = decides.share(conditions(placed)) < 0.5  # noqa: PLR2004 - most robots
            out[name] = found | out.get(name, np.zeros(len(state), dtype=bool))
    return out


def open_play_remarks(arm: Arm) -> tuple[str, ...]:
    """Return the remark on the share of poses, of 256 spread evenly between the limits of the
    drives, at which plays of passive joints are open, and of which joints; none where all are
    closed, and for an open chain.
    """
    if not may_not_assemble(arm):
        return ()
    q = few_even_poses(arm)
    found = open_plays(state_of(arm, q)) if len(q) else {}
    shares = {name: float(each.mean()) for name, each in found.items() if each.any()}
    if not shares:
        return ()
    some = float(np.any(list(found.values()), axis=0).mean())
    largest = sorted(shares.items(), key=lambda each: -each[1])
    listed = ", ".join(f"{name} {100 * share:.3g} %" for name, share in largest[:6])
    more = f" and {len(largest) - 6} more" if len(largest) > 6 else ""  # noqa: PLR2004 - as listed
    return (
        (
            f"plays of passive joints with a reaction below the closing force at {100 * some:.3g} "
            f"% of {len(q)} poses spread evenly: {listed}{more}. There the play is open, and the "
            "joint rests anywhere in it"
        ),
    )
