"""ISO 9283 characteristics: closed forms, agreement with the figures without sampling, and the
sheet of simulated robots.
"""

from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model.pose_matrix import screws
from lostmotion.laws import iso9283 as iso
from lostmotion.laws.frame_fit import best_fit, residual_after_fit
from lostmotion.mechanism.inverse import tool_and_jacobian
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.iso9283.cube import cube_from_arguments
from lostmotion.propagation.iso9283.experiment import Experiment
from lostmotion.propagation.iso9283.joint_motion import cycle_approach, side_approach
from lostmotion.propagation.iso9283.robots import CYCLES, DISTANCE, LOADS, PATH_CYCLES, load_sheets
from lostmotion.spatial import exp, pose_of

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "ISO 9283 sheet over robots",
        (
            "RP's constants; vAP of pure backlash in closed form; the study's kernel at the same "
            "poses; known frames recovered"
        ),
        "0.3 %; 4 standard errors, 10 %; encoder noise; 1e-9; 1e-12",
        "laws/iso9283.py laws/frame_fit.py",
    ),
)

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.mark.parametrize(("axes", "limit"), [(3, 3.61609), (2, 3.21872), (1, 2.60632)])
def test_rp_of_many_normal_visits_tends_to_its_constant(axes, limit):
    """RP of isotropic normal scatter is 3.61609 sigma in space, 3.21872 in a plane and 2.60632 on a
    line, sampled to 0.3 %.
    """
    visits = np.random.default_rng(2).normal(size=(400_000, axes))
    assert float(iso.pose_repeatability(visits)) == pytest.approx(limit, rel=3e-3)


def test_rp_of_thirty_visits_is_low_and_noisy():
    """With n = 30, RP averages 3.536 sigma and has a standard deviation of 0.329 between sets of
    visits.
    """
    sets = iso.pose_repeatability(np.random.default_rng(3).normal(size=(20_000, 30, 3)))
    assert sets.mean() == pytest.approx(3.536, abs=4 * 0.329 / np.sqrt(20_000))
    assert sets.std() == pytest.approx(0.329, rel=0.03)


def test_rp_of_play_has_a_closed_form():
    """Backlash of ±b on one axis: RP is (1/2 + 3 sqrt(1/12)) b = 1.36603 b for uniform positions,
    and b between the two stops.
    """
    rng, b = np.random.default_rng(4), 2e-5
    anywhere, stops = np.zeros((2, 400_000, 3))
    anywhere[:, 0], stops[:, 0] = rng.uniform(-b, b, len(anywhere)), rng.choice([-b, b], len(stops))
    assert float(iso.pose_repeatability(anywhere)) == pytest.approx(1.36603 * b, rel=3e-3)
    assert float(iso.pose_repeatability(stops)) == pytest.approx(b, rel=6e-3)


def test_characteristics_by_hand():
    """Two visits each, calculated by hand."""
    visits = np.array([[1.0, 0, 0], [3.0, 0, 0]])
    assert iso.pose_accuracy(visits, np.zeros(3)) == 2
    # both one away from the middle: no scatter of the distance
    assert iso.pose_repeatability(visits) == 1
    assert iso.axis_accuracy(visits) == pytest.approx([2, 0, 0])
    assert iso.axis_repeatability(visits) == pytest.approx([3 * np.sqrt(2), 0, 0])
    assert iso.distance_accuracy(np.zeros((2, 3)), visits, 1.5) == pytest.approx(0.5)
    assert iso.distance_repeatability(np.zeros((2, 3)), visits) == pytest.approx(3 * np.sqrt(2))
    sides = np.array([[[0.0, 0, 0], [0, 0, 0]], [[1, 0, 0], [3, 0, 0]], [[0, 1, 0], [0, 1, 0]]])
    assert iso.multi_directional_accuracy(sides) == pytest.approx(np.sqrt(5))
    for one_visit in (iso.pose_repeatability, iso.axis_repeatability):
        with pytest.raises(ValueError, match="at least 2"):
            one_visit(np.zeros((1, 3)))


@pytest.mark.parametrize("with_tool", [False, True])
def test_frames_are_found_again(with_tool):
    """Positions moved by a known base and tool frame return both to 1e-12, including large
    rotations.
    """
    rng = np.random.default_rng(5)
    command = rng.uniform(-0.5, 0.5, (12, 3))
    rotation = np.stack([pose_of(rpy=angles)[:3, :3] for angles in rng.uniform(-2, 2, (12, 3))])
    base = exp(np.array([0.3, -1.2, 0.7, 0.2, -0.4, 0.9]))
    tool = np.array([0.004, -0.002, 0.031]) if with_tool else np.zeros(3)
    attained = (command + rotation @ tool) @ base[:3, :3].T + base[:3, 3]
    fit = best_fit(attained, command, rotation if with_tool else None)
    assert fit.base == pytest.approx(base, abs=1e-12)
    assert fit.tool == pytest.approx(tool, abs=1e-12)
    assert np.abs(fit.residual).max() < 1e-12
    assert fit.rank == (9 if with_tool else 6)


def test_one_orientation_does_not_determine_the_tool():
    """With one orientation at all poses a tool offset is indistinguishable from a base shift: six
    parameters are determined, residuals vanish.
    """
    command = np.random.default_rng(6).uniform(-0.5, 0.5, (8, 3))
    held = np.tile(pose_of(rpy=(1.0, 0.2, 0.3))[:3, :3], (8, 1, 1))
    fit = best_fit(command + np.array([0.001, 0.002, 0.003]), command, held)
    assert fit.rank == 6
    assert np.abs(fit.residual).max() < 1e-12


def test_small_errors_are_fitted_in_one_step():
    """The joint fit of many robots leaves the residuals of each robot's exact fit, to second
    order.
    """
    rng = np.random.default_rng(7)
    command = rng.uniform(-0.5, 0.5, (5, 3))
    rotation = np.stack([pose_of(rpy=angles)[:3, :3] for angles in rng.uniform(-2, 2, (5, 3))])
    errors = rng.normal(0, 1e-5, (5, 4, 3))
    left = residual_after_fit(errors, command, rotation)
    for robot in range(4):
        assert left[:, robot] == pytest.approx(
            best_fit(command + errors[:, robot], command, rotation).residual, abs=1e-9
        )


def elbow():
    """Return three revolute joints with backlash that no load closes, and noise."""
    joint = {
        "type": "revolute",
        "limits": (-2.5, 2.5),
        "gearbox": {"backlash": "2 arcmin", "friction_torque": "1 kN m", "ratio": 100},
        "encoder": {"noise": "0.2 arcmin"},
        "link": {"length": "400 mm"},
    }
    joints = [
        {**joint, "name": name, "axis": axis} for name, axis in (("A", "z"), ("B", "y"), ("C", "y"))
    ]
    joints[0]["link"] = {"length": "300 mm", "direction": "z"}
    return lostmotion.Arm.model_validate({"name": "elbow", "joints": joints})


def test_each_joint_arrives_from_the_pose_before():
    """In the cycle P5, P4, P3, P2, P1 the sign at a pose is that of the motion from the previous
    pose; a joint at rest keeps its sign.
    """
    # P1 to P5
    q = np.array(
        [[0.0, 1.0, 5.0], [1.0, 1.0, 5.0], [2.0, 0.0, 5.0], [1.0, 0.0, 5.0], [3.0, 2.0, 5.0]]
    )
    signs, still = cycle_approach(q)
    assert still.tolist() == [False, False, True]
    # P1 from P2, P2 from P3, P3 from P4, P4 from P5, P5 from P1
    assert signs[:, 0].tolist() == [-1, -1, 1, -1, 1]
    assert signs[:, 1].tolist() == [1, 1, -1, -1, 1]  # P3 keeps what P4 had, P1 what P2 had
    assert (signs[:, 2] == 1).all()


def test_signs_of_each_joint_and_pose_are_felt_there():
    """The pose matrix for signs (pose, joint) equals, at each pose, that for its signs alone."""
    arm = elbow()
    q = np.array([[0.1, 0.5, -0.8], [0.4, 0.2, 0.9]])
    signs = np.array([[1.0, -1.0, 0.0], [-1.0, 1.0, 1.0]])

    def design(pose: int, sign: float, joint: str) -> np.ndarray:
        matrix = screws(state_of(arm, q[pose : pose + 1]), approach=sign)
        return sum(
            matrix.tool[0, :, t]
            for t in matrix.columns("design")
            if matrix.infos[t].owner.startswith(f"joints.{joint}.")
        )

    both = screws(state_of(arm, q), approach=signs).bias
    for pose in range(2):
        expected = sum(design(pose, signs[pose, k], joint) for k, joint in enumerate("ABC"))
        assert both[pose] == pytest.approx(expected, abs=1e-15)


def sheets_of(arm, cube, *, robots, cycles=CYCLES, seed=1, points=2, loads=(1.0,)):
    """Return the characteristics of simulated robots under these loads, without the tests of single
    axes.
    """
    visiting = Experiment(seed, robots, cycles, 0.0)
    line = (*DISTANCE, points)
    return load_sheets(arm, cube, visiting, dict(enumerate(loads)), line, PATH_CYCLES)


def test_vap_of_pure_play_has_a_closed_form():
    """Barycentres of approaches from three sides differ by the joints' backlash on their sides of
    arrival: |J (s - s') b / 2| at the worst pair.
    """
    arm = elbow()
    cube = cube_from_arguments(arm, np.array([0.5, 0.0, 0.4]), 0.2)
    (found,) = sheets_of(arm, cube, robots=2, cycles=200)
    approach = cycle_approach(cube.q)[0]
    half = np.radians(2 / 60) / 2
    for row, pose in enumerate((0, 1, 3)):
        signs = side_approach(arm, cube, pose, approach[pose])
        shifts = -half * signs @ tool_and_jacobian(arm, cube.q[pose : pose + 1])[1][0, 3:].T
        apart = max(np.linalg.norm(shifts[i] - shifts[j]) for i in range(3) for j in range(3))
        assert apart > 1e-5
        # encoder noise over 200 visits
        assert found.multi_directional[row] == pytest.approx(np.full(2, apart), rel=0.05)


def test_rp_over_robots_is_what_sums_over_terms_expect():
    """For normal visits, mean and standard deviation of RP over robots are those of the expectation
    without sampling.
    """
    arm = elbow()
    cube = cube_from_arguments(arm, np.array([0.5, 0.0, 0.4]), 0.2)
    (sheet,) = sheets_of(arm, cube, robots=1500)
    error = sheet.repeatability.std(axis=1) / np.sqrt(1500)
    assert np.abs(sheet.repeatability.mean(axis=1) - sheet.expected) == pytest.approx(
        np.zeros(5), abs=4 * error.max()
    )
    assert sheet.repeatability.std(axis=1) == pytest.approx(sheet.deviation, rel=0.1)
    assert (sheet.random_approach.mean(axis=1) > 3 * sheet.repeatability.mean(axis=1)).all()


def test_the_sheet_is_that_of_the_study_at_the_same_poses():
    """AP_p and RP_l with joints arriving from any side equal those of the accuracy study at these
    poses, from the same draws.
    """
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    cube = cube_from_arguments(arm, np.array([0.55, 0.0, 0.8]), 0.3)
    (found,) = sheets_of(arm, cube, robots=40, seed=3)
    study = lostmotion.study(arm, cube.q, robots=40, visits=30, seed=3, threads=1)
    assert found.random_approach.mean(axis=1) == pytest.approx(
        study.sampled.repeatability[:, 0], rel=1e-9
    )


def test_more_robots_keep_the_first_and_seeds_repeat():
    """The same seed gives identical results, more robots start with the same ones, and another seed
    gives others.
    """
    arm = elbow()
    cube = cube_from_arguments(arm, np.array([0.5, 0.0, 0.4]), 0.2)
    one, same, more, other = (
        sheets_of(arm, cube, robots=n, seed=seed, points=3)[0]
        for n, seed in ((8, 1), (8, 1), (16, 1), (8, 2))
    )
    assert (one.repeatability == same.repeatability).all()
    assert (one.path == same.path).all()
    assert more.repeatability[:, :8] == pytest.approx(one.repeatability, rel=1e-12)
    assert (one.repeatability != other.repeatability).any()


def test_a_lighter_load_sags_less():
    """At 10 % of the load an arm of springs and links has a smaller error at every pose."""
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    cube = cube_from_arguments(arm, np.array([0.55, 0.0, 0.8]), 0.3)
    full, light = sheets_of(arm, cube, robots=100, loads=LOADS)
    assert (full.load, light.load) == (1.0, 0.1)
    assert (light.accuracy.mean(axis=1) < full.accuracy.mean(axis=1)).all()
    assert (full.fitted.mean(axis=1) < full.accuracy.mean(axis=1)).all()
    assert light.path[0].mean() < full.path[0].mean()
    assert light.distance[0].mean() != full.distance[0].mean()


@pytest.mark.parametrize(
    "asked",
    [
        {"robots": 1},
        {"robots": 20_001},
        {"visits": 1},
        {"path": "P2 P2"},
        {"path": "P1 P7"},
        {"warm_up": "10 K", "warm_up_time": "0 s"},
        {"warm_up": float("nan")},
    ],
)
def test_numbers_out_of_range_are_refused(asked):
    """Numbers outside the range of the test, a line from a point to itself, and links that warm at
    once are refused.
    """
    with pytest.raises(lostmotion.InputError):
        lostmotion.iso9283(elbow(), cube=0.2, centre=(0.5, 0.0, 0.4), **asked)
