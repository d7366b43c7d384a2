"""The figures of calibration and compensation: what each would leave of the error."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from lostmotion.reporting.sheet import Figure, Row, Section, length, several

if TYPE_CHECKING:
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.propagation.montecarlo.waterfall import Waterfall

# What each stage is, in the order of `studies.montecarlo.waterfall.STAGES`.
TOLD: Final = (
    "nothing known but the drawing",
    "constant errors of each robot identified",
    "load, pose, nominal stiffness and play known",
    "constant errors identified, load compensated",
    "waves and stiffness of each robot mapped as well",
)


def waterfall_section(found: Waterfall, repeatability: Estimate | None) -> Section:
    """What would calibration and compensation buy?"""
    counted = f"{several(found.poses, 'pose')} x {several(found.robots, 'robot')} x {several(found.visits, 'visit')}, the same at every stage"
    rows = []
    for stage, told in zip(found.stages, TOLD, strict=True):
        off = _of(stage.off, counted)
        buys = f"; takes {off} ({off.interval}) off the 95 %" if stage is not found.stages[0] and off.interval else ""
        rows.append(Row(stage.name, (_of(stage.mean, counted), _of(stage.q95, counted)), told + buys))
    stays = ""
    if repeatability is not None and math.isfinite(repeatability.value):
        stays = f" RP stays at {_of(repeatability, '')} on the average: none of this changes from visit to visit."
    note = (
        "by Monte Carlo on a part of the poses and robots: the first row differs from the figures above, within its interval. Every remedy is ideal, "
        f"a real one leaves more. Calibration finds what of a robot is constant in the frame it sits in, {several(len(found.constant), 'error')} "
        "(lengths, axes, encoder zeros); it does not find waves (transmission error, encoder eccentricity), nor what follows the load: these a map "
        "of each robot may." + stays
    )
    return Section("waterfall", "What calibration and compensation buy", ("mean", "95 % below"), tuple(rows), note)


def _of(estimate: Estimate, samples: str) -> Figure:
    return length(estimate.value, estimate.low, estimate.high, samples)
