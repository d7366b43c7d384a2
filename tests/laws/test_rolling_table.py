"""The table of shifts against the solution in five degrees of freedom, for loads in any
direction.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from lostmotion.laws.rolling.equilibrium import shaft_equilibrium
from lostmotion.laws.rolling.radial import (
    BALL_EXPONENT,
    ball_stiffness,
    element_angles,
    radial_shift,
)
from lostmotion.laws.rolling.rows import BallRow, CrossedRow, RollerRow, RowSeat
from lostmotion.laws.rolling.table import Pair, ShiftTable, shift_table

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "bearing tables",
        "the solution in five degrees of freedom, loads in any direction",
        "2 to 9 % of the displacement",
        "laws/rolling/table.py",
    ),
)

UM = 1e-6
BALLS = BallRow(count=9, ball=12.7e-3, pitch=65e-3)
SPAN = 60e-3
ANGLE = math.radians(25)
ANGULAR = BallRow(count=13, ball=12.7e-3, pitch=65e-3, contact_angle=ANGLE)
DEEP = Pair((RowSeat(BALLS, -SPAN / 2), RowSeat(BALLS, SPAN / 2)), SPAN, axial=True)
BACK_TO_BACK = Pair(
    (
        RowSeat(ANGULAR, -SPAN / 2, preload_shift=5 * UM),
        RowSeat(ANGULAR, SPAN / 2, mirrored=True, preload_shift=5 * UM),
    ),
    SPAN + 65e-3 * math.tan(ANGLE),
    axial=True,
)
ROLLER = RollerRow(count=14, length=12e-3, roller=12e-3, pitch=70e-3, slices=12)
ROLLERS = Pair((RowSeat(ROLLER, -SPAN / 2), RowSeat(ROLLER, SPAN / 2)), SPAN, axial=False)
CROSSED = Pair((RowSeat(CrossedRow(count=48, length=8e-3, pitch=120e-3)),), 120e-3, axial=True)


def spatial(pair, clearance, top, thrust, count=120):
    """Return both results (case, 5): radial shifts of both rows as vectors and the axial shift,
    from the table and solved over the turn.
    """
    rng = np.random.default_rng(5)
    half = pair.span / 2
    direction = rng.normal(size=(count, 5)) * [1, 1, thrust, half, half]
    size = np.linalg.norm(direction * [1, 1, 1, 1 / half, 1 / half], axis=1)
    loads = direction / size[:, None] * top * rng.uniform(1e-3, 0.5, (count, 1))
    displacement = np.mean(
        [
            shaft_equilibrium(pair.turned(k / 4).seats, loads, clearance).displacement
            for k in range(4)
        ],
        axis=0,
    )
    lean = np.stack([displacement[:, 4], -displacement[:, 3]], axis=1) * half
    exact = np.hstack(
        [displacement[:, :2] - lean, displacement[:, :2] + lean, displacement[:, 2:3]]
    )
    couple = np.stack([loads[:, 4], -loads[:, 3]], axis=1) / pair.span
    reactions = loads[:, :2] / 2 - couple, loads[:, :2] / 2 + couple
    sizes = [np.linalg.norm(each, axis=1) for each in reactions]
    found = shift_table(pair, clearance, top).shifts(sizes[0], sizes[1], loads[:, 2])
    ways = [
        each / size[:, None] * found[:, k, None]
        for k, (each, size) in enumerate(zip(reactions, sizes, strict=True))
    ]
    return np.hstack([*ways, found[:, 2:]]), exact


def planar(pair, clearance, top, count=200):
    """Return the relative differences between table and solution for loads in one plane: the
    interpolation error alone.
    """
    rng = np.random.default_rng(3)
    direction = np.abs(rng.normal(size=(count, 3))) * [1, 1, 0.5 * pair.axial]
    direction[:, 2] *= rng.choice([-1, 1], count)
    loads = (
        direction
        / np.linalg.norm(direction, axis=1)[:, None]
        * top
        * rng.uniform(1e-3, 0.5, (count, 1))
    ).T
    exact = np.stack(pair.turned(0.25).solve(*loads, clearance), axis=-1)
    found = shift_table(pair, clearance, top).shifts(*loads)
    return np.linalg.norm(found - exact, axis=1) / np.linalg.norm(exact, axis=1)


@pytest.mark.parametrize(
    ("pair", "clearance", "top", "mean", "most"),
    [
        (DEEP, 15 * UM, 20e3, 0.005, 0.06),
        (DEEP, -5 * UM, 20e3, 0.003, 0.04),
        (DEEP, 0.0, 20e3, 0.005, 0.06),
        (BACK_TO_BACK, 0.0, 20e3, 0.01, 0.15),
        (ROLLERS, 50 * UM, 40e3, 0.005, 0.05),
        (ROLLERS, 0.0, 40e3, 0.005, 0.05),
        (ROLLERS, -0.1 * UM, 40e3, 0.005, 0.05),
        (CROSSED, 0.0, 30e3, 0.005, 0.05),
        (CROSSED, -10 * UM, 30e3, 0.003, 0.03),
    ],
)
def test_between_its_nodes_the_table_is_the_solution(pair, clearance, top, mean, most):
    """Between its nodes the table is within half a per cent of the solved shifts on average, and
    nowhere off by more than some per cent.
    """
    error = planar(pair, clearance, top)
    assert error.mean() < mean
    assert error.max() < most


@pytest.mark.parametrize(
    ("pair", "clearance"),
    [(DEEP, -5 * UM), (BACK_TO_BACK, 0.0), (ROLLERS, -10 * UM), (CROSSED, -10 * UM)],
)
@pytest.mark.parametrize("share", [1e-4, 1e-3])
def test_preloaded_rows_are_springs_under_light_loads(pair, clearance, share):
    """Under a load of a ten-thousandth of the largest, the table of preloaded rows is within 0.15 %
    of the solution.
    """
    loads = [np.array([part * share * 20e3]) for part in (1.0, 0.6, 0.3 * pair.axial)]
    exact = np.stack(pair.turned(0.25).solve(*loads, clearance), axis=-1)
    found = shift_table(pair, clearance, 20e3).shifts(*loads)
    assert np.linalg.norm(found - exact) < 0.0015 * np.linalg.norm(exact)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pair", "clearance", "top", "thrust", "share"),
    [
        (DEEP, 15 * UM, 20e3, 0.0, 0.09),
        (DEEP, 15 * UM, 20e3, 0.3, 0.06),
        (BACK_TO_BACK, 0.0, 20e3, 0.5, 0.06),
        (ROLLERS, 50 * UM, 40e3, 0.0, 0.05),
        (CROSSED, -10 * UM, 30e3, 1.0, 0.02),
        (CROSSED, -3 * UM, 30e3, 1.0, 0.03),
    ],
)
def test_three_numbers_describe_a_load_in_any_direction(pair, clearance, top, thrust, share):
    """Under loads and moments in any direction the shifts are those of the five-freedom solution,
    to some per cent of their size.
    """
    found, exact = spatial(pair, clearance, top, thrust)
    assert np.sqrt(((found - exact) ** 2).sum() / (exact**2).sum()) < share


def test_a_radial_load_follows_the_plane_law():
    """A 209 pair under a radial load midway: each bearing shifts as by the law of one bearing in
    its plane, averaged over the turn.
    """
    stiffness = ball_stiffness(12.7e-3, 65e-3)
    for clearance in (0.0, 15 * UM):
        one = np.mean(
            [
                radial_shift(
                    8900.0, clearance, stiffness, BALL_EXPONENT, element_angles(9, k * math.pi / 36)
                )
                for k in range(8)
            ]
        )
        found = ShiftTable(DEEP, clearance, 60e3).shifts(
            np.array([8900.0]), np.array([8900.0]), np.zeros(1)
        )
        assert found[0, 0] == pytest.approx(one, rel=0.01)
        assert found[0, 1] == pytest.approx(one, rel=0.01)
        assert abs(found[0, 2]) < 1e-3 * one


@pytest.mark.parametrize("clearance", [15 * UM, -5 * UM])
def test_a_load_on_either_row_of_a_pair_alone_shifts_it_as_much(clearance):
    """Two equal rows: a load on the row ahead has the mirror image of the shifts that the same load
    on the row behind has.
    """
    table, load, none = shift_table(DEEP, clearance, 20e3), np.array([2e3, 8e3]), np.zeros(2)
    behind, ahead = table.shifts(load, none, none), table.shifts(none, load, none)
    np.testing.assert_allclose(
        ahead[:, [1, 0]], behind[:, [0, 1]], rtol=0, atol=1e-6 * np.abs(behind).max()
    )


def test_edges_are_the_play():
    """Without deformation a radial load shifts a row by half its clearance, a thrust the shaft to
    the end of its axial play, √(A G - G²/4).
    """
    clearance, apart = 20 * UM, 0.04 * 12.7e-3
    table = shift_table(DEEP, clearance, 20e3)
    radial = table.edges(np.array([10.0]), np.array([10.0]), np.zeros(1))
    # With nine balls the ring can move between two of them, by up to G/2/cos(20 degrees).
    assert clearance / 2 <= radial[0, 0] * 1.01
    assert radial[0, 0] < clearance / 2 / math.cos(math.pi / 9)
    assert table.edges(np.zeros(1), np.zeros(1), np.array([50.0]))[0, 2] == pytest.approx(
        math.sqrt(apart * clearance - clearance**2 / 4), rel=0.01
    )
    assert not ShiftTable(DEEP, -1 * UM, 20e3).edges(np.ones(3), np.ones(3), np.ones(3)).any()


def test_loads_beyond_the_table_are_solved():
    """Above the table's largest load the result is the solution itself."""
    loads = [np.array([30e3]), np.array([8e3]), np.array([5e3])]
    table = shift_table(DEEP, 15 * UM, 20e3)
    np.testing.assert_array_equal(
        table.shifts(*loads)[0], np.stack(DEEP.solve(*loads, 15 * UM), axis=-1)[0]
    )


def test_reading_is_quicker_than_solving():
    """Reading the table is at least three times as fast as solving."""
    import time

    table = shift_table(DEEP, 15 * UM, 20e3)
    loads = np.abs(np.random.default_rng(1).normal(size=(3, 4000))) * 1000
    started = time.process_time()
    table.shifts(*loads)
    read = time.process_time() - started
    DEEP.solve(*loads, 15 * UM)
    assert time.process_time() - started - read > 3 * read


def test_a_table_needs_a_load():
    """A table up to zero load is refused."""
    with pytest.raises(ValueError, match="must be positive"):
        ShiftTable(DEEP, 0.0, 0.0)
