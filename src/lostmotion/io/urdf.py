"""URDF as an arm: the chain from the root link to one tip, with limits and masses; whatever URDF
cannot say comes from a sidecar TOML.

Each URDF joint gives one joint here. Its origin's rotation stays with it; its origin's translation
becomes the tip of the link before, so that the link is the beam between two joints (the first joint
keeps its whole origin). The root link stands on the ground, its mass weighs on nothing. Bodies
beside the chain are carried by the link they hang on, exactly where they are rigidly fixed, else at
their zero position.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lostmotion.errors import InputError
from lostmotion.io import mjcf, sdf, sdf_xml
from lostmotion.io.arm_builder import SHARED_EXAMPLES, build_arm
from lostmotion.io.dh import rpy_of
from lostmotion.io.draft import Draft
from lostmotion.io.limits import cut, listed, refuse_all
from lostmotion.io.project_root import take_root
from lostmotion.io.repairs import note_repairs, take_limits
from lostmotion.io.sidecar import add_sidecar, find_sidecar, sidecar_place
from lostmotion.io.srdf import add_tips
from lostmotion.io.text import read_old_text
from lostmotion.io.toml import key_step, read_toml
from lostmotion.io.urdf_chain import find_chain
from lostmotion.io.urdf_checks import with_warnings
from lostmotion.io.urdf_elements import read_tree
from lostmotion.io.urdf_loops import LoopsOfTree
from lostmotion.io.urdf_xml import root_of
from lostmotion.io.xacro_file import ENDING as XACRO
from lostmotion.io.xacro_file import expand, has_macros, take_arguments
from lostmotion.mechanism.arm import LONGEST_NAME, LONGEST_NOTE, MOST_NOTES, Arm
from lostmotion.parts.link import Frame
from lostmotion.spatial import pose_of, shift, turn

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

    from pydantic import BaseModel

    from lostmotion.errors import Problem
    from lostmotion.io.urdf_chain import Chain
    from lostmotion.io.urdf_tree import UrdfJoint, UrdfTree

MEGABYTES: Final = 5
_ALSO: Final[dict[type[BaseModel], dict[str, str]]] = {
    Arm: {"tip": 'tip = "tool0"', **SHARED_EXAMPLES}
}
_LIMITED: Final = ("revolute", "prismatic")
# What is found where an empty argument stands in a number or a name.
_MISSING: Final = ("''", "no name")
_LEVEL: Final = 1e-12  # rad; less is rounding


def read_arm(path: Path, sidecar: Path | None = None) -> Arm:
    """Return the arm that a URDF and its sidecar describe.

    A sidecar that is not given is NAME.toml beside NAME.urdf, where there is one. Joints may be
    revolute, continuous (taken as +-180 degrees, with a note), prismatic and fixed. Raises
    InputError with every mistake found, each with its line and element.
    """
    sidecar = sidecar or find_sidecar(path)
    return arm_of(path, sidecar, {} if sidecar is None else read_toml(sidecar))


def arm_of(path: Path, sidecar: Path | None, content: dict[str, Any]) -> Arm:
    """Return the arm that a URDF and the content of its sidecar describe. `content` is consumed;
    its mistakes name the file `sidecar`.
    """
    tree = tree_of(path, sidecar, content)
    take_limits(tree, content)
    chain = find_chain(tree, content, str(sidecar or path), sidecar_place(path).name)
    _stand_as_in_the_file(tree, chain, content)
    loops = LoopsOfTree(tree, chain, content)
    if loops.mistakes:
        refuse_all(loops.mistakes)
    made = _arm_tree(tree, chain, path.stem, loops)
    loops.add_to(made["joints"], content)
    draft = Draft(str(sidecar or path), made, _ALSO)
    draft.written.update(
        {
            ("joints", index): f"joints.{key_step(entry['name'])}"
            for index, entry in enumerate(made["joints"])
        }
    )
    note_repairs(draft, content, tree)
    add_sidecar(draft, content, tree.joints)
    arm = build_arm(draft)
    return with_warnings(arm, tree, chain)


def tree_of(path: Path, sidecar: Path | None, content: dict[str, Any]) -> UrdfTree:
    """Return the links and joints of a URDF, of the one that a xacro file makes, or of an MJCF or
    SDF file.

    Arguments of xacro, and the folder of the project, are taken out of the sidecar's `content`. A
    URDF has no use for them, but shares its sidecar with the xacro file that made it.
    """
    text, line = read_old_text(path, MEGABYTES)
    arguments, root = (
        take_arguments(content, str(sidecar or path)),
        take_root(content, sidecar, path),
    )
    kind = root_of(text)
    if kind == mjcf.ROOT:
        return mjcf.read_tree(path, text, root)
    if kind == sdf_xml.ROOT:
        return sdf.read_tree(path, text, root)
    if has_macros(path, text):
        beside = str(sidecar or sidecar_place(path))
        text, empty = expand(path, arguments, beside, root)
        try:
            tree = read_tree(text, str(path), has_lines=False)
        except InputError as error:
            raise InputError(_naming(empty, error.problems, beside)) from None
        tree.mistakes = _naming(empty, tree.mistakes, beside)
        for joint in tree.joints.values():
            joint.limit_mistakes = _naming(empty, joint.limit_mistakes, beside)
            joint.other_mistakes = _naming(empty, joint.other_mistakes, beside)
        add_tips(tree, path)
        return tree
    tree = read_tree(text, str(path))
    add_tips(tree, path)
    if line:
        tree.notes.append(f"line {line}: not UTF-8; the file is read as Latin-1")
    return tree


def _naming(empty: list[str], problems: Iterable[Problem], sidecar: str) -> list[Problem]:
    """Return mistakes with the empty arguments of xacro, where a value that is missing may come
    from one.
    """
    words = f"; empty: the argument {listed(empty)}, whose value stands in [xacro] of {sidecar}"
    return [
        replace(each, expected=each.expected + words) if empty and each.found in _MISSING else each
        for each in problems
    ]


def effort_limits(path: Path, sidecar: Path | None = None) -> dict[str, float]:
    """Return the effort limits of a robot file by joint, N m or N, as stated; 0 where none is. Many
    files state placeholders.
    """
    sidecar = sidecar or find_sidecar(path)
    tree = tree_of(path, sidecar, {} if sidecar is None else read_toml(sidecar))
    return {name: joint.effort for name, joint in tree.joints.items()}


def self_contained(
    path: Path, text: str, content: dict[str, Any], sidecar: Path | None
) -> tuple[str, str]:
    """Return the ending and the text of one file that describes the same arm: a URDF, MJCF or SDF.
    `content` is that of the sidecar.

    Raises InputError where the masses of an MJCF file follow from meshes, which are no text.
    """
    root = take_root(content, sidecar, path)
    kind = root_of(text)
    if kind == mjcf.ROOT:
        return ".xml", mjcf.self_contained_text(path, text, root)
    if kind == sdf_xml.ROOT:
        return ".sdf", sdf_xml.self_contained_text(path, text, root)
    if has_macros(path, text):
        return ".urdf", expand(
            path,
            take_arguments(content, str(sidecar or path)),
            str(sidecar or sidecar_place(path)),
            root,
        )[0]
    return ".urdf" if path.suffix.lower() == XACRO else path.suffix.lower(), text


def urdf_text(path: Path, sidecar: Path | None = None) -> tuple[str | None, Path]:
    """Return the text of a URDF, or of the one that a xacro file makes with the arguments of its
    sidecar, None for an MJCF or SDF file; and its project.
    """
    sidecar = sidecar or find_sidecar(path)
    content = {} if sidecar is None else read_toml(sidecar)
    text, _ = read_old_text(path, MEGABYTES)
    root = take_root(dict(content), sidecar, path)
    if root_of(text) in (mjcf.ROOT, sdf_xml.ROOT):
        return None, root
    return self_contained(path, text, content, sidecar)[1], root


def _arm_tree(tree: UrdfTree, chain: Chain, name: str, loops: LoopsOfTree) -> dict[str, Any]:
    """Return the chain as a tree with Arm's fields; numbers carry their SI units as in a file."""
    notes = [*chain.notes, *tree.notes]
    joints = []
    rows = [chain.joints, *loops.branches]
    own = {joint.name for row in rows for joint in row}
    weighs = any(tree.links[joint.child].mass for row in rows for joint in row)
    for joint, before, after in _in_rows(rows):
        link: dict[str, Any] = {"tip": Frame(xyz=after.xyz) if after else Frame()}
        mass, centre, held = _carried(tree, joint.child, own)
        if mass:
            link |= {"mass": f"{mass!r} kg", "centre_of_mass": [f"{x!r} m" for x in centre]}
        notes += _notes_of_fixed_joints(
            tree, joint.child, held, {each.name for row in rows for each in row if each.moves}
        )
        entry: dict[str, Any] = {
            "name": joint.name,
            "origin": _origin(joint, first=before is None),
            "link": link,
        }
        if weighs:
            entry["mass"] = "0 kg"  # a URDF's inertials weigh whole bodies, drives included
        joints.append(entry | loops.attached(joint, before) | _motion(joint) | loops.moved(joint))
        if joint.type == "continuous" and joint.name not in loops.passive:
            notes.append(
                f"joint '{joint.name}' turns without end; it is studied from -180 to 180 degrees"
            )
    notes = [cut(note, LONGEST_NOTE) for note in notes][:MOST_NOTES]
    return {"name": cut(tree.name or name, LONGEST_NAME) or "arm", "joints": joints, "notes": notes}


def _in_rows(
    rows: list[list[UrdfJoint]],
) -> Iterator[tuple[UrdfJoint, UrdfJoint | None, UrdfJoint | None]]:
    """Yield each joint with those before and after it in its row."""
    for row in rows:
        yield from zip(row, [None, *row[:-1]], [*row[1:], None], strict=True)


def _origin(joint: UrdfJoint, *, first: bool) -> Frame:
    """Return the place of a joint behind the tip of the link before; a joint that cannot move
    stands where its limits say.
    """
    xyz = joint.xyz if first else (0.0, 0.0, 0.0)
    if not joint.locked or not joint.limits[0]:
        return Frame(xyz=xyz, rpy=joint.rpy)
    axis = np.array(joint.axis) / math.hypot(*joint.axis)
    seat = pose_of(xyz, joint.rpy)
    pose = seat @ (
        shift(*(axis * joint.limits[0]))
        if joint.type == "prismatic"
        else turn(tuple(axis), joint.limits[0])
    )
    x, y, z = pose[:3, 3].tolist()
    return Frame(xyz=(x, y, z), rpy=rpy_of(pose[:3, :3]))


def _motion(joint: UrdfJoint) -> dict[str, Any]:
    if joint.type == "ball":
        cone = {"cone": f"{joint.limits[1]!r} rad", "axis": joint.axis} if joint.limits[1] else {}
        return {"type": "spherical", **cone}
    if joint.is_held_by_loops:
        return {"type": "free"}
    if not joint.moves:
        return {"type": "fixed"}
    low, high = (-math.pi, math.pi) if joint.type == "continuous" else joint.limits
    unit = "m" if joint.type == "prismatic" else "rad"
    return {
        "type": "prismatic" if joint.type == "prismatic" else "revolute",
        "axis": joint.axis,
        "limits": [f"{low!r} {unit}", f"{high!r} {unit}"],
    }


def _stand_as_in_the_file(tree: UrdfTree, chain: Chain, content: dict[str, Any]) -> None:
    """Tilt a base that is not the root as the joints before it do at zero, unless the sidecar says
    how it is tilted.
    """
    pose = pose_of()
    for joint in chain.before:
        pose = pose @ pose_of(joint.xyz, joint.rpy)
    roll, pitch, _ = rpy_of(pose[:3, :3])
    stated = content.setdefault("base", {}) if chain.before else None
    if (
        isinstance(stated, dict)
        and not {"roll", "pitch"} & stated.keys()
        and max(abs(roll), abs(pitch)) > _LEVEL
    ):
        stated |= {"roll": f"{roll!r} rad", "pitch": f"{pitch!r} rad"}
        tree.notes.append(
            f"the base is tilted as in the {tree.format}: roll {math.degrees(roll):.4g} deg, "
            f"pitch {math.degrees(pitch):.4g} deg"
        )


def _carried(
    tree: UrdfTree, link: str, own: set[str]
) -> tuple[float, tuple[float, float, float], list[UrdfJoint]]:
    """Return mass (kg) and centre (m, link's frame) of a link with everything that it carries
    beside the arm's own joints, and the joints held at zero.
    """
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
            if joint.name not in own:
                waiting.append((joint.child, pose @ pose_of(joint.xyz, joint.rpy)))
                if joint.type != "fixed":
                    held.append(joint)
    if not mass:
        return 0.0, (0.0, 0.0, 0.0), held
    x, y, z = (m / mass for m in moment)
    return mass, (x, y, z), held


def _notes_of_fixed_joints(
    tree: UrdfTree, link: str, held: list[UrdfJoint], moving: set[str]
) -> list[str]:
    """Return notes on the joints of a link that are not joints of the arm: the mass they carry,
    what they follow, suspicious limits or mistakes.

    `moving` are the names of the arm's own joints that move.
    """
    if not held:
        return []
    weight = math.fsum(
        tree.links[name].mass
        for name in {name for joint in held for name in _beyond(tree, joint.child)}
    )
    several = f"{len(held)} joints" if len(held) > 1 else "1 joint"
    out = [
        (
            f"not taken: {listed([joint.name for joint in held])} ({several} on link '{link}', "
            f"held at zero, {weight:.3g} kg carried)"
        )
    ]
    following = [
        f"{joint.name} (follows {joint.leader})" for joint in held if joint.leader in moving
    ]
    if following:
        out.append(
            f"held at zero, but moving with the arm in the {tree.format}: {listed(following)}; "
            "their weight is taken where it hangs at zero"
        )
    odd = [
        joint.name
        for joint in held
        if joint.type in _LIMITED
        and not joint.mistakes
        and not joint.limits[0] <= 0 <= joint.limits[1]
    ]
    if odd:
        out.append(
            f"held at zero, outside their limits: {listed(odd)}; their weight hangs where it "
            "cannot stand"
        )
    wrong = [f"{joint.name}: {joint.mistakes[0].found}" for joint in held if joint.mistakes]
    if wrong:
        out.append(
            f"wrong in the {tree.format}, and without effect beside the chain, where they are "
            f"held at zero: {listed(wrong)}"
        )
    return out


def _beyond(tree: UrdfTree, link: str) -> list[str]:
    out = [link]
    for name in out:
        out += [joint.child for joint in tree.children(name)]
    return out
