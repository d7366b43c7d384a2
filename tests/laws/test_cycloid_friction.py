"""Friction of a cycloidal stage against work by finite motion, the statics of a disc that rubs, and
closed forms of one contact.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest

from lostmotion.laws.contact import equivalent_modulus
from lostmotion.laws.cycloid.contact import Flanks, load_sharing
from lostmotion.laws.cycloid.friction import DriveFriction, FrictionCoefficients, friction_torques
from lostmotion.laws.cycloid.geometry import pin_angles
from lostmotion.laws.cycloid.stage import Stage
from lostmotion.laws.gears import friction_loop, unloads

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.contact import LoadSharing

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "friction of cycloidal drives",
        (
            "work of sliding by finite motion; statics of a disc with friction at every contact; "
            "wedge and friction circle"
        ),
        "1e-5; 1e-9; 1e-9",
        "laws/cycloid/friction.py laws/gears.py",
    ),
)

PLANET_PINS = Stage(0.0775, 0.002, 0.0012, 30, "planet pins")
RV_LIKE = Stage(0.0775, 0.004, 0.0015, 40)
HERTZ = Flanks(0.015, equivalent_modulus(210e9, 0.3, 210e9, 0.3))
STAGES = [
    Stage(0.028, 0.001474, 0.000236, 40),
    Stage(0.034, 0.003, 0.0012, 16),
    Stage(0.0576, 0.003, 0.0013, 40),
    Stage(0.1, 0.002, 0.001, 40),
]
LEVELS = np.array([0.0, 10.0, 100.0, 250.0])


def along_contacts(stage: Stage, crank: float) -> tuple[np.ndarray, np.ndarray]:
    """Return contacts (N, 2) and unit directions from the pitch point to them (N, 2), from the
    disc's centre.
    """
    theta = pin_angles(stage, np.array([crank]))[0]
    pin = stage.ring_radius * np.stack([np.cos(theta), np.sin(theta)], axis=-1)
    pitch = np.array([stage.eccentricity * stage.pins, 0.0])
    centre = np.array([0.0 if stage.has_planet_pins else stage.eccentricity, 0.0])
    outward = (pin - pitch) / np.linalg.norm(pin - pitch, axis=-1)[:, None]
    return pin + (1 if stage.has_planet_pins else -1) * stage.pin_radius * outward - centre, outward


def turned_by(
    stage: Stage, answer: LoadSharing, crank: float, mu: float, way: int
) -> tuple[float, float]:
    """Return the torque on the disc and that on the crank times the ratio, N m: the disc turns
    ahead of the load, `way` 1, or against it, -1.

    From the forces on the disc alone: each contact pushes along its normal and rubs against the
    disc's rotation about the pitch point. The eccentric takes the force at the disc's centre.
    """
    touch, outward = along_contacts(stage, crank)
    force = answer.forces[0, 0, 0][:, None]
    tangent = np.stack([-outward[:, 1], outward[:, 0]], axis=-1)
    whole = -force * outward - way * mu * force * tangent
    moment = float((touch[:, 0] * whole[:, 1] - touch[:, 1] * whole[:, 0]).sum())
    return -moment, float(whole[:, 1].sum()) * stage.planet_pitch_radius


def flank_share(stage: Stage, answer: LoadSharing, crank: float, mu: float) -> float:
    """Return the friction of the flanks over the moment of the normal forces."""
    torques = friction_torques(stage, [crank], answer, FrictionCoefficients(mu))
    return float(
        (torques.disc + torques.crank)[0, 0, 0] / turned_by(stage, answer, crank, 0.0, 1)[0]
    )


def of_flanks(stage: Stage, answer: LoadSharing, crank: float, mu: float) -> DriveFriction:
    """Return the friction of a drive of which only the flanks rub."""
    torques, moment = (
        friction_torques(stage, [crank], answer, FrictionCoefficients(mu)),
        turned_by(stage, answer, crank, 0.0, 1)[0],
    )
    return DriveFriction(
        LEVELS, *(float(each[0, 0, 0]) / moment * LEVELS for each in (torques.disc, torques.crank))
    )


def of_shares(
    discs: float = 0.0, crank: float = 0.0, pins: float = 0.0, constant: float = 0.0
) -> DriveFriction:
    """Return friction in proportion to the torque."""
    return DriveFriction(LEVELS, discs * LEVELS, crank * LEVELS, pins, constant)


def test_friction_is_the_work_of_sliding():
    """Friction at the output is the sum over flanks of mu, force and sliding distance, the latter
    by finite motion.
    """
    crank, mu, step = 0.4, 0.08, 1e-7
    ours = load_sharing(RV_LIKE, HERTZ, [200.0], [crank])
    theta = pin_angles(RV_LIKE, np.array([crank]))[0]
    pin = RV_LIKE.ring_radius * np.exp(1j * (theta + crank))
    pitch = RV_LIKE.ring_pitch_radius * np.exp(1j * crank)
    touch = pin - RV_LIKE.pin_radius * (pin - pitch) / np.abs(pin - pitch)
    e, z = RV_LIKE.eccentricity, RV_LIKE.lobes
    fixed_in_disc = (touch - e * np.exp(1j * crank)) * np.exp(1j * crank / z)
    moved = e * np.exp(1j * (crank + step)) + fixed_in_disc * np.exp(-1j * (crank + step) / z)
    work = mu * (ours.forces[0, 0, 0] * np.abs(moved - touch)).sum() / (step / z)
    found = friction_torques(
        RV_LIKE, [crank], ours, FrictionCoefficients(mu, 0.002, 0.02, 0.1, 0.05)
    )
    whole = (found.disc + found.crank)[0, 0, 0]
    assert whole == pytest.approx(work + 0.002 * 0.02 * 40 * ours.bearing_force[0, 0, 0], rel=1e-5)
    assert found.pins[0, 0, 0] == pytest.approx(
        0.1 * 0.0015 * 40 * 4 * 200 / (math.pi * 0.05), rel=1e-9
    )


@pytest.mark.parametrize("turns", [0.0, -40.0 + 1.0])
def test_output_pins_slide_less_where_the_crank_is_held(turns):
    """Pins in holes larger by the eccentricity, moved by a small turn of the output: the material
    points that touch part by e per radian on a crank at rest, and by N times that on one that turns.
    """
    circle, pin, step = 0.05, 0.006, 1e-7
    e = RV_LIKE.eccentricity
    centre = e * np.exp(0.3j)
    pins = circle * np.exp(2j * np.pi * np.arange(9) / 9)
    touch = pins - pin * centre / e
    assert np.allclose(np.abs(touch - (pins + centre)), pin + e)  # on the holes as well
    on_carrier = touch * np.exp(1j * step)
    on_disc = centre * np.exp(1j * turns * step) + (touch - centre) * np.exp(1j * step)
    slide = np.abs(on_carrier - on_disc) / step
    ours = load_sharing(RV_LIKE, HERTZ, [200.0], [0.4])
    rubs = friction_torques(
        RV_LIKE, [0.4], ours, FrictionCoefficients(0.0, output=0.1, pin_circle=circle)
    )
    # many pins that carry F |sin| each: the sum of F over the torque is 4/(pi circle)
    expected = 0.1 * slide * 4 / math.pi * 200 / circle
    found = rubs.pins if turns else rubs.pins_held
    np.testing.assert_allclose(found[0, 0, 0], expected, rtol=1e-6)


@pytest.mark.parametrize("stage", [*STAGES, PLANET_PINS])
@pytest.mark.parametrize("mu", [0.03, 0.1, 0.2])
def test_efficiency_of_flanks_is_that_of_the_forces_on_the_disc(stage, mu):
    """A disc with friction at every contact, by its forces alone, whichever side drives."""
    crank = 0.3
    answer = load_sharing(stage, HERTZ, [stage.planet_pitch_radius * 1e3], [crank])
    drives = of_flanks(stage, answer, crank, mu)
    disc, crank_torque = turned_by(stage, answer, crank, mu, -1)
    assert float(drives.efficiency(np.array(50.0))) == pytest.approx(
        disc / abs(crank_torque), rel=1e-9
    )
    disc, crank_torque = turned_by(stage, answer, crank, mu, 1)
    assert float(drives.efficiency_driven_back(np.array(50.0))) == pytest.approx(
        abs(crank_torque) / disc, rel=1e-9
    )


@pytest.mark.parametrize("stage", STAGES)
def test_flanks_that_rub_enough_stop_the_input_and_never_the_load(stage):
    """By the forces on the disc alone: at m = 1.8 its torque is against the load when the input
    drives, and the load still turns the crank.
    """
    crank = 0.3
    answer = load_sharing(stage, HERTZ, [stage.planet_pitch_radius * 1e3], [crank])
    mu = 1.8 / flank_share(stage, answer, crank, 1.0)
    assert turned_by(stage, answer, crank, mu, -1)[0] < 0
    back = turned_by(stage, answer, crank, mu, 1)
    assert back[0] * abs(back[1]) > 0
    found = of_flanks(stage, answer, crank, mu)
    assert not found.drives
    assert not found.self_locking
    assert np.isinf(found.driving(np.array(10.0)))
    assert found.efficiency(np.array(10.0)) == 0
    assert float(found.efficiency_driven_back(np.array(10.0))) == pytest.approx(
        abs(back[1]) / back[0]
    )


@pytest.mark.parametrize("share", [0.2, 0.7, 0.99])
def test_one_contact_rubs_as_a_wedge_does(share):
    """Normal force N at the arm l of the crank and friction mu N at the radius R of the disc: T = N
    (l - mu R) forwards, N (l + mu R) backwards.
    """
    arm, radius = 0.01, 0.05
    mu = share * arm / radius
    drives = of_shares(discs=share)
    assert float(drives.efficiency(np.array(30.0))) == pytest.approx(
        (arm - mu * radius) / arm, rel=1e-9
    )
    assert float(drives.efficiency_driven_back(np.array(30.0))) == pytest.approx(
        arm / (arm + mu * radius), rel=1e-9
    )


@pytest.mark.parametrize(("share", "locks"), [(0.98, False), (1.03, True)])
def test_an_eccentric_locks_once_its_friction_circle_reaches_the_eccentricity(share, locks):
    """A force on an eccentric turns it by its lever e about the shaft, less the radius mu r of the
    friction circle: T = F (e - mu r).
    """
    lever, ratio = RV_LIKE.eccentricity, RV_LIKE.lobes
    circle = share * lever
    force = LEVELS / (lever * ratio)
    drive = DriveFriction(LEVELS, circle * force, ratio * circle * force)
    assert drive.self_locking == locks
    assert math.isinf(drive.backdriving_torque) == locks
    # the moment of the bearing on the disc is friction for the load
    load = LEVELS[1:] + circle * force[1:]
    np.testing.assert_allclose(
        drive.driven_back(load), ratio * np.maximum(force[1:] * (lever - circle), 0.0), rtol=1e-9
    )
    # the input moves the load at any friction of the bearing
    np.testing.assert_allclose(
        drive.driving(LEVELS[1:] - circle * force[1:]),
        ratio * force[1:] * (lever + circle),
        rtol=1e-9,
    )


def test_losses_follow_each_other_from_the_load_to_the_input():
    """Pins rub by the load, flanks by the torque on the crank, the bearing by the force on it;
    friction without load acts at the output.
    """
    drives = of_shares(discs=0.2, crank=0.1, pins=0.05, constant=3.0)
    load = np.array([5.0, 80.0, 400.0])
    np.testing.assert_allclose(drives.driving(load), (1.05 * load + 3) / 0.8 * 1.1, rtol=1e-12)
    np.testing.assert_allclose(
        drives.driven_back(load), np.maximum(0.95 * load - 3, 0) / 1.2 * 0.9, rtol=1e-12
    )
    assert drives.backdriving_torque == pytest.approx(3 / 0.95)
    assert drives.driven_back(np.array(3 / 0.95 * (1 - 1e-9))) == 0
    np.testing.assert_allclose(drives.efficiency(load), load / drives.driving(load), rtol=0)


def test_rollers_have_less_friction_than_lobes():
    """Lobes with a friction coefficient of 0.08 have several times the loss of rollers with
    0.005.
    """
    ours = load_sharing(RV_LIKE, HERTZ, [200.0], [0.0])
    bare, rollers = (1 - flank_share(RV_LIKE, ours, 0.0, mu) for mu in (0.08, 0.005))
    assert 0.8 < bare < 0.95 < rollers < 1


def test_output_pins_rub_by_the_load_itself():
    """Friction of a share of the load before the springs takes that share in either direction,
    beside a stick-slip slider behind it.
    """
    load = np.array([-20.0, -3.0, 0.0, 5.0, 30.0])
    levels = np.array([0.0, 10.0, 50.0])
    rising, falling = friction_loop(lambda torque: torque, load, levels, 1.0 + 0.3 * levels, 0.1)
    up, down = load - 0.1 * np.abs(load) - 1.0, load + 0.1 * np.abs(load) + 1.0
    np.testing.assert_allclose(rising, up / np.where(up > 0, 1.3, 0.7), rtol=1e-12)
    np.testing.assert_allclose(falling, down / np.where(down > 0, 0.7, 1.3), rtol=1e-12)


def test_springs_unload_only_against_less_friction_than_their_torque():
    """Friction of a constant and 0.99 of the torque lets a spring turn back, of all of the torque
    not.
    """
    assert unloads(LEVELS, 5.0 + 0.99 * LEVELS)
    assert not unloads(LEVELS, 1.0 * LEVELS)
