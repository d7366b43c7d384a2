"""The sheet of one gearbox: what is found, printed, drawn and written."""

from __future__ import annotations

import functools
import io
import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pytest

import lostmotion
from lostmotion import InputError, LostmotionError
from lostmotion.analyses.gearbox.gear import gear
from lostmotion.analyses.gearbox.page.loop import over_samples
from lostmotion.analyses.gearbox.page.plots import gearbox_plots
from lostmotion.error_model.robot_intervals import robots_quantile, root_mean_square_of_samples
from lostmotion.io import dxf
from lostmotion.io.part_file import read_gearbox
from lostmotion.laws.contact import equivalent_modulus
from lostmotion.laws.cycloid import geometry
from lostmotion.laws.cycloid.friction import DriveFriction
from lostmotion.laws.cycloid.simulated import simulate
from lostmotion.laws.cycloid.stage import Stage
from lostmotion.laws.torque_angle import Definitions, SampledCurve, readings
from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox, examined, samples
from lostmotion.printed import ARCMIN
from lostmotion.reporting.layout import key_of, row_at
from tests.command import carried_out, carried_out_by_process
from tests.reporting.chart_texts import axis_titles, crowded, unprinted

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "results for one gearbox",
        (
            "torque from the printed lobe forces; Hertz by hand; a maker's RV figures; Parseval "
            "over the harmonics"
        ),
        "1e-9; 1e-12; printed digits; 2 %",
    ),
    (
        "DXF profiles",
        "every pin on every disc, read from the DXF; the flank at independent points",
        "1 µm; the chord error stated, at most 0.5 µm",
        "laws/cycloid/outline.py tests/laws/test_cycloid_outline.py",
    ),
    (
        "stiffness and lost motion as makers define them",
        "published readings of one curve, with and without friction",
        "printed digits",
        "laws/torque_angle.py",
    ),
)

EXAMPLES = Path(__file__).parents[3] / "examples" / "gearbox"
NAMES = ("rv-like", "two-stage-lobes", "printed")
PLAIN: dict[str, Any] = {
    "kind": "cycloidal",
    "rated_torque": "200 N m",
    "pins": 40,
    "ring_radius": "64 mm",
    "pin_radius": "3 mm",
    "eccentricity": "1.3 mm",
    "width": "12 mm",
    "relief": {"roller": "4 µm"},
}
# A gearbox by stated figures of each kind.
STATED = {
    "catalogue": 'gearbox = "RV-40E-121"',
    "no torque": '[gearbox]\nratio = 100\nstiffness = ["31e3 N m/rad", "50e3 N m/rad", "57e3 N m/rad"]\n'
    'zone_torques = ["14 N m", "48 N m"]\n'
    'backlash = "0 arcmin"\nhysteresis = "1 arcmin"\ntransmission_error = "0.8 arcmin"',
    "worm": '[gearbox]\nkind = "worm"\nwheel_teeth = 60\nbacklash = "1 arcmin ± 0.3 arcmin"\n'
    'lead_angle = "3 deg"\nfriction_coefficient = 0.1\n'
    'rated_torque = "100 N m"\nstiffness = ["10 N m/arcmin", "20 N m/arcmin"]\nzone_torques = '
    '["20 N m"]\nworm_error = "0.2 arcmin"\n'
    'hysteresis = "0.2 arcmin"',
    "planetary": (
        '[gearbox]\nkind = "planetary"\nsun_teeth = 20\nring_teeth = 70\nplanets = 3\nbacklash = '
        '"3 arcmin"\nplanet_error = "0.1 arcmin"'
    ),
    "wolfrom": '[gearbox]\nkind = "wolfrom"\nsun_teeth = 18\nplanet_teeth = 36\nfixed_ring_teeth = 90\n'
    "output_planet_teeth = 33\n"
    'output_ring_teeth = 87\nrated_torque = "50 N m"\nlost_motion = "2 arcmin"\nstiffness = '
    '"10 N m/arcmin"',
    "strain wave": '[gearbox]\nkind = "strain wave"\nflexspline_teeth = 200\ncircular_spline_teeth = 202\n'
    'rated_torque = "60 N m"\n'
    'stiffness = "9 N m/arcmin"\nwave_generator_error = "0.2 arcmin"',
    "belt": (
        '[gearbox]\nlead = "10 mm"\nbacklash = "20 µm ± 5 µm"\nstiffness = "100 N/µm"\n'
        'rated_torque = "500 N"\ntransmission_error = "5 µm"'
    ),
}


@functools.cache
def examined_gearbox(name):
    """Look at an example once."""
    return lostmotion.gear(EXAMPLES / f"{name}.toml", gearboxes=100)


@functools.cache
def bare():
    """Look at a steel gearbox of one disc without tolerances once."""
    return plain(discs=1)


@functools.cache
def twin():
    """Look at a gearbox of two planets with pins, without tolerances, once."""
    return plain(form="planet pins", pins=20, discs=2)


def plain(**more):
    """Look at a steel gearbox of one disc without tolerances, with these fields besides."""
    part = CycloidalGearbox.model_validate({**PLAIN, **more}, context={"text": True})
    return replace(gear(part, gearboxes=2), name="plain")


def stated(tmp_path, name):
    """Look at a gearbox by stated figures."""
    path = tmp_path / "stated.toml"
    path.write_text(STATED[name])
    return lostmotion.gear(path)


def figure(found, section, label, column=0):
    """Return one figure of a sheet."""
    return row_at(found.sheet.sections, section, key_of(label)).cells[column]


def ran(*words, cwd):
    """Run the command in a folder."""
    return carried_out("gear", *words, cwd=cwd, columns=200)


@pytest.mark.parametrize("name", NAMES)
def test_forces_of_the_lobes_hold_the_torque(name):
    """Lobe forces times their arms about the disc's centre add up to the disc's share of the
    torque, for each share that is printed.
    """
    found = examined_gearbox(name)
    assert [case.share for case in found.drawn.lobes] == (
        [0.5, 0.55] if found.gearbox.discs == 2 else [1.0]
    )
    for case in found.drawn.lobes:
        moment = float(case.force @ geometry.arms(found.gearbox.stage, case.theta))
        assert moment == pytest.approx(case.share * found.torque, rel=1e-9)


def test_with_the_ring_as_output_the_disc_carries_less():
    """Held at the carrier, the ring turns under T and the disc feels T z/N."""
    case = plain(fixed="carrier").drawn.lobes[0]
    stage = Stage(0.064, 0.003, 0.0013, 40)
    assert float(case.force @ geometry.arms(stage, case.theta)) == pytest.approx(
        200 * 39 / 40, rel=1e-9
    )


def test_peak_pressures_are_those_of_hertz():
    """Line contact: p = sqrt(F E*/(pi b Req))."""
    case = bare().drawn.lobes[0]
    stage = Stage(0.064, 0.003, 0.0013, 40)
    radius = stage.pin_radius * (1 - stage.pin_radius * geometry.curvature(stage, case.theta))
    expected = np.sqrt(
        case.force * equivalent_modulus(210e9, 0.3, 210e9, 0.3) / (math.pi * 0.012 * radius)
    )
    np.testing.assert_allclose(case.peak, expected, rtol=1e-12)


def test_geometry_of_the_rv_like():
    """K1 = 1.3 x 40/64, tip and root R - Rr ± e less the relief, pressure angle at the longest arm
    from the triangle of centres.
    """
    found = examined_gearbox("rv-like")
    assert figure(found, "geometry", "K1 = e N/R").as_shown == pytest.approx(0.8125)
    assert figure(found, "geometry", "tip radius of the disc").as_shown == pytest.approx(
        64 - 3 + 1.3 - 0.004
    )
    assert figure(found, "geometry", "root radius of the disc").as_shown == pytest.approx(
        64 - 3 - 1.3 - 0.004
    )
    distance = math.sqrt(64**2 + 1.3**2 - 2 * 64 * 1.3 * 0.8125)
    angle = math.degrees(math.acos(1.3 * 39 / distance))
    assert figure(found, "geometry", "pressure angle at the longest arm").as_shown == pytest.approx(
        angle
    )
    assert found.gearbox.ratio == 81
    assert found.result()["ratio"] == 81


def test_play_without_tolerances_is_that_of_the_relief():
    """Nothing scatters: all gearboxes have the play 2 dRr/(e z), a little more between two pins;
    the interval has no width and none jams.
    """
    found = bare()
    expected = 2 * 4e-6 / (0.0013 * 39) / ARCMIN
    assert figure(found, "geometry", "play by the relief alone").as_shown == pytest.approx(expected)
    mean = figure(found, "built", "play: mean")
    assert expected <= mean.as_shown <= 1.01 * expected
    assert mean.high - mean.low == pytest.approx(0, abs=1e-12)
    assert figure(found, "built", "gearboxes that jam").as_shown == 0


@pytest.mark.parametrize("name", NAMES)
def test_simulated_gearboxes_are_those_of_the_arm(name):
    """Other gearboxes of the same drawing: means of play and lost motion agree with those of its
    behaviour to three standard errors.
    """
    found = examined_gearbox(name)
    for here, there in (
        (found.drawn.play, found.gearbox.behaviour.play),
        (found.drawn.lost_motion, found.gearbox.behaviour.lost_motion),
    ):
        error = math.hypot(here.std() / math.sqrt(len(here)), there.std() / math.sqrt(len(there)))
        assert abs(here.mean() - there.mean()) < 3 * error


def test_more_gearboxes_keep_the_first():
    """One hundred gearboxes begin with the same twenty: so a figure only becomes more precise."""
    part = examined_gearbox("rv-like").gearbox
    few = gear(part, gearboxes=20).drawn
    np.testing.assert_array_equal(few.play, examined_gearbox("rv-like").drawn.play[:20])


@pytest.mark.parametrize("name", NAMES)
def test_members_add_up_to_the_end_of_the_loop(name):
    """What each member gives adds up to the wind-up; the loop ends half the play beyond the wind-up
    under the torque that friction leaves.
    """
    found = examined_gearbox(name)
    whole = sum(found.drawn.members.values())
    assert whole == pytest.approx(found.wind_up, rel=1e-12)
    assert list(found.drawn.members.values()) == sorted(found.drawn.members.values(), reverse=True)
    loop = found.loop
    rising, _ = found.drawn.curve.branches(np.array([found.torque]), found.torque)
    assert loop.rising[-1] == pytest.approx(rising.mean() + loop.play / 2, rel=1e-9)


@pytest.mark.parametrize("found", [*NAMES, "catalogue", "worm", "belt"])
def test_the_loop_closes_steps_by_the_play_and_shows_the_lost_motion(found, tmp_path):
    """It is odd, closed, never inside out; it steps by the play where friction is overcome, and its
    lost motion is that of the samples.
    """
    study = examined_gearbox(found) if found in NAMES else stated(tmp_path, found)
    loop = study.loop
    np.testing.assert_allclose(
        loop.rising, -loop.falling[::-1], rtol=0, atol=1e-12 * loop.rising.max()
    )
    assert loop.rising[-1] == pytest.approx(loop.falling[-1])
    assert (loop.falling >= loop.rising - 1e-15).all()
    assert (np.diff(loop.rising) >= -1e-15).all()
    before = np.searchsorted(loop.torque, loop.rest)
    assert loop.torque[before] == loop.rest
    assert loop.rising[before + 1] - loop.rising[before] == pytest.approx(loop.play, rel=1e-6)
    assert loop.width == pytest.approx(loop.play + loop.friction_width, rel=1e-9)
    middle = (loop.rising + loop.falling) / 2
    ends = np.interp([-loop.small, loop.small], loop.torque, middle)
    # the middle of the loop is nearly the elastic curve where friction is small
    assert ends[1] - ends[0] == pytest.approx(loop.lost_motion, rel=0.01)
    if study.drawn is not None:
        assert loop.lost_motion == pytest.approx(study.drawn.lost_motion.mean(), rel=1e-12)


def test_the_makers_figures_of_an_rv_come_back(tmp_path):
    """An RV-40E: 1' between ±3 % of 412 N m, a loop of 1' at zero torque, 108 N m/arcmin."""
    found = stated(tmp_path, "catalogue")
    assert figure(found, "loop", "lost motion").as_shown == pytest.approx(1.0)
    assert figure(found, "loop", "whole loop at zero torque").as_shown == pytest.approx(
        1.0, abs=1e-3
    )
    assert figure(found, "loop", "wind-up at 412 N m").as_shown == pytest.approx(412 / 108)


def test_a_ratio_that_nobody_stated_is_not_known(tmp_path):
    """A name of the catalogue without its ratio shows none, rather than one turn for one."""
    (tmp_path / "named.toml").write_text('gearbox = "RV-42N"')
    found = lostmotion.gear(tmp_path / "named.toml")
    assert found.result()["ratio"] is None
    assert "ratio" not in [row.label for section in found.sheet.sections for row in section.rows]
    (tmp_path / "named.toml").write_text('gearbox = "RV-42N-126"')
    assert str(figure(lostmotion.gear(tmp_path / "named.toml"), "stated", "ratio")) == "126"


def test_wind_up_in_zones(tmp_path):
    """Two zones, 20 N m at 10 N m/arcmin and 80 N m at 20: 2' and 4' more."""
    found = stated(tmp_path, "worm")
    assert figure(found, "loop", "wind-up at 100 N m").as_shown == pytest.approx(6.0)
    assert figure(found, "zones", "wind-up at 20 N m").as_shown == pytest.approx(2.0)
    assert figure(found, "transmission", "worm", 1).as_shown == 60
    play = figure(found, "stated", "play")
    assert (play.low, play.value, play.high) == pytest.approx((0.7 * ARCMIN, ARCMIN, 1.3 * ARCMIN))
    assert "stated limits" in play.interval


@pytest.mark.parametrize("name", NAMES)
def test_harmonics_contain_all_of_the_transmission_error(name):
    """Parseval: half the squares of the harmonics' amplitudes add up to the mean square of the
    error, over gearboxes and a turn.
    """
    found = examined_gearbox(name).drawn.transmission
    waves = (found.amplitude**2).sum(axis=1) / 2
    np.testing.assert_allclose(
        waves,
        (found.errors[:, :-1] ** 2).mean(axis=(1, 2)),
        rtol=0.02 if name == "two-stage-lobes" else 1e-12,
    )
    np.testing.assert_allclose(found.errors[:, 0], found.errors[:, -1], atol=1e-15)


def test_equal_pins_pass_forty_times_a_turn_of_the_crank():
    """Without tolerances one disc's error repeats with every pin: harmonics at multiples of N per
    turn of the crank, N z per turn of the output.
    """
    found = bare().drawn.transmission
    strong = found.cycles[found.amplitude[1] > 1e-6 * found.amplitude[1].max()]
    assert len(strong)
    np.testing.assert_allclose(strong % (40 * 39), 0, atol=1e-9)


def test_two_stages_have_two_families_of_harmonics():
    """Harmonics come at multiples of the last stage's 23 per turn; the first stage adds to those at
    253, once per turn of its own crank.
    """
    found = examined_gearbox("two-stage-lobes")
    cycles = found.drawn.transmission.cycles
    np.testing.assert_allclose(cycles % 23, 0, atol=1e-9)
    assert len(set(cycles)) == len(cycles)
    assert found.gearbox.ratio == 253
    alone = found.gearbox.model_copy(update={"first_stage": None})
    assert alone.ratio == -23
    without = gear(alone, gearboxes=2).drawn.transmission
    more = (
        found.drawn.transmission.amplitude[1, cycles == 253]
        / without.amplitude[1, without.cycles == 253]
    )
    assert float(more[0]) > 1


def test_efficiency_is_what_friction_leaves():
    """T/(T + M) at each load; without coefficients there is no such section."""
    found = examined_gearbox("rv-like")
    row = row_at(found.sheet.sections, "friction", "at_412_N_m")
    assert row.cells[1].as_shown == pytest.approx(100 * 412 / (412 + row.cells[0].as_shown))
    assert row.cells[1].as_shown == pytest.approx(row.cells[2].as_shown, abs=0.5)
    assert "friction" not in [section.key for section in bare().sheet.sections]


def test_what_is_known_of_each_member_is_reported():
    """The sheet says of each member whether it is stated, computed, assumed, bounded or absent, in
    its notes, its section and its plain data.
    """
    found = examined_gearbox("rv-like")
    states = found.result()["member_states"]
    assert states["frame"] == "stated"
    assert states["eccentric bearing"] == "computed"
    assert states["ring pins"].startswith("assumed: in seats along their full length")
    assert states["input shaft"].startswith("bounded: at most")
    assert states["output pins"] == "absent: the cranks carry the output"
    members = next(section for section in found.sheet.sections if section.key == "members")
    assert "absent: seat of the eccentric bearing, output pins" in members.note
    assert (
        next(row for row in members.rows if row.label == "input shaft (bounded)").note
        == states["input shaft"]
    )
    assert any(note.startswith("not specified: input shaft;") for note in found.sheet.notes)


def test_another_torque_moves_what_depends_on_it():
    """Half the torque: smaller forces and wind-up; play stays."""
    part = examined_gearbox("rv-like").gearbox
    half = gear(part, 206.0, 20)
    whole = examined_gearbox("rv-like")
    assert half.drawn.lobes[0].largest_force < 0.7 * whole.drawn.lobes[0].largest_force
    assert 0.4 * whole.wind_up < half.wind_up < 0.65 * whole.wind_up
    np.testing.assert_array_equal(half.drawn.play, whole.drawn.play[:20])


@pytest.mark.parametrize("name", [*NAMES, *STATED, "twin"])
def test_every_sheet_and_plot_is_whole(name, tmp_path):
    """No figure lacks unit, sample or number; rows fill their columns; every plot belongs to a
    section and names the units of its axes.
    """
    found = (
        twin()
        if name == "twin"
        else examined_gearbox(name)
        if name in NAMES
        else stated(tmp_path, name)
    )
    sheet = found.sheet
    for section in sheet.sections:
        assert section.rows, section.key
        for row in section.rows:
            assert len(row.cells) == len(section.columns)
            assert all(
                each.words or (each.unit and each.samples and math.isfinite(each.value))
                for each in row.cells
            ), row.label
    keys = {section.key for section in sheet.sections}
    for plot in gearbox_plots(found):
        assert plot.section in keys
        assert all("[" in title for title in axis_titles(plot)), plot.key
        assert not unprinted(plot, sheet), plot.key
        assert not crowded(plot.figure), plot.key
    assert json.dumps(found.result(), allow_nan=False)
    assert "<table" in found._repr_html_()


def test_a_drive_that_slides_is_read_in_lengths(tmp_path):
    """A belt's play is in µm, its stiffness in N/µm, its load in N."""
    found = stated(tmp_path, "belt")
    play = figure(found, "loop", "play")
    assert (str(play), play.between) == ("20 µm", "15 … 25")
    assert figure(found, "loop", "wind-up at 500 N").as_shown == pytest.approx(5.0)
    assert found.result()["force_N"] == 500


def test_without_a_torque_no_figure_is_invented(tmp_path):
    """A gearbox without a rated torque shows its zones, no loop, and says how to give one."""
    found = stated(tmp_path, "no torque")
    assert found.loop is None
    assert {section.key for section in found.sheet.sections} == {
        "stated",
        "zones",
        "transmission",
        "inputs",
        "laws",
    }
    assert any("--torque" in note for note in found.sheet.notes)
    given = gear(found.gearbox, 60.0)
    assert given.wind_up == pytest.approx(
        float(given.loop.friction_rising[-1] + given.gearbox.hysteresis / 2)
    )


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"torque": 0.0}, "above zero"),
        ({"torque": math.nan}, "above zero"),
        ({"gearboxes": 1}, "from 2 to 100000"),
        ({"seed": -1}, "at least 0"),
    ],
)
def test_arguments_that_cannot_be(more, said):
    """Each is refused with what is expected."""
    with pytest.raises(InputError, match=said):
        lostmotion.gear(EXAMPLES / "rv-like.toml", **more)


def test_a_large_torque_is_printed_without_a_power_of_ten(tmp_path):
    """15 kN m is 15000 N m in the headline, the cards and the tables of stated figures."""
    (tmp_path / "slewing.toml").write_text(
        (
            '[gearbox]\nrated_torque = "20 kN m"\nstiffness = "9 kN m/arcmin"\nlost_motion = "1 '
            'arcmin"\n'
        ),
        encoding="utf-8",
    )
    sheet = lostmotion.gear(tmp_path / "slewing.toml", torque="15 kN m").sheet
    assert "Under 15000 N m" in sheet.verdict
    rows = [
        text
        for section in sheet.sections
        for row in section.rows
        for text in (row.label, row.note, *map(str, row.cells))
    ]
    assert not re.search(
        r"\d[eE][+-]?\d",
        " ".join([sheet.verdict, *rows, *(card.number + card.quiet for card in sheet.cards)]),
    )


def test_displacement_of_an_rv_is_read_as_its_maker_does(tmp_path):
    """RV-42N at 60 N m: half its lost motion and (60 - 12.36)/113 beyond, 0.92', from the middle of
    the play; the wind-up alone is 0.531'.
    """
    (tmp_path / "rv.toml").write_text('gearbox = "RV-42N"')
    found = lostmotion.gear(tmp_path / "rv.toml", torque="60 N m")
    assert figure(found, "loop", "displacement at 60 N m").as_shown == pytest.approx(
        1 / 2 + (60 - 12.36) / 113, abs=1e-9
    )
    # its maker prints the lost motion and the hysteresis as upper limits
    assert str(figure(found, "loop", "displacement at 60 N m")) == "≤ 0.922 arcmin"
    for section, label in (
        ("stated", "lost motion"),
        ("loop", "play"),
        ("loop", "friction's loop alone"),
        ("loop", "whole loop at zero torque"),
    ):
        assert figure(found, section, label).bound == "upper"
    assert figure(found, "loop", "wind-up at 60 N m").bound == ""
    assert figure(found, "loop", "wind-up at 60 N m").as_shown == pytest.approx(60 / 113)
    row = row_at(found.sheet.sections, "loop", "lost_motion")
    assert "± 12.36 N m, 3 % of the rated torque" in row.note
    assert (
        "from 206 to 412 N m, 50 to 100 % of the rated torque"
        in row_at(found.sheet.sections, "loop", "stiffness_slope").note
    )


def test_secant_slope_and_lost_motion_of_a_known_curve():
    """W = 4 mrad (T/24)^0.6 + T/1500 with 10 mrad of play, rated 24 N m: 1200.0 and 1281.9 N m/rad,
    lost motion 11.936 mrad (theory's case).
    """
    torque = np.concatenate([[0.0], np.geomspace(1e-4, 30.0, 4000)])
    curve = SampledCurve(
        torque,
        (4e-3 * (torque / 24) ** 0.6 + torque / 1500)[:, None],
        DriveFriction(torque, 0 * torque, 0 * torque),
    )
    found = readings(curve, np.array([0.01]), Definitions(24.0, 0.03 * 24, (12.0, 24.0)))
    assert found.secant[0] == pytest.approx(1200.0, abs=0.05)
    assert found.slope[0] == pytest.approx(1281.9, abs=0.05)
    assert found.lost_motion[0] == pytest.approx(11.936e-3, abs=1e-6)
    assert found.displacement[0] == pytest.approx(0.005 + 0.02)


@pytest.mark.parametrize(
    ("definition", "stiffness"),
    [("slope", 1281.9), ("b/a", 1223.2), ("secant", 1200.0), ("tangent", 1304.3)],
)
def test_stiffness_as_makers_define_it(definition, stiffness):
    """One curve, rated 24 N m, with friction 0.5 N m + 0.15 T_e and without: each definition on the
    elastic curve, to the digits published.
    """
    torque = np.concatenate([[0.0], np.geomspace(1e-5, 40.0, 20_000)])
    curve = lambda load: 4e-3 * (load / 24) ** 0.6 + load / 1500  # noqa: E731
    asked = Definitions(24.0, 0.03 * 24, (12.0, 24.0), definition)
    for constant, share in ((0.5, 0.15), (0.0, 0.0)):
        friction = DriveFriction(torque, share * torque, 0 * torque, constant=constant)
        found = readings(
            SampledCurve(torque, curve(torque)[:, None], friction), np.array([0.01]), asked
        )
        assert found.stiffness is not None
        assert found.loading is not None
        assert found.lost_motion is not None
        assert found.stiffness[0] == pytest.approx(stiffness, abs=0.06)
        assert found.lost_motion[0] == pytest.approx(11.936e-3, abs=6e-7)
        assert found.wind_up[0] == pytest.approx(0.02)
        # as the torque rises the spring carries (T - F0)/(1 + m); below F0 nothing turns
        low, high = asked.span
        turned = curve((high - constant) / (1 + share)) - curve(
            max(low - constant, 0.0) / (1 + share)
        )
        if low:
            assert found.loading[0] == pytest.approx((high - low) / turned, rel=1e-5)
        assert found.width[0] == pytest.approx(11.649e-3 if constant else 0.01, abs=6e-7)


def test_springs_before_the_friction_have_no_loop():
    """Half of a spring on the load's side of the friction halves the loop, and leaves the
    wind-up.
    """
    torque = np.linspace(0.0, 40.0, 401)
    angle = (torque / 1000)[:, None]
    friction = DriveFriction(torque, 0.1 * torque, 0 * torque, constant=2.0)
    whole, half = (
        readings(
            SampledCurve(torque, angle, friction, share * torque / 1000),
            np.zeros(1),
            Definitions(24.0),
        )
        for share in (0.0, 0.5)
    )
    assert half.friction_width[0] == pytest.approx(whole.friction_width[0] / 2)
    assert half.friction_under_load[0] == pytest.approx(whole.friction_under_load[0] / 2)
    assert half.wind_up[0] == whole.wind_up[0]


def test_the_definition_of_the_stiffness_is_printed_beside_it(tmp_path):
    """On the card, in the table of samples and in result.json; b/a needs the torque of a lost
    motion.
    """
    for definition, text in (
        ("tangent", "tangent at 400 N m"),
        ("b/a", "b/a of the hysteresis curve from 12.36 to 400 N m"),
        ("secant", "secant from the middle"),
    ):
        found = lostmotion.gear(
            EXAMPLES / "rv-like.toml",
            gearboxes=4,
            torque="400 N m",
            stiffness_definition=definition,
        )
        assert next(
            card for card in found.sheet.cards if card.title == "stiffness"
        ).quiet.startswith(text)
        assert row_at(found.sheet.sections, "built", "stiffness_mean").note.startswith(text)
        assert found.sheet.facts["stiffness_definition"] == definition
        assert figure(found, "built", "stiffness: mean").as_shown == pytest.approx(
            figure(found, "loop", f"stiffness, {definition}").as_shown
        )
    path = tmp_path / "stated.toml"
    path.write_text(STATED["no torque"])
    with pytest.raises(InputError, match="stiffness_definition"):
        lostmotion.gear(path, torque="20 N m", stiffness_definition="b/a")


def test_lost_motion_is_never_read_at_a_share_of_the_torque_asked_for(tmp_path):
    """A gearbox without a rated torque has no lost motion at 3 % of it; with one it is read there
    whatever --torque is.
    """
    path = tmp_path / "stated.toml"
    path.write_text(STATED["no torque"])
    for torque in ("20 N m", "60 N m"):
        found = lostmotion.gear(path, torque=torque)
        assert row_at(found.sheet.sections, "loop", "lost_motion") is None
        assert any("--lost-motion-torque" in note for note in found.sheet.notes)
    asked = lostmotion.gear(
        path, torque="60 N m", lost_motion_torque="2 N m", slope_range=("14 N m", "48 N m")
    )
    assert figure(asked, "loop", "lost motion").as_shown == pytest.approx(2 * 2 / 31e3 / ARCMIN)
    assert figure(asked, "loop", "stiffness, slope").as_shown == pytest.approx(50e3 * ARCMIN)
    path.write_text(STATED["strain wave"])
    for torque in ("20 N m", "60 N m"):
        assert lostmotion.gear(path, torque=torque).read.asked.small == pytest.approx(0.03 * 60)
    assert lostmotion.gear(path, lost_motion_torque="4 %").read.asked.small == pytest.approx(2.4)
    with pytest.raises(InputError, match="rising"):
        lostmotion.gear(path, slope_range=("80 %", "50 %"))


def test_mistaken_definitions_are_one_message_and_a_slope_may_start_at_zero(tmp_path):
    """All three options are read before any is refused; from 0 to 100 % the slope of one stiffness
    zone is its stiffness.
    """
    path = tmp_path / "stated.toml"
    path.write_text(STATED["strain wave"])
    done = ran(
        path,
        "--torque",
        "2 mm",
        "--lost-motion-torque",
        "-3 %",
        "--slope-range",
        "100 %",
        "50 %",
        cwd=tmp_path,
    )
    assert done.returncode == 2
    assert all(
        key in done.stderr
        for key in ("3 mistakes", "--torque", "--lost-motion-torque", "--slope-range")
    ), done.stderr
    found = lostmotion.gear(path, slope_range=("0 %", "100 %"))
    assert figure(found, "loop", "stiffness, slope").as_shown == pytest.approx(9.0)
    path.write_text(STATED["no torque"])
    with pytest.raises(InputError, match="no rated_torque"):
        lostmotion.gear(path, torque="60 N m", slope_range=("50 %", "100 %"))


def test_stated_scatter_sets_limits(tmp_path):
    """Stiffness ± 20 %, play 1' ± 0.3': wind-up 2' ± 0.4', displacement within the root of both
    squares.
    """
    (tmp_path / "x.toml").write_text(
        '[gearbox]\nratio = 100\nrated_torque = "20 N m"\nstiffness = "10 N m/arcmin"\n'
        'stiffness_scatter = "20 %"\nbacklash = "1 arcmin ± 0.3 arcmin"'
    )
    found = lostmotion.gear(tmp_path / "x.toml")
    wound, displacement = (
        figure(found, "loop", f"{name} at 20 N m") for name in ("wind-up", "displacement")
    )
    assert (wound.low, wound.high) == pytest.approx((1.6 * ARCMIN, 2.4 * ARCMIN))
    assert displacement.high - displacement.value == pytest.approx(math.hypot(0.15, 0.4) * ARCMIN)
    assert wound.ends == "stated limits"


def test_scatter_of_the_material_reaches_wind_up_and_stiffness():
    """A disc of a print whose modulus differs by ± 30 %: the samples' wind-up differs by as much of
    the disc's share, and without it hardly.
    """
    soft = {"young": "2.1 GPa", "poisson": 0.38, "density": "1270 kg/m^3"}
    stated = {"disc_bore_radius": "20 mm", "rated_torque": "2 N m", "discs": 1}
    plain_part, scattered = (
        CycloidalGearbox.model_validate(
            {**PLAIN, **stated, "disc_material": {**soft, **more}}, context={"text": True}
        )
        for more in ({}, {"scatter": "30 %"})
    )
    without, found = gear(plain_part, gearboxes=300), gear(scattered, gearboxes=300)
    assert without.read.wind_up.std() < 1e-9 * without.wind_up
    of_disc = sum(
        found.drawn.members[name] for name in ("disc body", "seat of the eccentric bearing")
    )
    # the contacts of a soft disc on a steel ring are the disc's own, by its share of 1/E*
    share = 210 / (1 - 0.3**2) / (210 / (1 - 0.3**2) + 2.1 / (1 - 0.38**2))
    assert found.read.wind_up.std() == pytest.approx(
        0.1 * (of_disc + share * found.drawn.members["lobe contacts"]), rel=0.15
    )
    assert found.read.slope.std() > 0.03 * found.read.slope.mean()


def test_what_is_not_specified_is_in_the_headline():
    """The first screen names the bounded members and their share, and those declared rigid; a
    drawing that specifies all of them says neither.
    """
    found = examined_gearbox("rv-like")
    assert (
        "Not specified and only bounded, less than 1 % of it: input shaft." in found.sheet.verdict
    )
    assert "At most" not in found.sheet.verdict
    stiff = {
        "frame": "900 N m/arcmin",
        "disc_bore_radius": "20 mm",
        "ring_outer_radius": "75 mm",
        "pin_span": "12 mm",
    }
    stated = {
        **stiff,
        "eccentric": {"bearing": "300 N/µm", "shaft": "300 N/µm"},
        "output_pins": {"count": 8, "circle_radius": "40 mm", "stiffness": "50 N/µm"},
    }
    whole = plain(**stated, input_shaft="1 N m/arcmin")
    assert whole.gearbox.bounded == ()
    for sentence in ("Not specified", "At most"):
        assert sentence not in whole.sheet.verdict
    assert "≤" not in str(figure(whole, "loop", "stiffness, slope"))
    rigid = plain(**stated, rigid=["input shaft"])
    assert "At most this stiff: declared rigid are input shaft." in rigid.sheet.verdict
    assert str(figure(rigid, "loop", "stiffness, slope")).startswith("≤ ")
    assert "≥ " in str(figure(rigid, "loop", "wind-up at 200 N m"))


def test_a_drawing_without_tolerances_claims_no_perfect_play():
    """Where nothing that opens play is described, play and lost motion are lower bounds, in the
    headline and on the cards; a relief, a tolerance or a preload is a description.
    """

    def cards(found):
        return {card.title: card.number for card in found.sheet.cards}

    no_relief = {key: value for key, value in PLAIN.items() if key != "relief"}
    part = CycloidalGearbox.model_validate(no_relief, context={"text": True})
    undescribed = replace(gear(part, 100.0, gearboxes=8), name="bare")
    assert "Play is at least 0 arcmin and lost motion at least 0." in undescribed.sheet.verdict
    assert "no relief, clearance or tolerance is described" in undescribed.sheet.verdict
    assert cards(undescribed)["play"] == "≥ 0 arcmin"
    assert cards(undescribed)["lost motion"].startswith("≥ 0.")
    for row in ("displacement at 100 N m", "lost motion"):
        assert all(str(figure(undescribed, "bands", row, k)).startswith("≥ ") for k in range(3))
    for stated in ({"relief": {"roller": "4 µm"}}, {"flank_form": "2 µm"}):
        part = CycloidalGearbox.model_validate({**no_relief, **stated}, context={"text": True})
        found = replace(gear(part, 100.0, gearboxes=8), name="stated")
        assert " on average over 8 simulated gearboxes" in found.sheet.verdict
        assert "≥" not in cards(found)["play"] + cards(found)["lost motion"]


def test_tables_of_preloaded_discs_agree_and_wind_up_forwards(monkeypatch):
    """Discs that press on each other: one wind-up in all three tables, above zero down to a small
    torque, and more of it under more torque.
    """
    # the transmission error, which no table of the wind-up shows, at one angle for each pin
    monkeypatch.setattr(examined, "_PER_PIN", 1)
    stated = {
        "relief": {"roller": "0 µm"},
        "pin_size": "6 µm",
        "flank_form": "6 µm",
        "rated_torque": "784 N m",
        "discs": 2,
    }
    part = CycloidalGearbox.model_validate({**PLAIN, **stated}, context={"text": True})
    wound = []
    for torque in (10.0, 784.0):
        found = replace(gear(part, torque, gearboxes=4), name="preloaded")
        tables = [
            figure(found, "loop", f"wind-up at {torque:.4g} N m"),
            figure(found, "members", "all together"),
            figure(found, "built", "wind-up: mean"),
        ]
        assert [each.value for each in tables] == pytest.approx([tables[0].value] * 3, rel=1e-12)
        assert sum(found.drawn.members.values()) == pytest.approx(tables[0].value)
        assert all(angle > 0 for angle in found.drawn.members.values())
        assert (
            figure(found, "loop", "lost motion").value
            == figure(found, "built", "lost motion: mean").value
        )
        wound.append(tables[0].value)
        assert (found.read.wind_up >= 0).all()
    assert found.drawn.jammed > 1
    assert 0 < wound[0] < wound[1]


def test_intervals_of_two_seeds_meet():
    """Other samples of the same drawing: whatever the sheet prints with an interval, both intervals
    hold common values, but for one in twenty.
    """
    sheets = [
        examined_gearbox("printed").sheet,
        lostmotion.gear(EXAMPLES / "printed.toml", gearboxes=100, seed=2).sheet,
    ]
    pairs = [
        (one, other)
        for sections in zip(*(sheet.sections for sheet in sheets), strict=True)
        for row in sections[0].rows
        if (twin := row_at([sections[1]], sections[1].key, row.key or key_of(row.label)))
        is not None
        for one, other in zip(row.cells, twin.cells, strict=True)
        if math.isfinite(one.low) and one.high > one.low
    ]
    assert len(pairs) > 35
    assert {
        section.key
        for section in sheets[0].sections
        if any(row.cells[0].interval for row in section.rows)
    } >= {
        "built",
        "loop",
        "transmission",
    }
    missed = sum(one.high < other.low or other.high < one.low for one, other in pairs)
    assert missed <= 0.05 * len(pairs)


def test_intervals_hold_the_true_value_as_often_as_they_say():
    """Sixty runs of forty samples of the printed drive: about 95 % of their intervals hold the
    value over all 2 400 samples.
    """
    part = examined_gearbox("printed").gearbox
    runs, each = 60, 40
    torque = np.array([-4.0, -0.12, 0.12, 4.0])
    made = samples.gearboxes(part, torque, 4, runs * each, seed=7)
    crank = 2 * math.pi * np.arange(64) / 64
    error = simulate(part.drive, part.scatter, np.array([4.0]), crank, runs * each, 7).rotation[0]
    square = ((error - error.mean(axis=0)) ** 2).mean(axis=0)
    power = np.abs(np.fft.rfft(error, axis=0)[3]) ** 2
    wound, lost = made.wind_up[3] - made.wind_up[0], made.play + made.wind_up[2] - made.wind_up[1]
    held = {}
    for name, values in {"wind-up": wound, "lost motion": lost}.items():
        ends = [over_samples(part, "rad", "") for part in values.reshape(runs, each)]
        held[name] = sum(found.low <= values.mean() <= found.high for found in ends)
        middles = [robots_quantile(part, 0.5) for part in values.reshape(runs, each)]
        held[f"{name}, median"] = sum(low <= np.median(values) <= high for _, low, high in middles)
    for name, values in {"error": square, "harmonic": power}.items():
        found = [root_mean_square_of_samples(part) for part in values.reshape(runs, each)]
        held[name] = sum(one.low <= math.sqrt(values.mean()) <= one.high for one in found)
    # 95 % of sixty are 57, give or take 3.4 of two deviations
    assert all(count >= 53 for count in held.values()), held
    assert 0.92 < sum(held.values()) / (runs * len(held)) < 0.985, held


def read_back(found):
    """Read a drawing as another program would."""
    return ezdxf.read(io.StringIO(found.drawing().decode()))


def polyline(drawing, layer):
    """Return the points (n, 2), mm, of the one closed polyline on a layer."""
    (line,) = drawing.modelspace().query(f'LWPOLYLINE[layer=="{layer}"]')
    assert line.closed
    return np.array(line.get_points("xy"))


def from_polygon(points, polygon):
    """How far are points from a closed polygon, whichever side is nearest?"""
    way = np.roll(polygon, -1, axis=0) - polygon
    away = points[:, None] - polygon
    share = np.clip((away * way).sum(-1) / (way**2).sum(-1), 0, 1)
    return np.linalg.norm(away - share[..., None] * way, axis=-1).min(axis=1)


def test_discs_of_the_drawing_lie_on_all_pins():
    """Put on its eccentric, each disc read back from the file touches all forty pins, but for the 4
    µm ground off: to a micrometre.
    """
    drawing = read_back(examined_gearbox("rv-like"))
    assert drawing.header["$INSUNITS"] == 4
    assert not drawing.audit().errors
    pins = drawing.modelspace().query('CIRCLE[layer=="PINS"]')
    places = np.array([pin.dxf.center.vec2 for pin in pins])
    assert len(pins) == 40
    assert {pin.dxf.radius for pin in pins} == {3.0}
    for disc, way in ((1, 1), (2, -1)):
        outline = polyline(drawing, f"DISC_{disc}") + np.array([way * 1.3, 0])
        np.testing.assert_allclose(from_polygon(places, outline), 3.004, atol=1e-3)
    assert [
        layer
        for layer in ("PIN_CIRCLE", "DISC_BORE", "RING_OUTSIDE", "CRANK_CENTRES")
        if layer not in drawing.layers
    ] == []
    assert [
        hole.dxf.radius for hole in drawing.modelspace().query('CIRCLE[layer=="CRANK_HOLES"]')
    ] == [16.5] * 2
    said = dict(drawing.header.custom_vars)
    assert 0 < float(said["largest chord error in µm"]) <= 0.5


def test_the_drawn_profile_is_the_true_one():
    """Every corner lies on the flank, and the flank nowhere further from a chord than the file
    says, over two teeth.
    """
    found = examined_gearbox("printed")
    drawing = read_back(found)
    part = found.gearbox
    outline = polyline(drawing, "DISC_1")
    error = 1e-3 * float(dict(drawing.header.custom_vars)["largest chord error in µm"])
    t = np.linspace(0, 2 * math.pi, 60_001)
    true = 1e3 * geometry.flank(part.stage, t, part.drive.relief)[0]
    assert from_polygon(true[:8000:21], outline).max() <= error + 1e-9
    assert from_polygon(outline[80:280:7], true[:8000]).max() < 1e-5
    holes = drawing.modelspace().query('CIRCLE[layer=="OUTPUT_HOLES"]')
    assert [hole.dxf.radius for hole in holes] == pytest.approx([2.5 + 1.2 + 0.075] * 6)
    # the ring lies nowhere inside the disc in its place
    ring = polyline(drawing, "RING")
    inside = np.linalg.norm(ring, axis=1).min()
    assert inside == pytest.approx(31.0, abs=1e-6)
    assert from_polygon(outline + np.array([1.2, 0]), ring).min() > 0.1


def test_two_stages_and_a_twin_are_drawn_too():
    """Layers of a first stage begin with FIRST_; pins of the twin belong to its planet, and its
    ring is the polyline.
    """
    two = read_back(examined_gearbox("two-stage-lobes"))
    assert len(polyline(two, "FIRST_RING")) > 12
    assert len(polyline(two, "FIRST_DISC_1")) > 11
    drawn = read_back(twin())
    ring = polyline(drawn, "RING")
    for planet, way in ((1, 1), (2, -1)):
        places = np.array(
            [
                pin.dxf.center.vec2
                for pin in drawn.modelspace().query(f'CIRCLE[layer=="PINS_{planet}"]')
            ]
        )
        np.testing.assert_allclose(
            from_polygon(places + np.array([way * 1.3, 0]), ring), 3.004, atol=1e-3
        )


@pytest.mark.usefixtures("unpainted")
def test_without_ezdxf_a_drawing_says_how_to_install_it(monkeypatch, tmp_path):
    """The report is written without it; asked for by itself, the drawing is refused with the
    command that helps.
    """
    monkeypatch.setattr(dxf, "can_draw", lambda: False)
    found = examined_gearbox("printed")
    with pytest.raises(LostmotionError, match=r"pip install 'lostmotion\[dxf\]'"):
        found.drawing()
    written = found.report(tmp_path / "out")
    assert sorted(path.name for path in written.iterdir()) == ["report.html", "result.json"]


def test_the_command_writes_the_same_bytes_twice(tmp_path):
    """It prints every section, writes page, figures and drawing, and the same bytes again with
    --force; without it the folder is left alone.
    """
    words = (EXAMPLES / "printed.toml", "--gearboxes", "8")
    done = ran(*words, "--dxf", "disc.dxf", "--full", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    for title in (
        "Geometry",
        "Load of the lobes",
        "Manufactured samples",
        "Stiffness and hysteresis",
        "Compliance by member",
        "Transmission error",
        "Friction",
    ):
        assert title in done.stdout
    folder = tmp_path / "printed-gearbox"
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert sorted(before) == ["profile.dxf", "report.html", "result.json"]
    assert (tmp_path / "disc.dxf").read_bytes() == before["profile.dxf"]
    assert b'href="profile.dxf"' in before["report.html"]
    result = json.loads(before["result.json"])
    assert (result["built"], result["seed"], result["torque_Nm"]) == (8, 1, 4.0)
    printed = {section["title"] for section in result["sections"]}
    assert all(title in done.stdout for title in printed)
    again = ran(*words, cwd=tmp_path)
    assert again.returncode == 2
    assert "--force" in again.stderr
    assert carried_out_by_process("gear", *words, "--force", cwd=tmp_path).returncode == 0
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


WRONG = {
    "unit.toml": (
        '[gearbox]\nkind = "cycloidal"\npins = 40\nring_radius = "64 N"\nwidth = "12 mm"\n',
        ("ring_radius", "pin_radius", "4 mistakes"),
    ),
    "shape.toml": (
        (
            '[gearbox]\nkind = "cycloidal"\nrated_torque = "9 N m"\npins = 40\nring_radius = '
            '"40 mm"\npin_radius = "3 mm"\n'
            'eccentricity = "1.3 mm"\nwidth = "9 mm"\n'
        ),
        ("loops because K1",),
    ),
    "key.toml": (
        '[gearbox]\nratio = 10\nbacklsh = "1 arcmin"\n',
        ("backlsh", "did you mean 'backlash'"),
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_file_is_one_message(tmp_path, name):
    """Exit code 2, one message with file and key and what belongs there, no traceback, and nothing
    is written.
    """
    text, said = WRONG[name]
    path = tmp_path / name
    path.write_text(text)
    done = ran(name, cwd=tmp_path)
    assert done.returncode == 2
    assert all(word in done.stderr for word in (name, *said)), done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("nothing.toml",), "no such file"),
        ((EXAMPLES / "printed.toml", "--torque", "2 mm"), "--torque"),
        ((EXAMPLES / "printed.toml", "--torque", "0 N m"), "--torque"),
        ((EXAMPLES / "printed.toml", "--torque", "1e9 N m"), "no equilibrium found"),
        ((EXAMPLES / "printed.toml", "--dxf", "nowhere/x.dxf"), "no folder 'nowhere'"),
        ((EXAMPLES.parent / "z-arm.toml",), "one of its joints with a gearbox"),
        (
            (EXAMPLES.parent / "z-arm.toml", "--joint", "A", "--dxf", "x.dxf"),
            "a gearbox with a drawing",
        ),
        ((EXAMPLES / "printed.toml", "--joint", "A"), "no joints"),
    ],
)
def test_impossible_input_is_one_message(tmp_path, words, said):
    """A mistake on the command line is one message with exit code 2, no traceback, and nothing is
    written.
    """
    done = ran(*words, cwd=tmp_path)
    assert done.returncode == 2, done.stderr
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())


def test_a_drawing_that_is_there_is_left_alone(tmp_path):
    """A file of that name is refused without --force, a folder always."""
    (tmp_path / "x.dxf").write_text("mine")
    (tmp_path / "folder").mkdir()
    for words in (("--dxf", "x.dxf"), ("--dxf", "folder", "--force")):
        assert ran(EXAMPLES / "printed.toml", *words, cwd=tmp_path).returncode == 2
    assert (tmp_path / "x.dxf").read_text() == "mine"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["folder", "x.dxf"]


@pytest.mark.usefixtures("unpainted")
def test_a_gearbox_out_of_an_arm(tmp_path):
    """An arm's file and a joint: the sheet of that joint's gearbox, as the reader of one part gives
    it.
    """
    done = ran(EXAMPLES.parent / "z-arm.toml", "--joint", "A", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert read_gearbox(EXAMPLES.parent / "z-arm.toml", "A").name in done.stdout


def test_counts_and_places_that_cannot_be_are_refused_before_the_work(tmp_path):
    """Counts beyond memory, loads of no bearing, places where nothing can be written: exit code 2,
    nothing is left.
    """
    (tmp_path / "full").write_text("a file")
    gearbox, bearing = EXAMPLES / "printed.toml", EXAMPLES.parent / "bearing" / "6209-pair.toml"
    for words, said in (
        (("gear", gearbox, "--gearboxes", 10**12), "100000"),
        (("gear", gearbox, "--dxf", "full/x.dxf"), "--dxf"),
        (("gear", gearbox, "--out", "full/out", "--gearboxes", 2), "--out"),
        (("bearing", bearing, "--built", 10**12), "1000000"),
        (("bearing", bearing, "--moment", "1e14 N m"), "at most 1e+09 N m"),
    ):
        done = carried_out(*words, cwd=tmp_path)
        assert (done.returncode, said in done.stderr, "Traceback" in done.stderr) == (
            2,
            True,
            False,
        ), (words, done.stderr)
    assert [path.name for path in tmp_path.iterdir()] == ["full"]


def test_assumed_values_of_a_drawing_are_counted_and_listed():
    """Every assumed key of a drawing, of its first stage and of its materials is listed, and in
    result.json; the headline counts their sources.
    """
    found = examined_gearbox("two-stage-lobes")
    gearbox = found.gearbox
    listed = found.sheet.facts["states"]["assumed"]
    stated = {("gearbox", key) for key in gearbox.assumed} | {
        ("gearbox.first_stage", key) for key in gearbox.first_stage.assumed
    }
    assert stated
    assert stated <= {(each["part"], each["key"]) for each in listed}
    assert (
        f"This rests on {found.sheet.facts['states']['assumed_count']} assumed values."
        in found.sheet.verdict
    )
    (section,) = (each for each in found.sheet.sections if each.key == "inputs")
    assert all(key in " ".join(row.cells[0].words for row in section.rows) for _, key in stated)


@pytest.mark.usefixtures("unpainted")
@pytest.mark.parametrize(
    ("stands", "keys"),
    [("gearbox", {"backlash"}), ("joint", {"backlash", "stiffness", "rated_torque"})],
)
def test_assumed_values_of_stated_figures_reach_screen_and_result(tmp_path, stands, keys):
    """A play that is assumed by its table, or a gearbox that is assumed as a whole by its joint, is
    so on the screen and in result.json.
    """
    own = 'assumed = ["backlash"], ' if stands == "gearbox" else ""
    whole = 'assumed = ["gearbox"]' if stands == "joint" else ""
    (tmp_path / "arm.toml").write_text(
        'name = "arm"\n[[joints]]\nname = "a"\ntype = "revolute"\naxis = "z"\nlimits = ["-90 '
        f'deg", "90 deg"]\n{whole}\n'
        f'gearbox = {{ {own}backlash = "1 arcmin", stiffness = "20 N m/arcmin", rated_torque = '
        f'"100 N m", friction_torque = "1 N m ± 0 %" }}\n'
    )
    done = ran("arm.toml", "--joint", "a", "--out", "out", "--full", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "What went in" in done.stdout
    assert " assumed value" in done.stdout
    assumed = json.loads((tmp_path / "out" / "result.json").read_text())["states"]["assumed"]
    assert keys <= {each["key"] for each in assumed}
    assert {each["reason"] for each in assumed} == {"assumed"}
    assert "What went in" in (tmp_path / "out" / "report.html").read_text()


def test_a_gearbox_that_is_stated_in_full_rests_on_nothing_assumed(tmp_path):
    """Where no value is assumed neither the headline nor a table says so."""
    path = tmp_path / "stated.toml"
    path.write_text(f'{STATED["worm"]}\nfriction_torque = "1 N m ± 0.2 N m"')
    sheet = lostmotion.gear(path).sheet
    assert sheet.facts["states"]["assumed"] == []
    assert "assumed" not in sheet.verdict


def test_a_stated_play_of_zero_is_no_ideal_one_and_only_its_own_row_is_noted(tmp_path):
    """A strain wave gear whose row states no play is not called ideal in it, and no note on the
    reducer of another joint is printed.
    """
    joints = (
        (
            f'[[joints]]\nname = "{name}"\ntype = "revolute"\naxis = "z"\nlimits = ["-90 deg", "90 '
            f'deg"]\ngearbox = "{model}"\n'
        )
        for name, model in (("a", "RV-20E-121"), ("c", "CSG-20-100"))
    )
    (tmp_path / "arm.toml").write_text('name = "arm"\n' + "".join(joints))
    sheet = lostmotion.gear(tmp_path / "arm.toml", "c").sheet
    assert sheet.verdict.startswith("A catalogue gearbox by stated figures.")
    assert not any("RV-20E" in note for note in sheet.notes)
    assert any(note.startswith("CSG-20-100 is taken from the catalogue") for note in sheet.notes)


def test_a_gearbox_of_ones_own_is_none_of_the_catalogue(tmp_path):
    """A user's own gearbox is not called one of the catalogue; what it states as zero is stated,
    and what it omits is ideal.
    """
    path = tmp_path / "own.toml"
    path.write_text(
        '[gearbox]\nbacklash = "0 arcmin"\nhysteresis = "0 arcmin"\ntransmission_error = "0 arcmin"'
    )
    assert lostmotion.gear(path).sheet.verdict.startswith(
        "A gearbox by stated figures; not specified and assumed ideal: stiffness."
    )
