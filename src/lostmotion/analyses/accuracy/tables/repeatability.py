"""Repeatability of a study: its sentence on the first screen, and the table of what it is made of."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from lostmotion.error_model.arrival import arrival, rp_name
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.provenance import repeats_bounded
from lostmotion.reporting.sheet import Figure, Row, Section, find_row, several

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.montecarlo.repeatability import Repeatability

# Causes that the first screen names, with at least this share.
_MOST_CAUSES: Final = 2
_LEAST_SHARE: Final = 0.05


def made_of_sections(found: Sequence[Repeatability]) -> list[Section]:
    """Return the shares of each kind of error in the mean square between visits, for each way to arrive; nothing without scatter."""
    shares = [dict(each.causes) for each in found]
    names = sorted({name for of in shares for name in of}, key=lambda name: [-of.get(name, 0.0) for of in shares])
    if not names:
        return []
    rows = []
    for name in names:
        figures = (
            Figure(100 * of.get(name, 0.0), "%", samples=f"exact sum over terms, {several(len(each.poses), 'pose')}")
            for of, each in zip(shares, found, strict=True)
        )
        rows.append(Row(short_name(name), tuple(figures)))
    note = (
        "share of the mean square between visits, by kind of error. RP is not a sum of them, but grows with its root. In the ISO cycle each joint "
        "arrives from one side: the side of backlash and hysteresis adds a constant, and servo, encoder, friction and open clearances scatter"
    )
    return [Section("rp_made_of", "What RP is made of", tuple(arrival(each.approach) for each in found), tuple(rows), note)]


def repeatability_statement(found: Sequence[Section], repeats: Sequence[Repeatability], arm: Arm, known: States) -> str:
    """Return the sentence on RP in the standard's cycle and from any approach, each with its largest causes; empty for a study of one visit."""
    if not repeats:
        return ""
    if all(each.none for each in repeats):
        return "No described error differs between visits, so no repeatability is predicted."
    clauses = []
    for each in repeats:
        row = find_row(found, "iso9283", f"{rp_name(each.approach)}, 95th percentile of robots")
        name = rp_name(each.approach)
        if row is None or each.none:
            clauses.append(f"{name}: not predicted, no described error differs between visits")
            continue
        bound = repeats_bounded(row.figures[0], known)
        missing = undescribed_scatter(arm) if each.approach else ()
        if missing and not bound.startswith("at least"):
            bound = f"at least {row.figures[0]}"
        clauses.append(f"{name} {bound} ({'; '.join(filter(None, (_largest(each), _lacking(missing))))})")
    return f"{'; '.join(clauses)}, for 95 % of the robots."


def undescribed_scatter(arm: Arm) -> tuple[str, ...]:
    """Return the names of the moving joints that describe neither a dead band nor a scatter of friction, from which one-sided RP comes."""
    return tuple(joint.name for joint in arm.moving if not _describes_scatter(joint))


def _describes_scatter(joint: object) -> bool:
    servo, gearbox, lumped = (getattr(joint, name, None) for name in ("servo", "gearbox", "lumped"))
    scatters = gearbox is not None and "hysteresis_scatter" in gearbox.model_fields_set
    return scatters or lumped is not None or (servo is not None and servo.dead_band is not None)


def _largest(found: Repeatability) -> str:
    named = [(name, share) for name, share in found.causes if share >= _LEAST_SHARE][:_MOST_CAUSES]
    return ", ".join(f"{short_name(name)} {Figure(100 * share, '%')}" for name, share in named)


def _lacking(missing: Sequence[str]) -> str:
    return f"{several(len(missing), 'joint')} without servo or friction scatter" if missing else ""
