"""What gives, by its matrix: from finite elements of the part, or from what was measured on it."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Final, Self

import numpy as np
from pydantic import model_validator

from lostmotion.parts.error_source import AngleAmount, ForceAmount, LengthAmount, Share, TorqueAmount
from lostmotion.parts.provenance import Sourced
from lostmotion.parts.section import refuse_section

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

_Six = tuple[float, float, float, float, float, float]
_Three = tuple[float, float, float]
# A matrix printed with four digits is as symmetric as this, in units of the geometric mean of the two diagonal entries.
_SYMMETRY: Final = 2e-3
# Below this the smallest eigenvalue, so scaled, is rounding of the printed digits or energy out of nothing.
_LEAST: Final = 1e-6
# How much less than a bar's, two thirds of length times slope, a measured deflection may be by the errors of measuring.
_MEASURED: Final = 0.05
_FILE: Final = 'compliance = "forearm.csv"'


class Compliance(Sourced):
    """How a part turns and moves under a load: matrix (6, 6) from (moment, force) to (turn, shift), both at its far end and in the axes there.

    In SI: rad/(N m), rad/N, m/(N m), m/N. In a file it stands as a CSV that states its units. A direction in which nothing gives has a row and a
    column of zeros. `own_weight` (6, 3) is what the far end of a link does under its own weight, per gravity along x, y, z.
    `scatter` is the ± share by which such parts differ.
    """

    matrix: tuple[_Six, _Six, _Six, _Six, _Six, _Six]
    own_weight: tuple[_Three, _Three, _Three, _Three, _Three, _Three] | None = None
    scatter: Share = 0.0

    @model_validator(mode="after")
    def _obeys_reciprocity(self) -> Self:
        doubt = doubt_of_compliance(np.array(self.matrix))
        if not np.isfinite(np.array(self.own_weight or 0.0)).all():
            doubt = ("own weight with an entry that is not finite", "finite numbers")
        if doubt:
            raise refuse_section(*doubt, _FILE)
        return self

    @functools.cached_property
    def values(self) -> Floats:
        """Give the matrix (6, 6), symmetric."""
        matrix = np.array(self.matrix)
        return np.asarray((matrix + matrix.T) / 2)


def doubt_of_compliance(matrix: Floats) -> tuple[str, str] | None:
    """What keeps a matrix (6, 6) from being a compliance or a stiffness, and what is expected? None where it is symmetric and positive."""
    if not np.isfinite(matrix).all():
        return "a matrix with an entry that is not finite", "finite numbers"
    diagonal = np.diag(matrix)
    if diagonal.min() < 0:
        return f"a negative entry on the diagonal, {diagonal.min():g}", "a positive definite matrix: a load moves its point its own way"
    scale = np.outer(np.sqrt(diagonal), np.sqrt(diagonal))  # roots first: the product of two small entries would be zero
    gap = np.abs(matrix - matrix.T)
    if (gap > _SYMMETRY * scale).any():
        row, column = np.unravel_index(int(np.argmax(gap - _SYMMETRY * scale)), gap.shape)
        found = f"{matrix[row, column]:g} in row {row + 1}, column {column + 1} and {matrix[column, row]:g} across the diagonal"
        return found, "a symmetric matrix: what a load here moves there, a load there moves here"
    gives = diagonal > 0
    if matrix[~gives].any():
        return "an entry in a row whose diagonal is zero", "zeros all along a direction in which nothing gives"
    scaled = (matrix + matrix.T)[np.ix_(gives, gives)] / 2 / scale[np.ix_(gives, gives)]
    if gives.any() and np.linalg.eigvalsh(scaled).min() < _LEAST:
        return "a matrix by which some load gives energy back", "a positive definite matrix, printed with enough digits"
    return None


class Bending(Sourced):
    """What was measured in one plane: a force across the link at its far end, how far that point moved, and by how much it turned."""

    force: ForceAmount
    deflection: LengthAmount
    slope: AngleAmount | None = None

    def gives(self, length: float) -> tuple[float, float]:
        """Give 1/(E I) and 1/(k G A) of the uniform bar that bends so; without a slope, all of it bending. Raises ValueError as `doubt` says."""
        if self.doubt(length):
            raise ValueError(self.doubt(length))
        pure = 3 * self.deflection / (self.force * length**3)
        if self.slope is None:
            return pure, 0.0
        sheared = self.deflection - 2 / 3 * self.slope * length
        return (2 * self.slope / (self.force * length**2), sheared / (self.force * length)) if sheared > 0 else (pure, 0.0)

    def doubt(self, length: float) -> str:
        """Say what no bar of this length does; empty where one does."""
        if not self.force or not self.deflection:
            return "a force or a deflection of zero"
        least = 2 / 3 * (self.slope or 0.0) * length
        if self.deflection < (1 - _MEASURED) * least:
            return f"{self.deflection * 1e3:.4g} mm under a slope that bends a bar of {length * 1e3:g} mm by {least * 1e3:.4g} mm at least"
        return ""


class Measured(Bending):
    """How a link gave under a load at its far end, its root clamped: the uniform bar that gives so stands for it.

    force, deflection, slope   across the link, in the plane that a lifting joint bends (along the section's height)
    sideways                   the same along the joint's axis; left out: alike
    torque, twist              about the link; left out: rigid there. Along the link it is rigid
    """

    sideways: Bending | None = None
    torque: TorqueAmount | None = None
    twist: AngleAmount | None = None
    scatter: Share = 0.0

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if (self.torque is None) != (self.twist is None) or self.torque == 0:
            raise refuse_section("a torque without a twist, or the reverse", "both or neither", 'torque = "20 N m", twist = "3 arcmin"')
        return self

    def give(self, length: float) -> Floats:
        """Give what each section of the equal bar gives (6, 6), in the beam's axes."""
        out = np.zeros((6, 6))
        out[1, 1], out[5, 5] = self.gives(length)
        out[2, 2], out[4, 4] = (self.sideways or self).gives(length)
        if self.torque and self.twist is not None:
            out[0, 0] = self.twist / (self.torque * length)
        return out
