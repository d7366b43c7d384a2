"""The sheet of one bearing: what is found, printed, drawn and written."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion import InputError
from lostmotion.analyses.bearing.command import BearingStudy
from lostmotion.analyses.bearing.plots import bearing_plots
from lostmotion.error_model.budget import costs
from lostmotion.io.part_file import read_bearing
from lostmotion.laws.rolling.equilibrium import shaft_equilibrium
from lostmotion.laws.rolling.radial import ball_pressure
from lostmotion.loads.bearing import BearingLoad, examine
from lostmotion.parts.bearing.crossed_roller import CrossedRoller
from lostmotion.parts.bearing.pair import BallPair
from lostmotion.parts.bearing.rolling import RollingPair
from lostmotion.propagation.montecarlo import kernel
from lostmotion.reporting.layout import row_at
from tests.command import carried_out
from tests.reporting.chart_texts import axis_titles, crowded, unprinted

EXAMPLES = Path(__file__).parents[3] / "examples" / "bearing"
OF_209 = {
    "bore": "45 mm",
    "outside_diameter": "85 mm",
    "balls": 9,
    "ball_diameter": "12.7 mm",
    "pitch_diameter": "65 mm",
    "span": "60 mm",
}
LOAD = BearingLoad(3000.0, 300.0, 60.0)


def ran(*words, cwd):
    """Run the command in a folder."""
    return carried_out("bearing", *words, cwd=cwd)


@pytest.fixture(scope="module")
def found():
    """Look at the 6209 pair once."""
    return examine(read_bearing(EXAMPLES / "6209-pair.toml").part, LOAD)


def test_the_209_through_the_sheet():
    """Under twice 8 900 N the sheet says the published 4 336 N and 51.5 µm of a 209 without
    clearance, to 2 %.
    """
    of_209 = examine(BallPair(**OF_209), BearingLoad(2 * 8900.0))
    assert of_209.settled.loads[0][1].max() == pytest.approx(4336, rel=0.02)
    assert of_209.settled.displacement[1, 0] == pytest.approx(51.5e-6, rel=0.02)
    assert of_209.pressure[1] == pytest.approx(
        float(ball_pressure(4336.0, 12.7e-3, 65e-3)), rel=0.01
    )
    sheet = BearingStudy("209", of_209.bearing, of_209.load, of_209).sheet
    assert row_at(sheet.sections, "shift", "shift_across").cells[1].as_shown == pytest.approx(
        51.5, rel=0.02
    )


def test_loads_of_the_elements_hold_the_shaft(found):
    """At each clearance the balls' loads add up to what is put on the shaft, to the rounding of the
    sum.
    """
    assert found.settled.converged.all()
    assert found.settled.residual.max() < 1e-9


def test_stiffness_is_what_a_little_more_load_meets(found):
    """By differences: a little more load one way, all ways free to follow, moves the shaft by the
    load over the stiffness.
    """
    clearance = float(found.clearances[1])
    for way, step in ((0, 1.0), (1, 1.0), (2, 0.2), (3, 0.02), (4, 0.02)):
        loads = np.tile(LOAD.row, (2, 1))
        loads[:, way] += [-step, step]
        displacement = shaft_equilibrium(found.bearing.rows.seats, loads, clearance).displacement
        assert 2 * step / (displacement[1, way] - displacement[0, way]) == pytest.approx(
            found.stiffness[way], rel=0.01
        )


def test_curves_begin_at_the_edge_of_the_play_and_stiffen(found):
    """Each curve starts where the play ends, rises with the load and bends down."""
    for curve, edge in ((found.radial, found.clearances / 2), (found.axial, None)):
        assert (np.diff(curve.shifts, axis=1) > 0).all()
        if edge is not None:
            np.testing.assert_allclose(curve.shifts[2, 0], edge[2], rtol=0.07)
        slope = np.diff(curve.shifts[2]) / np.diff(curve.loads)
        assert (np.diff(slope) < 0).all()


def test_rollers_carry_no_axial_load():
    """A thrust on cylindrical rollers is refused; without it their sheet has no invented axial
    figure.
    """
    part = read_bearing(EXAMPLES / "nu212-pair.toml").part
    with pytest.raises(InputError, match="no axial load"):
        examine(part, BearingLoad(1000.0, 10.0))
    found = examine(part, BearingLoad(1000.0))
    assert found.axial is None
    assert found.stiffness[2] == 0
    sheet = BearingStudy("x", part, found.load, found).sheet
    assert (
        row_at(sheet.sections, "stiffness", "along_the_axis").note
        == "no stiffness in this direction"
    )


def test_an_overloaded_element_is_reported():
    """Beyond the pressure of a static rating the sheet warns."""
    heavy = examine(BallPair(**OF_209), BearingLoad(100e3))
    assert any(
        "4.2 GPa" in note
        for note in BearingStudy("x", heavy.bearing, heavy.load, heavy).sheet.notes
    )


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda path: path.stem)
def test_every_example_has_its_sheet(path):
    """Every example is read and analysed; no figure lacks its unit or sample, each section's plots
    have titled axes.
    """
    read = read_bearing(path)
    found = examine(read.part, BearingLoad(1000.0, 0.0, 30.0))
    sheet = BearingStudy(read.name, read.part, found.load, found, read.notes).sheet
    for section in sheet.sections:
        assert section.rows, section.key
        for row in section.rows:
            assert len(row.cells) == len(section.columns)
            assert all(
                figure.words or (figure.unit and figure.samples and math.isfinite(figure.value))
                for figure in row.cells
            ), row.label
    keys = {section.key for section in sheet.sections}
    for plot in bearing_plots(found):
        assert plot.section in keys
        assert all("[" in title for title in axis_titles(plot)), plot.key
        assert not unprinted(plot, sheet), plot.key
        assert not crowded(plot.figure), plot.key
        if plot.key == "element-loads":  # no x and y: loads by their angle
            assert (
                plot.figure.get_suptitle()
                == "Load of each element [N] by its angle from the radial load"
            )


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda path: path.stem)
def test_a_shaft_that_stays_parallel_tilts_by_zero(path):
    """Under a load across its middle the shaft of a symmetric bearing does not tilt: it prints 0,
    not a rounding error.
    """
    read = read_bearing(path)
    found = examine(read.part, BearingLoad(1000.0, 0.0, 0.0))
    sheet = BearingStudy(read.name, read.part, found.load, found).sheet
    assert "does not tilt" in sheet.verdict
    assert (
        next(card.number for card in sheet.cards if card.title == "tilt at this load") == "0 arcmin"
    )


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.toml")), ids=lambda path: path.stem)
def test_large_figures_are_printed_without_powers_of_ten(path):
    """20 kN is 20000 N, and the stiffness of a stiff bearing has all its digits, on every part of
    the sheet.
    """
    read = read_bearing(path)
    sheet = BearingStudy(
        read.name,
        read.part,
        BearingLoad(2e4, 0.0, 0.0),
        examine(read.part, BearingLoad(2e4, 0.0, 0.0)),
    ).sheet
    assert "Under 20000 N across" in sheet.verdict
    assert not re.search(
        r"\d[eE][+-]?\d",
        " ".join(
            [
                sheet.verdict,
                sheet.counts,
                sheet.source,
                *(card.number + card.quiet for card in sheet.cards),
            ]
        ),
    )


def test_catalogue_bearings_have_a_sheet_too():
    """A bearing described by its clearance or its stiffness shows what is stated and what it adds
    to the error.
    """
    for part in (
        RollingPair(clearance=6e-5, span=0.05, radial_stiffness=1e8),
        CrossedRoller(axial_stiffness=1e9, pitch_diameter=0.1),
    ):
        sheet = BearingStudy("x", part, LOAD, None).sheet
        assert [section.key for section in sheet.sections][:3] == ["stated", "terms", "inputs"]
        assert all(section.rows for section in sheet.sections)
    tilt = BearingStudy("x", RollingPair(clearance=6e-5, span=0.05), LOAD, None).sheet
    assert row_at(tilt.sections, "stated", "tilt_in_it_either_way").cells[
        0
    ].as_shown == pytest.approx(4.1, rel=0.01)


def test_the_command_writes_the_sheet(tmp_path):
    """It prints every section, writes report.html and result.json, the same bytes twice, and leaves
    an existing folder alone without --force.
    """
    words = (EXAMPLES / "nu212-pair.toml", "--force-radial", "6 kN")
    done = ran(*words, "--full", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    for title in (
        "delivered to working",
        "Simulated bearings",
        "Load of the elements",
        "Stiffness",
        "60 µm does not hold",
    ):
        assert title in done.stdout
    folder = tmp_path / "nu212-pair-bearing"
    assert sorted(path.name for path in folder.iterdir()) == ["report.html", "result.json"]
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    result = json.loads(before["result.json"])
    assert result["load"]["radial_N"] == 6000
    assert result["built"] == 1000
    assert b"arrays.nc" not in before["report.html"]
    again = ran(*words, cwd=tmp_path)
    assert again.returncode == 2
    assert "--force" in again.stderr
    assert ran(*words, "--force", cwd=tmp_path).returncode == 0
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("nothing.toml",), "no such file"),
        ((EXAMPLES / "6209-pair.toml", "--force-radial", "2 mm"), "--force-radial"),
        ((EXAMPLES / "nu212-pair.toml", "--force-axial", "200 N"), "no axial load"),
        ((EXAMPLES.parent / "z-arm.toml",), "one of its joints with a bearing"),
        ((EXAMPLES / "6209-pair.toml", "--joint", "A"), "no joints"),
    ],
)
def test_impossible_input_is_one_message(tmp_path, words, said):
    """A mistake is one message with exit code 2, no traceback, and nothing is written."""
    done = ran(*words, cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())


def test_an_arm_on_such_bearings_is_studied():
    """In a whole study the bearing has its share of the blame, no sample leaves the worst case, and
    first order is enough.

    It neglects what the weight W does in a robot whose bearings tilt by t. Along the axis it is
    then W t, at the lever R: a moment, hence forces W t R / span across on the two bearings. Each
    is displaced along its whole load, of which W / 2 displaces it by the shift: so the bearings
    tilt about the vertical by shift t R / (span / 2)^2, which moves the tool by R times that.
    """
    joint = {"type": "revolute", "axis": "y", "limits": (-1, 1), "link": {"length": 0.4}}
    bearing = {"kind": "ball pair", **OF_209, "clearance": "15 µm ± 8 µm"}
    arm = lostmotion.Arm.model_validate(
        {
            "name": "x",
            "joints": [{**joint, "name": "A", "bearing": bearing}],
            "payload": {"mass": 5},
        }
    )
    study = lostmotion.study(arm, 16, 100, 4, threads=1)
    assert [cost.part for cost in costs(study.sampled.tally)] == ["joints.A.bearing"]
    assert (study.sampled.per_pose[:, kernel.LARGEST] <= study.sampled.worst).all()
    exact = study.sampled.exact
    shift = examine(BallPair(**bearing), BearingLoad(5 * 9.81)).settled.displacement[:, 0]
    least, _, most = exact.turn * shift * (0.4 / 0.03) ** 2
    assert least < exact.largest < most
    assert exact.largest < 0.01 * exact.length


@pytest.mark.usefixtures("unpainted")
def test_a_bearing_out_of_an_arm(tmp_path):
    """An arm's file and a joint: the sheet of that joint's bearing."""
    done = ran(EXAMPLES.parent / "z-arm.toml", "--joint", "A", "--moment", "20 N m", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "bearing of joint A" in done.stdout


def test_a_single_209_by_itself(tmp_path):
    """One bearing under 8 900 N: the published 4 336 N and 51.5 µm without clearance, its own row
    alone, no span, nothing added to an arm.
    """
    text = (EXAMPLES / "6209.toml").read_text()
    for key in ("clearance", "shaft_fit", "housing_fit"):
        text = "\n".join(line for line in text.splitlines() if not line.startswith(key))
    (tmp_path / "209.toml").write_text(text)
    part = read_bearing(tmp_path / "209.toml").part
    one = examine(part, BearingLoad(8900.0), 10)
    assert one.settled.loads[0][1].max() == pytest.approx(4336, rel=0.02)
    assert one.settled.displacement[1, 0] == pytest.approx(51.5e-6, rel=0.02)
    assert len(one.settled.loads) == 1
    sheet = BearingStudy("209", part, one.load, one).sheet
    assert row_at(sheet.sections, "elements", "balls_largest").cells[1].as_shown == pytest.approx(
        4336, rel=0.02
    )
    assert "terms" not in [section.key for section in sheet.sections]
    assert any("carries almost no moment" in note for note in sheet.notes)
    # as stiff across as each of two
    two = examine(BallPair(**OF_209), BearingLoad(2 * 8900.0), 10)
    assert 2 * one.stiffness[0] == pytest.approx(two.stiffness[0], rel=1e-6)
    with pytest.raises(ValueError, match="cannot be part of an arm"):
        part.terms(None)


def test_a_single_roller_bearing_carries_no_axial_load(tmp_path):
    """Half the pair's load on one, the same roller loads; no axial load."""
    pair = (EXAMPLES / "nu212-pair.toml").read_text()
    one = "\n".join(
        line
        for line in pair.replace('"roller pair"', '"roller bearing"').splitlines()
        if not line.startswith("span")
    )
    (tmp_path / "one.toml").write_text(one)
    single = examine(read_bearing(tmp_path / "one.toml").part, BearingLoad(2000.0), 10)
    both = examine(read_bearing(EXAMPLES / "nu212-pair.toml").part, BearingLoad(4000.0), 10)
    np.testing.assert_allclose(single.settled.loads[0], both.settled.loads[0], rtol=1e-6, atol=1e-6)
    with pytest.raises(InputError, match="no axial load"):
        examine(single.bearing, BearingLoad(axial=100.0))


@pytest.mark.parametrize(
    ("more", "key"),
    [
        ('span = "60 mm"', "bearing.span"),
        ('preload = "100 N"', "bearing.preload"),
        ("balls = 90", "bearing"),
    ],
)
def test_what_a_single_bearing_has_not_is_refused(more, key, tmp_path):
    """Keys of a pair, and a drawing that no bearing can have: one message under its key."""
    text = (EXAMPLES / "6209.toml").read_text()
    (tmp_path / "x.toml").write_text(
        (text.replace("balls = 9\n", "") if "balls" in more else text) + more + "\n"
    )
    with pytest.raises(InputError) as refused:
        read_bearing(tmp_path / "x.toml")
    assert {problem.key for problem in refused.value.problems} == {key}


@pytest.mark.usefixtures("unpainted")
def test_a_single_bearing_is_drawn_and_printed(tmp_path):
    """The command writes its page; every plot has a section of its own."""
    done = ran(EXAMPLES / "6209.toml", "--force-radial", "2 kN", "--built", "20", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "6209-bearing" / "report.html").exists()
    part = read_bearing(EXAMPLES / "6209.toml").part
    one = examine(part, BearingLoad(2000.0), 20)
    keys = {section.key for section in BearingStudy("6209", part, one.load, one).sheet.sections}
    assert {plot.section for plot in bearing_plots(one)} <= keys


OF_STATED = (
    '[bearing]\nkind = "crossed roller"\nradial_runout = "2 µm"\nmoment_stiffness = "100 N '
    'm/arcmin"\nassumed = ["radial_runout"]\n'
)


@pytest.mark.usefixtures("unpainted")
@pytest.mark.parametrize(
    ("text", "keys"),
    [
        ((EXAMPLES / "6209-pair.toml").read_text(), {"inner_ring_warmer", "span"}),
        (OF_STATED, {"radial_runout"}),
    ],
    ids=["drawn", "stated"],
)
def test_assumed_values_of_a_bearing_are_counted_and_listed(tmp_path, text, keys):
    """What a bearing's table lists as assumed is counted in the headline, listed, and in
    result.json, of a drawing and of stated values.
    """
    (tmp_path / "b.toml").write_text(text)
    done = ran("b.toml", "--out", "out", "--full", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "What went in" in done.stdout
    result = json.loads((tmp_path / "out" / "result.json").read_text())
    assumed = result["states"]["assumed"]
    assert keys <= {
        each["key"] for each in assumed if each["reason"] == "assumed" and each["part"] == "bearing"
    }
    assert f"This rests on {result['states']['assumed_count']} assumed value" in " ".join(
        done.stdout.split()
    )
