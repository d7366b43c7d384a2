"""Rigid-body geometry, batched: poses (..., 4, 4), twists (..., 6) as (rad, m), wrenches (..., 6)
as (N m, N).

A twist is (rotation, displacement of the frame's origin); a wrench is (moment about the frame's
origin, force).
Angular parts come first in both. Source of the closed forms: K. Lynch, F. Park, Modern Robotics,
2017, ch. 3.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    # Rows of a matrix: each entry one number, or one for each pose (pose,).
    Matrix = Sequence[Sequence[Floats | float]]

# Below this angle the series of the closed forms is exact to rounding, and the closed forms are
# not.
_SMALL_ANGLE = 1e-4


def skew(vector: Floats) -> Floats:
    """Return the matrix (..., 3, 3) of the cross product with a vector (..., 3) from the left."""
    out = np.zeros((*vector.shape[:-1], 3, 3), dtype=np.result_type(vector, float))
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    out[..., 0, 1], out[..., 0, 2] = -z, y
    out[..., 1, 0], out[..., 1, 2] = z, -x
    out[..., 2, 0], out[..., 2, 1] = -y, x
    return out


def cross(a: Floats, b: Floats) -> Floats:
    """Return a x b for vectors (..., 3), faster than np.cross on short arrays."""
    x = a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1]
    # one component after the other in memory, so that steps run along the vectors
    out = np.empty((3, *x.shape), dtype=np.result_type(x, float))
    out[0] = x
    out[1] = a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2]
    out[2] = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return out.transpose(*range(1, out.ndim), 0)


def mapped(matrix: Floats, vectors: Floats) -> Floats:
    """Return matrix @ vector for vectors (pose, k): (pose, m) for a matrix (m, k), (pose,) for a
    vector (k,).

    Summed in one order, so that one vector has the same bits alone as among others; the matrix
    product of NumPy does not ensure that.
    """
    return np.asarray(
        sum(np.multiply.outer(matrix[..., k], vectors[:, k]) for k in range(matrix.shape[-1]))
    ).T


def combined(parts: Floats, matrix: Matrix, out: Floats | None = None) -> Floats:
    """Return parts @ matrix (row, m, pose) for parts (row, k, pose), written to `out` where that is
    given.

    Summed in one order as `mapped`, along the poses, which lie innermost in memory. Zeros of the
    matrix are skipped.
    """
    result = np.empty((len(parts), len(matrix[0]), parts.shape[2])) if out is None else out
    for j in range(len(matrix[0])):
        here, begun = result[:, j], False
        for k, row in enumerate(matrix):
            weight = row[j]
            if not isinstance(weight, np.ndarray) and weight == 0:
                continue
            if begun:
                here += weight * parts[:, k]
            else:
                begun = True
                np.multiply(weight, parts[:, k], out=here)
        if not begun:
            here[:] = 0
    return result


def added_in_order(parts: Floats, axis: int) -> Floats:
    """Return the sum of parts along an axis, of the same bits for one pose alone as among others,
    which NumPy's sum does not ensure.
    """
    first, *others = np.moveaxis(parts, axis, 0)
    out = first.copy()
    for part in others:  # whole arrays are added: a running sum along a short axis is slow
        out += part
    return np.asarray(out)


def out_of(frame: Floats, vector: Floats) -> Floats:
    """Return a vector (3,) of the frames' (pose, 4, 4) axes in the base's axes (pose, 3)."""
    return np.asarray(combined(frame.transpose(1, 2, 0)[:3, :3], vector[:, None].tolist())[:, 0].T)


def into(frame: Floats, vector: Floats) -> Floats:
    """Return a vector (3,) of the base's axes in the axes of the frames (pose, 4, 4); the result
    has shape (pose, 3).
    """
    return np.asarray(combined(frame.transpose(2, 1, 0)[:3, :3], vector[:, None].tolist())[:, 0].T)


def across(axis: Floats) -> tuple[Floats, Floats]:
    """Return two unit directions (3,) that are perpendicular to a unit axis (3,) and to each
    other.
    """
    round_axis = skew(axis)
    first = round_axis[:, int(np.argmin(np.abs(axis)))]
    first = first / np.linalg.norm(first)
    return first, round_axis @ first


def motion(twist: Floats, amount: Floats) -> Matrix:
    """Return the pose of a pure rotation or translation along a unit twist (6,) by angles or
    lengths (pose,), rad or m: exp(amount twist).
    """
    out: list[list[Floats | float]] = [[*row] for row in np.eye(4).tolist()]
    if twist[:3].any():
        sine, less = np.sin(amount), 1 - np.cos(amount)
        axis = skew(twist[:3])
        for (i, j), a, b in zip(
            np.ndindex(3, 3), axis.ravel().tolist(), (axis @ axis).ravel().tolist(), strict=True
        ):
            if a or b:
                out[i][j] = out[i][j] + a * sine + b * less
    else:
        for row, along in zip(out, twist[3:].tolist(), strict=False):
            row[3] = along * amount
    return out


def exp(twist: Floats) -> Floats:
    """Return the pose (..., 4, 4) that a twist (..., 6) leads to in unit time; any angle, zero
    included.
    """
    twist = np.asarray(twist, dtype=float)
    # one component after the other in memory, so that steps run along the twists
    along = np.ascontiguousarray(twist.reshape(-1, 6).T)
    omega, velocity = along[:3], along[3:]
    square = omega[0] ** 2 + omega[1] ** 2 + omega[2] ** 2
    angle = np.sqrt(square)
    small = angle < _SMALL_ANGLE
    safe = np.where(small, 1.0, angle)
    sine, half = np.sin(safe), np.sin(safe / 2)
    # a = sin t / t, b = (1 - cos t)/t^2, c = (t - sin t)/t^3; 1 - cos t itself cancels
    a = np.where(small, 1 - square / 6, sine / safe)
    b = np.where(small, 0.5 - square / 24, 2 * half**2 / safe**2)
    c = np.where(small, 1 / 6 - square / 120, (safe - sine) / safe**3)
    squared = omega[:, None] * omega
    turned = np.zeros_like(squared)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        squared[i, i] -= square
        turned[k, j], turned[j, k] = omega[i], -omega[i]
    out = np.empty((4, 4, len(square)))
    out[:3, :3] = a * turned + b * squared
    left = b * turned + c * squared
    out[:3, 3] = velocity + left[:, 0] * velocity[0]
    out[:3, 3] += left[:, 1] * velocity[1]
    out[:3, 3] += left[:, 2] * velocity[2]
    out[0, 0] += 1
    out[1, 1] += 1
    out[2, 2] += 1
    out[3, :3], out[3, 3] = 0.0, 1.0
    return np.ascontiguousarray(out.transpose(2, 0, 1)).reshape(*twist.shape[:-1], 4, 4)


def right_jacobian(twist: Floats) -> Floats:
    """Return the twist (pose, 6, 6) in the axes of the moved frame per change of the twist
    (pose, 6) that moved it: exp(e + d) = exp(e) exp(J d) for small d.

    Its series to the 16th power: exact to 1e-13 for rotations up to 1 rad, and to 1e-7 up to 2 rad.
    Source: K. Lynch, F. Park, Modern Robotics, 2017, 3.3; G. Chirikjian, Stochastic Models,
    Information Theory, and Lie Groups 2, 2012, 10.1.
    """
    bracket = np.zeros((*twist.shape[:-1], 6, 6))
    bracket[..., :3, :3] = bracket[..., 3:, 3:] = skew(twist[..., :3])
    bracket[..., 3:, :3] = skew(twist[..., 3:])
    eye = np.broadcast_to(np.eye(6), bracket.shape)
    out = eye.copy()
    for number in range(17, 1, -1):
        out = eye - bracket @ out / number
    return out


def rotation_vector(rotation: Floats) -> Floats:
    """Return the rotation vectors (..., 3), rad, of rotation matrices (..., 3, 3) by less than
    half a turn.
    """
    sine = np.stack(
        [
            rotation[..., 2, 1] - rotation[..., 1, 2],
            rotation[..., 0, 2] - rotation[..., 2, 0],
            rotation[..., 1, 0] - rotation[..., 0, 1],
        ],
        axis=-1,
    )
    size = np.sqrt((sine**2).sum(axis=-1)) / 2
    cosine = (rotation[..., 0, 0] + rotation[..., 1, 1] + rotation[..., 2, 2] - 1) / 2
    factor = np.where(size > 0, np.arctan2(size, cosine) / np.where(size > 0, size, 1.0), 1.0)
    return np.asarray(sine / 2 * factor[..., None])


def nearest_rotation(matrix: Floats) -> Floats:
    """Return the rotation (3, 3) that is nearest to a matrix (3, 3) in the sum of squares.

    Source: K. Arun, T. Huang, S. Blostein, IEEE PAMI 9 (1987) 698.
    """
    u, _, v = np.linalg.svd(matrix)
    return np.asarray(u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ v))]) @ v)


def mean_pose(poses: Floats) -> Floats:
    """Return the mean (4, 4) of poses (pose, 4, 4) that are near to each other."""
    out = poses.mean(axis=0)
    out[:3, :3] = nearest_rotation(out[:3, :3])
    return np.asarray(out)


def inverse(pose: Floats) -> Floats:
    """Return the inverse of a pose (..., 4, 4), whose bottom row is assumed to be (0, 0, 0, 1)."""
    rotation = np.swapaxes(pose[..., :3, :3], -1, -2)
    out = np.zeros_like(pose)
    out[..., :3, :3] = rotation
    out[..., :3, 3] = -np.einsum("...ij,...j->...i", rotation, pose[..., :3, 3])
    out[..., 3, 3] = 1.0
    return out


def pose_by_quaternion(
    xyz: Floats | Sequence[float], quaternion: Floats | Sequence[float] = (1.0, 0.0, 0.0, 0.0)
) -> Floats:
    """Return the pose (4, 4) at xyz (m), turned by a unit quaternion (w, x, y, z)."""
    w, x, y, z = quaternion
    out = np.eye(4)
    out[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    out[:3, 3] = xyz
    return out


def pose_of(
    xyz: Sequence[float] | Floats = (0, 0, 0), rpy: Sequence[float] | Floats = (0, 0, 0)
) -> Floats:
    """Return the pose (4, 4) at xyz (m) with roll, pitch, yaw (rad) about the fixed x, y, z axes,
    in that order (URDF).
    """
    out = np.eye(4)
    for axis, angle in zip(((0, 0, 1), (0, 1, 0), (1, 0, 0)), reversed(rpy), strict=True):
        if angle:  # few frames are turned, and turns take most of the time
            out = out @ turn(axis, float(angle))
    out[:3, 3] = xyz
    return out


def turn(axis: Sequence[float] | Floats, angle: float) -> Floats:
    """Return the rotation (4, 4) by an angle (rad) about a unit axis through the origin."""
    return exp(np.concatenate([np.asarray(axis, dtype=float) * angle, np.zeros(3)]))


def shift(x: float, y: float, z: float) -> Floats:
    """Return the translation (4, 4) by x, y, z (m)."""
    out = np.eye(4)
    out[:3, 3] = x, y, z
    return out
