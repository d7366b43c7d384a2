"""Files of a calibration: several that are measured, images of tags, plans by what a file states,
and what is written of arms with branches, quoted names and independent estimates.
"""

from __future__ import annotations

import csv
import io

import numpy as np
import pytest

import lostmotion
from lostmotion.calibration.geometry import exact_chain, is_serial, mdh_of
from lostmotion.calibration.terms import Deviations, added_terms
from lostmotion.errors import InputError
from lostmotion.io.calibration_file import read_calibration
from lostmotion.io.calibration_writer import calibration_text
from lostmotion.io.kinematics_writer import mdh_text
from lostmotion.io.measured.calibration_visits import read_calibration_visits
from lostmotion.io.measured.visit_file import read_measured
from lostmotion.laws.distributions import Normal
from lostmotion.mechanism.calibration import known_streams
from tests.analyses.calibrate.test_calibrate import HEADER, twenty, written
from tests.calibration.ur5_grid import ARM, EXAMPLES

HOBBY = EXAMPLES / "printed-hobby-arm.toml"
TAGS = EXAMPLES / "calibration" / "printed-tag.csv"
JOINT = 'type = "revolute"\naxis = [0, 1, 0]\nlimits = ["-90 deg", "90 deg"]\n'
TIP = 'link = { tip = { xyz = ["200 mm", "0 mm", "0 mm"] } }\n'
BRANCHED = "".join(
    f'[[joints]]\nname = "{name}"\n{after}{JOINT}{TIP}'
    for name, after in (
        ("shoulder", ""),
        ("finger", 'after = "base"\n'),
        ("elbow", 'after = "shoulder.tip"\n'),
    )
)


def test_a_driven_branch_beside_the_tool_path_is_no_serial_chain(tmp_path):
    """Its geometry cannot be written as one; the same arm without the branch has one."""
    path = tmp_path / "arm.toml"
    path.write_text(f'name = "branched"\n{BRANCHED}')
    assert not is_serial(lostmotion.read(path))
    path.write_text(
        f'name = "plain"\n{BRANCHED}'.replace('after = "base"\n', "").replace(
            "shoulder.", "finger."
        )
    )
    arm = lostmotion.read(path)
    assert is_serial(arm)
    assert len(exact_chain(arm).axes) == len(arm.driven)


@pytest.mark.parametrize(
    ("one", "other", "texts"),
    [
        ("# noise: 20 µm", "# noise: 30 µm", ("noise", "30 µm", "20 µm, as in", "one.csv")),
        ("", "# noise: 30 µm", ("noise", "nothing, as in", "no line # noise")),
        ("# deviations: shift 1 mm", "", ("deviations", "shift 1 mm, as in")),
    ],
)
def test_files_that_state_different_values_are_refused(one, other, texts, tmp_path):
    """With both files and values; equal values pass."""
    arm, (joints, points) = lostmotion.read(ARM), twenty()
    paths = []
    for name, line, rows in (("one", one, slice(10)), ("other", other, slice(10, 20))):
        paths.append(written(tmp_path / f"{name}.csv", joints[rows], points[rows]))
        paths[-1].write_text(f"{line}\n" + paths[-1].read_text())
    with pytest.raises(InputError) as refused:
        read_calibration_visits(paths, arm)
    for text in (*texts, str(paths[1])):
        assert text in str(refused.value)
    _, rows = paths[1].read_text().split(HEADER)
    paths[1].write_text(f"{one}\n{HEADER}{rows}")
    assert len(read_calibration_visits(paths, arm)) == 20


def test_cameras_that_differ_are_refused(tmp_path):
    """Pixels of one camera are not those of another."""
    other = tmp_path / "other.csv"
    other.write_text(TAGS.read_text("utf-8").replace("40 mm", "41 mm").replace("fx 800", "fx 801"))
    with pytest.raises(InputError) as refused:
        read_calibration_visits([TAGS, other], lostmotion.read(HOBBY))
    assert [each.key for each in refused.value.problems] == ["camera", "tag size"]


def test_a_corner_that_repeats_at_a_pose_begins_a_new_image(tmp_path):
    """Two images of one pose are two visits, one without a corner is counted in a remark, and an
    image that is stored twice is dropped.
    """
    *head, first = TAGS.read_text("utf-8").splitlines(keepends=True)[:5]
    rows = TAGS.read_text("utf-8").splitlines(keepends=True)[4:]
    again = [row.replace(".", ".1", 1) for row in rows[:4]]
    path, arm = tmp_path / "tag.csv", lostmotion.read(HOBBY)
    path.write_text("".join([*head, *rows, *again, *rows[4:8], *rows[8:11]]))
    assert rows[0] == first
    read = read_calibration_visits(path, arm)
    assert len(read) == len(rows) // 4 + 1
    assert read.duplicates == 1
    np.testing.assert_array_equal(read.q[-1], read.q[0])
    there = [row.split(",")[10:12] for row in again]
    np.testing.assert_allclose(read.readings.value[-1], np.array(there, float))
    assert f"images in {path} without all four corners of a tag, not used: 1" in read.remarks


def test_what_is_held_out_is_a_share_of_the_poses(tmp_path):
    """Four poses with two rows each cannot spare nine tenths."""
    joints, points = (np.repeat(each[:4], 2, axis=0) for each in twenty())
    points[1::2] += 0.01
    path = written(tmp_path / "visits.csv", joints, points)
    with pytest.raises(InputError, match="at least 3 of 4 poses"):
        lostmotion.calibrate(ARM, path, hold_out=0.6)


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"plan": 1, "hold_out": 0.2, "terms": "geometry"}, {"hold_out", "terms"}),
        ({"plan": 1, "instrument": "dial", "mapping": "x = a [mm]"}, {"instrument", "mapping"}),
        ({"measured": "visits.csv", "zone": "x 0..1 m"}, {"zone"}),
        (
            {
                "maker": "calibration.conf",
                "measured": "visits.csv",
                "mapping": "x = a [mm]",
                "terms": "waves",
                "noise": "70 µm",
                "instrument": "dial",
                "hold_out": 0.2,
                "plan": 5,
                "zone": "x 0..1 m",
            },
            {"measured", "mapping", "terms", "noise", "instrument", "hold_out", "plan", "zone"},
        ),
    ],
)
def test_an_argument_without_a_use_is_refused(given, named):
    """By name, all at once, before any file is read."""
    with pytest.raises(InputError) as refused:
        lostmotion.calibrate(ARM, **given)
    assert {each.key for each in refused.value.problems} == named


def test_a_plan_uses_what_the_file_states(tmp_path):
    """Its noise is that of the file, an option takes precedence, and smaller deviations leave a
    smaller predicted radius.
    """
    path = written(tmp_path / "visits.csv", *twenty())
    rows = path.read_text()
    path.write_text("# noise: 200 µm\n" + rows)
    noisy = lostmotion.calibrate(ARM, path, plan=1)
    assert noisy.noise == pytest.approx(200e-6)
    assert lostmotion.calibrate(ARM, path, plan=1, noise="90 µm").noise == pytest.approx(90e-6)
    sizes = "# deviations: turn 0.01 mrad, shift 0.001 mm, zero 0.01 mrad\n"
    path.write_text("# noise: 200 µm\n" + sizes + rows)
    known = lostmotion.calibrate(ARM, path, plan=1)
    assert known.plan.radius[0] < 0.8 * noisy.plan.radius[0]


@pytest.mark.parametrize("covariance", [np.diag([0.01, 0.04]), [[0.01, 0.003], [0.003, 0.04]]])
def test_a_calibration_is_read_as_it_was_written(covariance, tmp_path):
    """With independent estimates as with correlated ones."""
    streams = tuple((f"joints.{name}.encoder.zero", Normal()) for name in "AB")
    found = lostmotion.Calibration(streams, np.array([0.7, -0.2]), np.array(covariance))
    path = tmp_path / "robot.toml"
    path.write_text(calibration_text(found, Deviations(), poses=3, digest="0"))
    read = read_calibration(path, lostmotion.read(EXAMPLES / "z-arm.toml"))
    assert read.streams == streams
    np.testing.assert_array_equal(read.mean, found.mean)
    np.testing.assert_allclose(read.covariance, found.covariance, atol=1e-10)


def test_four_hundred_correlated_estimates_are_read_as_they_were_written(tmp_path):
    """Rows of thousands of characters, in a file of megabytes."""
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    sizes = Deviations(orders=40)
    streams = known_streams((*arm.terms, *added_terms(arm, sizes)))[:400]
    factor = np.random.default_rng(1).normal(size=(400, 400)) / 50
    found = lostmotion.Calibration(streams, np.linspace(-1, 1, 400), factor @ factor.T)
    path = tmp_path / "robot.toml"
    path.write_text(calibration_text(found, sizes, poses=3, digest="0"))
    assert path.stat().st_size > 2_000_000
    read = read_calibration(path, arm)
    assert read.streams == streams
    np.testing.assert_allclose(read.covariance, found.covariance, atol=1e-9)


def test_names_with_a_comma_are_quoted_in_the_table():
    """Every row of mdh.csv has five cells."""
    chain = exact_chain(lostmotion.read(EXAMPLES / "z-arm.toml"))
    names = ('A, "left"', *chain.joints[1:])
    text = mdh_text(chain._replace(joints=names), mdh_of(chain))
    rows = list(csv.reader(io.StringIO("".join(text.splitlines(keepends=True)[4:]))))
    assert {len(row) for row in rows} == {5}
    assert tuple(row[0] for row in rows[1:]) == names


@pytest.mark.parametrize(
    ("instrument", "example"),
    [
        ("dial", "dial [mm], along"),
        ("inclinometer", "angle [deg], about"),
        ("sphere", "sphere, radius [mm]"),
        ("tags", "u, v, corner, tag"),
        ("tracker", "x [mm], y [mm], z [mm]"),
    ],
)
def test_a_missing_column_has_the_example_of_its_instrument(instrument, example, tmp_path):
    """Not that of another one."""
    joints, points = twenty()
    path = written(tmp_path / "visits.csv", joints, points[:, :0], HEADER.partition(",x")[0])
    with pytest.raises(InputError) as refused:
        read_calibration_visits(path, lostmotion.read(ARM), instrument=instrument)
    assert example in [each.example for each in refused.value.problems]


def dial_file(path, rows):
    """Write readings of a dial gauge: joint values (deg), reading (mm) and axis."""
    head = ",".join([*(f"J{k} [deg]" for k in range(1, 7)), "dial [mm]", "along"])
    lines = [",".join(map(str, (*joints, reading, axis))) for joints, reading, axis in rows]
    path.write_text("\n".join([head, *lines]) + "\n")
    return path


def test_equal_readings_of_a_gauge_are_repeats_where_others_differ(tmp_path):
    """A gauge may show one number twice at a pose. Where every reading repeats to the last digit,
    as in a file that is stated twice, the rows are copies.
    """
    arm = lostmotion.read(ARM)
    poses = [(k, -80 - k, 90, 10 * k, 5, 0) for k in range(6)]
    rows = [(pose, 0.1 * k, "z") for k, pose in enumerate(poses)]
    again = [(poses[0], 0.0, "z"), (poses[1], 0.12, "z")]
    path = dial_file(tmp_path / "repeats.csv", rows + again)
    assert len(read_calibration_visits(path, arm)) == 8
    path = dial_file(tmp_path / "once.csv", rows)
    read = read_calibration_visits([path, path], arm)
    assert (len(read), read.duplicates) == (6, 6)
    copied = dial_file(tmp_path / "copied.csv", [*rows, rows[0], (poses[0], 0.0, "x")])
    read = read_calibration_visits(copied, arm)
    assert (len(read), read.duplicates) == (7, 1)  # another axis is another reading


def test_logged_joint_values_of_one_pose_jitter(tmp_path):
    """Visits within 0.1 mrad of one another are of one pose, at their mean; poses farther apart are
    not, nor is a path in small steps.
    """
    arm = lostmotion.read(ARM)
    joints, points = twenty()
    chance = np.random.default_rng(1)
    logged = np.repeat(joints, 4, axis=0)
    logged += np.degrees(chance.uniform(-4e-5, 4e-5, logged.shape))
    there = np.repeat(points, 4, axis=0) + chance.normal(0, 0.01, (80, 3))
    order = chance.permutation(80)
    read = read_calibration_visits(written(tmp_path / "log.csv", logged[order], there[order]), arm)
    means = np.radians(logged.reshape(20, 4, 6).mean(axis=1))[order // 4]
    np.testing.assert_allclose(read.q, means, atol=1e-12)
    assert len(np.unique(read.q, axis=0)) == 20
    for step in (1.2e-4, 0.9e-4):
        path = joints[:1] + np.degrees(step) * np.arange(20)[:, None]
        read = read_calibration_visits(written(tmp_path / "path.csv", path, points), arm)
        np.testing.assert_allclose(read.q, np.radians(path), atol=1e-12)


def test_equal_points_at_other_times_are_repeats(tmp_path):
    """Rows are copies where time, payload and side of approach are equal too."""
    arm = lostmotion.read(ARM)
    joints, points = twenty()
    more = np.zeros((20, 1))
    header = f"{HEADER},time [min]"
    first = np.hstack([points, more])
    later = np.hstack([points, more + 3])
    path = written(tmp_path / "a.csv", np.vstack([joints] * 2), np.vstack([first, later]), header)
    read = read_calibration_visits(path, arm)
    assert (len(read), read.duplicates) == (40, 0)
    np.testing.assert_allclose(read.time[[0, -1]], [0, 180])
    path = written(tmp_path / "b.csv", np.vstack([joints] * 2), np.vstack([first, first]), header)
    assert read_calibration_visits(path, arm).duplicates == 20


def test_a_payload_is_that_of_the_row_or_of_the_lines_above(tmp_path):
    """One file per payload may state it once; a time without a unit is not read, nor one that only
    some files state; a payload below zero is refused.
    """
    arm = lostmotion.read(ARM)
    joints, points = twenty()
    one = written(tmp_path / "one.csv", joints, points)
    one.write_text("# payload: 2 kg\n" + one.read_text())
    rows = np.hstack([points + 1, np.full((20, 1), 3)])
    two = written(tmp_path / "two.csv", joints, rows, f"{HEADER},payload [kg]")
    read = read_calibration_visits([one, two], arm)
    np.testing.assert_array_equal(read.payload, np.repeat([2.0, 3.0], 20))
    plain = written(tmp_path / "plain.csv", joints, rows, f"{HEADER},time")
    assert (
        "the column time states no unit: it is not used"
        in read_calibration_visits(plain, arm).remarks
    )
    timed = written(tmp_path / "timed.csv", joints, points, HEADER)
    timed.write_text(plain.read_text().replace(",time", ",time [s]"))
    read = read_calibration_visits([one, timed], arm)
    assert read.time is None
    assert "some of the files state no time: it is not used" in read.remarks
    rows[3, 3] = -1
    two = written(tmp_path / "two.csv", joints, rows, f"{HEADER},payload [kg]")
    with pytest.raises(InputError, match="line 5, payload"):
        read_calibration_visits(two, arm)


@pytest.mark.parametrize(
    ("line", "sign"),
    [
        ("# sign: attained - commanded", 1),
        ("# sign = commanded - measured", -1),
        ("#Sign: target minus actual", -1),
        ("# sign: measured less nominal", 1),
    ],
)
def test_a_file_states_the_sign_of_its_differences(line, sign, tmp_path):
    """In these words, with either mark, of points and of dial gauges; both readers obey it."""
    joints, points = twenty()
    header = HEADER.replace("x [", "dx [").replace("y [", "dy [").replace("z [", "dz [")
    path = written(tmp_path / "visits.csv", joints, points, header)
    path.write_text(f"{line}\n" + path.read_text())
    read = read_calibration_visits(path, lostmotion.read(ARM))
    assert read.signed
    np.testing.assert_allclose(read.difference, sign * points / 1000)
    gauge = dial_file(
        tmp_path / "dial.csv", [((k, -80 - k, 90, 10, 5, 0), k, "z") for k in range(6)]
    )
    gauge.write_text(f"{line}\n" + gauge.read_text())
    value = read_calibration_visits(gauge, lostmotion.read(ARM)).readings.value
    np.testing.assert_allclose(value, sign * np.arange(6) / 1000)
    cube = tmp_path / "iso.csv"
    cube.write_text(
        f"{line}\npose,dx [mm],dy [mm],dz [mm],xc [mm],yc [mm],zc [mm]\n"
        "P1,1,2,3,500,0,100\nP1,1,2,4,500,0,100\n"
    )
    attained = read_measured(cube).attained
    np.testing.assert_allclose(
        attained[0], np.array([500, 0, 100]) / 1000 + sign * np.arange(1, 4) / 1000
    )


@pytest.mark.parametrize(
    ("line", "mapping", "text"),
    [
        ("# sign: positive", "", "'positive'"),
        ("# sign: commanded - attaned", "", "did you mean 'commanded - attained'"),
        ("# sign:", "", "attained - commanded or commanded - attained"),
        ("# sign: attained - commanded\n# sign: commanded - attained", "", "two different signs"),
        ("# sign: attained - commanded", "dx = -dx [mm]", "dx negated by the mapping"),
    ],
)
def test_a_sign_that_may_be_read_two_ways_is_refused(line, mapping, text, tmp_path):
    """An unknown word, two signs, and a sign beside a mapping that negates."""
    joints, points = twenty()
    header = HEADER.replace("x [", "dx [").replace("y [", "dy [").replace("z [", "dz [")
    path = written(tmp_path / "visits.csv", joints, points, header)
    path.write_text(f"{line}\n" + path.read_text())
    with pytest.raises(InputError, match=text):
        read_calibration_visits(path, lostmotion.read(ARM), [mapping] if mapping else [])


def test_a_sign_is_about_differences_and_stated_in_all_files(tmp_path):
    """Points have none, and of two files both state it or neither."""
    arm, (joints, points) = lostmotion.read(ARM), twenty()
    path = written(tmp_path / "points.csv", joints, points)
    path.write_text("# sign: commanded - attained\n" + path.read_text())
    with pytest.raises(InputError, match="no differences in the file"):
        read_calibration_visits(path, arm)
    header = HEADER.replace("x [", "dx [").replace("y [", "dy [").replace("z [", "dz [")
    one = written(tmp_path / "one.csv", joints[:10], points[:10], header)
    two = written(tmp_path / "two.csv", joints[10:], points[10:], header)
    one.write_text("# sign: commanded - attained\n" + one.read_text())
    with pytest.raises(InputError, match="in all files, or in none"):
        read_calibration_visits([one, two], arm)
    two.write_text("# sign: attained - commanded\n" + two.read_text())
    read = read_calibration_visits([one, two], arm)
    np.testing.assert_allclose(read.difference, np.vstack([-points[:10], points[10:]]) / 1000)


def test_readings_of_another_arm_are_refused(tmp_path):
    """Where half of the distances are 5 % of the reach from those of any base and tool frame; their
    estimates were printed with a warning.
    """
    joints, _ = twenty()
    header = HEADER.replace("x [mm],y [mm],z [mm]", "distance [mm],to")
    text = [",".join([*map(str, row), f"{500 + 37 * k % 90},A"]) for k, row in enumerate(joints)]
    path = tmp_path / "wire.csv"
    path.write_text("\n".join([header, *text]) + "\n")
    with pytest.raises(InputError, match="belong to another arm"):
        lostmotion.calibrate(ARM, path, terms="geometry")


@pytest.mark.parametrize(
    ("heading", "cell", "found"),
    [
        ("distance [mm],to", "0,A", "distance"),
        ("sphere,radius [mm]", "A,-5", "radius"),
        ("x [mm],y [mm],z [mm],time [s]", "1,2,3,1e308", "time"),
        ("x [mm],y [mm],z [mm],payload [kg]", "1,2,3,-1", "payload"),
    ],
)
def test_impossible_readings_are_refused_by_line(heading, cell, found, tmp_path):
    """Of each kind, with the line."""
    joints, _ = twenty()
    header = HEADER.replace("x [mm],y [mm],z [mm]", heading)
    path = tmp_path / "visits.csv"
    path.write_text("\n".join([header, *(",".join([*map(str, r), cell]) for r in joints)]) + "\n")
    with pytest.raises(InputError, match=f"line 2, {found}"):
        read_calibration_visits(path, lostmotion.read(ARM))


def test_a_tag_without_area_is_refused(tmp_path):
    """Corners on one line leave no pose of it."""
    joints, _ = twenty()
    header = HEADER.replace("x [mm],y [mm],z [mm]", "u,v,corner,tag")
    camera = "# camera: fx 800, fy 800, cx 320, cy 240\n# tag size: 40 mm\n"
    cells = [",".join([*map(str, row), f"{c},{c},{c},A"]) for row in joints for c in range(4)]
    path = tmp_path / "tags.csv"
    path.write_text(camera + "\n".join([header, *cells]) + "\n")
    with pytest.raises(InputError, match="a tag of 0 px"):
        read_calibration_visits(path, lostmotion.read(ARM))
