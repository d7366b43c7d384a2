"""The native format: an arm as TOML, units in the text, parts by name where several joints share
them.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from lostmotion.errors import shown
from lostmotion.io.arm_builder import SHARED_EXAMPLES, SWEEP, build_arm
from lostmotion.io.dh import DH_EXAMPLES, place_by_rows
from lostmotion.io.draft import Draft, plain
from lostmotion.io.legs import EXAMPLE, LEGS, expand_legs
from lostmotion.io.limits import listed
from lostmotion.io.text import refuse
from lostmotion.io.toml import key_step, quoted, read_toml
from lostmotion.mechanism.arm import MOST_JOINTS, Arm
from lostmotion.parts.joint import FixedJoint, PrismaticJoint, RevoluteJoint

if TYPE_CHECKING:
    from pydantic import BaseModel

_JOINT_EXAMPLE = '[[joints]] with name = "A", type = "revolute", limits = ["-90 deg", "90 deg"]'
_ALSO: Final[dict[type[BaseModel], dict[str, str]]] = {
    Arm: {**SHARED_EXAMPLES, LEGS: EXAMPLE},
    **dict.fromkeys((RevoluteJoint, PrismaticJoint, FixedJoint), DH_EXAMPLES),
}
# Tables of requests that a file of their own may hold, and the command that reads it.
_REQUESTS: Final = {"sizing": "size", SWEEP: "sweep"}
# Stands where no joints can be read, so that the rest of the file is still checked.
_STAND_IN = {"name": "A", "type": "revolute", "limits": ["-90 deg", "90 deg"]}


def read_arm(path: Path, sidecar: Path | None = None) -> Arm:
    """Return the arm that a TOML file describes. Keys are Arm's fields, and tables of parts that
    joints share by name (`draft.SHARED`).

    A joint may carry a row of Denavit-Hartenberg values (`dh`, `mdh`) in place of origin and axis.
    Raises InputError with every mistake found, each under the key as the user wrote it.
    """
    refuse_sidecar(path.name, sidecar)
    return arm_of(str(path), read_toml(path))


def refuse_sidecar(arm: str, sidecar: Path | None) -> None:
    """Raise InputError for a sidecar: a TOML arm, or a dictionary, states everything itself."""
    if sidecar is not None:
        refuse(
            str(sidecar),
            "",
            f"a sidecar for {arm}",
            "a sidecar beside a URDF only; a TOML arm says everything itself",
            "arm.urdf",
        )


def arm_of(file: str, tree: dict[str, Any]) -> Arm:
    """Return the arm that a tree describes. `file` is named in the mistakes; the tree is used
    up.
    """
    draft = Draft(file, tree, _ALSO)
    expand_legs(draft)
    _check_joints(draft)
    place_by_rows(draft)
    return build_arm(draft)


def _check_joints(draft: Draft) -> None:
    """Name joints in keys as the user does, and note what the model could not say as well."""
    _refuse_request(draft)
    joints = draft.tree.get("joints")
    if _is_sidecar(draft.tree):
        expected = (
            "an arm with a list of joints; a table of joints by name, or a tip, is the sidecar of "
            "a URDF, which is read by naming the .urdf"
        )
        found = (
            f"joints by name: {listed(joints, plain)}"
            if isinstance(joints, dict)
            else "no joints, but a tip"
        )
        refuse(draft.file, "joints", found, expected, str(Path(draft.file).with_suffix(".urdf")))
    if "joints" in draft.tree and not isinstance(joints, list):
        draft.refuse(("joints",), shown(joints), "a list of joints", _JOINT_EXAMPLE)
        draft.tree["joints"] = [dict(_STAND_IN)]
    elif isinstance(joints, list) and len(joints) > MOST_JOINTS:
        draft.refuse(("joints",), f"{len(joints)} joints", f"at most {MOST_JOINTS}", _JOINT_EXAMPLE)
        draft.tree["joints"] = [dict(_STAND_IN)]
    _check_names(draft)


def _refuse_request(draft: Draft) -> None:
    """Refuse the request of another command that is given in place of an arm."""
    for key, command in _REQUESTS.items():
        if key in draft.tree and "joints" not in draft.tree:
            expected = (
                f"an arm with a list of joints; a file with [{key}] alone is read by `lostmotion "
                f"{command} ARM.toml --by FILE`"
            )
            refuse(
                draft.file,
                key,
                f"a [{key}] without an arm",
                expected,
                f"lostmotion {command} ARM.toml --by {Path(draft.file).name}",
            )


def _is_sidecar(tree: dict[str, Any]) -> bool:
    joints = tree.get("joints")
    if isinstance(joints, dict):
        return not any("type" in joint for joint in joints.values() if isinstance(joint, dict))
    return "tip" in tree and joints is None


def _check_names(draft: Draft) -> None:
    times = Counter(name for _, joint in draft.joints if isinstance(name := joint.get("name"), str))
    met = set()
    for index, joint in draft.joints:
        name = joint.get("name")
        if not isinstance(name, str):
            continue
        if times[name] == 1:
            draft.written["joints", index] = f"joints.{key_step(plain(name))}"
        elif name in met:
            draft.refuse(
                ("joints", index, "name"),
                f"the name '{plain(name)}' twice",
                "a name of its own for every joint",
                f"name = {quoted(f'{plain(name)[:70]}2')}",
            )
            joint["name"] = f"again {index}"
        met.add(name)
