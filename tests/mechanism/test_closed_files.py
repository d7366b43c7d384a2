"""Closed chains in files: what is refused, legs that repeat, and what a closure must not change."""

from __future__ import annotations

import copy
import tomllib
from pathlib import Path

import numpy as np
import pytest
import tomlkit

import lostmotion
from lostmotion.error_model.pose_matrix import screws
from lostmotion.error_model.poses import sample_poses
from lostmotion.errors import InputError
from lostmotion.io.arm_templates import template_text
from lostmotion.io.native import arm_of
from lostmotion.mechanism.closed_home import home_of
from lostmotion.mechanism.loops import loops_of
from lostmotion.mechanism.state import state_of
from lostmotion.mechanism.tool import Payload
from tests.command import carried_out
from tests.mechanism.closed_chains import (
    arm,
    at,
    five_bar,
    hexapod,
    hexapod_legs,
    link,
    palletiser,
    three_rrr,
    xyz,
)

TURN = {"type": "revolute", "limits": ["0 deg", "180 deg"]}
LOOSE = {"type": "revolute", "passive": True}
FIVE_BAR = {
    "name": "test",
    "joints": [
        {"name": "m1", **TURN, "start": "126 deg", "link": link(0.25)},
        {"name": "e1", **LOOSE, "start": "-80 deg", "link": link(0.4)},
        {"name": "m2", **TURN, "start": "51 deg", "after": "base", "origin": xyz(0.2, 0, 0)}
        | {"link": link(0.25)},
        {"name": "e2", **LOOSE, "start": "70 deg", "link": link(0.4)},
        {"name": "pin", **LOOSE},
    ],
    "closures": [{"joins": ["e1.tip", "pin.tip"]}],
    "tool": {"after": "e1.tip"},
}


def changed(joint: int | None = None, **values: object) -> dict:
    """Return the file of a five-bar with other values in a joint, or in the file itself."""
    tree = copy.deepcopy(FIVE_BAR)
    (tree if joint is None else tree["joints"][joint]).update(values)
    return tree


def fixed(joint: int) -> dict:
    """Return the file of a five-bar with a joint that does not move."""
    tree = copy.deepcopy(FIVE_BAR)
    one = tree["joints"][joint]
    tree["joints"][joint] = {"name": one["name"], "type": "fixed", "link": one.get("link", {})}
    return tree


@pytest.mark.parametrize(
    ("tree", "key", "found"),
    [
        (changed(1, link=link(0.1)), "closures[0]", "apart at home by 5.411 mm and 0 deg at least"),
        (changed(2, **LOOSE), "closures", "5 freedoms - rank 3 of the closures = 2, for 1 drive"),
        (fixed(4), "closures[0]", "1 freedom too few for m1, m2"),
        (changed(closures=[{"joins": ["e1.tip", "m1"]}]), "closures[0].joins", "on one branch"),
        (changed(closures=[{"joins": ["e1.tip", "pun.tip"]}]), "closures[0].joins", "pun.tip"),
        (changed(1, gearbox={"backlash": "1 arcmin"}), "joints.e1", "gearbox on a passive joint"),
        (changed(1, limits=["0 deg", "90 deg"]), "closures", "e1 outside its limits at home"),
        (changed(closures=[]), "joints.e1.passive", "without closures"),
        (changed(1, encoder={"zero": "1 arcmin"}), "joints.e1", "encoder on a passive joint"),
        (changed(3, start="-70 deg"), "joints.e1.start", "another assembly mode"),
        (changed(1, start="150 deg"), "joints.e1.start", "with its start at 150 deg"),
        (changed(1, passive="yes"), "joints.e1.passive", "'yes'"),
    ],
)
def test_a_chain_that_cannot_be_is_refused_by_name(tree: dict, key: str, found: str):
    """Each mistake has one message with its key, what was found, and a remedy."""
    with pytest.raises(InputError) as refused:
        arm_of("test.toml", tree)
    (problem,) = refused.value.problems
    assert problem.key.startswith(key)
    assert found in problem.found
    assert problem.expected
    assert problem.example


def test_rods_that_are_too_short_have_a_remedy_of_the_platform():
    """The example is a start in the form that a free platform takes."""
    text = template_text("delta").replace('"350 mm ± 50 µm"', '"30 mm"')
    with pytest.raises(InputError) as refused:
        arm_of("test.toml", tomlkit.parse(text).unwrap())
    (problem,) = refused.value.problems
    assert "apart at home by" in problem.found
    assert problem.example.startswith("start = { xyz = [")


def test_a_misspelt_type_of_a_ball_joint_is_one_mistake(tmp_path):
    """Its bearing, which then no joint uses, is checked as that of a ball joint."""
    examples = Path(__file__).parents[2] / "examples"
    text = (examples / "closed-chains" / "delta-printer.toml").read_text()
    for wrong, key in (
        (text.replace('type = "spherical"', 'type = "sperical"'), "joints.A1_ball.type"),
        (text.replace('kind = "ball"', 'kind = "ball"\nclearence = "1 µm"'), "bearings.ball"),
        (
            text + '\n[bearings.spare]\nkind = "ball"\nclearence = "1 µm"\n',
            "bearings.spare.clearence",
        ),
    ):
        (tmp_path / "wrong.toml").write_text(wrong)
        with pytest.raises(InputError) as refused:
            lostmotion.read(tmp_path / "wrong.toml")
        (problem,) = refused.value.problems
        assert problem.key.startswith(key)
    spare = text + '\n[bearings.spare]\nkind = "ball"\nclearance = "1 µm"\n'
    arm = arm_of("test.toml", tomlkit.parse(spare).unwrap())
    assert "described and used by no joint: bearings.spare" in arm.notes


def test_a_misspelt_place_of_a_closure_has_the_near_name():
    """In a closure, and in the `joins` of a leg."""
    text = template_text("hexapod").replace('joins = "platform.tip"', 'joins = "platfrm.tip"')
    for tree, near in (
        (changed(closures=[{"joins": ["e1.tip", "pun.tip"]}]), "pin.tip"),
        (tomlkit.parse(text).unwrap(), "platform.tip"),
    ):
        with pytest.raises(InputError) as refused:
            arm_of("test.toml", tree)
        (problem,) = refused.value.problems
        assert problem.nearest == near
        assert f'"{near}"]' in problem.example


def test_a_drive_too_many_has_a_drive_less_as_its_remedy():
    """A five-bar with a driven elbow closes at no home by lengths and starts: three drives need one
    more freedom than it has.
    """
    driven = changed(1, passive=False, limits=["-80 deg", "-20 deg"], start="-40 deg")
    with pytest.raises(InputError) as refused:
        arm_of("test.toml", driven)
    (problem,) = refused.value.problems
    assert "= 2, for 3 drives: 1 freedom too few for m1, e1, m2" in problem.found
    assert problem.expected.endswith("or a drive less")
    assert problem.example == "passive = true"


@pytest.mark.parametrize(
    "command",
    [
        ["compensate", "arm.toml", "--poses", "poses.csv", "--out", "out.csv"],
        ["export", "c", "arm.toml", "--out", "model"],
    ],
)
def test_a_table_for_a_controller_of_a_closed_chain_is_refused_with_what_answers(tmp_path, command):
    """The message names both commands, and the study of given poses."""
    laid_with_poses(tmp_path)
    done = carried_out(*command, cwd=tmp_path)
    assert done.returncode == 2
    found = " ".join(done.stderr.split())
    assert "no table for a controller, as `compensate` and `export` need it" in found
    assert "`study` predicts the errors at given poses (`--poses poses.csv`)" in found
    assert len(list(tmp_path.iterdir())) == 2


def test_what_answers_in_place_of_a_table_for_a_controller_does(tmp_path):
    """The study of given poses of a closed chain."""
    laid_with_poses(tmp_path)
    study = lostmotion.study(tmp_path / "arm.toml", poses=tmp_path / "poses.csv", robots=16)
    assert len(study.poses) == 1


def laid_with_poses(folder):
    """Write a five-bar and a table of one of its poses."""
    (folder / "arm.toml").write_text(template_text("five-bar"), "utf-8")
    (folder / "poses.csv").write_text("left [deg],right [deg]\n120,60\n", "utf-8")


def test_a_drive_on_a_ball_joint_of_six_legs_is_refused_once():
    """A gearbox, by name or in full, on a joint in several directions has one message that states
    what a passive joint may have.
    """
    text = template_text("hexapod")
    assert 'type = "spherical"' in text
    for gearbox in ('{ backlash = "1 µm" }', '"screw"'):
        tree = tomlkit.parse(
            text.replace('type = "spherical"', f'type = "spherical"\ngearbox = {gearbox}')
        ).unwrap()
        with pytest.raises(InputError) as refused:
            arm_of("test.toml", tree)
        assert {each.found for each in refused.value.problems} == {"gearbox on a passive joint"}


def test_a_command_refuses_a_loop_that_cannot_close_and_writes_nothing(tmp_path):
    """Exit code 2, and how far the loop is from closing, and where."""
    file = tmp_path / "arm.toml"
    file.write_text(tomlkit.dumps(changed(1, link=link(0.1))), "utf-8")
    done = carried_out("study", file, cwd=tmp_path)
    assert done.returncode == 2
    assert "closures[0]" in done.stderr
    assert "e1.tip and pin.tip apart at home by 5.411 mm" in done.stderr
    assert list(tmp_path.iterdir()) == [file]


def test_a_mistake_in_a_leg_is_reported_once_with_its_line(tmp_path):
    """A leg is written once, and so is its mistake, whatever the number of its copies."""
    file = tmp_path / "arm.toml"
    text = template_text("hexapod").replace('limits = ["20 mm", "50 mm"]', 'limits = "20 mm"')
    file.write_text(text, "utf-8")
    with pytest.raises(InputError) as refused:
        lostmotion.read(file)
    (problem,) = refused.value.problems
    line = next(k for k, row in enumerate(text.splitlines(), 1) if row.startswith("limits"))
    assert problem.file == f"{file}:{line}"
    assert problem.key == "joints.leg1_slide.limits"


def test_mistakes_of_two_copies_of_a_leg_are_two_with_their_lines(tmp_path):
    """What a copy states itself is its own mistake."""
    file = tmp_path / "arm.toml"
    rows = template_text("hexapod").splitlines()
    copies = [k for k, row in enumerate(rows) if 'name = "leg' in row]
    for k in (copies[0], copies[2]):
        rows[k] = rows[k].replace("place = {", 'slide = { limits = "20 mm" }, place = {')
    file.write_text("\n".join(rows), "utf-8")
    with pytest.raises(InputError) as refused:
        lostmotion.read(file)
    assert [(each.file, each.key) for each in refused.value.problems] == [
        (f"{file}:{copies[0] + 1}", "joints.leg1_slide.limits"),
        (f"{file}:{copies[2] + 1}", "joints.leg3_slide.limits"),
    ]


def test_a_home_in_a_parallel_singularity_is_refused():
    """With the distal links in one line the tool of a five-bar is loose."""
    tree = copy.deepcopy(FIVE_BAR)
    distance = 0.2 + 2 * 0.25 * np.cos(np.radians(60))
    for joint, start in ((0, "120 deg"), (2, "60 deg"), (1, "-120 deg"), (3, "120 deg")):
        tree["joints"][joint]["start"] = start
        tree["joints"][joint]["link"] = link(0.25 if joint in (0, 2) else distance / 2)
    with pytest.raises(InputError, match="singular"):
        arm_of("test.toml", tree)


def test_poses_of_a_closed_chain_stay_in_its_assembly_mode():
    """All sampled poses of a five-bar have their tool on one side of the line between its elbows,
    and are as many as were asked for.
    """
    chain = five_bar()
    poses = sample_poses(chain, 256)
    assert len(poses) == 256
    state = state_of(chain, poses.q)
    tool, *elbows = (
        state.frames[chain.places.index(name), :, :2, 3] for name in ("tool", "m1.tip", "m2.tip")
    )
    line, across = elbows[1] - elbows[0], tool - elbows[0]
    side = line[:, 0] * across[:, 1] - line[:, 1] * across[:, 0]
    assert (side > 0).all()


def test_legs_without_a_start_aim_at_the_platform_that_they_carry():
    """Straight up, as their file leaves them, the legs of a hexapod would be in a singularity; home
    is the pose at which distances from ball to ball are the lengths of the legs.
    """
    chain = arm_of("hexapod.toml", tomllib.loads(template_text("hexapod")))
    state = state_of(chain, chain.home[None])
    middle = state.frames[-1, 0]
    np.testing.assert_allclose(middle[:3, :3], np.eye(3), atol=1e-6)
    base, ball = (
        radius * np.array([np.cos(angle), np.sin(angle), 0.0])
        for radius, angle in ((0.15, np.radians(-15)), (0.1, np.radians(-45)))
    )
    length = np.linalg.norm(middle[:3, 3] + ball - base)
    np.testing.assert_allclose(length, 0.09 + 0.035 + 0.09, atol=1e-7)


@pytest.mark.parametrize(
    ("build", "redundant"),
    [(five_bar, [3]), (three_rrr, [0, 3, 3]), (hexapod, [0] * 6), (palletiser, [3, 3, 3])],
)
def test_the_loops_of_a_chain_have_the_redundant_constraints_that_mobility_counts(build, redundant):
    """Hinges of a planar loop need three constraints of six; a leg with a universal, a sliding and
    a ball joint needs all that hold its platform.
    """
    tree = build().tree
    assert [loop.redundant for loop in loops_of(tree)] == redundant
    assert all(loop.passive for loop in loops_of(tree))


def test_a_pose_that_cannot_be_assembled_is_refused_by_name():
    """Arms that stretch apart cannot be joined."""
    with pytest.raises(InputError, match=r"cannot be assembled|singularity"):
        state_of(five_bar(distal=0.27), np.radians([[175.0, 5.0]]))


def test_the_wrench_on_every_place_is_the_transpose_of_its_carry_matrix():
    """Virtual work, on a hexapod: a force and a moment on the tool load each place by the transpose
    of how an error there moves the tool.
    """
    chain = hexapod()
    q = hexapod_legs((0.02, 0.03, 0.5), 0.1)
    rng = np.random.default_rng(3)
    force, moment = rng.uniform(-100, 100, 3), rng.uniform(-10, 10, 3)
    loads = Payload(force=tuple(force), moment=tuple(moment))
    state = at(chain.with_payload(loads), q, gravity=np.zeros(3))
    turned = state.frames[-1, 0, :3, :3]
    wrench = np.concatenate([turned @ moment, turned @ force])
    for place in range(len(chain.places)):
        expected = state.carry(place)[0].T @ wrench
        np.testing.assert_allclose(state.wrenches[place, 0], expected, atol=1e-10)


def test_a_rigid_closure_that_is_redundant_changes_nothing():
    """Two frames on one link that a closure joins again leave errors and loads as they were."""
    joints = [
        {"name": "A", **TURN, "link": link(0.4, mass=2.0), "mounting": {"tilt": "1 arcmin"}},
        {"name": "B", **TURN, "axis": "y", "link": link(0.3, mass=1.0)},
        {"name": "one", "type": "fixed", "after": "A", "link": link(0.1, "z")},
        {"name": "two", "type": "fixed", "after": "A", "link": link(0.1, "z")},
    ]
    tool = {"after": "B.tip"}
    open_chain = arm(joints=joints, tool=tool)
    closed = arm(joints=joints, tool=tool, closures=[{"joins": ["one.tip", "two.tip"]}])
    q = np.array([[0.3, 0.7], [1.0, 2.0]])
    one, other = (screws(state_of(each, q)) for each in (open_chain, closed))
    np.testing.assert_allclose(other.tool, one.tool, atol=1e-12)
    np.testing.assert_allclose(other.state.torques, one.state.torques, atol=1e-12)


def test_errors_that_rigid_loops_cannot_take_up_are_refused_by_name():
    """A tilt out of the plane of a rigid five-bar has no answer; one of a length has."""
    for mounting, refused in (({"tilt": "1 arcmin"}, True), ({}, False)):
        chain = arm_of("test.toml", changed(1, mounting=mounting))
        state = state_of(chain, chain.home[None])
        if refused:
            with pytest.raises(InputError, match="rigid"):
                screws(state)
        else:
            assert screws(state).tool.size == 0


def test_the_exact_position_with_errors_agrees_with_first_order():
    """A small error at any place of a five-bar moves the tool as its carry matrix has it, and a
    large one otherwise.
    """
    chain = five_bar()
    state = at(chain, (2.2, 0.9))
    for name in ("m1.tip", "e2.tip", "m2.seat", "pin.tip"):
        place = chain.places.index(name)
        sides = []
        for size in (1e-4, -1e-4):
            twist = np.array([0, 0, 0, size, size / 2, 0])
            frames = state.composed([place], twist[None, None, None])
            sides.append(frames[0, 0, :3, 3])
        slope = (sides[0] - sides[1]) / 2e-4
        expected = state.carry(place)[0, 3:] @ [0, 0, 0, 1, 0.5, 0]
        np.testing.assert_allclose(slope, expected, atol=2e-6)


def test_chains_of_one_shape_share_their_home():
    """Arms that differ in their errors alone are assembled at home once; another length is another
    home.
    """
    loose = five_bar(bearing={"kind": "rolling", "clearance": "20 µm", "span": "40 mm"})
    assert home_of(loose.tree) is home_of(five_bar().tree)
    assert home_of(five_bar(0.41).tree) is not home_of(loose.tree)


def test_a_platform_similar_to_its_base_is_refused_for_its_shape():
    """Two regular hexagons joined corner to corner leave a platform loose at every pose: another
    home does not help, and twisted by 30 degrees it is held.
    """
    examples = Path(__file__).parents[2] / "examples" / "closed-chains"
    tables = tomllib.loads((examples / "hexapod.toml").read_text(encoding="utf-8"))

    def stage(twist):
        copies = [
            {"name": str(k), "place": corner(0.4, angle), "end": corner(0.25, angle + twist)}
            for k, angle in enumerate(np.radians(np.arange(0, 360, 60)))
        ]
        return copy.deepcopy({**tables, "legs": [{**tables["legs"][0], "copies": copies}]})

    def corner(radius, angle):
        return {"xyz": [f"{radius * np.cos(angle)} m", f"{radius * np.sin(angle)} m", "0 m"]}

    with pytest.raises(InputError, match="singular at home and beside it") as refused:
        arm_of("test.toml", stage(0.0))
    (problem,) = refused.value.problems
    assert problem.expected.startswith("another shape")
    turned = stage(0.0)
    for k, each in enumerate(turned["legs"][0]["copies"]):
        each["end"] = corner(0.25, np.radians(60 * k + (15 if k % 2 else -15)))
    assert arm_of("test.toml", turned).tree
