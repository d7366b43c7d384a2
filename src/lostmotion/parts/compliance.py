"""Compliance of a part: a matrix from finite elements, or a bending measurement."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Final, Self

import numpy as np
from pydantic import model_validator

from lostmotion.parts.error_source import (
    AngleAmount,
    ForceAmount,
    LengthAmount,
    Share,
    TorqueAmount,
)
from lostmotion.parts.provenance import Sourced
from lostmotion.parts.section import refuse_section

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

_Six = tuple[float, float, float, float, float, float]
_Three = tuple[float, float, float]
# A matrix printed with four digits is as symmetric as this, in units of the geometric mean of the
# two diagonal entries.
_SYMMETRY: Final = 2e-3
# A smaller scaled eigenvalue comes from rounding of the printed digits, or from a matrix that is
# not positive definite.
_LEAST: Final = 1e-6
# Measurement error: a deflection may be smaller by this share than a bar's, which is two thirds of
# length times slope.
_MEASURED: Final = 0.05
_FILE: Final = 'compliance = "forearm.csv"'


class Compliance(Sourced):
    """Compliance matrix (6, 6) of a part: from (moment, force) to (rotation, displacement), both at
    its far end and in the axes there.

    In SI: rad/(N m), rad/N, m/(N m), m/N. A file states it as a CSV with units. A rigid direction
    has a row and a column of zeros. `own_weight` (6, 3) is the twist of the far end of a link under
    its own weight, per gravity along x, y, z. `scatter` is the ± variation between such parts, as a
    share.
    """

    matrix: tuple[_Six, _Six, _Six, _Six, _Six, _Six]
    own_weight: tuple[_Three, _Three, _Three, _Three, _Three, _Three] | None = None
    scatter: Share = 0.0

    @model_validator(mode="after")
    def _obeys_reciprocity(self) -> Self:
        problem = compliance_error(np.array(self.matrix))
        if not np.isfinite(np.array(self.own_weight or 0.0)).all():
            problem = ("own weight with an entry that is not finite", "finite numbers")
        if problem:
            raise refuse_section(*problem, _FILE)
        return self

    @functools.cached_property
    def values(self) -> Floats:
        """Return the matrix (6, 6), symmetric."""
        matrix = np.array(self.matrix)
        return np.asarray((matrix + matrix.T) / 2)


def compliance_error(matrix: Floats) -> tuple[str, str] | None:
    """Return why a matrix (6, 6) is no compliance or stiffness, and what is expected; None where it
    is symmetric and positive definite.
    """
    if not np.isfinite(matrix).all():
        return "a matrix with an entry that is not finite", "finite numbers"
    diagonal = np.diag(matrix)
    if diagonal.min() < 0:
        return (
            f"a negative entry on the diagonal, {diagonal.min():g}",
            "a positive definite matrix: a load moves its point in its own direction",
        )
    # roots first: the product of two small entries would underflow
    scale = np.outer(np.sqrt(diagonal), np.sqrt(diagonal))
    gap = np.abs(matrix - matrix.T)
    if (gap > _SYMMETRY * scale).any():
        row, column = np.unravel_index(int(np.argmax(gap - _SYMMETRY * scale)), gap.shape)
        found = (
            f"{matrix[row, column]:g} in row {row + 1}, column {column + 1} and "
            f"{matrix[column, row]:g} across the diagonal"
        )
        return found, "a symmetric matrix: what a load here moves there, a load there moves here"
    compliant = diagonal > 0
    if matrix[~compliant].any():
        return (
            "an entry in a row whose diagonal is zero",
            "zeros throughout the row and column of a rigid direction",
        )
    scaled = (
        (matrix + matrix.T)[np.ix_(compliant, compliant)] / 2 / scale[np.ix_(compliant, compliant)]
    )
    if compliant.any() and np.linalg.eigvalsh(scaled).min() < _LEAST:
        return (
            "a matrix that is not positive definite: under some load its energy is negative",
            "a positive definite matrix, printed with enough digits",
        )
    return None


class Bending(Sourced):
    """Bending measurement in one plane: a transverse force at the far end of the link, and the
    deflection and slope of that point.
    """

    force: ForceAmount
    deflection: LengthAmount
    slope: AngleAmount | None = None

    def bar_compliances(self, length: float) -> tuple[float, float]:
        """Return 1/(E I) and 1/(k G A) of the equivalent uniform bar; without a slope, all of it
        bending. Raises ValueError for `inconsistency`.
        """
        if self.inconsistency(length):
            raise ValueError(self.inconsistency(length))
        pure = 3 * self.deflection / (self.force * length**3)
        if self.slope is None:
            return pure, 0.0
        sheared = self.deflection - 2 / 3 * self.slope * length
        return (
            (2 * self.slope / (self.force * length**2), sheared / (self.force * length))
            if sheared > 0
            else (pure, 0.0)
        )

    def inconsistency(self, length: float) -> str:
        """Return why no bar of this length deflects so; empty where one can."""
        if not self.force or not self.deflection:
            return "a force or a deflection of zero"
        least = 2 / 3 * (self.slope or 0.0) * length
        if self.deflection < (1 - _MEASURED) * least:
            return (
                f"{self.deflection * 1e3:.4g} mm under a slope that bends a bar of "
                f"{length * 1e3:g} mm by {least * 1e3:.4g} mm at least"
            )
        return ""


class Measured(Bending):
    """Measured deflection of a link under a load at its far end, its root clamped; an equivalent
    uniform bar represents the link.

    force, deflection, slope   across the link, in the plane that a lifting joint bends (along the
                               section's height)
    sideways                   the same along the joint's axis; default: as in that plane
    torque, twist              about the link; default: rigid there. Along the link it is rigid
    """

    sideways: Bending | None = None
    torque: TorqueAmount | None = None
    twist: AngleAmount | None = None
    scatter: Share = 0.0

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if (self.torque is None) != (self.twist is None) or self.torque == 0:
            raise refuse_section(
                "a torque without a twist, or the reverse",
                "both or neither",
                'torque = "20 N m", twist = "3 arcmin"',
            )
        return self

    def compliance_per_length(self, length: float) -> Floats:
        """Return the compliance per length (6, 6) of the equivalent bar, in the beam's axes."""
        out = np.zeros((6, 6))
        out[1, 1], out[5, 5] = self.bar_compliances(length)
        out[2, 2], out[4, 4] = (self.sideways or self).bar_compliances(length)
        if self.torque and self.twist is not None:
            out[0, 0] = self.twist / (self.torque * length)
        return out
