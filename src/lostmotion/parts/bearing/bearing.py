"""What all bearings and guides share."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lostmotion.parts.error_source import ErrorSource
from lostmotion.parts.provenance import Sourced

if TYPE_CHECKING:
    from lostmotion.parts.error_source import PartFigure


class BearingFigures(Sourced, ErrorSource):
    """Base class of bearings and guides."""

    @property
    def stated_figures(self) -> list[PartFigure]:
        """Return the figures that are stated, and what follows from them, for the sheet of the
        bearing.
        """
        return []
