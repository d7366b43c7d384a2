"""The cycloidal gearbox from its drawing: what it makes of the laws, what it bounds, what it
refuses.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.optimize import brentq

from lostmotion.io.part_file import read_gearbox
from lostmotion.laws.cycloid import geometry
from lostmotion.laws.cycloid.simulated import simulate
from lostmotion.parts.error_source import Friction
from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox, model, samples
from lostmotion.parts.gearbox.cycloidal.model import LEVELS, LOST_MOTION, Behaviour, wind_up
from lostmotion.parts.gearbox.cycloidal.names import BOUNDED
from lostmotion.parts.gearbox.cycloidal.samples import SEED, gearboxes
from lostmotion.parts.gearbox.cycloidal.states import bounds, unknowns
from lostmotion.parts.joint import RevoluteJoint
from tests.parts.conditions import ARCMIN, condition, terms_at

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "a steel RV-like drive from its drawing",
        "makers' 2.5' to 6' at rated torque, lost motion up to 1'",
        "3.3', 0.8'",
    ),
)

EXAMPLES = Path(__file__).parents[2] / "examples" / "gearbox"
NAMES = ("rv-like", "two-stage-lobes", "printed")

DRAWING: dict[str, Any] = {
    "kind": "cycloidal",
    "rated_torque": "400 N m",
    "pins": 40,
    "ring_radius": "64 mm",
    "pin_radius": "3 mm",
    "eccentricity": "1.3 mm",
    "width": "12 mm",
    "discs": 2,
}
# One field each that gives the member a spring, and the same spring half as stiff or softer.
SPRINGS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "lobe contacts": (
        {},
        {"disc_material": {"young": "100 GPa", "poisson": 0.3, "density": "7850 kg/m^3"}},
    ),
    "ring pins": ({"pin_span": "14 mm"}, {"pin_span": "28 mm"}),
    "disc body": ({"disc_bore_radius": "20 mm"}, {"disc_bore_radius": "12 mm"}),
    "ring body": ({"ring_outer_radius": "75 mm"}, {"ring_outer_radius": "90 mm"}),
    "eccentric bearing": (
        {"eccentric": {"rollers": 18, "roller_length": "12 mm"}},
        {"eccentric": {"rollers": 18, "roller_length": "6 mm"}},
    ),
    "eccentric shaft": ({"eccentric": {"shaft": "800 N/µm"}}, {"eccentric": {"shaft": "400 N/µm"}}),
    "output pins": (
        {
            "output_pins": {
                "count": 8,
                "circle_radius": "40 mm",
                "diameter": "14 mm",
                "free_length": "14 mm",
            }
        },
        {
            "output_pins": {
                "count": 8,
                "circle_radius": "40 mm",
                "diameter": "10 mm",
                "free_length": "14 mm",
            }
        },
    ),
    "first stage": (
        {
            "first_stage": {
                "kind": "planetary",
                "sun_teeth": 16,
                "planet_teeth": 32,
                "module": "1.25 mm",
                "mesh_stiffness": "140 N/µm",
            }
        },
        {
            "first_stage": {
                "kind": "planetary",
                "sun_teeth": 16,
                "planet_teeth": 32,
                "module": "1.25 mm",
                "mesh_stiffness": "70 N/µm",
            }
        },
    ),
    "frame": ({"frame": "800 N m/arcmin"}, {"frame": "400 N m/arcmin"}),
    "input shaft": ({"input_shaft": "1 N m/arcmin"}, {"input_shaft": "0.5 N m/arcmin"}),
}


def drawing(**more: Any) -> CycloidalGearbox:
    """Return a steel gearbox with these fields besides."""
    return CycloidalGearbox.model_validate({**DRAWING, **more}, context={"text": True})


def wind_up_at(found: Behaviour, torque: float) -> float:
    """Return the wind-up (rad) under a torque (N m), straight between the levels."""
    return float(np.interp(torque, found.torque, found.total))


def example(name: str) -> CycloidalGearbox:
    """Read one of the examples."""
    part = read_gearbox(EXAMPLES / f"{name}.toml").part
    assert isinstance(part, CycloidalGearbox)
    return part


@pytest.mark.parametrize("name", SPRINGS)
def test_every_spring_has_a_line_and_softening_it_softens_the_gearbox(name):
    """Not specified: bounded or assumed, never rigid in silence. Stated: not bounded, with a
    wind-up of its own. Softer: the whole winds up more.
    """
    plain, (stiff, soft) = drawing(), SPRINGS[name]
    torque = np.array([40.0, 400.0])
    stated, softer = drawing(**stiff), drawing(**{**stiff, **soft})
    if stiff and name != "first stage":
        assert plain.states[name].kind in ("bounded", "assumed")
        line = f"{name}{BOUNDED}" if name in plain.bounded else name
        # in seats along their full length
        assert (wind_up(plain, torque)[line] > 0).all() or name == "ring pins"
    assert name not in stated.bounded
    assert stated.states[name].kind in ("stated", "computed")
    assert (wind_up(stated, torque)[name] > 0).all()
    assert (sum(wind_up(softer, torque).values()) > sum(wind_up(stated, torque).values())).all()


def test_the_list_of_bounded_members_is_whole():
    """A drawing that states no spring bounds every one that cannot be computed, its first stage's
    too; cranks that carry the output need no pins.
    """
    first = {
        "kind": "cycloidal",
        "pins": 12,
        "ring_radius": "32 mm",
        "pin_radius": "4 mm",
        "eccentricity": "1.6 mm",
        "width": "8 mm",
    }
    stage = {"eccentric bearing", "eccentric shaft", "output pins"}
    silent = drawing(first_stage=first)
    assert set(silent.bounded) == {
        *stage,
        *(f"first stage, {name}" for name in stage),
        "frame",
        "input shaft",
    }
    assert {name for name, state in silent.states.items() if state.kind == "assumed"} >= {
        "disc body",
        "ring body",
        "ring pins",
    }
    listed = silent.not_specified.split(", ")
    assert len(set(listed)) == len(listed)  # each once, with the stage that it is of
    assert "output pins of the first stage" in listed
    assert (
        drawing(eccentric={"cranks": 2, "circle_radius": "36 mm"}).states["output pins"].kind
        == "absent"
    )
    planetary = drawing(
        first_stage={"kind": "planetary", "sun_teeth": 16, "planet_teeth": 32, "module": "1.25 mm"}
    )
    assert "first stage" in planetary.bounded
    assert set(bounds(planetary)) == set(planetary.bounded)


def test_a_bounded_member_is_compared_with_the_computed_ones():
    """0.05 to 1 times all of them together: the geometric mean in the tables; members before the
    eccentric at most a hundredth at a ratio of 15.
    """
    torque = np.array([40.0, 400.0])
    found = wind_up(drawing(), torque)
    computed = sum(angle for name, angle in found.items() if not name.endswith(BOUNDED))
    np.testing.assert_allclose(found[f"frame{BOUNDED}"], math.sqrt(0.05) * computed, rtol=1e-12)
    assert bounds(drawing())["input shaft"] == pytest.approx(
        (0.05 * 0.01 * (15 / 39) ** 2, 0.01 * (15 / 39) ** 2)
    )
    frame = next(each for each in unknowns(drawing()) if each.name == "frame")
    assert (frame.factor.low, frame.factor.high) == pytest.approx(
        (math.sqrt(0.05), 1 / math.sqrt(0.05))
    )
    assert frame.shares == {f"frame{BOUNDED}": 1.0}


def test_members_declared_rigid_are_ideal():
    """They have no line, and the state says that they are declared so; an unknown name is
    refused.
    """
    torque = np.array([40.0, 400.0])
    names = (
        "frame",
        "input shaft",
        "disc body",
        "ring body",
        "eccentric bearing",
        "eccentric shaft",
        "output pins",
    )
    rigid = drawing(rigid=names)
    assert all(str(rigid.states[name]) == "ideal: declared rigid" for name in names)
    assert rigid.bounded == ()
    assert {name for name, angle in wind_up(rigid, torque).items() if angle.any()} == {
        "lobe contacts"
    }
    stated = {"eccentric": {"bearing": "300 N/µm", "shaft": "300 N/µm"}, "frame": "900 N m/arcmin"}
    same = wind_up(drawing(**stated, rigid=names), torque)
    np.testing.assert_allclose(sum(same.values()), sum(wind_up(rigid, torque).values()), rtol=1e-12)
    with pytest.raises(ValidationError, match="'frane' in rigid"):
        drawing(rigid=["frane"])


def test_ratios():
    """RV-80E: 10/38 teeth and 40 pins make 153. Stages multiply; each cycloidal one turns its
    output the other way round, the ring as output not.
    """
    planetary = {"kind": "planetary", "sun_teeth": 10, "planet_teeth": 38, "module": "1 mm"}
    large = {"ring_radius": "77.5 mm", "pin_radius": "4 mm", "eccentricity": "1.5 mm"}
    assert drawing(**large, first_stage=planetary).ratio == pytest.approx(153)
    assert drawing(**large, first_stage=planetary, fixed="carrier").ratio == pytest.approx(-152)
    assert drawing().ratio == -39
    assert drawing(fixed="carrier").ratio == 40
    assert example("two-stage-lobes").ratio == 11 * 23
    twin = drawing(form="planet pins", pins=39, eccentricity="1.2 mm")
    assert (twin.ratio, twin.model_copy(update={"fixed": "carrier"}).ratio) == (-39, 40)


def test_a_steel_drive_of_the_rv_kind_winds_up_as_such_drives_do():
    """2.5' to 6' at its rated torque, of which the mesh is a few per cent; lost motion of the size
    that makers print, up to 1'.
    """
    found = example("rv-like").behaviour
    whole = wind_up_at(found, 412.0) / ARCMIN
    assert 2.5 < whole < 6
    assert found.wind_up["lobe contacts"][6] / ARCMIN < 0.08 * whole
    assert max(found.wind_up, key=lambda name: found.wind_up[name][6]).startswith("eccentric")
    assert 0.3 < found.lost_motion.mean() / ARCMIN < 1.0


def test_more_than_five_lobes_share_the_load_of_the_drive_without_rolling_bodies():
    """Simulated samples, at rated torque."""
    from lostmotion.laws.cycloid.drive import loaded_disc
    from lostmotion.laws.cycloid.tolerances import sample_gaps

    gearbox = example("two-stage-lobes")
    crank = np.linspace(0, 2 * math.pi, 9)
    gap = sample_gaps(gearbox.drive, gearbox.scatter, crank, 100, 1)
    lobes = [
        loaded_disc(gearbox.drive, 167.0 / 2, crank + math.pi * disc, gap[disc]).lobes
        for disc in (0, 1)
    ]
    assert (lobes[0] + lobes[1] > 5).all()
    # of one disc by itself; contacts of the second branch, which stiffen those counted here and so
    # leave more lobes in their gaps, not included
    assert (lobes[0] > 5).mean() > 0.85


def test_lost_motion_is_play_and_the_wind_up_both_ways_at_3_per_cent():
    """Without scatter by the drawing's own figures; a first stage's play reaches the output divided
    by the ratio.
    """
    planetary = {
        "kind": "planetary",
        "sun_teeth": 16,
        "planet_teeth": 32,
        "module": "1.25 mm",
        "play": "20 µm",
    }
    gearbox = drawing(
        relief={"roller": "5 µm"},
        eccentric={"shaft": "300 N/µm"},
        frame="500 N m/arcmin",
        first_stage=planetary,
    )
    found = gearbox.behaviour
    lever = gearbox.stage.planet_pitch_radius
    # between pin positions the free play is up to 3.5 % larger than the formula's
    assert found.play.mean() == pytest.approx(
        2 * 5e-6 / lever + 20e-6 / (0.010 * gearbox.ratio), rel=0.01
    )
    np.testing.assert_allclose(
        found.lost_motion - found.play, 2 * wind_up_at(found, LOST_MOTION * 400), rtol=0.02
    )
    assert found.play.std() < 1e-12
    first = {
        "kind": "cycloidal",
        "pins": 12,
        "ring_radius": "32 mm",
        "pin_radius": "4 mm",
        "eccentricity": "1.6 mm",
        "width": "8 mm",
    }
    first["relief"] = {"roller": "10 µm"}
    assert drawing(first_stage=first).behaviour.play.mean() == pytest.approx(
        2 * 10e-6 / (1.6e-3 * 11) / 39, rel=0.06
    )


def test_the_ring_as_output_turns_less_under_a_larger_torque():
    """The same stage with its carrier held: torque and angle of the ring are z/N of the disc's, per
    turn of the same mesh.
    """
    torque = np.array([390.0])
    ring_out = wind_up(drawing(fixed="carrier", eccentric={"shaft": "300 N/µm"}), torque * 40 / 39)
    disc_out = wind_up(drawing(eccentric={"shaft": "300 N/µm"}), torque)
    for name in ("lobe contacts", "eccentric shaft"):
        np.testing.assert_allclose(ring_out[name] * 40 / 39, disc_out[name])


def test_terms_fall_as_the_built_gearboxes_do():
    """Mean and deviation of the output's angle over robots, from the terms, against as many
    gearboxes solved one by one, at three loads.
    """
    gearbox = example("rv-like")
    joint = RevoluteJoint(name="A", limits=(-1.0, 1.0), gearbox=gearbox)
    count = 400
    for torque in (20.0, 140.0, 400.0):
        at = condition((0, 0, torque, 0, 0, 0))
        mean = variance = 0.0
        for source in joint.sources.values():
            for term in terms_at(source, at):
                angle = float(np.atleast_2d(term.screw)[0, 2])
                if term.level == "design":
                    mean += angle
                elif term.level == "robot" and "per turn" not in term.name:
                    variance += angle**2
        simulate = gearboxes(gearbox, np.array([torque]), 6, count, seed=5)
        rest = sum(
            angle
            for name, angle in wind_up(gearbox, np.array([torque])).items()
            if name in ("first stage", "frame", "input shaft")
        )
        whole = simulate.play / 2 + simulate.wind_up[0] + rest
        assert mean == pytest.approx(whole.mean(), rel=0.03)
        assert math.sqrt(variance) == pytest.approx(_deviation(simulate), rel=0.25)


def _deviation(simulate: Any) -> float:
    """Return the deviation of half the play and of the wind-up, each by itself, for the terms draw
    them apart.
    """
    return math.hypot((simulate.play / 2).std(), simulate.wind_up[0].std())


def test_sources_carry_the_names_of_parts():
    """So that a budget can say 'eccentric bearing'; without load no spring is wound up, and the
    play is anywhere.
    """
    joint = RevoluteJoint(name="A", limits=(-1.0, 1.0), gearbox=example("rv-like"))
    names = set(joint.sources)
    assert {
        "gearbox play",
        "gearbox eccentric bearing",
        "gearbox eccentric shaft",
        "gearbox disc body",
        "gearbox transmission error",
    } <= names
    for name, source in joint.sources.items():
        for term in terms_at(source, condition()):
            if term.name == "wind-up" or "side held" in term.name:
                assert not np.any(term.screw), name
        for term in terms_at(source, condition((0, 0, -300.0, 0, 0, 0))):
            if term.closed is None and (term.name == "wind-up" or "side held" in term.name):
                assert np.atleast_2d(term.screw)[0, 2] < 0, name


def test_an_output_encoder_sees_what_the_gearbox_does():
    """Then nothing of it is left but the play, where no load closes it."""
    joint = RevoluteJoint(
        name="A", limits=(-1.0, 1.0), gearbox=example("rv-like"), encoder={"side": "output"}
    )
    assert set(joint.sources) == {"gearbox", "encoder"}
    play = joint.gearbox.members["play"]
    left = [term for term in terms_at(joint.sources["gearbox"], condition()) if term.closed is None]
    assert [term.level for term in left] == ["visit", "robot x visit"]
    scatter = play.play.tolerance / play.play.nominal / 3.0
    whole = math.hypot(*(term.screw[0, 2] for term in left))
    assert whole == pytest.approx(
        play.play.nominal / 2 / math.sqrt(3) * math.hypot(1, scatter), rel=0.01
    )
    closed = terms_at(
        joint.sources["gearbox"], condition((0, 0, 1.5 * play.friction.load.nominal, 0, 0, 0))
    )
    assert not any(term.screw.any() for term in closed)


@pytest.mark.parametrize("name", NAMES)
def test_transmission_error_keeps_its_mean_square(name):
    """The few harmonics kept have the mean square of all, over gearboxes and angles; printed drives
    err by minutes, ground ones by seconds.
    """
    gearbox = example(name)
    found = gearbox.behaviour
    assert 0 <= found.neglected_share < 0.2
    whole = math.sqrt(sum(float(harmonic.size[-1]) ** 2 for harmonic in found.harmonics))
    assert all(harmonic.cycles % abs(gearbox.steps) == 0 for harmonic in found.harmonics)
    assert (0.5 * ARCMIN < whole < 10 * ARCMIN) if name == "printed" else (whole < 0.2 * ARCMIN)


def test_friction_makes_a_loop_by_the_way_of_arriving():
    """Its side is the approach's, its half width what friction leaves wound up; without
    coefficients there is none.
    """
    gearbox = example("two-stage-lobes")
    source = gearbox.members["friction"]
    held = next(
        term
        for term in terms_at(source, condition((0, 0, 100.0, 0, 0, 0), approach=1.0))
        if term.level == "design"
    )
    found = gearbox.behaviour
    # the springs behind the friction carry T_e, with T_e + F(T_e) = 100 N m on the way up and T_e -
    # F(T_e) = 100 N m on the way down, and the output pins rub by the load itself
    friction, pins = found.friction.in_loop, 100 * found.friction.pins
    carried = [
        brentq(
            lambda each, sign=sign: (
                each + sign * (np.interp(each, found.torque, friction) + pins) - 100.0
            ),
            1.0,
            400.0,
        )
        for sign in (1, -1)
    ]
    beyond = ("frame", "output pins", "holes of the output pins", "seats of the output pins")
    behind = found.total - sum(found.wind_up[name] for name in beyond)
    up, down = np.interp(carried, found.torque, behind)
    assert held.screw[0, 2] == pytest.approx(-(down - up) / 2)
    assert "friction" not in drawing().members


@pytest.mark.parametrize("name", ["rv-like", "two-stage-lobes", "printed"])
@pytest.mark.parametrize("share", [0.02, 0.1, 0.5])
def test_friction_never_leaves_more_than_what_it_winds_up(name: str, share: float):
    """A drive that starts soft, held by a friction torque: at rest the loop is twice the wind-up at
    that torque, under load never twice w(T + F).
    """
    gearbox = example(name)
    friction = share * gearbox.rated_torque
    found = gearbox.model_copy(
        update={"friction_torque": Friction.of_load(friction), "friction": None}
    ).behaviour
    loop, torque = found.loop, gearbox.rated_torque * np.linspace(-2, 2, 81)
    rising, falling = loop.branches(torque)
    # by hand, on the table of the spring itself
    behind = (
        found.total - found.wind_up.get("frame", 0.0) - found.wind_up.get(f"frame{BOUNDED}", 0.0)
    )
    table, angle = (
        np.concatenate([-found.torque[:0:-1], found.torque]),
        np.concatenate([-behind[:0:-1], behind]),
    )
    np.testing.assert_allclose(
        rising, np.interp(torque - friction, table, angle), rtol=1e-12, atol=1e-15
    )
    np.testing.assert_allclose(
        falling, np.interp(torque + friction, table, angle), rtol=1e-12, atol=1e-15
    )
    most = np.interp(np.abs(torque) + friction, table, angle)
    assert (falling - rising <= 2 * most * (1 + 1e-12)).all()
    at = condition(approach=-1.0)
    held = next(term for term in terms_at(loop, at) if term.level == "design")
    assert held.screw[0, 2] == pytest.approx(np.interp(friction, found.torque, behind))


def test_a_material_that_scatters_makes_the_wind_up_scatter():
    """By its share of the contacts and the body."""
    soft = {"young": "2.1 GPa", "poisson": 0.38, "density": "1270 kg/m^3", "scatter": "20 %"}
    source = drawing(rated_torque="2 N m", disc_material=soft, disc_bore_radius="20 mm").members[
        "disc body"
    ]
    terms = {term.name: term for term in terms_at(source, condition((0, 0, 2.0, 0, 0, 0)))}
    scatter = terms["material scatter"]
    assert scatter.screw[0, 2] * scatter.bound == pytest.approx(0.2 * terms["wind-up"].screw[0, 2])


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"eccentricity": "1.7 mm"}, "loops"),
        ({"pin_radius": "6 mm"}, "largest possible"),
        ({"disc_bore_radius": "62 mm"}, "bore"),
        ({"ring_outer_radius": "66 mm"}, "ring of outer radius"),
        ({"form": "lobe envelope", "ring_outer_radius": "63.5 mm"}, "lobes with roots out"),
        ({"form": "planet pins", "pins": 20, "ring_outer_radius": "68 mm"}, "lobes with roots out"),
        ({"relief": {"circle": "13 mm"}}, "loops"),
        ({"eccentric": {"rollers": 16}}, "incomplete or doubly stated"),
        ({"eccentric": {"cranks": 2}}, "without circle_radius"),
        (
            {
                "eccentric": {"cranks": 2, "circle_radius": "30 mm"},
                "output_pins": {"count": 6, "circle_radius": "30 mm"},
            },
            "both output pins",
        ),
        (
            {"output_pins": {"count": 6, "circle_radius": "30 mm", "diameter": "8 mm"}},
            "incomplete or doubly stated",
        ),
        ({"form": "lobe arcs", "pin_span": "10 mm"}, "pin_span"),
        ({"contact_law": "palmgren", "disc_bore_radius": "20 mm"}, "bodies"),
        (
            {
                "eccentric": {"cranks": 2, "circle_radius": "30 mm"},
                "first_stage": {
                    "kind": "planetary",
                    "sun_teeth": 16,
                    "planet_teeth": 32,
                    "module": "1 mm",
                    "planets": 3,
                },
            },
            "3 planets on 2 cranks",
        ),
    ],
)
def test_impossible_drawings_are_refused_with_their_reason(wrong, said):
    """One message that says why, and shows what passes."""
    with pytest.raises(ValidationError, match=said) as caught:
        drawing(**wrong)
    (detail,) = caught.value.errors()
    assert detail["ctx"]["expected"]
    assert "=" in detail["ctx"]["example"]


def test_harmonics_of_two_stages_at_one_frequency_add_up():
    """253 turns of the input make one of the output: the 11th harmonic of the last crank is the
    first one of the input.
    """
    gearbox = example("two-stage-lobes")
    whole = sum(float(harmonic.size[-1]) ** 2 for harmonic in gearbox.behaviour.harmonics)
    alone = gearbox.model_copy(update={"first_stage": None})
    assert whole > sum(float(harmonic.size[-1]) ** 2 for harmonic in alone.behaviour.harmonics)


@pytest.mark.parametrize(("relief", "jams"), [("4 µm ± 1 µm", False), ("1 µm ± 0.5 µm", True)])
def test_lost_motion_is_what_a_test_bench_would_read(relief, jams):
    """The way between the middles at +3 % and -3 % of the rated torque, solved for; where flanks
    interfere there is less of it.
    """
    stated = {"relief": {"roller": relief}, "pin_position": "1.5 µm", "flank_form": "2 µm"}
    rigid = ("output pins", "input shaft", "eccentric bearing")
    gearbox = drawing(
        **stated, eccentric={"shaft": "300 N/µm"}, frame="500 N m/arcmin", rigid=rigid
    )
    found = gearbox.behaviour
    assert (found.jammed > 0.02) == jams
    small = LOST_MOTION * 400
    crank = 2 * math.pi * np.arange(4) / 4
    made = simulate(
        gearbox.drive, gearbox.scatter, np.array([-small, small]), crank, model.GEARBOXES, SEED
    )
    read = (made.rotation[1] - made.rotation[0]).mean(axis=0) + 2 * small / gearbox.frame
    # which torques are solved besides shifts a little how two discs share them, most where they
    # press against each other
    assert found.lost_motion.mean() == pytest.approx(read.mean(), rel=0.05 if jams else 0.005)
    assert found.scatter[LEVELS.index(LOST_MOTION) + 1] < 0.06 * ARCMIN


def test_friction_without_load_holds_the_output_where_it_stopped():
    """A stated friction torque makes a loop at no load already, as wide both ways as it winds the
    gearbox up; unstated, there is none.
    """
    gearbox = drawing(friction_torque="10 N m", eccentric={"shaft": "300 N/µm"}, rigid=["frame"])
    assert gearbox.behaviour.friction.in_loop[0] == 10.0
    held = next(
        term
        for term in terms_at(gearbox.members["friction"], condition(approach=-1.0))
        if term.level == "design"
    )
    assert held.screw[0, 2] == pytest.approx(wind_up_at(gearbox.behaviour, 10.0))


def test_two_preloaded_discs_wind_up_forwards(monkeypatch):
    """Pins and flanks off by 6 µm and nothing ground off for them: the pair rests preloaded, and
    from there turns with the torque, ever further.
    """
    stated = {
        "relief": {"roller": "0 µm"},
        "pin_size": "6 µm",
        "flank_form": "6 µm",
        "rated_torque": "784 N m",
    }
    gearbox = drawing(**stated)
    torque = 784 * np.array([0.003, 0.03, 0.3, 1.0])
    monkeypatch.setattr(model, "GEARBOXES", 32)  # of the mean of its wind-up
    made = gearboxes(gearbox, np.concatenate([-torque, torque]), 4, 20)
    assert made.jammed > 0.2
    ahead, behind = made.wind_up[4:], made.wind_up[:4]
    assert (np.diff(ahead, axis=0, prepend=0.0) > -1e-15).all()
    assert (np.diff(behind, axis=0, prepend=0.0) < 1e-15).all()
    assert (made.play >= 0).all()
    assert (np.diff(gearbox.behaviour.total) > 0).all()


@pytest.mark.parametrize(
    ("form", "radius"), [("lobe envelope", "63.7 mm"), ("lobe arcs", "64.1 mm")]
)
def test_a_ring_of_one_piece_with_its_lobes_needs_room_for_no_pins(form, radius):
    """Roots lie at R - Rr + 2 e = 63.6 mm: a ring beyond them holds, though pins of 3 mm on 64 mm
    would reach out to 67 mm.
    """
    thin = drawing(form=form, ring_outer_radius=radius)
    assert thin.states["ring body"].kind == "computed"
    thick = drawing(form=form, ring_outer_radius="75 mm")
    torque = np.array([40.0, 400.0])
    of_thin, of_thick = (wind_up(each, torque)["ring body"] for each in (thin, thick))
    assert np.isfinite(of_thin).all()
    assert (of_thin < of_thick).all()
    with pytest.raises(ValidationError, match="pins that reach out to 67 mm"):
        drawing(ring_outer_radius="66 mm")


def test_a_larger_pin_circle_closes_what_a_larger_roller_opens():
    """10 µm of roller, and 8 µm of circle to either side: a smaller one adds 2 dR sqrt(1 - K1^2)/(e
    z) of play, a larger one takes more.
    """
    lever, k1 = 0.0013 * 39, 0.8125
    found = {}
    for circle in (-8e-6, 0.0, 8e-6):
        gearbox = drawing(relief={"roller": "10 µm", "circle": f"{circle * 1e6:g} µm"})
        found[circle] = gearbox.behaviour.play.mean()
        assert found[circle] == pytest.approx(
            geometry.play(gearbox.stage, gearbox.drive.relief), rel=0.04
        )
    more = 2 * 8e-6 * math.sqrt(1 - k1**2) / lever
    assert found[8e-6] - found[0.0] == pytest.approx(more, rel=0.05)
    assert found[0.0] - found[-8e-6] > more
    assert found[-8e-6] > 0


def test_members_outside_the_contacts_cost_no_second_simulation():
    """Drawings that differ only in their frame share their simulated gearboxes; one with other
    tolerances does not.
    """
    stiff, soft = (drawing(frame=f"{each} N m/arcmin") for each in (800, 400))
    load = np.array([10.0])
    before = samples._simulated.cache_info().misses
    one, two = (gearboxes(each, load, 2, 4) for each in (stiff, soft))
    assert samples._simulated.cache_info().misses == before + 1
    assert (one.play == two.play).all()
    gearboxes(drawing(pin_position="2 µm"), load, 2, 4)
    assert samples._simulated.cache_info().misses == before + 2


def test_a_drive_with_nothing_but_elastic_flanks_and_bodies_winds_up_by_them():
    """Every member that the drawing leaves open may be declared rigid; lost motion is then that of
    flanks, disc and ring.
    """
    found = drawing()
    stiff = found.model_copy(update={"rigid": found.bounded})
    assert not stiff.bounded
    assert set(stiff.behaviour.wind_up) < set(found.behaviour.wind_up)
    assert stiff.behaviour.lost_motion.mean() < found.behaviour.lost_motion.mean()
