"""The correction of wanted joint values, and what it leaves where the arm then stands."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from lostmotion.controller_model.compensation import LARGEST_STEP
from lostmotion.controller_model.controller import OK, SINGULAR, Controller
from lostmotion.controller_model.lowering import tables_of
from lostmotion.controller_model.remainder import reached
from lostmotion.controller_model.validity import validity_of
from lostmotion.error_model.arrival import last_motion
from lostmotion.errors import Problem
from lostmotion.io.limits import MOST_MISTAKES, refuse_all

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats


class Wanted(Protocol):
    """Wanted poses: joint values (pose, joint), signs of the last motions (pose, joint; NaN where
    not stated), and file and line of each.
    """

    q: Floats
    side: Floats
    where: tuple[tuple[str, str], ...]


def corrected(
    arm: Arm,
    given: Wanted,
    *,
    passes: int,
    whole_pose: bool,
    largest_step: float | None,
    along_path: bool,
) -> tuple[Floats, dict[str, Any]]:
    """Return the joint values to send (pose, joint), rad or m, and what was changed and what is
    left, in SI.

    along_path  whether the last motions that are not stated follow from the order of the poses

    Raises InputError for loads that the parts do not bear.
    """
    unstated = np.nan if along_path else 0.0
    side, _ = last_motion(given.q, np.where(np.isnan(given.side), unstated, given.side))
    model = Controller(tables_of(arm, validity_of(arm)))
    found = model.compensate(
        given.q,
        side=side,
        passes=2 if passes > 1 else 1,
        whole_pose=whole_pose,
        largest_step=LARGEST_STEP if largest_step is None else largest_step,
    )
    refused = np.flatnonzero(~np.isin(found.status, [OK, SINGULAR]))
    if len(refused):
        expected = "a load within the tables of its parts; a smaller payload"
        refuse_all(
            [
                Problem(
                    file, line, "a load that a bearing does not bear", expected, 'mass = "2 kg"'
                )
                for file, line in (given.where[row] for row in refused[: MOST_MISTAKES + 1])
            ]
        )
    wanted = found.prediction.point
    if side.any():  # the equilibrium of the parts knows no last motions, that of the tables does
        without, left = (
            np.linalg.norm(each[:, 3:], axis=1) for each in (found.prediction.screw, found.left)
        )
    else:
        without, left = (
            np.linalg.norm(reached(arm, each) - wanted, axis=1) for each in (given.q, found.command)
        )
    changes = np.abs(found.command - given.q).max(axis=0)
    return found.command, {
        "rows": len(wanted),
        "changed": {
            joint.name: float(change) for joint, change in zip(arm.driven, changes, strict=True)
        },
        "slides": [each.name for each in arm.driven if not each.twist[:3].any()],
        "without": _summary(without),
        "left": _summary(left),
        "reduced": int(np.count_nonzero(found.status == SINGULAR)),
    }


def _summary(errors: Floats) -> dict[str, float]:
    return {"median": float(np.median(errors)), "worst": float(errors.max())}
