"""An accuracy map with its sheet, plots and arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.result import Result
from lostmotion.analyses.workspace_map.page.labels import (
    configuration_label,
    configurations_label,
    edge_label,
    figure_over_cells,
    level_label,
    percentile_label,
    placement_label,
    share_within,
)
from lostmotion.analyses.workspace_map.page.tables import (
    budget_section,
    map_section,
    no_placement_sentence,
    placement_facts,
    placement_section,
    placement_sentence,
    reach_section,
    within_section,
)
from lostmotion.error_model.provenance import States, states
from lostmotion.error_model.upper_limits import with_limits
from lostmotion.maps.accuracy_map import WorkspaceMap
from lostmotion.maps.cell_statistics import CONFIGURATIONS, MEAN, QUANTILE
from lostmotion.reporting.arm_sheet import with_arm
from lostmotion.reporting.first_order import with_falls
from lostmotion.reporting.labelled_arrays import LabelledArrays
from lostmotion.reporting.provenance import (
    as_known,
    at_least,
    caveats,
    share_within_bounded,
)
from lostmotion.reporting.sheet import Card, Cell, Sheet, length, several

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import xarray

    from lostmotion.reporting.plot import Plot
    from lostmotion.spatial import Floats

_WORDS: Final = (
    (
        "cell",
        (
            "a cube of the grid, with the error at its centre; where the centre is out of reach, "
            "at the points reached."
        ),
    ),
    (
        "best, mean, worst",
        (
            "over the arm configurations in a cell. Best and worst are one-sided bounds that "
            "change with more configurations; the mean does not."
        ),
    ),
    (
        "position error",
        (
            "distance between commanded and attained position of the tool point, over all robots "
            "and visits."
        ),
    ),
    (
        "configuration",
        (
            "joint values with the tool point there, in any orientation of the tool. Obstacles, "
            "floor and self-collision are not checked."
        ),
    ),
    (
        "validation points",
        "a lattice over the box, corners included, with other poses than those of the map.",
    ),
    (
        "share",
        (
            "of the mean-square error over the poses on which the zone's figures are based, exact "
            "sums over terms. Shares add to 100 %."
        ),
    ),
)


def map_sheet(mapped: WorkspaceMap, at: Floats | None = None) -> Sheet:
    """Return the sheet of an accuracy map, with slices through the point `at` (3,), m."""
    known = with_limits(states(mapped.arm), mapped.arm, mapped.reached.q)
    sections = (
        map_section(mapped),
        within_section(mapped),
        placement_section(mapped),
        budget_section(mapped),
        reach_section(mapped),
    )
    return with_arm(
        Sheet(
            subject="accuracy map",
            verdict=with_falls(_verdict(mapped, known), mapped.arm),
            cards=tuple(_cards(mapped, known)),
            sections=tuple(section for section in sections if section is not None),
            counts=(
                f"{several(int(np.isfinite(mapped.selected).sum()), 'cell')} of "
                f"{edge_label(mapped)}, {configurations_label(mapped)}"
            ),
            notes=(*_remarks(mapped), *_point_off_map(mapped, at)),
            words=_WORDS,
            source=f"{mapped.reached.sampled} poses sampled (sobol), {len(mapped.reached.q)} "
            f"evaluated, seed {mapped.seed}. "
            "The same file, version, seed and options give the same bytes.",
            arrays="the map, cell by cell",
            seed=mapped.seed,
            facts=_facts(mapped),
        ),
        mapped.arm,
        known,
        sections=("map", "within", "places"),
    )


def _verdict(mapped: WorkspaceMap, known: States) -> str:
    least, middle, most = (_over_shown(mapped, known, what) for what in (np.min, np.median, np.max))
    text = f"{level_label(mapped)} of positions ({configuration_label(mapped)}) are within "
    if str(least) == str(most):
        text += f"{at_least(least, known)} in every cell."
    else:
        text += (
            f"{at_least(middle, known)} in the median cell, {least} in the most accurate and "
            f"{most} in the least accurate one."
        )
    if mapped.within_target is not None:
        text += f" {_share_sentence(mapped, mapped.within_target.target, known)}"
    if mapped.placements is not None:
        text += " " + placement_sentence(mapped.placements, mapped, known)
    return " ".join([text, *caveats(known)])


def _over_shown(mapped: WorkspaceMap, known: States, what: Callable[[Floats], float]) -> Cell:
    column = CONFIGURATIONS.index(mapped.by)
    return as_known(figure_over_cells(mapped, QUANTILE, column, what), known)


def _share_sentence(mapped: WorkspaceMap, target: float, known: States) -> str:
    share, _ = share_within(mapped, target)
    text = share_within_bounded(
        f"{100 * share.value:.3g} % ({100 * share.low:.3g} … {100 * share.high:.3g}) "
        "of the workspace",
        known,
    )
    return f"{text[0].upper()}{text[1:]} is within {length(target, stated=True)}."


def _cards(mapped: WorkspaceMap, known: States) -> list[Card]:
    least, middle, most = (_over_shown(mapped, known, what) for what in (np.min, np.median, np.max))
    out = [
        Card(
            f"{percentile_label(mapped)}, median cell",
            str(middle),
            configuration_label(mapped),
            limited_as="error",
        ),
        Card(
            "most accurate cell",
            str(least),
            f"least accurate {at_least(most, known)}",
            limited_as="error",
        ),
    ]
    if mapped.within_target is not None:
        share, _ = share_within(mapped, mapped.within_target.target)
        out.append(
            Card(
                f"within {length(mapped.within_target.target, stated=True)}",
                share_within_bounded(f"{100 * share.value:.3g} %", known),
                f"of the workspace, {100 * share.low:.3g} … {100 * share.high:.3g} %",
            )
        )
    if mapped.placements is not None and mapped.placements.best:
        box = mapped.placements.best[0]
        out.append(
            Card(
                "best placement",
                str(as_known(length(box.validated_worst), known)),
                f"{placement_label(box)}; worst validation point",
                limited_as="error",
            )
        )
    return out


def _remarks(mapped: WorkspaceMap) -> list[str]:
    out = ["any orientation of the tool; obstacles, floor and self-collision are not checked"]
    if mapped.uncertain.any():
        cells = several(int(mapped.uncertain.sum()), "cell")
        out.append(
            f"{cells} without a valid figure: a few two-valued errors dominate. Monte Carlo "
            "(lostmotion study) shows the distribution there"
        )
    for box in () if mapped.placements is None else mapped.placements.best:
        if box.validation_reached < box.validation_points:
            missed = box.validation_points - box.validation_reached
            out.append(
                f"placement at {placement_label(box)}: {missed} of {box.validation_points} "
                "validation points were not reached"
            )
    return out


def _point_off_map(mapped: WorkspaceMap, at: Floats | None) -> list[str]:
    """Return a note where the slices were requested through a point that no pose reaches."""
    if at is None:
        return []
    grid = mapped.reached.grid
    number = int(
        grid.cell_numbers(np.where(grid.flat, np.nan_to_num(np.array(grid.plane)), at)[None])[0]
    )
    on_plane = bool(
        np.allclose(at[grid.flat], np.array(grid.plane)[grid.flat], rtol=0, atol=grid.edge / 2)
    )
    point = (
        ", ".join(f"{axis} {value * 1e3:.6g}" for axis, value in zip("xyz", at, strict=True))
        + " mm"
    )
    if number >= 0 and on_plane and mapped.reached.counts.flat[number]:
        return []
    if number >= 0 and on_plane:
        return [f"no pose found in the cell of the point {point} of the slices"]
    high = grid.low + grid.edge * np.array(grid.shape)
    extent = (
        ", ".join(
            f"{axis} {a * 1e3:.4g} … {b * 1e3:.4g}"
            for axis, a, b in zip("xyz", grid.low, high, strict=True)
        )
        + " mm"
    )
    return [f"the point {point} is outside the map ({extent}): the slices show the nearest cells"]


def _facts(mapped: WorkspaceMap) -> dict[str, Any]:
    grid = mapped.reached.grid
    facts: dict[str, Any] = {
        "by": mapped.by,
        "level": mapped.level,
        "seed": mapped.seed,
        "cell_m": grid.edge,
        "cells": int(np.isfinite(mapped.selected).sum()),
        "low_m": grid.low.tolist(),
        "shape": list(grid.shape),
        "poses": {
            "sampled": mapped.reached.sampled,
            "looked_at": len(mapped.reached.q),
            "per_cell_asked": mapped.per_cell,
        },
    }
    if mapped.within_target is not None:
        facts["target_m"] = mapped.within_target.target
    return facts if mapped.placements is None else facts | placement_facts(mapped.placements)


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
        return map_sheet(self, self.at)

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.workspace_map.page.plots import map_plots

        return map_plots(self, self.at)

    @property
    def failure(self) -> str:
        """Return that no placement of the box is within reach, where that is so; else nothing."""
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
