"""Shafts on rolling bearings in five degrees of freedom."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from lostmotion.laws.rolling.equilibrium import shaft_equilibrium
from lostmotion.laws.rolling.radial import (
    BALL_EXPONENT,
    ROLLER_EXPONENT,
    ball_stiffness,
    element_angles,
    radial_shift,
    roller_stiffness,
)
from lostmotion.laws.rolling.rows import BallRow, CrossedRow, RollerRow, RowSeat
from tests.laws.closed_forms import element_loads

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "shaft on rolling bearings, five degrees of freedom",
        "SciPy's minimum of the stored energy and the force balance, both independent",
        "1e-3 of the displacement; 1e-8 of the load",
        "laws/rolling/equilibrium.py laws/rolling/equilibrium_kernel.py laws/rolling/rows.py",
    ),
)

UM = 1e-6
GROOVE = BallRow(count=9, ball=12.7e-3, pitch=65e-3)
ANGULAR = BallRow(count=15, ball=9.5e-3, pitch=60e-3, contact_angle=math.radians(25))
ROLLERS = RollerRow(count=16, length=10e-3, roller=10e-3, pitch=60e-3, slices=20)
CROSSED = CrossedRow(count=40, length=6e-3, pitch=80e-3)
PAIR = (
    RowSeat(ANGULAR, 0.02, preload_shift=5 * UM),
    RowSeat(ANGULAR, -0.02, mirrored=True, preload_shift=5 * UM),
)
SHAFTS = [
    pytest.param((RowSeat(GROOVE),), id="deep groove"),
    pytest.param((RowSeat(GROOVE, -0.03), RowSeat(GROOVE, 0.03)), id="two deep grooves"),
    pytest.param(PAIR, id="preloaded angular pair"),
    pytest.param((RowSeat(CROSSED),), id="crossed roller"),
    pytest.param((RowSeat(ROLLERS), RowSeat(GROOVE, 0.05)), id="roller and groove"),
]
FORCE = st.floats(-5000, 5000)
MOMENT = st.floats(-60, 60)
LOAD = st.tuples(FORCE, FORCE, FORCE, MOMENT, MOMENT)


@pytest.mark.parametrize("seats", SHAFTS)
@pytest.mark.parametrize("clearance", [-5 * UM, 0.0, 20 * UM])
def test_every_load_has_an_equilibrium(seats, clearance):
    """Under random loads every shaft reaches equilibrium with less than 1e-9 of the load
    unbalanced; elements only push.
    """
    rng = np.random.default_rng(3)
    load = rng.normal(size=(40, 5)) * [2000, 2000, 1000, 30, 30]
    found = shaft_equilibrium(seats, load, clearance)
    assert found.converged.all()
    assert found.residual.max() < 1e-9
    assert all((loads >= 0).all() for loads in found.loads)


@pytest.mark.parametrize("seats", SHAFTS)
def test_the_lightest_loads_have_an_equilibrium(seats):
    """Loads from a micronewton to a millinewton close the contacts on the far side of a play of 40
    µm.
    """
    rng = np.random.default_rng(4)
    load = (
        rng.normal(size=(300, 5)) * [2000, 2000, 1000, 30, 30] * 10 ** rng.uniform(-9, -6, (300, 1))
    )
    found = shaft_equilibrium(seats, load, 40 * UM)
    assert found.converged.all()
    assert found.residual.max() < 1e-3


@pytest.mark.parametrize("load", [1.0, 300.0, 8900.0])
@pytest.mark.parametrize("clearance", [-5 * UM, 0.0, 20 * UM])
def test_a_radial_load_alone_is_the_one_unknown_case(load, clearance):
    """Balls and rollers under a radial load have the shift and the element loads of the law with
    one unknown.
    """
    found = shaft_equilibrium((RowSeat(GROOVE),), np.array([[load, 0, 0, 0, 0]]), clearance)
    k, angles = ball_stiffness(12.7e-3, 65e-3), element_angles(9)
    alone = radial_shift(load, clearance, k, BALL_EXPONENT, angles)
    np.testing.assert_allclose(found.displacement[0], [alone, 0, 0, 0, 0], rtol=1e-8, atol=1e-15)
    np.testing.assert_allclose(
        found.loads[0][0],
        element_loads(alone, clearance, k, BALL_EXPONENT, angles),
        rtol=1e-7,
        atol=1e-6,
    )
    plain = RollerRow(count=16, length=10e-3, roller=10e-3, pitch=60e-3, crowned=False)
    found = shaft_equilibrium((RowSeat(plain),), np.array([[load, 0, 0, 0, 0]]), clearance)
    alone = radial_shift(
        load, clearance, roller_stiffness(10e-3), ROLLER_EXPONENT, element_angles(16)
    )
    assert found.displacement[0, 0] == pytest.approx(float(alone), rel=1e-8)


def stored(seat, displacement, clearance):
    """Return the energy (N m) in one row's contacts and the load (5,) it supports, from points,
    motions and lines of contact as vectors in space.
    """
    row, up = seat.row, np.array([0.0, 0.0, -1.0 if seat.mirrored else 1.0])
    rollers = isinstance(row, RollerRow)
    angles = np.repeat(element_angles(row.count, row.first), row.slices if rollers else 1)
    out = np.column_stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)])
    point = row.pitch / 2 * out + np.array([0, 0, seat.at])
    if isinstance(row, BallRow):
        apart, bend = (sum(row.grooves) - 1) * row.ball, row.contact_angle
        point += (row.grooves[0] - 0.5) * row.ball * math.cos(bend) * out
    if rollers:
        along = np.tile((np.arange(row.slices) + 0.5) / row.slices - 0.5, row.count)
        point += row.length * along[:, None] * up
    moved = displacement[:3] + np.cross([*displacement[3:], 0.0], point) + seat.preload_shift * up
    if isinstance(row, BallRow):
        line = (apart * math.cos(bend) - clearance / 2 + (moved * out).sum(axis=1))[
            :, None
        ] * out + apart * math.sin(bend) * up
        line[:, 2] += moved[:, 2]
        if bend:
            line[line @ up < 0, 2] = 0.0
        closed = np.linalg.norm(line, axis=1) - apart
        way = line / np.linalg.norm(line, axis=1)[:, None]
    elif rollers:
        way, closed = (
            out,
            (moved * out).sum(axis=1)
            - clearance / 2
            - 2 * 0.35e-3 * row.roller * np.log(1 / (1 - (2 * along) ** 2)),
        )
    else:
        way = (
            math.cos(row.lean) * out
            + math.sin(row.lean) * (-1.0) ** np.arange(row.count)[:, None] * up
        )
        closed = (moved * way).sum(axis=1) - clearance / 2 * math.cos(row.lean)
    stiffness, power = row.spring
    force = stiffness * np.maximum(closed, 0.0) ** power
    held = force @ np.hstack([way, np.cross(point, way)[:, :2]])
    return float((force * closed).sum() / (power + 1)), held


@pytest.mark.parametrize("seats", SHAFTS)
@pytest.mark.parametrize("clearance", [-5 * UM, 0.0, 20 * UM])
def test_the_equilibrium_minimises_the_energy(seats, clearance):
    """The potential energy, formulated independently in vectors, is smallest at the equilibrium:
    SciPy finds no other minimum.
    """
    rng = np.random.default_rng(11)
    unit = np.array([1e-6, 1e-6, 1e-6, 3e-5, 3e-5])
    for load in rng.normal(size=(4, 5)) * [2000, 2000, 1000, 30, 30]:

        def potential(place, load=load):
            parts = [stored(seat, place * unit, clearance) for seat in seats]
            return (sum(part[0] for part in parts) - load @ (place * unit)) * 1e6, (
                sum(part[1] for part in parts) - load
            ) * unit * 1e6

        found = shaft_equilibrium(seats, load[None], clearance).displacement[0] / unit
        least = minimize(
            potential, np.zeros(5), jac=True, method="BFGS", options={"gtol": 1e-4, "maxiter": 2000}
        )
        assert potential(found)[0] <= least.fun + 1e-9 * abs(least.fun)
        np.testing.assert_allclose(
            sum(stored(seat, found * unit, clearance)[1] for seat in seats),
            load,
            atol=1e-8 * np.linalg.norm(load),
        )
        np.testing.assert_allclose(found, least.x, rtol=1e-3, atol=1e-3 * np.abs(found).max())


def test_loads_add_up_by_statics():
    """Summed about the origin, a deep groove's ball loads along their lines of contact balance the
    load.
    """
    load = np.array([[1500.0, -400.0, 700.0, 8.0, -5.0]])
    found = shaft_equilibrium((RowSeat(GROOVE),), load, 15 * UM)
    angles = element_angles(9)
    apart = 0.04 * 12.7e-3
    radius = 65e-3 / 2 + 0.02 * 12.7e-3
    x, y, z, a, b = found.displacement[0]
    radial = apart - 7.5 * UM + x * np.cos(angles) + y * np.sin(angles)
    axial = z + radius * (a * np.sin(angles) - b * np.cos(angles))
    tilt = np.arctan2(axial, radial)
    q = found.loads[0][0]
    points = radius * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(9)])
    forces = (
        q * np.array([np.cos(tilt) * np.cos(angles), np.cos(tilt) * np.sin(angles), np.sin(tilt)])
    ).T
    np.testing.assert_allclose(forces.sum(axis=0), load[0, :3], rtol=1e-8)
    np.testing.assert_allclose(np.cross(points, forces).sum(axis=0)[:2], load[0, 3:], rtol=1e-7)


@pytest.mark.parametrize("seats", SHAFTS)
def test_stiffness_is_the_slope_of_the_load_and_symmetric(seats):
    """The stiffness equals finite differences of the load, is symmetric and never negative."""
    load = np.array([[1500.0, 500.0, 400.0, 6.0, -4.0]])
    found = shaft_equilibrium(seats, load, 0.0)
    stiffness = found.stiffness[0]
    np.testing.assert_allclose(
        stiffness, stiffness.T, rtol=1e-9, atol=1e-6 * np.abs(stiffness).max()
    )
    assert np.linalg.eigvalsh(stiffness).min() > 0
    scale = np.array([1500.0, 1500.0, 1500.0, 40.0, 40.0]) * 1e-4
    more = shaft_equilibrium(seats, load + np.diag(scale), 0.0).displacement
    less = shaft_equilibrium(seats, load - np.diag(scale), 0.0).displacement
    compliance = ((more - less) / (2 * scale[:, None])).T
    np.testing.assert_allclose(compliance @ stiffness, np.eye(5), atol=0.02)


def test_a_deep_groove_has_an_axial_dead_band_by_its_clearance():
    """Along its axis a deep groove of clearance G and groove centres A apart is free by +-sqrt(A G
    - G^2/4), far more than its radial play.
    """
    apart, clearance = 0.04 * 12.7e-3, 20 * UM
    free = math.sqrt(apart * clearance - clearance**2 / 4)
    found = shaft_equilibrium(
        (RowSeat(GROOVE),), np.array([[0, 0, 1e-3, 0, 0], [0, 0, -1e-3, 0, 0]]), clearance
    )
    np.testing.assert_allclose(found.displacement[:, 2], [free, -free], rtol=1e-3)
    assert free > 4 * clearance


def test_an_axial_load_is_shared_equally():
    """An angular-contact row under a pure axial load puts F/(Z sin a) on every ball, at an angle
    that grows a little beyond 25 degrees.
    """
    found = shaft_equilibrium((RowSeat(ANGULAR),), np.array([[0, 0, 1500.0, 0, 0]]))
    loads = found.loads[0][0]
    np.testing.assert_allclose(loads, loads[0], rtol=1e-9)
    angle = math.degrees(math.asin(1500 / 15 / loads[0]))
    assert 25 < angle < 28


def test_an_angular_row_pulled_off_its_shoulder_is_marked():
    """A single angular-contact row supports no load in the other direction: the result is marked
    and NaN.
    """
    found = shaft_equilibrium(
        (RowSeat(ANGULAR),), np.array([[0, 0, -500.0, 0, 0], [0, 0, 500.0, 0, 0]])
    )
    assert found.converged.tolist() == [False, True]
    assert np.isnan(found.displacement[0]).all()
    assert np.isnan(found.loads[0][0]).all()
    assert np.isfinite(found.displacement[1]).all()


def test_cylindrical_rollers_carry_no_axial_load():
    """An axial load on cylindrical rollers alone has no equilibrium and is marked; a radial load
    leaves the axial position unchanged.
    """
    found = shaft_equilibrium(
        (RowSeat(ROLLERS),), np.array([[500.0, 0, 100.0, 0, 0], [500.0, 0, 0, 0, 0]])
    )
    assert found.converged.tolist() == [False, True]
    assert abs(found.displacement[1, 2]) < 1e-15


def test_crossed_rollers_tilt_by_an_eighth():
    """The tilting stiffness of a preloaded crossed roller bearing is axial stiffness x pitch^2/8 (N
    m/rad); the radial one is half the axial.
    """
    found = shaft_equilibrium((RowSeat(CROSSED),), np.array([[1.0, 0, 0, 0, 0]]), -10 * UM)
    stiffness = found.stiffness[0]
    assert stiffness[3, 3] == pytest.approx(stiffness[2, 2] * 0.08**2 / 8, rel=2e-3)
    assert stiffness[4, 4] == pytest.approx(stiffness[3, 3], rel=2e-3)
    assert stiffness[0, 0] == pytest.approx(stiffness[2, 2] / 2, rel=2e-3)


def test_a_spaced_pair_tilts_in_its_clearance():
    """Two bearings of clearance G at span B let the axis tilt by G/B under the lightest moment: 20
    µm over 60 mm.
    """
    plain = RollerRow(count=20, length=1e-3, roller=5e-3, pitch=40e-3, slices=2, crowned=False)
    found = shaft_equilibrium(
        (RowSeat(plain, -0.03), RowSeat(plain, 0.03)), np.array([[0, 0, 0, 0, 1e-4]]), 20 * UM
    )
    assert found.displacement[0, 4] == pytest.approx(20 * UM / 0.06, rel=1e-2)
    np.testing.assert_allclose(found.displacement[0, :3], 0, atol=1e-9)


def test_preload_stiffens_a_pair():
    """The more two angular rows are preloaded, the stiffer is the pair axially, radially and in
    tilt; without preload it is soft at rest.
    """
    stiff = []
    for preload_shift in (1 * UM, 5 * UM, 15 * UM):
        seats = (
            RowSeat(ANGULAR, 0.02, preload_shift=preload_shift),
            RowSeat(ANGULAR, -0.02, mirrored=True, preload_shift=preload_shift),
        )
        found = shaft_equilibrium(seats, np.array([[1.0, 0, 0, 0, 0]]))
        stiff.append(np.diag(found.stiffness[0]))
    assert (np.diff(stiff, axis=0) > 0).all()


@pytest.mark.parametrize("seats", SHAFTS[1:3])
def test_a_mirrored_load_mirrors_the_shaft(seats):
    """Both shafts are symmetric: rotated by half a turn about x, load and displacement rotate
    together.
    """
    flip = np.array([1, -1, -1, 1, -1])
    load = np.array([[1200.0, 0.0, 300.0, 0.0, 9.0]])
    here, there = shaft_equilibrium(seats, load, 0.0), shaft_equilibrium(seats, load * flip, 0.0)
    np.testing.assert_allclose(there.displacement, here.displacement * flip, rtol=1e-6, atol=1e-12)


@given(LOAD, st.floats(1.1, 3))
@settings(deadline=None, max_examples=25)
def test_more_load_means_more_displacement_and_stiffness(load, more):
    """More load along any direction displaces the shaft further, by less than in proportion: the
    pair stiffens.
    """
    if np.linalg.norm(load) < 1:
        return
    loads = np.array([load, np.array(load) * more])
    found = shaft_equilibrium((RowSeat(CROSSED),), loads, 0.0)
    assert found.converged.all()
    way = np.einsum("ck,ck->c", found.displacement, loads)
    assert way[1] > way[0] * more
    assert way[1] < way[0] * more**2


def test_a_batch_equals_its_single_cases():
    """Many loads with their clearances in one call have the same equilibria as alone."""
    rng = np.random.default_rng(5)
    load, play = rng.normal(size=(200, 5)) * [1000, 1000, 500, 10, 10], rng.uniform(0, 30e-6, 200)
    whole = shaft_equilibrium((RowSeat(GROOVE),), load, play)
    assert whole.converged.all()
    for index in (0, 77, 199):
        alone = shaft_equilibrium((RowSeat(GROOVE),), load[index : index + 1], play[index])
        np.testing.assert_allclose(
            alone.displacement[0], whole.displacement[index], rtol=1e-6, atol=1e-12
        )


def test_no_load_moves_nothing():
    """Without load the shaft stays at the centre, also with preload."""
    found = shaft_equilibrium(PAIR, np.zeros((1, 5)))
    assert found.converged.all()
    np.testing.assert_allclose(found.displacement, 0, atol=1e-15)
    assert found.stiffness[0, 0, 0] > 1e6


@pytest.mark.parametrize("load", [np.zeros(5), np.zeros((2, 6)), np.full((1, 5), np.nan)])
def test_invalid_loads_are_refused(load):
    """A load has five components per case, all finite."""
    with pytest.raises(ValueError, match="shape"):
        shaft_equilibrium((RowSeat(GROOVE),), load)


def test_crossed_rollers_come_in_pairs():
    """An odd number of rollers cannot alternate in inclination."""
    with pytest.raises(ValueError, match="even"):
        CrossedRow(count=41, length=6e-3, pitch=80e-3)
