"""What one-sided repeatability comes from: the dead band of a servo, and friction that scatters
from visit to visit.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.optimize import brentq

from lostmotion.error_model.expected_repeatability import expected_repeatability, visit_covariance
from lostmotion.error_model.pose_matrix import screws
from lostmotion.error_model.servo_tuning import TUNINGS, tuned_rms
from lostmotion.laws.iso9283 import pose_repeatability
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.state import state_of
from lostmotion.parts.gearbox.cycloidal.sources import HysteresisLoop
from lostmotion.parts.joint import PrismaticJoint, RevoluteJoint
from tests.parts.conditions import TURN_Z, condition, drawn, terms_at

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "one-sided repeatability of one joint",
        (
            "RP of a uniform dead band, 1.36603 b; of normal friction scatter, 2.60632 standard "
            "deviations; the product of side and scatter, drawn"
        ),
        "1 %",
    ),
)

REACH, BAND = 0.5, 1e-3
LOOP, SHARE = 4e-4, 0.3


def joint(**fields: Any) -> RevoluteJoint:
    """Return a vertical joint with a rigid link of 0.5 m."""
    return RevoluteJoint(name="A", limits=(-1, 1), link={"length": REACH, "rigid": True}, **fields)


def spread(approach: float = 1.0, **fields: Any) -> float:
    """Return the standard deviation (m) between visits of the tool of an arm of one joint."""
    matrix = screws(
        state_of(Arm(name="one", joints=(joint(**fields),)), np.array([[0.3]])), approach=approach
    )
    return math.sqrt(np.trace(visit_covariance(matrix)[0]))


def test_a_servo_stops_anywhere_within_its_dead_band():
    """Uniform: standard deviation b / sqrt 3, never beyond b, and RP of many visits 1.36603 b at
    the tool.
    """
    (source,) = joint(servo={"dead_band": BAND}).sources.values()
    angle = drawn(terms_at(source, condition()), 200_000)[:, 0, 2]
    assert np.abs(angle).max() <= BAND * (1 + 1e-12)
    shift = REACH * angle[:, None] * np.array([0, 1.0, 0])
    assert float(pose_repeatability(shift)) == pytest.approx(1.36603 * REACH * BAND, rel=0.01)
    assert [spread(side, servo={"dead_band": BAND}) for side in (-1.0, 0.0, 1.0)] == pytest.approx(
        [REACH * BAND / math.sqrt(3)] * 3
    )


@pytest.mark.parametrize(
    ("encoder", "share"),
    [
        (None, 1.0),
        ({"side": "output"}, 1.0),
        ({"side": "motor"}, 1 / 80),
        ({"side": "motor", "ratio": 1.0}, 1.0),
    ],
)
def test_a_dead_band_is_measured_where_the_encoder_is(encoder: dict[str, Any] | None, share: float):
    """On the motor it reaches the output divided by the turns of the encoder; without an encoder it
    is stated at the output.
    """
    fields = {"gearbox": {"ratio": 80.0}, "servo": {"dead_band": BAND}, "encoder": encoder}
    assert spread(**fields) == pytest.approx(share * REACH * BAND / math.sqrt(3))


def test_a_dead_band_along_a_slide_is_a_length_at_the_slide():
    """Whatever the ratio of the drive."""
    slide = PrismaticJoint(
        name="X",
        limits=(0, 1),
        gearbox={"lead": 0.01, "ratio": 5.0},
        encoder={},
        servo={"dead_band": 1e-5},
    )
    covariance = visit_covariance(
        screws(state_of(Arm(name="one", joints=(slide,)), np.array([[0.3]])))
    )[0]
    assert math.sqrt(np.trace(covariance)) == pytest.approx(1e-5 / math.sqrt(3))


def test_with_an_output_encoder_the_dead_band_holds_the_play_too():
    """The control stops the output itself: backlash inside the loop adds nothing to the band, and
    two bands on one joint are a mistake.
    """
    geared = {"gearbox": {"backlash": 4 * BAND}, "encoder": {"side": "output"}}
    assert spread(**geared, servo={"dead_band": BAND}) == pytest.approx(REACH * BAND / math.sqrt(3))
    with pytest.raises(ValidationError) as caught:
        joint(
            gearbox={"backlash": BAND},
            encoder={"side": "output", "dead_band": BAND},
            servo={"dead_band": BAND},
        )
    assert (
        caught.value.errors()[0]["ctx"]["why"] == "a dead_band of the servo and one of the encoder"
    )


def test_friction_that_scatters_remains_where_the_side_is_known():
    """From one side the standard deviation is a third of the ± share of half the loop; its bound is
    the ± share, and the mean stays where it was.
    """
    gearbox = {"hysteresis": LOOP, "hysteresis_scatter": SHARE}
    # a normal distribution cut at three standard deviations has 0.97334 of its variance
    cut = 1 / math.sqrt(0.97334)
    known = REACH * SHARE * LOOP / 2 / 3 / cut
    assert spread(1.0, gearbox=gearbox) == pytest.approx(known, rel=1e-4)
    assert spread(0.0, gearbox=gearbox) == pytest.approx(
        math.hypot(known, REACH * LOOP / 2), rel=1e-4
    )
    arm = Arm(name="one", joints=(joint(gearbox=gearbox),))
    sided, plain = (
        screws(state_of(each, np.array([[0.3]])), approach=1.0).bias
        for each in (arm, Arm(name="one", joints=(joint(gearbox={"hysteresis": LOOP}),)))
    )
    np.testing.assert_array_equal(sided, plain)
    covariance = visit_covariance(screws(state_of(arm, np.array([[0.3]])), approach=1.0))
    assert expected_repeatability(covariance)[0][0] == pytest.approx(2.60632 * known, rel=1e-4)


def test_the_product_of_side_and_scatter_is_independent_of_the_side():
    """A backlash shares the side with the loop: b s + h s (1 + k x), drawn as a product, has the
    moments of the model's sum, also jointly with s.
    """
    play = 6e-4
    (source,) = joint(
        gearbox={
            "backlash": play,
            "hysteresis": LOOP,
            "hysteresis_scatter": SHARE,
            "friction_torque": 1.0,
        }
    ).sources.values()
    model = drawn(terms_at(source, condition()), 400_000)[:, 0, 2]
    rng = np.random.default_rng(5)
    side, x = rng.choice([-1.0, 1.0], 400_000), rng.standard_normal(800_000)
    x = x[np.abs(x) <= 3][:400_000] / 3
    product = side * (play / 2 + LOOP / 2 * (1 + SHARE * x))
    for power in (2, 4, 6):
        assert (model**power).mean() == pytest.approx((product**power).mean(), rel=0.005)
    np.testing.assert_allclose(
        np.quantile(np.abs(model), [0.05, 0.5, 0.95]),
        np.quantile(np.abs(product), [0.05, 0.5, 0.95]),
        rtol=0.002,
    )


def test_friction_behind_a_spring_is_a_loop_where_only_its_scatter_is_stated():
    """Half the loop of the friction F behind the stiffness K is F / K; without either a scatter has
    nothing to scatter, and is refused.
    """
    gearbox = {"friction_torque": 3.0, "stiffness": 1e4, "hysteresis_scatter": SHARE}
    same = {"stiffness": 1e4, "hysteresis": 2 * 3.0 / 1e4, "hysteresis_scatter": SHARE}
    assert [spread(side, gearbox=gearbox) for side in (0.0, 1.0)] == pytest.approx(
        [spread(side, gearbox=same) for side in (0.0, 1.0)]
    )
    for lacking in ({"stiffness": 1e4}, {"friction_torque": 3.0}, {}):
        with pytest.raises(ValidationError, match="without a hysteresis"):
            joint(gearbox={**lacking, "hysteresis_scatter": SHARE})


def test_the_loop_of_a_drawn_gearbox_scatters_with_the_load():
    """Its half width depends on the load, and the scatter is the same share of it under every
    load.
    """
    torque = np.array([0.0, 10.0, 100.0])
    loop = HysteresisLoop(torque, 1e-5 * torque, 0.1 + 0.05 * torque, scatter=SHARE)
    at = condition([(0, 0, load, 0, 0, 0) for load in (0.0, 5.0, 50.0)])
    side, scatter = (term.screw @ TURN_Z for term in terms_at(loop, at))
    assert np.ptp(side) > 0
    np.testing.assert_allclose(scatter, side * SHARE / 3 * math.sqrt(0.97334), rtol=1e-4)


def lifting(servo: dict[str, Any], force: float = 0.0) -> Arm:
    """Return 0.5 kg at 0.3 m on a joint that lifts, with a gearbox of 20 N m/rad."""
    lifts = RevoluteJoint(
        name="A",
        axis="-y",
        limits=(-1, 1),
        gearbox={"ratio": 10.0, "stiffness": 20.0},
        servo=servo,
        link={"length": 0.3, "mass": 0.5, "centre_of_mass": (0.3, 0, 0), "rigid": True},
    )
    return Arm(name="one", joints=(lifts,), payload={"force": (0.0, 0.0, force)})


@pytest.mark.parametrize(
    ("servo", "rest", "pushed", "force"),
    [
        ({"stiffness": 5.0}, 1.0, 1.0, 0.0),
        ({"stiffness": 5.0, "gravity_compensation": 0.7}, 0.3, 1.0, 0.0),
        ({"stiffness": 5.0, "gravity_compensation": 1.0}, 0.0, 1.0, -2.0),
        ({"stiffness": 5.0, "gravity_compensation": 0.4, "integral": True}, 0.0, 0.0, -2.0),
    ],
)
def test_a_servo_droops_by_the_torque_that_is_not_fed_forward(servo, rest, pushed, force):
    """The joint stands where servo and gearbox in series balance the load: of the weight only what
    is not fed forward winds the servo, and all of a process force. Integral action leaves none.
    """

    def balance(angle: float) -> float:
        weight, process = 0.5 * 9.80665 * 0.3 * math.cos(angle), -0.3 * force
        servo_turn = (rest * weight + pushed * process) / 5.0
        return angle - 0.5 + (weight + process) / 20.0 + servo_turn

    arm = lifting(servo, force)
    found = state_of(arm, np.array([[0.5]])).settled().frames[-1, 0]
    stands = brentq(balance, -1.5, 1.0, xtol=1e-13)
    np.testing.assert_allclose(
        found[[0, 2], 3], 0.3 * np.array([math.cos(stands), math.sin(stands)]), atol=1e-9
    )


def test_a_servo_is_a_spring_to_every_load():
    """What the controller feeds forward does not make the servo stiffer: the compliance along the
    force is r^2 (1/K + 1/k).
    """
    arm = lifting({"stiffness": 5.0, "gravity_compensation": 1.0})
    found = state_of(arm, np.zeros((1, 1))).compliance[0, 5, 5]
    assert found == pytest.approx(0.3**2 * (1 / 5 + 1 / 20))


def test_tuning_a_servo_leaves_what_the_tuned_arm_has():
    """Each tuning has the r.m.s. error of an arm that states it, and integral action leaves the
    least.
    """
    q = np.linspace(-0.5, 0.5, 8)[:, None]
    found = tuned_rms(lifting({"stiffness": 5.0}), q)
    assert tuple(found) == TUNINGS
    twice = tuned_rms(lifting({"stiffness": 10.0}), q)
    assert found["twice the stiffness"] == pytest.approx(twice["as described"])
    assert found["integral action"] == pytest.approx(found["gravity compensation of 100 %"])
    assert found["integral action"] < found["twice the stiffness"] < found["as described"]
    assert tuned_rms(lifting({"dead_band": BAND}), q) == {}


def test_gravity_compensation_needs_a_stiffness():
    """A share of a torque that winds nothing is refused."""
    with pytest.raises(
        ValidationError, match="gravity_compensation of a servo without a stiffness"
    ):
        joint(servo={"gravity_compensation": 0.5})
