"""Selection of parts for a target, from the file to the folder: options, result, tables, plots and
files.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
import json
import math
from pathlib import Path

import pytest

import lostmotion
from lostmotion.analyses.sizing.page.plots import selection_plots
from lostmotion.analyses.sizing.selection import StudySize, select_parts
from lostmotion.error_model.intervals import pooled_quantile
from lostmotion.io.arm_writer import reads_back, sized_text
from lostmotion.io.own_reducers import read_reducers
from lostmotion.io.sizing import read_request
from lostmotion.io.sizing_options import parse_objective
from lostmotion.propagation.montecarlo import kernel
from lostmotion.propagation.montecarlo.montecarlo import run
from lostmotion.reporting.layout import row_at
from lostmotion.sizing.candidates import Objective
from tests.command import carried_out
from tests.sizing.chosen_parts import with_parts

ROOT = Path(__file__).parents[3]
Z_ARM = ROOT / "examples" / "z-arm.toml"
DRAWN = ROOT / "examples" / "arm-from-drawings.toml"
SMALL = StudySize(robots=48, visits=4, seed=1, threads=2)

OFFER = """
[sizing]
minimise = "price + 20 * mass"
price_per_kg = 10
[sizing.links.O]
keep = true
[sizing.links.roll]
keep = true
[sizing.links.A]
stock = [{ kind = "tube", outer = "100 mm", wall = "3 mm" }, { kind = "tube", outer = "180 mm", wall = "3 mm" }]
[sizing.links.B]
stock = [{ kind = "tube", outer = "80 mm", wall = "3 mm" }, { kind = "tube", outer = "140 mm", wall = "3 mm" }]
[sizing.gearboxes]
A = ["present", "RV-40E", "X-9"]
B = ["RV-20E-121", "RV-40E"]
[sizing.bearings]
O = ["present", "10 µm ± 5 µm"]
A = ["30 µm ± 30 µm", "10 µm ± 5 µm"]
[sizing.costs]
"RV-20E*" = { mass = "3.5 kg", price = 900 }
RV-40E = { mass = "7 kg", price = 1500 }
X-9 = { mass = "6 kg", price = 2500 }
"10 µm ± 5 µm" = { price = 40 }
[sizing.present]
A = { mass = "3 kg", price = 900 }
B = { mass = "2.5 kg" }
[[reducers]]
models = ["X-9"]
maker = "X"
part = { rated_torque = "500 N m", stiffness = "150 N m/arcmin", backlash = "0.2 arcmin" }
source = "measured, 2024"
"""


@functools.cache
def z_arm():
    """Return the paper's arm, of which nothing is changed."""
    return lostmotion.read(Z_ARM)


def asked(tmp_path, text, arm=None, own=(), **options):
    """Read a sizing file."""
    path = tmp_path / "by.toml"
    path.write_text(text, encoding="utf-8")
    return read_request(path, options, arm or z_arm(), own)


def found_for(stated_request, arm, target, counts=SMALL, poses=32):
    """Return a selection with few poses."""
    few, all_poses = lostmotion.sample_poses(arm, 16), lostmotion.sample_poses(arm, poses)
    return select_parts(
        arm,
        stated_request.slots,
        stated_request.objective,
        target,
        few,
        all_poses,
        constraints=stated_request.constraints,
        study_size=counts,
    )


@pytest.fixture(scope="module")
def stated_request(tmp_path_factory):
    """Return the options for the paper's arm."""
    return asked(tmp_path_factory.mktemp("by"), OFFER, target="1.1 mm")


@pytest.fixture(scope="module")
def found(stated_request):
    """Return the selection."""
    return found_for(stated_request, z_arm(), stated_request.plan.target)


def error_of(arm, poses=32, counts=SMALL):
    """Return the 95 % error of an arm by a study."""
    sampled = run(
        arm,
        lostmotion.sample_poses(arm, poses),
        counts.robots,
        counts.visits,
        counts.seed,
        compared=0,
    )
    return pooled_quantile(
        sampled.group_hist,
        sampled.replicate_hist,
        0.95,
        float(sampled.per_pose[:, kernel.LARGEST].max()),
    )


def test_the_file_states_the_candidates(stated_request):
    """Ratios come from the present gearboxes, masses and prices by name, model or pattern, and rows
    from the file itself.
    """
    slots = {slot.label: slot for slot in stated_request.slots}
    assert list(slots) == ["O bearing", "A gearbox", "A bearing", "A link", "B gearbox", "B link"]
    assert [(each.name, each.mass, each.price) for each in slots["A gearbox"].candidates] == [
        ("present", 3.0, 900.0),
        ("RV-40E-121", 7.0, 1500.0),
        ("X-9-121", 6.0, 2500.0),
    ]
    assert slots["A gearbox"].candidates[1].part.ratio == 121
    assert slots["A gearbox"].candidates[2].file_value["stiffness"] == "150 N m/arcmin"
    assert [each.name for each in slots["B gearbox"].candidates] == ["RV-20E-121", "RV-40E-121"]
    assert math.isnan(slots["B gearbox"].present.price)
    assert slots["A bearing"].candidates[0].part is None
    assert slots["A bearing"].candidates[1].part.clearance.nominal == pytest.approx(10e-6)
    assert slots["A link"].candidates[0].price == pytest.approx(
        10 * slots["A link"].candidates[0].mass
    )
    assert stated_request.objective == Objective(20.0, 1.0)
    assert stated_request.constraints.limits is None


def test_the_selected_parts_meet_the_target_at_the_least_cost(stated_request, found):
    """The upper end of the study's error is within the target, and no cheaper selection has
    that.
    """
    arm = z_arm()
    assert found.meets_target
    assert error_of(found.sized) == found.error
    assert error_of(arm) == found.error_before
    assert found.proven
    cost = stated_request.objective.cost(found.mass, found.price)
    cheaper = [
        chosen
        for chosen in itertools.product(*(slot.candidates for slot in stated_request.slots))
        if sum(stated_request.objective.cost(each.mass, each.price) for each in chosen)
        < cost * (1 - 1e-9)
    ]
    assert cheaper
    for chosen in cheaper:
        assert error_of(with_parts(arm, stated_request.slots, chosen)).high > found.target * (
            1 - 0.01
        )


def test_every_selected_part_is_needed(found):
    """With any part replaced by the cheapest the error exceeds the target; looser targets cost
    less.
    """
    assert any(each.error_with_cheapest for each in found.parts)
    for each in found.parts:
        if each.error_with_cheapest is not None:
            assert each.saving > 0
            assert each.error_with_cheapest.high > found.target
    costs = [point.cost for point in found.trade_off]
    assert costs == sorted(costs, reverse=True)
    assert all(
        point.error.value < point.target * 1.05 for point in found.trade_off if point.meets_target
    )
    assert {point.target for point in found.trade_off} >= {found.target}


def test_the_sheet_agrees_with_the_selected_arm(found):
    """Masses, prices, errors and torques on the sheet are those of the arm, and every plot belongs
    to a section.
    """
    noted = dataclasses.replace(found, notes=("a note",))
    sheet = noted.sheet
    gearbox = row_at(sheet.sections, "parts", "A_gearbox")
    assert gearbox.cells[0].as_shown == 3.0
    assert gearbox.cells[1].as_shown == next(
        each.selected.mass for each in found.parts if each.slot.label == "A gearbox"
    )
    assert row_at(sheet.sections, "error", "selected_parts").cells[0].as_shown == pytest.approx(
        found.error.value * 1e3
    )
    assert row_at(sheet.sections, "trade", "1_1_mm").note == "stated target"
    held, rated, share = (figure.value for figure in row_at(sheet.sections, "torques", "A").cells)
    assert share == pytest.approx(held / rated)
    assert share <= 1
    assert "All cheaper selections miss the target" in sheet.verdict
    assert any("RV-40E-121 is taken from the catalogue" in note for note in sheet.notes) == any(
        each.selected.name == "RV-40E-121" for each in found.parts
    )
    assert {plot.section for plot in selection_plots(found)} <= {
        section.key for section in sheet.sections
    }
    json.dumps(noted.result(), allow_nan=False)


def test_the_selected_arm_reads_back_with_the_printed_error(found, tmp_path):
    """sized.toml is the user's file with other parts, comments preserved; read again it has the
    printed error, bit for bit.
    """
    folder = dataclasses.replace(found, source=Z_ARM).report(tmp_path / "out")
    written = folder / "sized.toml"
    assert not reads_back(Z_ARM, written, found)
    assert error_of(lostmotion.read(written)) == found.error
    assert "# paper: working clearance up to 60 µm" in written.read_text(encoding="utf-8")
    assert not lostmotion.read(written).notes or all(
        "used by no joint" not in note for note in lostmotion.read(written).notes
    )


@pytest.mark.parametrize(
    "pick", [(1, 0, 0, 0, 0, 0), (0, 2, 1, 1, 0, 1), (1, 1, 1, 0, 1, 0), (0, 0, 0, 1, 1, 1)]
)
def test_every_selection_is_written(stated_request, found, tmp_path, pick):
    """Shared bearings that become different, reducers of the file itself and unchanged parts: all
    read back as the arm.
    """
    arm = z_arm()
    chosen = tuple(slot.candidates[k] for slot, k in zip(stated_request.slots, pick, strict=True))
    bought = tuple(
        dataclasses.replace(each, selected=candidate)
        for each, candidate in zip(found.parts, chosen, strict=True)
    )
    other = dataclasses.replace(
        found, sized=with_parts(arm, stated_request.slots, chosen), parts=bought
    )
    out = tmp_path / "sized.toml"
    out.write_text(sized_text(Z_ARM, None, other), encoding="utf-8")
    assert not reads_back(Z_ARM, out, other)


@pytest.mark.slow
def test_groups_of_clearances_are_candidates_of_drawn_bearings(tmp_path):
    """C2, CN and C3 of a drawn bearing are the standard's bands; where all joints take the same the
    shared bearing gets it.
    """
    arm = lostmotion.read(DRAWN)
    text = (
        '[sizing]\ntarget = "2 mm"\nkeep = true\n[sizing.bearings]\nshoulder = ["C2", "CN", "C3"]\n'
        'elbow = ["C3", "C2"]'
    )
    stated_request = asked(tmp_path, text, arm)
    shoulder = {slot.label: slot for slot in stated_request.slots}["shoulder bearing"]
    assert shoulder.candidates[1].part is None
    assert [
        each.part.clearance.nominal * 1e6 for each in shoulder.candidates if each.part
    ] == pytest.approx([6.0, 26.5], abs=1.5)
    found = found_for(stated_request, arm, stated_request.plan.target, poses=32)
    assert found.meets_target
    assert not found.torques
    out = tmp_path / "sized.toml"
    out.write_text(sized_text(DRAWN, None, found), encoding="utf-8")
    assert not reads_back(DRAWN, out, found)


@pytest.mark.slow
def test_a_target_out_of_reach_is_reported_with_the_largest_effect(tmp_path):
    """Where no selection meets the target: the most accurate, the largest effect, no sized arm, and
    a trade-off around its error.
    """
    arm = lostmotion.read(Z_ARM)
    stated_request = asked(tmp_path, OFFER, arm, target="0.2 mm")
    found = found_for(stated_request, arm, stated_request.plan.target)
    assert not found.meets_target
    reached = dataclasses.replace(found, source=Z_ARM)
    assert "No selection meets the target of 0.2 mm" in reached.sheet.verdict
    assert "Largest effect: joints." in reached.sheet.verdict
    assert found.trade_off[0].target > found.target
    folder = reached.report(tmp_path / "out")
    assert sorted(path.name for path in folder.iterdir()) == ["report.html", "result.json"]


def test_the_whole_catalogue_may_be_offered(tmp_path):
    """Candidates from the catalogue have the ratio and the rating; rows without costs are excluded
    and noted.
    """
    text = """
[sizing]
target = "1 mm"
minimise = "price"
keep = true
[sizing.gearboxes]
A = "catalogue"
[sizing.costs]
"RV-*E*" = { price = 1000 }
"""
    stated_request = asked(tmp_path, text)
    (slot,) = stated_request.slots
    names = [each.name for each in slot.candidates]
    assert "RV-40E-121" in names
    assert all(each.part.rated_torque > 40 for each in slot.candidates)
    assert any(
        "excluded, because their costs are not stated" in note for note in stated_request.notes
    )
    assert any(
        "mass of the present one" in note and "not stated: the joint keeps its mass" in note
        for note in stated_request.notes
    )


def test_the_catalogue_stands_in_a_list_beside_other_candidates(tmp_path):
    """The present gearbox, a named one, and all suitable rows, each once; the order of the list
    does not matter to what is offered.
    """
    text = """
[sizing]
target = "1 mm"
minimise = "price"
keep = true
[sizing.gearboxes]
A = {}
[sizing.costs]
"RV-*E*" = {{ price = 1000 }}
[sizing.present]
A = {{ price = 950 }}
"""
    whole, both, listed = (
        [each.name for each in asked(tmp_path, text.format(stated)).slots[0].candidates]
        for stated in (
            '"catalogue"',
            '["present", "catalogue"]',
            '["catalogue", "RV-40E-121", "present"]',
        )
    )
    assert both == ["present", *whole]
    assert sorted(listed) == sorted(both)
    assert (
        asked(tmp_path, text.format('["catalogue"]')).slots[0].candidates
        == asked(tmp_path, text.format('"catalogue"')).slots[0].candidates
    )
    with pytest.raises(lostmotion.InputError, match="no price of CSF"):
        asked(tmp_path, text.format('["CSF-25-100", "catalogue"]'))


CATALOGUE_ARM = """name = "x"
[[joints]]
name = "A"
type = "revolute"
limits = ["-90 deg", "90 deg"]
gearbox = "RV-20E-121"
link = { length = "500 mm ± 50 µm", mass = "2 kg" }
"""


@pytest.mark.parametrize(("stated", "exchanged"), [("", 9.3), ('mass = "6 kg"\n', 6 - 4.7 + 9.3)])
def test_exchanging_a_reducer_changes_the_mass_by_the_difference_of_the_catalogues(
    tmp_path, stated, exchanged
):
    """An RV-40E of 9.3 kg in the place of an RV-20E of 4.7 kg, whether the joint's mass is stated
    or is its reducer's; no cost is required.
    """
    path = tmp_path / "arm.toml"
    path.write_text(CATALOGUE_ARM.replace("gearbox", stated + "gearbox"), encoding="utf-8")
    arm = lostmotion.read(path)
    text = (
        '[sizing]\ntarget = "1 mm"\nkeep = true\n[sizing.gearboxes]\nA = ["present", "RV-40E", '
        '"RV-80E"]\n'
    )
    (slot,) = asked(tmp_path, text, arm).slots
    assert [(each.name, each.mass) for each in slot.candidates] == [
        ("present", 4.7),
        ("RV-40E-121", 9.3),
        ("RV-80E-121", 13.1),
    ]
    assert slot.present.mass == 4.7
    assert slot.install(arm.joints[0], slot.candidates[0]).total_mass == arm.joints[0].total_mass
    assert slot.install(arm.joints[0], slot.candidates[1]).total_mass == pytest.approx(exchanged)


def test_incomplete_masses_are_noted(tmp_path):
    """A strain wave gear's mass is that of its component set; the result notes what it does not
    include.
    """
    path = tmp_path / "arm.toml"
    path.write_text(CATALOGUE_ARM, encoding="utf-8")
    text = (
        '[sizing]\ntarget = "1 mm"\nkeep = true\n[sizing.gearboxes]\nA = ["present", '
        '"CSG-40-120"]\n'
    )
    notes = asked(tmp_path, text, lostmotion.read(path)).notes
    assert any(
        note.startswith("mass of CSG-40-120") and "no output bearing" in note for note in notes
    )


def test_a_candidate_of_unknown_mass_counts_as_zero_and_is_named(tmp_path):
    """Where only the price is minimised, a row without a mass counts as zero, and the result notes
    it.
    """
    path = tmp_path / "arm.toml"
    path.write_text(CATALOGUE_ARM, encoding="utf-8")
    arm = lostmotion.read(path)
    text = (
        '[sizing]\ntarget = "1 mm"\nkeep = true\nminimise = "price"\n[sizing.gearboxes]\nA = '
        '["RV-40E", "X-9"]\n'
        '[sizing.costs]\n"*" = { price = 1 }\n' + OFFER[OFFER.index("[[reducers]]") :]
    )
    stated_request = asked(tmp_path, text, arm)
    assert [each.mass for each in stated_request.slots[0].candidates] == [9.3, 0.0]
    assert any(
        "mass of X-9-121 not stated: counted as zero" in note for note in stated_request.notes
    )


def test_rows_of_the_arm_file_may_be_offered(tmp_path):
    """A reducer that the arm file describes is offered by its name, and the sized arm names it."""
    text = Z_ARM.read_text(encoding="utf-8").replace(
        "# ---- Parts that several joints share",
        (
            '[[reducers]]\nmodels = ["Mine"]\nmaker = "me"\npart = { rated_torque = "300 N m", '
            'stiffness = "90 N m/arcmin" }\nsource = "measured"\n'
        ),
    )
    path = tmp_path / "arm.toml"
    path.write_text(text, encoding="utf-8")
    offer = (
        '[sizing]\ntarget = "1.3 mm"\nminimise = "price"\nkeep = true\n[sizing.gearboxes]\nA = '
        '["Mine"]\n[sizing.costs]\nMine = { price = 1 }'
    )
    arm = lostmotion.read(path)
    stated_request = asked(tmp_path, offer, arm, read_reducers(path))
    assert stated_request.slots[0].candidates[0].file_value == "Mine-121"
    found = found_for(stated_request, arm, stated_request.plan.target)
    out = tmp_path / "sized.toml"
    out.write_text(sized_text(path, None, found), encoding="utf-8")
    assert not reads_back(path, out, found)


@pytest.mark.parametrize(
    ("text", "objective"),
    [
        ("mass", Objective(1.0, 0.0)),
        ("price", Objective(0.0, 1.0)),
        ("mass + 0.05*price", Objective(1.0, 0.05)),
        ("price + 20 * mass", Objective(20.0, 1.0)),
        ("mass + mass", None),
        ("weight", None),
        ("-1 * mass", None),
        ("0 * mass", None),
        ("1e999 * mass", None),
        ("", None),
    ],
)
def test_the_objective_is_a_sum(text, objective):
    """Masses and prices, each with a factor."""
    assert parse_objective(text) == objective


def test_every_mistake_is_reported_at_once(tmp_path):
    """Wrong names with the nearest, joints that do not exist, a target without unit, wrong costs:
    all in one message, each under its key.
    """
    text = """
[sizing]
target = "0.5"
minimise = "wieght"
[sizing.gearboxes]
A = ["RV-40F"]
Q = ["RV-40E"]
B = 3
C = []
[sizing.bearings]
A = ["C2"]
BB = ["CN"]
[sizing.costs]
RV-40E = { mas = "3 kg" }
C2 = 3
[sizing.present]
A = { mass = "three" }
Z = { mass = "3 kg" }
"""
    with pytest.raises(lostmotion.InputError) as caught:
        asked(tmp_path, text)
    problems = {problem.key: problem for problem in caught.value.problems}
    assert set(problems) == {
        "sizing.target",
        "sizing.minimise",
        "sizing.gearboxes.A",
        "sizing.gearboxes.Q",
        "sizing.gearboxes.B",
        "sizing.gearboxes.C",
        "sizing.bearings.A",
        "sizing.bearings.BB",
        "sizing.costs.RV-40E.mas",
        "sizing.costs.C2",
        "sizing.present.A.mass",
        "sizing.present.Z",
    }
    assert problems["sizing.gearboxes.A"].nearest == "RV-40E"
    assert problems["sizing.costs.RV-40E.mas"].nearest == "mass"


_HEAVY = (
    '[sizing]\ntarget = "1 mm"\nkeep = true\n[sizing.gearboxes]\nA = ["RV-40E"]\n[sizing.costs]\n'
    'RV-40E = { mass = "9 kg" }\n'
)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            '[sizing]\ntarget = "1 mm"\nkeep = true\n[sizing.gearboxes]\nA = ["RV-40E"]',
            "sizing.present.A",
        ),
        (
            '[sizing]\ntarget = "1 mm"\nkeep = true\n[sizing.gearboxes]\nA = ["X-9"]\n'
            + OFFER[OFFER.index("[[reducers]]") :],
            "no mass of X-9-121",
        ),
        (
            (
                '[sizing]\ntarget = "1 mm"\nkeep = true\nminimise = "price"\n[sizing.gearboxes]\n'
                'A = ["RV-40E"]'
            ),
            "no price of RV-40E-121",
        ),
        ('[sizing]\ntarget = "1 mm"\nminimise = "price"', "price_per_kg"),
        ('[sizing]\n[sizing.gearboxes]\nA = ["RV-40E"]', "no target"),
        ('[sizing]\nminimise = "price"', "no target"),
        (_HEAVY, "sizing.present.A"),
        (_HEAVY + '[sizing.present]\nA = { mass = "5 kg" }', "no more than the joint's own mass"),
        (
            (
                '[sizing]\ntarget = "1 mm"\nkeep = true\nminimise = "price"\n[sizing.gearboxes]\n'
                'A = "catalogue"'
            ),
            "reducers without costs",
        ),
        ('[sizing]\ntarget = "1 mm"\nkeep = true', "no link to size"),
        ('[sizing]\ntarget = "-1 mm"', "sizing.target"),
    ],
)
def test_missing_values_are_reported(tmp_path, text, words):
    """One clear message for each value that the search needs."""
    with pytest.raises(lostmotion.InputError, match=words):
        asked(tmp_path, text)


def ran(*words, cwd):
    """Run the command in a folder."""
    return carried_out("size", *words, cwd=cwd)


def test_mistakes_end_with_2_and_write_nothing(tmp_path):
    """A mistake in an option has the option's name."""
    done = ran(Z_ARM, "--target", "0.5", "--minimise", "beauty", "--out", "out", cwd=tmp_path)
    assert done.returncode == 2
    assert "--target" in done.stderr
    assert "--minimise" in done.stderr
    assert not (tmp_path / "out").exists()
