"""What is met in public URDF files: what is passed over, held, repaired, warned of and refused."""

from __future__ import annotations

import pytest

from lostmotion.analyses.accuracy.command import study
from lostmotion.io import read
from lostmotion.parts.joint import FixedJoint
from tests.io.conftest import mistakes
from tests.io.urdfs import LIMIT, agrees_with_pinocchio, arm, joint, link, robot


@pytest.fixture
def urdf(tmp_path):
    """Write a URDF, and a sidecar where there is one."""

    def write(text, sidecar=None, name="r.urdf"):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        if sidecar is not None:
            path.with_suffix(".toml").write_text(sidecar, encoding="utf-8")
        return path

    return write


def noted(arm, words):
    """Return whether a note or a warning of the arm contains these words."""
    return any(words in note for note in (*arm.notes, *arm.warnings))


@pytest.mark.parametrize(
    "rest",
    [
        '<axis xyz="0 0 0"/>',
        '<limit lower="1" upper="-1"/>',
        '<mimic joint="nobody"/>',
        '<dynamics damping="x"/>',
        '<axis xyz="what"/>',
    ],
)
def test_a_fixed_joint_has_no_axis_limits_mimic_or_dynamics(urdf, rest):
    """CAD exporters write zeros and more there, and nobody reads them."""
    path = urdf(robot(*arm(), joint("mount", "link3 tool0", "fixed", rest), link("tool0", 0)))
    found = read(path)
    assert [each.name for each in found.joints] == ["j1", "j2", "j3", "mount"]


def test_a_zero_axis_is_refused_where_the_joint_moves_the_tool(urdf):
    """And named with its line."""
    path = urdf(robot(*arm()).replace('"0 1 0"', '"0 0 0"', 1))
    (found,) = mistakes(path)
    assert (found.file, found.key) == (f"{path}:3", '/robot/joint[@name="j1"]/axis/@xyz')


@pytest.mark.parametrize(
    ("rest", "words"),
    [
        (f'<axis xyz="0 0 0"/>{LIMIT}', "'0 0 0'"),
        ('<limit effort="1" velocity="1"/>', "a limit without lower and upper"),
        ("", "no limit"),
        ('<limit lower="1" upper="0"/>', "limits from 1 to 0"),
    ],
)
def test_a_mistake_beside_the_chain_is_held_at_zero_with_a_note(urdf, rest, words):
    """Only the mass of a side branch counts, and it counts."""
    parts = [*arm(), joint("mount", "link3 tool0", "fixed", ""), link("tool0", 0)]
    side = urdf(robot(*parts, joint("flap", "link1 plate", "revolute", rest), link("plate", 3)))
    found = read(side)
    assert len(found.moving) == 3
    assert noted(found, f"flap: {words}")
    fixed = urdf(robot(*parts, joint("flap", "link1 plate", "fixed", ""), link("plate", 3)))
    assert found.joints == read(fixed).joints
    agrees_with_pinocchio(fixed, found, "tool0")


def test_a_joint_that_cannot_move_is_fixed_where_its_limits_say(urdf):
    """Lower = upper on the chain: nothing moves there, and the arm is the one that Pinocchio sees
    at that value.
    """
    path = urdf(robot(*arm(4)).replace('lower="-1" upper="1.2"', 'lower="0.4" upper="0.4"', 1))
    found = read(path)
    assert isinstance(found.joints[0], FixedJoint)
    assert len(found.moving) == 3
    assert noted(found, "joint 'j1' cannot move")
    agrees_with_pinocchio(path, found, "link4", held={"j1": 0.4})


@pytest.mark.parametrize("limit", ['<limit effort="1" velocity="1"/>', ""])
def test_omitted_limits_on_the_chain_are_refused(urdf, limit):
    """The range decides every figure; both limits default to 0 in URDF."""
    (found,) = mistakes(urdf(robot(*arm()).replace(LIMIT, limit, 1)))
    assert found.key == '/robot/joint[@name="j1"]'
    assert "both default to 0" in found.expected


def test_a_joint_that_follows_another_is_held_beside_the_chain(urdf):
    """As in Pinocchio's neutral pose."""
    follower = joint(
        "right",
        "link3 f2",
        "prismatic",
        f'<axis xyz="0 1 0"/>{LIMIT}<mimic joint="left" multiplier="-1" offset="0.02"/>',
    )
    path = urdf(
        robot(
            *arm(),
            joint("left", "link3 f1", "prismatic"),
            link("f1", 0.2),
            follower,
            link("f2", 0.2),
        )
    )
    found = read(path)
    assert [each.name for each in found.moving] == ["j1", "j2", "j3"]
    assert noted(
        found, "not taken: left, right (2 joints on link 'link3', held at zero, 0.4 kg carried)"
    )
    agrees_with_pinocchio(path, found, "link3")


def test_a_joint_that_follows_another_on_the_chain_is_refused_by_name(urdf):
    """A linkage that keeps the wrist level is not modelled; the message says how it is coupled, and
    the tip before it that would do.
    """
    parts = [*arm(4), joint("mount", "link4 tool0", "fixed", ""), link("tool0", 0)]
    path = urdf(
        robot(*parts).replace(
            (
                '<child link="link4"/><origin xyz="0.3 0 0.1" rpy="0.2 0.1 0"/><axis xyz="0 1 '
                f'0"/>{LIMIT}'
            ),
            _FOLLOWING,
        )
    )
    (found,) = mistakes(path)
    assert found.key == '/robot/joint[@name="j4"]'
    assert "joint 'j4' follows 'j2' (mimic, x -1, offset 0.3)" in found.found
    assert "link3" in found.expected
    path.with_suffix(".toml").write_text(found.example, encoding="utf-8")
    assert len(read(path).moving) == 3


_FOLLOWING = (
    '<child link="link4"/><origin xyz="0.3 0 0.1" rpy="0.2 0.1 0"/><axis xyz="0 1 0"/>'
    + LIMIT
    + '<mimic joint="j2" multiplier="-1" offset="0.3"/>'
)


def test_zero_outside_a_held_joints_limits_is_reported(urdf):
    """A jaw at an impossible place shifts the centre of mass."""
    path = urdf(
        robot(
            *arm(),
            joint(
                "finger",
                "link3 jaw",
                "prismatic",
                '<axis xyz="1 0 0"/><limit lower="0.2" upper="0.3"/>',
            ),
            link("jaw", 1),
        )
    )
    assert noted(read(path), "held at zero, outside their limits: finger")


@pytest.mark.parametrize(
    ("change", "note"),
    [
        (lambda text: "\n\n  " + '<?xml version="1.0"?>\n' + text, "line 3: an XML declaration"),
        (
            lambda text: "Copyright: nobody\n" + '<?xml version="1.0"?>\n' + text,
            "line 1: text before the first tag",
        ),
        (lambda text: '<?xml version="0.0"?>' + text, "line 1: an XML declaration"),
        (
            lambda text: text.replace("<link", '<?xml version="1.0"?><link', 1),
            "line 2: an XML declaration",
        ),
        (
            lambda text: text.replace("<link", "<!---- the arm --\n-- it is -->\n<link", 1),
            "line 2: a comment with -- inside",
        ),
        (lambda text: text + "\nend of file", ": text after the last tag"),
        (
            lambda text: text.replace("</robot>", '\n<drake:tag gazebo:a="1"/></robot>'),
            "the prefix 'drake:' is never declared",
        ),
    ],
)
def test_text_that_is_not_quite_xml_is_repaired_with_its_line(urdf, change, note):
    """Every reader that people use lets it through, and nothing in the arm depends on it."""
    plain = read(urdf(robot(*arm())))
    found = read(urdf(change(robot(*arm()))))
    assert found.joints == plain.joints
    assert noted(found, note)


def test_a_byte_order_mark_and_a_default_namespace_say_nothing(urdf):
    """Neither is part of URDF; other readers pass over both."""
    plain = read(urdf(robot(*arm())))
    text = robot(*arm()).replace("<robot", '<robot xmlns="http://example.com"', 1)
    assert read(urdf(b"\xef\xbb\xbf" + text.encode())) == plain


def test_old_letters_are_read_with_a_note(urdf):
    """Latin-1 in a comment or a name, from programs that know nothing else."""
    found = read(
        urdf(
            b"\n<!-- Gr\xf6\xdfe -->" + robot(*arm()).replace("j2", "gr\xf6\xdfe").encode("latin-1")
        )
    )
    assert found.moving[1].name == "gr\xf6\xdfe"
    assert noted(found, "line 2: not UTF-8; the file is read as Latin-1")


@pytest.mark.parametrize(
    "left",
    [
        '<xacro:property name="width" value="3"/>',
        '<xacro:macro name="m"><link name="${prefix}x"/></xacro:macro>',
        '<gazebo reference="${x}"/>',
        '<material name="${colour}"/>',
    ],
)
def test_xacro_that_changes_nothing_is_passed_over(urdf, left):
    """Often only colours are left over."""
    text = robot(*arm(), left)
    found = read(urdf(text.replace("<robot", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"')))
    assert found.joints == read(urdf(robot(*arm()))).joints


def test_a_file_that_xacro_would_include_is_named(urdf):
    """It may add bodies."""
    text = robot(*arm(), '<xacro:include filename="gripper.xacro"/>')
    assert noted(read(urdf(text)), "'gripper.xacro' is not read")


@pytest.mark.parametrize(
    "left",
    [
        '<link name="${prefix}x"/>',
        '<xacro:gripper prefix="a"/>',
        '<link name="x"><xacro:box_inertia m="1"/></link>',
        '<link name="$(arg x)"/>',
    ],
)
@pytest.mark.parametrize("declared", [True, False])
def test_xacro_that_counts_is_named_with_what_to_do(urdf, left, declared):
    """A link or joint that is still to be computed, or a macro that nobody called; the prefix may
    be declared or not.
    """
    text = robot(*arm(), left)
    text = (
        text.replace("<robot", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"')
        if declared
        else text
    )
    (found,) = mistakes(urdf(text))
    assert found.found.startswith("this is xacro")
    assert "arm.urdf.xacro" in found.example


def test_macros_alone_are_xacro(urdf):
    """A file that only defines macros has no link of its own: it is named as xacro, not as a URDF
    that lacks its links.
    """
    macro = '<xacro:macro name="m"><link name="a"/><link name="b"/></xacro:macro>'
    (found,) = mistakes(
        urdf(robot(macro).replace("<robot", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"'))
    )
    assert found.found.startswith("this is xacro")


@pytest.mark.parametrize("ending", [".urdf", ".xml", ".sdf", ".mjcf", ".xacro", ".toml", ""])
@pytest.mark.parametrize(
    ("text", "name"),
    [
        ('<mujoco model="x"><worldbody/></mujoco>', "MJCF (MuJoCo)"),
        ('<?xml version="1.0"?><!-- <robot> --><sdf version="1.6"/>', "SDF (Gazebo)"),
        ('<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arm/></robot>', "xacro"),
        ("<!DOCTYPE html><html></html>", "a web page"),
        ("\n<!doctype html>\n<html><br></html>", "a web page"),
    ],
)
def test_a_format_is_named_by_its_root_element(urdf, text, name, ending):
    """Whatever the ending, with what to do next."""
    (found,) = mistakes(urdf(text, name=f"r{ending}"))
    if name == ending[1:]:  # it is what its ending says, and is expanded
        assert "unknown macro" in found.found
    elif name == "MJCF (MuJoCo)" and ending != ".toml":  # which is read
        assert "no joint that moves" in found.found
    elif name == "SDF (Gazebo)" and ending != ".toml":
        assert "no model" in found.found
    else:
        assert f"this is {name}" in found.found
    assert found.expected


def test_a_urdf_is_read_whatever_its_ending(urdf):
    """The root element says what it is; only a TOML is another file's name."""
    text = robot(*arm())
    plain = read(urdf(text)).joints
    assert read(urdf(text, name="r.xacro")).joints == plain
    assert read(urdf(text, name="r.urdf.xml")).joints == plain
    (found,) = mistakes(urdf(text, name="r.toml"))
    assert "URDF" in found.found


def test_a_weightless_arm_is_warned_of_first(urdf):
    """Older packages describe shapes only: all that gravity does is missing."""
    bare = [part for part in arm() if part.startswith("<joint")] + [
        link(name, 0) for name in ("base", "link1", "link2", "link3")
    ]
    path = urdf(robot(*bare))
    assert "no link of this arm has a mass" in read(path).warnings[0]
    path.with_suffix(".toml").write_text(
        '[joints.j1]\nlink = { mass = "2 kg" }\n', encoding="utf-8"
    )
    assert not noted(read(path), "no link of this arm has a mass")
    assert "nothing that moves with j2, j3 alone has a mass" in read(path).warnings[0]


@pytest.mark.parametrize(
    ("parts", "note"),
    [
        ([link("base"), *(link(f"link{k}", 1) for k in (1, 2, 3))], "every link weighs 1 kg"),
        (
            [link("base"), *(link(f"link{k}", k, "0 0 0") for k in (1, 2, 3))],
            "every centre of mass lies at its link's origin",
        ),
        (
            [link("base"), *(link(f"link{k}", 900 + k) for k in (1, 2, 3))],
            "the arm weighs 2.71e+03 kg",
        ),
        (
            [link("base"), *(link(f"link{k}", 1e-4 * k) for k in (1, 2, 3))],
            "the arm weighs 0.0006 kg",
        ),
        (
            [link("base"), link("link1", 2), link("link2", 0), link("link3", 3)],
            "nothing that moves with j2 alone has a mass",
        ),
    ],
)
def test_masses_that_look_like_placeholders_are_warned_of(urdf, parts, note):
    """They are read: the kinematics may be right all the same."""
    joints = [part for part in arm() if part.startswith("<joint")]
    assert note in read(urdf(robot(*joints, *parts))).warnings[0]


@pytest.mark.parametrize(
    ("origin", "length"),
    [("300 0 100", "949 m"), ("3000 0 1000", "9490 m"), ("0.003 0 0.001", "0.00949 m")],
)
def test_lengths_in_millimetres_are_warned_of(urdf, origin, length):
    """Exporters write millimetres; no arm is 15 m long, none 5 cm."""
    found = read(urdf(robot(*arm()).replace('"0.3 0 0.1"', f'"{origin}"')))
    assert f"add up to {length}: are they in metres" in found.warnings[0]


def test_a_range_over_two_turns_is_warned_of(urdf):
    """Poses are drawn over it; two turns are what some wrists have."""
    found = read(
        urdf(robot(*arm()).replace('lower="-1" upper="1.2"', 'lower="-6.2832" upper="6.2832"', 1))
    )
    assert not noted(found, "more than twice around")
    found = read(
        urdf(robot(*arm()).replace('lower="-1" upper="1.2"', 'lower="-1e6" upper="1e6"', 1))
    )
    assert "j1 may turn more than twice around" in found.warnings[0]


def test_long_names_beside_the_chain_are_nobodys_concern(urdf):
    """Programs join the names of parts; only the arm's own joints stand in tables."""
    found = read(
        urdf(robot(*arm(), joint("x" * 150, "link2 " + "y" * 150, "fixed", ""), link("y" * 150)))
    )
    assert len(found.joints) == 3


def test_a_balancer_is_named(urdf):
    """A URDF has no springs, so the shoulder seems to carry more than it does."""
    rod = joint("balance_rod", "link1 piston", "prismatic")
    assert noted(
        read(urdf(robot(*arm(), rod, link("piston", 2)))), "springs and balancers are not in a URDF"
    )


def test_a_free_root_is_held(urdf):
    """Humanoids float; the arm on them is studied where they stand."""
    parts = [link("world", 0), joint("free", "world base", "floating", ""), *arm()]
    path = urdf(robot(*parts))
    found = read(path)
    assert len(found.moving) == 3
    assert noted(found, "joint 'free' (floating) carries the whole arm: it is held at zero")
    agrees_with_pinocchio(urdf(robot(*parts).replace("floating", "fixed")), found, "link3")


def test_the_chain_may_start_at_a_link_of_the_tree(urdf):
    """On a body that leans: gravity stands on the arm as in the file, and the tool is seen from
    that link.
    """
    parts = [
        link("wheels", 30),
        joint("lift", "wheels torso", "prismatic", origin='xyz="0 0 0.5" rpy="0.3 -0.4 0.7"'),
        *arm(root="torso"),
    ]
    path = urdf(robot(*parts), 'base = "torso"\n')
    found = read(path)
    assert [each.name for each in found.joints] == ["j1", "j2", "j3"]
    assert noted(found, "the chain starts at link 'torso'; lift before it held at zero")
    agrees_with_pinocchio(path, found, "link3", base="torso")
    path.with_suffix(".toml").write_text(
        'tip = "link2"\n[base]\nlink = "torso"\nroll = "0 deg"\npitch = "0 deg"\n', encoding="utf-8"
    )
    level = read(path)
    assert len(level.joints) == 2
    assert level.base.roll.nominal == 0


@pytest.mark.parametrize(
    ("sidecar", "key"),
    [('base = "tors"', "base"), ("base = 3", "base"), ('[base]\nlink = "tors"', "base.link")],
)
def test_a_base_that_is_no_link_is_refused(urdf, sidecar, key):
    """With the nearest name."""
    parts = [link("wheels", 30), joint("lift", "wheels torso", "prismatic"), *arm(root="torso")]
    (found,) = mistakes(urdf(robot(*parts), sidecar))
    assert found.key == key
    assert found.nearest == ("" if "3" in sidecar else "torso")


def test_the_base_that_is_suggested_leads_to_an_arm(urdf):
    """Not the link of a like name at the end of the arm."""
    parts = [
        link("wheels", 30),
        joint("lift", "wheels torso", "prismatic"),
        *arm(root="torso"),
        joint("m", "link3 torso_", "fixed", ""),
        link("torso_"),
    ]
    path = urdf(robot(*parts), 'base = "torso__"\n')
    (found,) = mistakes(path)
    path.with_suffix(".toml").write_text(found.example, encoding="utf-8")
    assert len(read(path).moving) == 3


def test_a_tip_must_stand_behind_the_base(urdf):
    """Else no chain leads from one to the other; the example does."""
    path = urdf(robot(*arm(4)), 'base = "link3"\ntip = "link1"')
    (found,) = mistakes(path)
    assert found.key == "tip"
    path.with_suffix(".toml").write_text(f'base = "link3"\n{found.example}', encoding="utf-8")
    assert len(read(path).moving) == 1


def test_a_doubt_is_a_warning_of_every_command(urdf):
    """It stands with the verdict on the first screen, not among the notes, and outlives a change of
    the arm.
    """
    parts = [part for part in arm() if part.startswith("<joint")] + [
        link(name, 0) for name in ("base", "link1", "link2", "link3")
    ]
    path = urdf(robot(*parts), '[joints.j1]\nlumped = { angle = "1 arcmin" }\n')
    found = read(path)
    assert found.model_copy(update={"gravity": 3.7}).warnings == found.warnings
    sheets = [study(found, 8, 10, 2, 1).sheet, study(found, 8, method="analytic").sheet]
    for sheet in sheets:
        assert any("no link of this arm has a mass" in warning for warning in sheet.warnings)
