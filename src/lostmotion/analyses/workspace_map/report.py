"""The report of an accuracy map: a folder with report.html, result.json and the map itself as arrays.nc."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.analyses.workspace_map.arrays import map_dataset
from lostmotion.analyses.workspace_map.plots import zones_plots
from lostmotion.reporting.folder import refuse_existing, write_whole
from lostmotion.reporting.page import contents

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.analyses.workspace_map.map import Zones
    from lostmotion.reporting.sheet import Sheet
    from lostmotion.spatial import Floats


def write_zones(sheet: Sheet, found: Zones, out: str | Path, at: Floats | None = None, *, force: bool = False) -> Path:
    """Where does the map lie? Writes it into the folder `out`, with slices through the point `at` (3,), m; errors as `write_whole`."""
    refuse_existing(out, force=force)
    said = contents(sheet, zones_plots(found, at))
    return write_whole({**said, "arrays.nc": bytes(map_dataset(found).to_netcdf(engine="scipy"))}, out, force=force)
