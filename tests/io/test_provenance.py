"""What a file says of where its values come from."""

from __future__ import annotations

import itertools
import json
import tomllib

import pytest

import lostmotion
from lostmotion.catalogue import materials
from lostmotion.error_model.given_values import AssumedValue
from lostmotion.error_model.provenance import states
from lostmotion.errors import InputError
from lostmotion.io import read
from lostmotion.io.arm_writer import sized_text
from lostmotion.io.sweep_designs import read_design
from lostmotion.parts.provenance import LONGEST_SOURCE
from tests.io.conftest import EXAMPLES, JOINT, mistakes

ARM = 'name = "x"\n[gearboxes.g]\nratio = 100\nstiffness = "50 N m/arcmin"\nbacklash = "1 arcmin"\n'
USED = JOINT + 'gearbox = "g"\n'


def written(path, text):
    """Write a file and return its path."""
    path.write_text(text, encoding="utf-8")
    return path


def test_values_that_a_file_assumes_carry_its_source(tmp_path):
    """What a shared table assumes is assumed once, whichever joints use it, and its source stands
    beside it.
    """
    text = (
        ARM
        + 'assumed = ["backlash"]\nsource = "measured on one piece"\n'
        + USED
        + USED.replace('"A"', '"B"')
    )
    found = states(read(written(tmp_path / "arm.toml", text)))
    assert found.assumed[0] == AssumedValue(
        "gearboxes.g", "backlash", "assumed", "measured on one piece"
    )
    assert [(each.key, each.source) for each in found.assumed[1:]] == [("friction_torque", "")]
    assert [each.states["backlash"] for each in found.joints] == ["assumed", "assumed"]
    assert [each.states["stiffness"] for each in found.joints] == ["stated", "stated"]


@pytest.mark.parametrize(
    ("names", "found", "near"),
    [
        ('["stifness"]', "'stifness', not a key of this table", "stiffness"),
        ('["hysteresis"]', "'hysteresis' in assumed, without a value", ""),
        ('["ratio", "zone_torqes"]', "'zone_torqes', not a key of this table", "zone_torques"),
        ('["source"]', "'source', not a key of this table", ""),
    ],
)
def test_only_keys_that_a_table_states_can_be_assumed(tmp_path, names, found, near):
    """A misspelt key, and a key without a value, are refused with the nearest key; the example
    given is accepted.
    """
    (problem,) = mistakes(written(tmp_path / "arm.toml", f"{ARM}assumed = {names}\n{USED}"))
    assert problem.found == found
    assert problem.nearest == near
    if near == "stiffness":
        assert problem.key == "gearboxes.g.assumed"
        read(written(tmp_path / "again.toml", f"{ARM}{problem.example}\n{USED}"))


@pytest.mark.parametrize(
    "text",
    ["assumed = 3", 'assumed = "stiffness"', "assumed = [3]", "source = 3", 'source = "a\\u0007b"'],
)
def test_lists_and_sources_of_another_kind_are_refused(tmp_path, text):
    """Only a list of keys and a line of text are taken."""
    assert mistakes(written(tmp_path / "arm.toml", f"{ARM}{text}\n{USED}"))


def test_every_table_of_a_file_may_say_what_it_assumes(tmp_path):
    """Joints, links, bearings, encoders, mountings, lumped errors, materials, sections, base, tool
    and payload all take both keys.
    """
    text = """
    name = "x"
    base = { roll = "0 deg ± 1 deg", assumed = ["roll"], source = "s1" }
    tool = { mass = "1 kg", assumed = ["mass"], source = "s2" }
    payload = { mass = "1 kg", assumed = ["mass"], source = "s3" }
    [materials.m]
    young = "70 GPa"
    poisson = 0.3
    density = "2700 kg/m^3"
    assumed = ["young"]
    source = "s4"
    [[joints]]
    name = "A"
    type = "revolute"
    limits = ["-90 deg", "90 deg"]
    mass = "1 kg"
    assumed = ["mass", "limits"]
    source = "s5"
    bearing = { kind = "rolling", span = "80 mm", clearance = "20 µm", closing_force = "5 N ± 1 N", assumed = ["clearance"], source = "s6" }
    encoder = { zero = "1 arcmin", assumed = ["zero"], source = "s7" }
    mounting = { tilt = "1 arcmin", assumed = ["tilt"], source = "s8" }
    lumped = { angle = "1 arcmin", assumed = ["angle"], source = "s9" }
    [joints.link]
    length = "400 mm ± 1 mm"
    section = { kind = "tube", outer = "60 mm", wall = "3 mm", assumed = ["wall"], source = "s11" }
    material = "m"
    assumed = ["length"]
    source = "s10"
    """
    found = states(read(written(tmp_path / "arm.toml", text)))
    assert {each.source for each in found.assumed} == {f"s{k}" for k in range(1, 12)}
    assert set(found.joints[0].states.values()) == {"ideal", "assumed"}
    assert found.base == {"tilt": "assumed", "mount": "ideal"}


def test_keys_that_only_the_file_has_can_be_assumed(tmp_path):
    """A fit by its zone, and a row of Denavit-Hartenberg values, stand for the fields that they
    fill.
    """
    text = (EXAMPLES / "arm-from-drawings.toml").read_text(encoding="utf-8")
    text = text.replace('housing_fit = "H7"', 'housing_fit = "H7"\nassumed = ["shaft_fit", "bore"]')
    found = states(read(written(tmp_path / "arm.toml", text)))
    assert {each.key for each in found.assumed if "bearing" in each.owner} >= {
        "shaft_interference",
        "bore",
    }
    row = (
        'name = "x"\n'
        + JOINT
        + 'dh = { a = "1 m", alpha = "0 deg", d = "0 m", theta = "0 deg" }\nassumed = ["dh"]\n'
    )
    assert [each.key for each in states(read(written(tmp_path / "row.toml", row))).assumed] == [
        "origin"
    ]


def test_a_reducer_of_the_catalogue_says_which_values_are_limits(tmp_path):
    """What the maker prints only as an upper limit is assumed, with the row's source; what the user
    states is not.
    """
    own = (
        'name = "x"\n'
        + JOINT
        + (
            'gearbox = { catalogue = "RV-40E-121", backlash = "0.4 arcmin", source = "test '
            'report" }\n'
        )
    )
    for text in ('name = "x"\n' + JOINT + 'gearbox = "RV-40E-121"\n', own):
        arm = read(written(tmp_path / f"arm{len(text)}.toml", text))
        gearbox = arm.moving[0].gearbox
        limits = {
            each.key: each for each in states(arm).assumed if each.reason == "maker's upper limit"
        }
        assert set(limits) == set(gearbox.upper_limits)
        assert all(each.source == gearbox.source for each in limits.values())
        assert gearbox.source
        assert "backlash" not in limits or "0.4 arcmin" not in text
    assert gearbox.source.startswith("test report; the rest: ")
    longest = "t" * LONGEST_SOURCE
    assert (
        read(written(tmp_path / "long.toml", own.replace("test report", longest)))
        .moving[0]
        .gearbox.source
        == longest
    )
    assert mistakes(written(tmp_path / "longer.toml", own.replace("test report", longest + "t")))


def test_a_sidecar_keeps_what_it_says_of_its_values(tmp_path):
    """Joints and links of a URDF take both keys as well."""
    urdf = written(tmp_path / "arm.urdf", (EXAMPLES / "ur5e.urdf").read_text(encoding="utf-8"))
    text = (EXAMPLES / "ur5e.toml").read_text(encoding="utf-8")
    text = text.replace("[joints.elbow_joint]\n", '[joints.elbow_joint]\nsource = "a guess"\n')
    written(tmp_path / "arm.toml", text)
    found = states(read(urdf))
    assert AssumedValue("joints.elbow_joint", "gearbox", "assumed", "a guess") in found.assumed
    assert found.joints[2].states["stiffness"] == "assumed"
    assert found.joints[2].states["axis mounting"] == "ideal"


def test_a_value_set_by_a_sweep_is_not_assumed_any_more(tmp_path):
    """A sweep states its values: only the others of the table stay assumed."""
    path = written(tmp_path / "arm.toml", ARM + 'assumed = ["backlash", "stiffness"]\n' + USED)
    for key, left in (
        ("gearboxes.g.backlash", ("stiffness",)),
        ("joints.A.gearbox.stiffness", ("backlash",)),
    ):
        value = "2 arcmin" if key.endswith("backlash") else "10 N m/arcmin"
        assert read_design(path, None, {key: value}).moving[0].gearbox.assumed == left


def test_values_set_in_python_are_not_assumed_any_more(tmp_path):
    """A copy with another value states that value."""
    gearbox = (
        read(written(tmp_path / "arm.toml", ARM + 'assumed = ["backlash", "stiffness"]\n' + USED))
        .moving[0]
        .gearbox
    )
    assert gearbox.model_copy(update={"stiffness": 1e5}).assumed == ("backlash",)
    assert gearbox.model_copy().assumed == gearbox.assumed


def test_materials_of_the_catalogue_are_typical_values(tmp_path):
    """No value of a material from the catalogue is a fact about this arm; a material from the file
    is.
    """
    for name, material in materials().items():
        assert set(material.assumed) >= {"young", "poisson", "density"}, name
        assert material.source, name
    link = (
        'link = { length = "1 m", section = { kind = "rod", diameter = "50 mm" }, material = '
        '"steel" }\n'
    )
    found = states(read(written(tmp_path / "arm.toml", 'name = "x"\n' + JOINT + link)))
    assert found.joints[0].states["link bending"] == "assumed"
    own = '[materials.steel]\nyoung = "200 GPa"\npoisson = 0.3\ndensity = "7800 kg/m^3"\n'
    found = states(read(written(tmp_path / "own.toml", 'name = "x"\n' + own + JOINT + link)))
    assert found.joints[0].states["link bending"] == "stated"
    assert not found.assumed


def test_a_link_can_be_rigid_on_purpose(tmp_path):
    """A link that is stated as rigid is described; beside a section it is refused."""
    found = states(
        read(
            written(
                tmp_path / "arm.toml",
                'name = "x"\n' + JOINT + 'link = { length = "1 m", rigid = true }\n',
            )
        )
    )
    assert found.joints[0].states["link bending"] == "stated"
    assert found.described
    link = (
        'link = { length = "1 m", rigid = true, section = { kind = "rod", diameter = "50 mm" }, '
        'material = "steel" }\n'
    )
    (problem,) = mistakes(written(tmp_path / "both.toml", 'name = "x"\n' + JOINT + link))
    assert problem.found == "rigid beside section"


def test_the_schema_knows_the_keys():
    """Editors offer both keys in every table that takes them."""
    schema = json.loads((EXAMPLES.parent / "docs" / "arm.schema.json").read_text(encoding="utf-8"))
    for name in (
        "GearboxOfRevoluteJoint",
        "RollingPair",
        "Link",
        "Base",
        "Payload",
        "Material",
        "Tube",
        "RevoluteJoint",
        "Lumped",
    ):
        assert {"assumed", "source"} <= schema["$defs"][name]["properties"].keys(), name


def test_all_mistakes_in_lists_come_at_once(tmp_path):
    """A wrong list in one table does not hide one in another."""
    text = (
        ARM
        + 'assumed = ["x"]\n'
        + USED
        + 'assumed = ["y"]\n'
        + USED.replace('"A"', '"B"')
        + 'encoder = { zero = "1 arcmin", assumed = ["z"] }\n'
    )
    with pytest.raises(InputError) as caught:
        read(written(tmp_path / "arm.toml", text))
    found = {problem.key.rpartition(".")[0] for problem in caught.value.problems}
    assert found == {"gearboxes.g", "joints.A", "joints.B.encoder"}
    assert len(list(itertools.chain(caught.value.problems))) == 3


def test_a_section_that_was_sized_is_not_assumed_any_more(tmp_path):
    """The sized file keeps what else is assumed, and where values come from; the arm in memory
    agrees.
    """
    text = (
        'name = "x"\n[payload]\nmass = "5 kg"\nassumed = ["mass"]\nsource = "brief"\n'
        + JOINT
        + 'axis = "y"\n'
    )
    text += (
        '[joints.link]\nlength = "500 mm ± 1 mm"\nsection = { kind = "tube", outer = "60 mm", '
        'wall = "3 mm" }\nmaterial = "steel"\n'
    )
    path = written(
        tmp_path / "arm.toml", text + 'assumed = ["length", "section"]\nsource = "sketch"\n'
    )
    found = lostmotion.size(lostmotion.read(path), poses=16)
    sized = tomllib.loads(sized_text(path, None, found))
    assert sized["joints"][0]["link"]["assumed"] == ["length"]
    assert sized["joints"][0]["link"]["source"] == "sketch"
    assert sized["payload"]["assumed"] == ["mass"]
    again = read(written(tmp_path / "sized.toml", sized_text(path, None, found)))
    assert again.joints[0].link.assumed == found.sized.joints[0].link.assumed == ("length",)
