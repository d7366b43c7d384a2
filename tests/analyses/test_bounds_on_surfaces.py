"""What a real arm must have and a file does not describe makes every figure a bound, on every
surface; a declared ideal does not.
"""

from __future__ import annotations

import functools
import json
import re

import pytest

import lostmotion
from lostmotion.error_model.poses import sample_poses
from lostmotion.error_model.provenance import states
from lostmotion.error_model.remedies import STAGES
from lostmotion.live_view import panel
from lostmotion.live_view.session import LiveArm
from lostmotion.reporting.layout import row_at
from tests.reporting.first_screen import first_screen

pytestmark = pytest.mark.usefixtures("few_samples")

HEAD = 'name = "three"\n[payload]\nmass = "2 kg"\n'
DRIVE = (
    'ratio = 100, stiffness = "8 N m/arcmin", backlash = "1 arcmin ± 0.3 arcmin", hysteresis = '
    '"0.5 arcmin", friction_torque = "0.5 N m ± 20 %"'
)
TUBE = 'section = { kind = "tube", outer = "80 mm", wall = "4 mm" }, material = "aluminium"'
LINES = {
    "gearbox": f"gearbox = {{ {DRIVE} }}",
    "bearing": 'bearing = { kind = "crossed roller", moment_stiffness = "200e3 N m/rad" }',
    "encoder": 'encoder = { resolution = "20 arcsec", zero = "0.5 arcmin" }',
    "link": f'link = {{ length = "400 mm ± 0.1 mm", {TUBE} }}',
}
# For each kind: what takes its description away, and what declares it ideal instead.
KINDS = {
    "backlash": ('backlash = "1 arcmin ± 0.3 arcmin", ', "", 'backlash = "0 arcmin", '),
    "stiffness": ('stiffness = "8 N m/arcmin", ', "", "rigid = true, "),
    "hysteresis": ('hysteresis = "0.5 arcmin", ', "", 'hysteresis = "0 arcmin", '),
    "bearing": (LINES["bearing"], "", "bearing = { rigid = true }"),
    "encoder": (LINES["encoder"], "", 'encoder = { resolution = "0 arcsec" }'),
    "link bending": (
        'section = { kind = "tube", outer = "80 mm", wall = "4 mm" }, material = "aluminium"',
        'mass = "1 kg"',
        'rigid = true, mass = "1 kg"',
    ),
    "link length": ("400 mm ± 0.1 mm", "400 mm", "400 mm ± 0 mm"),
}


def text_of(changed=lambda text: text):
    """Return an arm of three joints with every kind of error that it must have, the second one
    changed.
    """
    lines = "\n".join(LINES.values())
    head = (
        '[[joints]]\nname = "{}"\ntype = "revolute"\naxis = "{}"\nlimits = ["-120 deg", "120 '
        'deg"]\n'
    )
    first, second, third = (
        head.format(name, axis) + f"{lines}\n"
        for name, axis in zip("ABC", ("z", "-y", "-y"), strict=True)
    )
    return HEAD + first + changed(second) + third


def arm_of(folder, text, name="arm"):
    """Write a text and return the arm."""
    path = folder / f"{name}.toml"
    path.write_text(text, encoding="utf-8")
    return lostmotion.read(path)


def without(kind):
    """Return the text in which nothing describes a kind of error at B."""
    stated, gone, _ = KINDS[kind]
    assert stated in text_of()
    return text_of(lambda text: text.replace(stated, gone))


def declared(kind):
    """Return the text in which a kind of error at B is declared ideal."""
    stated, _, ideal = KINDS[kind]
    return text_of(lambda text: text.replace(stated, ideal))


def all_declared():
    """Return the text in which every kind of error at B is declared ideal."""

    def changed(text):
        for stated, _, ideal in KINDS.values():
            assert stated in text
            text = text.replace(stated, ideal)
        return text

    return text_of(changed)


def view_text(arm):
    """Return the texts of the live view's panel."""
    poses = sample_poses(arm, 8)
    live = LiveArm(arm, poses)
    *_, over_all = live.workspace()
    return re.sub(
        "<[^>]+>", " ", panel.headline(live.figures(poses.q[0]), over_all, 100.0, states(arm))
    )


def exported(arm, folder):
    """Return the READMEs of exported controllers, of ROS 2 its own and that of its model."""
    for export in (lostmotion.export_c, lostmotion.export_ros2):
        export(arm, out=folder / export.__name__)
    readmes = sorted(folder.rglob("README.md"))
    assert len(readmes) == 3
    return [each.read_text(encoding="utf-8") for each in readmes]


FEW = {"poses": 8, "robots": 8, "visits": 3, "workers": 1}


def run_in(folder):
    """Return the folder of a run of the arm."""
    lostmotion.sweep(arm_file(folder), out=folder / "run", **FEW)
    return folder / "run"


SHEETS = {
    "study": lambda arm, _: lostmotion.study(
        arm, poses=8, robots=8, visits=3, target="2 mm", zone="x 0..1 m"
    ),
    "study without sampling": lambda arm, _: lostmotion.study(arm, poses=8, method="analytic"),
    "target of error": lambda arm, _: lostmotion.target(
        arm, error="20 mm", poses=8, robots=20, visits=2
    ),
    "target of RP": lambda arm, _: lostmotion.target(
        arm, rp_any="20 mm", poses=8, robots=20, visits=3
    ),
    "map": lambda arm, _: lostmotion.map(arm, poses=256, cell="400 mm", target="2 mm"),
    "iso9283": lambda arm, _: lostmotion.iso9283(
        arm, robots=20, visits=3, cube="100 mm", centre="700 mm, 0 mm, 500 mm"
    ),
    "size by limits": lambda arm, _: lostmotion.size(arm, poses=8),
    "size for a target": lambda arm, _: lostmotion.size(arm, target="20 mm", poses=8),
    "sweep": lambda _, folder: lostmotion.sweep(arm_file(folder), out=folder / "run", **FEW),
    "replay": lambda _, folder: lostmotion.replay(run_in(folder))[0],
    "compare": lambda arm, folder: lostmotion.compare(
        arm, arm_of(folder, text_of(), "other"), poses=8, robots=8, visits=3
    ),
    "statics": lambda arm, _: lostmotion.statics(arm, poses=8),
    "task": lambda arm, _: lostmotion.task(
        arm,
        {
            "features": [{"name": "a", "kind": "point", "at": (0.9, 0.2, 0.2)}],
            "tolerances": [{"sphere": 5e-3}],
        },
        robots=20,
        runs=2,
    ),
    "check": lambda _, folder: lostmotion.check(arm_file(folder)),
}
# What says that a figure is a bound; friction, which no file describes, makes the repeatability
# from one side one in any case.
BOUND = {
    "study": "^At least .*RP, any approach at least",
    "iso9283": "AP_p of 95 % of arms is at least",
}


# Surfaces whose sheet another one above makes too: of the arm that is declared ideal that one's is
# enough.
SIBLINGS = {"target of RP", "size for a target", "replay"}


def arm_file(folder):
    """Return the file of the arm."""
    return folder / "arm.toml"


# Questions without a figure of an arm's accuracy, and those tested by themselves below. A
# calibration predicts its own estimates, with assumed priors for what a file does not state.
OTHERS = {
    "bearing",
    "calibrate",
    "catalog",
    "compensate",
    "export_c",
    "export_fmu",
    "export_ros2",
    "gear",
    "new",
    "schema",
    "view",
}


def test_no_question_is_forgotten():
    """Every question that predicts an arm's error has a line above: a new one needs one."""
    assert {surface.partition(" ")[0] for surface in SHEETS} | OTHERS == set(lostmotion.QUESTIONS)


def test_the_whole_arm_is_no_bound(tmp_path):
    """With every kind that a real arm must have no figure is a bound, though axis mounting and
    transmission error are not described.
    """
    known = states(arm_of(tmp_path, text_of()))
    assert known.missing == {}
    assert not known.lower_bound


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_that_is_missing_is_named_with_its_joint(tmp_path, kind):
    """A kind that nothing describes is missing at its joint alone; declared ideal, or described, it
    is not.
    """
    assert states(arm_of(tmp_path, without(kind))).missing == {"B": (kind,)}
    assert states(arm_of(tmp_path, declared(kind))).missing == {}


@pytest.fixture(scope="module")
def sheet_of(tmp_path_factory):
    """Return the sheet of a surface for the arm that lacks a stiffness at one joint, or declares it
    ideal; each computed once.
    """

    @functools.cache
    def found(surface, bounded):
        folder = tmp_path_factory.mktemp("surface")
        text = without("stiffness") if bounded else declared("stiffness")
        return SHEETS[surface](arm_of(folder, text), folder).sheet

    return found


@pytest.mark.parametrize("surface", SHEETS)
def test_no_surface_forgets_the_bound(sheet_of, surface):
    """Of an arm without a stiffness at one joint every sheet names it, calls its figures lower
    bounds, and says so in result.json.
    """
    for bounded in (True,) if surface in SIBLINGS else (True, False):
        sheet = sheet_of(surface, bounded)
        words = " ".join([first_screen(sheet), sheet.verdict])
        assert ("tiffness (B) is not described" in words) == bounded
        assert bool(re.search(BOUND.get(surface, r"\b[Aa]t least\b|≥"), words)) == bounded
        found = (
            [sheet.facts["states"]]
            if "states" in sheet.facts
            else [each["states"] for each in sheet.facts["arms"]]
        )
        assert (found[0]["bound"], found[0]["missing"]) == (
            ("lower", {"B": ["stiffness"]}) if bounded else ("none", {})
        )


def test_the_live_view_and_an_exported_controller_carry_the_bound(tmp_path):
    """Their texts name what is missing and say that errors are at least these; of the declared arm
    they do not.
    """
    for text, bounded in ((without("stiffness"), True), (declared("stiffness"), False)):
        folder = tmp_path / str(bounded)
        folder.mkdir()
        arm = arm_of(folder, text)
        for words in (view_text(arm), *exported(arm, folder)):
            assert ("stiffness (B) is not described" in words) == bounded
            assert ("at least" in words) == bounded


# That each kind alone is missing and named is tested above.
@pytest.mark.parametrize("kind", ["link length", "none"])
def test_any_missing_kind_makes_the_figures_of_a_study_bounds(tmp_path, kind):
    """Headline, cards, remedies, RP and the share within a target: bounds without the kind, plain
    figures where every kind is declared ideal, of which none may be overlooked.
    """
    bounded = kind != "none"
    text = without(kind) if bounded else all_declared()
    sheet = lostmotion.study(
        arm_of(tmp_path, text), poses=8, robots=8, visits=3, target="2 mm"
    ).sheet
    assert sheet.verdict.startswith("At least " if bounded else "Expect 95 % of positions within ")
    remedies = next(block for block in sheet.bars if block.key == "waterfall").bars
    assert len(remedies) >= len(STAGES)
    assert {bar.figure.bound for bar in remedies} == {"lower" * bounded}
    assert ("RP, any approach at least" in first_screen(sheet)) == bounded
    assert ("At most" in dict(sheet.brief)["Target"]) == bounded
    cards = {card.title: card.number for card in sheet.cards}
    for title in (
        "95 % of positions within",
        "mean position error",
        "accuracy AP, 95 % of robots within",
        "RP, any approach, 95 % of robots within",
    ):
        assert cards[title].startswith("≥") == bounded
    # Nothing describes a scatter of servo or friction, from which RP from one side comes: a lower
    # bound on every surface in both cases.
    assert cards["RP, ISO cycle, 95 % of robots within"].startswith("≥")
    assert row_at(sheet.sections, "iso9283", "rp_iso_p95").cells[0].bound == "lower"


def test_a_target_is_met_by_what_is_described_alone(sheet_of):
    """'Met' does not stand without the condition, and the yield is an upper bound."""
    sheet = sheet_of("target of error", True)
    assert "is met by what is described." in sheet.verdict
    assert "The yield is at most 100 %" in sheet.verdict
    plain = sheet_of("target of error", False)
    assert "is met." in plain.verdict
    assert "The yield is 100 %" in plain.verdict


def test_an_encoder_describes_no_drive(tmp_path):
    """A joint with a fine encoder and a ratio is no joint without errors: what it lacks is named,
    and kinds that all lack are named once.
    """
    few = (
        'encoder = { resolution = "0.001 deg" }\ngearbox = { ratio = 100 }\nlink = { length = '
        '"400 mm", mass = "2 kg" }\n'
    )
    joint = (
        '[[joints]]\nname = "{}"\ntype = "revolute"\naxis = "-y"\nlimits = ["0 deg", "90 deg"]\n'
    )
    arm = arm_of(tmp_path, HEAD + joint.format("A") + few + joint.format("B") + few)
    sheet = lostmotion.study(arm, poses=8, robots=8, visits=3).sheet
    assert sheet.verdict.startswith("At least ")
    assert (
        ": backlash, stiffness, hysteresis and 3 more kinds of error are not described."
        in sheet.verdict
    )
    bare = arm_of(
        tmp_path,
        HEAD
        + joint.format("A")
        + 'encoder = { resolution = "1e-6 deg" }\n'
        + joint.format("B")
        + few,
    )
    assert states(bare).missing["A"] == ("backlash", "stiffness", "hysteresis", "bearing")
    assert lostmotion.study(bare, poses=8, robots=8, visits=3).sheet.verdict.startswith("At least ")


def test_what_no_real_arm_needs_is_no_bound(tmp_path):
    """Behind an encoder on the output only the play of the drive stays; a strain wave gear has
    none; a lumped error stands for its joint.
    """
    lines = LINES["bearing"] + "\n" + LINES["link"]
    cases = (
        (
            LINES["encoder"].replace("{ ", '{ side = "output", ')
            + '\ngearbox = { ratio = 100, backlash = "1 arcmin" }',
            (),
        ),
        (
            LINES["encoder"].replace("{ ", '{ side = "output", ') + "\ngearbox = { ratio = 100 }",
            ("backlash",),
        ),
        (
            LINES["encoder"]
            + (
                '\ngearbox = { kind = "strain wave", flexspline_teeth = 200, '
                'circular_spline_teeth = 202, rigid = true, hysteresis = "1 arcmin" }'
            ),
            (),
        ),
    )
    for text, missing in cases:
        joint = (
            f'[[joints]]\nname = "A"\ntype = "revolute"\nlimits = ["-60 deg", "60 deg"]\n{lines}\n'
            f"{text}\n"
        )
        assert states(arm_of(tmp_path, HEAD + joint)).missing.get("A", ()) == missing
    lumped = (
        '[[joints]]\nname = "A"\ntype = "revolute"\nlimits = ["-60 deg", "60 deg"]\nlumped = { '
        'angle = "1 arcmin" }\n'
    )
    assert states(arm_of(tmp_path, HEAD + lumped)).missing == {}
    with_link = lumped + 'link = { length = "400 mm" }\n'
    assert states(arm_of(tmp_path, HEAD + with_link)).missing == {
        "A": ("link bending", "link length")
    }


def test_a_slide_must_have_a_guideway_and_a_fixed_joint_its_link(tmp_path):
    """A sliding joint without a guideway, and a fixed one with a link of unknown stiffness, are
    bounds.
    """
    slide = (
        '[[joints]]\nname = "X"\ntype = "prismatic"\naxis = "x"\nlimits = ["0 mm", "300 mm"]\n'
        'gearbox = { stiffness = "40 N/µm", backlash = "0 µm", '
    )
    slide += (
        'hysteresis = "2 µm" }\nencoder = { resolution = "1 µm" }\nbearing = { rigid = true }\n'
    )
    assert states(arm_of(tmp_path, HEAD + slide)).missing == {"X": ("guideway",)}
    whole = HEAD + slide + 'guideway = { straightness = "0 µm" }\n'
    assert states(arm_of(tmp_path, whole)).missing == {}
    fixed = '[[joints]]\nname = "F"\ntype = "fixed"\nlink = { length = "100 mm ± 0.1 mm" }\n'
    assert states(arm_of(tmp_path, whole + fixed)).missing == {"F": ("link bending",)}


def test_rigid_false_declares_nothing(tmp_path):
    """`rigid = false` is no description of a stiffness."""
    text = without("stiffness").replace(
        "ratio = 100, backlash", "ratio = 100, rigid = false, backlash"
    )
    assert states(arm_of(tmp_path, text)).missing == {"B": ("stiffness",)}


@pytest.mark.parametrize(
    ("stated", "why"),
    [
        (
            'gearbox = { ratio = 100, stiffness = "8 N m/arcmin", rigid = true }',
            "rigid beside stiffness",
        ),
        ("bearing = { rigid = false }", "rigid"),
    ],
)
def test_rigid_beside_a_stiffness_is_refused(tmp_path, stated, why):
    """A part cannot be both, and a bearing that is not rigid is described by its kind."""
    with pytest.raises(lostmotion.InputError, match=why):
        arm_of(
            tmp_path,
            (
                f'{HEAD}[[joints]]\nname = "A"\ntype = "revolute"\nlimits = ["-60 deg", "60 deg"]\n'
                f"{stated}\n"
            ),
        )


def test_every_figure_of_a_bound_is_marked_in_result_json(tmp_path):
    """Each error carries the mark by itself, so that a program that reads one figure alone cannot
    miss it.
    """
    study = lostmotion.study(arm_of(tmp_path, without("encoder")), poses=8, robots=8, visits=3)
    from lostmotion.reporting.layout import plain

    found = json.loads(json.dumps(plain(study.sheet, "0")))
    assert found["figures"]["error"]["p95"]["value"] > 0
    assert {
        each["bound"]
        for key in ("error", "iso9283")
        for each in found["figures"][key].values()
        if each["unit"] == "m"
    } == {"lower"}
