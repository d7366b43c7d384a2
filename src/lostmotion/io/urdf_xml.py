"""The XML of a URDF: parsed without entities, network or document types; small faults that other
readers let through are repaired and noted.

The file is taken for hostile: no document type, no entities, no network, bounded depth, and no
other file is ever opened.
"""

from __future__ import annotations

import itertools
import re
from typing import TYPE_CHECKING, Final, NoReturn

from lxml import etree

from lostmotion.errors import shown
from lostmotion.io.text import refuse

if TYPE_CHECKING:
    from collections.abc import Iterator

_DECLARATION: Final = re.compile(r"<\?xml\b[^<>]{0,300}\?>")
_PREFIX: Final = re.compile(r"(?:</?|\s)([A-Za-z_][A-Za-z0-9_.-]{0,40}):(?=[A-Za-z_])")
_VERSION: Final = re.compile(r"""version\s*=\s*["']1\.""")
_MOST_PREFIXES: Final = 30
_MOST_REPAIRS: Final = 10
_FIRST_LETTERS: Final = 1000
_UNDECLARED: Final = "urn:undeclared:"
_XACRO_EXAMPLE: Final = "arm.urdf.xacro: macros are expanded in a file whose name ends in .xacro"
_XACRO_EXPECTED: Final = "a URDF with its macros and properties expanded"
# What xacro only defines: without a use of it nothing in the arm changes.
_DEFINES: Final = ("macro", "property", "arg")
_LEFT_OVER: Final = re.compile(r"\$[{(]")
_ARM: Final = ("link", "joint")
# Parts of links that are never read: shapes and colours.
_SHAPES: Final = ("visual", "collision", "material", "geometry")
# Root elements of other formats: what they are, and what to do next.
_FORMATS: Final = {
    "mujoco": ("MJCF (MuJoCo)", "MJCF from the first letter on, in a file whose name ends in .xml"),
    "mujocoinclude": ("a part of an MJCF model (MuJoCo)", "the model that includes it"),
    "sdf": ("SDF (Gazebo)", "SDF from the first letter on, in a file whose name ends in .sdf"),
    "html": ("a web page", "the URDF itself: download the file by its 'Raw' link"),
    "launch": ("a ROS launch file", "the URDF that it loads"),
    "COLLADA": ("COLLADA, a mesh", "the URDF that names this mesh"),
}


def parse_robot(text: str, file: str) -> tuple[etree._Element, list[str]]:
    """Parse the text of a URDF.

    Parameters
    ----------
    text
        The file's text.
    file
        The file's name, for messages.

    Returns
    -------
    robot
        The root element, without comments and processing instructions.
    notes
        One line for each repair: text before the first tag, XML declarations that are wrong,
        prefixes that are never declared.

    Raises
    ------
    InputError
        For a document type, text that is not XML, macros of xacro that are not expanded, and files
        of another format, which are named.

    """
    page = text[:_FIRST_LETTERS].lower().find("<!doctype html")
    if page >= 0:
        _refuse_format(file, _line_at(text, page), "html")
    robot, notes = parse_leniently(text, file, "robot")
    line = line_of(robot)
    if robot.tag != "robot":
        tag = str(robot.tag)
        if tag in _FORMATS:
            _refuse_format(file, line, tag)
        if tag.startswith("{") and "xacro" in tag:
            _refuse_xacro(file, line, f"the root element {shown(tag.partition('}')[2])}")
        refuse(
            f"{file}:{line}",
            "",
            f"the root element {shown(tag)}",
            "the root element robot",
            '<robot name="arm">',
        )
    notes += _look_for_macros(robot, file)
    return robot, notes


def parse_leniently(text: str, file: str, root: str) -> tuple[etree._Element, list[str]]:
    """Return the root element of XML, by this name where the text is sound, and a note on each
    repair. Raises InputError for a document type, and for what no repair makes XML.
    """
    _refuse_type(text, file)
    notes: list[str] = []
    try:
        element = _parsed(text)
    except etree.XMLSyntaxError as error:
        element, notes = _repaired(text, file, root, error)
    _drop_namespace(element)
    return element, notes


def root_of(text: str) -> str:
    """Return the name of the root element; empty where the text does not begin as XML does, or has
    a document type.
    """
    if "<!DOCTYPE" in text:
        return ""
    parser = etree.XMLPullParser(
        events=("start",), resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False
    )
    try:
        for at in range(0, len(text), _FIRST_LETTERS):
            parser.feed(text[at : at + _FIRST_LETTERS])
            for _, element in parser.read_events():
                return str(getattr(element, "tag", ""))
    except etree.XMLSyntaxError:
        pass
    return ""


def parse_plain(text: str, file: str) -> etree._Element:
    """Return the root element of XML without a document type, comments and processing instructions.
    Nothing is repaired.
    """
    _refuse_type(text, file)
    try:
        return _parsed(text)
    except etree.XMLSyntaxError as error:
        refuse(
            f"{file}:{error.lineno}",
            "",
            shown(error.msg or "no XML", 120)[1:-1],
            "well-formed XML",
            "<mujoco> ... </mujoco>",
        )


def _refuse_type(text: str, file: str) -> None:
    # Looked for in the text itself, and refused in comments too, so that no parser ever meets a
    # document type.
    if "<!DOCTYPE" in text:
        at = text.index("<!DOCTYPE")
        refuse(
            f"{file}:{_line_at(text, at)}",
            "",
            "a document type (<!DOCTYPE)",
            "a file without one",
            '<robot name="arm">',
        )


def refuse_xml(text: str, file: str) -> None:
    """Raise InputError for XML in a TOML's place: another format by its name, a URDF with the
    ending that it needs.
    """
    parse_robot(text, file)
    refuse(
        file,
        "",
        "this is a URDF",
        "a file that ends in .urdf; a TOML of the same name is its sidecar",
        f"{file.removesuffix('.toml')}.urdf",
    )


def line_of(element: etree._Element) -> int:
    """Return the line of an element, 0 where it is unknown."""
    return element.sourceline if isinstance(element.sourceline, int) else 0


def _parsed(text: str) -> etree._Element:
    parser = etree.XMLParser(
        resolve_entities=False,
        no_network=True,
        load_dtd=False,
        huge_tree=False,  # keeps libxml2's own bounds on depth and size
        remove_comments=True,
        remove_pis=True,
        encoding="utf-8",  # whatever the file declares: it was decoded and searched as this
    )
    return etree.fromstring(text.encode(), parser)


def _repaired(
    text: str, file: str, root: str, error: etree.XMLSyntaxError
) -> tuple[etree._Element, list[str]]:
    """Parse the text again after repairs that keep every line where it was; raise the first error
    where they do not help.
    """
    notes: list[str] = []
    first = text.find("<")
    if text[: max(first, 0)].strip():
        notes.append(
            f"line {_line_at(text, len(text) - len(text.lstrip()))}: text before the first tag "
            "is passed over"
        )
    fixed = _blank(text[: max(first, 0)]) + text[max(first, 0) :]
    wrong = [
        match
        for match in itertools.islice(_DECLARATION.finditer(fixed), _MOST_REPAIRS)
        if match.start() or not _VERSION.search(match[0])
    ]
    notes += [
        (
            f"line {_line_at(fixed, match.start())}: an XML declaration that is wrong or not at "
            "the start is passed over"
        )
        for match in wrong
    ]
    fixed = _DECLARATION.sub(lambda match: _blank(match[0]), fixed)
    fixed, odd = _uncommented(fixed)
    notes += [
        f"line {_line_at(fixed, at)}: a comment with -- inside it is passed over"
        for at in odd[:_MOST_REPAIRS]
    ]
    last = f"</{root}>"
    end = fixed.rfind(last) + len(last)
    if end > len(last) and fixed[end:].strip() and "<" not in fixed[end:]:
        notes.append(
            f"line {_line_at(fixed, len(fixed.rstrip()) - 1)}: text after the last tag is "
            "passed over"
        )
        fixed = fixed[:end]
    fixed, undeclared = _declared(fixed, root)
    notes += undeclared
    try:
        return _parsed(fixed), notes
    except etree.XMLSyntaxError as again:
        refuse(
            f"{file}:{again.lineno}",
            "",
            shown(again.msg or error.msg or "no XML", 120)[1:-1],
            "well-formed XML",
            f"<{root} ...> ... </{root}>",
        )


def _uncommented(text: str) -> tuple[str, list[int]]:
    """Blank the comments out, where some hold what no comment may, and return where those begin."""
    out, odd = [], []
    at = 0
    # Not by a pattern: one that looks for an end behind every beginning takes the square of the
    # length where none ends.
    while (begin := text.find("<!--", at)) >= 0 and (end := text.find("-->", begin + 4)) >= 0:
        out += [text[at:begin], _blank(text[begin : end + 3])]
        if "--" in text[begin + 4 : end] or text[end - 1 : end] == "-":
            odd.append(begin)
        at = end + 3
    return ("".join([*out, text[at:]]), odd) if odd else (text, odd)


def _declared(text: str, name: str) -> tuple[str, list[str]]:
    """Declare the prefixes that the root element does not declare; note the first line of each that
    is declared nowhere.
    """
    root = re.search(rf"<{name}(?=[\s>/])[^<>]{{0,5000}}", text)
    if root is None:
        return text, []
    first: dict[str, int] = {}
    for match in _PREFIX.finditer(text):
        if match[1] not in first and len(first) < _MOST_PREFIXES:
            first[match[1]] = match.start(1)
    missing = [
        prefix
        for prefix in first
        if not prefix.lower().startswith("xml") and f"xmlns:{prefix}" not in root[0]
    ]
    at = root.start() + len(f"<{name}")
    declarations = "".join(f' xmlns:{prefix}="{_UNDECLARED}{prefix}"' for prefix in missing)
    notes = [
        (
            f"line {_line_at(text, first[prefix])}: the prefix '{prefix}:' is never declared; its "
            "elements are passed over"
        )
        for prefix in missing
        if f"xmlns:{prefix}" not in text
    ]
    return text[:at] + declarations + text[at:], notes


def _blank(text: str) -> str:
    return re.sub(r"[^\n]", " ", text)


def _line_at(text: str, at: int) -> int:
    return text.count("\n", 0, at) + 1


def _drop_namespace(robot: etree._Element) -> None:
    """Take the default namespace of the root out of the names: URDF has none, and other readers
    ignore one that is declared.
    """
    namespace, mark, _ = str(robot.tag).rpartition("}")
    if mark and "xacro" not in namespace:
        for element in robot.iter():
            element.tag = str(element.tag).removeprefix(namespace + mark)


def _look_for_macros(robot: etree._Element, file: str) -> list[str]:
    """Refuse xacro where it would change the arm; note what is passed over elsewhere."""
    left: list[str] = []
    included: list[str] = []
    for element in _read_parts(robot):
        namespace, _, name = str(element.tag).rpartition("}")
        if "xacro" in namespace and name == "include":
            where = shown(element.get("filename", ""))
            included.append(
                f"line {line_of(element)}: the xacro file {where} is not read; if it adds "
                "links or joints, expand the file with xacro first"
            )
        elif "xacro" in namespace and name not in _DEFINES:
            _refuse_xacro(file, line_of(element), f"the macro {shown(name)}")
        elif "xacro" in namespace:
            left.append(f"line {line_of(element)}")
        elif element.getparent() is not robot or name in _ARM:
            for value in element.attrib.values():
                if _LEFT_OVER.search(str(value)):
                    _refuse_xacro(file, line_of(element), shown(str(value)))
    if left and robot.find("link") is None:
        _refuse_xacro(file, line_of(robot), "definitions of macros, and no link")
    return included[:_MOST_REPAIRS] + (
        [f"{left[0]}: xacro definitions that nothing uses are passed over"] if left else []
    )


def _read_parts(robot: etree._Element) -> Iterator[etree._Element]:
    """Yield the children of the root, and all within links and joints except shapes; not what
    stands in a definition, or in extensions.
    """
    for element in robot:
        yield element
        if element.tag in _ARM:
            waiting = [child for child in element if child.tag not in _SHAPES]
            while waiting:
                inner = waiting.pop()
                yield inner
                waiting += [child for child in inner if child.tag not in _SHAPES]


def _refuse_xacro(file: str, line: int, found: str) -> NoReturn:
    refuse(f"{file}:{line}", "/robot", f"this is xacro: {found}", _XACRO_EXPECTED, _XACRO_EXAMPLE)


def _refuse_format(file: str, line: int, root: str) -> NoReturn:
    name, expected = _FORMATS[root]
    refuse(f"{file}:{line}", "", f"this is {name}", expected, "lostmotion study arm.urdf")
