"""Reachable cells of a five-bar against two circles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model.trust import trusted
from lostmotion.maps.gain import gain_by_cell
from lostmotion.maps.reach import reachable_cells
from lostmotion.mechanism.assembly import assembled
from lostmotion.mechanism.state import state_of
from tests.mechanism.closed_chains import five_bar

EDGE = 0.02
FIVE_BAR = Path(__file__).parents[2] / "examples" / "closed-chains" / "five-bar.toml"


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


def test_a_map_has_no_cell_where_first_order_fails(tmp_path):
    """Poses of rods of uncertain length that are nearly in line have no figure: the map has neither them
    nor the cells that have no others.
    """
    text = FIVE_BAR.read_text().replace("400 mm ± 30 µm", "300 mm ± 8 mm")
    (tmp_path / "vague.toml").write_text(text)
    vague = lostmotion.read(tmp_path / "vague.toml")
    found = reachable_cells(vague, 256, 0.02, 1, 1)
    assert trusted(vague, found.q).all()
    assert (found.counts[found.centre] > 0).all()
    (tmp_path / "known.toml").write_text(text.replace("± 8 mm", "± 30 µm"))
    known = reachable_cells(lostmotion.read(tmp_path / "known.toml"), 256, 0.02, 1, 1)
    assert found.centre.sum() < known.centre.sum()


def test_the_gain_of_a_cell_is_how_far_small_errors_of_the_drives_move_the_tool():
    """By differences of exact positions, over that at home; where the rods are nearly in line it is
    largest. An open chain has none.
    """
    arm, size = five_bar(), 0.4
    reached = reachable_cells(arm, 256, 0.05, 1, 1)
    gain = gain_by_cell(arm, reached)

    def largest(q):
        columns = []
        for step in 1e-6 * np.eye(2):
            low, high = (state_of(arm, (q + side * step)[None]).frames[-1, 0] for side in (-1, 1))
            turned = high[:3, :3] @ low[:3, :3].T
            spin = np.array([turned[2, 1], turned[0, 2], turned[1, 0]])
            columns.append(np.append(spin, (high[:3, 3] - low[:3, 3]) / size) / 2e-6)
        return np.linalg.norm(np.array(columns), 2)

    home = largest(arm.home)
    chosen = np.unique(reached.cell)[::7]
    for cell in chosen:
        found = max(largest(q) for q in reached.q[reached.cell == cell]) / home
        assert gain.ravel()[cell] == pytest.approx(found, rel=1e-6)
    assert np.isnan(gain.ravel()[np.setdiff1d(np.arange(gain.size), reached.cell)]).all()
    assert np.nanmax(gain) > 1.5 > np.nanmin(gain)
    assert gain_by_cell(lostmotion.read(FIVE_BAR.parents[1] / "planar-2r.toml"), reached) is None


def test_a_map_of_a_closed_chain_shows_its_gain():
    """As a slice beside that of the error, a row of its table, and an array."""
    found = lostmotion.map(FIVE_BAR, poses=256, cell="40 mm", per_cell=2)
    assert [plot.key for plot in found.plots].count("gain-xy") == 1
    rows = [row.label for section in found.sheet.sections for row in section.rows]
    assert "largest gain over that at home" in rows
    assert found.arrays()["gain"].attrs["units"] == "1"
