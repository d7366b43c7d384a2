"""The study without sampling: mean vector and covariance of the error are exact sums over terms, its mean and quantiles follow by quadrature.

The terms' third and fourth cumulants enter as well, so flat, two-sided and wavy draws count as what they are, to first order. Where a few such draws
dominate, the error is no nearly normal vector, but a mixture of such: its largest draws are cut into cells of their law (`conditioned`). Figures
that this leaves unsure are read off a lattice (`lattice_length`), and what that does not tell off points over the draws (`points`). What is unsure
then has no figure here, and Monte Carlo is the way.
"""

from __future__ import annotations

import functools
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from math import prod
from threading import Lock
from typing import TYPE_CHECKING, Final, NamedTuple, Protocol, TypeAlias, cast

import numpy as np

from lostmotion.error_model.cumulants import cumulants
from lostmotion.error_model.pose_matrix import Screws, root_sum_square, screws, worst_case
from lostmotion.error_model.poses import Poses
from lostmotion.errors import refuse_argument
from lostmotion.laws.lattice_length import FINE, Draws, Lengths, Vectors, lattice_length
from lostmotion.laws.normal_length import WORST, Mixture, normal_length
from lostmotion.laws.normal_length_forms_kernel import FOURTHS
from lostmotion.mechanism.serial import as_poses
from lostmotion.propagation.analytic.conditioned import Cut, choose, condition, cuts
from lostmotion.propagation.analytic.credible import SMOOTH, SMOOTH_PARTS, believable, of_two_sides, on_a_line
from lostmotion.propagation.analytic.points import EACH, Points, by_points, points_of
from lostmotion.propagation.analytic.smoothened import smooth_draws, smoothen
from lostmotion.propagation.analytic.sums import Sums, sums, variance
from lostmotion.propagation.analytic.values import values_of
from lostmotion.propagation.montecarlo.memory import keep_freed
from lostmotion.spatial import mapped

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from numpy.typing import NDArray

    from lostmotion.laws.distributions import Smooth
    from lostmotion.mechanism.arm import Arm
    from lostmotion.spatial import Floats

LEVELS: Final = (0.5, 0.95, 0.99, 0.997)
# Poses at a time: few, where some take long; many, where all are quick, since every block walks the arm afresh.
BLOCK: Final = 1024
QUICK_BLOCK: Final = 5000
# Parts that the error at a pose is cut into where it is not nearly normal, one attempt after the other; and of all poses, what `pooled` can keep.
PARTS: Final = (16, 48)
MOST_PARTS: Final = 400_000
_AT_ONCE: Final = 16_384
# A figure that the next order may move by a larger share of itself is not told, and none at a pose where it moves the mean of a mixture by the
# second share, or any figure of one nearly normal part by the third.
MOST_LEFT_OUT: Final = 0.02
SURE_MEAN: Final = 0.01
FAR_FROM_NORMAL: Final = 0.1


class Law(Protocol):
    """Shares of the lengths of some errors; missed (n,) how far they may be off."""

    missed: Floats

    def share(self, some: NDArray[np.int64], lengths: Floats) -> tuple[Floats, Floats]:
        """Which share of some errors' lengths lies below these (some, length), and how dense are they there?"""


Known: TypeAlias = "tuple[NDArray[np.int64], Law, NDArray[np.int64]]"


@dataclass(frozen=True)
class Analytic:
    """What the terms say of every pose, in SI; nothing was drawn.

    bias            (pose, 3) mean error, m
    covariance      (pose, 3, 3) of the error, m^2
    fourth          (pose, 15) fourth cumulants of the error as a quartic form (`normal_length.FOURTHS`), m^4
    mean            (pose,) mean distance, m; NaN where the error is too far from normal for it
    mean_bound      (pose,) how far `mean` may be off: quadrature, and an estimate of what lies beyond fourth cumulants
    quantiles       (pose, level) distance that this share stays below, NaN likewise; quantiles_bound as mean_bound
    normal          (pose,) whether the error is near enough to normal for all of these figures
    excess          (pose,) by which share the scatter's mean fourth power differs from a normal vector's: 0 normal, below 0 flat or two-sided
    worst, rss      (pose,) everything at its limit, and root-sum-square
    parts           the nearly normal parts of every pose's error, most often one: what `pooled` sums over
    laws            poses whose lengths are known better than by their parts: which, their laws, and which of those they are
    """

    levels: tuple[float, ...]
    bias: Floats
    covariance: Floats
    third: Floats
    fourth: Floats
    mean: Floats
    mean_bound: Floats
    quantiles: Floats
    quantiles_bound: Floats
    normal: np.ndarray
    excess: Floats
    worst: Floats
    rss: Floats
    parts: tuple[Sums, Mixture]
    laws: tuple[Known, ...]

    @property
    def mean_square(self) -> Floats:
        """Give the mean square error (pose,), m^2: exact."""
        return np.asarray(np.einsum("pii->p", self.covariance) + np.einsum("pi,pi->p", self.bias, self.bias))

    @property
    def lattice(self) -> NDArray[np.bool_]:
        """Tell where (pose,) a figure was told off a lattice of the characteristic function."""
        return self._told_by(Lengths)

    @property
    def points(self) -> NDArray[np.bool_]:
        """Tell where (pose,) a figure was told by points of Sobol sequences over the draws."""
        return self._told_by(Points)

    def _told_by(self, kind: type) -> NDArray[np.bool_]:
        out = np.zeros(len(self.mean), bool)
        for at, law, _ in self.laws:
            if isinstance(law, kind):
                out[at] = True
        return out


def analytic(
    arm: Arm,
    poses: Poses | Floats,
    *,
    approach: float = 0.0,
    levels: Sequence[float] = LEVELS,
    quick: bool = False,
    threads: int = 1,
    progress: Callable[[str, int, int], None] | None = None,
) -> Analytic:
    """How far off is the tool at these poses, over all robots and visits, by sums over terms instead of samples?

    Poses, or q (pose, joint) rad or m. `approach` the sign of the joints' last motion, 0 where it differs from visit to visit. Each figure has its
    bound beside it, an estimate held against samples (docs/theory/accuracy.md), and is told where that is at most 2 % of it, NaN elsewhere; a pose
    whose error is far from normal takes milliseconds for that. `quick` takes microseconds for each and looks at none twice: all figures of a pose are
    told, or, where one may be off by more than 10 % or the scatter is no nearly normal one, none. Threads change no bit. Over all robots and visits
    together: what one robot does, and how it repeats, Monte Carlo tells. First order in the errors. `progress` hears what is done, how many poses,
    of how many. Raises InputError for no poses, and for approach or threads out of range, ValueError for levels outside 0.25 … 0.9995 and for q of
    another shape or not finite.
    """
    if threads < 1:
        raise refuse_argument("threads", threads, "at least 1", "threads = 2")
    if approach not in (-1, 0, 1):
        raise refuse_argument("approach", approach, "-1, 0 or 1", "approach = 0")
    asked = tuple(float(level) for level in levels)
    q = as_poses(arm, poses.q if isinstance(poses, Poses) else poses)
    if not len(q):
        raise refuse_argument("poses", "none", "at least one", "lostmotion.sample_poses(arm, 128)")
    keep_freed()
    known: list[_Draws] = []  # of the draws: the same at every pose
    size = min(max(-(-len(q) // threads), 1), QUICK_BLOCK) if quick else BLOCK

    # Walking the arm is many short steps in Python: two threads at it would hold each other up.
    walking = Lock()

    def block(first: int) -> Analytic:
        with walking:
            matrix = screws(arm, q[first : first + size], approach=approach)
            if not known:
                known.append(_Draws(matrix, ("robot", "visit", "robot x visit")))
        return _block(matrix, known[0], asked, quick=quick)

    starts = range(0, len(q), size)
    found: list[Analytic] = []
    room = MOST_PARTS
    with ThreadPoolExecutor(threads) as pool:
        for one in map(block, starts) if threads == 1 else pool.map(block, starts):
            count = len(one.parts[1].weights)
            if count - len(one.mean) > room:  # no memory for them: over all poses, these count as one nearly normal part each
                whole = Sums(one.bias, one.covariance, one.third, one.fourth)
                found.append(replace(one, parts=(whole, Mixture(np.arange(len(one.mean) + 1), np.ones(len(one.mean))))))
            else:
                found.append(one)
                room -= count - len(one.mean)
            if progress is not None:
                progress("summing up terms", min(len(found) * size, len(q)), len(q))
    arrays = [name for name in Analytic.__dataclass_fields__ if name not in {"levels", "parts", "laws"}]
    joined = {name: np.concatenate([getattr(one, name) for one in found]) for name in arrays}
    laws = tuple((first + at, law, own) for first, one in zip(starts, found, strict=True) for at, law, own in one.laws)
    return Analytic(levels=asked, parts=_joined([one.parts for one in found]), laws=laws, **joined)


def _joined(parts: list[tuple[Sums, Mixture]]) -> tuple[Sums, Mixture]:
    found = Sums(*(np.concatenate(arrays) for arrays in zip(*(one.arrays for one, _ in parts), strict=True)))
    counts = np.concatenate([np.diff(mixture.starts) for _, mixture in parts])
    return found, Mixture(np.append(0, np.cumsum(counts)), np.concatenate([mixture.weights for _, mixture in parts]))


def of_screws(matrix: Screws, levels: Sequence[float] = LEVELS, *, only: Sequence[str] = ("robot", "visit", "robot x visit")) -> Analytic:
    """What do the terms of these poses say by themselves? `only` names the levels of chance that vary; the bias counts whole."""
    return _block(matrix, _Draws(matrix, only), tuple(levels))


class _Draws:
    """What is known of an arm's draws without any pose: the cumulants of the terms that vary, and into which cells they can be cut."""

    def __init__(self, matrix: Screws, only: Sequence[str]) -> None:
        self._infos, self.columns = matrix.infos, matrix.columns(*only)  # type: ignore[arg-type]
        self.cumulants = cumulants(self._infos, self.columns)
        self.sides = of_two_sides(self._infos, self.columns)
        self._values: dict[int, Draws | None] = {}
        self._points: dict[int, Floats] = {}

    @functools.cached_property
    def cuts(self) -> tuple[Cut, ...]:
        return cuts(self._infos, self.columns, self.cumulants)

    @functools.cached_property
    def smooth(self) -> dict[int, Smooth]:
        """Give the laws of draws without steps that one term alone takes, by the term's row."""
        return smooth_draws(self._infos, self.columns)

    def points(self, each: int) -> Floats:
        """Give the draws (term, point) that stand for all, so many in each set."""
        if each not in self._points:
            self._points[each] = points_of(self._infos, self.columns, each)
        return self._points[each]

    def values(self, fine: int) -> Draws | None:
        """Give what the draws can be where the length is followed so finely."""
        if fine not in self._values:
            self._values[fine] = values_of(self._infos, self.columns, fine)
        return self._values[fine]


def _block(matrix: Screws, known: _Draws, levels: tuple[float, ...], *, quick: bool = False) -> Analytic:
    whole = sums(matrix.along_poses[3:], known.cumulants, np.asarray(matrix.bias[:, 3:]))
    figures, bounds = _figures(whole, None, levels)
    worst = worst_case(matrix)
    scatter = on_a_line(whole.covariance, levels)
    of_sides = variance(matrix.along_poses[3:], known.cumulants, known.sides)
    smooth = np.einsum("pii->p", whole.covariance) - of_sides
    even = smooth >= SMOOTH * of_sides
    bounds[~(believable(figures, bounds, scatter, worst).all(axis=1) & even)] = np.nan  # the series says nothing there
    near = np.all(bounds <= FAR_FROM_NORMAL * figures, axis=1, keepdims=True)
    told = (bounds <= (FAR_FROM_NORMAL if quick else MOST_LEFT_OUT) * figures) & near
    parts = [(np.arange(len(figures)), whole, np.ones(len(figures)))]
    for most in () if quick else PARTS:
        short = np.flatnonzero(~told.all(axis=1))
        for poses, taken in _worth_cutting(matrix, known, short, most):
            part, mixture = condition(matrix, known.cumulants, taken, poses)
            value, bound = _figures(part, mixture, levels)
            left = known.sides.difference(*(cut.terms for cut in taken))
            uncut = variance(matrix.along_poses[3:][:, :, poses], known.cumulants, left)
            solid = (smooth[poses] >= SMOOTH_PARTS * uncut)[:, None]
            better = solid & ((bound < bounds[poses]) | (np.isnan(bounds[poses]) & ~np.isnan(bound)))
            figures[poses], bounds[poses] = np.where(better, value, figures[poses]), np.where(better, bound, bounds[poses])
            # Between the lengths of two parts a quantile is vague or none; that says nothing against the others, but the mean must be sure.
            fair = (bound <= MOST_LEFT_OUT * value) & believable(value, bound, scatter[poses], worst[poses])
            told[poses] |= better & fair & (bound[:, :1] <= SURE_MEAN * value[:, :1])
            parts.append((np.repeat(poses, len(mixture.weights) // len(poses)), part, mixture.weights))
    laws: list[Known] = []
    if not quick:
        laws += _better(_on_lattice(matrix, known, whole, levels, figures, told, even), figures, bounds, told)
        for each in EACH:
            laws += _better(_by_points(matrix, known, whole, levels, told, each), figures, bounds, told)
    return Analytic(
        levels,
        *whole.arrays,
        np.where(told[:, 0], figures[:, 0], np.nan),
        bounds[:, 0],
        np.where(told[:, 1:], figures[:, 1:], np.nan),
        bounds[:, 1:],
        np.asarray(told.all(axis=1)),
        _excess(whole.covariance, whole.fourth),
        worst,
        root_sum_square(matrix),
        _finest(parts, len(figures)),
        tuple(laws),
    )


def _on_lattice(
    matrix: Screws, known: _Draws, whole: Sums, levels: tuple[float, ...], figures: Floats, told: np.ndarray, even: np.ndarray
) -> _Found | None:
    """Find the figures of poses where some is missing, and lengths do not stand in steps, by the characteristic function on a lattice."""
    short = np.flatnonzero(~told.all(axis=1) & even)
    if not len(short) or known.values(FINE[0]) is None:
        return None
    vectors = Vectors(matrix.tool[short, 3:], *(array[short] for array in whole.arrays))
    every = cast("Callable[[int], Draws]", known.values)
    found = lattice_length(every, vectors, np.array(levels), figures[short, 1:], ~told[short], MOST_LEFT_OUT)
    return _Found(short, found.values, found.bounds + WORST * found.values, found.lengths)


def _by_points(matrix: Screws, known: _Draws, whole: Sums, levels: tuple[float, ...], told: np.ndarray, each: int) -> _Found | None:
    """Find the figures of poses where some is missing still by points of Sobol sequences."""
    short = np.flatnonzero(~told.all(axis=1))
    if not len(short) or not len(known.columns):
        return None
    of_poses = whole.bias[short], matrix.tool[short, 3:][:, :, known.columns], np.array(levels)
    values, bounds, law = by_points(known.points(each), *of_poses)
    quantiles = values[:, 1:], bounds[:, 1:]
    for fewer in EACH if each == EACH[-1] else ():
        wanted = ~told[short, 1:] & (quantiles[1] > (MOST_LEFT_OUT - WORST) * quantiles[0])
        smoothen(quantiles, wanted, known.points(fewer), *of_poses, known.smooth)
    every = np.arange(len(short))
    return _Found(short, values, bounds + WORST * values, ((every, law, every),))


class _Found(NamedTuple):
    """Figures (n, figure) of some poses and their bounds, and the laws they were read off: which of the n, the law, which of its own."""

    poses: NDArray[np.int64]
    values: Floats
    bounds: Floats
    laws: Sequence[Known]


def _better(found: _Found | None, figures: Floats, bounds: Floats, told: np.ndarray) -> list[Known]:
    """Take what was missing, or is known better now: change figures, bounds and told in place. Gives the laws of the poses where that told any."""
    if found is None:
        return []
    poses, value, bound, laws = found
    better = (bound <= MOST_LEFT_OUT * value) & (~told[poses] | (bound < bounds[poses]))
    rows, columns = np.nonzero(better)
    figures[poses[rows], columns], bounds[poses[rows], columns], told[poses[rows], columns] = value[better], bound[better], True
    used = np.asarray(better.any(axis=1))
    return [(poses[at[used[at]]], law, own[used[at]]) for at, law, own in laws if used[at].any()]


def _worth_cutting(matrix: Screws, known: _Draws, poses: np.ndarray, most: int) -> Iterator[tuple[np.ndarray, tuple[Cut, ...]]]:
    """Give some poses at a time with the groups of terms that are worth cutting there."""
    if not len(poses) or not known.cuts:
        return
    taken = choose(matrix, known.cumulants, known.cuts, poses, most)
    for pattern in np.unique(taken[taken.any(axis=1)], axis=0):
        some = tuple(cut for cut, use in zip(known.cuts, pattern, strict=True) if use)
        alike = poses[(taken == pattern).all(axis=1)]
        step = max(_AT_ONCE // prod(len(cut.shares) for cut in some), 1)
        for first in range(0, len(alike), step):
            yield alike[first : first + step], some


def _figures(parts: Sums, mixture: Mixture | None, levels: Sequence[float]) -> tuple[Floats, Floats]:
    """Give mean and quantiles of the length (pose, 1 + level), and how far they may be off."""
    length = normal_length(parts.bias, parts.covariance, levels, parts.fourth, third=parts.third, mixture=mixture)
    value = np.column_stack([length.mean, length.quantiles])
    return value, np.column_stack([length.mean_left, length.quantiles_left]) + WORST * value


def _finest(parts: list[tuple[np.ndarray, Sums, Floats]], count: int) -> tuple[Sums, Mixture]:
    """Keep of every pose the parts that it was cut into last, in the poses' order."""
    if len(parts) == 1:
        return parts[0][1], Mixture(np.arange(count + 1), parts[0][2])
    last = np.zeros(count, int)
    for n, (poses, _, _) in enumerate(parts):
        last[poses] = n
    kept = [last[poses] == n for n, (poses, _, _) in enumerate(parts)]
    owner = np.concatenate([poses[keep] for keep, (poses, _, _) in zip(kept, parts, strict=True)])
    order = np.argsort(owner, kind="stable")
    arrays = zip(*((*part.arrays, weights) for _, part, weights in parts), strict=True)
    *found, weights = (np.concatenate([array[keep] for keep, array in zip(kept, every, strict=True)])[order] for every in arrays)
    return Sums(*found), Mixture(np.searchsorted(owner[order], np.arange(count + 1)), weights)


def _excess(covariance: Floats, forms: Floats) -> Floats:
    """Give k_iijj over the mean fourth power of a normal vector, (tr C)^2 + 2 tr C^2."""
    weight = np.array([1.0 if max(powers) == 4 else 1 / 3 if sorted(powers) == [0, 2, 2] else 0.0 for powers in FOURTHS])  # noqa: PLR2004 - x^4; x^2 y^2
    normal = np.einsum("pii->p", covariance) ** 2 + 2 * np.einsum("pij,pij->p", covariance, covariance)
    return mapped(weight, forms) / np.where(normal > 0, normal, 1.0)
