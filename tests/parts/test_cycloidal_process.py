"""Tolerances of a drawn cycloidal stage by the process that makes it: only where none are stated,
and listed as assumed.
"""

from __future__ import annotations

from copy import deepcopy
from typing import Any, get_args

import numpy as np
import pytest
from pydantic import ValidationError

from lostmotion.error_model.given_values import assumed_in_part
from lostmotion.laws.process_tolerance import Process, process_tolerance
from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
from lostmotion.parts.gearbox.cycloidal.model import wind_up
from tests.parts.test_cycloidal_members import DRAWING, PLASTIC


def drawing(**changes: Any) -> CycloidalGearbox:
    """Return the drawing of a printed gearbox with other values."""
    return CycloidalGearbox.model_validate({**DRAWING, **changes}, context={"text": True})


def test_every_process_can_be_stated():
    """The key takes every process that has tolerances, and no other."""
    for process in get_args(Process):
        assert (
            drawing(process=process, relief={"roller": "0.3 mm"}).process_tolerances["ring_radius"]
            > 0
        )
    with pytest.raises(ValidationError):
        drawing(process="forging")


def test_a_process_fills_only_what_is_not_stated():
    """Stated tolerances stay; others are two thirds of half a diameter's tolerance, and a third of
    it from lobe to lobe.
    """
    plain, printed = (
        drawing(),
        drawing(process="FFF", ring_radius="34 mm ± 10 µm", flank_form="0 mm"),
    )
    assert plain.scatter.pin_radius.tolerance == plain.scatter.pin_position == 0
    assert printed.scatter.ring_radius.tolerance == pytest.approx(10e-6)
    assert printed.scatter.flank_form == 0
    of_ring = process_tolerance("FFF", 68e-3) / 2
    assert printed.scatter.pin_position == pytest.approx(of_ring / 3)
    assert printed.scatter.pin_radius.tolerance == pytest.approx(process_tolerance("FFF", 6e-3) / 3)
    assert printed.scatter.output_clearance.nominal == plain.scatter.output_clearance.nominal
    assert (
        0 < printed.scatter.output_clearance.tolerance <= printed.scatter.output_clearance.nominal
    )
    assert printed.scatter.roller.tolerance <= printed.scatter.roller.nominal


def test_tolerances_of_a_process_are_listed_as_assumed():
    """Each tolerance that the process sets is an assumed value of the gearbox, with its size and
    the process; a plain drawing has none.
    """
    listed = {each.key: each.reason for each in assumed_in_part(drawing(process="IT7"), "gearbox")}
    assert listed["pin_radius"] == "default tolerance of IT7, ± 0.002 mm"
    assert set(drawing(process="IT7").process_tolerances) <= set(listed)
    assert not any("tolerance of" in each.reason for each in assumed_in_part(drawing(), "gearbox"))


def test_a_finer_process_makes_less_play_scatter():
    """Gearboxes of a finer process differ less in their play."""
    coarse, fine = (
        drawing(process=process, relief={"roller": "0.3 mm"}).behaviour.play.std()
        for process in ("FFF", "IT7")
    )
    assert 0 < fine < coarse / 5


def test_infill_softens_plates_and_layers_soften_standing_parts():
    """Infill softens disc, ring and seats in proportion, layers the shaft; contacts are of solid
    walls, and keep their stiffness.
    """
    torque = np.array([4.0])
    plain = wind_up(drawing(), torque)
    hollow, standing = ({**PLASTIC, key: "0.5"} for key in ("infill", "across_layers"))
    plates = wind_up(drawing(disc_material=hollow, ring_material=hollow), torque)
    for name in ("disc body", "ring body"):
        # softer bodies also shift the load to other lobes
        assert plates[name] == pytest.approx(2 * plain[name], rel=0.1), name
    assert plates["lobe contacts"] == pytest.approx(plain["lobe contacts"], rel=0.02)
    eccentric = deepcopy(DRAWING["eccentric"])
    for section in eccentric["shaft"]["sections"]:
        section["material"] = standing
        section.pop("core", None)
    solid = deepcopy(eccentric)
    for section in solid["shaft"]["sections"]:
        section["material"] = PLASTIC
    assert (
        wind_up(drawing(eccentric=eccentric), torque)["eccentric shaft"]
        > 1.5 * wind_up(drawing(eccentric=solid), torque)["eccentric shaft"]
    )


def test_a_process_without_tolerances_for_a_size_is_refused():
    """General tolerances of class f end at 2 m."""
    with pytest.raises(
        ValidationError, match="no general tolerance of ISO 2768 f at 2100 mm: up to 2000 mm"
    ):
        drawing(
            process="ISO 2768 f",
            ring_radius="1050 mm",
            pin_radius="90 mm",
            output_pins=None,
            disc={},
            ring_outer_radius=None,
        )
