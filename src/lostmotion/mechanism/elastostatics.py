"""Elastostatics of the whole arm, with links, joint units and base as springs: compliance at the
tool, deflection, ellipsoids, shares.

Design terms with an elastic form are included, each with its tangent compliance. Play is not
elastic and is neglected: valid while all play is closed. A gearbox within the control loop of an
encoder on its output does not deflect, because the controller corrects it.

Twists are (rotation, displacement) of the tool and wrenches (moment, force) at the tool point, both
in the base's axes. First order: the compliance is that at the pose of the unloaded arm. C = sum of
J C_part J^T over the parts; for the drives alone: J. Salisbury, Active stiffness control of a
manipulator in cartesian coordinates, Proc. 19th IEEE Conf. on Decision and Control, 1980.
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

# Poses evaluated at a time, so that the arrays of the parts fit into the processor's cache.
_BLOCK: Final = 1024
# Below this share of the largest compliance a direction counts as rigid. Rounding leaves about a
# thousandth of it in place of zero.
_RIGID: Final = 1e-10


@dataclass(frozen=True, repr=False)
class Compliances:
    """Compliance at the tool, by elastic part.

    parts    names of the elastic parts
    by_part  (part, pose, 6, 6) contribution of each part, rad and m per N m and N
    tool     (pose, 3) tool point in the base's frame, m
    """

    parts: tuple[str, ...]
    by_part: Floats
    tool: Floats

    @property
    def whole(self) -> Floats:
        """Return the compliance of the whole arm (pose, 6, 6), rad and m per N m and N."""
        return np.asarray(self.by_part.sum(axis=0))

    @property
    def mean_compliance(self) -> Floats:
        """Return the displacement along a force per newton, averaged over all directions of the
        force: (part, pose), m/N.
        """
        return np.asarray(np.einsum("tpii->tp", self.by_part[:, :, 3:, 3:])) / 3

    @property
    def shares(self) -> Floats:
        """Return each part's share (part, pose) of `mean_compliance`; NaN at poses where every part
        is rigid.
        """
        own = self.mean_compliance
        with np.errstate(invalid="ignore"):
            return np.asarray(own / own.sum(axis=0))

    @property
    def asymmetry(self) -> Floats:
        """Return the asymmetry (pose,) of the displacement per force, relative to its largest
        element; NaN where every part is rigid.

        By reciprocity the matrix is symmetric, so the asymmetry is rounding. Tables of bearings
        described by drawings add the error of their slopes.
        """
        shift = self.whole[:, 3:, 3:]
        off = np.abs(shift - shift.transpose(0, 2, 1)).max(axis=(1, 2), initial=0.0)
        with np.errstate(invalid="ignore"):
            return np.asarray(off / np.abs(shift).max(axis=(1, 2), initial=0.0))


def compliances(arm: Arm, q: Floats) -> Compliances:
    """Return the compliance contribution of each part at these poses, q (pose, joint) in rad or m.

    Each contribution is the tangent at the load that the part carries. It is exact, except for
    bearings described by drawings: their tables are differentiated over ±0.1 % of the load. An
    unloaded rolling contact has no stiffness; it is evaluated at a load of one millinewton.
    Raises ValueError for q of another shape or not finite.
    """
    values = as_poses(arm, q)
    springs = elastic_terms(arm)
    parts = tuple(dict.fromkeys(placed.owner for placed in springs))
    by_part = np.zeros((len(parts), len(values), 6, 6))
    tool = np.empty((len(values), 3))
    for start in range(0, len(values), _BLOCK):
        here = slice(start, start + _BLOCK)
        at = frames(arm, values[here])
        tool[here] = at[-1, :, :3, 3]
        conditions, carries = Conditions(arm, values[here], at), _carries(arm, at, springs)
        for placed in springs:
            carried = carries[placed.place]
            own = placed.term.scale * placed.term.form.compliance(conditions(placed))
            by_part[parts.index(placed.owner), here] += carried @ own @ carried.transpose(0, 2, 1)
    return Compliances(parts, by_part, tool)


def compliance(arm: Arm, q: Floats) -> Floats:
    """Return the twist of the tool per wrench on it (pose, 6, 6), rad and m per N m and N;
    arguments and errors as `compliances`.

    Symmetric and positive semidefinite where the compliances of all parts are (reciprocity).
    """
    return compliances(arm, q).whole


def deflection(arm: Arm, q: Floats, wrench: Floats) -> Floats:
    """Return rotation and displacement of the tool (pose, 6; rad, m) due to this wrench in addition
    to the arm's own loads.

    q       (pose, joint) rad or m
    wrench  (6,) or (pose, 6): moment and force at the tool point in the base's axes, N m and N

    The deflection of each part is evaluated with and without the wrench. So stiffness zones and
    contacts are included over the full change of load, not by their tangent. For linear springs the
    result is compliance @ wrench; for a rigid arm it is zero.
    Raises ValueError for q or wrench of another shape or not finite.
    """
    values = as_poses(arm, q)
    load = np.asarray(wrench, dtype=float)
    if load.shape not in {(6,), (len(values), 6)} or not np.isfinite(load).all():
        raise ValueError(
            f"a wrench of shape {load.shape}; expected 6 finite values, moment and force, or "
            "as many per pose"
        )
    load = np.broadcast_to(load, (len(values), 6))
    out, springs = np.zeros((len(values), 6)), elastic_terms(arm)
    for start in range(0, len(values), _BLOCK):
        here = slice(start, start + _BLOCK)
        at = frames(arm, values[here])
        conditions, carries = Conditions(arm, values[here], at), _carries(arm, at, springs)
        for placed in springs:
            before, carried = conditions(placed), carries[placed.place]
            more = replace(
                before, wrench=before.wrench + np.einsum("pji,pj->ip", carried, load[here])
            )
            moved = placed.term.scale * (
                placed.term.form.screw(more) - placed.term.form.screw(before)
            )
            out[here] += np.einsum("pij,jp->pi", carried, moved)
    return out


def sag(arm: Arm, q: Floats) -> Floats:
    """Return rotation and displacement of the tool (pose, 6; rad, m) by which the arm's own loads
    deflect its parts, first order.

    The loads are the weights of arm and payload, and the process force, at the pose of the unloaded
    arm; arguments and errors as `compliances`.
    """
    values = as_poses(arm, q)
    out, springs = np.zeros((len(values), 6)), elastic_terms(arm)
    for start in range(0, len(values), _BLOCK):
        here = slice(start, start + _BLOCK)
        at = frames(arm, values[here])
        conditions, carries = Conditions(arm, values[here], at), _carries(arm, at, springs)
        for placed in springs:
            out[here] += np.einsum(
                "pij,jp->pi",
                carries[placed.place],
                placed.term.scale * placed.term.form.screw(conditions(placed)),
            )
    return out


def _carries(arm: Arm, at: Floats, terms: list[PlacedTerm]) -> dict[int, Floats]:
    return {
        place: carry(arm.tree, at, place)
        for place in dict.fromkeys(placed.place for placed in terms)
    }


def elastic_terms(arm: Arm) -> list[PlacedTerm]:
    """Return the terms that deflect under load: design terms with an elastic form."""
    return [
        placed for placed in arm.terms if placed.term.form.elastic and placed.term.level == "design"
    ]


@dataclass(frozen=True)
class Ellipsoid:
    """Principal directions (pose, 3, 3), in columns, and the compliance along them (pose, 3), m/N,
    the most compliant first.

    A force along a principal direction displaces the tool point along that direction only.
    """

    directions: Floats
    values: Floats


def ellipsoid(matrix: Floats, *, rotation_fixed: bool = False) -> Ellipsoid:
    """Return the principal directions of the tool point's displacement under a force, for
    compliances (pose, 6, 6).

    The tool is free to rotate. With `rotation_fixed` its rotation is constrained instead: the
    compliance is then the inverse of the translational block of the stiffness matrix. For a rigid
    arm all values are zero, and the directions are arbitrary.
    """
    shift = matrix[..., 3:, 3:]
    if rotation_fixed:
        turns = matrix[..., :3, :3]
        shift = (
            shift
            - matrix[..., 3:, :3]
            @ np.linalg.pinv(turns, rcond=_RIGID, hermitian=True)
            @ matrix[..., :3, 3:]
        )
    values, directions = np.linalg.eigh((shift + np.swapaxes(shift, -1, -2)) / 2)
    return Ellipsoid(directions[..., ::-1], np.maximum(values[..., ::-1], 0.0))
