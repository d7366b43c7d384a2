"""Kinds of gearboxes: their ratios, what their teeth add to the printed figures, and how a joint
enters them.
"""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from lostmotion.parts.encoder import Encoder
from lostmotion.parts.error_source import Grouped
from lostmotion.parts.gearbox.catalogue import CatalogueGearbox
from lostmotion.parts.gearbox.planetary import PlanetaryGearbox
from lostmotion.parts.joint import RevoluteJoint
from lostmotion.parts.lumped import Lumped
from lostmotion.units import Toleranced
from tests.parts.conditions import ARCMIN, condition, design, drawn, gearbox, terms_at, visit_size

PLANETARY = {"kind": "planetary", "sun_teeth": 20, "ring_teeth": 70}


def joint(**fields: object) -> RevoluteJoint:
    """Return a turning joint."""
    return RevoluteJoint.model_validate({"name": "A", "limits": (-1, 1), **fields})


def why(**fields: object) -> dict[str, str]:
    """Return the message about an impossible gearbox."""
    with pytest.raises(ValidationError) as caught:
        gearbox(**fields)
    (detail,) = caught.value.errors()
    return detail["ctx"]


def numbers(example: str) -> dict[str, int]:
    """Read an example back."""
    return {name: int(value) for name, value in (each.split(" = ") for each in example.split(", "))}


def test_a_gearbox_without_a_kind_is_one_by_catalogue():
    """The kind may be omitted, and be stated; another kind is another part."""
    assert isinstance(gearbox(ratio=3), CatalogueGearbox)
    assert gearbox(ratio=3) == gearbox(kind="catalogue", ratio=3)
    assert isinstance(gearbox(**PLANETARY), PlanetaryGearbox)
    made = gearbox(**PLANETARY)
    assert joint(gearbox=made).gearbox is made


def test_a_motor_encoder_takes_the_ratio_that_the_teeth_give():
    """Behind a planetary stage of 20 and 70 teeth an encoder's noise is 4.5 times smaller at the
    output; one of its own goes first.
    """
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
    figures = {
        "stiffness": [1e4, 2e4],
        "zone_torques": [5.0],
        "backlash": 1e-3,
        "hysteresis": 1e-4,
        "rated_torque": 50.0,
        "transmission_error": 1e-4,
    }
    for load in ((0, 0, 0, 0, 0, 0), (0, 0, 30.0, 0, 0, 0)):
        here = condition(load)
        by_kind, by_catalogue = (
            terms_at(gearbox(**PLANETARY, **figures), here),
            terms_at(gearbox(**figures), here),
        )
        np.testing.assert_array_equal(design(by_kind), design(by_catalogue))
        assert visit_size(by_kind) == visit_size(by_catalogue)
        assert [term.name for term in by_kind] == [term.name for term in by_catalogue]


def spectrum(part, turns: int) -> dict[int, float]:
    """Return the amplitude of every harmonic of a gearbox's output over so many whole turns, by its
    total cycles; beyond 2048 less 4096.
    """
    samples = 4096
    angles = np.linspace(0, 2 * np.pi * turns, samples, endpoint=False)
    lines = np.abs(
        np.fft.rfft(drawn(terms_at(part, condition(angle=angles)), 1, poses=samples)[0, :, 2])
    ) / (samples / 2)
    return {k: float(line) for k, line in enumerate(lines) if line > 1e-12}


def test_a_planetary_stage_errs_as_often_as_its_wheels_turn():
    """With the ring held and 20, 25 and 70 teeth, per turn of the carrier: the sun 3.5 turns
    against it, a planet 2.8, the teeth 70 times.
    """
    part = gearbox(**PLANETARY, sun_error=1e-5, planet_error=2e-5, ring_error=3e-5, mesh_error=4e-5)
    found = spectrum(part, 10)
    assert found == pytest.approx({10: 3e-5, 28: 2e-5, 35: 1e-5, 700: 4e-5}, rel=1e-9)


@pytest.mark.parametrize(
    ("fields", "found", "example"),
    [
        (
            {"planet_teeth": 24},
            "planet 24 teeth",
            "sun_teeth = 20, planet_teeth = 24, ring_teeth = 68, planets = 2",
        ),
        (
            {"ring_teeth": 71},
            "no whole planet",
            "sun_teeth = 20, planet_teeth = 25, ring_teeth = 70",
        ),
        (
            {"ring_teeth": 20},
            "no whole planet",
            "sun_teeth = 20, planet_teeth = 1, ring_teeth = 22",
        ),
        ({"planets": 4}, "4 planets with sun + ring = 90", "planets = 3"),
        ({"planets": 7}, "7 planets with sun + ring = 90", "planets = 5"),
        ({"planets": 6}, "6 planets of 25 teeth around a sun of 20", "planets = 5"),
    ],
)
def test_a_planetary_stage_that_cannot_be_put_together_is_refused(
    fields: dict[str, int], found: str, example: str
):
    """Teeth that do not reach, planets that do not go in, planets that touch: each with the nearest
    that does.
    """
    said = why(**{**PLANETARY, **fields})
    assert found in said["why"]
    assert said["example"] == example
    assert gearbox(**{**PLANETARY, **fields, **numbers(example)})


@pytest.mark.parametrize("value", [0, -3, 20.5, "x", True, 1e9, "20 mm"])
def test_teeth_are_counted(value: object):
    """Teeth are whole, and at least one."""
    assert why(**{**PLANETARY, "sun_teeth": value})["expected"] == "a whole number from 1 to 10000"


WOLFROM = {
    "kind": "wolfrom",
    "sun_teeth": 18,
    "planet_teeth": 36,
    "fixed_ring_teeth": 90,
    "output_planet_teeth": 33,
    "output_ring_teeth": 87,
}
STRAIN_WAVE = {"kind": "strain wave", "flexspline_teeth": 200, "circular_spline_teeth": 202}
WORM = {"kind": "worm", "starts": 2, "wheel_teeth": 60}


@pytest.mark.parametrize(
    ("fields", "ratio"),
    [
        (PLANETARY, 4.5),
        (WOLFROM, 116.0),
        ({**WOLFROM, "output_ring_teeth": 80}, 6 / (1 - 90 * 33 / (36 * 80))),
        (STRAIN_WAVE, -100.0),
        ({**STRAIN_WAVE, "held": "flexspline"}, 101.0),
        (WORM, 30.0),
    ],
)
def test_a_ratio_follows_from_the_teeth(fields: dict[str, object], ratio: float):
    """Each kind has the ratio of its law; an encoder on the motor counts turns, whichever way they
    go.
    """
    assert gearbox(**fields).ratio == pytest.approx(ratio, rel=1e-14)
    assert joint(gearbox=fields, encoder={"noise": 1e-3}).sources["encoder"].ratio == pytest.approx(
        abs(ratio), rel=1e-14
    )


def test_a_wolfrom_gearbox_errs_as_often_as_its_wheels_turn():
    """Of ratio 116 with a carrier at 116/6 = 58/3: sun 96 2/3, planet 48 1/3 turns against it, 1740
    and 1595 teeth, per turn of the output.
    """
    part = gearbox(
        **WOLFROM, sun_error=1e-5, planet_error=2e-5, first_mesh_error=3e-5, second_mesh_error=4e-5
    )
    cycles = {name: count for name, _, count in part._own_harmonics()}
    assert cycles == pytest.approx(
        {"sun": 290 / 3, "planet": 145 / 3, "first mesh": 1740.0, "second mesh": 1595.0}, rel=1e-12
    )
    assert spectrum(part, 3) == pytest.approx(
        {290: 1e-5, 145: 2e-5, 3 * 1740 - 4096: 3e-5, 3 * 1595 - 4096: 4e-5}, rel=1e-9
    )


def test_a_wave_generator_errs_twice_a_turn():
    """At ratio -100, 200 times per turn of the output; at 101, 202 times."""
    assert spectrum(gearbox(**STRAIN_WAVE, wave_generator_error=1e-5), 1) == pytest.approx(
        {200: 1e-5}, rel=1e-9
    )
    assert spectrum(
        gearbox(**STRAIN_WAVE, held="flexspline", wave_generator_error=1e-5), 1
    ) == pytest.approx({202: 1e-5}, rel=1e-9)


def test_a_strain_wave_gear_has_no_play_unless_stated():
    """Its zones are all it gives."""
    part = gearbox(**STRAIN_WAVE, stiffness=[31e3, 50e3, 57e3], zone_torques=[14.0, 48.0])
    assert part.play.nominal == 0
    assert visit_size(terms_at(part, condition())) == 0
    assert gearbox(**STRAIN_WAVE, backlash=1e-4).play.nominal == 1e-4


def test_a_worm_errs_with_worm_wheel_and_teeth():
    """Two starts on 60 teeth: 30 turns of the worm, one of the wheel, 60 teeth per turn of the
    output; none of them stated, nothing errs.
    """
    found = spectrum(gearbox(**WORM, worm_error=1e-5, wheel_error=2e-5, mesh_error=3e-5), 1)
    assert found == pytest.approx({30: 1e-5, 1: 2e-5, 60: 3e-5}, rel=1e-9)
    assert terms_at(gearbox(**WORM), condition()) == []


def test_a_worm_locks_itself_below_its_friction_angle():
    """With mu = 0.06 at 20 degrees the friction angle is 3.65 degrees: a lead angle of 3 locks, one
    of 5 does not, unstated nobody knows.
    """
    degree = np.pi / 180
    reserve = gearbox(**WORM, lead_angle=3 * degree, friction_coefficient=0.06).locking_reserve
    assert reserve == pytest.approx(np.arctan(0.06 / np.cos(20 * degree)) - 3 * degree, rel=1e-12)
    assert reserve > 0
    assert gearbox(**WORM, lead_angle=5 * degree, friction_coefficient=0.06).locking_reserve < 0
    assert gearbox(**WORM, lead_angle=5 * degree).locking_reserve is None


def test_a_duplex_worm_is_shifted_until_little_play_is_left():
    """Leads of 6.2 and 6.4 mm at ratio 60: half a millimetre of shift takes 0.9' of a degree from a
    play of 3', of every gearbox.
    """
    leads = {"left_lead": 6.2e-3, "right_lead": 6.4e-3}
    taken = 2 * np.pi * 0.5e-3 * 0.2e-3 / (60 * 6.3e-3**2)
    stated = Toleranced(3 * ARCMIN, 0.5 * ARCMIN)
    part = gearbox(kind="worm", wheel_teeth=60, backlash=stated, duplex={**leads, "shift": 0.5e-3})
    assert taken / ARCMIN == pytest.approx(0.907, abs=1e-3)
    assert (part.play.nominal, part.play.tolerance) == pytest.approx(
        (3 * ARCMIN - taken, 0.5 * ARCMIN), rel=1e-12
    )
    assert visit_size(terms_at(part, condition())) == pytest.approx(
        visit_size(terms_at(gearbox(backlash=part.play), condition())), rel=1e-12
    )
    lost = {"lost_motion": 3 * ARCMIN, "rated_torque": 50.0, "stiffness": 1e4}
    with_lost_motion = gearbox(
        kind="worm", wheel_teeth=60, duplex={**leads, "shift": 0.5e-3}, **lost
    )
    assert with_lost_motion.play.nominal == pytest.approx(3 * ARCMIN - 3e-4 - taken, rel=1e-12)


def test_a_duplex_worm_shifted_too_far_jams():
    """The play cannot be reduced by more than its lower limit; the suggested shift passes, a
    thousandth more does not.
    """
    fields = {"kind": "worm", "wheel_teeth": 60, "backlash": Toleranced(3 * ARCMIN, 0.5 * ARCMIN)}
    leads = {"left_lead": 6.2e-3, "right_lead": 6.4e-3}
    example = why(**fields, duplex={**leads, "shift": 5e-3})["example"]
    shift = float(example.split('"')[1].removesuffix(" mm")) * 1e-3
    assert gearbox(**fields, duplex={**leads, "shift": shift}).play.nominal == pytest.approx(
        0.5 * ARCMIN, rel=1e-3
    )
    assert "play by more" in why(**fields, duplex={**leads, "shift": shift * 1.001})["why"]
    assert "equal leads" in why(**fields, duplex={"left_lead": 6e-3, "right_lead": 6e-3})["why"]
    assert (
        "play by more" in why(kind="worm", wheel_teeth=60, duplex={**leads, "shift": 1e-6})["why"]
    )


@pytest.mark.parametrize(
    ("fields", "found", "example"),
    [
        (
            {**WOLFROM, "output_planet_teeth": 36, "output_ring_teeth": 90},
            "stands still",
            "output_ring_teeth = 91",
        ),
        (
            {**WOLFROM, "output_ring_teeth": 33},
            "an output ring of 33 teeth around a planet of 33",
            "output_ring_teeth = 34",
        ),
        (
            {**WOLFROM, "fixed_ring_teeth": 30},
            "a fixed ring of 30 teeth around a planet of 36",
            "fixed_ring_teeth = 39",
        ),
        ({**WOLFROM, "planets": 5}, "5 planets with sun + fixed ring = 108", "planets = 4"),
        (
            {**STRAIN_WAVE, "circular_spline_teeth": 200},
            "circular spline of 200",
            "flexspline_teeth = 200, circular_spline_teeth = 202",
        ),
        (
            {**STRAIN_WAVE, "circular_spline_teeth": 198},
            "circular spline of 198",
            "flexspline_teeth = 200, circular_spline_teeth = 202",
        ),
        (
            {**STRAIN_WAVE, "circular_spline_teeth": 203},
            "circular spline of 203",
            "flexspline_teeth = 200, circular_spline_teeth = 202",
        ),
        (
            {**STRAIN_WAVE, "circular_spline_teeth": 205},
            "circular spline of 205",
            "flexspline_teeth = 200, circular_spline_teeth = 204",
        ),
        ({**WORM, "starts": 61}, "61 starts", "starts = 60"),
    ],
)
def test_teeth_that_cannot_be_are_refused(fields: dict[str, object], found: str, example: str):
    """Gears that stand still, run backwards by mistake, or cannot be put together are refused with
    the nearest that can; that passes.
    """
    said = why(**fields)
    assert found in said["why"]
    assert said["example"] == example
    assert gearbox(**{**fields, **numbers(example)})
