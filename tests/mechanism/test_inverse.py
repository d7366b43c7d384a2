"""Inverse kinematics: poses reported as reached are reached within the joint limits, and the
Jacobian is the derivative of the frames.
"""

from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model.poses import sample_poses
from lostmotion.mechanism.inverse import (
    REACHED,
    inverse_kinematics,
    pose_difference,
    tool_and_jacobian,
)
from lostmotion.mechanism.inverse_kernel import write_tool_and_jacobian
from lostmotion.mechanism.state import state_of

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="module")
def six():
    """Return an arm of six joints."""
    return lostmotion.read(EXAMPLES / "ur5e.urdf")


def test_the_jacobian_is_the_derivative_of_the_frames(six):
    """The Jacobian equals central differences of the tool's pose by each joint value."""
    q = sample_poses(six, 8, "uniform", 3).q
    found, step = tool_and_jacobian(six, q)[1], 1e-6
    for k in range(q.shape[1]):
        moved = np.eye(q.shape[1])[k] * step
        slope = pose_difference(
            state_of(six, q - moved).frames[-1], state_of(six, q + moved).frames[-1]
        ) / (2 * step)
        assert found[:, :, k] == pytest.approx(slope, abs=1e-8)


def test_compiled_forward_kinematics_equals_the_last_frame():
    """Compiled and plain forward kinematics agree on the examples and on an arm of turning, sliding
    and fixed joints with tilted axes and a tool.
    """
    joints = [
        {
            "name": "A",
            "type": "revolute",
            "axis": (1.0, 2.0, -0.5),
            "limits": (-3.0, 3.0),
            "link": {"tip": {"xyz": (0.1, 0.2, 0.3), "rpy": (0.1, -0.7, 2.0)}},
        },
        {"name": "B", "type": "fixed", "origin": {"xyz": (0.0, 0.1, 0.0), "rpy": (1.0, 0.0, 0.3)}},
        {
            "name": "C",
            "type": "prismatic",
            "axis": (0.0, 1.0, 1.0),
            "limits": (-0.3, 0.5),
            "origin": {"xyz": (0.2, 0.0, -0.1)},
        },
        {
            "name": "D",
            "type": "revolute",
            "axis": "-y",
            "limits": (-2.0, 2.0),
            "link": {"tip": {"xyz": (0.4, 0.0, 0.0), "rpy": (0.0, 0.5, 0.0)}},
        },
        {"name": "E", "type": "fixed"},
    ]
    tool = {"frame": {"xyz": (0.0, 0.05, 0.1), "rpy": (0.2, 0.0, 0.0)}}
    arms = [lostmotion.Arm.model_validate({"name": "mixed", "joints": joints, "tool": tool})]
    arms += [lostmotion.read(EXAMPLES / name) for name in ("z-arm.toml", "ur5e.urdf")]
    for arm in arms:
        q = sample_poses(arm, 64, "uniform", 5).q
        found, jacobian = tool_and_jacobian(arm, q)
        assert np.abs(found - state_of(arm, q).frames[-1]).max() < 1e-14
        slope = np.stack(
            [
                pose_difference(
                    *(
                        state_of(arm, q + end * np.eye(q.shape[1])[k]).frames[-1]
                        for end in (-1e-6, 1e-6)
                    )
                )
                / 2e-6
                for k in range(q.shape[1])
            ],
            axis=-1,
        )
        assert jacobian == pytest.approx(slope, abs=1e-8)


@pytest.mark.parametrize("turned", [True, False])
def test_a_pose_reported_as_reached_is_reached(six, turned):
    """From starts 0.1 rad away nearly all poses are found; every pose reported as reached is
    reached within the joint limits.
    """
    q = sample_poses(six, 400, "uniform", 4).q
    wanted = state_of(six, q).frames[-1]
    start = q + np.random.default_rng(0).normal(0, 0.1, q.shape)
    found, reached = inverse_kinematics(six, wanted, start, with_orientation=turned)
    assert reached.mean() > 0.99
    miss = pose_difference(state_of(six, found).frames[-1], wanted)[:, slice(0 if turned else 3, 6)]
    assert np.abs(miss[reached]).max() < REACHED
    low, high = six.limits.T
    assert (found >= low).all()
    assert (found <= high).all()


def test_out_of_reach_is_reported(six):
    """A point two metres away is reported as not reached."""
    wanted = np.eye(4)[None].copy()
    wanted[0, :3, 3] = 2.0, 0.0, 0.3
    assert not inverse_kinematics(
        six, wanted, six.limits.mean(axis=1)[None], with_orientation=False
    )[1].any()


@pytest.mark.parametrize("way", [-1, 1])
def test_a_joint_at_its_limit_does_not_stop_the_others(way):
    """With one of four slides at either limit, a slide along the same direction reaches the point
    beyond in as many steps as alone.
    """
    slide = {"type": "prismatic", "limits": ("-300 mm", "300 mm")}
    joints = [
        {**slide, "name": name, "axis": axis}
        for name, axis in (("X", "x"), ("Y", "y"), ("Z", "z"), ("U", "x"))
    ]
    arm = lostmotion.Arm.model_validate({"name": "slides", "joints": joints})
    wanted = np.eye(4)[None].copy()
    wanted[0, :3, 3] = way * 0.5, 0.1, 0.2
    q, reached = inverse_kinematics(
        arm, wanted, np.array([[way * 0.3, 0.0, 0.0, 0.0]]), with_orientation=False, steps=12
    )
    assert reached.all()
    assert q[0, 0] + q[0, 3] == pytest.approx(way * 0.5, abs=1e-9)


def test_compiled_forward_kinematics_stays_within_its_arrays():
    """Run by the interpreter, which checks every index, the kernel raises no error and returns what
    the compiled one does.
    """
    step = np.tile(np.eye(4), (3, 1, 1))
    step[:, 0, 3] = 0.4
    turning, sliding, q = (
        np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]),
        np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]),
        np.array([[0.5, 0.1]]),
    )
    interpreted, compiled = ((np.empty((1, 4, 4)), np.empty((1, 6, 2))) for _ in range(2))
    write_tool_and_jacobian.py_func(q, step, turning, sliding, *interpreted)
    write_tool_and_jacobian(q, step, turning, sliding, *compiled)
    for one, other in zip(interpreted, compiled, strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-15)
    np.testing.assert_allclose(
        interpreted[0][0, :3, 3], [0.4 + 0.9 * np.cos(0.5), 0.9 * np.sin(0.5), 0.0], atol=1e-15
    )
