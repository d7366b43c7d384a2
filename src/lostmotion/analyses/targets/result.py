"""What a target requires of an arm's parts, with its tables and plots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from lostmotion.analyses.result import Result
from lostmotion.analyses.targets.targets import Targets
from lostmotion.error_model.provenance import States, states

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Sheet


@dataclass(frozen=True, repr=False)
class Target(Targets, Result):
    """What a target requires of an arm's parts: every attribute of `Targets`, among them
    `allowances` and `yields`.
    """

    @property
    def states(self) -> States:
        """Return what is known of each joint: stated, assumed, or ideal, and the assumed values."""
        return states(self.arm)

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        from lostmotion.analyses.targets.tables.targets import targets_sheet

        return targets_sheet(self)

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.targets.plots import targets_plots

        return targets_plots(self)
