"""A gearbox or a bearing by itself: from a file of its own, or out of an arm."""

from __future__ import annotations

import pytest

import lostmotion
from lostmotion import InputError
from lostmotion.io.part_file import read_bearing, read_gearbox
from tests.io.conftest import EXAMPLES

PAIR = '[bearing]\nkind = "rolling"\nclearance = "40 µm ± 20 µm"\nspan = "50 mm"\n'


@pytest.fixture
def file(tmp_path):
    """Write a file and return its path."""

    def write(text, name="shoulder.toml"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_a_part_alone_is_the_part_in_an_arm(file):
    """The same keys give the same part, whether it stands alone or on a joint."""
    found = read_bearing(file(PAIR))
    arm = lostmotion.read(
        file(
            'name = "arm"\n[[joints]]\nname = "A"\ntype = "revolute"\nlimits = ["0 deg", "1 '
            f'deg"]\n{PAIR.replace("[", "[joints.")}'
        )
    )
    assert found.part == arm.joints[0].bearing
    assert found.name == "shoulder"
    assert read_bearing(file('name = "wrist"\n' + PAIR)).name == "wrist"


def test_a_reducer_of_the_catalogue_by_name_and_in_a_table(file):
    """A maker's name is enough; what is stated goes before it, and the catalogue's note comes
    along.
    """
    named, stated = (
        read_gearbox(file('gearbox = "RV-40E-121"')),
        read_gearbox(file('[gearbox]\ncatalogue = "RV-40E-121"\nbacklash = "0.4 arcmin"')),
    )
    assert named.part.ratio == stated.part.ratio == 121
    assert named.part.stiffness == stated.part.stiffness
    assert stated.part.backlash.nominal == pytest.approx(0.4 / 60 * 3.14159265 / 180)
    assert any("RV-40E" in note for note in named.notes)


def test_a_drive_in_lengths_and_forces(file):
    """A ball screw by itself is read as what a sliding joint has."""
    found = read_gearbox(file('[gearbox]\nbacklash = "10 µm"\nstiffness = "200 N/µm"'))
    assert found.part.backlash.nominal == pytest.approx(1e-5)


def test_a_part_of_an_arm():
    """Out of an arm, by the joint's name; native or URDF."""
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    joint = next(joint for joint in arm.moving if joint.gearbox is not None)
    assert read_gearbox(EXAMPLES / "z-arm.toml", joint.name).part == joint.gearbox
    assert read_gearbox(EXAMPLES / "ur5e.urdf", "shoulder_pan_joint").part is not None


@pytest.mark.parametrize(
    ("text", "joint", "key", "said"),
    [
        (PAIR, "A", "joint", "no joints"),
        ('[gearbox]\nbacklash = "1 arcmin"', None, "bearing", "lostmotion gear"),
        ('name = "x"', None, "bearing", "no bearing"),
        ('bearing = "6209"', None, "bearing", "a table"),
        (PAIR + 'spam = "1 mm"\n', None, "bearing.spam", "unknown key"),
        (PAIR.replace('"50 mm"', '"50 deg"'), None, "bearing.span", "not a unit of length"),
        (PAIR.replace("rolling", "roling"), None, "bearing.kind", "rolling"),
        ('nmae = "x"\n' + PAIR, None, "nmae", "did you mean 'name'"),
        ("notes = 3\n" + PAIR, None, "notes", "list"),
        (f'name = "{"x" * 81}"\n' + PAIR, None, "name", "80"),
        ("bearing = [[[[[[[[[[[[[[[[[[[[1]]]]]]]]]]]]]]]]]]]]", None, "", "nested"),
    ],
)
def test_mistakes_stand_under_the_users_own_keys(file, text, joint, key, said):
    """Whatever is wrong is one message with the file, the key as written, and what belongs
    there.
    """
    with pytest.raises(InputError) as refused:
        read_bearing(file(text), joint)
    problems = refused.value.problems
    assert problems[0].key == key
    assert said in str(refused.value)
    assert "joints" not in problems[0].key
    assert problems[0].example or key == "joint"


def test_all_mistakes_at_once(file):
    """A wrong key, a wrong unit and a wrong top-level key are reported at once."""
    with pytest.raises(InputError) as refused:
        read_bearing(
            file('colour = "red"\n' + PAIR.replace("span", "spam").replace("± 20 µm", "± 20 deg"))
        )
    assert {problem.key for problem in refused.value.problems} == {
        "colour",
        "bearing.spam",
        "bearing.span",
        "bearing.clearance",
    }


def test_an_unknown_reducer_names_the_nearest(file):
    """A misspelt maker's name is reported with the most similar name."""
    with pytest.raises(InputError, match="RV-40E") as refused:
        read_gearbox(file('gearbox = "RV-41E-121"'))
    assert refused.value.problems[0].key == "gearbox.catalogue"


def test_an_arm_without_a_joint_lists_its_joints():
    """An arm without a joint is answered with the names of its joints."""
    with pytest.raises(InputError, match="joint") as refused:
        read_gearbox(EXAMPLES / "z-arm.toml")
    arm = lostmotion.read(EXAMPLES / "z-arm.toml")
    assert all(
        joint.name in str(refused.value) for joint in arm.moving if joint.gearbox is not None
    )
    with pytest.raises(InputError, match="one of its joints"):
        read_gearbox(EXAMPLES / "z-arm.toml", "nobody")


def test_another_file_is_refused(tmp_path):
    """A folder, a picture or nothing at all is refused with what is read."""
    for name in ("part.png", "missing.toml", "part"):
        with pytest.raises(InputError):
            read_bearing(tmp_path / name)


def test_a_gear_file_has_materials_of_its_own(file):
    """[materials] beside [gearbox]: the drawing names them, their mistakes stand under their key,
    and a bearing's file takes none.
    """
    drawing = (
        '[gearbox]\nkind = "cycloidal"\nrated_torque = "4 N m"\npins = 16\nring_radius = "34 '
        'mm"\npin_radius = "3 mm"\neccentricity = "1.2 mm"\n'
        'width = "8 mm"\ndisc_material = "onyx"\n[materials.onyx]\nyoung = "1.4 GPa"\npoisson '
        '= 0.36\ndensity = "1200 kg/m^3"\nscatter = "10 %"\n'
    )
    assert read_gearbox(file(drawing)).part.disc_material.young == pytest.approx(1.4e9)
    with pytest.raises(InputError) as refused:
        read_gearbox(file(drawing.replace("1.4 GPa", "1.4 mm")))
    assert {problem.key for problem in refused.value.problems} == {"materials.onyx.young"}
    with pytest.raises(InputError, match="unknown key"):
        read_bearing(file(PAIR + "[materials.onyx]\nyoung = 1\n"))


def test_a_drive_of_a_slide_is_refused_by_its_own_mistakes(tmp_path):
    """A belt of a sliding joint with one wrong unit has one mistake: it is not read as a belt of a
    turning joint.
    """
    path = tmp_path / "belt.toml"
    path.write_text(
        (
            '[gearbox]\nkind = "belt"\nbelt_stiffness = "450 mm"\nbelt_length = "3 m"\nstart = '
            '"0.2 m"\nbacklash = "20 µm"\n'
        ),
        encoding="utf-8",
    )
    with pytest.raises(InputError) as refused:
        read_gearbox(path)
    assert [problem.key for problem in refused.value.problems] == ["gearbox.belt_stiffness"]


@pytest.mark.parametrize("form", ["ring pins", "planet pins"])
def test_a_difference_of_two_teeth_is_named_as_not_modelled(file, form):
    """24 pins and a disc of 22 lobes are a drive that exists: the message says what the number of
    lobes follows from.
    """
    sizes = (
        'pins = 24\nlobes = 22\nring_radius = "60 mm"\npin_radius = "4 mm"\neccentricity = "1.5 '
        'mm"\nwidth = "12 mm"\n'
    )
    path = file(
        f'[gearbox]\nkind = "cycloidal"\nform = "{form}"\nrated_torque = "100 N m"\n{sizes}'
    )
    with pytest.raises(InputError) as refused:
        read_gearbox(path)
    (problem,) = refused.value.problems
    assert problem.key == "gearbox.lobes"
    assert "N - 1 lobes" in problem.expected
    assert "not modelled" in problem.expected
