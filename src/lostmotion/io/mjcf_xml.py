"""The XML of an MJCF file (MuJoCo), reduced to what its bodies, joints and masses follow from, so
that its compiler reads no other file.

Includes are put in, from the folder of the project (`project_root`) and those in it. Textures,
materials, actuators, sensors and the like are omitted, and so are the shapes of bodies that state
their mass by `inertial`. A mesh is needed where a body's mass is computed from it, and must be in
that folder too.
"""

from __future__ import annotations

import math
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Final

from lxml import etree

from lostmotion.errors import shown
from lostmotion.io.project_root import RULE, within
from lostmotion.io.sidecar import sidecar_place
from lostmotion.io.text import numbers, read_old_text, refuse
from lostmotion.io.urdf_xml import line_of, parse_plain

if TYPE_CHECKING:
    from collections.abc import Iterator

MEGABYTES: Final = 5
_MOST_INCLUDES: Final = 50
_MOST_MESHES: Final = 100
_LARGEST_MESH: Final = 20_000_000
_EARTH: Final = (0.0, 0.0, -9.81)
_NEARLY: Final = 0.05  # m/s²
_SECTIONS: Final = frozenset({"compiler", "default", "asset", "worldbody", "equality"})
_KEPT: Final = {
    "default": frozenset({"default", "joint", "geom", "site", "mesh", "equality"}),
    "asset": frozenset({"mesh"}),
    "worldbody": frozenset(
        {"body", "frame", "replicate", "joint", "freejoint", "geom", "site", "inertial"}
    ),
    "equality": frozenset({"connect", "weld", "joint"}),
}
# Omitted, and what they do to the arm is missing.
_FORCES: Final = ("tendon", "composite", "flexcomp", "plugin")
# Attributes of the compiler that name folders, or drop bodies and shapes.
_OF_COMPILER: Final = (
    "meshdir",
    "texturedir",
    "assetdir",
    "strippath",
    "fusestatic",
    "discardvisual",
)


@dataclass(frozen=True, slots=True)
class Model:
    """A model that needs no other file than its meshes.

    meshes  the file of each, by its name in the XML
    notes   what was omitted
    lines   of the joints in the file itself, by name
    driven  names of the joints that an actuator moves
    """

    name: str
    xml: str
    meshes: dict[str, Path]
    notes: list[str]
    lines: dict[str, int]
    driven: frozenset[str]


def self_contained(path: Path, text: str, folder: Path) -> Model:
    """Return what counts of an MJCF file, which may name files within a folder.

    Raises InputError for includes and meshes that are missing or elsewhere, and for attached
    models.
    """
    root = parse_plain(text, str(path))
    lines = {
        name: line_of(joint)
        for joint in root.iter("joint", "freejoint")
        if (name := joint.get("name"))
    }
    _Includes(path, folder).put_in(root, str(path))
    gravity = [
        each.get("gravity", "") for each in root.iterchildren("option") if "gravity" in each.attrib
    ]
    compiler = {
        str(key): str(value)
        for each in root.iterchildren("compiler")
        for key, value in each.attrib.items()
    }
    driven = frozenset(
        each.get(key, "")
        for section in root.iterchildren("actuator")
        for each in section
        for key in ("joint", "jointinparent")
    )
    notes = [*_reduce(root, str(path)), *_of_gravity(gravity)]
    if compiler.get("inertiafromgeom") != "true":
        _drop_shapes(root)
    meshes = _meshes(root, path, compiler, folder)
    for each in root.iterchildren("compiler"):
        _take(each, *_OF_COMPILER)
    for element in root.iter():
        if "file" in element.attrib and (
            element.tag != "mesh" or element.get("file") not in meshes
        ):
            refuse(
                _at(path, element),
                "",
                f"a file named by <{element.tag}>",
                "files named by include and by meshes of asset only",
                '<mesh file="link.stl"/>',
            )
    return Model(
        root.get("model", ""),
        etree.tostring(root, encoding="unicode"),
        meshes,
        notes,
        lines,
        driven,
    )


def _of_gravity(stated: list[str]) -> list[str]:
    """Return a note on a gravity that is not that of the earth, along -z."""
    for text in stated[-1:]:
        with suppress(ValueError):
            if math.dist(numbers(text.split()), _EARTH) > _NEARLY:
                return [
                    (
                        f"not carried over: the gravity of the file, {shown(text)} m/s²; gravity "
                        "and the tilt of the base are stated in the sidecar"
                    )
                ]
    return []


class _Includes:
    """Put the children of included files in the place of `include`, each file once."""

    def __init__(self, path: Path, root: Path) -> None:
        self.path, self.root = path, root
        self.seen: set[Path] = set()

    def put_in(self, root: etree._Element, file: str) -> None:
        """Replace every `include` below this element, which stands in `file`."""
        for include in list(root.iter("include")):
            stated = include.get("file", "")
            # As MuJoCo: beside the model, else beside the file that includes it.
            places = [
                each
                for other in (self.path, Path(file))
                if (each := within(self.root, other.parent, stated)) is not None
            ]
            inside = next((each for each in places if each.is_file()), None)
            place = f"{file}:{line_of(include)}"
            if inside is None:
                expected = f"a file in {self.root}: {RULE}; {_another(self.path, stated)}"
                why = "which is not there" if places else "which is outside the project"
                refuse(
                    place,
                    "",
                    f"an include of {shown(stated)}, {why}",
                    expected,
                    '<include file="arm.xml"/>',
                )
            if inside.resolve() in self.seen or len(self.seen) >= _MOST_INCLUDES:
                refuse(
                    place,
                    "",
                    f"{shown(stated)} included twice, or too many includes",
                    f"each file once, at most {_MOST_INCLUDES}",
                    "one file",
                )
            self.seen.add(inside.resolve())
            other = parse_plain(read_old_text(inside, MEGABYTES)[0], str(inside))
            self.put_in(other, str(inside))
            parent = include.getparent()
            if parent is not None:
                at = parent.index(include)
                parent[at : at + 1] = list(other)


def _reduce(root: etree._Element, file: str) -> list[str]:
    """Drop whatever bodies, joints and masses do not follow from; return notes on the parts whose
    effect is missing.
    """
    dropped: Counter[str] = Counter()
    for section in list(root):
        if section.tag not in _SECTIONS:
            dropped[str(section.tag)] += len(section)
            root.remove(section)
            continue
        for element in [each for each in section.iterdescendants() if each.getparent() is not None]:
            kept = _KEPT.get(str(section.tag), frozenset())
            if element.tag in {"attach", "model"}:
                expected = (
                    "one file, or files put together by include; MuJoCo writes one by "
                    "mj_saveLastXML"
                )
                refuse(
                    f"{file}:{line_of(element)}",
                    "",
                    f"a model attached from another file (<{element.tag}>)",
                    expected,
                    '<include file="arm.xml"/>',
                )
            if element.tag not in kept or "hfield" in element.attrib:
                dropped[str(element.tag)] += 1
                _drop(element)
            _take(element, "material")
    forces = ", ".join(_counted(name, dropped) for name in _FORCES if dropped[name])
    out = (
        [f"not carried over: {forces}; their weight and their forces are missing"] if forces else []
    )
    return (
        [
            *out,
            f"not carried over: {_counted('actuator', dropped)}; drives are stated in the sidecar",
        ]
        if dropped["actuator"]
        else out
    )


def _counted(name: str, counts: Counter[str]) -> str:
    return f"{counts[name]} {name}{'s' * (counts[name] != 1)}"


def _drop_shapes(root: etree._Element) -> None:
    """Drop the shapes of all bodies whose mass is stated, and those of the world, which weigh on
    nothing.
    """
    for body in [*root.iter("body"), *root.iterchildren("worldbody")]:
        own = list(_own(body))
        if body.tag == "worldbody" or any(each.tag == "inertial" for each in own):
            for geom in (each for each in own if each.tag == "geom"):
                _drop(geom)


def _own(body: etree._Element) -> Iterator[etree._Element]:
    """Yield the elements of a body, also those in frames of it, without the bodies in it."""
    for child in body:
        if child.tag != "body":
            yield child
            yield from _own(child)


def _another(path: Path, stated: str) -> str:
    """Return the line of the sidecar that names the folder in which a file lies that a description
    names by its path.
    """
    up = "/".join([".."] * max(PurePosixPath(stated).parts.count(".."), 1))
    return f'root = "{up}" in {sidecar_place(path).name} names another folder above'


def _meshes(
    root: etree._Element, path: Path, compiler: dict[str, str], project: Path
) -> dict[str, Path]:
    """Keep the meshes that shapes use, under plain names; return the file of each. Raises
    InputError for the first that is not there.
    """
    used = {geom.get("mesh", "") for geom in root.iter("geom")}
    out: dict[str, Path] = {}
    folder = PurePosixPath(compiler.get("meshdir", compiler.get("assetdir", "")))
    for mesh in [each for section in root.iterchildren("asset") for each in section.iter("mesh")]:
        stated = mesh.get("file", "")
        name = mesh.get("name") or PurePosixPath(stated).stem
        if name not in used:
            _drop(mesh)
            continue
        mesh.set("name", name)
        if not stated:
            continue
        wanted = folder / (
            PurePosixPath(stated).name if compiler.get("strippath") == "true" else stated
        )
        file = within(project, path.parent, str(wanted))
        if (
            file is None
            or not file.is_file()
            or file.stat().st_size > _LARGEST_MESH
            or len(out) >= _MOST_MESHES
        ):
            expected = (
                f"at most {_MOST_MESHES} files in {project}, each of at most "
                f"{_LARGEST_MESH // 10**6} MB, for a body without <inertial> "
            )
            expected += f"has its mass from its meshes; {_another(path, str(wanted))}"
            refuse(
                _at(path, mesh),
                "",
                f"the mesh {shown(str(wanted))}, which is not there or too large",
                expected,
                '<inertial pos="0 0 0.1" mass="2"/>',
            )
        plain = f"mesh{len(out)}{file.suffix}"
        mesh.set("file", plain)
        out[plain] = file
    return out


def _drop(element: etree._Element) -> None:
    parent = element.getparent()
    if parent is not None:
        parent.remove(element)


def _take(element: etree._Element, *keys: str) -> None:
    for key in {*keys} & {*map(str, element.attrib)}:
        del element.attrib[key]


def _at(path: Path, element: etree._Element) -> str:
    return f"{path}:{line_of(element)}"
