"""What was asked for, to be looked at: on the screen, as a report, as plain data, in a notebook."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lostmotion.reporting.sheet import Sheet


class Shown(ABC):
    """Whatever has a sheet of figures can be printed, given as plain data, and shown in a notebook."""

    @property
    @abstractmethod
    def sheet(self) -> Sheet:
        """Give every figure, as printed, reported and written."""

    def summary(self) -> None:
        """Print every figure."""
        from lostmotion.reporting.screen import print_sheet

        print_sheet(self.sheet)

    def result(self) -> dict[str, Any]:
        """Give every printed figure as plain data, as in result.json."""
        from lostmotion.reporting.sheet import plain
        from lostmotion.version import __version__

        return plain(self.sheet, __version__)

    def _repr_html_(self) -> str:
        """Show the figures as tables in a notebook."""
        from lostmotion.reporting.page import tables

        return tables(self.sheet)
