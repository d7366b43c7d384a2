"""Reference mechanisms as arm files: a five-bar, a 3-RRR stage, a delta, a hexapod and a palletiser
with two parallelograms.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.io.native import arm_of
from lostmotion.mechanism.state import State, state_of

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm

M, DEG = "{} m".format, "{} deg".format


def xyz(*values: float) -> dict:
    """Return a frame at this point, m."""
    return {"xyz": [M(float(value)) for value in values]}


def placed(x: float, y: float, z: float, yaw: float) -> dict:
    """Return a frame at this point (m), turned about z (deg)."""
    return {**xyz(x, y, z), "rpy": ["0 deg", "0 deg", DEG(float(yaw))]}


def link(length: float, direction: str = "x", mass: float = 0.0, **more: object) -> dict:
    """Return a link of this length, m, and mass, kg."""
    return {"length": M(length), "direction": direction, "mass": f"{mass} kg", **more}


def arm(**tables: object) -> Arm:
    """Return the arm that these tables of a file describe."""
    return arm_of("test.toml", {"name": "test", **tables})


def at(arm: Arm, q: object, **more: object) -> State:
    """Return the state of an arm at one pose."""
    return state_of(arm, np.atleast_2d(np.asarray(q, dtype=float)), **more)


def moved(state: State, place: str, *twist: float) -> np.ndarray:
    """Return the twist of the tool (6,) per twist at a place."""
    return state.carry(state.arm.places.index(place))[0] @ np.array(twist)


def wrench(state: State, place: str) -> np.ndarray:
    """Return the wrench on a place (6,)."""
    return state.wrenches[state.arm.places.index(place), 0]


def five_bar(distal: float = 0.4, **pin: object) -> Arm:
    """Return a five-bar with motors at 0 and 0.2 m and proximal links of 0.25 m."""
    turning = {"type": "revolute", "limits": ["0 deg", "180 deg"]}
    passive = {"type": "revolute", "passive": True, **pin}
    return arm(
        joints=[
            {"name": "m1", **turning, "start": "2.2 rad", "link": link(0.25, mass=0.125)},
            {"name": "e1", **passive, "start": "-80 deg", "link": link(distal, mass=distal / 2)},
            {"name": "m2", **turning, "start": "0.9 rad", "after": "base", "origin": xyz(0.2, 0, 0)}
            | {"link": link(0.25, mass=0.125)},
            {"name": "e2", **passive, "start": "70 deg", "link": link(distal, mass=distal / 2)},
            {"name": "pin", **passive},
        ],
        closures=[{"joins": ["e1.tip", "pin.tip"]}],
        tool={"after": "e1.tip"},
        payload={"mass": "2 kg"},
    )


def three_rrr(**spring: object) -> Arm:
    """Return a planar stage on three legs of two links of 0.4 m."""
    angles = (90, 210, 330)
    section = spring.get("section", ({}, {}))
    turning = {"type": "revolute", "limits": ["-2 rad", "5 rad"]}
    return arm(
        joints=[{"name": "platform", "type": "free", "start": xyz(0.03, 0.05, 0)}],
        legs=[
            {
                "joins": "platform.tip",
                "copies": [
                    {
                        "name": str(k),
                        "place": xyz(
                            0.5 * math.cos(math.radians(a)), 0.5 * math.sin(math.radians(a)), 0
                        ),
                        "end": xyz(
                            0.15 * math.cos(math.radians(a)), 0.15 * math.sin(math.radians(a)), 0
                        ),
                        "crank": {"start": f"{start} rad"},
                    }
                    for k, (a, start) in enumerate(
                        zip(angles, (-0.387773, 1.561341, 3.472764), strict=True), 1
                    )
                ],
                "joints": [
                    {"name": "crank", **turning, **spring.get("drive", {})}
                    | {"link": link(0.4, **section[0])},
                    {"name": "elbow", "type": "revolute", "passive": True, "start": "-120 deg"}
                    | {"link": link(0.4, **section[1])},
                    {"name": "pin", "type": "revolute", "passive": True},
                ],
            }
        ],
        tool={"after": "platform.tip"},
    )


def delta() -> Arm:
    """Return Clavel's delta with pairs of rods."""
    sides = {"a": 0.05, "b": -0.05}
    arms, rods = [], []
    for k in range(3):
        yaw = math.radians(120 * k)
        c, s = math.cos(yaw), math.sin(yaw)
        arms.append({"name": str(k + 1), "place": placed(0.2 * c, 0.2 * s, 0, 120 * k)})
        for side, y in sides.items():
            end = placed(0.06 * c - y * s, 0.06 * s + y * c, 0, 120 * k)
            rods.append(
                {
                    "name": f"{k + 1}{side}",
                    "after": f"{k + 1}_arm.tip",
                    "place": xyz(0, y, 0),
                    "end": end,
                }
            )
    motor = {"name": "arm", "type": "revolute", "axis": "y", "limits": ["-40 deg", "80 deg"]}
    return arm(
        joints=[{"name": "platform", "type": "free", "start": xyz(0, 0, -0.42)}],
        legs=[
            {"copies": arms, "joints": [{**motor, "link": link(0.2, mass=0.6)}]},
            {
                "joins": "platform.tip",
                "copies": rods,
                "joints": [
                    {"name": "rod", "type": "universal", "axes": ["y", "x"]}
                    | {"link": link(0.48, "-z", mass=0.1)},
                    {"name": "ball", "type": "spherical"},
                ],
            },
        ],
        tool={"after": "platform.tip"},
        payload={"mass": "1.5 kg"},
    )


def hexapod(stiffness: str = "") -> Arm:
    """Return a Gough-Stewart platform on six universal, sliding and ball joints."""
    copies = []
    for k in range(6):
        ends = []
        for radius, spread in ((0.4, 15), (0.25, 45)):
            angle = math.radians(120 * (k // 2) + (spread if k % 2 else -spread))
            ends.append(xyz(radius * math.cos(angle), radius * math.sin(angle), 0))
        copies.append({"name": str(k + 1), "place": ends[0], "end": ends[1]})
    slide = {"type": "prismatic", "limits": ["0.4 m", "0.7 m"], "start": "0.53 m"}
    mass = {"mass": "1 kg"}
    return arm(
        joints=[
            {"name": "platform", "type": "free", "start": xyz(0, 0, 0.5)},
        ],
        legs=[
            {
                "joins": "platform.tip",
                "copies": copies,
                "joints": [
                    {"name": "base", "type": "universal", "axes": ["x", "y"]}
                    | {"link": {**mass, "centre_of_mass": ["0 m", "0 m", "0.15 m"]}},
                    {"name": "leg", **slide}
                    | ({"gearbox": {"stiffness": stiffness}} if stiffness else {})
                    | {"link": {**mass, "centre_of_mass": ["0 m", "0 m", "-0.15 m"]}},
                    {"name": "ball", "type": "spherical"},
                ],
            }
        ],
        tool={"after": "platform.tip"},
        payload={"mass": "20 kg", "centre_of_mass": ["0.01 m", "0.02 m", "0.1 m"]},
    )


def hexapod_legs(centre: tuple[float, ...], about_x: float) -> np.ndarray:
    """Return the leg lengths (6,), m, of `hexapod` with its platform here: closed form."""
    c, s = math.cos(about_x), math.sin(about_x)
    turned = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    out = []
    for k in range(6):
        base, platform = (
            np.array([radius * math.cos(a), radius * math.sin(a), 0.0])
            for radius, a in (
                (0.4, math.radians(120 * (k // 2) + (15 if k % 2 else -15))),
                (0.25, math.radians(120 * (k // 2) + (45 if k % 2 else -45))),
            )
        )
        out.append(np.linalg.norm(np.array(centre) + turned @ platform - base))
    return np.array(out)


def palletiser(parts: dict[str, dict] | None = None) -> Arm:
    """Return a palletiser with a driving parallelogram and two that keep the tool level.

    parts  keys of a link by joint, as section and material; or of a joint, under "joint NAME"
    """
    parts = parts or {}
    pin = {"type": "revolute", "axis": "-y", "passive": True}
    drive = {"type": "revolute", "axis": "-y"}

    def joint(name: str, kind: dict, length: float, angle: float = 0.0, **more: object) -> dict:
        mass = more.pop("mass", 0.0)
        centre = more.pop("centre", None)
        direction = [math.cos(angle), 0.0, math.sin(angle)]
        made = link(length, mass=mass) | {"direction": direction} | parts.get(name, {})
        made |= {} if centre is None else {"centre_of_mass": centre}
        return {"name": name, **kind, **more, **parts.get(f"joint {name}", {}), "link": made}

    turn = {"name": "turn", "type": "revolute", "limits": ["-3 rad", "3 rad"], "start": "0 rad"}
    turn |= {"link": {"tip": xyz(0.35, 0, 0.8), "mass": "120 kg"}} | parts.get("joint turn", {})
    turn["link"]["centre_of_mass"] = ["0.1 m", "0 m", "0.5 m"]
    return arm(
        joints=[
            turn,
            joint("arm", drive, 1.05, mass=60, limits=["1 rad", "2.5 rad"], start="1.9 rad"),
            joint("elbow", pin, 1.10, mass=40, start="-2.1 rad"),
            joint("wrist", pin, 0, mass=25, centre=["0.05 m", "0 m", "-0.1 m"], start="0.2 rad"),
            joint("heel", {"type": "fixed"}, 0.35, math.pi, after="elbow"),
            joint("horn", {"type": "fixed"}, 0.25, math.pi / 2, after="wrist"),
            joint("crank", drive, 0.35, mass=10, after="turn.tip")
            | {"limits": ["2.2 rad", "3.4 rad"], "start": "2.9 rad"},
            joint("rod", pin, 1.05, mass=12, start="-1 rad"),
            joint("rod end", pin, 0),
            joint("lug", {"type": "fixed"}, 0.25, 2.3, after="turn.tip"),
            joint("level 1", pin, 1.05, mass=8, start="1.9 rad"),
            joint("level 1 end", pin, 0, start="-1.9 rad"),
            joint("triangle", pin, 0, mass=6, after="arm.tip", start="-1.9 rad"),
            joint("first", {"type": "fixed"}, 0.25, 2.3, after="triangle"),
            joint("second", {"type": "fixed"}, 0.25, math.pi / 2, after="triangle"),
            joint("level 2", pin, 1.10, mass=8, start="-0.2 rad"),
            joint("level 2 end", pin, 0, start="0.2 rad"),
        ],
        closures=[
            {"joins": ["rod end.tip", "heel.tip"]},
            {"joins": ["level 1 end.tip", "first.tip"]},
            {"joins": ["level 2 end.tip", "horn.tip"]},
        ],
        tool={"after": "wrist.tip", "frame": xyz(0.2, 0, -0.25)},
        payload={"mass": "100 kg"},
    )
