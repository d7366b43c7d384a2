"""Calibrated arms: the error of a robot whose draws are N(theta, P)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model.bounds import bounds
from lostmotion.error_model.budget import LABELS, Tally, budget_changes, tally
from lostmotion.error_model.pose_matrix import pose_matrix, screws
from lostmotion.error_model.poses import sample_poses
from lostmotion.error_model.remedies import MEASURED, remaining, remaining_rms, screws_at_stage
from lostmotion.laws.distributions import Cosine, Sine
from lostmotion.mechanism.calibration import Calibration, known_streams
from lostmotion.mechanism.standing import standing
from lostmotion.mechanism.state import state_of
from lostmotion.propagation import exact
from lostmotion.propagation.analytic import analytic
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.montecarlo import run

EXAMPLES = Path(__file__).parents[2] / "examples"
# What remains of the twists in an equilibrium (`equilibrium.settle`).
SETTLED = 1e-9
Z_ARM = lostmotion.read(EXAMPLES / "z-arm.toml")


def posterior(count: int, size: float = 0.4) -> np.ndarray:
    """Return a covariance of estimates that are correlated with one another."""
    factor = np.random.default_rng(7).normal(size=(count, count)) * size / np.sqrt(count)
    whole = factor @ factor.T
    return (whole + whole.T) / 2


def calibration_of(arm: lostmotion.Arm, size: float = 0.4) -> Calibration:
    """Return estimates of every draw of an arm, harmonics and sizes of plays included."""
    streams = known_streams(arm.terms)
    return Calibration(
        streams,
        0.5 * np.random.default_rng(8).normal(size=len(streams)),
        posterior(len(streams), size),
    )


def bias_and_covariance(arm, calibration, q, approach=0.0):
    """Return mean and covariance of the error (pose, 3) from the columns of the arm as stated.

    By nothing but theta and P: columns with a draw x of which theta and P are estimates, in the
    frames where the calibrated arm stands. The known twists of every place compose its bias.
    """
    frames = standing(state_of(arm.calibrated(calibration), q)).frames
    matrix = screws(state_of(arm, q, frames=frames), approach=approach)
    row = {stream: k for k, stream in enumerate(calibration.streams)}
    shift = matrix.tool[:, 3:]
    twists = np.zeros((len(arm.places), len(q), 1, 6))
    side, out = np.zeros((len(q), 3)), np.zeros((len(q), 3, 3))
    known, spread = {}, {}
    for k, info in enumerate(matrix.infos):
        others = tuple(draw for draw in info.draws if draw[0][0] != "robot")
        estimate = None if info.robot is None else row[info.robot.name, info.robot.law]
        mean = 1.0 if estimate is None else calibration.mean[estimate]
        if others:
            known[others] = known.get(others, 0.0) + mean * shift[:, :, k]
        elif info.of.term.sided:  # adds to the equilibrium
            side += mean * shift[:, :, k]
        else:
            twists[info.of.place, :, 0] += mean * matrix.local[:, :, k]
        if estimate is not None:
            by_row = spread.setdefault(others, {})
            by_row[estimate] = by_row.get(estimate, 0.0) + shift[:, :, k]
    for moved in known.values():
        out += moved[:, :, None] * moved[:, None]
    for by_row in spread.values():
        rows = list(by_row)
        x = np.stack([by_row[each] for each in rows], axis=-1)
        out += x @ calibration.covariance[np.ix_(rows, rows)] @ x.transpose(0, 2, 1)
    command = state_of(arm, q)
    tool = command.composed(range(len(twists)), twists)[:, 0]
    return side + tool[:, :3, 3] - command.frames[-1, :, :3, 3], out


@pytest.mark.parametrize("approach", [0.0, 1.0])
@pytest.mark.parametrize("name", ["z-arm.toml", "six-axis.toml", "gantry.toml"])
def test_mean_and_covariance_are_those_of_the_estimates(name, approach):
    """At every pose the error has the mean and covariance that theta and P imply."""
    arm = lostmotion.read(EXAMPLES / name)
    calibration = calibration_of(arm)
    q = sample_poses(arm, 64).q
    bias, covariance = bias_and_covariance(arm, calibration, q, approach)
    calibrated = arm.calibrated(calibration)
    found = analytic(calibrated, q, approach=approach)
    np.testing.assert_allclose(found.bias, bias, atol=SETTLED * np.abs(bias).max())
    np.testing.assert_allclose(found.covariance, covariance, rtol=1e-9, atol=1e-18)
    assert len(calibrated.terms) <= 2 * len(arm.terms)


def test_shares_of_a_calibrated_arm_add_to_its_mean_square():
    """Every part counts with its own variance and its covariance with the others, which adds up."""
    calibrated = Z_ARM.calibrated(calibration_of(Z_ARM))
    q = sample_poses(Z_ARM, 64).q
    whole = analytic(calibrated, q).mean_square.sum()
    matrix = pose_matrix(calibrated, q)
    for by in LABELS:
        found = Tally.of(matrix, by)
        assert found.total == pytest.approx(whole, rel=1e-10)
        assert found.shared.sum() == pytest.approx(whole, rel=1e-10)
    levels = matrix.merged.level_squares
    assert levels.sum() == pytest.approx(whole, rel=1e-10)
    np.testing.assert_allclose(levels.sum(axis=0), found.levels, rtol=1e-9)


def test_remedies_remove_columns_of_a_calibrated_arm():
    """The mean square at a stage equals that of the matrix that remains there."""
    calibrated = Z_ARM.calibrated(calibration_of(Z_ARM))
    q = sample_poses(Z_ARM, 16).q
    matrix = pose_matrix(calibrated, q)
    left = remaining(matrix.infos, "output encoders", frozenset())
    shift = screws_at_stage(calibrated, q, "output encoders").merged.tool[:, 3:]
    assert matrix.mean_squares(left).sum() == pytest.approx(float((shift**2).sum()), rel=1e-9)


def test_the_step_of_the_measured_poses_leaves_what_is_uncertain():
    """A controller that corrects the estimates leaves the arm of the same estimates with mean zero;
    an arm that is not calibrated has no such step.
    """
    calibration = calibration_of(Z_ARM)
    poses = sample_poses(Z_ARM, 64)
    left = remaining_rms(Z_ARM.calibrated(calibration), poses)
    uncertain = replace(calibration, mean=np.zeros_like(calibration.mean))
    expected = remaining_rms(Z_ARM.calibrated(uncertain), poses)
    assert left[MEASURED].value == pytest.approx(expected["as manufactured"].value, rel=5e-3)
    assert left[MEASURED].value != pytest.approx(left["as manufactured"].value, rel=0.02)
    assert MEASURED not in remaining_rms(Z_ARM, poses)
    found = lostmotion.study(Z_ARM.calibrated(calibration), poses=64, robots=32, visits=2)
    groups = [group for section in found.sheet.sections for group in getattr(section, "bars", ())]
    groups += getattr(found.sheet, "bars", ())
    bars = [bar.label for group in groups for bar in group.bars]
    assert MEASURED in bars
    assert found.plots


def test_halving_one_part_leaves_what_its_budget_states():
    """The r.m.s. error with one part halved follows from its own and its shared mean square."""
    calibrated = Z_ARM.calibrated(calibration_of(Z_ARM))
    q = sample_poses(Z_ARM, 16).q
    matrix, found = pose_matrix(calibrated, q), tally(calibrated, q)
    owner = max(zip(found.own, found.owners, strict=True))[1]
    at = found.owners.index(owner)
    halves = np.array([0.5 if info.owner == owner else 1.0 for info in matrix.infos])
    expected = found.total - found.shared[at].sum() + found.own[at] / 4
    assert matrix.mean_squares(halves).sum() == pytest.approx(expected, rel=1e-9)


def test_a_run_draws_robots_from_the_estimates():
    """The mean square of a run equals the exact one; so do the draws by which columns are checked:
    their means are zero and their covariance is P.
    """
    calibration = calibration_of(Z_ARM)
    calibrated = Z_ARM.calibrated(calibration)
    poses = sample_poses(Z_ARM, 64)
    sampled = run(calibrated, poses, 4000, 2, 3)
    whole = analytic(calibrated, poses).mean_square
    assert np.mean(sampled.per_pose[:, kernel.MEAN_SQUARE]) == pytest.approx(
        np.mean(whole), rel=0.02
    )

    matrix = pose_matrix(calibrated, poses.q[:1])
    robots = np.arange(20_000)
    draws = exact.draws_of(matrix, 0, 3, 0, robots, np.zeros(len(robots), int))
    columns = {
        info.robot.name: draws[k]
        for k, info in enumerate(matrix.infos)
        if info.robot is not None and info.visit is None and info.closing is None
    }
    phases = {Sine: " sine", Cosine: " cosine"}
    names = [name + phases.get(type(law), "") for name, law in calibration.streams]
    rows = [k for k, name in enumerate(names) if name in columns]
    deviations = np.sqrt(np.diag(calibration.covariance))
    correlation = calibration.covariance / np.outer(deviations, deviations)
    found = np.cov([columns[names[k]] for k in rows])
    assert np.abs(found - correlation[np.ix_(rows, rows)]).max() < 0.05


def test_quantiles_equal_those_of_robots_drawn_by_numpy():
    """Mean and 95th percentile at a pose equal those of 100 000 errors from N(theta, P), plays with
    a correlated size included.
    """
    calibration = calibration_of(Z_ARM, 0.8)
    calibrated = Z_ARM.calibrated(calibration)
    q = sample_poses(Z_ARM, 8).q[:4]
    matrix = pose_matrix(Z_ARM, q)
    row = {stream: k for k, stream in enumerate(calibration.streams)}
    # of so many the mean varies by 0.2 %, the percentile by 0.3 %
    count, rng = 100_000, np.random.default_rng(1)
    theta = rng.multivariate_normal(calibration.mean, calibration.covariance, count).T
    visit, friction = {}, {}
    errors = np.zeros((len(q), 3, count))
    for k, info in enumerate(matrix.infos):
        draw = np.ones(count)
        if info.robot is not None:
            draw = draw * theta[row[info.robot.name, info.robot.law]]
        if info.visit is not None:
            name = info.visit.name, info.visit.law
            if info.visit.name not in visit:
                visit[info.visit.name] = rng.random(count)
            draw = draw * info.visit.law.quantile(visit[name[0]])
        draw = np.broadcast_to(draw, (len(q), count))
        if info.closing is not None:
            name = info.closing.stream.name
            u = friction.setdefault(name, rng.random(count))
            closed = matrix.closed[info.closing.row][:, None]
            c = np.where((closed > 0) & (closed < 1), closed, 0.5)
            z = np.where(u <= closed, 1 - c, -c) / np.sqrt(c * (1 - c))
            draw = draw * z * ((closed > 0) & (closed < 1))
        errors += matrix.tool[:, 3:, k][:, :, None] * draw[:, None]
    sizes = np.linalg.norm(errors, axis=1)
    found = analytic(calibrated, q, levels=(0.5, 0.95))
    np.testing.assert_allclose(found.mean, sizes.mean(axis=1), rtol=0.01)
    np.testing.assert_allclose(
        found.quantiles, np.quantile(sizes, [0.5, 0.95], axis=1).T, rtol=0.015
    )
    sampled = run(calibrated, sample_poses(Z_ARM, 8), 20_000, 1, 3)
    assert np.mean(sampled.per_pose[:4, kernel.MEAN]) == pytest.approx(np.mean(sizes), rel=0.02)


def test_a_calibration_that_equals_the_prior_changes_no_mean_square():
    """Estimates of mean zero and of the deviation that the file states are the arm as stated."""
    streams = known_streams(Z_ARM.terms)
    prior = Calibration(streams, np.zeros(len(streams)), np.eye(len(streams)))
    q = sample_poses(Z_ARM, 64).q
    np.testing.assert_allclose(
        analytic(Z_ARM.calibrated(prior), q).mean_square, analytic(Z_ARM, q).mean_square, rtol=1e-12
    )


def test_exact_estimates_leave_no_scatter_between_robots():
    """Where every draw is known exactly, all robots are this one: its error is known."""
    streams = known_streams(Z_ARM.terms)
    known = Calibration(
        streams, np.random.default_rng(8).normal(size=len(streams)), np.zeros((len(streams),) * 2)
    )
    calibrated = Z_ARM.calibrated(known)
    assert not any(of.term.robot for of in calibrated.terms)
    bias, covariance = bias_and_covariance(Z_ARM, known, sample_poses(Z_ARM, 8).q)
    found = analytic(calibrated, sample_poses(Z_ARM, 8).q)
    np.testing.assert_allclose(found.bias, bias, atol=SETTLED * np.abs(bias).max())
    np.testing.assert_allclose(found.covariance, covariance, rtol=1e-9, atol=1e-18)


def test_a_singular_covariance_ties_its_draws_together():
    """Two estimates with correlation one are one unknown."""
    streams = known_streams(Z_ARM.terms)[:2]
    tied = Calibration(streams, np.zeros(2), np.array([[0.04, 0.06], [0.06, 0.09]]))
    factor = tied.correlations.factor
    np.testing.assert_allclose(factor @ factor.T, np.ones((2, 2)), rtol=1e-12)


def test_changes_between_calibrated_arms_add_up():
    """Contributions of parts add to the change of the mean square: from stated to calibrated, and
    from one payload to another with the same estimates.
    """
    calibrated = Z_ARM.calibrated(calibration_of(Z_ARM))
    heavier = calibrated.with_payload(calibrated.payload.model_copy(update={"mass": 9.0}))
    q = sample_poses(Z_ARM, 16).q
    for before, after in ((Z_ARM, calibrated), (calibrated, heavier)):
        ((changes,),) = budget_changes(before, after, q, [LABELS["part"]])
        expected = np.mean(analytic(after, q).mean_square - analytic(before, q).mean_square)
        assert sum(changes.values()) == pytest.approx(expected, rel=1e-8)


def test_a_calibrated_arm_has_no_worst_case():
    """What remains uncertain of an estimate is normal without a limit; three deviations count in
    the root-sum-square.
    """
    calibrated = Z_ARM.calibrated(calibration_of(Z_ARM))
    found = bounds(pose_matrix(calibrated, sample_poses(Z_ARM, 8).q))
    assert np.isinf(found.worst_case).all()
    assert np.isfinite(found.root_sum_square).all()
