"""Presets wherever an arm file describes a joint or one of its parts.

    [presets]                        # of all joints that name none of their own
    revolute = "hobby servo"         # prismatic: of sliding joints
    link = "printed PLA"
    mounting = "printed"

    [[joints]]
    preset = "hobby servo"           # mass, gearbox, bearing, encoder; what the joint states takes
                                     precedence
    gearbox = { preset = "small planetary", ratio = 25 }
    link = { preset = "printed PLA", length = "120 mm" }

    [presets]
    drives = "small strain wave"     # the class of all drives: gearbox, bearing, encoder, mounting
                                     and link by the load of each joint

    [joints.shoulder]
    drive = { torque = "150 N m" }    # force on a sliding joint; `class` where it differs from that
    of the arm

Presets replace nothing that is stated, and every value that they fill in counts as assumed, with
the name of the preset.
"""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Any, Final

from pydantic import ValidationError

from lostmotion.catalogue.gearbox_row import REPLACES, source_in_words
from lostmotion.catalogue.presets import PARTS, PresetRow, presets
from lostmotion.errors import nearest, shown
from lostmotion.io.drive_classes import drive_of, take_class
from lostmotion.io.reducers import KEY as CATALOGUE
from lostmotion.parts.gearbox.kinds import DEFAULT_KIND
from lostmotion.parts.link import Link
from lostmotion.parts.provenance import NO_VALUES
from lostmotion.units import states_tolerance

if TYPE_CHECKING:
    from lostmotion.io.draft import Draft
    from lostmotion.io.validation_errors import Path

KEY: Final = "preset"
TABLE: Final = "presets"
TABLE_EXAMPLE: Final = f'[{TABLE}] with revolute = "hobby servo"'
# Keys of [presets], and the part that each fills in.
DEFAULTS: Final = {
    "revolute": "joint",
    "prismatic": "joint",
    "mounting": "mounting",
    "link": "link",
}
_SHARED: Final = {"gearboxes": "gearbox", "bearings": "bearing", "encoders": "encoder"}
_TYPES: Final = ("revolute", "prismatic", "fixed")
# A stated key replaces the preset's keys that express the same figure.
_REPLACES: Final = {
    **REPLACES,
    "length_tolerance": {"process"},
    **{key: {"section", "material"} for key in ("compliance", "measured")},
    "rigid": {"section", "material", *REPLACES["rigid"]},
}


def place_presets(draft: Draft) -> None:
    """Fill in the values of presets where joints and parts name them; note what is wrong with a
    name, and which presets were used.
    """
    used: list[str] = []
    of_arm = take_class(draft)
    defaults = _defaults(draft)
    shared = {table: draft.tree.get(table) for table in _SHARED}
    for table, part in _SHARED.items():
        stock = shared[table]
        for name, stated in stock.items() if isinstance(stock, dict) else ():
            _place(draft, used, stated, part, "", (table, name))
    of_class: dict[int, PresetRow] = {}
    for index, joint in draft.joints:
        path: Path = ("joints", index)
        driven = joint.get("passive") is not True
        kind = joint["type"] if driven and joint.get("type") in _TYPES else ""
        row = (
            _named(draft, joint, "joint", kind, path)
            or drive_of(draft, joint, kind, path, of_arm)
            or defaults.get(kind)
        )
        for part in PARTS:
            own = _place(draft, used, joint.get(part), part, kind, (*path, part))
            # A preset that the file names for all links or mountings goes before the class of the
            # drive.
            _fill_in_part(
                used,
                joint,
                part,
                None if own or (row is not None and row.size and part in defaults) else row,
            )
        if row is not None:
            _fill_in(
                used,
                joint,
                {key: value for key, value in row.values.items() if key not in PARTS},
                row,
            )
        if row is not None and row.size:
            of_class[index] = row
        if kind not in ("", "fixed") and "mounting" in defaults and "mounting" not in joint:
            joint["mounting"] = {}
            _fill_in(used, joint["mounting"], defaults["mounting"].values, defaults["mounting"])
        link = joint.get("link")
        if "link" in defaults and isinstance(link, dict) and KEY not in link and _reaches(link):
            _fill_in(used, link, defaults["link"].values, defaults["link"])
    _fill_in_fixed_links(draft, used, of_class)
    if used:
        draft.note(f"values of presets, all of them assumed: {', '.join(dict.fromkeys(used))}")


def _fill_in_fixed_links(draft: Draft, used: list[str], of_class: dict[int, PresetRow]) -> None:
    """Fill in the links of fixed joints as those of the joint before with a drive by its class,
    else of the one behind.
    """
    for index, joint in draft.joints if of_class else ():
        if joint.get("type") == "fixed" and isinstance(joint.get("link", {}), dict):
            before = [each for each in of_class if each < index]
            row = of_class[max(before) if before else min(of_class)]
            _fill_in_part(used, joint, "link", row)


def _defaults(draft: Draft) -> dict[str, PresetRow]:
    """Return the presets of all joints by key of [presets]."""
    stated = draft.tree.pop(TABLE, {})
    if not isinstance(stated, dict):
        draft.refuse((TABLE,), shown(stated), "a table of presets", TABLE_EXAMPLE)
        return {}
    out = {}
    for key, name in stated.items():
        if key not in DEFAULTS:
            near = nearest(key, DEFAULTS)
            draft.refuse(
                (TABLE, key),
                f"an unknown key with {shown(name)}",
                f"one of {', '.join(DEFAULTS)}",
                f"{near or 'revolute'} = {_any_preset(near or 'revolute')}",
                near,
            )
            continue
        part = DEFAULTS[key]
        row = _row(draft, name, part, key if part == "joint" else "", (TABLE, key))
        if row is not None:
            out[key] = row
    return out


def _any_preset(key: str) -> str:
    """Return a preset that a key of [presets] takes, as it stands in a file."""
    rows = presets().get(DEFAULTS[key], {}).values()
    return next(
        f'"{row.name}"' for row in rows if DEFAULTS[key] != "joint" or row.type in ("", key)
    )


def _place(draft: Draft, used: list[str], stated: Any, part: str, kind: str, path: Path) -> bool:  # noqa: ANN401 - whatever a file holds
    """Fill in the preset that a part names; return whether it names one."""
    if not isinstance(stated, dict) or KEY not in stated:
        return False
    row = _named(draft, stated, part, kind, path)
    if row is not None and _is_kind(stated, row.values, part):
        _fill_in(used, stated, row.values, row)
    elif row is not None:
        expected = f"no kind, or the preset's own: {row.values.get('kind', DEFAULT_KIND)}"
        draft.refuse(
            (*path, "kind"),
            f"{shown(stated['kind'])} beside preset {row.name}",
            expected,
            f'{KEY} = "{row.name}"',
        )
    return True


def _is_kind(stated: dict[str, Any], values: Any, part: str) -> bool:  # noqa: ANN401 - a table of an arm file
    """Return whether a part is, or does not say that it is not, of the kind that a preset
    describes.
    """
    return "kind" not in stated or stated["kind"] == values.get(
        "kind", DEFAULT_KIND if part == "gearbox" else None
    )


def _named(
    draft: Draft, holder: dict[str, Any], part: str, kind: str, path: Path
) -> PresetRow | None:
    """Take the name of a preset out of a table and return the preset; None where it names none, or
    a wrong one.
    """
    return _row(draft, holder.pop(KEY), part, kind, (*path, KEY)) if KEY in holder else None


def _row(draft: Draft, name: object, part: str, kind: str, path: Path) -> PresetRow | None:
    fitting = {
        row.name: row
        for row in presets().get(part, {}).values()
        if not kind or row.type in ("", kind)
    }
    if isinstance(name, str) and name in fitting:
        return fitting[name]
    near = nearest(name, fitting) if isinstance(name, str) else ""
    of = f"{kind} {part}" if kind else part
    draft.refuse(
        path,
        shown(name),
        f"a preset of a {of}: {', '.join(fitting) or 'there is none'}",
        f'{path[-1]} = "{near or next(iter(fitting), "")}"',
        near,
    )
    return None


def _fill_in_part(used: list[str], joint: dict[str, Any], part: str, row: PresetRow | None) -> None:
    """Fill in one part of a joint from the joint's preset, unless the joint states another kind of
    it, or names a shared one.
    """
    values = None if row is None else row.values.get(part)
    stated = joint.get(part, {})
    if (
        row is None
        or values is None
        or not isinstance(stated, dict)
        or CATALOGUE in stated
        or not _is_kind(stated, values, part)
    ):
        return
    if part == "link" and not _reaches(stated):
        return
    joint[part] = dict(stated)
    _fill_in(used, joint[part], values, row, part)


def _fill_in(
    used: list[str],
    holder: dict[str, Any],
    values: Any,  # noqa: ANN401
    row: PresetRow,
    part: str = "",
) -> None:
    """Add the values that a table does not state, and the name of the preset that they come from;
    `part` of a joint's preset.
    """
    replaced = {other for key in holder for other in _REPLACES.get(key, ())}
    if states_tolerance(holder.get("length")):
        replaced.add("process")
    added = {
        key: copy.deepcopy(value)
        for key, value in values.items()
        if key not in holder and key not in replaced
    }
    keys = [key for key in added if key not in NO_VALUES]
    if keys:
        holder |= {
            **added,
            KEY: {
                "name": row.name,
                "keys": keys,
                "source": source_in_words(row.sources.get(part, row.source)),
                **row.size,
            },
        }
        used.append(row.name)


def _reaches(link: dict[str, Any]) -> bool:
    """Return whether a link has a length, so that it can have a section."""
    frame = {key: link[key] for key in ("length", "direction", "tip") if key in link}
    try:
        return Link.model_validate(frame, context={"text": True}).reach > 0
    except ValidationError:
        return False  # the model reports what is wrong with it
