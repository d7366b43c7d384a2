"""What every joint of an arm carries, and how compliant the arm is, with its tables and plots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from lostmotion.analyses.result import Result
from lostmotion.analyses.statics.survey import Survey

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.analyses.statics.payload import MaxPayload
    from lostmotion.catalogue.gearbox_row import GearboxRow
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Sheet


@dataclass(frozen=True, repr=False)
class Statics(Survey, Result):
    """Loads and compliance of an arm: every attribute of `Survey`.

    `reducers` are the user's rows that are searched besides the catalogue, `payload` is the largest
    payload where it was asked for.
    """

    reducers: Sequence[GearboxRow] = ()
    payload: MaxPayload | None = None

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        from lostmotion.analyses.statics.tables import statics_sheet

        return statics_sheet(self, self.reducers, self.payload)

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.statics.plots import statics_plots

        return statics_plots(self, self.payload)
