"""The analytic study, compared with Monte Carlo samples of the same terms."""

import dataclasses
import functools
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

import lostmotion
from lostmotion import sample_poses
from lostmotion.error_model.closing import standardised
from lostmotion.error_model.columns import Draws, grouped
from lostmotion.error_model.cumulants import cumulants
from lostmotion.error_model.draws import Stream
from lostmotion.error_model.expected_repeatability import expected_repeatability
from lostmotion.error_model.pose_matrix import PoseMatrix, pose_matrix
from lostmotion.errors import InputError
from lostmotion.laws.distributions import Cosine, Normal, Sine, TwoSided, Uniform
from lostmotion.laws.iso9283 import pose_repeatability
from lostmotion.propagation.analytic import DrawnColumns, analytic, of_screws
from lostmotion.propagation.pooled import pooled
from tests.arms import arm_of

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "covariance and fourth cumulants of the error, with harmonics and products",
        "samples of the same terms",
        "1 % of the variance; 0.03 of the excess",
        "propagation/analytic.py",
    ),
)

EXAMPLES = Path(__file__).parents[2] / "examples"
DRAWN = ("robot", "visit", "robot x visit")


def draws(matrix, count, pose=0, seed=1):
    """Sample every column at a pose from its distribution (column, sample); columns that name the
    same stream share its samples.
    """
    rng, known = np.random.default_rng(seed), {}

    @functools.lru_cache(maxsize=16)  # the columns of a joint follow each other
    def of(level, stream):
        key = level, stream.name
        if key not in known:
            known[key] = rng.random(count)
        return stream.law.quantile(known[key])

    out = np.ones((len(matrix.infos), count))
    for row, info in zip(out, matrix.infos, strict=True):
        if info.robot:
            row[:] *= of("robot", info.robot)
        if info.visit:
            row[:] *= of("visit", info.visit)
        if info.closing:
            row[:] *= standardised(
                of("closing", info.closing.stream), matrix.closed[info.closing.row, pose]
            )
    return out


def test_cumulants_are_the_samples(arm):
    """The analytic second to fourth moments of the error along any direction equal those of the
    samples.

    The terms include products of draws, harmonics that share a phase and sizes that terms share.
    """
    matrix = pose_matrix(arm, sample_poses(arm, 8).q[:2])
    drawn = DrawnColumns(matrix)
    found = of_screws(matrix, drawn)
    for p, shift in enumerate(drawn.shift(matrix)):
        closed = matrix.closed[:, [p]].T[:, drawn.plays]
        third, fourth = (
            np.ravel(known.at(closed))
            for known in (drawn.with_plays.third, drawn.with_plays.fourth)
        )
        error = matrix.tool[p, 3:] @ draws(matrix, 400_000, p) - found.bias[p][:, None]
        for h in np.vstack([np.eye(3), [[1, 2, -1], [-1, 1, 1]]]):
            part, along = h @ error, h @ shift
            variance = h @ found.covariance[p] @ h
            squares = np.square(part)
            second = squares.mean()
            assert part.var() == pytest.approx(variance, rel=0.01)
            excess = fourth @ along[drawn.with_plays.fourth.terms].prod(axis=1) / variance**2
            fourth_moment = squares @ squares / len(part)
            assert fourth_moment / second**2 - 3 == pytest.approx(excess, abs=0.03)
            skewness = third @ along[drawn.with_plays.third.terms].prod(axis=1) / variance**1.5
            third_moment = squares @ part / len(part)
            assert third_moment / second**1.5 == pytest.approx(skewness, abs=0.02)
        # Excess over all directions: k_iijj divided by the mean fourth power of the normal vector.
        squares = np.square(error).sum(axis=0)
        trace, square = np.trace(found.covariance[p]), np.sum(found.covariance[p] ** 2)
        assert found.excess[p] == pytest.approx(
            np.mean(squares**2) / (trace**2 + 2 * square) - 1, abs=0.02
        )


def test_only_a_scattered_play_and_its_side_have_a_third_cumulant(arm):
    """Only a scattered size x and a side s have a third cumulant, E[x s (x s)] = 1 in six orders,
    where all robots have the same closed plays.
    """
    matrix = pose_matrix(arm, sample_poses(arm, 8).q[:1])
    assert not matrix.closed_in_some.any()
    known = cumulants([info.draws for info in matrix.infos if info.closing is None])
    assert len(known.third.terms)
    for columns, value in zip(known.third.terms, known.third.values, strict=True):
        steady = [info for info in matrix.infos if info.closing is None]
        by_level = {steady[k].level: steady[k] for k in columns}
        both = by_level["robot x visit"]
        assert (both.robot, both.visit) == (by_level["robot"].robot, by_level["visit"].visit)
        assert value == pytest.approx(6.0, abs=1e-8)


def test_terms_of_one_harmonic_are_uncorrelated_but_not_independent(arm):
    """The sine and cosine of one phase have a joint fourth cumulant of -1/2 in six orders, and a
    joint's backlash and hysteresis form one error.
    """
    matrix = pose_matrix(arm, sample_poses(arm, 8).q[:1])
    known = cumulants([info.draws for info in matrix.infos])
    names = [info.name for info in matrix.infos]
    harmonic = tuple(
        k
        for k, name in enumerate(names)
        if name.startswith("joints.A.gearbox.transmission error 1")
    )
    joint = {
        tuple(four): value
        for four, value in zip(known.fourth.terms.tolist(), known.fourth.values, strict=True)
    }
    assert joint[harmonic[0], harmonic[0], harmonic[1], harmonic[1]] == pytest.approx(
        -0.5 * 6, abs=1e-9
    )
    assert joint[(harmonic[0],) * 4] == pytest.approx(-1.5, abs=1e-9)
    together = [{names[k] for k in members} for members in matrix.groups.values()]
    assert {"joints.A.gearbox.backlash", "joints.A.gearbox.hysteresis"} in together


def test_threads_change_no_bit():
    """One thread and three threads return identical bits per pose and pooled, and an array of joint
    values returns the same bits as its poses.
    """
    arm = lostmotion.read(EXAMPLES / "ur5e.urdf")
    poses = sample_poses(arm, 1024)
    one, three, given = (
        analytic(arm, q, threads=threads) for q, threads in ((poses, 1), (poses, 3), (poses.q, 2))
    )
    assert 0 < one.nearly_normal.mean() < 1
    for field in dataclasses.fields(one):
        for other in (three, given):
            assert np.array_equal(getattr(one, field.name), getattr(other, field.name)), field.name
    assert pooled(arm, poses, one, threads=1) == pooled(arm, poses, one, threads=3)


def test_progress_is_reported_in_poses(arm):
    """The analytic study reports the number of finished poses, and rejects zero poses and levels
    outside its range.
    """
    poses, reports = sample_poses(arm, 1024), []
    analytic(arm, poses, progress=lambda *report: reports.append(report))
    assert reports == [("summing up terms", 512, 1024), ("summing up terms", 1024, 1024)]
    with pytest.raises(InputError, match="at least one"):
        analytic(arm, poses.q[:0])
    with pytest.raises(ValueError, match=r"from 0\.25 to 0\.9995"):
        analytic(arm, poses.q[:1], levels=(0.99999,))


FEW = {
    "one harmonic": ("harmonic", 1, "1 N m/arcmin"),
    "three harmonics": ("harmonic", 3, "5 N m/arcmin"),
    "one uniform error": ("uniform", 1, "1 N m/arcmin"),
    "two sides, two joints": ("two-sided", 2, "5 N m/arcmin"),
    "two sides, five joints, soft": ("two-sided", 5, "1 N m/arcmin"),
    "two sides, five joints": ("two-sided", 5, "20 N m/arcmin"),
}


@pytest.mark.parametrize("case", FEW)
def test_few_errors_beside_a_large_bias_lie_within_their_uncertainty(case):
    """Each quantile of an arm that sags more than it scatters lies within its uncertainty of the
    samples and below the worst case.

    One to five errors far from normal scatter about a large bias. A few two-sided errors have a
    stepped distribution of the magnitude.
    """
    law, count, stiffness = FEW[case]
    gearbox = {"ratio": 100, "rated_torque": "60 N m", "stiffness": stiffness} | (
        {"transmission_error": "1 arcmin"} if law == "harmonic" else {}
    )
    own = {} if law == "harmonic" else {"lumped": {"angle": "1 arcmin", "law": law}}
    joint = {
        "type": "revolute",
        "axis": "y",
        "limits": (-1.5, 1.5),
        "link": {"length": "400 mm"},
        "gearbox": gearbox,
        **own,
    }
    sagging = lostmotion.Arm.model_validate(
        {
            "name": "sagging",
            "joints": [{"name": name, **joint} for name in "ABCDE"[:count]],
            "payload": {"mass": "5 kg"},
        }
    )
    q = np.random.default_rng(1).uniform(-1.5, 1.5, (12, count))
    matrix, samples = pose_matrix(sagging, q), 200_000
    drawn = draws(matrix, samples)
    found = analytic(sagging, q)
    scatter = np.sqrt(np.trace(found.covariance, axis1=1, axis2=2))
    for p in range(len(q)):
        lengths = np.sort(np.linalg.norm(matrix.tool[p, 3:] @ drawn, axis=0))
        for n, level in enumerate(found.levels):
            spread = 4 * np.sqrt(level * (1 - level) / samples)
            low, high = (
                lengths[int((level - spread) * samples)],
                lengths[min(int((level + spread) * samples), samples - 1)],
            )
            # The theory page states up to 9 % of the scatter at 99.7 % beside a large bias.
            own, off = (
                found.quantiles[p, n],
                max(found.quantiles_uncertainty[p, n], 0.02 * scatter[p]),
            )
            assert low - off <= own <= high + off, (p, level)
            assert own <= found.worst[p] * (1 + 1e-6), (p, level)


def test_quantiles_rise_with_their_level_and_stay_below_the_worst_case(arm):
    """Analytic quantiles rise with their level and stay below the worst case, and mean square and
    worst case equal those of sampling.
    """
    poses = sample_poses(arm, 64)
    found, sampled = analytic(arm, poses), lostmotion.study(arm, poses, robots=50, visits=2).sampled
    assert found.mean_square.mean() == pytest.approx(
        sampled.tally.total / sampled.tally.poses, rel=1e-9
    )
    assert np.array_equal(found.worst, sampled.worst)
    assert np.array_equal(found.rss, sampled.rss)
    assert (np.diff(found.quantiles, axis=1) > 0).all()
    assert (found.quantiles[:, -1] <= found.worst).all()
    assert found.mean**2 + found.deviation**2 == pytest.approx(found.mean_square, rel=2e-4)


def test_few_plays_alone_are_exact():
    """An arm with two two-sided errors alone has four error magnitudes, whose mean and quantiles
    the analytic study finds.
    """
    arm = arm_of(
        2,
        gearbox=None,
        bearing=None,
        encoder=None,
        mounting=None,
        link={"length": 0.4},
        lumped={"angle": "3 arcmin", "law": "two-sided"},
    )
    poses = sample_poses(arm, 64)
    found = analytic(arm, poses)
    drawn = np.array([[1.0, 1.0, -1.0, -1.0], [1.0, -1.0, 1.0, -1.0]])
    matrix = pose_matrix(arm, poses.q)
    kinds = matrix.columns(*DRAWN)
    lengths = np.linalg.norm(
        matrix.bias[:, 3:, None] + matrix.tool[:, 3:][:, :, kinds] @ drawn, axis=1
    )
    assert not found.nearly_normal.any()
    assert found.mean == pytest.approx(lengths.mean(axis=1), rel=1e-5)
    assert found.quantiles[:, 1:] == pytest.approx(
        np.tile(lengths.max(axis=1)[:, None], 3), rel=1e-3
    )
    assert (found.quantiles_uncertainty[:, 1:] <= 1e-3 * found.quantiles[:, 1:]).all()


def test_a_joint_with_backlash_and_hysteresis_alone_has_every_figure():
    """The figures of one joint with a scattered backlash and a two-sided hysteresis equal those of
    a million samples, at each pose and pooled.
    """
    gearbox = {"ratio": 100, "backlash": "1 arcmin ± 0.3 arcmin", "hysteresis": "0.2 arcmin"}
    link = {"length": "1000 mm ± 50 µm"}
    joint = {
        "name": "A",
        "type": "revolute",
        "axis": "z",
        "limits": ("-90 deg", "90 deg"),
        "gearbox": gearbox,
        "link": link,
    }
    arm = lostmotion.Arm.model_validate({"name": "one", "joints": [joint]})
    poses = sample_poses(arm, 16)
    found = analytic(arm, poses)
    matrix = pose_matrix(arm, poses.q)
    drawn, whole = draws(matrix, 1_000_000), pooled(arm, poses, found)
    for p in (0, 7, 15):
        lengths = np.linalg.norm(matrix.tool[p, 3:] @ drawn, axis=0)
        exact = np.r_[lengths.mean(), np.quantile(lengths, found.levels)]
        assert np.r_[found.mean[p], found.quantiles[p]] == pytest.approx(exact, rel=5e-3)
        assert found.deviation[p] == pytest.approx(lengths.std(), rel=5e-3)
        # The joint's error does not depend on its angle.
        assert np.array(
            [whole.mean.value, *(one.value for one in whole.quantiles)]
        ) == pytest.approx(exact, rel=5e-3)
        assert whole.deviation.value == pytest.approx(lengths.std(), rel=5e-3)


PLAY, FLAT, SLIGHT = TwoSided(), Uniform(), Normal()
DOMINANT = {
    "a play": ([((1, 0, 0), None, ("side", PLAY))], (0, 0, 0)),
    "a play about a bias": ([((1, 0, 0), None, ("side", PLAY))], (0.5, 0.3, 0)),
    "three plays": (
        [
            ((1, 0.2, 0), None, ("a", PLAY)),
            ((0, 0.8, 0.3), None, ("b", PLAY)),
            ((0.5, -0.4, 0.6), None, ("c", PLAY)),
        ],
        (0.1, 0, 0),
    ),
    "a play beside a normal error of its size": (
        [((1, 0, 0), None, ("side", PLAY)), ((0, 1, 0), ("n", SLIGHT), None)],
        (0, 0, 0),
    ),
    "a uniform error": ([((1, 0, 0), ("u", FLAT), None)], (0.3, 0.4, 0)),
    "a harmonic in a plane": (
        [((1, 0, 0), ("w", Cosine()), None), ((0, 0.7, 0), ("w", Sine()), None)],
        (0, 0, 0),
    ),
    "a size times a side": (
        [
            ((0.3, 0, 0), ("a", SLIGHT), None),
            ((1, 0, 0), None, ("side", PLAY)),
            ((0.3, 0, 0), ("a", SLIGHT), ("side", PLAY)),
        ],
        (1, 0.5, 0),
    ),
}


def screws_of(terms, bias):
    """Return the pose matrix of one pose at which these draws displace the tool point."""
    infos, columns = [Draws(None, None, None)], [np.array(bias, float)]
    for shift, robot, visit in terms:
        streams = [None if stream is None else Stream(*stream) for stream in (robot, visit)]
        infos.append(Draws(*streams, None))
        columns.append(np.array(shift, float))
    tool = np.zeros((1, 6, len(infos)))
    tool[0, 3:] = np.array(columns).T
    return PoseMatrix(
        tuple(infos),
        tool,
        grouped(infos),
        np.zeros(len(infos), int),
        np.ones(len(infos)),
        tool,
        np.zeros((0, 1)),
        None,  # the state of no arm
        None,
    )


def test_a_pooled_median_in_a_gap_of_the_distribution_has_no_value():
    """Two two-sided errors about one axis make two error magnitudes, and the pooled median between
    them has no value.
    """
    joint = {
        "name": "A",
        "type": "revolute",
        "axis": "z",
        "limits": (-1, 1),
        "link": {"length": "1 m"},
    }
    twice = [
        joint | {"lumped": {"angle": f"{angle} arcmin", "law": "two-sided"}} for angle in (3, 1)
    ]
    twice[0]["link"], twice[1]["name"] = {"length": 0.0}, "B"
    arm = lostmotion.Arm.model_validate({"name": "two plays", "joints": twice})
    poses = sample_poses(arm, 64)
    found = analytic(arm, poses)
    whole = pooled(arm, poses, found)
    assert not found.valid.any()
    assert np.isnan(whole.quantiles[0].value)
    assert whole.quantiles[1].value == pytest.approx(np.pi / 10800 * 4, rel=2e-3)
    assert whole.mean.value == pytest.approx(np.pi / 10800 * 3, rel=1e-4)
    assert whole.deviation.value == pytest.approx(np.pi / 10800, rel=1e-4)


@pytest.mark.parametrize("case", DOMINANT)
def test_dominant_draws_lie_within_their_uncertainty(case):
    """Beside normal noise every figure lies within 1.5 times its uncertainty, or 0.5 %, of a
    million samples.
    """
    terms, bias = DOMINANT[case]
    noise = [(0.06 * np.eye(3)[k % 3], (f"noise {k}", SLIGHT), None) for k in range(6)]
    matrix = screws_of([*terms, *noise], bias)
    found = of_screws(matrix, DrawnColumns(matrix))
    lengths = np.linalg.norm(matrix.tool[0, 3:] @ draws(matrix, 1_000_000), axis=0)
    exact = np.r_[lengths.mean(), lengths.std(), np.quantile(lengths, found.levels)]
    own = np.r_[found.mean, found.deviation, found.quantiles[0]]
    off = np.r_[found.mean_uncertainty, found.deviation_uncertainty, found.quantiles_uncertainty[0]]
    assert (np.abs(own - exact) <= np.maximum(1.5 * off, 5e-3 * exact)).all()
    assert own[0] == pytest.approx(exact[0], rel=2e-3)


def test_pooled_analytic_figures_agree_with_monte_carlo(arm):
    """The pooled Monte Carlo mean and percentiles agree with the analytic ones to 1 % and lie in
    their intervals.
    """
    poses = sample_poses(arm, 256)
    study = lostmotion.study(arm, poses, robots=2000, visits=5, method="both")
    rows = {
        row["label"]: row["figures"][0]
        for section in study.result()["sections"]
        if section["key"] == "error"
        for row in section["rows"]
    }
    for label, own in zip(
        ("mean", "50th percentile", "95th percentile", "99th percentile"),
        (study.pooled.mean, *study.pooled.quantiles),
        strict=False,
    ):
        value = rows[label]["value"]
        assert own.value == pytest.approx(value, rel=0.01), label
        assert own.low < value < own.high, label
    difference = next(
        section for section in study.result()["sections"] if section["key"] == "routes"
    )
    assert all(row["figures"][0]["value"] < 1 for row in difference["rows"])


def test_the_interval_of_a_mean_over_all_poses_is_students_over_eight_sets(arm):
    """The half-width of the pooled mean is the root sum square of its uncertainty per pose and
    Student's half-width with seven degrees of freedom.
    """
    poses = sample_poses(arm, 64)
    found = analytic(arm, poses)
    mean = pooled(arm, poses, found).mean
    of_sets = found.mean.reshape(8, 8).mean(axis=1)
    half = np.hypot(found.mean_uncertainty.mean(), stats.t(7).ppf(0.975) * stats.sem(of_sets))
    assert (mean.low, mean.high) == pytest.approx(
        (of_sets.mean() - half, of_sets.mean() + half), rel=1e-9
    )


def test_an_unknown_method_is_rejected(arm):
    """A study rejects an unknown method and lists the valid ones."""
    with pytest.raises(InputError, match="montecarlo, analytic, both"):
        lostmotion.study(arm, 8, method="magic")


@pytest.mark.parametrize(("rank", "limit"), [(3, 3.61609), (2, 3.21872), (1, 2.60632)])
def test_repeatability_of_a_round_scatter_tends_to_its_constant(rank, limit):
    """Expected RP of isotropic scatter is a known multiple of its standard deviation per axis in
    three, two and one dimensions.
    """
    covariance = 4.0 * np.diag(np.arange(3) < rank).astype(float)[None]
    assert expected_repeatability(covariance)[0][0] / 2 == pytest.approx(limit, abs=2e-5)


@pytest.mark.parametrize("shape", [(1.0, 1.0, 1.0), (1.0, 0.3, 0.1), (1.0, 0.0, 0.0)])
def test_repeatability_of_thirty_visits_is_lower_and_varies(shape):
    """The expected RP of 30 visits equals the mean of 100 000 sampled sets within 0.2 %, and its
    standard deviation theirs within 3 %.

    Isotropic scatter of unit standard deviation has 3.537 and 0.329.
    """
    visits = np.random.default_rng(3).standard_normal((100_000, 30, 3)) * np.sqrt(shape)
    sampled = pose_repeatability(visits)
    mean, deviation = (value[0] for value in expected_repeatability(np.diag(shape)[None], 30))
    assert mean == pytest.approx(sampled.mean(), rel=2e-3)
    assert deviation == pytest.approx(sampled.std(), rel=0.03)
    if min(shape) == 1:
        assert mean == pytest.approx(3.537, abs=2e-3)
        assert deviation == pytest.approx(0.329, abs=2e-3)
