"""Mean and covariance of the tool's error at fixed poses, summed over independent parts, with a
cache for arms that differ in some parts only.

A part under a load for which its contribution is cached is not evaluated again, so an arm with one
part exchanged costs its loads and a sum. A part whose load changes with the mass outboard of it is
evaluated again. The sums are exact.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import replace
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.error_model.arrival import rp_name
from lostmotion.error_model.closing import mean_and_change
from lostmotion.mechanism.state import state_of
from lostmotion.parts.term import LAST_MOTION
from lostmotion.propagation.error_magnitude import rays_of, share_below

if TYPE_CHECKING:
    from collections.abc import Hashable

    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.placed_terms import PlacedPart
    from lostmotion.parts.error_source import ErrorSource
    from lostmotion.parts.term import Condition, Draw
    from lostmotion.propagation.error_magnitude import Rays
    from lostmotion.spatial import Floats

# Rows of a part's contribution: the bias, and xx, yy, zz, yz, xz, xy of the covariance.
BIAS, COVARIANCE = slice(3), slice(3, 9)
ROWS: Final = 9
_PAIRS: Final = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
# Most cached contributions, of about 20 kB each at 256 poses.
_MOST_CACHED: Final = 5000
_CLOSE: Final = 1e-5
_WIDER: Final = 1.03
_FURTHEST: Final = 200


class ErrorCache:
    """Contributions of parts to the error of arms with one geometry at some poses."""

    def __init__(self, arm: Arm, q: Floats, of: TargetOf = "error") -> None:
        """Compute the frames, which do not depend on the parts. `of`: for a repeatability only what
        differs between visits counts.
        """
        self.q, self._of = q, of
        self._state = state_of(arm, q)
        self._known: OrderedDict[
            tuple[Hashable, ...], tuple[ErrorSource, Floats, dict[Draw, Floats]]
        ] = OrderedDict()

    def of(self, arm: Arm) -> Floats:
        """Return bias and covariance (ROWS, pose), m and m^2, of an arm with the geometry of the
        first one.
        """
        out, felt = np.zeros((ROWS, len(self.q))), replace(self._state, arm=arm).conditions()
        shared: dict[tuple[int | str | None, Draw], Floats] = {}
        for part in arm.parts:
            _, own, common = self._contribution(part, felt(part))
            out += own
            for draw, moved in common.items():
                of = draw.shared or part.joint, draw
                shared[of] = shared[of] + moved if of in shared else moved
        for drawn in shared.values():
            _add_square(out, drawn)
        return out

    def _contribution(
        self, part: PlacedPart, felt: Condition
    ) -> tuple[ErrorSource, Floats, dict[Draw, Floats]]:
        """Return a part, its bias and covariance (ROWS, pose), and what moves the tool (3, pose)
        per unit of each draw that parts share.
        """
        # The source is stored with its contribution, so that its id is not reused. One part may be
        # at several joints.
        # Assumed friction depends on the holding torques at other poses, which are not part of the
        # wrench here.
        friction = part.source.play_friction(part.motion.holding)
        surroundings = felt.temperature_rise, part.motion.rise, part.motion.varies
        key = part.place, id(part.source), friction, surroundings, felt.wrench.tobytes()
        known = self._known.get(key)
        if known is None:
            known = self._known[key] = part.source, *self._computed(part, felt)
            if len(self._known) > _MOST_CACHED:
                self._known.popitem(last=False)
        else:
            self._known.move_to_end(key)
        return known

    def _computed(self, part: PlacedPart, felt: Condition) -> tuple[Floats, dict[Draw, Floats]]:
        terms = part.source.terms(part.motion)
        out = np.zeros((ROWS, len(self.q)))
        if not terms:
            return out, {}
        local = np.empty((6, len(terms), len(self.q)))
        for k, term in enumerate(terms):
            term.form.write(felt, np.array([term.scale]), local[:, k : k + 1])
        shift = self._state.tool_twists(np.full(len(terms), part.place), local)[3:]
        groups: dict[tuple[Draw | None, Draw | None, str | None], Floats] = {}
        for k, term in enumerate(terms):
            columns: dict[str | None, Floats] = {None: shift[:, k]}
            if (friction := term.form.threshold) is not None:
                mean, changed = mean_and_change(friction.share(felt), above=term.form.above)
                columns = {None: shift[:, k] * mean, friction.stream: shift[:, k] * changed}
            for closing, moved in columns.items():
                draws = term.robot, term.visit, closing
                groups[draws] = groups[draws] + moved if draws in groups else moved
        bias = groups.pop((None, None, None), 0.0)
        if self._of == "error":
            out[BIAS] = bias
        else:
            groups = {
                draws: moved
                for draws, moved in groups.items()
                if self._differs_between_visits(draws[1])
            }
        # The sign of the last motion is one draw for all parts of a joint, the temperature and a
        # batch of material for all of the arm: what depends on such a draw alone adds up over the
        # parts before it is squared.
        common: dict[Draw, Floats] = {}
        for (robot, visit, closing), drawn in groups.items():
            draw = robot or visit
            if (
                draw is not None
                and (robot, visit, closing).count(None) > 1
                and (draw.shared or draw == LAST_MOTION)
            ):
                common[draw] = common[draw] + drawn if draw in common else drawn
            else:
                _add_square(out, drawn)
        return out, common

    def _differs_between_visits(self, visit: Draw | None) -> bool:
        """Return whether an error with this draw per visit counts in RP: in the ISO cycle the side
        of the last motion is the same at every visit.
        """
        return visit is not None and not (visit == LAST_MOTION and self._of == "rp_iso")


def _add_square(sums: Floats, drawn: Floats) -> None:
    """Add the covariance of an error (3, pose), m per unit draw, to the sums: draws have mean zero,
    variance one, and no correlation.
    """
    for row, (i, j) in enumerate(_PAIRS, COVARIANCE.start):
        sums[row] += drawn[i] * drawn[j]


def mean_square(sums: Floats) -> float:
    """Return the mean square error over the poses, m^2; exact."""
    return float((sums[BIAS] ** 2).sum(axis=0).mean() + sums[3:6].sum(axis=0).mean())


def share_within(sums: Floats, limit: float) -> float:
    """Return the share of normal errors below a limit (m) over the poses, for bias and covariance
    (ROWS, pose).
    """
    return _share_below(_rays(sums), limit)


def error_at(sums: Floats, level: float) -> float:
    """Return the quantile (m) of normal errors over the poses, for bias and covariance (ROWS,
    pose); infinite where there is none.

    The root of `share_within`, with a relative tolerance of 1e-5.
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


TargetOf = Literal["error", "rp_iso", "rp_any"]
TARGETS: Final[dict[TargetOf, str]] = {
    "error": "95 % error",
    "rp_iso": f"{rp_name(1.0)}, of 95 % of robots",
    "rp_any": f"{rp_name(0.0)}, of 95 % of robots",
}


def approach_for(of: TargetOf) -> float:
    """Return the sign of the joints' last motion for a quantity: fixed in the ISO cycle, 0 where it
    is drawn at every visit.
    """
    return 1.0 if of == "rp_iso" else 0.0
