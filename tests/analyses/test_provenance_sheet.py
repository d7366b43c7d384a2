"""What headlines, tables and result.json say of what is known of each joint."""

from __future__ import annotations

import dataclasses
import json

import pytest

import lostmotion
from lostmotion.analyses.statics.page import statics_sheet
from lostmotion.error_model.provenance import states
from lostmotion.loads.survey import Survey
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.reporting.layout import plain
from lostmotion.reporting.provenance import provenance_sections
from tests.analyses.test_undescribed import urdf
from tests.io.conftest import EXAMPLES
from tests.reporting.first_screen import first_screen

pytestmark = pytest.mark.usefixtures("few_samples")

FIVE = "joint_3, joint_4, joint_5, joint_6, joint_7"
HALF = """
[gearboxes.g]
ratio = 100
backlash = "1 arcmin ± 0.3 arcmin"
stiffness = "20 N m/arcmin"
stiffness_scatter = "10 %"
transmission_error = "1 arcmin"
[joints.joint_1]
gearbox = "g"
[joints.joint_2]
gearbox = "g"
"""


@pytest.fixture(scope="module")
def half(tmp_path_factory):
    """Return an arm of which two of seven joints are described."""
    folder = tmp_path_factory.mktemp("half")
    (folder / "arm.urdf").write_text(urdf(), encoding="utf-8")
    (folder / "arm.toml").write_text(HALF, encoding="utf-8")
    return lostmotion.read(folder / "arm.urdf")


def test_a_half_described_arm_errs_by_at_least_so_much(half):
    """The headline of a study begins with a lower bound and names the joints that are taken as
    perfect; so do the figures that are shown first.
    """
    sheet = lostmotion.study(half, 8, 8, 3).sheet
    assert sheet.verdict.startswith("At least ")
    assert f"nothing is described for {FIVE} (taken as perfect)" in sheet.verdict
    assert "RP, any approach at least" in first_screen(sheet)
    assert [card.number[0] for card in sheet.cards if card.title.startswith("95 % of")] == ["≥"]
    assert json.loads(json.dumps(plain(sheet, "0")))["states"]["ideal_joints"] == FIVE.split(", ")


@pytest.mark.parametrize(
    "ask",
    [
        lambda arm: lostmotion.study(arm, 8, method="analytic"),
        lambda arm: lostmotion.map(arm, poses=512, cell="500 mm", per_cell=2),
        lambda arm: lostmotion.target(arm, error="1 mm", poses=8, robots=20, visits=2),
    ],
    ids=["analytic", "map", "target"],
)
def test_every_command_says_so(half, ask):
    """No command gives the figures of a half-described arm as if they were all."""
    sheet = ask(half).sheet
    assert "t least " in sheet.verdict
    assert FIVE in sheet.verdict
    assert sheet.facts["states"]["ideal_joints"] == FIVE.split(", ")
    assert "states" in [section.key for section in sheet.sections]


def test_a_target_is_met_by_what_is_described_alone(half):
    """The error of a half-described arm is a lower bound and its yield an upper one: in the
    headline and in the figures that are shown first.
    """
    sheet = lostmotion.target(half, error="20 mm", poses=8, robots=20, visits=2).sheet
    assert "the target of 20 mm is met by what is described." in sheet.verdict
    assert "The yield is at most 100 %" in sheet.verdict
    numbers = {card.title: card.number for card in sheet.cards}
    assert numbers["as stated"].startswith("≥ ")
    assert {
        numbers[title].partition("t most ")[0] for title in numbers if title.startswith("yield")
    } == {"a"}


def test_a_half_described_arm_is_at_least_this_compliant(half):
    """The compliance on the cards is a lower bound, as in the headline."""
    numbers = {card.title: card.number for card in lostmotion.statics(half, poses=8).sheet.cards}
    assert numbers["largest compliance"].startswith("≥ ")


@pytest.mark.parametrize(
    "file", ["z-arm.toml", "arm-from-drawings.toml", "ur5e.urdf", "paper/z-arm-lumped.toml"]
)
def test_the_table_has_a_line_for_every_moving_joint(file):
    """Each joint once, each cell a state; what went in names every value with its state, the
    assumed ones too.
    """
    known = states(lostmotion.read(EXAMPLES / file))
    table, inputs, *_ = provenance_sections(known)
    assert [row.label for row in table.rows] == [each.joint for each in known.joints]
    assert {str(figure) for row in table.rows for figure in row.cells} <= {
        "stated",
        "assumed",
        "ideal",
        "-",
    }
    rows = [row for row in inputs.rows if row.cells[1].words != "ideal"]
    shown = [
        (row.label, each.split(" ")[0], row.cells[1].words)
        for row in rows
        for each in row.cells[0].words.split("; ")
    ]
    assert shown == [(short_name(each.owner), each.key, each.state) for each in known.given]
    assert {(short_name(each.owner), each.key, each.reason) for each in known.assumed} <= set(shown)


def test_a_described_arm_is_no_lower_bound():
    """Where every kind that a real joint must have is described, nothing but the number of assumed
    values is added to the headline.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    verdict = lostmotion.study(arm, 8, 8, 3).sheet.verdict
    assert verdict.startswith("Expect 95 % of positions within ")
    assert "least" not in verdict
    assert f"This rests on {states(arm).assumed_count} assumed values" in verdict


def test_a_described_arm_without_assumed_values_has_none_counted():
    """The sentence is omitted where everything is stated."""
    joint = {
        "name": "A",
        "type": "revolute",
        "limits": (-1.0, 1.0),
        "gearbox": {"backlash": 3e-4, "friction_torque": "0.1 N m ± 20 %"},
    }
    verdict = lostmotion.study(lostmotion.Arm(name="x", joints=(joint,)), 8, 8, 3).sheet.verdict
    assert "assumed" not in verdict
    assert "least" not in verdict


def test_states_are_plain_data_of_their_own(half):
    """In Python an arm's states can be asked for by themselves, and stand beside every result; a
    study says in a line what it lacks.
    """
    known = states(half)
    study = lostmotion.study(half, 8, 4, 2)
    assert study.states == known
    assert f"at least: nothing is described for {FIVE}" in repr(study)
    assert lostmotion.target(half, error="1 mm", poses=8, robots=20, visits=2).states == known
    assert dataclasses.asdict(known)["joints"][0]["states"]["backlash"] == "stated"
    assert known.ideal_joints == tuple(FIVE.split(", "))


def test_iso_sheet_statics_and_sweep_say_so(tmp_path):
    """Of the Z-arm without parts at its last joint each of them names that joint, and calls its
    figures lower bounds.
    """
    text = (EXAMPLES / "z-arm.toml").read_text(encoding="utf-8")
    head, last = text.split('name = "roll"')
    kept = [
        line
        for line in last.splitlines()
        if not line.startswith(("gearbox", "bearing", "encoder", "link"))
    ]
    path = tmp_path / "arm.toml"
    path.write_text(head + 'name = "roll"' + "\n".join(kept) + "\n", encoding="utf-8")
    arm = lostmotion.read(path)
    assert states(arm).ideal_joints == ("roll",)
    sheets = [
        lostmotion.iso9283(
            arm, robots=3, visits=2, cube="100 mm", centre="520 mm, 0 mm, 1 m"
        ).sheet,
        statics_sheet(Survey.of(arm, lostmotion.sample_poses(arm, 8))),
        lostmotion.sweep(path, poses=8, robots=3, visits=2, out=tmp_path / "run").sheet,
    ]
    for sheet in sheets:
        assert "t least " in sheet.verdict
        assert "othing is described for roll (taken as perfect)" in sheet.verdict
        assert sheet.facts["states"]["ideal_joints"] == ["roll"]
        assert "states" in [section.key for section in sheet.sections]
