"""What does every part add to the tool's error? Mean and covariance at fixed poses, part by part: those of independent parts add.

For arms that differ in some parts only: a part that was met before under the same load is not asked again, so an arm with one part exchanged costs
a walk of the loads and a sum. Exact, nothing is fitted; a part whose load changes with the weight outboard of it is asked anew.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.carry import tool_twists
from lostmotion.mechanism.serial import Conditions, frames
from lostmotion.propagation.error_magnitude import rays_of, share_below

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.placed_terms import PlacedPart
    from lostmotion.parts.error_source import ErrorSource, Friction
    from lostmotion.parts.term import Condition, Draw
    from lostmotion.propagation.error_magnitude import Rays
    from lostmotion.spatial import Floats

# Rows of what a part adds: the bias, and the covariance's xx, yy, zz, yz, xz, xy.
BIAS, COVARIANCE = slice(3), slice(3, 9)
ROWS: Final = 9
_PAIRS: Final = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
# Parts under a load that are remembered: some 20 kB each at 256 poses.
_MOST_KEPT: Final = 5000
_CLOSE: Final = 1e-5
_WIDER: Final = 1.03
_FURTHEST: Final = 200


class Ledger:
    """The poses at which arms are compared that differ in their parts but not in their geometry, and what each part adds there."""

    def __init__(self, arm: Arm, q: Floats) -> None:
        """Walk the arm out once: where every place is does not depend on the parts."""
        self.q = q
        self._at = frames(arm, q)
        self._tree = arm.tree
        self._known: OrderedDict[tuple[int, int, Friction | None, bytes], tuple[ErrorSource, Floats]] = OrderedDict()

    def of(self, arm: Arm) -> Floats:
        """Return the sums of the whole arm's error (ROWS, pose), m and m^2. `arm` has the places of the one that this was made for."""
        out, felt = np.zeros((ROWS, len(self.q))), Conditions(arm, self.q, self._at)
        for part in arm.parts:
            out += self._part(part, felt(part))
        return out

    def _part(self, part: PlacedPart, felt: Condition) -> Floats:
        # The source is kept with what it adds, so that no other one takes its number. One part may sit at several joints.
        # Assumed friction follows from what the joint holds at other poses too, which the wrench here does not say.
        friction = part.source.play_friction(part.motion.holding)
        key = part.place, id(part.source), friction, felt.wrench.tobytes()
        found = self._known.get(key)
        if found is None:
            found = self._known[key] = part.source, self._added(part, felt)
            if len(self._known) > _MOST_KEPT:
                self._known.popitem(last=False)
        else:
            self._known.move_to_end(key)
        return found[1]

    def _added(self, part: PlacedPart, felt: Condition) -> Floats:
        terms = part.source.terms(part.motion)
        out = np.zeros((ROWS, len(self.q)))
        if not terms:
            return out
        local = np.empty((6, len(terms), len(self.q)))
        for k, term in enumerate(terms):
            term.form.write(felt, term.scale, local[:, k])
        shift = tool_twists(self._tree, self._at, np.full(len(terms), part.place), local)[3:]
        groups: dict[tuple[Draw | None, Draw | None], Floats] = {}
        for k, term in enumerate(terms):
            draws = term.robot, term.visit
            groups[draws] = groups[draws] + shift[:, k] if draws in groups else shift[:, k]
        out[BIAS] = groups.pop((None, None), 0.0)
        for drawn in groups.values():
            for row, (i, j) in enumerate(_PAIRS, COVARIANCE.start):
                # Draws have no mean, variance one, and no correlation.
                out[row] += drawn[i] * drawn[j]
        return out


def mean_square(sums: Floats) -> float:
    """What is the mean square error over the poses, m^2? Exact."""
    return float((sums[BIAS] ** 2).sum(axis=0).mean() + sums[3:6].sum(axis=0).mean())


def share_within(sums: Floats, limit: float) -> float:
    """Return the share of all errors over the poses below a limit (m), for sums (ROWS, pose), of normal errors."""
    return _share_below(_rays(sums), limit)


def error_at(sums: Floats, level: float) -> float:
    """Return the error (m) that this share of all errors over the poses stays below, for sums (ROWS, pose), of normal errors; infinite if none does.

    The root of `share_within`, to 1e-5 of it. A full study shows how far parts depart from the normal law, and what the choice of poses leaves open.
    """
    from scipy.optimize import brentq

    squares = (sums[BIAS] ** 2).sum(axis=0) + sums[3:6].sum(axis=0)
    guess = float(np.sqrt(np.quantile(squares, level)))
    if not guess > 0:
        guess = float(np.sqrt(squares.mean() / (1 - level)))
    if not (guess > 0 and np.isfinite(guess)):
        return 0.0 if guess == 0 else float("inf")
    rays = _rays(sums)

    def beyond(limit: float) -> float:
        return _share_below(rays, limit) - level

    here = beyond(guess)
    step = _WIDER if here < 0 else 1 / _WIDER
    for _ in range(_FURTHEST):
        there = beyond(guess * step)
        if not np.isfinite(there):
            break
        if (there < 0) != (here < 0):
            low, high = sorted((guess, guess * step))
            return float(brentq(beyond, low, high, xtol=_CLOSE * guess, rtol=_CLOSE))
        guess, here = guess * step, there
    return float("inf")


def _rays(sums: Floats) -> Rays:
    covariance = np.ascontiguousarray(sums[COVARIANCE].T[:, [[0, 5, 4], [5, 1, 3], [4, 3, 2]]])
    return rays_of(covariance, np.ascontiguousarray(sums[BIAS].T))


def _share_below(rays: Rays, limit: float) -> float:
    return float(share_below(rays, np.full((len(rays.square), 1), limit))[0].mean())
