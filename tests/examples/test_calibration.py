"""The simulated measurements beside the examples of calibration."""

from __future__ import annotations

import re
import runpy
import sys

import numpy as np
import pytest

import lostmotion
from lostmotion.calibration.choices import Asked
from lostmotion.calibration.correction import expected_tool
from lostmotion.calibration.model import model_of
from lostmotion.calibration.terms import added_terms, stated_scale
from lostmotion.calibration.validation import cross_validate
from lostmotion.error_model.provenance import states
from lostmotion.errors import InputError
from lostmotion.io.calibration_file import read_calibration
from lostmotion.io.measured.calibration_visits import read_calibration_visits
from lostmotion.mechanism.state import state_of
from lostmotion.reporting.provenance import provenance_sections
from tests.calibration.ur5_grid import EXAMPLES

FOLDER = EXAMPLES / "calibration"
NUMBER = re.compile(r"-?\d+\.\d+")


@pytest.mark.parametrize("kind", ["dial", "tag"])
def test_the_readings_are_what_their_script_writes(monkeypatch, capsys, kind):
    """Row by row, each reading to the last digit printed: else run examples/calibration/make.py."""
    monkeypatch.setattr(sys, "argv", ["make.py", kind])
    runpy.run_path(str(FOLDER / "make.py"), run_name="__main__")
    written = capsys.readouterr().out
    stored = (FOLDER / f"printed-{kind}.csv").read_text("utf-8")
    assert NUMBER.sub("#", written).split() == NUMBER.sub("#", stored).split()
    assert list(map(float, NUMBER.findall(written))) == pytest.approx(
        list(map(float, NUMBER.findall(stored))), abs=0.011
    )


@pytest.mark.slow
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

    # the last rung alone, at the same held-out readings, where no side of arrival is known
    robot = answer.robot
    every = model_of(arm, visits.q, added_terms(arm, robot.sizes), approach=0.0)
    blind = every.keeping(every.numbers(climb.model.streams))
    asked = Asked(
        np.ones(len(blind.streams) + len(climb.instrument.unknowns)),
        None,
        scale=stated_scale(arm, robot.sizes),
    )
    held = cross_validate(blind, climb.instrument, asked, climb.random.folds)
    assert held.mean > 1.5 * left


@pytest.mark.slow
def test_a_webcam_calibrates_a_printed_arm():
    """Corners of a tag, with unknown places of camera and tag, reduce the error at unused images by
    a quarter at least; their noise is that of 0.2 pixels at the distance of the tag.
    """
    arm = lostmotion.read(EXAMPLES / "printed-hobby-arm.toml")
    answer = lostmotion.calibrate(arm, FOLDER / "printed-tag.csv", terms="geometry")
    climb, tags = answer.robot.climb, answer.robot.instrument
    assert climb.random.mean < 0.75 * climb.before.mean
    assert climb.kept.fit.noise == pytest.approx(0.2 * tags.distance / 800, rel=0.2)
    assert 0.92 <= climb.kept.blocked.coverage <= 0.98
    assert answer.sheet.verdict


def test_stated_errors_move_the_tool_by_their_sizes(tmp_path):
    """The tool of the arm with the mastering offset and the length of by-hand.toml is that of an
    arm file with the other length, commanded to the other angle.
    """
    arm = lostmotion.read(FOLDER / "ur5.toml")
    known = read_calibration(FOLDER / "by-hand.toml", arm)
    other = tmp_path / "other.toml"
    other.write_text((FOLDER / "ur5.toml").read_text("utf-8").replace('"-425 mm', '"-425.4 mm'))
    q = np.random.default_rng(1).uniform(-1, 1, (5, 6))
    there = state_of(lostmotion.read(other), q + np.radians([0, 0.1, 0, 0, 0, 0])).frames[-1]
    np.testing.assert_allclose(expected_tool(arm.calibrated(known), q), there, atol=1e-12)
    size = np.sqrt(np.diag(known.covariance)) / np.abs(known.mean)
    np.testing.assert_allclose(size, [0.02 / 0.1, 0.05 / 0.4])


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ('"0.1 deg"', '"0.1 mm"', "estimates[0].mean"),
        ('"0.1 deg"', '"much"', "estimates[0].mean"),
        ('"0.05 mm"', '"-0.05 mm"', "estimates[1].deviation"),
        ("tip offset x", "tip ofset x", "tip offset x"),
        ('"0.1 deg"', "nan", "estimates[0].mean"),
    ],
)
def test_wrong_estimates_are_refused(old, new, text, tmp_path):
    """With their keys."""
    path = tmp_path / "by-hand.toml"
    path.write_text((FOLDER / "by-hand.toml").read_text("utf-8").replace(old, new))
    with pytest.raises(InputError) as refused:
        read_calibration(path, lostmotion.read(FOLDER / "ur5.toml"))
    assert text in str(refused.value)


def test_stated_and_estimated_errors_are_listed_apart(tmp_path):
    """What went in lists each stated error with its size, marks those that the arm file does not
    state, and counts those of a measurement.
    """
    path = tmp_path / "by-hand.toml"
    frame = '[added]\nbase_shift = 0.01\n[[estimates]]\ndraw = "base frame.shift z"\n'
    stated = (FOLDER / "by-hand.toml").read_text("utf-8")
    path.write_text(f"{frame}mean = 0.2\ndeviation = 0.05\n{stated}")
    arm = lostmotion.read(FOLDER / "ur5.toml")
    robot = arm.calibrated(read_calibration(path, arm))
    rows = {row.label: row for row in provenance_sections(states(robot))[1].rows}
    row = rows["base frame.shift z"]
    assert [str(each) for each in row.cells] == ["2 mm ± 0.5 mm", "stated"]
    assert row.note == "an error that the arm file does not state"
    assert str(rows["J2.link.tip offset x"].cells[0]) == "-0.4 mm ± 50 µm"
    assert "fit it best" not in robot.remarks[0]
    path.write_text(path.read_text().replace("[added]", "[data]\nposes = 20\n[added]"))
    robot = arm.calibrated(read_calibration(path, arm))
    rows = {row.label: row for row in provenance_sections(states(robot))[1].rows}
    assert [str(each) for each in rows["calibration"].cells] == ["3 estimates", "estimated"]
    assert rows["calibration"].note == "from 20 measured poses"
    assert "fit it best" in robot.remarks[0]


@pytest.mark.parametrize(
    ("added", "mean", "state"),
    [
        ("[added]", "0.2", "assumed"),
        ("[added]\nbase_turn = 0.01", "0.2", "assumed"),
        ("[added]\nbase_shift = 0.01", "0.2", "stated"),
        ("[added]", '"2 mm"', "stated"),
    ],
)
def test_a_number_of_assumed_deviations_is_assumed(added, mean, state, tmp_path):
    """Where nobody states the standard deviation of an error, nor its size as a length."""
    path = tmp_path / "by-hand.toml"
    estimate = f'[[estimates]]\ndraw = "base frame.shift z"\nmean = {mean}\ndeviation = 0.05\n'
    path.write_text(f"{added}\n{estimate}")
    arm = lostmotion.read(FOLDER / "ur5.toml")
    robot = arm.calibrated(read_calibration(path, arm))
    (row,) = [row for row in provenance_sections(states(robot))[1].rows if "shift z" in row.label]
    assert [str(each) for each in row.cells] == ["2 mm ± 0.5 mm", state]
    assert ("assumed" in row.note) == (state == "assumed")


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
