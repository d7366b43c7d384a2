"""xacro: macros, arguments, includes and packages become the same arm as a URDF; nothing in a file
reaches beyond its project.
"""

from __future__ import annotations

import subprocess
import sys
import textwrap

import pytest

from lostmotion import new
from lostmotion.errors import InputError
from lostmotion.io import read, xacro_file, xacro_process
from lostmotion.io.sidecar import sidecar_place
from lostmotion.io.sweep_designs import read_sweep, texts
from lostmotion.io.xacro_expression import check_plain
from tests.io.conftest import mistakes
from tests.io.urdfs import agrees_with_pinocchio, joint, link, robot

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "frames and static torques of xacro",
        "Pinocchio, given the URDF written by hand",
        "1e-9",
        "io/xacro_process.py",
    ),
)
HEAD = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r">'
ARM = f"""{HEAD}
<xacro:include filename="$(find r_description)/urdf/parts.xacro"/>
<xacro:arg name="upper" default="0.3"/>
<xacro:arg name="tool" default="false"/>
<xacro:property name="lengths" value="${{xacro.load_yaml('../config/lengths.yaml')}}"/>
<xacro:body name="base" mass="5"/>
<xacro:hinge name="j1" ends="base link1" height="$(arg upper)" turn="${{pi / 8}}"/>
<xacro:body name="link1" mass="${{python.sum([0.1 * k for k in range(5)])}}"/>
<xacro:hinge name="j2" ends="link1 link2" height="${{lengths.forearm}}" turn="$(eval 0.1 * 2)"/>
<xacro:body name="link2" mass="1.2"/>
<xacro:if value="$(arg tool)">
  <joint name="mount" type="fixed"><parent link="link2"/><child link="tool0"/><origin xyz="0 0 0.1"/></joint>
  <link name="tool0"/>
</xacro:if>
</robot>
"""
PARTS = f"""{HEAD}
<xacro:macro name="body" params="name mass">
  <link name="${{name}}"><inertial><origin xyz="0.1 0.02 0.03"/><mass value="${{mass}}"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
</xacro:macro>
<xacro:macro name="hinge" params="name ends height turn:=0">
  <joint name="${{name}}" type="revolute"><parent link="${{ends.split()[0]}}"/><child link="${{ends.split()[1]}}"/>
    <origin xyz="0.3 0 ${{height}}" rpy="${{turn}} 0.1 0"/><axis xyz="0 1 0"/><limit lower="-1" upper="1.2" effort="1" velocity="1"/></joint>
</xacro:macro>
</robot>
"""


@pytest.fixture
def project(tmp_path):
    """Write a ROS package with a xacro file, macros and lengths; `write` replaces or adds a file in
    its folder urdf.
    """
    package = tmp_path / "r_description"
    (package / "urdf").mkdir(parents=True)
    (package / "config").mkdir()
    (package / "package.xml").write_text(
        "<package><name>r_description</name></package>", encoding="utf-8"
    )
    (package / "config" / "lengths.yaml").write_text("forearm: 0.25\n", encoding="utf-8")

    def write(text, name="r.urdf.xacro", sidecar=None):
        path = package / "urdf" / name
        path.write_text(text, encoding="utf-8")
        if sidecar is not None:
            sidecar_place(path).write_text(sidecar, encoding="utf-8")
        return path

    write(PARTS, "parts.xacro")
    return write


def body(*parts):
    """Return a xacro file of these parts and one link."""
    return "\n".join([HEAD, '<link name="base"/>', *parts, "</robot>"])


def test_macros_arguments_and_packages_make_the_arm_of_a_urdf(project, tmp_path):
    """Includes by package and by path, properties from YAML, arguments, expressions and conditions:
    Pinocchio, given the URDF, has the same arm.
    """
    arm = read(
        project(ARM, sidecar='[xacro]\nupper = 0.5\ntool = true\n[payload]\nmass = "1 kg"\n')
    )
    assert (arm.name, arm.joints[-1].name, arm.payload.mass) == ("r", "mount", 1)
    by_hand = tmp_path / "by_hand.urdf"
    parts = [
        link("base", 5),
        joint("j1", "base link1", origin='xyz="0.3 0 0.5" rpy="0.39269908169872414 0.1 0"'),
        link("link1", 1.0),
    ]
    parts += [
        joint("j2", "link1 link2", origin='xyz="0.3 0 0.25" rpy="0.2 0.1 0"'),
        link("link2", 1.2),
    ]
    parts += [joint("mount", "link2 tool0", "fixed", "", 'xyz="0 0 0.1"'), link("tool0", 0)]
    by_hand.write_text(robot(*parts), encoding="utf-8")
    agrees_with_pinocchio(
        by_hand, arm.model_copy(update={"payload": read(by_hand).payload}), "tool0"
    )
    assert [each.model_dump() for each in read(by_hand).joints] == [
        each.model_dump() for each in arm.joints
    ]


def test_a_sidecar_begun_from_xacro_keeps_its_arguments(project):
    """`new --from` writes NAME.toml beside NAME.urdf.xacro, which the reader takes as it is."""
    path = project(ARM, sidecar='[xacro]\nupper = "0.5"\ntool = true\n')
    new(urdf=path, force=True).report()
    written = (path.parent / "r.toml").read_text("utf-8")
    assert '[xacro]\nupper = "0.5"\ntool = true\n' in written
    arm = read(path)
    assert arm.joints[-1].name == "mount"
    assert all(each.gearbox is not None for each in arm.moving)


def test_a_stored_run_holds_the_urdf_that_xacro_makes(project, tmp_path):
    """Its workers need neither the package xacro nor the project's files."""
    path = project(ARM, sidecar="[xacro]\nupper = 0.5\n")
    stored = texts(path, None, ())
    assert list(stored) == ["r.urdf", "r.toml"]
    for name, text in stored.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    assert read(tmp_path / "r.urdf").joints == read(path).joints


@pytest.mark.parametrize(
    ("name", "sidecar"),
    [
        ("r.urdf", "r.toml"),
        ("r.xacro", "r.toml"),
        ("r.urdf.xacro", "r.toml"),
        ("r.v2.urdf", "r.v2.toml"),
        ("r.v2.xacro", "r.v2.toml"),
    ],
)
def test_a_sidecar_has_the_name_of_its_description(tmp_path, name, sidecar):
    """Without the endings .urdf and .xacro."""
    assert sidecar_place(tmp_path / name) == tmp_path / sidecar


def test_a_package_beside_the_project_may_be_included(project, tmp_path):
    """A folder with a package.xml is there to be found by others; any other folder is not."""
    other = tmp_path / "tools"
    other.mkdir()
    (other / "tool.xacro").write_text(f'{HEAD}<link name="t"/></robot>', encoding="utf-8")
    path = project(
        body('<xacro:include filename="$(find tools)/tool.xacro"/>', joint("j", "base t"))
    )
    (found,) = mistakes(path)
    assert "package 'tools', which is not there" in found.found
    (other / "package.xml").write_text("<package><name>tools</name></package>", encoding="utf-8")
    assert read(path).moving[0].name == "j"
    mesh = (
        '<link name="m"><visual><geometry><mesh filename="$(find '
        'gone)/m.stl"/></geometry></visual></link>'
    )
    # no mesh is opened
    assert read(project(body(mesh, joint("j", "base m")))).moving[0].name == "j"


WRONG = {
    "argument without a value": (
        '<link name="$(arg size)"/>',
        "the argument 'size' without a value",
        "size = ",
    ),
    "unknown macro": ("<xacro:wrist/>", "unknown macro name: xacro:wrist", ""),
    "unknown property": ('<link name="${size}"/>', "name 'size' is not defined in '${size}'", ""),
    "unknown key": (
        "<a b=\"${xacro.load_yaml('../config/lengths.yaml')['upper_arm']}\"/>",
        "no key 'upper_arm'",
        "",
    ),
    "missing parameter": (
        '<xacro:macro name="m" params="a"/><xacro:m/>',
        "Undefined parameters [a]",
        "",
    ),
    "include that is not there": (
        '<xacro:include filename="wrist.xacro"/>',
        "'wrist.xacro', which is not there",
        "wrist.xacro",
    ),
    "not well-formed": ('<xacro:if value="1"><link name="a></xacro:if>', "not well-formed", ""),
    "circular": (
        '<xacro:property name="p" value="${p}"/><link name="${p}"/>',
        "circular variable definition",
        "",
    ),
    "macros without end": (
        '<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>',
        "without end",
        "",
    ),
    # What means harm.
    "include from elsewhere": (
        '<xacro:include filename="../../secret.xml" optional="true"/>',
        "secret.xml",
        "package.xml",
    ),
    "values of a package that is not there": (
        "<a b=\"${xacro.load_yaml('$(find gone)/a.yaml')}\"/>",
        "package 'gone', which is not there",
        "",
    ),
    "pattern of elsewhere": ('<xacro:include filename="/etc/*"/>', "opens '/etc'", "package.xml"),
    "values from elsewhere": (
        "<a b=\"${xacro.load_yaml('../../secret.xml')}\"/>",
        "secret.xml",
        "package.xml",
    ),
    "environment": ('<a b="$(env HOME)"/>', "environment variable 'HOME' is not set", ""),
    "built-in functions": ('<a b="$(eval open)"/>', "'open' is not defined", ""),
    "types": ('<a b="${python.type(1)}"/>', "'type' is not defined", ""),
    "inside of Python": ('<a b="${().__class__}"/>', "the expression '().__class__'", ""),
    "too much memory": ('<a b="${list(range(10**10))}"/>', "without end", ""),
    "entities": ('<xacro:include filename="bomb.xacro"/>', "a document type", ""),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_in_a_xacro_file_is_one_clear_mistake(project, tmp_path, case):
    """It names the file, and nothing outside the project is read."""
    text, found, hint = WRONG[case]
    (tmp_path / "secret.xml").write_text("<secret/>", encoding="utf-8")
    project('<!DOCTYPE robot [<!ENTITY a "b">]><robot>&a;</robot>', "bomb.xacro")
    (mistake,) = mistakes(project(body(text)))
    assert found in mistake.found
    assert hint in mistake.example + mistake.expected
    assert "bomb.xacro" in mistake.file if case == "entities" else "r.urdf.xacro" in mistake.file


def test_a_loop_is_stopped(project, monkeypatch):
    """By the time of the processor, which no file can extend."""
    monkeypatch.setattr(xacro_file, "_SECONDS", 1)
    (found,) = mistakes(project(body('<a b="${9**9**9}"/>')))
    assert "ended without an answer" in found.found


@pytest.mark.parametrize(
    ("sidecar", "key", "found"),
    [
        ("[xacro]\nuper = 1\n", "xacro.uper", "never asks for"),
        ("[xacro]\nupper = [1, 2]\ntool = { a = 1 }\n", "xacro.upper", "[1, 2]"),
        ("xacro = 3\n", "xacro", "3"),
    ],
)
def test_wrong_arguments_are_refused_by_their_key(project, sidecar, key, found):
    """In the sidecar, where they stand."""
    first = mistakes(project(ARM, sidecar=sidecar))[0]
    assert first.file.partition(".toml")[0].endswith("r")
    assert (first.key, found in first.found) == (key, True)


def test_a_library_of_macros_is_no_arm(project):
    """It is named as such, not as a URDF without links."""
    (found,) = mistakes(project(PARTS))
    assert "a library" in found.found


def test_without_the_package_the_command_that_installs_it_is_shown(project, monkeypatch, tmp_path):
    """A .xacro file with nothing to expand needs no package."""
    monkeypatch.setattr(xacro_file.importlib.util, "find_spec", lambda _: None)
    (found,) = mistakes(project(ARM))
    assert found.example == "pip install 'lostmotion[xacro]'"
    plain = tmp_path / "plain.xacro"
    plain.write_text(robot(link("base"), joint("j", "base one"), link("one")), encoding="utf-8")
    assert read(plain).moving[0].name == "j"


@pytest.mark.parametrize(
    "expression",
    [
        "().__class__.__mro__",
        "[x for x in [1] if x.__class__]",
        "[__import__('os') for _ in [1]]",
        "__builtins__",
        "(lambda: 1)()",
        "(x for x in [1])",
        "'{0.__class__}'.format(1)",
        "str.format_map('{a}', {})",
        "f'{().__class__}'",
        "a._private",
        "().__ｃlass__",
        "(a := 1)",
    ],
)
def test_an_expression_that_leads_inside_python_is_refused(expression):
    """By its syntax, before anything of it is evaluated."""
    with pytest.raises(InputError):
        check_plain(expression, "r.xacro")


@pytest.mark.parametrize(
    "expression",
    [
        "pi / 2 if a else -x[1:]",
        "[2 * x for x in python.range(3)]",
        "a.b.c + f'{d}_e'",
        "{'k': max(1, *b)}['k']",
    ],
)
def test_expressions_of_real_files_pass(expression):
    """Arithmetic, comprehensions, dotted values of YAML, text and dictionaries."""
    check_plain(expression, "r.xacro")


def test_a_confined_process_reads_its_folder_and_nothing_else(tmp_path):
    """Whatever code runs in it: no other file, no writing, no network, no program, no import."""
    (tmp_path / "inside.txt").write_text("inside", encoding="utf-8")
    text = f"""
        import os, socket, subprocess, sys
        from lostmotion.io.own_process import confine
        refused = confine([{str(tmp_path)!r}])
        assert open({str(tmp_path / "inside.txt")!r}).read() == "inside"
        tries = [
            lambda: open({__file__!r}), lambda: open({str(tmp_path / "new.txt")!r}, "w"), lambda: os.listdir("/"), lambda: os.system("true"),
            lambda: subprocess.run(["true"]), lambda: socket.create_connection(("127.0.0.1", 9)), lambda: __import__("ctypes"),
            lambda: os.remove({str(tmp_path / "inside.txt")!r}), lambda: os.kill(os.getpid(), 0), lambda: os.fork(), lambda: os.putenv("A", "b"),
        ]
        for number, attempt in enumerate(tries):
            try:
                attempt()
            except PermissionError:
                continue
            sys.exit(f"attempt {{number}} was allowed")
        print(len(refused) >= len(tries))
    """
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(text)], capture_output=True, text=True, check=False
    )
    assert (done.stdout.strip(), done.stderr) == ("True", "")
    assert not (tmp_path / "new.txt").exists()


def test_a_sweep_over_an_argument_is_refused_with_what_to_do_instead(project):
    """A run stores one expanded file; a comparison of one file with two sidecars answers the
    question.
    """
    path = project(ARM, sidecar='[xacro]\nupper = 0.5\n[sweep]\n"xacro.upper" = [0.3, 0.5]\n')
    with pytest.raises(InputError) as found:
        read_sweep(path)
    (problem,) = found.value.problems
    assert (problem.key, problem.found) == (
        'sweep."xacro.upper"',
        "an argument of xacro, which a sweep cannot change",
    )
    assert (
        problem.example
        == "lostmotion compare r.urdf.xacro r.urdf.xacro --sidecar one.toml --sidecar two.toml"
    )


def test_the_functions_of_xacro_that_are_replaced_exist():
    """Another version of the package that renames one would evaluate the file's expressions."""
    assert all(callable(getattr(module, name)) for module, name in xacro_process._HOOKS)
