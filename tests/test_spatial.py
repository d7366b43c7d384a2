"""Rigid-body geometry against SciPy's matrix exponential and against itself."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from lostmotion.spatial import across, exp, inverse, mapped, pose_of, shift, skew, turn

UNIT = (
    st.tuples(*[st.floats(-1, 1)] * 3)
    .filter(lambda v: np.linalg.norm(v) > 0.1)
    .map(lambda v: np.array(v) / np.linalg.norm(v))
)
VELOCITY = st.tuples(*[st.floats(-10, 10)] * 3).map(np.array)
ANGLE = st.one_of(
    st.floats(0, math.pi - 1e-7),
    st.floats(-14, 0).map(lambda e: 10.0**e),
    st.just(0.0),
    st.floats(-7, -1).map(lambda e: math.pi - 10.0**e),
)
TWIST = st.builds(
    lambda axis, angle, velocity: np.concatenate([axis * angle, velocity]), UNIT, ANGLE, VELOCITY
)


@given(UNIT)
def test_two_directions_lie_across_an_axis(axis):
    """The axis and the two directions across it are a right-handed frame."""
    frame = np.column_stack([*across(axis), axis])
    np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=1e-12)
    assert np.linalg.det(frame) > 0


def matrix(twist: np.ndarray) -> np.ndarray:
    """Write a twist as the 4 x 4 matrix whose exponential the pose is."""
    out = np.zeros((4, 4))
    out[:3, :3] = skew(twist[:3])
    out[:3, 3] = twist[3:]
    return out


@given(TWIST)
@settings(deadline=None, max_examples=300)
def test_exp_is_the_matrix_exponential(twist: np.ndarray):
    """The closed form of a screw motion is the matrix exponential, from no angle at all to half a
    turn.
    """
    np.testing.assert_allclose(exp(twist), expm(matrix(twist)), atol=3e-14)


@pytest.mark.parametrize("angle", [0.0, 1e-300, 1e-12, 0.99e-4, 1.01e-4, 1e-3, 1.0, 3.0, 6.0, 20.0])
def test_exp_is_exact_across_the_small_angle_switch(angle: float):
    """Where series and closed form meet, neither loses digits; several turns are fine too."""
    twist = np.array([0.6, 0.0, 0.8, 0, 0, 0]) * angle + np.array([0, 0, 0, 1.0, -2.0, 0.5])
    np.testing.assert_allclose(exp(twist), expm(matrix(twist)), atol=1e-14)


@given(TWIST)
@settings(deadline=None, max_examples=100)
def test_inverse_undoes_a_pose(twist: np.ndarray):
    """A pose and its inverse cancel, on either side."""
    pose = exp(twist)
    np.testing.assert_allclose(pose @ inverse(pose), np.eye(4), atol=1e-12)
    np.testing.assert_allclose(inverse(pose) @ pose, np.eye(4), atol=1e-12)


@given(UNIT, UNIT)
@settings(deadline=None, max_examples=50)
def test_skew_crosses(a: np.ndarray, b: np.ndarray):
    """The skew matrix of a times b is a x b."""
    np.testing.assert_allclose(skew(a) @ b, np.cross(a, b), atol=1e-15)


def test_batches_are_their_rows():
    """Any leading shape is worked row by row, large and tiny angles side by side."""
    rng = np.random.default_rng(1)
    twists = rng.normal(size=(3, 4, 6)) * np.array([1e-9, 1e-5, 1e-2, 1.0])[:, None]
    poses = exp(twists)
    assert poses.shape == (3, 4, 4, 4)
    for at in np.ndindex(3, 4):
        np.testing.assert_array_equal(poses[at], exp(twists[at]))
        np.testing.assert_array_equal(inverse(poses)[at], inverse(poses[at]))


def test_roll_pitch_yaw_are_urdfs():
    """Roll, pitch, yaw turn about the fixed x, y, z axes in that order, as in URDF and as SciPy's
    lower-case "xyz".
    """
    rpy = (0.3, -0.7, 1.9)
    pose = pose_of((0.1, 0.2, 0.3), rpy)
    np.testing.assert_allclose(
        pose[:3, :3], Rotation.from_euler("xyz", rpy).as_matrix(), atol=1e-15
    )
    np.testing.assert_array_equal(pose[:3, 3], [0.1, 0.2, 0.3])
    np.testing.assert_array_equal(pose[3], [0, 0, 0, 1])


def test_a_quarter_turn_takes_x_to_y():
    """A quarter turn about z takes a point on x to y; a shift moves it on."""
    moved = shift(0, 0, 0.5) @ turn((0, 0, 1), math.pi / 2) @ [1, 0, 0, 1]
    np.testing.assert_allclose(moved, [0, 1, 0.5, 1], atol=1e-15)


def test_one_vector_is_mapped_to_the_bits_of_many():
    """The matrix product, to rounding, and for one vector exactly as among others."""
    rng = np.random.default_rng(2)
    matrix, vectors = rng.normal(size=(6, 6)), rng.normal(size=(40, 6))
    found = mapped(matrix, vectors)
    np.testing.assert_allclose(found, vectors @ matrix.T, rtol=1e-13, atol=1e-15)
    for k in range(40):
        np.testing.assert_array_equal(mapped(matrix, vectors[k : k + 1])[0], found[k])
        assert mapped(matrix[0], vectors[k : k + 1])[0] == found[k, 0]
