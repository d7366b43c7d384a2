"""Springs and harmonics that are evaluated together have the bits of each by itself."""

from __future__ import annotations

import numpy as np
import pytest

from lostmotion.parts.forms import Curve, Harmonic, Spring
from lostmotion.parts.forms_together import kind, together
from lostmotion.parts.term import Condition

TURN, SLIDE = np.eye(6)[2], np.eye(6)[4]
LOADS = np.array([0.0, 0.5, 2.0, 7.0])
KNOTS = {"one": LOADS[:1], "several": LOADS, "from 0.5": LOADS[1:]}


def conditions(poses: int, seed: int = 3) -> Condition:
    """Return random values and loads of both signs: below, between, at and above all knots."""
    random = np.random.default_rng(seed)
    wrench = random.normal(0, 4, (6, poses))
    wrench[:, : len(LOADS)] = LOADS[: min(poses, len(LOADS))]
    return Condition(random.uniform(-3, 3, poses), wrench, np.zeros((3, poses)))


def curves(loads: np.ndarray, count: int = 5) -> list[Curve]:
    """Return random curves with these knots, the first of which ends level."""
    random = np.random.default_rng(len(loads))
    return [
        Curve(loads, np.cumsum(random.uniform(0, 1e-4, len(loads))), k * 1e-5) for k in range(count)
    ]


def each(forms: list, at: Condition, scales: np.ndarray) -> np.ndarray:
    """Return the screws (6, term, pose) of forms, each by itself."""
    out = np.empty((6, len(forms), len(at.angle)))
    for k, form in enumerate(forms):
        form.write(at, scales[k : k + 1], out[:, k : k + 1])
    return out


@pytest.mark.parametrize("poses", [1, 9])
@pytest.mark.parametrize("loads", KNOTS.values(), ids=KNOTS)
@pytest.mark.parametrize("direction", [TURN, SLIDE])
def test_forms_together_have_the_bits_of_each_by_itself(poses, loads, direction):
    """Springs, odd and even, and harmonics with and without envelopes, by both routes."""
    at, some = conditions(poses), curves(loads)
    families = [
        [Spring(direction, curve) for curve in some],
        [Spring(direction, curve, odd=False) for curve in some],
        [
            Harmonic(direction, 2.0 + k, ("sine", "cosine")[k % 2], envelope=curve)
            for k, curve in enumerate(some)
        ],
        [Harmonic(direction, 1.5 * k, ("cosine", "sine")[k % 2], turns=200.0) for k in range(3)],
    ]
    for forms in families:
        scales = np.linspace(0.5, 2, len(forms))
        found = np.empty((6, len(forms), poses))
        assert len({kind(form) for form in forms}) == 1
        together(forms).write(at, scales, found)
        np.testing.assert_array_equal(found, each(forms, at, scales))


def test_only_forms_of_one_motion_with_the_same_knots_are_evaluated_together():
    """Another direction, other knots, another lead or another parity is another kind; what follows
    the joint's value stays by itself.
    """
    one, other = curves(LOADS)[0], curves(LOADS[:2])[0]
    forms = [
        Spring(TURN, one),
        Spring(SLIDE, one),
        Spring(TURN, other),
        Spring(TURN, one, odd=False),
        Harmonic(TURN, 1.0, "sine"),
        Harmonic(TURN, 1.0, "sine", turns=3.0),
        Harmonic(TURN, 1.0, "sine", envelope=one),
        Harmonic(TURN, 1.0, "sine", envelope=other),
    ]
    assert len({kind(form) for form in forms}) == len(forms)
    assert kind(Spring(TURN, one, travel=one)) is None
