"""The report of an arm that was sized: a folder with report.html, result.json and, where its limits or its target hold, the arm as sized.toml."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.analyses.sizing.plots.selection import aimed_plots
from lostmotion.analyses.sizing.plots.sizing import sizing_plots
from lostmotion.reporting.folder import refuse_existing, write_whole
from lostmotion.reporting.page import contents

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.analyses.sizing.sizing import Sizing
    from lostmotion.analyses.sizing.target_study import Aimed
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Sheet


def write_sizing(sheet: Sheet, found: Sizing, sized: str | None, out: str | Path, *, force: bool = False) -> Path:
    """Where does the sheet lie? Writes it, and the text of the sized arm where there is one, into the folder `out`; errors as `write_whole`."""
    return _written(sheet, sizing_plots(found), sized, out, force=force)


def write_aimed(sheet: Sheet, found: Aimed, sized: str | None, out: str | Path, *, force: bool = False) -> Path:
    """Do so for an arm whose parts were chosen for a target."""
    return _written(sheet, aimed_plots(found), sized, out, force=force)


def _written(sheet: Sheet, plots: list[Plot], sized: str | None, out: str | Path, *, force: bool) -> Path:
    refuse_existing(out, force=force)
    said = contents(sheet, plots)
    return write_whole(said if sized is None else {**said, "sized.toml": sized.encode()}, out, force=force)
