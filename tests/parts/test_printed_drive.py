"""A printed drive by the dimensions of all its members: which of them its wind-up comes from."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.io.part_file import read_gearbox
from lostmotion.parts.bands import unknown_values
from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
from lostmotion.parts.gearbox.cycloidal.model import wind_up

if TYPE_CHECKING:
    from pathlib import Path

DRAWING: Final = """[gearbox]
kind = "cycloidal"
form = "lobe arcs"
rated_torque = "24 N m"
pins = 14
ring_radius = "34 mm"
pin_radius = "3.5 mm"
eccentricity = "1.5 mm"
width = "27 mm"
disc_material = "onyx"
ring_material = "onyx"
disc_bore_radius = "10.5 mm"
ring_outer_radius = "43 mm"
[gearbox.eccentric]
rollers = 18
roller_length = "20 mm"
cup = "1.5 mm"
[gearbox.eccentric.shaft]
supports = [ { at = "0 mm", bearing = "30 N/µm", seat = "housing", clearance = "10 µm" }, { at = "43 mm", bearing = "60 N/µm", seat = "housing" } ]
disc_at = ["16 mm"]
sections = [
    { to = "4 mm", diameter = "12 mm", material = "onyx" },
    { to = "27 mm", diameter = "15 mm", bore = "12 mm", material = "steel", core = "onyx" },
    { to = "43 mm", diameter = "15 mm", material = "onyx" } ]
screws = { count = 2, diameter = "4 mm", offset = "3.5 mm", tight = true }
[gearbox.seats.housing]
material = "onyx"
width = "5 mm"
diameter = "26 mm"
outer_diameter = "50 mm"
fit = "snug"
[gearbox.output_pins]
diameter = "5 mm"
free_length = "15 mm"
held = "ring"
seat = { depth = "10 mm", material = "onyx", outer_diameter = "16 mm", fit = "pressed" }
sleeve = { diameter = "9 mm", rollers = 8, length = "27 mm" }
[gearbox.disc]
holes = { count = 8, circle_radius = "20 mm", diameter = "12.1 mm" }
[gearbox.frame]
screws = { count = 8, circle_radius = "48 mm", size = "M3", material = "onyx" }
[materials.onyx]
young = "1.3 .. 3.0 GPa"
poisson = 0.36
density = "1200 kg/m^3"
scatter = "10 %"
"""


def test_a_printed_drive_winds_up_where_such_drives_do(tmp_path: Path):
    """Output pins in a floating cage about 40 %, eccentric with seats 20 %, frame 20 %, disc with
    holes 18 %, and contacts and ring little.
    """
    path = tmp_path / "printed.toml"
    path.write_text(DRAWING, encoding="utf-8")
    gearbox = read_gearbox(path).part
    assert isinstance(gearbox, CycloidalGearbox)
    assert gearbox.bounded == ("frame",)
    assert [each.key for each in unknown_values(gearbox)] == [
        "materials.onyx.young",
        "unstated.frame",
    ]
    found = {name: float(angle[0]) for name, angle in wind_up(gearbox, np.array([24.0])).items()}
    whole = sum(found.values())

    def share(*words: str) -> float:
        return (
            sum(angle for name, angle in found.items() if any(word in name for word in words))
            / whole
        )

    assert 0.33 < share("output pins") - share("holes of") < 0.47
    assert 0.12 < share("eccentric") < 0.25
    assert 0.15 < share("frame") < 0.25
    assert 0.10 < share("disc body", "holes of") < 0.25
    assert share("lobe contacts", "ring body") < 0.12
    assert all(angle >= 0 for angle in found.values())
