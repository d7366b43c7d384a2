"""The kernel for robots that err once at a pose, against the one for many visits and against plain NumPy."""

import os
import subprocess
import sys

import numpy as np
import pytest

from lostmotion import Poses, sample_poses, screws
from lostmotion.error_model.error_bins import BINS, bin_edges
from lostmotion.error_model.intervals import quantile, student
from lostmotion.parts.base import Base
from lostmotion.parts.lumped import Lumped
from lostmotion.propagation.exact import draws_of
from lostmotion.propagation.montecarlo import kernel, montecarlo, single_visit_kernel
from lostmotion.propagation.montecarlo.blocks import Plan, sample_block
from lostmotion.propagation.montecarlo.montecarlo import run
from lostmotion.units import Toleranced
from tests.conftest import arm_of

ROBOTS = 300  # two tiles and a part of one
BARE = {"gearbox": None, "bearing": None, "encoder": None, "mounting": None, "link": {"length": "400 mm", "mass": "3 kg"}}
LUMPED = {"angle": "3 arcmin", "offset": "30 µm"}


@pytest.fixture(scope="module", params=["robot", "visit", "every part"])
def some_arm(request, arm):
    """Return an arm whose errors are drawn per robot, per visit, or in every way there is."""
    if request.param == "every part":
        return arm
    return arm_of(3, **BARE, lumped={**LUMPED, "varies": request.param})


def lengths(arm, poses, robots, seed):
    """Form the errors of robots that come once, one by one: (pose, robot) m."""
    matrix = screws(arm, poses.q)
    every, once = np.arange(robots), np.zeros(robots, int)
    return matrix, np.array([np.linalg.norm(matrix.tool[p, 3:] @ draws_of(matrix, p, seed, p, every, once), axis=0) for p in range(len(poses))])


def test_both_kernels_agree_on_robots_that_come_once(some_arm, monkeypatch):
    """The kernel that keeps directions and the one that does not give the same counts, and the same figures but for the order of sums."""
    poses = sample_poses(some_arm, 40)
    matrix = screws(some_arm, poses.q)
    plan = Plan.of(some_arm, poses, ROBOTS, 1, 7, 0.0)
    once = sample_block(plan, matrix, 3)
    monkeypatch.setattr(single_visit_kernel, "run_once", kernel.run_block)
    many = sample_block(plan, matrix, 3)
    np.testing.assert_array_equal(once.whole_hist(), many.whole_hist())
    np.testing.assert_array_equal(once.robot_sums, many.robot_sums)
    np.testing.assert_allclose(once.per_pose, many.per_pose, rtol=1e-12)


def test_quantiles_next_to_the_smallest_error_are_those_of_the_samples():
    """An arm sags by far more than it scatters to the side: most errors lie in the lowest 3 % of their span, and with them the median's lower end."""
    drooping = arm_of(2, **{**BARE, "gearbox": {"stiffness": "0.5 N m/arcmin"}})
    first = drooping.joints[0].model_copy(update={"lumped": Lumped(angle=1e-3, varies="robot")})
    drooping = drooping.model_copy(update={"joints": (first, *drooping.joints[1:])})
    poses, robots = Poses(np.array([[0.0, 0.0], [0.3, 0.1]]), "given"), 40
    matrix, size = lengths(drooping, poses, robots, 7)
    sample = sample_block(Plan.of(drooping, poses, robots, 1, 7, 0.0), matrix, 0)
    low, span = sample.per_pose[:, kernel.FIRST_QUANTILE + 1], np.ptp(size, axis=1)
    half = student(robots - 1) * np.sqrt(0.25 / (robots - 1))
    exact = np.quantile(size, 0.5 - half, axis=1, method="inverted_cdf")
    assert (exact < size.min(axis=1) + 0.03 * span).all()
    assert (np.abs(low - exact) <= 1.001 * span / kernel.FINE).all()


def test_the_kernel_forms_the_same_errors_as_a_plain_matrix_product(some_arm):
    """Mean, mean square, the largest error and whose it is, each robot's mean and all counts are those of screws @ draws."""
    poses = sample_poses(some_arm, 40)
    matrix, size = lengths(some_arm, poses, ROBOTS, 7)
    sample = sample_block(Plan.of(some_arm, poses, ROBOTS, 1, 7, 0.0), matrix, 0)
    np.testing.assert_allclose(sample.per_pose[:, kernel.MEAN], size.mean(axis=1), rtol=1e-12)
    np.testing.assert_allclose(sample.per_pose[:, kernel.MEAN_SQUARE], (size**2).mean(axis=1), rtol=1e-12)
    np.testing.assert_allclose(sample.per_pose[:, kernel.LARGEST], size.max(axis=1), rtol=1e-12)
    np.testing.assert_array_equal(sample.per_pose[:, kernel.LARGEST_ROBOT], size.argmax(axis=1))
    np.testing.assert_allclose(sample.robot_sums, size.sum(axis=0), rtol=1e-12)
    assert sample.whole_hist().sum() == size.size
    counted = np.histogram(size, bin_edges())[0]
    assert np.abs(sample.whole_hist().sum(axis=0) - counted).sum() <= 4  # within rounding of an edge a sample may fall to either side


def test_a_pose_s_quantiles_are_within_a_bin_of_the_samples(some_arm):
    """Its bins are a 1024th of the span from its smallest to its largest error: the sample of that rank is never farther away."""
    poses = sample_poses(some_arm, 40)
    matrix, size = lengths(some_arm, poses, ROBOTS, 7)
    sample = sample_block(Plan.of(some_arm, poses, ROBOTS, 1, 7, 0.0), matrix, 0)
    span = size.max(axis=1) - size.min(axis=1)
    for k, level in enumerate(kernel.QUANTILES):
        exact = np.quantile(size, level, axis=1, method="inverted_cdf")
        assert (np.abs(sample.per_pose[:, kernel.FIRST_QUANTILE + 3 * k] - exact) <= 1.001 * span / kernel.FINE).all()


@pytest.mark.parametrize("level", [0.001, 0.05, 0.5, 0.95, 0.99, 0.9999])
def test_quantiles_of_all_samples_are_within_the_stated_error(some_arm, level):
    """A bin of the histogram of all samples is a 128th to a 256th wide in square: read from it, no quantile is 0.4 % off the sample of its rank."""
    poses = sample_poses(some_arm, 40)
    matrix, size = lengths(some_arm, poses, ROBOTS, 7)
    sample = sample_block(Plan.of(some_arm, poses, ROBOTS, 1, 7, 0.0), matrix, 0)
    widest = np.max(bin_edges()[1:] / bin_edges()[:-1]) - 1
    assert widest < 0.004
    exact = np.quantile(size, level, method="inverted_cdf")
    assert quantile(sample.whole_hist().sum(axis=0), level) == pytest.approx(exact, rel=widest)


def test_where_nothing_changes_from_visit_to_visit_thirty_are_as_good_as_one():
    """Every count is thirty times as large, every figure the same; AP is the robot's error itself, and RP is nothing."""
    steady = arm_of(3, **BARE, lumped={**LUMPED, "varies": "robot"})
    poses = sample_poses(steady, 16)
    matrix, size = lengths(steady, poses, ROBOTS, 7)
    one = sample_block(Plan.of(steady, poses, ROBOTS, 1, 7, 0.0), matrix, 0)
    thirty = sample_block(Plan.of(steady, poses, ROBOTS, 30, 7, 0.0), matrix, 0)
    np.testing.assert_array_equal(thirty.whole_hist(), 30 * one.whole_hist())
    np.testing.assert_array_equal(thirty.per_pose, one.per_pose)
    np.testing.assert_allclose(thirty.ap_rp[:, 0], size, rtol=1e-12)
    assert (thirty.ap_rp[:, 1] == 0).all()


def test_the_same_seed_gives_the_same_bits_on_any_threads_and_tiling(some_arm):
    """One thread or two, one block at a time or three: not one bit differs."""
    poses = sample_poses(some_arm, 4000, "uniform")
    first = run(some_arm, poses, 70, 1, 5)
    again = run(some_arm, poses, 70, 1, 5, threads=2, tile=3)
    for name in ("per_pose", "robot_means", "group_hist", "replicate_hist"):
        np.testing.assert_array_equal(getattr(again, name), getattr(first, name), err_msg=name)


def test_blocks_of_another_size_change_no_bit_of_a_pose(some_arm, monkeypatch):
    """A pose is reduced by itself: poses taken sixteen or three at a time, in one block or in seven, give the same bits."""
    poses = sample_poses(some_arm, 56, "uniform")
    whole = run(some_arm, poses, 70, 1, 5)
    monkeypatch.setattr(montecarlo, "BLOCK", 3)
    cut = run(some_arm, poses, 70, 1, 5)
    np.testing.assert_array_equal(cut.per_pose, whole.per_pose)
    np.testing.assert_array_equal(cut.group_hist, whole.group_hist)


@pytest.mark.parametrize("visits", [1, 3])
def test_an_arm_that_only_deflects_errs_by_the_length_of_its_deflection(visits):
    """Drives of stated stiffness and a leaning base: every robot errs by the same vector in space at every visit, and its length is the error."""
    elastic = arm_of(3, **{**BARE, "gearbox": {"stiffness": "5 N m/arcmin"}})
    leaning = elastic.model_copy(update={"base": Base(roll=Toleranced(0.3), pitch=Toleranced(-0.2))})
    poses = sample_poses(leaning, 24)
    deflection = screws(leaning, poses.q).bias[:, 3:]
    assert (np.abs(deflection).max(axis=0) > 1e-5).all()
    found = run(leaning, poses, 20, visits, 1).per_pose
    np.testing.assert_allclose(found[:, kernel.MEAN], np.linalg.norm(deflection, axis=1), rtol=1e-12)
    np.testing.assert_allclose(found[:, kernel.LARGEST], found[:, kernel.MEAN], rtol=1e-12)


def test_an_arm_of_one_robot_and_no_error_errs_by_nothing():
    """Without a single term every error is zero, and lies in the first bin."""
    perfect = arm_of(2, **BARE)
    found = run(perfect, Poses(np.array([[0.0, 0.3]]), "given"), 1, 1, 1)
    assert found.per_pose[0, [kernel.MEAN, kernel.LARGEST]].tolist() == [0.0, 0.0]
    assert found.group_hist[0, 0] == 1


@pytest.mark.parametrize("visits", [1, 3])
@pytest.mark.parametrize(("factor", "at"), [(1e-12, 0), (1e12, BINS - 1)])
def test_errors_beyond_the_bins_count_in_the_first_and_the_last(arm, visits, factor, at):
    """Errors of a few femtometres lie in the first bin, errors of millions of kilometres in the last: none is lost, and none counted elsewhere."""
    poses = sample_poses(arm, 4)
    sample = sample_block(Plan.of(arm, poses, ROBOTS, visits, 7, 0.0), screws(arm, poses.q).scaled(factor), 0)
    counts = sample.whole_hist().sum(axis=0)
    assert counts[at] == counts.sum() == len(poses) * ROBOTS * visits


_BITS = """
import hashlib
import numpy as np
from lostmotion.error_model import draw_kernel, error_bins
from lostmotion.propagation.montecarlo import kernel, single_visit_kernel
for visits, form in ((1, single_visit_kernel.run_once), (3, kernel.run_block)):
    rng = np.random.default_rng(3)
    poses, robots, groups = 5, 150, 4
    keys = np.arange(9).astype(np.uint64)
    shift, bias = rng.standard_normal((3, 14, poses)), rng.standard_normal((poses, 3))
    drawn, factors = rng.standard_normal((2, 8, draw_kernel.LANES)), rng.standard_normal((2, 2, draw_kernel.LANES))
    tables = np.resize(rng.standard_normal(draw_kernel.TABLE), draw_kernel.ROW)
    out = (np.zeros((poses, kernel.COLUMNS)), np.zeros((poses, 2, robots)), np.zeros(robots), np.zeros((groups, error_bins.ROW_OF_BINS), np.int64))
    none = np.zeros(4, np.int64)
    # One term that all robots have, and one that is there where a play is closed, in a third of the robots.
    plays, frictions = np.tile([[1.0, 1.0, 1.0], [1 / 3, 1.0, 0.0]], (poses, 1, 1)), rng.random((2, 2, draw_kernel.LANES))
    steady, visiting, products = np.arange(8), 8 + np.arange(4), 12 + np.arange(2)
    drawn_products = (products, none[:2], keys[4:6], factors, frictions)
    form(0, bias, shift, plays, steady, drawn, visiting, none, keys[:4], *drawn_products, tables, robots, visits, groups, 2.0, *out)
    print(hashlib.sha256(b"".join(x.tobytes() for x in out)).hexdigest())
"""


@pytest.mark.slow
def test_a_processor_without_fused_multiply_add_gives_the_same_bits(tmp_path):
    """Compiled for the plainest processor of its family, both kernels give bit for bit what they give here."""
    plain = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    here, there = (
        subprocess.run([sys.executable, "-c", _BITS], check=True, capture_output=True, text=True, env=env).stdout for env in (os.environ, plain)
    )
    assert here == there
    assert len(here.split()) == 2
