"""The Monte Carlo kernel, compared with plain NumPy on the same draws."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from lostmotion import Arm, Poses, read, sample_poses, screws
from lostmotion.error_model import error_bins
from lostmotion.error_model.bounds import bounds
from lostmotion.error_model.error_bins import bin_edges
from lostmotion.error_model.intervals import student
from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.laws.iso9283 import pose_accuracy, pose_repeatability
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.exact import draws_of
from lostmotion.propagation.montecarlo import kernel, montecarlo
from lostmotion.propagation.montecarlo.blocks import BlockPlan, sample_block, sample_blocks
from lostmotion.propagation.montecarlo.montecarlo import run
from tests.arms import arm_of

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "Monte Carlo kernel",
        "plain NumPy on the same draws",
        "1e-12",
        (
            "propagation/montecarlo/kernel.py propagation/montecarlo/product_kernel.py "
            "propagation/montecarlo/montecarlo.py "
            "propagation/montecarlo/blocks.py"
        ),
    ),
    (
        "intervals at a pose",
        "40 seeds x 8 poses, 5 to 1 000 robots: share that covers a long run's value",
        "90 % or more for nominal 95 %",
    ),
    (
        "same bits",
        "1 and 2 threads, any tiling; more robots; new sources",
        "bit for bit",
        "tests/propagation/test_single_visit_kernel.py tests/error_model/test_draws.py",
    ),
)

EXAMPLES = Path(__file__).parents[2] / "examples"
ROBOTS, VISITS = 150, 40  # more robots than the lanes of one tile


@pytest.fixture(scope="module")
def block(arm):
    """Return the kernel's statistics and the same errors computed sample by sample."""
    poses = sample_poses(arm, 8)
    matrix = screws(state_of(arm, poses.q))
    robot, visit = (
        x.ravel() for x in np.meshgrid(np.arange(ROBOTS), np.arange(VISITS), indexing="ij")
    )
    errors = np.stack(
        [
            (matrix.tool[p, 3:] @ draws_of(matrix, p, 7, p, robot, visit)).T
            for p in range(len(poses))
        ]
    )
    sample = sample_block(BlockPlan.of(arm, poses, ROBOTS, VISITS, 7, 0.0), matrix, 0)
    return sample, errors.reshape(len(poses), ROBOTS, VISITS, 3)


def test_the_kernel_computes_the_errors_of_a_plain_matrix_product(block):
    """The kernel's mean, mean square and largest error, with its robot and visit, equal those of
    screws @ draws.
    """
    sample, errors = block
    size = np.linalg.norm(errors, axis=-1)
    np.testing.assert_allclose(sample.per_pose[:, kernel.MEAN], size.mean(axis=(1, 2)), rtol=1e-12)
    np.testing.assert_allclose(
        sample.per_pose[:, kernel.MEAN_SQUARE], (size**2).mean(axis=(1, 2)), rtol=1e-12
    )
    np.testing.assert_allclose(
        sample.per_pose[:, kernel.LARGEST], size.max(axis=(1, 2)), rtol=1e-12
    )
    at = size.reshape(len(size), -1).argmax(axis=1)
    np.testing.assert_array_equal(sample.per_pose[:, kernel.LARGEST_ROBOT], at // VISITS)
    np.testing.assert_array_equal(sample.per_pose[:, kernel.LARGEST_VISIT], at % VISITS)
    np.testing.assert_allclose(sample.robot_sums, size.mean(axis=2).sum(axis=0), rtol=1e-12)


def test_the_kernel_follows_the_definitions_of_iso_9283(block):
    """AP and RP of every robot at every pose equal the formulas of ISO 9283 applied to the
    samples.
    """
    sample, errors = block
    np.testing.assert_allclose(sample.ap_rp[:, 0], pose_accuracy(errors, np.zeros(3)), rtol=1e-10)
    np.testing.assert_allclose(sample.ap_rp[:, 1], pose_repeatability(errors), rtol=1e-9)


def test_quantiles_read_from_the_histogram_are_those_of_the_samples(block):
    """The 50th, 95th and 99th percentiles equal those of the sorted samples within the width of a
    bin.
    """
    sample, errors = block
    size = np.linalg.norm(errors, axis=-1).reshape(len(errors), -1)
    for k, level in enumerate(kernel.QUANTILES):
        np.testing.assert_allclose(
            sample.per_pose[:, kernel.FIRST_QUANTILE + 3 * k],
            np.quantile(size, level, axis=1),
            rtol=3e-3,
        )


def test_every_sample_is_counted_once(block):
    """The histograms count every sample once, in its own bin."""
    sample, errors = block
    assert sample.whole_hist().sum() == errors[..., 0].size
    counted = np.histogram(np.linalg.norm(errors, axis=-1), bin_edges())[0]
    # rounding may move a sample at an edge to either side
    assert np.abs(sample.whole_hist().sum(axis=0) - counted).sum() <= 4


def test_the_interval_of_a_quantile_counts_robots(block):
    """The half-width in rank is Student's t times the larger of Woodruff's standard error over
    robots and Kish's design effect.
    """
    sample, errors = block
    for pose in range(len(errors)):
        size = np.linalg.norm(errors, axis=-1)[pose]
        value, low, high = sample.per_pose[
            pose, kernel.FIRST_QUANTILE + 3 : kernel.FIRST_QUANTILE + 6
        ]
        woodruff = (size <= value).mean(axis=1).std(ddof=1) / np.sqrt(ROBOTS)
        between = size.mean(axis=1).var() / size.var()
        kish = np.sqrt(0.95 * 0.05 * (1 + (VISITS - 1) * between) / size.size)
        half = student(ROBOTS - 1) * max(woodruff, kish)
        assert low == pytest.approx(np.quantile(size, 0.95 - half), rel=3e-3)
        assert high == pytest.approx(np.quantile(size, 0.95 + half), rel=3e-3)


@pytest.fixture(scope="module")
def long_run(arm):
    """Return 8 poses and the figures of many robots at them."""
    poses = Poses(sample_poses(arm, 8, seed=5).q, "given")
    return poses, run(arm, poses, 20_000, 4, 999).per_pose


@pytest.mark.parametrize(("robots", "visits"), [(5, 30), (200, 5), (1000, 1)])
def test_intervals_at_a_pose_cover_at_their_nominal_rate(arm, long_run, robots, visits):
    """Over 40 seeds the 95 % intervals of mean and percentiles at 8 poses cover the values of a
    long run; an end may be unknown but not wrong.
    """
    poses, truth = long_run
    covered, trials = np.zeros(4), 0
    for seed in range(40):
        found = run(arm, poses, robots, visits, seed, compared=0).per_pose
        covered[0] += np.sum(
            np.abs(found[:, kernel.MEAN] - truth[:, kernel.MEAN]) <= found[:, kernel.MEAN_ERROR]
        )
        for k in range(3):
            column = kernel.FIRST_QUANTILE + 3 * k
            low, high = found[:, column + 1], found[:, column + 2]
            value = truth[:, column]
            covered[k + 1] += np.sum(
                (np.isnan(low) | (low <= value)) & (np.isnan(high) | (value <= high))
            )
        trials += len(poses)
    assert (covered / trials > 0.9).all(), covered / trials


def test_a_pose_with_little_scatter_beside_a_large_bias_has_an_interval():
    """Quantiles and intervals resolve a scatter that is a hundredth or less of the bias."""
    stiff = arm_of(
        2,
        gearbox={"stiffness": "1 N m/arcmin"},
        bearing=None,
        encoder={"noise": "0.02 arcmin"},
        mounting={"offset": "2 µm"},
        link={"length": "400 mm", "mass": "3 kg"},
    )
    found = run(stiff, Poses(np.array([[0.0, 0.3]]), "given"), 400, 5, 1).per_pose[0]
    value, low, high = found[kernel.FIRST_QUANTILE : kernel.FIRST_QUANTILE + 3]
    assert found[kernel.MEAN] > 100 * (found[kernel.LARGEST] - found[kernel.MEAN])
    assert 0 < high - low < 0.2 * (found[kernel.LARGEST] - found[kernel.MEAN])
    assert low < value < high


def test_one_robot_has_no_interval_at_any_pose(arm):
    """With one robot the ends of every interval at a pose are unknown, not equal to the value."""
    found = run(arm, sample_poses(arm, 8), 1, 30, 1)
    assert np.isnan(found.per_pose[:, kernel.MEAN_ERROR]).all()
    assert np.isnan(found.per_pose[:, kernel.FIRST_QUANTILE + 1]).all()
    assert np.isnan(found.repeatability[:, 2:]).all()


def test_one_seed_returns_the_same_bits_for_any_threads_and_tiling(arm):
    """One seed returns the same bits for any number of threads and blocks at a time, and another
    seed returns other figures.
    """
    poses = sample_poses(arm, 2500, "uniform")
    first = run(arm, poses, 70, 3, 5, threads=1, tile=1)
    for threads, tile in ((2, 5), (1, 3)):
        again = run(arm, poses, 70, 3, 5, threads=threads, tile=tile)
        for name in (
            "per_pose",
            "accuracy",
            "repeatability",
            "robot_means",
            "group_hist",
            "replicate_hist",
            "worst",
            "bias",
        ):
            np.testing.assert_array_equal(getattr(again, name), getattr(first, name), err_msg=name)
        assert again.tally.total == first.tally.total
        assert again.exact == first.exact
    assert not np.array_equal(run(arm, poses, 70, 3, 6).per_pose, first.per_pose)


def test_blocks_sampled_together_equal_blocks_sampled_separately(arm):
    """Blocks that share one matrix and one layout of draws have the bits of blocks sampled
    separately, and the group counts accumulate over them.
    """
    poses = sample_poses(arm, 40, "uniform")
    plan = BlockPlan.of(arm, poses, 70, 3, 5, 0.0)
    spans = [(16, 20), (20, 21), (21, 40)]
    together = sample_blocks(plan, screws(state_of(arm, poses.q[16:])), spans)
    so_far = np.zeros((plan.groups, error_bins.BINS), np.int64)
    for (first, last), sample in zip(spans, together, strict=True):
        alone = sample_block(plan, screws(state_of(arm, poses.q[first:last])), first)
        for name in ("per_pose", "ap_rp", "robot_sums"):
            np.testing.assert_array_equal(getattr(sample, name), getattr(alone, name), err_msg=name)
        hist, so_far = np.zeros(error_bins.BINS, np.int64), so_far + alone.whole_hist()
        hist[sample.bins] = sample.hist
        np.testing.assert_array_equal(hist, alone.whole_hist().sum(axis=0))
        np.testing.assert_array_equal(sample.whole_hist(), so_far)
        assert so_far.any(axis=0).nonzero()[0][[0, -1]].tolist() == [
            sample.bins.start,
            sample.bins.stop - 1,
        ]


@pytest.mark.parametrize(("robots", "calls"), [(10, 1), (1000, 1), (120_000, 2)])
def test_a_study_of_few_samples_computes_one_pose_matrix(arm, monkeypatch, robots, calls):
    """A study computes the frames and terms of several of its eight blocks of poses in one call,
    as long as their samples are few.
    """
    counts = []
    monkeypatch.setattr(
        montecarlo,
        "pose_matrix",
        lambda arm, q, **options: counts.append(len(q)) or pose_matrix(arm, q, **options),
    )
    run(arm, sample_poses(arm, 256), robots, 1, 1)
    assert len(counts) == calls
    assert sum(counts) == 256


@pytest.mark.parametrize("file", ["z-arm.toml", "arm-from-drawings.toml", "ur5e.urdf"])
def test_a_pose_has_the_same_bits_alone_and_among_others(file):
    """The frames and screws of a pose have the same bits for any number of poses computed with
    it, at the command and where the arm stands.
    """
    arm = read(EXAMPLES / file)
    q = sample_poses(arm, 16, "uniform").q
    spans = ((0, 1), (5, 6), (6, 8), (8, 16))
    for (first, last), settled in itertools.product(spans, (False, True)):
        states = [state_of(arm, each) for each in (q[first:last], q)]
        some, every = (screws(each.settled() if settled else each) for each in states)
        same = every.stretch(first, last)
        for name in ("local", "tool", "bias"):
            np.testing.assert_array_equal(
                getattr(some, name), getattr(same, name), err_msg=f"{name} of {first} to {last}"
            )
        for bound, whole in zip(bounds(some), bounds(every), strict=True):
            np.testing.assert_array_equal(bound, whole[first:last], err_msg=f"{first} to {last}")


def test_a_turn_about_any_axis_has_the_same_bits_alone_and_among_others():
    """Frames behind tilted links and tilted joint axes have the same bits for any number of poses
    computed together.
    """
    rng = np.random.default_rng(2)
    tips = [{"xyz": (0.1, 0.2, 0.3), "rpy": tuple(rpy)} for rpy in rng.uniform(-1, 1, (4, 3))]
    axes = [tuple(axis) for axis in rng.standard_normal((4, 3))]
    joints = [
        {"name": f"{k}", "type": "revolute", "axis": axis, "limits": (-3, 3), "link": {"tip": tip}}
        for k, (axis, tip) in enumerate(zip(axes, tips, strict=True))
    ]
    slanted, q = (
        Arm.model_validate({"name": "slanted", "joints": joints}),
        rng.uniform(-3, 3, (16, 4)),
    )
    for first, last in ((0, 1), (3, 5), (8, 15)):
        np.testing.assert_array_equal(
            state_of(slanted, q[first:last]).frames, state_of(slanted, q).frames[:, first:last]
        )


def test_more_robots_keep_the_first_ones_for_any_grouping_of_blocks(arm):
    """The first robots have the same bits whether a study samples its eight blocks together or each
    by itself.
    """
    poses = sample_poses(arm, 8)
    few, many = (run(arm, poses, robots, 13, 5).robot_means[:, :70] for robots in (70, 80_000))
    np.testing.assert_array_equal(few, many)


def test_more_robots_keep_the_first_ones(arm):
    """Robots 0 to 69 have the same errors in a study of 70 robots and in one of 200."""
    poses = sample_poses(arm, 8)
    matrix = screws(state_of(arm, poses.q))
    few = sample_block(BlockPlan.of(arm, poses, 70, 3, 5, 0.0), matrix, 0)
    many = sample_block(BlockPlan.of(arm, poses, 200, 3, 5, 0.0), matrix, 0)
    np.testing.assert_array_equal(many.ap_rp[:, :, :70], few.ap_rp)
    np.testing.assert_array_equal(many.robot_sums[:70], few.robot_sums)


def test_counts_below_one_are_rejected(arm):
    """A run rejects zero robots, visits or threads, and names the argument."""
    poses = sample_poses(arm, 8)
    with pytest.raises(ValueError, match="robots"):
        run(arm, poses, 0, 3, 1)
    with pytest.raises(ValueError, match="visits"):
        run(arm, poses, 5, 0, 1)
    with pytest.raises(ValueError, match="threads"):
        run(arm, poses, 5, 2, 1, threads=0)


def test_visits_of_few_robots_replace_robots_where_only_visits_differ():
    """For an arm with encoder noise alone, 20 robots at 50 visits have at most twice the interval
    of the 95th percentile of 1 000 robots.
    """
    joint = {
        "name": "A",
        "type": "revolute",
        "axis": "z",
        "limits": (-1, 1),
        "encoder": {"noise": "1 arcmin"},
        "link": {"length": "1 m"},
    }
    noisy = Arm.model_validate({"name": "noisy", "joints": [joint]})
    poses = Poses(np.linspace(-1, 1, 16)[:, None], "given")
    column = kernel.FIRST_QUANTILE + 3  # of the 95th percentile
    widths = []
    for robots, visits in ((20, 50), (1000, 1)):
        found = run(noisy, poses, robots, visits, 3).per_pose
        widths.append(np.mean(found[:, column + 2] - found[:, column + 1]))
    assert 1 < widths[0] / widths[1] < 2
