"""Map the accuracy of an arm over its workspace, and find where work should stand."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.arguments import an_arm, sign_of, whole_seed
from lostmotion.analyses.quantities import Three, amounts
from lostmotion.analyses.result import Shown
from lostmotion.error_model.provenance import refuse_undescribed, states
from lostmotion.errors import refuse_argument
from lostmotion.propagation.first_order import refuse_large_errors
from lostmotion.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    import xarray

    from lostmotion.analyses.quantities import Amounts
    from lostmotion.analyses.workspace_map.map import Zones
    from lostmotion.error_model.provenance import States
    from lostmotion.mechanism.arm import Arm
    from lostmotion.reporting.sheet import Sheet
    from lostmotion.spatial import Floats

# What of a map is an amount, and what it may be; an arm and its work are no larger than this.
_MOST: Final = 1000.0
AMOUNTS: Final[dict[str, Quantity | Three]] = {
    "cell": Quantity("m", "50 mm", above=0, high=_MOST),
    "target": Quantity("m", "0.5 mm", above=0, high=_MOST),
    "box": Three(Quantity("m", "300 mm", low=0, high=_MOST), "300 mm x 200 mm x 100 mm"),
    "clear": Quantity("m", "200 mm", low=0, high=_MOST),
    "floor": Quantity("m", "0 mm", low=-_MOST, high=_MOST),
    "at": Three(Quantity("m", "500 mm", low=-_MOST, high=_MOST), "500 mm, 0 mm, 300 mm"),
    "level": Quantity("", "95 %", low=0.25, high=0.9995),
}


def zones(
    arm: Arm,
    *,
    seed: int = 1,
    approach: str = "random",
    at: Amounts | str | None = None,
    threads: int | None = None,
    progress: Callable[[str, int, int], None] | None = None,
    **asked: Any,  # noqa: ANN401 - the fields of a Wish
) -> AccuracyMap:
    """Where in its workspace is this arm how accurate, how much of it is good enough, and where should work stand?

    asked   cell="50 mm" (edge of the cells), by="best", "mean" or "worst" (configuration of the arm that a cell is judged by), level=0.95,
            target="0.5 mm", box=("300 mm", "200 mm", "100 mm"), box_by_mean=True, turned=True (boxes at other yaws), clear="200 mm" and floor=0.0
            (boxes keep off the base's z axis and above a height), poses=131072 (sampled), per_cell=8 (looked at in each cell). Lengths are amounts:
            text with a unit, or m
    seed, approach, threads   as in `study`; threads change no bit
    at      point ("500 mm", 0, "300 mm") that the slices of the report go through, amounts; left out, the best place

    Over all robots and visits, first order, by sums over terms without sampling; the tool may stand in any direction. Raises InputError for what
    cannot be asked, cells too small, and a box with a side along an axis that the tool cannot move along.
    """
    from lostmotion.analyses.workspace_map.map import Wish
    from lostmotion.analyses.workspace_map.map import zones as look_over

    arm, sign, seed = an_arm(arm), sign_of(approach), whole_seed(seed)
    known = Wish.__dataclass_fields__
    for name, value in asked.items():
        if name not in known:
            raise refuse_argument(name, value, "one of " + ", ".join(known), "box = (0.3, 0.2, 0.1)")
    read = amounts({**asked, "at": at}, AMOUNTS)
    point = np.asarray(read.pop("at")) if at is not None else None
    wish = Wish(**{name: read.get(name, value) for name, value in asked.items() if name in read or name not in AMOUNTS})
    workers = threads or os.cpu_count() or 1
    if workers < 1:
        raise refuse_argument("threads", threads, "at least 1", "threads = 2")
    refuse_undescribed(arm)
    refuse_large_errors(arm)
    return AccuracyMap(look_over(arm, wish, seed=seed, approach=sign, threads=workers, progress=progress), point)


@dataclass(frozen=True, repr=False)
class AccuracyMap(Shown):
    """An accuracy map: `summary()`, `report("out/")`, `arrays()`, `result()`; `found` holds every number."""

    found: Zones
    at: Floats | None = None

    @property
    def states(self) -> States:
        """Return what is known of each joint: stated, assumed, or ideal, and the assumed values."""
        return states(self.found.arm)

    @property
    def sheet(self) -> Sheet:
        """Give every figure, as printed, reported and written."""
        from lostmotion.analyses.workspace_map.tables.map import zones_sheet

        return zones_sheet(self.found, self.at)

    def report(self, out: str | Path, *, force: bool = False) -> Path:
        """Write report.html, result.json and arrays.nc into the folder `out`, whole or not at all; gives the folder.

        Raises OutputExistsError where the folder exists and `force` is not set.
        """
        from lostmotion.analyses.workspace_map.report import write_zones

        return write_zones(self.sheet, self.found, out, self.at, force=force)

    def arrays(self) -> xarray.Dataset:
        """Give the map cell by cell with names, units and coordinates."""
        from lostmotion.analyses.workspace_map.arrays import map_dataset

        return map_dataset(self.found)

    def __repr__(self) -> str:
        """Tell in a line what was mapped."""
        return f"<AccuracyMap of '{self.found.arm.name}': {self.sheet.counts}>"
