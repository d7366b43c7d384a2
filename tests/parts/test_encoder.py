"""Encoders on motor and output: counts, noise, eccentricity and zero."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError

from lostmotion.mechanism.arm import Arm
from lostmotion.parts.joint import PrismaticJoint, RevoluteJoint
from tests.parts.conditions import (
    SLIDE_Z,
    at_tool,
    condition,
    drawn,
    encoder,
    only,
    terms_at,
)

GEARED = {"ratio": 80, "backlash": 1e-3, "stiffness": 1e4, "transmission_error": 1e-4}


def test_an_encoder_on_the_motor_is_divided_by_the_ratio():
    """Resolution, noise and eccentricity of a motor encoder reach the output divided by the gear
    ratio; the mastering error reaches it whole.
    """
    fields = {"resolution": 1e-3, "noise": 2e-4, "eccentricity": 3e-4, "zero": 1e-4, "ratio": 100}
    motor, output = (
        terms_at(encoder(side=side, **fields), condition(angle=0.0)) for side in ("motor", "output")
    )
    for name in ("resolution", "noise", "eccentricity 1 cosine"):
        np.testing.assert_allclose(only(motor, name), only(output, name) / 100, rtol=1e-12)
        assert only(output, name)[2] > 0
    np.testing.assert_allclose(only(motor, "zero"), only(output, "zero"))
    assert only(output, "resolution")[2] == pytest.approx(0.5e-3)
    assert only(output, "noise")[2] == pytest.approx(2e-4)
    assert only(output, "zero")[2] == pytest.approx(1e-4)


def test_a_count_is_anywhere_within_itself():
    """Within one count the position is uniform: deviation count/sqrt 12, and drawn at every visit,
    as noise is; zero is not.
    """
    found = terms_at(encoder(side="output", resolution=1e-3, zero=1e-4, noise=1e-5), condition())
    assert {term.name: term.level for term in found} == {
        "resolution": "visit",
        "noise": "visit",
        "zero": "robot",
    }
    count = drawn([term for term in found if term.name == "resolution"], 20_000)[:, 0, 2]
    assert count.std() == pytest.approx(1e-3 / math.sqrt(12), rel=0.02)
    assert np.abs(count).max() <= 0.5e-3


@pytest.mark.parametrize(("side", "waves"), [("motor", 20), ("output", 1)])
def test_eccentricity_goes_round_with_the_encoder(side: str, waves: int):
    """An eccentric disc errs once a turn of its own: once per output turn on the output, once per
    motor turn on the motor.
    """
    angles = np.linspace(0, 2 * np.pi, 128, endpoint=False)
    found = terms_at(encoder(side=side, eccentricity=1e-3, ratio=20), condition(angle=angles))
    lines = np.abs(np.fft.rfft(drawn(found, 10, poses=128)[:, :, 2], axis=1)) / 64
    np.testing.assert_allclose(lines[:, waves], 1e-3 / (20 if side == "motor" else 1), rtol=1e-9)
    assert np.delete(lines, waves, axis=1).max() < 1e-15


def test_an_encoder_on_the_output_sees_the_gearbox():
    """With an encoder on the output the controller takes away what a loaded gearbox does; on the
    motor it cannot see it.
    """
    geared, measured = (
        RevoluteJoint(
            name="A", limits=(-1, 1), gearbox=GEARED, encoder={"side": side, "noise": 1e-5}
        )
        for side in ("motor", "output")
    )
    assert set(geared.sources) == {"gearbox", "encoder"}
    arm = Arm(
        name="arm",
        joints=[measured.model_copy(update={"axis": "y"})],
        payload={"mass": 1.0, "centre_of_mass": (0.4, 0.0, 0.0)},
    )
    left = [
        (item.name, float(np.abs(twist).max()))
        for item, twist in at_tool(arm, [0.3])
        if "gearbox" in item.owner
    ]
    assert set(left) == {("joints.A.gearbox.backlash left open", 0.0)}
    assert set(measured.model_copy(update={"gearbox": None}).sources) == {"encoder"}
    exact = RevoluteJoint(
        name="A",
        limits=(-1, 1),
        gearbox={"stiffness": 1e4, "hysteresis": 1e-4},
        encoder={"side": "output"},
    )
    assert set(exact.sources) == {"encoder"}


def test_a_motor_encoder_takes_the_ratio_of_its_gearbox():
    """An encoder that states no ratio turns as often as the gearbox makes it; one that does, as it
    says.
    """
    joint = RevoluteJoint(name="A", limits=(-1, 1), gearbox=GEARED, encoder={"noise": 8e-4})
    assert only(terms_at(joint.sources["encoder"], condition()), "noise")[2] == pytest.approx(1e-5)
    stated = RevoluteJoint(
        name="A", limits=(-1, 1), gearbox=GEARED, encoder={"noise": 8e-4, "ratio": 8}
    )
    assert only(terms_at(stated.sources["encoder"], condition()), "noise")[2] == pytest.approx(1e-4)
    bare = RevoluteJoint(name="A", limits=(-1, 1), encoder={"noise": 8e-4})
    assert only(terms_at(bare.sources["encoder"], condition()), "noise")[2] == pytest.approx(8e-4)


def sliding(**fields: object) -> PrismaticJoint:
    """Return a sliding joint with these parts."""
    return PrismaticJoint(name="S", limits=(0, 1), **fields)


def test_an_encoder_on_the_motor_of_a_screw_states_lengths_at_the_slide():
    """On a sliding joint no ratio divides what an encoder states: counts, noise and eccentricity
    are lengths at the slide.
    """
    fields = {"resolution": 1e-5, "noise": 2e-6, "eccentricity": 3e-6, "zero": 1e-5}
    joint = sliding(gearbox={"ratio": 4, "lead": 0.01}, encoder=fields)
    found = terms_at(joint.sources["encoder"], condition(axis=SLIDE_Z))
    sizes = {term.name: only(found, term.name)[5] for term in found}
    assert sizes == pytest.approx(
        {
            "resolution": 5e-6,
            "noise": 2e-6,
            "eccentricity 1 sine": 0,
            "eccentricity 1 cosine": 3e-6,
            "zero": 1e-5,
        },
    )


@pytest.mark.parametrize(
    ("drive", "own", "period"),
    [
        ({"ratio": 4, "lead": 0.01}, {}, 0.0025),
        ({"lead": 0.01}, {"ratio": 2}, 0.005),
        ({"lead": 0.01}, {"lead": 0.02}, 0.02),
        (None, {"lead": 0.02}, 0.02),
    ],
)
def test_eccentricity_on_a_screw_comes_back_with_the_motors_turn(drive, own, period):
    """A motor that turns 4 times per turn of a screw of 10 mm lead has the same error every 2.5 mm;
    the encoder's own values precede the drive's.
    """
    found = terms_at(
        sliding(gearbox=drive, encoder={"eccentricity": 3e-6, **own}).sources["encoder"],
        condition(axis=SLIDE_Z, angle=np.linspace(0, period, 64, endpoint=False)),
    )
    lines = np.abs(np.fft.rfft(drawn(found, 10, poses=64)[:, :, 5], axis=1)) / 32
    np.testing.assert_allclose(lines[:, 1], 3e-6, rtol=1e-9)
    assert np.delete(lines, 1, axis=1).max() < 1e-15


@pytest.mark.parametrize(
    ("fields", "why"),
    [
        ({"encoder": {"eccentricity": 3e-6}}, "eccentricity without a lead on a sliding joint"),
        (
            {"encoder": {"eccentricity": 3e-6}, "gearbox": {"ratio": 4}},
            "eccentricity without a lead on a sliding joint",
        ),
        (
            {"encoder": {"eccentricity": 3e-6, "side": "output"}, "gearbox": {"lead": 0.01}},
            "eccentricity of an encoder along the slide",
        ),
    ],
)
def test_eccentricity_on_a_slide_needs_something_that_turns(fields: dict[str, object], why: str):
    """Without a lead nobody knows how often an encoder turns, and a scale along the slide never
    does; without eccentricity no lead is asked for.
    """
    with pytest.raises(ValidationError) as caught:
        sliding(**fields)
    (error,) = caught.value.errors()
    assert error["loc"] == ("encoder",)
    assert error["ctx"]["why"] == why
    assert error["ctx"]["expected"]
    assert "=" in error["ctx"]["example"]
    assert (
        sliding(**{**fields, "encoder": {"noise": 1e-6, "eccentricity": 0.0}}).encoder is not None
    )
