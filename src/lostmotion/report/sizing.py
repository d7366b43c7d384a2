"""The report of an arm whose links were sized: a folder with report.html, result.json and, where its limits hold, the arm as sized.toml."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.plots.sizing import sizing_plots
from lostmotion.report.folder import refuse_existing, write_whole
from lostmotion.report.page import contents

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.figures import Sheet
    from lostmotion.studies.sizing import Sizing


def write_sizing(sheet: Sheet, found: Sizing, sized: str | None, out: str | Path, *, force: bool = False) -> Path:
    """Where does the sheet lie? Writes it, and the text of the sized arm where there is one, into the folder `out`; errors as `write_whole`."""
    refuse_existing(out, force=force)
    said = contents(sheet, sizing_plots(found))
    return write_whole(said if sized is None else {**said, "sized.toml": sized.encode()}, out, force=force)
