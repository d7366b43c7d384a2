"""Discs that push against each other without torque: the angle at which they rest, and the wind-up from there.

Each disc held at an angle carries a torque T_d of either sign, which never falls as the angle grows. The output is at the angle where the sum over
the discs is the torque on it. At rest that sum is zero: one disc pushes forwards, another backwards. Wind-up is the angle under torque less the angle
at rest, so it is never negative and grows with the torque.

Source: equilibrium of springs in parallel, each a contact problem of its own (`cycloid.contact`). Checked against one minimisation of the energy of
both discs over all their displacements.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid.drive import loaded_disc

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.drive import Drive
    from lostmotion.spatial import Floats

# Torques of one disc at which its angle is solved: a geometric series with this ratio, from this share of the smallest torque.
_STEP: Final = 1.25
_LEAST: Final = 0.1


@dataclass(frozen=True, slots=True)
class Branches:
    """Effect of clearances and misplaced output pins on the discs' angles, rad.

    `low`, `high` (disc, crank, gearbox): ends of the range in which a disc carries no torque. `shift` (direction, crank, gearbox): added to the angle
    of a disc loaded forwards, and backwards.
    """

    low: Floats
    high: Floats
    shift: Floats


def preloaded_discs(drive: Drive, torque: Floats, crank: Floats, gap: Floats, branches: Branches, *, threads: int = 1) -> tuple[Floats, Floats]:
    """Return the rest angles (end, crank, gearbox), rad, and the angle under each torque (torque, crank, gearbox), rad.

    `torque` (torque,) N m of either sign, not empty, none of them zero; `gap` (disc, crank, gearbox, N) m. The two ends, behind and ahead, differ
    where clearances leave play. Discs' angles are interpolated linearly between torques 25 % apart: to about 0.1 % of the angle. Raises
    DidNotConvergeError where the preload or a torque is beyond the contact law.
    """
    wanted = np.array([0.0, 0.0, *torque])
    most = float(np.abs(torque).max())
    lowest = _LEAST * float(np.abs(torque).min())
    steps = np.arange(math.ceil(math.log(most / lowest) / math.log(_STEP)) + 1, dtype=float)
    loads: Floats = np.asarray(lowest * _STEP**steps, dtype=float)
    tables = [_table(drive, loads, crank, gap, branches, threads)]
    while True:
        torques = np.concatenate([-loads[::-1], [0.0, 0.0], loads])
        angles = _joined(tables, branches)
        low, high = angles[:, 0].max(axis=0), angles[:, -1].min(axis=0)
        least, largest = (sum(carried_torque(each, torques, end) for each in angles) for end in (low, high))
        if (low < high).all() and (least <= wanted.min()).all() and (largest >= wanted.max()).all():
            break
        more = np.asarray(loads[-1] * _STEP ** np.arange(1.0, 4.0), dtype=float)
        tables.append(_table(drive, more, crank, gap, branches, threads))
        loads = np.concatenate([loads, more])
    points = angles.reshape(-1, *angles.shape[2:])
    sums = np.stack([sum(carried_torque(each, torques, point) for each in angles) for point in points])
    # of the two rest angles the first is where the sum stops being negative, the second where it becomes positive
    found = [_crossing(points, sums, sums <= 0 if k == 1 else sums < whole, whole) for k, whole in enumerate(wanted)]
    rest, turned = np.sort(found[:2], axis=0), np.array(found[2:])
    # where clearances leave no play the two ends differ by rounding, which must not appear as a rotation against the torque
    return rest, np.where(torque[:, None, None] > 0, np.maximum(turned, rest[1]), np.minimum(turned, rest[0]))


def _crossing(points: Floats, sums: Floats, below: np.ndarray, whole: float) -> Floats:
    """Return the angle (crank, gearbox) at which a piecewise linear sum over points (point, crank, gearbox) reaches the whole."""
    last, first = (np.where(chosen, points, bound) for chosen, bound in ((below, -np.inf), (~below, np.inf)))
    at = last.argmax(axis=0)[None], first.argmin(axis=0)[None]
    (start, end), (low, high) = ([np.take_along_axis(each, k, axis=0)[0] for k in at] for each in (points, sums))
    share = (whole - low) / np.where(high > low, high - low, 1.0)
    return np.asarray(start + np.clip(share, 0.0, 1.0) * (end - start))


def carried_torque(alone: Floats, loads: Floats, angle: Floats) -> Floats:
    """Return the load of one disc at an angle, linear between its own (load, crank, gearbox); beyond them that of the nearer end."""
    at = np.clip((alone <= angle).sum(axis=0), 1, len(loads) - 1)
    below, above = (np.take_along_axis(alone, k[None], axis=0)[0] for k in (at - 1, at))
    share = np.maximum(angle - below, 0.0) / np.maximum(above - below, np.finfo(float).tiny)
    return np.asarray(loads[at - 1] + np.minimum(share, 1.0) * (loads[at] - loads[at - 1]))


def _table(drive: Drive, loads: Floats, crank: Floats, gap: Floats, branches: Branches, threads: int) -> Floats:
    """Return the discs' angles (way, disc, load, crank, gearbox), rad, under loads (load,) N m of both signs."""
    out = np.empty((2, drive.discs, len(loads), *gap.shape[1:3]))
    for way, sign in enumerate((1.0, -1.0)):
        for disc in range(drive.discs):
            turned = crank + 2 * math.pi * disc / drive.discs
            for k, each in enumerate(loads):
                rotation = loaded_disc(drive, sign * float(each), turned, gap[disc], threads=threads).rotation[0]
                out[way, disc, k] = rotation + sign * branches.shift[way]
    return out


def _joined(tables: list[Floats], branches: Branches) -> Floats:
    """Return the discs' angles (disc, load, crank, gearbox) from the most negative load through no load, twice, to the largest."""
    ahead, behind = np.concatenate(tables, axis=2)
    high, low = np.minimum(branches.high, ahead[:, 0]), np.maximum(branches.low, behind[:, 0])
    middle = (high + low) / 2
    high, low = np.maximum(high, middle), np.minimum(low, middle)
    # each load has its own secant stiffness of the bearings, which must not reverse the order of two close loads
    ahead = np.maximum.accumulate(np.concatenate([high[:, None], ahead], axis=1), axis=1)
    behind = np.minimum.accumulate(np.concatenate([low[:, None], behind], axis=1), axis=1)
    return np.concatenate([behind[:, ::-1], ahead], axis=1)
