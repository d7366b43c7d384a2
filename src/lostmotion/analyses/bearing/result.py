"""One bearing under a load, with its tables and plots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from lostmotion.analyses.result import Result

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.analyses.bearing.bearing import BearingLoad, Examined
    from lostmotion.parts.moving_joint import Bearing
    from lostmotion.reporting.plot import Plot
    from lostmotion.reporting.sheet import Sheet


@dataclass(frozen=True, repr=False)
class BearingStudy(Result):
    """One bearing under a load: `examined` has every number where it is described by its drawing,
    and is None where by stated values.
    """

    name: str
    part: Bearing
    load: BearingLoad
    examined: Examined | None = None
    notes: tuple[str, ...] = ()

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed, reported and written."""
        from lostmotion.analyses.bearing.tables import bearing_sheet

        return bearing_sheet(self.name, self.part, self.load, self.examined, self.notes)

    @property
    def plots(self) -> Sequence[Plot]:
        """Return the plots of the report."""
        from lostmotion.analyses.bearing.plots import bearing_plots

        return () if self.examined is None else bearing_plots(self.examined)
