"""The figures of calibration and compensation: what each would leave of the error."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from lostmotion.figures import Figure, Row, Section, length

if TYPE_CHECKING:
    from lostmotion.studies.intervals import Estimate
    from lostmotion.studies.waterfall import Waterfall

# What each stage is, in the order of `studies.waterfall.STAGES`.
TOLD: Final = (
    "nothing known but the drawing",
    "lengths, axes, encoder zeros and the like of each robot identified: constant errors only",
    "load, pose, nominal stiffness and nominal play known to the controller",
    "geometry identified and load compensated",
    "waves and stiffness of each robot mapped as well: what is left changes from visit to visit",
)


def waterfall_section(found: Waterfall, repeatability: Estimate | None) -> Section:
    """What would calibration and compensation buy?"""
    counted = f"{found.poses} poses x {found.robots} robots x {found.visits} visits, the same at every stage"
    rows = tuple(
        Row(stage.name, (_of(stage.mean, counted), _of(stage.q95, counted), _of(stage.off, counted)), told)
        for stage, told in zip(found.stages, TOLD, strict=True)
    )
    stays = ""
    if repeatability is not None and math.isfinite(repeatability.value):
        stays = f" RP stays at {_of(repeatability, '')} on the average: none of this changes from visit to visit."
    note = (
        f"by Monte Carlo on {counted}: its first row differs from the figures above, within its interval. Every remedy is ideal, a real one leaves "
        f"more. Calibration finds the {len(found.constant)} errors of a robot that are constant in the frame they sit in; it does not find waves "
        f"(transmission error, encoder eccentricity), nor what follows the load: these a map of each robot may.{stays}"
    )
    return Section("waterfall", "What calibration and compensation buy", ("mean", "95 % below", "off the 95 % as built"), rows, note)


def _of(estimate: Estimate, samples: str) -> Figure:
    return length(estimate.value, estimate.low, estimate.high, samples)
