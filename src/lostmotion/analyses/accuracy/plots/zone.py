"""The plot of the error in a zone over that of the whole workspace."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.analyses.accuracy.tables.zone import seen_in
from lostmotion.error_model.intervals import pooled_quantile
from lostmotion.printed import factor_of, unit_of_length
from lostmotion.propagation.montecarlo.histogram import counts_between, linear_bins
from lostmotion.reporting.chart import histogram, label_axes, legend, mark, one
from lostmotion.reporting.palette import LIGHT

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lostmotion.analyses.accuracy.answer import Answer
    from lostmotion.analyses.accuracy.route import FoundInZone


def errors_in_zone(answer: Answer, zone: FoundInZone) -> Figure:
    """Draw the distribution of the error in a zone over that of the workspace, with the zone's 95th
    percentile.
    """
    inside = seen_in(answer, zone).sampled
    here, whole = inside.replicate_hist.sum(axis=0), answer.sampled.replicate_hist.sum(axis=0)
    edges, _ = linear_bins(here + whole)
    unit = unit_of_length(float(edges[-1]))
    factor = factor_of(unit)
    figure, on = one("Position error in the zone", 80)
    shares = [100 * counts_between(hist, edges) / hist.sum() for hist in (whole, here)]
    histogram(on, edges * factor, shares[0], LIGHT["line"], "whole workspace")
    on.stairs(shares[1], edges * factor, color=LIGHT["robot"], linewidth=1.5, label="in the zone")
    on.set_ylim(bottom=0)
    mark(
        on,
        pooled_quantile(inside.group_hist, inside.replicate_hist, 0.95),
        "95th percentile, in the zone",
        unit,
    )
    label_axes(
        on,
        f"position error [{unit}]",
        f"samples per {float(edges[1] - edges[0]) * factor:.3g} {unit} [%]",
    )
    legend(figure)
    return figure
