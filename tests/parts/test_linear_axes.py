"""Error motions of linear axes and their drives: each against its closed form at the tool, and the
sum of all against simulated robots.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError

import lostmotion
from lostmotion import Arm
from lostmotion.error_model.pose_matrix import screws
from lostmotion.error_model.provenance import states
from lostmotion.mechanism.state import state_of
from lostmotion.parts.guideway import Guideway
from lostmotion.parts.joint import PrismaticJoint, RevoluteJoint
from lostmotion.parts.term import Motion
from lostmotion.propagation.montecarlo import kernel
from lostmotion.units import Toleranced
from tests.parts.conditions import SLIDE_Z, condition, drawn, terms_at

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "linear axes: straightness, pitch, yaw, roll, squareness, lead and scale error",
        (
            "closed forms at the tool at nine positions; the mean square of 4 000 simulated axes "
            "with all of them"
        ),
        "1e-9; 5 %",
    ),
)

# Variance of a normal distribution that is cut at three standard deviations: 1 - 2 x 3 phi(3) / (2
# Phi(3) - 1).
CUT = 1 - 6 * 0.00443184841193801 / 0.99730020393674
BELT = {"kind": "belt", "belt_stiffness": 450e3, "belt_length": 3.0, "start": 0.2}
SCREW = {
    "kind": "ball screw",
    "root_diameter": 0.017,
    "length": 1.2,
    "start": 0.1,
    "nut_stiffness": 2e8,
    "bearing_stiffness": 1e8,
    "lead": 0.01,
}
AT = np.linspace(0.0, 1.0, 9)


def axis(*, tool=(0.0, 0.0, 0.0), force=(0.0, 0.0, 0.0), **parts) -> Arm:
    """Return an axis along x from 0 to 1 m, without weight, whose tool stands at a distance from
    the carriage.
    """
    joint = PrismaticJoint(name="X", axis="x", limits=(0.0, 1.0), **parts)
    return Arm(name="axis", joints=[joint], tool={"frame": {"xyz": tool}}, payload={"force": force})


def mean_and_square(arm: Arm):
    """Return the mean error and the mean square of the rest, both (pose, 3) along x, y, z, at nine
    places of the axis.
    """
    merged = screws(state_of(arm, AT[:, None])).merged
    rest = merged.columns("robot", "visit", "robot x visit")
    return merged.bias[:, 3:], (merged.tool[:, 3:, rest] ** 2).sum(axis=2)


@pytest.mark.parametrize(
    ("motion", "tool", "shifted"),
    [
        # A turn about y, z or x moves a point beside the carriage across itself: Abbe's error,
        # angle x distance.
        ("pitch", (0.0, 0.0, 0.3), 0),
        ("yaw", (0.0, 0.3, 0.0), 0),
        ("roll", (0.0, 0.3, 0.0), 2),
        ("roll", (0.0, 0.0, 0.3), 1),
        ("pitch", (0.3, 0.0, 0.0), 2),
        ("yaw", (0.3, 0.0, 0.0), 1),
    ],
)
def test_an_angular_error_motion_shifts_the_tool_by_angle_times_distance(motion, tool, shifted):
    """Of a harmonic with this range, peak to peak, the mean square is range²/8; the tool is shifted
    along one direction only.
    """
    _, square = mean_and_square(axis(tool=tool, guideway={motion: 2e-4}))
    expected = np.zeros(3)
    expected[shifted] = (2e-4 * 0.3) ** 2 / 8
    np.testing.assert_allclose(square, np.tile(expected, (9, 1)), rtol=1e-9, atol=1e-25)


def test_a_straightness_is_the_range_between_the_farthest_deviations():
    """Over the travel every robot's path deviates by the stated range, peak to peak, along up and
    across it, and never along the axis.
    """
    part = Guideway(straightness=(20e-6, 10e-6), wavelength=0.5)
    found = terms_at(
        part, condition(axis=np.array([0, 0, 0, 1.0, 0, 0]), angle=np.linspace(0, 0.5, 400))
    )
    paths = drawn(found, 20, poses=400)[:, :, 3:]
    np.testing.assert_allclose(
        np.ptp(paths, axis=1), np.tile([0.0, 10e-6, 20e-6], (20, 1)), rtol=1e-3, atol=1e-18
    )


def test_a_guideway_along_z_has_a_direction_up_of_its_own():
    """Up is x unless stated, and a stated direction counts by its part across the axis."""
    for up, expected in ((None, [1.0, 0, 0]), ("y", [0, 1.0, 0]), ([0.0, 1.0, 1.0], [0, 1.0, 0])):
        found = Guideway(straightness=(1e-5, 0.0), up=up, wavelength=1.0).terms(Motion(SLIDE_Z))
        np.testing.assert_allclose(found[0].form.direction[3:], expected, atol=1e-12)


def test_squareness_moves_the_carriage_across_by_angle_times_travel():
    """An axis that is mounted out of square by an angle carries the tool across by angle x travel,
    along both directions across it.
    """
    tilt = 1e-4
    _, square = mean_and_square(axis(mounting={"tilt": tilt}))
    expected = CUT / 9 * (tilt * AT) ** 2
    np.testing.assert_allclose(
        square, np.column_stack([0 * AT, expected, expected]), rtol=1e-9, atol=1e-25
    )


@pytest.mark.parametrize(
    "parts",
    [
        {"gearbox": {"lead_error": 1.7e-4, "backlash": 0.0}},
        {"encoder": {"side": "output", "scale_error": 1.7e-4}},
    ],
)
def test_a_lead_or_scale_error_grows_with_the_travel(parts):
    """50 µm in 300 mm, ± at three standard deviations, is ±170 µm after a metre, and nothing at the
    zero of the joint.
    """
    _, square = mean_and_square(axis(**parts))
    np.testing.assert_allclose(
        square,
        np.column_stack([CUT / 9 * (1.7e-4 * AT) ** 2, 0 * AT, 0 * AT]),
        rtol=1e-9,
        atol=1e-25,
    )


def test_a_scale_on_the_carriage_corrects_the_lead_error():
    """With an encoder on the output the drive lies in the control loop; the error motions of the
    guideway do not.
    """
    parts = {
        "gearbox": {"lead_error": 1.7e-4},
        "encoder": {"side": "output", "scale_error": 1e-5},
        "guideway": {"pitch": 1e-4},
    }
    found = {term.name.removeprefix("joints.X.") for term in axis(**parts).terms}
    assert found == {"encoder.scale error", "guideway.pitch sine", "guideway.pitch cosine"}


def by_hand(drive: dict, rest: float = 0.0):
    """Return the compliance at the nine places, as a sketch of the springs says."""
    if drive["kind"] == "belt":
        near = drive["start"] + AT
        return 1 / (drive["belt_stiffness"] * (1 / near + 1 / (drive["belt_length"] - near))) + rest
    area, polar = math.pi / 4 * 0.017**2, math.pi / 32 * 0.017**4
    at = drive["start"] + AT
    one = at / (206e9 * area) + 1 / 1e8
    if drive.get("support") == "fixed-fixed":
        other = (1.2 - at) / (206e9 * area) + 1 / 1e8
        one = one * other / (one + other)
    return one + 1 / 2e8 + (0.01 / (2 * math.pi)) ** 2 * at / (79.3e9 * polar) + rest


@pytest.mark.parametrize(
    "drive",
    [BELT, SCREW, {**SCREW, "support": "fixed-fixed"}],
    ids=["belt", "fixed-free", "fixed-fixed"],
)
@pytest.mark.parametrize("rest", [0.0, 1 / 5e7])
def test_a_drive_yields_as_its_free_length_says(drive, rest):
    """A force along the axis moves the tool by the compliance at that place, tabulated to 1e-4;
    statics agrees.
    """
    stiffness = {"stiffness": 1 / rest} if rest else {}
    arm = axis(force=(100.0, 0.0, 0.0), gearbox={**drive, **stiffness})
    bias, square = mean_and_square(arm)
    np.testing.assert_allclose(
        bias, np.column_stack([100 * by_hand(drive, rest), 0 * AT, 0 * AT]), rtol=1e-4, atol=1e-18
    )
    np.testing.assert_allclose(
        state_of(arm, AT[:, None]).compliance[:, 3, 3], by_hand(drive, rest), rtol=1e-4
    )
    assert not square.any()
    assert states(arm).joints[0].states["stiffness"] == "stated"


def test_the_scatter_of_a_belt_follows_its_length_too():
    """± 30 % of the elongation, at three standard deviations, at every place."""
    _, square = mean_and_square(
        axis(force=(100.0, 0.0, 0.0), gearbox={**BELT, "stiffness_scatter": 0.3})
    )
    np.testing.assert_allclose(square[:, 0], CUT / 9 * (0.3 * 100 * by_hand(BELT)) ** 2, rtol=1e-3)


def test_a_belt_stage_turns_a_joint_with_the_stiffness_of_its_strands():
    """2 EA r²/l, in series with what is stated for the rest; the eccentricity of each pulley comes
    once per turn of it.
    """
    gearbox = {
        "kind": "belt",
        "ratio": 4,
        "belt_stiffness": 450e3,
        "strand": 0.3,
        "pulley_radius": 0.04,
        "stiffness": 1e4,
    }
    made = RevoluteJoint(
        name="A",
        limits=(-1, 1),
        gearbox={**gearbox, "pulley_error": 1e-4, "motor_pulley_error": 2e-5},
    ).gearbox
    assert made.zones == [pytest.approx(1 / (0.3 / (2 * 450e3 * 0.04**2) + 1e-4))]
    assert made.harmonics == [("pulley", 1e-4, 1.0), ("motor pulley", 2e-5, 4)]


def test_a_rack_turns_angles_of_its_gearbox_into_lengths():
    """Play is r x angle more than that of the mesh; a turn of the pinion is its circumference; 20
    teeth pass in it.
    """
    gearbox = {
        "kind": "rack",
        "pinion_radius": 0.03,
        "gearbox_stiffness": 3e4,
        "backlash": Toleranced(2e-5, 1e-5),
    }
    gearbox |= {
        "gearbox_backlash": Toleranced(1e-3, 2e-4),
        "pinion_error": 1e-5,
        "pinion_teeth": 20,
        "mesh_error": 3e-6,
    }
    arm = axis(
        force=(100.0, 0.0, 0.0), gearbox={**gearbox, "friction_torque": Toleranced(0.0, 0.0)}
    )
    made = arm.joints[0].gearbox
    assert (made.play.nominal, made.play.tolerance) == (pytest.approx(5e-5), pytest.approx(1.6e-5))
    bias, _ = mean_and_square(arm)
    np.testing.assert_allclose(bias[:, 0], 100 * 0.03**2 / 3e4 + 2.5e-5, rtol=1e-9)
    place = {
        "axis": np.array([0, 0, 0, 1.0, 0, 0]),
        "angle": np.linspace(0, 2 * math.pi * 0.03, 64, endpoint=False),
    }
    waves = [
        term for term in terms_at(made, condition(**place)) if term.term.cause in ("pinion", "mesh")
    ]
    lines = np.abs(np.fft.rfft(drawn(waves, 5, poses=64)[:, :, 3], axis=1)) / 32
    np.testing.assert_allclose(lines[:, [1, 20]], np.tile([1e-5, 3e-6], (5, 1)), rtol=1e-9)


def test_simulated_axes_agree_with_the_sum_of_the_closed_forms():
    """Guideway, squareness, lead and belt at once: the mean square of 4 000 robots is that of the
    closed forms, within 5 %.
    """
    tool, force = np.array([0.05, 0.2, 0.3]), 50.0
    parts = {
        "guideway": {"straightness": (30e-6, 20e-6), "pitch": 2e-4, "yaw": 1e-4, "roll": 3e-4},
        "mounting": {"tilt": 2e-4},
        "gearbox": {**BELT, "lead_error": 3e-4},
    }
    study = lostmotion.study(
        axis(tool=tuple(tool), force=(force, 0.0, 0.0), **parts),
        AT[:8, None] + 0.1,
        robots=4000,
        visits=2,
    )
    at = AT[:8] + 0.1
    x, y, z = tool
    pitch, yaw, roll = (each**2 / 8 for each in (2e-4, 1e-4, 3e-4))
    near = 0.2 + at
    square = (force * near * (3.0 - near) / (3.0 * 450e3)) ** 2 + CUT / 9 * (3e-4 * at) ** 2
    square += (
        (30e-6**2 + 20e-6**2) / 8
        + pitch * (x**2 + z**2)
        + yaw * (x**2 + y**2)
        + roll * (y**2 + z**2)
    )
    # The mounting turns the whole axis about its seat: about y and z, at the distance of the tool
    # from the seat.
    square += CUT / 9 * 2e-4**2 * ((at + x) ** 2 * 2 + y**2 + z**2)
    np.testing.assert_allclose(study.sampled.per_pose[:, kernel.MEAN_SQUARE], square, rtol=0.05)


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"gearbox": {**BELT, "belt_length": 1.1}}, "the carriage reaches the drive pulley"),
        ({"gearbox": {**BELT, "belt_length": 0.1}}, "a start beyond the length of the belt"),
        ({"gearbox": {**SCREW, "length": 1.05}}, "the nut leaves the screw"),
        ({"gearbox": {**SCREW, "stiffness": [1e7, 2e7], "zone_torques": [5.0]}}, "stiffness zones"),
        ({"guideway": {"pitch": 1e-4, "up": "x"}}, "up along the axis itself"),
    ],
)
def test_an_impossible_axis_is_refused(parts, words):
    """Drives too short for the range, and directions that are none."""
    with pytest.raises(ValidationError, match=words):
        axis(**parts)


@pytest.mark.parametrize(
    "part", [{"gearbox": {"lead_error": 1e-4}}, {"encoder": {"scale_error": 1e-4}}]
)
def test_what_grows_with_a_travel_is_refused_on_a_joint_that_turns(part):
    """A turning joint has neither a lead nor a scale."""
    with pytest.raises(ValidationError, match=r"on a turning joint"):
        RevoluteJoint(name="A", limits=(-1, 1), **part)


@pytest.mark.parametrize("key", ["beam", "rail", "section", "supports"])
def test_a_rail_that_bends_between_supports_is_refused_with_the_key_that_stands_for_it(
    tmp_path, key
):
    """A bridge on two supports: nothing of it is read in silence, and the message names what is
    modelled in its place.
    """
    path = tmp_path / "bridge.toml"
    path.write_text(
        'name = "bridge"\n[[joints]]\nname = "x"\ntype = "prismatic"\naxis = "x"\nlimits = '
        '["0 mm", "600 mm"]\n'
        f'link = {{ length = "10 mm", rigid = true }}\nguideway = {{ {key} = {{ section = '
        f'"20x20", supports = "both ends" }} }}\n',
        encoding="utf-8",
    )
    with pytest.raises(lostmotion.InputError) as refused:
        lostmotion.read(path)
    (problem,) = refused.value.problems
    assert problem.key == f"joints.x.guideway.{key}"
    assert "not modelled" in problem.expected
    assert "radial_stiffness" in problem.expected
    assert problem.example.startswith("bearing = ")


@pytest.mark.parametrize(("each", "constant"), [(24, 48), (96, 192)])
def test_a_bearing_stands_for_a_rail_with_the_carriage_at_its_middle(each, constant):
    """Two bearings of 24 E I/L^3 deflect like a simply supported beam at mid-span, F L^3/(48 E I);
    of 96 E I/L^3 like one with clamped ends, 192.
    """
    young, area_moment, span = 70e9, 0.02**4 / 12, 0.6
    stiffness = young * area_moment / span**3
    bearing = {
        "kind": "rolling",
        "clearance": 0.0,
        "span": 0.15,
        "radial_stiffness": each * stiffness,
    }
    found = state_of(axis(bearing=bearing), np.array([[0.3]])).compliance[0, 5, 5]
    assert found == pytest.approx(1 / (constant * stiffness), rel=1e-9)
