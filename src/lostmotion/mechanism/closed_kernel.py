"""Compiled Newton steps of closed chains, pose by pose: the passive joints at values of the drives,
and the drives that bring the tool to a pose.

A frame is (3, 4) here: rotation and origin, m. Equations of the closures and freedoms of the
passive joints are free of units: rad, and lengths as shares of the size of the chain.
"""

from __future__ import annotations

import numpy as np

from lostmotion.compiled import compiled
from lostmotion.mechanism.closed_arrays import LONGEST_STEP

MOST_STEPS = 6
# Share of the normal equations by which freedoms that no closure holds take no step.
_IDLE = 1e-10
_SMALL_ANGLE, _NEAR_HALF_A_TURN, _ROUNDING = 1e-4, -0.9, 1e-15


@compiled
def exponential(twist, out):
    """Write to `out` the frame that a twist (6,) leads to in unit time."""
    x, y, z = twist[0], twist[1], twist[2]
    square = x * x + y * y + z * z
    angle = np.sqrt(square)
    if angle < _SMALL_ANGLE:
        a, b, c = 1 - square / 6, 0.5 - square / 24, 1 / 6 - square / 120
    else:
        half = np.sin(angle / 2)
        a, b = np.sin(angle) / angle, 2 * half * half / square
        c = (angle - np.sin(angle)) / (square * angle)
    w = (x, y, z)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[i, i] = 1 - b * (w[j] * w[j] + w[k] * w[k])
        out[i, j] = b * w[i] * w[j] - a * w[k]
        out[i, k] = b * w[i] * w[k] + a * w[j]
        v, u, t = twist[3 + i], twist[3 + j], twist[3 + k]
        out[i, 3] = (
            v * (1 - c * (w[j] * w[j] + w[k] * w[k]))
            + u * (c * w[i] * w[j] - b * w[k])
            + t * (c * w[i] * w[k] + b * w[j])
        )


@compiled
def copy(matrix, out):
    """Write a matrix to `out`.

    An assignment would do the same, but with the message of an error about shapes, whose
    compilation takes several seconds.
    """
    for i in range(matrix.shape[0]):
        for k in range(matrix.shape[1]):
            out[i, k] = matrix[i, k]


@compiled
def multiply(one, other, out):
    """Write to `out` the product of two frames."""
    for i in range(3):
        for k in range(4):
            out[i, k] = one[i, 0] * other[0, k] + one[i, 1] * other[1, k] + one[i, 2] * other[2, k]
        out[i, 3] += one[i, 3]


@compiled
def rotation_vector(one, other, out):
    """Write to out[:3] the rotation vector, rad, of one @ other.T, of any angle."""
    turn = np.empty((3, 3))
    for i in range(3):
        for k in range(3):
            turn[i, k] = one[i, 0] * other[k, 0] + one[i, 1] * other[k, 1] + one[i, 2] * other[k, 2]
    trace = turn[0, 0] + turn[1, 1] + turn[2, 2]
    if trace > _NEAR_HALF_A_TURN:
        size = 0.0
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            out[i] = (turn[k, j] - turn[j, k]) / 2
            size += out[i] * out[i]
        size = np.sqrt(size)
        factor = np.arctan2(size, (trace - 1) / 2) / size if size > 0 else 1.0
        for i in range(3):
            out[i] *= factor
        return
    # near half a turn the quaternion's largest component is of the axis
    i = 0
    for k in range(1, 3):
        if turn[k, k] > turn[i, i]:
            i = k
    j, k = (i + 1) % 3, (i + 2) % 3
    largest = np.sqrt(1 + turn[i, i] - turn[j, j] - turn[k, k])
    out[i] = largest / 2
    out[j] = (turn[i, j] + turn[j, i]) / (2 * largest)
    out[k] = (turn[i, k] + turn[k, i]) / (2 * largest)
    cosine = (turn[k, j] - turn[j, k]) / (2 * largest)
    sine = np.sqrt(out[0] ** 2 + out[1] ** 2 + out[2] ** 2)
    angle = 2 * np.arctan2(sine, cosine)
    if angle > np.pi:
        angle -= 2 * np.pi
    for row in range(3):
        out[row] *= angle / sine


@compiled
def place_all(chain, q, motions, at):
    """Write to `at` (place, 3, 4) the frames of all places."""
    step, twist = np.empty((3, 4)), np.empty(6)
    for i in range(3):
        for k in range(4):
            at[0, i, k] = 1.0 if i == k else 0.0
    for k in range(1, len(chain.parent)):
        parent = at[chain.parent[k]]
        if chain.drive[k] >= 0:
            for i in range(6):
                twist[i] = chain.twist[k, i] * q[chain.drive[k]]
            exponential(twist, step)
            multiply(parent, step, at[k])
        elif chain.passive[k] >= 0:
            multiply(parent, motions[chain.passive[k]], at[k])
        else:
            multiply(parent, chain.pose[k], at[k])


@compiled
def write_column(at, place, twist, size, out):
    """Write to `out` the twist (6,) about the tool point, in the base's axes, of a twist at a
    place.
    """
    frame, tool = at[place], at[-1]
    for i in range(3):
        out[i] = frame[i, 0] * twist[0] + frame[i, 1] * twist[1] + frame[i, 2] * twist[2]
        out[3 + i] = frame[i, 0] * twist[3] + frame[i, 1] * twist[4] + frame[i, 2] * twist[5]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[3 + i] += out[j] * (tool[k, 3] - frame[k, 3]) - out[k] * (tool[j, 3] - frame[j, 3])
        out[3 + i] /= size


@compiled
def write_misfit(chain, at, away):
    """Write to `away` (equation,) how far the closures are from being met, and return the largest
    component.
    """
    one, other, tool, largest = np.empty((3, 4)), np.empty((3, 4)), at[-1], 0.0
    for c in range(len(chain.ends)):
        multiply(at[chain.ends[c, 0]], chain.frame[c, 0], one)
        multiply(at[chain.ends[c, 1]], chain.frame[c, 1], other)
        turned = away[6 * c : 6 * c + 3]
        rotation_vector(one, other, turned)
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            away[6 * c + 3 + i] = (
                one[i, 3]
                - other[i, 3]
                + turned[j] * (tool[k, 3] - (one[k, 3] + other[k, 3]) / 2)
                - turned[k] * (tool[j, 3] - (one[j, 3] + other[j, 3]) / 2)
            ) / chain.size
    for each in away:
        largest = max(largest, abs(each)) if np.isfinite(each) else np.inf
    return largest


@compiled
def write_jacobian(chain, at, out):
    """Write to `out` (equation, freedom) the closures' Jacobian, its columns in the order of
    elimination.
    """
    column = np.empty(6)
    out[:] = 0.0
    for j, f in enumerate(chain.order):
        place = chain.of[f]
        write_column(at, place, chain.freedom[f], chain.size, column)
        for c in range(len(chain.sign)):
            sign = chain.sign[c, place]
            if sign:
                for i in range(6):
                    out[6 * c + i, j] = sign * chain.units[f] * column[i]


@compiled
def eliminated(matrix, right):
    """Solve matrix @ x = right (row, column) in place by Gaussian elimination, and return the sign
    of the determinant; 0 for a singular matrix. Zeros are skipped: chains are sparse.
    """
    n, sign = len(matrix), 1.0
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[pivot, k]):
                pivot = i
        if not abs(matrix[pivot, k]) > 0.0:
            return 0.0
        if pivot != k:
            sign = -sign
            for j in range(k, n):
                matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
            for j in range(right.shape[1]):
                right[k, j], right[pivot, j] = right[pivot, j], right[k, j]
        if matrix[k, k] < 0:
            sign = -sign
        for i in range(k + 1, n):
            if matrix[i, k] != 0.0:
                factor = matrix[i, k] / matrix[k, k]
                for j in range(k + 1, n):
                    matrix[i, j] -= factor * matrix[k, j]
                for j in range(right.shape[1]):
                    right[i, j] -= factor * right[k, j]
    for k in range(n - 1, -1, -1):
        for j in range(right.shape[1]):
            right[k, j] /= matrix[k, k]
        for i in range(k):
            if matrix[i, k] != 0.0:
                for j in range(right.shape[1]):
                    right[i, j] -= matrix[i, k] * right[k, j]
    return sign


@compiled
def product(one, other, out):
    """Write to `out` one.T @ other. Zeros are skipped."""
    out[:] = 0.0
    for row in range(one.shape[0]):
        for i in range(one.shape[1]):
            if one[row, i] != 0.0:
                for j in range(other.shape[1]):
                    out[i, j] += one[row, i] * other[row, j]


@compiled
def solved(chain, jacobian, right):
    """Return the smallest least-squares solution (freedom, column) of jacobian @ x = right, and the
    sign of the determinant; 0 without a solution.
    """
    rows, columns = jacobian.shape
    if rows == columns and not chain.idle:
        found = right.copy()
        return found, eliminated(jacobian.copy(), found)
    square, found = np.empty((columns, columns)), np.empty((columns, right.shape[1]))
    product(jacobian, jacobian, square)
    product(jacobian, right, found)
    if chain.idle:
        for i in range(columns):
            square[i, i] += _IDLE
    return found, eliminated(square, found)


@compiled
def same_side(chain, before, now):
    """Return whether two Jacobians have one orientation: no singularity is between them."""
    columns = now.shape[1]
    nothing = np.empty((columns, 0))
    if before.shape[0] == columns and not chain.idle:
        one, other = eliminated(before.copy(), nothing), eliminated(now.copy(), nothing)
        return one * other > 0
    both = np.empty((columns, columns))
    product(before, now, both)
    if chain.idle:
        for i in range(columns):
            both[i, i] += _IDLE
    return eliminated(both, nothing) > 0


@compiled
def move(chain, motions, step):
    """Move the passive joints (passive, 3, 4) by a step (freedom,) in the order of elimination, in
    place.
    """
    by_freedom, twist, turned, out = (
        np.empty(len(chain.order)),
        np.empty(6),
        np.empty((3, 4)),
        np.empty((3, 4)),
    )
    for j, f in enumerate(chain.order):
        by_freedom[f] = step[j] * chain.units[f]
    for k in range(len(motions)):
        twist[:] = 0.0
        for f in range(chain.first[k], chain.first[k + 1]):
            for i in range(6):
                twist[i] += by_freedom[f] * chain.freedom[f, i]
        exponential(twist, turned)
        multiply(motions[k], turned, out)
        copy(out, motions[k])


@compiled
def close(chain, q, motions, at, jacobian, met):
    """Move the passive joints by Newton's steps until the closures are met, in place, and return
    the largest misfit.
    """
    away = np.empty(6 * len(chain.ends))
    last = now = np.inf
    for turn in range(MOST_STEPS + 1):
        place_all(chain, q, motions, at)
        now = write_misfit(chain, at, away)
        write_jacobian(chain, at, jacobian)
        # one more step after the closures are met, which squares what is left
        if not np.isfinite(now) or (now < met and last < met ** (2 / 3)) or turn == MOST_STEPS:
            break
        if now < _ROUNDING or not len(chain.order):
            break
        last = now
        found, sign = solved(chain, jacobian, away.reshape(-1, 1))
        largest = np.abs(found).max()
        if sign == 0.0 or not np.isfinite(largest):
            return np.inf
        move(chain, motions, -found[:, 0] / max(largest / LONGEST_STEP, 1.0))
    return now


@compiled
def write_tool_columns(chain, at, jacobian, out):
    """Write to `out` (6, drive) the twist of the tool per motion of each drive after the loops have
    closed again, rad and shares of the size; return the steps of the passive joints (freedom,
    drive).
    """
    right, column = np.zeros((6 * len(chain.ends), len(chain.moved))), np.empty(6)
    for d, place in enumerate(chain.moved):
        write_column(at, place, chain.twist[place], chain.size, column)
        for c in range(len(chain.sign)):
            for i in range(6):
                right[6 * c + i, d] = -chain.sign[c, place] * column[i]
        for i in range(6):
            out[i, d] = column[i] if chain.carries[place] else 0.0
    steps, sign = solved(chain, jacobian, right)
    if sign == 0.0:
        steps[:] = np.inf
    for j, f in enumerate(chain.order):
        if chain.carries[chain.of[f]]:
            write_column(at, chain.of[f], chain.freedom[f], chain.size, column)
            for d in range(len(chain.moved)):
                for i in range(6):
                    out[i, d] += column[i] * chain.units[f] * steps[j, d]
    return steps
