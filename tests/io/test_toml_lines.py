"""Every mistake in a TOML file is reported with the line on which it stands."""

from __future__ import annotations

import tomllib

import pytest

import lostmotion
from lostmotion.errors import InputError
from lostmotion.io.arm_templates import template_text
from lostmotion.io.toml_lines import key_lines
from tests.io.conftest import EXAMPLES, mistakes

ODD = '''
a = """one
two = 2
"""
'b.c' = [ # a list = over lines
  1,
  { d = "x # no comment", e = [[1.5,
     2.5], []] }, 1979-05-27T07:32:00Z ]
f.g."h\\"i" = \'\'\'
[not.a.table]\'\'\'

[[list]]
k = 1
[list.inner]
k = { x = 1, y.z = 2 }
[[list.inner.deep]]
k = "quoted \\" bracket ]"
[[list]]
k = 2
[ "table" . t ]
k = -1.5e3
'''


def _paths(tree, path=()):
    """Return every key and list entry of a tree."""
    items = (
        tree.items()
        if isinstance(tree, dict)
        else enumerate(tree)
        if isinstance(tree, list)
        else ()
    )
    return [
        inner for step, value in items for inner in [(*path, step), *_paths(value, (*path, step))]
    ]


@pytest.mark.parametrize(
    "text",
    [ODD, *(path.read_text("utf-8") for path in sorted(EXAMPLES.rglob("*.toml")))],
    ids=lambda text: text[:20],
)
def test_each_key_of_a_file_has_the_line_on_which_it_stands(text):
    """Python's own parser finds the same keys and entries, each key is written on its line, and
    lines never decrease within a table.
    """
    lines = key_lines(text)
    rows = text.split("\n")
    assert set(lines) == set(_paths(tomllib.loads(text)))
    for path, line in lines.items():
        if isinstance(path[-1], str):
            assert path[-1].split('"')[0] in rows[line - 1]


def test_the_lines_of_a_text_with_every_kind_of_value_are_known():
    """Counted by hand, over strings and lists of several lines."""
    lines = key_lines(ODD)
    found = [
        lines[path]
        for path in (
            ("a",),
            ("b.c",),
            ("b.c", 0),
            ("b.c", 1, "e", 0, 1),
            ("f", "g", 'h"i'),
            ("list", 0, "inner", "k", "y", "z"),
            ("list", 1, "k"),
        )
    ]
    assert found == [2, 5, 6, 8, 9, 15, 19]


BAD = """name = "x"

[payload]
mass = "5 m"

[gearboxes.drive]
backlash = "1 kg"
stifness = "3 N m/arcmin"

[[joints]]
name = "A"
type = "revolute"
limits = [
    "-90 deg", # no mistake here
    "4 kg",
]
gearbox = "drive"
link = { length = "400 mm", wide = 3 }

[[joints]]
type = "revolute"
limits = ["0 deg", "1 deg"]
bearing = "none"
"""


def test_every_mistake_of_an_arm_names_file_and_line(tmp_path):
    """Wrong values and unknown keys on their own line, a missing key on that of its table; all in
    the order of the lines.
    """
    path = tmp_path / "arm.toml"
    path.write_text(BAD, "utf-8")
    found = {problem.key: problem.file for problem in mistakes(path)}
    expected = {
        "payload.mass": 4,
        "gearboxes.drive.backlash": 7,
        "gearboxes.drive.stifness": 8,
        "joints.A.limits[1]": 15,
        "joints.A.link.wide": 18,
        "joints[1].name": 20,
        "joints[1].bearing": 23,
    }
    assert list(found.items()) == [(key, f"{path}:{line}") for key, line in expected.items()]


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ('name = "x"\njoints = 3 mm\n', 2),
        ('name = "x"\n\n[joints\n', 3),
        ('name = "x"\njoints = [\n', 2),
        ('name = "x"\nnotes = ["a\0"]\n', 2),
        ('name = "x"\n# ' + "9" * 2000, 2),
    ],
)
def test_text_that_is_not_toml_names_the_line_where_reading_stopped(tmp_path, text, line):
    """Also where the file ends too early, or holds what no text holds."""
    path = tmp_path / "arm.toml"
    path.write_text(text, "utf-8")
    assert [problem.file for problem in mistakes(path)] == [f"{path}:{line}"]


def test_mistakes_in_a_sidecar_a_part_and_a_request_name_their_lines(tmp_path):
    """Each in the file in which it stands."""
    sidecar = tmp_path / "side.toml"
    sidecar.write_text('tip = "tool0"\n[joints.elbow_joint]\nmass = "3 kg"\n', "utf-8")
    assert [problem.file for problem in mistakes(EXAMPLES / "ur5e.urdf", sidecar)] == [
        f"{sidecar}:3"
    ]
    part = tmp_path / "gear.toml"
    part.write_text('[gearbox]\nratio = 100\nbacklash = "3 kg"\n', "utf-8")
    sizing = tmp_path / "sizing.toml"
    sizing.write_text('[sizing]\n\ntarget = "1 kg"\n', "utf-8")
    for wrong, line, ask in (
        (part, 3, lambda: lostmotion.gear(part)),
        (sizing, 3, lambda: lostmotion.size(EXAMPLES / "z-arm.toml", sizing)),
    ):
        with pytest.raises(InputError) as caught:
            ask()
        assert [problem.file for problem in caught.value.problems] == [f"{wrong}:{line}"]


def test_a_loop_of_a_leg_names_the_line_that_joins_it(tmp_path):
    """Whichever copy cannot close."""
    text = template_text("delta").replace('"350 mm ± 50 µm"', '"30 mm"')
    path = tmp_path / "delta.toml"
    path.write_text(text, "utf-8")
    with pytest.raises(InputError) as refused:
        lostmotion.read(path)
    (problem,) = refused.value.problems
    assert "apart at home" in problem.found
    lines = text.split("\n")
    (joins,) = (k for k, line in enumerate(lines, 1) if line.startswith("joins = "))
    assert problem.file == f"{path}:{joins}"
