"""The labelled arrays of a study (xarray), every variable with its unit and meaning."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.arm import tool_points
from lostmotion.figures.in_zone import seen_in
from lostmotion.studies.montecarlo import kernel
from lostmotion.studies.montecarlo.histogram import linear_bins, share_intervals
from lostmotion.studies.statics.statics import holding_torques

if TYPE_CHECKING:
    import xarray

    from lostmotion.studies.answer import Answer
    from lostmotion.studies.route import FoundInZone
    from lostmotion.studies.zones.zones import Zones


def dataset(answer: Answer) -> xarray.Dataset:
    """Give what the study found per pose and per robot, in SI, with units and long names."""
    import xarray

    sampled = answer.sampled
    table = sampled.per_pose
    joints = [joint.name for joint in answer.arm.moving]
    units = ["rad" if joint.type == "revolute" else "m" for joint in answer.arm.moving]
    quantiles = table[:, kernel.FIRST_QUANTILE :].reshape(len(table), len(kernel.QUANTILES), 3)
    per_pose = {
        "error_mean": (table[:, kernel.MEAN], "m", "mean position error over robots and visits"),
        "error_mean_half_interval": (table[:, kernel.MEAN_ERROR], "m", "half of the 95 % interval of error_mean, counting robots"),
        "error_rms": (np.sqrt(table[:, kernel.MEAN_SQUARE]), "m", "root mean square position error"),
        "error_largest": (table[:, kernel.LARGEST], "m", f"largest of {sampled.robots * sampled.visits} samples"),
        "largest_robot": (table[:, kernel.LARGEST_ROBOT].astype(np.int32), "1", "robot that made error_largest"),
        "largest_visit": (table[:, kernel.LARGEST_VISIT].astype(np.int32), "1", "visit that made error_largest"),
        "worst_case": (sampled.worst, "m", "bound: everything at its limit at once"),
        "root_sum_square": (sampled.rss, "m", "|bias| + root of the sum of squared limits"),
        "rotation_rms": (np.sqrt(sampled.rotation_ms), "rad", "root mean square rotation error of the tool"),
    }
    data: dict[str, object] = {name: ("pose", values, {"units": unit, "long_name": text}) for name, (values, unit, text) in per_pose.items()}
    data["q"] = (("pose", "joint"), answer.poses.q, {"units": "rad or m (see joint_unit)", "long_name": "joint values"})
    data["holding_torque"] = (("pose", "joint"), answer.torques, {"units": "N m or N", "long_name": "static torque or force that the drive holds"})
    data["tool"] = (("pose", "axis"), answer.tool, {"units": "m", "long_name": "commanded tool point, base frame"})
    data["bias"] = (("pose", "axis"), sampled.bias[:, 3:], {"units": "m", "long_name": "error common to all robots and visits"})
    data["error_quantile"] = (
        ("pose", "level"),
        quantiles[:, :, 0],
        {"units": "m", "long_name": "position error that this share of samples stays below"},
    )
    for k, end in ((1, "low"), (2, "high")):
        text = f"{end} end of the 95 % interval of error_quantile, counting robots"
        data[f"error_quantile_{end}"] = (("pose", "level"), quantiles[:, :, k], {"units": "m", "long_name": text})
    if sampled.visits > 1:
        for name, text, values, column in (
            ("AP", "pose accuracy AP", sampled.accuracy, 1),
            ("RP", "pose repeatability RP", sampled.repeatability, 2),
        ):
            data[f"{name}_mean"] = ("pose", values[:, 0], {"units": "m", "long_name": f"{text}, mean over robots"})
            data[f"{name}_95"] = ("pose", values[:, 1], {"units": "m", "long_name": f"{text}, 95 % of robots below"})
            data[f"{name}_95_low"] = ("pose", values[:, 2], {"units": "m", "long_name": f"low end of the 95 % interval of {name}_95"})
            data[f"{name}_95_high"] = ("pose", values[:, 3], {"units": "m", "long_name": f"high end of the 95 % interval of {name}_95"})
            data[f"robot_{name}"] = (
                "robot",
                sampled.robot_means[:, :, column].mean(axis=0),
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
    for column, (name, text) in enumerate((("", "share of all samples"), ("_low", "low end of its 95 % interval"), ("_high", "high end"))):
        shares = share_intervals(sampled.group_hist, edges)[:, column]
        data[f"error_share{name}"] = ("bin", shares, {"units": "1", "long_name": f"{text}, counting robots"})
    data["bin_low"] = ("bin", edges[:-1], {"units": "m", "long_name": "least position error of the bin"})
    data["bin_high"] = ("bin", edges[1:], {"units": "m", "long_name": "largest position error of the bin"})
    coordinates = {"joint": joints, "joint_unit": ("joint", units), "axis": ["x", "y", "z"], "level": list(kernel.QUANTILES)}
    for k, zone in enumerate(answer.zones, start=1):
        data |= _of_zone(answer, zone, f"zone_{k}")
    attributes = {
        "arm": answer.arm.name,
        "seed": str(answer.seed),  # NetCDF 3 has no long whole numbers
        "robots": sampled.robots,
        "visits": sampled.visits,
        "pose_law": answer.poses.law,
        **{f"zone_{k}": f"{zone.name}: {len(zone.poses)} poses, found among {zone.tried}" for k, zone in enumerate(answer.zones, start=1)},
    }
    return xarray.Dataset(data, coordinates, attributes)


def _of_zone(answer: Answer, zone: FoundInZone, key: str) -> dict[str, object]:
    """Give the same arrays over a zone's own poses, their names and those of their dimensions with the zone's key before them."""
    q = zone.poses.q
    inside = dataset(replace(seen_in(answer, zone), tool=tool_points(answer.arm, q), torques=holding_torques(answer.arm, q)[0]))
    own = {"pose", "robot", "bin"}
    return {
        f"{key}_{name}": (
            tuple(f"{key}_{dim}" if dim in own else dim for dim in values.dims),
            values.values,
            {**values.attrs, "long_name": f"{values.attrs['long_name']}, in {key}"},
        )
        for name, values in inside.data_vars.items()
    }


def map_dataset(found: Zones) -> xarray.Dataset:
    """Give an accuracy map cell by cell, in SI, with units and long names; NaN where the tool was not found to reach."""
    import xarray

    from lostmotion.studies.zones.by_cell import BYS, MEAN, QUANTILE

    grid, reached = found.reached.grid, found.reached
    space = ("x", "y", "z")
    share = f"{100 * found.level:.6g} %"
    data: dict[str, object] = {}
    for k, by in enumerate(BYS):
        of = "mean over the configurations" if by == "mean" else f"{by} configuration"
        for measure, name, text in (
            (MEAN, "error_mean", "mean position error"),
            (QUANTILE, "error_quantile", f"position error that {share} stay below"),
        ):
            data[f"{name}_{by}"] = (space, found.figures[measure, k], {"units": "m", "long_name": f"{text}, {of} looked at in the cell"})
    data["configurations"] = (space, reached.counts.astype(np.int32), {"units": "1", "long_name": "poses looked at in the cell"})
    flags = [
        ("centre_reached", reached.centre, "1 where the middle of the cell is in reach: the errors are those there"),
        ("bound", found.bounded, "1 where the errors are upper bounds, no pose being near enough to normal"),
    ]
    if found.within is not None:
        flags.append(("within_target", found.within.cells, f"1 where error_quantile_{found.by} is within {found.within.target:.6g} m"))
    if found.boxes is not None:
        place = np.zeros(grid.shape, np.int8)
        for number, box in enumerate(found.boxes.found, start=1):
            place.ravel()[box.cells] = number
        flags.append(("place", place, "number of the place for the box that the cell belongs to, the best first; 0 none"))
    for name, values, text in flags:
        data[name] = (space, values.astype(np.int8), {"units": "1", "long_name": text})
    coordinates = {
        axis: (axis, grid.along(k), {"units": "m", "long_name": f"middle of the cell along {axis}, base frame"}) for k, axis in enumerate(space)
    }
    attributes = {"arm": found.arm.name, "seed": str(found.seed), "cell": grid.edge, "level": found.level, "by": found.by}
    return xarray.Dataset(data, coordinates, attributes)
