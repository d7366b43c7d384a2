"""The wind-up of the drives under their static loads."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest

import lostmotion
from lostmotion.mechanism.state import state_of
from lostmotion.mechanism.wind_up import wind_ups

if TYPE_CHECKING:
    from collections.abc import Callable

ARCMIN = math.pi / 10800
LINK = {"length": "500 mm", "mass": "0 kg"}


def arm(*joints: dict[str, object]) -> lostmotion.Arm:
    """Return an arm of these joints with 10 kg at its tip."""
    return lostmotion.Arm.model_validate(
        {"name": "wound", "joints": joints, "payload": {"mass": "10 kg"}}
    )


def turning(name: str, **more: object) -> dict[str, object]:
    """Return a joint about a horizontal axis."""
    return {"type": "revolute", "name": name, "axis": "y", "limits": (-2, 2), "link": LINK, **more}


def drooped(wound: Callable[[float], float]) -> float:
    """Return the wind-up (arcmin) that is what the load winds up a link lowered by it (rad)."""
    found = 0.0
    for _ in range(20):
        found = wound(found * ARCMIN)
    return found


def test_a_horizontal_link_winds_its_drive_up_by_torque_over_stiffness():
    """10 kg at 1 m and 20 N m/arcmin: 98.07 N m and 4.903 arcmin, in the direction of the load, at
    the lever arm to which both links droop; a drive without a stiffness is not listed.
    """
    found = arm(
        turning("A", gearbox={"stiffness": "20 N m/arcmin"}),
        turning("B", gearbox={"backlash": "1 arcmin"}),
    )
    q = np.array([[math.pi / 2, 0.0], [0.0, 0.0]])  # the links stand upright, then lie
    torques = state_of(found, q).torques
    (wound,) = wind_ups(found, q)
    assert (wound.joint, wound.index) == ("A", int(np.abs(torques[:, 0]).argmax()))
    # the outer link droops by the inner wind-up and by half the backlash
    exact = drooped(lambda w: 98.0665 * 0.5 * (math.cos(w) + math.cos(w + ARCMIN / 2)) / 20)
    assert abs(wound.value) / ARCMIN == pytest.approx(exact, rel=1e-9)
    assert math.copysign(1, wound.value) == -math.copysign(1, torques[wound.index, 0])


def test_zones_of_stiffness_add_up():
    """50 N m in three zones with borders at 10 and 30 N m: 10/5 + 20/10 + the rest over 20, in
    arcmin, at the lever arm of the drooped link.
    """
    gearbox = {
        "stiffness": ["5 N m/arcmin", "10 N m/arcmin", "20 N m/arcmin"],
        "zone_torques": ["10 N m", "30 N m"],
    }
    found = arm(turning("A", gearbox=gearbox))
    (wound,) = wind_ups(found, np.array([[0.0]]))
    exact = drooped(lambda w: 2 + 2 + (10 * 9.80665 * 0.5 * math.cos(w) - 30) / 20)
    assert abs(wound.value) / ARCMIN == pytest.approx(exact, rel=1e-9)


def test_a_slide_shifts_by_force_over_stiffness():
    """A vertical slide with 10 kg and 100 N/µm: 0.980665 µm."""
    slide = {
        "type": "prismatic",
        "name": "Z",
        "axis": "z",
        "limits": ("0 mm", "300 mm"),
        "gearbox": {"kind": "rack", "pinion_radius": "20 mm", "stiffness": "100 N/µm"},
    }
    (wound,) = wind_ups(arm(slide), np.array([[0.1], [0.2]]))
    assert abs(wound.value) == pytest.approx(10 * 9.80665 / 1e8, rel=1e-9)


def test_the_table_of_joints_states_load_wind_up_and_bending():
    """Torque and its share of the rated one by hand, wind-up by the torque where the arm stands; a rigid link and an undescribed stiffness are
    ideal, a missing rating is not stated.
    """
    tube = {
        "length": "500 mm",
        "section": {"kind": "tube", "outer": "60 mm", "wall": "3 mm"},
        "material": {"young": "70 GPa", "poisson": 0.33, "density": "2700 kg/m^3"},
    }
    study = lostmotion.study(
        arm(
            turning(
                "A",
                gearbox={
                    "stiffness": "20 N m/arcmin",
                    "rated_torque": "200 N m",
                    "assumed": ["stiffness"],
                },
            ),
            turning("B", gearbox={"backlash": "1 arcmin"}, link=tube),
        ),
        np.array([[0.0, 0.0]]),
        8,
        2,
        threads=1,
    )
    (section,) = [section for section in study.sheet.sections if section.key == "torques"]
    first, second = ([str(figure) for figure in row.cells] for row in section.rows)
    weight = study.arm.joints[1].link.total_mass
    held = 9.80665 * (10 * 1.0 + weight * 0.75)
    settled = abs(state_of(study.arm, study.poses.q).settled().torques[0, 0])
    assert [abs(section.rows[0].cells[k].as_shown) for k in (0, 2, 3)] == pytest.approx(
        [held, held / 2, settled / 20], rel=1e-6
    )
    assert first[4] == "ideal"
    assert second[2:4] == ["not stated", "ideal"]
    assert section.rows[1].cells[4].as_shown == pytest.approx(1e6 * study.bending[0].deflection)
    assert ["; assumed: stiffness" in row.note for row in section.rows] == [True, False]
