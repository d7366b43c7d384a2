"""Search for reducers by requirements; rows that do not state a required figure are listed
separately, never dropped silently.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from lostmotion.errors import nearest, refuse_argument

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.catalogue.gearbox_row import GearboxRow

# Equal figures meet a limit, whatever their rounding.
_SAME: Final = 1 + 1e-9


@dataclass(frozen=True, slots=True)
class Criteria:
    """Requirements on a reducer; a field without a value excludes nothing. In SI.

    maker            a part of the maker's name, in any case
    ratio            a ratio to which the row's figures apply
    min_torque       smallest rated torque, N m
    max_lost_motion  largest printed lost motion, rad
    min_stiffness    smallest stiffness of the softest zone, N m/rad
    """

    maker: str = ""
    ratio: float | None = None
    min_torque: float | None = None
    max_lost_motion: float | None = None
    min_stiffness: float | None = None

    @property
    def empty(self) -> bool:
        """Return whether there is no requirement."""
        return self == Criteria()


@dataclass(frozen=True, slots=True)
class SearchResult:
    """The rows that meet the criteria, and by figure the rows that meet the others but do not state
    this one.
    """

    rows: tuple[GearboxRow, ...]
    not_stated: dict[str, tuple[GearboxRow, ...]]


def searchable_figures(row: GearboxRow, ratio: float | None = None) -> dict[str, float]:
    """Return the figures of a row that can be searched for, in SI; NaN where it states none.

    Stiffness is that of the softest zone, the rated torque that at `ratio`, or else the smallest of
    the ratios of the row.
    """
    part = row.figures.part
    torques = row.torques_at(ratio)
    lost_motion = row.lost_motion if part.lost_motion is None else part.lost_motion
    return {
        "rated torque": torques[0]
        if torques
        else math.nan
        if part.rated_torque is None
        else part.rated_torque,
        "stiffness": min(part.zones, default=math.nan),
        "lost motion": math.nan if lost_motion is None else lost_motion,
        "mass": math.nan if part.mass is None else part.mass,
    }


def search(rows: Sequence[GearboxRow], wanted: Criteria) -> SearchResult:
    """Return the rows that meet the criteria. Raises InputError for a maker without any row."""
    makers = tuple(dict.fromkeys(row.maker for row in rows))
    sought = wanted.maker.casefold()
    if not any(sought in maker.casefold() for maker in makers):
        near = nearest(wanted.maker, makers) or next(iter(makers), "")
        raise refuse_argument("maker", wanted.maker, "one of " + ", ".join(makers[:20]), maker=near)
    asked = {
        "rated torque": (wanted.min_torque, 1.0),
        "stiffness": (wanted.min_stiffness, 1.0),
        "lost motion": (wanted.max_lost_motion, -1.0),
    }
    fitting: list[GearboxRow] = []
    not_stated: dict[str, list[GearboxRow]] = {}
    for row in rows:
        if sought not in row.maker.casefold() or (
            wanted.ratio is not None and not row.applies_to(wanted.ratio)
        ):
            continue
        stated = searchable_figures(row, wanted.ratio)
        limits = {name: (limit, sign) for name, (limit, sign) in asked.items() if limit is not None}
        if any(
            sign * limit > sign * stated[name] * _SAME**sign
            for name, (limit, sign) in limits.items()
        ):
            # a comparison with NaN is never true: a figure that is not stated does not exclude a
            # row
            continue
        missing = [name for name in limits if math.isnan(stated[name])]
        for name in missing:
            not_stated.setdefault(name, []).append(row)
        if not missing:
            fitting.append(row)
    return SearchResult(
        tuple(fitting), {name: tuple(without) for name, without in not_stated.items()}
    )
