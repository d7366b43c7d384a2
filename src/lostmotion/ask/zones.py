"""Map the accuracy of an arm over its workspace, and find where work should stand."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lostmotion.ask.settings import sign_of, whole_seed
from lostmotion.ask.shown import Shown
from lostmotion.errors import refuse_argument

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    import xarray

    from lostmotion.arm import Arm
    from lostmotion.figures import Sheet
    from lostmotion.spatial import Floats
    from lostmotion.studies.zones.zones import Zones


def zones(
    arm: Arm,
    *,
    seed: int = 1,
    approach: str = "random",
    at: Sequence[float] | None = None,
    threads: int | None = None,
    progress: Callable[[str, int, int], None] | None = None,
    **asked: Any,  # noqa: ANN401 - the fields of a Wish
) -> AccuracyMap:
    """Where in its workspace is this arm how accurate, how much of it is good enough, and where should work stand?

    asked   lengths in m: cell=0.05 (edge of the cells), by="best", "mean" or "worst" (configuration of the arm that a cell is judged by), level=0.95,
            target=0.0005, box=(0.3, 0.2, 0.1), box_by_mean=True, turned=True (boxes at other yaws), clear=0.2 and floor=0.0 (boxes keep off the
            base's z axis and above a height), poses=131072 (sampled), per_cell=8 (looked at in each cell)
    seed, approach, threads   as in `study`; threads change no bit
    at      point (x, y, z), m, that the slices of the report go through; left out, the best place

    Over all robots and visits, first order, by sums over terms without sampling; the tool may stand in any direction. Raises InputError for what
    cannot be asked, cells too small, and a box with a side along an axis that the tool cannot move along.
    """
    from lostmotion.studies.zones.zones import Wish
    from lostmotion.studies.zones.zones import zones as look_over

    sign, seed = sign_of(approach), whole_seed(seed)
    known = Wish.__dataclass_fields__
    for name, value in asked.items():
        if name not in known:
            raise refuse_argument(name, value, "one of " + ", ".join(known), "box = (0.3, 0.2, 0.1)")
    point = None if at is None else np.asarray(at, dtype=float)
    if point is not None and (point.shape != (3,) or not np.isfinite(point).all()):
        raise refuse_argument("at", at, "a point (x, y, z), m", "at = (0.5, 0.0, 0.3)")
    workers = threads or os.cpu_count() or 1
    if workers < 1:
        raise refuse_argument("threads", threads, "at least 1", "threads = 2")
    return AccuracyMap(look_over(arm, Wish(**asked), seed=seed, approach=sign, threads=workers, progress=progress), point)


@dataclass(frozen=True, repr=False)
class AccuracyMap(Shown):
    """An accuracy map: `summary()`, `report("out/")`, `arrays()`, `result()`; `found` holds every number."""

    found: Zones
    at: Floats | None = None

    @property
    def sheet(self) -> Sheet:
        """Give every figure, as printed, reported and written."""
        from lostmotion.figures.zones import zones_sheet

        return zones_sheet(self.found)

    def report(self, out: str | Path, *, force: bool = False) -> Path:
        """Write report.html, result.json and arrays.nc into the folder `out`, whole or not at all; gives the folder.

        Raises OutputExistsError where the folder exists and `force` is not set.
        """
        from lostmotion.report.zones import write_zones

        return write_zones(self.sheet, self.found, out, self.at, force=force)

    def arrays(self) -> xarray.Dataset:
        """Give the map cell by cell with names, units and coordinates."""
        from lostmotion.arrays import map_dataset

        return map_dataset(self.found)

    def __repr__(self) -> str:
        """Tell in a line what was mapped."""
        return f"<AccuracyMap of '{self.found.arm.name}': {self.sheet.counts}>"
