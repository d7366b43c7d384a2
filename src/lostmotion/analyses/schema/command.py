"""Ask for the JSON Schema of the native TOML."""

from __future__ import annotations

from typing import Any

from lostmotion.analyses.signature import question


@question(folder=None)
def schema() -> dict[str, Any]:
    """Return the JSON Schema of the native TOML, for editors."""
    from lostmotion.io.schema import json_schema

    return json_schema()
