"""Comparison of a measured robot with the predicted robots, figure by figure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.iso9283.confidence import student_interval
from lostmotion.analyses.iso9283.cube import (
    INWARD,
    NAMES,
    five_points,
    orientation_clause,
    out_of_reach,
)
from lostmotion.analyses.iso9283.measured import natural_order
from lostmotion.analyses.iso9283.measured_paths import MIN_COMMANDS, path_ends
from lostmotion.analyses.iso9283.paths import PATH_FIGURES
from lostmotion.analyses.iso9283.predicted import DISTANCE, FROM_THREE_SIDES
from lostmotion.error_model.intervals import Estimate, of_length, robots_quantile
from lostmotion.errors import InputError, Problem, shown

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.analyses.iso9283.commanded_poses import CommandedPoses
    from lostmotion.analyses.iso9283.cube import Cube
    from lostmotion.analyses.iso9283.measured import MeasuredLoad, MeasuredRobot
    from lostmotion.analyses.iso9283.predicted import LoadSheet, PredictedRobots
    from lostmotion.io.measured.visits import Visits
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Commanded positions (m) and tool orientations (rad) that differ by less are equal.
SAME: Final = 1e-3
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


def commanded_cube(visits: Visits) -> tuple[Floats, float, Floats | None] | None:
    """Return centre, side (m) and tool rotation (None if unknown) of the cube of the commanded P1
    to P5; None where they are not poses of a cube.
    """
    at = {name: k for k, name in reversed(list(enumerate(visits.pose)))}
    known = {**visits.known} | {
        name: visits.commanded_pose(at[name]) for name in NAMES if name in at
    }
    if not set(NAMES) <= set(known):
        return None
    points = np.stack([known[name][:3, 3] for name in NAMES])
    if not np.isfinite(points).all():
        return None
    side = float(np.linalg.norm(points[3] - points[1])) / (INWARD * math.sqrt(3))
    if np.linalg.norm(points - five_points(points[0], side), axis=1).max() > SAME:
        return None
    rotation = known[NAMES[0]][:3, :3]
    return points[0], side, rotation if np.isfinite(rotation).all() else None


def unreachable_command(
    arm: Arm, visits: Visits, centre: Floats, side: float, rotation: Floats | None
) -> InputError:
    """Return the error for commanded P1 to P5, of a cube with this centre and side (m), that the
    arm cannot reach.
    """
    at = next((k for k, name in enumerate(visits.pose) if name in NAMES), 0)
    points = five_points(centre, side)
    beyond = np.flatnonzero(out_of_reach(arm, points, rotation))
    named = [f"{NAMES[k]} at ({', '.join(f'{x * 1e3:.0f}' for x in points[k])}) mm" for k in beyond]
    place = (
        f"a cube of {side * 1e3:.0f} mm about ({', '.join(f'{x * 1e3:.0f}' for x in centre)}) mm"
    )
    found = (
        f"{', '.join(named)}, out of reach of {arm.name}"
        if named
        else f"on {place}, part of which {arm.name} cannot reach"
    )
    expected = (
        "commands in the arm's base frame, on a cube that it reaches "
        f"entirely{orientation_clause(arm)}"
    )
    alone = (
        f"lostmotion iso9283 --measured {visits.where[at][0]}, to evaluate the measured robot alone"
    )
    return InputError(
        [Problem(visits.where[at][0], "commanded positions of P1 to P5", found, expected, alone)]
    )


def poses_of_cube(centre: Floats, side: float, rotation: Floats | None) -> dict[str, Floats]:
    """Return P1 to P5 (4, 4) by name for a cube with this centre (3,) and side in m; rotation NaN
    where none is stated.
    """
    out = {}
    for name, point in zip(NAMES, five_points(np.asarray(centre, dtype=float), side), strict=True):
        out[name] = np.eye(4)
        out[name][:3, 3], out[name][:3, :3] = point, math.nan if rotation is None else rotation
    return out


def refuse_missing_commands(visits: Visits) -> None:
    """Raise InputError where commands of P1 to P5 or of a path are missing: the cube found by a
    search need not be where the robot was sent.
    """
    commanded = np.asarray(np.isfinite(visits.command).all(axis=1))
    lines = {
        path for path in dict.fromkeys(visits.path) if path and _no_line(visits, path, commanded)
    }
    missing: dict[str, list[int]] = {}
    for k, (pose, path) in enumerate(zip(visits.pose, visits.path, strict=True)):
        if path in lines or (pose in NAMES and not commanded[k]):
            missing.setdefault(visits.where[k][0], []).append(k)
    mistakes = []
    for file, rows in missing.items():
        poses = ", ".join(sorted({visits.pose[k] for k in rows} - {""}))
        paths = ", ".join(
            shown(path) for path in dict.fromkeys(visits.path[k] for k in rows) if path
        )
        named = " and ".join(
            ([f"poses {poses}"] if poses else [])
            + ([f"readings along path {paths}"] if paths else [])
        )
        mistakes.append(
            Problem(
                file,
                f"{len(rows)} row{'s' * (len(rows) > 1)}, from line {visits.where[rows[0]][1]}",
                f"{named} without commanded positions",
                (
                    "xc, yc, zc in the rows, a file of commands, or the cube that was commanded "
                    "(the cube found by a search may be another one)"
                ),
                '--cube "400 mm" --centre "600 mm, 0 mm, 400 mm"',
            )
        )
    if mistakes:
        raise InputError(mistakes)


def _no_line(visits: Visits, path: str, commanded: np.ndarray) -> bool:
    """Return whether neither a path's name nor its rows define the commanded line."""
    rows = np.array([each == path for each in visits.path])
    return (
        path_ends(path, visits.known) is None
        and int(np.count_nonzero(rows & commanded)) < MIN_COMMANDS
    )
