"""Files of measured robots that once misled: a lost target, a far visit, metres under the name of
millimetres, forward and backward runs of an axis, and figures that stood beside others.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import lostmotion

GIVEN = Path(__file__).parent / "given"
EXAMPLES = Path(__file__).parents[2] / "examples"


def test_a_reading_without_a_number_excludes_its_row():
    """The warning names the line; the visits that are left are evaluated."""
    sheet = lostmotion.iso9283(measured=GIVEN / "lost-target.csv").sheet
    assert any("1 row without a reading excluded (line 6)" in each for each in sheet.warnings)
    assert "34 measured visits" in sheet.counts


def test_a_visit_far_from_the_others_is_named_beside_figures_without_it():
    """RP of all visits and of those but the outlying one, on the first screen."""
    sheet = lostmotion.iso9283(measured=GIVEN / "far-visit.csv").sheet
    assert any("P1 in line 5 by 5.04 mm" in each for each in sheet.warnings)
    assert "RP_l up to 2.9 mm, 0.111 mm without 1 outlying visit" in sheet.verdict


def test_positions_in_another_unit_than_their_header_are_refused():
    """A thousandth of the commanded distance in every row: the message asks for the units."""
    with pytest.raises(lostmotion.InputError, match=r"0\.001 times as far in all rows"):
        lostmotion.iso9283(measured=GIVEN / "metres-under-mm.csv")


@pytest.mark.parametrize("heading", ["approach", "side"])
def test_runs_from_two_sides_are_not_pooled(tmp_path, heading):
    """A, R and B of ISO 230-2 as computed by hand from the file, and RP of each side."""
    text = (GIVEN / "two-sides.csv").read_text("utf-8").replace("approach", heading, 1)
    (tmp_path / "axis.csv").write_text(text, "utf-8")
    sheet = lostmotion.iso9283(measured=tmp_path / "axis.csv").sheet
    (line,) = sheet.facts["measured"]["iso230"]
    found = {name: round(1e6 * line["figures_m"][name], 4) for name in ("A", "R", "B")}
    assert found == {"A": 0.0888, "R": 0.0688, "B": 0.0122}
    assert "Measured, from up: " in sheet.verdict
    assert "Measured, from down: " in sheet.verdict


def test_a_measured_robot_is_compared_at_its_commanded_poses():
    """The headline counts the figures within the predicted range at the poses of the file, and says
    of the figures of a test cube that they are not compared.
    """
    sheet = lostmotion.iso9283(
        EXAMPLES / "six-axis.toml",
        measured=GIVEN / "six-axis.csv",
        cube="300 mm",
        centre="900 mm, 0 mm, 600 mm",
        robots=20,
    ).sheet
    assert "robots predicted at the 5 commanded poses of the file" in sheet.verdict
    assert "Not compared, predicted in a test cube" in sheet.verdict
