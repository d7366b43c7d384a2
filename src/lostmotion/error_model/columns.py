"""The columns of a pose matrix: the draws of each, and its motion of the tool."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.error_model.draws import Stream
from lostmotion.mechanism.calibration import REMAINING
from lostmotion.parts.term import level_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lostmotion.error_model.closing import Closing
    from lostmotion.laws.distributions import Law
    from lostmotion.mechanism.calibration import Correlations
    from lostmotion.mechanism.placed_terms import PlacedTerm
    from lostmotion.parts.term import Draw, Level
    from lostmotion.spatial import Floats

    Key = tuple[tuple[tuple[str, str], Law], ...]
    Groups = dict[Key, list[int]]


@dataclass(frozen=True, slots=True)
class Draws:
    """The draws that a column is multiplied by. Columns with the same draws are one error; all
    others are uncorrelated.

    robot    stream drawn once per robot; None: the factor is one
    visit    stream drawn at every visit; None: the factor is one
    closing  decides whether the play of a robot is closed; the factor is `closing.standardised` of
             it. None: the factor is one
    """

    robot: Stream | None
    visit: Stream | None
    closing: Closing | None

    @property
    def level(self) -> Level:
        """Return the level of chance."""
        return level_of(self.robot or self.closing, self.visit)

    @property
    def robot_name(self) -> str:
        """Return the name of the stream drawn once per robot; empty for none."""
        return "" if self.robot is None else self.robot.name

    @property
    def draws(self) -> tuple[tuple[tuple[str, str], Law], ...]:
        """Return the streams (level, name) whose draws the column is multiplied by, each with its
        law.
        """
        closing = None if self.closing is None else self.closing.stream
        streams = (("closing", closing), ("robot", self.robot), ("visit", self.visit))
        return tuple(
            ((level, stream.name), stream.law) for level, stream in streams if stream is not None
        )

    @property
    def bound(self) -> float:
        """Return the largest absolute product of the robot and the visit draw, without the closing;
        1 where there are none.
        """
        return math.prod(
            stream.law.bound for stream in (self.robot, self.visit) if stream is not None
        )

    @property
    def limit(self) -> float:
        """Return the size of these draws in a root-sum-square: their bound, or the stated tolerance
        of an unbounded distribution.
        """
        return math.prod(
            stream.law.limit for stream in (self.robot, self.visit) if stream is not None
        )


@dataclass(frozen=True, slots=True)
class Column(Draws):
    """A column of the pose matrix: a term, or a part of one.

    A sided term has one column for poses whose last motion is known, which draws no side, and one
    for all others. A term that exists only where a load closes a play, or only where it leaves the
    play open, has two columns: its mean over robots, and the deviation of one robot from the mean.

    of       the term and its place on the arm
    mean_by  decides whether the play is closed, for the column of the mean; `closing` is the same
             for the column of the deviation
    """

    of: PlacedTerm
    mean_by: Closing | None

    @property
    def name(self) -> str:
        """Return the full name of the term ("joints.A.gearbox.backlash")."""
        return self.of.name

    @property
    def owner(self) -> str:
        """Return the name of the part that the term belongs to ("joints.A.gearbox")."""
        return self.of.owner


@dataclass(frozen=True)
class ToolScrews:
    """Motion of the tool per unit draw: error[pose] = tool[pose] @ draws, along the axes of the
    base frame, at the tool point.

    infos   the draws of each column
    tool    (pose, 6, column) rotation of the tool and displacement of the tool point, rad and m per
            unit draw
    """

    infos: Sequence[Draws]
    tool: Floats

    def columns(self, *levels: Level) -> NDArray[np.int64]:
        """Return the indices of the columns of these levels, in rising order."""
        return np.array([k for k, info in enumerate(self.infos) if info.level in levels], dtype=int)

    @functools.cached_property
    def along_poses(self) -> Floats:
        """Return `tool` as (6, column, pose), contiguous."""
        return np.ascontiguousarray(self.tool.transpose(1, 2, 0))

    @functools.cached_property
    def bias(self) -> Floats:
        """Return the sum of the design columns (pose, 6), rad and m: the mean error, which every
        robot has at every visit.
        """
        out = np.zeros((6, len(self.tool)))
        # one by one: NumPy would sum a single pose in another order
        for k in self.columns("design"):
            out += self.along_poses[:, k]
        return out.T

    @functools.cached_property
    def squares(self) -> Floats:
        """Return the squared displacement of the tool point by each column (column, pose), m^2."""
        return np.asarray(sum(shift**2 for shift in self.along_poses[3:]))

    @functools.cached_property
    def level_squares(self) -> Floats:
        """Return the mean square displacement of the tool point by design, by robot and by visit
        (pose, 3), m^2. Valid for columns with independent draws.
        """
        of_levels = (("robot",), ("visit", "robot x visit"))
        return np.column_stack(
            [
                (self.bias[:, 3:] ** 2).sum(axis=1),
                *(self.squares[self.columns(*levels)].sum(axis=0) for levels in of_levels),
            ]
        )


def grouped(infos: Sequence[Draws], correlations: Correlations | None = None) -> Groups:
    """Return the indices of the columns of each error by its draws.

    Columns that differ only in which of the correlated draws of robots they have are one error.
    """
    out: Groups = {}
    for k, info in enumerate(infos):
        draws = info.draws
        if (
            correlations is not None
            and info.robot is not None
            and info.robot.name in correlations.row
        ):
            others = (draw for draw in draws if draw[0][0] != "robot")
            draws = ((("robot", correlations.key), REMAINING), *others)
        out.setdefault(draws, []).append(k)
    return out


def column_of(
    of: PlacedTerm, side: str | None, joints: Sequence[str], closing: Closing | None, part: str
) -> Column:
    """Return the column of a term, or of one part of it. All parts of a joint share one stream of
    its last motion.
    """
    term = of.term
    owner = f"joints.{joints[of.joint]}" if term.sided and of.joint is not None else of.owner
    robot, visit = (
        _stream(of.owner, term.robot),
        None if side == "known" else _stream(owner, term.visit),
    )
    return Column(
        robot,
        visit,
        closing if part == "changed" else None,
        of,
        closing if part == "mean" else None,
    )


def _stream(owner: str, draw: Draw | None) -> Stream | None:
    return None if draw is None else Stream(draw.name(owner), draw.law)
