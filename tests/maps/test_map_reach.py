"""Reachable cells, corners and configurations of a map against the closed-form inverse kinematics
of an arm of three joints.
"""

import math

import numpy as np
import pytest

from lostmotion import Arm
from lostmotion.maps.configurations import distinct_configurations
from lostmotion.maps.placement import fully_reachable_cells
from lostmotion.maps.reach import reachable_cells

HEIGHT, UPPER, FORE = 0.2, 0.3, 0.2
LIMITS = np.radians([[-100, 140], [-30, 100], [-140, 140]])
EDGE = 0.05


def turret(**parts):
    """Return an arm that rotates about z, with two links in the vertical plane; `parts` of its
    joints by name.
    """
    axes, lengths = ("z", "-y", "-y"), (0.0, UPPER, FORE)
    joints = [
        {
            "name": name,
            "type": "revolute",
            "axis": axis,
            "limits": [f"{end} rad" for end in bounds],
            "link": {"length": f"{length} m"},
            **parts.get(name, {}),
        }
        for name, axis, length, bounds in zip("SAB", axes, lengths, LIMITS.tolist(), strict=True)
    ]
    joints[0]["origin"] = {"xyz": ["0 m", "0 m", f"{HEIGHT} m"]}
    return Arm.model_validate({"name": "turret", "joints": joints, "payload": {"mass": "3 kg"}})


def configurations(point):
    """Return the joint values within the limits that bring the tool there: forward or overhead,
    either elbow.
    """
    x, y, z = point[0], point[1], point[2] - HEIGHT
    out = []
    for turn, r in ((math.atan2(y, x), math.hypot(x, y)), (math.atan2(-y, -x), -math.hypot(x, y))):
        bend = (r * r + z * z - UPPER**2 - FORE**2) / (2 * UPPER * FORE)
        if abs(bend) > 1 + 1e-12:
            continue
        for elbow in {math.acos(np.clip(bend, -1, 1)), -math.acos(np.clip(bend, -1, 1))}:
            lean = math.atan2(z, r) - math.atan2(
                FORE * math.sin(elbow), UPPER + FORE * math.cos(elbow)
            )
            q = (np.array([turn, lean, elbow]) + math.pi) % (2 * math.pi) - math.pi
            if (q >= LIMITS[:, 0] - 1e-9).all() and (q <= LIMITS[:, 1] + 1e-9).all():
                out.append(q)
    return out


@pytest.fixture(scope="module")
def reached():
    """Map the arm's reach from few samples, three per cell."""
    return reachable_cells(turret(), 8000, EDGE, 8, 1)


def test_every_configuration_of_a_cell_is_found_once(reached):
    """Each cell centre has every existing configuration exactly once, except where two coincide."""
    cells = np.flatnonzero(reached.centre)
    middles = reached.grid.centres(cells)
    order = np.argsort(reached.cell, kind="stable")
    first, last = (np.searchsorted(reached.cell[order], cells, side) for side in ("left", "right"))
    compared = 0
    for cell, middle in enumerate(middles):
        rows, real = order[first[cell] : last[cell]], configurations(middle)
        mine = reached.q[rows]
        assert np.abs(reached.points[rows] - middle).max() < 1e-3 * EDGE
        if all(np.abs(a - b).max() > 0.05 for k, a in enumerate(real) for b in real[:k]):
            assert len(mine) == len(real)
            assert all(min(np.abs(a - b).max() for b in mine) < 5e-3 for a in real)
            compared += 1
    assert compared > 2400


def test_no_middle_or_corner_in_reach_is_missed(reached, monkeypatch):
    """The tool reaches every centre and corner that the closed form reaches, including the
    stretched arm, and no other.
    """
    everywhere = np.argwhere(np.ones(reached.grid.shape, bool))
    middles = reached.grid.low + EDGE * (everywhere + 0.5)
    assert np.array_equal(
        reached.centre.ravel(), [bool(configurations(middle)) for middle in middles]
    )
    from lostmotion.maps import placement

    calls = []
    plain = placement.solve_positions

    def listening(arm, found, wanted):
        calls.append((wanted, plain(arm, found, wanted)))
        return calls[-1][1]

    monkeypatch.setattr(placement, "solve_positions", listening)
    fully_reachable_cells(turret(), reached)
    ((corners, (_, solved)),) = calls
    assert np.array_equal(solved, [bool(configurations(corner)) for corner in corners])
    assert 2000 < solved.sum() < len(solved)


def test_what_counts_as_one_configuration():
    """Full turns and tiny differences do not count; poses are compared only within their cell."""
    q = np.array(
        [
            [0.1, 0.2, 0.3],
            [0.1 + 2 * math.pi, 0.2, 0.3],
            [0.1, 0.2, 0.35],
            [0.1, 0.2, 0.301],
            [0.1, 0.2, 0.3],
        ]
    )
    assert distinct_configurations(turret(), q, np.array([4, 4, 4, 4, 7]), EDGE).tolist() == [
        True,
        False,
        True,
        False,
        True,
    ]
    assert distinct_configurations(turret(), q[:0], np.zeros(0, int), EDGE).tolist() == []
