"""Equilibrium of a shaft on rolling bearings under any load: radial and axial shift and tilt, five
degrees of freedom.

Contacts are unilateral: they push with Q = K delta^n and do not pull. The closure delta of a
contact is a convex function of the shaft's displacement (a distance for balls, linear for rollers),
so the stored energy is convex too. So there is one equilibrium, found by Newton's method with a
line search. Valid for rigid rings and shaft, low speed and no friction; cages and ribs carry no
load.

Frame: z along the shaft, right-handed. A displacement is (x, y, z, about x, about y) of the shaft
relative to the housing, m and rad; a load (Fx, Fy, Fz, Mx, My) is what the shaft exerts on the
bearings, N and N m, both about the frame's origin.

Source: ISO/TS 16281:2008, 4.2 and 4.3; T. Harris, Rolling Bearing Analysis, 4th ed., chapter 7. In
the energy's own form the moment of a ball acts at the centres of the inner groove, where ISO/TS
16281 uses half the pitch diameter.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from lostmotion.laws.rolling.rows import RowSeat
    from lostmotion.spatial import Floats

    Flags = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class ShaftEquilibrium:
    """The equilibrium of a shaft.

    displacement  (case, 5) m and rad; NaN where no equilibrium was found
    loads         loads on the elements of each row (case, element), N
    residual      (case,) unbalanced load over the load, with moments over half the largest pitch
                  diameter: 1e-11, or rounding
                  where preload or stiffness is many times the load
    converged     (case,) false where the bearings cannot support the load
    stiffness     (case, 5, 5) derivative of the load at the displacement, N/m, N/rad, N m/rad
    """

    displacement: Floats
    loads: tuple[Floats, ...]
    residual: Floats
    converged: Flags
    stiffness: Floats


def shaft_equilibrium(
    seats: Sequence[RowSeat], load: ArrayLike, clearance: Floats | float = 0.0
) -> ShaftEquilibrium:
    """Return the displacement of a shaft on these rows under loads, and the load on each element.

    load       (case, 5) N and N m
    clearance  (case,), or one for all cases: radial internal clearance of every row, m, diametral;
               negative for preload

    In directions with no load and no stiffness the shaft stays at the centre. A case without
    equilibrium is NaN and not `converged`. Raises ValueError for loads of another shape or not
    finite.
    """
    from lostmotion.laws.rolling.equilibrium_kernel import solve_cases

    loads = np.asarray(load, dtype=float)
    if loads.ndim != 2 or loads.shape[1] != 5 or not np.isfinite(loads).all():  # noqa: PLR2004 - case by five
        raise ValueError(f"loads must be finite and of shape (case, 5), not {loads.shape}")
    cases = len(loads)
    play = np.array(np.broadcast_to(np.asarray(clearance, dtype=float), cases))
    # Tilts are expressed in metres at half the largest pitch diameter, so that all five components
    # have the same unit.
    reach = max(seat.row.pitch_diameter for seat in seats) / 2
    scale = np.array([1, 1, 1, 1 / reach, 1 / reach])
    wanted = loads * scale
    ends = np.cumsum([0] + [seat.row.count for seat in seats])
    contacts = np.concatenate([seat.contacts for seat in seats])
    contacts["element"] += np.repeat(ends[:-1], [len(seat.contacts) for seat in seats])
    contacts["across"] *= scale
    contacts["along"] *= scale
    displacement, stiffness, each = (
        np.empty((cases, 5)),
        np.empty((cases, 5, 5)),
        np.empty((cases, ends[-1])),
    )
    residual, converged = np.empty(cases), np.empty(cases, dtype=bool)
    solve_cases(contacts, play, wanted, reach, displacement, stiffness, each, residual, converged)
    size = np.linalg.norm(wanted, axis=1)
    return ShaftEquilibrium(
        displacement * scale,
        tuple(np.split(each, ends[1:-1], axis=1)),
        residual / np.where(size > 0, size, 1.0),
        converged,
        stiffness / (scale[:, None] * scale),
    )
