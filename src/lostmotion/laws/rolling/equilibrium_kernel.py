"""Kernel of the shaft's equilibrium: many unilateral contacts, solved case by case. Compiled by
Numba and cached; single-threaded.

The stored energy is convex in the displacement, so Newton's method with a line search on the energy
converges to its only minimum. Displacements are in metres throughout: tilts are multiplied by
`reach`.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from lostmotion.compiled import fused, fused_part

# hundreds of steps are needed where a very small load in a large clearance closes one contact after
# another
_STEPS: Final = 2000
_TRIES: Final = 40  # per step
_FIRST: Final = 1e-6  # m, the first step
_CONVERGED: Final = 1e-11
_ROUNDING: Final = 5e-16
# Directions with less than this share of the largest stiffness count as free: without load they do
# not move.
_SOFTEST: Final = 1e-12
_POINT: Final = 1.5  # exponent of a point contact, computed faster by a square root


@fused_part
def _closed(contact, clearance, displacement):
    """Return the closure of a contact (m), the magnitude of its terms (for rounding), and its
    direction (components of across and along).
    """
    radial, axial = contact.radial - contact.share * clearance, contact.axial
    start = radial
    for k in range(5):
        radial += contact.across[k] * displacement[k]
        axial += contact.along[k] * displacement[k]
    if contact.apart == 0.0:
        return radial, abs(radial) + 2.0 * abs(start), 1.0, 0.0
    # towards the side without a shoulder the ball stays at the bottom of the groove
    if axial <= 0.0 and not contact.shoulders:
        return abs(radial) - contact.apart, abs(radial), 1.0 if radial > 0.0 else -1.0, 0.0
    length = np.sqrt(radial * radial + axial * axial)
    return length - contact.apart, length, radial / length, axial / length


@fused_part
def _push(contact, approach):
    """Return the force (N) of a contact with the closure `approach` (m)."""
    return contact.stiffness * (
        approach * np.sqrt(approach) if contact.exponent == _POINT else approach**contact.exponent
    )


@fused_part
def _hold(contacts, clearance, displacement, held, slope, way, bow):
    """Write the supported load to `held` (5,) and its derivative to `slope` (5, 5; lower triangle).
    Return the rounding of the sums, N.
    """
    noise = 0.0
    for k in range(5):
        held[k] = 0.0
        for m in range(k + 1):
            slope[k, m] = 0.0
    for i in range(contacts.shape[0]):
        contact = contacts[i]
        approach, size, cosine, sine = _closed(contact, clearance, displacement)
        if approach > 0.0:
            force = _push(contact, approach)
            stiff = contact.exponent * force / approach
            # A ball's line of action also rotates; at the bottom of its groove, and for a straight
            # contact, the direction is fixed.
            turns = (
                force / size if contact.apart > 0.0 and (contact.shoulders or sine > 0.0) else 0.0
            )
            noise += force + stiff * size
            for k in range(5):
                way[k] = cosine * contact.across[k] + sine * contact.along[k]
                bow[k] = cosine * contact.along[k] - sine * contact.across[k]
            for k in range(5):
                held[k] += force * way[k]
                for m in range(k + 1):
                    slope[k, m] += stiff * way[k] * way[m] + turns * bow[k] * bow[m]
    return _ROUNDING * noise


@fused_part
def _dot(one, other):
    total = 0.0
    for k in range(5):
        total += one[k] * other[k]
    return total


@fused_part
def _step(slope, lack, root, step):
    """Solve slope step = lack by Cholesky factorisation (`root`), with almost no step along
    directions without stiffness and load.
    """
    largest = 1.0
    for k in range(5):
        largest = max(largest, slope[k, k])
    for k in range(5):
        for m in range(k + 1):
            rest = slope[k, m]
            for n in range(m):
                rest -= root[k, n] * root[m, n]
            if m < k:
                root[k, m] = rest / root[m, m]
            else:
                root[k, k] = np.sqrt(max(rest, 0.0) + largest * _SOFTEST)
    for k in range(5):
        step[k] = lack[k]
        for m in range(k):
            step[k] -= root[k, m] * step[m]
        step[k] /= root[k, k]
    for k in range(4, -1, -1):
        for m in range(k + 1, 5):
            step[k] -= root[m, k] * step[m]
        step[k] /= root[k, k]


@fused_part
def _balance(
    contacts, clearance, wanted, reach, displacement, held, slope, trial, lack, step, root, way, bow
):
    """Find the displacement at which the contacts support the load. Return the residual (N) and its
    ratio to the tolerance; above 1: no equilibrium.

    Where no contact is closed, the step is along the load and is doubled until contacts support
    half of it. All other steps are Newton's. Each step is shortened until the magnitude of the
    energy's slope along it has fallen to half or less.
    """
    size = np.sqrt(_dot(wanted, wanted))
    for k in range(5):
        displacement[k] = step[k] = 0.0
    down = low = share = at_low = at_high = 0.0
    high = left = ratio = np.inf
    steps = tries = 0
    free = False
    while True:
        for k in range(5):
            trial[k] = displacement[k] + share * step[k]
        noise = _hold(contacts, clearance, trial, held, slope, way, bow)
        for k in range(5):
            lack[k] = wanted[k] - held[k]
        now = _dot(lack, step)
        far = np.sqrt(_dot(trial, trial))
        tries += 1
        beyond, short = now < -0.5 * down, now > 0.5 * down and (free or share < 1.0)
        if (beyond or short) and tries < _TRIES and far < reach:
            if beyond:
                high, at_high = share, now
            else:
                low, at_low = share, now
            if high == np.inf:
                share *= 2.0
            else:  # bisection, alternating with the zero of a straight line
                share = low + (high - low) * (
                    min(max(at_low / (at_low - at_high), 0.1), 0.9) if tries % 2 else 0.5
                )
            continue
        for k in range(5):
            displacement[k] = trial[k]
        left = np.sqrt(_dot(lack, lack))
        ratio = 0.0 if left == 0.0 else left / (_CONVERGED * size + noise)
        # A shaft that has left the bearing is not supported.
        if not (ratio > 1.0 and steps < _STEPS and far < reach):
            return left, ratio
        free = noise == 0.0
        if free:
            for k in range(5):
                step[k] = wanted[k] * (_FIRST / size)
        else:
            _step(slope, lack, root, step)
            # No step is longer than the distance so far plus the clearance, so that directions
            # without support do not diverge.
            cut = min(1.0, (far + abs(clearance) + _FIRST) / np.sqrt(_dot(step, step)))
            for k in range(5):
                step[k] *= cut
        down = at_low = _dot(lack, step)
        low, high, share = 0.0, np.inf, 1.0
        steps += 1
        tries = 0


@fused
def solve_cases(
    contacts,  # (contact,) as `rolling.rows.CONTACT`, per displacement in metres
    clearance,  # (case,) m
    wanted,  # (case, 5) N
    reach,  # m
    displacement,  # out (case, 5) m
    slope,  # out (case, 5, 5) N/m
    loads,  # out (case, element) N
    residual,  # out (case,) N
    converged,  # out (case,)
):
    """Solve all cases. Where no equilibrium is found, all results but the residual are NaN."""
    held, trial, lack, step, way, bow = (
        np.zeros(5),
        np.zeros(5),
        np.zeros(5),
        np.zeros(5),
        np.zeros(5),
        np.zeros(5),
    )
    half, root = np.zeros((5, 5)), np.zeros((5, 5))
    for case in range(wanted.shape[0]):
        at = displacement[case]
        residual[case], ratio = _balance(
            contacts,
            clearance[case],
            wanted[case],
            reach,
            at,
            held,
            half,
            trial,
            lack,
            step,
            root,
            way,
            bow,
        )
        converged[case] = ratio <= 1.0
        blank = 0.0 if ratio <= 1.0 else np.nan
        for element in range(loads.shape[1]):
            loads[case, element] = blank
        for i in range(contacts.shape[0]):
            contact = contacts[i]
            approach = _closed(contact, clearance[case], displacement[case])[0]
            if approach > 0.0:
                loads[case, contact.element] += _push(contact, approach)
        for k in range(5):
            displacement[case, k] += blank
            for m in range(5):
                slope[case, k, m] = half[max(k, m), min(k, m)] + blank
