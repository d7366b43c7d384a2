"""Contacts on elastic bodies, solved together: limits, the equations themselves, and random
stages.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from lostmotion.laws.contact import equivalent_modulus
from lostmotion.laws.cycloid.bodies import ElasticBody, flexibility
from lostmotion.laws.cycloid.contact import Flanks, LoadSharing, Supports, load_sharing
from lostmotion.laws.cycloid.geometry import arms, contact_radius, normals, pin_angles
from lostmotion.laws.cycloid.stage import Stage
from lostmotion.laws.perforated_disc_series import Holes
from tests.laws.closed_forms import approach

STEEL = equivalent_modulus(210e9, 0.3, 210e9, 0.3)
STAGE = Stage(0.05, 0.003, 0.0012, 20)
HERTZ = Flanks(0.01, STEEL)
DISC, RING = ElasticBody("planet", 0.02, 210e9, 0.3), ElasticBody("ring", 0.06, 210e9, 0.3)
CRANK = np.array([0.0, 0.05, 1.7])
TORQUE = np.array([-100.0, -3.0, 0.5, 20.0, 200.0])


def both_bodies(crank: np.ndarray) -> np.ndarray:
    """Return the compliance of disc and ring, (side, crank, N, N), m/N."""
    return flexibility(STAGE, DISC, 0.01, crank) + flexibility(STAGE, RING, 0.01, crank)


def scattered(seed: int, draws: int = 30, mean: float = 1e-6) -> np.ndarray:
    """Return gaps (crank, draw, N) around a mean, m; some interfere."""
    return np.random.default_rng(seed).normal(mean, 2e-6, (len(CRANK), draws, STAGE.pins))


@pytest.mark.parametrize(
    "flanks",
    [
        HERTZ,
        Flanks(0.01, STEEL, bending=2e-9),
        Flanks(0.01, STEEL, "palmgren"),
        Flanks(0.01, STEEL, "linear", 0.0, 2e8),
    ],
)
@pytest.mark.parametrize("supports", [Supports(), Supports(3e8, 1e6, 0.03)])
def test_rigid_bodies_share_the_load_as_without_any(flanks: Flanks, supports: Supports):
    """Without compliance the two solvers, of different unknowns, agree on rotation, forces, bearing
    force, stiffness and number of lobes.
    """
    gap = scattered(1)
    ours = load_sharing(
        STAGE, flanks, TORQUE, CRANK, gap, supports, bodies=np.zeros((1, 3, 20, 20))
    ).checked()
    rigid = load_sharing(STAGE, flanks, TORQUE, CRANK, gap, supports).checked()
    np.testing.assert_allclose(ours.rotation, rigid.rotation, rtol=1e-8)
    np.testing.assert_allclose(ours.forces, rigid.forces, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(ours.bearing_force, rigid.bearing_force, rtol=1e-8)
    np.testing.assert_allclose(ours.stiffness, rigid.stiffness, rtol=1e-6)


def worst_violation(  # noqa: PLR0913, PLR0917 - the arguments of the solver, and its result
    stage: Stage,
    flanks: Flanks,
    torque: np.ndarray,
    crank: np.ndarray,
    gap: np.ndarray,
    supports: Supports,
    bodies: np.ndarray,
    found: LoadSharing,
) -> float:
    """Return the largest error in the equations of contacts and forces, over the largest approach
    or T/(e z), in NumPy and without the kernel.
    """
    theta = pin_angles(stage, crank)
    n, arm = normals(stage, theta), arms(stage, theta)
    worst = 0.0
    for i, each in enumerate(torque):
        for j in range(len(crank)):
            for k in np.flatnonzero(found.converged[i, j]):
                force = found.forces[i, j, k]
                pressed = approach(
                    flanks.law, force, flanks.width, contact_radius(stage, theta[j]), flanks.modulus
                )
                pressed = np.where(force > 0, pressed, 0.0) + flanks.bending * force
                moved = bodies[0 if each > 0 else 1, j] @ force
                unit = abs(each) / stage.planet_pitch_radius
                push = (
                    0.0
                    if math.isinf(supports.pin_circle)
                    else -4 * abs(each) / (math.pi * supports.pin_circle)
                )
                x, y = 0.0, 0.0
                if math.isfinite(supports.bearing):  # type: ignore[arg-type]
                    x, y = (
                        (push - force @ n[j, :, 0]) / supports.bearing,
                        -force @ n[j, :, 1] / supports.bearing,
                    )
                rigid = (
                    n[j] @ np.array([x, y])
                    + arm[j] * found.rotation[i, j, k]
                    - gap[min(j, len(gap) - 1), k]
                )
                off = rigid - pressed - moved
                worst = max(worst, abs(force @ arm[j] - each) / abs(each))
                scale = max(np.abs(pressed).max(), np.abs(moved).max(), np.abs(rigid).max())
                worst = max(
                    worst,
                    np.abs(off[force > 0]).max(initial=0.0) / scale,
                    off[force == 0].max(initial=0.0) / scale,
                )
                assert found.bearing_force[i, j, k] == pytest.approx(
                    math.hypot(force @ n[j, :, 0] - push, force @ n[j, :, 1]),
                    rel=1e-8,
                    abs=1e-8 * unit,
                )
    return worst


@pytest.mark.parametrize("mean", [2e-6, -2e-6])
@pytest.mark.parametrize("supports", [Supports(), Supports(3e8, math.inf, 0.03)])
def test_loaded_contacts_touch_and_the_others_do_not(mean: float, supports: Supports):
    """Approach by the law plus displacement of the bodies is the approach of the wheels less the
    gap where a lobe carries; no other lobe overlaps.
    """
    gap, bodies = scattered(2, 8, mean), both_bodies(CRANK)
    torque = TORQUE[[0, 3, 4]]
    found = load_sharing(STAGE, HERTZ, torque, CRANK, gap, supports, bodies=bodies).checked()
    assert worst_violation(STAGE, HERTZ, torque, CRANK, gap, supports, bodies, found) < 1e-9


def test_stiffness_is_the_slope_of_the_torque():
    """By differences of the rotation, with and without a bearing, in both directions."""
    bodies, gap = both_bodies(CRANK), scattered(3, 4)
    for supports in (Supports(), Supports(3e8, 1e6, 0.03)):
        for torque in (-80.0, 80.0):
            step = 1e-3
            found = load_sharing(
                STAGE,
                HERTZ,
                [torque - step, torque, torque + step],
                CRANK,
                gap,
                supports,
                bodies=bodies,
            ).checked()
            np.testing.assert_allclose(
                2 * step / (found.rotation[2] - found.rotation[0]), found.stiffness[1], rtol=2e-5
            )


def test_a_backward_torque_is_the_mirrored_drive():
    """With the crank mirrored about pin 0, lobe -k carries under a backward torque what lobe k
    carries under a forward one, also with holes.
    """
    mirror = -np.arange(20) % 20
    body = ElasticBody("planet", 0.02, 210e9, 0.3, Holes(6, 0.033, 0.006))
    ahead, behind = (
        load_sharing(STAGE, HERTZ, [t], [c], bodies=flexibility(STAGE, body, 0.01, np.array([c])))
        for t, c in ((90.0, 0.1), (-90.0, -0.1))
    )
    np.testing.assert_allclose(
        behind.forces[0, 0, 0][mirror], ahead.forces[0, 0, 0], rtol=1e-3, atol=0.1
    )
    assert float(behind.rotation[0, 0, 0]) == pytest.approx(
        -float(ahead.rotation[0, 0, 0]), rel=1e-4
    )


def test_softer_bodies_turn_further_and_spread_the_load():
    """Each halving of the modulus of both bodies turns the output further; the largest force falls
    from that on rigid bodies.
    """
    found = [
        load_sharing(
            STAGE, HERTZ, [100.0], [0.1], bodies=factor * both_bodies(np.array([0.1]))
        ).checked()
        for factor in (0.0, 0.5, 1.0, 2.0, 4.0)
    ]
    assert (np.diff([float(each.rotation[0, 0, 0]) for each in found]) > 0).all()
    assert max(float(each.forces.max()) for each in found[1:]) < 0.98 * float(found[0].forces.max())


def test_threads_and_batches_do_not_change_the_result():
    """Bit for bit, and one case of a batch as by itself."""
    gap, bodies = scattered(4), both_bodies(CRANK)
    whole = load_sharing(STAGE, HERTZ, TORQUE, CRANK, gap, Supports(3e8), bodies=bodies)
    threaded = load_sharing(
        STAGE, HERTZ, TORQUE, CRANK, gap, Supports(3e8), bodies=bodies, threads=3
    )
    np.testing.assert_array_equal(whole.rotation, threaded.rotation)
    one = load_sharing(
        STAGE, HERTZ, TORQUE[2:3], CRANK[1:2], gap[1, 7], Supports(3e8), bodies=bodies[:, 1:2]
    )
    np.testing.assert_array_equal(one.forces[0, 0, 0], whole.forces[2, 1, 7])


def test_no_torque_leaves_the_disc_free_or_preloaded():
    """With gaps nothing carries; with interference the forces have no moment."""
    bodies = both_bodies(CRANK[:1])
    free = load_sharing(STAGE, HERTZ, [0.0], CRANK[:1], 1e-6, bodies=bodies).checked()
    assert not free.forces.any()
    assert not free.rotation.any()
    tight = load_sharing(
        STAGE, HERTZ, [0.0], CRANK[:1], -1e-6, Supports(3e8), bodies=bodies
    ).checked()
    assert tight.forces.max() > 10
    moment = tight.forces[0, 0, 0] @ arms(STAGE, pin_angles(STAGE, CRANK[:1])[0])
    assert abs(moment) < 1e-9 * tight.forces.max() * STAGE.planet_pitch_radius


def test_a_load_beyond_the_law_is_marked():
    """A load at which the contact would be as wide as the pin has no figures."""
    found = load_sharing(
        STAGE, Flanks(0.01, STEEL / 100), [1e5], CRANK[:1], bodies=100 * both_bodies(CRANK[:1])
    )
    assert not found.converged.any()
    assert np.isnan(found.forces).all()


@pytest.mark.parametrize(
    ("bodies", "why"),
    [
        (np.zeros((1, 2, 20, 20)), "shape"),
        (np.zeros((20, 20)), "shape"),
        (np.full((1, 1, 20, 20), np.nan), "finite"),
    ],
)
def test_impossible_compliances_are_refused(bodies: np.ndarray, why: str):
    """A compliance of another shape, or with values that are not numbers."""
    with pytest.raises(ValueError, match=why):
        load_sharing(STAGE, HERTZ, [1.0], [0.0], bodies=bodies)


def random_holes(stream: np.random.Generator, stage: Stage, bore: float) -> Holes | None:
    """Return holes for output pins or for the bearings of cranks in the room between bore and root
    circle, or none.
    """
    root = stage.tip_radius - 2 * stage.eccentricity
    if root < 1.5 * bore or stream.uniform() < 1 / 3:
        return None
    bearings = bool(stream.uniform() < 1 / 2)
    count, circle = (
        int(stream.integers(2, 4) if bearings else stream.integers(3, 12)),
        (bore + root) / 2,
    )
    room = min((root - bore) / 2, circle * math.sin(math.pi / count))
    return Holes(count, circle, stream.uniform(0.2, 0.75) * room, bearings)


def random_cases(seed: int, stages: int, gearboxes: int, checked: int) -> tuple[int, int, float]:
    """Return the number of random cases, of those that are not converged, and the largest violation
    of the equations by the first `checked`.
    """
    stream = np.random.default_rng(seed)
    count = missed = 0
    worst = 0.0
    for _ in range(stages):
        pins, reach = int(stream.integers(8, 60)), 10 ** stream.uniform(-2, -0.7)
        pin = stream.uniform(0.2, 0.9) * reach * math.sin(math.pi / pins)
        kind = stream.choice(["ring pins", "lobe arcs", "lobe envelope", "planet pins"])
        try:
            stage = Stage(reach, pin, stream.uniform(0.2, 0.9) * reach / pins, pins, kind)
            young, other, width = (
                10 ** stream.uniform(9.3, 11.4),
                10 ** stream.uniform(9.3, 11.4),
                reach * stream.uniform(0.05, 0.5),
            )
            nu, crank = stream.uniform(0.2, 0.45), stream.uniform(0, 6, 1)
            bore = stream.uniform(0.1, 0.6) * reach
            disc = ElasticBody("planet", bore, young, nu, random_holes(stream, stage, bore))
            ring = ElasticBody("ring", stream.uniform(1.35, 2) * reach, other, nu)
            bodies = flexibility(stage, disc, width, crank) + flexibility(stage, ring, width, crank)
        except ValueError:
            continue
        modulus = equivalent_modulus(young, nu, other, nu)
        flanks = Flanks(width, modulus, bending=stream.choice([0.0, 1 / (modulus * width)]))
        torque = (
            modulus
            * width
            * reach**2
            * 10 ** stream.uniform(-7, -3.5, 4)
            * stream.choice([-1, 1], 4)
        )
        deflection = (
            np.abs(torque).max() / (modulus * width * stage.planet_pitch_radius) * 12 / pins
        )
        gap = (
            deflection
            * 10 ** stream.uniform(-2, 1)
            * stream.normal(stream.choice([0, 0.5, -1, 1]), 1, (1, gearboxes, pins))
        )
        bearing = stream.choice([math.inf, modulus * width * 10 ** stream.uniform(-2, 1)])
        supports = Supports(float(bearing), math.inf, float(stream.choice([math.inf, 0.5 * reach])))
        found = load_sharing(stage, flanks, torque, crank, gap, supports, bodies=bodies)
        count += found.converged.size
        if not found.converged.all():
            # beyond the law of contact without the bodies, too
            legitimate = ~load_sharing(stage, flanks, torque, crank, gap, supports).converged
            missed += int((~found.converged & ~legitimate).sum())
        if checked:
            some = load_sharing(
                stage, flanks, torque, crank, gap[:, :checked], supports, bodies=bodies
            )
            np.testing.assert_array_equal(some.forces, found.forces[:, :, :checked])
            worst = max(
                worst,
                worst_violation(
                    stage, flanks, torque, crank, gap[:, :checked], supports, bodies, some
                ),
            )
    return count, missed, worst


def test_random_stages_are_solved_or_marked():
    """Stages of every kind, holes, materials, gaps far above and below the deflections,
    interference, bearings: none is wrong, none is missed.
    """
    count, missed, worst = random_cases(1, 8, 10, 10)
    assert count > 200
    assert missed == 0
    assert worst < 1e-7


@pytest.mark.slow
def test_many_random_stages_are_solved_or_marked():
    """25 000 cases and more, as above; the equations are checked in 1 000."""
    count, missed, worst = random_cases(2, 50, 150, 6)
    assert count > 25_000
    assert missed == 0
    assert worst < 1e-7
