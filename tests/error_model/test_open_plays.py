"""Plays of passive joints of a closed chain that the reaction does not close."""

from pathlib import Path

import numpy as np
import pytest

import lostmotion
from lostmotion.error_model.open_plays import open_play_remarks, open_plays
from tests.mechanism.closed_chains import at, five_bar

# Forces in the pins of the five-bar under 2 kg, N, by virtual work.
FORCES = {"e1": 14.417371, "e2": 14.861590, "pin": 13.321713}


def loose(closing_force):
    """Return the five-bar with pins in two seats each, which this force on a seat closes, N."""
    bearing = {"kind": "rolling", "clearance": "20 µm", "span": "40 mm"}
    return five_bar(bearing=bearing | {"closing_force": f"{closing_force} N"})


@pytest.mark.parametrize("force", [6.5, 7.0, 7.3, 7.5])
def test_a_play_is_open_below_its_closing_force(force):
    """Each of both seats of a pin carries half of its reaction, which virtual work has."""
    state = at(loose(force), (2.2, 0.9), gravity=np.array([0, -9.80665, 0]))
    found = {name: bool(each[0]) for name, each in open_plays(state).items()}
    assert found == {name: whole / 2 < force for name, whole in FORCES.items()}


def test_the_notes_state_the_share_of_poses_with_open_plays():
    """Pins that no load closes are open at all poses; those of the example carry enough."""
    (note,) = open_play_remarks(loose(1e6))
    assert "at 100 % of" in note
    assert all(f"{name} 100 %" in note for name in FORCES)
    assert "at 100 % of" in open_play_remarks(loose("1e6 N ± 0"))[0]
    example = Path(__file__).parents[2] / "examples" / "closed-chains" / "five-bar.toml"
    assert open_play_remarks(lostmotion.read(example)) == ()
