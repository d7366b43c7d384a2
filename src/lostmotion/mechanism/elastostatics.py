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

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.parts.term import LOADS

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm
    from lostmotion.mechanism.placed_terms import PlacedTerm
    from lostmotion.spatial import Floats

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


def elastic_terms(arm: Arm) -> list[PlacedTerm]:
    """Return the terms that deflect under load: design terms with an elastic form."""
    return [
        placed for placed in arm.terms if placed.term.form.elastic and placed.term.level == "design"
    ]


def sagging_terms(arm: Arm) -> list[PlacedTerm]:
    """Return the terms that the arm's own loads deflect: the elastic ones, the bending of links
    under their own weight, and what controllers feed forward; not those of plays.
    """
    return [
        placed
        for placed in arm.terms
        if placed.term.level == "design"
        and not placed.term.form.jumps
        and not LOADS.isdisjoint(placed.term.form.reads)
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
