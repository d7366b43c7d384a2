"""The accuracy of an arm over its workspace, with its tables, plots and arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from lostmotion.analyses.result import Result, netcdf
from lostmotion.analyses.workspace_map.map import WorkspaceMap
from lostmotion.error_model.provenance import States, states

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray

    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Sheet
    from lostmotion.spatial import Floats


@dataclass(frozen=True, repr=False)
class AccuracyMap(WorkspaceMap, Result):
    """An accuracy map: every attribute of `WorkspaceMap`; the slices of the report go through the
    point `at` (3,), m.
    """

    at: Floats | None = None

    @property
    def states(self) -> States:
        """Return what is known of each joint: stated, assumed, or ideal, and the assumed values."""
        return states(self.arm)

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        from lostmotion.analyses.workspace_map.tables.map import map_sheet

        return map_sheet(self, self.at)

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.workspace_map.plots import map_plots

        return map_plots(self, self.at)

    @property
    def failure(self) -> str:
        """Return that no placement of the box is within reach, where that is so; else nothing."""
        from lostmotion.analyses.workspace_map.tables.placement import no_placement_sentence

        return (
            no_placement_sentence(self.placements)
            if self.placements is not None and not self.placements.best
            else ""
        )

    def arrays(self) -> xarray.Dataset:
        """Return the map cell by cell with names, units and coordinates."""
        from lostmotion.analyses.workspace_map.arrays import map_dataset

        return map_dataset(self)

    def files(self) -> dict[str, bytes]:
        """Return the map as arrays.nc."""
        return {"arrays.nc": netcdf(self.arrays())}
