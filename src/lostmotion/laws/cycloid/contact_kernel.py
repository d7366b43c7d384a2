"""Kernel of the load sharing: one disc, many unilateral contacts, solved case by case. Compiled
once by Numba and cached; single-threaded.

The normals' component across the line of centres is the arm over the planet's pitch radius r: n_y =
l/r. So a contact depends on x and v = y + r theta alone, and y follows directly from the balance
across the line of centres. Two unknowns remain. The energy is convex in them, so Newton's method
with a line search on the slope of the energy converges to its only minimum.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from lostmotion.compiled import fused, fused_part
from lostmotion.laws.contact import LEAST_LOGARITHM, PALMGREN_EXPONENT

LINEAR, LOGARITHMIC, POWER = range(3)
# Columns of the results per case.
ROTATION, SOFTNESS, BEARING, RESIDUAL, LOADED = range(5)
COLUMNS: Final = 5
TOLERANCE: Final = 1e-9  # of the torque
_GOAL: Final = 1e-12
_STALLED: Final = 1e-10  # accepted where a step no longer improves it: rounding
# of the sum of all forces: the accuracy limit of the balance, even where it is large compared with
# a small torque
_ROUNDING: Final = 2e-16
_TOUCH: Final = 1e-9  # of T/r: a smaller force is rounding
# contacts with arms below this share of the longest are ignored in the start value
_SHORT: Final = 0.05
# of the stiffness along the line of centres: rounding of the arm of a contact on that line
_ACROSS: Final = 1e-20
_STEPS: Final = 200
_HALVINGS: Final = 30
_LOWEST: Final = LEAST_LOGARITHM
_POWER: Final = PALMGREN_EXPONENT


@fused_part
def _push(law, delta, soft, scale):
    """Return force (N) and stiffness (N/m) at an approach delta > 0 (m): delta = F soft | soft F
    (scale - ln F) | soft F^0.9 + scale F.
    """
    if law == LINEAR:
        return delta / soft, 1.0 / soft
    if law == LOGARITHMIC:
        # u - ln u = ln(soft/delta) + scale, with u = scale - ln F
        height = np.log(soft / delta) + scale
        lowest = _LOWEST - np.log(_LOWEST)
        # beyond the range of the law: continued linearly, and the result is marked as not converged
        if height <= lowest:
            edge = np.exp(scale - _LOWEST)
            stiff = 1.0 / (soft * (_LOWEST - 1.0))
            return edge + (delta - soft * edge * _LOWEST) * stiff, stiff
        # u = start + correction: ln u within 1.1e-3 by a rational fit for u from 2 to 70, then
        # Newton's step with four terms of its series
        top = 2.65481 + height * (-1.66045 + height * (-1.60255 - height * 0.0377124))
        u = height + top / (1.0 + height * (-2.64817 + height * (-0.521448 - height * 0.0061659)))
        slope = 1.0 / (u - 1.0)
        t = (np.log(u) + height - u) * slope
        s = t * slope
        u *= 1.0 + t * (
            1.0
            - 0.5 * s
            + s * s * (0.5 - 0.625 * s)
            + t * s * (1.0 / 3.0 - 0.25 * t - 5.0 / 6.0 * s)
        )
        both = 1.0 / (soft * u * (u - 1.0))
        return delta * (u - 1.0) * both, u * both
    force = (delta / soft) ** (1.0 / _POWER)
    if scale > 0.0:
        force = 0.5 * min(force, delta / scale)
        if force == 0.0:  # an approach so small that its power underflows
            return 0.0, 0.0
        for _ in range(12):
            bending = soft * force**_POWER
            step = (delta - bending - scale * force) / (_POWER * bending / force + scale)
            force += step
            if abs(step) < 1e-14 * force:
                break
    return force, 1.0 / (_POWER * soft * force ** (_POWER - 1.0) + scale)


@fused_part
def _balance(law, x, v, side, across, arm, gap, soft, scale, sums, forces):
    """Write the forces at x, v, and their sums over all contacts to `sums`: F n_x, F a, F, k n_x^2,
    k n_x a, k a^2.
    """
    fx = fv = total = kxx = kxv = kvv = 0.0
    for i in range(arm.shape[0]):
        a = side * arm[i]
        delta = across[i] * x + a * v - gap[i]
        force = 0.0
        if delta > 0.0:
            force, stiff = _push(law, delta, soft[i], scale[i])
            n = across[i]
            fx += force * n
            fv += force * a
            total += force
            kxx += stiff * n * n
            kxv += stiff * n * a
            kvv += stiff * a * a
        forces[i] = force
    sums[0], sums[1], sums[2], sums[3], sums[4], sums[5] = fx, fv, total, kxx, kxv, kvv


@fused_part
def _start(law, pull, x, side, across, arm, gap, soft, scale):
    """Return a start value of v: the mean of the driving gaps, at least the first contact, plus the
    approach under an equal share of the load.
    """
    first, weight, weighted, best, at = np.inf, 0.0, 0.0, 0.0, 0
    for i in range(arm.shape[0]):
        a = side * arm[i]
        if a > _SHORT:
            room = gap[i] - across[i] * x
            first = min(first, room / a)
            weight += a * a
            weighted += a * room
            if a > best:
                best, at = a, i
    force = pull / max(weight, 1e-300)
    if law == LINEAR:
        more = soft[at] * force
    elif law == LOGARITHMIC:
        more = soft[at] * force * max(scale[at] - np.log(max(force, 1e-300)), _LOWEST)
    else:
        more = soft[at] * force**_POWER + scale[at] * force
    return max(first, weighted / max(weight, 1e-300)) + more


@fused_part
def _equilibrium(law, pull, push, stiffness, side, across, arm, gap, soft, scale, sums, forces):
    """Return v at which the contacts balance the pull (T/r, positive) and the push along the line
    of centres, and the residual.
    """
    x, v = 0.0, 0.0
    rigid = not np.isfinite(stiffness)
    spring = 0.0 if rigid else stiffness
    if pull > 0.0:
        v = _start(law, pull, x, side, across, arm, gap, soft, scale)
    _balance(law, x, v, side, across, arm, gap, soft, scale, sums, forces)
    unit = pull if pull > 0.0 else sums[2] + abs(push)
    if unit == 0.0:
        return v, 0.0
    best = np.inf
    for _ in range(_STEPS):
        rx = 0.0 if rigid else push - spring * x - sums[0]
        rv = pull - sums[1]
        error = max(abs(rx), abs(rv)) / unit
        if (
            error <= _GOAL
            or (error <= _STALLED and error >= 0.5 * best)
            or error * unit <= _ROUNDING * sums[2]
        ):
            return v, error
        best = min(best, error)
        kxx, kxv, kvv = sums[3] + spring, sums[4], sums[5]
        if rigid:
            dx, dv = 0.0, rv / kvv if kvv > 0.0 else 0.0
        else:
            determinant = kxx * kvv - kxv * kxv
            if determinant > 1e-14 * kxx * kvv:
                dx, dv = (kvv * rx - kxv * rv) / determinant, (kxx * rv - kxv * rx) / determinant
            else:
                dx, dv = rx / kxx, 0.0
        # no driving flank is in contact: move slightly beyond the first contact
        if kvv <= _ACROSS * kxx:
            dx, dv = (
                0.0,
                max(
                    _start(law, pull, x, side, across, arm, gap, soft, scale) - v,
                    1e-9 * (1.0 + abs(v)),
                ),
            )
        slope = rx * dx + rv * dv
        share = tried = 1.0
        for _ in range(_HALVINGS):
            tried = share
            _balance(
                law,
                x + share * dx,
                v + share * dv,
                side,
                across,
                arm,
                gap,
                soft,
                scale,
                sums,
                forces,
            )
            there = (0.0 if rigid else (push - spring * (x + share * dx) - sums[0]) * dx) + (
                pull - sums[1]
            ) * dv
            if there >= -0.5 * abs(slope):
                break
            share *= max(abs(slope) / (abs(slope) - there), 0.1)
        x += tried * dx
        v += tried * dv
    rx = 0.0 if rigid else push - spring * x - sums[0]
    return v, max(abs(rx), abs(pull - sums[1])) / unit


@fused
def solve_cases(
    first,  # case, counted (torque * places + place) * draws + draw
    last,  # one past the last case
    law,
    radius,  # of the planet's pitch circle, m
    thrust,  # force along the line of centres per torque, 1/m
    torque,  # (torque,)
    places,  # (place,) number of the crank angle
    across,  # (crank, N) n_x
    arm,  # (crank, N) n_y = l/r
    soft,  # (crank, N) coefficients of the law
    scale,  # (crank, N)
    largest,  # (crank, N) force at which the law ends
    gap,  # (place, draw, N), or 1 in either of the first two
    stiffness,  # (torque, draw) of the bearing, N/m
    out,  # out (case, COLUMNS)
    forces,  # out (case, N)
):
    """Solve a range of cases. Cases that do not converge are NaN."""
    count, draws = places.shape[0], stiffness.shape[1]
    sums = np.empty(6)
    for case in range(first, last):
        draw = case % draws
        place = case // draws % count
        c = places[place]
        load = case // draws // count
        moment = torque[load]
        side = -1.0 if moment < 0.0 else 1.0
        pull = abs(moment) / radius
        push = -thrust * abs(moment)
        k = stiffness[load, draw]
        g = gap[place % gap.shape[0], draw % gap.shape[1]]
        v, error = _equilibrium(
            law, pull, push, k, side, across[c], arm[c], g, soft[c], scale[c], sums, forces[case]
        )
        lobes, valid = 0, error <= TOLERANCE
        for i in range(arm.shape[1]):
            force = forces[case, i]
            lobes += force > _TOUCH * pull
            valid = valid and force <= largest[c, i]
        # d(theta)/d(torque): compliance of the contacts to push and pull, plus that of the bearing,
        # over r
        kxx, kxv, kvv = sums[3] + k, sums[4], sums[5]
        soft_v = (
            (kxx + kxv * thrust * radius) / (kxx * kvv - kxv * kxv) + 1.0 / k
            if np.isfinite(k)
            else 1.0 / kvv
        )
        y = -pull / k
        out[case, ROTATION] = side * (v - y) / radius
        out[case, SOFTNESS] = soft_v / (radius * radius)
        out[case, BEARING] = np.sqrt((sums[0] - push) ** 2 + sums[1] * sums[1])
        out[case, RESIDUAL] = error
        out[case, LOADED] = lobes
        if not valid:
            out[case, :RESIDUAL] = np.nan
            forces[case, :] = np.nan
