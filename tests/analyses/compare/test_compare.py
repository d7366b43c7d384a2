"""Comparison of arms: paired differences against two studies, a closed form, replicated runs, and
what differs in the descriptions.
"""

from __future__ import annotations

import io
import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console
from typer.testing import CliRunner

import lostmotion
from lostmotion.cli.app import app
from lostmotion.comparison.description import ABSENT
from lostmotion.error_model.differences import ZERO as NOTHING
from lostmotion.error_model.intervals import Estimate
from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.reporting.first_screen import print_first_screen
from lostmotion.reporting.screen import print_sheet
from tests.examples.test_planar_2r import (
    CUT,
    FILE,
    GRAVITY,
    K1,
    K2,
    L2,
    LENGTH,
    MASS,
    ZERO,
    lever_arms,
)

VALIDATES = (
    (
        "comparison of arms",
        (
            "two studies with the same draws; the planar 2R with another spring in closed form; "
            "50 pairs of runs against one of 16 million samples each"
        ),
        "every digit; 1e-9; no more than 8 of 50 intervals of any figure miss",
        "comparison/comparison.py comparison/compared_arm.py",
    ),
)

EXAMPLES = FILE.parent
# A quick arm whose error differs from robot to robot and from visit to visit.
ARM = """
name = "two joints"
[payload]
mass = "2 kg"
[[joints]]
name = "A"
type = "revolute"
axis = "z"
limits = ["-90 deg", "90 deg"]
gearbox = { ratio = 100, stiffness = "8 N m/arcmin", backlash = "0.6 arcmin ± 0.2 arcmin" }
encoder = { zero = "1 arcmin" }
link = { length = "400 mm ± 60 µm", rigid = true }
[[joints]]
name = "B"
type = "revolute"
axis = "-y"
limits = ["-150 deg", "150 deg"]
gearbox = { ratio = 100, stiffness = "4 N m/arcmin", backlash = "0.8 arcmin ± 0.4 arcmin" }
encoder = { zero = "1 arcmin", noise = "0.1 arcmin" }
link = { length = "300 mm ± 60 µm", rigid = true }
"""
# Another gearbox at A, another spring and encoder at B.
OTHER = (
    ARM.replace("0.6 arcmin ± 0.2 arcmin", "0.3 arcmin ± 0.1 arcmin")
    .replace("4 N m/arcmin", "5 N m/arcmin")
    .replace('zero = "1 arcmin", noise', 'zero = "1.4 arcmin", noise')
)
CHANGED = {"joints.A.gearbox", "joints.B.gearbox", "joints.B.encoder"}
# Levels of chance in a comparison and in a study.
OF_LEVELS = {
    "rms": "all_together",
    "rms_design": "from_load_and_pose",
    "rms_robot": "from_the_manufacture_of_each_robot",
    "rms_visit": "from_visit_to_visit",
}
SMALL = {"poses": 64, "robots": 80, "visits": 4, "threads": 1}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Return the paths of the quick arm and of the other one."""
    folder = tmp_path_factory.mktemp("arms")
    for name, text in (("one", ARM), ("other", OTHER)):
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    return folder / "one.toml", folder / "other.toml"


@pytest.fixture(scope="module")
def found(files):
    """Return the comparison of the quick arm with the other one."""
    return lostmotion.compare(*files, **SMALL)


def test_a_change_is_the_difference_of_two_studies(files, found):
    """Every figure is that of a study of each arm by itself, but for rounding where its unit is
    another, and its change is theirs to the last bit.
    """
    result = found.result()["figures"]
    for file, label in zip(files, ("one", "other"), strict=True):
        figures = lostmotion.study(file, 64, 80, 4, threads=1).result()["figures"]
        alone = {
            **{key: figures["error"][key] for key in ("p95", "p99", "mean", "rotation_rms")},
            **figures["levels"],
        }
        alone |= {
            "ap_p95": figures["iso9283"]["ap_p95"],
            "rp_any_p95": figures["iso9283"]["rp_any_p95"],
        }
        for key, name in (
            *((each, each) for each in alone if each in result["figures"]),
            *OF_LEVELS.items(),
        ):
            one, other = (
                result["figures"][key][label],
                alone[name]["rms_error"] if key in OF_LEVELS else alone[name],
            )
            ends = [[each[end] for end in ("value", "low", "high")] for each in (one, other)]
            assert [end is None for end in ends[0]] == [end is None for end in ends[1]], key
            metres = [
                [end for end in of if end is not None]
                for of, each in zip(ends, (one, other), strict=True)
            ]
            assert metres[0] == pytest.approx(metres[1], rel=1e-12), key
            assert one["unit"] == other["unit"], key
    values = {each.key: [each.value(arm).value for arm in found.arms] for each in found.measures}
    for key, change in found.changes[0].figures.items():
        assert change.value == values[key][1] - values[key][0], key


def test_an_arm_differs_from_itself_by_exactly_nothing(files):
    """The same description gives the same errors in every sample, and zero without any uncertainty
    everywhere.
    """
    same = lostmotion.compare(files[0], lostmotion.read(files[0]), **SMALL)
    (change,) = same.changes
    assert change.same
    for measure in same.measures:
        assert change.figures[measure.key].value == 0, measure.key
        assert measure.exact or change.figures[measure.key] == NOTHING
    assert all(
        each.alone == each.share == NOTHING and each.before == each.after
        for each in (each for items in change.by.values() for each in items)
    )
    assert not same.values
    assert not same.states
    assert "No difference:" in same.sheet.verdict


def test_exchanging_the_arms_changes_the_sign_and_nothing_else(files, found):
    """Value and both ends of every interval are mirrored at zero."""
    back = lostmotion.compare(*reversed(files), **SMALL)
    forth = found.changes[0]

    def mirrored(estimate):
        return [-estimate.value, -estimate.high, -estimate.low]

    for key, change in back.changes[0].figures.items():
        np.testing.assert_array_equal(
            [change.value, change.low, change.high], mirrored(forth.figures[key]), err_msg=key
        )
    for one, other in ((back.changes[0].by[grouping], forth.by[grouping]) for grouping in forth.by):
        of_other = {each.part: each for each in other}
        for each in one:
            twin = of_other[each.part]
            assert (each.before, each.after) == (twin.after, twin.before)
            for mine, its in ((each.alone, twin.alone), (each.share, twin.share)):
                np.testing.assert_allclose(
                    [mine.value, mine.low, mine.high], mirrored(its), rtol=1e-9, atol=1e-18
                )


def test_shares_of_parts_add_to_the_change_and_unchanged_parts_have_none(found):
    """By part and by kind of error they add to the change of the r.m.s. error; of parts that do not
    differ, only A's encoder has one, by its lever: B's other spring holds the tool elsewhere.
    """
    (change,) = found.changes
    reach = [
        (pose_matrix(each.arm, each.poses.q).state.frames[-1, :, :2, 3] ** 2).sum(axis=1)
        for each in found.arms
    ]
    (rms,) = (each for each in found.measures if each.key == "rms")
    roots = sum(rms.value(each).value for each in found.arms)
    for items in change.by.values():
        assert sum(each.share.value for each in items) == pytest.approx(
            change.figures["rms"].value, rel=1e-9
        )
    shares = {each.part: each.share for each in change.parts if each.share.value}
    assert set(shares) == {*CHANGED, "joints.A.encoder"}
    assert shares["joints.A.encoder"].value == pytest.approx(
        CUT / 9 * ZERO**2 * (reach[1] - reach[0]).mean() / roots, rel=1e-9
    )
    assert all(each.share == NOTHING for each in change.parts if each.part not in shares)


def test_the_intervals_of_changes_are_narrower_than_those_of_two_studies(found):
    """What both arms share cancels: of this pair the interval of the mean's change is less than
    half as wide as independent runs would give.
    """
    for measure in found.measures:
        if measure.exact:
            continue
        ends = [measure.value(each) for each in found.arms]
        independent = math.hypot(*(each.high - each.low for each in ends))
        change = found.changes[0].figures[measure.key]
        assert change.high - change.low <= independent, measure.key
        if measure.key == "mean":
            assert change.high - change.low < independent / 2


def test_a_softer_spring_of_the_planar_arm_is_the_closed_form(tmp_path):
    """Elbow springs of 4 and 3 N m/arcmin: the change of the r.m.s. error, of the sag and the
    shares by the joints are those of the arm where it stands under its load, on paper.
    """
    text = FILE.read_text(encoding="utf-8")
    (tmp_path / "soft.toml").write_text(
        text.replace("4 N m/arcmin", "3 N m/arcmin"), encoding="utf-8"
    )
    compared = lostmotion.compare(
        FILE, tmp_path / "soft.toml", poses=64, robots=2, visits=1, threads=1
    )
    q = compared.arms[0].poses.q
    loads, levers, sags = [], [], []
    for spring in (K2, 3 / 4 * K2):
        wound = np.zeros_like(q)
        for _ in range(20):  # each round leaves less than a thousandth of the one before
            whole, wrist = lever_arms(q - wound)
            wound = MASS * GRAVITY * np.column_stack([whole[:, 0] / K1, wrist[:, 0] / spring])
        stands = lever_arms(q - wound)[0]
        bias = stands - lever_arms(q)[0]
        loads.append((bias**2).sum(axis=1))
        levers.append(ZERO**2 * CUT / 9 * (stands**2).sum(axis=1))
        sags.append(-bias[:, 1].mean())
    others = CUT / 9 * (ZERO**2 * L2**2 + 2 * LENGTH**2)
    squares = [load + lever + others for load, lever in zip(loads, levers, strict=True)]
    roots = np.sqrt([each.mean() for each in squares])
    figures = compared.changes[0].figures
    assert figures["rms"].value == pytest.approx(roots[1] - roots[0], rel=1e-9)
    assert figures["sag"].value == pytest.approx(sags[1] - sags[0], rel=1e-9)
    parts = {each.part: each for each in compared.changes[0].parts if each.share.value}
    assert list(parts) == [
        "joints.elbow.gearbox",
        "joints.shoulder.gearbox",
        "joints.shoulder.encoder",
    ]
    # Differences of the mean squares over the sum of the roots: the springs together, and the lever
    # of the shoulder's zero.
    elbow, shoulder, zero = parts.values()
    assert elbow.share.value + shoulder.share.value == pytest.approx(
        (loads[1] - loads[0]).mean() / roots.sum(), rel=1e-9
    )
    # it differs by where the arm stands alone, which is settled to 1e-9 of the wind-up
    assert zero.share.value == pytest.approx((levers[1] - levers[0]).mean() / roots.sum(), rel=1e-8)
    # the shoulder's spring itself is the same, and its lever to less than the angle of wind-up
    most = np.abs(wound).sum(axis=1).max()
    assert abs(shoulder.share.value) < most * elbow.share.value
    assert elbow.before == pytest.approx(3 / 4 * elbow.after, rel=most)
    # The interval, from eight sets: the delta method on each set's change of the root.
    of_sets = [np.sqrt(each.reshape(8, -1).mean(axis=1)) for each in squares]
    # Student, 7 degrees of freedom
    spread = np.std(of_sets[1] - of_sets[0], ddof=1) / math.sqrt(8) * 2.3646242510102993
    assert figures["rms"].high - figures["rms"].value == pytest.approx(spread, rel=0.2)


@pytest.mark.slow
def test_intervals_contain_the_true_change(files):
    """Over 50 seeds each 95 % interval misses the change of a run of 4 096 poses and 4 000 robots
    in no more than 8 cases.
    """
    arms = [lostmotion.read(file) for file in files]
    truth = (
        lostmotion.compare(*arms, poses=4096, robots=4000, visits=4, seed=1000).changes[0].figures
    )
    missed = dict.fromkeys((key for key in truth if key not in {"mass", "load"}), 0)
    for seed in range(50):
        figures = (
            lostmotion.compare(*arms, poses=64, robots=120, visits=4, seed=seed, threads=1)
            .changes[0]
            .figures
        )
        for key in missed:
            missed[key] += not figures[key].low <= truth[key].value <= figures[key].high
    assert max(missed.values()) <= 8, missed


def test_a_change_smaller_than_its_interval_is_not_seen(tmp_path, files):
    """A spring that is stiffer by 0.01 per mille changes the 95 % error by less than its histogram
    resolves; the mean, free of bins, shows it.
    """
    (tmp_path / "nearly.toml").write_text(
        ARM.replace("4 N m/arcmin", "4.00004 N m/arcmin"), encoding="utf-8"
    )
    found = lostmotion.compare(files[0], tmp_path / "nearly.toml", **SMALL)
    sheet = found.sheet
    assert sheet.verdict.startswith("No difference seen between nearly and one")
    notes = {
        row.key: row.note
        for section in sheet.sections
        if section.key == "changes"
        for row in section.rows
    }
    assert notes["p95"] == "no difference seen"
    assert not notes["mean"]
    assert found.changes[0].figures["mean"].high < 0


@pytest.mark.parametrize("second", ["one more joint", "other limits"])
def test_arms_with_other_joints_have_poses_of_their_own(tmp_path, files, second):
    """A part that one arm lacks has its whole error in the other; shares still add, and the page
    states that poses differ.
    """
    more = ARM + (
        '[[joints]]\nname = "C"\ntype = "prismatic"\naxis = "x"\nlimits = ["0 mm", "100 mm"]\n'
        'encoder = { zero = "50 µm" }\n'
    )
    text = more if second == "one more joint" else ARM.replace("-150 deg", "-140 deg")
    (tmp_path / "second.toml").write_text(text, encoding="utf-8")
    found = lostmotion.compare(files[0], tmp_path / "second.toml", **SMALL)
    (change,) = found.changes
    assert not found.paired
    for items in change.by.values():
        assert sum(each.share.value for each in items) == pytest.approx(
            change.figures["rms"].value, rel=1e-9
        )
    poses = dict(found.sheet.brief)["Poses"]
    if second == "one more joint":
        assert "their joints differ" in poses
        (encoder,) = [each for each in change.parts if each.part == "joints.C.encoder"]
        assert encoder.before is None
        assert encoder.alone.value == encoder.after > 0
        assert [(each.name, each.texts) for each in found.values] == [
            ("joint C", (ABSENT, "prismatic"))
        ]
        back = lostmotion.compare(tmp_path / "second.toml", files[0], **SMALL).changes[0]
        assert back.figures["p95"].value == -change.figures["p95"].value
    else:
        assert "their joint limits differ" in poses
        assert [each.name for each in found.values] == ["joint B: limits"]


def test_more_than_two_arms_are_compared_with_the_first(tmp_path, files, found):
    """The changes of the second are those of the comparison of two; the headline names the most
    accurate arm.
    """
    three = lostmotion.compare(*files, files[0], **SMALL)
    assert [each.label for each in three.arms] == ["one (1)", "other", "one (2)"]
    assert three.changes[0].figures == found.changes[0].figures
    assert three.changes[1].same
    assert three.sheet.verdict.startswith("Of 3 arms other is the most accurate")
    three.report(tmp_path / "report")
    keys = json.loads((tmp_path / "report" / "result.json").read_text(encoding="utf-8"))["figures"]
    assert {"parts_2", "parts_3", "parts_shares_2", "causes_3"} <= set(keys)


def test_the_most_accurate_of_several_arms_is_one_that_is_seen_to_be(tmp_path, files):
    """Arms that differ by less than the samples resolve are not ranked: the headline names those
    that may be as accurate.
    """
    (tmp_path / "nearly.toml").write_text(
        ARM.replace("4 N m/arcmin", "4.00004 N m/arcmin"), encoding="utf-8"
    )
    (tmp_path / "worse.toml").write_text(
        ARM.replace("4 N m/arcmin", "2 N m/arcmin"), encoding="utf-8"
    )
    found = lostmotion.compare(tmp_path / "worse.toml", files[0], tmp_path / "nearly.toml", **SMALL)
    assert re.match(
        r"Of 3 arms (one|nearly) has the smallest error, .*; no difference seen from (one|nearly)\.",
        found.sheet.verdict,
    )


def test_a_part_that_is_gone_has_no_unit(tmp_path, files):
    """The bar of a part that only one arm has shows its size with a unit, and a dash for the
    other.
    """
    (tmp_path / "without.toml").write_text(
        ARM.replace('encoder = { zero = "1 arcmin" }\n', ""), encoding="utf-8"
    )
    found = lostmotion.compare(files[0], tmp_path / "without.toml", **SMALL)
    effects = {bar.label: str(bar.effect) for block in found.sheet.bars for bar in block.bars}
    assert re.fullmatch(r"[\d.]+ [mµ]m → -", effects["A.encoder"])


def test_a_share_that_other_parts_only_turn_has_no_row(found):
    """What is less than a ten-thousandth of the largest share is omitted from tables and charts,
    and the note counts it.
    """
    change = found.changes[0]
    largest = change.parts[0].share.value
    turned = replace(
        change.parts[0], part="joints.C.encoder", share=Estimate(9e-5 * largest, math.nan, math.nan)
    )
    more = replace(change, by={**change.by, "parts": (*change.parts, turned)})
    (section,) = [
        each
        for each in replace(found, changes=(more,)).sheet.sections
        if each.key == "parts_shares"
    ]
    assert "C.encoder" not in [row.label for row in section.rows]
    assert {"A.gearbox", "B.gearbox", "B.encoder", "all"} <= {row.label for row in section.rows}
    assert re.match(
        r"[1-9]\d* without a share, or with less than 0\.01 % of the largest one\.", section.note
    )


def test_what_differs_is_listed_in_the_words_of_the_file(tmp_path, files):
    """Values with their units, assumed or stated; equal changes at several joints once; a kind of
    error that one arm lacks is a warning.
    """
    text = (
        ARM.replace("4 N m/arcmin", "8 N m/arcmin")
        .replace("8 N m/arcmin", "10 N m/arcmin")
        .replace("2 kg", "2.5 kg")
    )
    text = text.replace(
        ', noise = "0.1 arcmin" }', ' }\nassumed = ["encoder"]\nmounting = { tilt = "20 arcsec" }'
    )
    (tmp_path / "changed.toml").write_text(text, encoding="utf-8")
    found = lostmotion.compare(files[0], tmp_path / "changed.toml", **SMALL)
    assert {each.name: each.texts for each in found.values} == {
        "payload: mass": ("2 kg", "2.5 kg"),
        "gearbox of A: stiffness": ("8 N m/arcmin", "10 N m/arcmin"),
        "gearbox of B: stiffness": ("4 N m/arcmin", "10 N m/arcmin"),
        "encoder of B: noise": ("0.1 arcmin", "-"),
        "encoder of B: zero": ("1 arcmin", "1 arcmin (assumed)"),
        "mounting of B: tilt": ("-", "0.333333 arcmin"),
    }
    assert {(each.place, each.kind): each.states for each in found.states} == {
        ("B", "encoder"): ("stated", "assumed"),
        ("B", "axis mounting"): ("ideal", "stated"),
    }
    assert any("axis mounting of B" in warning for warning in found.sheet.warnings)


def test_stated_prices_are_added_and_joints_without_one_are_named(tmp_path):
    """The price of a joint includes its gearbox's; links and tool add theirs; an arm without any
    price has none, which is not zero.
    """
    priced = ARM.replace("ratio = 100,", "ratio = 100, price = 900,").replace(
        'name = "B"', 'name = "B"\nprice = 1250'
    )
    (tmp_path / "priced.toml").write_text(
        priced.replace("rigid = true", "rigid = true, price = 40"), encoding="utf-8"
    )
    dearer = (
        priced.replace("price = 900", "price = 1000").replace(
            "rigid = true", "rigid = true, price = 40"
        )
        + "[tool]\nprice = 7\n"
    )
    (tmp_path / "dearer.toml").write_text(dearer, encoding="utf-8")
    (tmp_path / "partly.toml").write_text(
        ARM.replace("ratio = 100,", "ratio = 100, price = 900,", 1), encoding="utf-8"
    )
    (tmp_path / "none.toml").write_text(ARM, encoding="utf-8")
    prices = {
        name: lostmotion.read(tmp_path / f"{name}.toml").price
        for name in ("priced", "dearer", "partly", "none")
    }
    assert prices == {
        "priced": 900 + 1250 + 80,
        "dearer": 1000 + 1250 + 80 + 7,
        "partly": 900,
        "none": None,
    }
    text = (EXAMPLES / "z-arm-drawn.toml").read_text(encoding="utf-8")
    (tmp_path / "drawn.toml").write_text(
        text.replace("rated_torque = ", "price = 500\nrated_torque = "), encoding="utf-8"
    )
    assert lostmotion.read(tmp_path / "drawn.toml").price == 5 * 500
    found = lostmotion.compare(*(tmp_path / f"{name}.toml" for name in prices), **SMALL)
    of_price = [change.figures["price"].value for change in found.changes]
    assert of_price[:2] == [107.0, 900 - 2230]
    assert math.isnan(of_price[2])
    brief = dict(found.sheet.brief)["Price"]
    assert brief.startswith("2230 → 2337 → 900 → not stated")
    assert "B in partly; A, B in none" in brief
    assert found.changes[0].same
    two = lostmotion.compare(tmp_path / "priced.toml", tmp_path / "dearer.toml", **SMALL).sheet
    assert "It costs 107 more." in two.verdict
    assert "prices" not in " ".join(two.notes)


@pytest.mark.usual_counts
def test_an_arm_whose_errors_are_not_small_is_not_compared(tmp_path, files):
    """With a zero uncertain by sixty degrees adding errors up fails: the headline says so and names
    the arm, and no interval of an error is printed.
    """
    (tmp_path / "loose.toml").write_text(
        ARM.replace('zero = "1 arcmin", noise', 'zero = "60 deg", noise'), encoding="utf-8"
    )
    sheet = lostmotion.compare(files[0], tmp_path / "loose.toml", **SMALL).sheet
    assert sheet.verdict.startswith("loose: First-order figures fail here")
    assert not any(
        figure.interval
        for section in sheet.sections
        for row in section.rows
        for figure in row.cells
    )


def test_given_poses_are_those_of_every_arm(tmp_path, files):
    """A CSV of poses, or an array: all arms stand there, with no interval for the choice of poses;
    a file that suits only one arm is refused.
    """
    (tmp_path / "poses.csv").write_text("A [deg],B [deg]\n0,30\n10,-40\n", encoding="utf-8")
    found = lostmotion.compare(*files, poses=tmp_path / "poses.csv", robots=80, visits=2)
    assert found.paired
    assert [len(each.poses) for each in found.arms] == [2, 2]
    assert math.isnan(found.changes[0].figures["rms"].low)
    assert math.isfinite(found.changes[0].figures["mean"].low)
    same = lostmotion.compare(*files, poses=np.radians([[0, 30], [10, -40]]), robots=80, visits=2)
    assert same.changes[0].figures["mean"].value == pytest.approx(
        found.changes[0].figures["mean"].value, rel=1e-12
    )
    (tmp_path / "renamed.toml").write_text(
        ARM.replace('name = "B"', 'name = "C"'), encoding="utf-8"
    )
    with pytest.raises(lostmotion.InputError, match=r"poses\.csv"):
        lostmotion.compare(files[0], tmp_path / "renamed.toml", poses=tmp_path / "poses.csv")


def test_every_text_fits_a_terminal_and_no_number_is_a_power_of_ten(found):
    """The first screen has no more than 40 lines, every figure fits 80 columns, and numbers are
    written out.
    """
    first, whole = (io.StringIO() for _ in range(2))
    print_first_screen(found.sheet, Console(file=first, width=80))
    print_sheet(found.sheet, Console(file=whole, width=80))
    assert len(first.getvalue().splitlines()) <= 40
    for text in (first.getvalue(), whole.getvalue()):
        assert max(map(len, text.splitlines())) <= 80
        assert not re.search(r"\de[-+]\d", text)


def test_the_page_shows_every_section_and_its_plots(found, tmp_path):
    """The report has the answer, the tables and four plots; its figures are those of
    result.json.
    """
    folder = found.report(tmp_path / "out")
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert [plot.key for plot in found.plots] == ["changes", "parts", "shares", "distribution"]
    assert all(f'id="plot-{plot.key}"' in page for plot in found.plots)
    said = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    change = said["figures"]["changes"]["p95"]["change"]
    assert change["value"] == pytest.approx(found.changes[0].figures["p95"].value)
    (plain,) = said["changes"]
    assert plain["figures"]["p95"][0] == found.changes[0].figures["p95"].value
    assert sum(each["share_m"][0] for each in plain["members"]) == pytest.approx(
        plain["figures"]["rms"][0], rel=1e-9
    )
    assert said["differences"][0]["values"] == [
        "0.6 arcmin ± 0.2 arcmin",
        "0.3 arcmin ± 0.1 arcmin",
    ]


def test_mistakes_are_reported_all_at_once(files, tmp_path):
    """One arm alone, a missing file, an arm without any error: each is refused with what is
    expected and an example.
    """
    run = CliRunner().invoke
    (tmp_path / "bare.toml").write_text(
        'name = "bare"\n[[joints]]\nname = "A"\ntype = "revolute"\naxis = "z"\nlimits = ["-90 '
        'deg", "90 deg"]\n'
    )
    for words, expected in (
        ([str(files[0])], ("ARMS", "one arm", "2 to 6 arms")),
        ([str(files[0]), "none.toml", "--robots", "0"], ("none.toml", "--robots")),
        ([str(files[0]), str(tmp_path / "bare.toml")], ("bare", "no error source")),
        ([*map(str, files), "--sidecar", "a.toml"], ("--sidecar", "beside a URDF only")),
    ):
        error = run(app, ["compare", *words, "--out", str(tmp_path / "out")]).exception
        assert isinstance(error, lostmotion.InputError), words
        assert all(text in str(error) for text in expected), str(error)
    assert not (tmp_path / "out").exists()
    for words in ((), (1, 2)):
        with pytest.raises(lostmotion.InputError):
            lostmotion.compare(*words)


def test_two_sidecars_of_one_robot_description_are_compared(tmp_path):
    """Each URDF takes the sidecar of its place, and is named after it."""
    urdf = EXAMPLES / "ur5e.urdf"
    softer = (EXAMPLES / "ur5e.toml").read_text(encoding="utf-8")
    (tmp_path / "other.toml").write_text(
        softer.replace('mass = "', 'mass = "1', 1), encoding="utf-8"
    )
    found = lostmotion.compare(
        urdf,
        urdf,
        sidecar=[EXAMPLES / "ur5e.toml", tmp_path / "other.toml"],
        poses=8,
        robots=2,
        visits=1,
    )
    assert found.arms[1].label == "other"
    assert found.paired
    assert found.values


def test_a_change_below_a_nanometre_has_no_number(tmp_path):
    """A link that is longer by 2.3 mm stretches the lever of a fine encoder: a change of a
    millionth of a micrometre is reported as small, and no bar shows it.
    """
    text = """name = "half"
[[joints]]
name = "B"
type = "revolute"
axis = "z"
limits = ["0 deg", "90 deg"]
encoder = { resolution = "1e-6 deg" }
link = { length = "LENGTH ± 100 µm", direction = "x" }
"""
    paths = [tmp_path / f"{name}.toml" for name in ("one", "two")]
    for path, size in zip(paths, ("400 mm", "402.3 mm"), strict=True):
        path.write_text(text.replace("LENGTH", size), encoding="utf-8")
    sheet = lostmotion.compare(*paths, **SMALL).sheet
    assert "(change below 0.001 µm)" in dict(sheet.brief)["Repeatability"]
    assert not [block for block in sheet.bars if block.key.startswith("parts_shares")]
