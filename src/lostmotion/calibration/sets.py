"""Set-ups of the instrument: the errors of the arm are those of all, the frame of the instrument
against the base is that of each.

The base frame of the model is that of the set with the most rows. Every other set has a frame
against it, with the prior deviations of the base frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.calibration.instruments import OnInstrument, Rows, moved_base

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.calibration.instruments import Instrument, MeasuredVisits
    from lostmotion.calibration.terms import Deviations
    from lostmotion.spatial import Floats

# Fewest poses that determine the frame of a set.
FEWEST_IN_SET: Final = 3
_NAMES: Final = (*(f"turn {axis}" for axis in "xyz"), *(f"shift {axis}" for axis in "xyz"))


@dataclass(frozen=True, eq=False)
class InSets(OnInstrument):
    """An instrument that was set up several times.

    names   of the sets; the first is the one whose base frame the model has
    number  (pose,) of the set of each pose, among the names
    sizes   (6,) prior deviations of the frame of a set against the first: turns, rad, shifts, m
    """

    names: tuple[str, ...]
    number: NDArray[np.int64]
    sizes: Floats

    @property
    def unknowns(self) -> tuple[str, ...]:  # type: ignore[override]
        """Return the unknowns of the instrument, then the frames of all sets but the first."""
        frames = (f"{set_in_words(name)} {each}" for name in self.names[1:] for each in _NAMES)
        return (*self.inner.unknowns, *frames)

    def size(self, unknown: int) -> tuple[float, str]:
        """Return the deviation of an unknown with its unit."""
        k = unknown - len(self.inner.unknowns)
        if k < 0:
            return self.inner.size(unknown)
        k %= len(_NAMES)
        return float(self.sizes[k]), "rad" if k < 3 else "m"  # noqa: PLR2004

    def rows(self, frames: Floats, unknowns: Floats) -> Rows:
        """Return the rows of the instrument for the arm on the base of each set."""
        own, others = np.split(unknowns, [len(self.inner.unknowns)])
        twists = np.concatenate([np.zeros((1, 6)), others.reshape(-1, 6) * self.sizes])
        moved = moved_base(twists[self.number], frames)
        found = self.inner.rows(moved.frames, own)
        by_frame = found.by_twist @ (moved.motion * self.sizes)
        of_each = [
            np.where((self.number == k)[:, None, None], by_frame, 0.0)
            for k in range(1, len(self.names))
        ]
        by_unknown = np.concatenate([found.by_unknown, *of_each], axis=2)
        return Rows(found.residual, moved.by_twist(found.by_twist), by_unknown)

    def part(self, rows: NDArray[np.int64]) -> InSets:
        """Return the measurement at the poses in these rows."""
        return InSets(self.inner.part(rows), self.names, self.number[rows], self.sizes)


def in_sets(instrument: Instrument, visits: MeasuredVisits, sizes: Deviations) -> Instrument:
    """Return the instrument with a frame of each set of the visits; itself where there is one."""
    of = visits.by_set
    if len(of) == 1:
        return instrument
    number = np.zeros(len(visits), dtype=np.int64)
    for k, rows in enumerate(of.values()):
        number[rows] = k
    prior = np.repeat([sizes.base_turn, sizes.base_shift], 3)
    return InSets(instrument, tuple(of), number, prior)


def small_sets(visits: MeasuredVisits) -> dict[str, NDArray[np.int64]]:
    """Return the rows of each set whose poses are too few for its frame; none of a single set."""
    of = visits.by_set
    return {
        name: rows
        for name, rows in of.items()
        if len(of) > 1 and len(np.unique(visits.q[rows], axis=0)) < FEWEST_IN_SET
    }


def set_in_words(name: str) -> str:
    """Return a set in words: of rows without a name where it is empty."""
    return f"set {name}" if name else "set without a name"
