"""An SRDF beside a URDF names the tool; what it cannot decide stays with names and structure."""

from __future__ import annotations

import pytest

from lostmotion import new
from lostmotion.io import read, srdf
from lostmotion.io.sweep_designs import texts
from tests.io.conftest import mistakes
from tests.io.test_urdf_tip import fixed, sliding, turning, two_arms
from tests.io.test_xacro import HEAD
from tests.io.urdfs import arm, robot

ARM = [*arm(4), *fixed("plate", "link4", 0.2), *fixed("camera_mount", "plate", 0.1)]
CHAIN = '<group name="arm"><chain base_link="base" tip_link="{}"/></group>'
HAND = [
    *fixed("hand", "link4", 0.5),
    *fixed("hand_tcp", "hand"),
    *sliding("s1", "hand", "a"),
    *sliding("s2", "hand", "b"),
]


@pytest.fixture
def written(tmp_path):
    """Return the file of a URDF of these parts with an SRDF beside it."""

    def write(parts, srdf, name="r.srdf", robot_name="r", urdf="r.urdf"):
        path = tmp_path / urdf
        path.write_text(robot(*parts), encoding="utf-8")
        (tmp_path / name).write_text(
            f'<?xml version="1.0"?>\n<robot name="{robot_name}">{srdf}</robot>', encoding="utf-8"
        )
        return path

    return write


def tool_of(path):
    """Return the note on the tool, and the number of warnings of a guess."""
    found = read(path)
    return next(note for note in found.notes if note.startswith("tool:")), sum(
        "guess" in warning for warning in found.warnings
    )


@pytest.mark.parametrize(
    ("parts", "srdf", "tip", "joints"),
    [
        (ARM, CHAIN.format("plate"), "plate", 4),
        (ARM, CHAIN.format("link3"), "link3", 3),
        (
            ARM,
            '<group name="arm"><joint name="j1"/><joint name="j2"/><joint name="j3"/></group>',
            "link3",
            3,
        ),
        (ARM, '<group name="arm"><link name="link1"/><link name="link2"/></group>', "link2", 2),
        (
            [*ARM, *HAND],
            CHAIN.format("link4") + '<end_effector name="h" parent_link="hand" group="fingers"/>',
            "hand",
            4,
        ),
        (
            [*ARM, *HAND],
            CHAIN.format("link4")
            + '<group name="all"><chain base_link="base" tip_link="hand_tcp"/></group>',
            "hand_tcp",
            4,
        ),
        (
            [*ARM, *HAND],
            CHAIN.format("hand")
            + (
                '<group name="g"><chain base_link="hand" tip_link="a"/></group><end_effector '
                'group="g" parent_link="hand"/>'
            ),
            "hand",
            4,
        ),
        (
            [*ARM, *turning("neck", "base", "head")],
            CHAIN.format("plate") + CHAIN.format("head"),
            "plate",
            4,
        ),
        (
            [*ARM, *turning("rod", "link2", "bar", '<mimic joint="j2"/>')],
            CHAIN.format("plate"),
            "plate",
            4,
        ),
    ],
)
def test_the_tip_of_the_group_is_the_tool(written, parts, srdf, tip, joints):
    """Parents of end effectors, tips of chains, ends of listed joints; the note names the file, and
    nothing is guessed.
    """
    note, guesses = tool_of(written(parts, srdf))
    assert note.startswith(f"tool: {tip}, {joints} joints (named in r.srdf")
    assert guesses == 0


@pytest.mark.parametrize(
    ("srdf", "more"),
    [
        ("", ""),
        (CHAIN.format("gone"), ""),
        (CHAIN.format("base"), ""),
        ('<group name="arm"><joint name="j9"/></group>', ""),
    ],
)
def test_an_srdf_that_names_nothing_changes_nothing(written, srdf, more):
    """Groups without a tip, links that the URDF has not, a link that nothing moves."""
    note, _ = tool_of(written([*ARM, *fixed("tool0", "link4")], srdf + more))
    assert note.startswith("tool: tool0, 4 joints (by its name")


@pytest.mark.parametrize(
    "text", ["<robot", '<!DOCTYPE x [<!ENTITY a "b">]><robot name="r">&a;</robot>', "<srdf/>", ""]
)
def test_an_srdf_that_cannot_be_read_is_noted(written, text):
    """The URDF itself is whole."""
    path = written([*ARM, *fixed("tool0", "link4")], "")
    path.with_suffix(".srdf").write_text(text, encoding="utf-8")
    found = read(path)
    assert len(found.moving) == 4
    assert text == "<srdf/>" or any("r.srdf is not read" in note for note in found.notes)


def test_the_sidecar_and_the_option_come_first(written):
    """A tip of the user's own."""
    path = written(ARM, CHAIN.format("plate"))
    assert 'tip = "link3"' in new(urdf=path, tip="link3").text
    assert 'tip = "plate"' in new(urdf=path).text
    path.with_suffix(".toml").write_text('tip = "link2"\n', encoding="utf-8")
    assert len(read(path).moving) == 2


def test_an_srdf_of_another_name_belongs_to_its_robot(written):
    """As a generated configuration is often called; that of another robot is passed over, and of
    two nobody knows which.
    """
    path = written(ARM, CHAIN.format("link3"), name="arm.srdf")
    assert tool_of(path)[0].startswith("tool: link3, 3 joints (named in arm.srdf")
    written(ARM, CHAIN.format("link3"), name="arm.srdf", robot_name="other")
    assert tool_of(path)[0].startswith("tool: link4, 4 joints (a guess")
    assert "named in" not in tool_of(path)[0]
    written(ARM, CHAIN.format("link3"), name="arm.srdf")
    written(ARM, CHAIN.format("link2"), name="other.srdf")
    assert "named in" not in tool_of(path)[0]


def test_an_srdf_is_found_among_many_files(written, monkeypatch):
    """However many files of other kinds are beside it, in whatever order the folder lists them."""
    monkeypatch.setattr(srdf, "_MOST_FILES", 1)
    path = written(ARM, CHAIN.format("link3"), name="arm.srdf")
    for number in range(30):
        (path.parent / f"{number:02}.stl").touch()
    assert tool_of(path)[0].startswith("tool: link3, 3 joints (named in arm.srdf")


def test_one_group_of_two_arms_decides_and_two_do_not(written):
    """With one planning group its arm is meant; with one for each arm the question stays."""
    path = written(
        two_arms(), '<group name="right"><chain base_link="torso" tip_link="right_tcp"/></group>'
    )
    assert tool_of(path)[0].startswith("tool: right_tcp, 3 joints (named in r.srdf")
    groups = "".join(
        f'<group name="{side}"><chain base_link="torso" tip_link="{side}_tcp"/></group>'
        for side in ("left", "right")
    )
    (found,) = mistakes(written(two_arms(), groups))
    assert found.found.startswith("which of 2 arms?")


def test_an_srdf_stands_beside_xacro_too(written):
    """Beside NAME.urdf.xacro it is NAME.srdf."""
    path = written(ARM, CHAIN.format("link3"), urdf="unused.urdf").with_name("r.urdf.xacro")
    path.write_text(
        robot(*ARM).replace('<robot name="r">', f'{HEAD}<xacro:property name="p" value="1"/>'),
        encoding="utf-8",
    )
    assert tool_of(path)[0].startswith("tool: link3, 3 joints (named in r.srdf")


def test_a_stored_run_keeps_the_tool(written, tmp_path):
    """The SRDF comes along: read elsewhere, the arm is the same."""
    path = written(ARM, CHAIN.format("link3"), name="config.srdf")
    folder = tmp_path / "stored"
    folder.mkdir()
    stored = texts(path, None, ())
    for name, text in stored.items():
        (folder / name).write_text(text, encoding="utf-8")
    assert list(stored) == ["r.urdf", "r.srdf"]
    assert read(folder / "r.urdf").joints == read(path).joints
