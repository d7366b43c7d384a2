"""A straight stepped beam on springs: displacements at its loads, and which part of the beam or of
its supports they come from.

Timoshenko beam in one plane. Supports are springs at a place (bearings), or distributed along a
length (a pin in its seat). Elements are exact for loads and supports at their ends; under
distributed loads and seats they are refined until the error is below 1e-5.

Source: J. Przemieniecki, Theory of Matrix Structural Analysis, 1968, ch. 5 (element with shear); M.
Hetenyi, Beams on Elastic Foundation, 1946 (distributed supports).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.spatial import Floats

# Elements per interval under a seat or a distributed load, and of a sandwich, whose compliance is
# then accurate to 3e-4.
_ELEMENTS: Final = 24
# Share of a beam's length within which two places are one: the element between them would lose more
# digits to rounding (4e-5 at a share of 1e-8, all of them at 1e-13) than the distance is worth.
_SAME_PLACE: Final = 1e-6
_GAUSS: Final = np.polynomial.legendre.leggauss(4)
# Condition number, with a diagonal of ones, above which a beam counts as free to move.
_SINGULAR: Final = 1e14
_NOT_HELD: Final = "the supports do not hold this beam"
_DIRECTIONS: Final = 2  # a beam in a plane can shift and tilt


@dataclass(frozen=True, slots=True)
class BeamPiece:
    """A prismatic piece of the beam from `start` to `end` (m): `bending` stiffness EI (N m^2) and
    `shear` stiffness k G A (N).

    second  EI and k G A of a second beam, which shares the deflection of the first one but not its
            rotation, as the faces of a sandwich do; for all pieces of a beam or for none
    """

    start: float
    end: float
    bending: float
    shear: float
    second: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class Support:
    """A spring at a place (m): lateral `stiffness` (N/m) and `tilt` stiffness (N m/rad). Infinite
    means rigid, zero means free.
    """

    at: float
    stiffness: float = math.inf
    tilt: float = 0.0


@dataclass(frozen=True, slots=True)
class Foundation:
    """Springs spread from `start` to `end` (m): lateral `stiffness` (N/m per m) and `tilt`
    stiffness (N m/rad per m).

    floating  the body that holds these springs moves sideways freely, without tilting
    """

    start: float
    end: float
    stiffness: float
    tilt: float = 0.0
    floating: bool = False


@dataclass(frozen=True, slots=True)
class SupportedBeam:
    """A beam of consecutive pieces on supports and foundations. Raises ValueError for gaps between
    pieces and places beyond its ends.
    """

    pieces: tuple[BeamPiece, ...]
    supports: tuple[Support, ...] = ()
    foundations: tuple[Foundation, ...] = ()

    def __post_init__(self) -> None:
        """Refuse beams with gaps, without stiffness, or supported beyond their ends."""
        wrong = [
            f"the piece from {one.start:g} to {one.end:g} m has no length"
            for one in self.pieces
            if not one.end > one.start
        ]
        wrong += [
            "its pieces are not consecutive"
            for one, two in zip(self.pieces, self.pieces[1:], strict=False)
            if one.end != two.start
        ]
        wrong += [
            "a piece has no stiffness"
            for one in self.pieces
            if not min(one.bending, one.shear, *(one.second or ())) > 0
        ]
        if len({one.second is None for one in self.pieces}) > 1:
            wrong.append("only some of its pieces are sandwiches")
        places = [each.at for each in self.supports] + [
            end for each in self.foundations for end in (each.start, each.end)
        ]
        start, end = self.pieces[0].start, self.pieces[-1].end
        wrong += [
            f"the support at {place:g} m is beyond its ends at {start:g} and {end:g} m"
            for place in places
            if not start <= place <= end
        ]
        if wrong:
            raise ValueError("this beam cannot exist: " + "; ".join(wrong))


@dataclass(frozen=True, slots=True)
class BeamResponse:
    """Response of a beam to unit forces at its loads.

    by_part    (part, load, load) contribution of each part to the flexibility, m/N: pieces, then
               supports, then foundations
    reactions  (support, load) force of each support on the beam per force at a load, negative where
               it opposes the force
    """

    by_part: Floats
    reactions: Floats

    @property
    def flexibility(self) -> Floats:
        """Return the displacements (m) at load i, averaged over it, under a unit force (N) at load
        j: (load, load), symmetric.
        """
        return np.asarray(self.by_part.sum(axis=0))


def respond(beam: SupportedBeam, loads: Sequence[tuple[float, float]]) -> BeamResponse:
    """Return the response to unit forces, each distributed uniformly from one place to another (m);
    equal places are a point load.

    The contributions follow from the energy in each part, so they are all zero or more on the
    diagonal. Places closer than a millionth of the beam's length count as one. Raises ValueError
    for a load beyond the ends of the beam, for a piece or foundation shorter than that, and for a
    beam that its supports do not hold.
    """
    start, end = beam.pieces[0].start, beam.pieces[-1].end
    if not all(start <= low <= high <= end for low, high in loads):
        raise ValueError(f"a load lies beyond the ends of the beam at {start:g} and {end:g} m")
    beam, loads = _apart(beam, loads)
    at = _nodes(beam, loads)
    sandwich = beam.pieces[0].second is not None
    dofs = (_DIRECTIONS + sandwich) * len(at)  # rotations of the second beam come last
    node = {place: k for k, place in enumerate(at.tolist())}
    of_piece = np.searchsorted([piece.end for piece in beam.pieces], at[1:])
    bending, shearing = np.array([(piece.bending, piece.shear) for piece in beam.pieces])[
        of_piece
    ].T
    matrices, shears = _stiffness(bending, shearing, np.diff(at))
    elements = [np.flatnonzero(of_piece == piece) for piece in range(len(beam.pieces))]
    parts = [[_Springs(_places(own), matrices[own])] for own in elements]
    if sandwich:
        parts = [
            [*part, _of_second(piece, at, own)]
            for part, piece, own in zip(parts, beam.pieces, elements, strict=True)
        ]
    held = np.zeros(dofs, dtype=bool)
    for support in beam.supports:
        ways = _DIRECTIONS * node[support.at] + np.arange(_DIRECTIONS)
        stiffness = np.array([support.stiffness, support.tilt])
        held[ways] |= np.isinf(stiffness)
        if sandwich:
            held[_DIRECTIONS * len(at) + node[support.at]] = math.isinf(support.tilt)
        parts.append(
            [_Springs(ways[:, None], np.where(np.isinf(stiffness), 0.0, stiffness)[:, None, None])]
        )
    parts += [_foundation(each, at, shears) for each in beam.foundations]
    forces = np.stack([_load(low, high, at, shears, dofs) for low, high in loads], axis=-1)
    whole, free = _assembled(dofs, [springs for part in parts for springs in part]), ~held
    moved = np.zeros_like(forces)
    moved[free] = _solved(whole[np.ix_(free, free)], forces[free])
    reactions = np.zeros((len(beam.supports), len(loads)))
    for reaction, support in zip(reactions, beam.supports, strict=True):
        one = _DIRECTIONS * node[support.at]
        reaction[:] = (
            whole[one] @ moved - forces[one]
            if math.isinf(support.stiffness)
            else -support.stiffness * moved[one]
        )
    return BeamResponse(
        np.stack([np.sum([springs.energy(moved) for springs in part], axis=0) for part in parts]),
        reactions,
    )


@dataclass(frozen=True, slots=True)
class _Springs:
    """Elements with a stiffness matrix each: the degrees of freedom that they join, (element, k),
    and the matrices (element, k, k).
    """

    places: np.ndarray
    matrices: Floats

    def energy(self, moved: Floats) -> Floats:
        """Return twice the energy (load, load) under displacements (dof, load)."""
        own = moved[self.places]
        return np.asarray(np.tensordot(own, self.matrices @ own, axes=((0, 1), (0, 1))))


def _assembled(dofs: int, parts: Sequence[_Springs]) -> Floats:
    """Return the stiffness matrix of all elements on all degrees of freedom."""
    at = np.concatenate(
        [(dofs * each.places[:, :, None] + each.places[:, None, :]).ravel() for each in parts]
    )
    entries = np.concatenate([each.matrices.ravel() for each in parts])
    return np.asarray(np.bincount(at, entries, minlength=dofs**2), dtype=float).reshape(dofs, dofs)


def _solved(matrix: Floats, forces: Floats) -> Floats:
    """Return the displacements (dof, load) under forces (dof, load). Raises ValueError where the
    supports do not hold the beam.

    Sparse, because threads of dense algebra take longer on matrices of this size than the work
    itself.
    """
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import splu

    scale = 1 / np.sqrt(np.diag(matrix))
    try:
        factors = splu(
            csc_array(matrix * scale * scale[:, None]),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError:  # a pivot is exactly zero
        raise ValueError(_NOT_HELD) from None
    pivots = np.abs(factors.U.diagonal())
    if pivots.min() * _SINGULAR < pivots.max():
        raise ValueError(_NOT_HELD)
    return np.asarray(scale[:, None] * factors.solve(scale[:, None] * forces))


def _apart(
    beam: SupportedBeam, loads: Sequence[tuple[float, float]]
) -> tuple[SupportedBeam, Sequence[tuple[float, float]]]:
    """Return beam and loads with places that lie closer together than `_SAME_PLACE` moved to the
    first of them. Raises ValueError for a piece or a foundation as short as that.
    """
    places = _breaks(beam, loads)
    first = np.diff(places, prepend=-math.inf) > _SAME_PLACE * (places[-1] - places[0])
    if first.all():
        return beam, loads
    to = dict(zip(places.tolist(), places[first][np.cumsum(first) - 1].tolist(), strict=True))
    spans: tuple[BeamPiece | Foundation, ...] = (*beam.pieces, *beam.foundations)
    lost = [f"{one.start:g} to {one.end:g} m" for one in spans if to[one.start] == to[one.end]]
    if lost:
        raise ValueError(
            f"what reaches from {', '.join(lost)} is shorter than a millionth of the beam"
        )
    moved = SupportedBeam(
        tuple(replace(each, start=to[each.start], end=to[each.end]) for each in beam.pieces),
        tuple(replace(each, at=to[each.at]) for each in beam.supports),
        tuple(replace(each, start=to[each.start], end=to[each.end]) for each in beam.foundations),
    )
    return moved, [(to[low], to[high]) for low, high in loads]


def _breaks(beam: SupportedBeam, loads: Sequence[tuple[float, float]]) -> Floats:
    """Return all places (m) of a beam and its loads in order, each once."""
    spans: tuple[BeamPiece | Foundation, ...] = (*beam.pieces, *beam.foundations)
    ends = [end for each in spans for end in (each.start, each.end)]
    return np.unique([*ends, *(each.at for each in beam.supports), *itertools.chain(*loads)])


def _nodes(beam: SupportedBeam, loads: Sequence[tuple[float, float]]) -> Floats:
    spread = [(each.start, each.end) for each in beam.foundations] + [
        load for load in loads if load[1] > load[0]
    ]
    breaks = _breaks(beam, loads)
    out = [breaks[:1]]
    for low, high in itertools.pairwise(breaks):
        fine = beam.pieces[0].second is not None or any(
            first <= low and high <= last for first, last in spread
        )
        out.append(np.linspace(low, high, (_ELEMENTS if fine else 1) + 1)[1:])
    return np.concatenate(out)


def _stiffness(bending: Floats, shearing: Floats, long: Floats) -> tuple[Floats, Floats]:
    """Return the stiffness matrices (element, 4, 4) of elements (element,), and how much softer
    shear than bending makes them, 12 EI/(k G A l^2).
    """
    shear = 12 * bending / (shearing * long**2)
    near, far, turn, one = (4 + shear) * long**2, (2 - shear) * long**2, 6 * long, 12 + 0 * long
    rows = [
        [one, turn, -one, turn],
        [turn, near, -turn, far],
        [-one, -turn, one, -turn],
        [turn, far, -turn, near],
    ]
    return (bending / ((1 + shear) * long**3))[:, None, None] * np.moveaxis(
        np.array(rows), -1, 0
    ), shear


def _of_second(piece: BeamPiece, at: Floats, elements: np.ndarray) -> _Springs:
    """Return elements (element,) of the second beam."""
    nodes, (bending, shear) = len(at), piece.second or (0.0, 1.0)
    long = np.diff(at)[elements]
    one = _stiffness(np.full_like(long, bending), np.full_like(long, shear), long)[0]
    ends = np.stack([elements, elements + 1], axis=-1)
    return _Springs(
        np.stack([_DIRECTIONS * ends, _DIRECTIONS * nodes + ends], axis=-1).reshape(-1, 4), one
    )


def _places(elements: np.ndarray) -> np.ndarray:
    """Return the degrees of freedom (element, 4) of the ends of elements (element,)."""
    return np.asarray(_DIRECTIONS * elements[:, None] + np.arange(2 * _DIRECTIONS))


def _shapes(long: Floats, shear: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the weights (element, point), m, of the Gauss points of elements (element,), and how
    the section moves at each of them.

    The latter are displacement and rotation per displacement and rotation of the ends of the
    element, (element, point, 4) both.
    """
    x = (1 + _GAUSS[0]) / 2
    length, share, _ = np.broadcast_arrays(long[:, None], shear[:, None], x)
    shift = [
        1 - 3 * x**2 + 2 * x**3 + (1 - x) * share,
        length * (x - 2 * x**2 + x**3 + (x - x**2) * share / 2),
        3 * x**2 - 2 * x**3 + x * share,
        length * (x**3 - x**2 + (x**2 - x) * share / 2),
    ]
    turn = [
        6 * (x**2 - x) / length,
        1 - 4 * x + 3 * x**2 + (1 - x) * share,
        6 * (x - x**2) / length,
        3 * x**2 - 2 * x + x * share,
    ]
    whole = 1 + share[..., None]
    return _GAUSS[1] / 2 * length, np.stack(shift, axis=-1) / whole, np.stack(turn, axis=-1) / whole


def _foundation(each: Foundation, at: Floats, shears: Floats) -> list[_Springs]:
    under = np.flatnonzero((each.start <= at[:-1]) & (at[1:] <= each.end))
    weight, shift, turn = _shapes(np.diff(at)[under], shears[under])
    lateral, tilting = (
        stiffness * np.einsum("eg,egi,egj->eij", weight, shape, shape)
        for stiffness, shape in ((each.stiffness, shift), (each.tilt, turn))
    )
    out = [_Springs(_places(under), lateral + tilting)]
    if each.floating:
        moved = np.arange(_DIRECTIONS * len(at))
        along = np.where(moved % _DIRECTIONS == 0, 1.0, 0.0)
        pushed = np.bincount(
            _places(under).ravel(),
            (lateral @ along[_places(under)][..., None]).ravel(),
            minlength=len(moved),
        )
        out.append(_Springs(moved[None], -np.outer(pushed, pushed)[None] / float(along @ pushed)))
    return out


def _load(low: float, high: float, at: Floats, shears: Floats, dofs: int) -> Floats:
    out = np.zeros(dofs)
    if low == high:
        out[_DIRECTIONS * int(np.flatnonzero(at == low)[0])] = 1.0
        return out
    under = np.flatnonzero((low <= at[:-1]) & (at[1:] <= high))
    weight, shift, _ = _shapes(np.diff(at)[under], shears[under])
    np.add.at(out, _places(under), np.einsum("eg,egi->ei", weight, shift) / (high - low))
    return out
