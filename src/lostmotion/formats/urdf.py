"""URDF as an arm: the chain from the root link to one tip, with limits and masses; whatever URDF cannot say comes from a sidecar TOML.

Each URDF joint gives one joint here. Its origin's rotation stays with it; its origin's translation becomes the tip of the link before, so that
the link is the beam between two joints (the first joint keeps its whole origin). The root link stands on the ground, its mass weighs on
nothing. Bodies beside the chain are carried by the link they hang on, exactly where they are rigidly fixed, else at their zero position.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

from lostmotion.arm import LONGEST_NAME, LONGEST_NOTE, MOST_JOINTS, Arm
from lostmotion.errors import shown
from lostmotion.formats.bounds import cut, listed, nearest, refuse_all
from lostmotion.formats.draft import SHARED_EXAMPLES, Draft
from lostmotion.formats.sidecar import add_sidecar, find_sidecar
from lostmotion.formats.text import read_text, refuse
from lostmotion.formats.toml import read_toml
from lostmotion.formats.urdf_tree import read_tree
from lostmotion.parts.link import Place
from lostmotion.spatial import pose_of

if TYPE_CHECKING:
    from pathlib import Path

    from pydantic import BaseModel

    from lostmotion.formats.urdf_tree import UrdfJoint, UrdfTree

MEGABYTES: Final = 5
_ALSO: Final[dict[type[BaseModel], dict[str, str]]] = {Arm: {"tip": 'tip = "tool0"', **SHARED_EXAMPLES}}
_NOT_SERIAL: Final = ("floating", "planar")


def read_arm(path: Path, sidecar: Path | None = None) -> Arm:
    """Which arm do this URDF and its sidecar describe?

    A sidecar that is not given is NAME.toml beside NAME.urdf, where there is one. Joints may be revolute, continuous (taken as +-180 degrees, with
    a note), prismatic and fixed. Raises InputError with every mistake found, each with its line and element.
    """
    sidecar = sidecar or find_sidecar(path)
    return arm_of(path, sidecar, {} if sidecar is None else read_toml(sidecar))


def arm_of(path: Path, sidecar: Path | None, said: dict[str, Any]) -> Arm:
    """Which arm do this URDF and what its sidecar says describe? The tree `said` is used up; mistakes in it are told of the file `sidecar`."""
    tree = read_tree(read_text(path, MEGABYTES), str(path))
    chain = _chain(tree, said.pop("tip", None), str(sidecar or path), path.with_suffix(".toml").name)
    draft = Draft(str(sidecar or path), _arm_tree(tree, chain, path.stem), _ALSO)
    draft.written.update({("joints", index): f"joints.{joint.name}" for index, joint in enumerate(chain)})
    add_sidecar(draft, said, tree.joints)
    return draft.arm()


def _chain(tree: UrdfTree, tip: object, sidecar: str, sidecar_name: str) -> list[UrdfJoint]:
    """Which joints lead from the root to the tip?"""
    if tip is None:
        tips = tree.moving_leaves()
        if not tips:
            refuse(
                tree.file,
                "/robot",
                "no joint that moves",
                "a chain with at least one revolute, continuous or prismatic joint",
                '<joint name="A" type="revolute">',
            )
        if len(tips) > 1:
            refuse(
                tree.file,
                "/robot",
                f"{len(tips)} links where the arm could end: {listed(tips)}",
                f"the one that is the tool, named in {sidecar_name}",
                f'tip = "{tips[-1]}"',
            )
        tip = tips[0]
    if not isinstance(tip, str) or tip not in tree.links:
        near = nearest(str(tip), tree.links)
        refuse(sidecar, "tip", shown(tip), f"the name of a link of {tree.file}", f'tip = "{near or tree.leaves()[-1]}"', near)
    chain = tree.path_to(tip)
    for joint in chain:
        if joint.type in _NOT_SERIAL or joint.mimic:
            found = "a joint that mimics another" if joint.mimic else f"a {joint.type} joint"
            tree.refuse(joint.line, joint.path, found, "revolute, continuous, prismatic or fixed joints between root and tip", 'type="revolute"')
    if len(chain) > MOST_JOINTS:
        tree.refuse(chain[0].line, "/robot", f"{len(chain)} joints between root and tip", f"at most {MOST_JOINTS}", f'tip = "{chain[6].child}"')
    if not any(joint.moves for joint in chain):
        tree.refuse(0, "/robot", f"no joint that moves before the tip '{tip}'", "a tip behind at least one moving joint", 'tip = "tool0"')
    if tree.mistakes:
        refuse_all(tree.mistakes)
    return chain


def _arm_tree(tree: UrdfTree, chain: list[UrdfJoint], name: str) -> dict[str, Any]:
    """Give the chain as a tree with Arm's fields; numbers carry their SI units as in a file."""
    notes = []
    joints = []
    for index, joint in enumerate(chain):
        after = chain[index + 1] if index + 1 < len(chain) else None
        link: dict[str, Any] = {"tip": Place(xyz=after.xyz) if after else Place()}
        mass, centre, moving = _carried(tree, joint.child, after)
        if mass:
            link |= {"mass": f"{mass!r} kg", "centre_of_mass": [f"{x!r} m" for x in centre]}
        if moving:
            notes.append(cut(f"what hangs on link '{joint.child}' behind {listed(moving)} is carried at its zero position", LONGEST_NOTE))
        entry = {"name": joint.name, "origin": Place(xyz=joint.xyz if index == 0 else (0.0, 0.0, 0.0), rpy=joint.rpy), "link": link}
        joints.append(entry | _motion(joint))
        if joint.type == "continuous":
            notes.append(f"joint '{joint.name}' turns without end; it is studied from -180 to 180 degrees")
    return {"name": cut(tree.name or name, LONGEST_NAME) or "arm", "joints": joints, "notes": notes}


def _motion(joint: UrdfJoint) -> dict[str, Any]:
    if joint.type == "fixed":
        return {"type": "fixed"}
    low, high = (-math.pi, math.pi) if joint.type == "continuous" else joint.limits
    unit = "m" if joint.type == "prismatic" else "rad"
    return {"type": "prismatic" if joint.type == "prismatic" else "revolute", "axis": joint.axis, "limits": [f"{low!r} {unit}", f"{high!r} {unit}"]}


def _carried(tree: UrdfTree, link: str, after: UrdfJoint | None) -> tuple[float, tuple[float, float, float], list[str]]:
    """What do a link and all that hangs on it beside the chain weigh (kg), where is the common centre (m, link's frame), which joints were held?"""
    mass, moment = 0.0, [0.0, 0.0, 0.0]
    held = []
    waiting = [(link, pose_of())]
    while waiting:
        name, pose = waiting.pop()
        body = tree.links[name]
        centre = pose[:3, :3] @ body.centre + pose[:3, 3]
        mass += body.mass
        moment = [m + body.mass * float(c) for m, c in zip(moment, centre, strict=True)]
        for joint in tree.children(name):
            if joint is not after:
                waiting.append((joint.child, pose @ pose_of(joint.xyz, joint.rpy)))
                if joint.type != "fixed":
                    held.append(joint.name)
    if not mass:
        return 0.0, (0.0, 0.0, 0.0), held
    x, y, z = (m / mass for m in moment)
    return mass, (x, y, z), held
