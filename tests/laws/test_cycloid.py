"""Cycloidal geometry against the motion of the stage: pins in contact, normals through the pitch
point, rotation to first contact.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from lostmotion.laws.cycloid.geometry import (
    arms,
    contact_radius,
    curvature,
    first_contact_angle,
    flank,
    gaps,
    gaps_from_pins,
    normals,
    pin_angles,
    planet_pose,
    play,
    pressure_angles,
    ratio,
    smallest_convex_radius,
    valley_radius,
)
from lostmotion.laws.cycloid.ring import repeat_pitch, ring_pitch, ring_root_radius
from lostmotion.laws.cycloid.stage import Modification, Stage, undercut_limit
from tests.laws.closed_forms import averaged_error

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "cycloidal profile",
        "every pin touches the flank at every crank angle",
        "1e-12 m",
        "laws/cycloid/geometry.py laws/cycloid/stage.py laws/cycloid/ring.py",
    ),
)

LARGE = Stage(0.0775, 0.004, 0.0015, 40)
SMALL = Stage(0.034, 0.004, 0.0015, 14)
PAPER_LIKE = Stage(0.1, 0.002, 0.001, 40, "lobe envelope")
PLANET_PINS = Stage(0.0775, 0.002, 0.0012, 30, "planet pins")
STAGES = [LARGE, SMALL, PAPER_LIKE, PLANET_PINS]


def as_complex(plane: np.ndarray) -> np.ndarray:
    """Return points (..., 2) as x + i y."""
    return plane[..., 0] + 1j * plane[..., 1]


def distances(stage: Stage, places: np.ndarray, made: Modification | None = None) -> np.ndarray:
    """Return the distance of each point (complex) in the toothed wheel's frame from its flank, by a
    fine scan and Newton steps along the normal.
    """
    scan = np.linspace(0, 2 * math.pi, 400 * stage.lobes, endpoint=False)
    curve = as_complex(flank(stage, scan, made)[0])
    out = np.empty(len(places))
    for k, place in enumerate(places):
        t, step = scan[np.argmin(np.abs(curve - place))], scan[1]
        for _ in range(6):
            ends = [
                float(abs(as_complex(flank(stage, np.array(t + d), made)[0]) - place)) ** 2
                for d in (-step, 0.0, step)
            ]
            bend = ends[0] - 2 * ends[1] + ends[2]
            t -= step * (ends[2] - ends[0]) / 2 / bend
            step = max(step / 8, 1e-6)
        out[k] = float(abs(as_complex(flank(stage, np.array(t), made)[0]) - place))
    return out


def pins_in_wheel(stage: Stage, crank: float, extra: float = 0.0) -> np.ndarray:
    """Return the pin centres (N,), complex, in the toothed wheel's frame at a crank angle, with the
    planet rotated by an additional angle `extra`.
    """
    centre, turn = planet_pose(stage, np.array(crank))
    ring = stage.ring_radius * np.exp(2j * math.pi / stage.pins * np.arange(stage.pins))
    if stage.has_planet_pins:
        return as_complex(centre) + ring * np.exp(1j * (float(turn) + extra))
    return (ring - as_complex(centre)) * np.exp(-1j * (float(turn) + extra))


@pytest.mark.parametrize("stage", STAGES, ids=lambda s: f"{s.kind} {s.pins}")
@pytest.mark.parametrize("crank", [0.0, 0.3, 1.7, -2.6, 12.0])
def test_every_pin_touches_the_flank_at_every_crank_angle(stage: Stage, crank: float):
    """At every crank angle all N pins touch the unmodified flank and none interferes with it, to
    1e-12 m.
    """
    np.testing.assert_allclose(
        distances(stage, pins_in_wheel(stage, crank)), stage.pin_radius, rtol=0, atol=1e-12
    )


@pytest.mark.parametrize("stage", STAGES, ids=lambda s: f"{s.kind} {s.pins}")
def test_every_pin_touches_at_its_parameter(stage: Stage):
    """For a whole turn of the crank, a pin's centre lies one pin radius along the normal from the
    flank's point at its own parameter, to 1e-15 m.
    """
    for crank in np.linspace(-3, 9, 41):
        pin = 2 * math.pi / stage.pins * np.arange(stage.pins)
        t = pin - crank / stage.pins if stage.has_planet_pins else pin + crank / stage.lobes
        points, normal = flank(stage, t)
        np.testing.assert_allclose(
            as_complex(points + stage.pin_radius * normal),
            pins_in_wheel(stage, crank),
            rtol=0,
            atol=1e-15,
        )


@pytest.mark.parametrize("stage", STAGES, ids=lambda s: f"{s.kind} {s.pins}")
def test_all_normals_meet_in_the_pitch_point(stage: Stage):
    """Every contact's normal passes through the pitch point, so its moment about the planet's
    centre is force times arm.
    """
    theta = pin_angles(stage, np.linspace(0, 1, 7))
    normal = normals(stage, theta)
    pin = stage.ring_radius * np.stack([np.cos(theta), np.sin(theta)], axis=-1)
    pitch = np.array(
        [stage.planet_pitch_radius if stage.has_planet_pins else stage.ring_pitch_radius, 0.0]
    )
    lever = pin - pitch
    np.testing.assert_allclose(
        lever[..., 0] * normal[..., 1] - lever[..., 1] * normal[..., 0], 0, atol=1e-15
    )
    about = pin - [0.0 if stage.has_planet_pins else stage.eccentricity, 0.0]
    np.testing.assert_allclose(
        about[..., 0] * normal[..., 1] - about[..., 1] * normal[..., 0],
        arms(stage, theta),
        atol=1e-15,
    )
    np.testing.assert_allclose(np.linalg.norm(normal, axis=-1), 1, rtol=1e-14)
    slant = np.abs(arms(stage, theta)) / np.linalg.norm(about, axis=-1)
    np.testing.assert_allclose(np.cos(pressure_angles(stage, theta)), slant, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("stage", STAGES, ids=lambda s: f"{s.kind} {s.pins}")
def test_the_curvature_of_the_flank_is_the_closed_form(stage: Stage):
    """The curvature of the flank from differences of its normal agrees with the closed form,
    including the offset by the pin radius.
    """
    t = np.linspace(0.01, 2 * math.pi / stage.lobes, 50)
    h = 1e-6
    ahead, behind = flank(stage, t + h), flank(stage, t - h)
    turning = np.angle(as_complex(ahead[1]) / as_complex(behind[1]))
    step = ahead[0] - behind[0]
    # along the flank, in the direction of rotation of the outward normal
    along = as_complex(step) / (1j * as_complex(flank(stage, t)[1]))
    theta = stage.lobes * t * (1 if stage.has_planet_pins else -1)
    locus = 1 / curvature(stage, theta)
    radius = locus + stage.pin_radius if stage.has_planet_pins else locus - stage.pin_radius
    np.testing.assert_allclose(np.abs(turning / along.real), np.abs(1 / radius), rtol=1e-5)
    both = 1 / stage.pin_radius + (-1 if stage.has_planet_pins else 1) / radius
    np.testing.assert_allclose(contact_radius(stage, theta), 1 / both, rtol=1e-10)


@pytest.mark.parametrize("stage", STAGES, ids=lambda s: f"{s.kind} {s.pins}")
def test_undercut_begins_where_the_flank_turns_back(stage: Stage):
    """Just below the largest pin radius the flank runs forward everywhere; just above it runs back
    somewhere.
    """
    limit = undercut_limit(
        stage.ring_radius, stage.eccentricity, stage.pins, planet_pins=stage.has_planet_pins
    )
    theta = np.linspace(0, math.pi, 20001)
    sign = 1 if stage.has_planet_pins else -1
    assert (1 + sign * 0.9999 * limit * curvature(stage, theta)).min() > 0
    assert (1 + sign * 1.0001 * limit * curvature(stage, theta)).min() < 0
    assert smallest_convex_radius(stage) == pytest.approx(limit - stage.pin_radius)


def test_undercut_limit_is_the_printed_formula():
    """The limit over all stages equals the textbook's two cases."""
    for n, k1 in itertools.product((6, 11, 14, 40, 81), np.linspace(0.05, 0.95, 19)):
        inside = math.sqrt(27 * (1 - k1**2) * (n - 1)) / (n + 1) ** 1.5
        expected = inside if k1 > (n - 2) / (2 * n - 1) else (1 + k1) ** 2 / (n * k1 + 1)
        assert undercut_limit(1.0, k1 / n, n) == pytest.approx(expected, rel=1e-12)


@given(st.floats(0.05, 0.9), st.integers(14, 90), st.floats(-7, 7))
@settings(deadline=None, max_examples=100)
def test_half_the_pins_share_a_quarter_of_the_squares(k1: float, pins: int, crank: float):
    """Over the loaded half the squares of the arms add up to (e z)^2 N/4, whatever K1.

    They ripple with the crank by less than 1 % where K1 is up to 0.6 with 14 pins or more, to 0.8
    with 30, to 0.9 with 40; with 14 pins at
    K1 = 0.9 by 7.3 %.
    """
    stage = Stage(1.0, 1e-4, k1 / pins, pins)
    arm = np.maximum(arms(stage, pin_angles(stage, np.array([crank]))), 0)
    smooth = 0.6 if pins < 30 else 0.8 if pins < 40 else 0.9
    assert (arm**2).sum() == pytest.approx(
        stage.planet_pitch_radius**2 * pins / 4, rel=0.01 if k1 <= smooth else 0.073
    )


def test_the_longest_arm_is_where_the_cosine_is_k1():
    """No arm is longer than e z, and the pin at cos theta = K1 has it."""
    for stage in STAGES:
        assert arms(stage, np.arccos(stage.shortening)) == pytest.approx(
            stage.planet_pitch_radius, rel=1e-12
        )
        assert arms(stage, np.linspace(-4, 4, 999)).max() <= stage.planet_pitch_radius * (1 + 1e-12)


@pytest.mark.parametrize("stage", [LARGE, SMALL, PLANET_PINS], ids=lambda s: f"{s.kind} {s.pins}")
@pytest.mark.parametrize(
    "made",
    [
        Modification(roller=1e-5),
        Modification(circle=1e-5),
        Modification(turn=2e-5),
        Modification(2e-6, 3e-6, 1e-5),
    ],
)
def test_gaps_are_those_of_the_modified_flank(stage: Stage, made: Modification):
    """The stated gap at each pin is the distance from the pin to the modified flank, to second
    order in the material removed.
    """
    crank = 0.4
    measured = distances(stage, pins_in_wheel(stage, crank), made) - stage.pin_radius
    theta = pin_angles(stage, np.array([crank]))[0]
    # a turned flank leaves a step at tip and valley
    clear = np.abs(arms(stage, theta)) > 0.1 * stage.planet_pitch_radius
    np.testing.assert_allclose(
        measured[clear], gaps(stage, theta, made)[clear], rtol=0.01, atol=1.5e-7
    )


def turned_until_jammed(stage: Stage, crank: float, made: Modification, side: int) -> float:
    """Return the rotation (rad) of the planet until a pin touches, by bisection on the smallest
    distance of the pins.
    """
    low, high = 0.0, 2 * play(stage, made)
    for _ in range(16):  # to 3e-5 of the play
        middle = (low + high) / 2
        free = (
            distances(stage, pins_in_wheel(stage, crank, side * middle), made).min()
            >= stage.pin_radius
        )
        low, high = (middle, high) if free else (low, middle)
    return low


@pytest.mark.parametrize(
    "made", [Modification(roller=1e-5), Modification(circle=1e-5)], ids=["roller", "circle"]
)
def test_play_is_the_free_rotation_of_the_disc(made: Modification):
    """The free rotation of the disc between contacts, at two crank angles, is the formula's play or
    up to 3.5 % more.
    """
    for crank in (0.0, math.pi / SMALL.pins):
        free = sum(turned_until_jammed(SMALL, float(crank), made, side) for side in (-1, 1))
        assert 0.999 <= free / play(SMALL, made) <= 1.035


def test_gaps_determine_the_play_between_the_pins():
    """The first contact of the gaps has the same play, at 500 crank angles, and its minimum is the
    formula's.
    """
    for stage, most in ((SMALL, 1.035), (LARGE, 1.005)):
        for made in (Modification(roller=1e-5), Modification(circle=1e-5), Modification(turn=1e-4)):
            theta = pin_angles(stage, np.linspace(0, 2 * math.pi / stage.pins, 500))
            gap = gaps(stage, theta, made)
            free = first_contact_angle(stage, theta, gap) + first_contact_angle(stage, -theta, gap)
            assert free.min() >= play(stage, made) * (1 - 1e-12)
            assert free.max() <= play(stage, made) * most


@pytest.mark.parametrize("stage", [LARGE, PLANET_PINS], ids=["disc", "planet pins"])
def test_a_misplaced_pin_changes_its_gap(stage: Stage):
    """Moving or enlarging a pin by 0.1 µm changes its distance to the flank as the law states."""
    crank, d = 0.7, 1e-7
    theta = pin_angles(stage, np.array([crank]))[0]
    pins = pins_in_wheel(stage, crank)
    centre = (
        0.0
        if stage.has_planet_pins
        else -as_complex(planet_pose(stage, np.array(crank))[0])
        * np.exp(-1j * float(planet_pose(stage, np.array(crank))[1]))
    )
    outward = (
        pins - centre
        if not stage.has_planet_pins
        else pins - as_complex(planet_pose(stage, np.array(crank))[0])
    )
    outward /= np.abs(outward)
    for radial, across in ((d, 0.0), (0.0, d), (d, -d)):
        moved = pins + radial * outward + across * 1j * outward
        expected = gaps_from_pins(stage, theta, np.array(0.0), np.array(radial), np.array(across))
        np.testing.assert_allclose(distances(stage, moved) - stage.pin_radius, expected, atol=1e-10)
    assert gaps_from_pins(stage, theta, np.array(d), np.array(0.0), np.array(0.0)) == pytest.approx(
        -d
    )


def test_errors_of_many_pins_average():
    """With all driving flanks loaded, independent normal errors s of 1 µm scatter the output by 2
    s/(e z sqrt N); without load by much more.
    """
    rng = np.random.default_rng(5)
    gap = 1e-6 * rng.standard_normal((20000, 40))
    theta = pin_angles(LARGE, np.array([0.2]))[0]
    expected = 2e-6 / (LARGE.planet_pitch_radius * math.sqrt(40))
    assert averaged_error(LARGE, theta, gap).std() == pytest.approx(expected, rel=0.02)
    assert first_contact_angle(LARGE, theta, gap).mean() < -3 * expected


def test_ratios_follow_from_the_motion():
    """With the ring fixed the planet turns backwards once per z turns of the crank; relative to the
    planet the ring has its own ratio.
    """
    for stage in STAGES:
        _, turn = planet_pose(stage, np.array(2 * math.pi))
        assert 2 * math.pi / float(turn) == pytest.approx(ratio(stage))
        assert (2 * math.pi - float(turn)) / -float(turn) == pytest.approx(ratio(stage, "carrier"))
    assert (
        ratio(LARGE),
        ratio(LARGE, "carrier"),
        ratio(PLANET_PINS),
        ratio(PLANET_PINS, "carrier"),
    ) == (-39, 40, -30, 31)


@pytest.mark.parametrize(
    "stage",
    [
        PAPER_LIKE,
        Stage(0.05, 0.003, 0.0012, 20, "lobe envelope"),
        Stage(0.034, 0.004, 0.0015, 14, "lobe envelope"),
    ],
)
def test_an_envelope_ring_is_the_boundary_of_the_swept_disc(stage: Stage):
    """The disc swept through a turn of the crank leaves the ring, to the sweep's 0.5 um; the root
    lies at R - Rr + 2 e.
    """
    pitch = as_complex(ring_pitch(stage, 201))
    at = np.angle(pitch)
    assert (np.diff(at) > 0).all()
    t = np.linspace(0, 2 * math.pi, 400 * stage.lobes)
    disc = as_complex(flank(stage, t)[0])
    reach = np.zeros(len(pitch))
    for crank in np.linspace(-math.pi, math.pi, 721):
        swept = as_complex(planet_pose(stage, np.array(crank))[0]) + disc * np.exp(
            1j * float(planet_pose(stage, np.array(crank))[1])
        )
        order = np.argsort(np.angle(swept))
        reach = np.maximum(reach, np.interp(at, np.angle(swept)[order], np.abs(swept)[order]))
    np.testing.assert_allclose(np.abs(pitch), reach, rtol=0, atol=5e-7)
    assert np.abs(pitch[[0, -1]]) == pytest.approx(ring_root_radius(stage), rel=1e-12)
    assert np.abs(pitch).min() == pytest.approx(stage.ring_radius - stage.pin_radius, rel=1e-12)


def test_an_envelope_ring_keeps_the_pins_arc_near_the_crest():
    """On both sides of the crest the ring is exactly the arc of the pin: over 19.35 % of the pitch
    of one stage, 10 to 39 % of a published ring.
    """
    shares = []
    for stage in (Stage(0.05, 0.003, 0.0012, 20, "lobe envelope"), PAPER_LIKE):
        pitch = as_complex(ring_pitch(stage, 4001))
        on_arc = np.abs(np.abs(pitch - stage.ring_radius) - stage.pin_radius) < 1e-15
        assert np.count_nonzero(np.diff(on_arc)) == 2
        shares.append(np.abs(np.angle(pitch[on_arc])).max() * stage.pins / math.pi)
    assert shares[0] == pytest.approx(0.1935, abs=2e-4)
    assert 0.1 < shares[1] < 0.39


def test_a_ring_of_plain_arcs_clears_the_disc():
    """Plain arcs keep the pins' contacts on the crest, and the disc's tips pass the root with the
    specified clearance.
    """
    for stage, clearance in (
        (Stage(0.1, 0.002, 0.001, 40, "lobe arcs"), 1e-4),
        (Stage(0.05, 0.003, 0.0005, 20, "lobe arcs"), 0.0),
    ):
        pitch = as_complex(ring_pitch(stage, 201, clearance))
        crest = np.abs(np.angle(pitch)) < 0.3 * stage.pin_radius / stage.ring_radius
        np.testing.assert_allclose(
            np.abs(pitch[crest] - stage.ring_radius), stage.pin_radius, atol=1e-15
        )
        assert np.abs(pitch).max() == pytest.approx(
            stage.tip_radius + stage.eccentricity + clearance
        )
        assert (np.diff(np.angle(pitch)) > -1e-12).all()
        assert len(repeat_pitch(ring_pitch(stage, 201), stage.pins)) == 40 * (len(pitch) - 1) // (
            40 // stage.pins
        )


def test_the_ring_around_planet_pins_is_its_flank():
    """Planet pins: one pitch of the ring lies on the toothed wheel's flank, and closes after z
    copies.
    """
    pitch = ring_pitch(PLANET_PINS, 201)
    whole = repeat_pitch(pitch, PLANET_PINS.lobes)
    assert np.hypot(*pitch[0]) == pytest.approx(np.hypot(*pitch[-1]), rel=1e-12)
    assert len(whole) == PLANET_PINS.lobes * (len(pitch) - 1)
    assert np.hypot(*whole.T).max() == pytest.approx(
        PLANET_PINS.ring_radius + PLANET_PINS.pin_radius + PLANET_PINS.eccentricity, rel=1e-9
    )


@pytest.mark.parametrize(
    ("stage", "reason", "nearest"),
    [
        ((0.0775, 0.004, 0.0025, 40), "the profile loops", "below 1.9375 mm"),
        ((0.034, 0.0075, 0.0021, 14), "undercuts the flank", "largest possible is 5.5073 mm"),
        ((0.034, 0.008, 0.0010, 14), "neighbouring pins overlap", "7.5657 mm"),
        ((0.05, -0.001, 0.001, 20), "positive length", "pin radius is -0.001"),
        ((0.05, 0.003, math.nan, 20), "positive length", "eccentricity is nan"),
        ((0.05, 0.003, 0.001, 2), "2 pins", "3 or more"),
        ((0.05, 0.003, 0.001, 20, "rollers"), "'rollers'", "'planet pins'"),
    ],
)
def test_an_impossible_stage_is_refused_with_the_nearest_possible_one(
    stage: tuple, reason: str, nearest: str
):
    """An impossible stage is refused with the reason and the nearest possible value."""
    with pytest.raises(ValueError, match="cannot exist") as refusal:
        Stage(*stage)
    assert reason in str(refusal.value)
    assert nearest in str(refusal.value)


def test_the_nearest_value_in_the_message_is_possible():
    """A stage with the largest pin radius that a message states is accepted."""
    with pytest.raises(ValueError, match="largest possible is") as refusal:
        Stage(0.034, 0.0075, 0.0021, 14)
    named = float(str(refusal.value).split("largest possible is ")[1].split(" mm")[0])
    assert Stage(0.034, named * 1e-3, 0.0021, 14).pin_radius == pytest.approx(named * 1e-3)


def test_a_flat_valley_has_no_radius():
    """With a small eccentricity the locus is convex everywhere, and no valley radius limits a
    cutter.
    """
    assert valley_radius(Stage(0.1, 0.002, 0.0001, 20)) == math.inf


@pytest.mark.parametrize("circle", [-8e-6, -3e-6])
def test_play_of_a_disc_cut_on_a_larger_pin_circle(circle):
    """The play is the smallest free rotation of the true profile between contacts in both
    directions, over a pitch of the crank.
    """
    stage, made = Stage(0.064, 0.003, 0.0013, 40), Modification(roller=1e-5, circle=circle)
    points = flank(stage, np.linspace(0, 2 * np.pi, 80_001), made)[0] @ [1, 1j]
    pins = stage.ring_radius * np.exp(2j * np.pi * np.arange(40) / 40)

    def room(angle: float, way: int, psi: float) -> float:
        centre, turn = planet_pose(stage, np.array(psi))
        placed = points * np.exp(1j * (turn + way * angle)) + complex(*centre)
        return float(min(np.abs(placed - pin).min() for pin in pins) - stage.pin_radius)

    free = [
        sum(brentq(room, 0.0, 1e-3, args=(way, psi), xtol=1e-8) for way in (1, -1))
        for psi in (0.0, 0.05, 0.1)
    ]
    assert min(free) == pytest.approx(play(stage, made), rel=0.04)
