"""Keys with a place or a direction are seen from the frames that the table of docs/conventions.md
names: a probe each, against frames by hand.
"""

from __future__ import annotations

import re
import typing
from pathlib import Path

import numpy as np
import pytest
from pydantic import BaseModel

import lostmotion
from lostmotion.laws.elastic_foundation import track_stiffness
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.state import state_of
from lostmotion.parts.frame import Frame
from lostmotion.spatial import pose_of

PAGE = Path(__file__).parents[2] / "docs" / "conventions.md"
Q = np.array([0.7, -0.4])
GRAVITY = 9.81
STANDS = {"xyz": (0.1, -0.2, 0.3), "rpy": (0.3, -0.2, 0.5)}
TILT = {"roll": 0.2, "pitch": -0.15}
ORIGINS = [
    {"xyz": (0.05, 0.1, 0.2), "rpy": (0.4, 0.1, -0.3)},
    {"xyz": (0.02, -0.03, 0.07), "rpy": (-0.2, 0.6, 0.3)},
]
AXES = [(0.2, 0.3, 0.9), (0.5, -0.2, 0.8)]
TIPS = [
    {"xyz": (0.3, 0.1, 0.2), "rpy": (0.1, 0.5, 0.2)},
    {"xyz": (0.25, -0.1, 0.15), "rpy": (0.7, -0.3, 0.4)},
]
TOOL = {"xyz": (0.05, 0.02, 0.12), "rpy": (0.2, 0.9, -0.5)}
V = (0.11, -0.07, 0.13)
FORCE = (30.0, -20.0, 50.0)


def arm_with(base=None, joint=None, link=None, tool=None, payload=None):
    """Return an arm of two joints without masses, whose frames are all turned; its second joint,
    tool and payload have these fields too.
    """
    joints = [
        {
            "name": name,
            "type": "revolute",
            "limits": (-3, 3),
            "axis": axis,
            "origin": origin,
            "mass": 0.0,
            "link": {"tip": tip},
        }
        for name, axis, origin, tip in zip("AB", AXES, ORIGINS, TIPS, strict=True)
    ]
    joints[1] = {
        **joints[1],
        **(joint or {}),
        "link": {**(joints[1]["link"] if not (link or {}).get("length") else {}), **(link or {})},
    }
    stated = {
        "base": {**STANDS, **TILT, **(base or {})},
        "tool": {"frame": TOOL, **(tool or {})},
        "payload": payload or {},
    }
    return Arm(name="x", joints=joints, gravity=GRAVITY, **stated)


def turned(axis, angle):
    """Return the rotation (3, 3) about an axis, by Rodrigues."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * skew + (1 - np.cos(angle)) * skew @ skew


def pose(frame):
    """Return the pose (4, 4) of xyz and rpy."""
    return pose_of(frame["xyz"], frame["rpy"])


def by_hand(q=Q):
    """Return the frames that the table names, for the second joint, in the base's axes."""
    at = pose(STANDS)
    for value, axis, origin, tip in zip(q, AXES, ORIGINS, TIPS, strict=True):
        before, seat = at, at @ pose(origin)
        joint = seat.copy()
        joint[:3, :3] = seat[:3, :3] @ turned(axis, value)
        at = joint @ pose(tip)
    level = np.eye(4)
    level[:3, :3] = (turned((0, 1, 0), TILT["pitch"]) @ turned((1, 0, 0), TILT["roll"])).T
    named = {
        "base": np.eye(4),
        "level ground": level,
        "place before": before,
        "seat": seat,
        "joint": joint,
        "tip": at,
        "flange": at,
    }
    return {**named, "tool": at @ pose(TOOL)}


AT = by_hand()
POINT = AT["tool"][:3, 3]
PROCESS = AT["tool"][:3, :3] @ FORCE
DOWN = AT["level ground"][:3, :3] @ [0, 0, -GRAVITY]


def rows():
    """Return the table: key to the frame whose origin counts, and the frame whose axes count."""
    section = PAGE.read_text("utf-8").partition("## Frames")[2].partition("\n## ")[0]
    out = {}
    for keys, origin, axes in re.findall(
        r"^\| (`[^|]+) \| ([^|]+) \| ([^|]+) \|$", section, re.MULTILINE
    ):
        out |= dict.fromkeys(re.findall(r"`([^`]+)`", keys), (origin, axes))
    return out


def of_mass(where, field, mass="mass"):
    """Return a probe of a centre of mass: the moment of one weight on the base."""

    def probe(place, axes):
        fields = {where: {mass: 2.0, field: V}}
        found = state_of(arm_with(**fields), Q[None]).wrenches[0, 0, :3]
        return found, np.cross(place + axes @ V, 2.0 * DOWN)

    return probe


def of_place(name, before=None, **fields):
    """Return a probe of a frame: where a place of the arm is, and how it is turned."""

    def probe(place, axes):
        arm = arm_with(**fields)
        expected = np.eye(4)
        expected[:3, :3], expected[:3, 3] = axes, place
        stated = {"xyz": V, "rpy": (0.3, 0.2, 0.1)}
        expected = expected @ pose(stated) @ (np.eye(4) if before is None else pose(before))
        return state_of(arm, Q[None]).frames[arm.places.index(name), 0], expected

    return probe


STATED = {"xyz": V, "rpy": (0.3, 0.2, 0.1)}


def of_term(word, turn=None, shift=None, **fields):
    """Return a probe of an error's direction: how its term turns and shifts the tool, as unit
    vectors.
    """

    def probe(place, axes):
        matrix = lostmotion.screws(lostmotion.state_of(arm_with(**fields), Q[None]))
        (column,) = [k for k, info in enumerate(matrix.infos) if word in info.name]
        way = matrix.tool[0, :, column]
        if shift is not None:
            return way / np.linalg.norm(way), np.concatenate(
                [np.zeros(3), axes @ shift / np.linalg.norm(shift)]
            )
        about = axes @ turn / np.linalg.norm(turn)
        return way / np.linalg.norm(way[:3]), np.concatenate(
            [about, np.cross(about, POINT - place)]
        )

    return probe


def of_spring(stiffness, **fields):
    """Return a probe of a compliance: the shift of the tool under a process force, by a compliance
    (6, 6) in a frame.
    """

    def probe(place, axes):
        arm = arm_with(payload={"force": FORCE}, **fields)
        six = np.kron(np.eye(2), axes)
        twist = six @ np.linalg.solve(
            stiffness, six.T @ np.concatenate([np.cross(POINT - place, PROCESS), PROCESS])
        )
        return lostmotion.screws(lostmotion.state_of(arm, Q[None])).bias[0, 3:], twist[
            3:
        ] + np.cross(twist[:3], POINT - place)

    return probe


def of_tracks(place, axes):
    """Return the shift of the tool on two tracks, whose middle is stated."""
    fields = {"length": 0.8, "width": 0.15, "gauge": 0.6, "bedding": 5e7}
    stiffness = np.diag(track_stiffness(*fields.values(), 0.5))
    return of_spring(stiffness, base={"tracks": {**fields, "middle": V}})(place + axes @ V, axes)


def of_axis(place, axes):
    """Return how the tool moves with the second joint, from a small difference."""
    arm = arm_with()
    found = (
        state_of(arm, (Q + STEP)[None]).frames[-1, 0, :3, 3]
        - state_of(arm, (Q - STEP)[None]).frames[-1, 0, :3, 3]
    ) / (2 * STEP[1])
    return found, np.cross(axes @ AXES[1] / np.linalg.norm(AXES[1]), POINT - place)


def of_direction(_, axes):
    """Return where a link by length and direction ends."""
    arm = arm_with(link={"length": 0.4, "direction": V})
    return state_of(arm, Q[None]).frames[arm.places.index("B.tip"), 0, :3, 3], AT["joint"][
        :3, 3
    ] + axes @ (0.4 * np.array(V) / np.linalg.norm(V))


def of_up(_, axes):
    """Return the bending of a flat bar along its height, under a force along it: F L^3 / (3 E
    I).
    """
    # the tool has the axes of the joint here
    force = AT["joint"][:3, :3].T @ axes @ np.array([0.0, 0.0, 10.0])
    section = {"kind": "rectangle", "height": 0.01, "width": 0.03}
    material = {"young": 70e9, "poisson": 0.33, "density": 1e-3}
    link = {
        "length": 0.5,
        "direction": "x",
        "up": "z",
        "section": section,
        "material": material,
        "mass": 0.0,
    }
    arm = arm_with(link=link, tool={"frame": {}}, payload={"force": tuple(force)})
    found = lostmotion.screws(lostmotion.state_of(arm, Q[None])).bias[0, 3:]
    return found / (10 * 0.5**3 / (3 * 70e9 * 0.03 * 0.01**3 / 12)), axes @ np.array(
        [0.0, 0.0, 1.0]
    )


SPRING = np.diag([2e4, 3e4, 5e4, 2e6, 3e6, 7e6]) + 100.0
ONLY_TURNS, ONLY_SHIFTS = (
    np.diag([2e4, 3e4, 5e4, *[1e30] * 3]),
    np.diag([*[1e30] * 3, 2e6, 3e6, 7e6]),
)
MATRIX = tuple(map(tuple, np.linalg.inv(SPRING).tolist()))
Y = np.array([0.0, 1.0, 0.0])
STEP = np.array([0.0, 1e-6])
LEAST = (0.0, 1e-3, 0.0)
ACROSS = np.array(AXES[1]) / np.linalg.norm(AXES[1])
SLIDE = {"type": "prismatic", "limits": (-3, 3)}
PROBES = {
    "base.xyz": of_place("A.seat", ORIGINS[0], base=STATED),
    "base.rpy": of_place("A.seat", ORIGINS[0], base=STATED),
    "base.roll": of_term(
        "roll", turn=np.eye(3)[0], base={"roll": lostmotion.units.Toleranced(TILT["roll"], 1e-3)}
    ),
    "base.pitch": of_term(
        "pitch", turn=Y, base={"pitch": lostmotion.units.Toleranced(TILT["pitch"], 1e-3)}
    ),
    "base.angular_stiffness": of_spring(ONLY_TURNS, base={"angular_stiffness": (2e4, 3e4, 5e4)}),
    "base.linear_stiffness": of_spring(ONLY_SHIFTS, base={"linear_stiffness": (2e6, 3e6, 7e6)}),
    "base.compliance": of_spring(SPRING, base={"compliance": {"matrix": MATRIX}}),
    "base.tracks.middle": of_tracks,
    "joints.origin": of_place("B.seat", joint={"origin": STATED}),
    "joints.axis": of_axis,
    "joints.mounting.tilt": of_term("mounting", turn=Y, joint={"mounting": {"tilt": LEAST}}),
    "joints.mounting.offset": of_term("mounting", shift=Y, joint={"mounting": {"offset": LEAST}}),
    "joints.mounting.axes": of_term(
        "mounting",
        turn=turned((0, 0, 1), 0.4) @ Y,
        joint={"mounting": {"tilt": LEAST, "axes": (0, 0, 0.4)}},
    ),
    "joints.centre_of_mass": of_mass("joint", "centre_of_mass"),
    "joints.lumped.offset_along": of_term(
        "lumped", shift=Y, joint={"lumped": {"offset": 1e-3, "offset_along": ["y"]}}
    ),
    "joints.link.direction": of_direction,
    "joints.link.tip": of_place("B.tip", link={"tip": STATED}),
    "joints.link.centre_of_mass": of_mass("link", "centre_of_mass"),
    "joints.link.up": of_up,
    "joints.link.tip_tolerance": of_term(
        "tip tilt", turn=Y, link={"tip_tolerance": {"tilt": LEAST}}
    ),
    "joints.link.compliance": of_spring(SPRING, link={"compliance": {"matrix": MATRIX}}),
    "tool.frame": of_place("tool", tool={"frame": STATED}),
    "tool.centre_of_mass": of_mass("tool", "centre_of_mass"),
    "payload.centre_of_mass": of_mass("payload", "centre_of_mass"),
}


def of_slide(straightness, direction):
    """Return a probe of a guideway: the shift of the tool along a direction across the axis; the
    joint stands at zero, where it does not turn.
    """

    def probe(_, axes):
        joint = {**SLIDE, "guideway": {"straightness": straightness, "up": V}}
        matrix = lostmotion.screws(
            lostmotion.state_of(arm_with(joint=joint), np.array([[Q[0], 0.0]]))
        )
        columns = [k for k, info in enumerate(matrix.infos) if "straightness" in info.name]
        shift = next(way for k in columns if np.linalg.norm(way := matrix.tool[0, 3:, k]) > 0)
        unturned = axes @ turned(AXES[1], Q[1]).T
        return np.abs(shift @ unturned @ direction) / np.linalg.norm(shift), 1.0

    return probe


UP = np.array(V) - ACROSS * (ACROSS @ V)
UP /= np.linalg.norm(UP)
PROBES["joints.guideway.up"] = of_slide((1e-3, 0.0), UP)
PROBES["joints.guideway.straightness"] = of_slide((0.0, 1e-3), np.cross(ACROSS, UP))


def of_process(place, axes):
    """Return force and moment on the base of a process force on the tool."""
    return state_of(arm_with(payload={"force": FORCE}), Q[None]).wrenches[0, 0], np.concatenate(
        [np.cross(place, axes @ FORCE), axes @ FORCE]
    )


def of_moment(_, axes):
    """Return the moment on the base of a process moment."""
    return state_of(arm_with(payload={"moment": FORCE}), Q[None]).wrenches[0, 0], np.concatenate(
        [axes @ FORCE, np.zeros(3)]
    )


PROBES |= {"payload.force": of_process, "payload.moment": of_moment}
# Where the origin of the frame does not count.
FREE = {
    "joints.mounting.offset",
    "joints.lumped.offset_along",
    "joints.guideway.up",
    "joints.guideway.straightness",
    "joints.link.direction",
    "joints.link.up",
    "payload.moment",
    "base.linear_stiffness",
}


@pytest.mark.parametrize("key", PROBES)
def test_a_key_is_seen_from_the_frame_that_the_table_names(key):
    """Within rounding; and from any other frame of the arm the probe would differ, so that it could
    not pass by chance.
    """
    origin, axes = rows()[key]

    def differs(one, other):
        found, expected = PROBES[key](AT[one][:3, 3], AT[other][:3, :3])
        return np.abs(np.asarray(found) - expected).max() / np.abs(found).max()

    bound = 5e-3 if key == "joints.link.up" else 1e-5 if key == "joints.axis" else 1e-9
    assert differs(origin, axes) < bound
    alike = {name for name, frame in AT.items() if np.allclose(frame[:3, 3], AT[origin][:3, 3])}
    for other in AT:
        if not np.allclose(AT[other][:3, :3], AT[axes][:3, :3]) and not (
            key == "joints.axis" and other == "joint"
        ):
            assert differs(origin, other) > 1e-3, other
        if key not in FREE and other not in alike:
            assert differs(other, axes) > 1e-3, other


# Of closed chains, which are probed in test_closed_reference.
OF_CLOSURES = {"closures.frames", "joints.start", "joints.axes"}


def _placed(model, path="", seen=()):
    """Yield the keys of a model whose values are places, directions or frames: three of a kind,
    letters of axes, and frames.
    """
    for name, field in model.model_fields.items():
        key = f"{path}.{name}".lstrip(".")
        parts = list(_parts(field.annotation))
        if any(part is Frame or _is_three(part) for part in parts):
            yield key
        elif name != "gearbox":
            for inner in parts:
                if isinstance(inner, type) and issubclass(inner, BaseModel) and inner not in seen:
                    yield from _placed(inner, key, (*seen, inner))


def _parts(annotation):
    yield annotation
    for inner in typing.get_args(annotation):
        yield from _parts(inner)


def _is_three(part):
    inner = typing.get_args(part)
    return (typing.get_origin(part) is tuple and len(inner) == 3 and Ellipsis not in inner) or {
        "x",
        "y",
        "z",
    } <= {*map(str, inner)}


def test_every_key_with_a_place_or_a_direction_is_in_the_table():
    """A new field of three values, a direction or a frame needs its row, and each row a probe."""
    table = rows()
    assert table.keys() == PROBES.keys()
    found = set(_placed(Arm))
    assert len(found) > 15
    assert {
        key
        for key in found - OF_CLOSURES
        if not any(key == row or key.startswith(f"{row}.") for row in table)
    } == set()
