"""How much of the computed error a compensated joint command leaves."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
from scipy.optimize import brentq

import lostmotion
from lostmotion.controller_model.controller import LARGEST_STEP, OK, SINGULAR
from lostmotion.controller_model.prediction import frames
from lostmotion.controller_model.remainder import reached, remainder
from lostmotion.error_model.pose_matrix import screws
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.exact import compose
from tests.controller_model.test_prediction import one_joint
from tests.parts.random_arms import EXAMPLES, random_arm

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "controller: compensated command",
        (
            "exact composition of the expected errors, 1 500 poses of the UR5e: share that "
            "remains after one pass"
        ),
        "median 0.2 %, worst 1 % away from singular poses",
    ),
)


@functools.cache
def case(name):
    """Return an arm, its controller and 1 500 poses within ±2.8 rad and the limits."""
    arm = lostmotion.read(EXAMPLES / name)
    low, high = np.clip(arm.limits, -2.8, 2.8).T
    q = np.random.default_rng(2).uniform(low + 0.02, high - 0.02, size=(1500, len(low)))
    return arm, lostmotion.controller(arm), q


def composed(arm, command):
    """Return the tool points (pose, 3) of a robot that has exactly its expected errors, with exact
    composition of all frames.
    """
    matrix = screws(state_of(arm, command))
    draws = np.array([float(info.level == "design") for info in matrix.infos])
    return compose(
        matrix,
        np.arange(len(command)),
        np.broadcast_to(draws[:, None], (len(command), len(draws), 1)),
    )[:, 0, :3, 3]


def shares(model, q, plant, **options):
    """Return the share of the error (pose,) that remains, and the smallest singular value of the
    position Jacobian.
    """
    found = model.compensate(q, **options)
    wanted = found.prediction.point
    before, after = (
        np.linalg.norm(plant(values) - wanted, axis=1) for values in (q, found.command)
    )
    return after / before, np.linalg.svd(found.prediction.jacobian[:, 3:], compute_uv=False)[:, -1]


def test_one_pass_leaves_a_thousandth_of_the_error():
    """UR5e with 5 kg, away from singular poses: median 0.2 %, 95th percentile 0.5 %, worst 1 %;
    also with exact composition of the errors.
    """
    arm, model, q = case("ur5e.urdf")
    for plant in (functools.partial(reached, model), functools.partial(composed, arm)):
        share, regular = shares(model, q, plant)
        share = share[regular > 0.1]
        assert np.median(share) <= 2e-3
        assert np.quantile(share, 0.95) <= 5e-3
        assert share.max() <= 1e-2


def test_the_readme_of_an_export_measures_what_remains():
    """Median, 95th percentile and worst case at regular poses, as measured here pose by pose;
    without a regular pose there are none.
    """
    _, model, q = case("ur5e.urdf")
    share, regular = shares(model, q, functools.partial(reached, model))
    share = share[regular > 0.1]
    found = remainder(model, q, 1)
    assert found == pytest.approx(
        (len(share), np.median(share), np.quantile(share, 0.95), share.max())
    )
    assert remainder(model, q[regular <= 0.1], 1).poses == 0


def test_damping_and_the_largest_step_are_options():
    """More damping takes smaller steps near singular poses and leaves more; a smaller largest step
    is never exceeded; other values are refused.
    """
    _, model, q = case("ur5e.urdf")
    q = q.copy()
    q[:, 4] = 1e-3  # two axes of the wrist nearly in line
    usual, damped, short = (
        model.compensate(q, **each) for each in ({}, {"damping": 1e-2}, {"largest_step": 1e-4})
    )
    steps = [
        np.abs(each.command - q + each.prediction.joints).max(axis=1)
        for each in (usual, damped, short)
    ]
    left = [np.linalg.norm(each.left[:, 3:], axis=1) for each in (usual, damped, short)]
    assert np.median(steps[1]) < np.median(steps[0])
    assert np.median(left[1]) > 10 * np.median(left[0])
    assert steps[2].max() <= 1e-4 * (1 + 1e-9)
    assert (short.status == SINGULAR).any()
    for wrong in (
        {"damping": 0.0},
        {"damping": math.nan},
        {"largest_step": -1.0},
        {"largest_step": math.inf},
    ):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            model.compensate(q, **wrong)


@pytest.mark.parametrize("name", ["ur5e.urdf", "z-arm.toml"])
def test_two_passes_leave_next_to_nothing(name):
    """The second pass removes the change of the load and the curvature: a median of 1e-5
    remains.
    """
    _, model, q = case(name)
    share, regular = shares(model, q, functools.partial(reached, model), passes=2)
    assert np.median(share[regular > 0.1]) <= 1e-5


@pytest.mark.parametrize(
    "options", [{}, {"passes": 2}, {"whole_pose": True}, {"largest_step": 0.0}], ids=str
)
@pytest.mark.parametrize(
    "name",
    ["ur5e.urdf", "z-arm.toml", "scara.toml", "palletiser.toml", "planar-2r.toml", "six-axis.toml"],
)
def test_compensation_is_never_worse_than_none(name, options):
    """At singular poses, at joint limits and with short steps less is removed, and nothing is
    added; the steps for bending stay within their cap.
    """
    _, model, q = case(name)
    rng, limits = np.random.default_rng(3), np.clip(model.tables.limits, -2.8, 2.8)
    # stretched, folded, with axes in line or nearly so, and at the limits
    for joint, (low, high) in enumerate(limits):
        special = rng.choice([0.0, math.pi / 2, -math.pi / 2, low, high], len(q)) + rng.choice(
            [0.0, 0.0, 1e-4, -1e-3, 1e-2, -3e-2], len(q)
        )
        q = np.where(
            (rng.random(len(q)) < 0.35)[:, None] & (np.arange(len(limits)) == joint),
            np.clip(special, low, high)[:, None],
            q,
        )
    found = model.compensate(q, **options)
    assert set(found.status) <= {OK, SINGULAR}
    if "whole_pose" in options:  # a rotation counts as the displacement at a tenth of a metre
        weight = np.array([0.1, 0.1, 0.1, 1, 1, 1])
        before, after = (
            np.linalg.norm(each * weight, axis=1) for each in (found.prediction.screw, found.left)
        )
        assert (after <= before).all()
    else:
        share, _ = shares(model, q, functools.partial(reached, model), **options)
        assert share.max() <= 1.0
    if "passes" not in options:  # what deflects along the joints is no step
        steps = np.abs(found.command - q + found.prediction.joints)[found.status == OK]
        assert (
            steps.max(initial=0.0) <= options.get("largest_step", LARGEST_STEP) * (1 + 1e-9) + 1e-15
        )


@pytest.mark.parametrize("name", ["ur5e.urdf", "scara.toml", "printed-hobby-arm.toml"])
def test_what_is_left_is_reported(name):
    """The reported remainder is the error of a robot whose deflections stay as they were; their
    change is about the step times the error.
    """
    _, model, q = case(name)
    found = model.compensate(q)
    start = found.prediction
    frozen = (
        frames(model.tables, found.command + start.joints)[1][-1]
        + start.elsewhere[:, 3:]
        - start.point
    )
    whole = found.status == OK
    assert np.abs(frozen - found.left[:, 3:])[whole].max() <= 1e-7
    after = reached(model, found.command) - start.point
    before, step = np.linalg.norm(start.screw[:, 3:], axis=1), np.abs(found.command - q).max(axis=1)
    if name == "ur5e.urdf":
        assert (np.linalg.norm(after - found.left[:, 3:], axis=1) <= 5 * step * before).all()


def test_a_second_pass_that_finds_more_error_sends_no_correction():
    """Where the command changes the sign of a torque and a play turns over, one pass cannot know;
    two leave the command as it was.
    """
    arm = random_arm(2)
    model, q = (
        lostmotion.controller(arm),
        [[-0.67606, 1.42549, 1.8415, -1.00156, 0.46803, -0.39174]],
    )
    once, twice = (model.compensate(q, passes=passes) for passes in (1, 2))
    before, after = (
        np.linalg.norm(reached(model, each) - once.prediction.point)
        for each in (np.asarray(q), once.command)
    )
    assert after > 1.5 * before
    np.testing.assert_array_equal(twice.command, q)
    assert twice.status[0] == SINGULAR


def test_a_wound_up_drive_is_compensated_in_its_joint():
    """Of 0.98 mrad at the horizontal 4.7e-10 rad remains after one pass, a (1 - cos a); at 45
    degrees half the square of the wind-up.
    """
    model = lostmotion.controller(one_joint(stiffness=1e5))
    found = model.compensate([[0.0], [math.pi / 4]])
    remains = found.command[:, 0] + model.predict(found.command).joints[:, 0] - [0.0, math.pi / 4]
    assert abs(remains[0]) == pytest.approx(4.7e-10, rel=0.02)
    assert abs(remains[1]) == pytest.approx(0.5 * (98.0665 / 1e5) ** 2, rel=1e-2)
    assert (found.status == OK).all()


def test_a_rounding_at_a_limit_is_no_cut():
    """At its limit a joint whose correction is rounding leaves the status as it is."""
    _, model, q = case("scara.toml")
    q = q.copy()
    q[:, 0], q[:, 1] = np.where(q[:, 0] > 0, *model.tables.limits[0][::-1]), 0.0
    found = model.compensate(q)
    at_limit = np.abs(found.command[:, 0] - q[:, 0]) < 1e-15
    assert (found.status[at_limit] == OK).mean() > 0.9
    assert at_limit.any()


def test_a_command_stays_within_the_limits_and_reports_it():
    """At a limit the command is cut, and what it then leaves is the whole wind-up."""
    arm = one_joint(stiffness=1e5)
    arm = arm.model_copy(
        update={"joints": (arm.joints[0].model_copy(update={"limits": (-1.0, 0.0)}),)}
    )
    found = lostmotion.controller(arm).compensate([0.0])
    assert found.command[0, 0] == 0.0
    assert found.status[0] == SINGULAR
    assert found.left[0, 5] == pytest.approx(-9.80665e-4)


@pytest.mark.parametrize("stiffness", [200.0, 400.0, 1000.0])
def test_where_a_soft_joint_settles_one_pass_is_exact_and_two_are_not(tmp_path, stiffness):
    """A spring K under T cos(a) settles where K (c - a) = T cos(a): at q after one pass, (T/K)^2
    sin(q) cos(q) below it after two.
    """
    path = tmp_path / "soft.toml"
    path.write_text(
        'name = "soft"\n[payload]\nmass = "5.5 kg"\n[[joints]]\nname = "A"\ntype = "revolute"\n'
        'axis = "-y"\nlimits = ["-90 deg", "90 deg"]\n'
        f'gearbox = {{ ratio = 100, stiffness = "{stiffness} N m/rad", friction_torque = "0 N '
        f'm" }}\n'
        'link = { length = "200 mm", rigid = true, mass = "0 kg" }\n',
        encoding="utf-8",
    )
    model, q, droop = lostmotion.controller(path), 0.8, 5.5 * 9.80665 * 0.2 / stiffness
    sent = [float(model.compensate([q], passes=passes).command[0, 0]) for passes in (1, 2)]
    settled = [
        brentq(lambda a, c: c - a - droop * math.cos(a), -2, 2, args=(command,), xtol=1e-14)
        for command in sent
    ]
    assert settled[0] == pytest.approx(q, abs=1e-9)
    assert q - settled[1] == pytest.approx(droop**2 * math.sin(q) * math.cos(q), rel=0.1)
