"""Compliance of belts, ball screws and racks: against chains of springs that are solved as one set
of equations, and against energy.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from lostmotion.laws.linear_drives import (
    STEEL,
    STEEL_SHEAR,
    belt_compliance,
    belt_stage_stiffness,
    rack_compliance,
    screw_compliance,
)

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "belts and ball screws whose length follows the travel",
        (
            "one set of equations of 300 and 120 pieces; torsion by energy; the study's bias and "
            "the compliance of the arm"
        ),
        "1e-9; 1e-9; 1e-4",
        "laws/linear_drives.py tests/parts/test_linear_axes.py",
    ),
)

INF = math.inf


def displacement(springs: list[tuple[int, int, float]], count: int, loaded: int) -> float:
    """Return the displacement of a loaded node under 1 N, of nodes 1 to `count` joined by springs
    (node, node, stiffness); node 0 is fixed.
    """
    matrix = np.zeros((count + 1, count + 1))
    for one, other, stiffness in springs:
        matrix[[one, other], [one, other]] += stiffness
        matrix[[one, other], [other, one]] -= stiffness
    return float(np.linalg.inv(matrix[1:, 1:])[loaded - 1, loaded - 1])


@pytest.mark.parametrize("near", [0.1, 0.8, 1.5, 2.7])
def test_a_carriage_on_a_belt_hangs_on_both_strands(near: float):
    """A belt of 300 equal pieces from the drive pulley round the idler and back holds a carriage as
    the two strands in parallel do.
    """
    length, tension, pieces = 3.0, 450e3, 300
    stiffness = tension * pieces / length
    nodes = [0, *range(1, pieces), 0]
    springs = [(one, other, stiffness) for one, other in itertools.pairwise(nodes)]
    expected = displacement(springs, pieces - 1, round(near / length * pieces))
    assert belt_compliance(np.array(near), length, tension) == pytest.approx(expected, rel=1e-9)


def test_a_belt_is_softest_in_the_middle():
    """There both strands are equal, k = 4 EA/L, as the maker's paper states."""
    at = np.linspace(0.1, 2.9, 29)
    found = belt_compliance(at, 3.0, 450e3)
    assert at[found.argmax()] == pytest.approx(1.5)
    assert found.max() == pytest.approx(3.0 / (4 * 450e3))


def test_a_belt_stage_stores_the_energy_of_its_strands():
    """Turned by an angle, one strand is longer by r x angle and the other shorter: the energy is
    that of the torsional spring.
    """
    strand, radius, tension, angle = 0.3, 0.04, 450e3, 1e-3
    energy = 2 * 0.5 * tension / strand * (radius * angle) ** 2
    assert belt_stage_stiffness(strand, radius, tension) == pytest.approx(2 * energy / angle**2)


@pytest.mark.parametrize("both", [False, True], ids=["fixed-free", "fixed-fixed"])
@pytest.mark.parametrize("at", [0.05, 0.3, 0.55])
def test_a_ball_screw_is_its_bearings_its_shaft_and_its_nut(both, at):
    """A shaft of 120 pieces between its bearings, solved as one set of equations, gives the same
    displacement of the nut.
    """
    length, diameter, nut, bearing, pieces = 0.6, 0.017, 2e8, 1e8, 120
    piece = STEEL * math.pi * diameter**2 / 4 * pieces / length
    shaft = [(k, k + 1, piece) for k in range(1, pieces + 1)]
    ends = [(0, 1, bearing), *([(0, pieces + 1, bearing)] if both else [])]
    place = 1 + round(at / length * pieces)
    expected = displacement([*shaft, *ends, (place, pieces + 2, nut)], pieces + 2, pieces + 2)
    far = bearing if both else None
    found = screw_compliance(
        np.array(at), length, diameter, lead=None, nut=nut, near_bearing=bearing, far_bearing=far
    )
    assert found == pytest.approx(expected, rel=1e-9)


def test_the_torsion_of_a_screw_counts_by_its_energy():
    """A thrust F turns the shaft with F p/2π; the work of F on the nut is the energy of the
    torsion.
    """
    at, diameter, lead, thrust = 0.4, 0.015, 0.02, 1000.0
    torque = thrust * lead / (2 * math.pi)
    energy = torque**2 * at / (2 * STEEL_SHEAR * math.pi * diameter**4 / 32)
    rigid, soft = (
        screw_compliance(
            np.array(at), 1.0, diameter, lead=each, nut=INF, near_bearing=INF, far_bearing=None
        )
        for each in (None, lead)
    )
    assert thrust * (soft - rigid) * thrust / 2 == pytest.approx(energy)


def test_a_pinion_turns_its_torsion_into_travel():
    """F r on the drive turns it by F r/k, which is F r²/k along the rack."""
    assert rack_compliance(0.03, 3e4) == pytest.approx(0.03 * (0.03 / 3e4))
