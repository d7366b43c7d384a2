"""Joints: their axes, their parts, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError

from lostmotion.parts.joint import FixedJoint, PrismaticJoint, RevoluteJoint
from tests.parts.conditions import (
    SLIDE_Z,
    encoder,
)


def test_a_lead_belongs_to_sliding_joints():
    """On a turning joint the encoder's lead says nothing and is refused."""
    with pytest.raises(ValidationError, match="a lead on a turning joint"):
        encoder(eccentricity=1e-3, lead=0.01)


def test_a_joint_lists_its_parts_and_a_fixed_joint_has_none():
    """A joint names the parts that err, a sliding one too; a fixed joint has nothing that moves."""
    slide = PrismaticJoint(
        name="S",
        limits=(0, 1),
        gearbox={"backlash": 1e-5},
        bearing={"kind": "rolling", "span": 0.1},
        lumped={"angle": 1e-6},
    )
    assert set(slide.sources) == {"gearbox", "bearing", "lumped"}
    assert FixedJoint(name="F").sources == {}
    assert not FixedJoint(name="F").twist.any()


@pytest.mark.parametrize(
    "fields",
    [
        {"name": "A", "limits": (1, -1)},
        {"name": "A", "limits": (1, 1)},
        {"name": "A", "limits": (-1, 1), "axis": (0, 0, 0)},
        {"name": "A", "limits": (-1, 1), "axis": (0, 0, math.nan)},
        {"name": "", "limits": (-1, 1)},
        {"name": "A\nB", "limits": (-1, 1)},
        {"name": "A", "limits": (-1, 1), "mass": -1.0},
    ],
)
def test_a_joint_that_cannot_be_is_refused(fields: dict[str, object]):
    """Limits must rise, an axis must point somewhere, a name be a plain word and a mass not
    negative.
    """
    with pytest.raises(ValidationError):
        RevoluteJoint(**fields)


def test_any_direction_may_be_an_axis():
    """An axis is a direction: its length does not matter, and "-z" is the opposite of "z"."""
    tilted = RevoluteJoint(name="A", limits=(-1, 1), axis=(0, 3, 4))
    np.testing.assert_allclose(tilted.twist, [0, 0.6, 0.8, 0, 0, 0])
    np.testing.assert_array_equal(
        PrismaticJoint(name="A", limits=(-1, 1), axis="-z").twist, -SLIDE_Z
    )
