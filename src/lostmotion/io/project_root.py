"""The folder within which a description may name other files, and the packages below folders.

A description is taken for hostile until it is checked, so that the files that it names are opened
within one folder only: the nearest one above it that is the root of a project (`MARKERS`), at most
8 folders up, else its own. The sidecar of a URDF, xacro, MJCF or SDF file may name another one:

    root = ".."        # from the sidecar's folder; a folder that holds the description

The root of the file system, the folders right below it, the user's home and whatever holds it are
never such a folder.
"""

from __future__ import annotations

import os
import re
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from lostmotion.errors import shown
from lostmotion.io.text import refuse

if TYPE_CHECKING:
    from collections.abc import Iterable

KEY: Final = "root"
MANIFEST: Final = "package.xml"
MARKERS: Final = (".git", ".hg", MANIFEST, "pyproject.toml")
_MOST_FOLDERS_UP: Final = 8
# Below each folder in which packages are searched.
_MOST_FOLDERS: Final = 2000
_DEEPEST: Final = 5
_PASSED_OVER: Final = ("build", "log", "node_modules", "__pycache__")
_MANIFEST_BYTES: Final = 100_000
_NAME: Final = re.compile(r"<name>\s*([^<\s]+)\s*</name>")
RULE: Final = f"the nearest folder above with one of {', '.join(MARKERS)}, otherwise the file's own"


def is_safe(folder: Path) -> bool:
    """Return whether a real folder may be read in whole: not the root of the file system, a folder
    right below it, the home, or what holds it.
    """
    home = None
    with suppress(RuntimeError, OSError):
        home = Path(os.path.realpath(Path.home()))
    return len(folder.parts) > 2 and not (home is not None and home.is_relative_to(folder))  # noqa: PLR2004 - the root and a folder right below it


def project_root(path: Path, markers: Iterable[str] = MARKERS) -> Path:
    """Return the real folder of the project of a file: the nearest one above it with one of these
    markers, else its own.
    """
    path = Path(os.path.realpath(path))
    markers = tuple(markers)
    for folder in path.parents[:_MOST_FOLDERS_UP]:
        if not is_safe(folder):
            break
        if any(os.path.lexists(folder / marker) for marker in markers):
            return folder
    return path.parent


def take_root(content: dict[str, Any], sidecar: Path | None, path: Path) -> Path:
    """Take `root` out of the content of a sidecar, and return the folder within which a description
    may name files.

    Raises InputError for what is no folder, does not hold the description, or is never read in
    whole.
    """
    if KEY not in content:
        return project_root(path)
    stated, file = content.pop(KEY), str(sidecar or path)
    expected = (
        "a folder that holds the description, by its path from the sidecar, and neither the home, "
        "what holds it, nor that of the whole machine"
    )
    if not isinstance(stated, str) or not stated.isprintable() or not stated:
        refuse(file, KEY, shown(stated), expected, 'root = ".."')
    folder = Path(os.path.realpath(Path(file).parent / stated))
    if (
        not folder.is_dir()
        or not Path(os.path.realpath(path)).is_relative_to(folder)
        or not is_safe(folder)
    ):
        refuse(
            file,
            KEY,
            f"{shown(stated)}, which is {shown(str(folder), 100)}",
            expected,
            'root = ".."',
        )
    return folder


def within(root: Path, folder: Path, stated: object) -> Path | None:
    """Return the file that a description names by its path from a folder; None for what is no path,
    and for one that leads out of the root.
    """
    if (
        not isinstance(stated, str)
        or not stated.isprintable()
        or not stated
        or Path(stated).is_absolute()
    ):
        return None
    path = folder / stated
    return path if Path(os.path.realpath(path)).is_relative_to(os.path.realpath(root)) else None


def package_name(folder: Path) -> str:
    """Return the name that the manifest of a ROS package states; empty where there is none, or what
    has its name is no regular file.
    """
    manifest = folder / MANIFEST
    try:
        if not manifest.is_file():  # the search would wait for a pipe without end
            return ""
        with manifest.open("rb") as stream:
            found = _NAME.search(stream.read(_MANIFEST_BYTES).decode("utf-8", "replace"))
    except OSError:
        return ""
    return found[1] if found else ""


def packages_below(folders: Iterable[Path]) -> dict[str, Path]:
    """Return the ROS packages in and below folders, by the name in their manifests; of several of
    one name the first, in the order of folders.

    Searched level by level, at most 5 deep and 2 000 folders below each; not in hidden folders,
    links, packages, and folders of builds. Folders that are never read in whole (`is_safe`) are
    passed over.
    """
    out: dict[str, Path] = {}
    for start in dict.fromkeys(Path(os.path.realpath(each)) for each in folders):
        level, seen = [start] if is_safe(start) else [], 0
        for _ in range(_DEEPEST + 1):
            deeper: list[Path] = []
            for folder in level[: _MOST_FOLDERS - seen]:
                seen += 1
                name = package_name(folder)
                if name:
                    out.setdefault(name, folder)
                else:
                    deeper += _folders_in(folder)
            level = deeper
    return out


def _folders_in(folder: Path) -> list[Path]:
    try:
        with os.scandir(folder) as entries:
            names = sorted(entry.name for entry in entries if entry.is_dir(follow_symlinks=False))
    except OSError:
        return []
    return [
        folder / name for name in names if not name.startswith(".") and name not in _PASSED_OVER
    ]
