"""Questions about an arm with branches: a weightless one changes no answer, and a heavy one loads
what carries it.
"""

from __future__ import annotations

import numpy as np
import pytest

from lostmotion.analyses.sizing.sizing import rms_error
from lostmotion.maps.radial import full_turn_axis
from lostmotion.mechanism.arm import Arm
from lostmotion.mechanism.holding_torques import static_loads
from lostmotion.mechanism.load_causes import bending
from lostmotion.mechanism.state import state_of
from lostmotion.mechanism.warm_up import WarmUp, growth
from lostmotion.propagation.iso9283.largest_cube import _column
from lostmotion.sizing.link_deflection import LinkLoads

TUBE = {
    "section": {"kind": "tube", "outer": 0.08, "wall": 0.004},
    "material": {"young": 70e9, "poisson": 0.33, "density": 2700.0},
}
GEARBOX = {"stiffness": 2e5, "ratio": 100, "backlash": "1 arcmin", "friction_torque": 1.0}


def joints() -> list[dict[str, object]]:
    """Return an arm of four turning joints, the first about the vertical without end."""
    full, half = (-np.pi, np.pi), (-2.0, 2.0)
    return [
        {
            "name": "turret",
            "type": "revolute",
            "axis": "z",
            "limits": full,
            "gearbox": GEARBOX,
            "link": {"length": 0.3, "direction": "z", "mass": 5.0},
        },
        {
            "name": "shoulder",
            "type": "revolute",
            "axis": "y",
            "limits": half,
            "gearbox": GEARBOX,
            "link": {"length": 0.5, **TUBE},
        },
        {
            "name": "elbow",
            "type": "revolute",
            "axis": "y",
            "limits": half,
            "gearbox": GEARBOX,
            "link": {"length": 0.4, **TUBE},
        },
        {
            "name": "wrist",
            "type": "revolute",
            "axis": "x",
            "limits": half,
            "gearbox": GEARBOX,
            "link": {"length": 0.1, "mass": 1.0},
        },
    ]


def plain() -> Arm:
    """Return the arm without branches."""
    return Arm(name="plain", joints=joints(), payload={"mass": 4.0})


def branched(mass: float) -> Arm:
    """Return the arm with a sliding finger listed first, and behind its elbow a turning
    counterweight of this mass (kg) on a rod of 0.3 m.
    """
    first, *others = joints()
    weight = {
        "tip": {"xyz": (-0.3, 0, 0)},
        "length_tolerance": 1e-3,
        "mass": mass,
        "centre_of_mass": (-0.3, 0, 0),
    }
    counterweight = {
        "name": "weight",
        "type": "revolute",
        "axis": "y",
        "limits": (-1, 1),
        "after": "elbow",
        "link": weight,
    }
    finger = {
        "name": "finger",
        "type": "prismatic",
        "axis": "y",
        "limits": (0, 0.05),
        "lumped": {"offset": 1e-4},
        "link": {"length": 0.1},
    }
    chain = [
        finger,
        {**first, "after": "base"},
        *others[:2],
        counterweight,
        {**others[2], "after": "elbow.tip"},
    ]
    return Arm(name="branched", joints=chain, payload={"mass": 4.0})


# Columns of the plain arm's joints in q of the branched one.
MAIN = [1, 2, 3, 5]


def poses(count: int = 30) -> np.ndarray:
    """Draw poses (pose, joint) of the branched arm."""
    low, high = branched(0.0).limits.T
    return np.random.default_rng(4).uniform(low, high, (count, 6))


def test_a_weightless_branch_changes_no_answer():
    """Drift, compliance, error, bending, holding torques and the place of the first axis are those
    of the arm without the branch.
    """
    one, other, q = plain(), branched(0.0), poses()
    same = q[:, MAIN]
    np.testing.assert_allclose(
        growth(other, q[0], WarmUp(25.0)),
        growth(one, same[0], WarmUp(25.0)),
        rtol=1e-12,
        atol=1e-18,
    )
    np.testing.assert_allclose(
        state_of(other, q).compliance, state_of(one, same).compliance, rtol=1e-9, atol=1e-18
    )
    assert rms_error(other, q) == pytest.approx(rms_error(one, same), rel=1e-12)
    assert full_turn_axis(other) == pytest.approx(full_turn_axis(one))
    np.testing.assert_allclose(_column(other), _column(one), atol=1e-15)
    for mine, theirs in zip(
        bending(other, q, np.zeros((30, 3)), 1.0),
        bending(one, same, np.zeros((30, 3)), 1.0),
        strict=True,
    ):
        assert mine.joint == theirs.joint
        assert mine.deflection == pytest.approx(theirs.deflection, rel=1e-9)
    of_main = [load for load in static_loads(other, q) if load.joint not in ("finger", "weight")]
    for mine, theirs in zip(of_main, static_loads(one, same), strict=True):
        assert mine.joint == theirs.joint
        assert mine.any_tilt.value == pytest.approx(theirs.any_tilt.value, rel=1e-9, abs=1e-9)
        assert mine.moment == pytest.approx(theirs.moment, rel=1e-9)


def test_a_counterweight_bends_the_link_that_carries_it_and_no_other():
    """A mass of 12 kg behind the elbow adds 117.68 N on the upper arm's tip, nothing on the
    forearm's, and takes its moment off the elbow's drive.
    """
    light, heavy, q = branched(0.0), branched(12.0), poses()
    q[:, 4] = 0.0  # straight back
    added = {
        name: (LinkLoads.of(heavy, k, q, None).nominal - LinkLoads.of(light, k, q, None).nominal)[
            :, 3:6
        ]
        for k, name in enumerate(joint.name for joint in heavy.joints)
    }
    for name, expected in (
        ("turret", 12 * 9.80665),
        ("shoulder", 12 * 9.80665),
        ("elbow", 0.0),
        ("wrist", 0.0),
        ("finger", 0.0),
        ("weight", 0.0),
    ):
        np.testing.assert_allclose(
            np.linalg.norm(added[name], axis=1), expected, atol=1e-11, err_msg=name
        )
    before, after = (
        {load.joint: abs(load.any_tilt.value) for load in static_loads(arm, q)}
        for arm in (light, heavy)
    )
    assert after["elbow"] == pytest.approx(abs(before["elbow"] - 12 * 9.80665 * 0.3))
    assert after["wrist"] == pytest.approx(before["wrist"])
