"""Arms with a single source of error, whose figures follow by hand: a harmonic, a scattered play."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lostmotion.error_model.bounds import root_sum_square, worst_case
from lostmotion.error_model.budget import Tally, costs
from lostmotion.error_model.pose_matrix import screws
from lostmotion.error_model.poses import sample_poses
from lostmotion.mechanism.arm import Arm
from lostmotion.parts.joint import RevoluteJoint
from lostmotion.propagation.analytic import analytic
from lostmotion.propagation.montecarlo import montecarlo
from tests.parts.conditions import ARCMIN

LEVER = 0.5


def turning(**parts: object) -> Arm:
    """Return a vertical joint with a rigid, weightless link: no load, so that a play is free."""
    return Arm(name="one", joints=[RevoluteJoint(name="A", axis="z", limits=(-3, 3), link={"length": LEVER}, **parts)])


@pytest.mark.parametrize("angle", [0.0, 0.1, 0.55, 2.0])
def test_a_harmonic_is_at_most_its_amplitude(angle: float):
    """Sine and cosine of one phase are never both at their limits: at every angle the largest transmission error of 0.6' peak to peak is 0.3'."""
    matrix = screws(turning(gearbox={"transmission_error": 0.6 * ARCMIN, "ratio": 121}), np.array([[angle]]))
    assert worst_case(matrix)[0] == pytest.approx(LEVER * 0.3 * ARCMIN, rel=1e-12)
    assert root_sum_square(matrix)[0] == pytest.approx(LEVER * 0.3 * ARCMIN, rel=1e-12)


@pytest.mark.parametrize(("law", "deviations"), [("uniform", math.sqrt(3)), ("normal", 3 / 0.98658)])
@pytest.mark.parametrize("approach", [0.0, 1.0])
def test_a_scattered_play_turns_the_tool_by_half_its_mean_square_size(law: str, deviations: float, approach: float):
    """Free play of 2' ± 1' leaves the output half the play off the middle: mean square 1' squared plus (0.5' / limit in deviations) squared.

    Which side is chance or the last motion; the size differs between robots either way. At worst the output is 1.5' off.
    """
    arm = turning(gearbox={"backlash": f"2 arcmin ± 1 arcmin ({law})"})
    expected = ARCMIN**2 * (1 + (0.5 / deviations) ** 2)
    found = montecarlo.run(arm, sample_poses(arm, 8), 64, 4, 1, approach=approach)
    np.testing.assert_allclose(found.rotation_ms, expected, rtol=1e-5)
    matrix = screws(arm, np.zeros((1, 1)), approach=approach)
    (cost,) = costs(Tally.of(matrix))
    assert cost.alone == pytest.approx(LEVER * math.sqrt(expected), rel=1e-5)
    assert worst_case(matrix)[0] == pytest.approx(LEVER * 1.5 * ARCMIN, rel=1e-12)


def test_coming_down_is_the_other_side_of_coming_up():
    """A play of 2' leaves the output 1' behind the last motion: up and down the tool is 1' off to opposite sides, and 2' apart."""
    arm, q = turning(gearbox={"backlash": "2 arcmin"}), np.array([[0.0]])
    up, down = (analytic(arm, q, approach=sign) for sign in (1.0, -1.0))
    np.testing.assert_allclose(up.bias, [[0.0, -LEVER * ARCMIN, 0.0]], atol=1e-15)
    np.testing.assert_array_equal(down.bias, -up.bias)
    assert up.mean == down.mean == pytest.approx(LEVER * ARCMIN, rel=1e-9)
