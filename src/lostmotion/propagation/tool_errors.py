"""Errors of the same robots at all poses of a task: joint samples, which distances, paths and best
fits need.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.error_model.calibrated import correlated_draws
from lostmotion.error_model.closing import standardised
from lostmotion.error_model.draws import robot_draws, visit_draws

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from lostmotion.error_model.columns import ToolScrews
    from lostmotion.error_model.draws import Stream
    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.spatial import Floats

# Errors in memory at a time: poses x components x robots x visits.
_AT_ONCE: Final = 3_000_000


def tool_errors(
    matrix: PoseMatrix,
    seed: int,
    robots: int,
    visits: int,
    since: NDArray[np.int64] | None = None,
) -> Iterator[tuple[slice, Floats]]:
    """Yield for some robots at a time their numbers, and the errors of the tool (pose, 6, robot,
    visit), rad and m, to first order.

    since  (pose, joint) first pose at which the joint has the side on which it rests there: poses
           with the same one share its drawn side. None: it is drawn at every pose

    The draws are those of a study that visits these poses, in their order.
    """
    poses = len(matrix.tool)
    together = max(1, _AT_ONCE // (6 * poses * visits))
    summed, drawn = matrix.summed, _robot_draws(matrix, seed, robots)
    numbers = _numbers(matrix, since)
    by_visit: dict[Stream | None, list[int]] = {}
    for k in np.flatnonzero(summed.tool.any(axis=(0, 1))).tolist():
        info = summed.infos[k]
        by_visit.setdefault(info.visit, []).append(k)
    for first in range(0, robots, together):
        here = slice(first, min(first + together, robots))
        count = here.stop - here.start
        out = np.zeros((poses, 6, count, visits))
        index = (
            axis.ravel()
            for axis in np.meshgrid(
                np.arange(poses), np.arange(first, here.stop), np.arange(visits), indexing="ij"
            )
        )
        pose, robot, visit = index
        for stream, columns in by_visit.items():
            factor = _by_robot(matrix, summed, columns, drawn, here)
            if stream is None:
                out += factor[..., None]
                continue
            order = numbers.get(stream.name)
            values = visit_draws(
                seed, [stream], pose if order is None else order[pose], robot, visit
            ).reshape(poses, 1, count, visits)
            out += factor[..., None] * values
        yield here, out


def _robot_draws(matrix: PoseMatrix, seed: int, robots: int) -> dict[Stream, Floats]:
    """Return the draws of each robot (robot,) by their stream; closings are uniforms."""
    streams = dict.fromkeys(
        stream
        for info in matrix.infos
        for stream in (info.robot, None if info.closing is None else info.closing.stream)
        if stream is not None
    )
    found = robot_draws(seed, list(streams), robots)
    by_stream = (found[:, k].ravel()[:robots] for k in range(len(streams)))
    out = dict(zip(streams, by_stream, strict=True))
    if matrix.correlations is not None:
        correlated = correlated_draws(seed, matrix.correlations, robots)
        for stream in streams:
            if stream.name in correlated:
                out[stream] = correlated[stream.name].ravel()[:robots]
    return out


def _by_robot(
    matrix: PoseMatrix,
    summed: ToolScrews,
    columns: list[int],
    drawn: dict[Stream, Floats],
    here: slice,
) -> Floats:
    """Return the sum of columns with one visit draw, times their robot draws: (pose, 6, robot), or
    (pose, 6, 1) where all robots have the same.
    """
    out: Floats = np.zeros((len(summed.tool), 6, 1))
    plain: list[int] = []
    draws: list[Floats] = []
    for k in columns:
        info = summed.infos[k]
        if info.closing is not None:
            row = matrix.closed[info.closing.row]
            factor = standardised(drawn[info.closing.stream][here], row[:, None])
            if info.robot is not None:
                factor = factor * drawn[info.robot][here]
            out = out + summed.tool[:, :, k, None] * factor[:, None]
        elif info.robot is not None:
            plain.append(k)
            draws.append(drawn[info.robot][here])
        else:
            out = out + summed.tool[:, :, k, None]
    if plain:
        out = out + summed.tool[:, :, plain] @ np.stack(draws)
    return out


def _numbers(matrix: PoseMatrix, since: NDArray[np.int64] | None) -> dict[str, NDArray[np.int64]]:
    """Return the pose number (pose,) under which the last motion of each joint is drawn, by the
    name of its stream.
    """
    if since is None:
        return {}
    return {
        info.visit.name: since[:, info.of.joint]
        for info in matrix.infos
        if info.visit is not None and info.of.term.sided and info.of.joint is not None
    }
