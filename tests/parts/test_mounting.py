"""Mounting of a joint: tilt and offset of its axis."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from pydantic import ValidationError

from lostmotion.mechanism.arm import Arm
from lostmotion.parts.joint import FixedJoint, RevoluteJoint
from lostmotion.parts.mounting import Mounting
from tests.parts.conditions import (
    TURN_Z,
    at_tool,
    condition,
    only,
    terms_at,
)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.6, 0, 0.8)])
@pytest.mark.parametrize("slides", [False, True])
def test_a_joint_is_mounted_askew_across_its_axis_only(axis: tuple[float, ...], *, slides: bool):
    """Mounting tilts and offsets an axis in the two directions across it, equally, once per robot,
    and never along it.
    """
    direction = np.array(axis)
    twist = np.concatenate([np.zeros(3), direction] if slides else [direction, np.zeros(3)])
    found = terms_at(Mounting(tilt=1e-3, offset=2e-4), condition(axis=twist))
    assert {term.level for term in found} == {"robot"}
    total = sum(np.outer(term.screw, term.screw) * term.bound**2 for term in found)
    across = np.eye(3) - np.outer(direction, direction)
    np.testing.assert_allclose(total[:3, :3], 1e-6 * across, atol=1e-18)
    np.testing.assert_allclose(total[3:, 3:], 4e-8 * across, atol=1e-18)


def test_a_badly_mounted_axis_does_not_turn_with_its_joint():
    """The tilt of a joint's axis stays in the link before: half a turn of the joint leaves the tilt
    of the tool as it was.
    """
    arm = Arm(
        name="arm",
        joints=[
            RevoluteJoint(
                name="A", limits=(-4, 4), axis="z", mounting={"tilt": 1e-3}, link={"length": 0.5}
            )
        ],
    )
    for angle in (0.0, 1.0, math.pi):
        turned = np.array(
            [
                twist[:3] * item.term.bound
                for item, twist in at_tool(arm, [angle])
                if "mounting" in item.owner
            ]
        )
        np.testing.assert_allclose(turned.T @ turned, np.diag([1e-6, 1e-6, 0]), atol=1e-18)
        if angle == 0.0:
            first = turned
        np.testing.assert_allclose(turned, first, atol=1e-15)


def test_a_fixed_joint_can_be_mounted_askew():
    """A flange has a mounting error too, about the two directions across its z."""
    arm = Arm(
        name="arm",
        joints=[
            RevoluteJoint(name="A", limits=(-4, 4)),
            FixedJoint(name="F", mounting={"tilt": 1e-3, "offset": 1e-4}),
        ],
    )
    found = [twist for item, twist in at_tool(arm, [0.0]) if "mounting" in item.owner]
    assert len(found) == 4
    assert all(abs(twist[2]) < 1e-15 and abs(twist[5]) < 1e-15 for twist in found)


def test_a_mounting_by_direction_has_the_stated_limit_about_and_along_each_axis_of_the_seat():
    """Independent of each other, also about and along the axis itself; `axes` turns the directions,
    here by a quarter about z: x becomes y.
    """
    limits = ["1 mrad", "0 rad", "3 mrad"], ["0 mm", "20 µm", "0 µm ± 30 µm (uniform)"]
    stated = dict(zip(("tilt", "offset"), limits, strict=True))
    turned = {**stated, "axes": ["0 deg", "0 deg", "90 deg"]}
    for tree, x in ((stated, np.eye(3)[0]), (turned, np.eye(3)[1])):
        found = terms_at(
            Mounting.model_validate(tree, context={"text": True}), condition(axis=TURN_Z)
        )
        names = ["axis tilt x", "axis tilt z", "axis offset y", "axis offset z"]
        assert [term.name for term in found] == names
        np.testing.assert_allclose(only(found, names[0])[:3], 1e-3 * x, atol=1e-15)
        np.testing.assert_allclose(only(found, names[1]), [0, 0, 3e-3, 0, 0, 0], atol=1e-15)
        np.testing.assert_allclose(only(found, names[3]), [0, 0, 0, 0, 0, 30e-6], atol=1e-15)


@pytest.mark.parametrize("wrong", ['"-1 mrad"', '"1 mrad ± 2 mrad"', '"1 mm"', "0.001"])
def test_a_direction_of_a_mounting_takes_a_limit(wrong):
    """Not below zero, around zero, with a unit."""
    with pytest.raises(ValidationError):
        Mounting.model_validate(
            {"tilt": [json.loads(wrong), "0 rad", "0 rad"]}, context={"text": True}
        )
