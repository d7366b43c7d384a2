"""examples/planar-2r.toml against its closed form, which shares no code with the package."""

from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.propagation.montecarlo import kernel

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "wind-up, joint zeros and lengths of a planar arm",
        (
            "the closed form of [`planar-2r.toml`](../examples/planar-2r.toml), bias and mean "
            "square at 256 poses; 2 000 simulated robots"
        ),
        "7e-13 m and 1e-9; 3.6 %, three standard errors",
    ),
)

FILE = Path(__file__).parents[2] / "examples" / "planar-2r.toml"
ARCMIN = np.pi / 180 / 60
L1, L2, MASS, GRAVITY = 0.4, 0.3, 2.0, 9.80665
K1, K2 = 8 / ARCMIN, 4 / ARCMIN
ZERO, LENGTH = 1 * ARCMIN, 60e-6
# Variance of a normal distribution that is cut at three standard deviations: 1 - 2 x 3 phi(3) / (2
# Phi(3) - 1).
CUT = 1 - 6 * 0.00443184841193801 / 0.99730020393674


@pytest.fixture(scope="module")
def study():
    """Return a study of the example."""
    return lostmotion.study(lostmotion.read(FILE), 256, robots=2000, visits=2)


def lever_arms(q):
    """Return the tool from the first and from the second joint (pose, 2), x and z, at joint angles
    (pose, 2).
    """
    a, b = q[:, 0], q[:, 0] + q[:, 1]
    wrist = L2 * np.column_stack([np.cos(b), np.sin(b)])
    return wrist + L1 * np.column_stack([np.cos(a), np.sin(a)]), wrist


def bias_and_variance(q):
    """Return the exact displacement of the tool by the load (pose, 2), x and z, and the variance of
    the rest about the arm so loaded, at joint angles (pose, 2).
    """
    stands = q.copy()
    for _ in range(20):  # each round leaves about m g l / k, 2e-4, of the one before
        whole, wrist = lever_arms(stands)
        wound = np.column_stack([whole[:, 0] / K1, wrist[:, 0] / K2]) * MASS * GRAVITY
        stands = q - wound  # a load turns the links down
    whole, wrist = lever_arms(stands)
    bias = whole - lever_arms(q)[0]
    arms = (whole**2).sum(axis=1) + (wrist**2).sum(axis=1)
    return bias, CUT / 9 * (ZERO**2 * arms + 2 * LENGTH**2)


def test_the_mean_square_error_is_the_closed_form(study):
    """Wind-up under the payload, zeros and lengths add up as on paper: exactly where it is summed,
    and within sampling where it is drawn.
    """
    bias, variance = bias_and_variance(study.poses.q)
    # The arm settles to within 1e-9 of its wind-up, at most 1e-12 rad, at the end of 0.7 m.
    np.testing.assert_allclose(study.sampled.bias[:, [3, 5]], bias, rtol=0, atol=7e-13)
    assert study.sampled.tally.total / study.sampled.tally.poses == pytest.approx(
        ((bias**2).sum(axis=1) + variance).mean(), rel=1e-9
    )
    drawn = study.sampled.per_pose[:, kernel.MEAN_SQUARE]
    # The mean of 2 000 robots is known to 2 |bias| x 70 µm / sqrt(2000), about 1.2 % of the mean
    # square: three times that.
    assert drawn.mean() == pytest.approx(((bias**2).sum(axis=1) + variance).mean(), rel=0.036)


def test_nothing_differs_between_visits(study):
    """Every visit of a robot finds the same zeros, lengths and load, so the repeatability is zero
    however its joints arrive.
    """
    found = study.result()["figures"]["iso9283"]
    assert [found[f"{key}_p95"]["value"] for key in ("rp_iso", "rp_any")] == [0, 0]
