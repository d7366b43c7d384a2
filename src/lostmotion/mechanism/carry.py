"""Carry matrices: the twist of the tool per twist at a place. They transfer every error and every
deflection to the tool.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from lostmotion.mechanism.places import Tree
    from lostmotion.spatial import Floats

# Number of poses up to which the terms of a place are carried together.
_FEW: Final = 16


def carry(tree: Tree, at: Floats, place: int) -> Floats:
    """Return the twist of the tool about the tool point, in the base's axes, per twist at a place
    in its own axes: (pose, 6, 6).

    at     (place, pose, 4, 4) frames of all places, m
    place  index of the place

    Zero for a place that does not carry the tool. The transpose is the wrench at the place per
    wrench on the tool (virtual work).
    Source: adjoint map, K. Lynch, F. Park, Modern Robotics, 2017, 3.3.
    """
    out = np.zeros((6, 6, at.shape[1]))  # poses lie innermost in memory
    if place in tree.tool_path:
        frame, tool = at[place].transpose(1, 2, 0), at[-1].transpose(1, 2, 0)
        axes, to_tool = frame[:3, :3], tool[:3, 3] - frame[:3, 3]
        out[:3, :3] = out[3:, 3:] = axes
        # each axis x the vector to the tool point
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            out[3 + i, :3] = axes[j] * to_tool[k] - axes[k] * to_tool[j]
    return out.transpose(2, 0, 1)


def tool_twists(tree: Tree, at: Floats, place: np.ndarray, local: Floats) -> Floats:
    """Return the tool's twists (6, term, pose), rad and m, about the tool point in the base's axes,
    for twists `local` (6, term, pose).

    at     (place, pose, 4, 4) frames of all places, m
    place  (term,) index of the place in whose axes each local twist is stated, in groups of equal
           indices
    local  (6, term, pose) rad and m

    The order of the sum does not depend on the number of poses. Components of a twist that are zero
    at all poses are skipped.
    """
    out = np.zeros_like(local)
    filled = np.asarray(local.any(axis=2))
    first = 0
    for number, group in itertools.groupby(place.tolist()):
        matrix = carry(tree, at, number).transpose(1, 2, 0)
        turns = np.asarray(matrix[:3].any(axis=(0, 2)))
        last = first + sum(1 for _ in group)
        # At few poses a loop over terms costs more than products with zeros, which change no bit.
        together = last - first if local.shape[2] <= _FEW else 1
        for k in range(first, last, together):
            terms = slice(k, k + together)
            for j in np.flatnonzero(filled[:, terms].any(axis=1)):
                rows = slice(0 if turns[j] else 3, 6)
                out[rows, terms] += matrix[rows, None, j] * local[j, terms]
        first = last
    return out
