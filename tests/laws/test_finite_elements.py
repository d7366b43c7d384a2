"""Finite elements of a loaded cycloidal stage against reference solutions by another contact
method, and against exact laws.
"""

from __future__ import annotations

import functools
import importlib.util
import math
from dataclasses import replace

import numpy as np
import pytest

from lostmotion.errors import LostmotionError
from lostmotion.laws.contact import equivalent_modulus
from lostmotion.laws.cycloid.bodies import ElasticBody
from lostmotion.laws.cycloid.contact import Flanks
from lostmotion.laws.cycloid.drive import Drive, loaded_disc, nominal_gaps
from lostmotion.laws.cycloid.finite_elements import selection
from lostmotion.laws.cycloid.finite_elements.contours import contacts, gaps_at, pinned, toothed
from lostmotion.laws.cycloid.finite_elements.mesh import Meshes
from lostmotion.laws.cycloid.finite_elements.stage import Loaded, loaded_stage
from lostmotion.laws.cycloid.geometry import arms, contact_radius, normals, pin_angles
from lostmotion.laws.cycloid.stage import Kind, Stage
from lostmotion.laws.perforated_disc_series import Holes

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "finite elements of a cycloidal stage",
        (
            "three other contact methods (penalty in NGSolve, active set in scikit-fem, "
            "CalculiX), which agree to 0.2 %: rotation with a rigid "
            "and an elastic ring, half a pitch on, with gaps; loads; largest pressure; "
            "largest von Mises stress (third order); stress below a "
            "Hertz contact 0.5575 p0; torque and force across the crank; the disc with holes "
            "by a method without a mesh; lobes of plain arcs by"
            " contacts on elastic bodies; outlines and curved elements from the exact profile"
        ),
        (
            "0.3 %, with a turned crank or gaps 0.5 %; 1 %; 2 %; 3 %; 3 %; 0.1 %; 1 %; 0.3 %; "
            "0.02 µm, at contacts 0.01 µm"
        ),
        (
            "laws/cycloid/finite_elements/stage.py laws/cycloid/finite_elements/mesh.py "
            "laws/cycloid/finite_elements/contours.py "
            "laws/cycloid/finite_elements/equilibrium.py "
            "laws/cycloid/finite_elements/selection.py "
            "tests/laws/test_finite_elements_outlines.py"
        ),
    ),
)

STAGE = Stage(0.05, 0.003, 0.0012, 20)
PLANET, RING = ElasticBody("planet", 0.02, 210e9, 0.3), ElasticBody("ring", 0.06, 210e9, 0.3)
TORQUES = np.array([50.0, 100.0])
ARCMIN = math.pi / 180 / 60
KINDS: tuple[Kind, ...] = ("ring pins", "lobe arcs", "planet pins")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("crank", [0.0, 0.157, 2.5])
def test_profiles_touch_at_every_contact_and_part_by_the_equivalent_radius(kind, crank):
    """Unloaded flanks touch at every pin, and beside the contact the gap grows as s^2/(2 Req)."""
    stage = Stage(0.05, 0.003, 0.0012, 20, kind)
    made = contacts(stage, crank)
    s = 20e-6
    for k in range(stage.pins):
        gap = gaps_at(made, k, np.array([-s, 0.0, s]))
        assert abs(gap[1]) < 1e-15
        assert (gap[0] + gap[2]) / 2 == pytest.approx(
            s**2 / 2 / contact_radius(stage, made.theta[k]), rel=2e-3
        )


@pytest.mark.parametrize("kind", KINDS)
def test_outlines_are_closed_and_have_the_corners_asked_for(kind):
    """The outlines of both wheels are closed curves with one edge for each interval of a
    contact.
    """
    made = contacts(Stage(0.05, 0.003, 0.0012, 20, kind), 0.3)
    at = {k: np.linspace(-1e-4, 1e-4, 6) for k in (2, 3, 7)}
    for edges in (toothed(made, at), pinned(made, at)):
        starts, ends = (np.array([edge.points[k] for edge in edges]) for k in (0, -1))
        assert np.abs(np.roll(starts, -1) - ends).max() < 1e-12
        assert (
            sorted(edge.contact for edge in edges if edge.contact >= 0)
            == [2] * 5 + [3] * 5 + [7] * 5
        )
        assert (np.conj(starts) * ends).imag.sum() > 0


def test_thin_wheels_and_interfering_flanks_are_refused_before_meshing():
    """A hub that cuts the teeth, a ring that cuts its pins, interference and gaps of single
    envelope lobes are refused with the possible value.
    """
    for said, planet, ring, gap, kind in (
        ("reach in to 45.8 mm", replace(PLANET, edge=0.046), RING, 0.0, "ring pins"),
        ("reach out to 53 mm", PLANET, replace(RING, edge=0.0529), 0.0, "ring pins"),
        ("interfere before they are loaded, at pin 0 by 2 µm", PLANET, RING, -2e-6, "ring pins"),
        (
            "leave 0.1 mm to the bore",
            replace(PLANET, holes=Holes(6, 0.0301, 0.01)),
            RING,
            0.0,
            "ring pins",
        ),
        ("gaps of single lobes", PLANET, RING, 1e-6, "lobe envelope"),
    ):
        with pytest.raises(ValueError, match=said):
            loaded_stage(
                Stage(0.05, 0.003, 0.0012, 20, kind),
                planet,
                ring,
                0.01,
                TORQUES,
                gaps=np.full(20, gap),
            )


def test_without_ngsolve_the_message_names_the_extra(monkeypatch):
    """Without NGSolve the message says how to install it."""
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    with pytest.raises(LostmotionError, match=r"pip install 'lostmotion\[fem\]'"):
        loaded_stage(STAGE, PLANET, RING, 0.01, TORQUES)


@functools.cache
def solved() -> Loaded:
    """Return the reference stage with its elastic ring under both torques, with the elements of
    third order that its stresses need.
    """
    return loaded_stage(STAGE, PLANET, RING, 0.01, TORQUES, order=3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("ring", "crank", "gap", "expected", "within"),
    [
        (None, 0.0, 0.0, (0.2040, 0.3953), 0.003),
        (RING, 0.0, 0.0, (0.3251, 0.6247), 0.003),
        (RING, math.pi / 20, 0.0, (0.3249, 0.6244), 0.005),
        (RING, 0.0, 1e-6, (None, 0.8147), 0.005),
    ],
    ids=["rigid ring", "elastic ring", "half a pitch", "gaps"],
)
def test_rotation_agrees_with_an_independent_contact_method(ring, crank, gap, expected, within):
    """The rotation agrees with penalty contact of NGSolve, an active set of scikit-fem and
    CalculiX, which agree to 0.2 %.
    """
    if ring is not None and not crank and not gap:
        found = solved()  # which the tests below need too
    else:  # elements of the usual order, a quarter larger: within 0.2 % of the reference
        found = loaded_stage(
            STAGE, PLANET, ring, 0.01, TORQUES, crank=crank, gaps=np.full(20, gap), intervals=4
        )
    for value, reference in zip(found.rotation / ARCMIN, expected, strict=True):
        if reference is not None:
            assert value == pytest.approx(reference, rel=within)


@pytest.mark.slow
def test_loads_pressures_and_equilibrium_of_the_reference_stage():
    """Loads and pressures agree with the reference; the torque is that of the forces, and across
    the crank they add up to T/(e z).
    """
    found = solved()
    expected = [36.6, 553.4, 810.0, 868.2, 839.2, 764.7, 655.9, 516.4, 351.9, 169.9]
    np.testing.assert_allclose(found.forces[1, :10], expected, rtol=0.01, atol=1.5)
    assert not found.forces[:, 10:].any()
    np.testing.assert_allclose(found.peak.max(axis=1) / 1e6, [789, 1115], rtol=0.02)
    theta = pin_angles(STAGE, np.zeros(1))[0]
    # the contacts move by the slip of the flanks, which changes the arms by less than 0.1 %
    np.testing.assert_allclose(found.forces @ arms(STAGE, theta), TORQUES, rtol=1e-3)
    np.testing.assert_allclose(
        (found.forces @ normals(STAGE, theta))[:, 1], TORQUES / STAGE.planet_pitch_radius, rtol=1e-3
    )
    steps = np.diff(found.torque) / np.diff(found.rotation)
    assert found.stiffness[0] < steps[0] < found.stiffness[1]


@pytest.mark.slow
@pytest.mark.parametrize(("level", "stress"), [(0, 442e6), (1, 626e6)])
def test_largest_stress_is_that_of_hertz_below_the_surface(level, stress):
    """With elements of third order the largest von Mises stress is that of the reference, and
    0.5575 of the largest Hertz pressure.
    """
    found = solved()
    largest, strain = found.largest(level)
    assert largest == pytest.approx(stress, rel=0.03)
    assert largest == pytest.approx(0.5575 * found.peak[level].max(), rel=0.03)
    assert strain == pytest.approx(largest / (3 * 210e9 / 2.6), rel=1e-9)


@pytest.mark.slow
def test_stress_is_largest_at_the_depth_of_hertz():
    """The largest von Mises stress of the disc lies 0.704 half-widths below the surface of a
    contact.
    """
    found = solved()
    at = found.wheels[0].place_of_largest(found.pressures[1])
    made = contacts(STAGE, 0.0)
    k = int(np.abs(at - made.pin - STAGE.pin_radius * made.towards).argmin())
    depth = abs(at - made.pin[k]) - STAGE.pin_radius
    assert depth == pytest.approx(0.704 * found.half_width[1, k], rel=0.15)


@pytest.mark.slow
def test_rotation_depends_on_torque_per_width_and_turns_with_the_pitch():
    """Twice the width carries twice the torque with the same rotation, and a crank turned by a
    pitch shifts the loads by one pin, here of a rigid ring.
    """
    stage, pitch, meshes = Stage(0.05, 0.003, 0.0024, 10), 2 * math.pi / 10, Meshes()
    once, turned, twice = (
        loaded_stage(stage, PLANET, None, width, np.array([torque]), crank=crank, meshes=meshes)
        for width, torque, crank in ((0.01, 100.0, 0.0), (0.01, 100.0, pitch), (0.02, 200.0, 0.0))
    )
    assert twice.rotation[0] == pytest.approx(once.rotation[0], rel=1e-6)
    assert turned.rotation[0] == pytest.approx(once.rotation[0], rel=1e-3)
    np.testing.assert_allclose(np.roll(turned.forces[0], -1), once.forces[0], rtol=0.005, atol=1.0)


@pytest.mark.slow
def test_a_lobe_that_touches_beside_the_part_meshed_first_carries_its_share(monkeypatch):
    """Where play lets the flanks move by more than the width meshed at first, a lobe carries a
    tenth of the load as if all of its flank were meshed, though no node of that part closes.
    """
    stage = Stage(0.034, 0.003, 0.0024, 10)
    play = np.where(np.arange(10) == 4, 57e-6, 150e-6)
    solve = functools.partial(
        loaded_stage, stage, ElasticBody("planet", 0.012, 2e9, 0.38), None, 0.008, gaps=play
    )
    found = solve(torques=np.array([2.5]), intervals=3).forces[0]
    monkeypatch.setattr(selection, "_REACH", 6.0)
    wide = solve(torques=np.array([2.5])).forces[0]
    assert wide[4] > 0.09 * wide.sum()
    np.testing.assert_allclose(found, wide, rtol=0, atol=0.016 * wide.sum())


@pytest.mark.slow
def test_planet_pins_carry_the_torque():
    """With planet pins the forces balance the torque by the arms of that geometry."""
    stage = Stage(0.05, 0.003, 0.0024, 10, "planet pins")
    found = loaded_stage(stage, PLANET, RING, 0.01, np.array([100.0]), crank=0.1)
    theta = pin_angles(stage, np.array([0.1]))[0]
    assert found.forces[0] @ arms(stage, theta) == pytest.approx(100.0, rel=2e-3)


@pytest.mark.slow
def test_holes_that_take_the_torque_agree_with_the_law_of_the_plane_disc_with_holes():
    """The stage winds up as by Johnson's contacts on elastic bodies, which use no mesh: without
    holes, and with output pins in six holes and a rigid ring.
    """
    crank, rigid = np.zeros(1), Flanks(0.01, equivalent_modulus(210e9, 0.3, math.inf, 0.0))
    elastic = Flanks(0.01, equivalent_modulus(210e9, 0.3, 210e9, 0.3))
    holed = replace(PLANET, holes=Holes(6, 0.033, 0.006))
    for drive, found in (
        (Drive(STAGE, elastic, disc_body=PLANET, ring_body=RING), solved()),
        (
            Drive(STAGE, rigid, disc_body=holed),
            loaded_stage(STAGE, holed, None, 0.01, TORQUES[1:], intervals=4),
        ),
    ):
        expected = loaded_disc(drive, 100.0, crank, nominal_gaps(drive, crank)).rotation.item()
        assert found.rotation[-1] == pytest.approx(expected, rel=0.01)
