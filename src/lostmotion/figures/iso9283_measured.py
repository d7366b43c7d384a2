"""The figures of a measured robot by ISO 9283, alone and beside what was predicted."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from lostmotion.figures import Card, Figure, Row, Section, length
from lostmotion.figures.iso9283 import of
from lostmotion.studies.intervals import Estimate

if TYPE_CHECKING:
    from lostmotion.studies.iso9283.compared import Compared
    from lostmotion.studies.iso9283.measured import Measured, MeasuredPose

_MOST_POSES: Final = 12
_LETTERS: Final = ("a", "b", "c", "x", "y", "z")
# In reading order; the figures that stand in the table, not only in result.json.
SHOWN: Final = ("AP_p", "AP_p fitted", "RP_l", "RP_a", "RP_b", "RP_c", "vAP_p", "AD_p", "RD")


def measured_verdict(found: Measured, compared: list[Compared]) -> str:
    """What does the measured robot show, and does it look like those predicted?"""
    parts = []
    if found.pooled is not None:
        raw, fitted = found.pooled
        parts.append(f"Measured: AP_p {of(raw[0])} on the average over {len(found.poses)} poses as it is, {of(fitted[0])} with best-fit frames")
    repeat = [pose.repeatability.value for pose in found.poses if math.isfinite(pose.repeatability.value)]
    if repeat:
        parts.append(f"{'measured ' if not parts else ''}RP_l up to {length(max(repeat))}")
    text = ", ".join(parts) + "." if parts else "Measured: no command and no pose visited twice, so neither accuracy nor repeatability can be told."
    shown = [each for each in compared if each.name in SHOWN]
    if shown:
        text += (
            f" {sum(each.within for each in shown)} of {len(shown)} measured figures lie within what 5 % and 95 % of the predicted robots stay below."
        )
    return text[0].upper() + text[1:]


def measured_cards(found: Measured, compared: list[Compared]) -> list[Card]:
    """Give the measured figures that are asked for first."""
    out = []
    repeat = [pose.repeatability for pose in found.poses if math.isfinite(pose.repeatability.value)]
    if repeat:
        out.append(Card("RP_l measured", str(of(max(repeat, key=lambda each: each.value))), "worst pose"))
    if found.pooled is not None:
        out += [
            Card("AP_p measured", str(of(found.pooled[0][0])), f"mean of {len(found.poses)} poses, as it is"),
            Card("AP_p, best-fit frames", str(of(found.pooled[1][0])), "measured, mean over poses"),
        ]
    shown = [each for each in compared if each.name in SHOWN]
    if shown:
        out.append(Card("as predicted", f"{sum(each.within for each in shown)} of {len(shown)}", "within 5-95 % of robots"))
    return out


def measured_sections(found: Measured) -> list[Section]:
    """Give the sheet of the measured robot."""
    out = [*_pooled(found)]
    if any(math.isfinite(pose.repeatability.value) for pose in found.poses):
        out += [_poses(found), _axes(found)]
    if found.distance is not None:
        rows = tuple(Row(name, (of(value, "cycles with both"),)) for name, value in zip(("AD_p", "RD"), found.distance, strict=True) if _known(value))
        out.append(Section("measured-distance", "Measured: distance P2-P4", ("value",), rows))
    return [*out, _data(found)]


def _known(value: Estimate) -> bool:
    return math.isfinite(value.value)


def _pooled(found: Measured) -> list[Section]:
    if found.pooled is None or found.fit is None:
        return []
    counted = f"{len(found.poses)} poses"
    rows = [
        Row(name, (of(raw, counted), of(fitted, counted)))
        for name, raw, fitted in zip(("mean", "standard deviation", "95 % of poses below", "largest"), *found.pooled, strict=True)
    ]
    fit = found.fit
    shift = ", ".join(f"{x * 1e3:.3f}" for x in fit.base[:3, 3])
    tool = f"; tool ({', '.join(f'{x * 1e3:.3f}' for x in fit.tool)}) mm" if found.visits.rotation is not None else ""
    turn = math.degrees(math.acos(min(max((fit.base[:3, :3].trace() - 1) / 2, -1.0), 1.0)))
    note = f"best-fit base: shift ({shift}) mm, turn {turn:.4f}°{tool}; {fit.told} numbers told by the poses. "
    note += "Intervals by drawing poses again" if math.isfinite(found.pooled[0][0].low) else "Too few poses for intervals over them"
    return [Section("measured-accuracy", "Measured: AP_p over all poses", ("as it is", "best-fit frames"), tuple(rows), note)]


def _poses(found: Measured) -> Section:
    shown = found.poses[:_MOST_POSES]
    with_instrument = found.visits.instrument > 0
    with_sides = any(_known(pose.multi_directional) for pose in found.poses)

    def row(pose: MeasuredPose) -> Row:
        counted = f"{pose.visits} visits"
        figures = [of(pose.accuracy, counted), of(Estimate(pose.fitted, math.nan, math.nan)), of(pose.repeatability, counted)]
        if with_instrument:
            figures.append(length(pose.without_instrument))
        if with_sides:
            figures.append(of(pose.multi_directional))
        return Row(pose.name, tuple(figures))

    columns = ("AP_p", "best-fit frames", "RP_l", *(("less instrument",) if with_instrument else ()), *(("vAP_p",) if with_sides else ()))
    note = "" if len(shown) == len(found.poses) else f"the first {len(shown)} of {len(found.poses)} poses; "
    note += "the interval of RP_l is of what many visits would show, of which a sample shows a little less; normal scatter"
    if with_instrument:
        note += f". The instrument alone would show an RP_l of {length(found.floor)}; it is taken off in squares, zero where no more is left"
    return Section("measured-poses", "Measured: poses", columns, tuple(row(pose) for pose in shown), note)


def _axes(found: Measured) -> Section:
    rows = []
    for pose in found.poses[:_MOST_POSES]:
        for letter, average, scatter in zip(_LETTERS, pose.axes, pose.scatter, strict=True):
            if _known(scatter):
                angle = letter in "abc"
                rows.append(Row(f"{pose.name}-{letter}", (of(average, angle=angle), of(scatter, angle=angle))))
    return Section("measured-axes", "Measured: by axis", ("AP", "± 3 s"), tuple(rows), "intervals by Student's law and by chi-square")


def _data(found: Measured) -> Section:
    visits = found.visits
    rows = [
        Row("visits", (Figure(len(visits.pose), ""),), visits.source),
        Row("exact duplicates left out", (Figure(visits.duplicates, ""),), "rows that repeat another one in every cell" if visits.duplicates else ""),
        Row("poses", (Figure(len(found.poses), ""),)),
    ]
    if visits.instrument:
        rows.append(Row("instrument", (length(visits.instrument),), "standard deviation of one reading of a coordinate, as stated"))
    return Section("measured-data", "Measured: the data", ("value",), tuple(rows))


def compared_section(compared: list[Compared]) -> list[Section]:
    """Give predicted and measured side by side."""
    rows = []
    for name in SHOWN:
        for each in (each for each in compared if each.name == name):
            spread = each.predicted
            figures = (
                of(spread.low, angle=each.angle),
                of(spread.high, angle=each.angle),
                of(each.measured, angle=each.angle),
            )
            plain = tuple(Figure(figure.value, figure.unit) for figure in figures[:2])
            rows.append(Row(f"{name}, {each.pose}", (*plain, figures[2]), "within" if each.within else "outside"))
    if not rows:
        return []
    note = (
        "over robots built, full payload, visited as often, read with the instrument stated; within: between what 5 % and 95 % of them stay below. "
        "Of a robot like them one figure in ten is not"
    )
    return [Section("compared", "Predicted and measured", ("5 % below", "95 % below", "measured"), tuple(rows), note)]


def measured_facts(found: Measured, compared: list[Compared]) -> dict[str, Any]:
    """Give what result.json tells of the measurement besides."""
    return {
        "measured": {
            "source": found.visits.source,
            "visits": len(found.visits.pose),
            "duplicates": found.visits.duplicates,
            "instrument_m": found.visits.instrument,
            "base_fit": None if found.fit is None else found.fit.base.tolist(),
            "tool_fit_m": None if found.fit is None else found.fit.tool.tolist(),
        },
        "compared": [
            {
                "figure": each.name,
                "pose": each.pose,
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
