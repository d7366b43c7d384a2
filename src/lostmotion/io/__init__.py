"""File formats, one file each.

An ending names its reader in `READERS`; a new format is one more line there, and a module with
`read_arm(path, sidecar)`. Text that begins as XML does is read as what its root element says, URDF,
MJCF or SDF, whatever its ending; other formats are refused by their names.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from lostmotion.errors import nearest
from lostmotion.io.text import begins_as_xml, read_text, refuse
from lostmotion.io.toml import content, read_toml
from lostmotion.io.toml_lines import names_lines

if TYPE_CHECKING:
    from lostmotion.mechanism.arm import Arm

READERS: Final = {
    ".toml": "native",
    ".urdf": "urdf",
    ".xml": "urdf",
    ".xacro": "urdf",
    ".mjcf": "urdf",
    ".sdf": "urdf",
}


@names_lines
def read(path: str | Path | Mapping[str, Any], sidecar: str | Path | None = None) -> Arm:
    """Return the arm that a file describes, or a dictionary with what the TOML would hold. The
    ending says which format it is in, and XML by its first letters.

    `sidecar` is the TOML with what a URDF cannot state; unless given, NAME.toml beside NAME.urdf is
    used if it exists. Raises InputError with every mistake found: in the file, its sidecar, or the
    path itself.
    """
    beside = None if sidecar is None else Path(sidecar)
    if isinstance(path, Mapping):
        tree = content("arm", path)
        from lostmotion.io import native

        native.refuse_sidecar("a dictionary", beside)
        return native.arm_of("arm", tree)
    path = Path(path)
    ending = path.suffix.lower()
    if ending not in READERS and begins_as_xml(path):
        ending = ".urdf"
    if ending not in READERS:
        near = nearest(ending, READERS)
        if path.is_dir():
            refuse(
                str(path),
                "",
                "a folder",
                f"a file that ends in one of {', '.join(READERS)}",
                str(path / "arm.toml"),
            )
        refuse(
            str(path),
            "",
            f"the ending '{ending}'" if ending else "no ending",
            f"one of {', '.join(READERS)}",
            f"{path.stem or 'arm'}.toml",
            near,
        )
    if ending == ".toml":
        read_toml(path)  # before what checks its keys is loaded, which takes most of a second
    elif not path.exists():
        read_text(path, 1)
    arm: Arm = importlib.import_module(f"lostmotion.io.{READERS[ending]}").read_arm(path, beside)
    return arm
