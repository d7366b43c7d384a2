"""Sobol indices by SALib from draws alone, compared with the exact shares and with the gain from
halving a part.
"""

import numpy as np
import pytest
from SALib.analyze import sobol as sobol_analyze
from SALib.sample import sobol as sobol_sample

from lostmotion import sample_poses
from lostmotion.error_model.budget import Tally, costs
from lostmotion.error_model.pose_matrix import screws
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.montecarlo.sensitivity import halving
from tests.arms import arm_of

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "shares of the error budget",
        "Sobol indices by SALib at one pose",
        "0.02",
        "error_model/budget.py",
    ),
)


def problem_of(infos):
    """Return SALib's problem: one uniform variable per stream, grouped by part, since each part
    draws from its own streams.
    """
    streams = dict.fromkeys(
        (stream.name, info.owner)
        for info in infos
        for stream in (info.robot, info.visit)
        if stream is not None
    )
    names = [name for name, _ in streams]
    assert len(set(names)) == len(names)  # no stream is shared by two parts
    owners = [owner for _, owner in streams]
    return {
        "num_vars": len(names),
        "names": names,
        "groups": owners,
        "bounds": [[1e-12, 1 - 1e-12]] * len(names),
    }


def draws_of(infos, names, uniforms):
    """Return the factor of each term (sample, term) from uniforms (sample, stream): the inverse of
    its distribution, or a product over two levels.
    """
    out = np.ones((len(uniforms), len(infos)))
    for k, info in enumerate(infos):
        for stream in (info.robot, info.visit):
            if stream is not None:
                out[:, k] *= stream.law.quantile(uniforms[:, names.index(stream.name)])
    return out


def test_indices_of_each_component_are_the_exact_variance_shares(arm):
    """At one pose the first-order and total Sobol indices of a part equal its share of the variance
    of e_x, e_y and e_z.

    Weighted by the variances of the components, the indices equal the part's share of the drawn
    mean square in the budget.
    """
    matrix = screws(state_of(arm, np.array([[0.4, -0.3, 0.9]])))
    problem = problem_of(matrix.infos)
    uniforms = sobol_sample.sample(problem, 2048, calc_second_order=False, seed=1)
    shift = matrix.tool[0, 3:]
    errors = draws_of(matrix.infos, problem["names"], uniforms) @ shift.T
    owners = list(dict.fromkeys(problem["groups"]))
    squares = np.zeros((len(owners), 3))
    for members in (members for draws, members in matrix.groups.items() if draws):
        (owner,) = {matrix.infos[k].owner for k in members}
        squares[owners.index(owner)] += shift[:, members].sum(axis=1) ** 2
    weighted = np.zeros(len(owners))
    for axis in range(3):
        exact = squares[:, axis] / squares[:, axis].sum()
        found = sobol_analyze.analyze(
            problem, errors[:, axis], calc_second_order=False, num_resamples=10, seed=1
        )
        np.testing.assert_allclose(found["S1"], exact, atol=0.02)
        np.testing.assert_allclose(found["ST"], exact, atol=0.02)
        assert sum(found["S1"]) == pytest.approx(1, abs=0.02)
        weighted += found["S1"] * squares[:, axis].sum()
    levels = {cost.part: sum(cost.levels[1:]) for cost in costs(Tally.of(matrix))}
    of_drawn = np.array([levels[owner] for owner in owners]) / sum(levels.values())
    np.testing.assert_allclose(weighted / squares.sum(), of_drawn, atol=0.02)


def test_sobol_indices_of_the_squared_error_are_not_the_shares(arm):
    """The first-order indices of |e|^2 of an arm without bias do not add to one, because the parts
    interact.

    A part's share is its part of the mean of |e|^2; its index is its part of the variance of |e|^2.
    """
    matrix = screws(state_of(arm, np.array([[0.4, -0.3, 0.9]])))
    problem = problem_of(matrix.infos)
    uniforms = sobol_sample.sample(problem, 2048, calc_second_order=False, seed=1)
    drawn = np.array([info.level != "design" for info in matrix.infos])
    errors = (
        draws_of(matrix.infos, problem["names"], uniforms)[:, drawn] @ matrix.tool[0, 3:, drawn]
    )
    found = sobol_analyze.analyze(
        problem, (errors**2).sum(axis=1), calc_second_order=False, num_resamples=10, seed=1
    )
    assert sum(found["S1"]) < 0.9
    assert (found["ST"] >= found["S1"] - 0.05).all()


def test_total_indices_of_the_95_percent_error_rank_parts_as_halving_does():
    """Total indices of each robot's 95th percentile rank the parts in the order of their gains from
    halving.

    The errors of this arm vary per robot, without bias. For other arms variance over robots and
    gain in the percentile are different quantities.
    """
    bare = {"gearbox": None, "bearing": None, "mounting": None, "link": {"length": "400 mm"}}
    sizes = {"O": "0.6 arcmin", "A": "1 arcmin", "B": "4 arcmin"}
    arm = arm_of(3, **bare, encoder={"zero": "1 arcmin"})
    joints = tuple(
        joint.model_copy(
            update={
                "encoder": arm_of(
                    1, **bare, encoder={"zero": sizes[joint.name], "noise": "0.1 arcmin"}
                )
                .joints[0]
                .encoder
            }
        )
        for joint in arm.joints
    )
    arm = arm.model_copy(update={"joints": joints, "gravity": 0.0})
    poses = sample_poses(arm, 64)
    matrix = screws(state_of(arm, poses.q))
    robot, visit = (matrix.columns(level) for level in ("robot", "visit"))
    infos = [matrix.infos[k] for k in robot]
    problem = problem_of(infos)
    uniforms = sobol_sample.sample(problem, 512, calc_second_order=False, seed=1)
    fixed = np.einsum(
        "pct,rt->rpc", matrix.tool[:, 3:, robot], draws_of(infos, problem["names"], uniforms)
    )
    rng = np.random.default_rng(1)
    sides = np.stack(
        [matrix.infos[k].visit.law.quantile(rng.uniform(size=(len(poses), 4))) for k in visit],
        axis=-1,
    )
    moved = np.einsum("pct,pvt->pvc", matrix.tool[:, 3:, visit], sides)
    q95 = np.quantile(
        np.linalg.norm(fixed[:, :, None] + moved, axis=-1).reshape(len(fixed), -1), 0.95, axis=1
    )
    found = sobol_analyze.analyze(problem, q95, calc_second_order=False, num_resamples=10, seed=1)
    totals = dict(zip(dict.fromkeys(problem["groups"]), found["ST"], strict=True))
    gains = {
        part: gain.value
        for part, gain in halving(arm, poses, 128, 4, 1).gains.items()
        if part in totals
    }
    assert sorted(totals, key=totals.__getitem__) == sorted(gains, key=gains.__getitem__)
    assert max(totals, key=totals.__getitem__) == "joints.B.encoder"
