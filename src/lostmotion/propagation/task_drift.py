"""Drift of the tool over a task by the own heat of joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.propagation.task_success import share_of

if TYPE_CHECKING:
    from lostmotion.error_model.intervals import Estimate
    from lostmotion.error_model.task import Program
    from lostmotion.propagation.task_success import Judged
    from lostmotion.spatial import Floats


@dataclass(frozen=True)
class ToolDrift:
    """Displacement of the tool by the growth of links, from where it is while all are cold.

    largest  m, of all places and runs
    place    number of the place with it
    time     s, when it is visited
    joints   the joints, and the share (joint,) of each in the largest displacement
    growth   (joint, 3) m, displacement there by the full rise of each joint's link
    first, last  probability that all tolerances hold in the first and the last run
    """

    largest: float
    place: int
    time: float
    joints: tuple[str, ...]
    shares: Floats
    growth: Floats
    first: Estimate
    last: Estimate

    @classmethod
    def of(cls, program: Program, judged: Judged) -> ToolDrift | None:
        """Return the drift over a task; None without own heat."""
        heat, growth = program.task.heat, program.growth
        if heat is None or growth is None:
            return None
        runs = judged.held.shape[1]
        each = program.grown(runs)[:, :, 3:]  # (joint, place, 3, run)
        size = np.linalg.norm(each.sum(axis=0), axis=1)
        place, run = np.unravel_index(size.argmax(), size.shape)
        whole = each[:, place, :, run].sum(axis=0)
        square = float(whole @ whole)
        shares = each[:, place, :, run] @ whole / (square or 1.0)
        return cls(
            float(size[place, run]),
            int(place),
            float(heat.times(len(size), runs)[place, run]),
            heat.joints,
            shares,
            growth[:, place, 3:],
            share_of(judged.held[:, :1]),
            share_of(judged.held[:, -1:]),
        )
