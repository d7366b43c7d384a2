"""Load distribution and deformation of rolling bearings under radial load."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import ellipe, ellipk

from lostmotion.laws.rolling.radial import (
    BALL_EXPONENT,
    ROLLER_EXPONENT,
    ball_pressure,
    ball_stiffness,
    element_angles,
    point_pressure,
    point_stiffness,
    radial_shift,
    roller_pressure,
    roller_stiffness,
)
from tests.laws.closed_forms import element_loads

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "load on the balls and rollers of a bearing, and its pressure",
        (
            "Hertz in closed form; Harris's table 6.1; load factors 4.37 and 4.08; static ratings "
            "of ISO 76"
        ),
        "1e-9; 4e-4; 0.2 %; 0.5 %",
        "laws/rolling/radial.py",
    ),
)

UM = 1e-6
K_BALL = ball_stiffness(12.7e-3, 65e-3)


def radial_stiffness(load: float, clearance: float, angles: np.ndarray) -> float:
    """Return the slope (N/m) of a ball bearing's load over its shift, by central differences."""
    low, high = radial_shift(
        load * np.array([0.999, 1.001]), clearance, K_BALL, BALL_EXPONENT, angles
    )
    return float(0.002 * load / (high - low))


KINDS = [
    pytest.param(K_BALL, BALL_EXPONENT, id="ball"),
    pytest.param(roller_stiffness(0.012), ROLLER_EXPONENT, id="roller"),
]


def test_a_ball_on_a_plane_follows_hertz():
    """A sphere on a plane approaches by (9 Q^2/(16 R E*^2))^(1/3)."""
    radius, modulus = 5e-3, 114e9
    assert point_stiffness(2 / radius, 0.0, modulus) == pytest.approx(
        4 / 3 * modulus * math.sqrt(radius), rel=1e-12
    )


def test_crossed_cylinders_are_a_ball_on_a_plane():
    """Two equal cylinders across one another have the same curvatures as a sphere of their radius
    on a plane.
    """
    assert point_stiffness(1 / 5e-3 + 1 / 5e-3, 0.0, 1e11) == pytest.approx(
        4 / 3 * 1e11 * math.sqrt(5e-3)
    )


@pytest.mark.parametrize(
    ("difference", "shape"),
    [
        (0.1075, 0.9974),
        (0.3204, 0.9761),
        (0.4795, 0.9429),
        (0.5916, 0.9077),
        (0.6716, 0.8733),
        (0.7332, 0.8394),
    ],
)
def test_long_ellipses_follow_the_printed_table(difference: float, shape: float):
    """The contact's shape factor delta* falls with the difference of curvatures as Harris's table
    6.1 prints it.
    """
    total, modulus = 100.0, 1.14e11
    k = point_stiffness(total, difference, modulus)
    # K in terms of delta*: delta = delta* (3/(2 total modulus))^(2/3) total/2 for Q = 1
    found = k ** (-2 / 3) / ((3 / (2 * total * modulus)) ** (2 / 3) * total / 2)
    assert found == pytest.approx(shape, abs=4e-4)


def test_a_steel_point_contact_follows_the_handbooks_short_form():
    """For steel on steel K is 2.15e5 (sum of curvatures)^-1/2 delta*^-3/2 in N and mm."""
    for difference, shape in ((0.0, 1.0), (0.4795, 0.9429), (0.7332, 0.8394)):
        found = point_stiffness(200.0, difference, 207e9 / (2 * (1 - 0.3**2)))
        assert found * 1e-3**1.5 == pytest.approx(2.15e5 * 0.2**-0.5 * shape**-1.5, rel=5e-3)


def test_a_closer_groove_and_a_larger_ball_are_stiffer():
    """A groove radius closer to the ball's lengthens the contact ellipse and stiffens it; so does a
    larger ball.
    """
    assert (
        ball_stiffness(12.7e-3, 65e-3, 0.515, 0.515)
        > K_BALL
        > ball_stiffness(12.7e-3, 65e-3, 0.53, 0.53)
    )
    assert ball_stiffness(14e-3, 65e-3) > K_BALL > ball_stiffness(10e-3, 65e-3)


def test_a_roller_follows_palmgren():
    """A roller of 12 mm approaches its two races together by 2 x 3.84e-5 Q^0.9/l^0.8 mm."""
    force = 2000.0
    by_hand = 2 * 3.84e-5 * force**0.9 / 12**0.8 * 1e-3
    assert (force / roller_stiffness(0.012)) ** 0.9 == pytest.approx(by_hand, rel=1e-9)


@pytest.mark.parametrize(("count", "first"), [(8, 0.0), (9, 0.0), (20, 0.05), (33, 0.0)])
@pytest.mark.parametrize(("stiffness", "exponent"), KINDS)
@pytest.mark.parametrize("clearance", [-10 * UM, 0.0, 30 * UM])
def test_element_loads_balance_the_load(count, first, stiffness, exponent, clearance):
    """The components of the element loads along the load add up to it, to 1e-9, whatever the
    clearance.
    """
    angles = element_angles(count, first)
    load = np.geomspace(1e-3, 1e5, 25)
    shift = radial_shift(load, clearance, stiffness, exponent, angles)
    held = element_loads(shift, np.full(25, clearance), stiffness, exponent, angles) @ np.cos(
        angles
    )
    np.testing.assert_allclose(held[load > 1], load[load > 1], rtol=1e-9)


@pytest.mark.parametrize(
    ("stiffness", "exponent", "factor"),
    [(K_BALL, BALL_EXPONENT, 4.37), (roller_stiffness(0.012), ROLLER_EXPONENT, 4.08)],
)
def test_the_most_loaded_element_carries_its_known_share(stiffness, exponent, factor):
    """Without clearance the most loaded of many elements carries 4.37 F/Z if a ball, 4.08 F/Z if a
    roller.
    """
    for count in (40, 100):
        angles = element_angles(count)
        largest = element_loads(
            radial_shift(1e4, 0.0, stiffness, exponent, angles), 0.0, stiffness, exponent, angles
        ).max()
        assert largest * count / 1e4 == pytest.approx(factor, rel=2e-3)


@given(st.floats(0, 80e-6), st.floats(0.1, 1e5), st.integers(5, 30))
@settings(deadline=None, max_examples=60)
def test_clearance_is_a_dead_band_before_a_stiffening_spring(clearance, load, count):
    """Any load shifts the ring by more than half its clearance; more clearance loads fewer
    elements; stiffness rises with the load.
    """
    angles = element_angles(count)
    light, heavy = radial_shift(
        np.array([load, 2 * load]), clearance, K_BALL, BALL_EXPONENT, angles
    )
    assert clearance / 2 < light < heavy
    assert radial_stiffness(load, clearance, angles) < radial_stiffness(2 * load, clearance, angles)
    tight = element_loads(
        radial_shift(load, 0.0, K_BALL, BALL_EXPONENT, angles), 0.0, K_BALL, BALL_EXPONENT, angles
    )
    loose = element_loads(light, clearance, K_BALL, BALL_EXPONENT, angles)
    assert loose.max() >= tight.max() * (1 - 1e-9)
    assert (loose > 0).sum() <= (tight > 0).sum()


def test_without_load_the_bearing_stays_at_the_centre():
    """No load moves nothing, and the lightest load takes the ring across the clearance without
    resistance.
    """
    angles = element_angles(9)
    assert radial_shift(0.0, 30 * UM, K_BALL, BALL_EXPONENT, angles) == 0
    assert radial_shift(1e-9, 30 * UM, K_BALL, BALL_EXPONENT, angles) == pytest.approx(
        15 * UM, rel=1e-4
    )


def test_preload_makes_a_bearing_stiff_from_the_first_newton():
    """A preloaded bearing resists at once, more with more preload, and deflects less under the same
    load than one that just touches.
    """
    angles = element_angles(16)
    stiff = [radial_stiffness(1.0, -preload, angles) for preload in (2 * UM, 5 * UM, 10 * UM)]
    assert stiff == sorted(stiff)
    gives = [
        float(radial_shift(500.0, clearance, K_BALL, BALL_EXPONENT, angles))
        for clearance in (-10 * UM, -2 * UM, 0.0, 10 * UM)
    ]
    assert gives == sorted(gives)
    assert stiff[0] > radial_stiffness(1.0, 0.0, angles)


def test_opposite_loads_shift_a_bearing_equally():
    """With an even number of elements a bearing deflects equally under opposite loads."""
    angles = element_angles(12, 0.2)
    assert radial_shift(700.0, 20 * UM, K_BALL, BALL_EXPONENT, angles) == pytest.approx(
        float(radial_shift(700.0, 20 * UM, K_BALL, BALL_EXPONENT, angles + math.pi)), rel=1e-9
    )


@pytest.mark.parametrize(
    "call",
    [
        lambda: radial_shift(-1.0, 0.0, K_BALL, BALL_EXPONENT, element_angles(9)),
        lambda: radial_shift(1.0, 0.0, K_BALL, BALL_EXPONENT, np.array([math.pi])),
        lambda: radial_shift(float("nan"), 0.0, K_BALL, BALL_EXPONENT, element_angles(9)),
        lambda: ball_stiffness(12e-3, 65e-3, 0.5, 0.52),
        lambda: ball_stiffness(70e-3, 65e-3),
        lambda: point_stiffness(-1.0, 0.1, 1e11),
        lambda: point_stiffness(1.0, 1.0, 1e11),
    ],
)
def test_impossible_values_are_refused(call):
    """Negative loads, no element on the load's side, grooves narrower than their ball are
    refused.
    """
    with pytest.raises(ValueError, match=r"needed|needs"):
        call()


def test_pressure_of_a_ball_on_a_plane_is_hertzs_closed_form():
    """A round contact: (6 Q E*²/(π³ R²))^(1/3), none without load."""
    load, radius, modulus = np.array([0.0, 1.0, 100.0]), 5e-3, 114e9
    found = point_pressure(load, 2 / radius, 0.0, modulus)
    np.testing.assert_allclose(
        found, np.cbrt(6 * load * modulus**2 / (math.pi**3 * radius**2)), rtol=1e-9
    )


@pytest.mark.parametrize("ratio", [1.2, 3.0, 10.0])
def test_pressure_of_an_elliptic_contact_is_that_of_its_ellipse(ratio):
    """The curvatures and the load of an ellipse with a peak pressure (Johnson, Contact Mechanics,
    section 4.2) lead back to that pressure.
    """
    longer, peak, modulus = 1e-3, 2e9, 114e9
    shorter, square = longer / ratio, 1 - ratio**-2
    share = peak / modulus * shorter / (square * longer**2)
    along = share * (ellipk(square) - ellipe(square))
    across = share * (ratio**2 * ellipe(square) - ellipk(square))
    load = 2 / 3 * peak * math.pi * longer * shorter
    found = point_pressure(load, 2 * (along + across), (across - along) / (across + along), modulus)
    assert float(found) == pytest.approx(peak, rel=1e-8)


@pytest.mark.parametrize(
    ("ratio", "factor"),
    [
        (0.1, 16.4),
        (0.12, 15.9),
        (0.14, 15.4),
        (0.16, 14.9),
        (0.18, 14.4),
        (0.2, 14.0),
        (0.22, 13.5),
    ],
)
def test_balls_at_the_static_rating_of_iso_76_are_pressed_with_4200_mpa(ratio, factor):
    """The standard's factor f0 by ball over pitch diameter: its rating f0 Z D^2, in N and mm, loads
    the most heavily loaded ball with 5 f0 D^2.
    """
    ball = 8e-3
    assert float(ball_pressure(5 * factor * 8**2, ball, ball / ratio)) == pytest.approx(
        4200e6, rel=5e-3
    )


@pytest.mark.parametrize("ratio", [0.08, 0.2])
def test_rollers_at_the_static_rating_of_iso_76_are_pressed_with_4000_mpa(ratio):
    """The standard's rating 44 (1 - D/dm) Z L D, in N and mm, loads the most heavily loaded roller
    with five times its share.
    """
    assert float(
        roller_pressure(5 * 44 * (1 - ratio) * 12 * 10, 12e-3, 10e-3, 10e-3 / ratio)
    ) == pytest.approx(4000e6, rel=5e-3)
