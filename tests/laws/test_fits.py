"""From delivered to working clearance, against handbook figures and hand calculation."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lostmotion.laws.fits import (
    Body,
    clearance_spread,
    effective_interference,
    interference,
    mounted_clearance,
    raceway_diameter,
    share_of_inner_ring,
    share_of_outer_ring,
    thermal_loss,
    working_clearance,
)

UM = 1e-6
SIZE = st.floats(0, 100e-6)


def test_a_6008_on_k5_worked_by_hand():
    """A 6008 (40 x 68 mm, CN) on a ground k5 shaft, loose in its housing, 5 K warmer inside, works with 13 - 0.8 x 12.86 - 3.90 = -1.2 µm."""
    tight = interference((2 * UM, 13 * UM), (-12 * UM, 0.0))
    assert tight == pytest.approx((2 * UM, 25 * UM))
    effective = effective_interference(np.array(tight), 0.040)
    np.testing.assert_allclose(effective, np.array([2, 25]) * UM * 40 / 42, rtol=1e-12)
    warm = thermal_loss(5.0, raceway_diameter(0.040, 0.068, "ball"))
    assert warm == pytest.approx(12.5e-6 * 5 * (4 * 68 + 40) / 5 * 1e-3)
    middle = working_clearance(mounted_clearance(13 * UM, effective.mean()), warm)
    assert middle == pytest.approx((13 - 0.8 * 13.5 * 40 / 42 - 3.9) * UM, rel=1e-9)
    spread = clearance_spread((6 * UM, 20 * UM), tuple(effective), thermal=(0.0, float(warm)))
    assert spread.lowest == pytest.approx((6 - 0.8 * 25 * 40 / 42 - 3.9) * UM)
    assert spread.highest == pytest.approx((20 - 0.8 * 2 * 40 / 42) * UM)
    assert spread.lowest < 0 < spread.highest  # some of these bearings are preloaded, some rattle


def test_a_turned_seat_keeps_less_than_a_ground_one():
    """Of 20 µm on 40 mm a ground seat keeps 40/42 and a turned one 40/43."""
    assert effective_interference(20 * UM, 0.04) == pytest.approx(20 * UM * 40 / 42)
    assert effective_interference(20 * UM, 0.04, "turned") == pytest.approx(20 * UM * 40 / 43)


@given(SIZE, SIZE, SIZE, SIZE, st.floats(0, 1), st.floats(0, 1))
@settings(deadline=None, max_examples=100)
def test_whatever_is_tighter_or_warmer_leaves_less_clearance(initial, inner, outer, more, inner_share, outer_share):
    """More interference or warmth never opens a bearing; more initial clearance opens it by as much."""

    def works(i, a, b, t):
        return float(working_clearance(mounted_clearance(i, a, b, inner_share, outer_share), thermal_loss(t, 0.06)))

    base = works(initial, inner, outer, 0.0)
    assert works(initial, inner + more, outer, 0.0) <= base
    assert works(initial, inner, outer + more, 0.0) <= base
    assert works(initial, inner, outer, more * 1e6) <= base
    assert works(initial + more, inner, outer, 0.0) == pytest.approx(base + more, abs=1e-18)


@given(st.floats(-100e-6, 0), st.floats(0.001, 1))
@settings(deadline=None, max_examples=50)
def test_a_loose_fit_changes_nothing(loose, diameter):
    """A ring that sits loose keeps its clearance."""
    assert effective_interference(loose, diameter) == 0
    assert mounted_clearance(10 * UM, loose, loose) == 10 * UM


def test_a_ring_on_a_solid_shaft_passes_on_bore_over_raceway():
    """On a solid shaft of its own steel an inner ring's raceway grows by d/F of the interference, a deep groove's about 0.85."""
    assert share_of_inner_ring(Body(0.040, 0.0473), Body(0, 0.040)) == pytest.approx(40 / 47.3, rel=1e-12)


def test_a_ring_in_an_endless_housing_passes_on_raceway_over_outside():
    """In an endless housing of its own steel an outer ring's raceway shrinks by E/D of the interference."""
    assert share_of_outer_ring(Body(0.0608, 0.068), Body(0.068, math.inf)) == pytest.approx(60.8 / 68, rel=1e-12)


@given(st.floats(0, 0.9), st.floats(0.3, 0.95), st.floats(0.2, 4))
@settings(deadline=None, max_examples=100)
def test_a_hollow_or_softer_shaft_passes_on_less(hollow, wall, softer):
    """A hollow shaft of the ring's steel follows the handbooks' d/F (1 - c^2)/(1 - c^2 (d/F)^2); a stiffer one passes on more."""
    ring = Body(0.04, 0.04 / wall)
    same = share_of_inner_ring(ring, Body(hollow * 0.04, 0.04))
    assert same == pytest.approx(wall * (1 - hollow**2) / (1 - hollow**2 * wall**2), rel=1e-9)
    other = share_of_inner_ring(ring, Body(hollow * 0.04, 0.04, young=208e9 * softer))
    assert (other - same) * (softer - 1) >= 0
    assert 0 < other < 1.2


def test_an_aluminium_housing_passes_on_less_than_a_steel_one():
    """A thin aluminium housing gives way to the outer ring, which then shrinks less."""
    ring = Body(0.0608, 0.068)
    steel = share_of_outer_ring(ring, Body(0.068, 0.090))
    aluminium = share_of_outer_ring(ring, Body(0.068, 0.090, young=70e9, poisson=0.33))
    assert 0 < aluminium < steel < 60.8 / 68


def test_the_raceway_of_a_bearing():
    """A 40 x 68 mm ball bearing's outer raceway is taken as 62.4 mm, a roller bearing's as 61 mm."""
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
    """Whatever the parts are within their limits, the working clearance stays within its own; the limits at random are narrower."""
    bands = [tuple(sorted(band)) for band in (initial, inner, outer)]
    spread = clearance_spread(*bands)
    drawn = [low + share * (high - low) for (low, high), share in zip(bands, where, strict=True)]
    assert spread.lowest - 1e-15 <= mounted_clearance(*drawn) <= spread.highest + 1e-15
    assert spread.at_random <= (spread.highest - spread.lowest) / 2 + 1e-15


def test_batches_of_bearings_are_worked_out_at_once():
    """A thousand bearings in one call are the thousand one by one."""
    rng = np.random.default_rng(1)
    initial, inner = rng.uniform(0, 40e-6, 1000), rng.uniform(-10e-6, 30e-6, 1000)
    whole = mounted_clearance(initial, effective_interference(inner, 0.05))
    assert whole.shape == (1000,)
    assert whole[7] == mounted_clearance(initial[7], effective_interference(inner[7], 0.05))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: Body(0.04, 0.04), "inner diameter"),
        (lambda: Body(-0.01, 0.04), "inner diameter"),
        (lambda: effective_interference(1e-6, 0.0), "above zero"),
        (lambda: mounted_clearance(0.0, 0.0, 0.0, 1.2), "between 0 and 1"),
        (lambda: raceway_diameter(0.07, 0.068, "ball"), "smaller"),
        (lambda: share_of_inner_ring(Body(0.04, 0.047), Body(0, 0.05)), "bore"),
        (lambda: share_of_outer_ring(Body(0.06, 0.068), Body(0.07, 0.1)), "outer diameter"),
    ],
)
def test_what_cannot_be_is_refused(call, words):
    """Rings without wall, seats without diameter, shares beyond one and parts that do not meet have no answer."""
    with pytest.raises(ValueError, match=words):
        call()
