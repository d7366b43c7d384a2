"""A zone's own errors: the workspace's where the zone holds it, brute force where it does not, and
honest where few poses are in it.
"""

import dataclasses
import math

import numpy as np
import pytest

import lostmotion
from lostmotion.accuracy.route import Route
from lostmotion.analyses.accuracy.page.zone import stopped_in
from lostmotion.error_model import pose_selection
from lostmotion.error_model.intervals import pooled_quantile
from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.error_model.pose_selection import among, in_zone, poses_in_zone
from lostmotion.error_model.poses import Poses, sample_poses
from lostmotion.error_model.robot_intervals import pooled_mean
from lostmotion.errors import InputError
from lostmotion.laws.iso9283 import pose_accuracy, pose_repeatability
from lostmotion.mechanism.state import tool_points
from lostmotion.propagation.exact import draws_of
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.montecarlo import Sampled, run
from lostmotion.propagation.montecarlo.stopping import Tolerance
from tests.arms import arm_of
from tests.reporting.first_screen import first_screen

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "a study's zone",
        (
            "the whole workspace, bit for bit, if the zone contains it; errors recomputed "
            "with NumPy; both methods in the zone; intervals "
            "against a long run"
        ),
        "exact; 1e-9, percentiles 0.3 %; within intervals; 93 to 96 % of 300",
    ),
)

EVERYWHERE = {"x": (-9.0, 9.0), "z": (-9.0, 9.0)}
CORNER = {"x": (0.7, 1.0), "y": (0.1, 0.4), "z": (0.2, 0.4)}
ROBOTS, VISITS = 24, 3


def route(method="montecarlo", **more):
    """Return a route with few robots."""
    return Route(
        **{"method": method, "robots": ROBOTS, "visits": VISITS, "seed": 1, "most_robots": 100}
        | more
    )


def assert_same_bits(one, other):
    """Compare every array and figure of two results."""
    for field in dataclasses.fields(one):
        a, b = getattr(one, field.name), getattr(other, field.name)
        if isinstance(a, np.ndarray):
            np.testing.assert_array_equal(a, b, err_msg=field.name)
        elif dataclasses.is_dataclass(a):
            assert_same_bits(a, b)
        elif field.name != "parts":
            assert a == b, field.name


@pytest.mark.parametrize("law", ["sobol", "normal"])
def test_a_zone_that_holds_the_workspace_has_its_figures(arm, law):
    """Bit for bit, by samples and without: its poses are those of the workspace."""
    whole = sample_poses(arm, 48, law, seed=3)
    zone = poses_in_zone(arm, len(whole), EVERYWHERE, 3, law)
    assert zone.tried == len(whole)
    assert (zone.poses.law, zone.poses.replicates) == (law, 8)
    over, within = route("both", seed=3).over(arm, whole), route("both", seed=3).within(arm, zone)
    for name in ("sampled", "analytic", "pooled"):
        assert_same_bits(getattr(over, name), getattr(within, name))


def test_a_zone_of_given_and_of_gridded_poses_is_those_in_it(arm):
    """They are taken as they are, in one set; a mask says the same as the ends."""
    for poses in (sample_poses(arm, 125, "grid"), Poses(sample_poses(arm, 64).q, "given")):
        tool = tool_points(arm, poses.q)
        inside = among(poses, tool, {"z": (0.0, 0.5)})
        mask, _ = in_zone(tool, {"z": (0.0, 0.5)})
        assert inside.poses.replicates == 1
        assert inside.poses.law == poses.law
        np.testing.assert_array_equal(inside.poses.q, poses.q[mask])
        np.testing.assert_array_equal(among(poses, tool, mask).poses.q, poses.q[mask])


@pytest.fixture(scope="module")
def corner(arm):
    """Look at a corner of the workspace."""
    return route().within(arm, poses_in_zone(arm, 64, CORNER))


def test_the_figures_of_a_zone_are_those_of_its_stored_errors(arm, corner):
    """Every error computed again with NumPy, from the same robots: mean, quantiles, largest, AP and
    RP.
    """
    assert len(corner.poses) == 64
    assert in_zone(tool_points(arm, corner.poses.q), CORNER)[0].all()
    matrix = pose_matrix(arm, corner.poses.q)
    robots, visits = (
        axis.ravel() for axis in np.meshgrid(np.arange(ROBOTS), np.arange(VISITS), indexing="ij")
    )
    errors = np.array(
        [(matrix.tool[k, 3:] @ draws_of(matrix, k, 1, k, robots, visits)).T for k in range(64)]
    )
    sizes = np.linalg.norm(errors, axis=-1)
    found = corner.sampled
    assert pooled_mean(found.robot_means[:, :, 0]).value == pytest.approx(sizes.mean(), rel=1e-9)
    assert found.per_pose[:, kernel.LARGEST].max() == pytest.approx(sizes.max(), rel=1e-9)
    for level in kernel.QUANTILES:
        assert pooled_quantile(
            found.group_hist, found.replicate_hist, level
        ).value == pytest.approx(np.quantile(sizes, level), rel=3e-3)
    of_robots = errors.reshape(64, ROBOTS, VISITS, 3)
    for column, values in (
        (1, pose_accuracy(of_robots, np.zeros(3))),
        (2, pose_repeatability(of_robots)),
    ):
        np.testing.assert_allclose(
            found.robot_means[:, :, column].mean(axis=0), values.mean(axis=0), rtol=1e-9
        )


def test_the_same_bits_on_any_threads_and_tiling(arm, corner, monkeypatch):
    """The zone's run is cut as the workspace's is."""
    monkeypatch.setattr("lostmotion.propagation.montecarlo.montecarlo.BLOCK", 5)
    zone = poses_in_zone(arm, 64, CORNER)
    one, other = (
        route(threads=threads, tile=tile).within(arm, zone) for threads, tile in ((1, 1), (2, 3))
    )
    assert_same_bits(one.sampled, other.sampled)
    assert one.budget == other.budget == corner.budget


def test_the_budget_of_a_zone_is_its_mean_square(corner):
    """By the same poses: what the samples find, the exact sum over terms says."""
    assert corner.budget.rms**2 == pytest.approx(
        corner.sampled.tally.total / corner.sampled.tally.poses, rel=1e-12
    )
    assert corner.budget.poses == len(corner.poses)


@pytest.mark.slow
def test_both_routes_agree_in_a_zone(arm):
    """The mean and the quantiles without sampling lie within the intervals by samples, and differ
    from them by less than both uncertainties.
    """
    found = route("both", robots=600).within(arm, poses_in_zone(arm, 256, CORNER))
    pairs = [(found.pooled.mean, pooled_mean(found.sampled.robot_means[:, :, 0]))]
    for level, exact in zip(found.pooled.levels, found.pooled.quantiles, strict=True):
        if level in kernel.QUANTILES:
            pairs.append(
                (
                    exact,
                    pooled_quantile(found.sampled.group_hist, found.sampled.replicate_hist, level),
                )
            )
    assert len(pairs) == 4
    for exact, sampled in pairs:
        assert sampled.low <= exact.value <= sampled.high
        assert (
            abs(exact.value - sampled.value)
            <= math.hypot(exact.high - exact.low, sampled.high - sampled.low) / 2
        )


def test_few_poses_in_a_zone_are_all_kept_in_equal_sets(arm, monkeypatch):
    """Of the poses examined, all that are in the zone, up to a multiple of eight; one alone, or
    none, is refused.
    """
    monkeypatch.setattr(pose_selection, "MOST_TRIED", 4096)
    looked_at = sample_poses(arm, 4096)
    inside = in_zone(tool_points(arm, looked_at.q), CORNER)[0].sum()
    assert 8 <= inside < 32
    zone = poses_in_zone(arm, 64, CORNER)
    assert zone.tried == 4096
    assert zone.poses.replicates == 8
    assert len(zone.poses) == inside // 8 * 8
    assert len(poses_in_zone(arm, 8, CORNER).poses) == 8
    monkeypatch.setattr(pose_selection, "MOST_TRIED", 512)
    with pytest.raises(
        lostmotion.InputError,
        match=r"y 100 … 400 mm, z 200 … 400 mm: (none|only 1) of the 512 poses .*\n.*the tool reaches x",
    ):
        poses_in_zone(arm, 64, CORNER)


@pytest.mark.slow
def test_intervals_in_a_small_zone_hold_the_truth(arm, monkeypatch):
    """About ten poses in it, in eight sets: the intervals of mean and 95 % hold what 800 poses and
    2 000 robots say, about as often as they say.
    """
    many = sample_poses(arm, 1 << 18, seed=10**6)
    inside = in_zone(tool_points(arm, many.q), CORNER)[0]
    whole = run(arm, Poses(many.q[inside], "given"), 2000, 1, 10**6, compared=0)
    truth = estimates(whole)
    monkeypatch.setattr(pose_selection, "MOST_TRIED", 4096)
    held = np.zeros(2)
    for seed in range(80):
        found = run(arm, poses_in_zone(arm, 512, CORNER, seed).poses, 60, 1, seed, compared=0)
        held += [
            estimate.low <= true.value <= estimate.high
            for estimate, true in zip(estimates(found), truth, strict=True)
        ]
    assert (held >= 0.87 * 80).all()  # binomial: 95 % of 80 is below that once in a thousand


def estimates(found: Sampled):
    """Return mean and 95 % of all errors."""
    return pooled_mean(found.robot_means[:, :, 0]), pooled_quantile(
        found.group_hist, found.replicate_hist, 0.95
    )


def test_a_zone_stops_by_its_own_figures(arm, monkeypatch):
    """Where more poses can be drawn in it, they are; where there are no more, it says that poses
    are wanting.
    """
    zone = poses_in_zone(arm, 16, CORNER)
    asked = route(tolerance=Tolerance(0.02), robots=100, most_robots=4000)
    found = asked.within(arm, zone, lambda count: poses_in_zone(arm, count, CORNER).poses, 512)
    last = found.stopping.stages[-1]
    assert found.stopping.reached
    assert len(found.poses) == last.poses > 16
    assert last.figures["p95"].relative <= 0.02
    assert found.budget.poses == last.poses
    monkeypatch.setattr(pose_selection, "MOST_TRIED", 4096)
    few = poses_in_zone(arm, 512, CORNER)
    short = route(tolerance=Tolerance(0.01), most_robots=4000).within(
        arm, few, lambda count: poses_in_zone(arm, count, CORNER).poses, len(few.poses)
    )
    assert not short.stopping.reached
    assert short.stopping.limited_by == "poses"
    assert len(short.poses) == len(few.poses)
    (sentence,) = stopped_in([short])
    assert sentence.endswith(f"and no more than {len(few.poses)} were found")


@pytest.fixture(scope="module")
def study(arm):
    """Ask about a zone named by text and one by which poses are in it."""
    mask = tool_points(arm, sample_poses(arm, 32).q)[:, 2] > 0
    return lostmotion.study(arm, 32, 40, 3, method="both", zone=["z 0..2000 mm", mask], threads=1)


def test_a_study_says_what_was_found_in_its_zones(study):
    """Screen, result and arrays hold the zone's figures beside the workspace's."""
    by_ends, by_mask = study.zones
    assert (by_ends.name, by_mask.name) == ("z 0 … 2000 mm", "the zone asked for")
    assert len(by_ends.poses) == 32
    assert len(by_mask.poses) < 32
    assert by_mask.tried == 32
    sections = {section.key: section for section in study.sheet.sections}
    suffixes = ("", "_iso9283", "_analytic", "_routes_all", "_routes")
    assert {f"zone_{k}{suffix}" for k in (1, 2) for suffix in suffixes} <= set(sections)
    assert {"budget_at_1", "budget_at_2"} <= set(sections)
    rows = {row.label: row for row in sections["zone_1"].rows}
    assert [figure.value for figure in rows["poses"].cells] == [32, 32]
    whole = {row.label: row.cells[0] for row in sections["error"].rows}
    for label, row in rows.items():
        if label != "poses":
            assert row.cells[1].value == whole[label].value
    inside = pooled_quantile(by_ends.sampled.group_hist, by_ends.sampled.replicate_hist, 0.95)
    figure = rows["95th percentile"].cells[0]
    assert (figure.value, figure.low, figure.high) == pytest.approx(
        [inside.value, inside.low, inside.high]
    )
    assert f"In the zone z 0 … 2000 mm expect 95 % within {figure}" in first_screen(study.sheet)
    assert study.result()["zones"][1]["looked_at"] == 32
    arrays = study.arrays()
    assert arrays["zone_2_error_mean"].shape == (len(by_mask.poses),)
    assert (arrays["zone_1_tool"][:, 2] > 0).all()
    iso, either = by_ends.repeats
    np.testing.assert_allclose(arrays["zone_1_robot_rp_iso"], iso.robot_means.mean(axis=0))
    np.testing.assert_allclose(arrays["zone_1_robot_rp_any"], either.robot_means.mean(axis=0))
    np.testing.assert_allclose(
        arrays["zone_1_robot_rp_any"], by_ends.sampled.robot_means[:, :, 2].mean(axis=0)
    )


def test_a_study_without_sampling_says_it_too(arm, study):
    """The same figures as with both methods, and the error budget in the zone."""
    alone = lostmotion.study(arm, 32, method="analytic", zone={"z": (0, 2)})
    both = {section.key: section for section in study.sheet.sections}
    sections = {section.key: section for section in alone.sheet.sections}
    assert list(sections) == [
        "analytic",
        "zone_1_analytic",
        "levels",
        "remedies",
        "budget_levels",
        "causes_levels",
        "halving",
        "budget_at_1",
        "causes_at_1",
        "halving_at_1",
        "states",
        "inputs",
        "laws",
    ]
    for key in ("zone_1_analytic", "budget_at_1"):
        assert repr(sections[key].rows) == repr(both[key].rows)  # as text: no number is not itself


def test_a_zone_has_one_name_in_every_command(study):
    """By the command line's text, or by its ends, in m or with their unit."""
    text, ends = "z 0..500 mm, x -1..1 m", {"z": (0.0, 0.5), "x": (-1, 1)}
    assert (
        study.costs(zone=text)
        == study.costs(zone=ends)
        == study.costs(zone={"z": (0, "500 mm"), "x": ("-1 m", 1.0)})
    )
    assert study.with_budget(zone=text).budgets == study.with_budget(zone=ends).budgets
    joint = {
        "name": "A",
        "type": "revolute",
        "limits": (-1.0, 1.0),
        "link": {"length": 0.5},
        "lumped": {"angle": 1e-3},
    }
    plain = lostmotion.Arm(name="plain", joints=(joint,))
    one, other = (
        lostmotion.target(plain, error="1 mm", poses=16, zone=zone, robots=30, visits=2)
        for zone in ("x 0.3..1 m", {"x": (0.3, 1.0)})
    )
    assert one.zone == other.zone == "x 300 … 1000 mm"
    np.testing.assert_array_equal(one.poses.q, other.poses.q)


@pytest.mark.parametrize(
    ("zone", "named"),
    [
        ("x 1..2", r"lower one first(.|\n)*example   zone = "),
        ("x 3..4 m", "none of the 524288 poses is in it"),
        ({"x": 3}, "x: 3"),
        ({"x": ("0.2", 0.5)}, "unit"),
        ({"x": (0.2, "far")}, "zone"),
        ({"w": (0, 1), "x": (1, 0)}, "2 mistakes"),
        ({}, "no limits"),
        (3, "or limits along the base's axes in m"),
    ],
)
def test_what_is_no_zone_is_refused_with_the_same_message(zone, named):
    """By a study and by a target, with one message that says how a zone is named."""
    arm = arm_of(2)
    with pytest.raises(lostmotion.InputError, match=named):
        lostmotion.study(arm, 8, 20, 2, zone=zone)
    with pytest.raises(lostmotion.InputError, match=named):
        lostmotion.target(arm, error="1 mm", poses=8, zone=zone)


def test_a_zone_too_small_to_be_met_is_distinguished_from_one_out_of_reach(arm):
    """A cube of a tenth of a millimetre within reach is too small to contain a sampled pose; one
    five metres away is out of reach.
    """
    middle = tool_points(arm, sample_poses(arm, 1, "uniform").q)[0]
    small = {
        axis: (float(x) + 3e-5, float(x) + 1.3e-4) for axis, x in zip("xyz", middle, strict=True)
    }
    with pytest.raises(InputError, match="too small to contain a sampled pose"):
        poses_in_zone(arm, 8, small)
    with pytest.raises(InputError) as far:
        poses_in_zone(arm, 8, {"x": (5.0, 6.0)})
    assert "by chance" not in str(far.value)
