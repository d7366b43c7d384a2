"""The FMU of an arm: description, C sources, and a shared library for this platform, as one
reproducible zip.
"""

from __future__ import annotations

import io
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING, Final

from lostmotion.controller_model.c_source import packaged
from lostmotion.controller_model.fmi import (
    build_description,
    description,
    token,
    variables_of,
    variables_source,
)
from lostmotion.errors import LostmotionError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lostmotion.controller_model.controller import Controller
    from lostmotion.controller_model.fmi import Version

# Sources of a C export that the FMU takes over, and its own.
_CORE: Final = ("lm_core.c", "lm_core.h", "lm_tables.h", "lm_model.c", "lm_model.h")
# The platform in both versions of the FMI, and what a shared library is called there.
_PLATFORMS: Final = {
    ("linux", "x86_64"): ("linux64", "x86_64-linux", "so"),
    ("linux", "aarch64"): ("aarch64-linux", "aarch64-linux", "so"),
    ("darwin", "x86_64"): ("darwin64", "x86_64-darwin", "dylib"),
    ("darwin", "arm64"): ("aarch64-darwin", "aarch64-darwin", "dylib"),
}
_FIRST_DAY: Final = (1980, 1, 1, 0, 0, 0)


def fmu(model: Controller, c_files: Mapping[str, str], version: Version) -> tuple[bytes, str]:
    """Return the FMU and the folder of its library, empty where this machine has no C compiler or
    no name in the FMI.

    c_files  texts of the files of a C export by their path

    The same arm gives the same bytes on one machine with one compiler. Raises LostmotionError where
    the compiler refuses the sources.
    """
    tables = model.tables
    identifier = (
        "".join(each if each.isascii() and each.isalnum() else "_" for each in tables.name) or "arm"
    )
    identifier = identifier if identifier[0].isalpha() else f"arm_{identifier}"
    variables = variables_of(tables)
    glue = f"lm_fmi{version[0]}.c"
    sources = {name: c_files[f"src/{name}"] for name in _CORE} | {
        name: packaged(name) for name in ("lm_fmi.h", glue)
    }
    guid = token("\n".join([version, tables.name, *sources.values()]))
    sources["lm_variables.h"] = variables_source(variables, guid)
    compiled = sorted(name for name in sources if name.endswith(".c"))
    files: dict[str, bytes] = {f"sources/{name}": text.encode() for name, text in sources.items()}
    files["modelDescription.xml"] = description(
        tables.name, identifier, variables, guid, compiled, version
    )
    files["documentation/README.md"] = c_files["README.md"].encode()
    if version == "3.0":
        files["sources/buildDescription.xml"] = build_description(identifier, compiled)
    names, compiler = _PLATFORMS.get((sys.platform, platform.machine())), _compiler()
    folder = ""
    if names is not None and compiler:
        folder = f"binaries/{names[int(version == '3.0')]}"
        files[f"{folder}/{identifier}.{names[2]}"] = _library(sources, compiled, compiler)
    return _zipped(files), folder


def _compiler() -> str | None:
    return next(
        (
            found
            for name in (os.environ.get("CC", ""), "cc", "gcc", "clang")
            if name and (found := shutil.which(name))
        ),
        None,
    )


def _library(sources: Mapping[str, str], compiled: list[str], compiler: str) -> bytes:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, text in sources.items():
            (folder / file).write_text(text, encoding="utf-8")
        options = ["-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-DLM_DOUBLE"]
        # relative names, so that the folder leaves no trace in the library
        done = subprocess.run(  # noqa: S603 - the user's own compiler, on sources of this package
            [compiler, *options, *compiled, "-o", "library", "-lm"],
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode:
            raise LostmotionError(
                f"'{compiler}' refuses the C sources of the FMU\n  {done.stderr.strip()[:500]}"
            )
        return (folder / "library").read_bytes()


def _zipped(files: Mapping[str, bytes]) -> bytes:
    """Return a zip with the files in order of their names, all of the same time."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            archive.writestr(zipfile.ZipInfo(name, _FIRST_DAY), files[name], zipfile.ZIP_DEFLATED)
    return out.getvalue()
