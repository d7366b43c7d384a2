"""An encoder on the output: what the controller corrects, and the play that no load closes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from pydantic import ValidationError

from lostmotion.error_model.expected_repeatability import visit_covariance
from lostmotion.error_model.pose_matrix import screws
from lostmotion.laws.iso9283 import pose_repeatability
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.state import state_of
from lostmotion.parts.joint import RevoluteJoint
from lostmotion.units import Toleranced
from tests.parts.conditions import condition, drawn, encoder, terms_at

if TYPE_CHECKING:
    from lostmotion.parts.error_source import ErrorSource

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "backlash behind an output encoder",
        "root mean square h/√3 and RP 1.36603 h of a uniform distribution, by samples",
        "1 %",
    ),
)

PLAY, FRICTION, REACH = 2e-3, 4.0, 0.5


def left_of(play: object = PLAY, dead_band: float | None = None) -> ErrorSource:
    """Return what an encoder on the output leaves of a gearbox."""
    gearbox = {
        "backlash": play,
        "friction_torque": FRICTION,
        "stiffness": 1e4,
        "hysteresis": 1e-4,
        "transmission_error": 1e-4,
    }
    return RevoluteJoint(
        name="A",
        limits=(-1, 1),
        gearbox=gearbox,
        encoder={"side": "output", "dead_band": dead_band},
    ).sources["gearbox"]


@pytest.mark.parametrize(
    ("dead_band", "half"), [(None, PLAY / 2), (PLAY, PLAY / 2), (PLAY / 8, PLAY / 8), (0.0, 0.0)]
)
def test_without_load_the_output_rests_anywhere_within_play_and_dead_band(
    dead_band: float | None, half: float
):
    """A uniform law of half width h: root mean square h / sqrt 3, never more than h, RP of many
    visits h/2 + 3 h / sqrt 12 = 1.36603 h.
    """
    angle = drawn(terms_at(left_of(dead_band=dead_band), condition()), 200_000)[:, 0, 2]
    assert np.abs(angle).max() <= half * (1 + 1e-12)
    assert math.sqrt((angle**2).mean()) == pytest.approx(half / math.sqrt(3), rel=0.01)
    shift = REACH * angle[:, None] * np.array([0, 1.0, 0])
    assert float(pose_repeatability(shift)) == pytest.approx(1.36603 * REACH * half, rel=0.01)


@pytest.mark.parametrize("approach", [-1.0, 0.0, 1.0])
def test_the_load_closes_what_the_encoder_leaves_and_the_controller_takes_the_rest(approach: float):
    """All of it up to half the friction, nothing from one and a half times on, whatever the
    approach: no wind-up, no hysteresis, no side, no mean.
    """
    loads = np.array([0.0, 1e-9, 0.25, 0.5, 1.0, 1.5, 3.0]) * FRICTION
    found = terms_at(
        left_of(), condition([(0, 0, load, 0, 0, 0) for load in loads], approach=approach)
    )
    assert [term.level for term in found] == ["visit", "robot x visit"]
    whole = np.sqrt(sum(term.screw[:, 2] ** 2 for term in found))
    np.testing.assert_allclose(
        whole * math.sqrt(3), PLAY / 2 * np.sqrt([1, 1, 1, 1, 0.5, 0, 0]), rtol=1e-12, atol=1e-18
    )


def test_a_play_that_scatters_is_left_open_as_it_is_and_a_dead_band_does_not():
    """Over robots the mean square is that of the amount's; a dead band well inside the play is the
    controller's own and the same on all.
    """
    scattered = Toleranced(PLAY, 0.6 * PLAY, "uniform")
    angle = drawn(terms_at(left_of(scattered), condition()), 400_000)[:, 0, 2]
    assert (angle**2).mean() == pytest.approx((PLAY**2 + (0.6 * PLAY) ** 2 / 3) / 12, rel=0.01)
    band, _ = terms_at(left_of(scattered, PLAY / 8), condition())
    assert (band.level, band.name) == ("visit", "dead band")


def test_an_arm_says_what_its_output_encoders_correct():
    """The joints are named, and at the tool the open play swings with the reach; an encoder on the
    motor corrects nothing.
    """
    fields = {
        "gearbox": {"backlash": PLAY},
        "link": {"length": REACH, "mass": 2.0},
        "limits": (-1, 1),
    }
    joints = [
        RevoluteJoint(name=name, encoder={"side": side}, **fields)
        for name, side in (("A", "output"), ("B", "motor"), ("C", "output"))
    ]
    arm = Arm(name="vertical", joints=joints)
    (said,) = [remark for remark in arm.remarks if remark.startswith("encoder")]
    assert said.startswith(
        "encoder on the output of A, C: the controller corrects wind-up and backlash"
    )
    one = Arm(name="one", joints=joints[:1])
    spread = visit_covariance(screws(state_of(one, np.array([[0.0]]))))[0]
    assert math.sqrt(np.trace(spread)) == pytest.approx(REACH * PLAY / 2 / math.sqrt(3))
    assert one.assumed_friction
    assert not [
        remark
        for remark in Arm(name="motor", joints=joints[1:2]).remarks
        if remark.startswith("encoder")
    ]


def test_a_dead_band_belongs_to_the_output():
    """An encoder on the motor does not see the output, so that a dead band there says nothing and
    is refused.
    """
    with pytest.raises(ValidationError) as caught:
        encoder(dead_band=1e-4)
    (error,) = caught.value.errors()
    assert error["ctx"]["why"] == "dead_band of an encoder on the motor"
    assert encoder(side="output", dead_band=1e-4).dead_band == 1e-4
