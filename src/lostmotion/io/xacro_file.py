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
from lostmotion.io.project_root import MANIFEST, packages_below, project_root
from lostmotion.io.text import refuse

ENDING: Final = ".xacro"
TABLE: Final = "xacro"
# Of a processor. Large descriptions take one.
_SECONDS: Final = 5
_MACROS: Final = re.compile(r"<xacro:|\$[{(]")


def has_macros(path: Path, text: str) -> bool:
    """Return whether this is a file for xacro: by its ending, and because there is something in it
    to expand.
    """
    return path.suffix.lower() == ENDING and _MACROS.search(text) is not None


def take_arguments(content: dict[str, Any], sidecar: str) -> dict[str, str]:
    """Take the arguments out of the content of a sidecar, as text.

    Raises InputError with every one that is neither text, a number, true nor false.
    """
    stated = content.pop(TABLE, {})
    if not isinstance(stated, dict):
        refuse(
            sidecar,
            TABLE,
            shown(stated),
            "a table of the arguments of the xacro file",
            '[xacro] with ur_type = "ur5e"',
        )
    wrong = [
        Problem(
            sidecar,
            f"{TABLE}.{name}",
            shown(value),
            "text in quotes, a number, true or false",
            f'{name} = "ur5e"',
        )
        for name, value in stated.items()
        if not isinstance(value, str | int | float)
    ]
    if wrong:
        refuse_all(wrong)
    return {
        name: str(value).lower() if isinstance(value, bool) else str(value)
        for name, value in stated.items()
    }


def expand(
    path: Path, arguments: dict[str, str], sidecar: str, root: Path
) -> tuple[str, list[str]]:
    """Return the URDF that a xacro file and its arguments make, and the names of the arguments that
    are empty.

    It may include files within the folder `root`. Packages that it names are found by the names in
    their manifests below the folder that its own package lies in, below the project, and where an
    installed ROS has them (`packages_below`). Raises InputError with what is wrong, and where the
    package xacro is not installed.
    """
    if importlib.util.find_spec("xacro") is None:
        expected = (
            "the package xacro, which expands it: pip install 'lostmotion[xacro]'; or a URDF: "
            f"xacro {path.name} > {path.stem}"
        )
        refuse(
            str(path),
            "",
            "this is xacro, and the package xacro is not installed",
            expected,
            "pip install 'lostmotion[xacro]'",
        )
    homes = [Path(each) / "share" for each in _listed("AMENT_PREFIX_PATH")] + [
        Path(each) for each in _listed("ROS_PACKAGE_PATH")
    ]
    own = project_root(path, [MANIFEST])
    searched = [own.parent, root, project_root(own), *homes]
    request = {
        "file": str(path),
        "path": str(path.absolute()),
        "sidecar": sidecar,
        "arguments": arguments,
        "root": str(root),
        "own": str(own),
        "homes": [str(own.parent), *map(str, homes)],
        "packages": {name: str(folder) for name, folder in packages_below(searched).items()},
    }
    answer = ask("lostmotion.io.xacro_process", request, str(path), _SECONDS)
    return answer["text"], answer["empty"]


def _listed(variable: str) -> list[str]:
    return [each for each in os.environ.get(variable, "").split(os.pathsep) if each]
