"""Headline, cards and notes of a measured robot by ISO 9283."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.iso9283.page.labels import estimate_figure, measured_label
from lostmotion.analyses.iso9283.page.measured_figures import (
    SHOWN,
    positioning_cards,
    positioning_sentence,
)
from lostmotion.errors import shown
from lostmotion.io.limits import cut
from lostmotion.laws.iso9283 import PATH_FIGURES
from lostmotion.propagation.iso9283.cube import FULL
from lostmotion.reporting.sheet import Card, length, several
from lostmotion.standards.comparison import (
    determines_tool_frame,
    different_orientations,
    over_robots,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.error_model.intervals import Estimate
    from lostmotion.io.measured.visits import Visits
    from lostmotion.propagation.iso9283.cube import CommandedPoses
    from lostmotion.propagation.iso9283.robots import PredictedRobots
    from lostmotion.standards.comparison import ComparedFigure
    from lostmotion.standards.measured_robot import MeasuredLoad, MeasuredPose, MeasuredRobot

_MOST_NAMED: Final = 5
_LONGEST_NAME: Final = 40
# Multiple of the predicted 95th percentile, or length (m), above which a mean AP_p or an AT_p is
# doubtful.
_DOUBTED: Final = 10.0
_FAR: Final = 5e-3
# Path figures of orientation.
_TURNS: Final = tuple(k for k, word in enumerate(PATH_FIGURES) if word[-1] in "abc")


def measured_counts(measured: MeasuredRobot) -> str:
    """Return the number of visits and readings, in words."""
    along = sum(map(bool, measured.visits.path))
    visits = len(measured.visits.path) - along
    counted = [several(visits, "measured visit")] if visits or not along else []
    return "; ".join([*counted, *([f"{along} readings along paths"] if along else [])])


def measured_verdict(
    measured: MeasuredRobot, compared: Sequence[ComparedFigure], commanded: CommandedPoses | None
) -> str:
    """Return the headline of the measured robot: how many of its characteristics lie within the
    range of the robots predicted at the same poses, and what they are.
    """
    sentences = (
        [positioning_sentence(measured)] if any(load.axes for load in measured.loads) else []
    )
    for load in measured.loads:
        parts = []
        if load.pooled is not None:
            raw, fitted = load.pooled
            parts.append(
                f"AP_p {estimate_figure(raw[0])}, mean over "
                f"{several(len(load.poses), 'pose')}, {estimate_figure(fitted[0])} with "
                "best-fit frames"
            )
        repeat = [
            pose.repeatability for pose in load.poses if math.isfinite(pose.repeatability.value)
        ]
        if repeat:
            robust = _without_outlying(load)
            beside = (
                (
                    f", {estimate_figure(robust)} without "
                    f"{several(len(_outlying(load)), 'outlying visit')}"
                )
                if robust is not None
                else ""
            )
            parts.append(
                f"RP_l up to {estimate_figure(max(repeat, key=lambda each: each.value))}{beside}"
            )
        parts += [
            f"AT_p {length(path.figures[0])} and RT_p {length(path.figures[1])} along {path.name}"
            for path in load.paths
        ]
        if parts:
            sentences.append(
                f"{measured_label('Measured', load, measured.loads)}: {', '.join(parts)}."
            )
    text = " ".join(sentences) or (
        "Measured: no command and no pose visited twice, so neither accuracy nor "
        "repeatability is known."
    )
    shown = [each for each in compared if each.name in SHOWN]
    if not shown:
        return text
    where = (
        "" if commanded is None else f" at the {len(commanded.names)} commanded poses of the file"
    )
    return (
        f"{sum(each.within for each in shown)} of {len(shown)} measured figures lie "
        "between the 5th and 95th percentile of the robots "
        f"predicted{where}{_largest_of(shown)}. {text}"
    )


def _largest_of(shown: list[ComparedFigure]) -> str:
    """Return the largest measured AP_p and RP_l, each with the range of the predicted robots at its
    pose.
    """
    parts = []
    for name in ("AP_p", "RP_l"):
        if of := [each for each in shown if each.name == name]:
            most = max(of, key=lambda each: each.measured.value)
            low, high = (length(end.value) for end in (most.predicted.low, most.predicted.high))
            parts.append(
                f"{name} at {cut(most.pose, _LONGEST_NAME)} {length(most.measured.value)} "
                f"measured, {low} … {high} predicted"
            )
    return f": {'; '.join(parts)}" if parts else ""


def _outlying(load: MeasuredLoad) -> list[tuple[MeasuredPose, int, float]]:
    """Return the outlying visits of a load: pose, line and distance (m) from the median of the
    pose's visits.
    """
    return [(pose, line, far) for pose in load.poses for _, line, far in pose.outlying]


def _without_outlying(load: MeasuredLoad) -> Estimate | None:
    """Return the largest RP_l over the poses without outlying visits; None where there is no
    outlying visit.
    """
    if not _outlying(load):
        return None
    each = (pose.without_outlying if pose.outlying else pose.repeatability for pose in load.poses)
    return max(
        (value for value in each if math.isfinite(value.value)), key=lambda value: value.value
    )


def measured_warnings(
    measured: MeasuredRobot, predicted: PredictedRobots | None
) -> tuple[str, ...]:
    """Return what makes the measured figures doubtful: commands far from what was attained,
    outlying visits, readings that were lost.
    """
    return (
        *_command_warnings(measured, predicted),
        *_outlying_warnings(measured),
        *_lost_warnings(measured.visits),
    )


def measured_notes(
    measured: MeasuredRobot,
    predicted: PredictedRobots | None,
    at_commands: CommandedPoses | None,
    *,
    compared: bool,
) -> tuple[str, ...]:
    """Return notes on rows and columns that do not count, and on figures that are not compared."""
    none: tuple[str, ...] = ()
    if predicted is not None and not compared:
        none = (
            (
                "not compared: no pose of the measured file has a commanded position under a "
                "load that was predicted"
            ),
        )
    return (
        *_duplicates_notes(measured.visits),
        *_unused_notes(measured.visits),
        *_not_compared_notes(measured, predicted if compared else None, at_commands),
        *none,
    )


def _named(items: Sequence[object]) -> str:
    """Return the first items, and how many more there are."""
    more = f" and {len(items) - _MOST_NAMED} more" if len(items) > _MOST_NAMED else ""
    return f"{', '.join(map(str, items[:_MOST_NAMED]))}{more}"


def _outlying_warnings(measured: MeasuredRobot) -> tuple[str, ...]:
    """Return a warning that names the visits far from the others, which decide on the repeatability
    by themselves.
    """
    far = [each for load in measured.loads for each in _outlying(load)]
    if not far:
        return ()
    named = _named([f"{pose.name} in line {line} by {length(away)}" for pose, line, away in far])
    each = "visit lies" if len(far) == 1 else "visits lie"
    return (
        (
            f"{len(far)} measured {each} far from the others ({named}): a lost step, a wrong "
            "reading, or a rare event of the robot"
        ),
    )


def _lost_warnings(visits: Visits) -> tuple[str, ...]:
    """Return a warning that names the rows without a reading, which count in no figure."""
    if not visits.lost:
        return ()
    lines = _named([line for _, line in visits.lost])
    return (
        (
            f"{several(len(visits.lost), 'row')} without a reading excluded (line {lines}): "
            "the instrument lost its target"
        ),
    )


def _unused_notes(visits: Visits) -> tuple[str, ...]:
    """Return a note that names the columns that no role is mapped to."""
    if not visits.unused:
        return ()
    names = _named([shown(cut(name, _LONGEST_NAME)) for name in visits.unused])
    return (
        (f"columns that are not used: {names}; --map 'ROLE = COLUMN [unit]' says what a column is"),
    )


def _duplicates_notes(visits: Visits) -> tuple[str, ...]:
    """Return a note that rows of the measurement repeat others, with the unread columns in which
    they differ.
    """
    if not visits.duplicates:
        return ()
    rows = several(visits.duplicates, "row")
    note = (
        f"{rows} of the measurement dropped: identical to another row in every column that is read"
    )
    if visits.unread:
        columns = _named([shown(name) for name in visits.unread])
        note += f"; they differ only in {columns}, to which no role is mapped"
    separate = "separate visits with the same readings, number them in a column 'cycle'"
    return (f"{note}. If they are {separate}",)


def _command_warnings(
    measured: MeasuredRobot, predicted: PredictedRobots | None
) -> tuple[str, ...]:
    """Return a warning for each accuracy so poor that wrong commands, another frame or another unit
    are likelier than the arm.
    """
    out = []
    for load in measured.loads:
        known = [pose.accuracy.value for pose in load.poses if math.isfinite(pose.accuracy.value)]
        means = [("mean AP_p over poses", sum(known) / len(known), 0)] if known else []
        means += [(f"AT_p along {path.name}", float(path.figures[0]), 1) for path in load.paths]
        for name, value, along in means:
            sheet = None if predicted is None else predicted.loads[0]
            usual = (
                math.inf
                if sheet is None
                else float(
                    over_robots(sheet.path[0] if along else sheet.accuracy.max(axis=0)).high.value
                )
            )
            if value > min(_FAR, _DOUBTED * usual):
                against = (
                    ""
                    if sheet is None
                    else f", above the 95th percentile of the predicted robots, {length(usual)}"
                )
                out.append(
                    f"{measured_label(f'measured {name} is {length(value)}', load, measured.loads)}{against}: "  # noqa: E501
                    "check that the commanded positions "
                    "are those sent to the robot, in the frame and the units of the readings"
                )
    return tuple(out)


def _not_compared_notes(
    measured: MeasuredRobot, predicted: PredictedRobots | None, at_commands: CommandedPoses | None
) -> tuple[str, ...]:
    """Return notes on measured figures that are not evaluated, or not compared with the predicted
    robots, with the reason.
    """
    out = []
    visits = measured.visits
    attained, commanded = (
        np.isfinite(each).all(axis=(1, 2)) for each in (visits.orientation, visits.rotation)
    )
    if (attained & ~commanded).any():
        out.append(
            "orientations without commands (ac, bc, cc, or --tool-rpy): RP_a,b,c are "
            "evaluated, AP_a,b,c are not"
        )
    if predicted is None:
        return tuple(out)
    if at_commands is not None:
        text = (
            "compared at the commanded poses of the file, which are not P1 to P5 of the test cube"
        )
        more = f"; {at_commands.left} more poses are not compared" if at_commands.left else ""
        out.append(
            f"{text}; of several configurations that reach a pose, the one found first is "
            f"predicted{more}"
        )
    at = at_commands or predicted.cube
    different = {name: None for load in measured.loads for name in different_orientations(at, load)}
    if different:
        why = (
            ""
            if len(predicted.arm.tree.tool_joints) >= FULL
            else ": with fewer than six joints it follows from the position"
        )
        out.append(
            f"orientation is not compared at {', '.join(different)}, where measured and "
            f"predicted tool orientation differ{why}"
        )
    if predicted.cube.rotation is None and any(
        math.isfinite(path.figures[k])
        for load in measured.loads
        for path in load.paths
        for k in _TURNS
    ):
        out.append(
            "AT_a,b,c and RT_a,b,c are not compared: with fewer than six joints the "
            "orientation follows from the position"
        )
    if any(determines_tool_frame(load) for load in measured.loads):
        out.append(
            "AP_p with best-fit frames is not compared: measured poses are fitted with base "
            "and tool frame, predicted ones with a base frame only"
        )
    return tuple(out)


def measured_cards(measured: MeasuredRobot, compared: Sequence[ComparedFigure]) -> list[Card]:
    """Return the cards of the measured robot under its heaviest load."""
    out = positioning_cards(measured)
    load = measured.loads[0]
    quiet = (
        f", {100 * load.load:g} % load" if len({each.load for each in measured.loads}) > 1 else ""
    )
    quiet += f", from {load.side}" if load.side else ""
    repeat = [pose.repeatability for pose in load.poses if math.isfinite(pose.repeatability.value)]
    if repeat:
        out.append(
            Card(
                "RP_l measured",
                str(estimate_figure(max(repeat, key=lambda each: each.value))),
                f"worst pose{quiet}",
            )
        )
    robust = _without_outlying(load)
    if robust is not None:
        out.append(
            Card(
                "RP_l measured, robust",
                str(estimate_figure(robust)),
                f"without {several(len(_outlying(load)), 'outlying visit')}{quiet}",
            )
        )
    if load.pooled is not None:
        out += [
            Card(
                "AP_p measured",
                str(estimate_figure(load.pooled[0][0])),
                f"mean of {several(len(load.poses), 'pose')}{quiet}",
            ),
            Card(
                "AP_p measured, best-fit frames",
                str(estimate_figure(load.pooled[1][0])),
                f"mean of {several(len(load.poses), 'pose')}{quiet}",
            ),
        ]
    out += [
        Card(
            f"{word} measured",
            str(length(float(load.paths[0].figures[k]))),
            f"{load.paths[0].name}{quiet}",
        )
        for k, word in enumerate(PATH_FIGURES[:2])
        if load.paths
    ]
    shown = [each for each in compared if each.name in SHOWN]
    if shown:
        out.append(
            Card(
                "as predicted",
                f"{sum(each.within for each in shown)} of {len(shown)}",
                "within 5th to 95th percentile",
            )
        )
    return out
