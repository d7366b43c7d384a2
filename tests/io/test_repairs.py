"""Repairs of a description by its sidecar, and what keeps a cart's slide from being taken for a
joint of the arm.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.io import read
from lostmotion.mechanism.state import state_of
from tests.io.conftest import mistakes
from tests.io.test_mjcf import INERTIAL, model
from tests.io.urdfs import agrees_with_pinocchio, arm, joint, link, robot

NO_LIMITS = joint("j1", "base link1", rest='<axis xyz="0 1 0"/><limit effort="1" velocity="1"/>')
LOCKED = joint(
    "j1",
    "base link1",
    rest='<axis xyz="0 1 0"/><limit lower="0" upper="0" effort="1" velocity="1"/>',
)
ENDLESS = joint("j1", "base link1", "continuous", '<axis xyz="0 1 0"/>')
SLIDE = joint("j1", "base link1", "prismatic", '<axis xyz="0 1 0"/>')


@pytest.fixture
def written(tmp_path):
    """Return the file of a URDF of these parts, with a sidecar where one is given."""

    def write(*parts, sidecar=""):
        path = tmp_path / "r.urdf"
        path.write_text(robot(*parts), encoding="utf-8")
        path.with_suffix(".toml").unlink(missing_ok=True)
        if sidecar:
            path.with_suffix(".toml").write_text(sidecar, encoding="utf-8")
        return path

    return write


@pytest.mark.parametrize("stated", [NO_LIMITS, LOCKED, ENDLESS])
def test_limits_in_the_sidecar_repair_a_joint(written, stated):
    """One without limits, one whose limits are zeros, and one that turns without end: each gets the
    range of the sidecar, with a note.
    """
    path = written(
        link("base"), stated, link("link1"), sidecar='[joints.j1]\nlimits = ["-30 deg", "60 deg"]\n'
    )
    found = read(path)
    np.testing.assert_allclose(np.degrees(found.limits), [[-30, 60]])
    assert "URDF repaired by r.toml: limits of j1" in found.notes
    assert not any("without end" in note or "cannot move" in note for note in found.notes)
    assert any("limits of j1" in note for note in lostmotion.check(path).sheet.notes)


def test_what_is_missing_is_asked_for_with_the_line_that_repairs_it(written):
    """The line is accepted as it stands, also for a slide."""
    for stated in (NO_LIMITS, SLIDE):
        parts = (link("base"), stated, link("link1"))
        (found,) = mistakes(written(*parts))
        table, line = re.search(
            r"r\.toml: (\[joints\.j1\]) with (limits = \[[^]]*\])", found.expected
        ).groups()
        assert read(written(*parts, sidecar=f"{table}\n{line}\n")).moving[0].name == "j1"


@pytest.mark.parametrize(
    ("limits", "found"),
    [('["-30 mm", "60 mm"]', "unit"), ('["60 deg", "-30 deg"]', "60 deg"), ("3", "3")],
)
def test_a_range_that_is_none_is_refused_by_its_key(written, limits, found):
    """In the sidecar, once."""
    problems = mistakes(
        written(link("base"), NO_LIMITS, link("link1"), sidecar=f"[joints.j1]\nlimits = {limits}\n")
    )
    assert all(
        problem.key.startswith("joints.j1.limits") and "r.toml" in problem.file
        for problem in problems
    )
    assert found in problems[0].found


def test_masses_and_centres_of_the_sidecar_are_those_of_a_urdf_that_states_them(written, tmp_path):
    """Torques follow, as Pinocchio has them of the URDF that was meant; the doubt is gone once
    every placeholder is replaced.
    """
    placeholders = [
        part.replace('xyz="0.1 0.02 0.03"', 'xyz="0 0 0"').replace(
            f'mass value="{1 + 0.1 * k}"', 'mass value="1"'
        )
        for k, part in ((max(1, row // 2), part) for row, part in enumerate(arm(3)))
    ]
    doubtful = read(written(*placeholders))
    assert sum("placeholders?" in warning for warning in doubtful.warnings) == 2
    lines = [
        (
            f'[joints.j{k}]\nlink = {{ mass = "{1 + 0.1 * k} kg", centre_of_mass = ["100 mm", "20 '
            f'mm", "30 mm"] }}'
        )
        for k in (1, 2, 3)
    ]
    repaired = read(written(*placeholders, sidecar="\n".join(lines)))
    assert (
        "URDF repaired by r.toml: mass of j1, j2, j3; centre of mass of j1, j2, j3"
        in repaired.notes
    )
    assert not any("placeholders?" in warning for warning in repaired.warnings)
    meant = tmp_path / "meant.urdf"
    meant.write_text(robot(*arm(3)), encoding="utf-8")
    agrees_with_pinocchio(meant, repaired, "link3")
    partly = read(written(*placeholders, sidecar="\n".join(lines[:2])))
    assert [
        ("does not state those of j3" in warning)
        for warning in partly.warnings
        if "placeholders?" in warning
    ] == [True, True]


def test_a_first_sidecar_keeps_the_repairs(written):
    """`new --from --force` would otherwise write a file that no longer reads."""
    sidecar = (
        '[joints.j1]\nlimits = ["-30 deg", "60 deg"]\nlink = { mass = "2 kg", centre_of_mass = '
        '["10 mm", "0 mm", "5 mm"] }\n'
    )
    tool = (link("tool0", 0), joint("mount", "link1 tool0", "fixed", ""))
    path = written(link("base"), NO_LIMITS, link("link1"), *tool, sidecar=sidecar)
    before = read(path)
    lostmotion.new(urdf=path, force=True).report()
    after = read(path)
    np.testing.assert_array_equal(after.limits, before.limits)
    np.testing.assert_array_equal(
        state_of(after, np.array([[0.3]])).torques, state_of(before, np.array([[0.3]])).torques
    )


def vehicle(slide, turn="continuous", mass=50.0):
    """Return a cart that slides and turns, with an arm of two joints on it; `slide` are the limits
    of the way.
    """
    return [
        *(
            link("world", 0),
            joint("base_x", "world bx", "prismatic", f'<axis xyz="1 0 0"/>{slide}'),
            link("bx", 0),
        ),
        *(joint("base_theta", "bx cart", turn, '<axis xyz="0 0 1"/>'), link("cart", mass)),
        *arm(2, "cart")[1:],
    ]


@pytest.mark.parametrize("slide", ["", '<limit lower="-10" upper="10"/>'])
def test_the_slide_of_a_cart_is_met_with_the_line_that_starts_the_arm_on_it(written, slide):
    """Refused where it has no range, else warned of; either way `base` names the cart, and the arm
    on it is read.
    """
    path = written(*vehicle(slide))
    if slide:
        (hint,) = (warning for warning in read(path).warnings if "a cart?" in warning)
    else:
        (found,) = mistakes(path)
        hint = found.example
    line = re.search(r'base = "cart"', hint)[0]
    found = read(written(*vehicle(slide), sidecar=line))
    assert [each.name for each in found.moving] == ["j1", "j2"]
    assert not any("a cart?" in warning for warning in found.warnings)


@pytest.mark.parametrize("travel", [0.8, 4.0])
def test_a_rail_is_no_cart(written, travel):
    """Arms on a linear axis are read without a warning."""
    found = read(written(*vehicle(f'<limit lower="0" upper="{travel}"/>')))
    assert not any("a cart?" in warning for warning in found.warnings)


def test_the_slide_of_a_cart_in_mjcf(tmp_path):
    """Joints of one body: the whole body is the cart."""
    joints = (
        '<joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 '
        '0"/><joint name="yaw" axis="0 0 1"/>'
    )
    tool = (
        f'<body name="a">{INERTIAL.format(1)}<joint name="j1" axis="0 1 0" range="-1 1"/><site '
        'name="tcp" pos="0.3 0 0"/></body>'
    )
    path = tmp_path / "r.xml"
    path.write_text(
        model(f'<body name="cart">{INERTIAL.format(9)}{joints}{tool}</body>'), encoding="utf-8"
    )
    found = mistakes(path)
    assert [problem.found for problem in found] == ["a slide without range"] * 2
    assert {problem.example for problem in found} == {'base = "cart"'}
    path.with_suffix(".toml").write_text(found[0].example, encoding="utf-8")
    assert [each.name for each in read(path).moving] == ["j1"]


def test_no_text_for_users_names_a_class_of_the_code():
    """Sentences speak of masses and links, never of `PlacedMass`: a renamed class must not reach a
    message.
    """
    root = Path(lostmotion.__file__).parent
    modules = [[*ast.walk(ast.parse(path.read_text("utf-8")))] for path in root.rglob("*.py")]
    classes = {node.name for nodes in modules for node in nodes if isinstance(node, ast.ClassDef)}
    joined = {name for name in classes if len(re.findall("[A-Z][a-z0-9]+", name)) > 1}
    assert len(joined) > 100
    texts = [text for nodes in modules for text in _sentences(nodes)]
    assert len(texts) > 1000
    assert [text for text in texts if joined & {*re.findall(r"\w+", text)}] == []


def _sentences(nodes):
    """Return the texts of a module, by its nodes, that hold blanks: no docstrings, no types in quotes, no
    representations in angle brackets.
    """
    homes = (ast.Module, ast.ClassDef, ast.FunctionDef)
    docs = {
        id(node.body[0].value)
        for node in nodes
        if isinstance(node, homes) and node.body and isinstance(node.body[0], ast.Expr)
    }
    texts = [
        node.value
        for node in nodes
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docs
    ]
    return [
        text
        for text in texts
        if " " in text
        and not text.startswith("<")
        and not re.fullmatch(r"[\w\s|,.\[\]]*[|\[][\w\s|,.\[\]]*", text)
    ]
