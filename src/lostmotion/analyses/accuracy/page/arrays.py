"""The labelled arrays of a study, every variable with its unit and meaning."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lostmotion.analyses.accuracy.page.zone import seen_in
from lostmotion.error_model.arrival import rp_key, rp_name
from lostmotion.mechanism.holding_torques import holding_torques
from lostmotion.mechanism.state import tool_points
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.histogram import linear_bins, share_intervals
from lostmotion.reporting.labelled_arrays import LabelledArrays, axes_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.accuracy.answer import Answer
    from lostmotion.accuracy.route import FoundInZone
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.analytic import Analytic
    from lostmotion.spatial import Floats


def arrays_of_study(answer: Answer) -> LabelledArrays:
    """Return the figures of a study per pose and per robot, in SI, with units and long names; those
    without sampling as `analytic_...`.
    """
    sampled = answer.sampled
    table = sampled.per_pose
    quantiles = table[:, kernel.FIRST_QUANTILE :].reshape(len(table), len(kernel.QUANTILES), 3)
    per_pose = {
        "error_mean": (table[:, kernel.MEAN], "m", "mean position error over robots and visits"),
        "error_mean_half_interval": (
            table[:, kernel.MEAN_ERROR],
            "m",
            "half of the 95 % interval of error_mean, counting robots",
        ),
        "error_rms": (
            np.sqrt(table[:, kernel.MEAN_SQUARE]),
            "m",
            "root mean square position error",
        ),
        "error_standard_deviation": (
            np.sqrt(np.maximum(table[:, kernel.MEAN_SQUARE] - table[:, kernel.MEAN] ** 2, 0.0)),
            "m",
            "standard deviation of the position error",
        ),
        "error_largest": (
            table[:, kernel.LARGEST],
            "m",
            f"largest of {sampled.robots * sampled.visits} samples",
        ),
        "largest_robot": (
            table[:, kernel.LARGEST_ROBOT].astype(np.int32),
            "1",
            "robot of error_largest",
        ),
        "largest_visit": (
            table[:, kernel.LARGEST_VISIT].astype(np.int32),
            "1",
            "visit of error_largest",
        ),
        "worst_case": (
            sampled.worst,
            "m",
            "bound: everything at its limit at once; infinite where an error has no limits",
        ),
        "root_sum_square": (sampled.rss, "m", "|bias| + root of the sum of squared limits"),
        "rotation_rms": (
            np.sqrt(sampled.rotation_ms),
            "rad",
            "root mean square rotation error of the tool",
        ),
    }
    data: dict[str, Any] = {
        name: ("pose", values, {"units": unit, "long_name": text})
        for name, (values, unit, text) in per_pose.items()
    }
    data |= _visited(answer.arm, answer.poses, answer.tool)
    data["holding_torque"] = (
        ("pose", "joint"),
        answer.torques,
        _of_joints(answer.arm, "N m", "N", "static torques of the drives"),
    )
    data["bias"] = (
        ("pose", "axis"),
        sampled.bias[:, 3:],
        {"units": "m", "long_name": "error common to all robots and visits"},
    )
    data["error_quantile"] = (
        ("pose", "level"),
        quantiles[:, :, 0],
        {"units": "m", "long_name": "position error not exceeded by this share of samples"},
    )
    for k, end in ((1, "low"), (2, "high")):
        text = f"{end} end of the 95 % interval of error_quantile, counting robots"
        data[f"error_quantile_{end}"] = (
            ("pose", "level"),
            quantiles[:, :, k],
            {"units": "m", "long_name": text},
        )
    if sampled.visits > 1:
        spread = [("ap", "pose accuracy AP", sampled.accuracy, sampled.robot_means[:, :, 1])]
        spread += [
            (
                rp_key(each.approach),
                f"pose repeatability {rp_name(each.approach)}",
                each.per_pose,
                each.robot_means,
            )
            for each in answer.repeats  # one of them may be of a part of the poses and robots
            if len(each.poses) == len(answer.poses) and each.robots == sampled.robots
        ]
        for name, text, values, of_robots in spread:
            data[f"{name}_mean"] = (
                "pose",
                values[:, 0],
                {"units": "m", "long_name": f"{text}, mean over robots"},
            )
            data[f"{name}_95"] = (
                "pose",
                values[:, 1],
                {"units": "m", "long_name": f"{text}, 95th percentile of robots"},
            )
            data[f"{name}_95_low"] = (
                "pose",
                values[:, 2],
                {"units": "m", "long_name": f"low end of the 95 % interval of {name}_95"},
            )
            data[f"{name}_95_high"] = (
                "pose",
                values[:, 3],
                {"units": "m", "long_name": f"high end of the 95 % interval of {name}_95"},
            )
            data[f"robot_{name}"] = (
                "robot",
                of_robots.mean(axis=0),
                {"units": "m", "long_name": f"{text} of each robot, average over poses"},
            )
    data["robot_error_mean"] = (
        "robot",
        sampled.robot_means[:, :, 0].mean(axis=0),
        {"units": "m", "long_name": "mean position error of each robot over poses and visits"},
    )
    edges, counts = linear_bins(sampled.group_hist.sum(axis=0))
    data["error_histogram"] = (
        "bin",
        counts.astype(np.float64),
        {"units": "1", "long_name": "samples of all poses whose position error falls into the bin"},
    )
    for column, (name, text) in enumerate(
        (
            ("", "share of all samples"),
            ("_low", "low end of its 95 % interval"),
            ("_high", "high end"),
        )
    ):
        shares = share_intervals(sampled.group_hist, edges)[:, column]
        data[f"error_share{name}"] = (
            "bin",
            shares,
            {"units": "1", "long_name": f"{text}, counting robots"},
        )
    data["bin_low"] = (
        "bin",
        edges[:-1],
        {"units": "m", "long_name": "least position error of the bin"},
    )
    data["bin_high"] = (
        "bin",
        edges[1:],
        {"units": "m", "long_name": "largest position error of the bin"},
    )
    coordinates = {**_axes(answer.arm), "level": list(kernel.QUANTILES)}
    if answer.analytic is not None:
        data |= _summed(answer.analytic, "analytic_")
        coordinates |= {"with_axis": list("xyz"), "analytic_level": list(answer.analytic.levels)}
    for k, zone in enumerate(answer.zones, start=1):
        q = zone.poses.q
        inside = replace(
            seen_in(answer, zone),
            tool=tool_points(answer.arm, q),
            torques=holding_torques(answer.arm, q)[0],
        )
        data |= _of_zone(arrays_of_study(inside), f"zone_{k}")
    attributes = {
        "arm": answer.arm.name,
        "seed": str(answer.seed),  # NetCDF 3 has no long whole numbers
        "robots": sampled.robots,
        "visits": sampled.visits,
        "pose_law": answer.poses.law,
        **_zone_attributes(answer.zones),
    }
    return LabelledArrays(data, coordinates, attributes)


def arrays_without_sampling(
    arm: Arm, poses: Poses, analytic: Analytic, zones: Sequence[FoundInZone] = ()
) -> LabelledArrays:
    """Return the figures without sampling of every pose, in SI, with units and long names, each
    with its uncertainty.
    """
    data = {**_visited(arm, poses, tool_points(arm, poses.q)), **_summed(analytic)}
    for k, zone in enumerate(zones, start=1):
        if zone.analytic is not None:
            data |= _of_zone(arrays_without_sampling(arm, zone.poses, zone.analytic), f"zone_{k}")
    attributes = {"arm": arm.name, "pose_law": poses.law, **_zone_attributes(zones)}
    coordinates = {**_axes(arm), "with_axis": list("xyz"), "level": list(analytic.levels)}
    return LabelledArrays(data, coordinates, attributes)


def _summed(analytic: Analytic, prefix: str = "") -> dict[str, Any]:
    """Return the error at every pose by sums over terms, each figure with its uncertainty. `prefix`
    goes before every name.
    """
    sides, shares = ("pose", "axis"), ("pose", f"{prefix}level")
    figures = {
        "error_mean": (
            "pose",
            analytic.mean,
            analytic.mean_uncertainty,
            "mean position error over robots and visits",
        ),
        "error_standard_deviation": (
            "pose",
            analytic.deviation,
            analytic.deviation_uncertainty,
            "standard deviation of the position error",
        ),
        "error_quantile": (
            shares,
            analytic.quantiles,
            analytic.quantiles_uncertainty,
            "position error not exceeded by this share of errors",
        ),
    }
    off = {
        f"{name}_uncertainty": (dims, values, "m", f"half of the 95 % interval of {name}")
        for name, (dims, _, values, _) in figures.items()
    }
    data = {
        name: (dims, values, "m", text) for name, (dims, values, _, text) in figures.items()
    } | off
    data |= {
        "error_rms": (
            "pose",
            np.sqrt(analytic.mean_square),
            "m",
            "root mean square position error, exact sum over terms",
        ),
        "bias": (sides, analytic.bias, "m", "mean vector of the error, base frame"),
        "covariance": (
            (*sides, "with_axis"),
            analytic.covariance,
            "m^2",
            "covariance of the error, base frame",
        ),
        "worst_case": (
            "pose",
            analytic.worst,
            "m",
            "bound: everything at its limit at once; infinite where an error has no limits",
        ),
        "root_sum_square": (
            "pose",
            analytic.rss,
            "m",
            "|bias| + root of the sum of squared limits",
        ),
        "excess": (
            "pose",
            analytic.excess,
            "1",
            (
                "mean fourth power of the scatter against a normal vector's: 0 normal, less flat "
                "or two-sided"
            ),
        ),
        "nearly_normal": (
            "pose",
            analytic.nearly_normal.astype(np.int8),
            "1",
            "1 where the figures are of a nearly normal error, 0 where by Sobol points",
        ),
    }
    return {
        f"{prefix}{name}": (dims, values, {"units": unit, "long_name": f"{text}; without sampling"})
        for name, (dims, values, unit, text) in data.items()
    }


def _visited(arm: Arm, poses: Poses, tool: Floats) -> dict[str, Any]:
    """Return the poses and the tool points there."""
    return {
        "q": (("pose", "joint"), poses.q, _of_joints(arm, "rad", "m", "joint values")),
        "tool": (
            ("pose", "axis"),
            tool,
            {"units": "m", "long_name": "commanded tool point, base frame"},
        ),
    }


def _axes(arm: Arm) -> dict[str, Any]:
    units = ["rad" if joint.type == "revolute" else "m" for joint in arm.driven]
    return {
        "joint": [joint.name for joint in arm.driven],
        "joint_unit": ("joint", units),
        "axis": list("xyz"),
    }


def _of_joints(arm: Arm, turning: str, sliding: str, text: str) -> dict[str, str]:
    """Return unit and long name of an array over joints; turning and sliding joints have no common
    unit, so that a mixed array states none.
    """
    units = {turning if joint.type == "revolute" else sliding for joint in arm.driven}
    if len(units) == 1:
        return {"units": units.pop(), "long_name": text}
    return {"long_name": f"{text}: {turning} where joint_unit is rad, {sliding} where it is m"}


def _zone_attributes(zones: Sequence[FoundInZone]) -> dict[str, str]:
    return {
        f"zone_{k}": f"{zone.name}: {len(zone.poses)} poses, found among {zone.tried}"
        for k, zone in enumerate(zones, start=1)
    }


def _of_zone(inside: LabelledArrays, key: str) -> dict[str, object]:
    """Return the arrays over a zone's own poses; the zone's key precedes their names and
    dimensions.
    """
    own = {"pose", "robot", "bin"}
    return {
        f"{key}_{name}": (
            tuple(f"{key}_{axis}" if axis in own else axis for axis in axes_of(axes)),
            values,
            {**about, "long_name": f"{about['long_name']}, in {key}"},
        )
        for name, (axes, values, about) in inside.data.items()
    }
