"""Elastostatics of the whole arm, with links, joint units and base as springs: compliance at the tool, deflection, ellipsoids, shares.

Only the elastic forms among the parts' design terms count, each with its own tangent. Play is not elastic and is neglected: valid while plays
stay closed. A gearbox within the loop of an encoder on its output is held by the controller and does not deflect.

Directions are (rotation, displacement) of the tool and (moment, force) at the tool point, both in the base's axes. First order: the pose that the
unloaded arm stands in. C = sum of J C_part J^T over the parts; for the drives alone: J. Salisbury, Active stiffness control of a manipulator in
cartesian coordinates, Proc. 19th IEEE Conf. on Decision and Control, 1980.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.mechanism.carry import carry
from lostmotion.mechanism.serial import Conditions, as_poses, frames

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.placed_terms import PlacedTerm
    from lostmotion.spatial import Floats

# Poses at a time: what parts work on then stays in the processor's cache.
_BLOCK: Final = 1024
# Below this share of the largest, a direction counts as rigid: what differences leave of zero is a thousandth of it.
_RIGID: Final = 1e-10


@dataclass(frozen=True, repr=False)
class Compliances:
    """Compliance at the tool by elastic part: `by_part` (part, pose, 6, 6) in rad, m per N m, N; `tool` (pose, 3) the tool point, m."""

    parts: tuple[str, ...]
    by_part: Floats
    tool: Floats

    @property
    def whole(self) -> Floats:
        """Return the compliance of the whole arm (pose, 6, 6)."""
        return np.asarray(self.by_part.sum(axis=0))

    @property
    def mean_compliance(self) -> Floats:
        """Return by part (part, pose) the displacement along a force per newton, averaged over all directions of the force, m/N."""
        return np.asarray(np.einsum("tpii->tp", self.by_part[:, :, 3:, 3:])) / 3

    @property
    def shares(self) -> Floats:
        """Return each part's share (part, pose) of `mean_compliance`; NaN at poses where every part is rigid."""
        own = self.mean_compliance
        with np.errstate(invalid="ignore"):
            return np.asarray(own / own.sum(axis=0))

    @property
    def asymmetry(self) -> Floats:
        """Return the departure of the displacement under a force from reciprocity (pose,), as a share of the largest; NaN where every part is rigid.

        Rounding only, except with bearings described by drawings: there it is the uncertainty of the slopes of their tables.
        """
        shift = self.whole[:, 3:, 3:]
        off = np.abs(shift - shift.transpose(0, 2, 1)).max(axis=(1, 2), initial=0.0)
        with np.errstate(invalid="ignore"):
            return np.asarray(off / np.abs(shift).max(axis=(1, 2), initial=0.0))


def compliances(arm: Arm, q: Floats) -> Compliances:
    """Return the compliance contribution of each part at these poses, q (pose, joint) in rad or m.

    The tangent at the load that each part carries, exact for all springs but drawn bearings, whose tables are read over ±0.1 % of the load: a
    contact between rolling elements without load has no stiffness at all, and counts as if it carried a millinewton. Raises ValueError for q of
    another shape or not finite.
    """
    values = as_poses(arm, q)
    springs = springs_of(arm)
    parts = tuple(dict.fromkeys(of.owner for of in springs))
    by_part = np.zeros((len(parts), len(values), 6, 6))
    tool = np.empty((len(values), 3))
    for start in range(0, len(values), _BLOCK):
        here = slice(start, start + _BLOCK)
        at = frames(arm, values[here])
        tool[here] = at[-1, :, :3, 3]
        felt, carries = Conditions(arm, values[here], at), _carries(arm, at, springs)
        for of in springs:
            carried = carries[of.place]
            own = of.term.scale * of.term.form.compliance(felt(of))
            by_part[parts.index(of.owner), here] += carried @ own @ carried.transpose(0, 2, 1)
    return Compliances(parts, by_part, tool)


def compliance(arm: Arm, q: Floats) -> Floats:
    """Return the twist of the tool per wrench on it (pose, 6, 6), rad and m per N m and N; arguments and errors as `compliances`.

    Symmetric and positive semidefinite, as long as the parts' own laws are (reciprocity).
    """
    return compliances(arm, q).whole


def deflection(arm: Arm, q: Floats, wrench: Floats) -> Floats:
    """Return rotation and displacement of the tool (pose, 6; rad, m) under this wrench in addition to the arm's own loads.

    wrench (6,) or (pose, 6): moment and force at the tool point in the base's axes, N m and N. Not the tangent: parts are asked with and without the
    wrench, so that zones and contacts count over the whole way; for springs in proportion it is compliance @ wrench. A rigid arm: zero.
    Raises ValueError for q or wrench of another shape or not finite.
    """
    values = as_poses(arm, q)
    load = np.asarray(wrench, dtype=float)
    if load.shape not in {(6,), (len(values), 6)} or not np.isfinite(load).all():
        raise ValueError(f"a wrench of shape {load.shape}; expected 6 finite values, moment and force, or as many per pose")
    load = np.broadcast_to(load, (len(values), 6))
    out, springs = np.zeros((len(values), 6)), springs_of(arm)
    for start in range(0, len(values), _BLOCK):
        here = slice(start, start + _BLOCK)
        at = frames(arm, values[here])
        felt, carries = Conditions(arm, values[here], at), _carries(arm, at, springs)
        for of in springs:
            before, carried = felt(of), carries[of.place]
            more = replace(before, wrench=before.wrench + np.einsum("pji,pj->ip", carried, load[here]))
            moved = of.term.scale * (of.term.form.screw(more) - of.term.form.screw(before))
            out[here] += np.einsum("pij,jp->pi", carried, moved)
    return out


def _carries(arm: Arm, at: Floats, terms: list[PlacedTerm]) -> dict[int, Floats]:
    return {place: carry(arm.tree, at, place) for place in dict.fromkeys(of.place for of in terms)}


def springs_of(arm: Arm) -> list[PlacedTerm]:
    """Return the terms that deflect under load: design terms of an elastic form."""
    return [of for of in arm.terms if of.term.form.elastic and of.term.level == "design"]


@dataclass(frozen=True)
class Ellipsoid:
    """Principal directions (pose, 3, 3), in columns, and the compliance along them (pose, 3) in m/N (or rad/(N m)), the softest first.

    A unit force along a principal direction moves the tool point along it and nowhere else.
    """

    directions: Floats
    values: Floats


def ellipsoid(matrix: Floats, *, rotation_held: bool = False) -> Ellipsoid:
    """Return the principal directions of the tool point's displacement under a force, for compliances (pose, 6, 6).

    The tool is free to rotate, or its rotation is constrained (`rotation_held`: the inverse of the stiffness's translational block). For a rigid arm
    all values are zero, and the directions are arbitrary.
    """
    shift = matrix[..., 3:, 3:]
    if rotation_held:
        turns = matrix[..., :3, :3]
        shift = shift - matrix[..., 3:, :3] @ np.linalg.pinv(turns, rcond=_RIGID, hermitian=True) @ matrix[..., :3, 3:]
    values, directions = np.linalg.eigh((shift + np.swapaxes(shift, -1, -2)) / 2)
    return Ellipsoid(directions[..., ::-1], np.maximum(values[..., ::-1], 0.0))
