"""Rungs that some measurements open: compliance by two payloads, drift by the time of each row."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import lostmotion
from lostmotion.calibration.drift import drifting
from lostmotion.calibration.instruments import MeasuredVisits, Points
from lostmotion.calibration.ladder import COMPLIANCE, DRIFT, climb
from lostmotion.calibration.model import model_of
from lostmotion.calibration.robot import robot_of
from lostmotion.calibration.terms import Deviations, added_terms, is_compliance
from lostmotion.error_model.poses import sample_poses
from lostmotion.mechanism.state import state_of
from lostmotion.spatial import exp
from tests.calibration.ur5_grid import EXAMPLES

ARM = lostmotion.read(EXAMPLES / "six-axis.toml")
POSES, NOISE, SIZE = 20, 5e-5, 1e-5
Q = np.tile(sample_poses(ARM, 64, "sobol", 3).q[:POSES], (2, 1))
MASSES = np.repeat([0.0, 6.0], POSES)
# A row of docs/validation.md: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "compliance of a joint and drift, estimated from drawn robots",
        "the planted values; robots without them",
        "3 standard deviations; not estimated",
        "calibration/ladder.py calibration/drift.py",
    ),
)


@functools.cache
def under_two_payloads():
    """Return the model of the arm under two payloads, with compliances of the joints."""
    return model_of(ARM, Q, added_terms(ARM, Deviations(compliance=SIZE)), payload=MASSES)


def measured(seed: int, compliance: float = 0.0):
    """Return that model, and the tool points of a robot drawn from the prior whose joint 2 has
    this compliance in place of none, rad/(N m).
    """
    model = under_two_payloads()
    chance = np.random.default_rng(seed)
    draws = chance.normal(size=len(model.streams))
    draws[[is_compliance(owner) for owner in model.owners]] = 0.0
    draws[model.owners.index("joints.J2.compliance")] = compliance / SIZE
    points = model.frames(draws)[:, :3, 3]
    return model, points + chance.normal(0, NOISE, points.shape)


def rung(name: str, model, points, time=None):
    """Return one rung of the ladder, and the whole of it."""
    found = climb(model, Points(points), drift=drifting(Points(points), time), noise=NOISE)
    return next(each for each in found.rungs if each.name == name), found


def test_a_compliance_is_found_from_two_payloads():
    """Of a joint that yields by 10 µrad/(N m) more than its file states, within three standard
    deviations.
    """
    found, whole = rung(COMPLIANCE, *measured(1, 1e-5))
    assert found.kept
    at = whole.model.owners.index("joints.J2.compliance")
    deviation = np.sqrt(found.fit.covariance[at, at])
    assert found.fit.mean[at] == pytest.approx(1e-5 / SIZE, abs=3 * deviation)
    assert deviation < 0.1


def test_a_joint_that_yields_against_its_load_is_refused():
    """However well it predicts."""
    found, _ = rung(COMPLIANCE, *measured(1, -1e-4))
    assert "joints.J2.compliance is below zero" in found.reason


def test_one_payload_opens_no_compliance():
    """Deflection by the own weight resembles tilts and first harmonics."""
    _, points = measured(1, 1e-5)
    half = slice(0, 10)
    visits = MeasuredVisits(Q[half], point=points[half], payload=MASSES[half])
    found = robot_of(ARM, visits, noise=NOISE)
    assert COMPLIANCE not in [each.name for each in found.climb.rungs]
    assert DRIFT not in [each.name for each in found.climb.rungs]


def drifted(points: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Return points of a base that turns by 0.2 mrad about x and an arm that grows by 200 µm per
    metre, by homogeneous matrices.
    """
    out = []
    for point, t in zip(points, time - 0.5, strict=True):
        out.append((exp(t * np.array([2e-4, 0, 0, 0, 0, 0])) @ [*(point * (1 + t * 2e-4)), 1])[:3])
    return np.array(out)


def test_drift_is_found_by_the_time_of_the_rows():
    """Within three standard deviations, in an order of the rows by chance."""
    model, points = measured(1)
    time = np.random.default_rng(3).permutation(np.linspace(0, 1, len(points)))
    found, whole = rung(DRIFT, model, drifted(points, time), 3600 * time)
    assert found.kept
    names = list(whole.instrument.unknowns)
    for name, true in (("drift turn x", 2e-4), ("drift expansion", 2e-4), ("drift turn y", 0)):
        k = names.index(name)
        size, _ = whole.instrument.size(k)
        at = len(found.fit.mean) - len(names) + k
        deviation = size * np.sqrt(found.fit.covariance[at, at])
        assert size * found.fit.mean[at] == pytest.approx(true, abs=3 * deviation)
        assert deviation < 0.5 * size


@pytest.mark.parametrize("seed", [1, 2])
def test_neither_compliance_nor_drift_is_found_where_there_is_none(seed):
    """Of robots as stiff as their file states, measured over an hour."""
    model, points = measured(seed)
    drift, whole = rung(DRIFT, model, points, np.linspace(0, 3600, len(points)))
    assert not drift.kept
    assert not next(each for each in whole.rungs if each.name == COMPLIANCE).kept


def test_a_soft_arm_stands_under_each_payload():
    """The tool of its model is that of the arm with that payload."""
    arm = lostmotion.read(EXAMPLES / "printed-hobby-arm.toml")
    q = sample_poses(arm, 64, "sobol", 3).q[:6]
    model = model_of(arm, q, payload=np.array([0.05, 0.2] * 3))
    heavy = arm.with_payload(arm.payload.model_copy(update={"mass": 0.2}))
    for each, rows in ((arm, slice(0, None, 2)), (heavy, slice(1, None, 2))):
        expected = state_of(each, q[rows]).settled().frames[-1]
        found = model.frames(np.zeros(len(model.streams)))[rows]
        np.testing.assert_allclose(found, expected, atol=1e-6)
