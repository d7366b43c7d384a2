"""Quantities as arguments: text with a unit or a number in SI, the same for every function, and one
message where they are neither.
"""

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import lostmotion
from lostmotion.analyses.arguments import pose_of, poses_of, zone_of
from lostmotion.analyses.quantities import Three, amount, read_quantities, three
from lostmotion.mechanism.warm_up import WarmUp
from lostmotion.units import Quantity

EXAMPLES = Path(__file__).parents[2] / "examples"
Z_ARM = EXAMPLES / "z-arm.toml"
LENGTH = Quantity("m", "50 mm", above=0, high=100)
ANGLE = Quantity("rad", "10 deg", low=0, high=math.pi)
OF_A_MAP = ("cell", "target", "box", "clear", "floor", "at", "level")
OF_AN_ISO_SHEET = (
    "cube",
    "centre",
    "tool_rpy",
    "floor",
    "instrument",
    "warm_up",
    "warm_up_time",
    "load",
    "expansion",
)


@pytest.fixture(scope="module")
def arm():
    """Read the paper's arm once."""
    return lostmotion.read(Z_ARM)


@pytest.mark.parametrize(
    "value", ["50 mm", "5 cm", 0.05, np.float32(0.05), np.float64(0.05), "0.05 m"]
)
def test_text_and_numbers_are_the_same_amount(value):
    """A number is SI, text has its unit."""
    assert amount("cell", value, LENGTH) == pytest.approx(0.05, rel=1e-6)


@pytest.mark.parametrize(
    "value",
    [
        "50",
        "5 kg",
        "5 deg",
        "",
        "nan mm",
        "nan",
        math.nan,
        math.inf,
        -0.05,
        "-5 mm",
        0,
        "200 m",
        "1e30 m",
        True,
        None,
        [0.05],
        5j,
        "5 mm ± 1 mm",
    ],
)
def test_what_is_no_such_amount_is_refused_with_range_and_example(value):
    """Argument, what was found, what belongs there with its range, and an example that passes."""
    with pytest.raises(lostmotion.InputError) as caught:
        amount("cell", value, LENGTH)
    (problem,) = caught.value.problems
    assert problem.key == "cell"
    assert problem.expected == "length (mm, µm, m, in), above zero, at most 100 m"
    assert problem.passing == (("cell", "50 mm"),)


def test_a_refused_angle_states_its_limits_in_degrees():
    """In Python the example is an assignment."""
    with pytest.raises(lostmotion.InputError, match='tilt = "10 deg"') as caught:
        amount("tilt", "-10 deg", ANGLE)
    assert (
        caught.value.problems[0].expected
        == "angle (arcmin, arcsec, deg, mrad), zero or more, at most 180 deg"
    )


@pytest.mark.parametrize(
    "value",
    [
        (0.3, "20 cm", 0.1),
        np.array([0.3, 0.2, 0.1]),
        "300 mm, 0.2 m, 100 mm",
        "300 x 200 x 100 mm",
        "300×200×100 mm",
    ],
)
def test_three_quantities_are_a_sequence_or_one_text(value):
    """Of text, the unit may stand once at the end."""
    assert three("box", value, Three(LENGTH, "1 x 1 x 1 m")) == pytest.approx((0.3, 0.2, 0.1))


@pytest.mark.parametrize(
    "value",
    [
        (1, 2),
        5,
        "1 m, 2 m",
        "",
        "1, 2, 3",
        {"x": 1},
        "1 m, 2 kg, 3 m",
        (1, "nan", 3),
        "x" * 10_000,
        (1, None, 3),
    ],
)
def test_other_than_three_quantities_is_refused(value):
    """One message that names the argument."""
    with pytest.raises(lostmotion.InputError) as caught:
        three("box", value, Three(LENGTH, "1 x 1 x 1 m"))
    assert {problem.key for problem in caught.value.problems} == {"box"}


def test_all_mistakes_in_quantities_are_reported_at_once():
    """Each under its own name; what nobody asked for is omitted."""
    known = {"cell": LENGTH, "at": Three(LENGTH, "1 x 1 x 1 m"), "target": LENGTH}
    with pytest.raises(lostmotion.InputError) as caught:
        read_quantities({"cell": "5", "at": "1 m", "target": None, "seed": "x"}, known)
    assert [problem.key for problem in caught.value.problems] == ["cell", "at"]
    assert read_quantities({"cell": "5 mm", "target": None, "seed": 1}, known) == {"cell": 0.005}


def test_a_map_takes_every_amount_either_way(arm, monkeypatch):
    """The study receives SI, however a quantity was stated."""
    from lostmotion.analyses.workspace_map import page
    from lostmotion.maps import accuracy_map as room

    seen = []
    monkeypatch.setattr(
        room, "map_workspace", lambda _arm, wish, **_more: seen.append(wish) or SimpleNamespace()
    )
    monkeypatch.setattr(page, "AccuracyMap", SimpleNamespace)
    said = {
        "cell": "50 mm",
        "target": "0.5 mm",
        "box": ("300 mm", 0.2, "10 cm"),
        "clear": "20 cm",
        "floor": "-1 m",
        "level": "90 %",
    }
    in_si = {
        "cell": 0.05,
        "target": 0.0005,
        "box": (0.3, 0.2, 0.1),
        "clear": 0.2,
        "floor": -1.0,
        "level": 0.9,
    }
    points = [
        lostmotion.map(arm, at=at, **asked).at
        for at, asked in (("500 mm, 0, 300 mm", said), ((0.5, 0, 0.3), in_si))
    ]
    assert {*in_si, "at"} == set(OF_A_MAP)
    assert np.allclose(points[0], points[1])
    for name in in_si:
        assert getattr(seen[0], name) == pytest.approx(getattr(seen[1], name)), name


def test_an_iso_sheet_takes_every_amount_either_way(arm, monkeypatch):
    """The cube, how the tool is held, the floor and the warming reach the study in SI."""
    from lostmotion.analyses.iso9283 import result
    from lostmotion.standards import commanded_poses

    seen = []
    monkeypatch.setattr(commanded_poses, "cube_of", lambda _arm, *place: seen.append(place[:3]))
    monkeypatch.setattr(result, "answer", lambda *_, warm_up, **__: seen.append(warm_up))
    said = {
        "cube": "40 cm",
        "centre": "600, 0, 400 mm",
        "tool_rpy": ("180 deg", 0, 0),
        "floor": "-10 mm",
        "warm_up": "25 K",
    }
    in_si = {
        "cube": 0.4,
        "centre": (0.6, 0, 0.4),
        "tool_rpy": (math.pi, 0, 0),
        "floor": -0.01,
        "warm_up": 25.0,
    }
    for each in (said, in_si):
        lostmotion.iso9283(arm, **each)
    assert seen[1] == seen[3] == WarmUp(25.0)
    (centre, side), rotation, floor = seen[0]
    assert (*centre, side, floor) == pytest.approx((0.6, 0.0, 0.4, 0.4, -0.01))
    assert rotation == pytest.approx(seen[2][1])
    assert seen[2][0][0] == pytest.approx(centre)


WRONG = [
    *((lostmotion.iso9283, {name: "5 kg"}, name) for name in OF_AN_ISO_SHEET),
    *((lostmotion.map, {name: "5 kg"}, name) for name in OF_A_MAP),
    (lostmotion.target, {"error": "5 deg"}, "error"),
    (lostmotion.target, {"repeatability": 0}, "repeatability"),
    (lostmotion.target, {"error": "1 mm", "share": "5 mm"}, "share"),
    (lostmotion.production_yield, {"target": "3 N"}, "target"),
    (lostmotion.production_yield, {"target": 0.001, "share": math.nan}, "share"),
]


@pytest.mark.parametrize(("verb", "asked", "name"), WRONG)
def test_every_function_names_the_argument_that_is_wrong(arm, verb, asked, name):
    """The message names the argument, and has an example that passes."""
    with pytest.raises(lostmotion.InputError) as caught:
        verb(arm, **asked)
    *_, problem = (each for each in caught.value.problems if each.key == name)
    assert [example for example, _ in problem.passing] == [name]


def test_a_gearbox_takes_its_torque_either_way():
    """Text or N m; another dimension is refused."""
    said, number = (lostmotion.gear(Z_ARM, "A", torque=torque) for torque in ("20 N m", 20.0))
    assert said.torque == number.torque == 20
    with pytest.raises(lostmotion.InputError, match="torque"):
        lostmotion.gear(Z_ARM, "A", torque="20 N")


def test_ends_of_a_zone_and_joint_values_are_quantities(arm):
    """Text, numbers in SI, and the command line's own words name the same zone and the same
    pose.
    """
    zone = {"x": (0.2, 0.5), "z": (-0.1, 0.3)}
    for each in (
        zone,
        {"x": ("200 mm", 0.5), "z": ["-10 cm", "300 mm"]},
        "x 0.2..0.5 m, z -100..300 mm",
    ):
        assert {axis: pytest.approx(ends) for axis, ends in zone_of("zone", each).items()} == zone
    values = [math.radians(30), -0.1, 0.0, 0.2, 0.0]
    for each in (
        values,
        ["30 deg", -0.1, "0 deg", 0.2, 0.0],
        "O=30deg A=-0.1rad B=0deg C=0.2rad roll=0deg",
    ):
        np.testing.assert_allclose(pose_of("at", each, {"arm": arm}), values)
    assert pose_of("at", 3, {"arm": arm}) == pose_of("at", "3", {"arm": arm}) == 3


def test_a_study_names_the_largest_contributor_at_a_pose_in_words(arm):
    """Text, quantities and numbers of the same pose and the same zone cost the same."""
    study = lostmotion.study(arm, 8, 4, 2)
    words = (
        "O=30deg A=0deg B=0deg C=0.2rad roll=0deg",
        ["30 deg", 0, 0, 0.2, 0],
        np.array([math.radians(30), 0, 0, 0.2, 0]),
    )
    shares = [[cost.share for cost in study.costs(at=each)] for each in words]
    assert shares[0] == pytest.approx(shares[2])
    assert shares[1] == pytest.approx(shares[2])
    zones = [
        study.costs(zone=zone)[0].share for zone in ("z 0..3 m", {"z": ("0 mm", 3)}, {"z": (0, 3)})
    ]
    assert zones[0] == zones[1] == zones[2]
    with pytest.raises(lostmotion.InputError, match="at"):
        study.costs(at="O=30deg")


@pytest.mark.parametrize(
    "zone",
    [
        {"x": ("200 kg", 0.5)},
        {"x": ("0.2", "0.5 m")},
        {"x": ("0.5 m", "0.2 m")},
        {"w": ("1 m", "2 m")},
        {"x": "1 m"},
        5,
    ],
)
def test_what_is_no_zone_is_refused(zone):
    """Under its name."""
    with pytest.raises(lostmotion.InputError) as caught:
        zone_of("zone", zone)
    assert {problem.key for problem in caught.value.problems} == {"zone"}


@pytest.mark.parametrize(
    "pose",
    [["30 deg"], ["30 mm", 0, 0, 0, 0], ["30", 0, 0, 0, 0], "A=30deg", ["30 deg", None, 0, 0, 0]],
)
def test_what_is_no_pose_is_refused(arm, pose):
    """Under its name."""
    with pytest.raises(lostmotion.InputError) as caught:
        pose_of("at", pose, {"arm": arm})
    assert {problem.key for problem in caught.value.problems} == {"at"}


@pytest.mark.parametrize(
    "ask",
    [
        lambda: lostmotion.study("none.toml"),
        lambda: lostmotion.map("none.toml"),
        lambda: lostmotion.target("none.toml", error="1 mm"),
        lambda: lostmotion.size("none.toml"),
        lambda: lostmotion.statics("none.toml"),
        lambda: lostmotion.iso9283("none.toml"),
        lambda: lostmotion.sweep("none.toml"),
        lambda: lostmotion.gear("none.toml"),
        lambda: lostmotion.bearing("none.toml"),
        lambda: lostmotion.production_yield("none.toml", "1 mm"),
    ],
)
def test_every_question_takes_a_path_and_names_a_file_that_is_not_there(ask):
    """An arm and its file are asked the same way."""
    with pytest.raises(lostmotion.InputError) as caught:
        ask()
    assert (caught.value.problems[0].file, caught.value.problems[0].found) == (
        "none.toml",
        "no such file",
    )


@pytest.mark.parametrize(
    "ask", [lostmotion.read, lostmotion.gear, lostmotion.replay, lostmotion.sweep]
)
@pytest.mark.parametrize("given", [None, 5])
def test_what_is_no_path_is_refused(ask, given):
    """A message under the argument's name, and no TypeError from within."""
    with pytest.raises(lostmotion.InputError) as caught:
        ask(given)
    assert caught.value.problems[0].key in {"path", "part", "run", "arm"}


@pytest.mark.parametrize("poses", ["x", None, [[0.0]], [["a"] * 5], object(), [[math.nan] * 5]])
def test_what_are_no_poses_is_refused(arm, poses):
    """Neither a count nor joint values: one message that says which shape is expected."""
    with pytest.raises(lostmotion.InputError, match="poses"):
        poses_of("poses", poses, {"arm": arm})


@pytest.mark.parametrize(("name", "given"), [("robots", "many"), ("visits", 2.5), ("robots", None)])
def test_a_count_that_is_no_whole_number_is_refused(arm, name, given):
    """Robots and visits are counted: text, half of one or nothing gets a message that says so."""
    with pytest.raises(lostmotion.InputError, match=f"{name}[^§]*a whole number"):
        lostmotion.study(arm, 8, **{"robots": 10, "visits": 2, name: given})


def test_a_yield_needs_a_target(arm):
    """A target of nothing is refused by its name."""
    with pytest.raises(lostmotion.InputError, match="target"):
        lostmotion.production_yield(arm, None)
