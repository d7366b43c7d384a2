"""A measured arm: UR5, 1 000 poses of a laser tracker
(github.com/pauljac7700/serial_robots_datasets, UR5 grid set, MIT licence).
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.state import state_of, tool_points
from lostmotion.parts.joint import RevoluteJoint
from lostmotion.parts.link import Frame, Link

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "UR5 kinematics",
        "1 000 commanded positions of a laser-tracker set",
        (
            "0.4 µm mean with the two link offsets used for the data set (d1 89.16, d5 94.56 "
            "mm); 0.091 mm with the maker's 89.159 and 94.65, "
            "all of it along one axis"
        ),
        "mechanism/state.py",
    ),
)

GRID = Path(__file__).parents[2] / "examples" / "measured" / "ur5-grid.csv"

A = (0, -0.425, -0.39225, 0, 0, 0)
D = (0.089159, 0, 0, 0.10915, 0.09465, 0.0823)
ALPHA = (90, 0, 0, 90, -90, 0)
# What the commanded positions were calculated with, to go by how they fit.
AS_COMMANDED = (0.08916, 0, 0, 0.10915, 0.09456, 0.0823)


@pytest.fixture(scope="module")
def grid() -> np.ndarray:
    """Read the tracker's table."""
    return np.genfromtxt(GRID, delimiter=",", names=True)


def ur5(d: tuple[float, ...] = D, tool: tuple[float, float, float] = (0, 0, 0.031)) -> Arm:
    """Build a UR5 from a standard DH table, with a tool point seen from the flange."""
    links = [
        Link(tip=Frame(xyz=(a, 0, d_k), rpy=(math.radians(alpha), 0, 0)))
        for a, d_k, alpha in zip(A, d, ALPHA, strict=True)
    ]
    joints = [
        RevoluteJoint(name=f"J{k}", limits=(-7, 7), link=link) for k, link in enumerate(links, 1)
    ]
    return Arm(name="UR5", joints=joints, tool={"frame": {"xyz": tool}})


def joint_angles(grid: np.ndarray) -> np.ndarray:
    """Return the commanded joint angles (1000, 6), rad."""
    return np.radians(np.column_stack([grid[f"joint_{k}"] for k in range(1, 7)]))


def misses(grid: np.ndarray, arm: Arm) -> np.ndarray:
    """Return how the commanded positions lie beside where the arm's kinematics put the tool (1000,
    3), mm.
    """
    commanded = np.column_stack([grid[f"{axis}_t"] for axis in "xyz"])
    return commanded - state_of(arm, joint_angles(grid)).frames[-1, :, :3, 3] * 1000


def test_the_makers_table_leads_to_the_commanded_positions(grid: np.ndarray):
    """The maker's DH table and a 31 mm tool reproduce the commanded positions to 0.012 mm on
    average, if the tool may sit beside the axis.

    The offset that is left for the tool is 0.09 mm along its y, and nothing along x and z: the 31
    mm are right.
    """
    assert len(grid) == 1000
    off = misses(grid, ur5())
    turned = state_of(ur5(), joint_angles(grid)).frames[-1, :, :3, :3]
    beside = np.einsum("nij,ni->nj", turned, off).mean(axis=0)
    np.testing.assert_allclose(beside, [0, 0.09, 0], atol=0.002)
    tool = (beside[0] / 1000, beside[1] / 1000, 0.031 + beside[2] / 1000)
    assert np.linalg.norm(misses(grid, ur5(tool=tool)), axis=1).mean() < 0.012


def test_two_digits_of_the_table_are_swapped_in_the_data(grid: np.ndarray):
    """The commanded positions fit d5 = 94.56 mm, not the maker's 94.65, and d1 rounded to 89.16:
    then all agree to 0.4 µm, else to 0.09 mm.
    """
    assert np.linalg.norm(misses(grid, ur5(AS_COMMANDED)), axis=1).mean() < 0.4e-3
    assert np.linalg.norm(misses(grid, ur5()), axis=1).mean() == pytest.approx(0.091, abs=0.001)


def test_another_tool_length_would_show(grid: np.ndarray):
    """The agreement is not of the kind that anything reaches: a tool one hundredth of a millimetre
    longer is seen.
    """
    assert np.linalg.norm(
        misses(grid, ur5(AS_COMMANDED, (0, 0, 0.03101))), axis=1
    ).mean() == pytest.approx(0.01, abs=0.001)


def test_the_quick_way_to_the_tool_is_the_same(grid: np.ndarray):
    """On a thousand real poses the tool point found alone is the one found with all frames."""
    q = joint_angles(grid)
    np.testing.assert_allclose(
        tool_points(ur5(), q), state_of(ur5(), q).frames[-1, :, :3, 3], atol=1e-13
    )
