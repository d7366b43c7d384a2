"""The keys `assumed` of a file, where a table's own keys stand for other fields of its part."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping


def rename_assumed(table: dict[str, Any], fields: Mapping[str, str]) -> None:
    """Replace keys that only the file has by the fields that they fill ("shaft_fit" by
    "shaft_interference"); anything else stays as it is.
    """
    names = table.get("assumed")
    if isinstance(names, list):
        table["assumed"] = [
            fields.get(name, name) if isinstance(name, str) else name for name in names
        ]


def forget_assumed(table: Any, key: str) -> None:  # noqa: ANN401 - a dict, or tomlkit's own
    """Take a key whose value has been replaced out of the table's list of assumed values, and the
    list where it is then empty.
    """
    for listing in ("assumed", "upper_limits"):
        names = table.get(listing)
        if isinstance(names, list) and key in names:
            names.remove(key)
            if not names:
                table.pop(listing)
