"""Files that mean harm: each is refused in words, soon, and nothing else is opened."""

from __future__ import annotations

import os
import sys
import time

import pytest
from lxml import etree

from tests.formats.conftest import mistakes
from tests.formats.test_urdf import ROBOT

HIDDEN = "words of another file"
LAUGHS = "<!DOCTYPE robot [" + '<!ENTITY a0 "ha">' + "".join(f'<!ENTITY a{k} "{f"&a{k - 1};" * 10}">' for k in range(1, 10)) + "]>"


def with_type(declaration, name="r"):
    """Put a document type before a robot whose name uses an entity."""
    return (declaration + ROBOT.replace('name="r"', f'name="{name}"')).encode()


XML = {
    "billion laughs": with_type(LAUGHS, "&a9;"),
    "external entity": with_type('<!DOCTYPE robot [<!ENTITY x SYSTEM "secret.txt">]>', "&x;"),
    "entity in the text": with_type('<!DOCTYPE robot [<!ENTITY x SYSTEM "secret.txt">]>').replace(b"</robot>", b"&x;</robot>"),
    "external type": with_type('<!DOCTYPE robot SYSTEM "secret.txt">'),
    "parameter entity": with_type('<!DOCTYPE robot [<!ENTITY % x SYSTEM "secret.txt"> %x;]>'),
    "network": with_type('<!DOCTYPE robot SYSTEM "http://127.0.0.1:9/x.dtd">'),
    "type behind a comment": b"<!-- " + b"x" * 100_000 + b" -->" + with_type(LAUGHS, "&a9;"),
    "entity without a type": ROBOT.replace('"r"', '"&x;"').encode(),
    "another encoding": b'<?xml version="1.0" encoding="UTF-7"?>+ADwAIQ-DOCTYPE robot+AD4-' + ROBOT.encode(),
    "utf-16": ROBOT.encode("utf-16"),
    "nested 100 000 deep": b"<robot>" * 100_000,
    "100 000 links": b"<robot>" + b"".join(b'<link name="l%d"/>' % k for k in range(100_000)) + b"</robot>",
    "a chain of 10 000": b'<robot><link name="l0"/>'
    + b"".join(
        b'<link name="l%d"/><joint name="j%d" type="continuous"><parent link="l%d"/><child link="l%d"/></joint>' % (k, k, k - 1, k)
        for k in range(1, 10_000)
    )
    + b"</robot>",
    "no XML": b"\x7fELF" + bytes(range(1, 128)),
    "empty": b"",
}
TOML = {
    "nested 100 000 deep": b"a = " + b"[" * 100_000,
    "tables 100 000 deep": b"a = " + b"{a=" * 100_000,
    "deep over many lines": b"a = " + b"[\n" * 100_000,
    "deep but sound": b"a = " + b"[" * 100 + b"]" * 100,
    "dotted keys": b"".join(b"b%d." % k + b".".join([b"a"] * 480) + b" = 1\n" for k in range(300)),
    "one dotted key": b".".join([b"a"] * 400_000) + b" = 1\n",
    "a giant integer": b"a = " + b"9" * 900,
    "a number of 100 000 digits": b"a = " + b"9" * 100_000,
    "a number over lines": b"a = [" + b"9,\n" * 100_000 + b"]",
    "escape codes": b'"\\u001b[31mred\\u0007" = "\\u001b[31m"',
    "unclosed": b'a = """' + b"x\n" * 10_000,
    "empty": b"",
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
    """Whatever it holds: an InputError in words, in seconds, without a control character and without another file's text."""
    global _opened  # noqa: PLW0603 - an audit hook cannot be taken away, only be told to rest
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


@pytest.mark.parametrize("name", ["billion laughs", "external entity", "external type", "parameter entity", "type behind a comment"])
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


def test_a_sidecar_that_loops_is_told(folder):
    """A link beside the URDF that leads to itself is a mistake, not a missing sidecar."""
    (folder / "arm.urdf").write_text(ROBOT, encoding="utf-8")
    (folder / "arm.toml").symlink_to("arm.toml")
    assert mistakes(folder / "arm.urdf")[0].file.endswith("arm.toml")


def test_meshes_and_includes_are_never_opened(folder):
    """A URDF that names other files is read without them."""
    from lostmotion.formats import read

    global _opened  # noqa: PLW0603 - as above
    mesh = '<visual><geometry><mesh filename="file://secret.txt"/></geometry></visual>'
    mesh += '<x:include xmlns:x="http://www.w3.org/2001/XInclude" href="secret.txt"/>'
    path = folder / "arm.urdf"
    path.write_text(ROBOT.replace('<link name="base"/>', f'<link name="base">{mesh}</link>'), encoding="utf-8")
    _opened = []
    try:
        assert read(path).moving
        opened = {entry for entry in _opened if entry.startswith(str(folder))}
    finally:
        _opened = None
    assert opened == {str(path)}
