"""Compiled inverse kinematics of closed chains: drives and passive joints together, by damped
Newton steps from assembled poses.
"""

from __future__ import annotations

import numpy as np

from lostmotion.compiled import compiled
from lostmotion.mechanism.closed_arrays import MET
from lostmotion.mechanism.closed_kernel import (
    close,
    copy,
    eliminated,
    move,
    rotation_vector,
    same_side,
    write_tool_columns,
)

# Shares of a step that are tried: half of the one before where the chain does not assemble.
_HALVINGS = 7


@compiled
def _difference(reached, wanted, size, out):
    """Write to `out` (6,) the motion from one frame to another: rotation vector, rad, and
    displacement of the origin as a share of the size.
    """
    rotation_vector(wanted, reached, out)
    for i in range(3):
        out[3 + i] = (wanted[i, 3] - reached[i, 3]) / size


@compiled
def _damped(levers, error, out):
    """Write to `out` (drive,) the smallest motion that solves levers @ motion = error by damped
    least squares.
    """
    rows = len(error)
    square, right, far = np.zeros((rows, rows)), np.empty((rows, 1)), 0.0
    for i in range(rows):
        right[i, 0] = error[i]
        far += error[i] * error[i]
        for k in range(rows):
            for d in range(levers.shape[1]):
                square[i, k] += levers[i, d] * levers[k, d]
    # strong damping far from the solution, almost none near it, where Newton's steps converge
    for i in range(rows):
        square[i, i] += 1e-4 * min(far, 1e-2) + 1e-12
    eliminated(square, right)
    out[:] = 0.0
    for d in range(levers.shape[1]):
        for i in range(rows):
            out[d] += levers[i, d] * right[i, 0]


@compiled
def reach(chain, q, motions, wanted, rows, limits, longest, reached, steps, tools, done):
    """Move the drives q (pose, drive) and the passive joints (pose, passive, 3, 4) in place until
    the tool is at the wanted frames (pose, 3, 4), at most so many steps.

    rows     (component,) of the tool's twist that are reached
    limits   (drive, 2) of the drives; longest (drive,) steps of the drives
    reached  (2,) differences in rad, and as a share of the size, below which a pose is reached
    tools    (pose, 3, 4) is filled with the frames of the tool where the steps end, done (pose,)
             with whether they end at the wanted frame

    Every step is halved until the chain assembles without crossing a singularity. Where no part of
    a step does, or the chain does not assemble at the start, the steps end; there the tool of the
    start is NaN.
    """
    drives, components = q.shape[1], len(rows)
    frames = np.empty((len(chain.parent), 3, 4))
    now = np.empty((6 * len(chain.ends), len(chain.order)))
    trial = np.empty_like(now)
    columns, error, whole = np.empty((6, drives)), np.empty(components), np.empty(6)
    levers, step, ahead = np.empty((components, drives)), np.empty(drives), np.empty(drives)
    for p in range(len(q)):
        done[p] = False
        tools[p] = np.nan
        if not close(chain, q[p], motions[p], frames, now, MET) < MET:
            continue
        for turn in range(steps + 1):
            passive = write_tool_columns(chain, frames, now, columns)
            copy(frames[-1], tools[p])
            _difference(frames[-1], wanted[p], chain.size, whole)
            near = True
            for k in range(components):
                error[k] = whole[rows[k]]
                near &= abs(error[k]) < reached[rows[k] // 3]
            if near or turn == steps or not np.isfinite(passive).all():
                done[p] = near
                break
            for k in range(components):
                for d in range(drives):
                    levers[k, d] = columns[rows[k], d] * longest[d]
            _damped(levers, error, step)
            blocked = False
            for d in range(drives):
                if (q[p, d] <= limits[d, 0] + 1e-9 and step[d] < 0) or (
                    q[p, d] >= limits[d, 1] - 1e-9 and step[d] > 0
                ):
                    levers[:, d] = 0.0
                    blocked = True
            if blocked:
                _damped(levers, error, step)
            share, moved = 1 / max(np.abs(step).max(), 1.0), False
            for _ in range(_HALVINGS):
                for d in range(drives):
                    value = q[p, d] + share * longest[d] * step[d]
                    ahead[d] = min(max(value, limits[d, 0]), limits[d, 1])
                there = motions[p].copy()
                move(chain, there, passive @ (ahead - q[p]))
                if close(chain, ahead, there, frames, trial, MET) < MET and same_side(
                    chain, now, trial
                ):
                    for d in range(drives):
                        q[p, d] = ahead[d]
                    for k in range(len(there)):
                        copy(there[k], motions[p, k])
                    copy(trial, now)
                    moved = True
                    break
                share /= 2
            if not moved:
                break
