"""From a bearing's clearance as delivered, through its fits and its warmth, to the clearance with which it works.

Clearances are radial internal clearances in the standards' sense: the full free way across the bearing, on the diameter. Interference is on the
diameter too. Below zero a clearance is preload. Sources: ISO 5753-1 (clearance), ISO 286 (fits); shares and smoothing from bearing
makers' handbooks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

if TYPE_CHECKING:
    from lostmotion.spatial import Floats

Finish = Literal["ground", "turned"]
Limits = tuple[float, float]

# How much of a diameter the peaks of a finish take off in pressing on: d/(d + 2 mm) ground, d/(d + 3 mm) turned.
_PEAKS: Final[dict[Finish, float]] = {"ground": 2e-3, "turned": 3e-3}
# Of bearing steel and of most of what it sits on, 1/K.
STEEL_EXPANSION: Final = 12.5e-6
CUSTOMARY_SHARE: Final = 0.8


def interference(inside: Limits, outside: Limits) -> Limits:
    """Between which limits (m) lies the interference of a body with these deviations (m, lower and upper) in a bore with those?

    `inside` is the shaft's or the outer ring's deviations, `outside` the inner ring's or the housing's. Below zero they sit loose.
    """
    return inside[0] - outside[1], inside[1] - outside[0]


def effective_interference(measured: Floats | float, diameter: Floats | float, finish: Finish = "ground") -> Floats:
    """How much of a measured interference (m, any shape) is left once the peaks of the surfaces are pressed flat? None of a loose fit.

    `diameter` m, above zero, of the seat. measured x d/(d + 2 mm) for a ground seat, d/(d + 3 mm) for a turned one. For seats of some 10 to 500 mm.
    Raises ValueError for a diameter of zero or less, KeyError for another finish.
    """
    size = np.asarray(diameter, dtype=float)
    if (size <= 0).any():
        raise ValueError("a seat needs a diameter above zero")
    return np.asarray(np.maximum(measured, 0.0) * size / (size + _PEAKS[finish]))


def mounted_clearance(
    initial: Floats | float,
    inner: Floats | float,
    outer: Floats | float = 0.0,
    inner_share: float = CUSTOMARY_SHARE,
    outer_share: float = CUSTOMARY_SHARE,
) -> Floats:
    """What is left of a clearance (m) once the bearing sits on its shaft and in its housing? initial - f_i I_i - f_o I_o.

    `inner`, `outer`: effective interference of each ring (m, below zero counts as loose: none); shares 0.7-0.9, customary 0.8, or after Lamé for
    thick rings. All arrays of shapes that fit together. Raises ValueError for a share outside 0..1.
    """
    if not (0 <= inner_share <= 1 and 0 <= outer_share <= 1):
        raise ValueError("a share of the interference lies between 0 and 1")
    return np.asarray(initial - inner_share * np.maximum(inner, 0.0) - outer_share * np.maximum(outer, 0.0))


def raceway_diameter(bore: float, outside: float, kind: Literal["ball", "roller"]) -> float:
    """How large (m) is an outer raceway, to estimate how it grows with warmth? (4D + d)/5 of a ball bearing, (3D + d)/4 of a roller bearing.

    For bearings of the usual dimension series; a thin-section one has its own. Raises ValueError unless 0 < bore < outside.
    """
    if not 0 < bore < outside:
        raise ValueError("a bearing's bore is above zero and smaller than its outside")
    return (4 * outside + bore) / 5 if kind == "ball" else (3 * outside + bore) / 4


def thermal_loss(temperature_difference: Floats | float, raceway: float, expansion: float = STEEL_EXPANSION) -> Floats:
    """How much clearance (m) is lost where the inner ring is warmer than the outer one by so many kelvin (any shape)? expansion x dT x De.

    `raceway` De (m) of the outer ring. 5-10 K is normal, 15-20 K fast running; a robot's joint that moves at times stays near zero. Below zero
    the outer ring is the warmer and clearance grows.
    """
    return np.asarray(expansion * np.asarray(temperature_difference) * raceway)


def working_clearance(mounted: Floats | float, thermal: Floats | float = 0.0) -> Floats:
    """With which clearance (m) does a mounted bearing work when warm? Below zero: preload.

    Loads are not in it: they deform the contacts, which is `rolling`'s subject.
    """
    return np.asarray(np.asarray(mounted) - thermal)


@dataclass(frozen=True, slots=True)
class Spread:
    """A clearance over bearings built (m): its middle, the limits it never leaves, and the half width that parts at random keep."""

    middle: float
    lowest: float
    highest: float
    statistical: float


def clearance_spread(
    initial: Limits,
    inner: Limits,
    outer: Limits = (0.0, 0.0),
    thermal: Limits = (0.0, 0.0),
    inner_share: float = CUSTOMARY_SHARE,
    outer_share: float = CUSTOMARY_SHARE,
) -> Spread:
    """Between which limits (m) lies the working clearance of bearings whose clearance, fits and warmth lie between theirs?

    Effective interferences, thermal losses: lower and upper. `lowest` and `highest` are bounds; `statistical` is the root of the summed squares of
    the half widths, within which 99.7 % stay if each is normal with three sigma at its limits. Errors as `mounted_clearance`.
    """
    ends = []
    for clearance, shaft, housing, warm in zip(initial, inner[::-1], outer[::-1], thermal[::-1], strict=True):
        ends.append(float(working_clearance(mounted_clearance(clearance, shaft, housing, inner_share, outer_share), warm)))
    # What a loose fit is looser by changes nothing, so only the part above zero scatters.
    widths = [_width(initial), inner_share * _width(inner, tight=True), outer_share * _width(outer, tight=True), _width(thermal)]
    return Spread((ends[0] + ends[1]) / 2, ends[0], ends[1], float(np.sqrt(np.sum(np.square(widths))) / 2))


def _width(limits: Limits, *, tight: bool = False) -> float:
    low, high = (max(limit, 0.0) for limit in limits) if tight else limits
    return high - low
