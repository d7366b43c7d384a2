"""Calibration of an arm that droops."""

from __future__ import annotations

import numpy as np
from scipy.optimize import root

from lostmotion.calibration.model import model_of
from tests.mechanism.test_equilibrium import balance, described, random_arm

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "calibration of a soft arm: tool of a robot with zero offsets, and its derivatives",
        "an independent force balance with the offsets, solved by SciPy",
        "1e-8 m; 1e-5",
        "calibration/model.py",
    ),
)


def test_a_model_of_a_soft_robot_has_its_tool_where_forces_balance():
    """The tool of a robot with zero offsets of up to a degree is that of an independent balance,
    centimetres from the command; so are its derivatives by the offsets.
    """
    drawn = random_arm(30, 3, 3.0)
    q = np.random.default_rng(3).uniform(-2, 2, (2, 3))
    model = model_of(described(drawn, errors=True), q)
    zeros = [k for k, each in enumerate(model.streams) if each.name.endswith("encoder.zero")]
    of = [np.flatnonzero(model.of == k)[0] for k in zeros]
    unit = np.zeros((3, 2, 6))  # twists of seats and tips per draw
    unit[range(3), 0] = model.matrix.local[0][:, of].T
    draws = np.zeros(len(model.streams))
    draws[zeros] = [160.0, -140.0, 150.0]  # of standardised draws
    assert np.degrees(np.abs(unit[:, 0, :3]).max(axis=1) * np.abs(draws[zeros])).min() > 0.5

    def tool(command: np.ndarray, offsets: np.ndarray) -> np.ndarray:
        twists = (offsets[:, None, None] * unit).ravel()
        solved = root(lambda e: balance(drawn, command, e)[0] - twists, np.zeros(36), tol=1e-14)
        return balance(drawn, command, solved.x)[1][:3, 3]

    found = model.frames(draws)[:, :3, 3]
    for pose, command in enumerate(q):
        np.testing.assert_allclose(found[pose], tool(command, draws[zeros]), atol=1e-8)
        for joint, stream in enumerate(zeros):
            step = np.eye(3)[joint]
            shift = (tool(command, step) - tool(command, -step)) / 2
            size = np.linalg.norm(shift)
            np.testing.assert_allclose(model.columns[pose, 3:, stream], shift, atol=1e-5 * size)
