"""Poses chosen for a calibration."""

from __future__ import annotations

import numpy as np

from lostmotion.calibration.choices import Asked
from lostmotion.calibration.fit import fit
from lostmotion.calibration.plan import plan
from tests.calibration.ur5_grid import grid_model


def test_chosen_poses_predict_better_than_random_ones():
    """Ten chosen rows of the UR5 grid leave less at the other rows than ten random ones, and the
    predicted radius falls with every pose.
    """
    model, measured = grid_model()
    chance = np.random.default_rng(4)
    prior = np.ones(len(model.streams))
    chosen_error, random_error = [], []
    for _ in range(3):
        some = chance.choice(1000, 300, replace=False)
        rest = np.setdiff1d(np.arange(1000), some)
        found = plan(model.rows(some), model.rows(rest), 10, np.diag(4 * prior), noise=7e-5)
        assert (np.diff(found.radius) < 0).all()
        assert len(set(found.chosen)) == 10
        for rows, errors in (
            (some[found.chosen], chosen_error),
            (chance.choice(some, 10, replace=False), random_error),
        ):
            robot = fit(model.rows(rows), measured.part(rows), Asked(prior, 7e-5))
            left = measured.measured[rest] - model.rows(rest).frames(robot.mean)[:, :3, 3]
            errors.append(np.linalg.norm(left, axis=1).mean())
    assert np.median(chosen_error) < np.median(random_error)
    assert np.median(chosen_error) < 0.16e-3


def test_the_prediction_is_the_posterior_of_the_chosen_poses():
    """The covariance after each pose equals that of the normal equations of these poses."""
    model, _ = grid_model()
    rows = np.arange(0, 1000, 10)
    part = model.rows(rows)
    prior = np.ones(len(model.streams))
    found = plan(part, part, 4, np.diag(prior), noise=7e-5)
    columns = part.columns[found.chosen, 3:].reshape(-1, len(prior)) / 7e-5
    after = np.linalg.inv(columns.T @ columns + np.diag(1 / prior))
    whole = part.columns[:, 3:]
    variance = np.einsum("pik,kl,pil->p", whole, after, whole).mean()
    before = np.einsum("pik,pik->p", whole, whole).mean()
    assert variance < before
    # 95 % of a normal vector are within 1.7 to 2.0 times its root mean square.
    assert 1.5 < found.radius[-1] / np.sqrt(variance) < 2.05
