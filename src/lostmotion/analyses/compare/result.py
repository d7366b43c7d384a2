"""Comparison of arms with its tables and plots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from lostmotion.analyses.result import Result
from lostmotion.comparison.comparison import Comparison

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Sheet


@dataclass(frozen=True, repr=False)
class Compare(Comparison, Result):
    """What differs between arms and what it does: every attribute of `Comparison`."""

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        from lostmotion.analyses.compare.page import compare_sheet

        return compare_sheet(self)

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.compare.page.plots import compare_plots

        return compare_plots(self)
