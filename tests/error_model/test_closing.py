"""A load closes the play of those robots whose friction it overcomes.

One joint of 1 m has a play of half-width h = 1 mm with a relative standard deviation k = 0.2, half
a friction loop of l = 0.6 mm,
and friction of 1 N m ±50 %. Let s be the side of the last motion, b = 1 where the load overcomes
this robot's friction, else 0, and x the standardised deviation of its play. The error of the tool
is p = h (1 + k x) (b + (1 - b) s) + l s.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from lostmotion.error_model.bounds import bounds, worst_case
from lostmotion.error_model.draws import Stream, uniforms, visit_draws
from lostmotion.error_model.intervals import quantile
from lostmotion.error_model.pose_matrix import screws
from lostmotion.error_model.poses import Poses
from lostmotion.laws.distributions import Normal
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.state import state_of
from lostmotion.parts.error_source import Friction
from lostmotion.propagation.analytic import DrawnColumns, analytic
from lostmotion.propagation.exact import draws_of
from lostmotion.propagation.montecarlo.montecarlo import run
from lostmotion.propagation.montecarlo.waterfall import waterfall
from lostmotion.propagation.pooled import pooled
from lostmotion.units import Toleranced
from tests.error_model.arms import ARMS
from tests.parts.random_arms import random_poses

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "play that a load closes in some robots",
        (
            "mean, variance, third and fourth cumulant of one joint by sums over sides and "
            "states; a million draws; the kernel; the worst case "
            "against 200 000 draws; the friction's distribution by SciPy"
        ),
        "5e-5; 4 standard errors; its intervals; not exceeded, within 5 %; 1e-15",
        "laws/clearance.py tests/laws/test_clearance.py",
    ),
)

H, K, L = 1.0, 0.2, 0.6
HERE = np.zeros((1, 1))
# c, mean, variance, third and fourth cumulant at each load, by sums over s and b; x is a normal
# distribution truncated at 3 sigma.
REFERENCE = {
    0.9: (0.2736, 0.2736, 2.1967, -1.2218, -7.9317),
    0.0: (0.0, 0.0, 2.6, 0.0, -13.1075),
    1.2: (0.8860, 0.8860, 0.7519, -0.7448, 0.8116),
}


def loaded(load, *, scatter=0.5, amount=K):
    """Return the arm with this torque (N m) about its joint and no other error."""
    play = Toleranced(2e-3 * H, 2e-3 * H * amount * Normal().bound)
    gearbox = {
        "backlash": play,
        "hysteresis": 2e-3 * L,
        "friction_torque": Friction(Toleranced(1.0, scatter)),
    }
    joint = {
        "name": "A",
        "type": "revolute",
        "axis": "z",
        "limits": (-1, 1),
        "gearbox": gearbox,
        "link": {"length": 1.0},
    }
    return Arm.model_validate(
        {"name": "loaded", "joints": [joint], "payload": {"mass": 0.0, "force": (0.0, load, 0.0)}}
    )


def sampled(arm, robots, visits=1, approach=0.0, seed=4):
    """Return the error of each sample (robot x visit,), mm, and whether the play of its robot is
    closed.
    """
    matrix = screws(state_of(arm, HERE), approach=approach)
    robot, visit = (
        axis.ravel() for axis in np.meshgrid(np.arange(robots), np.arange(visits), indexing="ij")
    )
    closed = uniforms(seed, "joints.A.gearbox.friction", robots)[robot] <= matrix.closed[0, 0]
    return 1e3 * (matrix.tool[0, 4] @ draws_of(matrix, 0, seed, 0, robot, visit)), closed


@pytest.mark.parametrize("load", REFERENCE)
def test_cumulants_are_the_sums_over_sides_and_states(load):
    """The columns of the pose matrix and their joint cumulants have the share, mean, variance,
    third and fourth cumulant of p.
    """
    matrix = screws(state_of(loaded(load), HERE))
    drawn = DrawnColumns(matrix)
    shift = 1e3 * drawn.shift(matrix)[0, 1]
    closed = matrix.closed.T[:, drawn.plays]
    third, fourth = (
        float(
            (
                np.broadcast_to(np.ravel(known.at(closed)), len(known.terms))
                * shift[known.terms].prod(axis=1)
            ).sum()
        )
        for known in (drawn.with_plays.third, drawn.with_plays.fourth)
    )
    found = (matrix.closed[0, 0], 1e3 * matrix.bias[0, 4], (shift**2).sum(), third, fourth)
    assert found == pytest.approx(REFERENCE[load], abs=5e-5)


@pytest.mark.parametrize("load", REFERENCE)
def test_samples_have_the_moments_of_the_sums(load):
    """A million draws of the kernel have the moments of p within four standard errors, and the play
    of every robot is closed or open.
    """
    p, closed = sampled(loaded(load), 1_000_000)
    _, mean, variance, third, _ = REFERENCE[load]
    central = p - mean
    for power, expected in ((1, 0.0), (2, variance), (3, third)):
        assert (central**power).mean() == pytest.approx(
            expected, abs=4 * (central**power).std() / 1e3
        )
    sizes = np.abs(p[~closed])
    assert sizes.min(initial=np.inf) >= H * (1 - K * Normal().bound) + L - 1e-9
    assert sizes.max(initial=0.0) <= H * (1 + K * Normal().bound) + L + 1e-9


@pytest.mark.parametrize(
    ("approach", "mean", "variance"), [(-1.0, 1.6, 0.04), (1.0, -1.0527, 0.8350)]
)
def test_a_known_approach_leaves_scatter_between_robots_alone(approach, mean, variance):
    """With a known approach each robot repeats exactly, and p varies between robots alone: the load
    or the last motion sets its play.
    """
    matrix = screws(state_of(loaded(0.9), HERE), approach=approach)
    merged = matrix.merged
    assert {info.level for info in merged.infos} <= {"design", "robot"}
    drawn = sum(merged.squares[k, 0] for k, info in enumerate(merged.infos) if info.draws)
    assert (1e3 * matrix.bias[0, 4], 1e6 * drawn) == pytest.approx((mean, variance), abs=5e-5)


@pytest.mark.parametrize("load", [0.0, 0.9, 1.2, 2.0])
@pytest.mark.parametrize("approach", [0.0, 1.0, -1.0])
def test_monte_carlo_and_the_analytic_study_agree(load, approach):
    """The mean, mean square and quantiles of |p| by Monte Carlo agree with the analytic study
    within their intervals.
    """
    arm = loaded(load)
    without = analytic(arm, HERE, approach=approach)
    found = run(arm, Poses(HERE, "given"), 4000, 8, 3, approach=approach).per_pose[0]
    assert found[0] == pytest.approx(without.mean[0], abs=2 * found[1])
    assert found[2] == pytest.approx(without.mean_square[0], rel=0.03)
    for k in range(3):
        value, low, high = found[6 + 3 * k : 9 + 3 * k]
        assert without.quantiles[0, k] == pytest.approx(value, abs=2 * (high - low) + 5e-6)


def test_an_unloaded_play_and_its_friction_loop_add_up():
    """Without load the mean of |p| is 1.60 mm for any approach, because every visit ends at one
    side of both play and friction loop.
    """
    for approach in (0.0, 1.0, -1.0):
        assert analytic(loaded(0.0), HERE, approach=approach).mean[0] == pytest.approx(
            1.6e-3, rel=1e-5
        )


@pytest.mark.parametrize("load", [0.3, 0.6, 0.9, 1.0, 1.2, 1.4, 2.0])
@pytest.mark.parametrize("approach", [0.0, 1.0, -1.0])
def test_no_sample_exceeds_the_worst_case_and_the_largest_is_close(load, approach):
    """The worst case is the larger of closed and open play, at least the largest of many samples
    and less than 5 % above it.
    """
    arm = loaded(load)
    largest = np.abs(sampled(arm, 200_000, approach=approach)[0]).max() * 1e-3
    matrix = screws(state_of(arm, HERE), approach=approach)
    bound = worst_case(matrix)[0]
    assert largest <= bound * (1 + 1e-12)
    assert bounds(matrix).root_sum_square[0] <= bound * (1 + 1e-12)
    if load not in {0.3, 2.0} or approach == 0:
        assert bound <= max(largest * 1.05, 1e-3 * (H * (1 + K * Normal().bound) + L) * 1.0001)


def test_friction_without_scatter_closes_the_play_of_all_robots_at_one_load():
    """Where all robots have the same friction, the play of every robot is open below that load and
    closed above it.
    """
    below, above = (screws(state_of(loaded(load, scatter=0.0), HERE)) for load in (0.99, 1.01))
    assert all(info.closing is None for matrix in (below, above) for info in matrix.infos)
    assert not below.bias.any()
    assert 1e3 * above.bias[0, 4] == pytest.approx(H)


def test_one_robot_s_play_at_two_poses_is_closed_by_one_friction():
    """The friction of a robot closes its play at two poses, so (b - c) has the correlation (min(c1,
    c2) - c1 c2) / sqrt(c1 (1 - c1) c2 (1 - c2)).
    """
    joint = {
        "name": "A",
        "type": "revolute",
        "axis": "y",
        "limits": (-2, 2),
        "link": {"length": 1.0},
    }
    gearbox = {"backlash": 2e-3, "friction_torque": Friction(Toleranced(9.0, 4.5))}
    arm = Arm.model_validate(
        {"name": "pitch", "joints": [joint | {"gearbox": gearbox}], "payload": {"mass": 1.0}}
    )
    matrix = screws(state_of(arm, np.array([[0.0], [0.45]])))
    first, second = matrix.closed[0]
    assert 0.1 < second < first < 0.9
    robots, changed = (
        np.arange(400_000),
        [
            k
            for k, info in enumerate(matrix.infos)
            if info.closing is not None and info.visit is None
        ],
    )
    z = np.array([draws_of(matrix, row, 1, row, robots, 0 * robots)[changed[0]] for row in (0, 1)])
    expected = (second - first * second) / np.sqrt(first * (1 - first) * second * (1 - second))
    assert np.corrcoef(z)[0, 1] == pytest.approx(expected, abs=5e-3)
    np.testing.assert_allclose((z.mean(axis=1), (z**2).mean(axis=1)), [[0, 0], [1, 1]], atol=0.01)


def test_load_compensation_leaves_the_scatter_of_friction():
    """Load compensation removes the mean of closed plays over robots, and a map of each robot also
    removes the state of its own play.
    """
    arm = loaded(0.9, amount=0.0)
    stages = waterfall(arm, Poses(HERE, "given"), 512, 4, 2).stages
    mean = {stage.name: 1e3 * stage.mean.value for stage in stages}
    c = float(screws(state_of(arm, HERE)).closed[0, 0])
    ends = [(share / 2, b, s) for (share, b), s in itertools.product(((c, 1), (1 - c, 0)), (-1, 1))]
    assert mean["as manufactured"] == pytest.approx(
        sum(w * abs(H * (b + (1 - b) * s) + L * s) for w, b, s in ends), rel=0.03
    )
    assert mean["both"] == pytest.approx(
        sum(w * abs(H * (b - c + (1 - b) * s) + L * s) for w, b, s in ends), rel=0.03
    )
    assert mean["both, and each robot mapped"] == pytest.approx(
        sum(w * abs(H * (1 - b) * s + L * s) for w, b, s in ends), rel=0.03
    )


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
def test_the_play_of_each_robot_is_either_closed_or_open(arm):
    """The pose matrix has the errors of a sum over single terms, each of which a robot's friction
    switches on or off.
    """
    q, robots = random_poses(arm, 6), 40
    state = state_of(arm, q)
    felt, matrix, joints = (
        state.conditions(),
        screws(state),
        [joint.name for joint in arm.driven],
    )
    robot, visit = (
        axis.ravel() for axis in np.meshgrid(np.arange(robots), np.arange(3), indexing="ij")
    )
    whole = np.zeros((len(q), 6, len(robot)))
    for of in arm.terms:
        term, condition = of.term, felt(of)
        moved = np.einsum(
            "pij,jp->pi", state.carry(of.place), term.scale * term.form.screw(condition)
        )
        for row in range(len(q)):
            size = np.ones(len(robot))
            if term.robot is not None:
                size = (
                    size
                    * term.robot.law.quantile(
                        uniforms(9, f"{term.robot.shared or of.owner}.{term.robot.stream}", robots)
                    )[robot]
                )
            if term.visit is not None:
                owner = (
                    f"joints.{joints[of.joint]}" if term.sided else term.visit.shared or of.owner
                )
                size = (
                    size
                    * visit_draws(
                        9,
                        [Stream(f"{owner}.{term.visit.stream}", term.visit.law)],
                        row,
                        robot,
                        visit,
                    )[0]
                )
            friction = term.form.threshold
            if friction is not None:
                closed = (
                    uniforms(9, f"{of.owner}.{friction.stream}", robots)[robot]
                    <= friction.share(condition)[row]
                )
                size = size * (closed == term.form.above)
            whole[row] += moved[row][:, None] * size
    for row in range(len(q)):
        found = matrix.tool[row] @ draws_of(matrix, row, 9, row, robot, visit)
        np.testing.assert_allclose(
            found, whole[row], rtol=1e-9, atol=1e-11 * np.abs(whole[row]).max() + 1e-30
        )


def test_pooled_quantiles_over_poses_of_any_load_agree_with_monte_carlo():
    """The pooled 95th percentile agrees with Monte Carlo over poses at which the load closes the
    play of all, some or none of the robots.
    """
    joint = {
        "name": "A",
        "type": "revolute",
        "axis": "y",
        "limits": (-1.5, 1.5),
        "link": {"length": 1.0},
    }
    gearbox = {
        "backlash": "2 mrad ± 0.4 mrad",
        "hysteresis": "0.5 mrad",
        "friction_torque": Friction(Toleranced(6.0, 3.0)),
    }
    arm = Arm.model_validate(
        {"name": "pitch", "joints": [joint | {"gearbox": gearbox}], "payload": {"mass": 1.0}}
    )
    poses = Poses(np.linspace(-1.5, 1.5, 64)[:, None], "given")
    some = screws(state_of(arm, poses.q)).closed_in_some
    assert 0.2 < some.mean() < 0.9
    without = pooled(arm, poses, analytic(arm, poses))
    found = run(arm, poses, 4000, 4, 1)
    assert found.robot_means[0, :, 0].mean() == pytest.approx(without.mean.value, rel=5e-3)
    counts = found.group_hist.sum(axis=0)
    assert quantile(counts, 0.95) == pytest.approx(without.quantiles[1].value, rel=0.01)
