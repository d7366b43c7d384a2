"""Distance between a flank of the disc and an envelope ring, for the flanks that a load can bring
into contact.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from lostmotion.laws.cycloid.envelope import ring_of_second_branch
from lostmotion.laws.cycloid.geometry import arms, flank, gaps

if TYPE_CHECKING:
    from scipy.spatial import KDTree

    from lostmotion.laws.cycloid.stage import Modification, Stage
    from lostmotion.spatial import Floats

# Coarse steps, in elements, of the search for the parts of a flank that can touch.
_COARSE: Final = 16
_RING_POINTS: Final = 8001
_FLANK_POINTS: Final = 4001
# Share of the longest arm below which a contact on the line of centres only rounds to one that
# drives.
_SHORT: Final = 1e-6
# Elements that touch at this share of the largest wind-up are those of the first estimate.
_EARLY: Final = 0.4


@dataclass(slots=True)
class FlankDistance:
    """The part of one lobe's flank that can touch: influence (m/Pa), arms (m), gaps (m), elements
    in contact, their pressure (Pa), number, theta.
    """

    influence: Floats
    arm: Floats
    gap: Floats
    touching: np.ndarray
    pressure: Floats
    place: np.ndarray
    theta: Floats


def candidates(  # noqa: PLR0913 - stage, contact, elements
    stage: Stage,
    modulus: float,
    crank: float,
    relief: Modification,
    depth: float,
    size: float,
    bound: float,
    *,
    lobe: int | None = None,
) -> list[FlankDistance]:
    """Return the parts of all flanks, or of one lobe's, that a rotation of `bound` (rad) can bring
    into contact, in elements of `size` (m).
    """
    z = stage.lobes
    fine, length = _along(stage)
    count = math.ceil(length[-1] / size)
    at = np.interp((np.arange(count) + 0.5) * size, length, fine)
    place = flank(stage, at)[0] @ np.array([1, 1j])
    arm = arms(stage, -z * at)
    relieved = gaps(stage, -z * at, relief)
    coarse = np.unique(np.append(np.arange(0, count, _COARSE), count - 1))
    turns = np.exp(
        2j * math.pi * (np.arange(z) if lobe is None else np.array([lobe])) / z - 1j * crank / z
    )[:, None]
    centre = stage.eccentricity * np.exp(1j * crank)
    limit = 2 * arm[coarse] * bound + (_COARSE * size) ** 2 / stage.pin_radius
    within = float(limit.max() - min(relieved.min(), 0.0))
    near = _distance(stage, centre + turns * place[coarse], within) + relieved[coarse] < limit
    parts = []
    for turn, chosen in zip(turns, near, strict=True):
        wanted = np.zeros(count + _COARSE, dtype=bool)
        for shift in range(-_COARSE, _COARSE + 1):
            wanted[np.clip(coarse[chosen] + shift, 0, count - 1)] = True
        k = np.flatnonzero(wanted[:count])
        if not len(k):
            continue
        gap = _distance(stage, centre + turn * place[k], within) + relieved[k]
        can = (gap < arm[k] * bound) & (arm[k] > _SHORT * stage.planet_pitch_radius)
        k, gap = k[can], gap[can]
        if not len(k):
            continue
        table = (
            2
            / (math.pi * modulus)
            * np.diff(_integral((np.arange(k[-1] - k[0] + 2) - 0.5) * size, depth))
        )
        parts.append(
            FlankDistance(
                table[np.abs(k[:, None] - k)], arm[k], gap, k >= 0, np.zeros(len(k)), k, -z * at[k]
            )
        )
    first = min(float((each.gap / each.arm).min()) for each in parts)
    for each in parts:
        each.touching = each.gap < each.arm * (first + _EARLY * (bound - first))
    return parts


@functools.lru_cache(maxsize=8)
def _along(stage: Stage) -> tuple[Floats, Floats]:
    """Return parameters t (rad) of a flank with positive arms, theta = -z t, and the length (m)
    along it from its tip.
    """
    fine = np.linspace(-math.pi / stage.lobes, 0.0, _FLANK_POINTS)
    return fine, np.concatenate(
        [[0.0], np.cumsum(np.linalg.norm(np.diff(flank(stage, fine)[0], axis=0), axis=1))]
    )


def _integral(distance: Floats, depth: float) -> Floats:
    """Return the integral of ln(depth/s), zero beyond the depth, from zero to a distance (m) of
    either sign.
    """
    size = np.clip(np.abs(distance), np.finfo(float).tiny, depth)
    return np.asarray(np.sign(distance) * size * (np.log(depth / size) + 1))


def _distance(stage: Stage, place: np.ndarray, within: float) -> Floats:
    """Return the distance (m) of places (complex, m) from the envelope ring; infinite where the
    second branch is not `within` reach (m).
    """
    n = stage.pins
    turned = (
        place * np.exp(-2j * math.pi / n * np.round(np.angle(place) * n / (2 * math.pi)))
    ).ravel()
    turned = turned.real + 1j * np.abs(turned.imag)
    tree, points, tangents, bends = _ring(stage)
    step = float(np.abs(np.diff(points)).max())
    away, nearest = tree.query(
        np.stack([turned.real, turned.imag], axis=-1), distance_upper_bound=within + step
    )
    known = np.minimum(nearest, len(points) - 1)
    beside = (turned - points[known]) * tangents[known].conj()
    of_cut = np.where(
        np.isfinite(away), np.abs(beside.imag - bends[known] * beside.real**2 / 2), np.inf
    )
    from_pin = turned - stage.ring_radius
    on_arc = np.angle(-from_pin.conj()) < np.angle(-(points[0] - stage.ring_radius).conj())
    return np.where(on_arc, np.abs(from_pin) - stage.pin_radius, of_cut).reshape(place.shape)


@functools.lru_cache(maxsize=8)
def _ring(stage: Stage) -> tuple[KDTree, np.ndarray, np.ndarray, Floats]:
    """Return half a pitch of the ring's second branch, slightly beyond its root: search tree,
    points and tangents (complex, m), curvature (1/m).
    """
    from scipy.spatial import KDTree

    start = math.acos(stage.shortening) / stage.lobes
    points = ring_of_second_branch(
        stage, np.linspace(start, 1.02 * math.pi / stage.lobes, _RING_POINTS)
    ) @ np.array([1, 1j])
    along = np.gradient(points)
    bends = np.gradient(np.unwrap(np.angle(along))) / np.abs(along)
    return (
        KDTree(np.stack([points.real, points.imag], axis=-1)),
        points,
        along / np.abs(along),
        bends,
    )
