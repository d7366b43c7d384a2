"""Bearings: where the clearance lets the axis go, what gives under load, and which way runout
points.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from scipy.spatial.transform import Rotation

from lostmotion.mechanism.arm import Arm
from lostmotion.parts.bearing.crossed_roller import CrossedRoller
from lostmotion.parts.bearing.rolling import RollingPair
from lostmotion.parts.joint import PrismaticJoint, RevoluteJoint
from lostmotion.units import Toleranced
from tests.parts.conditions import (
    ARCMIN,
    SLIDE_Z,
    TURN_Z,
    at_tool,
    condition,
    design,
    drawn,
    terms_at,
    visit_size,
)

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "bearing tilt and displacement",
        "clearance over span; half the clearance",
        "exact",
    ),
)

GAP, SPAN = 60e-6, 0.05
PAIR = RollingPair(clearance=GAP, span=SPAN)
LOAD = st.tuples(*[st.one_of(st.just(0.0), st.floats(-1e3, 1e3))] * 6)


def test_a_moment_tilts_the_axis_by_the_clearance_over_the_span():
    """A pure moment sets two bearings against opposite sides: the axis tilts by exactly G/B, with
    the moment, and does not shift.
    """
    moment = np.array([3.0, -4.0, 0.0])
    error = design(terms_at(PAIR, condition([*moment, 0, 0, 0])))[0]
    np.testing.assert_allclose(error[:3], moment / 5 * GAP / SPAN, rtol=1e-12)
    np.testing.assert_allclose(error[3:], 0, atol=1e-18)


def test_sixty_micrometres_over_fifty_millimetres_are_four_arc_minutes():
    """The largest working clearance of the paper, on a short shaft, tilts the axis by 4.1', more
    than its whole angle budget of 3.27'.
    """
    tilt = np.linalg.norm(design(terms_at(PAIR, condition([1, 0, 0, 0, 0, 0])))[0, :3])
    assert tilt / ARCMIN == pytest.approx(4.1, abs=0.05)


def test_a_radial_force_shifts_the_axis_by_half_the_clearance():
    """A pure radial force sets both bearings against the same side: the axis shifts by exactly G/2,
    with the force, and does not tilt.
    """
    error = design(terms_at(PAIR, condition([0, 0, 0, 6.0, 8.0, 0])))[0]
    np.testing.assert_allclose(
        error, [0, 0, 0, 0.6 * GAP / 2, 0.8 * GAP / 2, 0], rtol=1e-12, atol=1e-18
    )


def test_drive_torque_and_thrust_leave_the_radial_clearance_alone():
    """A torque about the axis and a force along it load no bearing radially: the clearance stays
    open all round.
    """
    found = terms_at(PAIR, condition([0, 0, 50.0, 0, 0, 70.0]))
    assert not design(found).any()
    assert visit_size(found) > 0


@given(LOAD, st.floats(0, 100), st.floats(0, 1))
@example((0.0, 6e-162, 0.0, 0.0, 0.0, 0.0), 0.0, 0.0)  # of which the square has one digit
@settings(deadline=None, max_examples=100)
def test_no_axis_leaves_its_bearings(load: tuple[float, ...], closing: float, share: float):
    """Whatever the load, no axis in clearances G ± t tilts beyond (G + t)/B nor shifts beyond (G +
    t)/2; each bearing stays in its gap.
    """
    pair = RollingPair(clearance=Toleranced(GAP, share * GAP), span=SPAN, closing_force=closing)
    errors = drawn(terms_at(pair, condition(load)), 500)[:, 0]
    largest = GAP * (1 + share) * (1 + 1e-9)
    assert np.linalg.norm(errors[:, :3], axis=1).max() <= largest / SPAN
    assert np.linalg.norm(errors[:, 3:5], axis=1).max() <= largest / 2
    for side in (-SPAN / 2, SPAN / 2):
        at_bearing = errors[:, 3:] + np.cross(errors[:, :3], [0, 0, side])
        assert np.linalg.norm(at_bearing[:, :2], axis=1).max() <= largest / 2


def test_each_bearing_follows_its_own_reaction():
    """Under a force beyond the outboard bearing the inboard one is pushed the other way, as the
    lever's balance says.
    """
    force, beyond = np.array([0.0, -100.0, 0.0]), 0.2
    moment = np.cross([0, 0, beyond], force)
    pair = RollingPair(clearance=GAP, span=SPAN, radial_stiffness=1e8)
    found = terms_at(pair, condition([*moment, *force]))
    # Balance about each bearing in turn gives what the other one carries.
    outboard = force * (beyond + SPAN / 2) / SPAN
    inboard = force - outboard
    for side, reaction in ((SPAN / 2, outboard), (-SPAN / 2, inboard)):
        error = design(found)[0]
        at_bearing = error[3:] + np.cross(error[:3], [0, 0, side])
        expected = reaction / np.linalg.norm(reaction) * GAP / 2 + reaction / 1e8
        np.testing.assert_allclose(at_bearing, expected, atol=1e-15)


def test_two_springs_at_a_distance_resist_shift_and_tilt():
    """Two bearings of stiffness k at span B resist a shift with 2 k and a tilt with k B^2/2."""
    pair = RollingPair(span=SPAN, radial_stiffness=1e8, axial_stiffness=3e8)
    error = design(terms_at(pair, condition([10.0, 0, 99.0, 0, 50.0, 70.0])))[0]
    np.testing.assert_allclose(
        error, [10 / (1e8 * SPAN**2 / 2), 0, 0, 0, 50 / 2e8, 70 / 3e8], rtol=1e-12, atol=1e-20
    )


def test_what_is_free_lies_on_a_circle_in_each_bearing():
    """Unloaded, each bearing rests somewhere on the circle of radius G/2 that its clearance leaves,
    uniformly in all directions.
    """
    errors = drawn(terms_at(PAIR, condition()), 4000)[:, 0]
    for side in (-SPAN / 2, SPAN / 2):
        at_bearing = (errors[:, 3:] + np.cross(errors[:, :3], [0, 0, side]))[:, :2]
        np.testing.assert_allclose(np.linalg.norm(at_bearing, axis=1), GAP / 2, rtol=1e-12)
        assert np.abs(at_bearing.mean(axis=0)).max() < GAP / 2 * 0.05
    assert np.corrcoef(errors[:, 0], errors[:, 4])[0, 1] == pytest.approx(0, abs=0.08)


def test_clearances_differ_from_bearing_to_bearing_loaded_or_not():
    """With clearance 40 µm ± 20 µm the axis of some robots shifts by near 30 µm and of some by near
    10 µm, held by a load or not.
    """
    pair = RollingPair(clearance=Toleranced(40e-6, 20e-6, "uniform"), span=SPAN)
    for load in ((0, 0, 0, 0, 0, 0), (0, 0, 0, 100.0, 0, 0)):
        errors = drawn(terms_at(pair, condition(load)), 4000)[:, 0]
        at_bearing = np.linalg.norm(
            (errors[:, 3:] + np.cross(errors[:, :3], [0, 0, SPAN / 2]))[:, :2], axis=1
        )
        assert 29.5e-6 < at_bearing.max() <= 30e-6 * (1 + 1e-9)
        assert 10e-6 * (1 - 1e-9) <= at_bearing.min() < 10.5e-6


def test_the_load_holds_a_closed_bearing_where_it_is():
    """Under a load above the closing force the position in the clearance is the same at every
    visit; at that force in half of the robots.
    """
    pair = RollingPair(clearance=GAP, span=SPAN, closing_force=10.0)
    assert visit_size(terms_at(pair, condition([0, 0, 0, 30.0, 0, 0]))) == 0
    # Each of the two bearings takes half of the force.
    half = terms_at(pair, condition([0, 0, 0, 20.0, 0, 0]))
    assert design(half)[0, 3] == pytest.approx(GAP / 4)
    assert visit_size(half) > 0


def test_axial_play_lies_where_the_thrust_pushes():
    """Thrust closes the axial play to its side; without thrust the axis rests at one end or the
    other.
    """
    pair = RollingPair(span=SPAN, axial_play=Toleranced(2e-5, 1e-5, "uniform"))
    assert design(terms_at(pair, condition([0, 0, 0, 0, 0, -5.0])))[0, 5] == pytest.approx(-1e-5)
    assert visit_size(terms_at(pair, condition([0, 0, 0, 0, 0, -5.0]))) == 0
    ends = drawn(terms_at(pair, condition()), 4000)[:, 0, 5]
    assert not design(terms_at(pair, condition())).any()
    assert np.abs(ends).min() >= 0.5e-5 * (1 - 1e-9)
    assert 1.49e-5 < np.abs(ends).max() <= 1.5e-5 * (1 + 1e-9)
    assert ends.min() < 0 < ends.max()


def test_along_a_slide_the_drive_holds():
    """On a sliding joint neither axial play nor axial deflection of the guide counts: the drive
    holds that direction.
    """
    pair = RollingPair(span=SPAN, axial_play=2e-5, axial_stiffness=1e8)
    assert terms_at(pair, condition([0, 0, 0, 0, 0, 50.0], axis=SLIDE_Z)) == []
    crossed = CrossedRoller(axial_stiffness=1e8, radial_runout=1e-5, axial_runout=1e-5)
    assert terms_at(crossed, condition([0, 0, 0, 0, 0, 50.0], axis=SLIDE_Z)) == []


@pytest.mark.parametrize(
    "fields",
    [
        {"kind": "rolling", "span": SPAN, "axial_play": 2e-5},
        {"kind": "rolling", "span": SPAN, "axial_stiffness": 1e8},
        {"kind": "crossed roller", "axial_stiffness": 1e8},
        {"kind": "crossed roller", "radial_runout": 1e-5},
        {"kind": "crossed roller", "axial_runout": 1e-5},
    ],
)
def test_a_guide_is_not_given_what_it_cannot_use(fields: dict[str, object]):
    """A sliding joint refuses by name what would not count there; the same bearing stands on a
    turning joint.
    """
    with pytest.raises(ValidationError) as caught:
        PrismaticJoint(name="S", limits=(0, 1), bearing=fields)
    (error,) = caught.value.errors()
    assert error["loc"][0] == "bearing"
    assert error["ctx"]["why"] == f"{list(fields)[-1]} of a bearing on a sliding joint"
    assert RevoluteJoint(name="A", limits=(0, 1), bearing=fields).bearing is not None


def test_a_guide_takes_what_acts_across_it():
    """Clearance, radial and tilting stiffness stay on a sliding joint, and so does a stated
    zero.
    """
    for fields in (
        {
            "kind": "rolling",
            "span": SPAN,
            "clearance": GAP,
            "radial_stiffness": 1e8,
            "axial_play": 0.0,
        },
        {
            "kind": "crossed roller",
            "moment_stiffness": 1e5,
            "radial_stiffness": 1e8,
            "radial_runout": 0.0,
        },
    ):
        assert terms_at(
            PrismaticJoint(name="S", limits=(0, 1), bearing=fields).bearing,
            condition([1.0] * 6, axis=SLIDE_Z),
        )


@given(LOAD, st.tuples(*[st.floats(-3, 3)] * 3))
@settings(deadline=None, max_examples=60)
def test_space_has_no_preferred_direction(load: tuple[float, ...], rotvec: tuple[float, ...]):
    """A bearing turned in space, axis, load and all, errs by the same screw turned."""
    turn = Rotation.from_rotvec(rotvec).as_matrix()
    turn6 = np.kron(np.eye(2), turn)
    for part in (
        RollingPair(
            clearance=GAP,
            span=SPAN,
            radial_stiffness=1e8,
            axial_stiffness=1e8,
            axial_play=1e-5,
            closing_force=50.0,
        ),
        CrossedRoller(moment_stiffness=1e5, radial_stiffness=1e8, axial_stiffness=2e8),
    ):
        straight = design(terms_at(part, condition(load)))
        turned = design(terms_at(part, condition(turn6 @ load, axis=turn6 @ TURN_Z)))
        np.testing.assert_allclose(turned, straight @ turn6.T, atol=1e-12)


def test_a_crossed_roller_bearing_gives_in_three_ways():
    """A crossed-roller bearing tilts with the moment across its axis, shifts with the radial force
    and with the thrust; drive torque does nothing.
    """
    part = CrossedRoller(moment_stiffness=1e5, radial_stiffness=2e8, axial_stiffness=4e8)
    error = design(terms_at(part, condition([30.0, -20.0, 55.0, 100.0, 200.0, 400.0])))[0]
    np.testing.assert_allclose(error, [3e-4, -2e-4, 0, 5e-7, 1e-6, 1e-6], rtol=1e-12, atol=1e-20)


def runout_at_tool(**runout: float) -> np.ndarray:
    """Return where one robot's tool, on the axis of a single joint, is moved over a turn: (angle,
    3) in the base's axes.
    """
    arm = Arm(
        name="spindle",
        joints=[
            RevoluteJoint(name="A", limits=(-4, 4), bearing={"kind": "crossed roller", **runout})
        ],
    )
    phase = 0.13
    out = []
    for angle in np.linspace(0, 2 * np.pi, 361):
        moved = np.zeros(3)
        for item, twist in at_tool(arm, [angle]):
            if item.term.robot is not None:
                moved = moved + twist[3:] * item.term.robot.law.quantile(np.array(phase))
        out.append(moved)
    return np.array(out)


def test_radial_runout_turns_with_the_joint():
    """The high spot of a turning ring goes round once a turn: an indicator reads the stated runout
    from any side, and none along the axis.
    """
    moved = runout_at_tool(radial_runout=1e-5)
    np.testing.assert_allclose(np.linalg.norm(moved, axis=1), 0.5e-5, rtol=1e-9)
    for side in (0.0, 0.6, 2.0):
        reading = moved @ [math.cos(side), math.sin(side), 0]
        assert np.ptp(reading) == pytest.approx(1e-5, rel=1e-3)
        assert (np.diff(np.sign(reading - 1e-12)) != 0).sum() == 2
    bearing_angle = np.unwrap(np.arctan2(moved[:, 1], moved[:, 0]))
    np.testing.assert_allclose(
        bearing_angle - bearing_angle[0], np.linspace(0, 2 * np.pi, 361), atol=1e-9
    )
    assert not moved[:, 2].any()


def test_axial_runout_rises_and_falls_once_a_turn():
    """An indicator on the axis reads the stated axial runout over a turn, one harmonic, and nothing
    across.
    """
    moved = runout_at_tool(axial_runout=1e-5)
    assert np.ptp(moved[:, 2]) == pytest.approx(1e-5, rel=1e-3)
    assert np.abs(np.fft.rfft(moved[:-1, 2]))[2:].max() < 1e-15
    assert not moved[:, :2].any()
