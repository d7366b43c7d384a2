"""Exact composition of errors, compared with the first-order sum."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lostmotion import Arm, screws
from lostmotion.mechanism.state import state_of
from lostmotion.propagation.exact import ExactCheck, check, share_neglected

# A row of docs/validation.md each: quantity, compared with, agreement, other files.
VALIDATES = (
    (
        "share that first order neglects",
        "arc against tangent of a joint in its backlash",
        "1e-9",
        "propagation/exact.py",
    ),
)

RADIUS = 0.5


def chain(count: int, backlash: float) -> Arm:
    """Return an arm of parallel vertical joints with this backlash in rad, which no load closes."""
    joint = {
        "type": "revolute",
        "axis": "z",
        "limits": (-1, 1),
        "gearbox": {"backlash": backlash},
        "link": {"length": RADIUS},
    }
    return Arm.model_validate(
        {"name": "chain", "joints": [{**joint, "name": name} for name in "AB"[:count]]}
    )


@pytest.mark.parametrize("angle", [1e-3, 0.05, 0.5])
def test_first_order_replaces_the_arc_of_the_tool_by_its_tangent(angle):
    """The first-order sum of a joint at the end of its backlash neglects the distance from the arc
    to a tangent of equal length.
    """
    found = check(
        screws(state_of(chain(1, 2 * angle), np.array([[0.3]]))), 0, np.arange(1), 1, 4, 5
    )
    neglected = RADIUS * math.hypot(angle - math.sin(angle), 1 - math.cos(angle))
    assert (found.samples, found.turn, found.length) == (
        20,
        pytest.approx(angle),
        pytest.approx(RADIUS * angle),
    )
    assert (found.largest, found.mean) == pytest.approx((neglected, neglected), rel=1e-9)


def test_turns_about_parallel_axes_add_up():
    """The tool on two parallel joints with a backlash of ±30 degrees each turns by up to 60
    degrees.
    """
    found = check(
        screws(state_of(chain(2, math.radians(60)), np.array([[0.3, -0.4]]))),
        0,
        np.arange(1),
        1,
        20,
        20,
    )
    assert math.degrees(found.turn) == pytest.approx(60)


def test_the_neglected_share_is_relative_to_the_error():
    """The neglected share is the difference divided by the error: zero below a nanometre, and
    infinite for an error that is zero or not finite.
    """
    assert [
        share_neglected(ExactCheck(largest, largest, 10), 1e-3) for largest in (1e-5, 2e-4)
    ] == pytest.approx([0.01, 0.2])
    assert share_neglected(ExactCheck(0.0, 0.0, 10), 0.0) == 0
    assert share_neglected(ExactCheck(5e-10, 5e-10, 10), 1e-9) == 0
    assert share_neglected(ExactCheck(1e-3, 1e-3, 10), 0.0) == math.inf
    assert share_neglected(ExactCheck(1e-3, 1e-3, 10), math.inf) == math.inf
    assert share_neglected(ExactCheck(math.inf, 1e-3, 10), 1e-3) == math.inf
