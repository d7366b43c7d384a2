"""Whether a task succeeds, with its tables and plots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from lostmotion.analyses.result import Result
from lostmotion.analyses.task.outcome import TaskOutcome
from lostmotion.reporting.sheet import Cell

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Sheet


@dataclass(frozen=True, repr=False)
class TaskResult(TaskOutcome, Result):
    """Whether a task succeeds: every attribute of `TaskOutcome`."""

    @property
    def failure(self) -> str:
        """Return why the task fails: fewer robots and runs succeed than it requires."""
        if self.success.value >= self.task.required:
            return ""
        return (
            f"All tolerances hold in {Cell(self.success.value, '%')} of robots and runs; "
            f"{Cell(self.task.required, '%', stated=True)} are required."
        )

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        from lostmotion.analyses.task.page import task_sheet

        return task_sheet(self)

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.task.page.plots import task_plots

        return task_plots(self)
