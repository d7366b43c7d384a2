"""A run of many poses, or a grid of designs, with its tables, plots and arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from lostmotion.analyses.result import Result
from lostmotion.error_model.provenance import States, states

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    import xarray

    from lostmotion.mechanism.arm import Arm
    from lostmotion.reporting.figure_files import FigureKind
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Sheet
    from lostmotion.reporting.table_files import TableKind
    from lostmotion.runs.store import Store
    from lostmotion.runs.summary import Outcome


@dataclass(frozen=True, repr=False)
class Sweep(Result):
    """A completed run: `outcomes` by design; `store` has every block."""

    arm: Arm
    store: Store
    outcomes: tuple[Outcome, ...]

    @property
    def states(self) -> States:
        """Return what is known of each joint: stated, assumed, or ideal, and the assumed values of
        the first design.
        """
        return states(self.arm)

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        from lostmotion.analyses.sweep.tables.sweep import sweep_sheet

        return sweep_sheet(self.arm, self.store.order, self.outcomes)

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.sweep.plots import sweep_plots

        return sweep_plots(self.store.order, self.outcomes)

    def report(
        self,
        out: str | Path | None = None,
        *,
        force: bool = False,
        figures: FigureKind | None = None,
        tables: TableKind | None = None,
    ) -> Path:
        """Write report.html and result.json beside the blocks, or into the folder `out`, and return
        the folder. Errors as `Result.report`.
        """
        from lostmotion.reporting.page.document import contents

        if out is not None:
            return super().report(out, force=force, figures=figures, tables=tables)
        plots = self.plots
        for name, content in {
            **contents(self.sheet, plots),
            **self.copies(plots, figures, tables),
        }.items():
            self.store.keep(name, content)
        return self.store.folder

    def arrays(self) -> xarray.Dataset:
        """Return the figures of every design over the keys swept."""
        from lostmotion.runs.arrays import dataset

        return dataset(self.store.order, self.outcomes)

    def __repr__(self) -> str:
        """Return what was run, in a line."""
        order = self.store.order
        return (
            f"<Sweep of '{self.arm.name}': {order.designs} designs x {order.poses} poses x "
            f"{order.robots} robots x {order.visits} visits>"
        )
