"""Report of an arm at rest: a folder with report.html and result.json."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.analyses.statics.plots import statics_plots
from lostmotion.reporting.folder import refuse_existing, write_whole
from lostmotion.reporting.page import contents

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.analyses.statics.survey import Survey
    from lostmotion.reporting.sheet import Sheet


def write_statics(sheet: Sheet, found: Survey, out: str | Path, *, force: bool = False) -> Path:
    """Where does the sheet lie? Writes it into the folder `out`, whole or not at all; errors as `folder.write_whole`."""
    refuse_existing(out, force=force)
    return write_whole(contents(sheet, statics_plots(found)), out, force=force)
