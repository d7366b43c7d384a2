"""A straight stepped beam on springs: displacements at its loads, and which part of the beam or of its supports they come from.

Timoshenko beam in one plane. Supports are springs at a place (bearings), or distributed along a length (a pin in its seat). Elements are exact for
loads and supports at their ends; under distributed loads and seats they are refined until the error is below 1e-5.

Source: J. Przemieniecki, Theory of Matrix Structural Analysis, 1968, ch. 5 (element with shear); M. Hetenyi, Beams on Elastic Foundation, 1946
(distributed supports).
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from lostmotion.spatial import Floats

# Elements per interval under a seat or a distributed load, and of a sandwich, whose compliance is then accurate to 3e-4.
_ELEMENTS: Final = 24
_GAUSS: Final = np.polynomial.legendre.leggauss(4)
# Condition number, with a diagonal of ones, above which a beam counts as free to move.
_SINGULAR: Final = 1e14
_NOT_HELD: Final = "the supports do not hold this beam"
_DIRECTIONS: Final = 2  # a beam in a plane can shift and tilt


@dataclass(frozen=True, slots=True)
class Piece:
    """A prismatic piece of the beam from `start` to `end` (m): `bending` stiffness EI (N m^2) and `shear` stiffness k G A (N).

    second  EI and k G A of a second beam, which shares the deflection of the first one but not its rotation, as the faces of a sandwich do; for all
            pieces of a beam or for none
    """

    start: float
    end: float
    bending: float
    shear: float
    second: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class Support:
    """A spring at a place (m): lateral `stiffness` (N/m) and `tilt` stiffness (N m/rad). Infinite means rigid, zero means free."""

    at: float
    stiffness: float = math.inf
    tilt: float = 0.0


@dataclass(frozen=True, slots=True)
class Foundation:
    """Springs spread from `start` to `end` (m): lateral `stiffness` (N/m per m) and `tilt` stiffness (N m/rad per m).

    floating  the body that holds these springs moves sideways freely, without tilting
    """

    start: float
    end: float
    stiffness: float
    tilt: float = 0.0
    floating: bool = False


@dataclass(frozen=True, slots=True)
class SupportedBeam:
    """A beam of consecutive pieces on supports and foundations. Raises ValueError for gaps between pieces and places beyond its ends."""

    pieces: tuple[Piece, ...]
    supports: tuple[Support, ...] = ()
    foundations: tuple[Foundation, ...] = ()

    def __post_init__(self) -> None:
        """Refuse beams with gaps, without stiffness, or supported beyond their ends."""
        wrong = [f"the piece from {one.start:g} to {one.end:g} m has no length" for one in self.pieces if not one.end > one.start]
        wrong += ["its pieces are not consecutive" for one, two in zip(self.pieces, self.pieces[1:], strict=False) if one.end != two.start]
        wrong += ["a piece has no stiffness" for one in self.pieces if not min(one.bending, one.shear, *(one.second or ())) > 0]
        if len({one.second is None for one in self.pieces}) > 1:
            wrong.append("only some of its pieces are sandwiches")
        places = [each.at for each in self.supports] + [end for each in self.foundations for end in (each.start, each.end)]
        start, end = self.pieces[0].start, self.pieces[-1].end
        wrong += [f"the support at {place:g} m is beyond its ends at {start:g} and {end:g} m" for place in places if not start <= place <= end]
        if wrong:
            raise ValueError("this beam cannot exist: " + "; ".join(wrong))


@dataclass(frozen=True, slots=True)
class Response:
    """Response of a beam to unit forces at its loads.

    by_part    (part, load, load) contribution of each part to the flexibility, m/N: pieces, then supports, then foundations
    reactions  (support, load) force of each support on the beam per force at a load, negative where it opposes the force
    """

    by_part: Floats
    reactions: Floats

    @property
    def flexibility(self) -> Floats:
        """Return the displacements (m) at load i, averaged over it, under a unit force (N) at load j: (load, load), symmetric."""
        return np.asarray(self.by_part.sum(axis=0))


def respond(beam: SupportedBeam, loads: Sequence[tuple[float, float]]) -> Response:
    """Return the response to unit forces, each distributed uniformly from one place to another (m); equal places are a point load.

    The contributions follow from the energy in each part, so they are all zero or more on the diagonal. Raises ValueError for a load beyond the ends
    of the beam, and for a beam that its supports do not hold.
    """
    start, end = beam.pieces[0].start, beam.pieces[-1].end
    if not all(start <= low <= high <= end for low, high in loads):
        raise ValueError(f"a load lies beyond the ends of the beam at {start:g} and {end:g} m")
    at = _nodes(beam, loads)
    sandwich = beam.pieces[0].second is not None
    dofs = (_DIRECTIONS + sandwich) * len(at)  # rotations of the second beam come last
    node = {place: k for k, place in enumerate(at.tolist())}
    elements = [_element(beam, low, high) for low, high in itertools.pairwise(at)]
    parts = [_assembled(dofs, [(k, stiff) for k, (index, stiff, _) in enumerate(elements) if index == piece]) for piece in range(len(beam.pieces))]
    if sandwich:
        for k, (index, _, _) in enumerate(elements):
            parts[index] += _of_second(beam.pieces[index], at, k)
    held = np.zeros(dofs, dtype=bool)
    for support in beam.supports:
        spring = np.zeros((dofs, dofs))
        for direction, stiffness in enumerate((support.stiffness, support.tilt)):
            one = _DIRECTIONS * node[support.at] + direction
            held[one] |= math.isinf(stiffness)
            spring[one, one] = stiffness if math.isfinite(stiffness) else 0.0
        if sandwich:
            held[_DIRECTIONS * len(at) + node[support.at]] = math.isinf(support.tilt)
        parts.append(spring)
    parts += [_foundation(each, at, [shear for _, _, shear in elements], dofs) for each in beam.foundations]
    forces = np.stack([_load(low, high, at, [shear for _, _, shear in elements], dofs) for low, high in loads], axis=-1)
    whole, free = np.sum(parts, axis=0), ~held
    moved = np.zeros_like(forces)
    moved[free] = _solved(whole[np.ix_(free, free)], forces[free])
    unbalanced = np.sum(parts[: len(beam.pieces)] + parts[len(beam.pieces) + len(beam.supports) :], axis=0) @ moved - forces
    reactions = np.stack([unbalanced[_DIRECTIONS * node[each.at]] for each in beam.supports]) if beam.supports else np.zeros((0, len(loads)))
    return Response(np.stack([moved.T @ part @ moved for part in parts]), reactions)


def _solved(matrix: Floats, forces: Floats) -> Floats:
    """Return the displacements (dof, load) under forces (dof, load). Raises ValueError where the supports do not hold the beam.

    Sparse, because threads of dense algebra take longer on matrices of this size than the work itself.
    """
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import splu

    scale = 1 / np.sqrt(np.diag(matrix))
    try:
        factors = splu(csc_array(matrix * scale * scale[:, None]), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:  # a pivot is exactly zero
        raise ValueError(_NOT_HELD) from None
    pivots = np.abs(factors.U.diagonal())
    if pivots.min() * _SINGULAR < pivots.max():
        raise ValueError(_NOT_HELD)
    return np.asarray(scale[:, None] * factors.solve(scale[:, None] * forces))


def _nodes(beam: SupportedBeam, loads: Sequence[tuple[float, float]]) -> Floats:
    spread = [(each.start, each.end) for each in beam.foundations] + [load for load in loads if load[1] > load[0]]
    ends = [end for each in beam.pieces for end in (each.start, each.end)] + [each.at for each in beam.supports]
    breaks = np.unique(np.array(ends + [end for each in (*spread, *loads) for end in each]))
    out = [breaks[:1]]
    for low, high in itertools.pairwise(breaks):
        fine = beam.pieces[0].second is not None or any(first <= low and high <= last for first, last in spread)
        out.append(np.linspace(low, high, (_ELEMENTS if fine else 1) + 1)[1:])
    return np.concatenate(out)


def _element(beam: SupportedBeam, low: float, high: float) -> tuple[int, Floats, float]:
    """Return the piece of an element, its stiffness matrix (4, 4) and the ratio of its shear to its bending compliance, 12 EI/(k G A l^2)."""
    index = next(k for k, piece in enumerate(beam.pieces) if low < piece.end)
    piece, long = beam.pieces[index], high - low
    return index, *_stiffness(piece.bending, piece.shear, long)


def _stiffness(bending: float, shearing: float, long: float) -> tuple[Floats, float]:
    shear = 12 * bending / (shearing * long**2)
    near, far, turn = (4 + shear) * long**2, (2 - shear) * long**2, 6 * long
    matrix = np.array([[12, turn, -12, turn], [turn, near, -turn, far], [-12, -turn, 12, -turn], [turn, far, -turn, near]])
    return bending / ((1 + shear) * long**3) * matrix, shear


def _of_second(piece: Piece, at: Floats, k: int) -> Floats:
    """Return the stiffness matrix of element k of the second beam, on all degrees of freedom."""
    nodes = len(at)
    places = [_DIRECTIONS * k, _DIRECTIONS * nodes + k, _DIRECTIONS * (k + 1), _DIRECTIONS * nodes + k + 1]
    out = np.zeros(((_DIRECTIONS + 1) * nodes,) * 2)
    bending, shear = piece.second or (0.0, 1.0)
    out[np.ix_(places, places)] = _stiffness(bending, shear, float(at[k + 1] - at[k]))[0]
    return out


def _assembled(dofs: int, elements: Sequence[tuple[int, Floats]]) -> Floats:
    out = np.zeros((dofs, dofs))
    for k, matrix in elements:
        at = slice(_DIRECTIONS * k, _DIRECTIONS * k + 4)
        out[at, at] += matrix
    return out


def _shapes(x: float, long: float, shear: float) -> tuple[Floats, Floats]:
    """Return displacement and rotation of the section at x (0..1) along an element, per displacement and rotation of its ends: (4,) each."""
    shift = np.array([1 - 3 * x**2 + 2 * x**3 + (1 - x) * shear, long * (x - 2 * x**2 + x**3 + (x - x**2) * shear / 2)])
    other = np.array([3 * x**2 - 2 * x**3 + x * shear, long * (x**3 - x**2 + (x**2 - x) * shear / 2)])
    turn = np.array([6 * (x**2 - x) / long, 1 - 4 * x + 3 * x**2 + (1 - x) * shear, 6 * (x - x**2) / long, 3 * x**2 - 2 * x + x * shear])
    return np.concatenate([shift, other]) / (1 + shear), turn / (1 + shear)


def _foundation(each: Foundation, at: Floats, shears: Sequence[float], dofs: int) -> Floats:
    lateral, tilting = np.zeros((dofs, dofs)), np.zeros((dofs, dofs))
    for k, (low, high) in enumerate(itertools.pairwise(at)):
        if each.start <= low and high <= each.end:
            here = slice(_DIRECTIONS * k, _DIRECTIONS * k + 4)
            for x, weight in zip(*_GAUSS, strict=True):
                shift, turn = _shapes((1 + x) / 2, high - low, shears[k])
                lateral[here, here] += each.stiffness * weight / 2 * (high - low) * np.outer(shift, shift)
                tilting[here, here] += each.tilt * weight / 2 * (high - low) * np.outer(turn, turn)
    if each.floating:
        along = np.zeros(dofs)
        along[: _DIRECTIONS * len(at) : _DIRECTIONS] = 1.0
        pushed = lateral @ along
        lateral = lateral - np.outer(pushed, pushed) / float(along @ pushed)
    return lateral + tilting


def _load(low: float, high: float, at: Floats, shears: Sequence[float], dofs: int) -> Floats:
    out = np.zeros(dofs)
    if low == high:
        out[_DIRECTIONS * int(np.flatnonzero(at == low)[0])] = 1.0
        return out
    for k, (first, last) in enumerate(itertools.pairwise(at)):
        if low <= first and last <= high:
            for x, weight in zip(*_GAUSS, strict=True):
                shift, _ = _shapes((1 + x) / 2, last - first, shears[k])
                out[_DIRECTIONS * k : _DIRECTIONS * k + 4] += weight / 2 * (last - first) / (high - low) * shift
    return out
