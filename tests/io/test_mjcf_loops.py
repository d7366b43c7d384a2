"""Loops of MJCF models, by `connect` and `weld`, beside MuJoCo: its frames where its own residuals
vanish, and the static torques that balance its bias forces and its constraint forces.
"""

from __future__ import annotations

import numpy as np
import pytest

import lostmotion
from lostmotion.errors import InputError
from lostmotion.mechanism.state import state_of

mujoco = pytest.importorskip("mujoco")

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "frames and static torques of MJCF models with loops (`connect`, `weld`)",
        "MuJoCo: its equality residuals solved, its bias and constraint forces balanced",
        "1e-7",
    ),
)


def body(name, pos, kind, inside="", *, mass=0.5, centre="0.1 0 0.02", **joint):
    """Return a body with one joint of its name."""
    stated = " ".join(f'{key}="{value}"' for key, value in joint.items())
    return (
        f'<body name="{name}" pos="{pos}"><inertial pos="{centre}" mass="{mass}" '
        f'diaginertia="0.001 0.001 0.001"/><joint name="{name}" type="{kind}" {stated}/>'
        f"{inside}</body>"
    )


def model(bodies, equality, *drives):
    """Return an MJCF file."""
    motors = "".join(f'<motor joint="{drive}"/>' for drive in drives)
    return (
        f'<mujoco model="loop"><option jacobian="dense"/><worldbody>{bodies}</worldbody>'
        f"<equality>{equality}</equality><actuator>{motors}</actuator></mujoco>"
    )


TURN = {"axis": "0 -1 0"}
RANGE = {"range": "-40 40"}
TCP = '<site name="tcp" pos="0.5 0 0.05" euler="10 0 30"/>'
FOUR_BAR = model(
    body(
        "crank",
        "0 0 0.1",
        "hinge",
        body("coupler", "0 0 0.2", "hinge", TCP, **TURN),
        **TURN,
        **RANGE,
    )
    + body("rocker", "0.4 0 0.1", "hinge", centre="0 0 0.1", **TURN),
    '<connect name="pin" body1="coupler" body2="rocker" anchor="0.4 0 0"/>',
    "crank",
)
FIVE_BAR = model(
    body(
        "left",
        "0 0 0",
        "hinge",
        body("far", "-0.1 0 0.2", "hinge", '<site name="tcp" pos="0.2 0 0.25"/>', **TURN),
        **TURN,
        **RANGE,
    )
    + body(
        "right",
        "0.2 0 0",
        "hinge",
        body("other", "0.1 0 0.2", "hinge", '<site name="end" pos="-0.2 0 0.25"/>', **TURN),
        **TURN,
        **RANGE,
    ),
    '<connect site1="tcp" site2="end"/>',
    "left",
    "right",
)
# Crank and rocker in planes that cross, and a rod with a ball at each end.
SPATIAL = model(
    body("rocker", "0.3 0.1 0", "hinge", '<site name="tcp" pos="0 0.2 0.3"/>', axis="1 0 0.2")
    + body(
        "crank",
        "0 0 0",
        "hinge",
        body("rod", "0.1 0.1 0.05", "ball", centre="0.1 0.025 0.05"),
        axis="0 0 1",
        range="-30 30",
        ref="10",
    ),
    '<connect body1="rod" body2="rocker" anchor="0.2 0.05 0.1"/>',
    "crank",
)
WELDED = model(
    body(
        "crank",
        "0 0 0.1",
        "hinge",
        body("coupler", "0 0 0.2", "hinge", TCP, **TURN),
        **TURN,
        **RANGE,
    )
    + body(
        "rocker",
        "0.4 0 0.1",
        "hinge",
        body("stub", "0 0 0.2", "hinge", mass=0.1, **TURN),
        **TURN,
    ),
    '<weld body1="coupler" body2="stub"/>',
    "crank",
)


def of_mujoco(path, arm, q):
    """Return pose of the tool (4, 4) and torques of the drives with these at `q`, by MuJoCo."""
    made = mujoco.MjModel.from_xml_path(str(path))
    made.opt.gravity = [0, 0, -9.80665]
    data = mujoco.MjData(made)
    names = [joint.name for joint in arm.driven]
    ids = [made.joint(name).id for name in names]
    dofs = made.jnt_dofadr[ids]
    passive = np.setdiff1d(np.arange(made.nv), dofs)
    for count in range(1, 121):  # on the way from the pose of the file, in its assembly mode
        for at, value in zip(made.jnt_qposadr[ids], q, strict=True):
            data.qpos[at] = made.qpos0[at] + value * min(count / 60, 1.0)
        mujoco.mj_forward(made, data)
        rows = data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        jacobian = data.efc_J.reshape(-1, made.nv)[rows]
        step = np.zeros(made.nv)
        step[passive] = -np.linalg.lstsq(jacobian[:, passive], data.efc_pos[rows], rcond=1e-9)[0]
        mujoco.mj_integratePos(made, data.qpos, step, 1.0)
    mujoco.mj_forward(made, data)
    assert np.abs(data.efc_pos[rows]).max() < 1e-10
    pose = np.eye(4)
    pose[:3, :3] = data.site("tcp").xmat.reshape(3, 3)
    pose[:3, 3] = data.site("tcp").xpos
    forces = np.hstack([np.eye(made.nv)[:, dofs], data.efc_J.reshape(-1, made.nv)[rows].T])
    found = np.linalg.lstsq(forces, data.qfrc_bias, rcond=1e-9)[0]
    np.testing.assert_allclose(forces @ found, data.qfrc_bias, atol=1e-9)
    return pose, found[: len(dofs)]


def read(tmp_path, text, sidecar='tip = "tcp"'):
    """Return the file and the arm of an MJCF text."""
    path = tmp_path / "arm.xml"
    path.write_text(text, "utf-8")
    path.with_suffix(".toml").write_text(sidecar, "utf-8")
    return path, lostmotion.read(path)


@pytest.mark.parametrize(
    ("text", "passive", "closures"),
    [
        (FOUR_BAR, ["coupler", "rocker", "pin_ball"], 1),
        (FIVE_BAR, ["far", "other", "loop_ball"], 1),
        (SPATIAL, ["rocker", "rod", "loop_ball"], 1),
        (WELDED, ["coupler", "rocker", "stub"], 1),
    ],
)
def test_a_loop_stands_and_is_held_as_in_mujoco(tmp_path, text, passive, closures):
    """Joints of a loop without an actuator are passive; the tool is where MuJoCo has it, and the
    drives hold what balances its model.
    """
    path, arm = read(tmp_path, text)
    assert len(arm.closures) == closures
    moved = {each.joint for each in arm.tree.passive}
    assert moved == set(passive)
    assert not [each for each in arm.warnings if "ball" in each]
    for share in (-0.2, -0.1, 0.0):
        q = share * np.arange(1, len(arm.driven) + 1)
        state = state_of(arm, q[None])
        pose, torques = of_mujoco(path, arm, q)
        np.testing.assert_allclose(state.frames[-1, 0], pose, atol=1e-7)
        np.testing.assert_allclose(state.torques[0], torques, atol=1e-7)


URDF_FOUR_BAR = """<robot name="four-bar">
<link name="base"/>
{links}
<joint name="crank" type="revolute"><parent link="base"/><child link="crank"/>
<origin xyz="0 0 0.1"/><axis xyz="0 -1 0"/>
<limit lower="-0.7" upper="0.7" effort="0" velocity="0"/></joint>
<joint name="knee" type="continuous"><parent link="crank"/><child link="coupler"/>
<origin xyz="0 0 0.2"/><axis xyz="0 -1 0"/></joint>
<joint name="tool" type="fixed"><parent link="coupler"/><child link="tool0"/>
<origin xyz="0.5 0 0.05"/></joint>
<joint name="lug" type="fixed"><parent link="coupler"/><child link="lug"/>
<origin xyz="0.4 0 0"/></joint>
<joint name="rocker" type="continuous"><parent link="base"/><child link="rocker"/>
<origin xyz="0.4 0 0.1"/><axis xyz="0 -1 0"/></joint>
<joint name="pin" type="continuous"><parent link="rocker"/><child link="end"/>
<origin xyz="0 0 0.2"/><axis xyz="0 -1 0"/></joint>
</robot>"""
OF_SIDECAR = """tip = "tool0"
joints = { knee = { passive = true }, rocker = { passive = true }, pin = { passive = true } }
[[closures]]
joins = ["lug.tip", "pin.tip"]
"""


def test_a_urdf_with_a_loop_in_its_sidecar_is_the_same_four_bar(tmp_path):
    """URDF states a tree; the sidecar joins two of its branches and says which joints no drive
    moves. Tool and torque are those of the MJCF model of the same machine.
    """
    masses = {"crank": (0.5, "0.1 0 0.02"), "coupler": (0.5, "0.1 0 0.02")}
    masses |= {"rocker": (0.5, "0 0 0.1")}
    links = "".join(
        f'<link name="{name}"><inertial><origin xyz="{centre}"/><mass value="{mass}"/><inertia '
        'ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        for name, (mass, centre) in masses.items()
    ) + "".join(f'<link name="{name}"/>' for name in ("tool0", "lug", "end"))
    path = tmp_path / "four-bar.urdf"
    path.write_text(URDF_FOUR_BAR.format(links=links), "utf-8")
    path.with_suffix(".toml").write_text(OF_SIDECAR, "utf-8")
    arm, other = lostmotion.read(path), read(tmp_path, FOUR_BAR)[1]
    q = np.array([[-0.3], [0.0], [0.2]])
    one, two = state_of(arm, q), state_of(other, q)
    np.testing.assert_allclose(one.frames[-1, :, :3, 3], two.frames[-1, :, :3, 3], atol=1e-9)
    np.testing.assert_allclose(one.torques, two.torques, atol=1e-9)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        (FOUR_BAR.replace('<motor joint="crank"/>', ""), "none of which an actuator moves"),
        (FOUR_BAR.replace("/></actuator>", '/><motor joint="rocker"/></actuator>'), "freedoms"),
        (SPATIAL.replace('type="ball"', 'type="hinge"'), "closures"),
    ],
)
def test_a_loop_that_cannot_be_a_mechanism_is_refused(tmp_path, text, found):
    """Without a drive, with one too many, and with a hinge where a ball is needed."""
    with pytest.raises(InputError) as refused:
        read(tmp_path, text)
    assert found in str(refused.value)


def test_a_loop_of_two_branches_asks_for_the_link_that_carries_the_tool(tmp_path):
    """The branches of a five-bar are no two arms."""
    five_bar = model(
        "".join(
            body(
                f"{side}-arm",
                f"{x} 0 0.1",
                "hinge",
                body(f"{side}-rod", "0 0 0.2", "hinge", **TURN),
                **TURN,
                **RANGE,
            )
            for side, x in (("left", 0), ("right", 0.4))
        ),
        '<connect name="pin" body1="left-rod" body2="right-rod" anchor="0.2 0 0"/>',
        "left-arm",
        "right-arm",
    )
    with pytest.raises(InputError) as refused:
        read(tmp_path, five_bar, sidecar="")
    (problem,) = refused.value.problems
    assert problem.found.startswith(
        "which of 2 links of the loops carries the tool? left: left-rod"
    )
    assert problem.expected.startswith("that link, named in ")
    assert problem.example == 'tip = "left-rod"'
