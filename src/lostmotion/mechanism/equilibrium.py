"""Where an arm stands under its loads: the twists of its parts under the wrenches that act in the
deflected arm.

Every place k stands at its parent's frame times its own step times exp(e_k), and e_k is the
deflection of the parts there under the wrench on the place, both in the axes of the deflected
place. The loads depend on the frames, so the twists solve e = d(e).

Rounds e <- d(e) from the loads at the command settle stiff arms: their error shrinks each time by
the share that the load takes away from the stiffness, the contraction. Where that is slow or
diverges, Newton's method with the tangent 1 - C dw/de follows the equilibrium from the unloaded arm
to the loaded one. Where the tangent is not positive the arm does not stay there: a finding, with
the place that cannot hold.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Protocol

import numpy as np

from lostmotion.spatial import added_in_order, exp, inverse, rotation_vector

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lostmotion.mechanism.load_gradient import Freedom
    from lostmotion.mechanism.places import Tree
    from lostmotion.spatial import Floats

# Change of the deflection that remains, as a share of it.
_PRECISION: Final = 1e-9
# The same on the way from the unloaded to the loaded arm.
_ROUGH: Final = 1e-4
# Deflections that are rounding, as a share of the arm's length.
_ROUNDING: Final = 1e-14
# Rounds of the fixed point, and the contraction above which Newton's method follows.
_ROUNDS: Final = 16
_SLOW: Final = 0.3
# Rounds after which parts within plays keep their sides: a load that a play reverses would else
# change them for ever.
_PLAY_ROUNDS: Final = 4
# Steps of the load from the unloaded to the loaded arm: a smaller one from where one failed, a
# larger one after one that did not; and Newton's steps in each.
_LOAD_STEPS: Final = (1, 1 / 8, 1 / 16, 1 / 32, 1 / 64, 1 / 128, 1 / 256)
_NEWTON_STEPS: Final = 12
# A spring that is wound by more than a turn holds nothing: its frame comes round to balance again.
_TURN: Final = 2 * math.pi
# Largest step of Newton's method, as a share of the arm's length.
_LONGEST: Final = 0.5


class Deflection(Protocol):
    """How an arm deflects in given frames."""

    @property
    def freedoms(self) -> Sequence[Freedom]:
        """Return the freedoms of the tangent; none for an arm so stiff that it needs none."""
        ...

    def twists(
        self, frames: Floats, rows: NDArray[np.int64], *, play: bool = True
    ) -> tuple[Floats, Floats]:
        """Return the twists (place, pose, 6) of all parts without those of plays that a load
        closes, and the latter, at the poses in these rows, for frames (place, pose, 4, 4).

        play  compute the latter; else they are zero
        """
        ...

    def tangent(self, frames: Floats, rows: NDArray[np.int64]) -> tuple[Floats, Floats]:
        """Return the change of the deflections per deflection (pose, freedom, freedom), and the
        compliance of each freedom (pose, freedom).
        """
        ...


@dataclass(frozen=True, eq=False, repr=False)
class Equilibrium:
    """The frames in which an arm stands under its loads, and how they were found.

    command      (place, pose, 4, 4) frames that the command asks for, m
    frames       (place, pose, 4, 4) frames in equilibrium, m; NaN where there is none
    twists       (place, pose, 6) deflections in the places' own axes, rad and m
    contraction  (pose,) factor by which a round shrank the error; NaN where none was left
    rounds       (pose,) number of evaluations of the deflections
    falls_at     (pose,) index of the place whose springs cannot hold the load; -1 where the arm
                 stands
    """

    command: Floats
    frames: Floats
    twists: Floats
    contraction: Floats
    rounds: NDArray[np.int64]
    falls_at: NDArray[np.int64]

    def rows(self, rows: slice | NDArray[np.int64]) -> Equilibrium:
        """Return the equilibrium at the poses in these rows."""
        return replace(
            self,
            command=self.command[:, rows],
            frames=self.frames[:, rows],
            twists=self.twists[:, rows],
            contraction=self.contraction[rows],
            rounds=self.rounds[rows],
            falls_at=self.falls_at[rows],
        )


class ElasticChain:
    """The places of an arm at some poses, which twists displace."""

    def __init__(self, tree: Tree, frames: Floats) -> None:
        """Compute the pose of each place relative to its parent, from frames (place, pose, 4,
        4).
        """
        self._parents = [place.parent for place in tree.places]
        self._base = frames[0]
        self._steps = inverse(frames[self._parents[1:]]) @ frames[1:]
        self.length = added_in_order(np.linalg.norm(self._steps[..., :3, 3], axis=-1), 0)

    def displaced(self, twists: Floats, rows: NDArray[np.int64] | slice) -> Floats:
        """Return the frames (place, pose, 4, 4) at the poses in these rows, with every place
        displaced by its twist (place, pose, 6) in its own axes.
        """
        base = self._base[rows]
        out = np.empty((len(self._parents), *base.shape))
        moved = np.flatnonzero(twists.any(axis=(1, 2)))
        own = dict(zip(moved.tolist(), exp(twists[moved]), strict=True))
        out[0] = base @ own[0] if 0 in own else base
        for k, parent in enumerate(self._parents[1:], start=1):
            step = self._steps[k - 1, rows]
            np.matmul(out[parent], step @ own[k] if k in own else step, out=out[k])
        return out


def settle(tree: Tree, frames: Floats, deflection: Deflection) -> Equilibrium:
    """Return where an arm stands that is commanded to these frames (place, pose, 4, 4).

    What remains of the twists is below 1e-9 of their sum. Where the arm would leave its
    equilibrium, or has none, the frames are NaN, and `falls_at` is the place that cannot hold.
    """
    # NumPy's product may round by the order in memory: in this one, a pose has the same bits alone
    # as among others
    frames = np.ascontiguousarray(frames)
    found = _Settling(ElasticChain(tree, frames), deflection, frames)
    slow = found.by_rounds()
    if deflection.freedoms:
        stood = np.setdiff1d(np.arange(frames.shape[1]), slow)
        fell = stood[found.falling(stood, np.ones(len(stood))) >= 0]
        found.by_newton(np.concatenate([slow, fell]))
    else:
        found.falls_at[slow] = found.weakest(slow)
    stands = found.frames(np.arange(frames.shape[1]))
    stands[:, found.falls_at >= 0] = np.nan
    return Equilibrium(
        frames, stands, found.twists, found.contraction, found.rounds, found.falls_at
    )


def displacement(equilibrium: Equilibrium) -> Floats:
    """Return the exact rotation and displacement of the tool (6, pose) from its command, rad and m,
    in the base's axes: a rotation vector, and the path of the tool point.
    """
    stands, command = equilibrium.frames[-1], equilibrium.command[-1]
    turned = stands[:, :3, :3] @ command[:, :3, :3].transpose(0, 2, 1)
    vector = rotation_vector(turned)
    return np.concatenate([vector.T, (stands[:, :3, 3] - command[:, :3, 3]).T])


class _Settling:
    """The twists of an arm on the way to its equilibrium; arrays as those of `Equilibrium`."""

    def __init__(self, chain: ElasticChain, deflection: Deflection, command: Floats) -> None:
        """Start at the command."""
        self.chain, self._deflection, self._command = chain, deflection, command
        places, poses = command.shape[:2]
        self.twists = np.zeros((places, poses, 6))
        self._in_play = np.zeros((places, poses, 6))
        self.contraction = np.zeros(poses)
        self.rounds = np.zeros(poses, dtype=np.int64)
        self.falls_at = np.full(poses, -1)

    def by_rounds(self) -> NDArray[np.int64]:
        """Repeat e <- d(e) until little remains. Return the poses where that is slow."""
        here = np.arange(len(self.rounds))
        slow, before = [], np.full(len(here), np.nan)
        for number in range(_ROUNDS):
            new = self._deflected(here, self.frames(here), play=number < _PLAY_ROUNDS)
            step = self._size(new - self.twists[:, here], here)
            self.twists[:, here] = new
            counts = step > _ROUNDING * self.chain.length[here]
            ratio = np.where(counts, step / np.where(counts, before, 1.0), 0.0)
            if number:
                self.contraction[here] = np.where(counts, ratio, self.contraction[here])
                shrinks = ratio < 1
                remains = step * ratio / np.where(shrinks, 1 - ratio, 1.0)
                small = remains <= _PRECISION * self._size(new, here)
                # the first ratio alone may be small by chance, as where two drives cancel
                done = ~counts | (shrinks & small & (number > 1))
            else:
                done = ~counts
            stuck = ~done & (ratio > _SLOW) & (number > _PLAY_ROUNDS)
            slow.append(here[stuck])
            kept = ~(done | stuck)
            here, before = here[kept], step[kept]
            if not len(here):
                break
        return np.sort(np.concatenate([*slow, here]))

    def by_newton(self, rows: NDArray[np.int64]) -> None:
        """Follow the equilibrium of these poses from the unloaded to the loaded arm by Newton's
        method, and mark those that fall on the way.
        """
        self.twists[:, rows] = 0.0
        steps, here = np.array(_LOAD_STEPS), rows
        # of each pose: share of the load at which it stands, its twists there, which step is next
        stood, size = np.zeros(len(rows)), np.zeros(len(rows), dtype=np.int64)
        while len(here):
            kept = self.twists[:, here].copy()
            share = np.minimum(stood + steps[size], 1.0)
            self.twists[:, here] *= np.where(stood > 0, share / np.where(stood > 0, stood, 1), 1)[
                :, None
            ]
            open_ = self._solve(here, share)
            falls = self.falling(here, share)
            falls[open_] = np.where(falls[open_] < 0, self.weakest(here[open_]), falls[open_])
            self.falls_at[here] = falls
            fails = falls >= 0
            self.twists[:, here[fails]] = kept[:, fails]
            stood = np.where(fails, stood, share)
            size = np.where(fails, size + 1, np.maximum(size - 1, 1))
            on = (stood < 1) & (size < len(steps))
            here, stood, size = here[on], stood[on], size[on]

    def _solve(self, rows: NDArray[np.int64], share: Floats) -> NDArray[np.bool_]:
        """Solve e = share d(e) at these poses by Newton's method, for a share of the load each.
        Return whether it did not converge.
        """
        places = [each.place for each in self._deflection.freedoms]
        components = [each.component for each in self._deflection.freedoms]
        open_ = np.ones(len(rows), dtype=bool)
        before = np.full(len(rows), np.inf)
        for number in range(_NEWTON_STEPS):
            on = np.flatnonzero(open_)
            here, part = rows[on], share[on]
            frames = self.frames(here)
            rest = part[:, None] * self._deflected(here, frames, play=number < _PLAY_ROUNDS)
            rest -= self.twists[:, here]
            tangent, _ = self._deflection.tangent(frames, here)
            matrix = (1 + _ROUNDING) * np.eye(len(places)) - part[:, None, None] * tangent
            step = rest.copy()
            # the rounding keeps it from being singular, but for tangents beyond 1/_ROUNDING: there
            # a step by substitution does not converge
            matrix[np.abs(tangent).max(axis=(1, 2)) > 1 / _ROUNDING] = np.eye(len(places))
            step[places, :, components] = np.linalg.solve(
                matrix, rest[places, :, components].T[..., None]
            )[..., 0].T
            size, whole = self._size(step, here), self._size(self.twists[:, here], here)
            step *= np.minimum(1.0, _LONGEST * self.chain.length[here] / np.maximum(size, 1e-300))[
                :, None
            ]
            self.twists[:, here] += step
            self.contraction[here] = np.where(np.isfinite(before[on]), size / before[on], 0.0)
            before[on] = size
            limit = np.maximum(
                np.where(part == 1, _PRECISION, _ROUGH) * whole,
                _ROUNDING * self.chain.length[here],
            )
            open_[on] = ~(size <= limit)
            if not open_.any():
                break
        return open_

    def falling(self, rows: NDArray[np.int64], share: Floats) -> NDArray[np.int64]:
        """Return the place that cannot hold at each of these poses under a share of its load; -1
        where the tangent is positive and no spring is wound by a turn or more.
        """
        out = np.full(len(rows), -1)
        if not len(rows):
            return out
        tangent, compliance = self._deflection.tangent(self.frames(rows), rows)
        broken = ~np.isfinite(tangent).all(axis=(1, 2))
        tangent[broken] = 0.0
        loaded = share[:, None, None] * tangent
        places = np.array([each.place for each in self._deflection.freedoms])
        # no eigenvalue is larger than this norm: most arms need no eigenvalues at all
        soft = np.flatnonzero(np.abs(loaded).sum(axis=2).max(axis=1) >= 1)
        if len(soft):
            values, modes = np.linalg.eig(loaded[soft])
            worst, pose = values.real.argmax(axis=1), np.arange(len(soft))
            # strain energy of the mode in each freedom
            energy = np.abs(modes[pose, :, worst]) ** 2
            energy /= np.where(compliance > 0, compliance, np.inf)[soft]
            falls = values.real[pose, worst] >= 1
            out[soft[falls]] = places[energy.argmax(axis=1)][falls]
        out[broken] = places[0]
        turned = np.linalg.norm(self.twists[:, rows, :3], axis=2)
        wound = turned.max(axis=0) > _TURN
        out[wound] = turned.argmax(axis=0)[wound]
        return out

    def weakest(self, rows: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the place that turns most at each of these poses."""
        return np.asarray(np.abs(self.twists[:, rows, :3]).sum(axis=2).argmax(axis=0))

    def _deflected(self, rows: NDArray[np.int64], frames: Floats, *, play: bool) -> Floats:
        smooth, in_play = self._deflection.twists(frames, rows, play=play)
        self.rounds[rows] += 1
        if play:
            self._in_play[:, rows] = in_play
        return smooth + self._in_play[:, rows]

    def frames(self, rows: NDArray[np.int64]) -> Floats:
        """Return the frames at these poses; those of the command where nothing deflects."""
        twists = self.twists[:, rows]
        still = np.asarray(~twists.any(axis=(0, 2)))
        if still.all():
            return self._command[:, rows]
        out = self.chain.displaced(twists, rows)
        if still.any():
            out[:, still] = self._command[:, rows[still]]
        return out

    def _size(self, twists: Floats, rows: NDArray[np.int64]) -> Floats:
        """Return the sum of the sizes of twists (place, pose, 6), m: turns times the arm's
        length.
        """
        turns, shifts = (
            added_in_order(np.sqrt(added_in_order(each**2, 2)), 0)
            for each in np.split(twists, 2, axis=2)
        )
        return np.asarray(turns * self.chain.length[rows] + shifts)
