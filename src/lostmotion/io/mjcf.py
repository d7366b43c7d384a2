"""MJCF, the format of MuJoCo, as links and joints like those of a URDF: bodies, hinges, slides and
sites of the model that MuJoCo compiles.

A body may have several joints, each with an anchor of its own. Between two of them is a link
without mass, BODY@JOINT. Where the last anchor is not at the body's origin, BODY@JOINT has the
mass, and BODY is a frame fixed to it. Sites are frames too: those of tools. In the file's pose all
joints are at zero.
"""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.errors import Problem, shown
from lostmotion.io.dh import rpy_of
from lostmotion.io.limits import listed
from lostmotion.io.mjcf_loops import add_equalities
from lostmotion.io.mjcf_xml import self_contained
from lostmotion.io.own_process import ask
from lostmotion.io.sidecar import limits_in_sidecar
from lostmotion.io.text import refuse
from lostmotion.io.urdf_tree import (
    MOST_ELEMENTS,
    UrdfJoint,
    UrdfLink,
    UrdfTree,
    free_name,
    is_name,
)
from lostmotion.spatial import pose_by_quaternion
from lostmotion.units import LARGEST

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

ROOT: Final = "mujoco"
# Of a processor. Meshes are read only where a mass follows from them.
_SECONDS: Final = 15
# Types of joints, as MuJoCo and as URDF calls them.
_TYPES: Final = {"free": "floating", "ball": "ball", "slide": "prismatic", "hinge": "revolute"}
_WORLD: Final = "world"
# Numbers that are calculated with.
_MATRICES: Final = (
    "body_pos",
    "body_quat",
    "body_ipos",
    "body_mass",
    "jnt_pos",
    "jnt_axis",
    "jnt_range",
    "qpos0",
    "site_pos",
    "site_quat",
    "eq_data",
)


def read_tree(path: Path, text: str, root: Path) -> UrdfTree:
    """Return the links and joints of an MJCF file, which may name others within the folder `root`.

    Raises InputError where the package mujoco is not installed, for files that are missing or
    outside that folder, and in MuJoCo's words for a model that it does not compile.
    """
    if importlib.util.find_spec("mujoco") is None:
        expected = "the package mujoco, which compiles it: pip install 'lostmotion[mujoco]'"
        refuse(
            str(path),
            "",
            "this is MJCF (MuJoCo), and the package mujoco is not installed",
            expected,
            "pip install 'lostmotion[mujoco]'",
        )
    model = self_contained(path, text, root)
    meshes = {name: str(file.absolute()) for name, file in model.meshes.items()}
    request = {"file": str(path), "xml": model.xml, "meshes": meshes}
    compiled = ask("lostmotion.io.mjcf_process", request, str(path), _SECONDS)
    tree = UrdfTree(
        str(path),
        name=model.name,
        notes=[*model.notes],
        format="MJCF",
        root="/mujoco",
        hinge='<joint name="j1" type="hinge">',
    )
    built = _Builder(tree, compiled, model.lines).build()
    for joint in built.joints.values():
        joint.driven = joint.name in model.driven
    return built


def self_contained_text(path: Path, text: str, root: Path) -> str:
    """Return the text of one file with everything that counts. Raises InputError where a mass
    follows from a mesh.
    """
    model = self_contained(path, text, root)
    if model.meshes:
        found = (
            "masses that follow from the meshes "
            f"{listed([file.name for file in model.meshes.values()])}"
        )
        expected = (
            "masses by <inertial> in the bodies, or in a file that is stored as text: TOML or URDF"
        )
        refuse(
            str(path),
            "",
            found,
            expected,
            '<inertial pos="0 0 0.1" mass="2" diaginertia="0.1 0.1 0.1"/>',
        )
    return model.xml


class _Builder:
    """Builds a tree from the arrays of a compiled model."""

    def __init__(self, tree: UrdfTree, compiled: dict[str, Any], lines: dict[str, int]) -> None:
        self.tree = tree
        self.lines = lines
        self.model = {
            name: np.array(value, dtype=float) if name in _MATRICES else value
            for name, value in compiled.items()
        }
        wrong = [name for name in _MATRICES if not np.all(np.abs(self.model[name]) <= LARGEST)]
        if wrong:
            expected = f"finite numbers up to {LARGEST:g} in m, kg and rad"
            refuse(
                tree.file,
                tree.root,
                f"numbers that are not finite or too large: {', '.join(wrong)} of MuJoCo",
                expected,
                'pos="0 0 0.3"',
            )
        self.parents: list[int] = compiled["body_parentid"]
        self.bodies = self._names(
            "body", [_WORLD, *(f"body_{k}" for k in range(1, len(self.parents)))]
        )
        owners = [self.bodies[body] for body in compiled["jnt_bodyid"]]
        self.joints = self._names("joint", [f"{owner}_joint" for owner in owners])
        self.carriers: list[str] = []  # the link that carries mass and children of each body
        self.anchors: list[Floats] = []  # its place in the body's frame

    def build(self) -> UrdfTree:
        """Return the tree, or raise InputError with every mistake."""
        for body in range(len(self.parents)):
            self._add_body(body)
        for site, name in enumerate(self.model["site"]):
            if name and is_name(name) and len(self.tree.links) < MOST_ELEMENTS:
                pose = pose_by_quaternion(
                    self.model["site_pos"][site], self.model["site_quat"][site]
                )
                link = free_name(name, self.tree.links, "site")
                self._add_frame(link, self.model["site_bodyid"][site], pose)
        add_equalities(self.tree, self.model, self.joints, self.carriers, self.anchors)
        self._note()
        self.tree.connect()
        return self.tree

    def _names(self, kind: str, otherwise: list[str]) -> list[str]:
        """Return a name for each body or joint: its own, else one made from where it is."""
        out: dict[str, None] = {}
        stated = self.model[kind]
        if len(stated) > MOST_ELEMENTS:
            refuse(
                self.tree.file,
                self.tree.root,
                f"{len(stated)} elements <{kind}>",
                f"at most {MOST_ELEMENTS}",
                "one arm per file",
            )
        for name, other in zip(stated, otherwise, strict=True):
            if name and not is_name(name):
                refuse(
                    self.tree.file,
                    self.tree.root,
                    f"the name {shown(name)}",
                    "a name in one line of printable text",
                    f'<{kind} name="{kind}_1">',
                )
            out[name or free_name(other, [*stated, *out], kind)] = None
        return list(out)

    def _add_body(self, body: int) -> None:
        name, model = self.bodies[body], self.model
        joints = [k for k, owner in enumerate(model["jnt_bodyid"]) if owner == body]
        anchor = model["jnt_pos"][joints[-1]] if joints and self._turns(joints[-1]) else np.zeros(3)
        moved = bool(np.any(anchor))
        carrier = self._between(body, joints[-1]) if moved else name
        self.carriers.append(carrier)
        self.anchors.append(anchor)
        centre = tuple((model["body_ipos"][body] - anchor).tolist())
        mass = float(model["body_mass"][body])
        self.tree.links[carrier] = UrdfLink(
            carrier,
            mass,
            centre if mass else (0.0, 0.0, 0.0),
            not mass and not model["body_geomnum"][body],
        )
        if body:
            self._add_joints(body, joints)
        if moved:
            self._add_frame(name, body, pose_by_quaternion(np.zeros(3)))

    def _add_joints(self, body: int, joints: list[int]) -> None:
        """Add the joints between a body and its parent: one that is fixed where it has none."""
        model, parent = self.model, self.parents[body]
        seat = pose_by_quaternion(-self.anchors[parent]) @ pose_by_quaternion(
            model["body_pos"][body], model["body_quat"][body]
        )
        link = self.carriers[parent]
        if not joints:
            self._add(f"{self.bodies[body]}_fixed", "fixed", link, self.carriers[body], seat)
            return
        before = np.zeros(3)
        for joint in joints:
            anchor = model["jnt_pos"][joint] if self._turns(joint) else np.zeros(3)
            child = self.carriers[body] if joint == joints[-1] else self._between(body, joint)
            self.tree.links.setdefault(child, UrdfLink(child, is_frame=True))
            added = self._add(
                self.joints[joint],
                _TYPES[model["jnt_type"][joint]],
                link,
                child,
                seat @ pose_by_quaternion(anchor - before),
            )
            self._move(added, joint)
            link, before, seat = child, anchor, pose_by_quaternion(np.zeros(3))

    def _between(self, body: int, joint: int) -> str:
        """Return the name of the link behind one of the joints of a body."""
        return free_name(f"{self.bodies[body]}@{self.joints[joint]}", self.bodies, "link")

    def _turns(self, joint: int) -> bool:
        """Return whether a joint turns about an anchor: that of a slide shifts nothing."""
        return self.model["jnt_type"][joint] in {"hinge", "ball"}

    def _move(self, added: UrdfJoint, joint: int) -> None:
        """Set what a joint that moves has besides its place: axis and limits, from the pose of the
        file.
        """
        x, y, z = self.model["jnt_axis"][joint].tolist()
        added.axis = (x, y, z)
        at = (f"{self.tree.file}:{added.line}" if added.line else self.tree.file, added.path)
        limited = bool(self.model["jnt_limited"][joint])
        if added.type == "ball":
            expected = "hinge or slide joints between base and tool, or a loop that it is part of"
            added.other_mistakes.append(Problem(*at, "a ball joint", expected, 'type="hinge"'))
            if limited:
                self._limit_ball(added, joint)
        elif added.type == "revolute" and not limited:
            added.type = "continuous"
        elif added.type == "prismatic" and not limited:
            stated = limits_in_sidecar(Path(self.tree.file), added.name, added.type)
            expected = (
                f"range in m, for it decides every figure; or limits in the sidecar, {stated}"
            )
            added.limit_mistakes.append(
                Problem(*at, "a slide without range", expected, 'range="0 0.5"')
            )
        elif added.type != "floating":
            low, high = (self.model["jnt_range"][joint] - self.model["qpos0"][joint]).tolist()
            added.limits = (low, high)
        zero = float(self.model["qpos0"][joint])
        if zero and added.moves:
            shown_zero = (
                f"{math.degrees(zero):.4g} deg"
                if added.type != "prismatic"
                else f"{1e3 * zero:.4g} mm"
            )
            self.tree.notes.append(
                f"joint '{added.name}' is at zero in the pose of the file, which MuJoCo calls "
                f"{shown_zero} (ref)"
            )

    def _limit_ball(self, added: UrdfJoint, joint: int) -> None:
        """Set the cone of a ball joint, about the direction to the centre of mass of its body."""
        body = self.model["jnt_bodyid"][joint]
        axis = self.model["body_ipos"][body] - self.model["jnt_pos"][joint]
        x, y, z = axis.tolist() if np.any(axis) else (0.0, 0.0, 1.0)
        added.axis, cone = (x, y, z), float(self.model["jnt_range"][joint][1])
        added.limits = (0.0, cone if cone < math.pi else 0.0)

    def _add(self, name: str, kind: str, parent: str, child: str, seat: Floats) -> UrdfJoint:
        x, y, z = seat[:3, 3].tolist()
        if kind == "fixed":
            name = free_name(name, {*self.tree.joints, *self.joints}, "fixed")
        joint = UrdfJoint(
            name,
            kind,
            parent,
            child,
            (x, y, z),
            rpy_of(seat[:3, :3]),
            self.lines.get(name, 0),
            root="/",
        )
        self.tree.joints[name] = joint
        return joint

    def _add_frame(self, name: str, body: int, pose: Floats) -> None:
        """Add a link without mass at a pose in the frame of a body."""
        self.tree.links[name] = UrdfLink(name, is_frame=True)
        self._add(
            f"{name}_fixed",
            "fixed",
            self.carriers[body],
            name,
            pose_by_quaternion(-self.anchors[body]) @ pose,
        )

    def _note(self) -> None:
        joints = self.tree.joints.values()
        cones = [joint.name for joint in joints if joint.type == "ball" and joint.limits[1]]
        if cones:
            self.tree.notes.append(
                f"the range of {listed(cones)} is a cone about the direction to the centre of mass "
                "of the body; MuJoCo limits the whole rotation"
            )
        springs = [
            self.joints[k] for k, stiffness in enumerate(self.model["jnt_stiffness"]) if stiffness
        ]
        if springs:
            self.tree.notes.append(
                f"not carried over: the springs of {listed(springs)}; their forces are missing"
            )
        held = [self.bodies[k] for k, part in enumerate(self.model["body_gravcomp"]) if part]
        if held:
            self.tree.notes.append(
                f"not carried over: the gravity compensation (gravcomp) of {listed(held)}; "
                "they weigh all they weigh"
            )
