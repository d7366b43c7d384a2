"""Platforms of MJCF that legs alone carry, and ball joints within loops, beside MuJoCo."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lostmotion.mechanism.state import state_of
from tests.io.conftest import mistakes
from tests.io.test_mjcf_loops import of_mujoco, read

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "frames and static forces of hexapods in MJCF (`freejoint`, ball joints)",
        "MuJoCo: its equality residuals solved, its bias and constraint forces balanced",
        "1e-9",
    ),
)
FEET = 0.15 * np.array(
    [[math.cos(a), math.sin(a), 0.0] for a in np.radians([-15, 15, 105, 135, 225, 255])]
)
ENDS = 0.1 * np.array(
    [[math.cos(a), math.sin(a), 0.0] for a in np.radians([-45, 45, 75, 165, 195, 285])]
)
HEIGHT = np.array([0.0, 0.0, 0.2])
CROSS = '<joint name="x{k}" axis="1 0 0"/><joint name="y{k}" axis="0 1 0"/>'
BALL = '<joint name="b{k}" type="ball" range="0 40"/>'


def words(values):
    """Return numbers as they stand in a file."""
    return " ".join(map(repr, np.asarray(values).tolist()))


def platform(joint, at):
    """Return the body of the platform."""
    inertial = '<inertial pos="0.01 0 0.02" mass="3" diaginertia="0.01 0.01 0.01"/>'
    site = '<site name="tcp" pos="0 0 0.05" euler="0 0 20"/>'
    return f'<body name="platform" {at}>{joint}{inertial}{site}</body>'


def hexapod(foot, *, in_leg=False, legs=6):
    """Return a hexapod whose platform is free, or hangs in the first leg by a ball joint."""
    bodies, equality, drives = [], [], []
    free = platform('<freejoint name="float"/>', f'pos="{words(HEIGHT)}"')
    for k, (start, end) in enumerate(zip(FEET[:legs], ENDS, strict=False)):
        way = end + HEIGHT - start
        length = float(np.linalg.norm(way))
        turn, _ = Rotation.align_vectors([way / length], [[0, 0, 1]])
        inner = ""
        if in_leg and not k:
            joint = f'<joint name="last" type="ball" pos="{words(end)}"/>'
            back = turn.inv()
            place = np.array([0, 0, length - 0.1]) - back.apply(end)
            quaternion = back.as_quat()[[3, 0, 1, 2]]
            inner = platform(joint, f'pos="{words(place)}" quat="{words(quaternion)}"')
        else:
            anchor = f'anchor="0 0 {length - 0.1!r}"'
            equality.append(f'<connect body1="rod{k}" body2="platform" {anchor}/>')
        bodies.append(
            f'<body pos="{words(start)}" quat="{words(turn.as_quat()[[3, 0, 1, 2]])}">'
            f'{foot.format(k=k)}<inertial pos="0 0 0.05" mass="0.4" diaginertia="1e-3 1e-3 1e-3"/>'
            f'<body name="rod{k}" pos="0 0 0.1"><joint name="s{k}" type="slide" axis="0 0 1" '
            'range="-0.02 0.02"/><inertial pos="0 0 0.03" mass="0.2" diaginertia="1e-3 1e-3 1e-3"/>'
            f"{inner}</body></body>"
        )
        drives.append(f'<motor joint="s{k}"/>')
    world = "".join(bodies) + ("" if in_leg else free)
    return (
        f'<mujoco><option jacobian="dense"/><worldbody>{world}</worldbody><equality>'
        f"{''.join(equality)}</equality><actuator>{''.join(drives)}</actuator></mujoco>"
    )


@pytest.mark.parametrize(("foot", "in_leg"), [(CROSS, True), (BALL, False)])
def test_a_hexapod_stands_and_is_held_as_in_mujoco(tmp_path, foot, in_leg):
    """Whether its platform is free, or the last body of a leg."""
    path, arm = read(tmp_path, hexapod(foot, in_leg=in_leg), sidecar="")
    assert sorted(joint.name for joint in arm.driven) == [f"s{k}" for k in range(6)]
    assert ("free" in {joint.type for joint in arm.joints}) != in_leg
    for share in (0.0, 0.003):
        q = share * np.array([1, 2, -1, 3, 0.5, -2])
        state = state_of(arm, q[None])
        pose, forces = of_mujoco(path, arm, q)
        np.testing.assert_allclose(state.frames[-1, 0], pose, atol=1e-9)
        np.testing.assert_allclose(state.torques[0], forces, atol=1e-9)


def test_the_range_of_a_ball_joint_is_a_cone(tmp_path):
    """About the direction to the centre of mass of its body, with a note."""
    _, arm = read(tmp_path, hexapod(BALL), sidecar="")
    joint = next(each for each in arm.joints if each.name == "b0")
    assert joint.cone == pytest.approx(math.radians(40))
    np.testing.assert_allclose(joint.axis, [0, 0, 0.05])
    assert any("b0, b1, b2, b3, b4, b5 is a cone" in note for note in arm.notes)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        (hexapod(CROSS, legs=5), "36 freedoms - rank 30 of the closures = 6, for 5 drives"),
        (
            hexapod(CROSS).partition("<equality>")[0] + "</mujoco>",
            "no joint that moves before the tip 'tcp', only float, which no loop holds",
        ),
    ],
)
def test_a_platform_that_is_not_held_is_refused(tmp_path, text, found):
    """With the freedoms that are left, or that nothing closes a loop."""
    path = tmp_path / "arm.xml"
    path.write_text(text, "utf-8")
    path.with_suffix(".toml").write_text('tip = "tcp"', "utf-8")
    (mistake,) = mistakes(path)
    assert found in mistake.found


def test_a_free_root_that_is_welded_to_the_world_stands_there(tmp_path):
    """As one that nothing holds."""
    geom = '<geom size="0.1"/>'
    inner = f'<body><joint name="j" axis="0 1 0" range="-50 50"/>{geom}<site name="tcp"/></body>'
    body = f'<body name="base" pos="0 0 1"><freejoint/>{geom}{inner}</body>'
    weld = '<equality><weld body1="base"/></equality>'
    _, arm = read(tmp_path, f"<mujoco><worldbody>{body}</worldbody>{weld}</mujoco>")
    assert not arm.closures
    assert [joint.name for joint in arm.driven] == ["j"]
