"""What does every part add to the tool's error? Mean, covariance and fourth cumulants at fixed poses, part by part: those of independent parts add.

For arms that differ in some parts only: a part that was met before under the same load is not asked again, so an arm with one part exchanged costs
a walk of the loads and a sum. Exact, nothing is fitted; a part whose load changes with the weight outboard of it is asked anew.
"""

from __future__ import annotations

import functools
from collections import OrderedDict
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.arm import conditions, frames
from lostmotion.laws import normal_length_kernel
from lostmotion.laws.normal_length import share_below
from lostmotion.studies import kernel
from lostmotion.studies.cumulants import cumulants
from lostmotion.studies.draws import Stream
from lostmotion.studies.screws import TermInfo

if TYPE_CHECKING:
    from lostmotion.arm import Arm
    from lostmotion.parts.source import Condition, Draw, ErrorSource
    from lostmotion.spatial import Floats
    from lostmotion.studies.cumulants import Cumulants

# Rows of what a part adds: the bias, the covariance's six (xx, yy, zz, yz, xz, xy), the fourth cumulants as a quartic form.
BIAS, COVARIANCE, FOURTH = slice(3), slice(3, 9), slice(9, 9 + len(normal_length_kernel.FOURTHS))
ROWS: Final = FOURTH.stop
# Parts under a load that are remembered: some 50 kB each at 256 poses.
_MOST_KEPT: Final = 3000
_CLOSE: Final = 1e-5
_WIDER: Final = 1.03
_FURTHEST: Final = 200


class Ledger:
    """The poses at which arms are compared that differ in their parts but not in their geometry, and what each part adds there."""

    def __init__(self, arm: Arm, q: Floats) -> None:
        """Walk the arm out once: where every place is does not depend on the parts."""
        self.q = q
        self._at = frames(arm, q)
        self._along = np.ascontiguousarray(self._at.transpose(0, 2, 3, 1))
        self._known: OrderedDict[tuple[int, bytes], tuple[ErrorSource, Floats]] = OrderedDict()

    def of(self, arm: Arm) -> Floats:
        """What does the whole arm's error sum up to? (ROWS, pose), m, m^2 and m^4. `arm` has the places of the one that this was made for."""
        out = np.zeros((ROWS, len(self.q)))
        for owner, place, source, felt in conditions(arm, self.q, self._at):
            out += self._part(owner, place, source, felt)
        return out

    def by_part(self, arm: Arm) -> dict[str, Floats]:
        """What does each part add (ROWS, pose), by its owner's name?"""
        out: dict[str, Floats] = {}
        for owner, place, source, felt in conditions(arm, self.q, self._at):
            part = self._part(owner, place, source, felt)
            out[owner] = out[owner] + part if owner in out else part
        return out

    def _part(self, owner: str, place: int, source: ErrorSource, felt: Condition) -> Floats:
        # The source is kept with what it adds, so that no other one takes its number.
        key = id(source), felt.wrench.tobytes()
        found = self._known.get(key)
        if found is None:
            found = self._known[key] = source, self._added(owner, place, source, felt)
            if len(self._known) > _MOST_KEPT:
                self._known.popitem(last=False)
        else:
            self._known.move_to_end(key)
        return found[1]

    def _added(self, owner: str, place: int, source: ErrorSource, felt: Condition) -> Floats:
        terms = list(source.terms(felt))
        out = np.zeros((ROWS, len(self.q)))
        if not terms:
            return out
        local = np.empty((6, len(terms), len(self.q)))
        for k, term in enumerate(terms):
            local[:, k] = np.atleast_2d(term.screw).T
        shift = np.ascontiguousarray(kernel.carry_to_tool(self._along, np.full(len(terms), place), local)[3:])
        infos = tuple(TermInfo(term.name, owner, term.level, term.bound, _stream(owner, term.robot), _stream(owner, term.visit)) for term in terms)
        design = [k for k, info in enumerate(infos) if info.level == "design"]
        out[BIAS] = shift[:, design].sum(axis=1)
        known = _cumulants(infos)
        normal_length_kernel.add_up(shift, known.pairs, known.pair_values, known.fours, known.four_values, out[COVARIANCE], out[FOURTH])
        return out


@functools.lru_cache(maxsize=1000)
def _cumulants(infos: tuple[TermInfo, ...]) -> Cumulants:
    return cumulants(infos, np.array([k for k, info in enumerate(infos) if info.level != "design"], dtype=int))


def _stream(owner: str, draw: Draw | None) -> Stream | None:
    return None if draw is None else Stream(f"{owner}.{draw.stream}", draw.law)


def mean_square(sums: Floats) -> float:
    """What is the mean square error over the poses, m^2? Exact."""
    return float((sums[BIAS] ** 2).sum(axis=0).mean() + sums[3:6].sum(axis=0).mean())


def halved(part: Floats) -> Floats:
    """What would a part add (ROWS, pose) if all its errors were half as large?"""
    out = part / 2
    out[COVARIANCE] /= 2
    out[FOURTH] /= 8
    return out


def share_within(sums: Floats, limit: float) -> float:
    """Which share of all errors over the poses lies below a limit (m), for sums (ROWS, pose)? Near-normal errors, as `analytic`; NaN where not."""
    covariance = np.ascontiguousarray(sums[COVARIANCE].T[:, [[0, 5, 4], [5, 1, 3], [4, 3, 2]]])
    shares, _ = share_below(np.ascontiguousarray(sums[BIAS].T), covariance, [limit], np.ascontiguousarray(sums[FOURTH].T))
    return float(shares.mean())


def error_at(sums: Floats, level: float) -> float:
    """Which error (m) do this share of all errors over the poses stay below, for sums (ROWS, pose)? Infinite where they have no such figure.

    The root of `share_within`, to 1e-5 of it; what the departure from the normal law and the choice of poses leave open, a full study tells.
    """
    from scipy.optimize import brentq

    squares = (sums[BIAS] ** 2).sum(axis=0) + sums[3:6].sum(axis=0)
    guess = float(np.sqrt(np.quantile(squares, level)))
    if not guess > 0:
        return 0.0 if guess == 0 and not squares.any() else float(np.sqrt(squares.mean() / (1 - level)))

    def beyond(limit: float) -> float:
        return share_within(sums, limit) - level

    here = beyond(guess)
    step = _WIDER if here < 0 else 1 / _WIDER
    for _ in range(_FURTHEST):
        there = beyond(guess * step)
        if not np.isfinite(there):
            break
        if (there < 0) != (here < 0):
            ends = sorted((guess, guess * step))
            return float(brentq(beyond, *ends, xtol=_CLOSE * guess, rtol=_CLOSE))
        guess, here = guess * step, there
    return float("inf")
