"""MJCF: the model that MuJoCo compiles becomes the same arm as a URDF; nothing in a file reaches
beyond its folder.
"""

from __future__ import annotations

import struct
from pathlib import Path

import mujoco
import numpy as np
import pytest

from lostmotion import new
from lostmotion.io import mjcf, mjcf_process, read
from lostmotion.io.sweep_designs import texts
from lostmotion.mechanism.state import state_of
from tests.io.conftest import mistakes

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "frames and static torques of MJCF",
        (
            "MuJoCo, random arms with several joints on a body, anchors, slides and bodies beside "
            "the chain, and a model of two files with a mesh"
        ),
        "1e-9",
        "io/mjcf.py",
    ),
)
HINGE = '<joint name="{0}" axis="0 1 0" range="-1 1.2"/>'
INERTIAL = '<inertial pos="0.1 0.02 0.03" mass="{0}" diaginertia="0.1 0.1 0.1"/>'


@pytest.fixture
def here(monkeypatch):
    """Compile models in this process, which saves the start of another for each."""

    def ask(_module, request, file, _seconds):
        meshes = {name: Path(path).read_bytes() for name, path in request["meshes"].items()}
        return mjcf_process.compiled(request["xml"], meshes, file)

    monkeypatch.setattr(mjcf, "ask", ask)


def model(*parts, angle="radian", rest=""):
    """Return an MJCF file of these bodies."""
    return (
        f'<mujoco model="r">\n<compiler angle="{angle}"/>\n<worldbody>\n'
        + "\n".join(parts)
        + f"\n</worldbody>\n{rest}\n</mujoco>\n"
    )


def chain(*rest, kinds=("hinge", "hinge")):
    """Return bodies link1, link2 ..., one in the other, with joints j1, j2 ...; `rest` stands in
    the last.
    """
    text = "\n".join(rest)
    for k in range(len(kinds), 0, -1):
        joint = (
            HINGE.format(f"j{k}")
            if kinds[k - 1] == "hinge"
            else f'<joint name="j{k}" type="{kinds[k - 1]}"/>'
        )
        text = f'<body name="link{k}" pos="0.3 0 0.1">{INERTIAL.format(k)}{joint}{text}</body>'
    return text


def random_arm(seed):
    """Return a model whose bodies are turned, have up to two joints with anchors and zeros of their
    own, and carry other bodies that move.
    """
    rng = np.random.default_rng(seed)

    def words(count, size=0.3):
        return " ".join(map(repr, rng.uniform(-size, size, count).tolist()))

    text = f'<site name="tcp" pos="{words(3)}" quat="{words(4)}"/>'
    for k in range(4, 0, -1):
        joints = [
            (
                f'<joint name="j{k}{side}" type="{kind}" pos="{words(3)}" axis="{words(3)}" '
                f'range="-1 1.2" ref="{words(1)}"/>'
            )
            for side, kind in zip(
                "ab", rng.permutation(["hinge", "hinge", "slide"])[: 1 + k % 2], strict=False
            )
        ]
        finger = (
            f'<body name="f{k}" pos="{words(3)}">{INERTIAL.format(0.3)}<joint name="f{k}" '
            f'type="hinge" pos="{words(3)}"/></body>'
        )
        inertial = f'<inertial pos="{words(3)}" mass="{k}" diaginertia="0.1 0.1 0.1"/>'
        text = (
            f'<body name="b{k}" pos="{words(3)}" '
            f'euler="{words(3, 3)}">{inertial}{"".join(joints)}{finger}{text}</body>'
        )
    return model(text)


def agrees_with_mujoco(path, arm, site):
    """Compare the frame of a site and the static forces with MuJoCo's at ten poses. Other joints
    stand as in the file.
    """
    exact = mujoco.MjModel.from_xml_path(str(path))
    exact.opt.gravity = [0, 0, -arm.gravity]
    data = mujoco.MjData(exact)
    moving = [exact.joint(each.name) for each in arm.moving]
    zeros = np.array([exact.qpos0[each.qposadr[0]] for each in moving])
    q = np.random.default_rng(5).uniform(arm.limits[:, 0], arm.limits[:, 1], (10, len(moving)))
    for row, where, forces in zip(
        q, state_of(arm, q).frames[-1], state_of(arm, q).torques, strict=True
    ):
        data.qpos[:] = exact.qpos0
        data.qpos[[each.qposadr[0] for each in moving]] = row + zeros
        mujoco.mj_forward(exact, data)
        assert np.abs(data.site(site).xpos - where[:3, 3]).max() < 1e-9
        assert np.abs(data.site(site).xmat.reshape(3, 3) - where[:3, :3]).max() < 1e-9
        assert np.abs(data.qfrc_bias[[each.dofadr[0] for each in moving]] - forces).max() < 1e-9


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("seed", range(4))
def test_the_arm_stands_and_holds_as_mujocos_does(tmp_path, seed):
    """Anchors, several joints on one body, zeros that are not 0, slides, and bodies beside the
    chain.
    """
    path = tmp_path / "r.xml"
    path.write_text(random_arm(seed), encoding="utf-8")
    arm = read(path)
    assert [each.name for each in arm.moving] == ["j1a", "j1b", "j2a", "j3a", "j3b", "j4a"]
    agrees_with_mujoco(path, arm, "tcp")


def tetrahedron():
    """Return an STL with the corners (0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), in m."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype="<f4")
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    return (
        bytes(80)
        + struct.pack("<I", 4)
        + b"".join(bytes(12) + corners[list(face)].tobytes() + bytes(2) for face in faces)
    )


@pytest.fixture
def folder(tmp_path):
    """Write a model in two files with defaults, degrees, a mesh that weighs, materials, actuators,
    a gripper and a free object.
    """
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "solid.stl").write_bytes(tetrahedron())
    (tmp_path / "parts.xml").write_text(
        """<mujocoinclude><body name="hand" pos="0.2 0 0" euler="0 90 0"><geom type="box" size="0.05 0.02 0.01" mass="0.4" material="grey"/>
        <site name="pinch" pos="0 0 0.1"/>
        <body name="finger"><joint name="finger" type="slide" range="0 0.02"/><geom size="0.01" mass="0.1"/></body>
        <body name="jaw"><joint name="jaw" type="slide" range="0 0.02"/><geom size="0.01" mass="0.1"/></body>
        </body></mujocoinclude>""",
        encoding="utf-8",
    )
    path = tmp_path / "arm.xml"
    path.write_text(
        """<mujoco model="two files"><compiler meshdir="meshes" autolimits="true"/><option gravity="0 0 -3.7"/>
        <default><joint axis="0 1 0" range="-90 60"/><default class="wrist"><joint axis="1 0 0" stiffness="2"/></default></default>
        <asset><texture name="t" type="2d" file="t.png"/><material name="grey" texture="t"/>
          <mesh name="solid" file="solid.stl" scale="0.3 0.3 0.3"/><mesh name="shell" file="gone.stl"/></asset>
        <worldbody><geom type="plane" size="1 1 1"/><light/>
          <body name="arm" pos="0 0 0.3"><joint name="shoulder"/><geom type="mesh" mesh="solid" density="700"/>
            <frame euler="0 10 0"><body name="forearm" pos="0.4 0 0.1" gravcomp="1"><joint name="wrist" class="wrist"/>
              <inertial pos="0.1 0 0" mass="1.5" diaginertia="0.01 0.01 0.01"/><geom type="mesh" mesh="shell" material="grey"/>
              <include file="parts.xml"/></body></frame></body>
          <body name="cup" pos="1 0 0"><freejoint/><geom size="0.04"/></body></worldbody>
        <equality><joint joint1="jaw" joint2="finger"/></equality>
        <actuator><motor joint="shoulder"/></actuator><sensor><jointpos joint="wrist"/></sensor></mujoco>""",
        encoding="utf-8",
    )
    return path


@pytest.mark.usefixtures("here")
@pytest.mark.parametrize("deeper", [False, True])
def test_an_included_file_includes_from_its_own_folder_too(tmp_path, deeper):
    """As MuJoCo looks for it: beside the model, and only then beside the file that names it."""
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "arm.xml").write_text(
        '<mujocoinclude><include file="link.xml"/></mujocoinclude>', encoding="utf-8"
    )
    link = (
        '<mujocoinclude><body name="link">{}<joint name="{}" axis="0 1 0" range="-1 1"/><site '
        'name="tool"/></body></mujocoinclude>'
    )
    (tmp_path / "parts" / "link.xml").write_text(
        link.format(INERTIAL.format(1), "deeper"), encoding="utf-8"
    )
    if not deeper:
        (tmp_path / "link.xml").write_text(
            link.format(INERTIAL.format(1), "beside"), encoding="utf-8"
        )
    path = tmp_path / "r.xml"
    path.write_text(model('<include file="parts/arm.xml"/>'), encoding="utf-8")
    name = mujoco.MjModel.from_xml_path(str(path)).joint(0).name
    assert [each.name for each in read(path).moving] == [name] == ["deeper" if deeper else "beside"]


def test_a_model_of_several_files_is_read_in_a_process_of_its_own(folder, tmp_path):
    """Includes, meshes, defaults, frames; what is not carried over is listed. MuJoCo, given the
    parts that are left, has the same arm.
    """
    arm = read(folder)
    assert [each.name for each in arm.moving] == ["shoulder", "wrist"]
    assert arm.joints[-1].name == "pinch_fixed"
    assert arm.name == "two files"
    notes = "\n".join(arm.notes)
    for part in (
        "tool: pinch",
        "1 actuator",
        "springs of wrist",
        "(gravcomp) of forearm",
        "'0 0 -3.7'",
        "finger, jaw (2 joints on link 'hand'",
    ):
        assert part in notes
    solid = (0.3**3 / 6) * 700
    assert arm.mass == pytest.approx(solid + 1.5 + 0.4 + 0.2, rel=1e-6)
    plain = (
        folder.read_text("utf-8")
        .replace('<mesh name="shell" file="gone.stl"/>', "")
        .replace(' file="t.png"', ' builtin="flat" width="8" height="8"')
    )
    plain = plain.replace('<geom type="mesh" mesh="shell" material="grey"/>', "").replace(
        ' gravcomp="1"', ""
    )
    (tmp_path / "plain.xml").write_text(plain, encoding="utf-8")
    agrees_with_mujoco(tmp_path / "plain.xml", arm, "pinch")


@pytest.mark.usefixtures("here")
def test_a_first_sidecar_is_written_for_mjcf(folder):
    """And accepted as it is; a body is a tip too."""
    new(urdf=folder).report()
    sidecar = folder.with_suffix(".toml")
    assert 'tip = "pinch"' in sidecar.read_text("utf-8")
    assert all(each.gearbox is not None for each in read(folder).moving)
    sidecar.write_text(
        'tip = "forearm"\n[joints.wrist]\nencoder = { zero = "1 arcmin" }\n', encoding="utf-8"
    )
    assert [each.name for each in read(folder).joints] == ["shoulder", "wrist"]


@pytest.mark.usefixtures("here")
def test_a_stored_run_holds_one_file(folder, tmp_path):
    """Includes are put in. A model whose masses follow from meshes cannot be stored as text."""
    with pytest.raises(ValueError, match="masses that follow from the meshes solid"):
        texts(folder, None, ())
    folder.write_text(
        folder.read_text("utf-8").replace(
            'type="mesh" mesh="solid" density="700"', 'size="0.1" mass="3"'
        ),
        encoding="utf-8",
    )
    stored = tmp_path / "stored.xml"
    stored.write_text(texts(folder, None, ())["arm.xml"], encoding="utf-8")
    assert read(stored).joints == read(folder).joints


LOOP = '<equality><connect name="rod" body1="{0}" body2="{1}" anchor="0 0 0"/></equality>'
SIDE = f'<body name="crank">{INERTIAL.format(1)}{HINGE.format("crank")}</body>'


@pytest.mark.parametrize(
    ("text", "found"),
    [
        (
            model(
                chain(kinds=["hinge"] * 3),
                rest=(
                    '<equality><joint name="belt" joint1="j2" joint2="j1" polycoef="0 -1 0 0 '
                    '0"/></equality>'
                ),
            ),
            "'j2' follows 'j1' (equality",
        ),
        (
            model(chain(), SIDE, rest=LOOP.format("crank", "link2")),
            "a loop through j1, j2, crank, none of which an actuator moves",
        ),
        (
            model(
                chain(), SIDE, rest=1001 * LOOP.format("crank", "link2").replace(' name="rod"', "")
            ),
            "1001 elements in <equality>",
        ),
        (model(chain(kinds=("hinge", "ball", "hinge"))), "a ball joint"),
        (model(chain(kinds=("hinge", "slide"))), "a slide without range"),
        (model(chain(kinds=("hinge", "free"))), "free joint can only be used on top level"),
        (model(chain('<site pos="nan 0 0"/>')), "not finite or too large: site_pos"),
        (model(chain('<joint name="j1"/>')), "repeated name 'j1'"),
        (model('<body name="a"><geom size="0.1"/></body>'), "no joint that moves"),
        (model(chain('<body name="x"><joint/></body>')), "mass and inertia of moving bodies"),
    ],
)
def test_what_makes_no_serial_arm_is_refused_by_name(tmp_path, text, found):
    """In words of this project, or in those of MuJoCo's compiler."""
    path = tmp_path / "r.xml"
    path.write_text(text, encoding="utf-8")
    assert found in mistakes(path)[0].found


@pytest.mark.usefixtures("here")
def test_loops_beside_the_chain_and_ties_to_mocap_bodies_are_no_matter(tmp_path):
    """A gripper's linkage is held as in the file; a body that a person moves is no part of the
    arm.
    """
    jaws = (
        f'<body name="jaw">{INERTIAL.format(0.1)}{HINGE.format("jaw")}</body><body '
        f'name="rod">{INERTIAL.format(0.1)}{HINGE.format("rod")}</body>'
    )
    ties = LOOP.format("jaw", "rod") + '<equality><weld body1="target" body2="link2"/></equality>'
    path = tmp_path / "r.xml"
    path.write_text(
        model(chain(jaws, '<site name="tcp"/>'), '<body name="target" mocap="true"/>', rest=ties),
        encoding="utf-8",
    )
    arm = read(path)
    assert [each.name for each in arm.moving] == ["j1", "j2"]
    assert any("mocap" in note for note in arm.notes)
    agrees_with_mujoco(path, arm, "tcp")


@pytest.mark.parametrize(
    ("text", "found"),
    [
        (model('<include file="../secret.xml"/>'), "an include of '../secret.xml'"),
        (model('<include file="/etc/passwd"/>'), "an include of '/etc/passwd'"),
        (model('<include file="r.xml"/>'), "included twice"),
        (model('<include file="deep/r.xml"/>'), "an include of 'deep/r.xml'"),
        ('<!DOCTYPE x [<!ENTITY a "b">]>' + model("&a;"), "a document type"),
        (model(chain("<attach model='x' body='y'/>")), "a model attached from another file"),
        (
            model(chain(), rest='<asset><model name="x" file="../secret.xml"/></asset>'),
            "a model attached from another file",
        ),
        (
            model(
                '<body><joint/><geom type="mesh" mesh="m"/></body>',
                rest='<asset><mesh name="m" file="../m.stl"/></asset>',
            ),
            "the mesh '../m.stl'",
        ),
        (
            model(
                '<body><joint/><geom type="mesh" mesh="m"/></body>',
                rest='<asset><mesh file="m.stl"/></asset>',
            ),
            "the mesh 'm.stl'",
        ),
        (
            model(chain(), rest='<default><mesh file="/etc/passwd"/></default>'),
            "a file named by <mesh>",
        ),
        (
            model('<body><joint/><geom type="box" file="x" size="1 1 1"/></body>'),
            "a file named by <geom>",
        ),
    ],
)
def test_no_file_outside_the_folder_is_opened(tmp_path, monkeypatch, text, found):
    """Refused with its line before anything is compiled."""
    monkeypatch.setattr(mjcf, "ask", None)
    (tmp_path / "secret.xml").write_text("<mujoco/>", encoding="utf-8")
    path = tmp_path / "models" / "r.xml"
    path.parent.mkdir()
    path.write_text(text, encoding="utf-8")
    (mistake,) = mistakes(path)
    assert found in mistake.found
    assert mistake.file.rpartition(":")[2].isdecimal()


def test_without_the_package_the_command_that_installs_it_is_shown(tmp_path, monkeypatch):
    """Whatever the ending: the root element says what the file is."""
    monkeypatch.setattr(mjcf.importlib.util, "find_spec", lambda _: None)
    path = tmp_path / "r.mjcf"
    path.write_text(model(chain()), encoding="utf-8")
    (found,) = mistakes(path)
    assert found.example == "pip install 'lostmotion[mujoco]'"
