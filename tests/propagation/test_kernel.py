"""The fused kernel against plain NumPy on the same draws."""

from pathlib import Path

import numpy as np
import pytest

from lostmotion import Arm, Poses, frames, read, sample_poses, screws, worst_case
from lostmotion.analyses.iso9283.characteristics import pose_accuracy, pose_repeatability
from lostmotion.error_model import error_bins
from lostmotion.error_model.bounds import root_sum_square
from lostmotion.error_model.error_bins import bin_edges
from lostmotion.error_model.intervals import student
from lostmotion.propagation.exact import draws_of
from lostmotion.propagation.montecarlo import kernel, montecarlo
from lostmotion.propagation.montecarlo.blocks import Plan, sample_block, sample_blocks
from lostmotion.propagation.montecarlo.montecarlo import run
from tests.conftest import arm_of

EXAMPLES = Path(__file__).parents[2] / "examples"
ROBOTS, VISITS = 150, 40  # more robots than one tile has lanes


@pytest.fixture(scope="module")
def block(arm):
    """Return the kernel's statistics and the same errors formed one by one."""
    poses = sample_poses(arm, 8)
    matrix = screws(arm, poses.q)
    robot, visit = (x.ravel() for x in np.meshgrid(np.arange(ROBOTS), np.arange(VISITS), indexing="ij"))
    errors = np.stack([(matrix.tool[p, 3:] @ draws_of(matrix, p, 7, p, robot, visit)).T for p in range(len(poses))])
    sample = sample_block(Plan.of(arm, poses, ROBOTS, VISITS, 7, 0.0), matrix, 0)
    return sample, errors.reshape(len(poses), ROBOTS, VISITS, 3)


def test_the_kernel_forms_the_same_errors_as_a_plain_matrix_product(block):
    """Mean, mean square and the largest error, with the robot and visit that made it, are those of screws @ draws."""
    sample, errors = block
    size = np.linalg.norm(errors, axis=-1)
    np.testing.assert_allclose(sample.per_pose[:, kernel.MEAN], size.mean(axis=(1, 2)), rtol=1e-12)
    np.testing.assert_allclose(sample.per_pose[:, kernel.MEAN_SQUARE], (size**2).mean(axis=(1, 2)), rtol=1e-12)
    np.testing.assert_allclose(sample.per_pose[:, kernel.LARGEST], size.max(axis=(1, 2)), rtol=1e-12)
    at = size.reshape(len(size), -1).argmax(axis=1)
    np.testing.assert_array_equal(sample.per_pose[:, kernel.LARGEST_ROBOT], at // VISITS)
    np.testing.assert_array_equal(sample.per_pose[:, kernel.LARGEST_VISIT], at % VISITS)
    np.testing.assert_allclose(sample.robot_sums, size.mean(axis=2).sum(axis=0), rtol=1e-12)


def test_the_kernel_keeps_the_definitions_of_iso_9283(block):
    """AP and RP of every robot at every pose are those of the standard's formulas on the samples themselves."""
    sample, errors = block
    np.testing.assert_allclose(sample.ap_rp[:, 0], pose_accuracy(errors, np.zeros(3)), rtol=1e-10)
    np.testing.assert_allclose(sample.ap_rp[:, 1], pose_repeatability(errors), rtol=1e-9)


def test_quantiles_read_from_the_histogram_are_those_of_the_samples(block):
    """The 50, 95 and 99 % errors agree with sorting all samples to a bin's width."""
    sample, errors = block
    size = np.linalg.norm(errors, axis=-1).reshape(len(errors), -1)
    for k, level in enumerate(kernel.QUANTILES):
        np.testing.assert_allclose(sample.per_pose[:, kernel.FIRST_QUANTILE + 3 * k], np.quantile(size, level, axis=1), rtol=3e-3)


def test_every_sample_is_counted_once(block):
    """The histograms of the groups of robots hold every sample, in the bin where it belongs."""
    sample, errors = block
    assert sample.whole_hist().sum() == errors[..., 0].size
    counted = np.histogram(np.linalg.norm(errors, axis=-1), bin_edges())[0]
    assert np.abs(sample.whole_hist().sum(axis=0) - counted).sum() <= 4  # a sample within rounding of an edge may fall to either side


def test_the_interval_of_a_quantile_counts_robots(block):
    """Half of the interval in rank is Student's t times the larger of Woodruff's error, robot by robot, and that of Kish's design effect."""
    sample, errors = block
    for pose in range(len(errors)):
        size = np.linalg.norm(errors, axis=-1)[pose]
        value, low, high = sample.per_pose[pose, kernel.FIRST_QUANTILE + 3 : kernel.FIRST_QUANTILE + 6]
        woodruff = (size <= value).mean(axis=1).std(ddof=1) / np.sqrt(ROBOTS)
        between = size.mean(axis=1).var() / size.var()
        kish = np.sqrt(0.95 * 0.05 * (1 + (VISITS - 1) * between) / size.size)
        half = student(ROBOTS - 1) * max(woodruff, kish)
        assert low == pytest.approx(np.quantile(size, 0.95 - half), rel=3e-3)
        assert high == pytest.approx(np.quantile(size, 0.95 + half), rel=3e-3)


@pytest.mark.parametrize(("robots", "visits"), [(5, 30), (20, 30), (200, 5), (1000, 1)])
def test_intervals_at_a_pose_hold_the_truth_as_often_as_they_say(arm, robots, visits):
    """Over many seeds the 95 % intervals of mean, 50, 95 and 99 % error at 8 poses hold a long run's values; an end may be unknown, never wrong."""
    poses = Poses(sample_poses(arm, 8, seed=5).q, "given")
    truth = run(arm, poses, 20_000, 4, 999).per_pose
    held, tries = np.zeros(4), 0
    for seed in range(40):
        found = run(arm, poses, robots, visits, seed).per_pose
        held[0] += np.sum(np.abs(found[:, kernel.MEAN] - truth[:, kernel.MEAN]) <= found[:, kernel.MEAN_ERROR])
        for k in range(3):
            column = kernel.FIRST_QUANTILE + 3 * k
            low, high = found[:, column + 1], found[:, column + 2]
            value = truth[:, column]
            held[k + 1] += np.sum((np.isnan(low) | (low <= value)) & (np.isnan(high) | (value <= high)))
        tries += len(poses)
    assert (held / tries > 0.9).all(), held / tries


def test_a_pose_that_hardly_scatters_still_has_an_interval():
    """Where one large bias hides a scatter a thousand times smaller, quantiles and intervals are as fine as the scatter."""
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


def test_one_robot_says_nothing_of_others_at_any_pose(arm):
    """With one robot no pose has an interval: the ends are unknown, not equal to the value."""
    found = run(arm, sample_poses(arm, 8), 1, 30, 1)
    assert np.isnan(found.per_pose[:, kernel.MEAN_ERROR]).all()
    assert np.isnan(found.per_pose[:, kernel.FIRST_QUANTILE + 1]).all()
    assert np.isnan(found.repeatability[:, 2:]).all()


def test_the_same_seed_gives_the_same_bits_on_any_threads_and_tiling(arm):
    """One thread or two, one block at a time or five: not one bit differs; another seed differs."""
    poses = sample_poses(arm, 5000, "uniform")
    first = run(arm, poses, 70, 3, 5, threads=1, tile=1)
    for threads, tile in ((2, 1), (2, 5), (1, 3)):
        again = run(arm, poses, 70, 3, 5, threads=threads, tile=tile)
        for name in ("per_pose", "accuracy", "repeatability", "robot_means", "group_hist", "replicate_hist", "worst", "bias"):
            np.testing.assert_array_equal(getattr(again, name), getattr(first, name), err_msg=name)
        assert again.tally.total == first.tally.total
        assert again.exact == first.exact
    assert not np.array_equal(run(arm, poses, 70, 3, 6).per_pose, first.per_pose)


def test_blocks_walked_together_are_sampled_as_each_by_itself(arm):
    """Blocks of one matrix, with the draws laid out once, give the bits of blocks that were walked by themselves; groups are counted over all."""
    poses = sample_poses(arm, 40, "uniform")
    plan = Plan.of(arm, poses, 70, 3, 5, 0.0)
    spans = [(16, 20), (20, 21), (21, 40)]
    together = sample_blocks(plan, screws(arm, poses.q[16:]), spans)
    so_far = np.zeros((plan.groups, error_bins.BINS), np.int64)
    for (first, last), sample in zip(spans, together, strict=True):
        alone = sample_block(plan, screws(arm, poses.q[first:last]), first)
        for name in ("per_pose", "ap_rp", "robot_sums"):
            np.testing.assert_array_equal(getattr(sample, name), getattr(alone, name), err_msg=name)
        hist, so_far = np.zeros(error_bins.BINS, np.int64), so_far + alone.whole_hist()
        hist[sample.bins] = sample.hist
        np.testing.assert_array_equal(hist, alone.whole_hist().sum(axis=0))
        np.testing.assert_array_equal(sample.whole_hist(), so_far)
        assert so_far.any(axis=0).nonzero()[0][[0, -1]].tolist() == [sample.bins.start, sample.bins.stop - 1]


@pytest.mark.parametrize(("robots", "walks"), [(10, 1), (1000, 1), (10_000, 3), (40_000, 8)])
def test_a_study_of_few_samples_walks_the_arm_once(arm, monkeypatch, robots, walks):
    """Eight sets of poses are eight blocks; where each has few samples, their frames and terms are worked out together."""
    walked = []
    monkeypatch.setattr(montecarlo, "screws", lambda arm, q, **options: walked.append(len(q)) or screws(arm, q, **options))
    run(arm, sample_poses(arm, 256), robots, 1, 1)
    assert len(walked) == walks
    assert sum(walked) == 256


@pytest.mark.parametrize("file", ["z-arm.toml", "arm-from-drawings.toml", "ur5e.urdf"])
def test_a_pose_has_the_same_bits_alone_and_among_others(file):
    """Frames and screws of one pose do not depend on how many are worked out with it."""
    arm = read(EXAMPLES / file)
    q = sample_poses(arm, 16, "uniform").q
    every = screws(arm, q)
    for first, last in ((0, 1), (5, 6), (6, 8), (8, 16)):
        some, same = screws(arm, q[first:last]), every.stretch(first, last)
        for name in ("at", "local", "tool", "bias"):
            np.testing.assert_array_equal(getattr(some, name), getattr(same, name), err_msg=f"{name} of {first} to {last}")
        for bound in (worst_case, root_sum_square):
            np.testing.assert_array_equal(bound(some), bound(every)[first:last], err_msg=f"{first} to {last}")


def test_a_turn_about_any_axis_has_the_same_bits_alone_and_among_others():
    """Frames go on by slanted poses and turn about slanted axes: no bit depends on how many poses are worked out together."""
    rng = np.random.default_rng(2)
    tips = [{"xyz": (0.1, 0.2, 0.3), "rpy": tuple(rpy)} for rpy in rng.uniform(-1, 1, (4, 3))]
    axes = [tuple(axis) for axis in rng.standard_normal((4, 3))]
    joints = [
        {"name": f"{k}", "type": "revolute", "axis": axis, "limits": (-3, 3), "link": {"tip": tip}}
        for k, (axis, tip) in enumerate(zip(axes, tips, strict=True))
    ]
    slanted, q = Arm.model_validate({"name": "slanted", "joints": joints}), rng.uniform(-3, 3, (16, 4))
    for first, last in ((0, 1), (3, 5), (8, 15)):
        np.testing.assert_array_equal(frames(slanted, q[first:last]), frames(slanted, q)[:, first:last])


def test_more_robots_keep_the_first_ones_however_poses_are_walked(arm):
    """Eight poses are eight blocks, walked together where robots are few, else each by itself; the first robots are the same to the bit."""
    poses = sample_poses(arm, 8)
    few, many = (run(arm, poses, robots, 13, 5).robot_means[:, :70] for robots in (70, 80_000))
    np.testing.assert_array_equal(few, many)


def test_more_robots_keep_the_first_ones(arm):
    """Robots 0 to 69 are the same robots, at the same visits, when 200 are built."""
    poses = sample_poses(arm, 8)
    matrix = screws(arm, poses.q)
    few = sample_block(Plan.of(arm, poses, 70, 3, 5, 0.0), matrix, 0)
    many = sample_block(Plan.of(arm, poses, 200, 3, 5, 0.0), matrix, 0)
    np.testing.assert_array_equal(many.ap_rp[:, :, :70], few.ap_rp)
    np.testing.assert_array_equal(many.robot_sums[:70], few.robot_sums)


def test_unknown_counts_are_refused(arm):
    """No robots, no visits, no threads: an error that names what was wrong."""
    poses = sample_poses(arm, 8)
    with pytest.raises(ValueError, match="robots"):
        run(arm, poses, 0, 3, 1)
    with pytest.raises(ValueError, match="visits"):
        run(arm, poses, 5, 0, 1)
    with pytest.raises(ValueError, match="threads"):
        run(arm, poses, 5, 2, 1, threads=0)


def test_where_only_visits_differ_visits_of_few_robots_replace_robots():
    """An arm that errs by encoder noise alone: the interval of its 95th percentile from 20 robots at 50 visits is below twice that of 1 000."""
    joint = {"name": "A", "type": "revolute", "axis": "z", "limits": (-1, 1), "encoder": {"noise": "1 arcmin"}, "link": {"length": "1 m"}}
    noisy = Arm.model_validate({"name": "noisy", "joints": [joint]})
    poses = Poses(np.linspace(-1, 1, 16)[:, None], "given")
    column = kernel.FIRST_QUANTILE + 3  # of the 95th percentile
    widths = []
    for robots, visits in ((20, 50), (1000, 1)):
        found = run(noisy, poses, robots, visits, 3).per_pose
        widths.append(np.mean(found[:, column + 2] - found[:, column + 1]))
    assert 1 < widths[0] / widths[1] < 2
