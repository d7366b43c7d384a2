"""What a description may open: files of its own project, whose root is found or stated and is never
the home or the machine's.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from lostmotion import new
from lostmotion.io import project_root as rooms
from lostmotion.io import read
from lostmotion.io.project_root import is_safe, packages_below, project_root, within
from lostmotion.io.sweep_designs import texts
from tests.io.conftest import mistakes
from tests.io.test_mjcf import HINGE, INERTIAL, model, tetrahedron
from tests.io.test_xacro import HEAD
from tests.io.urdfs import joint, link

TOOL = '<site name="tcp" pos="0.3 0 0"/>'
SOLID = (
    f'<body name="solid" pos="0 0 0.1">{HINGE.format("j2")}<geom type="mesh" mesh="m" '
    f'density="700"/>{TOOL}</body>'
)
PARTS = f'<body name="a">{INERTIAL.format(1)}{HINGE.format("j1")}{SOLID}</body>'


@pytest.fixture
def robot(tmp_path):
    """Write an MJCF model in a folder of its own, whose bodies and mesh lie in folders beside
    it.
    """
    for folder in ("robots", "parts", "meshes"):
        (tmp_path / "repository" / folder).mkdir(parents=True)
    root = tmp_path / "repository"
    (root / "parts" / "a.xml").write_text(
        f"<mujocoinclude>{PARTS}</mujocoinclude>", encoding="utf-8"
    )
    (root / "meshes" / "m.stl").write_bytes(tetrahedron())
    path = root / "robots" / "arm.xml"
    asset = '<asset><mesh name="m" file="m.stl"/></asset>'
    text = model('<include file="../parts/a.xml"/>', rest=asset).replace(
        'angle="radian"', 'angle="radian" meshdir="../meshes"'
    )
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("marker", [".git", ".hg", "package.xml", "pyproject.toml"])
def test_a_model_may_name_files_of_its_project(robot, marker):
    """Includes and meshes beside the model's folder, in the nearest folder above with one of the
    marks of a project.
    """
    assert "outside the project" in mistakes(robot)[0].found
    (robot.parents[1] / marker).mkdir()
    assert [each.name for each in read(robot).moving] == ["j1", "j2"]
    (robot.parent / marker).mkdir()  # a project of its own, within the other
    assert "outside the project" in mistakes(robot)[0].found


def test_the_message_has_the_line_that_names_the_folder(robot):
    """`root` in the sidecar; a stored run, which holds one file, needs it no more."""
    (found,) = mistakes(robot)
    assert 'root = ".." in arm.toml' in found.expected
    sidecar = robot.with_suffix(".toml")
    sidecar.write_text('root = ".."\ntip = "tcp"\n', encoding="utf-8")
    assert [each.name for each in read(robot).moving] == ["j1", "j2"]
    assert 'root = ".."' in new(urdf=robot).text
    (robot.parents[1] / "parts" / "a.xml").write_text(
        (
            "<mujocoinclude><body "
            f'name="a">{INERTIAL.format(1)}{HINGE.format("j1")}{TOOL}</body></mujocoinclude>'
        ),
        encoding="utf-8",
    )
    assert texts(robot, None, ())["arm.toml"] == 'tip = "tcp"\n'


@pytest.mark.parametrize(
    "stated", ['"/"', '"../../../../../../../../../.."', '"~"', '"parts"', "3", '""', '"../parts"']
)
def test_a_root_that_is_none_is_refused_by_its_key(robot, stated):
    """The whole machine, a folder that does not hold the description, no folder, no text."""
    robot.with_suffix(".toml").write_text(f"root = {stated}\n", encoding="utf-8")
    (found,) = mistakes(robot)
    assert found.key == "root"
    assert found.example == 'root = ".."'


def test_the_home_and_what_holds_it_are_never_a_project(robot, monkeypatch):
    """A home whose settings lie in a repository does not open all its files to a downloaded model,
    neither by a mark nor by `root`.
    """
    home = robot.parents[1]
    (home / ".git").mkdir()
    assert read(robot).moving
    monkeypatch.setattr(rooms.Path, "home", lambda: home)
    assert project_root(robot) == robot.parent
    assert "outside the project" in mistakes(robot)[0].found
    robot.with_suffix(".toml").write_text('root = ".."\n', encoding="utf-8")
    assert mistakes(robot)[0].key == "root"
    assert [is_safe(Path(each)) for each in ("/", "/usr", "/home", "/home/a/robots")] == [
        False,
        False,
        False,
        True,
    ]


def test_a_mark_far_above_is_not_looked_for(tmp_path):
    """At most eight folders up."""
    (tmp_path / ".git").mkdir()
    deep = tmp_path.joinpath(*"abcdefgh")
    deep.mkdir(parents=True)
    assert project_root(deep.parent / "x.xml") == tmp_path
    assert project_root(deep / "x.xml") == deep


@pytest.mark.skipif(os.name == "nt", reason="links need rights there")
def test_a_link_does_not_lead_out(tmp_path):
    """Judged by the real place of a file."""
    (tmp_path / "project").mkdir()
    (tmp_path / "secret.xml").write_text("<mujoco/>", encoding="utf-8")
    (tmp_path / "project" / "a.xml").symlink_to(tmp_path / "secret.xml")
    assert within(tmp_path / "project", tmp_path / "project", "a.xml") is None
    assert within(tmp_path, tmp_path / "project", "../secret.xml") is not None
    assert [
        within(tmp_path, tmp_path, stated)
        for stated in (str(tmp_path / "secret.xml"), "", "a\0b", 3)
    ] == [None] * 4


@pytest.fixture
def workspace(tmp_path, monkeypatch):
    """Write a ROS workspace in which folders and packages have other names; the macros lie two
    folders deep.
    """
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)

    def write(deep="vendor/arm"):
        root = tmp_path / "ws"
        config, description = root / "config", root / deep
        for folder, name in ((config, "acme_config"), (description, "acme_description")):
            folder.mkdir(parents=True)
            (folder / "package.xml").write_text(
                f'<?xml version="1.0"?>\n<package format="3">\n <name>{name}</name></package>',
                encoding="utf-8",
            )
        (description / "arm.xacro").write_text(
            f"{HEAD}{link('base')}{joint('j1', 'base one')}{link('one')}</robot>", encoding="utf-8"
        )
        path = config / "robot.urdf.xacro"
        path.write_text(
            f'{HEAD}<xacro:include filename="$(find acme_description)/arm.xacro"/></robot>',
            encoding="utf-8",
        )
        return path

    return write


def test_packages_are_found_by_the_name_in_their_manifest(workspace):
    """Below the folder that the package of the file lies in, whatever their folders are called."""
    assert read(workspace()).moving[0].name == "j1"


@pytest.mark.parametrize("mark", [True, False])
def test_packages_are_found_in_the_whole_repository(workspace, mark):
    """Also where the package of the file lies deeper than the other one."""
    path = workspace()
    deeper = path.parents[1] / "stack" / "robots"
    deeper.mkdir(parents=True)
    moved = path.parent.rename(deeper / "config") / path.name
    if mark:
        (deeper.parents[1] / ".git").mkdir()
        assert read(moved).moving[0].name == "j1"
    else:
        (found,) = mistakes(moved)
        assert (
            "the package 'acme_description', which is not there, in '$(find "
            "acme_description)/arm.xacro'"
        ) in found.found
        assert "<name>acme_description</name>" in found.expected


def test_packages_are_found_below_the_folders_of_ros(workspace, tmp_path, monkeypatch):
    """Each folder of ROS_PACKAGE_PATH is searched as `rospack` does."""
    path = workspace()
    (tmp_path / "ros" / "src").mkdir(parents=True)
    (path.parents[1] / "vendor").rename(tmp_path / "ros" / "src" / "vendor")
    assert "is not there" in mistakes(path)[0].found
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ros"))
    assert read(path).moving[0].name == "j1"


def test_the_search_is_bounded(tmp_path, monkeypatch):
    """In depth and in number, and it never walks through the home."""
    package = tmp_path.joinpath(*"abcde") / "p"
    package.mkdir(parents=True)
    (package / "package.xml").write_text("<package><name>deep</name></package>", encoding="utf-8")
    assert packages_below([tmp_path]) == {}
    assert packages_below([tmp_path / "a"]) == {"deep": package.resolve()}
    for number in range(20):
        (tmp_path / "a" / f"{number:02}").mkdir()
    monkeypatch.setattr(rooms, "_MOST_FOLDERS", 20)
    assert packages_below([tmp_path / "a"]) == {}
    monkeypatch.setattr(rooms, "_MOST_FOLDERS", 2000)
    monkeypatch.setattr(rooms.Path, "home", lambda: tmp_path / "a")
    assert packages_below([tmp_path / "a"]) == {}


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes have no names here")
def test_a_pipe_in_place_of_a_manifest_is_not_waited_for(tmp_path):
    """An unpacked archive may hold a pipe of this name: it is no package, and those below are
    found.
    """
    os.mkfifo(tmp_path / "package.xml")
    (tmp_path / "p").mkdir()
    (tmp_path / "p" / "package.xml").write_text(
        "<package><name>below</name></package>", encoding="utf-8"
    )
    search = (
        "from pathlib import Path; from lostmotion.io.project_root import packages_below; "
        f"print(*packages_below([Path({str(tmp_path)!r})]))"
    )
    found = subprocess.run(
        [sys.executable, "-c", search], capture_output=True, text=True, timeout=60, check=True
    )
    assert found.stdout.split() == ["below"]


@pytest.mark.parametrize(
    ("body", "found", "empty"),
    [
        (
            '<xacro:include filename="../parts/wrist.xacro"/>',
            "an include of '../parts/wrist.xacro', which is not there",
            False,
        ),
        (
            '<xacro:include filename="config/$(arg kind)/wrist.xacro"/>',
            "an include of 'config/wrist.xacro', which is not there",
            True,
        ),
        ('<xacro:include filename="$(arg kind)"/>', "an include of '.', which is a folder", True),
        ('<link name="base"/><link name="$(arg kind)"/>', "no name", True),
        (
            '<link name="base"><inertial><mass value="$(arg kind)"/></inertial></link>'
            + joint("j", "base one")
            + link("one"),
            "''",
            True,
        ),
        (
            '<link name="base"/>'
            + joint("j", "base one", origin='xyz="0 0 ${2*$(arg kind)}"')
            + link("one"),
            "invalid syntax",
            True,
        ),
    ],
)
def test_paths_and_empty_arguments_are_named(tmp_path, body, found, empty):
    """Whoever sees the message knows which path was tried, and that an argument of the file is
    empty.
    """
    path = tmp_path / "r.urdf.xacro"
    path.write_text(f'{HEAD}<xacro:arg name="kind" default=""/>{body}</robot>', encoding="utf-8")
    mistake = mistakes(path)[0]
    assert found in mistake.found
    assert (
        "empty: the argument kind, whose value stands in [xacro] of" in mistake.expected
    ) is empty
