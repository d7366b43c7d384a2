"""Random closed chains: a wrench on the tool loads every place by the transpose of how an error
there moves the exact position of the tool (virtual work; Maxwell and Betti where springs share a
load).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest

from lostmotion.mechanism.tool import Payload
from tests.mechanism.closed_chains import arm, at, link, xyz

if TYPE_CHECKING:
    from lostmotion.mechanism.state import State

# Errors from which differences of positions are formed, rad and m.
STEP = 1e-5
# Chains of these seeds are away from parallel singularities, where differences say little.
SEEDS = (1, 4)
VALIDATES = (
    (
        (
            "carry matrices of random closed chains: planar loops with elastic links, "
            "over-constrained three times, and platforms on six legs"
        ),
        (
            "wrenches by statics, and differences of exact positions with small errors: Newton's "
            "method on the closures"
        ),
        "1e-8",
        "mechanism/closed_statics.py",
    ),
)


def loop(rng: np.random.Generator):
    """Return a four-bar with a random geometry, elastic links and a tool beside its coupler."""
    angles = rng.uniform((0.8, -1.4), (1.2, -0.8))
    crank, coupler = rng.uniform((0.2, 0.4), (0.3, 0.6))
    corner = crank * np.exp(1j * angles[0]) + coupler * np.exp(1j * angles.sum())
    foot = rng.uniform(0.6, 0.8) + 0.1j * rng.uniform(-1, 1)
    rocker = corner - foot
    more = {
        "section": {"kind": "box", "width": "40 mm", "height": "30 mm", "wall": "3 mm"},
        "material": "aluminium",
    }
    turning = {"type": "revolute", "passive": True}
    return arm(
        joints=[
            {"name": "crank", "type": "revolute", "limits": ["0 rad", "3 rad"]}
            | {"start": f"{angles[0]} rad", "link": link(crank, **more)},
            {"name": "coupler", **turning, "start": f"{angles[1]} rad"}
            | {"link": link(coupler, **more)},
            {"name": "rocker", **turning, "after": "base", "origin": xyz(foot.real, foot.imag, 0)}
            | {"start": f"{np.angle(rocker)} rad", "link": link(abs(rocker), **more)},
            {"name": "pin", **turning, "start": f"{angles.sum() - np.angle(rocker)} rad"},
        ],
        closures=[{"joins": ["coupler.tip", "pin.tip"]}],
        tool={"after": "coupler.tip", "frame": xyz(*rng.uniform(-0.1, 0.1, 3))},
    )


def platform(rng: np.random.Generator):
    """Return a platform on six sliding legs with random joint centres."""
    copies = []
    for k in range(6):
        ends = []
        for radius, spread in ((0.4, 15), (0.25, 45)):
            angle = math.radians(120 * (k // 2) + (spread if k % 2 else -spread))
            centre = radius * np.array([math.cos(angle), math.sin(angle), 0.0])
            ends.append(xyz(*(centre + rng.uniform(-0.03, 0.03, 3))))
        copies.append({"name": str(k + 1), "place": ends[0], "end": ends[1]})
    slide = {"type": "prismatic", "limits": ["0.4 m", "0.7 m"], "start": "0.53 m"}
    return arm(
        joints=[{"name": "platform", "type": "free", "start": xyz(0, 0, 0.5)}],
        legs=[
            {
                "joins": "platform.tip",
                "copies": copies,
                "joints": [
                    {"name": "base", "type": "universal", "axes": ["x", "y"]},
                    {"name": "leg", **slide},
                    {"name": "ball", "type": "spherical"},
                ],
            }
        ],
        tool={"after": "platform.tip", "frame": xyz(*rng.uniform(-0.1, 0.1, 3))},
    )


def differences(state: State, place: int) -> np.ndarray:
    """Return the twist of the tool (6, 6) per twist at a place: central differences of the exact
    position, solved from the closures.
    """
    steps = np.concatenate([np.eye(6), -np.eye(6)]) * STEP
    ends = state.composed([place], steps[None, None])[0].reshape(2, 6, 4, 4)
    turned = ends[0, :, :3, :3] @ ends[1, :, :3, :3].transpose(0, 2, 1)
    turned = (turned - turned.transpose(0, 2, 1)) / (4 * STEP)
    rotation = np.stack([turned[:, 2, 1], turned[:, 0, 2], turned[:, 1, 0]])
    return np.concatenate([rotation, (ends[0] - ends[1])[:, :3, 3].T / (2 * STEP)])


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("make", [loop, platform])
def test_the_wrench_on_a_place_is_the_transpose_of_how_an_error_there_moves_the_tool(
    make, seed: int
):
    """A force and a moment on the tool of a random closed chain load each place by the transpose of
    how the exact position of the tool differs with small errors there, as do carry matrices.
    """
    rng = np.random.default_rng(seed)
    chain = make(rng)
    force, moment = rng.uniform(-1, 1, (2, 3))
    loads = Payload(force=tuple(force), moment=tuple(moment))
    state = at(chain.with_payload(loads), chain.home, gravity=np.zeros(3))
    turned = state.frames[-1, 0, :3, :3]
    wrench = np.concatenate([turned @ moment, turned @ force])
    size = np.abs(state.wrenches).max()
    for place in range(1, len(chain.places)):
        moved = differences(state, place)
        np.testing.assert_allclose(state.carry(place)[0], moved, atol=1e-8, rtol=0)
        np.testing.assert_allclose(
            state.wrenches[place, 0], moved.T @ wrench, atol=1e-8 * size, rtol=0
        )
