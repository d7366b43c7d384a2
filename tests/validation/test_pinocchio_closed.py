"""Closed chains beside Pinocchio: its closures, Jacobians and gravity torques at the positions that
are found here.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import lostmotion
from lostmotion.error_model.poses import sample_poses
from lostmotion.mechanism.closed_position import assemble, joint_value
from lostmotion.mechanism.inverse import tool_and_jacobian
from lostmotion.mechanism.places import PlacedMass
from lostmotion.mechanism.state import state_of

EXAMPLES = Path(__file__).parents[2] / "examples" / "closed-chains"
NAMES = ("five-bar", "delta-printer", "hexapod", "parallelogram-palletiser")
POSES = 20
VALIDATES = (
    (
        "position, Jacobian and torques of the drives of four closed chains at 20 poses each",
        "Pinocchio: 6D constraints, their Jacobians, gravity torques",
        "1e-8 m and rad; 1e-11 of the largest",
        "mechanism/closed_position.py mechanism/closed_statics.py",
    ),
)


def model_of(arm):
    """Return an arm's tree as a model of Pinocchio, the joint and the frame there of each place,
    and the joint of each place that moves.
    """
    tree, model = arm.tree, pin.Model()
    of, moving = {0: (0, pin.SE3.Identity())}, {}
    for k, place in enumerate(tree.places[1:], start=1):
        joint, frame = of[place.parent]
        freedoms = place.twist.shape[1]
        if not freedoms:
            of[k] = (joint, frame * pin.SE3(place.pose))
            continue
        if freedoms > 1:
            kind = {3: pin.JointModelSpherical, 6: pin.JointModelFreeFlyer}[freedoms]()
        elif place.twist[:3].any():
            kind = pin.JointModelRevoluteUnaligned(*place.twist[:3, 0])
        else:
            kind = pin.JointModelPrismaticUnaligned(*place.twist[3:, 0])
        moving[k] = model.addJoint(joint, kind, frame, f"{place.name} {k}")
        of[k] = (moving[k], pin.SE3.Identity())
    tool, payload = len(tree.places) - 1, arm.payload
    loads = PlacedMass(tool, tool, payload.mass, np.array(payload.centre_of_mass)), *tree.masses
    for each in loads:
        joint, frame = of[each.at]
        point = pin.Inertia(each.mass, frame.act(np.array(each.centre)), np.zeros((3, 3)))
        model.appendBodyToJoint(joint, point, pin.SE3.Identity())
    return model, of, moving


def configuration(tree, model, moving, q, motions):
    """Return the configuration of Pinocchio at drives (drive,) and motions of passive joints
    (passive, 3, 4).
    """
    passive = {each.place: k for k, each in enumerate(tree.passive)}
    out = pin.neutral(model)
    for k, joint in moving.items():
        place, first = tree.places[k], model.joints[joint].idx_q
        if place.joint is not None:
            out[first] = q[place.joint]
            continue
        motion = motions[passive[k]]
        if place.twist.shape[1] == 1:
            out[first] = joint_value(place.twist[:, 0], motion[None])[0]
            continue
        turned = pin.Quaternion(motion[:, :3].copy()).coeffs()
        whole = turned if place.twist.shape[1] == 3 else np.r_[motion[:, 3], turned]
        out[first : first + len(whole)] = whole
    return out


@pytest.mark.parametrize("name", NAMES)
def test_a_closed_chain_has_the_position_jacobian_and_torques_of_pinocchio(name):
    """At the passive joints found here Pinocchio's closures are met, its tool is where ours is, and
    its constraint Jacobians lead to our twists per drive and to our torques of the drives.
    """
    arm = lostmotion.read(EXAMPLES / f"{name}.toml")
    tree, (model, of, moving) = arm.tree, model_of(arm)
    q = sample_poses(arm, POSES).q[:POSES]
    state, found = state_of(arm, q), assemble(tree, q)
    tools, jacobians = tool_and_jacobian(arm, q)
    model.gravity.linear = np.array(state.gravity).reshape(-1)[:3]
    closures = []
    for weld in tree.welds:
        ends = [
            (of[place][0], of[place][1] * pin.SE3(frame))
            for place, frame in zip(weld.places, weld.frames, strict=True)
        ]
        kind, axes = pin.ContactType.CONTACT_6D, pin.ReferenceFrame.LOCAL
        closures.append(pin.RigidConstraintModel(kind, model, *ends[0], *ends[1], axes))
    data, held = model.createData(), [each.createData() for each in closures]
    at, frame = of[len(tree.places) - 1]
    driven = [model.joints[moving[k]].idx_v for k in tree.moved]
    others = np.setdiff1d(np.arange(model.nv), driven)
    for k in range(POSES):
        x = configuration(tree, model, moving, q[k], found.motions[k])
        pin.computeJointJacobians(model, data, x)
        for each in closures:
            one = data.oMi[each.joint1_id] * each.joint1_placement
            other = data.oMi[each.joint2_id] * each.joint2_placement
            np.testing.assert_allclose(pin.log6(one.actInv(other)).vector, 0.0, atol=1e-8)
        tool = data.oMi[at] * frame
        np.testing.assert_allclose(tool.homogeneous, tools[k], atol=1e-10)
        about = pin.SE3(np.eye(3), tool.translation).toActionMatrixInverse()
        twists = about @ pin.getJointJacobian(model, data, at, pin.ReferenceFrame.WORLD)
        rows = [
            pin.getConstraintJacobian(model, data, one, two)
            for one, two in zip(closures, held, strict=True)
        ]
        loops = np.vstack(rows)
        follow = -np.linalg.lstsq(loops[:, others], loops[:, driven], rcond=1e-9)[0]
        columns = twists[:, driven] + twists[:, others] @ follow
        expected = np.vstack([columns[3:], columns[:3]])
        np.testing.assert_allclose(jacobians[k], expected, atol=1e-11 * np.abs(expected).max())
        torques = pin.computeGeneralizedGravity(model, data, x)
        expected = torques[driven] + follow.T @ torques[others]
        np.testing.assert_allclose(
            state.torques[k], expected, atol=1e-11 * max(np.abs(expected).max(), 1e-3)
        )
