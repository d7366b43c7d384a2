"""SDF, the format of Gazebo and Drake, as links and joints like those of a URDF.

A pose is stated relative to any frame of the model; a link's frame need not be that of its joint.
Where they differ, LINK@JOINT has the mass, and LINK is a frame fixed to it. Frames are links
without mass: tools. A joint whose child has a parent already closes a loop: it leads to a link
CHILD@JOINT of its own, which is one with the child.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.errors import shown
from lostmotion.io.dh import rpy_of
from lostmotion.io.limits import cut, listed, nearest, refuse_all
from lostmotion.io.sdf_frames import WORLD, Frames
from lostmotion.io.sdf_values import Values
from lostmotion.io.sdf_xml import TRUE, model_of
from lostmotion.io.sidecar import limits_in_sidecar
from lostmotion.io.urdf_tree import (
    LIMITED,
    Three,
    UrdfJoint,
    UrdfLink,
    UrdfLoop,
    UrdfTree,
    free_name,
)
from lostmotion.io.urdf_xml import line_of
from lostmotion.units import LARGEST

if TYPE_CHECKING:
    from lxml import etree

    from lostmotion.spatial import Floats

# Types of joints, as SDF and as URDF calls them; those with two axes are two joints.
_TYPES: Final = {
    "revolute": "revolute",
    "continuous": "continuous",
    "prismatic": "prismatic",
    "fixed": "fixed",
    "ball": "ball",
    "universal": "revolute",
    "revolute2": "revolute",
}
_TWO_AXES: Final = ("universal", "revolute2")
_RATIO: Final = "gearbox"
_EXAMPLE: Final = "<limit><lower>-1.57</lower><upper>1.57</upper></limit>"
# Frames that differ by less (m, rad) are one.
_SAME: Final = 1e-12
_DEFAULT_MASS: Final = 1.0  # kg, of a link without inertial, by the format


@dataclass(eq=False)
class _Joint:
    """A joint: its name, the bodies that it joins, its pose (4, 4) in the model, and the model that
    it stands in; `turned` where the tree leads from its child to its parent.
    """

    name: str
    element: etree._Element
    kind: str
    parent: str
    child: str
    pose: Floats
    scope: str
    turned: bool = False

    @property
    def moves(self) -> bool:
        return self.kind != "fixed"

    def turn_round(self) -> None:
        self.parent, self.child, self.turned = self.child, self.parent, not self.turned


def read_tree(path: Path, text: str, root: Path) -> UrdfTree:
    """Return the links and joints of an SDF file, which may include models within the folder
    `root`. Raises InputError where there is no tree, with every mistake.
    """
    model, notes = model_of(path, text, root)
    tree = UrdfTree(
        str(path),
        name=model.get("name", ""),
        notes=notes,
        format="SDF",
        root="/sdf",
        hinge='<joint name="j1" type="revolute">',
        drive="a <plugin> with the <joint_name> of each drive",
    )
    return _TreeOfModel(tree, model).build()


class _TreeOfModel:
    """Builds a tree from the elements of a model."""

    def __init__(self, tree: UrdfTree, model: etree._Element) -> None:
        self.tree = tree
        self.model = model
        self.values = Values(tree)
        self.frames = Frames(model, self.values)
        self.driven = {
            (each.text or "").strip()
            for plugin in model.iter("plugin")
            for each in plugin.iter("joint_name")
        }
        # Mass and pose of its centre, of each body that states them.
        self.inertials = {
            body: self._inertial(inertial, body)
            for body, element in self.frames.links.items()
            if (inertial := element.find("inertial")) is not None
        }
        self.above: dict[str, _Joint] = {}  # the joint of the tree that leads to a body
        self.carriers = {WORLD: WORLD}  # the link that has the mass of a body
        self.seats: dict[str, Floats] = {}  # the pose (4, 4) of that link in the model

    def build(self) -> UrdfTree:
        """Return the tree, or raise InputError with every mistake."""
        self._refuse()
        joints = self._joints()
        self._refuse()
        closing = self._span(joints)
        self._carry()
        self._stand(joints)
        for body, element in self.frames.links.items():
            self._add_link(body, element)
        for joint in joints:
            if joint not in closing:
                self._add_joint(joint, self.carriers[joint.child], self.seats[joint.child])
        for joint in closing:
            self._close(joint)
        for body in self.frames.links:
            if self.carriers[body] != body:
                self._add_frame(body, body, self.frames.pose_of(body))
        for name in self.frames.named:
            link, body = free_name(name, self.tree.links, "frame"), self.frames.body_of(name)
            self._add_frame(link, body, self.frames.pose_of(name))
        self._note()
        self.tree.connect()
        self._refuse()
        return self.tree

    def _refuse(self) -> None:
        if not self.frames.links:
            words = ("no link", "links and joints", '<link name="base"/>')
            self.values.refuse(self.model, "//model", *words)
        if self.tree.mistakes:
            refuse_all(self.tree.mistakes)

    def _joints(self) -> list[_Joint]:
        """Return the joints, their ends checked."""
        out = []
        for name, frame in self.frames.joints.items():
            stated = frame.element.get("type", "")
            if stated == _RATIO:
                self.tree.notes.append(
                    f"not carried over: {name}, a ratio between joints (gearbox)"
                )
                continue
            parent, child = (self.frames.body_of(end) for end in (frame.parent, frame.attached))
            pose = self.frames.of_joint(name)
            joint = _Joint(name, frame.element, stated, parent, child, pose, frame.scope)
            out.append(joint)
            if parent == child:
                found = f"a joint from {shown(parent)} to itself"
                self.values.refuse(
                    frame.element, frame.path, found, "two links", "<parent>base</parent>"
                )
            if child == WORLD:
                joint.turn_round()
        return out

    def _span(self, joints: list[_Joint]) -> list[_Joint]:
        """Choose the joints that lead to bodies, in the file's order; return those that close."""
        closing = []
        for joint in joints:
            if joint.child in self.above or self._root(joint.parent) == joint.child:
                apart = self._root(joint.child) != self._root(joint.parent)
                if not apart or joint.parent in self.above or joint.parent == WORLD:
                    closing.append(joint)
                    continue
                joint.turn_round()
            self.above[joint.child] = joint
        return closing

    def _root(self, body: str) -> str:
        while body in self.above:
            body = self.above[body].parent
        return body

    def _carry(self) -> None:
        """Choose the frame of each body: that of the joint that moves it, else its own."""
        self.seats[WORLD] = self.frames.pose_of(WORLD)
        for body in self.frames.links:
            own, joint = self.frames.pose_of(body), self.above.get(body)
            self.seats[body], name = own, body
            if joint is not None and joint.moves and np.abs(joint.pose - own).max() > _SAME:
                self.seats[body] = joint.pose
                name = free_name(f"{body}@{joint.name}", self.frames.links, "link")
            self.carriers[body] = name

    def _stand(self, joints: list[_Joint]) -> None:
        """Add the world, where a joint leads from it, or the model does not stand in its origin."""
        roots = [body for body in self.frames.links if body not in self.above]
        if any(WORLD in (joint.parent, joint.child) for joint in joints):
            self.tree.links[WORLD] = UrdfLink(WORLD, is_frame=True)
        elif len(roots) == 1:
            seat = np.linalg.inv(self.seats[WORLD]) @ self.seats[roots[0]]
            if np.abs(seat - np.eye(4)).max() > _SAME:
                self.tree.links[WORLD] = UrdfLink(WORLD, is_frame=True)
                self._add(f"{roots[0]}_fixed", "fixed", (WORLD, self.carriers[roots[0]]), seat)

    def _inertial(self, element: etree._Element, body: str) -> tuple[float, Floats]:
        path = f'//link[@name="{body}"]/inertial'
        stated = self.values.row(
            element.find("mass"), f"{path}/mass", (_DEFAULT_MASS,), "<mass>1.2</mass>"
        )
        if stated[0] < 0 or element.get("auto", "") in TRUE:
            found = f"{stated[0]:g} kg" if stated[0] < 0 else "a mass that follows from shapes"
            words = (found, "a mass in kg, zero or more", "<mass>1.2</mass>")
            self.values.refuse(element, path, *words)
        return stated[0], self.values.pose(element, path)

    def _add_link(self, body: str, element: etree._Element) -> None:
        mass, centre = self.inertials.get(body, (_DEFAULT_MASS, np.eye(4)))
        centre = self.frames.pose_of(body) @ centre
        x, y, z = (np.linalg.inv(self.seats[body]) @ centre)[:3, 3].tolist()
        shapes = any(element.find(each) is not None for each in ("inertial", "visual", "collision"))
        link = UrdfLink(self.carriers[body], mass, (x, y, z) if mass else (0.0, 0.0, 0.0))
        link.is_frame = not shapes
        self.tree.links[link.name] = link

    def _add_joint(self, joint: _Joint, child: str, seat: Floats) -> None:
        """Add a joint that leads to a link at a pose (4, 4); one with two axes as two joints."""
        pose = np.linalg.inv(self.seats[joint.parent]) @ (joint.pose if joint.moves else seat)
        link, axes = self.carriers[joint.parent], ["axis", "axis2"]
        axes = axes[: 1 + (joint.kind in _TWO_AXES)]
        for which in reversed(axes) if joint.turned else axes:
            name = joint.name if which == "axis" else f"{joint.name}_{which}"
            name = name if which == "axis" else free_name(name, self.frames.joints, "joint")
            after = child
            if which != (axes[0] if joint.turned else axes[-1]):
                after = free_name(f"{child}@{name}", self.tree.links, "link")
                self.tree.links[after] = UrdfLink(after, is_frame=True)
            added = self._add(name, _TYPES.get(joint.kind, joint.kind), (link, after), pose, joint)
            self._move(added, joint, which)
            link, pose = after, np.eye(4)

    def _add(
        self,
        name: str,
        kind: str,
        links: tuple[str, str],
        pose: Floats,
        joint: _Joint | None = None,
    ) -> UrdfJoint:
        x, y, z = pose[:3, 3].tolist()
        line = 0 if joint is None or joint.element.base else line_of(joint.element)
        if joint is None:
            name = free_name(name, {*self.tree.joints, *self.frames.joints}, "fixed")
        added = UrdfJoint(name, kind, *links, (x, y, z), rpy_of(pose[:3, :3]), line, root="/")
        added.driven = joint is not None and joint.name in self.driven
        self.tree.joints[name] = added
        return added

    def _add_frame(self, name: str, body: str, pose: Floats) -> None:
        """Add a link without mass at a pose (4, 4) in the model, fixed to a body."""
        self.tree.links[name] = UrdfLink(name, is_frame=True)
        seat = np.linalg.inv(self.seats[body]) @ pose
        self._add(f"{name}_fixed", "fixed", (self.carriers[body], name), seat)

    def _close(self, joint: _Joint) -> None:
        """Add the loop that a joint closes, and the joint as the end of a branch."""
        ends = [self.carriers[joint.parent], self.carriers[joint.child]]
        frames = [
            np.linalg.inv(self.seats[body]) @ joint.pose for body in (joint.parent, joint.child)
        ]
        if joint.moves:
            ends[0] = free_name(f"{joint.child}@{joint.name}", self.tree.links, "link")
            self.tree.links[ends[0]] = UrdfLink(ends[0], is_frame=True)
            self._add_joint(joint, ends[0], joint.pose)
            frames[0] = np.eye(4)
        loop = UrdfLoop(joint.name, (ends[1], ends[0]), (frames[1], frames[0]), turns=False)
        self.tree.loops.append(loop)

    def _move(self, added: UrdfJoint, joint: _Joint, which: str) -> None:
        """Set what a joint that moves has besides its place; what is wrong with it counts only
        where it moves the tool.
        """
        element, path = joint.element.find(which), f'//joint[@name="{joint.name}"]'
        self.values.mistakes = added.other_mistakes
        if joint.kind not in _TYPES:
            near = nearest(joint.kind, _TYPES)
            found, expected = shown(joint.kind), f"one of {', '.join(_TYPES)}"
            if joint.kind == "screw":
                expected = "the slide alone, type prismatic; its screw is a drive in the sidecar"
            example = f'type="{near or "prismatic"}"'
            self.values.refuse(joint.element, f"{path}/@type", found, expected, example, near)
        elif added.type == "ball":
            expected = "joints with an axis between base and tool, or a loop that it is part of"
            self.values.refuse(joint.element, path, "a ball joint", expected, 'type="revolute"')
        elif added.type != "fixed":
            added.axis = self._axis(element, joint, f"{path}/{which}")
            self.values.mistakes = added.limit_mistakes
            self._limit(element, added, joint)
            self._follow(element, added)
        self.values.mistakes = self.tree.mistakes

    def _axis(self, element: etree._Element | None, joint: _Joint, path: str) -> Three:
        """Return the axis of a joint in its own frame."""
        xyz = None if element is None else element.find("xyz")
        stated = self.values.row(xyz, f"{path}/xyz", (0.0, 0.0, 1.0), "<xyz>0 0 1</xyz>")
        if xyz is not None and not 0 < math.hypot(*stated) < math.inf:
            words = (shown(xyz.text or ""), "a direction that is not zero", "<xyz>0 0 1</xyz>")
            self.values.refuse(xyz, f"{path}/xyz", *words)
        seen_from = "" if xyz is None else xyz.get("expressed_in", "")
        axis = np.array(stated)
        if seen_from:
            frame = self.frames.resolve(joint.scope, seen_from)
            if not frame and xyz is not None:
                words = (shown(seen_from), "the name of a frame of this model", "__model__")
                self.values.refuse(xyz, f"{path}/xyz/@expressed_in", *words)
            axis = self.frames.pose_of(frame or WORLD)[:3, :3] @ axis
            axis = joint.pose[:3, :3].T @ axis
        x, y, z = (-axis if joint.turned else axis).tolist()
        return x, y, z

    def _limit(self, element: etree._Element | None, added: UrdfJoint, joint: _Joint) -> None:
        limit = None if element is None else element.find("limit")
        path = f"{added.path}/limit"
        low, high = (
            self.values.limit(None if limit is None else limit.find(end), f"{path}/{end}", none)
            for end, none in (("lower", -math.inf), ("upper", math.inf))
        )
        effort = self.values.limit(None if limit is None else limit.find("effort"), path, 0.0)
        added.effort = effort if 0 < effort <= LARGEST else 0.0
        if added.type == "revolute" and math.isinf(low) and math.isinf(high):
            added.type = "continuous"
        if added.type not in LIMITED or added.limit_mistakes:
            return
        if low > high or math.isinf(low) or math.isinf(high):
            found, expected = (
                f"limits from {low:g} to {high:g}",
                "a lower limit below the upper one",
            )
            if low < high:
                found = "no limit" if math.isinf(low) and math.isinf(high) else found
                expected = "lower and upper in rad or m, or limits in the sidecar, "
                expected += limits_in_sidecar(Path(self.tree.file), added.name, added.type)
            where = joint.element if limit is None else limit
            self.values.refuse(where, path, found, expected, _EXAMPLE)
            return
        added.limits = (low, high)

    def _follow(self, element: etree._Element | None, added: UrdfJoint) -> None:
        mimic = None if element is None else element.find("mimic")
        if mimic is not None:
            added.leader = shown(mimic.get("joint", "?"), 42)[1:-1]
            factor = shown(mimic.findtext("multiplier", "1").strip(), 20)[1:-1]
            added.coupling = f"mimic, x {factor}"

    def _note(self) -> None:
        """Note what the arm does not have of the model."""
        notes = self.tree.notes
        bare = [body for body in self.frames.links if body not in self.inertials]
        if bare:
            notes.append(f"no <inertial>, so 1 kg each, as SDF has it: {listed(bare)}")
        springs = [
            name
            for name, frame in self.frames.joints.items()
            for each in frame.element.iter("spring_stiffness")
            if (each.text or "").strip(" 0.")
        ]
        if springs:
            notes.append(
                f"not carried over: the springs of {listed(springs)}; their forces are missing"
            )
        floats = [
            name
            for name, link in self.frames.links.items()
            if link.findtext("gravity", "true").strip() not in TRUE
        ]
        if floats:
            words = "without gravity in the file; they weigh all they weigh"
            notes.append(f"not carried over: {listed(floats)} {words}")
        foreign = [str(each.tag).rpartition("}")[2] for each in self.model if "}" in str(each.tag)]
        if foreign:
            notes.append(f"not carried over: {cut(listed(foreign), 200)}, extensions of SDF")
