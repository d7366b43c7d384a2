"""Posterior and evidence against other methods, and robots drawn from their own prior."""

from __future__ import annotations

import numpy as np
import pytest

from lostmotion.calibration import evidence
from lostmotion.calibration.choices import STUDENT, Asked, EvidenceChoices
from lostmotion.calibration.fit import fit, linearised
from lostmotion.calibration.instruments import Points
from lostmotion.calibration.terms import is_frame
from tests.calibration.ur5_grid import grid_model

NOISE = 7e-5
# A row of docs/validation.md: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "Posterior and evidence of a calibration",
        "one measurement after another (Kalman), SciPy's density of the whole measurement",
        "1e-10; 1e-9",
        "calibration/evidence.py",
    ),
    (
        "Most probable errors with Student-t priors",
        "SciPy's maximum of the log posterior with its density, UR5 at 20 poses",
        "1e-6 of the prior deviations",
        "calibration/choices.py",
    ),
)


def some_rows() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return whitened columns, values and prior variances."""
    chance = np.random.default_rng(1)
    return chance.normal(size=(40, 12)), chance.normal(size=40) * 3, chance.uniform(0.2, 4, 12)


def test_posterior_equals_one_measurement_after_another():
    """The Kalman update by each row in turn has the same mean and covariance to 1e-10."""
    columns, values, variances = some_rows()
    found = evidence.posterior(evidence.NormalEquations.of(columns, values, 0.0), variances)
    mean, covariance = np.zeros(12), np.diag(variances)
    for row, value in zip(columns, values, strict=True):
        gain = covariance @ row / (row @ covariance @ row + 1)
        mean = mean + gain * (value - row @ mean)
        covariance = covariance - np.outer(gain, row @ covariance)
    np.testing.assert_allclose(found.mean, mean, atol=1e-10)
    np.testing.assert_allclose(found.covariance, covariance, atol=1e-10)


def test_the_fit_ends_where_one_measurement_after_another_does():
    """Of the exact robot, the Kalman update by each row of the equations linearised at the
    estimates has them as its mean to 1e-10 deviations.
    """
    model, measured = grid_model()
    rows = np.arange(0, 1000, 50)
    part, seen = model.rows(rows), measured.part(rows)
    found = fit(part, seen, Asked(np.ones(len(model.streams)), NOISE))
    residual, columns, _ = linearised(part, seen, found.mean)
    columns = columns.reshape(residual.size, -1)
    mean, covariance = np.zeros(columns.shape[1]), np.diag(found.variances)
    for row, value in zip(columns, residual.ravel() + columns @ found.mean, strict=True):
        gain = covariance @ row / (row @ covariance @ row + NOISE**2)
        mean = mean + gain * (value - row @ mean)
        covariance = covariance - np.outer(gain, row @ covariance)
    np.testing.assert_allclose(found.mean, mean, atol=1e-10)


def test_evidence_is_the_normal_density_of_the_measurement():
    """The log evidence equals that of SciPy for the whole covariance of the rows, and the gain of a
    wider prior is the difference of two of them.
    """
    from scipy.stats import multivariate_normal

    columns, values, variances = some_rows()
    data = evidence.NormalEquations.of(columns, values, 0.0)

    def direct(prior: np.ndarray) -> float:
        covariance = columns * prior @ columns.T + np.eye(40)
        return float(multivariate_normal(np.zeros(40), covariance).logpdf(values))

    assert evidence.log_evidence(data, variances) == pytest.approx(direct(variances), abs=1e-9)
    found = evidence.posterior(data, variances)
    assert found.evidence == pytest.approx(direct(variances), abs=1e-9)
    gains = evidence.release_gains(found, variances, np.full(12, 16.0))
    for k in range(12):
        wider = variances.copy()
        wider[k] *= 256
        assert gains[k] == pytest.approx(direct(wider) - direct(variances), abs=1e-9)


def drawn(count: int, poses: int, faults: tuple[str, ...] = ()):
    """Yield robots drawn from the prior of the UR5: true draws, poses and the fit to them, with
    errors of 20 deviations where a part is at fault.
    """
    model, _ = grid_model()
    chance = np.random.default_rng(8)
    names = [stream.name for stream in model.streams]
    for _ in range(count):
        rows = np.sort(chance.choice(1000, poses, replace=False))
        draws = chance.normal(size=len(names))
        for name in faults:
            draws[names.index(name)] = 20.0
        part = model.rows(rows)
        seen = part.frames(draws)[:, :3, 3] + chance.normal(0, NOISE, (poses, 3))
        yield draws, part, fit(part, Points(seen), Asked(np.ones(len(names)), NOISE))


@pytest.mark.parametrize(
    "pair",
    [
        ("joints.J4.seat.tilt 2", "joints.J2.link.tip offset x"),
        ("joints.J3.seat.tilt 1", "joints.J5.seat.tilt 2"),
        ("joints.J4.encoder.zero", "joints.J3.link.tip offset x"),
    ],
)
def test_two_planted_faults_are_found(pair):
    """Two errors of 20 deviations are released by 25 poses, and no other."""
    for draws, part, found in drawn(1, 25, pair):
        names = [stream.name for stream in part.streams]
        assert {names[each.draw] for each in found.released} == set(pair)
        for name in pair:
            at = names.index(name)
            assert found.mean[at] == pytest.approx(draws[at], abs=3)


@pytest.mark.slow
def test_estimates_are_within_their_intervals():
    """Of robots drawn from the prior 93 to 97 % of the estimates are within their 95 % intervals,
    and hardly any error is released.
    """
    inside, released = [], 0
    for draws, part, found in drawn(60, 20):
        deviation = np.sqrt(np.diag(found.covariance))
        robot = np.array([not is_frame(owner) for owner in part.owners])
        inside.append((np.abs(found.mean - draws) <= 1.96 * deviation)[robot].mean())
        released += len(found.released)
    assert 0.93 <= np.mean(inside) <= 0.97
    assert released <= 2


def test_a_student_prior_has_the_most_probable_values_of_its_density():
    """Reweighted normal priors end where SciPy's maximum of the log posterior with its Student-t
    density is, to 1e-6 of the prior deviations.
    """
    from scipy.optimize import minimize
    from scipy.stats import norm, t

    model, measured = grid_model()
    rows = np.arange(0, 1000, 50)
    part, seen = model.rows(rows), measured.part(rows)
    asked = Asked(np.ones(len(model.streams)), NOISE, student=True)
    residual, columns, _ = linearised(part, seen, np.zeros(len(model.streams)))
    columns, values = columns.reshape(-1, len(model.streams)) / NOISE, residual.ravel() / NOISE
    data = evidence.NormalEquations.of(columns, values, 0.0)
    choices = EvidenceChoices(part, asked)
    choices.reweigh(data)
    found = evidence.posterior(data, choices.variances).mean
    robot = np.array([not is_frame(owner) for owner in part.owners])

    def cost(x):
        fitted = norm.logpdf(values - columns @ x).sum()
        return -(fitted + t.logpdf(x[robot], STUDENT).sum() + norm.logpdf(x[~robot]).sum())

    def slope(x):
        heavy = (STUDENT + 1) * x / (STUDENT + x**2)
        return columns.T @ (columns @ x - values) + np.where(robot, heavy, x)

    def curvature(x):
        heavy = (STUDENT + 1) * (STUDENT - x**2) / (STUDENT + x**2) ** 2
        return columns.T @ columns + np.diag(np.where(robot, heavy, 1.0))

    start = evidence.posterior(data, asked.variances).mean
    best = minimize(
        cost, start, jac=slope, hess=curvature, method="trust-exact", options={"gtol": 1e-9}
    )
    assert best.fun < cost(start) - 10
    np.testing.assert_allclose(found, best.x, atol=1e-6)
