"""From a twist at its place to the twist of the tool, for many terms and poses. Compiled once by Numba and cached."""

from __future__ import annotations

import numpy as np

from lostmotion.compiled import compiled


@compiled
def carry_to_tool(at, place, local):
    """Return the tool's twist (6, term, pose), about the tool point in the base's axes, that follows from a twist at its own place.

    at (place, 4, 4, pose) the arm's frames, the tool's last; place (term,) where each twist is; local (6, term, pose) in that place's frame.
    """
    terms, poses = local.shape[1], local.shape[2]
    out = np.empty((6, terms, poses))
    way = np.empty((3, poses))  # from the place to the tool point
    for t in range(terms):
        frame = at[place[t]]
        if t == 0 or place[t] != place[t - 1]:
            for i in range(3):
                # no array expression: the check of its shapes alone takes Numba three seconds to compile
                for p in range(poses):
                    way[i, p] = at[-1, i, 3, p] - frame[i, 3, p]
        for i in range(3):
            _turn(frame[i], local[0, t], local[1, t], local[2, t], out[i, t])
            _turn(frame[i], local[3, t], local[4, t], local[5, t], out[i + 3, t])
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            _add_swing(out[j, t], way[k], out[k, t], way[j], out[i + 3, t])
    return out


@compiled
def _turn(axes, x, y, z, out):
    a, b, c = axes[0], axes[1], axes[2]
    for p in range(len(out)):
        out[p] = a[p] * x[p] + b[p] * y[p] + c[p] * z[p]


@compiled
def _add_swing(a, b, c, d, out):
    for p in range(len(out)):
        out[p] += a[p] * b[p] - c[p] * d[p]
