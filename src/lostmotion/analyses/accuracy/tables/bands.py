"""The bands of a study's figures, from values that are only known to lie in a range."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

from lostmotion.propagation.figures import HEADLINE as _HEADLINE
from lostmotion.reporting.sheet import Card, Cell, Row, Section, length, several

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from lostmotion.error_model.intervals import Estimate
    from lostmotion.propagation.figures import Figure
    from lostmotion.propagation.montecarlo.bands import Bands

COLUMNS: Final = ("5th percentile", "middle", "95th percentile")
_MOST_NAMES: Final = 3
# Share of a range in the variance of a figure from which it is named with the figure.
_NAMED: Final = 0.2


def bands_sections(
    found: Bands | None, declared: Iterable[Figure], figures: Mapping[str, Estimate]
) -> tuple[Section, ...]:
    """Return the table of the bands, and that of the ranges behind them; none where every value is
    known.
    """
    if found is None:
        return ()
    drawn = f"{several(len(found.shares), 'draw')} of {several(len(found.unknown), 'range')}"
    rows = []
    for each in declared:
        value = _value(found, each.key, figures)
        if value:
            low, high = found.band(each.key, value)
            cells = (length(end, samples=drawn) for end in (low, value, high))
            rows.append(Row(each.name, tuple(cells), key=each.key))
    note = (
        f"over {drawn}: a value known only as a range is the same for all robots. Every draw "
        f"has the same {several(found.robots, 'robot')}, "
        f"{several(found.visits, 'visit')} and {several(found.poses, 'pose')}, and is taken "
        "relative to the middle of each range. A band contains "
        "no confidence interval"
    )
    ranges = [
        Row(key, (Cell(share, "%", samples=drawn),))
        for key, share in found.influence(_HEADLINE).items()
    ]
    of_ranges = (
        "share of the variance of the 95th percentile that each range explains by itself; the "
        "largest is the first to measure"
    )
    return (
        Section("bands", "What the ranges leave open", COLUMNS, tuple(rows), note),
        Section("ranges", "Ranges", ("share of variance",), tuple(ranges), of_ranges),
    )


def bands_clause(found: Bands | None, figures: Mapping[str, Estimate]) -> str:
    """Return the clause of the headline on how far the 95 % error depends on ranges; empty where it
    does not.
    """
    value = 0.0 if found is None else _value(found, _HEADLINE, figures)
    if found is None or not value:
        return ""
    causes = [key for key, share in found.influence(_HEADLINE).items() if share > _NAMED][
        :_MOST_NAMES
    ]
    mostly = f" (first of all {', '.join(causes)})" if causes else ""
    return (
        f"values known only as ranges{mostly} leave {_text(found, _HEADLINE, value)} open "
        "(5 to 95 %)"
    )


def with_band(card: Card, found: Bands | None, figures: Mapping[str, Estimate]) -> Card:
    """Return the card of a figure with its band beside the interval."""
    value = 0.0 if found is None else _value(found, card.key, figures)
    if found is None or not value:
        return card
    quiet = f"{card.quiet}; ranges {_text(found, card.key, value)}" if card.quiet else ""
    return replace(card, quiet=quiet)


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


def _text(found: Bands, key: str, value: float) -> str:
    low, high = (length(end) for end in found.band(key, value))
    return f"{low} .. {high}"


def _value(found: Bands, key: str, figures: Mapping[str, Estimate]) -> float:
    """Return a figure that has a band, m; zero for others."""
    value = figures[key].value if key in found.ratios and key in figures else 0.0
    return value if math.isfinite(value) else 0.0
