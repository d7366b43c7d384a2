"""Error budget by part, kind of error and level, with the effect of halving: exact sums over terms, no sampling."""

from __future__ import annotations

import functools
import math
import operator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, Self

import numpy as np

from lostmotion.error_model.intervals import root_mean_square
from lostmotion.error_model.pose_matrix import screws
from lostmotion.errors import refuse_argument

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.pose_matrix import Column, PoseMatrix
    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.term import Level
    from lostmotion.spatial import Floats

By = Literal["part", "cause", "level", "term"]
# A part whose r.m.s. error alone is a smaller share of the whole's moves the tool by rounding only: it counts as nothing, wherever that is asked.
NOTHING: Final = 1e-12
_BLOCK: Final = 1024
# The three parts of a mean square, by what an error changes with.
_PARTS: Final[dict[Level, int]] = {"design": 0, "robot": 1, "visit": 2, "robot x visit": 2}
# The label by which columns are put together.
LABELS: Final[dict[By, Callable[[Column], str]]] = {
    "part": lambda column: column.owner,
    "cause": lambda column: f"{column.of.kind} {column.of.term.cause}",
    "level": lambda column: ("design", "robot", "visit")[_PARTS[column.level]],
    "term": lambda column: f"{column.owner}.{column.of.term.effect or column.of.term.name}",
}


def label_of(by: By) -> Callable[[Column], str]:
    """Return the label of a column when terms are put together by part, cause, level or term. Raises InputError for another word."""
    if by not in LABELS:
        raise refuse_argument("by", by, "one of " + ", ".join(LABELS), by="cause")
    return LABELS[by]


@dataclass(frozen=True)
class Halving:
    """By how much the 95 % error over the workspace falls (m) when errors are halved, from a smaller paired run of `samples`.

    gains of each part (or of what else was asked for first), causes of each kind of error; `before` is the 95 % error of that run.
    """

    gains: dict[str, Estimate]
    before: float
    samples: int
    causes: dict[str, Estimate]


@dataclass(frozen=True)
class Tally:
    """Sums over poses of mean-square tool errors, m^2; one entry per part in `owners`, or per whatever else terms are put together by.

    Columns with the same draws are one error, the design columns among them: with their sum X and the part x of it that one entry has,
    total   of everything: |X|^2 over all errors
    own     (entry,) |x|^2: the mean square of each entry by itself
    shared  (entry, 3) x.X by design, by robot and by visit; the entries add up to the total
    """

    owners: tuple[str, ...]
    poses: int
    total: float
    own: Floats
    shared: Floats

    @classmethod
    def of(cls, matrix: PoseMatrix, by: By | Callable[[Column], str] = "part") -> Self:
        """Sum up one block of poses, terms put together by part, by cause ("gearbox backlash", at whichever joint), by level, or by a label."""
        label = by if callable(by) else label_of(by)
        names = [label(column) for column in matrix.infos]
        entry = {owner: k for k, owner in enumerate(dict.fromkeys(names))}
        own, shared = np.zeros(len(entry)), np.zeros((len(entry), 3))
        shift, merged, total = matrix.along_poses[3:], matrix.merged, 0.0
        for column, members in enumerate(matrix.groups.values()):
            whole, part = merged.along_poses[3:, column], _PARTS[merged.infos[column].level]
            for name in dict.fromkeys(names[k] for k in members):
                mine = [k for k in members if names[k] == name]
                x = whole if len(mine) == len(members) else shift[:, mine].sum(axis=1)
                own[entry[name]] += np.vdot(x, x)
                shared[entry[name], part] += np.vdot(x, whole)
            total += float(np.vdot(whole, whole))
        return cls(tuple(entry), len(matrix.tool), total, own, shared)

    @property
    def levels(self) -> Floats:
        """Return the mean square by design, by robot and by visit (3,)."""
        return np.asarray(self.shared.sum(axis=0))

    def __add__(self, other: Tally) -> Tally:
        """Put two blocks together."""
        if self.owners != other.owners:
            raise ValueError("blocks of different arms do not add")
        return Tally(self.owners, self.poses + other.poses, self.total + other.total, self.own + other.own, self.shared + other.shared)


@dataclass(frozen=True, slots=True)
class Cost:
    """What one part costs: its r.m.s. error alone (m), its share of the mean square, and the whole's r.m.s. error if it were halved (m).

    Shares add to one. A negative share means that the part happens to cancel others: without it the arm would be worse. `levels` are
    the shares that are the part's by design, by robot and by visit, and add to its share.
    """

    part: str
    alone: float
    share: float
    rms_if_halved: float
    levels: tuple[float, float, float]

    @property
    def name(self) -> str:
        """Name what terms were put together by: the part, the cause, the level or the term; `part` holds it too."""
        return self.part


def costs(tally: Tally) -> list[Cost]:
    """Return the cost of each part over the poses tallied, the largest first; exactly zero where only rounding makes it move the tool (`NOTHING`)."""
    mean_square = tally.total / tally.poses
    out = []
    for owner, own, shared in zip(tally.owners, tally.own / tally.poses, tally.shared / tally.poses, strict=True):
        counts = own > NOTHING**2 * mean_square
        alone, levels = (float(own), shared) if counts else (0.0, np.zeros(3))
        halved = mean_square - float(levels.sum()) + alone / 4
        design, robot, visit = (float(each) / mean_square if mean_square else 0.0 for each in levels)
        out.append(Cost(owner, math.sqrt(alone), design + robot + visit, math.sqrt(max(halved, 0.0)), (design, robot, visit)))
    return sorted(out, key=lambda cost: -cost.share)


@dataclass(frozen=True)
class Budget:
    """Error budget at some poses: their number, their r.m.s. error (m), and the share of each part and each kind of error.

    of_sets   mean squares (m^2) by design, by robot and by visit over each independent set of the poses
    halving   what halving each of them buys there, where that was asked
    """

    where: str
    poses: int
    rms: float
    parts: tuple[Cost, ...]
    causes: tuple[Cost, ...]
    of_sets: tuple[tuple[float, float, float], ...]
    halving: Halving | None = None

    @property
    def levels(self) -> tuple[float, float, float]:
        """Return the shares of the mean square that are by design, by robot and by visit; they add to one, or are none where nothing errs."""
        design, robot, visit = (sum(cost.levels[k] for cost in self.parts) for k in range(3))
        return float(design), float(robot), float(visit)

    def rms_interval(self, *levels: int) -> Estimate:
        """Return the r.m.s. error of these levels of chance together (0 by design, 1 by robot, 2 by visit; all by default), m.

        Exact at the poses; the interval, 95 %, is the uncertainty due to their choice, and has NaN ends where they are no independent sets.
        """
        return root_mean_square(np.array(self.of_sets)[:, list(levels or (0, 1, 2))].sum(axis=1))


def tally(arm: Arm, q: Floats, by: By = "part", *, approach: float = 0.0) -> Tally:
    """Return the error budget of this arm at these poses (pose, joint), rad and m, by part, cause, level or term; exact.

    Raises InputError for another word, and as `screws`.
    """
    return _tallies(arm, q, (by,), approach)[0]


def budget(arm: Arm, q: Floats, where: str = "", *, approach: float = 0.0, replicates: int = 1) -> Budget:
    """Return the error budgets by part and by kind of error at these poses (pose, joint), rad and m; `where` names the poses.

    replicates   independent sets of equal size that they consist of, one after the other
    """
    found = [_tallies(arm, each, ("part", "cause"), approach) for each in np.split(q, replicates)]
    parts, causes = (functools.reduce(operator.add, each) for each in zip(*found, strict=True))
    design, robot, visit = np.transpose([each.levels / each.poses for each, _ in found]).tolist()
    of_sets = tuple(zip(design, robot, visit, strict=True))
    return Budget(where, parts.poses, float(np.sqrt(parts.total / parts.poses)), tuple(costs(parts)), tuple(costs(causes)), of_sets)


def _tallies(arm: Arm, q: Floats, groupings: tuple[By, ...], approach: float) -> list[Tally]:
    out: list[Tally] = []
    for start in range(0, len(q), _BLOCK):
        matrix = screws(arm, q[start : start + _BLOCK], approach=approach)
        block = [Tally.of(matrix, by) for by in groupings]
        out = [whole + part for whole, part in zip(out, block, strict=True)] if out else block
    if not out:
        raise refuse_argument("poses", "none", "at least one pose", at=0)
    return out
