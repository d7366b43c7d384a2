"""The kernel for robots that visit each pose once, compared with the kernel for many visits and
with plain NumPy.
"""

import os
import subprocess
import sys

import numpy as np
import pytest

from lostmotion import Poses, sample_poses, screws
from lostmotion.error_model.error_bins import BINS, bin_edges
from lostmotion.error_model.intervals import quantile, student
from lostmotion.mechanism.state import state_of
from lostmotion.parts.base import Base
from lostmotion.parts.lumped import Lumped
from lostmotion.propagation.exact import draws_of
from lostmotion.propagation.montecarlo import kernel, montecarlo, single_visit_kernel
from lostmotion.propagation.montecarlo.blocks import BlockPlan, sample_block
from lostmotion.propagation.montecarlo.montecarlo import run
from lostmotion.units import Toleranced
from tests.arms import arm_of

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "Monte Carlo with one visit",
        "plain NumPy on the same draws; the kernel for several visits",
        "1e-12; one bin, 0.1 % of the span",
        "propagation/montecarlo/single_visit_kernel.py propagation/montecarlo/histogram.py",
    ),
)

ROBOTS = 300  # two full tiles and a partial one
BARE = {
    "gearbox": None,
    "bearing": None,
    "encoder": None,
    "mounting": None,
    "link": {"length": "400 mm", "mass": "3 kg"},
}
LUMPED = {"angle": "3 arcmin", "offset": "30 µm"}


@pytest.fixture(scope="module", params=["robot", "visit", "every part"])
def some_arm(request, arm):
    """Return an arm whose errors vary per robot, per visit or in every supported way."""
    if request.param == "every part":
        return arm
    return arm_of(3, **BARE, lumped={**LUMPED, "varies": request.param})


def lengths(arm, poses, robots, seed):
    """Return the pose matrix and the error magnitudes (pose, robot), m, of robots that visit each
    pose once.
    """
    matrix = screws(state_of(arm, poses.q))
    every, once = np.arange(robots), np.zeros(robots, int)
    return matrix, np.array(
        [
            np.linalg.norm(matrix.tool[p, 3:] @ draws_of(matrix, p, seed, p, every, once), axis=0)
            for p in range(len(poses))
        ]
    )


def test_both_kernels_agree_on_robots_that_visit_once(some_arm, monkeypatch):
    """For one visit both kernels return the same counts and the same figures, except for the order
    of summation.
    """
    poses = sample_poses(some_arm, 40)
    matrix = screws(state_of(some_arm, poses.q))
    plan = BlockPlan.of(some_arm, poses, ROBOTS, 1, 7, 0.0)
    once = sample_block(plan, matrix, 3)
    monkeypatch.setattr(single_visit_kernel, "run_once", kernel.run_block)
    many = sample_block(plan, matrix, 3)
    np.testing.assert_array_equal(once.whole_hist(), many.whole_hist())
    np.testing.assert_array_equal(once.robot_sums, many.robot_sums)
    np.testing.assert_allclose(once.per_pose, many.per_pose, rtol=1e-12)


def test_quantiles_next_to_the_smallest_error_are_those_of_the_samples():
    """The lower end of the median of an arm that sags more than it scatters equals that of the
    samples.

    Most of its errors lie in the lowest 3 % of their span.
    """
    drooping = arm_of(2, **{**BARE, "gearbox": {"stiffness": "0.5 N m/arcmin"}})
    first = drooping.joints[0].model_copy(update={"lumped": Lumped(angle=1e-3, varies="robot")})
    drooping = drooping.model_copy(update={"joints": (first, *drooping.joints[1:])})
    poses, robots = Poses(np.array([[0.0, 0.0], [0.3, 0.1]]), "given"), 40
    matrix, size = lengths(drooping, poses, robots, 7)
    sample = sample_block(BlockPlan.of(drooping, poses, robots, 1, 7, 0.0), matrix, 0)
    low, span = sample.per_pose[:, kernel.FIRST_QUANTILE + 1], np.ptp(size, axis=1)
    half = student(robots - 1) * np.sqrt(0.25 / (robots - 1))
    exact = np.quantile(size, 0.5 - half, axis=1, method="inverted_cdf")
    assert (exact < size.min(axis=1) + 0.03 * span).all()
    assert (np.abs(low - exact) <= 1.001 * span / kernel.FINE).all()


def test_the_kernel_computes_the_errors_of_a_plain_matrix_product(some_arm):
    """The kernel's mean, mean square, largest error and its robot, means per robot and counts equal
    those of screws @ draws.
    """
    poses = sample_poses(some_arm, 40)
    matrix, size = lengths(some_arm, poses, ROBOTS, 7)
    sample = sample_block(BlockPlan.of(some_arm, poses, ROBOTS, 1, 7, 0.0), matrix, 0)
    np.testing.assert_allclose(sample.per_pose[:, kernel.MEAN], size.mean(axis=1), rtol=1e-12)
    np.testing.assert_allclose(
        sample.per_pose[:, kernel.MEAN_SQUARE], (size**2).mean(axis=1), rtol=1e-12
    )
    np.testing.assert_allclose(sample.per_pose[:, kernel.LARGEST], size.max(axis=1), rtol=1e-12)
    np.testing.assert_array_equal(sample.per_pose[:, kernel.LARGEST_ROBOT], size.argmax(axis=1))
    np.testing.assert_allclose(sample.robot_sums, size.sum(axis=0), rtol=1e-12)
    assert sample.whole_hist().sum() == size.size
    counted = np.histogram(size, bin_edges())[0]
    # rounding may move a sample at an edge to either side
    assert np.abs(sample.whole_hist().sum(axis=0) - counted).sum() <= 4


def test_a_pose_s_quantiles_are_within_a_bin_of_the_samples(some_arm):
    """A quantile of a pose differs from the sample of its rank by at most one bin, 1/1024 of the
    span of its errors.
    """
    poses = sample_poses(some_arm, 40)
    matrix, size = lengths(some_arm, poses, ROBOTS, 7)
    sample = sample_block(BlockPlan.of(some_arm, poses, ROBOTS, 1, 7, 0.0), matrix, 0)
    span = size.max(axis=1) - size.min(axis=1)
    for k, level in enumerate(kernel.QUANTILES):
        exact = np.quantile(size, level, axis=1, method="inverted_cdf")
        assert (
            np.abs(sample.per_pose[:, kernel.FIRST_QUANTILE + 3 * k] - exact)
            <= 1.001 * span / kernel.FINE
        ).all()


@pytest.mark.parametrize("level", [0.001, 0.05, 0.5, 0.95, 0.99, 0.9999])
def test_quantiles_of_all_samples_are_within_the_stated_error(some_arm, level):
    """A quantile of the pooled histogram differs from the sample of its rank by less than 0.4 %,
    the width of the widest bin.
    """
    poses = sample_poses(some_arm, 40)
    matrix, size = lengths(some_arm, poses, ROBOTS, 7)
    sample = sample_block(BlockPlan.of(some_arm, poses, ROBOTS, 1, 7, 0.0), matrix, 0)
    widest = np.max(bin_edges()[1:] / bin_edges()[:-1]) - 1
    assert widest < 0.004
    exact = np.quantile(size, level, method="inverted_cdf")
    assert quantile(sample.whole_hist().sum(axis=0), level) == pytest.approx(exact, rel=widest)


def test_visits_without_scatter_equal_one_visit():
    """Thirty visits without scatter have the figures of one visit and thirty times its counts; AP
    is the robot's error and RP is zero.
    """
    steady = arm_of(3, **BARE, lumped={**LUMPED, "varies": "robot"})
    poses = sample_poses(steady, 16)
    matrix, size = lengths(steady, poses, ROBOTS, 7)
    one = sample_block(BlockPlan.of(steady, poses, ROBOTS, 1, 7, 0.0), matrix, 0)
    thirty = sample_block(BlockPlan.of(steady, poses, ROBOTS, 30, 7, 0.0), matrix, 0)
    np.testing.assert_array_equal(thirty.whole_hist(), 30 * one.whole_hist())
    np.testing.assert_array_equal(thirty.per_pose, one.per_pose)
    np.testing.assert_allclose(thirty.ap_rp[:, 0], size, rtol=1e-12)
    assert (thirty.ap_rp[:, 1] == 0).all()


def test_one_seed_returns_the_same_bits_for_any_threads_and_tiling(some_arm):
    """One seed returns the same bits for one or two threads and for one or three blocks at a
    time.
    """
    poses = sample_poses(some_arm, 4000, "uniform")
    first = run(some_arm, poses, 70, 1, 5)
    again = run(some_arm, poses, 70, 1, 5, threads=2, tile=3)
    for name in ("per_pose", "robot_means", "group_hist", "replicate_hist"):
        np.testing.assert_array_equal(getattr(again, name), getattr(first, name), err_msg=name)


def test_blocks_of_another_size_change_no_bit_of_a_pose(some_arm, monkeypatch):
    """A pose has the same bits in blocks of any size."""
    poses = sample_poses(some_arm, 56, "uniform")
    whole = run(some_arm, poses, 70, 1, 5)
    monkeypatch.setattr(montecarlo, "BLOCK", 3)
    cut = run(some_arm, poses, 70, 1, 5)
    np.testing.assert_array_equal(cut.per_pose, whole.per_pose)
    np.testing.assert_array_equal(cut.group_hist, whole.group_hist)


@pytest.mark.parametrize("visits", [1, 3])
def test_the_error_of_an_arm_that_only_deflects_is_its_deflection(visits):
    """Every robot of an elastic arm on a tilted base has the same error vector at every visit, and
    the error is its magnitude.
    """
    elastic = arm_of(3, **{**BARE, "gearbox": {"stiffness": "5 N m/arcmin"}})
    leaning = elastic.model_copy(
        update={"base": Base(roll=Toleranced(0.3), pitch=Toleranced(-0.2))}
    )
    poses = sample_poses(leaning, 24)
    stands = state_of(leaning, poses.q).settled()
    deflection = (stands.frames - stands.commanded)[-1, :, :3, 3]
    assert (np.abs(deflection).max(axis=0) > 1e-5).all()
    found = run(leaning, poses, 20, visits, 1).per_pose
    np.testing.assert_allclose(
        found[:, kernel.MEAN], np.linalg.norm(deflection, axis=1), rtol=1e-12
    )
    np.testing.assert_allclose(found[:, kernel.LARGEST], found[:, kernel.MEAN], rtol=1e-12)


def test_an_arm_without_error_terms_has_zero_error():
    """An arm without error terms has zero error, counted in the first bin."""
    perfect = arm_of(2, **BARE)
    found = run(perfect, Poses(np.array([[0.0, 0.3]]), "given"), 1, 1, 1)
    assert found.per_pose[0, [kernel.MEAN, kernel.LARGEST]].tolist() == [0.0, 0.0]
    assert found.group_hist[0, 0] == 1


@pytest.mark.parametrize("visits", [1, 3])
@pytest.mark.parametrize(("factor", "at"), [(1e-12, 0), (1e12, BINS - 1)])
def test_errors_beyond_the_bins_count_in_the_first_and_the_last(arm, visits, factor, at):
    """The first bin counts errors of femtometres and the last bin errors of millions of kilometres,
    so no sample is lost.
    """
    poses = sample_poses(arm, 4)
    sample = sample_block(
        BlockPlan.of(arm, poses, ROBOTS, visits, 7, 0.0),
        screws(state_of(arm, poses.q)).scaled(factor),
        0,
    )
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
    # One term applies to all robots, and one to the third of the robots whose play is closed.
    plays, frictions = np.tile([[1.0, 1.0, 1.0], [1 / 3, 1.0, 0.0]], (poses, 1, 1)), rng.random((2, 2, draw_kernel.LANES))
    steady, visiting, products = np.arange(8), 8 + np.arange(4), 12 + np.arange(2)
    drawn_products = (products, none[:2], keys[4:6], factors, frictions)
    form(0, bias, shift, plays, steady, drawn, visiting, none, keys[:4], *drawn_products, tables, robots, visits, groups, 2.0, *out)
    print(hashlib.sha256(b"".join(x.tobytes() for x in out)).hexdigest())
"""


@pytest.mark.slow
def test_a_processor_without_fused_multiply_add_gives_the_same_bits(tmp_path):
    """Both kernels, compiled for a generic processor without fused multiply-add, return the bits of
    this processor.
    """
    plain = {
        **os.environ,
        "NUMBA_CACHE_DIR": str(tmp_path),
        "NUMBA_CPU_NAME": "generic",
        "NUMBA_CPU_FEATURES": "",
    }
    here, there = (
        subprocess.run(
            [sys.executable, "-c", _BITS], check=True, capture_output=True, text=True, env=env
        ).stdout
        for env in (os.environ, plain)
    )
    assert here == there
    assert len(here.split()) == 2
