"""Colour classes with round limits, and the factor by which errors are enlarged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.reporting.palette import CLASSES, DARK, class_limits, round_number

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.spatial import Floats

# Small to large error, on the dark ground of the view.
COLOURS: Final = tuple(DARK[f"c{k}"] for k in range(len(CLASSES)))
# Share of the errors below the first and above the last limit.
_ENDS: Final = (0.03, 0.97)
# Length of a typical error in the picture, as a share of the picture's size.
_SHOWN: Final = 0.06


@dataclass(frozen=True)
class Classes:
    """Limits (m) between the colour classes, ascending, at multiples of a round step."""

    limits: tuple[float, ...]

    def colours(self, errors: Floats) -> NDArray[np.uint8]:
        """Return the colour (error, 3) of each error (m); one that lies on a limit belongs to the
        class above it.
        """
        table = np.array(
            [[int(colour[k : k + 2], 16) for k in (1, 3, 5)] for colour in COLOURS], dtype=np.uint8
        )
        return np.asarray(table[np.searchsorted(self.limits, errors, side="right")])


def classes_of(errors: Floats) -> Classes:
    """Return the classes that suit these errors (m): round limits, in mm, over the range of most of
    them.
    """
    low, high = (float(each) for each in 1e3 * np.quantile(errors, _ENDS))
    return Classes(tuple(1e-3 * limit for limit in class_limits(low, high)))


def enlargement(errors: Floats, size: float) -> float:
    """Return the round factor at which a typical one of these errors (m) is well visible in a
    picture of this size (m); 1 without errors.
    """
    typical = float(np.median(errors))
    return round_number(_SHOWN * size / typical) if typical > 0 else 1.0
