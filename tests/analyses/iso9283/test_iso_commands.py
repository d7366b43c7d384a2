"""Commands of measured readings: those of the file, of a file of commands, or of a stated cube;
never of a cube found by search. Robots are predicted with the measured number of visits, and so
once.
"""

import math
from pathlib import Path

import pytest

import lostmotion
from lostmotion.standards import commanded_poses

EXAMPLES = Path(__file__).parents[3] / "examples"
Z_ARM, LOADS = EXAMPLES / "z-arm.toml", EXAMPLES / "measured" / "z-arm-loads.csv"
PLACE = {"cube": "500 mm", "centre": "520 mm, 0 mm, 1050 mm"}


def rows_of(folder, *, path, pose):
    """Write the example's readings at full load without their commands: along the path, at the
    poses, or both.
    """
    lines = [
        line.split(",")
        for line in LOADS.read_text(encoding="utf-8").splitlines()
        if not line.startswith("#")
    ]
    kept = [line for line in lines[1:] if line[3] == "100" and (path if line[1] else pose)]
    file = folder / "visits.csv"
    file.write_text("\n".join(",".join(line[:7]) for line in [lines[0], *kept]), encoding="utf-8")
    return file


@pytest.mark.parametrize(
    ("kinds", "said"),
    [
        (
            {"path": True, "pose": False},
            r"200 rows, from line 2\n  found     readings along path 'P2-P4' without commanded positions",
        ),
        (
            {"path": False, "pose": True},
            r"150 rows, from line 2\n  found     poses P1, P2, P3, P4, P5 without commanded positions",
        ),
        (
            {"path": True, "pose": True},
            r"350 rows, (.|\n)*P5 and readings along path 'P2-P4' without",
        ),
    ],
)
def test_a_cube_found_by_search_commands_nothing(tmp_path, monkeypatch, kinds, said):
    """Readings without commands are refused once, by file and rows, before a search for a cube,
    which need not be where the robot was sent.
    """
    monkeypatch.setattr(
        commanded_poses, "largest_cube", lambda *_, **__: pytest.fail("looked for a cube")
    )
    with pytest.raises(
        lostmotion.InputError, match=rf"1 mistake\n(.|\n)*visits.csv: {said}(.|\n)*--cube"
    ):
        lostmotion.iso9283(lostmotion.read(Z_ARM), rows_of(tmp_path, **kinds), robots=2)


@pytest.fixture(scope="module")
def stated():
    """Evaluate the same readings with the commands stated in their file."""
    return lostmotion.iso9283(measured=LOADS).measured.loads[0]


@pytest.mark.parametrize("arm", [None, Z_ARM])
def test_a_stated_cube_commands_its_poses_and_lines(tmp_path, stated, arm):
    """With a stated cube, with or without an arm, each figure equals that of the file with its own
    commands.
    """
    file = rows_of(tmp_path, path=True, pose=True)
    found = lostmotion.iso9283(
        None if arm is None else lostmotion.read(arm), file, robots=3, **PLACE
    )
    (load,) = found.measured.loads
    assert [pose.accuracy.value for pose in load.poses] == pytest.approx(
        [pose.accuracy.value for pose in stated.poses]
    )
    assert load.paths[0].figures[:2] == pytest.approx(stated.paths[0].figures[:2])
    assert not [note for note in found.sheet.notes if "sent to" in note]
    assert arm is None or {each.name for each in found.compared} >= {"AP_p", "RP_l", "AT_p"}


def test_poses_in_a_file_of_commands_determine_the_cube(tmp_path, stated):
    """Commands of P1 to P5 in their own file define the cube of the predicted robots, even if only
    a path was measured.
    """
    rows = {
        line.split(",")[0]: line.split(",")[7:]
        for line in LOADS.read_text(encoding="utf-8").splitlines()
        if line.startswith("P")
    }
    commands = tmp_path / "commands.csv"
    commands.write_text(
        "pose,x [mm],y [mm],z [mm]\n"
        + "\n".join(f"{name},{','.join(at)}" for name, at in rows.items()),
        encoding="utf-8",
    )
    file = rows_of(tmp_path, path=True, pose=False)
    found = lostmotion.iso9283(lostmotion.read(Z_ARM), file, robots=3, visits=2, commands=commands)
    assert found.predicted.cube.side == pytest.approx(0.5)
    assert found.measured.loads[0].paths[0].figures[0] == pytest.approx(stated.paths[0].figures[0])
    assert "AT_p" in {each.name for each in found.compared}


def test_the_orientation_of_a_stated_cube_is_the_stated_one(tmp_path):
    """Orientation errors need --tool-rpy; without it the commanded orientation is unknown, whatever
    the orientation of the predicted robots.
    """
    arm = lostmotion.read(EXAMPLES / "ur5e.urdf")
    file = tmp_path / "visits.csv"
    points = {
        "P1": (400, 0, 400),
        "P2": (360, -40, 360),
        "P3": (440, -40, 360),
        "P4": (440, 40, 440),
        "P5": (360, 40, 440),
    }
    rows = [
        f"{name},{c},{x},{y + c},{z},180,0,{c}"
        for c in (1, 2, 3)
        for name, (x, y, z) in points.items()
    ]
    file.write_text(
        "pose,cycle,x [mm],y [mm],z [mm],a [deg],b [deg],c [deg]\n" + "\n".join(rows),
        encoding="utf-8",
    )
    asked = {"robots": 2, "visits": 3, "cube": 0.1, "centre": (0.4, 0.0, 0.4)}
    told = (
        lostmotion.iso9283(None, file, tool_rpy="180 deg, 0 deg, 0 deg", **asked)
        .measured.loads[0]
        .poses[0]
    )
    assert told.axes[2].value == pytest.approx(0.0349, abs=1e-4)
    quiet = lostmotion.iso9283(arm, file, **asked).measured.loads[0].poses[0]
    assert math.isnan(quiet.axes[2].value)
    assert quiet.axes[4].value == pytest.approx(2e-3)


def test_an_accuracy_that_no_such_arm_has_is_doubted(tmp_path):
    """For a cube stated 37 mm off the sheet warns about the commands, with the predicted figure
    where there is one.
    """
    file = rows_of(tmp_path, path=True, pose=True)
    off = {"cube": "500 mm", "centre": "520 mm, 37 mm, 1050 mm"}
    notes = lostmotion.iso9283(measured=file, **off).sheet.warnings
    assert [note for note in notes if "mean AP_p over poses is 37." in note and "sent to" in note]
    beside = lostmotion.iso9283(lostmotion.read(Z_ARM), file, robots=3, **off).sheet.warnings
    assert [
        note
        for note in beside
        if "AT_p along P2-P4 is" in note
        and "above the 95th percentile of the predicted robots" in note
    ]
