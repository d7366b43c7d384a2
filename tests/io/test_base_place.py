"""Where an arm stands on its base: [base] xyz and rpy, in the native format and in a sidecar."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lostmotion.io import read
from lostmotion.io.native import arm_of
from lostmotion.mechanism.inverse import tool_and_jacobian
from lostmotion.mechanism.state import state_of, tool_points
from tests.io.urdfs import agrees_with_pinocchio, arm, joint, link, robot
from tests.parts.conditions import local_screws

PLACE = {"xyz": ["100 mm", "-200 mm", "700 mm"], "rpy": ["170 deg", "10 deg", "-30 deg"]}
XYZ, RPY = (0.1, -0.2, 0.7), tuple(np.radians([170, 10, -30]).tolist())
TILTED = {
    "roll": "2 deg ± 0.1 deg",
    "pitch": "1 deg",
    "angular_stiffness": ["1 MN m/rad", "2 MN m/rad", "3 MN m/rad"],
}


def native(base, *joints):
    """Return an arm of a few joints on this base, with further joints before them."""
    own = [
        {
            "name": name,
            "type": "revolute",
            "limits": ["-170 deg", "170 deg"],
            "axis": axis,
            "link": {
                "length": "300 mm",
                "direction": "x",
                "mass": "2 kg",
                "centre_of_mass": ["100 mm", "10 mm", "0 mm"],
            },
            "lumped": {"angle": "1 arcmin"},
        }
        for name, axis in (("A", "z"), ("B", "y"), ("C", "y"))
    ]
    return arm_of("x", {"name": "x", "base": base, "joints": [*joints, *own]})


def test_a_place_on_the_base_is_a_fixed_joint_before_the_arm():
    """Tool, torques, Jacobian, loads on the mount and every elementary error are those of an arm on
    such a plinth.
    """
    placed = native({**PLACE, **TILTED})
    plinth = native(TILTED, {"name": "plinth", "type": "fixed", "origin": PLACE})
    q = np.random.default_rng(1).uniform(-2, 2, (20, 3))
    assert np.abs(state_of(placed, q).frames[-1] - state_of(plinth, q).frames[-1]).max() < 1e-13
    assert np.abs(state_of(placed, q).frames[0] - np.eye(4)).max() == 0
    assert np.abs(tool_points(placed, q) - tool_points(plinth, q)).max() < 1e-13
    assert np.abs(state_of(placed, q).torques - state_of(plinth, q).torques).max() < 1e-12
    assert np.abs(tool_and_jacobian(placed, q)[1] - tool_and_jacobian(plinth, q)[1]).max() < 1e-12
    assert np.abs(state_of(placed, q).wrenches[0] - state_of(plinth, q).wrenches[0]).max() < 1e-11
    one, other = (
        {of.name: screw for of, screw in local_screws(each, q)} for each in (placed, plinth)
    )
    assert one.keys() == other.keys()
    assert all(np.abs(one[name] - other[name]).max() < 1e-12 for name in one)


def test_an_arm_is_moved_by_a_new_base():
    """A copy on another base stands there, also where the first was asked before."""
    q = np.array([[0.1, 0.3, 0.4]])
    low, high = native({}), native({"xyz": ["0 mm", "0 mm", "500 mm"]})
    moved = np.add(tool_points(low, q), (0, 0, 0.5))
    copy = low.model_copy(update={"base": high.base})
    for each in (high, copy):
        assert tool_points(each, q) == pytest.approx(moved)
        assert state_of(each, q).frames[-1, :, :3, 3] == pytest.approx(moved)


def test_an_arm_on_the_ceiling_carries_itself_the_other_way():
    """Turned over, a joint about a horizontal axis holds the opposite torque."""
    q = np.array([[0.0, 0.3, 0.4]])
    floor, ceiling = (
        state_of(native({}), q).torques,
        state_of(native({"rpy": ["180 deg", "0 deg", "0 deg"]}), q).torques,
    )
    assert ceiling[0, 1:] == pytest.approx(-floor[0, 1:])
    assert abs(floor[0, 1]) > 1


def test_a_sidecar_places_a_urdf(tmp_path):
    """As Pinocchio does with a fixed joint of that origin before the arm; the base may be named
    beside it.
    """
    text = robot(*arm())
    path = tmp_path / "r.urdf"
    path.write_text(text, encoding="utf-8")
    path.with_suffix(".toml").write_text(
        f"[base]\nxyz = {PLACE['xyz']}\nrpy = {PLACE['rpy']}\n", encoding="utf-8"
    )
    found = read(path)
    mount = f'xyz="{XYZ[0]} {XYZ[1]} {XYZ[2]}" rpy="{RPY[0]!r} {RPY[1]!r} {RPY[2]!r}"'
    with_mount = tmp_path / "mounted.urdf"
    with_mount.write_text(
        robot(*arm(), joint("mount", "world base", "fixed", "", mount), link("world", 0)),
        encoding="utf-8",
    )
    agrees_with_pinocchio(with_mount, found, "link3")
    path.with_suffix(".toml").write_text(
        f'[base]\nlink = "link1"\nxyz = {PLACE["xyz"]}\n', encoding="utf-8"
    )
    assert state_of(read(path), np.zeros((1, 2))).frames[1, 0, :3, 3] == pytest.approx(
        np.add(XYZ, (0.3, 0, 0.1))
    )


def test_a_plinth_carries_the_leaning_further():
    """A base that leans by an unknown angle moves the tool by that angle times its height above the
    base's own origin.
    """
    low, high = (
        native({"roll": "0 deg ± 1 deg", "xyz": ["0 mm", "0 mm", f"{height} mm"]})
        for height in (0, 1000)
    )
    q = np.zeros((1, 3))

    def moved(each):
        ((lean, screw),) = (
            (of.term, screw) for of, screw in local_screws(each, q) if of.owner == "base tilt"
        )
        return np.cross(screw[0, :3], tool_points(each, q)[0]) * lean.bound

    assert moved(high)[1] - moved(low)[1] == pytest.approx(-math.radians(1))
