"""How much the loads of a closed chain change its stiffness, which no figure contains."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lostmotion.mechanism.closed_jacobian import signs, twist_units
from lostmotion.mechanism.conditions import springs_under
from lostmotion.mechanism.even_poses import few_even_poses
from lostmotion.mechanism.state import state_of

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.state import State
    from lostmotion.spatial import Floats


def load_share(state: State) -> Floats:
    """Return the largest t/(k l) of the parts in loops (pose,): tension over stiffness and length,
    which is about the share of the stiffness that the load adds or takes away.

    It is how far the springs at a place deflect under their load: rotation, rad, or shift as a
    share of the longest fixed distance in the chain. Zero for an open chain.
    """
    tree = state.arm.tree
    by_place = np.zeros((len(tree.places), len(state), 6))
    for place, twist, _ in springs_under(state, state.wrenches):
        by_place[place] += twist
    inside = by_place[signs(tree).any(axis=0)] * twist_units(tree)
    parts = [np.linalg.norm(inside[..., half], axis=-1) for half in (slice(3), slice(3, 6))]
    return np.asarray(np.max(parts, axis=(0, 1), initial=0.0))


def load_remarks(arm: Arm) -> tuple[str, ...]:
    """Return the remark on the loads that change the stiffness of a closed chain, at 256 poses
    spread evenly between the limits of the drives; none for an open chain, and without springs.
    """
    q = few_even_poses(arm) if arm.closures else np.zeros((0, 0))
    largest = float(load_share(state_of(arm, q)).max(initial=0.0)) if len(q) else 0.0
    if not largest:
        return ()
    return (
        (
            f"load over stiffness and length, t/(k l), of parts in loops: {largest:.1g} at most, "
            f"of {len(q)} poses spread evenly. The load adds or takes away about this share of the "
            "stiffness, which is not counted"
        ),
    )
