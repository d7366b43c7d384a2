"""Chains of links against the direct stiffness method: an assembly of 12 x 12 Timoshenko elements
that knows of no chains, twists or compliances.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError

from lostmotion.error_model.pose_matrix import screws
from lostmotion.laws.cross_sections import SectionValues
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.state import state_of
from lostmotion.parts.joint import FixedJoint, RevoluteJoint

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "links in a chain",
        "direct stiffness assembly of Timoshenko elements, 3 to 10 links in space",
        "1e-8",
        "laws/beam.py",
    ),
)

YOUNG, NU, DENSITY = 70e9, 0.33, 2700.0
SHEAR = YOUNG / (2 * (1 + NU))


def element(length: float, s: SectionValues) -> np.ndarray:
    """Stiffness (12, 12) of a Timoshenko element on ux uy uz rx ry rz of both ends, after J.
    Przemieniecki, Theory of Matrix Structural Analysis.
    """
    k = np.zeros((12, 12))

    def put(rows: tuple[int, ...], block: np.ndarray) -> None:
        k[np.ix_(rows, rows)] += block

    put((0, 6), YOUNG * s.area / length * np.array([[1, -1], [-1, 1]]))
    put((3, 9), SHEAR * s.torsion / length * np.array([[1, -1], [-1, 1]]))
    for rows, bend, factor, sign in (
        ((1, 5, 7, 11), YOUNG * s.i_z, s.shear_y, 1.0),
        ((2, 4, 8, 10), YOUNG * s.i_y, s.shear_z, -1.0),
    ):
        phi = 12 * bend / (factor * SHEAR * s.area * length**2)
        a, b = 6 * length * sign, length**2
        block = [
            [12, a, -12, a],
            [a, (4 + phi) * b, -a, (2 - phi) * b],
            [-12, -a, 12, -a],
            [a, (2 - phi) * b, -a, (4 + phi) * b],
        ]
        put(rows, bend / (length**3 * (1 + phi)) * np.array(block))
    return k


def spread_load(length: float, load: np.ndarray) -> np.ndarray:
    """Forces and moments (12,) at both ends that stand for a uniform load (3,) per length along an
    element, in its axes.
    """
    force, moment = load * length / 2, np.cross([1, 0, 0], load) * length**2 / 12
    return np.concatenate([force, moment, force, -moment])


def random_arm(rng: np.random.Generator, links: int) -> Arm:
    """Draw an arm of links in all directions, with tubes, boxes, I-sections and bars that stand
    anyhow; every other joint is welded.
    """
    joints: list[RevoluteJoint | FixedJoint] = []
    for k in range(links):
        kinds = (
            {"kind": "tube", "outer": rng.uniform(0.05, 0.1), "wall": rng.uniform(0.002, 0.008)},
            {
                "kind": "box",
                "width": rng.uniform(0.04, 0.08),
                "height": rng.uniform(0.05, 0.1),
                "wall": 0.004,
            },
            {
                "kind": "I",
                "width": 0.05,
                "height": rng.uniform(0.05, 0.1),
                "web": 0.005,
                "flange": 0.006,
            },
            {
                "kind": "rectangle",
                "width": rng.uniform(0.01, 0.05),
                "height": rng.uniform(0.02, 0.08),
            },
        )
        fields = {
            "name": f"J{k}",
            "mass": rng.uniform(0, 5),
            "link": {
                "tip": {"xyz": rng.normal(size=3) * 0.3, "rpy": rng.uniform(-3, 3, 3)},
                "section": kinds[rng.integers(4)],
                "material": {"young": YOUNG, "poisson": NU, "density": DENSITY},
                "up": tuple(rng.normal(size=3)),
            },
        }
        joints.append(
            RevoluteJoint(limits=(-3, 3), axis="y", **fields)
            if k % 2 == 0
            else FixedJoint(**fields)
        )
    payload = {"mass": 3.0, "force": rng.normal(size=3) * 100, "moment": rng.normal(size=3) * 30}
    return Arm(
        name="frame",
        joints=joints,
        payload=payload,
        base={"roll": rng.uniform(-1, 1), "pitch": rng.uniform(-1, 1)},
    )


def by_direct_stiffness(arm: Arm, q: np.ndarray) -> np.ndarray:
    """Turn and shift (6,) of the tool, in the base's axes."""
    at = state_of(arm, q).frames[:, 0]
    nodes = len(arm.joints) + 1
    stiff, load = np.zeros((6 * nodes, 6 * nodes)), np.zeros(6 * nodes)
    for k, joint in enumerate(arm.joints):
        link, here = joint.link, at[3 * k + 2][:3, :3]
        axis = joint.twist[:3] if isinstance(joint, RevoluteJoint) else np.zeros(3)
        turn = np.kron(np.eye(4), (here @ link.beam_axes(axis)).T)
        values = link.section.values(NU)
        rows = slice(6 * k, 6 * k + 12)
        stiff[rows, rows] += turn.T @ element(link.reach, values) @ turn
        weight = here @ link.beam_axes(axis)
        load[rows] += turn.T @ spread_load(
            link.reach, weight.T @ arm.gravity_in_base * values.area * DENSITY
        )
        load[6 * k : 6 * k + 3] += (joint.mass or 0.0) * arm.gravity_in_base
    tool = at[-1][:3, :3]
    load[-6:-3] += arm.payload.mass * arm.gravity_in_base + tool @ np.array(arm.payload.force)
    load[-3:] += tool @ np.array(arm.payload.moment)
    moved = np.linalg.solve(stiff[6:, 6:], load[6:])
    return np.concatenate([moved[-3:], moved[-6:-3]])


@pytest.mark.parametrize("links", range(3, 11))
def test_a_chain_of_links_is_a_frame(links: int):
    """Three to ten links in space, joints locked, under own weight, joint masses, payload, force
    and moment: the tool goes where the frame's does.
    """
    rng = np.random.default_rng(links)
    arm = random_arm(rng, links)
    q = rng.uniform(-3, 3, (1, len(arm.moving)))
    expected = by_direct_stiffness(arm, q)
    found = screws(state_of(arm, q)).bias[0]
    np.testing.assert_allclose(
        found[:3], expected[:3], rtol=0, atol=1e-8 * np.linalg.norm(expected[:3])
    )
    np.testing.assert_allclose(
        found[3:], expected[3:], rtol=0, atol=1e-8 * np.linalg.norm(expected[3:])
    )


def test_the_frame_itself_bends_as_a_cantilever():
    """The assembly alone, one element: F l^3/(3 E I) + F l/(k G A), and w l^4/(8 E I) + w l^2/(2 k
    G A).
    """
    s, length = SectionValues(5e-4, 2e-7, 1e-7, 2e-7, 0.5, 0.6), 0.4
    k = element(length, s)[6:, 6:]
    force = np.linalg.solve(k, [0, 0, 1.0, 0, 0, 0])
    assert force[2] == pytest.approx(
        length**3 / (3 * YOUNG * 2e-7) + length / (0.6 * SHEAR * 5e-4), rel=1e-12
    )
    assert force[4] == pytest.approx(-(length**2) / (2 * YOUNG * 2e-7), rel=1e-12)
    spread = np.linalg.solve(k, spread_load(length, np.array([0, 1.0, 0]))[6:])
    assert spread[1] == pytest.approx(
        length**4 / (8 * YOUNG * 1e-7) + length**2 / (2 * 0.5 * SHEAR * 5e-4), rel=1e-12
    )
    assert spread[5] == pytest.approx(length**3 / (6 * YOUNG * 1e-7), rel=1e-12)


def test_a_direction_beyond_every_float_is_refused():
    """A direction whose length no float holds is refused in words, without a warning of the
    arithmetic.
    """
    for direction in (
        (1e200, 1e200, 0.0),
        (math.nan, 0.0, 1.0),
        (math.inf, 0.0, 0.0),
        (0.0, 0.0, 0.0),
    ):
        with pytest.raises(ValidationError):
            RevoluteJoint(name="A", limits=(-1.0, 1.0), axis=direction)
