"""The live view itself: without viser, with the meshes of a URDF, and in a real browser."""

from __future__ import annotations

import importlib.util
import io
import json
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.live_view.picture import COLOURS as CLASSES
from lostmotion.live_view.session import Session
from lostmotion.propagation.analytic import analytic
from lostmotion.propagation.error_magnitude import LEVELS
from lostmotion.reporting.sheet import length
from tests.browser.chromium import CHROMIUM, Browser

EXAMPLES = Path(__file__).parents[2] / "examples"
needs_viser = pytest.mark.skipif(
    importlib.util.find_spec("viser") is None,
    reason="viser is not installed: pip install 'lostmotion[view]'",
)
CUBE = """solid cube
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 0.1 0 0
vertex 0 0.1 0.3
endloop
endfacet
endsolid cube
"""
URDF = """<robot name="bar">
<link name="world"/><joint name="stand" type="fixed"><parent link="world"/><child link="foot"/><origin xyz="0 0 0.4"/></joint>
<link name="foot"/>
<joint name="A" type="revolute"><parent link="foot"/><child link="arm"/>
<axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<link name="arm"><visual><geometry><mesh filename="{mesh}"/></geometry></visual></link>
<joint name="end" type="fixed"><parent link="arm"/><child link="tip"/><origin xyz="0.5 0 0"/></joint>
<link name="tip"/></robot>
"""


def test_the_view_says_what_to_install(monkeypatch):
    """Without the extra one line names it; nothing else of the package needs it."""
    found = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "viser" else found(name)
    )
    with pytest.raises(
        lostmotion.LostmotionError, match=r"^[^\n]*pip install 'lostmotion\[view\]'$"
    ):
        lostmotion.view(EXAMPLES / "z-arm.toml")


def test_wrong_words_are_refused_before_anything_is_served():
    """Port and pose, with what is expected."""
    with pytest.raises(lostmotion.InputError) as mistakes:
        lostmotion.view(EXAMPLES / "z-arm.toml", at="A=30deg", port=80)
    assert {problem.key for problem in mistakes.value.problems} == {"at", "port"}


@needs_viser
@pytest.mark.skipif(
    importlib.util.find_spec("yourdfpy") is None,
    reason="yourdfpy is not installed: pip install 'lostmotion[view]'",
)
@pytest.mark.parametrize(
    ("mesh", "shown"),
    [
        ("package://bar/cube.stl", True),
        ("cube.stl", True),
        ("../cube.stl", False),
        ("none.stl", False),
    ],
)
def test_meshes_are_read_within_the_folder_of_the_urdf_alone(tmp_path, mesh, shown):
    """A mesh beside the URDF moves with its joint; of one outside, or missing, a warning names the
    file and the arm is drawn by its bodies.
    """
    import viser

    from lostmotion.live_view.scene import meshes_of

    folder = tmp_path / "robot"
    folder.mkdir()
    (folder / "cube.stl").write_text(CUBE)
    (tmp_path / "cube.stl").write_text(CUBE)
    (folder / "bar.urdf").write_text(URDF.format(mesh=mesh))
    server = viser.ViserServer(host="127.0.0.1", port=8480, verbose=False)
    try:
        draw, warning = meshes_of(server, folder / "bar.urdf", lostmotion.read(folder / "bar.urdf"))
        assert (draw is not None) == shown
        assert (mesh in warning) == (not shown)
        if draw is not None:
            draw(np.array([0.5]))
    finally:
        server.stop()


@needs_viser
@pytest.mark.skipif(
    importlib.util.find_spec("yourdfpy") is None,
    reason="yourdfpy is not installed: pip install 'lostmotion[view]'",
)
@pytest.mark.skipif(
    importlib.util.find_spec("xacro") is None,
    reason="xacro is not installed: pip install 'lostmotion[xacro]'",
)
@pytest.mark.parametrize(
    ("mesh", "shown"),
    [
        ("package://bar/meshes/$(arg shape).stl", True),
        ("$(find bar)/meshes/$(arg shape).stl", True),
        ("file://$(find bar)/meshes/$(arg shape).stl", True),
        ("../meshes/$(arg shape).stl", True),
        ("package://bar/../$(arg shape).stl", False),
        ("../../$(arg shape).stl", False),
        ("package://other/meshes/none.stl", False),
    ],
)
def test_meshes_of_xacro_are_read_within_its_package_alone(tmp_path, mesh, shown):
    """The expanded file names them, with the arguments of the sidecar; the folder with the
    package.xml holds them, and nothing above it is read.
    """
    import viser

    from lostmotion.live_view.scene import meshes_of

    package = tmp_path / "bar"
    for folder in (package / "urdf", package / "meshes"):
        folder.mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>bar</name></package>")
    for place in (package / "meshes" / "cube.stl", tmp_path / "cube.stl"):
        place.write_text(CUBE)
    head = (
        '<robot name="bar" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="shape" '
        'default="none"/>'
    )
    file = package / "urdf" / "bar.urdf.xacro"
    file.write_text(URDF.format(mesh=mesh).replace('<robot name="bar">', head))
    file.with_name("bar.toml").write_text('[xacro]\nshape = "cube"\n')
    server = viser.ViserServer(host="127.0.0.1", port=8482, verbose=False)
    try:
        draw, warning = meshes_of(server, file, lostmotion.read(file))
        assert (draw is not None) == shown, warning
        assert (".stl" in warning) == (not shown)
        if draw is not None:
            draw(np.array([0.5]))
    finally:
        server.stop()


@needs_viser
def test_meshes_beyond_the_bound_are_not_read(tmp_path, monkeypatch):
    """A warning states the bound, and the arm is drawn by its bodies."""
    import viser

    from lostmotion.live_view import scene as meshes

    monkeypatch.setattr(meshes, "_MEGABYTES", 0)
    (tmp_path / "cube.stl").write_text(CUBE)
    (tmp_path / "bar.urdf").write_text(URDF.format(mesh="cube.stl"))
    server = viser.ViserServer(host="127.0.0.1", port=8483, verbose=False)
    try:
        draw, warning = meshes.meshes_of(
            server, tmp_path / "bar.urdf", lostmotion.read(tmp_path / "bar.urdf")
        )
        assert draw is None
        assert "more than 0 MB of meshes" in warning
    finally:
        server.stop()


def start(*words: str) -> tuple[subprocess.Popen[str], str]:
    """Start the command and return it with the address that it prints."""
    process = subprocess.Popen(
        [sys.executable, "-m", "lostmotion", "view", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    line = process.stdout.readline()
    found = re.search(r"http://127\.0\.0\.1:\d+/\S+", line)
    assert found, line + process.stderr.read()
    return process, found[0]


def colours(picture: bytes) -> dict[tuple[int, int, int], int]:
    """Return the number of pixels of each colour in the left half of a picture."""
    from PIL import Image

    with Image.open(io.BytesIO(picture)) as image:
        left = np.asarray(image.convert("RGB"))[:, : image.width // 2].reshape(-1, 3)
    values, counts = np.unique(left, axis=0, return_counts=True)
    return {tuple(map(int, value)): int(count) for value, count in zip(values, counts, strict=True)}


@needs_viser
@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
def test_a_slider_in_a_real_browser_changes_the_number_to_what_the_study_computes(tmp_path):
    """The page loads from this computer alone and without an error, a key moves a joint by a
    degree, and the number follows.

    The picture shows the workspace in the colours of its legend. SIGTERM ends the view at once, and
    the last pose is printed.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    q = np.radians([10.0, 60.0, -60.0, -20.0, 0.0])
    process, url = start(
        str(EXAMPLES / "z-arm.toml"),
        "--at",
        "O=10deg A=60deg B=-60deg C=-20deg roll=0deg",
        "--port",
        "8490",
    )
    number = "document.querySelector('#lm-q95').textContent"

    def expected() -> str:
        return str(length(float(analytic(arm, q[None]).quantiles[0, LEVELS.index(0.95)])))

    try:
        with Browser(url) as page:
            page.wait(
                "document.querySelector('#lm-all') && "
                "document.querySelector('#lm-all').textContent.endsWith('mm')"
            )
            assert page.value(number) == expected()
            page.value("document.querySelectorAll('[role=slider]')[1].focus()")
            count = "document.querySelector('#lm-n').dataset.n"
            for _ in range(5):
                before = page.value(count)
                page.key("ArrowRight", 39)
                page.wait(f"{count} !== '{before}'")
            q[1] += np.radians(5.0)
            assert page.value(number) == expected()
            time.sleep(1)
            seen = colours(page.screenshot(tmp_path / "view.png").read_bytes())
            assert len(seen) > 500  # the arm is lit
            assert (
                sum(
                    seen.get(tuple(int(colour[k : k + 2], 16) for k in (1, 3, 5)), 0) > 50
                    for colour in CLASSES
                )
                >= 4
            )
            assert page.errors == []
            assert {
                address.split("/")[2]
                for address in page.requests
                if not address.startswith(("data:", "blob:"))
            } == {url.split("/")[2]}
        os.kill(process.pid, signal.SIGTERM)
        rest, errors = process.communicate(timeout=15)
    finally:
        process.kill()
    assert process.returncode == 0, errors
    assert errors == ""
    assert json.loads(rest)["at"] == '--at "O=10deg A=65deg B=-60deg C=-20deg roll=0deg"'


@needs_viser
def test_sliders_follow_a_pose_without_moving_the_arm_again():
    """A clicked pose is between the steps of the sliders: they show it rounded, and the arm stays
    at it. A dragged slider moves its joint alone.
    """
    import viser

    from lostmotion.live_view.controls import Controls

    arm = lostmotion.read(EXAMPLES / "scara.toml")
    poses = lostmotion.sample_poses(arm, 64)
    session = Session(arm, poses, poses.q[0])
    server = viser.ViserServer(host="127.0.0.1", port=8481, verbose=False)
    try:
        controls = Controls(server.gui, session, lambda: None, lambda _: None)
        controls.go_to(poses.q[1])
        time.sleep(0.3)
        np.testing.assert_array_equal(session.q, poses.q[1])
        shown = [slider.value for slider in controls._sliders]
        expected = [
            value * (1e3 if joint.type == "prismatic" else np.degrees(1))
            for joint, value in zip(arm.moving, poses.q[1], strict=True)
        ]
        np.testing.assert_allclose(shown, expected, atol=0.5 + 1e-6)
        controls._sliders[2].value = 50.0  # as a message from the browser does
        end = time.monotonic() + 10
        while session.q[2] == poses.q[1, 2] and time.monotonic() < end:
            time.sleep(0.02)
        np.testing.assert_allclose(session.q, [*poses.q[1, :2], 0.05, poses.q[1, 3]], atol=0)
    finally:
        server.stop()


@needs_viser
def test_new_colours_that_are_asked_for_during_a_drag_are_drawn_with_the_next_pose():
    """While the arm moves, each step of the work gives a pose and no workspace: the button for new
    colours must not wait for a step without one.
    """
    from lostmotion.live_view.window import Window

    arm = lostmotion.read(EXAMPLES / "scara.toml")
    poses = lostmotion.sample_poses(arm, 64)
    session = Session(arm, poses, poses.q[0])
    window = Window(session, poses, 8491, None, lambda _: None)
    try:
        end = time.monotonic() + 30
        while window._classes is None and time.monotonic() < end:
            time.sleep(0.02)
        window._stop.set()
        window._worker.join()  # from here on the test takes the steps
        before, window._workspace = (
            window._classes,
            replace(window._workspace, q95=10 * window._workspace.q95),
        )
        window._controls._ask_refit()
        session.move(poses.q[1])
        window._step()
        assert window._classes != before
    finally:
        window.stop()
