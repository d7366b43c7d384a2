"""A loaded cycloidal stage against finite elements: contacts by Johnson's law on the elastic bodies
of disc and ring, solved together.

Two dimensions, plane strain, frictionless: R 50, Rr 3, e 1.2 mm, N 20 round lobes on a ring 50...60
mm, disc on a rigid hub of 20 mm, width 10 mm, E 210 GPa, nu 0.3. Three finite-element programs
agreed to 0.2 %; rotation in arcmin (good to 0.3 %, the others to 0.5 %), lobe loads in N.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import root

from lostmotion.laws.contact import equivalent_modulus
from lostmotion.laws.cycloid.bodies import ElasticBody, flexibility
from lostmotion.laws.cycloid.contact import Flanks, LoadSharing, load_sharing
from lostmotion.laws.cycloid.drive import Drive, loaded_disc, nominal_gaps
from lostmotion.laws.cycloid.geometry import arms, contact_radius, pin_angles
from lostmotion.laws.cycloid.stage import Stage
from tests.laws.closed_forms import contact_force

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "contacts on elastic discs and rings",
        (
            "finite elements of one stage, of three discs with their exact flank, and of ten "
            "stages of random shape; SciPy with every approach "
            "as unknown; 25 000 random cases, a third each solid, with holes for pins and for "
            "cranks: none fails, and the equations hold; the "
            "solver for rigid bodies"
        ),
        (
            "0.1 % of the rotation, 0.7 % of the lobe forces (lobe 0: 12 %), 0.4 % of the "
            "pressure; 0.1 %; 0.4 %; 1e-8; 1e-7; 1e-8"
        ),
        "laws/cycloid/bodies.py laws/cycloid/elastic_kernel.py laws/cycloid/elastic_residual_kernel.py tests/laws/test_elastic_contact.py",
    ),
    (
        "contacts of both branches on an elastic disc and envelope ring",
        "finite elements of 21 stages of random shape, of steel, aluminium and polymer",
        "1 % of the rotation, mostly 0.3 %",
        "laws/cycloid/both_branches.py laws/cycloid/flank_contacts.py",
    ),
)

ARCMIN = math.pi / 10800
STAGE = Stage(0.05, 0.003, 0.0012, 20, "lobe arcs")
HUB, OUTER, WIDTH, YOUNG, NU = 0.02, 0.06, 0.01, 210e9, 0.3
PLANE = YOUNG / (1 - NU**2)
# elastic ring, 100 N m, no gaps
FORCES = np.array([36.6, 553.4, 810.0, 868.2, 839.2, 764.7, 655.9, 516.4, 351.9, 169.9])


def compliance(crank: float, *, ring: bool) -> np.ndarray:
    """Return the displacements (side, crank, N, N) along the contacts under unit forces, of the
    disc alone or with the ring, m/N.
    """
    parts = [ElasticBody("planet", HUB, YOUNG, NU), ElasticBody("ring", OUTER, YOUNG, NU)][
        : 1 + ring
    ]
    return np.sum([flexibility(STAGE, each, WIDTH, np.array([crank])) for each in parts], axis=0)


def solved(torque: float, crank: float, *, ring: bool, gap: float = 0.0) -> LoadSharing:
    """Return the load sharing on elastic bodies."""
    modulus = PLANE / 2 if ring else PLANE
    return load_sharing(
        STAGE, Flanks(WIDTH, modulus), [torque], [crank], gap, bodies=compliance(crank, ring=ring)
    ).checked()


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
    over = (
        float(solved(torque, crank, ring=ring, gap=gap).rotation[0, 0, 0]) / ARCMIN / reference - 1
    )
    assert over == pytest.approx(-0.0008 if ring else 0.0005, abs=0.0002)


@pytest.mark.parametrize("case", CASES)
def test_contacts_on_elastic_bodies_by_an_independent_root_finder(case: str):
    """SciPy finds the same rotation and forces; unknown are the approach of each contact, open or
    closed, and the rotation.
    """
    torque, crank, ring, gap, _ = CASES[case]
    ours = solved(torque, crank, ring=ring, gap=gap)
    theta = pin_angles(STAGE, np.array([crank]))[0]
    radius, arm, modulus = (
        contact_radius(STAGE, theta),
        arms(STAGE, theta),
        PLANE / 2 if ring else PLANE,
    )
    bodies = compliance(crank, ring=ring)[0, 0]

    def forces(approach: np.ndarray) -> np.ndarray:
        return np.asarray(contact_force("johnson", approach * 1e-6, WIDTH, radius, modulus))

    def wrong(unknown: np.ndarray) -> np.ndarray:
        pushed = forces(unknown[:-1])
        return np.append(
            unknown[:-1] + 1e6 * (bodies @ pushed + gap - 1e-4 * unknown[-1] * arm),
            pushed @ arm / torque - 1,
        )

    start = 1e-6 * torque + gap / STAGE.planet_pitch_radius
    found = root(wrong, np.append((start * arm - gap) * 5e5, start * 1e4), tol=1e-11)
    assert np.abs(found.fun).max() < 1e-8
    assert float(found.x[-1]) * 1e-4 == pytest.approx(float(ours.rotation[0, 0, 0]), rel=1e-8)
    np.testing.assert_allclose(ours.forces[0, 0, 0], forces(found.x[:-1]), rtol=1e-6, atol=1e-5)


def test_contacts_on_elastic_bodies_share_the_load_as_finite_elements_do():
    """Lobes 1 to 9 to 0.7 %; lobe 0, which a rigid disc leaves without load, carries 32 N instead
    of 36.6 N. Largest pressures to 0.4 %.
    """
    found = solved(100.0, 0.0, ring=True)
    forces = found.forces[0, 0, 0]
    np.testing.assert_allclose(forces[1:10], FORCES[1:], rtol=0.007)
    assert forces[0] == pytest.approx(32.1, abs=0.2)
    assert (forces[11:] == 0).all()
    assert forces[10] < 1e-6
    assert float(found.pressures.max()) == pytest.approx(1115e6, rel=0.004)
    assert float(solved(50.0, 0.0, ring=True).pressures.max()) == pytest.approx(789e6, rel=0.004)


def test_statics_of_the_whole():
    """Exact for any bodies: sum F l = T; the force across the crank is T/(e z); turning the crank
    by a pitch shifts the lobes by one.
    """
    found = solved(100.0, 0.05, ring=True)
    theta = pin_angles(STAGE, np.array([0.05]))[0]
    assert float(found.forces[0, 0, 0] @ arms(STAGE, theta)) == pytest.approx(100.0, rel=1e-10)
    assert float(
        found.forces[0, 0, 0] @ arms(STAGE, theta)
    ) / STAGE.planet_pitch_radius == pytest.approx(4385.96, rel=1e-5)
    next_one = solved(100.0, 0.05 + math.pi / 10, ring=True)
    np.testing.assert_allclose(
        next_one.forces[0, 0, 0], np.roll(found.forces[0, 0, 0], 1), rtol=1e-9, atol=1e-9
    )
    assert float(next_one.rotation[0, 0, 0]) == pytest.approx(
        float(found.rotation[0, 0, 0]), rel=1e-12
    )


def test_rotation_depends_on_the_torque_per_width():
    """Twice the torque on twice the width, and both moduli and the torque together, turn the disc
    as far.
    """
    modulus = PLANE / 2
    wide = [
        flexibility(STAGE, each, 2 * WIDTH, np.zeros(1))
        for each in (ElasticBody("planet", HUB, YOUNG, NU), ElasticBody("ring", OUTER, YOUNG, NU))
    ]
    soft = [
        flexibility(STAGE, each, WIDTH, np.zeros(1))
        for each in (
            ElasticBody("planet", HUB, YOUNG / 7, NU),
            ElasticBody("ring", OUTER, YOUNG / 7, NU),
        )
    ]
    once = float(solved(100.0, 0.0, ring=True).rotation[0, 0, 0])
    for torque, flanks, bodies in (
        (200.0, Flanks(2 * WIDTH, modulus), wide),
        (100.0 / 7, Flanks(WIDTH, modulus / 7), soft),
    ):
        assert float(
            load_sharing(STAGE, flanks, [torque], bodies=sum(bodies)).checked().rotation[0, 0, 0]
        ) == pytest.approx(once, rel=1e-10)


# R, Rr, e, hub (mm), N, crank angle, torque (N m) on 10 mm of width, rotation (arcmin): quadratic
# finite elements on the exact flank for the disc in a rigid ring; forces as half-ellipses over a
# sixteenth or a twelfth of a lobe, Johnson's law for the rest (scikit-fem 12)
DISCS = [
    (34, 3.5, 1.5, 10.5, 14, 0.013, 204.75, 1.73604),
    (34, 3.5, 1.5, 10.5, 14, 0.013, 40.95, 0.370977),
    (50, 3, 1.2, 20, 20, 0.3, 342.0, 1.27597),
    (64, 3, 1.3, 20, 40, 0.013, 1521.0, 2.09923),
]


@pytest.mark.parametrize("case", DISCS)
def test_discs_of_other_stages(case: tuple[float, ...]):
    """The exact flank by the method of fundamental solutions, and by finite elements: rotations to
    0.1 %, up to K1 = 0.81.
    """
    ring, pin, eccentricity, hub, pins, crank, torque, reference = case
    stage = Stage(ring * 1e-3, pin * 1e-3, eccentricity * 1e-3, int(pins))
    disc = flexibility(
        stage, ElasticBody("planet", hub * 1e-3, YOUNG, NU), WIDTH, np.array([crank])
    )
    found = load_sharing(stage, Flanks(WIDTH, PLANE), [torque], [crank], bodies=disc).checked()
    assert float(found.rotation[0, 0, 0]) / ARCMIN == pytest.approx(reference, rel=1e-3)


# Kind, N, Rr, e, hub, outer radius of the ring (mm), crank angle, torque (N m), rotation (arcmin)
# of stages with R 50 mm: contacts, disc and ring by quadratic finite elements on two meshes,
# extrapolated (NGSolve 6.2; the meshes differ by 0.15 to 0.5 %). Lobes of plain arcs end at the
# circle of their centres or, where the disc's tips reach farther, on stems.
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
def test_stages_of_random_shape(
    case: tuple[str, int, float, float, float, float, float, float, float],
):
    """Ten stages, with the contacts by finite elements too: rotations to 0.4 %."""
    kind, pins, pin, eccentricity, hub, outer, crank, torque, reference = case
    stage = Stage(0.05, pin * 1e-3, eccentricity * 1e-3, pins, kind)  # type: ignore[arg-type]
    bodies = [
        ElasticBody("planet", hub * 1e-3, YOUNG, NU),
        ElasticBody("ring", outer * 1e-3, YOUNG, NU),
    ]
    soft = np.sum([flexibility(stage, each, WIDTH, np.array([crank])) for each in bodies], axis=0)
    found = load_sharing(stage, Flanks(WIDTH, PLANE / 2), [torque], [crank], bodies=soft).checked()
    assert float(found.rotation[0, 0, 0]) / ARCMIN == pytest.approx(reference, rel=4e-3)


# Materials of disc and ring, N, R, Rr, e, hub, outer radius of the ring (mm), crank angle, torque
# (N m), rotation (arcmin) of stages with an envelope ring, width 10 mm: both wheels by quadratic
# finite elements on two meshes, extrapolated (benchmarks/envelope_contact.py, NGSolve 6.2; the
# meshes differ by 0.04 to 0.2 %). Walls of 1.5 to 12 times the eccentricity, loads of an eighth of
# the rated one and up.
ENVELOPES = [
    ("steel", "steel", 36, 50.0, 1.6145, 0.711832, 14.6567, 55.6024, 0.159306, 52.2179, 0.23653),
    (
        "aluminium",
        "steel",
        26,
        50.0,
        2.5438,
        1.48303,
        33.4175,
        54.6768,
        0.102301,
        28.0366,
        0.097963,
    ),
    (
        "steel",
        "aluminium",
        36,
        50.0,
        3.29934,
        0.726981,
        15.6937,
        51.9527,
        0.127158,
        9.01751,
        0.053268,
    ),
    (
        "polymer",
        "polymer",
        35,
        50.0,
        3.36433,
        0.714269,
        25.8066,
        49.3673,
        0.0777548,
        3.35222,
        0.68506,
    ),
    (
        "aluminium",
        "aluminium",
        32,
        50.0,
        2.97807,
        1.12034,
        19.6739,
        51.1426,
        0.0752743,
        23.4147,
        0.16816,
    ),
    (
        "polymer",
        "aluminium",
        34,
        50.0,
        3.52568,
        0.718999,
        16.8003,
        51.0451,
        0.0251179,
        2.68333,
        0.7256,
    ),
    (
        "aluminium",
        "aluminium",
        17,
        50.0,
        5.97874,
        1.7639,
        13.2228,
        51.1478,
        0.343066,
        9.979,
        0.16884,
    ),
    ("polymer", "polymer", 39, 50.0, 2.101, 0.92309, 15.0406, 54.2902, 0.0235612, 5.57359, 1.4324),
    ("polymer", "polymer", 22, 50.0, 5.01589, 1.45505, 14.804, 55.9956, 0.280119, 3.51683, 1.2297),
    (
        "aluminium",
        "aluminium",
        31,
        50.0,
        2.08905,
        1.13196,
        31.4422,
        60.0994,
        0.0708952,
        19.3116,
        0.10309,
    ),
    ("steel", "steel", 16, 50.0, 7.60168, 1.80242, 24.9184, 49.2916, 0.383126, 164.02, 0.59792),
    (
        "aluminium",
        "steel",
        27,
        50.0,
        2.08976,
        0.790064,
        31.9308,
        53.5082,
        0.0522913,
        11.2994,
        0.097961,
    ),
    (
        "steel",
        "aluminium",
        32,
        50.0,
        2.70961,
        0.79388,
        34.2276,
        50.5471,
        0.168329,
        6.0433,
        0.025905,
    ),
    (
        "aluminium",
        "aluminium",
        16,
        50.0,
        5.68289,
        2.17623,
        14.6092,
        73.0449,
        0.125958,
        13.5638,
        0.20189,
    ),
    ("steel", "steel", 17, 50.0, 5.57588, 1.87175, 26.0642, 59.072, 0.319007, 98.8211, 0.328),
    (
        "aluminium",
        "steel",
        15,
        50.0,
        5.67573,
        2.11808,
        24.5076,
        60.9853,
        0.00569083,
        25.9132,
        0.21875,
    ),
    ("steel", "steel", 20, 50.0, 3.0, 1.2, 20.0, 60.0, 0.0, 100.0, 0.52735),
    # with a contact at the junction of the branches
    ("polymer", "polymer", 25, 50.0, 4.08319, 1.03798, 29.1663, 54.8945, 0.23006, 6.63893, 1.4863),
    (
        "polymer",
        "polymer",
        14,
        50.0,
        4.56834,
        1.89018,
        19.4028,
        68.871,
        0.354402,
        0.688119,
        0.35685,
    ),
    ("steel", "steel", 20, 50.0, 3.0, 1.2, 20.0, 60.0, math.pi / 20, 100.0, 0.53011),
    ("steel", "steel", 14, 34.0, 3.5, 1.5, 10.5, 44.0, 0.0, 100.0, 1.15510),
]
MATERIALS = {"steel": (210e9, 0.3), "aluminium": (70e9, 0.33), "polymer": (2.4e9, 0.38)}


@pytest.mark.parametrize("case", ENVELOPES)
def test_envelope_stages_of_random_shape(
    case: tuple[str, str, int, float, float, float, float, float, float, float, float],
):
    """Twenty-one stages with contacts of both branches, four of them with one at the junction of
    the branches: rotations to 1 %, mostly 0.3 %.
    """
    disc, ring, pins, radius, pin, eccentricity, hub, outer, crank, torque, reference = case
    stage = Stage(radius * 1e-3, pin * 1e-3, eccentricity * 1e-3, pins, "lobe envelope")
    modulus = equivalent_modulus(*MATERIALS[disc], *MATERIALS[ring])
    bodies = (
        ElasticBody("planet", hub * 1e-3, *MATERIALS[disc]),
        ElasticBody("ring", outer * 1e-3, *MATERIALS[ring]),
    )
    drive = Drive(stage, Flanks(WIDTH, modulus), disc_body=bodies[0], ring_body=bodies[1])
    angle = np.array([crank])
    assert loaded_disc(
        drive, torque, angle, nominal_gaps(drive, angle)
    ).rotation.item() / ARCMIN == pytest.approx(reference, rel=0.01)
