"""The figures of an ISO 9283 sheet: test cube, accuracy and repeatability of poses, distances and a path, and drift, over robots built."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.iso9283.comparison import over_robots
from lostmotion.analyses.iso9283.cube import NAMES
from lostmotion.analyses.iso9283.paths import PATH_FIGURES
from lostmotion.analyses.iso9283.predicted import DISTANCE, FROM_THREE_SIDES
from lostmotion.analyses.iso9283.tables.labels import NO_SCATTER, estimate_figure, load_label, scatter_figure
from lostmotion.error_model.provenance import states
from lostmotion.error_model.upper_limits import with_limits
from lostmotion.reporting.first_order import checked, failure, judged
from lostmotion.reporting.provenance import provenance_facts, provenance_sections
from lostmotion.reporting.sheet import Figure, Row, Section, Sheet, length
from lostmotion.reporting.warnings import arm_warnings

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.analyses.iso9283.comparison import ComparedFigure
    from lostmotion.analyses.iso9283.measured import MeasuredRobot
    from lostmotion.analyses.iso9283.predicted import LoadSheet, PredictedRobots
    from lostmotion.analyses.iso9283.warm_up import Drift
    from lostmotion.reporting.sheet import Card
    from lostmotion.spatial import Floats

_AXES: Final = ("x", "y", "z", "a", "b", "c")
# Robots, of which less than three lie above the 95 %.
_FEW: Final = 60
_MEAN, _MOST = "mean", "95th percentile"
_WORDS: Final = (
    (
        "predicted, never certified",
        "what the definitions of ISO 9283:1998 give for robots built to this design; a certificate needs the robot and the standard's text.",
    ),
    ("AP_p", "pose accuracy: how far the barycentre, the average of a robot's visits, lies from the commanded point (7.2.1)."),
    (
        "best-fit frames",
        "what is left of AP_p once base frame (and tool frame, where orientations were measured) are set as well as can be.",
    ),
    ("RP_l", "pose repeatability: mean distance of the visits from their barycentre plus three standard deviations of it (7.2.2)."),
    (
        "thirty visits",
        "RP_l of 30 visits is a sample: of a round normal scatter, 3.536 sigma on the average, 3.616 with many visits, 0.329 up or down by chance.",
    ),
    (
        "none described",
        "nothing that is described varies from visit to visit there: no repeatability is predicted, which does not mean that it is zero.",
    ),
    ("from either side", "RP_l if joints arrived from either side at random: play that the standard's cycle keeps on one side then shows in full."),
    (
        "mean, 95th percentile",
        "over the robots built: their average, and what 95 % of them stay below. Under the full payload where no load is said.",
    ),
    ("worst", "the worst of the five poses, of each robot by itself."),
    ("a, b, c", "turns about the base's x, y, z axes."),
    (
        "vAP_p",
        "multi-directional accuracy: how far barycentres lie apart when a pose is approached along the base's x, y and z (7.2.3). Mostly play.",
    ),
    ("AD_p, RD", "accuracy and repeatability of the distance between P2 and P4 (7.3)."),
    (
        "AT_p, RT_p",
        "accuracy and repeatability of a path, across it, at its worst point (8.2, 8.3); AT_a to RT_c of its orientation. Predicted without speed.",
    ),
    ("100 %, 10 %", "shares of the payload that the tool carries."),
    ("interval", "95 % confidence; it counts robots. A question mark: too few of them to tell."),
)


def iso_sheet(
    predicted: PredictedRobots | None,
    drifted: Drift | None,
    measured: MeasuredRobot | None,
    compared: list[ComparedFigure],
    notes: tuple[str, ...] = (),
) -> Sheet:
    """What is there to say by ISO 9283 of an arm, predicted, measured or both?"""
    from lostmotion.analyses.iso9283.tables.headline import predicted_cards, predicted_verdict
    from lostmotion.analyses.iso9283.tables.measured import (
        compared_section,
        doubts,
        duplicates_note,
        left_out,
        measured_cards,
        measured_facts,
        measured_sections,
        measured_verdict,
        visited,
    )

    sections: list[Section] = []
    cards: list[Card] = []
    verdict: list[str] = []
    facts: dict[str, Any] = {}
    counted: list[str] = []
    about: tuple[Section, ...] = ()
    name = "Measured robot"
    if predicted is not None:
        sections += _predicted(predicted, drifted)
        known = with_limits(states(predicted.arm), predicted.arm, predicted.cube.q, predicted.approach)
        # Limits count in the scatter from either side that do not in that from one side.
        either = with_limits(states(predicted.arm), predicted.arm, predicted.cube.q)
        cards += predicted_cards(predicted, known, either)
        verdict.append(predicted_verdict(predicted, known, either))
        facts |= {**_facts(predicted), **provenance_facts(known)}
        about = provenance_sections(known)
        counted.append(f"{predicted.robots} robots x {predicted.cycles} cycles x 5 poses, seed {predicted.seed}")
        failed = failure(predicted.check, predicted.check.length)
        name, notes = (
            predicted.arm.name,
            (*([failed] if failed and measured is not None else []), *predicted.arm.remarks, *_remarks(predicted), *notes),
        )
    if measured is not None:
        sections += [*compared_section(compared), *measured_sections(measured)]
        cards += measured_cards(measured, compared)
        verdict.append(measured_verdict(measured, compared))
        facts |= measured_facts(measured, compared)
        notes = (*doubts(measured, predicted), *left_out(measured, predicted if compared else None), *notes)
        if measured.visits.duplicates:
            notes = (*notes, duplicates_note(measured.visits))
        counted.append(visited(measured))
    said = Sheet(
        name=name,
        subject="ISO 9283 sheet",
        verdict=" ".join(verdict),
        cards=tuple(cards),
        sections=(*sections, *about),
        counts="; ".join(counted),
        warnings=() if predicted is None else arm_warnings(predicted.arm),
        notes=notes,
        words=_WORDS,
        source=f"{'; '.join(counted)}. The same files, version and seed give the same bytes.",
        seed=None if predicted is None else predicted.seed,
        facts=facts,
    )
    return said if predicted is None or measured is not None else checked(said, predicted.check, predicted.check.length)


def _predicted(found: PredictedRobots, drifted: Drift | None) -> list[Section]:
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
    return f"{found.robots} robots x {found.cycles} visits"


def _percent(load: float) -> str:
    return f"{100 * load:.0f} % of the payload"


def _cube(found: PredictedRobots) -> Section:
    cube = found.cube
    steps = "" if math.isnan(cube.resolution) else f"grown in steps down to {cube.resolution * 1e3:.0f} mm"
    rows = [Row("side", (length(cube.side, stated=True),), steps)]
    rows += [Row(f"centre {axis}", (_place(cube.centre[k]),)) for k, axis in enumerate("xyz")]
    rows.append(Row("points reached", (Figure(cube.checked, ""),), "poses, corners and a grid, by inverse kinematics within the joint limits"))
    held = "the tool is held alike all over" if cube.rotation is not None else "fewer than six joints: the tool's orientation comes as it comes"
    how = "as given" if cube.method == "given" else f"the largest found: {cube.method}; another start may find one larger by some per cent"
    return Section(
        "cube", "Test cube", ("value",), tuple(rows), f"{how}; {held}. Edges along the base's axes; no obstacle or self-collision is looked at"
    )


def _place(value: float) -> Figure:
    """Give a coordinate in mm, without what rounding leaves of zero."""
    return Figure(round(1e3 * float(value), 5) + 0.0, "mm", stated=True)


def _poses(found: PredictedRobots) -> Section:
    rows = []
    for k, name in enumerate(NAMES):
        joints = ", ".join(
            f"{joint.name} {math.degrees(value) + 0.0:.1f}°" if joint.type == "revolute" else f"{joint.name} {value * 1e3:.1f} mm"
            for joint, value in zip(found.arm.moving, found.cube.q[k], strict=True)
        )
        signs = "".join("+" if sign > 0 else "-" for sign in found.approach[k])
        rows.append(Row(name, tuple(_place(x) for x in found.cube.poses[k, :3, 3]), f"{joints}; joints arrive {signs}"))
    note = (
        "plane C1-C2-C7-C8, a tenth of the diagonal from its corners; visited as P5, P4, P3, P2, P1, joints straight from pose to pose, "
        "so that each joint arrives at a pose from one and the same side in every cycle: + rising, - falling"
    )
    return Section("poses", "The five poses", ("x", "y", "z"), tuple(rows), note)


def _rows(values: Floats, counted: str, shown: Callable[..., Figure] = estimate_figure) -> tuple[Row, ...]:
    """Give a row for each pose of values (pose, robot), and one for the worst of them in each robot."""
    spreads = [(name, over_robots(values[k])) for k, name in enumerate(NAMES)]
    spreads.append(("worst", over_robots(values.max(axis=0))))
    return tuple(Row(name, (shown(spread.mean, counted), shown(spread.high, counted))) for name, spread in spreads)


def _both_loads(
    found: PredictedRobots, values: tuple[Floats, ...], shown: Callable[..., Figure] = estimate_figure
) -> tuple[tuple[str, ...], tuple[Row, ...]]:
    """Give the columns and rows of values (pose, robot) that are told for each load beside the other, what 95 % of robots stay below."""
    counted = _counted(found)
    columns = tuple(f"{100 * sheet.load:.0f} % load, {_MOST}" for sheet in found.loads)
    rows = [Row(name, tuple(shown(over_robots(each[k]).high, counted) for each in values)) for k, name in enumerate(NAMES)]
    rows.append(Row("worst", tuple(shown(over_robots(each.max(axis=0)).high, counted) for each in values)))
    return columns, tuple(rows)


def _accuracy(found: PredictedRobots, sheet: LoadSheet) -> Section:
    title = f"AP_p, {_percent(sheet.load)}"
    return Section(f"ap{100 * sheet.load:.0f}", title, (_MEAN, _MOST), _rows(sheet.accuracy, _counted(found)), "as it is: frames as commanded")


def _fitted(found: PredictedRobots) -> Section:
    columns, rows = _both_loads(found, tuple(sheet.fitted for sheet in found.loads))
    note = "what is left once each robot's base frame fits its five barycentres best: six numbers to fifteen. The tool is held alike, or as it comes"
    return Section("fitted", "AP_p with best-fit frames", columns, rows, note)


def _repeatability(found: PredictedRobots, sheet: LoadSheet) -> Section:
    note = (
        "from one side, as the standard's cycle makes every joint arrive; what scatters from visit to visit is what the parts state "
        "(encoder, bearings, sides of play that nothing holds). Wear, warmth, control and the floor come on top"
    )
    if sheet.repeatability.max() >= NO_SCATTER:
        note += (
            f". A normal scatter of the same covariance would show {_each(sheet.expected)} at P1 to P5 on the average of sets of {found.cycles} "
            f"visits, which read low, and {_each(sheet.limit)} with more and more visits"
        )
    title = f"RP_l, {_percent(sheet.load)}"
    return Section(f"rp{100 * sheet.load:.0f}", title, (_MEAN, _MOST), _rows(sheet.repeatability, _counted(found), scatter_figure), note)


def _each(values: Floats) -> str:
    return ", ".join(str(length(float(x))) for x in values)


def _either_side(found: PredictedRobots) -> Section:
    columns, rows = _both_loads(found, tuple(sheet.random_approach for sheet in found.loads), scatter_figure)
    note = "not the standard's cycle: joints arrive from either side at random, and play that no load holds closed shows in full"
    return Section("either", "RP_l from either side", columns, rows, note)


def _by_axis(found: PredictedRobots) -> list[Section]:
    sheet, counted = found.loads[0], _counted(found)
    accurate, repeats = [], []
    for k, name in enumerate(NAMES):
        for axis, letter in enumerate(_AXES):
            angle = axis >= 3  # noqa: PLR2004 - shifts come first here
            average = (sheet.turn if angle else sheet.barycentre)[k, :, axis % 3]
            figures = over_robots(average, signed=True).mean, over_robots(np.abs(average)).high
            accurate.append(Row(f"{letter}-{name}", tuple(estimate_figure(each, counted, angle=angle) for each in figures)))
            if angle:
                spread = over_robots(sheet.scatter[k, :, axis % 3])
                repeats.append(Row(f"{letter}-{name}", tuple(scatter_figure(each, counted, angle=True) for each in (spread.mean, spread.high))))
    note = "signed mean; the 95 % are of the size"
    return [
        Section("axes", "AP by axis", (_MEAN, _MOST), tuple(accurate), f"AP_x, AP_y, AP_z, AP_a, AP_b, AP_c: {note}"),
        Section("turns", "RP of orientation", (_MEAN, _MOST), tuple(repeats), "RP_a, RP_b, RP_c: ± 3 s"),
    ]


def _sides(found: PredictedRobots) -> Section:
    counted = f"{_counted(found)} from each side"
    rows = []
    for row, k in enumerate(FROM_THREE_SIDES):
        for sheet in found.loads:
            spread = over_robots(sheet.multi_directional[row])
            rows.append(
                Row(load_label(NAMES[k], sheet.load, found.loads), (estimate_figure(spread.mean, counted), estimate_figure(spread.high, counted)))
            )
    note = (
        "approached along the base's x, y and z from a tenth of the cube's side away; joints that stand still then rest as in the cycle. "
        "Play of a joint that arrives from the same side all three times does not show: vAP_p is small then, whatever the play"
    )
    return Section("vap", "vAP_p, from three sides", (_MEAN, _MOST), tuple(rows), note)


def _distance(found: PredictedRobots) -> Section:
    counted = _counted(found)
    ends = f"{NAMES[DISTANCE[0]]}-{NAMES[DISTANCE[1]]}"
    rows = []
    for k, name in enumerate(("AD_p", "RD")):
        for sheet in found.loads:
            values = sheet.distance[k]
            shown = estimate_figure if name == "AD_p" else scatter_figure
            figures = shown(over_robots(values, signed=name == "AD_p").mean, counted), shown(over_robots(np.abs(values)).high, counted)
            rows.append(Row(load_label(f"{name}, {ends}", sheet.load, found.loads), figures))
    note = "AD_p is signed, above zero too far; its 95 % are of the size. RD is ± 3 s"
    return Section("distance", "Distance AD_p, RD", (_MEAN, _MOST), tuple(rows), note)


def _path(found: PredictedRobots) -> Section:
    counted = f"{found.robots} robots x {found.path_cycles} cycles x {found.path_points} points"
    ends = "-".join(NAMES[k] for k in found.path_ends)
    a, b = (found.cube.poses[k, :3, 3] for k in found.path_ends)
    rows = []
    for k, word in enumerate(PATH_FIGURES):
        for sheet in found.loads:
            spread = over_robots(sheet.path[k])
            shown = scatter_figure if word.startswith("RT") else estimate_figure
            figures = tuple(shown(each, counted, angle=word[-1] in "abc") for each in (spread.mean, spread.high))
            rows.append(Row(load_label(word, sheet.load, found.loads), figures))
    worst = float(found.loads[0].path_profile[0, :, 0].argmax()) / (found.path_points - 1) * float(np.linalg.norm(b - a))
    note = (
        "straight line, in the planes across it, each at the worst of its points; AT_a, AT_b, AT_c by size. AT is largest on the average "
        f"{length(worst)} from {NAMES[found.path_ends[0]]}; RT_p of {found.path_cycles} cycles at the worst of many points is larger than at one"
    )
    return Section("path", f"Path AT_p, RT_p, {ends}", (_MEAN, _MOST), tuple(rows), note)


def _drift(found: PredictedRobots, drifted: Drift) -> Section:
    warm, spread = drifted.warm_up, over_robots(drifted.largest)
    hours = drifted.time[-1] / 3600
    counted = f"{found.robots} robots, {hours:.0f} h"
    rows = (
        Row("dAP_p, P1", (estimate_figure(spread.mean, counted), estimate_figure(spread.high, counted))),
        Row("way, P1", (length(float(np.linalg.norm(drifted.shift[-1]))),) * 2),
    )
    note = (
        f"dAP_p is the largest change of AP_p within {hours:.0f} h; the way is that of the barycentre at the end, alike in all robots. Assumed: "
        f"all links warm by {warm.rise:g} K, 63 % of it in {warm.time_constant / 60:.0f} min, and grow {warm.expansion * 1e6:g}e-6 per K; "
        "base, drives and bearings stay as they are; the controller does not know"
    )
    return Section("drift", "Drift dAP_p", (_MEAN, _MOST), rows, note)


def _check(found: PredictedRobots) -> Section:
    check = found.check
    rows = (Row("largest difference", (length(check.largest, samples=f"{check.samples} visits"),)), Row("mean difference", (length(check.mean),)))
    note = f"errors are small and are added up; a sample of them composed exactly: {judged(check, check.length)}"
    return Section("check", "First order against exact", ("value",), rows, note)


def _remarks(found: PredictedRobots) -> list[str]:
    out = []
    if found.robots < _FEW:
        out.append(f"{found.robots} robots are few: what 95 % of them stay below is told by the largest one or two")
    if found.still:
        out.append(f"joints that stand still in the cycle: {', '.join(found.still)}; their play is taken to rest on one side")
    sheet = found.loads[0]
    if sheet.repeatability.max() < NO_SCATTER:
        out.append(
            "from one side nothing that is described varies from visit to visit, so no repeatability is predicted there; a real arm adds friction, "
            "control and warmth"
        )
    elif sheet.repeatability.max() < 0.1 * sheet.random_approach.max():
        out.append(
            "RP_l from one side is small because the parts state little that changes from visit to visit; a real arm adds friction, control "
            "and warmth: see 'from either side' for what its play can do"
        )
    return out


def _facts(found: PredictedRobots) -> dict[str, Any]:
    cube = found.cube
    return {
        "arm": found.arm.name,
        "robots": found.robots,
        "cycles": found.cycles,
        "seed": found.seed,
        "cube": {
            "side_m": cube.side,
            "centre_m": cube.centre.tolist(),
            "tool_rotation": None if cube.rotation is None else cube.rotation.tolist(),
            "poses_m": {name: cube.poses[k, :3, 3].tolist() for k, name in enumerate(NAMES)},
            "q": {name: cube.q[k].tolist() for k, name in enumerate(NAMES)},
            "found_by": cube.method,
        },
        "approach": {name: found.approach[k].tolist() for k, name in enumerate(NAMES)},
    }
