"""Plane disc with a central bore and a circle of round holes, by series of Kolosov's two functions
with conditions on its edges.

Source: N. Muskhelishvili, Some Basic Problems of the Mathematical Theory of Elasticity, 1953,
sections 35 to 41 (multiply connected bodies).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

if TYPE_CHECKING:
    import numpy.typing as npt

    from lostmotion.laws.annulus import Annulus
    from lostmotion.spatial import Floats

    Complexes = npt.NDArray[np.complex128]

Bore = Literal["fixed", "sliding", "free"]
# Points of an edge per term.
_POINTS: Final = 3
# Added to the diagonal of the normal equations per unknown, with columns of unit length.
_RIDGE: Final = 1e-15


@dataclass(frozen=True, slots=True)
class Holes:
    """`count` holes of a `radius` on a `circle` (m), the first one at the angle 0.

    bearings  of crankshafts in the holes, which take torque and force; otherwise output pins, which
              take the torque
    """

    count: int
    circle: float
    radius: float
    bearings: bool = False

    @property
    def places(self) -> Complexes:
        """Return the directions of the centres (hole,) from that of the disc, as complex numbers of
        size one.
        """
        return np.asarray(np.exp(2j * math.pi * np.arange(self.count) / self.count))


@dataclass(frozen=True, slots=True)
class DiscEdge:
    """A circular edge, lengths in units of the rim's radius: its points, the outward normals of the
    disc there, and the number of terms about it.
    """

    centre: complex
    radius: float
    points: Complexes
    normals: Complexes
    terms: int


def edges_of(
    disc: Annulus, holes: Holes | None, terms: int, of_bore: int, rim_terms: int
) -> list[DiscEdge]:
    """Return the edges: rim, holes, bore."""

    def edge(centre: complex, radius: float, terms: int, side: float) -> DiscEdge:
        unit = np.exp(2j * math.pi * np.arange(_POINTS * terms) / (_POINTS * terms))
        return DiscEdge(centre, radius, centre + radius * unit, side * unit, terms)

    out = [edge(0j, 1.0, rim_terms, 1.0)]
    if holes is not None:
        out += [
            edge(complex(each), holes.radius / disc.loaded, terms, -1.0)
            for each in holes.circle / disc.loaded * holes.places
        ]
    return [*out, edge(0j, disc.fixed / disc.loaded, of_bore, -1.0)]


def edge_conditions(
    disc: Annulus, edges: list[DiscEdge], loads: Complexes, bore: Bore
) -> tuple[Complexes, Floats, Floats]:
    """Return the displacement (point, unknown), m, of every unknown, and the boundary conditions
    under tractions (load, point), Pa.

    The conditions are a matrix (condition, unknown) and what is wanted (condition, load).
    Displacements at the bore are not used.
    """
    points, normals = (
        np.concatenate([getattr(edge, name) for edge in edges]) for name in ("points", "normals")
    )
    moved, pulled = _columns(disc.kolosov, points, normals, edges)
    on_bore = len(points) - len(edges[-1].points)
    rows = [pulled[:on_bore].real, pulled[:on_bore].imag]
    inward = normals[on_bore:, None].conj()
    if bore == "fixed":
        rows += [moved[on_bore:].real, moved[on_bore:].imag]
    elif bore == "sliding":
        # the torques balance, so that the mean rotation can be chosen; without a choice rounding
        # would make one
        turned = (moved[on_bore:] * inward).imag
        rows += [
            (moved[on_bore:] * inward).real,
            (pulled[on_bore:] * inward).imag,
            turned.sum(axis=0)[None],
        ]
    else:
        # without traction; the loads balance, so that the mean displacement and rotation can be
        # chosen
        turned = (moved[on_bore:] * inward).imag
        rows += [
            pulled[on_bore:].real,
            pulled[on_bore:].imag,
            *(each.sum(axis=0)[None] for each in (moved.real, moved.imag, turned)),
        ]
    matrix = np.concatenate(rows)
    wanted = np.concatenate(
        [
            loads[:, :on_bore].real,
            loads[:, :on_bore].imag,
            np.zeros((len(loads), len(matrix) - 2 * on_bore)),
        ],
        axis=1,
    ).T
    size = np.sqrt((matrix**2).sum(axis=0))
    shear = disc.young / (2 + 2 * disc.nu)
    return moved / size * (disc.loaded / (2 * shear)), matrix / size, wanted


def least_squares(matrix: Floats, wanted: Floats) -> Floats:
    """Return the least-squares solution by the normal equations, with a ridge just above rounding;
    some terms are nearly dependent.
    """
    from scipy.linalg import cho_factor, cho_solve

    square = matrix.T @ matrix
    square[np.diag_indices_from(square)] += _RIDGE * len(square)
    return np.asarray(
        cho_solve(
            cho_factor(square, overwrite_a=True, check_finite=False),
            matrix.T @ wanted,
            check_finite=False,
        )
    )


def _columns(
    k: float, z: Complexes, normal: Complexes, edges: list[DiscEdge]
) -> tuple[Complexes, Complexes]:
    """Return displacement, in units of 1/(2 G), and traction of every term at points z: (point,
    term), two real terms per complex coefficient.
    """
    z, normal = z[:, None], normal[:, None]
    direct: list[tuple[Complexes, Complexes]] = []  # displacement and traction per coefficient
    conjugate: list[tuple[Complexes, Complexes]] = []  # and per its conjugate

    def potentials(g: Complexes, g1: Complexes, g2: Complexes) -> None:
        none = np.zeros_like(g)
        direct.extend([(k * g, normal * g1), (none, none)])
        conjugate.append((-z * g1.conj(), normal * g1.conj() - normal.conj() * z * g2.conj()))
        conjugate.append((-g.conj(), -normal.conj() * g1.conj()))

    # powers are slow: each is computed once, and the later ones serve the derivatives too
    n = np.arange(1, edges[0].terms + 2)
    powers = z ** np.arange(edges[0].terms + 2)
    # the constant moves the disc as a whole
    direct.append((np.ones_like(z), np.zeros_like(z)))
    conjugate.append((np.zeros_like(z), np.zeros_like(z)))
    potentials(powers[:, n], n * powers[:, n - 1], n * (n - 1) * powers[:, np.maximum(n - 2, 0)])
    for edge in edges[1:]:
        n, away = np.arange(1, edge.terms + 1), z - edge.centre
        powers = (edge.radius / away) ** np.arange(1, edge.terms + 3)
        potentials(
            powers[:, :-2],
            -n / edge.radius * powers[:, 1:-1],
            n * (n + 1) / edge.radius**2 * powers[:, 2:],
        )
        # logarithms for the resultant force; their angles cancel in the displacement
        one = 1 / away.conj()
        direct.append(
            (
                -2 * k * np.log(np.abs(away)).astype(np.complex128),
                -normal / away - normal.conj() * k * one,
            )
        )
        conjugate.append((z * one, -normal * one - normal.conj() * z * one**2))
    (u, t), (v, s) = (
        [np.concatenate([each[j] for each in some], axis=1) for j in range(2)]
        for some in (direct, conjugate)
    )
    return np.concatenate([u + v, 1j * (u - v)], axis=1), np.concatenate(
        [t + s, 1j * (t - s)], axis=1
    )
