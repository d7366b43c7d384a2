"""Distributions that users state, without limits or as a table, compared with closed forms by Monte
Carlo and the analytic study.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy import stats

import lostmotion
from lostmotion.error_model.bounds import bounds, worst_case
from lostmotion.error_model.draws import robot_draws, sobol
from lostmotion.error_model.pose_matrix import screws
from lostmotion.laws.distributions import Normal, Table, product_mean
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.state import state_of
from lostmotion.parts.joint import PrismaticJoint, RevoluteJoint
from lostmotion.units import Toleranced

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "distributions without limits, users' tables",
        "JCGM 101:2008, 9.2.2; the Maxwell distribution; Sobol points",
        "within the intervals",
        "error_model/intervals.py",
    ),
    (
        "standard deviation of the error",
        "NumPy over all samples; the Maxwell distribution; 400 synthetic studies",
        "1e-6; within the intervals; 92 to 98.5 %",
        "tests/error_model/test_intervals.py",
    ),
)

# Mean and mean square of a skewed table, relative to the stated size, by hand from its pieces.
SKEWED = ((-1.0, 0.0), (-0.2, 0.3), (0.4, 0.9), (2.0, 1.0))
MEAN_OF_SKEWED = 0.3 * -0.6 + 0.6 * 0.1 + 0.1 * 1.2
SQUARE_OF_SKEWED = (
    0.3 * (1 + 0.2 + 0.04) + 0.6 * (0.04 - 0.08 + 0.16) + 0.1 * (0.16 + 0.8 + 4)
) / 3
WITHOUT_LIMITS = "normal without limits"


def slides(axes: str, **encoder: Any) -> Arm:
    """Return slides along these axes, each with encoder noise of ±3 mm, so that a normal
    distribution without limits has sigma = 1 mm.
    """
    joints = [
        PrismaticJoint(name=f"J{k}", axis=axis, limits=(0, 1), encoder={"noise": 3e-3, **encoder})
        for k, axis in enumerate(axes)
    ]
    return Arm(name="slides", joints=joints)


def middle(arm: Arm) -> np.ndarray:
    """Return one pose with all joints in the middle of their ranges."""
    return arm.limits.mean(axis=1)[None]


def both(arm: Arm, robots: int = 4000, visits: int = 50) -> Any:
    """Return a study of one pose by Monte Carlo and the analytic method."""
    return lostmotion.study(arm, middle(arm), robots=robots, visits=visits, seed=2, method="both")


def row(study: Any, section: str, label: str) -> Any:
    """Return one printed figure in mm."""
    found = next(
        row
        for each in study.sheet.sections
        if each.key == section
        for row in each.rows
        if row.label == label
    )
    figure = found.cells[0]
    assert figure.unit == "m"
    return replace(figure, value=1e3 * figure.value, low=1e3 * figure.low, high=1e3 * figure.high)


def within(figure: Any, truth: float) -> bool:
    """Return whether a figure's interval, extended by half of its width at each end, contains the
    true value.
    """
    spare = 0.5 * (figure.high - figure.low)
    return figure.low - spare <= truth <= figure.high + spare


@pytest.mark.parametrize("visits", [50, 1])
def test_four_standard_normal_inputs_have_the_published_interval(visits: int):
    """The sum of four N(0, 1) has u = 2.0 and a 95 % interval of ±3.92 (JCGM 101:2008, 9.2.2);
    truncation at three sigma lowers it by 1.3 %.
    """
    whole, cut = (
        both(slides("xxxx", noise_law=law), robots=4000 if visits > 1 else 200_000, visits=visits)
        for law in (WITHOUT_LIMITS, "normal")
    )
    for section in ("error", "analytic"):
        assert within(row(whole, section, "95th percentile"), 3.92)
        # 4 000 robots have a sampling error of 0.4 %
        assert row(cut, section, "95th percentile").value == pytest.approx(0.987 * 3.92, rel=6e-3)
        assert row(cut, section, "95th percentile").value == pytest.approx(
            3.92 * 3 / Normal().bound, rel=0.006
        )
    assert whole.sampled.per_pose[0, 2] ** 0.5 == pytest.approx(2.0e-3, rel=0.005)
    assert whole.analytic.mean_square[0] ** 0.5 == pytest.approx(2.0e-3, rel=1e-9)


def test_the_magnitude_of_an_isotropic_normal_vector_is_maxwells():
    """The magnitude of three equal normal errors at right angles has the mean, quantiles and
    standard deviation of the Maxwell distribution.
    """
    study, maxwell = both(slides("xyz", noise_law=WITHOUT_LIMITS)), stats.maxwell()
    for section in ("error", "analytic"):
        assert within(row(study, section, "mean"), maxwell.mean())
        for level in (0.5, 0.95, 0.99):
            assert within(
                row(study, section, f"{100 * level:.4g}th percentile"), maxwell.ppf(level)
            )
        assert within(row(study, section, "standard deviation"), maxwell.std())
    assert maxwell.std() == pytest.approx(math.sqrt(3 - 8 / math.pi))


def test_the_standard_deviation_is_that_of_all_samples():
    """The printed standard deviation equals NumPy's over all robots and poses, and result.json and
    arrays.nc contain it.
    """
    joints = [
        RevoluteJoint(
            name=name, axis=axis, limits=(-1, 1), lumped={"angle": 1e-3, "varies": "robot"}
        )
        for name, axis in (("A", "z"), ("B", "y"))
    ]
    arm = Arm(name="two", joints=joints, tool={"frame": {"xyz": (0.3, 0.1, 0.2)}})
    study = lostmotion.study(arm, 16, robots=200, visits=2, seed=4)
    matrix = screws(state_of(arm, study.poses.q))
    draws = (
        robot_draws(4, [info.robot for info in matrix.infos], 200)
        .transpose(1, 0, 2)
        .reshape(len(matrix.infos), -1)[:, :200]
    )
    lengths = np.linalg.norm(matrix.tool[:, 3:] @ draws, axis=1)
    entry = next(
        r
        for s in study.result()["sections"]
        if s["key"] == "error"
        for r in s["rows"]
        if r["label"] == "standard deviation"
    )
    (figure,) = entry["figures"]
    assert figure["value"] == pytest.approx(lengths.std(), rel=1e-6)
    assert figure["interval"][0] < figure["value"] < figure["interval"][1]
    np.testing.assert_allclose(
        study.arrays()["error_standard_deviation"], lengths.std(axis=1), rtol=1e-6
    )


@pytest.mark.parametrize(("law", "third"), [(SKEWED, True), (((-1, 0), (0, 0.5), (1, 1)), False)])
def test_draws_of_a_table_have_mean_zero_and_variance_one(
    law: tuple[tuple[float, float], ...],
    third: bool,  # noqa: FBT001
):
    """Draws of a table have mean zero and variance one, since the mean of the table is a design
    term.
    """
    table = Table(tuple((float(value), float(probability)) for value, probability in law))
    u = (np.arange(1_000_000) + 0.5) / 1_000_000
    draws = table.quantile(u)
    assert draws.mean() == pytest.approx(0, abs=1e-6)
    assert (draws**2).mean() == pytest.approx(1, rel=1e-5)
    assert product_mean((table,) * 4) == pytest.approx((draws**4).mean(), abs=1e-4)
    assert bool(abs((draws**3).mean()) > 0.1) is third
    assert np.abs(draws).max() <= table.bound
    if third:
        assert table.mean == pytest.approx(MEAN_OF_SKEWED)
        assert table.stated == pytest.approx(1 / math.sqrt(SQUARE_OF_SKEWED - MEAN_OF_SKEWED**2))


def test_a_two_row_table_is_the_uniform_distribution():
    """A table of two rows has the standard deviation and the worst case of the uniform
    distribution.
    """
    table, word = (
        screws(state_of(slides("x", noise_law=law), np.array([[0.5]])))
        for law in (((-1, 0), (1, 1)), "uniform")
    )
    np.testing.assert_allclose(table.tool[..., -1], word.tool[..., -1], rtol=1e-12)
    np.testing.assert_allclose(worst_case(table), worst_case(word), rtol=1e-12)


@pytest.mark.parametrize("axes", ["xxxx", "xyz"])
def test_errors_of_a_skewed_table_agree_with_sobol_points(axes: str):
    """Mean and percentiles of errors from a skewed table agree with a million Sobol points, by
    Monte Carlo and the analytic study.
    """
    study = both(slides(axes, noise_law=SKEWED))
    values, probabilities = np.array(SKEWED).T
    draws = 3 * np.interp(sobol(5, "truth", len(axes)).points(20).T, probabilities, values)
    length = np.abs(draws.sum(axis=0)) if axes == "xxxx" else np.sqrt((draws**2).sum(axis=0))
    truth = {
        "mean": length.mean(),
        **{f"{100 * level:.4g}th percentile": np.quantile(length, level) for level in (0.5, 0.95)},
    }
    for label, value in truth.items():
        for section in ("error", "analytic"):
            assert within(row(study, section, label), value), (section, label)


def test_the_mean_of_a_table_displaces_every_robot_equally():
    """The non-zero mean of a table displaces every visit of every robot equally, for a lumped
    angle, an encoder, a length and a base tilt.
    """
    turning = RevoluteJoint(
        name="A",
        limits=(-1, 1),
        lumped={"angle": 1e-3, "law": SKEWED},
        encoder={"noise": 2e-3, "noise_law": SKEWED, "side": "output"},
        link={"length": Toleranced(0.5, 1e-4, SKEWED)},
    )
    arm = Arm(name="one", joints=[turning], base={"roll": Toleranced(0.0, 1e-3, SKEWED)})
    bias = screws(state_of(arm, np.zeros((1, 1)))).bias[0]
    assert bias[2] == pytest.approx(3e-3 * MEAN_OF_SKEWED)
    assert bias[3] == pytest.approx(1e-4 * MEAN_OF_SKEWED)
    assert bias[0] == pytest.approx(1e-3 * MEAN_OF_SKEWED)


def test_an_error_without_limits_has_no_worst_case():
    """An error without limits that moves the tool has no worst case, which every sheet states; one
    without a lever arm does not change it.
    """
    arm = slides("xyz", noise_law=WITHOUT_LIMITS)
    matrix = screws(state_of(arm, middle(arm)))
    assert np.isinf(worst_case(matrix)).all()
    assert bounds(matrix).root_sum_square == pytest.approx(math.sqrt(3) * 3e-3)
    study = both(arm, robots=20, visits=2)
    for section in ("error", "analytic"):
        found = next(
            row
            for each in study.sheet.sections
            if each.key == section
            for row in each.rows
            if row.label == "worst case, worst pose"
        )
        assert found.note.startswith("no worst case: normal without limits (J0.encoder.noise, ")
    entry = next(
        r
        for s in study.result()["sections"]
        if s["key"] == "error"
        for r in s["rows"]
        if r["label"] == "worst case, worst pose"
    )
    assert entry["figures"][0]["value"] is None
    # A rotation about an axis through the tool point does not move it.
    still = Arm(
        name="still",
        joints=[
            RevoluteJoint(
                name="A",
                limits=(-1, 1),
                lumped={"angle": 1e-3, "law": WITHOUT_LIMITS, "offset": 1e-5},
            )
        ],
    )
    assert worst_case(screws(state_of(still, np.zeros((1, 1))))) == pytest.approx(3e-5)


def test_a_target_is_sized_where_an_error_has_no_limits():
    """For one normal error without limits, the allowed noise has its 1.96 sigma at the target of
    the 95th percentile.
    """
    arm = slides("x", noise_law=WITHOUT_LIMITS)
    found = lostmotion.target(arm, error=1e-3, poses=8, robots=400)
    (noise,) = [each for each in found.allowances if each.item.cause == "noise"]
    assert noise.factor.value * 3e-3 == pytest.approx(3e-3 / stats.norm.ppf(0.975), rel=0.01)
