"""The command `calibrate`: files of measurements, the sentence, and the file that others take."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

import numpy as np
import pytest

import lostmotion
from lostmotion.analyses.calibrate.answer import corrected_radius
from lostmotion.calibration.alignment import align
from lostmotion.calibration.correction import expected_tool
from lostmotion.calibration.geometry import exact_chain, mdh_of
from lostmotion.errors import InputError
from lostmotion.io.calibration_file import read_calibration
from lostmotion.io.measured.calibration_visits import read_calibration_visits
from lostmotion.mechanism.state import state_of
from tests.calibration.ur5_grid import ARM, GRID, grid_model

if TYPE_CHECKING:
    from pathlib import Path

HEADER = "J1 [deg],J2 [deg],J3 [deg],J4 [deg],J5 [deg],J6 [deg],x [mm],y [mm],z [mm]"


@functools.cache
def twenty() -> tuple[np.ndarray, np.ndarray]:
    """Return joint values (deg) and attained points (mm) of every 50th row of the grid."""
    table = np.genfromtxt(GRID, delimiter=",", names=True)[::50]
    joints = np.column_stack([table[f"joint_{k}"] for k in range(1, 7)])
    beside = np.column_stack([table[f"{axis}_dif"] for axis in "xyz"])
    nominal = state_of(lostmotion.read(ARM), np.radians(joints)).frames[-1, :, :3, 3]
    return joints, 1000 * nominal - beside


def written(path: Path, joints: np.ndarray, points: np.ndarray, header: str = HEADER) -> Path:
    """Write a file of measurements and return its path."""
    rows = [",".join(f"{each:.17g}" for each in row) for row in np.hstack([joints, points])]
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> lostmotion.Calibrated:
    """Calibrate the UR5 by twenty poses."""
    path = written(tmp_path_factory.mktemp("ur5") / "visits.csv", *twenty())
    return lostmotion.calibrate(ARM, path, terms="geometry", noise="70 µm")


def test_the_sentence_names_accuracy_and_the_part(found):
    """Accuracy before and after is that at held-out poses, and the axis that is out of tolerance is
    named with its size.
    """
    assert found.sheet.verdict.startswith("Before 0.85")
    (finding,) = found.findings
    assert finding.startswith("J4.seat.tilt 2 is 12.2 mrad")
    assert "24 times" in finding
    assert "not in the arm file" in finding
    tilt = next(each for each in found.terms if each.released > 1)
    assert abs(tilt.value) == pytest.approx(11.8e-3, rel=0.05)
    assert found.held_out.mean < 0.25e-3


def test_a_student_prior_names_the_same_part(tmp_path):
    """With its stated prior, how many of these the estimate is, and no other part."""
    path = written(tmp_path / "visits.csv", *twenty())
    asked = {"terms": "geometry", "noise": "70 µm", "prior": "student-t"}
    found = lostmotion.calibrate(ARM, path, **asked)
    (finding,) = found.findings
    assert finding.startswith("J4.seat.tilt 2 is 12.2 mrad")
    assert "24 times" in finding
    tilt = next(each for each in found.terms if each.released > 1)
    assert tilt.prior == pytest.approx(0.5e-3)


def test_every_command_takes_its_file(found, tmp_path):
    """robot.toml holds the estimates and their covariance, and a study of that robot predicts the
    tool where it was measured, but for the base and tool frame, which are no errors of the robot.
    """
    out = found.report(tmp_path / "out")
    arm = lostmotion.read(ARM)
    read = read_calibration(out / "robot.toml", arm)
    assert read.streams == found.calibration.streams
    np.testing.assert_array_equal(read.mean, found.calibration.mean)
    np.testing.assert_allclose(read.covariance, found.calibration.covariance, atol=1e-7)
    joints, points = twenty()
    matrix = lostmotion.screws(state_of(arm.calibrated(read), np.radians(joints)))
    predicted = state_of(arm, np.radians(joints)).frames[-1].copy()
    predicted[:, :3, 3] += matrix.summed.bias[:, 3:]
    assert align(predicted, points / 1000).left < 0.15e-3
    assert "base and tool frame that fit it best" in arm.calibrated(read).remarks[0]


def craig(a, alpha, d, theta):
    """Return frame i in frame i-1, Craig, Introduction to Robotics, equation 3.6."""
    ca, sa, ct, st = np.cos(alpha), np.sin(alpha), np.cos(theta), np.sin(theta)
    return np.array(
        [
            [ct, -st, 0, a],
            [st * ca, ct * ca, -sa, -sa * d],
            [st * sa, ct * sa, ca, ca * d],
            [0, 0, 0, 1],
        ]
    )


def test_its_geometry_is_written_for_other_programs(found, tmp_path):
    """The tool by calibrated.urdf, and by mdh.csv and the textbook's matrix, is that of the exact
    composition of the estimates within a nanometre, also where two axes are nearly parallel.
    """
    out = found.report(tmp_path / "out")
    measured = found.robot.arm.calibrated(found.robot.calibrations.as_measured)
    q = np.radians(twenty()[0])
    expected = expected_tool(measured, q)
    there = state_of(lostmotion.read(out / "calibrated.urdf"), q).frames[-1]
    np.testing.assert_allclose(there, expected, atol=1e-9)
    assert "calibration rising" not in (out / "calibrated.urdf").read_text()
    head, *rows = [
        line for line in (out / "mdh.csv").read_text().splitlines() if not line.startswith("#")
    ]
    assert head == "joint,a [mm],alpha [deg],d [mm],theta [deg]"
    table = np.array([[float(cell) for cell in row.split(",")[1:]] for row in rows])
    a, alpha, d, theta = (table * [1e-3, np.pi / 180, 1e-3, np.pi / 180]).T
    assert np.abs(d).max() > 1  # of the parallel axes of the upper arm
    frames = mdh_of(exact_chain(measured))
    for values, wanted in zip(q, expected, strict=True):
        tool = frames.base
        for k in range(6):
            tool = tool @ craig(a[k], alpha[k], d[k], theta[k] + values[k])
        np.testing.assert_allclose(tool @ frames.tool, wanted, atol=1e-9)


def test_commands_that_miss_their_pose_are_named(found, tmp_path):
    """A robot whose fourth axis is tilted cannot reach the nominal pose with a stretched elbow: the
    notes name the line and the distance; where every pose is reached they are silent.
    """
    assert not found.remaining
    joints, points = twenty()
    stretched = np.array([[20.0, -60.0, 0.05, -30.0, 70.0, 10.0]])
    robot = found.robot.arm.calibrated(found.robot.calibrations.as_measured)
    attained = 1000 * expected_tool(robot, np.radians(stretched))[:, :3, 3]
    path = written(
        tmp_path / "visits.csv", np.vstack([joints, stretched]), np.vstack([points, attained])
    )
    missing = lostmotion.calibrate(ARM, path, terms="geometry", noise="70 µm")
    command, left = missing.corrections
    tool = expected_tool(
        missing.robot.arm.calibrated(missing.robot.calibrations.as_measured), command
    )
    nominal = state_of(missing.robot.arm, missing.visits.q).frames[-1]
    off = np.linalg.norm(tool[:, :3, 3] - nominal[:, :3, 3], axis=1)
    assert left == pytest.approx(off)
    assert off[20] > 1e-3
    (note,) = missing.remaining
    assert " miss 1 of 21 poses " in note
    assert f" line 22 by {1e3 * off[20]:.3g} mm" in note
    assert note in missing.sheet.notes


def test_the_predicted_radius_holds_the_unused_rows(found):
    """Of the other 980 rows of the grid 92 to 98 % are within the 95 % radius that is predicted for
    corrected commands, with the noise of the tracker.
    """
    model, measured = grid_model()
    others = np.setdiff1d(np.arange(1000), np.arange(0, 1000, 50))
    q = model.matrix.state.q[others]
    robot = found.robot.arm.calibrated(found.robot.calibrations.as_measured)
    error = np.linalg.norm(expected_tool(robot, q)[:, :3, 3] - measured.measured[others], axis=1)
    radius = np.hypot(corrected_radius(found.robot, q), 2.795 * 70e-6)
    assert 0.92 <= (error <= radius).mean() <= 0.98
    (section,) = [each for each in found.sheet.sections if each.key == "predicted"]
    assert len(section.rows) == 2


def test_the_map_of_the_predicted_radius_marks_measured_poses(found):
    """From above and from the side, each measured pose once in each view."""
    (plot,) = [each for each in found.plots if each.key == "map"]
    held = found.held_out.covered
    for on in plot.figure.axes:
        inside, beyond = (len(line.get_xdata()) for line in on.get_lines())
        assert (inside, beyond) == (held.sum(), (~held).sum())
        assert len(on.patches) > 1


def test_poses_in_a_slab_are_reported():
    """Every 40th row of the grid lies at one height."""
    visits = read_calibration_visits(GRID, lostmotion.read(ARM))
    rows = np.arange(0, 1000, 40)
    part = type(visits)(q=visits.q[rows], difference=visits.difference[rows], lines=tuple(rows))
    answer = lostmotion.calibrate(ARM, part, terms="geometry", noise="70 µm")
    assert any("slab" in text for text in answer.warnings)


def spoiled(what: str) -> tuple[np.ndarray, np.ndarray, str]:
    """Return measurements with one mistake."""
    joints, points = (each.copy() for each in twenty())
    header = HEADER
    if what == "not a number":
        points[3, 1] = np.nan
    elif what == "two rows":
        joints, points = joints[:2], points[:2]
    elif what == "equal rows":
        joints[:], points[:] = joints[0], points[0]
    elif what == "beyond the limits":
        joints[4, 2] = 400
    elif what == "metres in one column":
        points[:, 0] /= 1000
    elif what == "another arm":
        joints = joints[:, ::-1]
    elif what == "a longer tool":
        arm = lostmotion.read(ARM)
        frames = state_of(arm, np.radians(joints)).frames[-1]
        points = points + 90 * frames[:, :3, 2]
    elif what == "no column":
        header = header.replace("J3 [deg]", "elbow [deg]")
    return joints, points, header


@pytest.mark.parametrize(
    ("what", "text"),
    [
        ("not a number", "line 5"),
        ("two rows", "2 different rows"),
        ("equal rows", "in every row"),
        ("beyond the limits", "line 6, J3"),
        ("metres in one column", "x, about 0.0"),
        ("another arm", "% of the reach"),
        ("a longer tool", "z 8[5-9]"),
        ("no column", "no column for J3"),
    ],
)
def test_a_wrong_file_is_refused_with_its_row(what, text, tmp_path):
    """NaN, too few or equal rows, units that differ, values beyond the limits, another arm and
    another tool are refused by name.
    """
    path = written(tmp_path / "visits.csv", *spoiled(what))
    with pytest.raises(InputError, match=text):
        lostmotion.calibrate(ARM, path, terms="geometry", noise="70 µm")


@pytest.mark.parametrize(
    ("old", "new", "texts"),
    [
        ("J6 [deg]", "J9 [deg]", ("no column for J6", "J9, which is no joint")),
        ("J3 [deg]", "J_3 [deg]", ("no column for J3", "J_3, which is no joint", "mean 'J3'")),
        ("J6 [deg],", "J6 [deg],J7 [deg],", ("J7, which is no joint",)),
    ],
)
def test_an_unknown_joint_is_named_with_the_missing_one(old, new, texts, tmp_path):
    """All at once; and a further joint of another arm, which the file would hold besides."""
    joints, points = twenty()
    more = [joints[:, :1]] * new.count("J7")
    path = written(tmp_path / "v.csv", np.hstack([joints, *more]), points, HEADER.replace(old, new))
    with pytest.raises(InputError) as refused:
        read_calibration_visits(path, lostmotion.read(ARM))
    for text in texts:
        assert text in str(refused.value)
    assert len(refused.value.problems) == len([text for text in texts if "mean" not in text])


def test_a_share_of_few_rows_is_not_judged(found):
    """Twenty rows state their coverage, and that nobody compares it with 95 %."""
    notes = {section.key: section.note for section in found.sheet.sections}
    assert "not judged from fewer than 40 poses" in notes["accuracy"]
    assert "fewer than 40 poses" in notes["predicted"]


def test_a_plan_refuses_another_arm_too(tmp_path):
    """Poses are not planned by measurements of another arm."""
    path = written(tmp_path / "visits.csv", *spoiled("another arm"))
    with pytest.raises(InputError, match="% of the reach"):
        lostmotion.calibrate(ARM, path, plan=1)


def test_joints_may_be_mapped_after_other_columns(tmp_path):
    """One text that maps a coordinate first and then the joints by their names is read whole."""
    header = "q1 [deg],q2 [deg],q3 [deg],q4 [deg],q5 [deg],q6 [deg],px [mm],y [mm],z [mm]"
    path = written(tmp_path / "visits.csv", *twenty(), header)
    text = "x = px [mm]" + "".join(f", J{k} = q{k} [deg]" for k in range(1, 7))
    read = read_calibration_visits(path, lostmotion.read(ARM), [text])
    np.testing.assert_allclose(read.q, np.radians(twenty()[0]))
    np.testing.assert_allclose(read.point, twenty()[1] / 1000)


def test_rows_kept_aside_have_no_effect_on_the_estimates(tmp_path):
    """A millimetre that is added to them raises their error alone."""
    joints, points = twenty()
    aside = np.sort(np.random.default_rng(1).permutation(20)[:8])
    found = []
    for wrong in (0, 1):
        moved = points.copy()
        moved[aside, 2] += wrong
        path = written(tmp_path / "visits.csv", joints, moved)
        answer = lostmotion.calibrate(ARM, path, terms="geometry", noise="70 µm", hold_out="40 %")
        found.append((answer.calibration.mean, answer.robot.aside.mean))
        assert len(answer.visits) == 12
        assert [row.label for row in answer.sheet.sections[0].rows][4] == "kept aside"
    np.testing.assert_array_equal(found[0][0], found[1][0])
    assert found[1][1] > found[0][1] + 0.5e-3
    with pytest.raises(InputError, match="leaves at least 3 of 20"):
        lostmotion.calibrate(ARM, path, hold_out=0.9)


def test_a_file_states_its_instrument(tmp_path):
    """Above its rows, or by an option, which takes precedence; noise and deviations too."""
    joints, points = twenty()
    head = "# instrument: dial\n# noise: 30 µm\n# deviations: turn 0.2 mrad, shift = 0.1 mm\n"
    head += "# payload: 2 kg\n# temperature: 23 °C\n# free text: of any kind\n"
    header = HEADER + ",dial [mm]"
    path = written(tmp_path / "both.csv", joints, np.hstack([points, points[:, 2:] * 0]), header)
    rows = path.read_text()
    path.write_text(head + rows)
    arm = lostmotion.read(ARM)
    dial = read_calibration_visits(path, arm)
    assert dial.readings.kind == "dial"
    assert dial.noise == pytest.approx(30e-6)
    assert (dial.sizes.turn, dial.sizes.shift, dial.sizes.zero) == pytest.approx((2e-4, 1e-4, 1e-3))
    assert [text[:21] for text in dial.remarks] == [
        "measured with a paylo",
        "measured at 23 °C; th",
    ]
    points_read = read_calibration_visits(path, arm, instrument="tracker")
    np.testing.assert_allclose(points_read.point, points / 1000)
    path.write_text(rows)
    with pytest.raises(InputError, match="one kind of measurement, or --instrument"):
        read_calibration_visits(path, arm)


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("# instrument: dail", "dial"),
        ("# noise: 3", "noise"),
        ("# noise: -3 mm", "# noise: 20 µm"),
        ("# noise: 1e200 m", "at most 1 m"),
        ("# noise: 1e-19 m", "at least 1e-09 m"),
        ("# deviations: turn 1e200 rad", "# deviations: turn 0.2 mrad"),
        ("# camera: fx 1e-300, fy 800, cx 320, cy 240", "# camera: fx 800"),
        ("# temperature: 1e6 °C", "at most 200 °C"),
        ("# deviations: tilt 1 mrad", "tilt"),
        ("# deviations: turn 1 mm", "turn"),
        ("# Noise = -3 mm", "# noise: 20 µm"),
        ("# noise 3", "noise"),
        ("# nosie: 20 µm", "# noise"),
        ("# Pay load = 2 kg", "# payload"),
        ("# noise: 20 µm\n# NOISE: 30 µm", "line 3"),
    ],
)
def test_a_wrong_line_above_the_rows_is_refused(line, text, tmp_path):
    """With its number."""
    path = written(tmp_path / "visits.csv", *twenty())
    path.write_text(f"# free\n{line}\n" + path.read_text())
    with pytest.raises(InputError, match=r"line [23]") as refused:
        lostmotion.calibrate(ARM, path)
    assert refused.match(text)


@pytest.mark.parametrize("line", ["# noise: 30 µm", "#Noise = 30 µm", "# NOISE 30 µm"])
def test_a_line_above_the_rows_is_read_as_people_write_it(line, tmp_path):
    """With a colon, an equals sign or neither; and other comments are free."""
    path = written(tmp_path / "visits.csv", *twenty())
    free = "# notes: noise was low\n# operator: A\n# signed\n"
    path.write_text(f"{free}{line}\n" + path.read_text())
    assert read_calibration_visits(path, lostmotion.read(ARM)).noise == pytest.approx(30e-6)


def test_duplicates_and_wrong_rows_are_named(tmp_path):
    """A row that is repeated is dropped, and one that is wrong by 5 mm is weighted down by its
    line.
    """
    joints, points = (np.vstack([each, each[:1]]) for each in twenty())
    points[7, 0] += 5
    path = written(tmp_path / "visits.csv", joints, points)
    answer = lostmotion.calibrate(ARM, path, terms="geometry")
    assert any("1 duplicate row dropped" in text for text in answer.warnings)
    assert any("not counted in the accuracy: line 9" in text for text in answer.warnings)


def test_repeated_measurements_show_their_scatter(tmp_path):
    """Each of seven poses three times, by 30 µm: the interval holds it, whatever the model lacks."""
    joints, points = (np.repeat(each[:7], 3, axis=0) for each in twenty())
    points = points + np.random.default_rng(2).normal(0, 0.03, points.shape)
    path = written(tmp_path / "visits.csv", joints, points)
    answer = lostmotion.calibrate(ARM, path, terms="geometry")
    found = answer.repeats
    assert (found.poses, found.rows) == (7, 21)
    assert found.low < 30e-6 < found.high
    direct = (points.reshape(7, 3, 3).var(axis=1, ddof=1).mean() ** 0.5) / 1000
    assert found.deviation == pytest.approx(direct, rel=1e-3)
    (section,) = [each for each in answer.sheet.sections if each.key == "repeats"]
    assert section.rows[0].note == "21 rows at 7 poses"
    assert answer.sheet.counts == "21 visits of 7 poses, seed 1"
    assert len(answer.held_out.error) == len(answer.corrections[0]) == 7


@pytest.fixture(scope="module")
def without_row_7(tmp_path_factory: pytest.TempPathFactory) -> lostmotion.Calibrated:
    """Calibrate the UR5 by nineteen of the poses."""
    others = (np.delete(each, 7, axis=0) for each in twenty())
    path = written(tmp_path_factory.mktemp("clean") / "visits.csv", *others)
    return lostmotion.calibrate(ARM, path, terms="geometry")


@pytest.mark.parametrize("wrong", [0.3, 2.0])
def test_a_gross_mistake_is_as_if_it_had_not_been_measured(wrong, without_row_7, tmp_path):
    """Of a row that is 0.3 or 2 m off all that remains is its line. Before, predictions of the
    others were decimetres off, with a warning alone.
    """
    joints, points = twenty()
    points = points.copy()
    points[7, 0] += 1000 * wrong
    path = written(tmp_path / "visits.csv", joints, points)
    answer = lostmotion.calibrate(ARM, path, terms="geometry")
    np.testing.assert_array_equal(answer.calibration.mean, without_row_7.calibration.mean)
    assert answer.warnings[0].startswith("1 row far from where this arm can be")
    assert answer.warnings[0].endswith("line 9")


def test_rows_at_two_poses_are_refused(tmp_path):
    """However many they are."""
    joints, points = (np.repeat(each[:2], 9, axis=0) for each in twenty())
    points = points + np.random.default_rng(2).normal(0, 0.03, points.shape)
    with pytest.raises(InputError, match="18 rows at 2 poses"):
        lostmotion.calibrate(ARM, written(tmp_path / "visits.csv", joints, points))


def test_another_frame_of_the_instrument_is_removed(tmp_path):
    """Points in the frame of a tracker lead to the same estimates."""
    joints, points = twenty()
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    path = written(tmp_path / "visits.csv", joints, points @ turn.T + [3000, -200, 700])
    answer = lostmotion.calibrate(ARM, path, terms="geometry", noise="70 µm")
    tilt = next(each for each in answer.terms if each.released > 1)
    assert abs(tilt.value) == pytest.approx(11.8e-3, rel=0.05)


def test_distances_to_two_centres_calibrate_too(tmp_path):
    """A draw wire to two sockets, of which neither the places nor the zero are known, finds the
    same axis out of tolerance from 60 poses.
    """
    table = np.genfromtxt(GRID, delimiter=",", names=True)[::16]
    joints = np.column_stack([table[f"joint_{k}"] for k in range(1, 7)])
    beside = np.column_stack([table[f"{axis}_dif"] for axis in "xyz"])
    arm = lostmotion.read(ARM)
    points = 1000 * state_of(arm, np.radians(joints)).frames[-1, :, :3, 3] - beside
    lines = [HEADER.replace("x [mm],y [mm],z [mm]", "distance [mm],to")]
    for k, (row, point) in enumerate(zip(joints, points, strict=True)):
        centre = ([-900, 300, -200], [100, -800, 100])[k % 2]
        cells = [f"{each:.12g}" for each in (*row, np.linalg.norm(point - centre) - 12)]
        lines.append(",".join([*cells, "AB"[k % 2]]))
    path = tmp_path / "wire.csv"
    path.write_text("\n".join(lines) + "\n")
    answer = lostmotion.calibrate(arm, path, terms="geometry", noise="70 µm")
    assert answer.findings[0].startswith("J4.seat.tilt 2")
    assert answer.held_out.mean < answer.before.mean() / 2
    assert answer.sheet.verdict


def test_a_wrong_row_is_not_counted_in_the_accuracy(tmp_path):
    """A row that is wrong by 50 mm leaves the mean error as it is without it."""
    joints, points = twenty()
    points = points.copy()
    points[7] += 50
    path = written(tmp_path / "visits.csv", joints, points)
    answer = lostmotion.calibrate(ARM, path, terms="geometry")
    assert (~answer.counted).sum() == 1
    assert answer.errors_held_out[1].mean() < 0.3e-3
    assert "not counted in the accuracy: line 9" in " ".join(answer.warnings)


@pytest.mark.parametrize(
    ("turned", "text"),
    [("order", "on average from those of the arm"), ("tool", "rx 0|ry 0|rz 9")],
)
def test_orientations_that_are_not_those_of_the_arm_are_refused(turned, text, tmp_path):
    """Of a quaternion with its real part last, and of a tool that is turned by 9 degrees, by how
    much.
    """
    from scipy.spatial.transform import Rotation

    joints, points = twenty()
    rotation = state_of(lostmotion.read(ARM), np.radians(joints)).frames[-1, :, :3, :3]
    tool = Rotation.from_euler("z", 9 if turned == "tool" else 0, degrees=True)
    q = (Rotation.from_matrix(rotation) * tool).as_quat()
    q = q if turned == "order" else np.roll(q, 1, axis=1)
    path = written(tmp_path / "v.csv", joints, np.hstack([points, q]), f"{HEADER},qw,qx,qy,qz")
    with pytest.raises(InputError, match=text):
        lostmotion.calibrate(ARM, path, terms="geometry", noise="70 µm")
