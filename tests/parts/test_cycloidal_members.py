"""Members of a drawn cycloidal gearbox by their dimensions: output pins with seats, sleeves and
holes, discs with holes, the eccentric's shaft.
"""

from __future__ import annotations

import math
from copy import deepcopy
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from pydantic import ValidationError

import lostmotion
from lostmotion.errors import InputError
from lostmotion.laws.perforated_disc_series import Holes
from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
from lostmotion.parts.gearbox.cycloidal.materials import material_shares
from lostmotion.parts.gearbox.cycloidal.model import wind_up
from lostmotion.parts.gearbox.cycloidal.names import BOUNDED
from lostmotion.parts.gearbox.cycloidal.states import unknowns
from lostmotion.parts.term import Motion
from tests.parts.conditions import condition, terms_at

if TYPE_CHECKING:
    from pathlib import Path

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "frame screws, tubes, bearings by their size",
        "a pin in its seat; a thin tube; the 6000 bearing's 7 balls",
        "3 to 5 N/µm for an M3; 0.2 %; exact",
        "laws/screw_circle.py laws/rolling/by_size.py tests/laws/test_screw_circle.py",
    ),
)

PLASTIC = {"young": "2.4 GPa", "poisson": 0.36, "density": "1200 kg/m^3"}
STEEL = {"young": "210 GPa", "poisson": 0.3, "density": "7850 kg/m^3"}
SEAT = {"depth": "6 mm", "material": PLASTIC, "outer_diameter": "14 mm", "fit": "pressed"}
DRAWING: dict[str, Any] = {
    "kind": "cycloidal",
    "form": "lobe arcs",
    "rated_torque": "4 N m",
    "pins": 16,
    "ring_radius": "34 mm",
    "pin_radius": "3 mm",
    "eccentricity": "1.2 mm",
    "width": "8 mm",
    "disc_material": PLASTIC,
    "ring_material": PLASTIC,
    "disc_bore_radius": "10 mm",
    "ring_outer_radius": "42 mm",
    "eccentric": {
        "bearing": "40 N/µm",
        "shaft": {
            "disc_at": ["16 mm"],
            "supports": [
                {"at": "0 mm", "bearing": "30 N/µm", "seat": "housing"},
                {"at": "43 mm", "bearing": "60 N/µm", "seat": "housing"},
            ],
            "sections": [
                {"to": "4 mm", "diameter": "12 mm", "material": PLASTIC},
                {
                    "to": "27 mm",
                    "diameter": "15 mm",
                    "bore": "12 mm",
                    "material": STEEL,
                    "core": PLASTIC,
                },
                {"to": "43 mm", "diameter": "15 mm", "material": PLASTIC},
            ],
        },
    },
    "seats": {
        "housing": {
            "material": PLASTIC,
            "width": "5 mm",
            "diameter": "26 mm",
            "outer_diameter": "50 mm",
            "fit": "pressed",
        }
    },
    "output_pins": {
        "count": 6,
        "circle_radius": "19 mm",
        "diameter": "5 mm",
        "free_length": "8 mm",
        "clearance": "0.15 mm",
        "material": STEEL,
        "held": "ring",
        "seat": SEAT,
        "sleeve": {"diameter": "8 mm", "length": "8 mm", "rollers": 10},
    },
    "disc": {"holes": {"diameter": "10.55 mm"}, "bore_fit": "snug"},
    "frame": "10 N m/arcmin",
    "input_shaft": "1 N m/arcmin",
}
TORQUE = np.array([0.4, 4.0])
Change = tuple[tuple[Any, ...], Any]
SOFT = {**PLASTIC, "young": "2.3 GPa"}
# The member of the budget that becomes softer, and the value of the drawing that does it.
SOFTENED: list[tuple[str, Change]] = [
    ("eccentric shaft", (("eccentric", "shaft", "sections", 0, "material"), SOFT)),
    ("eccentric shaft", (("eccentric", "shaft", "sections", 1, "core"), SOFT)),
    ("eccentric shaft", (("eccentric", "shaft", "sections", 2, "diameter"), "14 mm")),
    (
        "bearings of the eccentric shaft",
        (("eccentric", "shaft", "supports", 1, "bearing"), "50 N/µm"),
    ),
    ("seats of the eccentric shaft", (("seats", "housing", "fit"), "snug")),
    ("seats of the eccentric shaft", (("seats", "housing", "material"), SOFT)),
    ("seats of the eccentric shaft", (("seats", "housing", "outer_diameter"), "60 mm")),
    ("output pins", (("output_pins", "material"), {**STEEL, "young": "200 GPa"})),
    ("output pins", (("output_pins", "diameter"), "4.8 mm")),
    ("output pins", (("output_pins", "span"), "17 mm")),
    ("seats of the output pins", (("output_pins", "seat", "fit"), "snug")),
    ("seats of the output pins", (("output_pins", "seat", "material"), SOFT)),
    ("seats of the output pins", (("output_pins", "seat", "depth"), "5 mm")),
    ("seats of the output pins", (("output_pins", "far_seat"), {**SEAT, "material": SOFT})),
    ("needles of the output pins", (("output_pins", "sleeve", "rollers"), 8)),
    ("holes of the output pins", (("disc_material",), SOFT)),
    ("disc body", (("disc_material",), SOFT)),
    ("seat of the eccentric bearing", (("disc_material",), SOFT)),
    ("input shaft", (("input_shaft",), "0.5 N m/arcmin")),
    ("frame", (("frame",), "9 N m/arcmin")),
    ("eccentric bearing", (("eccentric", "bearing"), "35 N/µm")),
    ("ring body", (("ring_material",), SOFT)),
    ("lobe contacts", (("ring_material",), SOFT)),
]


def changed(*changes: Change) -> dict[str, Any]:
    """Return the drawing with other values at these places; None removes a key."""
    out = deepcopy(DRAWING)
    for path, value in changes:
        holder = out
        for step in path[:-1]:
            holder = holder[step]
        if value is None:
            del holder[path[-1]]
        else:
            holder[path[-1]] = deepcopy(value)
    return out


def gearbox(*changes: Change) -> CycloidalGearbox:
    """Return the gearbox of the changed drawing."""
    return CycloidalGearbox.model_validate(changed(*changes), context={"text": True})


@pytest.mark.parametrize(("member", "change"), SOFTENED)
def test_softening_a_member_softens_the_gearbox(member, change):
    """That member winds up more, and so does the whole."""
    before, after = wind_up(gearbox(), TORQUE), wind_up(gearbox(change), TORQUE)
    assert (after[member] > before[member]).all()
    assert (sum(after.values()) > sum(before.values())).all()


def test_a_drawing_with_all_members_bounds_nothing():
    """Every member has its own line; one that the drawing does not describe is bounded, or follows
    from other dimensions.
    """
    whole = gearbox()
    assert whole.bounded == ()
    assert {state.kind for state in whole.states.values()} == {"computed", "stated"}
    found = wind_up(whole, TORQUE)
    named = {
        "eccentric shaft",
        "bearings of the eccentric shaft",
        "seats of the eccentric shaft",
        "output pins",
        "seats of the output pins",
    }
    named.add("seat of the eccentric bearing")
    assert named | {"needles of the output pins", "holes of the output pins"} <= {
        name for name, angle in found.items() if (angle > 0).all()
    }
    silent = gearbox(
        (("eccentric", "shaft", "supports", 0), {"at": "0 mm"}),
        (("output_pins", "seat"), None),
        (("disc",), None),
    )
    bounded = {"bearings of the eccentric shaft", "seats of the eccentric shaft"}
    assert set(silent.bounded) == bounded
    lines = wind_up(silent, TORQUE)
    assert all((lines[f"{name}{BOUNDED}"] > 0).all() for name in bounded)
    # holes follow from the pins, the eccentricity and the clearance, seats from the pins and the
    # ring
    assert (
        silent.states["holes of the output pins"].kind
        == silent.states["seats of the output pins"].kind
        == "assumed"
    )
    assert silent.drive.disc_body == whole.drive.disc_body


def test_every_member_is_an_error_source():
    """With the scatter of its own material: the seats of the pins scatter as their plastic does,
    less what the elastic pin evens out.
    """
    scatters = gearbox((("output_pins", "seat", "material"), {**PLASTIC, "scatter": "12 %"}))
    members = scatters.members
    assert {
        "seats of the output pins",
        "bearings of the eccentric shaft",
        "seats of the eccentric shaft",
        "holes of the output pins",
    } <= set(members)
    terms = {
        term.name: term
        for term in terms_at(members["seats of the output pins"], condition((0, 0, 4.0, 0, 0, 0)))
    }
    scatter = terms["material scatter"]
    share = scatter.screw[0, 2] * scatter.bound / (0.12 * terms["wind-up"].screw[0, 2])
    assert 0.85 < share < 1
    softer = wind_up(
        gearbox((("output_pins", "seat", "material"), {**PLASTIC, "young": "2.376 GPa"})), TORQUE
    )["seats of the output pins"]
    assert softer[-1] / wind_up(gearbox(), TORQUE)["seats of the output pins"][
        -1
    ] - 1 == pytest.approx(share * (1 / 0.99 - 1), rel=1e-3)
    assert sum(angle[-1] for angle in scatters.behaviour.wind_up.values()) == pytest.approx(
        scatters.behaviour.total[-1]
    )


@pytest.mark.parametrize("radius", [3.0, 2.0])
def test_a_lobe_is_a_cantilever_loaded_at_half_its_height(radius):
    """In a rigid ring a lobe alone bends: a disc that travels twice the eccentricity touches it
    from root to crest, so the force acts one eccentricity above the root, on average; the
    deflection there by the energy of the moment and of Cowper's shear.
    """
    young, nu, width, arm = 2.4e9, 0.36, 8e-3, 1.2e-3
    crest = min(math.acos(1 - min(2e3 * arm / radius, 1.0)), math.pi / 2)
    root = 2e-3 * radius * math.sin(crest)  # chord of the lobe's circle that the tips reach
    along = np.linspace(0.0, arm, 10_001)
    bent = np.trapezoid((arm - along) ** 2, along) / (young * width * root**3 / 12)
    sheared = arm * (12 + 11 * nu) / (10 * (1 + nu)) / (young / (2 + 2 * nu) * width * root)
    drawn = gearbox((("rigid",), ["ring body"]), (("pin_radius",), f"{radius} mm"))
    assert drawn.drive.flanks.bending == pytest.approx(bent + sheared, rel=1e-6)
    stiff = gearbox((("rigid",), ["ring body", "ring lobes"]))
    assert stiff.drive.flanks.bending == 0


def test_the_members_of_the_shaft_add_up_to_its_stiffness_at_the_disc():
    """A stated stiffness of the same size winds up as much."""
    drawn = gearbox()
    springs = drawn.shaft_springs
    assert springs is not None
    assert drawn.shaft_compliance == springs.total
    stated = gearbox((("eccentric", "shaft"), f"{1e-6 / springs.total} N/µm"))
    names = ("eccentric shaft", "bearings of the eccentric shaft", "seats of the eccentric shaft")
    found = wind_up(drawn, TORQUE)
    np.testing.assert_allclose(
        sum(found[name] for name in names), wind_up(stated, TORQUE)["eccentric shaft"], rtol=1e-9
    )


def test_the_bearing_in_the_bore_of_the_disc_by_its_fit():
    """0.36/(E b (e z)^2) from pressed to snug with holes, 0.1 from bonded to pressed without; none
    where the disc's own model has that fit.
    """
    unit = 2.4e9 * 8e-3 * (1.2e-3 * 15) ** 2
    name, fit = "seat of the eccentric bearing", ("disc", "bore_fit")
    # at the rated torque lobes push along the line of centres as well, so the eccentric's members
    # wind up a little more or less
    snug = wind_up(gearbox(), TORQUE)[name][-1] / TORQUE[-1] * unit
    assert snug == pytest.approx(0.357, rel=0.1)
    # pins of unknown diameter: the disc counts as solid and bonded
    bare = [
        (("disc",), {"bore_fit": "pressed"}),
        (("output_pins",), {"count": 6, "circle_radius": "19 mm", "stiffness": "5 N/µm"}),
    ]
    assert wind_up(gearbox(*bare), TORQUE)[name][-1] / TORQUE[-1] * unit == pytest.approx(
        0.098, rel=0.1
    )
    assert name not in wind_up(gearbox((fit, "pressed")), TORQUE)
    unstated = gearbox((fit, None))
    assert wind_up(unstated, TORQUE)[name][-1] / TORQUE[-1] * unit == pytest.approx(
        math.sqrt(0.05) * 0.357, rel=0.1
    )
    assert unstated.states[name].kind == "assumed"
    assert wind_up(gearbox((("eccentric",), {"bearing": "40 N/µm"})), TORQUE)[name][-1] > 0


def test_clearance_of_a_bearing_of_the_shaft_is_play():
    """By the share of the force that it carries: G (L - x)/L/(e z) for a disc at x on a span L."""
    free = gearbox((("eccentric", "shaft", "supports", 0, "clearance"), "10 µm"))
    more = free.behaviour.play.mean() - gearbox().behaviour.play.mean()
    assert more == pytest.approx(10e-6 * 27 / 43 / (1.2e-3 * 15), rel=1e-9)


def test_two_discs_load_the_shaft_by_a_couple():
    """Opposite discs shift a shaft between its bearings much less than one does; in which order
    they are listed changes nothing.
    """
    one = gearbox().shaft_springs
    place = ("eccentric", "shaft", "disc_at")
    two, other = (
        gearbox((("discs",), 2), (place, order)).shaft_springs
        for order in (["16 mm", "26 mm"], ["26 mm", "16 mm"])
    )
    assert one is not None
    assert two is not None
    assert other is not None
    assert two.total < 0.5 * one.total
    assert other.total == pytest.approx(two.total, rel=1e-9)


def test_a_floating_cage_is_softer_than_two_flanks_that_turn_together():
    """Between a cantilever and a pin that is held at both ends."""
    found = [
        sum(wind_up(gearbox((("output_pins", "held"), held)), TORQUE).values())[-1]
        for held in ("both flanges", "ring", "one end")
    ]
    assert found == sorted(found)
    assert found[0] < found[1] < found[2]


def test_units_change_nothing():
    """Millimetres, micrometres or inches; MPa or GPa."""
    seat = {
        **SEAT,
        "depth": "6000 µm",
        "outer_diameter": f"{14 / 25.4} in",
        "material": {**PLASTIC, "young": "2400 MPa"},
    }
    before, after = (
        wind_up(gearbox(), TORQUE),
        wind_up(gearbox((("output_pins", "seat"), seat)), TORQUE),
    )
    for name, angle in before.items():
        np.testing.assert_allclose(after[name], angle, rtol=1e-9)


def test_a_pin_with_a_diameter_alone_is_a_cantilever():
    """Of steel unless stated otherwise, L^3/(3 EI) with its shear, as before seats and cages could
    be stated.
    """
    plain = {"count": 6, "circle_radius": "19 mm", "diameter": "5 mm", "free_length": "8 mm"}
    found = gearbox((("output_pins",), plain), (("disc",), None)).output_pins
    assert found is not None
    pin, seats = found.compliance(1)
    area, shear = math.pi / 4 * 0.005**2, 6 * 1.3 / (7 + 6 * 0.3)
    assert seats == 0.0
    assert pin == pytest.approx(
        0.008**3 / (3 * 210e9 * math.pi / 64 * 0.005**4) + 0.008 / (shear * 210e9 / 2.6 * area),
        rel=1e-9,
    )


def test_an_unstated_fit_lies_between_bonded_and_snug():
    """The geometric mean of both in the tables, the limits among what the drawing does not state,
    and the fit marked as a default.
    """
    path, name = ("output_pins", "seat"), "seats of the output pins"
    unstated = {key: value for key, value in SEAT.items() if key != "fit"}
    drawn = gearbox((path, unstated))
    found = [
        wind_up(gearbox((path, {**SEAT, "fit": fit})), TORQUE)[name][-1]
        for fit in ("bonded", "snug")
    ]
    assert wind_up(drawn, TORQUE)[name][-1] == pytest.approx(
        math.sqrt(found[0] * found[1]), rel=1e-9
    )
    assert drawn.output_pins is not None
    assert drawn.output_pins.seat is not None
    assert drawn.output_pins.seat.assumptions["fit"] == "default, between bonded and snug"
    (fit,) = unknowns(drawn)
    assert fit.name == "fit of the output pins in their seats"
    assert fit.factor.low < 1 < fit.factor.high
    housing = {key: value for key, value in DRAWING["seats"]["housing"].items() if key != "fit"}
    (fit,) = unknowns(gearbox((("seats", "housing"), housing)))
    assert fit.shares == {"seats of the eccentric shaft": pytest.approx(1.0)}
    assert fit.factor.high / fit.factor.low == pytest.approx(2.9, rel=0.2)


def test_unstated_seats_of_pins_lie_between_a_shallow_and_a_deep_one():
    """From 0.8 diameters deep and snug to 2 diameters and bonded, in the material of the ring out
    to the next pin; in steel they hardly give.
    """
    pins, name = DRAWING["output_pins"], "seats of the output pins"
    reach = 2 * 19 * math.sin(math.pi / 6)

    def limit(depth: float, fit: str) -> float:
        seat = {
            "depth": f"{depth} mm",
            "material": PLASTIC,
            "outer_diameter": f"{reach} mm",
            "fit": fit,
        }
        return float(wind_up(gearbox((("output_pins", "seat"), seat)), TORQUE)[name][-1])

    assert (pins["diameter"], pins["count"], pins["circle_radius"]) == ("5 mm", 6, "19 mm")
    silent = gearbox((("output_pins", "seat"), None))
    stiff, soft = limit(10, "bonded"), limit(4, "snug")
    assert wind_up(silent, TORQUE)[name][-1] == pytest.approx(math.sqrt(stiff * soft), rel=1e-9)
    (seats,) = [each for each in unknowns(silent) if each.name == name]
    assert seats.factor.low < 1 < seats.factor.high
    assert "0.8 to 2 diameters deep" in silent.states[name].reason
    in_steel = wind_up(
        gearbox((("output_pins", "seat"), None), (("ring_material",), STEEL)), TORQUE
    )[name][-1]
    assert in_steel < 0.05 * math.sqrt(stiff * soft)


def test_screws_along_the_shaft():
    """Tight ones stiffen it more than loose ones; where the drawing does not say, it lies between,
    and says so.
    """
    path = ("eccentric", "shaft", "screws")
    stated = {"count": 2, "diameter": "4 mm", "offset": "3.5 mm"}
    tight, loose, unstated = (
        gearbox((path, each))
        for each in ({**stated, "tight": True}, {**stated, "tight": False}, stated)
    )
    bare, stiff, soft, middle = (each.shaft_springs for each in (gearbox(), tight, loose, unstated))
    assert bare is not None
    assert stiff is not None
    assert soft is not None
    assert middle is not None
    assert stiff.shaft < middle.shaft < soft.shaft < bare.shaft
    assert stiff.total == pytest.approx(
        middle.spread[0] + stiff.bearings + sum(stiff.seats.values()), rel=1e-9
    )
    assert unstated.states["eccentric shaft"].kind == "assumed"
    (screws,) = unknowns(unstated)
    assert screws.shares == {"eccentric shaft": 1.0}
    assert unknowns(tight) == ()


def test_the_frame_by_its_screws_and_its_tube():
    """They add n k r^2 with 3 to 5 N/µm of an M3 in plastic, beyond the slip of preloaded ones; the
    housing is bounded unless stated as a tube.
    """
    screws = {"count": 8, "circle_radius": "48 mm", "size": "M3", "material": PLASTIC}
    found = gearbox((("frame",), {"screws": screws}))
    assert found.bounded == ("frame",)
    each = TORQUE[-1] / wind_up(found, TORQUE)["frame screws"][-1] / (8 * 0.048**2)
    assert 3e6 < each < 5e6
    held = gearbox(
        (
            ("frame",),
            {"screws": {**screws, "preload": "500 N", "friction": 0.2, "clearance": "0.2 mm"}},
        )
    )
    assert not wind_up(held, TORQUE)["frame screws"].any()
    slip = 8 * 0.2 * 500 * 0.048
    beyond = wind_up(held, np.array([slip + 4.0]))["frame screws"][0]
    assert beyond == pytest.approx(
        0.1e-3 / 0.048 + wind_up(found, TORQUE)["frame screws"][-1], rel=1e-9
    )
    free = gearbox((("frame",), {"screws": {**screws, "clearance": "0.2 mm"}}))
    assert free.behaviour.play.mean() - found.behaviour.play.mean() == pytest.approx(
        0.2e-3 / 0.048, rel=1e-9
    )
    tube = gearbox(
        (
            ("frame",),
            {"tube": {"radius": "50 mm", "wall": "4 mm", "length": "30 mm", "material": PLASTIC}},
        )
    )
    assert tube.bounded == ()
    shear = 2.4e9 / 2.72
    assert TORQUE[-1] / wind_up(tube, TORQUE)["frame"][-1] == pytest.approx(
        2 * math.pi * 0.05**3 * 0.004 * shear / 0.03, rel=2e-3
    )


def test_bearings_by_their_size():
    """A 6000 (10 x 26 mm) has 7 balls; its stiffness is known to a factor of 0.7 to 1.4, and is
    taken at the rated torque.
    """
    size = {"bore": "10 mm", "outside_diameter": "26 mm"}
    drawn = gearbox(
        (("eccentric", "bearing"), size), (("eccentric", "shaft", "supports", 1, "bearing"), size)
    )
    assert drawn.drive.eccentric.elements == 7
    names = ("eccentric bearing", "bearings of the eccentric shaft")
    assert all(drawn.states[name].kind == "assumed" for name in names)
    assert [each.factor.high / each.factor.low for each in unknowns(drawn)] == pytest.approx(
        [2.0] * 2
    )
    found = wind_up(drawn, TORQUE)
    assert all((found[name] > 0).all() for name in names)


def test_a_disc_off_the_middle_of_its_bearing_tilts():
    """F u^2/k_tilt: 12 u^2/b^2 of the bearing's own shift with rollers of a length b. A bearing
    that cannot resist the tilt is refused.
    """
    rollers = {"rollers": 16, "roller_length": "8 mm", "shaft": "10 N/µm"}
    plain, off = (
        gearbox((("eccentric",), {**rollers, **more})) for more in ({}, {"offset": "2 mm"})
    )
    before, after = wind_up(plain, TORQUE), wind_up(off, TORQUE)
    ratio = after["tilt of the discs"] / after["eccentric bearing"]
    np.testing.assert_allclose(ratio, 12 * 2**2 / 8**2, rtol=1e-9)
    # the discs' equilibrium moves a little with the stiffness of their bearing
    np.testing.assert_allclose(after["eccentric bearing"], before["eccentric bearing"], rtol=0.02)
    with pytest.raises(ValidationError, match="bearings that do not resist tilting"):
        gearbox((("eccentric",), {"bearing": "40 N/µm", "offset": "2 mm"}))


def test_one_batch_of_a_material_is_one_draw():
    """Members of equal materials scatter together, whatever table names them; a shaft follows each
    of its materials by its share.
    """
    batch = {**PLASTIC, "scatter": "12 %"}
    path = ("output_pins", "seat", "material")
    drawn = gearbox(
        (("disc_material",), batch),
        (path, batch),
        (("eccentric", "shaft", "sections", 2, "material"), batch),
    )
    (same,) = [each for each in material_shares(drawn) if each.material.scatter]
    assert {"disc body", "seats of the output pins", "eccentric shaft"} <= set(same.shares)
    together = {
        name: sum(each.shares.get(name, 0.0) for each in material_shares(drawn))
        for name in ("disc body", "eccentric shaft", "output pins")
    }
    assert together == {
        "disc body": pytest.approx(1.0),
        "eccentric shaft": pytest.approx(1.0, abs=0.03),
        "output pins": pytest.approx(1.0, abs=0.03),
    }
    streams = {
        (term.robot.shared, term.robot.stream)
        for name in ("disc body", "seats of the output pins")
        for term in drawn.members[name].terms(Motion(np.array([0, 0, 1.0, 0, 0, 0])))
        if term.cause == "material scatter" and term.robot is not None
    }
    assert len(streams) == 1


CRANKS: list[Change] = [
    (
        ("eccentric",),
        {"cranks": 3, "circle_radius": "19 mm", "bearing": "40 N/µm", "shaft": "20 N/µm"},
    ),
    (("output_pins",), None),
    (("disc",), {"holes": {"diameter": "10 mm"}}),
    (("disc_bore_radius",), "6 mm"),
]


def test_a_hole_may_differ_from_its_pin_within_their_tolerances():
    """A hole of pin, twice the eccentricity and clearance is taken up to the tolerances of
    clearance and eccentricity, and refused beyond.
    """
    pins = {"diameter": "5 mm", "free_length": "15 mm", "clearance": "0.1 mm ± 0.06 mm"}
    changes = tuple((("output_pins", key), value) for key, value in pins.items())
    fitting = 8e-3 + 2 * 1.2e-3 + 0.1e-3
    tolerance = 0.06e-3 + 2 * gearbox().eccentricity.tolerance
    for off, refused in ((0.9, False), (-0.9, False), (1.1, True), (-1.1, True)):
        holes = (
            (("disc",), {"holes": {"diameter": f"{(fitting + off * tolerance) * 1e3:.6f} mm"}}),
        )
        if refused:
            with pytest.raises(ValidationError, match="twice the eccentricity and clearance"):
                gearbox(*changes, *holes)
        else:
            assert gearbox(*changes, *holes).hole_diameter == pytest.approx(
                fitting + off * tolerance
            )


@pytest.mark.parametrize("fit", ["bonded", "snug", "pressed", None])
def test_a_cup_is_pressed_into_its_bore(fit):
    """A drawn cup is computed as pressed in: another fit stated beside it is refused, no longer
    ignored.
    """
    changes = (
        (("eccentric",), {"rollers": 18, "roller_length": "20 mm", "cup": "1.5 mm"}),
        (("disc", "bore_fit"), fit),
    )
    if fit in ("bonded", "snug"):
        with pytest.raises(ValidationError, match="beside a cup"):
            gearbox(*changes)
    else:
        assert gearbox(*changes).states["seat of the eccentric bearing"].kind == "computed"


def test_the_holes_of_several_cranks():
    """Stated or as wide as bearings by their size they are computed; else they are assumed, and the
    disc is known to a factor of 0.6 to 1.7.
    """
    stated = gearbox(*CRANKS)
    assert stated.drive.disc_body is not None
    assert stated.drive.disc_body.holes == Holes(3, 0.019, 0.005, bearings=True)
    assert stated.states["disc body"].kind == "computed"
    assert stated.states["seat of the eccentric bearing"].kind == "absent"
    assert unknowns(stated) == ()
    size = {"bore": "5 mm", "outside_diameter": "10 mm"}
    by_size = gearbox(*CRANKS, (("disc",), None), (("eccentric", "bearing"), size))
    assert by_size.drive.disc_body == stated.drive.disc_body
    assert by_size.states["disc body"].kind == "computed"
    silent = gearbox(*CRANKS, (("disc",), None))
    # 0.6 of the room to the root circle at 34 - 3 - 1.2 mm
    assert silent.drive.disc_body == replace(
        stated.drive.disc_body, holes=Holes(3, 0.019, pytest.approx(0.6 * 10.8e-3), bearings=True)
    )
    assert str(silent.states["disc body"]).startswith("assumed: crank holes of 13 mm")
    (holes,) = unknowns(silent)
    assert holes.shares == {"disc body": 1.0}
    assert (holes.factor.low, holes.factor.high) == pytest.approx((0.6, 1 / 0.6))
    # the room around a stated bore, and a bore in the room between stated holes
    assert gearbox(
        *CRANKS, (("disc",), None), (("disc_bore_radius",), "10 mm")
    ).hole_diameter == pytest.approx(2 * 0.6 * 9e-3)
    assert gearbox(*CRANKS, (("disc_bore_radius",), None)).bore_radius == pytest.approx(0.8 * 14e-3)
    # the bore is free: material that it takes away softens the disc
    wider = gearbox(*CRANKS, (("disc_bore_radius",), "10 mm"))
    assert (wind_up(wider, TORQUE)["disc body"] > wind_up(stated, TORQUE)["disc body"]).all()


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ([*CRANKS, (("disc", "holes", "diameter"), "30 mm")], "disc holes of 30 mm"),
        (
            [*CRANKS, (("disc", "holes", "count"), 4)],
            "another count or circle_radius than the cranks",
        ),
        (
            [*CRANKS, (("eccentric", "bearing"), {"bore": "5 mm", "outside_diameter": "11 mm"})],
            "outside_diameter of 11 mm",
        ),
        ([*CRANKS, (("eccentric", "circle_radius"), "31 mm")], "circle of radius 31 mm"),
        ([*CRANKS, (("disc",), None), (("disc_bore_radius",), "20 mm")], "circle of radius 19 mm"),
        (
            [(("output_pins", "held"), "one end"), (("output_pins", "span"), "20 mm")],
            'span or far_seat of pins held at "one end"',
        ),
        (
            [(("output_pins", "seat"), None), (("output_pins", "far_seat"), SEAT)],
            "far_seat without seat",
        ),
        ([(("output_pins", "seat"), {**SEAT, "outer_diameter": "5 mm"})], "around a pin of 5 mm"),
        ([(("output_pins", "span"), "1e16 mm")], r"free length of 1e\+16 mm of pins of 5 mm"),
        ([(("output_pins", "seat"), {**SEAT, "depth": "1 nm"})], "seat depth of 1e-06 mm"),
        ([(("output_pins", "far_seat"), {**SEAT, "depth": "2 m"})], "far seat of 2000 mm"),
        ([(("output_pins", "sleeve", "diameter"), "4 mm")], "sleeve of diameter 4 mm"),
        ([(("output_pins", "span"), "10 mm")], "discs that push from 4 to 12 mm"),
        (
            [(("output_pins", "diameter"), None), (("output_pins", "free_length"), None)],
            "material and held and seat and sleeve without diameter",
        ),
        ([(("disc", "holes", "diameter"), "10.6 mm")], "make 10.55 mm"),
        ([(("disc", "holes", "count"), 8)], "another count"),
        (
            [
                (("eccentric", "cranks"), 2),
                (("eccentric", "circle_radius"), "20 mm"),
                (("output_pins",), None),
                (("disc", "holes"), None),
            ],
            "bore_fit with",
        ),
        (
            [
                (
                    ("eccentric", "shaft", "screws"),
                    {"count": 2, "diameter": "4 mm", "offset": "5 mm"},
                )
            ],
            "within one layer",
        ),
        ([(("frame",), {})], "a frame without screws and tube"),
        ([(("eccentric", "cup"), "1 mm")], "cup without the rollers"),
        (
            [(("eccentric", "bearing"), {"bore": "26 mm", "outside_diameter": "10 mm"})],
            "around a bore of 26 mm",
        ),
        (
            [(("output_pins",), {"count": 6, "circle_radius": "19 mm"})],
            "holes without output pins of a stated diameter",
        ),
        ([(("disc_bore_radius",), "14 mm")], "no room between a bore"),
        (
            [(("eccentric", "shaft", "disc_at"), ["16 mm", "20 mm"])],
            "2 places in disc_at for 1 disc",
        ),
        (
            [(("eccentric", "shaft", "supports", 0, "seat"), "lid")],
            "seat 'lid', which is not described",
        ),
        ([(("seats", "housing", "outer_diameter"), "26 mm")], "around a bore of 26 mm"),
        (
            [(("eccentric", "shaft", "sections", 1, "bore"), "15 mm")],
            "bore of 15 mm in a diameter of 15 mm",
        ),
        ([(("eccentric", "shaft", "sections", 0, "core"), PLASTIC)], "core without a bore"),
        ([(("eccentric", "shaft", "sections", 1, "to"), "4 mm")], "do not follow"),
        ([(("eccentric", "shaft", "sections", 2, "to"), "40 mm")], "on a shaft of 40 mm"),
        ([(("eccentric", "shaft", "supports"), [{"at": "3 mm"}])], "single support without tilt"),
    ],
)
def test_impossible_members_are_refused_with_their_reason(changes, why):
    """One message that says why, and shows what passes."""
    with pytest.raises(ValidationError, match=why) as caught:
        gearbox(*changes)
    detail = next(each for each in caught.value.errors() if each["type"] != "quantity")
    assert detail["ctx"]["expected"]
    assert "=" in detail["ctx"]["example"]


FILE = """
[gearbox]
kind = "cycloidal"
rated_torque = "4 N m"
pins = 16
ring_radius = "34 mm"
pin_radius = "3 mm"
eccentricity = "1.2 mm"
width = "8 mm"
seats = { housing = { material = "PETG", width = "5 mm", diameter = "26 mm", outer_diameter = "50 mm" } }

[gearbox.eccentric.shaft]
disc_at = ["16 mm"]
supports = [{ at = "0 mm", seat = "housing" }, { at = "PLACE", bearing = "60 N/µm" }]
sections = [{ to = "27 mm", diameter = "15 mm", bore = "12 mm", core = "CORE" }, { to = "43 mm", diameter = "15 mm", material = "onyx" }]

[materials.onyx]
young = "1.4 GPa"
poisson = 0.36
density = "1200 kg/m^3"
"""


def test_members_name_materials_of_the_file_and_of_the_catalogue(tmp_path: Path):
    """In sections, cores and seats; an unknown name, and a shaft that breaks a rule, are reported
    with their keys, both at once.
    """
    path = tmp_path / "drive.toml"
    path.write_text(FILE.replace("CORE", "onyx").replace("PLACE", "43 mm"))
    found = lostmotion.gear(path, gearboxes=20)
    assert "seats of the eccentric shaft" in found.drawn.members
    assert "Not specified and only bounded" in found.sheet.verdict
    path.write_text(FILE.replace("CORE", "onix").replace("PLACE", "50 mm"))
    with pytest.raises(InputError) as caught:
        lostmotion.gear(path)
    where = {problem.key: problem for problem in caught.value.problems}
    assert where["gearbox.eccentric.shaft.sections[0].core"].nearest == "onyx"
    assert "on a shaft of 43 mm" in where["gearbox.eccentric.shaft"].found
