"""What must hold for every kind of part, whatever it is."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lostmotion.parts.base import Base
from lostmotion.parts.bearing.crossed_roller import CrossedRoller
from lostmotion.parts.bearing.crossed_rollers import CrossedRollerBearing
from lostmotion.parts.bearing.pair import BallPair, RollerPair
from lostmotion.parts.bearing.rolling import RollingPair
from lostmotion.parts.elastic_link import ElasticLink
from lostmotion.parts.error_source import ErrorSource, Friction
from lostmotion.parts.gearbox.cycloidal.sources import (
    ErrorHarmonic,
    GearboxWindUp,
    HysteresisLoop,
    Play,
    TransmissionError,
)
from lostmotion.parts.guideway import Guideway
from lostmotion.parts.link import Link
from lostmotion.parts.lumped import Lumped
from lostmotion.parts.mounting import Mounting
from lostmotion.parts.servo import ServoStops
from lostmotion.parts.term import Condition, Motion
from lostmotion.units import Toleranced
from tests.parts.conditions import (
    SLIDE_Z,
    TURN_Z,
    condition,
    drawn,
    encoder,
    gearbox,
    screw_drive,
    terms_at,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.parts.term import Term


def elastic_link(s: float) -> ErrorSource:
    """Return a steel bar, s times as soft and s times as inexactly cut."""
    material = {"young": 210e9 / s, "poisson": 0.3, "density": 7850.0, "scatter": 0.1}
    link = Link(
        length=Toleranced(0.5, s * 1e-4),
        section={"kind": "rectangle", "width": 0.03, "height": 0.05},
        material=material,
    )
    return ElasticLink(link, np.array([0, 0, 1.0]))


def full_gearbox(s: float) -> ErrorSource:
    """Return a gearbox with every error it can have, all s times as large; with a lead, for it is
    put on sliding joints too.
    """
    return gearbox(
        ratio=100,
        rated_torque=50.0,
        stiffness=[31e3 / s, 50e3 / s],
        zone_torques=[14.0],
        stiffness_scatter=0.1,
        backlash=Toleranced(s * 2e-4, s * 1e-4),
        hysteresis=s * 1e-4,
        hysteresis_scatter=0.3,
        transmission_error=[
            {"amplitude": s * 1e-4, "cycles": 2.0},
            {"amplitude": s * 2e-5, "cycles": 200.0},
        ],
    ).model_copy(update={"lead": 0.01})


def full_screw_drive(s: float) -> ErrorSource:
    """Return a ball screw with every error it can have, all s times as large."""
    return screw_drive(
        rated_torque=500.0,
        stiffness=1e8 / s,
        backlash=Toleranced(s * 2e-5, s * 1e-5, "uniform"),
        hysteresis=s * 1e-6,
        transmission_error=s * 1e-5,
        lead=0.01,
        lead_error=s * 1e-4,
    )


def full_guideway(s: float) -> ErrorSource:
    """Return a guideway with every error motion it can have, all s times as large."""
    return Guideway(
        straightness=(s * 2e-5, s * 1e-5),
        pitch=s * 1e-4,
        yaw=s * 5e-5,
        roll=s * 2e-4,
        wavelength=0.7,
        up=[0.3, 0.4, 0.5],
    )


def full_rolling(s: float) -> ErrorSource:
    """Return a bearing pair with every error it can have, all s times as large."""
    return RollingPair(
        clearance=Toleranced(s * 4e-5, s * 2e-5),
        span=0.05,
        axial_play=Toleranced(s * 2e-5, s * 1e-5, "uniform"),
        radial_stiffness=1e8 / s,
        axial_stiffness=2e8 / s,
        closing_force=3.0,
    )


def full_crossed(s: float) -> ErrorSource:
    """Return a crossed-roller bearing with every error it can have, all s times as large."""
    return CrossedRoller(
        moment_stiffness=1e5 / s,
        radial_stiffness=1e8 / s,
        axial_stiffness=1e8 / s,
        radial_runout=s * 1e-5,
        axial_runout=s * 1e-5,
    )


def full_base(s: float) -> ErrorSource:
    """Return a base that nobody levelled well, on a mount s times as soft."""
    return Base(
        roll=Toleranced(0.1, s * 0.01),
        pitch=Toleranced(-0.2, s * 0.01, "uniform"),
        tilt_varies="visit",
        angular_stiffness=(1e5 / s, 2e5 / s, 3e5 / s),
        linear_stiffness=(1e8 / s, 2e8 / s, 3e8 / s),
    )


def full_encoder(side: str) -> Callable[[float], ErrorSource]:
    """Return an encoder with every error it can have, all s times as large; with a lead, for it is
    put on sliding joints too.
    """
    fields = {"resolution": 1e-4, "noise": 1e-5, "eccentricity": 3e-4, "zero": 1e-4}

    def made(s: float) -> ErrorSource:
        stated = encoder(side=side, ratio=50, **{name: s * size for name, size in fields.items()})
        return stated.model_copy(update={"lead": 0.01, "scale_error": s * 1e-4})

    return made


class DrawnGearbox(ErrorSource):
    """Every source of error that a cycloidal gearbox can have, all s times as large, as one
    part.
    """

    def __init__(self, s: float) -> None:
        """Make them."""
        torque = np.array([0.0, 1.0, 10.0, 100.0])
        harmonics = (
            ErrorHarmonic(39.0, s * np.array([1e-5, 2e-5, 3e-5])),
            ErrorHarmonic(78.0, s * np.array([3e-6, 2e-6, 1e-6])),
        )
        self.sources = (
            GearboxWindUp(
                torque,
                s * 1e-6 * torque**0.9,
                s * np.array([0.0, 1e-7, 1e-6, 2e-6]),
                (("onyx", 0.15), ("steel", 0.05)),
            ),
            TransmissionError(torque[1:], harmonics),
            Play(Toleranced(s * 2e-4, s * 1e-4), Friction.of_load(3.0)),
            HysteresisLoop(torque, s * 1e-6 * torque, 0.1 * torque, scatter=0.2),
        )

    def terms(self, motion: Motion) -> list[Term]:
        """Return all of them."""
        return [term for source in self.sources for term in source.terms(motion)]


PARTS: dict[str, Callable[[float], ErrorSource]] = {
    "cycloidal gearbox": DrawnGearbox,
    "gearbox": full_gearbox,
    "screw drive": full_screw_drive,
    "guideway": full_guideway,
    "bearing pair": full_rolling,
    "crossed roller": full_crossed,
    "motor encoder": full_encoder("motor"),
    "output encoder": full_encoder("output"),
    "servo": lambda s: ServoStops(s * 1e-3, 50.0),
    "lumped normal": lambda s: Lumped(angle=s * 1e-3, offset=s * 3e-5),
    "lumped uniform": lambda s: Lumped(angle=s * 1e-3, law="uniform", varies="robot"),
    "lumped two-sided": lambda s: Lumped(angle=s * 1e-3, law="two-sided"),
    "lumped from zero": lambda s: Lumped(angle=s * 1e-3, law="from zero to maximum"),
    "mounting": lambda s: Mounting(tilt=s * 1e-3, offset=s * 1e-4),
    "link": elastic_link,
    "base": full_base,
}
IDEAL: dict[str, ErrorSource] = {
    "gearbox": gearbox(ratio=100.0),
    "screw drive": screw_drive(),
    "bearing pair": RollingPair(span=0.05),
    "crossed roller": CrossedRoller(),
    "encoder": encoder(side="output"),
    "lumped": Lumped(),
    "mounting": Mounting(),
    "link": ElasticLink(Link(length=0.4), np.array([0, 0, 1.0])),
    "no link": ElasticLink(Link(), np.zeros(3)),
    "tilted base": Base(roll=0.3, pitch=-0.1),
}
LOAD = st.one_of(st.just(0.0), st.floats(-1e3, 1e3))
WRENCH = st.tuples(*[LOAD] * 6)
POSES = st.lists(st.tuples(WRENCH, st.floats(-6, 6)), min_size=1, max_size=4)
AXIS = st.one_of(
    st.sampled_from([TURN_Z, SLIDE_Z]),
    st.tuples(*[st.floats(-1, 1)] * 3, st.booleans())
    .filter(lambda v: np.linalg.norm(v[:3]) > 0.1)
    .map(
        lambda v: (
            np.concatenate(
                [np.array(v[:3]), np.zeros(3)] if v[3] else [np.zeros(3), np.array(v[:3])]
            )
            / np.linalg.norm(v[:3])
        )
    ),
)
# Springs that harden: twice as bad is not twice the error.
HARDENING: dict[str, ErrorSource] = {
    "ball pair": BallPair(
        bore=0.045,
        outside_diameter=0.085,
        balls=9,
        ball_diameter=0.0127,
        pitch_diameter=0.065,
        span=0.06,
        clearance=Toleranced(2e-5, 5e-6, "uniform"),
        closing_force=3.0,
        radial_runout=1e-5,
        axial_runout=1e-5,
    ),
    "roller pair": RollerPair(
        bore=0.06,
        outside_diameter=0.11,
        rollers=14,
        roller_diameter=0.014,
        roller_length=0.014,
        pitch_diameter=0.0855,
        span=0.08,
        clearance=Toleranced(5e-5, 1e-5),
    ),
    "crossed roller bearing": CrossedRollerBearing(
        bore=0.11,
        outside_diameter=0.15,
        rollers=48,
        roller_diameter=0.008,
        roller_length=0.006,
        pitch_diameter=0.13,
        clearance=Toleranced(-6e-6, 4e-6),
        axial_runout=1e-5,
    ),
}
EVERY = {**PARTS, **{name: lambda _, part=part: part for name, part in HARDENING.items()}}
every_part = pytest.mark.parametrize("make", EVERY.values(), ids=EVERY)


@every_part
@given(poses=POSES, axis=AXIS, approach=st.sampled_from([-1.0, 0.0, 1.0]))
@settings(deadline=None, max_examples=12)
def test_terms_are_finite_screws_with_names_of_their_own(make, poses, axis, approach):
    """Whatever load, pose and axis, a part answers with finite screws, one per pose or one for all,
    each term under its own name.
    """
    at = condition(
        [wrench for wrench, _ in poses],
        axis=axis,
        angle=np.array([angle for _, angle in poses]),
        approach=approach,
    )
    found = terms_at(make(1.0), at)
    assert found
    for term in found:
        assert np.shape(term.screw) in {(len(poses), 6), (6,)}
        assert np.isfinite(term.screw).all()
        assert np.isfinite(term.bound)
    names = [term.name for term in found if term.closed is None]
    assert len(set(names)) == len(names)


@every_part
@given(poses=POSES, axis=AXIS, approach=st.sampled_from([-1.0, 0.0, 1.0]))
@settings(deadline=None, max_examples=10)
def test_poses_do_not_see_each_other(make, poses, axis, approach):
    """What a part does at one pose is the same whether that pose is asked for alone or among
    others.
    """
    part = make(1.0)
    wrenches, angles = [wrench for wrench, _ in poses], np.array([angle for _, angle in poses])
    together = terms_at(part, condition(wrenches, axis=axis, angle=angles, approach=approach))
    for row in range(len(poses)):
        alone = terms_at(
            part, condition(wrenches[row], axis=axis, angle=angles[row], approach=approach)
        )
        assert [(term.name, term.level) for term in alone] == [
            (term.name, term.level) for term in together
        ]
        for one, many in zip(alone, together, strict=True):
            expected = many.screw if many.screw.ndim == 1 else many.screw[row]
            np.testing.assert_allclose(
                np.broadcast_to(one.screw, (1, 6))[0], expected, rtol=1e-12, atol=1e-18
            )


@pytest.mark.parametrize("make", PARTS.values(), ids=PARTS)
@given(wrench=WRENCH, angle=st.floats(-6, 6), axis=AXIS, approach=st.sampled_from([-1.0, 0.0, 1.0]))
@settings(deadline=None, max_examples=10)
def test_twice_the_tolerances_make_twice_the_error(make, wrench, angle, axis, approach):
    """A part made twice as badly and twice as softly makes every one of its errors twice as
    large.
    """
    at = condition(wrench, axis=axis, angle=angle, approach=approach)
    once, twice = terms_at(make(1.0), at), terms_at(make(2.0), at)
    assert [term.name for term in once] == [term.name for term in twice]
    for one, two in zip(once, twice, strict=True):
        np.testing.assert_allclose(two.screw, 2 * one.screw, rtol=1e-9, atol=1e-18)
        assert two.bound == pytest.approx(one.bound)


@every_part
@pytest.mark.parametrize("approach", [-1.0, 0.0, 1.0])
@pytest.mark.parametrize("wrench", [(0,) * 6, (0, 0, 0.2, 0, 0, 2.0), (30, -20, 10, 100, 50, -80)])
def test_no_robot_errs_beyond_the_worst_case(make, wrench, approach):
    """Of 10 000 robots none is off by more than the design error and all other terms at their
    bounds.
    """
    found = terms_at(make(1.0), condition(wrench, angle=0.7, approach=approach))
    worst = sum(
        (np.abs(np.broadcast_to(term.screw, (1, 6))) * term.bound for term in found),
        np.zeros((1, 6)),
    )
    errors = drawn(found, 10_000)
    assert (np.abs(errors) <= worst * (1 + 1e-12)).all()
    assert np.abs(errors).max() > 0


@every_part
def test_drawn_terms_have_mean_zero(make):
    """Averaged over many robots and visits only the design error is left: whatever has a mean puts
    it there.
    """
    at = condition((30, -20, 0.1, 1.0, 0.5, -0.8), angle=0.7)
    found = terms_at(make(1.0), at)
    draws = 40_000
    by_draw = defaultdict(lambda: np.zeros((1, 6)))
    for term in found:
        if term.level != "design":
            by_draw[term.robot, term.visit] += np.broadcast_to(term.screw, (1, 6))
    spread = np.sqrt(sum((each**2 for each in by_draw.values()), np.zeros((1, 6))))
    errors = drawn(found, draws)
    bias = sum(
        (np.broadcast_to(term.screw, (1, 6)) for term in found if term.level == "design"),
        np.zeros((1, 6)),
    )
    assert (
        np.abs(errors.mean(axis=0) - bias) <= 5 * spread / np.sqrt(draws) + 1e-9 * np.abs(bias)
    ).all()
    np.testing.assert_allclose(errors.std(axis=0), spread, rtol=0.05, atol=1e-15)


@pytest.mark.parametrize("part", IDEAL.values(), ids=IDEAL)
@given(wrench=WRENCH, axis=AXIS, approach=st.sampled_from([-1.0, 0.0, 1.0]))
@settings(deadline=None, max_examples=10)
def test_an_ideal_part_makes_no_error(part, wrench, axis, approach):
    """A part of which nothing but its size is stated is exact and rigid under any load."""
    for term in terms_at(part, condition(wrench, axis=axis, angle=0.3, approach=approach)):
        assert not np.any(term.screw)


# Every pair of a load, an axis and a last motion.
@every_part
@pytest.mark.parametrize(
    ("approach", "axis", "wrench"),
    [
        (-1.0, TURN_Z, (30, -20, 10, 100, 50, -80)),
        (-1.0, SLIDE_Z, (-15, 40, -20, 60, -90, 70)),
        (0.0, TURN_Z, (-15, 40, -20, 60, -90, 70)),
        (0.0, SLIDE_Z, (30, -20, 10, 100, 50, -80)),
        (1.0, TURN_Z, (30, -20, 10, 100, 50, -80)),
        (1.0, SLIDE_Z, (-15, 40, -20, 60, -90, 70)),
    ],
    ids=lambda value: str(value) if isinstance(value, float) else "",
)
def test_springs_go_on_giving_and_what_rests_in_a_play_does_not(make, wrench, axis, approach):
    """Under ten times the load a spring deflects more than three times as far; what rests in a play
    stays where it is.
    """
    part = make(1.0)
    none, once, tenfold = (
        {
            term.name: term
            for term in terms_at(
                part, condition(times * np.array(wrench), axis=axis, angle=0.3, approach=approach)
            )
        }
        for times in (0, 1, 10)
    )
    for name, term in once.items():
        if term.level == "design":
            before, after = (
                np.linalg.norm(one[name].screw - none[name].screw) for one in (once, tenfold)
            )
            if term.term.form.elastic:
                # A micrometre along an axis may come and go with the loads across it: balls roll up
                # their grooves.
                assert after >= 3 * before or before < 1e-6
            elif approach == 0:
                # with a known last motion friction's loop is a design term as well, and grows with
                # the friction
                assert after <= before * (1 + 1e-9)


@every_part
@pytest.mark.parametrize("axis", [TURN_Z, SLIDE_Z], ids=["turning", "sliding"])
@pytest.mark.parametrize(
    "load", [(30.0, -20.0, 12.0, 100.0, 50.0, -80.0), (-15.0, 40.0, -20.0, 60.0, -90.0, 70.0)]
)
def test_the_compliance_of_a_spring_is_the_slope_of_its_deflection(make, load, axis):
    """A small change of load deflects a spring by its compliance times that change; a play and a
    constant error have no compliance.
    """
    change = 1e-4 * np.array([3.0, -2.0, 5.0, 30.0, 20.0, -40.0])

    def at(wrench):
        return Condition(np.array([0.3]), np.asarray(wrench)[:, None], np.zeros((3, 1)))

    for term in make(1.0).terms(Motion(axis)):
        form, slope = term.form, term.form.compliance(at(load))[0]
        if form.elastic:
            expected = (form.screw(at(load + change)) - form.screw(at(load - change)))[:, 0] / 2
            np.testing.assert_allclose(
                slope @ change,
                expected,
                rtol=1e-3,
                atol=1e-9 * np.linalg.norm(form.screw(at(load))),
            )
        else:
            assert not slope.any()


@every_part
def test_a_form_depends_on_what_it_reads_and_on_nothing_else(make):
    """Other values of what a form does not read leave its screw as it is, to the bit."""
    rng = np.random.default_rng(3)
    read = {"angle": (1,), "wrench": (6, 1), "gravity": (3, 1)}
    values, others = (
        {name: rng.uniform(-50, 50, shape) for name, shape in read.items()} for _ in range(2)
    )
    for term in make(1.0).terms(Motion(TURN_Z)):
        mixed = {name: (values if name in term.form.reads else others)[name] for name in read}
        np.testing.assert_array_equal(
            term.form.screw(Condition(**values)), term.form.screw(Condition(**mixed))
        )
