"""The command line: one command per question, generated from its signature."""

from lostmotion.cli.app import app, main

__all__ = ["app", "main"]
