"""The report of a bearing: a folder with report.html and result.json."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.report.folder import refuse_existing, write_whole
from lostmotion.report.page import contents

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.figures import Sheet
    from lostmotion.parts.bearing.examined import Examined


def write_bearing(sheet: Sheet, examined: Examined | None, out: str | Path, *, force: bool = False) -> Path:
    """Where does the sheet lie? Writes it into the folder `out`, whole or not at all; errors as `folder.write_whole`."""
    refuse_existing(out, force=force)
    drawn = []
    if examined is not None:
        from lostmotion.plots.bearing import bearing_plots

        drawn = bearing_plots(examined)
    return write_whole(contents(sheet, drawn), out, force=force)
