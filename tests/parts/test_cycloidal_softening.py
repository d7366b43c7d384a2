"""Every member that the sheet of a drawn cycloidal gearbox can name: softened in some drawing, the
output winds up more; never less than nothing.
"""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import numpy as np
import pytest

from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox, names
from lostmotion.parts.gearbox.cycloidal.model import wind_up
from lostmotion.parts.gearbox.cycloidal.states import bounds, member_states
from tests.parts.test_cycloidal_members import CRANKS, DRAWING, PLASTIC, SEAT, SOFT, Change, changed

TORQUE = np.array([0.04, 0.4, 4.0])
SIZE = {"bore": "10 mm", "outside_diameter": "26 mm"}
# One drawing each in which the members below have lines of their own.
OF_STAGE = {
    key: value
    for key, value in DRAWING.items()
    if key not in ("rated_torque", "frame", "input_shaft")
}
PLANETARY = {
    "kind": "planetary",
    "sun_teeth": 16,
    "planet_teeth": 32,
    "module": "1 mm",
    "mesh_stiffness": "50 N/µm",
}
SCREWS = {"count": 8, "circle_radius": "48 mm", "size": "M3", "material": PLASTIC}
TUBE = {"radius": "50 mm", "wall": "4 mm", "length": "30 mm", "material": PLASTIC}
BARE = {
    key: DRAWING[key]
    for key in (
        "kind",
        "rated_torque",
        "pins",
        "ring_radius",
        "pin_radius",
        "eccentricity",
        "width",
    )
}
VARIANTS: dict[str, dict[str, Any]] = {
    "lobes": DRAWING,
    "pins": changed(
        (("form",), "ring pins"),
        (("pin_span",), "10 mm"),
        (("first_stage",), PLANETARY),
        (("frame",), {"screws": SCREWS, "tube": TUBE}),
    ),
    "rigid ring": changed((("rigid",), ["ring body"])),
    "off centre": changed(
        (
            ("eccentric",),
            {
                "rollers": 16,
                "roller_length": "8 mm",
                "offset": "2 mm",
                "cup": "1 mm",
                "shaft": "10 N/µm",
            },
        ),
        (("disc", "bore_fit"), "pressed"),  # the only fit of a cup
    ),
    "cranks": changed(*CRANKS),
    "envelope": changed((("form",), "lobe envelope")),
    "two stages": changed((("first_stage",), {**deepcopy(OF_STAGE), "kind": "cycloidal"})),
    "two stages, rigid ring": changed(
        (("first_stage",), {**deepcopy(OF_STAGE), "kind": "cycloidal", "rigid": ["ring body"]})
    ),
    "two stages, off centre": changed(
        (
            ("first_stage",),
            {
                **deepcopy(OF_STAGE),
                "kind": "cycloidal",
                "eccentric": {"rollers": 16, "roller_length": "8 mm", "offset": "2 mm"},
            },
        )
    ),
    "two stages, pins": changed(
        (
            ("first_stage",),
            {**deepcopy(OF_STAGE), "kind": "cycloidal", "form": "ring pins", "pin_span": "10 mm"},
        )
    ),
    "open": changed(
        (("output_pins", "seat", "fit"), None),
        (("seats", "housing", "fit"), None),
        (("disc", "bore_fit"), None),
        (("eccentric", "bearing"), SIZE),
        (("eccentric", "shaft", "supports", 1, "bearing"), SIZE),
        (("eccentric", "shaft", "screws"), {"count": 2, "diameter": "4 mm", "offset": "3.5 mm"}),
        (("frame",), None),
    ),
    "open pins": changed(
        (("output_pins",), {"count": 6, "circle_radius": "19 mm"}), (("disc",), None)
    ),
    "open cranks": changed(*CRANKS, (("disc",), None)),
    "silent": BARE,
    "silent planets": {
        **BARE,
        "form": "planet pins",
        "output_pins": {
            "count": 6,
            "circle_radius": "19 mm",
            "diameter": "5 mm",
            "free_length": "8 mm",
        },
    },
    "silent bodies": {**BARE, "contact_law": "palmgren"},
    "silent shaft": changed(
        (("eccentric", "shaft", "supports"), [{"at": "0 mm"}, {"at": "43 mm"}])
    ),
    "silent first stages": {
        **BARE,
        "first_stage": {key: value for key, value in PLANETARY.items() if key != "mesh_stiffness"},
    },
    "silent two stages": {
        **BARE,
        "first_stage": {
            **{key: value for key, value in BARE.items() if key != "rated_torque"},
            "kind": "cycloidal",
            "form": "planet pins",
        },
    },
    "silent two stages, bodies": {
        **BARE,
        "first_stage": {
            **{key: value for key, value in BARE.items() if key != "rated_torque"},
            "kind": "cycloidal",
            "contact_law": "palmgren",
        },
    },
    "silent two stages, shaft": {
        **BARE,
        "first_stage": {
            **changed(
                (("eccentric", "shaft", "supports"), [{"at": "0 mm"}, {"at": "43 mm"}]),
                (("output_pins", "seat"), None),
            ),
            "kind": "cycloidal",
        },
    },
}
for _key in ("rated_torque", "frame", "input_shaft"):
    del VARIANTS["silent two stages, shaft"]["first_stage"][_key]

# The drawing, its member that becomes softer, and the value that does it; members of a stage in the
# last stage and in the first one.
OF_STAGES: list[tuple[str, str, Change]] = [
    ("lobes", names.CONTACTS, (("ring_material",), SOFT)),
    ("pins", names.RING_PINS, (("pin_span",), "10.5 mm")),
    ("rigid ring", names.RING_LOBES, (("ring_material",), SOFT)),
    ("lobes", names.DISC_BODY, (("disc_bore_radius",), "9.9 mm")),
    ("lobes", names.RING_BODY, (("ring_outer_radius",), "43 mm")),
    ("lobes", names.BEARING, (("eccentric", "bearing"), "35 N/µm")),
    ("off centre", names.TILT, (("eccentric", "offset"), "2.1 mm")),
    ("lobes", names.BORE, (("disc_material",), SOFT)),
    ("lobes", names.SHAFT, (("eccentric", "shaft", "sections", 0, "material"), SOFT)),
    ("lobes", names.SHAFT_BEARINGS, (("eccentric", "shaft", "supports", 1, "bearing"), "50 N/µm")),
    ("lobes", names.SHAFT_SEATS, (("seats", "housing", "outer_diameter"), "60 mm")),
    ("lobes", names.PINS, (("output_pins", "diameter"), "4.8 mm")),
    ("lobes", names.SEATS, (("output_pins", "seat", "depth"), "5 mm")),
    ("lobes", names.NEEDLES, (("output_pins", "sleeve", "rollers"), 8)),
    ("lobes", names.HOLES, (("disc_material",), SOFT)),
]
MORE: list[tuple[str, str, Change]] = [
    ("cranks", names.DISC_BODY, (("disc_bore_radius",), "7 mm")),
    ("cranks", names.DISC_BODY, (("disc_material",), SOFT)),
    ("cranks", names.BEARING, (("eccentric", "bearing"), "35 N/µm")),
    ("cranks", names.SHAFT, (("eccentric", "shaft"), "19 N/µm")),
    ("envelope", names.CONTACTS, (("disc_material",), SOFT)),
    ("envelope", names.RING_BODY, (("ring_material",), SOFT)),
    ("off centre", names.BEARING, (("eccentric", "rollers"), 14)),
    ("off centre", names.BORE, (("eccentric", "cup"), "0.8 mm")),
    ("pins", names.FIRST, (("first_stage", "mesh_stiffness"), "45 N/µm")),
    ("pins", names.FRAME, (("frame", "tube", "wall"), "3.8 mm")),
    ("pins", names.FRAME_SCREWS, (("frame", "screws", "count"), 7)),
    ("lobes", names.FRAME, (("frame",), "9 N m/arcmin")),
    ("lobes", names.INPUT, (("input_shaft",), "0.9 N m/arcmin")),
    ("lobes", names.SEATS, (("output_pins", "far_seat"), {**SEAT, "material": SOFT})),
]
BY_STAGE = {
    "lobes": "two stages",
    "rigid ring": "two stages, rigid ring",
    "off centre": "two stages, off centre",
    "pins": "two stages, pins",
}
SOFTENED = [
    *OF_STAGES,
    *MORE,
    *(
        (BY_STAGE[drawing], f"{names.FIRST_STAGE}{member}", (("first_stage", *place), value))
        for drawing, member, (place, value) in OF_STAGES
    ),
]


# What turns the units of a drawing into others: the same length, stiffness, modulus, torque, angle.
OTHER_UNITS = {
    "mm": ("in", 1 / 25.4),
    "N/µm": ("N/mm", 1e3),
    "GPa": ("MPa", 1e3),
    "N m": ("N mm", 1e3),
    "N m/arcmin": ("N m/deg", 60.0),
}


def in_other_units(stated: Any) -> Any:
    """Return a drawing with every quantity in another unit."""
    if isinstance(stated, dict):
        return {key: in_other_units(value) for key, value in stated.items()}
    if isinstance(stated, (list, tuple)):
        return [in_other_units(value) for value in stated]
    number, _, unit = stated.partition(" ") if isinstance(stated, str) else ("", "", "")
    if unit not in OTHER_UNITS:
        return stated
    other, factor = OTHER_UNITS[unit]
    return f"{float(number) * factor!r} {other}"


def built(stated: dict[str, Any]) -> CycloidalGearbox:
    """Return the gearbox of a drawing."""
    return CycloidalGearbox.model_validate(deepcopy(stated), context={"text": True})


def with_change(stated: dict[str, Any], change: Change) -> dict[str, Any]:
    """Return a drawing with another value at one place."""
    out = deepcopy(stated)
    holder, (path, value) = out, change
    for step in path[:-1]:
        holder = holder[step]
    holder[path[-1]] = deepcopy(value)
    return out


@pytest.mark.parametrize(
    ("drawing", "member", "change"),
    SOFTENED,
    ids=[f"{drawing}: {member}" for drawing, member, _ in SOFTENED],
)
def test_softening_any_member_increases_its_wind_up_and_the_whole(drawing, member, change):
    """At every torque, strictly; and no member winds up backwards."""
    before, after = (
        wind_up(built(each), TORQUE)
        for each in (VARIANTS[drawing], with_change(VARIANTS[drawing], change))
    )
    assert (after[member] > before[member]).all()
    assert (sum(after.values()) > sum(before.values())).all()
    assert all((angle >= 0).all() for angle in (*before.values(), *after.values()))


@pytest.mark.parametrize("drawing", VARIANTS)
def test_softening_what_a_drawing_leaves_open_increases_the_whole(drawing):
    """Each quantity that the drawing does not state, bounded members among them: the softer, the
    more the output winds up.
    """
    plain = built(VARIANTS[drawing])
    for each in plain.unknowns:
        found = [
            wind_up(
                plain.model_copy(update={"unstated": {**plain.left_open, each.name: factor}}),
                TORQUE,
            )
            for factor in (each.factor.low, 1.0, each.factor.high)
        ]
        whole = [sum(angle for angle in one.values()) for one in found]
        assert (np.diff(whole, axis=0) > 0).all(), each.name
        for member, share in each.shares.items():
            assert share > 0
            if member in found[0]:
                assert (np.diff([one[member] for one in found], axis=0) > 0).all(), (
                    each.name,
                    member,
                )
        assert all((angle >= 0).all() for one in found for angle in one.values())


def test_every_member_that_the_sheet_can_name_is_softened_above():
    """All members of the last and of the first stage, and those outside of them: computed or stated
    ones by a value, bounded ones by their factor.
    """
    by_value = {member for _, member, _ in SOFTENED}
    bounded = {name for each in VARIANTS.values() for name in bounds(built(each))}
    of_stage = {names.CONTACTS, *names.STAGE_MEMBERS}
    every = of_stage | {f"{names.FIRST_STAGE}{name}" for name in of_stage} | set(names.OUTSIDE)
    assert every - by_value - bounded == set()
    # pins of a planet are only ever bounded
    assert every - by_value == {names.PLANET_PINS, f"{names.FIRST_STAGE}{names.PLANET_PINS}"}
    opened = {
        each.name.removeprefix(names.FIRST_STAGE)
        for drawing in VARIANTS.values()
        for each in built(drawing).unknowns
    } - bounded
    assert opened == {
        names.SEATS,
        "fit of the eccentric bearing in its bore",
        "fit of the output pins in their seats",
        "fit of the seat housing",
        "eccentric bearing by its size",
        "bearings of the eccentric shaft by their size",
        "screws of the eccentric shaft, loose or tight",
        "holes of the discs",
    }
    listed = {name for each in VARIANTS.values() for name in member_states(built(each))}
    assert listed == every
    # what can be bounded is in some drawing
    of_shaft = {names.BEARING, names.SHAFT, names.SHAFT_BEARINGS, names.SHAFT_SEATS}
    may_be_bounded = {names.PLANET_PINS, names.DISC_BODY, names.RING_BODY, names.PINS, *of_shaft}
    assert bounded == may_be_bounded | {f"{names.FIRST_STAGE}{name}" for name in may_be_bounded} | {
        names.FIRST,
        names.FRAME,
        names.INPUT,
    }


@pytest.mark.parametrize("drawing", VARIANTS)
def test_units_change_nothing(drawing):
    """Inches, newtons per millimetre, megapascals and degrees: every member winds up as before, to
    1e-7.
    """
    other = in_other_units(VARIANTS[drawing])
    assert other["ring_radius"] == f"{34 / 25.4!r} in"
    plain = built(VARIANTS[drawing])
    before, after = wind_up(plain, TORQUE), wind_up(built(other), TORQUE)
    assert before.keys() == after.keys()
    for name, angle in before.items():
        np.testing.assert_allclose(after[name], angle, rtol=1e-7, atol=1e-15)
