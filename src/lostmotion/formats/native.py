"""The native format: an arm as TOML, units in the text, parts by name where several joints share them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from lostmotion.arm import Arm
from lostmotion.errors import shown
from lostmotion.formats.dh import DH_EXAMPLES, place_by_rows
from lostmotion.formats.draft import SHARED_EXAMPLES, Draft, plain
from lostmotion.formats.text import refuse
from lostmotion.formats.toml import read_toml
from lostmotion.parts.joint import FixedJoint, PrismaticJoint, RevoluteJoint

if TYPE_CHECKING:
    from pathlib import Path

    from pydantic import BaseModel

_JOINT_EXAMPLE = '[[joints]] with name = "A", type = "revolute", limits = ["-90 deg", "90 deg"]'
_ALSO: Final[dict[type[BaseModel], dict[str, str]]] = {
    Arm: SHARED_EXAMPLES,
    **dict.fromkeys((RevoluteJoint, PrismaticJoint, FixedJoint), DH_EXAMPLES),
}
# Stands where no joints can be read, so that the rest of the file is still checked.
_STAND_IN = {"name": "A", "type": "revolute", "limits": ["-90 deg", "90 deg"]}


def read_arm(path: Path, sidecar: Path | None = None) -> Arm:
    """Which arm does this TOML file describe? Keys are Arm's fields, and tables of parts that joints share by name (`draft.SHARED`).

    A joint may carry a row of Denavit-Hartenberg values (`dh`, `mdh`) in place of origin and axis. Raises InputError with every mistake found, each
    under the key as the user wrote it.
    """
    if sidecar is not None:
        refuse(str(sidecar), "", f"a sidecar for {path.name}", "a sidecar beside a URDF only; a TOML arm says everything itself", "arm.urdf")
    return arm_of(str(path), read_toml(path))


def arm_of(file: str, tree: dict[str, Any]) -> Arm:
    """Which arm does this tree describe? `file` is named in the mistakes; the tree is used up."""
    draft = Draft(file, tree, _ALSO)
    _check_joints(draft)
    place_by_rows(draft)
    return draft.arm()


def _check_joints(draft: Draft) -> None:
    """Name joints in keys as the user does, and note what the model could not say as well."""
    joints = draft.tree.get("joints")
    if "joints" in draft.tree and not isinstance(joints, list):
        expected = "a list of joints"
        if isinstance(joints, dict):
            expected += "; a table of joints by name is the sidecar of a URDF: read the .urdf itself"
        draft.refuse(("joints",), shown(joints), expected, _JOINT_EXAMPLE)
        draft.tree["joints"] = [_STAND_IN]
    _check_names(draft)


def _check_names(draft: Draft) -> None:
    names = [joint.get("name") for _, joint in draft.joints]
    for position, (index, joint) in enumerate(draft.joints):
        name = names[position]
        if not isinstance(name, str):
            continue
        if names.count(name) == 1:
            draft.written["joints", index] = f"joints.{plain(name)}"
        elif name in names[:position]:
            draft.refuse(
                ("joints", index, "name"), f"the name '{plain(name)}' once more", "a name of its own for every joint", f'name = "{plain(name)}2"'
            )
            joint["name"] = f"again {index}"
