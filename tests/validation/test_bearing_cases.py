"""Bearings against T. Harris, Rolling Bearing Analysis, chapter 7: a 209 deep groove under radial
load, angular-contact balls under thrust.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from lostmotion.laws.rolling.equilibrium import shaft_equilibrium
from lostmotion.laws.rolling.radial import (
    BALL_EXPONENT,
    ball_stiffness,
    element_angles,
    radial_shift,
)
from lostmotion.laws.rolling.rows import BallRow, RowSeat
from tests.laws.closed_forms import element_loads

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "rolling bearings",
        "the 209 deep-groove case; load factors 4.37 and 4.08; the 209 as a part and in the report",
        "2 %",
        "laws/rolling/radial.py laws/rolling/equilibrium.py tests/parts/test_drawn_bearing.py",
    ),
)

UM = 1e-6
# Z 9, ball 12.7 mm, pitch 65 mm, f 0.52, E 207.5 GPa
STIFFNESS = ball_stiffness(12.7e-3, 65e-3, 0.52, 0.52, 0.0, (207.5e9, 0.3))
ANGLES = element_angles(9)
LOAD = 8900.0


def test_the_209_without_clearance():
    """Under 8 900 N the lowest ball of a 209 without clearance carries 4 336 N and the ring shifts
    by 51.5 µm.
    """
    shift = radial_shift(LOAD, 0.0, STIFFNESS, BALL_EXPONENT, ANGLES)
    loads = element_loads(shift, 0.0, STIFFNESS, BALL_EXPONENT, ANGLES)
    assert loads.max() == pytest.approx(4336, rel=1e-3)
    assert shift == pytest.approx(51.5 * UM, rel=2e-3)
    np.testing.assert_allclose(loads @ np.cos(ANGLES), LOAD, rtol=1e-9)


def test_the_209_in_space_is_the_209_in_its_plane():
    """Solved with all five freedoms the 209 under its radial load stands where the one-unknown
    solution says, and neither tilts nor wanders.
    """
    found = shaft_equilibrium(
        (RowSeat(BallRow(count=9, ball=12.7e-3, pitch=65e-3)),), np.array([[LOAD, 0, 0, 0, 0]])
    )
    assert found.loads[0].max() == pytest.approx(4336, rel=1e-3)
    np.testing.assert_allclose(found.displacement[0] / UM, [51.5, 0, 0, 0, 0], atol=0.1)


@pytest.mark.parametrize("thrust", [100.0, 2000.0, 17800.0])
@pytest.mark.parametrize("degrees", [15.0, 25.0, 40.0])
def test_thrust_on_angular_contact_balls_follows_the_closed_form(thrust, degrees):
    """Under thrust the angle of contact grows by F/(Z K A^1.5) = sin a (cos a0/cos a - 1)^1.5, and
    the shaft moves by A sin(a - a0)/cos a.
    """
    row = BallRow(
        count=16,
        ball=22.23e-3,
        pitch=125.26e-3,
        grooves=(0.5232, 0.5232),
        contact_angle=math.radians(degrees),
    )
    apart, free = 0.0464 * 22.23e-3, math.radians(degrees)
    share = thrust / (16 * row.spring[0] * apart**1.5)
    angle = brentq(
        lambda a: math.sin(a) * (math.cos(free) / math.cos(a) - 1) ** 1.5 - share,
        free,
        1.5,
        xtol=1e-15,
    )
    found = shaft_equilibrium((RowSeat(row),), np.array([[0, 0, thrust, 0, 0]]))
    np.testing.assert_allclose(found.loads[0][0], thrust / 16 / math.sin(angle), rtol=1e-7)
    assert found.displacement[0, 2] == pytest.approx(
        apart * math.sin(angle - free) / math.cos(angle), rel=1e-7
    )
