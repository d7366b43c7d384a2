"""The plots of a study, one function each: where the arm reaches and errs, how errors spread, which
part is to blame, what the drives hold.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lostmotion.analyses.accuracy.page.arm_plots import (
    PicturedErrors,
    arm_in_workspace,
    sections_of,
)
from lostmotion.analyses.accuracy.page.budget_plots import (
    CAUSES_TEXT,
    LEVELS_TEXT,
    at_places,
    bending,
    budget,
    by_level,
    errors_in_zone,
    levels,
    waterfall,
)
from lostmotion.analyses.accuracy.page.zone import seen_in
from lostmotion.error_model.arrival import rp_name
from lostmotion.error_model.intervals import pooled_quantile
from lostmotion.error_model.robot_intervals import pooled_robots_quantile
from lostmotion.printed import factor_of, unit_of_length
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.histogram import binned, linear_bins
from lostmotion.reporting.chart import (
    axes,
    axes_by_unit,
    figure,
    grouped,
    histogram,
    label_axes,
    legend,
    mark,
    mark_at,
    named_rows,
    one,
)
from lostmotion.reporting.palette import LIGHT
from lostmotion.reporting.plot import Plot
from lostmotion.reporting.section import SECTION_TEXT, sections
from lostmotion.reporting.sheet import length

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

    from lostmotion.accuracy.answer import Answer


def plots(answer: Answer) -> list[Plot]:
    """Return the plots of this study. In reading order; AP and RP only where poses were visited
    twice, a budget only where parts err.
    """
    drawn: list[tuple[str, str, Callable[[Answer], Figure], str]] = [
        (
            "error-histogram",
            "error",
            error_histogram,
            (
                "Histogram of the position error over the workspace with its 50th, 95th and 99th "
                "percentile."
            ),
        ),
        (
            "ap-rp",
            "iso9283",
            accuracy_over_robots,
            "Histograms of AP and RP over the robots with the 95th percentile.",
        ),
        ("levels", "levels", lambda answer: levels(answer.budget), LEVELS_TEXT),
        (
            "waterfall",
            "waterfall",
            lambda answer: waterfall(answer.waterfall),
            (
                "Waterfall of the 95th percentile: as manufactured, less the effects of "
                "calibration, load compensation and mapping."
            ),
        ),
        (
            "budget",
            "budget",
            budget,
            "Bars of each part's share of the mean-square error, the largest on top.",
        ),
        (
            "causes",
            "causes",
            lambda answer: by_level(answer.budget.causes, "Share of mean square by kind of error"),
            CAUSES_TEXT,
        ),
        ("bending", "bending", bending, "Stacked bars of each link's largest deflection by cause."),
        (
            "torques",
            "torques",
            torques,
            (
                "Bars of the largest holding torque of each joint, as the base stands and over "
                "all tilts of the base."
            ),
        ),
    ]
    missing = {"ap-rp"} if answer.sampled.visits < 2 else set()  # noqa: PLR2004 - a scatter needs two
    missing |= set() if answer.sampled.tally.owners else {"levels", "waterfall", "budget", "causes"}
    missing |= set() if answer.bending else {"bending"}
    pictured = pose_errors(answer)
    cut = [
        Plot(f"workspace-{name}", "workspace", drawn, SECTION_TEXT[name])
        for name, drawn in sections(sections_of(pictured))
    ]
    places = at_places(answer.places)
    for k, zone in enumerate(answer.zones, start=1):
        words = (
            f"Histogram of the position error in the zone {zone.name} over that of the whole "
            "workspace."
        )
        places.append(Plot(f"zone-{k}", f"zone_{k}", errors_in_zone(answer, zone), words))
        if answer.sampled.visits > 1:
            inside = accuracy_over_robots(seen_in(answer, zone))
            places.append(
                Plot(
                    f"zone-{k}-ap-rp",
                    f"zone_{k}_iso9283",
                    inside,
                    f"Histograms of AP and RP over the robots in the zone {zone.name}.",
                )
            )
    shown = [
        Plot(key, section, draw(answer), words)
        for key, section, draw, words in drawn
        if key not in missing
    ]
    return [*arm_in_workspace(pictured), *cut, *shown, *places]


def pose_errors(answer: Answer) -> PicturedErrors:
    """Return the error at each pose for the pictures of the first screen."""
    table = answer.sampled.per_pose
    within = table[:, kernel.FIRST_QUANTILE + 3 * kernel.QUANTILES.index(0.95)]
    return PicturedErrors(
        answer.arm,
        answer.poses.q,
        answer.approach,
        answer.tool,
        table[:, kernel.MEAN],
        within,
        answer.workspace.points,
        answer.target,
    )


def error_histogram(answer: Answer) -> Figure:
    """Draw the histogram of the position error with its 50th, 95th and 99th percentiles and their
    95 % intervals.
    """
    sampled = answer.sampled
    edges, counts = linear_bins(sampled.replicate_hist.sum(axis=0))
    unit = unit_of_length(float(edges[-1]))
    factor = factor_of(unit)
    drawn, on = one("Position error over the workspace", 80)
    histogram(on, edges * factor, 100 * counts / counts.sum())
    if answer.target is not None:  # first, so that the words of the others hide its line
        mark_at(
            on,
            answer.target * factor,
            f"target {length(answer.target, stated=True)}",
            row=len(kernel.QUANTILES),
        )
    for k, level in enumerate(kernel.QUANTILES):
        mark(
            on,
            pooled_quantile(sampled.group_hist, sampled.replicate_hist, level),
            f"{100 * level:.0f}th percentile",
            unit,
            row=k,
        )
    label_axes(
        on,
        f"position error [{unit}]",
        f"samples per {float(edges[1] - edges[0]) * factor:.3g} {unit} [%]",
    )
    return drawn


def accuracy_over_robots(answer: Answer) -> Figure:
    """Draw histograms of AP and RP over the robots: each robot's mean over the poses, with the 95th
    percentile.

    Raises ValueError for a study of a single visit, which has no RP.
    """
    sampled = answer.sampled
    if sampled.visits < 2:  # noqa: PLR2004 - a scatter needs two
        raise ValueError(
            f"{sampled.visits} visit to each pose; AP and RP over robots need at least 2"
        )
    shown = [("AP", sampled.robot_means[:, :, 1], sampled.of_poses(1))]
    shown += [
        (rp_name(each.approach), each.robot_means, each.per_pose[:, 0])
        for each in answer.repeats
        if not each.none
    ]
    drawn = figure(14 + 26 * len(shown))
    panels = axes(drawn, "AP and RP of simulated robots", rows=len(shown))[:, 0]
    for on, (name, of_robots, at_poses) in zip(panels, shown, strict=True):
        values = of_robots.mean(axis=0)
        unit = unit_of_length(float(values.max()))
        factor = factor_of(unit)
        edges, counts = binned(values, about=max(min(30, round(2 * len(values) ** (1 / 3))), 5))
        histogram(on, edges * factor, counts, LIGHT["robot"] if name == "AP" else LIGHT["visit"])
        on.locator_params(axis="x", nbins=8)
        on.locator_params(axis="y", integer=True)
        mark(on, pooled_robots_quantile(of_robots, of_poses=at_poses), "95th percentile", unit)
        label_axes(on, f"{name} [{unit}]", "robots [1]")
    return drawn


def torques(answer: Answer) -> Figure:
    """Draw the largest holding torque (N m, or force in N) of each joint as the base stands, and
    over every tilt of the base.
    """
    kinds = {
        unit: [one for one in answer.worst_torques if one.unit == unit] for unit in ("N m", "N")
    }
    title = "Largest holding torque or force" if kinds["N"] else "Largest holding torque"
    drawn, panels = axes_by_unit(title, {unit: len(held) for unit, held in kinds.items()})
    for unit, on in panels.items():
        held = kinds[unit]
        standing, tilted = (
            np.array(values)
            for values in ([abs(one.worst) for one in held], [abs(one.over_tilts) for one in held])
        )
        grouped(
            on,
            [
                ("as the base stands", LIGHT["robot"], standing),
                ("worst over base tilts", LIGHT["design"], tilted),
            ],
        )
        named_rows(on, [one.joint for one in held])
        label_axes(on, f"holding {'torque' if unit == 'N m' else 'force'}, magnitude [{unit}]")
    legend(drawn)
    return drawn
