"""Predictions of a controller against closed forms, and what it answers to inputs that are not
valid.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import ndtr

import lostmotion
from lostmotion import Arm
from lostmotion.controller_model.accurate_percentile import accurate95
from lostmotion.controller_model.controller import (
    INPUT,
    JOINT_PLAY,
    LOAD,
    OK,
    OPEN_PLAY,
    OVERLOAD,
    RANGE,
)
from lostmotion.controller_model.percentile import percentile95
from lostmotion.mechanism.arm import MOST_JOINTS
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.analytic import analytic
from lostmotion.units import Toleranced
from tests.parts.random_arms import EXAMPLES, random_poses

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "controller: 95th percentile of a normal vector's length, closed form and accurate",
        "Imhof's integral, 40 random vectors; integration over two axes, 60 random vectors",
        "1.5 %; 0.2 %",
        "controller_model/accurate_percentile.py",
    ),
)


def one_joint(*, length=1.0, payload=10.0, **gearbox):
    """Return an arm with one horizontal axis and a payload (kg) at the end of a rigid link (m)."""
    joint = {
        "name": "A",
        "type": "revolute",
        "axis": "-y",
        "limits": (-3.0, 3.0),
        "gearbox": {"kind": "catalogue", "ratio": 100.0, **gearbox},
    }
    return Arm(
        name="one joint",
        joints=[{**joint, "link": {"length": length, "direction": "x", "rigid": True}}],
        payload={"mass": payload},
    )


def share_below(length, mean, variances):
    """Return the share of normal vectors with these means and variances along principal axes that
    are shorter than a length.

    J. Imhof, Biometrika 48 (1961) 419.
    """
    scale = mean @ mean + variances.sum()
    x = length**2 / scale
    axes = [(m2 / scale, s / scale) for m2, s in zip(mean**2, variances, strict=True)]

    def integrand(u):  # of plain numbers: it is called some ten thousand times
        angle, product, exponent = -0.5 * x * u, 1.0, 0.0
        for m2, s in axes:
            root = 1 + (s * u) ** 2
            angle += 0.5 * (math.atan(s * u) + m2 * u / root)
            product *= root
            exponent += 0.5 * m2 * s * u**2 / root
        return math.sin(angle) / (u * product**0.25 * math.exp(exponent))

    top = 2000.0
    total, _ = quad(integrand, 1e-12, top, limit=4000, epsabs=1e-7)
    return 0.5 - total / math.pi


@pytest.mark.parametrize(
    ("mean", "variances", "value", "exact"),
    [
        ((1, 0, 0), (1, 1, 1), 3.183275, 3.194142),
        ((3, 4, 0), (1, 1, 1), 6.813623, 6.816239),
        ((1, 0, 0), (1, 0, 0), 2.612954, 2.646146),
        ((0, 0, 0), (1, 1, 1), 2.788369, math.sqrt(7.814728)),
        ((3, 4, 0), (0, 0, 0), 5.0, 5.0),
    ],
)
def test_percentile_of_reference_cases(mean, variances, value, exact):
    """The 95th percentile has the published form to six digits and is within 1.5 % of the exact
    one; its unit does not matter.
    """
    for unit in (1.0, 1e-6, 1e3):
        found = (
            percentile95(
                unit * np.array([mean], float), unit**2 * np.diag(variances).astype(float)[None]
            )[0]
            / unit
        )
        assert found == pytest.approx(value, rel=2e-7)
        assert found == pytest.approx(exact, rel=0.015)


def test_percentile_of_any_normal_vector():
    """The exact share of vectors shorter than it, by Imhof's integral, reaches 95 % within ±1.5 %
    of the length; axes may be rotated.
    """
    rng = np.random.default_rng(4)
    for _ in range(40):
        variances = 10.0 ** rng.uniform(-2, 0, 3)
        mean = rng.normal(size=3) * rng.uniform(0, 4)
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        found = percentile95((turn @ mean)[None], (turn * variances @ turn.T)[None])[0]
        assert (
            share_below(0.985 * found, mean, variances)
            < 0.95
            < share_below(1.015 * found, mean, variances)
        )


def exact_share_below(length, mean, variances):
    """Return the share of normal vectors shorter than a length: exact along the axis of the largest
    variance, by points up to five deviations along the others, beyond which lie 1e-6 of them.
    """
    order = np.argsort(-variances)
    (m, m2, m3), (s, s2, s3) = mean[order], np.sqrt(variances[order])
    z2, z3 = np.linspace(-5, 5, 751), np.linspace(-5, 5, 189)
    w2, w3 = np.exp(-(z2**2) / 2), np.exp(-(z3**2) / 2)
    rest = length**2 - (m2 + s2 * z2[:, None]) ** 2 - (m3 + s3 * z3) ** 2
    half = np.sqrt(np.maximum(rest, 0.0))
    inside = np.where(rest > 0, ndtr((half - m) / s) - ndtr((-half - m) / s), 0.0)
    return w2 @ inside @ w3 / (w2.sum() * w3.sum())


def test_accurate_percentile_of_any_normal_vector():
    """The exact share reaches 95 % within ±0.2 % of the length: variances that differ by up to 1e5,
    means of 0 to 30 deviations, rotated axes.
    """
    rng = np.random.default_rng(8)
    for trial in range(60):
        variances = np.array([1.0, *10.0 ** rng.uniform(-5, 0, 2)])
        mean = (
            rng.normal(size=3) * rng.uniform(0, 3 if trial % 2 else 20) * rng.integers(0, 2, size=3)
        )
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        offset, covariance = (turn @ mean)[None], (turn * variances @ turn.T)[None]
        found = accurate95(offset, covariance)[0]
        assert (
            exact_share_below(0.998 * found, mean, variances)
            < 0.95
            < exact_share_below(1.002 * found, mean, variances)
        )
        assert accurate95(1e-6 * offset, 1e-12 * covariance)[0] == pytest.approx(
            1e-6 * found, rel=1e-9
        )


def test_accurate_percentile_without_scatter():
    """A constant error has its own length, no error has none."""
    found = accurate95(
        np.array([[3.0, 4.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]),
        np.stack([np.zeros((3, 3))] * 2 + [np.eye(3)]),
    )
    np.testing.assert_allclose(found, [5.0, 0.0, 3.194142], rtol=2e-4)


def test_the_percentile_is_that_of_the_study_where_errors_are_nearly_normal():
    """UR5e: the study, which integrates the errors with their own distributions, has the same 95th
    percentile within 1.5 % at every pose.
    """
    arm = lostmotion.read(EXAMPLES / "ur5e.urdf")
    q = random_poses(arm, 64)
    study = analytic(arm, q, levels=(0.95,)).quantiles[:, 0]
    for accurate in (False, True):
        found = lostmotion.controller(arm, accurate_length=accurate).predict(q).length95
        np.testing.assert_allclose(found, study, rtol=0.015)
        assert np.median(np.abs(found / study - 1)) < 0.001


@pytest.mark.parametrize("force", [0.0, -30.0])
def test_a_servo_knows_the_weights_alone(force):
    """Fed forward 60 % of a weight, a servo droops by the rest of its torque and by all of that of
    a process force, in closed form at the command and at the wanted pose.
    """
    joint = {"name": "A", "type": "revolute", "axis": "-y", "limits": (-3.0, 3.0)}
    joint["servo"] = {"stiffness": 2e3, "gravity_compensation": 0.6}
    joint["link"] = {"length": 1.0, "direction": "x", "rigid": True}
    payload = {"mass": 10.0, "force": (0.0, 0.0, force)}
    arm = Arm(name="servo", joints=[joint], payload=payload)
    found = lostmotion.controller(arm)
    weight, q = 10.0 * 9.80665, np.array([[0.0], [0.5]])
    # the process force turns with the tool
    torque = 0.4 * weight * np.cos(q[:, 0]) - force
    np.testing.assert_allclose(found.predict(q).joints[:, 0], -torque / 2e3, rtol=1e-12)
    np.testing.assert_allclose(found.compensate(q).command[:, 0], q[:, 0] + torque / 2e3, rtol=1e-9)
    stands = state_of(arm, found.compensate(q).command).settled().frames[-1]
    np.testing.assert_allclose(stands, state_of(arm, q).frames[-1], atol=1e-9)


def test_wind_up_of_one_joint():
    """98.07 N m on 1e5 N m/rad wind up by 0.98 mrad and lower the tool by 0.98 mm; with two zones
    the maker's rule applies.
    """
    linear = lostmotion.controller(one_joint(stiffness=1e5)).predict([0.0])
    assert linear.torques == pytest.approx(98.0665)
    assert abs(linear.joints[0, 0]) == pytest.approx(9.80665e-4)
    assert linear.screw[0, 5] == pytest.approx(-9.80665e-4)
    zones = lostmotion.controller(one_joint(stiffness=[1e5, 2e5], zone_torques=[50.0])).predict(
        [0.0]
    )
    assert abs(zones.joints[0, 0]) == pytest.approx(5e-4 + 48.0665 / 2e5, rel=1e-12)


@pytest.mark.parametrize(
    ("torque", "side", "mean", "variance"),
    [
        (5.0, 0, 1e-3, 0.0),
        (1.0, 0, 0.0, 1e-6),
        (1.0, 1, -1e-3, 0.0),
        (1.0, -1, 1e-3, 0.0),
        (0.0, 0, 0.0, 1e-6),
    ],
)
def test_play_of_one_joint(torque, side, mean, variance):
    """A load above friction closes the play; below it the output rests behind the last motion, or
    at either end where that is not known.
    """
    arm = one_joint(backlash=2e-3, friction_torque=Toleranced(2.0), rated_torque=60.0)
    found = lostmotion.controller(arm).predict(
        [0.0], [torque / 9.80665, 0, 0, 0, 0, 0, 0, 0, 0, 0], side=[side]
    )
    sign = -np.sign(found.torques[0, 0]) if torque > 2 else 1.0
    assert found.joints[0, 0] == pytest.approx(sign * mean, abs=1e-15)
    assert found.covariance[0, 2, 2] == pytest.approx(variance, abs=1e-18)
    assert found.flags[0] == (0 if torque > 2 else OPEN_PLAY + JOINT_PLAY)


def test_flags_name_the_joints_whose_play_is_open():
    """Two joints with 2 N m of friction: a load of 3 N m on the first and 1 N m on the second
    leaves the play of the second open, and so on.
    """
    joint = one_joint(backlash=2e-3, friction_torque=Toleranced(2.0)).joints[0]
    arm = Arm(name="two joints", joints=[joint, joint.model_copy(update={"name": "B"})])
    model, open_play = (
        lostmotion.controller(arm, largest_payload=10.0),
        np.array([[0, 0], [0, 1], [1, 0], [1, 1]]),
    )
    # a force on the tool, one metre from the second joint and two from the first, and a moment
    for opens in open_play:
        first, second = np.where(opens, 1.0, 3.0)
        force = first - second
        found = model.predict([0.0, 0.0], [0, 0, 0, 0, 0, 0, -force, 0, second - force, 0])
        np.testing.assert_allclose(np.abs(found.torques[0]), [first, second])
        assert found.flags[0] == opens.any() * OPEN_PLAY + opens @ [JOINT_PLAY, 2 * JOINT_PLAY]


def test_flags_of_the_longest_arm_fit_into_an_integer_of_a_controller():
    """64 joints whose play is open: the first 29 have a flag each, and the sum of all flags is
    below 2^31.
    """
    joint = one_joint(backlash=2e-3, friction_torque=Toleranced(2.0)).joints[0]
    arm = Arm(
        name="many joints",
        joints=[joint.model_copy(update={"name": f"J{k}"}) for k in range(MOST_JOINTS)],
        gravity=0.0,
    )
    found = lostmotion.controller(arm).predict(np.zeros(MOST_JOINTS))
    assert (
        found.flags[0] == OPEN_PLAY + sum(JOINT_PLAY * 2**k for k in range(29)) < 2**31 - OVERLOAD
    )


def test_a_drive_above_its_rated_torque_is_flagged():
    """98 N m on a gearbox of 60 N m: the prediction holds, with a flag."""
    found = lostmotion.controller(one_joint(stiffness=1e5, rated_torque=60.0)).predict([0.0])
    assert found.status[0] == OK
    assert found.flags[0] == OVERLOAD


def test_inputs_that_are_not_valid_have_a_status_and_no_values():
    """What is not finite, a joint out of its range and a payload beyond the tables: all outputs are
    zero, and other poses are not affected.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    model, q = lostmotion.controller(arm), random_poses(arm, 9)
    load, gravity, side = (
        np.tile(model.tables.load, (9, 1)),
        np.tile(model.tables.gravity, (9, 1)),
        np.zeros_like(q),
    )
    clean = model.predict(q, load, gravity, side)
    q[1, 0], q[2, 1], q[3, 2] = np.nan, np.inf, arm.limits[2, 1] + 1e-6
    load[4, 0], load[5, 0], load[6, 2], gravity[7, 1], side[8, 0] = (
        2 * arm.payload.mass + 1e-3,
        -1e-9,
        np.nan,
        1e3,
        1.5,
    )
    for found in (
        model.predict(q, load, gravity, side),
        model.compensate(q, load, gravity, side).prediction,
    ):
        assert found.status.tolist() == [OK, INPUT, INPUT, RANGE, LOAD, LOAD, INPUT, LOAD, INPUT]
        for name in (
            "turn",
            "point",
            "torques",
            "joints",
            "elsewhere",
            "screw",
            "covariance",
            "mean_square",
            "length95",
            "jacobian",
        ):
            values = getattr(found, name)
            assert not values[1:].any()
            np.testing.assert_array_equal(values[0], getattr(clean, name)[0])


@pytest.mark.parametrize(("name", "size"), [("q", 4), ("load", 9), ("gravity", 2), ("side", 6)])
def test_an_array_of_another_shape_is_refused(name, size):
    """The message states the shape found and the shapes that are possible."""
    model = lostmotion.controller(EXAMPLES / "z-arm.toml")
    given = {"q": np.zeros(5), name: np.zeros(size)}
    with pytest.raises(ValueError, match=rf"{name} has shape \(.*{size}.*\); expected"):
        model.predict(**given)
