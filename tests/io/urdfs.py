"""Small URDFs, written piece by piece."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from lostmotion.mechanism.state import state_of

LIMIT = '<limit lower="-1" upper="1.2" effort="1" velocity="1"/>'


def link(name, mass=1.0, centre="0.1 0.02 0.03", shape=""):
    """Return a body, weightless where its mass is zero."""
    inertia = '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>'
    inertial = (
        f'<inertial><origin xyz="{centre}"/><mass value="{mass}"/>{inertia}</inertial>'
        if mass
        else ""
    )
    return f'<link name="{name}">{inertial}{shape}</link>'


def joint(
    name,
    ends,
    kind="revolute",
    rest=f'<axis xyz="0 1 0"/>{LIMIT}',
    origin='xyz="0.3 0 0.1" rpy="0.2 0.1 0"',
):
    """Return a joint between two links, "parent child"."""
    parent, child = ends.split()
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child '
        f'link="{child}"/><origin {origin}/>{rest}</joint>'
    )


def robot(*parts):
    """Return a URDF of these parts, one a line."""
    return '<robot name="r">\n' + "\n".join(parts) + "\n</robot>\n"


def arm(count=3, root="base", name="link", joints="j"):
    """Return the parts of a chain: `root`, then joints j1, j2 ... to links link1, link2 ..., each
    with a mass of its own.
    """
    out = [link(root, 5.0)]
    for k in range(1, count + 1):
        out += [
            joint(f"{joints}{k}", f"{root if k == 1 else f'{name}{k - 1}'} {name}{k}"),
            link(f"{name}{k}", 1 + 0.1 * k),
        ]
    return out


def agrees_with_pinocchio(path, arm, tip, base=None, held=None):
    """Compare the tool frame and the static torques with Pinocchio's at ten poses; `held` gives the
    values of other joints.
    """
    model = pin.buildModelFromUrdf(str(path))
    model.gravity.linear = np.array([0, 0, -arm.gravity])
    data = model.createData()
    index = model.getFrameId(tip, pin.FrameType.BODY)
    start = model.getFrameId(base, pin.FrameType.BODY) if base else None
    q = np.random.default_rng(5).uniform(arm.limits[:, 0], arm.limits[:, 1], (10, len(arm.moving)))
    moving = [model.joints[model.getJointId(each.name)] for each in arm.moving]
    for row, where, torques in zip(
        q, state_of(arm, q).frames[-1], state_of(arm, q).torques, strict=True
    ):
        values = pin.neutral(model)
        for name, value in (held or {}).items():
            values[model.joints[model.getJointId(name)].idx_q] = value
        for each, value in zip(moving, row, strict=True):
            if each.nq == 2:
                values[each.idx_q : each.idx_q + 2] = np.cos(value), np.sin(value)
            else:
                values[each.idx_q] = value
        pin.framesForwardKinematics(model, data, values)
        expected = data.oMf[index] if start is None else data.oMf[start].actInv(data.oMf[index])
        assert np.abs(expected.homogeneous - where).max() < 1e-9
        expected_torques = pin.computeGeneralizedGravity(model, data, values)[
            [each.idx_v for each in moving]
        ]
        assert np.abs(expected_torques - torques).max() < 1e-9
