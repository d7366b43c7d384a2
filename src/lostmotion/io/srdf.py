"""Tool links that an SRDF beside a URDF names: what MoveIt calls the tip of a planning group, and
the parent link of an end effector.

The file is NAME.srdf beside NAME.urdf or NAME.urdf.xacro, else the one SRDF of the folder whose
robot has the same name. It is read without entities, and where it cannot be read, the URDF is read
without it, with a note.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Final

from lostmotion.errors import InputError
from lostmotion.io.sidecar import sidecar_place
from lostmotion.io.text import read_old_text
from lostmotion.io.urdf_tree import NamedTips
from lostmotion.io.urdf_xml import parse_plain

if TYPE_CHECKING:
    from lxml import etree

    from lostmotion.io.urdf_tree import UrdfTree

_MEGABYTES: Final = 1
_MOST_FILES: Final = 100
_ENDING: Final = ".srdf"


def add_tips(tree: UrdfTree, path: Path) -> None:
    """Set the tips that the SRDF beside a description names; note an SRDF that cannot be read."""
    file = find_srdf(path, tree.name)
    if file is None:
        return
    try:
        robot = parse_plain(read_old_text(file, _MEGABYTES)[0], str(file))
    except InputError as error:
        tree.notes.append(f"{file.name} is not read: {error.problems[0].found}")
        return
    if robot.tag == "robot":
        tree.tips = NamedTips(
            file.name,
            tuple(link for link in dict.fromkeys(_tips(robot, tree)) if link in tree.links),
        )


def find_srdf(path: Path, robot: str) -> Path | None:
    """Return the SRDF that belongs to a description of the robot of this name.

    None where there is none, or several, or where it is a link that leads out of the folder.
    """
    folder, own = path.parent, sidecar_place(path).with_suffix(_ENDING)
    found = [own] if own.is_file() else []
    if not found and robot:
        try:
            names = sorted(
                each.name for each in folder.iterdir() if each.suffix.lower() == _ENDING
            )[:_MOST_FILES]
        except OSError:
            return None
        found = [folder / name for name in names if _robot_of(folder / name) == robot]
    inside = [
        each
        for each in found
        if Path(os.path.realpath(each)).is_relative_to(os.path.realpath(folder))
    ]
    return inside[0] if len(inside) == 1 else None


def _robot_of(file: Path) -> str:
    try:
        return parse_plain(read_old_text(file, _MEGABYTES)[0], str(file)).get("name", "")
    except InputError:
        return ""


def _tips(robot: etree._Element, tree: UrdfTree) -> list[str]:
    """Return the parents of end effectors, then the tips of chains; where there is neither, the
    ends of groups that list their joints or links.
    """
    effectors = list(robot.iterchildren("end_effector"))
    hands = {each.get("group") for each in effectors}
    groups = [each for each in robot.iterchildren("group") if each.get("name") not in hands]
    named = [each.get("parent_link", "") for each in effectors] + [
        chain.get("tip_link", "") for each in groups for chain in each.iterchildren("chain")
    ]
    return named or [end for each in groups if (end := _end(each, tree))]


def _end(group: etree._Element, tree: UrdfTree) -> str:
    """Return the last link of a group whose joints or links lie on one way; empty for any other."""
    joints = [tree.joints.get(each.get("name", "")) for each in group.iterchildren("joint")]
    links = [joint.child for joint in joints if joint is not None] + [
        each.get("name", "") for each in group.iterchildren("link")
    ]
    ways = {
        link: {joint.name for joint in tree.path_to(link) or []}
        for link in links
        if link in tree.links
    }
    last = max(ways, key=lambda link: len(ways[link]), default="")
    return last if last and all(way <= ways[last] for way in ways.values()) else ""
