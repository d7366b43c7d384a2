"""Entries of the catalogue that were found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from lostmotion.analyses.result import Result

if TYPE_CHECKING:
    from lostmotion.reporting.sheet import Sheet


@dataclass(frozen=True, repr=False)
class Catalog(Result):
    """Entries of the catalogue: `sheet.facts` has every row."""

    figures: Sheet

    @property
    def sheet(self) -> Sheet:
        """Return every figure, as printed and written."""
        return self.figures
