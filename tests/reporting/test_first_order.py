"""Errors too large to be added up: the headline says so, and no interval claims more than is
known.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import fsolve
from typer.testing import CliRunner

import lostmotion
from lostmotion.cli import app
from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.errors import InputError
from lostmotion.mechanism.droop import droop
from lostmotion.propagation.exact import ExactCheck
from lostmotion.propagation.first_order import refuse_large_errors
from lostmotion.reporting.first_order import failure
from lostmotion.reporting.layout import row_at
from lostmotion.reporting.sheet import length
from tests.runs.conftest import ARM, SWEEP

VALIDATES = (
    (
        "droop of a soft arm",
        "balance of torques on two springs, solved by SciPy",
        "1e-6",
        "mechanism/droop.py",
    ),
)
# Figures that the sum of errors makes, and their sections.
OF_ERRORS = ("error", "iso9283", "levels", "budget")


def arm_with(tmp_path, backlash, more=""):
    """Return the path of a small arm whose gearboxes have this play."""
    path = tmp_path / "tiny.toml"
    path.write_text(ARM.replace("1 arcmin ± 0.3 arcmin", backlash) + more, encoding="utf-8")
    return path


def test_errors_beyond_the_lengths_that_are_counted_are_refused(tmp_path):
    """Play of a hundred turns moves the tool by more than 16 m."""
    path = arm_with(tmp_path, "100 rev")
    with pytest.raises(InputError, match="16 m and more"):
        lostmotion.study(lostmotion.read(path), 64, 40, 3, seed=1)


@pytest.mark.parametrize("backlash", ["2 rev", "60 deg"])
def test_errors_of_many_degrees_are_no_accuracy(tmp_path, backlash):
    """Play of two turns, and of sixty degrees: the headline says that first order fails, and no
    figure of an error has an interval.
    """
    sheet = lostmotion.study(lostmotion.read(arm_with(tmp_path, backlash)), 64, 40, 3, seed=1).sheet
    assert "First-order figures fail here: errors of" in sheet.verdict
    assert "95 % of positions" not in sheet.verdict
    assert (
        "first order fails"
        in row_at(sheet.sections, "exact_check", "largest_share_of_the_p95").note
    )
    intervals = [
        figure.interval
        for section in sheet.sections
        if section.key in OF_ERRORS
        for row in section.rows
        for figure in row.cells
    ]
    assert intervals
    assert not any(intervals)
    assert not any("…" in card.quiet for card in sheet.cards)
    # the largest contributor is known, what a remedy leaves is not
    assert [block.key for block in sheet.bars] == ["budget"]
    assert not any(bar.effect for bar in sheet.bars[0].bars)


SOFT = """
name = "two soft servos"
[payload]
mass = "0.3 kg"
[[joints]]
name = "shoulder"
type = "revolute"
axis = "-y"
limits = ["-90 deg", "90 deg"]
gearbox = { stiffness = "10 N m/rad" }
link = { length = "250 mm", rigid = true }
[[joints]]
name = "elbow"
type = "revolute"
axis = "-y"
mass = "0.4 kg"
limits = ["-90 deg", "90 deg"]
gearbox = { stiffness = "5 N m/rad" }
link = { length = "250 mm", rigid = true }
"""


def test_an_arm_that_droops_has_the_figures_of_the_place_where_it_stands(tmp_path):
    """Two springs of 10 and 5 N m/rad let the tool down by about 150 mm; the mean error is that of
    an equilibrium computed by hand, and the note states the droop.
    """
    path = tmp_path / "soft.toml"
    path.write_text(SOFT, encoding="utf-8")
    pull = 9.80665

    def torques(a, b):
        outer = pull * 0.3 * 0.25 * np.cos(a + b)
        return pull * (0.3 + 0.4) * 0.25 * np.cos(a) + outer, outer

    a, b = fsolve(lambda at: np.array(torques(*at)) + at * [10.0, 5.0], [0.0, 0.0], xtol=1e-12)
    tip = 0.25 * np.array([np.cos(a) + np.cos(a + b), np.sin(a) + np.sin(a + b)])
    down = np.hypot(0.5 - tip[0], tip[1])
    arm = lostmotion.read(path)
    mean = np.linalg.norm(pose_matrix(arm, np.zeros((1, 2))).bias[0, 3:])
    assert mean == pytest.approx(down, rel=1e-6)
    found = droop(arm)
    assert down <= found.length < 1.1 * down  # somewhat above the horizontal it droops more
    sheet = lostmotion.study(path, 64, robots=20, visits=2).sheet
    assert sheet.notes[0].startswith(f"droops by up to {length(found.length)}")
    assert "fail" not in sheet.verdict
    refuse_large_errors(arm)


def test_an_arm_that_falls_is_refused_with_its_joint(tmp_path):
    """With a hundred times the payload the springs do not hold the arm upright: no plausible figure
    is stated, but the joint.
    """
    path = tmp_path / "falls.toml"
    path.write_text(SOFT.replace('"0.3 kg"', '"30 kg"'), encoding="utf-8")
    upright = np.array([[np.pi / 2, 0.0]])
    with pytest.raises(InputError, match="no stable equilibrium at 1 of 1 poses"):
        pose_matrix(lostmotion.read(path), upright)


def test_usual_errors_are_small_enough(tmp_path):
    """With play of an arcminute first order is enough, and every figure keeps its interval."""
    sheet = lostmotion.study(
        lostmotion.read(arm_with(tmp_path, "1 arcmin")), 64, 40, 3, seed=1
    ).sheet
    assert re.match(
        r"At least [\d.]+ µm \(.*\) for 95 % of positions: hysteresis, bearing, encoder and link bending are not described",
        sheet.verdict,
    )
    assert (
        row_at(sheet.sections, "exact_check", "largest_share_of_the_p95").note
        == "first order is enough"
    )
    assert row_at(sheet.sections, "error", "p95").cells[0].interval


def test_the_iso_sheet_says_it_too(tmp_path):
    """The standard's sheet of an arm with play of sixty degrees predicts nothing, and says why."""
    example = (Path(__file__).parents[2] / "examples" / "z-arm.toml").read_text(encoding="utf-8")
    path = tmp_path / "loose.toml"
    path.write_text(
        re.sub(r'^backlash = "[^"]*"', 'backlash = "60 deg"', example, flags=re.MULTILINE),
        encoding="utf-8",
    )
    # a stated cube saves the search for the largest
    stated = {"cube": "300 mm", "centre": "550 mm, 0 mm, 800 mm"}
    sheet = lostmotion.iso9283(lostmotion.read(path), robots=10, visits=5, **stated).sheet
    assert "First-order figures fail here" in sheet.verdict
    predicted = [section for section in sheet.sections if section.key not in {"check", "cube"}]
    assert not any(
        figure.interval for section in predicted for row in section.rows for figure in row.cells
    )


@pytest.mark.usefixtures("unpainted")
def test_a_sweep_names_the_designs_that_fail(tmp_path):
    """Of designs with little play and with sixty degrees the sound ones are ranked, and the others
    are counted with the worst one's name.
    """
    path = arm_with(tmp_path, "1 arcmin", SWEEP.replace('"0.5 arcmin"', '"60 deg"'))
    found = lostmotion.sweep(
        path, poses=16, robots=20, visits=3, block=4, out=tmp_path / "run", workers=1
    )
    verdict = found.sheet.verdict
    assert verdict.startswith("In 2 designs of 4, first of all backlash 60 deg")
    assert re.search(
        r"Of 2 designs the smallest 95th percentile of the position error is at least [\d.]+ [mµ]m, with backlash 1 arcmin",
        verdict,
    )
    found.report()


def test_failure_begins_at_a_tenth_of_the_error():
    """Neglecting a hundredth of the error passes, a twentieth is reported, a fifth fails."""
    assert [
        bool(failure(ExactCheck(largest, largest, 10), 1e-3)) for largest in (1e-5, 5e-5, 2e-4)
    ] == [False, False, True]


@pytest.mark.parametrize("command", ["map", "target", "size"])
def test_a_question_without_exact_composition_is_refused(tmp_path, command):
    """Maps, targets and parts for a target of an arm whose play is sixty degrees are refused in
    words; with an arcminute they are answered.
    """
    asked = {"map": [], "target": ["--error", "5 mm"], "size": ["--target", "5 mm"]}[command]
    path = arm_with(tmp_path, "60 deg")
    ran = CliRunner().invoke(app, [command, str(path), "--out", str(tmp_path / "out"), *asked])
    assert isinstance(ran.exception, InputError)
    assert "errors small enough to be added up" in str(ran.exception)
    assert not (tmp_path / "out").exists()
    refuse_large_errors(lostmotion.read(arm_with(tmp_path, "1 arcmin")))


def test_the_limit_lies_near_eleven_degrees(tmp_path):
    """A turn by a small angle a leaves its tangent by a/2 of the arc, a tenth of it at 0.2 rad: two
    joints of +-4 degrees pass, of +-16 not.
    """
    text = ARM.replace('axis = "y"', 'axis = "z"')
    one = tmp_path / "one.toml"
    for play, passes in (("8 deg", True), ("32 deg", False)):
        one.write_text(text.replace("1 arcmin ± 0.3 arcmin", play, 1), encoding="utf-8")
        if passes:
            refuse_large_errors(lostmotion.read(one))
        else:
            with pytest.raises(InputError, match="errors of up to"):
                refuse_large_errors(lostmotion.read(one))
