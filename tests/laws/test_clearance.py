"""Play as a dead band that the load closes on one side."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lostmotion.laws.clearance import seated

# Squares of smaller loads have no digits left.
LOADS = st.floats(-1e6, 1e6).map(lambda load: load if abs(load) > 1e-100 else 0.0)


@given(st.lists(LOADS, min_size=1, max_size=20), st.floats(0, 1e6), st.floats(0, 1e6))
@settings(deadline=None, max_examples=200)
def test_a_part_never_leaves_its_play(loads: list[float], friction: float, more: float):
    """Whatever the load and the friction, a part rests within its play, on the side to which the load pushes it."""
    load = np.array(loads)
    at = seated(load, friction, np.abs(load) + more)
    assert (np.abs(at) <= 1).all()
    assert (at * load >= 0).all()


def test_without_friction_any_load_closes_the_play():
    """Without friction the smallest load closes the play to its side; no load leaves it open."""
    np.testing.assert_array_equal(seated(np.array([-1e-3, 0.0, 1e-3, 5.0]), 0.0, np.full(4, 5.0)), [-1, 0, 1, 1])


def test_below_the_friction_the_position_is_proportional_to_the_load():
    """At half the friction the part rests at half of its half play; from the full friction on, at its end."""
    np.testing.assert_allclose(seated(np.array([-4.0, -1.0, 0.0, 1.0, 2.0, 9.0]), 2.0, np.full(6, 9.0)), [-1, -0.5, 0, 0.5, 1, 1])


@pytest.mark.parametrize("friction", [0.0, 1e-9])
def test_rounding_is_not_a_load(friction: float):
    """A load of 1e-10 of the whole wrench is rounding and closes nothing; one of 1e-8 is a load."""
    np.testing.assert_array_equal(seated(np.array([1e-7, -1e-7]), friction, np.full(2, 1e3)), [0, 0])
    np.testing.assert_array_equal(seated(np.array([1e-5, -1e-5]), friction, np.full(2, 1e3)), [1, -1])
