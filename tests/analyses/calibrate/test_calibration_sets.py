"""The column `set` of files by which an arm is calibrated."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

import lostmotion
from lostmotion.errors import InputError
from lostmotion.io.measured.calibration_visits import read_calibration_visits
from lostmotion.spatial import exp
from tests.analyses.calibrate.test_calibrate import HEADER, twenty, written
from tests.calibration.ur5_grid import ARM

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path


def in_sets(path: Path, sets: Sequence[str], header: str = HEADER, rows=None) -> Path:
    """Write as many of the twenty visits as there are sets, each with the name of its own, those of
    set B after the instrument was moved.
    """
    joints, points = (each[: len(sets)] for each in (twenty() if rows is None else rows))
    moved = exp(np.array([0.1, 0, 0.3, 0, 0, 0]))[:3, :3]
    there = np.array(list(sets))[:, None] == "B"
    points = np.where(there, points @ moved.T + [200, -100, 150], points)
    written(path, joints, points, header)
    first, *lines = path.read_text().splitlines()
    cells = [f"{line},{name}" for line, name in zip(lines, sets, strict=True)]
    path.write_text("\n".join([f"{first},set", *cells]) + "\n")
    return path


def test_two_sets_find_the_same_part(tmp_path):
    """The axis that is out of tolerance is found from two set-ups too, and the report states the
    frames.
    """
    path = in_sets(tmp_path / "visits.csv", "AB" * 10)
    found = lostmotion.calibrate(ARM, path, terms="geometry", noise="70 µm")
    (finding,) = found.findings
    assert finding.startswith("J4.seat.tilt 2 is 12")
    assert found.held_out.mean < found.before.mean() / 4
    texts = "\n".join(found.warnings)
    assert "2 sets, each with a frame of its own" in texts
    assert "the base frame of set A" in texts
    assert "measurements of set B are in the frame of the instrument" in texts
    assert "instrument.set B shift x" in [each.name for each in found.terms]
    assert b"set B" not in found.files()["robot.toml"]
    assert "set B" in str(found.sheet)
    path.write_text(path.read_text().replace(",set\n", ",station\n"))
    with pytest.raises(InputError, match="% of the reach"):
        lostmotion.calibrate(ARM, path, terms="geometry", noise="70 µm")


def test_one_name_is_no_set(tmp_path):
    """The visits are those of a file without the column."""
    plain = read_calibration_visits(written(tmp_path / "a.csv", *twenty()), lostmotion.read(ARM))
    named = read_calibration_visits(
        in_sets(tmp_path / "b.csv", ["day 1"] * 20), lostmotion.read(ARM)
    )
    assert named.sets is None
    assert named.remarks == plain.remarks
    for name in ("q", "point", "approach"):
        np.testing.assert_array_equal(getattr(named, name), getattr(plain, name))


def test_an_empty_cell_is_refused(tmp_path):
    """With its file and line."""
    path = in_sets(tmp_path / "visits.csv", [*"AB" * 5, "", *"AB"])
    with pytest.raises(InputError) as refused:
        read_calibration_visits(path, lostmotion.read(ARM))
    (problem,) = refused.value.problems
    assert (problem.file, problem.key) == (str(path), "line 12, set")


def test_a_set_of_two_poses_is_refused(tmp_path):
    """By one message with its rows, of the file that has them; three poses pass with a warning."""
    arm = lostmotion.read(ARM)
    first = in_sets(tmp_path / "one.csv", "A" * 10)
    joints, points = (each[10:] for each in twenty())
    second = in_sets(tmp_path / "two.csv", "AAAAAAAABB", rows=(joints, points))
    with pytest.raises(InputError) as refused:
        read_calibration_visits([first, second], arm)
    (problem,) = refused.value.problems
    assert (problem.file, problem.key) == (str(second), "set B")
    for text in ("2 rows at fewer than 3 poses, line 10, 11", "measure more"):
        assert text in str(refused.value)
    in_sets(second, "AAAAAAABBB", rows=(joints, points))
    found = lostmotion.calibrate(arm, [first, second], terms="geometry", noise="70 µm")
    assert any("set B has 3 poses" in text for text in found.warnings)


def test_files_without_the_column_are_one_set(tmp_path):
    """Together, of their own, which a remark states; equal names of two files are one set."""
    arm, (joints, points) = lostmotion.read(ARM), twenty()
    paths = [
        in_sets(tmp_path / "a.csv", "AAAA"),
        written(tmp_path / "b.csv", joints[4:8], points[4:8]),
        written(tmp_path / "c.csv", joints[8:12], points[8:12]),
        in_sets(tmp_path / "d.csv", "AAAA", rows=(joints[12:], points[12:])),
    ]
    read = read_calibration_visits(paths, arm)
    assert read.sets.tolist() == ["A"] * 4 + [""] * 8 + ["A"] * 4
    assert any("without a column set" in text for text in read.remarks)
    assert read_calibration_visits([paths[0], paths[3]], arm).sets is None


def test_rows_of_other_sets_are_no_copies_and_no_repeats(tmp_path):
    """Equal rows of one set are, and a pose is averaged within its set alone."""
    joints, points = (np.concatenate([each[:6], each[:6], each[:1]]) for each in twenty())
    path = in_sets(tmp_path / "visits.csv", "A" * 6 + "C" * 6 + "A", rows=(joints, points))
    read = read_calibration_visits(path, lostmotion.read(ARM))
    assert (len(read), read.duplicates) == (12, 1)
    found = lostmotion.calibrate(ARM, path, terms="geometry", noise="70 µm")
    assert len(found.visits) == 12
    assert found.repeats is None


@pytest.mark.parametrize(
    ("header", "kind", "remedy"),
    [
        ("distance [mm],to", "distance", "another name in to"),
        ("dial [mm],along", "dial", "rows of one set-up"),
    ],
)
def test_sets_of_one_number_are_refused(header, kind, remedy, tmp_path):
    """With what to do instead; with one name they pass."""
    joints, _ = twenty()
    path = tmp_path / "visits.csv"
    for names, passes in (("S" * 20, True), ("ST" * 10, False)):
        lines = [HEADER.replace("x [mm],y [mm],z [mm]", header) + ",set"]
        for k, row in enumerate(joints):
            cells = [*(f"{each:.12g}" for each in row), f"{100 + k}", "x", names[k]]
            lines.append(",".join(cells))
        path.write_text("\n".join(lines) + "\n")
        if passes:
            assert read_calibration_visits(path, lostmotion.read(ARM)).sets is None
            continue
        with pytest.raises(InputError) as refused:
            read_calibration_visits(path, lostmotion.read(ARM))
        assert f"2 sets of {kind} readings" in str(refused.value)
        assert remedy in str(refused.value)
