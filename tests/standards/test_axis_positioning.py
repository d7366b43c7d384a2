"""Positioning of an axis from two sides: the definitions of ISO 230-2 written out again, lines of
poses, and the sheet of a measured file.
"""

import math
import statistics
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.io.measured.visit_file import read_measured
from lostmotion.standards.axis_positioning import axis_positionings
from tests.standards.test_measured_robot import visits_of

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "positioning of an axis by ISO 230-2",
        "the standard's definitions written out point by point; two offset sides in closed form",
        "1e-12",
        "",
    ),
)


def on_a_line(axis, places, errors, sides, count):
    """Return visits to places along one axis; errors (side, place, visit) along it."""
    command = np.zeros((len(places), 3))
    command[:, axis] = places
    shift = np.zeros((len(places), len(sides) * count, 3))
    shift[:, :, axis] = np.concatenate(list(errors), axis=1)
    visits = visits_of(shift, command, [side for side in sides for _ in range(count)] * len(places))
    return replace(visits, cycle=np.tile(np.arange(count, dtype=float), len(sides) * len(places)))


def test_two_offset_sides_in_closed_form():
    """A scale of 1e-4 and a play of 20 µm between exact sides: B is the play, R equals it, E and A
    are scale times travel plus play, M the scale.
    """
    places = np.linspace(0.0, 0.4, 5)
    errors = np.stack(
        [np.repeat((1e-4 * places + half)[:, None], 5, axis=1) for half in (10e-6, -10e-6)]
    )
    (found,) = axis_positionings(on_a_line(1, places, errors, ("+", "-"), 5))
    assert found.axis == "y"
    assert found.sides == ("+", "-")
    expected = {
        "B": 20e-6,
        "mean B": 20e-6,
        "R": 20e-6,
        "E": 60e-6,
        "A": 60e-6,
        "M": 40e-6,
        "E1": 40e-6,
        "A2": 40e-6,
        "R1": 0.0,
    }
    assert {name: found.figures[name] for name in expected} == pytest.approx(expected, abs=1e-15)


def test_the_definitions_written_out():
    """Random deviations, point by point as the standard's clause 3 defines them, in plain
    Python.
    """
    rng = np.random.default_rng(2)
    places = np.array([-0.2, -0.05, 0.03, 0.11, 0.3, 0.42])
    errors = rng.normal(0, 2e-6, (2, 6, 7)) + rng.normal(0, 5e-6, (2, 6, 1))
    (found,) = axis_positionings(on_a_line(0, places, errors, ("up", "down"), 7))
    up, down = ([[float(x) for x in at] for at in side] for side in errors)
    mean_up, mean_down = ([statistics.fmean(at) for at in side] for side in (up, down))
    s_up, s_down = ([statistics.stdev(at) for at in side] for side in (up, down))
    reversal = [a - b for a, b in zip(mean_up, mean_down, strict=True)]
    each = zip(s_up, s_down, reversal, strict=True)
    assert found.figures["R"] == pytest.approx(
        max(max(2 * a + 2 * b + abs(c), 4 * a, 4 * b) for a, b, c in each)
    )
    assert found.figures["B"] == pytest.approx(max(map(abs, reversal)))
    assert found.figures["mean B"] == pytest.approx(statistics.fmean(reversal))
    high = [m + 2 * s for m, s in zip(mean_up + mean_down, s_up + s_down, strict=True)]
    low = [m - 2 * s for m, s in zip(mean_up + mean_down, s_up + s_down, strict=True)]
    assert found.figures["A"] == pytest.approx(max(high) - min(low))
    assert found.figures["A1"] == pytest.approx(max(high[:6]) - min(low[:6]))
    assert found.figures["R1"] == pytest.approx(4 * max(s_up))
    assert found.figures["R2"] == pytest.approx(4 * max(s_down))
    assert found.figures["E"] == pytest.approx(max(mean_up + mean_down) - min(mean_up + mean_down))
    assert found.figures["E2"] == pytest.approx(max(mean_down) - min(mean_down))
    middle = [(a + b) / 2 for a, b in zip(mean_up, mean_down, strict=True)]
    assert found.figures["M"] == pytest.approx(max(middle) - min(middle))


def rows(points, sides, *, heading="approach"):
    """Return a file of visits to points, mm, three from each side, with a play of 0.05 mm along
    every axis.
    """
    lines = [f"pose,cycle,{heading},xc [mm],yc [mm],zc [mm],x [mm],y [mm],z [mm],spindle"]
    for k, point in enumerate(points, 1):
        for side, half in zip(sides, (0.025, -0.025), strict=True):
            for cycle, noise in enumerate((0.001, -0.001, 0.0), 1):
                read = ",".join(f"{x + half + noise}" for x in point)
                lines.append(f"P{k},{cycle},{side},{','.join(map(str, point))},{read},off")
    return "\n".join(lines) + "\n"


def test_two_axes_of_a_machine_have_a_table_each(tmp_path):
    """Poses along x and along y, crossing in one point, are two lines; the headline gives accuracy,
    repeatability and reversal value of each.
    """
    points = [(x, 0, 0) for x in (0, 100, 200, 300, 400)] + [(0, y, 0) for y in (80, 160, 240, 320)]
    path = tmp_path / "mill.csv"
    path.write_text(rows(points, ("forward", "backward")), encoding="utf-8")
    sheet = lostmotion.iso9283(measured=path).sheet
    lines = sheet.facts["measured"]["iso230"]
    assert [(line["axis"], len(line["positions_m"]), line["sides"]) for line in lines] == [
        ("x", 5, ["forward", "backward"]),
        ("y", 5, ["forward", "backward"]),
    ]
    for line in lines:
        assert line["figures_m"]["B"] == pytest.approx(50e-6)
        assert line["figures_m"]["R"] == pytest.approx(50e-6 + 4 * 1e-6)
        assert line["figures_m"]["A"] == pytest.approx(50e-6 + 4 * 1e-6)
    assert "x axis: accuracy A 54" in sheet.verdict.replace("54.0", "54")
    assert "y axis: accuracy A 54" in sheet.verdict.replace("54.0", "54")
    assert {section.key for section in sheet.sections} >= {"iso230-x-1", "iso230-y-2"}
    note = next(section for section in sheet.sections if section.key == "iso230-x-1").note
    assert "the standard asks for 5 positions and 5 approaches" in note
    assert any("'spindle'" in each for each in sheet.notes)
    rp = [
        pose.repeatability.value
        for load in lostmotion.iso9283(measured=path).measured.loads
        for pose in load.poses
    ]
    assert max(rp) < 10e-6  # of each side; pooled it would be 90 µm


@pytest.mark.parametrize("heading", ["side", "approach", "direction"])
def test_the_side_may_be_headed_as_people_head_it(tmp_path, heading):
    """A column approach or direction is the side from which a pose was approached."""
    path = tmp_path / "axis.csv"
    path.write_text(
        rows([(x, 0, 0) for x in (0, 10, 20)], ("up", "down"), heading=heading), encoding="utf-8"
    )
    assert set(read_measured(path).side) == {"up", "down"}
    assert read_measured(path).unused == ("spindle",)


def test_what_is_no_line_has_no_figures():
    """Two positions, one approach from a side, three sides, and scattered poses are no axis by ISO
    230-2.
    """
    places = np.linspace(0, 0.4, 5)
    errors = np.random.default_rng(0).normal(0, 1e-6, (3, 5, 4))
    assert axis_positionings(on_a_line(0, places[:2], errors[:2, :2], ("a", "b"), 4)) == ()
    assert axis_positionings(on_a_line(0, places, errors[:2, :, :1], ("a", "b"), 1)) == ()
    assert axis_positionings(on_a_line(0, places, errors, ("a", "b", "c"), 4)) == ()
    scattered = on_a_line(0, places, errors[:2], ("a", "b"), 4)
    moved = scattered.command + np.repeat(np.random.default_rng(1).uniform(0, 1, (5, 3)), 8, axis=0)
    assert axis_positionings(replace(scattered, command=moved)) == ()


def test_a_lost_target_is_excluded_and_named(tmp_path):
    """Rows without a reading are excluded from every figure, and their lines are named on the first
    screen; the rest is evaluated.
    """
    head = "pose,cycle,x [mm],y [mm],z [mm],xc [mm],yc [mm],zc [mm]\n"
    text = (
        head
        + "".join(
            f"P1,{k},{500 + 0.01 * (k % 3)},0,{'' if k == 4 else 600},500,0,600\n"
            for k in range(1, 11)
        )
        + "P1,11,nan,nan,nan,500,0,600\n"
    )
    path = tmp_path / "visits.csv"
    path.write_text(text, encoding="utf-8")
    found = lostmotion.iso9283(measured=path)
    assert found.measured.loads[0].poses[0].visits == 9
    assert math.isfinite(found.measured.loads[0].poses[0].repeatability.value)
    assert any(
        "2 rows without a reading excluded (line 5, 12)" in note for note in found.sheet.warnings
    )
    assert [each["line"] for each in found.sheet.facts["measured"]["rows_without_a_reading"]] == [
        5,
        12,
    ]


def test_a_workbook_is_named_as_one(tmp_path):
    """A file of Excel is refused by what it is, with what to do, whatever its ending."""
    for name in ("visits.xlsx", "visits.csv"):
        path = Path(tmp_path) / name
        path.write_bytes(b"PK\x03\x04\x14\x00\x06\x00")
        with pytest.raises(lostmotion.InputError, match="save the sheet as CSV"):
            lostmotion.iso9283(measured=path)
