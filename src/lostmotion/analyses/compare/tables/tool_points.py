"""Table of the distance between the commanded tool points of arms at the same joint values."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from lostmotion.analyses.compare.tables.figures import EQUAL, ends, figure
from lostmotion.reporting.joint_values import joint_values
from lostmotion.reporting.sheet import Row, Section, length, several

if TYPE_CHECKING:
    from lostmotion.analyses.compare.comparison import Change, Comparison
    from lostmotion.analyses.compare.tool_points import ToolDistance


def commanded_tool_points(found: Comparison) -> list[Section]:
    """Return the table; none where no arm stands at the joint values of the first."""
    known = [
        (change.arm.label, change.apart) for change in found.changes if change.apart is not None
    ]
    if not known:
        return []
    poses = found.arms[0].poses
    counted = f"{several(len(poses), 'pose')} ({poses.law}), nominal geometry"
    several_arms = len(known) > 1
    places = [
        f"{f'{label}: ' if several_arms else ''}{_place(found, apart)}"
        for label, apart in known
        if not apart.is_zero
    ]
    aparts = [apart for _, apart in known]
    note = EQUAL if all(apart.is_zero for apart in aparts) else ""
    rows = [
        Row("mean", tuple(figure(apart.mean, "m", counted) for apart in aparts), note),
        Row("95th percentile", tuple(figure(apart.p95, "m", counted) for apart in aparts), note),
        Row(
            "largest",
            tuple(length(apart.largest, samples=counted) for apart in aparts),
            note or "; ".join(places),
        ),
    ]
    for k, axis in enumerate("xyz"):
        means = (length(float(apart.vectors[:, k].mean()), samples=counted) for apart in aparts)
        rows.append(Row(f"mean displacement along {axis}", tuple(means), note, f"mean_{axis}"))
    columns = tuple(f"{label} from {found.arms[0].label}" for label, _ in known)
    about = (
        "where the nominal geometry puts the tool, without any error, in the axes of the base; "
        "intervals are due to the choice of poses"
    )
    return [
        Section(
            "tool_points",
            "Distance of the commanded tool points at the same joint values",
            columns,
            tuple(rows),
            about,
        )
    ]


def _place(found: Comparison, apart: ToolDistance) -> str:
    """Return where the largest distance is: the pose, and the tool point of the first arm."""
    at = ", ".join(
        f"{axis} {length(float(value))}"
        for axis, value in zip("xyz", apart.tool[apart.largest_at], strict=True)
    )
    return (
        f"at {joint_values(found.arms[0].arm, found.arms[0].poses.q[apart.largest_at])}, tool at "
        f"{at}"
    )


def distance_facts(found: Comparison, change: Change) -> dict[str, Any] | None:
    """Return the distance of one arm from the first as plain data, in SI; None where they stand at
    different joint values.
    """
    apart = change.apart
    if apart is None:
        return None
    first, at = found.arms[0], apart.largest_at
    return {
        "arm": change.arm.label,
        "mean_m": ends(apart.mean),
        "p95_m": ends(apart.p95),
        "largest_m": apart.largest,
        "largest_at_joint_values": dict(
            zip(
                (joint.name for joint in first.arm.driven),
                map(float, first.poses.q[at]),
                strict=True,
            )
        ),
        "largest_at_m": list(map(float, apart.tool[at])),
        "mean_displacement_m": list(map(float, apart.vectors.mean(axis=0))),
    }
