"""Thin cups of needle bearings in soft bores."""

from __future__ import annotations

import math

import pytest

from lostmotion.laws.annulus import Annulus
from lostmotion.laws.cycloid.cup import cup_in_bore
from lostmotion.laws.cycloid.seat import seat_compliance
from lostmotion.laws.rolling.radial import (
    ROLLER_EXPONENT,
    element_angles,
    radial_shift,
    roller_stiffness,
)

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "thin cup of a needle bearing in a soft bore",
        "published shifts and roller forces; the bearing in a rigid bore",
        "0.5 %",
        "laws/cycloid/cup.py",
    ),
)

# Bore of radius 10.5 mm in a body held at 14 mm, 18 mm wide; 18 rollers of 98 N/µm under 1 000 N:
# shift, µm, and largest force on a roller, N
PUBLISHED = [
    (2.4e9, 0.36, math.inf, 3.730, 222),
    (2.4e9, 0.36, 1.5e-3, 4.307, 213),
    (70e9, 0.33, math.inf, 2.323, 222),
    (70e9, 0.33, 1.5e-3, 2.390, 222),
    (1e18, 0.3, math.inf, 2.263, 222),
]


@pytest.mark.parametrize(("young", "nu", "thickness", "shift", "largest"), PUBLISHED)
def test_a_soft_bore_adds_to_the_bearing_and_the_cup_bends_in_it(
    young, nu, thickness, shift, largest
):
    """A plastic bore adds 65 to 90 % to the bearing's shift, the cup's own bending 15 %."""
    bore = Annulus(0.0105, 0.014, 0.018, young, nu)
    found, force = cup_in_bore(bore, thickness, 18, 98e6, 1.0, 1000.0)
    assert found * 1e6 == pytest.approx(shift, rel=5e-3)
    assert force == pytest.approx(largest, rel=5e-3)


def test_a_rigid_cup_adds_its_seat_to_the_bearing():
    """With hardening rollers: the bearing's own shift and that of a pressed seat; a thicker cup
    bends less.
    """
    bore, each = Annulus(0.0105, 0.014, 0.018, 2.4e9, 0.36), roller_stiffness(0.012)
    rigid, _ = cup_in_bore(bore, math.inf, 18, each, ROLLER_EXPONENT, 500.0)
    alone = float(radial_shift(500.0, 0.0, each, ROLLER_EXPONENT, element_angles(18)))
    assert rigid == pytest.approx(alone + 500.0 * seat_compliance(bore, "pressed"), rel=1e-9)
    thick, thin = (
        cup_in_bore(bore, wall, 18, each, ROLLER_EXPONENT, 500.0)[0] for wall in (3e-3, 1e-3)
    )
    assert rigid < thick < thin


def test_impossible_cups_are_refused():
    """Without force or wall there is nothing to solve."""
    bore = Annulus(0.0105, 0.014, 0.018, 2.4e9, 0.36)
    for thickness, force in ((0.0, 1.0), (1e-3, 0.0)):
        with pytest.raises(ValueError, match="above zero"):
            cup_in_bore(bore, thickness, 18, 98e6, 1.0, force)
