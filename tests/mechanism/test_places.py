"""Places with parents: frames, wrenches and carry matrices on arms with branches, from first
principles.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError

from lostmotion.error_model.pose_matrix import screws
from lostmotion.error_model.provenance import states
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.inverse import inverse_kinematics, pose_difference, tool_and_jacobian
from lostmotion.mechanism.placed_terms import short_name
from lostmotion.mechanism.state import state_of, tool_points
from lostmotion.mechanism.tool import Payload
from lostmotion.parts.base import Base
from lostmotion.parts.joint import FixedJoint, PrismaticJoint, RevoluteJoint
from lostmotion.propagation.exact import compose
from lostmotion.spatial import exp, pose_of

ENDS = (".seat", "", ".tip")
GRAVITY = 9.80665


def test_a_part_of_a_joint_is_named_in_tables_by_joint_and_kind():
    """Tables drop the "joints." of the arm file, once, and leave parts of the base as they are."""
    assert short_name("joints.A.gearbox") == "A.gearbox"
    assert short_name("joints.joints.B.link") == "joints.B.link"
    assert short_name("base tilt") == "base tilt"


def vector(rng: np.random.Generator, size: float = 0.4) -> tuple[float, ...]:
    """Draw three numbers within ± size."""
    return tuple(map(float, rng.uniform(-size, size, 3)))


def random_tree(rng: np.random.Generator) -> Arm:
    """Draw an arm of 3 to 9 joints of all kinds, about half of them attached to any earlier place;
    the tool is attached to the last joint.
    """
    joints: list[RevoluteJoint | PrismaticJoint | FixedJoint] = []
    names = ["base"]
    for k in range(int(rng.integers(3, 10))):
        kind = rng.choice(["revolute", "prismatic", "fixed"], p=[0.6, 0.2, 0.2])
        fields = {
            "name": f"J{k}",
            "after": str(rng.choice(names)) if rng.random() < 0.5 else None,
            "origin": {"xyz": vector(rng), "rpy": vector(rng, 3)},
            "mass": rng.uniform(0, 3),
            "centre_of_mass": vector(rng, 0.1),
            "link": {
                "tip": {"xyz": vector(rng), "rpy": vector(rng, 3)},
                "mass": rng.uniform(0, 5),
                "centre_of_mass": vector(rng),
            },
        }
        moving = {
            "axis": vector(rng),
            "limits": (-1, 1),
            "lumped": {"angle": 1e-3} if kind == "revolute" else None,
        }
        if kind == "fixed":
            joints.append(FixedJoint(**fields))
        else:
            joints.append(
                (RevoluteJoint if kind == "revolute" else PrismaticJoint)(**fields, **moving)
            )
        names += [f"J{k}{end}" for end in ENDS]
    if not any(joint.type != "fixed" for joint in joints[-1:]):
        joints.append(RevoluteJoint(name="last", limits=(-1, 1), after=str(rng.choice(names))))
    return Arm(
        name="tree",
        joints=joints,
        base=Base(
            roll=rng.uniform(-1, 1), pitch=rng.uniform(-1, 1), xyz=vector(rng), rpy=vector(rng, 3)
        ),
        tool={
            "frame": {"xyz": vector(rng), "rpy": vector(rng, 3)},
            "mass": rng.uniform(0, 2),
            "centre_of_mass": vector(rng),
        },
        payload={"mass": rng.uniform(0, 10), "centre_of_mass": vector(rng)},
    )


def by_hand(arm: Arm, q: np.ndarray) -> dict[str, np.ndarray]:
    """Return the frame of every place of an arm at one pose q (joint,), as the product of the poses
    from the place that it names.
    """
    at = {"base": np.eye(4)}
    value, last = iter(q), "base"

    def stand(after: str | None, frame: np.ndarray) -> np.ndarray:
        on = after or last
        return at[on] @ (arm.base.foot if on == "base" else np.eye(4)) @ frame

    for joint in arm.joints:
        at[f"{joint.name}.seat"] = stand(joint.after, pose_of(joint.origin.xyz, joint.origin.rpy))
        at[joint.name] = at[f"{joint.name}.seat"] @ (
            np.eye(4) if joint.type == "fixed" else exp(joint.twist * next(value))
        )
        last = f"{joint.name}.tip"
        at[last] = at[joint.name] @ joint.link.tip_pose
    at["tool"] = stand(arm.tool.after, arm.tool.frame.pose)
    return at


def height_energy(arm: Arm, q: np.ndarray) -> float:
    """Return the potential energy (J) of all masses of an arm at one pose q (joint,), from the
    fields of the arm, without its tree.
    """
    at, gravity = by_hand(arm, q), arm.gravity_in_base
    flange = arm.tool.after or f"{arm.joints[-1].name}.tip"
    masses = [
        (flange, arm.tool.mass, arm.tool.centre_of_mass or arm.tool.frame.xyz),
        ("tool", arm.payload.mass, arm.payload.centre_of_mass),
    ]
    for joint in arm.joints:
        masses += [
            (f"{joint.name}.seat", joint.total_mass, joint.centre_of_mass),
            (joint.name, joint.link.total_mass, joint.link.mass_centre),
        ]
    return -sum(mass * gravity @ (at[place] @ [*centre, 1.0])[:3] for place, mass, centre in masses)


def slopes(arm: Arm, q: np.ndarray) -> np.ndarray:
    """Return the derivatives of the potential energy by each joint value, from differences of two
    widths (Richardson extrapolation).
    """

    def central(k: int, width: float) -> float:
        step = width * np.eye(len(q))[k]
        return (height_energy(arm, q + step) - height_energy(arm, q - step)) / (2 * width)

    return np.array([(4 * central(k, 5e-4) - central(k, 1e-3)) / 3 for k in range(len(q))])


@pytest.mark.parametrize("seed", range(40))
def test_every_place_is_attached_to_the_place_that_it_names(seed: int):
    """Frames of an arm with branches are the products of the poses along the path from the base to
    each place.
    """
    rng = np.random.default_rng(seed)
    arm = random_tree(rng)
    q = rng.uniform(-1, 1, (3, len(arm.moving)))
    at = state_of(arm, q).frames
    for k, each in enumerate(q):
        expected = by_hand(arm, each)
        np.testing.assert_allclose(at[:, k], [expected[name] for name in arm.places], atol=1e-13)
    np.testing.assert_allclose(tool_points(arm, q), at[-1, :, :3, 3], atol=1e-14)
    # the base has none, which is -1
    assert all(place.parent < number for number, place in enumerate(arm.tree.places))


@pytest.mark.parametrize("seed", range(40))
def test_holding_torques_are_the_gradient_of_the_potential_energy(seed: int):
    """By virtual work, each holding torque is the derivative of the potential energy by its joint
    value, also on arms with branches.
    """
    rng = np.random.default_rng(seed)
    arm = random_tree(rng)
    q = rng.uniform(-1, 1, len(arm.moving))
    torques = state_of(arm, q).torques[0]
    np.testing.assert_allclose(
        torques, slopes(arm, q), atol=1e-10 * max(1.0, np.abs(torques).max())
    )


@pytest.mark.parametrize("seed", range(40))
def test_the_carry_matrix_transposed_gives_the_wrench_of_a_load_on_the_tool(seed: int):
    """A wrench on the tool loads each place by the transpose of its carry matrix; a place that does
    not carry the tool is not loaded.
    """
    rng = np.random.default_rng(seed)
    arm = random_tree(rng)
    q = rng.uniform(-1, 1, (3, len(arm.moving)))
    state = state_of(arm, q)
    moment, force = rng.uniform(-50, 50, (2, 3))
    pressed = arm.with_payload(Payload(moment=tuple(moment), force=tuple(force)))
    felt = state_of(pressed, q, gravity=np.zeros(3)).wrenches
    turned = state.frames[-1, :, :3, :3]
    load = np.concatenate([turned @ moment, turned @ force], axis=1)
    for k in range(len(arm.places)):
        np.testing.assert_allclose(
            np.einsum("pji,pj->pi", state.carry(k), load), felt[k], atol=3e-15 * 100
        )
        assert (k in arm.tree.tool_path) == bool(state.carry(k).any())


@pytest.mark.parametrize("seed", range(10))
def test_the_carry_matrix_is_the_tools_motion_under_a_small_motion_of_a_place(seed: int):
    """A small motion of a place moves the tool by the carry matrix times that motion; a motion of a
    place on a branch does not move it.
    """
    rng = np.random.default_rng(seed)
    arm = random_tree(rng)
    state = state_of(arm, rng.uniform(-1, 1, len(arm.driven)))
    at = state.frames
    small = 1e-5 * rng.uniform(-1, 1, 6)
    for k in range(len(arm.places)):
        here = at[k, 0]
        there, again = (
            here @ exp(sign * small) @ np.linalg.inv(here) @ at[-1, 0] for sign in (1, -1)
        )
        moved = pose_difference(again, there) / 2
        expected = moved if k in arm.tree.tool_path else np.zeros(6)
        np.testing.assert_allclose(state.carry(k)[0] @ small, expected, atol=1e-13)


@pytest.mark.parametrize("seed", range(20))
def test_joints_on_a_branch_do_not_move_the_tool(seed: int):
    """A joint between base and tool moves the tool by its carry matrix. A joint on a branch does
    not, and inverse kinematics keeps its value.
    """
    rng = np.random.default_rng(seed)
    arm = random_tree(rng)
    q = rng.uniform(-1, 1, (3, len(arm.moving)))
    state = state_of(arm, q)
    tool, levers = tool_and_jacobian(arm, q)
    np.testing.assert_allclose(tool, state.frames[-1], atol=1e-13)
    for k, (joint, place) in enumerate(zip(arm.moving, arm.tree.moved, strict=True)):
        np.testing.assert_allclose(levers[:, :, k], state.carry(place) @ joint.twist, atol=1e-13)
        assert levers[:, :, k].any() == (k in arm.tree.tool_joints)
    beside = [k for k in range(len(arm.moving)) if k not in arm.tree.tool_joints]
    start = np.clip(q + 0.1 * rng.uniform(-1, 1, q.shape), *arm.limits.T)
    np.testing.assert_array_equal(
        inverse_kinematics(arm, tool, start, with_orientation=False)[0][:, beside], start[:, beside]
    )


def lifter(**counterweight: object) -> Arm:
    """Return an arm of three turning joints with a counterweight of 27 kg behind the elbow; the
    wrist is attached to the tip of the forearm.
    """
    common = {"limits": (-3, 3), "axis": "-y", "lumped": {"angle": 1e-4}}
    joints = [
        RevoluteJoint(name="shoulder", link={"length": 0.5, "mass": 4.0}, **common),
        RevoluteJoint(name="elbow", link={"length": 0.4, "mass": 3.0}, **common),
        RevoluteJoint(name="wrist", link={"length": 0.1, "mass": 1.0}, **common),
    ]
    if counterweight:
        arm_behind = {
            "tip": {"xyz": (-0.3, 0.0, 0.1)},
            "length_tolerance": 1e-4,
            "mass": 27.0,
            "centre_of_mass": (-0.3, 0.02, 0.1),
        }
        joints[2:2] = [RevoluteJoint(name="weight", after="elbow", link=arm_behind, **common)]
        joints[3] = joints[3].model_copy(update={"after": "elbow.tip"})
    return Arm(name="lifter", joints=joints, payload={"mass": 2.0})


def test_a_counterweight_loads_the_places_that_carry_it_and_never_moves_the_tool():
    """A branch of 27 kg on the elbow loads all places inboard by 264.78 N and none outboard. Its
    own errors do not move the tool at all.
    """
    without, arm = lifter(), lifter(counterweight=True)
    rng = np.random.default_rng(3)
    q = rng.uniform(-2, 2, (20, 4))
    before, after = state_of(without, q[:, [0, 1, 3]]).wrenches, state_of(arm, q).wrenches
    grown = {
        name: np.linalg.norm(after[arm.places.index(name), :, 3:], axis=1)
        - np.linalg.norm(before[k, :, 3:], axis=1)
        for k, name in enumerate(without.places)
    }
    for name, more in grown.items():
        expected = (
            27 * GRAVITY
            if name in ("base", "shoulder.seat", "shoulder", "shoulder.tip", "elbow.seat", "elbow")
            else 0.0
        )
        np.testing.assert_allclose(more, expected, atol=1e-10, err_msg=name)
    for each in q:
        np.testing.assert_allclose(state_of(arm, each).torques[0], slopes(arm, each), atol=1e-8)
    matrix = screws(state_of(arm, q))
    beside = np.array([info.owner.startswith("joints.weight") for info in matrix.infos])
    assert beside.any()
    assert not matrix.tool[:, :, beside].any()
    assert matrix.local[:, :, beside].any()


def test_errors_on_a_branch_do_not_change_the_exact_composition():
    """With finite rotations, too, large errors of a branch do not move the tool: its pose is that
    of the arm without the branch.
    """
    rng = np.random.default_rng(5)
    q = rng.uniform(-2, 2, (3, 4))
    whole, plain = (
        screws(state_of(lifter(counterweight=True), q)),
        screws(state_of(lifter(), q[:, [0, 1, 3]])),
    )
    owners = [info.owner for info in whole.infos]
    shared = [k for k, owner in enumerate(owners) if not owner.startswith("joints.weight")]
    assert [owners[k] for k in shared] == [info.owner for info in plain.infos]
    draws = 100 * rng.normal(size=(3, len(owners), 2))
    rows = np.arange(3)
    np.testing.assert_allclose(
        compose(whole, rows, draws), compose(plain, rows, draws[:, shared]), atol=1e-14
    )


def test_the_path_to_the_tool_excludes_branches():
    """The path to the tool excludes branches; the places outboard of a place include them."""
    arm = lifter(counterweight=True)
    path = [arm.places[k] for k in arm.tree.tool_path]
    assert path == [
        "base",
        *(f"{name}{end}" for name in ("shoulder", "elbow", "wrist") for end in ENDS),
        "tool",
    ]
    assert {arm.places[k] for k in arm.tree.outboard(arm.places.index("elbow"))} == {
        "elbow", "elbow.tip", "tool", *(f"{name}{end}" for name in ("weight", "wrist") for end in ENDS),
    }  # fmt: skip


def test_an_arm_that_names_a_place_it_does_not_have_is_refused():
    """A joint is attached to an earlier place, whose name must be unique."""
    joint = {"type": "revolute", "limits": (-1, 1)}
    cases = {
        "tipp": [{"name": "A", **joint}, {"name": "B", "after": "A.tipp", **joint}],
        "later": [{"name": "A", "after": "B.tip", **joint}, {"name": "B", **joint}],
        "its own": [{"name": "A", "after": "A.seat", **joint}],
        "of two meanings": [
            {"name": "A", **joint},
            {"name": "A.tip", **joint},
            {"name": "C", "after": "A.tip", **joint},
        ],
    }
    for name, joints in cases.items():
        with pytest.raises(ValidationError, match="not exactly one earlier place"):
            Arm(name=name, joints=joints)
    plinth, moving = {"name": "plinth", "type": "fixed"}, {"name": "A", **joint}
    still = [
        ([moving], "base"),
        ([moving], "A.seat"),
        ([plinth, {**moving, "after": "base"}], "plinth.tip"),
    ]
    for joints, after in still:
        with pytest.raises(ValidationError, match="no joint moves"):
            Arm(name="still", joints=joints, tool={"after": after})
    assert math.isclose(
        Arm(name="last", joints=[{"name": "A", **joint}], tool={"after": "A"}).tree.tool_path[-1], 4
    )


def test_a_branch_without_errors_is_not_missing_from_a_prediction():
    """A prediction is complete without errors of a finger, which cannot move the tool; without
    errors of a wrist it is not.
    """
    finger = {"name": "finger", "type": "prismatic", "after": "shoulder.tip", "limits": (0, 0.04)}
    arm = lifter()
    with_finger = Arm(name="hand", joints=[*arm.joints, finger], tool={"after": "wrist.tip"})
    bare = {"name": "bare", "type": "prismatic", "limits": (0, 0.04)}
    assert states(with_finger).ideal_joints == ()
    assert states(Arm(name="hand", joints=[*arm.joints, bare])).ideal_joints == ("bare",)
