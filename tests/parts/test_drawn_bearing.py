"""Bearings by their drawing: the published 209 through the part, closed forms, and what mounting
does.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError

from lostmotion.laws.distributions import of_tolerance
from lostmotion.laws.rolling.equilibrium import shaft_equilibrium
from lostmotion.laws.rolling.rows import CrossedRow, RowSeat
from lostmotion.parts.bearing.crossed_roller import CrossedRoller
from lostmotion.parts.bearing.crossed_rollers import CrossedRollerBearing
from lostmotion.parts.bearing.pair import BallPair, RollerPair
from lostmotion.parts.joint import PrismaticJoint
from lostmotion.units import Toleranced
from tests.parts.conditions import condition, drawn, terms_at

UM = 1e-6
OF_209 = {
    "bore": "45 mm",
    "outside_diameter": "85 mm",
    "balls": 9,
    "ball_diameter": "12.7 mm",
    "pitch_diameter": "65 mm",
    "span": "60 mm",
}
OF_NU212 = {
    "bore": "60 mm",
    "outside_diameter": "110 mm",
    "rollers": 14,
    "roller_diameter": "14 mm",
    "roller_length": "14 mm",
}
OF_NU212 |= {"pitch_diameter": "85.5 mm", "span": "80 mm"}
OF_CROSSED = {
    "bore": "110 mm",
    "outside_diameter": "150 mm",
    "rollers": 48,
    "roller_diameter": "8 mm",
    "roller_length": "6 mm",
    "pitch_diameter": "130 mm",
}


def shift(part, wrench):
    """Return the design's shift and tilt (6,) under one load."""
    return sum(
        np.broadcast_to(term.screw, (1, 6))[0]
        for term in terms_at(part, condition(wrench))
        if term.level == "design"
    )


def test_a_209_pair_under_load_is_the_published_209():
    """Two 209 without clearance, 8 900 N each: the axis sinks by 51.5 µm, to 2 %."""
    found = shift(BallPair(**OF_209), (0, 0, 0, 2 * 8900.0, 0, 0))
    assert found[3] == pytest.approx(51.5 * UM, rel=0.02)
    assert np.abs(found[[0, 1, 2, 4, 5]]).max() < 0.1 * UM


def test_a_209_pair_tilts_by_its_two_shifts():
    """Loaded against each other by a moment the two shift oppositely: the tilt is twice the shift
    over the span, the 209's own.
    """
    found = shift(BallPair(**OF_209), (0, 8900.0 * 0.06, 0, 0, 0, 0))
    assert found[1] == pytest.approx(2 * 51.5 * UM / 0.06, rel=0.03)


def test_clearance_sinks_with_any_load_and_then_gives():
    """A load of next to nothing closes half the clearance; between its edge and a real load the
    elements deflect more than without clearance.
    """
    loose, tight = BallPair(**OF_209, clearance=20 * UM), BallPair(**OF_209)
    assert 10 * UM <= shift(loose, (0, 0, 0, 1e-3, 0, 0))[3] < 10 * UM / math.cos(math.pi / 9)
    for load in (100.0, 1000.0, 17800.0):
        assert (
            shift(loose, (0, 0, 0, load, 0, 0))[3]
            > shift(tight, (0, 0, 0, load, 0, 0))[3] + 9.9 * UM
        )
    soft = [shift(tight, (0, 0, 0, load, 0, 0))[3] / load for load in (100.0, 1000.0, 10000.0)]
    assert soft[0] > 1.5 * soft[1] > 2 * soft[2]


def test_an_unloaded_pair_rests_anywhere_in_its_play():
    """Without load each bearing rests somewhere on the circle of its clearance, the axis at most at
    half of it, and tilts by G/span at most.
    """
    pair = BallPair(**OF_209, clearance=20 * UM)
    errors = drawn(terms_at(pair, condition()), 20_000)[:, 0]
    across, tilt = np.hypot(errors[:, 3], errors[:, 4]), np.hypot(errors[:, 0], errors[:, 1])
    assert across.max() == pytest.approx(10 * UM, rel=0.01)
    assert tilt.max() == pytest.approx(20 * UM / 0.06, rel=0.01)
    apart = 0.04 * 12.7e-3
    np.testing.assert_allclose(
        np.abs(errors[:, 5]), math.sqrt(apart * 20 * UM - (10 * UM) ** 2), rtol=0.01
    )


def test_roller_pairs_hold_nothing_along_the_axis():
    """Cylindrical rollers: whatever the thrust, no axial term, and across the shift is what it is
    without.
    """
    pair = RollerPair(**OF_NU212, clearance=50 * UM)
    np.testing.assert_array_equal(
        shift(pair, (0, 0, 0, 2000, 500, 700)), shift(pair, (0, 0, 0, 2000, 500, 0))
    )
    assert not any(
        "axial" in term.name for term in terms_at(pair, condition((0, 0, 0, 2000, 500, 700)))
    )


def test_a_crossed_roller_by_its_rollers_is_the_row_in_space():
    """A preloaded crossed roller under a load from everywhere gives as the row solved in all five
    freedoms, to 3 %.
    """
    part = CrossedRollerBearing(**OF_CROSSED, clearance=-8 * UM)
    row = CrossedRow(count=48, length=6e-3, pitch=130e-3)
    load = np.array([1500.0, -700.0, 900.0, 60.0, -80.0])
    exact = shaft_equilibrium([RowSeat(row)], load[None], -8 * UM).displacement[0]
    found = shift(part, (load[3], load[4], 0, *load[:3]))
    np.testing.assert_allclose(found[[3, 4, 5, 0, 1]], exact, rtol=0.03, atol=0.02 * UM)


def test_a_crossed_roller_tilts_as_the_ring_of_springs_says():
    """By its rollers or by its maker's axial stiffness: k D²/8 per radian against tilting."""
    part = CrossedRollerBearing(**OF_CROSSED, clearance=-20 * UM)
    axial = 10.0 / shift(part, (0, 0, 0, 0, 0, 10.0))[5]
    tilting = 1.0 / shift(part, (1.0, 0, 0, 0, 0, 0))[0]
    assert tilting == pytest.approx(axial * 0.13**2 / 8, rel=0.02)
    stated = CrossedRoller(axial_stiffness=axial, pitch_diameter=0.13)
    assert 1.0 / shift(stated, (1.0, 0, 0, 0, 0, 0))[0] == pytest.approx(axial * 0.13**2 / 8)
    own = CrossedRoller(axial_stiffness=axial, pitch_diameter=0.13, moment_stiffness=1e5)
    assert own.tilt_stiffness == pytest.approx(1e5)
    assert CrossedRoller(axial_stiffness=axial).tilt_stiffness is None


def test_preload_makes_angular_contact_stiffer():
    """A preloaded pair gives less than one that is only just set, and has no play."""
    fields = {**OF_209, "balls": 13, "contact_angle": "25 deg"}
    loose, tight = BallPair(**fields), BallPair(**fields, preload="500 N")
    for wrench in ((0, 0, 0, 300, 0, 0), (0, 0, 0, 0, 0, 300), (10, 0, 0, 0, 0, 0)):
        assert np.linalg.norm(shift(tight, wrench)) < 0.8 * np.linalg.norm(shift(loose, wrench))
    assert not any(
        "clearance" in term.name or "play" in term.name
        for term in terms_at(tight, condition((5, 3, 0, 100, 0, 0)))
    )
    wide, narrow = tight, BallPair(**fields, preload="500 N", arrangement="face-to-face")
    assert shift(wide, (50.0, 0, 0, 0, 0, 0))[0] < 0.5 * shift(narrow, (50.0, 0, 0, 0, 0, 0))[0]


def test_mounting_takes_clearance_away():
    """By hand: 14.5 µm less 0.8 x 13 µm x 45/47 of the fit, less 5 K x 12.5e-6 x 77 mm of thermal
    expansion.
    """
    pair = BallPair(
        **OF_209, clearance="14.5 µm", shaft_interference="13 µm", inner_ring_warmer="5 K"
    )
    assert pair.working.nominal == pytest.approx(
        14.5 * UM - 0.8 * 13 * UM * 45 / 47 - 5 * 12.5e-6 * 0.077, abs=1e-12
    )
    assert pair.spreads["mounted"].mean == pytest.approx(
        14.5 * UM - 0.8 * 13 * UM * 45 / 47, abs=1e-12
    )
    loose = BallPair(
        **OF_209, clearance="14.5 µm", shaft_interference="-13 µm", housing_interference="-20 µm"
    )
    assert loose.working.nominal == pytest.approx(14.5 * UM)


def test_simulated_bearings_stay_within_the_limits():
    """Of 20 000 simulated bearings none leaves the limits, they approach both, and mean and
    deviation are theirs.
    """
    pair = BallPair(
        **OF_209,
        clearance=Toleranced(14.5e-6, 8.5e-6, "uniform"),
        shaft_interference="18 µm ± 11 µm",
        inner_ring_warmer="5 K ± 5 K",
    )
    for step, values in pair.sample(20_000, 1).items():
        spread = pair.spreads[step]
        assert (values >= spread.lowest).all()
        assert (values <= spread.highest).all()
        assert values.mean() == pytest.approx(spread.mean, abs=0.2 * UM)
        assert values.std() == pytest.approx(spread.deviation, rel=0.02)
    np.testing.assert_array_equal(pair.sample(50, 3)["working"], pair.sample(50, 3)["working"])


def test_a_warm_aluminium_housing_leaves_the_mean_of_its_bearings():
    """A 209 in aluminium, N7, at a temperature rise of 30 K: most outer rings are loose, their mean
    4.5 µm above the middle of the limits.
    """
    fits = {
        "clearance": "15 µm",
        "shaft_interference": "13 µm ± 11 µm",
        "housing_interference": "17.5 µm ± 21.5 µm",
    }
    pair = BallPair(**OF_209, **fits, housing_expansion="23e-6 1/K", temperature_rise="30 K")
    spread, made = pair.spreads["working"], pair.sample(20_000, 1)["working"]
    error = made.std() / math.sqrt(20_000)
    assert abs(spread.mean - made.mean()) < 4 * error
    assert spread.deviation == pytest.approx(made.std(), rel=0.02)
    assert spread.mean > (spread.lowest + spread.highest) / 2 + 4 * UM
    assert pair.working.nominal == spread.mean
    assert pair.working.tolerance / of_tolerance(pair.working.law).bound == pytest.approx(
        spread.deviation
    )


def test_more_clearance_moves_the_shaft_by_what_the_amount_says():
    """The scatter's term is what one more micrometre of clearance moves the loaded shaft."""
    wrench = (0, 0, 0, 3000.0, 0, 0)
    scattered = BallPair(**OF_209, clearance=Toleranced(20e-6, 6e-6, "uniform"))
    amounts = [
        term
        for term in terms_at(scattered, condition(wrench))
        if term.name in ("inboard amount", "outboard amount")
    ]
    limit = sum(term.screw[0, 3] * term.bound for term in amounts)
    more, less = (
        shift(BallPair(**OF_209, clearance=20e-6 + step), wrench)[3] for step in (6e-6, -6e-6)
    )
    assert limit == pytest.approx((more - less) / 2, rel=0.03)


def test_equal_bearings_share_their_table():
    """Two joints with one and the same bearing, even with a preload that is solved for, fill one
    table; another preload has its own.
    """
    fields = {**OF_209, "balls": 13, "contact_angle": "25 deg", "preload": "500 N"}
    assert BallPair(**fields).table(0.0) is BallPair(**fields).table(0.0)
    assert BallPair(**fields).table(0.0) is not BallPair(**{**fields, "preload": "400 N"}).table(
        0.0
    )


@pytest.mark.parametrize(
    "fields",
    [
        {"balls": 2},
        {"balls": 20},
        {"ball_diameter": "25 mm"},
        {"groove_conformity": [0.5, 0.52]},
        {"preload": "100 N"},
        {"contact_angle": "25 deg", "clearance": "10 µm"},
        {"contact_angle": "60 deg", "arrangement": "face-to-face"},
        {"clearance": "10 deg"},
        {"clearance": "1 mm"},
        {"clearance": "-1 mm"},
        {"shaft_interference": "2 mm"},
        {"contact_angle": "25 deg", "preload": "1000 kN"},
        {"bore": "90 mm"},
    ],
)
def test_no_bearing_can_be_so(fields):
    """What cannot be drawn is refused."""
    with pytest.raises(ValidationError):
        BallPair(**{**OF_209, **fields})


def test_crossed_rollers_come_in_pairs_and_nothing_turns_on_a_slide():
    """An odd number of crossed rollers is refused, and so is a turning bearing on a sliding
    joint.
    """
    with pytest.raises(ValidationError, match="47 crossed rollers"):
        CrossedRollerBearing(**{**OF_CROSSED, "rollers": 47})
    with pytest.raises(ValidationError, match="sliding"):
        PrismaticJoint(name="S", limits=(0, 1), bearing={"kind": "ball pair", **OF_209})
