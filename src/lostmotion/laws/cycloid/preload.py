"""Discs that push against each other without torque (preload): their rest angle, and the wind-up
from there.

Each disc at an angle of the output carries a torque T_d of either sign, which does not decrease
with the angle. The output is at the angle where the sum over the discs is the torque on it. At rest
that sum is zero: one disc pushes forwards, another backwards. Wind-up is the angle under torque
less the rest angle, so it has the sign of the torque and grows with it.

Source: equilibrium of springs in parallel, each a contact problem of its own (`cycloid.contact`).
Checked against one minimisation of the energy of both discs over all their displacements.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid.drive import rotations

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.drive import Drive
    from lostmotion.spatial import Floats

# The angle of one disc is computed at a geometric series of torques with this ratio, from this
# share of the smallest torque, that of the rest angles.
_STEP: Final = 1.3
_LEAST: Final = 0.01
# Comparisons of angles, in number, at once.
_COMPARED: Final = 4_000_000


@dataclass(frozen=True, slots=True)
class ClearanceEffects:
    """Effect of clearances and misplaced output pins on the angles of the discs, rad.

    low, high  (disc, crank, gearbox) ends of the range in which a disc carries no torque
    shift      (direction, crank, gearbox) added to the angle of a disc that is loaded forwards, and
               subtracted from that of one loaded backwards
    """

    low: Floats
    high: Floats
    shift: Floats


def preloaded_discs(
    drive: Drive,
    torque: Floats,
    crank: Floats,
    gap: Floats,
    effects: ClearanceEffects,
    *,
    places: np.ndarray | None = None,
    threads: int = 1,
) -> tuple[Floats, Floats]:
    """Return the rest angles (end, crank, gearbox), rad, and the angle under each torque (torque,
    crank, gearbox), rad.

    torque   (torque,) N m of either sign, not empty and without zeros
    crank    (crank,) crank angles, rad
    gap      (disc, crank, gearbox, N) m
    effects  of clearances and misplaced output pins
    places   (place,) numbers of crank angles: gaps, effects and results then have places for an
             axis in place of crank angles; default: each crank angle once

    The two ends of the rest angles, behind and ahead, differ where clearances leave play. The
    angles of a disc are exact at torques 30 % apart, and between them where one more contact bears.
    The wind-up of preloaded discs is within 0.1 %. Where discs barely touch, contacts may follow
    each other more closely: 99 % of such pairs are within 4 %, single ones within 25 %, the mean
    over gearboxes within 0.2 %. Raises DidNotConvergeError where the preload or a torque is beyond
    the contact law.
    """
    wanted = np.array([0.0, 0.0, *torque])
    most = float(np.abs(torque).max())
    lowest = _LEAST * float(np.abs(torque).min())
    steps = np.arange(math.ceil(math.log(most / lowest) / math.log(_STEP)) + 1, dtype=float)
    loads: Floats = np.asarray(lowest * _STEP**steps, dtype=float)
    tables = [_table(drive, loads, crank, gap, effects, places, threads)]
    while True:
        angles, torques = _joined(tables, loads, effects)
        low, high = angles[:, 0].max(axis=0), angles[:, -1].min(axis=0)
        least, largest = (
            sum(map(carried_torque, angles, torques, [end[None]] * len(angles)))
            for end in (low, high)
        )
        if (low < high).all() and (least <= wanted.min()).all() and (largest >= wanted.max()).all():
            break
        more = np.asarray(loads[-1] * _STEP ** np.arange(1.0, 4.0), dtype=float)
        tables.append(_table(drive, more, crank, gap, effects, places, threads))
        loads = np.concatenate([loads, more])
    points = angles.reshape(-1, *angles.shape[2:])
    sums = np.asarray(sum(map(carried_torque, angles, torques, [points] * len(angles))))
    # The first rest angle is where the sum stops being negative, the second one where it becomes
    # positive.
    found = [
        crossing(points, sums, sums <= 0 if k == 1 else sums < whole, whole)
        for k, whole in enumerate(wanted)
    ]
    rest, turned = np.sort(found[:2], axis=0), np.array(found[2:])
    # Without play the two ends differ by rounding, which must not appear as a rotation against the
    # torque.
    return rest, np.where(
        torque[:, None, None] > 0, np.maximum(turned, rest[1]), np.minimum(turned, rest[0])
    )


def crossing(points: Floats, sums: Floats, below: np.ndarray, whole: float) -> Floats:
    """Return the angle (crank, gearbox), rad, at which the torque of all discs reaches `whole` (N
    m).

    points  (point, crank, gearbox) angles, in any order, between which the torque is linear
    sums    (point, crank, gearbox) N m, the torque at them
    below   (point, crank, gearbox) mask of the angles before the one that is sought
    """
    last, first = (
        np.where(chosen, points, bound) for chosen, bound in ((below, -np.inf), (~below, np.inf))
    )
    at = last.argmax(axis=0)[None], first.argmin(axis=0)[None]
    (start, end), (low, high) = (
        [np.take_along_axis(each, k, axis=0)[0] for k in at] for each in (points, sums)
    )
    share = (whole - low) / np.where(high > low, high - low, 1.0)
    return np.asarray(start + np.clip(share, 0.0, 1.0) * (end - start))


def carried_torque(alone: Floats, loads: Floats, angle: Floats) -> Floats:
    """Return the torque (point, crank, gearbox), N m, of one disc at angles (point, crank,
    gearbox), by linear interpolation.

    alone  (load, crank, gearbox) angles of the disc under the torques `loads` (load, 1 or
           crank, 1 or gearbox), rad and N m; beyond them the torque of the nearer end
    """
    out = np.empty(angle.shape)
    columns = alone.reshape(len(alone), -1)
    torques = np.broadcast_to(loads, alone.shape).reshape(columns.shape)
    column = np.arange(columns.shape[1])
    together = max(1, _COMPARED // columns.size)
    for first in range(0, len(angle), together):
        wanted = angle[first : first + together].reshape(-1, columns.shape[1])
        at = np.clip((columns[:, None] <= wanted).sum(axis=0), 1, len(loads) - 1)
        below, above = columns[at - 1, column], columns[at, column]
        least, most = torques[at - 1, column], torques[at, column]
        share = np.maximum(wanted - below, 0.0) / np.maximum(above - below, np.finfo(float).tiny)
        carried = least + np.minimum(share, 1.0) * (most - least)
        out[first : first + together] = carried.reshape(-1, *angle.shape[1:])
    return out


def _table(
    drive: Drive,
    loads: Floats,
    crank: Floats,
    gap: Floats,
    effects: ClearanceEffects,
    places: np.ndarray | None,
    threads: int,
) -> Floats:
    """Return the angles, rad, of the discs under loads (load,), N m, forwards and backwards, and
    their stiffness there, N m/rad: (angle or stiffness, direction, disc, load, crank, gearbox).
    """
    out = np.empty((2, 2, drive.discs, len(loads), *gap.shape[1:3]))
    for direction, sign in enumerate((1.0, -1.0)):
        for disc in range(drive.discs):
            turned = crank + 2 * math.pi * disc / drive.discs
            angle, out[1, direction, disc] = rotations(
                drive, sign * loads, turned, gap[disc], places=places, threads=threads
            )
            out[0, direction, disc] = angle + sign * effects.shift[direction]
    return out


def _joined(
    tables: list[Floats], loads: Floats, effects: ClearanceEffects
) -> tuple[Floats, Floats]:
    """Return angles, rad, and torques, N m, of the discs, (disc, point, crank, gearbox): for loads
    from the most negative to the largest with two of no load, and a point between each two.
    """
    (ahead, behind), stiff = np.concatenate(tables, axis=3)
    high, low = np.minimum(effects.high, ahead[:, 0]), np.maximum(effects.low, behind[:, 0])
    middle = (high + low) / 2
    high, low = np.maximum(high, middle), np.minimum(low, middle)
    # Each load has its own secant stiffness of the bearings, which must not reverse the order of
    # two similar loads.
    ahead = np.maximum.accumulate(np.concatenate([high[:, None], ahead], axis=1), axis=1)
    behind = np.minimum.accumulate(np.concatenate([low[:, None], behind], axis=1), axis=1)
    at = np.concatenate([behind[:, ::-1], ahead], axis=1)
    torque = np.concatenate([-loads[::-1], [0.0, 0.0], loads])[:, None, None]
    free = np.full_like(stiff[0, :, :1], math.nan)
    slope = np.concatenate([stiff[1, :, ::-1], free, free, stiff[0]], axis=1)
    return _with_kinks(at, np.broadcast_to(torque, at.shape), slope)


def _with_kinks(at: Floats, torque: Floats, slope: Floats) -> tuple[Floats, Floats]:
    """Return the points with one more between each two: where their tangents meet, which is where
    one more contact bears, or the middle where they do not meet between them.
    """
    (x, u), (y, v) = ((each[:, :-1], each[:, 1:]) for each in (at, torque))
    with np.errstate(all="ignore"):
        before, after = slope[:, :-1], slope[:, 1:]
        on = (v - y + after * (x - u)) / (before - after)  # angle beyond the first point
        up = before * on
        within = (on > 0) & (on < u - x) & (up > 0) & (up < v - y)
    out = np.empty((2, at.shape[0], 2 * at.shape[1] - 1, *at.shape[2:]))
    out[:, :, ::2] = at, torque
    out[:, :, 1::2] = (
        np.where(within, x + on, (x + u) / 2),
        np.where(within, y + up, (y + v) / 2),
    )
    return out[0], out[1]
