"""Errors of a task: ISO 9283 as a special case, the contributors, a process force, and how much the
task would bear.
"""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model.drawing_tolerances import measure
from lostmotion.error_model.task import program_of
from lostmotion.io.task_file import read_task
from lostmotion.laws import iso9283 as iso
from lostmotion.laws.iso9283 import path_figures
from lostmotion.propagation.iso9283.cube import cube_from_arguments
from lostmotion.propagation.iso9283.joint_motion import path_approach, path_poses
from lostmotion.propagation.iso9283.robots import predict_robots
from lostmotion.propagation.task_remedies import remedies
from lostmotion.propagation.task_success import shares
from lostmotion.propagation.tool_errors import tool_errors
from tests.analyses.task.test_brute_force import ARM, STATED
from tests.arms import JOINT, arm_of

VALIDATES = (
    (
        "RP, AP, AT and RT of the poses of a task; contributors; margins",
        (
            "the ISO 9283 sheet of the same cube and line, from other draws; sampled products of "
            "each part with the whole; the arm with that play in its file"
        ),
        "3 to 5 %; 2 % of the mean square; 5 % of the factor",
        (
            "propagation/task_success.py propagation/task_remedies.py error_model/task.py "
            "propagation/iso9283/robots.py propagation/iso9283/joint_motion.py"
        ),
    ),
    (
        "best placement of a task",
        "an arm whose error grows with the distance from its axis: the search moves towards it",
        "the sign of the move",
        "propagation/task_placement.py",
    ),
)
ROBOTS, CYCLES = 200, 30


def rows(path, q, arm, **more):
    """Return the program of a task that visits these joint values."""
    names = [joint.name for joint in arm.driven]
    text = ",".join(f"{name} [rad]" for name in names)
    path.mkdir(exist_ok=True)
    (path / "q.csv").write_text(
        text + "\n" + "\n".join(",".join(f"{x:.15g}" for x in row) for row in q), encoding="utf-8"
    )
    extra = "".join(f"{key} = {value}\n" for key, value in more.items())
    task = path / "task.toml"
    task.write_text(f'poses = "q.csv"\n{extra}[[tolerances]]\nsphere = "5 mm"\n', encoding="utf-8")
    return program_of(arm, read_task(task, arm))


def all_errors(program, robots, runs, seed=7):
    """Return the errors (place, robot, run, 6) of all robots."""
    parts = [e for _, e in tool_errors(program.matrix(), seed, robots, runs, program.since)]
    return np.concatenate(parts, axis=2).transpose(0, 2, 3, 1)


@functools.cache
def sheet():
    """Return the ISO 9283 sheet of an arm in a small cube."""
    arm = arm_of(4)
    cube = cube_from_arguments(arm, np.array([1.2, 0.0, 0.2]), 0.15)
    return arm, predict_robots(arm, cube, cycles=CYCLES, robots=ROBOTS, seed=3, loads=(1.0,))


def test_rp_and_ap_are_a_task(tmp_path):
    """The standard's cycle as a task that runs over and over: the same sides, AP and RP."""
    _, found = sheet()
    program = rows(tmp_path / "a", found.cube.q[::-1], found.arm, repeated="true")
    moving = program.sides[::-1] != 0
    np.testing.assert_array_equal(program.sides[::-1][moving], found.approach[moving])
    shift = all_errors(program, ROBOTS, CYCLES)[::-1, ..., 3:]
    load = found.loads[0]
    assert iso.pose_repeatability(shift).mean() == pytest.approx(
        load.repeatability.mean(), rel=0.03
    )
    reached = np.linalg.norm(iso.axis_accuracy(shift), axis=-1)
    assert reached.mean() == pytest.approx(load.accuracy.mean(), rel=0.05)


def test_at_and_rt_are_a_task(tmp_path):
    """The line of the standard as a path: AT and RT at its worst point."""
    _, found = sheet()
    q = path_poses(found.arm, found.cube, found.path_ends, found.path_points)
    run_up = np.vstack([2 * q[0] - q[1], q])
    program = rows(tmp_path / "b", run_up, found.arm)
    moving = program.sides[1:] != 0
    expected = path_approach(q, found.approach[found.path_ends[0]])
    np.testing.assert_array_equal(program.sides[1:][moving], expected[moving])
    errors = all_errors(program, ROBOTS, found.path_cycles)[1:]
    a, b = found.path_ends
    along = found.cube.poses[b, :3, 3] - found.cube.poses[a, :3, 3]
    figures = np.array([path_figures(each, along) for each in errors]).max(axis=0)
    load = found.loads[0]
    assert figures[0].mean() == pytest.approx(load.path[0].mean(), rel=0.05)
    assert figures[1].mean() == pytest.approx(load.path[1].mean(), rel=0.05)


def test_contributors_are_those_of_the_samples(tmp_path):
    """The exact share of each part in the mean square of a tolerance relative to a fitted frame
    against the mean product of sampled errors of the part and of all.
    """
    arm = arm_of(3)
    rng = np.random.default_rng(2)
    q = rng.uniform(-0.8, 0.8, (5, 3))
    program = rows(tmp_path / "c", q, arm)
    check = measure(
        replace(program.task.tolerances[0], datum="fitted"), program.features, program.places
    )
    matrix = program.matrix()
    operator = check.operator(2, len(q))
    found = shares(program, matrix, operator, "part")
    assert sum(found.values()) == pytest.approx(1.0)

    def components(one):
        parts = [e for _, e in tool_errors(one, 5, 6000, 2, program.since)]
        return np.einsum("cpi,pirv->crv", operator, np.concatenate(parts, axis=2))

    whole = components(matrix)
    total = (whole**2).sum(axis=0).mean()
    for part in list(found)[:5]:
        only = np.array([float(info.owner == part) for info in matrix.infos])
        product = (components(matrix.scaled(only)) * whole).sum(axis=0).mean()
        assert product / total == pytest.approx(found[part], abs=0.02)


def test_a_force_along_the_path_bends_the_arm():
    """A slide on a spring of 1 N/µm: 40 N along the path move it by 40 µm, with 25 % from run to
    run.
    """
    arm = lostmotion.Arm.model_validate(
        {
            "name": "slide",
            "joints": [
                {
                    "name": axis,
                    "type": "prismatic",
                    "axis": axis,
                    "limits": ("-1 m", "1 m"),
                    "gearbox": {"lead": "10 mm", "stiffness": "1 N/µm"},
                }
                for axis in "xyz"
            ],
        }
    )
    stated = {
        "force": {"along": 40.0, "scatter": 0.25},
        "features": [
            {"name": "seam", "kind": "line", "start": (0.0, 0.0, 0.0), "end": (0.3, 0.4, 0.0)}
        ],
        "tolerances": [{"box": (1e-3, 1e-3, 1e-3)}],
    }
    program = program_of(arm, read_task(stated, arm))
    way = np.array([0.6, 0.8, 0.0])
    mean = program.matrix().bias[:, 3:]
    np.testing.assert_allclose(mean, np.tile(40e-6 * way, (21, 1)), rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(program.varying[:, 3:], 0.25 * mean, rtol=1e-6, atol=1e-12)
    found = lostmotion.task(arm, stated, robots=500, runs=4)
    share = 0.25**2 / (1 + 0.25**2)
    assert found.parts["process force"] == pytest.approx(share, rel=1e-6)
    assert found.outcomes[0].used.value == pytest.approx(
        40e-6 * 0.8 * (1 + 0.25 * 1.645) / 0.5e-3, rel=0.03
    )


def test_the_margin_of_play_holds_in_the_arm_itself():
    """With the play of the file scaled by the margin found, the requirement is just met."""
    stated = {
        "required": 0.6,
        "features": [{"name": "a", "kind": "point", "at": (0.45, 0.15, 0.0)}],
        "tolerances": [{"cylinder": 0.5e-3, "axis": "z"}],
    }
    found = lostmotion.task(ARM, stated, robots=600, runs=4, seed=2)
    margin = next(each for each in found.helps.margins if each.name.startswith("play"))
    assert margin.factor > 1

    def with_play(factor):
        play = {"backlash": f"{2 * factor} arcmin ± {0.8 * factor} arcmin"}
        arm = lostmotion.Arm.model_validate(
            {
                **STATED,
                "joints": [
                    {**joint, "gearbox": play} if "gearbox" in joint else joint
                    for joint in STATED["joints"]
                ],
            }
        )
        return lostmotion.task(arm, stated, robots=250, runs=4, seed=2).success.value

    assert with_play(0.97 * margin.factor) > 0.59
    assert with_play(1.05 * margin.factor) < 0.61


def test_the_margin_of_payload_ends_where_the_arm_falls(tmp_path):
    """An upright arm on a spring k carries m at the height h while m g h < k; just before, the
    error d of its encoder moves the tool by h d / (1 - m g h / k), to the edge of the sphere.
    """
    stiffness, height, mass = 200.0, 0.5, 1.0
    arm = lostmotion.Arm.model_validate(
        {
            "name": "upright",
            "joints": [
                {
                    "name": "A",
                    "type": "revolute",
                    "axis": "y",
                    "limits": ("-100 deg", "10 deg"),
                    "gearbox": {"stiffness": f"{stiffness} N m/rad"},
                    "encoder": {"resolution": "0.5 arcmin"},
                    "link": {"length": height, "rigid": True},
                }
            ],
            "payload": {"mass": mass},
        }
    )
    program = rows(tmp_path, [[-np.pi / 2]], arm)
    found = remedies(program, program.matrix(), 0, [], 20, 1, 1)
    (margin,) = (each for each in found.margins if each.name == "payload")
    falls, edge = stiffness / (mass * arm.gravity * height), 5e-3
    largest = height * np.radians(0.25 / 60)
    assert margin.factor == pytest.approx(falls * (1 - largest / edge), rel=0.006)


def test_a_placement_is_found():
    """Near the axis the same angles move the tool less: the search moves the task towards it."""
    stated = {
        "placement": {"xyz": (0.5, 0.0, 0.0)},
        "search": {"x": 0.15},
        "features": [{"name": "a", "kind": "point", "at": (0.0, 0.0, 0.0)}],
        "tolerances": [{"sphere": 0.5e-3}],
    }
    found = lostmotion.task(ARM, stated, robots=50, runs=2)
    assert found.placed.after < found.placed.before
    assert found.program.places.points[0, 0] == pytest.approx(0.5 + found.placed.moved[0])
    assert found.placed.moved[0] < -0.1
    assert found.placed.tried == 49


def test_the_reversal_error_of_the_sheet_is_that_of_the_task(tmp_path):
    """Without scatter of the play every robot has the same reversal error: the sheet's along its
    line, and the task's along the same joint values.
    """
    play = {**JOINT["gearbox"], "backlash": "0.5 arcmin"}
    arm = arm_of(4, gearbox={key: play[key] for key in ("backlash", "stiffness", "ratio")})
    cube = cube_from_arguments(arm, np.array([1.2, 0.0, 0.2]), 0.15)
    found = predict_robots(arm, cube, cycles=2, robots=5, path_cycles=2, loads=(1.0,))
    q = path_poses(arm, cube, found.path_ends, found.path_points)
    # beyond both ends, so that all joints move at every place
    q = np.vstack([2 * q[0] - q[1], q, 2 * q[-1] - q[-2]])
    rows(tmp_path / "d", q, arm)
    answer = lostmotion.task(arm, tmp_path / "d" / "task.toml", robots=2, runs=1)
    expected = answer.reversal[1:-1].max()
    assert expected > 1e-5
    np.testing.assert_allclose(found.loads[0].path_reversal, expected, rtol=1e-6)
