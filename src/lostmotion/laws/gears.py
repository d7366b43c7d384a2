"""What every reducer does, whatever is inside: wind-up in stiffness zones, lost motion; and what its teeth say of the ratio.

Sources: makers' rules as Harmonic Drive (K1/K2/K3 zones) and Nabtesco (lost motion at +-3 % of the rated torque) print them; ratios by Willis'
equation, speeds against the carrier times teeth being equal where two wheels mesh. Ratios are turns of the input per turn of the output,
negative where they go opposite ways.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from lostmotion.spatial import Floats


def wind_up(torque: Floats, stiffness: Sequence[float], limits: Sequence[float] = ()) -> Floats:
    """By which angle (rad) does the output wind up under torques (any shape, N m)? Odd in the torque.

    `stiffness` N m/rad, one per zone; `limits` N m, rising, one fewer: T/K1 up to T1, on top (T - T1)/K2 up to T2, then (T - T2)/K3.
    Raises ValueError where the counts do not fit or the limits do not rise.
    """
    if len(limits) != len(stiffness) - 1 or any(b <= a for a, b in zip((0.0, *limits), limits, strict=False)):
        raise ValueError("one rising torque limit fewer than stiffness zones is needed")
    size = np.abs(np.asarray(torque, dtype=float))
    angle = np.zeros_like(size)
    low = 0.0
    for k, high in zip(stiffness, (*limits, np.inf), strict=True):
        angle += np.clip(size - low, 0.0, high - low) / k
        low = high
    return np.asarray(np.sign(torque) * angle)


def friction_loop(wound: Callable[[Floats], Floats], torque: Floats, friction: Floats) -> tuple[Floats, Floats]:
    """Between which angles (rad) does friction leave the output at torques (any shape, N m)? As the torque rises, and as it falls.

    `wound` is the spring curve w, odd and rising: the angle (rad) under torques (N m); `friction` F (N m, zero or more, the shape of `torque`). While
    the torque rises friction carries F of it and the spring T - F; while it falls the spring still holds T + F: w(T - F) and w(T + F), half the width
    [w(T + F) - w(T - F)] / 2. That is w(F) at no torque and never more than w(|T| + F), where F times the slope at zero of a curve that starts soft
    is. Valid for friction that does not depend on the way the output took.
    """
    return wound(torque - friction), wound(torque + friction)


def play_from_lost_motion(lost_motion: float, small_torque: float, stiffness: Sequence[float], limits: Sequence[float] = ()) -> float:
    """How much of a lost motion (rad) is play, when it is read between + and - `small_torque` (N m)? May come out negative: then it is all elastic.

    Lost motion = play + 2 x wind-up at the small torque.
    """
    return lost_motion - 2 * float(wind_up(np.array([small_torque]), stiffness, limits)[0])


def planetary_ratio(sun: int, ring: int) -> float:
    """How often does the sun turn per turn of the planet carrier, with the ring held? From their teeth: 1 + ring/sun."""
    return 1 + ring / sun


def wolfrom_ratio(sun: int, planet: int, fixed_ring: int, output_planet: int, output_ring: int) -> float:
    """How often does the sun of a Wolfrom (3K) gearbox turn per turn of its second ring? From the teeth.

    Sun and held ring mesh with one wheel of each planet, the second ring with the other wheel of the same planet; the carrier runs free:
    (1 + z_r1/z_s) / (1 - z_r1 z_p2/(z_p1 z_r2)). Raises ValueError where the second ring stands still.
    """
    differ = planet * output_ring - fixed_ring * output_planet
    if not differ:
        raise ValueError("the output ring stands still: both rings ask the planets for the same speed")
    return (sun + fixed_ring) * planet * output_ring / (sun * differ)


def strain_wave_ratio(flexspline: int, circular_spline: int, *, flexspline_held: bool = False) -> float:
    """How often does the wave generator turn per turn of the output? From the teeth of the two splines.

    With the circular spline held the flexspline is the output and goes the other way, -z_f/(z_c - z_f); with the flexspline held the circular
    spline goes along, z_c/(z_c - z_f). Raises ValueError where the circular spline has no more teeth than the flexspline.
    """
    more = circular_spline - flexspline
    if more <= 0:
        raise ValueError("a circular spline has more teeth than the flexspline inside it")
    return circular_spline / more if flexspline_held else -flexspline / more


def friction_angle(coefficient: float, pressure_angle: float) -> float:
    """Up to which lead angle (rad) does friction keep a wheel from driving its worm? atan(mu/cos(alpha)), alpha the normal pressure angle (rad)."""
    return math.atan(coefficient / math.cos(pressure_angle))


def duplex_take_up(shift: float, leads: tuple[float, float], ratio: float) -> float:
    """Which play at the wheel (rad) does shifting a duplex worm along its axis by `shift` (m) take away?

    `leads` (m) of the two flanks of its thread, which so grows thicker along the worm by their difference per turn; `ratio` is that of the
    gearbox. At the pitch circle, 2 pi shift |lead 1 - lead 2| / (ratio x mean lead^2).
    """
    first, second = leads
    mean = (first + second) / 2
    return 2 * math.pi * shift * abs(first - second) / (ratio * mean**2)
