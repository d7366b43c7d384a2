"""The sidecar of a URDF: a TOML, keyed by joint name, that says what URDF cannot.

    tip = "tool0"                    # which link is the tool, where several could be
    [payload]                        # name, gravity, base, tool, payload: as in the native format
    [gearboxes.large]                # parts that joints share, as in the native format
    [joints.shoulder_pan_joint]      # gearbox, bearing, encoder, mounting, lumped, link
    link = { section = "tube", material = "aluminium", length_tolerance = "50 µm" }
    limits = ["-90 deg", "90 deg"]   # a repair: in place of those of the URDF, as `mass` and
                                     `centre_of_mass` of the link; a note names it

It is NAME.toml beside NAME.urdf or NAME.urdf.xacro, unless another one is given. Of a xacro file it
holds the arguments too, in the table [xacro].
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from lostmotion.errors import shown
from lostmotion.io.limits import listed, nearest
from lostmotion.io.text import refuse
from lostmotion.io.toml import key_step
from lostmotion.mechanism.arm import MOST_NOTES

if TYPE_CHECKING:
    from collections.abc import Iterable

    from lostmotion.io import validation_errors
    from lostmotion.io.draft import Draft

# What a sidecar may say of a joint and of its link, with an example each; the rest is the URDF's.
_OF_JOINT: Final = {
    "preset": 'preset = "hobby servo"',
    "drive": 'drive = { torque = "150 N m" }',
    "gearbox": 'gearbox = "large"',
    "bearing": 'bearing = "large"',
    "guideway": 'guideway = { straightness = "20 µm", pitch = "20 arcsec" }',
    "encoder": 'encoder = { zero = "0.2 arcmin" }',
    "servo": 'servo = { dead_band = "0.05 deg" }',
    "mounting": 'mounting = { tilt = "0.5 arcmin" }',
    "lumped": 'lumped = { angle = "0.5 arcmin" }',
    "link": 'link = { section = "tube", material = "aluminium" }',
    "limits": 'limits = ["-90 deg", "90 deg"]',
    "passive": "passive = true",
    "start": 'start = "30 deg"',
    "assumed": 'assumed = ["gearbox"]',
    "source": 'source = "maker\'s data sheet, 2024"',
}
_OF_LINK: Final = {
    "preset": 'preset = "printed PLA"',
    "process": 'process = "ISO 2768 m"',
    "length_tolerance": 'length_tolerance = "50 µm"',
    "tip_tolerance": (
        'tip_tolerance = { tilt = ["1 arcmin", "1 arcmin", "0 arcmin"], offset = ["50 µm", "20 '
        'µm", "20 µm"] }'
    ),
    "mass": 'mass = "2.5 kg"',
    "centre_of_mass": 'centre_of_mass = ["120 mm", "0 mm", "15 mm"]',
    "section": 'section = "tube"',
    "material": 'material = "aluminium"',
    "compliance": 'compliance = "forearm.csv"',
    "measured": 'measured = { force = "100 N", deflection = "0.2 mm" }',
    "rigid": "rigid = true",
    "up": 'up = "z"',
    "expansion": 'expansion = "23e-6 1/K"',
    "temperature_difference": 'temperature_difference = "5 K"',
    "assumed": 'assumed = ["section"]',
    "source": 'source = "drawing 4711"',
}
_RANGES: Final = {"prismatic": '["0 mm", "500 mm"]'}
_EXAMPLE: Final = '[joints.shoulder_pan_joint] with gearbox = "large"'


def sidecar_place(description: Path) -> Path:
    """Return where the sidecar of a description has its place: NAME.toml beside NAME.urdf, and
    beside NAME.urdf.xacro.
    """
    inner = description.with_suffix("") if description.suffix.lower() == ".xacro" else description
    return (
        inner.with_suffix(".toml")
        if inner is description or inner.suffix.lower() == ".urdf"
        else inner.with_name(f"{inner.name}.toml")
    )


def find_sidecar(urdf: Path) -> Path | None:
    """Return the sidecar of a URDF. NAME.toml beside it, or none. Raises InputError for a link that
    leads out of its folder.
    """
    beside = sidecar_place(urdf)
    if not os.path.lexists(beside):
        return None
    folder = Path(os.path.realpath(urdf.parent))
    if not Path(os.path.realpath(beside)).is_relative_to(folder):
        refuse(
            str(beside),
            "",
            "a link that leads out of the folder",
            "a file beside the description, or a sidecar given by its path",
            f"--sidecar {beside.name}",
        )
    return beside


def limits_in_sidecar(description: Path, joint: str, kind: str) -> str:
    """Return the line of the sidecar that states the limits of a joint which the description leaves
    without.
    """
    example = _RANGES.get(kind, '["-90 deg", "90 deg"]')
    return f"{sidecar_place(description).name}: [joints.{key_step(joint)}] with limits = {example}"


def add_sidecar(draft: Draft, content: dict[str, Any], all_joints: Iterable[str]) -> None:
    """Put what a sidecar says onto a draft made from a URDF; note joints and keys that do not
    belong. `all_joints` are those of the URDF.
    """
    by_name = content.pop("joints", {})
    notes = draft.tree["notes"]
    draft.tree.update(content)
    if isinstance(content.get("notes", []), list):
        own = content.get("notes", [])
        draft.tree["notes"] = [*own, *notes[: max(MOST_NOTES - len(own), 0)]]
    if not isinstance(by_name, dict):
        expected = (
            "a table of joints by name; a list of joints is a whole arm, which is read by itself"
        )
        draft.refuse(("joints",), shown(by_name), expected, _EXAMPLE)
        return
    entries = {entry["name"]: index for index, entry in enumerate(draft.tree["joints"])}
    for name, parts in by_name.items():
        if draft.full:
            break
        if name not in entries:
            near = nearest(name, entries)
            known = (
                "a joint between root and tip"
                if name in all_joints
                else "a joint of the description"
            )
            draft.refuse(
                ("joints", name),
                "an unknown joint",
                f"{known}: {listed(entries)}",
                f"[joints.{key_step(near or next(iter(entries)))}]",
                near,
            )
        elif not isinstance(parts, dict):
            draft.refuse(("joints", name), shown(parts), "a table", _EXAMPLE)
        else:
            _add_joint(draft, entries[name], parts)


def _add_joint(draft: Draft, index: int, parts: dict[str, Any]) -> None:
    entry = draft.tree["joints"][index]
    link = parts.pop("link", {})
    _add(draft, entry, parts, _OF_JOINT, ("joints", index))
    if isinstance(link, dict):
        _add(draft, entry["link"], link, _OF_LINK, ("joints", index, "link"))
    else:
        draft.refuse(("joints", index, "link"), shown(link), "a table", _OF_JOINT["link"])


def _add(
    draft: Draft,
    onto: dict[str, Any],
    content: dict[str, Any],
    known: dict[str, str],
    path: validation_errors.Path,
) -> None:
    for key, value in content.items():
        if key in known:
            onto[key] = value
        elif not draft.full:
            near = nearest(key, known)
            draft.refuse(
                (*path, key),
                f"an unknown key with {shown(value)}",
                f"one of {', '.join(known)}; the description states the rest",
                known[near or next(iter(known))],
                near,
            )
