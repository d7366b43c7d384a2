"""Tables of a measured robot by ISO 9283."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from lostmotion.analyses.iso9283.page.labels import (
    accuracy_key,
    estimate_figure,
    load_label,
    measured_label,
)
from lostmotion.analyses.iso9283.page.measured_figures import (
    positioning_facts,
    positioning_sections,
)
from lostmotion.error_model.intervals import Estimate
from lostmotion.laws.iso9283 import PATH_FIGURES
from lostmotion.reporting.sheet import Cell, length, several, table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.reporting.sheet import Section
    from lostmotion.standards.comparison import ComparedFigure
    from lostmotion.standards.measured_paths import MeasuredPath
    from lostmotion.standards.measured_robot import MeasuredLoad, MeasuredPose, MeasuredRobot

_MOST_POSES: Final = 12
_LETTERS: Final = ("a", "b", "c", "x", "y", "z")


def measured_sections(measured: MeasuredRobot) -> list[Section]:
    """Return the tables of the measured robot, with each figure under its loads."""
    out = [
        *positioning_sections(measured),
        *(section for load in measured.loads for section in _pooled(measured, load)),
    ]
    poses = (pose for load in measured.loads for pose in load.poses)
    if any(math.isfinite(pose.repeatability.value) for pose in poses):
        out += [*_poses(measured), _axes(measured)]
    rows = [
        (
            measured_label(f"{name}, P2-P4", load, measured.loads),
            estimate_figure(load.distance[k], "cycles with both"),
        )
        for k, name in enumerate(("AD_p", "RD"))
        for load in measured.loads
        if load.distance is not None and _known(load.distance[k])
    ]
    if rows:
        out.append(table("measured-distance", "Measured: distance P2-P4", ("value",), rows))
    return [*out, *_paths(measured), _data(measured)]


def _known(value: Estimate) -> bool:
    return math.isfinite(value.value)


def _pooled(measured: MeasuredRobot, load: MeasuredLoad) -> list[Section]:
    if load.pooled is None or load.fit is None:
        return []
    counted = several(len(load.poses), "pose")
    rows = [
        (name, estimate_figure(raw, counted), estimate_figure(fitted, counted))
        for name, raw, fitted in zip(
            ("mean", "standard deviation", "95th percentile", "largest"), *load.pooled, strict=True
        )
    ]
    fit = load.fit
    shift = ", ".join(f"{x * 1e3:.3f}" for x in fit.base[:3, 3])
    tool = f"; tool ({', '.join(f'{x * 1e3:.3f}' for x in fit.tool)}) mm" if fit.with_tool else ""
    turn = math.degrees(math.acos(min(max((fit.base[:3, :3].trace() - 1) / 2, -1.0), 1.0)))
    note = (
        f"best-fit base: shift ({shift}) mm, rotation {turn:.4f}°{tool}; {fit.rank} parameters "
        "determined by the poses. "
    )
    note += (
        "Intervals: bootstrap over poses"
        if math.isfinite(load.pooled[0][0].low)
        else "Too few poses for intervals"
    )
    return [
        table(
            accuracy_key(load, measured.loads),
            measured_label("Measured: AP_p over all poses", load, measured.loads),
            ("commanded frames", "best-fit frames"),
            rows,
            note,
        )
    ]


def _in_order(measured: MeasuredRobot) -> list[tuple[MeasuredLoad, MeasuredPose]]:
    """Return the first poses, each under all its loads."""
    names = list(dict.fromkeys(pose.name for load in measured.loads for pose in load.poses))[
        :_MOST_POSES
    ]
    return [
        (load, pose)
        for name in names
        for load in measured.loads
        for pose in load.poses
        if pose.name == name
    ]


def _figure_without(pose: MeasuredPose, of_all: Estimate, without: Estimate) -> Cell:
    """Return a figure without outlying visits; where a pose has none, that of all visits."""
    return estimate_figure(without if pose.outlying else of_all)


def _poses(measured: MeasuredRobot) -> list[Section]:
    """Return a table for each characteristic; one table would be wider than a terminal."""
    shown = _in_order(measured)
    count, all_poses = (
        len({pose.name for _, pose in shown}),
        len({pose.name for load in measured.loads for pose in load.poses}),
    )
    first = "" if count == all_poses else f"the first {count} of {all_poses} poses"

    def label(load: MeasuredLoad, pose: MeasuredPose) -> str:
        return measured_label(pose.name, load, measured.loads)

    with_outlying = any(pose.outlying for _, pose in shown)
    accurate = [
        (
            label(load, pose),
            estimate_figure(pose.accuracy, several(pose.visits, "visit")),
            estimate_figure(Estimate(pose.fitted, math.nan, math.nan)),
            *(
                [_figure_without(pose, pose.accuracy, pose.accuracy_without)]
                if with_outlying
                else []
            ),
        )
        for load, pose in shown
        if _known(pose.accuracy)
    ]
    with_instrument = measured.visits.instrument > 0
    repeats = [
        (
            label(load, pose),
            estimate_figure(pose.repeatability, several(pose.visits, "visit")),
            *([estimate_figure(pose.without_instrument)] if with_instrument else []),
            *(
                [_figure_without(pose, pose.repeatability, pose.without_outlying)]
                if with_outlying
                else []
            ),
        )
        for load, pose in shown
    ]
    note = (f"{first}; " if first else "") + (
        "the interval is that of RP_l for many visits, of which a sample is slightly biased "
        "low; normal scatter"
    )
    if with_instrument:
        floor = max(load.floor for load in measured.loads)
        note += (
            f". RP_l of the instrument alone: {length(floor)}, subtracted in squares, never below "
            "zero"
        )
    if with_outlying:
        note += (
            ". Outlying: farther from the median of the visits than 15 times the median distance; "
            "the standard excludes none"
        )
    columns = (
        "RP_l",
        *(("less instrument",) if with_instrument else ()),
        *(("without outlying",) if with_outlying else ()),
    )
    sides = [
        (
            load_label(pose.name, load.load, {each.load for each in measured.loads}),
            estimate_figure(pose.multi_directional),
        )
        for load, pose in shown
        if _known(pose.multi_directional)
    ]
    poses = ("AP_p", "best-fit frames", *(("without outlying",) if with_outlying else ()))
    tables = (
        table("measured-poses", "Measured: AP_p", poses, accurate, first),
        table("measured-repeatability", "Measured: RP_l", columns, repeats, note),
        table("measured-sides", "Measured: vAP_p, over the sides", ("vAP_p",), sides, first),
    )
    return [each for each in tables if each.rows]


def _axes(measured: MeasuredRobot) -> Section:
    rows = []
    for load, pose in _in_order(measured):
        for letter, average, scatter in zip(_LETTERS, pose.axes, pose.scatter, strict=True):
            if _known(scatter):
                angle = letter in "abc"
                figures = (estimate_figure(each, angle=angle) for each in (average, scatter))
                label = measured_label(f"{pose.name}-{letter}", load, measured.loads)
                rows.append((label, *figures))
    return table(
        "measured-axes",
        "Measured: by axis",
        ("AP", "± 3 s"),
        rows,
        "intervals by Student's t and the chi-square distribution",
    )


def _paths(measured: MeasuredRobot) -> list[Section]:
    paths = [(load, path) for load in measured.loads for path in load.paths]
    rows = [
        (
            measured_label(f"{word}, {name}", load, measured.loads),
            *(
                estimate_figure(each, _counted(path), angle=word[-1] in "abc")
                for each in (Estimate(float(path.figures[k]), math.nan, math.nan), path.many[k])
            ),
            Cell(float(path.worst[k]), "mm"),
        )
        for name in dict.fromkeys(path.name for _, path in paths)
        for k, word in enumerate(PATH_FIGURES)
        for load, path in paths
        if path.name == name and math.isfinite(path.figures[k])
    ]
    if not rows:
        return []
    note = (
        "value: of these cycles by the standard's definition, at the worst place, with its "
        "distance from the start of the path. Many cycles: "
        "estimate of the limit for many cycles with its 95 % confidence interval, for normal "
        "scatter. The worst of several places of few cycles is "
        "biased high, so the value may lie outside the interval. Coverage is lower where a "
        "single place scatters more. "
    ) + _where_read([path for _, path in paths])
    if measured.visits.instrument:
        note += (
            f". RT_p of the instrument alone: about {length(max(path.floor for _, path in paths))}"
        )
    read = [
        (
            measured_label(path.name, load, measured.loads),
            path.readings,
            Cell(float(path.places[0]), "mm"),
            length(float(path.places[-1])),
            length(path.length, stated=True),
            length(path.gap),
            length(path.missed),
        )
        for load, path in paths
    ]
    columns = ("readings", "from", "to", "of", "gap", "missed")
    between = (
        "from, to: range covered by all cycles, of the path's length. Gap: largest distance "
        "of neighbouring readings along the path. Missed: r.m.s. "
        "distance of a reading from the straight line between its neighbours; noise, and "
        "about four times the error of interpolation where the path "
        "bends. Where it exceeds RT_p, read the path more densely"
    )
    figures = ("value", "many cycles", "worst at")
    return [
        table("measured-path", "Measured: path AT_p, RT_p", figures, rows, note),
        table("measured-path-data", "Measured: how the path was read", columns, read, between),
    ]


def _counted(path: MeasuredPath) -> str:
    return f"{path.cycles} cycles x {len(path.places)} {'places' if path.shared else 'planes'}"


def _where_read(paths: list[MeasuredPath]) -> str:
    """Return how the cycles' readings are compared."""
    sentences = []
    for shared in (True, False):
        if names := dict.fromkeys(path.name for path in paths if path.shared is shared):
            counts = sorted({len(path.places) for path in paths if path.shared is shared})
            many = str(counts[0]) if len(counts) == 1 else f"{counts[0]} to {counts[-1]}"
            along = (
                "" if len({path.shared for path in paths}) == 1 else f" along {', '.join(names)}"
            )
            how = (
                f"All cycles were read at the same {many} places"
                if shared
                else "The cycles were read at different places: each one's nearest reading is "
                f"moved to {many} evenly spaced planes by the mean "
                "change of the other cycles. RT is within 3 % of that of readings at shared "
                "places, unless the path bends between them"
            )
            sentences.append(how.replace("read at", f"read{along} at", 1))
    return ". ".join(sentences)


def _data(measured: MeasuredRobot) -> Section:
    visits = measured.visits
    along = sum(map(bool, visits.path))
    rows: list[tuple[Any, ...]] = [("visits", len(visits.path) - along, visits.source)]
    if along:
        rows.append(("readings along paths", along))
    if visits.load_stated:
        rows += [
            (f"rows at {100 * load.load:g} % load", int((visits.load == load.load).sum()))
            for load in measured.loads
        ]
    dropped = "identical in every column that is read" if visits.duplicates else ""
    rows.append(("duplicate rows dropped", visits.duplicates, dropped))
    if visits.lost:
        rows.append(("rows without a reading, excluded", len(visits.lost)))
    rows.append(("poses", len({name for name in visits.pose if name})))
    if visits.instrument:
        rows.append(
            (
                "instrument",
                length(visits.instrument, stated=True),
                "standard deviation of one reading of a coordinate, as stated",
            )
        )
    note = "" if visits.load_stated else "no load stated: full payload assumed"
    return table("measured-data", "Measured: the data", ("value",), rows, note)


def measured_facts(measured: MeasuredRobot, compared: Sequence[ComparedFigure]) -> dict[str, Any]:
    """Return the data of the measurement for result.json."""
    visits = measured.visits
    return {
        "measured": {
            "source": visits.source,
            "visits": len(visits.path) - sum(map(bool, visits.path)),
            "readings_along_paths": sum(map(bool, visits.path)),
            "duplicates": visits.duplicates,
            "unread_columns_that_differ": list(visits.unread),
            "unused_columns": list(visits.unused),
            "rows_without_a_reading": [{"file": file, "line": line} for file, line in visits.lost],
            "outlying": [
                {"pose": pose.name, "file": file, "line": line, "distance_m": far}
                for load in measured.loads
                for pose in load.poses
                for file, line, far in pose.outlying
            ],
            "iso230": positioning_facts(measured),
            "instrument_m": visits.instrument,
            "load_stated": visits.load_stated,
            "loads": [_load_facts(load) for load in measured.loads],
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
        "side": load.side,
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
                    word: {
                        "value": float(value),
                        "many_cycles": _value(each),
                        "interval": _ends(each),
                        "worst_at_m": float(at),
                    }
                    for word, value, each, at in zip(
                        PATH_FIGURES, path.figures, path.many, path.worst, strict=True
                    )
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
