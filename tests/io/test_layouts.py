"""Small layouts that readers misread: lifts, pantographs, carts, placeholders, models and packages
of several folders.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion import check
from lostmotion.io import read
from tests.io.conftest import mistakes

LAYOUTS = Path(__file__).parent / "layouts"


@pytest.fixture
def layout(tmp_path):
    """Copy the layouts to a folder that is no part of a project."""
    shutil.copytree(LAYOUTS, tmp_path / "layouts")
    return tmp_path / "layouts"


def names(arm):
    """Return the joints that move."""
    return [joint.name for joint in arm.moving]


def test_an_arm_on_one_of_two_slides_is_read_whole(layout):
    """The other slide carries a screen, and a turret stands beside both: neither is the arm."""
    found = read(layout / "pair.urdf")
    assert names(found) == ["arm_lift", "shoulder", "elbow"]
    assert found.mass == pytest.approx(8)


@pytest.mark.parametrize(
    ("file", "tip", "left"),
    [("pairmimic.urdf", "lower", ["j1", "j2"]), ("cut.urdf", "l2", ["j1", "j2"])],
)
def test_a_pantograph_is_answered_by_one_message(layout, file, tip, left):
    """It names the joint that follows another one; the tip that it offers is read, with a note on
    what hangs on it and moves in the file.
    """
    path = layout / file
    (found,) = mistakes(path)
    assert "joint 'j3' follows 'j2' (mimic, x -1): a linkage on the way to the tool" in found.found
    assert found.example == f'tip = "{tip}"'
    path.with_suffix(".toml").write_text(found.example, encoding="utf-8")
    arm = read(path)
    assert names(arm) == left
    assert any(
        "moving with the arm in the URDF: j3 (follows j2)" in note or "j3 (follows j2)" in note
        for note in arm.notes
    )


def test_a_cart_is_met_with_its_base(layout):
    """In URDF, where its way has limits, by a warning; in MJCF, where it has none, by the
    refusal.
    """
    warnings = read(layout / "mobile.urdf").warnings
    assert any('base = "cart" in mobile.toml' in warning for warning in warnings)
    (found,) = mistakes(layout / "mj" / "robots" / "mobile.xml")
    assert (found.found, found.example) == ("a slide without range", 'base = "cart"')
    for path, joints in (
        (layout / "mobile.urdf", ["shoulder", "elbow"]),
        (layout / "mj" / "robots" / "mobile.xml", ["j1", "j2"]),
    ):
        path.with_suffix(".toml").write_text(found.example, encoding="utf-8")
        assert names(read(path)) == joints


def test_limits_are_repaired_in_the_sidecar(layout):
    """The screen of `check` says so."""
    path = layout / "nolimit.urdf"
    np.testing.assert_allclose(np.degrees(read(path).limits), [[-90, 90]])
    assert ("repaired", "URDF repaired by nolimit.toml: limits of j1.") in check(path).sheet.brief
    path.with_suffix(".toml").unlink()
    (found,) = mistakes(path)
    assert "nolimit.toml: [joints.j1] with limits" in found.expected


def test_placeholders_are_named_in_words(layout):
    """What is doubtful is torques and sag."""
    (first, _) = read(layout / "placeholders.urdf").warnings
    assert (
        first
        == "every link weighs 1 kg: placeholders? Torques and sag are then no better than a guess"
    )


def test_a_model_of_two_folders_needs_its_project(layout):
    """A repository around both, or the folder stated in the sidecar."""
    path = layout / "mj" / "robots" / "arm.xml"
    (found,) = mistakes(path)
    assert 'root = ".." in arm.toml' in found.expected
    path.with_suffix(".toml").write_text('root = ".."\n', encoding="utf-8")
    assert names(read(path)) == ["j1"]
    path.with_suffix(".toml").unlink()
    (layout / "mj" / ".git").mkdir()
    assert names(read(path)) == ["j1"]


def test_a_package_is_found_by_its_name(layout):
    """Its folder is called otherwise."""
    assert names(read(layout / "ws" / "arm_config" / "robot.urdf.xacro")) == ["j1"]


@pytest.mark.parametrize("file", ["pair.urdf", "mobile.urdf", "placeholders.urdf", "nolimit.urdf"])
def test_a_first_sidecar_is_read_as_it_is(layout, file):
    """Also of an arm whose turning axes all stand upright: its drives accelerate what they carry,
    here 3 kg at 0.8 m by 5 m/s^2.
    """
    path = layout / file
    lostmotion.new(urdf=path, force=True).report()
    assert names(read(path))
    if file == "pair.urdf":
        text = path.with_suffix(".toml").read_text("utf-8")
        assert "No turning axis holds a static load" in text
        assert 'drive = { torque = "12 N m" }' in text
