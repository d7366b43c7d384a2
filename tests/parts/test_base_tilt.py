"""The tilt of the base that nobody measured: the tool's error, gravity, and a share of its own."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lostmotion.error_model.budget import Tally, costs
from lostmotion.error_model.pose_matrix import screws
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.state import state_of
from lostmotion.parts.base import Base
from lostmotion.parts.joint import RevoluteJoint
from lostmotion.spatial import pose_of
from lostmotion.units import Toleranced
from tests.parts.conditions import (
    STEEL,
    at_tool,
    condition,
    drawn,
    terms_at,
)
from tests.parts.test_base import GROUND


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


@pytest.mark.parametrize(
    ("roll", "pitch"), [(0.0, 0.0), (0.3, 0.0), (0.0, -0.4), (0.3, -0.4), (-1.0, 0.9)]
)
def test_a_tilt_that_nobody_measured_moves_the_tool_as_the_exact_rotation_does(
    roll: float, pitch: float
):
    """The error of base roll and pitch at the tool is the derivative of the exactly rotated tool
    position, seen in the base's axes.
    """
    arm = Arm(
        name="arm",
        base=Base(roll=Toleranced(roll, 0.01), pitch=Toleranced(pitch, 0.01)),
        joints=[
            RevoluteJoint(
                name="A", limits=(-4, 4), origin={"xyz": (0.1, 0.2, 0.3)}, link={"length": 0.7}
            )
        ],
    )
    point = np.array([0.1 + 0.7 * math.cos(0.4), 0.2 + 0.7 * math.sin(0.4), 0.3])
    level = pose_of(rpy=(roll, pitch, 0))[:3, :3]
    step = 1e-6
    for item, twist in at_tool(arm, [0.4]):
        by = (step, 0.0) if item.term.name == "roll" else (0.0, step)
        ahead, behind = (
            pose_of(rpy=(roll + s * by[0], pitch + s * by[1], 0))[:3, :3] for s in (1, -1)
        )
        exact = level.T @ (ahead - behind) @ point / (2 * step)
        np.testing.assert_allclose(twist[3:] * item.term.bound, exact * 0.01, atol=1e-11)


def test_a_tilted_base_turns_gravity():
    """A base rolled by a quarter turn about x has gravity along its own -y; one pitched nose down
    has it towards its nose.
    """
    joints = [RevoluteJoint(name="A", limits=(-1, 1))]
    rolled = Arm(name="arm", joints=joints, base=Base(roll=math.pi / 2)).gravity_in_base
    np.testing.assert_allclose(rolled, [0, -9.80665, 0], atol=1e-12)
    nose_down = Arm(name="arm", joints=joints, base=Base(pitch=math.pi / 2)).gravity_in_base
    np.testing.assert_allclose(nose_down, [9.80665, 0, 0], atol=1e-12)


@pytest.mark.parametrize("varies", ["robot", "visit"])
def test_a_mobile_base_stands_differently_every_time(varies: str):
    """The tilt of a base that is set down once belongs to the robot, of a mobile one to the
    visit.
    """
    found = terms_at(
        Base(roll=Toleranced(0, 0.01), pitch=Toleranced(0, 0.02), tilt_varies=varies), condition()
    )
    assert {term.level for term in found} == {varies}
    angles = drawn(found, 10_000)[:, 0]
    assert 0.009 < np.abs(angles[:, 0]).max() <= 0.01
    assert 0.018 < np.abs(angles[:, 1]).max() <= 0.02


def test_a_tilt_that_nobody_measured_is_a_part_of_its_own():
    """The budget names the tilt and the mount apart, and the tilt's share is the mean square of
    both angles times the tool's lever.
    """
    tilted = arm_on(Base(roll=Toleranced(0, 0.01), pitch=Toleranced(0, 0.01), tracks=GROUND))
    matrix = screws(state_of(tilted, Q))
    by_part = {cost.part: cost for cost in costs(Tally.of(matrix))}
    assert {"base tilt", "base mount"} <= set(by_part)
    tool = matrix.state.frames[-1, :, :3, 3]
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
    level, tilted = (
        screws(state_of(arm_on(Base(**{axis: size})), Q)).bias[:, 3:] for size in (0.0, angle)
    )
    drawn = screws(state_of(arm_on(Base(**{axis: Toleranced(0.0, angle)})), Q))
    (column,) = drawn.columns("robot")
    itself = np.linalg.norm(drawn.tool[:, 3:, column], axis=1) * drawn.infos[column].bound
    change = np.linalg.norm(tilted - level, axis=1)
    assert (change < 0.02 * itself).all()
    twice = np.linalg.norm(
        screws(state_of(arm_on(Base(**{axis: 2 * angle})), Q)).bias[:, 3:] - level, axis=1
    )
    np.testing.assert_allclose(twice, 2 * change, rtol=0.05, atol=1e-9)
    assert change.max() > 0
