"""The study without sampling, against samples of the same terms."""

import dataclasses

import numpy as np
import pytest
from scipy import stats

import lostmotion
from lostmotion import pose_repeatability, sample_poses, screws
from lostmotion.analyses.iso9283.expected_repeatability import expected_repeatability
from lostmotion.error_model.cumulants import cumulants
from lostmotion.error_model.draws import Stream
from lostmotion.error_model.pose_matrix import Screws, TermInfo
from lostmotion.errors import InputError
from lostmotion.laws.distributions import Amount, Cosine, Normal, Sine, TwoSided, Uniform
from lostmotion.laws.normal_length import WORST, normal_length
from lostmotion.laws.normal_length_forms_kernel import FOURTHS, THIRDS
from lostmotion.propagation.analytic import analytic as route
from lostmotion.propagation.analytic.analytic import analytic, of_screws
from lostmotion.propagation.analytic.pooled import pooled
from tests.conftest import arm_of

DRAWN = ("robot", "visit", "robot x visit")


def draws(infos, count, seed=1):
    """Draw every term afresh by its laws, streams of one name together: (term, sample)."""
    rng, known = np.random.default_rng(seed), {}

    def of(level, stream):
        return stream.law.quantile(known.setdefault((level, stream.name), rng.random(count)))

    out = np.ones((len(infos), count))
    for row, info in zip(out, infos, strict=True):
        if info.robot:
            row[:] *= of("robot", info.robot)
        if info.visit:
            row[:] *= of("visit", info.visit)
    return out


def test_cumulants_are_the_samples(arm):
    """Products, shared waves and shared amounts included: second to fourth moments of the error along any direction agree with samples."""
    matrix = screws(arm, sample_poses(arm, 8).q[:3])
    found, drawn = of_screws(matrix), draws(matrix.infos, 400_000)
    for p in range(3):
        error = matrix.tool[p, 3:] @ drawn - found.bias[p][:, None]
        for h in np.vstack([np.eye(3), [[1, 2, -1], [-1, 1, 1]]]):
            part = h @ error
            variance = h @ found.covariance[p] @ h
            assert part.var() == pytest.approx(variance, rel=0.01)
            powers = np.array([h[0] ** i * h[1] ** j * h[2] ** k for i, j, k in FOURTHS])
            excess = found.fourth[p] @ powers / variance**2
            assert np.mean(part**4) / np.mean(part**2) ** 2 - 3 == pytest.approx(excess, abs=0.03)
            skewness = found.third[p] @ [h[0] ** i * h[1] ** j * h[2] ** k for i, j, k in THIRDS] / variance**1.5
            assert np.mean(part**3) / np.mean(part**2) ** 1.5 == pytest.approx(skewness, abs=0.02)


def test_only_an_amount_with_its_play_has_third_cumulants(arm):
    """E[x A A] S S of an amount A = 1 + k x (over its root mean square) and a side S: 2 k / (1 + k^2), in three orders; nothing else is skew."""
    matrix = screws(arm, sample_poses(arm, 8).q[:1])
    known = cumulants(matrix.infos, matrix.columns(*DRAWN))
    assert len(known.threes)
    for (first, second, third), value in zip(known.threes, known.three_values, strict=True):
        amount, play, again = (matrix.infos[k] for k in (first, second, third))
        scatter = play.robot.law.scatter
        assert play is again
        assert amount.robot.law == play.robot.law.inner
        assert value == pytest.approx(3 * 2 * scatter / (1 + scatter**2), abs=1e-8)


def test_third_cumulants_move_the_quantiles_the_right_way():
    """A biased skew vector: gamma draws along x, against SciPy's law."""
    shape, bias = 60.0, 4.0  # a gamma law of shape 60, shifted to mean zero and scaled to variance one
    law, k3, k4 = stats.gamma(shape, loc=-np.sqrt(shape), scale=1 / np.sqrt(shape)), 2 / np.sqrt(shape), 6 / shape
    third, fourth = np.zeros((1, 10)), np.zeros((1, 15))
    third[0, THIRDS.index((3, 0, 0))], fourth[0, FOURTHS.index((4, 0, 0))] = k3, k4
    levels = (0.5, 0.95, 0.99)
    at, scatter = np.array([[bias, 0, 0]]), np.diag([1.0, 0, 0])[None]
    with_it, without = (normal_length(at, scatter, levels, fourth, third=one) for one in (third, None))
    exact = bias + law.ppf(levels)
    assert with_it.mean[0] == pytest.approx(bias, abs=2e-4)
    assert (np.abs(with_it.quantiles[0] - exact) <= with_it.quantiles_left[0]).all()
    assert np.abs(with_it.quantiles[0] - exact).max() < 0.2 * np.abs(without.quantiles[0] - exact).max()


def test_terms_of_one_wave_are_uncorrelated_but_not_independent(arm):
    """Sine and cosine of one phase have a joint fourth cumulant of -1/2, six times over; nothing else joins different streams."""
    matrix = screws(arm, sample_poses(arm, 8).q[:1])
    known = cumulants(matrix.infos, matrix.columns(*DRAWN))
    names = [info.name for info in matrix.infos]
    wave = tuple(k for k, name in enumerate(names) if name.startswith("joints.A.gearbox.transmission error 1"))
    joint = {tuple(four): value for four, value in zip(known.fours.tolist(), known.four_values, strict=True)}
    assert joint[wave[0], wave[0], wave[1], wave[1]] == pytest.approx(-0.5 * 6, abs=1e-9)
    assert joint[(wave[0],) * 4] == pytest.approx(-1.5, abs=1e-9)
    assert all(i == j for i, j in known.pairs.tolist())


def test_threads_change_no_bit(arm, monkeypatch):
    """One thread or three, any block: the same bits."""
    poses = sample_poses(arm, 64)
    monkeypatch.setattr(route, "BLOCK", 16)
    monkeypatch.setattr(route, "MOST_LEFT_OUT", 5e-3)  # so that the lattice is asked
    one, three = (analytic(arm, poses, threads=threads) for threads in (1, 3))
    assert one.lattice.any()
    monkeypatch.setattr(route, "BLOCK", 24)
    other = analytic(arm, poses)
    assert np.array_equal(one.quantiles, other.quantiles, equal_nan=True)
    assert np.array_equal(one.quantiles_bound, other.quantiles_bound, equal_nan=True)
    for field in dataclasses.fields(one):
        if field.name not in {"parts", "laws"}:
            assert np.array_equal(getattr(one, field.name), getattr(three, field.name), equal_nan=field.name != "normal"), field.name


def test_quick_figures_lie_within_their_bounds_of_the_sure_ones(arm):
    """Edgeworth's terms alone, at once: no pose is cut, asked of the lattice or of points; what is told holds its bound, the rest is not told."""
    poses = sample_poses(arm, 128)
    quick, sure = analytic(arm, poses, quick=True), analytic(arm, poses)
    assert not quick.laws
    assert len(quick.parts[1].weights) == len(poses)
    assert sure.laws or len(sure.parts[1].weights) > len(poses)
    figures, bounds = (np.column_stack([getattr(quick, f"mean{what}"), getattr(quick, f"quantiles{what}")]) for what in ("", "_bound"))
    others, left = (np.column_stack([getattr(sure, f"mean{what}"), getattr(sure, f"quantiles{what}")]) for what in ("", "_bound"))
    both = np.isfinite(figures) & np.isfinite(others)
    assert (np.abs(figures - others) <= bounds + left)[both].all()
    assert (bounds <= route.FAR_FROM_NORMAL * figures)[np.isfinite(figures)].all()
    assert both.mean() > 0.9
    assert ((bounds > route.MOST_LEFT_OUT * figures) & both).any()
    for name in ("covariance", "third", "fourth", "bias", "worst", "rss", "excess"):
        assert np.array_equal(getattr(quick, name), getattr(sure, name)), name


FEW = {
    "one wave": ("wave", 1, "1 N m/arcmin"),
    "three waves": ("wave", 3, "5 N m/arcmin"),
    "one flat error": ("uniform", 1, "1 N m/arcmin"),
    "two sides, two joints": ("two-sided", 2, "5 N m/arcmin"),
    "two sides, five joints, soft": ("two-sided", 5, "1 N m/arcmin"),
    "two sides, five joints": ("two-sided", 5, "20 N m/arcmin"),
}


@pytest.mark.parametrize("case", FEW)
def test_few_errors_beside_a_large_bias_are_told_within_their_bound(case):
    """An arm that sags far more than it scatters, by one to five errors far from normal: a bound that is small beside the length must be right too.

    Lengths of a few errors of two sides stand in steps, and no figure lies between them, nor beyond the worst case.
    """
    law, count, stiffness = FEW[case]
    gearbox = {"ratio": 100, "rated_torque": "60 N m", "stiffness": stiffness} | ({"transmission_error": "1 arcmin"} if law == "wave" else {})
    own = {} if law == "wave" else {"lumped": {"angle": "1 arcmin", "law": law}}
    joint = {"type": "revolute", "axis": "y", "limits": (-1.5, 1.5), "link": {"length": "400 mm"}, "gearbox": gearbox, **own}
    sagging = lostmotion.Arm.model_validate(
        {"name": "sagging", "joints": [{"name": name, **joint} for name in "ABCDE"[:count]], "payload": {"mass": "5 kg"}}
    )
    q = np.random.default_rng(1).uniform(-1.5, 1.5, (12, count))
    matrix, samples = screws(sagging, q), 200_000
    drawn = draws(matrix.infos, samples)
    quick, sure = analytic(sagging, q, quick=True), analytic(sagging, q)
    assert np.isfinite(sure.quantiles).mean() > 0.7
    for p in range(len(q)):
        lengths = np.sort(np.linalg.norm(matrix.tool[p, 3:] @ drawn, axis=0))
        for n, level in enumerate(sure.levels):
            spread = 4 * np.sqrt(level * (1 - level) / samples)
            low, high = lengths[int((level - spread) * samples)], lengths[min(int((level + spread) * samples), samples - 1)]
            for found in (quick, sure):
                own, bound = found.quantiles[p, n], found.quantiles_bound[p, n]
                assert np.isnan(own) or low - bound <= own <= high + bound, (p, level)
                assert np.isnan(own) or own <= found.worst[p] * (1 + WORST), (p, level)


def test_quick_figures_know_no_blocks_and_no_threads(arm, monkeypatch):
    """Any number of threads, any block, an array in place of poses: the same bits."""
    poses = sample_poses(arm, 64)
    one = analytic(arm, poses.q, quick=True)
    three = analytic(arm, poses, quick=True, threads=3)
    monkeypatch.setattr(route, "QUICK_BLOCK", 10)
    told = []
    other = analytic(arm, poses, quick=True, progress=lambda *heard: told.append(heard))
    for field in dataclasses.fields(one):
        if field.name not in {"parts", "laws"}:
            for more in (three, other):
                assert np.array_equal(getattr(one, field.name), getattr(more, field.name), equal_nan=field.name != "normal"), field.name
    assert told[-1] == ("summing up terms", 64, 64)
    with pytest.raises(InputError, match="at least one"):
        analytic(arm, poses.q[:0], quick=True)


def test_quick_figures_of_a_play_alone_are_not_told():
    """An error that is far from normal has no quick figure, but the bounds that need none."""
    lumped = {"angle": "1 arcmin", "law": "two-sided"}
    joint = {"name": "A", "type": "revolute", "axis": "z", "limits": (-1, 1), "lumped": lumped, "link": {"tip": {"xyz": (0.3, 0.0, 0.0)}}}
    found = analytic(lostmotion.Arm.model_validate({"name": "one play", "joints": [joint]}), np.zeros((1, 1)), quick=True)
    assert np.isnan(found.mean).all()
    assert np.isnan(found.quantiles).all()
    assert not found.normal.any()
    assert found.worst == pytest.approx(0.3 * np.pi / 10800)
    assert found.mean_square == pytest.approx((0.3 * np.pi / 10800) ** 2)


def test_mean_square_bounds_and_order(arm):
    """The mean square is the tally's; figures rise with their level and lie below the worst case, whose bound is root-sum-square's too."""
    poses = sample_poses(arm, 64)
    found, sampled = analytic(arm, poses), lostmotion.study(arm, poses, robots=50, visits=2).sampled
    assert found.mean_square.mean() == pytest.approx(sampled.tally.total / sampled.tally.poses, rel=1e-9)
    assert np.array_equal(found.worst, sampled.worst)
    assert np.array_equal(found.rss, sampled.rss)
    told = np.isfinite(found.quantiles).all(axis=1)
    assert told.mean() > 0.5
    assert (np.diff(found.quantiles[told], axis=1) > 0).all()
    assert (found.quantiles[told, -1] <= found.worst[told]).all()
    assert (found.mean[told] ** 2 <= found.mean_square[told]).all()


def test_few_plays_alone_are_told(monkeypatch):
    """An arm that errs by two two-sided draws alone: exact where a level falls inside one of four lengths, by parts and by points."""
    arm = arm_of(2, gearbox=None, bearing=None, encoder=None, mounting=None, link={"length": 0.4}, lumped={"angle": "3 arcmin", "law": "two-sided"})
    poses = sample_poses(arm, 64)
    found = analytic(arm, poses)
    drawn = np.array([[1.0, 1.0, -1.0, -1.0], [1.0, -1.0, 1.0, -1.0]])
    matrix = screws(arm, poses.q)
    kinds = matrix.columns(*DRAWN)
    lengths = np.linalg.norm(matrix.bias[:, 3:, None] + matrix.tool[:, 3:][:, :, kinds] @ drawn, axis=1)
    assert found.mean == pytest.approx(lengths.mean(axis=1), rel=1e-6)
    assert found.quantiles[:, 1] == pytest.approx(lengths.max(axis=1), rel=1e-4)
    monkeypatch.setattr(route, "PARTS", ())
    bare = analytic(arm, poses)
    assert bare.points.all()
    assert bare.mean == pytest.approx(lengths.mean(axis=1), rel=1e-6)
    assert bare.quantiles[:, 1:] == pytest.approx(np.tile(lengths.max(axis=1)[:, None], 3), rel=1e-6)
    assert np.isfinite(bare.worst).all()


PLAY, FLAT, SLIGHT, AMOUNT = TwoSided(), Uniform(), Normal(), Amount(0.3, Normal())
DOMINANT = {
    "a play": ([((1, 0, 0), None, ("side", PLAY))], (0, 0, 0)),
    "a play about a bias": ([((1, 0, 0), None, ("side", PLAY))], (0.5, 0.3, 0)),
    "three plays": ([((1, 0.2, 0), None, ("a", PLAY)), ((0, 0.8, 0.3), None, ("b", PLAY)), ((0.5, -0.4, 0.6), None, ("c", PLAY))], (0.1, 0, 0)),
    "a play beside a normal error of its size": ([((1, 0, 0), None, ("side", PLAY)), ((0, 1, 0), ("n", SLIGHT), None)], (0, 0, 0)),
    "a flat error": ([((1, 0, 0), ("u", FLAT), None)], (0.3, 0.4, 0)),
    "a wave in a plane": ([((1, 0, 0), ("w", Cosine()), None), ((0, 0.7, 0), ("w", Sine()), None)], (0, 0, 0)),
    "an amount times a side": ([((0.3, 0, 0), ("a", SLIGHT), None), ((1, 0, 0), ("a", AMOUNT), ("side", PLAY))], (1, 0.5, 0)),
}


def screws_of(terms, bias):
    """Give one pose at which these draws displace the tool point."""
    infos, columns = [TermInfo("design", "", "design", 1.0, None, None)], [np.array(bias, float)]
    for k, (shift, robot, visit) in enumerate(terms):
        streams = [None if stream is None else Stream(*stream) for stream in (robot, visit)]
        level = "robot x visit" if all(streams) else "robot" if robot else "visit"
        infos.append(TermInfo(f"{k}", "", level, 4.0, *streams))
        columns.append(np.array(shift, float))
    tool = np.zeros((1, 6, len(infos)))
    tool[0, 3:] = np.array(columns).T
    return Screws(tuple(infos), np.zeros(len(infos), int), tool, tool, np.zeros((1, 1, 4, 4)), (0,))


def test_points_tell_no_length_in_a_gap(monkeypatch):
    """Two plays and nothing else, four lengths that are two: half of the errors are the shorter, half the longer, and their median is neither."""
    monkeypatch.setattr(route, "PARTS", ())
    found = of_screws(screws_of([((1, 0, 0), None, ("a", PLAY)), ((0.3, 0.5, 0), None, ("b", PLAY))], (0, 0, 0)))
    short, long = np.hypot(0.7, 0.5), np.hypot(1.3, 0.5)
    assert found.points.all()
    assert np.isnan(found.quantiles[0, 0])
    assert found.quantiles[0, 1:] == pytest.approx([long] * 3, rel=1e-9)
    assert found.mean[0] == pytest.approx((short + long) / 2, rel=1e-9)
    assert np.isnan(pooled(found).quantiles[0].value)


@pytest.mark.parametrize("case", DOMINANT)
def test_dominant_draws_are_told_within_their_bound(case):
    """Beside a tenth of normal noise: every figure that is told lies within its bound of a million samples, the mean always is, and most are."""
    terms, bias = DOMINANT[case]
    noise = [(0.06 * np.eye(3)[k % 3], (f"noise {k}", SLIGHT), None) for k in range(6)]
    matrix = screws_of([*terms, *noise], bias)
    found = of_screws(matrix)
    count = 1_000_000
    lengths = np.linalg.norm(matrix.tool[0, 3:] @ draws(matrix.infos, count), axis=0)
    told = 0
    for level, own, bound in zip(
        (None, *found.levels), (found.mean[0], *found.quantiles[0]), (found.mean_bound[0], *found.quantiles_bound[0]), strict=True
    ):
        if level is None:
            value, off = lengths.mean(), lengths.std() / np.sqrt(count)
        else:
            share = np.sqrt(level * (1 - level) / count)
            low, value, high = np.quantile(lengths, (level - share, level, level + share))
            off = (high - low) / 2
        told += not np.isnan(own)
        assert np.isnan(own) or abs(own - value) <= bound + 4 * off, level
    assert not np.isnan(found.mean[0])
    assert told >= (1 if "of its size" in case else 2)


def test_pooled_figures_are_monte_carlos(arm):
    """Mean and quantiles over all poses lie in both routes' intervals, of the same poses."""
    poses = sample_poses(arm, 256)
    study = lostmotion.study(arm, poses, robots=2000, visits=5, method="both")
    rows = {row["label"]: row["figures"][0] for section in study.result()["sections"] if section["key"] == "error" for row in section["rows"]}
    for label, own in zip(("mean", "50 % below", "95 % below", "99 % below"), (study.pooled.mean, *study.pooled.quantiles), strict=False):
        value = rows[label]["value"] * (1e-6 if rows[label]["unit"] == "µm" else 1e-3)
        assert own.value == pytest.approx(value, rel=0.01), label
        assert own.low < value < own.high, label
    apart = next(section for section in study.result()["sections"] if section["key"] == "routes")
    assert all(row["figures"][0]["value"] < 1 for row in apart["rows"])


def test_the_front_door_refuses_an_unknown_method(arm):
    """A method that does not exist is named, with those that do."""
    with pytest.raises(InputError, match="montecarlo, analytic, both"):
        lostmotion.study(arm, 8, method="magic")


@pytest.mark.parametrize(("rank", "limit"), [(3, 3.61609), (2, 3.21872), (1, 2.60632)])
def test_repeatability_of_a_round_scatter_tends_to_its_constant(rank, limit):
    """RP in units of the deviation per axis, in three, two and one dimensions."""
    covariance = 4.0 * np.diag(np.arange(3) < rank).astype(float)[None]
    assert expected_repeatability(covariance)[0][0] / 2 == pytest.approx(limit, abs=2e-5)


@pytest.mark.parametrize("shape", [(1.0, 1.0, 1.0), (1.0, 0.3, 0.1), (1.0, 0.0, 0.0)])
def test_repeatability_of_thirty_visits_is_lower_and_varies(shape):
    """Against 100 000 sets of 30 visits: mean within 0.2 %, deviation within 3 %; round scatter 3.537 and 0.329."""
    visits = np.random.default_rng(3).standard_normal((100_000, 30, 3)) * np.sqrt(shape)
    sampled = pose_repeatability(visits)
    mean, deviation = (value[0] for value in expected_repeatability(np.diag(shape)[None], 30))
    assert mean == pytest.approx(sampled.mean(), rel=2e-3)
    assert deviation == pytest.approx(sampled.std(), rel=0.03)
    if min(shape) == 1:
        assert mean == pytest.approx(3.537, abs=2e-3)
        assert deviation == pytest.approx(0.329, abs=2e-3)
