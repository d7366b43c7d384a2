"""How is a target shared out among all items at once? The mean square is a quadratic form in the items' factors; equal effects follow from it.

With bias b = sum f_k b_k and independent draws of variance f_k^2 v_k, the mean square over the poses is f' A f, A = <b_j . b_k> + diag <v_k>, and
what item k has of it is f_k (A f)_k: these parts add up to the whole exactly, and one below zero cancels part of the others. Equal parts: the minimum
of f' A f / 2 - sum log f_k, which is convex and has but one (S. Maillard, T. Roncalli, J. Teiletche, J. Portfolio Management 36 (2010) 60, of equal
contributions to a variance).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.budget import NOTHING as NOTHING_OF_RMS
from lostmotion.error_model.cumulants import cumulants

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lostmotion.analyses.targets.parameters import Item
    from lostmotion.analyses.targets.yield_ import Yield
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.pose_matrix import Screws
    from lostmotion.spatial import Floats

# An item with a smaller share of the mean square does not move the tool: the budget's rule, squared.
NOTHING: Final = NOTHING_OF_RMS**2
_ROUNDS: Final = 200
_CLOSE: Final = 1e-12
# Factors that differ more come of a form in which items cancel each other for all sizes.
_WIDEST: Final = 1e6


@dataclass(frozen=True)
class Joint:
    """All items sized together: factors (item,), NaN for those that do not move the tool, what each then has of the mean square (item,), m^2.

    value     the error or RP that these sizes are meant to give, m: the target, where the route's own interval ends; less where all are `usual`
    verified  the same by Monte Carlo
    usual     (item,) items that stand at their largest usual size and still have a smaller part than the others: they do not limit the target
    yields    robots that keep the target with these sizes, by the figures that judge them as things are
    """

    factors: Floats
    parts: Floats
    value: Estimate
    verified: Estimate
    usual: NDArray[np.bool_]
    yields: tuple[Yield, ...]


def mean_square_form(matrix: Screws, items: Sequence[Item], *, visits_only: bool = False) -> Floats:
    """Which matrix (item, item), m^2, gives the mean-square error over the poses, factors @ matrix @ factors?

    With `visits_only` only what differs from visit to visit counts: no bias, nothing that was drawn once per robot.
    """
    owner = np.empty(len(matrix.infos), dtype=int)
    for k, item in enumerate(items):
        owner[list(item.columns)] = k
    poses = len(matrix.tool)
    shift = matrix.along_poses[3:]
    out = np.zeros((len(items), len(items)))
    levels = ("visit", "robot x visit") if visits_only else ("robot", "visit", "robot x visit")
    known = cumulants(matrix.infos, matrix.columns(*levels))
    for (i, j), value in zip(known.pairs, known.pair_values, strict=True):
        part = float(np.vdot(shift[:, i], shift[:, j])) * value / poses
        out[owner[i], owner[j]] += part / 2
        out[owner[j], owner[i]] += part / 2
    if not visits_only:
        bias = np.zeros((len(items), 3, poses))
        for column in matrix.columns("design"):
            bias[owner[column]] += shift[:, column]
        flat = bias.reshape(len(items), 3 * poses)
        out += flat @ flat.T / poses
    return out


def moving(form: Floats) -> np.ndarray:
    """Which items move the tool at all (item,)?"""
    return np.asarray(np.diag(form) > NOTHING * max(float(np.diag(form).sum()), 0.0))


def equal_effect(form: Floats) -> Floats | None:
    """Which factors (item,) give all items that move the tool the same part of the mean square, one each? NaN for the others.

    None where no such factors exist, because items cancel each other whatever their size.
    """
    moves = moving(form)
    if not moves.any():
        return None
    found = _equal_parts(form[np.ix_(moves, moves)], np.zeros(int(moves.sum())), 1.0)
    if found is None:
        return None
    out = np.full(len(form), np.nan)
    out[moves] = found
    return out


def equal_effect_within(form: Floats, most: Floats, part: float) -> tuple[Floats, NDArray[np.bool_]] | None:
    """Return factors (item,) with which every item has this part of the mean square, m^2, but none a factor above its `most`; and which stand at it.

    NaN for items that do not move the tool; None as for `equal_effect`.
    """
    moves = moving(form)
    fixed = np.zeros(len(form), bool)
    while True:
        free = moves & ~fixed
        factors = np.where(fixed, most, np.nan)
        if free.any():
            found = _equal_parts(form[np.ix_(free, free)], form[np.ix_(free, fixed)] @ most[fixed], part)
            if found is None:
                return None
            factors[free] = found
        over = free & (np.where(free, factors, 0.0) > most)
        if not over.any():
            return factors, fixed
        fixed |= over


def _equal_parts(form: Floats, pull: Floats, part: float) -> Floats | None:
    """Return the minimum of f' form f / 2 + pull . f - part sum log f, where every f_k (form f + pull)_k equals `part`.

    Newton's method, damped as for any self-concordant function (S. Boyd, L. Vandenberghe, Convex Optimization, 2004, 9.6). None without a minimum.
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


def parts_of(form: Floats, factors: Floats) -> Floats:
    """What has each item of the mean square at these factors (item,), m^2? NaN counts as an item left as it is: it moves nothing."""
    known = np.where(np.isfinite(factors), factors, 1.0)
    return np.asarray(known * (form @ known))
