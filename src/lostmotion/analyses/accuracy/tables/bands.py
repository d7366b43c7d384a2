"""The bands of a study's figures, from values that are only known to lie in a range."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from lostmotion.error_model.arrival import rp_name
from lostmotion.reporting.sheet import Card, Cell, Row, Section, find_row, length, several

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.propagation.montecarlo.bands import Bands

COLUMNS: Final = ("5th percentile", "middle", "95th percentile")
# Titles of the cards of the figures, in their order; that of RP names the approach.
_CARDS: Final = (
    "mean position error",
    "95 % of positions within",
    "accuracy AP, 95 % of robots within",
)
_MOST_NAMES: Final = 3
# Share of a range in the variance of a figure from which it is named with the figure.
_NAMED: Final = 0.2


def bands_sections(found: Bands | None, sections: Sequence[Section]) -> tuple[Section, ...]:
    """Return the table of the bands, and that of the ranges behind them; none where every value is
    known.
    """
    if found is None:
        return ()
    drawn = f"{several(len(found.shares), 'draw')} of {several(len(found.unknown), 'range')}"
    rows = []
    for name, value in _values(found, sections).items():
        low, high = found.band(name, value)
        rows.append(Row(name, tuple(length(each, samples=drawn) for each in (low, value, high))))
    note = (
        f"over {drawn}: a value known only as a range is the same for all robots. Every draw "
        f"has the same {several(found.robots, 'robot')}, "
        f"{several(found.visits, 'visit')} and {several(found.poses, 'pose')}, and is taken "
        "relative to the middle of each range. A band contains "
        "no confidence interval"
    )
    ranges = [
        Row(key, (Cell(share, "%", samples=drawn),))
        for key, share in found.influence("95th percentile").items()
    ]
    of_ranges = (
        "share of the variance of the 95th percentile that each range explains by itself; the "
        "largest is the first to measure"
    )
    return (
        Section("bands", "What the ranges leave open", COLUMNS, tuple(rows), note),
        Section("ranges", "Ranges", ("share of variance",), tuple(ranges), of_ranges),
    )


def bands_clause(found: Bands | None, sections: Sequence[Section]) -> str:
    """Return the clause of the headline on how far the 95 % error depends on ranges; empty where it
    does not.
    """
    value = 0.0 if found is None else _values(found, sections).get("95th percentile", 0.0)
    if found is None or not value:
        return ""
    causes = [key for key, share in found.influence("95th percentile").items() if share > _NAMED][
        :_MOST_NAMES
    ]
    mostly = f" (first of all {', '.join(causes)})" if causes else ""
    return (
        f"values known only as ranges{mostly} leave {_text(found, '95th percentile', value)} open "
        "(5 to 95 %)"
    )


def with_band(card: Card, found: Bands | None, sections: Sequence[Section]) -> Card:
    """Return the card of a figure with its band beside the interval."""
    if found is None:
        return card
    figures = dict(
        zip(
            (*_CARDS, f"{rp_name(found.approach)}, 95 % of robots within"),
            found.figures,
            strict=True,
        )
    )
    if card.title not in figures:
        return card
    name = figures[card.title]
    value = _values(found, sections).get(name, 0.0)
    return (
        Card(
            card.title,
            card.number,
            f"{card.quiet}; ranges {_text(found, name, value)}" if card.quiet else "",
        )
        if value
        else card
    )


def bands_facts(found: Bands | None) -> dict[str, Any]:
    """Return what result.json holds of the ranges besides the figures: their limits in SI; nothing
    where every value is known.
    """
    if found is None:
        return {}
    return {
        "ranges": [
            {"key": each.name, "low": each.band.low, "high": each.band.high, "law": each.band.law}
            for each in found.unknown
        ]
    }


def _text(found: Bands, name: str, value: float) -> str:
    low, high = (length(end) for end in found.band(name, value))
    return f"{low} .. {high}"


def _values(found: Bands, sections: Sequence[Section]) -> dict[str, float]:
    """Return the figures that have a band, m."""
    rows = (
        (name, find_row(sections, key, name))
        for name, key in zip(found.figures, ("error", "error", "iso9283", "iso9283"), strict=True)
    )
    figures = {name: row.cells[0] for name, row in rows if row is not None}
    return {
        name: each.value
        for name, each in figures.items()
        if each.value and math.isfinite(each.value)
    }
