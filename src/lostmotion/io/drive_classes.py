"""Classes of drive wherever an arm file names one, and the same arm with drives of another class.

[presets]
drives = "small strain wave"

[joints.shoulder]
drive = { torque = "150 N m" }
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from lostmotion.catalogue import materials
from lostmotion.catalogue.drive_classes import LOADS, drive_classes, load_of
from lostmotion.catalogue.gearbox_row import source_in_words
from lostmotion.catalogue.presets import PARTS, PresetRow
from lostmotion.error_model.assumed_drives import OF_DRIVE, whole_preset
from lostmotion.errors import nearest, shown
from lostmotion.parts.joint import has_drive
from lostmotion.parts.link import Link
from lostmotion.parts.provenance import NO_VALUES, Preset

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.catalogue.drive_classes import DriveClass
    from lostmotion.io.draft import Draft
    from lostmotion.io.validation_errors import Path
    from lostmotion.mechanism.arm import Arm
    from lostmotion.parts.joint import Joint, PrismaticJoint, RevoluteJoint

# Key of a joint, and of [presets] for the whole arm.
DRIVE: Final = "drive"
DRIVES: Final = "drives"
CLASS: Final = "class"
# By type of joint: the key of a drive's load.
LOAD_KEYS: Final = {"revolute": "torque", "prismatic": "force"}


def take_class(draft: Draft) -> DriveClass | None:
    """Take the class of all drives out of [presets] and return it; None where none is named. Note a
    wrong name.
    """
    stated = draft.tree.get("presets")
    if not isinstance(stated, dict) or DRIVES not in stated:
        return None
    return _class(draft, stated.pop(DRIVES), ("presets", DRIVES))


def drive_of(
    draft: Draft, joint: dict[str, Any], kind: str, path: Path, of_arm: DriveClass | None
) -> PresetRow | None:
    """Take the drive out of a joint's table and return the values of its class; None where the
    joint states none, or a wrong one.
    """
    if DRIVE not in joint:
        return None
    stated = joint.pop(DRIVE)
    here: Path = (*path, DRIVE)
    if kind == "fixed":
        draft.refuse(
            here, shown(stated), "no drive: a fixed joint does not move", 'type = "revolute"'
        )
    if kind not in LOAD_KEYS or not _is_drive(draft, stated, kind, here):
        return None
    of = _class(draft, stated[CLASS], (*here, CLASS)) if CLASS in stated else of_arm
    load = _load(draft, stated[LOAD_KEYS[kind]], kind, (*here, LOAD_KEYS[kind]))
    if of is None and CLASS not in stated and not draft.mistakes:
        expected = (
            f"a {CLASS}, or one for the whole arm: [presets] with {DRIVES} = …, one of "
            f"{', '.join(drive_classes())}"
        )
        draft.refuse(
            here,
            "a drive without its class",
            expected,
            f'[presets] with {DRIVES} = "small strain wave"',
        )
    return None if of is None or load is None else row_of(of, kind, load)


def _is_drive(draft: Draft, stated: Any, kind: str, here: Path) -> bool:  # noqa: ANN401 - whatever a file holds
    """Return whether a drive is a table with its load and no strange key; note what is wrong."""
    key = LOAD_KEYS[kind]
    example = f'{DRIVE} = {{ {key} = "{LOADS[kind].example}" }}'
    if not isinstance(stated, dict):
        draft.refuse(here, shown(stated), f"a table with {key}", example)
        return False
    strange = [name for name in stated if name not in (key, CLASS)]
    if strange:
        near = nearest(strange[0], (key, CLASS))
        draft.refuse(
            (*here, strange[0]),
            f"an unknown key with {shown(stated[strange[0]])}",
            f"{key}, and {CLASS} where it differs",
            example,
            near,
        )
    elif key not in stated:
        draft.refuse(
            here, shown(stated), f"the largest load that the drive is to give, {key}", example
        )
    return not strange and key in stated


def row_of(of: DriveClass, kind: str, load: float) -> PresetRow:
    """Return the values of a class for a drive of this load (N m or N) on a joint of this type, as
    a preset of the joint.
    """
    sources = {part: of.source(kind, part) for part in PARTS if part in of.laws[kind]}
    return PresetRow(
        "joint",
        of.name,
        kind,
        of.values(kind, load),
        of.source(kind, "joint"),
        sources,
        {"load": load},
    )


def _class(draft: Draft, name: object, path: Path) -> DriveClass | None:
    known = drive_classes()
    if isinstance(name, str) and name in known:
        return known[name]
    near = nearest(name, known) if isinstance(name, str) else ""
    draft.refuse(
        path,
        shown(name),
        f"a class of drive: {', '.join(known)}",
        f'{path[-1]} = "{near or next(iter(known))}"',
        near,
    )
    return None


def _load(draft: Draft, stated: object, kind: str, path: Path) -> float | None:
    from pydantic_core import PydanticCustomError

    try:
        return load_of(stated if isinstance(stated, str) else shown(stated), kind)
    except PydanticCustomError:
        draft.refuse(
            path, shown(stated), LOADS[kind].expected, f'{path[-1]} = "{LOADS[kind].example}"'
        )
        return None


def class_of_arm(arm: Arm) -> DriveClass | None:
    """Return the class of the arm's largest drive where the drives of all joints are assumed from
    classes; None where any is stated.

    The largest is that of the latest class in the order of size.
    """
    found = []
    for joint in arm.driven:
        presets = [_class_preset(getattr(joint, part, None)) for part in OF_DRIVE]
        if any(each is None for each in presets):
            return None
        found.append(drive_classes()[presets[0].name])  # type: ignore[union-attr] # none is None
    return max(found, key=lambda each: each.order, default=None)


def _class_preset(part: Any) -> Preset | None:  # noqa: ANN401 - a part of a joint, or None
    """Return the class that all values of a part come from; None where any is stated, or comes from
    elsewhere.
    """
    preset = whole_preset(part)
    if preset is None or preset.load is None or preset.name not in drive_classes():
        return None
    return preset


def with_class(arm: Arm, of: DriveClass, loads: Mapping[str, float] | None = None) -> Arm:
    """Return the arm with drives of another class on every moving joint: what its own class
    describes is replaced, what the file states is kept.

    loads  by joint, N m or N, for an arm without drives; default: those of its drives
    """
    joints = [
        _with_class(joint, of, (loads or {}).get(joint.name)) if has_drive(joint) else joint
        for joint in arm.joints
    ]
    rows = {
        k: row_of(of, joint.type, load)
        for k, joint in enumerate(joints)
        if has_drive(joint) and (load := _load_of(joint)) is not None
    }
    for k, joint in enumerate(joints):
        if joint.type == "fixed" and rows:
            before = [each for each in rows if each < k]
            own = joint.link.preset is not None and joint.link.preset.load is not None
            joints[k] = joint.model_copy(
                update={
                    "link": _link(
                        joint.link, rows[max(before) if before else min(rows)], own_class=own
                    )
                }
            )
    return arm.model_copy(update={"joints": tuple(joints)})


def _load_of(joint: Joint) -> float | None:
    """Return the load of the drive (N m or N) that a part of a joint suits by its class; None
    without one.
    """
    presets = [getattr(getattr(joint, part, None), "preset", None) for part in PARTS]
    return next(
        (preset.load for preset in presets if preset is not None and preset.load is not None), None
    )


def _with_class(
    joint: RevoluteJoint | PrismaticJoint, of: DriveClass, load: float | None
) -> RevoluteJoint | PrismaticJoint:
    parts = [part for part in PARTS if part in type(joint).model_fields]
    presets = {part: getattr(getattr(joint, part), "preset", None) for part in parts}
    load = _load_of(joint) if load is None else load
    if load is None:
        return joint
    row = row_of(of, joint.type, load)
    own = {
        part for part, preset in presets.items() if preset is not None and preset.load is not None
    }
    wanted = {
        part: row.values[part]
        for part in parts
        if part != "link" and part in row.values and (part in own or getattr(joint, part) is None)
    }
    made = type(joint).model_validate(
        {
            "name": joint.name,
            "limits": [
                f"{end!r} {'rad' if joint.type == 'revolute' else 'm'}" for end in joint.limits
            ],
            **_mass(joint, row),
            **{
                part: {**values, "preset": _preset(row, part, values)}
                for part, values in wanted.items()
            },
        },
        context={"text": True},
    )
    update: dict[str, Any] = {} if made.mass is None else {"mass": made.mass, "preset": made.preset}
    for part in wanted:
        new, old, preset = getattr(made, part), getattr(joint, part), presets[part]
        if old is not None and preset is not None and isinstance(old, type(new)):
            new = new.model_copy(
                update={
                    key: getattr(old, key)
                    for key in old.model_fields_set - NO_VALUES - {"preset", *preset.keys}
                }
            )
        update[part] = new
    link = _link(joint.link, row, own_class="link" in own)
    return joint.model_copy(update={**update, "link": link})


def _mass(joint: RevoluteJoint | PrismaticJoint, row: PresetRow) -> dict[str, Any]:
    """Return the mass of a joint unit by its class, and where it comes from; nothing where the file
    states the mass, or the class none.
    """
    if "mass" not in row.values or (
        joint.mass is not None and (joint.preset is None or "mass" not in joint.preset.keys)
    ):
        return {}
    return {"mass": row.values["mass"], "preset": _preset(row, "joint", {"mass": ""})}


def _link(link: Link, row: PresetRow, *, own_class: bool) -> Link:
    """Return a link with the values of a class, unless it has no length, or the file states its
    stiffness or tolerance.
    """
    keys = set(link.preset.keys) if own_class and link.preset is not None else set()
    stated = (
        link.model_fields_set
        & {"section", "material", "compliance", "measured", "rigid", "process", "length_tolerance"}
        - keys
    )
    values = {key: value for key, value in row.values["link"].items() if key not in stated}
    if not link.reach or stated or link.length.tolerance:
        return link
    named = {**values, "material": materials()[values["material"]]}
    of_class = Link.model_validate(
        {"length": f"{link.reach!r} m", **named, "preset": _preset(row, "link", values)},
        context={"text": True},
    )
    return link.model_copy(update={key: getattr(of_class, key) for key in (*values, "preset")})


def _preset(row: PresetRow, part: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the provenance of a part whose values are all those of a class."""
    keys = [key for key in values if key not in NO_VALUES]
    return {
        "name": row.name,
        "keys": keys,
        "source": source_in_words(row.sources.get(part, row.source)),
        **row.size,
    }
