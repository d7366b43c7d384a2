"""SDF: the model becomes the arm that its text describes, computed here by another route; loops
close; nothing in a file reaches beyond its project.
"""

from __future__ import annotations

import functools
import math
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lostmotion import new
from lostmotion.io import read
from lostmotion.io.sweep_designs import texts
from lostmotion.mechanism.state import state_of
from tests.io import urdfs
from tests.io.conftest import mistakes

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "frames and static torques of SDF",
        (
            "a walk over the XML by another route, and the slope of the potential energy, for "
            "random models of all versions; the same robots as URDF"
        ),
        "1e-12 m, 1e-6 N m",
        "io/sdf.py",
    ),
    (
        "a four-bar of SDF, whose last joint closes the loop",
        "its closed form, and the slope of its potential energy",
        "1e-12 m, 1e-6 N m",
        "io/sdf.py",
    ),
)
GRAVITY = 9.80665
STEP = 1e-5
TURN = "<axis><xyz>0 -1 0</xyz></axis>"


def pose(x=0.0, y=0.0, z=0.0, roll=0.0, pitch=0.0, yaw=0.0):
    """Return a pose (4, 4)."""
    out = np.eye(4)
    out[:3, :3] = Rotation.from_euler("xyz", [roll, pitch, yaw]).as_matrix()
    out[:3, 3] = x, y, z
    return out


class Walk:
    """The frames of a model by its text alone: each element's pose, resolved by recursion."""

    def __init__(self, text):
        """Parse a text."""
        self.sdf = ET.fromstring(text)  # noqa: S314 - a text of this test
        self.model = self.sdf.find("model")
        self.by_name = {
            each.get("name"): each
            for kind in ("link", "joint", "frame")
            for each in self.model.findall(kind)
        }
        self.old = self.sdf.get("version") == "1.4"
        self.joints = {each.findtext("child"): each for each in self.model.findall("joint")}
        # of the text alone, whatever the values of the joints
        self.at, self.axis = map(functools.cache, (self.at, self.axis))

    def stated(self, element):
        """Return the pose that an element states, and what it is relative to."""
        found = element.find("pose")
        default = {"link": None, "joint": element.findtext("child")}.get(
            element.tag, element.get("attached_to")
        )
        if found is None:
            return np.eye(4), default
        values = np.array(found.text.split(), float)
        if found.get("rotation_format") == "quat_xyzw":
            out = pose(*values[:3])
            out[:3, :3] = Rotation.from_quat(values[3:]).as_matrix()
        else:
            values[3:] *= math.pi / 180 if found.get("degrees") == "true" else 1
            out = pose(*values)
        return out, found.get("relative_to") or default

    def at(self, name):
        """Return the pose of a frame in the model, all joints at zero."""
        if name in (None, "__model__"):
            return np.eye(4)
        own, base = self.stated(self.by_name[name])
        return self.at(base) @ own

    def axis(self, joint, which):
        """Return an axis in the model."""
        axis = joint.find(which)
        xyz = axis.find("xyz")
        seen_from = xyz.get("expressed_in")
        if seen_from is None:
            of_model = self.old or axis.findtext("use_parent_model_frame") == "1"
            seen_from = "__model__" if of_model else joint.get("name")
        direction = self.at(seen_from)[:3, :3] @ np.array(xyz.text.split(), float)
        return direction / np.linalg.norm(direction)

    def moved(self, body, values):
        """Return the motion (4, 4) of a body in the model against where it is at zero."""
        joint = self.joints.get(body)
        if joint is None:
            return np.eye(4)
        out = self.moved(joint.findtext("parent"), values)
        through = self.at(joint.get("name"))[:3, 3]
        for which in ("axis", "axis2"):
            if joint.get("type") == "fixed" or joint.find(which) is None:
                continue
            name = joint.get("name") + ("" if which == "axis" else "_axis2")
            axis, value = self.axis(joint, which), values.get(name, 0.0)
            step = np.eye(4)
            if joint.get("type") == "prismatic":
                step[:3, 3] = value * axis
            else:
                step[:3, :3] = Rotation.from_rotvec(value * axis).as_matrix()
                step[:3, 3] = through - step[:3, :3] @ through
            out = out @ step
        return out

    def energy(self, values):
        """Return the potential energy, N m, of all bodies."""
        stands = self.stated(self.model)[0]
        total = 0.0
        for link in self.model.findall("link"):
            inertial = link.find("inertial")
            mass = float(inertial.findtext("mass"))
            centre = self.at(link.get("name")) @ self.stated(inertial)[0]
            total += mass * GRAVITY * (stands @ self.moved(link.get("name"), values) @ centre)[2, 3]
        return total


def random_model(seed, version):  # noqa: C901 - words of each version
    """Return a model with offset frames, universal joints, and bodies beside the chain."""
    rng = np.random.default_rng(seed)
    new_words = version not in ("1.4", "1.6")
    known = ["__model__"]

    def words(count, size=0.3):
        return " ".join(map(repr, rng.uniform(-size, size, count).tolist()))

    def placed(*, allowed=True):
        if rng.random() < 0.2:
            return ""
        to = (
            f' relative_to="{rng.choice(known)}"'
            if new_words and allowed and rng.random() < 0.5
            else ""
        )
        if version == "1.9" and rng.random() < 0.3:
            return f'<pose{to} rotation_format="quat_xyzw">{words(7)}</pose>'
        if version == "1.9" and rng.random() < 0.3:
            return f'<pose{to} degrees="true">{words(3)} {words(3, 170)}</pose>'
        return f"<pose{to}>{words(3)} {words(3, 3)}</pose>"

    def axis(tag="axis"):
        seen = f' expressed_in="{rng.choice(known)}"' if new_words and rng.random() < 0.5 else ""
        flag = "<use_parent_model_frame>1</use_parent_model_frame>"
        flag = flag if version == "1.6" and rng.random() < 0.5 else ""
        limit = "<limit><lower>-1</lower><upper>1.2</upper></limit>"
        return f"<{tag}><xyz{seen}>{words(3)}</xyz>{flag}{limit}</{tag}>"

    def link(name, mass):
        out = f'<link name="{name}">{placed()}<inertial>{placed(allowed=False)}<mass>{mass}</mass></inertial></link>'
        known.append(name)
        return out

    def joint(name, parent, child, kind):
        axes = axis() + (axis("axis2") if kind == "universal" else "") if kind != "fixed" else ""
        ends = f"<parent>{parent}</parent><child>{child}</child>"
        out = f'<joint name="{name}" type="{kind}">{ends}{placed()}{axes}</joint>'
        known.append(name)
        return out

    kinds = rng.permutation(["revolute", "revolute", "prismatic", "universal", "fixed", "revolute"])
    parts = [link("base", 4)]
    for k, kind in enumerate(kinds):
        before = "base" if not k else f"l{k - 1}"
        parts += [link(f"l{k}", 1 + k), joint(f"j{k}", before, f"l{k}", kind)]
        parts += [link(f"finger{k}", 0.3), joint(f"f{k}", f"l{k}", f"finger{k}", "revolute")]
    if new_words:
        parts.append(
            f'<frame name="tcp" attached_to="l5"><pose>{words(3)} {words(3, 3)}</pose></frame>'
        )
    else:
        parts += [link("tcp", 0.1), joint("tool", "l5", "tcp", "fixed")]
    stands = "<pose>0 0 0.4 0.3 -0.2 0.5</pose>"
    return f'<sdf version="{version}"><model name="r">{stands}{"".join(parts)}</model></sdf>'


def written(tmp_path, text, sidecar="", name="arm.sdf"):
    """Return the path of a file with this text, and a sidecar beside it."""
    path = tmp_path / name
    path.write_text(text, "utf-8")
    if sidecar:
        path.with_suffix(".toml").write_text(sidecar, "utf-8")
    return path


@pytest.mark.parametrize("version", ["1.4", "1.6", "1.7", "1.9"])
@pytest.mark.parametrize("seed", range(6))
def test_a_model_stands_and_weighs_as_its_text_says(tmp_path, version, seed):
    """Whatever its poses are relative to, and its axes seen from, in all versions."""
    text = random_model(seed, version)
    arm = read(written(tmp_path, text, 'tip = "tcp"'))
    walk, names = Walk(text), [joint.name for joint in arm.driven]
    assert len(names) == 6
    q = np.random.default_rng(seed).uniform(arm.limits[:, 0], arm.limits[:, 1], (4, 6))
    state = state_of(arm, q)
    stands = walk.stated(walk.model)[0]
    for row, frame, torques in zip(q, state.frames[-1], state.torques, strict=True):
        values = dict(zip(names, row.tolist(), strict=True))
        body = "tcp" if walk.by_name["tcp"].tag == "link" else "l5"
        expected = stands @ walk.moved(body, values) @ walk.at("tcp")
        np.testing.assert_allclose(frame, expected, atol=1e-12)
        for name, torque in zip(names, torques, strict=True):
            up, down = ({**values, name: values[name] + sign * STEP} for sign in (1, -1))
            slope = (walk.energy(up) - walk.energy(down)) / (2 * STEP)
            assert torque == pytest.approx(slope, abs=1e-6)


def as_sdf(text):
    """Return a URDF as SDF 1.7, by hand: a joint stands in its parent, a link in its joint."""
    robot = ET.fromstring(text)  # noqa: S314 - a text of this test

    def stated(origin, to=""):
        if origin is None:
            return f"<pose{to}/>"
        return f"<pose{to}>{origin.get('xyz', '0 0 0')} {origin.get('rpy', '0 0 0')}</pose>"

    joints = {each.find("child").get("link"): each for each in robot.findall("joint")}
    out = []
    for link in robot.findall("link"):
        name, inertial = link.get("name"), link.find("inertial")
        above = joints.get(name)
        seat = "" if above is None else f'<pose relative_to="{above.get("name")}"/>'
        weight = (
            f"{stated(inertial.find('origin'))}<mass>{inertial.find('mass').get('value')}</mass>"
        )
        out.append(f'<link name="{name}">{seat}<inertial>{weight}</inertial></link>')
    for joint in robot.findall("joint"):
        parent = joint.find("parent").get("link")
        seat = stated(joint.find("origin"), f' relative_to="{parent}"')
        limit = "".join(f"<{k}>{joint.find('limit').get(k)}</{k}>" for k in ("lower", "upper"))
        axis = f"<axis><xyz>{joint.find('axis').get('xyz')}</xyz><limit>{limit}</limit></axis>"
        ends = f"<parent>{parent}</parent><child>{joint.find('child').get('link')}</child>"
        out.append(f'<joint name="{joint.get("name")}" type="revolute">{ends}{seat}{axis}</joint>')
    return f'<sdf version="1.7"><model name="r">{"".join(out)}</model></sdf>'


def test_the_same_robot_as_urdf_is_the_same_arm(tmp_path):
    """Names, order, frames and torques."""
    text = urdfs.robot(*urdfs.arm(6))
    one = read(written(tmp_path, text, name="arm.urdf"))
    two = read(written(tmp_path, as_sdf(text)))
    assert [joint.name for joint in one.joints] == [joint.name for joint in two.joints]
    q = np.random.default_rng(0).uniform(one.limits[:, 0], one.limits[:, 1], (20, 6))
    for what in ("frames", "torques"):
        here, there = (getattr(state_of(arm, q), what) for arm in (one, two))
        np.testing.assert_allclose(here, there, atol=1e-12)


def bar(name, at, centre, mass=0.5):
    """Return a link without turns."""
    inertial = f"<inertial><pose>{centre} 0 0 0</pose><mass>{mass}</mass></inertial>"
    return f'<link name="{name}"><pose>{at} 0 0 0</pose>{inertial}</link>'


def pin(name, parent, child, kind="revolute", axis=TURN, at=""):
    """Return a joint, in the origin of its child unless stated."""
    ends = f"<parent>{parent}</parent><child>{child}</child>"
    return f'<joint name="{name}" type="{kind}">{ends}{at}{axis}</joint>'


def in_model(*parts, version="1.9"):
    """Return an SDF file of these parts, one a line."""
    lines = "\n".join(parts)
    return f'<sdf version="{version}">\n<model name="r">\n{lines}\n</model>\n</sdf>\n'


LIMITED = "<axis><xyz>0 -1 0</xyz><limit><lower>-0.7</lower><upper>0.7</upper></limit></axis>"
DRIVE = '<plugin name="p" filename="f"><joint_name>crank</joint_name></plugin>'
CRANK = bar("crank", "0 0 0.1", "0.1 0 0.02")
OTHERS = (
    bar("base", "0 0 0", "0 0 0"),
    bar("coupler", "0 0 0.3", "0.1 0 0.02"),
    bar("rocker", "0.4 0 0.1", "0 0 0.1"),
    '<frame name="tcp" attached_to="coupler"><pose>0.5 0 0.05 0 0 0</pose></frame>',
    pin("crank", "base", "crank", axis=LIMITED),
    pin("knee", "crank", "coupler"),
)
LAST = pin("pin", "rocker", "coupler", at="<pose>0.4 0 0 0 0 0</pose>")
FOUR_BAR = in_model(CRANK, *OTHERS, pin("rocker", "base", "rocker"), LAST, DRIVE)


def four_bar(angle):
    """Return place and pitch of the tool, and the potential energy, of the four-bar at an angle of
    its crank: two circles.
    """
    knee = np.array([-0.2 * math.sin(angle), 0.1 + 0.2 * math.cos(angle)])
    foot = np.array([0.4, 0.1])
    way = foot - knee
    distance = np.linalg.norm(way)
    along = (0.4**2 - 0.2**2 + distance**2) / (2 * distance)
    across = math.sqrt(0.4**2 - along**2)
    unit = way / distance
    top = knee + along * unit + across * np.array([-unit[1], unit[0]])
    direction = (top - knee) / 0.4
    normal = np.array([-direction[1], direction[0]])
    rocker = (top - foot) / 0.2
    crank = (
        np.array([math.cos(angle), math.sin(angle)]),
        np.array([-math.sin(angle), math.cos(angle)]),
    )
    heights = (
        0.1 + (0.1 * crank[0] + 0.02 * crank[1])[1],
        (knee + 0.1 * direction + 0.02 * normal)[1],
        (foot + 0.1 * rocker)[1],
    )
    return knee + 0.5 * direction + 0.05 * normal, 0.5 * GRAVITY * sum(heights)


@pytest.mark.parametrize("order", ["as named", "from the other side", "turned round"])
def test_a_second_parent_closes_a_loop(tmp_path, order):
    """The joint of the second parent ends a branch, in whatever direction the joints lead; other
    joints of the loop are passive unless a plugin drives them.
    """
    text = FOUR_BAR
    if order == "from the other side":
        text = in_model(CRANK, *OTHERS, LAST, pin("rocker", "base", "rocker"), DRIVE)
    elif order == "turned round":  # the base is its child
        turned = pin("rocker", "rocker", "base", at="<pose>0.4 0 0.1 0 0 0</pose>")
        ground = pin("ground", "world", "base", "fixed", "")
        text = in_model(CRANK, *OTHERS, ground, turned, LAST, DRIVE)
    arm = read(written(tmp_path, text, 'tip = "tcp"'))
    assert [joint.name for joint in arm.driven] == ["crank"]
    assert len(arm.closures) == 1
    q = np.array([[-0.3], [0.0], [0.2]])
    state = state_of(arm, q)
    for (angle,), frame, (torque,) in zip(q, state.frames[-1], state.torques, strict=True):
        place, _ = four_bar(angle)
        np.testing.assert_allclose(frame[[0, 2], 3], place, atol=1e-12)
        slope = (four_bar(angle + STEP)[1] - four_bar(angle - STEP)[1]) / (2 * STEP)
        assert torque == pytest.approx(slope, abs=1e-6)


def test_a_loop_without_a_drive_asks_for_one(tmp_path):
    """SDF has no actuators; a plugin names them, or the sidecar."""
    path = written(tmp_path, FOUR_BAR.replace(DRIVE, ""), 'tip = "tcp"')
    (found,) = mistakes(path)
    assert "none of which an actuator moves" in found.found
    assert "<plugin>" in found.expected
    path.with_suffix(".toml").write_text(
        'tip = "tcp"\njoints = { crank = { passive = false } }', "utf-8"
    )
    assert [joint.name for joint in read(path).driven] == ["crank"]


@pytest.mark.parametrize(
    ("kind", "axis"),
    [("ball", ""), ("universal", f"{TURN}<axis2><xyz>0 0 1</xyz></axis2>")],
)
def test_the_closing_joint_may_have_more_freedoms(tmp_path, kind, axis):
    """In the plane a ball or a universal joint does what a pin does."""
    last = pin("pin", "rocker", "coupler", kind, axis, at="<pose>0.4 0 0 0 0 0</pose>")
    arm = read(written(tmp_path, FOUR_BAR.replace(LAST, last), 'tip = "tcp"'))
    frame = state_of(arm, np.array([[0.2]])).frames[-1, 0]
    np.testing.assert_allclose(frame[[0, 2], 3], four_bar(0.2)[0], atol=1e-12)


def test_a_fixed_joint_to_a_second_parent_welds(tmp_path):
    """The bodies that it joins are one."""
    stub = bar("stub", "0.4 0 0.3", "0 0 0", 1e-9)
    joints = pin("stub", "rocker", "stub"), pin("weld", "stub", "coupler", "fixed", "")
    arm = read(written(tmp_path, FOUR_BAR.replace(LAST, "".join((stub, *joints))), 'tip = "tcp"'))
    frame = state_of(arm, np.array([[0.2]])).frames[-1, 0]
    np.testing.assert_allclose(frame[[0, 2], 3], four_bar(0.2)[0], atol=1e-12)


CHAIN = in_model(
    bar("base", "0 0 0", "0 0 0"),
    bar("upper", "0 0 0.1", "0 0 0.1"),
    bar("hand", "0 0 0.4", "0 0 0.1"),
    pin("j1", "base", "upper", axis=LIMITED),
    pin("j2", "upper", "hand", axis=LIMITED),
)
PART = in_model(
    bar("palm", "0 0 0", "0 0 0.02", 0.3), '<frame name="tcp"><pose>0 0 0.1 0 0 0</pose></frame>'
)


def test_an_include_is_read_within_the_project(tmp_path):
    """By its folder or its file; its names begin with its own, and one text holds all of it."""
    (tmp_path / ".git").mkdir()
    folder = tmp_path / "models" / "gripper"
    folder.mkdir(parents=True)
    (folder / "model.config").write_text("<model><sdf version='1.9'>g.sdf</sdf></model>", "utf-8")
    (folder / "g.sdf").write_text(PART, "utf-8")
    (tmp_path / "arm").mkdir()
    include = (
        "<include><uri>model://gripper</uri><name>tool</name>"
        '<pose relative_to="hand">0 0 0.2 0 0 0</pose></include>'
        + pin("mount", "hand", "tool", "fixed", "")
    )
    path = written(tmp_path / "arm", CHAIN.replace("</model>", f"{include}</model>"))
    arm = read(path)
    assert "tool::tcp" in arm.notes[-1] + arm.notes[0]
    frame = state_of(arm, np.zeros((1, 2))).frames[-1, 0]
    np.testing.assert_allclose(frame[:3, 3], [0, 0, 0.7], atol=1e-12)
    alone = tmp_path / "alone"
    alone.mkdir()
    (text,) = texts(path, None, ()).values()
    assert "include" not in text
    assert read(written(alone, text)).joints == arm.joints


@pytest.mark.parametrize(
    "uri", ["/etc/passwd", "../secret.sdf", "model://../secret", "https://x.y/z"]
)
def test_an_include_outside_the_project_is_refused(tmp_path, uri):
    """Whatever is there."""
    (tmp_path / "secret.sdf").write_text(PART, "utf-8")
    inner = tmp_path / "inner"
    inner.mkdir()
    include = f"<include><uri>{uri}</uri></include></model>"
    (found,) = mistakes(written(inner, CHAIN.replace("</model>", include)))
    assert uri in found.found
    assert found.file.endswith("arm.sdf:8")


def test_an_include_of_itself_ends(tmp_path):
    """Before it fills the memory."""
    include = "<include><uri>arm.sdf</uri></include></model>"
    (found,) = mistakes(written(tmp_path, CHAIN.replace("</model>", include)))
    assert "includes itself" in found.found


@pytest.mark.parametrize(
    ("old", "new_words", "found", "line"),
    [
        ("0 0 0.4 0 0 0", "0 0 x 0 0 0", "0 0 x", 5),
        ("0 0 0.4 0 0 0", "0 0 0.4", "0 0 0.4", 5),
        ("<parent>upper", "<parent>uper", "uper", 7),
        ("<child>hand", "<child>upper", "itself", 7),
        ('version="1.9"', 'version="1.2"', "1.2", 1),
        (' version="1.9"', "", "no version", 1),
        ("<pose>0 0 0.4", '<pose relative_to="hand">0 0 0.4', "round to itself", 5),
        ("<pose>0 0 0.4", '<pose rotation_format="axis">0 0 0.4', "axis", 5),
        ("<pose>0 0 0.4", "<pose>1e15 0 0.4", "1e15", 5),
        ("<mass>0.5", "<mass>-0.5", "-0.5 kg", 4),
        ('name="hand"', 'name="upper"', "twice", 5),
        ('"j2" type="revolute"', '"j2" type="screw"', "screw", 7),
        ('"j2" type="revolute"', '"j2" type="revolut"', "revolut", 7),
        ('"j2" type="revolute"', '"j2" type="ball"', "ball", 7),
        ("0 -1 0", "0 0 0", "0 0 0", 6),
        ("<lower>-0.7", "<lower>0.9", "limits from 0.9 to 0.7", 6),
        ("<upper>0.7", "<upper>inf", "limits from -0.7 to inf", 6),
        ("<xyz>", '<xyz expressed_in="tool">', "tool", 6),
    ],
)
def test_a_mistake_is_reported_at_its_line(tmp_path, old, new_words, found, line):
    """With what was found, what is expected, and an example."""
    text = CHAIN.replace(old, new_words)
    assert text != CHAIN
    problems = mistakes(written(tmp_path, text))
    assert any(found in each.found and each.file.endswith(f":{line}") for each in problems)


def test_all_mistakes_are_reported_at_once(tmp_path):
    """Three of three."""
    text = CHAIN.replace("0 0 0.4 0", "0 0 x 0").replace("<mass>0.5", "<mass>y", 1)
    text = text.replace("<parent>upper", "<parent>uper")
    assert len(mistakes(written(tmp_path, text))) == 3


def test_what_is_not_carried_over_is_noted(tmp_path):
    """Springs, extensions, masses that the format assumes, other models of a world."""
    text = CHAIN.replace(
        "</axis>", "<dynamics><spring_stiffness>3</spring_stiffness></dynamics></axis>"
    )
    text = text.replace("</model>", '<link name="bare"/><drake:ball_constraint/></model>')
    text = text.replace("</model>", pin("b", "hand", "bare", "fixed", "") + "</model>")
    text = text.replace(
        "<model", '<world name="w"><model name="floor"><link name="f"/></model><model', 1
    )
    arm = read(written(tmp_path, text.replace("</sdf>", "</world></sdf>")))
    notes = "\n".join(arm.notes)
    for words in (
        "springs of j1, j2",
        "ball_constraint",
        "no <inertial>",
        "bare",
        "floor",
        "drake:",
    ):
        assert words in notes


def test_new_writes_a_sidecar_that_is_read(tmp_path, monkeypatch):
    """As for a URDF."""
    monkeypatch.chdir(tmp_path)
    path = written(tmp_path, CHAIN)
    new(urdf=path).report()
    assert "what SDF cannot state" in path.with_suffix(".toml").read_text("utf-8")
    assert [joint.name for joint in read(path).driven] == ["j1", "j2"]
