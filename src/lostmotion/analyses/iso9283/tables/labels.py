"""Estimates as figures with units, and labels that name their payload."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from lostmotion.reporting.sheet import ARCMIN, ARCSEC, Figure, length

if TYPE_CHECKING:
    from collections.abc import Collection

    from lostmotion.error_model.intervals import Estimate

# Of an arcmin: below it seconds are read more easily.
_SMALL_ANGLE: Final = 0.1
# m, rad: a scatter below it is what rounding leaves of none.
NO_SCATTER: Final = 1e-13


def estimate_figure(estimate: Estimate, samples: str = "", *, angle: bool = False) -> Figure:
    """Give an estimate as a length (m) or an angle (rad, shown in arcmin or arcsec)."""
    if math.isnan(estimate.value):
        return Figure(math.nan, "1")
    if angle:
        unit, size = ("arcsec", ARCSEC) if abs(estimate.value) < _SMALL_ANGLE * ARCMIN else ("arcmin", ARCMIN)
        return Figure(estimate.value / size, unit, estimate.low / size, estimate.high / size, samples)
    return length(estimate.value, estimate.low, estimate.high, samples)


def scatter_figure(estimate: Estimate, samples: str = "", *, angle: bool = False) -> Figure:
    """Give a repeatability as `estimate_figure` does; words in place of a number where nothing that is described varies from visit to visit."""
    return (
        Figure(math.nan, "1", samples=samples, words="none described")
        if estimate.value < NO_SCATTER
        else estimate_figure(estimate, samples, angle=angle)
    )


def load_label(label: str, load: float, loads: Collection[object]) -> str:
    """Give a label with its share of the payload, where figures stand under several; no space, at which a narrow screen would fold it."""
    return f"{label}, {100 * load:g}%" if len(loads) > 1 else label
