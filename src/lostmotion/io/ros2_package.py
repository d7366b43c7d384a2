"""The files of a package for ROS 2: a chainable controller around the C source of one arm."""

from __future__ import annotations

import json
import pkgutil
from typing import TYPE_CHECKING, Final
from xml.sax.saxutils import escape

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.controller_model.controller import Controller

# Files with places to fill in, and where they go.
_FILES: Final = {
    "CMakeLists.txt": "CMakeLists.txt",
    "package.xml": "package.xml",
    "plugin.xml": "plugin.xml",
    "README.md": "README.md",
    "compensation_controller.cpp": "src/compensation_controller.cpp",
    "controllers.yaml": "config/controllers.yaml",
    "compensation.launch.py.in": "launch/compensation.launch.py",
}


def ros2_files(
    model: Controller, c_files: Mapping[str, str], title: str, remarks: str
) -> dict[str, str]:
    """Return the texts of all files of the package by their path.

    c_files  of the model in double precision, by their path
    title    name of the arm as Markdown
    remarks  what a user must know of the model, as a list in Markdown
    """
    tables = model.tables
    joints = list(tables.joints)
    marks = {
        "@PACKAGE@": package_name(tables.name),
        "@NAME@": title,
        "@REMARKS@": remarks,
        "@JOINTS@": _yaml(joints),
        "@REFERENCES@": _yaml([f"compensation/{name}" for name in joints]),
    }
    out = {f"model/{path}": text for path, text in c_files.items()}
    for name, path in _FILES.items():
        text = (pkgutil.get_data("lostmotion.controller_model", f"ros2/{name}") or b"").decode()
        for mark, value in marks.items():
            text = text.replace(mark, escape(value) if name.endswith(".xml") else value)
        out[path] = text
    rows = [
        f"  {_yaml(name)}:\n    has_position_limits: true\n"
        f"    min_position: {low!r}\n    max_position: {high!r}"
        for name, (low, high) in zip(joints, tables.limits.tolist(), strict=True)
    ]
    out["config/joint_limits.yaml"] = "\n".join(["joint_limits:", *rows, ""])
    return out


def package_name(arm: str) -> str:
    """Return the name of the package: lower-case letters, digits and single underscores."""
    letters = "".join(each if each.isascii() and each.isalnum() else " " for each in arm.lower())
    words = "_".join(letters.split()) or "arm"
    return f"{words if words[0].isalpha() else f'arm_{words}'}_compensation"


def _yaml(value: str | list[str]) -> str:
    """Return text or a list as YAML, of which JSON is a part."""
    return json.dumps(value)
