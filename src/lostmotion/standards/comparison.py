"""Comparison of a measured robot with the predicted robots, figure by figure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.intervals import Estimate, of_length
from lostmotion.error_model.robot_intervals import robots_quantile
from lostmotion.error_model.visit_intervals import student_interval
from lostmotion.laws.iso9283 import PATH_FIGURES
from lostmotion.propagation.iso9283.cube import NAMES
from lostmotion.propagation.iso9283.robots import DISTANCE, FROM_THREE_SIDES
from lostmotion.standards.commanded_poses import SAME
from lostmotion.standards.measured_robot import natural_order

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.propagation.iso9283.cube import CommandedPoses, Cube
    from lostmotion.propagation.iso9283.robots import LoadSheet, PredictedRobots
    from lostmotion.spatial import Floats
    from lostmotion.standards.measured_robot import MeasuredLoad, MeasuredRobot

# Orientations of the tool that differ by less are equal, rad.
_SAME_ORIENTATION: Final = 0.01
_LOW: Final = 0.05
_HIGH: Final = 0.95
_BASE: Final = 6
_AXES: Final = ("a", "b", "c", "x", "y", "z")
_TURNS: Final = 3


@dataclass(frozen=True)
class OverRobots:
    """Distribution of a figure over the simulated robots: mean, 5th and 95th percentile, with
    confidence intervals.
    """

    mean: Estimate
    low: Estimate
    high: Estimate


def over_robots(values: Floats, *, signed: bool = False) -> OverRobots:
    """Return the distribution of a figure (robot,) over robots; intervals of unsigned figures do
    not go below zero.
    """
    low, high = (
        Estimate(*(float(x) for x in robots_quantile(values, level))) for level in (_LOW, _HIGH)
    )
    mean = student_interval(values)
    return OverRobots(mean if signed else of_length(mean.value, mean.low, mean.high), low, high)


@dataclass(frozen=True)
class ComparedFigure:
    """One figure: name, pose or path, whether it is an angle (rad) or a length (m), load,
    distribution over predicted robots, measured value.
    """

    name: str
    pose: str
    angle: bool
    load: float
    predicted: OverRobots
    measured: Estimate

    @property
    def within(self) -> bool:
        """Return whether the measured value lies between the 5th and the 95th percentile of the
        predicted robots.
        """
        return self.predicted.low.value <= self.measured.value <= self.predicted.high.value


def compare(predicted: PredictedRobots, measured: MeasuredRobot) -> list[ComparedFigure]:
    """Return the figures that both have at the same poses, along the same path and under the same
    load; empty if there are none.

    Orientations are compared where measured and predicted tool orientation agree; along a path only
    with six joints or more. AP_p with best-fit frames is compared where the measured poses
    determine only a base frame, as the fit of the predicted robots does.
    """
    found: list[ComparedFigure] = []
    for there in measured.loads:
        for sheet in predicted.loads:
            if sheet.load == there.load:
                found += _at_poses(predicted.cube, sheet, there) + _along_path(
                    predicted, sheet, there
                )
    return [each for each in found if math.isfinite(each.measured.value)]


def compare_at(
    at: CommandedPoses, sheets: Sequence[LoadSheet], measured: MeasuredRobot
) -> list[ComparedFigure]:
    """Return the figures of robots predicted at the commanded poses of a measured one, as `compare`
    does for those of a cube.
    """
    found = [
        each
        for there in measured.loads
        for sheet in sheets
        if sheet.load == there.load
        for each in _at_poses(at, sheet, there)
    ]
    return sorted(
        (each for each in found if math.isfinite(each.measured.value)),
        key=lambda each: natural_order(each.pose),
    )


def different_orientations(at: Cube | CommandedPoses, measured: MeasuredLoad) -> tuple[str, ...]:
    """Return the names of the poses at which the measured tool orientation differs from that of the
    predicted arm.
    """
    known = {pose.name: pose.rotation for pose in measured.poses}
    return tuple(
        name
        for name, rotation in zip(at.names, at.poses[:, :3, :3], strict=True)
        if name in known and _apart(known[name], rotation)
    )


def _apart(one: Floats, other: Floats) -> bool:
    """Return whether two rotations (3, 3) differ; unknown rotations (NaN) count as equal."""
    return float(np.linalg.norm(one - other)) > math.sqrt(2) * _SAME_ORIENTATION


def determines_tool_frame(measured: MeasuredLoad) -> bool:
    """Return whether the measured poses determine a tool frame besides the base frame; predicted
    robots are fitted with a base frame only.
    """
    return measured.fit is not None and measured.fit.rank > _BASE


def _at_poses(
    points: Cube | CommandedPoses, sheet: LoadSheet, measured: MeasuredLoad
) -> list[ComparedFigure]:
    at = {pose.name: pose for pose in measured.poses}
    command = points.poses[:, :3, 3]
    if not set(points.names) <= set(at) or not all(
        np.linalg.norm(at[name].command - command[k]) <= SAME for k, name in enumerate(points.names)
    ):
        return []
    found: list[ComparedFigure] = []
    turned = different_orientations(points, measured)
    # A fit of frames over more poses than were predicted is another fit.
    fitted = not determines_tool_frame(measured) and len(points.names) == len(measured.poses)

    def add(
        name: str,
        pose: str,
        values: Floats,
        value: Estimate,
        *,
        angle: bool = False,
        signed: bool = False,
    ) -> None:
        found.append(
            ComparedFigure(name, pose, angle, sheet.load, over_robots(values, signed=signed), value)
        )

    for k, name in enumerate(points.names):
        pose = at[name]
        add("AP_p", name, sheet.accuracy[k], pose.accuracy)
        add(
            "AP_p fitted",
            name,
            sheet.fitted[k],
            Estimate(pose.fitted if fitted else math.nan, math.nan, math.nan),
        )
        add("RP_l", name, sheet.repeatability[k], pose.repeatability)
        average = np.concatenate([sheet.turn[k], sheet.barycentre[k]], axis=-1)
        for axis, letter in list(enumerate(_AXES))[_TURNS if name in turned else 0 :]:
            add(
                f"AP_{letter}",
                name,
                average[:, axis],
                pose.axes[axis],
                angle=axis < _TURNS,
                signed=True,
            )
            if axis < _TURNS:
                add(f"RP_{letter}", name, sheet.scatter[k, :, axis], pose.scatter[axis], angle=True)
        if points.names == NAMES and k in FROM_THREE_SIDES:
            add(
                "vAP_p",
                name,
                sheet.multi_directional[FROM_THREE_SIDES.index(k)],
                pose.multi_directional,
            )
    if measured.distance is not None and np.isfinite(sheet.distance).all():
        both = "-".join(NAMES[k] for k in DISTANCE)
        for word, values, value in zip(
            ("AD_p", "RD"), sheet.distance, measured.distance, strict=True
        ):
            add(word, both, values, value, signed=word == "AD_p")
    return found


def _along_path(
    predicted: PredictedRobots, sheet: LoadSheet, measured: MeasuredLoad
) -> list[ComparedFigure]:
    """Compare the path that the predicted robots followed; orientation only where it is constant
    over the cube.
    """
    ends = predicted.cube.poses[list(predicted.path_ends), :3, 3]
    name = "-".join(NAMES[k] for k in predicted.path_ends)
    return [
        ComparedFigure(
            word,
            name,
            word[-1] in "abc",
            sheet.load,
            over_robots(values),
            Estimate(float(value), math.nan, math.nan),
        )
        for path in measured.paths
        if path.name == name and np.abs(path.ends - ends).max() <= SAME
        for word, values, value in zip(PATH_FIGURES, sheet.path, path.figures, strict=True)
        if predicted.cube.rotation is not None or word[-1] not in "abc"
    ]
