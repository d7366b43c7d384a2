"""The figures of an accuracy map: the error over the cells, how much of the workspace is good enough, where work should stand, who is to blame."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.figures import Card, Figure, Row, Section, Sheet, length
from lostmotion.studies.intervals import Estimate
from lostmotion.studies.zones.afresh import of_count
from lostmotion.studies.zones.by_cell import BYS, MEAN, QUANTILE

if TYPE_CHECKING:
    from collections.abc import Iterable

    from lostmotion.spatial import Floats
    from lostmotion.studies.zones.boxes import Box, Boxes
    from lostmotion.studies.zones.zones import Zones

_UNITS: Final = {3: "m³", 2: "m²", 1: "m"}
# Shares of the workspace for which the error that they stay within is told.
_SHARES: Final = (0.1, 0.5, 0.9)
# Share of raised figures from which it is said before all else.
_MANY: Final = 0.05
_WORDS: Final = (
    ("cell", "a cube of the grid. Its error is that at its middle; where only a part of the cell is in reach, at the points reached."),
    (
        "best, mean, worst",
        "over the arm configurations looked at in a cell. Best and worst are bounds, from one side, and move on with more poses; the mean does not.",
    ),
    ("position error", "distance between the point the tool was sent to and the point it reaches, over all robots and visits together."),
    (
        "configuration",
        "joint values that bring the tool point there; the tool may stand in any direction. No obstacle, floor or self-collision counts.",
    ),
    ("afresh", "at the points of another lattice over the box, its corners included, with other poses than those of the map."),
    ("share", "of the mean-square error over the poses that the zone's figures rest on, exact sums over terms. Shares add to 100 %."),
)


def zones_sheet(found: Zones, at: Floats | None = None) -> Sheet:
    """What is there to say about an accuracy map, with slices through the point `at` (3,), m?"""
    return Sheet(
        name=found.arm.name,
        subject="accuracy map",
        verdict=_verdict(found),
        cards=tuple(_cards(found)),
        sections=tuple(section for section in (_map(found), _within(found), _places(found), _budget(found), _reach(found)) if section is not None),
        counts=f"{_cells(found)} of {edge_said(found)}, {_per_cell(found)}",
        notes=(*found.arm.remarks, *_remarks(found), *_off_the_map(found, at)),
        words=_WORDS,
        source=f"{found.reached.sampled} poses sampled (sobol), {len(found.reached.q)} looked at, seed {found.seed}. "
        "The same file, version, seed and options give the same bytes.",
        arrays="the map, cell by cell",
        seed=found.seed,
        facts=_facts(found),
    )


def level_said(found: Zones) -> str:
    """Name the share of errors that the figures are of."""
    return f"{100 * found.level:.6g} %"


def by_said(found: Zones) -> str:
    """Name the configuration that cells are judged by."""
    return "mean over configurations" if found.by == "mean" else f"{found.by} configuration"


def edge_said(found: Zones) -> str:
    """Name the cells' edge as it was asked for."""
    return f"{found.reached.grid.edge * 1e3:.6g} mm"


def place_said(box: Box) -> str:
    """Name a place by its middle, and its yaw where it is turned."""
    text = ", ".join(f"{axis} {value * 1e3:.0f}" for axis, value in zip("xyz", box.centre, strict=True)) + " mm"
    return text + (f", yaw {math.degrees(box.yaw):.0f}°" if box.yaw else "")


def size_said(size: Iterable[float]) -> str:
    """Name a box by its sides."""
    return " x ".join(f"{side * 1e3:.4g}" if side < 10 else f"{side * 1e3:.0f}" for side in size) + " mm"  # noqa: PLR2004 - no powers of ten


def _known(found: Zones) -> np.ndarray:
    return found.centre & np.isfinite(found.shown)


def _cells(found: Zones) -> str:
    return f"{int(np.isfinite(found.shown).sum())} cells"


def _per_cell(found: Zones) -> str:
    counts = found.reached.counts[found.reached.counts > 0]
    return f"{_whole(float(np.median(counts)))} configurations in each (median; least {int(counts.min())})"


def _whole(value: float, samples: str = "") -> Figure:
    """Give a median of counts: a whole number, or one and a half."""
    return Figure(int(value) if value.is_integer() else value, "1", samples=samples)


def _drawn(found: Zones) -> str:
    afresh = found.afresh
    return "cells reached at their middle" if afresh is None else f"{len(afresh.points)} of {afresh.drawn} points drawn around are in reach"


def _unit(found: Zones) -> str:
    return _UNITS[max(found.reached.grid.dimensions, 1)]


def _verdict(found: Zones) -> str:
    values = found.shown[_known(found)]
    text = f"By the {by_said(found)}, {level_said(found)} of positions lie within {length(float(np.median(values)))} in the median cell"
    text += f", {length(float(values.min()))} in the most accurate one and {length(float(values.max()))} in the least accurate one."
    if found.within is not None:
        text += f" {_percent(found.within.share)} of the workspace is within {length(found.within.target)}."
    if found.boxes is not None:
        text += " " + boxes_said(found.boxes, found)
    return text


def boxes_said(boxes: Boxes, found: Zones) -> str:
    """Say where the box should stand, or that it fits nowhere, and which one would."""
    if boxes.found:
        box = boxes.found[0]
        return (
            f"Work of {size_said(boxes.size)} is best placed around {place_said(box)}: {level_said(found)} within {length(box.worst)} "
            f"in the worst of its cells ({len(box.cells)}); looked at afresh, {length(box.afresh_worst)}."
        )
    if boxes.largest is None:
        return f"No box of the proportions {size_said(boxes.size)} fits into the reach on this grid, however small."
    return f"No place within reach holds {size_said(boxes.size)}; the largest box of these proportions that fits here is {size_said(boxes.largest)}."


def _percent(share: Estimate) -> str:
    return f"{100 * share.value:.3g} % ({100 * share.low:.3g} … {100 * share.high:.3g})"


def _cards(found: Zones) -> list[Card]:
    values = found.shown[_known(found)]
    out = [
        Card(f"{level_said(found)} below, median cell", str(length(float(np.median(values)))), by_said(found)),
        Card("most accurate cell", str(length(float(values.min()))), f"least accurate {length(float(values.max()))}"),
    ]
    if found.within is not None:
        share = found.within.share
        out.append(
            Card(
                f"within {length(found.within.target)}",
                f"{100 * share.value:.3g} %",
                f"of the workspace, {100 * share.low:.3g} … {100 * share.high:.3g} %",
            )
        )
    if found.boxes is not None and found.boxes.found:
        box = found.boxes.found[0]
        out.append(Card("best place", str(length(box.afresh_worst)), f"{place_said(box)}; worst point, looked at afresh"))
    return out


def _map(found: Zones) -> Section:
    known = _known(found)
    counts = found.reached.counts[known]
    rows = []
    for measure, name in ((QUANTILE, f"{level_said(found)} below"), (MEAN, "mean error")):
        for k, by in enumerate(BYS):
            values, (low, high) = found.figures[measure, k][known], found.ends[:, measure, k][:, known]
            middle = _median(found, measure, k)
            shown = " (in the plots)" if measure == QUANTILE and by == found.by else ""
            for cell, at in (("most accurate cell", int(values.argmin())), ("median cell", None), ("least accurate cell", int(values.argmax()))):
                if at is None:
                    all_cells = f"{int(known.sum())} cells, {_per_cell(found)}"
                    rows.append(Row(f"{name}, {by}, {cell}", (length(*middle, samples=all_cells),), _counted_in_median(found)))
                    continue
                said = f"{counts[at]} configuration{'s' * int(counts[at] != 1)} in the cell"
                rows.append(Row(f"{name}, {by}, {cell}", (length(float(values[at]), float(low[at]), float(high[at]), said),), said + shown))
    note = (
        f"cells of {edge_said(found)} reached at their middle. Interval of a cell: what the sums over terms leave out, and of a mean over drawn "
        "configurations 95 % (Student); ?: more configurations may be better, or worse, without a limit known. Chosen as extremes, the two extreme "
        "cells stand a little too far out"
    )
    return Section("map", "Accuracy map", ("value",), tuple(rows), note)


def _median(found: Zones, measure: int, column: int) -> tuple[float, float, float]:
    """Give the median over the cells with ends that hold that over the workspace as well."""
    known = _known(found)
    value, ends = float(np.median(found.figures[measure, column][known])), found.ends[:, measure, column][:, known]
    # A cell of which nothing is known on one side may lie anywhere there; if that leaves the median nowhere to stand, nothing is known of it.
    low, high = (float(np.median(np.where(np.isnan(end), beyond, end))) for end, beyond in zip(ends, (-np.inf, np.inf), strict=True))
    low, high = (end if math.isfinite(end) else math.nan for end in (low, high))
    if found.afresh is not None:
        over = found.afresh.quantile(measure, BYS[column], 0.5)
        low = low if math.isnan(low + over.low) else min(low, over.low)
        high = high if math.isnan(high + over.high) else max(high, over.high)
    return value, low, high


def _counted_in_median(found: Zones) -> str:
    return f"{int(_known(found).sum())} cells" + ("" if found.afresh is None else f", {len(found.afresh.points)} points afresh")


def _within(found: Zones) -> Section:
    values = found.shown[_known(found)]
    unit, afresh = _unit(found), found.afresh
    counted = f"{len(values)} cells, {_per_cell(found)}" if afresh is None else f"{len(afresh.points)} points, {afresh.poses} poses"
    told = [] if found.within is None else [(found.within.target, found.within.share, found.within.size, "the target")]
    for part in _SHARES:
        error = float(np.quantile(values, part))
        if afresh is not None:
            told.append((error, *afresh.share(QUANTILE, found.by, error), ""))
        else:
            share = of_count(int((values <= error).sum()), len(values))
            size = Estimate(share.value * found.size.value, share.low * found.size.low, share.high * found.size.high)
            told.append((error, share, size, ""))
    rows = [
        Row(
            f"within {length(error)}",
            (
                Figure(100 * share.value, "%", 100 * share.low, 100 * share.high, counted),
                Figure(size.value, unit, size.low, size.high, counted),
            ),
            remark,
        )
        for error, share, size, remark in told
    ]
    note = f"by the {by_said(found)}, {level_said(found)} of errors. " + (
        "No point drawn in space is in reach (the workspace is next to a surface): shares of the cells, with intervals as if those were drawn"
        if afresh is None
        else f"At {len(afresh.points)} points drawn evenly over the workspace, looked at afresh; intervals of a count (Clopper and Pearson), "
        "from the points that are surely within to those that may be"
    )
    return Section("within", "How much of the workspace is how accurate", ("share", "size"), tuple(rows), note)


def _places(found: Zones) -> Section | None:
    boxes = found.boxes
    if boxes is None:
        return None
    title = f"Where work of {size_said(boxes.size)} should stand"
    if not boxes.found:
        return Section("places", title, ("value",), (), boxes_said(boxes, found))
    rows, places = [], []
    for number, box in enumerate(boxes.found, start=1):
        cells = f"{len(box.cells)} cells of the map"
        other = f"{box.afresh_reached} of {box.afresh_points} other points reached, {box.afresh_poses} other poses"
        low, high = (np.round(end, 9) + 0.0 for end in (box.centre - box.size / 2, box.centre + box.size / 2))  # no -0
        sides = ", ".join(f"{axis} {a * 1e3:.0f} … {b * 1e3:.0f}" for axis, a, b in zip("xyz", low, high, strict=True)) + " mm"
        sides = sides if not box.yaw else f"sides along x, y turned by {math.degrees(box.yaw):.0f}°"
        said = (
            ("worst cell", box.worst, cells),
            ("mean of cells", box.mean, cells),
            ("worst point, afresh", box.afresh_worst, other),
            ("mean, afresh", box.afresh_mean, other),
        )
        for (what, value, counted), (low, high) in zip(said, box.ends.T, strict=True):
            rows.append(Row(f"{number}. {what}", (length(value, float(low), float(high), counted),), _counts_said(box, afresh=counted == other)))
        places.append(f"{number}. around {place_said(box)}: {sides}")
    judged = "mean over its cells" if boxes.by_mean else "worst cell"
    turned = ", any yaw in steps of 15°" if boxes.turned else ""
    note = (
        f"{level_said(found)} of errors by the {by_said(found)}; judged by the {judged}; the best of all {boxes.tried} places on the grid"
        f"{turned} of which the tool was brought to every cell's middle and corners; no two share a cell"
    )
    note = "; ".join(places) + ". " + note + ". Interval: what the sums leave out, and of means over drawn configurations 95 % (Student)"
    if boxes.largest is not None:
        note += f". The largest box of these proportions in reach: {size_said(boxes.largest)}"
    return Section("places", title, ("value",), tuple(rows), note)


def _counts_said(box: Box, *, afresh: bool) -> str:
    if not afresh:
        return f"{len(box.cells)} cell{'s' * (len(box.cells) != 1)}"
    return f"{box.afresh_reached} of {box.afresh_points} points, {box.afresh_poses} poses"


def _budget(found: Zones) -> Section | None:
    if not found.budgets or not found.budgets[0].costs:
        return None
    first = found.budgets[0]
    shares = [{cost.part: cost.share for cost in each.costs} for each in found.budgets]
    said = [f"{each.poses} pose{'s' * (each.poses != 1)} in {each.cells} cell{'s' * (each.cells != 1)}: {each.zone}" for each in found.budgets]
    rows = [Row("r.m.s. error", tuple(length(each.rms, samples=counted) for each, counted in zip(found.budgets, said, strict=True)), "of the zone")]
    for cost in first.costs:
        figures = tuple(Figure(100 * of.get(cost.part, 0.0), "%", samples=counted) for of, counted in zip(shares, said, strict=True))
        rows.append(Row(cost.part.removeprefix("joints."), figures))
    note = f"shares of the mean-square error, exact sums over terms at the poses that the figures rest on ({by_said(found)}); the dearest first"
    return Section("budget", "Which part is to blame, where", tuple(each.zone for each in found.budgets), tuple(rows), note)


def _reach(found: Zones) -> Section:
    reached, errors = found.reached, found.looked.errors
    counts = reached.counts[reached.counts > 0]
    poses = f"{len(reached.q)} poses looked at"
    rim = int(((reached.counts > 0) & ~reached.centre).sum())
    size = found.size
    rows = [
        Row("cells reached", (Figure(len(counts), "1"),), f"edge {edge_said(found)}"),
        Row("of them only in part", (Figure(rim, "1"),), "the middle is out of reach, or was not found"),
        Row(
            {3: "volume", 2: "area", 1: "length"}[max(reached.grid.dimensions, 1)],
            (Figure(size.value, _unit(found), size.low, size.high, _drawn(found)),) if size.value else (Figure(0.0, _unit(found)),),
            _drawn(found) if size.value else "the workspace is a surface on this grid",
        ),
        Row("poses sampled", (Figure(reached.sampled, "1"),), "Sobol sequences"),
        Row("poses brought by inverse kinematics", (Figure(int(reached.brought.sum()), "1"),), "from cells around"),
        Row("configurations in a cell, median", (_whole(float(np.median(counts)), poses),), "each once: those that differ"),
        Row(
            "cells with fewer than asked", (Figure(int((counts < found.per_cell).sum()), "1"),), f"least {int(counts.min())}, asked {found.per_cell}"
        ),
        Row("poses with both figures", (Figure(100 * float(errors.told.mean()), "%", samples=poses),), "near enough to normal"),
        Row(
            "poses with a raised figure",
            (Figure(100 * float(errors.careful.mean()), "%", samples=poses),),
            "normal law, raised by what departs from it",
        ),
        Row(
            "poses left out",
            (Figure(100 * float(1 - errors.known.mean()), "%", samples=poses),),
            "bounds alone: a few two-sided or wavy errors dominate",
        ),
        Row("cells with bounds alone", (Figure(int(found.bounded.sum()), "1"),), "an upper bound stands there"),
    ]
    return Section("reach", "What was looked at", ("value",), tuple(rows), "cells that are reached are all looked at; none is left unvisited")


def _remarks(found: Zones) -> list[str]:
    out = ["the tool may stand in any direction; obstacles, floor and self-collision are not looked at"]
    careful = float(found.looked.errors.careful.mean())
    if careful > _MANY:
        out.append(
            f"{100 * careful:.2g} % of the poses are not quite normal: their {level_said(found)} figures stand "
            "a little too high, as do map and places; "
            "intervals hold what they may be"
        )
    if found.bounded.any():
        out.append(
            f"{int(found.bounded.sum())} cells hold an upper bound: no pose there is near enough to normal. Monte Carlo (lostmotion run) tells more"
        )
    for box in () if found.boxes is None else found.boxes.found:
        if box.afresh_reached < box.afresh_points:
            missed = box.afresh_points - box.afresh_reached
            out.append(f"the place around {place_said(box)}: {missed} of {box.afresh_points} points looked at afresh were not reached")
    return out


def _off_the_map(found: Zones, at: Floats | None) -> list[str]:
    """Say where slices were asked for through a point that no pose reaches."""
    if at is None:
        return []
    grid = found.reached.grid
    number = int(grid.number(np.where(grid.flat, np.nan_to_num(np.array(grid.plane)), at)[None])[0])
    on_plane = bool(np.allclose(at[grid.flat], np.array(grid.plane)[grid.flat], rtol=0, atol=grid.edge / 2))
    point = ", ".join(f"{axis} {value * 1e3:.6g}" for axis, value in zip("xyz", at, strict=True)) + " mm"
    if number >= 0 and on_plane and found.reached.counts.flat[number]:
        return []
    if number >= 0 and on_plane:
        return [f"no pose was found that reaches the cell of the point {point}, through which the slices go"]
    high = grid.low + grid.edge * np.array(grid.shape)
    ends = ", ".join(f"{axis} {a * 1e3:.4g} … {b * 1e3:.4g}" for axis, a, b in zip("xyz", grid.low, high, strict=True)) + " mm"
    return [f"the point {point} is out of reach, beyond the map ({ends}): the slices go through the map's cells nearest to it"]


def _facts(found: Zones) -> dict[str, Any]:
    grid = found.reached.grid
    facts: dict[str, Any] = {
        "arm": found.arm.name,
        "by": found.by,
        "level": found.level,
        "seed": found.seed,
        "cell_m": grid.edge,
        "cells": int(np.isfinite(found.shown).sum()),
        "low_m": grid.low.tolist(),
        "shape": list(grid.shape),
        "poses": {"sampled": found.reached.sampled, "looked_at": len(found.reached.q), "per_cell_asked": found.per_cell},
    }
    if found.within is not None:
        facts["target_m"] = found.within.target
    if found.boxes is not None:
        facts["box_m"] = list(found.boxes.size)
        facts["largest_box_m"] = None if found.boxes.largest is None else found.boxes.largest.tolist()
        facts["places"] = [
            {
                "centre_m": box.centre.tolist(),
                "yaw_rad": box.yaw,
                "worst_m": box.worst,
                "mean_m": box.mean,
                "afresh_worst_m": _number(box.afresh_worst),
            }
            for box in found.boxes.found
        ]
    return facts


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
