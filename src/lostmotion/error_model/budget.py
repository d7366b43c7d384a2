"""Which part, kind of error or level of chance costs how much, and what would halving it buy? Exact sums over terms, no sampling."""

from __future__ import annotations

import functools
import operator
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, Self

import numpy as np

from lostmotion.error_model.intervals import root_mean_square
from lostmotion.error_model.pose_matrix import screws
from lostmotion.errors import refuse_argument

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.pose_matrix import Screws, TermInfo
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

By = Literal["part", "cause", "level", "term"]
# A part whose r.m.s. error alone is a smaller share of the whole's moves the tool by rounding only: it counts as nothing, wherever that is asked.
NOTHING: Final = 1e-12
_BLOCK: Final = 1024
# What tells terms of one cause apart: the bearing, what is drawn of a play, a harmonic's number and its phase.
_NOT_CAUSE: Final = re.compile(r"\b(?:inboard|outboard|side held by load|by approach|amount|position)\b|\d+$")
_HARMONIC: Final = re.compile(r"\d+ per turn")


def _level(info: TermInfo) -> str:
    return "visit" if info.level == "robot x visit" else info.level


def _term(info: TermInfo) -> str:
    return info.name.rsplit(" ", 1)[0] if info.phase else info.name


def _cause(info: TermInfo) -> str:
    """Name the kind of error, whichever joint it is at: "gearbox backlash", "link length"."""
    kind, _, member = info.owner.rsplit(".", 1)[-1].partition(" ")
    stem = _term(info).removeprefix(info.owner).lstrip(".")
    if _HARMONIC.search(stem):
        stem = member
    stem = " ".join(_NOT_CAUSE.sub("", stem).split())
    return f"{kind} {stem or 'clearance'}"


# What terms are put together by, and the name of what a term belongs to.
LABELS: Final[dict[By, Callable[[TermInfo], str]]] = {"part": lambda info: info.owner, "cause": _cause, "level": _level, "term": _term}


def label_of(by: By) -> Callable[[TermInfo], str]:
    """How are terms named that are put together by part, cause, level or term? Raises InputError for another word."""
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

    total     of everything: |bias|^2 plus the variances, which add because terms are independent
    variance  of each part's drawn terms; own_bias of its design terms alone; shared_bias their product with the whole bias
    levels    the mean square that is |bias|^2 (design), drawn per robot, and drawn per visit
    of_visits what of `variance` is drawn per visit; None where that was not asked
    """

    owners: tuple[str, ...]
    poses: int
    total: float
    variance: Floats
    own_bias: Floats
    shared_bias: Floats
    levels: Floats
    of_visits: Floats | None = None

    @classmethod
    def of(cls, matrix: Screws, by: By = "part") -> Self:
        """Sum up one block of poses, terms put together by part, by cause ("gearbox backlash", at whichever joint), by level or not at all."""
        shift = matrix.along_poses[3:]
        bias = matrix.bias[:, 3:].T
        label = label_of(by)
        names = [label(info) for info in matrix.infos]
        owners = tuple(dict.fromkeys(names))
        variance, own, shared, of_visits = (np.zeros(len(owners)) for _ in range(4))
        squares = matrix.square_sums
        for k, owner in enumerate(owners):
            part = np.zeros_like(bias)
            for c, info in enumerate(matrix.infos):
                if names[c] == owner and info.level == "design":
                    part += shift[:, c]
                elif names[c] == owner:
                    variance[k] += squares[c]
                    of_visits[k] += squares[c] if info.level != "robot" else 0.0
            own[k] = np.vdot(part, part)
            shared[k] = np.vdot(part, bias)
        whole = float(np.sum(bias * bias))
        robot = float(squares[matrix.columns("robot")].sum())
        visit = float(squares[matrix.columns("visit", "robot x visit")].sum())
        return cls(owners, len(matrix.tool), whole + robot + visit, variance, own, shared, np.array([whole, robot, visit]), of_visits)

    def __add__(self, other: Tally) -> Tally:
        """Put two blocks together."""
        if self.owners != other.owners:
            raise ValueError("blocks of different arms do not add")
        return Tally(
            self.owners,
            self.poses + other.poses,
            self.total + other.total,
            self.variance + other.variance,
            self.own_bias + other.own_bias,
            self.shared_bias + other.shared_bias,
            self.levels + other.levels,
            None if self.of_visits is None or other.of_visits is None else self.of_visits + other.of_visits,
        )


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
    """What does each part cost over the poses tallied, the largest first? Exactly nothing where only rounding makes it move the tool (`NOTHING`)."""
    mean_square = tally.total / tally.poses
    visits = np.full(len(tally.owners), np.nan) if tally.of_visits is None else tally.of_visits
    out = []
    for k, owner in enumerate(tally.owners):
        variance, own, shared, of_visits = (float(x[k]) / tally.poses for x in (tally.variance, tally.own_bias, tally.shared_bias, visits))
        if variance + own <= NOTHING**2 * mean_square:
            variance = own = shared = of_visits = 0.0
        halved = mean_square - shared + own / 4 - 0.75 * variance
        design, robot, visit = (size / mean_square if mean_square else 0.0 for size in (shared, variance - of_visits, of_visits))
        share = (variance + shared) / mean_square if mean_square else 0.0
        out.append(Cost(owner, float(np.sqrt(variance + own)), share, float(np.sqrt(max(halved, 0.0))), (design, robot, visit)))
    return sorted(out, key=lambda cost: -cost.share)


@dataclass(frozen=True)
class Budget:
    """Who is to blame at some poses: how many they are, their r.m.s. error (m), and what each part and each kind of error costs there.

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
        """Give the shares of the mean square that are by design, by robot and by visit; they add to one, or are none where nothing errs."""
        design, robot, visit = (sum(cost.levels[k] for cost in self.parts) for k in range(3))
        return float(design), float(robot), float(visit)

    def sure(self, *levels: int) -> Estimate:
        """Give the r.m.s. error that levels of chance make together (0 by design, 1 by robot, 2 by visit; left out, all), m.

        Exact at the poses; the interval, 95 %, tells what their choice leaves, and has NaN ends where they are no independent sets.
        """
        return root_mean_square(np.array(self.of_sets)[:, list(levels or (0, 1, 2))].sum(axis=1))


def tally(arm: Arm, q: Floats, by: By = "part", *, approach: float = 0.0) -> Tally:
    """What do the terms of this arm add up to at these poses (pose, joint), rad and m? Exact; put together by part, cause, level or term.

    Raises InputError for another word, and as `screws`.
    """
    return _tallies(arm, q, (by,), approach)[0]


def budget(arm: Arm, q: Floats, where: str = "", *, approach: float = 0.0, replicates: int = 1) -> Budget:
    """Which parts and which kinds of error are to blame at these poses (pose, joint), rad and m? `where` says in words which they are.

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
