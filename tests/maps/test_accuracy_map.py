"""Accuracy map of a planar arm of two joints against closed forms, and its invariances."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import ndtr
from scipy.stats import truncnorm

from lostmotion import Arm, InputError
from lostmotion.maps.accuracy_map import map_workspace
from lostmotion.maps.cell_statistics import CONFIGURATIONS, QUANTILE
from lostmotion.maps.cells import grid_around, interior
from lostmotion.maps.placement import (
    YAWS,
    best_placements,
    clear_cells,
    footprint,
    placement_scores,
)
from lostmotion.maps.reach import reachable_cells
from lostmotion.maps.request import MapRequest
from lostmotion.parts.frame import Frame
from lostmotion.propagation.analytic import analytic
from lostmotion.propagation.error_magnitude import by_rays

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "accuracy map of a planar arm with sag and encoder errors",
        (
            "equilibrium and covariance by hand, quadrature over one principal direction; the "
            "annulus: no cell missed; brute force over placements of a box"
        ),
        "0.5 %; every cell; exact",
    ),
)

pytestmark = pytest.mark.usual_counts

UPPER, FORE = 0.5, 0.3
ZERO = (2e-3, 3e-3)  # rad, ± limits
STIFFNESS = (4e3, 1.5e3)  # N m/rad
VARIANCE = np.square(ZERO) / 9 * truncnorm(-3, 3).var()
PAYLOAD = 4.0
GRAVITY = 9.81


def planar(turned=0.0, second=("-179.9 deg", "179.9 deg")):
    """Return two links in the x-z plane, or in that plane rotated about z, with errors of encoder
    zeros and drive compliance only.
    """

    def joint(name, length, zero, stiffness, limits):
        return {
            "name": name,
            "type": "revolute",
            "axis": "-y",
            "limits": limits,
            "link": {"length": f"{length} m"},
            "encoder": {"zero": f"{zero} rad"},
            "gearbox": {"ratio": 100, "stiffness": f"{stiffness} N m/rad"},
        }

    first = joint("A", UPPER, ZERO[0], STIFFNESS[0], ("-180 deg", "180 deg"))
    first["origin"] = {"rpy": ("0 deg", "0 deg", f"{turned} deg")}
    joints = [first, joint("B", FORE, ZERO[1], STIFFNESS[1], second)]
    return Arm.model_validate(
        {
            "name": "planar",
            "joints": joints,
            "payload": {"mass": f"{PAYLOAD} kg"},
            "gravity": f"{GRAVITY} m/s^2",
        }
    )


def elbow_and_tool(q):
    """Return elbow and tool of the planar arm for these joint angles."""
    elbow = UPPER * np.array([math.cos(q[0]), math.sin(q[0])])
    return elbow, elbow + FORE * np.array([math.cos(q[0] + q[1]), math.sin(q[0] + q[1])])


def by_hand(q):
    """Return the commanded tool position of the planar arm for one pose, and the sag and in-plane
    covariance where it stands: its springs in equilibrium with the payload, by hand.
    """
    q, wound, before = np.asarray(q), np.zeros(2), np.ones(2)
    while np.abs(wound - before).max() > 1e-13:  # each round shrinks what is left to 1 %
        elbow, tool = elbow_and_tool(q + wound)
        torque = -PAYLOAD * GRAVITY * np.array([tool[0], tool[0] - elbow[0]])
        before, wound = wound, torque / np.array(STIFFNESS)
    # motion of the tool per turn of each joint
    across = np.array([[-tool[1], tool[0]], [-(tool - elbow)[1], (tool - elbow)[0]]])
    commanded = elbow_and_tool(q)[1]
    return commanded, tool - commanded, across.T @ np.diag(VARIANCE) @ across


def below(sag, covariance, level=0.95):
    """Return the quantile `level` of the length of a normal vector in the plane, by quadrature over
    one principal direction.
    """
    values, axes = np.linalg.eigh(covariance)
    b, s = axes.T @ sag, np.sqrt(np.maximum(values, 1e-30))

    def share(t):
        def part(x):
            y = math.sqrt(max(t * t - x * x, 0.0))
            return math.exp(-(((x - b[1]) / s[1]) ** 2) / 2) * (
                ndtr((y - b[0]) / s[0]) - ndtr((-y - b[0]) / s[0])
            )

        dilated = [x for x in (b[1] - 4 * s[1], b[1], b[1] + 4 * s[1]) if -t < x < t]
        return quad(part, -t, t, points=dilated or None, limit=200)[0] / (
            s[1] * math.sqrt(2 * math.pi)
        )

    size = math.hypot(*sag) + 4 * math.sqrt(values.sum())
    return brentq(lambda t: share(t) - level, 1e-3 * size, 2 * size, xtol=1e-9)


@pytest.fixture(scope="module")
def plane():
    """Map the planar arm, with a target and a box to be placed."""
    return map_workspace(
        planar(),
        MapRequest(
            cell=0.04, by="best", target=2.5e-3, box=(0.2, 0.0, 0.1), poses=16384, per_cell=12
        ),
    )


def test_figures_are_the_closed_form(plane):
    """Best, mean and worst of a cell follow from its poses' sag and covariance, and are in that
    order.
    """
    reached = plane.reached
    rng = np.random.default_rng(5)
    for cell in rng.choice(np.unique(reached.cell), 12, replace=False):
        mine = np.flatnonzero(reached.cell == cell)
        known = [by_hand(reached.q[k]) for k in mine]
        assert np.allclose(
            [tool for tool, _, _ in known], reached.points[mine][:, [0, 2]], atol=1e-12
        )
        values = [below(sag, covariance) for _, sag, covariance in known]
        at = np.unravel_index(cell, reached.grid.shape)
        expected = np.array([min(values), sum(values) / len(values), max(values)])
        found = plane.errors[(QUANTILE, slice(None), *at)]
        # limits at three sigma are not quite normal
        assert found == pytest.approx(expected, rel=6e-3)
    low, middle, high = (plane.errors[:, k][np.isfinite(plane.errors[:, k])] for k in range(3))
    assert (low <= middle).all()
    assert (middle <= high).all()
    assert (low < high).any()
    assert plane.evaluated.errors.valid.all()
    assert not plane.uncertain.any()


def test_both_elbows_are_evaluated(plane):
    """Sag differs between elbow up and down, and nearly every cell has poses of both kinds."""
    reached = plane.reached
    both = [
        len(set(np.sign(reached.q[reached.cell == cell, 1]))) == 2
        for cell in np.unique(reached.cell)
    ]
    assert np.mean(both) > 0.9


@pytest.mark.parametrize("edge", [0.05, pytest.param(0.013, marks=pytest.mark.slow)])
def test_no_cell_in_reach_is_missed(edge):
    """Every cell with its centre in the reachable annulus has poses and was reached at its centre,
    from few samples or many.
    """
    found = reachable_cells(planar(), 2048, edge, 4, 1)
    grid = found.grid
    x, z = np.meshgrid(grid.centres_along(0), grid.centres_along(2), indexing="ij")
    from_base = np.hypot(x, z)
    inside = (from_base > UPPER - FORE + 1e-3 * edge) & (from_base < UPPER + FORE - 1e-3 * edge)
    inside &= np.abs(from_base - (UPPER - FORE)) > 2e-6  # folded further than the second joint goes
    visited = found.counts[:, 0, :] > 0
    assert not (inside & ~visited).any()
    assert not (inside & ~found.centre[:, 0, :]).any()
    outside = (from_base < UPPER - FORE - 1e-6) | (from_base > UPPER + FORE + 1e-6)
    assert not (found.centre[:, 0, :] & outside).any()
    # And none lies outside the grid.
    span = (
        np.arange(-40, 40) * edge + edge / 2
        if edge > 0.02
        else np.arange(-80, 80) * edge + edge / 2
    )
    count = sum(
        (UPPER - FORE + 1e-3 * edge < math.hypot(a, b) < UPPER + FORE - 1e-3 * edge)
        for a in span
        for b in span
    )
    assert np.count_nonzero(inside) == count
    assert grid.dimensions == 2
    assert np.allclose(found.points[:, 1], 0, atol=1e-12)
    assert np.array_equal(grid.cell_numbers(found.points), found.cell)
    middle = grid.centres(found.cell)
    there = found.centre.ravel()[found.cell]
    assert (np.abs(found.points - middle)[there] < 1e-3 * edge).all()


def best_below(points):
    """Return the 95 % distance at points (point, 2) in the annulus by the better elbow; the
    quadrature agrees with the closed form above.
    """
    sags, wide = np.zeros((2, len(points), 3)), np.zeros((2, len(points), 3, 3))
    tools = np.zeros((2, len(points), 2))
    for k, (x, z) in enumerate(points):
        bend = math.acos((x * x + z * z - UPPER**2 - FORE**2) / (2 * UPPER * FORE))
        lean = math.atan2(FORE * math.sin(bend), UPPER + FORE * math.cos(bend))
        for way, sign in enumerate((1, -1)):
            tools[way, k], sag, covariance = by_hand([math.atan2(z, x) - sign * lean, sign * bend])
            sags[way, k, [0, 2]], wide[way, k][np.ix_([0, 2], [0, 2])] = sag, covariance
    np.testing.assert_allclose(tools, [points, points], rtol=0, atol=1e-9)
    roots = np.linalg.cholesky(wide + 1e-24 * np.eye(3))
    return np.min(
        [
            by_rays(root, b, levels=(0.95,)).values[:, 2]
            for b, root in zip(sags, roots, strict=True)
        ],
        axis=0,
    )


def test_size_and_share_hold_the_closed_form(plane):
    """The interval of the size contains the area of the annulus, that of the share within the
    target the share of a fine grid of closed forms.
    """
    area = math.pi * ((UPPER + FORE) ** 2 - (UPPER - FORE) ** 2)
    assert plane.size.low < area < plane.size.high
    assert plane.size.value == pytest.approx(area, rel=0.01)
    x, z = np.meshgrid(np.arange(-0.79, 0.8, 0.02), np.arange(-0.79, 0.8, 0.02))
    r = np.hypot(x, z)
    fine = best_below(
        np.column_stack([each[(r > UPPER - FORE) & (r < UPPER + FORE)] for each in (x, z)])
    )
    share = plane.within_target.share
    assert share.low <= np.mean(fine <= plane.within_target.target) <= share.high
    assert share.high - share.low < 0.3
    assert 0.05 < share.value < 0.95


def test_cells_are_judged_at_their_middles(plane):
    """The best of each cell with its centre in reach is the closed form of the better elbow
    there.
    """
    at = np.argwhere(plane.reached.centre[:, 0, :])
    points = np.column_stack(
        [plane.reached.grid.centres_along(axis)[at[:, k]] for k, axis in enumerate((0, 2))]
    )
    found = plane.errors[QUANTILE, 0, at[:, 0], 0, at[:, 1]]
    ratio = found / best_below(points)
    assert (np.abs(ratio - 1) < 5e-3).mean() > 0.9
    assert (ratio > 1 - 5e-3).all()
    assert (ratio < 1.1).mean() > 0.98  # the rest: only one elbow among their poses


def test_a_box_stands_at_its_stated_place(plane):
    """All of the best placement is in reach; the closed form of the better elbow gives the map's
    errors there, and those of the validation points.
    """
    box = plane.placements.best[0]
    assert box.validation_reached == box.validation_points == 6 * 4
    x, z = np.meshgrid(np.linspace(-0.1, 0.1, 6), np.linspace(-0.05, 0.05, 4))
    assert box.validated_worst == pytest.approx(
        best_below(box.centre[[0, 2]] + np.column_stack([x.ravel(), z.ravel()])).max(), rel=0.05
    )
    middles = plane.reached.grid.centres(box.cells)[:, [0, 2]]
    assert box.worst == pytest.approx(best_below(middles).max(), rel=0.05)
    taken = np.concatenate([each.cells for each in plane.placements.best])
    assert len(plane.placements.best) == 3
    assert len(np.unique(taken)) == len(taken)
    assert [each.worst for each in plane.placements.best] == sorted(
        each.worst for each in plane.placements.best
    )


def test_budgets_add_up(plane):
    """Shares of every zone sum to one, and each zone has the mean square of the poses on which its
    figures are based.
    """
    assert [each.zone for each in plane.budgets] == ["best box", "within the target", "all cells"]
    for each in plane.budgets:
        assert sum(cost.share for cost in each.costs) == pytest.approx(1, abs=1e-12)
        assert each.poses == each.cells
    which = plane.evaluated.poses_of(
        plane.placements.best[0].cells, "best", plane.errors.reshape(2, 3, -1)
    )
    squares = [
        sag @ sag + np.trace(covariance)
        for _, sag, covariance in map(by_hand, plane.reached.q[which])
    ]
    assert plane.budgets[0].rms == pytest.approx(math.sqrt(np.mean(squares)), rel=1e-9)


def test_threads_change_no_bit():
    """Every number is the same for any number of threads."""
    asked = MapRequest(
        cell=0.08, by="best", target=2.5e-3, box=(0.2, 0.0, 0.1), poses=2048, per_cell=4
    )
    alone, other = (map_workspace(planar(), asked, threads=threads) for threads in (1, 3))
    assert np.array_equal(alone.errors, other.errors, equal_nan=True)
    assert np.array_equal(alone.reached.q, other.reached.q)
    assert alone.within_target.share == other.within_target.share
    assert alone.budgets == other.budgets
    assert alone.placements.best
    for one, two in zip(alone.placements.best, other.placements.best, strict=True):
        assert all(
            np.array_equal(getattr(one, field.name), getattr(two, field.name))
            for field in dataclasses.fields(one)
        )


def test_turning_the_base_turns_the_map(plane):
    """The arm's plane rotated by 90° gives the same cells in the other plane, and the same figures
    for sampled poses, to rounding.
    """
    other = map_workspace(planar(90), MapRequest(cell=0.04, by="best", poses=16384, per_cell=12))
    assert np.array_equal(plane.reached.counts[:, 0, :] > 0, other.reached.counts[0] > 0)
    sampled = ~np.isin(
        np.arange(plane.selected.size), plane.reached.cell[plane.reached.brought]
    ).reshape(plane.selected.shape)[:, 0, :]
    assert sampled.sum() > 300
    for by in range(len(CONFIGURATIONS)):
        one, two = plane.errors[QUANTILE, by, :, 0, :], other.errors[QUANTILE, by, 0]
        assert np.allclose(one[sampled], two[sampled], rtol=1e-9, equal_nan=True)
        assert np.nanmedian(np.abs(one / two - 1)) < 1e-9


@pytest.mark.slow
def test_a_half_turn_of_a_spatial_arm_turns_its_map(arm):
    """For a spatial arm on a base rotated by 180°, grid, reach and figures of sampled cells rotate
    with it.
    """
    request = MapRequest(cell=0.1, poses=8192, per_cell=2)
    first = arm.joints[0].model_copy(update={"origin": Frame(rpy=(0.0, 0.0, math.pi))})
    turned = Arm(name="turned", joints=(first, *arm.joints[1:]), payload=arm.payload)
    one, two = map_workspace(arm, request), map_workspace(turned, request)
    assert one.reached.grid.shape == two.reached.grid.shape
    a, b = one.selected, two.selected[::-1, ::-1, :]
    assert np.array_equal(np.isfinite(a), np.isfinite(b))
    close = np.isclose(a, b, rtol=1e-6)
    assert close[np.isfinite(a)].mean() > 0.99


def test_sliding_windows_are_brute_force():
    """Worst and mean under every footprint, holes included, equal those of a separate evaluation of
    each placement.
    """
    rng = np.random.default_rng(3)
    field = rng.random((9, 8, 6))
    field[rng.random(field.shape) < 0.03] = np.inf
    for size, yaw in (
        ((0.3, 0.2, 0.1), 0.0),
        ((0.4, 0.1, 0.3), 0.0),
        ((0.3, 0.2, 0.2), YAWS[2]),
        ((0.25, 0.1, 0.1), YAWS[7]),
        ((0.0, 0.3, 0.2), 0.0),
    ):
        cover = footprint(size, yaw, 0.1)
        worst, mean = (placement_scores(field, cover, by_mean=by_mean) for by_mean in (False, True))
        for at in np.ndindex(field.shape):
            part = tuple(slice(i, i + n) for i, n in zip(at, cover.shape, strict=True))
            fits = all(i + n <= m for i, n, m in zip(at, cover.shape, field.shape, strict=True))
            under = field[part][cover] if fits else np.array([np.inf])
            assert worst[at] == under.max()
            assert mean[at] == pytest.approx(under.mean(), rel=1e-12)


@pytest.mark.parametrize("yaw", YAWS[1:])
def test_a_turned_footprint_holds_the_box(yaw):
    """Every point of the rotated box is in a cell of its footprint, and every cell of the footprint
    contains, or nearly contains, one.
    """
    size, edge = np.array([0.43, 0.17, 0.1]), 0.05
    cover = footprint(size, yaw, edge)[:, :, 0]
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, 801) * size[0], np.linspace(-0.5, 0.5, 801) * size[1])
    x, y = math.cos(yaw) * u - math.sin(yaw) * v, math.sin(yaw) * u + math.cos(yaw) * v
    at = np.floor(np.stack([x, y]) / edge + (np.array(cover.shape) / 2)[:, None, None]).astype(int)
    hit = np.zeros_like(cover)
    hit[tuple(at.reshape(2, -1))] = True
    assert (cover | ~hit).all()
    assert (cover & ~hit).sum() <= 4


def test_a_box_too_large_is_reported(plane):
    """Where no placement is in reach the largest box of the proportions is reported; it fits, and
    one a cell wider does not.
    """
    figures = plane.selected
    found = best_placements(planar(), plane.reached, figures, (1.2, 0.0, 1.2))
    assert not found.best
    assert found.largest is not None
    # Beside the hole the largest square in an annulus of 0.2 to 0.8 m reaches from 0.2 m to the
    # circle of 0.8 m.
    ideal = brentq(lambda a: math.hypot(0.2 + a, a / 2) - 0.8, 0.1, 0.8)
    assert ideal - 0.1 <= found.largest[0] <= ideal + 1e-9
    again = best_placements(planar(), plane.reached, figures, tuple(found.largest))
    assert again.best
    assert not best_placements(planar(), plane.reached, figures, tuple(found.largest * 1.02)).best
    with pytest.raises(InputError, match="cannot leave y = 0 mm"):
        best_placements(planar(), plane.reached, figures, (0.2, 0.1, 0.1))


@pytest.mark.parametrize("size", [(1e-6, 0.0, 0.3), (1e3, 0.0, 1e3)])
def test_no_footprint_is_larger_than_the_grid(plane, monkeypatch, size):
    """A box with a tiny side, or far too large, is placed without footprints larger than the
    grid.
    """
    grid = plane.reached.grid

    def small(size, yaw, edge):
        assert max(size) <= grid.edge * math.hypot(*grid.shape) * (1 + 1e-9)
        return footprint(size, yaw, edge)

    monkeypatch.setattr("lostmotion.maps.placement.footprint", small)
    found = best_placements(planar(), plane.reached, plane.selected, size)
    assert bool(found.best) == (max(size) < 1)
    assert found.tried > 0 or not found.best
    assert found.largest is not None
    assert found.largest[2] / found.largest[0] == pytest.approx(size[2] / size[0])


def test_cells_that_spread_beyond_the_sampled_ones_are_counted(monkeypatch):
    """Few sampled poses lead to many cells, which are refused too where their poses would be too
    many.
    """
    monkeypatch.setattr("lostmotion.maps.reach.MOST_POSES", 1000)
    with pytest.raises(InputError, match="at most 1000 poses"):
        reachable_cells(planar(), 16, 0.05, 4, 1)


def test_boxes_keep_clear(plane):
    """A box keeps the requested clearance from the base's axis and stays above the floor."""
    grid = plane.reached.grid
    allowed = clear_cells(grid, 0.4, 0.1)
    found = best_placements(planar(), plane.reached, plane.selected, (0.2, 0.0, 0.1), allowed)
    for box in found.best:
        assert abs(box.centre[0]) - 0.1 >= 0.4 - 1e-9
        assert box.centre[2] - 0.05 >= 0.1 - 1e-9
    assert found.best[0].worst >= plane.placements.best[0].worst


def test_cells_are_counted_from_the_base():
    """The same edge gives the same cells for any points; the extent sets the default; too small a
    cell is refused with a valid example.
    """
    rng = np.random.default_rng(1)
    points = rng.normal(size=(1000, 3))
    grid, wider = grid_around(points, 0.1), grid_around(1.3 * points, 0.1)
    assert np.allclose(
        grid.centres(grid.cell_numbers(points)),
        wider.centres(wider.cell_numbers(points)),
        atol=1e-12,
    )
    assert (np.abs(points - grid.centres(grid.cell_numbers(points))) <= 0.05 + 1e-12).all()
    assert grid.cropped_to(grid.cell_numbers(points)).shape <= grid.shape
    assert grid_around(points).edge in (0.1, 0.2, 0.5)
    with pytest.raises(InputError, match="cell") as caught:
        grid_around(points, 0.001)
    grid_around(
        points, float(str(dict(caught.value.problems[0].passing)["cell"]).removesuffix(" mm")) / 1e3
    )
    cells = np.zeros((5, 1, 5), bool)
    cells[1:4, 0, 1:4] = True
    assert interior(cells, np.array([False, True, False])).sum() == 1


@pytest.mark.parametrize(
    "arguments",
    [
        {"by": "median"},
        {"level": 1.0},
        {"target": -1.0},
        {"box": (0.1, 0.1)},
        {"box": (0, 0, 0)},
        {"per_cell": 1},
        {"clear": -1.0},
        {"floor": math.nan},
        {"cell": "100 mm"},
        {"turned": True},
        {"box_by_mean": True},
        {"clear": 0.2},
    ],
)
def test_what_cannot_be_asked_is_refused(arguments):
    """Invalid arguments are refused, in one clear message each."""
    with pytest.raises(InputError):
        MapRequest(**arguments)


def test_poses_without_a_valid_figure_are_omitted_where_a_cell_has_others(monkeypatch):
    """An invalid figure counts only in cells without others, which are marked."""
    arm = planar()
    plain = map_workspace(arm, MapRequest(cell=0.1, by="worst", poses=1024, per_cell=3))

    def unsure(arm, poses, **options):
        found = analytic(arm, poses, **options)
        # one elbow
        off = np.where(poses.q[:, 1:] > 0, 0.2 * found.quantiles, found.quantiles_uncertainty)
        return dataclasses.replace(found, quantiles_uncertainty=off)

    monkeypatch.setattr("lostmotion.maps.cell_statistics.analytic", unsure)
    found = map_workspace(arm, MapRequest(cell=0.1, by="worst", poses=1024, per_cell=3))
    reached, errors = found.reached, found.evaluated.errors
    lost = reached.q[:, 1] > 0
    assert np.array_equal(errors.valid, ~lost)
    only = np.bincount(reached.cell[~lost], minlength=found.selected.size) == 0
    cells = only.reshape(found.selected.shape) & np.isfinite(found.selected)
    both = ~only.reshape(found.selected.shape) & np.isfinite(found.selected)
    assert cells.any()
    assert np.array_equal(found.uncertain, cells)
    assert (found.selected[both] <= plain.selected[both]).all()
    assert found.selected[cells] == pytest.approx(plain.selected[cells])
