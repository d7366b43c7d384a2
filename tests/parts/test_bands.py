"""Values that are only known to lie in a range: found in drawings and arms, drawn, and replaced."""

from __future__ import annotations

import math
from copy import deepcopy
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from lostmotion.error_model.provenance import states
from lostmotion.errors import InputError
from lostmotion.io import read
from lostmotion.parts.bands import DRAWS, UnknownValue, latin_hypercube, unknown_values, with_values
from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
from tests.parts.test_cycloidal_members import DRAWING, PLASTIC

if TYPE_CHECKING:
    from pathlib import Path

PRINTED = {**PLASTIC, "young": "1.3 .. 3.0 GPa", "name": "onyx"}
ARM = """
name = "two drives"
[materials.onyx]
young = "1.3 .. 3.0 GPa"
poisson = 0.36
density = "1200 kg/m^3"
[materials.other]
young = "1.3 .. 3.0 GPa"
poisson = 0.36
density = "1200 kg/m^3"
[gearboxes.drive]
kind = "cycloidal"
rated_torque = "4 N m"
pins = 16
ring_radius = "34 .. 34.2 mm ± 0.05 mm"
pin_radius = "3 mm"
eccentricity = "1.2 mm"
width = "8 mm"
disc_material = "onyx"
ring_material = "other"
frame = "5 .. 20 N m/arcmin"
rigid = ["output pins", "eccentric bearing", "seat of the eccentric bearing"]
[[joints]]
name = "A"
type = "revolute"
limits = ["-90 deg", "90 deg"]
gearbox = "drive"
link = { length = "200 mm", section = { kind = "rod", diameter = "20 .. 25 mm" }, material = "onyx" }
[[joints]]
name = "B"
type = "revolute"
limits = ["-90 deg", "90 deg"]
gearbox = "drive"
"""


def drawing(**changes: Any) -> CycloidalGearbox:
    """Return the drawing of a printed gearbox with other values."""
    return CycloidalGearbox.model_validate({**deepcopy(DRAWING), **changes}, context={"text": True})


def test_a_batch_of_material_has_one_modulus():
    """Disc and ring of one material in a range are of one batch: one unknown value, drawn once,
    replaces both.
    """
    gearbox = drawing(disc_material=PRINTED, ring_material=PRINTED)
    (unknown,) = unknown_values(gearbox)
    assert unknown.key == "materials.onyx.young"
    found = with_values(gearbox, {unknown.key: 1.5e9})
    assert found.disc_material.young == found.ring_material.young == 1.5e9
    assert unknown_values(found) == ()


def test_materials_of_two_names_are_two_batches():
    """Materials of the same range under two names have a value each; so have two dimensions of one
    range.
    """
    seat = {
        "material": PLASTIC,
        "width": "5 mm",
        "diameter": "26 mm",
        "outer_diameter": "40 .. 60 mm",
        "fit": "pressed",
    }
    shaft = deepcopy(DRAWING["eccentric"])
    shaft["shaft"]["supports"][1]["seat"] = "cover"
    gearbox = drawing(
        disc_material=PRINTED,
        ring_material={**PRINTED, "name": "PLA"},
        seats={"housing": seat, "cover": seat},
        eccentric=shaft,
    )
    keys = [each.key for each in unknown_values(gearbox)]
    assert keys == [
        "materials.PLA.young",
        "materials.onyx.young",
        "seats.cover.outer_diameter",
        "seats.housing.outer_diameter",
    ]


def test_results_for_other_values_do_not_remain():
    """A drawing with known values has their shaft compliance, even if that of the middle was
    computed before; what did not change is shared.
    """
    eccentric = deepcopy(DRAWING["eccentric"])
    eccentric["shaft"]["sections"][0]["material"] = PRINTED
    gearbox = drawing(eccentric=eccentric)
    middle = gearbox.shaft_compliance
    stiff, soft = (with_values(gearbox, {"materials.onyx.young": young}) for young in (3e9, 1.3e9))
    assert stiff.shaft_compliance < middle < soft.shaft_compliance
    assert soft.output_pins is gearbox.output_pins
    assert soft.model_fields_set == gearbox.model_fields_set


def test_the_middle_of_a_range_is_its_value():
    """A drawing with a range computes as one with the middle of the range: geometric for moduli,
    arithmetic for dimensions.
    """
    ranged = drawing(
        disc_material=PRINTED, frame="5 .. 20 N m/arcmin", ring_outer_radius="40 .. 44 mm"
    )
    plain = drawing(
        disc_material={**PRINTED, "young": f"{math.sqrt(3.9)!r} GPa"},
        frame="10 N m/arcmin",
        ring_outer_radius="42 mm",
    )
    assert (disc := ranged.drive.disc_body) is not None
    assert (ring := ranged.drive.ring_body) is not None
    assert (plain_disc := plain.drive.disc_body) is not None
    assert disc.young == pytest.approx(plain_disc.young, rel=1e-12)
    assert ranged.frame == pytest.approx(plain.frame, rel=1e-12)
    assert ring.edge == pytest.approx(42e-3, rel=1e-12)


def test_an_impossible_drawing_within_a_range_is_named():
    """A bore that within its range reaches the teeth is refused, with the values that do it."""
    gearbox = drawing(
        disc={"bore_fit": "pressed"},
        output_pins=None,
        disc_bore_radius="20 .. 32 mm",
        rigid=["output pins"],
    )
    with pytest.raises(
        InputError,
        match=r"ranges that allow a bore of radius 31 mm.* \(with disc_bore_radius = 0.031, in SI\)",
    ):
        with_values(gearbox, {"disc_bore_radius": 31e-3})


def test_a_latin_hypercube_has_one_draw_in_each_interval():
    """Each value has one draw in every interval; a further range leaves the draws of the others as
    they are, another seed does not.
    """
    one, two = (
        UnknownValue(key, drawing(frame="5 .. 20 N m/arcmin").frame) for key in ("frame", "width")
    )  # type: ignore[arg-type]
    both = latin_hypercube((one, two))
    assert both.shape == (DRAWS, 2)
    np.testing.assert_allclose(
        np.sort(both, axis=0), np.repeat((np.arange(DRAWS)[:, None] + 0.5) / DRAWS, 2, axis=1)
    )
    np.testing.assert_array_equal(latin_hypercube((one,))[:, 0], both[:, 0])
    assert not np.array_equal(latin_hypercube((one,), seed=2)[:, 0], both[:, 0])
    assert latin_hypercube(()).shape == (DRAWS, 0)


def test_what_a_drawing_leaves_open_is_named_by_the_joint_that_has_the_drawing(tmp_path: Path):
    """A drawing of a joint's own is 'the gearbox of A', one shared under a name is read by that
    name, also where values are listed.
    """
    shared = ARM.replace("[gearboxes.drive]", "[gearboxes.'my drive']").replace(
        '"drive"', '"my drive"'
    )
    file = tmp_path / "arm.toml"
    file.write_text(shared, encoding="utf-8")
    arm = read(file)
    assert [each.name for each in unknown_values(arm)][:3] == [
        'gearboxes."my drive".frame',
        'gearboxes."my drive".ring_radius',
        'eccentric shaft of gearboxes."my drive" (not stated)',
    ]
    owners = [each.owner for each in states(arm).given]
    assert 'gearboxes."my drive"' in owners
    assert not any(owner.startswith("joints.A.gearbox") for owner in owners)
    own = arm.model_copy(
        update={
            "joints": (
                arm.joints[0].model_copy(update={"gearbox": arm.joints[0].gearbox.model_copy()}),
                *arm.joints[1:],
            )
        }
    )
    assert unknown_values(own)[2].name == "eccentric shaft of the gearbox of A (not stated)"


def test_an_arm_shares_the_ranges_of_shared_parts(tmp_path: Path):
    """A drawing on two joints, and a material of drawing and link, have one value each in the whole
    arm.
    """
    file = tmp_path / "arm.toml"
    file.write_text(ARM, encoding="utf-8")
    arm = read(file)
    found = unknown_values(arm)
    assert [each.key for each in found] == [
        "joints.A.gearbox.frame",
        "joints.A.gearbox.ring_radius",
        "joints.A.gearbox.unstated.eccentric shaft",
        "joints.A.link.section.diameter",
        "materials.onyx.young",
        "materials.other.young",
    ]
    assert [each.name for each in found] == [
        "gearboxes.drive.frame",
        "gearboxes.drive.ring_radius",
        "eccentric shaft of gearboxes.drive (not stated)",
        "diameter of the section of the link of A",
        "materials.onyx.young",
        "materials.other.young",
    ]
    assert any("stated as a range a .. b: gearboxes.drive.frame, " in each for each in arm.remarks)
    known = with_values(arm, {each.key: each.band.at(0.1) for each in found})
    first, second = known.joints
    assert first.gearbox == second.gearbox
    assert first.link.material.young == pytest.approx(1.3e9 * (3 / 1.3) ** 0.1)
    assert first.gearbox.ring_radius.tolerance == pytest.approx(5e-5)
    assert not any("range" in each for each in known.remarks)
