"""Does a measured robot look like one of those predicted? Each figure of its sheet against the same figure of the robots built."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.studies.intervals import Estimate, robots_quantile
from lostmotion.studies.iso9283.cube import INWARD, NAMES, five_points
from lostmotion.studies.iso9283.measured import student_interval
from lostmotion.studies.iso9283.predicted import DISTANCE, FROM_THREE_SIDES

if TYPE_CHECKING:
    from lostmotion.spatial import Floats
    from lostmotion.studies.iso9283.measured import Measured, Visits
    from lostmotion.studies.iso9283.predicted import Predicted

# m: commanded positions that differ by less are the same.
SAME: Final = 1e-3
_LOW: Final = 0.05
_HIGH: Final = 0.95
_AXES: Final = ("a", "b", "c", "x", "y", "z")


@dataclass(frozen=True)
class OverRobots:
    """How a figure falls over the robots built: mean, and what 5 % and 95 % of them stay below, with intervals."""

    mean: Estimate
    low: Estimate
    high: Estimate


def over_robots(values: Floats) -> OverRobots:
    """How does a figure (robot,) fall over robots?"""
    low, high = (Estimate(*(float(x) for x in robots_quantile(values, level))) for level in (_LOW, _HIGH))
    return OverRobots(student_interval(values), low, high)


@dataclass(frozen=True)
class Compared:
    """One figure: its name, which pose, whether it is an angle (rad) or a length (m), what robots show, what was measured."""

    name: str
    pose: str
    angle: bool
    predicted: OverRobots
    measured: Estimate

    @property
    def within(self) -> bool:
        """Tell whether the measured value lies between what 5 % and 95 % of the robots stay below."""
        return self.predicted.low.value <= self.measured.value <= self.predicted.high.value


def compare(predicted: Predicted, measured: Measured) -> list[Compared]:
    """Which figures do both have, at the same poses and under the full load? Empty where the poses are others."""
    sheet = predicted.loads[0]
    at = {pose.name: pose for pose in measured.poses}
    command = predicted.cube.poses[:, :3, 3]
    if not set(NAMES) <= set(at) or not all(np.linalg.norm(at[name].command - command[k]) <= SAME for k, name in enumerate(NAMES)):
        return []
    found: list[Compared] = []
    for k, name in enumerate(NAMES):
        pose = at[name]
        rows = [
            Compared("AP_p", name, False, over_robots(sheet.accuracy[k]), pose.accuracy),
            Compared("AP_p fitted", name, False, over_robots(sheet.fitted[k]), Estimate(pose.fitted, math.nan, math.nan)),
            Compared("RP_l", name, False, over_robots(sheet.repeatability[k]), pose.repeatability),
        ]
        average = np.concatenate([sheet.turn[k], sheet.barycentre[k]], axis=-1)
        for axis, letter in enumerate(_AXES):
            rows.append(Compared(f"AP_{letter}", name, axis < 3, over_robots(average[:, axis]), pose.axes[axis]))  # noqa: PLR2004 - turns come first
        rows += [
            Compared(f"RP_{letter}", name, True, over_robots(sheet.scatter[k, :, axis]), pose.scatter[axis]) for axis, letter in enumerate("abc")
        ]
        if k in FROM_THREE_SIDES:
            rows.append(Compared("vAP_p", name, False, over_robots(predicted.multi_directional[FROM_THREE_SIDES.index(k)]), pose.multi_directional))
        found += rows
    if measured.distance is not None:
        both = "-".join(NAMES[k] for k in DISTANCE)
        found += [
            Compared(word, both, False, over_robots(values), value)
            for word, values, value in zip(("AD_p", "RD"), predicted.distance, measured.distance, strict=True)
        ]
    return [each for each in found if math.isfinite(each.measured.value)]


def commanded_cube(visits: Visits) -> tuple[Floats, float, Floats | None] | None:
    """Which cube were P1 to P5 commanded in? Centre, side (m) and the tool's rotation where known; None where they are no five poses of a cube."""
    at = {name: k for k, name in reversed(list(enumerate(visits.pose)))}
    if not set(NAMES) <= set(at):
        return None
    rows = [at[name] for name in NAMES]
    points = visits.command[rows]
    if not np.isfinite(points).all():
        return None
    side = float(np.linalg.norm(points[3] - points[1])) / (INWARD * math.sqrt(3))
    if np.linalg.norm(points - five_points(points[0], side), axis=1).max() > SAME:
        return None
    return points[0], side, None if visits.rotation is None else visits.rotation[rows[0]]
