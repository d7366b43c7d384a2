"""Reducers by what is wanted of them; rows that do not state a figure asked for are kept apart, never dropped in silence."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from lostmotion.errors import nearest, refuse_argument

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.catalogue.gearboxes import GearboxRow

# Equal figures fit, however they were worked out.
_SAME: Final = 1 + 1e-9


@dataclass(frozen=True, slots=True)
class Criteria:
    """Search criteria for reducers, in SI; what is not stated may be anything.

    maker            a part of the maker's name, capitals or not
    ratio            a ratio of which the row's figures hold
    min_torque       rated torque of at least so many N m
    max_lost_motion  lost motion as printed of at most so many rad
    min_stiffness    stiffness of the softest zone of at least so many N m/rad
    """

    maker: str = ""
    ratio: float | None = None
    min_torque: float | None = None
    max_lost_motion: float | None = None
    min_stiffness: float | None = None

    @property
    def empty(self) -> bool:
        """Return whether nothing is asked for."""
        return self == Criteria()


@dataclass(frozen=True, slots=True)
class SearchResult:
    """The rows that fit, and by figure those that fit as far as they go but do not state it."""

    rows: tuple[GearboxRow, ...]
    not_stated: dict[str, tuple[GearboxRow, ...]]


def searchable_figures(row: GearboxRow) -> dict[str, float]:
    """Return the searchable values of a row. In SI; NaN where it says nothing. Stiffness is that of the softest zone."""
    part = row.figures.part
    lost_motion = row.lost_motion if part.lost_motion is None else part.lost_motion
    return {
        "rated torque": math.nan if part.rated_torque is None else part.rated_torque,
        "stiffness": min(part.zones, default=math.nan),
        "lost motion": math.nan if lost_motion is None else lost_motion,
        "mass": math.nan if part.mass is None else part.mass,
    }


def search(rows: Sequence[GearboxRow], wanted: Criteria) -> SearchResult:
    """Return the rows that match. Raises InputError for a maker of whom there is no row."""
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
        if sought not in row.maker.casefold() or (wanted.ratio is not None and not row.applies_to(wanted.ratio)):
            continue
        stated = searchable_figures(row)
        limits = {name: (limit, sign) for name, (limit, sign) in asked.items() if limit is not None}
        if any(sign * limit > sign * stated[name] * _SAME**sign for name, (limit, sign) in limits.items()):
            continue  # a comparison with NaN is never true: what is not stated does not rule a row out
        missing = [name for name in limits if math.isnan(stated[name])]
        for name in missing:
            not_stated.setdefault(name, []).append(row)
        if not missing:
            fitting.append(row)
    return SearchResult(tuple(fitting), {name: tuple(without) for name, without in not_stated.items()})
