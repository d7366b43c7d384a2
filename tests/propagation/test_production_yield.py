"""Yield: the exact interval against the binomial law and synthetic productions, and figures of
single robots against brute force.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import binom

import lostmotion
from lostmotion.error_model.closing import standardised
from lostmotion.error_model.draws import robot_draws, uniforms, visit_draws
from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.error_model.poses import sample_poses
from lostmotion.error_model.share_intervals import share_interval
from lostmotion.errors import InputError
from lostmotion.io import read
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.blocks import BlockPlan
from lostmotion.propagation.montecarlo.montecarlo import run
from lostmotion.propagation.production_yield import (
    compute_yield,
    computed_blocks,
    robot_figures,
    robots_needed,
)

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "yield",
        "the binomial law and 1 000 synthetic productions; all errors of 40 robots",
        "covers at least 95 %; 1e-6",
        "propagation/production_yield.py",
    ),
)

EXAMPLES = Path(__file__).parents[2] / "examples"


def coverage(share, count, confidence=0.95):
    """Return which numbers of hits (hits,) have an exact interval that holds the true share, and
    how probable these are together; numbers that never occur, 1e-13 in all, count as not held.
    """
    hits = np.arange(count + 1)
    probable = binom.pmf(hits, count, share)
    holds = np.zeros(count + 1, bool)
    for k in np.flatnonzero(probable > 1e-16):
        low, high = share_interval(int(k), count, confidence, "exact")
        holds[k] = low <= share <= high
    return holds, float(probable @ holds)


@pytest.mark.parametrize("count", [10, 300])
@pytest.mark.parametrize("share", [0.02, 0.5, 0.9, 0.997])
def test_the_interval_covers_whatever_the_share(count, share):
    """Summed over the binomial law, the 95 % interval holds the true share in at least 95 % of
    productions: never fewer.
    """
    assert coverage(share, count)[1] >= 0.95


def test_a_nominal_90_percent_covers_87_to_93():
    """Over 1 000 synthetic productions the nominal 90 % interval covers in 87 to 93 %, and as often
    as the binomial law says.
    """
    rng = np.random.default_rng(11)
    share, count = 0.9, 2000
    holds, exact = coverage(share, count, 0.90)
    seen = holds[rng.binomial(count, share, 1000)].mean()
    assert 0.90 <= exact < 0.93
    assert 0.87 <= seen <= 0.93
    assert abs(seen - exact) < 4 * math.sqrt(exact * (1 - exact) / 1000)


def test_the_interval_by_its_definition():
    """At each end, what was seen or more of it has half of what the confidence leaves; none and all
    of the robots have closed forms.
    """
    low, high = share_interval(37, 50, method="exact")
    assert binom.sf(36, 50, low) == pytest.approx(0.025, rel=1e-9)
    assert binom.cdf(37, 50, high) == pytest.approx(0.025, rel=1e-9)
    assert share_interval(0, 30, method="exact") == pytest.approx((0.0, 1 - 0.025 ** (1 / 30)))
    assert share_interval(30, 30, method="exact") == pytest.approx((0.025 ** (1 / 30), 1.0))
    for hits, count in ((-1, 3), (4, 3), (0, 0)):
        with pytest.raises(ValueError, match=r"[kn]"):
            share_interval(hits, count, method="exact")


def test_so_many_robots_are_needed():
    """The interval of that many is narrow enough, of fewer it is not."""
    for share, width in ((0.9, 0.02), (0.5, 0.05), (1.0, 0.01)):
        count = robots_needed(share, width)
        low, high = share_interval(round(share * count), count, method="exact")
        assert high - low <= width
        low, high = share_interval(
            round(share * 0.95 * count / 0.95) - round(share * 0.05 * count),
            count - round(0.05 * count),
            method="exact",
        )
        assert high - low > width
    with pytest.raises(ValueError, match="width"):
        robots_needed(0.9, 0.0)


@pytest.fixture(scope="module")
def built():
    """Build a few robots of the paper's arm at a few poses, and all of their errors one by one
    besides (pose, robot, visit, 3).
    """
    arm = read(EXAMPLES / "z-arm.toml")
    poses = sample_poses(arm, 16)
    plan = BlockPlan.of(arm, poses, 40, 6, 3, 0.0)
    matrix = pose_matrix(arm, poses.q)
    errors = np.empty((16, 40, 6, 3))
    robots, visits = (
        each.ravel() for each in np.meshgrid(np.arange(40), np.arange(6), indexing="ij")
    )
    for pose in range(16):
        total = np.tile(matrix.bias[pose, 3:], (len(robots), 1))
        for k, info in enumerate(matrix.infos):
            if info.level != "design":
                drawn = np.ones(len(robots))
                if info.robot is not None:
                    drawn = drawn * robot_draws(3, [info.robot], 40)[:, 0].ravel()[robots]
                if info.visit is not None:
                    drawn = drawn * visit_draws(3, [info.visit], pose, robots, visits)[0]
                if info.closing is not None:
                    drawn = drawn * standardised(
                        uniforms(3, info.closing.stream.name, 40)[robots],
                        matrix.closed[info.closing.row, pose],
                    )
                total += drawn[:, None] * matrix.tool[pose, 3:, k]
        errors[pose] = total.reshape(40, 6, 3)
    return plan, errors


def test_each_robot_is_judged_by_itself(built):
    """Per-robot 95 % error, worst AP, mean and worst RP equal those of every single error, written
    out.
    """
    plan, errors = built
    found = robot_figures(plan, computed_blocks(plan), 0.95)
    sizes = np.linalg.norm(errors, axis=3).transpose(1, 0, 2).reshape(40, -1)
    # A histogram's bins are 0.3 % wide; between two samples any value is the quantile.
    ordered = np.sort(sizes, axis=1)
    rank = math.ceil(0.95 * sizes.shape[1])
    assert (found.error > ordered[:, rank - 2] * 0.997).all()
    assert (found.error < ordered[:, rank] * 1.003).all()
    centre = errors.mean(axis=2)
    np.testing.assert_allclose(
        found.worst_accuracy, np.linalg.norm(centre, axis=2).max(axis=0), rtol=1e-6
    )
    distance = np.linalg.norm(errors - centre[:, :, None], axis=3)
    rp = distance.mean(axis=2) + 3 * distance.std(axis=2, ddof=1)
    np.testing.assert_allclose(found.repeatability, rp.mean(axis=0), rtol=1e-6)
    np.testing.assert_allclose(found.worst_repeatability, rp.max(axis=0), rtol=1e-6)


def test_blocks_change_nothing(built):
    """Poses in one block or in many give the same figures."""
    plan, _ = built
    whole = pose_matrix(plan.arm, plan.poses.q)
    parts = [(k, whole.stretch(k, k + 5)) for k in range(0, 16, 5)]
    one, other = robot_figures(plan, [(0, whole)], 0.9), robot_figures(plan, parts, 0.9)
    for name in ("error", "worst_accuracy", "repeatability", "worst_repeatability"):
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-12)


def test_yield_rises_with_the_target_and_belongs_to_the_study():
    """Yield is monotone in the target, none below the best robot and all above the worst; robots
    are those of the study with the same seed.
    """
    arm = read(EXAMPLES / "z-arm.toml")
    poses = sample_poses(arm, 16)
    options = {"share": 0.95, "robots": 60, "visits": 5, "seed": 2}
    shares = [
        compute_yield(arm, poses, target, criterion="error", **options).share
        for target in (1e-4, 1e-3, 1.2e-3, 1.3e-3, 5e-3)
    ]
    assert shares == sorted(shares)
    assert (shares[0], shares[-1]) == (0.0, 1.0)
    found = compute_yield(arm, poses, 1.2e-3, criterion="repeatability", **options)
    study = run(arm, poses, 60, 5, 2)
    np.testing.assert_allclose(
        found.figures, np.sort(study.robot_means[:, :, 2].mean(axis=0)), rtol=1e-9
    )
    targets, share, ends = found.curve()
    assert (np.diff(share) >= 0).all()
    assert share[0] == 0
    assert share[-1] == 1
    assert ((ends[:, 0] <= share) & (share <= ends[:, 1])).all()
    assert targets[0] < found.figures[0] < found.figures[-1] < targets[-1]
    assert study.per_pose.shape[1] == kernel.COLUMNS


@pytest.mark.parametrize(
    ("options", "key"),
    [
        ({"target": 0.0}, "target"),
        ({"criterion": "speed"}, "criterion"),
        ({"share": 0.2}, "share"),
        ({"robots": 100_000}, "robots"),
        ({"visits": 1, "criterion": "repeatability"}, "visits"),
    ],
)
def test_numbers_out_of_range_are_refused(options, key):
    """Each is one clear message."""
    arm = read(EXAMPLES / "z-arm.toml")
    asked = {
        "target": 1e-3,
        "criterion": "error",
        "share": 0.95,
        "robots": 20,
        "visits": 2,
        "seed": 1,
    } | options
    with pytest.raises(InputError) as caught:
        lostmotion.production_yield(arm, asked.pop("target"), poses=8, **asked)
    assert [problem.key for problem in caught.value.problems] == [key]
