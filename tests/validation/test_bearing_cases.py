"""Bearings against published cases: a 209 deep-groove ball bearing, as in T. Harris, Rolling Bearing Analysis, example 7.1."""

from __future__ import annotations

import numpy as np
import pytest

from lostmotion.laws.rolling import BALL_EXPONENT, ball_stiffness, element_angles, radial_loads, radial_shift

UM = 1e-6
# Z 9, ball 12.7 mm, pitch 65 mm, f 0.52, E 207.5 GPa
STIFFNESS = ball_stiffness(12.7e-3, 65e-3, 0.52, 0.52, 0.0, (207.5e9, 0.3))
ANGLES = element_angles(9)
LOAD = 8900.0


def test_the_209_without_clearance():
    """Under 8 900 N the lowest ball of a 209 without clearance carries 4 336 N and the ring shifts by 51.5 µm."""
    shift = radial_shift(LOAD, 0.0, STIFFNESS, BALL_EXPONENT, ANGLES)
    loads = radial_loads(shift, 0.0, STIFFNESS, BALL_EXPONENT, ANGLES)
    assert loads.max() == pytest.approx(4336, rel=1e-3)
    assert shift == pytest.approx(51.5 * UM, rel=2e-3)
    np.testing.assert_allclose(loads @ np.cos(ANGLES), LOAD, rtol=1e-9)
