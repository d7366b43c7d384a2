"""The XML of an SDF file (SDFormat, of Gazebo and Drake): one model, with the models that it
includes put in.

The file is taken for hostile, as a URDF is; included files lie within the folder of the project.
What older versions mean without saying so is written out, so that versions may be mixed.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from lxml import etree

from lostmotion.errors import shown
from lostmotion.io.limits import listed
from lostmotion.io.project_root import RULE, within
from lostmotion.io.text import read_old_text, refuse
from lostmotion.io.urdf_xml import line_of, parse_leniently, parse_plain

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

ROOT: Final = "sdf"
MEGABYTES: Final = 5
_MOST_INCLUDES: Final = 50
_DEEPEST: Final = 5
_OLDEST: Final = (1, 4)
_NEWEST: Final = (1, 12)
# From here on an axis is seen from its joint, before it from the model.
_OF_JOINT: Final = (1, 5)
TRUE: Final = ("true", "1")
_SCHEME: Final = re.compile(r"^(?:model|package)://|^file:(?://)?")
_BASE: Final = "{http://www.w3.org/XML/1998/namespace}base"
_CONFIG: Final = "model.config"
_MODEL: Final = "model.sdf"


def model_of(path: Path, text: str, folder: Path) -> tuple[etree._Element, list[str]]:
    """Return the model that an SDF file describes, with what it includes from within a folder, and
    notes on repairs and on what is passed over.

    The file of an element is its `base`, None for the file itself. Raises InputError for what is no
    SDF 1.4 to 1.12, for several models with joints, and for includes that are missing or elsewhere.
    """
    root, notes = parse_leniently(text, str(path), ROOT)
    _write_out(root, str(path))
    models = [*root.iterchildren("model")]
    for world in root.iterchildren("world"):
        models += world.iterchildren("model")
        if (count := len(world.findall("include"))) > 0:
            notes.append(f"not read: {count} models that the world includes")
    jointed = [model for model in models if model.find(".//joint") is not None]
    chosen = jointed or models
    if len(chosen) != 1:
        names = f": {listed([_name(model) for model in chosen])}" if chosen else ""
        refuse(
            f"{path}:{line_of(root)}",
            "/sdf",
            f"{len(chosen)} models{names}" if chosen else "no model",
            "one model with joints; models that it includes stand within it",
            '<sdf version="1.9"><model name="arm"> ... </model></sdf>',
        )
    if len(models) > 1:
        others = [_name(model) for model in models if model is not chosen[0]]
        notes.append(f"not taken: the models {listed(others)}, which have no joints")
    _IncludedModels(folder).put_in(chosen[0], path, 0)
    return chosen[0], notes


def self_contained_text(path: Path, text: str, folder: Path) -> str:
    """Return the text of one file with everything that an SDF file describes and includes."""
    model, _ = model_of(path, text, folder)
    etree.strip_attributes(model, _BASE)
    words = etree.tostring(model, encoding="unicode", with_tail=False)
    return f'<sdf version="{".".join(map(str, _NEWEST))}">\n{words}\n</sdf>\n'


def place(element: etree._Element, file: str) -> str:
    """Return file and line of an element of the model in `file`."""
    return f"{element.base or file}:{line_of(element)}"


def _name(model: etree._Element) -> str:
    return shown(model.get("name", "?"), 42)[1:-1]


def _write_out(root: etree._Element, file: str) -> None:
    """Check the version, and write the frame of each axis that a version leaves unsaid."""
    etree.strip_attributes(root, _BASE)
    stated = root.get("version", "")
    version = tuple(map(int, stated.split("."))) if re.fullmatch(r"\d\.\d{1,2}", stated) else ()
    if not _OLDEST <= version <= _NEWEST:
        found = f"version {shown(stated)}" if stated else "no version"
        refuse(
            f"{file}:{line_of(root)}",
            "/sdf/@version",
            found,
            "a version from 1.4 to 1.12, which decides what an axis is seen from",
            '<sdf version="1.9">',
        )
    for axis in root.iter("axis", "axis2"):
        xyz = axis.find("xyz")
        if xyz is not None and "expressed_in" not in xyz.attrib:
            of_model = axis.findtext("use_parent_model_frame", "").strip() in TRUE
            xyz.set("expressed_in", "__model__" if of_model or version < _OF_JOINT else "")


class _IncludedModels:
    """Put included models in the place of `include`."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.count = 0

    def put_in(self, model: etree._Element, path: Path, depth: int) -> None:
        """Replace every `include` of a model and of those in it, which stand in the file `path`."""
        for include in list(model.iter("include")):
            parent = include.getparent()
            if parent is None:
                continue
            self.count += 1
            at = f"{path}:{line_of(include)}"
            if depth >= _DEEPEST or self.count > _MOST_INCLUDES:
                refuse(
                    at,
                    "//include",
                    "too many includes, or one that includes itself",
                    f"at most {_MOST_INCLUDES}, {_DEEPEST} deep",
                    "one file",
                )
            if include.get("merge", "") in TRUE:
                refuse(
                    at,
                    "//include/@merge",
                    "a model that is merged into this one",
                    "a nested model: its names then begin with NAME::",
                    "<include><uri>model://hand</uri></include>",
                )
            file = self._file(include.findtext("uri", "").strip(), path, at)
            inner = self._model(file)
            for key in ("name", "placement_frame"):
                if stated := include.findtext(key, "").strip():
                    inner.set(key, stated)
            pose = include.find("pose")
            if pose is not None:
                for own in inner.findall("pose"):
                    inner.remove(own)
                inner.append(pose)
            self.put_in(inner, file, depth + 1)
            inner.base = str(file)
            inner.tail = None
            parent.replace(include, inner)

    def _model(self, file: Path) -> etree._Element:
        root, _ = parse_leniently(read_old_text(file, MEGABYTES)[0], str(file), ROOT)
        _write_out(root, str(file))
        model = root.find("model")
        if model is None:
            refuse(f"{file}:{line_of(root)}", "/sdf", "no model", "a model", '<model name="hand">')
        return model

    def _file(self, uri: str, path: Path, at: str) -> Path:
        """Return the file that an include names: beside the file that includes it, or in a folder
        above, up to the project's.
        """
        stated = _SCHEME.sub("", uri)
        places = [
            within(self.root, f, n)
            for f in self._folders(path)
            for n in (stated, f"models/{stated}")
        ]
        folders = [each for each in places if each is not None and each.is_dir()]
        files = [each for each in places if each is not None and each.is_file()]
        files += [
            each
            for folder in folders
            if (each := within(self.root, folder, _file_in(folder))) is not None and each.is_file()
        ]
        if not files:
            expected = f"a model in {self.root} ({RULE}): its file, or a folder with {_MODEL}"
            found = f"an include of {shown(uri)}, which is not in the project" if uri else "no uri"
            refuse(at, "//include/uri", found, expected, "<uri>model://hand</uri>")
        return files[0]

    def _folders(self, path: Path) -> Iterator[Path]:
        for folder in path.absolute().parents:
            if not folder.resolve().is_relative_to(self.root):
                break
            yield folder


def _file_in(folder: Path) -> str:
    """Return the name of the newest model file in a model's folder, as its manifest states it."""
    config = folder / _CONFIG
    stated = ""
    if config.is_file():
        root = parse_plain(read_old_text(config, 1)[0], str(config))
        stated = next((each.text or "" for each in reversed(root.findall("sdf"))), "").strip()
    return stated or _MODEL
