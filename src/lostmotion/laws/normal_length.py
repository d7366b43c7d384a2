"""How long is a vector that is normal, or nearly so? Means, quantiles and shares of |b + N(0, C)| in three dimensions, without sampling.

The squared length is a weighted sum of noncentral chi-squares. Its mean follows by quadrature on the real axis, its distribution by quadrature of the
inversion integral along a path near the one of steepest descent (S. O. Rice, SIAM J. Sci. Stat. Comput. 1 (1980) 438). Normal vectors: within
`ACCURACY` of the length, whatever the rank of C. With fourth cumulants the vector may depart from the normal law a little; what the next order could
still add is told with every figure.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws import normal_length_kernel as kernel

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.spatial import Floats

# Of the length: largest error of any mean or quantile of a normal vector, by the tests.
ACCURACY: Final = 1e-6
# Quantiles are told from the first of these shares to the last.
LEAST_LEVEL, MOST_LEVEL = 0.25, 0.9995


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


def normal_length(bias: Floats, covariance: Floats, levels: Sequence[float] = (0.5, 0.95, 0.99, 0.997), fourth: Floats | None = None) -> Length:
    """How long are the vectors bias (n, 3) + N(0, covariance (n, 3, 3))? Mean, and the lengths that these shares stay below.

    `fourth` (n, 15) are the coefficients of the quartic form k_ijkl h_i h_j h_k h_l of the fourth cumulants, in the order of `kernel.FOURTHS`;
    without it the vectors are normal. Zero covariance gives |bias|. NaN where the series has no quantile or the input is not finite. Raises
    ValueError for shapes that do not belong together and levels outside LEAST_LEVEL..MOST_LEVEL.
    """
    from scipy.special import ndtri

    bias, covariance, fourth = _checked(bias, covariance, fourth)
    wanted = np.asarray(levels, dtype=float)
    if len(wanted) and not (wanted.min() >= LEAST_LEVEL and wanted.max() <= MOST_LEVEL):
        raise ValueError(f"levels {list(levels)}; expected shares from {LEAST_LEVEL} to {MOST_LEVEL}")
    moments = np.empty((len(bias), 3))
    quantiles, left = np.empty((2, len(bias), len(wanted)))
    kernel.lengths(bias, covariance, fourth, wanted, ndtri(wanted), moments, quantiles, left)
    square = np.einsum("nii->n", covariance) + np.einsum("ni,ni->n", bias, bias)
    return Length(moments[:, kernel.MEAN], square, moments[:, kernel.THIRD], quantiles, moments[:, kernel.MEAN_ERROR], left)


def share_below(bias: Floats, covariance: Floats, limits: Sequence[float] | Floats, fourth: Floats | None = None) -> tuple[Floats, Floats]:
    """Which share of each vector's lengths lies below these limits? Shares (n, limit), and how much what is left out could change them.

    Arguments and errors as `normal_length`. The share's own numerical error is below 1e-6.
    """
    bias, covariance, fourth = _checked(bias, covariance, fourth)
    asked = np.asarray(limits, dtype=float)
    out, left = np.empty((2, len(bias), len(asked)))
    kernel.shares(bias, covariance, fourth, asked, out, left)
    return out, left


def _checked(bias: Floats, covariance: Floats, fourth: Floats | None) -> tuple[Floats, Floats, Floats]:
    bias, covariance = np.ascontiguousarray(bias, dtype=float), np.ascontiguousarray(covariance, dtype=float)
    kept = np.empty((0, len(kernel.FOURTHS))) if fourth is None else np.ascontiguousarray(fourth, dtype=float)
    count = len(bias)
    if bias.shape != (count, 3) or covariance.shape != (count, 3, 3) or (fourth is not None and kept.shape != (count, len(kernel.FOURTHS))):
        raise ValueError(f"bias {bias.shape}, covariance {covariance.shape}, fourth {kept.shape}; expected (n, 3), (n, 3, 3), (n, 15)")
    return bias, covariance, kept
