"""The ± of an arm's temperature on clearances: one draw with the growth of the links, against arms
at other temperatures and simulated robots.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model.pose_matrix import screws
from lostmotion.error_model.poses import Poses
from lostmotion.mechanism.state import state_of
from lostmotion.parts.standard_terms import VARIATION
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.montecarlo import run
from lostmotion.sizing.error_cache import BIAS, COVARIANCE, ErrorCache
from tests.error_model.test_temperature import in_heat, some_poses
from tests.parts.test_cycloidal import drawing

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "the ± of a temperature on clearances",
        "arms at two temperatures; sizing against the pose matrix; simulated robots",
        "0.3 % (3 % with a drawn drive); 1e-9; 3 %",
    ),
)

SUN = "examples/arm-in-the-sun.toml"


@pytest.fixture(scope="module")
def arm() -> Arm:
    """Return an arm with drawn bearings in aluminium housings, and on its shoulder a drawn drive
    with steel pins in aluminium.
    """
    sun = lostmotion.read(SUN)
    found = drawing(relief={"roller": "10 µm"}, ring_expansion="23e-6 1/K")
    drive = found.model_copy(
        update={
            "rigid": (*found.bounded, "disc body", "ring body", "seat of the eccentric bearing")
        }
    )
    shoulder = sun.joints[1].model_copy(update={"gearbox": drive})
    return sun.model_copy(update={"joints": (sun.joints[0], shoulder, sun.joints[2])})


def of_temperature(arm: Arm, q: np.ndarray, varies: str) -> np.ndarray:
    """Return the displacement of the tool (pose, 3) per unit draw of the temperature alone."""
    matrix = screws(state_of(arm, q))
    (found,) = [
        members
        for draws, members in matrix.groups.items()
        if [draw for draw, _ in draws] == [(varies, "environment.temperature")]
    ]
    return np.asarray(matrix.tool[:, 3:, found].sum(axis=2))


@pytest.mark.parametrize("varies", ["robot", "visit"])
def test_a_draw_moves_the_tool_as_another_temperature_does(arm: Arm, varies: str):
    """Between two temperatures the bias changes as one draw says: links and clearances of bearings
    to 0.3 %, with the drive's play to 3 %.

    The wind-up of the drive is that at the nominal temperature: with the clearance, fewer or more
    of its lobes carry the load.
    """
    q = np.array([[0.3, 0.4, -0.6], [-1.0, 0.9, -1.2], [1.4, 0.1, -0.2]])
    for each, tolerance in ((lostmotion.read(SUN), 0.003), (arm, 0.03)):
        hot, cold = (
            screws(state_of(in_heat(each, f"{25 + shift} °C"), q)).bias[:, 3:]
            for shift in (1.0, -1.0)
        )
        per_kelvin = (hot - cold) / 2
        found = of_temperature(
            in_heat(each, "25 °C ± 1 K (uniform)", temperature_varies=varies), q, varies
        ) * np.sqrt(3)
        np.testing.assert_allclose(
            found, per_kelvin, rtol=0, atol=tolerance * np.abs(per_kelvin).max()
        )


@pytest.mark.parametrize("varies", ["robot", "visit"])
def test_the_cache_and_the_pose_matrix_agree_on_clearances(arm: Arm, varies: str):
    """Bias and covariance of the sizing cache are those of the pose matrix, with products of
    temperature and side of an open clearance.
    """
    q = some_poses(arm, 12)
    hot = in_heat(arm, "30 °C ± 6 K", temperature_varies=varies)
    sums, matrix = ErrorCache(arm, q).of(hot), screws(state_of(hot, q))
    np.testing.assert_allclose(sums[BIAS].T, matrix.bias[:, 3:], rtol=1e-9, atol=1e-15)
    drawn = matrix.merged.tool[:, 3:, matrix.merged.columns("robot", "visit", "robot x visit")]
    covariance = drawn @ drawn.transpose(0, 2, 1)
    pairs = np.stack(
        [covariance[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))]
    )
    np.testing.assert_allclose(sums[COVARIANCE], pairs, rtol=1e-9, atol=1e-9 * covariance.max())


@pytest.mark.parametrize("varies", ["robot", "visit"])
def test_simulated_robots_have_the_summed_error(arm: Arm, varies: str):
    """The mean-square error of simulated robots at 30 °C ± 10 K is that of the pose matrix."""
    hot, q = in_heat(arm, "30 °C ± 10 K", temperature_varies=varies), some_poses(arm, 12)
    found = run(hot, Poses(q, "given"), robots=3000, visits=4, seed=1)
    merged = screws(state_of(hot, q)).merged
    summed = (merged.bias[:, 3:] ** 2).sum() + merged.squares.sum(axis=1)[
        merged.columns("robot", "visit", "robot x visit")
    ].sum()
    assert found.per_pose[:, kernel.MEAN_SQUARE].sum() == pytest.approx(summed, rel=0.03)


def test_open_clearances_vary_from_robot_to_robot_only(arm: Arm):
    """The width of an open clearance at a robot's temperature is a product of two draws; from visit
    to visit it stays nominal.
    """
    names = {
        varies: {
            placed.name
            for placed in in_heat(arm, "30 °C ± 6 K", temperature_varies=varies).terms
            if VARIATION in placed.name
        }
        for varies in ("robot", "visit")
    }
    free = {name for name in names["robot"] if "free" in name}
    assert names["robot"] - free == names["visit"]
    assert any("backlash" in name for name in free)
    assert any("clearance position" in name for name in free)
    assert not any(VARIATION in placed.name for placed in in_heat(arm, "30 °C").terms)
