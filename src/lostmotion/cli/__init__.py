"""The command line: one file here per command, `lostmotion run FILE` and the others that `lostmotion --help` lists."""

from lostmotion.cli import run, map, catalog, gear, bearing, statics, size, iso9283, target, sweep, replay, schema  # noqa: A004, F401, I001 - in the order of the help
from lostmotion.cli.app import app, main

__all__ = ["app", "main"]
