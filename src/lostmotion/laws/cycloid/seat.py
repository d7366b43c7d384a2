"""Compliance of a seat: a rigid ring or pin in the bore of an elastic plane body, shifted sideways
by a force.

The body is an annulus around the bore, fixed at an outer radius. Three fits bracket every real one:
bonded (glued, moulded in, shrunk on with high friction), pressed (in contact all round, sliding
along the bore) and snug (no preload: the contact behind the pin opens). From an outer radius of
five bore radii on, the fits differ by a local term that does not depend on the body: pressed -
bonded 0.10, snug - bonded 0.46 to 0.53 over E b.

Where the body is part of another model whose bore is bonded and rigid, only the difference to the
bonded fit may be added.

Source: bonded after J. Adkins, A. Gent, Brit. J. Appl. Phys. 5 (1954) 354, here for any Poisson's
ratio; receding contact L. Keer, J. Dundurs, K. Kiattikomol, Int. J. Eng. Sci. 11 (1973) 1221;
contact with clearance A. Persson, dissertation, Chalmers 1964.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.annulus import Annulus, edge_compliance

if TYPE_CHECKING:
    from lostmotion.laws.annulus import Plane
    from lostmotion.spatial import Floats

Fit = Literal["bonded", "pressed", "snug"]

# Points around half of the bore, and harmonics of the pressure. The snug fit is accurate to 0.1 %.
_POINTS: Final = 600
# Fewest points that resolve a pressure.
_FEWEST: Final = 4
# Outer radius over bore radius from which on the fits differ by constants.
LARGE: Final = 5.0


@functools.lru_cache(maxsize=256)
def seat_compliance(bore: Annulus, fit: Fit) -> float:
    """Return the shift of a rigid pin per force (m/N) in the bore of this annulus, loaded at the
    bore and fixed at its outer radius.

    A snug seat is linear in the load as well, because its contact has the same extent under any
    load (a receding contact).
    """
    if fit == "bonded":
        return bonded_compliance(bore)
    if fit == "pressed":
        return float(edge_compliance(bore, 1)[1].sum() / (2 * math.pi * bore.loaded * bore.width))
    shift, _ = pin_in_bore(bore, 1.0, 0.0)
    return shift


def bonded_compliance(bore: Annulus) -> float:
    """Return the shift per force (m/N) of a rigid pin bonded into the bore: [2 k ln(c/a) - (2/k)
    (c^2 - a^2)/(c^2 + a^2)]/[4 pi G (1 + k) b].

    k is Kolosov's constant, G the shear modulus, a and c the radii of the bore and of the fixed
    edge, b the width. Exact.
    """
    k, shear = bore.kolosov, bore.young / (2 + 2 * bore.nu)
    a2, c2 = bore.loaded**2, bore.fixed**2
    return (k * math.log(c2 / a2) - 2 / k * (c2 - a2) / (c2 + a2)) / (
        4 * math.pi * shear * (1 + k) * bore.width
    )


def compliance_beyond(
    bore_radius: float, width: float, young: float, nu: float, fit: Fit, included: Fit
) -> float:
    """Return the shift per force (m/N) of a ring in the bore of a large body, beyond that of the
    fit that the body's own model includes.

    The difference is local: 0.10/(E b) from bonded to pressed, about 0.36/(E b) from pressed to
    snug. Negative for a stiffer fit. Plane strain; sizes in m, Young's modulus in Pa.
    """
    body = Annulus(bore_radius, LARGE * bore_radius, width, young, nu)
    return seat_compliance(body, fit) - seat_compliance(body, included)


def tilt_stiffness_per_length(bore: Annulus) -> float:
    """Return the tilting stiffness (N m/rad per m of depth) of a pin whose sides adhere to the
    bore: pi G a^2 (c^2 + a^2)/(c^2 - a^2).

    The sides shear the body along the pin (antiplane shear of an annulus, exact). Without adhesion
    it is zero. The width of the annulus is not used.
    """
    a2, c2 = bore.loaded**2, bore.fixed**2
    return math.pi * bore.young / (2 + 2 * bore.nu) * a2 * (c2 + a2) / (c2 - a2)


def pin_in_bore(bore: Annulus, force: float, clearance: float) -> tuple[float, float]:
    """Return the shift (m) of a rigid pin beyond its first contact with a wider bore, and half the
    angle of their contact (rad).

    bore       loaded at its inner radius, fixed outside
    force      N, above zero
    clearance  radial: radius of the bore minus that of the pin, m; zero for a snug pin

    The contact is unilateral and without friction. It begins as Hertz's and ends as that of a snug
    pin. Raises ValueError for a force that is not positive or a negative clearance,
    DidNotConvergeError where no contact is found, and for a contact narrower than four points (0.6
    degrees).
    """
    if not (force > 0 and clearance >= 0):
        raise ValueError("a pin in a bore needs a force above zero and a clearance of zero or more")
    solved = _contact_of_pin(bore.fixed / bore.loaded, bore.nu, bore.plane)
    stiff = bore.young * bore.width
    if not clearance:
        return force / stiff * solved.snug, math.pi * solved.points / _POINTS
    load = force / (stiff * clearance)
    if load < solved.force[_FEWEST - 1]:
        raise DidNotConvergeError("the contact of the pin in its bore is too narrow for this model")
    if load >= solved.force[-1]:
        # all points of the snug pin's contact are loaded: from here on linear
        shift = solved.shift[-1] + (load - solved.force[-1]) * solved.snug
    else:
        shift = float(np.interp(load, solved.force, solved.shift))
    return clearance * shift, math.pi * int(np.searchsorted(solved.force, load)) / _POINTS


@dataclass(frozen=True, slots=True)
class _Contact:
    """Contact of a rigid pin in a bore of unit radius, width and modulus.

    force, shift  (point,) with unit clearance, as the pressure of one more point begins: between
                  them the contact is linear
    snug          shift per force without clearance, with `points` in contact
    """

    force: Floats
    shift: Floats
    snug: float
    points: int


@functools.lru_cache(maxsize=64)
def _contact_of_pin(ratio: float, nu: float, plane: Plane) -> _Contact:
    """Return the contact of a pin in a bore by the ratio of its outer radius to that of the bore,
    for all loads.

    Where n points are in contact, their pressures are s x - g y with K x = cos, K y = 1 - cos, for
    the shift s and the clearance g. One Cholesky decomposition K = L L' serves every n, because
    that of a leading block is the leading block of L. With z = L^-1 cos and v = L^-1 (1 - cos) the
    last pressure begins at s/g = v_n/z_n, and the force is proportional to s sum(z^2) - g sum(z v).
    A snug pin has contact as long as z_n > 0.
    """
    from scipy.linalg import solve_triangular

    cosine, kernel = _radial_kernel(Annulus(1.0, ratio, 1.0, 1.0, nu, plane))
    front = int(np.count_nonzero(cosine > 0))
    lower = np.linalg.cholesky(kernel[:front, :front])
    both = solve_triangular(
        lower, np.stack([cosine[:front], 1 - cosine[:front]], axis=1), lower=True
    )
    z, v = both[:, 0], both[:, 1]
    points = int(np.argmax(z <= 0)) if (z <= 0).any() else front
    z, v = z[:points], v[:points]
    weight = 2 * math.pi / _POINTS
    shift = v / z
    force = weight * (shift * np.cumsum(z**2) - np.cumsum(z * v))
    return _Contact(force, shift, 1 / (weight * float(z @ z)), points)


def cosine_pressure_compliance(bore: Annulus) -> float:
    """Return the displacement per force (m/N) of half of a bore under a cosine pressure on it: the
    mean weighted by the pressure, along the force.
    """
    cosine, kernel = _radial_kernel(
        Annulus(1.0, bore.fixed / bore.loaded, 1.0, 1.0, bore.nu, bore.plane)
    )
    pressure = np.maximum(cosine, 0.0)
    area = 2 * math.pi / _POINTS
    return (
        float(pressure @ kernel @ pressure)
        * area
        / float(area * pressure @ cosine) ** 2
        / (bore.young * bore.width)
    )


@functools.lru_cache(maxsize=32)
def _radial_kernel(bore: Annulus) -> tuple[Floats, Floats]:
    """Return the cosines (point,) of the angles around half of the bore, and the radial
    displacements (m) per pressure (Pa) between the points.
    """
    each = edge_compliance(bore, _POINTS - 1)
    radial = each.sum(axis=(1, 2)) / 2
    radial[0] = each[0, 0, 0] / 2
    angle, modes = _modes()
    return np.cos(angle), (modes * (2 / _POINTS * radial)) @ modes.T


@functools.cache
def _modes() -> tuple[Floats, Floats]:
    """Return the angles (point,), rad, around half of the bore and the cosines (point, harmonic) of
    their multiples.
    """
    angle = (np.arange(_POINTS) + 0.5) * math.pi / _POINTS
    return angle, np.cos(angle[:, None] * np.arange(_POINTS))
