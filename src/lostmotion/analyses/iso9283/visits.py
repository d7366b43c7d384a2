"""What was measured, row by row: visits to poses, and readings along paths, in metres and radians."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.spatial import Floats

# What each row has, and in which kind of list it stands.
ARRAYS: Final = ("cycle", "load", "attained", "command", "orientation", "rotation")
TUPLES: Final = ("pose", "path", "side", "where")


@dataclass(frozen=True)
class Visits:
    """Measured rows; m and rad, base frame. NaN stands for what was not measured, not commanded, or is not known.

    pose (row,)            label of the pose; empty for a reading along a path
    path (row,)            label of the path, its two ends ("P2-P4"); empty for a visit to a pose
    cycle (row,)           number of the cycle, counted up within a pose where the file names none
    side (row,)            from which side a pose was approached; empty for the standard's cycle
    load (row,)            share of the payload
    attained (row, 3)      positions
    command (row, 3)       commanded positions
    orientation, rotation (row, 3, 3)  the tool's, attained and commanded
    where (row,)           file and line of each
    duplicates             rows dropped because they repeat another one in every column that was read
    unread                 names of columns that were not read and differ between a dropped row and the one kept
    instrument             standard deviation of one reading of a coordinate, m; 0 where not stated
    source                 where they come from
    known                  commanded poses (4, 4) by name, m: of the rows, and of others that paths may join; rotation NaN where not known
    load_stated            False: nobody said which load, and the full one was taken
    """

    pose: tuple[str, ...]
    path: tuple[str, ...]
    cycle: np.ndarray
    side: tuple[str, ...]
    load: Floats
    attained: Floats
    command: Floats
    orientation: Floats
    rotation: Floats
    where: tuple[tuple[str, int], ...]
    duplicates: int
    instrument: float
    source: str
    known: Mapping[str, Floats]
    load_stated: bool
    unread: tuple[str, ...] = ()

    @property
    def turn(self) -> Floats:
        """Give the rotation vector (row, 3) from the commanded orientation to the attained one, base axes; NaN where one of them is not known."""
        from scipy.spatial.transform import Rotation

        out = np.full((len(self.pose), 3), np.nan)
        if (known := np.isfinite(self.orientation).all(axis=(1, 2)) & np.isfinite(self.rotation).all(axis=(1, 2))).any():
            between = self.orientation[known] @ np.swapaxes(self.rotation[known], 1, 2)
            out[known] = Rotation.from_matrix(between).as_rotvec()
        return out

    def picked(self, rows: np.ndarray) -> Visits:
        """Give some of the rows, by number or by True and False, in their order."""
        at = np.flatnonzero(rows) if rows.dtype == bool else rows
        picked: dict[str, Any] = {name: getattr(self, name)[at] for name in ARRAYS}
        picked |= {name: tuple(getattr(self, name)[k] for k in at) for name in TUPLES}
        return replace(self, **picked)

    def commanded_pose(self, k: int) -> Floats:
        """Give the commanded pose (4, 4) of a row; NaN where it is not known."""
        out = np.eye(4)
        out[:3, :3], out[:3, 3] = self.rotation[k], self.command[k]
        return out

    def commanded(self, known: Mapping[str, Floats]) -> Visits:
        """Give the rows with commanded poses (4, 4) by name, m, where neither they nor the file state a commanded position."""
        known = {**known, **self.known}
        command, rotation = self.command.copy(), self.rotation.copy()
        for k, name in enumerate(self.pose):
            if name in known and not np.isfinite(command[k]).all():
                command[k], rotation[k] = known[name][:3, 3], known[name][:3, :3]
        return replace(self, command=command, rotation=rotation, known=known)
