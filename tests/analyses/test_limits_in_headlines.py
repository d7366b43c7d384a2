"""What rests on makers' upper limits is called 'at most', with the limit that counts most;
comparisons say what they do not count.
"""

from __future__ import annotations

import re

import pytest

import lostmotion
from lostmotion.analyses.sizing.page.selection import not_counted
from lostmotion.error_model.poses import sample_poses
from lostmotion.error_model.upper_limits import limit_shares
from tests.arms import arm_of as any_arm
from tests.reporting.first_screen import first_screen

pytestmark = pytest.mark.usefixtures("few_samples")

JOINT = """[[joints]]
name = "{name}"
type = "revolute"
axis = "{axis}"
limits = ["-90 deg", "90 deg"]
gearbox = {{ catalogue = "X-10", values = "{values}" }}
mounting = {{ tilt = "1 arcmin" }}
link = {{ length = "{length}", mass = "2 kg" }}
"""
ROWS = """[[reducers]]
models = ["X-10"]
maker = "X"
ratio = 100
upper_limits = ["hysteresis"]
source = "data sheet"
part = { rated_torque = "50 N m", stiffness = "20 N m/arcmin", hysteresis = "1 arcmin", mass = "3 kg" }
typical = { hysteresis = "0.1 arcmin", source = "measured on 5 pieces" }
[[reducers]]
models = ["Y-10"]
maker = "Y"
source = "data sheet"
part = { rated_torque = "50 N m", stiffness = "20 N m/arcmin", hysteresis = "0.5 arcmin" }
"""


def text_of(values, *, extra=""):
    """Return an arm of three joints with the same gearbox."""
    lengths = (("A", "z", "100 mm"), ("B", "y", "400 mm"), ("C", "y", "300 mm"))
    joints = "".join(
        JOINT.format(name=name, axis=axis, length=length, values=values)
        for name, axis, length in lengths
    )
    return 'name = "x"\n' + joints + ROWS + extra


def arm_of(tmp_path, values, **more):
    """Read it."""
    path = tmp_path / f"{values}.toml"
    path.write_text(text_of(values, **more), encoding="utf-8")
    return lostmotion.read(path)


def test_typical_values_bring_the_repeatability_down_by_their_share(tmp_path):
    """Where a loop of 1' at its maker's limit drives RP, one of 0.1' makes a tenth of it."""
    limit, typical = (
        lostmotion.study(arm_of(tmp_path, values), poses=8, robots=8, visits=30)
        .sampled.robot_means[:, :, 2]
        .mean()
        for values in ("limit", "typical")
    )
    assert typical == pytest.approx(0.1 * limit, rel=0.02)


@pytest.mark.parametrize("method", ["montecarlo", "analytic"])
def test_the_headline_of_a_study_names_the_limit_and_bounds_nothing_where_kinds_are_not_described(
    tmp_path, method
):
    """Both routes; with typical values no limit is named."""
    limit = lostmotion.study(
        arm_of(tmp_path, "limit"), poses=8, robots=8, visits=4, method=method
    ).sheet
    assert "95 % of positions within 0." in limit.verdict
    assert "within at most" not in first_screen(limit)
    assert "Makers' upper limits stand for hysteresis of X-10" in first_screen(limit)
    assert "The largest of them is hysteresis at" in first_screen(limit)
    assert not any("≤" in card.number for card in limit.cards)
    assert {each["key"] for each in limit.facts["states"]["upper_limits"]} == {"hysteresis"}
    if method == "montecarlo":
        assert "RP, ISO cycle" in first_screen(limit)
    typical = lostmotion.study(
        arm_of(tmp_path, "typical"), poses=8, robots=8, visits=4, method=method
    ).sheet
    assert "at most" not in first_screen(typical)
    assert "upper limit" not in first_screen(typical)
    assert not any("≤" in card.number for card in typical.cards)


def test_a_joint_taken_as_perfect_beside_a_limit_leaves_no_bound(tmp_path):
    """The headline is no bound: it names the joint, the sentence says that what rests on limits may
    also be less, and the card carries no sign.
    """
    extra = '[[joints]]\nname = "D"\ntype = "revolute"\nlimits = ["-90 deg", "90 deg"]\n'
    path = tmp_path / "arm.toml"
    path.write_text(
        text_of("limit").replace("[[reducers]]", extra + "[[reducers]]", 1), encoding="utf-8"
    )
    sheet = lostmotion.study(lostmotion.read(path), poses=8, robots=8, visits=4).sheet
    assert sheet.verdict.startswith("Expect 95 % of positions within 0.")
    assert ", though nothing is described for D (taken as perfect)" in sheet.verdict
    assert sheet.facts["states"]["bound"] == "neither"
    assert "neither side" not in sheet.verdict
    assert (
        "parts of these figures rest on them, so the true error may also be less"
        in first_screen(sheet)
    )
    assert sheet.cards[0].number[0].isdigit()


FULL = """[[joints]]
name = "A"
type = "revolute"
limits = ["-90 deg", "90 deg"]
gearbox = { catalogue = "X-10", ratio = 100, backlash = "0.1 arcmin", transmission_error = "0.1 arcmin" }
bearing = { kind = "rolling", span = "40 mm", clearance = "2 µm" }
encoder = { resolution = "1 arcsec" }
mounting = { tilt = "1 arcmin" }
link = { length = "300 mm", length_tolerance = "0.1 mm", rigid = true, mass = "2 kg" }
"""


@pytest.mark.parametrize(
    ("left_out", "bounded"),
    [("", True), ("encoder", False), ("bearing", False), ("mounting", False)],
)
def test_a_limit_bounds_an_error_only_where_every_kind_is_described(tmp_path, left_out, bounded):
    """One joint with every kind of error: 'at most', and the card's sign; with one kind less
    neither.
    """
    path = tmp_path / "arm.toml"
    lines = [line for line in FULL.splitlines() if not left_out or not line.startswith(left_out)]
    path.write_text("\n".join(['name = "x"', *lines, ROWS]), encoding="utf-8")
    sheet = lostmotion.study(lostmotion.read(path), poses=8, method="analytic").sheet
    assert ("within at most" in sheet.verdict) == bounded
    assert sheet.cards[0].number.startswith("≤ ") == bounded


def test_the_sheet_of_iso_9283_names_the_limits(tmp_path):
    """Loops at their makers' limits are named; they bound no figure, since kinds of error are not
    described.
    """
    asked = {"robots": 20, "visits": 4, "cube": "100 mm", "centre": "700 mm, 0 mm, 0 mm"}
    sheet = lostmotion.iso9283(arm_of(tmp_path, "limit"), **asked).sheet
    assert re.search(r"95 % of arms repeat within [^a:]*: RP_l, any approach", sheet.verdict)
    assert re.search(r"is within [^a:]* of the commanded point", sheet.verdict)
    assert re.search(r", [\d.]+ .?m( \([^)]*\))* with best-fit frames", sheet.verdict)
    assert "Makers' upper limits stand for hysteresis of X-10" in sheet.verdict
    # no bound where kinds of errors are not described
    assert [card.number[:2] for card in sheet.cards[:4]] == ["0.", "no", "0.", "0."]
    typical = lostmotion.iso9283(arm_of(tmp_path, "typical"), **asked).sheet
    assert "at most" not in typical.verdict


def test_shares_of_limits_are_those_of_the_budget(tmp_path):
    """The loops are all that scatters between visits, so that their shares add to one; the largest
    stands first.
    """
    arm = arm_of(tmp_path, "limit")
    q = sample_poses(arm, 64).q
    shares = limit_shares(arm, q)
    assert [each.key for each in shares] == ["hysteresis"] * 3
    assert [each.of_error for each in shares] == sorted(
        (each.of_error for each in shares), reverse=True
    )
    whole = {
        cost.part: cost for cost in lostmotion.study(arm, poses=64, robots=8, visits=2).budget.parts
    }
    for each in shares:
        assert each.of_repeat * sum(cost.levels[2] for cost in whole.values()) == pytest.approx(
            whole[f"joints.{each.joint}.gearbox"].levels[2], rel=1e-9
        )
    assert sum(each.of_repeat for each in shares) == pytest.approx(1.0)


def test_a_sweep_compares_masses_and_says_what_it_does_not_count(tmp_path):
    """A heavier reducer shows its mass, one of unknown mass is named, and the errors that rest on
    limits may be less.
    """
    path = tmp_path / "arm.toml"
    path.write_text(
        text_of("limit", extra='[sweep]\n"joints.B.gearbox" = ["X-10-100", "Y-10"]\n').replace(
            "ratio = 100\n", ""
        ),
        encoding="utf-8",
    )
    sheet = lostmotion.sweep(
        path, poses=16, robots=8, visits=4, out=tmp_path / "out", workers=1
    ).sheet
    (masses,) = (section for section in sheet.sections if section.key == "masses")
    assert [row.cells[0].as_shown for row in masses.rows] == pytest.approx([3 * 3 + 6, 2 * 3 + 6])
    assert [row.note for row in masses.rows] == ["", "mass of Y-10 not stated: counted as zero"]
    assert sheet.notes[0].startswith("not counted: motion")
    assert "mass of Y-10 (not stated: counted as zero)" in sheet.notes[0]
    assert "so the true error may also be less" in sheet.verdict
    assert {each["bound"] for each in sheet.facts["designs"]} == {"neither"}
    assert [each["mass_kg"] for each in sheet.facts["designs"]] == pytest.approx([15.0, 12.0])


def test_sizing_says_what_it_does_not_count():
    """By limits: stresses, prices and motion; for a target besides that only what was offered was
    chosen.
    """
    sheet = lostmotion.size(any_arm(1), poses=8).sheet
    assert "stresses and buckling of links" in sheet.notes[0]
    assert "prices" in sheet.notes[0]
    assert sheet.facts["not_counted"] == sheet.notes[0]


def test_a_choice_of_parts_says_what_it_does_not_count(tmp_path):
    """Prices where none count, clearances where none are offered, and the mass of a reducer that
    nobody states.
    """
    arm = arm_of(tmp_path, "limit")
    by = tmp_path / "by.toml"
    by.write_text(
        (
            '[sizing]\ntarget = "3 mm"\nminimise = "price"\nkeep = true\n[sizing.gearboxes]\nB = '
            '["Y-10"]\n[sizing.costs]\nY-10 = { price = 3 }\n'
        ),
        encoding="utf-8",
    )
    from lostmotion.io.own_reducers import read_reducers

    found = lostmotion.size(arm, by, poses=8, reducers=read_reducers(tmp_path / "limit.toml"))
    said = not_counted(found)
    assert "mass of Y-10" in said
    assert "other bearing clearances than the arm's" in said
    assert "prices" not in said
