"""The report of a target: a folder with report.html and result.json."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.analyses.targets.plots import targets_plots
from lostmotion.reporting.folder import refuse_existing, write_whole
from lostmotion.reporting.page import contents

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.analyses.targets.targets import Targets
    from lostmotion.reporting.sheet import Sheet


def write_targets(sheet: Sheet, found: Targets, out: str | Path, *, force: bool = False) -> Path:
    """Where does the sheet lie? Writes it into the folder `out`; errors as `write_whole`."""
    refuse_existing(out, force=force)
    return write_whole(contents(sheet, targets_plots(found)), out, force=force)
