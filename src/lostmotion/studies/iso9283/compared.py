"""Does a measured robot look like one of those predicted? Each figure of its sheet against the same figure of the robots built."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.studies.intervals import Estimate, robots_quantile
from lostmotion.studies.iso9283.confidence import student_interval
from lostmotion.studies.iso9283.cube import INWARD, NAMES, five_points
from lostmotion.studies.iso9283.paths import PATH_FIGURES
from lostmotion.studies.iso9283.predicted import DISTANCE, FROM_THREE_SIDES

if TYPE_CHECKING:
    from lostmotion.spatial import Floats
    from lostmotion.studies.iso9283.measured import Measured, MeasuredLoad
    from lostmotion.studies.iso9283.predicted import LoadSheet, Predicted
    from lostmotion.studies.iso9283.visits import Visits

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
    """One figure: its name, which pose or path, whether it is an angle (rad) or a length (m), the load, what robots show, what was measured."""

    name: str
    pose: str
    angle: bool
    load: float
    predicted: OverRobots
    measured: Estimate

    @property
    def within(self) -> bool:
        """Tell whether the measured value lies between what 5 % and 95 % of the robots stay below."""
        return self.predicted.low.value <= self.measured.value <= self.predicted.high.value


def compare(predicted: Predicted, measured: Measured) -> list[Compared]:
    """Which figures do both have, at the same poses, along the same path and under the same load? Empty where poses and loads are others."""
    found: list[Compared] = []
    for there in measured.loads:
        for sheet in predicted.loads:
            if sheet.load == there.load:
                found += _at_poses(predicted, sheet, there) + _along_path(predicted, sheet, there)
    return [each for each in found if math.isfinite(each.measured.value)]


def _at_poses(predicted: Predicted, sheet: LoadSheet, measured: MeasuredLoad) -> list[Compared]:
    at = {pose.name: pose for pose in measured.poses}
    command = predicted.cube.poses[:, :3, 3]
    if not set(NAMES) <= set(at) or not all(np.linalg.norm(at[name].command - command[k]) <= SAME for k, name in enumerate(NAMES)):
        return []
    found: list[Compared] = []

    def add(name: str, pose: str, values: Floats, value: Estimate, *, angle: bool = False) -> None:
        found.append(Compared(name, pose, angle, sheet.load, over_robots(values), value))

    for k, name in enumerate(NAMES):
        pose = at[name]
        add("AP_p", name, sheet.accuracy[k], pose.accuracy)
        add("AP_p fitted", name, sheet.fitted[k], Estimate(pose.fitted, math.nan, math.nan))
        add("RP_l", name, sheet.repeatability[k], pose.repeatability)
        average = np.concatenate([sheet.turn[k], sheet.barycentre[k]], axis=-1)
        for axis, letter in enumerate(_AXES):
            add(f"AP_{letter}", name, average[:, axis], pose.axes[axis], angle=letter in "abc")
        for axis, letter in enumerate("abc"):
            add(f"RP_{letter}", name, sheet.scatter[k, :, axis], pose.scatter[axis], angle=True)
        if k in FROM_THREE_SIDES:
            add("vAP_p", name, sheet.multi_directional[FROM_THREE_SIDES.index(k)], pose.multi_directional)
    if measured.distance is not None:
        both = "-".join(NAMES[k] for k in DISTANCE)
        for word, values, value in zip(("AD_p", "RD"), sheet.distance, measured.distance, strict=True):
            add(word, both, values, value)
    return found


def _along_path(predicted: Predicted, sheet: LoadSheet, measured: MeasuredLoad) -> list[Compared]:
    """Compare the path that robots were sent along; whether its ends are those of the cube is seen by them."""
    ends = predicted.cube.poses[list(predicted.path_ends), :3, 3]
    name = "-".join(NAMES[k] for k in predicted.path_ends)
    return [
        Compared(word, name, word[-1] in "abc", sheet.load, over_robots(values), value)
        for path in measured.paths
        if path.name == name and np.abs(path.ends - ends).max() <= SAME
        for word, values, value in zip(PATH_FIGURES, sheet.path, path.figures, strict=True)
    ]


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
    rotation = visits.rotation[rows[0]]
    return points[0], side, rotation if np.isfinite(rotation).all() else None
