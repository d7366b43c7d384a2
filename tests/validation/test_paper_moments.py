"""Static moments of the Z-arm, eqs. (2) and (3) of S. Strutynskyi, R. Semenchuk,
doi:10.15587/2706-5448.2021.237326.

The printed sums carry misprints; these tests show what they must read, and what the root of their
squares means.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lostmotion.mechanism.arm import STANDARD_GRAVITY, Arm
from lostmotion.mechanism.holding_torques import worst_torques_over_tilts
from lostmotion.mechanism.state import state_of
from lostmotion.mechanism.tool import Payload
from lostmotion.parts.base import Base
from lostmotion.parts.joint import FixedJoint, RevoluteJoint

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "the paper's static moment, eqs. (2), (3)",
        "worst torque over tilts",
        "rounding",
    ),
)

LENGTHS = (0.4, 0.4, 0.2)  # AB, BC, CD, m


@dataclass(frozen=True)
class Weights:
    """Masses of links AB, BC, CD and of the nodes B, C, D and the payload Q, kg; the paper's sums
    take them as weights.
    """

    m2: float
    m3: float
    m4: float
    m_b: float
    m_c: float
    m_d: float
    payload: float


TYPICAL = Weights(m2=3.0, m3=2.5, m4=1.2, m_b=4.0, m_c=2.0, m_d=0.8, payload=5.0)
ANGLE = st.floats(-math.pi, math.pi)
MASS = st.floats(0, 20)


def z_arm(w: Weights, **base: float) -> Arm:
    """Return the arm from node A on, turning about -y, so that angles are measured upwards from the
    horizontal.
    """
    joints = [
        RevoluteJoint(
            name="A", limits=(-7, 7), axis="-y", link={"length": LENGTHS[0], "mass": w.m2}
        ),
        RevoluteJoint(
            name="B",
            limits=(-7, 7),
            axis="-y",
            mass=w.m_b,
            link={"length": LENGTHS[1], "mass": w.m3},
        ),
        RevoluteJoint(
            name="C",
            limits=(-7, 7),
            axis="-y",
            mass=w.m_c,
            link={"length": LENGTHS[2], "mass": w.m4},
        ),
        FixedJoint(name="D", mass=w.m_d),
    ]
    return Arm(name="Z-arm", joints=joints, payload=Payload(mass=w.payload), base=Base(**base))


def projections(phi: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return the link projections h (along X) and z (along Z) for link directions from the
    horizontal.
    """
    return np.array(LENGTHS) * np.cos(phi), np.array(LENGTHS) * np.sin(phi)


def q_of(phi: tuple[float, ...]) -> np.ndarray:
    """Turn link directions into joint angles."""
    return np.array([[phi[0], phi[1] - phi[0], phi[2] - phi[1]]])


def moment(p: np.ndarray, w: Weights) -> float:
    """Eq. (2) read properly: sum of weight times projection about A, N m. p holds h or z of links
    2, 3, 4.
    """
    p2, p3, p4 = p
    sums = (
        (w.payload + w.m_d) * (p2 + p3 + p4)
        + w.m4 * (p4 / 2 + p3 + p2)
        + w.m_c * (p3 + p2)
        + w.m3 * (p3 / 2 + p2)
        + w.m_b * p2
        + w.m2 * p2 / 2
    )
    return float(STANDARD_GRAVITY * sums)


def printed_x(h: np.ndarray, w: Weights) -> float:
    """Mx of eq. (2) as printed: D counted twice, B omitted, link 2 at the wrong lever."""
    h2, h3, h4 = h
    sums = (w.payload + w.m_d) * (h4 + h3 + h2) + w.m4 * (h4 / 2 + h3 + h2) + w.m_c * (h3 + h2)
    return float(
        STANDARD_GRAVITY
        * (sums + w.m3 * (h3 / 2 + h2) + w.m_d * (h2 + h3 + h4) + w.m2 * (h2 + h3 + h4 / 2))
    )


def printed_z(z: np.ndarray, w: Weights) -> float:
    """Mz of eq. (2) as printed, for the drawn pose in which link 4 points down (z4 is then a
    length): D where B belongs.
    """
    z2, z3, z4 = z[0], z[1], -z[2]
    sums = (
        (w.payload + w.m_d) * (z2 + z3 - z4)
        + w.m4 * (z3 + z2 - z4 / 2)
        + w.m_c * (z3 + z2)
        + w.m3 * (z3 / 2 + z2)
    )
    return float(STANDARD_GRAVITY * (sums + w.m_d * z2 + w.m2 * z2 / 2))


@given(st.tuples(ANGLE, ANGLE, ANGLE), st.builds(Weights, MASS, MASS, MASS, MASS, MASS, MASS, MASS))
@settings(deadline=None, max_examples=100)
def test_the_papers_root_is_the_worst_moment_over_all_tilts(phi: tuple[float, ...], w: Weights):
    """Eq. (3), the root of Mx^2 + Mz^2, is the largest moment that gravity can put on node A,
    whichever way the chassis leans.
    """
    h, z = projections(phi)
    worst = worst_torques_over_tilts(state_of(z_arm(w), q_of(phi)))[0, 0]
    assert worst == pytest.approx(math.hypot(moment(h, w), moment(z, w)), rel=1e-12, abs=1e-9)


@given(st.tuples(ANGLE, ANGLE, ANGLE))
@settings(deadline=None, max_examples=50)
def test_on_level_ground_only_mx_acts(phi: tuple[float, ...]):
    """On a level chassis the drive at A holds Mx; on its nose, pitched by a quarter turn, it bears
    Mz.
    """
    h, z = projections(phi)
    assert state_of(z_arm(TYPICAL), q_of(phi)).torques[0, 0] == pytest.approx(
        moment(h, TYPICAL), abs=1e-9
    )
    # Pitched about +y by a quarter turn, gravity points along the base's +x: masses above A want to
    # fall forwards.
    nose_down = state_of(z_arm(TYPICAL, pitch=math.pi / 2), q_of(phi)).torques[0, 0]
    assert nose_down == pytest.approx(moment(z, TYPICAL), abs=1e-9)


@given(st.tuples(ANGLE, ANGLE, ANGLE))
@settings(deadline=None, max_examples=20)
def test_some_tilt_reaches_the_worst_and_none_passes_it(phi: tuple[float, ...]):
    """Of all chassis pitches, one reaches the paper's root and none exceeds it."""
    pitches = np.linspace(-math.pi, math.pi, 721)
    arm, q = z_arm(TYPICAL), q_of(phi)
    down = STANDARD_GRAVITY * np.column_stack([np.sin(pitches), np.zeros(721), -np.cos(pitches)])
    by_axis = np.array([state_of(arm, q, gravity=unit).torques[0, 0] for unit in np.eye(3)])
    held = np.abs(down @ by_axis)
    worst = worst_torques_over_tilts(state_of(arm, q))[0, 0]
    assert held.max() <= worst * (1 + 1e-12)
    assert held.max() == pytest.approx(worst, rel=1e-4)


# The drawn pose of the paper's Fig. 5: up, forwards, and link 4 pointing down.
DRAWN = (math.radians(70), math.radians(10), math.radians(-60))


def test_the_printed_sums_do_not_balance():
    """As printed, eq. (2) counts node D twice and node B not at all: both sums differ from the
    moment that statics gives, Mx by a fifth and more.
    """
    h, z = projections(DRAWN)
    held = state_of(z_arm(TYPICAL), q_of(DRAWN)).torques[0, 0]
    assert moment(h, TYPICAL) == pytest.approx(held, rel=1e-12)
    assert abs(printed_x(h, TYPICAL) / held - 1) > 0.2
    assert abs(printed_z(z, TYPICAL) / moment(z, TYPICAL) - 1) > 0.05
    worst = worst_torques_over_tilts(state_of(z_arm(TYPICAL), q_of(DRAWN)))[0, 0]
    assert abs(math.hypot(printed_x(h, TYPICAL), printed_z(z, TYPICAL)) / worst - 1) > 0.01


def test_the_misprints_are_those_named():
    """Setting node B and D and link 2 to nothing, the printed sums agree with statics: nothing else
    is misprinted.
    """
    h, z = projections(DRAWN)
    bare = Weights(m2=0.0, m3=2.5, m4=1.2, m_b=0.0, m_c=2.0, m_d=0.0, payload=5.0)
    assert printed_x(h, bare) == pytest.approx(moment(h, bare), rel=1e-12)
    assert printed_z(z, bare) == pytest.approx(moment(z, bare), rel=1e-12)
    with_two = Weights(m2=3.0, m3=2.5, m4=1.2, m_b=0.0, m_c=2.0, m_d=0.0, payload=5.0)
    assert printed_z(z, with_two) == pytest.approx(moment(z, with_two), rel=1e-12)
    assert printed_x(h, with_two) != pytest.approx(moment(h, with_two), rel=1e-2)
