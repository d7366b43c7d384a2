"""Stiffness zones and lost motion against the makers' rules, worked by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lostmotion.laws.gears import play_from_lost_motion, wind_up

# Harmonic Drive, size 25, ratio above 50: K1, K2, K3 in N m/rad, T1 and T2 in N m
K = (31e3, 50e3, 57e3)
T = (14.0, 48.0)
ARCMIN = math.pi / 180 / 60


@pytest.mark.parametrize(
    ("torque", "angle"),
    [
        (0.0, 0.0),
        (7.0, 7 / 31e3),
        (14.0, 14 / 31e3),
        (30.0, 14 / 31e3 + 16 / 50e3),
        (48.0, 14 / 31e3 + 34 / 50e3),
        (100.0, 14 / 31e3 + 34 / 50e3 + 52 / 57e3),
    ],
)
def test_a_strain_wave_gear_winds_up_zone_by_zone(torque: float, angle: float):
    """A size-25 strain wave gear winds up by T/K1, then (T - T1)/K2 on top, then (T - T2)/K3, as its maker prints."""
    assert wind_up(np.array([torque]), K, T)[0] == pytest.approx(angle, rel=1e-14, abs=0)


def test_a_single_zone_is_a_spring():
    """An RV-42N at its rated 412 N m winds up by 412/113 = 3.65'."""
    assert wind_up(np.array([412.0]), [113 / ARCMIN])[0] / ARCMIN == pytest.approx(412 / 113, rel=1e-14)


ZONES = st.integers(1, 8).flatmap(
    lambda n: st.tuples(
        st.lists(st.floats(1, 1e7), min_size=n, max_size=n),
        st.lists(st.floats(0.1, 1e3), min_size=n - 1, max_size=n - 1).map(lambda steps: list(np.cumsum(steps))),
    ),
)


@given(ZONES, st.lists(st.floats(-1e5, 1e5), min_size=2, max_size=20))
@settings(deadline=None, max_examples=100)
def test_wind_up_is_odd_and_rises_with_the_torque(zones: tuple[list[float], list[float]], torques: list[float]):
    """Whatever the zones, a reducer winds up alike to both sides, further under more torque, and never by more than its softest zone."""
    stiffness, limits = zones
    torque = np.sort(torques)
    angle = wind_up(torque, stiffness, limits)
    np.testing.assert_array_equal(wind_up(-torque, stiffness, limits), -angle)
    assert (np.diff(angle) >= -1e-12 * np.abs(angle).max()).all()
    assert (np.abs(angle) <= np.abs(torque) / min(stiffness) * (1 + 1e-9)).all()
    assert (np.abs(angle) >= np.abs(torque) / max(stiffness) * (1 - 1e-9)).all()


def test_whole_numbers_of_torque_are_numbers():
    """A torque of 30 is a torque of 30.0, and any shape of torques gives the same shape of angles."""
    assert wind_up(np.array([[30]]), K, T).tolist() == wind_up(np.array([[30.0]]), K, T).tolist()


@pytest.mark.parametrize(
    ("stiffness", "limits"),
    [(K, (14.0,)), (K, (48.0, 14.0)), (K, (14.0, 14.0)), (K[:1], (14.0,)), (K[:2], (0.0,)), (K[:2], (-1.0,))],
)
def test_zones_that_do_not_fit_are_refused(stiffness: tuple[float, ...], limits: tuple[float, ...]):
    """Zones need one rising, positive torque fewer than stiffness values; anything else has no meaning."""
    with pytest.raises(ValueError, match="rising torque limit"):
        wind_up(np.array([1.0]), stiffness, limits)


def test_lost_motion_is_play_and_wind_up_both_ways():
    """Of a lost motion of 1' at 3 % of 412 N m, an RV-42N spends 2 x 12.36/113 = 0.219' on wind-up: 0.781' is play."""
    play = play_from_lost_motion(ARCMIN, 0.03 * 412, [113 / ARCMIN])
    assert play / ARCMIN == pytest.approx(1 - 2 * 12.36 / 113, rel=1e-12)


@given(st.floats(0, 0.01), st.floats(0.1, 100))
@settings(deadline=None, max_examples=50)
def test_play_and_lost_motion_tell_the_same(play: float, small: float):
    """Whoever builds the lost motion from a play finds the same play in it again; a small lost motion leaves less than none."""
    lost = play + 2 * float(wind_up(np.array([small]), K, T)[0])
    assert play_from_lost_motion(lost, small, K, T) == pytest.approx(play, abs=1e-15)
    assert play_from_lost_motion(0.0, small, K, T) < 0
