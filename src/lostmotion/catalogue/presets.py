"""Presets: typical values of classes of parts, for a first answer before parts are chosen."""

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

from lostmotion.catalogue import data_file

if TYPE_CHECKING:
    from collections.abc import Mapping

# Parts of a joint that have presets, in the order of the arm file.
PARTS: Final = ("gearbox", "bearing", "guideway", "encoder", "servo", "mounting", "link")
_NO_VALUES: Final = ("type", "source", "also")


@dataclass(frozen=True, slots=True)
class PresetRow:
    """One preset.

    part    "joint", or one of `PARTS`
    type    "revolute" or "prismatic", of the joints that it suits; empty for any
    values  keys of the part's table in an arm file, quantities as text; of a joint also tables of
            its parts
    source  where the values come from, with marks as in `catalogue.gearboxes`
    sources the same by part of a joint, where it differs
    size    {"load": …}, N m or N, of a row that a class of drive has for this load; else empty
    """

    part: str
    name: str
    type: str
    values: Mapping[str, Any]
    source: str
    sources: Mapping[str, str] = field(default_factory=dict)
    size: Mapping[str, float] = field(default_factory=dict)


@functools.cache
def presets() -> dict[str, dict[str, PresetRow]]:
    """Return the presets by part and name."""
    return {
        part: {
            name: PresetRow(
                part,
                name,
                entry.get("type", ""),
                {key: value for key, value in entry.items() if key not in _NO_VALUES},
                entry["source"],
            )
            for name, entry in (
                (name, entry)
                for own, entry in entries.items()
                for name in (own, *entry.get("also", ()))
            )
        }
        for part, entries in data_file("presets.toml").items()
    }
