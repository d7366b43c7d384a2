"""Deformation of an elastic ring or disc: a plane annulus, fixed along one edge and loaded by
distributed forces on the other.

The traction on the edge is expanded in a Fourier series. Each harmonic has an exact solution in
powers of the radius, from Kolosov's two functions of z = r exp(i theta): 2 G (u_x + i u_y) = k phi
- z conj(phi') - conj(psi), with k = 3 - 4 nu in plane strain and (3 - nu)/(1 + nu) in plane stress.
Torsion (n = 0) and the translation of the whole edge under a resultant (n = 1, with its logarithm)
are included. Small displacements, linear material.

Source: N. Muskhelishvili, Some Basic Problems of the Mathematical Theory of Elasticity, 1953
(functions and single-valued displacements); J. Michell, Proc. London Math. Soc. 31 (1899) 100 (the
same solution as a stress function). Load distribution at a square corner: M. Williams, J. Appl.
Mech. 19 (1952) 526.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, get_args

import numpy as np

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

Plane = Literal["strain", "stress"]

ELLIPTIC: Final = 0.5  # Hertz's pressure: the traction falls as (1 - x^2)^0.5 over the arc
# At a square inner corner the stress is singular: it grows as distance^(s - 1), with sin(3 pi s/2)
# = s (Williams).
CORNERED: Final = 0.5444837368 - 1

# Number of harmonics times half arc (rad). With the mean of the remaining ones the sums are
# accurate to 3e-4 of the largest displacement (half-ellipse: 3e-6).
_PER_ARC: Final = 20


@dataclass(frozen=True, slots=True)
class Annulus:
    """An elastic annulus.

    loaded, fixed  radii of the loaded and of the fixed edge, m; either may be the outer one
    width          along the axis, m
    young, nu      Young's modulus, Pa, and Poisson's ratio
    plane          "strain" for bodies much wider than the loaded arc, "stress" for thin ones; real
                   discs are between the two

    Raises ValueError for impossible values.
    """

    loaded: float
    fixed: float
    width: float
    young: float
    nu: float
    plane: Plane = "strain"

    def __post_init__(self) -> None:
        """Refuse impossible values, all at once."""
        named = (
            ("loaded radius", self.loaded),
            ("fixed radius", self.fixed),
            ("width", self.width),
            ("Young's modulus", self.young),
        )
        wrong = [
            f"its {name} is {value!r}, but must be positive and finite"
            for name, value in named
            if not (math.isfinite(value) and value > 0)
        ]
        if self.loaded == self.fixed:
            wrong.append("its two radii are the same")
        if not -1 < self.nu <= 0.5:  # noqa: PLR2004 - incompressible
            wrong.append(f"its Poisson's ratio is {self.nu!r}, but must be within -1..0.5")
        if self.plane not in get_args(Plane):
            wrong.append(f"its plane is {self.plane!r}, but must be 'strain' or 'stress'")
        if wrong:
            raise ValueError("this annulus cannot exist: " + "; ".join(wrong))

    @property
    def kolosov(self) -> float:
        """Return Kolosov's constant k: 3 - 4 nu in plane strain, (3 - nu)/(1 + nu) in plane
        stress.
        """
        return 3 - 4 * self.nu if self.plane == "strain" else (3 - self.nu) / (1 + self.nu)

    @property
    def plane_modulus(self) -> float:
        """Return the effective modulus (Pa) of a half-plane: E/(1 - nu^2) in plane strain, E in
        plane stress.
        """
        return self.young / (1 - self.nu**2) if self.plane == "strain" else self.young

    @property
    def plane_nu(self) -> float:
        """Return the effective Poisson's ratio of the plane problem: nu/(1 - nu) in plane strain,
        nu in plane stress.
        """
        return self.nu / (1 - self.nu) if self.plane == "strain" else self.nu


def edge_compliance(annulus: Annulus, harmonics: int) -> Floats:
    """Return the displacement of the loaded edge per traction (m/Pa) for harmonics 0 to n:
    symmetric matrices (harmonics + 1, 2, 2).

    The traction is q = q_r + i q_t = sum of q_n exp(i n theta), radial outwards and tangential
    towards larger angles; the displacement u has the same form. The matrix S_n is that of (u_n,
    conj u_-n) = S_n (q_n, conj q_-n) for n >= 1. S_0 is diagonal: uniform radial traction, and
    torsion.
    """
    ratio, k = annulus.fixed / annulus.loaded, annulus.kolosov
    side = 1.0 if ratio < 1 else -1.0  # direction of the loaded edge's outward normal
    out = np.zeros((harmonics + 1, 2, 2))
    # n = 0: u = x r + y/r, zero at the fixed edge; torsion: t/r^2 is the only stress
    x, y = np.linalg.solve([[(k - 1) * ratio, -1 / ratio], [2 * side, side]], [0.0, 1.0])
    out[0] = np.diag([(k - 1) * x - y, side * (ratio**-2 - 1)])
    load = np.array([[0.0, 0.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    if harmonics > 0:
        rows = np.concatenate(
            [
                _first_displacement(k, ratio),
                side * np.array([[2.0, 2.0, 2.0, 0.0], [0.0, 1 + k, 0.0, 0.0]]),
            ]
        )
        out[1] = _first_displacement(k, 1.0) @ np.linalg.solve(rows, load)
    n = np.arange(2.0, harmonics + 1)
    displaced, pulled = _harmonics(k, n, 1.0, ratio)
    rows = np.concatenate([_harmonics(k, n, ratio, ratio)[0], side * pulled], axis=1)
    out[2:] = displaced @ np.linalg.solve(rows, np.broadcast_to(load, (len(n), 4, 2)))
    shear = annulus.young / (2 + 2 * annulus.nu)
    return np.asarray(out * annulus.loaded / (2 * shear))


def _first_displacement(k: float, r: float) -> Floats:
    """Return 2 G (u_1, conj u_-1) at the radius r for the terms z^2 and ln z of phi, z^-2 and 1 of
    psi.
    """
    return np.array(
        [[k * r * r, -1.0, -1 / r**2, 0.0], [-2 * r * r, 2 * k * math.log(r), 0.0, -1.0]]
    )


def _harmonics(k: float, n: Floats, r: float, ratio: float) -> tuple[Floats, Floats]:
    """Return 2 G (u_n, conj u_-n) and the tractions of the terms z^(n+1), z^(1-n) of phi and
    z^(-n-1), z^(n-1) of psi, both (n, 2, 4).

    Each power is normalised to 1 at the edge (radius 1 or `ratio`) where it is largest, so that
    none overflows.
    """
    powers = np.stack([n + 1, 1 - n, -n - 1, n - 1])
    a, b, c, d = np.exp(powers * math.log(r) - np.maximum(0.0, powers * math.log(ratio)))
    none = np.zeros_like(n)
    displaced = np.array([[k * a, (n - 1) * b, -c, none], [-(n + 1) * a, k * b, none, -d]])
    pulled = (
        np.array(
            [
                [(n + 1) * a, (1 - n * n) * b, (n + 1) * c, none],
                [(1 - n * n) * a, (1 - n) * b, none, (1 - n) * d],
            ]
        )
        / r
    )
    return np.moveaxis(displaced, -1, 0), np.moveaxis(pulled, -1, 0)


def spectrum(phase: Floats, exponent: float) -> Floats:
    """Return the normalised Fourier transform of a load (1 - x^2)^exponent over an arc: of harmonic
    n at the phase n x half arc (rad, any shape).

    It is 1 at phase 0. The exponent must be above -0.75, where the displacement of the edge is
    still finite: 0.5 is Hertz's half-ellipse, 0 uniform.
    """
    from scipy.special import gamma, jv

    order = exponent + 0.5
    safe = np.where(phase > 0, phase, 1.0)
    return np.asarray(
        np.where(phase > 0, gamma(order + 1) * (2 / safe) ** order * jv(order, safe), 1.0)
    )


def flexibility(
    annulus: Annulus,
    angles: Floats,
    slants: Floats,
    half_arcs: Floats | float,
    exponent: float = ELLIPTIC,
    harmonics: int | None = None,
) -> Floats:
    """Return the displacements (m/N) of the edge along force i under a unit force j: (k, k),
    symmetric.

    angles     (k,) positions of the forces around the edge, rad
    slants     (k,) inclination of each force from the outward radius, towards larger angles, rad
    half_arcs  (k,), or one for all forces: each is distributed over angle +- half arc, rad, with
               the same inclination to the local radius
    exponent   of the distribution (1 - x^2)^exponent over the arc; above -0.75
    harmonics  number of harmonics in the sums; by default enough for 3e-4 of the largest
               displacement

    Displacements are means over the arc, weighted by the load. So the matrix A is symmetric
    (reciprocity) and F' A F is twice the strain energy. The resultant of a wide inclined arc is
    smaller than F by the `spectrum` of the first harmonic; the moment is exact. Raises ValueError
    for angles and slants of different shapes, arcs of zero width and exponents out of range.
    """
    from scipy.special import gamma

    angles, slants = (
        np.atleast_1d(np.asarray(angles, dtype=float)),
        np.atleast_1d(np.asarray(slants, dtype=float)),
    )
    if angles.ndim != 1 or angles.shape != slants.shape:
        raise ValueError(
            f"each force needs its angle and its slant, not angles of shape {angles.shape} and "
            f"slants of shape {slants.shape}"
        )
    half = np.atleast_1d(np.asarray(half_arcs, dtype=float))
    if not ((half > 0).all() and exponent > -0.75):  # noqa: PLR2004 - the energy of more concentrated loads is infinite
        raise ValueError(
            "the arcs must be wider than zero, and the exponent of the load's shape above -0.75"
        )
    top = max(8, math.ceil(_PER_ARC / float(half.min()))) if harmonics is None else harmonics
    own = edge_compliance(annulus, top)
    n = np.arange(1, top + 1)
    modes = np.exp(1j * angles[:, None] * n) * spectrum(half[:, None] * n, exponent)
    direct, counter, coupling = own[1:, 0, 0], own[1:, 1, 1], own[1:, 0, 1]
    same = (modes * direct) @ modes.conj().T + ((modes * counter) @ modes.conj().T).conj()
    mirrored = 2 * ((modes * coupling) @ modes.conj().T).real
    # Beyond the last harmonic the compliance falls as 1/n and the mean square of the spectrum as
    # n^-(2 exponent + 2).
    left = (
        gamma(exponent + 1.5) ** 2
        * (2 / half) ** (2 * exponent + 1)
        / (math.pi * half)
        * top ** (-2 * exponent - 2)
        / (2 * exponent + 2)
        * top
    )
    left = np.broadcast_to(left, angles.shape)
    same = same + np.diag(left * (direct[-1] + counter[-1]))
    mirrored = mirrored + np.diag(left * 2 * coupling[-1])
    force = np.exp(1j * slants)
    moved = (same + own[0, 0, 0] / 2 + own[0, 1, 1] / 2) * force + (
        mirrored + own[0, 0, 0] / 2 - own[0, 1, 1] / 2
    ) * force.conj()
    together = (force.conj()[:, None] * moved).real / (2 * math.pi * annulus.loaded * annulus.width)
    return np.asarray((together + together.T) / 2)
