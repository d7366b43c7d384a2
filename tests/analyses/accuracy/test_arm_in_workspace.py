"""The pictures of the first screen: the arm at its worst and at its best pose, in a cut through its
workspace and in space.
"""

from __future__ import annotations

import base64
import gzip
import json
import re
from dataclasses import replace

import numpy as np
import pytest

import lostmotion
from lostmotion.analyses.accuracy.page import arm_plots as picture
from lostmotion.analyses.accuracy.page.plots import pose_errors
from lostmotion.mechanism.state import tool_points
from lostmotion.propagation.analytic import analytic
from lostmotion.propagation.montecarlo import kernel
from lostmotion.reporting.page.viewer import viewer
from lostmotion.reporting.palette import LIGHT
from lostmotion.reporting.svg import inline_svg
from lostmotion.reporting.workspace_cells import cells_in_space, cells_of_cut
from tests.arms import STIFF, small_study


def ball() -> np.ndarray:
    """Return many points in a ball of 1 m."""
    points = np.random.default_rng(1).uniform(-1, 1, (200_000, 3))
    return points[np.linalg.norm(points, axis=1) < 1]


def scene_of(study):
    """Return the scene of a study and what the page's script draws of it."""
    scene = next(picture.arm_in_workspace(pose_errors(study))).scene
    return scene, json.loads(
        re.search(r'<script type="application/json">(.*?)</script>', viewer(scene))[1]
    )


def test_cut_holds_the_values_of_the_poses_near_each_cell():
    """For values that are linear in the place, a cell has nearly the value of its own place;
    outside the workspace there is none.
    """
    points = ball()
    view = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    across, up, values = cells_of_cut(
        points, points[:20_000], points[:20_000] @ [0.0, 2.0, 0.0], view, 0.2, 0.05
    )
    y, z = np.meshgrid((across[1:] + across[:-1]) / 2, (up[1:] + up[:-1]) / 2, indexing="ij")
    known = np.isfinite(values)
    inside = np.hypot(y, z) < 0.85
    assert known[inside].all()
    assert not known[np.hypot(y, z) > 1.1].any()
    assert values[inside] == pytest.approx(2 * y[inside], abs=0.1)  # 16 poses lie within 60 mm


def test_values_that_do_not_depend_on_the_azimuth_are_compared_at_all_azimuths():
    """With 300 poses, 16 of which span 0.7 m in space: about a vertical axis a cell of the cut has
    the value of its own distance and height.
    """
    points = ball() + np.array([0.2, 0.0, 0.0])
    tool, view = points[:300], np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    radius = np.hypot(tool[:, 0] - 0.2, tool[:, 1])
    off = []
    for axis in (None, (0.2, 0.0)):
        across, up, values = cells_of_cut(points, tool, radius, view, 0.0, 0.05, axis)
        x, z = np.meshgrid((across[1:] + across[:-1]) / 2, (up[1:] + up[:-1]) / 2, indexing="ij")
        inside = (np.hypot(x - 0.2, z) < 0.8) & (np.abs(x - 0.2) > 0.2)
        off.append(np.abs(values - np.abs(x - 0.2))[inside].max())
    assert off[1] < 0.12 < off[0]


def test_cells_in_space_fill_the_workspace_and_hold_the_values_near_them():
    """The cells of a ball have its volume, and values that are linear in the place; a flat
    workspace is one layer about its plane.
    """
    points = ball()
    low, values = cells_in_space(points, points[:20_000], points[:20_000] @ [0.0, 2.0, 0.0], 0.05)
    known = np.isfinite(values)
    centres = low + 0.05 * (np.argwhere(known) + 0.5)
    # cells that the surface crosses count whole
    assert known.sum() * 0.05**3 == pytest.approx(4 / 3 * np.pi, rel=0.12)
    inside = np.linalg.norm(centres, axis=1) < 0.85
    assert values[known][inside] == pytest.approx(2 * centres[inside, 1], abs=0.1)
    low, values = cells_in_space(points * [1, 1, 0], points[:100] * [1, 1, 0], np.zeros(100), 0.05)
    assert values.shape[2] == 1
    assert low[2] == pytest.approx(-0.025)


def test_view_contains_the_axis_of_the_base_and_the_tool():
    """The plane of the cut contains the vertical through the base and the tool; a flat workspace is
    seen from above.
    """
    tool = np.array([0.3, -0.4, 0.5])
    view, _ = picture._view(tool, flat=False)
    assert view @ view.T == pytest.approx(np.eye(3))
    assert view @ tool == pytest.approx([0.5, 0.5, 0.0])
    assert (picture._view(tool, flat=True)[0] == np.eye(3)).all()


@pytest.mark.parametrize(
    ("most", "factor"), [(0.3, 1), (1.0, 1), (4.9, 2), (151, 100), (200, 200), (999, 500)]
)
def test_the_error_is_drawn_larger_by_a_round_factor(most, factor):
    """A reader can divide by 1, 2 or 5 times a power of ten."""
    assert picture._factor(most) == factor


def test_the_pictures_show_arm_arrow_and_classes():
    """Each arrow is the mean error of its pose times the stated factor, the same in both, and every
    colour is one of the palette.
    """
    study = small_study()
    means = study.sampled.per_pose[:, kernel.MEAN]
    factors = set()
    for shown, pose in zip(
        picture.arm_in_workspace(pose_errors(study)), (means.argmax(), means.argmin()), strict=True
    ):
        (arrow,) = shown.figure.axes[0].texts
        view, _ = picture._view(study.tool[pose], flat=False)
        factors.add(float(re.search(r"drawn (\d+) times", shown.words)[1]))
        drawn = np.array(arrow.xy) - arrow.xyann
        assert drawn == pytest.approx(1e3 * max(factors) * view[:2] @ study.sampled.bias[pose, 3:])
        assert not set(re.findall(r"#[0-9a-f]{6}", inline_svg(shown))) & set(LIGHT.values())
        assert "var(--c" in inline_svg(shown)
    assert len(factors) == 1


def test_the_scene_has_the_errors_of_its_poses():
    """Arrow and ellipsoid are mean and covariance by the analytic route, which computes them apart,
    times the stated factor.
    """
    study = small_study()
    scene, data = scene_of(study)
    assert [pose.name for pose in scene.poses] == ["worst pose", "best pose"]
    known = analytic(study.arm, np.array([pose.q for pose in scene.poses]))
    for k, (pose, drawn) in enumerate(zip(scene.poses, data["poses"], strict=True)):
        assert f"drawn {scene.factor:g} times larger" in drawn["words"]
        assert np.array(drawn["tool"]) == pytest.approx(
            tool_points(study.arm, pose.q[None])[0], abs=1e-4
        )
        assert np.array(drawn["error"]) == pytest.approx(scene.factor * known.bias[k], abs=1e-4)
        axes = np.array(drawn["axes"]) / scene.factor
        assert axes.T @ axes == pytest.approx(
            7.8147 * known.covariance[k],
            rel=2e-2,
            abs=1e-3 * 7.8147 * np.trace(known.covariance[k]),
        )
        assert np.linalg.det(axes) >= 0
        assert len(drawn["bodies"]) == len(data["bodies"]) == len(study.arm.bodies)


def test_the_cells_of_the_scene_have_the_classes_of_the_legend():
    """Unpacked as the script does, x fastest: 0 where the tool never is, else the class of the 95th
    percentile by the limits of the legend.
    """
    study = small_study()
    scene, data = scene_of(study)
    cells = data["cells"]
    codes = np.frombuffer(gzip.decompress(base64.b64decode(cells["classes"])), np.uint8).reshape(
        cells["shape"], order="F"
    )
    assert (codes == scene.cells.classes + 1).all()
    assert set(np.unique(codes)) <= set(range(8))
    index = ((study.tool - cells["low"]) / cells["edge"]).astype(int)
    assert (codes[tuple(index.T)] > 0).all()  # every pose of the study lies in a coloured cell


def test_a_scene_is_drawn_of_any_study():
    """Too few poses colour no cell; an arm without errors has no arrow; one error everywhere is one
    pose.
    """
    study = small_study()
    few = replace(
        pose_errors(study),
        **{name: getattr(pose_errors(study), name)[:3] for name in ("q", "tool", "mean", "within")},
    )
    first, _ = picture.arm_in_workspace(few)
    assert first.scene.cells is None
    assert "Grey: what the tool reaches." in first.words
    assert "legend" not in viewer(first.scene)
    arm = lostmotion.Arm.model_validate({"name": "ideal", "joints": [STIFF]})
    q = np.linspace(-1, 1, 50)[:, None]
    tool, nothing = tool_points(arm, q), np.zeros(50)
    (alone,) = picture.arm_in_workspace(
        picture.PicturedErrors(arm, q, 0.0, tool, nothing, nothing, tool)
    )
    assert alone.scene.flat
    assert "larger" not in alone.words + alone.scene.poses[0].words
    assert "through the arm" not in viewer(alone.scene)
    assert "<button" not in viewer(alone.scene)


def test_a_study_without_sampling_shows_the_same_scene():
    """The cloud of poses is at hand there too."""
    study = lostmotion.study(small_study().arm, 64, method="analytic", threads=1)
    shown = study.plots[0]
    assert shown.scene is not None
    assert shown.scene.cells.limits
    assert [pose.name for pose in shown.scene.poses] == ["worst pose", "best pose"]
