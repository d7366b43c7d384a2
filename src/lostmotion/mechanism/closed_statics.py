"""Statics of a closed chain: what the closures carry, and how a twist at any place moves the tool
after the loops have closed again.

The loads of the closures and the steps of the passive joints solve

    [ A   G ] [load]   [ -misfit of the open chain    ]
    [ G'  0 ] [step] = [ -loads on the passive joints ]

with the closures' Jacobian G and the compliance A of the parts within the loops. Where G is square
and regular, A does not matter: the chain is exactly constrained. Where rigid parts constrain it too
often, the smallest loads are taken, and errors on which the solution depends are refused.

Twists and wrenches are about the tool point, in the base's axes. Source: virtual work, as in
M. Pott, M. Hiller, A new approach to error analysis in parallel kinematic structures, 2004; leg by
leg: A. Pashkevich, D. Chablat, P. Wenger, arXiv 0904.0052.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.carry import at_tool_point, carry
from lostmotion.mechanism.closed_home import home_of
from lostmotion.mechanism.closed_jacobian import balance, loop_columns, signs, twist_units
from lostmotion.spatial import mapped

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from lostmotion.mechanism.places import Tree
    from lostmotion.spatial import Floats

    # Place, twist (pose, 6) under its load and compliance (pose, 6, 6) of a spring.
    Spring = tuple[int, Floats, Floats]

# Eigenvalues below this share of the largest one count as zero: rounding leaves 1e-15.
_NULL: Final = 1e-11
# A part of an error that the closures cannot take up counts above this share of it.
_TAKEN_UP: Final = 1e-7


@dataclass(frozen=True, eq=False)
class Loops:
    """The closures of a chain in frames, with the springs in its parts.

    tree, at     the chain and its frames (place, pose, 4, 4)
    compliance   (pose, 6, 6) of each place with springs, in its own axes
    exact        whether the closures determine the passive joints exactly, without any spring
    """

    tree: Tree
    at: Floats
    compliance: dict[int, Floats]
    exact: bool

    def rows(self, rows: NDArray[np.int64]) -> Loops:
        """Return the closures at the poses in these rows, which may repeat."""
        out = Loops(
            self.tree,
            self.at[:, rows],
            {place: each[rows] for place, each in self.compliance.items()},
            self.exact,
        )
        factors = self._factors
        known = {
            "columns": self.columns[rows],
            "_factors": (*factors[:2], *(each[rows] for each in factors[2:])),
            "_inverse": tuple(each[rows] for each in self._inverse),
        }
        out.__dict__.update(known)
        return out

    @functools.cached_property
    def columns(self) -> Floats:
        """Return the Jacobian G of the closures (pose, equation, freedom)."""
        return loop_columns(self.tree, self.at, [each.place for each in self.tree.passive])

    @functools.cached_property
    def _factors(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Return the factors that balance rows and columns, the size of the compliance, and the
        balanced system; its inverse where the chain is exactly constrained.
        """
        rows, columns = balance(self.tree)
        matrix = self.columns * rows[:, None] * columns
        if self.exact:
            return rows, columns, np.ones(len(matrix)), np.asarray(np.linalg.inv(matrix))
        give = self.loop_compliance * rows[:, None] * rows
        largest = np.abs(give).max(axis=(1, 2), initial=0.0)
        largest[largest == 0] = 1.0
        lower = np.zeros((len(matrix), len(columns), len(columns)))
        whole = np.concatenate(
            [
                np.concatenate([give / largest[:, None, None], matrix], axis=2),
                np.concatenate([matrix.transpose(0, 2, 1), lower], axis=2),
            ],
            axis=1,
        )
        return rows, columns, np.asarray(largest), whole

    @functools.cached_property
    def _inverse(self) -> tuple[Floats, Floats]:
        """Return the inverse of the balanced system and a basis (pose, equation, stress) of the
        loads that no passive joint and no spring feels, by which it is singular.
        """
        rows, _, _, whole = self._factors
        none = np.zeros((len(whole), len(rows), 0))
        if self.exact or not len(whole):
            return whole, none
        values = np.linalg.eigvalsh(whole[0])
        if (np.abs(values) > _NULL * np.abs(values).max(initial=0.0)).all() and len(values):
            return np.asarray(np.linalg.inv(whole)), none
        values, vectors = np.linalg.eigh(whole)
        size_of = np.abs(values)
        zero = size_of <= _NULL * size_of.max(axis=1, keepdims=True, initial=0.0)
        inverted = np.where(zero, 0.0, 1 / np.where(zero, 1.0, values))
        null = vectors * zero[:, None, :]
        return (vectors * inverted[:, None, :]) @ vectors.transpose(0, 2, 1), null[:, : len(rows)]

    @functools.cached_property
    def redundant(self) -> Floats:
        """Return a basis (pose, equation, load) of the loads of the closures that no passive joint
        feels, of balanced equations.
        """
        rows, columns = balance(self.tree)
        every = np.linalg.svd(self.columns * rows[:, None] * columns)[0]
        return np.asarray(every[:, :, home_of(self.tree).rank :])

    @functools.cached_property
    def loop_compliance(self) -> Floats:
        """Return A (pose, equation, equation): what the closures give per load on them."""
        count, sign = 6 * len(self.tree.welds), signs(self.tree)
        out = np.zeros((self.at.shape[1], count, count))
        for place, own in self.compliance.items():
            if not sign[:, place].any():
                continue
            moved = at_tool_point(self.at, place)
            here = moved @ own @ moved.transpose(0, 2, 1)
            both = np.multiply.outer(sign[:, place], sign[:, place])
            out += np.einsum("cd,pij->pcidj", both, here).reshape(out.shape)
        return out

    def solved(self, misfit: Floats, loads: Floats) -> tuple[Floats, Floats]:
        """Return the loads of the closures (pose, equation, n) and the steps of the passive joints
        (pose, freedom, n) for the right-hand sides (pose, equation, n) and (pose, freedom, n).
        """
        rows, columns, largest, _ = self._factors
        inverse, count = self._inverse[0], len(rows)
        top, bottom = rows[:, None] * misfit, columns[:, None] * loads
        if self.exact:
            load, step = inverse.transpose(0, 2, 1) @ bottom, inverse @ top
            return rows[:, None] * load, columns[:, None] * step
        scale = largest[:, None, None]
        found = inverse @ np.concatenate([top, scale * bottom], axis=1)
        return rows[:, None] * found[:, :count] / scale, columns[:, None] * found[:, count:]

    @functools.cached_property
    def per_tool_wrench(self) -> Floats:
        """Return the loads of the closures per wrench on the tool (pose, equation, 6)."""
        tree, sign = self.tree, signs(self.tree)
        top = np.zeros((self.at.shape[1], 6 * len(tree.welds), 6))
        for place, own in self.compliance.items():
            if not self.exact and place in tree.tool_path and sign[:, place].any():
                moved = at_tool_point(self.at, place)
                here = moved @ own @ moved.transpose(0, 2, 1)
                top -= np.concatenate([each * here for each in sign[:, place]], axis=1)
        bottom = [np.zeros((self.at.shape[1], 0, 6))]
        for each in tree.passive:
            moved = carry(tree, self.at, each.place) @ tree.places[each.place].twist
            bottom.append(-moved.transpose(0, 2, 1))
        return self.solved(top, np.concatenate(bottom, axis=1))[0]

    def on_place(self, place: int, loads: Floats) -> Floats:
        """Return the wrench (pose, 6, n) on a place by loads of the closures (pose, equation, n),
        about the tool point.
        """
        blocks = loads.reshape(len(loads), -1, 6, loads.shape[2])
        return np.asarray(np.einsum("c,pcin->pin", signs(self.tree)[:, place], blocks))

    def carry(self, place: int) -> Floats:
        """Return the twist of the tool about the tool point, in the base's axes, per twist at a
        place in its own axes (pose, 6, 6), after the loops have closed again.
        """
        moved = at_tool_point(self.at, place)
        out = self.on_place(place, self.per_tool_wrench).transpose(0, 2, 1) @ moved
        return out + moved if place in self.tree.tool_path else out

    def wrenches(self, of_tree: Floats, springs: Iterable[Spring] = ()) -> Floats:
        """Return the wrenches on all places (place, pose, 6) in their axes, for those of the open
        tree.

        springs  twist and compliance at the load at which the compliance is taken
        """
        tree, sign = self.tree, signs(self.tree)
        top = np.zeros((self.at.shape[1], len(tree.welds), 6))
        for place, twist, _ in springs:
            if sign[:, place].any() and not self.exact:
                own = twist + np.einsum("pij,pj->pi", self.compliance[place], of_tree[place])
                moved = np.einsum("pij,pj->pi", at_tool_point(self.at, place), own)
                top -= sign[:, place, None] * moved[:, None]
        bottom = np.concatenate(
            [
                np.zeros((self.at.shape[1], 0)),
                *(
                    -mapped(tree.places[each.place].twist.T, of_tree[each.place])
                    for each in tree.passive
                ),
            ],
            axis=1,
        )
        loads, _ = self.solved(top.reshape(len(top), -1, 1), bottom[..., None])
        out = of_tree.copy()
        for place in np.flatnonzero(sign.any(axis=0)).tolist():
            moved = at_tool_point(self.at, place)
            out[place] += np.einsum("pij,pi->pj", moved, self.on_place(place, loads)[..., 0])
        return out

    def loads(self, places: NDArray[np.int64], local: Floats) -> Floats:
        """Return the loads of the closures (pose, equation, term) by twists at places (term,),
        local (pose, 6, term) in their axes.
        """
        moved = np.empty_like(local)
        for place in np.unique(places).tolist():
            here = places == place
            moved[:, :, here] = at_tool_point(self.at, place) @ local[:, :, here]
        misfit = np.concatenate([each[places] * moved for each in signs(self.tree)], axis=1)
        none = np.zeros((len(local), self.columns.shape[2], local.shape[2]))
        return self.solved(-misfit, none)[0]

    def untaken(self, place: int, local: Floats) -> Floats:
        """Return the share (term, pose) of twists at a place, local (6, term, pose), that the loops
        of rigid parts cannot take up: their effect has no answer.
        """
        stress = self._inverse[1]
        if not stress.shape[2] or not signs(self.tree)[:, place].any():
            return np.zeros(local.shape[1:])
        rows, sign = twist_units(self.tree), signs(self.tree)
        moved = rows[:, None] * (at_tool_point(self.at, place) @ local.transpose(2, 0, 1))
        misfit = np.concatenate([each * moved for each in sign[:, place]], axis=1)
        left = np.linalg.norm(stress.transpose(0, 2, 1) @ misfit, axis=1)
        whole = np.linalg.norm(misfit, axis=1)
        return np.asarray(np.where(whole > 0, left / np.where(whole > 0, whole, 1), 0)).T

    def refuses(self, place: int, local: Floats) -> Floats:
        """Return whether (term,) twists at a place have no answer at some pose."""
        return np.asarray((self.untaken(place, local) > _TAKEN_UP).any(axis=1))
