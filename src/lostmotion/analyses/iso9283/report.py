"""The report of an ISO 9283 sheet: a folder with report.html and result.json."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.analyses.iso9283.plots.sheet import iso_plots
from lostmotion.reporting.folder import refuse_existing, write_whole
from lostmotion.reporting.page import contents

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.analyses.iso9283.comparison import ComparedFigure
    from lostmotion.analyses.iso9283.measured import MeasuredRobot
    from lostmotion.analyses.iso9283.predicted import PredictedRobots
    from lostmotion.analyses.iso9283.warm_up import Drift
    from lostmotion.reporting.sheet import Sheet


def write_iso_report(
    sheet: Sheet,
    predicted: PredictedRobots | None,
    drifted: Drift | None,
    measured: MeasuredRobot | None,
    compared: list[ComparedFigure],
    out: str | Path,
    *,
    force: bool = False,
) -> Path:
    """Where does the sheet lie? Writes it into the folder `out`, whole or not at all; errors as `write_whole`."""
    refuse_existing(out, force=force)
    return write_whole(contents(sheet, iso_plots(predicted, drifted, measured, compared)), out, force=force)
