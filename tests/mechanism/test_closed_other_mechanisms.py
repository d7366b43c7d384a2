"""Closed chains beside routes of their own: a spatial four-bar whose rod spins freely, a tripod of
three sliding legs, and a coupler on three parallel cranks in space.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve, minimize

from lostmotion.error_model.pose_matrix import screws
from tests.mechanism.closed_chains import arm, at, link, moved, xyz
from tests.mechanism.test_closed_reference import constants, metal

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "carry matrices and drive loads of a spatial four-bar with an idle rod and of a 3-RPS tripod",
        "differences of positions by distances and planes, errors put in; potential energy",
        "1e-7",
        "mechanism/closed_statics.py mechanism/closed_position.py",
    ),
    (
        (
            "compliance of a coupler on three parallel cranks, over-constrained six times, and what a "
            "rod too long does to it"
        ),
        "a displacement method for beams with hinges as constraints",
        "1e-7",
        "mechanism/closed_statics.py",
    ),
    (
        "play in two balls of a spatial four-bar under its weight",
        "the least potential energy over the positions of both balls",
        "0.5 % of the shift",
        "parts/play.py",
    ),
)

STEP = 1e-6
GRAVITY = np.array([0.0, 0.0, -9.81])


def differences(solve, size=STEP):
    """Return the change of a position per unit of an error, by central differences."""
    return (np.asarray(solve(size)) - np.asarray(solve(-size))) / (2 * size)


# ---- a spatial four-bar: crank, rod between two balls, rocker --------------------------------

CRANK, ROD, ROCKER, LEVER = 0.1, 0.36, 0.2, 0.3
PIVOT = np.array([0.35, 0.05, 0.1])


def four_bar(balls=({}, {})):
    """Return a crank about z, a rod between two balls, and a rocker about x with the tool.

    balls  bearings of the two balls
    """
    big, small = ({"bearing": each} if each else {} for each in balls)
    start = four_bar_rocker(0.4)
    rod = four_bar_ends(0.4, start)
    along = (rod[1] - rod[0]) / ROD
    turned = np.array([math.cos(0.4), math.sin(0.4), 0.0])
    # the rod's x axis in the axes of the crank, as yaw and pitch
    inner = np.array([along @ turned, -along[0] * turned[1] + along[1] * turned[0], along[2]])
    yaw, pitch = math.atan2(inner[1], inner[0]), -math.asin(inner[2])
    return arm(
        joints=[
            {"name": "crank", "type": "revolute", "axis": "z", "limits": ["-1 rad", "1 rad"]}
            | {"start": "0.4 rad", "link": link(CRANK, mass=0.3)},
            {"name": "big end", "type": "spherical", **big, "link": link(ROD, mass=0.5)}
            | {"start": ["0 rad", f"{pitch} rad", f"{yaw} rad"]},
            {"name": "small end", "type": "spherical", **small},
            {"name": "rocker", "type": "revolute", "axis": "x", "passive": True, "after": "base"}
            | {"origin": xyz(*PIVOT), "start": f"{start} rad", "link": link(ROCKER, "y")},
        ],
        closures=[{"joins": ["small end.tip", "rocker.tip"]}],
        tool={"after": "rocker.tip", "frame": xyz(0, LEVER - ROCKER, 0)},
        payload={"mass": "3 kg"},
    )


def four_bar_ends(q, rocker, crank=CRANK, pivot=PIVOT):
    """Return the centres of the two balls."""
    a = crank * np.array([math.cos(q), math.sin(q), 0.0])
    return a, pivot + ROCKER * np.array([0.0, math.cos(rocker), math.sin(rocker)])


def four_bar_rocker(q, rod=ROD, crank=CRANK, pivot=PIVOT):
    """Return the angle of the rocker at which the balls are a rod apart."""

    def apart(angle):
        a, b = four_bar_ends(q, angle, crank, pivot)
        return np.linalg.norm(a - b) - rod

    angles = np.linspace(-1.2, 1.6, 57)
    values = [apart(angle) for angle in angles]
    k = next(k for k in range(56) if values[k] * values[k + 1] < 0)
    return brentq(apart, angles[k], angles[k + 1], xtol=1e-15, rtol=1e-15)


def four_bar_tool(q, **changed):
    """Return the tool's turn about x and its position."""
    return four_bar_at(four_bar_rocker(q, **changed), changed.get("pivot", PIVOT))


def four_bar_at(angle, pivot=PIVOT):
    """Return the tool's turn about x and its position at an angle of the rocker."""
    return np.array([angle, *(pivot + LEVER * np.array([0, math.cos(angle), math.sin(angle)]))])


def test_a_spatial_four_bar_with_an_idle_rod_moves_as_a_distance_has_it():
    """The spin of the rod is idle. Errors of lengths and of the rocker's place move the tool, and
    the weights load the crank, as the distance between two balls has it.
    """
    mechanism = four_bar()
    q = 0.7
    state = at(mechanism, q)
    assert state.frames[-1, 0, :3, 3] == pytest.approx(four_bar_tool(q)[1:], abs=1e-12)

    def check(twist, expected):
        assert twist[[0, 3, 4, 5]] == pytest.approx(expected, abs=1e-7)
        assert twist[1:3] == pytest.approx(0.0, abs=1e-12)

    check(moved(state, "crank", 0, 0, 1, 0, 0, 0), differences(lambda x: four_bar_tool(q + x)))
    along = (0, 0, 0, 1, 0, 0)
    lengths = {"crank.tip": ("crank", CRANK), "big end.tip": ("rod", ROD)}
    for place, (name, size) in lengths.items():
        check(
            moved(state, place, *along),
            differences(lambda x: four_bar_tool(q, **{name: size + x})),  # noqa: B023 - called here
        )
    for k, axis in enumerate(np.eye(3)):
        check(
            moved(state, "rocker.seat", 0, 0, 0, *np.eye(3)[k]),
            differences(lambda x: four_bar_tool(q, pivot=PIVOT + x * axis)),  # noqa: B023 - called here
        )
    spun = np.array(four_bar_ends(q, four_bar_rocker(q)))
    assert moved(state, "big end", 1, 0, 0, 0, 0, 0) == pytest.approx(np.zeros(6), abs=1e-12)

    def energy(angle):
        ends = four_bar_ends(angle, four_bar_rocker(angle))
        crank, rod = ends[0] / 2, (ends[0] + ends[1]) / 2
        return 9.80665 * (0.3 * crank + 0.5 * rod + 3 * four_bar_tool(angle)[1:])[2]

    assert np.linalg.norm(spun[0] - spun[1]) == pytest.approx(ROD, abs=1e-14)
    assert state.torques[0, 0] == pytest.approx(differences(lambda x: energy(q + x)), rel=1e-6)


def test_the_seats_of_loaded_balls_are_those_of_least_energy():
    """Two balls of 60 and 100 µm of clearance under all weights: where the tool rests, against the
    least energy over the positions of both balls in their sockets.
    """
    plays, q = (60e-6, 100e-6), 0.7
    balls = [
        {"kind": "ball", "clearance": f"{1e6 * play} µm", "closing_force": "1e-9 N"}
        for play in plays
    ]
    state = at(four_bar(balls), q)

    def tool(offsets):
        # the rod between the centres of the sockets, its balls displaced within them
        shift = offsets[:3] - offsets[3:]

        def apart(angle):
            a, b = four_bar_ends(q, angle)
            return np.linalg.norm(b - a + shift) - ROD

        near = four_bar_rocker(q)
        angle = brentq(apart, near - 0.01, near + 0.01, xtol=1e-15, rtol=1e-15)
        a, b = four_bar_ends(q, angle)
        height, stands = 0.5 * (a + b + offsets[:3] + offsets[3:])[2] / 2, four_bar_at(angle)
        return 9.80665 * (height + 3 * stands[3]), stands

    def seated(angles):
        one, other = (
            0.5
            * play
            * np.array([math.cos(a) * math.cos(b), math.sin(a) * math.cos(b), math.sin(b)])
            for play, (a, b) in zip(plays, np.reshape(angles, (2, 2)), strict=True)
        )
        return np.concatenate([one, other])

    starts = np.random.default_rng(3).uniform(-1.5, 1.5, (4, 4))
    # the energy, of 3e5 in these units, is rounded to 1e-10: the search would not end by less
    found = [
        minimize(lambda x: 1e4 * tool(seated(x))[0], start, method="Nelder-Mead", tol=1e-9)
        for start in starts
    ]
    least = min(found, key=lambda each: each.fun)
    shift = tool(seated(least.x))[1] - four_bar_tool(q)
    matrix = screws(state)
    design = [k for k, each in enumerate(matrix.infos) if not each.draws]
    first = matrix.tool[0][:, design].sum(axis=1)[[0, 3, 4, 5]]
    assert np.linalg.norm(shift[1:]) > 20e-6
    assert first == pytest.approx(shift, abs=5e-3 * np.linalg.norm(shift[1:]))


# ---- a tripod: three legs of hinge, slide and ball -------------------------------------------

BASE, TOP, TOOL = 0.3, 0.18, np.array([0.02, -0.03, 0.1])
ANGLES = np.radians([10.0, 125.0, 250.0])


def tripod():
    """Return a platform on three legs, each a hinge, a slide and a ball, at uneven angles."""
    legs = [
        {
            "name": str(k),
            "place": {**xyz(BASE * math.cos(a), BASE * math.sin(a), 0)}
            | {"rpy": ["0 rad", "0 rad", f"{a} rad"]},
            "end": xyz(TOP * math.cos(a), TOP * math.sin(a), 0),
        }
        for k, a in enumerate(ANGLES, 1)
    ]
    return arm(
        joints=[{"name": "platform", "type": "free", "start": xyz(0, 0, 0.5)}],
        legs=[
            {
                "joins": "platform.tip",
                "copies": legs,
                "joints": [
                    {"name": "hinge", "type": "revolute", "axis": "y", "passive": True},
                    {"name": "slide", "type": "prismatic", "axis": "z"}
                    | {"limits": ["0.4 m", "0.65 m"], "start": "0.515 m"},
                    {"name": "ball", "type": "spherical"},
                ],
            }
        ],
        tool={"after": "platform.tip", "frame": xyz(*TOOL)},
        payload={"mass": "10 kg"},
    )


def rotation(vector):
    """Return the rotation by a vector, by its series of sine and cosine."""
    angle = np.linalg.norm(vector)
    if angle == 0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def tripod_pose(lengths, centres=None, tilts=None, tops=None):
    """Return turn (rotation vector) and position of the platform at which every ball is a leg's
    length from its hinge, in the plane across the hinge's axis: six equations.

    centres, tops  shifts of the joints at base and platform (leg, 3); tilts  (leg, 3) of hinges
    """
    zero = np.zeros((3, 3))
    centres, tilts, tops = (zero if each is None else each for each in (centres, tilts, tops))
    radial = np.column_stack([np.cos(ANGLES), np.sin(ANGLES), np.zeros(3)])
    axes = np.column_stack([-np.sin(ANGLES), np.cos(ANGLES), np.zeros(3)])
    axes = np.array([rotation(tilt) @ axis for tilt, axis in zip(tilts, axes, strict=True)])
    base, top = BASE * radial + centres, TOP * radial + tops

    def misfit(x):
        legs = x[3:] + top @ rotation(x[:3]).T - base
        return np.concatenate(
            [np.linalg.norm(legs, axis=1) - lengths, np.einsum("ki,ki->k", legs, axes)]
        )

    # without the warning of a solution that is exact to rounding
    found = fsolve(misfit, [0, 0, 0, 0, 0, 0.5], xtol=1e-15, full_output=True)[0]
    assert np.abs(misfit(found)).max() < 1e-13
    return found


def test_a_tripod_moves_as_distances_and_planes_have_it():
    """A 3-RPS tripod at uneven angles: leg lengths, places and tilts of hinges and centres of balls
    move the tool, and its weight loads the legs, as six equations of geometry have it.
    """
    lengths = np.array([0.50, 0.53, 0.55])
    state = at(tripod(), lengths)
    pose = tripod_pose(lengths)
    turned = rotation(pose[:3])
    assert state.frames[-1, 0, :3, 3] == pytest.approx(pose[3:] + turned @ TOOL, abs=1e-10)

    def tool(**changed):
        def solve(size):
            return tripod_pose(
                lengths + size * changed.get("lengths", 0.0),
                **{k: size * v for k, v in changed.items() if k != "lengths"},
            )

        ends = [solve(size) for size in (1e-5, -1e-5)]
        turns = [rotation(end[:3]) for end in ends]
        spin = (turns[0] @ turns[1].T - turns[1] @ turns[0].T) / 4e-5
        shift = [end[3:] + turn @ TOOL for end, turn in zip(ends, turns, strict=True)]
        return np.array([spin[2, 1], spin[0, 2], spin[1, 0], *(shift[0] - shift[1]) / 2e-5])

    def unit(leg, axis):
        out = np.zeros((3, 3))
        out[leg] = axis
        return out

    for leg, angle in enumerate(ANGLES):
        name = str(leg + 1)
        c, s = math.cos(angle), math.sin(angle)
        own = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])  # radial, along the hinge, up
        found = moved(state, f"{name}_slide", 0, 0, 0, 0, 0, 1)
        assert found == pytest.approx(tool(lengths=np.eye(3)[leg]), abs=1e-7)
        for k, axis in enumerate(own):
            found = moved(state, f"{name}_hinge.seat", 0, 0, 0, *np.eye(3)[k])
            assert found == pytest.approx(tool(centres=unit(leg, axis)), abs=1e-7)
            found = moved(state, f"{name}_hinge.seat", *np.eye(3)[k], 0, 0, 0)
            assert found == pytest.approx(tool(tilts=unit(leg, axis)), abs=1e-7)
    height = [differences(lambda x: lengths_of(x, leg, lengths), 1e-5) for leg in range(3)]  # noqa: B023 - called here
    assert state.torques[0] == pytest.approx(10 * 9.80665 * np.array(height), rel=1e-6)


def lengths_of(size, leg, lengths):
    """Return the height of the tripod's tool with one leg longer, m."""
    found = tripod_pose(lengths + size * np.eye(3)[leg])
    return (found[3:] + rotation(found[:3]) @ TOOL)[2]


# ---- a coupler on three parallel cranks, by displacements ------------------------------------

SECTION = (8e-4, 3e-7, 5e-7, 6e-7, 0.5)  # area, second moments about y and z, torsion, shear
YOUNG, SHEAR = 70e9, 26e9
LENGTHS = {"arm": 0.3, "rear": 0.2, "front": 0.25, "near": 0.3, "far": 0.3}
ANGLE, DRIVE = 1.1, 4e4


def three_cranks(**near_end):
    """Return a coupler of two links on three parallel cranks of one length, the first driven."""
    metals = metal(YOUNG / 1e9, SHEAR / 1e9)
    bar = {"section": constants(*SECTION), "material": metals, "up": "z"}
    pin = {"type": "revolute", "axis": "z", "passive": True}
    crank = {**pin, "after": "base", "start": f"{ANGLE} rad", "link": link(0.3, **bar)}
    return arm(
        joints=[
            {"name": "arm", "type": "revolute", "axis": "z", "limits": ["0.5 rad", "2 rad"]}
            | {"start": f"{ANGLE} rad", "gearbox": {"stiffness": f"{DRIVE} N m/rad"}}
            | {"link": link(0.3, **bar)},
            {**pin, "name": "rear", "start": f"{-ANGLE} rad", "link": link(0.2, **bar)},
            {"name": "front", "type": "fixed", "after": "rear.tip", "link": link(0.25, **bar)},
            {**crank, "name": "near", "origin": xyz(0.2, 0, 0)},
            {**pin, "name": "near end", "start": f"{-ANGLE} rad", **near_end},
            {**crank, "name": "far", "origin": xyz(0.45, 0, 0)},
            {**pin, "name": "far end", "start": f"{-ANGLE} rad"},
        ],
        closures=[
            {"joins": ["near end.tip", "rear.tip"]},
            {"joins": ["far end.tip", "front.tip"]},
        ],
        tool={"after": "front.tip"},
    )


def beam(start, end):
    """Return the stiffness (12, 12) of a Timoshenko beam between two points of the plane z = 0, in
    base axes; displacements before rotations at each end.
    """
    area, i_y, i_z, torsion, factor = SECTION
    length = np.linalg.norm(end - start)
    k = np.zeros((12, 12))

    def add(rows, block):
        k[np.ix_(rows, rows)] += block

    pair = np.array([[1, -1], [-1, 1]])
    add([0, 6], YOUNG * area / length * pair)
    add([3, 9], SHEAR * torsion / length * pair)
    for rows, second, sign in (([1, 5, 7, 11], i_z, 1), ([2, 4, 8, 10], i_y, -1)):
        phi = 12 * YOUNG * second / (SHEAR * area * factor * length**2)
        a, b = 6 * length * sign, length**2
        block = np.array(
            [
                [12, a, -12, a],
                [a, (4 + phi) * b, -a, (2 - phi) * b],
                [-12, -a, 12, -a],
                [a, (2 - phi) * b, -a, (4 + phi) * b],
            ]
        )
        add(rows, YOUNG * second / (length**3 * (1 + phi)) * block)
    x = (end - start) / length
    turn = np.array([x, [-x[1], x[0], 0], [0, 0, 1]])
    whole = np.kron(np.eye(4), turn)
    return whole.T @ k @ whole


def frame(load, longer=0.0, *, loose=False):
    """Return the tool's displacement and rotation (6,) under a load (6,), force before moment, with
    the far crank longer: beams with hinges as constraints, by Lagrange's multipliers.

    loose  whether the hinge at the end of the near crank holds only what the mechanism needs: it
           turns about all axes, and slides along the crank
    """
    up = 0.3 * np.array([math.cos(ANGLE), math.sin(ANGLE), 0.0])
    feet = np.array([[0, 0, 0], [0.2, 0, 0], [0.45, 0, 0]], dtype=float)
    tops = feet + up
    # nodes: foot and top of each crank, then the coupler's own nodes at each top
    members = [(0, 1, feet[0], tops[0]), (2, 3, feet[1], tops[1]), (4, 5, feet[2], tops[2])]
    members += [(6, 7, tops[0], tops[1]), (7, 8, tops[1], tops[2])]
    k = np.zeros((54, 54))
    for a, b, start, end in members:
        rows = np.r_[6 * a : 6 * a + 6, 6 * b : 6 * b + 6]
        k[np.ix_(rows, rows)] += beam(start, end)
    k[5, 5] += DRIVE  # the drive turns about z
    rows, right = [], []
    for foot in (0, 2, 4):
        for freedom in range(5):
            row = np.zeros(54)
            row[6 * foot + freedom] = 1
            rows.append(row)
            right.append(0.0)
    for top, node in ((1, 6), (3, 7), (5, 8)):
        for freedom in range(5):
            row = np.zeros(54)
            row[6 * node + freedom], row[6 * top + freedom] = 1, -1
            rows.append(row)
            # the tip of the far crank lies farther out than its beam ends
            right.append(longer * up[freedom] / 0.3 if top == 5 and freedom < 3 else 0.0)
    if loose:
        x, y, z, *_ = (rows[15 + 5 + freedom] for freedom in range(5))
        rows[20:25] = [(-math.sin(ANGLE) * x + math.cos(ANGLE) * y), z]
        right[20:25] = [0.0, 0.0]
    held = np.array(rows)
    force = np.zeros(54)
    force[48:] = load
    whole = np.block([[k, held.T], [held, np.zeros((len(held), len(held)))]])
    found = np.linalg.solve(whole, np.concatenate([force, right]))[48:54]
    return found[[3, 4, 5, 0, 1, 2]]


def test_a_coupler_on_three_cranks_deflects_as_a_displacement_method_has_it():
    """One crank more than a parallelogram needs, all in space: with two closures of rigid hinges. The
    tool's compliance is that of a frame of beams, and a crank that is too long stresses it.
    """
    state = at(three_cranks(), ANGLE)
    expected = np.array([frame(np.roll(row, 3)) for row in np.eye(6)]).T
    found = state.compliance[0]
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    np.testing.assert_allclose(found / scale, expected / scale, atol=1e-7)
    long = moved(state, "far.tip", 0, 0, 0, 1, 0, 0)
    np.testing.assert_allclose(long, frame(np.zeros(6), 1.0), atol=1e-7)
