"""The simulated measurements beside the examples of calibration."""

from __future__ import annotations

import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import lostmotion
from lostmotion.errors import InputError
from lostmotion.io.measured.calibration_visits import read_calibration_visits
from tests.calibration.ur5_grid import EXAMPLES

FOLDER = EXAMPLES / "calibration"
NUMBER = re.compile(r"-?\d+\.\d+")


@pytest.mark.parametrize("kind", ["dial", "tag"])
def test_the_readings_are_what_their_script_writes(kind):
    """Row by row, each reading to the last digit printed: else run examples/calibration/make.py."""
    written = subprocess.run(
        [sys.executable, FOLDER / "make.py", kind], capture_output=True, text=True, check=True
    ).stdout
    stored = (FOLDER / f"printed-{kind}.csv").read_text("utf-8")
    assert NUMBER.sub("#", written).split() == NUMBER.sub("#", stored).split()
    assert list(map(float, NUMBER.findall(written))) == pytest.approx(
        list(map(float, NUMBER.findall(stored))), abs=0.011
    )


def test_a_dial_gauge_calibrates_a_printed_arm():
    """With the side of arrival the error at unused readings falls by a third at least; without it
    half as much again remains.
    """
    arm = lostmotion.read(EXAMPLES / "printed-hobby-arm.toml")
    visits = read_calibration_visits(FOLDER / "printed-dial.csv", arm)
    answer = lostmotion.calibrate(arm, visits, terms="geometry")
    climb = answer.robot.climb
    left = climb.random.mean
    assert climb.random.mean < 2 / 3 * climb.before.mean

    blind = replace(visits, approach=np.zeros_like(visits.q))
    climb = lostmotion.calibrate(arm, blind, terms="geometry").robot.climb
    assert climb.random.mean > 1.5 * left


def test_a_webcam_calibrates_a_printed_arm():
    """Corners of a tag, with unknown places of camera and tag, reduce the error at unused images by
    a quarter at least; their noise is that of 0.2 pixels at the distance of the tag.
    """
    arm = lostmotion.read(EXAMPLES / "printed-hobby-arm.toml")
    answer = lostmotion.calibrate(arm, FOLDER / "printed-tag.csv", terms="geometry")
    climb, tags = answer.robot.climb, answer.robot.instrument
    assert climb.random.mean < 0.75 * climb.before.mean
    assert climb.kept.fit.noise == pytest.approx(0.2 * tags.distance / 800, rel=0.2)
    assert 0.92 <= climb.kept.blocked.coverage(answer.robot.inflation) <= 0.98
    assert answer.sheet.verdict


@pytest.mark.parametrize("kind", ["dial", "tag"])
def test_the_excerpt_of_the_page_is_from_the_stored_file(kind):
    """Line by line, each without the columns that the page omits."""
    page = (EXAMPLES.parent / "docs" / "tour" / f"calibrate-{kind}.md").read_text("utf-8")
    stored = (FOLDER / f"printed-{kind}.csv").read_text("utf-8").splitlines()
    for line in page.partition("```text\n")[2].partition("```")[0].splitlines():
        start, _, end = line.partition("...")
        assert any(each.startswith(start) and each.endswith(end) for each in stored), line


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ("# camera: fx 800, ", "# camera: fx 0, ", "at least 1, at most 1e+06"),
        ("# camera: fx 800, ", "# camera: focus 800, ", "fx, fy, cx, cy"),
        ("# tag size: 40 mm", "# tag size unknown", "pixels without a camera"),
        (",0,gripper", ",5,gripper", "line 5, corner"),
        (",3,gripper", ",2,gripper", "0 poses at which all four corners"),
        (",u,v,", ",u,w,", "u, corner without v"),
    ],
)
def test_wrong_pixels_are_refused(old, new, text, tmp_path):
    """With the line, or what is missing."""
    path = tmp_path / "tag.csv"
    path.write_text((FOLDER / "printed-tag.csv").read_text("utf-8").replace(old, new))
    with pytest.raises(InputError) as refused:
        read_calibration_visits(path, lostmotion.read(EXAMPLES / "printed-hobby-arm.toml"))
    assert text in str(refused.value)
