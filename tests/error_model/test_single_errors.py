"""Arms with a single source of error, a harmonic or a scattered play, whose figures follow by
hand.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from lostmotion.error_model.bounds import bounds, worst_case
from lostmotion.error_model.budget import Tally, costs
from lostmotion.error_model.pose_matrix import screws
from lostmotion.error_model.poses import sample_poses
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.state import state_of
from lostmotion.parts.joint import RevoluteJoint
from lostmotion.propagation.analytic import analytic
from lostmotion.propagation.montecarlo import montecarlo
from tests.parts.conditions import ARCMIN

LEVER = 0.5


def turning(**parts: object) -> Arm:
    """Return an arm of one vertical joint with a rigid, massless link, whose play no load
    closes.
    """
    return Arm(
        name="one",
        joints=[RevoluteJoint(name="A", axis="z", limits=(-3, 3), link={"length": LEVER}, **parts)],
    )


@pytest.mark.parametrize("angle", [0.0, 0.1, 0.55, 2.0])
def test_a_harmonic_is_at_most_its_amplitude(angle: float):
    """The worst case of a transmission error of 0.6' peak to peak is 0.3' at every angle, because
    sine and cosine share their phase.
    """
    matrix = screws(
        state_of(
            turning(gearbox={"transmission_error": 0.6 * ARCMIN, "ratio": 121}), np.array([[angle]])
        )
    )
    assert worst_case(matrix)[0] == pytest.approx(LEVER * 0.3 * ARCMIN, rel=1e-12)
    assert bounds(matrix).root_sum_square[0] == pytest.approx(LEVER * 0.3 * ARCMIN, rel=1e-12)


@pytest.mark.parametrize(
    ("law", "deviations"), [("uniform", math.sqrt(3)), ("normal", 3 / 0.98658)]
)
@pytest.mark.parametrize("approach", [0.0, 1.0])
def test_a_scattered_play_has_the_mean_square_of_its_half_width(
    law: str, deviations: float, approach: float
):
    """A free play of 2' ± 1' has the mean square of its half-width: 1' squared plus (0.5' / limit
    in deviations) squared.

    The side is random or that of the last motion, the size varies between robots, and the worst
    case is 1.5'.
    """
    arm = turning(gearbox={"backlash": f"2 arcmin ± 1 arcmin ({law})"})
    expected = ARCMIN**2 * (1 + (0.5 / deviations) ** 2)
    found = montecarlo.run(arm, sample_poses(arm, 8), 64, 4, 1, approach=approach)
    np.testing.assert_allclose(found.rotation_ms, expected, rtol=1e-5)
    matrix = screws(state_of(arm, np.zeros((1, 1))), approach=approach)
    (cost,) = costs(Tally.of(matrix))
    assert cost.alone == pytest.approx(LEVER * math.sqrt(expected), rel=1e-5)
    assert worst_case(matrix)[0] == pytest.approx(LEVER * 1.5 * ARCMIN, rel=1e-12)


def test_upward_and_downward_last_motions_have_opposite_errors():
    """A play of 2' displaces the tool by 1' behind its last motion, to opposite sides for upward
    and downward motions.
    """
    arm, q = turning(gearbox={"backlash": "2 arcmin"}), np.array([[0.0]])
    up, down = (analytic(arm, q, approach=sign) for sign in (1.0, -1.0))
    np.testing.assert_allclose(up.bias, [[0.0, -LEVER * ARCMIN, 0.0]], atol=1e-15)
    np.testing.assert_array_equal(down.bias, -up.bias)
    assert up.mean == down.mean == pytest.approx(LEVER * ARCMIN, rel=1e-9)
