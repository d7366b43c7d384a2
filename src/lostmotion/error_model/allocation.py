"""Allocation of a target to all items: the mean square error as a quadratic form in the items'
factors, and factors of equal effect.

With bias b = sum f_k b_k and independent draws of variance f_k^2 v_k, the mean square over the
poses is f' A f, A = <b_j . b_k> + diag <v_k>; items that share a draw, such as backlash and
hysteresis of one joint, have its product as well. The contribution of item k is f_k (A f)_k:
contributions add up to the mean square, and a negative one cancels others. Equal contributions
minimise f' A f / 2 - sum log f_k, which is convex (S. Maillard, T. Roncalli, J. Teiletche, J.
Portfolio Management 36 (2010) 60, for contributions to a variance).
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.budget import NOTHING as NOTHING_OF_RMS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lostmotion.error_model.items import Item
    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.spatial import Floats

# An item with a smaller share of the mean square does not move the tool: the threshold of the error
# budget, squared.
NOTHING: Final = NOTHING_OF_RMS**2
_ROUNDS: Final = 200
_CLOSE: Final = 1e-12
# Factors that differ more follow from a form in which items cancel each other at every size.
_WIDEST: Final = 1e6


def mean_square_form(
    matrix: PoseMatrix, items: Sequence[Item], *, visits_only: bool = False
) -> Floats:
    """Return the matrix (item, item), m^2, of the mean square error over the poses, factors @
    matrix @ factors.

    With `visits_only` only terms that differ between visits count: no bias, nothing drawn once per
    robot.
    """
    item_of = {column: k for k, item in enumerate(items) for column in item.columns}
    shift, out = matrix.along_poses[3:], np.zeros((len(items), len(items)))
    for key, members in matrix.groups.items():
        if visits_only and matrix.infos[members[0]].visit is None:
            continue
        if key in matrix.mixtures:
            of_item = np.array([item_of[column] for column in members])
            np.add.at(out, (of_item[:, None], of_item), matrix.products[key] / len(matrix.tool))
            continue
        own = {
            k: np.zeros_like(shift[:, 0])
            for k in dict.fromkeys(item_of[column] for column in members)
        }
        for column in members:
            own[item_of[column]] += shift[:, column]
        # Columns with the same draws add before they are squared, so that items which share a draw
        # have a product.
        for (i, x), (j, y) in itertools.product(own.items(), repeat=2):
            out[i, j] += float(np.vdot(x, y)) / len(matrix.tool)
    return out


def moving(form: Floats) -> np.ndarray:
    """Return which items move the tool (item,)."""
    return np.asarray(np.diag(form) > NOTHING * max(float(np.diag(form).sum()), 0.0))


def equal_effect(form: Floats) -> Floats | None:
    """Return factors (item,) with which every item that moves the tool contributes 1 m^2 to the
    mean square; NaN for the others.

    None where no such factors exist, because items cancel each other at every size.
    """
    moves = moving(form)
    if not moves.any():
        return None
    solved = _equal_parts(form[np.ix_(moves, moves)], np.zeros(int(moves.sum())), 1.0)
    if solved is None:
        return None
    out = np.full(len(form), np.nan)
    out[moves] = solved
    return out


def equal_effect_within(
    form: Floats, most: Floats, part: float
) -> tuple[Floats, NDArray[np.bool_]] | None:
    """Return factors (item,) with which every item contributes `part`, m^2, limited to `most`, and
    which items are at that limit.

    NaN for items that do not move the tool; None as for `equal_effect`.
    """
    moves = moving(form)
    fixed = np.zeros(len(form), bool)
    while True:
        free = moves & ~fixed
        factors = np.where(fixed, most, np.nan)
        if free.any():
            solved = _equal_parts(
                form[np.ix_(free, free)], form[np.ix_(free, fixed)] @ most[fixed], part
            )
            if solved is None:
                return None
            factors[free] = solved
        over = free & (np.where(free, factors, 0.0) > most)
        if not over.any():
            return factors, fixed
        fixed |= over


def _equal_parts(form: Floats, pull: Floats, part: float) -> Floats | None:
    """Return the minimum of f' form f / 2 + pull . f - part sum log f, where every f_k (form f +
    pull)_k equals `part`.

    Damped Newton's method for self-concordant functions (S. Boyd, L. Vandenberghe, Convex
    Optimization, 2004, 9.6). None without a minimum.
    """
    scale = np.sqrt(np.diag(form))
    unit, pull = form / np.outer(scale, scale), pull / (scale * np.sqrt(part))
    f = np.full(len(unit), 1 / np.sqrt(len(unit)))
    for _ in range(_ROUNDS):
        slope = unit @ f + pull - 1 / f
        step = np.linalg.solve(unit + np.diag(1 / f**2), slope)
        decrement = np.sqrt(max(float(slope @ step), 0.0))
        f = f - step / (1 + decrement)
        if f.max() > _WIDEST * f.min() or f.max() > _WIDEST:
            return None
        if decrement < _CLOSE:
            break
    if np.abs(f * (unit @ f + pull) - 1).max() > 1e-10:  # noqa: PLR2004 - parts are computed to 1e-9
        return None
    return np.asarray(f * np.sqrt(part) / scale)


def contributions(form: Floats, factors: Floats) -> Floats:
    """Return the contributions (item,) to the mean square, m^2; NaN counts as a factor of 1,
    because that item does not move the tool.
    """
    known = np.where(np.isfinite(factors), factors, 1.0)
    return np.asarray(known * (form @ known))
