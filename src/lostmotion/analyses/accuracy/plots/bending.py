"""The plot of the bending of links by cause."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lostmotion.mechanism.load_causes import CAUSES, OUTBOARD_CAUSES, OWN_WEIGHT
from lostmotion.reporting.chart import label_axes, legend, named_rows, one, stacked
from lostmotion.reporting.palette import OF_CAUSE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lostmotion.analyses.accuracy.answer import Answer


def bending(answer: Answer) -> Figure:
    """Draw the largest deflection of each link (µm), stacked by cause; a cause that reduces the
    bending extends to the left.
    """
    links = answer.bending
    figure, on = one("Largest deflection of each link", 36 + 8 * len(links))
    rows = []
    for cause in (OWN_WEIGHT, *CAUSES):
        parts = np.array([bent.by_cause.get(cause, (0.0, 0.0, 0.0))[0] * 1e6 for bent in links])
        if parts.any():
            rows.append((OUTBOARD_CAUSES.get(cause, cause), OF_CAUSE[cause], parts))
    stacked(on, rows)
    named_rows(on, [bent.joint for bent in links])
    label_axes(on, "deflection of the link's tip [µm]")
    legend(figure)
    return figure
