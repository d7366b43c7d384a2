"""Disc and envelope ring with their exact profile: round bodies as limits, the number of point
forces, and stages of every shape.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.annulus import Annulus, flexibility
from lostmotion.laws.cycloid.envelope import second_contacts
from lostmotion.laws.cycloid.geometry import contact_radius, normals, pin_angles
from lostmotion.laws.cycloid.lobed_wheel import _attempt, contact_flexibility
from lostmotion.laws.cycloid.stage import Stage

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "disc and envelope ring with their exact profile",
        "the annulus as their limit without lobes; more point forces; reciprocity in random stages",
        "0.2 %; 0.1 %; 1 % of the largest displacement",
        "laws/cycloid/lobed_wheel.py",
    ),
)

NU = 0.3


def unit_disc(hub: float, nu: float = NU) -> Annulus:
    """Return a disc of unit modulus and width, in plane strain."""
    return Annulus(1.0, hub, 1.0, 1.0, nu)


@pytest.mark.parametrize("hub", [0.01, 0.02, 0.04])
def test_without_lobes_it_is_the_annulus(hub: float):
    """At an eccentricity of 1/100 000 of the radius the disc is round: displacements are those of
    the annulus, exact by Fourier series.
    """
    stage = Stage(0.05, 0.003, 5e-7, 20)
    theta = pin_angles(stage, np.array([0.1]))[0]
    along = np.angle(normals(stage, theta) @ np.array([1, 1j]))
    rim, half = stage.ring_radius - stage.pin_radius, 4e-3
    slant = along - np.angle(
        stage.ring_radius * np.exp(1j * theta)
        - stage.eccentricity
        - stage.pin_radius * np.exp(1j * along)
    )
    exact = flexibility(Annulus(rim, hub, 1.0, 1.0, NU), along - slant, slant, half)
    exact += np.diag(
        2
        * np.log(half * rim / (4 * contact_radius(stage, theta) * math.exp(-0.75)))
        * (1 - NU**2)
        / math.pi
    )
    np.testing.assert_allclose(
        contact_flexibility(stage, unit_disc(hub), 0.1), exact, atol=2e-3 * np.abs(exact).max()
    )


@pytest.mark.parametrize(
    "stage",
    [
        Stage(0.064, 0.003, 0.0013, 40),
        Stage(0.05, 0.0061, 0.0029, 14),
        Stage(0.05, 0.003, 0.0012, 20),
    ],
)
def test_more_point_forces_change_nothing(stage: Stage):
    """The displacements at 24 and at 60 point forces per lobe differ by less than 1/1000 of the
    largest.
    """
    first, second = (_attempt(stage, unit_disc(0.02), 0.013, density) for density in (24, 60))
    np.testing.assert_allclose(first, second, atol=1e-3 * np.abs(second).max())


@pytest.mark.parametrize("outer", [0.052, 0.06, 0.1])
def test_a_ring_without_lobes_is_the_annulus(outer: float):
    """At an eccentricity of 1/100 000 of the radius an envelope ring is round: displacements are
    those of the annulus, exact by Fourier series.
    """
    stage = Stage(0.05, 0.003, 5e-7, 20, "lobe envelope")
    theta = pin_angles(stage, np.array([0.1]))[0]
    along = np.angle(normals(stage, theta) @ np.array([1, 1j]))
    rim, half = stage.ring_radius - stage.pin_radius, 4e-3
    slant = along - np.angle(
        stage.ring_radius * np.exp(1j * theta) - stage.pin_radius * np.exp(1j * along)
    )
    exact = flexibility(Annulus(rim, outer, 1.0, 1.0, NU), along - slant, slant, half)
    exact += np.diag(
        2
        * np.log(half * rim / (4 * contact_radius(stage, theta) * math.exp(-0.75)))
        * (1 - NU**2)
        / math.pi
    )
    found = contact_flexibility(stage, Annulus(rim, outer, 1.0, 1.0, NU), 0.1, "ring")
    np.testing.assert_allclose(found, exact, atol=2e-3 * np.abs(exact).max())


@pytest.mark.parametrize(
    ("pins", "pin", "eccentricity", "outer"),
    [(14, 0.0061, 0.0029, 0.055), (20, 0.003, 0.0012, 0.06), (40, 0.0025, 0.0006, 0.051)],
)
def test_rings_are_reciprocal_at_contacts_of_both_branches(
    pins: int, pin: float, eccentricity: float, outer: float
):
    """Displacements of a ring at all contacts are reciprocal to 1/1000 before they are made
    symmetric, and more point forces change them no more.
    """
    stage = Stage(0.05, pin, eccentricity, pins, "lobe envelope")
    second = second_contacts(stage, [0.05])[0]
    second = second[np.isfinite(second)]
    found, finer = (
        _attempt(stage, Annulus(0.05, outer, 1.0, 1.0, NU), 0.05, density, "ring", second)
        for density in (48, 96)
    )
    np.testing.assert_allclose(found, found.T, atol=1e-3 * np.abs(found).max())
    np.testing.assert_allclose(found, finer, atol=1e-3 * np.abs(found).max())


@settings(max_examples=15, deadline=None)
@given(
    st.integers(5, 70),
    st.floats(0.15, 0.95),
    st.floats(0.15, 0.95),
    st.floats(0.15, 0.97),
    st.floats(0, 6),
    st.floats(0.0, 0.48),
)
def test_discs_of_every_shape_are_resolved(
    pins: int, shortening: float, share: float, wall: float, crank: float, nu: float
):
    """Displacements are reciprocal before they are made symmetric, and a force never moves a disc
    away from itself at a distance.
    """
    try:
        stage = Stage(0.05, share * 0.05 * math.sin(math.pi / pins), shortening * 0.05 / pins, pins)
    except ValueError:
        assume(False)
        raise
    hub = max(wall * (stage.tip_radius - 2 * stage.eccentricity), 0.15 * 0.05)
    assume(hub < 0.98 * (stage.tip_radius - 2 * stage.eccentricity))
    found = contact_flexibility(stage, unit_disc(hub, nu), crank)
    assert np.isfinite(found).all()
    # turning the crank by a pitch shifts the contacts by one
    np.testing.assert_allclose(
        contact_flexibility(stage, unit_disc(hub, nu), crank + 2 * math.pi / pins),
        np.roll(found, (1, 1), (0, 1)),
        atol=5e-3 * np.abs(found).max(),
    )


def test_flanks_too_sharp_are_reported():
    """Pins of a thousandth of the radius between flanks nearly as sharp are not resolved, and no
    plausible number is returned.
    """
    with pytest.raises(DidNotConvergeError, match="too sharp"):
        contact_flexibility(Stage(0.05, 2e-5, 0.0012, 20), unit_disc(0.02), 0.1)
