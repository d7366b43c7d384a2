"""Comparison of predicted and measured robots: which figures are compared, how, and the notes on
the others.
"""

import io
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from scipy.spatial.transform import Rotation

import lostmotion
from lostmotion.propagation.iso9283.cube import (
    NAMES,
    CommandedPoses,
    cube_from_arguments,
    orientation_clause,
)
from lostmotion.propagation.iso9283.experiment import Experiment
from lostmotion.propagation.iso9283.robots import load_sheets, predict_at
from lostmotion.reporting.layout import row_at
from lostmotion.reporting.screen import print_sheet
from lostmotion.reporting.sheet import Cell, Row, Section, Sheet

EXAMPLES = Path(__file__).parents[3] / "examples"
HEADER = (
    "pose,cycle,x [mm],y [mm],z [mm],a [deg],b [deg],c [deg],xc [mm],yc [mm],zc [mm],ac [deg],bc "
    "[deg],cc [deg]"
)


def written(folder, cube, *, held=None, columns=14):
    """Write visits to P1 to P5 of a cube, each rotated by a fraction of a degree about the base's
    z; commanded as the arm's tool, or `held`.
    """
    lines = [",".join(HEADER.split(",")[:columns])]
    for cycle in range(1, 6):
        for name, pose in zip(NAMES, cube.poses, strict=True):
            rotation = Rotation.from_matrix(pose[:3, :3] if held is None else held)
            turned = Rotation.from_euler("z", 0.02 + 0.001 * cycle, degrees=True) * rotation
            place = 1e3 * pose[:3, 3]
            numbers = [
                *(place + 0.01 * cycle),
                *turned.as_euler("xyz", degrees=True),
                *place,
                *rotation.as_euler("xyz", degrees=True),
            ]
            lines.append(
                ",".join([name, str(cycle), *(f"{number:.7f}" for number in numbers)][:columns])
            )
    file = folder / "turned.csv"
    file.write_text("\n".join(lines), encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def arm():
    """Read the arm with five joints, whose orientation follows from the position."""
    return lostmotion.read(EXAMPLES / "z-arm.toml")


@pytest.fixture(scope="module")
def cube(arm):
    """Return a cube of 300 mm."""
    return cube_from_arguments(arm, np.array([0.52, 0.0, 1.05]), 0.3)


def test_a_measured_orientation_is_shown_and_compared(arm, cube, tmp_path):
    """For an arm of five joints, orientation errors about the command are listed and compared with
    robots of the same orientation.
    """
    found = lostmotion.iso9283(arm, written(tmp_path, cube), robots=4, visits=5)
    row = row_at(found.sheet.sections, "measured-axes", "P1_c")
    assert row.cells[0].as_shown == pytest.approx(0.023 * 60, abs=1e-4)
    assert row.cells[1].as_shown == pytest.approx(3 * np.std(np.arange(5) * 0.06, ddof=1), rel=1e-3)
    assert {each.name for each in found.compared} >= {
        "AP_a",
        "AP_b",
        "AP_c",
        "RP_a",
        "RP_b",
        "RP_c",
    }
    assert row_at(found.sheet.sections, "compared", "RP_c_P1") is not None
    # Several orientations determine a tool frame too; predicted robots are fitted with a base frame
    # only.
    assert found.measured.loads[0].fit.rank > 6
    assert "AP_p fitted" not in {each.name for each in found.compared}
    assert any("fitted with base and tool frame" in note for note in found.sheet.notes)


def test_a_tool_held_otherwise_is_shown_and_not_compared(arm, cube, tmp_path):
    """Orientations other than the arm's are listed but not compared, with a note."""
    found = lostmotion.iso9283(
        arm,
        written(tmp_path, cube, held=Rotation.from_euler("x", 40, degrees=True).as_matrix()),
        robots=4,
        visits=5,
    )
    assert row_at(found.sheet.sections, "measured-axes", "P1_c").cells[0].as_shown == pytest.approx(
        0.023 * 60, abs=1e-4
    )
    assert {each.name for each in found.compared} >= {"AP_p", "RP_l", "AP_x", "AP_p fitted"}
    assert not {each.name for each in found.compared} & {
        "AP_a",
        "AP_b",
        "AP_c",
        "RP_a",
        "RP_b",
        "RP_c",
    }
    assert any(
        "not compared at P1, P2, P3, P4, P5" in note and "fewer than six joints" in note
        for note in found.sheet.notes
    )


def test_turns_without_a_command_scatter_all_the_same(cube, tmp_path):
    """Orientations without commands have RP_a,b,c about their mean, unknown AP_a,b,c, and a note on
    the missing columns.
    """
    found = lostmotion.iso9283(measured=written(tmp_path, cube, columns=11))
    whole = lostmotion.iso9283(measured=written(tmp_path, cube))
    row, beside = (row_at(each.sheet.sections, "measured-axes", "P3_c") for each in (found, whole))
    assert str(row.cells[0]) == "not known"
    assert row.cells[1].as_shown == pytest.approx(beside.cells[1].as_shown, rel=1e-4)
    assert any("ac, bc, cc" in note for note in found.sheet.notes)
    assert not [note for note in whole.sheet.notes if "ac, bc, cc" in note]


def test_commands_out_of_reach_name_their_file(arm, cube, tmp_path):
    """A measured file whose P1 to P5 the arm does not reach is named with the poses; no option that
    was not given, and no constant orientation.
    """
    file = written(tmp_path, cube)
    rows = [line.split(",") for line in file.read_text(encoding="utf-8").splitlines()]
    file.write_text(
        "\n".join(
            ",".join([*row[:8], *(f"{float(x) + 400:.4f}" for x in row[8:11])]) for row in rows[1:]
        ),
        encoding="utf-8",
    )
    file.write_text(
        ",".join(rows[0][:11]) + "\n" + file.read_text(encoding="utf-8"), encoding="utf-8"
    )
    with pytest.raises(
        lostmotion.InputError,
        match=r"turned.csv: commanded positions of P1 to P5(.|\n)*P4 at \(1040, 520, 1570\) mm",
    ) as caught:
        lostmotion.iso9283(arm, file, robots=2)
    assert "--cube" not in str(caught.value)
    assert "constant orientation" not in str(caught.value)
    with pytest.raises(
        lostmotion.InputError, match="a cube that the tool reaches entirely"
    ) as caught:
        lostmotion.iso9283(arm, cube=3.0, centre=(0.5, 0.0, 0.5), robots=2)
    assert "constant orientation" not in str(caught.value)


def renamed(folder, cube):
    """Write the visits to a cube in the standard's order under other names, so that it is no test
    cube.
    """
    file = written(folder, cube)
    header, *lines = (
        ",".join([*(cells := line.split(","))[:5], *cells[8:11]])
        for line in file.read_text(encoding="utf-8").splitlines()
    )
    lines.sort(key=lambda line: (int(line.split(",")[1]), -int(line[1])))
    file.write_text(
        "\n".join([header, *("ABCDE"[int(line[1]) - 1] + line[2:] for line in lines)]) + "\n",
        encoding="utf-8",
    )
    return file


def test_robots_predicted_at_commanded_poses_are_those_of_the_cube(arm, cube, tmp_path):
    """Robots in the configurations of a cube's poses have its AP and RP; commands under other names
    are reached, and refused out of reach.
    """
    # a stated cube saves the search for the largest
    stated = {"cube": 0.2, "centre": (0.55, 0.0, 0.9)}
    found = lostmotion.iso9283(arm, renamed(tmp_path, cube), robots=4, visits=2, **stated)
    assert found.commanded.names == tuple("EDCBA")
    np.testing.assert_allclose(found.commanded.poses[::-1, :3, 3], cube.poses[:, :3, 3], atol=1e-5)
    assert {each.pose for each in found.compared if each.name == "AP_p"} == set("ABCDE")
    (standard,) = load_sheets(arm, cube, Experiment(1, 400, 5, 0.0), {0: 1.0}, None, 10)
    (sheet,) = predict_at(
        arm,
        CommandedPoses(tuple("EDCBA"), cube.q[::-1], cube.poses[::-1], None, 0),
        cycles=5,
        robots=400,
        seed=1,
        loads=(1.0,),
    )
    for one, other in (
        (standard.accuracy, sheet.accuracy[::-1]),
        (standard.repeatability, sheet.repeatability[::-1]),
    ):
        np.testing.assert_allclose(
            other.mean(axis=1), one.mean(axis=1), atol=4 * np.sqrt(2) * one.std() / 20
        )
    file = renamed(tmp_path, cube)
    file.write_text(
        file.read_text(encoding="utf-8") + "F,1,9000,0,0,9000,0,0\nF,2,9000,0,0.1,9000,0,0\n",
        encoding="utf-8",
    )
    with pytest.raises(lostmotion.InputError, match=r"F at \(9000, 0, 0\) mm, out of reach"):
        lostmotion.iso9283(arm, file, robots=2, visits=2, **stated)


@pytest.mark.parametrize(
    ("name", "clause"),
    [("ur5e.urdf", ", with constant orientation of the tool"), ("z-arm.toml", "")],
)
def test_only_six_joints_can_hold_a_constant_orientation(name, clause):
    """A message mentions the constant orientation only for an arm that can hold one."""
    assert orientation_clause(lostmotion.read(EXAMPLES / name)) == clause


def test_a_word_without_room_is_printed_once_for_all_its_rows():
    """On a narrow terminal rows with the same remark are listed together below the table, those
    without one not at all.
    """
    words = {"AP_p, P1": "low", "AP_p, P2": "", "RP_l, P1": "high", "RP_l, P2": "low"}
    rows = tuple(Row(label, (Cell(0.25, "mm"),), word) for label, word in words.items())
    screen = Console(width=20, record=True, file=io.StringIO())
    print_sheet(
        Sheet(
            name="",
            subject="",
            verdict="",
            cards=(),
            sections=(Section("s", "Compared", ("measured",), rows),),
            source="",
        ),
        screen,
    )
    told = " ".join(screen.export_text().split())
    assert told.endswith("AP_p, P1; RP_l, P2: low RP_l, P1: high")
