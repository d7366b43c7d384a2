"""Lines of TOML that describe the drives of an arm by their class, with the name of every joint: a
start for who has only its shape.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from lostmotion.catalogue.drive_classes import drive_classes
from lostmotion.io.drive_classes import DRIVE, DRIVES, LOAD_KEYS
from lostmotion.io.drive_loads import load_text
from lostmotion.io.sidecar import find_sidecar, sidecar_place
from lostmotion.io.toml import key_step, quoted, read_toml

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.io.drive_loads import DriveLoads
    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.joint import PrismaticJoint, RevoluteJoint


@dataclass(frozen=True, slots=True)
class Skeleton:
    """Lines to add to a file: its name, and the text."""

    file: str
    text: str


def skeleton(arm: Arm, path: Path, drives: DriveLoads, sidecar: Path | None = None) -> Skeleton:
    """Return lines that describe the drive of every moving joint by its class and load, for the
    file that the arm was read from.

    For a URDF they are its sidecar, or are added to it; for a TOML they are added to it, each
    joint's lines where a comment says. Every value that follows from them counts as assumed. The
    reader accepts them as they are. Raises InputError for a file that can no longer be read.
    """
    urdf = path.suffix.lower() != ".toml"
    source = (sidecar or find_sidecar(path)) if urdf else path
    tree = {} if source is None else read_toml(source)
    lines = [
        (
            "# Assumed from the class of the drives and the load of each: gearbox, bearing, "
            "encoder, servo, mounting and link."
        ),
        "# What you state in a joint takes precedence.",
        *_of_arm(f"{DRIVES} = {quoted(drives.of.name)}", tree),
    ]
    there = tree.get("joints", {})
    for joint in arm.driven:
        lines += _joint(
            joint, drives.loads[joint.name], there if isinstance(there, dict) else {}, urdf=urdf
        )
    return Skeleton(
        (source or (sidecar_place(path) if urdf else path)).name, "\n".join(lines) + "\n"
    )


def _of_arm(line: str, tree: dict[str, Any]) -> list[str]:
    """Return the lines that choose the class of all drives; a comment where the file has presets
    already.
    """
    classes = f"# one of {', '.join(drive_classes())}"
    return (
        ["", "# In [presets]:", classes, f"# {line}"]
        if "presets" in tree
        else ["", "[presets]", classes, line]
    )


def _joint(
    joint: RevoluteJoint | PrismaticJoint, load: float, there: dict[str, Any], *, urdf: bool
) -> list[str]:
    """Return the lines of one joint: its table in a sidecar, else the lines for the table that it
    has.
    """
    name = quoted(joint.name)
    lines = [f'{DRIVE} = {{ {LOAD_KEYS[joint.type]} = "{load_text(load, joint.load_unit)}" }}']
    silent = [
        part for part in ("gearbox", "bearing", "encoder") if getattr(joint, part) is not None
    ]
    lines += (
        [f"# its {', its '.join(silent)}: described without errors; add them there"]
        if silent
        else []
    )
    if urdf and joint.name not in there:
        return ["", f"[joints.{key_step(joint.name)}]", *lines]
    where = f"[joints.{name}]" if urdf else f"[[joints]] with name = {name}"
    return ["", f"# In {where}:", *(f"# {line.removeprefix('# ')}" for line in lines)]
