"""Beams and sections against closed forms, numerical integration of the beam equations and of the
torsion problem.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse
from scipy.integrate import quad, solve_ivp
from scipy.sparse.linalg import spsolve

from lostmotion.laws.beam import prism
from lostmotion.laws.cross_sections import (
    SectionValues,
    box_section,
    compliance_per_length,
    i_section,
    parallel_layers,
    rectangle_section,
    round_section,
)

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "beams",
        "closed forms; an independent integration of the Timoshenko beam",
        "1e-9",
        "laws/beam.py laws/cross_sections.py",
    ),
)

E, G = 70e9, 26.3e9
# Different about y and z, so that an exchange of the two planes is detected.
SECTION = SectionValues(
    area=5.4e-4, i_y=2.2e-7, i_z=0.9e-7, torsion=1.7e-7, shear_y=0.42, shear_z=0.53
)
RIGID_IN_SHEAR = SectionValues(
    area=5.4e-4, i_y=2.2e-7, i_z=0.9e-7, torsion=1.7e-7, shear_y=math.inf, shear_z=math.inf
)
LENGTH = 0.4


def tip_compliance(
    length: float, young: float, shear_modulus: float, section: SectionValues
) -> np.ndarray:
    """Return the compliance matrix (6, 6) of the tip of a cantilever."""
    return prism(length, [compliance_per_length(young, shear_modulus, section)]).compliance_at(
        length
    )[0]


def tip_under_uniform_load(length: float, section: SectionValues) -> np.ndarray:
    """Return the tip's twist per load per length along the axes (6, 3)."""
    beam = prism(length, [compliance_per_length(E, G, section)])
    return beam.tip_under_uniform_load(0.0, length)[0][:, 3:] * length


def test_a_tip_force_bends_by_the_cube_of_the_length():
    """A tip force F without shear moves the tip by F l^3/(3 E I) and turns it by F l^2/(2 E I), in
    the plane of the force.
    """
    c = tip_compliance(LENGTH, E, G, RIGID_IN_SHEAR)
    up = c @ [0, 0, 0, 0, 0, 100.0]
    side = c @ [0, 0, 0, 0, 100.0, 0]
    assert up[5] == pytest.approx(100 * LENGTH**3 / (3 * E * 2.2e-7), rel=1e-12)
    assert up[1] == pytest.approx(-100 * LENGTH**2 / (2 * E * 2.2e-7), rel=1e-12)
    assert side[4] == pytest.approx(100 * LENGTH**3 / (3 * E * 0.9e-7), rel=1e-12)
    assert side[2] == pytest.approx(100 * LENGTH**2 / (2 * E * 0.9e-7), rel=1e-12)


def test_a_tip_moment_bends_by_the_square_of_the_length():
    """A tip moment M moves the tip by M l^2/(2 E I) and turns it by M l/(E I)."""
    c = tip_compliance(LENGTH, E, G, SECTION)
    about_y = c @ [0, 10.0, 0, 0, 0, 0]
    about_z = c @ [0, 0, 10.0, 0, 0, 0]
    assert about_y[5] == pytest.approx(-10 * LENGTH**2 / (2 * E * 2.2e-7), rel=1e-12)
    assert about_y[1] == pytest.approx(10 * LENGTH / (E * 2.2e-7), rel=1e-12)
    assert about_z[4] == pytest.approx(10 * LENGTH**2 / (2 * E * 0.9e-7), rel=1e-12)
    assert about_z[2] == pytest.approx(10 * LENGTH / (E * 0.9e-7), rel=1e-12)


def test_a_torque_twists_and_a_pull_stretches():
    """A torque T twists by T l/(G J), a pull N stretches by N l/(E A), and neither has another
    effect.
    """
    c = tip_compliance(LENGTH, E, G, SECTION)
    np.testing.assert_allclose(
        c @ [10.0, 0, 0, 0, 0, 0], [10 * LENGTH / (G * 1.7e-7), 0, 0, 0, 0, 0], rtol=1e-12
    )
    np.testing.assert_allclose(
        c @ [0, 0, 0, 10.0, 0, 0], [0, 0, 0, 10 * LENGTH / (E * 5.4e-4), 0, 0], rtol=1e-12
    )


def test_a_beam_sags_by_the_fourth_power_under_its_own_weight():
    """A load w spread along the beam moves its tip by w l^4/(8 E I) and turns it by w l^3/(6 E
    I).
    """
    c = tip_under_uniform_load(LENGTH, RIGID_IN_SHEAR)
    down = c @ [0, 0, -30.0]
    side = c @ [0, 30.0, 0]
    assert down[5] == pytest.approx(-30 * LENGTH**4 / (8 * E * 2.2e-7), rel=1e-12)
    assert down[1] == pytest.approx(30 * LENGTH**3 / (6 * E * 2.2e-7), rel=1e-12)
    assert side[4] == pytest.approx(30 * LENGTH**4 / (8 * E * 0.9e-7), rel=1e-12)
    assert side[2] == pytest.approx(30 * LENGTH**3 / (6 * E * 0.9e-7), rel=1e-12)


def test_a_hanging_beam_stretches_under_its_own_weight():
    """A hanging beam lengthens by w l^2/(2 E A), half as much as under its whole weight at the
    tip.
    """
    stretch = (tip_under_uniform_load(LENGTH, SECTION) @ [30.0, 0, 0])[3]
    assert stretch == pytest.approx(30 * LENGTH**2 / (2 * E * 5.4e-4), rel=1e-12)
    assert stretch == pytest.approx(
        (tip_compliance(LENGTH, E, G, SECTION) @ [0, 0, 0, 30.0 * LENGTH, 0, 0])[3] / 2, rel=1e-12
    )


def by_unit_loads(wrench: np.ndarray, spread: np.ndarray, length: float) -> np.ndarray:
    """Return the tip's twist by the unit-load theorem: each component is the integral of inner load
    x inner load of a unit force / stiffness.
    """
    flexibility = np.array(
        [
            1 / (G * 1.7e-7),
            1 / (E * 2.2e-7),
            1 / (E * 0.9e-7),
            1 / (E * 5.4e-4),
            1 / (0.42 * G * 5.4e-4),
            1 / (0.53 * G * 5.4e-4),
        ]
    )

    def inner(tip: np.ndarray, load: np.ndarray, x: float) -> np.ndarray:
        lever = np.array([length - x, 0, 0])
        force = tip[3:] + load * (length - x)
        moment = tip[:3] + np.cross(lever, tip[3:]) + np.cross(lever / 2, load * (length - x))
        return np.concatenate([moment, force])

    out = np.zeros(6)
    for k, unit in enumerate(np.eye(6)):

        def density(x: float, unit: np.ndarray = unit) -> float:
            return float(inner(wrench, spread, x) * flexibility @ inner(unit, np.zeros(3), x))

        out[k] = quad(density, 0, length, epsabs=0, epsrel=1e-12)[0]
    return out


@pytest.mark.parametrize("length", [0.02, 0.4, 1.5])
def test_short_and_long_beams_follow_timoshenko(length: float):
    """Under any tip wrench and distributed load the tip's twist is the unit-load integral of
    bending, shear, torsion and tension.
    """
    rng = np.random.default_rng(4)
    wrench, spread = rng.normal(size=6) * 100, rng.normal(size=3) * 50
    ours = (
        tip_compliance(length, E, G, SECTION) @ wrench
        + tip_under_uniform_load(length, SECTION) @ spread
    )
    np.testing.assert_allclose(ours, by_unit_loads(wrench, spread, length), rtol=1e-9)


def test_integration_of_the_beam_equation_ends_at_the_same_tip():
    """Integrating Timoshenko's equations from the clamp outwards ends at the closed form's tip."""
    force, moment, load = 80.0, -7.0, 40.0

    def slopes(x: float, state: np.ndarray) -> list[float]:
        turn = state[1]  # of the section, positive where the beam rises
        rest = LENGTH - x
        shear = force + load * rest
        bending = force * rest + load * rest**2 / 2 - moment
        return [turn + shear / (0.53 * G * 5.4e-4), bending / (E * 2.2e-7)]

    end = solve_ivp(slopes, (0, LENGTH), [0.0, 0.0], rtol=1e-12, atol=1e-16).y[:, -1]
    ours = tip_compliance(LENGTH, E, G, SECTION) @ [
        0,
        moment,
        0,
        0,
        0,
        force,
    ] + tip_under_uniform_load(LENGTH, SECTION) @ [0, 0, load]
    assert ours[5] == pytest.approx(end[0], rel=1e-9)
    assert -ours[1] == pytest.approx(end[1], rel=1e-9)


SIZES = st.floats(0.005, 0.5)


@given(SIZES, SIZES, st.floats(0.02, 0.48), st.floats(0.01, 3), st.floats(0, 0.49))
@settings(deadline=None, max_examples=100)
def test_every_beam_stores_energy_and_is_reciprocal(
    width: float, height: float, share: float, length: float, nu: float
):
    """Every beam stores energy under every load (positive definite), and its compliance is
    symmetric.
    """
    wall = share * min(width, height)
    for section in (
        round_section(width, width - 2 * wall, nu),
        rectangle_section(width, height, nu),
        box_section(width, height, wall, nu),
    ):
        assert (
            min(
                section.area,
                section.i_y,
                section.i_z,
                section.torsion,
                section.shear_y,
                section.shear_z,
            )
            > 0
        )
        assert max(section.shear_y, section.shear_z) <= 1
        c = tip_compliance(length, E, E / (2 + 2 * nu), section)
        np.testing.assert_array_equal(c, c.T)
        scale = np.sqrt(np.diag(c))
        assert np.linalg.eigvalsh(c / np.outer(scale, scale)).min() > 0


@given(st.floats(0.01, 1), st.floats(0.05, 0.95))
@settings(deadline=None, max_examples=50)
def test_two_beams_in_line_are_one(length: float, share: float):
    """A beam cut in two and joined again deflects as the whole one."""
    near, far = share * length, (1 - share) * length
    # carries a wrench on the tip to the joint; its transpose carries the twist of the joint to the
    # tip
    over = np.eye(6)
    over[1, 5], over[2, 4] = -far, far
    joined = over.T @ tip_compliance(near, E, G, SECTION) @ over + tip_compliance(
        far, E, G, SECTION
    )
    whole = tip_compliance(length, E, G, SECTION)
    np.testing.assert_allclose(joined, whole, rtol=1e-9, atol=0)


def test_a_beam_without_length_does_not_bend():
    """A beam of length zero is rigid."""
    assert not tip_compliance(0.0, E, G, SECTION).any()
    assert not tip_under_uniform_load(0.0, SECTION).any()


def test_round_sections_are_those_of_the_tables():
    """A 60 x 3 mm tube has 537.21 mm^2 and 21.88 cm^4, as in tables of hollow sections, and twice
    that in torsion.
    """
    tube = round_section(0.060, 0.054, 0.3)
    assert tube.area * 1e6 == pytest.approx(537.21, abs=0.01)
    assert tube.i_y * 1e8 == pytest.approx(21.88, abs=0.01)
    assert tube.torsion * 1e8 == pytest.approx(43.76, abs=0.02)
    assert tube.i_y == tube.i_z


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_round_shear_factors_are_cowpers(nu: float):
    """Cowper's special values: a solid round 6(1 + nu)/(7 + 6 nu), a thin tube 2(1 + nu)/(4 + 3
    nu).
    """
    assert round_section(0.05, 0.0, nu).shear_y == pytest.approx(
        6 * (1 + nu) / (7 + 6 * nu), rel=1e-12
    )
    assert round_section(0.05, 0.05 * (1 - 1e-7), nu).shear_z == pytest.approx(
        2 * (1 + nu) / (4 + 3 * nu), rel=1e-6
    )


def test_a_solid_bar_has_the_rectangles_values():
    """A bar 20 wide and 60 high resists nine times better upright, has Cowper's shear factor and
    5/6 at nu = 0.
    """
    bar = rectangle_section(0.02, 0.06, 0.3)
    assert bar.i_y == pytest.approx(0.02 * 0.06**3 / 12)
    assert bar.i_y / bar.i_z == pytest.approx(9)
    assert bar.shear_y == bar.shear_z == pytest.approx(13 / 15.3)
    assert rectangle_section(0.02, 0.06, 0.0).shear_z == pytest.approx(5 / 6)


@pytest.mark.parametrize(
    ("aspect", "factor"),
    [(1, 0.1406), (1.5, 0.196), (2, 0.229), (3, 0.263), (5, 0.291), (10, 0.312)],
)
def test_rectangles_twist_as_saint_venant_found(aspect: float, factor: float):
    """The torsion constant of a rectangle is that of Saint-Venant's series, whose values books
    tabulate.
    """
    n = np.arange(1, 200, 2)
    exact = (
        aspect
        / 3
        * (1 - 192 / (np.pi**5 * aspect) * np.sum(np.tanh(n * np.pi * aspect / 2) / n**5))
    )
    assert exact / aspect == pytest.approx(factor, abs=6e-4)
    assert rectangle_section(0.01 * aspect, 0.01, 0.3).torsion / 0.01**4 == pytest.approx(
        exact, rel=1e-6
    )
    assert rectangle_section(0.01, 0.01 * aspect, 0.3).torsion / 0.01**4 == pytest.approx(
        exact, rel=1e-6
    )


def torsion_by_membrane(width: float, height: float, wall: float, cells: int) -> float:
    """Torsion constant of a rectangular tube from Prandtl's membrane on a quarter of it, finite
    volumes; the hole is a stiff plate in it.
    """
    step = wall / cells
    nx, ny = round(width / 2 / step), round(height / 2 / step)
    x, y = (np.arange(nx) + 0.5) * step, (np.arange(ny) + 0.5) * step
    k = np.where((x[:, None] < width / 2 - wall) & (y[None, :] < height / 2 - wall), 1e7, 1.0)
    kx, ky = (2 * a * b / (a + b) for a, b in ((k[1:], k[:-1]), (k[:, 1:], k[:, :-1])))
    own = np.zeros((nx, ny))
    own[1:] += kx
    own[:-1] += kx
    own[:, 1:] += ky
    own[:, :-1] += ky
    own[-1] += 2
    own[:, -1] += 2
    at = np.arange(nx * ny).reshape(nx, ny)
    rows = np.concatenate([part.ravel() for part in (at[1:], at[:-1], at[:, 1:], at[:, :-1], at)])
    columns = np.concatenate(
        [part.ravel() for part in (at[:-1], at[1:], at[:, :-1], at[:, 1:], at)]
    )
    values = np.concatenate([-kx.ravel(), -kx.ravel(), -ky.ravel(), -ky.ravel(), own.ravel()])
    height_of_membrane = spsolve(
        sparse.csc_matrix((values, (rows, columns))), np.full(nx * ny, 2 * step**2)
    )
    return float(8 * height_of_membrane.sum() * step**2)


def test_the_membrane_method_reproduces_a_solid_bar():
    """The membrane method for a bar with a closed hole yields Saint-Venant's 0.1406 a^4."""
    assert torsion_by_membrane(1.0, 1.0, 0.5, 40) == pytest.approx(0.1406, rel=1e-3)


@pytest.mark.parametrize(
    ("width", "height", "wall", "cells", "stated"),
    [
        (60, 40, 2, 6, 0.005),
        (50, 50, 5, 8, 0.005),
        (40, 80, 8, 10, 0.005),
        (40, 40, 8, 16, 0.005),
        (40, 100, 12, 12, 0.005),
        (40, 40, 16, 32, 0.03),
    ],
)
def test_torsion_of_boxes_is_that_of_the_membrane(
    width: float, height: float, wall: float, cells: int, stated: float
):
    """The torsion constant of a rectangular tube is exact to the membrane method's own error, and
    within 3 % where the hole is narrow.
    """
    ours = box_section(width, height, wall, 0.3).torsion
    assert ours == pytest.approx(torsion_by_membrane(width, height, wall, cells), rel=stated)


def test_torsion_of_a_thin_box_is_bredts():
    """A tube with very thin walls follows Bredt's formula, 4 A^2 t / perimeter."""
    thin = box_section(0.06, 0.04, 1e-6, 0.3).torsion
    assert thin == pytest.approx(4 * (0.06 * 0.04) ** 2 * 1e-6 / 0.2, rel=1e-4)


@pytest.mark.parametrize(("width", "height"), [(0.04, 0.04), (0.02, 0.08), (0.08, 0.02)])
def test_a_box_shears_by_the_energy_in_its_walls(width: float, height: float):
    """Without Poisson's effect Cowper's factor of a thin box is that of the shear-flow energy: I^2
    / (A x integral of S^2/t).
    """
    wall = 1e-6
    section = box_section(width, height, wall, 0.0)
    for across, along, second, factor in (
        (width, height, section.i_y, section.shear_z),
        (height, width, section.i_z, section.shear_y),
    ):
        flange = quad(lambda s, along=along: (wall * s * along / 2) ** 2, 0, across / 2)[0]
        start = wall * across * along / 4
        web = quad(
            lambda s, along=along, start=start: (start + wall * (along**2 / 8 - s**2 / 2)) ** 2,
            0,
            along / 2,
        )[0]
        assert factor == pytest.approx(
            second**2 / (section.area * 4 * (flange + web) / wall), rel=1e-3
        )


def test_a_box_is_an_outer_bar_less_an_inner_one():
    """Area and bending values of a box are those of the outer bar less those of the hole."""
    box, outer, hole = (
        box_section(0.05, 0.06, 0.003, 0.3),
        rectangle_section(0.05, 0.06, 0.3),
        rectangle_section(0.044, 0.054, 0.3),
    )
    assert box.area == pytest.approx(outer.area - hole.area)
    assert box.i_y == pytest.approx(outer.i_y - hole.i_y)
    assert box.i_z == pytest.approx(outer.i_z - hole.i_z)
    assert box.i_y > box.i_z


def test_an_i_section_is_an_outer_bar_less_two_at_its_sides():
    """Area and bending values of an I; its torsion lies below that of its three bars in sum by the
    corners' rounding only.
    """
    section = i_section(0.05, 0.1, 0.005, 0.008, 0.3)
    outer, side = rectangle_section(0.05, 0.1, 0.3), rectangle_section(0.045, 0.084, 0.3)
    assert section.area == pytest.approx(outer.area - side.area)
    assert section.i_y == pytest.approx(outer.i_y - side.i_y)
    assert section.i_z == pytest.approx((2 * 0.008 * 0.05**3 + 0.084 * 0.005**3) / 12)
    bars = (
        2 * rectangle_section(0.05, 0.008, 0.3).torsion
        + rectangle_section(0.005, 0.084, 0.3).torsion
    )
    assert section.torsion == pytest.approx(bars, rel=0.06)
    assert 0 < section.shear_y < 1


@pytest.mark.parametrize(("width", "height"), [(0.05, 0.1), (0.1, 0.05), (0.02, 0.2)])
def test_an_i_section_shears_by_the_energy_in_its_web_and_flanges(width: float, height: float):
    """Without Poisson's effect Cowper's factor of a thin I is that of the shear-flow energy: I^2 /
    (A x integral of S^2/t).
    """
    web, flange = 1e-6, 2e-6
    section = i_section(width, height, web, flange, 0.0)
    outside = quad(lambda s: (flange * s * height / 2) ** 2 / flange, 0, width / 2)[0]
    inside = quad(
        lambda s: (flange * width * height / 2 + web * (height**2 / 8 - s**2 / 2)) ** 2 / web,
        0,
        height / 2,
    )[0]
    assert section.shear_z == pytest.approx(
        section.i_y**2 / (section.area * (4 * outside + 2 * inside)), rel=1e-3
    )


def test_parallel_layers_share_a_load():
    """Two equal layers have half the compliance of one, half of it in each; the parts add up to the
    inverse of the sum of the stiffnesses.
    """
    one, two = (
        compliance_per_length(E, G, SECTION),
        compliance_per_length(2 * E, 0.3 * G, RIGID_IN_SHEAR) + np.diag([0, 0, 0, 0, 1e-9, 1e-9]),
    )
    np.testing.assert_allclose(
        parallel_layers(np.stack([one, one])), [one / 4, one / 4], rtol=1e-12, atol=1e-25
    )
    whole = parallel_layers(np.stack([one, two])).sum(axis=0)
    np.testing.assert_allclose(
        np.linalg.inv(whole), np.linalg.inv(one) + np.linalg.inv(two), rtol=1e-9, atol=1e-3
    )


def test_an_unsymmetrical_section_deflects_in_two_directions():
    """A rotated section deflects as the section about its principal axes: the force resolved along
    them, the deflections added.
    """
    angle = 0.4
    c, s = math.cos(angle), math.sin(angle)
    i_y, i_z = 2.2e-7, 0.9e-7
    skew = SectionValues(
        5.4e-4,
        i_y * c**2 + i_z * s**2,
        i_y * s**2 + i_z * c**2,
        1.7e-7,
        math.inf,
        math.inf,
        i_yz=(i_z - i_y) * s * c,
    )
    moved = tip_compliance(LENGTH, E, G, skew)[3:, 5] * 100
    along_y, along_z = (
        100 * share * LENGTH**3 / (3 * E * second) for share, second in ((s, i_z), (c, i_y))
    )
    np.testing.assert_allclose(
        moved, [0, along_y * c - along_z * s, along_y * s + along_z * c], rtol=1e-9, atol=1e-15
    )
