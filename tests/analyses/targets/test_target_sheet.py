"""Targets from the command to the folder: arguments, tables, plots, files and messages."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.analyses.targets.page.items import in_unit, ordered, size_at
from lostmotion.analyses.targets.page.plots import plots
from lostmotion.error_model.intervals import Estimate
from lostmotion.error_model.items import Item, StatedSize
from lostmotion.error_model.pose_selection import poses_in_zone
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.mechanism.state import tool_points
from lostmotion.propagation import factor_metrics as metrics
from lostmotion.reporting.layout import key_of, row_at
from tests.command import carried_out, carried_out_by_process

EXAMPLES = Path(__file__).parents[3] / "examples"
ARM = EXAMPLES / "paper" / "z-arm-lumped.toml"
QUICK = {"poses": 16, "robots": 60, "visits": 4}
WORDS = ("--poses", "16", "--robots", "60", "--visits", "4")


def ran(*words, cwd):
    """Run the command in a folder."""
    return carried_out("target", *words, cwd=cwd)


@pytest.fixture(scope="module", params=["not met", "met", "repeatability"])
def asked(request):
    """Return a target that is not met, one that is met, and one for repeatability, from few
    samples.
    """
    wanted = {
        "not met": {"error": "2 mm"},
        "met": {"error": "6 mm"},
        "repeatability": {"rp_any": "3 mm"},
    }
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(metrics, "_SAMPLES", 1 << 14)
        return lostmotion.target(lostmotion.read(ARM), **wanted[request.param], **QUICK)


def test_every_item_is_in_one_table(asked):
    """Each item is in one table: with its allowed size, out of reach, or not limiting; plots belong
    to sections; the result is plain data.
    """
    sheet, found = asked.sheet, asked
    keys = [section.key for section in sheet.sections]
    for each in found.allowances:
        if each.verdict == "sized":
            row = row_at(sheet.sections, "single", key_of(short_name(each.item.name)))
            assert row.cells[0].value == pytest.approx(size_at(each.item, each.factor).value)
            assert row.cells[1].as_shown > 0
        elif each.verdict == "none":
            assert "none" in keys
            assert each.without.value > found.target
        else:
            assert "any" in keys
    assert {plot.section for plot in plots(found)} <= set(keys)
    said = asked.result()
    assert "nan" not in json.dumps(said, allow_nan=False)
    assert len(said["items"]) == len(found.items)
    assert (
        ("is met" in sheet.verdict)
        == said["target"]["kept"]
        == (found.current.value <= found.target)
    )
    of_size = {"allowed size of the tightest item": 0, "size that one item alone needs": -1}
    for card in (card for card in sheet.cards if card.title in of_size):
        one = ordered(found.allowances)[of_size[card.title]]
        allowed = size_at(one.item, one.factor)
        assert card.number == str(allowed.alone)
    for name in ("equal_factor", "equal_effect"):
        assert sum(each["mean_square_m2"] for each in said[name].values()) == pytest.approx(
            np.nansum(getattr(found, name).mean_squares), rel=1e-9
        )


def test_yield_has_its_interval(asked):
    """The share of robots on the sheet is that of `production_yield`, for the same arm and
    counts.
    """
    first = asked.yields[0]
    other = lostmotion.production_yield(
        lostmotion.read(ARM), asked.target, criterion=first.criterion, **QUICK
    )
    assert (other.within, other.interval) == (first.within, first.interval)
    rows = next(section for section in asked.sheet.sections if section.key == "yield").rows
    assert rows[0].cells[0].as_shown == pytest.approx(100 * first.share)
    assert f"{first.within} of 60 robots" in rows[0].note


def test_items_that_do_not_limit_a_target_are_named_so(monkeypatch):
    """No encoder with a few counts per turn: the table says "not limiting", result.json null, and
    the allocated yield has its interval.
    """
    monkeypatch.setattr(metrics, "_SAMPLES", 1 << 14)
    joint = {"name": "A", "type": "revolute", "limits": (-1.0, 1.0), "link": {"length": 1.0}}
    arm = lostmotion.Arm(
        name="one",
        joints=({**joint, "encoder": {"zero": 3e-4, "resolution": 1e-6, "ratio": 100.0}},),
    )
    asked = lostmotion.target(arm, error="5 mm", poses=np.zeros((8, 1)), robots=100, visits=2)
    row = row_at(asked.sheet.sections, "together", "A_encoder_resolution")
    assert str(row.cells[2]) == "not limiting"
    assert row_at(asked.sheet.sections, "single", "A_encoder_resolution") is None
    assert str(row_at(asked.sheet.sections, "usual", "encoder_resolution").cells[0]) == "216 arcmin"
    said = asked.result()
    assert "joints_A_encoder_resolution" in said["figures"]["together"]
    told = said["equal_effect"]["joints.A.encoder resolution"]
    assert (told["factor"], told["not_limiting"]) == (None, True)
    # One count is 2 pi / 100 at the motor, a hundredth of it at the output, and uniform.
    assert told["mean_square_m2"] == pytest.approx((2 * math.pi / 1e4) ** 2 / 12)
    (counts,) = [each for each in said["items"] if each["cause"] == "resolution"]
    assert (counts["verdict"], counts["allowed"]) == ("usual", None)
    rows = next(
        section for section in asked.sheet.sections if section.key == "yield_allocated"
    ).rows
    assert all(
        row.cells[0].low < row.cells[0].value < row.cells[0].high
        for row in rows
        if row.label.startswith("equal effect")
    )
    assert "With the sizes of equal effect" in asked.sheet.verdict


def test_the_yield_of_a_study_is_that_of_its_robots():
    """The yield of a study counts its own robots; a target as text or in metres means the same."""
    study = lostmotion.study(lostmotion.read(ARM), 16, 60, 4, seed=3)
    found = lostmotion.production_yield(study, "2.5 mm", criterion="repeatability")
    np.testing.assert_allclose(
        found.figures, np.sort(study.sampled.robot_means[:, :, 2].mean(axis=0)), rtol=1e-9
    )
    assert (
        found.within == lostmotion.production_yield(study, 2.5e-3, criterion="repeatability").within
    )
    assert "robots meet 2.5 mm (repeatability)" in repr(found)


def test_sizes_have_practical_units():
    """Angles in arcmin, stiffness in N m/arcmin or N/µm, lengths in µm or mm; the interval of a
    stiffness is inverted.
    """
    assert str(in_unit(StatedSize(math.pi / 10800, "rad"), 2.0)) == "2.00 arcmin"
    assert (
        str(in_unit(StatedSize(49 * 10800 / math.pi, "N m/rad", divides=True), 2.0))
        == "24.5 N m/arcmin"
    )
    assert str(in_unit(StatedSize(200e6, "N/m", divides=True), 0.5)) == "400 N/µm"
    factor = Estimate(2.0, 1.6, 2.5)
    clearance = size_at(
        Item("joints.A.bearing", "bearing", "clearance", (0,), StatedSize(60e-6, "m")), factor
    )
    assert (clearance.value, clearance.low, clearance.high) == pytest.approx(
        (0.12e-3, 0.096e-3, 0.15e-3)
    )
    per_arcmin = StatedSize(49 * 10800 / math.pi, "N m/rad", divides=True)
    stiffness = size_at(
        Item("joints.A.gearbox", "gearbox", "stiffness", (0,), per_arcmin, stiff=True), factor
    )
    per_rad = 49 * 10800 / math.pi
    assert (stiffness.low, stiffness.high) == pytest.approx((per_rad / 2.5, per_rad / 1.6))
    link = size_at(Item("joints.A.link", "link", "stiffness", (0,), stiff=True), factor)
    assert (link.value, link.low, link.high) == pytest.approx((0.5, 0.4, 0.625))
    assert (clearance.shown, link.shown) == ("mm", "%")
    assert (clearance.unit, stiffness.unit, link.unit) == ("m", "N m/rad", "1")


def test_an_arm_without_error_meets_any_target():
    """Where no error moves the tool there is no allocation: every robot meets the target, and the
    yield is plotted; one pose is enough.
    """
    joint = {
        "name": "A",
        "type": "revolute",
        "limits": (-1.0, 1.0),
        "axis": "x",
        "link": {"length": 0.5, "direction": "x"},
    }
    arm = lostmotion.Arm(name="on its axis", joints=({**joint, "encoder": {"zero": 1e-3}},))
    found = lostmotion.target(arm, error="1 µm", poses=np.zeros((1, 1)), robots=30, visits=2)
    assert found.current.value == 0
    assert found.equal_factor is None
    assert found.yields[0].share == 1
    assert "is met" in found.sheet.verdict
    assert "No single item" not in found.sheet.verdict
    assert [plot.key for plot in plots(found)] == ["yield"]


def test_poses_in_a_zone_are_in_it():
    """The tool is in the zone at every pose, in eight sets of one size; a zone that is out of reach
    is refused.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    zone = {"x": (0.3, 0.7), "z": (0.5, 1.0)}
    found = poses_in_zone(arm, 64, zone)
    poses, name = found.poses, found.name
    points = tool_points(arm, poses.q)
    assert len(poses) == 64
    assert poses.replicates == 8
    assert (points[:, 0].min(), points[:, 2].max()) >= (0.3, 0.0)
    assert (
        (points[:, 0] >= 0.3)
        & (points[:, 0] <= 0.7)
        & (points[:, 2] >= 0.5)
        & (points[:, 2] <= 1.0)
    ).all()
    assert "x 300 … 700 mm" in name
    with pytest.raises(lostmotion.InputError, match="none of the"):
        poses_in_zone(arm, 8, {"x": (50.0, 51.0)})


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Run the command once."""
    where = tmp_path_factory.mktemp("target")
    done = ran(ARM, "--error", "2 mm", *WORDS, "--full", cwd=where)
    assert done.returncode == 0, done.stderr
    assert "Allowance for one item at a time" in done.stdout
    assert " ".join(done.stdout.split()).count("With the sizes of equal effect it is") == 1
    return where / "z-arm-lumped-target"


def test_a_share_out_of_range_is_reported_in_per_cent_too():
    """Who asks for 60 as a share learns that it may be stated in per cent, and from where to
    where.
    """
    with pytest.raises(
        lostmotion.InputError,
        match=r"a plain number or per cent, at least 0.5 \(50 %\), at most 0.999 \(99.9 %\)",
    ):
        lostmotion.target(lostmotion.read(ARM), error="2 mm", share="60")


def test_the_command_writes_a_folder_and_leaves_it_alone(folder):
    """It writes report.html and result.json, and refuses to write them again."""
    assert sorted(path.name for path in folder.iterdir()) == ["report.html", "result.json"]
    again = ran(ARM, "--error", "2 mm", *WORDS, cwd=folder.parent)
    assert again.returncode == 2
    assert "exists" in again.stderr


@pytest.mark.slow
def test_the_same_input_gives_the_same_bytes(folder):
    """On one thread or more."""
    words = ("target", ARM, "--error", "2 mm", *WORDS, "--threads", 1, "--out", "again")
    done = carried_out_by_process(*words, cwd=folder.parent)
    assert done.returncode == 0, done.stderr
    for name in ("report.html", "result.json"):
        assert (folder.parent / "again" / name).read_bytes() == (folder / name).read_bytes()


@pytest.mark.parametrize(
    ("wanted", "keys"),
    [
        ({}, ["error, rp_iso, rp_any"]),
        ({"error": "0.5"}, ["error"]),
        ({"error": "-0.5 mm"}, ["error"]),
        ({"error": "0 mm"}, ["error"]),
        ({"error": "0.5 mm ± 0.1 mm"}, ["error"]),
        ({"error": "3 arcmin"}, ["error"]),
        ({"error": "1e400 mm"}, ["error"]),
        ({"error": math.nan}, ["error"]),
        ({"repeatability": "500 m"}, ["repeatability"]),
        ({"error": "0.5 mm", "repeatability": "0.1 mm"}, ["error, rp_iso, rp_any"]),
        ({"error": "0.5", "rp_iso": "0.1 kg"}, ["error, rp_iso, rp_any", "error", "rp_iso"]),
        ({"rp_iso": "0.5 mm", "rp_any": "0.5 mm"}, ["error, rp_iso, rp_any"]),
        ({"repeatability": "0.5 mm"}, ["repeatability"]),
        ({"rp_any": "0.5 mm", "approach": "up"}, ["approach"]),
        ({"error": "0.5 mm", "share": 2.0}, ["share"]),
        ({"error": "0.5 mm", "robots": 5}, ["robots"]),
        ({"error": "0.5 mm", "visits": 1}, ["visits"]),
        ({"error": "0.5 mm", "threads": -1}, ["threads"]),
        ({"error": "0.5 mm", "approach": "left"}, ["approach"]),
        ({"error": "0.5 mm", "seed": -1}, ["seed"]),
        ({"error": "0.5 mm", "poses": 100_000}, ["poses"]),
        ({"error": "0.5 mm", "zone": {"x": (0.5, 0.2)}}, ["zone"]),
        ({"error": "0.5 mm", "zone": {"x": (0.2, 0.5)}, "poses": np.zeros((3, 4))}, ["zone"]),
    ],
)
def test_what_cannot_be_asked_is_refused(wanted, keys):
    """One clear message with every mistake, under its key, with an example where there is one."""
    with pytest.raises(lostmotion.InputError) as caught:
        lostmotion.target(lostmotion.read(ARM), **wanted)
    assert [problem.key for problem in caught.value.problems] == keys


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--error", "0.5", "--rp-any", "0.1 mm"], "--error, --rp-iso, --rp-any"),
        (["--error", "1 mm", "--zone", "w 0..1 m"], "--zone"),
    ],
)
def test_the_command_refuses_with_code_2_and_writes_nothing(tmp_path, words, said):
    """A mistake is a message on standard error, and no folder."""
    done = ran(ARM, *words, cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())
