"""Best placement of a task: where the same robots use its tolerances least."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.draws import sobol
from lostmotion.error_model.joint_path import starts_of
from lostmotion.error_model.task import program_of
from lostmotion.errors import InputError
from lostmotion.propagation.task_success import judged
from lostmotion.spatial import pose_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.error_model.joint_path import Starts
    from lostmotion.error_model.task import Program, Task
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

# Placements that are tried, as powers of two: over the whole range, then about the best of them
# within this share of the range.
_WIDE: Final = 5
_NEAR: Final = 4
_NARROW: Final = 0.25
_ROBOTS: Final = 64
_RUNS: Final = 2
_LEVEL: Final = 0.95


@dataclass(frozen=True)
class FoundPlacement:
    """The best of the placements that were tried.

    moved    shift along x, y, z (m) and yaw (rad) in the frame of the task, from the stated one
    before   share of the most used tolerance that 95 % of robots and runs stay within at the
             stated placement; NaN where it is out of reach
    after    the same at the best one
    tried    number of placements
    reached  of which all places are within reach
    """

    moved: Floats
    before: float
    after: float
    tried: int
    reached: int


def best_placement(
    arm: Arm,
    task: Task,
    seed: int,
    report: Callable[[str, int, int], None] | None = None,
) -> tuple[Program, FoundPlacement]:
    """Return the program at the placement with the smallest use of tolerances, and the search.

    The stated placement is tried as well. Raises ValueError for a task whose placement is fixed,
    InputError where no placement that was tried is within reach.
    """
    if task.search is None:
        raise ValueError("the placement of this task is fixed")
    low, high = task.search.T
    wide = sobol(seed, "task.placement", len(low)).points(_WIDE)
    near = sobol(seed, "task.placement.near", len(low)).points(_NEAR) - 0.5
    count, found = 1 + len(wide) + len(near), list[_Tried]()
    starts = starts_of(arm)

    def tries(moved: Floats) -> None:
        if report is not None:
            report("searching the placement", len(found), count)
        found.append(_tried(arm, task, moved, seed, starts))

    for moved in ((low + high) / 2, *(low + wide * (high - low))):
        tries(moved)
    best = min(found, key=lambda each: each.used)
    if best.program is None:
        raise InputError([] if best.refusal is None else best.refusal.problems)
    for step in _NARROW * near * (high - low):
        tries(np.clip(best.moved + step, low, high))
    best = min(found, key=lambda each: each.used)
    if best.program is None:
        raise ValueError("no program at the best placement")
    reached = sum(each.program is not None for each in found)
    before = found[0].used if found[0].program is not None else np.nan
    return best.program, FoundPlacement(best.moved, before, best.used, len(found), reached)


@dataclass(frozen=True)
class _Tried:
    """A placement that was tried; infinite use where it is out of reach."""

    moved: Floats
    program: Program | None
    used: float
    refusal: InputError | None = None


def _tried(arm: Arm, task: Task, moved: Floats, seed: int, starts: Starts) -> _Tried:
    try:
        program = program_of(arm, task, pose_of(moved[:3], (0, 0, moved[3])), starts)
    except InputError as error:
        return _Tried(moved, None, np.inf, error)
    used = judged(program, program.matrix(), _ROBOTS, _RUNS, seed).used
    return _Tried(moved, program, float(np.quantile(used.max(axis=0), _LEVEL)))
