"""Parts of legs that repeat, taken apart for the copies while a file is changed.

Arguments are trees of dictionaries, or tomlkit's own (`plain`: whether they are dictionaries).
"""

from __future__ import annotations

import copy
from typing import Any, Final

from lostmotion.io.legs import merged

# Keys of a joint that new parts replace.
_PARTS: Final = ("link", "gearbox", "bearing", "mass")


def spread_legs(tree: Any, changed: set[str], *, plain: bool) -> dict[str, Any]:  # noqa: ANN401 - see the module
    """Move the parts of the joints of legs to each copy, where one of these joints is of a copy.
    Return the tables of the copies by the name of their joint.
    """
    out: dict[str, Any] = {}
    for leg in tree.get("legs", []):
        for joint in leg["joints"]:
            names = [f"{each['name']}_{joint['name']}" for each in leg["copies"]]
            if changed.isdisjoint(names):
                continue
            stated = {key: _unwrapped(joint.pop(key)) for key in _PARTS if key in joint}
            for name, each in zip(names, leg["copies"], strict=True):
                own = merged(stated, _unwrapped(each.get(joint["name"], {})), {})
                each[joint["name"]] = inline(own, plain=plain)
                out[name] = each[joint["name"]]
    return out


def gather_legs(tree: Any, *, plain: bool) -> None:  # noqa: ANN401 - see the module
    """Move parts that all copies of a leg share back to the joint of the leg."""
    for leg in tree.get("legs", []):
        for joint in leg["joints"]:
            tables = [each.get(joint["name"], {}) for each in leg["copies"]]
            for key in _PARTS:
                values = [_unwrapped(table.get(key)) for table in tables]
                if values[0] is None or any(each != values[0] for each in values):
                    continue
                joint[key] = inline(values[0], plain=plain)
                for table in tables:
                    table.pop(key)
            for each, table in zip(leg["copies"], tables, strict=True):
                if not table:
                    each.pop(joint["name"], None)


def inline(value: Any, *, plain: bool) -> Any:  # noqa: ANN401 - see the module
    """Return a value as it stands in a file, a table in one line."""
    if plain or not isinstance(value, dict):
        return value
    import tomlkit

    out = tomlkit.inline_table()
    out.update(value)
    return out


def _unwrapped(part: Any) -> Any:  # noqa: ANN401 - see the module
    return copy.deepcopy(part.unwrap() if hasattr(part, "unwrap") else part)
