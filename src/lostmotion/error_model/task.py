"""A task of an arm as stated: the places that the tool visits in their order, and the tolerances
that hold there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.error_model.drawing_tolerances import DrawingTolerance, Feature
    from lostmotion.spatial import Floats


@dataclass(frozen=True)
class ForceAlong:
    """Force on the tool at the places of a task.

    vector   (place, 3) N, along the axes of the task
    along    (place,) N, along the direction of travel
    scatter  standard deviation from run to run, as a share of the force
    """

    vector: Floats
    along: Floats
    scatter: float


@dataclass(frozen=True)
class Task:
    """A task; its rows are the poses that the arm visits, some of which are places with tolerances.

    poses      (row, 4, 4) of the tool in the frame of the task, m; None where joint values are
               stated
    q          (row, joint) joint values, rad or m; None where poses are stated
    turned     whether the poses state the orientation of the tool
    visited    (row,) whether it is a place; the arm only passes through other rows
    where      file and row of each row
    approach   (row, joint) stated sign of the last motion, NaN where the path decides
    features   in the order in which they are visited; axes in the frame of the task
    placement  (4, 4) frame of the task in the base's frame, m
    search     (4, 2) limits of a shift of the placement along x, y, z (m) and of its yaw (rad),
               within which the best one is to be found; None: it is fixed
    repeated   whether the task runs over and over: the last row comes before the first
    required   share of robots and runs in which all tolerances must hold
    """

    name: str
    poses: Floats | None
    q: Floats | None
    turned: bool
    visited: NDArray[np.bool_]
    where: tuple[tuple[str, str], ...]
    approach: Floats
    features: tuple[Feature, ...]
    tolerances: tuple[DrawingTolerance, ...]
    placement: Floats
    search: Floats | None
    force: ForceAlong | None
    repeated: bool
    required: float

    @property
    def places(self) -> NDArray[np.int64]:
        """Return the rows that are places (place,)."""
        return np.flatnonzero(self.visited)
