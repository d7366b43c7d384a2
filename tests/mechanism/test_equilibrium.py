"""Where a loaded arm stands, against published cases and a solver that shares no code with it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq, fsolve

from lostmotion import Arm, state_of
from lostmotion.mechanism.equilibrium import ElasticChain
from lostmotion.mechanism.load_gradient import Freedom, load_gradient
from lostmotion.mechanism.wrenches import place_wrenches

VALIDATES = [
    (
        "Equilibrium of soft arms with springs of joints, bearings and links, process force",
        "force balance with kinematics of its own, solved by SciPy's fsolve",
        "1e-6 of the droop",
    ),
]
G = 9.80665


def upright(
    stiffness: tuple[float | tuple[float, ...], ...],
    masses: tuple[float, ...],
    length: float,
    **gearbox: object,
) -> Arm:
    """Return joints that lift, with point masses at the ends of their massless links; `gearbox`
    has more values of each.
    """
    joints = [
        {
            "name": "AB"[k],
            "type": "revolute",
            "axis": "-y",
            "limits": ("-180 deg", "180 deg"),
            "gearbox": {"ratio": 100, "stiffness": each} | gearbox,
            "link": {"length": length, "mass": mass, "centre_of_mass": (length, 0.0, 0.0)},
        }
        for k, (each, mass) in enumerate(zip(stiffness, masses, strict=True))
    ]
    return Arm.model_validate({"name": "upright", "joints": joints})


def angles(arm: Arm, command: list[list[float]]) -> np.ndarray:
    """Return where the joints stand, deg."""
    q = np.radians(command)
    found = state_of(arm, q).settled().equilibrium
    moved = [-found.twists[place, :, 1] for place in arm.tree.moved]
    return np.degrees(q + np.array(moved).T)


def test_one_joint_on_a_soft_spring():
    """0.5 kg at 0.3 m on 5 N m/rad settles where the published solution has it."""
    found = angles(upright((5.0,), (0.5,), 0.3), [[0], [30], [60], [85]])
    expected = [-16.18806, 13.61745, 48.92445, 82.92334]
    np.testing.assert_allclose(found[:, 0], expected, atol=6e-6)


def test_two_joints_in_the_vertical_plane():
    """Angles and displacement of the tool are those of the published table."""
    arm = upright((30.0, 15.0), (0.4, 0.3), 0.25)
    command = [[0, 0], [30, 40], [60, -90], [-20, 100]]
    expected = [
        [-4.65965, -2.78571],
        [26.47936, 38.8263],
        [57.07077, -92.295],
        [-23.34976, 99.31888],
    ]
    np.testing.assert_allclose(angles(arm, command), expected, atol=6e-6)
    state = state_of(arm, np.radians(command))
    moved = 1e3 * (state.settled().frames[-1, :, :3, 3] - state.frames[-1, :, :3, 3])
    table = [[-2.9341, -52.7044], [26.2067, -21.317], [-1.3804, -25.8651], [11.8017, -17.2414]]
    np.testing.assert_allclose(moved[:, [0, 2]], table, atol=6e-5)


def test_pendulum_on_a_spring_stands_upright_only_on_a_stiff_one():
    """Upright, the spring must be stiffer than m g l; hanging, any spring holds."""
    for ratio, falls in ((0.5, 1), (0.99, 1), (1.01, 0), (3.0, 0)):
        arm = upright((ratio * 0.5 * G * 0.3,), (0.5,), 0.3)
        state = state_of(arm, np.radians([[90.0], [-90.0]])).settled()
        place = arm.tree.moved[0]
        assert state.equilibrium.falls_at.tolist() == [place if falls else -1, -1]
        assert np.isnan(state.frames[:, 0]).all() == bool(falls)


def test_pendulum_near_the_upright_stands_where_its_spring_holds_it():
    """A soft spring lets the pendulum down to its only stable equilibrium."""
    for ratio, degrees in ((0.5, 80.0), (0.9, 89.0), (1.1, 89.0), (0.5, -45.0)):
        arm = upright((ratio * 0.5 * G * 0.3,), (0.5,), 0.3)
        start = np.radians(degrees)
        # from the lower end, the first zero of the balance is the stable one
        ends = -np.pi / 2, start - 1e-3
        stands = brentq(lambda a, k, c: k * (c - a) - np.cos(a), *ends, args=(ratio, start))
        np.testing.assert_allclose(angles(arm, [[degrees]])[0, 0], np.degrees(stands), atol=1e-6)


def test_the_joint_that_cannot_hold_is_named():
    """Two upright links fall at the joint whose spring is below its load gradient."""
    for stiffness, name in (((100.0, 0.3), "B"), ((1.0, 100.0), "A")):
        arm = upright(stiffness, (0.4, 0.3), 0.25)
        found = state_of(arm, np.radians([[90.0, 0.0]])).settled().equilibrium
        assert arm.places[found.falls_at[0]] == name


def test_a_drive_that_is_limp_under_small_torques_hangs_or_falls():
    """Its spring is not wound by thousands of turns until the next zone balances the load."""
    arm = upright(((1e-12, 5e3, 5e3),), (0.5,), 0.3, zone_torques=(0.5, 1.0))
    q = np.radians(np.linspace(-80, 80, 9))[:, None]
    found = state_of(arm, q).settled().equilibrium
    stands = found.falls_at < 0
    assert stands.any()
    hangs = np.degrees(q[:, 0] - found.twists[arm.tree.moved[0], :, 1])
    np.testing.assert_allclose(hangs[stands], -90.0, atol=1e-3)


def test_contraction_is_the_share_of_stiffness_that_the_load_takes_away():
    """Near the solution a round shrinks the error by load gradient over stiffness."""
    arm = upright((5.0,), (0.5,), 0.3)
    found = state_of(arm, np.radians([[30.0]])).settled().equilibrium
    stands = np.radians(13.61745)
    np.testing.assert_allclose(
        found.contraction[0], 0.5 * G * 0.3 * np.sin(stands) / 5.0, rtol=0.02
    )


def test_without_loads_nothing_moves():
    """An arm without weights stands at its command, to the bit."""
    arm = upright((5.0,), (0.0,), 0.3)
    state = state_of(arm, np.radians([[30.0], [80.0]]))
    assert (state.settled().frames == state.frames).all()


def test_a_pose_settles_to_the_same_frames_alone_and_among_others():
    """A pose settles to the same bits whatever stands beside it."""
    arm = described(random_arm(1, 4, 1.0))
    q = np.random.default_rng(2).uniform(-2, 2, (12, 4))
    together = state_of(arm, q).settled()
    for row in (0, 5, 11):
        alone = state_of(arm, q[[row]]).settled()
        assert (alone.frames[:, 0] == together.frames[:, row]).all()
        assert (together.rows(slice(row, row + 1)).frames == alone.frames).all()


def test_load_gradient_is_the_derivative_of_the_wrenches():
    """Displacing any place changes the wrenches of all places as the gradient has it."""
    arm = described(random_arm(3, 3, 1.0))
    state = state_of(arm, np.random.default_rng(1).uniform(-2, 2, (2, 3)))
    freedoms = [Freedom(place, k) for place in range(len(arm.places)) for k in range(6)]
    found = load_gradient(arm.tree, state.frames, arm.payload, state.gravity, freedoms)
    for j, (place, component) in enumerate(freedoms):
        twists = np.zeros((len(arm.places), 2, 6))
        twists[place, :, component] = 1e-6
        ahead, behind = (
            place_wrenches(
                arm.tree,
                ElasticChain(arm.tree, state.frames).displaced(sign * twists, slice(None)),
                arm.payload,
                state.gravity,
            )
            for sign in (1, -1)
        )
        np.testing.assert_allclose(found[..., j], (ahead - behind) / 2e-6, atol=2e-7)


# A solver of the same balance, with kinematics and statics of its own.


def hat(twist: np.ndarray) -> np.ndarray:
    """Return the matrix (4, 4) of a twist (rotation, displacement)."""
    x, y, z = twist[:3]
    out = np.zeros((4, 4))
    out[:3] = [[0, -z, y, twist[3]], [z, 0, -x, twist[4]], [-y, x, 0, twist[5]]]
    return out


def rpy_pose(xyz: list[float], rpy: list[float]) -> np.ndarray:
    """Return a pose from a position and angles about the fixed axes."""
    out = np.eye(4)
    for axis, angle in enumerate(rpy):
        out = expm(hat(np.eye(6)[axis] * angle)) @ out
    out[:3, 3] = xyz
    return out


def random_arm(seed: int, joints: int, softness: float) -> dict:
    """Return a random arm: axes, springs, links with compliance matrices, masses, loads."""
    rng = np.random.default_rng(seed)
    out = []
    for _ in range(joints):
        axis = rng.normal(size=3)
        root = rng.normal(size=(6, 6)) * np.array([1, 1, 1, 0.2, 0.2, 0.2])[:, None]
        out.append(
            {
                "axis": axis / np.linalg.norm(axis),
                "spring": rng.uniform(60, 150) / softness,
                "tilt": rng.uniform(200, 500) / softness,
                "radial": rng.uniform(1, 3) * 1e4 / softness,
                "axial": rng.uniform(1, 3) * 1e4 / softness,
                "xyz": rng.uniform(-0.25, 0.25, 3),
                "rpy": rng.uniform(-1, 1, 3),
                "compliance": root @ root.T * 2e-4 * softness,
                "own_weight": rng.normal(size=(6, 3)) * 2e-4 * softness,
                "mass": rng.uniform(0.1, 0.6),
                "centre": rng.uniform(-0.1, 0.1, 3),
                "housing": rng.uniform(0.0, 0.4),
            }
        )
    return {
        "joints": out,
        "payload": (rng.uniform(0.2, 0.6), rng.uniform(-0.05, 0.05, 3)),
        "force": rng.uniform(-2, 2, 3),
        "moment": rng.uniform(-0.3, 0.3, 3),
    }


def described(arm: dict, *, errors: bool = False) -> Arm:
    """Return the arm as this software describes it, with errors of encoders, springs and links where
    they are wanted.
    """
    joints = [
        {
            "name": f"J{k}",
            "type": "revolute",
            "axis": tuple(each["axis"]),
            "limits": (-3.0, 3.0),
            "mass": each["housing"],
            "gearbox": {
                "ratio": 100,
                "stiffness": each["spring"],
                **({"stiffness_scatter": 0.1} if errors else {}),
            },
            **({"encoder": {"zero": 3e-4}} if errors else {}),
            "bearing": {
                "kind": "crossed roller",
                "moment_stiffness": each["tilt"],
                "radial_stiffness": each["radial"],
                "axial_stiffness": each["axial"],
            },
            "link": {
                "tip": {"xyz": tuple(each["xyz"]), "rpy": tuple(each["rpy"])},
                "mass": each["mass"],
                "centre_of_mass": tuple(each["centre"]),
                **({"length_tolerance": 1e-4} if errors else {}),
                "compliance": {
                    "matrix": tuple(map(tuple, each["compliance"])),
                    "own_weight": tuple(map(tuple, each["own_weight"])),
                },
            },
        }
        for k, each in enumerate(arm["joints"])
    ]
    mass, centre = arm["payload"]
    payload = {
        "mass": mass,
        "centre_of_mass": tuple(centre),
        "force": tuple(arm["force"]),
        "moment": tuple(arm["moment"]),
    }
    return Arm.model_validate({"name": "random", "joints": joints, "payload": payload})


def balance(arm: dict, q: np.ndarray, unknown: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return twists minus compliance times wrench, and the pose of the tool."""
    twists = unknown.reshape(-1, 2, 6)
    here, weights, places = np.eye(4), [], []
    for joint, value, (turn, bend) in zip(arm["joints"], q, twists, strict=True):
        weights.append((len(places), here[:3, 3], joint["housing"]))
        here = here @ expm(hat(np.append(joint["axis"] * value, [0, 0, 0]))) @ expm(hat(turn))
        places.append(here)
        weights.append((len(places), (here @ np.append(joint["centre"], 1))[:3], joint["mass"]))
        here = here @ rpy_pose(joint["xyz"], joint["rpy"]) @ expm(hat(bend))
        places.append(here)
    mass, centre = arm["payload"]
    weights.append((len(places), (here @ np.append(centre, 1))[:3], mass))
    out = []
    for k, at in enumerate(places):
        force, moment = here[:3, :3] @ arm["force"], here[:3, :3] @ arm["moment"]
        moment = moment + np.cross(here[:3, 3] - at[:3, 3], force)
        for carrier, point, kilograms in weights:
            if carrier > k:
                pull = np.array([0, 0, -kilograms * G])
                force, moment = force + pull, moment + np.cross(point - at[:3, 3], pull)
        wrench = np.concatenate([at[:3, :3].T @ moment, at[:3, :3].T @ force])
        joint = arm["joints"][k // 2]
        if k % 2:
            down = at[:3, :3].T @ np.array([0, 0, -G])
            out.append(joint["compliance"] @ wrench + joint["own_weight"] @ down)
            continue
        along = np.outer(joint["axis"], joint["axis"])
        out.append(
            np.concatenate(
                [
                    (along / joint["spring"] + (np.eye(3) - along) / joint["tilt"]) @ wrench[:3],
                    (along / joint["axial"] + (np.eye(3) - along) / joint["radial"]) @ wrench[3:],
                ]
            )
        )
    return unknown - np.concatenate(out), here


@pytest.mark.parametrize(("joints", "softness"), [(3, 3.0), (4, 3.0), (5, 1.0), (6, 0.3), (7, 0.3)])
def test_random_soft_arms_stand_where_forces_balance(joints, softness):
    """The tool of a soft arm stands where an independent force balance has it."""
    for seed in range(2):
        drawn = random_arm(seed + 10 * joints, joints, softness)
        q = np.random.default_rng(seed).uniform(-2, 2, joints)
        settled = state_of(described(drawn), q[None]).settled()
        assert settled.equilibrium.falls_at[0] == -1
        solution, _, converged, message = fsolve(
            lambda e, arm=drawn, at=q: balance(arm, at, e)[0],
            np.zeros(12 * joints),
            xtol=1e-13,
            full_output=True,
        )
        assert converged == 1 or np.abs(balance(drawn, q, solution)[0]).max() < 1e-11, message
        tool, rest = (balance(drawn, q, e)[1] for e in (solution, np.zeros(12 * joints)))
        droop = np.linalg.norm(tool[:3, 3] - rest[:3, 3])
        assert droop > 1e-3
        np.testing.assert_allclose(settled.frames[-1, 0, :3, 3], tool[:3, 3], atol=1e-6 * droop)
