"""A thin ring, such as the drawn cup of a needle bearing, on rollers in the bore of an elastic
body.

The rollers push unilaterally on the cup at single angles. The cup slides in the bore, in contact
all round: for every harmonic of the pressure its bending stiffness adds to the stiffness of the
bore. A soft bore adds to the bearing's deflection; the bending of the cup matters while
E_cup t^3/(12 a^3 E) is below 1.

Source: harmonics of the bore from `annulus`; inextensional bending of a ring, A. Love, A Treatise
on the Mathematical Theory of Elasticity, 1927.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.annulus import edge_compliance
from lostmotion.laws.rolling.radial import BEARING_STEEL, element_angles

if TYPE_CHECKING:
    from lostmotion.laws.annulus import Annulus
    from lostmotion.spatial import Floats

# Harmonics of the pressure under the cup, per roller.
_HARMONICS: Final = 12
_ITERATIONS: Final = 200
_CONVERGED: Final = 1e-10


def cup_in_bore(
    bore: Annulus,
    thickness: float,
    rollers: int,
    stiffness: float,
    exponent: float,
    force: float,
    material: tuple[float, float] = BEARING_STEEL,
) -> tuple[float, float]:
    """Return the shift (m) of the shaft in a needle bearing with a thin cup, and the force (N) on
    its most heavily loaded roller.

    bore       loaded at its inner radius, fixed outside
    thickness  of the cup, m; infinite for a cup that does not bend
    rollers, stiffness, exponent  number of rollers, the first one in line with the force; K (N/m^n)
                                  of each, and its exponent n
    force      N, above zero
    material   Young's modulus (Pa) and Poisson's ratio of the cup

    Without clearance. Raises ValueError for a force that is not positive, DidNotConvergeError where
    no equilibrium is found.
    """
    if not (force > 0 and thickness > 0):
        raise ValueError("a cup in a bore needs a force and a thickness above zero")
    angles = element_angles(rollers)
    cosine, give = np.cos(angles), _radial_flexibility(bore, thickness, angles, material)
    shift = (force / stiffness) ** (1 / exponent)
    loads = np.maximum(cosine, 0.0) * force / float(np.maximum(cosine, 0.0) @ cosine)
    for _ in range(_ITERATIONS):
        # Newton on the rollers in contact: their approach is the shift less the displacement of the
        # cup
        carrying = loads > 0
        soft = give[np.ix_(carrying, carrying)] + np.diag(
            loads[carrying] ** (1 / exponent - 1) * stiffness ** (-1 / exponent) / exponent
        )
        excess = give[np.ix_(carrying, carrying)] @ loads[carrying] + (
            loads[carrying] / stiffness
        ) ** (1 / exponent)
        count = int(carrying.sum())
        matrix = np.zeros((count + 1, count + 1))
        matrix[:-1, :-1], matrix[:-1, -1], matrix[-1, :-1] = (
            soft,
            -cosine[carrying],
            cosine[carrying],
        )
        scale = np.append(np.full(count, 1 / force), 1 / shift)
        step = (
            np.linalg.solve(
                matrix / scale,
                np.append(
                    -(excess - shift * cosine[carrying]), force - cosine[carrying] @ loads[carrying]
                ),
            )
            / scale
        )
        new = np.zeros_like(loads)
        new[carrying] = loads[carrying] + step[:-1]
        shift = max(shift + float(step[-1]), 1e-3 * shift)
        gap = shift * cosine - give @ np.maximum(new, 0.0)
        new[~carrying & (gap > 0)] = 1e-6 * force
        done = float(np.abs(new - loads).max()) <= _CONVERGED * force
        loads = np.maximum(new, 0.0)
        if done:
            return shift, float(loads.max())
    raise DidNotConvergeError("no equilibrium of the rollers in this cup was found")


def _radial_flexibility(
    bore: Annulus, thickness: float, angles: Floats, material: tuple[float, float]
) -> Floats:
    """Return the radial displacements (m/N) of the cup at each roller under a unit force of another
    one: (roller, roller).
    """
    harmonics = _HARMONICS * len(angles)
    each = edge_compliance(bore, harmonics)
    radial = each.sum(axis=(1, 2)) / 2
    radial[0] = each[0, 0, 0]
    n = np.arange(harmonics + 1)
    young, nu = material
    if math.isinf(thickness):
        soft = np.where(n == 1, radial, 0.0)
    else:
        bending = young / (1 - nu**2) * thickness**3 / 12 * (n**2 - 1.0) ** 2 / bore.loaded**4
        bending[0] = young / (1 - nu**2) * thickness / bore.loaded**2  # the hoop
        soft = 1 / (1 / radial + bending)
    weights = np.where(n == 0, 0.5, 1.0) / (math.pi * bore.loaded * bore.width)
    return np.asarray(np.cos((angles[:, None] - angles)[..., None] * n) @ (weights * soft))
