"""Lines of TOML that describe the error sources of an arm by example values, with the name of every joint: a start for who has only its shape."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from lostmotion.io.sidecar import find_sidecar, sidecar_place
from lostmotion.io.toml import key_step, quoted, read_toml
from lostmotion.parts.joint import PrismaticJoint

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.joint import RevoluteJoint

_SOURCE: Final = 'source = "example values, to be replaced"'
# By kind of motion, then by table: the keys of an example part.
_EXAMPLES: Final[dict[str, dict[str, dict[str, str]]]] = {
    "turning": {
        "gearboxes": {
            "ratio": "100",
            "stiffness": '"20 N m/arcmin"',
            "backlash": '"1 arcmin ± 0.3 arcmin"',
            "hysteresis": '"0.5 arcmin"',
            "transmission_error": '"1 arcmin"',
        },
        "bearings": {"kind": '"crossed roller"', "moment_stiffness": '"200e3 N m/rad"'},
        "encoders": {"side": '"motor"', "resolution": '"5 arcmin"', "zero": '"0.3 arcmin"', "ratio": "100"},
    },
    "sliding": {
        "gearboxes": {"stiffness": '"100 N/µm"', "backlash": '"20 µm ± 5 µm"', "hysteresis": '"5 µm"'},
        "bearings": {"kind": '"crossed roller"', "moment_stiffness": '"200e3 N m/rad"'},
        "encoders": {"side": '"motor"', "resolution": '"1 µm"', "zero": '"20 µm"'},
    },
}
_KEYS: Final = {"gearboxes": "gearbox", "bearings": "bearing", "encoders": "encoder"}
_NO_VALUES: Final = ("kind", "side")


@dataclass(frozen=True, slots=True)
class Skeleton:
    """Lines to add to a file: its name, and the text."""

    file: str
    text: str


def skeleton(arm: Arm, path: Path, sidecar: Path | None = None) -> Skeleton:
    """Return lines that describe the parts of every moving joint by example values, for the file that the arm was read from.

    For a URDF they are its sidecar, or are added to it; for a TOML they are added to it, each joint's lines where a comment says. Every value is
    marked as assumed. The reader accepts them as they are. Raises InputError for a file that can no longer be read.
    """
    urdf = path.suffix.lower() != ".toml"
    source = (sidecar or find_sidecar(path)) if urdf else path
    tree = {} if source is None else read_toml(source)
    names = _free_names(tree)
    lines = [
        "# Example values: replace them by those of your parts, each then taken out of its list `assumed`.",
        "# Joints need not share parts. Omit what is not known: it counts as ideal, and the result lists it.",
    ]
    for kind, tables in _EXAMPLES.items():
        if any(_kind(joint) == kind for joint in arm.moving):
            for table, keys in tables.items():
                lines += _part(table, names[table, kind], keys)
    there = tree.get("joints", {})
    for joint in arm.moving:
        lines += _joint(joint, names, there if isinstance(there, dict) else {}, urdf=urdf)
    return Skeleton((source or (sidecar_place(path) if urdf else path)).name, "\n".join(lines) + "\n")


def _kind(joint: RevoluteJoint | PrismaticJoint) -> str:
    return "sliding" if isinstance(joint, PrismaticJoint) else "turning"


def _free_names(tree: dict[str, Any]) -> dict[tuple[str, str], str]:
    """Return a name for each example part that the file does not use yet."""
    out = {}
    for kind, tables in _EXAMPLES.items():
        for table in tables:
            stock = tree.get(table)
            taken = stock if isinstance(stock, dict) else {}
            name = f"{kind}_example"
            while name in taken:
                name += "_"
            out[table, kind] = name
    return out


def _part(table: str, name: str, keys: dict[str, str]) -> list[str]:
    assumed = ", ".join(f'"{key}"' for key in keys if key not in _NO_VALUES)
    return ["", f"[{table}.{name}]", *(f"{key} = {value}" for key, value in keys.items()), f"assumed = [{assumed}]", _SOURCE]


def _joint(joint: RevoluteJoint | PrismaticJoint, names: dict[tuple[str, str], str], there: dict[str, Any], *, urdf: bool) -> list[str]:
    """Return the lines of one joint: its table in a sidecar, else the lines for the table that it has."""
    kind, name = _kind(joint), quoted(joint.name)
    parts = [f'{key} = "{names[table, kind]}"' for table, key in _KEYS.items() if getattr(joint, key) is None]
    silent = [key for key in _KEYS.values() if getattr(joint, key) is not None]
    parts += [f"# its {', its '.join(silent)}: described without errors; add them there"] if silent else []
    if urdf and joint.name not in there:
        return ["", f"[joints.{key_step(joint.name)}]", *parts]
    where = f"[joints.{name}]" if urdf else f"[[joints]] with name = {name}"
    return ["", f"# In {where}:", *(f"# {line.removeprefix('# ')}" for line in parts)]
