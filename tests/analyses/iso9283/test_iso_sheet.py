"""ISO 9283 from the file to the folder: arguments, sheet, plots and files."""

import io
import json
import re
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

import lostmotion
from lostmotion.analyses.iso9283.page.plots import iso_plots
from lostmotion.propagation.iso9283.cube import NAMES, cube_from_arguments
from lostmotion.reporting.layout import key_of, row_at
from lostmotion.reporting.screen import print_sheet
from lostmotion.standards import commanded_poses
from tests.command import carried_out

EXAMPLES = Path(__file__).parents[3] / "examples"
Z_ARM, VISITS, LOADS = (
    EXAMPLES / "z-arm.toml",
    EXAMPLES / "measured" / "z-arm.csv",
    EXAMPLES / "measured" / "z-arm-loads.csv",
)


def ran(*words, cwd):
    """Run the command in a folder."""
    return carried_out("iso9283", *words, cwd=cwd)


@pytest.fixture(scope="module")
def both():
    """Predict the paper's arm and evaluate a robot of it, once."""
    return lostmotion.iso9283(
        lostmotion.read(Z_ARM), VISITS, robots=20, visits=10, instrument=5e-6, warm_up="25 K"
    )


def test_the_sheet_says_what_was_found(both):
    """Figures of the sheet are those of the study in their displayed units; every plot belongs to a
    section; all of it is plain data.
    """
    sheet, found = both.sheet, both.predicted
    mean = row_at(sheet.sections, "ap100", "P4").cells[0]
    assert mean.value == pytest.approx(found.loads[0].accuracy[3].mean())
    most = row_at(sheet.sections, "rp10", "worst").cells[1]
    assert most.value == pytest.approx(np.sort(found.loads[1].repeatability.max(axis=0))[18])
    assert most.samples == "20 robots x 10 visits"
    assert row_at(sheet.sections, "cube", "side").cells[0].as_shown == pytest.approx(500)
    keys = [section.key for section in sheet.sections]
    assert keys[0] == "compared"
    assert keys[keys.index("cube") :][:4] == ["cube", "poses", "ap100", "ap10"]
    assert {
        "fitted",
        "either",
        "axes",
        "turns",
        "vap",
        "distance",
        "path",
        "drift",
        "check",
        "compared",
        "measured-poses",
        "measured-data",
    } <= set(keys)
    drawn = iso_plots(both.predicted, both.drift, both.measured, list(both.compared))
    assert {plot.section for plot in drawn} <= set(keys)
    assert len({plot.key for plot in drawn}) == len(drawn) == 8
    json.dumps(both.result(), allow_nan=False)
    assert re.match(r"\d+ of 20 measured figures lie between", sheet.verdict)
    assert "Predicted in the test cube of 500 mm: " in sheet.verdict


def test_the_measured_cube_is_the_one_predicted_in(both):
    """Robots are predicted in the cube of the commanded P1 to P5 of the file, and each figure is
    compared with its own.
    """
    assert both.predicted.cube.centre == pytest.approx([0.52, 0.0, 1.05])
    said = both.result()
    row = next(
        each for each in said["compared"] if each["figure"] == "RP_l" and each["pose"] == "P3"
    )
    assert row["measured"] == pytest.approx(both.measured.loads[0].poses[2].repeatability.value)
    assert row["within"] == (row["predicted_5"] <= row["measured"] <= row["predicted_95"])


def test_robots_are_compared_as_often_visited(both):
    """With 30 measured visits and 10 requested, RP_l is compared with that of 30 visits, and the
    sheet keeps 10.
    """
    assert both.predicted.cycles == 10
    again = lostmotion.iso9283(
        lostmotion.read(Z_ARM), VISITS, robots=20, visits=30, instrument=5e-6
    )
    for one, other in zip(both.compared, again.compared, strict=True):
        assert one.predicted.high.value == other.predicted.high.value


def test_a_measured_robot_alone():
    """Without an arm the sheet has the measured robot only, with commands and frames."""
    found = lostmotion.iso9283(measured=VISITS)
    assert found.predicted is None
    assert row_at(found.sheet.sections, "measured-data", "visits").cells[0].as_shown == 420
    assert row_at(found.sheet.sections, "measured-poses", "P4").cells[0].as_shown == pytest.approx(
        0.717, abs=1e-3
    )
    assert [
        row.label
        for section in found.sheet.sections
        if section.key == "measured-sides"
        for row in section.rows
    ] == ["P1", "P2", "P4"]


def test_no_table_is_wider_than_a_terminal(both, tmp_path):
    """With two loads, an instrument, sides, a path and a temperature rise, no line exceeds 80
    columns, and no figure or heading is truncated.
    """
    rows = [
        line.split(",")
        for line in VISITS.read_text(encoding="utf-8").splitlines()
        if not line.startswith("#")
    ][1:]
    path = [
        line.split(",")
        for line in LOADS.read_text(encoding="utf-8").splitlines()
        if ",P2-P4," in line
    ]
    lines = ["pose,path,cycle,side,load [%],x [mm],y [mm],z [mm],xc [mm],yc [mm],zc [mm]"]
    lines += [
        ",".join([row[0], "", row[1], row[2], load, *row[3:]])
        for load in ("100", "10")
        for row in rows
    ]
    lines += [",".join(["", row[1], row[2], "", *row[3:]]) for row in path]
    file = tmp_path / "wide.csv"
    file.write_text("\n".join(lines), encoding="utf-8")
    beside = lostmotion.iso9283(
        lostmotion.read(Z_ARM), file, robots=4, visits=10, instrument=5e-6, warm_up="25 K"
    )
    for sheet in (both.sheet, beside.sheet):
        screen = Console(width=80, record=True, file=io.StringIO())
        print_sheet(sheet, screen)
        said = screen.export_text()
        assert max(len(line.rstrip()) for line in said.splitlines()) <= 80
        words = set(said.split())
        assert not [word for word in words if word.endswith("…") and word != "…"]
        for section in sheet.sections:
            for row in section.rows:
                assert {
                    word for figure in row.cells for word in f"{figure} {figure.interval}".split()
                } <= words


@pytest.fixture(scope="module")
def loads():
    """Evaluate the robot measured at both loads and along the path, and compare it with predicted
    robots, once.
    """
    return lostmotion.iso9283(lostmotion.read(Z_ARM), LOADS, robots=20, instrument=5e-6)


def test_every_interval_on_the_measured_sheet_is_of_the_figure_beside_it(loads):
    """Each interval contains its figure, as computed and as printed, and only signed figures have
    negative limits.
    """
    rows = [
        (section.key, row)
        for section in loads.sheet.sections
        if section.key.startswith(("measured", "compared"))
        for row in section.rows
    ]
    figures = [
        (key, row.label, figure)
        for key, row in rows
        for figure in row.cells
        if figure.between and "?" not in figure.between
    ]
    assert len(figures) > 60
    for key, label, figure in figures:
        assert figure.low <= figure.value <= figure.high, label
        low, high = map(float, figure.between.split(" … "))
        assert low <= float(str(figure).split()[0]) <= high, label
        assert (
            figure.low >= 0
            or key in {"measured-axes", "compared-axes", "compared-axes-10"}
            or label.startswith("AD_p")
        ), label


def test_both_loads_and_the_path_are_on_the_sheet(loads):
    """Each figure is listed under each load, measured and compared; plots and result.json have them
    too.
    """
    sections, said = loads.sheet.sections, loads.result()
    heavy, light = loads.measured.loads
    for load, each, key in (("100%", heavy, "compared"), ("10%", light, "compared-10")):
        row = row_at(sections, "measured-path", key_of(f"AT_p, P2-P4, {load}"))
        assert row.cells[0].as_shown == pytest.approx(each.paths[0].figures[0] * 1e3)
        assert not row.cells[0].between
        assert row.cells[1].low < row.cells[1].value < row.cells[1].high
        assert row.cells[0].samples == "10 cycles x 20 places"
        assert row.cells[2].as_shown == pytest.approx(each.paths[0].worst[0] * 1e3)
        assert row_at(sections, key, key_of("AT_p, P2-P4")).note == ""
        assert row_at(sections, key, key_of("RP_l, P3")).cells[2].as_shown == pytest.approx(
            each.poses[2].repeatability.value * 1e6
        )
        assert row_at(sections, "measured-poses", key_of(f"P4, {load}")).cells[
            0
        ].as_shown == pytest.approx(each.poses[3].accuracy.value * 1e3)
        assert row_at(sections, "path", key_of(f"AT_p, {load}")).cells[0].low > 0
    assert {(each["figure"], each["load"]) for each in said["compared"]} >= {
        (name, load) for name in ("AT_p", "RT_p", "AP_p") for load in (1, 0.1)
    }
    assert said["measured"]["readings_along_paths"] == 400
    assert said["measured"]["loads"][1]["paths"][0]["RT_p"]["value"] == pytest.approx(
        light.paths[0].figures[1]
    )
    assert row_at(sections, "measured-data", "rows_at_10_load").cells[0].as_shown == 350
    keys = {section.key for section in sections}
    drawn = iso_plots(loads.predicted, loads.drift, loads.measured, list(loads.compared))
    assert {plot.section for plot in drawn} <= keys
    assert "measured-path" in {plot.key for plot in drawn}
    assert len({plot.key for plot in drawn}) == len(drawn)
    json.dumps(said, allow_nan=False)
    assert "along P2-P4" in loads.sheet.verdict


def test_signed_parts_of_ap_are_compared(loads):
    """AP_x, AP_y, AP_z have a signed comparison of their own: the wrong sign is outside, however
    small the error.
    """
    rows = next(section for section in loads.sheet.sections if section.key == "compared-axes").rows
    assert [row.label for row in rows] == [f"AP_{axis}, {pose}" for axis in "xyz" for pose in NAMES]
    one = next(
        each for each in loads.compared if (each.name, each.pose, each.load) == ("AP_y", "P1", 1.0)
    )
    assert one.measured.value < 0
    row = row_at(loads.sheet.sections, "compared-axes", "AP_y_P1")
    assert row.note == ("" if one.within else "low")
    assert row.cells[2].as_shown * 1e-3 == pytest.approx(one.measured.value)
    assert (one.measured.value < one.predicted.low.value) == (row.note == "low")


def test_at_80_columns_a_word_stands_in_the_row(loads):
    """With two loads in separate tables, high and low are printed in the row of the value, not
    below the table.
    """
    screen = Console(width=80, record=True, file=io.StringIO())
    print_sheet(loads.sheet, screen)
    lines = screen.export_text().splitlines()
    outside = [
        each
        for each in loads.compared
        if not each.within and each.name in {"RP_l", "RD", "AP_p", "AP_x", "AP_y", "AP_z"}
    ]
    assert outside
    for each in outside:
        word = "high" if each.measured.value > each.predicted.high.value else "low"
        assert [
            line
            for line in lines
            if line.strip().startswith(f"{each.name}, {each.pose}")
            and line.rstrip().endswith(f" {word}")
        ]
    assert not [line for line in lines if line.rstrip().endswith((": high", ": low", ": within"))]


def test_the_sheet_says_that_thirty_visits_read_low(loads):
    """The note on RP_l states the expectation for 30 visits and its larger limit, 2.2 % for
    isotropic scatter.
    """
    for sheet in loads.predicted.loads:
        assert (sheet.limit > 1.02 * sheet.expected).all()
        note = next(
            section
            for section in loads.sheet.sections
            if section.key == f"rp{100 * sheet.load:.0f}"
        ).note
        assert "with 30 visits, " in note
        assert f"{1e6 * sheet.limit[0]:.3g} µm" in note
    assert "on the average (AP_p)" not in loads.sheet.verdict
    assert "AP_p of 95 % of arms is within" in loads.sheet.verdict


def test_a_load_that_no_column_names_is_named_for_the_file(monkeypatch):
    """A third load is predicted as well, for comparison; without an arm the sheet has the measured
    robot only. The file is read once, also where its commands define the cube.
    """
    from lostmotion.io.measured import visit_file

    seen = []
    kept = visit_file.read_measured
    monkeypatch.setattr(
        visit_file, "read_measured", lambda *words: seen.append(words) or kept(*words)
    )
    found = lostmotion.iso9283(lostmotion.read(Z_ARM), VISITS, robots=4, load="50 %")
    assert len(seen) == 1
    assert {each.load for each in found.compared} == {0.5}
    assert [sheet.load for sheet in found.predicted.loads] == [1.0, 0.1]
    assert lostmotion.iso9283(measured=[VISITS], load=[0.5]).measured.loads[0].load == 0.5
    with pytest.raises(lostmotion.InputError, match="a measured file that it belongs to"):
        lostmotion.iso9283(lostmotion.read(Z_ARM), load=0.5)


def test_the_measured_path_is_the_one_predicted(tmp_path):
    """Without --path, robots follow the measured line, else the stated one."""
    text = LOADS.read_text(encoding="utf-8")
    path = tmp_path / "other.csv"
    path.write_text(
        "\n".join(line for line in text.splitlines() if ",P2-P4," not in line)
        + "\n"
        + other_path(text),
        encoding="utf-8",
    )
    found = lostmotion.iso9283(lostmotion.read(Z_ARM), path, robots=3)
    assert found.predicted.path_ends == (4, 2)
    assert {each.pose for each in found.compared if each.name == "AT_p"} == {"P5-P3"}
    assert lostmotion.iso9283(
        lostmotion.read(Z_ARM), path, robots=3, path=("P2", "P4")
    ).predicted.path_ends == (1, 3)


def other_path(text):
    """Return readings along P5 to P3: those along P2 to P4 mirrored in z about the centre of the
    cube, and reversed in x.
    """
    rows = [line.split(",") for line in text.splitlines() if ",P2-P4," in line]
    return "\n".join(
        ",".join(
            [
                "",
                "P5-P3",
                row[2],
                row[3],
                row[4],
                f"{-float(row[5]):.4f}",
                f"{2100 - float(row[6]):.4f}",
                "",
                "",
                "",
            ]
        )
        for row in rows
    )


def test_other_poses_are_compared_where_the_robot_was_sent():
    """Measured poses off the test cube are compared with robots predicted at the commands of the
    file, and the headline says so.
    """
    found = lostmotion.iso9283(
        lostmotion.read(Z_ARM), VISITS, robots=4, cube=0.3, centre=(0.52, 0.0, 1.0)
    )
    # in the order in which the robot visited them
    assert found.commanded.names == ("P5", "P4", "P3", "P2", "P1")
    assert [each.pose for each in found.compared if each.name == "RP_l"] == [
        "P1",
        "P2",
        "P3",
        "P4",
        "P5",
    ]
    assert "commanded poses of the file" in found.sheet.verdict
    assert any("not P1 to P5 of the test cube" in note for note in found.sheet.notes)


def test_a_cube_of_other_corners_is_compared_at_its_commands(monkeypatch, tmp_path):
    """Five poses in another plane of a cube, in decimal commas: the comparison at these poses comes
    first, and figures of the test cube found elsewhere are named as such.
    """
    centre, half = np.array([520.0, 0.0, 1000.0]), 50.0
    corners = {"P1": (0, 0, 0), "P2": (1, 1, 1), "P3": (-1, 1, 1), "P4": (-1, -1, -1)}
    at = {name: centre + half * np.array(corner) for name, corner in corners.items()}
    at["P5"] = centre + half * np.array([1, -1, -1])
    chance = np.random.default_rng(5)
    rows = [
        (name, cycle, *point, *(point + 0.3 + 0.02 * chance.normal(size=3)))
        for cycle in range(1, 6)
        for name, point in at.items()
    ]
    lines = [";".join(str(x).replace(".", ",") for x in row) for row in rows]
    path = tmp_path / "measured.csv"
    heads = "pose;cycle;xc [mm];yc [mm];zc [mm];x [mm];y [mm];z [mm]"
    path.write_text("\n".join([heads, *lines]), encoding="utf-8")
    # the search for the largest cube, which these commands ask for, is replaced by one that stands
    cube, sought = cube_from_arguments(lostmotion.read(Z_ARM), np.array([0.55, 0.0, 0.9]), 0.2), []
    monkeypatch.setattr(
        commanded_poses, "largest_cube", lambda *said, **_: sought.append(said) or cube
    )
    found = lostmotion.iso9283(
        lostmotion.read(Z_ARM), path, robots=4, visits=5, cube=None, centre=None
    )
    assert len(sought) == 1
    assert found.commanded.names == tuple(at)
    np.testing.assert_allclose(
        [pose[:3, 3] for pose in found.commanded.poses],
        np.stack(list(at.values())) / 1e3,
        atol=1e-6,
    )
    said = found.sheet.verdict
    assert re.match(r"\d+ of \d+ measured figures lie between", said)
    assert "at the 5 commanded poses of the file: AP_p at P" in said
    assert said.index("Not compared, predicted in a test cube of") > said.index("Measured: ")
    titles = [card.title for card in found.sheet.cards]
    assert titles.index("as predicted") < titles.index("AP_p, 95 % of arms, test cube")
    assert "AP_p, 95 % of arms" not in titles


@pytest.mark.parametrize("asked", [{}, {"cube": 0.4}, {"path": ("P1",)}, {"path": ("P1", "P9")}])
def test_questions_without_an_answer_are_refused(asked):
    """Neither arm nor visits, a cube without its centre, a path to nowhere."""
    arm = lostmotion.read(Z_ARM) if asked else None
    place = {"cube": 0.3, "centre": (0.52, 0.0, 1.0)} if "path" in asked else {}
    with pytest.raises(lostmotion.InputError):
        lostmotion.iso9283(arm, robots=2, **place, **asked)


@pytest.mark.usefixtures("unpainted")
def test_the_command_repeats_exactly(tmp_path):
    """`lostmotion iso9283` prints, writes report and figures only, repeats exactly, and does not
    overwrite an existing folder.
    """
    words = (
        Z_ARM,
        "--cube",
        "300 mm",
        "--centre",
        "550 mm, 0 mm, 800 mm",
        "--robots",
        "4",
        "--cycles",
        "3",
        "--warm-up",
        "25 K",
    )
    first = ran(*words, "--full", cwd=tmp_path)
    assert first.returncode == 0, first.stderr
    assert "RP_l" in first.stdout
    folder = tmp_path / "z-arm-iso9283"
    assert sorted(path.name for path in folder.iterdir()) == ["report.html", "result.json"]
    again = ran(*words, "--json", cwd=tmp_path)
    assert json.loads(again.stdout) == json.loads(
        (folder / "result.json").read_text(encoding="utf-8")
    )
    third = ran(*words, cwd=tmp_path)
    assert third.returncode == 2
    assert "--force" in third.stderr


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--centre", "1 mm, 2 mm"), "three lengths"),
        (("--cube", "3 m", "--centre", "500 mm, 0 mm, 500 mm"), "that the tool reaches entirely"),
        (("--measured", "nowhere.csv"), "no such file"),
        (("--measured", LOADS, "--load", "100 %"), "10 % of the payload, where 100 % is named"),
        (("--measured", VISITS, "--load", "100"), "at most 2"),
        ((), "neither"),
    ],
)
def test_mistakes_are_one_message(tmp_path, words, said):
    """A mistake in an option gives exit code 2, one message and no folder."""
    done = ran(*((Z_ARM,) if words else ()), *words, cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((Z_ARM, "--load", "10 kg", "--measured", VISITS), "--load"),
        ((Z_ARM, "--measured", "nowhere.csv"), "example   examples/measured/z-arm.csv"),
        ((Z_ARM, "--measured", "torn.csv"), "a visit to a pose"),
        ((Z_ARM, "--path", "P1 P9"), "two different ones of P1"),
        (
            (Z_ARM, "--cube", "400 mm"),
            '--cube, --centre\n(.|\n)*--cube "400 mm" --centre "600 mm, 0 mm, 400 mm"\n',
        ),
        ((Z_ARM, "--load", "10 %"), '--measured "visits.csv" --load "10 %"\n'),
        ((), 'ARM, --measured\n(.|\n)*example   --measured "visits.csv"\n'),
        ((Z_ARM,), "--force"),
    ],
)
def test_what_was_asked_is_refused_before_the_folder(tmp_path, words, said):
    """An older folder hides no mistake in options or files; only where all of them are valid is it
    reported. Examples can be typed.
    """
    for name in ("z-arm-iso9283", "robot-iso9283"):
        (tmp_path / name).mkdir()
    (tmp_path / "torn.csv").write_text(
        "pose,path,cycle,x [mm],y [mm],z [mm]\nP1,P2-P4,1,1,2,3\n", encoding="utf-8"
    )
    done = ran(*words, cwd=tmp_path)
    assert done.returncode == 2
    assert re.search(said, done.stderr)
    assert "lostmotion.iso9283(" not in done.stderr
    assert ("--force" in done.stderr) == (said == "--force")


@pytest.mark.parametrize(
    "wrong",
    [
        {"cube": 0.2, "centre": (0.5, 0.0)},
        {"cube": 0.2, "centre": (0.5, 0.0, np.nan)},
        {"tool_rpy": (0.0, np.inf, 0.0)},
    ],
)
def test_places_and_turns_are_three_finite_numbers(wrong):
    """From Python, too, a centre or a turn that is none is one clear message under its name."""
    with pytest.raises(
        lostmotion.InputError, match=r"three lengths|three angles|not a finite number"
    ):
        lostmotion.iso9283(lostmotion.read(Z_ARM), **wrong)


LOOPS = """name = "loops"
[[joints]]
name = "A"
type = "revolute"
axis = "z"
limits = ["-90 deg", "90 deg"]
gearbox = { hysteresis = "1 arcmin", ratio = 100, rated_torque = "50 N m", stiffness = "20 N m/arcmin" }
mounting = { tilt = "1 arcmin" }
link = { length = "100 mm", direction = "z", mass = "2 kg" }
[[joints]]
name = "B"
type = "revolute"
axis = "y"
limits = ["-90 deg", "90 deg"]
gearbox = { hysteresis = "1 arcmin", ratio = 100, rated_torque = "50 N m", stiffness = "20 N m/arcmin" }
mounting = { tilt = "1 arcmin" }
link = { length = "400 mm", mass = "2 kg" }
[[joints]]
name = "C"
type = "revolute"
axis = "y"
limits = ["-90 deg", "90 deg"]
GEARBOX
link = { length = "300 mm", mass = "2 kg" }
"""
LOOP = (
    'gearbox = { hysteresis = "1 arcmin", ratio = 100, rated_torque = "50 N m", stiffness = "20 N '
    'm/arcmin" }'
)


def loops(tmp_path, text):
    """Predict the sheet of an arm written like this."""
    path = tmp_path / "loops.toml"
    path.write_text(text, encoding="utf-8")
    return lostmotion.iso9283(
        lostmotion.read(path), robots=20, visits=4, cube="60 mm", centre="600 mm, 0 mm, 100 mm"
    )


@pytest.mark.parametrize("last", [LOOP, ""])
def test_a_zero_is_never_a_headline(tmp_path, last):
    """Hysteresis repeats exactly where every joint arrives from one side: no repeatability is
    predicted there, and the other figure comes first.
    """
    found = loops(tmp_path, LOOPS.replace("GEARBOX", last))
    sheet = found.sheet
    assert found.predicted.loads[0].repeatability.max() < 1e-15
    either = row_at(sheet.sections, "either", "worst").cells[0]
    # stiffness and bearings are not described, so that every figure is a lower bound
    plain = str(either).removeprefix("≥ ")
    assert sheet.verdict.startswith(
        f"RP_l, any approach, of 95 % of arms is at least {plain} ({either.interval})"
    )
    assert (
        "In the ISO cycle no described error varies from visit to visit, so no repeatability "
        "is predicted"
    ) in sheet.verdict
    assert not re.search(r"(within|least|most) 0 ", sheet.verdict)
    fitted = row_at(sheet.sections, "fitted", "worst").cells[0]
    assert (
        f"at least {str(fitted).removeprefix('≥ ')} ({fitted.interval}) with best-fit frames"
        in sheet.verdict
    )
    assert [card.title for card in sheet.cards[:2]] == ["RP_l, any approach", "RP_l, ISO cycle"]
    assert sheet.cards[1].number == "none described"
    rows = [
        row
        for key in ("rp100", "rp10", "turns")
        for section in sheet.sections
        if section.key == key
        for row in section.rows
    ]
    rows += [
        row
        for section in sheet.sections
        for row in section.rows
        if row.label.startswith(("RD,", "RT_"))
    ]
    assert {str(figure) for row in rows for figure in row.cells} == {"none described"}
    written = [
        each
        for section in found.result()["sections"]
        if section["key"] == "rp100"
        for row in section["rows"]
        for each in row["figures"]
    ]
    assert {(each["value"], each["interval"], each["words"]) for each in written} == {
        (None, None, "none described")
    }


def test_an_arm_whose_errors_never_change_has_no_repeatability(tmp_path):
    """Tilted axes are tilted at every visit: the headline predicts no repeatability, and the cards
    start with accuracy.
    """
    text = re.sub(r'hysteresis = "1 arcmin", ', "", LOOPS.replace("GEARBOX", ""))
    sheet = loops(tmp_path, text).sheet
    assert sheet.verdict.startswith(
        "No described error varies from visit to visit, from either side of approach"
    )
    assert sheet.cards[0].title == "AP_p, 95 % of arms"
