"""A plot of a report: the figure, the section whose figures it shows, and what it shows in words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Section of a plot that the first screen of the page shows.
FIRST_SCREEN: Final = ""


@dataclass(frozen=True)
class Plot:
    """A drawn plot: the section whose figures it shows, a key for file names, and what it shows in words for those who cannot see it."""

    key: str
    section: str
    figure: Figure
    words: str
