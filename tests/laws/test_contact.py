"""Line contact against the elastic half-plane, integrated numerically, and against its laws of
approach.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from lostmotion.laws.contact import (
    equivalent_modulus,
    lobe_compliance,
    palmgren_factor,
    peak_pressure,
    round_bar_compliance,
)
from tests.laws.closed_forms import approach, contact_force, half_width

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "line contact of cylinders, by Johnson and by Palmgren",
        (
            "integration of the stress below a half ellipse of pressure (Flamant); Palmgren by "
            "hand; each law against the other"
        ),
        "1e-3; printed digits; 15 %",
        "laws/contact.py",
    ),
)

STEEL = 210e9
BOTH = equivalent_modulus(STEEL, 0.3, STEEL, 0.3)
LAWS = ["johnson", "palmgren"]


def test_two_steel_bodies_halve_the_modulus():
    """The equivalent modulus of two equal bodies is half of E/(1 - nu^2); of one against a rigid
    body it is all of it.
    """
    assert pytest.approx(STEEL / (1 - 0.09) / 2) == BOTH
    assert equivalent_modulus(STEEL, 0.3, math.inf, 0) == pytest.approx(2 * BOTH)
    with pytest.raises(ValueError, match="elastic"):
        equivalent_modulus(math.inf, 0.3, math.inf, 0.3)
    with pytest.raises(ValueError, match="positive"):
        equivalent_modulus(STEEL, 0.6, STEEL, 0.3)


def test_pressure_over_the_width_carries_the_load():
    """The half ellipse of pressure over the contact adds up to the load: pi a p_H/2 = p."""
    load = np.array([1e3, 5e4, 2e5])
    wide, high = half_width(load, 4e-3, BOTH), peak_pressure(load, 4e-3, BOTH)
    np.testing.assert_allclose(math.pi / 2 * wide * high, load, rtol=1e-12)


def test_the_deformed_surface_fits_the_cylinder():
    """Under the half ellipse of pressure a half-plane sinks by x^2/(2 Req) less at x than at the
    centre of the contact (Flamant).
    """
    load, radius = 1e5, 4e-3
    a, high = (
        float(half_width(np.array(load), radius, BOTH)),
        float(peak_pressure(np.array(load), radius, BOTH)),
    )

    def sinks(x: float) -> float:
        # pressure as a function of an angle, so that the ends are smooth; the singularity at s = x
        # is split off
        at = math.acos(-x / a)
        return quad(
            lambda b: high * a * math.sin(b) ** 2 * -math.log(abs(x + a * math.cos(b))),
            0,
            math.pi,
            points=[at],
            limit=200,
        )[0]

    for x in (0.2 * a, 0.5 * a, 0.9 * a):
        # two equal bodies, each of modulus 2 E*
        less = 2 / (math.pi * 2 * BOTH) * 2 * (sinks(0.0) - sinks(x))
        assert less == pytest.approx(x**2 / (2 * radius), rel=1e-6)


def test_johnsons_law_integrates_the_strain_down_to_its_depth():
    """Each of two equal bodies contributes its strain under the middle of the contact, down to 2
    Req exp((1 + nu')/2 - 1) = 1.5 Req, to 0.1 %.
    """
    load, radius, nu = 1e5, 4e-3, 0.3
    a, high = (
        float(half_width(np.array(load), radius, BOTH)),
        float(peak_pressure(np.array(load), radius, BOTH)),
    )

    def strain(z: float) -> float:
        root = math.sqrt(1 + (z / a) ** 2)
        # Johnson (4.46)  # noqa: ERA001
        down, across = -high / root, -high * ((1 + 2 * (z / a) ** 2) / root - 2 * z / a)
        return -((1 - nu**2) * down - nu * (1 + nu) * across) / STEEL

    depth = 2 * radius * math.exp((1 + nu / (1 - nu)) / 2 - 1)
    assert depth == pytest.approx(1.5 * radius, rel=0.01)
    summed = quad(strain, 0, depth, points=[a], limit=200)[0]
    assert float(
        approach("johnson", np.array(load * 0.01), 0.01, np.array(radius), BOTH)
    ) == pytest.approx(2 * summed, rel=1e-3)


def test_johnsons_law_is_that_of_two_half_cylinders():
    """Johnson's law is that of two half-cylinders, p (1-nu^2)/(pi E) [2 ln(4 R/a) - 1] each, with
    Req for both radii.
    """
    p, req = 5e4, 3e-3
    a = float(half_width(np.array(p), req, BOTH))
    each = p * (1 - 0.09) / (math.pi * STEEL) * (2 * math.log(4 * req / a) - 1)
    assert float(
        approach("johnson", np.array(p * 0.01), 0.01, np.array(req), BOTH)
    ) == pytest.approx(2 * each, rel=1e-12)


def test_palmgrens_law_is_the_printed_one():
    """The approach under 1 000 N on 10 mm is 3.84e-5 x 1000^0.9/10^0.8 mm = 3.0502 µm."""
    assert float(
        approach("palmgren", np.array(1000.0), 0.010, np.array(4e-3), BOTH)
    ) * 1e6 == pytest.approx(3.0502, abs=5e-5)
    assert palmgren_factor(1e-3) == pytest.approx(3.84e-8)


def test_the_two_laws_differ_by_fifteen_percent():
    """For steel lobes of Req 1.5 to 12 mm under 20 to 200 N per mm the two laws stay within 15 % of
    their common mean.
    """
    radius, load = np.meshgrid(np.geomspace(1.5e-3, 12e-3, 9), np.geomspace(20e3, 200e3, 9))
    for width in (0.010, 0.020):
        one, other = (approach(law, load * width, width, radius, BOTH) for law in LAWS)
        mean = (one + other) / 2
        assert (np.abs(one - mean) <= 0.15 * mean).all()


@given(
    st.floats(1e-3, 2e5),
    st.floats(2e-3, 0.1),
    st.floats(5e-4, 0.1),
    st.sampled_from(LAWS),
    st.floats(5e8, 2e11),
)
@settings(deadline=None, max_examples=200)
def test_load_and_approach_are_inverse(
    force: float, width: float, radius: float, law: str, modulus: float
):
    """Load and approach invert each other wherever the law is valid; more force, more approach."""
    there = approach(law, np.array([force, 1.01 * force]), width, np.array(radius), modulus)
    if np.isfinite(there).all():
        np.testing.assert_allclose(
            contact_force(law, there, width, np.array(radius), modulus),
            [force, 1.01 * force],
            rtol=1e-7,
        )
        assert there[1] > there[0]


def test_beyond_its_range_johnsons_law_is_nan():
    """Where the contact would be as wide as the cylinder the law is not valid: NaN in either
    direction.
    """
    assert math.isnan(float(approach("johnson", np.array(1e8), 0.01, np.array(1e-3), 1e9)))
    assert math.isnan(float(contact_force("johnson", np.array(1e-2), 0.01, np.array(1e-3), 1e9)))


@pytest.mark.parametrize("law", LAWS)
def test_bodies_out_of_contact_do_not_push(law: str):
    """Without force there is no approach, and cylinders that do not touch exert no force."""
    np.testing.assert_array_equal(
        contact_force(law, np.array([-1e-6, 0.0]), 0.01, np.array(4e-3), BOTH), 0
    )
    assert float(approach(law, np.array(0.0), 0.01, np.array(4e-3), BOTH)) == 0


@pytest.mark.parametrize(
    ("ends", "shape"),
    [("supported", lambda s: s - 2 * s**3 + s**4), ("clamped", lambda s: s**2 * (1 - s) ** 2)],
)
def test_the_deflection_of_a_pin_is_the_mean_of_its_line(ends: str, shape):
    """A pin's deflection is the mean of the line under a uniform load, w l^4/(24 E I) times its
    shape; shear adds 1/12.
    """
    span, diameter = 0.02, 0.004
    second = math.pi * diameter**4 / 64
    bending = span**3 / (24 * STEEL * second) * quad(shape, 0, 1)[0]
    shear = span / (12 * 6 * 1.3 / 8.8 * STEEL / 2.6 * math.pi * diameter**2 / 4)
    assert round_bar_compliance(span, diameter, STEEL, 0.3, ends) == pytest.approx(
        bending + shear, rel=1e-12
    )


def test_a_lobe_is_a_short_cantilever():
    """A slender lobe deflects by h^3/(3 E I), a short one mostly by shear."""
    slender = 0.02**3 / (3 * STEEL * 0.01 * 0.002**3 / 12)
    assert lobe_compliance(0.02, 0.002, 0.01, STEEL, 0.3) == pytest.approx(slender, rel=0.02)
    assert lobe_compliance(0.001, 0.004, 0.01, STEEL, 0.3) > 5 * 0.001**3 / (
        3 * STEEL * 0.01 * 0.004**3 / 12
    )
