"""Tables of a gearbox mark figures that rest on kinds of error that nothing describes."""

import pytest

import lostmotion
from lostmotion.reporting.layout import key_of, row_at

# Exact contours: no relief, clearance, tolerance or friction.
DRAWING = {
    "kind": "cycloidal",
    "form": "lobe arcs",
    "rated_torque": "100 N m",
    "pins": 20,
    "ring_radius": "50 mm",
    "pin_radius": "3 mm",
    "eccentricity": "1.2 mm",
    "width": "10 mm",
    "disc_bore_radius": "20 mm",
    "ring_outer_radius": "60 mm",
    "rigid": ["frame", "input shaft", "eccentric shaft", "eccentric bearing", "output pins"],
}


def bound_of(sheet, section, row):
    """Return the bound of the first figure of a row."""
    return row_at(sheet.sections, section, key_of(row)).cells[0].bound


def test_a_drawing_without_tolerances_bounds_every_table():
    """Play, lost motion, wind-up and transmission error of an exact drawing are the least that a
    real one has, in the tables as in the cards; its stiffness is the most.
    """
    sheet = lostmotion.gear({"gearbox": DRAWING}, gearboxes=4).sheet
    for section, row in (
        ("built", "play: mean"),
        ("built", "lost motion: 95th percentile"),
        ("built", "wind-up: median"),
        ("loop", "play"),
        ("loop", "friction's loop alone"),
        ("loop", "whole loop at zero torque"),
        ("loop", "lost motion"),
        ("transmission", "peak to peak"),
        ("transmission", "root mean square"),
    ):
        assert bound_of(sheet, section, row) == "lower", (section, row)
    assert bound_of(sheet, "built", "stiffness: mean") == "upper"
    cards = {card.title: card.number for card in sheet.cards}
    assert all(
        cards[name].startswith("≥ ")
        for name in ("play", "lost motion", "wind-up", "transmission error")
    )


def test_tolerances_end_the_bound():
    """A drawing with relief and tolerances predicts its play."""
    drawing = DRAWING | {"relief": {"roller": "10 µm ± 3 µm"}, "pin_position": "2 µm"}
    sheet = lostmotion.gear({"gearbox": drawing}, gearboxes=4).sheet
    assert bound_of(sheet, "loop", "play") == bound_of(sheet, "built", "play: mean") == ""
    assert bound_of(sheet, "transmission", "peak to peak") == ""
    assert bound_of(sheet, "loop", "friction's loop alone") == "lower"


STIFF = {"ratio": 100, "rated_torque": "100 N m", "stiffness": "20 N m/arcmin"}


@pytest.mark.parametrize(
    ("more", "play", "loop", "lost"),
    [
        ({}, "lower", "lower", "lower"),
        ({"backlash": "0 arcmin"}, "", "lower", ""),
        ({"backlash": "0 arcmin", "hysteresis": "0 arcmin"}, "", "", ""),
        ({"stiffness": None, "backlash": "1 arcmin"}, "", "lower", "lower"),
        ({"stiffness": None, "rigid": True, "backlash": "1 arcmin"}, "", "lower", ""),
    ],
)
def test_what_no_figure_states_is_no_zero(more, play, loop, lost):
    """Missing play, stiffness or hysteresis of stated gearboxes makes what rests on it a lower
    bound; a stated zero and `rigid` do not.
    """
    stated = {key: value for key, value in (STIFF | more).items() if value is not None}
    sheet = lostmotion.gear({"gearbox": stated}).sheet
    assert bound_of(sheet, "loop", "play") == play
    assert bound_of(sheet, "loop", "friction's loop alone") == loop
    assert bound_of(sheet, "loop", "lost motion") == lost
    assert ("Play 0" in sheet.verdict) == (more.get("backlash") == "0 arcmin")
