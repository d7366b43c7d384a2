"""Screw circles and tubes in torsion."""

from __future__ import annotations

import math

import pytest

from lostmotion.laws.cycloid.output_pins import ElasticPinSeat
from lostmotion.laws.screw_circle import (
    circle_stiffness,
    screw_stiffness,
    slip_torque,
    tube_stiffness,
)


@pytest.mark.parametrize(
    ("young", "low", "high"), [(2.0e9, 3e6, 4.5e6), (2.4e9, 3.5e6, 5e6), (70e9, 50e6, 120e6)]
)
def test_a_small_screw_in_its_seat(young, low, high):
    """An M3, 6 mm deep in plastic, has 3 to 5 N/µm; in aluminium the screw itself gives as well."""
    seat = ElasticPinSeat(0.006, 0.0075, young, 0.36, "snug")
    assert low < screw_stiffness("M3", 210e9, 0.3, seat) < high
    assert screw_stiffness("M4", 210e9, 0.3, seat) > screw_stiffness("M3", 210e9, 0.3, seat)


def test_a_circle_of_screws():
    """Eight of 4 N/µm at 48 mm hold n k r^2; with 500 N and mu 0.2 they slip at n mu F r."""
    assert circle_stiffness(8, 0.048, 4e6) == pytest.approx(8 * 4e6 * 0.048**2)
    assert slip_torque(8, 0.048, 500.0, 0.2) == pytest.approx(38.4)


def test_a_tube():
    """2 pi r^3 t G/L for a thin wall; a wall as thick as the radius allows is a solid bar, pi d^4
    G/(32 L).
    """
    thin = tube_stiffness(0.05, 1e-4, 0.03, 1e9)
    assert thin == pytest.approx(2 * math.pi * 0.05**3 * 1e-4 * 1e9 / 0.03, rel=1e-5)
    assert tube_stiffness(0.01, 0.02, 0.03, 1e9) == pytest.approx(
        math.pi * 0.04**4 / 32 * 1e9 / 0.03, rel=1e-12
    )
