"""A load closes a play where it overcomes friction, which differs from robot to robot.

One joint of 1 m has a play of half width h = 1 mm, which differs by k = 0.2 of itself (one standard deviation), half a friction loop of l = 0.6 mm,
and friction of 1 N m ±50 %. With s the side of the last motion, b = 1 where the load overcomes this robot's friction and x its amount of play,
the tool errs by p = h (1 + k x) (b + (1 - b) s) + l s.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from lostmotion.error_model.bounds import root_sum_square, worst_case
from lostmotion.error_model.draws import Stream, uniforms, visit_draws
from lostmotion.error_model.intervals import quantile
from lostmotion.error_model.pose_matrix import screws
from lostmotion.error_model.poses import Poses
from lostmotion.laws.distributions import Normal
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.carry import carry
from lostmotion.mechanism.serial import Conditions, frames
from lostmotion.parts.error_source import Friction
from lostmotion.propagation.analytic import Drawn, analytic, pooled
from lostmotion.propagation.exact import draws_of
from lostmotion.propagation.montecarlo.montecarlo import run
from lostmotion.propagation.montecarlo.waterfall import STAGES, waterfall
from lostmotion.units import Toleranced
from tests.parts.random_arms import example_arms, random_arms, random_poses

H, K, L = 1.0, 0.2, 0.6
HERE = np.zeros((1, 1))
# c, mean, variance, third and fourth cumulant at each load, by sums over s and b (for the amount's mean powers, x is a normal law cut at 3 sigma).
REFERENCE = {
    0.9: (0.2736, 0.2736, 2.1967, -1.2218, -7.9317),
    0.0: (0.0, 0.0, 2.6, 0.0, -13.1075),
    1.2: (0.8860, 0.8860, 0.7519, -0.7448, 0.8116),
}


def loaded(load, *, scatter=0.5, amount=K):
    """Return the arm with this torque (N m) about its joint, and nothing else that errs."""
    play = Toleranced(2e-3 * H, 2e-3 * H * amount * Normal().bound)
    gearbox = {"backlash": play, "hysteresis": 2e-3 * L, "friction_torque": Friction(Toleranced(1.0, scatter))}
    joint = {"name": "A", "type": "revolute", "axis": "z", "limits": (-1, 1), "gearbox": gearbox, "link": {"length": 1.0}}
    return Arm.model_validate({"name": "loaded", "joints": [joint], "payload": {"mass": 0.0, "force": (0.0, load, 0.0)}})


def sampled(arm, robots, visits=1, approach=0.0, seed=4):
    """Return the error of each sample (robot x visit,), mm, and whether this robot's play is closed."""
    matrix = screws(arm, HERE, approach=approach)
    robot, visit = (axis.ravel() for axis in np.meshgrid(np.arange(robots), np.arange(visits), indexing="ij"))
    closed = uniforms(seed, "joints.A.gearbox.friction", robots)[robot] <= matrix.closed[0, 0]
    return 1e3 * (matrix.tool[0, 4] @ draws_of(matrix, 0, seed, 0, robot, visit)), closed


@pytest.mark.parametrize("load", REFERENCE)
def test_moments_are_those_of_all_sides_and_states(load):
    """Share, mean, variance, third and fourth cumulant of p, from the columns of the pose matrix and their joint cumulants."""
    matrix = screws(loaded(load), HERE)
    drawn = Drawn(matrix)
    shift = 1e3 * drawn.shift(matrix)[0, 1]
    closed = matrix.closed.T[:, drawn.plays]
    third, fourth = (
        float((np.broadcast_to(np.ravel(known.at(closed)), len(known.terms)) * shift[known.terms].prod(axis=1)).sum())
        for known in (drawn.with_plays.third, drawn.with_plays.fourth)
    )
    found = (matrix.closed[0, 0], 1e3 * matrix.bias[0, 4], (shift**2).sum(), third, fourth)
    assert found == pytest.approx(REFERENCE[load], abs=5e-5)


@pytest.mark.parametrize("load", REFERENCE)
def test_moments_of_samples_are_the_same(load):
    """The draws that the kernel reads have these moments, within four standard errors of a million samples; every robot is closed or open."""
    p, closed = sampled(loaded(load), 1_000_000)
    _, mean, variance, third, _ = REFERENCE[load]
    central = p - mean
    for power, expected in ((1, 0.0), (2, variance), (3, third)):
        assert (central**power).mean() == pytest.approx(expected, abs=4 * (central**power).std() / 1e3)
    sizes = np.abs(p[~closed])
    assert sizes.min(initial=np.inf) >= H * (1 - K * Normal().bound) + L - 1e-9
    assert sizes.max(initial=0.0) <= H * (1 + K * Normal().bound) + L + 1e-9


@pytest.mark.parametrize(("approach", "mean", "variance"), [(-1.0, 1.6, 0.04), (1.0, -1.0527, 0.8350)])
def test_with_a_known_approach_a_robot_repeats_and_robots_differ(approach, mean, variance):
    """At a load of 0.9 the play is closed towards the load, or else at the end behind the last motion: arriving downwards both are the same end."""
    matrix = screws(loaded(0.9), HERE, approach=approach)
    merged = matrix.merged
    assert {info.level for info in merged.infos} <= {"design", "robot"}
    drawn = sum(merged.squares[k, 0] for k, info in enumerate(merged.infos) if info.draws)
    assert (1e3 * matrix.bias[0, 4], 1e6 * drawn) == pytest.approx((mean, variance), abs=5e-5)


@pytest.mark.parametrize("load", [0.0, 0.9, 1.2, 2.0])
@pytest.mark.parametrize("approach", [0.0, 1.0, -1.0])
def test_monte_carlo_and_sums_over_terms_agree(load, approach):
    """Mean, mean square and quantiles of |p| by the kernel lie within its intervals of those without sampling."""
    arm = loaded(load)
    without = analytic(arm, HERE, approach=approach)
    found = run(arm, Poses(HERE, "given"), 4000, 8, 3, approach=approach).per_pose[0]
    assert found[0] == pytest.approx(without.mean[0], abs=2 * found[1])
    assert found[2] == pytest.approx(without.mean_square[0], rel=0.03)
    for k in range(3):
        value, low, high = found[6 + 3 * k : 9 + 3 * k]
        assert without.quantiles[0, k] == pytest.approx(value, abs=2 * (high - low) + 5e-6)


def test_an_unloaded_play_and_its_friction_loop_add_up():
    """Without a load the mean of |p| is 1.60 mm from above, from below and from either side: every visit ends at the end of both."""
    for approach in (0.0, 1.0, -1.0):
        assert analytic(loaded(0.0), HERE, approach=approach).mean[0] == pytest.approx(1.6e-3, rel=1e-5)


@pytest.mark.parametrize("load", [0.3, 0.6, 0.9, 1.0, 1.2, 1.4, 2.0])
@pytest.mark.parametrize("approach", [0.0, 1.0, -1.0])
def test_no_sample_lies_beyond_the_worst_case_and_some_come_near(load, approach):
    """The worst case holds for closed and open plays, and is the larger of the two: less than 5 % beyond the largest of many samples."""
    arm = loaded(load)
    largest = np.abs(sampled(arm, 200_000, approach=approach)[0]).max() * 1e-3
    matrix = screws(arm, HERE, approach=approach)
    bound = worst_case(matrix)[0]
    assert largest <= bound * (1 + 1e-12)
    assert root_sum_square(matrix)[0] <= bound * (1 + 1e-12)
    if load not in {0.3, 2.0} or approach == 0:
        assert bound <= max(largest * 1.05, 1e-3 * (H * (1 + K * Normal().bound) + L) * 1.0001)


def test_friction_without_scatter_is_a_step():
    """Where all robots have the same friction, there is no column of what differs between them, and the play is open below and closed above."""
    below, above = (screws(loaded(load, scatter=0.0), HERE) for load in (0.99, 1.01))
    assert all(info.closing is None for matrix in (below, above) for info in matrix.infos)
    assert not below.bias.any()
    assert 1e3 * above.bias[0, 4] == pytest.approx(H)


def test_one_robot_s_play_at_two_poses_is_closed_by_one_friction():
    """Two poses of different load: (b - c) of the same robots is correlated by (min(c1, c2) - c1 c2) / sqrt(c1 (1 - c1) c2 (1 - c2))."""
    joint = {"name": "A", "type": "revolute", "axis": "y", "limits": (-2, 2), "link": {"length": 1.0}}
    gearbox = {"backlash": 2e-3, "friction_torque": Friction(Toleranced(9.0, 4.5))}
    arm = Arm.model_validate({"name": "pitch", "joints": [joint | {"gearbox": gearbox}], "payload": {"mass": 1.0}})
    matrix = screws(arm, np.array([[0.0], [0.45]]))
    first, second = matrix.closed[0]
    assert 0.1 < second < first < 0.9
    robots, changed = np.arange(400_000), [k for k, info in enumerate(matrix.infos) if info.closing is not None and info.visit is None]
    z = np.array([draws_of(matrix, row, 1, row, robots, 0 * robots)[changed[0]] for row in (0, 1)])
    expected = (second - first * second) / np.sqrt(first * (1 - first) * second * (1 - second))
    assert np.corrcoef(z)[0, 1] == pytest.approx(expected, abs=5e-3)
    np.testing.assert_allclose((z.mean(axis=1), (z**2).mean(axis=1)), [[0, 0], [1, 1]], atol=0.01)


def test_a_controller_that_knows_the_mean_is_left_with_what_friction_changes():
    """Load compensation takes away the share of robots whose play is closed; mapping each robot also takes away whether it is closed in this one."""
    arm = loaded(0.9, amount=0.0)
    stages = waterfall(arm, Poses(HERE, "given"), 512, 4, 2).stages
    mean = dict(zip(STAGES, (1e3 * stage.mean.value for stage in stages), strict=True))
    c = float(screws(arm, HERE).closed[0, 0])
    ends = [(share / 2, b, s) for (share, b), s in itertools.product(((c, 1), (1 - c, 0)), (-1, 1))]
    assert mean["as manufactured"] == pytest.approx(sum(w * abs(H * (b + (1 - b) * s) + L * s) for w, b, s in ends), rel=0.03)
    assert mean["both"] == pytest.approx(sum(w * abs(H * (b - c + (1 - b) * s) + L * s) for w, b, s in ends), rel=0.03)
    assert mean["both, and each robot mapped"] == pytest.approx(sum(w * abs(H * (1 - b) * s + L * s) for w, b, s in ends), rel=0.03)


@pytest.mark.parametrize("arm", [*example_arms(), *random_arms(30)], ids=lambda arm: arm.name)
def test_every_play_of_a_robot_is_closed_or_open_and_nothing_between(arm):
    """Each term by itself, there or not by its robot's friction, adds up to the same errors as the columns of means and of what friction changes."""
    q, robots = random_poses(arm, 6), 40
    at = frames(arm, q)
    felt, matrix, joints = Conditions(arm, q, at), screws(arm, q), [joint.name for joint in arm.moving]
    robot, visit = (axis.ravel() for axis in np.meshgrid(np.arange(robots), np.arange(3), indexing="ij"))
    whole = np.zeros((len(q), 6, len(robot)))
    for of in arm.terms:
        term, condition = of.term, felt(of)
        moved = np.einsum("pij,jp->pi", carry(arm.tree, at, of.place), term.scale * term.form.screw(condition))
        for row in range(len(q)):
            size = np.ones(len(robot))
            if term.robot is not None:
                size = size * term.robot.law.quantile(uniforms(9, f"{of.owner}.{term.robot.stream}", robots))[robot]
            if term.visit is not None:
                owner = f"joints.{joints[of.joint]}" if term.sided else of.owner
                size = size * visit_draws(9, [Stream(f"{owner}.{term.visit.stream}", term.visit.law)], row, robot, visit)[0]
            friction = term.form.threshold
            if friction is not None:
                closed = uniforms(9, f"{of.owner}.{friction.stream}", robots)[robot] <= friction.share(condition)[row]
                size = size * (closed == term.form.above)
            whole[row] += moved[row][:, None] * size
    for row in range(len(q)):
        found = matrix.tool[row] @ draws_of(matrix, row, 9, row, robot, visit)
        np.testing.assert_allclose(found, whole[row], rtol=1e-9, atol=1e-11 * np.abs(whole[row]).max() + 1e-30)


def test_over_poses_of_any_load_quantiles_are_those_of_monte_carlo():
    """Poses at which all, some and none of the robots have a closed play, counted together: 95 % of errors below, by points and by the kernel."""
    joint = {"name": "A", "type": "revolute", "axis": "y", "limits": (-1.5, 1.5), "link": {"length": 1.0}}
    gearbox = {"backlash": "2 mrad ± 0.4 mrad", "hysteresis": "0.5 mrad", "friction_torque": Friction(Toleranced(6.0, 3.0))}
    arm = Arm.model_validate({"name": "pitch", "joints": [joint | {"gearbox": gearbox}], "payload": {"mass": 1.0}})
    poses = Poses(np.linspace(-1.5, 1.5, 64)[:, None], "given")
    some = screws(arm, poses.q).closed_in_some
    assert 0.2 < some.mean() < 0.9
    without = pooled(arm, poses, analytic(arm, poses))
    found = run(arm, poses, 4000, 4, 1)
    assert found.robot_means[0, :, 0].mean() == pytest.approx(without.mean.value, rel=5e-3)
    counts = found.group_hist.sum(axis=0)
    assert quantile(counts, 0.95) == pytest.approx(without.quantiles[1].value, rel=0.01)
