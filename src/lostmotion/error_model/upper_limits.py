"""Values that are a maker's upper limits: the share of each in an arm's mean-square error and in
its scatter between visits.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.provenance import LimitShare
from lostmotion.parts.gearbox.gearbox import LIMITED

if TYPE_CHECKING:
    from lostmotion.error_model.columns import Column
    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Enough poses to rank the limits and to select those that count.
_MOST_POSES: Final = 256
# A limit with a smaller share of the mean square changes no printed digit.
_LEAST: Final = 1e-3


def limit_shares(arm: Arm, q: Floats, approach: float | Floats = 0.0) -> tuple[LimitShare, ...]:
    """Return the upper limits that count at these poses, the largest contributor first.

    Shares are exact sums over terms, at no more than 256 of the poses, evenly spaced. A limit
    counts where its share of the mean-square error, or of the mean square between visits, is more
    than a thousandth.

    q         (pose, joint) rad or m
    approach  sign of the joints' last motion, as in `screws`

    Raises ValueError for q of another shape or not finite.
    """
    # Loaded with Numba, which a check of a file does without.
    from lostmotion.error_model.budget import Tally, costs
    from lostmotion.error_model.pose_matrix import pose_matrix

    limited = {
        f"joints.{joint.name}.gearbox": (joint.name, joint.gearbox.model, keys)
        for joint in arm.driven
        if joint.gearbox is not None and (keys := getattr(joint.gearbox, "upper_limits", ()))
    }
    if not limited:
        return ()
    rows = np.unique(np.linspace(0, len(q) - 1, min(len(q), _MOST_POSES)).astype(int))
    last_motion = approach[rows] if isinstance(approach, np.ndarray) else approach
    found = costs(Tally.of(pose_matrix(arm, np.asarray(q)[rows], approach=last_motion), _item))
    between = sum(cost.levels[2] for cost in found)
    out = []
    for owner, (joint, model, keys) in limited.items():
        for key in keys:
            own = [
                cost for cost in found if key in LIMITED and cost.part == f"{owner} {LIMITED[key]}"
            ]
            of_error, of_visits = (
                sum(cost.share for cost in own),
                sum(cost.levels[2] for cost in own),
            )
            out.append(
                LimitShare(joint, model, key, of_error, of_visits / between if between else 0.0)
            )
    counting = [each for each in out if max(each.of_error, each.of_repeat) > _LEAST]
    return tuple(sorted(counting, key=lambda each: (-each.of_error, -each.of_repeat, each.joint)))


def _item(column: Column) -> str:
    """Return the label of a column: its part, and the key of its parameter where it has one."""
    sized = column.of.term.parameter
    return column.owner if sized is None else f"{column.owner} {sized.key}"


def with_limits(known: States, arm: Arm, q: Floats, approach: float | Floats = 0.0) -> States:
    """Return the states of an arm's error sources with the upper limits that count at these poses;
    arguments and errors as for `limit_shares`.
    """
    return replace(known, limits=limit_shares(arm, q, approach))


def in_error(known: States) -> bool:
    """Return whether any upper limit counts in the position error."""
    return any(each.of_error > _LEAST for each in known.limits)


def in_repeats(known: States) -> bool:
    """Return whether any upper limit counts in the scatter between visits."""
    return any(each.of_repeat > _LEAST for each in known.limits)
