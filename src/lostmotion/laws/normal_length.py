"""How long is a vector that is normal, or nearly so? Means, quantiles and shares of |b + N(0, C)| in three dimensions, without sampling.

The squared length is a weighted sum of noncentral chi-squares. Its mean follows by quadrature on the real axis, its distribution by quadrature of the
inversion integral along a path near the one of steepest descent (S. O. Rice, SIAM J. Sci. Stat. Comput. 1 (1980) 438). Normal vectors: within
`ACCURACY` of the length, whatever the rank of C; one quantile in a thousand is off by more, up to `WORST`. With third and fourth cumulants the vector
may depart from the normal law a little, and as a mixture of such parts a lot; what the next order could still add is told with every figure.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws import normal_length_kernel as kernel
from lostmotion.laws.normal_length_forms_kernel import FOURTHS, THIRDS
from lostmotion.laws.normal_length_means_kernel import MEAN, MEAN_ERROR, THIRD

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from lostmotion.spatial import Floats

# Of the length: error of a mean or quantile of a normal vector, all but one in a thousand; and the largest of 20 000 random vectors that lie flat.
ACCURACY: Final = 1e-6
WORST: Final = 2e-4
# Quantiles are told from the first of these shares to the last.
LEAST_LEVEL, MOST_LEVEL = 0.25, 0.9995
# Vectors that a thread takes at a time.
_BLOCK: Final = 512


@dataclass(frozen=True, slots=True)
class Length:
    """The length of each of many vectors, in their unit; the last axis of quantiles is the level.

    mean_square is exact; cube_mean that of the normal vector. mean_left, quantiles_left: what is left out beyond the fourth cumulants may be about so
    large (zeros for normal vectors).
    """

    mean: Floats
    mean_square: Floats
    cube_mean: Floats
    quantiles: Floats
    mean_left: Floats
    quantiles_left: Floats


@dataclass(frozen=True, slots=True)
class Mixture:
    """Which of the vectors given are parts of one and the same? Parts starts[v] to starts[v + 1] (vector + 1,) make up vector v.

    weights (part,) are the shares in which it is one or the other, and sum to one over each vector.
    """

    starts: NDArray[np.int64]
    weights: Floats


def normal_length(
    bias: Floats,
    covariance: Floats,
    levels: Sequence[float] = (0.5, 0.95, 0.99, 0.997),
    fourth: Floats | None = None,
    *,
    third: Floats | None = None,
    mixture: Mixture | None = None,
    threads: int = 1,
) -> Length:
    """How long are the vectors bias (n, 3) + N(0, covariance (n, 3, 3))? Mean, and the lengths that these shares stay below.

    `third` (n, 10) and `fourth` (n, 15) are the coefficients of the forms k_ijk h_i h_j h_k and k_ijkl h_i h_j h_k h_l of the third and fourth
    cumulants, in the order of `THIRDS` and `FOURTHS`; without fourth ones the vectors are normal. With `mixture` the n are parts of fewer vectors.
    Zero covariance gives |bias|. Threads change no bit. NaN where the series has no quantile, where a quantile of a mixture falls between lengths
    that do not scatter, or where the input is not finite. Raises ValueError for shapes that do not belong together and levels outside
    LEAST_LEVEL..MOST_LEVEL.
    """
    from scipy.special import ndtri

    parts = _Parts.checked(bias, covariance, third, fourth, mixture)
    wanted = np.asarray(levels, dtype=float)
    if len(wanted) and not (wanted.min() >= LEAST_LEVEL and wanted.max() <= MOST_LEVEL):
        raise ValueError(f"levels {list(levels)}; expected shares from {LEAST_LEVEL} to {MOST_LEVEL}")
    order = np.argsort(wanted, kind="stable")
    rising = wanted[order]
    moments, quantiles, left, *_ = parts.lengths((rising, np.asarray(ndtri(rising))), np.empty(0), threads)
    back = np.argsort(order)
    square = np.einsum("nii->n", parts.covariance) + np.einsum("ni,ni->n", parts.bias, parts.bias)
    if mixture is not None:
        square = np.add.reduceat(square * parts.weights, parts.starts[:-1])
    return Length(moments[:, MEAN], square, moments[:, THIRD], quantiles[:, back], moments[:, MEAN_ERROR], left[:, back])


def share_below(
    bias: Floats,
    covariance: Floats,
    limits: Sequence[float] | Floats,
    fourth: Floats | None = None,
    *,
    third: Floats | None = None,
    mixture: Mixture | None = None,
) -> tuple[Floats, Floats]:
    """Which share of each vector's lengths lies below these limits? Shares (n, limit), and how much what is left out could change them.

    Arguments and errors as `normal_length`. The share's own numerical error is below 1e-6.
    """
    shares, _, left = share_and_density(bias, covariance, limits, fourth, third=third, mixture=mixture)
    return np.clip(shares, 0.0, 1.0), left


def share_and_density(
    bias: Floats,
    covariance: Floats,
    limits: Sequence[float] | Floats,
    fourth: Floats | None = None,
    *,
    third: Floats | None = None,
    mixture: Mixture | None = None,
    threads: int = 1,
) -> tuple[Floats, Floats, Floats]:
    """How dense are each vector's lengths at these limits besides? Shares, densities per unit of length, and what is left out: all (n, limit).

    As the series gives them: far out, shares may lie outside 0 … 1 by what is left out.
    Limits (limit,) for all vectors, or (n, limit) for each its own. Arguments and errors as `share_below`.
    """
    parts = _Parts.checked(bias, covariance, third, fourth, mixture)
    _, _, _, shares, densities, left = parts.lengths(None, np.asarray(limits, dtype=float), threads)
    return shares, densities, left


@dataclass(frozen=True, slots=True)
class _Parts:
    bias: Floats
    covariance: Floats
    third: Floats
    fourth: Floats
    weights: Floats
    starts: NDArray[np.int64]

    @classmethod
    def checked(cls, bias: Floats, covariance: Floats, third: Floats | None, fourth: Floats | None, mixture: Mixture | None) -> _Parts:
        bias, covariance = np.ascontiguousarray(bias, dtype=float), np.ascontiguousarray(covariance, dtype=float)
        count = len(bias)
        if fourth is None and third is not None:
            fourth = np.zeros((count, len(FOURTHS)))
        four = np.empty((0, len(FOURTHS))) if fourth is None else np.ascontiguousarray(fourth, dtype=float)
        three = np.zeros((len(four), len(THIRDS))) if third is None else np.ascontiguousarray(third, dtype=float)
        if bias.shape != (count, 3) or covariance.shape != (count, 3, 3) or (fourth is not None and four.shape != (count, len(FOURTHS))):
            raise ValueError(f"bias {bias.shape}, covariance {covariance.shape}, fourth {four.shape}; expected (n, 3), (n, 3, 3), (n, 15)")
        if three.shape != (len(four), len(THIRDS)):
            raise ValueError(f"third {three.shape}; expected ({len(four)}, 10)")
        if not four.any() and not three.any():
            three, four = three[:0], four[:0]
        if mixture is None:
            return cls(bias, covariance, three, four, np.ones(count), np.arange(count + 1))
        starts, weights = np.ascontiguousarray(mixture.starts, dtype=np.int64), np.ascontiguousarray(mixture.weights, dtype=float)
        if weights.shape != (count,) or starts[0] != 0 or starts[-1] != count or (np.diff(starts) < 1).any():
            raise ValueError(f"mixture of {len(weights)} weights, starts {starts[0]} to {starts[-1]}; expected {count} parts, at least one a vector")
        return cls(bias, covariance, three, four, weights, starts)

    def lengths(self, levels: tuple[Floats, Floats] | None, limits: Floats, threads: int) -> list[Floats]:
        """Call the kernel for some vectors at a time; `levels` with their normal quantiles, None to leave out the moments as well."""

        def one(first: int) -> None:
            at = slice(first, min(first + _BLOCK, count))
            own = slice(self.starts[at.start], self.starts[at.stop])
            parts = (array[own] for array in (self.bias, self.covariance, self.third, self.fourth, self.weights))
            kernel.lengths(*(*parts, self.starts[at.start : at.stop + 1] - self.starts[at.start], *wanted, asked[at], *(array[at] for array in out)))

        count = len(self.starts) - 1
        wanted = (np.empty(0), np.empty(0)) if levels is None else levels
        asked = np.ascontiguousarray(np.broadcast_to(limits, (count, limits.shape[-1])))
        out = [np.empty((0 if levels is None else count, 3)), *np.empty((2, count, len(wanted[0]))), *np.empty((3, count, asked.shape[1]))]
        firsts = range(0, count, _BLOCK)
        if threads == 1 or count <= _BLOCK:
            for first in firsts:
                one(first)
        else:
            with ThreadPoolExecutor(threads) as pool:
                list(pool.map(one, firsts))
        return out
