"""A loaded cycloidal stage against finite elements: contacts by Johnson's law on the elastic bodies of disc and ring, solved together.

Two dimensions, plane strain, frictionless: R 50, Rr 3, e 1.2 mm, N 20 round lobes on a ring 50...60 mm, disc on a rigid hub of 20 mm, width 10 mm,
E 210 GPa, nu 0.3. Three finite-element programs agreed to 0.2 %; rotation in arcmin (good to 0.3 %, the others to 0.5 %), lobe loads in N.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import root

from lostmotion.laws.cycloid.bodies import Body, flexibility
from lostmotion.laws.cycloid.contact import Flanks, LoadSharing, load_sharing
from lostmotion.laws.cycloid.geometry import Stage, arms, contact_radius, pin_angles
from tests.laws.closed_forms import contact_force

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "contacts on elastic discs and rings",
        (
            "finite elements of one stage, of three discs with their exact flank, and of ten stages of random shape; SciPy with every approach "
            "as unknown; 50 000 random cases, a third each solid, with holes for pins and for cranks: none fails, and the equations hold; the "
            "solver for rigid bodies"
        ),
        "0.1 % of the rotation, 0.7 % of the lobe forces (lobe 0: 12 %), 0.4 % of the pressure; 0.1 %; 0.4 %; 1e-8; 1e-7; 1e-8",
        "laws/cycloid/bodies.py laws/cycloid/elastic_kernel.py tests/laws/test_elastic_contact.py",
    ),
)

ARCMIN = math.pi / 10800
STAGE = Stage(0.05, 0.003, 0.0012, 20, "lobe arcs")
HUB, OUTER, WIDTH, YOUNG, NU = 0.02, 0.06, 0.01, 210e9, 0.3
PLANE = YOUNG / (1 - NU**2)
FORCES = np.array([36.6, 553.4, 810.0, 868.2, 839.2, 764.7, 655.9, 516.4, 351.9, 169.9])  # elastic ring, 100 N m, no gaps


def compliance(crank: float, *, ring: bool) -> np.ndarray:
    """Return the displacements (side, crank, N, N) along the contacts under unit forces, of the disc alone or with the ring, m/N."""
    parts = [Body("planet", HUB, YOUNG, NU), Body("ring", OUTER, YOUNG, NU)][: 1 + ring]
    return np.sum([flexibility(STAGE, each, WIDTH, np.array([crank])) for each in parts], axis=0)


def solved(torque: float, crank: float, *, ring: bool, gap: float = 0.0) -> LoadSharing:
    """Return the load sharing on elastic bodies."""
    modulus = PLANE / 2 if ring else PLANE
    return load_sharing(STAGE, Flanks(WIDTH, modulus), [torque], [crank], gap, bodies=compliance(crank, ring=ring)).checked()


# torque, crank angle, whether the ring is elastic, gap, rotation by finite elements
CASES = {
    "rigid ring, 50 N m": (50.0, 0.0, False, 0.0, 0.2040),
    "rigid ring, 100 N m": (100.0, 0.0, False, 0.0, 0.3953),
    "elastic ring, 50 N m": (50.0, 0.0, True, 0.0, 0.3251),
    "elastic ring, 100 N m": (100.0, 0.0, True, 0.0, 0.6247),
    "crank at 9 degrees, 50 N m": (50.0, math.pi / 20, True, 0.0, 0.3249),
    "crank at 9 degrees, 100 N m": (100.0, math.pi / 20, True, 0.0, 0.6244),
    "gaps of 1 um, 100 N m": (100.0, 0.0, True, 1e-6, 0.8147),
}


@pytest.mark.parametrize("case", CASES)
def test_contacts_on_elastic_bodies_turn_as_far_as_finite_elements(case: str):
    """Every case agrees to 0.1 %, within the accuracy of the finite elements."""
    torque, crank, ring, gap, reference = CASES[case]
    over = float(solved(torque, crank, ring=ring, gap=gap).rotation[0, 0, 0]) / ARCMIN / reference - 1
    assert over == pytest.approx(-0.0008 if ring else 0.0005, abs=0.0002)


@pytest.mark.parametrize("case", CASES)
def test_contacts_on_elastic_bodies_by_an_independent_root_finder(case: str):
    """SciPy finds the same rotation and forces; unknown are the approach of each contact, open or closed, and the rotation."""
    torque, crank, ring, gap, _ = CASES[case]
    ours = solved(torque, crank, ring=ring, gap=gap)
    theta = pin_angles(STAGE, np.array([crank]))[0]
    radius, arm, modulus = contact_radius(STAGE, theta), arms(STAGE, theta), PLANE / 2 if ring else PLANE
    bodies = compliance(crank, ring=ring)[0, 0]

    def forces(approach: np.ndarray) -> np.ndarray:
        return np.asarray(contact_force("johnson", approach * 1e-6, WIDTH, radius, modulus))

    def wrong(unknown: np.ndarray) -> np.ndarray:
        pushed = forces(unknown[:-1])
        return np.append(unknown[:-1] + 1e6 * (bodies @ pushed + gap - 1e-4 * unknown[-1] * arm), pushed @ arm / torque - 1)

    start = 1e-6 * torque + gap / STAGE.planet_pitch_radius
    found = root(wrong, np.append((start * arm - gap) * 5e5, start * 1e4), tol=1e-11)
    assert np.abs(found.fun).max() < 1e-8
    assert float(found.x[-1]) * 1e-4 == pytest.approx(float(ours.rotation[0, 0, 0]), rel=1e-8)
    np.testing.assert_allclose(ours.forces[0, 0, 0], forces(found.x[:-1]), rtol=1e-6, atol=1e-5)


def test_contacts_on_elastic_bodies_share_the_load_as_finite_elements_do():
    """Lobes 1 to 9 to 0.7 %; lobe 0, which a rigid disc leaves without load, carries 32 N instead of 36.6 N. Largest pressures to 0.4 %."""
    found = solved(100.0, 0.0, ring=True)
    forces = found.forces[0, 0, 0]
    np.testing.assert_allclose(forces[1:10], FORCES[1:], rtol=0.007)
    assert forces[0] == pytest.approx(32.1, abs=0.2)
    assert (forces[11:] == 0).all()
    assert forces[10] < 1e-6
    assert float(found.pressures.max()) == pytest.approx(1115e6, rel=0.004)
    assert float(solved(50.0, 0.0, ring=True).pressures.max()) == pytest.approx(789e6, rel=0.004)


def test_statics_of_the_whole():
    """Exact for any bodies: sum F l = T; the force across the crank is T/(e z); turning the crank by a pitch shifts the lobes by one."""
    found = solved(100.0, 0.05, ring=True)
    theta = pin_angles(STAGE, np.array([0.05]))[0]
    assert float(found.forces[0, 0, 0] @ arms(STAGE, theta)) == pytest.approx(100.0, rel=1e-10)
    assert float(found.forces[0, 0, 0] @ arms(STAGE, theta)) / STAGE.planet_pitch_radius == pytest.approx(4385.96, rel=1e-5)
    next_one = solved(100.0, 0.05 + math.pi / 10, ring=True)
    np.testing.assert_allclose(next_one.forces[0, 0, 0], np.roll(found.forces[0, 0, 0], 1), rtol=1e-9, atol=1e-9)
    assert float(next_one.rotation[0, 0, 0]) == pytest.approx(float(found.rotation[0, 0, 0]), rel=1e-12)


def test_rotation_depends_on_the_torque_per_width():
    """Twice the torque on twice the width, and both moduli and the torque together, turn the disc as far."""
    modulus = PLANE / 2
    wide = [flexibility(STAGE, each, 2 * WIDTH, np.zeros(1)) for each in (Body("planet", HUB, YOUNG, NU), Body("ring", OUTER, YOUNG, NU))]
    soft = [flexibility(STAGE, each, WIDTH, np.zeros(1)) for each in (Body("planet", HUB, YOUNG / 7, NU), Body("ring", OUTER, YOUNG / 7, NU))]
    once = float(solved(100.0, 0.0, ring=True).rotation[0, 0, 0])
    for torque, flanks, bodies in ((200.0, Flanks(2 * WIDTH, modulus), wide), (100.0 / 7, Flanks(WIDTH, modulus / 7), soft)):
        assert float(load_sharing(STAGE, flanks, [torque], bodies=sum(bodies)).checked().rotation[0, 0, 0]) == pytest.approx(once, rel=1e-10)


# R, Rr, e, hub (mm), N, crank angle, torque (N m) on 10 mm of width, rotation (arcmin): quadratic finite elements on the exact flank for the disc in
# a rigid ring; forces as half-ellipses over a sixteenth or a twelfth of a lobe, Johnson's law for the rest (scikit-fem 12)
DISCS = [
    (34, 3.5, 1.5, 10.5, 14, 0.013, 204.75, 1.73604),
    (34, 3.5, 1.5, 10.5, 14, 0.013, 40.95, 0.370977),
    (50, 3, 1.2, 20, 20, 0.3, 342.0, 1.27597),
    (64, 3, 1.3, 20, 40, 0.013, 1521.0, 2.09923),
]


@pytest.mark.parametrize("case", DISCS)
def test_discs_of_other_stages(case: tuple[float, ...]):
    """The exact flank by the method of fundamental solutions, and by finite elements: rotations to 0.1 %, up to K1 = 0.81."""
    ring, pin, eccentricity, hub, pins, crank, torque, reference = case
    stage = Stage(ring * 1e-3, pin * 1e-3, eccentricity * 1e-3, int(pins))
    disc = flexibility(stage, Body("planet", hub * 1e-3, YOUNG, NU), WIDTH, np.array([crank]))
    found = load_sharing(stage, Flanks(WIDTH, PLANE), [torque], [crank], bodies=disc).checked()
    assert float(found.rotation[0, 0, 0]) / ARCMIN == pytest.approx(reference, rel=1e-3)


# Kind, N, Rr, e, hub, outer radius of the ring (mm), crank angle, torque (N m), rotation (arcmin) of stages with R 50 mm: contacts, disc and ring by
# quadratic finite elements on two meshes, extrapolated (NGSolve 6.2; the meshes differ by 0.15 to 0.5 %). Lobes of plain arcs end at the circle of
# their centres or, where the disc's tips reach farther, on stems.
STAGES = [
    ("ring pins", 13, 7.42685, 2.3063, 10.5866, 61.7582, 0.4484, 179.8917, 1.5283),
    ("ring pins", 13, 5.67045, 2.62085, 13.0167, 65.7628, 0.32384, 204.4264, 1.2885),
    ("ring pins", 18, 4.41912, 1.64392, 22.681, 59.5368, 0.27988, 251.5202, 1.0651),
    ("lobe arcs", 26, 2.4586, 1.50705, 21.1842, 57.9529, 0.02008, 489.7917, 1.1773),
    ("ring pins", 40, 1.63376, 0.70622, 26.3566, 56.4537, 0.14152, 550.85, 1.3209),
    ("lobe arcs", 27, 2.07682, 1.22075, 18.681, 56.2755, 0.02189, 214.2409, 0.7085),
    ("lobe arcs", 13, 3.75676, 2.72416, 17.4076, 55.4903, 0.35486, 106.2423, 0.5447),
    ("lobe arcs", 12, 4.11921, 2.90753, 17.1893, 56.849, 0.30709, 95.9485, 0.5323),
    ("lobe arcs", 13, 4.88681, 1.48158, 29.5276, 63.4838, 0.17825, 115.5631, 1.3158),
    ("lobe arcs", 25, 4.49653, 1.21238, 22.0164, 66.3247, 0.05137, 363.7147, 1.2374),
]


@pytest.mark.parametrize("case", STAGES)
def test_stages_of_random_shape(case: tuple[str, int, float, float, float, float, float, float, float]):
    """Ten stages, with the contacts by finite elements too: rotations to 0.4 %."""
    kind, pins, pin, eccentricity, hub, outer, crank, torque, reference = case
    stage = Stage(0.05, pin * 1e-3, eccentricity * 1e-3, pins, kind)  # type: ignore[arg-type]
    bodies = [Body("planet", hub * 1e-3, YOUNG, NU), Body("ring", outer * 1e-3, YOUNG, NU)]
    soft = np.sum([flexibility(stage, each, WIDTH, np.array([crank])) for each in bodies], axis=0)
    found = load_sharing(stage, Flanks(WIDTH, PLANE / 2), [torque], [crank], bodies=soft).checked()
    assert float(found.rotation[0, 0, 0]) / ARCMIN == pytest.approx(reference, rel=4e-3)
