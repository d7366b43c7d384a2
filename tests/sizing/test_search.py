"""Search for parts that meet a target: against all selections, and against the study."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import lostmotion
from lostmotion.analyses.sizing.sizing import rms_error, size_links
from lostmotion.catalogue import materials
from lostmotion.error_model.pose_matrix import screws
from lostmotion.error_model.poses import Poses
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.state import state_of
from lostmotion.parts.bearing.rolling import RollingPair
from lostmotion.parts.encoder import Encoder
from lostmotion.parts.error_source import (
    AngleAmount,
    AngularStiffness,
    FrictionTorque,
    PlayDim,
    TorqueAmount,
)
from lostmotion.parts.family import TubeFamily
from lostmotion.parts.gearbox.catalogue import CatalogueGearbox
from lostmotion.parts.section import Tube
from lostmotion.sizing.candidates import (
    LinkOptions,
    Objective,
    PartCandidate,
    Slot,
    link_slot,
    refined_candidates,
)
from lostmotion.sizing.error_cache import ErrorCache, error_at, mean_square, share_within
from lostmotion.sizing.evaluation import LEVEL, Constraints
from lostmotion.sizing.lightest import Limits
from lostmotion.sizing.search import Search
from lostmotion.units import Toleranced
from tests.sizing.chosen_parts import with_parts

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "parts chosen for a target",
        (
            "all selections of 24 small cases; sums over parts against a first evaluation of the "
            "arm; a study of sized.toml"
        ),
        "equal where proven, else within 1 % of the cost; bit for bit; bit for bit",
        "tests/analyses/sizing/test_selection_sheet.py",
    ),
)

ARCMIN = math.pi / 10800
Reducer = CatalogueGearbox[AngleAmount, PlayDim, AngularStiffness, TorqueAmount, FrictionTorque]


def reducer(name, torque, stiffness, play, **costs):
    """A reducer with figures in N m, N m/arcmin and arcmin."""
    made = Reducer.model_validate(
        {
            "model": name,
            "rated_torque": torque,
            "stiffness": stiffness / ARCMIN,
            "backlash": Toleranced(play * ARCMIN),
        }
    )
    return PartCandidate(name, made, **costs)


def bearing(clearance, price):
    """A pair of bearings with this clearance, µm."""
    return PartCandidate(
        f"{clearance} µm",
        RollingPair(span=0.1, clearance=Toleranced(clearance * 1e-6, clearance * 5e-7)),
        price=price,
    )


def arm_of(joints=3, payload=6.0):
    """A chain of horizontal joints with tubes between."""
    link = {
        "length": 0.35,
        "section": Tube(outer=0.08, wall=0.003),
        "material": materials()["aluminium"],
    }
    made = [
        {
            "name": f"j{k}",
            "type": "revolute",
            "axis": "z" if k == 0 else "y",
            "limits": (-1.2, 1.2),
            "mass": 5.0,
            "link": link,
            "gearbox": Reducer.model_validate({"stiffness": 40 / ARCMIN, "rated_torque": 200.0}),
            "bearing": RollingPair(span=0.1, clearance=Toleranced(30e-6)),
        }
        for k in range(joints)
    ]
    return Arm(name="chain", joints=made, payload={"mass": payload})


def gearbox_slot(name, rng, count):
    """Gearboxes for a joint: expensive ones tend to be stiffer and to have less backlash."""
    made = []
    for k in range(count):
        good = 1.6**k * rng.uniform(0.8, 1.25)
        made.append(
            reducer(
                f"g{k}",
                400.0,
                15 * good,
                1.2 / good,
                mass=3.0 * 1.2**k * rng.uniform(0.9, 1.1),
                price=300 * 1.5**k * rng.uniform(0.8, 1.2),
            )
        )
    return Slot(name, "gearbox", tuple(made), PartCandidate("now", None, 3.0), mass_in_joint=3.0)


def bearing_slot(name, rng):
    """Bearing clearances for a joint."""
    return Slot(
        name,
        "bearing",
        tuple(bearing(c, p * rng.uniform(0.5, 2)) for c, p in ((45, 0), (30, 15), (12, 50))),
        PartCandidate("now", None),
    )


def link_of(arm, name, count):
    """A list of tubes for a link."""
    joint = next(joint for joint in arm.joints if joint.name == name)
    return link_slot(
        joint,
        tuple(Tube(outer=0.05 + 0.03 * k, wall=0.003) for k in range(count)),
        None,
        0.0,
        per_kg=8.0,
    )


def slots_of(arm, seed):
    """Return slots that depend on the seed, with 27 to 500 selections."""
    rng = np.random.default_rng(seed)
    kinds = [
        lambda: (gearbox_slot("j1", rng, 5), link_of(arm, "j1", 5), bearing_slot("j0", rng)),
        lambda: (
            gearbox_slot("j0", rng, 4),
            gearbox_slot("j1", rng, 4),
            link_of(arm, "j0", 4),
            bearing_slot("j1", rng),
        ),
        lambda: (
            gearbox_slot("j2", rng, 3),
            link_of(arm, "j2", 3),
            link_of(arm, "j1", 3),
            gearbox_slot("j1", rng, 3),
        ),
        lambda: (link_of(arm, "j0", 5), link_of(arm, "j1", 5), link_of(arm, "j2", 5)),
    ]
    return kinds[seed % len(kinds)]()


def every(slots):
    """Return all selections."""
    return list(itertools.product(*(range(len(slot.candidates)) for slot in slots)))


@pytest.fixture(scope="module")
def arm():
    """The chain."""
    return arm_of()


@pytest.fixture(scope="module")
def q(arm):
    """A few poses."""
    return lostmotion.sample_poses(arm, 16).q


def test_sums_over_parts_are_those_of_the_study(arm, q):
    """Bias, covariance and mean square of the sums are those of the pose matrix."""
    sums = ErrorCache(arm, q).of(arm)
    matrix = screws(state_of(arm, q))
    drawn = matrix.tool[:, 3:, matrix.columns("robot", "visit", "robot x visit")]
    covariance = np.einsum("pit,pjt->pij", drawn, drawn)
    assert np.allclose(sums[:3].T, matrix.bias[:, 3:], rtol=1e-12, atol=1e-18)
    assert np.allclose(
        sums[3:].T, covariance[:, [0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1]], rtol=1e-9, atol=1e-22
    )
    assert math.sqrt(mean_square(sums)) == pytest.approx(rms_error(arm, q), rel=1e-12)


def test_the_error_at_a_level_is_where_the_share_is(arm, q):
    """The 95 % error has 95 % of all errors below it, also for an arm without scatter, or without
    error.
    """
    sums = ErrorCache(arm, q).of(arm)
    assert share_within(sums, error_at(sums, LEVEL)) == pytest.approx(LEVEL, abs=1e-4)
    still = sums.copy()
    still[3:] = 0
    sizes = np.sort(np.linalg.norm(still[:3], axis=0))
    assert (
        sizes[int(LEVEL * len(sizes)) - 1] * (1 - 1e-4)
        <= error_at(still, LEVEL)
        <= sizes[-1] * (1 + 1e-4)
    )
    assert error_at(np.zeros_like(sums), LEVEL) == 0


def test_cached_sums_equal_new_ones(arm, q):
    """After many exchanges the sums of a selection equal those of the same arm without a cache, bit
    for bit.
    """
    slots = slots_of(arm, 1)
    search = Search(arm, slots, Objective(), q, Constraints())
    for choice in every(slots)[::7]:
        search.evaluate(choice)
    for choice in every(slots)[::23]:
        made = with_parts(arm, slots, search.evaluator.parts(choice))
        assert np.array_equal(
            search.evaluator.cache.of(search.evaluator.arm_with(choice)),
            ErrorCache(made, q).of(made),
        )


def test_one_part_at_two_joints_adds_at_both():
    """The same encoder at two unloaded joints contributes at both; its cached contribution at one
    is not used for the other.
    """
    encoder = Encoder[AngleAmount](resolution=1e-4)
    joint = {"type": "revolute", "axis": "y", "limits": (-1.2, 1.2), "encoder": encoder}
    unloaded = Arm(
        name="unloaded",
        joints=[
            joint | {"name": "a", "link": {"length": 0.3}},
            joint | {"name": "b", "link": {"length": 0.1}},
        ],
    )
    at = lostmotion.sample_poses(unloaded, 16).q
    assert unloaded.joints[0].encoder is unloaded.joints[1].encoder
    assert math.sqrt(mean_square(ErrorCache(unloaded, at).of(unloaded))) == pytest.approx(
        rms_error(unloaded, at), rel=1e-12
    )


def test_a_gearbox_takes_the_place_of_the_present_one(arm):
    """The joint's mass changes by the difference of both gearboxes; a link's mass is that of its
    section.
    """
    slots = (gearbox_slot("j1", np.random.default_rng(0), 3), link_of(arm, "j1", 3))
    made = with_parts(arm, slots, (slots[0].candidates[2], slots[1].candidates[0]))
    joint = made.joints[1]
    assert joint.mass == pytest.approx(5.0 - 3.0 + slots[0].candidates[2].mass)
    assert joint.link.total_mass == pytest.approx(slots[1].candidates[0].mass)
    assert joint.gearbox.model == "g2"


@pytest.mark.parametrize(
    "seed", [0, 1, 2, 3, *(pytest.param(k, marks=pytest.mark.slow) for k in range(4, 8))]
)
def test_the_search_finds_the_cheapest_of_all(arm, q, seed):
    """The search result is within 1 % of the cheapest of all selections that meet the target; the
    proven one is the cheapest.
    """
    rng = np.random.default_rng(seed)
    slots = slots_of(arm, seed)
    objective = (
        Objective(*((1.0, 0.0), (20.0, 1.0), (0.0, 1.0))[seed % 3])
        if seed % len(slots) != 3
        else Objective()
    )
    # What a selection costs and errs does not depend on the target: one search evaluates it once.
    search = Search(arm, slots, objective, q, Constraints())
    found = {
        choice: (search.evaluate(choice).cost, search.error(choice)) for choice in every(slots)
    }
    errors = sorted(error for _, error in found.values())
    for share in (0.05, 0.3, 0.7):
        target = float(np.quantile(errors, share)) * rng.uniform(1.0, 1.02)
        choice = search.solve(target)
        assert search.meets(choice, target)
        best = min(
            cost
            for choice, (cost, error) in found.items()
            if error <= target and search.evaluate(choice).violation <= 0
        )
        assert search.evaluate(choice).cost <= best * 1.01
        proven, is_proven = search.prove(target, choice, 1000)
        assert is_proven
        assert search.evaluate(proven).cost == pytest.approx(best, rel=1e-9)


def test_every_upgrade_is_needed(arm, q):
    """With any part replaced by a cheaper one the target is not met, and a stricter target never
    costs less.
    """
    slots = (*slots_of(arm, 1), link_of(arm, "j2", 5))
    search = Search(arm, slots, Objective(20.0, 1.0), q, Constraints())
    least, most = (
        search.error(search.most_accurate(search.cheapest())),
        search.error(search.cheapest()),
    )
    costs = []
    for target in np.geomspace(1.05 * least, 0.95 * most, 5):
        choice = search.solve(float(target))
        assert search.meets(choice, float(target))
        for k, slot in enumerate(slots):
            for index in range(len(slot.candidates)):
                other = (*choice[:k], index, *choice[k + 1 :])
                if search.evaluate(other).cost < search.evaluate(choice).cost * (1 - 1e-9):
                    assert not search.meets(other, float(target))
        costs.append(search.evaluate(choice).cost)
    assert costs == sorted(costs, reverse=True)
    assert costs[0] > costs[-1]


def test_an_unreachable_target_gets_the_most_accurate_selection(arm, q):
    """For a target that no selection meets, the result has the least error of all."""
    slots = slots_of(arm, 0)
    search = Search(arm, slots, Objective(), q, Constraints())
    choice = search.solve(1e-6)
    assert not search.meets(choice, 1e-6)
    assert search.error(choice) == pytest.approx(
        min(search.error(each) for each in every(slots)), rel=1e-9
    )


def test_gearboxes_below_the_holding_torque_are_not_selected(arm, q):
    """A gearbox rated below the holding torque with the selected masses is never selected, however
    cheap and accurate it is.
    """
    weak, strong = (
        reducer("weak", 10.0, 400, 0.01, price=1.0),
        reducer("strong", 200.0, 40, 0.5, price=500.0),
    )
    slots = (
        Slot("j1", "gearbox", (weak, strong), PartCandidate("now", None)),
        link_of(arm, "j2", 4),
    )
    search = Search(arm, slots, Objective(1.0, 1.0), q, Constraints())
    assert search.evaluator.parts(search.solve(1.0))[0].name == "strong"
    held = search.evaluator.torques(search.evaluator.arm_with((1, 0)))[1]
    level = np.abs(
        state_of(search.evaluator.arm_with((1, 0)), search.evaluator.load_q).torques[:, 1]
    ).max()
    assert held == pytest.approx(level, rel=1e-12)
    # rated between the holding torques with light and with heavy links outboard: only light ones
    # are feasible
    between = (held + search.evaluator.torques(search.evaluator.arm_with((1, 3)))[1]) / 2
    tight = Slot(
        "j1",
        "gearbox",
        (reducer("tight", float(between), 40, 0.5, price=1.0),),
        PartCandidate("now", None),
    )
    search = Search(arm, (tight, link_of(arm, "j2", 4)), Objective(0.0, 1.0), q, Constraints())
    assert search.evaluate((0, 0)).violation == 0
    assert search.evaluate((0, 3)).violation > 0
    tilted = Search(
        arm, (tight, link_of(arm, "j2", 4)), Objective(0.0, 1.0), q, Constraints(tilt=0.5)
    )
    assert tilted.evaluate((0, 0)).violation >= search.evaluate((0, 0)).violation


def test_a_loose_target_with_limits_gives_the_lightest_sections_within_them(arm, q):
    """With limits of the links as constraints and a target that is always met, the lightest
    sections within the limits are selected.
    """
    stock = tuple(Tube(outer=0.06 + 0.03 * k, wall=0.003) for k in range(5))
    limits = Limits(0.5 * ARCMIN, 2500.0)
    slots = tuple(link_slot(joint, stock, None, 0.0) for joint in arm.joints)
    sized = size_links(
        arm, {joint.name: LinkOptions(stock) for joint in arm.joints}, limits, Poses(q, "given")
    )
    search = Search(arm, slots, Objective(), sized.q, Constraints(limits))
    choice = search.solve(1.0)
    assert [each.part for each in search.evaluator.parts(choice)] == [
        link.section for link in sized.links
    ]


def test_sections_between_those_of_the_grid_are_found(arm, q):
    """Refinement of a coarse grid is cheaper than the grid, and within 2 % of the best of a fine
    list.
    """
    family = TubeFamily(outer="40 mm .. 160 mm", wall="3 mm")
    joint = arm.joints[1]
    slot = link_slot(joint, family, None, 1e-4)
    assert all(refined_candidates(joint, slot, each, 1.05) for each in slot.candidates)
    search = Search(arm, (slot,), Objective(), q, Constraints())
    target = (search.error((0,)) + search.error((len(slot.candidates) - 1,))) / 2
    coarse = search.solve(target)
    fine = search.refine(target, coarse)
    assert search.evaluate(fine).cost < search.evaluate(coarse).cost
    stock = tuple(Tube(outer=0.04 + 0.002 * k, wall=0.003) for k in range(61))
    listed = Search(arm, (link_slot(joint, stock, None, 0.0),), Objective(), q, Constraints())
    best = min(listed.evaluate((k,)).cost for k in range(61) if listed.meets((k,), target))
    assert search.evaluate(fine).cost == pytest.approx(best, rel=0.02)
    both = link_slot(joint, TubeFamily(outer="40 mm .. 160 mm", wall="2 mm .. 6 mm"), None, 1e-4)
    assert 5 < len(both.candidates) <= 14
    masses = [each.mass for each in both.candidates]
    assert masses == sorted(masses)


def test_a_part_without_a_solution_is_not_selected(arm, q, monkeypatch):
    """Where a part has no solution under its load, the error of that selection is infinite and the
    search avoids it.
    """
    slots = slots_of(arm, 0)
    search = Search(arm, slots, Objective(), q, Constraints())
    bad = slots[0].candidates[0].part
    terms = Reducer.terms

    def failing(self, at):
        if self is bad:
            raise lostmotion.errors.DidNotConvergeError("no solution")
        return terms(self, at)

    monkeypatch.setattr(Reducer, "terms", failing)
    choice = search.solve(1.0)
    assert choice[0] != 0
    assert math.isinf(search.error((0, *choice[1:])))
