"""The study without sampling: mean vector and covariance are exact sums over terms;
`error_magnitude` computes the error's magnitude from them.
"""

from __future__ import annotations

import functools
from collections import Counter, deque
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeVar

import numpy as np

from lostmotion.error_model.bounds import bounds
from lostmotion.error_model.calibrated import streams_of
from lostmotion.error_model.cumulants import cumulants
from lostmotion.error_model.pose_sets import blocks_of_sets, matrices_of
from lostmotion.error_model.poses import Poses
from lostmotion.error_model.remedies import STAGES, screws_at_stage
from lostmotion.errors import refuse_argument
from lostmotion.laws.distributions import COMPARED
from lostmotion.mechanism.state import BLOCK, as_poses
from lostmotion.propagation.error_magnitude import (
    LEVELS,
    POINTS,
    TILE,
    Magnitude,
    Plays,
    figures,
    pooled_counts,
    sobol_draws,
)
from lostmotion.propagation.montecarlo.memory import keep_freed

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Iterator, Sequence

    from numpy.typing import NDArray

    from lostmotion.error_model.pose_matrix import PoseMatrix
    from lostmotion.laws.distributions import Law
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

_Found = TypeVar("_Found")
_LEAST_LEVEL: Final = 0.25
_MOST_LEVEL: Final = 0.9995
# A figure is valid, and is printed, if its uncertainty is at most this share of it.
MOST_UNCERTAIN: Final = 0.05


@dataclass(frozen=True)
class Analytic:
    """The error at every pose over all robots and visits, in SI, by sums over terms. The magnitude
    is the length of the error vector.

    levels          shares of the quantiles, 0..1
    bias            (pose, 3) mean error vector, m
    covariance      (pose, 3, 3) covariance of the error vector, m^2
    mean            (pose,) mean magnitude, m
    deviation       (pose,) standard deviation of the magnitude, m
    quantiles       (pose, level) quantiles of the magnitude, m
    mean_uncertainty, deviation_uncertainty, quantiles_uncertainty: half-widths of about 95 %
    intervals of these figures, m
    nearly_normal   (pose,) whether the error is close enough to a normal vector for integration
                    along rays; elsewhere points are used
    excess          (pose,) relative difference of the scatter's mean fourth power from a normal
                    vector's: 0 normal, below 0 flat or two-sided
    worst, rss      (pose,) worst case and root-sum-square bound, m; NaN where they were not asked
                    for
    """

    levels: tuple[float, ...]
    bias: Floats
    covariance: Floats
    mean: Floats
    deviation: Floats
    quantiles: Floats
    mean_uncertainty: Floats
    deviation_uncertainty: Floats
    quantiles_uncertainty: Floats
    nearly_normal: NDArray[np.bool_]
    excess: Floats
    worst: Floats
    rss: Floats

    @property
    def mean_square(self) -> Floats:
        """Return the exact mean-square error (pose,), m^2."""
        return np.asarray(
            np.einsum("pii->p", self.covariance) + np.einsum("pi,pi->p", self.bias, self.bias)
        )

    @property
    def valid(self) -> NDArray[np.bool_]:
        """Return whether (pose,) the uncertainties of the mean and of all quantiles are at most 5 %
        of them.
        """
        mean = self.mean_uncertainty <= MOST_UNCERTAIN * self.mean
        return np.asarray(
            mean & (self.quantiles_uncertainty <= MOST_UNCERTAIN * self.quantiles).all(axis=1)
        )


def analytic(
    arm: Arm,
    poses: Poses | Floats,
    *,
    approach: float = 0.0,
    levels: Sequence[float] = LEVELS,
    stage: str = STAGES[0],
    threads: int = 1,
    progress: Callable[[str, int, int], None] | None = None,
) -> Analytic:
    """Return the error of the tool at each of these poses, over all robots and visits, by sums over
    terms instead of samples.

    Valid to first order in the errors. Figures of single robots, such as AP and RP, require Monte
    Carlo.

    poses     `Poses`, or q (pose, joint) in rad or m
    approach  sign of the joints' last motion, 0 where it is drawn at every visit
    levels    shares of the quantiles, from 0.25 to 0.9995
    stage     which remedies are applied, one of `remedies.EVERY_STAGE`
    threads   number of threads; it changes no bit of the result
    progress  called with the name of the step, the number of poses done, and the number of all
              poses

    Raises InputError for no poses, and for approach or threads out of range, ValueError for levels
    outside 0.25 … 0.9995 and for q of another shape or not finite.
    """
    wanted = tuple(float(level) for level in levels)
    if not all(_LEAST_LEVEL <= level <= _MOST_LEVEL for level in wanted):
        raise ValueError(
            f"levels {list(levels)}; expected shares from {_LEAST_LEVEL} to {_MOST_LEVEL}"
        )
    if threads < 1:
        raise refuse_argument("threads", threads, "at least 1", threads=2)
    if approach not in (-1, 0, 1):
        raise refuse_argument("approach", approach, "-1, 0 or 1", approach=0)
    q = as_poses(arm, poses.q if isinstance(poses, Poses) else poses)
    if not len(q):
        raise refuse_argument("poses", "none", "at least one", poses=128)
    keep_freed()
    drawn = DrawnColumns(screws_at_stage(arm, q[:TILE], stage, approach=approach))
    found: list[Analytic] = []
    for one in over_blocks(
        arm,
        q,
        blocks_of_sets(len(q), 1, BLOCK),
        (stage, approach),
        threads,
        lambda matrix: of_screws(matrix, drawn, wanted),
    ):
        found.append(one)
        if progress is not None:
            progress("summing up terms", min(len(found) * BLOCK, len(q)), len(q))
    return joined(found)


def joined(blocks: Sequence[Analytic]) -> Analytic:
    """Return the figures of several sets of poses, at the same levels, as those of one set."""
    arrays = [name for name in Analytic.__dataclass_fields__ if name != "levels"]
    return Analytic(
        blocks[0].levels,
        *(np.concatenate([getattr(one, name) for one in blocks]) for name in arrays),
    )


def of_screws(
    matrix: PoseMatrix,
    drawn: DrawnColumns,
    levels: Sequence[float] = LEVELS,
    *,
    with_bounds: bool = True,
) -> Analytic:
    """Return the figures at the poses of this matrix, with or without bounds; `drawn` are the drawn
    columns of the same arm.
    """
    shift, bias = drawn.shift(matrix), np.ascontiguousarray(matrix.bias[:, 3:])
    found = drawn.figures(matrix, shift, bias, levels)
    unknown = np.full(len(bias), np.nan)
    return Analytic(
        tuple(levels),
        bias,
        shift @ shift.transpose(0, 2, 1),
        *(found.values[:, 0], found.values[:, 1], found.values[:, 2:]),
        *(found.uncertainty[:, 0], found.uncertainty[:, 1], found.uncertainty[:, 2:]),
        found.nearly_normal,
        found.excess,
        *(bounds(matrix) if with_bounds else (unknown, unknown)),
    )


class DrawnColumns:
    """The drawn columns of an arm's merged pose matrix: their cumulants, and their draws at Sobol
    points, which are the same at every pose.

    The columns that depend on whether a robot's play is closed are the last ones. They count only
    at poses where some robots have it closed.

    cumulants   cumulants of the other columns
    with_plays  cumulants of all columns
    plays       rows of the matrix's `closed`, in the order of `with_plays.closings`
    """

    def __init__(self, matrix: PoseMatrix) -> None:
        """Take the columns of the matrix at some poses; the largest columns there use the first
        coordinates of the Sobol sequence.
        """
        infos = matrix.merged.infos
        drawn = matrix.merged.columns("robot", "visit", "robot x visit")
        self._columns = np.array(
            sorted(drawn, key=lambda k: infos[k].closing is not None), dtype=int
        )
        closings = [closing for k in self._columns if (closing := infos[k].closing) is not None]
        self._steady = len(self._columns) - len(closings)
        # Two plays with one friction, such as an axial play that any of three loads closes, have
        # different shares: each counts as its own draw.
        terms = [
            [
                (
                    (stream, closing.row)
                    if (closing := infos[k].closing) and law == COMPARED
                    else stream,
                    law,
                )
                for stream, law in infos[k].draws
            ]
            for k in self._columns
        ]
        self.cumulants = cumulants(terms[: self._steady])
        self.with_plays = cumulants(terms) if closings else self.cumulants
        by_row = {closing.row: closing for closing in closings}
        self.plays = np.array(list(by_row), dtype=int)
        self._of_term = np.array(
            [list(by_row).index(closing.row) for closing in closings], dtype=int
        )
        # Correlated draws are sums of independent ones, which have coordinates of the sequence.
        sums: dict[Hashable, Floats] = {
            ("robot", stream.name): direction
            for mixed in matrix.mixtures.values()
            for stream, direction in zip(mixed.streams, mixed.directions, strict=True)
        }
        independent: list[tuple[Hashable, Law]] = [
            (("robot", stream.name), stream.law) for stream in streams_of(matrix.correlations)
        ]
        importance: Counter[Hashable] = Counter()
        for k, size in zip(self._columns, (self.shift(matrix) ** 2).sum(axis=(0, 1)), strict=True):
            for stream, _ in infos[k].draws:
                if stream not in sums:
                    importance[stream] += size
                    continue
                for (each, _), share in zip(independent, sums[stream].tolist(), strict=True):
                    importance[each] += size * share**2
        own = [
            [
                (stream, law)
                for stream, law in infos[k].draws
                if law != COMPARED and stream not in sums
            ]
            for k in self._columns
        ]
        uniforms = [[(("closing", closing.stream.name), COMPARED)] for closing in by_row.values()]
        directions = {
            row: sums[stream]
            for row, k in enumerate(self._columns)
            for stream, _ in infos[k].draws
            if stream in sums
        }

        @functools.cache
        def points(count: int) -> Floats:
            """Return the draws (term, count) at `count` points, followed by the uniforms that
            decide whether plays are closed.
            """
            each = [[stream] for stream in independent]
            found = sobol_draws([*own, *uniforms, *each], importance, count)
            found, of_independent = np.split(found, [len(own) + len(uniforms)])
            if directions:
                found[list(directions)] *= np.array(list(directions.values())) @ of_independent
            return found

        self._drawn = points

    def draws(self, count: int) -> Floats:
        """Return the draws (term, count) at `count` points; for plays, without the factor that
        depends on whether they are closed.
        """
        return self._drawn(count)[: len(self._columns)]

    def _steady_draws(self, count: int) -> Floats:
        return self.draws(count)[: self._steady]

    def shift(self, matrix: PoseMatrix) -> Floats:
        """Return the displacement of the tool point per unit of each draw (pose, 3, term), m."""
        return np.ascontiguousarray(matrix.merged.tool[:, 3:][:, :, self._columns])

    def figures(
        self, matrix: PoseMatrix, shift: Floats, bias: Floats, levels: Sequence[float]
    ) -> Magnitude:
        """Return the figures of the error's magnitude at each pose: shift (pose, 3, term) and bias
        (pose, 3) of the same matrix, m.
        """
        some = np.asarray(matrix.closed_in_some.any(axis=0))
        if not some.any():
            return figures(
                shift[:, :, : self._steady], bias, self.cumulants, self._steady_draws, levels
            )
        elsewhere = figures(
            shift[~some][:, :, : self._steady],
            bias[~some],
            self.cumulants,
            self._steady_draws,
            levels,
        )
        plays = self._deciding(POINTS, matrix, some)
        there = figures(shift[some], bias[some], self.with_plays, self.draws, levels, plays)
        back = np.argsort(np.concatenate([np.flatnonzero(~some), np.flatnonzero(some)]))
        return Magnitude(
            *(
                np.concatenate([getattr(elsewhere, name), getattr(there, name)])[back]
                for name in Magnitude.__dataclass_fields__
            )
        )

    def pooled_counts(self, matrix: PoseMatrix, points: int) -> NDArray[np.int64]:
        """Return the numbers of magnitudes in each bin (block, bin) at this number of points, over
        all poses of the matrix.
        """
        shift, bias, some = (
            self.shift(matrix),
            np.ascontiguousarray(matrix.bias[:, 3:]),
            np.asarray(matrix.closed_in_some.any(axis=0)),
        )
        out = pooled_counts(
            shift[~some][:, :, : self._steady], bias[~some], self._steady_draws(points)
        )
        if some.any():
            out += pooled_counts(
                shift[some], bias[some], self.draws(points), self._deciding(points, matrix, some)
            )
        return out

    def _deciding(self, points: int, matrix: PoseMatrix, poses: NDArray[np.bool_]) -> Plays:
        """Return the data that decide whether plays are closed at the selected poses (pose,) of the
        matrix.
        """
        return Plays(
            self._drawn(points)[len(self._columns) :],
            matrix.closed[self.plays][:, poses].T,
            self._of_term,
        )


def over_blocks(
    arm: Arm,
    q: Floats,
    blocks: Sequence[slice],
    of: tuple[str, float],
    threads: int,
    work: Callable[[PoseMatrix], _Found],
) -> Iterator[_Found]:
    """Yield the result of `work` for the pose matrix of each block of poses, in order; `of`: stage
    and approach.
    """
    # Building a pose matrix is many short steps in Python, and stays in one thread: two that do it
    # at once would slow each other down.
    matrices = matrices_of(
        blocks, lambda rows: screws_at_stage(arm, q[rows], of[0], approach=of[1])
    )
    if threads == 1:
        yield from map(work, matrices)
        return
    with ThreadPoolExecutor(threads) as pool:
        waiting: deque[Future[_Found]] = deque()
        for matrix in matrices:
            waiting.append(pool.submit(work, matrix))
            if len(waiting) > threads:
                yield waiting.popleft().result()
        for each in waiting:
            yield each.result()
