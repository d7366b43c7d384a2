"""Tasks of a closed chain and of a calibrated robot, against simulations of their own: two circles
that intersect, and the estimates of the robot drawn by their covariance.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model import joint_path
from lostmotion.error_model.poses import sample_poses
from lostmotion.io.task_file import read_task
from lostmotion.propagation.task_placement import best_placement
from tests.analyses.task.test_brute_force import (
    ARCMIN,
    ARM,
    CENTRE,
    COUNT,
    LENGTH,
    LINKS,
    RUNS,
    cut_normal,
    inverse,
    tool,
)

VALIDATES = (
    (
        "probability that a task of a five-bar, and of a calibrated arm, succeeds",
        "intersections of circles, and estimates drawn by their covariance, by hand",
        "within the intervals of both, at shares of 30 to 80 %",
        "propagation/task_success.py",
    ),
)
PROXIMAL, DISTAL, BASE = 0.25, 0.4, 0.2
SEARCHED = """
name = "holes"
tool_rpy = ["0 deg", "0 deg", "0 deg"]
placement = { xyz = ["100 mm", "500 mm", "0 mm"] }
search = { x = "20 mm" }
[[features]]
name = "holes"
kind = "holes"
centre = ["0 mm", "0 mm", "0 mm"]
diameter = "16 mm"
count = 3
[[tolerances]]
name = "place"
of = "holes"
cylinder = "0.2 mm"
axis = "z"
relative_to = "fitted"
"""
ROBOTS = 1500


def z_of(held, found):
    """Return by how many standard errors a share of robots and runs (robot, run) differs from the
    one found.
    """
    spread = held.mean(axis=1).std(ddof=1) / math.sqrt(len(held))
    error = math.hypot(spread, (found.high - found.low) / 3.92)
    return (held.mean() - found.value) / error


def hinge(name, limits, start, length, **more):
    """Return a hinge without clearance, and its rigid link with a length tolerance."""
    passive = {"passive": True} if limits is None else {"limits": limits}
    return {
        "name": name,
        "type": "revolute",
        **passive,
        "start": start,
        "link": {"length": f"{1e3 * length:g} mm ± 60 µm", "rigid": True},
        **more,
    }


def five_bar():
    """Return a planar five-bar with play and encoder errors in its two drives."""
    drive = {
        "gearbox": {"backlash": "0.8 arcmin ± 0.3 arcmin"},
        "encoder": {"resolution": "0.3 arcmin", "zero": "0.6 arcmin"},
    }
    return lostmotion.Arm.model_validate(
        {
            "name": "five-bar",
            "joints": [
                hinge("left", ("100 deg", "160 deg"), "130 deg", PROXIMAL, **drive),
                hinge("left-elbow", None, "-80 deg", DISTAL),
                hinge(
                    "right",
                    ("20 deg", "80 deg"),
                    "50 deg",
                    PROXIMAL,
                    after="base",
                    origin={"xyz": (BASE, 0.0, 0.0)},
                    **drive,
                ),
                hinge("right-elbow", None, "80 deg", DISTAL),
                {"name": "pin", "type": "revolute", "passive": True},
            ],
            "closures": [{"joins": ("left-elbow.tip", "pin.tip")}],
            "tool": {"after": "left-elbow.tip"},
        }
    )


def meeting(left, right, lengths):
    """Return where the distal links meet (..., 2): the upper intersection of two circles, for
    drive angles and lengths of proximal and distal links (left, right, left, right).
    """
    elbows = [
        np.stack([lengths[k] * np.cos(a) + k * BASE, lengths[k] * np.sin(a)], axis=-1)
        for k, a in enumerate((left, right))
    ]
    apart = elbows[1] - elbows[0]
    far = np.linalg.norm(apart, axis=-1, keepdims=True)
    one, other = (each[..., None] for each in np.broadcast_arrays(*lengths[2:]))
    along = (far**2 + one**2 - other**2) / (2 * far)
    up = np.sqrt(one**2 - along**2)
    unit = apart / far
    return elbows[0] + along * unit + up * np.stack([-unit[..., 1], unit[..., 0]], axis=-1)


def drives(point):
    """Return the angles of both drives (2,) that lead to a point (2,), elbows outward."""
    out = []
    for base, way in ((0.0, 1.0), (BASE, -1.0)):
        x, y = point[0] - base, point[1]
        far = math.hypot(x, y)
        inner = math.acos((PROXIMAL**2 + far**2 - DISTAL**2) / (2 * PROXIMAL * far))
        out.append(math.atan2(y, x) + way * inner)
    return np.array(out)


@pytest.mark.parametrize("size", [0.085e-3, 0.058e-3])
def test_a_five_bar_along_a_line(size):
    """Places on a line, both drives with the side of their last motion; the tolerance is missed by
    a fifth and by two thirds of all runs.
    """
    start, end = np.array([0.02, 0.5]), np.array([0.18, 0.5])
    line = start + np.linspace(0, 1, 9)[:, None] * (end - start)
    q = np.array([drives(point) for point in line])
    rng = np.random.default_rng(11)
    shape = (ROBOTS, 1, 1)
    lengths = [
        length + 6e-5 * cut_normal(rng, shape) for length in (PROXIMAL, PROXIMAL, DISTAL, DISTAL)
    ]
    angles = []
    for j in range(2):
        play = (0.8 + 0.3 * cut_normal(rng, (ROBOTS, 1))) * ARCMIN / 2
        zero = 0.6 * ARCMIN * cut_normal(rng, (ROBOTS, 1))
        side = rng.choice([-1.0, 1.0], (ROBOTS, RUNS))
        values = np.empty((ROBOTS, RUNS, len(line)))
        for row in range(len(line)):
            if row and abs(q[row, j] - q[row - 1, j]) > 1e-7:
                side = np.full((ROBOTS, RUNS), np.sign(q[row, j] - q[row - 1, j]))
            count = 0.3 * ARCMIN * rng.uniform(-0.5, 0.5, (ROBOTS, RUNS))
            values[..., row] = q[row, j] + zero + count - side * play
        angles.append(values)
    off = np.linalg.norm(meeting(*angles, lengths) - line, axis=-1).max(axis=-1)
    stated = {
        "features": [
            {
                "name": "line",
                "kind": "line",
                "start": (*start, 0.0),
                "end": (*end, 0.0),
                "tool_rpy": (0.0, 0.0, 0.0),
            }
        ],
        "step": 0.02,
        "tolerances": [{"sphere": 2 * size}],
    }
    found = lostmotion.task(five_bar(), stated, robots=ROBOTS, runs=RUNS, seed=4)
    assert abs(z_of(off < size, found.success)) < 3


@pytest.mark.parametrize("size", [0.3e-3, 0.27e-3])
def test_a_calibrated_arm_on_holes(tmp_path, size):
    """One robot whose encoder zeros and forearm were measured: its own bias, and the covariance of
    the estimates in place of the tolerances.
    """
    mean = np.array([0.4 * ARCMIN, -0.3 * ARCMIN, 6e-5])
    spread = np.array([0.08 * ARCMIN, 0.1 * ARCMIN, 2e-5])
    robot = tmp_path / "robot.toml"
    robot.write_text(
        "".join(
            f'[[estimates]]\ndraw = "{draw}"\nmean = "{m:.12g} {unit}"\n'
            f'deviation = "{s:.12g} {unit}"\n'
            for draw, m, s, unit in (
                ("joints.A.encoder.zero", *(1e3 * np.array([mean[0], spread[0]])), "mrad"),
                ("joints.B.encoder.zero", *(1e3 * np.array([mean[1], spread[1]])), "mrad"),
                ("joints.B.link.length", *(1e3 * np.array([mean[2], spread[2]])), "mm"),
            )
        ),
        encoding="utf-8",
    )
    turn = 2 * np.pi * np.arange(6) / 6
    holes = np.array(CENTRE) + 0.06 * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    found = lostmotion.task(
        ARM,
        {
            "features": [
                {
                    "name": "holes",
                    "kind": "holes",
                    "centre": CENTRE,
                    "diameter": 0.12,
                    "count": 6,
                    "tool_rpy": (0.0, 0.0, 0.0),
                }
            ],
            "tolerances": [{"sphere": 2 * size}],
        },
        calibration=robot,
        robots=ROBOTS,
        runs=RUNS,
        seed=4,
    )
    rng, q = np.random.default_rng(12), inverse(holes)
    known = mean + spread * rng.standard_normal((ROBOTS, 3))
    angles = []
    for j in range(2):
        play = (2 + 0.8 * cut_normal(rng, (ROBOTS, 1))) * ARCMIN / 2
        side = rng.choice([-1.0, 1.0], (ROBOTS, RUNS))
        values = np.empty((ROBOTS, RUNS, 6))
        for row in range(6):
            if row:
                side = np.full((ROBOTS, RUNS), np.sign(q[row, j] - q[row - 1, j]))
            count = COUNT * rng.uniform(-0.5, 0.5, (ROBOTS, RUNS))
            values[..., row] = q[row, j] + known[:, j, None] + count - side * play
        angles.append(values)
    first = LINKS[0] + LENGTH * cut_normal(rng, (ROBOTS, 1, 1))
    second = LINKS[1] + known[:, 2, None, None]
    points = tool(*angles, q[:, 2], first, second)[0]
    off = np.linalg.norm(points - holes, axis=-1).max(axis=-1)
    assert abs(z_of(off < size, found.success)) < 3


def test_a_search_of_the_placement_samples_the_poses_of_an_arm_once(tmp_path, monkeypatch):
    """For all placements that are tried, with the same joint values as a path of its own."""
    counted = []

    def sampled(*given, **options):
        counted.append(given)
        return sample_poses(*given, **options)

    monkeypatch.setattr(joint_path, "sample_poses", sampled)
    file = tmp_path / "task.toml"
    file.write_text(SEARCHED, encoding="utf-8")
    arm = five_bar()
    program, placement = best_placement(arm, read_task(file, arm), 1)
    assert placement.reached == placement.tried > 10
    assert len(counted) == 1
    again, count = joint_path.joint_path(
        arm, program.placement @ program.task.poses, with_orientation=False
    )
    assert count == len(again)
    np.testing.assert_array_equal(program.q, again)
