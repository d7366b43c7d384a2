"""The JSON Schema of the native TOML: Arm's own, adapted to what the file takes besides (parts by
name, Denavit-Hartenberg rows).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from pydantic.json_schema import GenerateJsonSchema

from lostmotion.catalogue.drive_classes import LOADS, drive_classes
from lostmotion.catalogue.presets import PARTS, presets
from lostmotion.catalogue.printed_row import CheckedRow
from lostmotion.io.arm_builder import MATERIALS_OF_GEARBOXES, SHARED, SWEEP
from lostmotion.io.clearances import ALSO as IN_BEARINGS
from lostmotion.io.dh import DH_KEYS, DhRow
from lostmotion.io.drive_classes import CLASS, DRIVE, DRIVES, LOAD_KEYS
from lostmotion.io.legs import LEGS
from lostmotion.io.own_reducers import FILE, ROWS
from lostmotion.io.presets import DEFAULTS, TABLE
from lostmotion.io.presets import KEY as PRESET_KEY
from lostmotion.io.reducers import KEY as CATALOGUE_KEY
from lostmotion.io.reducers import VALUES
from lostmotion.mechanism.arm import Arm

if TYPE_CHECKING:
    from pydantic_core import core_schema

_JOINTS: Final = ("RevoluteJoint", "PrismaticJoint", "FixedJoint")
_PASSIVE: Final = ("SphericalJoint", "UniversalJoint", "FreeJoint")
_TURNING_GEARBOX: Final = "GearboxOfRevoluteJoint"
_WITHOUT_KIND: Final = (_TURNING_GEARBOX, "GearboxOfPrismaticJoint", "RigidBearing")
_DESCRIPTION: Final = (
    "An arm for lostmotion: joints from base to tool with their gearboxes, bearings, encoders "
    "and links. Quantities are text with a unit, "
    '"400 mm ± 50 µm"; parts that joints share stand in tables and are named where they are used.'
)

Schema = dict[str, Any]


class _ForToml(GenerateJsonSchema):
    """Pydantic's schema without what no TOML holds: nulls, defaults in SI numbers, titles that only
    repeat the key.
    """

    def nullable_schema(self, schema: core_schema.NullableSchema) -> Schema:
        return self.generate_inner(schema["schema"])

    def default_schema(self, schema: core_schema.WithDefaultSchema) -> Schema:
        inner = self.generate_inner(schema["schema"])
        return (
            {**inner, "default": schema["default"]}
            if isinstance(schema.get("default"), str) and "const" not in inner
            else inner
        )

    def field_title_should_be_set(self, schema: Any) -> bool:  # noqa: ANN401, ARG002 - pydantic's signature
        return False


def json_schema() -> Schema:
    """Return the JSON Schema (2020-12) of arm files, for editors. The reader itself checks more
    (ranges, units, what fits together).
    """
    schema = Arm.model_json_schema(schema_generator=_ForToml)
    kinds: dict[str, Schema] = schema["$defs"]
    kinds["DenavitHartenbergRow"] = {
        **DhRow.model_json_schema(schema_generator=_ForToml),
        "title": "DenavitHartenbergRow",
    }
    for joint in _JOINTS[:2]:
        _name_readably(kinds, joint, kinds[joint])
    _require_tags(schema)
    gearbox = next(name for name, kind in kinds.items() if kind["title"] == _TURNING_GEARBOX)
    kinds[gearbox]["properties"][CATALOGUE_KEY] = {
        "type": "string",
        "description": _REDUCER,
        "examples": ["RV-40E-121"],
    }
    kinds[gearbox]["properties"][VALUES] = {"enum": ["limit", "typical"], "description": _VALUES}
    row = CheckedRow.model_json_schema(schema_generator=_ForToml)
    row["properties"]["part"] = {"$ref": f"#/$defs/{gearbox}"}
    kinds["Typical"] = row["$defs"]["Typical"]
    kinds["ReducerRow"] = {
        **{key: value for key, value in row.items() if key != "$defs"},
        "title": "ReducerRow",
    }
    for model, examples in IN_BEARINGS.items():
        fits = {
            key: {"type": "string", "description": _FIT, "examples": [_value(text)]}
            for key, text in examples.items()
        }
        kinds[model.__name__]["properties"] |= fits
    _name_presets(kinds)
    for joint, kind in zip(_JOINTS, LOAD_KEYS, strict=False):
        kinds[joint]["properties"][DRIVE] = _drive(kind)
    stock = _take_parts_by_name(kinds)
    _waive_limits(kinds["RevoluteJoint"])
    for joint in _JOINTS:
        kinds[joint]["properties"] |= {
            key: {"$ref": "#/$defs/DenavitHartenbergRow", "description": _ROW[key]}
            for key in DH_KEYS
        }
    schema["properties"] |= stock
    schema["properties"][ROWS] = {
        "type": "array",
        "description": "reducers of your own, found by model as those of the catalogue",
        "items": _ROW_REF,
    }
    schema["properties"][FILE] = {
        "type": "string",
        "description": f"a file with [[{ROWS}]], beside this one or below",
        "examples": ["my_reducers.toml"],
    }
    schema["properties"][TABLE] = {
        "type": "object",
        "description": "presets of all joints, axes and links that name none of their own",
        "properties": {
            **{
                key: {"enum": _presets_of(part, key if part == "joint" else "")}
                for key, part in DEFAULTS.items()
            },
            DRIVES: {
                "enum": list(drive_classes()),
                "description": "the class of all drives; each joint states the load of its own",
            },
        },
        "additionalProperties": False,
    }
    schema["properties"][LEGS] = _legs(schema)
    schema["properties"][SWEEP] = {
        "type": "object",
        "description": _SWEEP,
        "examples": [{"gearboxes.wrist.backlash": ["0.5 arcmin", "1 arcmin"]}],
    }
    schema = _with_renamed_references(schema, {name: kind["title"] for name, kind in kinds.items()})
    schema["$defs"] = {
        kind["title"]: kind
        for _, kind in sorted(schema["$defs"].items(), key=lambda item: str(item[1]["title"]))
    }
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **schema,
        "title": "lostmotion arm",
        "description": _DESCRIPTION,
    }


_ROW_REF: Final = {"$ref": "#/$defs/ReducerRow"}
_REDUCER: Final = (
    "a reducer of the catalogue, with or without its ratio; the fields stated here go before its "
    "own"
)
_VALUES: Final = (
    "with `catalogue`: typical values where the maker prints only upper limits; default: the limits"
)
_FIT: Final = (
    "a zone of ISO 286-2, in place of the interference; the bearing's ring is of the normal class"
)
_SWEEP: Final = (
    "for `lostmotion sweep`: keys of this file, each with a list of values, or a range { from, "
    "to, steps, spacing }"
)
_LEGS: Final = (
    "legs that repeat: joints of each copy, the first one after `after` at `place`; the tip of the "
    "last one meets the place that the leg `joins`, at `end`"
)
_PRESET: Final = (
    "typical values of a class of parts, which count as assumed; what the file states takes "
    "precedence"
)
_COMPLIANCE_FILE: Final = {
    "type": "string",
    "description": "a CSV with a matrix (6, 6), beside this file or below",
    "examples": ["forearm.csv"],
}
_ROW: Final = {
    "dh": (
        "instead of origin, axis and tip: a row of standard Denavit-Hartenberg values, Rz(theta + "
        "q) Tz(d) Tx(a) Rx(alpha)"
    ),
    "mdh": (
        "instead of origin, axis and tip: a row of modified (Craig) values, Rx(alpha) Tx(a) "
        "Rz(theta + q) Tz(d)"
    ),
}


def _waive_limits(joint: Schema) -> None:
    """Require the limits of a joint with a drive alone."""
    joint["required"].remove("limits")
    passive = {"properties": {"passive": {"const": True}}, "required": ["passive"]}
    joint["anyOf"] = [{"required": ["limits"]}, passive]


def _legs(schema: Schema) -> Schema:
    """Return the schema of legs that repeat."""
    place = {"type": "string", "examples": ["base", "platform.tip"]}
    frame = {"$ref": "#/$defs/Frame"}
    of_copy = {"name": {"type": "string"}, "place": frame, "end": frame, "after": place}
    joints = {key: value for key, value in schema["properties"]["joints"].items() if key == "items"}
    return {
        "type": "array",
        "description": _LEGS,
        "items": {
            "type": "object",
            "properties": {
                "after": place,
                "joins": place,
                "copies": {
                    "type": "array",
                    "description": "where each copy begins and ends, and what differs, by joint",
                    "items": {"type": "object", "properties": of_copy, "required": ["name"]},
                },
                "joints": {"type": "array", **joints},
                "closures": schema["properties"]["closures"],
            },
            "required": ["copies", "joints"],
            "additionalProperties": False,
        },
    }


def _drive(kind: str) -> Schema:
    """Return the schema of the drive of a joint of this type by its class."""
    load = {
        "type": "string",
        "description": LOADS[kind].expected,
        "examples": [LOADS[kind].example],
    }
    return {
        "type": "object",
        "description": (
            "the largest load that the drive is to give: its class, or that of the arm, fills in "
            "what the joint does not state"
        ),
        "properties": {LOAD_KEYS[kind]: load, CLASS: {"enum": list(drive_classes())}},
        "required": [LOAD_KEYS[kind]],
        "additionalProperties": False,
    }


def _value(assignment: str) -> str:
    """Return what stands behind the key of an example."""
    return assignment.partition(" = ")[2].strip('"')


def _name_readably(kinds: dict[str, Schema], joint: str, schema: Any) -> None:  # noqa: ANN401 - any piece of a schema
    """Title the parts whose units depend on the kind of joint after both:
    GearboxOfRevoluteJoint.
    """
    if isinstance(schema, list):
        for inner in schema:
            _name_readably(kinds, joint, inner)
    if isinstance(schema, dict):
        kind = kinds.get(str(schema.get("$ref", "")).removeprefix("#/$defs/"), {})
        if "[" in kind.get("title", ""):
            kind["title"] = kind["title"].partition("[")[0].removeprefix("Catalogue") + f"Of{joint}"
            _name_readably(kinds, joint, kind)
        for inner in schema.values():
            _name_readably(kinds, joint, inner)


def _require_tags(schema: Schema) -> None:
    """Require the key that chooses among kinds: the reader does, and without it several would
    match. One gearbox and a rigid bearing go without.
    """
    waiting: list[Any] = [schema]
    while waiting:
        piece = waiting.pop()
        if isinstance(piece, dict):
            for reference in piece.get("discriminator", {}).get("mapping", {}).values():
                kind = schema["$defs"][reference.removeprefix("#/$defs/")]
                if kind["title"] in _WITHOUT_KIND:
                    continue
                kind["required"] = sorted(
                    {*kind.get("required", ()), piece["discriminator"]["propertyName"]}
                )
            waiting += piece.values()
        elif isinstance(piece, list):
            waiting += piece


def _presets_of(part: str, joint: str = "", kind: str = "") -> list[str]:
    """Return the names of the presets of a part that suit a type of joint and, where they are of
    one kind, a kind of part.
    """
    fitting = (
        row for row in presets().get(part, {}).values() if not joint or row.type in ("", joint)
    )
    return [row.name for row in fitting if not kind or row.values.get("kind", kind) == kind]


def _name_presets(kinds: dict[str, Schema]) -> None:
    """Allow the name of a preset where a part may take its values from one."""
    for kind in kinds.values():
        fields = kind.get("properties", {})
        if PRESET_KEY not in fields:
            continue
        title = str(kind["title"])
        joint = next(
            (word.removesuffix("Joint").lower() for word in _JOINTS if title.endswith(word)), ""
        )
        part = (
            "joint"
            if title in (*_JOINTS, *_PASSIVE)
            else next((part for part in PARTS if title.lower().startswith(part)), "bearing")
        )
        names = _presets_of(part, joint, str(fields.get("kind", {}).get("const", "")))
        fields.pop(PRESET_KEY)
        if names:
            fields[PRESET_KEY] = {"enum": names, "description": _PRESET}
    del kinds["Preset"]


def _take_parts_by_name(kinds: dict[str, Schema]) -> dict[str, Schema]:
    """Allow a text where a joint takes a shared part, and return the tables of those parts."""
    stock: dict[str, Schema] = {}
    for table, steps in SHARED.items():
        allowed: list[Schema] = []
        for holder in ["Link"] if len(steps) > 1 else [*_JOINTS, *_PASSIVE]:
            fields = kinds[holder]["properties"]
            if steps[-1] in fields:
                part = fields[steps[-1]]
                allowed += [] if part in allowed else [part]
                or_known = {
                    "gearboxes": ", or a reducer of the catalogue",
                    "materials": ", or one of the catalogue",
                }.get(table, "")
                fields[steps[-1]] = {
                    "anyOf": [
                        {"type": "string", "description": f"a name under [{table}]{or_known}"},
                        part,
                    ]
                }
        items = allowed[0] if len(allowed) == 1 else {"anyOf": allowed}
        stock[table] = {
            "type": "object",
            "description": "parts by name, for joints to share",
            "additionalProperties": items,
        }
    named = kinds["Link"]["properties"]["material"]
    for holder in ("Layer", "Step", "Station"):
        fields = kinds[holder]["properties"]
        fields["section"] = {
            "anyOf": [
                {"type": "string", "description": "a name under [sections]"},
                fields["section"],
            ]
        }
        if "material" in fields:
            fields["material"] = named
    matrix = kinds["Compliance"]
    matrix["properties"] = {
        "file": _COMPLIANCE_FILE,
        **{
            key: field
            for key, field in matrix["properties"].items()
            if key not in ("matrix", "own_weight")
        },
    }
    matrix["required"] = ["file"]
    for holder in ("Link", "Base"):
        fields = kinds[holder]["properties"]
        if "compliance" in fields:
            fields["compliance"] = {"anyOf": [_COMPLIANCE_FILE, fields["compliance"]]}
    for holder in (
        "CycloidalGearbox",
        "CycloidalFirstStage",
        "OutputPins",
        "PinSeat",
        "BearingSeat",
        "ShaftSection",
    ):
        fields = kinds[holder]["properties"]
        fields |= {key: named for key in MATERIALS_OF_GEARBOXES if key in fields}
    return stock


def _with_renamed_references(piece: Any, titles: dict[str, str]) -> Any:  # noqa: ANN401 - any piece of a schema
    if isinstance(piece, list):
        return [_with_renamed_references(inner, titles) for inner in piece]
    if isinstance(piece, dict):
        return {key: _with_renamed_references(inner, titles) for key, inner in piece.items()}
    if isinstance(piece, str) and piece.startswith("#/$defs/"):
        return "#/$defs/" + titles[piece.removeprefix("#/$defs/")]
    return piece
