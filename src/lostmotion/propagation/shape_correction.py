"""Directions of rays, and the first correction of a normal vector for its shape along them, by
Hermite polynomials of the third and fourth cumulants.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from lostmotion.error_model.cumulants import Cumulants
    from lostmotion.spatial import Floats

# Directions along which the normal vector is integrated.
RAYS: Final = 256
# Axes of the squares and products of three numbers.
_PAIRS: Final = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))


@functools.cache
def directions() -> Floats:
    """Return RAYS evenly spaced unit vectors (3, ray) on a golden spiral; none of them is aligned
    with an axis.
    """
    n = np.arange(RAYS) + 0.5
    z, angle = 1 - 2 * n / RAYS, 4 * math.pi * n / (1 + math.sqrt(5))
    return np.stack([np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z])


@functools.cache
def _powers(order: int) -> tuple[tuple[int, int, int], ...]:
    """Return the exponents of x, y, z in the monomials of this order."""
    return tuple((i, j, order - i - j) for i in range(order + 1) for j in range(order + 1 - i))


def forms_of(white: Floats, known: Cumulants, closed: Floats | None) -> Floats:
    """Return the coefficients (pose, 10 + 15) of the third and fourth forms of sums white (pose, 3,
    term) @ draws.
    """
    threes, fours = known.third.terms, known.fourth.terms

    def pairs(terms: NDArray[np.int64]) -> Floats:
        one, two = white[:, :, terms[:, 0]], white[:, :, terms[:, 1]]
        return np.stack(
            [one[:, i] * two[:, j] + (one[:, j] * two[:, i] if i != j else 0.0) for i, j in _PAIRS],
            axis=1,
        )

    third = pairs(threes) * known.third.at(closed) @ white[:, :, threes[:, 2]].transpose(0, 2, 1)
    fourth = pairs(fours) * known.fourth.at(closed) @ pairs(fours[:, 2:]).transpose(0, 2, 1)
    return np.concatenate(
        [third.reshape(len(white), -1) @ _collect(3), fourth.reshape(len(white), -1) @ _collect(4)],
        axis=1,
    )


@functools.cache
def _collect(order: int) -> Floats:
    """Return ones where a product of a pair of axes with an axis (order 3) or a pair (order 4) is a
    monomial, else zeros (product, monomial).
    """
    others: tuple[tuple[int, ...], ...] = ((0,), (1,), (2,)) if order == 3 else _PAIRS  # noqa: PLR2004 - the order itself
    products = [pair + other for pair in _PAIRS for other in others]
    return np.array(
        [
            [tuple(map(axes.count, range(3))) == powers for powers in _powers(order)]
            for axes in products
        ],
        float,
    )


def excess_of(forms: Floats, deviations: Floats) -> Floats:
    """Return k_iijj / ((tr C)^2 + 2 tr C^2) (pose,) from the fourth form of the whitened sum; the
    divisor is a normal vector's mean fourth power.
    """
    fourth, variances = forms[:, len(_powers(3)) :], deviations**2
    traced = np.zeros(len(forms))
    for column, powers in enumerate(_powers(4)):
        if all(power % 2 == 0 for power in powers):
            # the coefficient of x^4 is k_xxxx; that of x^2 y^2 is six k_xxyy, of which the trace
            # has two
            share = 1.0 if max(powers) == 4 else 1 / 3  # noqa: PLR2004 - x^4
            traced += share * fourth[:, column] * np.prod(deviations ** np.array(powers), axis=1)
    normal = variances.sum(axis=1) ** 2 + 2 * (variances**2).sum(axis=1)
    return np.asarray(traced / np.where(normal > 0, normal, 1.0))


@functools.cache
def hermite_weights() -> Floats:
    """Return the weights along the rays per coefficient of the forms (10 + 15, 5 x ray), by
    Hermite's tensors: k3 : H3 / 6 + k4 : H4 / 24.

    Along r u these are (k_uuu r^3 - 3 k_iiu r) / 6 and (k_uuuu r^4 - 6 k_iiuu r^2 + 3 k_iijj) / 24.
    A trace is a Laplacian of the form.
    """
    u = {
        order: np.array(
            [
                np.prod(directions() ** np.array(powers)[:, None], axis=0)
                for powers in _powers(order)
            ]
        )
        for order in (0, 1, 2, 3, 4)
    }
    out = np.zeros((25, 5, RAYS))
    third, fourth = out[: len(_powers(3))], out[len(_powers(3)) :]
    third[:, 3], third[:, 1] = u[3] / 6, -_laplacian(3) @ u[1] / 12
    fourth[:, 4], fourth[:, 2], fourth[:, 0] = (
        u[4] / 24,
        -_laplacian(4) @ u[2] / 48,
        _laplacian(4) @ _laplacian(2) @ u[0] / 192,
    )
    return out.reshape(25, -1)


@functools.cache
def _laplacian(order: int) -> Floats:
    """Return the Laplacian of each monomial of this order, in monomials two orders lower (monomial,
    monomial).
    """
    out = np.zeros((len(_powers(order)), len(_powers(order - 2))))
    for row, powers in enumerate(_powers(order)):
        for column, lower in enumerate(_powers(order - 2)):
            difference = np.subtract(powers, lower)
            if sorted(difference) == [0, 0, 2]:
                power = powers[int(np.argmax(difference))]
                out[row, column] = power * (power - 1)
    return out
