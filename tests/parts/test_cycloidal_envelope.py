"""Second branch of envelope lobes in a drawing: the method used, its effect on the wind-up, and
what is refused.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from lostmotion.analyses.gearbox.gear import gear
from lostmotion.laws.cycloid.envelope import stiffening_by_rule
from lostmotion.parts.gearbox.cycloidal import CycloidalGearbox
from lostmotion.parts.gearbox.cycloidal.model import wind_up

DRAWING: dict[str, Any] = {
    "kind": "cycloidal",
    "form": "lobe envelope",
    "rated_torque": "60 N m",
    "pins": 14,
    "ring_radius": "34 mm",
    "pin_radius": "3.5 mm",
    "eccentricity": "1.5 mm",
    "width": "12 mm",
}
RIGID = {"rigid": ["disc body", "ring body"]}


def drawing(**more: Any) -> CycloidalGearbox:
    """Return a steel gearbox with envelope lobes and these fields besides."""
    return CycloidalGearbox.model_validate({**DRAWING, **more}, context={"text": True})


def test_the_second_branch_stiffens_the_contacts_and_nothing_else():
    """Without gaps the contacts wind up by the stiffening less than lobes of plain arcs, which have
    one branch; the bending of the lobes remains.
    """
    torque = np.array([6.0, 60.0])
    both, alone = (wind_up(drawing(form=form), torque) for form in ("lobe envelope", "lobe arcs"))
    np.testing.assert_allclose(
        both["lobe contacts"],
        alone["lobe contacts"] / stiffening_by_rule(drawing().stage),
        rtol=1e-9,
    )
    np.testing.assert_allclose(both["ring lobes"], alone["ring lobes"], rtol=0.02)


@pytest.mark.parametrize(
    ("asked", "more", "method"),
    [
        (None, RIGID, "rule"),
        (None, {}, "rule"),
        ("exact", {}, "exact"),
        (None, {"pins": 12}, "exact"),
    ],
    ids=["rigid", "rule", "exact", "12 lobes"],
)
def test_the_sheet_names_the_method(asked, more, method):
    """The rule in its range, the contact along the whole flank where asked for or outside of that
    range, each with what it is.

    On elastic disc and ring the contacts of both branches are solved together, and the peak
    pressure is no upper limit.
    """
    study = gear(drawing(**more, **({} if asked is None else {"envelope": asked})), gearboxes=2)
    assert study.drawn is not None
    assert study.drawn.branches is not None
    assert study.drawn.branches.effect.method == method
    sheet = study.sheet
    section = next(each for each in sheet.sections if each.key == "branches")
    assert ("rule" in section.note) == (method == "rule")
    assert ("whole flank, to a depth of 2." in section.note) == (method == "exact")
    peak = next(each for each in sheet.cards if each.title == "peak contact pressure")
    assert peak.number.startswith("≤") == (more is RIGID)
    assert ("solved together on the elastic disc and ring" in section.note) == (more is not RIGID)


def test_the_peak_pressure_along_the_flank_is_below_that_of_the_first_branch():
    """By the 12 to 28 % that the sheet states where it has the first branch alone."""
    study = gear(drawing(envelope="exact", **RIGID), gearboxes=2).drawn
    assert study is not None
    assert study.branches is not None
    assert study.branches.solved is not None
    assert 1.12 < study.lobes[0].largest_peak / study.branches.solved.peak.max() < 1.28


def test_contacts_of_the_second_branch_are_listed_with_arm_and_gap():
    """At crank zero, with arms above zero and the gap of the relief."""
    found = gear(drawing(relief={"roller": "4 µm"}), gearboxes=2).drawn
    assert found is not None
    assert found.branches is not None
    assert (found.branches.fewest, found.branches.most) == (17, 18)
    assert (found.branches.arm > 0).all()
    np.testing.assert_allclose(found.branches.gap, 4e-6)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"form": "lobe arcs", "envelope": "rule"}, 'envelope = "rule" with form = "lobe arcs"'),
        (
            {"pins": 12, "envelope": "rule"},
            'envelope = "rule" with K1 = e N/R of 0.529 and 12 lobes',
        ),
        (
            {"pins": 20, "ring_radius": "34 mm", "eccentricity": "1.54 mm", "pin_radius": "1 mm"},
            "second branch of the envelope folds",
        ),
    ],
)
def test_what_is_refused(wrong, message):
    """A method without a second branch, the rule outside of its range, and a branch that folds."""
    with pytest.raises(ValidationError, match=message):
        drawing(**wrong)
