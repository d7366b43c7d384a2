"""Ask for the JSON Schema of an arm file, or of result.json."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from lostmotion.analyses.signature import Argument, question, read_arguments


@question(folder=None)
def schema(
    of: Annotated[
        Literal["arm", "result"], Argument("An arm file (native TOML), or result.json.")
    ] = "arm",
) -> dict[str, Any]:
    """Return the JSON Schema of the native TOML, for editors, or of result.json.

    Raises
    ------
    InputError
        For another word.

    """
    asked = read_arguments(schema, locals())
    if asked.of == "result":
        from lostmotion.reporting.layout import result_schema

        return result_schema()
    from lostmotion.io.schema import json_schema

    return json_schema()
