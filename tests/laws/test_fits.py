"""From delivered to working clearance, against handbook figures and hand calculation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lostmotion.laws.fits import (
    clearance_range,
    effective_interference,
    interference,
    mounted_clearance,
    raceway_diameter,
    thermal_loss,
    working_clearance,
)

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "working clearance of a bearing",
        "a maker's worked example (6008 on a k5 shaft); a thousand cases one by one",
        "printed digits; exact",
        "laws/fits.py",
    ),
)

UM = 1e-6
SIZE = st.floats(0, 100e-6)


def test_a_6008_on_k5_calculated_by_hand():
    """A 6008 (40 x 68 mm, CN) on a ground k5 shaft, loose in its housing, inner ring 5 K above the
    outer:  13 - 0.8 x 12.86 - 3.90 = -1.2 µm.
    """
    tight = interference((2 * UM, 13 * UM), (-12 * UM, 0.0))
    assert tight == pytest.approx((2 * UM, 25 * UM))
    effective = effective_interference(np.array(tight), 0.040)
    np.testing.assert_allclose(effective, np.array([2, 25]) * UM * 40 / 42, rtol=1e-12)
    warm = thermal_loss(5.0, raceway_diameter(0.040, 0.068, "ball"))
    assert warm == pytest.approx(12.5e-6 * 5 * (4 * 68 + 40) / 5 * 1e-3)
    middle = working_clearance(mounted_clearance(13 * UM, effective.mean()), warm)
    assert middle == pytest.approx((13 - 0.8 * 13.5 * 40 / 42 - 3.9) * UM, rel=1e-9)
    half = np.array([0.0, 1.0, 0.5])
    spread = clearance_range(
        6 * UM + 14 * UM * half, effective[0] + np.diff(effective) * half, 0 * half, warm * half
    )
    assert spread.mean == pytest.approx((13 - 0.8 * 13.5 * 40 / 42 - 3.9 / 2) * UM, rel=1e-9)
    assert spread.lowest == pytest.approx((6 - 0.8 * 25 * 40 / 42 - 3.9) * UM)
    assert spread.highest == pytest.approx((20 - 0.8 * 2 * 40 / 42) * UM)
    # some of these bearings are preloaded, others have clearance
    assert spread.lowest < 0 < spread.highest


def test_a_turned_seat_keeps_less_than_a_ground_one():
    """Of 20 µm on 40 mm a ground seat retains 40/42 and a turned one 40/43."""
    assert effective_interference(20 * UM, 0.04) == pytest.approx(20 * UM * 40 / 42)
    assert effective_interference(20 * UM, 0.04, "turned") == pytest.approx(20 * UM * 40 / 43)


@given(SIZE, SIZE, SIZE, SIZE, st.floats(0, 1), st.floats(0, 1))
@settings(deadline=None, max_examples=100)
def test_interference_and_temperature_reduce_clearance(
    initial, inner, outer, more, inner_share, outer_share
):
    """More interference or a hotter inner ring never increases the clearance; more initial
    clearance adds in full.
    """

    def works(i, a, b, t):
        return float(
            working_clearance(
                mounted_clearance(i, a, b, inner_share, outer_share), thermal_loss(t, 0.06)
            )
        )

    base = works(initial, inner, outer, 0.0)
    assert works(initial, inner + more, outer, 0.0) <= base
    assert works(initial, inner, outer + more, 0.0) <= base
    assert works(initial, inner, outer, more * 1e6) <= base
    assert works(initial + more, inner, outer, 0.0) == pytest.approx(base + more, abs=1e-18)


@given(st.floats(-100e-6, 0), st.floats(0.001, 1))
@settings(deadline=None, max_examples=50)
def test_a_loose_fit_changes_nothing(loose, diameter):
    """A loose fit of a ring does not change the clearance."""
    assert effective_interference(loose, diameter) == 0
    assert mounted_clearance(10 * UM, loose, loose) == 10 * UM


def test_the_raceway_of_a_bearing():
    """A 40 x 68 mm ball bearing's outer raceway is estimated as 62.4 mm, a roller bearing's as 61
    mm.
    """
    assert raceway_diameter(0.04, 0.068, "ball") == pytest.approx(0.0624)
    assert raceway_diameter(0.04, 0.068, "roller") == pytest.approx(0.061)


@given(
    st.tuples(SIZE, SIZE),
    st.tuples(st.floats(-50e-6, 50e-6), SIZE),
    st.tuples(st.floats(-50e-6, 50e-6), SIZE),
    st.lists(st.floats(0, 1), min_size=3, max_size=3),
)
@settings(deadline=None, max_examples=100)
def test_no_bearing_leaves_the_limits(initial, inner, outer, where):
    """For any parts within their limits the working clearance and its mean are within its own; the
    deviation is half of their distance at most.
    """
    bands = [tuple(sorted(band)) for band in (initial, inner, outer)]
    quantiles = np.concatenate([[0.0, 1.0], (np.arange(50) + 0.5) / 50])
    spread = clearance_range(
        *(low + quantiles * (high - low) for low, high in bands), 0 * quantiles
    )
    drawn = [low + share * (high - low) for (low, high), share in zip(bands, where, strict=True)]
    assert spread.lowest - 1e-15 <= mounted_clearance(*drawn) <= spread.highest + 1e-15
    assert spread.lowest - 1e-15 <= spread.mean <= spread.highest + 1e-15
    assert spread.deviation <= (spread.highest - spread.lowest) / 2 + 1e-15


@pytest.mark.parametrize("low", [-20.0, -6.0, -1.0, 3.0])
def test_a_fit_that_may_be_loose_takes_away_what_the_tight_ones_do(low):
    """An interference uniform from `low` to 10 µm, with 0.8 of what is above zero: by integrals,
    the mean is -0.4 b² / (b - a), b = 10 µm.
    """
    quantiles = np.concatenate([[0.0, 1.0], (np.arange(2000) + 0.5) / 2000])
    tight = low + (10.0 - low) * quantiles
    spread = clearance_range(0 * quantiles, tight, 0 * quantiles, 0 * quantiles)
    start, width = max(low, 0.0), 10.0 - low
    mean, square = (100.0 - start**2) / 2 / width, (1000.0 - start**3) / 3 / width
    assert spread.mean == pytest.approx(-0.8 * mean, abs=1e-5)
    assert spread.deviation == pytest.approx(0.8 * np.sqrt(square - mean**2), abs=1e-5)
    assert (spread.lowest, spread.highest) == pytest.approx((-8.0, -0.8 * start))


def test_a_batch_equals_its_single_bearings():
    """A thousand bearings in one call are the thousand one by one."""
    rng = np.random.default_rng(1)
    initial, inner = rng.uniform(0, 40e-6, 1000), rng.uniform(-10e-6, 30e-6, 1000)
    whole = mounted_clearance(initial, effective_interference(inner, 0.05))
    assert whole.shape == (1000,)
    assert whole[7] == mounted_clearance(initial[7], effective_interference(inner[7], 0.05))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: effective_interference(1e-6, 0.0), "above zero"),
        (lambda: mounted_clearance(0.0, 0.0, 0.0, 1.2), "between 0 and 1"),
        (lambda: raceway_diameter(0.07, 0.068, "ball"), "smaller"),
    ],
)
def test_impossible_values_are_refused(call, words):
    """Seats without a diameter, shares above one and bores beyond the outside diameter are
    refused.
    """
    with pytest.raises(ValueError, match=words):
        call()
