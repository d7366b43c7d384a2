"""The newest request is computed first, whatever was asked for before."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion import sample_poses
from lostmotion.live_view.session import ErrorOverWorkspace, Figures, LiveArm, Refused, Session

EXAMPLES = Path(__file__).parents[2] / "examples"
POSES = 256


@pytest.fixture
def session():
    """Return a session with the six-joint example at the middle of its ranges."""
    arm = lostmotion.read(EXAMPLES / "ur5e.urdf")
    return Session(arm, sample_poses(arm, POSES), np.zeros(6))


def complete(session):
    """Return the workspace after as many steps as it takes, and their number."""
    for count in range(1, 20):
        found = session.step()
        if isinstance(found, ErrorOverWorkspace):
            return found, count
    raise AssertionError("the workspace is not complete")


def test_the_pose_comes_first_and_the_workspace_after_it(session):
    """The first step shows the pose, the following ones compute the workspace, and then nothing is
    left to do.
    """
    first = session.step()
    assert isinstance(first, Figures)
    np.testing.assert_array_equal(first.q, np.zeros(6))
    found, _ = complete(session)
    assert len(found.points) == POSES
    assert session.step() is None


def test_the_newest_pose_wins(session):
    """Of a hundred moves of a slider between two steps the last one is computed; the others are
    not.
    """
    session.step()
    complete(session)
    for k in range(100):
        session.move_joint(2, 0.01 * k)
    found = session.step()
    assert found.q.tolist() == [0, 0, 0.99, 0, 0, 0]
    assert session.step() is None


def test_a_move_does_not_wait_for_the_workspace_and_does_not_restart_it(session):
    """A move in between costs the workspace one step."""
    session.step()
    undisturbed = complete(session)[1]
    session.choose(payload=3.0)
    session.step()
    session.step()
    session.move_joint(0, 0.5)
    assert isinstance(session.step(), Figures)
    assert complete(session)[1] == undisturbed - 1


def test_new_choices_replace_a_workspace_that_is_not_complete(session):
    """The workspace that arrives is that of the newest choices."""
    session.step()
    session.step()
    session.choose(payload=3.0, compensated=True)
    session.choose_gearbox("elbow_joint", "CSG-25-100")
    found = session.step()
    assert session.arm.payload.mass == 3.0
    assert session.arm.joints[2].gearbox.model == "CSG-25-100"
    assert not found.error.bias.any()
    whole, _ = complete(session)
    *_, expected = LiveArm(
        session.arm, sample_poses(session.arm, POSES), "load compensated"
    ).workspace()
    np.testing.assert_array_equal(whole.q95, expected.q95)


def test_poses_stay_within_the_limits(session):
    """A value beyond a limit is moved to the limit."""
    session.move(np.full(6, 100.0))
    np.testing.assert_allclose(session.step().q, session.arm.limits[:, 1])
    session.move_joint(1, -100.0)
    assert session.step().q[1] == session.arm.limits[1, 0]


def test_a_point_leads_the_tool_and_leaves_its_orientation(session):
    """With six drives; a point out of reach leads it towards that point, within the limits."""
    session.move(np.radians([20.0, -60.0, 70.0, -30.0, 40.0, 10.0]))
    before = session.step().at[-1]
    assert not session.led
    session.lead(before[:3, 3] + [0.03, -0.02, 0.01])
    after = session.step()
    assert session.led
    np.testing.assert_allclose(after.at[-1, :3, 3], before[:3, 3] + [0.03, -0.02, 0.01], atol=1e-8)
    np.testing.assert_allclose(after.at[-1, :3, :3], before[:3, :3], atol=1e-8)
    np.testing.assert_array_equal(session.q, after.q)
    session.lead(np.array([50.0, 0.0, 0.0]))
    far = session.step()
    assert far.at[-1, 0, 3] > after.at[-1, 0, 3]
    low, high = session.arm.limits.T
    assert ((low <= far.q) & (far.q <= high)).all()
    with pytest.raises(ValueError, match="finite"):
        session.lead(np.array([np.nan, 0.0, 0.0]))


def test_an_impossible_choice_is_refused_and_leaves_the_arm_as_it_was(session):
    """The reason is reported; the next move shows the arm before the choice."""
    before = session.step()
    session.choose_gearbox("elbow_joint", "RV-1E-7")
    refused = session.step()
    assert isinstance(refused, Refused)
    assert "RV-1E" in refused.reason
    session.move(np.zeros(6))
    np.testing.assert_array_equal(session.step().error.bias, before.error.bias)
    session.choose_section("elbow_joint", "tube 80 x 4 mm")
    assert isinstance(session.step(), Refused)
    session.choose_gearbox("elbow_joint", "as in the file")
    assert isinstance(session.step(), Figures)
    assert session.arm.joints[2].link.section.outer == 0.08


def test_waiting_ends_when_something_is_to_be_done(session):
    """A session with work does not wait; one without waits until a request arrives, here none."""
    session.wait(60)
    session.step()
    session.wait(60)
    complete(session)
    session.wait(0.01)
    session.move(np.ones(6))
    session.wait(60)


def test_a_closed_chain_moves_where_it_is_assembled():
    """A carriage of a delta moves its platform and its figures; a pose that its rods do not reach
    is refused with the reason, and the next one is computed.
    """
    arm = lostmotion.read(EXAMPLES / "closed-chains" / "delta-printer.toml")
    session = Session(arm, sample_poses(arm, 16), arm.home)
    assert isinstance(session.step(), Figures)
    complete(session)
    session.move(np.full(3, 0.29))
    tool = session.step().at[-1, :3, 3]
    np.testing.assert_allclose(tool[:2], 0, atol=1e-9)
    point = tool + np.array([0.02, -0.01, 0.005])
    session.lead(point)
    np.testing.assert_allclose(session.step().at[-1, :3, 3], point, atol=1e-8)
    session.move(np.array([0.37, 0.23, 0.37]))
    refused = session.step()
    assert isinstance(refused, Refused)
    assert "rod is outside its limits" in refused.reason
    session.move(np.full(3, 0.31))
    assert isinstance(session.step(), Figures)
