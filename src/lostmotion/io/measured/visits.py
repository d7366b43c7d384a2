"""Measured visits to poses and readings along paths, row by row, in metres and radians."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.spatial import Floats

# Fields with one entry per row: arrays and tuples.
ARRAYS: Final = ("cycle", "load", "attained", "command", "orientation", "rotation")
TUPLES: Final = ("pose", "path", "side", "where")


@dataclass(frozen=True)
class Visits:
    """Measured rows; m and rad, base frame. NaN where a value was not measured, not commanded, or
    is unknown.

    pose (row,)            label of the pose; empty for a reading along a path
    path (row,)            label of the path, its two ends ("P2-P4"); empty for a visit to a pose
    cycle (row,)           number of the cycle; counted within a pose where the file states none
    side (row,)            side from which a pose was approached; empty for the standard's cycle
    load (row,)            share of the payload
    attained (row, 3)      attained positions
    command (row, 3)       commanded positions
    orientation, rotation (row, 3, 3)  attained and commanded orientation of the tool
    where (row,)           file and line of each row
    duplicates             number of dropped rows that repeat another one in every column that was
                           read
    unread                 columns that were not read and differ between a dropped row and its
                           duplicate
    instrument             standard deviation of one reading of a coordinate, m; 0 where not stated
    source                 names of the files
    known                  commanded poses (4, 4) by name, m: of the rows, and of others that paths
                           may join; rotation NaN where unknown
    load_stated            False: no load was stated, and the full payload is assumed
    unused                 columns of the files that no role is mapped to
    lost                   file and line of each row without a reading, which is excluded
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
    unused: tuple[str, ...] = ()
    lost: tuple[tuple[str, int], ...] = ()

    @property
    def turn(self) -> Floats:
        """Return the rotation vector (row, 3) from commanded to attained orientation, base axes;
        NaN where one of them is unknown.
        """
        from scipy.spatial.transform import Rotation

        out = np.full((len(self.pose), 3), np.nan)
        if (
            known := np.isfinite(self.orientation).all(axis=(1, 2))
            & np.isfinite(self.rotation).all(axis=(1, 2))
        ).any():
            between = self.orientation[known] @ np.swapaxes(self.rotation[known], 1, 2)
            out[known] = Rotation.from_matrix(between).as_rotvec()
        return out

    def picked(self, rows: np.ndarray) -> Visits:
        """Return some of the rows, by number or by mask, in their order."""
        at = np.flatnonzero(rows) if rows.dtype == bool else rows
        picked: dict[str, Any] = {name: getattr(self, name)[at] for name in ARRAYS}
        picked |= {name: tuple(getattr(self, name)[k] for k in at) for name in TUPLES}
        return replace(self, **picked)

    def commanded_pose(self, k: int) -> Floats:
        """Return the commanded pose (4, 4) of a row; NaN where unknown."""
        out = np.eye(4)
        out[:3, :3], out[:3, 3] = self.rotation[k], self.command[k]
        return out

    def commanded(self, known: Mapping[str, Floats]) -> Visits:
        """Return the rows with commanded poses (4, 4) by name, m, where neither they nor the file
        state a commanded position.
        """
        known = {**known, **self.known}
        command, rotation = self.command.copy(), self.rotation.copy()
        for k, name in enumerate(self.pose):
            if name in known and not np.isfinite(command[k]).all():
                command[k], rotation[k] = known[name][:3, 3], known[name][:3, :3]
        return replace(self, command=command, rotation=rotation, known=known)
