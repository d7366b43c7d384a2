"""Seats against exact solutions, finite elements, and Hertz's contact."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lostmotion.laws.annulus import Annulus
from lostmotion.laws.cycloid.seat import (
    cosine_pressure_compliance,
    pin_in_bore,
    seat_compliance,
    tilt_stiffness_per_length,
)

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "seats of pins and bearings",
        "exact plane solutions; finite elements; rubber bushes",
        "4 digits; 0.3 % for a receding contact",
        "laws/cycloid/seat.py",
    ),
)

# outer over inner radius: C E b of bonded, pressed and snug seats, nu 0.3, plane strain
PUBLISHED = {
    1.5: (0.0763, 0.1087, 0.218),
    2.0: (0.1351, 0.1918, 0.381),
    3.0: (0.2266, 0.3067, 0.594),
    5.0: (0.3523, 0.4469, 0.807),
    10.0: (0.5320, 0.6332, 1.03),
}
# the same by finite elements
FINITE_ELEMENTS = {
    (2.0, "bonded"): 0.1351,
    (2.0, "pressed"): 0.1918,
    (2.0, "snug"): 0.3815,
    (5.0, "bonded"): 0.3523,
    (5.0, "snug"): 0.8045,
}
UNIT = 1e9  # so that moduli stay physical while the figures are per E b


@pytest.mark.parametrize("ratio", PUBLISHED)
def test_compliance_of_a_seat_by_its_fit(ratio):
    """Bonded and pressed seats are exact; a snug one depends a little on the number of points
    around the bore.
    """
    body = Annulus(0.005, 0.005 * ratio, 1 / UNIT, UNIT, 0.3)
    bonded, pressed, snug = PUBLISHED[ratio]
    assert seat_compliance(body, "bonded") == pytest.approx(bonded, abs=5e-5)
    assert seat_compliance(body, "pressed") == pytest.approx(pressed, abs=5e-5)
    assert seat_compliance(body, "snug") == pytest.approx(snug, rel=5e-3)


@pytest.mark.parametrize(("ratio", "fit"), FINITE_ELEMENTS)
def test_seats_agree_with_finite_elements(ratio, fit):
    """Receding contact included, to 0.3 %."""
    assert seat_compliance(Annulus(1.0, ratio, 1.0, 1.0, 0.3), fit) == pytest.approx(
        FINITE_ELEMENTS[ratio, fit], rel=3e-3
    )


def test_seats_in_plane_stress():
    """A thin plate of a polymer: bonded 0.2532 and lifting 0.6499 by finite elements."""
    body = Annulus(1.0, 3.0, 1.0, 1.0, 0.36, "stress")
    assert seat_compliance(body, "bonded") == pytest.approx(0.2532, abs=5e-5)
    assert seat_compliance(body, "snug") == pytest.approx(0.6499, rel=1e-3)


def test_an_incompressible_bonded_bush_is_that_of_rubber():
    """Adkins and Gent: F/u = 4 pi G b/[ln(c/a) - (c^2 - a^2)/(c^2 + a^2)] for a long bush."""
    inner, outer, shear = 0.006, 0.0145, 1e6
    body = Annulus(inner, outer, 0.02, 3 * shear, 0.5)
    expected = (math.log(outer / inner) - (outer**2 - inner**2) / (outer**2 + inner**2)) / (
        4 * math.pi * shear * 0.02
    )
    assert seat_compliance(body, "bonded") == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("load", "shift", "angle"), [(5e3, 2.334, 11.7), (20e3, 6.648, 22.5), (80e3, 18.70, 37.6)]
)
def test_a_pin_with_clearance(load, shift, angle):
    """Radial clearance 50 µm in a polymer: the shift beyond the clearance, µm, and half the angle
    of contact, which Hertz's formula overestimates.
    """
    body = Annulus(4.5e-3, 9e-3, 1.0, 2.4e9, 0.36)
    found, half = pin_in_bore(body, load, 50e-6)
    assert found * 1e6 == pytest.approx(shift, rel=3e-3)
    assert math.degrees(half) == pytest.approx(angle, abs=0.35)  # two points of the mesh
    hertz = (
        math.sqrt(4 * load * body.loaded**2 / 50e-6 / (math.pi * body.plane_modulus)) / body.loaded
    )
    assert math.degrees(half) < math.degrees(hertz) * 1.02
    assert pin_in_bore(body, 16 * load, 50e-6)[0] < 16 * found


@pytest.mark.parametrize(("load", "shift"), [(5e3, 0.71), (20e3, 2.85), (80e3, 11.4)])
def test_a_snug_pin_shifts_in_proportion_to_its_load(load, shift):
    """Receding contact: the extent of contact does not depend on the load."""
    assert pin_in_bore(Annulus(4.5e-3, 9e-3, 1.0, 2.4e9, 0.36), load, 0.0)[
        0
    ] * 1e6 == pytest.approx(shift, rel=5e-3)


def test_fits_differ_by_a_local_term_in_large_bodies():
    """Pressed - bonded 0.10, snug - bonded 0.46 to 0.53 over E b, whatever the size of the body; a
    cosine pressure on half is softer than bonded.
    """
    for ratio in (5.0, 20.0):
        body = Annulus(1.0, ratio, 1.0, 1.0, 0.3)
        bonded = seat_compliance(body, "bonded")
        assert seat_compliance(body, "pressed") - bonded == pytest.approx(0.10, abs=0.01)
        assert 0.45 < seat_compliance(body, "snug") - bonded < 0.54
        assert cosine_pressure_compliance(body) == pytest.approx(
            seat_compliance(body, "snug"), rel=0.01
        )


@given(st.floats(1.2, 20.0), st.floats(0.0, 0.45), st.sampled_from(["strain", "stress"]))
@settings(deadline=None, max_examples=40)
def test_a_better_fit_is_stiffer(ratio, nu, plane):
    """Adhesion and preload only add constraints."""
    body = Annulus(1.0, ratio, 1.0, 1.0, nu, plane)
    bonded, pressed, snug = (seat_compliance(body, fit) for fit in ("bonded", "pressed", "snug"))
    assert 0 < bonded < pressed < snug
    assert (
        tilt_stiffness_per_length(body)
        > tilt_stiffness_per_length(Annulus(1.0, 1.1 * ratio, 1.0, 1.0, nu, plane))
        > 0
    )


@pytest.mark.parametrize(
    ("force", "clearance"), [(0.0, 1e-5), (-1.0, 1e-5), (1.0, -1e-5), (math.nan, 0.0)]
)
def test_impossible_pins_are_refused(force, clearance):
    """A force that pulls, or a pin larger than its bore."""
    with pytest.raises(ValueError, match="force above zero and a clearance of zero or more"):
        pin_in_bore(Annulus(1.0, 2.0, 1.0, 1.0, 0.3), force, clearance)
