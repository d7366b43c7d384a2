"""CSV files of measured visits: units, mapping, and messages with the line of every mistake."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lostmotion
from lostmotion.io.measured.visit_file import read_measured
from lostmotion.spatial import pose_of

MEASURED = Path(__file__).parents[2] / "examples" / "measured"


def read(tmp_path, text, *mapping, **options):
    """Read a text as a file."""
    path = tmp_path / "visits.csv"
    path.write_text(text, encoding="utf-8")
    return read_measured(path, mapping, **options)


def test_positions_come_in_metres_whatever_their_unit(tmp_path):
    """Millimetres, inches and metres are converted to SI, commands too; cycles are counted where
    none are stated.
    """
    found = read(
        tmp_path,
        (
            "# a remark\npose,x [mm],y [in],z [m],xc [mm],yc [mm],zc [mm]\n"
            "P1,1000,1,2,1000,25,2000\nP1,1001,1,2,1000,25,2000\nP2,0,0,0,0,0,0\n"
        ),
    )
    assert found.pose == ("P1", "P1", "P2")
    assert found.attained[0] == pytest.approx([1.0, 0.0254, 2.0])
    assert found.command[1] == pytest.approx([1.0, 0.025, 2.0])
    assert found.cycle.tolist() == [1, 2, 1]
    assert np.isnan(found.turn).all()


def test_semicolons_and_deviations_with_a_sign(tmp_path):
    """Deviations are added to the command, negated where they are command less attained; units come
    from the header or the map.
    """
    text = "nr;gx;gy;gz;ex [µm];ey [µm];ez [µm]\n1;100;0;0;10;20;30\n2;200;0;0;10;20;30\n"
    found = read(
        tmp_path, text, "xc = gx [mm], yc = gy [mm], zc = gz [mm]", "dx = -ex", "dy = ey, dz = ez"
    )
    assert found.attained[0] == pytest.approx([0.1 - 1e-5, 2e-5, 3e-5])
    assert found.pose == ("1", "2")


def test_exact_repeats_are_omitted_and_counted(tmp_path):
    """A row that repeats another one in every cell is no second visit, even with other trailing
    zeros.
    """
    found = read(tmp_path, "pose,cycle,x [mm],y [mm],z [mm]\nA,1,1,2,3\nA,1,1,2.00,3\nA,2,1,2,3\n")
    assert found.duplicates == 1
    assert found.unread == ()
    assert len(found.pose) == 2


def test_turns_are_relative_to_the_commanded_orientation(tmp_path):
    """A rotation by 0.1° about the base's z after the commanded orientation is a rotation vector
    along z, for any commanded orientation.
    """
    from scipy.spatial.transform import Rotation

    command = Rotation.from_euler("xyz", [170, 20, 30], degrees=True)
    a, b, c = (Rotation.from_rotvec([0, 0, np.radians(0.1)]) * command).as_euler(
        "xyz", degrees=True
    )
    header = (
        "pose,x [mm],y [mm],z [mm],a [deg],b [deg],c [deg],xc [mm],yc [mm],zc [mm],ac [deg],bc "
        "[deg],cc [deg]"
    )
    found = read(tmp_path, f"{header}\nP1,0,0,0,{a:.12f},{b:.12f},{c:.12f},0,0,0,170,20,30\n")
    assert found.turn[0] == pytest.approx([0, 0, np.radians(0.1)], abs=1e-12)
    assert found.rotation[0] == pytest.approx(pose_of(rpy=np.radians([170, 20, 30]))[:3, :3])


def test_commands_in_a_second_file_or_known(tmp_path):
    """Commanded poses may be in a file of their own, or known from the test cube; poses without one
    have none.
    """
    path = tmp_path / "commands.csv"
    path.write_text("pose,x [mm],y [mm],z [mm]\nA,1,2,3\n", encoding="utf-8")
    text = "pose,x [mm],y [mm],z [mm]\nA,1,2,4\nB,0,0,0\n"
    found = read(tmp_path, text, commands=path)
    assert found.command[0] == pytest.approx([0.001, 0.002, 0.003])
    assert np.isnan(found.command[1]).all()
    assert read(tmp_path, text).commanded({"B": pose_of((1, 2, 3))}).command[1] == pytest.approx(
        [1, 2, 3]
    )


PATH = "pose,path,cycle,load [%],x [mm],y [mm],z [mm],xc [mm],yc [mm],zc [mm]\n"


def test_paths_and_loads_stand_beside_poses(tmp_path):
    """A row with a path is a reading along it, without a command; the load is a share of the
    payload; poses keep their commands.
    """
    found = read(
        tmp_path, PATH + "P2,,1,100,1,2,3,1,2,3\n,P2-P4,1,10,4,5,6,,,\n,P2-P4,1,10,5,5,6,,,\n"
    )
    assert found.pose == ("P2", "", "")
    assert found.path == ("", "P2-P4", "P2-P4")
    assert found.load.tolist() == [1.0, 0.1, 0.1]
    assert found.load_stated
    assert np.isfinite(found.command).all(axis=1).tolist() == [True, False, False]
    assert found.where[2][1] == 4


def repeated(visits=20, rows=531):
    """Return a file with 20 visits in 531 rows, as written by a tracker that samples while the
    robot is at rest: only the clock changes.
    """
    rng = np.random.default_rng(19)
    at = rng.normal([600, 0, 400], 0.02, (visits, 3))
    lines = [
        f"P1,{k % visits + 1},{0.01 * k:.2f},{','.join(f'{x:.4f}' for x in at[k % visits])},ok"
        for k in range(rows)
    ]
    return "pose,id,time,x [mm],y [mm],z [mm],state\n" + "\n".join(lines) + "\n"


def test_a_clock_beside_the_readings_makes_no_visits(tmp_path):
    """Rows that differ only in an unread column are one visit, so RP_l's interval is that of 20
    visits; the note names the column.
    """
    for mapping in ((), ("cycle = id",)):
        found = read(tmp_path, repeated(), *mapping)
        assert (len(found.pose), found.duplicates) == (20, 511)
        assert found.unread == ("time",)
        assert sorted(found.cycle.tolist()) == list(range(1, 21))
    judged = lostmotion.iso9283(measured=tmp_path / "visits.csv", mapping=["cycle = id"])
    pose = judged.measured.loads[0].poses[0]
    assert pose.visits == 20
    assert pose.repeatability.high - pose.repeatability.low > 0.3 * pose.repeatability.value
    (note,) = [note for note in judged.sheet.notes if "dropped" in note]
    assert "511 rows" in note
    assert "'time'" in note
    assert "'state'" not in note


def test_two_readings_of_one_visit_are_refused_by_what_differs(tmp_path):
    """A second reading of a pose in one cycle that differs in y is refused, and the message names
    y.
    """
    from lostmotion.standards.measured_robot import evaluate

    with pytest.raises(lostmotion.InputError, match="line 2 has another y\n"):
        evaluate(
            read(tmp_path, "pose,cycle,x [mm],y [mm],z [mm]\nA,1,1,2,3\nA,1,1,2.5,3\nA,2,1,2,3\n")
        )


def test_several_files_are_one_robot(tmp_path):
    """Each file has its own stated load; mapped columns may be in one file only; repeats are
    counted over all files.
    """
    text = "{},cycle,x [mm],y [mm],z [mm]\n{},1,1,2,3\n{},1,1,2,3\n{},2,1,2,4\n"
    for name, label in (("full", "P1"), ("light", "P1")):
        (tmp_path / f"{name}.csv").write_text(
            text.format("place" if name == "light" else "pose", label, label, label),
            encoding="utf-8",
        )
    found = read_measured(
        [tmp_path / "full.csv", tmp_path / "light.csv"], ["pose = place"], loads=[1.0, 0.1]
    )
    assert found.load.tolist() == [1, 1, 0.1, 0.1]
    assert found.duplicates == 2
    assert found.source == "full.csv, light.csv"
    with pytest.raises(lostmotion.InputError, match="1 for 2 measured files"):
        read_measured([tmp_path / "full.csv", tmp_path / "full.csv"], loads=[1.0])
    with pytest.raises(lostmotion.InputError, match="from 0 to 2"):
        read_measured(tmp_path / "full.csv", loads=[100.0])


def test_cycles_may_be_any_number(tmp_path):
    """Cycle numbers may be counts, dates, or numbers with many digits."""
    found = read(
        tmp_path, f"pose,cycle,x [mm],y [mm],z [mm]\nA,20261121,1,2,3\nA,2.{'0' * 80},1,2,3\n"
    )
    assert found.cycle.tolist() == [20261121, 2]


def test_a_load_not_stated_is_the_full_one(tmp_path):
    """Without a stated load the full payload is assumed, and recorded as not stated."""
    found = read(tmp_path, "pose,x [mm],y [mm],z [mm]\nA,1,2,3\n")
    assert found.load.tolist() == [1.0]
    assert not found.load_stated


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "P2,,1,100,1,2,3,1,2,3\nP2,,2,10,1,2,4,1,2,3\n",
            r"line 3, load(.|\n)*1 row, the first with 10 % of the payload, where 100 % is named",
        ),
        ("P2,,1,-5,1,2,3,1,2,3\n", r"line 2, load(.|\n)*-5 %"),
        ("P2,,1,10000,1,2,3,1,2,3\n", r"line 2, load(.|\n)*10000 %"),
        ("P2,,1,,1,2,3,1,2,3\n", r"line 2, load(.|\n)*a finite number"),
        ("P2,P2-P4,1,100,1,2,3,,,\n", "path 'P2-P4' and pose 'P2'"),
        (",,1,100,1,2,3,1,2,3\n", "the name of the pose or of the path"),
        (",P2-P4,1,100,1,2,3,1,,3\n", r"line 2, yc(.|\n)*a finite number"),
        ("P2,,1,100,1,2,3,,,\n", r"line 2, xc"),
        (",P2-P4,,100,1,2,3,,,\n", r"line 2, cycle"),
        (",P2-P4,1,100,,2,3,,,\n", r"line 2, x "),
        (",P2-P4,1,100,1e20,2,3,,,\n", r"line 2, x (.|\n)*at most 10 km"),
    ],
)
def test_rows_of_loads_and_paths_that_do_not_fit_are_refused(tmp_path, text, said):
    """Two loads where one was stated, invalid shares, rows that are both or neither, and incomplete
    commands are refused.
    """
    with pytest.raises(lostmotion.InputError, match=said):
        read(tmp_path, PATH + text, loads=[1.0])


def test_more_loads_than_a_test_has_are_refused(tmp_path):
    """A different load in every row is a wrongly mapped column."""
    rows = "".join(f"P2,,{k},{k},1,2,3,1,2,3\n" for k in range(1, 8))
    with pytest.raises(lostmotion.InputError, match="7 loads"):
        read(tmp_path, PATH + rows)


def test_a_cycle_that_visits_a_pose_twice_is_refused(tmp_path):
    """Two different readings of one pose in one cycle, side and load are refused with both lines;
    other sides and loads are no repeat.
    """
    from lostmotion.standards.measured_robot import evaluate

    header = "pose,side,cycle,load [%],x [mm],y [mm],z [mm]\n"
    again = "P2,,1,100,1,2,3\nP4,,1,100,9,2,3\nP4,,1,100,9,2,4\nP4,x,1,100,9,2,4\nP4,,1,10,9,2,4\n"
    with pytest.raises(
        lostmotion.InputError,
        match=r"line 4(.|\n)*pose 'P4' of cycle 1 a second time: line 3 has another z",
    ) as caught:
        evaluate(read(tmp_path, header + again))
    assert len(caught.value.problems) == 1


def test_commands_without_turns_determine_none(tmp_path):
    """A file of commands without orientations leaves them unknown, not zero."""
    path = tmp_path / "commands.csv"
    path.write_text("pose,x [mm],y [mm],z [mm]\nA,1,2,3\n", encoding="utf-8")
    found = read(
        tmp_path,
        "pose,x [mm],y [mm],z [mm],a [deg],b [deg],c [deg]\nA,1,2,4,180,0,0\n",
        commands=path,
    )
    assert np.isnan(found.turn).all()


def test_bad_rows_are_reported_all_at_once(tmp_path):
    """Cells that are not numbers, short rows, and a pose with two commands are reported together,
    each with its line.
    """
    text = (
        "pose,x [mm],y [mm],z [mm],xc [mm],yc [mm],zc [mm]\nA,1,2,x,0,0,0\n\nA,1,2,3,0,0,0\n"
        "A,1,two,3,0,0,0\nA,1,2\n,1,2,3,0,0,0\n"
    )
    with pytest.raises(lostmotion.InputError) as caught:
        read(tmp_path, text)
    assert [problem.key.split(",")[0] for problem in caught.value.problems] == [
        "line 2",
        "line 5",
        "line 6",
        "line 7",
    ]
    with pytest.raises(lostmotion.InputError, match=r"line 3(.|\n)*than in line 2"):
        read(
            tmp_path,
            "pose,x [mm],y [mm],z [mm],xc [mm],yc [mm],zc [mm]\nA,1,2,3,0,0,0\nA,1,2,3,0,0,1\n",
        )


def test_header_and_rows_are_reported_at_once(tmp_path):
    """A column without a unit, a missing one, an invalid map, and rows that are not numbers are
    reported in one message.
    """
    text = "pose,x,y [mm],z [mm],xc [mm],yc [mm]\nA,1,2,bad,0,0\nA,worse,2,3,0,0\nA,1,2\n"
    with pytest.raises(lostmotion.InputError) as caught:
        read(tmp_path, text, "side = nowhere")
    keys = [problem.key for problem in caught.value.problems]
    assert keys == ["mapping", "line 1, x", "line 1", "line 2, z [mm]", "line 3, x", "line 4"]
    # no column names a pose: reported once, not for every row
    with pytest.raises(lostmotion.InputError) as caught:
        read(tmp_path, "place,x [mm],y [mm],z [mm]\nA,1,2,3\nA,1,2,bad\n")
    assert [problem.key for problem in caught.value.problems] == ["line 1", "line 3, z [mm]"]


def test_mistakes_of_several_files_are_reported_at_once(tmp_path):
    """Mistakes of each file are reported under its name."""
    for name in ("one", "two"):
        (tmp_path / f"{name}.csv").write_text(
            "pose,x [mm],y [mm],z [mm]\nA,1,2,bad\n", encoding="utf-8"
        )
    with pytest.raises(
        lostmotion.InputError, match=r"2 mistakes(.|\n)*one.csv: line 2, z(.|\n)*two.csv: line 2, z"
    ):
        read_measured([tmp_path / "one.csv", tmp_path / "two.csv"])


@pytest.mark.parametrize(
    ("header", "mapping", "said"),
    [
        ("pose,x [mm],y [mm]", (), "without z"),
        ("pose,x,y [mm],z [mm]", (), "no unit"),
        ("pose,x [deg],y [mm],z [mm]", (), "not a unit of length"),
        ("pose,cycle", (), "no attained positions"),
        ("x [mm],y [mm],z [mm]", (), "neither pose nor"),
        ("pose,dx [mm],dy [mm],dz [mm]", (), "dx, dy, dz without xc"),
        ("pose,x [mm],x [mm],y [mm],z [mm]", (), "a second time"),
        ("path,x [mm],y [mm],z [mm]", (), "path without cycle"),
        ("pose,load,x [mm],y [mm],z [mm]", (), "no unit"),
        ("pose,load [kg],x [mm],y [mm],z [mm]", (), "load"),
        ("pose,x [mm],y [mm],z [mm]", ("q = x",), "ROLE = COLUMN"),
        ("pose,x [mm],y [mm],z [mm]", ("xc = xx [mm]",), "a column of"),
        ("pose,x [mm],y [mm],z [mm]", ("nonsense",), "ROLE = COLUMN"),
    ],
)
def test_columns_that_do_not_fit_are_refused(tmp_path, header, mapping, said):
    """Missing, repeated and unitless columns and invalid maps are refused by name."""
    row = ",".join(["1"] * len(header.split(",")))
    with pytest.raises(lostmotion.InputError, match=said):
        read(tmp_path, f"{header}\n{row}\n", *mapping)


@pytest.mark.parametrize("text", ["", "pose,x [mm],y [mm],z [mm]\n", "# nothing\n", '"a\n'])
def test_files_without_visits_are_refused(tmp_path, text):
    """Files without visits are refused with a message, without a traceback."""
    with pytest.raises(lostmotion.InputError):
        read(tmp_path, text)


@settings(max_examples=50, deadline=None)
@given(text=st.text(max_size=200), mapping=st.text(max_size=40))
def test_hostile_text_is_read_or_refused(tmp_path_factory, text, mapping):
    """Any text in the file or the map leads to a result or a list of mistakes."""
    try:
        read(tmp_path_factory.mktemp("hostile"), "pose,x [mm],y [mm],z [mm]\n" + text, mapping)
    except lostmotion.InputError as error:
        assert error.problems  # noqa: PT017 - refused is as good as read


@settings(max_examples=60, deadline=None)
@given(
    rows=st.lists(
        st.tuples(
            st.sampled_from(["P2-P4", "", "P2"]),
            st.sampled_from(["P2", "P4", ""]),
            st.integers(0, 2),
            st.floats(-1e300, 1e300),
            st.floats(-9, 9),
        ),
        max_size=30,
    )
)
def test_hostile_paths_are_judged_or_refused(tmp_path_factory, rows):
    """Any path leads to figures or a list of mistakes, without warnings and without NaN for a known
    name.
    """
    from lostmotion.standards.measured_robot import evaluate

    text = "P2,,1,100,0,0,0,0,0,0\nP4,,1,100,9,0,0,9,0,0\n"
    text += "".join(f"{pose},{path},{cycle},100,{x},{y},0,,,\n" for path, pose, cycle, x, y in rows)
    try:
        for path in evaluate(read(tmp_path_factory.mktemp("hostile"), PATH + text)).loads[0].paths:
            assert np.isfinite(path.figures[:2]).all()
    except lostmotion.InputError as error:
        assert error.problems  # noqa: PT017 - refused is as good as read


def test_ends_of_a_path_may_be_known_from_commands_alone(tmp_path):
    """Readings along a path may have its ends in the file of commands, without visits to them."""
    from lostmotion.standards.measured_robot import evaluate

    commands = tmp_path / "commands.csv"
    commands.write_text("pose,x [mm],y [mm],z [mm]\nE1,0,0,0\nE2,100,0,0\n", encoding="utf-8")
    rows = "".join(
        f"E1 to E2,{cycle},{x},{cycle},0\n" for cycle in (1, 2, 3) for x in range(0, 101, 10)
    )
    found = evaluate(
        read(tmp_path, "path,cycle,x [mm],y [mm],z [mm]\n" + rows, commands=commands)
    ).loads[0]
    assert found.poses == ()
    assert found.paths[0].name == "E1-E2"
    assert found.paths[0].figures[0] == pytest.approx(2e-3)
    assert found.paths[0].figures[1] == pytest.approx((2 / 3 + 3 * np.sqrt(1 / 3)) * 1e-3)


COMMAS = "pose;cycle;x [mm];y [mm];z [mm];xc [mm];yc [mm];zc [mm]\n"


def test_decimal_commas_between_semicolons_are_read(tmp_path):
    """Decimal commas, as exported by many European spreadsheets, are read like points, and so are
    quoted cells between commas.
    """
    text = COMMAS + "P1;1;320,2129;-0,5;1250;320;0;1,25e3\nP1;2;320,213;,5;1250,1;320;0;1,25e3\n"
    found, same = read(tmp_path, text), read(tmp_path, text.replace(",", "."))
    assert found.attained[:, 0] == pytest.approx([0.3202129, 0.320213], abs=1e-12)
    assert np.array_equal(found.attained, same.attained)
    assert np.array_equal(found.command, same.command)
    quoted = read(tmp_path, 'pose,x [mm],y [mm],z [mm],remark\nP1,"320,2129","0,5",1250,1.5\n')
    assert quoted.attained[0] == pytest.approx([0.3202129, 0.0005, 1.25], abs=1e-12)


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (
            ["P1;{};320,2129;0,5;1250.5;320;0;1250"],
            r"line 2\n  found     80 numbers with a comma, '320,2129', and '1250.5' in line 2",
        ),
        (
            ["P1;{};1.320,2129;0,5;1250,5;320;0;1250"],
            r"line 2\n  found     120 numbers with a comma, '1.320,2129'\n",
        ),
        (
            ["P1;{};1,320;200;1,250;1,320;200;1,250"],
            r"line 2\n  found     160 numbers with a comma, '1,320'\n",
        ),
        (
            ["P1;{};1,320,100;200;0,5;1,320;200;1,250"],
            r"line 2\n  found     160 numbers with a comma, '1,320,100'\n",
        ),
    ],
)
def test_commas_that_may_be_either_are_one_mistake(tmp_path, rows, said):
    """Ambiguous commas (beside points, between thousands, as in 1,320) are one mistake for the
    file, with advice on the export.
    """
    text = COMMAS + "\n".join(rows[0].format(k + 1) for k in range(40))
    with pytest.raises(lostmotion.InputError, match=rf"1 mistake\n.*{said}(.|\n)*decimal point"):
        read(tmp_path, text)


def test_the_tracker_data_is_read_as_published():
    """1 000 poses of a UR5 by a laser tracker: mean error 2.635 mm, s 0.375, 95th percentile 3.394,
    largest 4.409; less with the best-fit base.
    """
    from lostmotion.standards.measured_robot import evaluate

    mapping = (
        "xc = x_t [mm], yc = y_t [mm], zc = z_t [mm]",
        "dx = -x_dif [mm], dy = -y_dif [mm], dz = -z_dif [mm]",
    )
    found = evaluate(read_measured(MEASURED / "ur5-grid.csv", mapping))
    assert len(found.loads[0].poses) == 1000
    raw, fitted = found.loads[0].pooled
    assert [1e3 * each.value for each in raw] == pytest.approx(
        [2.635, 0.375, 3.394, 4.409], abs=6e-4
    )
    assert fitted[0].value < raw[0].value / 3
    assert raw[0].low < raw[0].value < raw[0].high
    # The closed form for the base alone, by SciPy: the same residual.
    from scipy.spatial.transform import Rotation

    visits = found.visits
    a, c = (
        visits.attained - visits.attained.mean(axis=0),
        visits.command - visits.command.mean(axis=0),
    )
    turned = Rotation.align_vectors(a, c)[0].apply(c)
    assert float(np.linalg.norm(a - turned, axis=1).mean()) == pytest.approx(
        fitted[0].value, rel=1e-9
    )
