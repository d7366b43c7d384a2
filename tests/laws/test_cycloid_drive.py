"""The cycloidal stage as springs in series, against closed forms and statics."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from lostmotion.laws.contact import equivalent_modulus
from lostmotion.laws.cycloid.bodies import ElasticBody
from lostmotion.laws.cycloid.contact import Flanks, output_pin_stiffness
from lostmotion.laws.cycloid.drive import (
    Drive,
    EccentricSprings,
    OutputPinSprings,
    crank_angles_of_pitch,
    crank_force_per_torque,
    loaded_disc,
    nominal_gaps,
    play_per_crank_clearance,
)
from lostmotion.laws.cycloid.geometry import normals, pin_angles
from lostmotion.laws.cycloid.stage import Modification, Stage
from lostmotion.laws.cycloid.wind_up import wind_up_by_member
from lostmotion.laws.perforated_disc_series import Holes
from lostmotion.laws.rolling.radial import roller_stiffness
from tests.laws.closed_forms import mesh_stiffness

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "compliance of a cycloidal stage by member",
        (
            "closed forms; statics of a disc on crankshafts by a 3 x 3 stiffness matrix; "
            "every member that can be named softened, bounded ones "
            "too; other units"
        ),
        (
            "2e-6; 2 %, the mesh's response to the shift; always more compliant; 1e-7, holed "
            "discs 5e-4"
        ),
        (
            "laws/cycloid/drive.py laws/cycloid/wind_up.py "
            "tests/parts/test_cycloidal.py "
            "tests/parts/test_cycloidal_softening.py"
        ),
    ),
)

STEEL = equivalent_modulus(210e9, 0.3, 210e9, 0.3)
STAGE = Stage(0.064, 0.003, 0.0013, 40)
LEVER = STAGE.planet_pitch_radius
SPRINGS = Drive(STAGE, Flanks(0.0125, STEEL, "linear", stiffness=4e8), discs=2)


def test_equal_springs_have_the_closed_forms():
    """Mesh n_d k (e z)^2 N/4, eccentric k (e z)^2 with k of all bearings, output pins k_w Rw^2
    n_w/4: each by itself, to the ripple of N = 40.
    """
    drive = replace(
        SPRINGS,
        eccentric=EccentricSprings(bearing=3e8, shaft=6e8),
        output=OutputPinSprings(8, 0.04, 2e8),
    )
    found = wind_up_by_member(drive, np.array([50.0, 400.0]))
    torque = np.array([50.0, 400.0])
    np.testing.assert_allclose(
        found["lobe contacts"], torque / mesh_stiffness(STAGE, 4e8, discs=2), rtol=2e-6
    )
    np.testing.assert_allclose(
        found["output pins"], torque / (2 * output_pin_stiffness(2e8, 0.04, 8))
    )
    np.testing.assert_allclose(found["eccentric bearing"], 2 * found["eccentric shaft"])
    alone = wind_up_by_member(replace(drive, output=None), torque)
    # K = k (e z)^2 includes only the force across the line of centres; the lobes also push slightly
    # along it.
    np.testing.assert_allclose(alone["eccentric bearing"], torque / (2 * 3e8 * LEVER**2), rtol=0.04)
    assert (alone["eccentric bearing"] > torque / (2 * 3e8 * LEVER**2)).all()
    assert not found["disc body"].any()
    assert not found["ring pins"].any()


@pytest.mark.parametrize("cranks", [2, 3, 5])
def test_crankshafts_support_a_disc_as_a_stiffness_matrix_does(cranks):
    """A disc on n springs around a circle, under the force of the mesh, moves as its 3 x 3
    stiffness matrix states.
    """
    circle, spring, torque = 0.036, 3e8, 300.0
    drive = replace(
        SPRINGS, eccentric=EccentricSprings(bearing=spring, cranks=cranks, circle=circle)
    )
    places = circle * np.exp(2j * math.pi * np.arange(cranks) / cranks + 0.3j)
    matrix = np.zeros((3, 3))
    for place in places:
        across = np.array([[1, 0, -place.imag], [0, 1, place.real]])
        matrix += spring * across.T @ across
    each, turned = torque / 2, []
    for crank in crank_angles_of_pitch(drive):
        mesh = _mesh_force(drive, each, crank)
        shift = np.linalg.solve(matrix, np.array([*mesh, each]))
        turned.append((mesh @ shift[:2]) / each + shift[2])
    found = wind_up_by_member(drive, np.array([torque]))
    # A disc on an elastic bearing loads other lobes than one on a rigid bearing; the difference is
    # part of the bearing's wind-up.
    assert 1.0 < found["eccentric bearing"][0] / np.mean(turned) < 1.02


def _mesh_force(drive: Drive, torque: float, crank: float) -> np.ndarray:
    """Return the sum of the lobes' forces on one disc (2,), along and across the line of
    centres.
    """
    at = np.array([crank])
    answer = loaded_disc(drive, torque, at, nominal_gaps(drive, at))
    return answer.forces[0, 0, 0] @ normals(drive.stage, pin_angles(drive.stage, at)[0])


def test_each_crank_carries_its_part_of_force_and_torque():
    """The force on each crankshaft is the mean over a turn of |T/(n e z) y + T/(n Rc) t|, as a sum
    of vectors.
    """
    drive = replace(SPRINGS, eccentric=EccentricSprings(bearing=3e8, cranks=3, circle=0.036))
    at = np.linspace(0, 2 * math.pi, 10_001)[:-1]
    force = np.array([[0.0], [1 / LEVER]]) + np.array([-np.sin(at), np.cos(at)]) / 0.036
    assert crank_force_per_torque(drive) == pytest.approx(np.hypot(*force).mean() / 3, rel=1e-6)
    assert crank_force_per_torque(SPRINGS) == pytest.approx(1 / LEVER)
    assert play_per_crank_clearance(SPRINGS) == pytest.approx(1 / LEVER)


def test_a_rolling_bearing_has_the_secant_stiffness_of_its_load():
    """Rollers stiffen with load: the eccentric's wind-up per torque decreases, and is the
    displacement of the bearing over e z.
    """
    rollers = EccentricSprings(elements=16, element_stiffness=roller_stiffness(0.0105))
    drive = replace(SPRINGS, eccentric=rollers)
    torque = np.array([10.0, 100.0, 1000.0])
    shares = wind_up_by_member(drive, torque)["eccentric bearing"]
    assert (np.diff(shares / torque) < 0).all()
    for each, share in zip(torque / 2, shares, strict=True):
        force = float(np.hypot(*_mesh_force(drive, each, 0.0)))
        # mostly across, a little along the line of centres
        assert force == pytest.approx(each / LEVER, rel=0.05)
        assert 1.0 < share / (force**2 / rollers.bearing_stiffness(force) / each) < 1.03
    assert EccentricSprings().bearing_stiffness(10.0) == math.inf
    assert rollers.bearing_stiffness(0.0) == 0.0


def test_play_is_not_wind_up():
    """The wind-up of a stage with profile relief starts at its first contact: it vanishes with the
    torque.
    """
    drive = replace(SPRINGS, flanks=Flanks(0.0125, STEEL), relief=Modification(roller=20e-6))
    assert wind_up_by_member(drive, np.array([1e-3]))["lobe contacts"][0] < 1e-9
    assert nominal_gaps(drive, crank_angles_of_pitch(drive)) == pytest.approx(20e-6)


GIVEN = Drive(
    STAGE,
    Flanks(0.0125, STEEL, bending=1e-9),
    Modification(roller=5e-6),
    2,
    EccentricSprings(elements=14, element_stiffness=roller_stiffness(0.01), shaft=5e8),
    OutputPinSprings(8, 0.04, 2e8),
    ElasticBody("planet", 0.02, 210e9, 0.3),
    ElasticBody("ring", 0.08, 210e9, 0.3),
)


@settings(max_examples=40, deadline=None)
@given(st.floats(1.05, 5.0), st.floats(20.0, 800.0), st.sampled_from(range(8)))
def test_softening_any_member_lowers_the_stiffness(factor, torque, which):
    """A softer spring in any member increases the wind-up of the drive."""
    eccentric, flanks, output = GIVEN.eccentric, GIVEN.flanks, GIVEN.output
    assert output is not None
    assert GIVEN.disc_body is not None
    assert GIVEN.ring_body is not None
    softer = (
        replace(GIVEN, flanks=replace(flanks, modulus=flanks.modulus / factor)),
        replace(GIVEN, flanks=replace(flanks, bending=flanks.bending * factor)),
        replace(GIVEN, disc_body=replace(GIVEN.disc_body, young=GIVEN.disc_body.young / factor)),
        replace(GIVEN, ring_body=replace(GIVEN.ring_body, young=GIVEN.ring_body.young / factor)),
        replace(
            GIVEN,
            eccentric=replace(eccentric, element_stiffness=eccentric.element_stiffness / factor),
        ),
        replace(GIVEN, eccentric=replace(eccentric, shaft=eccentric.shaft / factor)),
        replace(GIVEN, output=replace(output, stiffness=output.stiffness / factor)),
        replace(GIVEN, discs=1),
    )[which]
    before = sum(wind_up_by_member(GIVEN, np.array([torque])).values())
    assert sum(wind_up_by_member(softer, np.array([torque])).values()) > before


@pytest.mark.parametrize(
    "holes",
    [
        None,
        Holes(6, 0.04, 0.009),
        Holes(2, 0.036, 0.0165, bearings=True),
        Holes(3, 0.036, 0.012, bearings=True),
    ],
)
@pytest.mark.parametrize("torque", [-200.0, 50.0])
def test_a_crank_turned_by_a_pitch_of_the_pins_moves_the_loads_by_one_pin(holes, torque):
    """And changes nothing else, with and without holes for output pins or for the bearings of
    cranks.
    """
    assert GIVEN.disc_body is not None
    drive = replace(GIVEN, disc_body=replace(GIVEN.disc_body, edge=0.014, holes=holes))
    crank = np.array([0.0, 0.03, 0.11])
    first, second = (
        loaded_disc(drive, torque, crank + turns * 2 * math.pi / 40, np.full((3, 1, 40), 2e-6))
        for turns in (0, 7)
    )
    np.testing.assert_allclose(second.rotation, first.rotation, rtol=1e-9)
    np.testing.assert_allclose(
        second.forces, np.roll(first.forces, 7, axis=-1), rtol=1e-7, atol=1e-6 * first.forces.max()
    )


@pytest.mark.parametrize(
    "wrong",
    [
        {"bearing": 0.0},
        {"shaft": -1.0},
        {"elements": 2, "element_stiffness": 1e9},
        {"elements": 9},
        {"cranks": 2},
        {"circle": 0.03},
        {"cranks": 0},
    ],
)
def test_impossible_eccentrics_are_refused(wrong):
    """Springs without stiffness, bearings with too few elements and a single crank off the centre
    are refused.
    """
    with pytest.raises(ValueError, match=r"eccentric|bearing"):
        EccentricSprings(**wrong)


@pytest.mark.parametrize("discs", [1, 2, 3, 4])
def test_output_pins_between_several_discs(discs):
    """Output pins are springs in any direction and holes push along the disc's line of centres:
    stiffness by least energy, pin by pin.
    """
    count, circle, spring, turn = 24, 0.04, 2e8, 1e-4
    ways = np.exp(2j * math.pi * np.arange(discs) / discs)
    energy = 0.0
    for place in circle * np.exp(2j * math.pi * (np.arange(count) + 0.3) / count):
        seat = 1j * place * turn * 1e6  # µm, position of the pin without discs
        found = minimize(
            lambda at, seat=seat: abs(complex(*at) - seat) ** 2,
            [0.0, 0.0],
            constraints=[
                {"type": "ineq", "fun": lambda at, way=way: -(complex(*at) * way.conjugate()).real}
                for way in ways
            ],
        )
        energy += spring / 2 * found.fun * 1e-12
    torque = 2 * energy / turn
    drive = replace(SPRINGS, discs=discs, output=OutputPinSprings(count, circle, spring))
    assert wind_up_by_member(drive, np.array([torque]))["output pins"][0] == pytest.approx(
        turn, rel=5e-3
    )
