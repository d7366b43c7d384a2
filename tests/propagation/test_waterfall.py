"""Calibration and compensation leave what a study without those errors finds."""

import numpy as np
import pytest

from lostmotion import sample_poses
from lostmotion.error_model.intervals import pooled_mean, quantile
from lostmotion.error_model.pose_matrix import screws
from lostmotion.propagation.analytic import Drawn, of_screws
from lostmotion.propagation.montecarlo import montecarlo
from lostmotion.propagation.montecarlo.blocks import Plan, sample_block
from lostmotion.propagation.montecarlo.common_random_numbers import thinned
from lostmotion.propagation.montecarlo.waterfall import STAGES, geometry_of, remaining, waterfall
from tests.conftest import JOINT, arm_of

POSES, ROBOTS, VISITS, SEED = 64, 60, 4, 3


def dropped(matrix, stage, geometry):
    """Return the pose matrix of a stage."""
    return matrix.scaled(remaining(matrix.infos, stage, geometry))


@pytest.fixture(scope="module")
def found(arm):
    """Return the waterfall of the arm with every kind of error, over poses of which it takes all."""
    return waterfall(arm, sample_poses(arm, POSES), ROBOTS, VISITS, SEED)


def test_calibrated_is_a_study_of_an_arm_that_was_built_without_constant_errors():
    """Lengths without tolerance, true axes, mastered encoders: the same draws by name, so the same figures."""
    arm = arm_of()
    calibrated = waterfall(arm, sample_poses(arm, POSES), ROBOTS, VISITS, SEED).stages[STAGES.index("calibrated")]
    true = arm_of(mounting=None, encoder={**JOINT["encoder"], "zero": 0.0}, link={**JOINT["link"], "length": "400 mm"})
    again = montecarlo.run(true, sample_poses(true, POSES), ROBOTS, VISITS, SEED)
    assert calibrated.q95.value == pytest.approx(quantile(again.group_hist.sum(axis=0), 0.95), rel=1e-9)
    assert calibrated.mean.value == pytest.approx(again.robot_means[:, :, 0].mean(), rel=1e-9)


@pytest.mark.parametrize(("stage", "gone"), [("load compensated", {"design"}), ("both, and each robot mapped", {"design", "robot"})])
def test_stages_are_studies_with_those_levels_dropped(arm, found, monkeypatch, stage, gone):
    """A whole study whose pose matrix has those levels set to nothing finds the same mean and 95 % error, to rounding."""

    def without(*words, **options):
        matrix = screws(*words, **options)
        kept = np.array([info.level not in gone for info in matrix.infos], dtype=float)
        return matrix.scaled(kept)

    monkeypatch.setattr(montecarlo, "screws", without)
    again = montecarlo.run(arm, sample_poses(arm, POSES), ROBOTS, VISITS, SEED)
    told = found.stages[STAGES.index(stage)]
    assert told.q95.value == pytest.approx(quantile(again.group_hist.sum(axis=0), 0.95), rel=1e-9)
    assert told.mean.value == pytest.approx(pooled_mean(again.robot_means[:, :, 0]).value, rel=1e-9)
    assert told.mean.low == pytest.approx(pooled_mean(again.robot_means[:, :, 0]).low, rel=1e-9)


def test_no_remedy_changes_repeatability(arm, monkeypatch):
    """RP of every robot at every pose is the same at all stages but the last, which keeps the amount of a free play as well."""
    poses = sample_poses(arm, 16)
    geometry = geometry_of(arm)
    before = montecarlo.run(arm, poses, 20, 5, 1).robot_means[:, :, 2]
    for stage in STAGES:
        monkeypatch.setattr(montecarlo, "screws", lambda *words, stage=stage, **options: dropped(screws(*words, **options), stage, geometry))
        np.testing.assert_allclose(montecarlo.run(arm, poses, 20, 5, 1).robot_means[:, :, 2], before, rtol=1e-9)


def test_calibration_finds_constant_errors_and_neither_harmonics_nor_what_follows_the_load(arm):
    """An error that depends on angle or load is not geometry, even where the study's poses happen to leave it constant."""
    geometry = geometry_of(arm)
    kinds = {name.removeprefix("joints.A.") for name in geometry if name.startswith("joints.A.")}
    assert kinds == {
        "encoder.zero",
        "link.length",
        "mounting.axis tilt 1",
        "mounting.axis tilt 2",
        "mounting.axis offset 1",
        "mounting.axis offset 2",
    }


def test_stages_fall_and_intervals_hold_the_drop(found):
    """Nothing is removed as manufactured; compensation removes most; what every robot still shows is least; intervals contain their values."""
    by_name = {stage.name: stage for stage in found.stages}
    assert [stage.name for stage in found.stages] == list(STAGES)
    assert by_name["as manufactured"].reduction.value == 0
    assert by_name["both"].q95.value < by_name["load compensated"].q95.value < by_name["as manufactured"].q95.value
    for stage in found.stages:
        assert stage.reduction.value == pytest.approx(by_name["as manufactured"].q95.value - stage.q95.value, rel=1e-3, abs=1e-9)
        for told in (stage.mean, stage.q95, stage.reduction):
            assert told.low <= told.value <= told.high


def test_both_agrees_with_the_route_without_sampling(arm):
    """Where nothing is left of the bias, mean square by samples and by the sum over terms agree within 3 %, at every stage."""
    poses = sample_poses(arm, 64)
    matrix = screws(arm, poses.q)
    geometry = geometry_of(arm)
    for stage in STAGES:
        kept = dropped(matrix, stage, geometry)
        plan = Plan.of(arm, poses, 2000, 2, 5, 0.0)
        sample = sample_block(plan, kept, 0)
        exact = of_screws(kept, Drawn(kept))
        squares = (exact.bias**2).sum(axis=1) + np.einsum("pii->p", exact.covariance)
        assert sample.per_pose[:, 2].mean() == pytest.approx(squares.mean(), rel=0.03)


def test_a_thinned_study_keeps_its_sets(arm):
    """The beginning of each independent sequence, so that intervals still include the choice of poses; equal steps of given poses."""
    poses = sample_poses(arm, 512)
    few = thinned(poses, 64)
    assert (len(few), few.replicates) == (64, 8)
    np.testing.assert_array_equal(few.q[8:16], poses.q[64:72])
    given = thinned(sample_poses(arm, 100, "grid"), 10)
    assert (len(given), given.replicates) == (10, 1)
