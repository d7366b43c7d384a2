"""Exact composition of errors, beside the first-order sum."""

from __future__ import annotations

import math

import numpy as np
import pytest

from lostmotion import Arm, screws
from lostmotion.propagation.exact import ExactCheck, check, share_neglected

RADIUS = 0.5


def chain(count: int, backlash: float) -> Arm:
    """Return an arm whose parallel joints, with this backlash in rad, turn about the vertical, so that no load holds them in it."""
    joint = {"type": "revolute", "axis": "z", "limits": (-1, 1), "gearbox": {"backlash": backlash}, "link": {"length": RADIUS}}
    return Arm.model_validate({"name": "chain", "joints": [{**joint, "name": name} for name in "AB"[:count]]})


@pytest.mark.parametrize("angle", [1e-3, 0.05, 0.5])
def test_first_order_follows_the_tangent_where_the_tool_follows_its_arc(angle):
    """A joint that ends its visits half its backlash to either side: the sum neglects the distance from the arc to as long a tangent."""
    found = check(screws(chain(1, 2 * angle), np.array([[0.3]])), 0, np.arange(1), 1, 4, 5)
    neglected = RADIUS * math.hypot(angle - math.sin(angle), 1 - math.cos(angle))
    assert (found.samples, found.turn, found.length) == (20, pytest.approx(angle), pytest.approx(RADIUS * angle))
    assert (found.largest, found.mean) == pytest.approx((neglected, neglected), rel=1e-9)


def test_turns_about_parallel_axes_add_up():
    """Two parallel joints with backlash of 30 degrees to either side: the tool turns by up to 60 degrees."""
    found = check(screws(chain(2, math.radians(60)), np.array([[0.3, -0.4]])), 0, np.arange(1), 1, 20, 20)
    assert math.degrees(found.turn) == pytest.approx(60)


def test_what_first_order_neglects_is_a_share_of_the_error():
    """A hundredth, a fifth; nothing of an error that is not there or below a nanometre; no share of an error that is no finite number."""
    assert [share_neglected(ExactCheck(largest, largest, 10), 1e-3) for largest in (1e-5, 2e-4)] == pytest.approx([0.01, 0.2])
    assert share_neglected(ExactCheck(0.0, 0.0, 10), 0.0) == 0
    assert share_neglected(ExactCheck(5e-10, 5e-10, 10), 1e-9) == 0
    assert share_neglected(ExactCheck(1e-3, 1e-3, 10), 0.0) == math.inf
    assert share_neglected(ExactCheck(1e-3, 1e-3, 10), math.inf) == math.inf
    assert share_neglected(ExactCheck(math.inf, 1e-3, 10), 1e-3) == math.inf
