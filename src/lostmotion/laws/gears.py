"""Laws of reducers: wind-up in stiffness zones, hysteresis, lost motion and play; ratios from the
numbers of teeth.

Sources: makers' rules as printed by Harmonic Drive (K1/K2/K3 zones) and Nabtesco (lost motion at
+-3 % of the rated torque). Ratios follow from Willis' equation: where two wheels mesh, speed
relative to the carrier times number of teeth is equal for both. Ratios are turns of the input per
turn of the output, negative for opposite directions.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.spatial import Floats


def wind_up(torque: Floats, stiffness: Sequence[float], limits: Sequence[float] = ()) -> Floats:
    """Return the wind-up of the output (rad) under torques (any shape, N m): T/K1 up to T1, plus (T
    - T1)/K2 up to T2, plus (T - T2)/K3 beyond.

    stiffness  K1, K2 ..., N m/rad, one for each zone
    limits     T1, T2 ..., N m, rising, one fewer than the zones

    An odd function of the torque. Raises ValueError where the numbers of zones and limits do not
    match, or the limits do not rise.
    """
    if len(limits) != len(stiffness) - 1 or any(
        b <= a for a, b in zip((0.0, *limits), limits, strict=False)
    ):
        raise ValueError("the torque limits must rise and be one fewer than the stiffness zones")
    size = np.abs(np.asarray(torque, dtype=float))
    angle = np.zeros_like(size)
    low = 0.0
    for k, high in zip(stiffness, (*limits, np.inf), strict=True):
        angle += np.clip(size - low, 0.0, high - low) / k
        low = high
    return np.asarray(np.sign(torque) * angle)


def friction_loop(
    spring: Callable[[Floats], Floats],
    torque: Floats,
    levels: Floats,
    friction: Floats,
    share: float = 0.0,
) -> tuple[Floats, Floats]:
    """Return the branches of the hysteresis loop at torques (any shape, N m): angles (rad) as the
    torque rises, and as it falls.

    spring    odd, increasing spring curve w behind the friction: angles (rad) under torques (N m)
    levels    (level,) N m, from zero on: the torque that the springs carry
    friction  (level,) N m, F at these levels, zero or more; linear between the levels and beyond
    share     further friction, of this share of the torque at the output, between the load and the
              other

    The input is held, and friction acts between the load and the springs. While the torque T rises,
    the springs carry the T_e of T_e + F(|T_e|) = T, while it falls that of T_e - F(|T_e|) = T. Of
    F0 + m |T_e| these are (T - F0)/(1 + m) and (T + F0)/(1 - m), with m of the other sign where T_e
    is below zero. Without load the half-width is w(F0/(1 - m)), larger than F0 times the compliance
    there where the spring starts soft. Springs between the load and the friction carry T and have
    no loop. Friction of the torque carried or more holds the springs at the last level.
    """
    size = share * np.abs(torque)
    rising, falling = (
        torque_behind_friction(torque - size, levels, friction, 1),
        torque_behind_friction(torque + size, levels, friction, -1),
    )
    return spring(rising), spring(falling)


def torque_behind_friction(
    torque: Floats, levels: Floats, friction: Floats, direction: Literal[1, -1]
) -> Floats:
    """Return the torque T_e (N m) that springs carry behind friction while the torque (any shape, N
    m) rises, `direction` 1, or falls, -1.

    Other arguments as `friction_loop`.
    """
    carried = np.concatenate([-levels[:0:-1], levels])
    forward = np.maximum.accumulate(levels + direction * friction)
    backward = np.minimum.accumulate(direction * friction - levels)
    applied = np.concatenate([backward[:0:-1], forward])
    out = np.interp(torque, applied, carried)
    slope = direction * (friction[-1] - friction[-2]) / (levels[-1] - levels[-2])
    for end, beyond, growth in (
        (-1, np.maximum(torque - applied[-1], 0.0), 1 + slope),
        (0, np.minimum(torque - applied[0], 0.0), 1 - slope),
    ):
        if growth > 0:
            out = np.where(beyond != 0, carried[end] + beyond / growth, out)
    return np.asarray(out)


def unloads(levels: Floats, friction: Floats) -> bool:
    """Return whether springs behind this friction turn the output back as the load falls, which
    needs friction that grows less than their torque.

    Arguments as `friction_loop`. Otherwise friction holds the springs, and the angle during
    unloading says nothing about them.
    """
    return bool((np.diff(levels - friction) > 0).all())


def interpolated(load: Floats | float, torque: Floats, values: Floats) -> Floats:
    """Return the value at loads (any shape, zero or more): linear between the levels, extrapolated
    linearly beyond the last.
    """
    load = np.asarray(load, dtype=float)
    slope = (values[-1] - values[-2]) / (torque[-1] - torque[-2])
    return np.asarray(np.interp(load, torque, values) + np.maximum(load - torque[-1], 0.0) * slope)


def play_from_lost_motion(
    lost_motion: float,
    small_torque: float,
    stiffness: Sequence[float],
    limits: Sequence[float] = (),
) -> float:
    """Return the play (rad) that is part of a lost motion (rad) measured between + and -
    `small_torque` (N m).

    Lost motion = play + 2 x wind-up at the small torque. A negative result means that the wind-up
    alone exceeds the lost motion. Other arguments and errors as `wind_up`.
    """
    return lost_motion - 2 * float(wind_up(np.array([small_torque]), stiffness, limits)[0])


def planetary_ratio(sun: int, ring: int) -> float:
    """Return the turns of the sun per turn of the planet carrier with the ring fixed, from the
    numbers of teeth: 1 + ring/sun.
    """
    return 1 + ring / sun


def wolfrom_ratio(
    sun: int, planet: int, fixed_ring: int, output_planet: int, output_ring: int
) -> float:
    """Return the turns of the sun of a Wolfrom (3K) gearbox per turn of its second ring, from the
    numbers of teeth.

    Sun and fixed ring mesh with one wheel of each planet, the second ring with the other wheel of
    the same planet; the carrier is free. The ratio is (1 + z_r1/z_s)/(1 - z_r1 z_p2/(z_p1 z_r2)).
    Raises ValueError where the second ring does not turn.
    """
    difference = planet * output_ring - fixed_ring * output_planet
    if not difference:
        raise ValueError(
            "the output ring does not turn: both rings require the same speed of the planets"
        )
    return (sun + fixed_ring) * planet * output_ring / (sun * difference)


def strain_wave_ratio(
    flexspline: int, circular_spline: int, *, flexspline_fixed: bool = False
) -> float:
    """Return the turns of the wave generator of a strain wave gear per turn of its output, from the
    numbers of teeth of the two splines.

    With the circular spline fixed the flexspline is the output and turns in the opposite direction:
    -z_f/(z_c - z_f). With the flexspline fixed the circular spline turns in the same direction:
    z_c/(z_c - z_f). Raises ValueError where the circular spline has no more teeth than the
    flexspline.
    """
    difference = circular_spline - flexspline
    if difference <= 0:
        raise ValueError("a circular spline must have more teeth than the flexspline inside it")
    return circular_spline / difference if flexspline_fixed else -flexspline / difference


def friction_angle(coefficient: float, pressure_angle: float) -> float:
    """Return the lead angle (rad) up to which a worm is self-locking: atan(mu/cos(alpha)), alpha
    the normal pressure angle (rad).
    """
    return math.atan(coefficient / math.cos(pressure_angle))


def duplex_take_up(shift: float, leads: tuple[float, float], ratio: float) -> float:
    """Return the play at the wheel (rad) removed by shifting a duplex worm along its axis by
    `shift` (m).

    It is 2 pi shift |lead 1 - lead 2|/(ratio x mean lead^2), at the pitch circle. `leads` (m) are
    those of the two flanks: their difference is the growth of the thread's thickness per turn.
    `ratio` is that of the gearbox.
    """
    first, second = leads
    mean = (first + second) / 2
    return 2 * math.pi * shift * abs(first - second) / (ratio * mean**2)
