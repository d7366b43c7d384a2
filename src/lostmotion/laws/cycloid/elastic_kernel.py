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

from lostmotion.compiled import fused, fused_part
from lostmotion.laws.cycloid.contact_kernel import (
    BEARING,
    LOADED,
    RESIDUAL,
    ROTATION,
    SOFTNESS,
    TOLERANCE,
)
from lostmotion.laws.cycloid.elastic_residual_kernel import (
    ALONG,
    AROUND,
    LARGEST,
    LENGTH,
    ROUNDING,
    STALLED,
    TOTAL,
    factorise,
    left_over,
    nearest,
    start,
)

_GOAL: Final = 1e-12
_TOUCH: Final = 1e-9  # of T/r: a smaller force is rounding
# of the stiffness along the line of centres: rounding of the arm of a contact on that line
_ACROSS: Final = 1e-20
_STEPS: Final = 200
_HALVINGS: Final = 12


@fused_part
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
    v, compliance = start(law, pull, side, arm, gap, soft, scale, flexible, state, moved)
    left_over(
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
    unit = pull if pull > 0.0 else sums[TOTAL] + abs(push)
    if unit == 0.0:
        return x, v, 0.0
    length = compliance * unit
    best = np.inf
    for _ in range(_STEPS):
        rx = 0.0 if rigid else push - spring * x - sums[ALONG]
        rv = pull - sums[AROUND]
        error = max(max(abs(rx), abs(rv)) / unit, sums[LENGTH] / length)
        rounded = (
            max(abs(rx), abs(rv)) <= ROUNDING * sums[TOTAL]
            and sums[LENGTH] <= ROUNDING * sums[LARGEST]
        )
        if error <= _GOAL or (error <= STALLED and error >= 0.5 * best) or rounded:
            return x, v, error
        best = min(best, error)
        merit = (rx / unit) ** 2 + (rv / unit) ** 2
        for i in range(count):
            merit += (left[i] / length) ** 2
        number = factorise(
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
            v = nearest(law, pull, x, side, across, arm, gap, soft, scale, flexible, state, moved)
            left_over(
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
            left_over(
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
            there = 0.0 if rigid else ((push - spring * x - sums[ALONG]) / unit) ** 2
            there += ((pull - sums[AROUND]) / unit) ** 2
            for i in range(count):
                there += (left[i] / length) ** 2
            if there <= (1.0 - 0.1 * share) * merit or halving == _HALVINGS - 1:
                break
            for i in range(count):
                state[i] = 0.5 * (state[i] + trial[i])
            share *= 0.5
    rx = 0.0 if rigid else push - spring * x - sums[ALONG]
    return x, v, max(max(abs(rx), abs(pull - sums[AROUND])) / unit, sums[LENGTH] / length)


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
    flexible,  # (side, crank, N, N) m/N, of the bodies under forward and backward torques
    out,  # out (case, COLUMNS) as of `contact_kernel`
    forces,  # out (case, N)
):
    """Solve a range of cases. Cases that do not converge are NaN."""
    count, draws, pins = places.shape[0], stiffness.shape[1], arm.shape[1]
    sums, room = np.empty(5), np.empty((4, pins))
    matrix, columns, loaded = np.empty((pins, pins)), np.empty((pins, 3)), np.empty(pins, np.int64)
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
        number = factorise(
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
