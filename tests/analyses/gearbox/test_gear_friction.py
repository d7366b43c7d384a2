"""Friction of a drawn gearbox: the elastic stiffness, what a bench test reads, backdriving and
self-locking, and hysteresis in an arm.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from lostmotion import DidNotConvergeError
from lostmotion.analyses.gearbox.gear import gear
from lostmotion.io.part_file import read_gearbox
from lostmotion.parts.error_source import Friction as LoadFriction
from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
from lostmotion.parts.gearbox.cycloidal.dimensions import StageFriction
from lostmotion.reporting.layout import row_at
from tests.parts.conditions import condition, terms_at

EXAMPLE = Path(__file__).parents[3] / "examples" / "gearbox" / "printed.toml"


def printed(friction: StageFriction | None, **stated: object) -> CycloidalGearbox:
    """Return the printed drive with other friction."""
    part = read_gearbox(EXAMPLE).part
    assert isinstance(part, CycloidalGearbox)
    return part.model_copy(update={"friction": friction, **stated})


def backdriving(found: object) -> list[str]:
    """Return the words of the table of backdriving."""
    rows = next(section for section in found.sheet.sections if section.key == "backdriving").rows
    return [row.cells[0].words for row in rows]


@pytest.mark.parametrize("flank", [0.01, 0.15, 0.25, 0.6])
def test_friction_does_not_change_the_stiffness(flank):
    """Wind-up, stiffness and lost motion are those without friction at any coefficient, and the
    loading branch is stiffer and finite.
    """
    rubs, smooth = (
        gear(printed(friction), gearboxes=8)
        for friction in (StageFriction(flank=flank, output=0.15), None)
    )
    for name in ("wind_up", "secant", "slope", "stiffness", "lost_motion"):
        np.testing.assert_array_equal(getattr(rubs.read, name), getattr(smooth.read, name))
    assert np.isfinite(rubs.read.loading).all()
    assert (rubs.read.loading > rubs.read.stiffness).all()
    np.testing.assert_allclose(smooth.read.loading, smooth.read.stiffness, rtol=1e-12)
    # between the ends of its loop a drive turns no further than it winds up
    assert (rubs.read.friction_under_load <= 2 * rubs.read.wind_up).all()
    rows = [
        row.label
        for section in rubs.sheet.sections
        if section.key == "loop"
        for row in section.rows
    ]
    assert "stiffness of the loading branch" in rows
    assert "stiffness of the loading branch" not in [
        row.label for section in smooth.sheet.sections for row in section.rows
    ]


def test_a_drive_that_friction_holds_says_so():
    """Flanks that rub at 0.6 let no input turn the output: the sheet says so, and that a load turns
    the input; its loop stays wound up.
    """
    found = gear(printed(StageFriction(flank=0.6)), gearboxes=8)
    assert any("the input cannot turn the output" in note for note in found.sheet.notes)
    assert backdriving(found) == ["not stated", "no", "no"]
    assert {"self_locking": False, "input_turns_output": False}.items() <= found.sheet.facts.items()
    assert (
        row_at(found.sheet.sections, "friction", "at_4_N_m").cells[0].words
        == "the input cannot turn it"
    )
    locked = gear(printed(StageFriction(flank=0.0, bearing=0.3, bearing_radius=9e-3)), gearboxes=8)
    assert backdriving(locked) == ["none", "yes", "yes"]


def test_friction_without_load_is_the_backdriving_torque():
    """A load that exceeds it turns the input; it is stated, and not known where it is only
    assumed.
    """
    found = gear(printed(None, friction_torque=LoadFriction.of_load(0.3)), gearboxes=8)
    assert row_at(found.sheet.sections, "backdriving", "backdriving_torque").cells[
        0
    ].value == pytest.approx(0.3)
    assert row_at(found.sheet.sections, "friction", "at_0_4_N_m").cells[2].value == pytest.approx(
        0.25
    )


@pytest.mark.parametrize("flank", [0.05, 0.25])
def test_an_arm_has_the_elastic_spring_and_friction_in_its_hysteresis_alone(flank):
    """Wind-up of every member is that without friction; half of the loop is what friction leaves
    wound up between both directions of arrival.
    """
    rubs, smooth = (printed(friction).members for friction in (StageFriction(flank=flank), None))
    assert set(rubs) - set(smooth) == {"friction"}
    at = condition((0, 0, 3.0, 0, 0, 0), approach=1.0)
    for name, source in smooth.items():
        for ours, theirs in zip(terms_at(rubs[name], at), terms_at(source, at), strict=True):
            np.testing.assert_array_equal(ours.screw, theirs.screw)
    half = next(term for term in terms_at(rubs["friction"], at) if term.level == "design").screw[
        0, 2
    ]
    found = printed(StageFriction(flank=flank)).behaviour
    levels, friction = found.friction.levels, found.friction.discs
    # the springs behind the friction carry T_e of T_e + F = 3 N m and T_e - F = 3 N m
    carried = [
        brentq(
            lambda each, way=way: each + way * np.interp(each, levels, friction) - 3.0,
            0.0,
            levels[-1],
        )
        for way in (1, -1)
    ]
    ends = np.interp(carried, found.torque, found.total - found.load_side)
    assert abs(half) == pytest.approx((ends[1] - ends[0]) / 2, rel=1e-9)


def test_an_arm_whose_input_cannot_turn_a_joint_is_refused():
    """Flanks that take all of the torque leave no hysteresis to be computed: no figure is printed
    in its place.
    """
    with pytest.raises(DidNotConvergeError, match="takes all of its torque"):
        terms_at(
            printed(StageFriction(flank=0.6)).members["friction"], condition((0, 0, 3.0, 0, 0, 0))
        )
