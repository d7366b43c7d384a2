"""The published JSON Schema."""

from __future__ import annotations

import json
import tomllib

import jsonschema
import pytest

from lostmotion.io.schema import json_schema
from lostmotion.parts.bearing.single import PAIRS
from tests.io.conftest import EXAMPLES, JOINT


@pytest.fixture(scope="module")
def validator():
    """Return what checks a tree by the schema, which is itself checked by a test of its own."""
    return jsonschema.Draft202012Validator(json_schema())


def test_the_published_schema_is_the_generated_one():
    """docs/arm.schema.json is what `lostmotion schema` prints."""
    published = (EXAMPLES.parent / "docs" / "arm.schema.json").read_text(encoding="utf-8")
    assert published == json.dumps(json_schema(), indent=2, ensure_ascii=False) + "\n"


def test_every_name_in_the_schema_can_be_read():
    """Definitions are named after parts, not after Python's types."""
    schema = json_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    assert all(name.isalpha() for name in schema["$defs"])
    assert {"GearboxOfRevoluteJoint", "GearboxOfPrismaticJoint", "DenavitHartenbergRow"} <= set(
        schema["$defs"]
    )


@pytest.mark.parametrize(
    "path",
    sorted(
        path
        for path in EXAMPLES.rglob("*.toml")
        if path.parent.name not in {"sizing", "sweep", "tasks"}
        and "[[estimates]]" not in path.read_text(encoding="utf-8")
    ),
    ids=lambda path: path.stem,
)
def test_every_example_fits_the_schema(path, validator):
    """An editor that knows the schema finds nothing wrong in an example; sidecars, keyed by joint,
    and parts by themselves are put into an arm.
    """
    tree = tomllib.loads(path.read_text(encoding="utf-8"))
    if "joints" not in tree:
        parts = {key: tree.pop(key) for key in ("gearbox", "bearing") if key in tree}
        assert parts
        if parts.get("bearing", {}).get("kind") in PAIRS:
            # an arm's bearings stand in pairs: a single one has the keys of its pair but for the
            # span
            parts["bearing"] |= {"kind": PAIRS[parts["bearing"]["kind"]], "span": "1 m"}
        tree = {
            "name": "x",
            **tree,
            "joints": [{"name": "A", "type": "revolute", "limits": ["0 deg", "1 deg"], **parts}],
        }
    elif isinstance(tree["joints"], dict):
        assert path.with_suffix(".urdf").exists()
        tree = {
            "name": "x",
            "joints": [
                {"name": "A", "type": "revolute", "limits": ["0 deg", "1 deg"], **joint}
                for joint in tree["joints"].values()
            ],
        }
    validator.validate(tree)


def test_rows_of_ones_own_fit_the_schema(validator):
    """A row as the catalogue has it passes, one with a slip in its gearbox does not."""
    row = {"models": ["X-10"], "maker": "X", "part": {"backlash": "1 arcmin"}, "source": "measured"}
    tree = {**tomllib.loads('name = "x"\n' + JOINT), "reducers": [row]}
    validator.validate({"catalogue": "my_reducers.toml", **tree})
    row["part"]["backlsh"] = "1 arcmin"
    with pytest.raises(jsonschema.ValidationError):
        validator.validate(tree)


@pytest.mark.parametrize(
    "line",
    [
        "axis = 3",
        'gearbox = { ratio = "x", unknown = 1 }',
        "mass = 3",
        "dh = { a = 1 }",
        'link = { section = { kind = "tub" } }',
    ],
)
def test_the_schema_refuses_what_the_reader_refuses(line, validator):
    """Slips of a key or a type show in the editor already."""
    tree = tomllib.loads('name = "x"\n' + JOINT + line)
    with pytest.raises(jsonschema.ValidationError):
        validator.validate(tree)
