"""The report of a gearbox: a folder with report.html and result.json, and the profile of a cycloidal one as profile.dxf."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from lostmotion.report.folder import refuse_existing, write_whole
from lostmotion.report.page import contents

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.figures import Sheet
    from lostmotion.studies.gear import GearStudy


def write_gearbox(sheet: Sheet, study: GearStudy, drawing: bytes | None, out: str | Path, *, force: bool = False) -> Path:
    """Where does the sheet lie? Writes it into the folder `out`, whole or not at all; errors as `folder.write_whole`."""
    from lostmotion.plots.gearbox import gearbox_plots

    refuse_existing(out, force=force)
    drawn = gearbox_plots(study)
    if drawing is None:
        return write_whole(contents(sheet, drawn), out, force=force)
    sheet = replace(sheet, drawing="the profiles of disc and ring in mm")
    return write_whole({**contents(sheet, drawn), "profile.dxf": drawing}, out, force=force)
