"""Which link is the tool: names first, then structure, never between two arms; and a hint that is
followed is never refused.
"""

from __future__ import annotations

import random
import re

import pytest

from lostmotion.errors import InputError
from lostmotion.io import read
from tests.io.conftest import mistakes
from tests.io.urdfs import LIMIT, arm, joint, link, robot


def fixed(name, parent, mass=0):
    """Return a link that is fixed to another."""
    return [joint(f"to_{name}", f"{parent} {name}", "fixed", ""), link(name, mass)]


def sliding(name, parent, child, rest=""):
    """Return a joint that slides."""
    return [
        joint(name, f"{parent} {child}", "prismatic", f'<axis xyz="0 1 0"/>{LIMIT}{rest}'),
        link(child, 0.1),
    ]


def turning(name, parent, child, rest=""):
    """Return a joint that turns."""
    return [
        joint(name, f"{parent} {child}", "revolute", f'<axis xyz="0 1 0"/>{LIMIT}{rest}'),
        link(child, 0.1),
    ]


@pytest.fixture
def taken(tmp_path):
    """Return what is noted as the tool of a URDF of these parts, and the arm."""

    def of(*parts):
        path = tmp_path / "r.urdf"
        path.write_text(robot(*parts), encoding="utf-8")
        found = read(path)
        return next(note for note in found.notes if note.startswith("tool:")), found

    return of


PANDA = [
    *fixed("panda_hand", "link3", 0.7),
    *fixed("panda_hand_tcp", "panda_hand"),
    *sliding("panda_finger_joint1", "panda_hand", "panda_leftfinger"),
    *sliding("panda_finger_joint2", "panda_hand", "panda_rightfinger"),
]


@pytest.mark.parametrize(
    ("parts", "tool"),
    [
        (PANDA, "panda_hand_tcp"),
        (
            [
                *fixed("flange", "link3"),
                *fixed("tool0", "flange"),
                *fixed("camera_link", "tool0", 0.2),
            ],
            "tool0",
        ),
        ([*fixed("ee_link", "link3"), *fixed("tool0", "link3")], "tool0"),
        ([*fixed("my-Flange", "link3", 0.3), *fixed("cover", "my-Flange", 0.3)], "my-Flange"),
        ([*fixed("gripper_base", "link3"), *fixed("grasp_point", "gripper_base")], "grasp_point"),
        ([*fixed("leftToolFrame", "link3"), *fixed("hand", "link3")], "leftToolFrame"),
        (
            [*turning("gripper", "link3", "moving_jaw"), *fixed("tcp_of_nothing_else", "link3")],
            "tcp_of_nothing_else",
        ),
        (
            [
                *turning("joint_6", "link3", "gripper"),
                *fixed("gripper_tcp", "link3"),
                *fixed("gripper_tcp2", "gripper"),
            ],
            "gripper_tcp",
        ),
        ([*fixed("tool0_controller", "link3"), *fixed("ur_tool0_link", "link3")], "ur_tool0_link"),
        (
            [
                *turning("left_knuckle", "link3", "lk"),
                *turning("lk_tip", "lk", "left_tip"),
                *fixed("hand", "link3"),
            ],
            "hand",
        ),
    ],
)
def test_the_name_decides(taken, parts, tool):
    """A person reads `tcp`, `tool0` and `flange` before counting joints; the choice is stated, and
    its alternatives.
    """
    note, found = taken(*arm(), *parts)
    assert note.startswith(f"tool: {tool}, 3 joints (by its name")
    assert not any("guess" in warning for warning in found.warnings)
    assert 'tip = "..." changes it' in note
    assert len(found.moving) == 3


def test_the_others_are_listed(taken):
    """The note names the frames that could be meant as well."""
    note, _ = taken(*arm(), *PANDA)
    assert note == (
        'tool: panda_hand_tcp, 3 joints (by its name; others: panda_hand; tip = "..." changes it)'
    )


@pytest.mark.parametrize(
    ("parts", "tool", "joints"),
    [
        (turning("jaw", "link3", "j"), "link3", 3),
        (turning("gripper_joint", "link3", "claw"), "link3", 3),
        ([*turning("jointGripper", "link3", "gripperMover")], "link3", 3),
        ([*sliding("s1", "link3", "a"), *sliding("s2", "link3", "b")], "link3", 3),
        (
            [
                *turning("wrist_roll", "link3", "gripper_finger_holder"),
                *sliding("finger", "gripper_finger_holder", "f"),
            ],
            "gripper_finger_holder",
            4,
        ),
        ([*turning("cyl", "link1", "cylinder"), *sliding("rod", "cylinder", "piston")], "link3", 3),
        (
            [
                *turning("neck", "base", "n1"),
                *turning("n2", "n1", "n2"),
                *turning("n3", "n2", "n3"),
                *turning("n4", "n3", "head"),
            ],
            "link3",
            3,
        ),
        (turning("front_wheel", "base", "w"), "link3", 3),
        ([*fixed("frame", "link3"), *fixed("plate", "link3", 0.3)], "frame", 3),
    ],
)
def test_without_a_name_the_structure_decides_with_a_warning(taken, parts, tool, joints):
    """Jaws, balancers, heads and wheels are no arm; of what is left the longest chain is, and a
    pure frame at its end before a body.
    """
    note, found = taken(*arm(), *parts)
    assert note.startswith(f"tool: {tool}, {joints} joints (a guess by the structure")
    assert found.warnings[-1].startswith(f"the tool is a guess: link '{tool}'")
    assert len(found.moving) == joints


def test_fingers_without_a_fingers_name_are_a_hand(taken):
    """Several short ends on one link behind a long chain."""
    parts = [part for k in range(3) for part in turning(f"m{k}", "link5", f"p{k}")]
    note, found = taken(*arm(5), *parts)
    assert note.startswith("tool: link5, 5 joints (a guess")
    assert len(found.moving) == 5


def test_hands_of_two_arms_are_not_ends_of_arms(tmp_path):
    """The arms are listed, not their fingers."""
    parts = [link("torso")]
    for side in ("left", "right"):
        parts += arm(5, "torso", f"{side}_link", f"{side}_j")[1:]
        parts += [
            part
            for k in range(3)
            for part in turning(f"{side}_m{k}", f"{side}_link5", f"{side}_p{k}")
        ]
    path = tmp_path / "r.urdf"
    path.write_text(robot(*parts), encoding="utf-8")
    (found,) = mistakes(path)
    assert (
        found.found == "which of 2 arms? left: left_link5 (5 joints), right: right_link5 (5 joints)"
    )


def test_a_gripper_alone_is_read(taken):
    """Where everything is a finger nothing is omitted."""
    note, found = taken(
        link("base"),
        *turning("finger_1", "base", "finger_link_1"),
        *turning("finger_2", "finger_link_1", "finger_link_2"),
    )
    assert note.startswith("tool: finger_link_2, 2 joints (a guess")
    assert len(found.moving) == 2


def two_arms(left="left", right="right", tool="tcp"):
    """Return a torso with two arms."""
    return [
        link("torso"),
        *(
            part
            for side in (left, right)
            for part in arm(3, "torso", f"{side}_link", f"{side}_j")[1:]
        ),
        *fixed(f"{left}_{tool}", f"{left}_link3"),
        *fixed(f"{right}_{tool}", f"{right}_link3"),
    ]


@pytest.mark.parametrize(("left", "right"), [("left", "right"), ("L", "R"), ("arm_1", "arm_2")])
def test_two_arms_are_never_chosen_between(tmp_path, left, right):
    """The ends of the arms are listed, and nothing but them; the line to write names one of
    them.
    """
    path = tmp_path / "r.urdf"
    path.write_text(
        robot(*two_arms(left, right), *turning("head", "torso", "camera")), encoding="utf-8"
    )
    (found,) = mistakes(path)
    assert found.found.startswith("which of 2 arms? ")
    assert f"{left}_tcp (3 joints)" in found.found
    assert f"{right}_tcp (3 joints)" in found.found
    assert "camera" not in found.found
    assert found.example == f'tip = "{left}_tcp"'
    assert "r.toml" in found.expected


def test_arms_are_labelled_by_their_sides(tmp_path):
    """As they are called in the file."""
    path = tmp_path / "r.urdf"
    path.write_text(robot(*two_arms()), encoding="utf-8")
    (found,) = mistakes(path)
    assert found.found == "which of 2 arms? left: left_tcp (3 joints), right: right_tcp (3 joints)"


def test_a_tool_behind_a_linkage_is_not_replaced_by_what_stands_before_it(tmp_path):
    """An arm cut off before its wrist would be another arm: the linkage is refused by name."""
    parts = [
        *arm(3),
        *turning("level", "link3", "wrist", '<mimic joint="j2"/>'),
        *turning("j5", "wrist", "end"),
        *fixed("tool0", "end"),
    ]
    path = tmp_path / "r.urdf"
    path.write_text(robot(*parts), encoding="utf-8")
    (found,) = mistakes(path)
    assert "joint 'level' follows 'j2'" in found.found
    assert found.example == 'tip = "link3"'


_NAMES = (
    *(
        "link",
        "tool0",
        "left_tcp",
        "right_tcp",
        "hand",
        "finger_l",
        "finger_r",
        "camera",
        "wheel",
        "piston",
        "ee_link",
        "wrist",
    ),
    *(
        "flange",
        "cover",
        "head",
        "elbow",
        "knee",
        "jaw",
        "a/b",
        "x y",
        "tcp.1",
        "o'clock",
        'q"q',
        "b\\s",
        "ä",
        "[3]",
        "k=3",
    ),
)


_ODD_LIMITS = (
    '<limit lower="0.1" upper="0.1"/>',
    '<limit effort="1"/>',
    '<limit lower="2" upper="1"/>',
)


def synthetic_tree(rng):
    """Return a random tree: any names, kinds, mistakes and couplings."""
    parts, links = ['<link name="root"/>'], ["root"]
    names = []
    for k in range(rng.randint(1, 12)):
        child = f"{rng.choice(_NAMES)}{k}"
        name = f"{rng.choice(_NAMES)}_{k}"
        kind = rng.choice(
            [
                "revolute",
                "revolute",
                "revolute",
                "continuous",
                "prismatic",
                "fixed",
                "fixed",
                "floating",
                "planar",
                "screw",
            ]
        )
        axis = rng.choice(["0 0 1", "0 1 0", "1 0 0", "1 0 0", "0 0 0"])
        limit = rng.choice(
            [
                LIMIT,
                LIMIT,
                LIMIT,
                LIMIT,
                "",
                '<limit lower="0.1" upper="0.1"/>',
                '<limit effort="1"/>',
                '<limit lower="2" upper="1"/>',
            ]
        )
        mimic = (
            f"<mimic joint={_quoted(rng.choice(names))}/>" if names and rng.random() < 0.15 else ""
        )
        parent = rng.choice(links[-4:])
        ends = f"<parent link={_quoted(parent)}/><child link={_quoted(child)}/>"
        parts.append(
            f'<joint name={_quoted(name)} type="{kind}">{ends}<axis '
            f'xyz="{axis}"/>{limit}{mimic}</joint>'
        )
        parts.append(f"<link name={_quoted(child)}/>")
        links.append(child)
        names.append(name)
    return robot(*parts)


def _quoted(name):
    return '"' + name.replace('"', "&quot;") + '"'


def test_a_hint_that_is_followed_is_never_refused(tmp_path):
    """Of 400 synthetic trees every one is read, or refused without a hint, or read after its
    hint.
    """
    rng = random.Random(19)  # noqa: S311 - trees, not secrets
    path, sidecar = tmp_path / "r.urdf", tmp_path / "r.toml"
    followed = 0
    for _ in range(400):
        path.write_text(synthetic_tree(rng), encoding="utf-8")
        sidecar.unlink(missing_ok=True)
        try:
            read(path)
            continue
        except InputError as error:
            hint = next(
                (
                    problem.example
                    for problem in error.problems
                    if re.match(r"(tip|base) = ", problem.example)
                ),
                None,
            )
        if hint is not None:
            sidecar.write_text(hint, encoding="utf-8")
            assert read(path).moving
            followed += 1
    assert followed > 20
