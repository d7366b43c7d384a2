"""How much a load changes the stiffness of a closed chain: a hexapod, leg by leg in closed form."""

import numpy as np
import pytest

from lostmotion.mechanism.closed_loads import load_remarks, load_share
from tests.arms import arm_of
from tests.mechanism.closed_chains import at, hexapod, hexapod_legs

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "share of the stiffness of a hexapod that its load takes away, t/(k l)",
        "geometric stiffness of its six legs beside that of their drives, in closed form",
        "order of magnitude",
        "mechanism/closed_loads.py",
    ),
)
STIFFNESS = 20e6


def test_the_load_of_a_hexapod_changes_its_stiffness_by_the_tension_of_a_leg():
    """20 kg on legs of 20 N/µm: a few millionths, as the legs' geometric stiffness has it along the
    direction in which it counts most.
    """
    centre, tilt = (0.02, 0.03, 0.5), 0.1
    legs = hexapod_legs(centre, tilt)
    state = at(hexapod("20 N/um"), legs)
    (share,) = load_share(state)
    c, s = np.cos(tilt), np.sin(tilt)
    turned = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    elastic, geometric = np.zeros((6, 6)), np.zeros((6, 6))
    for k, length in enumerate(legs):
        base, top = (
            radius * np.array([np.cos(angle), np.sin(angle), 0.0])
            for radius, angle in (
                (0.4, np.radians(120 * (k // 2) + (15 if k % 2 else -15))),
                (0.25, np.radians(120 * (k // 2) + (45 if k % 2 else -45))),
            )
        )
        arm = turned @ top
        along = (np.array(centre) + arm - base) / length
        x, y, z = arm
        lever = np.hstack([-np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]), np.eye(3)])
        row = along @ lever
        elastic += STIFFNESS * np.outer(row, row)
        tension = -state.torques[0, k]
        geometric += tension / length * lever.T @ (np.eye(3) - np.outer(along, along)) @ lever
    exact = np.abs(np.linalg.eigvals(np.linalg.solve(elastic, geometric))).max()
    assert share == pytest.approx(np.abs(state.torques).max() / STIFFNESS / 0.4, rel=1e-6)
    assert 0.1 < share / exact < 10
    assert 1e-6 < share < 1e-5


def test_an_open_chain_has_no_such_note():
    """In a serial arm the loads act where it stands: nothing is neglected."""
    assert load_remarks(arm_of(2)) == ()
    (note,) = load_remarks(hexapod("20 N/um"))
    assert "t/(k l)" in note
