"""An ISO 9283 sheet, with its tables and plots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from lostmotion.analyses.result import Result
from lostmotion.error_model.provenance import States, states

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.analyses.iso9283.commanded_poses import CommandedPoses
    from lostmotion.analyses.iso9283.comparison import ComparedFigure
    from lostmotion.analyses.iso9283.measured import MeasuredRobot
    from lostmotion.analyses.iso9283.predicted import PredictedRobots
    from lostmotion.analyses.iso9283.warm_up import Drift
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Sheet


@dataclass(frozen=True, repr=False)
class Iso9283(Result):
    """An ISO 9283 sheet: `predicted`, `drift`, `measured` and `compared`; None, or empty, where
    there is none.

    commanded  the poses of the measured file at which robots were predicted for the comparison;
               None where they are those of the cube
    """

    predicted: PredictedRobots | None
    drift: Drift | None
    measured: MeasuredRobot | None
    compared: tuple[ComparedFigure, ...]
    commanded: CommandedPoses | None = None

    @property
    def states(self) -> States | None:
        """Return what is known of each joint: stated, assumed, or ideal, and the assumed values;
        None without a prediction.
        """
        return None if self.predicted is None else states(self.predicted.arm)

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        from lostmotion.analyses.iso9283.tables.sheet import iso_sheet

        notes: tuple[str, ...] = ()
        if self.predicted is not None and self.measured is not None and not self.compared:
            notes = (
                (
                    "not compared: no pose of the measured file has a commanded position under a "
                    "load that was predicted"
                ),
            )
        return iso_sheet(
            self.predicted, self.drift, self.measured, list(self.compared), notes, self.commanded
        )

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.iso9283.plots.sheet import iso_plots

        return iso_plots(self.predicted, self.drift, self.measured, list(self.compared))
