"""How much of the computed error a compensated joint command leaves."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import lostmotion
from lostmotion.controller_model.compensation import LARGEST_STEP
from lostmotion.controller_model.controller import OK, SINGULAR
from lostmotion.controller_model.remainder import reached, remainders
from lostmotion.error_model.pose_matrix import screws
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.exact import compose
from tests.controller_model.equilibrium import soft_arm
from tests.controller_model.test_prediction import one_joint
from tests.parts.random_arms import EXAMPLES

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "controller: compensated command",
        (
            "exact composition of the expected errors, 500 poses of the UR5e: share that "
            "remains after one pass"
        ),
        "median 0.2 %, worst 1 % away from singular poses",
    ),
    (
        "controller: compensated command of a soft arm",
        "equilibrium of arms of 2 to 7 joints by SciPy's rotations and iteration",
        "drives alone: 1e-9 of the error after one pass; every part elastic: 2e-5 after two",
    ),
)


@functools.cache
def case(name):
    """Return an arm, its controller and 500 poses within ±2.8 rad and the limits."""
    arm = lostmotion.read(EXAMPLES / name)
    low, high = np.clip(arm.limits, -2.8, 2.8).T
    q = np.random.default_rng(2).uniform(low + 0.02, high - 0.02, size=(500, len(low)))
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
    for plant in (functools.partial(reached, arm), functools.partial(composed, arm)):
        share, regular = shares(model, q, plant)
        share = share[regular > 0.1]
        assert np.median(share) <= 2e-3
        assert np.quantile(share, 0.95) <= 5e-3
        assert share.max() <= 1e-2


def test_the_readme_of_an_export_measures_what_remains():
    """Median, 95th percentile and worst case at regular poses, as measured here pose by pose;
    without a regular pose there are none.
    """
    arm, model, q = case("ur5e.urdf")
    q = q[:100]
    share, regular = shares(model, q, functools.partial(reached, arm))
    share = share[regular > 0.1]
    found, _ = remainders(model, arm, q)
    assert found == pytest.approx(
        (len(share), np.median(share), np.quantile(share, 0.95), share.max())
    )
    assert remainders(model, arm, q[regular <= 0.1])[0].poses == 0


def test_damping_and_the_largest_step_are_options():
    """More damping takes smaller steps near singular poses and leaves more; so does a smaller
    largest step, but for steps as large as the bending; other values are refused.
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
    bends = np.linalg.norm(short.prediction.elsewhere[:, 3:], axis=1) / 0.1
    assert (steps[2] <= np.maximum(1e-4, bends) * (1 + 1e-9))[short.status == OK].all()
    assert steps[2].max() < 0.6 * steps[0].max()
    assert (short.status == SINGULAR).any()
    for wrong in (
        {"damping": 0.0},
        {"damping": math.nan},
        {"largest_step": -1.0},
        {"largest_step": math.inf},
    ):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            model.compensate(q, **wrong)


@pytest.mark.parametrize(
    "options", [{}, {"passes": 2}, {"whole_pose": True}, {"largest_step": 0.0}], ids=str
)
@pytest.mark.parametrize(
    "name",
    ["ur5e.urdf", "z-arm.toml", "scara.toml", "planar-2r.toml"],
)
def test_compensation_is_never_worse_than_none(name, options):
    """At singular poses, at joint limits and with short steps less is removed, and nothing is
    added; the steps for bending stay within their cap.
    """
    arm, model, q = case(name)
    q = q[:300]
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
        assert (after <= 1.005 * before + 1e-12).all()  # that before is of first order
    else:
        share, _ = shares(model, q, functools.partial(reached, arm), **options)
        assert share.max() <= 1 + 1e-6
    if "passes" not in options:  # what deflects along the joints is no step
        steps = np.abs(found.command - q + found.prediction.joints).max(axis=1)
        bends = np.linalg.norm(found.prediction.elsewhere * [0.1, 0.1, 0.1, 1, 1, 1], axis=1) / 0.1
        most = np.maximum(options.get("largest_step", LARGEST_STEP), bends)
        assert (steps <= most * (1 + 1e-9) + 1e-15)[found.status == OK].all()


def test_the_cap_of_a_step_does_not_touch_bending():
    """A soft link whose tip sags by 4 % of the reach takes steps of 40 mrad at regular poses, and
    no pose is reported as reduced.
    """
    arm = soft_arm(7, 7, droop=0.0, bend=0.02)
    model, q = lostmotion.controller(arm.described()), regular_poses(arm, 7)
    found = model.compensate(q)
    assert np.abs(found.command - q).max() > 4 * LARGEST_STEP
    assert (found.status == OK).all()


def regular_poses(arm, seed, count=200):
    """Return poses (pose, joint) of a soft arm whose position Jacobian has no singular value below
    0.1 m.
    """
    q = np.random.default_rng(seed).uniform(-2.5, 2.5, (count, len(arm.axes)))
    step = 1e-6
    columns = [
        (arm.moved(q + each)[1][:, -1] - arm.moved(q - each)[1][:, -1]) / (2 * step)
        for each in step * np.eye(q.shape[1])
    ]
    singular = np.linalg.svd(np.stack(columns, 2), compute_uv=False)[:, -1]
    return q[singular > 0.1]


def settled_errors(arm, found, q, side=None):
    """Return the errors (pose,), m, of an uncompensated and a compensated arm in equilibrium, and
    the poses at which both have one.
    """
    wanted, errors, settles = arm.moved(q)[1][:, -1], [], True
    for command in (q, found.command):
        _, point, change = arm.settled(command, side)
        errors.append(np.linalg.norm(point - wanted, axis=1))
        settles = settles & (change < 1e-10)
    return (*errors, settles)


@pytest.mark.parametrize("passes", [1, 2])
@pytest.mark.parametrize(("joints", "droop"), [(2, 0.2), (3, 0.1), (6, 0.05), (7, 0.1)])
def test_where_only_drives_wind_up_one_pass_is_exact(joints, droop, passes):
    """Drives that droop by up to 3 to 11 degrees leave less than 1e-9 of the error, at singular
    poses too; a second pass changes nothing.
    """
    arm = soft_arm(joints, joints, droop=droop)
    model = lostmotion.controller(arm.described())
    q = np.random.default_rng(joints).uniform(-2.5, 2.5, (200, joints))
    found = model.compensate(q, passes=passes)
    before, after, settles = settled_errors(arm, found, q)
    assert settles.all()
    assert (after <= 1e-9 * before + 1e-14).all()
    assert (found.status == OK).all()
    assert np.median(before) > 1e-3


@pytest.mark.parametrize(("joints", "bend"), [(5, 0.003), (6, 0.003), (7, 0.005)])
def test_where_every_part_bends_two_passes_leave_next_to_nothing(joints, bend):
    """Drives, bearings and links, with errors of some millimetres per metre of reach: below 1e-5 of
    the error, of which one pass leaves up to some per cent.
    """
    arm = soft_arm(joints, joints, droop=0.02, bend=bend)
    model, q = lostmotion.controller(arm.described()), regular_poses(arm, joints)
    once, twice = (settled_errors(arm, model.compensate(q, passes=passes), q) for passes in (1, 2))
    assert len(q) > 50
    assert (twice[1] <= 1e-5 * twice[0]).all()
    assert np.median(once[1] / once[0]) > 10 * np.median(twice[1] / twice[0])
    assert np.median(once[0]) > 2e-3


def special_poses(joints, seed, count):
    """Return poses of which a third of the joints are stretched, folded, in line or at a limit."""
    rng = np.random.default_rng(seed)
    special = rng.choice([0.0, math.pi / 2, -math.pi / 2, -3.0, 3.0], (count, joints))
    special += rng.choice([0.0, 0.0, 1e-4, -1e-3, 1e-2, 3e-2, -1e-2], (count, joints))
    usual = rng.uniform(-2.8, 2.8, (count, joints))
    return np.clip(np.where(rng.random((count, joints)) < 0.35, special, usual), -3, 3)


@pytest.mark.parametrize(
    ("joints", "soft", "count", "passes"),
    [
        pytest.param(*arm, count, passes, marks=[pytest.mark.slow] if count > 1_000 else [])
        for number, arm in enumerate(
            (
                (2, {"droop": 0.05, "play": 0.01}),
                (4, {"droop": 0.02, "bend": 0.005, "play": 0.01}),
                (6, {"droop": 0.05, "bend": 0.02}),
                (6, {"droop": 0.02, "bend": 0.002, "play": 0.005}),
            )
        )
        # one pass at few poses and two at many, or the other way round
        for count, passes in ((200, 1 + number % 2), (2_000, 2 - number % 2))
    ],
    ids=str,
)
def test_a_soft_arm_never_stands_farther_off(joints, soft, count, passes):
    """At limits, singular poses, and where a play turns over: in equilibrium no command leaves more
    than the wanted joint values, with known and unknown last motions.
    """
    arm = soft_arm(joints, joints, **soft)
    model, q = lostmotion.controller(arm.described()), special_poses(joints, joints, count)
    side = np.random.default_rng(1).integers(-1, 2, q.shape).astype(float)
    found = model.compensate(q, side=side, passes=passes)
    before, after, settles = settled_errors(arm, found, q, side)
    assert settles.mean() > 0.95
    assert (after <= before * (1 + 1e-9) + 1e-12)[settles].all()
    assert np.median(after / before) < 0.05


def test_a_play_that_turns_over_late_adds_nothing():
    """A drive of a soft arm is just loaded enough to close its play where the arm stands, and not
    yet two steps before: the command that adds to the error is not sent.
    """
    arm = soft_arm(41, 6, droop=0.1, bend=0.01, play=0.003)
    row = slice(820, 821)
    q = special_poses(6, 41, 3_000)
    side = np.random.default_rng(1).integers(-1, 2, q.shape).astype(float)[row]
    found = lostmotion.controller(arm.described()).compensate(q[row], side=side, passes=2)
    before, after, settles = settled_errors(arm, found, q[row], side)
    assert settles.all()
    assert after <= before * (1 + 1e-9)


def test_what_is_left_is_what_the_equilibrium_leaves():
    """The remainder that is reported, of one pass and of two, is the error of the arm in
    equilibrium to a few thousandths of the whole error; its rotation as well.
    """
    arm = soft_arm(6, 6, droop=0.02, bend=0.005)
    model, q = lostmotion.controller(arm.described()), regular_poses(arm, 6)
    for passes, share in ((1, 5e-3), (2, 5e-5)):
        found = model.compensate(q, passes=passes)
        turn, point, _ = arm.settled(found.command)
        wanted, at = (each[:, -1] for each in arm.moved(q))
        spin = Rotation.from_matrix(turn @ wanted.transpose(0, 2, 1)).as_rotvec()
        whole = np.linalg.norm(found.prediction.screw[:, 3:], axis=1)
        assert (np.linalg.norm(point - at - found.left[:, 3:], axis=1) <= share * whole).all()
        assert np.abs(spin - found.left[:, :3]).max() <= share


@pytest.mark.parametrize("wanted", [(0, 0), (30, 40), (60, -90), (-20, 100)], ids=str)
def test_an_elbow_stands_where_it_is_wanted(wanted):
    """Links of 0.25 m, 0.4 kg at the elbow and 0.3 kg at the tip, drives of 30 and 15 N m/rad: sent
    what the drives wind up by at the wanted pose, in closed form, the arm stands there.
    """
    q = np.radians([wanted])
    first, both = 0.25 * np.cos(q[0, 0]), 0.25 * np.cos(q[0].sum())
    torques = 9.80665 * np.array([0.7 * first + 0.3 * both, 0.3 * both])
    model = lostmotion.controller(elbow())
    for passes in (1, 2):
        command = model.compensate(q, passes=passes).command[0]
        np.testing.assert_allclose(command, q[0] + torques / [30.0, 15.0], atol=1e-14)


def elbow():
    """Return a two-joint arm in the vertical plane with point masses at elbow and tip."""
    drives = (30.0, 15.0)
    return lostmotion.Arm(
        name="elbow",
        joints=[
            {
                "name": name,
                "type": "revolute",
                "axis": "-y",
                "limits": (-3.0, 3.0),
                "gearbox": {"kind": "catalogue", "ratio": 100.0, "stiffness": stiffness},
                "link": {
                    "length": 0.25,
                    "rigid": True,
                    "mass": mass,
                    "centre_of_mass": (0.25, 0.0, 0.0),
                },
            }
            for name, stiffness, mass in zip("AB", drives, (0.4, 0.0), strict=True)
        ],
        payload={"mass": 0.3},
    )


@pytest.mark.parametrize(
    ("wanted", "sent"), [(0, 16.85639), (30, 44.59806), (60, 68.42819), (85, 86.46913)]
)
def test_a_drooping_joint_stands_where_it_is_wanted(wanted, sent):
    """0.5 kg at 0.3 m on a drive of 5 N m/rad: published commands to five digits, and where the arm
    then stands by K (c - a) = T cos(a).
    """
    model = lostmotion.controller(one_joint(stiffness=5.0, length=0.3, payload=0.5))
    command = float(model.compensate([math.radians(wanted)]).command[0, 0])
    assert math.degrees(command) == pytest.approx(sent, abs=5e-6)
    torque = 0.5 * 9.80665 * 0.3
    stands = brentq(lambda a: 5.0 * (command - a) - torque * math.cos(a), -2, 2, xtol=1e-14)
    assert math.degrees(stands) == pytest.approx(wanted, abs=1e-9)


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
