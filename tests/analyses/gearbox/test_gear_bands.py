"""Bands of a gearbox over the values that are stated as ranges: their quantiles, and that nothing
else enters them.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import lostmotion
from lostmotion.analyses.gearbox.gear import Gear, gear
from lostmotion.parts.bands import band, influence
from lostmotion.parts.gearbox import bands as of_gearbox
from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
from lostmotion.printed import ARCMIN
from lostmotion.reporting.layout import row_at

if TYPE_CHECKING:
    from pathlib import Path

    from lostmotion.parts.gearbox.bands import GearBands

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "bands of a gearbox",
        "one spring in a log-uniform range, in closed form; clearances and materials in ranges",
        "1e-4; 1e-6",
    ),
)

# Declared rigid besides its contacts and bodies, which are far stiffer than its frame.
RIGID = [
    "output pins",
    "eccentric bearing",
    "eccentric shaft",
    "input shaft",
    "seat of the eccentric bearing",
]
DRAWING: dict[str, Any] = {
    "kind": "cycloidal",
    "rated_torque": "200 N m",
    "pins": 40,
    "ring_radius": "64 mm",
    "pin_radius": "3 mm",
    "eccentricity": "1.3 mm",
    "width": "12 mm",
    "relief": {"roller": "4 µm"},
    "frame": "10 .. 40 N m/arcmin",
    "rigid": RIGID,
}
SPRING = 40 / ARCMIN
STATED = (
    '[gearbox]\nkind = "catalogue"\nratio = 100\nrated_torque = "50 N m"\nbacklash = "1 arcmin"\n'
    'stiffness = "{}"\n'
)


def asked(count: int = 16, **changes: Any) -> Gear:
    """Ask for a gearbox of the drawing with other values."""
    return of_table({**DRAWING, **changes}, count)


@functools.cache
def drawn() -> Gear:
    """Return the gearbox of the drawing as it is, computed once."""
    return asked()


def of_table(table: dict[str, Any], count: int = 16) -> Gear:
    """Ask for the gearbox of this table."""
    return gear(CycloidalGearbox.model_validate(table, context={"text": True}), gearboxes=count)


def bands(found: Gear) -> GearBands:
    """Return the bands, which this gearbox has."""
    assert found.bands is not None
    return found.bands


def test_one_spring_has_the_quantiles_of_its_range():
    """The wind-up of a spring k in a log-uniform range a .. b has the quantiles T/(a (b/a)^p),
    above that of the other members.
    """
    found = asked(relief={"roller": "0 mm"})
    wound = bands(found).read.wind_up
    middle = float(found.read.wind_up.mean())
    expected = [middle + 200 / SPRING * (4 * 4**-p - 2) for p in (0.95, 0.05)]
    assert band(wound) == pytest.approx(expected, rel=1e-4)
    low, high = band(bands(found).members["frame"])
    assert (low, high) == (
        pytest.approx(200 / SPRING * 4**0.05, rel=1e-3),
        pytest.approx(200 / SPRING * 4**0.95, rel=1e-3),
    )
    others = [np.ptp(each) for name, each in bands(found).members.items() if name != "frame"]
    assert max(others) == pytest.approx(0, abs=1e-15)


def test_a_range_that_shrinks_to_nothing_has_the_nominal_figures():
    """Limits a millionth apart leave every figure where a single value has it, and the band is as
    narrow.
    """
    known, nearly = asked(frame="20 N m/arcmin"), asked(frame="19.99999 .. 20.00001 N m/arcmin")
    assert known.bands is None
    for name in ("wind_up", "displacement", "secant", "slope", "lost_motion"):
        value = float(getattr(known.read, name).mean())
        assert float(getattr(nearly.read, name).mean()) == pytest.approx(value, rel=1e-6)
        assert band(getattr(bands(nearly).read, name)) == (
            pytest.approx(value, rel=2e-3),
            pytest.approx(value, rel=2e-3),
        )
    assert np.ptp(bands(nearly).read.wind_up) == pytest.approx(
        1e-6 * known.drawn.members["frame"], rel=0.1
    )


def test_scatter_between_gearboxes_is_no_part_of_a_band(monkeypatch):
    """Tolerances widen the interval over gearboxes and move the mean; the band keeps its width,
    however many gearboxes are simulated.
    """
    # draw by draw, for which eight do as well
    monkeypatch.setattr(of_gearbox, "DRAWS", 8)
    without = asked()
    plain = bands(without).read.wind_up
    for found in (
        asked(ring_radius="64 mm ± 10 µm", flank_form="3 µm"),
        asked(ring_radius="64 mm ± 10 µm", count=8),
    ):
        assert found.read.wind_up.std() > 0
        np.testing.assert_allclose(
            bands(found).read.wind_up - found.read.wind_up.mean(),
            plain - without.read.wind_up.mean(),
            rtol=1e-9,
        )


def test_shares_of_a_draw_add_up_to_one():
    """In each draw the members' shares of the wind-up add up to one, and their wind-ups to that of
    the draw.
    """
    rigid = [name for name in RIGID if name != "eccentric bearing"]
    found = bands(asked(eccentric={"bearing": "50 .. 100 N/µm"}, width="11 .. 13 mm", rigid=rigid))
    np.testing.assert_allclose(np.sum(list(found.member_shares.values()), axis=0), 1.0, rtol=1e-12)
    np.testing.assert_allclose(
        np.sum(list(found.members.values()), axis=0), found.read.wind_up, rtol=1e-9
    )
    assert influence(found.shares, found.read.wind_up).sum() == pytest.approx(1, abs=0.2)
    assert influence(found.shares, found.read.wind_up).argmax() == [
        each.key for each in found.unknown
    ].index("frame")


def test_an_unknown_clearance_widens_the_play_and_no_stiffness():
    """A clearance in a range moves play and lost motion by its share of the radius, and leaves the
    wind-up alone.
    """
    pins = {"count": 8, "circle_radius": "40 mm", "clearance": "10 .. 30 µm"}
    found = bands(asked(frame="20 N m/arcmin", output_pins=pins, rigid=[*RIGID, "disc body"]))
    low, high = band(found.read.lost_motion)
    assert high - low == pytest.approx(0.9 * 20e-6 / 40e-3, rel=1e-6)
    assert np.ptp(found.read.wind_up) == pytest.approx(0, abs=1e-12)
    assert found.unknown_share == 0


def test_a_stiffness_that_is_mostly_unknown_is_printed_as_its_band():
    """Where more than a fifth of the compliance depends on ranges, headline and card begin with the
    band; where less does, with the value.
    """
    unknown, known = drawn(), asked(frame="10000 .. 20000 N m/arcmin")
    assert bands(unknown).unknown_share > 0.2 > bands(known).unknown_share > 0
    assert "(5-95 % of what the drawing leaves open), middle" in unknown.sheet.verdict
    assert unknown.sheet.verdict.startswith("Stiffness ")
    assert known.sheet.verdict.startswith("Play ")
    (card,) = (card for card in unknown.sheet.cards if card.title == "stiffness")
    assert " .. " in card.number
    for found in (unknown, known):
        row = row_at(found.sheet.sections, "bands", "stiffness_slope")
        assert row is not None
        low, middle, high = (figure.value for figure in row.cells)
        assert low < middle < high
        assert middle == pytest.approx(float(found.read.slope.mean()))
    assert row_at(asked(frame="20 N m/arcmin").sheet.sections, "bands", "stiffness_slope") is None


def test_result_json_has_bands_by_name():
    """Programs find each end of a band, the range behind it, and its share of the variance, by
    name.
    """
    found = drawn().result()
    assert set(found["figures"]["bands"]["stiffness_slope"]) == {"p5", "middle", "p95"}
    (range_,) = found["ranges"]
    assert range_ == {
        "key": "frame",
        "low": pytest.approx(10 / ARCMIN),
        "high": pytest.approx(40 / ARCMIN),
        "law": "log-uniform",
    }
    assert found["figures"]["ranges"]["frame"]["share_of_variance"]["value"] == pytest.approx(1)
    assert 0.2 < found["share_of_compliance_in_ranges"] < 1


def test_order_of_keys_and_units_change_nothing(monkeypatch):
    """A drawing with its keys in another order and its ranges in other units has the same bands."""
    # draw by draw, for which eight do as well
    monkeypatch.setattr(of_gearbox, "DRAWS", 8)
    changes = {"width": "11 .. 13 mm", "eccentric": {"bearing": "50 .. 100 N/µm"}, "rigid": []}
    first = asked(**changes)
    turned = dict(
        reversed(
            {
                **DRAWING,
                **changes,
                "width": "1.1 .. 1.3 cm",
                "eccentric": {"bearing": "50e6 N/m .. 0.1 N/nm"},
            }.items()
        )
    )
    second = of_table(turned)
    np.testing.assert_allclose(bands(first).read.slope, bands(second).read.slope, rtol=1e-12)


def test_stated_figures_have_bands_too(tmp_path: Path):
    """A stiffness stated as a range has its quantiles in slope and secant."""
    file = tmp_path / "stated.toml"
    file.write_text(STATED.format("5 .. 20 N m/arcmin"), encoding="utf-8")
    found = lostmotion.gear(file)
    expected = tuple(pytest.approx(5 * 4**p / ARCMIN, rel=1e-3) for p in (0.05, 0.95))
    assert band(bands(found).read.slope) == expected
    assert band(bands(found).read.secant) == expected
    assert found.sheet.verdict.startswith(
        "Stiffness 5.36 .. 18.7 N m/arcmin (5-95 % of what the drawing leaves open), middle 10.0."
    )
    file.write_text(STATED.format("5 N m/arcmin"), encoding="utf-8")
    assert lostmotion.gear(file).bands is None


def test_an_impossible_drawing_within_the_ranges_is_refused():
    """A flank that is undercut somewhere in its range is one clear message."""
    with pytest.raises(
        lostmotion.InputError, match=r"ranges that allow a pin radius of .* undercuts the flank"
    ):
        asked(eccentricity="1.0 .. 1.5 mm")


def test_what_a_drawing_leaves_open_has_a_band_too():
    """A frame that is not stated has 0.05 to 1 times the compliance of the computed members:
    log-uniform, and 100 % of what is unknown.
    """
    table = {key: value for key, value in DRAWING.items() if key != "frame"}
    found = of_table(table)
    (frame,) = bands(found).unknown
    assert frame.key == "unstated.frame"
    (row,) = next(section for section in found.sheet.sections if section.key == "ranges").rows
    assert (row.label, row.key) == ("frame (not stated)", "unstated_frame")
    computed = sum(each for name, each in bands(found).middle.items() if name != "frame (bounded)")
    low, high = band(bands(found).members["frame (bounded)"])
    assert low == pytest.approx(0.05 * 20**0.05 * computed, rel=0.02)
    assert high == pytest.approx(0.05 * 20**0.95 * computed, rel=0.02)
    assert bands(found).unknown_share == pytest.approx(
        math.sqrt(0.05) / (1 + math.sqrt(0.05)), rel=0.02
    )
    known = of_table({**table, "unstated": {"frame": 2.0}})
    assert known.bands is None
    assert known.drawn.members["frame (bounded)"] == pytest.approx(
        2 * found.drawn.members["frame (bounded)"], rel=1e-9
    )
