"""Inverse kinematics of closed chains against closed forms: two circles, three spheres, distances."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

from lostmotion.errors import InputError
from lostmotion.io.native import arm_of
from lostmotion.mechanism import closed_position
from lostmotion.mechanism.assembly import assembled
from lostmotion.mechanism.closed_home import home_of
from lostmotion.mechanism.closed_inverse import solved
from lostmotion.mechanism.inverse import inverse_kinematics, tool_and_jacobian
from lostmotion.mechanism.state import state_of
from lostmotion.spatial import pose_of
from tests.mechanism.closed_chains import delta, five_bar, hexapod, hexapod_legs, three_rrr

POINTS = 40
EXAMPLES = Path(__file__).parents[2] / "examples" / "closed-chains"
VALIDATES = (
    (
        "inverse kinematics of a five-bar, a delta, a hexapod and a planar stage",
        "closed forms: law of cosines, three spheres, six distances",
        "1e-7 rad, 1e-8 m",
        "mechanism/closed_inverse.py",
    ),
)


def poses(points: np.ndarray, turn: np.ndarray | None = None) -> np.ndarray:
    """Return poses (point, 4, 4) at points."""
    out = np.tile(np.eye(4), (len(points), 1, 1))
    out[:, :3, 3] = points
    if turn is not None:
        out[:, :3, :3] = turn
    return out


def crank(centre: np.ndarray, tool: np.ndarray, arm: float, rod: float, side: int) -> float:
    """Return the angle of a crank whose rod ends at the tool: the law of cosines."""
    x, y = tool - centre
    reach = math.hypot(x, y)
    inner = math.acos((reach**2 + arm**2 - rod**2) / (2 * reach * arm))
    return math.atan2(y, x) + side * inner


def test_the_drives_of_a_five_bar_are_those_of_two_circles():
    """Both cranks of a five-bar stand as the law of cosines has it, elbows outward."""
    arm, rng = five_bar(), np.random.default_rng(1)
    tools = np.column_stack([rng.uniform(0.0, 0.2, POINTS), rng.uniform(0.3, 0.5, POINTS)])
    expected = [
        (
            crank(np.zeros(2), each, 0.25, 0.4, 1),
            crank(np.array([0.2, 0]), each, 0.25, 0.4, -1),
        )
        for each in tools
    ]
    wanted = poses(np.column_stack([tools, np.zeros(POINTS)]))
    q, reached = inverse_kinematics(
        arm, wanted, np.tile(arm.home, (POINTS, 1)), with_orientation=False
    )
    assert reached.all()
    np.testing.assert_allclose(q, expected, atol=1e-7)


def test_the_drives_of_a_delta_are_those_of_three_spheres():
    """Every arm of a delta ends on a sphere of its rod: A sin q + B cos q = C in closed form."""
    arm, rng = delta(), np.random.default_rng(2)
    tools = np.column_stack([rng.uniform(-0.1, 0.1, (POINTS, 2)), rng.uniform(-0.5, -0.38, POINTS)])
    expected = np.empty((POINTS, 3))
    for k in range(3):
        yaw = math.radians(120 * k)
        along = tools[:, 0] * math.cos(yaw) + tools[:, 1] * math.sin(yaw) + 0.06 - 0.2
        aside = -tools[:, 0] * math.sin(yaw) + tools[:, 1] * math.cos(yaw)
        # (along - 0.2 cos q)^2 + aside^2 + (z + 0.2 sin q)^2 = 0.48^2
        a, b = 0.4 * tools[:, 2], -0.4 * along
        c = 0.48**2 - 0.2**2 - along**2 - aside**2 - tools[:, 2] ** 2
        expected[:, k] = np.arctan2(a, b) + np.arccos(c / np.hypot(a, b))
    expected = (expected + np.pi) % (2 * np.pi) - np.pi
    q, reached = inverse_kinematics(
        arm, poses(tools), np.tile(arm.home, (POINTS, 1)), with_orientation=False
    )
    assert reached.all()
    np.testing.assert_allclose(q, expected, atol=1e-7)


def test_the_legs_of_a_hexapod_are_six_distances():
    """Six legs reach a pose of the platform with its orientation."""
    arm, rng = hexapod(), np.random.default_rng(3)
    at = np.column_stack([rng.uniform(-0.04, 0.04, (POINTS, 2)), rng.uniform(0.47, 0.53, POINTS)])
    tilts = rng.uniform(-0.15, 0.15, POINTS)
    turns = np.array([pose_of(rpy=(tilt, 0, 0))[:3, :3] for tilt in tilts])
    expected = [hexapod_legs(tuple(a), tilt) for a, tilt in zip(at, tilts, strict=True)]
    q, reached = inverse_kinematics(
        arm, poses(at, turns), np.tile(arm.home, (POINTS, 1)), with_orientation=True
    )
    assert reached.all()
    np.testing.assert_allclose(q, expected, atol=1e-8)


def test_a_planar_stage_reaches_the_components_that_it_controls():
    """A 3-RRR stage reaches x, y and its turn; the elbows are on the side of its home."""
    arm, rng = three_rrr(), np.random.default_rng(4)
    at = np.column_stack([rng.uniform(-0.05, 0.1, (POINTS, 2)), rng.uniform(0.0, 0.3, POINTS)])
    wanted = poses(
        np.column_stack([at[:, :2], np.zeros(POINTS)]),
        np.array([pose_of(rpy=(0, 0, turn))[:3, :3] for turn in at[:, 2]]),
    )
    expected = np.empty((POINTS, 3))
    for k, about in enumerate(np.radians((90, 210, 330))):
        corner = at[:, :2] + 0.15 * np.column_stack(
            [np.cos(about + at[:, 2]), np.sin(about + at[:, 2])]
        )
        motor = 0.5 * np.array([math.cos(about), math.sin(about)])
        expected[:, k] = [crank(motor, each, 0.4, 0.4, 1) for each in corner]
    rows = np.array([2, 3, 4])
    start = np.tile(arm.home, (POINTS, 1))
    q, reached = solved(arm.tree, arm.limits, wanted, start, rows, 1e-9, 40)
    assert reached.all()
    away = (q - expected + np.pi) % (2 * np.pi) - np.pi
    np.testing.assert_allclose(away, 0.0, atol=1e-7)


def test_rods_that_spin_on_two_balls_do_not_hinder_a_delta_printer():
    """A delta printer with rods on two balls each reaches what three spheres have it, although the
    six rods are free to spin about themselves: the end stops stand sqrt(L^2 - r^2) above the tool.
    """
    text = (EXAMPLES / "delta-printer.toml").read_text(encoding="utf-8")
    universal = text[text.index('type = "universal"') : text.index("link = { length = ")]
    ball = 'type = "spherical"\nstart = ["0 deg", "26 deg", "0 deg"]\nbearing = "ball"\n'
    arm = arm_of("test.toml", tomllib.loads(text.replace(universal, ball)))
    assert home_of(arm.tree).idle == 6
    rng = np.random.default_rng(5)
    tools = np.column_stack([rng.uniform(-0.05, 0.05, (POINTS, 2)), rng.uniform(0.05, 0.1, POINTS)])
    expected = np.empty((POINTS, 3))
    for k, angle in enumerate(np.radians((0, 120, 240))):
        # from the middle of two balls of a carriage to that of two balls of the platform
        tower = (0.14 - 0.03) * np.array([math.cos(angle), math.sin(angle)])
        aside = np.linalg.norm(tools[:, :2] - tower, axis=1)
        expected[:, k] = tools[:, 2] + np.sqrt(0.25**2 - aside**2)
    q, reached = inverse_kinematics(
        arm, poses(tools), np.tile(arm.home, (POINTS, 1)), with_orientation=False
    )
    assert reached.all()
    np.testing.assert_allclose(q, expected, atol=1e-8)


def test_what_a_closed_chain_cannot_reach_is_not_returned_as_reached():
    """A point beyond the legs, one beyond a limit of a drive and one that only the other assembly
    mode reaches are not reached, and the values returned are assembled.
    """
    arm = five_bar()
    tools = np.array([(0.1, 0.9, 0), (0.1, -0.4, 0), (0.1, 0.4, 0)])
    q, reached = inverse_kinematics(
        arm, poses(tools), np.tile(arm.home, (3, 1)), with_orientation=False
    )
    np.testing.assert_array_equal(reached, (False, False, True))
    assert assembled(arm, q).all()
    assert ((q >= arm.limits[:, 0]) & (q <= arm.limits[:, 1])).all()


def test_what_only_the_other_assembly_mode_reaches_is_not_returned_as_reached():
    """At these points all pairs of elbows within the limits have the rods crossed: the other
    intersection of two circles than that of home. Starts from which it is near do not reach them.
    """
    arm = five_bar()
    tools = np.array([(x, y, 0.0) for x in (-0.36, -0.3, -0.24) for y in (-0.2, -0.15, -0.1)])
    for tool in tools[:, :2]:
        elbows = [
            [
                centre + 0.25 * np.array([math.cos(angle), math.sin(angle)])
                for side in (1, -1)
                if math.sin(angle := crank(centre, tool, 0.25, 0.4, side)) >= 0
            ]
            for centre in (np.zeros(2), np.array([0.2, 0.0]))
        ]
        rods = [(tool - one, tool - other) for one in elbows[0] for other in elbows[1]]
        assert rods
        assert all(one[0] * other[1] < one[1] * other[0] for one, other in rods)
    for start in (arm.home, np.array([1.7, 2.9]), np.array([0.94, 1.33])):
        q, reached = inverse_kinematics(
            arm, poses(tools), np.tile(start, (len(tools), 1)), with_orientation=False
        )
        assert not reached.any()
        assert assembled(arm, q).all()


def test_from_values_near_a_parallel_singularity_the_inverse_starts_at_home():
    """Where the elbows of a five-bar almost meet, both rods lie almost on one another, and the tool
    is loose across them. Points reached so are reached with the elbows apart, as from home.
    """
    arm = five_bar()
    left = math.acos(0.4) + np.linspace(0.002, 0.02, POINTS)
    start = np.column_stack([left, np.pi - left])
    assert not assembled(arm, start).any()
    aside = 0.1 - 0.25 * np.cos(left)
    tools = np.column_stack([np.full(POINTS, 0.1), 0.25 * np.sin(left), np.zeros(POINTS)])
    tools[:, 1] += np.sqrt(0.4**2 - aside**2)
    q, reached = inverse_kinematics(arm, poses(tools), start, with_orientation=False)
    assert reached.all()
    assert assembled(arm, q).all()
    expected = [crank(np.zeros(2), tool[:2], 0.25, 0.4, 1) for tool in tools]
    np.testing.assert_allclose(q[:, 0], expected, atol=1e-7)


def test_the_jacobian_of_a_chain_that_is_not_assembled_is_refused():
    """A pose of the drives beyond the rods has no tool, and the message names the pose."""
    arm = five_bar(0.3)
    apart = np.array([arm.home, [math.pi, 0.0]])
    with pytest.raises(InputError, match="pose 1 of 2: the closed chain cannot be assembled"):
        tool_and_jacobian(arm, apart)


@pytest.mark.parametrize("make", [five_bar, delta, hexapod, three_rrr])
def test_the_jacobian_of_a_closed_chain_is_the_difference_of_its_tool(make):
    """The twist of the tool per motion of a drive equals a central difference of assembled poses."""
    arm = make()
    q, step = arm.home[None], 1e-5
    at, columns = tool_and_jacobian(arm, q)
    np.testing.assert_allclose(at, state_of(arm, q).frames[-1], atol=1e-14)
    for d in range(len(arm.driven)):
        side = np.eye(len(arm.driven))[d] * step
        ends = state_of(arm, np.concatenate([q - side, q + side])).frames[-1]
        shift = (ends[1, :3, 3] - ends[0, :3, 3]) / (2 * step)
        turned = ends[1, :3, :3] @ ends[0, :3, :3].T
        turned = (turned - turned.T) / (4 * step)
        np.testing.assert_allclose(columns[0, 3:, d], shift, atol=1e-7)
        np.testing.assert_allclose(
            columns[0, :3, d], (turned[2, 1], turned[0, 2], turned[1, 0]), atol=1e-7
        )


def test_poses_that_are_kept_have_the_bits_of_poses_that_are_solved(monkeypatch):
    """A pose of a closed chain does not depend on those asked for with it or before it; what was
    solved is not solved again, and no more is kept than its bound.
    """
    arm, counts = hexapod(), []
    low, high = arm.limits.T
    q = np.random.default_rng(3).uniform(low, high, (192, len(low)))
    whole, solve = closed_position._solved(arm.tree, q), closed_position._solved

    def counted(tree, values):
        counts.append(len(values))
        return solve(tree, values)

    monkeypatch.setattr(closed_position, "_solved", counted)
    closed_position._kept.cache_clear()
    for rows in (slice(0, 64), slice(32, 128), slice(None, None, -1), slice(5, 6)):
        found = closed_position.assemble(arm.tree, q[rows])
        for name in ("frames", "problem", "joint", "motions", "columns"):
            expected = getattr(whole, name)
            expected = expected[:, rows] if name == "frames" else expected[rows]
            np.testing.assert_array_equal(getattr(found, name), expected)
    assert counts == [64, 64, 64]
    monkeypatch.setattr(closed_position, "_MOST_KEPT", whole.bytes // 2)
    closed_position._kept.cache_clear()
    closed_position.assemble(arm.tree, q[:80])
    again = closed_position.assemble(arm.tree, q)
    np.testing.assert_array_equal(again.frames, whole.frames)
    assert closed_position._kept(arm.tree).last == ({}, None)
