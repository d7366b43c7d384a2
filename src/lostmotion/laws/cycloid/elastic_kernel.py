"""Kernel of the load sharing on elastic bodies: contacts and bodies together, case by case.
Compiled once by Numba and cached; single-threaded.

Unknown are the displacement x along the line of centres, v = y + r theta as in `contact_kernel`,
and one number s per contact: its force where s is positive; otherwise s c is its separation, with a
compliance c. At every contact the approach of the rigid wheels is that of the law of the contact
plus the displacement A F of the bodies. Newton's method on these equations and on the balance of
forces, with a line search on the norm of what remains: a contact opens or closes where its s
changes sign. The law of the contact is linearised, not inverted, so one logarithm per contact and
step is enough.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from lostmotion.compiled import compiled_with
from lostmotion.laws.contact import LEAST_LOGARITHM, PALMGREN_EXPONENT
from lostmotion.laws.cycloid.contact_kernel import (
    BEARING,
    LINEAR,
    LOADED,
    LOGARITHMIC,
    RESIDUAL,
    ROTATION,
    SOFTNESS,
    TOLERANCE,
)

_GOAL: Final = 1e-12
_STALLED: Final = 1e-10  # accepted where a step no longer improves it: rounding
# of the sum of all forces: the accuracy limit of the balance, even where it is large compared with
# a small torque
_ROUNDING: Final = 4e-16
_TOUCH: Final = 1e-9  # of T/r: a smaller force is rounding
# contacts with arms below this share of the longest are ignored in the start value
_SHORT: Final = 0.05
# of the stiffness along the line of centres: rounding of the arm of a contact on that line
_ACROSS: Final = 1e-20
_STEPS: Final = 200
_HALVINGS: Final = 12
_LOWEST: Final = LEAST_LOGARITHM
_POWER: Final = PALMGREN_EXPONENT
# Sums over all contacts.
_ALONG, _AROUND, _TOTAL, _LENGTH, _LARGEST = range(5)

_jit = compiled_with(fastmath={"contract"})


@_jit
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


@_jit
def _left_over(
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
    sums[_ALONG], sums[_AROUND], sums[_TOTAL], sums[_LENGTH], sums[_LARGEST] = (
        along,
        around,
        total,
        length,
        largest,
    )


@_jit
def _factorise(law, state, side, across, arm, soft, scale, flexible, loaded, matrix, columns, left):
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


@_jit
def _start(law, pull, side, arm, gap, soft, scale, flexible, state, moved):
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


@_jit
def _nearest(law, pull, x, side, across, arm, gap, soft, scale, flexible, state, moved):
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


@_jit
def _equilibrium(
    law,
    pull,
    push,
    spring,
    side,
    across,
    arm,
    gap,
    soft,
    scale,
    flexible,
    room,
    matrix,
    columns,
    loaded,
    sums,
):
    """Return x, v and the residual at which contacts, bodies and bearing balance the pull (T/r,
    positive) and the push along the line of centres.

    An infinite spring holds x. The rows of `room` are the states, the states of a trial,
    displacements of the bodies, and what remains.
    """
    state, trial, moved, left = room[0], room[1], room[2], room[3]
    rigid = not np.isfinite(spring)
    count = arm.shape[0]
    x = 0.0
    v, compliance = _start(law, pull, side, arm, gap, soft, scale, flexible, state, moved)
    _left_over(
        law,
        x,
        v,
        state,
        compliance,
        side,
        across,
        arm,
        gap,
        soft,
        scale,
        flexible,
        moved,
        left,
        sums,
    )
    unit = pull if pull > 0.0 else sums[_TOTAL] + abs(push)
    if unit == 0.0:
        return x, v, 0.0
    length = compliance * unit
    best = np.inf
    for _ in range(_STEPS):
        rx = 0.0 if rigid else push - spring * x - sums[_ALONG]
        rv = pull - sums[_AROUND]
        error = max(max(abs(rx), abs(rv)) / unit, sums[_LENGTH] / length)
        rounded = (
            max(abs(rx), abs(rv)) <= _ROUNDING * sums[_TOTAL]
            and sums[_LENGTH] <= _ROUNDING * sums[_LARGEST]
        )
        if error <= _GOAL or (error <= _STALLED and error >= 0.5 * best) or rounded:
            return x, v, error
        best = min(best, error)
        merit = (rx / unit) ** 2 + (rv / unit) ** 2
        for i in range(count):
            merit += (left[i] / length) ** 2
        number = _factorise(
            law, state, side, across, arm, soft, scale, flexible, loaded, matrix, columns, left
        )
        nr = nn = na = ar = aa = 0.0
        for p in range(number):
            n, a = across[loaded[p]], side * arm[loaded[p]]
            nr += n * columns[p, 0]
            nn += n * columns[p, 1]
            na += n * columns[p, 2]
            ar += a * columns[p, 0]
            aa += a * columns[p, 2]
        if aa <= _ACROSS * (nn + (0.0 if rigid else spring)):  # no driving flank is in contact
            v = _nearest(law, pull, x, side, across, arm, gap, soft, scale, flexible, state, moved)
            _left_over(
                law,
                x,
                v,
                state,
                compliance,
                side,
                across,
                arm,
                gap,
                soft,
                scale,
                flexible,
                moved,
                left,
                sums,
            )
            continue
        dx = 0.0
        if not rigid:
            dx = ((rx - nr) * aa - (rv - ar) * na) / ((nn + spring) * aa - na * na)
        dv = (rv - ar - na * dx) / aa
        # the first column becomes the change of the loaded contacts, `trial` that of all
        for i in range(count):
            trial[i] = left[i] + across[i] * dx + side * arm[i] * dv
        for p in range(number):
            columns[p, 0] += columns[p, 1] * dx + columns[p, 2] * dv
            for i in range(count):
                trial[i] -= flexible[loaded[p], i] * columns[p, 0]
        for i in range(count):
            trial[i] /= compliance
        for p in range(number):
            trial[loaded[p]] = columns[p, 0]
        share = 1.0
        before = x, v
        for i in range(count):
            trial[i] += state[i]
            state[i], trial[i] = trial[i], state[i]  # trial is the state before the step
        for halving in range(_HALVINGS):
            x, v = before[0] + share * dx, before[1] + share * dv
            _left_over(
                law,
                x,
                v,
                state,
                compliance,
                side,
                across,
                arm,
                gap,
                soft,
                scale,
                flexible,
                moved,
                left,
                sums,
            )
            there = 0.0 if rigid else ((push - spring * x - sums[_ALONG]) / unit) ** 2
            there += ((pull - sums[_AROUND]) / unit) ** 2
            for i in range(count):
                there += (left[i] / length) ** 2
            if there <= (1.0 - 0.1 * share) * merit or halving == _HALVINGS - 1:
                break
            for i in range(count):
                state[i] = 0.5 * (state[i] + trial[i])
            share *= 0.5
    rx = 0.0 if rigid else push - spring * x - sums[_ALONG]
    return x, v, max(max(abs(rx), abs(pull - sums[_AROUND])) / unit, sums[_LENGTH] / length)


@_jit
def solve_cases(
    first,  # case, counted (torque * cranks + crank) * draws + draw
    last,  # one past the last case
    law,
    radius,  # of the planet's pitch circle, m
    thrust,  # force along the line of centres per torque, 1/m
    torque,  # (torque,)
    across,  # (crank, N) n_x
    arm,  # (crank, N) n_y = l/r
    soft,  # (crank, N) coefficients of the law
    scale,  # (crank, N)
    largest,  # (crank, N) force at which the law ends
    gap,  # (crank, draw, N), or 1 in either of the first two
    stiffness,  # (draw,) of the bearing, N/m
    flexible,  # (side, crank, N, N) m/N, of the bodies under forward and backward torques
    out,  # out (case, COLUMNS) as of `contact_kernel`
    forces,  # out (case, N)
):
    """Solve a range of cases. Cases that do not converge are NaN."""
    cranks, draws, pins = arm.shape[0], stiffness.shape[0], arm.shape[1]
    sums, room = np.empty(5), np.empty((4, pins))
    matrix, columns, loaded = np.empty((pins, pins)), np.empty((pins, 3)), np.empty(pins, np.int64)
    for case in range(first, last):
        draw = case % draws
        c = case // draws % cranks
        moment = torque[case // draws // cranks]
        side = -1.0 if moment < 0.0 else 1.0
        pull = abs(moment) / radius
        push = -thrust * abs(moment)
        k = stiffness[draw]
        g = gap[c % gap.shape[0], draw % gap.shape[1]]
        bodies = flexible[1 if side < 0.0 else 0, c]
        _, v, error = _equilibrium(
            law,
            pull,
            push,
            k,
            side,
            across[c],
            arm[c],
            g,
            soft[c],
            scale[c],
            bodies,
            room,
            matrix,
            columns,
            loaded,
            sums,
        )
        lobes, fx, fv, valid = 0, 0.0, 0.0, error <= TOLERANCE
        for i in range(pins):
            force = max(room[0, i], 0.0)
            lobes += force > _TOUCH * pull
            valid = valid and force <= largest[c, i]
            forces[case, i] = force
            fx += force * across[c, i]
            fv += force * side * arm[c, i]
        number = _factorise(
            law,
            room[0],
            side,
            across[c],
            arm[c],
            soft[c],
            scale[c],
            bodies,
            loaded,
            matrix,
            columns,
            room[3],
        )
        nn = na = aa = 0.0
        for p in range(number):
            i = loaded[p]
            nn += across[c, i] * columns[p, 1]
            na += across[c, i] * columns[p, 2]
            aa += side * arm[c, i] * columns[p, 2]
        # d(theta)/d(torque): compliance of contacts and bodies to push and pull, plus that of the
        # bearing, over r
        soft_v = (
            (nn + k + na * thrust * radius) / ((nn + k) * aa - na * na) + 1.0 / k
            if np.isfinite(k)
            else 1.0 / aa
        )
        out[case, ROTATION] = side * (v + pull / k) / radius
        out[case, SOFTNESS] = soft_v / (radius * radius)
        out[case, BEARING] = np.sqrt((fx - push) ** 2 + fv * fv)
        out[case, RESIDUAL] = error
        out[case, LOADED] = lobes
        if not valid:
            out[case, :RESIDUAL] = np.nan
            forces[case, :] = np.nan
