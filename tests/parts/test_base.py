"""What the arm stands on: mounts by matrix and on tracks, and the tilt that nobody measured."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError

from lostmotion.error_model.budget import Tally, costs
from lostmotion.error_model.pose_matrix import screws
from lostmotion.mechanism.arm import Arm
from lostmotion.parts.base import Base, Tracks
from lostmotion.parts.joint import RevoluteJoint
from lostmotion.units import Toleranced
from tests.parts.conditions import STEEL, condition, design, terms_at

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


def arm_on(base: Base) -> Arm:
    """Put two aluminium tubes with a payload on a base, every joint softer than most."""
    link = {
        "length": 0.5,
        "section": {"kind": "tube", "outer": 0.06, "wall": 0.003},
        "material": {**STEEL, "young": 70e9, "density": 2700.0},
    }
    gearbox = {"stiffness": 5e4}
    joints = [
        RevoluteJoint(name=name, limits=(-3, 3), axis="y", mass=4.0, gearbox=gearbox, link=link)
        for name in "AB"
    ]
    return Arm(name="arm", joints=joints, payload={"mass": 5.0}, base=base)


Q = np.array([[-0.9, 0.7], [0.2, -1.3], [-0.3, 0.1]])


def test_a_tilt_that_nobody_measured_is_a_part_of_its_own():
    """The budget names the tilt and the mount apart, and the tilt's share is the mean square of
    both angles times the tool's lever.
    """
    tilted = arm_on(Base(roll=Toleranced(0, 0.01), pitch=Toleranced(0, 0.01), tracks=GROUND))
    matrix = screws(tilted, Q)
    by_part = {cost.part: cost for cost in costs(Tally.of(matrix))}
    assert {"base tilt", "base mount"} <= set(by_part)
    tool = matrix.at[-1, :, :3, 3]
    lever = tool[:, 1] ** 2 + tool[:, 2] ** 2 + tool[:, 0] ** 2 + tool[:, 2] ** 2
    deviation = 0.01 / next(info.bound for info in matrix.infos if info.owner == "base tilt")
    assert by_part["base tilt"].alone == pytest.approx(
        deviation * math.sqrt(lever.mean()), rel=1e-9
    )


@pytest.mark.parametrize("axis", ["roll", "pitch"])
@pytest.mark.parametrize("angle", [0.002, 0.01])
def test_the_load_that_a_tilt_changes_is_small_beside_the_tilt(axis: str, angle: float):
    """With the tilt set, the arm's deflection changes by less than 2 % of the tilt's effect at the
    tool: it is neglected, and grows as the tilt.
    """
    level, tilted = (screws(arm_on(Base(**{axis: size})), Q).bias[:, 3:] for size in (0.0, angle))
    drawn = screws(arm_on(Base(**{axis: Toleranced(0.0, angle)})), Q)
    (column,) = drawn.columns("robot")
    itself = np.linalg.norm(drawn.tool[:, 3:, column], axis=1) * drawn.infos[column].bound
    change = np.linalg.norm(tilted - level, axis=1)
    assert (change < 0.02 * itself).all()
    twice = np.linalg.norm(screws(arm_on(Base(**{axis: 2 * angle})), Q).bias[:, 3:] - level, axis=1)
    np.testing.assert_allclose(twice, 2 * change, rtol=0.05, atol=1e-9)
    assert change.max() > 0
