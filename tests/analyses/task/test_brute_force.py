"""Tasks against a simulation of its own: forward and inverse kinematics in closed form, robots from
other random numbers, sides of the joints from the path, tolerances by their textbook definitions.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import least_squares

import lostmotion

VALIDATES = (
    (
        "probability that a task succeeds",
        (
            "a simulation of its own for a hole pattern, a seam, a circle and a peg: kinematics in "
            "closed form, exact fits of frames, lines and circles, sides of the joints by hand"
        ),
        "within the intervals of both",
        "propagation/task_success.py error_model/drawing_tolerances.py",
    ),
)

ARCMIN = math.pi / 10800
BACKLASH, SCATTER, ZERO, COUNT, LENGTH = 2 * ARCMIN, 0.8 * ARCMIN, 0.6 * ARCMIN, 0.5 * ARCMIN, 8e-5
LINKS = (0.4, 0.3)
TURNING = {
    "type": "revolute",
    "axis": "z",
    "gearbox": {"backlash": "2 arcmin ± 0.8 arcmin"},
    "encoder": {"resolution": "0.5 arcmin", "zero": "0.6 arcmin"},
}
STATED = {
    "name": "three axes",
    "joints": [
        {
            **TURNING,
            "name": "A",
            "limits": ("-170 deg", "170 deg"),
            "link": {"length": "400 mm ± 80 µm", "rigid": True},
        },
        {
            **TURNING,
            "name": "B",
            "limits": ("5 deg", "170 deg"),  # one configuration
            "link": {"length": "300 mm ± 80 µm", "rigid": True},
        },
        {"name": "Z", "type": "prismatic", "axis": "z", "limits": ("-300 mm", "300 mm")},
    ],
    "tool": {"frame": {"rpy": ("0 deg", "90 deg", "0 deg")}},
}
ARM = lostmotion.Arm.model_validate(STATED)
ROBOTS, RUNS = 1500, 3


def inverse(points):
    """Return the joint values that reach points (row, 3), with the elbow to one side."""
    x, y, z = points.T
    far = np.hypot(x, y)
    elbow = np.arccos((far**2 - LINKS[0] ** 2 - LINKS[1] ** 2) / (2 * LINKS[0] * LINKS[1]))
    behind = np.arctan2(LINKS[1] * np.sin(elbow), LINKS[0] + LINKS[1] * np.cos(elbow))
    return np.column_stack([np.arctan2(y, x) - behind, elbow, z])


def tool(a, b, z, first, second):
    """Return the tool point (..., 3) and the direction (..., 3) of the forearm."""
    point = np.stack(
        [
            first * np.cos(a) + second * np.cos(a + b),
            first * np.sin(a) + second * np.sin(a + b),
            z + 0 * a,
        ],
        axis=-1,
    )
    return point, np.stack([np.cos(a + b), np.sin(a + b), 0 * a], axis=-1)


def cut_normal(rng, size):
    """Return draws within ±1 of a normal law whose three sigma reach one."""
    out = rng.standard_normal(size) / 3
    while (wrong := np.abs(out) > 1).any():
        out[wrong] = rng.standard_normal(int(wrong.sum())) / 3
    return out


def simulate(points, seed=5):
    """Return tool points and forearm directions (robot, run, row, 3) along a path of points."""
    rng, q = np.random.default_rng(seed), inverse(points)
    shape = (ROBOTS, RUNS, len(points))
    angles = []
    for j in range(2):
        play = (BACKLASH + SCATTER * cut_normal(rng, (ROBOTS, 1))) / 2
        zero = ZERO * cut_normal(rng, (ROBOTS, 1))
        side = rng.choice([-1.0, 1.0], (ROBOTS, RUNS))
        values = np.empty(shape)
        for row in range(len(points)):
            step = q[row, j] - q[row - 1, j] if row else 0.0
            if abs(step) > 1e-7:
                side = np.full((ROBOTS, RUNS), math.copysign(1.0, step))
            count = COUNT * rng.uniform(-0.5, 0.5, (ROBOTS, RUNS))
            # the output lags behind a positive motion
            values[..., row] = q[row, j] + zero + count - side * play
        angles.append(values)
    first, second = (length + LENGTH * cut_normal(rng, (ROBOTS, 1, 1)) for length in LINKS)
    return tool(*angles, q[:, 2], first, second)


def agrees(held, found):
    """Check a share of robots and runs (robot, run) against the one found, within both intervals."""
    share, spread = held.mean(), held.mean(axis=1).std(ddof=1) / math.sqrt(len(held))
    error = math.hypot(spread, (found.high - found.low) / 4)
    assert 0.05 < share < 0.95
    assert abs(share - found.value) < 3 * error


def ask(features, tolerances, **more):
    """Return the answer for a task about a point in reach."""
    stated = {"features": features, "tolerances": tolerances, **more}
    return lostmotion.task(ARM, stated, robots=ROBOTS, runs=RUNS, seed=3)


CENTRE = (0.45, 0.15, 0.05)


def test_a_hole_pattern():
    """Six holes, approached from above so that the sides of the turning joints are those of the way
    from hole to hole; on the base, and relative to the best fit of the pattern.
    """
    found = ask(
        [
            {
                "name": "holes",
                "kind": "holes",
                "centre": CENTRE,
                "diameter": 0.12,
                "count": 6,
                "retract": 0.02,
                "tool_rpy": (0.0, 0.0, 0.0),
            }
        ],
        [
            {"name": "base", "sphere": 0.54e-3},
            {"name": "fitted", "cylinder": 0.4e-3, "axis": "z", "relative_to": "fitted"},
            {"name": "apart", "of": ["holes 1", "holes 3"], "distance": 0.2e-3},
        ],
    )
    turn = 2 * np.pi * np.arange(6) / 6
    holes = np.array(CENTRE) + 0.06 * np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    path = np.repeat(holes, 2, axis=0)
    path[::2, 2] -= 0.02  # the tool's z points up
    points = simulate(path)[0][:, :, 1::2]
    off = np.linalg.norm(points - holes, axis=-1).max(axis=-1)
    base = off < 0.27e-3
    middle = points - points.mean(axis=2, keepdims=True)
    wanted = holes - holes.mean(axis=0)
    u, _, vt = np.linalg.svd(np.einsum("rvpi,pj->rvij", middle[..., :2], wanted[:, :2]))
    residual = middle[..., :2] - np.einsum("rvij,pj->rvpi", u @ vt, wanted[:, :2])
    fitted = np.linalg.norm(residual, axis=-1).max(axis=-1) < 0.2e-3
    far = np.linalg.norm(points[:, :, 2] - points[:, :, 0], axis=-1)
    apart = np.abs(far - np.linalg.norm(holes[2] - holes[0])) < 0.2e-3
    for held, outcome in zip((base, fitted, apart), found.outcomes, strict=True):
        agrees(held, outcome.held)
    agrees(base & fitted & apart, found.success)


def test_a_seam():
    """A straight seam on which both joints reverse: across the path, and straight by itself."""
    start, end = np.array([0.25, 0.42, 0.0]), np.array([0.25, -0.42, 0.0])
    seam = {"name": "seam", "kind": "line", "start": tuple(start), "end": tuple(end)}
    found = ask(
        [seam],
        [{"name": "across", "cylinder": 0.4e-3}, {"name": "straight", "straightness": 0.36e-3}],
    )
    line = start + np.linspace(0, 1, 21)[:, None] * (end - start)
    points = simulate(line)[0]
    across = np.abs(points[..., 0] - 0.25).max(axis=-1) < 0.2e-3
    middle = points[..., :2] - points[..., :2].mean(axis=2, keepdims=True)
    normal = np.linalg.svd(middle, full_matrices=False)[2][..., 1, :]
    off = np.abs(np.einsum("rvpi,rvi->rvp", middle, normal)).max(axis=-1)
    straight = off < 0.18e-3
    agrees(across, found.outcomes[0].held)
    agrees(straight, found.outcomes[1].held)
    agrees(across & straight, found.success)
    assert (np.diff(found.program.sides[:, :2], axis=0) != 0).any(axis=0).all()
    assert found.reversal.max() > 1e-4


def test_a_circle():
    """Roundness about the least-squares circle, and the circle's place."""
    turned = np.linspace(0, 2 * np.pi, 21)
    ring = np.column_stack([np.cos(turned), np.sin(turned), 0 * turned])
    circle = {"name": "bore", "kind": "circle", "centre": CENTRE, "diameter": 0.1}
    found = ask(
        [circle], [{"name": "round", "roundness": 0.26e-3}, {"name": "place", "cylinder": 0.34e-3}]
    )
    nominal = np.array(CENTRE) + 0.05 * ring
    points = simulate(nominal)[0][:300]
    rounded = np.empty(points.shape[:2], bool)
    for at in np.ndindex(rounded.shape):
        own = points[at][:, :2]

        def off(fit, own=own):
            return np.linalg.norm(own - fit[:2], axis=1) - fit[2]

        gap = off(least_squares(off, (*CENTRE[:2], 0.05)).x)
        rounded[at] = np.ptp(gap) < 0.26e-3
    agrees(rounded, found.outcomes[0].held)
    radial = np.einsum("rvpi,pi->rvp", points - nominal, ring)
    along_z = points[..., 2] - CENTRE[2]
    place = np.hypot(radial, along_z).max(axis=-1) < 0.17e-3
    agrees(place, found.outcomes[1].held)


def test_a_peg_in_a_hole():
    """A peg of 60 mm along the forearm must lie within the hole's clearance over its length; the
    angle is a tolerance of its own.
    """
    points = np.array([[0.5, 0.2, 0.0], [0.45, -0.1, 0.0]])
    found = ask(
        [{"name": f"hole {k}", "kind": "point", "at": tuple(p)} for k, p in enumerate(points)],
        [
            {"name": "clearance", "cylinder": 0.4e-3, "axis": "tool", "length": 0.06},
            {"name": "angle", "orientation": 2 * ARCMIN},
        ],
    )
    tip, way = simulate(points)
    q = inverse(points)
    _, nominal = tool(q[:, 0], q[:, 1], q[:, 2], *LINKS)
    lateral = np.stack([-nominal[:, 1], nominal[:, 0]], axis=-1)
    ends = [tip, tip - 0.06 * way]
    wanted = [points, points - 0.06 * nominal]
    off = [
        np.abs(np.einsum("rvpi,pi->rvp", (e - w)[..., :2], lateral)).max(axis=-1)
        for e, w in zip(ends, wanted, strict=True)
    ]
    clear = np.maximum(*off) < 0.2e-3
    angle = np.arcsin(np.einsum("rvpi,pi->rvp", way[..., :2], lateral))
    square = np.abs(angle).max(axis=-1) < 2 * ARCMIN
    agrees(clear, found.outcomes[0].held)
    agrees(square, found.outcomes[1].held)
    agrees(clear & square, found.success)


def test_a_side_stays_until_the_joint_moves():
    """Two places that differ in height alone share the drawn side of both turning joints."""
    found = ask(
        [
            {"name": "low", "kind": "point", "at": (0.5, 0.2, 0.0)},
            {"name": "high", "kind": "point", "at": (0.5, 0.2, 0.1)},
        ],
        [{"of": ["low", "high"], "box": (0.4e-3, 0.4e-3, 1.0), "relative_to": "base"}],
    )
    points = simulate(np.array([[0.5, 0.2, 0.0], [0.5, 0.2, 0.1]]))[0]
    off = np.abs(points[..., :2] - np.array([0.5, 0.2])).max(axis=(2, 3))
    agrees(off < 0.2e-3, found.success)
    assert (found.program.sides[:, :2] == 0).all()
    assert (found.program.since[:, :2] == 0).all()


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_the_interval_counts_robots(share):
    """Robots that always succeed or never: as many samples as robots, whatever the runs."""
    from scipy.stats import beta

    from lostmotion.error_model.small_counts import clustered_share

    own = np.zeros(200)
    own[: round(200 * share)] = 1.0
    low, high = clustered_share(own, 50)
    n, k = 200, round(200 * share)
    wanted_low = 0.0 if k == 0 else beta.ppf(0.025, k, n - k + 1)
    wanted_high = 1.0 if k == n else beta.ppf(0.975, k + 1, n - k)
    assert low == pytest.approx(wanted_low, abs=2e-3)
    assert high == pytest.approx(wanted_high, abs=2e-3)
