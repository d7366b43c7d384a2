"""Tables of the standards for bearings and their seats: clearance as delivered, and limit
deviations of shafts, housings and rings.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final, Literal, NoReturn, get_args

from lostmotion.catalogue import data_file
from lostmotion.errors import InputError, Problem, nearest, shown
from lostmotion.laws.fits import interference
from lostmotion.laws.iso286 import (
    HOLE_ZONES,
    RANGES,
    SHAFT_ZONES,
    STEPS,
    expected_zone,
    limit_deviations,
)
from lostmotion.units import Toleranced

Bearing = Literal["deep-groove ball", "cylindrical roller"]
Surface = Literal["shaft", "bearing bore", "housing", "bearing outside"]

_MILLIMETRE: Final = 1e-3
_MICROMETRE: Final = 1e-6
# The largest working clearance in S. Strutynskyi, R. Semenchuk, doi:10.15587/2706-5448.2021.237326,
# stated there for bores up to 100 mm.
PAPERS_CLEARANCE: Final = 60e-6


@dataclass(frozen=True, slots=True)
class Range:
    """One row of a table: for diameters over `over` up to and including `to` (m), the limits
    (lower, upper; m) of each class.
    """

    over: float
    to: float
    limits: dict[str, tuple[float, float]]

    def contains(self, diameter: float) -> bool:
        """Return whether a diameter (m) is in the row; to a nanometre, so that 0.05 is 50 mm
        however it was computed.
        """
        return round(diameter - self.over, 9) > 0 and round(diameter - self.to, 9) <= 0

    def __str__(self) -> str:
        """Return the range as the standards print it."""
        return f"over {self.over / _MILLIMETRE:g} to {self.to / _MILLIMETRE:g} mm"


@dataclass(frozen=True, slots=True)
class ClearanceTable:
    """A table of the standards with its source."""

    source: str
    rows: tuple[Range, ...]


@functools.cache
def tables(file: Literal["clearances", "fits"]) -> dict[str, ClearanceTable]:
    """Return the tables in SI: clearances by kind of bearing, or fits by kind of surface, with the
    common zones of shafts and housings.
    """
    found = {
        name: ClearanceTable(entry["source"], tuple(_row(row) for row in entry["rows"]))
        for name, entry in data_file(f"{file}.toml").items()
    }
    if file == "clearances":
        return found
    # each seat before the ring that sits on it
    found |= {"shaft": _of_zones(SHAFT_ZONES), "housing": _of_zones(HOLE_ZONES)}
    return {name: found[name] for name in get_args(Surface)}


def _of_zones(zones: tuple[str, ...]) -> ClearanceTable:
    rows = [
        Range(
            low * _MILLIMETRE,
            high * _MILLIMETRE,
            {zone: limit_deviations(zone, high * _MILLIMETRE) for zone in zones},
        )
        for low, high in pairwise(STEPS)
    ]
    return ClearanceTable("ISO 286-1, formulas, rounded as its tables [M 95]", tuple(rows))


def delivered_clearance(bearing: Bearing, bore: float, group: str = "CN") -> tuple[float, float]:
    """Return the limits (m) of a bearing's radial clearance as delivered; diametral: the full free
    travel across.

    `bore` m; `group` C2, CN (normal), C3 or C4. Source: ISO 5753-1. Raises InputError for another
    kind or group, or a bore outside the table, with the nearest possible value.
    """
    return _limits("clearances", bearing, bore, group)


def deviation(surface: Surface, diameter: float, zone: str = "normal") -> tuple[float, float]:
    """Return the limit deviations (m, lower and upper) of a shaft, a housing bore, or a bearing's
    ring of this nominal diameter (m).

    `zone` such as k5 for a shaft or J7 for a housing (ISO 286, zones f to s, over 3 mm to 250 mm),
    "normal" for a bearing's ring (ISO 492). Raises InputError for other zones and diameters, with
    the nearest possible value.
    """
    if surface not in {"shaft", "housing"}:
        return _limits("fits", surface, diameter, zone)
    expected, near = expected_zone(zone, hole=surface == "housing")
    if expected:
        _refuse("fits", shown(zone), expected, near, near)
    try:
        return limit_deviations(zone, diameter)
    except ValueError:
        found = f"a {surface} of {diameter / _MILLIMETRE:g} mm"
        end = RANGES[0] + 1 if diameter < RANGES[1] * _MILLIMETRE else RANGES[-1]
        _refuse("fits", found, f"a diameter over {RANGES[0]} to {RANGES[-1]} mm", f"{end} mm")


def clearance_of_group(bearing: Bearing, bore: float, group: str = "CN") -> Toleranced:
    """Return the clearance of a bearing of this group as delivered, as a toleranced dimension:
    uniform within its limits.

    Arguments, source and errors as `delivered_clearance`.
    """
    low, high = delivered_clearance(bearing, bore, group)
    return Toleranced((low + high) / 2, (high - low) / 2, "uniform")


def interference_of_zone(
    seat: Literal["shaft", "housing"], diameter: float, zone: str
) -> Toleranced:
    """Return the interference (m, on the diameter) of a ring of the normal class with a shaft or
    housing of this zone: middle and ± limits.

    `diameter` m of the seat, `zone` such as k5 for a shaft or H7 for a housing. Negative for a
    loose fit. Source and errors as `deviation`.
    """
    if seat == "shaft":
        low, high = interference(
            deviation("shaft", diameter, zone), deviation("bearing bore", diameter)
        )
    else:
        low, high = interference(
            deviation("bearing outside", diameter), deviation("housing", diameter, zone)
        )
    return Toleranced((low + high) / 2, (high - low) / 2)


def clearance_warning(
    bearing: Bearing, bore: float, group: str = "CN", assumed: float = PAPERS_CLEARANCE
) -> str:
    """Return why clearances cannot be assumed to be at most this large (m, default 60 µm); empty
    where they can.

    Only the delivered clearance counts: fits and temperature reduce it. Raises InputError as
    `delivered_clearance`.
    """
    low, high = (limit / _MICROMETRE for limit in delivered_clearance(bearing, bore, group))
    limit = assumed / _MICROMETRE
    if high <= limit * (1 + 1e-9):
        return ""
    return (
        f"a clearance of at most {limit:.3g} µm does not hold for a {bearing} bearing of "
        f"{bore / _MILLIMETRE:g} mm bore in group {group}: "
        f"as delivered it is {low:.3g} to {high:.3g} µm (ISO 5753-1); state its working "
        "clearance, or a tighter group"
    )


def _row(row: dict[str, Any]) -> Range:
    limits = {
        name: (low * _MICROMETRE, high * _MICROMETRE)
        for name, (low, high) in ((k, v) for k, v in row.items() if k not in ("over", "to"))
    }
    return Range(row["over"] * _MILLIMETRE, row["to"] * _MILLIMETRE, limits)


def _limits(
    file: Literal["clearances", "fits"], name: str, diameter: float, column: str
) -> tuple[float, float]:
    known = tables(file)
    if name not in known:
        _refuse(
            file,
            shown(name),
            "one of " + ", ".join(known),
            nearest(name, known) or next(iter(known)),
            nearest(name, known),
        )
    rows = known[name].rows
    row = next((row for row in rows if row.contains(diameter)), None)
    if row is None:
        near = min(rows, key=lambda row: max(row.over - diameter, diameter - row.to))
        found = f"a {name} of {diameter / _MILLIMETRE:g} mm" + (
            " bore" if file == "clearances" else ""
        )
        whole = f"over {rows[0].over / _MILLIMETRE:g} to {rows[-1].to / _MILLIMETRE:g} mm"
        _refuse(
            file,
            found,
            f"a diameter in the table, {whole}; the nearest row is {near}",
            f"{near.to / _MILLIMETRE:g} mm",
        )
    if column not in row.limits:
        near_column = nearest(column, row.limits)
        _refuse(
            file,
            shown(column),
            f"one of {', '.join(row.limits)} for a {name}",
            near_column or next(iter(row.limits)),
            near_column,
        )
    return row.limits[column]


def _refuse(file: str, *words: str) -> NoReturn:
    raise InputError([Problem("the catalogue", file, *words)])
