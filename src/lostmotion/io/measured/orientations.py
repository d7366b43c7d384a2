"""Orientations in files of measurements: quaternions, or turns about fixed axes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.spatial import Floats

TURNS: Final = ("rx", "ry", "rz")
QUATERNION: Final = ("qw", "qx", "qy", "qz")


def rotations(groups: Mapping[tuple[str, ...], Floats]) -> Floats | None:
    """Return the rotations (visit, 3, 3) of a file with columns of either kind; None without."""
    if QUATERNION in groups:
        return _of_quaternions(groups[QUATERNION])
    return _of_turns(groups[TURNS]) if TURNS in groups else None


def _of_quaternions(quaternions: Floats) -> Floats:
    """Return rotations (visit, 3, 3) of unit quaternions (visit, 4), real part first."""
    w, v = quaternions[:, :1], quaternions[:, 1:]
    length = np.linalg.norm(quaternions, axis=1)[:, None]
    w, v = w / length, v / length
    x, y, z = v.T
    none = np.zeros(len(w))
    skew = np.array([[none, -z, y], [z, none, -x], [-y, x, none]]).transpose(2, 0, 1)
    return np.asarray(np.eye(3) + 2 * w[:, :, None] * skew + 2 * skew @ skew)


def _of_turns(turns: Floats) -> Floats:
    """Return rotations (visit, 3, 3) about the fixed x, then y, then z by these angles (visit, 3),
    rad.
    """
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_euler("xyz", turns).as_matrix())
