"""Load sharing against closed forms, an independent root finder in three unknowns, and properties
of every drive.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq, root

from lostmotion.errors import DidNotConvergeError
from lostmotion.laws.contact import equivalent_modulus, peak_pressure
from lostmotion.laws.cycloid.contact import (
    Flanks,
    Supports,
    load_sharing,
    output_pin_stiffness,
)
from lostmotion.laws.cycloid.geometry import arms, contact_radius, gaps, pin_angles, play
from lostmotion.laws.cycloid.stage import Modification, Stage
from tests.laws.closed_forms import (
    approach,
    averaged_error,
    contact_force,
    largest_force,
    mesh_stiffness,
)

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "loaded cycloidal contact",
        "closed forms with equal springs; SciPy in three unknowns",
        "1e-6; 3e-11",
        "laws/cycloid/contact.py laws/cycloid/contact_kernel.py",
    ),
)

STEEL = equivalent_modulus(210e9, 0.3, 210e9, 0.3)
RV_LIKE = Stage(0.0775, 0.004, 0.0015, 40)
SMALL = Stage(0.034, 0.004, 0.0015, 14)
PLANET_PINS = Stage(0.0775, 0.002, 0.0012, 30, "planet pins")
SPRINGS = Flanks(0.015, STEEL, "linear", stiffness=2e8)
HERTZ = Flanks(0.015, STEEL)
ALL_FLANKS = [
    SPRINGS,
    HERTZ,
    Flanks(0.015, STEEL, "palmgren"),
    Flanks(0.015, STEEL, bending=2e-9),
    Flanks(0.015, STEEL, "palmgren", bending=2e-9),
]
HELD = Supports(3e8, 1e6, 0.05)


def push(flanks: Flanks, delta: float, radius: float) -> float:
    """Return the force of one contact, from the laws of contact alone."""
    if delta <= 0:
        return 0.0
    if flanks.law == "linear":
        return delta * flanks.stiffness
    if flanks.bending == 0:
        return float(
            contact_force(
                flanks.law, np.array(delta), flanks.width, np.array(radius), flanks.modulus
            )
        )
    both = lambda f: (  # noqa: E731
        float(approach(flanks.law, np.array(f), flanks.width, np.array(radius), flanks.modulus))
        + flanks.bending * f
        - delta
    )
    return float(brentq(both, 0.0, delta / flanks.bending, xtol=1e-13, rtol=1e-14))


def by_root_finder(
    stage: Stage, flanks: Flanks, torque: float, crank: float, gap: np.ndarray, supports: Supports
) -> np.ndarray:
    """Return displacement x, y and output rotation by SciPy: three unknowns, forces and moments in
    the plane.
    """
    theta = pin_angles(stage, np.array([crank]))[0]
    radius = contact_radius(stage, theta)
    pin = stage.ring_radius * np.stack([np.cos(theta), np.sin(theta)], axis=-1)
    pitch = [stage.planet_pitch_radius if stage.has_planet_pins else stage.ring_pitch_radius, 0.0]
    centre = [0.0 if stage.has_planet_pins else stage.eccentricity, 0.0]
    outward = (pin - pitch) / np.linalg.norm(pin - pitch, axis=-1)[:, None]
    touch = pin + (1 if stage.has_planet_pins else -1) * stage.pin_radius * outward - centre
    length = stage.planet_pitch_radius
    thrust = -4 * abs(torque) / (math.pi * supports.pin_circle)

    def left_over(unknown: np.ndarray) -> np.ndarray:
        x, y, turn = unknown[0] * 1e-6, unknown[1] * 1e-6, unknown[2] * 1e-6 / length
        moved = np.stack([x - turn * touch[:, 1], y + turn * touch[:, 0]], axis=-1)
        pressed = (moved * outward).sum(axis=-1) - gap
        force = (
            np.array([push(flanks, d, r) for d, r in zip(pressed, radius, strict=True)])[:, None]
            * -outward
        )
        moment = (touch[:, 0] * force[:, 1] - touch[:, 1] * force[:, 0]).sum()
        along = thrust - supports.bearing * x + force[:, 0].sum()
        across = -supports.bearing * y + force[:, 1].sum()
        return np.array([along, across, (torque + moment) / length]) / (abs(torque) / length)

    guess = (
        np.array(
            [
                0.0,
                -torque / length / supports.bearing,
                2 * torque / length / supports.bearing + math.copysign(1e-5, torque),
            ]
        )
        * 1e6
    )
    answer = root(left_over, guess, method="hybr", tol=1e-13)
    assert np.abs(left_over(answer.x)).max() < 1e-8
    x, y, turned = answer.x * 1e-6
    return np.array([x, y, turned / length + torque / supports.output])


@pytest.mark.parametrize("stage", [RV_LIKE, SMALL, PLANET_PINS], ids=["rv", "small", "planet pins"])
@pytest.mark.parametrize("flanks", ALL_FLANKS, ids=lambda f: f"{f.law} {f.bending}")
def test_a_root_finder_in_three_unknowns_agrees(stage: Stage, flanks: Flanks):
    """Forces, lever arms and springs in the plane, solved by SciPy's root finder, lead to the same
    rotation and bearing force.
    """
    rng = np.random.default_rng(8)
    torques, cranks = np.array([-40.0, 300.0]), np.array([0.0, 2.1])
    gap = rng.normal(scale=1e-6, size=(1, stage.pins))
    ours = load_sharing(stage, flanks, torques, cranks, gap, HELD).checked()
    for i, torque in enumerate(torques):
        for j, crank in enumerate(cranks):
            expected = by_root_finder(stage, flanks, torque, crank, gap[0], HELD)
            np.testing.assert_allclose(ours.rotation[i, j, 0], expected[2], rtol=1e-6)
            np.testing.assert_allclose(
                ours.bearing_force[i, j, 0], HELD.bearing * np.hypot(*expected[:2]), rtol=1e-6
            )


@pytest.mark.parametrize("stage", [RV_LIKE, SMALL, PLANET_PINS], ids=["rv", "small", "planet pins"])
def test_equal_springs_share_by_their_arms(stage: Stage):
    """Equal linear springs, no gaps, rigid bearing: F_i = T l_i/sum(l^2), and K = k_c sum(l^2), to
    1e-12; half the pins carry.
    """
    crank = np.linspace(0.01, 1, 5)
    ours = load_sharing(stage, SPRINGS, [70.0], crank)
    arm = np.maximum(arms(stage, pin_angles(stage, crank)), 0)
    squares = (arm**2).sum(axis=-1)
    np.testing.assert_allclose(
        ours.forces[0, :, 0], 70 * arm / squares[:, None], rtol=1e-12, atol=1e-9
    )
    np.testing.assert_allclose(ours.stiffness[0, :, 0], 2e8 * squares, rtol=1e-12)
    np.testing.assert_allclose(70 / ours.rotation[0, :, 0], 2e8 * squares, rtol=1e-12)
    assert (np.abs(ours.lobes - stage.pins / 2) <= 1).all()


def test_closed_forms_hold_on_the_average_of_a_turn():
    """Mean stiffness over a turn is k_c (e z)^2 N/4 to 1e-6, and with smooth arms (K1 = 0.2) each
    force F_max l_i/(e z) with F_max = 4 T/(e z N).
    """
    crank = np.linspace(0, 2 * math.pi / 40, 2000, endpoint=False)
    ours = load_sharing(RV_LIKE, SPRINGS, [70.0], crank)
    assert ours.stiffness.mean() == pytest.approx(mesh_stiffness(RV_LIKE, 2e8), rel=1e-6)
    smooth = Stage(0.1, 0.0005, 0.0001, 200)
    ours = load_sharing(smooth, SPRINGS, [70.0], [0.01])
    share = (
        np.maximum(arms(smooth, pin_angles(smooth, np.array([0.01]))[0]), 0)
        / smooth.planet_pitch_radius
    )
    np.testing.assert_allclose(
        ours.forces[0, 0, 0], largest_force(smooth, 70.0) * share, rtol=1e-6, atol=1e-6
    )
    assert ours.stiffness[0, 0, 0] == pytest.approx(mesh_stiffness(smooth, 2e8), rel=1e-6)


def test_springs_in_series_add_their_compliances():
    """A soft eccentric bearing and output pins add 1/[k_r (e z)^2] and 1/K_pins to the mesh; the
    bearing carries T/(e z) across.
    """
    output = output_pin_stiffness(5e7, 0.05, 10)
    bending = replace(SPRINGS, bending=3e-9)
    for supports in (Supports(2e8, output), Supports(2e8), Supports(math.inf, output)):
        for flanks, contact in ((SPRINGS, 2e8), (bending, 1 / (1 / 2e8 + 3e-9))):
            # the mean over many crank angles, because the bearing also deflects slightly along the
            # line of centres
            ours = load_sharing(
                RV_LIKE, flanks, [70.0], np.linspace(0, 0.157, 40, endpoint=False), 0.0, supports
            )
            soft = (
                1 / mesh_stiffness(RV_LIKE, contact)
                + 1 / (supports.bearing * RV_LIKE.planet_pitch_radius**2)
                + 1 / supports.output
            )
            rigid_across = 70.0 * soft
            assert rigid_across <= ours.rotation.mean() * (1 + 1e-3)
            assert ours.rotation.mean() == pytest.approx(rigid_across, rel=0.05)
            assert (ours.bearing_force >= 70 / 0.0585 * (1 - 1e-12)).all()
    assert (mesh_stiffness(RV_LIKE, 1.0, 2), output) == (
        pytest.approx(2 * 0.0585**2 * 10),
        pytest.approx(5e7 * 0.05**2 * 2.5),
    )


@given(
    st.sampled_from([RV_LIKE, SMALL, PLANET_PINS]),
    st.sampled_from(ALL_FLANKS),
    st.floats(-1e3, 1e3).filter(lambda t: abs(t) > 0.1),
    st.floats(-7, 7),
    st.floats(-8, -4.5),
    st.integers(0, 2**32),
    st.sampled_from([math.inf, 1e10, 1e8, 1e6]),
    st.sampled_from([math.inf, 0.05]),
)
# an approach whose power underflows to zero
@example(SMALL, ALL_FLANKS[4], -1.0, 3.440708116756634e-309, -5.0, 120155, math.inf, math.inf)
# the first contact is of a lobe on the line of centres
@example(RV_LIKE, SPRINGS, -0.15603473164999626, 0.0, -5.0, 2361097373, 1e8, math.inf)
@settings(deadline=None, max_examples=300)
def test_every_load_has_an_equilibrium(stage, flanks, torque, crank, spread, seed, bearing, circle):  # noqa: PLR0913, PLR0917 - one drawn drive
    """For any gaps, interference, torque and bearing, contacts only push, and their moments add up
    to the torque, to 1e-9.

    Only where a load is beyond the law of approach may a case not converge, and then it is NaN.
    """
    gap = 10**spread * np.random.default_rng(seed).normal(size=(3, stage.pins))
    gap[1] = np.abs(gap[1])
    gap[2] -= gap[2].min()
    ours = load_sharing(stage, flanks, [torque], [crank], gap, Supports(bearing, math.inf, circle))
    for draw in range(3):
        if not ours.converged[0, 0, draw]:
            assert flanks.law == "johnson"  # the only law with a limited range
            assert np.isnan(ours.forces[0, 0, draw]).all()
            assert math.isnan(ours.rotation[0, 0, draw])
            continue
        force = ours.forces[0, 0, draw]
        assert (force >= 0).all()
        assert (force @ arms(stage, pin_angles(stage, np.array([crank]))[0])) == pytest.approx(
            torque, rel=2e-9
        )
        assert (
            ours.lobes[0, 0, draw]
            == np.count_nonzero(force > 1e-9 * abs(torque) / stage.planet_pitch_radius)
            > 0
        )


@pytest.mark.parametrize("flanks", ALL_FLANKS, ids=lambda f: f"{f.law} {f.bending}")
def test_every_ordinary_drive_converges(flanks: Flanks):
    """20 000 drives with gaps of micrometres over all loads from 0.01 to 1 000 N m all converge, to
    1e-9 of the torque.
    """
    gap = 4e-6 * np.abs(np.random.default_rng(3).normal(size=(250, 40)))
    torque = np.concatenate([-np.geomspace(0.01, 1000, 8), np.geomspace(0.01, 1000, 8)])
    for supports in (Supports(), HELD):
        ours = load_sharing(RV_LIKE, flanks, torque, np.linspace(0, 6, 5), gap, supports)
        assert ours.converged.all()
        assert ours.residual.max() < 1e-9


@pytest.mark.parametrize("flanks", ALL_FLANKS, ids=lambda f: f"{f.law} {f.bending}")
@pytest.mark.parametrize(
    "supports", [Supports(), Supports(3e8), HELD], ids=["rigid", "bearing", "pins"]
)
def test_stiffness_is_the_slope_of_the_wind_up_curve(flanks: Flanks, supports: Supports):
    """The stated stiffness is the slope of torque over rotation, by central differences, at every
    load and in both directions.
    """
    gap = 1e-6 * np.random.default_rng(1).random((4, 40))
    for torque in (-200.0, 5.0, 50.0, 700.0):
        step = 1e-5 * torque
        ours = load_sharing(
            RV_LIKE, flanks, [torque - step, torque, torque + step], [0.3], gap, supports
        )
        np.testing.assert_allclose(
            2 * step / (ours.rotation[2] - ours.rotation[0]), ours.stiffness[1], rtol=1e-4
        )


def test_the_output_never_turns_back_as_the_load_grows():
    """Wind-up grows with the torque for any gaps; a reversed load mirrors the rotation of a
    symmetric drive.
    """
    gap = 3e-6 * np.random.default_rng(2).random((50, 40))
    ours = load_sharing(RV_LIKE, HERTZ, np.linspace(-500, 500, 41), [0.1], gap, HELD)
    assert (np.diff(ours.rotation, axis=0) >= 0).all()
    assert (ours.stiffness[np.arange(41) != 20] > 0).all()
    even = load_sharing(
        RV_LIKE,
        HERTZ,
        [-80.0, 80.0],
        [0.0],
        gaps(RV_LIKE, pin_angles(RV_LIKE, np.array([0.0])), Modification(1e-6)),
        HELD,
    )
    assert even.rotation[0, 0, 0] == pytest.approx(-even.rotation[1, 0, 0], rel=1e-9)


@pytest.mark.parametrize("member", ["width", "modulus", "bending", "bearing", "output"])
def test_any_softer_member_softens_the_drive(member: str):
    """With half the stiffness of any one member, the drive winds up more and is softer."""
    flanks, supports = Flanks(0.015, STEEL, bending=1e-9), Supports(3e8, 1e6, 0.05)
    if member in {"width", "modulus"}:
        softer = replace(flanks, **{member: getattr(flanks, member) / 2}), supports
    elif member == "bending":
        softer = replace(flanks, bending=2e-9), supports
    else:
        softer = flanks, replace(supports, **{member: getattr(supports, member) / 2})
    before, after = (
        load_sharing(RV_LIKE, flanks, [300.0], supports=supports),
        load_sharing(RV_LIKE, softer[0], [300.0], supports=softer[1]),
    )
    assert after.rotation > before.rotation
    assert after.stiffness < before.stiffness


@pytest.mark.parametrize(
    "made",
    [Modification(roller=1e-5), Modification(circle=1e-5), Modification(turn=1e-4)],
    ids=["roller", "circle", "turn"],
)
def test_a_small_load_takes_up_the_play(made: Modification):
    """Between torques of plus and minus a hundredth of a newton metre, a disc on a rigid bearing
    turns by its play and hardly more.
    """
    crank = np.linspace(0, 0.157, 20)
    gap = gaps(RV_LIKE, pin_angles(RV_LIKE, crank), made)[:, None, :]
    ours = load_sharing(RV_LIKE, HERTZ, [-1e-2, 1e-2], crank, gap).checked()
    travel = ours.rotation[1] - ours.rotation[0]
    assert 1 <= travel.min() / play(RV_LIKE, made) < travel.max() / play(RV_LIKE, made) < 1.01


def test_without_load_the_disc_is_free():
    """At zero torque a disc with play carries no load and has no stiffness; with interference all
    round it is held without torque.
    """
    free = load_sharing(RV_LIKE, HERTZ, [0.0], [0.2], 1e-6, HELD).checked()
    assert (
        float(free.rotation[0, 0, 0]),
        float(free.lobes[0, 0, 0]),
        float(free.stiffness[0, 0, 0]),
    ) == (0, 0, 0)
    tight = load_sharing(RV_LIKE, HERTZ, [0.0], [0.2], -1e-6, HELD).checked()
    assert tight.lobes[0, 0, 0] == 40
    assert tight.stiffness[0, 0, 0] > 1e5


def test_pressure_is_hertz_at_each_contact():
    """Every lobe's pressure is that of its force on its own equivalent radius."""
    ours = load_sharing(RV_LIKE, HERTZ, [300.0], [0.2, 0.3])
    radius = contact_radius(RV_LIKE, pin_angles(RV_LIKE, np.array([0.2, 0.3])))
    np.testing.assert_allclose(
        ours.pressures[0, :, 0],
        peak_pressure(ours.forces[0, :, 0] / 0.015, radius, STEEL),
        rtol=1e-12,
    )
    assert 3e8 < ours.pressures.max() < 1.5e9


def test_a_load_beyond_the_law_is_marked_and_refused():
    """A printed drive under an excessive load: the result is marked and NaN, and `checked` states
    which case it was.
    """
    soft = Flanks(0.005, 1e9)
    ours = load_sharing(SMALL, soft, [1.0, 1e5], [0.1])
    assert ours.converged[:, 0, 0].tolist() == [True, False]
    assert np.isnan(ours.rotation[1]).all()
    assert np.isnan(ours.pressures[1]).all()
    assert np.isfinite(ours.rotation[0]).all()
    with pytest.raises(DidNotConvergeError, match=r"1 of 2 .* \(1, 0, 0\)"):
        ours.checked()


def test_a_batch_equals_its_single_cases():
    """Torque x crank x draw in one call, on one thread or three, equals single calls bit for
    bit.
    """
    gap = 1e-6 * np.random.default_rng(4).normal(size=(6, 40))
    bearing = np.linspace(1e8, 5e8, 6)
    torque, crank = np.array([-30.0, 200.0]), np.array([0.0, 0.5, 1.0])
    whole = load_sharing(RV_LIKE, HERTZ, torque, crank, gap, Supports(bearing, 1e6))
    threaded = load_sharing(RV_LIKE, HERTZ, torque, crank, gap, Supports(bearing, 1e6), threads=3)
    assert whole.rotation.shape == (2, 3, 6)
    for name in ("rotation", "forces", "bearing_force", "stiffness", "residual"):
        np.testing.assert_array_equal(getattr(whole, name), getattr(threaded, name))
    one = load_sharing(RV_LIKE, HERTZ, [200.0], [0.5], gap[3], Supports(float(bearing[3]), 1e6))
    assert one.rotation[0, 0, 0] == whole.rotation[1, 1, 3]


def test_errors_average_under_load():
    """With equal springs and load on every driving flank, pin errors turn the output by sum(l
    g)/sum(l^2).
    """
    rng = np.random.default_rng(6)
    gap = 1e-6 * rng.standard_normal((30, 40))
    crank = np.linspace(0, 2 * math.pi, 64, endpoint=False)
    torque = np.array([3000.0])
    ours = load_sharing(RV_LIKE, SPRINGS, torque, crank, gap).rotation
    ideal = load_sharing(RV_LIKE, SPRINGS, torque, crank).rotation
    error = ours.mean(axis=1, keepdims=True) - ours
    expected = averaged_error(RV_LIKE, pin_angles(RV_LIKE, crank)[:, None, :], gap[None])
    ripple = np.ptp(ideal)
    assert np.corrcoef((expected.mean(axis=0) - expected).ravel(), error.ravel())[0, 1] > 0.98
    assert error.std() == pytest.approx(expected.std(axis=0).mean(), rel=0.15)
    assert (ours - ideal).std() == pytest.approx(2e-6 / (0.0585 * math.sqrt(40)), rel=0.15)
    assert ripple < 0.02 * ideal.mean()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: Flanks(0.01, STEEL, "hertz"), "'hertz': choose"),
        (lambda: Flanks(0.0, STEEL), "must be positive"),
        (lambda: Flanks(0.01, STEEL, "linear"), "finite contact stiffness"),
        (lambda: Flanks(0.01, STEEL, stiffness=1e8), "no other law"),
        (lambda: load_sharing(SMALL, HERTZ, [math.nan]), "finite numbers"),
        (
            lambda: load_sharing(SMALL, HERTZ, [1.0], [0.0], np.zeros((3, 1, 14))),
            "3 crank angles, but there are 1",
        ),
        (
            lambda: load_sharing(SMALL, HERTZ, [1.0], supports=Supports(bearing=-1.0)),
            "must be positive",
        ),
    ],
)
def test_impossible_values_are_refused(call, words: str):
    """Impossible contacts, gaps and supports are refused with the expected values."""
    with pytest.raises(ValueError, match=words):
        call()
