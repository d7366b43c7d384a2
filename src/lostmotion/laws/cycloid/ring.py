"""Profiles of cycloidal rings with integral lobes.

Source: F. Litvin, P. Feng, Mech. Mach. Theory 31 (1996) 891 (envelope with two branches).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from lostmotion.laws.cycloid.envelope import junction, ring_of_second_branch
from lostmotion.laws.cycloid.geometry import flank

if TYPE_CHECKING:
    from lostmotion.laws.cycloid.stage import Stage
    from lostmotion.spatial import Floats


def ring_root_radius(stage: Stage) -> float:
    """Return the root radius (m) of the ring: the largest distance from its centre that the moving
    disc reaches, R - Rr + 2 e.
    """
    return stage.ring_radius - stage.pin_radius + 2 * stage.eccentricity


def ring_pitch(stage: Stage, points: int = 401, clearance: float = 0.0) -> Floats:
    """Return one pitch of the ring's profile, from -pi/N to pi/N with the crest at angle 0: at
    least `points` points (point, 2), m.

    For "lobe envelope" it is the boundary of the area swept by the moving disc: the arc of the pin
    near the crest, then the branch cut by the tips of the disc. For "lobe arcs" (and "ring pins",
    as if integral with the ring) it consists of arcs of Rr down to a root circle, `clearance` (m)
    beyond the reach of the tips, with radial walls where the root is outside of the arc's centre.
    For "planet pins" the ring is the toothed wheel: one of the z pitches of its `flank`.
    """
    half = points // 2 + 1
    if stage.has_planet_pins:
        at = np.linspace(-math.pi, math.pi, 2 * half - 1) / stage.lobes
        return flank(stage, at)[0]
    side = (
        _envelope_side(stage, half)
        if stage.kind == "lobe envelope"
        else _arc_side(stage, half, ring_root_radius(stage) + clearance)
    )
    return np.concatenate([side[:0:-1] * [1, -1], side])


def repeat_pitch(pitch: Floats, times: int) -> Floats:
    """Return the closed outline (times x (n - 1), 2), m, of `times` copies of one pitch (n, 2),
    m.
    """
    one = pitch[:-1, 0] + 1j * pitch[:-1, 1]
    whole = (np.exp(2j * math.pi / times * np.arange(times))[:, None] * one).ravel()
    return np.stack([whole.real, whole.imag], axis=-1)


def _arc_side(stage: Stage, points: int, root: float) -> Floats:
    r, rr = stage.ring_radius, stage.pin_radius
    behind = math.sqrt(r**2 - rr**2)
    # The arc ends where it meets the root circle, or, with a deep root, where a ray from the centre
    # is tangent to it.
    meets = math.acos((r**2 + rr**2 - root**2) / (2 * r * rr) if root < behind else rr / r)
    turn = np.linspace(0, meets, points // 2)
    arc = np.stack([r - rr * np.cos(turn), rr * np.sin(turn)], axis=-1)
    start = math.atan2(arc[-1, 1], arc[-1, 0])
    at = np.linspace(start, math.pi / stage.pins, points - points // 2 + (root < behind))[
        int(root < behind) :
    ]
    return np.concatenate([arc, root * np.stack([np.cos(at), np.sin(at)], axis=-1)])


def _envelope_side(stage: Stage, points: int) -> Floats:
    t = junction(stage)
    cut = ring_of_second_branch(stage, np.linspace(t, math.pi / stage.lobes, points - points // 3))
    turn = np.linspace(0, math.atan2(cut[0, 1], stage.ring_radius - cut[0, 0]), points // 3 + 1)[
        :-1
    ]
    arc = np.stack(
        [stage.ring_radius - stage.pin_radius * np.cos(turn), stage.pin_radius * np.sin(turn)],
        axis=-1,
    )
    return np.concatenate([arc, cut])
