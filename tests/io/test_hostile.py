"""Files that mean harm: each is refused in words, soon, and nothing else is opened."""

from __future__ import annotations

import os
import sys
import time

import pytest
from lxml import etree

from lostmotion.io import read
from tests.io.conftest import JOINT, mistakes
from tests.io.test_urdf import ROBOT

LINK = 'link = { length = "1 m", section = { kind = "rod", diameter = "9 mm" }, material = "m" }\n'
NINES = "9" * 900
HIDDEN = "words of another file"
LAUGHS = (
    "<!DOCTYPE robot ["
    '<!ENTITY a0 "ha">'
    + "".join(f'<!ENTITY a{k} "{f"&a{k - 1};" * 10}">' for k in range(1, 10))
    + "]>"
)


def with_type(declaration, name="r"):
    """Put a document type before a robot whose name uses an entity."""
    return (declaration + ROBOT.replace('name="r"', f'name="{name}"')).encode()


def model(parts):
    """Return an SDF file."""
    return f'<sdf version="1.9"><model name="m">{parts}</model></sdf>'.encode()


def pin(name, parent, child):
    """Return a joint of an SDF file."""
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    return f'<joint name="{name}" type="revolute">{ends}</joint>'


def dangling(count):
    """Return a URDF whose joints all name links that nearly exist."""
    body = "".join(
        (
            f'<link name="link_number_{k}"/><joint name="j{k}" type="continuous"><parent '
            f'link="lnik_number_{k}"/><child link="link_nubmer_{k}"/></joint>'
        )
        for k in range(count)
    )
    return f'<robot name="r">{body}</robot>'.encode()


def astray(joints, parts):
    """Return a TOML whose joints all name parts that nearly exist."""
    body = "".join(
        JOINT.replace('"A"', f'"A{k}"') + f'gearbox = "geabrox_number_{k}"\n' for k in range(joints)
    )
    return (
        f'name = "x"\n{body}'
        + "".join(f"[gearboxes.gearbox_number_{k}]\nratio = 3\n" for k in range(parts))
    ).encode()


def shared(part):
    """Return a TOML whose 64 joints all use one part."""
    return (
        'name = "x"\n'
        + "".join(JOINT.replace('"A"', f'"A{k}"') + 'gearbox = "g"\n' for k in range(64))
        + "[gearboxes.g]\n"
        + part
    ).encode()


XML = {
    "300 dangling joints": dangling(300),
    "3000 dangling joints": dangling(3000),
    "1000 words for one number": ROBOT.replace('value="2"', f'value="{"9 " * 500_000}"').encode(),
    "a name of 1 MB": ROBOT.replace('"one"', f'"{"o" * 1_000_000}"').encode(),
    "billion laughs": with_type(LAUGHS, "&a9;"),
    "external entity": with_type('<!DOCTYPE robot [<!ENTITY x SYSTEM "secret.txt">]>', "&x;"),
    "entity in the text": with_type('<!DOCTYPE robot [<!ENTITY x SYSTEM "secret.txt">]>').replace(
        b"</robot>", b"&x;</robot>"
    ),
    "external type": with_type('<!DOCTYPE robot SYSTEM "secret.txt">'),
    "parameter entity": with_type('<!DOCTYPE robot [<!ENTITY % x SYSTEM "secret.txt"> %x;]>'),
    "network": with_type('<!DOCTYPE robot SYSTEM "http://127.0.0.1:9/x.dtd">'),
    "type behind a comment": b"<!-- " + b"x" * 100_000 + b" -->" + with_type(LAUGHS, "&a9;"),
    "entity without a type": ROBOT.replace('"r"', '"&x;"').encode(),
    "another encoding": b'<?xml version="1.0" encoding="UTF-7"?>+ADwAIQ-DOCTYPE robot+AD4-'
    + ROBOT.encode(),
    "utf-16": ROBOT.encode("utf-16"),
    "nested 100 000 deep": b"<robot>" * 100_000,
    "100 000 links": b"<robot>"
    + b"".join(b'<link name="l%d"/>' % k for k in range(100_000))
    + b"</robot>",
    "a chain of 10 000": b'<robot><link name="l0"/>'
    + b"".join(
        b'<link name="l%d"/><joint name="j%d" type="continuous"><parent link="l%d"/><child link="l%d"/></joint>'
        % (k, k, k - 1, k)
        for k in range(1, 10_000)
    )
    + b"</robot>",
    "an entity behind a repair": b'<?xml version="0.0"?>'
    + ROBOT.replace("</robot>", "<drake:tag/>&x;</robot>").encode(),
    "Latin-1 with a type": b"<!-- \xff -->" + with_type('<!DOCTYPE robot SYSTEM "secret.txt">'),
    "300 000 declarations": b'<?xml version="1.0"?>' * 230_000 + b"<robot>&x;</robot>",
    "comments without end": b"<robot>" + b"<!--" * 1_200_000 + b"</robot>",
    "300 000 prefixes": b"<robot>"
    + b"".join(b"<p%d:b/>" % k for k in range(300_000))
    + b"</robot>",
    "no XML": b"\x7fELF" + bytes(range(1, 128)),
    "empty": b"",
}
TOML = {
    "300 joints astray": astray(300, 300),
    "3000 joints astray": astray(3000, 3000),
    "64 joints astray among 3000 parts": astray(64, 3000),
    "64 joints of one name": b'name = "x"\n' + JOINT.encode() * 64,
    "10 000 joints of one name": b'name = "x"\n' + JOINT.encode() * 10_000,
    "60 000 unknown keys": (
        f'name = "x"\n{JOINT}' + "".join(f"k{k} = 1\n" for k in range(60_000))
    ).encode(),
    "15 000 unknown keys": (
        f'name = "x"\n{JOINT}' + "".join(f"k{k} = 1\n" for k in range(15_000))
    ).encode(),
    "unknown keys in a row": (
        f'name = "x"\n{JOINT}[joints.dh]\n' + "".join(f"k{k} = 1\n" for k in range(60_000))
    ).encode(),
    "unknown keys that all share": shared("".join(f"k{k} = 1\n" for k in range(60_000))),
    "fewer unknown keys that all share": shared("".join(f"k{k} = 1\n" for k in range(250))),
    "lists that all share": shared("stiffness = [" + "true,\n" * 90_000 + "]\n"),
    "20 000 unknown reducers": (
        'name = "x"\n'
        + JOINT
        + "".join(f'[gearboxes.g{k}]\ncatalogue = "RV-41X{k}"\n' for k in range(20_000))
    ).encode(),
    "100 000 notes": b'name = "x"\nnotes = [' + b"1,\n" * 100_000 + b"]\n" + JOINT.encode(),
    "an integer beyond every float": (
        f'name = "x"\ngravity = {NINES}\n{JOINT}gearbox = {{ catalogue = "RV-40E", ratio = {NINES} '
        f"}}\n"
    ).encode(),
    "nested 100 000 deep": b"a = " + b"[" * 100_000,
    "tables 100 000 deep": b"a = " + b"{a=" * 100_000,
    "deep over many lines": b"a = " + b"[\n" * 100_000,
    "deep but sound": b"a = " + b"[" * 100 + b"]" * 100,
    "dotted keys": b"".join(b"b%d." % k + b".".join([b"a"] * 480) + b" = 1\n" for k in range(300)),
    "one dotted key": b".".join([b"a"] * 400_000) + b" = 1\n",
    "a giant integer": b"a = " + b"9" * 900,
    "a number of 100 000 digits": b"a = " + b"9" * 100_000,
    "a number over lines": b"a = [" + b"9,\n" * 100_000 + b"]",
    "a million numbers": b"a = [" + b"1," * 1_000_000 + b"]",
    "300 000 numbers": b"a = [" + b"1," * 299_000 + b"]",
    "300 000 tables named by a number": b"[[1]]\n" * 300_000,
    "a million blanks before a word": b"a = " + b" " * 1_000_000 + b",x",
    "rows of numbers before a word": b"a = [" + b"1.5e-3, " * 200_000 + b"x]",
    "escape codes": b'"\\u001b[31mred\\u0007" = "\\u001b[31m"',
    "unclosed": b'a = """' + b"x\n" * 10_000,
    "empty": b"",
}
SDF = {
    "external entity": XML["external entity"].replace(b"robot", b"sdf"),
    "a billion laughs": (LAUGHS.replace("robot", "sdf") + "<sdf>&a9;</sdf>").encode(),
    "another file as base": model(
        '<link name="a" xml:base="secret.txt"/><include><uri>../secret.txt</uri></include>'
    ),
    "an include of a device": model("<include><uri>file:///dev/zero</uri></include>"),
    "2 000 links": model("".join(f'<link name="a{k}"/>' for k in range(2000))),
    "1 000 joints in a row of one link": model(
        '<link name="a"/>' + "".join(pin(f"j{k}", "a", "a") for k in range(990))
    ),
    "a circle of 900 frames": model(
        "".join(f'<frame name="f{k}" attached_to="f{(k + 1) % 900}"/>' for k in range(900))
    ),
    "a chain of 900 frames": model(
        '<link name="a"/>'
        + "".join(f'<frame name="f{k}" attached_to="f{k + 1}"/>' for k in range(900))
        + '<frame name="f900" attached_to="a"/>'
    ),
    "a ladder of 300 loops": model(
        "".join(f'<link name="a{k}"/><joint name="b{k}" type="fixed"/>' for k in range(300))
        + "".join(pin(f"{side}{k}", f"a{k}", f"a{k + 1}") for side in "jkl" for k in range(130))
    ),
    "models 200 deep": model('<model name="m">' * 200 + "</model>" * 200),
}
BYTES = {
    "not UTF-8": b'name = "\xff\xfe"',
    "NUL": b'name = "x\x00y"',
    "10 MB": b"# " + b"x" * 10_000_000,
}
FILES = (
    [pytest.param("arm.urdf", raw, id=f"urdf: {name}") for name, raw in {**XML, **BYTES}.items()]
    + [pytest.param("arm.toml", raw, id=f"toml: {name}") for name, raw in {**TOML, **BYTES}.items()]
    + [pytest.param("arm.xml", XML["external entity"], id="xml: external entity")]
    + [pytest.param("arm.sdf", raw, id=f"sdf: {name}") for name, raw in SDF.items()]
)

_opened: list[str] | None = None


def _note_opened(event, arguments):
    if event == "open" and _opened is not None:
        _opened.append(str(arguments[0]))


sys.addaudithook(_note_opened)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Work in a folder that holds a secret; all files opened from Python are noted."""
    (tmp_path / "secret.txt").write_text(HIDDEN, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(("name", "raw"), FILES)
def test_a_hostile_file_is_refused_and_opens_no_other(folder, name, raw):
    """Whatever it holds: an InputError in words, in seconds, without a control character and
    without another file's text.
    """
    global _opened  # noqa: PLW0603 - an audit hook cannot be removed, only disabled
    path = folder / name
    path.write_bytes(raw)
    began = time.monotonic()
    _opened = []
    try:
        found = mistakes(path)
        opened = {entry for entry in _opened if entry.startswith(str(folder))}
    finally:
        _opened = None
    assert time.monotonic() - began < 20
    assert opened == {str(path)}
    text = "".join(map(str, found))
    assert HIDDEN not in text
    assert all(char.isprintable() or char == "\n" for char in text)
    assert len(text) < 50_000


@pytest.mark.parametrize(
    ("name", "raw"), [("arm.urdf", dangling(300)), ("arm.toml", astray(64, 3000))]
)
def test_many_mistakes_are_cut_short_soon(folder, name, raw):
    """At most fifty are reported, the last line states that there are more, and it takes no
    time.
    """
    (folder / name).write_bytes(raw)
    began = time.monotonic()
    found = mistakes(folder / name)
    assert time.monotonic() - began < 5
    assert len(found) == 51
    assert found[-1].key == "and more"
    assert all(problem.nearest for problem in found[:50])


@pytest.mark.parametrize("escape", ["\\u001b[31m", "\\n", "\\u0007", "\\u009b31m", "\\u202e"])
@pytest.mark.parametrize(
    ("text", "key"),
    [
        (f'name = "a!"\n{JOINT}', "name"),
        (f'name = "x"\nnotes = ["fine", "a!"]\n{JOINT}', "notes[1]"),
        (f'name = "x"\n{JOINT}gearbox = {{ model = "a!" }}\n', "joints.A.gearbox.model"),
        (
            (
                'name = "x"\n[materials.m]\nyoung = "1 GPa"\npoisson = 0.1\ndensity = "9 kg/m^3"\n'
                f'source = "a!"\n{JOINT}{LINK}'
            ),
            "materials.m.source",
        ),
        (f'name = "x"\n{JOINT.replace("A", "a!")}', "joints"),
    ],
)
def test_what_a_terminal_would_obey_is_refused(mistakes_in, text, key, escape):
    """Escape codes, bells and line breaks reach no screen, neither as a name nor in the words that
    refuse them.
    """
    found = mistakes_in(text.replace("!", escape))
    assert all(name.startswith(key) for name in found)
    assert all(
        char.isprintable() or char == "\n" for problem in found.values() for char in str(problem)
    )


def test_text_that_fills_a_screen_is_refused(mistakes_in):
    """Names and notes are bounded in length and number."""
    assert "at most 80" in mistakes_in(f'name = "{"x" * 81}"\n{JOINT}')["name"].expected
    assert (
        "at most 300"
        in mistakes_in(f'name = "x"\nnotes = ["{"x" * 301}"]\n{JOINT}')["notes[0]"].expected
    )
    assert (
        "at most 200"
        in mistakes_in('name = "x"\nnotes = [' + '"x",\n' * 201 + f"]\n{JOINT}")["notes"].expected
    )


@pytest.mark.parametrize("escape", ["&#10;", "&#155;31m", "&#x202e;"])
def test_what_a_terminal_would_obey_leaves_no_urdf(folder, escape):
    """Names of links and joints are refused with their line; the robot's own is cleaned."""
    path = folder / "arm.urdf"
    for name in ("one", "a"):
        path.write_text(ROBOT.replace(f'"{name}"', f'"{name}{escape}"'), encoding="utf-8")
        found = mistakes(path)
        assert {problem.key for problem in found} <= {"/robot/link/@name", "/robot/joint/@name"}
        assert all(char.isprintable() or char == "\n" for problem in found for char in str(problem))
    path.write_text(ROBOT.replace('"r"', f'"r{escape}"'), encoding="utf-8")
    assert read(path).name.startswith("r?")


@pytest.mark.parametrize(
    "name",
    [
        "billion laughs",
        "external entity",
        "external type",
        "parameter entity",
        "type behind a comment",
    ],
)
def test_a_document_type_meets_no_parser(folder, name, monkeypatch):
    """It is refused in the text, with its line, before anything could be expanded."""
    monkeypatch.setattr(etree, "fromstring", None)
    (folder / "arm.urdf").write_bytes(b"\n\n" + XML[name])
    (found,) = mistakes(folder / "arm.urdf")
    assert "DOCTYPE" in found.found
    assert found.file.endswith(":3")


def test_a_giant_meets_no_parser(folder, monkeypatch):
    """Ten megabytes of sound URDF are refused by size alone."""
    monkeypatch.setattr(etree, "fromstring", None)
    (folder / "arm.urdf").write_bytes(ROBOT.encode() + b" " * 10_000_000)
    assert mistakes(folder / "arm.urdf")[0].found == "more than 5 MB"


@pytest.mark.parametrize("name", ["arm.toml", "arm.urdf"])
def test_what_is_no_file_is_not_opened(folder, name):
    """Loops of links, pipes that would wait for ever, devices without end, and names with a NUL."""
    (folder / name).symlink_to(folder / name)
    mistakes(folder / name)
    (folder / name).unlink()
    os.mkfifo(folder / name)
    assert mistakes(folder / name)[0].found == "no regular file"
    (folder / name).unlink()
    (folder / name).symlink_to("/dev/zero")
    assert mistakes(folder / name)[0].found == "no regular file"
    mistakes(folder / f"a\0{name}")


def test_a_sidecar_that_loops_is_reported(folder):
    """A link beside the URDF that leads to itself is a mistake, not a missing sidecar."""
    (folder / "arm.urdf").write_text(ROBOT, encoding="utf-8")
    (folder / "arm.toml").symlink_to("arm.toml")
    assert mistakes(folder / "arm.urdf")[0].file.endswith("arm.toml")


def test_meshes_and_includes_are_never_opened(folder):
    """A URDF that names other files is read without them."""
    global _opened  # noqa: PLW0603 - as above
    mesh = '<visual><geometry><mesh filename="file://secret.txt"/></geometry></visual>'
    mesh += '<x:include xmlns:x="http://www.w3.org/2001/XInclude" href="secret.txt"/>'
    path = folder / "arm.urdf"
    path.write_text(
        ROBOT.replace('<link name="base"/>', f'<link name="base">{mesh}</link>'), encoding="utf-8"
    )
    _opened = []
    try:
        assert read(path).moving
        opened = {entry for entry in _opened if entry.startswith(str(folder))}
    finally:
        _opened = None
    assert opened == {str(path)}
