"""The report of a bearing: a folder with report.html and result.json."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.reporting.folder import refuse_existing, write_whole
from lostmotion.reporting.page import contents

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.analyses.bearing.bearing import Examined
    from lostmotion.reporting.sheet import Sheet


def write_bearing(sheet: Sheet, examined: Examined | None, out: str | Path, *, force: bool = False) -> Path:
    """Write the sheet into the folder `out`, whole or not at all, and return the folder; errors as `folder.write_whole`."""
    refuse_existing(out, force=force)
    drawn = []
    if examined is not None:
        from lostmotion.analyses.bearing.plots import bearing_plots

        drawn = bearing_plots(examined)
    return write_whole(contents(sheet, drawn), out, force=force)
