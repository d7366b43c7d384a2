"""Templates of arm files: one TOML each, package data, every value marked as assumed that no maker
prints.
"""

from __future__ import annotations

import importlib.resources
import re
from typing import Final

from lostmotion.io.toml import quoted

_NAME: Final = re.compile(r"^name = .*$", re.MULTILINE)


def template_text(template: str, name: str = "") -> str:
    """Return the text of a template, with another name for the arm where one is given."""
    text = (
        importlib.resources.files("lostmotion.io")
        .joinpath("templates", f"{template}.toml")
        .read_text(encoding="utf-8")
    )
    return _NAME.sub(lambda _: f"name = {quoted(name)}", text, count=1) if name else text


def template_summary(template: str) -> str:
    """Return what a template describes: its first line."""
    return template_text(template).partition("\n")[0].removeprefix("# ")
