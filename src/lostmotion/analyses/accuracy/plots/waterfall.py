"""The plot of the effects of calibration and compensation, step by step."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from lostmotion.reporting.chart import grid, label_axes, one, text
from lostmotion.reporting.palette import LIGHT
from lostmotion.reporting.sheet import in_one_unit, length

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lostmotion.propagation.montecarlo.waterfall import Waterfall

# The stages of `error_model.remedies.STAGES` that follow each other, and what is done from one to
# the next.
_STEPS = (
    ("as manufactured", "as\nmanufactured"),
    ("calibrated", "geometry\ncalibrated"),
    ("both", "load\ncompensated"),
    ("both, and each robot mapped", "harmonics,\nstiffness mapped"),
)
_WIDE = 0.62


def waterfall(found: Waterfall) -> Figure:
    """Draw what remains of the 95th percentile after each remedy with its 95 % interval, and above
    it, paler, what the remedy removes.
    """
    stages = {stage.name: stage for stage in found.stages}
    at = [stages[name].q95 for name, _ in _STEPS]
    shown = in_one_unit([length(each.value, each.low, each.high) for each in at])
    unit, values = shown[0].shown, [figure.as_shown for figure in shown]
    figure, on = one("95th percentile, one remedy after the other", 76)
    grid(on)
    for k, remaining in enumerate(shown):
        value = remaining.as_shown
        before = values[k - 1] if k else value
        on.bar(k, value, width=_WIDE, color=LIGHT["robot"], linewidth=0)
        on.bar(
            k,
            before - value,
            bottom=value,
            width=_WIDE,
            color=LIGHT["visit"] if before >= value else LIGHT["warn"],
            alpha=0.3,
            linewidth=0,
        )
        if k:
            on.plot(
                [k - 1 + _WIDE / 2, k + _WIDE / 2],
                [before, before],
                color=LIGHT["quiet"],
                linewidth=0.8,
                linestyle=(0, (2, 2)),
            )
        ends = [end if math.isfinite(end) else value for end in (remaining.low, remaining.high)]
        on.errorbar(
            k,
            value,
            [[max(value - ends[0], 0.0)], [max(ends[1] - value, 0.0)]],
            color=LIGHT["ink"],
            linewidth=1.1,
            capsize=3,
        )
        text(on, k, max(value, ends[1]), str(remaining), xytext=(0, 4), ha="center", va="bottom")
    on.set_xticks(range(len(_STEPS)), [words for _, words in _STEPS], color=LIGHT["ink"])
    on.tick_params(axis="x", length=0)
    on.set_ylim(0, 1.14 * max(*values, 1e-12))
    label_axes(on, y=f"95th percentile of the error [{unit}]")
    return figure
