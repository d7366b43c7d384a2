"""xacro: macros that make a URDF, expanded by the package xacro in a process of its own.

Arguments stand in the sidecar's table [xacro]:

    [xacro]
    ur_type = "ur5e"        # on xacro's own command line: ur_type:=ur5e
"""

from __future__ import annotations

import importlib.util
import os
import re
from pathlib import Path
from typing import Any, Final

from lostmotion.errors import Problem, shown
from lostmotion.io.limits import refuse_all
from lostmotion.io.own_process import ask
from lostmotion.io.text import refuse

ENDING: Final = ".xacro"
TABLE: Final = "xacro"
# Of a processor. Large descriptions take one.
_SECONDS: Final = 5
MANIFEST: Final = "package.xml"
_MOST_FOLDERS_UP: Final = 8
_MACROS: Final = re.compile(r"<xacro:|\$[{(]")


def has_macros(path: Path, text: str) -> bool:
    """Return whether this is a file for xacro: by its ending, and because there is something in it to expand."""
    return path.suffix.lower() == ENDING and _MACROS.search(text) is not None


def project_of(path: Path) -> Path:
    """Return the folder of the project of a file: the nearest one above it with a package.xml, else its own."""
    path = Path(os.path.realpath(path))
    return next((each for each in path.parents[:_MOST_FOLDERS_UP] if (each / MANIFEST).is_file()), path.parent)


def take_arguments(content: dict[str, Any], sidecar: str) -> dict[str, str]:
    """Take the arguments out of the content of a sidecar, as text.

    Raises InputError with every one that is neither text, a number, true nor false.
    """
    stated = content.pop(TABLE, {})
    if not isinstance(stated, dict):
        refuse(sidecar, TABLE, shown(stated), "a table of the arguments of the xacro file", '[xacro] with ur_type = "ur5e"')
    wrong = [
        Problem(sidecar, f"{TABLE}.{name}", shown(value), "text in quotes, a number, true or false", f'{name} = "ur5e"')
        for name, value in stated.items()
        if not isinstance(value, str | int | float)
    ]
    if wrong:
        refuse_all(wrong)
    return {name: str(value).lower() if isinstance(value, bool) else str(value) for name, value in stated.items()}


def expand(path: Path, arguments: dict[str, str], sidecar: str) -> str:
    """Return the URDF that a xacro file and its arguments make.

    It may include files of its project: the nearest folder above it with a package.xml, else its own folder. Packages that it names are looked for
    beside that folder, and where an installed ROS has them. Raises InputError with what is wrong, and where the package xacro is not installed.
    """
    if importlib.util.find_spec("xacro") is None:
        expected = f"the package xacro, which expands it: pip install 'lostmotion[xacro]'; or a URDF: xacro {path.name} > {path.stem}"
        refuse(str(path), "", "this is xacro, and the package xacro is not installed", expected, "pip install 'lostmotion[xacro]'")
    homes = [str(Path(each) / "share") for each in _listed("AMENT_PREFIX_PATH")] + _listed("ROS_PACKAGE_PATH")
    request = {"file": str(path), "path": str(path.absolute()), "sidecar": sidecar, "arguments": arguments, "homes": homes}
    text: str = ask("lostmotion.io.xacro_process", request, str(path), _SECONDS)["text"]
    return text


def _listed(variable: str) -> list[str]:
    return [each for each in os.environ.get(variable, "").split(os.pathsep) if each]
