"""Drives by class in arm files and sidecars, and the loads that follow from a robot file."""

from __future__ import annotations

import tomllib

import pytest

import lostmotion
from lostmotion.catalogue.drive_classes import drive_classes
from lostmotion.errors import InputError
from lostmotion.io.drive_classes import class_of_arm, with_class
from lostmotion.io.drive_loads import drive_loads
from lostmotion.io.native import arm_of
from lostmotion.io.urdf import effort_limits

ARM = """
name = "x"
payload = { mass = "1 kg" }
presets = { drives = "CLASS" }
joints = [
    { name = "A", type = "revolute", limits = ["-90 deg", "90 deg"], drive = { torque = "150 N m" }, link = { length = "60 mm" } },
    { name = "B", type = "revolute", axis = "-y", limits = ["-90 deg", "90 deg"], drive = { torque = "80 N m" }, link = { length = "400 mm" } },
    { name = "C", type = "prismatic", axis = "x", limits = ["0 mm", "90 mm"], drive = { force = "15 N" }, link = { length = "200 mm" } },
]
"""


def arm(name: str = "small strain wave", **changes: str):
    """Return the arm with drives of this class, with pieces of its text replaced."""
    text = ARM.replace("CLASS", name)
    for old, new in changes.items():
        text = text.replace(old, new)
    return arm_of("arm.toml", tomllib.loads(text))


def joint(
    name: str,
    parent: str,
    child: str,
    *,
    axis: str = "0 1 0",
    xyz: str = "0 0 0.3",
    effort: str = "",
    kind: str = "revolute",
) -> str:
    """Return a joint of a robot file."""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child '
        f'link="{child}"/><origin xyz="{xyz}"/><axis xyz="{axis}"/>'
        f'<limit lower="-1.5" upper="1.5" {effort} velocity="1"/></joint>'
    )


def robot(tmp_path, mass=("3", "3.1", "1", "0.5"), efforts=("", "", "", ""), scale: float = 1.0):
    """Write a robot file of four joints, the first upright, and return its path; lengths times
    `scale`.
    """
    links = "".join(
        f'<link name="l{k}">{_inertial(each, scale)}</link>' for k, each in enumerate(mass, 1)
    )
    joints = [
        joint(
            f"j{k}",
            f"l{k - 1}",
            f"l{k}",
            axis="0 0 1" if k == 1 else "0 1 0",
            xyz=f"0 0 {0.3 * scale}",
            effort=effort,
        )
        for k, effort in enumerate(efforts, 1)
    ]
    path = tmp_path / "robot.urdf"
    tip = (
        '<link name="tool"/><joint name="end" type="fixed"><parent link="l4"/><child '
        f'link="tool"/><origin xyz="0 0 {0.1 * scale}"/></joint>'
    )
    path.write_text(
        f'<robot name="r"><link name="l0"/>{links}{"".join(joints)}{tip}</robot>', "utf-8"
    )
    return path


def _inertial(mass: str, scale: float) -> str:
    if not mass:
        return ""
    inertia = '<inertia ixx="1e-2" ixy="0" ixz="0" iyy="1e-2" iyz="0" izz="1e-2"/>'
    return f'<inertial><origin xyz="0 0 {0.15 * scale}"/><mass value="{mass}"/>{inertia}</inertial>'


def loads_of(path):
    """Return the loads of the drives of a robot file."""
    return drive_loads(lostmotion.read(path), effort_limits(path))


@pytest.mark.parametrize("name", drive_classes())
def test_an_arm_with_another_class_is_the_arm_that_its_file_would_describe(name):
    """Changing the class in memory gives every part that changing one line of the file gives."""
    changed, read = with_class(arm(), drive_classes()[name]), arm(name)
    for one, other in zip(changed.joints, read.joints, strict=True):
        assert {key: getattr(one, key) for key in type(one).model_fields} == {
            key: getattr(other, key) for key in type(other).model_fields
        }
    assert class_of_arm(changed).name == name


def test_what_the_file_states_beside_a_class_is_kept_when_the_class_changes():
    """A stated length tolerance, mass or link of the user stays, and a stated gearbox ends the
    comparison of classes.
    """
    own = arm(
        **{
            'link = { length = "400 mm" }': (
                'link = { length = "400 mm", section = { kind = "rod", diameter = "50 mm" }, '
                'material = "steel" }'
            )
        }
    )
    changed = with_class(own, drive_classes()["hobby servo"])
    assert changed.joints[1].link.section == own.joints[1].link.section
    assert class_of_arm(own) is not None
    stated = arm(
        **{
            'drive = { torque = "80 N m" }': 'drive = { torque = "80 N m" }, gearbox = { backlash = "0.2 arcmin" }'
        }
    )
    assert stated.joints[1].gearbox.play.nominal == pytest.approx(0.2 / 60 * 0.0174533, rel=1e-5)
    assert class_of_arm(stated) is None


def test_presets_of_links_and_mountings_go_before_the_class():
    """What the file chooses for all links is more specific than the class of the drives."""
    found = arm(
        **{
            'drives = "small strain wave"': 'drives = "small strain wave", link = "printed PLA", mounting = "printed"'
        }
    )
    assert found.joints[0].link.preset.name == "printed PLA"
    assert found.joints[0].mounting.preset.name == "printed"
    assert found.joints[0].gearbox.preset.name == "small strain wave"


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("small strain wave", "strain wav", "a class of drive"),
        ('drives = "small strain wave"', 'revolute = "hobby servo"', "one for the whole arm"),
        ('torque = "80 N m"', 'torque = "80"', "torque"),
        ('torque = "80 N m"', 'rated_torque = "80 N m"', "torque, and class"),
        ('drive = { torque = "80 N m" }', "drive = 80", "a table with torque"),
        ('force = "15 N"', 'torque = "15 N m"', "force"),
    ],
)
def test_a_wrong_drive_is_refused_with_an_example(old, new, expected):
    """One message with what was found, what is expected and an example."""
    with pytest.raises(InputError) as error:
        arm(**{old: new})
    assert any(expected in problem.expected for problem in error.value.problems)
    assert all(problem.example for problem in error.value.problems)


def test_credible_effort_limits_are_the_loads_of_the_drives(tmp_path):
    """Limits above what gravity asks for, different by joint, are taken as they stand."""
    found = loads_of(
        robot(tmp_path, efforts=('effort="87"', 'effort="87"', 'effort="40"', 'effort="12.5"'))
    )
    assert list(found.loads.values()) == pytest.approx([87, 87, 40, 12.5], rel=1e-3)
    assert found.remarks == ()
    assert found.of.name == "small strain wave"


@pytest.mark.parametrize(
    "effort", ['effort="0"', 'effort="1000"', 'effort="1e6"', 'effort="0.1"', 'effort="none"', ""]
)
def test_placeholders_of_effort_are_not_used(tmp_path, effort):
    """Zero, a thousand everywhere, a million, a limit that cannot carry the arm and no number at
    all lead to the same loads as none.
    """
    none, found = loads_of(robot(tmp_path)), loads_of(robot(tmp_path, efforts=(effort,) * 4))
    assert found.loads == none.loads
    assert found.efforts == {}
    assert any("effort limits not used" in each for each in found.remarks) == (
        effort not in {"", 'effort="0"', 'effort="none"'}
    )


def test_an_upright_axis_takes_the_load_of_its_neighbour(tmp_path):
    """It holds nothing at rest, but carries the arm's inertia: its drive is that of the shoulder,
    and no wrist is below a seventh of it.
    """
    found = loads_of(robot(tmp_path))
    loads = list(found.loads.values())
    assert found.static["j1"] == pytest.approx(0, abs=1e-9)
    assert loads[0] == loads[1] == pytest.approx(2.5 * found.static["j2"])
    assert min(loads) >= max(loads) / 7 * 0.999


@pytest.mark.parametrize(
    ("mass", "word"),
    [
        (("",) * 4, "no masses"),
        (("2",) * 4, "placeholder"),
        (("1e4", "1.1e4", "1e4", "9e3"), "placeholders"),
    ],
)
def test_without_credible_masses_the_loads_follow_from_the_reach(tmp_path, mass, word):
    """No masses, the same mass everywhere, and masses in grams lead to the same loads, which grow
    with the fourth power of the size.
    """
    small, large = (loads_of(robot(tmp_path, mass, scale=scale)) for scale in (1.0, 2.0))
    assert any(word in each for each in small.remarks)
    assert large.loads["j2"] == pytest.approx(16 * small.loads["j2"], rel=1e-6)
    assert small.of.order < large.of.order


def test_a_sidecar_is_read_as_it_is_written_and_one_line_changes_all_drives(tmp_path):
    """Same file, same text; the class in it can be replaced by any other."""
    path = robot(tmp_path)
    begun = lostmotion.new(urdf=path)
    assert begun.text == lostmotion.new(urdf=path).text
    sidecar = begun.report()
    own = class_of_arm(lostmotion.read(path)).name
    for name in drive_classes():
        sidecar.write_text(begun.text.replace(f'drives = "{own}"', f'drives = "{name}"'), "utf-8")
        assert class_of_arm(lostmotion.read(path)).name == name
    assert begun.text.count("drive = { torque") == 4


@pytest.mark.parametrize("mass", ["3", "300", ""])
@pytest.mark.parametrize("roll", ["3.141592653589793", "3.1416", "0.01"])
def test_upright_axes_that_lean_by_a_rounded_angle_have_the_loads_of_upright_ones(
    tmp_path, roll, mass
):
    """A horizontal arm, hung from its base by pi or 3.1416: what leans by 0.01 rad holds a
    hundredth of its weight, but is driven as what stands.
    """

    def loads(roll):
        second = joint("j2", "l1", "l2", axis="0 0 1", xyz="0.4 0 0")
        first = joint("j1", "l0", "l1", axis="0 0 1", xyz="0 0 0.3").replace(
            "xyz=", f'rpy="{roll} 0 0" xyz=', 1
        )
        tip = (
            '<link name="tool"/><joint name="end" type="fixed"><parent link="l2"/><child '
            'link="tool"/><origin xyz="0.4 0 0"/></joint>'
        )
        links = "".join(f'<link name="l{k}">{_inertial(mass, 0.1)}</link>' for k in (1, 2))
        path = tmp_path / "hung.urdf"
        path.write_text(
            f'<robot name="r"><link name="l0"/>{links}{first}{second}{tip}</robot>', "utf-8"
        )
        return loads_of(path)

    upright, leaning = loads("0"), loads(roll)
    assert list(leaning.loads.values()) == pytest.approx(list(upright.loads.values()), rel=1e-2)
    assert leaning.loads["j1"] == pytest.approx(
        5 * 2 * float(mass) * 0.8 if mass else 100 * 0.8**4, rel=1e-3
    )
    assert leaning.remarks == upright.remarks


def test_a_sliding_axis_has_a_force_by_what_it_lifts_or_moves(tmp_path):
    """Upright it lifts the weight, level it accelerates it: both have a load above zero and a drive
    of the arm's class.
    """
    for axis in ("0 0 1", "1 0 0"):
        path = tmp_path / "slide.urdf"
        slide = joint("j1", "l0", "l1", axis=axis, kind="prismatic")
        path.write_text(
            (
                '<robot name="r"><link name="l0"/><link '
                f'name="l1">{_inertial("4", 1.0)}</link>{slide}</robot>'
            ),
            "utf-8",
        )
        found = loads_of(path)
        assert found.loads["j1"] == pytest.approx(
            2.5 * 4 * 9.80665 if axis == "0 0 1" else 5 * 4, rel=1e-3
        )
        lostmotion.new(urdf=path).report(force=True)
        path.with_suffix(".toml").write_text(lostmotion.new(urdf=path).text, "utf-8")
        assert class_of_arm(lostmotion.read(path)).name == found.of.name


def test_the_link_of_a_fixed_joint_is_that_of_its_neighbour():
    """A stand or a flange bends as the arm does: its link has the section of the joint before with
    a drive, else of the one behind.
    """
    tree = tomllib.loads(ARM.replace("CLASS", "small strain wave"))
    tree["joints"].insert(
        0, {"name": "stand", "type": "fixed", "link": {"length": "300 mm", "direction": "z"}}
    )
    tree["joints"].append({"name": "flange", "type": "fixed", "link": {"length": "50 mm"}})
    found = arm_of("arm.toml", tree)
    assert found.joints[0].link.section == found.joints[1].link.section
    assert found.joints[-1].link.section == found.joints[-2].link.section
    changed = with_class(found, drive_classes()["industrial"])
    assert (
        changed.joints[0].link.section
        == changed.joints[1].link.section
        != found.joints[0].link.section
    )
