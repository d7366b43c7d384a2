"""Lumped errors: limits, directions and levels."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lostmotion.parts.joint import RevoluteJoint
from lostmotion.parts.lumped import Lumped
from lostmotion.parts.mounting import Mounting
from tests.parts.conditions import (
    TURN_Z,
    condition,
    drawn,
    terms_at,
)


def test_from_zero_to_maximum_is_read_as_a_cut_normal_law():
    """The paper's 'normal, from zero to maximum': mean max/2, three sigma reach both ends, none
    outside.
    """
    angles = drawn(terms_at(Lumped(angle=6e-3, law="from zero to maximum"), condition()), 20_000)[
        :, 0, 2
    ]
    assert angles.min() >= 0
    assert angles.max() <= 6e-3
    assert angles.mean() == pytest.approx(3e-3, rel=0.01)
    assert angles.std() == pytest.approx(1e-3 * 0.98658, rel=0.02)


@pytest.mark.parametrize(
    ("law", "deviation"),
    [("normal", 0.98658 / 3), ("uniform", 1 / math.sqrt(3)), ("two-sided", 1.0)],
)
def test_a_lumped_angle_stays_within_its_limit(law: str, deviation: float):
    """A lumped angle ± a never leaves ± a and scatters as its law says."""
    angles = drawn(terms_at(Lumped(angle=1e-3, law=law), condition()), 20_000)[:, 0, 2]
    assert np.abs(angles).max() <= 1e-3 * (1 + 1e-12)
    assert angles.std() == pytest.approx(1e-3 * deviation, rel=0.02)


def test_a_lumped_offset_shifts_along_the_named_axes():
    """A lumped offset is uniform and independent along each named direction of the joint's frame,
    and turns nothing.
    """
    moved = drawn(terms_at(Lumped(offset=3e-5, offset_along=["x", "z"]), condition()), 20_000)[:, 0]
    assert not moved[:, [0, 1, 2, 4]].any()
    np.testing.assert_allclose(moved[:, [3, 5]].std(axis=0), 3e-5 / math.sqrt(3), rtol=0.02)
    assert np.abs(moved).max() <= 3e-5
    assert np.corrcoef(moved[:, 3], moved[:, 5])[0, 1] == pytest.approx(0, abs=0.03)


def test_lumped_errors_are_drawn_per_visit_or_per_robot_as_stated():
    """A lumped error differs from visit to visit unless it is stated as a property of the robot."""
    assert {term.level for term in terms_at(Lumped(angle=1e-3, offset=1e-5), condition())} == {
        "visit"
    }
    assert {
        term.level
        for term in terms_at(Lumped(angle=1e-3, offset=1e-5, varies="robot"), condition())
    } == {"robot"}


def test_a_part_shows_what_was_stated():
    """A part prints its stated fields and leaves the others out."""
    assert repr(Lumped(angle=1e-3)) == "Lumped(angle=0.001)"
    assert repr(Mounting()) == "Mounting()"
    assert TURN_Z.tolist() == RevoluteJoint(name="A", limits=(-1, 1)).twist.tolist()
