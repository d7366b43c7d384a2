"""Drift over the time of a measurement: of the base or the instrument, and by uniform expansion of
the arm. It is linear in time, and zero in the middle of the measurement.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.calibration.instruments import OnInstrument, Rows, moved_base

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.calibration.instruments import Instrument
    from lostmotion.spatial import Floats

# Prior deviations of the drift from the first row to the last: turn, rad, and shift, m, of the
# base, and expansion, that of aluminium by 4 K.
_TURN: Final = 0.1e-3
_SHIFT: Final = 0.1e-3
_GROWTH: Final = 1e-4
_SIZES: Final = np.array([_TURN] * 3 + [_SHIFT] * 3 + [_GROWTH])
_NAMES: Final = (
    *(f"drift turn {axis}" for axis in "xyz"),
    *(f"drift shift {axis}" for axis in "xyz"),
    "drift expansion",
)


@dataclass(frozen=True, eq=False)
class Drifting(OnInstrument):
    """An instrument that measures an arm which drifts.

    time  (pose,) of each visit, -1/2 at the first and 1/2 at the last one
    """

    time: Floats

    @property
    def unknowns(self) -> tuple[str, ...]:  # type: ignore[override]
        """Return the unknowns of the instrument, then those of the drift."""
        return (*self.inner.unknowns, *_NAMES)

    def size(self, unknown: int) -> tuple[float, str]:
        """Return the deviation of an unknown with its unit."""
        k = unknown - len(self.inner.unknowns)
        if k < 0:
            return self.inner.size(unknown)
        return float(_SIZES[k]), "rad" if k < 3 else "m" if k < 6 else "m/m"  # noqa: PLR2004

    def rows(self, frames: Floats, unknowns: Floats) -> Rows:
        """Return the rows of the instrument for the drifted arm."""
        own, drift = np.split(unknowns, [len(self.inner.unknowns)])
        twist = self.time[:, None] * (drift * _SIZES)[:6]
        growth = 1 + self.time * (drift * _SIZES)[6]
        grown = frames.copy()
        grown[:, :3, 3] *= growth[:, None]
        moved = moved_base(twist, grown)
        found = self.inner.rows(moved.frames, own)
        # Motion of the tool about its point by a unit of each.
        motion = np.zeros((len(frames), 6, len(_SIZES)))
        motion[:, :, :6] = moved.motion
        motion[:, 3:, 6] = (moved.turn @ frames[:, :3, 3:])[:, :, 0]
        motion *= self.time[:, None, None] * _SIZES
        by_unknown = np.concatenate([found.by_unknown, found.by_twist @ motion], axis=2)
        # The drift moves a twist of the arm along.
        by_twist = moved.by_twist(found.by_twist)
        by_twist[:, :, 3:] *= growth[:, None, None]
        return Rows(found.residual, by_twist, by_unknown)

    def part(self, rows: NDArray[np.int64]) -> Drifting:
        """Return the measurement at the poses in these rows."""
        return Drifting(self.inner.part(rows), self.time[rows])


def drifting(instrument: Instrument, time: Floats | None) -> Drifting | None:
    """Return the instrument with a drift by these times (pose,), s; None without two times."""
    if time is None or not np.ptp(time):
        return None
    return Drifting(instrument, (time - time.min()) / np.ptp(time) - 0.5)
