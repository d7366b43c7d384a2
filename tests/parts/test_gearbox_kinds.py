"""Kinds of gearboxes: their ratios, what their teeth add to the printed figures, and how a joint enters them."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from lostmotion.parts.encoder import Encoder
from lostmotion.parts.gearbox.catalogue import CatalogueGearbox
from lostmotion.parts.gearbox.planetary import PlanetaryGearbox
from lostmotion.parts.joint import RevoluteJoint
from lostmotion.parts.lumped import Lumped
from lostmotion.parts.source import Grouped
from tests.parts.conditions import condition, design, drawn, gearbox, visit_size

PLANETARY = {"kind": "planetary", "sun_teeth": 20, "ring_teeth": 70}


def joint(**fields: object) -> RevoluteJoint:
    """Give a turning joint."""
    return RevoluteJoint.model_validate({"name": "A", "limits": (-1, 1), **fields})


def why(**fields: object) -> dict[str, str]:
    """Give what is said of a gearbox that cannot be."""
    with pytest.raises(ValidationError) as caught:
        gearbox(**fields)
    (detail,) = caught.value.errors()
    return detail["ctx"]


def test_a_gearbox_without_a_kind_is_one_by_catalogue():
    """The kind may be left out, and be stated; another kind is another part."""
    assert isinstance(gearbox(ratio=3), CatalogueGearbox)
    assert gearbox(ratio=3) == gearbox(kind="catalogue", ratio=3)
    assert isinstance(gearbox(**PLANETARY), PlanetaryGearbox)
    made = gearbox(**PLANETARY)
    assert joint(gearbox=made).gearbox is made


def test_a_motor_encoder_takes_the_ratio_that_the_teeth_give():
    """Behind a planetary stage of 20 and 70 teeth an encoder's noise is 4.5 times smaller at the output; one of its own goes first."""
    found = joint(gearbox=PLANETARY, encoder={"noise": 9e-4}).sources["encoder"]
    assert isinstance(found, Encoder)
    assert found.ratio == 4.5
    own = joint(gearbox=PLANETARY, encoder={"noise": 9e-4, "ratio": 2}).sources["encoder"]
    assert own.ratio == 2


def test_an_encoder_on_the_output_silences_every_kind():
    """What the gearbox does wrong is inside the loop, whatever its kind."""
    assert set(joint(gearbox=PLANETARY, encoder={"side": "output"}).sources) == {"encoder"}


def test_a_part_of_several_sources_is_entered_by_each(monkeypatch: pytest.MonkeyPatch):
    """A gearbox with members is counted member by member, under its own name and theirs."""
    members = {"eccentric bearing": Lumped(angle=1e-3), "pins": Lumped(angle=2e-3)}
    monkeypatch.setattr(PlanetaryGearbox, "members", members, raising=False)
    made = joint(gearbox=PLANETARY, lumped={"angle": 1e-3})
    assert isinstance(made.gearbox, Grouped)
    assert list(made.sources) == ["gearbox eccentric bearing", "gearbox pins", "lumped"]
    assert made.sources["gearbox pins"] is members["pins"]
    assert set(joint(gearbox=PLANETARY, encoder={"side": "output"}).sources) == {"encoder"}


def test_every_kind_takes_the_printed_figures():
    """Wind-up, play and hysteresis are those of the same gearbox by catalogue."""
    figures = {"stiffness": [1e4, 2e4], "zone_torques": [5.0], "backlash": 1e-3, "hysteresis": 1e-4, "rated_torque": 50.0, "transmission_error": 1e-4}
    for load in ((0, 0, 0, 0, 0, 0), (0, 0, 30.0, 0, 0, 0)):
        here = condition(load)
        by_kind, by_catalogue = gearbox(**PLANETARY, **figures).terms(here), gearbox(**figures).terms(here)
        np.testing.assert_array_equal(design(by_kind), design(by_catalogue))
        assert visit_size(by_kind) == visit_size(by_catalogue)
        assert [term.name for term in by_kind] == [term.name for term in by_catalogue]


def spectrum(part, turns: int) -> dict[float, float]:
    """Give the amplitude of every wave of a gearbox's output over so many whole turns, by its cycles per turn."""
    samples = 4096
    angles = np.linspace(0, 2 * np.pi * turns, samples, endpoint=False)
    lines = np.abs(np.fft.rfft(drawn(part.terms(condition(angle=angles)), 1, poses=samples)[0, :, 2])) / (samples / 2)
    return {k / turns: float(line) for k, line in enumerate(lines) if line > 1e-12}


def test_a_planetary_stage_errs_as_often_as_its_wheels_turn():
    """With the ring held and 20, 25 and 70 teeth, per turn of the carrier: the sun 3.5 turns against it, a planet 2.8, the teeth 70 times."""
    part = gearbox(**PLANETARY, sun_error=1e-5, planet_error=2e-5, ring_error=3e-5, mesh_error=4e-5)
    found = spectrum(part, 10)
    assert found == pytest.approx({1.0: 3e-5, 2.8: 2e-5, 3.5: 1e-5, 70.0: 4e-5}, rel=1e-9)


@pytest.mark.parametrize(
    ("fields", "found", "example"),
    [
        ({"planet_teeth": 24}, "planet 24 teeth", "sun_teeth = 20, planet_teeth = 24, ring_teeth = 68"),
        ({"ring_teeth": 71}, "no whole planet", "sun_teeth = 20, planet_teeth = 25, ring_teeth = 70"),
        ({"ring_teeth": 20}, "no whole planet", "sun_teeth = 20, planet_teeth = 1, ring_teeth = 22"),
        ({"planets": 4}, "4 planets with sun + ring = 90", "planets = 3"),
        ({"planets": 7}, "7 planets with sun + ring = 90", "planets = 5"),
        ({"planets": 6}, "6 planets of 25 teeth around a sun of 20", "planets = 5"),
    ],
)
def test_a_planetary_stage_that_cannot_be_put_together_is_refused(fields: dict[str, int], found: str, example: str):
    """Teeth that do not reach, planets that do not go in, planets that touch: each with the nearest that does."""
    said = why(**{**PLANETARY, **fields})
    assert found in said["why"]
    assert said["example"] == example


@pytest.mark.parametrize("value", [0, -3, 20.5, "x", True, 1e9, "20 mm"])
def test_teeth_are_counted(value: object):
    """Teeth are whole, and at least one."""
    assert why(**{**PLANETARY, "sun_teeth": value})["expected"] == "a whole number from 1 to 10000"
