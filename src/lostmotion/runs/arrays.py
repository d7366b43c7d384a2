"""A sweep's figures with their names: one axis per key swept."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    import xarray

    from lostmotion.error_model.intervals import Estimate
    from lostmotion.runs.job import Order
    from lostmotion.runs.summary import Outcome

_ENDS = ("value", "low", "high")


def dataset(order: Order, outcomes: Sequence[Outcome]) -> xarray.Dataset:
    """Return the figures of every design over the keys swept; `end` is value, low or high end of
    the 95 % interval, in m. NaN for designs that fall at some poses.

    Mass (kg) and price are as far as the arm file states them. A key's coordinate holds its values
    as numbers in the unit they are stated in where they are plain quantities, else as text.
    """
    import xarray

    keys = dict.fromkeys(key for each in outcomes for key in each.figures)
    found: dict[str, list[Estimate | None]] = {
        key: [each.figures.get(key) for each in outcomes] for key in keys
    }
    found["p95_lower"] = [each.lower for each in outcomes]
    shape = tuple(len(axis.values) for axis in order.axes)
    dims = tuple(axis.key for axis in order.axes)
    data: dict[str, Any] = {}
    for name, estimates in found.items():
        table = np.array(
            [
                [np.nan if each is None else getattr(each, end) for end in _ENDS]
                for each in estimates
            ]
        )
        data[name] = ((*dims, "end"), table.reshape(*shape, len(_ENDS)), {"units": "m"})
    data["p95_lower"][2]["long_name"] = (
        "by how much the 95 % error lies below that of the first design"
    )
    largest = np.array([each.worst[0].error if each.worst else np.nan for each in outcomes])
    data["largest"] = (dims, largest.reshape(shape), {"units": "m"})
    data["mass"] = (
        dims,
        np.array([each.mass for each in outcomes]).reshape(shape),
        {"units": "kg"},
    )
    if any(each.price is not None for each in outcomes):
        data["price"] = (
            dims,
            np.array([np.nan if each.price is None else each.price for each in outcomes]).reshape(
                shape
            ),
            {"units": "1"},
        )
    coordinates: dict[str, Any] = {"end": list(_ENDS)}
    for axis in order.axes:
        quantities = axis.quantities
        coordinates[axis.key] = (
            (axis.key, list(axis.labels))
            if quantities is None
            else (axis.key, list(quantities[0]), {"units": quantities[1]})
        )
    about = {
        "arm": order.arm,
        "poses": order.poses,
        "robots": order.robots,
        "visits": order.visits,
        "seed": str(order.seed),
    }
    return xarray.Dataset(data, coordinates, about)
