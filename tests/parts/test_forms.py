"""What holds for forms by themselves: where a seat holds a part in its play, and how a curve runs
on.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lostmotion.parts.forms import Curve
from lostmotion.parts.play import HeldPlay, Seat
from lostmotion.parts.term import Condition, Motion
from lostmotion.units import Toleranced

# Squares of smaller loads have no digits left.
LOADS = st.floats(-1e6, 1e6).map(lambda load: load if abs(load) > 1e-100 else 0.0)
SHIFTS = np.hstack([np.zeros((3, 3)), np.eye(3)])


def under(forces):
    """Return what a place feels under forces (pose, 3)."""
    forces = np.atleast_2d(forces)
    return Condition(
        np.zeros(len(forces)),
        np.hstack([np.zeros_like(forces), forces]).T,
        np.zeros((3, len(forces))),
    )


@given(st.lists(st.tuples(LOADS, LOADS, LOADS), min_size=1, max_size=20), st.floats(0, 1e6))
@settings(deadline=None, max_examples=200)
def test_a_journal_never_leaves_its_clearance(loads, friction):
    """In a round clearance the part that the load holds and the part that is free add up to the
    radius, and it is held in the load's direction.
    """
    at, seat = under(loads), Seat(SHIFTS, Toleranced(friction))
    held, free = (
        HeldPlay(seat, "held").screw(at)[3:],
        HeldPlay(seat, "free", np.eye(6)[3]).screw(at)[3],
    )
    np.testing.assert_allclose(np.linalg.norm(held, axis=0) + free, 1.0, rtol=1e-12)
    assert (free >= 0).all()
    load = at.wrench[3:]
    np.testing.assert_allclose(
        np.cross(held.T, load.T), 0, atol=1e-9 * np.linalg.norm(load, axis=0).max(initial=1)
    )
    assert ((held * load).sum(axis=0) >= 0).all()


def test_a_journal_without_load_is_free_all_round():
    """Without load the last motion decides everything, and nothing is divided by zero."""
    at, seat = under(np.zeros((2, 3))), Seat(SHIFTS, Toleranced(0.0))
    np.testing.assert_array_equal(HeldPlay(seat, "held").screw(at), 0)
    np.testing.assert_array_equal(HeldPlay(seat, "free", np.eye(6)[3]).screw(at)[3], 1)


@given(
    st.lists(st.floats(0.1, 100), min_size=1, max_size=5),
    st.lists(st.floats(0.1, 100), min_size=1, max_size=5),
    st.floats(0, 1000),
)
@settings(deadline=None, max_examples=100)
def test_the_slope_of_a_curve_is_that_of_its_values(steps, rises, load):
    """Between knots and beyond the last the curve rises by its slope, and the slope is never below
    zero where the values rise.
    """
    count = min(len(steps), len(rises))
    knots, values = np.cumsum([0.0, *steps[:count]]), np.cumsum([0.0, *rises[:count]])
    curve = Curve.through(knots, values)
    step = 1e-7 * (1 + load)
    inside = np.abs(knots - load).min() > 2 * step
    rise = float(curve(np.array(load + step)) - curve(np.array(load))) / step
    assert not inside or rise == pytest.approx(float(curve.slope(np.array(load))), rel=1e-5)


def test_zones_of_stiffness_make_the_makers_sum():
    """K1, K2, K3: T1/K1 + (T2 - T1)/K2 + (T - T2)/K3, and straight on."""
    curve = Curve.of_zones([2.0, 4.0, 8.0], [10.0, 30.0])
    np.testing.assert_allclose(
        curve(np.array([0.0, 10.0, 20.0, 30.0, 46.0])), [0.0, 5.0, 7.5, 10.0, 12.0]
    )
    np.testing.assert_allclose(curve.slope(np.array([0.0, 10.0, 30.0])), [0.5, 0.25, 0.125])


def test_a_slide_without_a_lead_turns_nothing():
    """What counts turns on a sliding joint needs the lead of a screw."""
    slide = Motion(np.eye(6)[5])
    with pytest.raises(ValueError, match="without a lead"):
        slide.turns(None)
    assert slide.turns(0.01) == pytest.approx(200 * np.pi)
    assert Motion(np.eye(6)[2]).turns(None) is None
