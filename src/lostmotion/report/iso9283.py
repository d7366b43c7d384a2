"""The report of an ISO 9283 sheet: a folder with report.html and result.json."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.plots.iso9283 import iso_plots
from lostmotion.report.folder import refuse_existing, write_whole
from lostmotion.report.page import contents

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.figures import Sheet
    from lostmotion.studies.iso9283.compared import Compared
    from lostmotion.studies.iso9283.measured import Measured
    from lostmotion.studies.iso9283.predicted import Predicted
    from lostmotion.studies.iso9283.warm_up import Drift


def write_iso(
    sheet: Sheet,
    predicted: Predicted | None,
    drifted: Drift | None,
    measured: Measured | None,
    compared: list[Compared],
    out: str | Path,
    *,
    force: bool = False,
) -> Path:
    """Where does the sheet lie? Writes it into the folder `out`, whole or not at all; errors as `write_whole`."""
    refuse_existing(out, force=force)
    return write_whole(contents(sheet, iso_plots(predicted, drifted, measured, compared)), out, force=force)
