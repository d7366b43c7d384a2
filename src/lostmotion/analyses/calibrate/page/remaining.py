"""What remains after a calibration: the accuracy that is predicted, what is not estimated, and what
to measure next.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.calibrate.answer import FEWEST_COUNTED, corrected_radius
from lostmotion.calibration.plan import next_poses
from lostmotion.reporting.joint_values import joint_values
from lostmotion.reporting.sheet import in_words, length, table

if TYPE_CHECKING:
    from lostmotion.analyses.calibrate.answer import CalibrationAnswer
    from lostmotion.reporting.sheet import Section

_PREDICTED: Final = 256
_QUANTILE: Final = 0.95
# What no measurement of this kind can resolve: what it is, why, and what to measure instead.
_STIFFNESS: Final = (
    "joint stiffness",
    "one payload: deflection by the arm's own weight resembles tilts and first harmonics",
    "the same poses with two payloads, in a column payload [kg]",
)
_SIDE: Final = (
    "play",
    "the direction of approach is not recorded: play counts as scatter between visits",
    "both directions, with a column NAME approach",
)
_DRIFT: Final = ("drift", "no time is recorded", "the time of each row, in a column time [s]")
_ORIENTATION: Final = (
    "orientation of the tool",
    "a point has none",
    "three points of the tool, or its full pose",
)


def predicted_accuracy(answer: CalibrationAnswer) -> Section:
    """Return the accuracy that is predicted where the estimates are corrected."""
    robot = answer.robot
    low, high = answer.visits.q.min(axis=0), answer.visits.q.max(axis=0)
    share = np.random.default_rng(answer.seed).random((_PREDICTED, len(low)))
    limits = robot.arm.limits
    rows = []
    for name, ends in (("measured joint ranges", (low, high)), ("joint limits", limits.T)):
        radius = corrected_radius(robot, ends[0] + share * (ends[1] - ends[0]))
        worst = np.quantile(radius, _QUANTILE)
        rows.append((name, length(float(radius.mean())), length(float(worst))))
    covered = 100 * robot.climb.kept.blocked.coverage
    note = "the tool is within it of the corrected command in 95 % of visits, each in the base "
    note += "frame as measured; noise of the instrument is not in it. Of the measurements in "
    note += f"excluded regions {covered:.0f} % are within their 95 % regions"
    if len(answer.visits) < FEWEST_COUNTED:
        note += f", a share that fewer than {FEWEST_COUNTED} poses do not compare with 95 %"
    title = "Predicted accuracy with the estimates corrected"
    return table("predicted", title, ("mean 95 % radius", "95th percentile"), rows, note)


def refusals(answer: CalibrationAnswer) -> list[Section]:
    """Return what no such measurement can estimate, why, and what to measure instead."""
    payload = answer.visits.payload
    kinds = [_STIFFNESS] if payload is None or not np.ptp(payload) else []
    kinds += [_DRIFT] if answer.visits.time is None else []
    kinds += [] if np.any(answer.visits.approach) else [_SIDE]
    kinds += [_ORIENTATION] if answer.visits.rotation is None else []
    rows = [(what, in_words(instead), why) for what, why, instead in kinds]
    return [table("refused", "Not estimated", ("measure instead",), rows)] if rows else []


def next_measurements(answer: CalibrationAnswer) -> Section:
    """Return the poses that would improve the calibration most."""
    q, radius = next_poses(answer.robot, answer.visits.q, answer.seed)
    rows = [
        (joint_values(answer.robot.arm, each), length(float(radius[k])))
        for k, each in enumerate(q, 1)
    ]
    return table(
        "next",
        "Poses to measure next",
        ("95 % radius with so many",),
        rows,
        f"now {length(float(radius[0]))}, mean over the measured joint ranges, without the scatter "
        "between visits",
    )
