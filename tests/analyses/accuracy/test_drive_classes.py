"""The first answer: figures of an arm by class of drive, as long as every drive is assumed."""

from __future__ import annotations

import json
import re
import shutil

import numpy as np
import pytest

import lostmotion
from lostmotion.accuracy import drive_classes as classes_of_drive
from lostmotion.accuracy.drive_classes import class_figures
from lostmotion.catalogue.drive_classes import drive_classes
from lostmotion.io.drive_classes import class_of_arm, with_class
from lostmotion.printed import rounded_length
from lostmotion.propagation.iso9283.cube import cube_from_arguments
from lostmotion.propagation.iso9283.experiment import Experiment
from lostmotion.propagation.iso9283.robots import CYCLES, load_sheets
from tests.io.conftest import EXAMPLES

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "RP of the ISO cycle by class of drive, a sum over terms at poses of the whole workspace",
        "100 robots drawn one by one in the standard's cycle",
        "factor of 1.5",
        "accuracy/drive_classes.py",
    ),
)

# A small printed arm with bus servos: 0.5 kg, all effort limits 10 N m, a placeholder.
PRINTED = """<robot name="printed"><link name="base"/>
<link name="l1"><inertial><origin xyz="0 0 0.02"/><mass value="0.1"/>INERTIA</inertial></link>
<link name="l2"><inertial><origin xyz="0.06 0 0"/><mass value="0.11"/>INERTIA</inertial></link>
<link name="l3"><inertial><origin xyz="0.07 0 0"/><mass value="0.09"/>INERTIA</inertial></link>
<link name="l4"><inertial><origin xyz="0.03 0 0"/><mass value="0.2"/>INERTIA</inertial></link><link name="tool"/>
<joint name="j1" type="revolute"><parent link="base"/><child link="l1"/><origin xyz="0 0 0.055"/><axis xyz="0 0 1"/>LIMIT</joint>
<joint name="j2" type="revolute"><parent link="l1"/><child link="l2"/><origin xyz="0.03 0 0.054"/><axis xyz="0 -1 0"/>LIMIT</joint>
<joint name="j3" type="revolute"><parent link="l2"/><child link="l3"/><origin xyz="0.116 0 0"/><axis xyz="0 -1 0"/>LIMIT</joint>
<joint name="j4" type="revolute"><parent link="l3"/><child link="l4"/><origin xyz="0.135 0 0"/><axis xyz="0 -1 0"/>LIMIT</joint>
<joint name="end" type="fixed"><parent link="l4"/><child link="tool"/><origin xyz="0.1 0 0"/></joint></robot>"""
INERTIA = '<inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/>'
LIMIT = '<limit lower="-1.9" upper="1.9" effort="10" velocity="10"/>'


@pytest.fixture(scope="module")
def of_ur5e(tmp_path_factory):
    """Return a UR5e of assumed drives, and its figures by class."""
    path = tmp_path_factory.mktemp("ur5e") / "robot.urdf"
    shutil.copy(EXAMPLES / "ur5e.urdf", path)
    lostmotion.new(urdf=path).report()
    arm = lostmotion.read(path)
    return arm, class_figures(arm)


@pytest.fixture
def ur5e(tmp_path):
    """Copy the URDF of a UR5e and write its first sidecar."""
    path = tmp_path / "robot.urdf"
    shutil.copy(EXAMPLES / "ur5e.urdf", path)
    lostmotion.new(urdf=path).report()
    return path


@pytest.fixture
def few_poses(monkeypatch):
    """Find the figures of each class at 8 poses in place of 64, where words, keys and order are
    checked and not their size.
    """
    monkeypatch.setattr(classes_of_drive, "POSES", 8)


@pytest.fixture
def printed(tmp_path):
    """Write a small printed arm without a sidecar."""
    path = tmp_path / "printed.urdf"
    path.write_text(PRINTED.replace("INERTIA", INERTIA).replace("LIMIT", LIMIT), "utf-8")
    return path


@pytest.fixture(scope="module")
def assumed(of_ur5e):
    """Return a small study of a UR5e of assumed drives, with figures of each class at few poses."""
    with pytest.MonkeyPatch.context() as few:
        few.setattr(classes_of_drive, "POSES", 8)
        return lostmotion.study(of_ur5e[0], poses=8, robots=8, visits=3)


def test_the_headline_is_a_range_of_one_digit_that_says_that_it_is_assumed(assumed):
    """In one sentence: assumed by class, the range of accuracy and repeatability, the arm's own
    class; no interval, and no number of more digits.
    """
    sentence = assumed.sheet.verdict.partition(". ")[0]
    assert sentence.startswith(
        "Assumed by class of drive, stepper to industrial: expect 95 % of positions within "
    )
    assert "(RP, ISO cycle)" in sentence
    assert "as small strain wave arm" in sentence
    assert "…" not in assumed.sheet.verdict
    for number in re.findall(r"(?<![\d.])([\d.]+)(?= (?:mm|µm|to))", sentence):
        assert len(number.replace(".", "").strip("0")) <= 1, number
    assert not any(
        card.title.startswith(("95 %", "mean position", "accuracy AP", "repeatability"))
        for card in assumed.sheet.cards
    )


def test_the_table_and_the_result_hold_the_class_and_its_neighbours(assumed):
    """Three classes side by side, in SI in result.json, the arm's own marked; better drives give
    smaller figures, and both ways to arrive have a column each: backlash makes the second larger.
    """
    (section,) = (each for each in assumed.sheet.sections if each.key == "drive_classes")
    assert [row.label for row in section.rows] == [
        "as stepper arm",
        "as small strain wave arm",
        "as industrial arm",
    ]
    assert section.columns == ("95 % within", "RP, ISO cycle", "RP, any approach")
    assert all(row.cells[2].value > row.cells[1].value for row in section.rows)
    facts = json.loads(json.dumps(assumed.sheet.facts["drive_classes"]))
    assert [each["default"] for each in facts] == [False, True, False]
    for key in ("within_95", "rp_iso"):
        values = [each[key] for each in facts]
        assert values == sorted(values, reverse=True)
        assert all(0 < value < 0.1 for value in values)


def test_a_stated_drive_ends_the_comparison_of_classes(ur5e):
    """With one real gearbox the headline is that of any study, with its interval."""
    sidecar = ur5e.with_suffix(".toml")
    text = sidecar.read_text("utf-8")
    sidecar.write_text(
        text.replace("[joints.elbow_joint]", '[joints.elbow_joint]\ngearbox = "CSG-25-100"', 1),
        "utf-8",
    )
    study = lostmotion.study(ur5e, poses=8, robots=8, visits=3)
    assert study.classes == ()
    assert study.sheet.verdict.startswith("Expect 95 % of positions within ")


@pytest.mark.usefixtures("few_poses")
def test_a_bare_robot_file_has_a_first_answer_by_class(printed):
    """Without a sidecar no accuracy is predicted; the table of classes stands in its place."""
    with pytest.raises(lostmotion.InputError) as error:
        lostmotion.study(printed, poses=64)
    left = error.value.partial()
    assert [each.name for each in left.classes] == ["hobby servo", "stepper"]
    assert left.sheet.verdict.startswith("Assumed by class of drive, hobby servo to stepper")
    assert left.sheet.facts["drive_classes"][0]["class"] == "hobby servo"


def test_a_small_printed_arm_is_a_servo_arm_of_centimetres(printed):
    """Its effort limits are placeholders; by its own presets of servo, print and mounting 95 % lie
    within a figure that the range contains.
    """
    lostmotion.new(urdf=printed).report()
    figures = class_figures(lostmotion.read(printed))
    own = next(each for each in figures if each.default)
    printed.with_suffix(".toml").write_text(
        'presets = { revolute = "hobby servo", link = "printed PLA", mounting = "printed" }\n',
        "utf-8",
    )
    by_presets = lostmotion.study(printed, poses=64, method="analytic").pooled.quantiles
    reference = max(each.value for each in by_presets[:3])
    assert own.name == "hobby servo"
    assert (
        min(each.within for each in figures) < reference < 2 * max(each.within for each in figures)
    )
    assert own.within == pytest.approx(reference, rel=1.0)


def test_the_repeatability_of_a_class_is_that_of_simulated_robots_in_the_iso_cycle(of_ur5e):
    """By another method: robots drawn one by one follow the standard's cycle at its five poses; the
    sum over terms agrees within a factor of 1.5.
    """
    arm, figures = of_ur5e
    cube = cube_from_arguments(arm, np.array([0.4, 0.0, 0.4]), 0.3)
    (sheet,) = load_sheets(arm, cube, Experiment(1, 100, CYCLES, 0.0), {0: 1.0}, None, 10)
    simulated = sheet.repeatability.mean()
    own = next(each for each in figures if each.default)
    assert own.repeatability / simulated == pytest.approx(1.0, rel=0.5)


@pytest.mark.usefixtures("few_poses")
def test_figures_of_classes_are_the_same_for_the_same_file(ur5e):
    """Bit for bit, and in a study without sampling."""
    study = lostmotion.study(ur5e, poses=8, method="analytic")
    assert study.classes == class_figures(lostmotion.read(ur5e))


@pytest.mark.usefixtures("few_poses")
def test_a_better_class_is_more_repeatable(printed):
    """From hobby servos to drives of small strain wave arms, one after the other, on the same arm;
    the next step, to industrial drives, is that of the table above.
    """
    lostmotion.new(urdf=printed).report()
    arm = lostmotion.read(printed)
    assert class_of_arm(arm) is not None
    order = list(drive_classes().values())[:3]
    # beside a class stand the next smaller and the next larger one
    figures = class_figures(with_class(arm, order[1]))
    assert [each.name for each in figures] == [each.name for each in order]
    repeats = [each.repeatability for each in figures]
    assert repeats == sorted(repeats, reverse=True)


@pytest.mark.parametrize(
    ("value", "near", "down", "up"),
    [
        (9.56e-4, "1 mm", "0.9 mm", "1 mm"),
        (2.98e-3, "3 mm", "3 mm", "3 mm"),
        (1.2e-3, "1 mm", "1 mm", "2 mm"),
        (5.5e-6, "6 µm", "5 µm", "6 µm"),
        (0, *["0 µm"] * 3),
    ],
)
def test_a_length_has_one_digit(value, near, down, up):
    """Rounded to the nearest, or outward but for three per cent."""
    assert (rounded_length(value), rounded_length(value, -1.0), rounded_length(value, 1.0)) == (
        near,
        down,
        up,
    )


PRESETS = """tip = "tool"
presets = { revolute = "hobby servo", link = "printed PLA", mounting = "printed" }
[payload]
mass = "100 g"
"""


@pytest.mark.parametrize("method", ["montecarlo", "analytic"])
def test_an_arm_of_presets_alone_has_figures_of_one_digit(printed, method):
    """Every drive comes from a preset: the headline says so beside one digit, as figures by class
    have it, and bars and statements follow.
    """
    printed.with_suffix(".toml").write_text(PRESETS, "utf-8")
    sheet = lostmotion.study(printed, poses=8, robots=8, visits=3, method=method).sheet
    assert re.match(
        r"Assumed by preset, hobby servo: expect 95 % of positions within \d+ mm\. ", sheet.verdict
    )
    lengths = [
        figure
        for block in sheet.bars
        for bar in block.bars
        for figure in (bar.figure, bar.effect)
        if figure is not None and figure.unit == "m"
    ]
    assert lengths
    assert all(re.fullmatch(r"-?0*\.?0*[1-9]?0* .?m", str(each)) for each in lengths)
    said = dict(sheet.brief)
    assert re.search(r"mean \d mm|mean 0\.\d mm", said["Where"])
    if method == "montecarlo":
        assert re.match(r"RP, ISO cycle \d+ mm|RP, ISO cycle 0\.\d mm", said["RP"])
        assert "RP, any approach" in said["RP"]


def test_a_stated_play_ends_the_figures_of_one_digit(printed):
    """One drive that is not of a preset, and the headline has the digits of any study."""
    stated = f'{PRESETS}[joints.j2]\ngearbox = {{ backlash = "1 deg" }}\n'
    printed.with_suffix(".toml").write_text(stated, "utf-8")
    stated = lostmotion.study(printed, poses=64, robots=16, visits=2).sheet
    assert "Assumed by preset" not in stated.verdict
    assert re.search(r"within \d+\.\d+ mm", stated.verdict)
