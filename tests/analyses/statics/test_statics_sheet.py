"""Sheet, plots and files of an arm at rest."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.analyses.accuracy.page import sections
from lostmotion.analyses.accuracy.page.plots import bending
from lostmotion.analyses.accuracy.page.plots import plots as arm_plots
from lostmotion.analyses.statics.page import statics_sheet
from lostmotion.analyses.statics.page.plots import statics_plots
from lostmotion.catalogue.gearboxes import gearboxes
from lostmotion.catalogue.search import searchable_figures
from lostmotion.loads.survey import Survey
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.state import state_of
from lostmotion.parts.joint import PrismaticJoint, RevoluteJoint
from lostmotion.reporting.layout import key_of, row_at
from tests.command import carried_out
from tests.reporting.chart_texts import axis_titles, crowded, unprinted

Z_ARM = Path(__file__).parents[3] / "examples" / "z-arm.toml"
PLANAR = Z_ARM.with_name("planar-2r.toml")
TILT = math.radians(10)


def ran(*words, cwd):
    """Run the command in a folder."""
    return carried_out("statics", *words, cwd=cwd)


@pytest.fixture(scope="module")
def found():
    """Return the survey of the paper's arm."""
    arm = lostmotion.read(Z_ARM)
    return Survey.of(arm, lostmotion.sample_poses(arm, 256), TILT)


def test_torques_on_the_sheet_are_those_of_the_arm(found):
    """Torques on the sheet are those of the arm at the stated poses, and the causes add up to
    them.
    """
    sheet = statics_sheet(found)
    for k, node in enumerate(found.joint_loads):
        standing, tilted, anyhow = row_at(sheet.sections, "torques", node.joint).cells
        assert standing.value == pytest.approx(
            state_of(found.arm, found.poses.q[node.nominal.index]).torques[0, k], abs=1e-9
        )
        assert abs(standing.value) <= tilted.value * (1 + 1e-9) + 1e-9
        assert tilted.value <= anyhow.value * (1 + 1e-9) + 1e-9
    for row in next(section for section in sheet.sections if section.key == "causes").rows:
        whole, *parts = (figure.value for figure in row.cells)
        assert sum(parts) == pytest.approx(whole, rel=1e-9)
        assert whole > 0


def test_suitable_reducers_are_rated_for_the_torque(found):
    """Every reducer that the sheet counts has the joint's ratio and the required torque; rows
    without a rated torque are counted separately.
    """
    sheet = statics_sheet(found)
    rated = [searchable_figures(row)["rated torque"] for row in gearboxes() if row.applies_to(121)]
    section = next(section for section in sheet.sections if section.key == "reducers")
    for node, row in zip(found.joint_loads, section.rows, strict=True):
        enough = sum(torque >= abs(node.required.value) for torque in rated)
        assert row.note.startswith(f"{enough} in the catalogue for the ratio 121;")
        assert row.cells[0].as_shown == abs(node.within_tilt.value)
    missing = sum(math.isnan(torque) for torque in rated)
    assert (f"{missing} rows without a rated torque are excluded" in section.note) == (missing > 0)


def test_the_headline_says_what_the_base_as_it_stands_asks_for_first():
    """A level SCARA's drives hold nothing and a palletiser's shoulder more than its turn: the worst
    tilt is named second, as such.
    """
    examples = Z_ARM.parent
    level = statics_sheet(
        Survey.of(
            arm := lostmotion.read(examples / "scara.toml"), lostmotion.sample_poses(arm, 256)
        )
    ).verdict
    assert level.startswith(
        "No joint holds a torque as the base stands; shoulder has 51.3 N m at any tilt of the base."
    )
    heavy = statics_sheet(
        Survey.of(
            arm := lostmotion.read(examples / "palletiser.toml"), lostmotion.sample_poses(arm, 256)
        )
    ).verdict
    assert heavy.startswith(
        "Joint shoulder has the largest holding torque: 4020 N m as the base stands, 5320 N m "
        "at turn at any tilt of the base."
    )


def test_a_reducer_below_the_holding_torque_is_reported():
    """The sheet reports a reducer rated below its holding torque, a load beyond the catalogue, and
    a prismatic joint.
    """
    joints = [
        PrismaticJoint(name="lift", limits=(0, 1)),
        RevoluteJoint(
            name="A",
            axis="y",
            limits=(-1, 1),
            link={"length": 2.0},
            gearbox={"rated_torque": 10.0, "stiffness": 1e5},
        ),
    ]
    arm = Arm(name="heavy", joints=joints, payload={"mass": 2000.0})
    sheet = statics_sheet(Survey.of(arm, lostmotion.sample_poses(arm, 16)))
    assert (
        row_at(sheet.sections, "reducers", "A").note
        == "the stated reducer is rated below this; none in the catalogue is rated for it"
    )
    assert row_at(sheet.sections, "reducers", "lift").note.startswith("prismatic joint")
    assert row_at(sheet.sections, "torques", "lift").cells[-1].as_shown == pytest.approx(
        2000 * lostmotion.Arm.model_fields["gravity"].default
    )
    assert sheet.notes[-1] == (
        "compliance not specified, assumed rigid: the base; gearboxes of lift; bearings of "
        "lift, A; links of A"
    )


def test_compliance_on_the_sheet_is_that_of_the_arm(found):
    """The most compliant pose, its ellipsoid and the shares agree with `compliance` at that
    pose.
    """
    sheet = statics_sheet(found)
    there = state_of(found.arm, found.poses.q[found.softest_pose]).settled().compliance
    free = lostmotion.ellipsoid(there).values[0]
    assert row_at(sheet.sections, "map", "most_compliant_direction_worst_pose").cells[
        0
    ].value == pytest.approx(free[0])
    for k in range(3):
        assert row_at(sheet.sections, "ellipsoid", key_of(f"free to rotate, {k + 1}")).cells[
            0
        ].value == pytest.approx(free[k])
    shares = next(section for section in sheet.sections if section.key == "shares")
    for column in range(2):
        assert sum(row.cells[column].as_shown for row in shares.rows) == pytest.approx(100)
    assert sheet.facts["compliance_at_softest_pose"]["values"] == pytest.approx(there[0], rel=1e-9)


def test_plots_show_the_figures_of_the_survey(found):
    """Every plot belongs to a section of the sheet; causes add up to the holding torque; the ring
    marks the most compliant pose.
    """
    sheet = statics_sheet(found)
    drawn = {plot.key: plot for plot in statics_plots(found)}
    assert {plot.section for plot in drawn.values()} <= {section.key for section in sheet.sections}
    held = widths(drawn["causes"].figure)
    np.testing.assert_allclose(
        held, [abs(node.required.value) for node in found.joint_loads], rtol=1e-9, atol=1e-9
    )
    (ring,) = [
        line
        for line in drawn["compliance-xoz"].figure.axes[0].lines
        if line.get_label() == "most compliant pose"
    ]
    axis = lostmotion.state_of(found.arm, np.zeros((1, len(found.arm.moving)))).frames[
        found.arm.tree.moved[0], 0, :3, 3
    ]
    x, y, z = 1e3 * (found.tool_positions[found.softest_pose] - [axis[0], axis[1], 0])
    np.testing.assert_allclose(
        [ring.get_xdata()[0], ring.get_ydata()[0]], [1e3 * axis[0] + np.hypot(x, y), z], atol=1e-6
    )
    bars = [bar.get_width() for bar in drawn["shares"].figure.axes[0].patches[: len(found.parts)]]
    np.testing.assert_allclose(bars, 100 * np.sort(found.shares)[::-1], rtol=1e-9)
    assert not set().union(*(unprinted(plot, sheet) for plot in drawn.values()))
    assert all("[" in title for plot in drawn.values() for title in axis_titles(plot))
    assert not [plot.key for plot in drawn.values() if crowded(plot.figure)]


def test_outlines_of_the_ellipsoid_are_its_shadows(found):
    """Points of the ellipsoid lie within its outline on each plane of the base's axes, and reach
    it.
    """
    on = {plot.key: plot for plot in statics_plots(found)}["ellipsoid"].figure.axes
    turns = np.random.default_rng(3).normal(size=(3, 200_000))
    ball = turns / np.linalg.norm(turns, axis=0)
    points = (
        1e6 * found.translational.directions[0] @ (found.translational.values[0][:, None] * ball)
    )
    for panel, (across, up) in zip(on, ((0, 1), (0, 2), (1, 2)), strict=True):
        outline = panel.lines[0].get_xydata()
        np.testing.assert_allclose(
            np.abs(outline).max(axis=0), np.abs(points[[across, up]]).max(axis=1), rtol=5e-3
        )


def widths(figure):
    """Return the sums of the widths of stacked bars, by row."""
    sums = {}
    for bar in (bar for on in figure.axes for bar in on.patches):
        row = round(bar.get_y() + bar.get_height() / 2)
        sums[row] = sums.get(row, 0.0) + bar.get_width()
    return [sums.get(row, 0.0) for row in range(max(sums) + 1)]


def test_a_rigid_arm_has_a_sheet_without_compliance():
    """The sheet of a rigid arm has torques and a note; there is no ellipsoid."""
    arm = Arm(
        name="rigid",
        joints=[
            RevoluteJoint(name="A", axis="y", limits=(-1, 1), link={"length": 0.5, "mass": 2.0})
        ],
    )
    surveyed = Survey.of(arm, lostmotion.sample_poses(arm, 16))
    sheet = statics_sheet(surveyed)
    assert [section.key for section in sheet.sections] == [
        "torques",
        "causes",
        "reducers",
        "bearings",
        "states",
        "inputs",
        "laws",
    ]
    assert "rigid" in sheet.notes[-1]
    assert [plot.key for plot in statics_plots(surveyed)] == ["causes"]


def test_a_study_reports_bending_by_cause(found):
    """A study has a row for each compliant link and one for each cause, which add up, as do the
    bars; rigid links have none.
    """
    study = lostmotion.study(found.arm, 8, robots=2, visits=2)
    (section,) = [section for section in sections(study) if section.key == "bending"]
    rows = {row.label: [figure.value for figure in row.cells] for row in section.rows}
    assert [name for name in rows if "," not in name] == ["O", "A", "B", "roll"]
    assert {"O, own weight", "O, payload", "O, next links", "O, next joints and drives"} <= set(
        rows
    )
    assert "roll, next links" not in rows
    for joint in ("O", "A", "B", "roll"):
        parts = [values for name, values in rows.items() if name.startswith(f"{joint}, ")]
        np.testing.assert_allclose(np.sum(parts, axis=0), rows[joint], rtol=1e-9)
    np.testing.assert_allclose(
        widths(bending(study)), [1e6 * rows[name][0] for name in ("O", "A", "B", "roll")], rtol=1e-9
    )
    rigid = Arm(
        name="rigid",
        joints=[
            RevoluteJoint(
                name="A", axis="y", limits=(-1, 1), link={"length": 0.5, "mass": 2.0, "rigid": True}
            )
        ],
    )
    study = lostmotion.study(rigid, 8, robots=2, visits=2)
    assert "bending" not in [section.key for section in sections(study)]
    assert "bending" not in [plot.key for plot in arm_plots(study)]


@pytest.mark.usefixtures("unpainted")
def test_the_command_prints_and_writes(tmp_path):
    """`lostmotion statics` prints the sheet and writes page and data; --json prints what is
    written, from a second survey, and writes nothing.
    """
    first = ran(PLANAR, "--tilt", "10 deg", "--poses", 8, "--full", cwd=tmp_path)
    assert first.returncode == 0, first.stderr
    assert "Compliance by part" in first.stdout
    folder = tmp_path / "planar-2r-statics"
    assert sorted(each.name for each in folder.iterdir()) == ["report.html", "result.json"]
    (tmp_path / "empty").mkdir()
    as_json = ran(PLANAR, "--tilt", "10 deg", "--poses", 8, "--json", cwd=tmp_path / "empty")
    assert json.loads(as_json.stdout) == json.loads(
        (folder / "result.json").read_text(encoding="utf-8")
    )
    assert not list((tmp_path / "empty").iterdir())


@pytest.mark.parametrize("tilt", ["-5 deg", "5", "5 mm"])
def test_a_tilt_out_of_range_is_refused(tilt, tmp_path):
    """A tilt below zero, without a unit or of another dimension is one message with the range and
    an example, and nothing is written.
    """
    refused = ran(Z_ARM, "--tilt", tilt, cwd=tmp_path)
    assert refused.returncode == 2
    assert '--tilt "10 deg"' in refused.stderr
    assert "zero or more, at most 180 deg" in refused.stderr
    assert not list(tmp_path.iterdir())
