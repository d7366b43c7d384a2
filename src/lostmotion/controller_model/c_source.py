"""The C source of a controller: its tables as constant arrays that the C core evaluates, and the
files that are the same for every arm.
"""

from __future__ import annotations

import math
import pkgutil
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np
from scipy.special import ndtr

from lostmotion.controller_model.controller import play_flags
from lostmotion.laws.rolling.table import BOTTOM, RIM

if TYPE_CHECKING:
    from collections.abc import Iterable

    from lostmotion.controller_model.controller import Controller
    from lostmotion.controller_model.tables import (
        Entry,
        ExportedCurve,
        ExportedFriction,
        ExportedLoadTable,
        Product,
        Record,
        Tables,
    )
    from lostmotion.laws.rolling.table import ShiftTable
    from lostmotion.spatial import Floats


# Stands for infinity: a float holds it.
_HUGE: Final = 1e30
# A smaller share is rounding.
_ROUNDING: Final = 1e-14
_UPPER: Final = np.triu_indices(6)
# Numbers of a line of C.
_PER_LINE: Final = 12


def packaged(name: str) -> str:
    """Return the text of a C source, or of a file beside it, that is the same for every arm."""
    return (pkgutil.get_data("lostmotion.controller_model", f"c/{name}") or b"").decode()


def number(value: float) -> str:
    """Return a number as a C constant of the controller's own type, with all its digits."""
    return f"R({min(max(float(value), -_HUGE), _HUGE)!r})"


def numbers(values: Floats) -> str:
    """Return an array as a C initialiser, in one row."""
    return (
        "{"
        + ", ".join(number(value) for value in np.asarray(values, dtype=float).ravel().tolist())
        + "}"
    )


@dataclass
class _Arrays:
    """The arrays of the source, row by row."""

    matrices: list[str] = field(default_factory=list)
    rows: dict[str, list[str]] = field(default_factory=dict)

    def add(self, kind: str, rows: Iterable[str]) -> tuple[int, int]:
        """Add rows of a kind and return the index of the first and their count."""
        found = self.rows.setdefault(kind, [])
        first = len(found)
        found.extend(rows)
        return first, len(found) - first

    def matrix(self, values: Floats) -> str:
        """Return the name of a constant array with these values; 0 where all are zero."""
        return self.array(values) if np.any(values) else "0"

    def array(self, values: Floats) -> str:
        """Return the name of a constant array with these values."""
        flat = np.asarray(values, dtype=float).ravel().tolist()
        lines = (
            ", ".join(number(value) for value in flat[k : k + _PER_LINE])
            for k in range(0, len(flat), _PER_LINE)
        )
        self.matrices.append(
            f"static const lm_real lm_m{len(self.matrices)}[{len(flat)}] = {{\n    "
            + ",\n    ".join(lines)
            + "};"
        )
        return f"lm_m{len(self.matrices) - 1}"


def table_source(tables: Tables) -> str:
    """Return the definitions of all constant arrays."""
    arrays = _Arrays()
    arrays.add("lm_place lm_places", [_place(record, arrays) for record in tables.records])
    lists = (
        "piece",
        "curve",
        "harmonic",
        "seat",
        "friction",
        "threshold",
        "load_table",
        "size",
        "entry",
        "axis_entry",
        "product",
        "axis_product",
    )
    # Arrays without rows have one of zeros: C knows no empty arrays.
    for kind in (*lists, "column", "shared"):
        rows = arrays.rows.setdefault(f"lm_{kind} lm_{_plural(kind)}", [])
        rows += [] if rows else ["{{0}}" if kind == "column" else "{0}"]
    blocks = [
        f"const {name}[{len(rows)}] = {{\n    " + ",\n    ".join(rows) + "};"
        for name, rows in arrays.rows.items()
    ]
    valid = tables.valid
    blocks += [
        f"const lm_real lm_limits[2 * LM_JOINTS] = {numbers(tables.limits)};",
        f"const lm_real lm_rated[LM_JOINTS] = {numbers(tables.rated)};",
        f"const lm_real lm_load[10] = {numbers(tables.load)};",
        f"const lm_real lm_gravity[3] = {numbers(tables.gravity)};",
        (
            "const lm_validity lm_valid = "
            f"{numbers(np.array([valid.payload, valid.reach, valid.force, valid.moment, valid.gravity]))};"  # noqa: E501
        ),
    ]
    return "\n\n".join([*arrays.matrices, *blocks])


def vector_source(model: Controller, count: int) -> str:
    """Return the array of tested poses, with the results of the Python model."""
    q = tested_poses(model.tables, count)
    side = np.resize([0.0, 1.0, -1.0, -1.0, 1.0], q.shape)
    sent = model.compensate(q, side=side)
    found, upper = sent.prediction, np.triu_indices(3)
    fixed = f"{numbers(model.tables.load)}, {numbers(model.tables.gravity)}"
    rows = []
    for k in range(count):
        outputs = (found.point[k], found.screw[k], found.covariance[k][upper], found.torques[k])
        texts = ", ".join(numbers(each) for each in outputs)
        texts += f", {number(found.length95[k])}, {numbers(sent.command[k])}"
        rows.append(f"{{{{{numbers(q[k])}, {fixed}, {numbers(side[k])}}}, {texts}}}")
    return "const lm_vector lm_vectors[LM_VECTORS] = {\n    " + ",\n    ".join(rows) + "};"


def tested_poses(tables: Tables, count: int) -> Floats:
    """Return joint values (pose, joint) spread over the middle 80 % of the range of each joint."""
    share = (
        0.5
        + np.outer(
            np.arange(1, count + 1), np.sqrt([2.0 + 3 * k for k in range(len(tables.joints))])
        )
    ) % 1.0
    low, high = tables.limits.T
    return np.asarray(low + (0.1 + 0.8 * share) * (high - low))


def _plural(kind: str) -> str:
    return kind[:-1] + "ies" if kind.endswith("y") else kind + "s"


def _place(record: Record, arrays: _Arrays) -> str:
    axis = 5 if record.slides else 2
    on_axis = np.zeros(6, dtype=bool)
    on_axis[axis] = record.joint >= 0
    scalar = [entry for entry in record.entries if not entry.direction[~on_axis].any()]
    vector = [entry for entry in record.entries if entry.direction[~on_axis].any()]
    off = ~np.outer(on_axis, on_axis)
    variance, columns = _columns(record.covariance, axis if record.joint >= 0 else None)
    scalars = [product for product in record.products if not product.matrix[off].any()]
    matrices = [product for product in record.products if product.matrix[off].any()]
    shared = []
    for each in record.shared:
        first, count = arrays.add("lm_entry lm_entries", [_entry(entry) for entry in each.entries])
        share = each.share
        rest = (
            (
                each.compliance - share * record.compliance,
                each.own_weight - share * record.own_weight,
            )
            if not share
            else (np.zeros(1), np.zeros(1))
        )
        shared.append(
            f"{{{each.draw}, {number(share)}, {arrays.matrix(rest[0])}, "
            f"{arrays.matrix(rest[1])}, {first}, {count}}}"
        )
    thresholds = []
    for threshold in record.thresholds:
        first, count = arrays.add(
            "lm_friction lm_frictions",
            [_friction(friction, arrays) for friction in threshold.frictions],
        )
        thresholds.append(f"{{{first}, {count}}}")
    lists = (
        arrays.add("lm_curve lm_curves", [_curve(curve, arrays) for curve in record.curves]),
        arrays.add(
            "lm_harmonic lm_harmonics",
            [
                f"{{{number(each.order)}, {number(each.turns)}, {int(each.cosine)}}}"
                for each in record.harmonics
            ],
        ),
        arrays.add(
            "lm_seat lm_seats",
            [
                f"{{{len(seat.way)}, {numbers(np.resize(seat.way, (3, 6)))}}}"
                for seat in record.seats
            ],
        ),
        arrays.add("lm_threshold lm_thresholds", thresholds),
        arrays.add(
            "lm_load_table lm_load_tables", [_load_table(table, arrays) for table in record.tables]
        ),
        arrays.add("lm_size lm_sizes", [f"{{{a}, {b}, {c}}}" for a, b, c in record.sizes]),
        arrays.add("lm_entry lm_entries", [_entry(entry) for entry in vector]),
        arrays.add(
            "lm_axis_entry lm_axis_entries",
            [f"{{{each.size}, {each.side}, {number(each.direction[axis])}}}" for each in scalar],
        ),
        arrays.add(
            "lm_product lm_products",
            [f"{_product(each)}, {numbers(each.matrix[_UPPER])}}}" for each in matrices],
        ),
        arrays.add(
            "lm_axis_product lm_axis_products",
            [f"{_product(each)}, {number(each.matrix[axis, axis])}}}" for each in scalars],
        ),
        arrays.add("lm_column lm_columns", [f"{{{numbers(column)}}}" for column in columns]),
        arrays.add("lm_shared lm_shareds", shared),
    )
    head = (
        f"{record.parent}, {record.joint}, {axis}, "
        f"{int(record.carries_tool and (record.joint >= 0 or _errs(record)))}, "
        f"{play_flags(record)}"
    )
    pose = (
        f"{numbers(record.pose[:3, :3])}, {numbers(record.pose[:3, 3])}, {number(record.mass)}, "
        f"{numbers(record.moment)}, {numbers(record.mean)}"
    )
    constant = (
        f"{arrays.matrix(record.compliance)}, {arrays.matrix(record.own_weight)}, "
        f"{number(variance)}"
    )
    return (
        f"{{{head}, {pose}, {constant}, "
        + ", ".join(f"{first}, {count}" for first, count in lists)
        + "}"
    )


def _errs(record: Record) -> bool:
    """Return whether a place has errors."""
    constant = any(
        each.any()
        for each in (record.mean, record.compliance, record.own_weight, record.covariance)
    )
    return bool(constant or record.entries or record.products or record.shared)


def _columns(covariance: Floats, axis: int | None) -> tuple[float, list[Floats]]:
    """Return the variance along an axis, where it is independent of the rest, and columns whose
    squares add to the rest of a covariance (6, 6).
    """
    rest, variance = covariance.copy(), 0.0
    if axis is not None and not np.delete(rest[axis], axis).any():
        variance, rest[axis, axis] = float(rest[axis, axis]), 0.0
    scale = np.sqrt(np.diag(rest))  # rotations and displacements have different units
    per = np.where(scale > 0, scale, 1.0)
    values, vectors = np.linalg.eigh(rest / np.outer(per, per))
    return variance, [
        scale * np.sqrt(value) * vector
        for value, vector in zip(values, vectors.T, strict=True)
        if value > _ROUNDING
    ]


def _entry(entry: Entry) -> str:
    return f"{{{entry.size}, {entry.side}, {numbers(entry.direction)}}}"


def _product(product: Product) -> str:
    return f"{{{product.first}, {product.second}, {product.side}"


def _pieces(start: Floats, width: Floats, slope: Floats, arrays: _Arrays) -> tuple[int, int]:
    return arrays.add(
        "lm_piece lm_pieces",
        [numbers(np.array(row)) for row in zip(start, width, slope, strict=True)],
    )


def _curve(curve: ExportedCurve, arrays: _Arrays) -> str:
    first, count = _pieces(curve.start, curve.width, curve.slope, arrays)
    return (
        f"{{{number(curve.base)}, {int(curve.odd)}, {int(curve.travels)}, {int(curve.weights)}, "
        f"{first}, {count}, {numbers(curve.way)}}}"
    )


def _friction(friction: ExportedFriction, arrays: _Arrays) -> str:
    first, count = (
        (0, 0) if friction.cut else _pieces(friction.start, friction.width, friction.slope, arrays)
    )
    low = float(ndtr(-friction.cut)) if friction.cut and math.isfinite(friction.cut) else 0.0
    values = [friction.lever, friction.nominal, friction.tolerance, friction.base]
    law = [friction.scale, low, 1 - 2 * low]
    return (
        f"{{{friction.seat}, {', '.join(map(number, values))}, {first}, {count}, "
        f"{', '.join(map(number, law))}}}"
    )


def _load_table(table: ExportedLoadTable, arrays: _Arrays) -> str:
    power, step = 1 / table.table.pair.exponent, table.step
    own, wider = _spline(table.table, table.table.spline.c, arrays), "0"
    if table.wider is not None and table.wider.preloaded == table.table.preloaded:
        # The difference of two tables as one table, because in single precision it would lose
        # digits.
        wider, step = (
            _spline(table.table, (table.wider.spline.c - table.table.spline.c) / step, arrays),
            0.0,
        )
    elif table.wider is not None:
        wider = _spline(table.wider, table.wider.spline.c, arrays)
    values = (power, table.table.top**power, RIM, BOTTOM ** (power / 2), step)
    return (
        f"{{{int(table.axial)}, {{{', '.join(map(str, table.seats))}}}, "
        f"{', '.join(map(number, values))}, {own}, {wider}}}"
    )


def _spline(table: ShiftTable, coefficients: Floats, arrays: _Arrays) -> str:
    knots = [arrays.array(each) for each in table.spline.t]
    names = [*knots, "0", "0"][:3]
    nodes = [*coefficients.shape[:-1], 1, 1][:3]
    flags = f"{int(table.clearance > 0)}, {int(table.preloaded)}"
    values, name = arrays.array(coefficients), f"lm_s{len(arrays.matrices)}"
    arrays.matrices.append(
        f"static const lm_spline {name} = {{{{{', '.join(names)}}}, "
        f"{{{', '.join(map(str, nodes))}}}, {values}, {flags}}};"
    )
    return f"&{name}"
