"""Finite elements of a disc in an envelope ring: contacts of both branches, and their outlines."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from lostmotion.laws.contact import equivalent_modulus
from lostmotion.laws.cycloid.bodies import ElasticBody
from lostmotion.laws.cycloid.contact import Flanks
from lostmotion.laws.cycloid.drive import Drive, loaded_disc, nominal_gaps
from lostmotion.laws.cycloid.envelope import second_contacts
from lostmotion.laws.cycloid.envelope_contact import envelope_contact
from lostmotion.laws.cycloid.finite_elements.envelope import EnvelopeContacts, envelope_contacts
from lostmotion.laws.cycloid.finite_elements.stage import loaded_stage
from lostmotion.laws.cycloid.geometry import arms
from lostmotion.laws.cycloid.ring import repeat_pitch, ring_pitch
from lostmotion.laws.cycloid.stage import Modification, Stage

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "finite elements of an envelope ring",
        (
            "contacts of both branches on elastic bodies; largest pressure by the contact "
            "along the whole flank, three stages; torque of the "
            "forces; distances to the ring from a polygon of its profile"
        ),
        "1 %; 6 %; 0.3 %; 1 nm",
        "laws/cycloid/finite_elements/envelope.py",
    ),
)

STAGE = Stage(0.05, 0.003, 0.0012, 20, "lobe envelope")
SMALL = Stage(0.034, 0.0035, 0.0015, 14, "lobe envelope")


@cache
def found(stage: Stage, crank: float) -> tuple[EnvelopeContacts, dict[int, np.ndarray]]:
    """Return the contacts where the gap is below 0.3 µm, in intervals of 50 µm."""
    return envelope_contacts(
        stage,
        crank,
        Modification(),
        lambda theta: np.full(len(theta), 3e-7),
        lambda theta: np.full(len(theta), 5e-5),
    )


@pytest.mark.parametrize(
    ("stage", "crank"), [(STAGE, 0.0), (STAGE, 0.157), (SMALL, 0.157), (SMALL, 1.0)]
)
def test_outlines_are_closed_and_have_one_edge_for_each_interval(stage, crank):
    """Both outlines are closed, counter-clockwise, without slivers, with one edge for each interval
    of a contact.
    """
    made, at = found(stage, crank)
    for edges in (made.planet_outline(at), made.ring_outline(at)):
        starts, ends = (np.array([edge.points[k] for edge in edges]) for k in (0, -1))
        assert np.abs(np.roll(starts, -1) - ends).max() < 1e-12
        assert np.abs(ends - starts).min() > 5e-6
        assert (np.conj(starts) * ends).imag.sum() > 0
        assert sorted(edge.contact for edge in edges if edge.contact >= 0) == [
            k for k, places in at.items() for _ in places[1:]
        ]


@pytest.mark.parametrize("stage", [STAGE, SMALL])
def test_gaps_are_distances_from_the_profile_of_the_ring(stage):
    """The gap of every node is its distance from a fine polygon of the ring, which is drawn by
    another function; it is zero at second contacts.
    """
    made, at = found(stage, 0.157)
    polygon = repeat_pitch(ring_pitch(stage, 8_001), stage.pins) @ np.array([1, 1j])
    for k, places in at.items():
        corners = np.array(
            [edge.points[0] for edge in made.planet_outline({k: places}) if edge.contact == k]
        )
        nearest = np.abs(polygon[:, None] - corners).argmin(axis=0)
        along = polygon[nearest + 1] - polygon[nearest - 1]
        expected = np.abs(((corners - polygon[nearest]) * np.conj(along / np.abs(along))).imag)
        np.testing.assert_allclose(
            np.sort(made.surface(k, places[:-1])[0]), np.sort(expected), rtol=0, atol=1e-9
        )
    t = second_contacts(stage, [0.157])[0]
    theta = -stage.lobes * t[np.isfinite(t)]
    for angle in theta[arms(stage, theta) > 0.3 * stage.planet_pitch_radius]:
        k = int(np.abs(np.angle(np.exp(1j * (made.theta - angle)))).argmin())
        fine = np.linspace(at[k][0], at[k][-1], 2001)
        assert abs(made.surface(k, fine)[0].min()) < 1e-12


def test_places_along_a_flank_are_found_again():
    """The point of the disc at a place of a contact has its foot there."""
    made, at = found(STAGE, 0.157)
    for k, places in at.items():
        points = made.planet_outline({k: places})
        corners = np.array([edge.points[0] for edge in points if edge.contact == k])
        np.testing.assert_allclose(np.sort(made.along(k, corners)), places[:-1], atol=1e-10)


def test_interfering_relief_is_refused_before_meshing():
    """A disc with added material interferes with its envelope; gaps of single lobes have no meaning
    there.
    """
    disc = ElasticBody("planet", 0.02, 210e9, 0.3)
    with pytest.raises(ValueError, match="interfere before they are loaded, at"):
        loaded_stage(STAGE, disc, None, 0.01, np.array([100.0]), relief=Modification(roller=-1e-6))
    with pytest.raises(ValueError, match="single lobes"):
        loaded_stage(STAGE, disc, None, 0.01, np.array([100.0]), gaps=np.full(20, 1e-6))


@pytest.mark.slow
def test_both_branches_on_elastic_bodies_wind_up_as_by_finite_elements():
    """Contacts of both branches on the exact bodies wind up as contact by finite elements within 1
    %, with the same pressure within 5 %.

    More stages, with results computed beforehand: tests/validation/test_fem_cases.py.
    """
    bodies = ElasticBody("planet", 0.0105, 2.4e9, 0.3), ElasticBody("ring", 0.038, 2.4e9, 0.3)
    angle = np.array([0.1])
    made = loaded_stage(SMALL, *bodies, 0.01, np.array([0.2]), crank=0.1)
    drive = Drive(
        SMALL,
        Flanks(0.01, equivalent_modulus(2.4e9, 0.3, 2.4e9, 0.3)),
        disc_body=bodies[0],
        ring_body=bodies[1],
    )
    found = loaded_disc(drive, 0.2, angle, nominal_gaps(drive, angle))
    assert found.rotation.item() == pytest.approx(made.rotation[0], rel=0.01)
    assert found.pressures.max() == pytest.approx(made.peak.max(), rel=0.05)
    assert made.forces[0] @ arms(SMALL, made.theta) == pytest.approx(0.2, rel=0.003)


@pytest.mark.parametrize(
    ("stage", "hub", "outer", "crank", "peak"),
    [
        (STAGE, 0.02, 0.06, 0.0, 993.1e6),
        (STAGE, 0.02, 0.06, math.pi / 20, 999.9e6),
        (SMALL, 0.0105, 0.044, 0.0, 1318e6),
    ],
    ids=["N 20", "half a pitch", "N 14"],
)
def test_the_largest_pressure_is_that_of_finite_elements(stage, hub, outer, crank, peak):
    """Along the flank on half-planes within 6 %, of contacts on elastic bodies within 5 %; steel,
    10 mm, 100 N m, solved by `loaded_stage` before.
    """
    flanks, angle = Flanks(0.01, equivalent_modulus(210e9, 0.3, 210e9, 0.3)), np.array([crank])
    assert envelope_contact(stage, flanks, 100.0, angle).peak[0] == pytest.approx(peak, rel=0.06)
    drive = Drive(
        stage,
        flanks,
        disc_body=ElasticBody("planet", hub, 210e9, 0.3),
        ring_body=ElasticBody("ring", outer, 210e9, 0.3),
    )
    assert loaded_disc(
        drive, 100.0, angle, nominal_gaps(drive, angle)
    ).pressures.max() == pytest.approx(peak, rel=0.05)
