"""The state of an arm where its places really stand: wrenches, carry matrices and first-order errors
there, from energies and from exact composition.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model.pose_matrix import screws
from lostmotion.mechanism.inverse import pose_difference
from lostmotion.mechanism.places import PlacedMass
from lostmotion.mechanism.state import state_of, states_of
from lostmotion.spatial import exp
from tests.error_model.arms import SEEDS
from tests.mechanism.test_places import random_tree
from tests.parts.random_arms import EXAMPLES, random_arm, random_poses

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "errors of an arm that stands beside its nominal geometry",
        "differences of exactly composed frames, seven arms with every kind of part",
        "1e-8",
        "mechanism/state.py",
    ),
    (
        "wrenches in an arm that stands beside its nominal geometry",
        "differences of the potential energy, 8 random arms with branches",
        "1e-6",
        "mechanism/wrenches.py",
    ),
)


def standing(arm, q, *twists):
    """Return all frames (place, pose, 4, 4) with every place displaced by twists (place, 6), or
    (place, pose, 6), in its axes, one after the other: parent by parent, from the description of
    each joint.
    """
    out = np.empty((len(arm.places), len(q), 4, 4))
    column = {place: k for k, place in enumerate(arm.tree.moved)}
    for k, place in enumerate(arm.tree.places):
        out[k] = out[place.parent] @ place.pose if k else np.eye(4)
        if k in column:
            out[k] = out[k] @ exp(arm.driven[column[k]].twist * q[:, column[k], None])
        for each in twists:
            out[k] = out[k] @ exp(each[k])
    return out


def displaced(rng, arm):
    """Draw a twist of each place, up to 50 mrad and 50 mm."""
    return 0.05 * rng.uniform(-1, 1, (len(arm.places), 6))


@pytest.mark.parametrize("seed", SEEDS)
def test_errors_are_linearised_where_the_arm_stands(seed):
    """The pose matrix of an arm that stands beside its nominal geometry is the derivative of its
    exact composition there, and not that of the nominal geometry.
    """
    arm, rng = random_arm(seed), np.random.default_rng(seed)
    q, off, step = random_poses(arm, 3), displaced(rng, arm), 1e-6
    found = screws(state_of(arm, q, frames=standing(arm, q, off)))
    for k in rng.permutation(len(found.infos))[:8]:
        size = np.abs(found.local[:, :, k]).max(axis=1, keepdims=True)
        size[size == 0] = 1.0
        ahead = np.zeros((len(off), len(q), 6))
        ahead[found.place[k]] = step * found.local[:, :, k] / size
        one, other = (standing(arm, q, off, each)[-1] for each in (ahead, -ahead))
        slope = pose_difference(other, one) / (2 * step)
        np.testing.assert_allclose(found.tool[:, :, k] / size, slope, atol=1e-8)
    assert np.abs(found.tool - screws(state_of(arm, q)).tool).max() > 0


@pytest.mark.parametrize("seed", range(8))
def test_exact_composition_leads_to_where_the_tool_stands(seed):
    """The tool of places that are displaced in the nominal geometry is that of the displaced arm,
    for displacements of any size and with branches.
    """
    rng = np.random.default_rng(seed)
    arm = random_tree(rng)
    q, off = rng.uniform(-2, 2, (2, len(arm.driven))), 20 * displaced(rng, arm)
    places = range(len(arm.places))
    twists = np.broadcast_to(off[:, None, None], (len(off), len(q), 1, 6))
    np.testing.assert_allclose(
        state_of(arm, q).composed(places, twists)[:, 0],
        standing(arm, q, off)[-1],
        atol=1e-12,
    )


def energy(arm, at, masses):
    """Return the potential energy (J) at the first pose of the frames."""
    return -sum(
        weight.mass * arm.gravity_in_base @ (at[weight.at, 0] @ [*weight.centre, 1])[:3]
        for weight in masses
    )


@pytest.mark.parametrize("seed", range(8))
def test_wrenches_are_the_slope_of_the_energy_where_the_arm_stands(seed):
    """The wrench on each place of a displaced arm is the work of the weights on it and outboard of
    it per small displacement of that place.
    """
    rng = np.random.default_rng(seed)
    arm = random_tree(rng)
    q, off, step = rng.uniform(-1, 1, (1, len(arm.driven))), displaced(rng, arm), 1e-6
    at = standing(arm, q, off)
    found, tool = state_of(arm, q, frames=at).wrenches, len(arm.places) - 1
    payload = PlacedMass(tool, tool, arm.payload.mass, np.array(arm.payload.centre_of_mass))
    masses = [*arm.tree.masses, payload]
    for k in range(len(arm.places)):
        outboard = [weight for weight in masses if weight.on in arm.tree.outboard(k)]
        for axis in range(6):
            small = step * np.eye(6)[axis] * np.array([[1.0], [-1.0]])
            one, other = (_carried(at, k, twist) for twist in small)
            slope = (energy(arm, one, outboard) - energy(arm, other, outboard)) / (2 * step)
            assert found[k, 0, axis] == pytest.approx(-slope, abs=1e-6)


def _carried(at, place, twist):
    """Return the frames after a small motion of one place, with all masses on it and outboard."""
    motion = at[place] @ exp(twist) @ np.linalg.inv(at[place])
    return motion @ at


@pytest.mark.parametrize("name", ["z-arm.toml", "gantry.toml", "arm-from-drawings.toml"])
def test_blocks_of_poses_are_the_poses_together(name):
    """A pose has the same bits alone, in a block and among all others."""
    arm = lostmotion.read(EXAMPLES / name)
    q = random_poses(arm, 10)
    whole = state_of(arm, q)
    for here, state in states_of(arm, q, 4):
        np.testing.assert_array_equal(state.q, q[here])
        for one in (state, whole.rows(here)):
            np.testing.assert_array_equal(one.frames, whole.frames[:, here])
            np.testing.assert_array_equal(one.wrenches, whole.wrenches[:, here])
            np.testing.assert_array_equal(one.torques, whole.torques[here])
            np.testing.assert_array_equal(one.sag, whole.sag[here])
            np.testing.assert_array_equal(one.compliance, whole.compliance[here])


def test_a_state_does_not_follow_changes_of_what_it_was_built_from():
    """Joint values and frames are copied, and the arrays of a state are read-only."""
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    q = random_poses(arm, 2)
    at = standing(arm, q)
    state = state_of(arm, q, frames=at)
    before = state.frames.copy()
    q[:], at[:] = 0.0, 0.0
    np.testing.assert_array_equal(state.frames, before)
    assert state.q.any()
    for array in (state.q, state.frames, state.gravity):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0
    tilted = dataclasses.replace(state, gravity=np.array([0.0, 9.81, 0.0]))
    assert np.abs(tilted.wrenches - state.wrenches).max() > 1


@pytest.mark.parametrize("wrong", [np.zeros((3, 2, 4, 4)), np.eye(4), None])
def test_frames_of_another_arm_are_refused(wrong):
    """Frames handed in are one per place and pose, and finite; the message states both shapes."""
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    q = random_poses(arm, 2)
    frames = standing(arm, q) * np.nan if wrong is None else wrong
    with pytest.raises(ValueError, match=r"frames of shape .* expected \(\d+, 2, 4, 4\)"):
        state_of(arm, q, frames=frames)


def test_a_place_has_as_many_unit_motions_as_freedoms():
    """A fixed frame has no freedom, a driven joint has one, which is a column of q."""
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    for place in arm.tree.places:
        assert place.twist.shape == (6, 0 if place.joint is None else 1)
    assert [arm.tree.places[k].joint for k in arm.tree.moved] == list(range(len(arm.driven)))


@pytest.mark.parametrize("name", ["frames", "wrenches", "compliance", "deflection"])
def test_a_former_name_says_what_has_its_place(name):
    """Functions of (arm, q) that a state replaced: the message names its property or method, which
    exists.
    """
    with pytest.raises(AttributeError, match=rf"use lostmotion\.state_of\(arm, q\)\.{name}\b"):
        getattr(lostmotion, name)
    assert hasattr(lostmotion.State, name) or name in lostmotion.State.__dataclass_fields__
