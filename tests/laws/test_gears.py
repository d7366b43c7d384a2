"""Stiffness zones, hysteresis and lost motion against the makers' rules, calculated by hand; ratios
against Willis' equations.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lostmotion.laws.gears import (
    duplex_take_up,
    friction_angle,
    friction_loop,
    planetary_ratio,
    play_from_lost_motion,
    strain_wave_ratio,
    wind_up,
    wolfrom_ratio,
)

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "wind-up in zones",
        "the maker's rule by hand",
        "exact",
        "laws/gears.py",
    ),
    (
        "ratios of planetary, Wolfrom, strain wave gears",
        "Willis' equations solved for every wheel",
        "1e-9 (Wolfrom 1e-7)",
        "laws/gears.py",
    ),
    (
        "friction hysteresis",
        (
            "published half-widths; a slider that sticks and slips, stepped through a cycle; the "
            "spring's own table at T ± F"
        ),
        "printed digits; 5e-5 of the torque; 1e-12",
        "laws/gears.py tests/parts/test_cycloidal.py",
    ),
)

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
    """A size-25 strain wave gear winds up by T/K1, then (T - T1)/K2 on top, then (T - T2)/K3, as
    its maker prints.
    """
    assert wind_up(np.array([torque]), K, T)[0] == pytest.approx(angle, rel=1e-14, abs=0)


def test_a_single_zone_is_a_spring():
    """An RV-42N at its rated 412 N m winds up by 412/113 = 3.65'."""
    assert wind_up(np.array([412.0]), [113 / ARCMIN])[0] / ARCMIN == pytest.approx(
        412 / 113, rel=1e-14
    )


ZONES = st.integers(1, 8).flatmap(
    lambda n: st.tuples(
        st.lists(st.floats(1, 1e7), min_size=n, max_size=n),
        st.lists(st.floats(0.1, 1e3), min_size=n - 1, max_size=n - 1).map(
            lambda steps: list(np.cumsum(steps))
        ),
    ),
)


@given(ZONES, st.lists(st.floats(-1e5, 1e5), min_size=2, max_size=20))
@settings(deadline=None, max_examples=100)
def test_wind_up_is_odd_and_rises_with_the_torque(
    zones: tuple[list[float], list[float]], torques: list[float]
):
    """Whatever the zones, wind-up is odd, rises with the torque, and never exceeds that of the
    softest zone.
    """
    stiffness, limits = zones
    torque = np.sort(torques)
    angle = wind_up(torque, stiffness, limits)
    np.testing.assert_array_equal(wind_up(-torque, stiffness, limits), -angle)
    assert (np.diff(angle) >= -1e-12 * np.abs(angle).max()).all()
    assert (np.abs(angle) <= np.abs(torque) / min(stiffness) * (1 + 1e-9)).all()
    assert (np.abs(angle) >= np.abs(torque) / max(stiffness) * (1 - 1e-9)).all()


def test_integer_torques_are_numbers():
    """A torque of 30 is a torque of 30.0, and the angles have the shape of the torques."""
    assert wind_up(np.array([[30]]), K, T).tolist() == wind_up(np.array([[30.0]]), K, T).tolist()


@pytest.mark.parametrize(
    ("stiffness", "limits"),
    [
        (K, (14.0,)),
        (K, (48.0, 14.0)),
        (K, (14.0, 14.0)),
        (K[:1], (14.0,)),
        (K[:2], (0.0,)),
        (K[:2], (-1.0,)),
    ],
)
def test_zones_that_do_not_fit_are_refused(stiffness: tuple[float, ...], limits: tuple[float, ...]):
    """The torque limits must rise, be positive and one fewer than the stiffness values."""
    with pytest.raises(ValueError, match="limits must rise"):
        wind_up(np.array([1.0]), stiffness, limits)


def test_lost_motion_is_play_and_wind_up_in_both_directions():
    """Of a lost motion of 1' at 3 % of 412 N m, 2 x 12.36/113 = 0.219' of an RV-42N is wind-up:
    0.781' is play.
    """
    play = play_from_lost_motion(ARCMIN, 0.03 * 412, [113 / ARCMIN])
    assert play / ARCMIN == pytest.approx(1 - 2 * 12.36 / 113, rel=1e-12)


@given(st.floats(0, 0.01), st.floats(0.1, 100))
@settings(deadline=None, max_examples=50)
def test_play_and_lost_motion_are_inverse(play: float, small: float):
    """A lost motion computed from a play contains that play again; a smaller lost motion than the
    wind-up leaves a negative one.
    """
    lost = play + 2 * float(wind_up(np.array([small]), K, T)[0])
    assert play_from_lost_motion(lost, small, K, T) == pytest.approx(play, abs=1e-15)
    assert play_from_lost_motion(0.0, small, K, T) < 0


def speeds(
    wheels: int, meshes: list[tuple[int, int, int, int, int, bool]], held: int, output: int
) -> np.ndarray:
    """Solve Willis' equations for the speed of every wheel while the output makes one turn.

    Each mesh is (wheel, its teeth, other wheel, its teeth, carrier of both axes, whether one lies
    inside the other): against the carrier,
    as many teeth of the one pass as of the other, in the same direction where one lies inside the
    other.
    """
    rows, right = [], []
    for a, teeth_a, b, teeth_b, carrier, inside in meshes:
        row = np.zeros(wheels)
        sign = -1.0 if inside else 1.0
        row[a] += teeth_a
        row[b] += sign * teeth_b
        row[carrier] -= teeth_a + sign * teeth_b
        rows.append(row)
        right.append(0.0)
    for wheel, speed in ((held, 0.0), (output, 1.0)):
        rows.append(np.eye(wheels)[wheel])
        right.append(speed)
    return np.linalg.solve(np.array(rows), np.array(right))


TEETH = st.integers(9, 150)


@given(TEETH, TEETH)
@settings(deadline=None, max_examples=50)
def test_a_planetary_ratio_solves_willis_equations(sun: int, planet: int):
    """Sun 0, planet 1, ring 2 (fixed), carrier 3 (output): the speeds have the law's ratio,
    whatever the teeth.
    """
    ring = sun + 2 * planet
    found = speeds(
        4, [(0, sun, 1, planet, 3, False), (1, planet, 2, ring, 3, True)], held=2, output=3
    )
    assert planetary_ratio(sun, ring) == pytest.approx(found[0], rel=1e-9)
    assert (found[0] - 1, abs(found[1] - 1)) == pytest.approx((ring / sun, ring / planet), rel=1e-9)


@given(TEETH, TEETH, TEETH, st.integers(1, 60), st.integers(1, 60))
@settings(deadline=None, max_examples=100)
def test_a_wolfrom_ratio_solves_willis_equations(
    sun: int, planet: int, second: int, first_more: int, second_more: int
):
    """Sun 0, planet 1 with two wheels, ring 2 (fixed), ring 3 (output), carrier 4 (free): same
    ratio and sign, or both find no motion.
    """
    ring, out = planet + first_more, second + second_more
    meshes = [
        (0, sun, 1, planet, 4, False),
        (1, planet, 2, ring, 4, True),
        (1, second, 3, out, 4, True),
    ]
    if planet * out == ring * second:
        with pytest.raises(ValueError, match="does not turn"):
            wolfrom_ratio(sun, planet, ring, second, out)
        return
    found = speeds(5, meshes, held=2, output=3)
    assert wolfrom_ratio(sun, planet, ring, second, out) == pytest.approx(found[0], rel=1e-7)
    assert found[0] == pytest.approx(
        (1 + ring / sun) / (1 - ring * second / (planet * out)), rel=1e-7
    )


@given(st.integers(20, 400), st.integers(1, 5), st.booleans())
@settings(deadline=None, max_examples=50)
def test_a_strain_wave_ratio_solves_willis_equations(
    flexspline: int,
    pairs: int,
    hold_flexspline: bool,  # noqa: FBT001
):
    """Flexspline 0 inside circular spline 1, carried by the wave generator 2."""
    circular = flexspline + 2 * pairs
    held, output = (0, 1) if hold_flexspline else (1, 0)
    found = speeds(3, [(0, flexspline, 1, circular, 2, True)], held=held, output=output)
    assert strain_wave_ratio(
        flexspline, circular, flexspline_fixed=hold_flexspline
    ) == pytest.approx(found[2], rel=1e-9)


def test_a_strain_wave_gear_loses_its_difference_of_teeth_each_turn():
    """A turn of the generator meshes 202 teeth of the circular spline with 200 of the flexspline,
    which falls back by 2 of its 200 teeth.
    """
    laid = fall_back = 0
    while laid < 202:  # the flexspline turns backwards by the difference of teeth
        laid += 1
        fall_back = laid - laid * 200 / 202
    assert strain_wave_ratio(200, 202) == pytest.approx(-200 / fall_back, rel=1e-12)
    for circular in (200, 198):
        with pytest.raises(ValueError, match="more teeth"):
            strain_wave_ratio(200, circular)


def test_a_worm_is_self_locking_up_to_the_friction_angle():
    """At the friction angle the force along the thread of a worm balances friction; at a larger
    lead angle it exceeds it.
    """
    alpha, mu = math.radians(20), 0.06
    limit = friction_angle(mu, alpha)

    def excess(lead: float) -> float:
        # around, along the worm, radially
        normal = np.array(
            [-math.cos(alpha) * math.sin(lead), math.cos(alpha) * math.cos(lead), math.sin(alpha)]
        )
        sliding = np.array([math.cos(lead), math.sin(lead), 0.0])
        # The wheel pushes along the worm. Around the worm, the slope of the thread drives it and
        # friction resists.
        return float(abs(normal[0]) - mu * sliding[0])

    assert excess(limit) == pytest.approx(0, abs=1e-15)
    assert excess(limit * 1.01) > 0 > excess(limit * 0.99)


def test_a_shifted_duplex_worm_removes_play():
    """The play removed by shifting a duplex worm (leads 6.2 and 6.4 mm) by half a millimetre equals
    the change of its tooth thickness.
    """
    left, right, shift, ratio = 6.2e-3, 6.4e-3, 0.5e-3, 60.0
    mean = (left + right) / 2

    def thickness(place: float) -> float:
        # The flanks of turn k are at k x lead; between them the position is proportional to the
        # angle.
        turns = place / mean
        return 1.5e-3 + turns * right - turns * left

    thicker = thickness(10 * mean + shift) - thickness(10 * mean)
    # the pitch circle of the wheel moves by one lead per turn of the worm
    radius = ratio * mean / (2 * math.pi)
    assert duplex_take_up(shift, (left, right), ratio) == pytest.approx(thicker / radius, rel=1e-12)
    assert duplex_take_up(shift, (right, left), ratio) == duplex_take_up(
        shift, (left, right), ratio
    )


def soft_start(torque: np.ndarray) -> np.ndarray:
    """Return a spring that starts soft, w = 4 mrad (T/24)^0.6 + T/1500 rad, odd in the torque."""
    return np.asarray(np.sign(torque) * 4e-3 * (np.abs(torque) / 24) ** 0.6 + torque / 1500)


LEVELS = np.array([0.0, 10.0, 40.0])


@pytest.mark.parametrize(
    ("constant", "share", "half_widths"),
    [
        (2.5, 0.0, (2.6963e-3, 2.2969e-3, 1.9979e-3)),
        (0.5, 0.15, (8.2434e-4, 8.6902e-4, 1.87658e-3)),
    ],
)
def test_half_width_of_a_friction_loop(constant, share, half_widths):
    """Friction F0 + m |T_e| in series with a spring: published half-widths at 0, 3 and 12 N m, to
    the digits printed.
    """
    rising, falling = friction_loop(
        soft_start, np.array([0.0, 3.0, 12.0]), LEVELS, constant + share * LEVELS
    )
    np.testing.assert_allclose((falling - rising) / 2, half_widths, rtol=3e-5)


@pytest.mark.parametrize(("constant", "share"), [(2.5, 0.0), (0.5, 0.15), (1.0, 0.3)])
def test_a_friction_loop_is_that_of_a_slider_that_sticks_and_slips(constant, share):
    """A slider between load and spring, stepped through a cycle of ± 24 N m: it moves where the
    load differs from the spring by more than F.
    """
    steps = np.linspace(0.0, 24.0, 20_001)
    path = np.concatenate([steps, steps[::-1], -steps, -steps[::-1], steps])
    held, carried = 0.0, np.empty_like(path)
    for k, load in enumerate(path):
        # the spring's torque stays unless the friction at a torque nearer to the load can no longer
        # hold the difference
        forward = (
            (load - constant) / (1 + share) if load > constant else (load - constant) / (1 - share)
        )
        backward = (
            (load + constant) / (1 - share) if load > -constant else (load + constant) / (1 + share)
        )
        held = min(max(held, forward), backward)
        carried[k] = held
    sampled = np.linspace(-20.0, 20.0, 41)
    # the torque that the spring carries, in place of its angle
    rising, falling = friction_loop(
        lambda torque: torque, sampled, LEVELS, constant + share * LEVELS
    )
    way_back = slice(len(steps), 3 * len(steps))
    down, up = path[way_back][::-1], path[3 * len(steps) :]
    fell, rose = (
        np.interp(sampled, *each)
        for each in ((down, carried[way_back][::-1]), (up, carried[3 * len(steps) :]))
    )
    # after a reversal the spring stays until the load has changed by the friction of both
    # directions
    most = (24 - constant) / (1 + share)
    np.testing.assert_allclose(fell, np.minimum(falling, most), rtol=0, atol=1e-3)
    np.testing.assert_allclose(rose, np.maximum(rising, -most), rtol=0, atol=1e-3)


def test_friction_as_large_as_the_torque_holds_the_springs():
    """A self-locking drive, m of 1 or more, does not unwind: while the torque falls its springs
    keep the torque of the last level.
    """
    rising, falling = friction_loop(
        soft_start, np.array([0.0, 5.0, 100.0]), LEVELS, 1.0 + 1.5 * LEVELS
    )
    np.testing.assert_allclose(rising[1:], soft_start(np.array([4.0, 99.0]) / 2.5))
    assert np.isfinite(falling).all()
    assert (falling >= rising).all()
