"""Closed outlines of the wheels of a cycloidal stage for drawings, with a bound on the distance of the chords from the true profile."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid.geometry import flank
from lostmotion.laws.cycloid.ring import repeat_pitch, ring_pitch

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.laws.cycloid.geometry import Modification, Stage
    from lostmotion.spatial import Floats

# Points of half a pitch at which the true profile is evaluated; doubled until their own chords are within a tenth of the tolerance.
_LOOKED: Final = 257
_MOST: Final = 10_000


@dataclass(frozen=True, slots=True)
class Outline:
    """A closed polygon (point, 2), m, about the wheel's own centre, corners on the true profile; `chord_error` m, its largest distance from it."""

    points: Floats
    chord_error: float


def wheel_outline(stage: Stage, relief: Modification, tolerance: float) -> Outline:
    """Return the outline of the toothed wheel (the disc; with planet pins the ring) with its modification. A valley is at angle 0; `tolerance` m.

    Raises ValueError for turned flanks: their two halves do not meet.
    """
    if relief.turn:
        raise ValueError("turned flanks leave a step in the valley and have no closed outline")

    def pitch(points: int) -> Floats:
        return flank(stage, np.linspace(-math.pi, math.pi, points) / stage.lobes, relief)[0]

    return _refined(pitch, stage.lobes, tolerance)


def ring_outline(stage: Stage, tolerance: float) -> Outline:
    """Return the outline of a ring with integral lobes, "lobe arcs" or "lobe envelope". A crest is at angle 0; `tolerance` m.

    Raises ValueError for stages with pins, whose ring or planet consists of circles.
    """
    if stage.kind not in {"lobe arcs", "lobe envelope"}:
        raise ValueError(f"a stage with {stage.kind} has no ring with lobes")
    return _refined(lambda points: ring_pitch(stage, points), stage.pins, tolerance)


def chord_error(polygon: Floats, true: Floats) -> float:
    """Return the largest distance (m) of points (m, 2) of the true curve from an open polygon (n, 2), by the two chords at each nearest corner."""
    from scipy.spatial import KDTree

    near = KDTree(polygon).query(true)[1]
    ends = len(polygon) - 2
    sides = [_off(true, polygon[first], polygon[first + 1]) for first in (np.clip(near - 1, 0, ends), np.clip(near, 0, ends))]
    return float(np.minimum(*sides).max())


def _off(points: Floats, start: Floats, end: Floats) -> Floats:
    """Return the distance (m) of points (m, 2) from straight lines between two ends, (2,) or (m, 2)."""
    away, way = points - start, end - start
    square = np.maximum((way**2).sum(axis=-1), np.finfo(float).tiny)
    share = np.clip((away * way).sum(axis=-1) / square, 0.0, 1.0)
    return np.asarray(np.linalg.norm(away - share[..., None] * way, axis=-1))


def _refined(pitch: Callable[[int], Floats], times: int, tolerance: float) -> Outline:
    """Return an outline with as few points as the tolerance allows; raises ValueError where the tolerance cannot be met."""
    points = _LOOKED
    while points < _MOST:
        half, finer = (_half(pitch(2 * count + 1)) for count in (points, 2 * points))
        own = 2 * chord_error(half, finer)  # the farthest point of an arc may lie between those evaluated
        if own <= 0.1 * tolerance:
            chosen, error = _kept(half, 0.9 * tolerance)
            kept = half[chosen]
            return Outline(repeat_pitch(np.concatenate([kept[:0:-1] * [1, -1], kept]), times), error + own)
        points *= 2
    raise ValueError(f"chords of an outline cannot be kept within {tolerance:g} m of it")


def _half(pitch: Floats) -> Floats:
    """Return the half of a pitch from its middle on; the other half mirrors it."""
    return pitch[len(pitch) // 2 :]


def _kept(line: Floats, tolerance: float) -> tuple[list[int], float]:
    """Return the points of a line, in order, that a coarser line needs to stay within the tolerance, and the largest distance of the others.

    D. Douglas, T. Peucker, Cartographica 10 (1973) 112.
    """
    kept, worst = [0, len(line) - 1], 0.0
    spans = [(0, len(line) - 1)]
    while spans:
        first, last = spans.pop()
        if last - first < 2:  # noqa: PLR2004 - no point between neighbours
            continue
        off = _off(line[first + 1 : last], line[first], line[last])
        if off.max() > tolerance:
            at = first + 1 + int(off.argmax())
            kept.append(at)
            spans += [(first, at), (at, last)]
        else:
            worst = max(worst, float(off.max()))
    return sorted(kept), worst
