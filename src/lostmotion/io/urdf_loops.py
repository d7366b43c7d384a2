"""Loops of a description: the branches beside the chain that they lead through, and closures."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

import numpy as np

from lostmotion.errors import Problem
from lostmotion.io.dh import rpy_of
from lostmotion.io.limits import listed
from lostmotion.io.toml import key_step
from lostmotion.parts.link import Frame
from lostmotion.spatial import pose_of

if TYPE_CHECKING:
    from lostmotion.io.urdf_chain import Chain
    from lostmotion.io.urdf_tree import UrdfJoint, UrdfLoop, UrdfTree
    from lostmotion.spatial import Floats

_ENDS = (".seat", ".tip")


class LoopsOfTree:
    """Joints beside the chain that loops lead through, and the closures of these loops.

    branches  joints in a row, the first of them attached to a joint that comes before
    passive   names of the joints that loops move
    """

    def __init__(
        self,
        tree: UrdfTree,
        chain: Chain,
        content: dict[str, Any],
    ) -> None:
        """Find the branches of loops that lead through the chain, and of what a sidecar joins."""
        self.tree, self.base = tree, chain.base
        self.branches: list[list[UrdfJoint]] = []
        self.passive: set[str] = set()
        self._chain = chain.joints
        self._in_loops: set[str] = set()
        self._known = {joint.name for joint in chain.joints}
        for name in _stated(content.get("closures")):
            joint = tree.joints.get(name)
            if joint is not None:
                self._include(tree.path_to(joint.child, self.base) or [])
        self._loops: list[UrdfLoop] = []
        waiting, before = list(tree.loops), -1
        while len(waiting) != before:
            before = len(waiting)
            for loop in list(waiting):
                around = self._around(loop)
                if any(joint.name in self._known and joint.type != "fixed" for joint in around):
                    waiting.remove(loop)
                    self._loops.append(loop)
                    for link in loop.links:
                        self._include(tree.path_to(link, self.base) or [])
                    self._in_loops |= {joint.name for joint in around}
                    self.passive |= {joint.name for joint in around if not joint.driven}
        by_name = content.get("joints")
        for name, parts in by_name.items() if isinstance(by_name, dict) else ():
            if isinstance(parts, dict) and parts.get("passive") is False:
                self.passive.discard(name)
        self._last = {branch[-1].name for branch in self.branches}

    def _around(self, loop: UrdfLoop) -> list[UrdfJoint]:
        """Return the joints of a loop; none where it does not stand on the base of the chain."""
        ways = [self.tree.path_to(link, self.base) for link in loop.links]
        if ways[0] is None or ways[1] is None:
            return []
        names = [{joint.name for joint in way or []} for way in ways]
        return [self.tree.joints[name] for name in names[0] ^ names[1]]

    def _include(self, way: list[UrdfJoint]) -> None:
        new = [joint for joint in way if joint.name not in self._known]
        self._known |= {joint.name for joint in new}
        if new:
            self.branches.append(new)

    @property
    def mistakes(self) -> list[Problem]:
        """Return what is wrong with the joints of the branches, where a ball joint may be."""
        own = [*self._chain, *(each for branch in self.branches for each in branch)]
        moving = [joint.name for joint in own if joint.moves]
        out = []
        if self._loops and self.passive.issuperset(moving):
            found = f"a loop through {listed(moving)}, none of which an actuator moves"
            expected = f"{self.tree.drive}; or, in the sidecar, those that have one"
            example = f"[joints.{key_step(moving[0])}] with passive = false"
            out.append(Problem(self.tree.file, self.tree.root, found, expected, example))
        for joint in own[len(self._chain) :]:
            out += joint.limit_mistakes
            if joint.type in {"floating", "planar"} and not joint.is_held_by_loops:
                where = f"{self.tree.file}:{joint.line}" if joint.line else self.tree.file
                expected = "a platform that legs alone carry as type free in TOML"
                found = f"a {joint.type} joint that no loop holds"
                out.append(Problem(where, joint.path, found, expected, "free"))
            out += joint.other_mistakes
        return out

    def attached(self, joint: UrdfJoint, before: UrdfJoint | None) -> dict[str, Any]:
        """Return where the first joint of a branch is attached; nothing for another."""
        way = self._way(joint)[:-1]
        branch = any(each[0] is joint for each in self.branches)
        return {"after": way[-1].name if way else "base"} if branch and before is None else {}

    def moved(self, joint: UrdfJoint) -> dict[str, Any]:
        """Return what an entry states of a joint in a loop: passive, or at zero at home."""
        if joint.name not in self._in_loops or not joint.moves:
            return {}
        if joint.name in self.passive or joint.is_held_by_loops:
            return {"passive": True}
        low, high = joint.limits if joint.type != "continuous" else (-1.0, 1.0)
        unit = "m" if joint.type == "prismatic" else "rad"
        return {"start": f"0 {unit}"} if low <= 0 <= high else {}

    def add_to(self, joints: list[dict[str, Any]], content: dict[str, Any]) -> None:
        """Put the closures into the content of a sidecar, with the place of the tool, and a ball
        joint for each that holds a point alone into `joints`.

        The link of the last joint of a branch leads to where the first loop closes.
        """
        tip = joints[len(self._chain) - 1]["name"]
        out = [self._closure(loop, joints) for loop in self._loops]
        if self.branches or out:
            tool = content.setdefault("tool", {})
            if isinstance(tool, dict):
                tool.setdefault("after", f"{tip}.tip")
        if out:
            stated = content.get("closures", [])
            content["closures"] = [*out, *stated] if isinstance(stated, list) else stated

    def _closure(self, loop: UrdfLoop, joints: list[dict[str, Any]]) -> dict[str, Any]:
        """Return a closure; the ball joint of one that holds a point is put into `joints`."""
        entries = {entry["name"]: entry for entry in joints}
        places, frames, turned = [], [], []
        for link, pose in zip(loop.links, loop.frames, strict=True):
            way = self.tree.path_to(link, self.base) or []
            name, at = (way[-1].name if way else "base"), pose
            rotation = functools.reduce(
                np.matmul, (pose_of(each.xyz, each.rpy)[:3, :3] for each in way), np.eye(3)
            )
            turned.append(rotation @ pose[:3, :3])
            if name in self._last:
                self._last.remove(name)
                entries[name]["link"]["tip"] = _frame(pose, turns=False)
                name, at = f"{name}.tip", _turn(pose)
            places.append(name)
            frames.append(_frame(at))
        if loop.turns:
            ball, count = f"{loop.name}_ball", 1
            while ball in entries:
                count += 1
                ball = f"{loop.name}_ball{count}"
            start = [f"{angle!r} rad" for angle in rpy_of(turned[1].T @ turned[0])]
            place = {"after": places[1], "origin": frames[1]}
            joints.append({"name": ball, "type": "spherical", **place, "start": start})
            places[1], frames[1] = f"{ball}.tip", Frame()
        return {"joins": places, "frames": frames}

    def _way(self, joint: UrdfJoint) -> list[UrdfJoint]:
        return self.tree.path_to(joint.child, self.base) or []


def _stated(closures: Any) -> list[str]:  # noqa: ANN401 - what a sidecar states
    """Return the names of the joints whose places a sidecar's closures join."""
    out = []
    for closure in closures if isinstance(closures, list) else []:
        joins = closure.get("joins") if isinstance(closure, dict) else None
        for place in joins if isinstance(joins, list) else []:
            name = str(place)
            for end in _ENDS:
                name = name.removesuffix(end)
            out.append(name)
    return out


def _frame(pose: Floats, *, turns: bool = True) -> Frame:
    x, y, z = pose[:3, 3].tolist()
    return Frame(xyz=(x, y, z), rpy=rpy_of(pose[:3, :3]) if turns else (0.0, 0.0, 0.0))


def _turn(pose: Floats) -> Floats:
    out = np.eye(4)
    out[:3, :3] = pose[:3, :3]
    return out
