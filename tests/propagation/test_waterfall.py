"""The stages of calibration and compensation, compared with studies without the errors that they
remove.
"""

import numpy as np
import pytest

from lostmotion import sample_poses
from lostmotion.error_model.intervals import quantile
from lostmotion.error_model.pose_matrix import pose_matrix
from lostmotion.error_model.remedies import EVERY_STAGE, STAGES, geometry_of, remaining
from lostmotion.error_model.robot_intervals import pooled_mean
from lostmotion.propagation.analytic import analytic
from lostmotion.propagation.error_magnitude import LEVELS
from lostmotion.propagation.montecarlo import montecarlo
from lostmotion.propagation.montecarlo.blocks import BlockPlan, sample_block
from lostmotion.propagation.montecarlo.common_random_numbers import thinned
from lostmotion.propagation.montecarlo.waterfall import waterfall
from lostmotion.propagation.pooled import pooled
from tests.arms import JOINT, arm_of

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "what calibration and compensation leave",
        "studies of arms with those errors removed; sums over terms at every stage",
        "1e-9; 3 % mean square, 5 % 95th percentile",
        "propagation/montecarlo/waterfall.py",
    ),
)

POSES, ROBOTS, VISITS, SEED = 64, 60, 4, 3


def remaining_errors(matrix, stage, geometry):
    """Return the pose matrix without the errors that a stage removes."""
    return matrix.scaled(remaining(matrix.infos, stage, geometry))


@pytest.fixture(scope="module")
def found(arm):
    """Return the waterfall of the arm with every kind of error, over all of its poses."""
    return waterfall(arm, sample_poses(arm, POSES), ROBOTS, VISITS, SEED)


def test_the_calibrated_stage_is_a_study_of_an_arm_without_constant_errors():
    """The calibrated stage has the figures of an arm with exact lengths, axes and encoder zeros,
    since streams by name keep the other draws.
    """
    arm = arm_of()
    calibrated = waterfall(arm, sample_poses(arm, POSES), ROBOTS, VISITS, SEED).stages[
        STAGES.index("calibrated")
    ]
    true = arm_of(
        mounting=None,
        encoder={**JOINT["encoder"], "zero": 0.0},
        link={**JOINT["link"], "length": "400 mm"},
    )
    again = montecarlo.run(true, sample_poses(true, POSES), ROBOTS, VISITS, SEED)
    assert calibrated.q95.value == pytest.approx(
        quantile(again.group_hist.sum(axis=0), 0.95), rel=1e-9
    )
    assert calibrated.mean.value == pytest.approx(again.robot_means[:, :, 0].mean(), rel=1e-9)


@pytest.mark.parametrize(
    ("stage", "removed"),
    [("load compensated", {"design"}), ("both, and each robot mapped", {"design", "robot"})],
)
def test_stages_are_studies_with_those_levels_dropped(arm, found, monkeypatch, stage, removed):
    """A study whose pose matrix has zeros at the removed levels has the mean and 95th percentile of
    the stage.
    """

    def without(*words, **options):
        matrix = pose_matrix(*words, **options)
        kept = np.array([info.level not in removed for info in matrix.infos], dtype=float)
        return matrix.scaled(kept)

    monkeypatch.setattr(montecarlo, "pose_matrix", without)
    again = montecarlo.run(arm, sample_poses(arm, POSES), ROBOTS, VISITS, SEED)
    compared = found.stages[STAGES.index(stage)]
    assert compared.q95.value == pytest.approx(
        quantile(again.group_hist.sum(axis=0), 0.95), rel=1e-9
    )
    assert compared.mean.value == pytest.approx(
        pooled_mean(again.robot_means[:, :, 0]).value, rel=1e-9
    )
    assert compared.mean.low == pytest.approx(pooled_mean(again.robot_means[:, :, 0]).low, rel=1e-9)


def test_no_remedy_changes_repeatability(arm, monkeypatch):
    """RP of every robot at every pose is the same at all stages of calibration and compensation."""
    poses = sample_poses(arm, 16)
    geometry = geometry_of(arm)
    before = montecarlo.run(arm, poses, 20, 5, 1).robot_means[:, :, 2]
    for stage in STAGES:
        monkeypatch.setattr(
            montecarlo,
            "pose_matrix",
            lambda *words, stage=stage, **options: remaining_errors(
                pose_matrix(*words, **options), stage, geometry
            ),
        )
        np.testing.assert_allclose(
            montecarlo.run(arm, poses, 20, 5, 1).robot_means[:, :, 2], before, rtol=1e-9
        )


def test_calibration_finds_constant_errors_but_neither_harmonics_nor_deflections(arm):
    """Calibration removes constant geometry errors, and no error that depends on angle or load."""
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


def test_the_error_falls_from_stage_to_stage(found):
    """Load compensation lowers the error, calibration lowers it further, the first stage removes
    nothing, and every interval contains its value.
    """
    by_name = {stage.name: stage for stage in found.stages}
    assert [stage.name for stage in found.stages] == list(EVERY_STAGE)
    assert by_name["as manufactured"].reduction.value == 0
    assert (
        by_name["both"].q95.value
        < by_name["load compensated"].q95.value
        < by_name["as manufactured"].q95.value
    )
    for stage in found.stages:
        assert stage.reduction.value == pytest.approx(
            by_name["as manufactured"].q95.value - stage.q95.value, rel=1e-3, abs=1e-9
        )
        for compared in (stage.mean, stage.q95, stage.reduction):
            assert compared.low <= compared.value <= compared.high


def test_every_stage_agrees_with_the_analytic_mean_square(arm):
    """At every stage the sampled mean square agrees with the sum over terms within 3 %."""
    poses = sample_poses(arm, 64)
    matrix = pose_matrix(arm, poses.q)
    geometry = geometry_of(arm)
    for stage in STAGES:
        kept = remaining_errors(matrix, stage, geometry)
        plan = BlockPlan.of(arm, poses, 2000, 2, 5, 0.0)
        sample = sample_block(plan, kept, 0)
        exact = analytic(arm, poses, stage=stage)
        assert sample.per_pose[:, 2].mean() == pytest.approx(exact.mean_square.mean(), rel=0.03)


def test_the_figures_over_all_poses_follow_a_remedy_too(arm, found):
    """At every stage the 95th percentile by sums over terms agrees with that of the samples within
    5 %.
    """
    poses = sample_poses(arm, POSES)
    for stage in found.stages:
        exact = pooled(arm, poses, analytic(arm, poses, stage=stage.name), stage=stage.name)
        assert exact.quantiles[LEVELS.index(0.95)].value == pytest.approx(stage.q95.value, rel=0.05)


def test_a_thinned_study_keeps_its_sets(arm):
    """A thinned study takes the beginning of each independent set, so that intervals include the
    choice of poses, and equal steps of stated poses.
    """
    poses = sample_poses(arm, 512)
    few = thinned(poses, 64)
    assert (len(few), few.replicates) == (64, 8)
    np.testing.assert_array_equal(few.q[8:16], poses.q[64:72])
    given = thinned(sample_poses(arm, 100, "grid"), 10)
    assert (len(given), given.replicates) == (10, 1)
