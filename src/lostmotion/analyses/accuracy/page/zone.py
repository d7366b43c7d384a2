"""Tables of zones, of the precision reached, and of the remedies."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from lostmotion.analyses.accuracy.page.error import error_section, iso_section
from lostmotion.error_model.arrival import rp_name
from lostmotion.error_model.robot_intervals import pooled_mean
from lostmotion.propagation.montecarlo.stopping import MOST_POSES
from lostmotion.reporting.layout import key_of
from lostmotion.reporting.sheet import Cell, Row, Section, in_one_unit, length, several

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from lostmotion.accuracy.answer import Answer
    from lostmotion.accuracy.route import FoundInZone
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.poses import Poses
    from lostmotion.propagation.montecarlo.repeatability import Repeatability
    from lostmotion.propagation.montecarlo.stopping import Stopping, Watched
    from lostmotion.propagation.montecarlo.waterfall import Waterfall


def stopping_section(
    stopping: Stopping, where: str = "", key: str = "stopping", *, scarce: bool = False
) -> Section:
    """Return the precision of each figure, stage by stage; `where` and `scarce` as in `outcome`."""
    columns = tuple(
        f"{several(stage.poses, 'pose')} x {several(stage.robots, 'robot')}"
        for stage in stopping.stages
    )
    last = stopping.stages[-1]
    rows = []
    for name, figure in last.figures.items():
        figures = tuple(
            _half(
                stage.figures[name],
                f"{several(stage.poses, 'pose')} x {several(stage.robots, 'robot')}",
            )
            for stage in stopping.stages
        )
        asked = _asked(stopping, figure, missed=name in stopping.missed)
        rows.append(Row(figure.name, figures, asked, name))
    note = (
        "half of each 95 % interval, as a share of the figure, at each stage; asked for: "
        f"{stopping.tolerance}. The first stage shows how many robots "
        "and poses are needed; every printed interval is that of the last stage alone (JCGM "
        "101:2008, 7.9, in two stages or more)"
    )
    return Section(key, outcome(stopping, where, scarce=scarce), columns, tuple(rows), note)


def outcome(stopping: Stopping, where: str = "", *, scarce: bool = False) -> str:
    """Return a sentence on whether the figures have the precision asked for.

    `where` names the poses, where there are several kinds; `scarce` means that there are no more of
    them.
    """
    last = stopping.stages[-1]
    where = where and f" {where}"
    if stopping.reached:
        watched = ", ".join(
            dict.fromkeys(
                each.name.rpartition(", ")[0] or each.name for each in last.figures.values()
            )
        )
        return (
            f"Reached ±{stopping.tolerance}{where and f'{where} ({watched})'} after "
            f"{several(last.robots, 'robot')} and {several(last.poses, 'pose')}"
        )
    figure = last.figures[stopping.missed[0]]
    half = (
        f"half-width {100 * figure.relative:.2g} %"
        if math.isfinite(figure.relative)
        else "too few robots"
    )
    why = {
        "poses": "mostly due to the choice of poses"
        + (
            f", and no more than {last.poses} were found"
            if scarce
            else f": ask for more than {last.poses}"
        ),
        "robots": f"after the most robots allowed, {last.robots}",
        "stages": (
            f"after {len(stopping.stages)} stages, {several(last.robots, 'robot')} and "
            f"{several(last.poses, 'pose')}"
        ),
    }[stopping.limited_by]
    return f"Did not reach ±{stopping.tolerance}{where}: {half} ({figure.name}), {why}"


def _half(figure: Watched, counted: str) -> Cell:
    return Cell(
        figure.relative if math.isfinite(figure.relative) else math.nan, "%", samples=counted
    )


def _asked(stopping: Stopping, figure: Watched, *, missed: bool) -> str:
    allowed = (
        f", ±{100 * stopping.tolerance.half(figure.value) / abs(figure.value):.2g} % here"
        if stopping.tolerance.digits and figure.value
        else ""
    )
    return ("not precise enough" if missed else "precise enough") + allowed


WHOLE: Final = "over the workspace"


BESIDE: Final = ("in the zone", "whole workspace")


OWN: Final = " in the zone"


def zone_sections(answer: Answer) -> list[Section]:
    """Return error, AP and RP of each zone beside those of the whole workspace."""
    out = []
    for k, zone in enumerate(answer.zones, 1):
        inside = seen_in(answer, zone)
        note = f"by Monte Carlo, the same robots: {sampling_note(zone)}"
        for key, title, section in (
            ("", "Position error", error_section),
            ("_iso9283", "ISO 9283, predicted,", iso_section),
        ):
            here, whole = section(inside, OWN), section(answer)
            if not here.rows:
                continue
            rows = (_counted(zone.poses, answer.poses), *beside(here, whole))
            out.append(
                Section(
                    f"zone_{k}{key}",
                    f"{title} in the zone {zone.name}",
                    BESIDE,
                    rows,
                    f"{note}; {here.note}",
                )
            )
    return out


def zone_stopping(zones: Sequence[FoundInZone]) -> list[Section]:
    """Return the precision of each zone's figures, stage by stage."""
    return [
        stopping_section(
            zone.stopping,
            f"in the zone {zone.name}",
            f"zone_{k}_stopping",
            scarce=_scarce(zone.stopping),
        )
        for k, zone in enumerate(zones, 1)
        if zone.stopping is not None
    ]


def stopped_in(zones: Sequence[FoundInZone]) -> list[str]:
    """Return a sentence for each zone on whether its figures have the precision asked for."""
    return [
        outcome(zone.stopping, f"in the zone {zone.name}", scarce=_scarce(zone.stopping))
        for zone in zones
        if zone.stopping is not None
    ]


def _scarce(stopping: Stopping) -> bool:
    """Return whether more poses would have been drawn in the zone, had they been found."""
    return stopping.most_poses < MOST_POSES


def seen_in(answer: Answer, zone: FoundInZone) -> Answer:
    """Return the study as if it had visited the zone's poses alone. Raises ValueError for a zone
    that was not sampled.
    """
    if zone.sampled is None:
        raise ValueError(f"no samples in the zone {zone.name}")
    return replace(
        answer,
        poses=zone.poses,
        sampled=zone.sampled,
        analytic=zone.analytic,
        pooled=zone.pooled,
        budget=zone.budget,
        repeats=zone.repeats,
        zones=(),
    )


def sampling_note(zone: FoundInZone) -> str:
    """Return a note on how the zone's poses were sampled, and what the interval counts."""
    poses = zone.poses
    found = f"{several(len(poses), 'pose')} of the zone ({poses.law}), found among {zone.tried}"
    own = (
        "they have their own numbers, and the worst of them may be worse than the worst visited "
        "pose of the whole workspace"
    )
    if poses.replicates > 1:
        return f"{found}, in {poses.replicates} independent sets; {own}"
    return f"{found}; {own}"


def _counted(here: Poses, whole: Poses) -> Row:
    return Row("poses", (Cell(len(here), "1"), Cell(len(whole), "1")))


def beside(here: Section, whole: Section) -> tuple[Row, ...]:
    """Put the rows of two sections side by side, by key; with the first one's remark, unless it
    is that of both and there is a figure.
    """
    others = {row.key or key_of(row.label): row for row in whole.rows}
    none = Row("", (Cell(math.nan, "1"),))
    pairs = ((row, others.get(row.key or key_of(row.label), none)) for row in here.rows)
    return tuple(
        Row(row.label, (row.cells[0], other.cells[0]), _remark(row, other), row.key)
        for row, other in pairs
    )


def _remark(here: Row, whole: Row) -> str:
    if math.isnan(here.cells[0].value):
        return here.note
    return f"in the zone: {here.note}" if here.note != whole.note else ""


# Each stage in words, in the order of the waterfall.
STAGES: Final = (
    "as manufactured",
    "constant errors of each robot identified",
    "load, pose, stated temperature, nominal stiffness and play known",
    "constant errors identified, load compensated",
    "harmonics and stiffness of each robot mapped as well",
    (
        "every joint from the same side at every visit: backlash and hysteresis become a "
        "constant, which repeats"
    ),
    "nominal backlash and hysteresis of the side of arrival compensated",
    "the same, with load, pose, stated temperature and nominal stiffness known",
    (
        "the same, with constant errors, harmonics and stiffness of each robot known: encoder, "
        "servo, friction and open clearances remain"
    ),
    (
        "an encoder on each output that leaves no play open; its error and the dead band of the "
        "servo remain, as large at the output as now"
    ),
    (
        "the load of each drive is measured: its nominal wind-up, and the side of backlash that "
        "the load closes"
    ),
)


# Of a calibrated arm, after those above.
_MEASURED: Final = "the controller corrects the estimates; what is uncertain of them remains"


def waterfall_section(waterfall: Waterfall, repeats: Sequence[Repeatability]) -> Section:
    """Return the effect of calibration and compensation."""
    counted = (
        f"{several(waterfall.poses, 'pose')} x {several(waterfall.robots, 'robot')} x "
        f"{several(waterfall.visits, 'visit')}, the same at every stage"
    )
    rows = []
    means, left = (
        in_one_unit([_of(each, counted) for each in column])
        for column in zip(*((s.mean, s.q95) for s in waterfall.stages), strict=True)
    )
    texts = (*STAGES, _MEASURED)[: len(waterfall.stages)]
    for stage, text, mean, q95 in zip(waterfall.stages, texts, means, left, strict=True):
        off = _of(stage.reduction, counted)
        effect = (
            f"; reduces the 95th percentile by {off} ({off.interval})"
            if stage is not waterfall.stages[0] and off.interval
            else ""
        )
        rows.append(Row(stage.name, (mean, q95), "" if text == stage.name else text + effect))
    each = (
        f"{rp_name(each.approach)}, {_of(pooled_mean(each.robot_means, each.per_pose[:, 0]), '')}"
        for each in repeats
    )
    stays = (
        f" No calibration or compensation of the load changes RP ({'; '.join(each)} on average)."
        if repeats
        else ""
    )
    note = (
        "by Monte Carlo on a part of the poses and robots, so the first row differs from the "
        "figures above. Every remedy is ideal, "
        "a real one leaves more. Calibration removes a robot's errors that are constant in "
        f"their own frame, {several(len(waterfall.constant), 'error')} "
        "(lengths, axes, encoder zeros). It does not find harmonics (transmission error, "
        "encoder eccentricity) and load-dependent errors: a map "
        "of each robot may find these." + stays
    )
    return Section(
        "waterfall",
        "Effect of calibration and load compensation",
        ("mean", "95th percentile"),
        tuple(rows),
        note,
    )


def rms_section(estimates: Mapping[str, Estimate], poses: int) -> Section:
    """Return what each remedy leaves of the root mean square (m) over so many poses, without
    sampling.
    """
    counted = f"exact sum over terms, {several(poses, 'pose')}"
    left = in_one_unit([_of(each, counted) for each in estimates.values()])
    rows = (
        Row(name, (figure,), "" if text == name else text)
        for name, text, figure in zip(
            estimates, (*STAGES, _MEASURED)[: len(estimates)], left, strict=True
        )
    )
    note = (
        "every remedy is ideal, a real one leaves more. Calibration does not find harmonics "
        "(transmission error, encoder eccentricity) and "
        "load-dependent errors: a map of each robot may find these"
    )
    return Section(
        "remedies", "Effect of remedies without sampling", ("root mean square",), tuple(rows), note
    )


def _of(estimate: Estimate, samples: str) -> Cell:
    return length(estimate.value, estimate.low, estimate.high, samples)
