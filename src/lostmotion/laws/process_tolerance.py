"""Usual tolerances of a dimension by its size and the process that makes it: printing, machining to
general tolerances, grades of ISO 286.

| process | ± of a dimension | source |
|---|---|---|
| FFF | 0.2 mm, at least 0.2 % | reinforced nylon: layerx3d.in; the share: Xometry's guide for FDM |
| FFF industrial | 0.1 mm, at least 0.2 % | Xometry's guide for FDM (0.004 in, 0.002 in/in) |
| FFF desktop | 0.3 mm, at least 0.5 % | desk-top printers below 100 mm, as print services state it; the share [M 75] |
| SLA, SLA fine | 0.1 mm, 0.05 mm, at least 0.2 % | print services; the share [M 75] |
| SLS | 0.13 mm, at least 0.2 % | Xometry's guide for SLS |
| MJF | as SLS | [M 75] |
| ISO 2768 f, m, c | table, 0.5 to 4000 mm, f to 2000 mm | DIN ISO 2768-1:1991, table 1 |
| IT5 to IT11 | half of the grade | ISO 286-1, see `iso286`; sizes below 3 mm as those just above, larger than 250 mm as 250 mm |

Holes printed by FFF are 0.1 to 0.3 mm too small, those by SLS up to 0.3 mm, unless they are reamed:
a bias, which no tolerance describes.
"""  # noqa: E501

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from lostmotion.laws.iso286 import RANGES, grade_width

Process = Literal[
    "FFF",
    "FFF industrial",
    "FFF desktop",
    "SLA",
    "SLA fine",
    "SLS",
    "MJF",
    "ISO 2768 f",
    "ISO 2768 m",
    "ISO 2768 c",
    "IT5",
    "IT6",
    "IT7",
    "IT8",
    "IT9",
    "IT10",
    "IT11",
]
_MM: Final = 1e-3
_UM: Final = 1e-6


@dataclass(frozen=True, slots=True)
class _Print:
    """± of a printed dimension: at least `least` (m), at least this share of the size."""

    least: float
    share: float


_PRINTS: Final = {
    "FFF": _Print(0.2 * _MM, 0.002),
    "FFF industrial": _Print(0.1 * _MM, 0.002),
    "FFF desktop": _Print(0.3 * _MM, 0.005),
    "SLA": _Print(0.1 * _MM, 0.002),
    "SLA fine": _Print(0.05 * _MM, 0.002),
    "SLS": _Print(0.13 * _MM, 0.002),
    "MJF": _Print(0.13 * _MM, 0.002),
}
# Upper ends of the ranges of size, mm, and ± there, mm.
_GENERAL_SIZES: Final = (3, 6, 30, 120, 400, 1000, 2000, 4000)
_GENERAL: Final = {
    "ISO 2768 f": (0.05, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5),
    "ISO 2768 m": (0.1, 0.1, 0.2, 0.3, 0.5, 0.8, 1.2, 2.0),
    "ISO 2768 c": (0.2, 0.3, 0.5, 0.8, 1.2, 2.0, 3.0, 4.0),
}
_GRADES: Final = {f"IT{grade}": grade for grade in range(5, 12)}


def process_tolerance(process: str, size: float) -> float:
    """Return the ± tolerance (m) of a dimension of this size (m, above zero) by the process that
    makes it, one of those above.

    Raises ValueError for a general tolerance beyond its table, KeyError for an unknown process.
    """
    if process in _PRINTS:
        made = _PRINTS[process]
        return max(made.least, made.share * size)
    millimetres = size / _MM
    if process in _GENERAL:
        tolerances = _GENERAL[process]
        for end, tolerance in zip(_GENERAL_SIZES, tolerances, strict=False):
            if millimetres <= end * (1 + 1e-9):  # a size computed from another differs by rounding
                return tolerance * _MM
        raise ValueError(
            f"no general tolerance of {process} at {millimetres:.4g} mm: up to "
            f"{_GENERAL_SIZES[len(tolerances) - 1]} mm"
        )
    within = min(max(millimetres, RANGES[0] * (1 + 1e-9)), float(RANGES[-1]))
    return grade_width(_GRADES[process], within) / 2 * _UM
