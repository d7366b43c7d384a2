"""Equations of the load sharing on elastic bodies, compiled: their residual, their factorised
Jacobian, and starting values of Newton's method. The unknowns are those of `elastic_kernel`.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from lostmotion.compiled import fused_part
from lostmotion.laws.contact import LEAST_LOGARITHM, PALMGREN_EXPONENT
from lostmotion.laws.cycloid.contact_kernel import (
    LINEAR,
    LOGARITHMIC,
)

STALLED: Final = 1e-10  # accepted where a step no longer improves it: rounding
# of the sum of all forces: the accuracy limit of the balance, even where it is large compared with
# a small torque
ROUNDING: Final = 4e-16
# contacts with arms below this share of the longest are ignored in the start value
_SHORT: Final = 0.05
_LOWEST: Final = LEAST_LOGARITHM
_POWER: Final = PALMGREN_EXPONENT
# Sums over all contacts.
ALONG, AROUND, TOTAL, LENGTH, LARGEST = range(5)


@fused_part
def _approach(law, force, soft, scale):
    """Return approach (m) and compliance (m/N) under a force > 0 (N): F soft | soft F (scale - ln
    F) | soft F^0.9 + scale F.
    """
    if law == LINEAR:
        return force * soft, soft
    if law == LOGARITHMIC:
        height = scale - np.log(force)
        if height >= _LOWEST:
            return soft * force * height, soft * (height - 1.0)
        # beyond the range of the law: continued linearly, and the result is marked as not converged
        edge = np.exp(scale - _LOWEST)
        return soft * (edge * _LOWEST + (force - edge) * (_LOWEST - 1.0)), soft * (_LOWEST - 1.0)
    bending = soft * force**_POWER
    return bending + scale * force, _POWER * bending / force + scale


@fused_part
def left_over(
    law, x, v, state, compliance, side, across, arm, gap, soft, scale, flexible, moved, left, sums
):
    """Write the displacements of the bodies, what remains of the equation of each contact (m), and
    the sums over the contacts.
    """
    count = arm.shape[0]
    along = around = total = length = largest = 0.0
    moved[:] = 0.0
    for j in range(count):
        force = state[j]
        if force > 0.0:
            along += force * across[j]
            around += force * side * arm[j]
            total += force
            for i in range(count):
                moved[i] += flexible[j, i] * force
    for i in range(count):
        force = state[i]
        approach = (
            _approach(law, force, soft[i], scale[i])[0] if force > 0.0 else compliance * force
        )
        rigid = across[i] * x + side * arm[i] * v - gap[i]
        left[i] = rigid - approach - moved[i]
        length = max(length, abs(left[i]))
        largest = max(largest, abs(arm[i] * v) + abs(gap[i]) + abs(moved[i]))
    sums[ALONG], sums[AROUND], sums[TOTAL], sums[LENGTH], sums[LARGEST] = (
        along,
        around,
        total,
        length,
        largest,
    )


@fused_part
def factorise(law, state, side, across, arm, soft, scale, flexible, loaded, matrix, columns, left):
    """Factorise the compliance matrix of the loaded contacts; write its inverse times left, n_x and
    arm to the columns. Returns their number.
    """
    count = 0
    for i in range(arm.shape[0]):
        if state[i] > 0.0:
            loaded[count] = i
            count += 1
    for p in range(count):
        i = loaded[p]
        for q in range(p):
            matrix[p, q] = flexible[i, loaded[q]]
        matrix[p, p] = flexible[i, i] + _approach(law, state[i], soft[i], scale[i])[1]
        columns[p, 0], columns[p, 1], columns[p, 2] = left[i], across[i], side * arm[i]
    # L D L', in place, with L below the diagonal
    for p in range(count):
        for q in range(p):
            entry = matrix[p, q]
            for r in range(q):
                entry -= matrix[p, r] * matrix[q, r] * matrix[r, r]
            matrix[p, q] = entry / matrix[q, q]
        for q in range(p):
            matrix[p, p] -= matrix[p, q] * matrix[p, q] * matrix[q, q]
            for c in range(3):
                columns[p, c] -= matrix[p, q] * columns[q, c]
    for p in range(count):
        for c in range(3):
            columns[p, c] /= matrix[p, p]
    for p in range(count - 1, -1, -1):
        for q in range(p + 1, count):
            for c in range(3):
                columns[p, c] -= matrix[q, p] * columns[q, c]
    return count


@fused_part
def start(law, pull, side, arm, gap, soft, scale, flexible, state, moved):
    """Write a start value of s for each contact, from shares of the load in proportion to the arms.
    Returns v and the compliance c.
    """
    count = arm.shape[0]
    weight, longest = 0.0, 0
    for i in range(count):
        if side * arm[i] > _SHORT:
            weight += arm[i] * arm[i]
            if side * arm[i] > side * arm[longest]:
                longest = i
    unit = pull / max(weight, 1e-300)
    compliance = 0.0
    if pull > 0.0:
        force = unit * abs(arm[longest])
        compliance = _approach(law, force, soft[longest], scale[longest])[0] / force
    else:  # interference alone
        compliance = _approach(
            law,
            max(1e-6 * np.exp(scale[longest]), 1e-300) if law == LOGARITHMIC else 1.0,
            soft[longest],
            scale[longest],
        )[1]
    moved[:] = 0.0
    for j in range(count):
        if side * arm[j] > _SHORT:
            for i in range(count):
                moved[i] += flexible[j, i] * unit * side * arm[j]
    v = 0.0
    if pull > 0.0:
        for i in range(count):
            a = side * arm[i]
            if a > _SHORT:
                v += a * (gap[i] + compliance * unit * a + moved[i])
        v /= max(weight, 1e-300)
    for i in range(count):
        state[i] = (side * arm[i] * v - gap[i] - moved[i]) / compliance
    return v, compliance


@fused_part
def nearest(law, pull, x, side, across, arm, gap, soft, scale, flexible, state, moved):
    """Load the driving contact that is nearest to touching, where none is loaded. Returns v, or its
    former value.
    """
    best, at = np.inf, -1
    for i in range(arm.shape[0]):
        a = side * arm[i]
        if a > _SHORT:
            room = (gap[i] - across[i] * x + moved[i]) / a
            if room < best:
                best, at = room, i
    if at < 0:
        return 0.0
    force = pull / (side * arm[at])
    state[at] = force
    return best + (_approach(law, force, soft[at], scale[at])[0] + flexible[at, at] * force) / (
        side * arm[at]
    )
