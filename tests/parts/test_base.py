"""What the arm stands on: mounts by stiffness, by matrix and on tracks."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from lostmotion.parts.base import Base, Tracks
from tests.parts.conditions import condition, design, terms_at, visit_size

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "compliance of a base on tracks",
        "4 800 single springs below a rigid plate",
        "0.1 %",
        "laws/elastic_foundation.py",
    ),
)

GROUND = {
    "length": 0.9,
    "width": 0.2,
    "gauge": 0.6,
    "bedding": 5e7,
    "shear_share": 0.4,
    "middle": (0.1, -0.05, -0.4),
}


def test_a_matrix_gives_as_the_diagonal_it_holds():
    """A diagonal compliance is the same mount as its stiffnesses, and its scatter is that share of
    the deflection.
    """
    stiff = np.array([1e5, 2e5, 3e5, 1e7, 2e7, 3e7])
    by_axis = Base(angular_stiffness=stiff[:3], linear_stiffness=stiff[3:])
    matrix = Base(compliance={"matrix": np.diag(1 / stiff).tolist(), "scatter": 0.1})
    load = condition([30.0, -20, 10, 100, 200, -700])
    np.testing.assert_allclose(
        design(terms_at(matrix, load)), design(terms_at(by_axis, load)), rtol=1e-12
    )
    scatter = terms_at(matrix, load)[1]
    np.testing.assert_allclose(
        scatter.screw * scatter.bound, 0.1 * design(terms_at(by_axis, load)), rtol=1e-12
    )


def test_tracks_stand_on_springs_all_over():
    """The compliance on tracks is that of a rigid plate on 2 x 60 x 40 little springs under both
    tracks, each on its own, seen from the base.
    """
    tracks = Tracks(**GROUND)
    nx, ny = 60, 40
    x = (np.arange(nx) + 0.5) / nx * 0.9 - 0.45
    y = np.concatenate([side + (np.arange(ny) + 0.5) / ny * 0.2 - 0.1 for side in (-0.3, 0.3)])
    stiff = np.zeros((6, 6))
    for px in x:
        for py in y:
            arm = np.add(GROUND["middle"], (px, py, 0.0))
            shift = np.hstack(
                [
                    -np.array([[0, -arm[2], arm[1]], [arm[2], 0, -arm[0]], [-arm[1], arm[0], 0]]),
                    np.eye(3),
                ]
            )
            stiff += shift.T @ np.diag([0.4, 0.4, 1.0]) @ shift * (5e7 * 0.9 * 0.2 / (nx * ny))
    scale = np.sqrt(np.diag(tracks.values))
    np.testing.assert_allclose(
        tracks.values / np.outer(scale, scale),
        np.linalg.inv(stiff) / np.outer(scale, scale),
        atol=1e-3,
    )


@pytest.mark.parametrize(
    ("fields", "why"),
    [
        (
            {"compliance": {"matrix": (np.eye(6) * 1e-6).tolist()}, "tracks": GROUND},
            "compliance beside tracks",
        ),
        ({"tracks": GROUND, "linear_stiffness": (1e7, 1e7, 1e7)}, "linear_stiffness beside tracks"),
        (
            {"compliance": {"matrix": (np.eye(6) * 1e-6).tolist(), "own_weight": [[0.0] * 3] * 6}},
            "own weight",
        ),
        ({"tracks": {**GROUND, "shear_share": 1.5}}, "out of range"),
    ],
)
def test_a_base_stands_on_one_thing(fields: dict[str, object], why: str):
    """Two mounts at once, and a mount with a weight, are refused."""
    with pytest.raises(ValidationError, match=why):
        Base(**fields)


def test_a_mount_gives_in_six_directions():
    """A mount moves by load over stiffness, direction by direction; where no stiffness is stated it
    is rigid.
    """
    load = (10.0, -20.0, 30.0, 100.0, 200.0, -300.0)
    whole = Base(angular_stiffness=(1e5, 2e5, 3e5), linear_stiffness=(1e8, 2e8, 3e8))
    np.testing.assert_allclose(
        design(terms_at(whole, condition(load)))[0],
        [1e-4, -1e-4, 1e-4, 1e-6, 1e-6, -1e-6],
        rtol=1e-12,
    )
    turning = Base(angular_stiffness=(1e5, 2e5, 3e5))
    np.testing.assert_allclose(
        design(terms_at(turning, condition(load)))[0], [1e-4, -1e-4, 1e-4, 0, 0, 0], rtol=1e-12
    )
    sinking = Base(linear_stiffness=(1e8, 2e8, 3e8))
    np.testing.assert_allclose(
        design(terms_at(sinking, condition(load)))[0], [0, 0, 0, 1e-6, 1e-6, -1e-6], rtol=1e-12
    )
    assert visit_size(terms_at(whole, condition(load))) == 0
