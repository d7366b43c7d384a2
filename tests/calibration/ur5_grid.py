"""The measured UR5 of examples/measured: commanded joints and attained positions."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np

from lostmotion.calibration.instruments import Points
from lostmotion.calibration.model import RobotModel, model_of
from lostmotion.calibration.terms import Deviations, added_terms
from lostmotion.io import read

EXAMPLES = Path(__file__).parents[2] / "examples"
GRID = EXAMPLES / "measured" / "ur5-grid.csv"
ARM = EXAMPLES / "calibration" / "ur5.toml"


@functools.cache
def grid_model(orders: int = 0) -> tuple[RobotModel, Points]:
    """Return the model of the arm at the 1 000 poses of the grid, and what was measured there."""
    table = np.genfromtxt(GRID, delimiter=",", names=True)
    q = np.radians(np.column_stack([table[f"joint_{k}"] for k in range(1, 7)]))
    beside = np.column_stack([table[f"{axis}_dif"] for axis in "xyz"]) / 1000
    arm = read(ARM)
    model = model_of(arm, q, added_terms(arm, Deviations(orders=orders)))
    return model, Points(model.matrix.state.frames[-1, :, :3, 3] - beside)


def mean_error(rows: np.ndarray, model: RobotModel, measured: Points, draws: np.ndarray) -> float:
    """Return the mean error (mm) at all poses of the grid but these."""
    others = np.setdiff1d(np.arange(len(model)), rows)
    predicted = model.rows(others).frames(draws)[:, :3, 3]
    return 1000 * float(np.linalg.norm(measured.measured[others] - predicted, axis=1).mean())
