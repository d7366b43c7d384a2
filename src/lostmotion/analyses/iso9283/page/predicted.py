"""Tables of the predicted robots: test cube, pose, distance and path characteristics, drift."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.iso9283.page.labels import (
    NO_SCATTER,
    estimate_figure,
    load_label,
    scatter_figure,
)
from lostmotion.error_model.arrival import ANY_APPROACH, ISO_CYCLE
from lostmotion.laws.iso230 import APPROACHES, POSITIONS
from lostmotion.laws.iso9283 import PATH_FIGURES
from lostmotion.printed import stated_text
from lostmotion.propagation.iso9283.axes import REPEATABILITY
from lostmotion.propagation.iso9283.cube import NAMES
from lostmotion.propagation.iso9283.robots import DISTANCE, FROM_THREE_SIDES
from lostmotion.reporting.first_order import judged
from lostmotion.reporting.joint_values import joint_values
from lostmotion.reporting.sheet import Cell, length, several, table
from lostmotion.standards.comparison import over_robots

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.mechanism.warm_up import Drift
    from lostmotion.propagation.iso9283.robots import LoadSheet, PredictedRobots
    from lostmotion.reporting.sheet import Section
    from lostmotion.spatial import Floats

_AXES: Final = ("x", "y", "z", "a", "b", "c")
_SPREAD: Final = ("mean", "95th percentile")


def predicted_sections(predicted: PredictedRobots, drifted: Drift | None) -> list[Section]:
    """Return the tables of the predicted robots, in reading order."""
    return [
        _cube(predicted),
        _poses(predicted),
        *(_accuracy(predicted, sheet) for sheet in predicted.loads),
        _fitted(predicted),
        *(_repeatability(predicted, sheet) for sheet in predicted.loads),
        _either_side(predicted),
        *_by_axis(predicted),
        *([_axes_of_makers(predicted)] if predicted.axes else []),
        _sides(predicted),
        _distance(predicted),
        _path(predicted),
        *([] if drifted is None else [_drift(predicted, drifted)]),
        _check(predicted),
    ]


def _counted(predicted: PredictedRobots) -> str:
    return f"{several(predicted.robots, 'robot')} x {several(predicted.cycles, 'visit')}"


def _percent(load: float) -> str:
    return f"{100 * load:.0f} % of the payload"


def _cube(predicted: PredictedRobots) -> Section:
    cube = predicted.cube
    steps = (
        "" if math.isnan(cube.resolution) else f"last search step {cube.resolution * 1e3:.0f} mm"
    )
    rows = [
        ("side", length(cube.side, stated=True), steps),
        *((f"centre {axis}", _place(cube.centre[k])) for k, axis in enumerate("xyz")),
        (
            "points reached",
            cube.checked,
            "poses, corners and a grid, by inverse kinematics within the joint limits",
        ),
    ]
    held = (
        "constant orientation of the tool"
        if cube.rotation is not None
        else "fewer than six joints: the orientation follows from the position"
    )
    how = (
        "as stated"
        if cube.method == "given"
        else (
            f"the largest cube found: {cube.method}; another search may find one larger by some "
            "per cent"
        )
    )
    note = (
        f"{how}; {held}. Edges along the base's axes; obstacles and self-collision are not checked"
    )
    return table("cube", "Test cube", ("value",), rows, note)


def _place(value: float) -> Cell:
    """Return a coordinate in mm, without negative zero."""
    return Cell(round(float(value), 8) + 0.0, "mm", stated=True)


def _poses(predicted: PredictedRobots) -> Section:
    rows = []
    for k, name in enumerate(NAMES):
        joints = joint_values(predicted.arm, predicted.cube.q[k] + 0.0)  # without negative zero
        signs = "".join("+" if sign > 0 else "-" for sign in predicted.approach[k])
        rows.append(
            (
                name,
                *(_place(x) for x in predicted.cube.poses[k, :3, 3]),
                f"{joints}; direction of arrival {signs}",
            )
        )
    note = (
        "plane C1-C2-C7-C8, a tenth of the diagonal from its corners; visited in the order "
        "P5, P4, P3, P2, P1. Each joint moves monotonically from "
        "pose to pose, so it arrives from the same side in every cycle: + increasing, - decreasing"
    )
    return table("poses", "The five poses", ("x", "y", "z"), rows, note)


def _mean_and_p95(
    label: str,
    values: Floats,
    samples: str,
    *,
    angle: bool = False,
    signed: bool = False,
    scatter: bool = False,
) -> tuple[Any, ...]:
    """Return a row with the mean over robots of values (robot,), and the 95th percentile of their
    magnitude.
    """
    shown = scatter_figure if scatter else estimate_figure
    mean, high = over_robots(values, signed=signed).mean, over_robots(np.abs(values)).high
    return label, shown(mean, samples, angle=angle), shown(high, samples, angle=angle)


def _by_pose(values: Floats) -> dict[str, Floats]:
    """Return values (pose, robot) at each pose by its name, and those of each robot's worst
    pose.
    """
    return dict(zip(NAMES, values, strict=True)) | {"worst": values.max(axis=0)}


def _both_loads(
    predicted: PredictedRobots,
    key: str,
    title: str,
    values: Sequence[Floats],
    note: str,
    *,
    scatter: bool = False,
) -> Section:
    """Return a table of the 95th percentile over robots of values (pose, robot), one column for
    each load.
    """
    shown, counted = scatter_figure if scatter else estimate_figure, _counted(predicted)
    columns = tuple(f"{_SPREAD[1]}, {100 * sheet.load:.0f} % load" for sheet in predicted.loads)
    at = [_by_pose(each) for each in values]
    rows = [
        (name, *(shown(over_robots(each[name]).high, counted) for each in at)) for name in at[0]
    ]
    return table(key, title, columns, rows, note)


def _accuracy(predicted: PredictedRobots, sheet: LoadSheet) -> Section:
    counted = _counted(predicted)
    rows = [_mean_and_p95(name, each, counted) for name, each in _by_pose(sheet.accuracy).items()]
    title = f"AP_p, {_percent(sheet.load)}"
    return table(f"ap{100 * sheet.load:.0f}", title, _SPREAD, rows, "with the commanded frames")


def _fitted(predicted: PredictedRobots) -> Section:
    return _both_loads(
        predicted,
        "fitted",
        "AP_p with best-fit frames",
        [sheet.fitted for sheet in predicted.loads],
        "after the least-squares fit of each robot's base frame (six parameters) to its five "
        "barycentres (15 coordinates)",
    )


def _repeatability(predicted: PredictedRobots, sheet: LoadSheet) -> Section:
    note = (
        "every joint arrives from one side, as in the standard's cycle. Scatter from visit to "
        "visit as described by the parts "
        "(encoders, bearings, backlash that no load closes). Neglected: wear, temperature "
        "where none is stated, control, the floor"
    )
    if sheet.repeatability.max() >= NO_SCATTER:
        note += (
            f". Expected for normal scatter of the same covariance: {_each(sheet.expected)} at "
            f"P1 to P5 with {predicted.cycles} visits, "
            f"{_each(sheet.limit)} with many visits"
        )
    counted = _counted(predicted)
    rows = [
        _mean_and_p95(name, each, counted, scatter=True)
        for name, each in _by_pose(sheet.repeatability).items()
    ]
    title = f"RP_l, {ISO_CYCLE}, {_percent(sheet.load)}"
    return table(f"rp{100 * sheet.load:.0f}", title, _SPREAD, rows, note)


def _each(values: Floats) -> str:
    return ", ".join(str(length(float(x))) for x in values)


def _either_side(predicted: PredictedRobots) -> Section:
    return _both_loads(
        predicted,
        "either",
        f"RP_l, {ANY_APPROACH}",
        [sheet.random_approach for sheet in predicted.loads],
        "not the standard's cycle: joints arrive from either side at random, so all backlash that "
        "no load closes counts",
        scatter=True,
    )


def _by_axis(predicted: PredictedRobots) -> list[Section]:
    sheet, counted = predicted.loads[0], _counted(predicted)
    accurate, repeats = [], []
    for k, name in enumerate(NAMES):
        for axis, letter in enumerate(_AXES):
            angle, label = letter in "abc", f"{letter}-{name}"
            average = (sheet.turn if angle else sheet.barycentre)[k, :, axis % 3]
            accurate.append(_mean_and_p95(label, average, counted, angle=angle, signed=True))
            if angle:
                spread = sheet.scatter[k, :, axis % 3]
                repeats.append(_mean_and_p95(label, spread, counted, angle=True, scatter=True))
    note = "signed mean; 95th percentile of the magnitude"
    return [
        table(
            "axes",
            "AP by axis",
            _SPREAD,
            accurate,
            f"AP_x, AP_y, AP_z, AP_a, AP_b, AP_c: {note}",
        ),
        table(
            "turns",
            f"RP of the orientation, {ISO_CYCLE}",
            _SPREAD,
            repeats,
            "RP_a, RP_b, RP_c: ± 3 s",
        ),
    ]


def _axes_of_makers(predicted: PredictedRobots) -> Section:
    counted = f"{several(predicted.robots, 'robot')} x {APPROACHES} approaches from each side"
    rows = [
        _mean_and_p95(
            f"{each.axis}, {name}", values, counted, angle=each.turns, scatter=name == REPEATABILITY
        )
        for each in predicted.axes
        for name, values in each.stated.items()
    ]
    travels = []
    for each in predicted.axes:
        unit, factor = ("deg", math.degrees(1)) if each.turns else ("mm", 1e3)
        low, high = (stated_text(factor * end) for end in each.travel.tolist())
        travels.append(f"{each.axis} {low} … {high} {unit}")
    note = (
        "by ISO 230-2:2014, as makers of positioners state it: one axis moves at a time, through "
        f"P1; {POSITIONS} positions, the outer ones a tenth of the travel from its ends. "
        "Unidirectional repeatability is 4 s, which makers print as ± 2 s; reversal is the "
        "difference of the means from the two sides; accuracy is the range of mean ± 2 s of all "
        f"positions and both sides. Travel from P1: {'; '.join(travels)}"
    )
    return table("positioning", "Positioning by axis", _SPREAD, rows, note)


def _sides(predicted: PredictedRobots) -> Section:
    counted = f"{_counted(predicted)} from each side"
    rows = [
        _mean_and_p95(
            load_label(NAMES[k], sheet.load, predicted.loads), sheet.multi_directional[row], counted
        )
        for row, k in enumerate(FROM_THREE_SIDES)
        for sheet in predicted.loads
    ]
    return table(
        "vap",
        "vAP_p, from three sides",
        _SPREAD,
        rows,
        "approached along the base's x, y and z from a tenth of the cube's side away; joints "
        "at rest keep the direction of the cycle. "
        "Backlash of a joint that arrives from the same side all three times has no effect on "
        "vAP_p",
    )


def _distance(predicted: PredictedRobots) -> Section:
    counted = _counted(predicted)
    ends = f"{NAMES[DISTANCE[0]]}-{NAMES[DISTANCE[1]]}"
    rows = [
        _mean_and_p95(
            load_label(f"{name}, {ends}", sheet.load, predicted.loads),
            sheet.distance[k],
            counted,
            signed=name == "AD_p",
            scatter=name == "RD",
        )
        for k, name in enumerate(("AD_p", "RD"))
        for sheet in predicted.loads
    ]
    return table(
        "distance",
        "Distance AD_p, RD",
        _SPREAD,
        rows,
        "AD_p is signed, positive for too long a distance; 95th percentile of its magnitude. RD "
        "is ± 3 s",
    )


def _path(predicted: PredictedRobots) -> Section:
    counted = (
        f"{several(predicted.robots, 'robot')} x {several(predicted.path_cycles, 'cycle')} x "
        f"{several(predicted.path_points, 'point')}"
    )
    a, b = (predicted.cube.poses[k, :3, 3] for k in predicted.path_ends)
    start, end = (NAMES[k] for k in predicted.path_ends)
    rows = [
        _mean_and_p95(
            load_label(word, sheet.load, predicted.loads),
            sheet.path[k],
            counted,
            angle=word[-1] in "abc",
            scatter=word.startswith("RT"),
        )
        for k, word in enumerate(PATH_FIGURES)
        for sheet in predicted.loads
    ]
    rows += [
        _mean_and_p95(
            load_label("reversal error", sheet.load, predicted.loads), sheet.path_reversal, counted
        )
        for sheet in predicted.loads
    ]
    worst = (
        float(predicted.loads[0].path_profile[0, :, 0].argmax())
        / (predicted.path_points - 1)
        * float(np.linalg.norm(b - a))
    )
    return table(
        "path",
        f"Path AT_p, RT_p, {start}-{end}",
        _SPREAD,
        rows,
        "straight line, in planes normal to it, each figure at its worst point; AT_a, AT_b, "
        "AT_c as magnitudes. Mean AT_p is largest "
        f"{length(worst)} from {start}; RT_p of {predicted.path_cycles} cycles "
        "at the worst of many points is larger than at one. Reversal error: largest distance "
        "between the line followed in either direction, by the sides of the joints",
    )


def _drift(predicted: PredictedRobots, drifted: Drift) -> Section:
    warm, hours = drifted.warm_up, drifted.time[-1] / 3600
    shift = length(float(np.linalg.norm(drifted.shift[-1])))
    counted = f"{several(predicted.robots, 'robot')}, {hours:.0f} h"
    return table(
        "drift",
        "Drift dAP_p",
        _SPREAD,
        [
            _mean_and_p95("dAP_p, P1", drifted.largest, counted),
            ("displacement, P1", shift, shift),
        ],
        f"dAP_p is the largest change of AP_p within {hours:.0f} h; the displacement is that "
        "of the barycentre at the end, the same for all robots. "
        f"Assumed: temperature rise of all links {warm.rise:g} K, time constant "
        f"{warm.time_constant / 60:.0f} min, thermal expansion "
        f"{warm.expansion * 1e6:g}e-6 per K; no expansion of base, drives and bearings; no "
        "compensation by the controller",
    )


def _check(predicted: PredictedRobots) -> Section:
    check = predicted.check
    largest = length(check.largest, samples=several(check.samples, "visit"))
    return table(
        "check",
        "First order against exact",
        ("value",),
        [("largest difference", largest), ("mean difference", length(check.mean))],
        "sum of small errors against their exact composition, on a sample: "
        f"{judged(check, check.length)}",
    )
