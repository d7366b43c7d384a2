"""How far simulated robots use the tolerances of a task, and which errors make the use.

Each robot is drawn once and carries out the task in every run.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.error_model.arrival import last_motion
from lostmotion.error_model.budget import LABELS
from lostmotion.error_model.draws import Stream, visit_draws
from lostmotion.error_model.intervals import Estimate
from lostmotion.error_model.small_counts import clustered_share
from lostmotion.laws.distributions import Normal
from lostmotion.propagation.tool_errors import tool_errors

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.error_model.task import Program
    from lostmotion.spatial import Floats

PROCESS_FORCE: Final = "process force"
_OWN_HEAT: Final = "own heat"
_FORCE: Final = Stream("task.force", Normal())


@dataclass(frozen=True)
class Judged:
    """How far the tolerances were used by robots and runs.

    used    (tolerance, robot, run) share of each tolerance that is used
    at      (place, robot, run) largest share at each place; NaN where no tolerance applies
    misses  by tolerance, (output,) number of samples beyond it
    squares by tolerance, (output,) mean square of the share used
    """

    used: Floats
    at: Floats
    misses: tuple[Floats, ...]
    squares: tuple[Floats, ...]

    @property
    def held(self) -> NDArray[np.bool_]:
        """Return whether all tolerances hold (robot, run)."""
        return np.asarray((self.used <= 1).all(axis=0))


def judged(program: Program, matrix: PoseMatrix, robots: int, runs: int, seed: int) -> Judged:
    """Return how far these robots use the tolerances in these runs."""
    count, grown = len(matrix.tool), program.grown(runs).sum(axis=0)[:, :, None]
    used = np.empty((len(program.measures), robots, runs))
    at = np.full((count, robots, runs), np.nan)
    misses = [np.zeros(len(each.outputs)) for each in program.measures]
    squares = [np.zeros(len(each.outputs)) for each in program.measures]
    for here, errors in tool_errors(matrix, seed, robots, runs, program.since):
        shape = errors.shape[2:]
        varies = (
            0.0
            if program.varying is None
            else program.varying[:, :, None, None] * _force_draws(seed, here, runs)
        )
        flat = (errors + varies + grown).reshape(count, 6, -1)
        for k, each in enumerate(program.measures):
            whole, by = each.used(flat)
            used[k, here] = whole.reshape(shape)
            misses[k] += (by > 1).sum(axis=1)
            squares[k] += (by**2).sum(axis=1) / (robots * runs)
            for place, values in zip(each.outputs, by.reshape(-1, *shape), strict=True):
                at[place, here] = np.fmax(at[place, here], values)
    return Judged(used, at, tuple(misses), tuple(squares))


def _force_draws(seed: int, here: slice, runs: int) -> Floats:
    """Return the process force in each run (robot, run), in standard deviations from its mean."""
    robot, run = np.meshgrid(np.arange(here.start, here.stop), np.arange(runs), indexing="ij")
    drawn = visit_draws(seed, [_FORCE], 0, robot.ravel(), run.ravel())
    return drawn.reshape(robot.shape)


def share_of(held: NDArray[np.bool_]) -> Estimate:
    """Return the share of robots and runs (robot, run), with the interval by robots."""
    return Estimate(
        float(held.mean()), *clustered_share(held.mean(axis=1), held.shape[1]), unit="1"
    )


def worst_output(tolerances: Judged, k: int) -> int:
    """Return the output of a tolerance that is missed most often, or else used most."""
    order = np.lexsort((tolerances.squares[k], tolerances.misses[k]))
    return int(order[-1])


def shares(
    program: Program,
    matrix: PoseMatrix,
    operator: Floats,
    by: Literal["part", "cause"],
    runs: int = 1,
) -> dict[str, float]:
    """Return the share of each label in the mean square of operator @ errors, the largest first;
    operator (c, place, 6). Exact sums over terms, without sampling; the shares add up to one.

    by    "part" or "cause"
    runs  number of runs, at whose times links have grown by own heat

    Plays that a load closes in some robots only count as if the same robots had them closed at all
    places.
    """
    by_place = np.einsum("cpi,pik->pck", operator, matrix.tool)
    grown = np.einsum("cpi,jpir->jcr", operator, program.grown(runs))
    still = np.zeros(grown.shape[1])
    names = [LABELS[by](column) for column in matrix.infos]
    out = dict.fromkeys(names, 0.0)
    for key, members in matrix.groups.items():
        first = matrix.infos[members[0]]
        moved = by_place[:, :, members]
        if first.visit is None:
            drawn = moved.sum(axis=0)[None]
        elif first.of.term.sided and first.of.joint is not None:
            drawn = _together(moved, program.since[:, first.of.joint])
        else:
            drawn = moved
        whole = drawn.sum(axis=2)
        if not first.draws:  # growth adds to what has no draw, before it is squared
            still = whole[0]
            whole = whole + grown.sum(axis=0).mean(axis=1)
        if key in matrix.mixtures:
            of_columns = np.einsum("pck,kl,pcl->k", drawn, matrix.mixtures[key].correlation, drawn)
        else:
            of_columns = np.einsum("pck,pc->k", drawn, whole)
        for k, square in zip(members, of_columns, strict=True):
            out[names[k]] += float(square)
    if program.varying is not None:
        varies = np.tensordot(operator, program.varying, axes=2)
        out[PROCESS_FORCE] = float(varies @ varies)
    at_runs = still[:, None] + grown.sum(axis=0)
    for name, own in zip(own_heats(program), grown, strict=False):
        label = _OWN_HEAT if by == "cause" else name
        out[label] = out.get(label, 0.0) + float((own * at_runs).sum(axis=0).mean())
    total = sum(out.values())
    ordered = sorted(out.items(), key=lambda item: -abs(item[1]))
    return {name: square / total if total else 0.0 for name, square in ordered}


def own_heats(program: Program) -> list[str]:
    """Return the name of each joint's own heat as a contributor."""
    heat = program.task.heat
    return [] if heat is None else [f"{_OWN_HEAT} of {name}" for name in heat.joints]


def _together(moved: Floats, since: NDArray[np.int64]) -> Floats:
    """Return the sums over places (group, c, column) that share a drawn side."""
    groups, index = np.unique(since, return_inverse=True)
    out = np.zeros((len(groups), *moved.shape[1:]))
    np.add.at(out, index, moved)
    return out


def reversal(program: Program, matrix: PoseMatrix) -> Floats:
    """Return the displacement of the mean tool point (place,), m, between the path and the same
    path followed backwards; zero for joints that rest on a drawn side.
    """
    back = last_motion(program.q[::-1])[0][::-1][program.task.places]
    other = program.matrix(back)
    return np.asarray(np.linalg.norm((other.bias - matrix.bias)[:, 3:], axis=1))
