"""The figures of a study in zones, beside those of the whole workspace."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from lostmotion.analyses.accuracy.tables.error import error_section, iso_section
from lostmotion.analyses.accuracy.tables.stopping import outcome, stopping_section
from lostmotion.propagation.montecarlo.stopping import MOST_POSES
from lostmotion.reporting.layout import key_of
from lostmotion.reporting.sheet import Cell, Row, Section, several

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.analyses.accuracy.answer import Answer
    from lostmotion.analyses.accuracy.route import FoundInZone
    from lostmotion.error_model.poses import Poses
    from lostmotion.propagation.montecarlo.stopping import Stopping

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
