"""Tables of the predicted robots: test cube, pose, distance and path characteristics, drift."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.analyses.iso9283.comparison import over_robots
from lostmotion.analyses.iso9283.tables.labels import (
    NO_SCATTER,
    estimate_figure,
    load_label,
    scatter_figure,
)
from lostmotion.error_model.arrival import ANY_APPROACH, ISO_CYCLE
from lostmotion.laws.iso9283 import PATH_FIGURES
from lostmotion.propagation.iso9283.cube import NAMES
from lostmotion.propagation.iso9283.robots import DISTANCE, FROM_THREE_SIDES
from lostmotion.reporting.first_order import judged
from lostmotion.reporting.joint_values import joint_values
from lostmotion.reporting.sheet import Cell, Row, Section, length, several

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.mechanism.warm_up import Drift
    from lostmotion.propagation.iso9283.robots import LoadSheet, PredictedRobots
    from lostmotion.spatial import Floats

_AXES: Final = ("x", "y", "z", "a", "b", "c")
_MEAN: Final = "mean"
_P95: Final = "95th percentile"


def predicted_sections(found: PredictedRobots, drifted: Drift | None) -> list[Section]:
    """Return the tables of the predicted robots, in reading order."""
    return [
        _cube(found),
        _poses(found),
        *(_accuracy(found, sheet) for sheet in found.loads),
        _fitted(found),
        *(_repeatability(found, sheet) for sheet in found.loads),
        _either_side(found),
        *_by_axis(found),
        _sides(found),
        _distance(found),
        _path(found),
        *([] if drifted is None else [_drift(found, drifted)]),
        _check(found),
    ]


def _counted(found: PredictedRobots) -> str:
    return f"{several(found.robots, 'robot')} x {several(found.cycles, 'visit')}"


def _percent(load: float) -> str:
    return f"{100 * load:.0f} % of the payload"


def _cube(found: PredictedRobots) -> Section:
    cube = found.cube
    steps = (
        "" if math.isnan(cube.resolution) else f"last search step {cube.resolution * 1e3:.0f} mm"
    )
    rows = [Row("side", (length(cube.side, stated=True),), steps)]
    rows += [Row(f"centre {axis}", (_place(cube.centre[k]),)) for k, axis in enumerate("xyz")]
    rows.append(
        Row(
            "points reached",
            (Cell(cube.checked, "1"),),
            "poses, corners and a grid, by inverse kinematics within the joint limits",
        )
    )
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
    return Section("cube", "Test cube", ("value",), tuple(rows), note)


def _place(value: float) -> Cell:
    """Return a coordinate in mm, without negative zero."""
    return Cell(round(float(value), 8) + 0.0, "mm", stated=True)


def _poses(found: PredictedRobots) -> Section:
    rows = []
    for k, name in enumerate(NAMES):
        joints = joint_values(found.arm, found.cube.q[k] + 0.0)  # without negative zero
        signs = "".join("+" if sign > 0 else "-" for sign in found.approach[k])
        rows.append(
            Row(
                name,
                tuple(_place(x) for x in found.cube.poses[k, :3, 3]),
                f"{joints}; direction of arrival {signs}",
            )
        )
    note = (
        "plane C1-C2-C7-C8, a tenth of the diagonal from its corners; visited in the order "
        "P5, P4, P3, P2, P1. Each joint moves monotonically from "
        "pose to pose, so it arrives from the same side in every cycle: + increasing, - decreasing"
    )
    return Section("poses", "The five poses", ("x", "y", "z"), tuple(rows), note)


def _rows(
    values: Floats, counted: str, shown: Callable[..., Cell] = estimate_figure
) -> tuple[Row, ...]:
    """Return a row for each pose of values (pose, robot), and one for each robot's worst pose."""
    spreads = [(name, over_robots(values[k])) for k, name in enumerate(NAMES)]
    spreads.append(("worst", over_robots(values.max(axis=0))))
    return tuple(
        Row(name, (shown(spread.mean, counted), shown(spread.high, counted)))
        for name, spread in spreads
    )


def _both_loads(
    found: PredictedRobots,
    values: tuple[Floats, ...],
    shown: Callable[..., Cell] = estimate_figure,
) -> tuple[tuple[str, ...], tuple[Row, ...]]:
    """Return columns and rows of the 95th percentile over robots of values (pose, robot), one
    column for each load.
    """
    counted = _counted(found)
    columns = tuple(f"{_P95}, {100 * sheet.load:.0f} % load" for sheet in found.loads)
    rows = [
        Row(name, tuple(shown(over_robots(each[k]).high, counted) for each in values))
        for k, name in enumerate(NAMES)
    ]
    rows.append(
        Row("worst", tuple(shown(over_robots(each.max(axis=0)).high, counted) for each in values))
    )
    return columns, tuple(rows)


def _accuracy(found: PredictedRobots, sheet: LoadSheet) -> Section:
    title = f"AP_p, {_percent(sheet.load)}"
    return Section(
        f"ap{100 * sheet.load:.0f}",
        title,
        (_MEAN, _P95),
        _rows(sheet.accuracy, _counted(found)),
        "with the commanded frames",
    )


def _fitted(found: PredictedRobots) -> Section:
    columns, rows = _both_loads(found, tuple(sheet.fitted for sheet in found.loads))
    note = (
        "after the least-squares fit of each robot's base frame (six parameters) to its five "
        "barycentres (15 coordinates)"
    )
    return Section("fitted", "AP_p with best-fit frames", columns, rows, note)


def _repeatability(found: PredictedRobots, sheet: LoadSheet) -> Section:
    note = (
        "every joint arrives from one side, as in the standard's cycle. Scatter from visit to "
        "visit as described by the parts "
        "(encoders, bearings, backlash that no load closes). Neglected: wear, temperature "
        "where none is stated, control, the floor"
    )
    if sheet.repeatability.max() >= NO_SCATTER:
        note += (
            f". Expected for normal scatter of the same covariance: {_each(sheet.expected)} at "
            f"P1 to P5 with {found.cycles} visits, "
            f"{_each(sheet.limit)} with many visits"
        )
    title = f"RP_l, {ISO_CYCLE}, {_percent(sheet.load)}"
    return Section(
        f"rp{100 * sheet.load:.0f}",
        title,
        (_MEAN, _P95),
        _rows(sheet.repeatability, _counted(found), scatter_figure),
        note,
    )


def _each(values: Floats) -> str:
    return ", ".join(str(length(float(x))) for x in values)


def _either_side(found: PredictedRobots) -> Section:
    columns, rows = _both_loads(
        found, tuple(sheet.random_approach for sheet in found.loads), scatter_figure
    )
    note = (
        "not the standard's cycle: joints arrive from either side at random, so all backlash that "
        "no load closes counts"
    )
    return Section("either", f"RP_l, {ANY_APPROACH}", columns, rows, note)


def _by_axis(found: PredictedRobots) -> list[Section]:
    sheet, counted = found.loads[0], _counted(found)
    accurate, repeats = [], []
    for k, name in enumerate(NAMES):
        for axis, letter in enumerate(_AXES):
            angle = axis >= 3  # noqa: PLR2004 - shifts come first here
            average = (sheet.turn if angle else sheet.barycentre)[k, :, axis % 3]
            figures = over_robots(average, signed=True).mean, over_robots(np.abs(average)).high
            accurate.append(
                Row(
                    f"{letter}-{name}",
                    tuple(estimate_figure(each, counted, angle=angle) for each in figures),
                )
            )
            if angle:
                spread = over_robots(sheet.scatter[k, :, axis % 3])
                repeats.append(
                    Row(
                        f"{letter}-{name}",
                        tuple(
                            scatter_figure(each, counted, angle=True)
                            for each in (spread.mean, spread.high)
                        ),
                    )
                )
    note = "signed mean; 95th percentile of the magnitude"
    return [
        Section(
            "axes",
            "AP by axis",
            (_MEAN, _P95),
            tuple(accurate),
            f"AP_x, AP_y, AP_z, AP_a, AP_b, AP_c: {note}",
        ),
        Section(
            "turns",
            f"RP of the orientation, {ISO_CYCLE}",
            (_MEAN, _P95),
            tuple(repeats),
            "RP_a, RP_b, RP_c: ± 3 s",
        ),
    ]


def _sides(found: PredictedRobots) -> Section:
    counted = f"{_counted(found)} from each side"
    rows = []
    for row, k in enumerate(FROM_THREE_SIDES):
        for sheet in found.loads:
            spread = over_robots(sheet.multi_directional[row])
            rows.append(
                Row(
                    load_label(NAMES[k], sheet.load, found.loads),
                    (estimate_figure(spread.mean, counted), estimate_figure(spread.high, counted)),
                )
            )
    note = (
        "approached along the base's x, y and z from a tenth of the cube's side away; joints "
        "at rest keep the direction of the cycle. "
        "Backlash of a joint that arrives from the same side all three times has no effect on vAP_p"
    )
    return Section("vap", "vAP_p, from three sides", (_MEAN, _P95), tuple(rows), note)


def _distance(found: PredictedRobots) -> Section:
    counted = _counted(found)
    ends = f"{NAMES[DISTANCE[0]]}-{NAMES[DISTANCE[1]]}"
    rows = []
    for k, name in enumerate(("AD_p", "RD")):
        for sheet in found.loads:
            values = sheet.distance[k]
            shown = estimate_figure if name == "AD_p" else scatter_figure
            figures = (
                shown(over_robots(values, signed=name == "AD_p").mean, counted),
                shown(over_robots(np.abs(values)).high, counted),
            )
            rows.append(Row(load_label(f"{name}, {ends}", sheet.load, found.loads), figures))
    note = (
        "AD_p is signed, positive for too long a distance; 95th percentile of its magnitude. RD "
        "is ± 3 s"
    )
    return Section("distance", "Distance AD_p, RD", (_MEAN, _P95), tuple(rows), note)


def _path(found: PredictedRobots) -> Section:
    counted = (
        f"{several(found.robots, 'robot')} x {several(found.path_cycles, 'cycle')} x "
        f"{several(found.path_points, 'point')}"
    )
    ends = "-".join(NAMES[k] for k in found.path_ends)
    a, b = (found.cube.poses[k, :3, 3] for k in found.path_ends)
    rows = []
    for k, word in enumerate(PATH_FIGURES):
        for sheet in found.loads:
            spread = over_robots(sheet.path[k])
            shown = scatter_figure if word.startswith("RT") else estimate_figure
            figures = tuple(
                shown(each, counted, angle=word[-1] in "abc") for each in (spread.mean, spread.high)
            )
            rows.append(Row(load_label(word, sheet.load, found.loads), figures))
    worst = (
        float(found.loads[0].path_profile[0, :, 0].argmax())
        / (found.path_points - 1)
        * float(np.linalg.norm(b - a))
    )
    note = (
        "straight line, in planes normal to it, each figure at its worst point; AT_a, AT_b, "
        "AT_c as magnitudes. Mean AT_p is largest "
        f"{length(worst)} from {NAMES[found.path_ends[0]]}; RT_p of {found.path_cycles} cycles "
        "at the worst of many points is larger than at one"
    )
    return Section("path", f"Path AT_p, RT_p, {ends}", (_MEAN, _P95), tuple(rows), note)


def _drift(found: PredictedRobots, drifted: Drift) -> Section:
    warm, spread = drifted.warm_up, over_robots(drifted.largest)
    hours = drifted.time[-1] / 3600
    counted = f"{several(found.robots, 'robot')}, {hours:.0f} h"
    rows = (
        Row(
            "dAP_p, P1",
            (estimate_figure(spread.mean, counted), estimate_figure(spread.high, counted)),
        ),
        Row("displacement, P1", (length(float(np.linalg.norm(drifted.shift[-1]))),) * 2),
    )
    note = (
        f"dAP_p is the largest change of AP_p within {hours:.0f} h; the displacement is that "
        "of the barycentre at the end, the same for all robots. "
        f"Assumed: temperature rise of all links {warm.rise:g} K, time constant "
        f"{warm.time_constant / 60:.0f} min, thermal expansion "
        f"{warm.expansion * 1e6:g}e-6 per K; no expansion of base, drives and bearings; no "
        "compensation by the controller"
    )
    return Section("drift", "Drift dAP_p", (_MEAN, _P95), rows, note)


def _check(found: PredictedRobots) -> Section:
    check = found.check
    rows = (
        Row(
            "largest difference", (length(check.largest, samples=several(check.samples, "visit")),)
        ),
        Row("mean difference", (length(check.mean),)),
    )
    note = (
        "sum of small errors against their exact composition, on a sample: "
        f"{judged(check, check.length)}"
    )
    return Section("check", "First order against exact", ("value",), rows, note)
