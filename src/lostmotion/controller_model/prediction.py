"""Evaluation of the tables of a controller in NumPy, for many poses at a time: the reference for
the C sources, step by step the same.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from scipy.special import ndtr

from lostmotion.spatial import cross, exp, skew

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from lostmotion.controller_model.tables import (
        Entry,
        ExportedCurve,
        ExportedFriction,
        ExportedLoadTable,
        Record,
        Shared,
        Tables,
    )
    from lostmotion.spatial import Floats

# A load below this share of the whole wrench is rounding (`laws.clearance`).
_ROUNDING: Final = 1e-9
# A larger share of robots with a closed play is all of them.
_ALL: Final = 0.999999
# Smaller loads (N or N m) have no direction.
_LEAST: Final = 1e-140


class PredictionFactors(NamedTuple):
    """What the errors of one place depend on.

    values     the factors (pose,) of its record, in their order
    open_play  (pose,) whether a load leaves a play open in some robots
    beyond     (pose,) whether a load is beyond a table of displacements
    """

    values: list[Floats]
    open_play: NDArray[np.bool_]
    beyond: NDArray[np.bool_]


class ToolError(NamedTuple):
    """State and error of the tool; the names are those of `controller.Prediction`.

    twists   (place, pose, 6) expected twist of each place in its own axes, zero off the way to the
             tool
    factors  those of each place that has any
    """

    turn: Floats
    point: Floats
    torques: Floats
    joints: Floats
    elsewhere: Floats
    screw: Floats
    covariance: Floats
    jacobian: Floats
    twists: Floats
    factors: list[PredictionFactors]


def tool_error(
    tables: Tables,
    q: Floats,
    load: Floats,
    gravity: Floats,
    side: Floats,
    factors_of: Callable[[Record, Floats, Floats, Floats], PredictionFactors],
) -> ToolError:
    """Return state and error of the tool at valid inputs, in the shapes of `Controller.predict`.

    factors_of  function that evaluates the factors of a record from the joint value (pose,), the
                wrench and the part of it by the process force (pose, 6) in the axes of the place

    Only additions, products, sines and cosines: the arrays may hold symbols in place of numbers.
    """
    (count, joints), kind = q.shape, q.dtype
    turns, points = frames(tables, q)
    carried = wrenches(tables, turns, points, load, gravity)
    process = process_wrenches(tables, turns, points, load)
    tool = points[-1]
    torques, along, jacobian = (
        np.zeros((count, joints), kind),
        np.zeros((count, joints), kind),
        np.zeros((count, 6, joints), kind),
    )
    elsewhere, screw, covariance = (
        np.zeros((count, 6), kind),
        np.zeros((count, 6), kind),
        np.zeros((count, 3, 3), kind),
    )
    shared = np.zeros((len(tables.draws), count, 3), kind)
    twists = np.zeros((len(tables.records), count, 6), kind)
    found = []
    for k, record in enumerate(tables.records):
        axis = 5 if record.slides else 2
        if record.joint >= 0:
            torques[:, record.joint] = -carried[k, :, axis]
        if not record.carries_tool:
            continue
        carry = to_tool(turns[k], tool - points[k])
        value, last = (
            (q[:, record.joint], side[:, record.joint])
            if record.joint >= 0
            else (np.zeros(count), np.zeros(count))
        )
        factors = factors_of(record, value, carried[k], process[k])
        found.append(factors)
        fall = np.einsum("pij,pi->pj", turns[k], gravity)
        mean, spread, own = local_error(record, factors.values, last)
        linear = _linear(record, carried[k], fall)
        twists[k] = mean + linear
        shift, along_axis = carry[:, 3:], np.zeros((count, 3), kind)
        if record.joint >= 0:
            motion = mean[:, axis] + linear[:, axis]
            jacobian[:, :, record.joint] = carry[:, :, axis]
            along[:, record.joint] = motion
            screw += carry[:, :, axis] * motion[:, None]
            along_axis = shift[:, :, axis] * linear[:, axis, None]
            mean[:, axis] = linear[:, axis] = 0.0
        moved = np.einsum("pij,pj->pi", shift, linear)  # used again by the draws that scale it
        elsewhere[:, :3] += np.einsum("pij,pj->pi", turns[k], mean[:, :3] + linear[:, :3])
        elsewhere[:, 3:] += np.einsum("pij,pj->pi", shift, mean) + moved
        covariance += shift @ spread @ shift.transpose(0, 2, 1)
        for each, part in zip(record.shared, own, strict=True):
            whole = part if each.share else part + _linear(each, carried[k], fall)
            shared[each.draw] += each.share * (moved + along_axis) + np.einsum(
                "pij,pj->pi", shift, whole
            )
    covariance += np.einsum("dpi,dpj->pij", shared, shared)
    return ToolError(
        turns[-1],
        tool,
        torques,
        along,
        elsewhere,
        screw + elsewhere,
        covariance,
        jacobian,
        twists,
        found,
    )


def frames(tables: Tables, q: Floats, twists: Floats | None = None) -> tuple[Floats, Floats]:
    """Return rotations (place, pose, 3, 3) and origins (place, pose, 3), m, of the places in the
    base's axes, for q (pose, joint).

    twists  (place, pose, 6) of the places in their own axes, behind the motion of their joint; none
            by default
    """
    turns, points = (
        np.empty((len(tables.records), len(q), 3, 3), dtype=q.dtype),
        np.empty((len(tables.records), len(q), 3), dtype=q.dtype),
    )
    turns[0], points[0] = np.eye(3), 0.0
    if twists is not None:
        base = exp(twists[0])
        turns[0], points[0] = base[:, :3, :3], base[:, :3, 3]
    for k, record in enumerate(tables.records[1:], start=1):
        before = turns[record.parent]
        turn = before @ record.pose[:3, :3]
        point = points[record.parent] + before @ record.pose[:3, 3]
        if record.joint >= 0:
            value = q[:, record.joint]
            if record.slides:
                point = point + turn[:, :, 2] * value[:, None]
            else:
                cosine, sine = np.cos(value)[:, None], np.sin(value)[:, None]
                turned = turn.copy()
                turned[:, :, 0] = cosine * turn[:, :, 0] + sine * turn[:, :, 1]
                turned[:, :, 1] = cosine * turn[:, :, 1] - sine * turn[:, :, 0]
                turn = turned
        if twists is not None and record.carries_tool:
            moved = exp(twists[k])
            point = point + np.einsum("pij,pj->pi", turn, moved[:, :3, 3])
            turn = turn @ moved[:, :3, :3]
        turns[k], points[k] = turn, point
    return turns, points


def wrenches(
    tables: Tables, turns: Floats, points: Floats, load: Floats, gravity: Floats
) -> Floats:
    """Return the wrench on each place from everything outboard of it (place, pose, 6), in its axes,
    N m and N.

    load     (pose, 10) mass, centre of mass, force and moment in the tool's axes, as in
             `Tables.load`
    gravity  (pose, 3) in the base's axes, m/s^2
    """
    force, moment = (
        np.zeros(points.shape, dtype=points.dtype),
        np.zeros(points.shape, dtype=points.dtype),
    )
    last = len(tables.records) - 1
    for k in range(last, -1, -1):
        record = tables.records[k]
        mass, first = (
            np.full((len(load), 1), record.mass),
            np.broadcast_to(record.moment, points[k].shape),
        )
        if k == last:
            mass = mass + load[:, :1]
            first = first + load[:, :1] * load[:, 1:4]
            force[k] += np.einsum("pij,pj->pi", turns[k], load[:, 4:7])
            moment[k] += np.einsum("pij,pj->pi", turns[k], load[:, 7:10])
        force[k] += mass * gravity
        moment[k] += cross(np.einsum("pij,pj->pi", turns[k], first), gravity)
        if k:
            force[record.parent] += force[k]
            moment[record.parent] += moment[k] + cross(points[k] - points[record.parent], force[k])
    local = [np.einsum("kpij,kpi->kpj", turns, vector) for vector in (moment, force)]
    return np.concatenate(local, axis=2)


def process_wrenches(tables: Tables, turns: Floats, points: Floats, load: Floats) -> Floats:
    """Return the part of `wrenches` by the process force and moment; zeros where no curve needs
    it.
    """
    if not tables.fed_forward:
        return np.zeros((*points.shape[:2], 6))
    return wrenches(tables, turns, points, load, np.zeros((len(load), 3)))


def local_error(
    record: Record, factors: Sequence[Floats], side: Floats
) -> tuple[Floats, Floats, list[Floats]]:
    """Return mean (pose, 6) and covariance (pose, 6, 6) of the screw at one place, in its axes, and
    the part (pose, 6) of each shared draw.

    Without compliance and own weight, which `tool_error` adds.

    factors  (pose,) each, of the record
    side     (pose,) sign of the joint's last motion; 0 where it is not known
    """
    sizes, behind = _sizes_and_sides(record, factors, side)
    covariance = np.broadcast_to(record.covariance, (len(side), 6, 6))
    for product in record.products:
        factor = sizes[product.first] * sizes[product.second] * behind[product.side]
        covariance = covariance + factor[:, None, None] * product.matrix
    shared = [_sum(each.entries, sizes, behind, len(side)) for each in record.shared]
    return record.mean + _sum(record.entries, sizes, behind, len(side)), covariance, shared


def expected_twist(
    record: Record, factors: Sequence[Floats], side: Floats, wrench: Floats, fall: Floats
) -> Floats:
    """Return the expected twist (pose, 6) of one place in its axes; arguments as `local_error`,
    with the wrench and the acceleration of free fall in these axes.
    """
    sizes, behind = _sizes_and_sides(record, factors, side)
    mean = record.mean + _sum(record.entries, sizes, behind, len(side))
    return np.asarray(mean + _linear(record, wrench, fall))


def _sizes_and_sides(
    record: Record, factors: Sequence[Floats], side: Floats
) -> tuple[list[Floats], list[Floats]]:
    """Return the sizes of a record and its side factors, (pose,) each."""
    sizes = [factors[a] * factors[b] * factors[c] for a, b, c in record.sizes]
    # the output trails the motor: it rests behind its last motion
    return sizes, [np.ones_like(side), -side, 1 - side * side]


def _linear(of: Record | Shared, wrench: Floats, gravity: Floats) -> Floats:
    return np.asarray(wrench @ of.compliance.T + gravity @ of.own_weight.T)


def _sum(
    entries: Sequence[Entry], sizes: Sequence[Floats], behind: Sequence[Floats], count: int
) -> Floats:
    out: Floats = np.zeros((count, 6))
    for entry in entries:
        out = out + (sizes[entry.size] * behind[entry.side])[:, None] * entry.direction
    return out


def factors_of(record: Record, value: Floats, wrench: Floats, process: Floats) -> PredictionFactors:
    """Return the factors of a record at joint values (pose,), rad or m, and wrenches (pose, 6) in
    the axes of its place, with the part of them by the process force.
    """
    out = [np.ones(len(value))]
    for curve in record.curves:
        load = (wrench - process if curve.weights else wrench) @ curve.way
        out.append(_curve(curve, value if curve.travels else load))
    for harmonic in record.harmonics:
        phase = harmonic.order * (harmonic.turns * value)
        out.append(np.cos(phase) if harmonic.cosine else np.sin(phase))
    loads = [wrench @ seat.way.T for seat in record.seats]
    lengths = [_length(load) for load in loads]
    for load, length in zip(loads, lengths, strict=True):
        out += list((load / np.where(length > 0, length, 1.0)[:, None]).T)
    whole = np.sqrt((wrench**2).sum(axis=1))
    open_play, beyond = np.zeros((2, len(value)), dtype=bool)
    for threshold in record.thresholds:
        closed = np.max(
            [_share(friction, lengths[friction.seat], whole) for friction in threshold.frictions],
            axis=0,
        )
        out += [closed, 1 - closed, np.sqrt(closed * (1 - closed))]
        open_play |= closed < _ALL
    for table in record.tables:
        displacements, above = _displacements(table, loads, lengths)
        out += displacements
        beyond |= above
    return PredictionFactors(out, open_play, beyond)


def _length(load: Floats) -> Floats:
    length = np.sqrt((load**2).sum(axis=1))
    return np.where(length > _LEAST, length, 0.0)


def _curve(curve: ExportedCurve, load: Floats) -> Floats:
    size = load if curve.travels else np.abs(load)
    out = np.full(len(load), curve.base)
    for start, width, slope in zip(curve.start, curve.width, curve.slope, strict=True):
        out += slope * np.clip(size - start, 0.0, width)
    return np.sign(load) * out if curve.odd else out


def _share(friction: ExportedFriction, load: Floats, whole: Floats) -> Floats:
    """Return the share of robots in which a load overcomes the friction, as
    `laws.clearance.closed_share`.
    """
    rounding = _ROUNDING * whole / friction.lever
    real = np.where((load > rounding) | (friction.nominal > rounding), load, 0.0)
    if not friction.tolerance:
        return np.asarray((real > 0) & (real >= friction.nominal), dtype=float)
    with np.errstate(over="ignore"):
        beyond = (real - friction.nominal) / friction.tolerance
    if friction.cut:
        low = ndtr(-friction.cut) if math.isfinite(friction.cut) else 0.0
        return np.asarray(
            (ndtr(np.clip(friction.scale * beyond, -friction.cut, friction.cut)) - low)
            / (1 - 2 * low)
        )
    out = np.full(len(load), friction.base)
    for start, width, slope in zip(friction.start, friction.width, friction.slope, strict=True):
        out += slope * np.clip(beyond - start, 0.0, width)
    return out


def _displacements(
    table: ExportedLoadTable, loads: Sequence[Floats], lengths: Sequence[Floats]
) -> tuple[list[Floats], NDArray[np.bool_]]:
    """Return the nine factors (pose,) of a table, and whether the loads are beyond it; their
    factors are then those without a load.
    """
    behind, ahead, along = table.seats
    given = (
        lengths[behind],
        lengths[ahead],
        loads[along][:, 0] if table.axial else np.zeros(len(lengths[behind])),
    )
    beyond = table.table.coordinates(*given)[0] > 1
    one, other, axial = (np.where(beyond, 0.0, load) for load in given)
    at = one, other, axial
    whole, edge = table.table.shifts(*at), table.table.edges(*at)
    grows = (
        np.zeros_like(whole)
        if table.wider is None
        else (table.wider.shifts(*at) - whole) / table.step
    )
    return [
        each
        for row in range(3)
        for each in (whole[:, row] - edge[:, row], edge[:, row], grows[:, row])
    ], beyond


def to_tool(turn: Floats, from_place: Floats) -> Floats:
    """Return the tool's twist per twist at a place (pose, 6, 6), for rotations of the place and the
    vector from it to the tool point (pose, 3).
    """
    out = np.zeros((len(turn), 6, 6), dtype=turn.dtype)
    out[:, :3, :3] = out[:, 3:, 3:] = turn
    out[:, 3:, :3] = -skew(from_place) @ turn
    return out
