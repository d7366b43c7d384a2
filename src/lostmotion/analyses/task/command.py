"""Ask whether an arm will succeed at a task."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

from lostmotion.analyses.arguments import (
    DEFAULT_ROBOTS,
    ArmArgument,
    CalibrationArgument,
    ProgressArgument,
    ReadyArgument,
    RobotsArgument,
    SeedArgument,
    SidecarArgument,
    path_of,
)
from lostmotion.analyses.signature import Argument, question, read_arguments

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.analyses.task.outcome import TaskResult


def _stated(name: str, value: object, _given: object) -> Path | Mapping[str, Any]:
    """Return the path of a task, or the keys of such a file."""
    return value if isinstance(value, Mapping) else path_of(name, value, example="task.toml")


@question(folder="task")
def task(
    arm: ArmArgument,
    by: Annotated[
        "str | Path | Mapping[str, Any]",
        Argument(
            "TOML of the task: poses or features, and their tolerances; in Python also its keys.",
            _stated,
            metavar="TASK",
        ),
    ],
    *,
    robots: RobotsArgument = DEFAULT_ROBOTS,
    runs: Annotated[int, Argument("How often each robot carries out the task.", least=1)] = 10,
    seed: SeedArgument = 1,
    sidecar: SidecarArgument = None,
    calibration: CalibrationArgument = None,
    progress: ProgressArgument = None,
    ready: ReadyArgument = None,
) -> TaskResult:
    """Predict whether a task succeeds: the probability that every tolerance holds, the worst place,
    the largest contributor, and what would help.

    The side on which each joint rests follows from the path. On the command line the exit code is
    1 where the task succeeds in fewer robots and runs than it requires.

    Raises
    ------
    InputError
        With every mistake in the arguments and the files; for a place out of reach, and a
        tolerance that the places of the task cannot have.

    """
    asked = read_arguments(task, locals())
    from lostmotion.analyses.task.outcome import TaskResult
    from lostmotion.error_model.provenance import refuse_undescribed
    from lostmotion.io.task_file import read_task
    from lostmotion.io.toml_lines import names_lines

    refuse_undescribed(asked.arm)
    stated = read_task(asked.by, asked.arm)
    asked.ready()
    # Places out of reach and tolerances without a reference are mistakes in the task's file too.
    return names_lines(TaskResult.of)(
        asked.arm, stated, asked.robots, asked.runs, asked.seed, progress
    )
