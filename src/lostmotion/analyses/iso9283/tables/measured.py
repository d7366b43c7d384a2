"""The figures of a measured robot by ISO 9283, alone and beside what was predicted."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.iso9283.comparison import determines_tool_frame, different_orientations, over_robots
from lostmotion.analyses.iso9283.paths import PATH_FIGURES
from lostmotion.analyses.iso9283.tables.labels import estimate_figure, load_label
from lostmotion.error_model.intervals import Estimate
from lostmotion.errors import shown
from lostmotion.reporting.sheet import Card, Figure, Row, Section, length, several

if TYPE_CHECKING:
    from lostmotion.analyses.iso9283.comparison import ComparedFigure
    from lostmotion.analyses.iso9283.measured import MeasuredLoad, MeasuredPose, MeasuredRobot
    from lostmotion.analyses.iso9283.measured_paths import MeasuredPath
    from lostmotion.analyses.iso9283.predicted import PredictedRobots
    from lostmotion.analyses.iso9283.visits import Visits

_MOST_POSES: Final = 12
_MOST_NAMED: Final = 5
# A mean AP_p or an AT_p above so many times what 95 % of robots stay below, or so much (m) where none were built, is seldom the arm's own.
_DOUBTED: Final = 10.0
_FAR: Final = 5e-3
# Of the path's figures, those of orientation.
_TURNS: Final = tuple(k for k, word in enumerate(PATH_FIGURES) if word[-1] in "abc")
_LETTERS: Final = ("a", "b", "c", "x", "y", "z")
# In reading order; the figures that stand in the table, not only in result.json.
PARTS: Final = ("AP_x", "AP_y", "AP_z", "AP_a", "AP_b", "AP_c")
SHOWN: Final = ("AP_p", "AP_p fitted", "RP_l", "RP_a", "RP_b", "RP_c", "vAP_p", "AD_p", "RD", *PATH_FIGURES)


def visited(found: MeasuredRobot) -> str:
    """Say how many visits and readings were measured."""
    along = sum(map(bool, found.visits.path))
    visits = len(found.visits.path) - along
    counted = [several(visits, "measured visit")] if visits or not along else []
    return "; ".join([*counted, *([f"{along} readings along paths"] if along else [])])


def measured_verdict(found: MeasuredRobot, compared: list[ComparedFigure]) -> str:
    """What does the measured robot show, and does it look like those predicted?"""
    said = []
    for load in found.loads:
        parts = []
        if load.pooled is not None:
            raw, fitted = load.pooled
            parts.append(f"AP_p {estimate_figure(raw[0])}, mean over {len(load.poses)} poses, {estimate_figure(fitted[0])} with best-fit frames")
        repeat = [pose.repeatability for pose in load.poses if math.isfinite(pose.repeatability.value)]
        if repeat:
            parts.append(f"RP_l up to {estimate_figure(max(repeat, key=lambda each: each.value))}")
        parts += [f"AT_p {length(path.figures[0])} and RT_p {length(path.figures[1])} along {path.name}" for path in load.paths]
        if parts:
            said.append(f"{load_label('Measured', load.load, found.loads)}: {', '.join(parts)}.")
    text = " ".join(said) or "Measured: no command and no pose visited twice, so neither accuracy nor repeatability can be told."
    shown = [each for each in compared if each.name in SHOWN]
    if shown:
        text += (
            f" {sum(each.within for each in shown)} of {len(shown)} measured figures lie within what 5 % and 95 % of the predicted robots stay below."
        )
    return text


def duplicates_note(visits: Visits) -> str:
    """Return a warning that rows of the measurement repeat others, naming the unread columns in which they differ."""
    rows = several(visits.duplicates, "row")
    note = f"{rows} of the measurement dropped: equal to another row in every column that is read"
    if visits.unread:
        columns = ", ".join(shown(name) for name in visits.unread[:_MOST_NAMED])
        more = f" and {len(visits.unread) - _MOST_NAMED} more" if len(visits.unread) > _MOST_NAMED else ""
        note += f"; they differ only in {columns}{more}, which no role is mapped to"
    return f"{note}. If they are separate visits that read the same, number them in a column 'cycle'"


def doubts(found: MeasuredRobot, predicted: PredictedRobots | None) -> tuple[str, ...]:
    """Say which measured accuracies are so bad that another frame, or other commands than the robot's, are likelier than the arm."""
    out = []
    for load in found.loads:
        known = [pose.accuracy.value for pose in load.poses if _known(pose.accuracy)]
        means = [("AP_p on the average over poses", sum(known) / len(known), 0)] if known else []
        means += [(f"AT_p along {path.name}", float(path.figures[0]), 1) for path in load.paths]
        for name, value, along in means:
            sheet = None if predicted is None else predicted.loads[0]
            usual = math.inf if sheet is None else float(over_robots(sheet.path[0] if along else sheet.accuracy.max(axis=0)).high.value)
            if value > min(_FAR, _DOUBTED * usual):
                against = "" if sheet is None else f", where 95 % of the robots predicted stay below {length(usual)}"
                out.append(
                    f"{load_label(f'measured {name} is {length(value)}', load.load, found.loads)}{against}: are the commanded positions those that "
                    "the robot was sent to, and in the frame and the units of the readings?"
                )
    return tuple(out)


def left_out(found: MeasuredRobot, predicted: PredictedRobots | None) -> tuple[str, ...]:
    """Say what was measured and is not judged, or not compared with robots predicted, and why."""
    out = []
    visits = found.visits
    turned, aimed = (np.isfinite(each).all(axis=(1, 2)) for each in (visits.orientation, visits.rotation))
    if (turned & ~aimed).any():
        out.append("orientations were measured, their commands are not stated (ac, bc, cc, or --tool-rpy): RP_a,b,c are told, AP_a,b,c are not")
    if predicted is None:
        return tuple(out)
    otherwise = {name: None for load in found.loads for name in different_orientations(predicted, load)}
    if otherwise:
        why = "" if predicted.cube.rotation is not None else ": with fewer than six joints its orientation comes as it comes"
        out.append(
            f"orientation is not compared at {', '.join(otherwise)}, where the measured tool was held otherwise than the arm predicted holds it{why}"
        )
    if predicted.cube.rotation is None and any(math.isfinite(path.figures[k]) for load in found.loads for path in load.paths for k in _TURNS):
        out.append("AT_a,b,c and RT_a,b,c are not compared: with fewer than six joints the tool's orientation along a path comes as it comes")
    if any(determines_tool_frame(load) for load in found.loads):
        out.append("AP_p with best-fit frames is not compared: the measured poses tell a tool frame too, robots predicted are fitted by a base alone")
    return tuple(out)


def measured_cards(found: MeasuredRobot, compared: list[ComparedFigure]) -> list[Card]:
    """Give the measured figures that are asked for first: those under the heaviest load."""
    out = []
    load = found.loads[0]
    quiet = f", {100 * load.load:g} % load" if len(found.loads) > 1 else ""
    repeat = [pose.repeatability for pose in load.poses if math.isfinite(pose.repeatability.value)]
    if repeat:
        out.append(Card("RP_l measured", str(estimate_figure(max(repeat, key=lambda each: each.value))), f"worst pose{quiet}"))
    if load.pooled is not None:
        out += [
            Card("AP_p measured", str(estimate_figure(load.pooled[0][0])), f"mean of {len(load.poses)} poses, as it is{quiet}"),
            Card("AP_p, best-fit frames", str(estimate_figure(load.pooled[1][0])), f"measured, mean over poses{quiet}"),
        ]
    out += [
        Card(f"{word} measured", str(length(float(load.paths[0].figures[k]))), f"{load.paths[0].name}{quiet}")
        for k, word in enumerate(PATH_FIGURES[:2])
        if load.paths
    ]
    shown = [each for each in compared if each.name in SHOWN]
    if shown:
        out.append(Card("as predicted", f"{sum(each.within for each in shown)} of {len(shown)}", "within 5-95 % of robots"))
    return out


def measured_sections(found: MeasuredRobot) -> list[Section]:
    """Give the sheet of the measured robot, each figure under its loads."""
    out = [section for load in found.loads for section in _pooled(found, load)]
    if any(math.isfinite(pose.repeatability.value) for load in found.loads for pose in load.poses):
        out += [*_poses(found), _axes(found)]
    rows = [
        Row(load_label(f"{name}, P2-P4", load.load, found.loads), (estimate_figure(load.distance[k], "cycles with both"),))
        for k, name in enumerate(("AD_p", "RD"))
        for load in found.loads
        if load.distance is not None and _known(load.distance[k])
    ]
    if rows:
        out.append(Section("measured-distance", "Measured: distance P2-P4", ("value",), tuple(rows)))
    return [*out, *_paths(found), _data(found)]


def _known(value: Estimate) -> bool:
    return math.isfinite(value.value)


def _pooled(found: MeasuredRobot, load: MeasuredLoad) -> list[Section]:
    if load.pooled is None or load.fit is None:
        return []
    counted = f"{len(load.poses)} poses"
    rows = [
        Row(name, (estimate_figure(raw, counted), estimate_figure(fitted, counted)))
        for name, raw, fitted in zip(("mean", "standard deviation", "95 % of poses below", "largest"), *load.pooled, strict=True)
    ]
    fit = load.fit
    shift = ", ".join(f"{x * 1e3:.3f}" for x in fit.base[:3, 3])
    tool = f"; tool ({', '.join(f'{x * 1e3:.3f}' for x in fit.tool)}) mm" if fit.with_tool else ""
    turn = math.degrees(math.acos(min(max((fit.base[:3, :3].trace() - 1) / 2, -1.0), 1.0)))
    note = f"best-fit base: shift ({shift}) mm, turn {turn:.4f}°{tool}; {fit.told} numbers told by the poses. "
    note += "Intervals by drawing poses again" if math.isfinite(load.pooled[0][0].low) else "Too few poses for intervals over them"
    key = "measured-accuracy" if load is found.loads[0] else f"measured-accuracy-{100 * load.load:g}"
    return [Section(key, load_label("Measured: AP_p over all poses", load.load, found.loads), ("as it is", "best-fit frames"), tuple(rows), note)]


def _in_order(found: MeasuredRobot) -> list[tuple[MeasuredLoad, MeasuredPose]]:
    """Give the poses that are shown, each under all its loads."""
    names = list(dict.fromkeys(pose.name for load in found.loads for pose in load.poses))[:_MOST_POSES]
    return [(load, pose) for name in names for load in found.loads for pose in load.poses if pose.name == name]


def _poses(found: MeasuredRobot) -> list[Section]:
    """Give a table for each characteristic: side by side they are wider than a terminal."""
    shown = _in_order(found)
    count, all_poses = len({pose.name for _, pose in shown}), len({pose.name for load in found.loads for pose in load.poses})
    first = "" if count == all_poses else f"the first {count} of {all_poses} poses"

    def label(load: MeasuredLoad, pose: MeasuredPose) -> str:
        return load_label(pose.name, load.load, found.loads)

    accurate = tuple(
        Row(label(load, pose), (estimate_figure(pose.accuracy, f"{pose.visits} visits"), estimate_figure(Estimate(pose.fitted, math.nan, math.nan))))
        for load, pose in shown
        if _known(pose.accuracy)
    )
    out = [Section("measured-poses", "Measured: AP_p", ("AP_p", "best-fit frames"), accurate, first)] if accurate else []
    with_instrument = found.visits.instrument > 0
    repeats = []
    for load, pose in shown:
        figures = (
            estimate_figure(pose.repeatability, f"{pose.visits} visits"),
            *((estimate_figure(pose.without_instrument),) if with_instrument else ()),
        )
        repeats.append(Row(label(load, pose), figures))
    note = (f"{first}; " if first else "") + (
        "the interval of RP_l is of what many visits would show, of which a sample shows a little less; normal scatter"
    )
    if with_instrument:
        floor = max(load.floor for load in found.loads)
        note += f". The instrument alone would show an RP_l of {length(floor)}; it is taken off in squares, zero where no more is left"
    columns = ("RP_l", *(("less instrument",) if with_instrument else ()))
    out.append(Section("measured-repeatability", "Measured: RP_l", columns, tuple(repeats), note))
    sides = tuple(Row(label(load, pose), (estimate_figure(pose.multi_directional),)) for load, pose in shown if _known(pose.multi_directional))
    return [*out, *([Section("measured-sides", "Measured: vAP_p, from three sides", ("vAP_p",), sides, first)] if sides else [])]


def _axes(found: MeasuredRobot) -> Section:
    rows = []
    for load, pose in _in_order(found):
        for letter, average, scatter in zip(_LETTERS, pose.axes, pose.scatter, strict=True):
            if _known(scatter):
                angle = letter in "abc"
                label = load_label(f"{pose.name}-{letter}", load.load, found.loads)
                rows.append(Row(label, (estimate_figure(average, angle=angle), estimate_figure(scatter, angle=angle))))
    return Section("measured-axes", "Measured: by axis", ("AP", "± 3 s"), tuple(rows), "intervals by Student's law and by chi-square")


def _paths(found: MeasuredRobot) -> list[Section]:
    rows = []
    paths = [path for load in found.loads for path in load.paths]
    for name in dict.fromkeys(path.name for path in paths):
        for k, word in enumerate(PATH_FIGURES):
            for load in found.loads:
                for path in (path for path in load.paths if path.name == name and math.isfinite(path.figures[k])):
                    counted = f"{path.cycles} cycles x {len(path.places)} {'places' if path.shared else 'planes'}"
                    label = load_label(f"{word}, {name}", load.load, found.loads)
                    value = Estimate(float(path.figures[k]), math.nan, math.nan)
                    shown = (estimate_figure(each, counted, angle=word[-1] in "abc") for each in (value, path.many[k]))
                    rows.append(Row(label, (*shown, Figure(float(path.worst[k]) * 1e3, "mm"))))
    if not rows:
        return []
    note = (
        "value: of these cycles, as the standard defines it, at the worst place, with how far from the path's start that stands. Many cycles: "
        "estimate of what very many would show, and its 95 % interval, for a normal scatter. The worst of several places of few cycles reads high, "
        "so the value may lie outside; the interval covers less where a single place scatters more. "
    ) + _where_read(paths)
    if found.visits.instrument:
        note += f". The instrument alone would show an RT_p of about {length(max(path.floor for path in paths))}"
    read = tuple(
        Row(
            load_label(path.name, load.load, found.loads),
            (
                Figure(path.readings, ""),
                Figure(float(path.places[0]) * 1e3, "mm"),
                length(float(path.places[-1])),
                length(path.length, stated=True),
                length(path.gap),
                length(path.missed),
            ),
        )
        for load in found.loads
        for path in load.paths
    )
    columns = ("readings", "from", "to", "of", "gap", "missed")
    between = (
        "from, to: where all cycles were read, of the path's length. Gap: largest distance of neighbouring readings along the path. Missed: by how "
        "much the straight line between its neighbours passes a reading by, root mean square: noise, and some four times what is lost between "
        "readings where the way bends. Where it exceeds RT_p, read the path more densely"
    )
    return [
        Section("measured-path", "Measured: path AT_p, RT_p", ("value", "many cycles", "worst at"), tuple(rows), note),
        Section("measured-path-data", "Measured: how the path was read", columns, read, between),
    ]


def _where_read(paths: list[MeasuredPath]) -> str:
    """Say at which places the cycles are compared."""
    said = []
    for shared in (True, False):
        if names := dict.fromkeys(path.name for path in paths if path.shared is shared):
            counts = sorted({len(path.places) for path in paths if path.shared is shared})
            many = str(counts[0]) if len(counts) == 1 else f"{counts[0]} to {counts[-1]}"
            along = "" if len({path.shared for path in paths}) == 1 else f" along {', '.join(names)}"
            how = (
                f"All cycles were read at the same {many} places, and the figures are those of the readings there"
                if shared
                else f"The cycles were read at different places: each one's nearest reading is moved to {many} evenly spaced planes by as much as "
                "the other cycles change on the way there. RT is within 3 % of that of readings at shared places, unless the path bends between them"
            )
            said.append(how.replace("read at", f"read{along} at", 1))
    return ". ".join(said)


def _data(found: MeasuredRobot) -> Section:
    visits = found.visits
    along = sum(map(bool, visits.path))
    rows = [Row("visits", (Figure(len(visits.path) - along, ""),), visits.source)]
    if along:
        rows.append(Row("readings along paths", (Figure(along, ""),)))
    if visits.load_stated:
        counted = ((load.load, int((visits.load == load.load).sum())) for load in found.loads)
        rows += [Row(f"rows at {100 * load:g} % load", (Figure(count, ""),)) for load, count in counted]
    rows += [
        Row("duplicate rows dropped", (Figure(visits.duplicates, ""),), "equal in every column that is read" if visits.duplicates else ""),
        Row("poses", (Figure(len({name for name in visits.pose if name}), ""),)),
    ]
    if visits.instrument:
        rows.append(Row("instrument", (length(visits.instrument, stated=True),), "standard deviation of one reading of a coordinate, as stated"))
    note = "" if visits.load_stated else "the load is not stated: taken as the full payload"
    return Section("measured-data", "Measured: the data", ("value",), tuple(rows), note)


def compared_section(compared: list[ComparedFigure]) -> list[Section]:
    """Give predicted and measured side by side, load by load: characteristics, and the parts of AP along and about the axes."""
    columns = ("5th percentile", "95th percentile", "measured")
    loads = sorted({each.load for each in compared}, reverse=True)
    out = []
    for load in loads:
        key = "" if load == loads[0] else f"-{100 * load:g}"
        rows, parts = (_side_by_side([each for each in compared if each.load == load], names) for names in (SHOWN, PARTS))
        if rows:
            note = (
                f"over robots built, at {100 * load:g} % of the payload, visited and run as often, read with the instrument stated. High: above what "
                f"95 % of them stay below; low: below what 5 % do; all else, {_within(rows)}, lies within. Of a robot like them one in ten does not"
            )
            out.append(Section(f"compared{key}", load_label("Predicted and measured", load, loads), columns, rows, note))
        if parts:
            note = (
                "AP_x, AP_y, AP_z along, AP_a, AP_b, AP_c about the base's axes, as it is: what the measured base or tool frame is off counts in "
                f"full. Signed, and judged so; {_within(parts)} lie within"
            )
            out.append(Section(f"compared-axes{key}", load_label("Predicted and measured: AP by axis", load, loads), columns, parts, note))
    return out


def _within(rows: tuple[Row, ...]) -> str:
    return f"{sum(not row.note for row in rows)} of {len(rows)}"


def _side_by_side(compared: list[ComparedFigure], names: tuple[str, ...]) -> tuple[Row, ...]:
    """Give a row for each of these figures, with a word where the measured robot lies outside."""
    rows = []
    for each in (each for name in names for each in compared if each.name == name):
        low, high, value = (estimate_figure(figure, angle=each.angle) for figure in (each.predicted.low, each.predicted.high, each.measured))
        plain = (Figure(figure.value, figure.unit) for figure in (low, high))
        word = "" if each.within else "high" if each.measured.value > each.predicted.high.value else "low"
        rows.append(Row(f"{each.name}, {each.pose}", (*plain, value), word))
    return tuple(rows)


def measured_facts(found: MeasuredRobot, compared: list[ComparedFigure]) -> dict[str, Any]:
    """Give what result.json tells of the measurement besides."""
    visits = found.visits
    return {
        "measured": {
            "source": visits.source,
            "visits": len(visits.path) - sum(map(bool, visits.path)),
            "readings_along_paths": sum(map(bool, visits.path)),
            "duplicates": visits.duplicates,
            "unread_columns_that_differ": list(visits.unread),
            "instrument_m": visits.instrument,
            "load_stated": visits.load_stated,
            "loads": [_load_facts(load) for load in found.loads],
        },
        "compared": [
            {
                "figure": each.name,
                "pose": each.pose,
                "load": each.load,
                "unit": "rad" if each.angle else "m",
                "predicted_5": each.predicted.low.value,
                "predicted_mean": each.predicted.mean.value,
                "predicted_95": each.predicted.high.value,
                "measured": each.measured.value,
                "within": bool(each.within),
            }
            for each in compared
        ],
    }


def _load_facts(load: MeasuredLoad) -> dict[str, Any]:
    return {
        "load": load.load,
        "base_fit": None if load.fit is None else load.fit.base.tolist(),
        "tool_fit_m": None if load.fit is None else load.fit.tool.tolist(),
        "paths": [
            {
                "path": path.name,
                "ends_m": path.ends.tolist(),
                "cycles": path.cycles,
                "readings": path.readings,
                "largest_gap_m": path.gap,
                "missed_between_m": path.missed,
                "planes_m": path.places.tolist(),
                "places_shared": path.shared,
                **{
                    word: {"value": float(value), "many_cycles": _value(each), "interval": _ends(each), "worst_at_m": float(at)}
                    for word, value, each, at in zip(PATH_FIGURES, path.figures, path.many, path.worst, strict=True)
                    if math.isfinite(value)
                },
            }
            for path in load.paths
        ],
    }


def _value(estimate: Estimate) -> float | None:
    return estimate.value if math.isfinite(estimate.value) else None


def _ends(value: Estimate) -> list[float] | None:
    return [value.low, value.high] if math.isfinite(value.low) else None
