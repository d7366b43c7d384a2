"""Repeatability of a study: its sentence on the first screen, and the table and bars of what it is
made of.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from lostmotion.error_model.arrival import arrival, rp_key, rp_name
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.layout import row_at
from lostmotion.reporting.provenance import as_known, repeats_bounded
from lostmotion.reporting.sheet import Bar, Bars, Cell, Row, Section, in_words, several

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.montecarlo.repeatability import Repeatability

_MADE_OF: Final = "rp_made_of"
_AT_LEAST: Final = "at least "
# Causes that the first screen names, with at least this share.
_MOST_CAUSES: Final = 2
_LEAST_SHARE: Final = 0.05


def made_of_sections(repeats: Sequence[Repeatability]) -> list[Section]:
    """Return the shares of each kind of error in the mean square between visits, for each way to
    arrive; nothing without scatter.
    """
    shares = [dict(each.causes) for each in repeats]
    names = sorted(
        {name for of in shares for name in of},
        key=lambda name: [-of.get(name, 0.0) for of in shares],
    )
    if not names:
        return []
    rows = []
    for name in names:
        figures = (
            in_words("not predicted")
            if each.none
            else Cell(
                of.get(name, 0.0),
                "%",
                samples=f"exact sum over terms, {several(len(each.poses), 'pose')}",
            )
            for of, each in zip(shares, repeats, strict=True)
        )
        rows.append(Row(short_name(name), tuple(figures)))
    note = (
        "share of the mean square between visits, by kind of error. RP is not a sum of them, "
        "but grows with its root. In the ISO cycle each joint "
        "arrives from one side: the side of backlash and hysteresis adds a constant, and "
        "servo, encoder, friction and open clearances scatter"
    )
    return [
        Section(
            _MADE_OF,
            "What RP is made of",
            tuple(arrival(each.approach) for each in repeats),
            tuple(rows),
            note,
        )
    ]


def with_made_of_bars(
    sections: Sequence[Section], repeats: Sequence[Repeatability], arm: Arm, known: States
) -> tuple[Section, ...]:
    """Return the sections of a study, the table of what RP is made of with a block of bars of each
    of its columns that is predicted.
    """
    made_of = next((section for section in sections if section.key == _MADE_OF), None)
    if made_of is None:
        return tuple(sections)
    blocks = []
    for column, each in enumerate(repeats):
        row = _row_of(sections, each)
        if row is None or each.none:
            continue
        bound = _bounded(row.cells[0], each, arm, known)
        shown = tuple(
            Bar(of.label, of.cells[column], of.cells[column].value) for of in made_of.rows
        )
        note = "shares of what is described" if bound.startswith(_AT_LEAST) else ""
        title = f"{rp_name(each.approach)}: {bound}"
        blocks.append(Bars(_MADE_OF, title, "share of the mean square", shown, note=note, most=1.0))
    return tuple(
        replace(section, bars=tuple(blocks)) if section is made_of else section
        for section in sections
    )


def repeatability_statement(
    sections: Sequence[Section],
    repeats: Sequence[Repeatability],
    arm: Arm,
    known: States,
) -> str:
    """Return the sentence on RP in the standard's cycle and from any approach, each with its
    largest causes; empty for a study of one visit.
    """
    if not repeats:
        return ""
    if all(each.none for each in repeats):
        return "No described error differs between visits, so no repeatability is predicted."
    clauses = []
    for each in repeats:
        row, name = _row_of(sections, each), rp_name(each.approach)
        if row is None or each.none:
            clauses.append(f"{name}: not predicted, no described error differs between visits")
            continue
        causes = "; ".join(filter(None, (_largest(each), _lacking(_missing(each, arm)))))
        clauses.append(
            f"{name} {_bounded(as_known(row.cells[0], known), each, arm, known)} ({causes})"
        )
    return f"{'; '.join(clauses)}, for 95 % of the robots."


def _row_of(sections: Sequence[Section], each: Repeatability) -> Row | None:
    """Return the row of this RP, of which 95 % of the robots are within."""
    return row_at(sections, "iso9283", f"{rp_key(each.approach)}_p95")


def _bounded(figure: Cell, each: Repeatability, arm: Arm, known: States) -> str:
    """Return an RP, as a bound where kinds of error are missing, the scatter that one-sided RP
    comes from among them.
    """
    bound = repeats_bounded(figure, known)
    return (
        f"{_AT_LEAST}{figure}" if _missing(each, arm) and not bound.startswith(_AT_LEAST) else bound
    )


def _missing(each: Repeatability, arm: Arm) -> tuple[str, ...]:
    return undescribed_scatter(arm) if each.approach else ()


def one_sided_bounded(sections: Sequence[Section], arm: Arm) -> tuple[Section, ...]:
    """Return sections, RP in the ISO cycle as a lower bound where a joint describes neither a dead
    band nor a scatter of friction.
    """
    if not undescribed_scatter(arm):
        return tuple(sections)
    return tuple(
        replace(section, rows=tuple(map(_one_sided_bounded, section.rows))) for section in sections
    )


def _one_sided_bounded(row: Row) -> Row:
    if not row.key.startswith(rp_key(1.0)):
        return row
    return replace(
        row,
        cells=tuple(
            figure if figure.words else replace(figure, bound="lower") for figure in row.cells
        ),
    )


def undescribed_scatter(arm: Arm) -> tuple[str, ...]:
    """Return the names of the moving joints that describe neither a dead band nor a scatter of
    friction, from which one-sided RP comes.
    """
    return tuple(joint.name for joint in arm.driven if not _describes_scatter(joint))


def _describes_scatter(joint: object) -> bool:
    servo, gearbox, lumped = (getattr(joint, name, None) for name in ("servo", "gearbox", "lumped"))
    scatters = gearbox is not None and "hysteresis_scatter" in gearbox.model_fields_set
    return scatters or lumped is not None or (servo is not None and servo.dead_band is not None)


def _largest(repeatability: Repeatability) -> str:
    named = [(name, share) for name, share in repeatability.causes if share >= _LEAST_SHARE][
        :_MOST_CAUSES
    ]
    return ", ".join(f"{short_name(name)} {Cell(share, '%')}" for name, share in named)


def _lacking(missing: Sequence[str]) -> str:
    return f"{several(len(missing), 'joint')} without servo or friction scatter" if missing else ""
