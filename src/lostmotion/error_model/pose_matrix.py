"""Arm x poses -> pose matrix: how each elementary error moves the tool, per unit of what is drawn."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.error_model.draws import Stream
from lostmotion.mechanism.carry import tool_twists
from lostmotion.mechanism.serial import Conditions, as_poses, frames
from lostmotion.parts.term import level_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lostmotion.laws.distributions import Law
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.placed_terms import PlacedTerm
    from lostmotion.parts.term import Draw, Level
    from lostmotion.spatial import Floats


@dataclass(frozen=True, slots=True)
class Draws:
    """What a column is multiplied by. Columns with the same draws are one error; any others are uncorrelated."""

    robot: Stream | None
    visit: Stream | None

    @property
    def level(self) -> Level:
        """Return the level of chance."""
        return level_of(self.robot, self.visit)

    @property
    def streams(self) -> tuple[Stream, ...]:
        """Return what is drawn."""
        return tuple(stream for stream in (self.robot, self.visit) if stream is not None)

    @property
    def draws(self) -> tuple[tuple[tuple[str, str], Law], ...]:
        """Return the streams (level, name) whose draws the column is multiplied by, each with its law."""
        both = (("robot", self.robot), ("visit", self.visit))
        return tuple(((level, stream.name), stream.law) for level, stream in both if stream is not None)

    @property
    def bound(self) -> float:
        """Return the largest size of the draw; 1 where nothing is drawn."""
        return math.prod(stream.law.bound for stream in self.streams)

    @property
    def limit(self) -> float:
        """Return the size of the draw in a root-sum-square: the largest, or the amount stated for a distribution without limits."""
        return math.prod(stream.law.limit for stream in self.streams)


@dataclass(frozen=True, slots=True)
class Column(Draws):
    """A column of the pose matrix: a term `of` a part, or the half of a sided term for which the last motion is known, which draws no side."""

    of: PlacedTerm

    @property
    def name(self) -> str:
        """Return the full name of the term ("joints.A.gearbox.backlash")."""
        return self.of.name

    @property
    def owner(self) -> str:
        """Return the part that the term belongs to ("joints.A.gearbox")."""
        return self.of.owner


@dataclass(frozen=True)
class ToolScrews:
    """How far the tool moves per unit draw: error[pose] = tool[pose] @ draws, in the base's axes at the tool point.

    infos   what is drawn, one per column
    tool    (pose, 6, column) rotation of the tool and displacement of the tool point, rad and m
    """

    infos: Sequence[Draws]
    tool: Floats

    def columns(self, *levels: Level) -> NDArray[np.int64]:
        """Return the indices of the columns of these levels."""
        return np.array([k for k, info in enumerate(self.infos) if info.level in levels], dtype=int)

    @functools.cached_property
    def along_poses(self) -> Floats:
        """Return `tool` as (6, column, pose), contiguous."""
        return np.ascontiguousarray(self.tool.transpose(1, 2, 0))

    @functools.cached_property
    def bias(self) -> Floats:
        """Return the sum of the design columns (pose, 6): the error of every robot at every visit."""
        out = np.zeros((6, len(self.tool)))
        for k in self.columns("design"):  # one after the other: NumPy takes another order for one pose alone
            out += self.along_poses[:, k]
        return out.T

    @functools.cached_property
    def squares(self) -> Floats:
        """Return the squared displacement of the tool point by each column (column, pose), m^2."""
        return np.asarray(sum(shift**2 for shift in self.along_poses[3:]))

    @functools.cached_property
    def square_sums(self) -> Floats:
        """Return `squares` summed over the poses (column,), m^2."""
        return np.asarray(self.squares.sum(axis=1))


@dataclass(frozen=True)
class PoseMatrix(ToolScrews):
    """The pose matrix of the study, one column per term; what adds squares takes them from `merged`, where a draw has one column.

    place   (column,) index of the place whose frame `local` is in
    scale   (column,) size of the column: columns of one form, at one place, are in proportion to it at every pose
    local   (pose, 6, column) rad, m per unit draw, in that place's frame
    at      (place, pose, 4, 4) the arm's frames
    way     numbers of the places from the base to the tool
    """

    infos: tuple[Column, ...]
    place: NDArray[np.int64]
    scale: Floats
    local: Floats
    at: Floats
    way: tuple[int, ...]

    def stretch(self, first: int, last: int) -> PoseMatrix:
        """Return the matrix of the poses from number `first` up to `last`."""
        rows = slice(first, last)
        return PoseMatrix(self.infos, self.tool[rows], self.place, self.scale, self.local[rows], self.at[:, rows], self.way)

    def scaled(self, factors: Floats) -> PoseMatrix:
        """Return the matrix with every column scaled by its factor (column,)."""
        return replace(self, tool=self.tool * factors, scale=self.scale * factors, local=self.local * factors)

    @functools.cached_property
    def owners(self) -> tuple[str, ...]:
        """Return the parts in walking order."""
        return tuple(dict.fromkeys(info.owner for info in self.infos))

    @functools.cached_property
    def groups(self) -> dict[tuple[tuple[tuple[str, str], Law], ...], list[int]]:
        """Return the columns of each error by what is drawn for it; the design columns are the group without a draw."""
        out: dict[tuple[tuple[tuple[str, str], Law], ...], list[int]] = {}
        for k, info in enumerate(self.infos):
            out.setdefault(info.draws, []).append(k)
        return out

    @functools.cached_property
    def merged(self) -> ToolScrews:
        """Return one column per draw: columns that are multiplied by the same draw add before they are squared."""
        out = np.empty((6, len(self.groups), len(self.tool)))
        for column, (first, *others) in enumerate(self.groups.values()):
            out[:, column] = self.along_poses[:, first]
            for k in others:
                out[:, column] += self.along_poses[:, k]
        firsts = (self.infos[members[0]] for members in self.groups.values())
        return ToolScrews(tuple(Draws(info.robot, info.visit) for info in firsts), out.transpose(2, 0, 1))


def screws(arm: Arm, q: Floats, *, approach: float | Floats = 0.0) -> PoseMatrix:
    """Return how every elementary error moves the tool at these poses, to first order.

    q (pose, joint) rad or m; `approach` the sign of the joints' last motion, 0 where it differs from visit to visit: one for all, or (pose, joint).
    First order in the errors; `exact.check` reports what that neglects. Raises ValueError for q of another shape or not finite.
    """
    values = as_poses(arm, q)
    at = frames(arm, values)
    arriving = np.asarray(approach, dtype=float)
    sides = _sides(arriving)
    halves = [(of, side) for of in arm.terms for side in (sides if of.term.sided else (None,))]
    place = np.array([of.place for of, _ in halves], dtype=int)
    # Poses lie innermost in memory: every step from here on runs along them.
    local = np.empty((6, len(halves), len(values)))
    conditions = Conditions(arm, values, at)
    for k, (of, side) in enumerate(halves):
        of.term.form.write(conditions(of), of.term.scale, local[:, k])
        if side is not None and of.joint is not None:
            local[:, k] *= _share(arriving if arriving.ndim == 0 else arriving[:, of.joint], known=side == "known")
    tool = tool_twists(arm.tree, at, place, local)
    names = [joint.name for joint in arm.moving]
    infos = tuple(_column(of, side, names) for of, side in halves)
    scale = np.array([of.term.scale for of, _ in halves])
    return PoseMatrix(infos, tool.transpose(2, 0, 1), place, scale, local.transpose(2, 0, 1), at, arm.tree.tool_path)


def _sides(arriving: Floats) -> tuple[str, ...]:
    """Return the columns that a sided term has: one for the poses where the last motion is known, one for those where a side is drawn."""
    return (*(("known",) if (arriving != 0).any() else ()), *(("drawn",) if (arriving == 0).any() else ()))


def _share(arriving: Floats, *, known: bool) -> Floats:
    """Return the factor on a sided screw. Arriving in the positive direction the motor leads and the output trails, so it rests behind."""
    return -arriving if known else (arriving == 0).astype(float)


def _column(of: PlacedTerm, side: str | None, joints: Sequence[str]) -> Column:
    """Return the column of a term, or of one half of a sided term, whose last motion is one stream for all parts of the joint."""
    term = of.term
    owner = f"joints.{joints[of.joint]}" if term.sided and of.joint is not None else of.owner
    return Column(_stream(of.owner, term.robot), None if side == "known" else _stream(owner, term.visit), of)


def _stream(owner: str, draw: Draw | None) -> Stream | None:
    return None if draw is None else Stream(f"{owner}.{draw.stream}", draw.law)


def worst_case(matrix: PoseMatrix) -> Floats:
    """Return the largest possible error of the tool at each pose (pose,), m: |bias| + the sum of all errors at their bounds.

    An upper bound: no draw exceeds it. The two parts of a harmonic count as one, since they share a phase. Infinite where a law is unbounded.
    """
    return np.asarray(np.linalg.norm(matrix.bias[:, 3:], axis=1) + sum(at_bounds(matrix)))


def root_sum_square(matrix: PoseMatrix) -> Floats:
    """Return the error of the tool at each pose by the root-sum-square rule of tolerancing (pose,), m: |bias| + root of the sum of squared limits.

    A distribution without limits counts with the amount that the file states, three standard deviations.
    """
    return np.asarray(np.linalg.norm(matrix.bias[:, 3:], axis=1) + np.sqrt(sum(at_limits(matrix) ** 2)))


def at_limits(matrix: PoseMatrix) -> Floats:
    """Return the size of each independent error at its limit (error, pose), m: its bound, or the stated amount where there is none."""
    columns = matrix.merged
    errors = independent_errors(columns.infos)
    out = np.zeros((max(len(errors), 1), len(matrix.tool)))
    for row, phases in zip(out, errors, strict=False):
        np.sqrt(sum(sum(np.sqrt(columns.squares[k]) * columns.infos[k].limit for k in members) ** 2 for members in phases), out=row)
    return out


def at_bounds(matrix: PoseMatrix) -> Floats:
    """Return the size of each independent error at its bound (error, pose), m: infinite where an error without limits moves the tool."""
    out, infos = at_limits(matrix), matrix.merged.infos
    for row, phases in zip(out, independent_errors(infos), strict=False):
        if any(math.isinf(infos[k].bound) for members in phases for k in members):
            row[:] = np.where(row > 0, np.inf, 0.0)
    return out


def independent_errors(infos: Sequence[Draws]) -> list[list[list[int]]]:
    """Return the drawn columns by independent error, and within it by its two phases where it is a harmonic.

    One stream decides an error's side or phase: that of the visit, or else that of the robot. Columns of one phase, such as a play and its scatter,
    are largest at the same draws and so add; the two phases of a harmonic never are, and count by the root of the sum of their squares.
    """
    out: dict[str, dict[Law, list[int]]] = {}
    for k, info in enumerate(infos):
        if info.streams:
            deciding = info.streams[-1]
            out.setdefault(deciding.name, {}).setdefault(deciding.law, []).append(k)
    return [list(phases.values()) for phases in out.values()]
