"""Lengths by points of Sobol sequences over the draws, against closed forms and samples."""

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import quad

import lostmotion
from lostmotion.error_model.draws import Stream
from lostmotion.error_model.pose_matrix import TermInfo
from lostmotion.laws.distributions import Cosine, Normal, Sine, TwoSided, Uniform
from lostmotion.propagation.analytic.analytic import analytic, of_screws
from lostmotion.propagation.analytic.points import EACH, SETS, by_points, points_of
from lostmotion.propagation.analytic.pooled import pooled
from lostmotion.propagation.analytic.smoothened import smooth_draws, smoothen

LEVELS = np.array([0.5, 0.95, 0.99, 0.997])
ENDLESS = Normal(np.inf)
NOISE = [(np.eye(3)[k], f"noise {k}", ENDLESS) for k in range(3)]
CASES = {
    "a flat draw": ([((0.6, 0, 0.8), "u", Uniform())], lambda share: share * np.sqrt(3)),
    "a play in round noise": ([((0, 1.5, 0), "side", TwoSided()), *NOISE], lambda share: np.sqrt(stats.ncx2.ppf(share, 3, 1.5**2))),
    "a round wave": ([((1, 0, 0), "w", Cosine()), ((0, 1, 0), "w", Sine())], lambda share: np.sqrt(2) + 0 * share),
    "three flat draws on a line": (
        [((1, 0, 0), f"{k}", Uniform()) for k in range(3)],
        lambda share: (stats.irwinhall(3).ppf((1 + share) / 2) - 1.5) * 2 * np.sqrt(3),
    ),
}


@pytest.mark.parametrize("each", EACH)
@pytest.mark.parametrize("name", CASES)
def test_lengths_by_points_are_the_closed_forms(name, each):
    """Mean and quantiles within their bounds, which shrink with more points; the law read back says the levels."""
    terms, quantile = CASES[name]
    infos = [TermInfo(f"{k}", "", "robot", 4.0, Stream(stream, law), None) for k, (_, stream, law) in enumerate(terms)]
    drawn = points_of(infos, np.arange(len(infos)), each)
    assert drawn.shape == (len(infos), SETS * each)
    values, bounds, law = by_points(drawn, np.zeros((1, 3)), np.array([shift for shift, *_ in terms], float).T[None], LEVELS)
    exact = np.r_[quad(quantile, 0, 1, limit=200)[0], quantile(LEVELS)]
    assert (np.abs(values[0] - exact) <= bounds[0] + 1e-9).all()
    assert (bounds[0, :3] <= (0.04 if each == EACH[0] else 0.01) * exact[:3]).all()
    if name != "a round wave":  # of one length
        shares, densities = law.share(np.zeros(1, int), exact[None, 1:])
        assert (np.abs(shares[0] - LEVELS) <= law.missed[0]).all()
        assert (densities > 0).all()


@pytest.mark.parametrize("name", [name for name in CASES if name != "a round wave"])
def test_quantiles_with_one_draw_summed_over_are_the_closed_forms(name):
    """Within bounds less than half as wide as by counting points; what is not wanted stays."""
    terms, quantile = CASES[name]
    infos = [TermInfo(f"{k}", "", "robot", 4.0, Stream(stream, law), None) for k, (_, stream, law) in enumerate(terms)]
    every, exact = np.arange(len(infos)), quantile(LEVELS)
    drawn, shift = points_of(infos, every, EACH[0]), np.array([shift for shift, *_ in terms], float).T[None]
    values, bounds, _ = by_points(drawn, np.zeros((1, 3)), shift, LEVELS)
    counted, vague = values[:, 1:].copy(), bounds[:, 1:].copy()
    values, bounds = found = counted.copy(), vague.copy()
    smoothen(found, np.array([[True, True, True, False]]), drawn, np.zeros((1, 3)), shift, LEVELS, smooth_draws(infos, every))
    assert (np.abs(values - exact) <= bounds + 1e-9).all()
    assert (bounds[0, :3] < 0.5 * vague[0, :3]).all()
    assert (values[0, 3], bounds[0, 3]) == (counted[0, 3], vague[0, 3])


def test_a_draw_that_does_not_move_the_tool_betters_nothing():
    """Where the one draw without steps has no lever, figures stay as they were counted."""
    drawn = np.random.default_rng(1).standard_normal((2, SETS * 64))
    shift, every = np.array([[[1.0, 0], [0, 0], [0, 0]]]), np.ones((1, 4), bool)
    values, bounds = found = np.array([[0.7, 1.9, 2.5, 2.9]]), np.full((1, 4), 0.06)
    smoothen(found, every, drawn, np.zeros((1, 3)), shift, LEVELS, {1: ENDLESS})
    assert (values.tolist(), bounds.tolist()) == ([[0.7, 1.9, 2.5, 2.9]], [[0.06] * 4])


def test_only_draws_without_steps_that_one_term_takes_are_summed_over():
    """No play, no wave, no product, nothing that two terms share."""
    flat, play = Uniform(), TwoSided()
    robots = [("a", flat), ("b", play), ("c", ENDLESS), ("c", ENDLESS), ("d", flat), ("w", Cosine())]
    infos = [TermInfo(f"{k}", "", "robot", 4.0, Stream(*robot), Stream("side", play) if robot[0] == "d" else None) for k, robot in enumerate(robots)]
    assert smooth_draws(infos, np.arange(6)) == {0: flat}
    assert smooth_draws(infos, np.array([1, 2])) == {1: ENDLESS}


def test_an_arm_of_two_joints_with_plays_has_every_figure():
    """Whose farthest errors are too rare to count; against two million samples."""
    gearbox = {"ratio": 100, "stiffness": "5 N m/arcmin", "backlash": "1 arcmin"}
    joints = [
        {"name": name, "type": "revolute", "axis": "z", "limits": limits, "gearbox": gearbox, "link": {"length": f"{length} mm ± 0.1 mm"}}
        for name, limits, length in (("a", ("-90 deg", "90 deg"), 300), ("b", ("0 deg", "150 deg"), 200))
    ]
    arm = lostmotion.Arm.model_validate({"name": "planar", "payload": {"mass": "1 kg"}, "joints": joints})
    bends = np.radians(np.linspace(2.0, 148.0, 24))
    matrix = lostmotion.screws(arm, np.column_stack([0 * bends, bends]))
    found, rng = of_screws(matrix), np.random.default_rng(1)
    assert found.normal.all()
    assert (found.quantiles_bound <= 0.02 * found.quantiles).all()
    columns = matrix.columns("robot", "visit", "robot x visit")
    streams = [matrix.infos[k].robot or matrix.infos[k].visit for k in columns]
    drawn = np.stack([stream.law.quantile(rng.random(2_000_000)) for stream in streams])
    for p in (0, 8, 16, 23):
        exact = np.quantile(np.linalg.norm(matrix.tool[p, 3:][:, columns] @ drawn + matrix.bias[p, 3:, None], axis=0), found.levels)
        assert (np.abs(found.quantiles[p] - exact) <= found.quantiles_bound[p] + 2e-3 * exact).all()


def test_a_joint_that_errs_by_play_and_friction_alone_has_every_figure():
    """One joint, a play whose amount scatters and a friction of two sides: neither parts nor lattice tell all; against a million samples."""
    gearbox = {"ratio": 100, "backlash": "1 arcmin ± 0.3 arcmin", "hysteresis": "0.2 arcmin"}
    link = {"length": "1000 mm ± 50 µm"}
    joint = {"name": "A", "type": "revolute", "axis": "z", "limits": ("-90 deg", "90 deg"), "gearbox": gearbox, "link": link}
    arm = lostmotion.Arm.model_validate({"name": "one", "joints": [joint]})
    poses = lostmotion.sample_poses(arm, 16)
    found = analytic(arm, poses)
    assert found.normal.all()
    assert found.points.all()
    matrix, rng = lostmotion.screws(arm, poses.q), np.random.default_rng(1)
    drawn, known = np.ones((len(matrix.infos), 1_000_000)), {}
    for row, info in zip(drawn, matrix.infos, strict=True):
        for level, stream in (("robot", info.robot), ("visit", info.visit)):
            if stream is not None:
                np.multiply(row, stream.law.quantile(known.setdefault((level, stream.name), rng.random(1_000_000))), out=row)
    whole = pooled(found, poses.replicates)
    for p in (0, 7, 15):
        lengths = np.linalg.norm(matrix.tool[p, 3:] @ drawn, axis=0)
        exact = np.r_[lengths.mean(), np.quantile(lengths, found.levels)]
        told, bounds = np.r_[found.mean[p], found.quantiles[p]], np.r_[found.mean_bound[p], found.quantiles_bound[p]]
        assert (np.abs(told - exact) <= bounds + 2e-3 * exact).all()
        # The joint errs alike wherever it stands.
        assert np.array([whole.mean.value, *(one.value for one in whole.quantiles)]) == pytest.approx(exact, rel=5e-3)
