"""`lostmotion schema`: print the JSON Schema."""

from __future__ import annotations

from lostmotion.cli.app import app
from lostmotion.cli.terminal import say_json


@app.command()
def schema() -> None:
    """Print the JSON Schema of the native TOML, for editors."""
    from lostmotion.io.schema import json_schema

    say_json(json_schema())
