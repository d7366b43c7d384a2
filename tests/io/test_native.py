"""The native TOML format."""

from __future__ import annotations

import pytest

from lostmotion.io import read
from lostmotion.io.native import arm_of
from lostmotion.mechanism.state import state_of
from tests.io.conftest import JOINT

HEAD = 'name = "x"\n'


def test_a_whole_file_becomes_an_arm(tmp_path):
    """Shared parts stand where joints name them, and materials come from the catalogue or from the
    file.
    """
    path = tmp_path / "arm.toml"
    path.write_text(
        HEAD
        + """
        [gearboxes.g]
        ratio = 121
        [materials.foam]
        young = "1 GPa"
        poisson = 0.1
        density = "100 kg/m^3"
        [sections.t]
        kind = "rod"
        diameter = "50 mm"
        [[joints]]
        name = "A"
        type = "revolute"
        limits = ["-90 deg", "90 deg"]
        gearbox = "g"
        link = { length = "400 mm ± 50 µm", section = "t", material = "foam" }
        [[joints]]
        name = "B"
        type = "prismatic"
        limits = ["0 mm", "300 mm"]
        gearbox = "g"
        link = { length = "400 mm", section = { kind = "tube", outer = "60 mm", wall = "3 mm" }, material = "steel" }
        """,
        encoding="utf-8",
    )
    arm = read(path)
    assert [joint.name for joint in arm.joints] == ["A", "B"]
    assert [joint.gearbox.ratio for joint in arm.moving] == [121, 121]
    assert arm.joints[0].link.material.young == 1e9
    assert arm.joints[0].link.length.tolerance == pytest.approx(50e-6)
    assert arm.joints[1].link.material.young == pytest.approx(210e9)
    assert arm.notes == ()


def test_a_gripper_of_two_fingers_stands_on_one_flange(tmp_path):
    """A joint and the tool may each name the place that they stand on: the second finger and the
    tool share the flange with the first finger.
    """
    path = tmp_path / "arm.toml"
    finger = (
        '[[joints]]\nname = "{}"\ntype = "fixed"\nafter = "A.tip"\nlink = {{ length = "80 mm", '
        'direction = "{}", mass = "2 kg" }}\n'
    )
    path.write_text(
        HEAD
        + JOINT
        + 'link = { length = "1 m" }\n'
        + finger.format("left", "y")
        + finger.format("right", "-y")
        + '[tool]\nafter = "A.tip"\n',
        encoding="utf-8",
    )
    arm = read(path)
    at = dict(zip(arm.places, state_of(arm, [[0.0]]).frames[:, 0, :3, 3], strict=True))
    assert at["left.tip"] == pytest.approx([1.0, 0.08, 0.0])
    assert at["right.tip"] == pytest.approx([1.0, -0.08, 0.0])
    assert at["tool"] == pytest.approx([1.0, 0.0, 0.0])
    weight = dict(zip(arm.places, -state_of(arm, [[0.0]]).wrenches[:, 0, 5], strict=True))
    assert weight["base"] == pytest.approx(4 * 9.80665)
    assert weight["left"] == pytest.approx(2 * 9.80665)
    assert weight["tool"] == 0.0


def test_three_mistakes_are_reported_at_once(mistakes_in):
    """A wrong unit, a misspelt key and a name that leads nowhere come in one message, each with its
    own near word.
    """
    found = mistakes_in(
        HEAD
        + '[gearboxes.shoulder]\nratio = 100\nstiffness = "50 N m"\n'
        + JOINT
        + (
            'gearbox = "sholder"\n[[joints]]\nname = "B"\ntype = "revolute"\nlimitz = ["-90 deg", '
            '"90 deg"]\nlimits = ["0 deg", "1 deg"]\n'
        )
        + 'gearbox = "shoulder"\n',
    )
    assert set(found) == {"joints.A.gearbox", "joints.B.limitz", "gearboxes.shoulder.stiffness"}
    assert found["joints.A.gearbox"].nearest == "shoulder"
    assert found["joints.B.limitz"].nearest == "limits"
    assert "angular stiffness" in found["gearboxes.shoulder.stiffness"].expected


def test_distributions_are_read_from_a_file(tmp_path):
    """Words and tables of distributions stand beside the amount that they belong to."""
    path = tmp_path / "arm.toml"
    table = "[[-1, 0], [0.2, 0.5], [1, 1]]"
    lines = (
        f'lumped = {{ angle = "1 arcmin", law = {table} }}\n'
        'encoder = { noise = "1 arcmin", noise_law = "normal without limits" }\n'
        f'link = {{ length = {{ value = "400 mm ± 50 µm", law = {table} }} }}\n'
    )
    path.write_text(HEAD + JOINT + lines, encoding="utf-8")
    joint = read(path).joints[0]
    assert joint.lumped.law == joint.link.length.law == ((-1.0, 0.0), (0.2, 0.5), (1.0, 1.0))
    assert joint.encoder.noise_law == "normal without limits"


@pytest.mark.parametrize(
    ("lines", "key", "expected"),
    [
        ("gearbox = { backlash = 3 }\n", "joints.A.gearbox.backlash", "angle"),
        ("gearbox = { stiffness = 3 }\n", "joints.A.gearbox.stiffness", "or a list"),
        (
            'gearbox = { stiffness = ["1 N m/rad", "2 m"], zone_torques = ["1 N m"] }\n',
            "joints.A.gearbox.stiffness[1]",
            "stiffness",
        ),
        (
            'gearbox = { stiffness = ["2 N m/rad", "1 N m/rad"] }\n',
            "joints.A.gearbox",
            "zone torques",
        ),
        (
            'gearbox = { transmission_error = [{ amplitude = "1 mm", cycles = 2 }] }\n',
            "joints.A.gearbox.transmission_error[0].amplitude",
            "angle",
        ),
        ("gearbox = 5\n", "joints.A.gearbox", "a table, or a name"),
        ('gearbox = ["g"]\n', "joints.A.gearbox", "a table, or a name"),
        ('bearing = { kind = "roling" }\n', "joints.A.bearing.kind", '"rolling"'),
        ('bearing = { span = "60 mm" }\n', "joints.A.bearing.kind", '"rolling"'),
        ('bearing = { kind = "rolling" }\n', "joints.A.bearing.span", "length"),
        ('encoder = { side = "motr" }\n', "joints.A.encoder.side", '"motor"'),
        (
            'lumped = { angle = "1 arcmin", law = "norml" }\n',
            "joints.A.lumped.law",
            '"normal without limits"',
        ),
        (
            'lumped = { angle = "1 arcmin", law = [[0, 0], [1, 0.5]] }\n',
            "joints.A.lumped.law",
            "rows [value",
        ),
        (
            'encoder = { noise = "1 arcmin", noise_law = 3 }\n',
            "joints.A.encoder.noise_law",
            '"uniform"',
        ),
        (
            'link = { length = { value = "400 mm ± 50 µm", law = [[1, 0]] } }\n',
            "joints.A.link.length",
            "tolerance",
        ),
        (
            'gearbox = { backlash = "1 arcmin ± 1 arcmin (normal without limits)" }\n',
            "joints.A.gearbox.backlash",
            "tolerance",
        ),
        ('lumped = { offset_along = ["x", "w"] }\n', "joints.A.lumped.offset_along[1]", '"y"'),
        ("axis = [0, 0, 0]\n", "joints.A.axis", "not zero"),
        ("axis = [0, nan, 1]\n", "joints.A.axis", "finite"),
        ("axis = [0, inf, 1]\n", "joints.A.axis", "finite"),
        ("axis = [0, 1]\n", "joints.A.axis", "a list of 3"),
        ('axis = "q"\n', "joints.A.axis", '"-z"'),
        ('origin = { xyz = ["1 mm", "2 mm"] }\n', "joints.A.origin.xyz", "a list of 3"),
        (
            'origin = { xyz = ["1 mm", "2 mm", "3 mm", "4 mm"] }\n',
            "joints.A.origin.xyz",
            "at most 3",
        ),
        ('mass = "-1 kg"\n', "joints.A.mass", "zero or more"),
        ("mass = nan\n", "joints.A.mass", "mass"),
        ("mass = 2020-01-01\n", "joints.A.mass", "mass"),
        ("mass = true\n", "joints.A.mass", "mass"),
        (
            (
                'link = { length = "400 mm", section = { kind = "tube", outer = "10 mm", wall = '
                '"6 mm" }, material = "steel" }\n'
            ),
            "joints.A.link.section",
            "half",
        ),
        (
            'link = { length = "400 mm", section = "t", material = "stel" }\n',
            "joints.A.link.material",
            "steel",
        ),
        (
            'link = { length = "400 mm", tip = { xyz = ["1 mm", "0 mm", "0 mm"] } }\n',
            "joints.A.link",
            "one of the two",
        ),
        ('link = { length_tolerance = "50 µm" }\n', "joints.A.link", "a length or a tip"),
        ("link = 3\n", "joints.A.link", "a table"),
        (
            'bearing = { rigid = true, length = "400 mm" }\n',
            "joints.A.bearing.length",
            "one of kind, rigid",
        ),
        ("bearing = { rigid = false }\n", "joints.A.bearing.rigid", "true"),
        ('after = "A.tip"\n', "joints.A.after", "of an earlier joint"),
        ("after = 3\n", "joints.A.after", "text"),
    ],
)
def test_a_mistake_in_a_joint_is_one_problem_under_the_users_key(mistakes_in, lines, key, expected):
    """Whatever alternatives the model tried, the user hears once what belongs where they wrote
    something else.
    """
    found = mistakes_in(HEAD + '[sections.t]\nkind = "rod"\ndiameter = "9 mm"\n' + JOINT + lines)
    assert list(found) == [key]
    assert expected in found[key].expected


@pytest.mark.parametrize(
    ("text", "key", "word"),
    [
        ("", "name", "text"),
        (HEAD, "joints", "a list"),
        (HEAD + "joints = []\n", "joints", "at least 1"),
        (HEAD + "joints = 3\n", "joints", "a list of joints"),
        (HEAD + "joints = [3]\n", "joints[0]", "a table"),
        (HEAD + '[joints.A]\ngearbox = "g"\n', "joints", "sidecar"),
        (HEAD + '[[joints]]\nname = "A"\n', "joints.A.type", "revolute"),
        (HEAD + '[[joints]]\nname = "A"\ntype = "revolut"\n', "joints.A.type", "revolute"),
        (HEAD + '[[joints]]\nname = "A"\ntype = "revolute"\n', "joints.A.limits", "a list of 2"),
        (HEAD + '[[joints]]\nname = "A"\ntype = "fixed"\n', "", "at least one revolute"),
        (HEAD + JOINT.replace("-90", "100"), "joints.A.limits", "below"),
        (HEAD + JOINT.replace('"A"', '" A/b"'), 'joints." A/b".name', "without blanks"),
        (HEAD + JOINT + JOINT, "joints[1].name", "of its own"),
        (HEAD + 'gravity = "9.81 m"\n' + JOINT, "gravity", "acceleration"),
        (HEAD + "sections = 3\n" + JOINT, "sections", "named parts"),
        (HEAD + JOINT + '[tool]\nafter = "A.tap"\n', "tool.after", "NAME.tip"),
        (HEAD + JOINT + '[tool]\nafter = "base"\n', "tool.after", "at least one moving joint"),
        (HEAD + JOINT + "[gearbox.g]\nratio = 2\n", "gearbox", "gearboxes"),
        (HEAD + "[gearbx.g]\nratio = 2\n" + JOINT, "gearbx", "gearboxes"),
    ],
)
def test_a_mistake_in_the_frame_of_the_file_is_reported(mistakes_in, text, key, word):
    """Missing names, joints that are none, and unknown tables each get their own words."""
    found = mistakes_in(text)
    assert key in found
    assert word in found[key].expected


def test_a_mistake_in_a_part_of_a_joint_of_unknown_type_is_reported(mistakes_in):
    """The type of the joint and the backlash of the gearbox that it alone names are two mistakes,
    found in one reading.
    """
    found = mistakes_in(
        HEAD
        + '[gearboxes.g]\nbacklash = "1 potato"\n'
        + JOINT.replace("revolute", "revolut")
        + 'gearbox = "g"\n'
    )
    assert set(found) == {"gearboxes.g.backlash", "joints.A.type"}


def test_limits_that_do_not_rise_are_shown_as_the_file_states_them(mistakes_in):
    """Degrees stay degrees in the message."""
    found = mistakes_in(
        HEAD + '[[joints]]\nname = "A"\ntype = "revolute"\nlimits = ["90 deg", "-30 deg"]\n'
    )
    assert "90 deg" in found["joints.A.limits"].found
    assert found["joints.A.limits"].expected == "a lower limit below the upper one"


def test_a_mistake_in_a_shared_part_is_reported_once(mistakes_in):
    """Two joints that share a gearbox share its mistake, reported under the gearbox."""
    found = mistakes_in(
        HEAD
        + '[gearboxes.g]\nratio = "12 mm"\n'
        + JOINT
        + 'gearbox = "g"\n'
        + JOINT.replace('"A"', '"B"')
        + 'gearbox = "g"\n'
    )
    assert list(found) == ["gearboxes.g.ratio"]


def test_an_unused_part_is_noted():
    """A part that no joint names is probably a slip, but no mistake."""
    arm = arm_of(
        "x",
        {
            "name": "x",
            "gearboxes": {"g": {}},
            "joints": [{"name": "A", "type": "revolute", "limits": ["0 deg", "1 deg"]}],
        },
    )
    assert arm.notes == ("described and used by no joint: gearboxes.g",)


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ('name = "x\n', "column 10"),
        ('name = "x"\nname = "y"\n', "column 11"),
        ('name = "x"\n[joints\n', "column 8"),
        ("x = 1 2\n", "column 7"),
    ],
)
def test_broken_toml_says_line_and_column(mistakes_in, text, key):
    """Text that is no TOML is reported with the place where reading stopped."""
    assert list(mistakes_in(text)) == [key]


def test_a_path_that_is_no_arm_is_reported(tmp_path):
    """A missing file, a folder, and an ending that no reader knows."""
    from tests.io.conftest import mistakes

    (tmp_path / "z-arm.toml").write_text("x", encoding="utf-8")
    assert mistakes(tmp_path / "z-arn.toml")[0].nearest == "z-arm.toml"
    assert mistakes(tmp_path / "arm.tml")[0].nearest == ".toml"
    assert ".urdf" in mistakes(tmp_path / "arm")[0].expected
    (tmp_path / "folder.toml").mkdir()
    assert mistakes(tmp_path / "folder.toml")[0].found == "a folder"
    assert mistakes(tmp_path / "folder")[0].found == "no ending"
    (tmp_path / "folder").mkdir()
    assert mistakes(tmp_path / "folder")[0].found == "a folder"
    (tmp_path / "z-arm.toml").write_text('name = "x"', encoding="utf-8")
    assert "URDF only" in mistakes(tmp_path / "z-arm.toml", tmp_path / "s.toml")[0].expected


@pytest.mark.parametrize(
    "text",
    [
        'tip = "tool0"\n',
        'tip = "tool0"\n[joints.A]\ngearbox = "g"\n',
        '[joints.A]\ngearbox = "g"\n',
    ],
)
def test_a_sidecar_read_as_an_arm_is_reported_once(mistakes_in, text):
    """One message names the URDF to read instead."""
    found = mistakes_in(text)
    assert list(found) == ["joints"]
    assert found["joints"].example.endswith("arm.urdf")


@pytest.mark.parametrize(("table", "command"), [("sizing", "size"), ("sweep", "sweep")])
def test_a_request_read_as_an_arm_names_the_command_that_reads_it(mistakes_in, table, command):
    """A file with a request alone is one mistake, not a list of everything that an arm lacks."""
    found = mistakes_in(f'[{table}]\ntarget = "1 mm"\n')
    assert list(found) == [table]
    assert found[table].example.startswith(f"lostmotion {command} ARM.toml --by ")


def test_a_urdf_under_a_wrong_ending_is_reported(mistakes_in):
    """The ending decides who reads it."""
    (found,) = mistakes_in('<robot name="x"/>').values()
    assert ".urdf" in found.expected


def test_more_than_64_joints_are_one_mistake(mistakes_in):
    """However many they are, they are not examined one by one."""
    assert mistakes_in(HEAD + JOINT * 65)["joints"].expected == "at most 64"


def test_a_shared_part_is_checked_before_any_joint_names_it(mistakes_in):
    """Mistakes in parts that nobody uses yet are reported at once, each under its own table; sound
    ones are only noted.
    """
    found = mistakes_in(
        HEAD
        + JOINT
        + '[gearboxes.slide]\nbacklash = "20 µm"\n[gearboxes.g]\nstiffness = "50 N m"\n'
        '[bearings.b]\nkind = "rolling"\nspan = "5 cm"\nclearence = "1 µm"\n'
        '[sections.s]\nkind = "tube"\nouter = "10 mm"\nwall = "9 mm"\n[encoders.e]\nside = '
        '"sideways"\n'
        '[materials.m]\nyoung = "-3 GPa"\npoisson = 0.3\ndensity = "1 kg/m^3"\n',
    )
    assert set(found) == {
        "gearboxes.g.stiffness",
        "bearings.b.clearence",
        "sections.s",
        "encoders.e.side",
        "materials.m.young",
    }


def test_a_link_of_negative_length_is_refused(mistakes_in):
    """A length is a distance; the direction says where the link points."""
    found = mistakes_in(HEAD + JOINT + 'link = { length = "-400 mm" }\n')
    assert list(found) == ["joints.A.link.length"]
    assert "-400 mm" in found["joints.A.link.length"].found
    assert 'direction = "-x"' in found["joints.A.link.length"].example


def test_the_example_for_a_misspelt_key_keeps_the_name_that_was_meant(mistakes_in):
    """An empty table as the example would describe an ideal gearbox, which its author never
    meant.
    """
    found = mistakes_in(HEAD + "[gearboxes.elbow]\nratio = 2\n" + JOINT + 'gearbx = "elbow"\n')
    assert found["joints.A.gearbx"].example == 'gearbox = "elbow"'
