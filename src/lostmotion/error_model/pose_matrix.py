"""Arm x poses -> screws: by how much does each elementary error move the tool, per unit of what is drawn?"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.error_model.draws import Stream
from lostmotion.laws.distributions import Cosine, Sine
from lostmotion.mechanism.carry import tool_twists
from lostmotion.mechanism.serial import frames, terms

if TYPE_CHECKING:
    from lostmotion.laws.distributions import Law
    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.error_source import Draw, Level
    from lostmotion.spatial import Floats


@dataclass(frozen=True, slots=True)
class TermInfo:
    """What is known of a term without any pose: its name, the part that owns it, what is drawn and how large a draw can be."""

    name: str
    owner: str
    level: Level
    bound: float
    robot: Stream | None
    visit: Stream | None

    @property
    def limit(self) -> float:
        """Return the size of the draw in a root-sum-square: the largest, or the amount stated for a distribution without limits."""
        return math.prod(stream.law.limit for stream in (self.robot, self.visit) if stream is not None)

    @property
    def draws(self) -> tuple[tuple[tuple[str, str], Law], ...]:
        """Return the streams (level, name) whose draws the term multiplies, each with its law."""
        both = (("robot", self.robot), ("visit", self.visit))
        return tuple(((level, stream.name), stream.law) for level, stream in both if stream is not None)

    @property
    def phase(self) -> str:
        """Name what this term draws together with its partner; empty for all but the two parts of a wave."""
        streams = [stream for stream in (self.robot, self.visit) if stream is not None]
        waves = any(isinstance(stream.law, Cosine | Sine) for stream in streams)
        return " x ".join(stream.name for stream in streams) if waves else ""


@dataclass(frozen=True)
class Screws:
    """The pose matrix of the study: error[pose] = tool[pose] @ draws, in the base's axes at the tool point.

    infos   one per term
    place   (term,) index of the place whose frame `local` is in
    local   (pose, 6, term) rad, m per unit draw, in that place's frame
    tool    (pose, 6, term) rotation of the tool and displacement of the tool point, base axes
    at      (place, pose, 4, 4) the arm's frames
    way     numbers of the places from the base to the tool
    """

    infos: tuple[TermInfo, ...]
    place: np.ndarray
    local: Floats
    tool: Floats
    at: Floats
    way: tuple[int, ...]

    def columns(self, *levels: Level) -> np.ndarray:
        """Give the indices of the terms of these levels."""
        return np.array([k for k, info in enumerate(self.infos) if info.level in levels], dtype=int)

    def stretch(self, first: int, last: int) -> Screws:
        """Give the screws of the poses from number `first` up to `last`."""
        return Screws(self.infos, self.place, self.local[first:last], self.tool[first:last], self.at[:, first:last], self.way)

    @functools.cached_property
    def along_poses(self) -> Floats:
        """Give `tool` as (6, term, pose), contiguous."""
        return np.ascontiguousarray(self.tool.transpose(1, 2, 0))

    @functools.cached_property
    def bias(self) -> Floats:
        """Give the sum of the design terms (pose, 6): what every robot does at every visit."""
        out = np.zeros((6, len(self.tool)))
        for k in self.columns("design"):  # one after the other: NumPy takes another order for one pose alone
            out += self.along_poses[:, k]
        return out.T

    @functools.cached_property
    def squares(self) -> Floats:
        """Give the squared displacement of the tool point by each term (term, pose), m^2."""
        return np.asarray(sum(shift**2 for shift in self.along_poses[3:]))

    @functools.cached_property
    def square_sums(self) -> Floats:
        """Give `squares` summed over the poses (term,), m^2."""
        return np.asarray(self.squares.sum(axis=1))

    @functools.cached_property
    def at_limits(self) -> Floats:
        """Return the size of each independent error at its limit (pose, term or wave), m: its bound, or the stated amount where there is none."""
        waves = self._independent
        if not waves:
            return np.zeros((len(self.tool), 1))
        out = np.empty((len(waves), len(self.tool)))
        for row, members in enumerate(waves):
            np.sqrt(sum(self.squares[k] * self.infos[k].limit ** 2 for k in members), out=out[row])
        return out.T

    @functools.cached_property
    def at_bounds(self) -> Floats:
        """Return the size of each independent error at its bound (pose, term or wave), m: infinite where an error without limits moves the tool."""
        endless = [row for row, members in enumerate(self._independent) if any(math.isinf(self.infos[k].bound) for k in members)]
        if not endless:
            return self.at_limits
        out = self.at_limits.copy()
        out[:, endless] = np.where(out[:, endless] > 0, np.inf, 0.0)
        return out

    @functools.cached_property
    def _independent(self) -> list[list[int]]:
        """Return the drawn terms, those of one wave together."""
        waves: dict[str, list[int]] = {}
        for k in self.columns("robot", "visit", "robot x visit"):
            waves.setdefault(self.infos[k].phase or f"\0{k}", []).append(k)
        return list(waves.values())

    @functools.cached_property
    def owners(self) -> tuple[str, ...]:
        """Give the parts in walking order."""
        return tuple(dict.fromkeys(info.owner for info in self.infos))


def screws(arm: Arm, q: Floats, *, approach: float | Floats = 0.0) -> Screws:
    """How does every elementary error move the tool at these poses, to first order?

    q (pose, joint) rad or m; `approach` the sign of the joints' last motion, 0 where it differs from visit to visit: one for all, or (pose, joint).
    First order in the errors; `exact.check` says what that leaves out. Raises ValueError for q of another shape or not finite.
    """
    at = frames(arm, q)
    placed = terms(arm, q, approach=approach, at=at)
    place = np.array([item.place for item in placed], dtype=int)
    # Poses lie innermost in memory: every step from here on runs along them.
    local = np.empty((6, len(placed), len(at[0])))
    for k, item in enumerate(placed):
        local[:, k] = np.atleast_2d(item.term.screw).T
    tool = tool_twists(arm.tree, at, place, local)
    infos = tuple(
        TermInfo(item.name, item.owner, item.term.level, item.term.bound, _stream(item.owner, item.term.robot), _stream(item.owner, item.term.visit))
        for item in placed
    )
    return Screws(infos, place, local.transpose(2, 0, 1), tool.transpose(2, 0, 1), at, arm.tree.way)


def _stream(owner: str, draw: Draw | None) -> Stream | None:
    return None if draw is None else Stream(f"{owner}.{draw.stream}", draw.law)


def worst_case(matrix: Screws) -> Floats:
    """How far can the tool be off at each pose if everything conspires (pose,), m? |bias| + the sum of all terms at their bounds.

    An upper bound: no draw exceeds it. The two parts of a wave count as one, since they share a phase. Infinite where a law is unbounded.
    """
    return np.asarray(np.linalg.norm(matrix.bias[:, 3:], axis=1) + sum(matrix.at_bounds.T))


def root_sum_square(matrix: Screws) -> Floats:
    """How far is the tool off at each pose by the root-sum-square rule of tolerancing (pose,), m? |bias| + root of the sum of squared limits.

    A distribution without limits counts with the amount that the file states, three standard deviations.
    """
    return np.asarray(np.linalg.norm(matrix.bias[:, 3:], axis=1) + np.sqrt(sum(matrix.at_limits.T**2)))
