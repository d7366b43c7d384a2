"""A measured robot by ISO 9283: coverage of intervals, the sheet of synthetic visits, and
comparison with predicted robots.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lostmotion
from lostmotion.error_model.expected_repeatability import expected_repeatability
from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.error_model.visit_intervals import (
    accuracy_interval,
    outlying_visits,
    repeatability_interval,
    scatter_interval,
    student_interval,
)
from lostmotion.io.measured.visit_file import combined, read_measured
from lostmotion.io.measured.visits import Visits
from lostmotion.laws import iso9283 as iso
from lostmotion.mechanism.warm_up import WarmUp, drift, growth
from lostmotion.propagation.exact import draws_of
from lostmotion.propagation.iso9283.cube import cube_from_arguments, five_points
from lostmotion.propagation.iso9283.joint_motion import path_approach, path_poses
from lostmotion.propagation.iso9283.robots import (
    DISTANCE,
    LOADS,
    predict_robots,
    with_payload_share,
)
from lostmotion.standards.commanded_poses import commanded_cube
from lostmotion.standards.comparison import compare
from lostmotion.standards.measured_robot import evaluate

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "measured ISO 9283 sheet",
        (
            "500 synthetic tests; a UR5 by a laser tracker (mean 2.635, s 0.375, 95th "
            "percentile 3.394, largest 4.409 mm); SciPy's best-fit rotation"
        ),
        "90 % intervals cover 86 to 94 %; 0.6 µm; 1e-9",
        "tests/io/test_measured.py",
    ),
)

EXAMPLES = Path(__file__).parents[2] / "examples"


def visits_of(errors, command, sides=None, instrument=0.0):
    """Return visits (pose, visit, 3) to poses P1, P2, ... about their commands."""
    poses, count = errors.shape[:2]
    names = tuple(f"P{k + 1}" for k in range(poses) for _ in range(count))
    return Visits(
        pose=names,
        path=("",) * len(names),
        cycle=np.tile(np.arange(count, dtype=float), poses),
        side=tuple(sides or [""] * len(names)),
        load=np.ones(len(names)),
        attained=(command[:, None] + errors).reshape(-1, 3),
        command=np.repeat(command, count, axis=0),
        orientation=np.full((len(names), 3, 3), np.nan),
        rotation=np.full((len(names), 3, 3), np.nan),
        where=tuple(("made up", k) for k in range(len(names))),
        duplicates=0,
        instrument=instrument,
        source="made up",
        known={},
        load_stated=False,
    )


@settings(max_examples=15, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    poses=st.integers(1, 12),
    count=st.integers(1, 8),
    size=st.sampled_from([1e-7, 1e-5, 1e-3]),
    off=st.sampled_from([0.0, 1e-6, 1e-3]),
    flat=st.booleans(),
)
def test_every_interval_holds_its_figure(seed, poses, count, size, off, flat):
    """Each interval contains its figure, and intervals of lengths and scatters are not negative."""
    rng = np.random.default_rng(seed)
    errors = rng.normal(0, size, (poses, count, 3)) * (
        [1.0, 0.1, 0.0] if flat else 1.0
    ) + rng.normal(0, off, (poses, 1, 3))
    visits = visits_of(errors, rng.uniform(-1, 1, (poses, 3)), instrument=1e-6)
    if count == 1 and poses < 3:
        with pytest.raises(lostmotion.InputError, match="at least two visits to a pose"):
            evaluate(visits)
        return
    (found,) = evaluate(visits).loads
    lengths = [
        each
        for pose in found.poses
        for each in (pose.accuracy, pose.repeatability, pose.without_instrument, *pose.scatter)
    ]
    lengths += [each for pooled in found.pooled or () for each in pooled]
    signed = [each for pose in found.poses for each in pose.axes]
    if found.distance is not None:
        lengths, signed = [*lengths, found.distance[1]], [*signed, found.distance[0]]
    with_interval = [each for each in (*lengths, *signed) if np.isfinite(each.low)]
    assert with_interval or count == 1
    for each in with_interval:
        assert each.low <= each.value <= each.high
    assert all(each.low >= 0 for each in lengths if np.isfinite(each.low))


def test_poses_seen_from_sides_alone_beside_others_are_refused():
    """A pose visited only from stated sides, beside others visited in the standard's cycle, is
    refused in one message.
    """
    errors = np.random.default_rng(3).normal(0, 1e-5, (2, 4, 3))
    command = np.array([[0.6, 0.0, 0.4], [0.5, 0.1, 0.4]])
    with pytest.raises(lostmotion.InputError, match=r"side.*P2"):
        evaluate(visits_of(errors, command, [""] * 4 + ["x", "x", "y", "y"]))


def test_sides_everywhere_are_cycles_of_their_own():
    """Where every visit states its side, repeatability is that of each side, not of both pooled: a
    play of 0.1 mm between them is vAP, not RP.
    """
    rng = np.random.default_rng(5)
    errors = rng.normal(0, 1e-6, (2, 60, 3))
    errors[:, 30:, 0] += 1e-4
    visits = visits_of(
        errors, np.array([[0.6, 0.0, 0.4], [0.5, 0.1, 0.4]]), (["up"] * 30 + ["down"] * 30) * 2
    )
    found = evaluate(replace(visits, cycle=np.tile(np.arange(30.0), 4)))
    assert [load.side for load in found.loads] == ["up", "down"]
    for load, half in zip(found.loads, (errors[:, :30], errors[:, 30:]), strict=True):
        np.testing.assert_allclose(
            [pose.repeatability.value for pose in load.poses],
            iso.pose_repeatability(half),
            rtol=1e-9,
        )
    assert [pose.multi_directional.value for pose in found.loads[0].poses] == pytest.approx(
        [1e-4] * 2, rel=0.02
    )


def test_one_outlying_visit_is_named_and_counted():
    """One of thirty visits 5 mm off makes RP and AP what they are; both without it stand beside
    them, and normal scatter has no such visit.
    """
    rng = np.random.default_rng(7)
    errors = rng.normal(0, 3e-5, (2, 30, 3))
    errors[0, 3, 0] += 5e-3
    first, second = (
        evaluate(visits_of(errors, np.array([[0.5, 0.0, 0.6], [0.4, 0.1, 0.5]]))).loads[0].poses
    )
    ((_, line, far),) = first.outlying
    assert line == 3
    assert far == pytest.approx(5e-3, rel=0.02)
    assert first.repeatability.value > 2e-3
    assert first.without_outlying.value == pytest.approx(
        float(iso.pose_repeatability(np.delete(errors[0], 3, axis=0))), rel=1e-9
    )
    barycentre = np.linalg.norm(np.delete(errors[0], 3, axis=0).mean(axis=0))
    assert first.accuracy_without.value == pytest.approx(barycentre, rel=1e-9)
    assert first.accuracy.value > 5 * first.accuracy_without.value
    assert second.outlying == ()
    normal = np.random.default_rng(8).normal(0, 1, (200, 30, 3))
    assert not any(outlying_visits(errors) for errors in normal)


@pytest.mark.slow
def test_intervals_cover():
    """Over 500 synthetic sets of 30 normal visits, 90 % intervals of AP_p, RP_l, AP_x and RP_a
    cover the true values in 86 to 94 %.
    """
    rng = np.random.default_rng(8)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0] * [1.0, 0.3, 0.1]
    off = np.array([3.0, -1.0, 2.0])
    covariance = turn @ turn.T
    truth = (
        np.linalg.norm(off),
        float(expected_repeatability(covariance[None])[0][0]),
        off[0],
        3 * np.sqrt(covariance[0, 0]),
    )
    hits = np.zeros(4)
    for _ in range(500):
        errors = rng.normal(size=(30, 3)) @ turn.T + off
        found = (
            accuracy_interval(errors, 0.9),
            repeatability_interval(errors, 0.9),
            student_interval(errors[:, 0], 0.9),
            scatter_interval(errors[:, 0], 0.9),
        )
        hits += [each.low <= value <= each.high for each, value in zip(found, truth, strict=True)]
    assert (hits >= 430).all(), hits
    assert (hits <= 470).all(), hits


def test_a_vanishing_bias_is_not_excluded():
    """Where the mean is within its own scatter of the command, the interval of AP_p starts at
    zero.
    """
    found = accuracy_interval(np.random.default_rng(9).normal(size=(30, 3)))
    assert found.low == 0
    assert found.high > found.value / 2


def test_the_sheet_of_synthetic_visits():
    """Values follow the definitions, with distance, frames and the instrument's contribution; poses
    are in natural order.
    """
    rng = np.random.default_rng(10)
    command = five_points(np.array([0.5, 0.0, 0.4]), 0.3)
    errors = rng.normal(0, 2e-5, (5, 30, 3)) + rng.normal(0, 1e-4, (5, 1, 3)) + [5e-4, 0, 0]
    found = evaluate(visits_of(errors, command, instrument=1e-5)).loads[0]
    assert [pose.name for pose in found.poses] == ["P1", "P2", "P3", "P4", "P5"]
    for k, pose in enumerate(found.poses):
        assert pose.accuracy.value == pytest.approx(
            float(iso.pose_accuracy(errors[k], np.zeros(3)))
        )
        assert pose.repeatability.value == pytest.approx(float(iso.pose_repeatability(errors[k])))
        assert (
            0
            <= pose.without_instrument.low
            <= pose.without_instrument.value
            <= pose.without_instrument.high
            < pose.repeatability.high
        )
        assert pose.without_instrument.value == pytest.approx(
            np.sqrt(pose.repeatability.value**2 - found.floor**2)
        )
        assert pose.fitted < pose.accuracy.value
    assert found.floor == pytest.approx(3.5362e-5, rel=1e-4)
    ends = command[1] + errors[1], command[3] + errors[3]
    far = np.linalg.norm(command[3] - command[1])
    assert found.distance[0].value == pytest.approx(float(iso.distance_accuracy(*ends, far)))
    assert found.distance[1].value == pytest.approx(float(iso.distance_repeatability(*ends)))


def test_visits_from_sides_make_vap_and_nothing_else():
    """Rows with a side count for vAP only: barycentres displaced by 3 and 4 at a right angle are 5
    apart.
    """
    rng = np.random.default_rng(11)
    errors = rng.normal(0, 1e-3, (1, 90, 3))
    errors -= (
        errors.reshape(1, 3, 30, 3).mean(axis=2, keepdims=True).repeat(30, axis=2).reshape(1, 90, 3)
    )
    errors[0, 30:60] += [3.0, 0, 0]
    errors[0, 60:] += [0, 4.0, 0]
    found = visits_of(errors, np.zeros((1, 3)), sides=["x"] * 30 + ["y"] * 30 + ["z"] * 30)
    plain = visits_of(np.full((1, 2, 3), 7.0), np.zeros((1, 3)))
    both = combined([replace(found, cycle=np.tile(np.arange(30.0), 3)), plain])
    pose = evaluate(both).loads[0].poses[0]
    assert pose.multi_directional.value == pytest.approx(5.0)
    assert pose.multi_directional.low < 5 < pose.multi_directional.high
    assert pose.accuracy.value == pytest.approx(7 * np.sqrt(3))
    assert pose.visits == 2


def test_the_cube_is_known_from_its_commands():
    """Five poses on the diagonals determine centre and side; with one of them moved by 2 mm they do
    not.
    """
    command = five_points(np.array([0.5, 0.0, 0.4]), 0.3)
    centre, side, rotation = commanded_cube(visits_of(np.zeros((5, 2, 3)), command))
    assert centre == pytest.approx([0.5, 0.0, 0.4])
    assert side == pytest.approx(0.3)
    assert rotation is None
    command[2, 0] += 2e-3
    assert commanded_cube(visits_of(np.zeros((5, 2, 3)), command)) is None


def test_robots_predicted_look_like_themselves():
    """A robot drawn from the design lies within the 5th and 95th percentile in about nine of ten
    figures; one with 10 mm more AP_p does not.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    found = read_measured(EXAMPLES / "measured" / "z-arm.csv", instrument=5e-6)
    centre, side, _ = commanded_cube(found)
    predicted = predict_robots(
        arm, cube_from_arguments(arm, centre, side), robots=100, path_points=2, instrument=5e-6
    )
    rows = [
        each
        for each in compare(predicted, evaluate(found))
        if each.name in {"AP_p", "AP_p fitted", "RP_l", "vAP_p", "AD_p", "RD"}
    ]
    assert len(rows) == 20
    assert sum(each.within for each in rows) >= 16
    off = replace(found, attained=found.attained + 0.01)
    assert not any(each.within for each in compare(predicted, evaluate(off)) if each.name == "AP_p")


def test_a_path_of_a_predicted_robot_is_judged_as_predicted(tmp_path):
    """A predicted robot's readings along the path at both loads, written and read back, have its
    own AT_p and RT_p, within their intervals.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    cube = cube_from_arguments(arm, np.array([0.52, 0.0, 1.05]), 0.5)
    found = predict_robots(arm, cube, robots=3, cycles=2)
    q = path_poses(arm, cube, DISTANCE, found.path_points)
    line = cube.poses[list(DISTANCE), :3, 3]
    places = line[0] + np.linspace(0, 1, found.path_points)[:, None] * (line[1] - line[0])
    rows = [
        f"{name},,1,100,{','.join(f'{1e3 * x:.9f}' for x in (*at, *at))}"
        for name, at in zip(("P2", "P4"), line, strict=True)
    ]
    for number, load in enumerate(LOADS):
        matrix = pose_matrix(
            with_payload_share(arm, load),
            q,
            approach=path_approach(q, found.approach[DISTANCE[0]]),
        )
        cycles, attained = np.arange(found.path_cycles), []
        for k, place in enumerate(places):
            number_of_place = 2000 + 200 * number + k
            draws = draws_of(
                matrix, k, found.seed, number_of_place, np.full_like(cycles, 2), cycles
            )
            attained.append(place + (matrix.tool[k, 3:] @ draws).T)
        for cycle, points in enumerate(np.stack(attained, axis=1)):
            rows += [
                f",P2-P4,{cycle + 1},{100 * load:g},{','.join(f'{1e3 * x:.9f}' for x in at)},,,"
                for at in points
            ]
    path = tmp_path / "path.csv"
    path.write_text(
        "pose,path,cycle,load [%],x [mm],y [mm],z [mm],xc [mm],yc [mm],zc [mm]\n" + "\n".join(rows),
        encoding="utf-8",
    )
    measured = evaluate(read_measured(path)).loads
    assert [each.load for each in measured] == list(LOADS)
    for each, sheet in zip(measured, found.loads, strict=True):
        path = each.paths[0]
        assert path.shared
        assert path.figures[0] == pytest.approx(sheet.path[0, 2], rel=1e-6)
        assert path.figures[1] == pytest.approx(sheet.path[1, 2], rel=1e-6)
        accuracy, repeat = path.many[:2]
        assert accuracy.low <= sheet.path[0, 2] <= accuracy.high or sheet.path[
            0, 2
        ] == pytest.approx(accuracy.value, rel=2e-3)
        assert repeat.low < sheet.path[1].mean() < repeat.high * 1.2


def test_loads_and_paths_are_compared_with_their_own():
    """Rows at 100 % and 10 % load and the path are compared with robots under that load; a path
    that was not predicted is not compared.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    found = read_measured(EXAMPLES / "measured" / "z-arm-loads.csv", instrument=5e-6)
    centre, side, _ = commanded_cube(found)
    cube = cube_from_arguments(arm, centre, side)
    predicted, measured = predict_robots(arm, cube, robots=100, instrument=5e-6), evaluate(found)
    rows = compare(predicted, measured)
    for load in LOADS:
        names = {each.name for each in rows if each.load == load}
        assert {"AP_p", "RP_l", "AD_p", "RD", "AT_p", "RT_p"} <= names
    shown = [
        each
        for each in rows
        if each.name in {"AP_p", "AP_p fitted", "RP_l", "AD_p", "RD", "AT_p", "RT_p"}
    ]
    assert len(shown) == 38
    assert sum(each.within for each in shown) >= 32
    heavy, light = (
        next(each for each in rows if (each.name, each.load) == ("AT_p", load)) for load in LOADS
    )
    assert heavy.measured.value > 1.2 * light.measured.value
    assert not light.predicted.low.value <= heavy.measured.value <= light.predicted.high.value
    other = compare(predict_robots(arm, cube, robots=2, path=(2, 4)), measured)
    assert not [each for each in other if each.name in {"AT_p", "RT_p"}]


def test_a_link_that_warms_moves_the_tool_by_its_growth():
    """A straight arm of 0.7 m heated by 25 K with 23e-6 per K expands by 0.4025 mm, 63 % of it
    within the time constant; dAP_p follows.
    """
    joints = [
        {
            "name": name,
            "type": "revolute",
            "axis": "z",
            "limits": (-1, 1),
            "link": {"length": length},
        }
        for name, length in (("A", "400 mm"), ("B", "300 mm"))
    ]
    arm = lostmotion.Arm.model_validate({"name": "straight", "joints": joints})
    warm = WarmUp(25.0)
    grown = growth(arm, np.zeros(2), warm)
    assert grown == pytest.approx([0.7 * 23e-6 * 25, 0, 0])
    found = drift(arm, np.zeros(2), np.array([[1e-3, 0, 0], [-1e-3, 0, 0]]), warm)
    # one hour of eight in 48 steps
    assert found.shift[6] == pytest.approx(grown * (1 - np.exp(-1)), rel=1e-12)
    assert found.largest == pytest.approx(np.full(2, float(grown[0]) * (1 - np.exp(-8))))
    right = growth(arm, np.array([np.pi / 2, 0]), warm)
    assert right == pytest.approx([0, grown[0], 0], abs=1e-15)
