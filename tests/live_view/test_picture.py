"""Colour classes, camera, first pose, clicks and the texts of the panel."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion import sample_poses
from lostmotion.error_model.budget import Cost
from lostmotion.io.pose_and_zone_text import read_pose
from lostmotion.live_view import panel
from lostmotion.live_view.picture import (
    COLOURS,
    Framing,
    classes_of,
    enlargement,
    first_pose,
    picked,
    visible,
)
from lostmotion.live_view.session import LiveArm
from lostmotion.mechanism.state import state_of, tool_points
from lostmotion.printed import round_number

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.mark.parametrize(
    ("value", "expected"),
    [(0.0013, 0.001), (0.0016, 0.002), (3.0, 2.0), (3.3, 5.0), (8.0, 10.0), (1.0, 1.0)],
)
def test_round_numbers_are_1_2_and_5_times_a_power_of_ten(value, expected):
    """The nearest one by ratio."""
    assert round_number(value) == pytest.approx(expected)


def test_classes_have_round_limits_over_the_range_of_the_errors():
    """Errors from 0.3 to 1.5 mm have classes of 0.2 mm; the smallest errors have the first colour,
    the largest the last.
    """
    errors = np.linspace(0.3e-3, 1.5e-3, 500)
    classes = classes_of(errors)
    np.testing.assert_allclose(classes.limits, np.arange(4, 16, 2) * 1e-4)
    colours = classes.colours(np.array([0.0, classes.limits[0], 1e-3 + 1e-9, 2e-3]))
    assert ["#{:02x}{:02x}{:02x}".format(*each) for each in colours] == [
        COLOURS[0],
        COLOURS[1],
        COLOURS[4],
        COLOURS[6],
    ]
    # at the ends of the classes
    assert re.findall(r">([\d.]*)</span></span>", panel.legend(classes)) == [
        "0.4",
        "0.6",
        "0.8",
        "1",
        "1.2",
        "1.4",
        "",
    ]
    assert "within, mm<" in panel.legend(classes)


def test_an_arm_without_errors_has_one_class_and_no_enlargement():
    """Nothing is divided by zero."""
    classes = classes_of(np.zeros(10))
    assert {tuple(each) for each in classes.colours(np.zeros(10)).tolist()} == {(0, 78, 71)}
    assert enlargement(np.zeros(10), 2.0) == 1.0


def test_errors_of_one_size_have_classes_too():
    """A workspace with the same error everywhere."""
    classes = classes_of(np.full(10, 1e-3))
    assert all(low < high for low, high in zip(classes.limits, classes.limits[1:], strict=False))


def test_a_typical_error_is_drawn_as_a_twentieth_of_the_picture():
    """The factor is round, so the length lies within the step of round numbers around 6 %."""
    errors = np.full(5, 1.2e-3)
    factor = enlargement(errors, 3.0)
    assert factor in {50.0, 100.0, 200.0, 500.0}
    assert 0.03 < factor * 1.2e-3 / 3.0 < 0.1


def test_an_arm_above_its_workspace_is_in_the_picture():
    """The rails of a gantry are not part of its base, and its workspace is not around it."""
    arm = lostmotion.read(EXAMPLES / "gantry.toml")
    poses = sample_poses(arm, 64)
    framing = Framing.of(arm, tool_points(arm, poses.q), poses.q[0])
    at = state_of(arm, poses.q[:1]).frames[:, 0]
    corners = np.concatenate(
        [body.corners() @ at[body.place, :3, :3].T + at[body.place, :3, 3] for body in arm.bodies]
    )
    assert (np.linalg.norm(corners - framing.middle, axis=1) <= framing.size / 2 + 1e-9).all()
    # From the camera every corner and tool point is within 90 % of its angle of view, and one is at
    # the edge.
    ahead = (framing.middle - framing.camera) / np.linalg.norm(framing.middle - framing.camera)
    seen = np.concatenate([corners, tool_points(arm, poses.q), np.zeros((1, 3))]) - framing.camera
    depth = seen @ ahead
    aside = np.linalg.norm(seen - np.multiply.outer(depth, ahead), axis=1)
    assert (aside / depth).max() == pytest.approx(0.9 * math.tan(math.radians(75 / 2)), rel=1e-9)
    assert 0.3 < len(visible(tool_points(arm, poses.q), "half", framing.size)) / 64 < 0.6


@pytest.mark.parametrize("file", ["z-arm.toml", "ur5e.urdf", "arm-from-drawings.toml"])
def test_the_first_pose_shows_the_arm_above_its_base(file):
    """No place of the arm is below the base, and the tool is neither at the axis nor at full
    stretch; base and workspace are in the picture.
    """
    arm = lostmotion.read(EXAMPLES / file)
    poses = sample_poses(arm, 512)
    q = first_pose(arm, poses)
    at = state_of(arm, q[None]).frames[:, 0, :3, 3]
    points = tool_points(arm, poses.q)
    assert at[:, 2].min() > -0.02
    assert 0.3 < np.hypot(*at[-1, :2]) / np.hypot(*points[:, :2].T).max() < 0.9
    framing = Framing.of(arm, points, q)
    assert np.linalg.norm(framing.camera - framing.middle) < framing.size
    assert (np.linalg.norm(points - framing.middle, axis=1) <= framing.size / 2 + 1e-9).all()
    assert framing.floor <= 0


def test_a_click_means_the_first_point_near_the_ray():
    """Points beside the ray and behind the camera do not count."""
    points = np.array([[2.0, 0, 0], [1.0, 0.01, 0], [-1.0, 0, 0], [0.5, 0.2, 0]])
    assert picked(np.zeros(3), np.array([3.0, 0, 0]), points, 1.0) == 1
    assert picked(np.zeros(3), np.array([-1.0, 0, 0]), points, 1.0) == 2
    assert picked(np.zeros(3), np.array([0, 0, 1.0]), points, 1.0) is None


def test_half_of_the_workspace_is_that_behind_the_arm():
    """A plane workspace has no half behind it and is shown whole."""
    points = np.array([[0, -1.0, 0], [0, 0, 0], [0, 1.0, 0]])
    assert visible(points + np.array([0, 5, 0]), "half", 2.0).tolist() == [2]
    assert visible(points, "half", 2.0).tolist() == [2]
    assert visible(points, "all", 2.0).tolist() == [0, 1, 2]
    assert visible(points, "none", 2.0).tolist() == []
    assert visible(points * [1, 0.01, 1], "half", 2.0).tolist() == [0, 1, 2]


def test_the_printed_pose_is_read_as_the_same_pose():
    """As `--at` of a study, for turning and sliding joints."""
    joints = [
        {"type": "prismatic", "name": "lift", "limits": (-0.5, 0.7)},
        {"type": "revolute", "name": "r2/waist", "limits": (-3.0, 3.0)},
    ]
    arm = lostmotion.Arm.model_validate({"name": "two", "joints": joints})
    for q in np.random.default_rng(1).uniform(arm.limits[:, 0], arm.limits[:, 1], (20, 2)):
        option = panel.pose_option(arm, q)
        np.testing.assert_allclose(
            read_pose(re.fullmatch('--at "(.*)"', option)[1], arm), q, atol=1e-9
        )


def test_names_of_a_file_cannot_become_page_content():
    """A joint may have any printable name; the panel shows it as text."""
    name = "<img src=x onerror=alert(1)>"
    text = panel.budget_bars([Cost(f"joints.{name}.link", 1e-3, 1.0, 1e-3, (1.0, 0.0, 0.0))])
    assert "<img" not in text
    assert "&lt;img" in text
    assert "<b>" not in panel.warning("<b>") + panel.text_to_copy("<b>")


def test_a_part_that_cancels_others_extends_to_the_left():
    """Shares of 120 % and -20 %: both bars begin at the zero line, a seventh of the width from the
    left.
    """
    costs = [
        Cost("joints.A.link", 1e-3, 1.2, 1e-3, (1.2, 0.0, 0.0)),
        Cost("joints.B.link", 1e-3, -0.2, 1e-3, (-0.2, 0.0, 0.0)),
    ]
    bars = re.findall(r"margin-left:([\d.]+)%;width:([\d.]+)%", panel.budget_bars(costs))
    assert [tuple(map(float, each)) for each in bars] == [(14.3, 85.7), (0.0, 14.3)]


def test_the_panel_shows_the_figures_with_three_digits():
    """The error at the pose and over the workspace, and torques above their rating in red."""
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    poses = sample_poses(arm, 64)
    live = LiveArm(arm, poses)
    found = live.figures(poses.q[0])
    *_, over_all = live.workspace()
    text = panel.headline(found, over_all, 200.0)
    assert re.search(r'id="lm-q95"[^>]*>([\d.]+) mm<', text)[1] == f"{found.q95 * 1e3:.3g}"
    assert "arrow: mean error, ellipsoid: 95 % of errors; both 200 × larger" in text
    assert "both at 0.5 of their size" in panel.headline(found, over_all, 0.5)
    bars = panel.torque_bars(arm, found)
    assert [
        re.search(rf">{joint.name}<.*?>([\d.]+) N m, (\d+) %<", bars).groups()
        for joint in arm.joints[1:3]
    ] == [
        (f"{abs(torque):.3g}", f"{100 * load:.0f}")
        for torque, load in zip(found.torques[1:3], found.loads[1:3], strict=True)
    ]
    assert ">…<" in panel.headline(found, None, None)
    assert "#ff9a6b" not in panel.torque_bars(arm, found)
    heavy = arm.with_payload(arm.payload.model_copy(update={"mass": 100.0}))
    assert "#ff9a6b" in panel.torque_bars(heavy, LiveArm(heavy, poses).figures(poses.q[0]))
    assert not math.isnan(found.loads[1])
