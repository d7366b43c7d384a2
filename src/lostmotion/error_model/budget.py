"""Error budget by part, kind of error and level, with the effect of halving each: exact sums over
terms, without sampling.
"""

from __future__ import annotations

import functools
import math
import operator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, Self

import numpy as np

from lostmotion.error_model.few_poses import Squares
from lostmotion.error_model.pose_sets import matrices_of_sets
from lostmotion.errors import refuse_argument

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.error_model.columns import Column, Key
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.error_model.poses import Poses
    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.term import Level
    from lostmotion.spatial import Floats

By = Literal["part", "cause", "level", "term"]
# A part whose own r.m.s. error is a smaller share of the total moves the tool by rounding only. It
# counts as zero in every analysis.
NOTHING: Final = 1e-12
# Each level of chance counts in one of three parts of a mean square: by design, by robot, by visit.
_PARTS: Final[dict[Level, int]] = {"design": 0, "robot": 1, "visit": 2, "robot x visit": 2}
# The label by which columns are grouped.
LABELS: Final[dict[By, Callable[[Column], str]]] = {
    "part": lambda column: column.owner,
    "cause": lambda column: f"{column.of.kind} {column.of.term.cause}",
    "level": lambda column: ("design", "robot", "visit")[_PARTS[column.level]],
    "term": lambda column: f"{column.owner}.{column.of.term.effect or column.of.term.name}",
}


def label_of(by: By) -> Callable[[Column], str]:
    """Return the function that labels a column when terms are grouped by part, cause, level or
    term. Raises InputError for any other word.
    """
    if by not in LABELS:
        raise refuse_argument("by", by, "one of " + ", ".join(LABELS), by="cause")
    return LABELS[by]


@dataclass(frozen=True)
class Halving:
    """Decrease of the 95th percentile of the error (m) when errors are halved, from a smaller run
    with common random numbers.

    gains    decrease by part, or by the grouping that was requested instead
    before   95th percentile of that run with all errors, m
    samples  number of samples of that run
    causes   decrease by kind of error
    """

    gains: dict[str, Estimate]
    before: float
    samples: int
    causes: dict[str, Estimate]


@dataclass(frozen=True)
class Tally:
    """Sums over poses of mean-square tool errors, m^2, with one entry per part in `owners`, or per
    label of another grouping.

    Columns with the same draws are one error; so are all design columns, and all columns whose
    draws a calibration leaves correlated. X is the sum of the columns of one error times their
    draws, and x the part of it that belongs to one entry; products are means over the draws. So a
    correlated part counts with its own variance and its covariance with all others.

    total   sum of |X|^2 over all errors
    own     (entry,) sum of |x|^2: the mean square of each entry by itself
    shared  (entry, 3) sum of x.X by design, by robot and by visit; all entries together add up to
            the total
    """

    owners: tuple[str, ...]
    poses: int
    total: float
    own: Floats
    shared: Floats

    @classmethod
    def of(cls, matrix: PoseMatrix, by: By | Callable[[Column], str] = "part") -> Self:
        """Return the sums over one block of poses, grouped by part, by cause ("gearbox backlash",
        at any joint), by level, by term, or by a label.
        """
        label = by if callable(by) else label_of(by)
        names = [label(column) for column in matrix.infos]
        entry = {owner: k for k, owner in enumerate(dict.fromkeys(names))}
        own, shared = np.zeros(len(entry)), np.zeros((len(entry), 3))
        shift, total = matrix.along_poses[3:], 0.0
        uncorrelated = iter(matrix.uncorrelated.along_poses[3:].transpose(1, 0, 2))
        for key, members in matrix.groups.items():
            part = _PARTS[matrix.infos[members[0]].level]
            entries: dict[str, list[int]] = {}
            for k in members:
                entries.setdefault(names[k], []).append(k)
            if key in matrix.mixtures:
                products = matrix.products[key]
                for name, of_entry in entries.items():
                    rows = [members.index(k) for k in of_entry]
                    own[entry[name]] += products[np.ix_(rows, rows)].sum()
                    shared[entry[name], part] += products[rows].sum()
                total += float(products.sum())
                continue
            whole = next(uncorrelated)
            for name, of_entry in entries.items():
                x = whole if len(of_entry) == len(members) else shift[:, of_entry].sum(axis=1)
                own[entry[name]] += np.vdot(x, x)
                shared[entry[name], part] += np.vdot(x, whole)
            total += float(np.vdot(whole, whole))
        return cls(tuple(entry), len(matrix.tool), total, own, shared)

    @property
    def levels(self) -> Floats:
        """Return the mean squares by design, by robot and by visit (3,), summed over poses, m^2."""
        return np.asarray(self.shared.sum(axis=0))

    def __add__(self, other: Tally) -> Tally:
        """Return the sums over two blocks of poses of one arm. Raises ValueError for different
        entries.
        """
        if self.owners != other.owners:
            raise ValueError("blocks of different arms do not add")
        return Tally(
            self.owners,
            self.poses + other.poses,
            self.total + other.total,
            self.own + other.own,
            self.shared + other.shared,
        )


@dataclass(frozen=True, slots=True)
class Cost:
    """The contribution of one part to the error of an arm.

    part           the part, or the label of another grouping
    alone          r.m.s. error of this part by itself, m
    share          share of the mean-square error; all shares add to one. A negative share means
                   that the part partly cancels others
    rms_if_halved  r.m.s. error of the arm if the errors of this part were halved, m
    levels         share by design, by robot and by visit; the three add to `share`
    """

    part: str
    alone: float
    share: float
    rms_if_halved: float
    levels: tuple[float, float, float]

    @property
    def name(self) -> str:
        """Return `part`: the name of the part, cause, level or term by which terms are grouped."""
        return self.part


def costs(tally: Tally) -> list[Cost]:
    """Return the contribution of each part at the poses of the tally, the largest first; exactly
    zero where it is only rounding (`NOTHING`).
    """
    mean_square = tally.total / tally.poses
    out = []
    for owner, own, shared in zip(
        tally.owners, tally.own / tally.poses, tally.shared / tally.poses, strict=True
    ):
        counts = own > NOTHING**2 * mean_square
        alone, levels = (float(own), shared) if counts else (0.0, np.zeros(3))
        halved = mean_square - float(levels.sum()) + alone / 4
        design, robot, visit = (
            float(each) / mean_square if mean_square else 0.0 for each in levels
        )
        out.append(
            Cost(
                owner,
                math.sqrt(alone),
                design + robot + visit,
                math.sqrt(max(halved, 0.0)),
                (design, robot, visit),
            )
        )
    # what is equal but for rounding stays in the order of the arm
    return sorted(out, key=lambda cost: -float(f"{cost.share:.9g}"))


@dataclass(frozen=True)
class Budget:
    """Error budget at some poses: their number, the r.m.s. error (m), and the contribution of each
    part and each kind of error.

    where     name of the poses
    squares   mean squares by level over each independent set of the poses, and over many others
    halving   effect of halving each part there, where it was requested
    """

    where: str
    poses: int
    rms: float
    parts: tuple[Cost, ...]
    causes: tuple[Cost, ...]
    squares: Squares
    halving: Halving | None = None

    @property
    def levels(self) -> tuple[float, float, float]:
        """Return the shares of the mean square by design, by robot and by visit; they add to one,
        or are zero for an arm without errors.
        """
        design, robot, visit = (sum(cost.levels[k] for cost in self.parts) for k in range(3))
        return float(design), float(robot), float(visit)

    def rms_interval(self, *levels: int) -> Estimate:
        """Return the r.m.s. error (m) of these levels of chance together: 0 by design, 1 by robot,
        2 by visit; all by default.

        The value is exact at the poses. The 95 % interval is the uncertainty due to their choice;
        its ends are NaN without independent sets of poses, and as in `known_ends` where the poses
        are too few.
        """
        weights = np.isin(range(3), levels or (0, 1, 2)).astype(float)
        return self.squares.known_ends(self.squares.root_mean_square(weights), weights)


def tally(arm: Arm, q: Floats, by: By = "part", *, approach: float = 0.0) -> Tally:
    """Return the exact error budget of an arm at the poses q (pose, joint), rad and m, by part,
    cause, level or term.

    `approach` as in `screws`. Raises InputError for no poses or any other grouping, and ValueError
    as `screws` does.
    """
    (((found,),), _) = _sums(arm, q, (by,), approach, 1)
    return found


def budget(
    arm: Arm,
    q: Floats,
    where: str = "",
    *,
    approach: float = 0.0,
    replicates: int = 1,
    many: Poses | None = None,
) -> Budget:
    """Return the error budgets by part and by kind of error at the poses q (pose, joint), rad and
    m; `where` names the poses.

    approach     sign of the joints' last motion, as in `screws`
    replicates   number of independent sets of equal size that the poses consist of, one after
                 another
    many         poses by which to check whether these are too few (`many_poses`)

    Raises InputError for no poses, ValueError as `screws` does or where the sets would differ in
    size.
    """
    found, squares = sums(arm, q, ("part", "cause"), approach, replicates, many)
    parts, causes = (functools.reduce(operator.add, each) for each in zip(*found, strict=True))
    rms = float(np.sqrt(parts.total / parts.poses))
    return Budget(where, parts.poses, rms, tuple(costs(parts)), tuple(costs(causes)), squares)


def sums(
    arm: Arm,
    q: Floats,
    groupings: Sequence[By | Callable[[Column], str]],
    approach: float = 0.0,
    replicates: int = 1,
    many: Poses | None = None,
) -> tuple[list[list[Tally]], Squares]:
    """Return the exact error budget of each independent set of poses for each grouping, and the
    mean squares over them and over many poses; arguments and errors as for `budget`.
    """
    found, squares = _sums(arm, q, groupings, approach, replicates)
    beside = [] if many is None else _sums(arm, many.q, (), approach, many.replicates)[1]
    return found, Squares.of(squares, beside)


def budget_changes(
    before: Arm,
    after: Arm,
    q: Floats,
    labels: Sequence[Callable[[Column], str]],
    *,
    approach: float = 0.0,
    replicates: int = 1,
) -> list[list[dict[str, float]]]:
    """Return the contribution of each part to the change of the mean-square error from one arm to
    another, m^2, over each independent set of poses one dictionary for each label.

    X and Y are the sums of the columns of one error (the same draws) before and after, x and y the
    parts of them that belong to one entry. The entry contributes (y - x).(X + Y): these add to the
    change of the mean square exactly, and an entry that moves the tool as before contributes
    nothing, also where others no longer add to it.

    q       (pose, joint) rad or m: both arms stand there
    labels  by which columns are grouped, `label_of("part")`

    Other arguments and errors as for `budget`.
    """
    of_sets: list[list[dict[str, float]]] = [[{} for _ in labels] for _ in range(replicates)]
    poses = len(q) // replicates
    blocks = (matrices_of_sets(arm, q, replicates, approach=approach) for arm in (before, after))
    for (at, one), (_, other) in zip(*blocks, strict=True):
        matrices, out = (one, other), of_sets[at]
        for draws in dict.fromkeys(draws for matrix in matrices for draws in matrix.groups):
            if any(draws in matrix.mixtures for matrix in matrices):
                _add_correlated_changes(matrices, draws, labels, out, poses)
                continue
            found = [matrix.along_poses[3:, matrix.groups.get(draws, [])] for matrix in matrices]
            both = sum(each.sum(axis=1) for each in found)
            for label, changes in zip(labels, out, strict=True):
                for sign, matrix, columns in zip((-1.0, 1.0), matrices, found, strict=True):
                    names = [label(matrix.infos[k]) for k in matrix.groups.get(draws, [])]
                    for name in dict.fromkeys(names):
                        own = columns[:, [k for k, other in enumerate(names) if other == name]].sum(
                            axis=1
                        )
                        changes[name] = (
                            changes.get(name, 0.0) + sign * float(np.vdot(own, both)) / poses
                        )
    return of_sets


def _add_correlated_changes(
    matrices: Sequence[PoseMatrix],
    draws: Key,
    labels: Sequence[Callable[[Column], str]],
    out: Sequence[dict[str, float]],
    poses: int,
) -> None:
    """Add the contributions of the columns with these correlated draws, before and after, to the
    changes of `budget_changes`.
    """
    infos, shifts, spread, signs = [], [], [], []
    for sign, matrix in zip((-1.0, 1.0), matrices, strict=True):
        members = matrix.groups.get(draws, [])
        correlations = matrix.correlations
        if correlations is None or not members:
            continue
        infos += [matrix.infos[k] for k in members]
        shifts.append(matrix.along_poses[3:, members])
        spread.append(
            correlations.factor[[correlations.row[matrix.infos[k].robot_name] for k in members]]
        )
        signs += [sign] * len(members)
    shift, weights = np.concatenate(shifts, axis=1), np.concatenate(spread)
    found = np.array(signs) * ((weights @ weights.T) * sum(x @ x.T for x in shift)).sum(axis=1)
    for label, changes in zip(labels, out, strict=True):
        for info, change in zip(infos, found.tolist(), strict=True):
            changes[label(info)] = changes.get(label(info), 0.0) + change / poses


def _sums(
    arm: Arm,
    q: Floats,
    groupings: Sequence[By | Callable[[Column], str]],
    approach: float,
    replicates: int,
) -> tuple[list[list[Tally]], list[Floats]]:
    """Return the budgets of each independent set of poses, for each grouping, and the mean squares
    by level at each of its poses (pose, 3).
    """
    if not len(q):
        raise refuse_argument("poses", "none", "at least one pose", at=0)
    found: list[list[Tally]] = [[] for _ in range(replicates)]
    squares: list[list[Floats]] = [[] for _ in range(replicates)]
    for at, matrix in matrices_of_sets(arm, q, replicates, approach=approach):
        here = [Tally.of(matrix, by) for by in groupings]
        before = found[at]
        found[at] = [x + y for x, y in zip(before, here, strict=True)] if before else here
        squares[at].append(matrix.merged.level_squares)
    return found, [np.concatenate(each) for each in squares]
