"""Table of the bands of a gearbox: its figures over draws of the values that are only known to lie
in a range.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.parts.bands import band, influence
from lostmotion.parts.gearbox.bands import LARGE
from lostmotion.printed import stated_text
from lostmotion.reporting.layout import key_of
from lostmotion.reporting.sheet import Card, Cell, Row, Section, several

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lostmotion.analyses.gearbox.tables.units import Units
    from lostmotion.laws.torque_angle import Readings
    from lostmotion.parts.gearbox.bands import GearBands
    from lostmotion.spatial import Floats

COLUMNS: Final = ("5th percentile", "middle", "95th percentile")
OPEN: Final = "5-95 % of what the drawing leaves open"
# Smallest share of a member that has a row of its own, in some draw.
_SMALLEST: Final = 0.01


def bands_sections(bands: GearBands | None, read: Readings, units: Units) -> tuple[Section, ...]:
    """Return the table of the bands, and that of the ranges behind them; none without ranges."""
    if bands is None:
        return ()
    drawn = f"{len(bands.shares)} draws of {several(len(bands.unknown), 'range')}"
    wound = np.asarray(bands.read.wind_up)
    rows = [*_rows(bands, read, units, drawn)]
    whole = sum(bands.middle.values())
    for name, share in bands.member_shares.items():
        if share.max() >= _SMALLEST:
            rows.append(
                Row(
                    f"share of {name}",
                    _figures(bands.middle.get(name, 0.0) / whole, "%", share, drawn),
                )
            )
    note = (
        f"over {drawn}, without the scatter between gearboxes; middle: mean of the gearboxes with "
        "the middle of each range; shares: of the wind-up"
    )
    explained = influence(bands.shares, wound)
    ranges = tuple(
        Row(each.name, (Cell(float(share), "%", samples=drawn),), key=key_of(each.key))
        for each, share in zip(bands.unknown, explained.tolist(), strict=True)
    )
    of_ranges = (
        "share of the variance of the wind-up that each range explains by itself; the largest is "
        "the first to measure"
    )
    return (
        Section("bands", "What the ranges leave open", COLUMNS, tuple(rows), note),
        Section(
            "ranges",
            "Ranges",
            ("share of variance",),
            tuple(sorted(ranges, key=lambda row: -row.cells[0].value)),
            of_ranges,
        ),
    )


def _rows(bands: GearBands, read: Readings, units: Units, drawn: str) -> Iterator[Row]:
    torque = f"{stated_text(read.asked.torque)} {units.torque}"
    angle, stiff = units.angle, units.stiffness
    for label, name, unit, note in (
        ("stiffness, slope", "slope", stiff, ""),
        ("stiffness, secant", "secant", stiff, f"from the middle of the play to {torque}"),
        (f"wind-up at {torque}", "wind_up", angle, "beyond the play"),
        (f"displacement at {torque}", "displacement", angle, "from the middle of the play"),
        ("lost motion", "lost_motion", angle, ""),
    ):
        middle, values = getattr(read, name), getattr(bands.read, name)
        if middle is not None and np.isfinite(middle).all() and np.isfinite(values).all():
            yield Row(label, _figures(float(middle.mean()), unit, values, drawn), note)


def _figures(middle: float, unit: str, values: Floats, samples: str) -> tuple[Cell, Cell, Cell]:
    low, high = band(values)
    return (
        Cell(low, unit, samples=samples),
        Cell(middle, unit, samples=samples),
        Cell(high, unit, samples=samples),
    )


def stiffness_band(
    bands: GearBands | None, read: Readings, units: Units
) -> tuple[Cell, Cell, Cell] | None:
    """Return the stiffness by its definition, or else as secant, with the limits of its band: 5th
    percentile, middle, 95th percentile.

    None where no more than a fifth of the compliance depends on ranges.
    """
    if bands is None or bands.unknown_share <= LARGE:
        return None
    middle, values = (
        (read.stiffness, bands.read.stiffness)
        if read.stiffness is not None
        else (read.secant, bands.read.secant)
    )
    if values is None or not (np.isfinite(values).all() and np.isfinite(middle).all()):
        return None
    return _figures(float(middle.mean()), units.stiffness, values, "")


def first_sentence(figures: tuple[Cell, Cell, Cell] | None) -> str:
    """Return the sentence that begins a headline with the band of the stiffness; empty without
    one.
    """
    if figures is None:
        return ""
    low, middle, high = (each.number for each in figures)
    return f"Stiffness {low} .. {high} {figures[0].shown} ({OPEN}), middle {middle}. "


def with_band(card: Card, figures: tuple[Cell, Cell, Cell] | None) -> Card:
    """Return the card of the stiffness with its band before the value of the middle."""
    if figures is None or card.title != "stiffness":
        return card
    low, middle, high = (each.number for each in figures)
    return Card(
        card.title, f"{low} .. {high} {figures[0].shown}", f"{OPEN}; middle {middle}; {card.quiet}"
    )


def bands_facts(bands: GearBands | None) -> dict[str, Any]:
    """Return what result.json holds of the ranges besides the figures: their limits in SI, and the
    share of the compliance that depends on them.
    """
    if bands is None:
        return {}
    ranges = [
        {"key": each.name, "low": each.band.low, "high": each.band.high, "law": each.band.law}
        for each in bands.unknown
    ]
    return {"ranges": ranges, "share_of_compliance_in_ranges": bands.unknown_share}
