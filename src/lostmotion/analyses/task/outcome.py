"""Probability that simulated robots of a design meet all tolerances of a task, and what decides it.

Each robot is drawn once and carries out the task in every run. The side on which each joint rests
follows from the path: its last motion, at random until it first moves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.analyses.result import Result
from lostmotion.error_model.intervals import Estimate
from lostmotion.error_model.small_counts import clustered_share
from lostmotion.error_model.task import Program, program_of
from lostmotion.propagation import exact
from lostmotion.propagation.task_drift import ToolDrift
from lostmotion.propagation.task_placement import best_placement
from lostmotion.propagation.task_remedies import remedies
from lostmotion.propagation.task_success import (
    Judged,
    judged,
    reversal,
    share_of,
    shares,
    worst_output,
)
from lostmotion.reporting.sheet import Cell

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Self

    from lostmotion.error_model.drawing_tolerances import DrawingTolerance
    from lostmotion.error_model.task import Task
    from lostmotion.mechanism.arm import Arm
    from lostmotion.propagation.exact import ExactCheck
    from lostmotion.propagation.task_placement import FoundPlacement
    from lostmotion.propagation.task_remedies import Remedies
    from lostmotion.spatial import Floats

_CHECKED: Final = (8, 8, 4)  # places, robots and runs
LEVEL: Final = 0.95


@dataclass(frozen=True)
class ToleranceOutcome:
    """How one tolerance fares.

    held   probability that it holds
    used   share of it that 95 % of robots and runs stay within
    worst  number of the place where it is missed most often, and its mean square is largest
    """

    tolerance: DrawingTolerance
    held: Estimate
    used: Estimate
    worst: int


@dataclass(frozen=True, repr=False)
class TaskResult(Result):
    """Whether a task succeeds.

    success     probability that all tolerances hold
    outcomes    of each tolerance, as stated
    features    probability that all tolerances of a feature hold, by its name
    place_held  (place,) probability that all tolerances hold at the place; NaN without any
    place_used  (place,) share of the tolerance used there by 95 % of robots and runs
    decisive    number of the tolerance that is missed most often
    parts       share of each part in the mean square of that tolerance at its worst place
    causes      the same by kind of error
    reversal    (place,) displacement of the tool when the path is followed backwards, m
    check       comparison with exact composition
    helps       what would help, and how much more the task would bear
    placed      how the placement was found; None where it is fixed
    drift       of the tool by the own heat of joints; None where none is stated
    """

    program: Program
    robots: int
    runs: int
    seed: int
    success: Estimate
    outcomes: tuple[ToleranceOutcome, ...]
    features: dict[str, Estimate]
    place_held: Floats
    place_used: Floats
    decisive: int
    parts: dict[str, float]
    causes: dict[str, float]
    reversal: Floats
    check: ExactCheck
    helps: Remedies
    placed: FoundPlacement | None
    drift: ToolDrift | None

    @property
    def arm(self) -> Arm:
        """Return the arm."""
        return self.program.arm

    @property
    def task(self) -> Task:
        """Return the task as stated."""
        return self.program.task

    @property
    def figures(self) -> dict[str, Estimate]:
        """Return the probabilities: "success", and of every tolerance and feature by name."""
        return {
            "success": self.success,
            **{each.tolerance.name: each.held for each in self.outcomes},
            **self.features,
        }

    @property
    def failure(self) -> str:
        """Return why the task fails: fewer robots and runs succeed than it requires."""
        if self.success.value >= self.task.required:
            return ""
        return (
            f"All tolerances hold in {Cell(self.success.value, '%')} of robots and runs; "
            f"{Cell(self.task.required, '%', stated=True)} are required."
        )

    def where(self, place: int) -> str:
        """Return the place by its feature and its number there."""
        for each in self.program.features:
            if place in each.places:
                number = int(np.flatnonzero(each.places == place)[0]) + 1
                return f"'{each.name}'" + (f", place {number}" if len(each.places) > 1 else "")
        return f"place {place + 1}"

    @property
    def facts(self) -> dict[str, Any]:
        """Return what result.json holds besides the tables: the task and every place."""
        task, program = self.task, self.program
        return {
            "task": {
                "name": task.name,
                "robots": self.robots,
                "runs": self.runs,
                "seed": self.seed,
                "required": task.required,
                "succeeds": bool(self.success.value >= task.required),
                "placement": program.placement.tolist(),
                "decisive": self.outcomes[self.decisive].tolerance.name,
                "worst_place": self.outcomes[self.decisive].worst + 1,
            },
            "places": [
                {
                    "feature": self.where(k),
                    "row": " ".join(task.where[row]),
                    "point_m": point.tolist(),
                    "q": q.tolist(),
                    "sides": side.tolist(),
                    "probability": None if math.isnan(held) else float(held),
                    "used_p95": None if math.isnan(used) else float(used),
                    "reversal_m": float(back),
                }
                for k, (row, point, q, side, held, used, back) in enumerate(
                    zip(
                        task.places,
                        program.places.points,
                        program.visited,
                        program.sides,
                        self.place_held,
                        self.place_used,
                        self.reversal,
                        strict=True,
                    )
                )
            ],
        }

    @classmethod
    def of(
        cls,
        arm: Arm,
        task: Task,
        robots: int,
        runs: int,
        seed: int,
        progress: Callable[[str, int, int], None] | None = None,
    ) -> Self:
        """Return whether a task succeeds, over these robots and runs. Errors as `program_of`."""
        report = progress or (lambda _stage, _done, _total: None)
        report("finding the joint values", 0, 3)
        placed = None
        if task.search is None:
            program = program_of(arm, task)
        else:
            program, placed = best_placement(arm, task, seed, progress)
        matrix = program.matrix()
        report("running the task", 1, 3)
        found = judged(program, matrix, robots, runs, seed)
        report("finding what decides it", 2, 3)
        outcomes = tuple(_outcome(program, found, k) for k in range(len(program.measures)))
        decisive = min(
            range(len(outcomes)), key=lambda k: (outcomes[k].held.value, -outcomes[k].used.value)
        )
        output = worst_output(found, decisive)
        operator = program.measures[decisive].operator(output, len(matrix.tool))
        many, often = min(robots, _CHECKED[1]), min(runs, _CHECKED[2])
        with np.errstate(invalid="ignore"):
            within = np.where(np.isnan(found.at), np.nan, found.at <= 1).mean(axis=(1, 2))
            quantiles = np.quantile(found.at.reshape(len(found.at), -1), LEVEL, axis=1)
        parts = shares(program, matrix, operator, "part", runs)
        helps = remedies(program, matrix, decisive, list(parts), robots, runs, seed)
        return cls(
            program,
            robots,
            runs,
            seed,
            share_of(found.held),
            outcomes,
            _by_feature(program, found),
            np.asarray(within, dtype=float),
            np.asarray(quantiles, dtype=float),
            decisive,
            parts,
            shares(program, matrix, operator, "cause", runs),
            reversal(program, matrix),
            _check(program, seed, many, often),
            helps,
            placed,
            ToolDrift.of(program, found),
        )


def _check(program: Program, seed: int, robots: int, runs: int) -> ExactCheck:
    """Return the comparison with exact composition at some places under one process force."""
    places, matrix = program.parts()[0]
    rows = np.unique(np.linspace(0, len(places) - 1, _CHECKED[0]).astype(int))
    return exact.check(matrix, 0, rows, seed, robots, runs)


def _outcome(program: Program, tolerances: Judged, k: int) -> ToleranceOutcome:
    used = tolerances.used[k]
    value = float(np.quantile(used, LEVEL))
    # Woodruff's interval: the quantiles at the ends of that of the share below.
    ends = clustered_share((used <= value).mean(axis=1), used.shape[1])
    low, high = (math.nan if math.isnan(end) else float(np.quantile(used, end)) for end in ends)
    spread = Estimate(value, min(low, value), max(high, value), unit="1")
    place = int(program.measures[k].outputs[worst_output(tolerances, k)])
    return ToleranceOutcome(program.task.tolerances[k], share_of(used <= 1), spread, place)


def _by_feature(program: Program, tolerances: Judged) -> dict[str, Estimate]:
    """Return the probability that all tolerances of a feature hold, by its name."""
    out = {}
    for number, each in enumerate(program.features):
        own = [k for k, t in enumerate(program.task.tolerances) if number in t.features]
        if own:
            out[each.name] = share_of(np.asarray((tolerances.used[own] <= 1).all(axis=0)))
    return out
