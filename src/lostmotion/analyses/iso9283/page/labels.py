"""Figures from estimates, and labels that name the payload and the side of approach."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from lostmotion.io.limits import cut
from lostmotion.printed import ARCMIN
from lostmotion.reporting.sheet import Cell, length

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from lostmotion.error_model.intervals import Estimate
    from lostmotion.standards.measured_robot import MeasuredLoad

# Angles below this many arcmin are shown in arcsec.
_SMALL_ANGLE: Final = 0.1
LONGEST_SIDE: Final = 20
# Scatter (m, rad) below which only rounding remains.
NO_SCATTER: Final = 1e-13


def estimate_figure(estimate: Estimate, samples: str = "", *, angle: bool = False) -> Cell:
    """Return an estimate as a length (m) or an angle (rad, shown in arcmin or arcsec)."""
    if math.isnan(estimate.value):
        return Cell(math.nan, "1")
    if angle:
        unit = "arcsec" if abs(estimate.value) < _SMALL_ANGLE * ARCMIN else "arcmin"
        return Cell(estimate.value, unit, estimate.low, estimate.high, samples)
    return length(estimate.value, estimate.low, estimate.high, samples)


def scatter_figure(estimate: Estimate, samples: str = "", *, angle: bool = False) -> Cell:
    """Return a repeatability as `estimate_figure` does, or "none described" where no described
    error varies from visit to visit.
    """
    return (
        Cell(math.nan, "1", samples=samples, words="none described")
        if estimate.value < NO_SCATTER
        else estimate_figure(estimate, samples, angle=angle)
    )


def load_label(label: str, load: float, loads: Collection[object]) -> str:
    """Return a label with its share of the payload where there are several loads; no space before
    %, so that it does not wrap.
    """
    return f"{label}, {100 * load:g}%" if len(loads) > 1 else label


def measured_label(text: str, load: MeasuredLoad, loads: Sequence[MeasuredLoad]) -> str:
    """Return a label of measured figures with the side of approach, where there are sides, and with
    the load, where there are several.
    """
    text = f"{text}, from {cut(load.side, LONGEST_SIDE)}" if load.side else text
    return load_label(text, load.load, {each.load for each in loads})


def accuracy_key(load: MeasuredLoad, loads: Sequence[MeasuredLoad]) -> str:
    """Return the key of the table of AP_p over the poses under a load, from a side."""
    at = "" if load.load == loads[0].load else f"-{100 * load.load:g}"
    sides = [each.side for each in loads if each.load == load.load]
    nth = sides.index(load.side)
    return f"measured-accuracy{at}" + (f"-side-{nth + 1}" if nth else "")
