"""Torsional stiffness of a housing: a tube, and a circle of screws that transmit its torque.

A bolted joint is rigid until it slips, at the torque n mu F r. Then every screw is a pin in its
seats, and the joint turns by the torque over n k r^2, after the clearance of the screws in their
holes.

Source: VDI 2230 (slip of bolted joints); the screw in its seat as an output pin
(`cycloid.output_pins`).
"""

from __future__ import annotations

import math
from typing import Literal

from lostmotion.laws.cycloid.output_pins import ElasticPinSeat, HeldPin

Thread = Literal["M2", "M2.5", "M3", "M4", "M5", "M6", "M8", "M10", "M12", "M16"]


def nominal_diameter(size: Thread) -> float:
    """Return the nominal diameter (m) of a metric screw."""
    return float(size[1:]) * 1e-3


def screw_stiffness(size: Thread, young: float, nu: float, seat: ElasticPinSeat) -> float:
    """Return the stiffness (N/m) of a screw that is pushed sideways where two bodies meet.

    size, young, nu  of the screw; seat: its seat in the softer body. The other body counts as
                     rigid.
    """
    pin, seats = HeldPin(
        nominal_diameter(size), young, nu, 0.0, (0.0, 0.0), flange=seat
    ).compliance()
    return 1 / (pin + seats)


def slip_torque(count: int, circle: float, preload: float, friction: float) -> float:
    """Return the torque (N m) at which a bolted circle slips: n mu F r, with the radius of the
    circle (m) and the preload of a screw (N).
    """
    return count * friction * preload * circle


def circle_stiffness(count: int, circle: float, screw: float) -> float:
    """Return the torsional stiffness n k r^2 (N m/rad) of screws of a stiffness (N/m) on a circle
    of this radius (m).
    """
    return count * screw * circle**2


def tube_stiffness(radius: float, wall: float, length: float, shear: float) -> float:
    """Return the torsional stiffness (N m/rad) of a tube: 2 pi r^3 t G/L for a thin wall, exact for
    a thick one.

    radius  mean radius of the wall, m; wall: its thickness, m; shear: shear modulus, Pa
    """
    outer, inner = radius + wall / 2, radius - wall / 2
    return math.pi / 2 * (outer**4 - inner**4) * shear / length
