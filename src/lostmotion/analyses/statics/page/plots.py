"""Plots of an arm at rest: holding torques by cause, compliance over the poses, compliance
ellipsoid, compliance by part.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.poses import reachable_points
from lostmotion.mechanism.load_causes import CAUSES
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.chart import (
    axes,
    axes_by_unit,
    figure,
    grouped,
    label_axes,
    legend,
    named_rows,
    one,
    stacked,
)
from lostmotion.reporting.palette import LIGHT, OF_CAUSE
from lostmotion.reporting.plot import Plot
from lostmotion.reporting.section import SECTION_TEXT, PoseValues, sections

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lostmotion.loads.payload import MaxPayload, PayloadLimit
    from lostmotion.loads.survey import Survey
    from lostmotion.mechanism.elastostatics import Ellipsoid
    from lostmotion.spatial import Floats

_PARTS_SHOWN: Final = 15


def statics_plots(survey: Survey, payload: MaxPayload | None = None) -> list[Plot]:
    """Return the plots in reading order; a rigid arm has none of compliance."""
    drawn = (
        []
        if payload is None
        else [plot for each in payload.limits for plot in _payloads(survey, each)]
    )
    drawn += [
        Plot(
            "causes",
            "causes",
            causes(survey),
            "Stacked bars of each joint's largest holding torque by cause.",
        )
    ]
    if survey.parts:
        drawn += [
            Plot(f"compliance-{name}", "map", section, SECTION_TEXT[name])
            for name, section in sections(compliances(survey))
        ]
        drawn += [
            Plot(
                "ellipsoid",
                "ellipsoid",
                ellipsoid_plot(survey),
                "Compliance ellipsoids at the most compliant pose, rotation free and constrained.",
            ),
            Plot(
                "shares",
                "shares",
                shares(survey),
                "Bars of each part's share of the compliance, mean and at the most compliant pose.",
            ),
        ]
    return drawn


def _payloads(survey: Survey, limit: PayloadLimit) -> list[Plot]:
    """Return the sections of the workspace in classes of the largest payload by one criterion; none
    where a pose has no limit.
    """
    if not np.isfinite(limit.values).all() or not np.ptp(limit.values) > 0:
        return []
    what = f"largest payload by {limit.criterion}"
    shown = PoseValues(
        survey.arm,
        limit.tool,
        limit.values,
        what,
        "kg",
        limit.worst,
        "smallest",
        reachable_points(survey.arm),
    )
    return [
        Plot(f"payload-{limit.criterion}-{name}", "payload", drawn, f"{what}: {SECTION_TEXT[name]}")
        for name, drawn in sections(shown)
    ]


def causes(survey: Survey) -> Figure:
    """Plot the largest holding torque of each drive by cause; causes that relieve the drive are
    negative.
    """
    kinds = {
        unit: [node for node in survey.joint_loads if node.unit == unit] for unit in ("N m", "N")
    }
    tilt = "any tilt of the base" if survey.tilt is None else "worst tilt of the base"
    made, panels = axes_by_unit(
        f"Largest holding torques, {tilt}", {unit: len(nodes) for unit, nodes in kinds.items()}
    )
    for unit, on in panels.items():
        loads = [node.required for node in kinds[unit]]
        least = 1e-9 * max(abs(load.value) for load in loads)
        rows = [
            (
                cause,
                OF_CAUSE[cause],
                np.array([np.sign(load.value) * load.by_cause.get(cause, 0.0) for load in loads]),
            )
            for cause in CAUSES
        ]
        stacked(on, [row for row in rows if (np.abs(row[2]) > least).any()])
        named_rows(on, [node.joint for node in kinds[unit]])
        label_axes(on, f"holding {'torque' if unit == 'N m' else 'force'} [{unit}]")
    legend(made)
    return made


def compliances(survey: Survey) -> PoseValues:
    """Return the compliance along the most compliant direction at each pose, with the most
    compliant pose marked.
    """
    values, marked = survey.max_compliance * 1e6, (survey.softest_pose, "most compliant pose")
    return PoseValues(
        survey.arm,
        survey.tool_positions,
        values,
        "largest compliance",
        "µm/N",
        *marked,
        reachable_points(survey.arm),
    )


def ellipsoid_plot(survey: Survey) -> Figure:
    """Plot the outlines of the compliance ellipsoids (µm/N) at the most compliant pose along each
    axis of the base, rotation free and constrained.
    """
    made = figure(62)
    reach = 1.08e6 * float(survey.translational.values[0, 0])
    views = ((0, 1), (0, 2), (1, 2))
    for on, (across, up) in zip(
        axes(made, f"Compliance ellipsoid at pose {survey.softest_pose}", columns=len(views))[0],
        views,
        strict=True,
    ):
        for ellipsoid, colour, name in (
            (survey.translational, LIGHT["robot"], "free to rotate"),
            (survey.guided, LIGHT["design"], "rotation constrained"),
        ):
            x, y = _outline(ellipsoid, across, up)
            on.fill(x, y, color=colour, alpha=0.25, linewidth=0)
            on.plot(x, y, color=colour, linewidth=1.4, label=name)
        on.set_xlim(-reach, reach)
        on.set_ylim(-reach, reach)
        on.set_aspect("equal")
        on.locator_params(nbins=4)
        label_axes(on, f"{'xyz'[across]} [µm/N]", f"{'xyz'[up]} [µm/N]")
    legend(made)
    return made


def _outline(ellipsoid: Ellipsoid, across: int, up: int) -> tuple[Floats, Floats]:
    """Return the outline of an ellipsoid seen along one axis of the base, µm/N.

    The shadow of {R diag(v) u, |u| <= 1} on a plane is the ellipse of the square root of that block
    of R diag(v^2) R'.
    """
    half = ellipsoid.directions[0] * ellipsoid.values[0] * 1e6
    block = (half @ half.T)[np.ix_([across, up], [across, up])]
    values, directions = np.linalg.eigh(block)
    turn = np.linspace(0, 2 * np.pi, 61)
    x, y = directions @ (
        np.sqrt(np.maximum(values, 0.0))[:, None] * np.stack([np.cos(turn), np.sin(turn)])
    )
    return x, y


def shares(survey: Survey) -> Figure:
    """Plot each part's share of the compliance, mean over poses and at the most compliant pose, the
    largest first.
    """
    order = np.argsort(-survey.shares, kind="stable")[:_PARTS_SHOWN]
    made, on = one("Share of compliance by part", 30 + 7.5 * len(order))
    both = (
        ("mean over poses", LIGHT["robot"], survey.shares),
        ("most compliant pose", LIGHT["design"], survey.softest_shares),
    )
    grouped(on, [(name, colour, 100 * values[order]) for name, colour, values in both])
    named_rows(on, [short_name(survey.parts[k]) for k in order])
    label_axes(on, "share of compliance [%]")
    legend(made)
    return made
