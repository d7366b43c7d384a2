"""The links and joints of a URDF file as one tree, checked as a whole; meshes, materials and extensions are never looked at.

The file is taken for hostile: no document type, no entities, no network, bounded depth, and no other file is ever opened.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import Final

from lxml import etree

from lostmotion.errors import Problem, shown
from lostmotion.formats.bounds import MOST_MISTAKES, listed, nearest, refuse_all
from lostmotion.formats.text import numbers, refuse
from lostmotion.parts.joint import NAME_PATTERN
from lostmotion.units import LARGEST

Three = tuple[float, float, float]
_ZERO: Final = (0.0, 0.0, 0.0)
_MOVING: Final = ("revolute", "continuous", "prismatic")
_TYPES: Final = (*_MOVING, "fixed", "floating", "planar")
_BLANK: Final = " \t\r\n"
_BLANKS: Final = re.compile(f"[{_BLANK}]+")
_MOST_ELEMENTS: Final = 1000
_LONGEST_NAME: Final = 80


@dataclass
class UrdfLink:
    """A body: its mass (kg), and the centre of it (m) in its frame."""

    name: str
    mass: float = 0.0
    centre: Three = _ZERO


@dataclass
class UrdfJoint:
    """A joint as the file states it: m, rad, axis of any length; `line` and `path` say where it stands."""

    name: str
    type: str
    parent: str
    child: str
    xyz: Three
    rpy: Three
    axis: Three
    limits: tuple[float, float]
    mimic: bool
    line: int

    @property
    def moves(self) -> bool:
        """Tell a joint that turns or slides."""
        return self.type in _MOVING

    @property
    def path(self) -> str:
        """Give the element as an XPath."""
        return f'/robot/joint[@name="{self.name}"]'


@dataclass
class UrdfTree:
    """All links and joints by name, and the mistakes found so far."""

    file: str
    name: str = ""
    links: dict[str, UrdfLink] = field(default_factory=dict)
    joints: dict[str, UrdfJoint] = field(default_factory=dict)
    mistakes: list[Problem] = field(default_factory=list)
    _children: dict[str, list[UrdfJoint]] = field(default_factory=dict)
    _parent: dict[str, UrdfJoint] = field(default_factory=dict)

    def refuse(self, line: int, path: str, *words: str) -> None:
        """Note a mistake: what was found, what is expected, an example, and the nearest name."""
        if not self.full:
            self.mistakes.append(Problem(f"{self.file}:{line}" if line else self.file, path, *words))

    @property
    def full(self) -> bool:
        """Tell whether more mistakes are known than will be listed: no need to look for others."""
        return len(self.mistakes) > MOST_MISTAKES

    def children(self, link: str) -> list[UrdfJoint]:
        """Which joints lead away from this link?"""
        return self._children.get(link, [])

    def leaves(self) -> list[str]:
        """Which links end the tree?"""
        return [name for name in self.links if name not in self._children]

    def moving_leaves(self) -> list[str]:
        """Which links end a chain that moves?"""
        out = []
        waiting = [(name, False) for name in self.links if name not in self._parent]
        while waiting:
            name, moves = waiting.pop()
            if moves and not self.children(name):
                out.append(name)
            waiting += [(joint.child, moves or joint.moves) for joint in reversed(self.children(name))]
        return out

    def path_to(self, link: str) -> list[UrdfJoint]:
        """Which joints lead from the root to this link?"""
        out = []
        while link in self._parent:
            out.append(self._parent[link])
            link = out[-1].parent
        return out[::-1]

    def connect(self) -> None:
        """Hang every joint between its links; note links that do not exist, second parents, several roots, loops."""
        lost = False
        for joint in self.joints.values():
            for end, link in (("parent", joint.parent), ("child", joint.child)):
                if self.full:
                    return
                if link not in self.links:
                    lost = True
                    near = nearest(link, self.links)
                    known = near or next(iter(self.links), "base_link")
                    self.refuse(
                        joint.line, f"{joint.path}/{end}/@link", shown(link), "the name of a link of this file", f'<{end} link="{known}"/>', near
                    )
            if joint.child in self._parent:
                other = self._parent[joint.child].name
                found = f"a second parent of link '{joint.child}', beside joint '{other}'"
                self.refuse(joint.line, f"{joint.path}/child", found, "one parent for every link", '<child link="another_link"/>')
                continue
            self._parent[joint.child] = joint
            self._children.setdefault(joint.parent, []).append(joint)
        if not lost:
            self._check_whole()

    def _check_whole(self) -> None:
        roots = [name for name in self.links if name not in self._parent]
        if len(roots) > 1:
            found = f"{len(roots)} links without a parent: {listed(roots)}"
            example = f'<joint name="mount" type="fixed"><parent link="{roots[0]}"/><child link="{roots[1]}"/></joint>'
            self.refuse(0, "/robot", found, "one root link", example)
        reached = set(roots)
        waiting = list(roots)
        while waiting:
            for joint in self.children(waiting.pop()):
                reached.add(joint.child)
                waiting.append(joint.child)
        if len(reached) < len(self.links):
            around = [joint.name for joint in self.joints.values() if joint.child not in reached]
            first = self.joints[around[0]]
            found = f"joints that lead round in a loop: {listed(around)}"
            self.refuse(first.line, first.path, found, "a tree: every link reached from one root", '<parent link="base_link"/>')


def read_tree(text: str, file: str) -> UrdfTree:
    """Which links and joints does this URDF text describe? Raises InputError with every mistake, each with its line and element."""
    tree = UrdfTree(file)
    robot = _parsed(text, file)
    tree.name = robot.get("name", "")
    reader = _Reader(tree)
    for what in ("link", "joint"):
        count = sum(1 for _ in robot.iterchildren(what))
        if count > _MOST_ELEMENTS:
            refuse(file, "/robot", f"{count} {what}s", f"at most {_MOST_ELEMENTS} {what}s", f'<{what} name="{what}_1">')
    for element in robot.iterchildren("link"):
        reader.link(element)
    for element in robot.iterchildren("joint"):
        reader.joint(element)
    if not tree.links:
        tree.refuse(_line(robot), "/robot", "no link", "links and joints", '<link name="base_link"/>')
    if not reader.misnamed:
        tree.connect()
    if tree.mistakes:
        refuse_all(tree.mistakes)
    return tree


def _parsed(text: str, file: str) -> etree._Element:
    # Looked for in the text itself, and refused in comments too, so that no parser ever meets a document type.
    if "<!DOCTYPE" in text:
        line = text.count("\n", 0, text.index("<!DOCTYPE")) + 1
        refuse(f"{file}:{line}", "", "a document type (<!DOCTYPE)", "a URDF without one", '<robot name="arm">')
    parser = etree.XMLParser(
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=False,  # keeps libxml2's own bounds on depth and size
        remove_comments=True,
        remove_pis=True,
        encoding="utf-8",  # whatever the file declares: it was decoded and looked through as this
    )
    try:
        robot = etree.fromstring(text.encode(), parser)
    except etree.XMLSyntaxError as error:
        refuse(f"{file}:{error.lineno}", "", shown(error.msg or "no XML", 120)[1:-1], "well-formed XML", '<robot name="arm"> ... </robot>')
    if robot.tag != "robot":
        refuse(f"{file}:{_line(robot)}", "", f"the root element {shown(str(robot.tag))}", "the root element robot", '<robot name="arm">')
    for element in robot.iter():
        if str(element.tag).startswith("{") and "xacro" in str(element.tag).partition("}")[0]:
            found = f"the macro {shown(str(element.tag).partition('}')[2])}"
            refuse(f"{file}:{_line(element)}", "/robot", found, "a URDF with its macros expanded", "xacro arm.urdf.xacro > arm.urdf")
    return robot


def _line(element: etree._Element) -> int:
    return element.sourceline if isinstance(element.sourceline, int) else 0


def _end(joint: etree._Element, end: str) -> str:
    found = joint.find(end)
    return "" if found is None else found.get("link", "")


class _Reader:
    """Reads elements into a tree, noting every mistake."""

    def __init__(self, tree: UrdfTree) -> None:
        self.tree = tree
        self.misnamed = False  # an element is left out, and others would seem to lead nowhere

    def link(self, element: etree._Element) -> None:
        name = self._name(element, "link", self.tree.links)
        if name is None:
            return
        link = self.tree.links[name] = UrdfLink(name)
        inertial = element.find("inertial")
        if inertial is None:
            return
        path = f'/robot/link[@name="{name}"]/inertial'
        mass = inertial.find("mass")
        if mass is None:
            self.tree.refuse(_line(inertial), path, "no mass", "a mass in kg", '<mass value="1.2"/>')
            return
        link.mass = self._numbers(mass, path, "value", (0.0,), '"1.2"')[0]
        if link.mass < 0:
            self.tree.refuse(_line(mass), f"{path}/mass/@value", f"{link.mass:g}", "a mass in kg, zero or more", '<mass value="1.2"/>')
        link.centre = self._three(inertial.find("origin"), path, "xyz", _ZERO)

    def joint(self, element: etree._Element) -> None:
        name = self._name(element, "joint", self.tree.joints)
        if name is None:
            return
        path, line = f'/robot/joint[@name="{name}"]', _line(element)
        if not re.match(NAME_PATTERN, name):
            self.tree.refuse(line, path, shown(name), "a name of letters, digits, spaces, - and _, at most 40", 'name="shoulder_pan_joint"')
        kind = element.get("type", "")
        if kind not in _TYPES:
            near = nearest(kind, _TYPES)
            self.tree.refuse(line, f"{path}/@type", shown(kind), f"one of {', '.join(_TYPES)}", f'type="{near or "revolute"}"', near)
        origin = element.find("origin")
        self.tree.joints[name] = UrdfJoint(
            name,
            kind,
            _end(element, "parent"),
            _end(element, "child"),
            self._three(origin, path, "xyz", _ZERO),
            self._three(origin, path, "rpy", _ZERO),
            self._axis(element, path),
            self._limits(element, path, kind),
            mimic=element.find("mimic") is not None,
            line=line,
        )

    def _name(self, element: etree._Element, what: str, taken: dict[str, UrdfLink] | dict[str, UrdfJoint]) -> str | None:
        name, line = element.get("name", ""), _line(element)
        if not name:
            self.tree.refuse(line, f"/robot/{what}/@name", "no name", "a name", f'<{what} name="{what}_1">')
            return None
        if not name.isprintable() or len(name) > _LONGEST_NAME:
            self.misnamed = True
            expected = f"a name in one line of printable text, at most {_LONGEST_NAME} characters"
            self.tree.refuse(line, f"/robot/{what}/@name", shown(name), expected, f'<{what} name="{what}_1">')
            return None
        if name in taken:
            self.tree.refuse(
                line, f"/robot/{what}/@name", f"the name {shown(name)} once more", f"a name of its own for every {what}", f'<{what} name="{what}_2">'
            )
            return None
        return name

    def _axis(self, element: etree._Element, path: str) -> Three:
        axis = element.find("axis")
        stated = self._three(axis, path, "xyz", (1.0, 0.0, 0.0))
        if axis is not None and not 0 < math.hypot(*stated) < math.inf:
            self.tree.refuse(_line(axis), f"{path}/axis/@xyz", shown(axis.get("xyz", "")), "a direction that is not zero", '<axis xyz="0 0 1"/>')
        return stated

    def _limits(self, element: etree._Element, path: str, kind: str) -> tuple[float, float]:
        if kind not in ("revolute", "prismatic"):
            return 0.0, 0.0
        limit, example = element.find("limit"), '<limit lower="-1.57" upper="1.57" effort="0" velocity="0"/>'
        if limit is None:
            self.tree.refuse(_line(element), path, "no limit", "limits in rad or m", example)
            return 0.0, 0.0
        low = self._numbers(limit, path, "lower", (0.0,), '"-1.57"')[0]
        high = self._numbers(limit, path, "upper", (0.0,), '"1.57"')[0]
        if low >= high:
            self.tree.refuse(_line(limit), f"{path}/limit", f"limits from {low:g} to {high:g}", "a lower limit below the upper one", example)
        return low, high

    def _three(self, element: etree._Element | None, path: str, name: str, left_out: Three) -> Three:
        if element is None:
            return left_out
        x, y, z = self._numbers(element, path, name, left_out, '"0 0 1"')
        return x, y, z

    def _numbers(self, element: etree._Element, path: str, name: str, left_out: tuple[float, ...], example: str) -> tuple[float, ...]:
        """Give the numbers of an attribute; those left out, where it is missing or wrong."""
        stated = element.get(name)
        if stated is None:
            return left_out
        try:
            values = tuple(numbers(_BLANKS.split(stated.strip(_BLANK))))
        except ValueError:
            values = ()
        if len(values) == len(left_out) and all(abs(value) <= LARGEST for value in values):
            return values
        expected = "a finite number" if len(left_out) == 1 else f"{len(left_out)} finite numbers"
        expected += " in plain decimal notation"
        self.tree.refuse(_line(element), f"{path}/{element.tag}/@{name}", shown(stated), expected, f"{name}={example}")
        return left_out
