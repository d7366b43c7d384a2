"""A plot of a report: the figure, the section whose figures it shows, and what it shows in
words.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from lostmotion.reporting.arm_scene import ArmScene

# Section of a plot that the first screen of the page shows.
FIRST_SCREEN: Final = ""


@dataclass(frozen=True)
class Plot:
    """A drawn plot: the section whose figures it shows, a key for file names, and what it shows in
    words for those who cannot see it.

    A plot of the first screen may have a scene: on a screen the viewer then replaces all pictures
    there.
    """

    key: str
    section: str
    figure: Figure
    words: str
    scene: ArmScene | None = None
