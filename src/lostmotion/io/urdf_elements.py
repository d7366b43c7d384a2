"""Reading of a URDF's elements into a tree: names, origins, axes, limits and inertials, with every
mistake noted at its line.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import TYPE_CHECKING, Final

from lostmotion.errors import Problem, shown
from lostmotion.io.limits import nearest, refuse_all
from lostmotion.io.sidecar import limits_in_sidecar
from lostmotion.io.text import numbers, refuse
from lostmotion.io.urdf_tree import (
    LARGEST_NUMBER,
    LIMITED,
    LONGEST_NAME,
    MOST_ELEMENTS,
    MOVING,
    Three,
    UrdfJoint,
    UrdfLink,
    UrdfTree,
    is_name,
)
from lostmotion.io.urdf_xml import line_of, parse_robot
from lostmotion.units import LARGEST

if TYPE_CHECKING:
    from lxml import etree

_ZERO: Final = (0.0, 0.0, 0.0)
_TYPES: Final = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_BLANK: Final = " \t\r\n"
_BLANKS: Final = re.compile(f"[{_BLANK}]+")


def read_tree(text: str, file: str, *, has_lines: bool = True) -> UrdfTree:
    """Return the links and joints that a URDF text describes. Without `has_lines` the lines of the
    text are not those of the file.

    Mistakes in numbers stay in `tree.mistakes`, for the caller to raise with its own. Raises
    InputError where there is no tree: with every mistake, each with its line and element.
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
            refuse(
                file,
                "/robot",
                f"{count} {what}s",
                f"at most {MOST_ELEMENTS} {what}s",
                f'<{what} name="{what}_1">',
            )
    for element in robot.iterchildren("link"):
        reader.link(element)
    for element in robot.iterchildren("joint"):
        reader.joint(element)
    if not tree.links:
        tree.refuse(
            line_of(robot), "/robot", "no link", "links and joints", '<link name="base_link"/>'
        )
    before = len(tree.mistakes)
    if not reader.lost:
        tree.connect()
    if reader.lost or len(tree.mistakes) > before or not tree.links:
        # Without a tree nobody knows which joints move the tool: all their mistakes are reported.
        every = [
            *tree.mistakes,
            *(mistake for joint in tree.joints.values() for mistake in joint.mistakes),
        ]
        refuse_all(sorted(every, key=lambda mistake: _line_in(mistake.file)))
    return tree


def _line_in(place: str) -> int:
    line = place.rpartition(":")[2]
    return int(line) if line.isdecimal() else 0


def _end(joint: etree._Element, end: str) -> str:
    found = joint.find(end)
    return "" if found is None else found.get("link", "").strip(" ")


def _effort(limit: etree._Element | None) -> float:
    """Return the effort limit; 0 for none, and for what is no number: nothing that is read depends
    on it.
    """
    try:
        (value,) = numbers([("" if limit is None else limit.get("effort", "")).strip(_BLANK)])
    except ValueError:
        return 0.0
    return value if 0 < value <= LARGEST else 0.0


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
        link.is_frame = (
            inertial is None
            and element.find("visual") is None
            and element.find("collision") is None
        )
        if inertial is None:
            return
        path = f'/robot/link[@name="{name}"]/inertial'
        mass = inertial.find("mass")
        if mass is None:
            self.tree.refuse(
                line_of(inertial), path, "no mass", "a mass in kg", '<mass value="1.2"/>'
            )
            return
        link.mass = self._numbers(mass, path, "value", (0.0,), '"1.2"')[0]
        if link.mass < 0:
            self.tree.refuse(
                line_of(mass),
                f"{path}/mass/@value",
                f"{link.mass:g}",
                "a mass in kg, zero or more",
                '<mass value="1.2"/>',
            )
        if link.mass:  # where nothing weighs, nobody asks for its centre
            link.centre = self._three(inertial.find("origin"), path, "xyz", _ZERO)

    def joint(self, element: etree._Element) -> None:
        name = self._name(element, "joint", self.tree.joints)
        if name is None:
            return
        line, origin = line_of(element), element.find("origin")
        path = f'/robot/joint[@name="{name}"]'
        xyz, rpy = (self._three(origin, path, what, _ZERO) for what in ("xyz", "rpy"))
        joint = UrdfJoint(
            name,
            element.get("type", ""),
            _end(element, "parent"),
            _end(element, "child"),
            xyz,
            rpy,
            line,
        )
        self.tree.joints[name] = joint
        if joint.type not in _TYPES:
            near = nearest(joint.type, _TYPES)
            words = (
                f"{path}/@type",
                shown(joint.type),
                f"one of {', '.join(_TYPES)}",
                f'type="{near or "revolute"}"',
                near,
            )
            joint.other_mistakes.append(Problem(self._at(element), *words))
        elif joint.type in MOVING:
            self._motion(element, joint)

    def _motion(self, element: etree._Element, joint: UrdfJoint) -> None:
        """Read what only a moving joint has; on others it has no meaning and is not read."""
        kept, self.tree.mistakes = self.tree.mistakes, joint.limit_mistakes
        joint.limits = self._limits(element, joint)
        joint.effort = _effort(element.find("limit"))
        self.tree.mistakes = joint.other_mistakes
        if joint.limits != (0.0, 0.0) or not joint.locked:
            joint.axis = self._axis(element, joint.path)
        self.tree.mistakes = kept
        mimic = element.find("mimic")
        if mimic is not None:
            joint.leader = shown(mimic.get("joint", "?"), 42)[1:-1]
            offset = mimic.get("offset", "0")
            factor = shown(mimic.get("multiplier", "1"), 20)[1:-1]
            joint.coupling = f"mimic, x {factor}" + (
                "" if re.fullmatch(r"[-+0. ]*", offset) else f", offset {shown(offset, 20)[1:-1]}"
            )

    def _at(self, element: etree._Element) -> str:
        line = line_of(element)
        return f"{self.tree.file}:{line}" if line else self.tree.file

    def _name(
        self, element: etree._Element, what: str, taken: dict[str, UrdfLink] | dict[str, UrdfJoint]
    ) -> str | None:
        name, line = element.get("name", "").strip(" "), line_of(element)
        if not name:
            self.lost = True
            self.tree.refuse(
                line, f"/robot/{what}/@name", "no name", "a name", f'<{what} name="{what}_1">'
            )
            return None
        if not is_name(name):
            self.lost = True
            expected = f"a name in one line of printable text, at most {LONGEST_NAME} characters"
            self.tree.refuse(
                line, f"/robot/{what}/@name", shown(name), expected, f'<{what} name="{what}_1">'
            )
            return None
        if name in taken:
            self.lost = True
            self.tree.refuse(
                line,
                f"/robot/{what}/@name",
                f"the name {shown(name)} twice",
                f"a name of its own for every {what}",
                f'<{what} name="{what}_2">',
            )
            return None
        return name

    def _axis(self, element: etree._Element, path: str) -> Three:
        axis = element.find("axis")
        before = len(self.tree.mistakes)
        stated = self._three(axis, path, "xyz", (1.0, 0.0, 0.0))
        if (
            axis is not None
            and len(self.tree.mistakes) == before
            and not 0 < math.hypot(*stated) < math.inf
        ):
            found = shown(axis.get("xyz", ""))
            self.tree.refuse(
                line_of(axis),
                f"{path}/axis/@xyz",
                found,
                "a direction that is not zero: this joint moves",
                '<axis xyz="0 0 1"/>',
            )
        return stated

    def _limits(self, element: etree._Element, joint: UrdfJoint) -> tuple[float, float]:
        path = joint.path
        if joint.type not in LIMITED:
            return 0.0, 0.0
        limit, example = (
            element.find("limit"),
            '<limit lower="-1.57" upper="1.57" effort="0" velocity="0"/>',
        )
        if limit is None or not {"lower", "upper"} & set(limit.attrib):
            found = "no limit" if limit is None else "a limit without lower and upper"
            expected = (
                "lower and upper in rad or m; both default to 0 in URDF, so that the joint would "
                "not move; or limits in the sidecar, "
            )
            expected += limits_in_sidecar(Path(self.tree.file), joint.name, joint.type)
            self.tree.refuse(
                line_of(element if limit is None else limit), path, found, expected, example
            )
            return 0.0, 0.0
        low = self._numbers(limit, path, "lower", (0.0,), '"-1.57"')[0]
        high = self._numbers(limit, path, "upper", (0.0,), '"1.57"')[0]
        if low > high:
            self.tree.refuse(
                line_of(limit),
                f"{path}/limit",
                f"limits from {low:g} to {high:g}",
                "a lower limit below the upper one",
                example,
            )
        return low, high

    def _three(
        self, element: etree._Element | None, path: str, name: str, left_out: Three
    ) -> Three:
        if element is None:
            return left_out
        x, y, z = self._numbers(element, path, name, left_out, '"0 0 1"')
        return x, y, z

    def _numbers(
        self,
        element: etree._Element,
        path: str,
        name: str,
        left_out: tuple[float, ...],
        example: str,
    ) -> tuple[float, ...]:
        """Return the numbers of an attribute; the default, where it is missing or wrong."""
        stated = element.get(name)
        if stated is None:
            return left_out
        try:
            values = tuple(numbers(_BLANKS.split(stated.strip(_BLANK))))
        except ValueError:
            values = ()
        if len(values) == len(left_out) and all(abs(value) <= LARGEST_NUMBER for value in values):
            return values
        expected = "a finite number" if len(left_out) == 1 else f"{len(left_out)} finite numbers"
        expected += " in plain decimal notation"
        self.tree.refuse(
            line_of(element),
            f"{path}/{element.tag}/@{name}",
            shown(stated),
            expected,
            f"{name}={example}",
        )
        return left_out
