"""What a page of ISO 9283 says: figures from estimates, labels that name the payload and the side
of approach, and what its words mean, for whoever reads it without the standard.
"""

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
WORDS: Final = (
    (
        "predicted, never certified",
        (
            "characteristics by the definitions of ISO 9283:1998, for simulated robots of this "
            "design; a certificate needs the robot itself."
        ),
    ),
    (
        "AP_p",
        (
            "pose accuracy: distance of the barycentre (the mean of a robot's visits) from the "
            "commanded point (7.2.1)."
        ),
    ),
    (
        "best-fit frames",
        (
            "AP_p after a least-squares fit of the base frame (and of the tool frame, where "
            "orientations were measured)."
        ),
    ),
    (
        "RP_l",
        (
            "pose repeatability: mean distance of the visits from their barycentre plus three "
            "standard deviations of it (7.2.2)."
        ),
    ),
    (
        "thirty visits",
        (
            "RP_l of 30 visits is a sample estimate: for isotropic normal scatter mean 3.536 "
            "sigma, standard deviation 0.329; 3.616 for many visits."
        ),
    ),
    (
        "none described",
        (
            "no described error varies from visit to visit: no repeatability is predicted, which "
            "does not mean that it is zero."
        ),
    ),
    (
        "from either side",
        (
            "RP_l if joints arrive from either side at random, so that all backlash counts. In "
            "the standard's cycle each arrives from one."
        ),
    ),
    (
        "mean, 95th percentile",
        "over the simulated robots; at full payload where no load is stated.",
    ),
    ("worst", "the worst of the five poses of each robot."),
    ("a, b, c", "rotations about the base's x, y, z axes."),
    (
        "vAP_p",
        (
            "multi-directional pose accuracy: largest distance between the barycentres of "
            "approaches along the base's x, y and z (7.2.3)."
        ),
    ),
    (
        "positioning by axis",
        "ISO 230-2 along and about one axis at a time, as makers of positioners state it.",
    ),
    (
        "A, R, B, E, M",
        (
            "ISO 230-2: range of mean ± two standard deviations over all positions (A) and at the "
            "worst (R); B is the difference of the sides."
        ),
    ),
    ("AD_p, RD", "accuracy and repeatability of the distance between P2 and P4 (7.3)."),
    (
        "AT_p, RT_p",
        (
            "path accuracy and repeatability, normal to the path, at its worst point (8.2, 8.3); "
            "AT_a to RT_c of its orientation. Quasi-static."
        ),
    ),
    ("100 %, 10 %", "share of the payload that the tool carries."),
    (
        "interval",
        "95 % confidence interval from the number of robots. A question mark: too few robots.",
    ),
)


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
