"""Positioning along and about each axis, as makers of positioners state it: play of a gantry in
closed form, and a hexapod beside the covariance of its visits.
"""

from pathlib import Path

import numpy as np
import pytest

from lostmotion import Arm
from lostmotion.error_model.expected_repeatability import visit_covariance
from lostmotion.error_model.pose_matrix import screws
from lostmotion.io import read
from lostmotion.laws.iso230 import APPROACHES, POSITIONS
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.iso9283 import cube as iso_cube
from lostmotion.propagation.iso9283.cube import cube_from_arguments
from lostmotion.propagation.iso9283.joint_motion import path_approach
from lostmotion.propagation.iso9283.robots import predict_robots

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "positioning of simulated robots by axis",
        "play of a gantry in closed form; normal scatter of the covariance of a hexapod's visits",
        "1e-9; 3 %",
        "laws/iso230.py propagation/iso9283/axes.py propagation/iso9283/experiment.py",
    ),
)

HEXAPOD = Path(__file__).parents[3] / "examples" / "closed-chains" / "hexapod.toml"


def gantry(**gearbox):
    """Return three sliding axes without other errors than those of their drives."""
    screw = {"lead": "10 mm", **gearbox}
    return Arm.model_validate(
        {
            "name": "gantry",
            "payload": {"mass": "1 kg"},
            "joints": [
                {
                    "name": axis,
                    "type": "prismatic",
                    "axis": axis,
                    "limits": (-0.3, 0.3),
                    "gearbox": {**screw, "backlash": f"{play} µm"},
                }
                for axis, play in (("x", 10), ("y", 20), ("z", 0))
            ],
        }
    )


def test_play_of_one_axis_is_its_reversal():
    """A gantry with 10 and 20 µm of play across gravity: reversal and accuracy equal the play of
    the axis alone, over a travel of 600 mm, and each side repeats without scatter.
    """
    arm = gantry()
    cube = cube_from_arguments(arm, np.zeros(3), 0.2)
    found = {each.axis: each for each in predict_robots(arm, cube, robots=20, loads=(1.0,)).axes}
    assert list(found) == ["x", "y", "z"]
    for axis, play in {"x": 10e-6, "y": 20e-6, "z": 0.0}.items():
        each = found[axis]
        assert each.travel == pytest.approx([-0.3, 0.3], abs=1e-3)
        assert each.positions == pytest.approx(np.linspace(-0.24, 0.24, POSITIONS), abs=1e-3)
        assert each.stated["reversal"] == pytest.approx(play, abs=1e-14)
        assert each.stated["accuracy"] == pytest.approx(play, abs=1e-14)
        assert each.stated["unidirectional repeatability"] == pytest.approx(0.0, abs=1e-14)


def test_a_hexapod_has_six_axes_whose_scatter_is_that_of_its_visits(monkeypatch):
    """Four standard deviations of five approaches, at the worst of five positions, average what
    normal scatter of the covariance from one side has; the tool turns about all axes as well.
    """
    monkeypatch.setattr(iso_cube, "SAMPLES", 2048)  # where the way to the centre may begin
    arm = read(HEXAPOD)
    cube = cube_from_arguments(arm, np.array([0.0, 0.0, 0.49]), 0.03)
    found = predict_robots(arm, cube, robots=400, cycles=2, path_points=2, loads=(1.0,))
    assert [each.axis for each in found.axes] == ["a", "b", "c", "x", "y", "z"]
    rng = np.random.default_rng(5)
    for each in found.axes:
        assert (np.abs(each.travel) > (np.radians(5) if each.turns else 0.02)).all()
        if each.turns:
            continue
        approach = path_approach(each.q, found.approach[0])
        covariance = visit_covariance(screws(state_of(arm, each.q), approach=approach))
        along = "xyz".index(each.axis)
        visits = rng.normal(size=(20_000, POSITIONS, APPROACHES))
        visits *= np.sqrt(covariance[:, along, along])[:, None]
        expected = 4 * visits.std(axis=-1, ddof=1).max(axis=1).mean()
        assert each.figures["R1"].mean() == pytest.approx(expected, rel=0.03)
        assert (each.figures["B"] > 0).all()
