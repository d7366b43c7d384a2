"""Reachable cells of a five-bar against two circles."""

from __future__ import annotations

import numpy as np

from lostmotion.analyses.workspace_map.reach import reachable_cells
from lostmotion.mechanism.assembly import assembled
from tests.mechanism.closed_chains import five_bar

EDGE = 0.02


def test_the_cells_of_a_five_bar_are_reached_as_two_circles_have_it():
    """At every pose both rods have their length, the tool is on the side of the elbows where it is
    at home, and no cell in the middle of the workspace is missing.
    """
    found = reachable_cells(five_bar(), 2048, EDGE, 2, 1)
    assert assembled(five_bar(), found.q).all()
    elbows = 0.25 * np.stack([np.cos(found.q), np.sin(found.q)], axis=2) + [[0, 0], [0.2, 0]]
    rods = found.points[:, None, :2] - elbows
    np.testing.assert_allclose(np.linalg.norm(rods, axis=2), 0.4, atol=1e-8)
    (ax, ay), (bx, by) = rods[:, 0].T, rods[:, 1].T
    assert (ax * by - ay * bx > 0).all()
    middle = np.array(
        [(x, y, 0.0) for x in np.arange(0.02, 0.2, EDGE) for y in np.arange(0.3, 0.5, EDGE)]
    )
    cells = found.grid.cell_numbers(middle)
    assert (cells >= 0).all()
    assert (found.counts.ravel()[cells] > 0).all()


def test_no_pose_of_a_map_is_near_a_parallel_singularity():
    """Coarse cells reach to where the rods are in line; their poses keep away from it."""
    arm = five_bar()
    assert assembled(arm, reachable_cells(arm, 256, 0.04, 1, 1).q).all()
