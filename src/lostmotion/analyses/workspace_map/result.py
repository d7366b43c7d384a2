"""The accuracy map of an arm, with its tables, plots and arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.analyses.result import Result
from lostmotion.error_model.provenance import States, states
from lostmotion.maps.accuracy_map import WorkspaceMap
from lostmotion.maps.cell_statistics import CONFIGURATIONS, MEAN, QUANTILE
from lostmotion.reporting.labelled_arrays import LabelledArrays

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray

    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Sheet
    from lostmotion.spatial import Floats


def arrays_of_map(accuracy_map: WorkspaceMap) -> LabelledArrays:
    """Return an accuracy map cell by cell, in SI, with units and long names; NaN where the tool
    does not reach.
    """
    grid, reached = accuracy_map.reached.grid, accuracy_map.reached
    space = ("x", "y", "z")
    share = f"{100 * accuracy_map.level:.6g} %"
    data: dict[str, object] = {}
    for k, by in enumerate(CONFIGURATIONS):
        configuration = "mean over the configurations" if by == "mean" else f"{by} configuration"
        for measure, name, text in (
            (MEAN, "error_mean", "mean position error"),
            (QUANTILE, "error_quantile", f"{share} quantile of the position error"),
        ):
            data[f"{name}_{by}"] = (
                space,
                accuracy_map.errors[measure, k],
                {"units": "m", "long_name": f"{text}, {configuration} in the cell"},
            )
    data["configurations"] = (
        space,
        reached.counts.astype(np.int32),
        {"units": "1", "long_name": "configurations evaluated in the cell"},
    )
    if accuracy_map.gain is not None:
        text = "how many times as far as at home an error of the drives moves the tool, at most"
        data["gain"] = space, accuracy_map.gain, {"units": "1", "long_name": text}
    flags = [
        (
            "centre_reached",
            reached.centre,
            "1 where the cell centre is in reach: the errors are those there",
        ),
        ("uncertain", accuracy_map.uncertain, "1 where no pose has both figures to 5 %"),
    ]
    if accuracy_map.within_target is not None:
        flags.append(
            (
                "within_target",
                accuracy_map.within_target.cells,
                (
                    f"1 where error_quantile_{accuracy_map.by} is within "
                    f"{accuracy_map.within_target.target:.6g} m"
                ),
            )
        )
    if accuracy_map.placements is not None:
        place = np.zeros(grid.shape, np.int8)
        for number, box in enumerate(accuracy_map.placements.best, start=1):
            place.ravel()[box.cells] = number
        flags.append(
            ("place", place, "rank of the placement of the box that the cell belongs to; 0 none")
        )
    for name, values, text in flags:
        data[name] = (space, values.astype(np.int8), {"units": "1", "long_name": text})
    coordinates = {
        axis: (
            axis,
            grid.centres_along(k),
            {"units": "m", "long_name": f"cell centre along {axis}, base frame"},
        )
        for k, axis in enumerate(space)
    }
    attributes = {
        "arm": accuracy_map.arm.name,
        "seed": str(accuracy_map.seed),
        "cell": grid.edge,
        "level": accuracy_map.level,
        "by": accuracy_map.by,
    }
    return LabelledArrays(data, coordinates, attributes)


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
        from lostmotion.analyses.workspace_map.page import map_sheet

        return map_sheet(self, self.at)

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.workspace_map.page.plots import map_plots

        return map_plots(self, self.at)

    @property
    def failure(self) -> str:
        """Return that no placement of the box is within reach, where that is so; else nothing."""
        from lostmotion.analyses.workspace_map.page.placements import no_placement_sentence

        return (
            no_placement_sentence(self.placements)
            if self.placements is not None and not self.placements.best
            else ""
        )

    def arrays(self) -> xarray.Dataset:
        """Return the map cell by cell with names, units and coordinates."""
        return arrays_of_map(self).dataset()

    def files(self) -> dict[str, bytes]:
        """Return the map as arrays.nc."""
        return {"arrays.nc": arrays_of_map(self).netcdf()}
