"""`lostmotion schema`: print the JSON Schema."""

from __future__ import annotations

import typer

from lostmotion.cli.app import app


@app.command()
def schema() -> None:
    """Print the JSON Schema of the native TOML, for editors."""
    import json

    from lostmotion.formats.schema import json_schema

    typer.echo(json.dumps(json_schema(), indent=2, ensure_ascii=False))
