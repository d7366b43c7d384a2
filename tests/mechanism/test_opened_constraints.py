"""Over-constrained chains with plays that open a constraint: a bar on three rods, and a coupler on
three parallel cranks with a loose pin.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model.opened_constraints import (
    open_matrices,
    redundant_plays,
    with_larger_error,
)
from lostmotion.error_model.pose_matrix import screws
from lostmotion.io import read
from lostmotion.io.native import arm_of
from lostmotion.mechanism.even_poses import few_even_poses
from lostmotion.mechanism.state import state_of
from tests.mechanism.closed_chains import arm, at, link, moved, wrench, xyz
from tests.mechanism.test_closed_other_mechanisms import ANGLE, frame, three_cranks
from tests.mechanism.test_closed_reference import constants, metal

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "compliance of a coupler on three parallel cranks with one pin loose in its play",
        "a displacement method for beams, with fewer constraints at this pin",
        "1e-4",
        "mechanism/opened_constraints.py",
    ),
    (
        "a bar on three rods, the middle one with play, under loads that close it or not",
        "the least energy of springs and play, by hand",
        "1e-4",
        "mechanism/opened_constraints.py",
    ),
)

EXAMPLES = Path(__file__).parents[2] / "examples" / "closed-chains"
PIN = {"kind": "rolling", "clearance": "20 µm", "span": "40 mm"}
STIFFNESS, HALF = 1e6, 50e-6


def bar_on_three_rods(load: float):
    """Return a bar on three upright rods of 1 N/µm; the hinge on the middle one has ±50 µm of play.
    Slots let the bar slide on the second and third. A drive turns all of it.
    """
    young, length = 200e9, 0.2
    section = constants(STIFFNESS * length / young, 1e-4, 1e-4, 1e-4, 0.5)
    rod = {"type": "fixed", "after": "turn"}
    rod["link"] = link(length, "z", section=section, material=metal(200, 77))
    hinge = {"type": "revolute", "axis": "y", "passive": True}
    slot = {"type": "prismatic", "axis": "x", "passive": True, "limits": ["-50 mm", "50 mm"]}
    play = {"kind": "rolling", "clearance": "100 µm", "span": "40 mm", "closing_force": "0 N"}
    return arm(
        joints=[
            {"name": "turn", "type": "revolute", "axis": "z", "limits": ["-1 rad", "1 rad"]},
            {**rod, "name": "left"},
            {**hinge, "name": "left hinge"},
            {"name": "half", "type": "fixed", "link": link(0.3)},
            {"name": "other half", "type": "fixed", "link": link(0.3)},
            {**rod, "name": "middle", "origin": xyz(0.3, 0, 0)},
            {**hinge, "name": "middle hinge", "bearing": play},
            {**slot, "name": "middle slot"},
            {**rod, "name": "right", "origin": xyz(0.6, 0, 0)},
            {**hinge, "name": "right hinge"},
            {**slot, "name": "right slot"},
        ],
        closures=[
            {"joins": ["half.tip", "middle slot"]},
            {"joins": ["other half.tip", "right slot"]},
        ],
        tool={"after": "half.tip"},
        payload={"mass": f"{load / 10} kg"},
        gravity="10 m/s^2",
    )


MIDDLE = "joints.middle hinge.bearing"


@pytest.mark.parametrize(
    ("load", "down", "is_open"),
    [(20, 10, True), (99, 49.5, True), (200, 250 / 3, False), (600, 650 / 3, False)],
)
def test_a_bar_on_three_rods_sinks_as_springs_and_play_have_it(load, down, is_open):
    """Below 100 N the middle rod carries nothing, beyond it the play is closed. The state that
    holds is one of the two that are computed, and an open one that the load closes is excluded.
    """
    closed = bar_on_three_rods(load)
    state = at(closed.with_open_play(MIDDLE) if is_open else closed, 0.0)
    np.testing.assert_allclose(screws(state).bias[0, 5], -down * 1e-6, rtol=1e-4)
    if is_open:
        assert wrench(state, "middle")[5] == pytest.approx(0, abs=1e-4 * load)
    q = np.zeros((1, 1))
    found = list(open_matrices(closed, q, redundant_plays(closed, q)))
    assert found == ([MIDDLE] if is_open else [])


def test_the_larger_error_counts_and_the_arm_says_so():
    """The closed bar sinks farther wherever the play may be open; a five-bar with a light load errs
    more with its pin open; a load that closes every play leaves nothing to open.
    """
    light = with_larger_error(bar_on_three_rods(20))
    assert not light.open_ways
    assert light.remarks[-1].endswith("less than with all closed. All figures are with all closed")
    heavy = with_larger_error(bar_on_three_rods(600))
    assert not heavy.open_ways
    assert "carry every part across its play" in heavy.remarks[-1]
    text = (EXAMPLES / "five-bar.toml").read_text().replace('mass = "2 kg"', 'mass = "0.1 kg"')
    five_bar = arm_of("five-bar.toml", tomllib.loads(text))
    looser = with_larger_error(five_bar)
    assert [way.part for way in looser.open_ways] == ["joints.pin.bearing"]
    assert "All figures are with those of pin.bearing open" in looser.remarks[-1]
    q = few_even_poses(five_bar)[::16]
    squares = [
        screws(state_of(each, q)).merged.level_squares.sum(axis=1).mean()
        for each in (five_bar, looser)
    ]
    assert squares[1] > 1.05 * squares[0]
    delta = read(EXAMPLES / "delta-printer.toml")
    assert with_larger_error(delta) is delta


def test_a_question_answers_for_the_larger_error(tmp_path):
    """Also a design of a sweep; a study of the closed chain alone has a smaller error."""
    text = (EXAMPLES / "five-bar.toml").read_text().replace('mass = "2 kg"', 'mass = "0.1 kg"')
    file = tmp_path / "five-bar.toml"
    file.write_text(text)
    given = {"poses": 32, "robots": 4, "visits": 2}
    found = lostmotion.study(file, **given)
    assert any("pin.bearing open" in note for note in found.sheet.notes)
    swept = lostmotion.sweep(
        file, by={"payload.mass": ["0.1 kg", "2 kg"]}, out=tmp_path / "run", **given
    )
    same = swept.outcomes[0].figures["rms"].value
    assert same == pytest.approx(found.figures["rms"].value, rel=1e-9)


def test_a_coupler_with_a_loose_pin_deflects_as_a_displacement_method_has_it():
    """A pin in its play holds neither tilts nor a shift along its crank: two cranks hold those."""
    loose = three_cranks(bearing=PIN).with_open_play("joints.near end.bearing")
    state = at(loose, ANGLE)
    expected = np.array([frame(np.roll(row, 3), loose=True) for row in np.eye(6)]).T
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    np.testing.assert_allclose(state.compliance[0] / scale, expected / scale, atol=2e-6)
    held = np.array([frame(np.roll(row, 3)) for row in np.eye(6)]).T
    assert (np.diag(expected) > 1.01 * np.diag(held)).any()
    long = moved(state, "far.tip", 0, 0, 0, 1, 0, 0)
    np.testing.assert_allclose(long, frame(np.zeros(6), 1.0, loose=True), atol=1e-5)


def test_a_chain_with_a_loose_pin_closes_again_as_first_order_says():
    """Errors put into the places, and the closures met again by Newton's method."""
    state = at(three_cranks(bearing=PIN).with_open_play("joints.near end.bearing"), ANGLE)
    place, size = state.arm.places.index("far.tip"), 1e-5
    twists = np.zeros((1, 1, 2, 6))
    twists[0, 0, :, 3] = size, -size
    plus, minus = state.composed([place], twists)[0]
    shift = (plus[:3, 3] - minus[:3, 3]) / (2 * size)
    np.testing.assert_allclose(shift, state.carry(place)[0][3:, 3], atol=1e-6)
