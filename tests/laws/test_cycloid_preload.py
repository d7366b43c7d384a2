"""Discs that push against each other without torque: their rest angle, and the wind-up from
there.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from lostmotion.laws.contact import equivalent_modulus
from lostmotion.laws.cycloid import simulated
from lostmotion.laws.cycloid.bodies import ElasticBody
from lostmotion.laws.cycloid.contact import Flanks
from lostmotion.laws.cycloid.drive import Drive, EccentricSprings, OutputPinSprings, rest_angle
from lostmotion.laws.cycloid.geometry import arms, normals, pin_angles
from lostmotion.laws.cycloid.preload import ClearanceEffects, preloaded_discs
from lostmotion.laws.cycloid.simulated import simulate
from lostmotion.laws.cycloid.stage import Modification, Stage
from lostmotion.laws.cycloid.tolerances import DimensionScatter
from lostmotion.laws.cycloid.wind_up import wind_up_by_member
from lostmotion.units import Toleranced

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "preloaded discs",
        "minimum of the energy over the displacements of output and discs",
        "0.1 %",
        "laws/cycloid/preload.py",
    ),
)

STEEL = equivalent_modulus(210e9, 0.3, 210e9, 0.3)
# A case computed by two methods: linear contacts of 2e5 N/mm, a bearing of 3e5 N/mm for each disc.
CASE = Drive(
    Stage(0.0775, 0.004, 0.0015, 40),
    Flanks(0.02, 1e11, "linear", stiffness=2e8),
    discs=2,
    eccentric=EccentricSprings(bearing=3e8),
)
DRIVE = Drive(
    Stage(0.064, 0.003, 0.0013, 40),
    Flanks(0.0125, STEEL),
    Modification(),
    2,
    EccentricSprings(bearing=4e8),
)
ELASTIC = replace(
    DRIVE,
    disc_body=ElasticBody("planet", 0.02, 210e9, 0.3),
    ring_body=ElasticBody("ring", 0.08, 210e9, 0.3),
)
CRANK = np.array([0.1])


def interfering(seed):
    """Return the gaps (disc, crank, gearbox, N), m, of a pair whose flanks interfere, and the
    effects of clearances.
    """
    stream = np.random.default_rng(seed)
    gap = np.stack([stream.normal(-2e-6, 4e-6, 40) for _ in range(2)])[:, None, None]
    alone = np.stack(
        [rest_angle(CASE, CRANK + math.pi * disc, gap[disc], 1.0) for disc in range(2)]
    )
    return gap, ClearanceEffects(alone, alone, np.zeros((2, 1, 1)))


def test_a_pair_of_interfering_discs_against_the_minimised_energy():
    """Rest angle and wind-up equal those found by minimisation of the energy, to 0.1 %."""
    rest, turned = preloaded_discs(
        CASE, np.array([1.0, 10.0, 50.0, 200.0, 784.0]), CRANK, *interfering(1)
    )
    np.testing.assert_allclose(rest.ravel(), 7.577235e-6, rtol=1e-3)
    np.testing.assert_allclose(
        (turned - rest[1]).ravel(),
        [5.470e-7, 5.4682e-6, 2.72791e-5, 1.08883e-4, 4.26568e-4],
        rtol=1e-3,
    )


def test_the_order_of_the_discs_changes_nothing():
    """Half a turn of the crank and the discs exchanged are the same pair: the rest angle, and the
    angle under every torque of either sign.
    """
    torque = np.array([-200.0, 50.0, 784.0])
    gap, effects = interfering(4)
    rest, turned = preloaded_discs(CASE, torque, CRANK, gap, effects)
    swapped = replace(effects, low=effects.low[::-1], high=effects.high[::-1])
    other = preloaded_discs(CASE, torque, CRANK + math.pi, gap[::-1], swapped)
    np.testing.assert_allclose(other[0], rest, rtol=1e-9)
    np.testing.assert_allclose(other[1], turned, rtol=1e-9)


def test_a_pair_in_a_mirror_turns_as_far_the_other_way():
    """A pair seen in a mirror turns as far the other way: crank, lobes and torques reversed, and
    forwards exchanged with backwards in the effects of clearances and output pins.
    """
    torque = np.array([-200.0, -3.0, 50.0, 784.0])
    gap, effects = interfering(4)
    effects = replace(effects, shift=np.array([2e-5, 7e-5]).reshape(2, 1, 1))
    rest, turned = preloaded_discs(CASE, torque, CRANK, gap, effects)
    mirrored = np.roll(gap[..., ::-1], 1, axis=-1)  # lobe k stands where lobe -k stood
    other = ClearanceEffects(-effects.high, -effects.low, effects.shift[::-1])
    back, turned_back = preloaded_discs(CASE, -torque, -CRANK, mirrored, other)
    np.testing.assert_allclose(back, -rest[::-1], rtol=1e-9)
    np.testing.assert_allclose(turned_back, -turned, rtol=1e-9)


@pytest.mark.parametrize("relief", [-4e-6, 4e-6])
def test_output_pins_all_displaced_by_one_angle_turn_the_output_by_it(relief, monkeypatch):
    """A flange whose pins all stand off by one angle about its axis turns by that angle, with play
    or preload, without torque or under any; nothing else changes.
    """
    angle, drawn, circle = 2e-5, simulated.sample, 0.04

    def displaced(size, law, name, seed, shape):
        if not name.startswith("output_position"):
            return drawn(size, law, name, seed, shape)
        at = 2 * math.pi * np.arange(shape[1]) / shape[1]
        return np.tile(size * (np.sin(at) if " x " in name else -np.cos(at)), (shape[0], 1))

    drive = replace(
        DRIVE, relief=Modification(roller=relief), output=OutputPinSprings(8, circle, math.inf)
    )
    case = (np.array([-200.0, -20.0, 20.0, 200.0]), np.array([0.1, 1.7]), 10, 1)
    straight = simulate(drive, DimensionScatter(flank_form=3e-6), *case)
    monkeypatch.setattr(simulated, "sample", displaced)
    turned = simulate(
        drive, DimensionScatter(flank_form=3e-6, output_position=angle * circle), *case
    )
    assert (straight.play > 0).all() == (relief > 0)
    np.testing.assert_allclose(turned.rotation, straight.rotation + angle, atol=1e-12)
    for end, before in zip(turned.ends, straight.ends, strict=True):
        np.testing.assert_allclose(end, before + angle, atol=1e-12)


@pytest.mark.parametrize("seed", [2, 3])
@pytest.mark.parametrize("torque", [0.0, 50.0, -200.0])
def test_the_pair_is_at_the_minimum_of_its_energy(seed, torque):
    """The angle of the output equals that of one energy minimisation over the displacements of
    output and discs, a method without disc torques.
    """
    gap, effects = interfering(seed)
    lever, n_x, arm = CASE.stage.planet_pitch_radius, [], []
    for disc in range(2):
        theta = pin_angles(CASE.stage, CRANK + math.pi * disc)[0]
        n_x.append(normals(CASE.stage, theta)[:, 0])
        arm.append(arms(CASE.stage, theta) / lever)

    def energy(unknown):
        # µm and µm at the pitch circle; energies in N mm
        turn, shifts = unknown[0], unknown[1:].reshape(2, 2)
        out = -torque / lever * turn * 1e-3
        for disc, (x, y) in enumerate(shifts):
            approach = np.maximum(
                n_x[disc] * x + arm[disc] * (y + turn) - gap[disc, 0, 0] * 1e6, 0.0
            )
            out += (
                0.5 * 200.0 * float(approach @ approach) * 1e-3
                + 0.5 * 300.0 * (x * x + y * y) * 1e-3
            )
        return out

    best = minimize(energy, np.zeros(5), method="BFGS", options={"gtol": 1e-9, "maxiter": 5000})
    asked = torque or 1.0
    rest, turned = preloaded_discs(CASE, np.array([asked]), CRANK, gap, effects)
    found = float(turned[0, 0, 0]) if torque else float(rest[1, 0, 0])
    assert found == pytest.approx(
        float(best.x[0]) * 1e-6 / lever,
        abs=2e-3 * abs(float(turned[0, 0, 0] - rest[1, 0, 0])) + 2e-9,
    )


def balanced(gap, torque, crank):
    """Return the angle of the output of a pair with linear contacts, by Newton's method on all five
    balances.
    """
    lever = CASE.stage.planet_pitch_radius
    rows, room = [], []
    for disc in range(2):
        theta = pin_angles(CASE.stage, np.array([crank + math.pi * disc]))[0]
        across, arm = normals(CASE.stage, theta)[:, 0], arms(CASE.stage, theta) / lever
        of_disc = np.zeros((40, 5))
        of_disc[:, 0], of_disc[:, 1 + 2 * disc], of_disc[:, 2 + 2 * disc] = arm, across, arm
        rows.append(of_disc)
        room.append(gap[disc, 0, 0])
    matrix, apart = np.concatenate(rows), np.concatenate(room)
    springs, load = (
        np.diag([0.0, 3e8, 3e8, 3e8, 3e8]),
        np.array([torque / lever, 0.0, 0.0, 0.0, 0.0]),
    )
    moved = np.zeros(5)
    for _ in range(100):
        touching = matrix @ moved > apart
        stiff = springs + 2e8 * matrix[touching].T @ matrix[touching]
        found = np.linalg.solve(stiff, load + 2e8 * matrix[touching].T @ apart[touching])
        if np.abs(found - moved).max() < 1e-18:
            break
        moved = found
    return moved[0] / lever


@pytest.mark.parametrize(
    ("relief", "asked", "single", "mean"),
    [
        (-2e-6, 0.1, 1e-9, 1e-9),
        (-2e-6, 2.0, 1e-9, 1e-9),
        (0.0, 0.1, 1.6e-2, 1e-3),
        (0.0, 2.0, 2e-3, 1e-4),
        (0.5e-6, 0.1, 1e-9, 1e-9),
        (0.5e-6, 2.0, 1e-2, 1e-3),
        (1e-6, 0.1, 1.6e-2, 2e-3),
        (1e-6, 2.0, 1.6e-2, 1e-3),
    ],
)
def test_a_small_torque_winds_each_pair_up_as_its_balance_says(
    relief, asked, single, mean, monkeypatch
):
    """Under 0.3 % and 0.01 % of the rated torque, for pairs with preload and pairs that barely
    touch: each sample, and their mean, by all five balances.
    """
    pairs = []
    monkeypatch.setattr(
        simulated,
        "preloaded_discs",
        lambda *given, **more: (pairs.append((given, more)), preloaded_discs(*given, **more))[1],
    )
    simulate(
        replace(CASE, relief=Modification(roller=relief)),
        DimensionScatter(flank_form=3e-6),
        np.array([asked]),
        np.array([0.3, 2.0]),
        12,
        3,
    )
    (drive, torque, crank, gap, effects), more = pairs[0]
    rest, turned = preloaded_discs(drive, torque, crank, gap, effects, **more)
    errors = []
    for pair, angle in enumerate(crank[more["places"]]):
        own = gap[:, pair : pair + 1]
        exact = balanced(own, asked, angle) - balanced(own, 0.0, angle)
        errors.append(float(turned[0, pair, 0] - rest[1, pair, 0]) / exact - 1)
    assert np.abs(errors).max() < single
    assert abs(np.mean(errors)) < mean


@settings(max_examples=25, deadline=None)
@given(
    relief=st.floats(-6e-6, 4e-6),
    form=st.floats(0, 5e-6),
    clearance=st.floats(0, 6e-6),
    seed=st.integers(0, 2**31),
    elastic=st.booleans(),
)
def test_no_gearbox_winds_up_backwards(relief, form, clearance, seed, elastic):
    """For any flanks, bodies, clearance and interference, the output turns in the direction of its
    torque, and further under a larger torque.
    """
    drive = replace(ELASTIC if elastic else DRIVE, relief=Modification(roller=relief))
    scatter = DimensionScatter(
        pin_radius=Toleranced(0.003, 2e-6), flank_form=form, crank_clearance=Toleranced(clearance)
    )
    torque = np.array([-200.0, -20.0, -2.0, 2.0, 20.0, 80.0, 200.0])
    found = simulate(drive, scatter, torque, np.array([0.0, 1.0]), 8, seed)
    ahead, behind = found.ends
    assert (ahead >= behind).all()
    wound = np.concatenate([found.rotation[:3] - behind, found.rotation[3:] - ahead])
    assert (wound[:3] <= 0).all()
    assert (wound[3:] >= 0).all()
    assert (np.diff(wound, axis=0) >= -1e-15).all()


def test_discs_that_just_touch_wind_up_as_those_with_play():
    """At zero interference both methods agree: flanks without gap, rest at zero, the wind-up of a
    stage with play.
    """
    torque = np.array([10.0, 40.0, 160.0])
    crank = np.array([0.2, 1.3])
    plain = simulate(DRIVE, DimensionScatter(), torque, crank, 1, 1)
    none = np.zeros((2, 2, 1))
    rest, turned = preloaded_discs(
        DRIVE, torque, crank, np.zeros((2, 2, 1, 40)), ClearanceEffects(none, none, none)
    )
    np.testing.assert_allclose(rest, 0.0, atol=1e-15)
    np.testing.assert_allclose(turned, plain.rotation, rtol=2e-3)


def test_play_and_wind_up_are_continuous_into_interference():
    """From a gap of 0.02 µm to an interference of 0.02 µm, lost motion at ±20 N m changes by at
    most 2 c/(e z), with c of 40 nm.
    """
    lost, torque, crank = [], np.array([-20.0, 20.0]), np.array([0.4, 2.0])
    for relief in (2e-8, -2e-8):
        found = simulate(
            replace(DRIVE, relief=Modification(roller=relief)),
            DimensionScatter(flank_form=3e-6),
            torque,
            crank,
            40,
            3,
        )
        lost.append((found.rotation[1] - found.rotation[0]).mean(axis=0))
    assert np.abs(lost[0] - lost[1]).max() < 3 * 4e-8 / DRIVE.stage.planet_pitch_radius


def test_every_member_of_an_interfering_drive_winds_up_forwards():
    """With elastic bodies and interference, contacts, bearing, disc and ring each turn the output
    along the torque, and more under more.
    """
    members = wind_up_by_member(
        replace(ELASTIC, relief=Modification(roller=-2e-6)), np.array([20.0, 100.0, 400.0])
    )
    for name in ("lobe contacts", "eccentric bearing", "disc body", "ring body"):
        assert (members[name] > 0).all()
        assert (np.diff(members[name]) > 0).all()


def test_interfering_nominal_flanks_wind_up_less():
    """Without tolerances: contacts loaded from both sides are stiffer, and every member winds up in
    the torque's direction.
    """
    torque = np.array([20.0, 100.0, 400.0])
    tight, free = (
        wind_up_by_member(replace(DRIVE, relief=Modification(roller=each)), torque)
        for each in (-2e-6, 2e-6)
    )
    assert (tight["lobe contacts"] > 0).all()
    assert (tight["eccentric bearing"] > 0).all()
    assert (tight["lobe contacts"] < free["lobe contacts"]).all()
