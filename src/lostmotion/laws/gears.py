"""Laws of every reducer: wind-up in stiffness zones, hysteresis, lost motion and play; ratios from the numbers of teeth.

Sources: makers' rules as printed by Harmonic Drive (K1/K2/K3 zones) and Nabtesco (lost motion at +-3 % of the rated torque); ratios by Willis'
equation: speeds relative to the carrier times teeth are equal where two wheels mesh. Ratios are turns of the input per turn of the output, negative
for opposite directions.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.spatial import Floats


def wind_up(torque: Floats, stiffness: Sequence[float], limits: Sequence[float] = ()) -> Floats:
    """Return the wind-up of the output (rad) under torques (any shape, N m). Odd in the torque.

    `stiffness` N m/rad, one per zone; `limits` N m, rising, one fewer: T/K1 up to T1, plus (T - T1)/K2 up to T2, plus (T - T2)/K3. Raises ValueError
    where the counts do not fit or the limits do not rise.
    """
    if len(limits) != len(stiffness) - 1 or any(b <= a for a, b in zip((0.0, *limits), limits, strict=False)):
        raise ValueError("the torque limits must rise and be one fewer than the stiffness zones")
    size = np.abs(np.asarray(torque, dtype=float))
    angle = np.zeros_like(size)
    low = 0.0
    for k, high in zip(stiffness, (*limits, np.inf), strict=True):
        angle += np.clip(size - low, 0.0, high - low) / k
        low = high
    return np.asarray(np.sign(torque) * angle)


def friction_loop(spring: Callable[[Floats], Floats], torque: Floats, friction: Floats) -> tuple[Floats, Floats]:
    """Return the branches of the hysteresis loop at torques (any shape, N m): angles (rad) as the torque rises, and as it falls.

    `spring` is the odd, increasing spring curve w: angles (rad) under torques (N m); `friction` F (N m, zero or more, the shape of `torque`). While
    the torque rises, friction carries F of it and the spring T - F; while it falls, the spring still carries T + F: w(T - F) and w(T + F), half width
    [w(T + F) - w(T - F)] / 2. That is w(F) without torque and at most w(|T| + F); F times the compliance at zero would overestimate a spring that
    starts soft. Valid for friction that does not depend on the path of the output.
    """
    return spring(torque - friction), spring(torque + friction)


def play_from_lost_motion(lost_motion: float, small_torque: float, stiffness: Sequence[float], limits: Sequence[float] = ()) -> float:
    """Return the play in a lost motion (rad) measured between + and - `small_torque` (N m). Negative: the lost motion is all elastic.

    Lost motion = play + 2 x wind-up at the small torque.
    """
    return lost_motion - 2 * float(wind_up(np.array([small_torque]), stiffness, limits)[0])


def planetary_ratio(sun: int, ring: int) -> float:
    """Return the turns of the sun per turn of the planet carrier with the ring fixed, from the teeth: 1 + ring/sun."""
    return 1 + ring / sun


def wolfrom_ratio(sun: int, planet: int, fixed_ring: int, output_planet: int, output_ring: int) -> float:
    """Return the turns of the sun of a Wolfrom (3K) gearbox per turn of its second ring, from the teeth.

    Sun and fixed ring mesh with one wheel of each planet, the second ring with the other wheel of the same planet; the carrier runs free: (1 +
    z_r1/z_s) / (1 - z_r1 z_p2/(z_p1 z_r2)). Raises ValueError where the second ring does not turn.
    """
    differ = planet * output_ring - fixed_ring * output_planet
    if not differ:
        raise ValueError("the output ring does not turn: both rings require the same speed of the planets")
    return (sun + fixed_ring) * planet * output_ring / (sun * differ)


def strain_wave_ratio(flexspline: int, circular_spline: int, *, flexspline_held: bool = False) -> float:
    """Return the turns of the wave generator per turn of the output, from the teeth of the two splines.

    With the circular spline fixed the flexspline is the output and turns the opposite way, -z_f/(z_c - z_f); with the flexspline fixed the circular
    spline turns the same way, z_c/(z_c - z_f). Raises ValueError where the circular spline has no more teeth than the flexspline.
    """
    more = circular_spline - flexspline
    if more <= 0:
        raise ValueError("a circular spline must have more teeth than the flexspline inside it")
    return circular_spline / more if flexspline_held else -flexspline / more


def friction_angle(coefficient: float, pressure_angle: float) -> float:
    """Return the lead angle (rad) up to which a worm is self-locking: atan(mu/cos(alpha)), alpha the normal pressure angle (rad)."""
    return math.atan(coefficient / math.cos(pressure_angle))


def duplex_take_up(shift: float, leads: tuple[float, float], ratio: float) -> float:
    """Return the play at the wheel (rad) removed by shifting a duplex worm along its axis by `shift` (m).

    `leads` (m) of the two flanks: the thread's thickness grows along the worm by their difference per turn. `ratio` of the gearbox. At the pitch
    circle, 2 pi shift |lead 1 - lead 2| / (ratio x mean lead^2).
    """
    first, second = leads
    mean = (first + second) / 2
    return 2 * math.pi * shift * abs(first - second) / (ratio * mean**2)
