"""The picture of the first screen: the arm at its worst pose, in the cut through its workspace."""

from __future__ import annotations

import re

import numpy as np
import pytest

from lostmotion.analyses.accuracy.plots import arm as picture
from lostmotion.propagation.montecarlo import kernel
from lostmotion.reporting.palette import LIGHT
from lostmotion.reporting.svg import inline_svg
from tests.test_plots import small_study


def test_cut_holds_the_values_of_the_poses_near_each_cell():
    """For values that are linear in the place, a cell has nearly the value of its own place; outside the workspace there is none."""
    points = np.random.default_rng(1).uniform(-1, 1, (200_000, 3))
    points = points[np.linalg.norm(points, axis=1) < 1]
    view = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    across, up, values = picture._cut(points, points[:20_000], points[:20_000] @ [0.0, 2.0, 0.0], view, 0.2, 0.05)
    y, z = np.meshgrid((across[1:] + across[:-1]) / 2, (up[1:] + up[:-1]) / 2, indexing="ij")
    known = np.isfinite(values)
    inside = np.hypot(y, z) < 0.85
    assert known[inside].all()
    assert not known[np.hypot(y, z) > 1.1].any()
    assert values[inside] == pytest.approx(2 * y[inside], abs=0.1)  # 16 poses lie within 60 mm


def test_view_contains_the_axis_of_the_base_and_the_tool():
    """The plane of the cut contains the vertical through the base and the tool; a flat workspace is seen from above."""
    points = np.random.default_rng(2).uniform(-1, 1, (100, 3))
    tool = np.array([0.3, -0.4, 0.5])
    view, _ = picture._view(points, tool, 2.0)
    assert view @ view.T == pytest.approx(np.eye(3))
    assert view @ tool == pytest.approx([0.5, 0.5, 0.0])
    assert (picture._view(points * [1, 1, 0.01], tool, 2.0)[0] == np.eye(3)).all()


@pytest.mark.parametrize(("most", "factor"), [(0.3, 1), (1.0, 1), (4.9, 2), (151, 100), (200, 200), (999, 500)])
def test_the_error_is_drawn_larger_by_a_round_factor(most, factor):
    """A reader can divide by 1, 2 or 5 times a power of ten."""
    assert picture._factor(most) == factor


def test_the_picture_shows_arm_arrow_and_classes():
    """The arrow is the mean error of the worst pose times the stated factor, and every colour of the picture is one of the palette."""
    study = small_study()
    shown = picture.arm_in_workspace(study)
    worst = int(study.sampled.per_pose[:, kernel.MEAN].argmax())
    (arrow,) = shown.figure.axes[0].texts
    view, _ = picture._view(study.workspace.points, study.tool[worst], float(np.ptp(study.workspace.points, axis=0).max()))
    factor = float(re.search(r"drawn (\d+) times", shown.words)[1])
    drawn = np.array(arrow.xy) - arrow.xyann
    assert drawn == pytest.approx(1e3 * factor * view[:2] @ study.sampled.bias[worst, 3:])
    assert not set(re.findall(r"#[0-9a-f]{6}", inline_svg(shown))) & set(LIGHT.values())
    assert "var(--c" in inline_svg(shown)
