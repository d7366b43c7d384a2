"""Files of tasks: what they state, and one message for each mistake."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import lostmotion
from lostmotion.cli.app import app
from lostmotion.io.task_file import read_task
from lostmotion.propagation import task_remedies
from tests.analyses.task.test_brute_force import ARM, inverse

TASKS = Path(__file__).parents[3] / "examples" / "tasks"
POINT = '[[features]]\nname = "hole"\nkind = "point"\nat = ["450 mm", "150 mm", "0 mm"]\n'
HOLE = '[[tolerances]]\nsphere = "1 mm"\n'
DUTY = '[warm_up]\nduration = "2 min"\n'
HEAT = DUTY + '[[warm_up.joints]]\njoint = "A"\nrise = "9 K"\ntime_constant = "1 h"\n'


@pytest.fixture
def write(tmp_path):
    """Return a function that writes a task and the files that it names, and returns its path."""

    def written(text, **files):
        for name, content in files.items():
            (tmp_path / f"{name}.csv").write_text(content, encoding="utf-8")
        path = tmp_path / "task.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return written


MISTAKES = {
    "unreachable place": (
        POINT.replace("450 mm", "900 mm") + HOLE,
        "",
        ["task.toml:1: features[0], place 1", "(900, 150, 0) mm", "does not reach"],
    ),
    "tolerance of zero": (POINT + HOLE.replace("1 mm", "0 mm"), "", ["tolerances[0].sphere"]),
    "no tolerance": (POINT, "", ["tolerances", "nothing"]),
    "two kinds": (
        POINT + HOLE + 'roundness = "1 mm"\n',
        "",
        ["tolerances[0]", "sphere and roundness", "exactly one of"],
    ),
    "unknown feature": (POINT + HOLE + 'of = "hol"\n', "", ["did you mean 'hole'?"]),
    "datum not fixed": (
        POINT
        + POINT.replace('"hole"', '"other"').replace("450", "400")
        + HOLE
        + 'of = "hole"\nrelative_to = ["other"]\n',
        "",
        ["tolerances[0]", "leave a motion of their frame free"],
    ),
    "its own datum": (
        POINT + HOLE + 'relative_to = ["hole"]\n',
        "",
        ["tolerances[0]", "relative to itself", "other places"],
    ),
    "too many places": (
        'step = "1 nm"\n'
        + POINT.replace("point", "line").replace(
            "at =", 'end = ["450 mm", "250 mm", "0 mm"]\nstart ='
        )
        + HOLE
        + 'of = "hole"\n',
        "",
        ["features[0]", "at most 2000"],
    ),
    "round point": (
        POINT + '[[tolerances]]\nroundness = "1 mm"\n',
        "",
        ["task.toml:5: tolerances[0]", "a single place", "at least 4"],
    ),
    "no feature": (POINT + HOLE + "of = []\n", "", ["tolerances[0].of", "an empty list"]),
    "idle axis": (POINT + HOLE + 'axis = "x"\n', "", ["tolerances[0].axis", "with cylinder or"]),
    "no distance": (
        POINT + POINT.replace('"hole"', '"other"') + '[[tolerances]]\ndistance = "1 mm"\n',
        "",
        ["tolerances[0]", "features at one place"],
    ),
    "no line": (
        POINT.replace("point", "line").replace("at =", 'end = ["0 mm", "0 mm", "0 mm"]\nstart =')
        + HOLE
        + POINT.replace("point", "line")
        .replace("at =", 'end = ["450 mm", "150 mm", "0 mm"]\nstart =')
        .replace('"hole"', '"other"'),
        "",
        ["features[1]", "a line whose start is its end"],
    ),
    "no time constant": (
        POINT + HOLE + HEAT.replace('time_constant = "1 h"\n', ""),
        "",
        ["warm_up.joints[0].time_constant", "40 min"],
    ),
    "negative rise": (
        POINT + HOLE + HEAT.replace("9 K", "-9 K"),
        "",
        ["task.toml:11: warm_up.joints[0].rise", "-9 K", "above zero"],
    ),
    "no joint warms": (POINT + HOLE + DUTY, "", ["warm_up.joints"]),
    "unknown joint": (POINT + HOLE + HEAT.replace('"A"', '"AA"'), "", ["did you mean 'A'?"]),
    "rigid in heat": (POINT + HOLE + HEAT, "", ["warm_up.joints[0].joint", "no known expansion"]),
    "neither": (HOLE, "", ["poses, program, features", "none of them"]),
    "wrong column": ('poses = "path.csv"\n' + HOLE, "x [mm],y [mm],h [mm]\n1,2,3\n", ["column 3"]),
    "wrong unit": ('poses = "path.csv"\n' + HOLE, "x [deg],y [mm],z [mm]\n1,2,3\n", ["column 1"]),
    "missing column": ('poses = "path.csv"\n' + HOLE, "x [mm],y [mm]\n1,2\n", ["no column for z"]),
    "not a number": (
        'poses = "path.csv"\n' + HOLE,
        "x [mm],y [mm],z [mm]\n450,150,0\n450,nan,0\n",
        ["path.csv: line 3, y", "'nan'"],
    ),
    "outside the limits": (
        'poses = "path.csv"\n' + HOLE,
        "A [deg],B [deg],Z [mm]\n0,90,0\n0,90,400\n",
        ["path.csv: line 3, joint Z", "400 mm", "-300 mm to 300 mm"],
    ),
    "unreachable row": (
        'poses = "path.csv"\n' + HOLE,
        "x [mm],y [mm],z [mm]\n450,150,0\n850,150,0\n",
        ["path.csv: line 3", "does not reach"],
    ),
    "unknown side": (
        'poses = "path.csv"\n' + HOLE,
        "x [mm],y [mm],z [mm],approach\n450,150,0,left\n",
        ["path.csv: line 2, approach", "up, down or random"],
    ),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_has_one_message_with_its_place(write, name):
    """File and key, or file and line, and exit code 2."""
    text, rows, words = MISTAKES[name]
    path = write(text, **({"path": rows} if rows else {}))
    with pytest.raises(lostmotion.InputError) as caught:
        lostmotion.task(ARM, path, robots=4, runs=2)
    assert len(caught.value.problems) == 1
    for word in words:
        assert word in str(caught.value)


def test_rows_state_joints_or_the_tool(write):
    """The same path by joint values and by points of the tool has the same answer."""
    points = np.array([[0.45, 0.15, 0.0], [0.40, 0.20, 0.02], [0.45, 0.10, 0.0]])
    q = inverse(points)
    by_tool = "x [mm],y [mm],z [mm],feature\n" + "".join(
        f"{x * 1e3:.9f},{y * 1e3:.9f},{z * 1e3:.9f},f{k}\n" for k, (x, y, z) in enumerate(points)
    )
    by_joint = "Z [mm],A [rad],B [rad],feature\n" + "".join(
        f"{z * 1e3:.12f},{a:.12f},{b:.12f},f{k}\n" for k, (a, b, z) in enumerate(q)
    )
    found = [
        lostmotion.task(ARM, write('poses = "path.csv"\n' + HOLE, path=rows), robots=50, runs=2)
        for rows in (by_tool, by_joint)
    ]
    assert [len(each.features) for each in found] == [3, 3]
    np.testing.assert_allclose(found[0].program.q, found[1].program.q, atol=1e-9)
    np.testing.assert_array_equal(found[0].program.sides, found[1].program.sides)
    np.testing.assert_allclose(found[0].place_used, found[1].place_used, rtol=1e-5)


def test_a_row_may_state_its_side(write):
    """A stated side replaces that of the path, for all joints or for one, and stays until the joint
    moves.
    """
    rows = (
        "A [deg],B [deg],Z [mm],approach,approach B\n0,90,0,up,\n1,91,0,,down\n"
        "1,91,5,,\n2,91,5,random,\n2,92,5,,\n"
    )
    stated = read_task(write('poses = "path.csv"\n' + HOLE, path=rows), ARM)
    from lostmotion.error_model.arrival import last_motion

    sides, since = last_motion(stated.q, stated.approach)
    np.testing.assert_array_equal(sides, [[1, 1, 1], [1, -1, 1], [1, -1, 1], [0, 0, 0], [0, 1, 0]])
    np.testing.assert_array_equal(since, [[0, 0, 0], [1, 1, 0], [1, 1, 2], [3, 3, 3], [3, 4, 3]])


PROGRAM = """%
G21 G90 G17 (mm, absolute)
N10 G0 X450 Y150 Z20 ; above
G0 Z0
G1 X470 F500 M3
G91 Y10
G90 G3 X450 Y180 I-20 J0
G0 Z20
G20 G2 X17.7165354 Y5.9055118 R0.75
"""


def test_a_program_is_sampled(write):
    """Lines and arcs, absolute and relative, mm and inch, against points by hand; the arm passes
    through rapid moves.
    """
    path = write('program = "part.csv"\nstep = "5 mm"\n' + HOLE, part=PROGRAM)
    stated = read_task(path, ARM)
    points = 1e3 * stated.poses[:, :3, 3]
    assert [each.name for each in stated.features] == ["path 1", "path 2"]
    assert stated.where[0][1] == "line 3"
    assert not stated.visited[:2].any()
    first = points[stated.visited][stated.features[0].places]
    np.testing.assert_allclose(first[:5], [[450 + 5 * k, 150, 0] for k in range(5)], atol=1e-9)
    np.testing.assert_allclose(first[5:7], [[470, 155, 0], [470, 160, 0]], atol=1e-9)
    arc = first[6:]
    np.testing.assert_allclose(np.hypot(arc[:, 0] - 450, arc[:, 1] - 160), 20.0, atol=1e-9)
    np.testing.assert_allclose(arc[-1], [450, 180, 0], atol=1e-9)
    assert (np.diff(arc[:, 1]) > 0).all()  # a quarter of a turn, anticlockwise
    second = points[stated.visited][stated.features[1].places]
    np.testing.assert_allclose(second[[0, -1]], [[450, 180, 20], [450, 150, 20]], atol=1e-5)
    assert (second[1:-1, 0] > 450).all()  # clockwise, from the upper end
    away = np.linalg.norm(second[:, :2] - (450 - math.sqrt(19.05**2 - 225), 165), axis=1)
    np.testing.assert_allclose(away, 19.05, atol=1e-5)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("G81 X10 Z-5", ["line 2", "G81", "G0 to G3"]),
        ("G2 X460 Y150", ["line 2", "an arc without a centre"]),
        ("G2 X460 Y150 I1 J20", ["line 2", "not at one distance"]),
        ("G1 X1e3", ["line 2", "letters, each with a number"]),
        ("G1 A90", ["line 2", "no other axis"]),
        ("G0 X450 Y150", ["no cutting move"]),
    ],
)
def test_a_program_that_cannot_be_followed(write, line, words):
    """One message with file and line."""
    path = write('program = "part.csv"\n' + HOLE, part=f"G0 X450 Y150\n{line}\n")
    with pytest.raises(lostmotion.InputError) as caught:
        read_task(path, ARM)
    assert len(caught.value.problems) == 1
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    "name",
    [
        "peg-in-hole",
        *(
            pytest.param(name, marks=pytest.mark.slow)
            for name in ("hole-pattern", "seam", "circle", "pocket", "warm-up")
        ),
    ],
)
def test_the_examples_answer(name, monkeypatch, tmp_path):
    """Every example runs on the six-axis arm, and its decisive tolerance has contributors that add
    to one.
    """
    shutil.copytree(TASKS, tmp_path / "tasks")
    path = tmp_path / "tasks" / f"{name}.toml"
    # a pocket of a quarter of the poses
    path.write_text(path.read_text("utf-8").replace('step = "5 mm"', 'step = "20 mm"'), "utf-8")
    # of each margin, which has tests of its own
    monkeypatch.setattr(task_remedies, "_STEPS", 2)
    found = lostmotion.task(TASKS.parent / "six-axis.toml", path, robots=30, runs=2)
    assert 0 <= found.success.low <= found.success.value <= found.success.high <= 1
    assert sum(found.parts.values()) == pytest.approx(1)
    assert found.figures["success"] == found.success
    assert found.result()["figures"]["task"]["success"]["value"] == found.success.value
    assert found.plots[0].figure is not None


def test_all_mistakes_in_a_warm_up_at_once(write):
    """A joint twice, and runs that follow each other for less time than one takes."""
    twice = HEAT.replace("[warm_up]", '[warm_up]\nover = "1 min"') + HEAT.removeprefix(DUTY)
    arm = lostmotion.read(TASKS.parent / "six-axis.toml")
    with pytest.raises(lostmotion.InputError) as caught:
        read_task(write(POINT + HOLE + twice.replace('"A"', '"J2"')), arm)
    assert {each.key for each in caught.value.problems} == {
        "warm_up.joints[0].joint",
        "warm_up.over",
    }


def test_a_task_that_fails_exits_with_one(write):
    """The requirement is missed: exit code 1 and the reason."""
    path = write(POINT + HOLE.replace("1 mm", "1 µm"))
    arm = path.parent / "arm.toml"
    arm.write_text(
        'name = "x"\n'
        + "".join(
            f'[[joints]]\nname = "{name}"\ntype = "revolute"\naxis = "z"\n'
            'limits = ["-170 deg", "170 deg"]\ngearbox = { backlash = "2 arcmin" }\n'
            f'link = {{ length = "{length} mm", rigid = true }}\n'
            for name, length in (("A", 400), ("B", 300))
        ),
        encoding="utf-8",
    )
    asked = ["task", str(arm), "--by", str(path), "--robots", "20", "--runs", "2", "--json"]
    done = CliRunner().invoke(app, asked)
    assert done.exit_code == 1
    assert '"succeeds": false' in done.stdout


def test_a_tolerance_that_no_error_reaches_has_no_bars():
    """The orientation of a slide without errors of rotation: nothing contributes."""
    arm = {
        "name": "slide",
        "joints": [
            {
                "name": "A",
                "type": "prismatic",
                "axis": "x",
                "limits": ("0 mm", "500 mm"),
                "encoder": {"zero": "0.1 mm"},
            }
        ],
    }
    stated = {
        "features": [{"name": "a", "kind": "point", "at": (0.2, 0.0, 0.0), "tool_rpy": (0, 0, 0)}],
        "tolerances": [{"orientation": "0.1 deg"}],
    }
    found = lostmotion.task(lostmotion.Arm.model_validate(arm), stated, robots=20, runs=2)
    assert found.success.value == 1
    assert [block.key for block in found.sheet.bars] == ["remedies"]
    found.summary()


def test_what_is_not_described_makes_the_probability_an_upper_bound():
    """An arm that lacks kinds of error succeeds at most as often as stated, and uses at least that
    share of a tolerance.
    """
    stated = {
        "features": [{"name": "a", "kind": "point", "at": (0.45, 0.15, 0.0)}],
        "tolerances": [{"sphere": 0.3e-3}],
    }
    sheet = lostmotion.task(ARM, stated, robots=50, runs=3).sheet
    assert "All tolerances hold in at most " in sheet.verdict
    assert "95 % stay within at least " in sheet.verdict
    signs = {card.title: card.number[:1] for card in sheet.cards}
    assert signs["all tolerances hold"] == "≤"
    assert signs["decisive tolerance, used"] == "≥"
