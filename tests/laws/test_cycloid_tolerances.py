"""Simulated cycloidal stages against direct searches, closed forms of averaging, and their own
reproducibility.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq, linprog

from lostmotion.laws.contact import equivalent_modulus
from lostmotion.laws.cycloid.contact import Flanks
from lostmotion.laws.cycloid.drive import (
    LEAST_ARM,
    Drive,
    EccentricSprings,
    OutputPinSprings,
    loaded_disc,
)
from lostmotion.laws.cycloid.geometry import (
    arms,
    first_contact_angle,
    flank,
    normals,
    pin_angles,
    planet_pose,
    play,
)
from lostmotion.laws.cycloid.simulated import simulate
from lostmotion.laws.cycloid.stage import Modification, Stage
from lostmotion.laws.cycloid.tolerances import (
    DimensionScatter,
    clearance_angle,
    sample,
    sample_gaps,
)
from lostmotion.laws.cycloid.wind_up import wind_up_by_member
from lostmotion.laws.distributions import Normal
from lostmotion.units import Toleranced

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "gaps of stages with manufacturing errors",
        "distances to the displaced true profile",
        "2 % of the error",
        "laws/cycloid/tolerances.py laws/cycloid/simulated.py",
    ),
    (
        "manufactured samples of cycloidal stages",
        (
            "torque shares by root finding; backlash by linear programming; averages of "
            "independent errors"
        ),
        "5 % of the share; 1 to 3 % of the backlash, at most 15 %; 10 % of the standard deviation",
        "laws/cycloid/tolerances.py laws/cycloid/simulated.py",
    ),
)

STEEL = equivalent_modulus(210e9, 0.3, 210e9, 0.3)
STAGE = Stage(0.064, 0.003, 0.0013, 40)
LEVER = STAGE.planet_pitch_radius
DRIVE = Drive(
    STAGE, Flanks(0.0125, STEEL), Modification(roller=6e-6), 2, EccentricSprings(bearing=4e8)
)
SCATTER = DimensionScatter(
    pin_radius=Toleranced(0.003, 1e-6),
    eccentricity=Toleranced(0.0013, 2e-6),
    pin_position=2e-6,
    pin_size=0.5e-6,
    flank_form=1.5e-6,
)
CRANK = 2 * math.pi * np.arange(8) / 8


def test_without_scatter_all_gearboxes_are_nominal():
    """Without scatter the play is the formula's, and the wind-up is the sum over the members."""
    found = simulate(DRIVE, DimensionScatter(), np.array([100.0]), CRANK, 3, 1)
    np.testing.assert_allclose(found.play, play(STAGE, DRIVE.relief), rtol=5e-3)
    wind_up = (found.rotation[0] - found.ahead).mean(axis=0)
    np.testing.assert_allclose(
        wind_up, sum(wind_up_by_member(DRIVE, np.array([100.0])).values())[0], rtol=3e-3
    )
    np.testing.assert_array_equal(found.play, found.play[0])
    assert not found.jammed.any()


def test_discs_share_the_torque_at_a_common_angle():
    """The common angle of two discs with different gaps is that at which a root finder balances
    their torques.
    """
    scatter = replace(SCATTER, flank_form=4e-6)
    crank = np.array([0.7])
    torque = 60.0
    found = simulate(
        DRIVE, scatter, np.array([0.2 * torque, 0.5 * torque, torque, 2 * torque]), crank, 12, 3
    )
    gap = sample_gaps(DRIVE, scatter, crank, 12, 3)

    def carried(disc: int, gearbox: int, angle: float) -> float:
        turned = crank + math.pi * disc

        def excess(load: float) -> float:
            return (
                float(loaded_disc(DRIVE, load, turned, gap[disc][:, [gearbox]]).rotation[0, 0, 0])
                - angle
            )

        return 0.0 if excess(1e-3) > 0 else brentq(excess, 1e-3, 3 * torque, xtol=1e-9)

    unlike = 0.0
    for gearbox in range(12):
        shares = [carried(disc, gearbox, float(found.rotation[2, 0, gearbox])) for disc in (0, 1)]
        # linear interpolation between a few loads
        assert sum(shares) == pytest.approx(torque, rel=0.05)
        unlike = max(unlike, abs(shares[0] - shares[1]))
    assert unlike > 0.1 * torque


def test_errors_average_under_load_and_one_decides_without():
    """Independent flank errors s rotate a loaded disc by 2 s/(e z sqrt N), r.m.s. over gearboxes;
    unloaded the narrowest gap decides.
    """
    deviation = 1e-6
    scatter = DimensionScatter(flank_form=3 * deviation)
    one = replace(DRIVE, discs=1, eccentric=EccentricSprings())
    # the wind-up is much larger than the differences between flanks
    found = simulate(one, scatter, np.array([3000.0]), np.array([0.3]), 1500, 1)
    spread = found.rotation[0, 0].std()
    assert spread == pytest.approx(2 * deviation / (LEVER * math.sqrt(40)), rel=0.1)
    assert found.ahead[0].std() > 1.3 * spread
    assert found.play.mean() < play(STAGE, DRIVE.relief)
    two = simulate(replace(one, discs=2), scatter, np.array([6000.0]), np.array([0.3]), 1500, 1)
    assert two.rotation[0, 0].std() == pytest.approx(spread / math.sqrt(2), rel=0.1)


def test_every_dimension_changes_the_gaps_to_first_order():
    """Gaps of a stage with errors, measured on the true profile at its true position, agree with
    the first-order gaps.
    """
    wrong = {"ring_radius": 0.5e-6, "pin_radius": 0.5e-6, "eccentricity": 0.5e-6}
    t = np.linspace(0, 2 * math.pi, 400_001)
    psi = 0.4
    for name, size in wrong.items():
        scatter = DimensionScatter(**{name: Toleranced(getattr(STAGE, name), size)})
        gap = sample_gaps(replace(DRIVE, relief=Modification()), scatter, np.array([psi]), 1, 1)[
            0, 0, 0
        ]
        made = {key: getattr(STAGE, key) for key in ("ring_radius", "pin_radius", "eccentricity")}
        sample = _drawn_size(scatter, name)
        made[name] += sample
        # the disc is nominal; pins and crank have errors
        points = flank(STAGE, t)[0] @ [1, 1j]
        centre, turn = planet_pose(replace(STAGE, eccentricity=made["eccentricity"]), np.array(psi))
        placed = points * np.exp(1j * turn) + complex(*centre)
        angle = 2 * math.pi * np.arange(STAGE.pins) / STAGE.pins
        pins = made["ring_radius"] * np.exp(1j * angle)
        seen = np.array([np.abs(placed - pin).min() for pin in pins]) - made["pin_radius"]
        np.testing.assert_allclose(gap, seen, atol=0.02 * abs(sample))


def _drawn_size(scatter: DimensionScatter, name: str) -> float:
    """Return the sampled size from a stage on which it alone acts."""
    gap = sample_gaps(
        replace(DRIVE, relief=Modification(), discs=1), scatter, np.array([0.0]), 1, 1
    )[0, 0, 0]
    per_unit = {
        "ring_radius": 1.0,
        "pin_radius": -1.0,
        "eccentricity": -float(normals(STAGE, np.array(0.0))[0]),
    }[name]
    return float(gap[0] / per_unit)


def test_clearances_add_by_their_levers():
    """Play is G/(e z) of the crank bearing plus Gw/Rw of the output pins; a direct search over disc
    positions finds slightly more, never less.
    """
    drive = replace(DRIVE, discs=1, output=OutputPinSprings(8, 0.04))
    scatter = replace(SCATTER, crank_clearance=Toleranced(10e-6), output_clearance=Toleranced(8e-6))
    np.testing.assert_allclose(clearance_angle(drive, scatter, 4, 1), 10e-6 / LEVER + 8e-6 / 0.04)
    crank = np.array([0.2])
    gap = sample_gaps(drive, scatter, crank, 60, 1)[0, 0]
    theta = pin_angles(STAGE, crank)[0]
    found = simulate(drive, scatter, np.array([]), crank, 60, 1)
    around = 2 * math.pi * np.arange(64) / 64
    circle = np.stack([np.zeros(64), np.cos(around), np.sin(around)], axis=-1)
    held = np.column_stack([arms(STAGE, theta) * 1e3, -normals(STAGE, theta)])
    ratios = []
    for each, additive in zip(gap, found.ahead[0] - 4e-6 / 0.04, strict=True):
        # largest rotation (mrad) of the disc with its centre (µm) anywhere within the clearance
        best = linprog(
            [-1, 0, 0],
            np.vstack([held, circle]),
            np.r_[each * 1e6, np.full(64, 5.0)],
            bounds=[(None, None)] * 3,
        )
        ratios.append(-best.fun * 1e-3 / additive)
    assert min(ratios) > 0.998  # a polygon instead of a circle
    assert 1.0 < np.mean(ratios) < 1.03
    assert max(ratios) < 1.15


def test_mirrored_errors_mirror_the_rotation():
    """Mirrored errors respond to a torque as the unmirrored ones to the opposite torque."""
    found = simulate(DRIVE, SCATTER, np.array([-40.0, 40.0]), CRANK, 400, 1)
    assert (found.rotation[0] < 0).all()
    assert found.rotation[1].mean() == pytest.approx(-found.rotation[0].mean(), rel=0.01)
    assert found.behind.mean() == pytest.approx(found.ahead.mean(), rel=0.02)


def test_gearboxes_that_interfere_are_counted():
    """Without relief and with pins too large by up to 5 µm, flanks push against each other without
    torque, and there is no play.
    """
    tight = replace(DRIVE, relief=Modification())
    found = simulate(
        tight,
        DimensionScatter(pin_radius=Toleranced(0.003, 5e-6, "uniform")),
        np.array([]),
        CRANK,
        200,
        1,
    )
    assert 0.4 < found.jammed.mean() < 0.6
    assert (found.play[found.jammed] == 0).all()
    assert (found.play[~found.jammed] > 0).all()


def test_the_same_gearboxes_whatever_the_other_settings():
    """More gearboxes keep the first; threads have no effect; another tolerance leaves the other
    draws unchanged; another seed changes them.
    """
    few = simulate(DRIVE, SCATTER, np.array([50.0]), CRANK[:2], 5, 7)
    many = simulate(DRIVE, SCATTER, np.array([50.0]), CRANK[:2], 9, 7, threads=2)
    np.testing.assert_array_equal(few.rotation, many.rotation[..., :5])
    np.testing.assert_array_equal(few.ahead, many.ahead[..., :5])
    wider = sample_gaps(
        DRIVE, replace(SCATTER, ring_radius=Toleranced(0.064, 4e-6)), CRANK[:1], 5, 7
    )
    plain = sample_gaps(DRIVE, SCATTER, CRANK[:1], 5, 7)
    along = (wider - plain)[0, 0]  # dR (1 - K1 cos theta)/D: one draw per gearbox
    np.testing.assert_allclose(
        along / along[:, :1], np.broadcast_to(along[0] / along[0, 0], along.shape), rtol=1e-6
    )
    assert not np.array_equal(
        simulate(DRIVE, SCATTER, np.array([]), CRANK[:1], 5, 8).ahead, few.ahead[:1]
    )


def test_no_torque_is_refused():
    """Without torque the angle is not determined."""
    with pytest.raises(ValueError, match="play"):
        simulate(DRIVE, SCATTER, np.array([0.0]), CRANK, 2, 1)


def test_first_contact_counts_both_discs():
    """The free rotation ahead is the smaller one of the two discs'."""
    crank = CRANK[:3]
    gap = sample_gaps(DRIVE, SCATTER, crank, 6, 2)
    each = [
        first_contact_angle(
            STAGE, pin_angles(STAGE, crank + math.pi * disc)[:, None], gap[disc], LEAST_ARM
        )
        for disc in (0, 1)
    ]
    np.testing.assert_array_equal(
        simulate(DRIVE, SCATTER, np.array([]), crank, 6, 2).ahead, np.minimum(*each)
    )


def test_discs_that_push_against_each_other_rest_in_the_middle_of_their_overlap():
    """Without torque, where one disc's first contact ahead lies behind the other's first contact
    behind, the output rests halfway and has no play.
    """
    scatter, crank = replace(SCATTER, flank_form=12e-6), CRANK[:3]
    gap = sample_gaps(DRIVE, scatter, crank, 400, 2)
    angles = [pin_angles(STAGE, crank + math.pi * disc)[:, None] for disc in (0, 1)]
    ahead, behind = (
        np.array(
            [
                first_contact_angle(STAGE, sign * theta, each, LEAST_ARM)
                for theta, each in zip(angles, gap, strict=True)
            ]
        )
        for sign in (1, -1)
    )
    free = ((ahead + behind) > 0).all(axis=0)  # each disc alone has play
    overlap = free & (ahead.min(axis=0) + behind.min(axis=0) < 0)
    assert overlap.sum() > 10
    found = simulate(DRIVE, scatter, np.array([]), crank, 400, 2)
    halfway = (ahead.min(axis=0) - behind.min(axis=0)) / 2
    np.testing.assert_allclose(found.ahead[overlap], halfway[overlap], rtol=1e-12)
    np.testing.assert_array_equal(found.ahead[overlap], -found.behind[overlap])


def test_misplaced_output_pins_touch_their_holes_as_circles_do():
    """Free rotation to the first contact of circular pins and holes agrees with the first-order
    formula; under load the errors average.
    """
    clearance, position, pins = 30e-6, 12e-6, OutputPinSprings(8, 0.04)
    drive = replace(DRIVE, discs=1, output=pins)
    scatter = DimensionScatter(output_clearance=Toleranced(clearance), output_position=position)
    crank = np.array([0.5])
    found = simulate(drive, scatter, np.array([]), crank, 40, 3)
    without = simulate(drive, replace(scatter, output_position=0.0), np.array([]), crank, 40, 3)
    place = pins.circle * np.exp(2j * math.pi * np.arange(8) / 8)
    way = STAGE.eccentricity * np.exp(1j * crank[0])
    law = Normal()
    off = [sample(position, law, f"output_position {axis} disc 0", 3, (40, 8)) for axis in "xy"]
    for ends, sign in ((found.ahead - without.ahead, 1), (found.behind - without.behind, -1)):
        for gearbox in range(40):

            def room(turn: float, error: np.ndarray, sign: int = sign) -> float:
                gone = place * (np.exp(1j * sign * turn) - 1) + error - way
                return float((STAGE.eccentricity + clearance / 2 - np.abs(gone)).min())

            error = off[0][gearbox] + 1j * off[1][gearbox]
            true = brentq(room, 0, 5e-3, args=(error,)) - brentq(room, 0, 5e-3, args=(np.zeros(8),))
            assert ends[0, gearbox] == pytest.approx(true, abs=0.02 * clearance / pins.circle)
    assert (found.play < without.play).mean() > 0.9  # one of many pins touches early
    heavy = simulate(
        replace(drive, eccentric=EccentricSprings()), scatter, np.array([3000.0]), crank, 1500, 1
    ).rotation[0, 0]
    # errors of pins along the line of centres have the deviation s, the output s/(Rw sqrt(sum of
    # sin^2)); the sum is a quarter of the number of pins
    assert heavy.std() == pytest.approx(
        position / law.bound / (pins.circle * math.sqrt(8 / 4)), rel=0.1
    )


CRANKS = EccentricSprings(bearing=4e8, cranks=2, circle=0.036)


def _bores_off(position: float, cranks: int, gearboxes: int, disc: int) -> np.ndarray:
    """Return the offsets (gearbox, crank) of a disc's bores, as complex numbers."""
    x, y = (
        sample(position, Normal(), f"crank_position {way} disc {disc}", 3, (gearboxes, cranks))
        for way in "xy"
    )
    return x + 1j * y


@pytest.mark.parametrize(
    "eccentric", [EccentricSprings(), CRANKS, EccentricSprings(cranks=3, circle=0.036)]
)
def test_misplaced_bores_shift_and_rotate_the_disc(eccentric):
    """Gaps measured on the true profile of a disc, placed on its crankshafts by least squares,
    agree with the simulated gaps.
    """
    drive, psi, gearbox = replace(DRIVE, relief=Modification(), eccentric=eccentric), 0.4, 0
    found = sample_gaps(drive, DimensionScatter(crank_position=2e-7), np.array([psi]), 4, 3)[
        :, 0, gearbox
    ]
    points = flank(STAGE, np.linspace(0, 2 * math.pi, 400_001))[0] @ [1, 1j]
    pins = STAGE.ring_radius * np.exp(2j * math.pi * np.arange(STAGE.pins) / STAGE.pins)
    circle = eccentric.circle if eccentric.cranks > 1 else 0.0
    for disc in (0, 1):
        # in axes along the line of centres of this disc, whose crank is half a turn ahead
        off = _bores_off(2e-7, eccentric.cranks, 4, disc)[gearbox] * np.exp(-1j * math.pi * disc)
        shafts = circle * np.exp(
            1j * (2 * math.pi * np.arange(eccentric.cranks) / eccentric.cranks - math.pi * disc)
        )
        turned = (np.conj(shafts) * off).imag.sum() / max((np.abs(shafts) ** 2).sum(), 1.0e-30)
        centre, turn = planet_pose(STAGE, np.array(psi))
        placed = points * np.exp(1j * (turn + turned)) + complex(*centre) + off.mean()
        seen = np.array([np.abs(placed - pin).min() for pin in pins]) - STAGE.pin_radius
        # pins are numbered from the same position; the other disc meets them half a turn later
        np.testing.assert_allclose(np.sort(found[disc]), np.sort(seen), atol=6e-10)
        assert np.ptp(seen) > 3e-8


@pytest.mark.parametrize(("cranks", "missing"), [(2, 0.02), (3, 0.08)])
def test_misfitting_bores_reduce_the_clearance(cranks, missing):
    """The reduced free rotation agrees with a linear program for a rigid disc with all its bores
    within the clearance of their bearings.
    """
    clearance = 10e-6
    drive = replace(DRIVE, discs=1, relief=Modification(), eccentric=replace(CRANKS, cranks=cranks))
    scatter = DimensionScatter(crank_clearance=Toleranced(clearance), crank_position=4e-6)
    crank, many = 2 * math.pi * np.arange(6) / 6, 40
    free = simulate(drive, scatter, np.array([]), crank, many, 3)
    tight = simulate(
        drive, replace(scatter, crank_clearance=Toleranced(0.0)), np.array([]), crank, many, 3
    )
    left = ((free.ahead - tight.ahead) / (clearance_angle(drive, scatter, 1, 3) / 2))[0]
    off = _bores_off(4e-6, cranks, many, 0)
    around = np.exp(2j * math.pi * np.arange(64) / 64)
    true = np.empty((len(crank), many))
    for k, psi in enumerate(crank):
        shafts = np.exp(1j * (2 * math.pi * np.arange(cranks) / cranks - psi))
        tangent = 1j * shafts
        for gearbox in range(many):
            error = off[gearbox] * np.exp(-1j * psi)
            error = error - error.mean() - (np.conj(tangent) * error).real.mean() * tangent
            # unknowns: displacement along and across, rotation times Rc; each bore is within a
            # polygon around its crank
            held = np.vstack(
                [
                    np.column_stack([around.real, around.imag, (np.conj(around) * t).real])
                    for t in tangent
                ]
            )
            room = np.concatenate([clearance / 2 + (np.conj(around) * e).real for e in error])
            best = linprog(
                [0, -1 / LEVER, -1 / CRANKS.circle], held, room * 1e6, bounds=[(None, None)] * 3
            )
            true[k, gearbox] = -best.fun * 1e-6
    true /= float(clearance_angle(drive, scatter, 1, 3)[0]) / 2
    assert (left.mean() - true.mean()) == pytest.approx(missing, abs=0.02)
    assert left.mean() < 0.995
    jammed = simulate(drive, replace(scatter, crank_position=60e-6), np.array([]), crank, many, 3)
    alone = simulate(
        drive,
        replace(scatter, crank_position=60e-6, crank_clearance=Toleranced(0.0)),
        np.array([]),
        crank,
        many,
        3,
    )
    # beyond it the bearings are preloaded
    assert ((jammed.ahead - alone.ahead).mean(axis=0) < 1e-12).mean() > 0.5
