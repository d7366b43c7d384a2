"""URDF and its sidecar."""

from __future__ import annotations

import math
import shutil

import numpy as np
import pinocchio as pin
import pytest

from lostmotion.io import read
from lostmotion.mechanism.state import state_of
from tests.io.conftest import EXAMPLES, mistakes
from tests.io.test_dh import UR5E, by_hand

UR5E_URDF = EXAMPLES / "ur5e.urdf"

ROBOT = """<robot name="r"> <link name="base"/>
<joint name="a" type="revolute"><parent link="base"/><child link="one"/>
<origin xyz="0 0 0.3"/><axis xyz="0 1 0"/><limit lower="-1" upper="1"/></joint>
<link name="one"><inertial><mass value="2"/></inertial></link>
<joint name="b" type="revolute"><parent link="one"/><child link="two"/>
<origin xyz="0.4 0 0"/><axis xyz="0 1 0"/><limit lower="-1" upper="1"/></joint>
<link name="two"><inertial><mass value="1"/></inertial></link>
</robot>
"""


@pytest.fixture
def urdf(tmp_path):
    """Write a URDF, and a sidecar where there is one."""

    def write(text, sidecar=None):
        path = tmp_path / "r.urdf"
        path.write_text(text, encoding="utf-8")
        if sidecar is not None:
            path.with_suffix(".toml").write_text(sidecar, encoding="utf-8")
        return path

    return write


def pinocchios(path, arm, q, frame):
    """Return where Pinocchio puts a frame, and which torques it asks for, at these poses; the arm's
    payload hangs on the frame.
    """
    model = pin.buildModelFromUrdf(str(path))
    model.gravity.linear = np.array([0, 0, -arm.gravity])
    index = model.getFrameId(frame)
    held = model.frames[index]
    model.appendBodyToJoint(
        held.parentJoint,
        pin.Inertia(arm.payload.mass, np.array(arm.payload.centre_of_mass), np.zeros((3, 3))),
        held.placement,
    )
    data = model.createData()
    order = [model.joints[model.getJointId(joint.name)].idx_q for joint in arm.moving]
    where, torques = [], []
    for row in q:
        values = pin.neutral(model)
        values[order] = row
        pin.framesForwardKinematics(model, data, values)
        where.append(data.oMf[index].homogeneous.copy())
        torques.append(pin.computeGeneralizedGravity(model, data, values)[order].copy())
    return np.array(where), np.array(torques)


def test_the_ur5e_stands_and_holds_as_pinocchios_does():
    """The example URDF, read here and by Pinocchio, has the same tool frame and the same static
    torques, payload included.
    """
    arm = read(UR5E_URDF)
    q = np.random.default_rng(3).uniform(arm.limits[:, 0], arm.limits[:, 1], (50, 6))
    where, torques = pinocchios(UR5E_URDF, arm, q, "tool0")
    assert arm.payload.mass == 5
    assert np.abs(state_of(arm, q).frames[-1] - where).max() < 1e-10
    assert np.abs(state_of(arm, q).torques - torques).max() < 1e-10


def test_the_ur5e_is_the_makers_table():
    """The example URDF leads where the maker's Denavit-Hartenberg rows lead."""
    arm = read(UR5E_URDF)
    rows = list(zip(UR5E["a"], UR5E["alpha"], UR5E["d"], [0.0] * 6, strict=True))
    q = np.random.default_rng(4).uniform(-3, 3, (20, 6))
    for row, pose in zip(q, state_of(arm, q).frames[-1], strict=True):
        assert np.abs(pose - by_hand(rows, row, ["revolute"] * 6, modified=False)).max() < 1e-12


def test_the_sidecar_says_what_urdf_cannot():
    """Gears, bearings, sections and tolerances come from ur5e.toml beside ur5e.urdf; without it the
    arm is bare.
    """
    arm = read(UR5E_URDF)
    lift = arm.joints[1]
    assert lift.gearbox.zones == [67e3, 110e3, 120e3]
    assert lift.link.section.outer == pytest.approx(0.11)
    assert lift.link.length_tolerance == pytest.approx(50e-6)
    assert arm.joints[-1].type == "fixed"
    assert arm.notes == ()


def test_a_urdf_without_sidecar_is_read(urdf):
    """Its links then are rigid and its joints exact; the beam of a link runs from joint to
    joint.
    """
    arm = read(urdf(ROBOT))
    assert [joint.name for joint in arm.joints] == ["a", "b"]
    assert arm.joints[0].origin.xyz == (0, 0, 0.3)
    assert arm.joints[0].link.reach == 0.4
    assert arm.joints[1].origin.xyz == (0, 0, 0)
    assert arm.joints[1].link.reach == 0


def test_an_explicit_sidecar_may_lie_anywhere(urdf, tmp_path):
    """And it is preferred to the one beside the URDF."""
    path = urdf(ROBOT, "tip = 'nowhere'")
    other = tmp_path / "elsewhere" / "s.toml"
    other.parent.mkdir()
    other.write_text(
        'name = "renamed"\n[joints.b]\nencoder = { zero = "1 arcmin" }\n', encoding="utf-8"
    )
    arm = read(path, other)
    assert arm.name == "renamed"
    assert arm.moving[1].encoder.zero == pytest.approx(math.radians(1 / 60))


def test_a_sidecar_takes_a_servo(urdf):
    """A joint whose servo stands in the sidecar droops by the torque that is not fed forward."""
    servo = 'servo = { stiffness = "60 N m/rad", gravity_compensation = "70 %" }'
    arm = read(urdf(ROBOT, f"[joints.b]\n{servo}\n"))
    found = arm.moving[1].servo
    assert (found.stiffness, found.gravity_compensation) == (60.0, pytest.approx(0.7))
    assert {each.term.cause for each in arm.terms} == {"servo droop", "gravity compensation"}


def body(name, mass, centre):
    """Return a link with a weight, as Pinocchio wants it too."""
    inertia = '<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/>'
    return (
        f'<link name="{name}"><inertial><origin xyz="{centre}" rpy="1 2 3"/><mass '
        f'value="{mass}"/>{inertia}</inertial></link>'
    )


def hinge(name, kind, ends, origin, rest=""):
    """Return a joint between two links."""
    parent, child = ends.split()
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child '
        f'link="{child}"/><origin {origin}/>{rest}</joint>'
    )


def branched(*, finger="prismatic"):
    """Return a robot whose wrist carries a camera rigidly and a finger that slides, and whose
    joints turn, slide, turn without end and are fixed.
    """
    limit = '<limit lower="-0.1" upper="0.5" effort="1" velocity="1"/>'
    parts = [
        body("base", 99, "0 0 0"),
        hinge(
            "a", "continuous", "base one", 'xyz="0 0 0.3" rpy="0.1 0.2 0.3"', '<axis xyz="0 2 1"/>'
        ),
        body("one", 2, "0.1 0.2 0.3"),
        hinge("b", "prismatic", "one two", 'xyz="0.4 0 0.1" rpy="-1 2 0.4"', limit),
        '<link name="two"/>',
        hinge("mount", "fixed", "one camera", 'xyz="0.2 0.1 0" rpy="0.4 0.5 0.6"'),
        body("camera", 1.5, "0 0 0.1"),
        hinge("finger", finger, "camera tip", 'xyz="0 0.3 0"', '<axis xyz="0 0 1"/>' + limit),
        body("tip", 0.5, "0.1 0 0"),
        hinge("c", "fixed", "two three", 'xyz="0.1 0.2 0.3" rpy="1 1 1"'),
        body("three", 0.25, "0 0 0"),
    ]
    return f'<robot name="r">{"".join(parts)}</robot>'


def test_side_branches_weigh_on_the_link_that_carries_them(urdf):
    """A camera and a gripper beside the chain load the joints as Pinocchio says; what can move is
    held at zero, and named.
    """
    path = urdf(branched(), 'tip = "three"')
    arm = read(path)
    assert arm.notes == (
        "not taken: finger (1 joint on link 'one', held at zero, 0.5 kg carried)",
        "joint 'a' turns without end; it is studied from -180 to 180 degrees",
    )
    assert arm.limits[0] == pytest.approx([-math.pi, math.pi])
    model = pin.buildModelFromUrdf(str(path))
    q = np.random.default_rng(0).uniform(-1, 1, (10, 2))
    data = model.createData()
    model.gravity.linear = np.array([0, 0, -arm.gravity])
    for (turn, slide), where, torque in zip(
        q, state_of(arm, q).frames[-1], state_of(arm, q).torques, strict=True
    ):
        values = pin.neutral(model)
        a, b = (model.joints[model.getJointId(name)] for name in "ab")
        values[a.idx_q : a.idx_q + 2] = math.cos(turn), math.sin(turn)
        values[b.idx_q] = slide
        pin.framesForwardKinematics(model, data, values)
        assert np.abs(data.oMf[model.getFrameId("three")].homogeneous - where).max() < 1e-10
        assert (
            np.abs(
                pin.computeGeneralizedGravity(model, data, values)[[a.idx_v, b.idx_v]] - torque
            ).max()
            < 1e-10
        )


def test_three_mistakes_are_reported_at_once_with_their_lines(urdf):
    """A zero axis, a mass below zero and a link that does not exist come in one message."""
    text = (
        ROBOT.replace('<axis xyz="0 1 0"/>', '<axis xyz="0 0 0"/>', 1)
        .replace('value="2"', 'value="-2"')
        .replace('parent link="one"', 'parent link="onn"')
    )
    path = urdf(text)
    found = {problem.key: problem for problem in mistakes(path)}
    assert {key: problem.file for key, problem in found.items()} == {
        '/robot/joint[@name="a"]/axis/@xyz': f"{path}:3",
        '/robot/link[@name="one"]/inertial/mass/@value': f"{path}:4",
        '/robot/joint[@name="b"]/parent/@link': f"{path}:5",
    }
    assert found['/robot/joint[@name="b"]/parent/@link'].nearest == "one"


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        (
            '<link name="base"/>',
            '<link name="base"/><link name="other"/>',
            "2 links without a parent: base, other",
        ),
        ('<parent link="base"/>', '<parent link="two"/>', "loop"),
        ('name="b" type', 'name="a" type', "twice"),
        ('<link name="base"/>', '<link name="base"/><link name="base"/>', "twice"),
        ('<link name="base"/>', '<link name="base"/><link/>', "no name"),
        ('<child link="two"/>', '<child link="one"/>', "a second parent of link 'one'"),
        ('xyz="0.4 0 0"', 'xyz="0.4 0"', "0.4 0"),
        ('xyz="0.4 0 0"', 'xyz="0.4 0 nan"', "nan"),
        ('xyz="0.4 0 0"', 'xyz="0.4 0 1e999"', "1e999"),
        ('xyz="0.4 0 0"', 'xyz="0.4 0 1e13"', "1e13"),
        ('xyz="0.4 0 0"', 'xyz="${x} 0 0"', "${x}"),
        ('<mass value="2"/>', "", "no mass"),
        ('<mass value="2"/>', '<mass value="inf"/>', "inf"),
        ('<limit lower="-1" upper="1"/>', "", "no limit"),
        ('<limit lower="-1" upper="1"/>', '<limit lower="1" upper="-1"/>', "limits from 1 to -1"),
        ('type="revolute"', 'type="revolut"', "revolut"),
        ('name="b" type="revolute"', 'name="b" type="screw"', "screw"),
        (
            '<axis xyz="0 1 0"/>',
            '<axis xyz="0 1 0"/><mimic joint="b"/>',
            "joint 'a' follows 'b' (mimic, x 1)",
        ),
        ('name="b"', f'name="{"b" * 81}"', "81 characters"),
        ("<robot", "<machine", "mismatch"),
        ("robot", "machine", "machine"),
        (
            '<link name="base"/>',
            '<x:arm xmlns:x="http://www.ros.org/wiki/xacro"/>',
            "this is xacro: the macro 'arm'",
        ),
        ("revolute", "fixed", "no joint that moves"),
    ],
)
def test_a_mistake_in_a_urdf_is_reported(urdf, old, new, word):
    """Trees that are none, numbers that are none, and joints that a serial arm cannot have."""
    text = ROBOT.replace(old, new) if old in ("robot", "revolute") else ROBOT.replace(old, new, 1)
    found = mistakes(urdf(text))
    assert any(word in problem.found for problem in found)


def test_joints_that_no_serial_arm_has_may_hang_beside_the_chain(urdf):
    """Only between root and tip must every joint be one that is understood."""
    assert read(urdf(branched(finger="floating"), 'tip = "three"')).joints


@pytest.mark.parametrize(
    ("sidecar", "key", "near"),
    [
        ("tip = 'twoo'", "tip", "two"),
        ("tip = 3", "tip", ""),
        ("tip = 'base'", "/robot", ""),
        ("[joints.bb]\n", "joints.bb", "b"),
        ("[joints.A]\n", "joints.A", ""),
        ("joints = []", "joints", ""),
        ("[joints]\na = 3", "joints.a", ""),
        ("[joints.a]\ngearbocs = 3", "joints.a.gearbocs", "gearbox"),
        ("[joints.a]\naxis = 'x'", "joints.a.axis", ""),
        ("[joints.a]\nlink = 3", "joints.a.link", ""),
        ("[joints.a]\nlink = { length = '3 m' }", "joints.a.link.length", ""),
        ("[joints.a]\nlink = { length_tolerance = '3 kg' }", "joints.a.link.length_tolerance", ""),
        ("[joints.a]\ngearbox = 'large'", "joints.a.gearbox", ""),
        (
            "[gearboxes.large]\nratio = '3 mm'\n[joints.a]\ngearbox = 'large'",
            "gearboxes.large.ratio",
            "",
        ),
        ("[paylod]\nmass = '3 kg'", "paylod", "payload"),
        ("notes = 3", "notes", ""),
    ],
)
def test_a_mistake_in_a_sidecar_is_reported_under_its_key(urdf, sidecar, key, near):
    """With the name of the sidecar, and the joint's own name."""
    path = urdf(ROBOT, sidecar)
    (found,) = mistakes(path)
    assert (found.key, found.nearest) == (key, near)
    line = next((k for k, row in enumerate(sidecar.split("\n"), 1) if key.split(".")[-1] in row), 0)
    assert found.file == (str(path) if key == "/robot" else f"{path.with_suffix('.toml')}:{line}")


def test_a_sidecar_link_must_not_lead_out_of_the_folder(tmp_path):
    """A URDF from a stranger does not make the reader open files elsewhere."""
    folder = tmp_path / "in"
    folder.mkdir()
    secret = tmp_path / "secret.toml"
    secret.write_text("password = 1", encoding="utf-8")
    (folder / "r.urdf").write_text(ROBOT, encoding="utf-8")
    (folder / "r.toml").symlink_to(secret)
    (found,) = mistakes(folder / "r.urdf")
    assert "out of the folder" in found.found
    (folder / "r.toml").unlink()
    shutil.copy(secret, folder / "inside.toml")
    (folder / "r.toml").symlink_to("inside.toml")
    assert mistakes(folder / "r.urdf")[0].key == "password"


@pytest.mark.parametrize(
    "word", ["1_0", "infinity", "nan", "١٢", "１", "1\u00a0", "", "1e999", "1 1"]
)
def test_a_number_is_plain_decimal(urdf, word):
    """What Python would read besides is refused in words."""
    (found,) = mistakes(urdf(ROBOT.replace('value="2"', f'value="{word}"')))
    assert found.key.endswith("mass/@value")
    assert "plain decimal" in found.expected


def test_numbers_may_stand_among_blanks(urdf):
    """As other readers of URDF take them: tabs and line breaks, a plus, exponents."""
    arm = read(urdf(ROBOT.replace('xyz="0.4 0 0"', 'xyz=" +4e-1\t0.\n .0 "')))
    assert arm.joints[0].link.reach == pytest.approx(0.4)


def test_too_many_links_are_refused_first(urdf):
    """No arm has a thousand."""
    (found,) = mistakes(
        urdf(
            ROBOT.replace(
                "</robot>", "".join(f'<link name="l{k}"/>' for k in range(1000)) + "</robot>"
            )
        )
    )
    assert found.found == "1003 links"
