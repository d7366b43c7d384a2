"""Copies of a leg are sized together: one section, one reducer, for the loads of all of them."""

import numpy as np
import pytest

import lostmotion
from lostmotion.analyses.sizing.sizing import size_links
from lostmotion.io.arm_templates import template_text
from lostmotion.io.sizing import read_request
from lostmotion.mechanism.load_causes import bending
from lostmotion.sizing.candidates import Objective
from lostmotion.sizing.evaluation import Constraints, Evaluator
from lostmotion.sizing.lightest import PAPER, with_section
from lostmotion.sizing.links import one_pass

DRIVES = ("left", "right")
STOCK = [{"kind": "tube", "outer": f"{outer} mm", "wall": "2 mm"} for outer in range(16, 44, 2)]


@pytest.fixture(scope="module")
def five_bar(tmp_path_factory):
    """Return the five-bar of the template."""
    path = tmp_path_factory.mktemp("five-bar") / "five-bar.toml"
    path.write_text(template_text("five-bar"), encoding="utf-8")
    return lostmotion.read(path)


def links(arm):
    """Return the link of each joint that has a section."""
    return {each.name: each.link for each in arm.joints if each.link.section is not None}


@pytest.mark.usefixtures("few_scales")
def test_both_arms_of_a_five_bar_get_the_lightest_section_that_is_enough_for_both(five_bar):
    """By the bending in a study: no lighter tube of the list is enough for both links of a pair."""
    options = read_request({"sizing": {"stock": STOCK}}, {}, five_bar, ()).link_options
    poses = lostmotion.sample_poses(five_bar, 16)
    size = size_links(five_bar, options, PAPER, poses)
    assert [each.joint for each in size.links] == ["left", "left-elbow", "right", "right-elbow"]
    assert size.meets_limits

    def enough(arm, names):
        found = bending(arm, size.q, np.zeros((len(size.q), 3)), 0.0)
        return all(
            each.slope <= PAPER.slope and each.deflection * PAPER.deflection <= each.length
            for each in found
            if each.joint in names
        )

    for pair in (("left", "right"), ("left-elbow", "right-elbow")):
        sections = [links(size.sized)[name].section for name in pair]
        assert sections[0] == sections[1]
        assert enough(size.sized, pair)
        lighter = sections[0].model_copy(update={"outer": sections[0].outer - 2e-3})
        assert lighter.outer > 15e-3
        joints = tuple(
            with_section(each, lighter) if each.name in pair else each for each in size.sized.joints
        )
        assert not enough(size.sized.model_copy(update={"joints": joints}), pair)


@pytest.mark.usefixtures("few_scales")
def test_sizing_a_sized_closed_chain_again_changes_nothing(five_bar):
    """Sections are those for the loads that they themselves cause, which loops share."""
    request = read_request(None, {}, five_bar, ())
    size = size_links(five_bar, request.link_options, PAPER, lostmotion.sample_poses(five_bar, 16))
    again, _ = one_pass(size.sized, request.link_options, PAPER, size.q, None, 1e-4)
    assert {name: link.section for name, link in links(again).items()} == {
        name: link.section for name, link in links(size.sized).items()
    }


def test_a_copy_with_options_of_its_own_is_sized_alone(five_bar):
    """A list for one elbow leaves the other the family around its own section."""
    own = {"sizing": {"links": {"right-elbow": {"stock": STOCK}}}}
    options = read_request(own, {}, five_bar, ()).link_options
    sized, _ = one_pass(
        five_bar, options, PAPER, lostmotion.sample_poses(five_bar, 64).q, None, 1e-4
    )
    sections = {name: link.section for name, link in links(sized).items()}
    assert sections["left-elbow"].kind == "box"
    assert sections["right-elbow"].kind == "tube"


def test_a_target_has_one_choice_for_all_copies(five_bar):
    """With the mass of all of them, installed at each."""
    stated = {
        "target": "0.3 mm",
        "gearboxes": {name: ["present", "CSG-20-80"] for name in DRIVES},
        "costs": {"CSG*": {"mass": "1 kg"}},
        "present": {name: {"mass": "0 kg"} for name in DRIVES},
    }
    slots = read_request({"sizing": stated}, {}, five_bar, ()).slots
    assert [each.joints for each in slots] == [DRIVES, DRIVES, ("left-elbow", "right-elbow")]
    assert slots[0].candidates[1].mass == 2.0
    assert slots[1].present.mass == pytest.approx(2 * links(five_bar)["left"].total_mass)
    q = lostmotion.sample_poses(five_bar, 8).q
    evaluator = Evaluator(five_bar, slots, Objective(), q, Constraints())
    choice = (1, 0, 0)
    arm, before = evaluator.arm_with(choice), {each.name: each for each in five_bar.joints}
    made = {each.name: each for each in arm.joints}
    for name in DRIVES:
        assert made[name].gearbox.model == "CSG-20-80"
        assert made[name].total_mass == before[name].total_mass + 1.0
    grown = sum(each.link.total_mass for each in arm.joints) + 2.0
    assert evaluator.evaluate(choice).mass == pytest.approx(grown, rel=1e-12)


def test_copies_that_are_offered_different_parts_are_chosen_apart(five_bar):
    """A reducer that is offered for one drive alone is no choice for the other."""
    stated = {
        "target": "0.3 mm",
        "gearboxes": {"left": ["present"], "right": ["present", "CSG-20-80"]},
        "links": {name: {"keep": True} for name in links(five_bar)},
    }
    slots = read_request({"sizing": stated}, {}, five_bar, ()).slots
    assert [each.joints for each in slots] == [("left",), ("right",)]
