"""Compiled continuation of closed chains from home, pose by pose."""

from __future__ import annotations

import numpy as np

from lostmotion.compiled import compiled
from lostmotion.mechanism.closed_arrays import ASSEMBLED, MET, NOT_ASSEMBLED, SINGULAR
from lostmotion.mechanism.closed_kernel import close, copy, same_side, write_tool_columns

# Misfit on the way to another pose, and the shortest part of a step.
_NEARLY_MET = 1e-3
_SHORTEST = 2.0**-7


@compiled
def assemble(chain, home, longest, start, before, q, at, motions, columns, problem):
    """Assemble the chain at q (pose, drive), each pose by continuation from home.

    home     (drive,) values of the drives at home; longest (drive,) steps of the drives
    start    (passive, 3, 4) motions at home; before (equation, freedom) Jacobian there, its
             columns in the order of elimination
    at       (place, 4, 4, pose) is filled with the frames, motions (pose, passive, 3, 4) with those
             of the passive joints, columns (pose, 6, drive) with the twists of the tool per motion
             of a drive, rad and shares of the size, problem (pose,) with what prevents assembly
    """
    here, frames = np.empty(q.shape[1]), np.empty((len(chain.parent), 3, 4))
    jacobian = np.empty_like(before)
    for p in range(len(q)):
        most = 1.0
        for d in range(q.shape[1]):
            most = max(most, np.ceil(abs(q[p, d] - home[d]) / longest[d]))
        stride, done, side = 1 / most, 0.0, before.copy()
        step = stride
        for k in range(len(start)):
            copy(start[k], motions[p, k])
        problem[p] = NOT_ASSEMBLED
        while step >= _SHORTEST * stride:
            reach = min(done + step, 1.0)
            if reach > 1 - 1e-9:
                reach = 1.0
            for d in range(q.shape[1]):
                here[d] = home[d] + reach * (q[p, d] - home[d]) if reach < 1 else q[p, d]
            moved = motions[p].copy()
            enough = _NEARLY_MET if reach < 1.0 else MET
            met = close(chain, here, moved, frames, jacobian, enough) < enough
            if met and same_side(chain, side, jacobian):
                done = reach
                for k in range(len(moved)):
                    copy(moved[k], motions[p, k])
                copy(jacobian, side)
                step = min(2 * step, stride)
                if reach == 1.0:
                    problem[p] = ASSEMBLED
                    write_tool_columns(chain, frames, jacobian, columns[p])
                    break
            else:
                step /= 2
                problem[p] = SINGULAR if met else NOT_ASSEMBLED
        write_frames(frames, at, p)


@compiled
def write_frames(frames, at, pose):
    """Write frames (place, 3, 4) of one pose to at[:, :, :, pose]."""
    for k in range(len(frames)):
        for i in range(3):
            for j in range(4):
                at[k, i, j, pose] = frames[k, i, j]
            at[k, 3, i, pose] = 0.0
        at[k, 3, 3, pose] = 1.0
