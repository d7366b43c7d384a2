"""The method of the paper as it stands, in plain NumPy, each formula as printed and as it must
read.

S. Strutynskyi, R. Semenchuk, "Investigation of the accuracy of the manipulator of the robotic
complex constructed on the basis of cycloidal transmission", Technology Audit and Production
Reserves 4/1(60), 2021, doi:10.15587/2706-5448.2021.237326 (CC BY).

Nothing here uses lostmotion: it is the independent half of the comparison in run.py. Units are SI;
`reading` is "printed" for a formula letter by letter and "corrected" for what it must mean. Joint
values are (sample, 4): omega, q1, q2, q3; angle errors (sample, 4): Delta O, A, B, C.

What each formula says, and what is wrong with it:
(1)  Z is printed with the cosines of X: every point would lie on a cone. It must have sines.
(2)  Mx counts the weight at D twice, where the second must be m_B h2, and ends in m2 (h2 + h3 +
     h4/2), which must be m2 h2/2.
     Mz has m_D z2, which must be m_B z2. The "masses" are weights, N.
(3)  sqrt(Mx^2 + Mz^2): no moment on a level chassis, but the largest one over all tilts of the
     chassis in the plane of the arm.
(5)  Is printed with "<="; E I y'' = M is an equation.
(6), (7)  Add lengths to pure numbers, and N m^2 to lengths: their value depends on the units that
          one works in.
6.3  A strain, 0.00066, is read as an angle in radians; the rounded parts add to 3.26177', the
     unrounded ones to the 3.27' that is stated.
(8)  Y has sin(omega + Delta A), which must be Delta O; Z has cosines again. One and the same Delta
     o is added to X and Y.
(9)  The total deviation; the bracket holds the disturbed coordinate minus the coordinate of (1).
     The disturbed coordinates are printed as "Delta X", as if they were errors already.
"""

from __future__ import annotations

import math
import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from collections.abc import Callable

Floats = NDArray[np.float64]
Reading = Literal["printed", "corrected"]

ARCMIN = math.pi / 10800
STANDARD_GRAVITY = 9.80665

# What the paper prints.
STRAIN = 0.00066
TRANSMISSION_ARCMIN = 2.26
LINK_ARCMIN = 0.00177
BACKLASH_ARCMIN = 0.5
MANUFACTURE_ARCMIN = 0.5
JOINT_ARCMIN = 3.27
CLEARANCE = 60e-6
OFFSET = 30e-6
SLOPE_LIMIT_ARCMIN = 0.5
DEFLECTION_LIMIT = 1 / 2500
LARGEST = 0.91e-3
SMALLEST = 3.625e-2 * 1e-3


@dataclass(frozen=True)
class ZArm:
    """The arm of Fig. 1: link lengths OA, AB, BC, CD (m), the fixed inclination q0 of OA (rad), and
    O at (s, 0, R) (m).

    ranges (4, 2) rad of omega, q1, q2, q3. None of these numbers is printed by the paper.
    """

    lengths: tuple[float, float, float, float] = (0.3, 0.4, 0.4, 0.2)
    q0: float = math.radians(45)
    s: float = 0.1
    height: float = 0.3
    ranges_deg: tuple[tuple[float, float], ...] = ((-180, 180), (30, 180), (30, 180), (90, 270))

    @property
    def ranges(self) -> Floats:
        """Return the joint ranges in rad (4, 2)."""
        return np.radians(np.array(self.ranges_deg, dtype=float))


@dataclass(frozen=True)
class Weights:
    """Weights in N: links AB, BC, CD, nodes B, C, D, and the payload. The paper prints none of
    them.
    """

    link2: float = 1.2 * STANDARD_GRAVITY
    link3: float = 1.2 * STANDARD_GRAVITY
    link4: float = 0.6 * STANDARD_GRAVITY
    node_b: float = 3.0 * STANDARD_GRAVITY
    node_c: float = 2.0 * STANDARD_GRAVITY
    node_d: float = 1.0 * STANDARD_GRAVITY
    payload: float = 5.0 * STANDARD_GRAVITY


def directions(arm: ZArm, q: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the directions of AB, BC and CD, measured up from the horizontal (rad), for q (sample,
    4). OA points along q0.

    phi2 = q0 - q1 + pi, phi3 = q0 - q1 + q2, phi4 = q0 - q1 + q2 + q3 + pi: the signs in front of
    L2 and L4 in (1) are the half turns.
    """
    phi2 = arm.q0 - q[:, 1] + math.pi
    phi3 = phi2 + q[:, 2] - math.pi
    return phi2, phi3, phi3 + q[:, 3] + math.pi


def position(arm: ZArm, q: Floats, reading: Reading = "corrected") -> Floats:
    """Return the position of D in the chassis frame (sample, 3), m. Eq. (1)."""
    return _point(arm, q, q[:, 0], reading)


def _point(arm: ZArm, q: Floats, omega_in_y: Floats, reading: Reading) -> Floats:
    l1, l2, l3, l4 = arm.lengths
    phi2, phi3, phi4 = directions(arm, q)
    out = l1 * math.cos(arm.q0) + l2 * np.cos(phi2) + l3 * np.cos(phi3) + l4 * np.cos(phi4)
    up = (
        out
        if reading == "printed"
        else l1 * math.sin(arm.q0) + l2 * np.sin(phi2) + l3 * np.sin(phi3) + l4 * np.sin(phi4)
    )
    return np.stack(
        [np.cos(q[:, 0]) * out + arm.s, np.sin(omega_in_y) * out, up + arm.height], axis=1
    )


def displaced(
    arm: ZArm, q: Floats, angles: Floats, offsets: Floats, reading: Reading = "corrected"
) -> Floats:
    """Return the position of D (sample, 3), m, with these angle errors (sample, 4) and bearing
    offsets o, a, b, c (sample, 4). Eq. (8).

    Offsets as (8) adds them, along the chassis: the same Delta o in X and in Y, Delta a + Delta b +
    Delta c in Z. The printed reading turns Y by Delta A in place of Delta O.
    """
    off = q + angles
    turned = q[:, 0] + angles[:, 1 if reading == "printed" else 0]
    point = _point(arm, off, turned, reading)
    point[:, :2] += offsets[:, :1]
    point[:, 2] += offsets[:, 1] + offsets[:, 2] + offsets[:, 3]
    return point


def displaced_across_axes(arm: ZArm, q: Floats, angles: Floats, offsets: Floats) -> Floats:
    """Return the position of D (sample, 3), m, with the bearing offsets across each joint's axis.
    Not in the paper.

    Offsets (sample, 4, 2), m: at O along and across the arm's plane, horizontally; at A, B and C in
    the plane, along the joint's link and across it. Corrected eq. (8) in all else.
    """
    off = q + angles
    point = _point(arm, off, off[:, 0], "corrected")
    out, aside, up = offsets[:, 0, 0].copy(), offsets[:, 0, 1], np.zeros(len(q))
    for k, phi in enumerate(directions(arm, off), 1):
        along, across = offsets[:, k, 0], offsets[:, k, 1]
        out += along * np.cos(phi) - across * np.sin(phi)
        up += along * np.sin(phi) + across * np.cos(phi)
    cos, sin = np.cos(off[:, 0]), np.sin(off[:, 0])
    return point + np.stack([cos * out - sin * aside, sin * out + cos * aside, up], axis=1)


def deviation(disturbed: Floats, undisturbed: Floats) -> Floats:
    """Return the distances of two points (sample,), m. Eq. (9)."""
    apart = disturbed - undisturbed
    return np.sqrt(np.einsum("ij,ij->i", apart, apart))


def cut_normal(rng: np.random.Generator, shape: tuple[int, ...]) -> Floats:
    """Draw N(0, 1); whatever falls outside +-3 is drawn again."""
    found = rng.standard_normal(shape)
    flat = found.reshape(-1)
    while (again := np.flatnonzero(np.abs(flat) > 3)).size:
        flat[again] = rng.standard_normal(again.size)
    return found


def workspace_poses(arm: ZArm, rng: np.random.Generator, samples: int) -> Floats:
    """Return the poses of the paper's Monte Carlo (sample, 4), rad. Normal around mid-range, sigma
    = range/6, cut at the range.
    """
    low, high = arm.ranges.T
    return (low + high) / 2 + (high - low) / 6 * cut_normal(rng, (samples, 4))


def angle_errors(rng: np.random.Generator, samples: int, largest: float) -> Floats:
    """Return the drawn angle errors (sample, 4), rad. "Normal law, from zero to maximum": mean
    max/2, sigma max/6, cut to 0..max.
    """
    return largest / 2 + largest / 6 * cut_normal(rng, (samples, 4))


def deviations(
    arm: ZArm,
    samples: int,
    seed: int,
    reading: Reading = "corrected",
    *,
    largest_angle: float = JOINT_ARCMIN * ARCMIN,
    offset: float = OFFSET,
) -> Floats:
    """Return the deviations (sample,), m, of the paper's Monte Carlo. Eqs. (1), (8), (9); a fresh
    pose for every sample.

    A longer run begins with a shorter one's samples. `offset` is the +- limit of the bearing
    offsets, uniform.
    """

    def some(rng: np.random.Generator) -> Floats:
        q = workspace_poses(arm, rng, _CHUNK)
        angles = angle_errors(rng, _CHUNK, largest_angle)
        offsets = rng.uniform(-offset, offset, (_CHUNK, 4))
        return deviation(displaced(arm, q, angles, offsets, reading), position(arm, q, reading))

    return _gather(some, samples, seed)


def deviations_across_axes(
    arm: ZArm,
    samples: int,
    seed: int,
    *,
    largest_angle: float = JOINT_ARCMIN * ARCMIN,
    offset: float = OFFSET,
) -> Floats:
    """Return the deviations (sample,), m, with the offsets across the joints' axes. As `deviations`
    in all else.
    """

    def some(rng: np.random.Generator) -> Floats:
        q = workspace_poses(arm, rng, _CHUNK)
        angles = angle_errors(rng, _CHUNK, largest_angle)
        offsets = rng.uniform(-offset, offset, (_CHUNK, 4, 2))
        return deviation(displaced_across_axes(arm, q, angles, offsets), position(arm, q))

    return _gather(some, samples, seed)


_CHUNK = 20_000


def _gather(some: Callable[[np.random.Generator], Floats], samples: int, seed: int) -> Floats:
    """Draw chunk by chunk, each from its own generator, on as many threads as there are
    processors.
    """
    found = np.empty(samples)

    def fill(k: int) -> None:
        part = found[k * _CHUNK : (k + 1) * _CHUNK]
        part[:] = some(np.random.default_rng([seed, k]))[: len(part)]

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for _ in pool.map(fill, range(-(-samples // _CHUNK))):
            pass
    return found


def quantile_with_interval(ordered: Floats, level: float) -> tuple[float, float, float]:
    """Return the quantile `level` of independent values with its 95 % confidence interval. All in
    m.

    `ordered` (sample,) must rise. Order statistics, free of any law (W. Conover, Practical
    Nonparametric Statistics, 1999, 3.2).
    """
    count = len(ordered)
    half = 1.96 * math.sqrt(level * (1 - level) * count)
    ranks = (level * count, level * count - half, level * count + half)
    value, low, high = (
        float(ordered[min(max(math.ceil(rank) - 1, 0), count - 1)]) for rank in ranks
    )
    return value, low, high


def projections(arm: ZArm, q: Floats) -> tuple[Floats, Floats]:
    """Return the lengths of AB, BC, CD along X and along Z (3, sample), m. z counts up; the paper
    draws z4 down, so its z4 is minus this one.
    """
    length = np.array(arm.lengths[1:])[:, None]
    phi = np.stack(directions(arm, q))
    return length * np.cos(phi), length * np.sin(phi)


def static_moment(
    arm: ZArm, weights: Weights, q: Floats, reading: Reading = "corrected"
) -> tuple[Floats, Floats, Floats]:
    """Return the moments at node A (sample,), N m. Mx and Mz by eq. (2), and the total by eq. (3).

    On a level chassis gravity makes Mx alone. The total is the largest over all tilts of the
    chassis in the plane of the arm.
    """
    (h2, h3, h4), (z2, z3, z4_up) = projections(arm, q)
    z4 = -z4_up
    w, end = weights, weights.payload + weights.node_d
    mx = (
        end * (h4 + h3 + h2)
        + w.link4 * (h4 / 2 + h3 + h2)
        + w.node_c * (h3 + h2)
        + w.link3 * (h3 / 2 + h2)
    )
    mz = (
        end * (z2 + z3 - z4)
        + w.link4 * (z3 + z2 - z4 / 2)
        + w.node_c * (z3 + z2)
        + w.link3 * (z3 / 2 + z2)
    )
    if reading == "printed":
        mx = mx + w.node_d * (h2 + h3 + h4) + w.link2 * (h2 + h3 + h4 / 2)
        mz = mz + w.node_d * z2 + w.link2 * z2 / 2
    else:
        mx = mx + w.node_b * h2 + w.link2 * h2 / 2
        mz = mz + w.node_b * z2 + w.link2 * z2 / 2
    return mx, mz, np.hypot(mx, mz)


def cantilever_slope(
    length: float, stiffness: float, force: float, moment: float, own_weight: float
) -> float:
    """Return the slope (rad) of a link's tip. What (6) must say: theta = (F l^2/2 + M l + W l^2/6)
    / (E I).

    force (N) and moment (N m) at the tip and the link's own weight (N, spread evenly), as they act
    across the link; stiffness = E I, N m^2.
    """
    return (force * length**2 / 2 + moment * length + own_weight * length**2 / 6) / stiffness


def cantilever_deflection(
    length: float, stiffness: float, force: float, moment: float, own_weight: float
) -> float:
    """Return the deflection (m) of a link's tip. What (7) must say: delta = (F l^3/3 + M l^2/2 + W
    l^3/8) / (E I). Arguments as for the slope.
    """
    return (force * length**3 / 3 + moment * length**2 / 2 + own_weight * length**3 / 8) / stiffness


def stiffness_for_limits(
    length: float, force: float, moment: float, own_weight: float
) -> tuple[float, float]:
    """Return the E I (N m^2) at the slope limit of condition (4), and at the deflection limit. The
    larger of the two is needed.
    """
    slope = cantilever_slope(length, 1.0, force, moment, own_weight) / (SLOPE_LIMIT_ARCMIN * ARCMIN)
    deflection = cantilever_deflection(length, 1.0, force, moment, own_weight) / (
        length * DEFLECTION_LIMIT
    )
    return slope, deflection


def slope_as_printed(
    *,
    length: float,
    stiffness: float,
    reaction: float,
    node_weight: float,
    own_weight: float,
    moment: float,
    next_length: float,
) -> float:
    """Evaluate the right side of (6) for a level arm: h3 = `length`, h4 = `next_length`.

    No angle: the first three terms are lengths and the last a pure number, so the value depends on
    the unit of length that the arguments are in.
    """
    weights = (
        -reaction * length**3 / 2 + node_weight * length**3 / 2 + own_weight * (length**3 / 2) / 2
    )
    return (weights - moment * next_length) / stiffness


def sum_of_maxima(transmission_arcmin: float) -> float:
    """Return the largest angle error per joint, arcmin, of section 6.3: link, transmission,
    backlash and manufacture, added.
    """
    return LINK_ARCMIN + transmission_arcmin + BACKLASH_ARCMIN + MANUFACTURE_ARCMIN


def strain_read_as_angle(strain: float = STRAIN) -> float:
    """Return the angle, arcmin, of this number of radians. What the paper does with a strain; a
    strain is no rotation.
    """
    return strain / ARCMIN
