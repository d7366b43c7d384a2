"""Play, friction that is stated or assumed, and loads near zero: repeatability has no step in lean, axis direction or payload."""

from __future__ import annotations

import functools
import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lostmotion import study
from lostmotion.analyses.iso9283.expected_repeatability import expected_repeatability
from lostmotion.analyses.iso9283.predicted import visit_covariance, with_payload_share
from lostmotion.error_model.pose_matrix import screws
from lostmotion.io import read
from lostmotion.mechanism.arm import STANDARD_GRAVITY, Arm
from lostmotion.mechanism.serial import worst_torques_over_tilts
from lostmotion.mechanism.tool import Payload
from lostmotion.parts.base import Base
from lostmotion.parts.joint import FixedJoint, PrismaticJoint, RevoluteJoint
from tests.parts.conditions import ARCMIN, local_screws

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.spatial import Floats

EXAMPLES = Path(__file__).parents[2] / "examples"
BALLS = {
    "kind": "ball pair",
    "bore": 0.045,
    "outside_diameter": 0.085,
    "balls": 9,
    "ball_diameter": 0.0127,
    "pitch_diameter": 0.065,
    "span": 0.12,
    "clearance": "15 µm ± 8 µm",
}
LOOSE = {"backlash": "2 arcmin"}
PAIR = {"kind": "rolling", "clearance": "20 µm", "span": "60 mm", "axial_play": "10 µm"}


def scara(**fields: object) -> Arm:
    """Return two turning joints about the vertical and a vertical slide, all with play, friction stated nowhere."""
    joints = [
        RevoluteJoint(name="A", limits=(-2, 2), gearbox=LOOSE, bearing=PAIR, mass=3.0, link={"length": 0.4, "mass": 5.0}),
        RevoluteJoint(name="B", limits=(-2, 2), gearbox=LOOSE, bearing=BALLS, mass=2.0, link={"length": 0.3, "mass": 2.0}),
        PrismaticJoint(name="Z", limits=(0, 0.2), gearbox={"backlash": "20 µm"}, bearing={**PAIR, "axial_play": "0 µm"}, mass=0.5),
    ]
    return Arm(name="scara", joints=joints, **fields)


def weightless(**fields: object) -> Arm:
    """Return an elbow arm whose file states no mass, its last axis through the tool's middle."""
    joints = [
        RevoluteJoint(name="A", limits=(-2, 2), axis="-y", gearbox=LOOSE, bearing=BALLS, link={"length": 0.4}),
        RevoluteJoint(name="B", limits=(-2, 2), axis="-y", gearbox=LOOSE, bearing=PAIR, link={"length": 0.3}),
        FixedJoint(name="flange"),
        RevoluteJoint(name="roll", limits=(-3, 3), axis="x", gearbox=LOOSE, link={"length": 0.1, "mass": 0.0}),
    ]
    return Arm(name="weightless", joints=joints, tool={"frame": {"xyz": (0, 0, 0.1)}}, **fields)


ARMS: dict[str, Callable[[], Arm]] = {
    "scara": lambda: scara(payload={"mass": 2.0}),
    "weightless": lambda: weightless(payload={"mass": 0.0}),
    "on its side": lambda: scara(payload={"mass": 2.0}, base={"pitch": "90 deg"}),
    **{
        name: lambda name=name: read(EXAMPLES / name)  # type: ignore[misc]
        for name in ("z-arm.toml", "ur5e.urdf", "arm-from-drawings.toml", "paper/z-arm-lumped.toml")
    },
}
every_arm = pytest.mark.parametrize("make", ARMS.values(), ids=ARMS)
# Per radian, per kilogram: friction of 1 or 2 % of what is held is overcome by a lean of as much, that of 2 g by 2 g.
PER_LEAN, PER_KILOGRAM = 400.0, 1000.0
SMALL = np.array([0.0, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3])


def poses(arm: Arm) -> Floats:
    """Return a dozen poses, the middle of all ranges first."""
    low, high = arm.limits.T
    return low + (high - low) * np.vstack([np.full(len(low), 0.5), np.random.default_rng(3).random((11, len(low)))])


def repeatability(arm: Arm, q: Floats) -> Floats:
    """Return RP_l of many visits (pose,), m, without sampling."""
    return expected_repeatability(visit_covariance(screws(arm, q)))[0]


def from_one_side(arm: Arm, q: Floats) -> Floats:
    """Return how far apart plays rest (pose x axis,), m, as every joint comes upwards and downwards."""
    return (screws(arm, q, approach=1.0).bias[:, 3:] - screws(arm, q, approach=-1.0).bias[:, 3:]).ravel()


def smooth(amounts: Floats, of: Callable[[Arm, Floats], Floats], arm: Arm, changed: Callable[[float], Arm], slope: float) -> None:
    """Say that a figure never changes faster than `slope` times what it is where no load closes any play."""
    q = poses(arm)
    values = np.array([of(changed(float(amount)), q) for amount in amounts])
    steps, open_play = np.abs(np.diff(values, axis=0)), np.abs(of(arm.model_copy(update={"gravity": 0.0, "payload": Payload()}), q)).max()
    assert (steps <= slope * open_play * np.diff(amounts)[:, None] + 1e-9 * np.abs(values).max()).all()


@every_arm
def test_a_base_that_leans_a_little_repeats_nearly_as_well(make):
    """From level to a lean of a milliradian RP, and where plays rest, change at every pose in proportion to the lean, never in a step."""
    arm = make()
    base = arm.base

    def leaning(lean: float) -> Arm:
        return arm.model_copy(update={"base": Base(roll=base.roll.nominal + lean, pitch=base.pitch.nominal + lean / 2)})

    smooth(SMALL, repeatability, arm, leaning, PER_LEAN)
    smooth(SMALL, from_one_side, arm, leaning, PER_LEAN)


@every_arm
def test_an_axis_written_with_fewer_digits_repeats_nearly_as_well(make):
    """A joint's seat turned by as little as three digits of pi leave changes RP in proportion."""
    arm = make()

    def turned(number: int, by: float) -> Arm:
        joints = list(arm.joints)
        roll, pitch, yaw = joints[number].origin.rpy
        joints[number] = joints[number].model_copy(update={"origin": joints[number].origin.model_copy(update={"rpy": (roll + by, pitch - by, yaw)})})
        return arm.model_copy(update={"joints": tuple(joints)})

    for number in range(len(arm.joints)):
        smooth(SMALL, repeatability, arm, functools.partial(turned, number), PER_LEAN)


@every_arm
def test_a_payload_of_nearly_nothing_changes_repeatability_by_nearly_nothing(make):
    """From no payload to ten grams, out of line with every axis, RP changes in proportion."""
    arm = make()
    payload = Payload(centre_of_mass=(0.02, 0.03, 0.01))

    def holding(mass: float) -> Arm:
        return arm.model_copy(update={"payload": payload.model_copy(update={"mass": mass})})

    smooth(np.array([*SMALL, 2e-3, 5e-3, 1e-2]), repeatability, arm, holding, PER_KILOGRAM)


@given(
    axes=st.lists(st.sampled_from(["x", "y", "z", "-y"]), min_size=1, max_size=4),
    masses=st.lists(st.sampled_from([0.0, 1e-6, 0.1, 5.0]), min_size=4, max_size=4),
    lean=st.floats(-7, -2),
    rated=st.sampled_from([None, 20.0]),
    payload=st.sampled_from([0.0, 1e-6, 1.0]),
)
@settings(deadline=None, max_examples=100)
def test_no_arm_has_a_step_in_its_repeatability(axes, masses, lean, rated, payload):
    """Arms of any axes and masses, rated or not: two tilts so close together have the same repeatability."""
    gearbox = {**LOOSE, "rated_torque": rated} if rated else LOOSE
    joints = [
        RevoluteJoint(name=f"J{k}", limits=(-2, 2), axis=axis, gearbox=gearbox, bearing=PAIR, link={"length": 0.3, "mass": mass})
        for k, (axis, mass) in enumerate(zip(axes, masses, strict=False))
    ]
    arm = Arm(name="any", joints=joints, payload={"mass": payload, "centre_of_mass": (0.05, 0.02, 0.01)}, tool={"frame": {"xyz": (0.1, 0, 0)}})
    by = 10**lean
    at_most = max(PER_LEAN, 200 * max(holding.load for holding in map(arm.holding, range(len(joints)))) / (rated or math.inf))
    smooth(np.array([0.0, by, 2 * by]), repeatability, arm, lambda roll: arm.model_copy(update={"base": Base(roll=roll)}), at_most)


def test_a_file_that_writes_pi_with_six_digits_repeats_as_well_as_one_with_all(tmp_path):
    """A base axis that leans by a millionth of a radian for want of digits: AP and RP by sampling stay as they are, where any load once closed it."""
    found = []
    for digits in ("3.141592653589793", "3.14159"):
        urdf = f"""<robot name="r"><link name="base"/>
            <link name="arm"><inertial><origin xyz="0.3 0 0"/><mass value="8"/>
            <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
            <link name="tool"/>
            <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><origin rpy="{digits} 0 0"/><axis xyz="0 0 1"/>
            <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
            <joint name="end" type="fixed"><parent link="arm"/><child link="tool"/><origin xyz="0.6 0 0"/></joint></robot>"""
        (tmp_path / "r.urdf").write_text(urdf, encoding="utf-8")
        (tmp_path / "r.toml").write_text('[joints.turn]\ngearbox = { backlash = "10 arcmin" }\n', encoding="utf-8")
        answer = study(read(tmp_path / "r.urdf"), poses=64, robots=64, visits=30, seed=1)
        found.append(answer.sampled.robot_means[:, :, 2].mean())
    assert found[0] > 0.5e-3
    assert found[1] == pytest.approx(found[0], rel=1e-3)


@pytest.mark.parametrize("name", ["scara", "weightless", "one loose joint"])
def test_no_length_on_a_sheet_has_an_interval_below_zero(name):
    """A handful of robots and poses, of which few show any play: errors, AP and RP end at zero at the least; only what a remedy gains may not."""
    arm = ARMS[name]() if name in ARMS else one_loose_joint(friction_torque=0.0)
    sheets = [study(arm, poses=8, robots=2, visits=4, seed=2).sheet, study(arm, poses=8, seed=2, method="analytic").sheet]
    figures = [(section.key, row.label, figure) for sheet in sheets for section in sheet.sections for row in section.rows for figure in row.figures]
    lengths = [each for each in figures if each[2].unit in {"m", "mm", "µm", "nm"} and "paired samples" not in each[2].samples]
    assert sum(each[2].low >= 0 for each in lengths) > 5
    assert not [each for each in lengths if each[2].low < 0]


def one_loose_joint(**gearbox: object) -> Arm:
    """Return an elbow whose friction is stated, a load going through zero within its range."""
    joints = [
        RevoluteJoint(name="A", limits=(-0.2, 3.0), axis="-y", gearbox={**LOOSE, **gearbox}, link={"length": 0.5, "mass": 2.0}),
        RevoluteJoint(name="turn", limits=(-3.0, 3.0), axis="z", gearbox={**LOOSE, **gearbox}, link={"length": 0.1, "mass": 1.0}),
    ]
    return Arm(name="elbow", joints=joints)


def test_what_a_joint_holds_is_the_most_over_poses_and_slopes():
    """As `worst_torques_over_tilts` of many random poses finds, but for the few per cent by which a few hundred poses miss the worst one."""
    for make in (lambda: scara(payload={"mass": 2.0, "force": (0, 0, 30.0)}), ARMS["z-arm.toml"], ARMS["ur5e.urdf"]):
        arm = make()
        low, high = arm.limits.T
        q = low + (high - low) * np.random.default_rng(1).random((20_000, len(low)))
        numbers = [k for k, joint in enumerate(arm.joints) if not isinstance(joint, FixedJoint)]
        for number, worst in zip(numbers, worst_torques_over_tilts(arm, q).max(axis=0), strict=True):
            found = arm.holding(number).load
            assert 0.93 * worst < found < 1.005 * max(worst, 0.1 * STANDARD_GRAVITY * 2)


def test_friction_that_nobody_states_is_assumed_and_reported():
    """1 % of what a reducer is rated for; without a rating, and for bearings, 2 % of the most that the joint holds; stated friction is not listed."""
    lever, grams = 0.5, 4.0
    holds = lever * grams * STANDARD_GRAVITY

    def arm(**gearbox: object) -> Arm:
        joint = RevoluteJoint(name="A", limits=(-2, 2), gearbox={**LOOSE, **gearbox}, bearing=PAIR, link={"length": lever})
        return Arm(name="one", joints=[joint], payload={"mass": grams})

    of_axis = arm().assumed_friction
    assert of_axis["A", "gearbox"].load.nominal == pytest.approx(0.02 * holds)
    assert of_axis["A", "bearing"].load.nominal == pytest.approx(0.02 * (grams * STANDARD_GRAVITY / 2 + holds / 0.06))
    assert arm(rated_torque="80 N m").assumed_friction["A", "gearbox"].load.nominal == pytest.approx(0.8)
    assert ("A", "gearbox") not in arm(friction_torque="0 N m").assumed_friction
    (_, gearbox, bearing) = arm().remarks
    assert gearbox.startswith("friction of the gearbox of A: not stated, assumed 2 %")
    assert "(0.392 N m)" in gearbox
    assert bearing.startswith("friction of the bearing of A: not stated, assumed 2 %")
    # Leaning by a load of just this friction, the play stays open in half of the robots.
    leaning = arm().model_copy(update={"base": Base(pitch=0.02)})
    screw = next(screw for of, screw in local_screws(leaning, [math.pi / 2]) if of.name == "joints.A.gearbox.backlash")
    assert np.abs(screw).max() == pytest.approx(ARCMIN / 2, rel=1e-3)


def test_an_arm_without_weight_has_friction_all_the_same():
    """It counts as holding a tenth of a kilogram at its reach at least, on every axis, one through the tool's middle too."""
    arm = weightless()
    reach = math.hypot(0.8, 0.1)
    loads = [arm.holding(k).load for k in (0, 1, 3)]
    assert loads[0] == pytest.approx(0.1 * STANDARD_GRAVITY * reach, rel=0.03)
    assert loads[1] == loads[2] == loads[0]


def test_a_lighter_load_leaves_the_drives_their_friction():
    """At a tenth of the payload ISO 9283's arm has the same drives, and so the friction that was assumed under the whole of it."""
    arm = scara(payload={"mass": 10.0})
    light = with_payload_share(arm, 0.1)
    assert light.payload.mass == 1.0
    assert light.assumed_friction == arm.assumed_friction
    assert arm.model_copy(update={"payload": light.payload}).assumed_friction != arm.assumed_friction
