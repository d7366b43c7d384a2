"""Denavit-Hartenberg rows, standard and modified."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model.provenance import states
from lostmotion.io.dh import rpy_of
from lostmotion.io.native import arm_of
from lostmotion.mechanism.state import state_of
from lostmotion.spatial import pose_of, shift, turn
from tests.io.conftest import JOINT
from tests.parts.conditions import local_screws

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "scatter of the tool by tolerances of Denavit-Hartenberg values",
        (
            "40 000 products of the table with deviating values, both conventions, turning and "
            "sliding joints"
        ),
        "3 %",
        "io/dh.py",
    ),
)
UR5E = {
    "a": [0, -0.425, -0.3922, 0, 0, 0],
    "d": [0.1625, 0, 0, 0.1333, 0.0997, 0.0996],
    "alpha": [90, 0, 0, 90, -90, 0],
}
X, Z = (1, 0, 0), (0, 0, 1)


def arm_of_rows(key, rows, kinds=None):
    """Make an arm of rows (a, alpha, d, theta) in m and degrees."""
    joints = []
    for k, (a, alpha, d, theta) in enumerate(rows):
        row = {
            "a": f"{a!r} m",
            "alpha": f"{alpha!r} deg",
            "d": f"{d!r} m",
            "theta": f"{theta!r} deg",
        }
        kind = kinds[k] if kinds else "revolute"
        limits = ["-360 deg", "360 deg"] if kind == "revolute" else ["-9 m", "9 m"]
        joints.append({"name": f"J{k}", "type": kind, "limits": limits, key: row})
    return arm_of("x", {"name": "x", "joints": joints})


def standard_rows():
    """Return the UR5e's rows by the standard convention, with some offsets in theta."""
    return list(
        zip(UR5E["a"], UR5E["alpha"], UR5E["d"], [0.0, 10.0, 0.0, -90.0, 33.0, 5.0], strict=True)
    )


def by_hand(rows, q, kinds, *, modified):
    """Multiply the four elementary motions of every row as the convention orders them."""
    pose = np.eye(4)
    for (a, alpha, d, theta), value, kind in zip(rows, q, kinds, strict=True):
        angle = math.radians(theta) + (value if kind == "revolute" else 0)
        slide = d + (value if kind == "prismatic" else 0)
        across, along = (
            shift(a, 0, 0) @ turn(X, math.radians(alpha)),
            turn(Z, angle) @ shift(0, 0, slide),
        )
        pose = pose @ (across @ along if modified else along @ across)
    return pose


@pytest.mark.parametrize(("key", "modified"), [("dh", False), ("mdh", True)])
def test_rows_multiply_as_their_convention_orders(key, modified):
    """Random rows of turning and sliding joints lead where the four elementary motions of each row
    lead.
    """
    rng = np.random.default_rng(5)
    for _ in range(50):
        count = int(rng.integers(1, 8))
        kinds = [str(kind) for kind in rng.choice(["revolute", "prismatic"], count)]
        rows = [
            tuple(
                float(v)
                for v in (
                    rng.normal(),
                    rng.choice([0, 90, -90, 180, 37]),
                    rng.normal(),
                    rng.choice([0, 90, -90, 12]),
                )
            )
            for _ in kinds
        ]
        q = rng.uniform(-2, 2, count)
        assert (
            np.abs(
                state_of(arm_of_rows(key, rows, kinds), q).frames[-1, 0]
                - by_hand(rows, q, kinds, modified=modified)
            ).max()
            < 1e-12
        )


@pytest.mark.parametrize("key", ["dh", "mdh"])
def test_fixed_joints_without_a_row_stand_beside_rows(key):
    """A plinth, a plate between two links and a flange have origins of their own; the product of
    all motions is that by hand.
    """
    place = {"xyz": ["10 mm", "-20 mm", "300 mm"], "rpy": ["10 deg", "20 deg", "-30 deg"]}
    matrix = pose_of((0.01, -0.02, 0.3), np.radians([10, 20, -30]))
    rows = standard_rows()
    plain = arm_of_rows(key, rows)
    joints = []
    for k, (a, alpha, d, theta) in enumerate(rows):
        row = {
            "a": f"{a!r} m",
            "alpha": f"{alpha!r} deg",
            "d": f"{d!r} m",
            "theta": f"{theta!r} deg",
        }
        if k in {0, 3}:
            joints.append({"name": f"plate {k}", "type": "fixed", "origin": place})
        joints.append(
            {"name": f"J{k}", "type": "revolute", "limits": ["-360 deg", "360 deg"], key: row}
        )
    joints.append(
        {
            "name": "flange",
            "type": "fixed",
            "origin": place,
            "link": {"tip": {"xyz": ["0 mm", "0 mm", "50 mm"]}},
        }
    )
    arm = arm_of("x", {"name": "x", "joints": joints})
    q = np.random.default_rng(8).uniform(-3, 3, (20, 6))
    for row, pose in zip(q, state_of(arm, q).frames[-1], strict=True):
        first = by_hand(rows[:3], row[:3], ["revolute"] * 3, modified=key == "mdh")
        last = by_hand(rows[3:], row[3:], ["revolute"] * 3, modified=key == "mdh")
        assert (
            np.abs(matrix @ first @ matrix @ last @ matrix @ shift(0, 0, 0.05) - pose).max() < 1e-12
        )
    assert [joint.name for joint in arm.moving] == [joint.name for joint in plain.moving]


@pytest.mark.parametrize("key", ["dh", "mdh"])
def test_a_row_behind_after_begins_a_chain_of_its_own(key):
    """A second chain that stands on a joint of the first is the product of its own rows from there,
    whatever the row listed before it says.
    """
    rows, q = standard_rows(), np.random.default_rng(3).uniform(-2, 2, 6)
    joints = [
        {
            "name": f"J{k}",
            "type": "revolute",
            "limits": ["-360 deg", "360 deg"],
            key: {
                "a": f"{a!r} m",
                "alpha": f"{alpha!r} deg",
                "d": f"{d!r} m",
                "theta": f"{theta!r} deg",
            },
        }
        for k, (a, alpha, d, theta) in enumerate(rows)
    ]
    joints[4]["after"] = "J1.tip"
    arm = arm_of("x", {"name": "x", "joints": joints})
    kinds, modified = ["revolute"] * 6, key == "mdh"
    first = state_of(arm_of_rows(key, rows[:4]), q[:4]).frames[arm.places.index("J1.tip"), 0]
    second = by_hand(rows[4:], q[4:], kinds[4:], modified=modified)
    assert np.abs(state_of(arm, q).frames[-1, 0] - first @ second).max() < 1e-12


def test_both_conventions_describe_the_same_ur5e():
    """The modified table of an arm is its standard one with a and alpha moved on by a row; both
    have the same frames at all joints and the tool.
    """
    rows = standard_rows()
    moved = [
        (a, alpha, d, theta)
        for (a, alpha, _, _), (_, _, d, theta) in zip(
            [(0.0, 0.0, 0, 0), *rows[:-1]], rows, strict=True
        )
    ]
    one, other = arm_of_rows("dh", rows), arm_of_rows("mdh", moved)
    q = np.random.default_rng(2).uniform(-3, 3, (20, 6))
    assert np.abs(state_of(one, q).frames - state_of(other, q).frames).max() < 1e-12


@pytest.mark.parametrize("pitch", [0.0, 90.0, -90.0, 89.9999999, 180.0, 45.0])
def test_roll_pitch_yaw_come_back_from_the_matrix(pitch):
    """Also where pitch is 90 degrees and roll and yaw are one angle, and without a warning."""
    rng = np.random.default_rng(1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for roll, yaw in [
            *rng.uniform(-math.pi, math.pi, (50, 2)),
            (0.0, 0.0),
            (math.pi, -math.pi / 2),
        ]:
            rotation = pose_of(rpy=(roll, math.radians(pitch), yaw))[:3, :3]
            assert np.abs(pose_of(rpy=rpy_of(rotation))[:3, :3] - rotation).max() < 2e-15


ROW = '{ a = "0 mm", alpha = "90 deg", d = "100 mm", theta = "0 deg" }'


@pytest.mark.parametrize(
    ("lines", "key", "expected"),
    [
        (f"dh = {ROW}\naxis = 'x'\n", "joints.A.axis", "not both"),
        (f"dh = {ROW}\norigin = {{}}\n", "joints.A.origin", "not both"),
        (f"dh = {ROW}\nlink = {{ length = '3 m' }}\n", "joints.A.link.length", "length_tolerance"),
        (f"dh = {ROW}\nlink = {{ tip = {{}} }}\n", "joints.A.link.tip", "not both"),
        (f"dh = {ROW}\nmdh = {ROW}\n", "joints.A", "the same one key"),
        (
            "dh = { a = '0 mm', alpha = '9 mm', d = '1 m', theta = '0 deg' }\n",
            "joints.A.dh.alpha",
            "angle",
        ),
        (
            "dh = { a = '0 mm', alfa = '9 deg', alpha = '9 deg', d = '1 m', theta = '0 deg' }\n",
            "joints.A.dh.alfa",
            "alpha",
        ),
        ("dh = { a = '0 mm', alpha = '9 deg', d = '1 m' }\n", "joints.A.dh.theta", "angle"),
        ("mdh = [0, 1, 2, 3]\n", "joints.A.mdh", "a table"),
        (
            f"dh = {ROW}\n" + JOINT.replace('"A"', '"B"') + f"mdh = {ROW}\n",
            "joints.B",
            "the same one key",
        ),
        (f"dh = {ROW}\n" + JOINT.replace('"A"', '"B"'), "joints.B", "the same one key"),
    ],
)
def test_a_row_says_everything_once(mistakes_in, lines, key, expected):
    """A row excludes what it says itself, and one convention holds for the whole arm."""
    found = mistakes_in('name = "x"\n' + JOINT + lines)
    assert list(found) == [key]
    assert expected in found[key].expected


def test_a_link_behind_a_row_keeps_its_beam():
    """Section, material and a length tolerance go with a row; the tolerance acts along the line to
    the next joint.
    """
    row = {"a": "300 mm", "alpha": "90 deg", "d": "400 mm", "theta": "0 deg"}
    link = {
        "section": {"kind": "rod", "diameter": "40 mm"},
        "material": "steel",
        "length_tolerance": "50 µm",
    }
    arm = arm_of(
        "x",
        {
            "name": "x",
            "joints": [
                {
                    "name": "A",
                    "type": "revolute",
                    "limits": ["0 deg", "1 deg"],
                    "dh": row,
                    "link": link,
                }
            ],
        },
    )
    assert arm.joints[0].link.reach == pytest.approx(0.5)
    length, screw = next(
        each for each in local_screws(arm, np.zeros(1)) if each[0].name == "joints.A.link.length"
    )
    seen_from_joint = arm.joints[0].link.tip_pose[:3, :3] @ screw[0, 3:]
    assert seen_from_joint * length.term.bound == pytest.approx(50e-6 * np.array([0.6, 0, 0.8]))


# Of a six-axis arm: limits of a (mm), alpha (deg), d (mm) and theta (deg) of each row; 19 of 24 are
# known. Every third one is uniform.
LIMITS = [
    (0.10, 0.020, 0.15, None),
    (0.20, 0.015, None, 0.030),
    (0.25, 0.040, 0.10, 0.020),
    (None, 0.010, 0.20, 0.050),
    (0.05, None, 0.12, 0.040),
    (0.08, 0.030, 0.06, None),
]


def _stated(value, limit, unit, number):
    return f"{value!r} {unit}" + (
        "" if limit is None else f" ± {limit!r} {unit}" + (" (uniform)" if number % 3 == 0 else "")
    )


def toleranced_arm(key, rows, kinds):
    """Return an arm of these rows (a, alpha, d, theta) in m and degrees, whose values have the
    limits above.
    """
    joints = []
    for k, (row, limits, kind) in enumerate(zip(rows, LIMITS, kinds, strict=True)):
        units = ("mm", "deg", "mm", "deg")
        values = [
            1e3 * value if unit == "mm" else value for value, unit in zip(row, units, strict=True)
        ]
        stated = [
            _stated(value, limit, unit, 4 * k + n)
            for n, (value, limit, unit) in enumerate(zip(values, limits, units, strict=True))
        ]
        reach = ["-360 deg", "360 deg"] if kind == "revolute" else ["-9 m", "9 m"]
        joints.append(
            {
                "name": f"J{k}",
                "type": kind,
                "limits": reach,
                key: dict(zip(("a", "alpha", "d", "theta"), stated, strict=True)),
            }
        )
    return arm_of("x", {"name": "x", "joints": joints})


def drawn(rng, limit, number, count):
    """Return deviations within a limit: uniform, or normal with three standard deviations at the
    limit, cut there.
    """
    if limit is None:
        return np.zeros(count)
    if number % 3 == 0:
        return rng.uniform(-limit, limit, count)
    out = rng.normal(0, limit / 3, 2 * count)
    return out[np.abs(out) <= limit][:count]


def products(rows, q, kinds, deviations, *, modified):
    """Return the end of the chain (sample, 3) with deviating values, from the four elementary
    motions of every row; m and rad.
    """
    pose = np.broadcast_to(np.eye(4), (len(deviations[0][0]), 4, 4))
    for (a, alpha, d, theta), value, kind, off in zip(rows, q, kinds, deviations, strict=True):
        angle = math.radians(theta) + np.radians(off[3]) + (value if kind == "revolute" else 0.0)
        slide = d + 1e-3 * off[2] + (value if kind == "prismatic" else 0.0)
        across = np.zeros((len(angle), 4, 4))
        cos, sin = (
            np.cos(math.radians(alpha) + np.radians(off[1])),
            np.sin(math.radians(alpha) + np.radians(off[1])),
        )
        across[:, 0, 0] = across[:, 3, 3] = 1
        across[:, 1, 1], across[:, 1, 2], across[:, 2, 1], across[:, 2, 2] = cos, -sin, sin, cos
        across[:, 0, 3] = a + 1e-3 * off[0]
        along = np.zeros_like(across)
        along[:, 2, 2] = along[:, 3, 3] = 1
        along[:, 0, 0], along[:, 0, 1], along[:, 1, 0], along[:, 1, 1] = (
            np.cos(angle),
            -np.sin(angle),
            np.sin(angle),
            np.cos(angle),
        )
        along[:, 2, 3] = slide
        pose = pose @ (across @ along if modified else along @ across)
    return pose[:, :3, 3]


@pytest.mark.parametrize(("key", "modified"), [("dh", False), ("mdh", True)])
@pytest.mark.parametrize("sliding", [(), (2,)])
def test_tolerances_of_a_table_scatter_the_tool_as_the_tables_product_does(key, modified, sliding):
    """Covariance of the tool's position at four poses, against 40 000 products of the table with
    deviating values: each axis within 3 %.
    """
    rng = np.random.default_rng(4)
    rows = standard_rows()
    rows[0] = (0.05, 90.0, 0.1625, 25.0)  # a first row with all four values
    kinds = ["prismatic" if k in sliding else "revolute" for k in range(6)]
    arm = toleranced_arm(key, rows, kinds)
    stated = [term for term in arm.terms if term.term.robot is not None]
    assert len(stated) == sum(limit is not None for row in LIMITS for limit in row) == 19
    for q in rng.uniform(-2, 2, (4, 6)):
        screws = tool_screws(arm, q)
        expected = screws.T @ screws
        off = [
            [drawn(rng, limit, 4 * k + n, 40_000) for n, limit in enumerate(row)]
            for k, row in enumerate(LIMITS)
        ]
        found = np.cov(products(rows, q, kinds, off, modified=modified).T)
        scale = np.sqrt(np.diag(expected))
        np.testing.assert_allclose(np.sqrt(np.diag(found)), scale, rtol=0.03)
        np.testing.assert_allclose(
            found / np.outer(scale, scale), expected / np.outer(scale, scale), atol=0.04
        )


def tool_screws(arm, q):
    """Return the displacement of the tool (term, 3), m, per standard deviation of each term, in the
    base's axes.
    """
    matrix = lostmotion.screws(lostmotion.state_of(arm, q[None]))
    return matrix.tool[0, 3:].T


@pytest.mark.parametrize(
    ("lines", "key"),
    [
        ('mounting = { tilt = "1 arcmin" }\n', "joints.A.mounting"),
        ('link = { length_tolerance = "50 µm" }\n', "joints.A.link.length_tolerance"),
        (
            'link = { tip_tolerance = { offset = ["50 µm", "0 µm", "0 µm"] } }\n',
            "joints.A.link.tip_tolerance",
        ),
    ],
)
def test_a_tolerance_is_stated_once(mistakes_in, lines, key):
    """In the row, or beside it."""
    row = (
        'dh = { a = "400 mm ± 0.1 mm", alpha = "90 deg", d = "100 mm", theta = "0 deg ± 0.02 deg" '
        "}\n"
    )
    found = mistakes_in('name = "x"\n' + JOINT + row + lines)
    assert list(found) == [key]
    assert "not both" in found[key].expected


def test_a_row_that_is_assumed_has_assumed_tolerances():
    """`assumed = ["dh"]` counts its tolerances too; a row without ± leaves mounting and length
    undescribed.
    """
    row = {"a": "400 mm ± 0.1 mm", "alpha": "90 deg", "d": "100 mm", "theta": "0 deg ± 0.02 deg"}
    exact = {key: value.partition(" ±")[0] for key, value in row.items()}
    for stated, state in ((row, "assumed"), (exact, "ideal")):
        joint = {
            "name": "A",
            "type": "revolute",
            "limits": ["0 deg", "1 deg"],
            "dh": stated,
            "assumed": ["dh"],
        }
        known = states(arm_of("x", {"name": "x", "joints": [joint]})).joints[0].states
        assert (known["axis mounting"], known["link length"]) == (state, state)
