"""Repeatability is continuous in base tilt, axis direction and payload, for stated and assumed
friction and loads near zero.
"""

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
from lostmotion.error_model.expected_repeatability import expected_repeatability, visit_covariance
from lostmotion.error_model.pose_matrix import screws
from lostmotion.io import read
from lostmotion.mechanism.arm import STANDARD_GRAVITY, Arm
from lostmotion.mechanism.holding_torques import worst_torques_over_tilts
from lostmotion.mechanism.state import state_of
from lostmotion.mechanism.tool import Payload
from lostmotion.parts.base import Base
from lostmotion.parts.joint import FixedJoint, PrismaticJoint, RevoluteJoint
from lostmotion.propagation.iso9283.robots import with_payload_share
from tests.parts.conditions import ARCMIN, local_screws

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.spatial import Floats

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "RP near zero load",
        "tilts, axis errors and payloads from 1e-9 up, seven arms and synthetic ones: no step",
        "400 per radian, 1 000 per kilogram",
    ),
    (
        "largest load of a joint at rest",
        "20 000 random poses under every tilt",
        "7 %",
    ),
)

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
    """Return a SCARA arm, two revolute joints about the vertical and a vertical slide, all with
    play and without stated friction.
    """
    joints = [
        RevoluteJoint(
            name="A",
            limits=(-2, 2),
            gearbox=LOOSE,
            bearing=PAIR,
            mass=3.0,
            link={"length": 0.4, "mass": 5.0},
        ),
        RevoluteJoint(
            name="B",
            limits=(-2, 2),
            gearbox=LOOSE,
            bearing=BALLS,
            mass=2.0,
            link={"length": 0.3, "mass": 2.0},
        ),
        PrismaticJoint(
            name="Z",
            limits=(0, 0.2),
            gearbox={"backlash": "20 µm"},
            bearing={**PAIR, "axial_play": "0 µm"},
            mass=0.5,
        ),
    ]
    return Arm(name="scara", joints=joints, **fields)


def weightless(**fields: object) -> Arm:
    """Return an elbow arm whose file states no mass and whose last axis passes through the tool
    point.
    """
    joints = [
        RevoluteJoint(
            name="A", limits=(-2, 2), axis="-y", gearbox=LOOSE, bearing=BALLS, link={"length": 0.4}
        ),
        RevoluteJoint(
            name="B", limits=(-2, 2), axis="-y", gearbox=LOOSE, bearing=PAIR, link={"length": 0.3}
        ),
        FixedJoint(name="flange"),
        RevoluteJoint(
            name="roll", limits=(-3, 3), axis="x", gearbox=LOOSE, link={"length": 0.1, "mass": 0.0}
        ),
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
# Slopes per radian and per kilogram: a tilt of 0.01 or 0.02 rad overcomes friction of 1 or 2 % of
# the load, and 2 g overcome the friction of 2 g.
PER_RADIAN, PER_KILOGRAM = 400.0, 1000.0
SMALL = np.array([0.0, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3])


def poses(arm: Arm) -> Floats:
    """Return twelve poses (pose, joint), the middle of all ranges first."""
    low, high = arm.limits.T
    return low + (high - low) * np.vstack(
        [np.full(len(low), 0.5), np.random.default_rng(3).random((11, len(low)))]
    )


def repeatability(arm: Arm, q: Floats) -> Floats:
    """Return RP_l of many visits (pose,), m, without sampling."""
    return expected_repeatability(visit_covariance(screws(state_of(arm, q))))[0]


def from_one_side(arm: Arm, q: Floats) -> Floats:
    """Return the distance (pose x axis,), m, between the tool positions after upward and after
    downward last motions of all joints.
    """
    return (
        screws(state_of(arm, q), approach=1.0).bias[:, 3:]
        - screws(state_of(arm, q), approach=-1.0).bias[:, 3:]
    ).ravel()


def smooth(
    sizes: Floats,
    of: Callable[[Arm, Floats], Floats],
    arm: Arm,
    changed: Callable[[float], Arm],
    slope: float,
) -> None:
    """Assert that a figure changes by at most `slope` times its value with all plays open, per unit
    of the changed quantity.
    """
    q = poses(arm)
    values = np.array([of(changed(float(size)), q) for size in sizes])
    steps, open_play = (
        np.abs(np.diff(values, axis=0)),
        np.abs(of(arm.model_copy(update={"gravity": 0.0, "payload": Payload()}), q)).max(),
    )
    assert (
        steps <= slope * open_play * np.diff(sizes)[:, None] + 1e-9 * np.abs(values).max()
    ).all()


@every_arm
def test_repeatability_is_continuous_in_the_tilt_of_the_base(make):
    """RP and the resting positions of plays change at every pose in proportion to the base tilt,
    without a step.
    """
    arm = make()
    base = arm.base

    @functools.cache
    def tilted(tilt: float) -> Arm:
        return arm.model_copy(
            update={
                "base": Base(roll=base.roll.nominal + tilt, pitch=base.pitch.nominal + tilt / 2)
            }
        )

    smooth(SMALL, repeatability, arm, tilted, PER_RADIAN)
    smooth(SMALL, from_one_side, arm, tilted, PER_RADIAN)


@every_arm
def test_repeatability_is_continuous_in_the_direction_of_an_axis(make):
    """RP changes in proportion to a rotation of a joint's origin, down to the rounding error of pi
    in a file.
    """
    arm = make()

    def turned(number: int, by: float) -> Arm:
        joints = list(arm.joints)
        roll, pitch, yaw = joints[number].origin.rpy
        joints[number] = joints[number].model_copy(
            update={
                "origin": joints[number].origin.model_copy(
                    update={"rpy": (roll + by, pitch - by, yaw)}
                )
            }
        )
        return arm.model_copy(update={"joints": tuple(joints)})

    for number in range(len(arm.joints)):
        smooth(SMALL[::2], repeatability, arm, functools.partial(turned, number), PER_RADIAN)


@every_arm
def test_repeatability_is_continuous_in_a_small_payload(make):
    """RP changes in proportion to a payload from zero to ten grams that is off every axis."""
    arm = make()
    payload = Payload(centre_of_mass=(0.02, 0.03, 0.01))

    def holding(mass: float) -> Arm:
        return arm.model_copy(update={"payload": payload.model_copy(update={"mass": mass})})

    smooth(np.array([*SMALL, 2e-3, 5e-3, 1e-2]), repeatability, arm, holding, PER_KILOGRAM)


@given(
    axes=st.lists(st.sampled_from(["x", "y", "z", "-y"]), min_size=1, max_size=4),
    masses=st.lists(st.sampled_from([0.0, 1e-6, 0.1, 5.0]), min_size=4, max_size=4),
    exponent=st.floats(-7, -2),
    rated=st.sampled_from([None, 20.0]),
    payload=st.sampled_from([0.0, 1e-6, 1.0]),
)
@settings(deadline=None, max_examples=40)
def test_repeatability_of_a_random_arm_is_continuous_in_tilt(
    axes, masses, exponent, rated, payload
):
    """The RP of an arm with any axes and masses, with or without a rated torque, changes in
    proportion to a small base tilt.
    """
    gearbox = {**LOOSE, "rated_torque": rated} if rated else LOOSE
    joints = [
        RevoluteJoint(
            name=f"J{k}",
            limits=(-2, 2),
            axis=axis,
            gearbox=gearbox,
            bearing=PAIR,
            link={"length": 0.3, "mass": mass},
        )
        for k, (axis, mass) in enumerate(zip(axes, masses, strict=False))
    ]
    arm = Arm(
        name="any",
        joints=joints,
        payload={"mass": payload, "centre_of_mass": (0.05, 0.02, 0.01)},
        tool={"frame": {"xyz": (0.1, 0, 0)}},
    )
    by = 10**exponent
    at_most = max(
        PER_RADIAN,
        200
        * max(holding.load for holding in map(arm.holding, range(len(joints))))
        / (rated or math.inf),
    )
    smooth(
        np.array([0.0, by, 2 * by]),
        repeatability,
        arm,
        lambda roll: arm.model_copy(update={"base": Base(roll=roll)}),
        at_most,
    )


def test_six_digits_of_pi_in_a_file_leave_repeatability_unchanged(tmp_path):
    """A base axis tilted by a microradian, the rounding error of pi in the file, has the sampled RP
    of a vertical axis.
    """
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
        (tmp_path / "r.toml").write_text(
            '[joints.turn]\ngearbox = { backlash = "10 arcmin" }\n', encoding="utf-8"
        )
        answer = study(read(tmp_path / "r.urdf"), poses=64, robots=64, visits=30, seed=1)
        found.append(answer.sampled.robot_means[:, :, 2].mean())
    assert found[0] > 0.5e-3
    assert found[1] == pytest.approx(found[0], rel=1e-3)


@pytest.mark.parametrize("name", ["scara", "weightless", "one loose joint"])
def test_no_interval_of_a_length_on_a_sheet_ends_below_zero(name):
    """Intervals of errors, AP and RP of few robots and poses end at zero or above; those of the
    gain from a remedy may end below.
    """
    arm = ARMS[name]() if name in ARMS else one_loose_joint(friction_torque=0.0)
    sheets = [
        study(arm, poses=8, robots=2, visits=4, seed=2).sheet,
        study(arm, poses=8, seed=2, method="analytic").sheet,
    ]
    figures = [
        (section.key, row.label, figure)
        for sheet in sheets
        for section in sheet.sections
        for row in section.rows
        for figure in row.cells
    ]
    lengths = [
        each
        for each in figures
        if each[2].unit in {"m", "mm", "µm", "nm"} and "paired samples" not in each[2].samples
    ]
    assert sum(each[2].low >= 0 for each in lengths) > 5
    assert not [each for each in lengths if each[2].low < 0]


def one_loose_joint(**gearbox: object) -> Arm:
    """Return an elbow arm with this gearbox, whose gravity torque passes zero within its range."""
    joints = [
        RevoluteJoint(
            name="A",
            limits=(-0.2, 3.0),
            axis="-y",
            gearbox={**LOOSE, **gearbox},
            link={"length": 0.5, "mass": 2.0},
        ),
        RevoluteJoint(
            name="turn",
            limits=(-3.0, 3.0),
            axis="z",
            gearbox={**LOOSE, **gearbox},
            link={"length": 0.1, "mass": 1.0},
        ),
    ]
    return Arm(name="elbow", joints=joints)


def test_the_largest_load_of_a_joint_is_that_of_random_poses_under_every_tilt():
    """The largest load of a joint is that of 20 000 random poses under every tilt, within the 7 %
    by which these miss the worst pose.
    """
    for make in (
        lambda: scara(payload={"mass": 2.0, "force": (0, 0, 30.0)}),
        ARMS["z-arm.toml"],
        ARMS["ur5e.urdf"],
    ):
        arm = make()
        low, high = arm.limits.T
        q = low + (high - low) * np.random.default_rng(1).random((20_000, len(low)))
        numbers = [k for k, joint in enumerate(arm.joints) if not isinstance(joint, FixedJoint)]
        for number, worst in zip(
            numbers, worst_torques_over_tilts(state_of(arm, q)).max(axis=0), strict=True
        ):
            found = arm.holding(number).load
            assert 0.93 * worst < found < 1.005 * max(worst, 0.1 * STANDARD_GRAVITY * 2)


def test_friction_without_a_stated_value_is_assumed_and_reported():
    """Friction without a stated value is assumed as 1 % of the rated torque, else as 2 % of the
    joint's largest load, and reported.
    """
    lever, grams = 0.5, 4.0
    holds = lever * grams * STANDARD_GRAVITY

    def arm(**gearbox: object) -> Arm:
        joint = RevoluteJoint(
            name="A",
            limits=(-2, 2),
            gearbox={**LOOSE, **gearbox},
            bearing=PAIR,
            link={"length": lever},
        )
        return Arm(name="one", joints=[joint], payload={"mass": grams})

    of_axis = arm().assumed_friction
    assert of_axis["A", "gearbox"].load.nominal == pytest.approx(0.02 * holds)
    assert of_axis["A", "bearing"].load.nominal == pytest.approx(
        0.02 * (grams * STANDARD_GRAVITY / 2 + holds / 0.06)
    )
    assert arm(rated_torque="80 N m").assumed_friction[
        "A", "gearbox"
    ].load.nominal == pytest.approx(0.8)
    assert ("A", "gearbox") not in arm(friction_torque="0 N m").assumed_friction
    (_, gearbox, bearing) = arm().remarks
    assert gearbox.startswith("friction of the gearbox of A: not stated, assumed 2 %")
    assert "(0.392 N m)" in gearbox
    assert bearing.startswith("friction of the bearing of A: not stated, assumed 2 %")
    # At a tilt whose load equals this friction, the play stays open in half of the robots.
    tilted = arm().model_copy(update={"base": Base(pitch=0.02)})
    screw = next(
        screw
        for of, screw in local_screws(tilted, [math.pi / 2])
        if of.name == "joints.A.gearbox.backlash"
    )
    assert np.abs(screw).max() == pytest.approx(ARCMIN / 2, rel=1e-3)


def test_an_arm_without_mass_has_assumed_friction():
    """Every joint of an arm without mass has the assumed friction of at least 0.1 kg at its
    reach.
    """
    arm = weightless()
    reach = math.hypot(0.8, 0.1)
    loads = [arm.holding(k).load for k in (0, 1, 3)]
    assert loads[0] == pytest.approx(0.1 * STANDARD_GRAVITY * reach, rel=0.03)
    assert loads[1] == loads[2] == loads[0]


def test_a_lighter_payload_leaves_the_assumed_friction_unchanged():
    """At a tenth of the payload, as in ISO 9283, the drives have the friction that was assumed for
    the full payload.
    """
    arm = scara(payload={"mass": 10.0})
    light = with_payload_share(arm, 0.1)
    assert light.payload.mass == 1.0
    assert light.assumed_friction == arm.assumed_friction
    assert (
        arm.model_copy(update={"payload": light.payload}).assumed_friction != arm.assumed_friction
    )
