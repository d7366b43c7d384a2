"""What would help a task, and how much more it would bear: the same robots and runs with errors
removed or scaled.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.remedies import (
    ALL_KNOWN,
    OUTPUT_ENCODERS,
    SIDE_AND_LOAD,
    SIDE_KNOWN,
    TORQUE_SENSORS,
    geometry_of,
    remaining,
)
from lostmotion.errors import InputError
from lostmotion.propagation.task_success import PROCESS_FORCE, judged, own_heats, share_of

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.error_model.columns import Column
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.error_model.task import Program
    from lostmotion.spatial import Floats

# Robots and runs with which remedies are compared, at most.
_ROBOTS: Final = 250
_RUNS: Final = 4
# Parts that are switched off one at a time.
_PARTS: Final = 5
# Largest factor that is tried, and steps of the bisection of its logarithm.
_MOST: Final = 64.0
_STEPS: Final = 9
_PLAYS: Final = frozenset({"play", "hysteresis", "clearance"})
_LEVEL: Final = 0.95
# Of `error_model.remedies`, with the names by which a task calls them.
_NAMES: Final = {
    "calibrated": "calibration of each robot",
    "load compensated": "load and pose compensated",
    SIDE_KNOWN: "side compensated",
    "both": "calibrated, load compensated",
    SIDE_AND_LOAD: "load and side compensated",
    "both, and each robot mapped": "each place taught",
    ALL_KNOWN: "places taught, side known",
    OUTPUT_ENCODERS: "encoders on the outputs",
    TORQUE_SENSORS: "joint-torque sensors",
}
_LOAD_ALONE: Final = frozenset({"load compensated", "both"})
ALL_FROM_ONE_SIDE: Final = "arriving from one side"
WARMED: Final = "warmed up before"
TAUGHT_WARM: Final = "warmed up before, taught warm"


@dataclass(frozen=True)
class Remedied:
    """What is left where some errors are removed, from the same robots and runs.

    success  probability that all tolerances hold
    used     share of the decisive tolerance that 95 % of robots and runs stay within
    """

    name: str
    success: Estimate
    used: float


@dataclass(frozen=True)
class Margin:
    """By how much a property may change with the required probability still met.

    factor  on the property; NaN where no change of it meets the requirement, infinite where it may
            change by more than was tried
    """

    name: str
    factor: float


@dataclass(frozen=True)
class Remedies:
    """What would help.

    before  the same robots and runs as they are
    stages  remedies of a controller or of measurements, ideal ones
    parts   parts without error, by name
    margins how much play, compliance and payload the task would bear
    robots, runs  how many were compared
    """

    before: Remedied
    stages: tuple[Remedied, ...]
    parts: tuple[Remedied, ...]
    margins: tuple[Margin, ...]
    robots: int
    runs: int


def remedies(
    program: Program,
    matrix: PoseMatrix,
    decisive: int,
    parts: Sequence[str],
    robots: int,
    runs: int,
    seed: int,
) -> Remedies:
    """Return what would help a task.

    decisive  number of the tolerance whose use is compared
    parts     names of parts, the largest contributor first
    """
    many, often = min(robots, _ROBOTS), min(runs, _RUNS)

    def left(
        name: str, one: PoseMatrix, factors: Floats | None = None, of: Program = program
    ) -> Remedied:
        scaled = one if factors is None else one.scaled(factors)
        found = judged(of, scaled, many, often, seed)
        return Remedied(
            name, share_of(found.held), float(np.quantile(found.used[decisive], _LEVEL))
        )

    geometry = geometry_of(program.arm)
    sided = np.array([info.of.term.sided for info in matrix.infos])

    def kept(stage: str) -> Floats:
        factors = remaining(matrix.infos, stage, geometry)
        # The side of the path is no draw, and yet no controller knows it that knows the load alone.
        return np.where(sided, 1.0, factors) if stage in _LOAD_ALONE else factors

    stages = [left(name, matrix, kept(stage)) for stage, name in _NAMES.items()]
    from_one = program.matrix(np.ones_like(program.sides))
    stages.append(left(ALL_FROM_ONE_SIDE, from_one))
    if program.growth is not None:
        stages.append(left(WARMED, matrix, of=program.warmed()))
        stages.append(left(TAUGHT_WARM, matrix, of=replace(program, growth=None)))
    without = [
        left(
            part,
            matrix,
            np.array([float(info.owner != part) for info in matrix.infos]),
            _without(program, part),
        )
        for part in parts[:_PARTS]
    ]

    def holds(one: PoseMatrix) -> bool:
        found = judged(program, one, many, often, seed)
        return float(found.held.mean()) >= program.task.required

    def carries(factor: float) -> bool:
        """Return whether the arm meets it with so many times the payload: not where it falls."""
        try:
            matrix = program.with_payload(factor).matrix()
        except InputError:
            return False
        return holds(matrix)

    def of(which: Callable[[Column], bool]) -> float:
        return _largest(lambda factor: holds(matrix.scaled(_factors(matrix, which, factor))))

    margins = [Margin("play and hysteresis", of(_is_play)), Margin("compliance", of(_is_elastic))]
    if program.arm.payload.mass:
        margins.append(Margin("payload", _largest(carries)))
    return Remedies(
        left("as it is", matrix), tuple(stages), tuple(without), tuple(margins), many, often
    )


def _without(program: Program, part: str) -> Program:
    """Return the program without the scatter of its force or the own heat of a joint, where that is
    the contributor.
    """
    if part == PROCESS_FORCE:
        return replace(program, varying=None)
    kept = np.array([name != part for name in own_heats(program)], dtype=float)
    if program.growth is None or kept.all():
        return program
    return replace(program, growth=program.growth * kept[:, None, None])


def _is_play(column: Column) -> bool:
    parameter = column.of.term.parameter
    return parameter is not None and parameter.key in _PLAYS


def _is_elastic(column: Column) -> bool:
    return column.of.term.exponent == -1


def _factors(matrix: PoseMatrix, which: Callable[[Column], bool], factor: float) -> Floats:
    """Return one for each column, `factor` for those of which `which` is true."""
    return np.array([factor if which(column) else 1.0 for column in matrix.infos])


def _largest(holds: Callable[[float], bool]) -> float:
    """Return the largest factor with which the requirement is met, by bisection; NaN where none
    meets it, infinite where all that are tried do.
    """
    if holds(1.0):
        if holds(_MOST):
            return np.inf
        low, high = 1.0, _MOST
    elif holds(1 / _MOST):
        low, high = 1 / _MOST, 1.0
    else:
        return np.nan
    for _ in range(_STEPS):
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low
