"""Closed forms of contacts, cycloidal stages and bearings that the tests compare the solvers with.

Sources as in the modules of `lostmotion.laws`: K. Johnson, Contact Mechanics (line contact); M.
Lehmann, TU München 1976, and S. Malhotra,
M. Parameswaran, Mech. Mach. Theory 18 (1983) 491 (cycloidal stage with equal springs); T. Harris,
Rolling Bearing Analysis (load distribution).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import lambertw

from lostmotion.laws.contact import (
    LEAST_LOGARITHM,
    PALMGREN_EXPONENT,
    johnson_scale,
    palmgren_factor,
)
from lostmotion.laws.cycloid.geometry import arms

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.stage import Stage


def approach(
    law: str, force: np.ndarray, width: float, radius: np.ndarray, modulus: float
) -> np.ndarray:
    """Return the approach (m) of two cylinders under forces (N); NaN where a force is beyond
    Johnson's law.
    """
    if law == "palmgren":
        return palmgren_factor(width) * force**PALMGREN_EXPONENT
    logarithm = np.log(johnson_scale(width, radius, modulus) / np.where(force > 0, force, 1.0))
    valid = (logarithm >= LEAST_LOGARITHM) | (force == 0)
    return np.where(valid, force * logarithm / (math.pi * modulus * width), np.nan)


def contact_force(
    law: str, approached: np.ndarray, width: float, radius: np.ndarray, modulus: float
) -> np.ndarray:
    """Return the force (N) at an approach (m), the inverse of `approach`; zero where the cylinders
    do not touch, NaN beyond Johnson's law.
    """
    delta = np.maximum(approached, 0.0)
    if law == "palmgren":
        return (delta / palmgren_factor(width)) ** (1 / PALMGREN_EXPONENT)
    compliance = 1 / (math.pi * modulus * width)
    share = delta / (compliance * johnson_scale(width, radius, modulus))
    largest = LEAST_LOGARITHM * math.exp(-LEAST_LOGARITHM) * (1 + 1e-9)
    logarithm = -np.real(lambertw(-np.where(share > 0, np.minimum(share, largest), 1e-3), -1))
    return np.where(share <= largest, delta / (compliance * logarithm), np.nan)


def half_width(load: np.ndarray, radius: float, modulus: float) -> np.ndarray:
    """Return the half-width (m) of the contact under a load per width (N/m): sqrt(4 p Req/(pi E*)).
    Johnson (4.43).
    """
    return np.sqrt(4 * load * radius / (math.pi * modulus))


def largest_force(stage: Stage, torque: float) -> float:
    """Return F_max = 4 T/(e z N) (N): equal springs, no gaps, F_i = F_max l_i/(e z)."""
    return 4 * torque / (stage.planet_pitch_radius * stage.pins)


def mesh_stiffness(stage: Stage, contact: float, discs: int = 1) -> float:
    """Return n_d k_c (e z)^2 N/4 (N m/rad): equal contacts of stiffness k_c (N/m), no gaps, rigid
    bearings.
    """
    return discs * contact * stage.planet_pitch_radius**2 * stage.pins / 4


def averaged_error(stage: Stage, theta: np.ndarray, gap: np.ndarray) -> np.ndarray:
    """Return the rotation sum(l g)/sum(l^2) (rad) that gaps (..., N) allow while all flanks with l
    > 0 carry load on equal springs.
    """
    arm = np.maximum(arms(stage, theta), 0.0)
    return (arm * gap).sum(axis=-1) / (arm**2).sum(axis=-1)


def element_loads(
    shift: float | np.ndarray,
    clearance: float | np.ndarray,
    stiffness: float,
    exponent: float,
    angles: np.ndarray,
) -> np.ndarray:
    """Return the loads (..., element; N) of rolling elements at `angles` (rad) from a radial shift
    (m) in a diametral clearance (m).
    """
    return (
        stiffness
        * np.maximum(
            np.multiply.outer(shift, np.cos(angles)) - np.asarray(clearance)[..., None] / 2, 0.0
        )
        ** exponent
    )
