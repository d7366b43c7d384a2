"""How errors move the tool of a soft arm whose loads they change."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import root

from lostmotion import Arm, screws, state_of
from lostmotion.mechanism.equilibrium import ElasticChain
from lostmotion.mechanism.state import DesignDeflection
from lostmotion.propagation.exact import compose
from lostmotion.spatial import exp, inverse, right_jacobian, rotation_vector
from tests.arms import JOINT
from tests.mechanism.test_equilibrium import balance, described, random_arm

VALIDATES = [
    (
        "Effect of errors on the tool of a soft arm, with the loads that they change",
        "differences of an independent force balance, solved by SciPy",
        "1e-6",
        "mechanism/load_feedback.py",
    ),
]


def errors_of(matrix, draws):
    """Return the twists of all places (12 joint,) by drawn errors, and the motion of the tool that
    the pose matrix has for them, at the first pose.
    """
    drawn = [k for k, info in enumerate(matrix.infos) if info.level != "design"]
    places = matrix.state.arm.places
    out = np.zeros((len(matrix.state.arm.joints), 2, 6))
    for k in drawn:
        name = places[matrix.place[k]]
        out[int(name[1]), int(name.endswith(".tip"))] += draws[k] * matrix.local[0, :, k]
    return out.ravel(), matrix.tool[0][:, drawn] @ draws[drawn]


@pytest.mark.parametrize(
    ("joints", "softness"),
    [
        (3, 3.0),
        (4, 3.0),
        pytest.param(7, 0.3, marks=pytest.mark.slow),
    ],
)
def test_errors_of_soft_arms_move_the_tool_as_a_force_balance_has_it(joints, softness):
    """The motion of the tool by random errors of all parts is that of an independent balance of
    forces; loads that do not follow the errors would miss it by per cents.
    """
    drawn = random_arm(10 * joints, joints, softness)
    rng = np.random.default_rng(joints)
    q = rng.uniform(-2, 2, joints)
    state = state_of(described(drawn, errors=True), q[None]).settled()
    matrix = screws(state)
    rest = root(lambda e: balance(drawn, q, e)[0], np.zeros(12 * joints), tol=1e-14).x
    twists, moved = errors_of(matrix, rng.normal(size=len(matrix.infos)))
    step = 1e-4 / np.abs(twists).max()

    def tool(sign: int) -> np.ndarray:
        found = root(lambda e: balance(drawn, q, e)[0] - sign * step * twists, rest, tol=1e-14).x
        return balance(drawn, q, found)[1]

    ahead, behind = tool(1), tool(-1)
    shift = (ahead - behind)[:3, 3] / (2 * step)
    np.testing.assert_allclose(moved[3:], shift, atol=1e-6 * np.linalg.norm(shift))
    turn = rotation_vector(ahead[:3, :3] @ behind[:3, :3].T) / (2 * step)
    np.testing.assert_allclose(moved[:3], turn, atol=1e-6 * np.linalg.norm(turn))
    fixed = state.tool_twists(matrix.place, matrix.local.transpose(1, 2, 0))[3:, :, 0]
    assert np.abs(fixed - matrix.tool[0, 3:]).max() > 0.01 * np.abs(matrix.tool[0, 3:]).max()


def servo_arm(axes: str = "yxyy", stiffness: str = "200 N m/rad") -> Arm:
    """Return joints about these axes on servos that know part of the weights, with plays and
    bending links, under a process force.
    """
    joint = {
        **JOINT,
        "gearbox": {"backlash": "10 arcmin ± 3 arcmin", "stiffness": 400.0, "ratio": 100},
        "bearing": {"kind": "crossed roller", "moment_stiffness": 900.0, "radial_stiffness": 3e5},
        "servo": {"stiffness": stiffness, "gravity_compensation": "60 %"},
        "limits": (-2, 2),
        "link": {
            "length": "400 mm ± 1 mm",
            "section": {"kind": "tube", "outer": "20 mm", "wall": "1 mm"},
            "material": {"young": "3 GPa", "poisson": 0.33, "density": "2700 kg/m^3"},
        },
    }
    joints = [{**joint, "name": f"J{k}", "axis": axis} for k, axis in enumerate(axes)]
    payload = {"mass": "1 kg", "force": ("5 N", "-3 N", "8 N"), "moment": ("0.5 N m", 0, 0)}
    return Arm.model_validate({"name": "servos", "joints": joints, "payload": payload})


def test_errors_move_the_tool_of_servos_and_bending_links_as_their_equilibrium():
    """Small errors of all parts move the tool as the difference of two equilibria, with springs
    that only the weights or only the process force wind, plays, and links under their own weight.
    """
    arm, rng = servo_arm(), np.random.default_rng(4)
    matrix = screws(state_of(arm, rng.uniform(-1.5, 1.5, (1, 4))).settled())
    assert arm.soft_freedoms
    rows, step = np.arange(1), 1e-3
    drawn = np.array([info.level != "design" for info in matrix.infos])
    draws = rng.normal(size=len(matrix.infos)) * drawn

    def tools(sign: int) -> np.ndarray:
        values = np.where(drawn, sign * step * draws, 1.0)
        return compose(matrix, rows, values[None, :, None])[:, 0, :3, 3]

    shift = (tools(1) - tools(-1)) / (2 * step)
    np.testing.assert_allclose(matrix.tool[:, 3:] @ draws, shift, atol=1e-5 * np.abs(shift).max())


def test_a_pose_of_a_soft_arm_has_the_same_errors_alone_and_among_others():
    """The errors of a soft arm at a pose have the same bits whatever stands beside it."""
    arm = described(random_arm(1, 4, 1.0), errors=True)
    q = np.random.default_rng(2).uniform(-2, 2, (6, 4))
    together = screws(state_of(arm, q).settled())
    for row in (0, 5):
        alone = screws(state_of(arm, q[[row]]).settled())
        assert (alone.tool[0] == together.tool[row]).all()
    arm = servo_arm("yx", "8 N m/rad")
    q = np.random.default_rng(2).uniform(-1.5, 1.5, (20, 2))
    frames = state_of(arm, q).settled().frames
    assert 0 < np.isnan(frames[-1, :, 0, 3]).sum() < 5  # some fall beside it
    alone = state_of(arm, q[[8]]).settled().frames
    np.testing.assert_array_equal(alone[:, 0], frames[:, 8])


def test_the_tangent_is_the_derivative_of_the_deflections():
    """Newton's matrix equals central differences of what the parts deflect in displaced frames,
    with springs that the process force does not wind and links under their own weight.
    """
    arm, rng = servo_arm(), np.random.default_rng(4)
    state = state_of(arm, rng.uniform(-1.5, 1.5, (3, 4)))
    deflection, rows = DesignDeflection(state), np.arange(3)
    chain = ElasticChain(arm.tree, np.ascontiguousarray(state.frames))
    found, _ = deflection.tangent(state.frames, rows)
    step = 1e-6
    for column, (place, component) in enumerate(deflection.freedoms):
        twist = np.zeros((len(arm.places), 3, 6))
        twist[place, :, component] = step
        ahead, behind = (
            deflection.twists(chain.displaced(sign * twist, rows), rows)[0] for sign in (1, -1)
        )
        expected = [
            (ahead - behind)[each.place, :, each.component] / (2 * step)
            for each in deflection.freedoms
        ]
        np.testing.assert_allclose(found[:, :, column].T, expected, atol=1e-7)


def test_the_right_jacobian_is_the_derivative_of_the_exponential():
    """A change of a twist moves the frame it leads to by the Jacobian times the change, in the axes
    of the frame.
    """
    rng = np.random.default_rng(3)
    twist, change = rng.normal(size=(2, 5, 6)) * 0.5
    step = 1e-6
    moved = inverse(exp(twist)) @ (exp(twist + step * change) - exp(twist - step * change))
    found = np.einsum("pij,pj->pi", right_jacobian(twist), change)
    expected = moved[:, [2, 0, 1, 0, 1, 2], [1, 2, 0, 3, 3, 3]] / (2 * step)
    np.testing.assert_allclose(found, expected, atol=1e-9)
