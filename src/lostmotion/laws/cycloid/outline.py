"""Closed outlines of the wheels of a cycloidal stage for drawings, with a bound on their distance
from the true profile.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid.geometry import flank
from lostmotion.laws.cycloid.ring import repeat_pitch, ring_pitch

if TYPE_CHECKING:
    from collections.abc import Callable

    from lostmotion.laws.cycloid.stage import Modification, Stage
    from lostmotion.spatial import Floats

# Number of points of half a pitch at which the true profile is evaluated; doubled until their
# chords are within a tenth of the tolerance.
_POINTS: Final = 257
_MOST_POINTS: Final = 10_000


@dataclass(frozen=True, slots=True)
class DiscOutline:
    """A closed polygon.

    points       (point, 2) corners on the true profile, m, from the wheel's own centre
    chord_error  largest distance of the polygon from the true profile, m
    """

    points: Floats
    chord_error: float


def wheel_outline(stage: Stage, relief: Modification, tolerance: float) -> DiscOutline:
    """Return the outline of the toothed wheel (the disc; with planet pins the ring) with its
    modification; a valley is at angle 0.

    tolerance: largest distance from the true profile, m. Raises ValueError for turned flanks, whose
    two halves do not meet, and for a tolerance that cannot be met.
    """
    if relief.turn:
        raise ValueError("turned flanks leave a step in the valley and have no closed outline")

    def pitch(points: int) -> Floats:
        return flank(stage, np.linspace(-math.pi, math.pi, points) / stage.lobes, relief)[0]

    return _refined(pitch, stage.lobes, tolerance)


def ring_outline(stage: Stage, tolerance: float) -> DiscOutline:
    """Return the outline of a ring with integral lobes, "lobe arcs" or "lobe envelope"; a crest is
    at angle 0.

    tolerance: largest distance from the true profile, m. Raises ValueError for stages with pins,
    whose ring or planet consists of circles, and for a tolerance that cannot be met.
    """
    if stage.kind not in {"lobe arcs", "lobe envelope"}:
        raise ValueError(f"a stage with {stage.kind} has no ring with lobes")
    return _refined(lambda points: ring_pitch(stage, points), stage.pins, tolerance)


def chord_error(polygon: Floats, true: Floats) -> float:
    """Return the largest distance (m) of points (m, 2) of a curve from an open polygon (n, 2), by
    the two chords at the nearest corner of each.
    """
    from scipy.spatial import KDTree

    near = KDTree(polygon).query(true)[1]
    ends = len(polygon) - 2
    sides = [
        _off(true, polygon[first], polygon[first + 1])
        for first in (np.clip(near - 1, 0, ends), np.clip(near, 0, ends))
    ]
    return float(np.minimum(*sides).max())


def _off(points: Floats, start: Floats, end: Floats) -> Floats:
    """Return the distance (m) of points (m, 2) from straight lines between two ends, (2,) or (m,
    2).
    """
    away, way = points - start, end - start
    square = np.maximum((way**2).sum(axis=-1), np.finfo(float).tiny)
    share = np.clip((away * way).sum(axis=-1) / square, 0.0, 1.0)
    return np.asarray(np.linalg.norm(away - share[..., None] * way, axis=-1))


def _refined(pitch: Callable[[int], Floats], times: int, tolerance: float) -> DiscOutline:
    """Return an outline with as few points as the tolerance (m) allows. Raises ValueError where the
    tolerance cannot be met.
    """
    points = _POINTS
    while points < _MOST_POINTS:
        half, finer = (_half(pitch(2 * count + 1)) for count in (points, 2 * points))
        # the most distant point of an arc may be between those evaluated
        own = 2 * chord_error(half, finer)
        if own <= 0.1 * tolerance:
            chosen, error = _simplified(half, 0.9 * tolerance)
            kept = half[chosen]
            return DiscOutline(
                repeat_pitch(np.concatenate([kept[:0:-1] * [1, -1], kept]), times), error + own
            )
        points *= 2
    raise ValueError(f"no outline has all its chords within {tolerance:g} m of the true profile")


def _half(pitch: Floats) -> Floats:
    """Return the second half of a pitch; the first half is its mirror image."""
    return pitch[len(pitch) // 2 :]


def _simplified(line: Floats, tolerance: float) -> tuple[list[int], float]:
    """Return the indices, in order, of the points that a simplified line within the tolerance (m)
    needs, and the largest distance (m) of the others.

    Source: D. Douglas, T. Peucker, Cartographica 10 (1973) 112.
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
