"""The arm in its coloured workspace, in three dimensions: what the viewer of a page draws."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np

    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats


@dataclass(frozen=True)
class Cells:
    """Cubic cells of a workspace along the axes of the base.

    edge     of a cell, m
    low      (3,) corner of the first cell, m
    classes  (x, y, z) class of each cell from 0, by its error; -1 where the tool never is
    limits   the six limits between the classes, in `unit`
    what     what the classes show, without its unit
    """

    edge: float
    low: Floats
    classes: np.ndarray
    limits: Sequence[float]
    what: str
    unit: str


@dataclass(frozen=True)
class ShownPose:
    """A pose of the arm with its error.

    name   "worst pose"
    q      (joint,) rad or m
    error  (3,) mean error vector, m
    axes   (3, 3) semi-axes of the error's ellipsoid, one in each row, m
    words  what is seen, in a sentence or two
    """

    name: str
    q: Floats
    error: Floats
    axes: Floats
    words: str


@dataclass(frozen=True)
class ArmScene:
    """An arm at one or more poses within its workspace.

    factor  by which errors are drawn larger
    flat    whether the workspace is flat, so that it is seen from above
    cells   None where too few poses are known to colour the workspace
    """

    arm: Arm
    poses: Sequence[ShownPose]
    factor: float
    flat: bool
    cells: Cells | None
