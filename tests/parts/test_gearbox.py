"""Gearboxes by catalogue values: wind-up, play closed by the load, hysteresis, transmission
error.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from scipy import stats

from lostmotion.parts.joint import PrismaticJoint, RevoluteJoint
from lostmotion.units import Toleranced
from tests.parts.conditions import (
    ARCMIN,
    SLIDE_Z,
    TURN_Z,
    condition,
    design,
    drawn,
    gearbox,
    screw_drive,
    terms_at,
    visit_size,
)

PLAY = gearbox(backlash=1e-3, friction_torque=2.0)


def about_z(torque: float) -> tuple[float, ...]:
    """Return a load about the joint's axis, with others across it that must not matter."""
    return (40.0, -30.0, torque, 5.0, 6.0, 7.0)


@pytest.mark.parametrize("torque", [-412.0, -3.0, 0.0, 3.0, 412.0])
def test_the_output_deflects_under_the_load(torque: float):
    """A torque from outside turns the output its own way, by torque over stiffness, and about the
    joint's axis only.
    """
    error = design(terms_at(gearbox(stiffness=113 / ARCMIN), condition(about_z(torque))))
    np.testing.assert_allclose(error, [[0, 0, torque / 113 * ARCMIN, 0, 0, 0]], rtol=1e-12)


def test_zones_stiffen():
    """A size-25 strain wave gear at 30 N m winds up by 14/K1 + 16/K2."""
    part = gearbox(stiffness=[31e3, 50e3, 57e3], zone_torques=[14.0, 48.0])
    assert design(terms_at(part, condition(about_z(-30.0))))[0, 2] == pytest.approx(
        -(14 / 31e3 + 16 / 50e3)
    )


def test_scatter_of_stiffness_is_a_share_of_the_wind_up():
    """With ± 10 % on stiffness no gearbox winds up by more than 10 % beside the nominal, and some
    by almost that.
    """
    found = terms_at(gearbox(stiffness=1e4, stiffness_scatter=0.1), condition(about_z(100.0)))
    wind_up = drawn(found, 10_000)[:, 0, 2]
    assert np.abs(wind_up / 0.01 - 1).max() <= 0.1
    assert np.abs(wind_up / 0.01 - 1).max() > 0.09


@pytest.mark.parametrize("torque", [3.0, -3.0, 300.0, -300.0])
@pytest.mark.parametrize("approach", [-1.0, 0.0, 1.0])
def test_a_load_closes_the_play_on_its_side(torque: float, approach: float):
    """Under a load above the largest friction the output sits at half the play on the load's side,
    at every visit, whatever the approach.

    Friction of 2 N m differs by ±50 % where its scatter is not stated, so that 3 N m overcome it in
    every robot.
    """
    found = terms_at(PLAY, condition(about_z(torque), approach=approach))
    np.testing.assert_allclose(design(found)[0], math.copysign(0.5e-3, torque) * TURN_Z, rtol=1e-12)
    assert visit_size(found) == 0


def test_without_load_the_play_is_open():
    """At no load the output rests on either side of the play, half of it away from the middle, and
    nothing in between.
    """
    found = terms_at(PLAY, condition(about_z(0.0)))
    assert not design(found).any()
    angles = drawn(found, 1000)[:, 0, 2]
    np.testing.assert_allclose(np.unique(angles), [-0.5e-3, 0.5e-3], rtol=1e-12)


@pytest.mark.parametrize("approach", [-1.0, 1.0])
def test_always_coming_from_one_side_the_output_trails(approach: float):
    """An unloaded joint that always arrives in one direction sits at the trailing end of its play
    and repeats exactly.
    """
    found = terms_at(PLAY, condition(about_z(0.0), approach=approach))
    np.testing.assert_allclose(design(found)[0], -approach * 0.5e-3 * TURN_Z, rtol=1e-12)
    assert visit_size(found) == 0


def test_play_comes_and_goes_through_the_balance_point():
    """As a joint passes the pose at which its load changes sign, its repeatability is worst at
    balance and best outside the friction.
    """
    torques = np.linspace(-4, 4, 81)
    found = terms_at(PLAY, condition([about_z(t) for t in torques]))
    spread = np.sqrt(sum(term.screw[:, 2] ** 2 for term in found if term.visit is not None))
    # The play stays open in robots whose friction is larger: a truncated normal distribution about
    # 2 N m, three sigma of which are 1 N m.
    closed = stats.truncnorm(-3, 3, loc=2.0, scale=1 / 3).cdf(np.abs(torques))
    np.testing.assert_allclose(spread, 0.5e-3 * np.sqrt(1 - closed), atol=1e-12)


def test_friction_is_a_hundredth_of_the_rated_torque_unless_stated():
    """Without a stated friction torque 1 % of the rated torque, ±50 %, can hold the play open: 2 N
    m, and so 1 to 3.
    """
    part = gearbox(backlash=1e-3, rated_torque=200.0)
    assert visit_size(terms_at(part, condition(about_z(1.0)))) == pytest.approx(0.5e-3)
    assert visit_size(terms_at(part, condition(about_z(2.0)))) == pytest.approx(0.25e-3)
    assert visit_size(terms_at(part, condition(about_z(3.0)))) == 0
    assert visit_size(terms_at(gearbox(backlash=1e-3), condition(about_z(1e-3)))) == 0


@given(
    st.floats(-6, 6),
    st.sampled_from([-1.0, 0.0, 1.0]),
    st.floats(0, 1),
    st.sampled_from(["normal", "uniform"]),
)
@settings(deadline=None, max_examples=60)
def test_no_output_leaves_its_play(torque: float, approach: float, share: float, law: str):
    """Whatever the load and approach, no gearbox of play p ± t stands off by more than (p + t)/2,
    nor by less than (p - t)/2: it is at an end.
    """
    part = gearbox(backlash=Toleranced(1e-3, share * 1e-3, law), friction_torque=2.0)
    off = np.abs(
        drawn(terms_at(part, condition(about_z(torque), approach=approach)), 2000)[:, 0, 2]
    )
    assert off.max() <= 0.5e-3 * (1 + share) * (1 + 1e-12)
    assert off.min() >= 0.5e-3 * (1 - share) * (1 - 1e-12)
    assert off.mean() == pytest.approx(0.5e-3, rel=0.05)


def test_the_loop_of_friction_does_not_close_under_load():
    """Hysteresis is half its width on either side by the way of arriving, under any load."""
    part = gearbox(hysteresis=2e-4)
    for torque in (0.0, 500.0):
        assert set(
            np.round(drawn(terms_at(part, condition(about_z(torque))), 100)[:, 0, 2], 12)
        ) == {-1e-4, 1e-4}
        assert design(terms_at(part, condition(about_z(torque), approach=1.0)))[
            0, 2
        ] == pytest.approx(-1e-4)


def test_transmission_error_is_peak_to_peak_over_a_turn():
    """Over a turn the transmission error of every single gearbox swings by the stated peak-to-peak
    value, from a phase of its own.
    """
    angles = np.linspace(0, 2 * np.pi, 721)
    errors = drawn(
        terms_at(gearbox(transmission_error=1e-4), condition(angle=angles)), 50, poses=721
    )[:, :, 2]
    np.testing.assert_allclose(np.ptp(errors, axis=1), 1e-4, rtol=1e-4)
    assert np.ptp(np.argmax(errors, axis=1)) > 180


def test_harmonics_of_transmission_error_have_their_cycles_per_turn():
    """A harmonic with 2 cycles a turn and amplitude a is a sine of that amplitude: its spectrum has
    one line, at 2, of height a.
    """
    angles = np.linspace(0, 2 * np.pi, 64, endpoint=False)
    part = gearbox(
        transmission_error=[{"amplitude": 3e-5, "cycles": 2.0}, {"amplitude": 1e-5, "cycles": 11.0}]
    )
    lines = (
        np.abs(
            np.fft.rfft(
                drawn(terms_at(part, condition(angle=angles)), 20, poses=64)[:, :, 2], axis=1
            )
        )
        / 32
    )
    np.testing.assert_allclose(lines[:, 2], 3e-5, rtol=1e-9)
    np.testing.assert_allclose(lines[:, 11], 1e-5, rtol=1e-9)
    assert np.delete(lines, [2, 11], axis=1).max() < 1e-15


def test_a_screw_repeats_with_its_lead():
    """On a sliding joint a harmonic counts cycles per turn of the screw: with 5 mm lead one repeats
    after 5 mm, three after a third of it.
    """
    once, thrice = (
        screw_drive(transmission_error=[{"amplitude": 1e-5, "cycles": cycles}], lead=5e-3)
        for cycles in (1, 3)
    )
    for part, period in ((once, 5e-3), (thrice, 5e-3 / 3)):
        places = 0.1 + period * np.array([0, 1, 0.5])
        errors = drawn(terms_at(part, condition(angle=places, axis=SLIDE_Z)), 20, poses=3)[:, :, 5]
        np.testing.assert_allclose(errors[:, 0], errors[:, 1], atol=1e-15)
        np.testing.assert_allclose(errors[:, 0], -errors[:, 2], atol=1e-15)


def test_one_figure_for_a_screw_is_its_error_over_a_turn():
    """A ball screw's 20 µm of transmission error swing through 20 µm over one lead, once."""
    places = np.linspace(0.2, 0.21, 721)
    errors = drawn(
        terms_at(
            screw_drive(transmission_error=2e-5, lead=0.01), condition(angle=places, axis=SLIDE_Z)
        ),
        50,
        poses=721,
    )[:, :, 5]
    np.testing.assert_allclose(np.ptp(errors, axis=1), 2e-5, rtol=1e-4)
    assert (np.abs(np.fft.rfft(errors[:, :-1], axis=1))[:, 2:] < 1e-14).all()


@pytest.mark.parametrize("waves", [2e-5, [{"amplitude": 1e-5, "cycles": 2.0}]])
def test_harmonics_along_a_slide_need_a_lead(waves: object):
    """The travel per turn must be known: a sliding joint refuses harmonics without a lead, a
    turning one any lead.
    """
    with pytest.raises(ValidationError) as caught:
        screw_drive(transmission_error=waves)
    assert (
        caught.value.errors()[0]["ctx"]["why"]
        == "transmission_error without a lead on a sliding joint"
    )
    assert (
        caught.value.errors()[0]["ctx"]["example"]
        == 'gearbox = { transmission_error = "20 µm", lead = "10 mm" }'
    )
    with pytest.raises(ValidationError, match="a lead on a turning joint"):
        gearbox(lead=0.01)
    with pytest.raises(ValidationError, match="out of range"):
        screw_drive(transmission_error=waves, lead=0.0)
    with pytest.raises(ValueError, match="without a lead"):
        terms_at(gearbox(transmission_error=waves), condition(axis=SLIDE_Z))


def test_a_sliding_joint_deflects_along_its_axis():
    """A ball screw of 100 N/µm under 50 N yields by half a micrometre along the slide."""
    error = design(
        terms_at(screw_drive(stiffness=1e8), condition((9, 9, 9, 9, 9, 50.0), axis=SLIDE_Z))
    )
    np.testing.assert_allclose(error[0], 0.5e-6 * SLIDE_Z, rtol=1e-12)


def test_lost_motion_holds_play_and_wind_up():
    """An RV-42N with 1' of lost motion at 3 % of 412 N m and 113 N m/arcmin has 0.781' of play."""
    part = gearbox(lost_motion=ARCMIN, rated_torque=412.0, stiffness=113 / ARCMIN)
    assert part.play.nominal / ARCMIN == pytest.approx(1 - 2 * 12.36 / 113)
    assert visit_size(terms_at(part, condition())) == pytest.approx(part.play.nominal / 2)
    at_four_percent = gearbox(
        lost_motion=ARCMIN, lost_motion_torque=0.04, rated_torque=412.0, stiffness=113 / ARCMIN
    )
    assert at_four_percent.play.nominal / ARCMIN == pytest.approx(1 - 2 * 16.48 / 113)


@pytest.mark.parametrize(
    ("fields", "why"),
    [
        (
            {"backlash": 1e-4, "lost_motion": 1e-4, "rated_torque": 10.0, "stiffness": 1e4},
            "both backlash and lost_motion",
        ),
        ({"lost_motion": 1e-4}, "lost_motion without rated_torque"),
        ({"lost_motion": 1e-4, "rated_torque": 10.0}, "lost_motion without rated_torque"),
        (
            {"lost_motion": 1e-6, "rated_torque": 1000.0, "stiffness": 1e4},
            "smaller than the elastic wind-up",
        ),
        ({"stiffness": [1e4, 2e4]}, "zone torques"),
        ({"stiffness": [1e4, 2e4, 3e4], "zone_torques": [5.0, 4.0]}, "zone torques"),
        ({"stiffness": [1e4, 2e4], "zone_torques": [-5.0]}, "out of range"),
        ({"zone_torques": [5.0]}, "zone torques"),
        ({"rated_torque": -10.0}, "out of range"),
        ({"friction_torque": -1.0}, "out of range"),
        ({"ratio": 0.0}, "out of range"),
        ({"backlash": Toleranced(1e-4, 2e-4)}, "reaches out of range"),
        ({"backlsh": 1e-4}, "Extra inputs"),
    ],
)
def test_a_gearbox_that_cannot_be_is_refused(fields: dict[str, object], why: str):
    """Catalogue values that contradict each other or physics are refused with the reason."""
    with pytest.raises(ValidationError, match=why):
        RevoluteJoint(name="A", limits=(-1, 1), gearbox=fields)
    with pytest.raises(ValidationError):
        PrismaticJoint(name="A", limits=(-1, 1), gearbox=fields)
