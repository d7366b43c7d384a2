"""Presets: typical values of a class of parts, for what an arm file does not state."""

from __future__ import annotations

import tomllib

import pytest

from lostmotion import catalog
from lostmotion.catalogue.gearbox_row import mark_of
from lostmotion.catalogue.presets import PARTS, presets
from lostmotion.error_model.provenance import states
from lostmotion.errors import InputError
from lostmotion.io import read
from lostmotion.io.native import arm_of
from lostmotion.laws.process_tolerance import process_tolerance
from tests.io.conftest import EXAMPLES

ROWS = [row for of_part in presets().values() for row in of_part.values()]
LIMITS = {"revolute": ["-90 deg", "90 deg"], "prismatic": ["0 mm", "500 mm"]}
# An arm in ten lines: three presets, three joints and a payload.
SHORT = """
name = "my arm"
payload = { mass = "100 g" }
presets = { revolute = "hobby servo", link = "printed PLA", mounting = "printed" }
joints = [
    { name = "turn", type = "revolute", limits = ["-90 deg", "90 deg"], link = { length = "60 mm", direction = "z" } },
    { name = "shoulder", type = "revolute", axis = "-y", limits = ["-90 deg", "90 deg"], link = { length = "110 mm" } },
    { name = "elbow", type = "revolute", axis = "-y", limits = ["-90 deg", "90 deg"], link = { length = "130 mm" } },
]
"""


def arm(text: str):
    """Return the arm that the text of a file describes."""
    return arm_of("arm.toml", tomllib.loads(text))


def one_joint(kind: str = "revolute", **keys):
    """Return the arm of one joint with these keys in its table."""
    link = {"length": "200 mm", **keys.pop("link", {})}
    return arm_of(
        "arm.toml",
        {
            "name": "x",
            "joints": [{"name": "A", "type": kind, "limits": LIMITS[kind], "link": link, **keys}],
        },
    )


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row.part} {row.name}")
def test_every_preset_is_accepted_and_all_of_its_values_count_as_assumed(row):
    """Every value of a preset is assumed, under the name of the preset and with its source, and
    nothing of the joint is stated.
    """
    kind = row.type or "revolute"
    made = one_joint(
        kind, **({"preset": row.name} if row.part == "joint" else {row.part: {"preset": row.name}})
    )
    found = states(made)
    expected = (
        {(part, key) for part in PARTS for key in row.values.get(part, {})}
        if row.part == "joint"
        else {(row.part, key) for key in row.values}
    )
    listed = {
        (each.owner.split(".")[2], each.key)
        for each in found.assumed
        if each.reason == f"preset {row.name}" and each.owner.count(".") == 2
    }
    assert listed == {(part, key) for part, key in expected if key != "kind"}
    assert all(each.source for each in found.assumed if each.reason == f"preset {row.name}")
    assert "stated" not in found.joints[0].states.values()
    assert "assumed" in found.joints[0].states.values()
    assert mark_of(row.source)
    assert made.notes == (f"values of presets, all of them assumed: {row.name}",)


def test_an_arm_of_ten_lines_has_every_kind_of_error():
    """Three presets describe play, stiffness, encoder, axes and links of every joint, all of them
    assumed.
    """
    found = states(arm(SHORT))
    assert len(SHORT.strip().splitlines()) <= 10
    assert found.ideal_joints == ()
    assert {state for each in found.joints for state in each.states.values()} == {
        "assumed",
        "ideal",
    }
    assert set(found.ideal_kinds) == {"hysteresis"}


def test_a_stated_value_takes_precedence_over_the_preset():
    """What the file states is stated; the rest of the part is that of the preset."""
    gearbox = one_joint(preset="hobby servo", gearbox={"backlash": "0.2 deg"}).joints[0].gearbox
    assert gearbox.backlash.nominal == pytest.approx(0.2 * 0.0174533, rel=1e-5)
    assert "backlash" not in gearbox.preset.keys
    assert gearbox.stiffness == pytest.approx(0.6 / 0.0174533, rel=1e-5)
    assert "stiffness" in gearbox.preset.keys


def test_a_part_of_another_kind_or_name_takes_nothing_from_the_preset_of_the_joint():
    """A gearbox by its teeth or from the catalogue is described by itself, while the encoder
    remains that of the preset.
    """
    for gearbox in (
        {"kind": "planetary", "sun_teeth": 20, "ring_teeth": 70},
        "CSG-25-100",
        {"preset": "small planetary"},
    ):
        joint = one_joint(preset="hobby servo", gearbox=gearbox).joints[0]
        assert joint.encoder.preset.name == "hobby servo"
        assert getattr(getattr(joint.gearbox, "preset", None), "name", "") != "hobby servo"


def test_a_changed_value_is_no_longer_that_of_the_preset():
    """A copy with another value lists the others only."""
    gearbox = one_joint(preset="hobby servo").joints[0].gearbox
    changed = gearbox.model_copy(update={"hysteresis": 0.0, "stiffness_scatter": 0.1})
    assert set(gearbox.preset.keys) - set(changed.preset.keys) == {"stiffness_scatter"}


def test_a_stated_length_tolerance_replaces_that_of_the_process():
    """A link of a process has the general tolerance of its length unless it states its own."""
    found, stated = (
        one_joint(link={"preset": "machined ISO 2768 m", "length": length})
        for length in ("400 mm", "400 mm ± 30 µm")
    )
    limits = [
        [term.term.scale * term.term.bound for term in each.terms if term.term.cause == "length"]
        for each in (found, stated)
    ]
    assert limits == [[pytest.approx(process_tolerance("ISO 2768 m", 0.4))], [pytest.approx(30e-6)]]
    assert states(found).joints[0].states["link length"] == "assumed"
    assert states(stated).joints[0].states["link length"] == "stated"


def test_presets_of_a_whole_arm_apply_where_a_joint_names_none(tmp_path):
    """In the sidecar of a URDF three words describe all joints; a fixed frame gets no axis error,
    and the masses remain those of the URDF.
    """
    sidecar = tmp_path / "my.toml"
    sidecar.write_text(
        'presets = { revolute = "hobby servo", link = "printed PETG", mounting = "printed" }\n'
    )
    found = read(EXAMPLES / "ur5e.urdf", sidecar)
    assert {joint.gearbox.preset.name for joint in found.moving} == {"hobby servo"}
    assert all(joint.mass == 0 for joint in found.moving)
    assert not any(joint.mounting for joint in found.joints if joint.type == "fixed")
    assert found.mass == pytest.approx(read(EXAMPLES / "ur5e.urdf").mass)


@pytest.mark.parametrize(
    ("text", "key", "words"),
    [
        ('preset = "hoby servo"', "joints.A.preset", "hobby servo"),
        ('preset = "belt axis"', "joints.A.preset", "a preset of a revolute joint"),
        ("preset = 3", "joints.A.preset", "hobby servo"),
        ('link = { length = "1 m", preset = "oak" }', "joints.A.link.preset", "printed PLA"),
        (
            'gearbox = { kind = "worm", wheel_teeth = 60, preset = "small planetary" }',
            "joints.A.gearbox.kind",
            "small planetary",
        ),
        ('encoder = { preset = "17 bits" }', "joints.A.encoder.preset", "there is none"),
        ('lumped = { preset = "hobby servo" }', "joints.A.lumped.preset", "angle"),
    ],
)
def test_a_wrong_name_of_a_preset_is_refused_with_those_that_fit(text, key, words):
    """The message names the key as the user wrote it, and the presets of that part."""
    with pytest.raises(InputError) as refused:
        arm(
            'name = "x"\n[[joints]]\nname = "A"\ntype = "revolute"\nlimits = ["-90 deg", "90 '
            f'deg"]\n{text}'
        )
    (problem,) = refused.value.problems
    assert problem.key == key
    assert words in f"{problem.expected} {problem.example} {problem.nearest}"


@pytest.mark.parametrize(
    ("table", "key"),
    [
        ({"turning": "hobby servo"}, "presets.turning"),
        ({"link": "hobby servo"}, "presets.link"),
        (3, "presets"),
    ],
)
def test_a_wrong_entry_among_the_presets_of_all_joints_is_refused(table, key):
    """Unknown keys and names, and anything but a table."""
    with pytest.raises(InputError) as refused:
        arm_of(
            "arm.toml",
            {
                "name": "x",
                "presets": table,
                "joints": [{"name": "A", "type": "revolute", "limits": LIMITS["revolute"]}],
            },
        )
    assert [problem.key for problem in refused.value.problems] == [key]


def test_the_catalogue_lists_every_preset_and_prints_one_with_all_its_values():
    """`lostmotion catalog` shows each preset with its source, and by its name every value of it."""
    listed = catalog(kind="preset").sheet.facts["presets"]
    assert listed == [row.name for row in ROWS]
    (entry,) = catalog("hobby servo").sheet.facts["entries"]
    assert entry["gearbox"]["backlash"] == "0.9 deg ± 0.4 deg"
    (section,) = catalog("belt axis", kind="preset").sheet.sections
    assert {"gearbox.lead", "source"} <= {row.label for row in section.rows}


def test_what_a_part_of_a_preset_consists_of_is_assumed_too():
    """Height, width and wall of a section that a preset describes, and the values of its material,
    are not stated values of the arm.
    """
    made = states(one_joint(link={"preset": "printed PLA"}))
    within = [each for each in made.given if each.owner.startswith("joints.A.link.")]
    assert {each.key for each in within} >= {"height", "width", "wall"}
    assert not [each.key for each in within if each.state == "stated"]
