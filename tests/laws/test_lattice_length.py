"""Lengths of sums of draws by the characteristic function on a lattice, against closed forms."""

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import quad

from lostmotion.error_model.cumulants import cumulants
from lostmotion.error_model.draws import Stream
from lostmotion.error_model.pose_matrix import TermInfo
from lostmotion.laws.distributions import Amount, Cosine, Normal, Sine, TwoSided, Uniform, gauss_rule
from lostmotion.laws.lattice_length import Vectors, lattice_length
from lostmotion.laws.normal_length import normal_length
from lostmotion.propagation.analytic.sums import sums
from lostmotion.propagation.analytic.values import values_of

LEVELS = np.array([0.5, 0.95, 0.99, 0.997])
ENDLESS = Normal(np.inf)


def told(terms, bias=(0.0, 0.0, 0.0)):
    """Give mean and quantiles (1 + level,) of the sum of these (shift, stream, law) about a bias, without any guess, and their bounds."""
    infos = tuple(TermInfo(f"{k}", "", "robot", 4.0, Stream(stream, law), None) for k, (_, stream, law) in enumerate(terms))
    shift = np.array([shift for shift, *_ in terms], float).T[None]
    columns = np.arange(len(infos))
    whole = sums(np.ascontiguousarray(shift.transpose(1, 2, 0)), cumulants(infos, columns), np.array([bias], float))
    wanted = np.ones((1, 1 + len(LEVELS)), bool)
    found = lattice_length(
        lambda fine: values_of(infos, columns, fine), Vectors(shift, *whole.arrays), LEVELS, np.full((1, len(LEVELS)), np.nan), wanted, 1e-3
    )
    return found.values[0], found.bounds[0]


def searchable_figures(quantile):
    """Give mean and quantiles (1 + level,) of the law with these quantiles."""
    return np.r_[quad(quantile, 0, 1, limit=200)[0], quantile(LEVELS)]


def round_noise(size):
    """Give a normal draw of this deviation along each axis."""
    return [(size * np.eye(3)[k], f"noise {k}", ENDLESS) for k in range(3)]


@pytest.mark.parametrize("play", [0.5, 1.0, 1.5])
def test_a_play_in_round_noise_is_noncentral_chi_square(play):
    """|(+-a, 0, 0) + N(0, 1)|^2 has three degrees of freedom and a^2, whichever side."""
    value, bound = told([((0.6 * play, 0, 0.8 * play), "side", TwoSided()), *round_noise(1.0)])
    exact = searchable_figures(lambda share: np.sqrt(stats.ncx2.ppf(share, 3, play**2)))
    assert (np.abs(value - exact) <= bound).all()
    assert (bound <= 0.01 * exact).all()


@pytest.mark.parametrize("wave", [0.7, 2.0])
def test_a_round_wave_in_round_noise_is_noncentral_chi_square(wave):
    """Sine and cosine of one phase, equally large and at right angles: the same, with the amplitude 2^(1/2) times each."""
    value, bound = told([((wave, 0, 0), "w", Cosine()), ((0, wave, 0), "w", Sine()), *round_noise(1.0)])
    exact = searchable_figures(lambda share: np.sqrt(stats.ncx2.ppf(share, 3, 2 * wave**2)))
    assert (np.abs(value - exact) <= bound).all()
    assert (bound <= 0.01 * exact).all()


@pytest.mark.parametrize("bias", [0.0, 3.0])
def test_normal_draws_need_no_correction(bias):
    """A flat normal vector about a bias along its long axis, against the lengths' own law: noncentral in one dimension."""
    value, bound = told([((1, 0, 0), "n", ENDLESS)], (bias, 0, 0))
    exact = searchable_figures(stats.foldnorm(bias).ppf)
    assert value == pytest.approx(exact, rel=2e-5)
    assert (np.abs(value - exact) <= bound).all()


@pytest.mark.parametrize("count", [3, 5, 9])
def test_uniforms_on_a_line_are_irwin_and_halls(count):
    """Few flat draws along one slanted line: |sum| against the exact law, far from normal at three."""
    line = np.array([2.0, -1.0, 2.0]) / 3
    value, bound = told([(line, f"{k}", Uniform()) for k in range(count)])
    exact = searchable_figures(lambda share: (stats.irwinhall(count).ppf((1 + share) / 2) - count / 2) * 2 * np.sqrt(3))
    known = np.isfinite(bound)
    assert known[:4].all()
    assert value[0] == pytest.approx(exact[0], rel=1e-3)
    assert (np.abs(value - exact) <= bound)[known].all()


@pytest.mark.parametrize(("play", "noise"), [(0.8, 0.6), (1.0, 0.7), (1.0, 0.8)])
def test_where_edgeworths_shares_pass_one_the_correction_still_fits(play, noise):
    """Two plays at right angles in noise that is wider along one: by symmetry as long as a normal vector on one side of both.

    At 99.7 % the nearly normal vector's share is above 1, and the correction takes it back.
    """
    terms = [((play, 0, 0), "a", TwoSided()), ((0, play, 0), "b", TwoSided()), ((noise, 0, 0), "wider", ENDLESS), *round_noise(noise / 2)]
    value, bound = told(terms)
    one = normal_length(np.array([[play, play, 0]]), np.diag([1.25, 0.25, 0.25])[None] * noise**2, LEVELS)
    exact = np.r_[one.mean, one.quantiles[0]]
    assert value == pytest.approx(exact, rel=3e-3)
    assert (np.abs(value - exact) <= bound).all()


def test_an_amount_times_its_side_is_told_within_its_bound():
    """Skew and two-sided: k x + (1 + k x) S on a line beside noise, by quadrature over x."""
    k, noise = 0.3, 0.5
    scale = np.hypot(1, k)
    infos = (
        TermInfo("amount", "", "robot", 4.0, Stream("a", ENDLESS), None),
        TermInfo("play", "", "robot x visit", 4.0, Stream("a", Amount(k, ENDLESS)), Stream("s", TwoSided())),
        TermInfo("noise", "", "robot", 4.0, Stream("n", ENDLESS), None),
    )
    shift = np.zeros((1, 3, 3))
    shift[0, 0] = k, scale, noise
    whole = sums(np.ascontiguousarray(shift.transpose(1, 2, 0)), cumulants(infos, np.arange(3)), np.zeros((1, 3)))
    found = lattice_length(
        lambda fine: values_of(infos, np.arange(3), fine), Vectors(shift, *whole.arrays), LEVELS, np.full((1, 4), np.nan), np.ones((1, 5), bool), 1e-3
    )
    value, bound = found.values, found.bounds
    nodes, weights = np.polynomial.hermite_e.hermegauss(80)
    weights = weights / weights.sum()
    means = [stats.foldnorm.mean(abs(k * nodes + side * (1 + k * nodes)) / noise) * noise for side in (-1, 1)]
    assert abs(value[0, 0] - 0.5 * weights @ (means[0] + means[1])) <= min(bound[0, 0], 1e-3 * value[0, 0])
    for n, level in enumerate(LEVELS, start=1):
        if np.isfinite(bound[0, n]):
            lows, highs = (value[0, n] + sign * bound[0, n] for sign in (-1, 1))
            below = []
            for r in (lows, highs):
                ends = [stats.norm.cdf((end - k * nodes - side * (1 + k * nodes)) / noise) for side in (-1, 1) for end in (r, -r)]
                below.append(0.5 * weights @ (ends[0] - ends[1] + ends[2] - ends[3]))
            assert below[0] <= level <= below[1]
    assert np.isfinite(bound[0]).sum() >= 4


def test_draws_that_never_let_the_characteristic_function_fall_are_not_told():
    """Two plays and nothing else: four lengths, each a step; no quantile is claimed to better than a step."""
    value, bound = told([((1, 0, 0), "a", TwoSided()), ((0.3, 0.5, 0), "b", TwoSided())])
    assert not (bound <= 0.02 * value).any()


def test_gauss_rules_are_the_known_ones():
    """A flat law's is Legendre's, a normal law's Hermite's; a two-sided one's has its two values; cut ones keep their moments."""
    for law, (nodes, weights) in ((Uniform(), np.polynomial.legendre.leggauss(8)), (ENDLESS, np.polynomial.hermite_e.hermegauss(8))):
        own, shares = gauss_rule(law, 8)
        assert own == pytest.approx(nodes * (np.sqrt(3) if isinstance(law, Uniform) else 1), abs=1e-6)
        assert shares == pytest.approx(weights / weights.sum(), abs=1e-7)
    assert gauss_rule(TwoSided(), 2)[0] == pytest.approx([-1, 1])
    own, shares = gauss_rule(Normal(), 12)
    assert shares @ own**2 == pytest.approx(1, abs=1e-9)
    assert shares @ own**4 == pytest.approx(3 + Normal().excess, abs=1e-8)


def test_what_does_not_vary_or_is_no_number_is_not_told():
    """No covariance, or a bias that is no number: NaN, and no error."""
    draws = values_of((TermInfo("a", "", "robot", 4.0, Stream("a", Uniform()), None),), np.arange(1), 8)
    nothing, wanted = np.full((2, 4), np.nan), np.ones((2, 5), bool)
    vectors = Vectors(np.ones((2, 3, 1)), np.array([[1.0, 0, 0], [np.nan, 0, 0]]), np.stack([np.zeros((3, 3)), np.eye(3)]), *np.zeros((2, 2, 1)))
    found = lattice_length(lambda _: draws, vectors, LEVELS, nothing, wanted, 0.02)
    assert np.isnan(found.values).all()
    assert np.isnan(found.bounds).all()
    assert not found.lengths
