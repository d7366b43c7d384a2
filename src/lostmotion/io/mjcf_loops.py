"""Equality constraints of MJCF: loops that `connect` and `weld` close, and joints that follow."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from lostmotion.io.text import refuse
from lostmotion.io.urdf_tree import MOST_ELEMENTS, UrdfLoop, UrdfTree, is_name
from lostmotion.spatial import pose_by_quaternion

if TYPE_CHECKING:
    from lostmotion.spatial import Floats


def add_equalities(
    tree: UrdfTree,
    model: dict[str, Any],
    joints: list[str],
    carriers: list[str],
    anchors: list[Floats],
) -> None:
    """Mark the joints that equality constraints couple, which `find_chain` refuses by name on the
    chain, and add the loops that such constraints close.

    joints, carriers, anchors  names of the joints, and of each body the link that has its mass, and
                               the place of that in its frame
    """
    if len(model["eq_type"]) > MOST_ELEMENTS:  # each closes a loop through all joints
        found = f"{len(model['eq_type'])} elements in <equality>"
        refuse(tree.file, tree.root, found, f"at most {MOST_ELEMENTS}", "one arm per file")
    for k, kind in enumerate(model["eq_type"]):
        first, second = model["eq_obj1id"][k], model["eq_obj2id"][k]
        title = f"equality '{model['equality'][k]}'" if model["equality"][k] else "an equality"
        if not model["eq_active0"][k]:
            continue
        if kind == "joint":
            joint = tree.joints[joints[first]]
            joint.leader = joints[second] if second >= 0 else "a constant"
            joint.coupling = f"{title}, x {model['eq_data'][k][1]:.4g}"
        elif kind in {"connect", "weld"}:
            ends = [
                end if model["eq_objtype"][k] == "body" else model["site_bodyid"][end]
                for end in (first, second)
            ]
            if any(model["body_mocapid"][end] >= 0 for end in ends):
                tree.notes.append(
                    f"not carried over: {title}, which ties a body to one that a person moves "
                    "(mocap)"
                )
                continue
            one, other = (
                pose_by_quaternion(-anchors[body]) @ frame
                for body, frame in zip(ends, _frames(model, k), strict=True)
            )
            # a weld whose rotation has no weight holds a point
            turns = kind == "connect" or not model["eq_data"][k][10]
            name = model["equality"][k]
            name = name if name and is_name(name) else "loop"
            links = (carriers[ends[0]], carriers[ends[1]])
            tree.loops.append(UrdfLoop(name, links, (one, other), turns))


def _frames(model: dict[str, Any], k: int) -> list[Floats]:
    """Return the frames (4, 4) of a constraint in its two bodies."""
    data = model["eq_data"][k]
    if model["eq_objtype"][k] != "body":
        sites = (model["eq_obj1id"][k], model["eq_obj2id"][k])
        return [pose_by_quaternion(model["site_pos"][at], model["site_quat"][at]) for at in sites]
    if model["eq_type"][k] == "connect":
        return [pose_by_quaternion(data[:3]), pose_by_quaternion(data[3:6])]
    return [pose_by_quaternion(data[3:6], data[6:10]), pose_by_quaternion(data[:3])]
