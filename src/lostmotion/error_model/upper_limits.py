"""Values that are a maker's upper limits: how much of an arm's error and of its scatter between visits rests on each of them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.budget import Tally, costs
from lostmotion.error_model.pose_matrix import screws
from lostmotion.error_model.provenance import LimitShare
from lostmotion.parts.gearbox.gearbox import LIMITED

if TYPE_CHECKING:
    from lostmotion.error_model.pose_matrix import Column
    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Enough to rank the limits and to select those that count; shares of a budget, not figures of their own.
_MOST_POSES: Final = 256
# A limit below this share of a mean square moves no digit that is printed.
_LEAST: Final = 1e-3


def limit_shares(arm: Arm, q: Floats, approach: float | Floats = 0.0) -> tuple[LimitShare, ...]:
    """Return the limits that count at these poses (pose, joint), rad and m, the largest contributor first.

    Shares are exact sums over terms, at no more than 256 of the poses, evenly spread. A limit counts where it makes more than a thousandth of the
    mean-square error, or of that between visits. `approach` as in `screws`. Raises ValueError for q of another shape or not finite.
    """
    limited = {
        f"joints.{joint.name}.gearbox": (joint.name, joint.gearbox.model, keys)
        for joint in arm.moving
        if joint.gearbox is not None and (keys := getattr(joint.gearbox, "upper_limits", ()))
    }
    if not limited:
        return ()
    rows = np.unique(np.linspace(0, len(q) - 1, min(len(q), _MOST_POSES)).astype(int))
    arriving = approach[rows] if isinstance(approach, np.ndarray) else approach
    found = costs(Tally.of(screws(arm, np.asarray(q)[rows], approach=arriving), _item))
    between = sum(cost.levels[2] for cost in found)
    out = []
    for owner, (joint, model, keys) in limited.items():
        for key in keys:
            own = [cost for cost in found if key in LIMITED and cost.part == f"{owner} {LIMITED[key]}"]
            of_error, of_visits = sum(cost.share for cost in own), sum(cost.levels[2] for cost in own)
            out.append(LimitShare(joint, model, key, of_error, of_visits / between if between else 0.0))
    counting = [each for each in out if max(each.of_error, each.of_repeat) > _LEAST]
    return tuple(sorted(counting, key=lambda each: (-each.of_error, -each.of_repeat, each.joint)))


def _item(column: Column) -> str:
    sized = column.of.term.parameter
    return column.owner if sized is None else f"{column.owner} {sized.key}"


def with_limits(known: States, arm: Arm, q: Floats, approach: float | Floats = 0.0) -> States:
    """Return what is known of an arm, with the limits that count at these poses; arguments as for `limit_shares`."""
    return replace(known, limits=limit_shares(arm, q, approach))


def in_error(known: States) -> bool:
    """Return whether limits count in the position error."""
    return any(each.of_error > _LEAST for each in known.limits)


def in_repeats(known: States) -> bool:
    """Return whether limits count in the scatter between visits."""
    return any(each.of_repeat > _LEAST for each in known.limits)
