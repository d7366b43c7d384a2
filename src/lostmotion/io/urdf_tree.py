"""The links and joints of a URDF file as one tree, checked as a whole; meshes, materials and extensions are never read.

Mistakes that count only where a joint moves the tool (axis, limits, type) stay with the joint: beside the chain it is held at zero.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from lostmotion.errors import Problem, shown
from lostmotion.io.limits import MOST_MISTAKES, listed, nearest, refuse_all
from lostmotion.io.text import numbers, refuse
from lostmotion.io.urdf_xml import line_of, parse_robot
from lostmotion.units import LARGEST

if TYPE_CHECKING:
    from lxml import etree

Three = tuple[float, float, float]
_ZERO: Final = (0.0, 0.0, 0.0)
_LIMITED: Final = ("revolute", "prismatic")
_MOVING: Final = (*_LIMITED, "continuous")
_TYPES: Final = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_BLANK: Final = " \t\r\n"
_BLANKS: Final = re.compile(f"[{_BLANK}]+")
MOST_ELEMENTS: Final = 1000
_LONGEST_NAME: Final = 200  # as programs join them; a joint of the arm has a shorter one


@dataclass
class UrdfLink:
    """A body: its mass (kg), and the centre of it (m) in its frame; `is_frame` where it has neither mass nor shape."""

    name: str
    mass: float = 0.0
    centre: Three = _ZERO
    is_frame: bool = False


@dataclass
class UrdfJoint:
    """A joint as the file states it: m, rad, axis of any length; `line` and `path` say where it stands.

    limits    lower and upper, rad or m; zeros for types without
    leader    the joint that it follows (mimic), and `coupling` how; empty where it follows none
    mistakes  what is wrong with its type, axis or limits: it counts only where the joint is on the chain
    root      what stands before its element in an XPath
    """

    name: str
    type: str
    parent: str
    child: str
    xyz: Three
    rpy: Three
    line: int
    axis: Three = (1.0, 0.0, 0.0)
    limits: tuple[float, float] = (0.0, 0.0)
    leader: str = ""
    coupling: str = ""
    mistakes: list[Problem] = field(default_factory=list)
    root: str = "/robot"

    @property
    def locked(self) -> bool:
        """Return whether the lower limit equals the upper one, so that the joint is held there."""
        return self.type in _LIMITED and not self.mistakes and self.limits[0] == self.limits[1]

    @property
    def moves(self) -> bool:
        """Return whether the joint turns or slides."""
        return self.type in _MOVING and not self.locked

    @property
    def path(self) -> str:
        """Return the element as an XPath."""
        return f'{self.root}/joint[@name="{self.name}"]'


@dataclass
class UrdfTree:
    """All links and joints by name, the mistakes found so far, and notes on what was repaired.

    format  as it is called in messages
    root    the root element as an XPath
    hinge   an example of a joint that moves
    """

    file: str
    name: str = ""
    format: str = "URDF"
    root: str = "/robot"
    hinge: str = '<joint name="A" type="revolute">'
    notes: list[str] = field(default_factory=list)
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
        """Return whether more mistakes are known than will be listed: no need to look for others."""
        return len(self.mistakes) > MOST_MISTAKES

    def children(self, link: str) -> list[UrdfJoint]:
        """Return the joints that lead away from this link."""
        return self._children.get(link, [])

    @property
    def roots(self) -> list[str]:
        """Return the links without a parent."""
        return [name for name in self.links if name not in self._parent]

    def path_to(self, link: str, base: str | None = None) -> list[UrdfJoint] | None:
        """Return the joints from the base (the root unless stated) to this link. None where the base does not lead there."""
        out = []
        while link in self._parent and link != base:
            out.append(self._parent[link])
            link = out[-1].parent
        return out[::-1] if base in (None, link) else None

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
        roots = self.roots
        if len(roots) > 1:
            found = f"{len(roots)} links without a parent: {listed(roots)}"
            example = f'<joint name="mount" type="fixed"><parent link="{roots[0]}"/><child link="{roots[1]}"/></joint>'
            self.refuse(0, self.root, found, "one root link", example)
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


def read_tree(text: str, file: str, *, has_lines: bool = True) -> UrdfTree:
    """Return the links and joints that a URDF text describes. Without `has_lines` the lines of the text are not those of the file.

    Mistakes in numbers stay in `tree.mistakes`, for the caller to raise with its own. Raises InputError where there is no tree: with every mistake,
    each with its line and element.
    """
    tree = UrdfTree(file)
    robot, tree.notes = parse_robot(text, file)
    if not has_lines:
        for element in robot.iter():
            element.sourceline = 0  # type: ignore[assignment] # the stubs know no number here
    tree.name = robot.get("name", "")
    reader = _Reader(tree)
    for what in ("link", "joint"):
        count = sum(1 for _ in robot.iterchildren(what))
        if count > MOST_ELEMENTS:
            refuse(file, "/robot", f"{count} {what}s", f"at most {MOST_ELEMENTS} {what}s", f'<{what} name="{what}_1">')
    for element in robot.iterchildren("link"):
        reader.link(element)
    for element in robot.iterchildren("joint"):
        reader.joint(element)
    if not tree.links:
        tree.refuse(line_of(robot), "/robot", "no link", "links and joints", '<link name="base_link"/>')
    before = len(tree.mistakes)
    if not reader.lost:
        tree.connect()
    if reader.lost or len(tree.mistakes) > before or not tree.links:
        # Without a tree nobody knows which joints move the tool: all their mistakes are reported.
        every = [*tree.mistakes, *(mistake for joint in tree.joints.values() for mistake in joint.mistakes)]
        refuse_all(sorted(every, key=lambda mistake: _line_in(mistake.file)))
    return tree


def is_name(text: str) -> bool:
    """Return whether this may name a link or a joint: one line of printable text that is not too long."""
    return text.isprintable() and len(text) <= _LONGEST_NAME


def _line_in(place: str) -> int:
    line = place.rpartition(":")[2]
    return int(line) if line.isdecimal() else 0


def _end(joint: etree._Element, end: str) -> str:
    found = joint.find(end)
    return "" if found is None else found.get("link", "").strip(" ")


class _Reader:
    """Reads elements into a tree, noting every mistake."""

    def __init__(self, tree: UrdfTree) -> None:
        self.tree = tree
        self.lost = False  # an element is missing, and others would seem to lead nowhere

    def link(self, element: etree._Element) -> None:
        name = self._name(element, "link", self.tree.links)
        if name is None:
            return
        link = self.tree.links[name] = UrdfLink(name)
        inertial = element.find("inertial")
        link.is_frame = inertial is None and element.find("visual") is None and element.find("collision") is None
        if inertial is None:
            return
        path = f'/robot/link[@name="{name}"]/inertial'
        mass = inertial.find("mass")
        if mass is None:
            self.tree.refuse(line_of(inertial), path, "no mass", "a mass in kg", '<mass value="1.2"/>')
            return
        link.mass = self._numbers(mass, path, "value", (0.0,), '"1.2"')[0]
        if link.mass < 0:
            self.tree.refuse(line_of(mass), f"{path}/mass/@value", f"{link.mass:g}", "a mass in kg, zero or more", '<mass value="1.2"/>')
        if link.mass:  # where nothing weighs, nobody asks for its centre
            link.centre = self._three(inertial.find("origin"), path, "xyz", _ZERO)

    def joint(self, element: etree._Element) -> None:
        name = self._name(element, "joint", self.tree.joints)
        if name is None:
            return
        line, origin = line_of(element), element.find("origin")
        path = f'/robot/joint[@name="{name}"]'
        xyz, rpy = (self._three(origin, path, what, _ZERO) for what in ("xyz", "rpy"))
        joint = UrdfJoint(name, element.get("type", ""), _end(element, "parent"), _end(element, "child"), xyz, rpy, line)
        self.tree.joints[name] = joint
        if joint.type not in _TYPES:
            near = nearest(joint.type, _TYPES)
            words = (f"{path}/@type", shown(joint.type), f"one of {', '.join(_TYPES)}", f'type="{near or "revolute"}"', near)
            joint.mistakes.append(Problem(self._at(element), *words))
        elif joint.type in _MOVING:
            self._motion(element, joint)

    def _motion(self, element: etree._Element, joint: UrdfJoint) -> None:
        """Read what only a moving joint has; on others it has no meaning and is not read."""
        kept, self.tree.mistakes = self.tree.mistakes, joint.mistakes
        joint.limits = self._limits(element, joint.path, joint.type)
        if joint.limits != (0.0, 0.0) or not joint.locked:
            joint.axis = self._axis(element, joint.path)
        self.tree.mistakes = kept
        mimic = element.find("mimic")
        if mimic is not None:
            joint.leader = shown(mimic.get("joint", "?"), 42)[1:-1]
            offset = mimic.get("offset", "0")
            factor = shown(mimic.get("multiplier", "1"), 20)[1:-1]
            joint.coupling = f"mimic, x {factor}" + ("" if re.fullmatch(r"[-+0. ]*", offset) else f", offset {shown(offset, 20)[1:-1]}")

    def _at(self, element: etree._Element) -> str:
        line = line_of(element)
        return f"{self.tree.file}:{line}" if line else self.tree.file

    def _name(self, element: etree._Element, what: str, taken: dict[str, UrdfLink] | dict[str, UrdfJoint]) -> str | None:
        name, line = element.get("name", "").strip(" "), line_of(element)
        if not name:
            self.lost = True
            self.tree.refuse(line, f"/robot/{what}/@name", "no name", "a name", f'<{what} name="{what}_1">')
            return None
        if not is_name(name):
            self.lost = True
            expected = f"a name in one line of printable text, at most {_LONGEST_NAME} characters"
            self.tree.refuse(line, f"/robot/{what}/@name", shown(name), expected, f'<{what} name="{what}_1">')
            return None
        if name in taken:
            self.lost = True
            self.tree.refuse(
                line, f"/robot/{what}/@name", f"the name {shown(name)} twice", f"a name of its own for every {what}", f'<{what} name="{what}_2">'
            )
            return None
        return name

    def _axis(self, element: etree._Element, path: str) -> Three:
        axis = element.find("axis")
        before = len(self.tree.mistakes)
        stated = self._three(axis, path, "xyz", (1.0, 0.0, 0.0))
        if axis is not None and len(self.tree.mistakes) == before and not 0 < math.hypot(*stated) < math.inf:
            found = shown(axis.get("xyz", ""))
            self.tree.refuse(line_of(axis), f"{path}/axis/@xyz", found, "a direction that is not zero: this joint moves", '<axis xyz="0 0 1"/>')
        return stated

    def _limits(self, element: etree._Element, path: str, kind: str) -> tuple[float, float]:
        if kind not in _LIMITED:
            return 0.0, 0.0
        limit, example = element.find("limit"), '<limit lower="-1.57" upper="1.57" effort="0" velocity="0"/>'
        if limit is None or not {"lower", "upper"} & set(limit.attrib):
            found = "no limit" if limit is None else "a limit without lower and upper"
            expected = "lower and upper in rad or m; both default to 0 in URDF, so that the joint would not move"
            self.tree.refuse(line_of(element if limit is None else limit), path, found, expected, example)
            return 0.0, 0.0
        low = self._numbers(limit, path, "lower", (0.0,), '"-1.57"')[0]
        high = self._numbers(limit, path, "upper", (0.0,), '"1.57"')[0]
        if low > high:
            self.tree.refuse(line_of(limit), f"{path}/limit", f"limits from {low:g} to {high:g}", "a lower limit below the upper one", example)
        return low, high

    def _three(self, element: etree._Element | None, path: str, name: str, left_out: Three) -> Three:
        if element is None:
            return left_out
        x, y, z = self._numbers(element, path, name, left_out, '"0 0 1"')
        return x, y, z

    def _numbers(self, element: etree._Element, path: str, name: str, left_out: tuple[float, ...], example: str) -> tuple[float, ...]:
        """Return the numbers of an attribute; the default, where it is missing or wrong."""
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
        self.tree.refuse(line_of(element), f"{path}/{element.tag}/@{name}", shown(stated), expected, f"{name}={example}")
        return left_out
